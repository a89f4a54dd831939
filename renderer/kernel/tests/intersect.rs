//! Rays against primitives, one by one and through the tree.

mod common;

use common::{Random, direction, flat, placed, round};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use kinora_kernel::generated::{FAR, Hit, NONE, PLANE_BIT, PRIMITIVE_PARALLELOGRAM, PRIMITIVE_TRIANGLE};
use kinora_kernel::query::{
    BATCH, Bounds, Hits, Isa, Rays, build, bvh_any, bvh_any_many, bvh_closest, bvh_closest_many,
};
use kinora_kernel::{Kernel, Packed, Primitive, Shape};
/// A scene under construction.
#[derive(Default)]
struct Builder {
    primitives: Vec<Primitive>,
    boxes: Vec<Bounds>,
    shapes: Vec<Shape>,
}

impl Builder {
    fn flat(&mut self, kind: u32, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners;
        let (low, high) = (a.min(b).min(c).min(d), a.max(b).max(c).max(d));
        self.boxes.push(Bounds { low, high });
        self.primitives.push(flat(kind, 0, self.primitives.len() as u32, corners));
    }

    fn triangle(&mut self, [a, b, c]: [Vec3; 3]) {
        self.flat(PRIMITIVE_TRIANGLE, [a, b, c, a]);
    }

    fn mesh(&mut self, corners: &[Vec3], faces: &[Vec<usize>]) {
        for face in faces {
            match face[..] {
                [a, b, c] => self.triangle([a, b, c].map(|i| corners[i])),
                [a, b, c, d] => self.flat(PRIMITIVE_PARALLELOGRAM, [a, b, c, d].map(|i| corners[i])),
                _ => panic!("{face:?}"),
            }
        }
    }

    /// The unit sphere, placed.
    fn sphere(&mut self, place: DAffine3) {
        let rows = place.matrix3.transpose();
        let half = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let (low, high) = (place.translation - half, place.translation + half);
        self.boxes.push(Bounds { low: low.as_vec3(), high: high.as_vec3() });
        self.primitives.push(round(self.shapes.len() as u32));
        self.shapes.push(placed(place));
    }

    /// Without a tree.
    fn bare(self) -> Packed {
        let mut packed = Packed::empty();
        packed.params.primitive_count = self.primitives.len() as u32;
        packed.primitives = self.primitives.into();
        packed
    }

    /// With a tree.
    fn build(mut self) -> Packed {
        let mut packed = Packed::empty();
        packed.params.primitive_count = self.primitives.len() as u32;
        *packed.tree = build(&mut self.primitives, &self.boxes, &self.shapes);
        packed.primitives = self.primitives.into();
        if !self.shapes.is_empty() {
            packed.shapes = self.shapes.into();
        }
        packed.check_depth().expect("a deep tree");
        packed
    }
}

fn ball(centre: DVec3, radius: f64) -> DAffine3 {
    DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(radius))
}

