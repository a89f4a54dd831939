//! `kinora fmt`: what a scene looks like, and that nothing is lost.

use kinora_lang::diagnostic::Diagnostic;
use kinora_lang::eval::{Overrides, eval};
use kinora_lang::files::Folder;
use kinora_lang::format::{WIDTH, format, format_partial};
use kinora_lang::source::{FileId, Source};
use kinora_lang::syntax::{SyntaxKind, Tree, parse};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn read(text: &str) -> Tree {
    parse(&Source::new(FileId(0), "a.kin", text))
}

#[track_caller]
fn check(text: &str, expected: &str) {
    let formatted = format(&read(text)).unwrap_or_else(|found| panic!("{text}\n{found:?}"));
    assert_eq!(formatted, expected, "of:\n{text}");
    same(text, &formatted);
}

/// What holds for every text and what it becomes.
fn same(text: &str, formatted: &str) {
    assert_eq!(format(&read(formatted)).as_deref(), Ok(formatted), "not stable:\n{text}\n---\n{formatted}");
    let (before, after) = (content(text), content(formatted));
    assert_eq!(before.0, after.0, "other tokens:\n{text}\n---\n{formatted}");
    assert_eq!(before.1, after.1, "other comments:\n{text}\n---\n{formatted}");
    let spaces = formatted.lines().any(|line| line.ends_with([' ', '\t']));
    assert!(!spaces || text.contains("/*"), "spaces at a line's end:\n{formatted}");
    assert!(!formatted.contains("\n\n\n") || text.contains("/*"), "two empty lines:\n{formatted}");
    assert!(formatted.is_empty() || formatted.ends_with('\n') && !formatted.starts_with('\n'));
}

/// The text without spaces and separators, and the comments in any order.
fn content(text: &str) -> (String, Vec<String>) {
    let (mut tokens, mut comments) = (String::new(), Vec::new());
    for token in read(text).root().tokens() {
        match token.kind() {
            SyntaxKind::LineComment | SyntaxKind::DocComment | SyntaxKind::BlockComment => {
                comments.push(token.text().trim_end().replace("\r\n", "\n"));
            }
            SyntaxKind::Comma | SyntaxKind::Semicolon | SyntaxKind::Whitespace | SyntaxKind::Bom => {}
            SyntaxKind::Color => tokens += &token.text().to_ascii_lowercase(),
            _ => tokens += token.text(),
        }
    }
    comments.sort();
    (tokens, comments)
}

/// Of a text that cannot be read whole: all but spaces and separators, in any order.
fn letters(text: &str) -> Vec<char> {
    let mut letters: Vec<char> =
        text.to_lowercase().chars().filter(|c| !c.is_whitespace() && !",;".contains(*c)).collect();
    letters.sort_unstable();
    letters
}

#[test]
fn items() {
    check("", "");
    check("\n\n  \n", "");
    check("// only this", "// only this\n");
    check("\u{FEFF}lang 1\r\nsky{}\r\n", "lang 1\r\nsky {}\r\n");
    check("lang 1;camera{};;sky { }", "lang 1\ncamera {}\nsky {}\n");
    check(
        "lang 1\n\n\n\nsky {\n\n\ncolor: #FFF\n\n\nstrength: 1;\n\n}\n\n",
        "lang 1\n\nsky {\n    color: #fff\n\n    strength: 1\n}\n",
    );
    check("sphere   ball{radius :50cm ;position:(0,1 , 2)}", "sphere ball { radius: 50cm, position: (0, 1, 2) }\n");
    check(
        "diffuse a like  b{color:#ABCDEF}\ndiffuse c like b{}",
        "diffuse a like b { color: #abcdef }\ndiffuse c like b {}\n",
    );
    check("override \"A/B\"{ }", "override \"A/B\" {}\n");
    check(
        "import  \"x.kin\"as x\nimport{a as b,c}from\"y.kin\"",
        "import \"x.kin\" as x\nimport { a as b, c } from \"y.kin\"\n",
    );
    check("param a:float=1 in 0 .. 2", "param a: float = 1 in 0..2\n");
    check(
        "fn f(a:vec3,b : list < float >=[])->vec3{return a}",
        "fn f(a: vec3, b: list<float> = []) -> vec3 { return a }\n",
    );
    check("fn f(a)=a+1", "fn f(a) = a + 1\n");
    check(
        "prefab p{sphere{}}\nprefab q ( a ) {\nsphere { } box{ }}",
        "prefab p { sphere {} }\nprefab q(a) {\n    sphere {}\n    box {}\n}\n",
    );
    check("for i , x in xs{ball{at:x}}", "for i, x in xs { ball { at: x } }\n");
    check("if a{sky{}}else if b{\nbox{}}else{}", "if a {\n    sky {}\n} else if b {\n    box {}\n} else {}\n");
}

