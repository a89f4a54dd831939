//! `test` and `diff`: scenes beside their reference pictures.
#![cfg(feature = "render")]

mod common;

use common::{Folder, Ran, exists};

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
            "faulty scenes/c.kin:3: `flop` is not known here",
            "did you mean `flip`?",
            "tested 4 pictures in ",
            "1 right, 1 changed, 1 missing, 1 faulty",
        ],
    );
    assert_eq!(ran.out, "");
    assert!(folder.read("scenes/pictures/b.png") == before && !exists(&folder.path("scenes/c.exr")));

    let xml = String::from_utf8(folder.read("out.xml")).unwrap();
    for piece in [
        "<testsuites name=\"kinora test\" tests=\"4\" failures=\"2\" errors=\"1\" time=\"",
        "<testsuite name=\"scenes/a.kin\" tests=\"1\" failures=\"0\" errors=\"0\" time=\"",
        "<testsuite name=\"scenes/c.kin\" tests=\"2\" failures=\"1\" errors=\"1\" time=\"",
        "<testcase name=\"a.png\" classname=\"scenes/a.kin\" file=\"scenes/a.kin\" line=\"2\" time=\"",
        "<failure type=\"changed\" message=\"flip 0.",
        "<failure type=\"missing\" message=\"there is no reference\">",
        "<error type=\"faulty\" message=\"`flop` is not known here\">",
    ] {
        assert!(xml.contains(piece), "no {piece} in {xml}");
    }
    let html = String::from_utf8(folder.read("out.html")).unwrap();
    // The new picture where one is missing, and two with the difference where there is something to compare.
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 3 + 3 + 1);
    assert_eq!((html.matches("data-swipe>").count(), html.matches("class=\"scale\"").count()), (2, 2));
    for piece in [
        "<code>pictures/b.png, samples 2, flip &lt; 0.01</code>",
        "<code>kinora test scenes/b.kin --bless</code>",
        "did you mean `flip`?",
        "alt=\"the reference of scenes/b.kin: pictures/b.png\"",
    ] {
        assert!(html.contains(piece), "no {piece}");
    }
    assert!(!html.contains("http:") && !html.contains("https:"), "nothing comes from elsewhere");
    assert!(html.find("class=\"wrong\" open") < html.find("class=\"right\">"), "what is wrong comes first");

    let ran = folder.run("test scenes --backend cpu --json -q").check(1, &[]);
    let records: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let of = |at: usize| (records[at]["scene"].as_str().unwrap(), records[at]["verdict"].as_str().unwrap());
    let verdicts = [("scenes/a.kin", "right"), ("scenes/b.kin", "changed"), ("scenes/c.kin", "missing")];
    assert_eq!([of(0), of(1), of(2)], verdicts);
    assert!(records[1]["flip"].as_f64() > Some(0.01) && records[2]["flip"].is_null() && records[3]["line"] == 3);

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
    let line = "test a.kin b.kin c.kin --backend cpu";
    folder.run(line).check(
        1,
        &[
            "faulty a.kin:2: a.png: the scene has mistakes",
            "E0117",
            "faulty b.kin:2: b.png",
            "hue",
            "faulty c.kin:2: c.png: the reference cannot be read",
            "faulty c.kin:3: `c.tiff` is no picture to compare with",
            "4 faulty",
        ],
    );
    // A reference that is no picture is written anew; where there is no picture, nothing is.
    folder.run(&format!("{line} --bless")).check(1, &["blessed c.kin:2: c.png", "1 blessed, 3 faulty"]);
    assert!(folder.read("c.png").starts_with(b"\x89PNG") && !exists(&folder.path("a.png")));
    folder.write("d.kin", &scene("#ff0000", "/*\n// test: d.png\n*/"));
    folder.run("test d.kin --backend cpu").check(2, &["no scene here names a reference"]);
    folder.run("test d.kin --backend cpu --allow-empty").check(0, &["nothing to do"]);
    folder.run("test nowhere.kin --backend cpu").check(2, &["cannot read `nowhere.kin`"]);
    folder.run("test a.kin --html nowhere/out.html").check(2, &["there is no folder `nowhere`"]);
}

