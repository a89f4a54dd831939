//! Which folders to watch for a list of files, and which events there concern them.
//!
//! Folders and not files: editors save by putting another file in the place of the old one, and a watch on a file stays
//! with the old one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The folders of `files`, and of what links among them lead to; where a folder is missing, the nearest one above it that
/// is there.
pub fn folders(files: &[PathBuf]) -> BTreeSet<PathBuf> {
    let real = files.iter().filter_map(|file| file.canonicalize().ok());
    let above = |file: &Path| file.ancestors().skip(1).find(|folder| folder.is_dir()).map(Path::to_path_buf);
    files.iter().cloned().chain(real).filter_map(|file| above(&file)).collect()
}

/// Whether something that happened to `path` may have changed one of `files`: it is one, or a folder above one, or what
/// a link among them leads to.
pub fn concerns(path: &Path, files: &[PathBuf]) -> bool {
    files.iter().any(|file| file.starts_with(path) || file.canonicalize().is_ok_and(|real| real.starts_with(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_folder_that_is_there_is_watched() {
        let root = std::env::temp_dir().join(format!("kinora-folders-{}", std::process::id()));
        std::fs::create_dir_all(root.join("scenes")).unwrap();
        let root = root.canonicalize().unwrap();
        let files = [root.join("scenes/a.kin"), root.join("meshes/deep/b.obj")];
        assert_eq!(folders(&files), BTreeSet::from([root.clone(), root.join("scenes")]));
        for (path, expected) in [
            ("scenes/a.kin", true),
            ("scenes/a.kin~", false),
            ("scenes/other.kin", false),
            ("meshes", true),
            ("meshes/deep/b.obj", true),
            ("meshes/deep/b.obj/c", false),
        ] {
            assert_eq!(concerns(&root.join(path), &files), expected, "{path}");
        }
        std::fs::remove_dir_all(&root).unwrap();
    }
}
