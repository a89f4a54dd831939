//! Codes of types and units.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0301",
        title: "a value of the wrong type",
        text: "The property or operator takes something else.",
        bad: scene!(r#"sphere ball { radius: "big" }"#),
        good: scene!("sphere ball { radius: 2m }"),
    },
    Row {
        code: "E0302",
        title: "a number of the wrong dimension",
        text: "Lengths, angles and times do not stand for one another.",
        bad: scene!("sphere ball { radius: 30deg }"),
        good: scene!("sphere ball { radius: 30cm }"),
    },
    Row {
        code: "E0303",
        title: "an operator between values that do not fit",
        text: "Only numbers of one dimension can be added or compared; products and quotients have a dimension of \
            their own.",
        bad: scene!(
            r#"let size = 1m + 2s
sphere ball { radius: size }"#
        ),
        good: scene!(
            r#"let size = 1m + 2cm
sphere ball { radius: size }"#
        ),
    },
    Row {
        code: "E0304",
        title: "a number lacks its unit",
        text: "A bare number would be guessed: 40 degrees or 40 radians? Lengths alone may be bare, in metres; and \
            0 is 0 in every unit.",
        bad: scene!(
            r#"camera side { position: (4, 0, 0), fov: 40 }
render { camera: side }"#
        ),
        good: scene!(
            r#"camera side { position: (4, 0, 0), fov: 40deg }
render { camera: side }"#
        ),
    },
    Row {
        code: "E0305",
        title: "a unit does not exist",
        text: "The units are mm, cm, m, km, in, ft; ms, s, min, f; deg, rad, turn; g, kg; N, J, W, Hz, K; lm, cd, \
            lx, sr; and %. They stand right behind the number and may be joined: `9.81m/s^2`.",
        bad: scene!(
            r#"camera side { fov: 40degrees }
render { camera: main }"#
        ),
        good: scene!(
            r#"camera side { fov: 40deg }
render { camera: main }"#
        ),
    },
    Row {
        code: "E0306",
        title: "a vector of the wrong size",
        text: "The property takes another number of components.",
        bad: scene!("sphere ball { position: (0, 1) }"),
        good: scene!("sphere ball { position: (0, 1, 0) }"),
    },
    Row {
        code: "W0306",
        title: "a variable is named like a unit",
        text: "`3m/s` is a speed, whatever `s` is; `3m / s` divides by the variable.",
        bad: scene!(
            r#"let s = 2
sphere ball { radius: 3m / s }"#
        ),
        good: scene!(
            r#"let share = 2
sphere ball { radius: 3m / share }"#
        ),
    },
    Row {
        code: "E0307",
        title: "components of different dimensions",
        text: "All components of a vector measure the same thing.",
        bad: scene!("sphere ball { position: (1m, 2, 30deg) }"),
        good: scene!("sphere ball { position: (1m, 2, 3) }"),
    },
    Row {
        code: "W0307",
        title: "a parameter lies outside its own range",
        text: "The default should be one of the values that the range allows. Perhaps a `%` is missing.",
        bad: scene!(
            r#"param rough: float = 50 in 0..1
sphere ball { radius: rough }"#
        ),
        good: scene!(
            r#"param rough: float = 50% in 0..1
sphere ball { radius: rough }"#
        ),
    },
    Row {
        code: "E0308",
        title: "an argument of the wrong type",
        text: "The function cannot compute with this value.",
        bad: scene!("sphere ball { radius: sin(2m) }"),
        good: scene!("sphere ball { radius: sin(2m / 1m) }"),
    },
    Row {
        code: "E0309",
        title: "a colour is expected",
        text: "A single number is no colour: say in which encoding it is meant.",
        bad: scene!(
            r#"diffuse grey { color: 0.5 }
sphere ball { material: grey }"#
        ),
        good: scene!(
            r#"diffuse grey { color: srgb(0.5, 0.5, 0.5) }
sphere ball { material: grey }"#
        ),
    },
    Row {
        code: "E0310",
        title: "a whole number is expected",
        text: "Half a sample cannot be taken.",
        bad: scene!(
            r#"render { samples: 2.5 }
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"render { samples: 3 }
sphere ball { radius: 1 }"#
        ),
    },
    Row {
        code: "E0311",
        title: "a condition is neither true nor false",
        text: "Numbers are not conditions: compare them.",
        bad: scene!("if 1 { sphere ball { radius: 1 } }"),
        good: scene!("if 1 > 0 { sphere ball { radius: 1 } }"),
    },
    Row {
        code: "E0312",
        title: "the arms of an `if` differ",
        text: "Whichever arm is taken, the value must be of one type.",
        bad: scene!(r#"sphere ball { radius: if true { 1 } else { "one" } }"#),
        good: scene!("sphere ball { radius: if true { 1 } else { 2 } }"),
    },
    Row {
        code: "E0313",
        title: "the items of a list differ",
        text: "All items of a list are of one type.",
        bad: scene!(
            r#"let list = [1, "two"]
sphere ball { radius: list[0] }"#
        ),
        good: scene!(
            r#"let list = [1, 2]
sphere ball { radius: list[0] }"#
        ),
    },
    Row {
        code: "E0314",
        title: "an operator before a value that it does not fit",
        text: "`-` takes numbers and vectors, `!` takes true and false.",
        bad: scene!(r#"sphere ball { radius: -"a" }"#),
        good: scene!("sphere ball { radius: -(0 - 1) }"),
    },
    Row {
        code: "W0315",
        title: "a colour has alpha",
        text: "Colours are red, green and blue. How much light a surface lets past is said by its material.",
        bad: scene!("sphere ball { material: diffuse { color: #ff800080 } }"),
        good: scene!("sphere ball { material: diffuse { color: #ff8000, opacity: 50% } }"),
    },
];