#[test]
fn values() {
    let value = |value: &str, expected: &str| check(&format!("let a = {value}"), &format!("let a = {expected}\n"));
    value("1+2 *3-  -4^2", "1 + 2 * 3 - -4 ^ 2");
    value("a/b", "a / b");
    value("3m/s", "3m/s");
    value("3m / s", "3m / s");
    value("3m ^ 2", "3m ^ 2");
    value("1e-3+1_000.50m", "1e-3 + 1_000.50m");
    value("!a&&b||c==d", "!a && b || c == d");
    value("f ( x ) [ 0 ] . y", "f(x)[0].y");
    value("a .b", "a.b");
    value("- 3", "-3");
    value("[1,2,]", "[1, 2]");
    value("[for i in 0..8 if i!=3:10cm*(i+1)]", "[for i in 0..8 if i != 3: 10cm * (i + 1)]");
    value(
        "keys(interpolate:spline){0s:1;after 2s:2 ease out_quad}",
        "keys(interpolate: spline) { 0s: 1, after 2s: 2 ease out_quad }",
    );
    value("keys{0s:{value:1,in:0,out:2}}", "keys { 0s: { value: 1, in: 0, out: 2 } }");
    value("if a{1}else{2}", "if a { 1 } else { 2 }");
    value("if a{\n1}else if b{2}else{3}", "if a {\n    1\n} else if b {\n    2\n} else {\n    3\n}");
    value("rotate_y(keys{\n0s:0deg  4s:1turn})", "rotate_y(keys {\n    0s: 0deg\n    4s: 1turn\n})");
    value("diffuse{\ncolor:#FFF}", "diffuse {\n    color: #fff\n}");
    value("()", "()");
    value("\"a // b\"", "\"a // b\"");
}

#[test]
fn long_lines() {
    let long = "a_rather_long_name_of_something";
    check(
        &format!("let a = {long} + {long} * {long} - {long}"),
        &format!("let a = {long}\n    + {long} * {long}\n    - {long}\n"),
    );
    check(
        &format!("let a = f({long}, {long}, x: {long})"),
        &format!("let a = f(\n    {long},\n    {long},\n    x: {long},\n)\n"),
    );
    check(
        &format!("sphere {{ {long}: {long}, x: {long} }}"),
        &format!("sphere {{\n    {long}: {long}\n    x: {long}\n}}\n"),
    );
    check(
        &format!("import {{ {long}, {long}, {long} }} from \"x\""),
        &format!("import {{\n    {long},\n    {long},\n    {long},\n}} from \"x\"\n"),
    );
    // Numbers fill the lines; lines that the author ended end there.
    let numbers: Vec<String> = (1000..1040).map(|number| number.to_string()).collect();
    let formatted = format(&read(&format!("let a = [{}]", numbers.join(",")))).unwrap();
    assert_eq!(formatted.lines().count(), 5, "{formatted}");
    assert!(formatted.lines().all(|line| line.len() <= WIDTH), "{formatted}");
    check("let a = [\n0,1,\n2,3]", "let a = [\n    0, 1,\n    2, 3,\n]\n");
    check("let a = [0,1,\n2,3]", "let a = [0, 1, 2, 3]\n");
}

#[test]
fn comments() {
    check("// a\n\n\n// b\nsky {} // c\n// d", "// a\n\n// b\nsky {} // c\n// d\n");
    check("sky { // a\ncolor: 1 // b\n\n// c\n}", "sky { // a\n    color: 1 // b\n\n    // c\n}\n");
    check("sky { color: 1, // a\n strength: 10, // b\n}", "sky {\n    color: 1     // a\n    strength: 10 // b\n}\n");
    check("sky { /* a */ color: /* b */ 1 /* c */ }", "sky { /* a */ color: /* b */ 1 /* c */ }\n");
    check("sky { /* a */ }\nbox {\n// b\n}", "sky { /* a */ }\nbox {\n    // b\n}\n");
    check("let a = f(1, // a\n2)", "let a = f(\n    1, // a\n    2,\n)\n");
    check("let a = [\n// a\n1, 2 // b\n// c\n]", "let a = [\n    // a\n    1, 2, // b\n    // c\n]\n");
    check("let a = 1 // a\n + 2", "let a = 1 // a\n    + 2\n");
    check("/// docs\nparam a = 1", "/// docs\nparam a = 1\n");
    check("/* a\n   b */ sky {}", "/* a\n   b */ sky {}\n");
    check("let a // a\n = // b\n 1", &format(&read("let a // a\n = // b\n 1")).unwrap());
}

#[track_caller]
fn partial(text: &str, expected: &str) {
    let tree = read(text);
    assert!(!tree.errors().is_empty(), "{text}");
    assert_eq!(format(&tree).map_err(|found| found.len()), Err(tree.errors().len()), "{text}");
    let formatted = format_partial(&tree);
    assert_eq!(formatted, expected, "of:\n{text}");
    assert_eq!(format_partial(&read(&formatted)), expected, "not stable:\n{formatted}");
}

