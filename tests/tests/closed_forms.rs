//! Scenes whose answer is known in closed form, from text to pixel. The numbers are of formulas, or were integrated
//! twice in f64 by other programs; no renderer made them.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::fmt::Write as _;

use glam::DVec3;
use kinora_renderer::Choice;
use kinora_tests::measure::{Estimate, Kernel, Report};
use kinora_tests::world;

/// A scene, and what the whole of its picture shows in the mean.
struct Case {
    name: String,
    /// What `render` says besides.
    render: String,
    scene: String,
    truth: DVec3,
    /// Relative: of the truth, the approximation that the scene is, and the kernel's tables.
    tolerance: f64,
    /// Relative: the largest deviation that may go unnoticed.
    sharp: f64,
}

fn case(name: impl Into<String>, render: &str, scene: String, truth: f64, tolerance: f64) -> Case {
    Case { name: name.into(), render: render.into(), scene, truth: DVec3::splat(truth), tolerance, sharp: SHARP }
}

/// Numbers that say exactly what a formula says differ by f32 only.
const EXACT: f64 = 2e-5;
const PRELUDE: &str = "lang 1\nfn grey(x: float) -> color { return linear(x, x, x) }\n";
const SEEDS: u32 = 12;
const SHARP: f64 = 0.02;

fn check(cases: Vec<Case>) {
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut gpu = Kernel::gpu();
    let mut report = Report::new(2 * cases.len());
    for (i, case) in cases.iter().enumerate() {
        let render = format!("render {{ resolution: (8, 8), filter: box, {} }}", case.render);
        let world = world(&format!("{PRELUDE}{render}\n{}", case.scene));
        let truth = Estimate { mean: case.truth, ..Estimate::known(0.0) };
        // A program may be the GPU: some of the cases are enough for it.
        let gpu = gpu.as_deref_mut().filter(|_| i % 4 == 0 && world.render.samples <= 128);
        for (name, kernel) in [("cpu", Some(&mut cpu)), ("gpu", gpu)] {
            let Some(kernel) = kernel else { continue };
            let got = kernel.measure(&world, &[[0, 0, 8, 8]], SEEDS)[0];
            report.compare(&format!("{name}: {}", case.name), &got, &truth, case.tolerance, case.sharp);
        }
    }
    report.finish();
}

/// A camera that sees a few millimetres about `target` from `away`.
fn close_up(target: DVec3, away: DVec3) -> String {
    let eye = target + away;
    format!(
        "camera {{ position: ({}, {}, {}), look_at: ({}, {}, {}), up: (0.1, 0.7, 0.7), fov: 0.1deg }}\n",
        eye.x, eye.y, eye.z, target.x, target.y, target.z
    )
}

// --- direct light: a surface of albedo 1/2 under lamps of radiance 2 reflects E / (π L)

const DIRECT: &str = "max_bounces: 1, samples: 64";

fn receiver(normal: DVec3) -> String {
    let quad = format!("normal: ({}, {}, {}), size: (2cm, 2cm)", normal.x, normal.y, normal.z);
    let tangent = normal.any_orthonormal_vector();
    close_up(DVec3::ZERO, 0.05 * (normal + 0.3 * tangent))
        + &format!("quad {{ {quad}, material: diffuse {{ color: grey(0.5) }} }}\n")
}

fn mesh(positions: &[DVec3], indices: &[[usize; 3]], material: &str) -> String {
    let mut text = "mesh { positions: [".to_owned();
    for p in positions {
        write!(text, "({:.9}, {:.9}, {:.9}),", p.x, p.y, p.z).expect("memory");
    }
    text += "], indices: [";
    for i in indices.as_flattened() {
        write!(text, "{i},").expect("memory");
    }
    text + &format!("], material: {material} }}\n")
}

const LAMP: &str = "emitter { radiance: 2W/m^2/sr, two_sided: true }";

