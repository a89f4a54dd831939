//! Codes of time and animation.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0601",
        title: "structure depends on time",
        text: "How many nodes there are is decided before the first frame, so that an animation keeps its layout.",
        bad: scene!("for i in 0..floor(time / 1s) { sphere { position: (i, 0, 0) } }"),
        good: scene!("for i in 0..4 { sphere { position: (i, 0, 0), visible: time > i * 1s } }"),
    },
    Row {
        code: "E0602",
        title: "keys out of order",
        text: "Keys are written from the earliest to the latest.",
        bad: scene!("sphere ball { radius: keys { 0s: 1  2s: 2  1s: 3 } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1  1s: 3  2s: 2 } }"),
    },
    Row {
        code: "E0603",
        title: "two keys at one time",
        text: "A curve has one value at a time. A jump is a key that is reached by `ease step`.",
        bad: scene!("sphere ball { radius: keys { 0s: 1  1s: 2  1s: 3 } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1  1s: 3 ease step } }"),
    },
    Row {
        code: "E0604",
        title: "no keys",
        text: "A curve needs a value at one time at least.",
        bad: scene!("sphere ball { radius: keys { } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1 } }"),
    },
    Row {
        code: "W0605",
        title: "easing on the first key",
        text: "An easing shapes the way to its key, and no way leads to the first one.",
        bad: scene!("sphere ball { radius: keys { 0s: 1 ease out_quad  1s: 2 } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1  1s: 2 ease out_quad } }"),
    },
    Row {
        code: "E0606",
        title: "keys of different types",
        text: "A curve runs through values of one type: numbers, vectors, colours or rotations.",
        bad: scene!("sphere ball { radius: keys { 0s: 1m  1s: 30deg } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1m  1s: 2m } }"),
    },
    Row {
        code: "E0607",
        title: "two rotations exactly opposite",
        text: "Both ways from one to the other are equally short.",
        bad: scene!("box b { rotation: keys { 0s: rotate_y(0deg)  1s: rotate_y(180deg) } }"),
        good: scene!("box b { rotation: rotate_y(keys { 0s: 0deg  1s: 180deg }) }"),
    },
    Row {
        code: "E0608",
        title: "a property that cannot be animated",
        text: "It is the same in all frames.",
        bad: scene!(
            r#"render { samples: floor(16 + time / 1s) }
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"render { samples: 16 }
sphere ball { radius: 1 + time / 1s }"#
        ),
    },
    Row {
        code: "E0609",
        title: "unknown easing",
        text: "Easings are named `ease_in_out`, `in_out_cubic` and so on.",
        bad: scene!("sphere ball { radius: keys { 0s: 1  1s: 2 ease inout_cubic } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1  1s: 2 ease in_out_cubic } }"),
    },
    Row {
        code: "E0610",
        title: "frames without a rate",
        text: "`24f` is a time only where the scene says how many frames a second has.",
        bad: scene!("sphere ball { radius: keys { 0s: 1  24f: 2 } }"),
        good: scene!(
            r#"render { fps: 24 }
sphere ball { radius: keys { 0f: 1  24f: 2 } }"#
        ),
    },
    Row {
        code: "W0611",
        title: "a key after the end",
        text: "The animation ends before the key is reached.",
        bad: scene!(
            r#"render { duration: 8s }
sphere ball { radius: keys { 0s: 1  12s: 2 } }"#
        ),
        good: scene!(
            r#"render { duration: 12s }
sphere ball { radius: keys { 0s: 1  12s: 2 } }"#
        ),
    },
    Row {
        code: "W0612",
        title: "two keys within a frame",
        text: "The way between them is never seen.",
        bad: scene!("sphere ball { radius: keys { 0s: 1  1ms: 2 } }"),
        good: scene!("sphere ball { radius: keys { 0s: 1  1s: 2 } }"),
    },
    Row {
        code: "E0613",
        title: "a value of a surface's point elsewhere",
        text: "`p`, `p_local`, `uv` and `normal` are known where a ray meets a surface, so only what is asked there can depend on them: the colours and ratios of materials.",
        bad: scene!("sphere ball { radius: 1m + 0.1 * p.x }"),
        good: scene!("sphere ball { material: diffuse { roughness: 0.5 + 0.5 * noise(p) } }"),
    },
    Row {
        code: "E0614",
        title: "no keys for some of the frames",
        text: "With `outside: error` keys have no value before the first and after the last of them, and a frame lies there.",
        bad: scene!(
            r#"render { duration: 8s }
sphere ball { radius: keys(outside: error) { 0s: 1  4s: 2 } }"#
        ),
        good: scene!(
            r#"render { duration: 8s }
sphere ball { radius: keys(outside: error) { 0s: 1  8s: 2 } }"#
        ),
    },
    Row {
        code: "E0615",
        title: "a function that is no easing",
        text: "An easing says how far a segment has come, 0 to 1, when a part of its time has passed: a function of one plain number that gives one, and that depends on nothing else, neither on `time` nor on keys.",
        bad: scene!(
            r#"fn late(x) = x * sin(time / 1s)
sphere ball { radius: keys { 0s: 1  1s: 2 ease late } }"#
        ),
        good: scene!(
            r#"fn late(x) = x * sin(turn(x / 4))
sphere ball { radius: keys { 0s: 1  1s: 2 ease late } }"#
        ),
    },
    Row {
        code: "E0616",
        title: "tangents without hermite",
        text: "`in` and `out` say how much a value changes a second before and after its key. They belong to curves with `interpolate: hermite`, in the value's own space.",
        bad: scene!("sphere ball { radius: keys { 0s: { value: 1, out: 2 }  1s: 2 } }"),
        good: scene!("sphere ball { radius: keys(interpolate: hermite) { 0s: { value: 1, out: 2 }  1s: 2 } }"),
    },
];
