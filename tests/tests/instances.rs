//! Instances show what the same shapes written out would.

use kinora_lang::Overrides;
use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_renderer::Choice;

const HEAD: &str = "lang 1
render { resolution: (48, 32), filter: box, samples: 16, max_bounces: 3, tonemap: none }
camera { position: (0, 3, 8), look_at: (0, 0.8, 0), fov: 40deg }
sky { color: linear(0.5, 0.7, 1) }
quad { size: (20, 20) }
diffuse red { color: #c03020 }
diffuse blue { color: #2040c0 }
prefab tree(paint: material = red) {
    cylinder { radius: 0.1, position: (0, 0.5, 0), material: blue }
    sphere { position: (0, 1.2, 0), radius: 0.5, material: paint }
}
";

/// Light of every pixel.
fn picture(text: &str) -> Vec<f64> {
    let source = Source::new(FileId(0), "test.kin", format!("{HEAD}{text}"));
    // What a case does not use is warned about.
    let evaluated = kinora_lang::eval(&kinora_lang::parse(&source), &Memory::default(), &Overrides::default());
    let scene = evaluated.unwrap_or_else(|found| panic!("{text}: {found:?}")).scene;
    let film = kinora_tests::render(&scene, 0, Choice::Cpu);
    film.mean().iter().map(|light| f64::from(light.element_sum()) / 3.0).collect()
}

fn same(what: &str, instances: &str, written: &str) {
    let [a, b] = [instances, written].map(picture);
    let (mean, off) = (b.iter().sum::<f64>(), a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum::<f64>());
    assert!(off < 0.004 * mean, "{what}: off by {:.2} %", 100.0 * off / mean);
}

#[test]
fn instances() {
    let three = "tree { } group { position: (2, 0, 0), tree { } } group { position: (-2, 0, 1), scale: 0.5, tree { } }";
    let places = "instance { of: one } instance { of: one, position: (2, 0, 0) }
        instance { of: one, position: (-2, 0, 1), scale: 0.5 }";
    same("a prefab by `let`", &format!("let one = tree {{ }}\n{places}"), three);
    same("a group that is hidden itself", &format!("group one {{ tree {{ }}\nvisible: false }}\n{places}"), three);
    same("a group that is seen itself", &format!("group one {{ tree {{ }} }}\n{places}"), three);
    same(
        "a loop, which makes one node of all turns",
        "let one = tree { }
        for i in 0..5 { instance { of: one, position: (i - 2, 0, 0), rotation: axis_angle((0, 0, 1), 10deg * i), scale: 0.5 } }",
        "for i in 0..5 { group { position: (i - 2, 0, 0), rotation: axis_angle((0, 0, 1), 10deg * i), scale: 0.5, tree { } } }",
    );
    same(
        "two of them in turn",
        "let one = tree { }
        let other = tree { paint: blue }
        for i in 0..4 { instance { of: if mod(i, 2) == 0 { one } else { other }, position: (i - 2, 0, 0) } }",
        "for i in 0..4 { group { position: (i - 2, 0, 0), tree { paint: if mod(i, 2) == 0 { red } else { blue } } } }",
    );
    same(
        "as it is placed in its parent",
        "sphere ball { radius: 0.4, position: (0, 1, 0), material: red, visible: false }
        instance { of: ball, position: (1, 0, 0) }",
        "sphere { radius: 0.4, position: (1, 1, 0), material: red }",
    );
    same(
        "inside one another, mirrored",
        "group pair { visible: false, tree { }\ninstance { of: tree { }, position: (1, 0, 0), scale: 0.6 } }
        for i in 0..2 { instance { of: pair, position: (3 * i - 2, 0, 0), scale: (1, 1, -1) } }",
        "for i in 0..2 { group { position: (3 * i - 2, 0, 0), scale: (1, 1, -1)
            tree { }
            group { position: (1, 0, 0), scale: 0.6, tree { } } } }",
    );
    same(
        "of another material",
        "let one = sphere { radius: 0.5, material: red }
        instance { of: one, material: blue, position: (0, 1, 0) }",
        "sphere { radius: 0.5, material: blue, position: (0, 1, 0) }",
    );
    same(
        "lamps and planes",
        "group one { visible: false
            sphere { radius: 0.2, material: emitter { power: 100W } }
            point_light { position: (0, 1, 0), power: 50W }
            plane { normal: (0, 0, 1), position: (0, 0, -3) } }
        for i in 0..2 { instance { of: one, position: (2 * i - 1, 1, 0) } }",
        "for i in 0..2 { group { position: (2 * i - 1, 1, 0)
            sphere { radius: 0.2, material: emitter { power: 100W } }
            point_light { position: (0, 1, 0), power: 50W }
            plane { normal: (0, 0, 1), position: (0, 0, -3) } } }",
    );
}