#[test]
fn lamps() {
    let square = |x: f64, y: f64, z: f64| {
        format!(
            "quad {{ position: ({x}, {y}, {z}), normal: (0, -1, 0), size: (1, 1), material: emitter {{ radiance: 2W/m^2/sr }} }}"
        )
    };
    let mut cases = Vec::new();
    let mut direct = |name: String, normal: DVec3, lamp: String, e: f64, tolerance: f64| {
        // Much of a lamp is behind the horizon where little of its light arrives.
        let samples = if e < 0.1 { 2048 } else { 128 };
        let render = format!("max_bounces: 1, samples: {samples}");
        cases.push(case(name, &render, receiver(normal) + &lamp, e / PI, tolerance));
    };
    direct("a square above".into(), DVec3::Y, square(0.0, 1.0, 0.0), 0.752_274_688_5, EXACT);
    direct("a square aside".into(), DVec3::Y, square(-2.0, 1.0, 0.0), 0.043_742_648_3, EXACT);
    direct("a square, tilted".into(), DVec3::new(0.6, 0.8, 0.0), square(0.0, 1.0, 0.0), 0.601_819_750_8, EXACT);
    direct("half a square".into(), DVec3::X, square(0.0, 1.0, 0.0), 0.087_510_264_8, EXACT);
    let corners = |points: &[(f64, f64, f64)]| points.iter().map(|&(x, y, z)| DVec3::new(x, z, -y)).collect::<Vec<_>>();
    let triangle = corners(&[(0.0, 0.0, 2.0), (1.0, 0.0, 2.0), (0.0, 1.5, 1.0)]);
    direct("a triangle".into(), DVec3::Y, mesh(&triangle, &[[0, 1, 2]], LAMP), 0.225_353_617_0, EXACT);
    let near = corners(&[(0.2, 0.1, 0.3), (-0.4, 0.3, 0.2), (0.1, -0.5, 0.4)]);
    direct("a triangle near by".into(), DVec3::Y, mesh(&near, &[[0, 1, 2]], LAMP), 1.154_150_875_6, 2e-4);
    let ceiling = "quad { position: (0, 548.8cm, 0), normal: (0, -1, 0), size: (130cm, 105cm), material: emitter { radiance: 2W/m^2/sr } }";
    direct("a ceiling lamp".into(), DVec3::Y, ceiling.into(), 0.044_632_474_7, EXACT);

    // Discs of 256 sides whose area is that of the disc.
    for (h, offset, radius, e) in [
        (1.0, 0.0, 1.0, FRAC_PI_2),
        (2.0, 0.0, 0.5, 0.184_799_568),
        (1.0, 0.5, 1.0, 1.375_963_021),
        (1.0, 2.0, 1.0, 0.165_833_381),
        (0.25, 0.9, 1.0, 1.958_928_958),
        (10.0, 3.0, 2.0, 0.102_906_425),
    ] {
        let sides = 256;
        let turn = 2.0 * PI / sides as f64;
        let r = radius * (turn / turn.sin()).sqrt();
        let corner = |i: usize| DVec3::new(offset + r * (turn * i as f64).cos(), h, r * (turn * i as f64).sin());
        let mut positions: Vec<_> = (0..sides).map(corner).collect();
        positions.push(DVec3::new(offset, h, 0.0));
        let fan: Vec<_> = (0..sides).map(|i| [i, (i + 1) % sides, sides]).collect();
        let name = format!("a disc of radius {radius} at ({offset}, {h})");
        direct(name, DVec3::Y, mesh(&positions, &fan, LAMP), e, 1e-4);
    }

    for (d, radius, degrees, e) in [
        (2.0, 1.0, 0.0_f64, FRAC_PI_4),
        (2.0, 1.0, 45.0, 0.555_360_367),
        (2.0, 1.0, 75.0, 0.221_200_880),
        (2.0, 1.0, 90.0, 0.090_586_074),
        (2.0, 1.0, 110.0, 0.006_753_066),
        (1.1, 1.0, 30.0, 2.251_259_197),
        (1.1, 1.0, 90.0, 0.762_371_397),
        (5.0, 0.5, 60.0, 0.015_707_963),
        (100.0, 1.0, 20.0, 0.000_295_213_143),
    ] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let lamp = format!(
            "sphere {{ radius: {radius}, position: ({}, {}, 0), material: emitter {{ radiance: 2W/m^2/sr }} }}",
            d * sin,
            d * cos
        );
        direct(format!("a sphere of radius {radius}, {d} away at {degrees} degrees"), DVec3::Y, lamp, e, 1e-4);
    }
    check(cases);
}

