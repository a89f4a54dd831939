//! Texts that would take for ever if each mistake, each turn and each name took its time.

use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Overrides, eval, parse};

const HEAD: &str = "lang 1\ncamera main { position: (0, 0, 4), look_at: (0, 0, 0) }\nsky { color: #fff }\n";

/// The codes of what is found.
fn codes(text: &str) -> Vec<&'static str> {
    let tree = parse(&Source::new(FileId(0), "a.kin", format!("{HEAD}{text}")));
    match eval(&tree, &Memory::default(), &Overrides::default()) {
        Ok(evaluated) => evaluated.warnings.iter().map(|found| found.code).collect(),
        Err(found) => found.iter().map(|found| found.code).collect(),
    }
}

#[test]
fn many_mistakes() {
    assert_eq!(codes(&"}".repeat(50_000)), ["E0102"]);
    assert_eq!(codes(&"}\n".repeat(5_000)).len(), 5_000);
    assert!(codes(&"a: (1,,2), ".repeat(10_000)).contains(&"E0115"));
    let block = format!("group {{\n{}}}\n", "  sphere { }\n".repeat(5_000));
    assert_eq!(codes(&format!("{block}{}", "}\n".repeat(5_000))).len(), 5_000);
    let astray = format!("sphere {{ radius: 1 }}\n{}{}", "scale: 1\n".repeat(5_000), "}\n".repeat(5_000));
    assert!(codes(&astray).contains(&"E0102"));
    // Each of these names is looked for in all of the text, so that a fix finds its other places.
    let dashed: String = (0..20_000).map(|i| format!("sphere my-ball{i} {{ radius: 1 }}\n")).collect();
    assert!(codes(&dashed).contains(&"E0114"));
    let needs = "model { clip: \"a\" }\n".repeat(20_000);
    assert!(codes(&format!("sphere {{ radius 1 }}\ngroup {{\n{needs}")).contains(&"E0207"));
}

#[test]
fn many_unknown_names() {
    let declared: String = (0..3_000).map(|i| format!("let variable_{i} = {i}\n")).collect();
    let used: String = (0..3_000).map(|i| format!("sphere {{ radius: varable_{i} }}\n")).collect();
    let found = codes(&format!("{declared}{used}"));
    assert_eq!(found.iter().filter(|code| **code == "E0203").count(), 3_000);
}

#[test]
fn many_allowances() {
    let comments = "// allow(W0201): why\n".repeat(20_000);
    let found = codes(&format!("{comments}let x = 1\nsphere {{ }}\n"));
    // The first of them allows that `x` is not used, the others nothing.
    assert_eq!((found.len(), found.first(), found.last()), (19_999, Some(&"W0903"), Some(&"W0903")));
}

#[test]
fn doubling() {
    let chain = |first: &str, next: fn(usize) -> String| {
        let lets: String = (0..64).map(|i| format!("let a{} = {}\n", i + 1, next(i))).collect();
        codes(&format!("let a0 = {first}\n{lets}sphere {{ radius: a64 }}\n"))
    };
    assert!(chain("[1]", |i| format!("a{i} + a{i}")).contains(&"E1004"));
    assert!(chain("[1]", |i| format!("[a{i}, a{i}]")).contains(&"E1004"));
    assert!(chain("\"text\"", |i| format!("a{i} + a{i}")).contains(&"E1004"));
}

#[test]
fn loops_and_calls() {
    assert_eq!(codes("for i in 0..1000000000 { sphere { } }\n"), ["E1002"]);
    assert_eq!(codes("for i in 0..1000000 { for k in 0..1000000 { group { } } }\n"), ["E1004"]);
    assert!(codes("let a = [for i in 0..100000: i]\nfor i in 0..1000000 { let b = a + a }\n").contains(&"E1003"));
    let calls = "prefab p(n: int) { if n < 200 { p { n: n + 1 }\n p { n: n + 1 } } }\np { n: 0 }\n";
    assert!(codes(calls).iter().any(|code| matches!(*code, "E1003" | "E1004")));
}

/// A node that is written in a loop and says nothing of the turn is one node.
#[test]
fn what_no_turn_changes_is_made_once() {
    let nodes = |text: &str| {
        let tree = parse(&Source::new(FileId(0), "a.kin", format!("{HEAD}{text}")));
        let scene = eval(&tree, &Memory::default(), &Overrides::default()).unwrap().scene;
        let copies: usize = scene.nodes.iter().filter_map(|node| node.copies.as_ref()).map(|of| of.at.len()).sum();
        (scene.nodes.iter().filter(|node| node.shape.is_some()).count(), scene.materials.len(), copies)
    };
    let turns = |inside: &str| nodes(&format!("let r = 1\nfor i in 0..5 {{ {inside} }}\n"));
    assert_eq!(turns("instance { of: group { sphere { radius: r } }, position: (i, 0, 0) }"), (1, 1, 5));
    assert_eq!(turns("instance { of: group { sphere { radius: r + i } }, position: (i, 0, 0) }").0, 5);
    assert_eq!(turns("let s = i + 1\ninstance { of: group { sphere { radius: s } }, position: (i, 0, 0) }").0, 5);
    assert_eq!(turns("sphere { position: (3 * i, 0, 0), material: diffuse { color: #f00 } }").1, 1);
    assert_eq!(turns("sphere { position: (3 * i, 0, 0), material: diffuse { color: srgb(i / 5, 0, 0) } }").1, 5);
}
