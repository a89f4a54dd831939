//! All estimators have the same mean, `clamp` is what the language says, and a lamp near by is no noisier than it has to be.

use kinora_renderer::Choice;
use kinora_tests::measure::{Estimate, Kernel, Region, Report};
use kinora_tests::world;

const GREY: &str = "fn grey(x: float) -> color { return linear(x, x, x) }";
const QUARTERS: &[Region] = &[[0, 0, 6, 6], [6, 0, 12, 6], [0, 6, 6, 12], [6, 6, 12, 12]];

fn measure(kernel: &mut Kernel, render: &str, scene: &str, seeds: u32) -> Vec<Estimate> {
    let text = format!("lang 1\nrender {{ resolution: (12, 12), filter: box, {render} }}\n{GREY}\n{scene}");
    kernel.measure(&world(&text), QUARTERS, seeds)
}

const TECHNIQUES: &[&str] = &[
    "mis: one_sample",
    "mis: one_sample, light_probability: 0",
    "mis: one_sample, light_probability: 0.5",
    "mis: one_sample, light_probability: 0.9",
    "mis: one_sample, light_probability: 1",
    "mis: bsdf",
    "mis: light",
    "sampler: random",
    "roulette_from: 1",
    "roulette_from: 1000",
];

const SCENES: &[(&str, &str)] = &[
    (
        "lamps near and far, small and large",
        "camera { position: (0, 1.5, 4), look_at: (0, 0.3, 0), fov: 35deg }
        sky { color: linear(0.1, 0.2, 0.3) }
        plane { material: diffuse { color: grey(0.5), roughness: 0.5 } }
        sphere { position: (-0.6, 0.4, 0), radius: 0.4, material: glossy { color: linear(0.8, 0.3, 0.2), roughness: 0.3 } }
        sphere { position: (0.6, 0.4, 0), radius: 0.4, material: metal { roughness: 0.4, anisotropy: 0.5 } }
        sphere { position: (0, 0.25, 0.6), radius: 0.2, material: emitter { color: linear(2, 3, 4) } }
        box { position: (0, 3, -1), size: (2, 0.2, 1), rotation: rotate_z(20deg), material: emitter { radiance: 4W/m^2/sr } }
        quad { position: (-1.3, 0.4, 0), normal: (1, 0, 0), size: (0.8, 0.8), material: emitter { color: linear(3, 2, 1), two_sided: true } }",
    ),
    (
        "mirrors, clear and rough glass before lamps",
        "camera { position: (0, 1, 4), look_at: (0, 0.5, 0), fov: 30deg }
        sky { color: linear(0.1, 0.2, 0.3) }
        plane { material: mix(diffuse { color: grey(0.6) }, metal { roughness: 0 }, amount: 0.3) }
        quad { position: (0, 1, -1), normal: (0, 0, 1), size: (3, 1.5), material: emitter { radiance: 3W/m^2/sr } }
        box { position: (-0.5, 0.51, 0), size: (0.6, 0.9, 0.2), rotation: rotate_y(15deg), material: dielectric { roughness: 0.4 } }
        sphere { position: (0.5, 0.5, 0), radius: 0.4, material: dielectric { } }
        quad { position: (0.5, 0.6, 0.7), normal: (0, 0.3, 1), size: (0.5, 0.7), material: dielectric { thin: true, roughness: 0.5 } }
        sphere { position: (-0.4, 0.3, 0.7), radius: 0.25, material: glossy { base: metal { roughness: 0 }, roughness: 0.5 } }",
    ),
    (
        "lamps that are cut out and mixed, in a medium",
        "camera { position: (0, 0.4, 1.4), look_at: (0, 0.3, 0), fov: 60deg }
        box { position: (0, 1, 0), size: (4, 2, 4), material: diffuse { color: grey(0.6) } }
        box { position: (0, 1, 0), size: (3.8, 1.9, 3.8), material: dielectric { ior: 1.3, roughness: 0.7, attenuation_color: grey(0.8), attenuation_distance: 1m } }
        quad { position: (0, 1.8, 0), normal: (0, -1, 0), size: (2, 2), material: emitter { radiance: 4W/m^2/sr, opacity: 0.5 } }
        sphere { position: (-0.7, 0.5, 0), radius: 0.3, material: mix(emitter { color: linear(8, 4, 2) }, glossy { roughness: 0.6 }, amount: 0.5) }
        sphere { position: (0.7, 0.7, 0), radius: 0.3, scale: (1, 1.5, 0.7), material: mix(emitter { color: linear(1, 4, 2) }, metal { roughness: 0.7 }, amount: 0.6) }
        sphere { position: (0, 0.4, 0.2), radius: 0.3, material: diffuse { opacity: 0.6 } }",
    ),
    (
        "lamps of every shape, with pictures",
        "camera { position: (0, 1.5, 4), look_at: (0, 0.5, 0), fov: 35deg }
        plane { material: diffuse { color: grey(0.6) } }
        let squares = checker(linear(6, 1, 2), linear(0.2, 3, 0), scale: 3)
        sphere { position: (-0.8, 0.3, 0), radius: 0.3, material: emitter { color: squares } }
        sphere { position: (-0.8, 1, 0), radius: 0.2, scale: (1, 2, 1), material: emitter { color: squares } }
        torus { position: (0, 0.3, 0), radius: 0.3, tube: 0.1, material: emitter { color: squares, two_sided: true } }
        cylinder { position: (0.8, 0.4, 0), radius: 0.2, height: 0.7, material: mix(emitter { color: squares }, diffuse { color: grey(0.5) }, amount: checker(0, 1, scale: 5)) }
        disk { position: (0, 1.2, -0.3), normal: (0, -0.3, 1), radius: 0.4, material: glossy { base: emitter { color: squares, two_sided: true }, roughness: checker(0.2, 0.7, scale: 2) } }
        cone { position: (0.8, 1.1, 0), radius: 0.2, height: 0.4, material: emitter { color: squares, opacity: checker(1, 0.3, scale: 4) } }
        group { scale: (1, 1, 2), rotation: rotate_y(40deg)
            quad { position: (1, 0.4, 0.6), normal: (1, 0, 1), size: (0.4, 0.4), material: emitter { color: squares, two_sided: true } } }",
    ),
];

