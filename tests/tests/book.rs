//! The pages that show a picture of every property. A page's first example is its stage; the others, each below its picture,
//! are added to it. `KINORA_BLESS=1` renders the pictures anew.

use std::path::Path;

use kinora_lang::files::Memory;
use kinora_renderer::{Choice, Options, Renderer, develop, open};
use kinora_tests::picture::{mean_difference, read_png, write_png};
use kinora_tests::world_with;

const PAGES: &[&str] = &["cameras", "lights", "materials", "procedural", "shapes"];

/// As of the golden pictures.
const TOLERANCE: f64 = 0.02;

#[test]
fn pictures_of_the_pages() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let bless = std::env::var_os("KINORA_BLESS").is_some_and(|v| v == "1");
    let mut renderer = Renderer::new(open(Choice::Cpu, Options::default()).expect("the CPU opens"));
    let texture = |name| std::fs::read(folder.join("pictures").join(name)).expect("the texture is there");
    let textures = ["bricks.png", "bricks_normal.png"].map(|name| (name, texture(name)));
    let sky = std::fs::read(folder.join("../examples/assets/esplanade.hdr")).expect("the sky is there");
    let textures = textures.iter().map(|(name, bytes)| (*name, bytes)).chain([("sky.hdr", &sky)]);
    let files = Memory::new(textures.map(|(name, bytes)| (name, bytes.as_slice())));
    for page in PAGES {
        let text = std::fs::read_to_string(folder.join(format!("{page}.md"))).expect("the page is there");
        let text = text.replace("\r\n", "\n");
        let mut examples = text.split("```kin\n").skip(1).filter_map(|rest| rest.split_once("```"));
        let (stage, mut above) = examples.next().expect("a page has a stage");
        for (example, below) in examples {
            let picture = above.rsplit("](pictures/").next().and_then(|rest| rest.split_once(')'));
            let (name, _) = picture.unwrap_or_else(|| panic!("{page}: no picture above\n{example}"));
            above = below;
            let world = world_with(&format!("{stage}{example}"), &files);
            let got = develop(&renderer.render(&world, &()).expect("the example renders"), &world.look).codes8();
            let path = folder.join("pictures").join(name);
            if bless {
                write_png(&path, world.render.resolution, &got);
            }
            let difference = mean_difference(&read_png(&path), &got);
            assert!(difference <= TOLERANCE, "{page}: {name} differs by {difference}; KINORA_BLESS=1 renders it anew");
        }
    }
}