// --- glass slabs

fn fresnel(c: f64, n: f64) -> f64 {
    let t = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
    let (s, p) = ((c - n * t) / (c + n * t), (n * c - t) / (n * c + t));
    0.5 * (s * s + p * p)
}

#[test]
fn slabs() {
    let render = "max_bounces: 64, samples: 512";
    let mut cases = Vec::new();
    let lamp = "plane { position: (0, -2, 0), material: emitter { } }\n";
    // What `misc.json` of the project's reference data lists: transmitted without and with an optical depth of 1/2.
    for (n, degrees, clear, tinted) in [
        (1.05, 60.0_f64, 0.991_319_925, 0.409_428_398),
        (1.333, 30.0, 0.958_026_825, 0.558_464_159),
        (1.5, 0.0, 0.923_076_923, 0.559_307_869),
        (1.5, 60.0, 0.836_232_463, 0.450_738_834),
        (1.5, 80.0, 0.441_229_173, 0.201_249_523),
        (4.0, 60.0, 0.472_849_522, 0.258_949_731),
    ] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let eye = close_up(DVec3::ZERO, 3.0 * DVec3::new(sin, cos, 0.0));
        let slab = |more: &str| {
            format!("box {{ position: (0, -0.5, 0), size: (60, 1, 60), material: dielectric {{ ior: {n}{more} }} }}\n")
        };
        let tint = format!(", attenuation_color: grey({:.9}), attenuation_distance: 50cm", (-0.25_f64).exp());
        cases.push(case(
            format!("a slab of {n} at {degrees}"),
            render,
            format!("{eye}{lamp}{}", slab("")),
            clear,
            EXACT,
        ));
        cases.push(case(
            format!("a dark slab of {n} at {degrees}"),
            render,
            format!("{eye}{lamp}{}", slab(&tint)),
            tinted,
            EXACT,
        ));
        let r = fresnel(cos, n);
        let t = (-0.5 / (1.0 - (sin / n).powi(2)).sqrt()).exp();
        let back = r + r * (1.0 - r).powi(2) * t * t / (1.0 - r * r * t * t);
        if back > 0.05 {
            let scene = format!(
                "{eye}sky {{ color: grey(1) }}\nplane {{ position: (0, -2, 0), material: diffuse {{ color: grey(0) }} }}\n{}",
                slab(&tint)
            );
            cases.push(case(format!("a dark slab of {n} reflects at {degrees}"), render, scene, back, EXACT));
        }
        let sheet =
            format!("{eye}{lamp}quad {{ size: (1000, 1000), material: dielectric {{ ior: {n}, thin: true }} }}");
        cases.push(case(format!("a sheet of {n} at {degrees}"), render, sheet, clear, EXACT));
    }
    // Through the centre of a ball, straight: 0.96² t / (1 − 0.04² t²).
    let t = (-0.7_f64).exp();
    let ball = format!(
        "camera {{ position: (0, 0, 3), look_at: (0, 0, 0), fov: 0.01deg }}
        quad {{ position: (0, 0, -3), normal: (0, 0, 1), size: (1, 1), material: emitter {{ }} }}
        sphere {{ radius: 1, material: dielectric {{ attenuation_color: grey({t:.9}), attenuation_distance: 2m }} }}"
    );
    cases.push(case("through a ball", render, ball, 0.9216 * t / (1.0 - 0.0016 * t * t), 1e-4));
    // In at one leg of a prism of 45°, all of it off the base, out of the other leg; nothing from behind the base.
    let prism = mesh(
        &[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
            .iter()
            .flat_map(|&(x, y)| [DVec3::new(x, y, -1.0), DVec3::new(x, y, 1.0)])
            .collect::<Vec<_>>(),
        &[[0, 2, 1], [1, 2, 3], [0, 1, 4], [1, 5, 4], [2, 4, 3], [3, 4, 5], [0, 4, 2], [1, 3, 5]],
        "dielectric { }",
    );
    let scene = format!(
        "camera {{ position: (-2, 0.4, 0.1), look_at: (0, 0.4, 0.1), fov: 0.1deg }}
        quad {{ position: (0.5, -1, 0), size: (4, 4), material: emitter {{ color: linear(1, 0, 0.5) }} }}
        quad {{ position: (1.5, 1.5, 0), normal: (-1, -1, 0), size: (9, 9), material: emitter {{ color: linear(0, 1, 0) }} }}
        {prism}"
    );
    let through = (1.0 - 0.04) / (1.0 + 0.04);
    cases.push(Case { truth: DVec3::new(through, 0.0, 0.5 * through), ..case("a prism", render, scene, 0.0, EXACT) });
    // The eye in the middle of a ball of glass: radiance is n² times as high there (Veach 1997, section 5.2).
    for (name, more, truth) in [
        ("clear", "", 2.25),
        ("dark", ", attenuation_color: grey(0.5), attenuation_distance: 1m", 2.25 * 0.96 * 0.5 / (1.0 - 0.04 * 0.25)),
    ] {
        let scene = format!(
            "camera {{ position: (0, 0, 0), look_at: (0, 0, 1), fov: 40deg }} sky {{ color: grey(1) }}
            sphere {{ material: dielectric {{ ior: 1.5{more} }} }}"
        );
        cases.push(case(format!("inside {name} glass"), render, scene, truth, EXACT));
    }
    check(cases);
}

