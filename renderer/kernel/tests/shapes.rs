//! Disks, cylinders, cones, capsules and rings against distances in f64: hits from afar and from the surface itself,
//! which finds neither gaps nor itself; boxes; what is drawn on them.

mod common;

use std::f64::consts::{PI, TAU};

use common::{Random, placed};
use glam::{DAffine3, DQuat, DVec2, DVec3, UVec4, Vec2, Vec3, Vec4};
use kinora_kernel::generated::{
    FAR, Kernel, LIGHT_OTHER, NONE, OTHER_CAPSULE, OTHER_CONE, OTHER_CYLINDER, OTHER_DISK, OTHER_FUNNEL, OTHER_TORUS,
    OTHER_TUBE, PRIMITIVE_OTHER,
};
use kinora_kernel::query::{Bounds, Isa, build};
use kinora_kernel::{Light, Packed, Primitive};

/// How far a point is off the shape, less than 0 inside; of what is open, or has corners, at least near the surface.
fn distance(kind: u32, size: f64, p: DVec3) -> f64 {
    let rho = p.x.hypot(p.z);
    match kind {
        OTHER_CYLINDER => (rho - 1.0).max(p.y.abs() - 1.0),
        OTHER_CONE => ((rho + p.y) / 2.0_f64.sqrt()).max(-1.0 - p.y),
        OTHER_CAPSULE => (p - DVec3::Y * p.y.clamp(-size, size)).length() - 1.0,
        _ => (rho - 1.0).hypot(p.y) - size,
    }
}

/// All roots of the distance along a ray of unit length within `far`, in order: steps as long as nothing can be missed,
/// and where the surface is grazed, as short as `fine`.
fn roots(kind: u32, size: f64, o: DVec3, d: DVec3, far: f64, fine: f64) -> Vec<f64> {
    let at = |t: f64| distance(kind, size, o + t * d);
    let mut found = Vec::new();
    let mut t = 0.0;
    while t < far {
        let here = at(t);
        let next = t + here.abs().max(fine);
        if (at(next) > 0.0) != (here > 0.0) {
            let (mut low, mut high) = (t, next);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if (at(middle) > 0.0) == (here > 0.0) { low = middle } else { high = middle }
            }
            found.push(high);
        }
        t = next;
    }
    found
}

const CLOSED: [(u32, f64); 7] = [
    (OTHER_CYLINDER, 0.0),
    (OTHER_CONE, 0.0),
    (OTHER_CAPSULE, 0.0),
    (OTHER_CAPSULE, 1.7),
    (OTHER_TORUS, 0.25),
    (OTHER_TORUS, 0.01),
    (OTHER_TORUS, 0.9),
];
const OPEN: [u32; 3] = [OTHER_DISK, OTHER_TUBE, OTHER_FUNNEL];

fn scene(kind: u32, size: f64, place: DAffine3) -> Packed {
    let primitive = Primitive {
        x: Vec4::new(size as f32, 0.0, 0.0, 0.0),
        shade: UVec4::new(0, 0, 0, PRIMITIVE_OTHER),
        index: UVec4::new(0, 0, kind, 0),
        ..Primitive::default()
    };
    let shape = placed(place);
    let rows = [0, 1, 2].map(|i| place.matrix3.row(i).extend(place.translation[i]));
    let bounds = Bounds::of_other(&primitive, rows);
    let reach = bounds.low.abs().max(bounds.high.abs()).max_element();
    let mut primitives = vec![primitive];
    let mut packed = Packed { shapes: vec![shape].into(), ..Packed::empty() };
    *packed.tree = build(&mut primitives, &[bounds.padded(reach)], &packed.shapes);
    *packed.primitives = primitives;
    packed.params.primitive_count = 1;
    packed
}

fn any_place(random: &mut Random, scale: f64, stretched: bool) -> DAffine3 {
    let axis = random.direction().as_dvec3();
    let mut one = || if stretched { f64::from(random.within(0.4, 1.6)) } else { 1.0 };
    let size = DVec3::new(one(), one(), if stretched { -one() } else { 1.0 }) * scale;
    let turn = DQuat::from_axis_angle(axis, f64::from(random.within(0.0, 6.0)));
    DAffine3::from_scale_rotation_translation(size, turn, random.cube(2.0).as_dvec3() * scale)
}

