//! Which files are meant: scenes by name, folders by what is in them.

use std::path::{Path, PathBuf};

/// The scenes that the paths mean: files as they are, folders by what is in them.
pub fn find(paths: &[PathBuf]) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    for path in paths {
        let first = files.len();
        match path.is_dir() {
            true => walk(path, &mut files)?,
            false => files.push(path.clone()),
        }
        if files.len() == first {
            return Err(format!("there is no *.kin in `{}`", path.display()));
        }
    }
    Ok(files)
}

// Adds every *.kin in and below `folder`, sorted. What is hidden, called `target` or linked is left out.
fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let mut open = vec![folder.to_path_buf()];
    let first = files.len();
    while let Some(folder) = open.pop() {
        let unreadable = |error| format!("cannot read the folder `{}`: {error}", folder.display());
        for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
            let entry = entry.map_err(unreadable)?;
            let (name, kind) = (entry.file_name(), entry.file_type().map_err(unreadable)?);
            if name.to_string_lossy().starts_with('.') {
                continue;
            }
            if kind.is_dir() && name != "target" {
                open.push(entry.path());
            } else if kind.is_file() && entry.path().extension().is_some_and(|ending| ending == "kin") {
                files.push(entry.path());
            }
        }
    }
    if let Some(found) = files.get_mut(first..) {
        found.sort();
    }
    Ok(())
}
