//! Rays against primitives, one by one and through the tree.

mod common;

use common::{Random, direction, nothing};
use glam::{DAffine3, DMat3, DVec3, UVec4, Vec3, Vec3A, Vec4};
use kinora_kernel::generated::{FAR, Hit, NONE, PLANE_BIT, PRIMITIVE_SPHERE};
use kinora_kernel::query::{bvh_any, bvh_closest};
use kinora_kernel::{Kernel, Packed, Shape, Triangle};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::builder::build_cwbvh;
use obvhs::{Boundable, BvhBuildParams};

/// A scene under construction.
#[derive(Default)]
struct Builder {
    triangles: Vec<Triangle>,
    boxes: Vec<Bounds>,
    shapes: Vec<Shape>,
}

#[derive(Clone, Copy)]
struct Bounds(Aabb);

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        self.0
    }
}

impl Builder {
    fn triangle(&mut self, [a, b, c]: [Vec3; 3]) {
        self.boxes.push(Bounds(Aabb { min: a.min(b).min(c).into(), max: a.max(b).max(c).into() }));
        self.triangles.push(Triangle {
            x: Vec4::new(a.x, b.x, c.x, self.triangles.len() as f32),
            y: Vec4::new(a.y, b.y, c.y, 0.0),
            z: Vec4::new(a.z, b.z, c.z, 0.0),
            shade: UVec4::ZERO,
        });
    }

    fn mesh(&mut self, corners: &[Vec3], triangles: &[[usize; 3]]) {
        for t in triangles {
            self.triangle(t.map(|i| corners[i]));
        }
    }

    /// The unit sphere, placed.
    fn sphere(&mut self, place: DAffine3) {
        let rows = place.matrix3.transpose();
        let half = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let (low, high) = (place.translation - half, place.translation + half);
        self.boxes.push(Bounds(Aabb { min: low.as_vec3a(), max: high.as_vec3a() }));
        self.triangles.push(Triangle {
            x: Vec4::new(0.0, 0.0, 0.0, self.triangles.len() as f32),
            z: Vec4::new(0.0, 0.0, 0.0, PRIMITIVE_SPHERE),
            shade: UVec4::new(0, 0, 0, self.shapes.len() as u32),
            ..Triangle::default()
        });
        self.shapes.push(placed(place));
    }

    /// As the renderer does: boxes padded, then primitives in the order of the leaves.
    fn build(mut self) -> Packed {
        let reach = self.boxes.iter().fold(0.0_f32, |reach, b| {
            reach.max(b.0.min.abs().max_element()).max(b.0.max.abs().max_element())
        });
        let pad = Vec3A::splat((reach * 4.0 * f32::EPSILON).max(f32::MIN_POSITIVE));
        for b in &mut self.boxes {
            b.0.min -= pad;
            b.0.max += pad;
        }
        let bvh = build_cwbvh(&self.boxes, BvhBuildParams::fast_build(), &mut std::time::Duration::default());
        let triangles: Vec<_> = bvh.primitive_indices.iter().map(|&i| self.triangles[i as usize]).collect();
        let mut packed = nothing();
        packed.params.primitive_count = triangles.len() as u32;
        packed.triangles = triangles;
        packed.bvh = bvh;
        if !self.shapes.is_empty() {
            packed.shapes = self.shapes;
        }
        packed.check_depth().expect("a deep tree");
        packed
    }
}

fn placed(place: DAffine3) -> Shape {
    let row = |m: &DAffine3, i: usize| m.matrix3.row(i).extend(m.translation[i]).as_vec4();
    let inverse = place.inverse();
    Shape {
        world_from_object_x: row(&place, 0),
        world_from_object_y: row(&place, 1),
        world_from_object_z: row(&place, 2),
        object_from_world_x: row(&inverse, 0),
        object_from_world_y: row(&inverse, 1),
        object_from_world_z: row(&inverse, 2),
        ..Shape::default()
    }
}

