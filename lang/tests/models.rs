//! glTF files in scenes, made here as text: what they become, and what is wrong with broken ones.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use kinora_lang::assets::gltf::{self, LampKind, Projection};
use kinora_lang::diagnostic::Diagnostic;
use kinora_lang::eval::{Overrides, eval};
use kinora_lang::files::Memory;
use kinora_lang::parse;
use kinora_lang::source::{FileId, Source};
use kinora_scene::{Bsdf, Mesh, Scene, Shape, Slot, Texture};
use serde_json::{Value, json};

/// A triangle in the plane z = 0, at (0, 0), (1, 0) and (0, 1): indices as bytes, positions, and uv in one interleaved
/// view with normals as normalized bytes.
fn bytes() -> Vec<u8> {
    let mut bytes = vec![0, 1, 2, 0];
    for p in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        bytes.extend(p.into_iter().flat_map(f32::to_le_bytes));
    }
    for [u, v] in [[0.0_f32, 1.0], [1.0, 1.0], [0.0, 0.25]] {
        bytes.extend([u, v].into_iter().flat_map(f32::to_le_bytes));
        bytes.extend([0, 0, 127, 0]);
        bytes.extend([255, 0, 51, 255]);
    }
    bytes
}

fn document() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "buffers": [{ "uri": "my%20triangle.bin", "byteLength": 88 }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 3 },
            { "buffer": 0, "byteOffset": 4, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 40, "byteLength": 48, "byteStride": 16 },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5121, "count": 3, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC2" },
            { "bufferView": 2, "byteOffset": 8, "componentType": 5120, "normalized": true, "count": 3, "type": "VEC3" },
            { "bufferView": 2, "byteOffset": 12, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4" },
        ],
        "materials": [{ "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0 } }],
        "meshes": [{ "name": "triangle", "primitives": [{
            "attributes": { "POSITION": 1, "TEXCOORD_0": 2, "NORMAL": 3, "COLOR_0": 4 },
            "indices": 0, "material": 0,
        }] }],
        "nodes": [
            { "name": "Arm", "translation": [1, 2, 3], "children": [1] },
            { "name": "Hand", "mesh": 0 },
        ],
        "scenes": [{ "nodes": [0] }],
        "scene": 0,
    })
}

/// A document with parts replaced, by JSON pointer; `null` removes.
fn with(changes: &[(&str, Value)]) -> Value {
    let mut root = document();
    for (pointer, value) in changes {
        let (outer, key) = pointer.rsplit_once('/').unwrap();
        match root.pointer_mut(outer).unwrap() {
            Value::Object(map) if value.is_null() => _ = map.remove(key),
            Value::Object(map) => _ = map.insert(key.to_string(), value.clone()),
            Value::Array(list) => match key.parse::<usize>().unwrap() {
                at if at < list.len() => list[at] = value.clone(),
                _ => list.push(value.clone()),
            },
            _ => unreachable!(),
        }
    }
    root
}

fn read(root: &Value) -> Result<gltf::Model, gltf::Faults> {
    let files = Memory::new([("models/my triangle.bin", bytes().as_slice())]);
    gltf::read("models/m.gltf", root.to_string().as_bytes(), &files)
}

fn evaluate(text: &str, root: &Value) -> Result<(Scene, Vec<Diagnostic>), Vec<Diagnostic>> {
    let model = root.to_string();
    let files = Memory::new([("models/my triangle.bin", bytes().as_slice()), ("models/m.gltf", model.as_bytes())]);
    let source = Source::new(FileId(0), "a.kin", format!("lang 1\nsky {{ color: #fff }}\n{text}"));
    eval(&parse(&source), &files, &Overrides::default()).map(|done| (done.scene, done.warnings))
}

const CAMERA: &str = "camera main { position: (0, 0, 4) }\n";

