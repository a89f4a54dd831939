//! The files of a project: what is open in the editor, and the rest as the disk has it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use kinora_lang::files::{self, Files, Folder};
use kinora_lang::ide::{Analysis, Place};
use kinora_lang::library;
use kinora_lang::source::{FileId, Source};
use lsp_types::Uri;

use super::uri;

/// Texts that are open, by absolute path.
pub type Open = BTreeMap<PathBuf, Arc<[u8]>>;

/// So many scene files of a project are looked through for names.
const MOST_FILES: usize = 5_000;

/// So many files and folders are looked at to find them.
const MOST_ENTRIES: usize = 200_000;

/// The folder that a text belongs to, with the open texts in it, and the name of the text there. Where there is no such
/// folder, the open texts alone.
pub enum Project {
    Folder(Folder, String),
    Nowhere { open: files::Memory, root: PathBuf, name: String },
}

impl Project {
    pub fn of(path: &Path, open: &Open) -> Project {
        match Folder::of(path) {
            Ok((folder, name)) => Project::Folder(folder.with_open(open), name),
            Err(_) => {
                let name = path.file_name().map_or("scene.kin".into(), |name| name.to_string_lossy().into_owned());
                let root = path.parent().unwrap_or(Path::new("")).to_path_buf();
                let texts: Vec<(String, &[u8])> =
                    open.iter().filter_map(|(path, text)| Some((below(&root, path)?, &**text))).collect();
                let open = files::Memory::new(texts.iter().map(|(name, text)| (&**name, *text)));
                Project::Nowhere { open, root, name }
            }
        }
    }

    pub fn files(&self) -> &dyn Files {
        match self {
            Project::Folder(folder, _) => folder,
            Project::Nowhere { open, .. } => open,
        }
    }

    /// The name of the text, from the root.
    pub fn name(&self) -> &str {
        match self {
            Project::Folder(_, name) | Project::Nowhere { name, .. } => name,
        }
    }

    pub fn root(&self) -> &Path {
        match self {
            Project::Folder(folder, _) => folder.root(),
            Project::Nowhere { root, .. } => root,
        }
    }

    /// Where a file of the project is on the disk. What is part of this program is written there, so that editors can show it.
    pub fn path(&self, file: &str) -> Option<PathBuf> {
        match library::is_path(file) {
            true => standard(file),
            false => Some(self.root().join(file)),
        }
    }

    pub fn uri(&self, file: &str) -> Option<Uri> {
        uri::of(&self.path(file)?)
    }

    /// The text of a file of the project as it counts: open, or on the disk.
    pub fn source(&self, file: &str) -> Option<Source> {
        match library::is_path(file) {
            true => Some(Source::new(FileId(0), file, library::find(file)?)),
            false => files::load(self.files(), FileId(0), file).ok().map(|loaded| loaded.source),
        }
    }

    pub fn analyse(&self, file: &str) -> Option<Analysis> {
        Some(Analysis::new(file, &self.source(file)?.text, self.files()))
    }

    /// The scene files of the project, from its root, sorted: those that are open, and those on the disk that are not ignored.
    pub fn scenes(&self, open: &Open) -> Vec<String> {
        let root = self.root();
        let mut found: Vec<String> = scenes_below(root).iter().filter_map(|path| below(root, path)).collect();
        found.extend(open.keys().filter_map(|path| below(root, path)));
        found.push(self.name().to_string());
        found.sort();
        found.dedup();
        found
    }

    /// Every place of the project that means what is declared at a place. With `same_word`, only those that are called the same.
    pub fn references(&self, open: &Open, declared: &Place, same_word: bool) -> Vec<Place> {
        let analyses = self.scenes(open).into_iter().filter_map(|file| self.analyse(&file));
        let mut found: Vec<Place> = analyses.flat_map(|analysis| analysis.references(declared, same_word)).collect();
        found.sort();
        found.dedup();
        found
    }
}

/// The path of a file from a root.
fn below(root: &Path, path: &Path) -> Option<String> {
    let parts: Option<Vec<&str>> = path.strip_prefix(root).ok()?.iter().map(|part| part.to_str()).collect();
    Some(parts?.join("/"))
}

/// The scene files below a folder, as far as they are not ignored.
pub fn scenes_below(root: &Path) -> Vec<PathBuf> {
    let walk = ignore::WalkBuilder::new(root).require_git(false).follow_links(false).max_depth(Some(16)).build();
    let scene = |path: &Path| path.extension().is_some_and(|ending| ending == "kin") && path.is_file();
    let found = walk.take(MOST_ENTRIES).flatten().map(|entry| entry.into_path());
    found.filter(|path| scene(path)).take(MOST_FILES).collect()
}

/// Where the parts of this program are written that editors open.
fn standard_folder() -> PathBuf {
    let of = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let cache = of("XDG_CACHE_HOME").or_else(|| Some(of("HOME")?.join(".cache"))).or_else(|| of("LOCALAPPDATA"));
    cache.unwrap_or_else(std::env::temp_dir).join("kinora").join(env!("CARGO_PKG_VERSION"))
}

/// Whether a file is a part of this program that was written for an editor.
pub fn is_standard(path: &Path) -> bool {
    let folder = standard_folder();
    path.starts_with(folder.canonicalize().unwrap_or(folder))
}

/// A part of this program as a file that editors can open.
fn standard(file: &str) -> Option<PathBuf> {
    let text = library::find(file)?;
    let path = standard_folder().join(format!("{file}.kin"));
    let is_there = std::fs::read(&path).is_ok_and(|there| there == text.as_bytes());
    if !is_there {
        std::fs::create_dir_all(path.parent()?).ok()?;
        crate::write::create(&path, text).ok()?;
    }
    Some(path)
}