/// Runs `f` with each set of instructions that this CPU has.
fn with_each_isa(packed: &Packed, mut f: impl FnMut(&Kernel<'_>)) {
    for &isa in Isa::ALL.iter().filter(|isa| isa.is_there()) {
        packed.with_kernel_on(isa, &mut f);
    }
}

fn by_brute_force(k: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> Hit {
    let mut best = Hit { t: t_max, id: NONE, instance: NONE, ..Hit::default() };
    for id in 0..k.params.primitive_count {
        let hit = k.hit_primitive(id, k.probe_along(o, d), best.t, start);
        if hit.id != NONE {
            best = hit;
        }
    }
    if best.id == NONE {
        best.t = FAR;
    }
    best
}

/// Corners, and faces of three or four of them.
type Faces = (Vec<Vec3>, Vec<Vec<usize>>);

fn cube() -> Faces {
    let corners = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (corners, faces.map(Vec::from).into())
}

fn in_halves((corners, faces): Faces) -> Faces {
    (corners, faces.iter().flat_map(|f| [vec![f[0], f[1], f[2]], vec![f[0], f[2], f[3]]]).collect())
}

fn turned((corners, faces): Faces) -> Faces {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, 2.5);
    (corners.iter().map(|c| (turn * c.as_dvec3() * 37.0).as_vec3()).collect(), faces)
}

/// An octahedron, refined.
fn ball_of_triangles(levels: u32) -> Faces {
    let mut corners = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut triangles = vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
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
    (corners, triangles.into_iter().map(Vec::from).collect())
}

/// A box whose faces are fans of needles.
fn needles() -> Faces {
    const SPOKES: usize = 400;
    let mut corners = vec![Vec3::new(0.0, 0.0, 1.0), Vec3::new(0.0, 0.0, -0.5)];
    corners.extend((0..SPOKES).map(|i| {
        let turn = i as f64 / SPOKES as f64;
        direction(0.0, std::f64::consts::TAU * turn * turn) * 300.0
    }));
    let rim = |i: usize| 2 + i % SPOKES;
    let triangles = (0..SPOKES).flat_map(|i| [vec![0, rim(i), rim(i + 1)], vec![1, rim(i + 1), rim(i)]]).collect();
    (corners, triangles)
}

/// Directions from `o` that are awkward: to corners, to points of edges, and along axes.
fn awkward((corners, faces): &Faces, o: Vec3, random: &mut Random) -> Vec<Vec3> {
    let mut all = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    all.extend(corners.iter().map(|c| (c - o).normalize()));
    for face in faces {
        for i in 0..face.len() {
            let (a, b) = (corners[face[i]], corners[face[(i + 1) % face.len()]]);
            all.push(((a + b) * 0.5 - o).normalize());
            all.push((a + (b - a) * random.unit() - o).normalize());
        }
    }
    all
}

#[track_caller]
fn check_watertight(name: &str, mesh: &Faces, inside: f32, rays: usize) {
    let mut builder = Builder::default();
    builder.mesh(&mesh.0, &mesh.1);
    let packed = builder.build();
    // Every ray by the tree, as many as there is time for by brute force.
    let exhaustive = 2_000_000 / mesh.1.len();
    with_each_isa(&packed, |k| {
        let mut random = Random(1);
        let mut done = 0;
        while done < rays {
            let o = if done == 0 { Vec3::ZERO } else { random.cube(inside) };
            let mut directions = awkward(mesh, o, &mut random);
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
                    assert_eq!(hit, brute, "{name}: {o:?} {d:?}");
                }
                done += 1;
            }
        }
    });
}

#[test]
fn a_cube_is_watertight() {
    check_watertight("cube of parallelograms", &cube(), 0.99, 250_000);
    check_watertight("cube", &in_halves(cube()), 0.99, 250_000);
}

#[test]
fn a_turned_cube_is_watertight() {
    check_watertight("turned cube of parallelograms", &turned(cube()), 20.0, 250_000);
    check_watertight("turned cube", &turned(in_halves(cube())), 20.0, 250_000);
}

#[test]
fn a_ball_of_triangles_is_watertight() {
    check_watertight("ball", &ball_of_triangles(4), 0.5, 500_000);
}

#[test]
fn thin_triangles_are_watertight() {
    check_watertight("needles", &needles(), 0.1, 250_000);
}