fn mesh_of(model: &gltf::Model) -> Arc<Mesh> {
    model.nodes.iter().find_map(|part| part.shape.clone()).expect("a mesh").0
}

/// The transform of a scene's node.
fn world(scene: &Scene, name: &str) -> DAffine3 {
    let mut at = scene.nodes.iter().position(|node| node.name == name && node.shape.is_some());
    let mut world = DAffine3::IDENTITY;
    while let Some(node) = at.map(|at| &scene.nodes[at]) {
        let placing = &node.placing;
        let constant = (placing.scale.constant(), placing.rotation.constant(), placing.position.constant());
        let (Some(scale), Some(rotation), Some(position)) = constant else { panic!("it moves") };
        world = DAffine3::from_scale_rotation_translation(*scale, *rotation, *position) * world;
        at = node.parent;
    }
    world
}

#[test]
fn attributes_in_every_storage() {
    let model = read(&document()).unwrap();
    let mesh = mesh_of(&model);
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(mesh.normals, [Vec3::Z; 3]);
    assert_eq!(mesh.uvs, [Vec2::new(0.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.75)]);
    assert_eq!(mesh.colors, [Vec4::new(1.0, 0.0, 0.2, 1.0); 3]);
    assert_eq!(model.warnings.iter().count(), 0);
    // A sparse change of the zeros that stand where there is no view: the second vertex becomes (1, 0, 0).
    let sparse = json!({ "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 0, 0], "sparse": {
        "count": 1,
        "indices": { "bufferView": 3, "componentType": 5121 },
        "values": { "bufferView": 1, "byteOffset": 12 },
    } });
    let view = json!({ "buffer": 0, "byteOffset": 1, "byteLength": 1 });
    // The same view cannot hold vertices and sparse values: positions are these zeros alone.
    let model = read(&with(&[("/accessors/1", sparse), ("/bufferViews/3", view)])).unwrap();
    assert_eq!(mesh_of(&model).positions, [Vec3::ZERO, Vec3::X, Vec3::ZERO]);
}

#[test]
fn strips_and_fans() {
    for (mode, triangles) in [(4, vec![[0, 1, 2]]), (5, vec![[0, 1, 2]]), (6, vec![[0, 1, 2]])] {
        let model = read(&with(&[("/meshes/0/primitives/0/mode", json!(mode))])).unwrap();
        let mesh = mesh_of(&model);
        let corner = |v: u32| mesh.positions[v as usize];
        let normal = |[a, b, c]: [u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a));
        assert_eq!(mesh.triangles.len(), triangles.len());
        assert!(mesh.triangles.iter().all(|t| normal(*t) == Vec3::Z), "mode {mode}");
    }
    let model = read(&with(&[("/meshes/0/primitives/0/mode", json!(1))])).unwrap();
    assert!(model.nodes.iter().all(|part| part.shape.is_none()));
    assert_eq!(model.warnings.iter().map(|(what, ..)| what.as_str()).collect::<Vec<_>>(), ["points and lines"]);
}

#[test]
fn matrices_place_as_they_say() {
    let matrix = [0.5, 0.2, 0.0, 0.0, 0.7, 2.0, -0.3, 0.0, 0.1, 0.4, -1.5, 0.0, 4.0, 5.0, 6.0, 1.0];
    let (scene, warnings) = evaluate(
        &format!("{CAMERA}model m {{ file: \"models/m.gltf\", position: (0, 0, 9) }}"),
        &with(&[("/nodes/1/matrix", json!(matrix))]),
    )
    .unwrap();
    let local = glam::DMat4::from_cols_array(&matrix);
    let world = world(&scene, "Hand");
    for p in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
        let expected = local.transform_point3(p) + DVec3::new(1.0, 2.0, 12.0);
        assert!((world.transform_point3(p) - expected).length() < 1e-9, "{p}");
    }
    assert_eq!(warnings.iter().map(|found| found.code).collect::<Vec<_>>(), ["W0810"]);
}

