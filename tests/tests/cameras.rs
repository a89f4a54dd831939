//! Cameras from the text: what they move with and look at, and where a picture shows what they see.

use std::sync::Arc;

use glam::{DVec3, Vec4};
use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_renderer::Choice;
use kinora_scene::{Image, Projection, Scene, Sky, SkyLight, Texels, View};
use kinora_tests::measure::Kernel;
use kinora_tests::world;

/// A turntable with an arm, a camera on the arm's hand, and nothing to see.
const MODEL: &str = r#"{
    "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
    "nodes": [
        { "name": "Table", "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476], "children": [1] },
        { "name": "Arm", "translation": [1, 0, 0], "children": [2] },
        { "name": "Hand", "translation": [0, 2, 0], "scale": [2, 2, 2], "camera": 0 }
    ],
    "cameras": [{ "name": "flat", "type": "orthographic",
        "orthographic": { "xmag": 4, "ymag": 1.5, "zfar": 9, "znear": 0.1 } }]
}"#;

fn scene(text: &str) -> Scene {
    let files = Memory::new([("arm.gltf", MODEL.as_bytes())]);
    let text = format!("lang 1\nsky {{ color: #fff }}\n{text}");
    let source = Source::new(FileId(0), "test.kin", text.as_str());
    match kinora_lang::eval(&kinora_lang::parse(&source), &files, &Default::default()) {
        Ok(evaluated) if evaluated.warnings.is_empty() => evaluated.scene,
        Ok(evaluated) => panic!("{text}\n{:?}", evaluated.warnings),
        Err(found) => panic!("{text}\n{found:?}"),
    }
}

fn view(scene: &Scene, time_s: f64) -> View {
    kinora_animator::sample(scene, scene.clock.shutter_at(time_s)).expect("there is a picture").view
}

/// Where it is, and the way that it looks.
#[track_caller]
fn check(view: &View, eye: DVec3, ahead: DVec3) {
    let place = view.world_from_camera;
    let off = (place.translation - eye).length().max((place.matrix3.z_axis + ahead.normalize()).length());
    assert!(off < 1e-6, "{place:?}, expected {eye} looking along {ahead}");
}

#[test]
fn cameras_move_with_nodes_and_look_at_them() {
    // Both move; the camera is carried by a scaled group that turns, and keeps its own size.
    let moving = scene(
        "group table { rotation: rotate_y(90deg * (time / 1s)), scale: 2 }
        group ball { position: keys { 0s: (0, 1, 0)  1s: (4, 1, -3) } }
        camera { parent: table, position: (0, 1, 2), look_at: ball, fov: 30deg }",
    );
    check(&view(&moving, 0.0), DVec3::new(0.0, 2.0, 4.0), DVec3::new(0.0, -1.0, -4.0));
    check(&view(&moving, 1.0), DVec3::new(4.0, 2.0, 0.0), DVec3::new(0.0, -1.0, -3.0));
    // A camera inside a group, turned by itself.
    let inside = scene("group { position: (1, 0, 0), rotation: rotate_y(90deg)\ncamera { position: (0, 0, 1) } }");
    check(&view(&inside, 0.0), DVec3::new(2.0, 0.0, 0.0), DVec3::NEG_X);
}

#[test]
fn cameras_and_nodes_of_models() {
    let model = "model robot { file: \"arm.gltf\" }\n";
    let hand = DVec3::new(0.0, 2.0, -1.0);
    let on_hand = scene(&format!("{model}camera {{ parent: node(robot, \"Arm/Hand\"), position: (0, 0, 1) }}"));
    check(&view(&on_hand, 0.0), hand + 2.0 * DVec3::X, DVec3::NEG_X);
    let at_hand = scene(&format!(
        "{model}camera {{ look_at: node(robot, \"Table/Arm/Hand\"), position: (0, 2, 3), aperture: 2cm, blades: 7 }}"
    ));
    check(&view(&at_hand, 0.0), DVec3::new(0.0, 2.0, 3.0), DVec3::NEG_Z);
    assert!((view(&at_hand, 0.0).focus_m - 4.0).abs() < 1e-6, "it is focused on what it looks at");
    assert_eq!(view(&at_hand, 0.0).blades.count, 7);
    // Its own camera sees twice its `ymag`, whatever its node is scaled by.
    let own = scene(&format!("{model}render {{ camera: robot.flat }}"));
    check(&view(&own, 0.0), hand, DVec3::NEG_X);
    assert_eq!(view(&own, 0.0).projection, Projection::Orthographic { height_m: 3.0 });
}