/// A point on the surface in the shape's own space, by Newton's method from a random one.
fn on_surface(kind: u32, size: f64, random: &mut Random) -> DVec3 {
    loop {
        let mut p = random.cube(2.7).as_dvec3();
        for _ in 0..60 {
            let e = 1e-6;
            let here = distance(kind, size, p);
            let slope = DVec3::AXES.map(|axis| (distance(kind, size, p + axis * e) - here) / e);
            let slope = DVec3::from_array(slope);
            p -= slope * here / slope.length_squared().max(1e-6);
        }
        // An edge or a tip is where Newton's method leads most points from outside.
        let edge = match kind {
            OTHER_CYLINDER | OTHER_CONE => (p.x.hypot(p.z) - 1.0).abs().max((p.y.abs() - 1.0).abs()) < 1e-3,
            _ => false,
        };
        if distance(kind, size, p).abs() < 1e-9 && !edge && p.length() > 1e-3 {
            return p;
        }
    }
}

#[test]
fn rays_from_afar_meet_what_is_there() {
    let mut random = Random(1);
    for (kind, size) in CLOSED {
        let (mut wrong, mut hits, mut missed) = (0, 0, 0);
        for round in 0..16 {
            let place = any_place(&mut random, [1.0, 1e3, 1e-3][round % 3], round >= 3);
            let packed = scene(kind, size, place);
            packed.validate().expect("valid");
            packed.with_kernel(|k| {
                for _ in 0..600 {
                    // Near the surface on purpose, where rays graze it.
                    let target = on_surface(kind, size, &mut random) + random.direction().as_dvec3() * 0.02;
                    let o = target + random.direction().as_dvec3() * f64::from(random.within(0.05, 9.0));
                    let (o, target) = (place.transform_point3(o), place.transform_point3(target));
                    let d = (target - o).normalize().as_vec3();
                    let o = o.as_vec3();
                    let got = k.closest_hit(o, d, NONE);
                    let back = place.inverse();
                    let (f, v) = (back.transform_point3(o.as_dvec3()), back.transform_vector3(d.as_dvec3()));
                    let speed = v.length();
                    let want = roots(kind, size, f, v / speed, 16.0, 1e-5);
                    let blur = 2e-5 * (1.0 + f.length());
                    // What the ray passes within rounding may be met or not.
                    let t = f64::from(got.t) * speed;
                    let good = match (got.id == NONE, want.first()) {
                        (true, None) => true,
                        (false, Some(first)) if (t - first).abs() < blur => true,
                        (false, _) => distance(kind, size, f + v / speed * t).abs() < 2e-7 * (2.0 + f.length()),
                        (true, Some(first)) => want.get(1).is_some_and(|second| {
                            let deepest = distance(kind, size, f + v / speed * (0.5 * (first + second)));
                            deepest.abs() < 1e-6 * (1.0 + f.length())
                        }),
                    };
                    hits += usize::from(got.id != NONE);
                    missed += usize::from(got.id == NONE);
                    wrong += usize::from(!good);
                    if !good && wrong < 4 {
                        println!("{kind} {size}: {} at {t}, want {want:?}", got.id);
                    }
                }
            });
        }
        assert!(hits > 2000 && missed > 200, "{kind} {size}: {hits} hits, {missed} misses");
        assert_eq!(wrong, 0, "{kind} {size}");
    }
}

