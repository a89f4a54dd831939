//! Lights: what is sampled is what the density says, and irradiances against closed forms.

mod common;

use std::f64::consts::PI;

use common::{
    Mean, Random, SphereBins, check_counts, check_rejects, direction, flat, glossy, number, placed, round, rows,
};
use glam::{DAffine3, DMat3, DVec3, UVec4, Vec3};
use kinora_kernel::generated::{
    EMITTER_TWO_SIDED, FAR, LIGHT_ELLIPSOID, LIGHT_PARALLELOGRAM, LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_TRIANGLE,
    MATERIAL_EMITTER, NONE, PRIMITIVE_KIND, PRIMITIVE_PARALLELOGRAM, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE,
};
use kinora_kernel::{Kernel, Light, Material, Packed, Primitive, Shape};

const IRRADIANCE: &str = include_str!("data/light_irradiance.csv");

/// The scene of lights, each with its chance.
#[derive(Default)]
struct Builder {
    primitives: Vec<Primitive>,
    shapes: Vec<Shape>,
    lights: Vec<Light>,
}

impl Builder {
    fn shape(&mut self, place: DAffine3) -> u32 {
        self.shapes.push(Shape { index: UVec4::new(0, self.lights.len() as u32, NONE, 0), ..placed(place) });
        self.shapes.len() as u32 - 1
    }

    fn light(&mut self, kind: u32, shape: u32, origin: Vec3, u: Vec3, v: Vec3, area: f32) {
        self.lights.push(Light {
            origin: origin.extend(0.0),
            edge_u: u.extend(0.0),
            edge_v: v.extend(0.0),
            normal: u.cross(v).normalize_or_zero().extend(1.0 / area),
            kind: UVec4::new(kind, shape, 0, 0),
        });
    }

    fn triangle(&mut self, [a, b, c]: [Vec3; 3]) {
        let shape = self.shape(DAffine3::IDENTITY);
        self.primitives.push(flat(PRIMITIVE_TRIANGLE, shape, 0, [a, b, c, a]));
        self.light(LIGHT_TRIANGLE, shape, a, b - a, c - a, 0.5 * (b - a).cross(c - a).length());
    }

    fn parallelogram(&mut self, a: Vec3, u: Vec3, v: Vec3) {
        let shape = self.shape(DAffine3::IDENTITY);
        self.primitives.push(flat(PRIMITIVE_PARALLELOGRAM, shape, 0, [a, a + u, a + u + v, a + v]));
        self.light(LIGHT_PARALLELOGRAM, shape, a, u, v, u.cross(v).length());
    }

    fn round_light(&mut self, kind: u32, place: DAffine3, size: f64) {
        let shape = self.shape(place);
        self.primitives.push(round(shape));
        self.light(kind, shape, place.translation.as_vec3(), Vec3::X * size as f32, Vec3::ZERO, 1.0);
    }

    fn sphere(&mut self, centre: DVec3, radius: f64) {
        let place = DAffine3::from_translation(centre) * DAffine3::from_scale(DVec3::splat(radius));
        self.round_light(LIGHT_SPHERE, place, radius);
    }

    fn ellipsoid(&mut self, centre: DVec3, matrix: DMat3) {
        let place = DAffine3::from_mat3_translation(matrix, centre);
        self.round_light(LIGHT_ELLIPSOID, place, matrix.determinant().abs());
    }

    fn build(mut self, powers: &[f64]) -> Packed {
        assert_eq!(powers.len(), self.lights.len());
        let total: f64 = powers.iter().sum();
        let last = powers.iter().rposition(|p| *p > 0.0).expect("a light");
        let mut before = 0.0;
        for (i, light) in self.lights.iter_mut().enumerate() {
            light.origin.w = if i > last { 2.0 } else { before as f32 };
            light.edge_u.w = (powers[i] / total) as f32;
            before += powers[i] / total;
        }
        let mut packed = Packed::empty();
        packed.params.light_count = self.lights.len() as u32;
        packed.params.primitive_count = self.primitives.len() as u32;
        packed.primitives = self.primitives.into();
        packed.shapes = self.shapes.into();
        packed.lights = self.lights.into();
        packed
    }
}

fn triangle() -> Builder {
    let mut b = Builder::default();
    b.triangle([Vec3::new(0.2, -0.3, 1.0), Vec3::new(1.4, 0.1, 0.8), Vec3::new(0.1, 1.2, 1.7)]);
    b
}