#[test]
fn a_mesh_used_twice_is_stored_once() {
    let root = with(&[("/nodes/2", json!({ "mesh": 0 })), ("/scenes/0/nodes", json!([0, 2]))]);
    let (scene, _) = evaluate(
        &format!("{CAMERA}model a {{ file: \"models/m.gltf\" }}\nmodel b {{ file: \"models/m.gltf\" }}"),
        &root,
    )
    .unwrap();
    let meshes: Vec<_> = scene
        .nodes
        .iter()
        .filter_map(|node| match &node.shape {
            Some(Shape::Mesh(mesh)) => Some(Arc::as_ptr(mesh)),
            _ => None,
        })
        .collect();
    assert_eq!(meshes.len(), 4);
    assert!(meshes.iter().all(|mesh| *mesh == meshes[0]));
}

#[test]
fn what_refers_into_a_model() {
    let root = with(&[
        ("/cameras", json!([{ "name": "eye", "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }])),
        ("/nodes/0/camera", json!(0)),
    ]);
    let text = "model robot { file: \"models/m.gltf\", override \"Hand\" { material: gold } }\n\
                metal gold { color: #ffd700 }\n\
                sphere held { parent: node(robot, \"Arm/Hand\"), radius: 1cm }\n";
    let (scene, _) = evaluate(text, &root).unwrap();
    // The only camera is the model's.
    let camera = &scene.cameras[scene.camera.unwrap()];
    assert_eq!(
        (&*camera.name, &camera.projection),
        ("robot.eye", &kinora_scene::Projection::Perspective { fov: 0.5.into() })
    );
    let held = world(&scene, "held");
    assert_eq!(held.translation, DVec3::new(1.0, 2.0, 3.0));
    assert!(scene.nodes.iter().enumerate().all(|(at, node)| node.parent.is_none_or(|parent| parent < at)));
    let hand = scene.nodes.iter().find(|node| node.name == "Hand").unwrap();
    assert!(matches!(scene.materials[hand.material].bsdf, Bsdf::Metal { .. }));

    let (scene, _) = evaluate(&format!("{CAMERA}render {{ camera: robot.eye }}\n{text}"), &root).unwrap();
    assert_eq!(scene.cameras[scene.camera.unwrap()].name, "robot.eye");

    let fails = |text: &str, message: &str, help: &str| {
        let found = evaluate(&format!("{CAMERA}{text}"), &root).unwrap_err();
        let code = if text.contains("override") { "E0508" } else { "E0804" };
        let found = found.iter().find(|found| found.code == code).unwrap_or_else(|| panic!("{found:?}"));
        assert_eq!(found.message, message);
        assert!(format!("{found:?}").contains(help), "{found:?}");
    };
    let model = "model robot { file: \"models/m.gltf\" }\n";
    fails(
        &format!("{model}sphere {{ parent: node(robot, \"Arm/Hund\") }}"),
        "model has no node `Arm/Hund`",
        "`Arm/Hand`",
    );
    fails(&format!("{model}render {{ camera: robot.eyes }}"), "no camera `eyes` in the model", "`eye`");
    fails(
        "diffuse a { }\nmodel robot { file: \"models/m.gltf\", override \"Leg\" { material: a } }",
        "model has no node `Leg`",
        "it has `Arm` and `Arm/Hand`",
    );
}

#[test]
fn every_node_is_where_it_is_written() {
    let model = document().to_string();
    let files = Memory::new([("models/my triangle.bin", bytes().as_slice()), ("models/m.gltf", model.as_bytes())]);
    // What moves with a model's node stands before it in the text, and behind it in the scene.
    let text = format!(
        "lang 1\nsky {{ color: #fff }}\n{CAMERA}\
        group g {{ sphere held {{ parent: node(robot, \"Arm/Hand\"), radius: 1cm }} }}\n\
        model robot {{ file: \"models/m.gltf\" }}\n\
        for i in 0..2 {{ box {{ position: (i, 0, 0) }} }}\n"
    );
    let done = eval(&parse(&Source::new(FileId(3), "a.kin", text.clone())), &files, &Overrides::default()).unwrap();
    let (nodes, places) = (&done.scene.nodes, &done.places);
    assert_eq!((places.nodes.len(), places.cameras.len(), places.lights.len()), (nodes.len(), 1, 0));
    for (node, (file, span)) in nodes.iter().zip(&places.nodes) {
        let written = &text[span.start as usize..span.end as usize];
        let expected = match &*node.name {
            "Arm" | "Hand" | "triangle" => "robot",
            name => name,
        };
        assert_eq!((*file, written), (FileId(3), expected), "{}", node.name);
    }
    assert!(
        nodes.iter().any(|node| node.name == "Hand"),
        "{:?}",
        nodes.iter().map(|node| &node.name).collect::<Vec<_>>()
    );
}

#[test]
fn cameras_and_lights() {
    let root = with(&[
        ("/extensionsUsed/1", json!("KHR_lights_punctual")),
        (
            "/extensions",
            json!({ "KHR_lights_punctual": { "lights": [
            { "type": "spot", "intensity": 3, "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.4 } },
            { "type": "directional", "color": [1, 0.5, 0] },
        ] } }),
        ),
        ("/nodes/0/extensions", json!({ "KHR_lights_punctual": { "light": 0 } })),
        ("/nodes/1/extensions", json!({ "KHR_lights_punctual": { "light": 1 } })),
        (
            "/cameras",
            json!([{ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 2, "znear": 0, "zfar": 1 } }]),
        ),
        ("/nodes/1/camera", json!(0)),
    ]);
    let model = read(&root).unwrap();
    let lamps: Vec<_> = model.nodes.iter().filter_map(|part| part.light.clone()).collect();
    assert_eq!(lamps[0].kind, LampKind::Spot([0.1, 0.4]));
    assert_eq!((lamps[0].name.as_str(), lamps[0].intensity), ("Arm", 3.0));
    assert_eq!((lamps[1].kind, lamps[1].color), (LampKind::Sun, [1.0, 0.5, 0.0]));
    let lens = model.nodes.iter().find_map(|part| part.camera.clone()).unwrap();
    assert_eq!(lens.projection, Projection::Orthographic(4.0));
}

const ONE_TEXEL: &str = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP43+AAAARBAcAM0e2RAAAAAElFTkSuQmCC";

#[test]
fn materials_become_trees() {
    let build = |material: Value, extensions: &[&str]| {
        let mut changes = vec![("/materials/0", material)];
        let mut used = vec!["KHR_mesh_quantization"];
        used.extend(extensions);
        changes.push(("/extensionsUsed", json!(used)));
        changes.push(("/images", json!([{ "uri": format!("data:image/png;base64,{ONE_TEXEL}") }])));
        changes.push(("/textures", json!([{ "source": 0 }])));
        let model = read(&with(&changes)).unwrap();
        let root = model.nodes.iter().find_map(|part| part.shape.clone()).unwrap().1;
        (model.materials[root].clone(), model)
    };
    let (material, model) =
        build(json!({ "pbrMetallicRoughness": { "metallicFactor": 0.25, "roughnessFactor": 0.5 } }), &[]);
    let Bsdf::Glossy { base, ior, roughness, metalness, .. } = material.bsdf else { panic!() };
    assert!((ior - 1.5).abs() < 1e-9);
    assert_eq!((roughness.constant(), metalness.constant()), (Some(&0.5), Some(&0.25)));
    // The colours of the vertices scale that of the base.
    let base = &model.materials[base];
    assert!(matches!(*base.maps[0].texture, Texture::VertexColor { .. }) && base.maps[0].slot == Slot::Color);

    let (material, _) = build(
        json!({ "alphaMode": "MASK", "alphaCutoff": 0.3, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.6] } }),
        &[],
    );
    assert_eq!((material.opacity.constant(), material.cutoff), (Some(&0.6), Some(0.3)));

    let strength = json!({ "emissiveFactor": [1, 0.5, 0], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } } });
    let (material, _) = build(strength, &["KHR_materials_emissive_strength"]);
    assert_eq!(material.emission, Vec3::new(8.0, 4.0, 0.0));

    let (material, model) = build(
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": {
            "KHR_materials_transmission": { "transmissionFactor": 0.9 },
            "KHR_materials_ior": { "ior": 1.33 },
            "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [1, 0.5, 0.5] },
            "KHR_materials_clearcoat": { "clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.1 },
        } }),
        &["KHR_materials_transmission", "KHR_materials_ior", "KHR_materials_volume", "KHR_materials_clearcoat"],
    );
    let Bsdf::Glossy { base, .. } = material.bsdf else { panic!("a coat") };
    let Bsdf::Mix { b, ref amount, .. } = model.materials[base].bsdf else { panic!("glass mixed in") };
    assert_eq!(amount.constant(), Some(&0.9));
    let Bsdf::Dielectric { ref ior, attenuation_distance_m, thin, .. } = model.materials[b].bsdf else {
        panic!("glass")
    };
    assert_eq!((ior.constant(), attenuation_distance_m, thin), (Some(&1.33), 2.0, false));

    // F0 = 0.04 / 4: as of an index of 1.1 / 0.9.
    let specular = json!({ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_specular": { "specularFactor": 0.25 } } });
    let (material, _) = build(specular, &["KHR_materials_specular"]);
    let Bsdf::Glossy { ior, .. } = material.bsdf else { panic!() };
    assert!((ior - 1.1 / 0.9).abs() < 1e-9, "{ior}");

    // The brightest channel is part of the index, the others are a tint beside it.
    let tinted = json!({ "pbrMetallicRoughness": { "metallicFactor": 0 }, "extensions": { "KHR_materials_specular": {
        "specularColorFactor": [0.25, 0.125, 0], "specularColorTexture": { "index": 0 } } } });
    let (material, model) = build(tinted, &["KHR_materials_specular"]);
    let Bsdf::Glossy { ior, ref tint, .. } = material.bsdf else { panic!() };
    assert!((ior - 1.1 / 0.9).abs() < 1e-9, "{ior}");
    assert_eq!(tint.constant(), Some(&Vec3::new(1.0, 0.5, 0.0)));
    assert!(material.maps.iter().any(|map| map.slot == Slot::Color), "{:?}", material.maps);
    assert_eq!(model.warnings.iter().count(), 0);

    let brushed = json!({ "extensions": { "KHR_materials_anisotropy": {
        "anisotropyStrength": 0.5, "anisotropyRotation": 0.3, "anisotropyTexture": { "index": 0 } } } });
    let (material, model) = build(brushed, &["KHR_materials_anisotropy"]);
    let Bsdf::Mix { b, .. } = material.bsdf else { panic!("metal mixed in") };
    let Bsdf::Metal { anisotropy, anisotropy_rotation, .. } = model.materials[b].bsdf else { panic!() };
    assert_eq!((anisotropy, anisotropy_rotation), (0.5, 0.3));
    assert!(model.materials[b].maps.iter().any(|map| map.slot == Slot::Stretch));
}

#[test]
fn a_glb_is_the_same() {
    let mut text = with(&[("/buffers/0/uri", Value::Null)]).to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let chunk = |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
    let body = [chunk(b"JSON", text.as_bytes()), chunk(b"BIN\0", &bytes())].concat();
    let glb = [&b"glTF"[..], &2u32.to_le_bytes(), &(12 + body.len() as u32).to_le_bytes(), &body].concat();
    let model = gltf::read("a.glb", &glb, &Memory::default()).unwrap();
    assert_eq!(*mesh_of(&model), *mesh_of(&read(&document()).unwrap()));
    // Cut off anywhere, it is an error and nothing worse.
    for end in (0..glb.len()).step_by(7) {
        assert!(gltf::read("a.glb", &glb[..end], &Memory::default()).is_err(), "{end}");
    }
}

#[test]
fn broken_models_say_where() {
    let nan = f32::NAN.to_le_bytes();
    assert!(nan.len() == 4);
    for (changes, code, at) in [
        (vec![("/nodes/1/mesh", json!(7))], "E0801", "/nodes/1/mesh"),
        (vec![("/meshes/0/primitives/0/indices", json!(1))], "E0801", "/meshes/0/primitives/0/indices"),
        (vec![("/accessors/1/count", json!(4))], "E0803", "/accessors/1"),
        (vec![("/accessors/1/max", json!([5, 1, 0]))], "E0801", "/accessors/1/max/0"),
        (vec![("/accessors/1/max", Value::Null)], "E0801", "/meshes/0/primitives/0/attributes/POSITION"),
        (vec![("/nodes/1/rotation", json!([0, 0, 0.5, 0.5]))], "E0801", "/nodes/1/rotation"),
        (vec![("/nodes/1/children", json!([0]))], "E0801", "/nodes/0"),
        (vec![("/buffers/0/uri", json!("../../../etc/passwd"))], "E0703", "/buffers/0/uri"),
        (vec![("/buffers/0/uri", json!("https://example.com/a.bin"))], "E0704", "/buffers/0/uri"),
        (vec![("/buffers/0/uri", json!("none.bin"))], "E0701", "/buffers/0/uri"),
        (vec![("/buffers/0/byteLength", json!(4096))], "E0801", "/buffers/0"),
        (
            vec![
                ("/extensionsUsed/1", json!("KHR_draco_mesh_compression")),
                ("/extensionsRequired/1", json!("KHR_draco_mesh_compression")),
            ],
            "E0802",
            "/extensionsRequired/1",
        ),
        (
            vec![("/bufferViews/0/byteOffset", json!(1)), ("/bufferViews/0/byteLength", json!(4))],
            "E0803",
            "/meshes/0/primitives/0/indices",
        ),
        (vec![("/asset/version", json!("1.0"))], "E0801", "/asset/version"),
        (vec![("/accessors/0/count", json!(-1))], "E0801", "/accessors/0/count"),
        (vec![("/accessors/1/count", json!(4_000_000_000_u64))], "E0803", "/accessors/1"),
    ] {
        let mut changes: HashMap<&str, Value> = changes.into_iter().collect();
        if code == "E0803" && at.ends_with("indices") {
            // 1, 2, 0 and the first byte of a position.
            changes.insert("/accessors/0/count", json!(3));
            changes.insert("/accessors/1/count", json!(2));
            changes.insert("/accessors/1/max", json!([1, 0, 0]));
            for other in 2..5 {
                let pointer: &'static str =
                    ["/accessors/2/count", "/accessors/3/count", "/accessors/4/count"][other - 2];
                changes.insert(pointer, json!(2));
            }
        }
        let changes: Vec<_> = changes.into_iter().collect();
        let faults = read(&with(&changes)).map(|_| ()).expect_err(at);
        let found: Vec<_> = faults.first().iter().map(|fault| (fault.code, fault.at.as_str())).collect();
        assert!(found.contains(&(code, at)), "{at}: {:?}", faults.first());
    }
    let twice = document().to_string().replacen("\"asset\"", "\"asset\":{\"version\":\"2.0\"},\"asset\"", 1);
    let faults = gltf::read("m.gltf", twice.as_bytes(), &Memory::default()).map(|_| ()).unwrap_err();
    assert!(faults.first()[0].message.contains("twice"), "{faults:?}");
}
