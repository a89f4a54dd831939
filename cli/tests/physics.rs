//! Bodies from the command line: bakes that are kept, stale, damaged, stopped and resumed.
#![cfg(all(feature = "physics", feature = "render"))]

mod common;

use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::{Folder, exists};

/// Two bodies on the ground.
const DROP: &str = "lang 1\n
render { resolution: (24, 16), samples: 2, max_bounces: 2, fps: 8, duration: 1s }
camera main { position: (0, 1, 6), look_at: (0, 1, 0) }
sky { color: #bcd7ff }
diffuse paint { color: #d9402b }
plane ground { rigid_body { kind: fixed } }
sphere ball { radius: 50cm, position: (0, 2, 0), material: paint, rigid_body { restitution: 50% } }
box crate { position: (3, 0.5, 0), rigid_body { } }
";

fn drop(text: &str) -> Folder {
    let folder = Folder::new();
    folder.write("drop.kin", text);
    folder
}

/// What `kinora bake --json` says of one thing.
fn said(out: &str, name: &str) -> serde_json::Value {
    serde_json::from_str::<serde_json::Value>(out).unwrap()[name].clone()
}

#[test]
fn kept_by_what_physics_sees() {
    let folder = drop(DROP);
    folder.run("render drop.kin -q --frozen-bake").check(1, &["E0906", "it is not there", "kinora bake"]);
    assert!(!exists(&folder.path("cache")) && !exists(&folder.path("drop.png")));
    let first = folder.run("bake drop.kin --json").check(0, &[]).out;
    assert_eq!(
        (said(&first, "kept"), said(&first, "bodies"), said(&first, "steps")),
        (false.into(), 2.into(), 240.into())
    );
    assert_eq!(folder.names("cache"), ["drop.bake"]);
    let bytes = folder.read("cache/drop.bake");
    assert_eq!(said(&folder.run("bake drop.kin --json").check(0, &[]).out, "kept"), true);
    // Frames, alone and in a range, with the bake as it is.
    folder.run("render drop.kin -q --frozen-bake --frame 5 -o alone.png").check(0, &[]);
    folder.run("animate drop.kin -q --frozen-bake -o all.##.png").check(0, &[]);
    folder.run("render drop.kin -q --frame 0 -o start.png").check(0, &[]);
    let pixels = |name: &str| folder.read(name);
    assert_ne!(pixels("all.05.png"), pixels("all.00.png"));
    assert_eq!(folder.names(".").len(), 8 + 4);
    // What physics does not see changes nothing.
    let other = DROP.replace("#d9402b", "#2b40d9").replace("(0, 1, 6)", "(1, 1, 6)").replace("#bcd7ff", "#ffffff");
    folder.write("drop.kin", &(other + "sphere decoration { position: (0, 5, 0) }\nquad q { visible: false }\n"));
    folder.run("render drop.kin -q --frozen-bake").check(0, &[]);
    // What it sees does.
    folder.write("drop.kin", &DROP.replace("50%", "60%"));
    folder.run("render drop.kin -q --frozen-bake").check(1, &["E0906", "it was made for other bodies"]);
    folder.run("render drop.kin -q").check(0, &[]);
    folder.run("render drop.kin -q --frozen-bake").check(0, &[]);
    assert_ne!(folder.read("cache/drop.bake"), bytes);
    // Damaged: an error where none may be made, and made anew where it may.
    folder.write("drop.kin", DROP);
    for damage in [&bytes[..bytes.len() - 9], b"", b"kinora bake 1\n", b"something else altogether"] {
        std::fs::write(folder.path("cache/drop.bake"), damage).unwrap();
        folder.run("bake drop.kin --frozen-bake").check(1, &["E0906"]);
        folder.run("bake drop.kin -q").check(0, &[]);
        assert!(folder.read("cache/drop.bake") == bytes);
    }
}

#[test]
fn the_same_bytes_ten_times() {
    let keys = (0..10).map(|_| {
        let folder = drop(DROP);
        let key = said(&folder.run("bake drop.kin --json").check(0, &[]).out, "key").to_string();
        (key, folder.read("cache/drop.bake"))
    });
    let all: Vec<_> = keys.collect();
    assert!(all.iter().all(|one| *one == all[0]));
}

#[test]
fn places_and_names() {
    let folder = drop(&DROP.replace("render {", "simulation fall { duration: 0.1s }\nrender {"));
    folder.run("bake drop.kin").check(0, &["fall.bake", "2 bodies, 24 steps"]);
    folder.write("deep/kinora.toml", "");
    folder
        .write("deep/scenes/drop.kin", &DROP.replace("render {", "simulation { bake: \"../kept/a.bake\" }\nrender {"));
    folder.run("bake deep/scenes/drop.kin -q").check(0, &[]);
    assert_eq!(folder.names("deep/kept"), ["a.bake"]);
    // Nothing to do.
    folder.write("still.kin", "lang 1\ncamera main { position: (0, 0, 4) }\nsky { color: #fff }\nsphere ball { }\n");
    folder.run("bake still.kin").check(0, &["nothing to bake"]);
    folder.run("render still.kin -q --frozen-bake --size 8x8 --samples 1").check(0, &[]);
    folder.run("bake none.kin").check(2, &["there is no file"]);
    folder.write("wrong.kin", &DROP.replace("50%", "150%"));
    folder.run("bake wrong.kin").check(1, &["E0407"]);
    // Out of the project by a link, and no folder to write to: pictures come all the same.
    #[cfg(unix)]
    {
        let other = Folder::new();
        folder.write("linked/drop.kin", DROP);
        std::os::unix::fs::symlink(other.path("."), folder.path("linked/cache")).unwrap();
        folder.run("bake linked/drop.kin").check(2, &["cannot write", "outside the project"]);
        folder.run("render linked/drop.kin -q -o linked.png").check(0, &["computed anew"]);
        assert_eq!(other.names("."), [] as [&str; 0]);
    }
    folder.write("file/cache", "no folder");
    folder.write("file/drop.kin", DROP);
    folder.run("bake file/drop.kin").check(2, &["cannot write"]);
    folder.run("render file/drop.kin -q -o file.png").check(0, &["computed anew"]);
}

#[test]
fn findings_of_a_simulation() {
    let fast = DROP.replace("restitution: 50%", "velocity: (100000000m/s, 0, 0)");
    let folder = drop(&fast);
    folder.run("render drop.kin -q").check(1, &["E0905", "body `ball` left the world at 0.013s", "drop.kin:8:8"]);
    folder.write("drop.kin", &DROP.replace("(3, 0.5, 0)", "(0.9, 2, 0)"));
    let overlap = ["W0907", "bodies `ball` and `crate` overlap by 100 mm at 0s"];
    folder.run("check drop.kin").check(0, &overlap);
    folder.run("check drop.kin --deny warnings").check(1, &overlap);
    assert!(!folder.path("cache/drop.bake").exists(), "check bakes nothing");
    folder.run("bake drop.kin").check(0, &overlap);
    folder.write("kinora.toml", "[lints]\nallow = [\"W0907\"]\n");
    folder.write("drop.kin", &DROP.replace("(3, 0.5, 0)", "(0.9, 2.1, 0)"));
    for line in ["bake drop.kin", "check drop.kin --deny warnings"] {
        let ran = folder.run(line).check(0, &[]);
        assert!(!ran.err.contains("W0907"), "{}", ran.err);
    }
    folder.write("kinora.toml", "");
    let flat = "mesh leaf { positions: [(0, 5, 0), (1, 5, 0), (0, 5, 1)], indices: [0, 1, 2], rigid_body { } }\n";
    folder.write("drop.kin", &(DROP.to_string() + flat));
    folder.run("bake drop.kin").check(1, &["E0902", "`leaf`", "flat"]);
    let long = DROP.replace("render {", "simulation { rate: 100000Hz, duration: 100000s }\nrender {");
    folder.write("drop.kin", &long);
    folder.run("bake drop.kin").check(1, &["E1004", "GiB"]);
    folder.run("check drop.kin").check(1, &["E1004", "GiB"]);
    // In what is imported, and as often as it is said once.
    folder.write("lib.kin", "lang 1\nprefab crate(x: length) { box { position: (x, 0, 0), rigid_body { } } }\n");
    let import = "lang 1\nimport { crate } from \"lib.kin\"\ncamera { position: (0, 0, 9) }\nsky { color: #fff }\n";
    folder.write("drop.kin", &format!("{import}for i in 0..9 {{ crate {{ x: 0.9 * i }} }}\n"));
    folder.run("check drop.kin").check(0, &["W0907", "lib.kin:2:27", "by 100 mm", "7 more of them"]);
}

/// Balls that fly about in a room for a while, all of them all the time.
fn room(steps: u32) -> String {
    format!(
        "lang 1
camera main {{ position: (0, 0, 9) }}
sky {{ color: #fff }}
simulation {{ gravity: (0, 0, 0), rate: 100Hz, duration: {}s }}
for side in [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)] {{
    plane {{ normal: side, position: -3 * side, rigid_body {{ kind: fixed, restitution: 1 }} }}
}}
for i in 0..120 {{
    sphere {{
        radius: 10cm
        position: (0.5 * (i - 10 * floor(i / 10)) - 2.3, 0.5 * floor(i / 10) - 2.8, 2 * rand(i, 0) - 1)
        rigid_body {{ restitution: 1, velocity: 3m/s * (rand(i, 1) - 0.5, rand(i, 2) - 0.5, rand(i, 3) - 0.5) }}
    }}
}}
",
        f64::from(steps) / 100.0
    )
}

#[cfg(unix)]
#[test]
fn killed_and_resumed() {
    // As many steps as take a few seconds here.
    let folder = Folder::new();
    folder.write("room.kin", &room(500));
    let start = Instant::now();
    folder.run("bake room.kin -q").check(0, &[]);
    let per_step = (start.elapsed().as_secs_f64() / 500.0).max(1e-5);
    let text = room(((6.0 / per_step) as u32).clamp(2_000, 200_000));
    let whole = Folder::new();
    whole.write("room.kin", &text);
    let start = Instant::now();
    whole.run("bake room.kin -q").check(0, &[]);
    let all = start.elapsed();

    folder.write("room.kin", &text);
    std::fs::remove_file(folder.path("cache/room.bake")).unwrap();
    let part = folder.path("cache/room.bake.part");
    let length = || std::fs::metadata(&part).map_or(0, |data| data.len());
    // Killed without warning, after a record: what does not grow any more is a whole one, the next comes seconds later.
    let mut child = folder.command("bake room.kin -q").stdout(Stdio::null()).spawn().unwrap();
    let mut first = 0;
    while (first == 0 || length() != first) && child.try_wait().unwrap().is_none() {
        first = length();
        sleep(Duration::from_millis(200));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(first > 0 && !exists(&folder.path("cache/room.bake")), "the bake of {all:?} was over before it was killed");
    // Asked to end.
    let mut child = folder.command("bake room.kin").stderr(Stdio::null()).spawn().unwrap();
    sleep(all / 5);
    let status = std::process::Command::new("kill").arg(child.id().to_string()).status().unwrap();
    assert!(status.success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
    // On a busy machine it may not have come far.
    assert!(length() >= first && !exists(&folder.path("cache/room.bake")));
    // A record that was torn.
    let bytes = std::fs::read(&part).unwrap();
    std::fs::write(&part, &bytes[..bytes.len() - 100]).unwrap();
    folder.run("bake room.kin -q").check(0, &[]);
    assert!(folder.read("cache/room.bake") == whole.read("cache/room.bake"));
    assert_eq!(folder.names("cache"), ["room.bake"]);
}
