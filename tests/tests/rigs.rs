//! Models that move: clips, skins and morph targets, made here as text and checked against closed forms.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec3, Vec4};
use kinora_lang::files::Memory;
use kinora_scene::{LightKind, Mesh, Shape, World};
use kinora_tests::{scene_of, world_at};
use serde_json::{Value, json};

/// Node, path, interpolation, times, numbers an element, values.
type Channel<'a> = (usize, &'a str, &'a str, &'a [f64], usize, &'a [f64]);

/// A document that grows.
struct Document {
    bytes: Vec<u8>,
    root: Value,
}

impl Document {
    fn new() -> Document {
        let root = json!({
            "asset": { "version": "2.0" },
            "scene": 0, "scenes": [{ "nodes": [0] }],
            "buffers": [], "bufferViews": [], "accessors": [], "nodes": [], "meshes": [],
        });
        Document { bytes: Vec::new(), root }
    }

    fn push(&mut self, array: &str, item: Value) -> usize {
        let list = self.root.as_object_mut().unwrap().entry(array).or_insert(json!([])).as_array_mut().unwrap();
        list.push(item);
        list.len() - 1
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Floats, so many an element.
    fn floats(&mut self, each: usize, numbers: &[f64]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = match each {
            1 => "SCALAR",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let bound = |pick: fn(f64, f64) -> f64| -> Vec<f64> {
            (0..each)
                .map(|c| numbers.iter().skip(c).step_by(each).map(|x| f64::from(*x as f32)).reduce(pick).unwrap())
                .collect()
        };
        let (min, max) = (bound(f64::min), bound(f64::max));
        let count = numbers.len() / each;
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind, "min": min, "max": max }),
        )
    }

    fn joints(&mut self, joints: &[u8]) -> usize {
        let view = self.view(joints);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5121, "count": joints.len() / 4, "type": "VEC4" }),
        )
    }

    /// A clip called so.
    fn clip(&mut self, name: &str, channels: &[Channel<'_>]) {
        let (mut all, mut samplers) = (Vec::new(), Vec::new());
        for (node, path, way, times, each, values) in channels {
            let (input, output) = (self.floats(1, times), self.floats(*each, values));
            all.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": input, "output": output, "interpolation": way }));
        }
        self.push("animations", json!({ "name": name, "channels": all, "samplers": samplers }));
    }

    /// The scene of a text at a time, with the document as `m.gltf`.
    fn at(&mut self, text: &str, millisecond: i64) -> World {
        world_at(&around(text), &self.files(), millisecond)
    }

    fn files(&mut self) -> Memory {
        self.root["buffers"] = json!([{ "uri": "m.bin", "byteLength": self.bytes.len() }]);
        Memory::new([("m.gltf", self.root.to_string().as_bytes()), ("m.bin", self.bytes.as_slice())])
    }

    fn complaints(&mut self, text: &str) -> Vec<(&'static str, String)> {
        use kinora_lang::source::{FileId, Source};
        let text = format!("lang 1\ncamera {{ position: (0, 0, 9) }}\nsky {{ color: #fff }}\n{text}");
        let source = Source::new(FileId(0), "test.kin", text);
        let found = match kinora_lang::eval(&kinora_lang::parse(&source), &self.files(), &Default::default()) {
            Ok(evaluated) => evaluated.warnings,
            Err(found) => found,
        };
        found.into_iter().map(|found| (found.code, format!("{}; {}", found.message, found.helps.join("; ")))).collect()
    }
}

/// A scene with these lines, a frame a millisecond.
fn around(text: &str) -> String {
    format!("lang 1\nrender {{ fps: 1000 }}\ncamera {{ position: (0, 0, 9) }}\nsky {{ color: #fff }}\n{text}")
}

const TRIANGLE: [f64; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
const UP: [f64; 9] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];

fn quarter(axis: DVec3, turns: f64) -> [f64; 4] {
    DQuat::from_axis_angle(axis, turns * FRAC_PI_2).to_array()
}

