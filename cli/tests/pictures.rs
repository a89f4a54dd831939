//! `render` and `animate`, run as a user runs them.
#![cfg(feature = "render")]

mod common;

use std::collections::BTreeMap;
use std::io::BufReader;

use common::{Folder, HELLO, exists};

/// Width, height, bits and texts of a PNG.
fn png(folder: &Folder, name: &str) -> (u32, u32, u8, BTreeMap<String, String>) {
    let file = BufReader::new(std::fs::File::open(folder.path(name)).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert!(pixels.iter().any(|value| *value != pixels[0]), "{name} shows nothing");
    let info = reader.info();
    assert!(info.srgb.is_some());
    let texts = info.uncompressed_latin1_text.iter().map(|text| (text.keyword.clone(), text.text.clone()));
    (info.width, info.height, info.bit_depth as u8, texts.collect())
}

#[test]
fn a_picture_and_what_it_says() {
    let folder = Folder::hello();
    let ran = folder.run("render hello.kin --backend cpu --seed 3 --frame 2").check(0, &[]);
    assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""));
    assert_eq!(folder.names("."), ["hello.kin", "hello.png"]);
    let (width, height, bits, texts) = png(&folder, "hello.png");
    assert_eq!((width, height, bits), (24, 16, 8));
    let said: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    let version = env!("CARGO_PKG_VERSION");
    let software = format!("kinora {version}");
    let hash = texts["kinora:scene"].as_str();
    assert_eq!(
        said,
        [
            ("Software", software.as_str()),
            ("kinora:backend", "cpu"),
            ("kinora:frame", "2"),
            ("kinora:samples", "4"),
            ("kinora:scene", hash),
            ("kinora:seed", "3"),
            ("kinora:version", version),
        ]
    );
    assert_eq!(hash.len(), 64);
}

#[test]
fn flags_change_the_picture() {
    let folder = Folder::hello();
    let render = |name: &str, flags: &str| {
        folder.run(&format!("render hello.kin --backend cpu -o {name} {flags}")).check(0, &[]);
        folder.read(name)
    };
    let plain = render("a.png", "");
    assert_eq!(plain, render("b.png", ""));
    assert_eq!(render("c.png", "--frame 4"), render("d.png", "--time 500ms").to_vec());
    for (name, flags) in [
        ("e.png", "--time 1s"),
        ("f.png", "--seed 1"),
        ("g.png", "--samples 5"),
        ("h.png", "--set render.max_bounces=0"),
        ("i.png", "--set ball.radius=20cm"),
    ] {
        assert!(render(name, flags) != plain, "{flags}");
    }
    render("j.png", "--size 32x8 --bits 16");
    let (width, height, bits, _) = png(&folder, "j.png");
    assert_eq!((width, height, bits), (32, 8, 16));
}

#[test]
fn the_camera_is_chosen_by_name() {
    let folder = Folder::new();
    folder.write("a.kin", &(HELLO.to_string() + "camera top { position: (0, 5, 0.1), look_at: (0, 0, 0) }\n"));
    folder.run("render a.kin --backend cpu").check(1, &["E0502"]);
    folder.run("render a.kin --backend cpu --camera top -o top.png").check(0, &[]);
    folder.run("render a.kin --backend cpu --camera main -o main.png").check(0, &[]);
    assert!(folder.read("top.png") != folder.read("main.png"));
    folder.run("render a.kin --backend cpu --camera tpo").check(1, &["`tpo`", "`top`"]);
}

#[test]
fn exr_files_are_the_same_bytes_always() {
    let folder = Folder::hello();
    for (name, threads) in [("a.exr", 1), ("b.exr", 2), ("c.exr", 2)] {
        folder.run(&format!("render hello.kin --backend cpu --size 70x50 --threads {threads} -o {name}")).check(0, &[]);
    }
    assert!(folder.read("a.exr") == folder.read("b.exr") && folder.read("b.exr") == folder.read("c.exr"));
    let meta = exr::meta::MetaData::read_from_file(folder.path("a.exr"), false).unwrap();
    let header = &meta.headers[0];
    let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["B", "G", "R"]);
    assert!(header.channels.list.iter().all(|channel| channel.sample_type == exr::meta::attribute::SampleType::F32));
    assert_eq!(header.compression, exr::compression::Compression::ZIP16);
    assert_eq!(header.own_attributes.frames_per_second, Some((8, 1)));
    assert!(header.own_attributes.other.keys().any(|name| *name == *"kinora:scene"));
}

#[test]
fn other_formats() {
    let folder = Folder::hello();
    for name in ["a.hdr", "a.jpg"] {
        folder.run(&format!("render hello.kin --backend cpu -o {name}")).check(0, &[]);
        let bytes = folder.read(name);
        assert!(bytes.windows(13).any(|piece| piece == b"kinora:scene="), "{name}");
        let kind = if name == "a.hdr" { image::ImageFormat::Hdr } else { image::ImageFormat::Jpeg };
        let picture = image::load_from_memory_with_format(&bytes, kind).unwrap();
        assert_eq!((picture.width(), picture.height()), (24, 16));
    }
}

