//! Scenes through the evaluator: what each mistake is answered with, and that nothing makes it fail.

mod support;

use std::path::{Path, PathBuf};

use kinora_lang::diagnostic::{Diagnostic, Style, codes, render};
use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Evaluated, Overrides, eval, eval_project, parse};
use support::{Case, Found};

/// What the cases may read: `cube.ply` and `cube.obj` are sound, the others are not.
fn files<'a>(more: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Memory {
    let cube = include_bytes!("assets/cube.ply").as_slice();
    let known: Vec<(&str, &[u8])> = vec![
        ("cube.ply", cube),
        ("cube.obj", include_bytes!("assets/cube.obj")),
        ("cut.ply", &cube[..cube.len() / 2]),
        ("points.ply", include_bytes!("assets/points.ply")),
        ("negative.exr", include_bytes!("assets/negative.exr")),
        ("cut.exr", &include_bytes!("assets/negative.exr")[..200]),
        ("index.ply", include_bytes!("assets/index.ply")),
        ("text.obj", b"f 1 2 9\n"),
        ("data.bin", b"\0\0"),
        ("cut.stl", b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"),
        ("few.stl", &[0; 84 + 7]),
        ("nan.stl", b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n"),
        ("lost.obj", b"mtllib lost.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n"),
        ("bare.obj", b"mtllib bare.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"),
        ("bare.mtl", b"newmtl a\nmap_Kd -s 2 2 none.png\n"),
        ("lib/metals.kin", b"lang 1\nmetal gold { spectrum: \"Au\" }\nmetal silver { spectrum: \"Ag\" }\n"),
        ("lib/shapes.kin", include_bytes!("assets/shapes.kin")),
        ("lib/faulty.kin", include_bytes!("assets/faulty.kin")),
        ("lib/ring.kin", b"lang 1\nimport \"chain.kin\" as chain\nlet a = chain.b\n"),
        ("lib/chain.kin", b"lang 1\nimport \"ring.kin\" as ring\nlet b = ring.a\n"),
        ("lib/latin.kin", b"let caf\xE9 = 1"),
        (
            "arm.gltf",
            br#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_x"],"nodes":[{"name":"Arm","children":[1]},{"name":"Hand"}]}"#,
        ),
        (
            "draco.gltf",
            br#"{"asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"],
                "extensionsRequired":["KHR_draco_mesh_compression"]}"#,
        ),
        ("broken.gltf", br#"{"asset":{"version":"2.0"},"nodes":[{"mesh":3},{"rotation":[0,0,0,2]}]}"#),
        ("away.gltf", br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"../away.bin"}]}"#),
        ("picture.gltf", br#"{"asset":{"version":"2.0"},"images":[{"uri":"data:image/png;base64,AAAA"}]}"#),
    ];
    Memory::new(known.into_iter().chain(more))
}

fn evaluate(text: &str, overrides: &Overrides) -> Result<Evaluated, Vec<Diagnostic>> {
    eval(&parse(&Source::new(FileId(0), "a.kin", text)), &files([]), overrides)
}

fn found(case: &Case) -> Found {
    let ((name, text), others) = case.files.split_first().unwrap();
    let files = files(others.iter().map(|(name, text)| (name.as_str(), text.as_bytes())));
    let overrides = Overrides { params: case.params.clone(), ..Overrides::default() };
    let (evaluated, sources) =
        eval_project(&parse(&Source::new(FileId(0), name.as_str(), text.as_str())), &files, &overrides);
    (evaluated.map_or_else(|diagnostics| diagnostics, |evaluated| evaluated.warnings), sources)
}

fn errors(text: &str, overrides: &Overrides) -> Vec<(&'static str, String)> {
    match evaluate(text, overrides) {
        Ok(evaluated) => evaluated.warnings.into_iter().map(|found| (found.code, found.message)).collect(),
        Err(diagnostics) => diagnostics.into_iter().map(|found| (found.code, found.message)).collect(),
    }
}