/// The meshes of a world with where they are.
fn meshes(world: &World) -> Vec<(Arc<Mesh>, DAffine3)> {
    let of = |shape: &Shape<kinora_scene::Still>| match shape {
        Shape::Mesh(mesh) => Some(mesh.clone()),
        _ => None,
    };
    world.instances.iter().filter_map(|one| Some((of(&one.shape)?, one.world_from_object))).collect()
}

fn near(found: Vec3, expected: DVec3, what: impl std::fmt::Debug) {
    assert!((found.as_dvec3() - expected).length() < 2e-6, "{what:?}: {found}, expected {expected}");
}

/// A triangle whose corners follow a joint, another, and both by halves; the joints turn in a second by a quarter about z
/// and by a half about x. Bound where the second joint was at (2, 0, 0).
fn skinned(two_sets: bool, bound: bool) -> Document {
    let mut doc = Document::new();
    let position = doc.floats(3, &TRIANGLE);
    let normal = doc.floats(3, &UP);
    let mut attributes = json!({ "POSITION": position, "NORMAL": normal });
    if two_sets {
        // The third corner's halves are in two sets.
        attributes["JOINTS_0"] = doc.joints(&[0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]).into();
        attributes["WEIGHTS_0"] = doc.floats(4, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0]).into();
        attributes["JOINTS_1"] = doc.joints(&[0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0]).into();
        attributes["WEIGHTS_1"] = doc.floats(4, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0]).into();
    } else {
        attributes["JOINTS_0"] = doc.joints(&[0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]).into();
        attributes["WEIGHTS_0"] = doc.floats(4, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0]).into();
    }
    doc.push("meshes", json!({ "primitives": [{ "attributes": attributes }] }));
    let one = DAffine3::IDENTITY;
    let two = DAffine3::from_translation(DVec3::new(-2.0, 0.0, 0.0));
    let columns = |m: DAffine3| glam::DMat4::from(m).to_cols_array();
    let mut skin = json!({ "joints": [2, 3] });
    if bound {
        skin["inverseBindMatrices"] = doc.floats(16, &[columns(one), columns(two)].concat()).into();
    }
    doc.push("skins", skin);
    // The node of the mesh is somewhere: that does not count.
    doc.push("nodes", json!({ "name": "Root", "children": [1, 2, 3] }));
    doc.push("nodes", json!({ "name": "Body", "mesh": 0, "skin": 0, "translation": [9, 9, 9] }));
    doc.push("nodes", json!({ "name": "First" }));
    doc.push("nodes", json!({ "name": "Second", "translation": [2, 0, 0] }));
    let turn = |axis, turns| [quarter(axis, 0.0), quarter(axis, turns)].concat();
    let (about_z, about_x) = (turn(DVec3::Z, 1.0), turn(DVec3::X, 1.999));
    doc.clip(
        "Bend",
        &[(2, "rotation", "LINEAR", &[0.0, 1.0], 4, &about_z), (3, "rotation", "LINEAR", &[0.0, 1.0], 4, &about_x)],
    );
    doc
}

