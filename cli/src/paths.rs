//! Which files are meant: scenes by name, folders by what is in them.

use std::path::{Path, PathBuf};

use ignore::WalkBuilder;
use ignore::overrides::{Override, OverrideBuilder};

/// How files are looked for.
#[derive(Clone, Debug, Default)]
pub struct Search {
    /// Patterns, as in .gitignore, of what is left out.
    pub exclude: Vec<String>,
    /// Leave out files too that are named themselves.
    pub force_exclude: bool,
    /// Look also where .gitignore says not to, and in folders called `target`.
    pub no_ignore: bool,
    /// Finding nothing is fine.
    pub allow_empty: bool,
}

/// The scenes that the paths mean: files as they are, folders by what is in them.
///
/// # Errors
/// A folder cannot be read, a pattern is none, or there is nothing.
pub fn find(paths: &[PathBuf], search: &Search) -> Result<Vec<PathBuf>, String> {
    let mut excluded = OverrideBuilder::new(".");
    for pattern in &search.exclude {
        excluded.add(&format!("!{pattern}")).map_err(|error| format!("--exclude `{pattern}`: {error}"))?;
    }
    let excluded = excluded.build().map_err(|error| format!("--exclude: {error}"))?;
    let mut files = Vec::new();
    for path in paths {
        let first = files.len();
        match path.is_dir() {
            true => walk(path, search, &excluded, &mut files)?,
            false if search.force_exclude && excluded.matched(path, false).is_ignore() => continue,
            false => files.push(path.clone()),
        }
        if files.len() == first && !search.allow_empty {
            return Err(format!("there is no *.kin in `{}`", path.display()));
        }
    }
    if files.is_empty() && !search.allow_empty {
        return Err("nothing is left to look at".into());
    }
    Ok(files)
}

// Adds every *.kin in and below `folder`, sorted. What is hidden, ignored, called `target` or linked is left out.
fn walk(folder: &Path, search: &Search, excluded: &Override, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let mut builder = WalkBuilder::new(folder);
    // What one machine ignores in all folders would make its results its own.
    builder.standard_filters(!search.no_ignore).hidden(true).git_global(false).require_git(false);
    builder.overrides(excluded.clone());
    let no_ignore = search.no_ignore;
    builder.filter_entry(move |entry| {
        no_ignore || entry.depth() == 0 || entry.file_name() != "target" || !entry.path().is_dir()
    });
    let first = files.len();
    for entry in builder.build() {
        let entry = entry.map_err(|error| format!("cannot read the folder `{}`: {error}", folder.display()))?;
        let is_file = entry.file_type().is_some_and(|kind| kind.is_file());
        if is_file && entry.path().extension().is_some_and(|ending| ending == "kin") {
            files.push(entry.into_path());
        }
    }
    if let Some(found) = files.get_mut(first..) {
        found.sort();
    }
    Ok(())
}
