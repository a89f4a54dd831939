//! Codes of names and the schema.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0201",
        title: "unknown property",
        text: "The kind has no property of that name. Unknown names are never skipped in silence.",
        bad: scene!("sphere ball { raduis: 0.5 }"),
        good: scene!("sphere ball { radius: 0.5 }"),
    },
    Row {
        code: "W0201",
        title: "a name is never used",
        text: "Perhaps another name was meant where this one was to be used. A name that begins with `_` is never \
            reported.",
        bad: scene!(
            r#"let size = 2m
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"let _size = 2m
sphere ball { radius: 1 }"#
        ),
    },
    Row {
        code: "E0202",
        title: "unknown kind",
        text: "A node begins with its kind: a built-in one, or a `prefab` of the file.",
        bad: scene!("spere ball { radius: 1 }"),
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "W0202",
        title: "a name hides another",
        text: "Inside the block the outer value cannot be reached any more.",
        bad: scene!(
            r#"let i = 4
for i in 0..3 { sphere { position: (i, 0, 0) } }
box b { size: (i, 1, 1) }"#
        ),
        good: scene!(
            r#"let n = 4
for i in 0..3 { sphere { position: (i, 0, 0) } }
box b { size: (n, 1, 1) }"#
        ),
    },
    Row {
        code: "E0203",
        title: "unknown name",
        text: "Nothing of that name can be seen from here. Names inside a block are not visible outside it.",
        bad: scene!(
            r#"metal gold { color: #ffd700 }
sphere ball { material: golld }
box b { material: gold }"#
        ),
        good: scene!(
            r#"metal gold { color: #ffd700 }
sphere ball { material: gold }"#
        ),
    },
    Row {
        code: "E0204",
        title: "a node of the wrong sort",
        text: "The name is a node, but not one that can be used here: a camera is no material.",
        bad: scene!("sphere ball { material: main }"),
        good: scene!("sphere ball { material: diffuse { } }"),
    },
    Row {
        code: "E0205",
        title: "a name is declared twice",
        text: "Names in one block are different from each other.",
        bad: scene!(
            r#"sphere ball { radius: 1 }
box ball { size: (1, 1, 1) }"#
        ),
        good: scene!(
            r#"sphere ball { radius: 1 }
box crate { size: (1, 1, 1) }"#
        ),
    },
    Row {
        code: "E0206",
        title: "a property is set twice",
        text: "Each property is set once. The last one does not win, because that would hide a mistake. Two \
            properties that say the same, such as `radiance` and `power` of an `emitter` or `spectrum` and \
            `color` of a `metal`, exclude each other.",
        bad: scene!("sphere ball { radius: 1, radius: 2 }"),
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0207",
        title: "something is missing",
        text: "The node cannot do without this property, or the function without a `return`.",
        bad: scene!("mesh bunny { fit: 1m }"),
        good: scene!("mesh bunny { positions: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [0, 1, 2], fit: 1m }"),
    },
    Row {
        code: "E0208",
        title: "unknown parameter",
        text: "The prefab or function has no parameter of that name.",
        bad: scene!(
            r#"prefab pair(index: int) { sphere { position: (index, 0, 0) } }
pair { indx: 1 , index: 2 }"#
        ),
        good: scene!(
            r#"prefab pair(index: int) { sphere { position: (index, 0, 0) } }
pair { index: 1 }"#
        ),
    },
    Row {
        code: "E0209",
        title: "a parameter is not given",
        text: "A parameter without a default must be given in every call.",
        bad: scene!(
            r#"prefab pair(index: int) { sphere { position: (index, 0, 0) } }
pair { }"#
        ),
        good: scene!(
            r#"prefab pair(index: int = 1) { sphere { position: (index, 0, 0) } }
pair { }"#
        ),
    },
    Row {
        code: "E0210",
        title: "unknown function",
        text: "There is no function of that name, neither built in nor in the file.",
        bad: scene!("sphere ball { radius: sinn(30deg) }"),
        good: scene!("sphere ball { radius: sin(30deg) }"),
    },
    Row {
        code: "E0211",
        title: "wrong number of arguments",
        text: "The function takes more or fewer values.",
        bad: scene!("sphere ball { radius: clamp(2, 1) }"),
        good: scene!("sphere ball { radius: clamp(2, 0.5, 1) }"),
    },
    Row {
        code: "E0212",
        title: "a `let` is used above its line",
        text: "Nodes, prefabs and functions may be used before they are declared; a `let` may not, so that a text \
            reads from top to bottom.",
        bad: scene!(
            r#"sphere ball { radius: r }
let r = 1m"#
        ),
        good: scene!(
            r#"let r = 1m
sphere ball { radius: r }"#
        ),
    },
    Row {
        code: "E0213",
        title: "a value depends on itself",
        text: "To compute the value, the value itself would be needed.",
        bad: scene!(
            r#"let a = b
let b = a
sphere ball { radius: a }"#
        ),
        good: scene!(
            r#"let b = 1m
let a = b
sphere ball { radius: a }"#
        ),
    },
    Row {
        code: "E0214",
        title: "unknown field",
        text: "Vectors have x y z, colours r g b, nodes their properties.",
        bad: scene!(
            r#"let v = (1, 2, 3)
sphere ball { radius: v.q }"#
        ),
        good: scene!(
            r#"let v = (1, 2, 3)
sphere ball { radius: v.x }"#
        ),
    },
    Row {
        code: "E0215",
        title: "something stands in the wrong place",
        text: "Some kinds and declarations belong to the top level, others inside a shape.",
        bad: scene!("group all { render { samples: 16 } }"),
        good: scene!(
            r#"render { samples: 16 }
group all { sphere { radius: 1 } }"#
        ),
    },
    Row {
        code: "E0216",
        title: "a private name of another file",
        text: "Names that start with `_` are for their own file alone, so that it may change them without asking \
            anybody.",
        bad: r#"lang 1
import { _paper } from "std/studio"
camera main { position: (0, 0, 4) }
sky { color: #fff }
sphere { material: _paper }"#,
        good: r#"lang 1
import { white } from "std/cornell"
camera main { position: (0, 0, 4) }
sky { color: #fff }
sphere { material: white }"#,
    },
    Row {
        code: "E0217",
        title: "a name is built in",
        text: "The name already means something, and hiding it would confuse every reader.",
        bad: scene!(
            r#"let time = 3s
sphere ball { radius: time / 3s }"#
        ),
        good: scene!(
            r#"let start = 3s
sphere ball { radius: start / 3s }"#
        ),
    },
];
