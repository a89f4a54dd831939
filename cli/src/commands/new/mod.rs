//! `kinora new`: a project to begin with.

use std::fs;
use std::path::{Path, PathBuf};

use crate::exit::{self, Outcome};
use crate::terminal;
use crate::write;

/// Begin a project: a scene, a test of its picture, and a workflow that checks both.
///
/// Example: kinora new film
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The folder, which is new or empty
    folder: PathBuf,
}

const FILES: [(&str, &str); 5] = [
    ("kinora.toml", include_str!("kinora.toml")),
    ("scene.kin", include_str!("scene.kin")),
    ("README.md", include_str!("README.md")),
    (".gitignore", include_str!("gitignore")),
    (".github/workflows/scenes.yml", include_str!("scenes.yml")),
];

/// What stands in the files for this program.
const WORDS: [(&str, &str); 2] =
    [("@VERSION@", env!("CARGO_PKG_VERSION")), ("@REPOSITORY@", env!("CARGO_PKG_REPOSITORY"))];

pub fn run(args: &Args) -> Outcome {
    let folder = &args.folder;
    let cannot = |error: std::io::Error| format!("cannot make `{}`: {error}", folder.display());
    if folder.exists() && !folder.is_dir() {
        return Err(format!("`{}` is a file", folder.display()));
    }
    if folder.is_dir() && fs::read_dir(folder).map_err(cannot)?.any(|entry| entry.is_ok_and(|entry| !is_git(&entry))) {
        return Err(format!("`{}` is not empty: a project begins in a new folder", folder.display()));
    }
    for (name, text) in FILES {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(cannot)?;
        let text = WORDS.iter().fold(text.to_string(), |text, (word, value)| text.replace(word, value));
        write::create(&path, &text)?;
    }
    let scene = folder.join("scene.kin");
    let bless = format!("kinora test {} --bless", scene.display());
    let made = reference(&scene)?;
    let then =
        if made { String::new() } else { format!("  {bless}    makes the picture that its test compares with\n") };
    let scene = scene.display();
    terminal::out(&format!(
        "made a project in {}\n  kinora view {scene}    shows it while you write\n{then}",
        folder.display()
    ))?;
    Ok(exit::CLEAN)
}

// A repository may be there before anything is in it.
fn is_git(entry: &fs::DirEntry) -> bool {
    entry.file_name() == ".git"
}

/// Makes the picture that the scene's test compares with; false where this program does not render.
#[cfg(feature = "render")]
fn reference(scene: &Path) -> Result<bool, String> {
    super::test::bless(scene).map(|_| true)
}

#[cfg(not(feature = "render"))]
fn reference(_: &Path) -> Result<bool, String> {
    Ok(false)
}