#[test]
fn skins_follow_their_joints() {
    for (two_sets, bound) in [(false, true), (true, true), (false, false)] {
        let mut doc = skinned(two_sets, bound);
        for ms in [0, 250, 500, 1000, 3000] {
            // Placed and scaled as a whole: the mesh is carried along.
            let world = doc.at("model m { file: \"m.gltf\", clip: \"Bend\", position: (5, 0, 0), scale: 2 }", ms);
            let [(mesh, place)] = &meshes(&world)[..] else { panic!("one mesh") };
            assert_eq!(place.translation, DVec3::new(5.0, 0.0, 0.0));
            let t = (ms as f64 / 1000.0).min(1.0);
            let first = DAffine3::from_axis_angle(DVec3::Z, t * FRAC_PI_2);
            let bind = DAffine3::from_translation(DVec3::new(if bound { -2.0 } else { 0.0 }, 0.0, 0.0));
            let second = DAffine3::from_translation(DVec3::new(2.0, 0.0, 0.0))
                * DAffine3::from_axis_angle(DVec3::X, t * 1.999 * FRAC_PI_2)
                * bind;
            let what = (two_sets, bound, ms);
            near(mesh.positions[0], first.transform_point3(DVec3::ZERO), what);
            near(mesh.positions[1], second.transform_point3(DVec3::X), what);
            let half = (first.transform_point3(DVec3::Y) + second.transform_point3(DVec3::Y)) / 2.0;
            near(mesh.positions[2], half, what);
            near(mesh.normals[0], DVec3::Z, what);
            near(mesh.normals[1], second.transform_vector3(DVec3::Z), what);
            // Of the mean matrix, by its inverse transpose.
            let mean = (first.matrix3 + second.matrix3) * 0.5;
            let normal = mean.inverse().transpose() * DVec3::Z * mean.determinant().signum();
            near(mesh.normals[2], normal.normalize(), what);
        }
        // At rest it is one mesh for all frames and all models.
        let rest = doc.at("model a { file: \"m.gltf\" }\nmodel b { file: \"m.gltf\", position: (3, 0, 0) }", 500);
        let [(a, _), (b, _)] = &meshes(&rest)[..] else { panic!("two meshes") };
        assert!(Arc::ptr_eq(a, b));
    }
}