/// Codes that no scene text alone can have; they are tested below or beside their code.
const ELSEWHERE: &[&str] = &[
    "E0305", "E0705", "E0711", "E0712", "E0713", "W0714", "E0806", "E0807", "E0905", "E0906", "W0907", "W0908",
    "E1003", "E1006", "E1007",
];

#[test]
fn cases() {
    let mut seen = Vec::new();
    for folder in
        ["names", "types", "values", "structure", "time", "files", "assets", "lints", "limits", "surface", "physics"]
    {
        seen.extend(support::run(folder, found));
    }
    for row in codes::all() {
        let ours = !row.code.starts_with("E01") && !ELSEWHERE.contains(&row.code);
        assert!(!ours || seen.iter().any(|code| code == row.code), "no case for {}", row.code);
    }
    for code in seen {
        assert!(codes::find(&code).is_some(), "{code} has no row");
    }
}

/// Codes whose examples are no scenes of texts alone: they take a link, a file of many MiB, another encoding, a picture,
/// the project's file, a simulation, or a fault of the program.
const NO_SCENES: &[&str] = &[
    "E0119", "E0705", "E0711", "E0712", "E0713", "W0714", "E0806", "E0807", "W0809", "W0811", "E0905", "E0906",
    "W0907", "W0908", "E1005", "E1006", "E1007",
];

/// What `kinora explain` shows as bad is bad, and what it shows as good is good: this makes the pages about the codes.
#[test]
fn examples_and_pages_of_codes() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let mut index = String::from(
        "# Diagnostics\n\nEvery code that `kinora check` knows. `kinora explain CODE` shows the same page; \
         [check.md](check.md) says how to allow warnings.\n\n| code | |\n|---|---|\n",
    );
    let mut stale = Vec::new();
    let mut keep = |path: PathBuf, text: &str| {
        if std::fs::read_to_string(&path).is_ok_and(|page| page == text) {
            return;
        }
        match std::env::var_os("UPDATE_EXPECT") {
            Some(_) => std::fs::write(path, text).unwrap(),
            None => stale.push(path),
        }
    };
    for row in codes::all() {
        index += &format!("| [{}](diagnostics/{}.md) | {} |\n", row.code, row.code, row.title);
        let mut page = codes::page(&row);
        assert!(!row.bad.is_empty() && !row.good.is_empty(), "{} has no examples", row.code);
        if !NO_SCENES.contains(&row.code) {
            let (bad, sources) = found(&Case::read("scene.kin", row.bad));
            let codes: Vec<_> = bad.iter().map(|found| found.code).collect();
            assert!(codes.contains(&row.code), "{}: {bad:?}", row.code);
            let said: Vec<String> = bad.iter().map(|found| render(found, &sources, Style::default())).collect();
            page += &format!("\nWhat is said of the first:\n\n```text\n{}```\n", said.join("\n"));
            assert_eq!(found(&Case::read("scene.kin", row.good)).0, [], "{}", row.code);
        }
        keep(docs.join(format!("diagnostics/{}.md", row.code)), &page);
    }
    keep(docs.join("diagnostics.md"), &index);
    let count = std::fs::read_dir(docs.join("diagnostics")).unwrap().count();
    assert_eq!((count, stale), (codes::all().len(), Vec::new()), "UPDATE_EXPECT=1 writes the pages anew");
}

const HEAD: &str = "lang 1\ncamera main { position: (0, 0, 4) }\nsky { color: #fff }\n";

fn with_param(given: &str, line: &str) -> Vec<(&'static str, String)> {
    let (name, value) = given.split_once('=').unwrap();
    let overrides = Overrides { params: vec![(name.into(), value.into())], ..Overrides::default() };
    errors(&format!("{HEAD}{line}\nsphere {{ position: (count, 0, 0) }}"), &overrides)
}