fn ball(centre: DVec3, radius: f64) -> DAffine3 {
    DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(radius))
}

fn by_brute_force(k: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> Hit {
    let mut best = Hit { t: t_max, id: NONE, ..Hit::default() };
    for id in 0..k.params.primitive_count {
        let hit = k.hit_primitive(id, o, d, best.t, start);
        if hit.id != NONE {
            best = hit;
        }
    }
    if best.id == NONE {
        best.t = FAR;
    }
    best
}

fn cube() -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let corners = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (corners, quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect())
}

fn icosphere(levels: u32) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    // An octahedron will do.
    let mut corners = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::HashMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(i, j)| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    corners.push((corners[i] + corners[j]).normalize());
                    corners.len() - 1
                })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (corners, triangles)
}

/// A box whose faces are fans of needles.
fn needles() -> (Vec<Vec3>, Vec<[usize; 3]>) {
    const SPOKES: usize = 400;
    let mut corners = vec![Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 0.0, -0.5)];
    corners.extend((0..SPOKES).map(|i| {
        let turn = i as f64 / SPOKES as f64;
        direction(0.0, std::f64::consts::TAU * turn * turn) * 300.0
    }));
    let rim = |i: usize| 2 + i % SPOKES;
    let triangles = (0..SPOKES).flat_map(|i| [[0, rim(i), rim(i + 1)], [1, rim(i + 1), rim(i)]]).collect();
    (corners, triangles)
}

/// Directions from `o` that are awkward: to corners, to points of edges, and along axes.
fn awkward(corners: &[Vec3], triangles: &[[usize; 3]], o: Vec3, random: &mut Random) -> Vec<Vec3> {
    let mut all = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    all.extend(corners.iter().map(|c| (c - o).normalize()));
    for t in triangles {
        for i in 0..3 {
            let (a, b) = (corners[t[i]], corners[t[(i + 1) % 3]]);
            all.push(((a + b) * 0.5 - o).normalize());
            all.push((a + (b - a) * random.unit() - o).normalize());
        }
    }
    all
}

#[track_caller]
fn check_watertight(name: &str, corners: &[Vec3], triangles: &[[usize; 3]], inside: f32, rays: usize) {
    let mut builder = Builder::default();
    builder.mesh(corners, triangles);
    let packed = builder.build();
    let mut random = Random(1);
    // Every ray by the tree, as many as there is time for by brute force.
    let exhaustive = 8_000_000 / triangles.len();
    packed.with_kernel(|k| {
        let mut done = 0;
        while done < rays {
            let o = if done == 0 { Vec3::ZERO } else { random.cube(inside) };
            let mut directions = awkward(corners, triangles, o, &mut random);
            directions.extend((0..20_000).map(|_| random.direction()));
            for d in directions {
                let hit = bvh_closest(k, o, d, FAR, NONE);
                if hit.id == NONE {
                    let brute = by_brute_force(k, o, d, FAR, NONE);
                    panic!("{name}: ray {o:?} {d:?} leaks after {done} rays; by brute force it meets {brute:?}");
                }
                assert!(bvh_any(k, o, d, FAR, NONE), "{name}: no hit at all of {o:?} {d:?}");
                if done < exhaustive {
                    let brute = by_brute_force(k, o, d, FAR, NONE);
                    assert_eq!(hit.t, brute.t, "{name}: {o:?} {d:?}");
                }
                done += 1;
            }
        }
    });
}

#[test]
fn a_cube_is_watertight() {
    let (corners, triangles) = cube();
    check_watertight("cube", &corners, &triangles, 0.99, 1_000_000);
}

#[test]
fn a_cube_far_away_is_watertight() {
    let (corners, triangles) = cube();
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, 2.5);
    let corners: Vec<_> = corners.iter().map(|c| (turn * c.as_dvec3() * 37.0).as_vec3()).collect();
    check_watertight("turned cube", &corners, &triangles, 20.0, 300_000);
}