#[test]
fn what_bends_is_known_at_the_next_frame() {
    let mut doc = skinned(false, true);
    let text = "model m { file: \"m.gltf\", clip: \"Bend\" }\nmodel r { file: \"m.gltf\", position: (3, 0, 0) }";
    let scene = scene_of(&around(text), &doc.files());
    for ms in [0, 250, 999, 1000, 3000] {
        let world = kinora_animator::sample_moving(&scene, scene.clock.shutter_of(ms)).unwrap();
        let [moving, resting] = &world.instances[..] else { panic!("two meshes") };
        let [(now, _), _] = &meshes(&world)[..] else { panic!("two meshes") };
        let [(next, _), _] = &meshes(&doc.at(text, ms + 1))[..] else { panic!("two meshes") };
        // After its last key a clip rests.
        assert_eq!(moving.next_mesh.as_ref(), (ms < 1000).then_some(next), "{ms}");
        assert!(ms >= 1000 || now.positions != next.positions);
        assert_eq!(resting.next_mesh, None);
    }
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let mut doc = Document::new();
    let (position, normal) = (doc.floats(3, &TRIANGLE), doc.floats(3, &UP));
    let tangent = doc.floats(4, &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let lift = doc.floats(3, &[0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]);
    let lean = doc.floats(3, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let twist = doc.floats(3, &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    // A sparse accessor: of zeros, the third is (0, 4, 0).
    let (which, what) = (doc.view(&[2]), doc.view(&[0.0_f32, 4.0, 0.0].map(f32::to_le_bytes).concat()));
    let stretch = doc.push(
        "accessors",
        json!({ "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 4, 0], "sparse": {
            "count": 1,
            "indices": { "bufferView": which, "componentType": 5121 },
            "values": { "bufferView": what },
        } }),
    );
    let primitive = json!({
        "attributes": { "POSITION": position, "NORMAL": normal, "TANGENT": tangent },
        "targets": [{ "POSITION": lift, "NORMAL": lean, "TANGENT": twist }, { "POSITION": stretch }],
    });
    doc.push("meshes", json!({ "primitives": [primitive], "weights": [0.0, 0.25] }));
    doc.push("nodes", json!({ "name": "Face", "mesh": 0 }));
    // Two weights a key.
    doc.clip("Smile", &[(0, "weights", "LINEAR", &[0.0, 2.0], 1, &[0.0, 1.0, 1.0, -1.0])]);
    // in, value, out: from 0 to 1 with a slope of 1 a second at the start.
    let cubic = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    doc.clip("Slowly", &[(0, "weights", "CUBICSPLINE", &[0.0, 2.0], 1, &cubic)]);
    doc.clip("Once", &[(0, "weights", "STEP", &[0.5, 1.0], 1, &[0.0, 0.0, 1.0, 1.0])]);
    let mut check = |clip: &str, ms: i64, a: f64, b: f64| {
        let clip = if clip.is_empty() { String::new() } else { format!("clip: \"{clip}\"") };
        let world = doc.at(&format!("model m {{ file: \"m.gltf\", {clip} }}"), ms);
        let (mesh, _) = &meshes(&world)[0];
        let what = (clip, ms);
        near(mesh.positions[0], DVec3::ZERO, &what);
        near(mesh.positions[1], DVec3::new(1.0, 0.0, 2.0 * a), &what);
        near(mesh.positions[2], DVec3::new(0.0, 1.0 + 4.0 * b, 0.0), &what);
        near(mesh.normals[1], DVec3::new(a, 0.0, 1.0).normalize(), &what);
        near(mesh.tangents[1].truncate(), DVec3::new(1.0, a, 0.0).normalize(), &what);
        assert_eq!(mesh.tangents[1].w, -1.0);
    };
    check("", 700, 0.0, 0.25);
    for (ms, t) in [(0, 0.0), (500, 0.25), (2000, 1.0), (5000, 1.0)] {
        check("Smile", ms, t, 1.0 - 2.0 * t);
    }
    for (ms, t) in [(0, 0.0_f64), (500, 0.25), (1300, 0.65), (2000, 1.0)] {
        // Appendix C.4: the slope at the start counts for two seconds.
        let value = 3.0 * t * t - 2.0 * t.powi(3) + 2.0 * (t.powi(3) - 2.0 * t * t + t);
        check("Slowly", ms, value, 0.0);
    }
    for (ms, a) in [(0, 0.0), (999, 0.0), (1000, 1.0), (1001, 1.0)] {
        check("Once", ms, a, a);
    }
}

/// Nodes that move, turn and grow; a camera, a light and a mesh in them.
fn moving() -> Document {
    let mut doc = Document::new();
    let position = doc.floats(3, &TRIANGLE);
    doc.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": position } }] }));
    doc.push("nodes", json!({ "name": "Arm", "children": [1, 2, 3], "rotation": quarter(DVec3::X, 0.5) }));
    doc.push("nodes", json!({ "name": "Hand", "mesh": 0, "translation": [0, 0, 7] }));
    doc.push("nodes", json!({ "name": "Eye", "camera": 0, "translation": [1, 0, 0] }));
    doc.push(
        "nodes",
        json!({
            "name": "Torch", "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [0, 1, 0],
        }),
    );
    doc.push("cameras", json!({ "name": "eye", "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }));
    doc.root["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    doc.root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "name": "torch", "type": "point" }] } });
    let turn = [quarter(DVec3::Y, 0.0), quarter(DVec3::Y, 1.0)].concat();
    let path =
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0], [4.0, 0.0, 1.0], [0.0, 0.0, 0.0]].concat();
    doc.clip(
        "Wave",
        &[
            (0, "rotation", "LINEAR", &[1.0, 3.0], 4, &turn),
            (1, "translation", "CUBICSPLINE", &[1.0, 3.0], 3, &path),
            (1, "scale", "STEP", &[0.0, 2.0], 3, &[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]),
        ],
    );
    doc.clip("Hide", &[(1, "scale", "LINEAR", &[0.0, 1.0], 3, &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0])]);
    doc
}

#[test]
fn clips_move_nodes() {
    let mut doc = moving();
    let hermite = |t: f64| {
        let (t2, t3) = (t * t, t * t * t);
        DVec3::Z * (2.0 * t3 - 3.0 * t2 + 1.0)
            + 2.0 * (t3 - 2.0 * t2 + t) * DVec3::new(3.0, 0.0, 0.0)
            + DVec3::new(4.0, 0.0, 1.0) * (3.0 * t2 - 2.0 * t3)
            + 2.0 * (t3 - t2) * DVec3::new(0.0, 2.0, 0.0)
    };
    let expected = |seconds: f64| {
        let t = ((seconds - 1.0) / 2.0).clamp(0.0, 1.0);
        let scale = if seconds < 2.0 { 1.0 } else { 2.0 };
        DAffine3::from_rotation_y(t * FRAC_PI_2)
            * DAffine3::from_scale_rotation_translation(DVec3::splat(scale), DQuat::IDENTITY, hermite(t))
    };
    let mut check = |clock: &str, ms: i64, seconds: f64| {
        let world = doc.at(&format!("model m {{ file: \"m.gltf\", clip: \"Wave\", {clock} }}"), ms);
        let (_, place) = meshes(&world)[0];
        assert!(place.abs_diff_eq(expected(seconds), 1e-6), "{clock} at {ms}: {place:?}, {:?}", expected(seconds));
    };
    // Before its first and after its last key each channel holds.
    for ms in [0, 1000, 1500, 1999, 2000, 2600, 3000, 4000] {
        check("", ms, ms as f64 / 1000.0);
    }
    check("clip_time: time - 1s", 2600, 1.6);
    check("clip_time: 2 * time", 1300, 2.6);
    check("clip_time: 2.6s", 7, 2.6);
    check("clip_time: 0s", 7, 0.0);
    check("clip_time: mod(time, 3s)", 7600, 1.6);
    check("clip_time: keys(outside: pingpong) { 0s: 1s  2s: 3s }", 3000, 2.0);
}

#[test]
fn what_moves_with_a_clip() {
    let mut doc = moving();
    let turn = |ms: i64| DAffine3::from_rotation_y(((ms as f64 / 1000.0 - 1.0) / 2.0).clamp(0.0, 1.0) * FRAC_PI_2);
    let text = "model m { file: \"m.gltf\", clip: \"Wave\" }
        sphere s { parent: node(m, \"Arm\"), position: (0, 0, 2) }
        spot_light l { position: (0, 5, 0), look_at: node(m, \"Arm/Hand\"), power: 1W }";
    for ms in [0, 1700, 2500] {
        let world = doc.at(text, ms);
        let sphere = world.instances.iter().find(|one| matches!(one.shape, Shape::Sphere { .. })).unwrap();
        let expected = turn(ms).transform_point3(DVec3::new(0.0, 0.0, 2.0));
        near(sphere.world_from_object.translation.as_vec3(), expected, ms);
        let hand = meshes(&world)[0].1.translation;
        let lights: Vec<&LightKind<_>> = world.lights.iter().map(|lamp| &lamp.light.kind).collect();
        let spot = lights.iter().find_map(|kind| match kind {
            LightKind::Spot { aim: kinora_scene::Beam::Direction(to), .. } => Some(*to),
            _ => None,
        });
        near(spot.unwrap().as_vec3(), (hand - DVec3::new(0.0, 5.0, 0.0)).normalize(), ms);
        let torch = lights.iter().find_map(|kind| match kind {
            LightKind::Point { position, .. } => Some(*position),
            _ => None,
        });
        near(torch.unwrap().as_vec3(), turn(ms).transform_point3(DVec3::Y), ms);
    }
    // Cameras: the model's own, one in a node, one that looks at a node, one on a path.
    let view = |doc: &mut Document, camera: &str, taker: &str, ms: i64| {
        let text = format!(
            "lang 1\nrender {{ fps: 1000, camera: {taker} }}\nsky {{ color: #fff }}\n{camera}
             model m {{ file: \"m.gltf\", clip: \"Wave\" }}"
        );
        world_at(&text, &doc.files(), ms).view.world_from_camera
    };
    for ms in [0, 1700, 2500] {
        let own = view(&mut doc, "", "m.eye", ms);
        assert!(own.abs_diff_eq(turn(ms) * DAffine3::from_translation(DVec3::X), 1e-6), "{ms}");
        let inside = view(&mut doc, "camera c { parent: node(m, \"Arm\"), position: (0, 1, 1) }", "c", ms);
        assert!(inside.abs_diff_eq(turn(ms) * DAffine3::from_translation(DVec3::new(0.0, 1.0, 1.0)), 1e-6), "{ms}");
        let looking = view(&mut doc, "camera c { position: (0, 8, 8), look_at: node(m, \"Hand\") }", "c", ms);
        let hand = meshes(&doc.at("model m { file: \"m.gltf\", clip: \"Wave\" }", ms))[0].1.translation;
        let to = (hand - DVec3::new(0.0, 8.0, 8.0)).normalize();
        near((-looking.matrix3.z_axis).as_vec3(), to, ms);
    }
    let path = "camera c { position: keys(interpolate: spline) { 0s: (0, 2, 8)  1s: (8, 2, 0)  2s: (0, 2, -8) }, look_at: (0, 0, 0) }";
    let on_it = view(&mut doc, path, "c", 1000);
    near(on_it.translation.as_vec3(), DVec3::new(8.0, 2.0, 0.0), "on the path");
    near(-on_it.matrix3.z_axis.as_vec3(), DVec3::new(-8.0, -2.0, 0.0).normalize(), "looking back");
}

#[test]
fn what_has_no_size_is_hidden() {
    let mut doc = moving();
    for (ms, count) in [(0, 1), (999, 1), (1000, 0), (5000, 0)] {
        let world = doc.at("model m { file: \"m.gltf\", clip: \"Hide\" }", ms);
        assert_eq!(meshes(&world).len(), count, "{ms}");
    }
    // At rest of no size, and made larger by a clip.
    doc.root["nodes"][1]["scale"] = json!([0, 0, 0]);
    assert_eq!(meshes(&doc.at("model m { file: \"m.gltf\", clip: \"Wave\" }", 500)).len(), 1);
    assert_eq!(meshes(&doc.at("model m { file: \"m.gltf\" }", 500)).len(), 0);
}

#[test]
fn rotations_are_read_from_whole_numbers() {
    let mut doc = moving();
    let half = (FRAC_PI_2 / 2.0).sin();
    let shorts: Vec<u8> = [0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]
        .iter()
        .flat_map(|x: &f64| ((x * 32767.0).round() as i16).to_le_bytes())
        .collect();
    let view = doc.view(&shorts);
    let output = doc.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5122, "normalized": true, "count": 2, "type": "VEC4" }),
    );
    doc.root["animations"][0]["samplers"][0]["output"] = output.into();
    let world = doc.at(
        "model m { file: \"m.gltf\", clip: \"Wave\" }\nsphere { parent: node(m, \"Arm\"), position: (0, 0, 2) }",
        2000,
    );
    let sphere = world.instances.iter().find(|one| matches!(one.shape, Shape::Sphere { .. })).unwrap();
    let sphere = sphere.world_from_object.translation;
    let expected = DVec3::new((PI / 4.0).sin(), 0.0, (PI / 4.0).cos()) * 2.0;
    assert!((sphere - expected).length() < 2e-4, "{sphere}");
}

#[test]
fn copies_move_by_their_own_clocks() {
    let mut doc = skinned(false, true);
    let text = "model a { file: \"m.gltf\", clip: \"Bend\" }
        model b { file: \"m.gltf\", clip: \"Bend\", clip_time: time + 500ms }
        instance c { of: a, position: (0, 5, 0) }";
    let world = doc.at(text, 250);
    let [(a, _), (b, _)] = &meshes(&world)[..] else { panic!("two meshes") };
    assert_eq!(a.positions.len(), b.positions.len());
    assert_ne!(a.positions, b.positions);
    assert_eq!(world.copies.len(), 1);
    let Shape::Mesh(copied) = &world.parts[0].instances[0].shape else { panic!("a mesh") };
    assert_eq!(copied.positions, a.positions);
}

#[test]
fn mistakes_are_named() {
    let mut doc = moving();
    let (code, text) = doc.complaints("model m { file: \"m.gltf\", clip: \"Wav\" }").remove(0);
    assert_eq!((code, &*text), ("E0804", "no clip `Wav` in the model; did you mean `Wave`?"));
    let (code, text) = doc.complaints("model m { file: \"m.gltf\", clip: \"Jump\" }").remove(0);
    assert_eq!((code, &*text), ("E0804", "no clip `Jump` in the model; it has `Wave` and `Hide`"));
    let (code, text) = doc.complaints("model m { file: \"m.gltf\", clip_time: time }").remove(0);
    assert_eq!(
        (code, &*text),
        ("W0416", "`clip_time` has no effect without `clip`; say which clip plays: `clip: \"...\"`")
    );
    assert_eq!(doc.complaints("model m { file: \"m.gltf\", clip: \"Wave\" }"), []);
    let mut broken = |pointer: &str, value: Value, expected: &str| {
        let whole = doc.root.clone();
        *doc.root.pointer_mut(pointer).unwrap() = value;
        let found = doc.complaints("model m { file: \"m.gltf\" }").remove(0);
        assert!(found.0 == "E0801" && found.1.contains(expected), "{pointer}: {found:?}");
        doc.root = whole;
    };
    let clip = "/animations/0";
    broken(&format!("{clip}/samplers/0/output"), json!(0), "a rotation cannot be a VEC3 of component type 5126");
    broken(&format!("{clip}/samplers/1/interpolation"), json!("LINEAR"), "6 values for 2 times, 2 are expected");
    broken(
        &format!("{clip}/channels/0/target/path"),
        json!("weights"),
        "the node's mesh has no morph targets to weigh",
    );
    broken(&format!("{clip}/channels/0/sampler"), json!(7), "the animation has 3 samplers");
    // Times that stand still, that run backwards, and that begin before the beginning.
    for (times, expected) in [
        ([1.0, 1.0], "the key at 1 s comes after the key at 1 s"),
        ([2.0, 1.0], "the key at 1 s comes after the key at 2 s"),
        ([-1.0, 1.0], "the first key is at -1 s, before the beginning"),
    ] {
        let mut doc = moving();
        doc.root["animations"][0]["samplers"][0]["input"] = doc.floats(1, &times).into();
        let found = doc.complaints("model m { file: \"m.gltf\" }").remove(0);
        assert!(found.0 == "E0801" && found.1.contains(expected), "{found:?}");
    }
}

#[test]
fn tangents_of_vec4_keep_their_sides() {
    // The side of a tangent is not what a skin turns.
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        normals: vec![Vec3::Z; 3],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let influences = kinora_scene::Influences { each: 1, joints: vec![0, 0, 7], weights: vec![2.0, 0.5, 1.0] };
    let turned = mesh.formed(&[], &[], Some((&influences, &[DAffine3::from_rotation_z(FRAC_PI_2)])));
    near(turned.positions[1], DVec3::Y, "weights sum to 1");
    near(turned.tangents[1].truncate(), DVec3::Y, "turned");
    assert_eq!((turned.tangents[1].w, turned.positions[2]), (-1.0, Vec3::Y));
}

#[test]
fn what_a_skin_carries_can_be_made_of_something_else() {
    let mut doc = skinned(false, true);
    let text = "model m { file: \"m.gltf\", clip: \"Bend\", override \"Root/Body\" { material: gold } }
        metal gold { spectrum: \"Au\" }";
    let world = doc.at(text, 300);
    let material = &world.materials[world.instances[0].material];
    assert!(matches!(material.bsdf, kinora_scene::Bsdf::Metal { .. }), "{material:?}");
}
