//! Codes of the parser and of files.

use super::Row;

const fn row(
    code: &'static str,
    title: &'static str,
    text: &'static str,
    bad: &'static str,
    good: &'static str,
) -> Row {
    Row { code, title, text, bad, good }
}

pub(super) const ROWS: &[Row] = &[
    row(
        "E0101",
        "a `{` is never closed",
        "Every `{` needs a `}`. The braces alone show only at the end of the file that one is missing; the indentation is \
         used to say where it was probably meant.",
        "sphere ball {\n    radius: 1\n\nsphere other { radius: 2 }",
        "sphere ball {\n    radius: 1\n}\n\nsphere other { radius: 2 }",
    ),
    row(
        "E0102",
        "a closing bracket closes nothing",
        "There is one `}`, `)` or `]` more than there are opening ones. Often a block above it was closed too early.",
        "sphere ball { radius: 1 } }",
        "sphere ball { radius: 1 }",
    ),
    row(
        "E0103",
        "a `(` is never closed",
        "Every `(` needs a `)` before the block around it ends.",
        "sphere ball {\n    position: (0, 1, 4\n    radius: 1\n}",
        "sphere ball {\n    position: (0, 1, 4)\n    radius: 1\n}",
    ),
    row("E0104", "a `[` is never closed", "Every `[` needs a `]`.", "let sizes = [1, 2", "let sizes = [1, 2]"),
    row(
        "E0105",
        "a property lacks its `:`",
        "A property is `name: value`; a node is `kind name { ... }`. The line is neither.",
        "sphere ball { radius 0.5 }",
        "sphere ball { radius: 0.5 }",
    ),
    row(
        "E0106",
        "a property uses `=`",
        "Properties are written with `:`. The sign `=` gives a name to a value: `let side = 2m`.",
        "sphere ball { radius = 0.5 }",
        "sphere ball { radius: 0.5 }",
    ),
    row(
        "E0107",
        "`let` or `param` lacks its `=`",
        "The value of a `let` or `param` comes behind `=`. Behind `:` comes its type, which may be left out.",
        "let side: 3",
        "let side = 3",
    ),
    row(
        "E0108",
        "a value is missing",
        "Behind `:`, `=`, an operator and some keywords a value is expected. The next line is read as what it seems to be, \
         so the rest of the scene is checked all the same.",
        "sphere ball {\n    material:\n    radius: 1\n}",
        "sphere ball {\n    material: diffuse { }\n    radius: 1\n}",
    ),
    row(
        "E0109",
        "a string does not end",
        "A string ends on the line where it begins. Line breaks in text are written `\\n`.",
        "model robot { file: \"robot.glb }",
        "model robot { file: \"robot.glb\" }",
    ),
    row(
        "E0110",
        "a comment does not end",
        "A comment that begins with `/*` ends at the first `*/`; such comments do not nest. Use `//` to put single lines \
         aside.",
        "sphere ball { radius: 1 } /* the rest",
        "sphere ball { radius: 1 } /* the rest */",
    ),
    row(
        "E0111",
        "an escape means nothing",
        "In strings, `\\` begins an escape: `\\\"`, `\\\\`, `\\n`, `\\t` or `\\u{1F600}`. Paths are written with `/` on every \
         system.",
        "model robot { file: \"assets\\robot.glb\" }",
        "model robot { file: \"assets/robot.glb\" }",
    ),
    row(
        "E0112",
        "a name starts with a digit",
        "Names begin with a letter or `_`. A node may also have any name in quotes.",
        "sphere 3rd { radius: 1 }",
        "sphere third { radius: 1 }",
    ),
    row(
        "E0113",
        "a keyword is used as a name",
        "Keywords have a meaning of their own and name nothing: `let fn prefab for in if else import from as param return \
         keys ease after like lang true false`. Before `:` they are ordinary names.",
        "let for = 1",
        "let count = 1",
    ),
    row(
        "E0114",
        "a name has a `-` in it",
        "`-` is the sign for minus, so names are joined with `_`.",
        "sphere my-ball { radius: 1 }",
        "sphere my_ball { radius: 1 }",
    ),
    row(
        "E0115",
        "extra comma",
        "One comma stands between two values; one more may stand behind the last.",
        "box b { position: (0,, 1, 2) }",
        "box b { position: (0, 1, 2) }",
    ),
    row(
        "E0116",
        "a number lacks a digit beside its point",
        "A number has a digit on both sides of the point, so that `0..5` is always a range.",
        "sphere ball { radius: .5 }",
        "sphere ball { radius: 0.5 }",
    ),
    row(
        "E0117",
        "a colour has a wrong number of digits",
        "Colours are written with 3, 6 or 8 digits of base 16: `#rgb`, `#rrggbb` or `#rrggbbaa`.",
        "sky { color: #12345 }",
        "sky { color: #123456 }",
    ),
    row(
        "E0118",
        "nothing separates two things",
        "Properties on one line, and values in brackets, are separated by `,`. Between lines no sign is needed.",
        "sphere ball { radius: 1 position: (0, 1, 2) }",
        "sphere ball { radius: 1, position: (0, 1, 2) }",
    ),
    row(
        "E0119",
        "a file is not UTF-8",
        "Scenes are text in UTF-8. Files of other encodings, such as Latin-1 or UTF-16, must be saved anew as UTF-8.",
        "",
        "",
    ),
    row(
        "E0120",
        "a control character is in the text",
        "Characters that are not seen, or that change the order in which text is shown, could make a scene look like \
         another one. They are not allowed anywhere, not even in comments and strings.",
        "sphere ball { radius: 1 } // \u{202E}1 :suidar",
        "sphere ball { radius: 1 }",
    ),
    row(
        "E0121",
        "a character only looks right",
        "Word processors and web pages write curly quotes, typographic minus signs and the like. The language knows only \
         the plain ones.",
        "model robot { file: “robot.glb” }",
        "model robot { file: \"robot.glb\" }",
    ),
    row(
        "E0122",
        "nesting is too deep",
        "Brackets may nest 128 levels deep and expressions 512; beyond that nothing could be read by people, and a program \
         would run out of stack. Split the scene: prefabs for nodes, `let` for values.",
        "",
        "",
    ),
    row(
        "E0123",
        "`else` is followed by neither `{` nor `if`",
        "Another condition is written `else if`, in two words.",
        "if a > 1 { } elseif a > 0 { }",
        "if a > 1 { } else if a > 0 { }",
    ),
    row(
        "E0124",
        "comparisons are chained",
        "A comparison gives true or false, which cannot be compared with a number again. Join two comparisons with `&&`.",
        "let inside = 0 < x < 1",
        "let inside = 0 < x && x < 1",
    ),
    row(
        "E0125",
        "a vector is written with `<` and `>`",
        "Vectors are written in round brackets; `<` and `>` compare values.",
        "sphere ball { position: <0, 1, 0> }",
        "sphere ball { position: (0, 1, 0) }",
    ),
    row(
        "E0126",
        "something is missing",
        "A name, a keyword, a type or a bracket is missing; the message says which and the label says where.",
        "for i 0..3 { }",
        "for i in 0..3 { }",
    ),
    row(
        "E0127",
        "something stands where it cannot",
        "What is there begins no property, node or declaration and continues no value.",
        "let a = 1 2",
        "let a = 1 * 2",
    ),
    row(
        "E0128",
        "a plain value follows a named one",
        "In a call, plain values come first, then those with a name.",
        "let a = clamp(low: 0, 2)",
        "let a = clamp(2, low: 0)",
    ),
    row(
        "E0305",
        "a unit does not exist",
        "The units are mm, cm, m, km, in, ft; ms, s, min, f; deg, rad, turn; g, kg; N, J, W, Hz, K; lm, cd, lx, sr; and %. \
         They stand right behind the number and may be joined: `9.81m/s^2`.",
        "camera main { fov: 40degrees }",
        "camera main { fov: 40deg }",
    ),
    row(
        "E0701",
        "a file does not exist",
        "Paths are relative to the scene that names them, or to the project's folder if they begin with `/`.",
        "",
        "",
    ),
    row(
        "E0703",
        "a path leaves the project",
        "A scene may read files in its project only: the nearest folder above it that holds `kinora.toml`, else its own \
         folder.",
        "",
        "",
    ),
    row(
        "E0704",
        "a path is not of the project",
        "Absolute paths of the system, addresses of the web, drives and devices are not allowed, so that a scene works the \
         same everywhere. Copy the file into the project.",
        "",
        "",
    ),
    row(
        "E0705",
        "a link leaves the project",
        "A symbolic link in the project points out of it. Copy the file into the project.",
        "",
        "",
    ),
    row("E0711", "a file cannot be read", "The file is there, but the system does not give its content.", "", ""),
    row(
        "E0712",
        "a file is too large",
        "A scene may have 64 MiB and a mesh 2 GiB. Large data belongs into meshes and images of their own.",
        "",
        "",
    ),
    row(
        "E1101",
        "not yet",
        "What is written is part of the language, but this version of the program does not know it yet.",
        "",
        "",
    ),
];