#[test]
fn a_ball_of_triangles_is_watertight() {
    let (corners, triangles) = icosphere(4);
    check_watertight("ball", &corners, &triangles, 0.5, 1_000_000);
}

#[test]
fn thin_triangles_are_watertight() {
    let (corners, triangles) = needles();
    check_watertight("needles", &corners, &triangles, 0.1, 500_000);
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let mut random = Random(2);
    for (scene, size) in [(0, 1.0_f32), (1, 100.0), (2, 1e-2)] {
        let mut builder = Builder::default();
        for i in 0..300 {
            let a = random.cube(size);
            let reach = size * if i % 10 == 0 { 1.0 } else { 0.1 };
            builder.triangle([a, a + random.cube(reach), a + random.cube(reach)]);
            if i % 6 == 0 {
                let scale = DVec3::new(0.02, 0.05, 0.1) * f64::from(size);
                let turn = DMat3::from_axis_angle(random.direction().as_dvec3().normalize(), 1.0);
                let centre = random.cube(size).as_dvec3();
                builder.sphere(DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), centre));
            }
        }
        let packed = builder.build();
        packed.with_kernel(|k| {
            let mut hits = 0;
            for i in 0..20_000 {
                let o = random.cube(2.0 * size);
                let d = if i % 7 == 0 { [Vec3::X, -Vec3::Y, Vec3::Z][i % 3] } else { random.direction() };
                let t_max = if i % 2 == 0 { FAR } else { random.within(0.0, 2.0 * size) };
                let start = if i % 3 == 0 { (random.bits() % 300) as u32 } else { NONE };
                let (tree, brute) = (bvh_closest(k, o, d, t_max, start), by_brute_force(k, o, d, t_max, start));
                assert_eq!(tree.t, brute.t, "scene {scene}: {o:?} {d:?} to {t_max} from {start}");
                assert_eq!(bvh_any(k, o, d, t_max, start), brute.id != NONE, "scene {scene}: any of {o:?} {d:?}");
                hits += usize::from(tree.id != NONE);
                if tree.id != NONE {
                    let p = k.surface_at(tree, o, d).p;
                    let off = (o + d * tree.t - p).length();
                    assert!(off < 1e-5 * size.max(tree.t), "scene {scene}: the surface is {off} off the hit");
                }
            }
            assert!((2_000..18_000).contains(&hits), "scene {scene}: {hits} hits");
        });
    }
}

#[test]
fn an_empty_scene_has_nothing_to_hit() {
    nothing().with_kernel(|k| {
        assert_eq!(bvh_closest(k, Vec3::ZERO, Vec3::Z, FAR, NONE).id, NONE);
        assert_eq!(k.closest_hit(Vec3::ZERO, Vec3::Z, NONE).t, FAR);
        assert!(!bvh_any(k, Vec3::ZERO, Vec3::Z, FAR, NONE));
    });
}

// Distance to a sphere in f64 from the f32 ray.
fn sphere_exact(o: Vec3, d: Vec3, centre: DVec3, radius: f64) -> Option<f64> {
    let (f, d) = (o.as_dvec3() - centre, d.as_dvec3());
    let (a, b, c) = (d.dot(d), f.dot(d), f.dot(f) - radius * radius);
    let root = (b * b - a * c).sqrt();
    [(-b - root) / a, (-b + root) / a].into_iter().find(|t| *t > 0.0)
}