#[test]
fn what_is_whole_round_mistakes() {
    partial(
        "sky{color :#FFF}\nsphere  a {\n radius   0.5\n position :(0,1,2)\n}\nbox{}",
        "sky { color: #fff }\nsphere a {\n    radius   0.5\n    position: (0, 1, 2)\n}\nbox {}\n",
    );
    partial("sky{}\n}\nbox { size :1 }", "sky {}\n}\nbox { size: 1 }\n");
    partial("sky  {}\nsphere  3rd {\n  radius :1\n}\nbox  {}", "sky {}\nsphere  3rd {\n  radius :1\n}\nbox {}\n");
    partial("sky  {}\nsphere  a {\n  radius :1\n", "sky {}\nsphere  a {\n  radius :1\n");
    partial("box {\n a :(1, 2)\n,(8)\n}\nbox{}", "box {\n    a: (1, 2)\n    ,(8)\n}\nbox {}\n");
    partial("sky  {}\nbox { a :1 b :2 }\nbox  {}", "sky {}\nbox { a :1 b :2 }\nbox {}\n");
}

/// The scenes of a folder of the repository, with what is below it.
fn scenes(folder: &str, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            scenes(path.to_str().unwrap(), found);
        } else if path.extension().is_some_and(|ending| ending == "kin") {
            found.push(path);
        }
    }
}

fn repository() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for folder in ["../examples", "../tests", "tests/scenes"] {
        scenes(&format!("{}/{folder}", env!("CARGO_MANIFEST_DIR")), &mut found);
    }
    assert!(found.len() > 50);
    found
}

/// A scene as bits, or what is wrong with it.
fn compiled(text: &str, path: &Path) -> Result<Vec<u8>, Vec<&'static str>> {
    let (folder, name) = Folder::of(path).unwrap();
    let tree = parse(&Source::new(FileId(0), name.as_str(), text));
    match eval(&tree, &folder, &Overrides::default()) {
        Ok(evaluated) => Ok(serde_json::to_vec(&evaluated.scene).unwrap()),
        Err(found) => Err(found.iter().map(|found: &Diagnostic| found.code).collect()),
    }
}

#[test]
fn examples_are_laid_out_and_mean_the_same() {
    let mut untidy = Vec::new();
    for path in repository() {
        let text = std::fs::read_to_string(&path).unwrap();
        match format(&read(&text)) {
            Ok(formatted) => {
                same(&text, &formatted);
                assert!(compiled(&text, &path) == compiled(&formatted, &path), "{} changes", path.display());
                if path.parent().is_some_and(|folder| folder.ends_with("examples")) && text != formatted {
                    untidy.push(path);
                }
            }
            Err(_) => {
                let formatted = format_partial(&read(&text));
                assert_eq!(format_partial(&read(&formatted)), formatted, "{}", path.display());
            }
        }
    }
    assert!(untidy.is_empty(), "run `kinora fmt examples`: {untidy:?}");
}

