//! The commands that need no renderer, run as a user runs them.

mod common;

use std::io::Write;
use std::process::Stdio;

use common::{Folder, HELLO, Ran};

const BROKEN: &str = "lang 1\ncamera main { position: (0, 1, 4), look_at: (0, 0, 0) }\nsphere ball { raduis: 1 }\n";

#[test]
fn a_clean_scene() {
    let ran = Folder::hello().run("check hello.kin").check(0, &["checked 1 file in ", "no mistakes"]);
    assert_eq!(ran.out, "");
}

#[test]
fn findings_end_in_1() {
    let folder = Folder::new();
    folder.write("a/broken.kin", BROKEN);
    folder
        .run("check a/broken.kin")
        .check(1, &["error[E0201]: unknown property `raduis`", "a/broken.kin:3:15", "1 error, 1 fixable with --fix\n"]);
    folder.run("check a/broken.kin --format short").check(1, &["a/broken.kin:3:15: error[E0201]: unknown property"]);
    folder.run("inspect a/broken.kin").check(1, &["E0201"]);
}

#[test]
fn json_goes_to_stdout() {
    let folder = Folder::new();
    folder.write("a.kin", HELLO);
    folder.write("b.kin", BROKEN);
    let ran = folder.run("check a.kin b.kin --format json").check(1, &["checked 2 files in "]);
    assert_eq!(ran.err.lines().count(), 1);
    let records: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(records[0]["code"], "E0201");
    assert_eq!(records[0]["file"], "b.kin");
    assert_eq!(records[0]["span"]["line"], 3);
}

#[test]
fn the_environment_chooses_the_format() {
    let folder = Folder::new();
    folder.write("b.kin", BROKEN);
    let run =
        |format: &str, line: &str| Ran::from(line, folder.command(line).env("KINORA_FORMAT", format).output().unwrap());
    run("short", "check b.kin").check(1, &["b.kin:3:15: error[E0201]"]);
    run("json", "check b.kin --format short").check(1, &["b.kin:3:15: error[E0201]"]);
    run("xml", "check b.kin").check(2, &["KINORA_FORMAT is `xml`"]);
}

#[test]
fn warnings_can_be_denied() {
    let folder = Folder::new();
    folder.write("a.kin", &HELLO.replace("lang 1\n", ""));
    folder.run("check a.kin").check(0, &["warning[W0710]", "1 warning"]);
    folder.run("check a.kin --deny warnings").check(1, &["error[W0710]"]);
}

#[test]
fn standard_input() {
    let folder = Folder::new();
    let run = |line: &str, text: &str| {
        let mut command = folder.command(line);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        Ran::from(line, child.wait_with_output().unwrap())
    };
    run("check -", HELLO).check(0, &["no mistakes"]);
    run("check - --format short", BROKEN).check(1, &["stdin.kin:3:15: error[E0201]"]);
    run("check - --format short --stdin-path new.kin", BROKEN).check(1, &["new.kin:3:15: error[E0201]"]);
}

#[test]
fn scenes_are_laid_out() {
    let folder = Folder::new();
    let (untidy, tidy) = ("lang 1\nsky{color:#FFF}\n", "lang 1\nsky { color: #fff }\n");
    let faulty = "lang 1\nsky{color:#FFF}\nbox a { size  1 }\n";
    let run = |line: &str, text: &str| {
        let mut command = folder.command(line);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        Ran::from(line, child.wait_with_output().unwrap())
    };
    for (name, text) in [("a/x.kin", untidy), ("a/y.kin", tidy), ("a/z.txt", untidy), ("b.kin", faulty)] {
        folder.write(name, text);
    }
    assert_eq!(folder.run("fmt a --check").check(1, &[]).out.replace('\\', "/"), "a/x.kin\n");
    let diff = folder.run("fmt a --diff").check(1, &[]).out;
    assert!(diff.contains("-sky{color:#FFF}\n+sky { color: #fff }\n"), "{diff}");
    assert_eq!(folder.read("a/x.kin"), untidy.as_bytes());
    // A faulty file stays as it is and keeps no other from being laid out.
    folder.run("fmt b.kin a").check(2, &["E0105", "b.kin:3"]);
    assert_eq!(folder.read("a/x.kin"), tidy.as_bytes());
    assert_eq!(folder.read("b.kin"), faulty.as_bytes());
    assert_eq!(folder.names("a"), ["x.kin", "y.kin", "z.txt"]);
    folder.run("fmt a --check").check(0, &[]);
    folder.run("fmt b.kin --partial").check(1, &["E0105"]);
    assert_eq!(folder.read("b.kin"), "lang 1\nsky { color: #fff }\nbox a { size  1 }\n".as_bytes());
    assert_eq!(run("fmt -", untidy).check(0, &[]).out, tidy);
    assert_eq!(run("fmt - --check", untidy).check(1, &[]).out, "stdin.kin\n");
    assert_eq!(run("fmt - --stdin-path n.kin", faulty).check(2, &["n.kin:3"]).out, "");
    folder.run("fmt missing.kin").check(2, &["there is no file `missing.kin`"]);
}

