//! A scene that is turned, moved, and scaled as a whole gives the same picture.

use kinora_renderer::Choice;
use kinora_tests::measure::{Kernel, Region, Report};
use kinora_tests::world;

const QUARTERS: &[Region] = &[[0, 0, 8, 8], [8, 0, 16, 8], [0, 8, 8, 16], [8, 8, 16, 16]];

/// Name, `rotation`, `scale`, `position` over `scale`.
const PLACES: &[(&str, &str, f64, [f64; 3])] = &[
    ("as it is", "axis_angle((0, 1, 0), 0deg)", 1.0, [0.0; 3]),
    ("turned", "euler(x: 37deg, y: 71deg, z: -113deg)", 1.0, [0.0; 3]),
    ("large", "axis_angle((0.3, 1, 0.2), 17deg)", 1000.0, [3.0, -2.0, 5.0]),
    ("small", "axis_angle((1, 0.1, 0.7), 211deg)", 0.001, [-4.0, 1.0, 2.0]),
    ("far away", "axis_angle((0.3, -1, 0.2), 77deg)", 1.0, [200.0, -150.0, 90.0]),
    ("small and far away", "euler(x: 10deg, y: 20deg, z: 30deg)", 0.001, [-90.0, 100.0, 200.0]),
];

fn scene(rotation: &str, scale: f64, position: [f64; 3], samples: u32) -> String {
    let [x, y, z] = position.map(|p| p * scale);
    let attenuation = 0.4 * scale;
    let (aperture, focus) = (0.05 * scale, 4.0 * scale);
    format!(
        "lang 1
        render {{ resolution: (16, 16), samples: {samples}, max_bounces: 8, filter: box }}
        fn grey(x: float) -> color {{ return linear(x, x, x) }}
        camera {{ parent: stage, position: (0, 1.2, 4), look_at: (0, 0.4, 0), up: (0, 1, 0), fov: 30deg, aperture: {aperture}, focus: {focus} }}
        sky {{ color: linear(0.3, 0.4, 0.5) }}
        group stage {{
            rotation: {rotation}
            scale: {scale}
            position: ({x}, {y}, {z})
            quad {{ position: (0, -0.1, 0), size: (6, 6), material: diffuse {{ color: linear(0.6, 0.5, 0.4), roughness: 0.5 }} }}
            quad {{ position: (-0.5, 3, 0), normal: (0, -1, 0), size: (2, 1), material: emitter {{ radiance: 5W/m^2/sr }} }}
            sphere {{ position: (-0.7, 0.4, 0), radius: 0.4, material: dielectric {{ attenuation_color: linear(0.9, 0.5, 0.3), attenuation_distance: {attenuation} }} }}
            sphere {{ position: (-0.7, 0.4, 0), radius: 0.2, material: metal {{ color: linear(1, 0.8, 0.4), roughness: 0.4, anisotropy: 0.6, anisotropy_rotation: 40deg }} }}
            box {{ position: (0.3, 0.4, -0.2), size: (0.6, 0.8, 0.5), rotation: rotate_y(30deg), material: glossy {{ color: linear(0.2, 0.5, 0.8), roughness: 0.2 }} }}
            mesh {{ position: (0.9, 0, 0.4), positions: [(0, 0, 0), (0.6, 0, 0), (0, 0.6, 0), (0, 0, 0.6)],
                indices: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], material: dielectric {{ roughness: 0.4 }} }}
            sphere {{ position: (0.3, 0.95, 0.3), radius: 0.15, material: emitter {{ color: linear(6, 3, 1) }} }}
            torus {{ position: (0.3, 0.1, 0.9), radius: 0.25, tube: 0.08, material: diffuse {{ opacity: 0.6 }} }}
        }}"
    )
}

fn check(kernel: &mut Kernel, name: &str, samples: u32, seeds: u32, sharp: f64) {
    let mut report = Report::new((PLACES.len() - 1) * QUARTERS.len());
    let mut truth = Vec::new();
    for &(place, rotation, scale, position) in PLACES {
        let got = kernel.measure(&world(&scene(rotation, scale, position, samples)), QUARTERS, seeds);
        if truth.is_empty() {
            truth = got;
            continue;
        }
        for (i, (got, truth)) in got.iter().zip(&truth).enumerate() {
            report.compare(&format!("{name}: {place}, quarter {i}"), got, truth, 5e-4, sharp);
        }
    }
    report.finish();
}

#[test]
fn cpu() {
    check(&mut Kernel::open(Choice::Cpu), "cpu", 128, 16, 0.03);
}

#[test]
fn on_a_gpu() {
    if let Some(mut kernel) = Kernel::gpu() {
        check(&mut kernel, "gpu", 32, 16, 0.05);
    }
}