#[test]
fn rays_from_the_surface_find_neither_gaps_nor_themselves() {
    let mut random = Random(2);
    for (kind, size) in CLOSED {
        let (mut lost, mut found, mut torn, mut clear) = (0, 0, 0, 0);
        for round in 0..16 {
            let place = any_place(&mut random, [1.0, 1e3, 1e-3][round % 3], round >= 3);
            let packed = scene(kind, size, place);
            packed.with_kernel(|k| {
                for _ in 0..600 {
                    // A real hit, as a path has it.
                    let target = place.transform_point3(on_surface(kind, size, &mut random));
                    let size_m = place.matrix3.determinant().abs().cbrt();
                    let o = target + random.direction().as_dvec3() * (3.0 * size_m);
                    let (o, d) = (o.as_vec3(), (target - o).normalize().as_vec3());
                    let hit = k.closest_hit(o, d, NONE);
                    if hit.id == NONE {
                        continue;
                    }
                    let s = k.surface_at(hit, o, d);
                    let next = random.direction();
                    let cosine = next.dot(s.ng);
                    let side = if cosine > 0.0 { s.ng } else { -s.ng };
                    let start = k.offset_point(s, side);
                    let again = k.closest_hit(start, next, hit.id);
                    // Grazing rays may go either way.
                    if cosine.abs() < 3e-3 {
                        continue;
                    }
                    if cosine < 0.0 {
                        // Inside: it must come out, through the inner side.
                        let out = again.id != NONE && {
                            let out = k.surface_at(again, start, next);
                            out.ng.dot(next) > -1e-3
                        };
                        lost += usize::from(!out);
                        found += 1;
                    } else {
                        let back = place.inverse();
                        let f = back.transform_point3(s.p.as_dvec3());
                        let v = back.transform_vector3(next.as_dvec3());
                        let speed = v.length();
                        let shape = roots(kind, size, f + v / speed * 1e-4, v / speed, 8.0, 1e-4);
                        let grazes = shape.windows(2).any(|w| w[1] - w[0] < 5e-3);
                        let t = f64::from(again.t) * speed;
                        let good = match (again.id == NONE, shape.first()) {
                            (true, None) => true,
                            (false, Some(first)) => (t - first).abs() < 2e-3,
                            _ => grazes,
                        };
                        torn += usize::from(!good);
                        clear += 1;
                    }
                }
            });
        }
        assert!(found > 2000 && clear > 2000, "{kind} {size}: {found} inside, {clear} outside");
        assert_eq!((lost, torn), (0, 0), "{kind} {size} of {found} and {clear}");
    }
}

#[test]
fn what_is_open_is_met_from_both_sides() {
    let mut random = Random(3);
    for kind in OPEN {
        let mut met = [0; 3];
        for round in 0..20 {
            let place = any_place(&mut random, 1.0, round > 0);
            let packed = scene(kind, 0.0, place);
            packed.with_kernel(|k| {
                for _ in 0..500 {
                    let o = random.cube(2.0).as_dvec3();
                    let v = random.direction().as_dvec3();
                    // Every place where the whole quadric, or plane, is met.
                    let (a, b, c) = match kind {
                        OTHER_DISK => (0.0, 0.5 * v.y, o.y),
                        OTHER_TUBE => (v.x * v.x + v.z * v.z, o.x * v.x + o.z * v.z, o.x * o.x + o.z * o.z - 1.0),
                        _ => (
                            v.x * v.x + v.z * v.z - v.y * v.y,
                            o.x * v.x + o.z * v.z - o.y * v.y,
                            o.x * o.x + o.z * o.z - o.y * o.y,
                        ),
                    };
                    let root = (b * b - a * c).sqrt();
                    let roots = if a == 0.0 { [-0.5 * c / b; 2] } else { [(-b - root) / a, (-b + root) / a] };
                    let inside = |p: DVec3| match kind {
                        OTHER_DISK => 1.0 - p.x.hypot(p.z),
                        OTHER_TUBE => 1.0 - p.y.abs(),
                        _ => (-p.y).min(p.y + 1.0),
                    };
                    let there = roots.map(|t| (t, if t > 0.0 { inside(o + t * v) } else { -1.0 }));
                    if root.is_nan() || root < 1e-3 || there.iter().any(|(t, x)| x.abs() < 1e-4 || t.abs() < 1e-4) {
                        continue;
                    }
                    let want = there.iter().filter(|(_, x)| *x > 0.0).map(|(t, _)| *t).fold(f64::INFINITY, f64::min);
                    let (from, along) = (place.transform_point3(o), place.transform_vector3(v));
                    let d = along.normalize().as_vec3();
                    let got = k.closest_hit(from.as_vec3(), d, NONE);
                    assert_eq!(got.id == NONE, want.is_infinite(), "{kind}: {o} {v}, {} for {want}", got.t);
                    if got.id == NONE {
                        met[0] += 1;
                        continue;
                    }
                    let t = f64::from(got.t) / along.length();
                    assert!((t - want).abs() < 1e-3, "{kind}: {t} for {want}");
                    let s = k.surface_at(got, from.as_vec3(), d);
                    met[if s.ng.dot(d) < 0.0 { 1 } else { 2 }] += 1;
                    // From there on, only what is left.
                    let side = if s.ng.dot(d) > 0.0 { s.ng } else { -s.ng };
                    let on = k.closest_hit(k.offset_point(s, side), d, got.id);
                    let last = there.iter().filter(|(t, x)| *x > 0.0 && *t > want + 1e-9).count();
                    assert_eq!(on.id == NONE, last == 0, "{kind}: {} after {want}: {there:?}", on.t);
                }
            });
        }
        assert!(met.iter().all(|&n| n > 200), "{kind}: {met:?}");
    }
}

