//! Codes of limits.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E1001",
        title: "calls without end",
        text: "A function may call itself, if a condition ends that; and values may depend on values, but not in a \
            chain of thousands.",
        bad: scene!(
            r#"fn f(n: int) = f(n + 1)
sphere ball { radius: f(0) }"#
        ),
        good: scene!(
            r#"fn f(n: int) = if n > 3 { 1m } else { f(n + 1) }
sphere ball { radius: f(0) }"#
        ),
    },
    Row {
        code: "E1002",
        title: "a loop with too many turns",
        text: "Loops are counted before they run.",
        bad: scene!("for i in 0..1e9 { sphere { position: (i, 0, 0) } }"),
        good: scene!("for i in 0..9 { sphere { position: (i, 0, 0) } }"),
    },
    Row {
        code: "E1003",
        title: "too many steps",
        text: "An evaluation ends after a fixed number of steps, so that every scene loads in seconds.",
        bad: scene!(
            r#"fn f(n: int) = sum([for i in 0..1000: i * n])
let many = [for i in 0..100000: f(i)]
sphere ball { radius: many[0] }"#
        ),
        good: scene!(
            r#"fn f(n: int) = sum([for i in 0..10: i * n])
let many = [for i in 1..10: f(i)]
sphere ball { radius: many[0] }"#
        ),
    },
    Row {
        code: "E1004",
        title: "too many nodes or items",
        text: "A scene has at most a million nodes, a list a million items, a text 64 KiB.",
        bad: scene!("for i in 0..1000000 { sphere { }  sphere { } }"),
        good: scene!("for i in 0..10 { sphere { }  sphere { } }"),
    },
    Row {
        code: "E1005",
        title: "too many files",
        text: "A scene has at most 256 files, and they import one another at most 32 deep.",
        bad: r#"import "a1.kin" as a // which imports a2.kin, which imports a3.kin, and so on to a40.kin"#,
        good: r#"import "a.kin" as a // with all of it"#,
    },
    Row {
        code: "E1006",
        title: "more than fits into memory",
        text: "What a scene takes while it is rendered is known before: triangles where they are written out, nodes, copies \
            and pictures. The limit is what is free on the machine, or 8 GiB if that is more.",
        bad: "for i in 0..1000 { mesh { file: \"a_million_triangles.ply\", position: (i, 0, 0) } }",
        good: r#"mesh tree { file: "a_million_triangles.ply" }
for i in 1..1000 { instance { of: tree, position: (i, 0, 0) } }"#,
    },
    Row {
        code: "E1007",
        title: "a bug in the tool",
        text: "The tool contradicts itself. It is not the fault of the scene.",
        bad: "// no scene should get it",
        good: "// report it, with the scene that does",
    },
];
