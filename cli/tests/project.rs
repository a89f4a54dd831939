//! What a project begins with, and what its pages say to run: the steps of the workflow and the hook before a commit, as
//! they are written.

mod common;

use std::process::{Command, Stdio};

use common::{Folder, Ran, exists};

/// A page of the book.
fn page(name: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// The block of code that follows some words on a page.
fn block<'p>(page: &'p str, after: &str) -> &'p str {
    let (_, rest) = page.split_once(after).unwrap_or_else(|| panic!("no {after:?}"));
    let (_, rest) = rest.split_once("```").unwrap();
    let (_, rest) = rest.split_once('\n').unwrap();
    rest.split_once("```").unwrap().0
}

/// A shell, in a folder of the project, that finds the program as an installed one.
#[cfg(unix)]
fn shell(folder: &Folder, inside: &str, script: &str) -> Ran {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_kinora")).parent().unwrap().to_path_buf();
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::join_paths(std::iter::once(program).chain(std::env::split_paths(&paths))).unwrap();
    let mut command = Command::new("bash");
    // As GitHub runs a step; nothing of this machine's git counts.
    command.args(["--noprofile", "--norc", "-eo", "pipefail", "-c", script]);
    command.current_dir(folder.path(inside)).env("PATH", paths).env("HOME", folder.path("")).stdin(Stdio::null());
    for name in ["AUTHOR", "COMMITTER"] {
        command.env(format!("GIT_{name}_NAME"), "A").env(format!("GIT_{name}_EMAIL"), "a@example.com");
    }
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "KINORA_FORMAT", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY"]
    {
        command.env_remove(name);
    }
    command.env("GIT_CONFIG_NOSYSTEM", "1");
    Ran::from(script, command.output().unwrap())
}

#[cfg(unix)]
fn has_git() -> bool {
    let found = Command::new("git").arg("--version").output().is_ok();
    if !found {
        eprintln!("there is no git here: not tested");
    }
    found
}

#[cfg(all(unix, feature = "render"))]
#[test]
fn the_workflow_as_written() {
    let folder = Folder::new();
    folder.run("new film").check(0, &[]);
    let workflow = String::from_utf8(folder.read("film/.github/workflows/scenes.yml")).unwrap();
    let steps: Vec<&str> = workflow.lines().filter_map(|line| line.trim().strip_prefix("run: ")).collect();
    assert_eq!(steps.len(), 4, "{workflow}");
    assert!(
        !workflow.contains('@') || workflow.matches('@').count() == workflow.matches("uses:").count(),
        "{workflow}"
    );
    assert!(steps[0].contains(env!("CARGO_PKG_REPOSITORY")), "{}", steps[0]);
    for step in &steps {
        shell(&folder, "film", step).check(0, &[]);
    }
    assert!(exists(&folder.path("film/report.html")) && exists(&folder.path("film/report.xml")));
    // The page has the same workflow.
    assert_eq!(block(&page("testing.md"), "In `.github/workflows/scenes.yml`:"), workflow);
    // A change of the picture is found by the last of them only, and one of the layout by the one before.
    let scene = String::from_utf8(folder.read("film/scene.kin")).unwrap();
    folder.write("film/scene.kin", &scene.replace("#f0c060", "#3060f0").replace("radius: 50cm", "radius:50cm"));
    let codes: Vec<Option<i32>> = steps.iter().map(|step| shell(&folder, "film", step).code).collect();
    assert_eq!(codes, [Some(0), Some(0), Some(1), Some(1)]);
}

#[cfg(unix)]
#[test]
fn the_hook_as_written() {
    use std::os::unix::fs::PermissionsExt;
    if !has_git() {
        return;
    }
    let folder = Folder::new();
    folder.run("new film").check(0, &[]);
    let git = |script: &str| shell(&folder, "film", script);
    git("git init -q && git add -A && git commit -q -m begin").check(0, &[]);
    let page = page("testing.md");
    folder.write("film/.git/hooks/pre-commit", block(&page, "`.git/hooks/pre-commit`"));
    let hook = folder.path("film/.git/hooks/pre-commit");
    std::fs::set_permissions(hook, std::fs::Permissions::from_mode(0o755)).unwrap();
    let scene = String::from_utf8(folder.read("film/scene.kin")).unwrap();

    // A scene and what it imports, both with spaces in their names.
    folder.write(
        "film/a b/it's \"one\".kin",
        "lang 1\n\nimport { brick } from \"part two.kin\"\n\ncamera { position: (0, 0, 5) }\nsky {}\nbrick {}\n",
    );
    folder.write("film/a b/part two.kin", "lang 1\n\nprefab brick() {\n    box {}\n}\n");
    git("git add -A && git commit -q -m more").check(0, &[]);
    // What is staged counts: a mistake there is found though the file was put right meanwhile, and the other way round.
    folder.write("film/scene.kin", &scene.replace("radius: 50cm", "raduis: 50cm"));
    git("git add -A").check(0, &[]);
    folder.write("film/scene.kin", &scene);
    git("git commit -q -m wrong").check(1, &["E0201", "scene.kin:"]);
    folder.write("film/scene.kin", &scene.replace("50cm", "60cm"));
    git("git add -A").check(0, &[]);
    folder.write("film/scene.kin", "lang 1\nsphere {");
    git("git commit -q -m right").check(0, &[]);
    git("git commit -q -a -m wrong").check(1, &["E0101"]);
    folder.write("film/scene.kin", &scene.replace("radius: 50cm", "radius:50cm"));
    let ran = git("git commit -q -a -m layout").check(1, &[]);
    assert!(ran.out.contains("scene.kin") || ran.err.contains("scene.kin"), "{} {}", ran.out, ran.err);
    // Nothing stays behind, and a project without scenes is none that is wrong.
    git("git checkout -q . && git rm -q -r '*.kin' && git commit -q -m none").check(0, &[]);
    assert_eq!(git("ls -a").out.matches("tmp").count(), 0);
}