#[test]
fn all_instructions_find_the_same() {
    let mut random = Random(4);
    let mut primitives = Vec::new();
    let mut bounds = Vec::new();
    let mut packed = Packed { shapes: Vec::new().into(), ..Packed::empty() };
    for i in 0..120_u32 {
        let place = DAffine3::from_translation(random.cube(6.0).as_dvec3()) * any_place(&mut random, 0.7, i % 2 == 0);
        packed.shapes.push(placed(place));
        let primitive = Primitive {
            x: Vec4::new(0.3, 0.0, 0.0, 0.0),
            shade: UVec4::new(0, 0, 0, PRIMITIVE_OTHER | i),
            index: UVec4::new(0, 0, i % 7, 0),
            ..Primitive::default()
        };
        let rows = [0, 1, 2].map(|i| place.matrix3.row(i).extend(place.translation[i]));
        bounds.push(Bounds::of_other(&primitive, rows).padded(10.0));
        primitives.push(primitive);
    }
    for few in [true, false] {
        let count = if few { 14 } else { primitives.len() };
        let mut own = primitives[..count].to_vec();
        *packed.tree = build(&mut own, &bounds[..count], &packed.shapes);
        *packed.primitives = own;
        packed.params.primitive_count = count as u32;
        let mut met = 0;
        for _ in 0..3000 {
            let (o, d) = (random.cube(8.0), random.direction());
            // Every primitive in turn.
            let want = packed.with_kernel(|k| {
                let probe = k.probe_along(o, d);
                (0..count as u32)
                    .map(|id| k.hit_primitive(id, probe, FAR, NONE))
                    .fold(k.no_hit(), |best, hit| if hit.t < best.t { hit } else { best })
            });
            for isa in Isa::ALL {
                let got = packed.with_kernel_on(*isa, |k| k.closest_hit(o, d, NONE));
                assert_eq!((got.t.to_bits(), got.id, got.uv), (want.t.to_bits(), want.id, want.uv), "{isa:?}");
                let any = packed.with_kernel_on(*isa, |k| k.any_hit(o, d, FAR, NONE));
                assert_eq!(any, want.id != NONE, "{isa:?}");
            }
            met += usize::from(want.id != NONE);
        }
        assert!(met > 100, "{met}");
    }
}

