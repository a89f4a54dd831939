//! Codes of files, imports and versions.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0701",
        title: "a file does not exist",
        text: "Paths are relative to the scene that names them, or to the project's folder if they begin with `/`.",
        bad: scene!(
            r#"mesh part { file: "prat.obj" }
// --- part.obj
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
        code: "E0702",
        title: "files that import each other in a circle",
        text: "Imports form a tree: a file that needs itself, through whichever others, has no beginning. Move what \
            both need into a third file.",
        bad: r#"lang 1
import "lib/a.kin" as a
camera main { position: (0, 0, 4) }
sky { color: #fff }
sphere ball { material: a.paint }
// --- lib/a.kin
lang 1
import "b.kin" as b
diffuse paint like b.base { }
// --- lib/b.kin
lang 1
import "a.kin" as a
diffuse base { color: #fff }
diffuse other like a.paint { }"#,
        good: r#"lang 1
import "lib/a.kin" as a
camera main { position: (0, 0, 4) }
sky { color: #fff }
sphere ball { material: a.paint }
// --- lib/a.kin
lang 1
import "b.kin" as b
diffuse paint like b.base { }
// --- lib/b.kin
lang 1
diffuse base { color: #fff }"#,
    },
    Row {
        code: "E0703",
        title: "a path leaves the project",
        text: "A scene may read files in its project only: the nearest folder above it that holds `kinora.toml`, \
            else its own folder.",
        bad: scene!(r#"mesh part { file: "../part.obj" }"#),
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
        code: "E0704",
        title: "a path is not of the project",
        text: "Absolute paths of the system, addresses of the web, drives and devices are not allowed, so that a \
            scene works the same everywhere. Copy the file into the project.",
        bad: scene!(r#"mesh part { file: "C:/Users/me/part.obj" }"#),
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
        code: "E0705",
        title: "a link leaves the project",
        text: "A symbolic link in the project points out of it. Copy the file into the project.",
        bad: r#"mesh part { file: "assets/part.ply" } // a link to /home/me/part.ply"#,
        good: r#"mesh part { file: "assets/part.ply" } // the file itself"#,
    },
    Row {
        code: "E0706",
        title: "an imported file has no such name",
        text: "A file offers what its top level declares: nodes, materials, prefabs, functions, values and \
            parameters. What it imports itself it does not pass on.",
        bad: r#"lang 1
import { backdrop } from "std/studio"
camera main { position: (0, 0, 4) }
sky { color: #fff }
backdrop { }"#,
        good: r#"lang 1
import { cyclorama as backdrop } from "std/studio"
camera main { position: (0, 0, 4) }
sky { color: #fff }
backdrop { }"#,
    },
    Row {
        code: "E0707",
        title: "an import or the version below other items",
        text: "The `lang` line is the first item of a file, so that all of it is read as that version means it. Imports \
            come next, so that a reader sees at once what a file needs.",
        bad: scene!(
            r#"sphere ball { material: metals.gold }
import "std/metals" as metals"#
        ),
        good: r#"lang 1
import "std/metals" as metals
camera main { position: (0, 0, 4) }
sky { color: #fff }
sphere ball { material: metals.gold }"#,
    },
    Row {
        code: "E0708",
        title: "a file whose name is written in another case",
        text: "Some systems take `Robot.ply` and `robot.ply` for one file, others for two. Written as it is, the \
            name works on all of them.",
        bad: scene!(
            r#"mesh part { file: "Part.obj" }
// --- part.obj
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
        code: "E0709",
        title: "a version of the language that is not known",
        text: "The first line says for which version the file is written.",
        bad: r#"lang 7
camera main { position: (0, 0, 4) }
sky { color: #fff }"#,
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "W0710",
        title: "no `lang` line",
        text: "The version is written down, so that a file keeps its meaning.",
        bad: r#"camera main { position: (0, 0, 4) }
sky { color: #fff }"#,
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0711",
        title: "a file cannot be read",
        text: "The file is there, but the system does not give its content.",
        bad: r#"mesh part { file: "assets" } // a folder"#,
        good: r#"mesh part { file: "assets/part.ply" }"#,
    },
    Row {
        code: "E0712",
        title: "a file is too large",
        text: "A scene may have 64 MiB and a mesh 2 GiB. Large data belongs into meshes and images of their own.",
        bad: "// a scene of 90 MiB, most of it numbers",
        good: r#"mesh many { file: "many.ply" } // the numbers in a mesh"#,
    },
    Row {
        code: "E0713",
        title: "a project file that cannot be used",
        text: "`kinora.toml` is TOML, and `[lints]` in it says how warnings are taken: a code or `warnings` with \
            the level `allow`, `warn` or `deny`, or a level with a list of codes. Errors cannot be allowed.",
        bad: "# kinora.toml\n[lints]\nW0401 = \"off\"",
        good: "# kinora.toml\n[lints]\nW0401 = \"allow\"",
    },
    Row {
        code: "W0714",
        title: "a key of the project file that means nothing",
        text: "`kinora.toml` may have the table `[lints]`. What is not known is named, so that a typing mistake is \
            found.",
        bad: "# kinora.toml\n[lint]\nW0401 = \"allow\"",
        good: "# kinora.toml\n[lints]\nW0401 = \"allow\"",
    },
];