#[cfg(unix)]
#[test]
fn a_scene_that_is_laid_out_keeps_its_permissions_and_its_links() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = Folder::new();
    folder.write("real.kin", "sky{}\n");
    std::fs::set_permissions(folder.path("real.kin"), std::fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.kin", folder.path("link.kin")).unwrap();
    folder.run("fmt link.kin").check(0, &[]);
    assert_eq!(folder.read("real.kin"), b"sky {}\n");
    assert_eq!(std::fs::metadata(folder.path("real.kin")).unwrap().permissions().mode() & 0o777, 0o640);
    assert!(folder.path("link.kin").is_symlink());
}

#[test]
fn folders_are_searched() {
    let folder = Folder::new();
    for name in ["a/x.kin", "a/b/y.kin", "a/.hidden/z.kin", "a/target/z.kin", "a/note.txt"] {
        folder.write(name, HELLO);
    }
    folder.write("empty/note.txt", "");
    folder.run("check a").check(0, &["checked 2 files"]);
    folder.run("check a/target").check(0, &["checked 1 file"]);
    folder.run("check empty").check(2, &["there is no *.kin in `empty`"]);
    folder.run("check missing.kin").check(2, &["there is no file `missing.kin`"]);
    folder.run("check missing/a.kin").check(2, &["there is no file `missing/a.kin`"]);
}

#[test]
fn the_last_frame_is_checked_too() {
    let folder = Folder::new();
    folder.write("a.kin", &HELLO.replace("radius: 50cm", "radius: 1m - 1m * time / 1s"));
    folder.run("check a.kin").check(1, &["E0401", "a.kin:7:", "`radius` of `ball`"]);
}

#[test]
fn codes_are_explained() {
    let folder = Folder::new();
    let ran = folder.run("explain e0115").check(0, &[]);
    assert!(ran.out.starts_with("# E0115: "), "{}", ran.out);
    let ran = folder.run("explain E0115 --json").check(0, &[]);
    assert_eq!(serde_json::from_str::<serde_json::Value>(&ran.out).unwrap()["code"], "E0115");
    let ran = folder.run("explain --all --json").check(0, &[]);
    assert!(serde_json::from_str::<Vec<serde_json::Value>>(&ran.out).unwrap().len() > 20);
    folder.run("explain E0195").check(2, &["there is no code `E0195`; did you mean E01"]);
    folder.run("explain nonsense").check(2, &["`kinora explain --all` lists them"]);
}

#[test]
fn what_a_scene_contains() {
    let folder = Folder::hello();
    let ran = folder.run("inspect hello.kin").check(0, &[]);
    assert!(ran.out.contains("2: 1 plane, 1 sphere") && ran.out.contains("16 frames"), "{}", ran.out);
    let ran = folder.run("inspect hello.kin --ron --set render.samples=9").check(0, &[]);
    let scene: kinora_scene::Scene = ron::from_str(&ran.out).unwrap();
    assert_eq!((scene.render.samples, scene.nodes.len()), (9, 2));
}

#[test]
fn parameters_are_listed_and_changed() {
    let folder = Folder::new();
    let params = "/// How large.\nparam size: float = 0.5 in 0.1..2\n";
    folder.write(
        "a.kin",
        &(HELLO.replace("radius: 50cm", "radius: size").replace("lang 1\n", &format!("lang 1\n{params}"))),
    );
    let ran = folder.run("params a.kin --json").check(0, &[]);
    let list: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(list[0]["name"], "size");
    assert_eq!(list[0]["doc"], "How large.");
    assert!(folder.run("params a.kin").check(0, &[]).out.contains("size"));
    let ran = folder.run("inspect a.kin --ron -D size=0.25").check(0, &[]);
    assert!(ran.out.contains("radius_m: Const(0.25)"), "{}", ran.out);
    folder.run("inspect a.kin -D size=9").check(1, &["E0413"]);
    folder.run("inspect a.kin -D size=abc").check(1, &["E0414"]);
    folder.run("inspect a.kin -D size").check(2, &["write a name, `=` and a value"]);
}

