//! What cameras move with and look at, from the text to where they are.

use glam::DVec3;
use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_scene::{Projection, Scene, View};

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
