//! `kinora migrate`: scenes of an older version of the language become those of this one.

use std::path::Path;

use kinora_lang::Tree;
use kinora_lang::diagnostic::{Applicability, Diagnostic, Level, Levels, apply, choose};
use kinora_lang::source::FileId;

use super::check::ROUNDS;
use super::rewrite::{RewriteFlags, rewrite};
use crate::exit::Outcome;
use crate::session::{self, Changes};

/// Bring scenes to the version of the language that this program speaks: its `lang` line, and names that have changed.
///
/// Example: kinora migrate scenes --diff
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    files: RewriteFlags,
}

/// What is about versions: no `lang` line, one that is not the first, and names that the next version will not know.
const CODES: [&str; 3] = ["W0710", "E0707", "W0901"];
/// A version that this program does not know: nothing can be said of such a file.
const UNKNOWN: &str = "E0709";

pub fn run(args: &Args) -> Outcome {
    rewrite(&args.files, migrated)
}

/// The text as this version has it.
fn migrated(path: &Path, tree: &Tree) -> Result<String, Vec<Diagnostic>> {
    if !tree.errors().is_empty() {
        return Err(tree.errors().to_vec());
    }
    // Also where the project takes no notice of such things.
    let mut levels = Levels::default();
    for code in CODES.into_iter().filter(|code| code.starts_with('W')) {
        let _ = levels.set(code, Level::Warn);
    }
    let changes = Changes { no_assets: true, levels, ..Changes::default() };
    let mut text = tree.source.text.to_string();
    for _ in 0..ROUNDS {
        let fault = |why: String| vec![Diagnostic::new("E0711", why)];
        let loaded = session::load_bytes(FileId::default(), path, text.as_bytes(), &changes).map_err(fault)?;
        let own = |found: &Diagnostic| found.place().is_some_and(|(file, _)| file == FileId::default());
        let found: Vec<Diagnostic> = loaded.diagnostics.into_iter().filter(own).collect();
        if found.iter().any(|found| found.code == UNKNOWN) {
            return Err(found.into_iter().filter(|found| found.code == UNKNOWN).collect());
        }
        let found: Vec<Diagnostic> = found.into_iter().filter(|found| CODES.contains(&found.code)).collect();
        let edits = choose(&found, Applicability::Safe);
        if edits.is_empty() {
            break;
        }
        text = apply(&text, FileId::default(), &edits);
    }
    Ok(text)
}
