//! Where a texture lies on a shape, read off the pixels of what reflects an even sky: each shows its own colour.

use glam::DVec3;
use kinora_lang::files::Memory;
use kinora_renderer::Choice;
use kinora_tests::measure::Kernel;
use kinora_tests::world_with;

/// What is 2 m wide and lies at z = 0 fills the picture.
const HEAD: &str = "lang 1
render { resolution: (4, 4), filter: box, samples: 4, max_bounces: 1 }
camera { position: (0, 0, 10), look_at: (0, 0, 0), fov: 2 * atan(0.1) }
sky { color: linear(1, 1, 1) }
";

const R: DVec3 = DVec3::X;
const G: DVec3 = DVec3::Y;
const B: DVec3 = DVec3::Z;
/// The sRGB code 128.
const M: DVec3 = DVec3::splat(0.215_860_500);

/// The picture of four texels, the upper two first.
fn files() -> Memory {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(&[255, 0, 0, 0, 255, 0, 0, 0, 255, 128, 128, 128]).expect("four texels");
    writer.finish().expect("an end");
    Memory::new([("four.png", bytes.as_slice())])
}

/// Shapes of the material `m`, and what the rows of the picture show from the top; `None`: not asked.
type Case = (&'static str, &'static str, [[Option<DVec3>; 4]; 4]);

fn rows(rows: [[DVec3; 4]; 4]) -> [[Option<DVec3>; 4]; 4] {
    rows.map(|row| row.map(Some))
}

#[test]
fn textures() {
    let whole = rows([[R, R, G, G], [R, R, G, G], [B, B, M, M], [B, B, M, M]]);
    let middle = [[None; 4], [None, Some(R), Some(G), None], [None, Some(B), Some(M), None], [None; 4]];
    let column = |columns: [[DVec3; 2]; 4]| {
        let row = |i: usize| columns.map(|column| column[i]);
        rows([row(0), row(0), row(1), row(1)])
    };
    let (left, right) = ([R, B], [G, M]);
    let quad = "quad { normal: (0, 0, 1), size: (2, 2), material: m }";
    let image = "image(\"four.png\", filter: nearest)";
    let (black, white) = (DVec3::ZERO, DVec3::ONE);
    let cases: [Case; 10] = [
        (image, quad, whole),
        (image, "box { size: (2, 2, 2), position: (0, 0, -1), material: m }", whole),
        (image, "disk { normal: (0, 0, 1), radius: 1, material: m }", middle),
        (
            image,
            "cylinder { radius: 1, height: 1, position: (0, 0, -0.5), rotation: euler(90deg, 0deg, 0deg), material: m }",
            middle,
        ),
        (
            image,
            "mesh { positions: [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], indices: [0, 1, 2, 0, 2, 3],
                uvs: [(0, 0), (1, 0), (1, 1), (0, 1)], material: m }",
            whole,
        ),
        (
            "image(\"four.png\", filter: nearest, scale: (2, 1), offset: (-1, 0), wrap: repeat)",
            quad,
            column([left, right, left, right]),
        ),
        (
            "image(\"four.png\", filter: nearest, scale: (2, 1), offset: (-1, 0), wrap: mirror)",
            quad,
            column([right, left, left, right]),
        ),
        (
            "image(\"four.png\", filter: nearest, scale: (2, 1), offset: (-1, 0), wrap: clamp)",
            quad,
            column([left, left, left, right]),
        ),
        ("image(\"four.png\", filter: nearest, rotation: 90deg)", quad, column([[B, M], [B, M], [R, G], [R, G]])),
        (
            "checker(#000, #fff, scale: 4)",
            quad,
            rows([[white, black, white, black], [black, white, black, white]].repeat(2).try_into().expect("four rows")),
        ),
    ];
    let files = files();
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut gpu = Kernel::gpu();
    for (texture, shape, expected) in cases {
        let world = world_with(&format!("{HEAD}diffuse m {{ color: {texture} }}\n{shape}"), &files);
        for (name, kernel) in [("cpu", Some(&mut cpu)), ("gpu", gpu.as_deref_mut())] {
            let Some(kernel) = kernel else { continue };
            let picture = kernel.picture(&world);
            for (i, (got, color)) in picture.iter().zip(expected.as_flattened()).enumerate() {
                let Some(color) = color else { continue };
                let difference = (got - color).abs().max_element();
                assert!(difference < 1e-4, "{name}, {texture}, {shape}, pixel {i}: {got}, expected {color}");
            }
        }
    }
}
