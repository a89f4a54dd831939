//! Codes of a scene as a whole.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0501",
        title: "no camera",
        text: "Something must take the picture.",
        bad: r#"lang 1
sky { color: #fff }
sphere ball { radius: 1 }"#,
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0502",
        title: "several cameras and none chosen",
        text: "Say which one takes the picture.",
        bad: scene!("camera side { position: (4, 0, 0) }"),
        good: scene!(
            r#"camera side { position: (4, 0, 0) }
render { camera: side }"#
        ),
    },
    Row {
        code: "E0503",
        title: "nothing to see",
        text: "The scene has neither a shape nor a sky.",
        bad: r#"lang 1
camera main { position: (0, 0, 4) }"#,
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0504",
        title: "a prefab contains itself without end",
        text: "It may contain itself, if something ends that.",
        bad: scene!(
            r#"prefab tree() { sphere { radius: 1 }  tree { } }
tree { }"#
        ),
        good: scene!(
            r#"prefab tree(depth: int) { sphere { radius: 1 }  if depth > 0 { tree { depth: depth - 1 } } }
tree { depth: 3 }"#
        ),
    },
    Row {
        code: "E0505",
        title: "a node needs itself",
        text: "Two nodes that each move with the other have no place, and two materials that each contain the other \
            are nothing.",
        bad: scene!(
            r#"sphere a { parent: b }
sphere b { parent: a }"#
        ),
        good: scene!(
            r#"sphere a { parent: b }
sphere b { position: (0, 1, 0) }"#
        ),
    },
    Row {
        code: "W0506",
        title: "a light shut in",
        text: "It is inside a closed shape that lets no light out, and the camera is not.",
        bad: scene!(
            r#"box case { }
sphere lamp { radius: 0.1, material: emitter { } }"#
        ),
        good: scene!(
            r#"box case { }
sphere lamp { radius: 0.1, position: (0, 1, 0), material: emitter { } }"#
        ),
    },
    Row {
        code: "E0507",
        title: "a block that may be there only once",
        text: "A scene has one `render` block and one `sky`.",
        bad: scene!(
            r#"render { samples: 16 }
render { max_bounces: 4 }
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"render { samples: 16, max_bounces: 4 }
sphere ball { radius: 1 }"#
        ),
    },
    Row {
        code: "E0508",
        title: "a part of a model that is not there",
        text: "An `override` names a node of the model's file by its path, or by as much of its end as only one of them \
            has; `kinora inspect MODEL` lists them.",
        bad: scene!(
            r#"model robot { file: "robot.gltf", override "Visr" { material: metal { } } }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "nodes": [{ "name": "Visor" }], "scenes": [{ "nodes": [0] }] }"#
        ),
        good: scene!(
            r#"model robot { file: "robot.gltf", override "Visor" { material: metal { } } }
// --- robot.gltf
{ "asset": { "version": "2.0" }, "nodes": [{ "name": "Visor" }], "scenes": [{ "nodes": [0] }] }"#
        ),
    },
    Row {
        code: "W0509",
        title: "glass with holes",
        text: "Where an edge belongs to one triangle only there is a way into the mesh that crosses no surface, so \
            that nobody can tell what is inside.",
        bad: scene!(
            "mesh m { material: dielectric { }, positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [0, 1, 2] }"
        ),
        good: scene!(
            "mesh m { material: dielectric { thin: true }, positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [0, 1, 2] }"
        ),
    },
    Row {
        code: "W0510",
        title: "two flat shapes in one plane",
        text: "Where they overlap, rounding decides at every point which of them is seen.",
        bad: scene!(
            r#"diffuse red { color: #f00 }
plane floor { }
quad mat { material: red }"#
        ),
        good: scene!(
            r#"diffuse red { color: #f00 }
plane floor { }
quad mat { material: red, position: (0, 1mm, 0) }"#
        ),
    },
];
