//! `check --fix`: what can be put right is, until nothing more can be.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use kinora_lang::diagnostic::{Applicability, Diagnostic, apply, choose};
use kinora_lang::library;

use super::Checked;
use crate::write::write;

/// A fix can make room for another, so often at most.
pub const ROUNDS: usize = 10;

/// Applies fixes to the files and to what they import; how many findings were put right.
///
/// # Errors
/// A file cannot be read or written.
pub fn fix(
    files: &[PathBuf],
    least: Applicability,
    check: impl Fn(&Path) -> Result<Checked, String>,
) -> Result<usize, String> {
    if files.iter().any(|file| file == Path::new("-")) {
        return Err("what comes from standard input cannot be put right there: --fix needs a file".into());
    }
    let mut fixed = 0;
    for file in files {
        for _ in 0..ROUNDS {
            let Checked { loaded, found } = check(file)?;
            let own = |found: &Diagnostic| {
                let edits = || found.fixes.iter().flat_map(|fix| &fix.edits);
                edits().all(|edit| {
                    loaded.sources.iter().any(|source| source.id == edit.file && !library::is_path(&source.name))
                })
            };
            let found: Vec<Diagnostic> = found.into_iter().filter(own).collect();
            let edits = choose(&found, least);
            if edits.is_empty() {
                break;
            }
            let changed: BTreeSet<_> = edits.iter().map(|edit| edit.file).collect();
            for source in loaded.sources.iter().filter(|source| changed.contains(&source.id)) {
                let text = apply(&source.text, source.id, &edits);
                if let Some(path) = loaded.path_of(source.id) {
                    write(&path, &text)?;
                }
            }
            let applied = |found: &&Diagnostic| {
                let fix = found.fixes.iter().find(|fix| fix.applicability <= least);
                fix.is_some_and(|fix| fix.edits.iter().all(|edit| edits.contains(edit)))
            };
            fixed += found.iter().filter(applied).count();
        }
    }
    Ok(fixed)
}
