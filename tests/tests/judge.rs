//! Small scenes, as the kernel renders them and as the independent judge does: region by region, by z-test.

use kinora_renderer::Choice;
use kinora_tests::measure::{Kernel, Region, Report};
use kinora_tests::{reference, world};

struct Case {
    name: &'static str,
    /// What `render` says besides.
    render: &'static str,
    scene: &'static str,
    regions: &'static [Region],
    /// Of the judge, a region.
    paths: u64,
    /// Relative; what the kernel's tables may be off by.
    tolerance: f64,
}

const SIZE: u32 = 16;
const GREY: &str = "fn grey(x: float) -> color { return linear(x, x, x) }";
const SEEDS: u32 = 16;
const HALVES: &[Region] = &[[0, 0, SIZE / 2, SIZE], [SIZE / 2, 0, SIZE, SIZE]];
const THIRDS: &[Region] = &[[0, 0, 5, SIZE], [5, 0, 11, SIZE], [11, 0, SIZE, SIZE]];
const BANDS: &[Region] = &[[0, 0, SIZE, SIZE / 2], [0, SIZE / 2, SIZE, SIZE]];

const CASES: &[Case] = &[
    Case {
        name: "diffuse models",
        render: "max_bounces: 4",
        scene: "
            camera { position: (0, 1.5, 6), look_at: (0, 0.5, 0), fov: 22deg }
            sky { color: linear(0.3, 0.5, 0.8) }
            quad { position: (-1, 3, 1), normal: (0, -1, 0), size: (3, 3), material: emitter { radiance: 3W/m^2/sr } }
            plane { material: diffuse { color: linear(0.6, 0.5, 0.4), roughness: 0.4 } }
            let ball = linear(0.9, 0.6, 0.3)
            sphere { position: (-0.9, 0.5, 0), radius: 0.4, material: diffuse { color: ball, roughness: 0.85 } }
            sphere { position: (0, 0.5, 0), radius: 0.4, material: diffuse { color: ball, roughness: 0.6, model: fon } }
            sphere { position: (0.9, 0.5, 0), radius: 0.4, material: diffuse { color: ball, roughness: 0.5, model: qon } }",
        regions: THIRDS,
        paths: 400_000,
        tolerance: 1e-4,
    },
    Case {
        name: "metals",
        render: "max_bounces: 4",
        scene: "
            camera { position: (0, 0.4, 6), look_at: (0, 0, 0), fov: 22deg }
            sky { color: linear(0.4, 0.4, 0.6) }
            quad { position: (-3, 3, 2), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            let gold = linear(1, 0.78, 0.34)
            sphere { position: (-0.8, 0, 0), radius: 0.4, material: metal { color: gold, edge_tint: linear(0.5, 0.9, 1), roughness: 0.35 } }
            sphere { position: (0, 0, 0), radius: 0.4, material: metal { color: gold, roughness: 0.9 } }
            sphere { position: (0.8, 0, 0), radius: 0.4, material: metal { color: gold, roughness: 0.75, energy_compensation: false } }
            plane { position: (0, -0.4, 0), material: metal { color: grey(0.7), roughness: 0 } }",
        regions: THIRDS,
        paths: 400_000,
        tolerance: 1e-3,
    },
    Case {
        name: "tinted coats, one over another",
        render: "max_bounces: 4",
        scene: "
            camera { position: (0, 1.5, 5), look_at: (0, 0, 0), fov: 24deg }
            sky { color: grey(0.2) }
            quad { position: (-3, 2, 1), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            glossy under { color: linear(0.5, 0.2, 0.1), ior: 2.5, tint: linear(0.2, 1, 0.4), roughness: 0.5 }
            sphere { position: (-0.5, 0, 0), radius: 0.45, material: under }
            quad { position: (0.5, 0, 0), normal: (0.2, 1, 0.3), size: (0.9, 0.9),
                material: glossy { base: under, ior: 2, tint: linear(1, 0.3, 0), roughness: 0.3 } }",
        regions: HALVES,
        paths: 800_000,
        tolerance: 3e-3,
    },
    Case {
        name: "brushed metals",
        render: "max_bounces: 3",
        scene: "
            camera { position: (0, 1.5, 5), look_at: (0, 0, 0), fov: 24deg }
            sky { color: grey(0.2) }
            quad { position: (-3, 2, 1), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            sphere { position: (-0.5, 0, 0), rotation: euler(x: 20deg, y: 40deg, z: 30deg), radius: 0.45,
                material: metal { roughness: 0.5, anisotropy: 0.8 } }
            quad { position: (0.5, 0, 0), normal: (0.2, 1, 0.3), size: (0.9, 0.9),
                material: metal { roughness: 0.6, anisotropy: 0.6, anisotropy_rotation: 35deg } }",
        regions: HALVES,
        paths: 800_000,
        tolerance: 3e-3,
    },
    Case {
        name: "measured metals, and facets along u",
        render: "max_bounces: 3",
        scene: "
            camera { position: (0, 0.5, 6), look_at: (0, 0, 0), fov: 16deg }
            sky { color: linear(0.4, 0.4, 0.6) }
            quad { position: (-3, 3, 2), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            sphere { position: (-0.5, 0, 0), radius: 0.4, material: metal { spectrum: \"Au\", roughness: 0.4 } }
            torus { position: (0, -0.3, 0.2), radius: 0.4, tube: 0.15, material: metal { spectrum: \"Cr\", roughness: 0.7 } }
            mesh { position: (0.2, -0.2, 0), positions: [(0, 0, 0), (0.8, 0.1, -0.3), (0.6, 0.7, -0.5)], uvs: [(0, 0), (0.3, 1), (1, 0.4)],
                indices: [0, 1, 2], material: metal { roughness: 0.5, anisotropy: 0.9, anisotropy_rotation: 20deg } }",
        regions: HALVES,
        paths: 400_000,
        tolerance: 3e-3,
    },
    Case {
        name: "smooth glass that absorbs",
        render: "max_bounces: 12",
        scene: "
            camera { position: (0, 1, 5), look_at: (0, 0.4, 0), fov: 18deg }
            sky { color: linear(0.5, 0.6, 0.7) }
            quad { position: (1, 3, 0), normal: (0, -1, 0), size: (3, 3), material: emitter { radiance: 4W/m^2/sr } }
            plane { material: diffuse { color: linear(0.7, 0.5, 0.3) } }
            sphere { position: (-0.45, 0.4, 0), radius: 0.4,
                material: dielectric { ior: 1.5, attenuation_color: linear(0.9, 0.5, 0.2), attenuation_distance: 50cm } }
            box { position: (0.45, 0.42, 0), size: (0.5, 0.8, 0.5), rotation: rotate_y(30deg),
                material: dielectric { ior: 1.33, attenuation_color: linear(0.2, 0.5, 0.9), attenuation_distance: 1m } }",
        regions: HALVES,
        paths: 400_000,
        tolerance: 1e-4,
    },
    Case {
        name: "rough glass",
        render: "max_bounces: 24",
        scene: "
            camera { position: (0, 0.4, 6), look_at: (0, 0, 0), fov: 22deg }
            sky { color: linear(0.6, 0.7, 0.8) }
            quad { position: (-2, 2, -2), normal: (1, -1, 1), size: (3, 3), material: emitter { radiance: 3W/m^2/sr } }
            sphere { position: (-0.8, 0, 0), radius: 0.4, material: dielectric { roughness: 0.5 } }
            sphere { position: (0, 0, 0), radius: 0.4, material: dielectric { roughness: 0.8, energy_compensation: false } }
            box { position: (0.8, 0, 0), size: (0.6, 0.6, 0.3), rotation: rotate_y(-20deg), material: dielectric { ior: 1.8, roughness: 0.35 } }",
        regions: THIRDS,
        paths: 400_000,
        tolerance: 3e-3,
    },
    Case {
        name: "sheets",
        render: "max_bounces: 8",
        scene: "
            camera { position: (0, 1, 5), look_at: (0, 0.4, 0), fov: 20deg }
            sky { color: linear(0.6, 0.7, 0.8) }
            quad { position: (0, 2, -2), normal: (0, -1, 1), size: (3, 3), material: emitter { radiance: 3W/m^2/sr } }
            plane { material: diffuse { color: grey(0.5) } }
            quad { position: (-0.45, 0.5, 0), normal: (0.3, 0, 1), size: (0.8, 0.9), material: dielectric { ior: 1.7, thin: true } }
            quad { position: (0.45, 0.5, 0), normal: (-0.3, 0.2, 1), size: (0.8, 0.9), material: dielectric { thin: true, roughness: 0.5 } }",
        regions: HALVES,
        paths: 400_000,
        tolerance: 1e-3,
    },
    Case {
        name: "nested media",
        render: "max_bounces: 9",
        scene: "
            camera { position: (0, 1, 5), look_at: (0, 0.5, 0), fov: 16deg }
            sky { color: linear(0.8, 0.7, 0.6) }
            quad { position: (1, 3, 0), normal: (0, -1, 0), size: (3, 3), material: emitter { radiance: 4W/m^2/sr } }
            plane { material: diffuse { color: grey(0.5) } }
            dielectric glass { ior: 1.5, priority: 2, attenuation_color: linear(0.9, 1, 0.9), attenuation_distance: 20cm }
            dielectric water { ior: 1.33, priority: 1, attenuation_color: linear(0.3, 0.6, 0.9), attenuation_distance: 50cm }
            dielectric ice { ior: 1.2, priority: 3 }
            box { position: (0, 0.5, 0), size: (0.9, 0.9, 0.9), material: glass }
            box { position: (0, 0.51, 0), size: (0.7, 0.8, 1), material: water }
            sphere { position: (0.1, 0.9, 0.1), radius: 0.3, material: ice }",
        regions: BANDS,
        paths: 200_000,
        tolerance: 1e-4,
    },
    Case {
        name: "coats",
        render: "max_bounces: 4",
        scene: "
            camera { position: (0, 0.4, 6), look_at: (0, 0, 0), fov: 22deg }
            sky { color: linear(0.4, 0.4, 0.6) }
            quad { position: (-3, 3, 2), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            diffuse clay { color: linear(0.8, 0.4, 0.2), roughness: 0.5 }
            sphere { position: (-0.8, 0, 0), radius: 0.4, material: glossy { base: clay, roughness: 0.4 } }
            sphere { position: (0, 0, 0), radius: 0.4, material: glossy { base: clay, ior: 1.8, roughness: 0.6, metalness: 0.4 } }
            sphere { position: (0.8, 0, 0), radius: 0.4,
                material: glossy { base: metal { color: linear(0.9, 0.6, 0.3), roughness: 0.6 }, roughness: 0 } }",
        regions: THIRDS,
        paths: 400_000,
        tolerance: 2e-3,
    },
    Case {
        name: "coats over coats and glass",
        render: "max_bounces: 16",
        scene: "
            camera { position: (0, 0.4, 6), look_at: (0, 0, 0), fov: 16deg }
            sky { color: linear(0.4, 0.5, 0.6) }
            quad { position: (-3, 3, 2), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            glossy inner { base: diffuse { color: linear(0.8, 0.4, 0.2) }, roughness: 0.5 }
            sphere { position: (-0.5, 0, 0), radius: 0.4, material: glossy { base: inner, ior: 1.7, roughness: 0.7 } }
            sphere { position: (0.5, 0, 0), radius: 0.4, material: glossy { base: dielectric { ior: 1.4 }, roughness: 0.5 } }",
        regions: HALVES,
        paths: 400_000,
        tolerance: 2e-3,
    },
    Case {
        name: "fibres",
        render: "max_bounces: 6",
        scene: "
            camera { position: (0, 0.4, 6), look_at: (0, 0, 0), fov: 22deg }
            sky { color: linear(0.4, 0.5, 0.6) }
            quad { position: (-3, 3, 2), normal: (1, -1, 0), size: (4, 4), material: emitter { color: linear(4, 3, 2) } }
            diffuse clay { color: linear(0.3, 0.1, 0.2) }
            sphere { position: (-0.8, 0, 0), radius: 0.4, material: sheen { base: clay, roughness: 0.3 } }
            sphere { position: (0, 0, 0), radius: 0.4, material: sheen { base: glossy { base: clay }, color: linear(0.9, 0.5, 0.3), roughness: 0.7 } }
            sphere { position: (0.8, 0, 0), radius: 0.4, material: glossy { base: sheen { base: clay, roughness: 1 } } }",
        regions: THIRDS,
        paths: 400_000,
        tolerance: 2e-3,
    },
    Case {
        name: "mixtures and holes",
        render: "max_bounces: 6",
        scene: "
            camera { position: (0, 1, 6), look_at: (0, 0.4, 0), fov: 20deg }
            sky { color: linear(0.3, 0.4, 0.5) }
            quad { position: (0, 3, 0), normal: (0, -1, 0), size: (3, 3), material: emitter { radiance: 3W/m^2/sr } }
            plane { material: diffuse { color: grey(0.5) } }
            diffuse clay { color: linear(0.8, 0.4, 0.2), roughness: 0.5 }
            metal steel { roughness: 0.4 }
            emitter glow { color: linear(0.2, 0.5, 2), two_sided: true }
            sphere { position: (-0.9, 0.4, 0), radius: 0.4, material: mix(mix(clay, steel, amount: 0.3), glow, amount: 0.4) }
            sphere { position: (0, 0.4, 0), radius: 0.4, material: diffuse { color: linear(0.8, 0.4, 0.2), opacity: 0.4 } }
            sphere { position: (0.9, 0.4, 0), radius: 0.4, material: mix(glow, dielectric { }, amount: 0.8) }",
        regions: THIRDS,
        paths: 400_000,
        tolerance: 1e-3,
    },
    Case {
        name: "a camera in rough water",
        render: "max_bounces: 16",
        scene: "
            camera { position: (0, 0, 0.8), look_at: (0, 0, -1), fov: 50deg }
            sky { color: linear(0.3, 0.4, 0.5) }
            quad { position: (1, 3, -2), normal: (0, -1, 0), size: (3, 3), material: emitter { radiance: 3W/m^2/sr } }
            plane { position: (0, -1.5, 0), material: diffuse { color: grey(0.5) } }
            box { size: (2, 2, 2), material: dielectric { ior: 1.33, roughness: 0.4, attenuation_color: linear(0.5, 0.7, 0.9), attenuation_distance: 2m } }
            sphere { position: (0.2, 0.1, -0.2), radius: 0.3, material: diffuse { color: linear(0.8, 0.5, 0.3) } }",
        regions: BANDS,
        paths: 400_000,
        tolerance: 2e-3,
    },
    Case {
        name: "a lens before lamps of all shapes",
        render: "max_bounces: 2",
        scene: "
            camera { position: (0, 0.5, 4), look_at: (0, 0.3, 0), fov: 30deg, aperture: 40cm, focus: 3.5m, blades: 5, blade_rotation: 20deg }
            plane { material: diffuse { color: grey(0.6) } }
            box { position: (-0.8, 0.4, 0), size: (0.4, 0.3, 0.5), rotation: euler(x: 20deg, y: 40deg, z: 0deg),
                material: emitter { color: linear(3, 1, 1) } }
            sphere { position: (0, 0.5, -0.4), radius: 0.5, scale: (1, 0.5, 0.7), rotation: rotate_z(30deg),
                material: emitter { color: linear(1, 3, 1), power: 6W } }
            mesh { position: (0.8, 0.2, 0.2), scale: (-1, 1, 0.7), positions: [(0, 0, 0), (0.6, 0, 0), (0, 0.6, 0), (0, 0, 0.6)],
                indices: [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3], material: emitter { color: linear(1, 1, 4), power: 3W } }
            quad { position: (0, 1.2, 0.5), normal: (1, 2, 0.5), size: (0.5, 0.3), material: emitter { power: 2W, two_sided: true } }",
        regions: THIRDS,
        paths: 1_000_000,
        tolerance: 1e-4,
    },
    Case {
        name: "a room, two bounces and many",
        render: "max_bounces: 2",
        scene: "
            camera { position: (0, 1, 0.95), look_at: (0, 0.9, -1), fov: 70deg }
            box { position: (0, 1, 0), size: (2, 2, 2), material: diffuse { color: linear(0.8, 0.6, 0.4) } }
            box { position: (0.4, 0.3, -0.3), size: (0.6, 0.6, 0.6), rotation: rotate_y(25deg), material: diffuse { color: grey(0.5) } }
            quad { position: (0, 1.9, 0), normal: (0, -1, 0), size: (1, 1), material: emitter { radiance: 5W/m^2/sr } }",
        regions: BANDS,
        paths: 1_000_000,
        tolerance: 1e-4,
    },
    Case {
        name: "shading normals",
        render: "max_bounces: 3",
        scene: "
            camera { position: (0, 1, 3), look_at: (0, 0.2, 0), fov: 30deg }
            sky { color: linear(0.3, 0.4, 0.5) }
            quad { position: (1, 3, 0), normal: (0, -1, 0), size: (3, 3), material: emitter { radiance: 3W/m^2/sr } }
            mesh { rotation: rotate_y(20deg), positions: [(0.6, 0, 0.6), (0.6, 0, -0.6), (-0.6, 0, -0.6), (-0.6, 0, 0.6), (0, 0.7, 0)],
                normals: [(1, 0.5, 1), (1, 0.5, -1), (-1, 0.5, -1), (-1, 0.5, 1), (0, 1, 0)],
                indices: [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4], material: diffuse { color: linear(0.8, 0.5, 0.3) } }",
        regions: HALVES,
        paths: 400_000,
        tolerance: 1e-3,
    },
];

/// The GPU's share of the cases: it may be a program on the same processor.
const GPU_EVERY: usize = 3;

#[test]
fn kernel_and_judge_agree() {
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut gpu = Kernel::gpu();
    let mut report = Report::new(2 * CASES.iter().map(|case| case.regions.len()).sum::<usize>());
    for (i, case) in CASES.iter().enumerate() {
        let render = format!("render {{ resolution: ({SIZE}, {SIZE}), filter: box, {} }}", case.render);
        let mut world = world(&format!("lang 1\n{render}\n{GREY}\n{}", case.scene));
        let truth: Vec<_> = case.regions.iter().map(|r| reference::measure(&world, *r, case.paths, 1)).collect();
        let gpu = gpu.as_deref_mut().filter(|_| i % GPU_EVERY == 0);
        for (name, kernel, samples, sharp) in [("cpu", Some(&mut cpu), 128, 0.02), ("gpu", gpu, 32, 0.03)] {
            let Some(kernel) = kernel else { continue };
            world.render.samples = samples;
            for (i, (got, truth)) in kernel.measure(&world, case.regions, SEEDS).iter().zip(&truth).enumerate() {
                let name = format!("{name}: {}, region {i}", case.name);
                report.compare(&name, got, truth, case.tolerance, sharp);
            }
        }
    }
    report.finish();
}