#[test]
fn the_tree_finds_what_brute_force_finds() {
    let mut random = Random(2);
    for (scene, size) in [(0, 1.0_f32), (1, 100.0), (2, 1e-2)] {
        let mut builder = Builder::default();
        for i in 0..300 {
            let a = random.cube(size);
            let reach = size * if i % 10 == 0 { 1.0 } else { 0.1 };
            let (u, v) = (random.cube(reach), random.cube(reach));
            if i % 3 == 0 {
                builder.flat(PRIMITIVE_PARALLELOGRAM, [a, a + u, a + u + v, a + v]);
            } else {
                builder.triangle([a, a + u, a + v]);
            }
            if i % 6 == 0 {
                let scale = DVec3::new(0.02, 0.05, 0.1) * f64::from(size);
                let turn = DMat3::from_axis_angle(random.direction().as_dvec3().normalize(), 1.0);
                let centre = random.cube(size).as_dvec3();
                match i % 12 {
                    0 => builder.sphere(ball(centre, scale.y)),
                    _ => builder.sphere(DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), centre)),
                }
            }
        }
        with_each_isa(&builder.build(), |k| {
            let mut hits = 0;
            for i in 0..20_000 {
                let o = random.cube(2.0 * size);
                let d = if i % 7 == 0 { [Vec3::X, -Vec3::Y, Vec3::Z][i % 3] } else { random.direction() };
                let t_max = if i % 2 == 0 { FAR } else { random.within(0.0, 2.0 * size) };
                let start = if i % 3 == 0 { (random.bits() % 300) as u32 } else { NONE };
                let (tree, brute) = (bvh_closest(k, o, d, t_max, start), by_brute_force(k, o, d, t_max, start));
                assert_eq!(tree, brute, "scene {scene}: {o:?} {d:?} to {t_max} from {start}");
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
    Packed::empty().with_kernel(|k| {
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
        with_each_isa(&builder.build(), |k| {
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
        with_each_isa(&builder.build(), |k| {
            for _ in 0..20_000 {
                let from = centre.as_vec3() + random.direction() * (3.0 * radius) as f32;
                let hit = bvh_closest(k, from, (centre.as_vec3() - from).normalize(), FAR, NONE);
                let s = k.surface_at(hit, from, (centre.as_vec3() - from).normalize());
                let d = random.direction();
                let out = d.dot(s.ng);
                let o = k.offset_point(s, if out > 0.0 { s.ng } else { -s.ng });
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
            let mut packed = Packed::empty();
            *packed.shapes = vec![placed(DAffine3::from_mat3_translation(turn, origin))];
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
                let p = k.offset_point(s, side);
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
            builder.bare().with_kernel(|k| {
                let (u, v) = (random.unit(), random.unit());
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                let target = a + (b - a) * u + (c - a) * v;
                let from = random.cube(2.0 * scale);
                let d = (target - from).normalize();
                let hit = by_brute_force(k, from, d, FAR, NONE);
                if hit.id == NONE {
                    return;
                }
                let s = k.surface_at(hit, from, d);
                let side = if d.dot(s.ng) < 0.0 { s.ng } else { -s.ng };
                let p = k.offset_point(s, side);
                let height = |p: Vec3| (p - a).as_dvec3().dot(normal) * f64::from(side.dot(normal.as_vec3())).signum();
                crossed += usize::from(height(p) <= 0.0);
                let next = random.direction();
                let next = if next.dot(side) < 0.0 { -next } else { next };
                met += usize::from(
                    next.dot(side) > 1e-2 && k.hit_primitive(0, k.probe_along(p, next), FAR, NONE).id != NONE,
                );
                assert_eq!(k.hit_primitive(0, k.probe_along(p, next), FAR, hit.id).id, NONE, "it starts there");
            });
        }
        assert_eq!((crossed, met), (0, 0), "at scale {scale}: crossed, met again");
    }
}

#[test]
fn edge_weights_give_the_point() {
    let mut random = Random(7);
    for i in 0..20_000 {
        let [a, b, c] = [random.cube(1.0), random.cube(1.0), random.cube(1.0)];
        let triangle = i % 2 == 0;
        let mut builder = Builder::default();
        if triangle {
            builder.triangle([a, b, c]);
        } else {
            builder.flat(PRIMITIVE_PARALLELOGRAM, [a, b, b + c - a, c]);
        }
        builder.bare().with_kernel(|k| {
            let most = if triangle { 0.4 } else { 0.9 };
            let (u, v) = (most * random.unit() + 0.05, most * random.unit() + 0.05);
            let target = a + (b - a) * u + (c - a) * v;
            let o = random.cube(3.0);
            let d = (target - o).normalize();
            let normal = (b - a).cross(c - a);
            if normal.length() < 0.1 || d.dot(normal.normalize()).abs() < 0.1 {
                return;
            }
            let hit = by_brute_force(k, o, d, FAR, NONE);
            assert_eq!(hit.id, 0, "missed {a} {b} {c} at {u} {v} from {o}");
            assert!((hit.uv - glam::Vec2::new(u, v)).abs().max_element() < 2e-4, "{hit:?}, not {u} {v}");
            let s = k.surface_at(hit, o, d);
            assert!((s.p - target).length() < 1e-4 && (s.ng - normal.normalize()).length() < 1e-5);
        });
    }
}

/// Rays that are hard to get right in a scene of that size: axis-parallel, through corners and along edges, from corners
/// and from far away, and some that are no rays at all.
fn hard_rays(packed: &Packed, size: f32, count: usize, random: &mut Random) -> Vec<(Vec3, Vec3, f32, u32)> {
    let corner = |random: &mut Random| {
        let p = packed.primitives[random.bits() as usize % packed.primitives.len()];
        let i = random.bits() as usize % 4;
        Vec3::new(p.x[i], p.y[i], p.z[i])
    };
    let axes = [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let mut rays = Vec::new();
    for i in 0..count {
        let o = match i % 5 {
            0 => corner(random),
            1 => random.direction() * (1000.0 * size),
            2 => corner(random) + axes[random.bits() as usize % 6] * random.unit() * size,
            _ => random.cube(1.5 * size),
        };
        let target = match i % 7 {
            0 => corner(random),
            1 => corner(random).midpoint(corner(random)),
            _ => random.cube(size),
        };
        let d = match i % 11 {
            0 => axes[random.bits() as usize % 6],
            1 => Vec3::new(random.unit() - 0.5, 0.0, random.unit() - 0.5).normalize_or_zero(),
            2 => (axes[random.bits() as usize % 6] + random.cube(1e-8)).normalize_or_zero(),
            3 => -(target - o).normalize_or_zero(),
            _ => (target - o).normalize_or_zero(),
        };
        let d = if i % 997 == 0 { Vec3::NAN } else { d };
        let t_max = if i % 3 == 0 { random.unit() * size } else { FAR };
        let start = if i % 2 == 0 { NONE } else { random.bits() as u32 % packed.params.primitive_count };
        rays.push((o, d, t_max, start));
    }
    rays
}

/// Every query gives, to the bit, what the translated `hit_primitive` gives for one primitive after the other.
#[track_caller]
fn check_bits(name: &str, builder: Builder, size: f32, count: usize) {
    let packed = builder.build();
    let mut random = Random(8);
    let rays = hard_rays(&packed, size, count, &mut random);
    let bits = |h: Hit| (h.t.to_bits(), h.id, h.uv.x.to_bits(), h.uv.y.to_bits());
    // Of what is seen exactly edge-on, all edges' signs are rounding, and a hit may lie anywhere along it, out of its box.
    let edge_on = |id: u32, d: Vec3| {
        packed.primitives.get(id as usize).is_some_and(|p| {
            let corner = |i: usize| Vec3::new(p.x[i], p.y[i], p.z[i]).as_dvec3();
            let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
            let longest = (corner(1) - corner(0)).length().max((corner(2) - corner(0)).length());
            normal.dot(d.as_dvec3()).abs() <= 1e-5 * longest * longest
        })
    };
    let mut odd = 0;
    let want: Vec<Hit> = packed.with_kernel_on(Isa::Portable, |k| {
        rays.iter().map(|&(o, d, t_max, start)| by_brute_force(k, o, d, t_max, start)).collect()
    });
    let hits = want.iter().filter(|hit| hit.id != NONE).count();
    assert!(hits > count / 100, "{name}: {hits} hits of {count}");
    with_each_isa(&packed, |k| {
        for (&(o, d, t_max, start), &want) in rays.iter().zip(&want) {
            let hit = bvh_closest(k, o, d, t_max, start);
            if bits(hit) != bits(want) && (edge_on(want.id, d) || edge_on(hit.id, d)) {
                odd += 1;
                continue;
            }
            assert_eq!(bits(hit), bits(want), "{name}: {hit:?}, not {want:?}: {o} {d} to {t_max} from {start}");
            assert_eq!(
                bvh_any(k, o, d, t_max, start),
                want.id != NONE,
                "{name}: any of {o} {d} to {t_max} from {start}"
            );
        }
        for (i, (rays, want)) in rays.chunks(BATCH).zip(want.chunks(BATCH)).enumerate() {
            // What is not active may be anything.
            let mut batch = Rays { o: [[f32::NAN; BATCH]; 3], t_max: [f32::INFINITY; BATCH], ..Rays::default() };
            let mut active = 0;
            for (lane, &(o, d, t_max, start)) in rays.iter().enumerate() {
                for axis in 0..3 {
                    (batch.o[axis][lane], batch.d[axis][lane]) = (o[axis], d[axis]);
                }
                (batch.t_max[lane], batch.start[lane]) = (t_max, start);
                active |= u32::from((i + lane) % 5 > 0) << lane;
            }
            let mut hits = Hits::default();
            let found = bvh_closest_many(k, &batch, active, &mut hits);
            let any = bvh_any_many(k, &batch, active);
            for (lane, &want) in want.iter().enumerate() {
                let uv = glam::Vec2::new(hits.u[lane], hits.v[lane]);
                let hit = Hit { t: hits.t[lane], id: hits.id[lane], uv, instance: hits.instance[lane] };
                let want = if active >> lane & 1 == 1 { want } else { k.no_hit() };
                if bits(hit) != bits(want) && (edge_on(want.id, rays[lane].1) || edge_on(hit.id, rays[lane].1)) {
                    odd += 1;
                    continue;
                }
                assert_eq!(bits(hit), bits(want), "{name}: batch {i}, {:?}", rays[lane]);
                assert_eq!(found >> lane & 1 == 1, want.id != NONE, "{name}: batch {i}, {:?}", rays[lane]);
                assert_eq!(any >> lane & 1 == 1, want.id != NONE, "{name}: batch {i}, {:?}", rays[lane]);
            }
        }
    });
    assert!(odd <= count / 500, "{name}: {odd} odd hits of what is seen edge-on");
}

/// Primitives of all kinds, many of which touch or coincide.
fn medley(count: usize, size: f32) -> Builder {
    let mut random = Random(9);
    let mut builder = Builder::default();
    let grid = |random: &mut Random| (random.cube(4.0).round() * 0.25) * size;
    for i in 0..count {
        let a = grid(&mut random);
        let (u, v) = (random.cube(1.0).round() * 0.5 * size, random.cube(1.0) * 0.3 * size);
        match i % 5 {
            0 | 1 => builder.triangle([a, a + u, a + v]),
            2 => builder.triangle([a, grid(&mut random), grid(&mut random)]),
            3 => builder.flat(PRIMITIVE_PARALLELOGRAM, [a, a + u, a + u + v, a + v]),
            _ => {
                let scale = DVec3::new(0.02, 0.05, 0.1) * f64::from(size) * if i % 2 == 0 { 1.0 } else { 4.0 };
                let turn = DMat3::from_axis_angle(random.direction().as_dvec3().normalize(), 1.0);
                match i % 3 {
                    // Neither turned nor stretched.
                    0 => builder.sphere(ball(a.as_dvec3(), scale.x)),
                    _ => builder
                        .sphere(DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(scale), a.as_dvec3())),
                }
            }
        }
    }
    builder
}

#[test]
fn all_instructions_give_the_bits_of_the_scalar_test() {
    for (count, rays) in
        [(1, 20_000), (2, 20_000), (7, 50_000), (20, 100_000), (32, 100_000), (33, 100_000), (200, 50_000)]
    {
        for size in [1.0, 1e-3, 1e4] {
            check_bits(&format!("{count} of {size} m"), medley(count, size), size, rays);
        }
    }
    check_bits("many", medley(6_000, 1.0), 1.0, 2_000);
}

#[test]
fn a_thousand_in_one_place_are_no_deep_tree() {
    let mut builder = Builder::default();
    for _ in 0..1_000 {
        builder.triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
        builder.sphere(ball(DVec3::new(0.5, 0.5, 0.0), 0.5));
    }
    check_bits("in one place", builder, 1.0, 2_000);
}

#[test]
fn the_tree_does_not_depend_on_the_threads() {
    let tree = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| medley(50_000, 1.0).build())
    };
    let (one, three) = (tree(1), tree(3));
    assert_eq!(*one.primitives, *three.primitives);
    let nodes = |packed: &Packed| packed.compressed().expect("a flat tree").node_bytes();
    assert_eq!(nodes(&one), nodes(&three));
}