fn parallelogram() -> Builder {
    let mut b = Builder::default();
    b.parallelogram(Vec3::new(-0.5, -0.4, 1.0), Vec3::new(1.0, 0.1, 0.3), Vec3::new(-0.2, 0.9, 0.0));
    b
}

fn rectangle(corner: Vec3) -> Builder {
    let mut b = Builder::default();
    b.parallelogram(corner, Vec3::new(1.0, 0.1, 0.3), Vec3::new(-0.2, 2.0, 0.0));
    b.lights[0].kind.x = LIGHT_RECTANGLE;
    b
}

fn sphere(distance: f64, radius: f64) -> Builder {
    let mut b = Builder::default();
    b.sphere(DVec3::new(0.6, -0.64, 0.48) * distance, radius);
    b
}

fn ellipsoid(distance: f64) -> Builder {
    let mut b = Builder::default();
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, 1.0, -0.7);
    b.ellipsoid(DVec3::new(0.6, -0.64, 0.48) * distance, turn * DMat3::from_diagonal(DVec3::new(0.3, 1.0, 0.6)));
    b
}

fn cases() -> Vec<(&'static str, Packed)> {
    vec![
        ("triangle", triangle().build(&[1.0])),
        ("parallelogram", parallelogram().build(&[1.0])),
        ("rectangle", rectangle(Vec3::new(-0.5, -0.4, 1.0)).build(&[1.0])),
        ("near rectangle", rectangle(Vec3::new(-0.5, -0.4, 0.35)).build(&[1.0])),
        ("far rectangle", rectangle(Vec3::new(-0.5, -0.4, 30.0)).build(&[1.0])),
        ("sphere", sphere(3.0, 1.0).build(&[1.0])),
        ("near sphere", sphere(1.01, 1.0).build(&[1.0])),
        ("sphere around", sphere(0.7, 1.0).build(&[1.0])),
        ("small sphere", sphere(2.0, 0.8).build(&[1.0])),
        ("ellipsoid", ellipsoid(2.0).build(&[1.0])),
        ("ellipsoid around", ellipsoid(0.1).build(&[1.0])),
    ]
}

/// Every place where a ray meets the lights.
fn hits(k: &Kernel<'_>, o: Vec3, d: Vec3) -> Vec<kinora_kernel::generated::Surface> {
    let mut found = Vec::new();
    for id in 0..k.params.primitive_count {
        let mut from = o;
        for _ in 0..2 {
            let hit = k.hit_primitive(id, k.probe_along(from, d), FAR, NONE);
            if hit.id == NONE {
                break;
            }
            let s = k.surface_at(hit, from, d);
            found.push(s);
            if k.primitives[id as usize].shade.w & PRIMITIVE_KIND != PRIMITIVE_SPHERE {
                break;
            }
            from = s.p + d * 1e-3;
        }
    }
    found
}

#[test]
fn directions_follow_the_density() {
    // An ellipsoid's density has a pole all along its outline, which no bin can hold, nor can it what is far and small.
    let held = |name: &str, p: &Packed| name != "far rectangle" && p.lights[0].kind.x != LIGHT_ELLIPSOID;
    let cases: Vec<_> = cases().into_iter().filter(|(name, p)| held(name, p)).collect();
    let tests = 2 * cases.len();
    for (i, (name, packed)) in cases.iter().enumerate() {
        packed.with_kernel(|k| {
            let eye = Vec3::ZERO;
            let mut random = Random(i as u64);
            let bins = SphereBins { z_low: -1.0, rows: 24, columns: 48, jumps: true, off: 0.0 };
            let (observed, expected) = bins.check(
                name,
                tests,
                1_000_000,
                || Some((k.light_sample(eye, Vec3::ZERO, random.square()).p - eye).normalize()),
                |d| hits(k, eye, d).first().map_or(0.0, |s| f64::from(k.light_pdf(*s, eye, Vec3::ZERO))),
            );
            check_rejects(name, tests, &observed, &expected);
        });
    }
}