#[cfg(feature = "render")]
#[test]
fn facts_for_a_bug_report() {
    let ran = Folder::new().run("info --json").check(0, &[]);
    let info: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!(info["version"], env!("CARGO_PKG_VERSION"));
    assert!(info["threads"].as_u64() > Some(0));
    // The CPU and every GPU that there is show the right picture.
    let adapters = info["adapters"].as_array().unwrap();
    for device in adapters.iter().chain([&info]) {
        assert_eq!(device["self_test"]["ok"], true, "{device}");
        assert!(device["self_test"]["off"].as_f64().unwrap() < 0.02);
    }
    assert_eq!(info["problems"], serde_json::json!([]));
    let ran = Folder::new().run("info").check(0, &[]);
    assert_eq!(ran.out.matches("self-test ok").count(), 1 + adapters.len(), "{}", ran.out);
}

#[test]
fn wrong_flags_end_in_2() {
    let folder = Folder::hello();
    folder.run("").check(2, &["Usage: kinora"]);
    folder.run("chekc hello.kin").check(2, &["check"]);
    folder.run("check hello.kin --frmat full").check(2, &["--format"]);
    folder.run("inspect .").check(2, &["cannot read"]);
}

#[test]
fn colour() {
    let folder = Folder::new();
    folder.write("b.kin", BROKEN);
    let coloured = |line: &str, set: &[(&str, &str)]| {
        let mut command = folder.command(line);
        command.envs(set.iter().copied());
        Ran::from(line, command.output().unwrap()).err.contains('\x1b')
    };
    for (line, set, expected) in [
        ("check b.kin", &[][..], false),
        ("check b.kin --color always", &[][..], true),
        ("--color=always check b.kin", &[("NO_COLOR", "1")][..], true),
        ("check b.kin", &[("CLICOLOR_FORCE", "1")][..], true),
        ("check b.kin", &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")][..], false),
        ("check b.kin --color never", &[("CLICOLOR_FORCE", "1")][..], false),
        ("check --nonsense", &[("CLICOLOR_FORCE", "1")][..], true),
        ("check --nonsense --color never", &[("CLICOLOR_FORCE", "1")][..], false),
    ] {
        assert_eq!(coloured(line, set), expected, "{line} {set:?}");
    }
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = Folder::new();
    let mut command = folder.command("explain --all");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    Ran::from("explain --all", child.wait_with_output().unwrap()).check(0, &[]);
}

#[test]
fn shells_and_manuals() {
    let folder = Folder::new();
    for (shell, piece) in [
        ("bash", "complete -F _kinora"),
        ("zsh", "#compdef kinora"),
        ("fish", "complete -c kinora"),
        ("powershell", "Register-ArgumentCompleter"),
        ("nushell", "export extern kinora"),
    ] {
        let ran = folder.run(&format!("completions {shell}")).check(0, &[]);
        assert!(ran.out.contains(piece) && ran.out.contains("explain"), "{shell}: {}", ran.out);
    }
    folder.run("completions csh").check(2, &["invalid value 'csh'"]);
    assert!(folder.run("man").check(0, &[]).out.contains(".TH kinora 1"));
    folder.run("man -o manual/pages").check(0, &[]);
    let page = String::from_utf8(folder.read("manual/pages/kinora-check.1")).unwrap();
    assert!(page.contains(".TH kinora-check 1") && page.contains("deny"), "{page}");
    assert!(folder.names("manual/pages").contains(&"kinora.1".to_string()));
}

#[test]
fn a_new_project() {
    let folder = Folder::new();
    folder.run("new film").check(0, &[]);
    let names = [".github", ".gitignore", "README.md", "kinora.toml", "scene.kin"];
    assert!(names.iter().all(|name| folder.names("film").contains(&name.to_string())), "{:?}", folder.names("film"));
    folder.run("new film").check(2, &["`film` is not empty"]);
    folder.write("file", "");
    folder.run("new file").check(2, &["`file` is a file"]);
}