#[test]
fn a_new_project_begins_anywhere() {
    let folder = Folder::new();
    // The program takes the folder as one word.
    let new = |name: &str, inside: &str| {
        let mut command = folder.command("new");
        Ran::from(name, command.arg(name).current_dir(folder.path(inside)).output().unwrap())
    };
    for name in ["with space & <b>", "\u{fc}n\u{ef}/deep/er", "-dash", "it's"] {
        if name.starts_with('-') {
            let mut command = folder.command("new --");
            Ran::from(name, command.arg(name).output().unwrap()).check(0, &[]);
        } else {
            new(name, "").check(0, &[]);
        }
        let inside = folder.path(name);
        for line in ["check . --deny warnings", "fmt . --check"] {
            let mut command = folder.command(line);
            Ran::from(line, command.current_dir(&inside).output().unwrap()).check(0, &[]);
        }
        #[cfg(feature = "render")]
        {
            let mut command = folder.command("test . --backend cpu");
            Ran::from("test", command.current_dir(&inside).output().unwrap()).check(0, &["1 right"]);
        }
    }
    std::fs::create_dir_all(folder.path("here/.git")).unwrap();
    new(".", "here").check(0, &[]);
    assert!(exists(&folder.path("here/scene.kin")));
    new(".", "here").check(2, &["is not empty"]);
}

#[test]
fn scenes_are_brought_to_this_version() {
    let folder = Folder::new();
    let (old, new) = ("ggx gold { color: #ffd700 }\nsky {}\n", "lang 1\n\nmetal gold { color: #ffd700 }\nsky {}\n");
    folder.write("a/old.kin", old);
    folder.write("a/late.kin", "sky {}\nlang 1\ncamera { position: (0, 0, 3) }\n");
    folder.write("a/new.kin", new);
    // Nothing but what versions are about: neither the layout nor other mistakes.
    folder.write("a/odd.kin", "lang 1\nsphere{raduis:1}\n");
    folder.write("kinora.toml", "[lints]\nwarnings = \"allow\"\n");
    let ran = folder.run("migrate a --check").check(1, &[]);
    assert_eq!(ran.out.lines().collect::<Vec<_>>(), ["a/late.kin", "a/old.kin"]);
    let ran = folder.run("migrate a/old.kin --diff").check(1, &[]);
    assert!(
        ran.out.contains("-ggx gold") && ran.out.contains("+metal gold") && ran.out.contains("+lang 1"),
        "{}",
        ran.out
    );
    assert_eq!(folder.read("a/old.kin"), old.as_bytes());
    folder.run("migrate a").check(0, &[]);
    assert_eq!(String::from_utf8(folder.read("a/old.kin")).unwrap(), new);
    assert_eq!(
        String::from_utf8(folder.read("a/late.kin")).unwrap(),
        "lang 1\n\nsky {}\n\ncamera { position: (0, 0, 3) }\n"
    );
    assert_eq!(folder.read("a/odd.kin"), b"lang 1\nsphere{raduis:1}\n");
    folder.run("migrate a --check").check(0, &[]);

    // What cannot be read, or is newer, stays; the others change all the same.
    folder.write("b/broken.kin", "ggx gold {\n");
    folder.write("b/newer.kin", "lang 7\nggx gold {}\n");
    folder.write("b/old.kin", old);
    folder.run("migrate b").check(2, &["E0101", "E0709", "this file needs version 7"]);
    assert_eq!(folder.read("b/newer.kin"), b"lang 7\nggx gold {}\n");
    assert_eq!(folder.read("b/old.kin"), new.as_bytes());
    folder.run("migrate nowhere.kin").check(2, &["there is no file `nowhere.kin`"]);

    let mut command = folder.command("migrate -");
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), old.as_bytes()).unwrap();
    assert_eq!(Ran::from("migrate -", child.wait_with_output().unwrap()).check(0, &[]).out, new);

    // The page has every name that changed.
    let page = page("migrate.md");
    for (old, new) in kinora_lang::schema::DEPRECATED {
        assert!(page.contains(&format!("`{old} ")) && page.contains(&format!("`{new} ")), "{old} is now {new}");
    }
}