#[test]
fn positions_are_even_on_flat_lights() {
    const CELLS: usize = 24;
    const COUNT: usize = 1_000_000;
    for (name, packed, half) in
        [("triangle", triangle().build(&[1.0]), true), ("parallelogram", parallelogram().build(&[1.0]), false)]
    {
        let light = packed.lights[0];
        let (u, v) = (light.edge_u.truncate(), light.edge_v.truncate());
        packed.with_kernel(|k| {
            let mut random = Random(5);
            let mut observed = vec![0.0; CELLS * CELLS];
            let normal = u.cross(v);
            for _ in 0..COUNT {
                // From so far away, by area.
                let s = k.light_sample(Vec3::splat(-90.0), Vec3::ZERO, random.square());
                let p = s.p - light.origin.truncate();
                let st = [p.cross(v).dot(normal), u.cross(p).dot(normal)].map(|x| x / normal.length_squared());
                assert!(st.iter().all(|x| (-1e-5..1.0 + 1e-5).contains(x)) && (!half || st[0] + st[1] < 1.0 + 1e-5));
                assert!((s.n - normal.normalize()).length() < 1e-5, "{name}: {}", s.n);
                let [i, j] = st.map(|x| ((x * CELLS as f32).max(0.0) as usize).min(CELLS - 1));
                observed[i * CELLS + j] += 1.0;
            }
            let expected: Vec<f64> = (0..CELLS * CELLS)
                .map(|bin| {
                    let share = match (half, (bin / CELLS + bin % CELLS + 1).cmp(&CELLS)) {
                        (false, _) => 1.0,
                        (true, std::cmp::Ordering::Less) => 2.0,
                        (true, std::cmp::Ordering::Equal) => 1.0,
                        (true, std::cmp::Ordering::Greater) => 0.0,
                    };
                    share * COUNT as f64 / (CELLS * CELLS) as f64
                })
                .collect();
            check_counts(name, 2, &observed, &expected);
            check_rejects(name, 2, &observed, &expected);
        });
    }
}