#[test]
fn references_stay_in_the_project() {
    let folder = Folder::new();
    folder.write("p/kinora.toml", "");
    folder.write("p/scenes/a.kin", &scene("#ff0000", "// test: ../pictures/new/a.png\n// test: /pictures/b.exr"));
    folder.run("test p --backend cpu --bless").check(0, &["2 blessed"]);
    assert_eq!(
        (folder.names("p/pictures"), folder.names("p/pictures/new")),
        (names(&["b.exr", "new"]), names(&["a.png"]))
    );
    folder.run("test p --backend cpu").check(0, &["2 right"]);
    // What is right keeps its bytes.
    let before = std::fs::metadata(folder.path("p/pictures/b.exr")).unwrap().modified().unwrap();
    folder.run("test p --backend cpu --bless").check(0, &["2 right"]);
    assert_eq!(std::fs::metadata(folder.path("p/pictures/b.exr")).unwrap().modified().unwrap(), before);

    folder.write("p/scenes/out.kin", &scene("#ff0000", "// test: ../../out.png\n// test: ./a.png\n// test: a.png"));
    let pieces = ["`../../out.png` is outside the project", "`a.png` is named twice", "1 blessed, 2 faulty"];
    folder.run("test p/scenes/out.kin --backend cpu --bless").check(1, &pieces);
    assert!(!exists(&folder.path("out.png")));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../..", folder.path("p/scenes/away")).unwrap();
        folder.write("p/scenes/link.kin", &scene("#ff0000", "// test: away/out.png\n// test: away/deep/out.png"));
        folder.run("test p/scenes/link.kin --backend cpu --bless").check(1, &["links outside the project", "2 faulty"]);
        assert!(!exists(&folder.path("out.png")) && !exists(&folder.path("deep")));
    }
}

fn names(list: &[&str]) -> Vec<String> {
    list.iter().map(|name| name.to_string()).collect()
}

#[test]
fn github_shows_what_changed() {
    let folder = three();
    let mut command = folder.command("test scenes --backend cpu");
    command.env("GITHUB_ACTIONS", "true").env("GITHUB_STEP_SUMMARY", folder.path("summary.md"));
    let ran = Ran::from("test", command.output().unwrap()).check(1, &["1 changed"]);
    let start = "::error title=kinora test,file=scenes/b.kin,line=2::pictures/b.png is changed: flip 0.";
    assert!(ran.out.starts_with(start), "{}", ran.out);
    assert_eq!(ran.out.lines().count(), 3);
    let summary = String::from_utf8(folder.read("summary.md")).unwrap();
    assert!(summary.contains("| missing | scenes/c.kin:2 | c.exr: there is no reference |"), "{summary}");
}

#[test]
fn names_of_all_kinds() {
    let folder = Folder::new();
    let name = "a <b> & 'c' \u{fc}\u{1f600}";
    folder.write(&format!("{name}.kin"), &scene("#ff0000", &format!("// test: \"{name}, 1.png\", samples 1")));
    let run = |flags: &[&str]| {
        let mut command = folder.command("test . --backend cpu");
        Ran::from("test .", command.args(flags).output().unwrap())
    };
    run(&["--html", "out.html", "--junit", "out.xml"])
        .check(1, &[&format!("missing {name}.kin:2: {name}, 1.png: there")]);
    let escaped = name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    for file in ["out.html", "out.xml"] {
        let text = String::from_utf8(folder.read(file)).unwrap();
        assert!(text.contains(&escaped) && !text.contains(name), "{file}");
    }
    run(&["--bless"]).check(0, &["1 blessed"]);
    run(&["-q"]).check(0, &[]);
}

#[test]
fn transparent_pictures() {
    let folder = Folder::new();
    let text = scene("#ff0000", "// test: a.png, flip < 0.0001\n// test: a.exr, error < 1e-9")
        .replace("tonemap: none", "tonemap: none, background: transparent");
    folder.write("a.kin", &(text + "sphere ball { radius: 1, material: diffuse { color: #40c080 } }\n"));
    folder.run("test a.kin --backend cpu --bless").check(0, &["2 blessed"]);
    folder.run("test a.kin --backend cpu").check(0, &["2 right"]);
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
    folder.run("diff a.png b.png --flip 0.3 --error 0").check(1, &[]);
    folder.run("diff a.png b.png --error 1").check(0, &[]);
    folder.run("diff a.png b.exr").check(2, &["linear light", "compare two of a kind"]);
    folder.run("diff a.png c.png").check(2, &["cannot read `c.png`"]);
    folder.run("diff a.png a.kin").check(2, &["pictures are compared as"]);
    folder.run("render a.kin --backend cpu -q --size 8x8 -o s.png").check(0, &[]);
    let ran = folder.run("diff a.png s.png --flip 1 --html s.html -o none.png").check(1, &[]);
    assert_eq!(ran.out, "the reference is 32 × 24, the picture 8 × 8\n");
    let html = String::from_utf8(folder.read("s.html")).unwrap();
    assert!(html.matches("src=\"data:image/png;base64,").count() == 2 && !exists(&folder.path("none.png")));
}
