//! `test` and `diff`: scenes beside their reference pictures.
#![cfg(feature = "render")]

mod common;

use common::{Folder, exists};

/// A picture of one colour.
fn scene(color: &str, test: &str) -> String {
    format!(
        "lang 1\n{test}\nrender {{ resolution: (32, 24), samples: 4, tonemap: none }}\n\
         camera {{ position: (0, 0, 5), look_at: (0, 0, 0) }}\nsky {{ color: {color} }}\n"
    )
}

/// One right, one changed and one missing.
fn three() -> Folder {
    let folder = Folder::new();
    folder.write("scenes/a.kin", &scene("#ff0000", "// test: a.png"));
    folder.write("scenes/b.kin", &scene("#00ff00", "// test: pictures/b.png, samples 2, flip < 0.01"));
    folder.write("scenes/none.kin", &scene("#00ff00", "// it says nothing"));
    std::fs::create_dir(folder.path("scenes/pictures")).unwrap();
    let test = "test scenes --backend cpu";
    folder.run(test).check(1, &["missing scenes/a.kin:2: a.png: there is no reference", "2 missing", "--bless"]);
    folder.run(&format!("{test} --bless")).check(0, &["blessed scenes/b.kin:2: pictures/b.png", "2 blessed"]);
    folder.run(test).check(0, &["right scenes/a.kin:2: a.png: flip 0.0000 < 0.02", "tested 2 pictures", "2 right"]);
    folder.write("scenes/b.kin", &scene("#10f010", "// test: pictures/b.png, samples 2, flip < 0.01"));
    folder.write("scenes/c.kin", &scene("#0000ff", "// test: c.exr, error < 1e-4\n// test: d.png, flop < 1"));
    folder
}

#[test]
fn right_changed_missing() {
    let folder = three();
    let before = folder.read("scenes/pictures/b.png");
    let ran = folder.run("test scenes --backend cpu --html out.html --junit out.xml").check(
        1,
        &[
            "changed scenes/b.kin:2: pictures/b.png: flip 0.",
            "≥ 0.01",
            "missing scenes/c.kin:2: c.exr",
            "faulty scenes/c.kin:3: `flop` is not known here; did you mean `flip`?",
            "tested 4 pictures in ",
            "1 right, 1 changed, 1 missing, 1 faulty",
        ],
    );
    assert_eq!(ran.out, "");
    assert!(folder.read("scenes/pictures/b.png") == before && !exists(&folder.path("scenes/c.exr")));

    let xml = String::from_utf8(folder.read("out.xml")).unwrap();
    assert!(xml.contains("<testsuites name=\"kinora test\" tests=\"4\" failures=\"3\" errors=\"0\">"), "{xml}");
    assert!(xml.contains("<testcase name=\"a.png\" classname=\"scenes/a.kin\" time=\""), "{xml}");
    assert!(xml.contains("<failure type=\"changed\" message=\"flip 0."), "{xml}");
    let html = String::from_utf8(folder.read("out.html")).unwrap();
    // Two pictures of each comparison stand side by side and to swipe, with a third of the difference.
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 5 + 5 + 1);
    assert!(!html.contains("http") && html.contains("class=\"wrong\" open"), "nothing comes from elsewhere");

    // What is blessed is what `render` writes.
    folder.run("test scenes/b.kin --backend cpu --bless -q").check(0, &[]);
    folder.run("render scenes/b.kin --backend cpu --samples 2 -o b.png -q").check(0, &[]);
    assert!(folder.read("b.png") == folder.read("scenes/pictures/b.png"));
    folder.run("test scenes/b.kin --backend cpu").check(0, &["1 right"]);
}

#[test]
fn what_keeps_a_scene_from_a_picture() {
    let folder = Folder::new();
    folder.write("a.kin", &scene("#ff000", "// test: a.png"));
    folder.write("b.kin", &scene("#ff0000", "// test: b.png, param hue=3"));
    folder.write("c.kin", &scene("#ff0000", "// test: c.png\n// test: c.tiff"));
    folder.write("c.png", "no picture");
    folder.run("test a.kin b.kin c.kin --backend cpu").check(
        1,
        &[
            "faulty a.kin:2: a.png: the scene has mistakes",
            "E0117",
            "faulty b.kin:2: b.png",
            "hue",
            "faulty c.kin:2: c.png: cannot read `c.png`",
            "faulty c.kin:3: c.tiff: pictures cannot be written as `.tiff`",
        ],
    );
    folder.write("d.kin", &scene("#ff0000", ""));
    folder.run("test d.kin --backend cpu").check(2, &["no scene here names a reference"]);
    folder.run("test d.kin --backend cpu --allow-empty").check(0, &["nothing to do"]);
    folder.run("test nowhere.kin --backend cpu").check(2, &["cannot read `nowhere.kin`"]);
    folder.run("test a.kin --html nowhere/out.html").check(2, &["there is no folder `nowhere`"]);
}

#[test]
fn two_pictures() {
    let folder = Folder::new();
    for (name, color) in [("a", "#808080"), ("b", "#888888")] {
        folder.write(&format!("{name}.kin"), &scene(color, ""));
        for ending in ["png", "exr", "hdr", "jpg"] {
            folder.run(&format!("render {name}.kin --backend cpu -q -o {name}.{ending}")).check(0, &[]);
        }
    }
    let ran = folder.run("diff a.png a.png").check(0, &[]);
    assert_eq!(ran.out, "they are the same\n");
    for ending in ["png", "exr", "hdr", "jpg"] {
        let ran = folder.run(&format!("diff a.{ending} b.{ending} --json")).check(1, &[]);
        let numbers: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
        let [flip, error] = ["flip", "error"].map(|name| numbers[name].as_f64().unwrap());
        // 0x80 and 0x88 in linear light, squared and relative.
        let expected = (0.2462_f64 - 0.2159).powi(2) / (0.2159_f64.powi(2) + 0.01);
        assert!((error - expected).abs() < 0.05 * expected + 3e-4, "{ending}: {error}, not {expected}");
        assert!(flip > 0.005 && flip < 0.2, "{ending}: {flip}");
        folder.run(&format!("diff a.{ending} b.{ending} --flip 0.3")).check(0, &[]);
    }
    folder.run("diff a.png b.png --html d.html -o d.png").check(1, &[]);
    assert!(exists(&folder.path("d.html")) && folder.read("d.png").starts_with(b"\x89PNG"));
    folder.run("diff a.png b.exr").check(2, &["linear light"]);
    folder.run("diff a.png c.png").check(2, &["cannot read `c.png`"]);
    folder.run("diff a.png a.kin").check(2, &["pictures are compared as"]);
    folder.run("render a.kin --backend cpu -q --size 8x8 -o s.png").check(0, &[]);
    folder.run("diff a.png s.png").check(2, &["the reference is 32 × 24, the picture 8 × 8"]);
}
