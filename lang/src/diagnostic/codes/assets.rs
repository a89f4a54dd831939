//! Codes of meshes, models and pictures.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0801",
        title: "a file that is not what its name says",
        text: "The file is damaged, cut off, or of another format.",
        bad: scene!(
            r#"mesh part { file: "part.txt" }
// --- part.txt
v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3"#
        ),
        good: scene!(
            r#"mesh part { file: "part.obj" }
// --- part.obj
v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3"#
        ),
    },
    Row {
        code: "E0802",
        title: "a model that needs an extension",
        text: "The file says that it cannot be shown without an extension of glTF, and this program does not know \
            it. Most often it is compressed: export it again without.",
        bad: scene!(
            r#"model robot { file: "robot.gltf" }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_draco_mesh_compression"],
  "extensionsRequired": ["KHR_draco_mesh_compression"] }"#
        ),
        good: scene!(
            r#"model robot { file: "robot.gltf" }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "nodes": [{ "name": "Arm" }] }"#
        ),
    },
    Row {
        code: "E0803",
        title: "a mesh that cannot be used",
        text: "An index refers to no vertex, a number is not finite, or there are no triangles.",
        bad: scene!("mesh m { positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [0, 1, 9001] }"),
        good: scene!("mesh m { positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [0, 1, 2] }"),
    },
    Row {
        code: "E0804",
        title: "an unknown part of a model",
        text: "The model's file has no node or camera of that name, or several. Nodes are named by their path, or \
            by as much of its end as only one of them has; `kinora inspect MODEL` lists them.",
        bad: scene!(
            r#"model robot { file: "robot.gltf" }
sphere cup { parent: node(robot, "Hnad") }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "nodes": [{ "name": "Hand" }], "scenes": [{ "nodes": [0] }] }"#
        ),
        good: scene!(
            r#"model robot { file: "robot.gltf" }
sphere cup { parent: node(robot, "Hand") }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "nodes": [{ "name": "Hand" }], "scenes": [{ "nodes": [0] }] }"#
        ),
    },
    Row {
        code: "E0805",
        title: "a picture that cannot be used",
        text: "The file is damaged, cut off, of a kind that is not supported, or has more texels than fit into \
            memory.",
        bad: scene!(
            r#"sphere ball { material: diffuse { color: image("wood.png") } }
// --- wood.png
not a picture"#
        ),
        good: scene!("sphere ball { material: diffuse { color: checker(#b08050, #805030) } }"),
    },
    Row {
        code: "E0806",
        title: "a mesh with too many triangles",
        text: "It would not fit into the memory of most machines.",
        bad: r#"mesh city { file: "city.ply" } // 310 M triangles"#,
        good: r#"mesh city { file: "city_small.ply" } // 90 M triangles"#,
    },
    Row {
        code: "E0807",
        title: "too much for one buffer",
        text: "Textures and meshes of a scene must fit into the buffers of the device.",
        bad: r#"sky { file: "sky.exr" } // 40 000 x 20 000 texels"#,
        good: r#"sky { file: "sky_8k.exr" } // 8192 x 4096 texels"#,
    },
    Row {
        code: "W0808",
        title: "a texture on a mesh without texture coordinates",
        text: "Every point of the mesh shows the same texel.",
        bad: scene!(
            r#"mesh part { file: "part.obj", material: diffuse { color: checker(#b08050, #805030) } }
// --- part.obj
v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3"#
        ),
        good: scene!(
            r#"mesh part { file: "part.obj", material: diffuse { color: checker(#b08050, #805030) } }
// --- part.obj
v 0 0 0
v 1 0 0
v 0 1 0
vt 0 0
vt 1 0
vt 0 1
f 1/1 2/2 3/3"#
        ),
    },
    Row {
        code: "W0809",
        title: "a ratio that is read as a colour",
        text: "Roughness, opacity and the like are numbers: a picture of them is not encoded for a screen.",
        bad: r#"metal steel { roughness: image("rough.png", space: srgb) }"#,
        good: r#"metal steel { roughness: image("rough.png") }"#,
    },
    Row {
        code: "W0810",
        title: "a part of a model that is left out",
        text: "The file has something that this version does not show. The rest of the model is complete.",
        bad: scene!(
            r#"model robot { file: "robot.gltf" }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "extensionsUsed": ["EXT_x"], "nodes": [{ "name": "Hand" }] }"#
        ),
        good: scene!(
            r#"model robot { file: "robot.gltf" }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "nodes": [{ "name": "Hand" }] }"#
        ),
    },
    Row {
        code: "W0811",
        title: "texels that are no light",
        text: "A picture of light may have no negative values, and none that are not finite.",
        bad: r#"sky { file: "sky.exr" } // with texels below 0"#,
        good: r#"sky { file: "sky.exr" } // with none"#,
    },
];