#[test]
fn bad_outputs_are_refused_before_there_is_work() {
    let folder = Folder::hello();
    folder.write("plain", "");
    std::fs::create_dir(folder.path("folder.png")).unwrap();
    std::fs::copy(folder.path("hello.kin"), folder.path("scene.png")).unwrap();
    for (line, piece) in [
        ("render hello.kin -o a.tga", "pictures cannot be written as `.tga`"),
        ("render hello.kin -o a", "no ending"),
        ("render hello.kin -o a.mp4", "a whole film in one file"),
        ("render hello.kin -o missing/a.png", "there is no folder `missing`"),
        ("render hello.kin -o plain/a.png", "there is no folder `plain`"),
        ("render hello.kin -o folder.png", "it is a folder"),
        ("render scene.png -o ./scene.png", "is the scene itself"),
        ("animate hello.kin -o a.png", "no place for the frame's number"),
        ("animate hello.kin -o plain/a.##.png", "cannot make the folder `plain`"),
        ("animate hello.kin --frames 4..1", "runs backwards"),
        ("render hello.kin --frame 1 --time 2s", "cannot be used with"),
        ("render hello.kin --time 2", "times need a unit"),
        ("render hello.kin --size 0x4", "640x360"),
        ("render missing.kin", "there is no file `missing.kin`"),
    ] {
        folder.run(&format!("{line} --samples 1000000000")).check(2, &[piece]);
    }
    assert_eq!(folder.names("."), ["folder.png", "hello.kin", "plain", "scene.png"]);
}

#[test]
fn what_it_took_is_one_line_of_json() {
    let folder = Folder::hello();
    let ran = folder.run("render hello.kin --backend cpu --json").check(0, &[]);
    assert_eq!((ran.out.lines().count(), ran.err.as_str()), (1, ""));
    let took: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!((&took["samples"], &took["backend"]), (&4.into(), &"cpu".into()));
    assert!(took["rays"].as_u64() >= Some(24 * 16 * 4), "{took}");
    for name in ["load_s", "build_s", "render_s"] {
        assert!(took[name].as_f64() >= Some(0.0), "{name} of {took}");
    }
    assert_eq!(took["peak_bytes"].is_u64(), cfg!(target_os = "linux"), "{took}");
}

#[test]
fn warnings_are_told_and_the_picture_is_made() {
    let folder = Folder::new();
    folder.write("a.kin", &HELLO.replace("lang 1\n", ""));
    folder.run("render a.kin --backend cpu").check(0, &["W0710"]);
    assert!(exists(&folder.path("a.png")));
}

#[test]
fn a_frame_alone_is_the_frame_in_a_range() {
    let folder = Folder::hello();
    folder.run("animate hello.kin --backend cpu --frames 6..9 -o range/f.###.png").check(0, &[]);
    folder.run("animate hello.kin --backend cpu --frames 7 -o alone/f.%03d.png").check(0, &[]);
    assert_eq!(folder.names("range"), ["f.006.png", "f.007.png", "f.008.png"]);
    assert_eq!(folder.names("alone"), ["f.007.png"]);
    assert!(folder.read("range/f.007.png") == folder.read("alone/f.007.png"));
    assert!(folder.read("range/f.007.png") != folder.read("range/f.008.png"));
    folder.run("animate hello.kin --backend cpu --frames 7-8:5,-1 -o exr/{frame:02}.exr").check(0, &[]);
    assert_eq!(folder.names("exr"), ["-01.exr", "07.exr"]);
}

#[test]
fn all_frames_into_out() {
    let folder = Folder::hello();
    let ran = folder.run("animate hello.kin --backend cpu --json").check(0, &[]);
    assert_eq!(folder.names("out").len(), 16);
    let took: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    assert_eq!((&took["frames"], &took["skipped"]), (&16.into(), &0.into()));
}

#[test]
fn what_is_there_is_left_out() {
    let folder = Folder::hello();
    for ending in ["png", "exr", "hdr", "jpg"] {
        let took = |flags: &str| {
            let line = format!("animate hello.kin --backend cpu --resume --json -o {ending}/#.{ending} {flags}");
            let took: serde_json::Value = serde_json::from_str(&folder.run(&line).check(0, &[]).out).unwrap();
            (took["frames"].as_u64().unwrap(), took["skipped"].as_u64().unwrap())
        };
        assert_eq!(took("--frames 0..2"), (2, 0), "{ending}");
        assert_eq!(took("--frames 0..4"), (2, 2), "{ending}");
        assert_eq!(took("--frames 0..4 --samples 3"), (4, 0), "{ending}");
        std::fs::write(folder.path(&format!("{ending}/1.{ending}")), "no picture").unwrap();
        assert_eq!(took("--frames 0..4 --samples 3"), (1, 3), "{ending}");
    }
}

#[test]
fn a_frame_without_a_picture_does_not_stop_the_others() {
    let folder = Folder::new();
    folder.write("a.kin", &HELLO.replace("radius: 50cm", "radius: 50cm * abs(frame - 1)"));
    let ran = folder.run("animate a.kin --backend cpu --frames 0..3").check(1, &["frame 1 has no picture", "E0401"]);
    assert!(ran.err.contains("`radius` of `ball`"), "{}", ran.err);
    assert_eq!(folder.names("out"), ["frame.0000.png", "frame.0002.png"]);
}

/// Runs an endless film, sends `signal` once its first frame is there, and demands the exit code.
#[cfg(unix)]
fn stopped_by(signal: &str, code: i32) {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let folder = Folder::hello();
    let mut command = folder.command("animate hello.kin --backend cpu --frames 0..900000 --size 64x64");
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    while !exists(&folder.path("out/frame.0000.png")) {
        assert!(start.elapsed() < Duration::from_secs(120), "no first frame");
        std::thread::sleep(Duration::from_millis(20));
    }
    let sent = Command::new("sh").args(["-c", &format!("kill -s {signal} {}", child.id())]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(code));
    let names = folder.names("out");
    assert!(names.iter().all(|name| name.starts_with("frame.") && name.ends_with(".png")), "{names:?}");
    let last = names.last().unwrap();
    png(&folder, &format!("out/{last}"));
}

#[cfg(unix)]
#[test]
fn ctrl_c() {
    stopped_by("INT", 130);
}

#[cfg(unix)]
#[test]
fn sigterm() {
    stopped_by("TERM", 75);
}
