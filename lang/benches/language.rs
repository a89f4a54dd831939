//! Speed of the language: `cargo bench -p kinora-lang`. Each row is the best of several passes.

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Overrides, eval_project, parse};

const HEAD: &str = "lang 1\ncamera main { position: (0, 2, 60), look_at: (0, 0, 0) }\nsky { color: #bcd7ff }\n";

/// Numbers that are the same in every run, 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Spheres, each with a place, a size and a material of its own.
fn spheres(count: usize) -> String {
    let mut random = Random(7);
    let mut text = HEAD.to_string();
    for _ in 0..count {
        let mut r = || random.next();
        let (x, y, z, radius) = (60.0 * r() - 30.0, 60.0 * r() - 30.0, 60.0 * r() - 30.0, 0.02 + 0.3 * r());
        let _ = writeln!(
            text,
            "sphere {{\n    position: ({x:.5}, {y:.5}, {z:.5})\n    radius: {radius:.5}\n    material: diffuse {{ color: srgb({:.5}, {:.5}, {:.5}) }}\n}}",
            r(),
            r(),
            r(),
        );
    }
    text
}

/// The time of the quickest pass in seconds.
fn best(passes: usize, mut pass: impl FnMut()) -> f64 {
    let mut time = || {
        let start = Instant::now();
        pass();
        start.elapsed().as_secs_f64()
    };
    (0..passes).map(|_| time()).fold(f64::INFINITY, f64::min)
}

fn source(name: &str, text: &str) -> Source {
    Source::new(FileId(0), name, text)
}

/// Parses and evaluates a scene.
fn check(text: &str, files: &Memory) {
    let tree = parse(&source("scene.kin", text));
    let (found, _) = eval_project(&tree, files, &Overrides::default());
    assert!(black_box(found).is_ok());
}

fn main() {
    let big = spheres(100_000);
    let megabytes = big.len() as f64 / 1e6;
    let seconds = best(5, || drop(black_box(parse(&source("big.kin", &big)))));
    println!("parse 100 000 spheres, {megabytes:.1} MB: {seconds:.3} s, {:.0} MB/s", megabytes / seconds);
    let seconds = best(5, || check(&big, &Memory::default()));
    println!("parse and evaluate them: {seconds:.3} s");

    let turns = format!(
        "{HEAD}group tree {{ sphere {{ }} }}\nfor i in 0..100000 {{ instance {{ of: tree, position: (rand(i, seed: 1), \
         0, rand(i, seed: 2)), rotation: rotate_y(360deg * rand(i, seed: 3)), scale: 0.5 + rand(i, seed: 4) }} }}\n"
    );
    let seconds = best(5, || check(&turns, &Memory::default()));
    println!("a loop of 100 000 instances: {seconds:.3} s, {:.2} µs a turn", seconds * 10.0);

    // Ten files of 10 KB, one line of the first edited each time.
    let part = format!("lang 1\nprefab part() {{\n{}}}\n", spheres(80).replacen(HEAD, "", 1));
    let names: Vec<String> = (1..10).map(|i| format!("part_{i}.kin")).collect();
    let files = Memory::new(names.iter().map(|name| (name.as_str(), part.as_bytes())));
    let mut scene = String::from("lang 1\n");
    (1..10).for_each(|i| _ = writeln!(scene, "import \"part_{i}.kin\" as part_{i}"));
    scene += &HEAD["lang 1\n".len()..];
    (1..10).for_each(|i| _ = writeln!(scene, "part_{i}.part {{ }}"));
    let mut edit = 0;
    let seconds = best(50, || {
        edit += 1;
        check(&format!("{scene}sphere {{ radius: {edit}cm }}\n"), &files);
    });
    println!("ten files of 10 KB again after an edit: {:.2} ms", seconds * 1e3);
}