#[test]
fn the_density_of_a_sample_is_that_of_its_surface() {
    let mut failures = Vec::new();
    for (name, packed) in cases() {
        packed.with_kernel(|k| {
            let mut random = Random(6);
            let mut worst = (0.0_f32, String::new());
            let mut checked = 0;
            let mut missed = 0;
            for _ in 0..50_000 {
                let eye = random.cube(0.3);
                let s = k.light_sample(eye, Vec3::ZERO, random.square());
                assert!(s.pdf.is_finite() && s.pdf >= 0.0, "{name}: {s:?}");
                assert!((s.n.length() - 1.0).abs() < 1e-5, "{name}: {s:?}");
                let d = (s.p - eye).normalize();
                // Seen edge on, the point where a ray arrives is not where it was sent.
                if d.dot(s.n).abs() < 0.03 {
                    continue;
                }
                let Some(found) = hits(k, eye, d).into_iter().find(|f| (f.p - s.p).length() < 1e-3) else {
                    // Rounding may send it past an edge.
                    missed += u32::from(s.pdf > 0.0);
                    continue;
                };
                assert_eq!(found.shape, s.shape);
                assert!(found.ng.dot(s.n) > 0.999, "{name}: the normal is {}, not {}", found.ng, s.n);
                let error = (k.light_pdf(found, eye, Vec3::ZERO) / s.pdf - 1.0).abs();
                checked += 1;
                if error > worst.0 {
                    worst = (error, format!("{s:?} from {eye}"));
                }
            }
            println!("{name}: {}", worst.0);
            assert!(checked > 20_000 && missed <= 5, "{name}: {checked} checked, {missed} missed");
            if worst.0 > 1e-3 {
                failures.push((name, worst));
            }
        });
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn lights_are_chosen_by_power() {
    let all: [&[f64]; 5] = [
        &[1.0],
        &[0.0, 3.0, 0.0, 0.0, 1.0, 0.0],
        &[1.0, 1.0, 1.0],
        &[1e-6, 1.0, 1e-6],
        &[5.0, 0.0, 2.0, 0.1, 0.0, 0.0, 7.0, 1.0],
    ];
    for powers in all {
        let mut b = Builder::default();
        for i in 0..powers.len() {
            b.sphere(DVec3::new(i as f64, 0.0, 5.0), 0.1);
        }
        b.build(powers).with_kernel(|k| {
            const STEPS: u32 = 1 << 20;
            let total: f64 = powers.iter().sum();
            let mut counts = vec![0.0; powers.len()];
            let mut fresh = vec![Mean::default(); powers.len()];
            let draw = |u: f32| {
                let mut left = u;
                (k.light_choose(0, powers.len() as u32, &mut left) as usize, left)
            };
            for i in 0..STEPS {
                let (light, left) = draw((i as f32 + 0.5) / STEPS as f32);
                assert!((0.0..1.0).contains(&left), "{powers:?}: {left} is left");
                assert!(powers[light] > 0.0, "{powers:?}: chose {light}, which has no power");
                counts[light] += 1.0;
                fresh[light].add(left.into());
            }
            for u in [0.0, f32::MIN_POSITIVE, 0.5, 1.0_f32.next_down()] {
                let (light, left) = draw(u);
                assert!(powers[light] > 0.0 && (0.0..1.0).contains(&left), "{powers:?}: {light} by {u}");
            }
            for (i, power) in powers.iter().enumerate() {
                let want = power / total * f64::from(STEPS);
                assert!((counts[i] - want).abs() <= 2.0, "{powers:?}: light {i} {} times, not {want}", counts[i]);
                if counts[i] > 1000.0 {
                    assert!((fresh[i].mean() - 0.5).abs() < 1e-3, "{powers:?}: {} is left", fresh[i].mean());
                }
            }
        });
    }
}

#[test]
fn a_sample_includes_the_choice() {
    let powers = [2.0, 0.0, 6.0, 1.0];
    let mut b = Builder::default();
    b.triangle([Vec3::new(0.0, 0.0, 2.0), Vec3::new(1.0, 0.0, 2.0), Vec3::new(0.0, 1.5, 1.0)]);
    b.sphere(DVec3::new(5.0, 0.0, 0.0), 1.0);
    b.sphere(DVec3::new(-3.0, 0.0, 1.0), 1.0);
    b.parallelogram(Vec3::new(-1.0, -3.0, 0.5), Vec3::X, Vec3::Y);
    b.build(&powers).with_kernel(|k| {
        let mut random = Random(7);
        let mut seen = [0; 4];
        for _ in 0..20_000 {
            let s = k.light_sample(Vec3::ZERO, Vec3::ZERO, random.square());
            seen[s.shape as usize] += 1;
            let d = s.p.normalize();
            if d.dot(s.n).abs() < 0.05 {
                continue;
            }
            let found = hits(k, Vec3::ZERO, d).into_iter().find(|f| (f.p - s.p).length() < 1e-3).expect("a surface");
            assert!((k.light_pdf(found, Vec3::ZERO, Vec3::ZERO) / s.pdf - 1.0).abs() < 1e-3, "{s:?}");
        }
        assert_eq!(seen[1], 0);
        assert!([0, 2, 3].iter().all(|i| seen[*i] > 1000), "{seen:?}");
        let dark = kinora_kernel::generated::Surface { shape: 1, ..Default::default() };
        assert_eq!(k.light_pdf(dark, Vec3::ZERO, Vec3::ZERO), 0.0, "a light that is never chosen");
    });
}

/// The mean of visible cosine over density.
fn irradiance(packed: &Packed, eye: Vec3, normal: DVec3, seed: u64) -> Mean {
    packed.with_kernel(|k| {
        let mut random = Random(seed);
        let mut mean = Mean::default();
        for _ in 0..40 {
            for _ in 0..100_000 {
                let s = k.light_sample(eye, Vec3::ZERO, random.square());
                let cos = (s.p - eye).as_dvec3().normalize().dot(normal).max(0.0);
                mean.add(if s.pdf > 0.0 { cos / f64::from(s.pdf) } else { 0.0 });
            }
            if mean.error() < 0.0018 * mean.mean() {
                break;
            }
        }
        mean
    })
}

#[test]
fn irradiance_is_the_closed_form() {
    let table: Vec<_> = rows(IRRADIANCE).collect();
    for (i, row) in table.iter().enumerate() {
        let at = |i: usize| DVec3::new(number(row[i]), number(row[i + 1]), number(row[i + 2]));
        let (eye, normal, want) = (at(1), at(4), number(row[8]));
        let numbers: Vec<f64> = row[7].split(' ').map(number).collect();
        let mut b = Builder::default();
        let corner = |i: usize| DVec3::from_slice(&numbers[3 * i..]).as_vec3();
        match (row[0], numbers.len()) {
            ("sphere", _) => b.sphere(DVec3::from_slice(&numbers), numbers[3]),
            (_, 9) => b.triangle([corner(0), corner(1), corner(2)]),
            (_, 12) => b.parallelogram(corner(0), corner(1) - corner(0), corner(3) - corner(0)),
            _ => panic!("{row:?}"),
        }
        // A sphere cut to a sliver by the horizon takes more samples than there is time for.
        let uncertainty = if want < 0.01 && row[0] == "sphere" { 0.01 } else { 2e-3 };
        let mean = irradiance(&b.build(&[1.0]), eye.as_vec3(), normal, i as u64);
        mean.check(&format!("{row:?}"), table.len(), want, 1e-5 * want + 1e-6, uncertainty);
    }
}

#[test]
fn an_ellipsoid_shines_as_the_same_sphere() {
    // Radius 0.5, made as an ellipsoid: both sides are drawn, so half of the samples are behind the light.
    let mut b = Builder::default();
    b.ellipsoid(DVec3::new(0.0, 0.0, 2.0), DMat3::from_diagonal(DVec3::splat(0.5)));
    b.build(&[1.0]).with_kernel(|k| {
        let mut random = Random(9);
        let mut mean = Mean::default();
        for _ in 0..2_000_000 {
            let s = k.light_sample(Vec3::ZERO, Vec3::ZERO, random.square());
            let facing = s.n.dot(s.p) < 0.0;
            mean.add(if facing { f64::from(s.p.normalize().z / s.pdf) } else { 0.0 });
        }
        mean.check("ellipsoid", 1, PI / 16.0, 1e-6, 2e-3);
    });
}

#[test]
fn an_ellipsoid_is_sampled_all_over_and_fills_its_solid_angle() {
    for (name, packed) in cases().into_iter().filter(|(_, p)| p.lights[0].kind.x == LIGHT_ELLIPSOID) {
        packed.with_kernel(|k| {
            let eye = Vec3::ZERO;
            let mut random = Random(10);
            let mut filled = Mean::default();
            let bins = SphereBins { z_low: -1.0, rows: 24, columns: 48, jumps: false, off: 0.0 };
            let draw = || {
                let s = k.light_sample(eye, Vec3::ZERO, random.square());
                let facing = s.n.dot(s.p - eye) < 0.0;
                filled.add(if facing && s.pdf > 0.0 { 1.0 / f64::from(s.pdf) } else { 0.0 });
                Some(k.object_point(s.shape, s.p).normalize())
            };
            let (observed, expected) = bins.check(name, 4, 1_000_000, draw, |_| 0.25 / PI);
            check_rejects(name, 4, &observed, &expected);
            if name.contains("around") {
                return;
            }
            // The share of directions that meet it, one by one.
            const STEPS: u32 = 1200;
            let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(STEPS);
            let met = (0..STEPS * STEPS)
                .map(|i| direction(1.0 - 2.0 * middle(i / STEPS), 2.0 * PI * middle(i % STEPS)))
                .filter(|d| k.hit_primitive(0, k.probe_along(eye, *d), FAR, NONE).id != NONE)
                .count();
            let solid_angle = 4.0 * PI * met as f64 / f64::from(STEPS * STEPS);
            filled.check(name, 4, solid_angle, 3e-4 * solid_angle, 2e-3);
        });
    }
}

/// An emitter's record: its coat and the next one, or NONE.
fn emitter(radiance: Vec3, flags: u32, coat: u32, next: u32) -> Material {
    Material {
        color: radiance.extend(0.0),
        kind: UVec4::new(MATERIAL_EMITTER, flags, coat, next),
        ..Material::default()
    }
}

#[test]
fn what_shines_on_which_side() {
    let mut packed = triangle().build(&[1.0]);
    let (one, other) = (Vec3::new(3.0, 2.0, 1.0), Vec3::new(0.0, 0.5, 7.0));
    *packed.materials = vec![
        emitter(one, 0, NONE, NONE),
        emitter(one, EMITTER_TWO_SIDED, NONE, NONE),
        // Two that are mixed, of which one shines to both sides.
        emitter(one, 0, NONE, 3),
        emitter(other, EMITTER_TWO_SIDED, NONE, NONE),
        // Below a coat.
        emitter(one, 0, 5, NONE),
        glossy(1.5, 0.0, NONE),
    ];
    let coated = one * (1.0 - 0.04);
    for (first, front, back) in [
        (0, one, Vec3::ZERO),
        (1, one, one),
        (2, one + other, other),
        (4, coated, Vec3::ZERO),
        (NONE, Vec3::ZERO, Vec3::ZERO),
    ] {
        packed.shapes[0].index.z = first;
        packed.with_kernel(|k| {
            assert!((k.light_eval(0, 1.0, Vec3::Z) - front).length() < 1e-6, "emitters from {first} on");
            assert!((k.light_eval(0, -1.0, Vec3::Z) - back).length() < 1e-6, "emitters from {first} on, from within");
        });
    }
    packed.shapes[0].index.y = NONE;
    packed.with_kernel(|k| {
        let s = hits(k, Vec3::ZERO, direction(0.9, 0.5))[0];
        assert_eq!(k.light_pdf(s, Vec3::ZERO, Vec3::ZERO), 0.0, "it is no light");
    });
}