/// A text of the language with a hole in every gap.
fn item() -> impl Strategy<Value = Vec<String>> {
    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_string).collect()
    }
    fn list(parts: Vec<Vec<String>>, by: &str) -> Vec<String> {
        parts.join(&by.to_string())
    }
    let leaf = prop::sample::select(vec![
        "1",
        "50cm",
        "9.81m/s^2",
        "-3",
        "#FFaa00",
        "\"text//x\"",
        "true",
        "a.b",
        "x . y",
        "- 2",
        "( )",
        "[ ]",
        "f ( )",
        "diffuse { }",
        "3m / s",
        "1_000.50",
        "f ( x ) [ 0 ]",
        "a ^ 2",
        "gold like metal { }",
    ])
    .prop_map(words);
    let value = leaf.prop_recursive(4, 24, 4, |inner| {
        let many = |at_least| prop::collection::vec(inner.clone(), at_least..5);
        let two = (inner.clone(), inner.clone(), inner.clone());
        prop_oneof![
            many(0).prop_map(|values| [words("["), list(values, ","), words("]")].concat()),
            many(2).prop_map(|values| [words("("), list(values, ","), words(")")].concat()),
            many(0).prop_map(|values| [words("f ("), list(values, ","), words(")")].concat()),
            inner.clone().prop_map(|value| [words("rotate_y ( angle :"), value, words(")")].concat()),
            (many(0), prop::sample::select(vec![",", ";"])).prop_map(|(values, by)| {
                let values = values.into_iter().map(|value| [words("p :"), value].concat()).collect();
                [words("diffuse {"), list(values, by), words("}")].concat()
            }),
            two.clone().prop_map(|(a, b, _)| [
                words("if x < 1 {"),
                a,
                words("} else if y {"),
                b,
                words("} else { 3 }")
            ]
            .concat()),
            two.clone().prop_map(|(a, b, c)| {
                [
                    words("keys ( outside : loop ) { 0s :"),
                    a,
                    words(", after 2s :"),
                    b,
                    words("ease in_out ; 9s :"),
                    c,
                    words("}"),
                ]
                .concat()
            }),
            inner.clone().prop_map(|value| [words("[ for i , x in 0 .. 8 if i != 3 :"), value, words("]")].concat()),
            prop::collection::vec(prop::sample::select(vec!["+", "-", "*", "/", "&&", "^"]), 1..6).prop_map(|ops| {
                let rest = ops.iter().flat_map(|op| [op.to_string(), "some_long_name_of_a_value".to_string()]);
                std::iter::once("- x".to_string()).chain(rest).flat_map(|text| words(&text)).collect()
            }),
        ]
    });
    let simple = value.prop_flat_map(|value| {
        let with = |head: &str, tail: &str| Just([words(head), value.clone(), words(tail)].concat());
        prop_oneof![
            with("let a =", ""),
            with("param a : float =", "in 0 .. 2"),
            with("sphere ball { radius : 1 , material :", "}"),
            with("fn f ( a : list < float > = 1 , b ) -> vec3 { let c = 1 ; return", "}"),
            with("fn f ( a ) =", ""),
            with("diffuse a like b { c :", "}"),
            with("override \"A/B\" { in :", "}"),
            Just(words("import { a as b , c } from \"x.kin\"")),
            Just(words("import \"x.kin\" as x")),
            Just(words("lang 1")),
        ]
    });
    simple.prop_recursive(2, 12, 4, |inner| {
        let items = prop::collection::vec(inner, 0..4).prop_map(|items| list(items, ";"));
        prop_oneof![
            items.clone().prop_map(|items| [words("group {"), items, words("}")].concat()),
            items.clone().prop_map(|items| [words("for i , x in xs {"), items, words("}")].concat()),
            items.clone().prop_map(|items| [words("prefab p ( a : int , b = 2 ) {"), items, words("}")].concat()),
            items.prop_map(|items| [
                words("if a {"),
                items.clone(),
                words("} else if b {"),
                items,
                words("} else { }")
            ]
            .concat()),
        ]
    })
}

const GAPS: &[&str] = &[
    " ",
    " ",
    " ",
    " ",
    "\n",
    "\n\n\n",
    " // line\n",
    "\n// own\n",
    "\n\n// own\n\n",
    " /* in */ ",
    " /* end */\n",
    "\n/* start */ ",
    "\n/* own */\n",
    " /* two\n  lines */ ",
    "\n/// docs\n",
    " // a\n// b\n",
    " /* a */ /* b */ ",
    "\r\n",
];

fn join(items: &[Vec<String>], gaps: &[usize]) -> String {
    let mut gaps = gaps.iter().cycle();
    let mut text = String::new();
    for item in items {
        for word in item.iter().map(String::as_str).chain([";"]) {
            text += GAPS[*gaps.next().unwrap_or(&0) % GAPS.len()];
            text += word;
        }
    }
    text
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, max_shrink_iters: 100_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_is_lost(items in prop::collection::vec(item(), 1..4), gaps in prop::collection::vec(0usize..1000, 1..60)) {
        let text = join(&items, &gaps);
        let tree = read(&text);
        prop_assert_eq!(tree.errors(), &[], "{}", text);
        match format(&tree) {
            Ok(formatted) => same(&text, &formatted),
            Err(found) => prop_assert!(false, "{}\n{:?}", text, found),
        }
    }

    /// Cut, doubled and replaced pieces of a scene.
    #[test]
    fn mutations(start in 0usize..3000, length in 0usize..40, put in prop::sample::select(vec!["", "}", "{", "(", ")", "\"", "/*", "//", ",", ";", "\n", " ", "let", "\u{e9}"])) {
        let scene = include_str!("scenes/cornell.kin");
        let start = scene.floor_char_boundary(start % scene.len());
        let end = scene.floor_char_boundary((start + length).min(scene.len()));
        let text = [&scene[..start], put, &scene[end..]].concat();
        let tree = read(&text);
        match format(&tree) {
            Ok(formatted) => same(&text, &formatted),
            Err(found) if !tree.errors().is_empty() => {
                prop_assert!(found.iter().all(|found| found.code != "E1007"));
                let formatted = format_partial(&tree);
                prop_assert_eq!(letters(&text), letters(&formatted));
                prop_assert_eq!(format_partial(&read(&formatted)), formatted);
            }
            Err(found) => prop_assert!(false, "{}\n{:?}", text, found),
        }
    }
}
