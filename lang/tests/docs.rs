//! Everything that the pages show in the scene language is right, or wrong as they say.
//!
//! A block that begins with `lang 1` is a whole scene. Without it a block is added to its page's first scene, the stage, which
//! need not be whole by itself.
//! Words behind `kin` say otherwise:
//!
//! | | |
//! |---|---|
//! | `kin` | checks without findings |
//! | `kin fragment` | as part of a scene with a camera, a sky and a sphere, where names may be unused |
//! | `kin bad E0304 ..` | has these findings and no others; a fragment, unless it begins with `lang 1` |
//! | `kin file lib/x.kin` | a file that the page's later scenes may import |

use std::path::{Path, PathBuf};

use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Overrides, eval, parse};

/// The scene that a fragment is part of.
fn around(fragment: &str) -> String {
    let camera = if fragment.contains("camera") { "" } else { "camera { position: (0, 0, 4) }\n" };
    let sky = if fragment.contains("sky {") { "" } else { "sky { color: #ffffff }\n" };
    format!("lang 1\n{camera}{sky}sphere {{ }}\n{fragment}")
}

/// What the pages' scenes read, by the names that they use.
fn files() -> Vec<(String, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"));
    let robot = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0,2,4,5]}],"scene":0,"nodes":[
        {"name":"Body","children":[1]},{"name":"Visor"},{"name":"Arm","children":[3]},{"name":"Hand"},
        {"name":"front","camera":0},{"name":"Head"}],
        "accessors":[{"componentType":5126,"count":1,"type":"SCALAR","min":[0],"max":[0]},
            {"componentType":5126,"count":1,"type":"VEC3"}],
        "animations":[{"name":"Wave","channels":[{"sampler":0,"target":{"node":2,"path":"translation"}}],
            "samplers":[{"input":0,"output":1}]}],
        "cameras":[{"name":"front","type":"perspective","perspective":{"yfov":0.7,"znear":0.1}}]}"#;
    vec![
        ("bricks.png".into(), read("docs/pictures/bricks.png")),
        ("bricks_normal.png".into(), read("docs/pictures/bricks_normal.png")),
        ("sky.hdr".into(), read("examples/assets/esplanade.hdr")),
        ("skull.ply".into(), read("examples/assets/skull.ply")),
        ("assets/robot.gltf".into(), robot.to_vec()),
    ]
}

/// A fenced block: the words of its first line, and what is in it.
struct Block {
    line: usize,
    info: String,
    text: String,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (i, line) in page.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (None, Some(info)) => open = Some(Block { line: i + 1, info: info.trim().into(), text: String::new() }),
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(block), None) => block.text += &format!("{line}\n"),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

/// The codes found in a scene, each once.
fn codes(text: &str, files: &[(String, Vec<u8>)]) -> Vec<&'static str> {
    let memory = Memory::new(files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())));
    let tree = parse(&Source::new(FileId(0), "page.kin", text));
    let found = match eval(&tree, &memory, &Overrides::default()) {
        Ok(evaluated) => evaluated.warnings,
        Err(found) => found,
    };
    let mut codes: Vec<&str> = found.iter().map(|found| found.code).collect();
    codes.dedup();
    codes
}

fn check(page: &Path) -> (usize, Vec<String>) {
    let text = std::fs::read_to_string(page).unwrap().replace("\r\n", "\n");
    let mut files = files();
    let blocks = blocks(&text);
    let added = |block: &&Block| block.info == "kin" && !block.text.starts_with("lang ");
    let has_stage = blocks.iter().find(added).is_some();
    let mut stage: Option<String> = None;
    let (mut count, mut wrong) = (0, Vec::new());
    for block in blocks {
        let words: Vec<&str> = block.info.split_whitespace().collect();
        let Some((&"kin", words)) = words.split_first() else { continue };
        count += 1;
        let whole = block.text.starts_with("lang ");
        let fragment = || if whole { block.text.clone() } else { around(&block.text) };
        let without_unused = |codes: Vec<&'static str>| codes.into_iter().filter(|code| *code != "W0201").collect();
        let (found, expected): (Vec<&str>, &[&str]) = match words {
            [] if whole && has_stage && stage.is_none() => {
                stage = Some(block.text);
                continue;
            }
            [] if whole => (codes(&block.text, &files), &[]),
            [] => {
                let stage = stage.as_deref().unwrap_or_else(|| panic!("{}:{}: no stage", page.display(), block.line));
                (codes(&format!("{stage}{}", block.text), &files), &[])
            }
            ["fragment"] => (without_unused(codes(&fragment(), &files)), &[]),
            ["bad", expected @ ..] if expected.contains(&"W0201") => (codes(&fragment(), &files), expected),
            ["bad", expected @ ..] => (without_unused(codes(&fragment(), &files)), expected),
            ["file", name] => {
                files.push((name.to_string(), block.text.clone().into_bytes()));
                (
                    codes(&block.text, &files)
                        .into_iter()
                        .filter(|code| *code != "E0501" && *code != "E0503")
                        .collect(),
                    &[],
                )
            }
            _ => panic!("{}:{}: `{}` is no kind of block", page.display(), block.line, block.info),
        };
        if found != expected {
            wrong.push(format!("{}:{}: found {found:?}, not {expected:?}\n{}", page.display(), block.line, block.text));
        }
    }
    (count, wrong)
}

fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true if path.ends_with("node_modules") => {}
            true => pages(&path, found),
            false if path.extension().is_some_and(|extension| extension == "md") => found.push(path),
            false => {}
        }
    }
}

#[test]
fn blocks_of_all_pages() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut all = vec![root.join("README.md")];
    pages(&root.join("docs"), &mut all);
    all.sort();
    let (mut count, mut wrong) = (0, Vec::new());
    for page in all {
        let (here, bad) = check(&page);
        count += here;
        wrong.extend(bad);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count > 80, "only {count} blocks were found");
}