#[test]
fn spheres_of_all_sizes_are_hit_where_they_are() {
    let mut random = Random(3);
    let cases = [
        (1e-3, DVec3::ZERO, 1.0),
        (1e-3, DVec3::new(3.0, -2.0, 5.0), 10.0),
        (1.0, DVec3::ZERO, 1e4),
        (1e4, DVec3::new(0.0, 0.0, -2e4), 1e4),
        (1e4, DVec3::new(3e4, 1e4, 0.0), 3e4),
        (0.5, DVec3::new(100.0, 20.0, -70.0), 3.0),
    ];
    for (radius, centre, distance) in cases {
        let mut builder = Builder::default();
        builder.sphere(ball(centre, radius));
        builder.build().with_kernel(|k| {
            let mut worst = 0.0_f64;
            for _ in 0..20_000 {
                let from = random.direction() * (radius + distance) as f32;
                let o = centre.as_vec3() + from;
                // At a point of the disc that is seen, away from its rim, where nothing is exact.
                let side = random.direction().cross(from).normalize() * (0.9 * radius) as f32 * random.unit();
                let d = (centre.as_vec3() + side - o).normalize();
                let hit = bvh_closest(k, o, d, FAR, NONE);
                let want = sphere_exact(o, d, centre, radius).expect("aimed at it");
                assert!(hit.id == 0, "radius {radius} at {centre}: missed from {o} along {d}");
                worst = worst.max((f64::from(hit.t) - want).abs() / want);
                let away = (centre.as_vec3() - o).normalize() * -1.0;
                assert_eq!(bvh_closest(k, o, away, FAR, NONE).id, NONE, "radius {radius}: hit behind");
            }
            println!("radius {radius} from {distance}: {worst:e}");
            assert!(worst < 1e-5, "radius {radius} from {distance}: off by {worst:e} of the way");
        });
    }
}

#[test]
fn a_ray_that_starts_on_a_sphere_leaves_it_or_crosses_it() {
    let mut random = Random(4);
    for (radius, centre) in [(1.0, DVec3::ZERO), (1e-3, DVec3::new(1.0, 2.0, 3.0)), (1e4, DVec3::new(0.0, -1e4, 0.0))] {
        let mut builder = Builder::default();
        builder.sphere(ball(centre, radius));
        builder.build().with_kernel(|k| {
            for _ in 0..20_000 {
                let from = centre.as_vec3() + random.direction() * (3.0 * radius) as f32;
                let hit = bvh_closest(k, from, (centre.as_vec3() - from).normalize(), FAR, NONE);
                let s = k.surface_at(hit, from, (centre.as_vec3() - from).normalize());
                let d = random.direction();
                let out = d.dot(s.ng);
                let o = k.offset_point(s.p, if out > 0.0 { s.ng } else { -s.ng });
                // The offset, of 256 roundings, slants a small sphere's normal.
                if out.abs() < 0.01 + 4.0 * (o - s.p).length() / radius as f32 {
                    continue;
                }
                let again = bvh_closest(k, o, d, FAR, hit.id);
                if out > 0.0 {
                    assert_eq!(again.id, NONE, "radius {radius}: {o} along {d} meets itself at {}", again.t);
                    assert!(!bvh_any(k, o, d, FAR, hit.id));
                } else {
                    let want = -2.0 * out * radius as f32;
                    // The offset moves the start inwards, which shortens a slanted way more.
                    let slack = 2.0 * (o - s.p).length() / out.abs() + 1e-4 * want;
                    assert!((again.t - want).abs() < slack, "radius {radius}: {} not {want}", again.t);
                    assert_eq!(again.id, hit.id);
                }
            }
        });
    }
}