/// One lamp, and the pixel of a picture 80 by 40 in whose middle it is.
#[test]
fn points_where_the_text_puts_them() {
    let mut cpu = Kernel::open(Choice::Cpu);
    for (projection, lamp, size, [x, y]) in [
        // Half a height is tan 20° by default.
        ("", "(0.182, 0, -1)", 0.01, [50, 20]),
        ("fov: 2 * atan(0.5)", "(-2.6, 0.6, -4)", 0.05, [13, 13]),
        ("projection: orthographic, height: 4m", "(1.25, 0.65, -70)", 0.05, [52, 13]),
        ("projection: orthographic, height: 4m", "(-3.95, -1.95, -1)", 0.05, [0, 39]),
        // A quarter to the right, half way up; straight behind, at both edges; nearly straight down.
        ("projection: panorama", "(5, 5, 0)", 0.1, [60, 10]),
        ("projection: panorama", "(-0.15, -0.1, 2)", 0.05, [0, 20]),
        ("projection: panorama", "(0.2, -5, -0.2)", 0.05, [50, 39]),
        // Half of all by default: 45° are a quarter of the height.
        ("projection: fisheye", "(3, 0, -3)", 0.1, [50, 20]),
        ("projection: fisheye", "(0, 3, -0.2)", 0.1, [40, 0]),
        ("projection: fisheye, fov: 360deg", "(0, -1, 1)", 0.05, [40, 35]),
    ] {
        let text = format!(
            "lang 1
            render {{ resolution: (80, 40), samples: 16, filter: box, max_bounces: 0 }}
            camera {{ position: (1, 2, 3), rotation: rotate_y(50deg) * rotate_x(10deg), {projection} }}
            group {{
                position: (1, 2, 3)
                rotation: rotate_y(50deg) * rotate_x(10deg)
                sphere {{ position: {lamp}, radius: {size}, material: emitter {{ }} }}
            }}"
        );
        let picture = cpu.picture(&world(&text));
        let light = |i: usize| picture[i].x;
        let brightest = (0..80 * 40).max_by(|a, b| light(*a).total_cmp(&light(*b))).unwrap_or(0);
        // A lamp in the middle of a side of a pixel is as bright in both.
        let (column, row) = (brightest % 80, brightest / 80);
        let near = column.abs_diff(x) <= 1 && row.abs_diff(y) <= 1;
        assert!(light(brightest) > 0.0 && near, "{projection}, {lamp}: at {column}, {row}, expected {x}, {y}");
    }
}

/// A panorama's picture is the sky's, texel by texel; in the mean over a pixel an eighth comes from each neighbour.
#[test]
fn a_panorama_shows_the_sky_as_it_is() {
    let texel = |x: usize, y: usize| [(x * x % 7) as f32, (x * y % 5) as f32, (y + 1) as f32, 1.0];
    let texels = (0..32).map(|i| texel(i % 8, i / 8)).collect();
    let image = Arc::new(Image::new("sky", 8, 4, Texels::Rgba32F(texels)).expect("as many texels"));
    let mut world = world(
        "lang 1
        render { resolution: (8, 4), samples: 1024, filter: box }
        camera { projection: panorama }
        sky { color: #fff }",
    );
    world.sky = Some(Sky { light: SkyLight::Map { image, rotation: 0.0 }, strength: 1.0, visible: true });
    let picture = Kernel::open(Choice::Cpu).picture(&world);
    for (i, got) in picture.iter().enumerate() {
        let (x, y) = (i % 8, i / 8);
        let mut expected = Vec4::ZERO;
        for (column, across) in [((x + 7) % 8, 0.125), (x, 0.75), ((x + 1) % 8, 0.125)] {
            for (row, down) in [(y.saturating_sub(1), 0.125), (y, 0.75), ((y + 1).min(3), 0.125)] {
                expected += across * down * Vec4::from(texel(column, row));
            }
        }
        let off = (*got - expected.truncate().as_dvec3()).abs().max_element();
        assert!(off < 5e-3, "{x}, {y}: {got}, expected {expected}");
    }
}
