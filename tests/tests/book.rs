//! The pages that show pictures of their scenes. A page's first scene is its stage, unless it has a picture of its own. The
//! other examples stand below their pictures: whole scenes, or what is added to the stage. `name.0018.png` shows frame 18.
//! `KINORA_BLESS=1` renders the pictures anew.

use std::path::Path;

use kinora_lang::files::Memory;
use kinora_renderer::{Choice, Options, Renderer, develop, open};
use kinora_tests::picture::{mean_difference, read_png, write_png};
use kinora_tests::world_at;

const PAGES: &[&str] = &["cameras", "coming_from", "lights", "materials", "procedural", "shapes", "tutorial"];

/// As of the golden pictures.
const TOLERANCE: f64 = 0.02;

/// Widest picture.
const WIDTH: u32 = 320;

/// What scenes read, by name.
type Files = Vec<(String, Vec<u8>)>;

/// A picture, the scene that it shows, and the files that the page has given up to there.
struct Example {
    picture: String,
    scene: String,
    files: Files,
}

fn examples(page: &str, text: &str, files: &Files) -> Vec<Example> {
    let mut examples = Vec::new();
    let mut files = files.clone();
    let mut stage = "";
    let mut blocks = text.split("```kin");
    let mut above = blocks.next().unwrap_or_default();
    for block in blocks {
        let (info, rest) = block.split_once('\n').expect("a block has a first line");
        let (scene, below) = rest.split_once("```").expect("a block has an end");
        let picture = above.rsplit_once("![](pictures/").and_then(|(_, rest)| rest.split_once(".png)"));
        above = below;
        match (info.trim(), picture) {
            ("", Some((picture, _))) => {
                let stage = if scene.starts_with("lang ") { "" } else { stage };
                examples.push(Example {
                    picture: picture.into(),
                    scene: format!("{stage}{scene}"),
                    files: files.clone(),
                });
            }
            ("", None) => {
                assert!(stage.is_empty(), "{page}: no picture above\n{scene}");
                stage = scene;
            }
            (info, _) => {
                files.extend(info.strip_prefix("file ").map(|name| (name.to_string(), scene.as_bytes().to_vec())));
            }
        }
    }
    examples
}

#[test]
fn pictures_of_the_pages() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let bless = std::env::var_os("KINORA_BLESS").is_some_and(|v| v == "1");
    let mut renderer = Renderer::new(open(Choice::Cpu, Options::default()).expect("the CPU opens"));
    let files: Files = [
        ("bricks.png", "pictures/bricks.png"),
        ("bricks_normal.png", "pictures/bricks_normal.png"),
        ("sky.hdr", "../examples/assets/esplanade.hdr"),
    ]
    .map(|(name, path)| (name.into(), std::fs::read(folder.join(path)).expect("the file is there")))
    .into();
    for page in PAGES {
        let text = std::fs::read_to_string(folder.join(format!("{page}.md"))).expect("the page is there");
        for Example { picture, scene, files } in examples(page, &text.replace("\r\n", "\n"), &files) {
            let memory = Memory::new(files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())));
            let frame = picture.rsplit_once('.').and_then(|(_, frame)| frame.parse().ok()).unwrap_or(0);
            let mut world = world_at(&scene, &memory, frame);
            let [width, height] = world.render.resolution;
            if width > WIDTH {
                world.render.resolution = [WIDTH, height * WIDTH / width];
            }
            let got = develop(&renderer.render(&world, &()).expect("the example renders"), &world.look).codes8();
            let path = folder.join(format!("pictures/{picture}.png"));
            if bless {
                write_png(&path, world.render.resolution, &got);
            }
            let difference = mean_difference(&read_png(&path), &got);
            let message = format!("{page}: {picture} differs by {difference}; KINORA_BLESS=1 renders it anew");
            assert!(difference <= TOLERANCE, "{message}");
        }
    }
}