#[test]
fn planes_are_hit_once() {
    let mut random = Random(5);
    for scale in [1e-2_f64, 1.0, 100.0, 1e4] {
        for _ in 0..2_000 {
            let turn = DMat3::from_axis_angle(random.direction().as_dvec3().normalize(), 2.0);
            let origin = random.cube(1.0).as_dvec3() * scale;
            let mut packed = nothing();
            packed.shapes = vec![placed(DAffine3::from_mat3_translation(turn, origin))];
            packed.params.plane_count = 1;
            packed.with_kernel(|k| {
                let normal = turn.z_axis;
                let o = random.cube(scale as f32);
                let d = random.direction();
                let want = (origin - o.as_dvec3()).dot(normal) / d.as_dvec3().dot(normal);
                let hit = k.closest_hit(o, d, NONE);
                let fall = d.as_dvec3().dot(normal).abs();
                if fall < 1e-2 || want.abs() < 1e-3 * scale {
                    return;
                }
                assert_eq!(hit.id, if want > 0.0 { PLANE_BIT } else { NONE }, "{o} {d}");
                if want < 0.0 {
                    return;
                }
                assert!((f64::from(hit.t) - want).abs() < 5e-7 * (scale + want) / fall, "{} not {want}", hit.t);
                let s = k.surface_at(hit, o, d);
                let reach = scale + f64::from(s.p.length());
                assert!(((s.p.as_dvec3() - origin).dot(normal)).abs() < 1e-6 * reach, "{} is off the plane", s.p);
                let side = if d.dot(s.ng) < 0.0 { s.ng } else { -s.ng };
                let p = k.offset_point(s.p, side);
                let next = random.direction();
                let next = if next.dot(side) < 0.0 { -next } else { next };
                assert_eq!(k.closest_hit(p, next, hit.id).id, NONE, "the plane is met twice");
                assert!(!k.any_hit(p, next, FAR, hit.id));
            });
        }
    }
}

#[test]
fn an_offset_point_stays_on_its_side() {
    let mut random = Random(6);
    for scale in [1e-4_f32, 1e-2, 1.0, 100.0, 1e4] {
        let (mut crossed, mut met) = (0, 0);
        for _ in 0..20_000 {
            let a = random.cube(scale);
            let (b, c) = (a + random.cube(scale), a + random.cube(scale));
            let normal = (b - a).as_dvec3().cross((c - a).as_dvec3());
            let edge = (b - a).length().max((c - a).length()).max((c - b).length());
            // Slivers have no side in f32.
            if normal.length() < f64::from(0.05 * edge * edge) {
                continue;
            }
            let mut builder = Builder::default();
            builder.triangle([a, b, c]);
            builder.build().with_kernel(|k| {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let target = a + (b - a) * u + (c - a) * v;
                let from = random.cube(2.0 * scale);
                let d = (target - from).normalize();
                let hit = bvh_closest(k, from, d, FAR, NONE);
                if hit.id == NONE {
                    return;
                }
                let s = k.surface_at(hit, from, d);
                let side = if d.dot(s.ng) < 0.0 { s.ng } else { -s.ng };
                let p = k.offset_point(s.p, side);
                let height = |p: Vec3| (p - a).as_dvec3().dot(normal) * f64::from(side.dot(normal.as_vec3())).signum();
                crossed += usize::from(height(p) <= 0.0);
                let next = random.direction();
                let next = if next.dot(side) < 0.0 { -next } else { next };
                met += usize::from(next.dot(side) > 1e-2 && bvh_any(k, p, next, FAR, NONE));
                assert!(!bvh_any(k, p, next, FAR, hit.id), "it starts there");
            });
        }
        assert_eq!((crossed, met), (0, 0), "at scale {scale}: crossed, met again");
    }
}

#[test]
fn barycentric_weights_give_the_point() {
    let mut random = Random(7);
    for _ in 0..20_000 {
        let corners = [random.cube(1.0), random.cube(1.0), random.cube(1.0)];
        let mut builder = Builder::default();
        builder.triangle(corners);
        builder.build().with_kernel(|k| {
            let (u, v) = (0.4 * random.unit() + 0.05, 0.4 * random.unit() + 0.05);
            let target = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
            let o = random.cube(3.0);
            let d = (target - o).normalize();
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            if normal.length() < 0.1 || d.dot(normal.normalize()).abs() < 0.1 {
                return;
            }
            let hit = bvh_closest(k, o, d, FAR, NONE);
            assert_eq!(hit.id, 0, "missed {corners:?} at {u} {v} from {o}");
            assert!((hit.barycentric - glam::Vec2::new(u, v)).abs().max_element() < 2e-4, "{hit:?}, not {u} {v}");
            let s = k.surface_at(hit, o, d);
            assert!((s.p - target).length() < 1e-4 && (s.ng - normal.normalize()).length() < 1e-5);
        });
    }
}
