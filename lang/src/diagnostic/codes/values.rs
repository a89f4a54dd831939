//! Codes of values and their ranges.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0401",
        title: "a value out of range",
        text: "The property has no meaning there.",
        bad: scene!("sphere ball { radius: -1 }"),
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "W0401",
        title: "the tiny beside the huge",
        text: "Positions are computed with seven digits: of a shape a million times smaller than the scene little \
            is left. Most often a unit was forgotten.",
        bad: scene!(
            r#"sphere pea { radius: 4mm }
sphere moon { radius: 2km, position: (0, 0, -20km) }"#
        ),
        good: scene!(
            r#"sphere pea { radius: 4mm }
sphere moon { radius: 2m, position: (0, 0, -20m) }"#
        ),
    },
    Row {
        code: "E0402",
        title: "division by zero",
        text: "The quotient is no number.",
        bad: scene!(
            r#"let n = 0
sphere ball { radius: 1 / n }"#
        ),
        good: scene!(
            r#"let n = 2
sphere ball { radius: 1 / n }"#
        ),
    },
    Row {
        code: "W0402",
        title: "no light",
        text: "Without a sky or an `emitter` the picture is black.",
        bad: r#"lang 1
camera main { position: (0, 0, 4) }
sphere ball { radius: 1 }"#,
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0403",
        title: "a value is not a finite number",
        text: "An operation before had no result, such as the root of a negative number.",
        bad: scene!("sphere ball { position: (0, sqrt(-2), 0) }"),
        good: scene!("sphere ball { position: (0, sqrt(2), 0) }"),
    },
    Row {
        code: "E0404",
        title: "a scale of 0",
        text: "What has no extent in one direction has no surface.",
        bad: scene!("sphere ball { scale: (1, 0, 1) }"),
        good: scene!("sphere ball { scale: (1, 0.01, 1) }"),
    },
    Row {
        code: "E0405",
        title: "a direction of no length",
        text: "Two things that must differ are the same: camera and target, `up` and the view.",
        bad: scene!(
            r#"camera side { position: (0, 1, 0), look_at: (0, 1, 0) }
render { camera: side }"#
        ),
        good: scene!(
            r#"camera side { position: (0, 1, 0), look_at: (0, 0, 1) }
render { camera: side }"#
        ),
    },
    Row {
        code: "E0406",
        title: "a refractive index below 1",
        text: "Light is not faster than in vacuum.",
        bad: scene!(
            r#"dielectric glass { ior: 0.2 }
sphere ball { material: glass }"#
        ),
        good: scene!(
            r#"dielectric glass { ior: 1.5 }
sphere ball { material: glass }"#
        ),
    },
    Row {
        code: "E0407",
        title: "a share above 1",
        text: "A surface cannot give back more light than it gets, and roughness runs from 0 to 1.",
        bad: scene!(
            r#"metal steel { roughness: 1.7 }
sphere ball { material: steel }"#
        ),
        good: scene!(
            r#"metal steel { roughness: 0.7 }
sphere ball { material: steel }"#
        ),
    },
    Row {
        code: "E0408",
        title: "a field of view that cannot be",
        text: "A perspective picture shows more than 0 and less than 180 degrees.",
        bad: scene!(
            r#"camera wide { position: (0, 1, 0), fov: 180deg }
render { camera: wide }"#
        ),
        good: scene!(
            r#"camera wide { position: (0, 1, 0), fov: 120deg }
render { camera: wide }"#
        ),
    },
    Row {
        code: "E0409",
        title: "an index out of range",
        text: "Items are counted from 0.",
        bad: scene!(
            r#"let list = [1, 2]
sphere ball { radius: list[2] }"#
        ),
        good: scene!(
            r#"let list = [1, 2]
sphere ball { radius: list[1] }"#
        ),
    },
    Row {
        code: "E0410",
        title: "a number is too large",
        text: "Numbers go up to about 1.8e308, whole ones up to 2^53.",
        bad: scene!("sphere ball { radius: 10^400 }"),
        good: scene!("sphere ball { radius: 10^4 }"),
    },
    Row {
        code: "E0411",
        title: "a picture of no size, or too large a one",
        text: "A side has 1 to 16384 pixels.",
        bad: scene!(
            r#"render { resolution: (0, 1080) }
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"render { resolution: (1920, 1080) }
sphere ball { radius: 1 }"#
        ),
    },
    Row {
        code: "E0412",
        title: "a handle of a bezier curve out of range",
        text: "Its x is a time, and time does not run backwards.",
        bad: scene!("sphere ball { radius: keys { 0s: 1  1s: 2 ease bezier(1.4, 0, 0.5, 1) } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1  1s: 2 ease bezier(0.4, 0, 0.5, 1) } }"),
    },
    Row {
        code: "E0413",
        title: "a parameter out of range",
        text: "The value on the command line lies outside what the `param` line allows.",
        bad: scene!(
            r#"param count: int = 60 in 1..500
for i in 0..count { sphere { position: (i, 0, 0), radius: 0.3 } }
// -D count=900"#
        ),
        good: scene!(
            r#"param count: int = 60 in 1..500
for i in 0..count { sphere { position: (i, 0, 0), radius: 0.3 } }
// -D count=90"#
        ),
    },
    Row {
        code: "E0414",
        title: "a value on the command line that cannot be read",
        text: "`-D name=value` and `--set node.property=value` take values as a scene writes them.",
        bad: scene!(
            r#"param count: int = 60 in 1..500
for i in 0..count { sphere { position: (i, 0, 0), radius: 0.3 } }
// -D count=many"#
        ),
        good: scene!(
            r#"param count: int = 60 in 1..500
for i in 0..count { sphere { position: (i, 0, 0), radius: 0.3 } }
// -D count=90"#
        ),
    },
    Row {
        code: "W0416",
        title: "a property without effect",
        text: "Another property decides whether this one matters, and as it stands it does not.",
        bad: scene!(
            r#"dielectric amber { attenuation_color: #e8a34a }
sphere ball { material: amber }"#
        ),
        good: scene!(
            r#"dielectric amber { attenuation_color: #e8a34a, attenuation_distance: 20cm }
sphere ball { material: amber }"#
        ),
    },
];