// --- furnaces: what loses nothing cannot be seen in a uniform world

#[test]
fn furnaces() {
    let eye = "camera { position: (0.4, 0.3, 4), look_at: (0, 0, 0), fov: 26deg }\nsky { color: grey(1) }\n";
    let mut cases = Vec::new();
    let mut furnace = |material: &str, shape: &str, bounces: u32, samples: u32, tolerance: f64| {
        let name = format!("{material} {}", shape.split(' ').next().unwrap_or_default());
        let render = format!("max_bounces: {bounces}, samples: {samples}");
        cases.push(case(name, &render, format!("{eye}{shape}, material: {material} }}"), 1.0, tolerance));
    };
    let ball = "sphere { rotation: rotate_z(40deg)";
    let block = "box { size: (1.1, 1.2, 0.9), rotation: euler(x: 20deg, y: 30deg, z: 10deg)";
    let ring = "torus { radius: 0.7, tube: 0.3, rotation: rotate_x(60deg)";
    for (roughness, shape) in [(0.0, ball), (0.13, ball), (0.37, block), (0.61, ring), (0.88, ball), (1.0, ball)] {
        furnace(&format!("diffuse {{ color: grey(1), roughness: {roughness} }}"), shape, 64, 64, 0.001);
    }
    for (roughness, anisotropy, shape) in [
        (0.0, 0.0, ball),
        (0.02, 0.0, ball),
        (0.17, 0.0, ball),
        (0.33, 0.0, block),
        (0.47, 0.0, ring),
        (0.72, 0.0, ball),
        (0.9, 0.0, ball),
        (1.0, 0.0, ball),
        (0.28, 0.4, ball),
        (0.53, 0.71, block),
        (0.77, 0.9, ball),
        (0.95, 0.35, ball),
        (1.0, 1.0, ball),
    ] {
        let material = format!(
            "metal {{ color: grey(1), roughness: {roughness}, anisotropy: {anisotropy}, anisotropy_rotation: 33deg }}"
        );
        furnace(&material, shape, 64, 96, 0.004);
    }
    for (ior, roughness, shape) in [
        (1.1, 0.23, ball),
        (1.1, 0.87, block),
        (1.21, 0.6, ball),
        (1.33, 0.41, block),
        (1.5, 0.12, ball),
        (1.5, 0.3, block),
        (1.5, 0.55, ball),
        (1.5, 1.0, ball),
        (2.4, 0.35, ball),
    ] {
        furnace(&format!("dielectric {{ ior: {ior}, roughness: {roughness} }}"), shape, 1000, 512, 0.006);
    }
    for (ior, shape) in [(1.05, ball), (1.33, block), (1.5, ring), (2.4, ball), (4.0, block)] {
        furnace(&format!("dielectric {{ ior: {ior} }}"), shape, 1000, 64, EXACT);
    }
    for (ior, roughness) in [(1.5, 0.0), (1.7, 0.4), (2.2, 0.9)] {
        let material = format!("dielectric {{ ior: {ior}, roughness: {roughness}, thin: true }}");
        furnace(&material, "quad { size: (1.5, 1.5), rotation: euler(x: 50deg, y: 20deg, z: 0deg)", 8, 128, 0.004);
        if roughness < 0.5 {
            furnace(&material, ball, 64, 64, 0.004);
        }
    }
    for (ior, roughness, metalness) in
        [(1.5, 0.0, 0.0), (1.5, 0.35, 0.0), (1.2, 0.8, 0.0), (1.9, 1.0, 0.0), (1.5, 0.35, 0.4), (1.5, 0.8, 1.0)]
    {
        let coat = format!("ior: {ior}, roughness: {roughness}, metalness: {metalness}");
        furnace(&format!("glossy {{ color: grey(1), {coat} }}"), ball, 64, 64, 0.004);
        furnace(
            &format!("glossy {{ base: diffuse {{ color: grey(1), roughness: 0.7 }}, {coat} }}"),
            block,
            64,
            64,
            0.004,
        );
    }
    furnace("glossy { base: metal { color: grey(1), roughness: 0.6 }, roughness: 0.3 }", ball, 64, 64, 0.006);
    furnace("glossy { base: glossy { color: grey(1), roughness: 0.5 }, roughness: 0.2 }", ball, 64, 64, 0.006);
    furnace("glossy { base: dielectric { ior: 1.4 }, roughness: 0.4 }", ball, 1000, 64, 0.006);
    furnace("mix(diffuse { color: grey(1), roughness: 0.5 }, dielectric { }, amount: 0.6)", ball, 1000, 64, 0.002);
    furnace(
        "mix(glossy { color: grey(1) }, metal { color: grey(1), roughness: 0.7 }, amount: 0.3)",
        ring,
        64,
        64,
        0.005,
    );
    furnace("diffuse { color: grey(1), opacity: 0.3 }", ball, 64, 64, EXACT);
    furnace(
        "mix(diffuse { color: grey(1), opacity: 0.5 }, metal { color: grey(1), roughness: 0.5 }, amount: 0.5)",
        ball,
        64,
        64,
        0.004,
    );

    // One boundary alone, from outside and from within, with n² the radiance inside.
    for (ior, roughness) in
        [(1.1, 0.9), (1.25, 0.45), (1.5, 0.3), (1.5, 0.7), (1.5, 1.0), (1.9, 0.85), (2.4, 0.5), (2.4, 1.0)]
    {
        let scene = format!(
            "sky {{ color: grey(1) }}
            box {{ position: (0, -5, 0), size: (10000, 10, 10000), material: dielectric {{ ior: {ior}, roughness: {roughness} }} }}
            plane {{ position: (0, -2, 0), material: emitter {{ radiance: {}W/m^2/sr, two_sided: true }} }}",
            ior * ior
        );
        for mu in [0.15, 0.5, 0.95_f64] {
            let s = (1.0 - mu * mu).sqrt();
            for (side, from, truth) in [("outside", mu, 1.0), ("inside", -mu, ior * ior)] {
                let name = format!("the boundary of {ior}, roughness {roughness}, from {side} at {mu}");
                let eye = close_up(DVec3::ZERO, DVec3::new(s, from, 0.0));
                cases.push(case(name, "max_bounces: 1, samples: 256", eye + &scene, truth, 0.006));
            }
        }
    }

    // Nested media, all clear.
    let nested = "
        dielectric glass { ior: 1.5, priority: 2 }
        dielectric water { ior: 1.33, priority: 1 }
        dielectric ice { ior: 1.31, priority: 3 }
        sphere { radius: 0.9, material: glass }
        box { position: (0, -0.1, 0), size: (1, 1.3, 1), material: water }
        sphere { position: (0.3, 0.4, 0.2), radius: 0.4, material: ice }
        sphere { position: (-0.4, 0.3, 0.2), radius: 0.3, material: ";
    for inner in [
        "dielectric { ior: 1, priority: 5 }",
        "dielectric { ior: 2.4, priority: 1 }",
        "metal { color: grey(1), roughness: 0 }",
    ] {
        cases.push(case(
            format!("nested, {inner}"),
            "max_bounces: 1000, samples: 128",
            format!("{eye}{nested}{inner} }}"),
            1.0,
            1e-4,
        ));
    }

    // Many bodies that see each other in a closed room that shines.
    let room = "
        camera { position: (0, 0.5, 1.9), look_at: (0, 0, 0), fov: 50deg }
        box { size: (4, 4, 4), material: emitter { two_sided: true } }
        sphere { position: (-1, 0, 0), radius: 0.6, material: diffuse { color: grey(1), roughness: 0.8 } }
        sphere { position: (0.3, 0, 0), radius: 0.6, material: dielectric { } }
        sphere { position: (0.3, 0, 0), radius: 0.3, material: metal { color: grey(1), roughness: 0.6 } }
        box { position: (1.2, 0.2, -0.4), rotation: rotate_y(30deg), material: glossy { color: grey(1), roughness: 0.2 } }
        quad { position: (0, 0, 0.9), normal: (0.3, 0.2, 1), size: (1, 0.7), material: dielectric { thin: true } }
        box { position: (0, -1.2, 0), size: (2, 0.4, 1), material: mix(metal { color: grey(1), roughness: 0 }, diffuse { color: grey(1) }, amount: 0.5) }";
    cases.push(case("a full room", "max_bounces: 1000, samples: 64", room.into(), 1.0, 0.002));
    check(cases);
}

// --- what a surface reflects of a uniform sky, seen at one angle

#[test]
fn albedos() {
    let mut cases = Vec::new();
    let mut albedo = |material: &str, mu: f64, truth: DVec3, tolerance: f64| {
        let eye = close_up(DVec3::ZERO, 2.0 * DVec3::new((1.0 - mu * mu).sqrt(), mu, 0.0));
        let scene = format!("{eye}sky {{ color: grey(1) }}\nplane {{ material: {material} }}");
        let name = format!("{material} at {mu:.3}");
        let samples = if truth.max_element() < 0.2 { 12288 } else { 128 };
        cases.push(Case { truth, ..case(name, &format!("max_bounces: 1, samples: {samples}"), scene, 0.0, tolerance) });
    };
    let same = DVec3::splat;
    for (roughness, mu, truth) in
        [(0.5, 0.1, 0.797497), (0.25, 0.5, 0.793257), (1.0, 0.3, 0.785132), (1.0, 1.0, 0.758722)]
    {
        albedo(&format!("diffuse {{ color: grey(0.8), roughness: {roughness} }}"), mu, same(truth), 3e-5);
    }
    for (roughness, mu, truth) in [(0.25, 0.1, 0.992283), (0.5, 0.5, 0.924188), (1.0, 0.9, 0.784220)] {
        albedo(&format!("diffuse {{ color: grey(1), roughness: {roughness}, model: fon }}"), mu, same(truth), 3e-5);
    }
    for (sigma, mu, truth) in [(0.25, 0.1, 1.006296), (0.25, 0.5, 0.975364), (1.0, 0.3, 0.783651), (1.0, 1.0, 0.624060)]
    {
        let roughness = sigma / (0.5 * PI);
        albedo(&format!("diffuse {{ color: grey(1), roughness: {roughness:.9}, model: qon }}"), mu, same(truth), 2e-4);
    }
    for (roughness, mu, truth) in [
        (0.25, 0.1, 0.896769),
        (0.5, 0.05, 0.933131),
        (0.5, 0.5, 0.857263),
        (0.75, 0.3, 0.721728),
        (1.0, 0.1, 0.760210),
        (1.0, 0.5, 0.450693),
        (1.0, 1.0, 1.0 - 2.0_f64.ln()),
    ] {
        let metal = format!("metal {{ color: grey(1), roughness: {roughness}, energy_compensation: false }}");
        albedo(&metal, mu, same(truth), 3e-5);
    }
    // F82: the colour straight on, and Schlick's curve times the tint where the cosine is 1/7.
    let (f0, tint) = (DVec3::new(0.9, 0.6, 0.2), DVec3::new(0.4, 0.8, 1.0));
    let metal = "metal { color: linear(0.9, 0.6, 0.2), edge_tint: linear(0.4, 0.8, 1), roughness: 0 }";
    albedo(metal, 1.0, f0, EXACT);
    albedo(metal, 1.0 / 7.0, (f0 + (1.0 - f0) * (6.0_f64 / 7.0).powi(5)) * tint, 2e-4);
    // What a rough boundary reflects, if nothing comes back from inside.
    for (roughness, mu, reflected, kept) in
        [(0.5, 0.3, 0.105404, 0.929958), (0.5, 1.0, 0.037049, 0.992045), (1.0, 0.5, 0.023387, 0.741838)]
    {
        let dark = "attenuation_color: grey(0.001), attenuation_distance: 1mm";
        for (compensation, truth, tolerance) in [(false, reflected, 5e-5), (true, reflected / kept, 0.004)] {
            let glass = format!("dielectric {{ roughness: {roughness}, energy_compensation: {compensation}, {dark} }}");
            albedo(&glass, mu, same(truth), tolerance);
        }
    }
    // A coat over a base that reflects half of what gets there.
    for mu in [0.2, 0.5, 1.0] {
        let f = fresnel(mu, 1.5);
        albedo("glossy { color: grey(0.5), roughness: 0 }", mu, same(f + 0.5 * (1.0 - f)), EXACT);
    }
    // A tinted coat: the tint straight on, white where it grazes, and its base is covered as by a white one.
    let tint = DVec3::new(1.0, 0.5, 0.0);
    for mu in [0.2, 0.5, 1.0] {
        let (f, grazing) = (fresnel(mu, 1.5), (1.0_f64 - mu).powi(5));
        let truth = f * (tint + (1.0 - tint) * grazing) + 0.5 * (1.0 - f);
        albedo("glossy { color: grey(0.5), tint: linear(1, 0.5, 0), roughness: 0 }", mu, truth, EXACT);
    }
    let coat = 0.105404 + 0.5 * (1.0 - 0.105404);
    albedo("glossy { color: grey(0.5), roughness: 0.5 }", 0.3, same(coat), 0.003);
    check(cases);
}

// --- closed rooms

#[test]
fn rooms() {
    let mut cases = Vec::new();
    // Walls that are half lamp (radiance 2) and half diffuse: every ray sees 1/(1 − ρ/2).
    let wall = |rho: f64| {
        format!(
            "mix(emitter {{ radiance: 2W/m^2/sr, two_sided: true }}, diffuse {{ color: grey({rho}) }}, amount: 0.5)"
        )
    };
    let tetrahedron = |material: &str| {
        let corners = [(1.0, 1.0, 1.0), (-1.0, -1.0, 1.0), (-1.0, 1.0, -1.0), (1.0, -1.0, -1.0)];
        mesh(
            &corners.map(|(x, y, z)| 2.0 * DVec3::new(x, y, z)),
            &[[0, 1, 3], [0, 2, 1], [0, 3, 2], [1, 2, 3]],
            material,
        )
    };
    let eye = "camera { position: (0.2, 0.1, 0.3), look_at: (0.5, 0, -1), fov: 60deg }\n";
    for (rho, bounces) in [(0.3, 200), (0.8, 200), (1.0, 200), (0.8, 0), (0.8, 1), (0.8, 4), (0.8, 7)] {
        let truth = (1.0 - (rho / 2.0_f64).powi(bounces + 1)) / (1.0 - rho / 2.0);
        let render = format!("max_bounces: {bounces}, samples: 64");
        for (name, room) in [
            ("box", format!("box {{ size: (2, 1, 3), material: {} }}", wall(rho))),
            ("ball", format!("sphere {{ radius: 1.5, scale: (1, 0.7, 1.2), material: {} }}", wall(rho))),
            ("tetrahedron", tetrahedron(&wall(rho))),
        ] {
            let name = format!("a {name} of albedo {rho}, {bounces} bounces");
            cases.push(case(name, &render, format!("{eye}{room}"), truth, EXACT));
        }
    }
    // An integrating sphere: ρ Φ / (4 π² R² (1 − ρ)).
    let sphere = "camera { position: (0, 0, 1), look_at: (0, 0.3, 2), fov: 30deg }
        sphere { radius: 2, material: diffuse { color: grey(0.8) } }
        sphere { radius: 1cm, material: emitter { power: 100W } }";
    cases.push(case("an integrating sphere", "max_bounces: 400, samples: 4096", sphere.into(), 2.533_029_591, 2e-4));

    // A cube whose ceiling shines, all faces diffuse: by radiosity.
    for (rho, points) in [
        (0.5, [0.197_602, 0.148_402, 0.177_647, 0.292_343, 0.091_809]),
        (0.8, [0.713_066, 0.612_902, 0.683_662, 0.872_161, 0.552_287]),
    ] {
        let places = [
            (DVec3::new(0.5, 0.0, 0.5), DVec3::Y),
            (DVec3::new(0.1, 0.0, 0.1), DVec3::Y),
            (DVec3::new(0.0, 0.5, 0.5), DVec3::X),
            (DVec3::new(0.0, 0.9, 0.5), DVec3::X),
            (DVec3::new(0.5, 1.0, 0.5), DVec3::NEG_Y),
        ];
        for ((p, n), reflected) in places.into_iter().zip(points) {
            let wall = |position: &str, normal: &str, material: &str| {
                format!("quad {{ position: ({position}), normal: ({normal}), size: (1, 1), material: {material} }}\n")
            };
            let white = format!("diffuse {{ color: grey({rho}) }}");
            let lamp = format!(
                "mix(emitter {{ radiance: {}W/m^2/sr }}, diffuse {{ color: grey(1) }}, amount: {rho})",
                1.0 / (1.0 - rho)
            );
            let scene = close_up(p, 0.05 * n)
                + &wall("0.5, 0, 0.5", "0, 1, 0", &white)
                + &wall("0.5, 1, 0.5", "0, -1, 0", &lamp)
                + &wall("0, 0.5, 0.5", "1, 0, 0", &white)
                + &wall("1, 0.5, 0.5", "-1, 0, 0", &white)
                + &wall("0.5, 0.5, 0", "0, 0, 1", &white)
                + &wall("0.5, 0.5, 1", "0, 0, -1", &white);
            let truth = if n == DVec3::NEG_Y { 1.0 + reflected } else { reflected };
            cases.push(case(
                format!("a cube of albedo {rho} at {p}"),
                "max_bounces: 400, samples: 512",
                scene,
                truth,
                3e-4,
            ));
        }
    }
    check(cases);
}

// --- the lens: a small lamp out of focus is a disc as wide as the lens is seen from it

#[test]
fn lens() {
    let mut cases = Vec::new();
    let (aperture, focus, distance) = (0.05 / 1.8, 2.0, 1.0);
    // On the plane in focus, metres; the picture is `width` wide there.
    let blur = aperture * (focus - distance) / distance;
    let share = |radius: f64| (radius * focus / (focus - distance) / (0.5 * aperture)).powi(2);
    for (name, radius, at, width, truth, samples) in [
        ("the middle", 0.001, 0.0, 0.3 * blur, share(0.001), 4096),
        ("a point inside the rim", 0.001, 0.4 * blur, 0.02 * blur, share(0.001), 4096),
        ("a point outside the rim", 0.001, 0.6 * blur, 0.02 * blur, 0.0, 1024),
        ("all of it", 0.003, 0.0, 2.0 * blur, share(0.003) * PI / 16.0, 8192),
    ] {
        let fov = 2.0 * (0.5 * width / focus).atan();
        // Turned in its place, the camera would not keep the plane in focus: the lamp moves instead.
        let scene = format!(
            "camera {{ position: (0, 0, 0), look_at: (0, 0, -1), fov: {:.9}deg, aperture: f_number(1.8, focal_length: 50mm), focus: 2m }}
            sphere {{ position: ({:.9}, 0, -1), radius: {radius}, material: emitter {{ }} }}",
            fov.to_degrees(),
            0.5 * at
        );
        cases.push(case(
            format!("a disc of light: {name}"),
            &format!("max_bounces: 0, samples: {samples}"),
            scene,
            truth,
            1e-3,
        ));
    }
    check(cases);
}

/// A truth that is off by little is noticed.
#[test]
fn the_test_can_fail() {
    let scene = receiver(DVec3::Y)
        + "quad { position: (0, 1, 0), normal: (0, -1, 0), size: (1, 1), material: emitter { radiance: 2W/m^2/sr } }";
    let truth = 1.02 * 0.752_274_688_5 / PI;
    let caught = std::panic::catch_unwind(|| check(vec![case("a wrong constant", DIRECT, scene, truth, EXACT)]));
    assert!(caught.is_err(), "2 % went unnoticed");
}
