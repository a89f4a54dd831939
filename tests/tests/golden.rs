//! Every example against its golden picture, made by the CPU backend. `KINORA_BLESS=1` writes new ones; a failing run
//! leaves a page that shows both pictures and where they differ.

use std::path::{Path, PathBuf};

use kinora_renderer::{Choice, develop};
use kinora_tests::picture::{mean_difference, read_png, write_png};
use kinora_tests::{gpu, render, scene};

/// Largest mean difference of 8-bit values that a backend may show. The CPU gives the same bits everywhere but for the
/// f64 functions of the system, which may move a rounding; a GPU contracts and reorders what the CPU does not.
const CPU_TOLERANCE: f64 = 0.02;
const GPU_TOLERANCE: f64 = 1.0;

/// Example, frame.
const EXAMPLES: &[(&str, i64)] = &[
    ("hello", 0),
    ("cornell", 0),
    ("bounce", 28),
    ("orbit", 0),
    ("orbit", 30),
    ("scan", 0),
    ("materials", 0),
    ("procedural", 0),
    ("still_life", 0),
    ("mis", 0),
    ("fireflies", 0),
    ("bvh", 0),
    ("night", 0),
    ("sky", 48),
    ("lens", 0),
    ("forest", 0),
    ("helmet", 0),
    ("robot", 30),
    ("title", 170),
    ("dominoes", 100),
    ("pendulums", 70),
];

const SIZE: [u32; 2] = [96, 72];
const SAMPLES: u32 = 64;

fn picture(name: &str, frame: i64, choice: Choice) -> Vec<u8> {
    let mut scene = scene(&format!("examples/{name}.kin"), &[]);
    scene.render.resolution = SIZE;
    scene.render.samples = SAMPLES;
    let film = render(&scene, frame, choice);
    let world = kinora_animator::sample(&scene, scene.clock.shutter_of(frame)).expect("the frame has a world");
    develop(&film, &world.look).codes8()
}

fn golden_path(name: &str, frame: i64) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("golden/{name}.{frame:04}.png"))
}

// A page with both pictures and their difference, ten times.
fn report(backend: &str, failures: &[(String, Vec<u8>, Vec<u8>, f64)]) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("golden-{backend}"));
    let mut page =
        String::from("<!doctype html><meta charset=utf-8><style>img{width:384px;image-rendering:pixelated}</style>");
    for (name, golden, got, difference) in failures {
        let shown: Vec<u8> = golden.iter().zip(got).map(|(a, b)| a.abs_diff(*b).saturating_mul(10)).collect();
        page += &format!("<h2>{name}: mean difference {difference:.3}</h2>");
        for (kind, rgb) in [("golden", golden), ("got", got), ("difference", &shown)] {
            let file = format!("{name}.{kind}.png");
            write_png(&folder.join(&file), SIZE, rgb);
            page += &format!("<img src='{file}' title='{kind}'> ");
        }
    }
    let path = folder.join("index.html");
    std::fs::write(&path, page).expect("the report can be written");
    path
}

fn check(backend: &str, choice: Choice, tolerance: f64) {
    let mut failures = Vec::new();
    for &(name, frame) in EXAMPLES {
        let got = picture(name, frame, choice);
        let path = golden_path(name, frame);
        if choice == Choice::Cpu && std::env::var_os("KINORA_BLESS").is_some_and(|v| v == "1") {
            write_png(&path, SIZE, &got);
        }
        let golden = read_png(&path);
        let difference = mean_difference(&golden, &got);
        println!("{backend}: {name}, frame {frame}: mean difference {difference:.4}");
        if difference > tolerance {
            failures.push((format!("{name}.{frame:04}"), golden, got, difference));
        }
    }
    assert!(failures.is_empty(), "{} pictures differ: see {}", failures.len(), report(backend, &failures).display());
}

#[test]
fn cpu() {
    check("cpu", Choice::Cpu, CPU_TOLERANCE);
}

#[test]
fn on_a_gpu() {
    if gpu().is_some() {
        check("gpu", Choice::Gpu, GPU_TOLERANCE);
    }
}

#[test]
fn every_example_is_checked() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    for entry in std::fs::read_dir(folder).expect("the examples are there") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|e| e == "kin") {
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            assert!(EXAMPLES.iter().any(|(known, _)| *known == name), "{name}.kin has no golden picture");
        }
    }
}
