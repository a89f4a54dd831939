//! Codes of physics, of allowances and of tests.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "E0901",
        title: "no mass",
        text: "What forces move has a mass above 0. What they cannot move has `kind: fixed`.",
        bad: scene!("sphere ball { rigid_body { mass: 0kg } }"),
        good: scene!("sphere ball { rigid_body { mass: 2kg } }"),
    },
    Row {
        code: "W0901",
        title: "a deprecated name",
        text: "The name still means what it meant, but the next version of the language will not know it.",
        bad: scene!(
            r#"ggx gold { color: #ffd700 }
sphere ball { material: gold }"#
        ),
        good: scene!(
            r#"metal gold { color: #ffd700 }
sphere ball { material: gold }"#
        ),
    },
    Row {
        code: "E0902",
        title: "a body without an inside",
        text: "A dynamic body needs a volume: where it is has to be told from where it is not, and its mass has to be \
            somewhere. Triangles have no inside, a flat mesh has none, and a plane has no end. Their bodies can be \
            `fixed`, or get the hull about them.",
        bad: scene!("plane ground { rigid_body { } }"),
        good: scene!("plane ground { rigid_body { kind: fixed } }"),
    },
    Row {
        code: "W0902",
        title: "an allowance that is none",
        text: "A warning is allowed by `// allow(W0401): why` on a line of its own above the line that gets it. The \
            code must be a warning's: what is an error cannot be allowed.",
        bad: scene!(
            r#"// allow(W9999): no such code
sphere ball { radius: 1 }"#
        ),
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "E0903",
        title: "a body moved by keys and by forces",
        text: "A dynamic body is where the simulation puts it, and a fixed one stays where it is at 0s. A body that \
            follows its own keys, or what it moves with, is kinematic: it pushes others and nothing pushes it.",
        bad: scene!("sphere ball { position: (0, time / 1s, 0), rigid_body { } }"),
        good: scene!("sphere ball { position: (0, time / 1s, 0), rigid_body { kind: kinematic } }"),
    },
    Row {
        code: "W0903",
        title: "an allowance of what does not occur",
        text: "The next line does not get the warning that the comment allows: it was put right meanwhile, or the \
            comment stands above another line.",
        bad: scene!(
            r#"// allow(W0201): used later
let size = 1
sphere ball { radius: size }"#
        ),
        good: scene!(
            r#"let size = 1
sphere ball { radius: size }"#
        ),
    },
    Row {
        code: "E0904",
        title: "a body that changes its size",
        text: "The shape that a body collides with is made once, at 0s.",
        bad: scene!("sphere ball { scale: 1 + time / 1s, rigid_body { kind: kinematic } }"),
        good: scene!("sphere ball { scale: 2, rigid_body { kind: kinematic } }"),
    },
    Row {
        code: "W0904",
        title: "a test that cannot be read",
        text: "A comment `// test: picture.png, samples 64, flip < 0.02` on a line of its own names a reference picture \
            of the scene for `kinora test`. After the file may come samples, size, frame, seed, camera, param, flip and \
            error; the file lies in the project.",
        bad: scene!(
            r#"// test: picture.png, smaples 64
sphere ball { radius: 1 }"#
        ),
        good: scene!(
            r#"// test: picture.png, samples 64
sphere ball { radius: 1 }"#
        ),
    },
    Row {
        code: "E0905",
        title: "the simulation blew up",
        text: "A body is further away than numbers reach, or nowhere at all. Mostly bodies that overlap at the start, \
            or a spring that is too stiff for the step, threw it there. A higher `rate` of the `simulation` makes \
            smaller steps.",
        bad: scene!("sphere ball { rigid_body { velocity: (100000000m/s, 0, 0) } }\nrender { duration: 1s }"),
        good: scene!("sphere ball { rigid_body { velocity: (10m/s, 0, 0) } }\nrender { duration: 1s }"),
    },
    Row {
        code: "E0906",
        title: "a stale bake under --frozen-bake",
        text: "The file that keeps where bodies are is not there, is damaged, or was made for other bodies. Without \
            `--frozen-bake` it is made anew; `kinora bake` makes it.",
        bad: scene!("// kinora render scene.kin --frozen-bake\nsphere ball { rigid_body { } }"),
        good: scene!(
            "// kinora bake scene.kin\n// kinora render scene.kin --frozen-bake\nsphere ball { rigid_body { } }"
        ),
    },
    Row {
        code: "W0907",
        title: "bodies inside one another",
        text: "Two bodies that may not be in one place are so at the start. They are pushed apart in the first steps.",
        bad: scene!("sphere a { rigid_body { } }\nsphere b { position: (1.9, 0, 0), rigid_body { } }"),
        good: scene!("sphere a { rigid_body { } }\nsphere b { position: (2, 0, 0), rigid_body { } }"),
    },
    Row {
        code: "W0908",
        title: "a bake from another kind of machine",
        text: "Rounding may differ between kinds of processors, and what touches grows such differences. The bake is \
            used as it is. One that is made here may show another film.",
        bad: scene!("// cache/scene.bake comes from another machine\nsphere ball { rigid_body { } }"),
        good: scene!("// cache/scene.bake was removed, and kinora bake made it anew\nsphere ball { rigid_body { } }"),
    },
    Row {
        code: "E0909",
        title: "a joint that holds nothing",
        text: "A joint is between two different bodies, and forces move at least one of them.",
        bad: scene!(
            r#"sphere ball { rigid_body { } }
joint pin { kind: ball, a: ball, b: ball }"#
        ),
        good: scene!(
            r#"sphere post { position: (0, 3, 0), rigid_body { kind: fixed } }
sphere ball { rigid_body { } }
joint pin { kind: ball, a: post, b: ball }"#
        ),
    },
    Row {
        code: "E0910",
        title: "a body among copies",
        text: "An instance shows a shape in many places, and a body is in one. A body written inside what is only \
            there for its instances is nowhere. Write it inside the instance: each of them is then a body.",
        bad: scene!(
            r#"prefab brick() { box block { rigid_body { } } }
instance wall { of: brick { } }"#
        ),
        good: scene!(
            r#"prefab brick() { box block { } }
instance wall { of: brick { }, rigid_body { } }"#
        ),
    },
];
