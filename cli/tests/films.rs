//! What is written into pictures: bits, layers, windows, alpha and views.
#![cfg(feature = "render")]

mod common;

use std::collections::BTreeMap;
use std::io::BufReader;

use common::{Folder, HELLO, exists};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

/// A PNG: width, height, channels, and the codes of all pixels.
fn png(folder: &Folder, name: &str) -> (usize, usize, usize, Vec<u16>) {
    let file = BufReader::new(std::fs::File::open(folder.path(name)).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let codes = match info.bit_depth {
        png::BitDepth::Sixteen => bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect(),
        _ => bytes.into_iter().map(u16::from).collect(),
    };
    (info.width as usize, info.height as usize, info.color_type.samples(), codes)
}

/// An EXR: its data window as left, top, width, height, its picture's size, and its channels by name as f64.
struct Exr {
    window: [i64; 4],
    picture: [usize; 2],
    channels: BTreeMap<String, Vec<f64>>,
    whole: Vec<String>,
}

fn exr(folder: &Folder, name: &str) -> Exr {
    let image = read_first_flat_layer_from_file(folder.path(name)).unwrap();
    let layer = image.layer_data;
    let at = layer.attributes.layer_position;
    let (mut channels, mut whole) = (BTreeMap::new(), Vec::new());
    for channel in &layer.channel_data.list {
        let values = match &channel.sample_data {
            FlatSamples::F32(values) => values.iter().map(|v| f64::from(*v)).collect(),
            FlatSamples::U32(values) => {
                whole.push(channel.name.to_string());
                values.iter().map(|v| f64::from(*v)).collect()
            }
            FlatSamples::F16(_) => panic!("{name}: half floats"),
        };
        channels.insert(channel.name.to_string(), values);
    }
    let size = image.attributes.display_window.size;
    let window = [i64::from(at.x()), i64::from(at.y()), layer.size.x() as i64, layer.size.y() as i64];
    Exr { window, picture: [size.x(), size.y()], channels, whole }
}

fn render(folder: &Folder, flags: &str) {
    folder.run(&format!("render hello.kin --backend cpu {flags}")).check(0, &[]);
}

// `part` of a picture `width` values wide, a pixel having `channels` of them.
fn cut<T: Copy>(values: &[T], width: usize, channels: usize, [left, top, w, h]: [usize; 4]) -> Vec<T> {
    let row = |y: usize| (y * width + left) * channels;
    (top..top + h).flat_map(|y| values[row(y)..row(y) + w * channels].to_vec()).collect()
}

#[test]
fn a_crop_has_the_pixels_of_the_whole() {
    let folder = Folder::hello();
    let part = [7, 3, 11, 9];
    for bits in [8, 16] {
        render(&folder, &format!("--bits {bits} -o whole.png"));
        render(&folder, &format!("--bits {bits} --crop 7,3,11,9 -o part.png"));
        let (width, _, channels, whole) = png(&folder, "whole.png");
        let (w, h, _, got) = png(&folder, "part.png");
        assert_eq!((w, h, channels), (11, 9, 3));
        assert_eq!(got, cut(&whole, width, 3, part), "{bits} bits");
    }
    let layers = "--aov albedo,normal,depth,id,position";
    render(&folder, &format!("{layers} -o whole.exr"));
    render(&folder, &format!("{layers} --crop 7,3,11,9 -o part.exr"));
    let (whole, got) = (exr(&folder, "whole.exr"), exr(&folder, "part.exr"));
    assert_eq!((whole.window, whole.picture), ([0, 0, 24, 16], [24, 16]));
    assert_eq!((got.window, got.picture), ([7, 3, 11, 9], [24, 16]));
    assert!(whole.channels.keys().eq(got.channels.keys()));
    for (name, values) in &whole.channels {
        assert_eq!(got.channels[name], cut(values, 24, 1, part), "{name}");
    }
    folder.run("animate hello.kin --backend cpu --frames 0..2 --crop 7,3,11,9 -o out/#.png").check(0, &[]);
    assert!(folder.read("out/0.png") != folder.read("out/1.png"));
    let again = "animate hello.kin --backend cpu --frames 0..2 --crop 7,3,11,8 -o out/#.png --resume --json";
    assert!(folder.run(again).check(0, &[]).out.contains(r#""skipped":0"#), "another crop is another picture");
}

#[test]
fn layers() {
    let folder = Folder::hello();
    let flags = "--aov position,samples,albedo,id,depth,normal --set render.adaptive=5%";
    render(&folder, &format!("{flags} --threads 1 -o a.exr"));
    render(&folder, &format!("{flags} --threads 2 -o b.exr"));
    assert!(folder.read("a.exr") == folder.read("b.exr"), "the same picture is the same bytes");
    let meta = exr::meta::MetaData::read_from_file(folder.path("a.exr"), false).unwrap();
    let header = &meta.headers[0];
    let names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    let expected = [
        "B",
        "G",
        "R",
        "albedo.B",
        "albedo.G",
        "albedo.R",
        "depth.Z",
        "id",
        "normal.X",
        "normal.Y",
        "normal.Z",
        "position.X",
        "position.Y",
        "position.Z",
        "samples",
    ];
    assert_eq!(names, expected);
    let own = &header.own_attributes;
    assert_eq!(own.comments.as_ref().map(ToString::to_string).as_deref(), Some("hello"));
    assert!(own.world_to_camera.is_some() && own.world_to_normalized_device.is_some() && own.exposure == Some(0.0));
    let picture = exr(&folder, "a.exr");
    assert_eq!(picture.whole, ["id"]);
    // The middle shows the ball, the lower corner the floor, the upper one the sky.
    let at = |name: &str, x: usize, y: usize| picture.channels[name][y * 24 + x];
    // The ball is of radius ½ about (0, ½, 0), the eye at (0, 1, 4).
    let distance = [("X", 0.0), ("Y", 0.5), ("Z", 0.0)].map(|(axis, c)| at(&format!("position.{axis}"), 12, 8) - c);
    let radius = distance.iter().map(|d| d * d).sum::<f64>().sqrt();
    assert!((radius - 0.5).abs() < 1e-4, "{radius}");
    assert!(at("depth.Z", 12, 8) > 3.4 && at("depth.Z", 12, 8) < 3.7, "{}", at("depth.Z", 12, 8));
    assert!(at("normal.Z", 12, 8) > 0.9);
    assert!((at("albedo.R", 12, 8) - 0.694).abs() < 0.01, "{}", at("albedo.R", 12, 8));
    assert_eq!([at("id", 12, 8), at("id", 0, 15), at("id", 0, 0)], [2.0, 1.0, 0.0]);
    assert!((at("normal.Y", 0, 15) - 1.0).abs() < 1e-6 && at("position.Y", 0, 15).abs() < 1e-5);
    assert_eq!([at("depth.Z", 0, 0), at("albedo.R", 0, 0), at("normal.X", 0, 0)], [1e10_f32.into(), 0.0, 0.0]);
}

#[test]
fn light_in_parts() {
    let folder = Folder::hello();
    render(&folder, "-o plain.exr");
    let flags = "--aov specular,variance,diffuse,emission";
    render(&folder, &format!("{flags} --threads 1 -o a.exr"));
    render(&folder, &format!("{flags} --threads 2 -o b.exr"));
    assert!(folder.read("a.exr") == folder.read("b.exr"), "the same picture is the same bytes");
    let (plain, picture) = (exr(&folder, "plain.exr").channels, exr(&folder, "a.exr").channels);
    let names: Vec<&str> = picture.keys().map(String::as_str).collect();
    let expected = [
        "B",
        "G",
        "R",
        "diffuse.B",
        "diffuse.G",
        "diffuse.R",
        "emission.B",
        "emission.G",
        "emission.R",
        "specular.B",
        "specular.G",
        "specular.R",
        "variance.B",
        "variance.G",
        "variance.R",
    ];
    assert_eq!(names, expected);
    for axis in ["R", "G", "B"] {
        assert_eq!(picture[axis], plain[axis], "layers change the picture");
        let part = |layer: &str| &picture[&format!("{layer}.{axis}")];
        let (diffuse, specular, emission) = (part("diffuse"), part("specular"), part("emission"));
        for (i, all) in picture[axis].iter().enumerate() {
            let sum = diffuse[i] + specular[i] + emission[i];
            assert!((sum - all).abs() <= 1e-6 * all, "{axis} of pixel {i} is {all}, its parts are {sum}");
        }
        // The sky shines, the ball and the floor scatter.
        assert!(emission[0] > 0.0 && diffuse[0] + specular[0] == 0.0);
        assert!(emission[8 * 24 + 12] == 0.0 && part("variance")[8 * 24 + 12] > 0.0);
    }
}

const MOVES: &str = "lang 1
render { resolution: (24, 16), samples: 1, max_bounces: 0, fps: 10, duration: 1s }
camera { projection: orthographic, height: 4m, position: (time / 1s, 0, 5) }
sphere { position: (0, -2 * (time / 1s), 0), radius: 1 }";

#[test]
fn motion() {
    let folder = Folder::new();
    folder.write("hello.kin", MOVES);
    let moves = |file: &str| {
        let picture = exr(&folder, file).channels;
        assert!(picture.keys().eq(["B", "G", "R", "motion.X", "motion.Y"]));
        let at = |i: usize| [picture["motion.X"][i], picture["motion.Y"][i]];
        (at(0), at(8 * 24 + 12))
    };
    // A tenth of a second is 0.1 m to the right for the camera, hence 0.4 pixels to the left for the ball, which falls 0.2 m.
    let check = |file: &str| {
        let (sky, [x, y]) = moves(file);
        assert_eq!(sky, [0.0, 0.0]);
        assert!((x + 0.4).abs() < 1e-4 && (y + 0.8).abs() < 1e-4, "{file}: {x}, {y}");
    };
    render(&folder, "--aov motion -o a.exr");
    check("a.exr");
    let animate = "animate hello.kin --backend cpu --aov motion --frames 0..2 -o out/#.exr --resume --json";
    folder.run(animate).check(0, &[]);
    check("out/1.exr");
    assert!(folder.run(animate).check(0, &[]).out.contains(r#""skipped":2"#));
    // Where the next frame is another, so is this one's motion.
    folder.write("hello.kin", &MOVES.replace("fps: 10", "fps: 20"));
    assert!(folder.run(animate).check(0, &[]).out.contains(r#""skipped":0"#));
    // Only who asks for motion needs a next frame.
    folder.write("hello.kin", &MOVES.replace("radius: 1", "radius: 0.05 - time / 1s"));
    render(&folder, "--aov id -o a.exr");
    folder.run("render hello.kin --backend cpu --aov motion -o a.exr").check(1, &["radius"]);
}

#[test]
fn transparency() {
    let folder = Folder::new();
    folder.write("hello.kin", &HELLO.replace("plane floor", "// plane floor"));
    render(&folder, "-o opaque.png");
    assert_eq!(png(&folder, "opaque.png").2, 3);
    for (bits, most) in [(8, 255), (16, 65535)] {
        render(&folder, &format!("--set render.background=transparent --samples 64 --bits {bits} -o a.png"));
        let (_, _, channels, codes) = png(&folder, "a.png");
        assert_eq!(channels, 4);
        let alpha: Vec<u16> = codes.chunks_exact(4).map(|c| c[3]).collect();
        assert_eq!((alpha[0], alpha[8 * 24 + 12]), (0, most));
        assert!(alpha.iter().any(|a| *a > 0 && *a < most), "no edge is between");
        assert_eq!(codes[..4], [0; 4]);
    }
    render(&folder, "--set render.background=transparent --samples 64 -o a.exr");
    let picture = exr(&folder, "a.exr");
    assert!(picture.channels.keys().eq(["A", "B", "G", "R"]));
    let (alpha, red) = (&picture.channels["A"], &picture.channels["R"]);
    assert_eq!((alpha[0], red[0], alpha[8 * 24 + 12]), (0.0, 0.0, 1.0));
    // Red light over alpha is that of the ball everywhere: linear light is multiplied by alpha.
    let full = red.iter().zip(alpha).filter(|(_, a)| **a == 1.0).map(|(r, _)| *r).fold(f64::INFINITY, f64::min);
    for (r, a) in red.iter().zip(alpha).filter(|(_, a)| **a > 0.2 && **a < 1.0) {
        assert!(*r < a * 1.2 && r / a > 0.5 * full, "{r} at alpha {a}, {full} inside");
    }
    for name in ["a.jpg", "a.hdr"] {
        let line = format!("render hello.kin --set render.background=transparent -o {name}");
        folder.run(&line).check(2, &["cannot be transparent", ".png"]);
        assert!(!exists(&folder.path(name)));
    }
}

#[test]
fn views() {
    let folder = Folder::hello();
    let mut pictures = Vec::new();
    for view in ["beauty", "albedo", "normal", "depth", "id", "cost", "bvh"] {
        render(&folder, &format!("--set render.view={view} -o {view}.png"));
        let (width, height, channels, codes) = png(&folder, &format!("{view}.png"));
        assert_eq!((width, height, channels), (24, 16, 3));
        assert!(codes.iter().any(|code| *code != codes[0]), "{view} shows nothing");
        assert!(pictures.iter().all(|other| *other != codes), "{view} shows what another view shows");
        pictures.push(codes);
        render(&folder, &format!("--set render.view={view} --aov id -o {view}.exr"));
        assert!(exr(&folder, &format!("{view}.exr")).channels.keys().eq(["B", "G", "R", "id"]), "{view}");
    }
    // In an EXR the picture of a layer is that layer.
    render(&folder, "--aov albedo,normal,depth,id -o layers.exr");
    let layers = exr(&folder, "layers.exr").channels;
    for (view, channel, layer) in [
        ("albedo", "R", "albedo.R"),
        ("normal", "R", "normal.X"),
        ("normal", "B", "normal.Z"),
        ("depth", "G", "depth.Z"),
        ("id", "B", "id"),
    ] {
        assert_eq!(exr(&folder, &format!("{view}.exr")).channels[channel], layers[layer], "{view}");
    }
    let cost = &exr(&folder, "cost.exr").channels["R"];
    assert!(cost[0] == 1.0 && cost[8 * 24 + 12] > 1.0, "the sky takes one ray, the ball {}", cost[8 * 24 + 12]);
    folder.run("render hello.kin --set render.view=normal -o a.hdr").check(2, &["no negative numbers"]);
}

#[test]
fn what_cannot_be_written_is_refused_before_there_is_work() {
    let folder = Folder::hello();
    for (line, piece) in [
        ("render hello.kin -o a.png --aov id", "adds layers to an .exr"),
        ("render hello.kin -o a.png --aov diffuse", "adds layers to an .exr"),
        ("render hello.kin -o a.exr --aov colour", "`colour` is no layer: there are albedo, depth, diffuse"),
        ("render hello.kin -o a.exr --aov depth,moton", "`moton` is no layer; did you mean `motion`?"),
        ("render hello.kin --crop 20,0,5,1", "the crop 20,0,5,1 is not a part of the picture, which is 24 × 16"),
        ("render hello.kin --crop 0,0,0,4", "100,50,320,180"),
        ("render hello.kin --crop -1,0,4,4", "100,50,320,180"),
        ("render hello.kin --crop 1,2,3", "100,50,320,180"),
        ("animate hello.kin --crop 0,16,4,4", "is not a part of the picture"),
        ("animate hello.kin -o out/#.jpg --aov id", "adds layers to an .exr"),
    ] {
        folder.run(&format!("{line} --samples 1000000000")).check(2, &[piece]);
    }
    folder.run("render hello.kin -o a.exr --aov variance --samples 1").check(2, &["needs 2 or more"]);
}