#[test]
fn estimators_agree() {
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut gpu = Kernel::gpu();
    let mut report = Report::new(SCENES.len() * (TECHNIQUES.len() + 2) * QUARTERS.len());
    for (scene_name, scene) in SCENES {
        let truth = measure(&mut cpu, "max_bounces: 7, samples: 512", scene, 16);
        let mut judge = |name: &str, got: Vec<Estimate>| {
            for (i, (got, truth)) in got.iter().zip(&truth).enumerate() {
                report.compare(
                    &format!("{scene_name}, {name}, quarter {i}"),
                    got,
                    truth,
                    1e-4,
                    // Light samples alone are noisy where a lobe is narrow.
                    match name {
                        "mis: one_sample" => 0.06,
                        "mis: light" | "mis: one_sample, light_probability: 1" => 0.25,
                        _ => 0.15,
                    },
                );
            }
        };
        for technique in TECHNIQUES {
            let got = measure(&mut cpu, &format!("max_bounces: 7, samples: 256, {technique}"), scene, 16);
            judge(technique, got);
        }
        if let Some(gpu) = &mut gpu {
            for technique in ["mis: nee", "mis: one_sample"] {
                let got = measure(gpu, &format!("max_bounces: 7, samples: 64, {technique}"), scene, 16);
                judge(&format!("gpu, {technique}"), got);
            }
        }
    }
    report.finish();
}

#[test]
fn clamp_is_off_and_biased_low() {
    let mut kernel = Kernel::open(Choice::Cpu);
    // A caustic that only chance finds, and light from near by.
    let scene = SCENES[1].1;
    let open = measure(&mut kernel, "samples: 256", scene, 8);
    let wide = measure(&mut kernel, "samples: 256, clamp: 1e9", scene, 8);
    assert_eq!(open, wide, "a clamp beyond all weights changes the picture");
    let tight = measure(&mut kernel, "samples: 256, clamp: 0.2", scene, 8);
    for (open, tight) in open.iter().zip(&tight) {
        assert!(tight.mean.cmplt(open.mean).all(), "{tight:?} is not below {open:?}");
    }
    // min(1, clamp) · Le where the camera sees a lamp itself.
    let lamp = "camera { position: (0, 0, 3), look_at: (0, 0, 0) } sphere { radius: 3, material: emitter { color: linear(4, 2, 1), two_sided: true } }";
    let seen = measure(&mut kernel, "samples: 16, clamp: 0.25", lamp, 2);
    for seen in seen {
        assert!((seen.mean - glam::DVec3::new(1.0, 0.5, 0.25)).length() < 1e-6, "{seen:?}");
    }
}

/// The relative standard deviation of one sample where the middle of the picture is lit from `height` metres above.
fn noise(kernel: &mut Kernel, lamp: &str, aside: f64) -> f64 {
    let samples = 64;
    let seeds = 24;
    let scene = format!(
        "camera {{ position: ({aside}, -1mm, 3mm), look_at: ({aside}, -5mm, 0), fov: 1deg }}
        quad {{ position: (0, -5mm, 0), size: (1, 1), material: diffuse {{ }} }} {lamp}"
    );
    let got = measure(kernel, &format!("max_bounces: 1, samples: {samples}, sampler: random"), &scene, seeds);
    let relative = |e: &Estimate| e.error.x / e.mean.x * f64::from(samples * seeds * 36).sqrt();
    got.iter().map(relative).fold(0.0, f64::max)
}

/// Sampled by solid angle, a lamp that fills the whole sky leaves the cosine alone to chance: 1/√3 of its mean. Sampled
/// by area, one that is 1 cm away would leave dozens of means.
#[test]
fn a_lamp_near_by_is_as_clean() {
    let mut kernel = Kernel::open(Choice::Cpu);
    let near_limit = 0.45;
    for height in [0.005, 0.05, 0.5, 5.0] {
        let quad = format!(
            "quad {{ position: (0, {height}, 0), normal: (0, -1, 0), size: (0.8, 0.6), material: emitter {{ }} }}"
        );
        let ball = format!("sphere {{ position: (0, {}, 0), radius: 0.3, material: emitter {{ }} }}", height + 0.3);
        let triangle = format!(
            "mesh {{ positions: [(-0.5, {height}, -0.4), (0.5, {height}, -0.4), (0, {height}, 0.6)], indices: [0, 1, 2], material: emitter {{ }} }}"
        );
        for (name, lamp) in [("rectangle", quad), ("sphere", ball), ("triangle", triangle)] {
            for aside in [0.0, 0.1] {
                let relative = noise(&mut kernel, &lamp, aside);
                println!("{name}, {height} m away, {aside} m aside: {relative:.3} of its mean");
                assert!(relative < near_limit, "{name}, {height} m away: {relative} of its mean");
            }
        }
    }
}