#[test]
fn parameters_on_the_command_line() {
    let check = |given: &str, line: &str, expected: &[(&'static str, &str)]| {
        let found = with_param(given, line);
        let found: Vec<_> = found.iter().map(|(code, message)| (*code, message.as_str())).collect();
        assert_eq!(found, expected, "{given} {line}");
    };
    let int = "param count: int = 60 in 1..500";
    check("count=7", int, &[]);
    check("count=500", int, &[]);
    check("count=900", int, &[("E0413", "`count` must be within 1..500, got 900")]);
    check("count=0", int, &[("E0413", "`count` must be within 1..500, got 0")]);
    check("count=abc", int, &[("E0414", "`-D count=abc`: expected a whole number")]);
    check("count=2.5", int, &[("E0414", "`-D count=2.5`: expected a whole number")]);
    check("count=3m", int, &[("E0414", "`-D count=3m`: expected a whole number")]);
    check("count=time", int, &[("E0414", "`-D count=time`: expected a value that does not change over time")]);
    check("count=1/0", int, &[("E0414", "`-D count=1/0`: division by zero gives no finite number")]);
    check("cuont=7", int, &[("E0414", "`-D cuont=7`: no parameter named `cuont`")]);
    check("count=2cm", "param count: length = 1m", &[]);
    check("count=2", "param count: length = 1m", &[]);
    check("count=2s", "param count: length = 1m", &[("E0414", "`-D count=2s`: expected a length")]);
    check("count=30cm", "param count = 1m", &[]);
    check("count=\"a\"", "param count = 1m", &[("E0414", "`-D count=\"a\"`: expected a length")]);
    check("count=50%", "param count: float = 1", &[]);
    let broken = with_param("count=(", int);
    assert_eq!(broken.first().map(|found| found.0), Some("E0414"), "{broken:?}");
}

#[test]
fn parameters_are_listed() {
    let text = format!(
        "{HEAD}/// How rough.\nparam rough: float = 0.25 in 0..1\nparam size = 20cm\nsphere {{ radius: size * rough }}"
    );
    let params = evaluate(&text, &Overrides::default()).unwrap().params;
    let first = params.first().unwrap();
    assert_eq!((first.name.as_str(), first.ty.as_str(), first.default.as_str()), ("rough", "float", "0.25"));
    assert_eq!(first.range, Some(["0".to_string(), "1".to_string()]));
    assert_eq!(first.doc.as_deref(), Some("How rough."));
    assert_eq!(params.get(1).map(|param| param.ty.as_str()), Some("length"));
}

#[test]
fn properties_on_the_command_line() {
    let set = |sets: &[(&str, &str)], text: &str| {
        let sets = sets.iter().map(|(path, value)| (path.to_string(), value.to_string())).collect();
        evaluate(text, &Overrides { sets, ..Overrides::default() })
    };
    let text = format!(
        "{HEAD}sphere ball {{ radius: 1, material: red }}\ndiffuse red {{ color: #f00 }}\ncamera side {{ }}\nrender {{ camera: main, samples: 3 }}"
    );
    let scene = set(
        &[("render.max_bounces", "2"), ("render.camera", "side"), ("render.filter", "box"), ("ball.radius", "50cm")],
        &text,
    )
    .unwrap()
    .scene;
    assert_eq!((scene.render.max_bounces, scene.render.samples, scene.camera), (2, 3, Some(1)));
    assert_eq!((scene.render.filter, scene.render.filter_width), (kinora_scene::Filter::Box, 1.0));
    let radius = scene.nodes.iter().find_map(|node| match &node.shape {
        Some(kinora_scene::Shape::Sphere { radius_m }) => radius_m.constant().copied(),
        _ => None,
    });
    assert_eq!(radius, Some(0.5));
    assert_eq!(set(&[("render.samples", "9")], HEAD).unwrap().scene.render.samples, 9);
    let check = |path: &str, value: &str, code: &str, message: &str| {
        let found = set(&[(path, value)], &text).unwrap_err();
        let found: Vec<_> = found.iter().map(|found| (found.code, found.message.as_str())).collect();
        assert_eq!(found, [(code, message)]);
    };
    check(
        "render.sampels",
        "2",
        "E0201",
        "`--set render.sampels=2`: unknown property `sampels` on `render`, did you mean `samples`?",
    );
    check("render.samples", "0", "E0401", "`--set render.samples=0`: samples must be within 1..4294967295");
    check("nothing.samples", "0", "E0203", "`--set nothing.samples=0`: no node named `nothing` here");
    check("samples", "0", "E0414", "`--set samples=0`: write `node.property=value`, for example `render.samples=16`");
    check("render.clamp", "0", "E0401", "`--set render.clamp=0`: clamp must be greater than 0");
}

#[test]
fn a_camera_on_the_command_line() {
    let text = format!("{HEAD}camera side {{ position: (4, 0, 0) }}");
    let camera = |name: &str| evaluate(&text, &Overrides { camera: Some(name.into()), ..Overrides::default() });
    assert_eq!(camera("side").unwrap().scene.camera, Some(1));
    assert_eq!(camera("main").unwrap().scene.camera, Some(0));
    let found = camera("sied").unwrap_err();
    assert_eq!(found.first().map(|found| found.message.as_str()), Some("no camera named `sied` here"));
}

#[test]
fn samples_of_the_language() {
    let sample =
        |name: &str| std::fs::read_to_string(format!("{}/tests/scenes/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let hello = evaluate(&sample("hello.kin"), &Overrides::default()).unwrap();
    assert_eq!((hello.scene.nodes.len(), hello.scene.materials.len(), hello.warnings.len()), (2, 2, 0));
    for name in ["cornell.kin", "dominoes.kin"] {
        for (code, message) in errors(&sample(name), &Overrides::default()) {
            let fine = matches!(code, "E1101" | "E0701" | "E0706") || message == "`heights` is never used";
            assert!(fine, "{name}: {code} {message}");
        }
    }
}

#[test]
fn evaluation_is_deterministic() {
    let text = format!(
        "{HEAD}for i in 0..50 {{ sphere {{ position: (rand(i), noise((i * 0.3, 0, 0)), sin(time / 1s + i)) }} }}"
    );
    let of = || evaluate(&text, &Overrides::default()).unwrap().scene;
    assert_eq!(of(), of());
}

/// SplitMix64: the same mutations in every run.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[test]
fn mutations_never_fail() {
    let root = env!("CARGO_MANIFEST_DIR");
    let samples: Vec<Vec<char>> = ["hello.kin", "cornell.kin", "dominoes.kin"]
        .iter()
        .map(|name| std::fs::read_to_string(format!("{root}/tests/scenes/{name}")).unwrap().chars().collect())
        .collect();
    let pieces = [
        "time",
        "keys { 0s: 1 }",
        "(0, 1)",
        "-1",
        "1e400",
        "like",
        "{",
        "}",
        "for i in 0..9 { }",
        "\"",
        "0",
        "white",
        "main",
        "m",
        "..",
        "a",
        "#fff",
        "if",
        "1 / 0",
        "[1]",
        ",",
        "fn f() = f()",
    ];
    let mut state = 7;
    for round in 0..1000 {
        let mut text = samples[round % samples.len()].clone();
        for _ in 0..1 + next(&mut state) % 4 {
            let at = next(&mut state) as usize % text.len();
            let end = (at + next(&mut state) as usize % 12).min(text.len());
            let piece = pieces[next(&mut state) as usize % pieces.len()];
            text.splice(at..end, piece.chars());
        }
        let text: String = text.into_iter().collect();
        for (code, message) in errors(&text, &Overrides::default()) {
            assert_ne!(code, "E1007", "{message}:\n{text}");
        }
    }
}

#[test]
fn bombs_end() {
    let chain: String = (0..30_000).map(|i| format!("diffuse d{i} like d{} {{ }}\n", i + 1)).collect();
    let lets: String = (0..30_000).map(|i| format!("fn f{i}() = f{}()\n", i + 1)).collect();
    let parents: String = (0..30_000).map(|i| format!("sphere s{i} {{ parent: s{} }}\n", i + 1)).collect();
    let groups = format!("{}{}", "group { ".repeat(100), "}".repeat(100));
    let sums = format!("sphere {{ position: ({}, 0, 0) }}", vec!["time / 1s"; 50_000].join(" + "));
    let nested = format!("sphere {{ radius: {}1{} }}", "(".repeat(120), ")".repeat(120));
    let moving =
        "let many = sum([for i in 0..100000: sin(time / 1s + i)])\nsphere { position: (many, 0, 0) }".to_string();
    let branch = "prefab tree(n: int) { sphere { }  for i in 0..9 { tree { n: n + 1 } } }\ntree { n: 0 }".to_string();
    let fuel = "fn f(n: int) = sum([for i in 0..1000: i * n])\nlet many = [for i in 0..100000: f(i)]\nsphere { radius: many[0] }";
    let lists = "fn double(list: list<int>, n: int) = if n == 0 { list } else { double(list + list, n - 1) }\nlet list = double([1, 2], 30)\nsphere { radius: list[0] }";
    let chain_of = |line: &dyn Fn(usize) -> String| (0..60).map(line).collect::<String>();
    let tuples = chain_of(&|i| format!("let t{} = (t{i}, t{i})\n", i + 1));
    let copies = chain_of(&|i| format!("group g{} {{\ngroup like g{i} {{ }}\ngroup like g{i} {{ }}\n}}\n", i + 1));
    let coats: String = (0..30_000).map(|i| format!("glossy c{i} {{ base: c{} }}\n", i + 1)).collect();
    let mixes = chain_of(&|i| format!("let m{} = mix(m{i}, m{i}, amount: 0.5)\n", i + 1));
    let in_order = concat!(
        "fn more(list: list<material>) -> list<material> = list + [mix(list[0], list[count(list) - 1], amount: 0.5)]\n",
        "fn grow(list: list<material>, n: int) -> list<material> = if n == 0 { list } else { grow(more(list), n - 1) }\n",
        "for m in grow([diffuse { }], 60) { sphere { material: m } }"
    );
    let boxes: String = (0..30_000).map(|i| format!("let b{} = [b{i}]\n", i + 1)).collect();
    let sums_of_lists =
        "let big = [for i in 0..100000: i]\nlet all = [for i in 0..100000: sum(big)]\nsphere { radius: all[0] }";
    let operations = "fn f(n: float) = sin(time / 1s + n)\nlet all = [for i in 0..999999: f(i) * f(i + 0.5) + f(i + 0.25)]\nsphere { radius: all[0] }";
    for (name, text, expected) in [
        ("tuples", format!("let t0 = (1, 1)\n{tuples}sphere {{ position: t60 }}"), Some("E1004")),
        ("copies", format!("group g0 {{ sphere {{ }} }}\n{copies}"), Some("E1004")),
        ("coats", format!("{coats}glossy c30000 {{ }}\nsphere {{ material: c0 }}"), Some("E1004")),
        ("mixes", format!("diffuse m0 {{ }}\n{mixes}sphere {{ material: m60 }}"), Some("E1004")),
        ("mixes in order", in_order.to_string(), Some("E1004")),
        ("boxes", format!("let b0 = 1\n{boxes}sphere {{ position: b30000 }}"), Some("E1004")),
        ("sums of lists", sums_of_lists.to_string(), Some("E1003")),
        ("operations", operations.to_string(), Some("E1004")),
        ("fuel", fuel.to_string(), Some("E1003")),
        ("lists", lists.to_string(), Some("E1004")),
        ("nodes", "for i in 0..1000000 { sphere { }, sphere { } }".to_string(), Some("E1004")),
        ("likes", format!("{chain}diffuse d30000 {{ }}"), Some("E1001")),
        ("calls", format!("{lets}fn f30000() = 1\nsphere {{ radius: f0() }}"), Some("E1001")),
        ("parents", format!("{parents}sphere s30000 {{ }}"), None),
        ("groups", groups, None),
        ("sums", sums, None),
        ("nested", nested, None),
        ("moving", moving, None),
        ("branch", branch, Some("E0504")),
    ] {
        let found = errors(&format!("{HEAD}{text}"), &Overrides::default());
        let found: Vec<_> = found.iter().map(|found| found.0).filter(|code| code.starts_with('E')).collect();
        assert_eq!(found.first().copied(), expected, "{name}: {found:?}");
    }
}
