//! Codes of the parser.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0101",
        title: "a `{` is never closed",
        text: "Every `{` needs a `}`. The braces alone show only at the end of the file that one is missing; the \
            indentation is used to say where it was probably meant.",
        bad: scene!(
            r#"sphere ball {
    radius: 1

box crate { size: (1, 2, 1) }"#
        ),
        good: scene!(
            r#"sphere ball {
    radius: 1
}

box crate { size: (1, 2, 1) }"#
        ),
    },
    Row {
        code: "E0102",
        title: "a closing bracket closes nothing",
        text: "There is one `}`, `)` or `]` more than there are opening ones. Often a block above it was closed too \
            early.",
        bad: scene!("sphere ball { radius: 1 } }"),
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0103",
        title: "a `(` is never closed",
        text: "Every `(` needs a `)` before the block around it ends.",
        bad: scene!(
            r#"sphere ball {
    position: (0, 1, 4
    radius: 1
}"#
        ),
        good: scene!(
            r#"sphere ball {
    position: (0, 1, 4)
    radius: 1
}"#
        ),
    },
    Row {
        code: "E0104",
        title: "a `[` is never closed",
        text: "Every `[` needs a `]`.",
        bad: scene!(
            r#"let sizes = [1, 2
sphere ball { radius: sizes[0] }"#
        ),
        good: scene!(
            r#"let sizes = [1, 2]
sphere ball { radius: sizes[0] }"#
        ),
    },
    Row {
        code: "E0105",
        title: "a property lacks its `:`",
        text: "A property is `name: value`; a node is `kind name { ... }`. The line is neither.",
        bad: scene!("sphere ball { radius 0.5 }"),
        good: scene!("sphere ball { radius: 0.5 }"),
    },
    Row {
        code: "E0106",
        title: "a property uses `=`",
        text: "Properties are written with `:`. The sign `=` gives a name to a value: `let side = 2m`.",
        bad: scene!("sphere ball { radius = 0.5 }"),
        good: scene!("sphere ball { radius: 0.5 }"),
    },
    Row {
        code: "E0107",
        title: "`let` or `param` lacks its `=`",
        text: "The value of a `let` or `param` comes behind `=`. Behind `:` comes its type, which may be left out.",
        bad: scene!(
            r#"let side: 3
sphere ball { radius: side }"#
        ),
        good: scene!(
            r#"let side = 3
sphere ball { radius: side }"#
        ),
    },
    Row {
        code: "E0108",
        title: "a value is missing",
        text: "Behind `:`, `=`, an operator and some keywords a value is expected. The next line is read as what it \
            seems to be, so the rest of the scene is checked all the same.",
        bad: scene!(
            r#"sphere ball {
    material:
    radius: 1
}"#
        ),
        good: scene!(
            r#"sphere ball {
    material: diffuse { }
    radius: 1
}"#
        ),
    },
    Row {
        code: "E0109",
        title: "a string does not end",
        text: "A string ends on the line where it begins. Line breaks in text are written `\\n`.",
        bad: scene!(
            r#"metal gold { spectrum: "Au }
sphere ball { material: gold }"#
        ),
        good: scene!(
            r#"metal gold { spectrum: "Au" }
sphere ball { material: gold }"#
        ),
    },
    Row {
        code: "E0110",
        title: "a comment does not end",
        text: "A comment that begins with `/*` ends at the first `*/`; such comments do not nest. Use `//` to put \
            single lines aside.",
        bad: scene!("sphere ball { radius: 1 } /* the rest"),
        good: scene!("sphere ball { radius: 1 } /* the rest */"),
    },
    Row {
        code: "E0111",
        title: "an escape means nothing",
        text: "In strings, `\\` begins an escape: `\\\"`, `\\\\`, `\\n`, `\\t` or `\\u{1F600}`. Paths are written \
            with `/` on every system.",
        bad: scene!(
            r#"mesh part { file: "assets\part.obj" }
// --- assets/part.obj
v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3"#
        ),
        good: scene!(
            r#"mesh part { file: "assets/part.obj" }
// --- assets/part.obj
v 0 0 0
v 1 0 0
v 0 1 0
f 1 2 3"#
        ),
    },
    Row {
        code: "E0112",
        title: "a name starts with a digit",
        text: "Names begin with a letter or `_`. A node may also have any name in quotes.",
        bad: scene!("sphere 3rd { radius: 1 }"),
        good: scene!("sphere third { radius: 1 }"),
    },
    Row {
        code: "E0113",
        title: "a keyword is used as a name",
        text: "Keywords have a meaning of their own and name nothing: `let fn prefab for in if else import from as \
            param return keys ease after like lang true false`. Before `:` they are ordinary names.",
        bad: scene!(
            r#"let for = 1
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"let count = 1
sphere ball { radius: count }"#
        ),
    },
    Row {
        code: "E0114",
        title: "a name has a `-` in it",
        text: "`-` is the sign for minus, so names are joined with `_`.",
        bad: scene!("sphere my-ball { radius: 1 }"),
        good: scene!("sphere my_ball { radius: 1 }"),
    },
    Row {
        code: "E0115",
        title: "extra comma",
        text: "One comma stands between two values; one more may stand behind the last.",
        bad: scene!("box b { position: (0,, 1, 2) }"),
        good: scene!("box b { position: (0, 1, 2) }"),
    },
    Row {
        code: "E0116",
        title: "a number lacks a digit beside its point",
        text: "A number has a digit on both sides of the point, so that `0..5` is always a range.",
        bad: scene!("sphere ball { radius: .5 }"),
        good: scene!("sphere ball { radius: 0.5 }"),
    },
    Row {
        code: "E0117",
        title: "a colour has a wrong number of digits",
        text: "Colours are written with 3, 6 or 8 digits of base 16: `#rgb`, `#rrggbb` or `#rrggbbaa`.",
        bad: scene!("sphere ball { material: diffuse { color: #12345 } }"),
        good: scene!("sphere ball { material: diffuse { color: #123456 } }"),
    },
    Row {
        code: "E0118",
        title: "nothing separates two things",
        text: "Properties on one line, and values in brackets, are separated by `,`. Between lines no sign is \
            needed.",
        bad: scene!("sphere ball { radius: 1 position: (0, 1, 2) }"),
        good: scene!("sphere ball { radius: 1, position: (0, 1, 2) }"),
    },
    Row {
        code: "E0119",
        title: "a file is not UTF-8",
        text: "Scenes are text in UTF-8. Files of other encodings, such as Latin-1 or UTF-16, must be saved anew as \
            UTF-8.",
        bad: "// a scene that an editor saved as Latin-1 or UTF-16",
        good: "// the same scene, saved as UTF-8",
    },
    Row {
        code: "E0120",
        title: "a control character is in the text",
        text: "Characters that are not seen, or that change the order in which text is shown, could make a scene \
            look like another one. They are not allowed anywhere, not even in comments and strings. Lines end with a \
            line feed, with or without a carriage return before it; a carriage return alone ends none.",
        bad: scene!("sphere ball { radius: 1 } // \u{202E}1 :suidar"),
        good: scene!("sphere ball { radius: 1 } // radius: 1"),
    },
    Row {
        code: "E0121",
        title: "a character only looks right",
        text: "Word processors and web pages write curly quotes, typographic minus signs and the like. The language \
            knows only the plain ones.",
        bad: scene!(
            r#"metal gold { spectrum: “Au” }
sphere ball { material: gold }"#
        ),
        good: scene!(
            r#"metal gold { spectrum: "Au" }
sphere ball { material: gold }"#
        ),
    },
    Row {
        code: "E0122",
        title: "nesting is too deep",
        text: "Brackets may nest 128 levels deep and expressions 512; beyond that nothing could be read by people, \
            and a program would run out of stack. Split the scene: prefabs for nodes, `let` for values.",
        bad: scene!(
            "sphere ball { radius: ((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((1)))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))) }"
        ),
        good: scene!("sphere ball { radius: (1) }"),
    },
    Row {
        code: "E0123",
        title: "`else` is followed by neither `{` nor `if`",
        text: "Another condition is written `else if`, in two words.",
        bad: scene!(
            r#"let a = 2
if a > 3 { sphere ball { radius: 1 } } elseif a > 1 { box crate { } }"#
        ),
        good: scene!(
            r#"let a = 2
if a > 3 { sphere ball { radius: 1 } } else if a > 1 { box crate { } }"#
        ),
    },
    Row {
        code: "E0124",
        title: "comparisons are chained",
        text: "A comparison gives true or false, which cannot be compared with a number again. Join two comparisons \
            with `&&`.",
        bad: scene!(
            r#"let x = 0.5
sphere ball { visible: 0 < x < 1 }"#
        ),
        good: scene!(
            r#"let x = 0.5
sphere ball { visible: 0 < x && x < 1 }"#
        ),
    },
    Row {
        code: "E0125",
        title: "a vector is written with `<` and `>`",
        text: "Vectors are written in round brackets; `<` and `>` compare values.",
        bad: scene!("sphere ball { position: <0, 1, 0> }"),
        good: scene!("sphere ball { position: (0, 1, 0) }"),
    },
    Row {
        code: "E0126",
        title: "something is missing",
        text: "A name, a keyword, a type or a bracket is missing; the message says which and the label says where.",
        bad: scene!("for i 0..3 { sphere { position: (i, 0, 0), radius: 0.3 } }"),
        good: scene!("for i in 0..3 { sphere { position: (i, 0, 0), radius: 0.3 } }"),
    },
    Row {
        code: "E0127",
        title: "something stands where it cannot",
        text: "What is there begins no property, node or declaration and continues no value.",
        bad: scene!(
            r#"let a = 1 2
sphere ball { radius: a }"#
        ),
        good: scene!(
            r#"let a = 1 * 2
sphere ball { radius: a }"#
        ),
    },
    Row {
        code: "E0128",
        title: "a plain value follows a named one",
        text: "In a call, plain values come first, then those with a name.",
        bad: scene!("sphere ball { radius: clamp(low: 0, 2, 1) }"),
        good: scene!("sphere ball { radius: clamp(0, 2, 1) }"),
    },
];