/// Points drawn on a shape, and their densities, against the area of each part of it: ∫ f = mean of f / pdf.
#[test]
fn what_is_drawn_is_spread_as_said() {
    let mut random = Random(5);
    let parts = Vec3::new(0.5, 0.2, 0.3);
    for (kind, size, area) in [
        (OTHER_DISK, 0.0, PI),
        (OTHER_CYLINDER, 0.0, 6.0 * PI),
        (OTHER_TUBE, 0.0, 4.0 * PI),
        (OTHER_CONE, 0.0, PI * (1.0 + 2.0_f64.sqrt())),
        (OTHER_FUNNEL, 0.0, PI * 2.0_f64.sqrt()),
        (OTHER_CAPSULE, 0.8, 4.0 * PI * 1.8),
        (OTHER_TORUS, 0.3, 4.0 * PI * PI * 0.3),
        (OTHER_TORUS, 1.5, {
            let end = (-1.0 / 1.5_f64).acos();
            TAU * 1.5 * 2.0 * (end + 1.5 * end.sin())
        }),
    ] {
        let parts = match kind {
            OTHER_TUBE | OTHER_FUNNEL => Vec3::X,
            OTHER_CONE => Vec3::new(0.6, 0.0, 0.4),
            OTHER_CAPSULE => Vec3::new(0.6, 0.4, 0.0),
            _ => parts,
        };
        let place = DAffine3::IDENTITY;
        let mut packed = scene(kind, size, place);
        *packed.lights = vec![Light {
            edge_u: Vec4::new(1.0, size as f32, 0.0, 1.0),
            edge_v: parts.extend(0.0),
            kind: UVec4::new(LIGHT_OTHER, 0, kind, 0),
            ..Light::default()
        }];
        packed.with_kernel(|k: &Kernel<'_>| {
            let n = 120_000;
            // The area, and moments that tell places apart.
            let (mut sum, mut square) = ([0.0; 3], [0.0; 3]);
            let mut expected = [area, 0.0, 0.0];
            for _ in 0..n {
                let u: Vec2 = random.square();
                let drawn = k.other_sample(kind, size as f32, parts, u);
                let p = drawn.at.p.as_dvec3();
                let off = match kind {
                    OTHER_DISK => p.y.abs(),
                    OTHER_TUBE => p.x.hypot(p.z) - 1.0,
                    OTHER_FUNNEL => p.x.hypot(p.z) + p.y,
                    _ => distance(kind, size, p),
                };
                assert!(off.abs() < 1e-5, "{kind}: {p} is {off} off");
                let density = k.other_light_density(0, drawn.at.p);
                // An apple is drawn without end at its core.
                let blur = 2e-3 + 1e-6 / p.x.hypot(p.z) * f64::from(u8::from(size > 1.0));
                assert!(
                    (f64::from(density / drawn.pdf) - 1.0).abs() < blur,
                    "{kind}: {density} at {p} of {}",
                    drawn.pdf
                );
                let weight = 1.0 / f64::from(drawn.pdf);
                for (i, f) in [1.0, p.x, p.z].into_iter().enumerate() {
                    sum[i] += f * weight;
                    square[i] += (f * weight).powi(2);
                }
            }
            for i in 0..3 {
                let mean = sum[i] / f64::from(n);
                let error = ((square[i] / f64::from(n) - mean * mean) / f64::from(n)).sqrt();
                if kind == OTHER_DISK || i > 0 {
                    expected[i] = if i == 0 { area } else { 0.0 }
                }
                assert!(
                    (mean - expected[i]).abs() < 5.0 * error + 1e-4 * area,
                    "{kind} {size} {i}: {mean} ± {error}, {}",
                    expected[i]
                );
            }
        });
    }
}

#[test]
fn uv_runs_as_of_spheres_and_quads() {
    let packed = scene(OTHER_TORUS, 0.25, DAffine3::IDENTITY);
    packed.with_kernel(|k| {
        let at = |kind, size, p: [f32; 3], part| k.other_uv(kind, size, Vec3::from_array(p), part);
        let near = |a: Vec2, b: [f64; 2]| assert!((a.as_dvec2() - DVec2::from_array(b)).length() < 1e-5, "{a} {b:?}");
        // +z is the middle, +x a quarter on.
        near(at(OTHER_CYLINDER, 0.0, [0.0, 0.0, 1.0], 0.0), [0.5, 0.5]);
        near(at(OTHER_CYLINDER, 0.0, [1.0, 1.0, 0.0], 0.0), [0.75, 1.0]);
        near(at(OTHER_CONE, 0.0, [-0.25, -0.25, 0.0], 0.0), [0.25, 0.75]);
        near(at(OTHER_CAPSULE, 0.0, [0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt()], 0.0), [0.5, 0.75]);
        near(at(OTHER_CAPSULE, 1.0, [0.0, -2.0, 0.0], 0.0), [0.5, 0.0]);
        near(at(OTHER_TORUS, 0.25, [0.0, 0.25, 1.0], 0.0), [0.5, 0.25]);
        near(at(OTHER_TORUS, 0.25, [0.75, 0.0, 0.0], 0.0), [0.75, 0.5]);
        near(at(OTHER_DISK, 0.0, [1.0, 0.0, 0.0], 0.0), [1.0, 0.5]);
        near(at(OTHER_DISK, 0.0, [0.0, 0.0, -1.0], 0.0), [0.5, 1.0]);
        near(at(OTHER_CYLINDER, 0.0, [0.0, 1.0, -1.0], 1.0), [0.5, 1.0]);
        near(at(OTHER_CYLINDER, 0.0, [0.0, -1.0, 1.0], -1.0), [0.5, 1.0]);
    });
}
