//! The only door to the disk, and it cannot leave the project.
//!
//! The project is the nearest folder above the scene that holds `kinora.toml`, else the scene's own folder. Scenes name
//! files with `/`, relative to themselves, or from the project's root with a leading `/`; [`resolve`] turns that into a
//! path from the root, and [`Files`] reads such paths and remembers each one, found or not: that list is what a watcher
//! watches.
//!
//! [`Folder`] opens the project's root once and everything else relative to that handle (cap-std), so that no path, link
//! or renamed folder leads out of it, whatever happens to the disk meanwhile.

use crate::assets::cache::{Cache, Version};
use crate::diagnostic::{Applicability, Diagnostic};
use crate::source::{FileId, MAX_SOURCE_BYTES, Source, Span, decode};
use crate::suggest::suggest;
use cap_std::ambient_authority;
use cap_std::fs::Dir;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime};

/// The file that makes a folder a project, and says what holds in all of it.
pub const PROJECT: &str = "kinora.toml";

/// Most bytes an asset may have, unless its reader says less.
pub const MAX_ASSET_BYTES: u64 = 2 << 30;

/// Why a file could not be read. `path` is relative to the project's root, or as written where it names no place in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileError {
    /// There is no such file.
    Missing {
        /// The path.
        path: String,
    },
    /// There is one whose name differs in upper and lower case only: some systems would find it, others not.
    Case {
        /// The path asked for.
        path: String,
        /// The path as the disk has it.
        named: String,
    },
    /// `..` above the root.
    Outside {
        /// The path.
        path: String,
    },
    /// An absolute path of the system, a URL or the name of a device.
    Forbidden {
        /// The path.
        path: String,
    },
    /// A symbolic link leads out of the project.
    Link {
        /// The path.
        path: String,
    },
    /// The system does not give it.
    Unreadable {
        /// The path.
        path: String,
        /// In plain words: "is a directory".
        reason: String,
    },
    /// More bytes than allowed.
    TooLarge {
        /// The path.
        path: String,
        /// Its size.
        bytes: u64,
        /// What is allowed.
        limit: u64,
    },
}

impl FileError {
    /// The code of [`FileError::diagnostic`].
    pub fn code(&self) -> &'static str {
        match self {
            FileError::Missing { .. } => "E0701",
            FileError::Case { .. } => "E0708",
            FileError::Outside { .. } => "E0703",
            FileError::Forbidden { .. } => "E0704",
            FileError::Link { .. } => "E0705",
            FileError::Unreadable { .. } => "E0711",
            FileError::TooLarge { .. } => "E0712",
        }
    }

    /// One lower-case clause.
    pub fn message(&self) -> String {
        match self {
            FileError::Missing { path } => format!("cannot find `{path}`"),
            FileError::Case { named, .. } => format!("file is named `{named}`"),
            FileError::Outside { path } => format!("`{path}` is outside the project"),
            FileError::Forbidden { .. } => "only paths inside the project are allowed".to_string(),
            FileError::Link { path } => format!("`{path}` links outside the project"),
            FileError::Unreadable { path, reason } => format!("cannot read `{path}`: {reason}"),
            FileError::TooLarge { path, bytes, limit } => {
                format!("`{path}` is {}, limit {}", mebibytes(*bytes), mebibytes(*limit))
            }
        }
    }

    /// The same as a diagnostic at the place that names the file.
    pub fn diagnostic(&self, file: FileId, span: Span) -> Diagnostic {
        let found = Diagnostic::new(self.code(), self.message());
        match self {
            FileError::Missing { path } => {
                found.primary(file, span, "no such file").note(format!("looked in the project for `{path}`"))
            }
            FileError::Case { .. } => found
                .primary(file, span, "upper and lower case differ")
                .note("some systems would find it all the same, others would not")
                .help("write it as the file is named"),
            FileError::Outside { .. } => found
                .primary(file, span, "leaves the project")
                .note("the project is the folder with kinora.toml, else the scene's folder")
                .help("where the scene's folder is a part of the project, put an empty kinora.toml into the whole"),
            FileError::Forbidden { path } if path.contains('\\') => {
                found.primary(file, span, "not a path of the project").help("separate folders with `/`")
            }
            FileError::Forbidden { .. } => found
                .primary(file, span, "not a path of the project")
                .help("copy the file into the project, for example to `assets/`"),
            FileError::Link { .. } => found
                .primary(file, span, "a symbolic link leads out of the project")
                .help("copy the file into the project"),
            FileError::Unreadable { .. } => found.primary(file, span, ""),
            FileError::TooLarge { .. } => {
                found.primary(file, span, "").help("put large data into meshes or images of their own")
            }
        }
    }
}

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message())
    }
}

impl std::error::Error for FileError {}

fn mebibytes(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} bytes"),
        1024..1_048_576 => format!("{} KiB", bytes.div_ceil(1024)),
        _ => format!("{} MiB", bytes.div_ceil(1 << 20)),
    }
}

/// A file that was asked for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependency {
    /// Path from the project's root.
    pub path: String,
    /// Whether it could be read. A missing file is a dependency too: the scene changes when it appears.
    pub found: bool,
}

/// Bytes by path from the project's root.
pub trait Files {
    /// Reads a file of at most `limit` bytes and remembers that it was asked for.
    ///
    /// # Errors
    /// Every [`FileError`]; the path is checked again here, so a caller cannot get round [`resolve`].
    fn read_at_most(&self, path: &str, limit: u64) -> Result<Arc<[u8]>, FileError>;

    /// Every path asked for so far, sorted, each once.
    fn dependencies(&self) -> Vec<Dependency>;

    /// The names in a folder of the project, sorted, for suggestions: none where there is no such folder.
    fn names_in(&self, folder: &str) -> Vec<String>;

    /// What was made of files before, if that is kept.
    fn cache(&self) -> Option<&Cache> {
        None
    }

    /// What tells whether a file is as it was, and remembers that it was asked for; `None` where that cannot be said: it
    /// is not there, or was changed so lately that it may change again without showing it.
    fn version(&self, _path: &str) -> Option<Version> {
        None
    }

    /// Reads an asset.
    ///
    /// # Errors
    /// As [`Files::read_at_most`], with [`MAX_ASSET_BYTES`].
    fn read(&self, path: &str) -> Result<Arc<[u8]>, FileError> {
        self.read_at_most(path, MAX_ASSET_BYTES)
    }
}

/// Folders of systems.
const SYSTEM: &[&str] = &[
    "Applications",
    "Users",
    "Volumes",
    "bin",
    "dev",
    "etc",
    "home",
    "mnt",
    "opt",
    "proc",
    "root",
    "srv",
    "tmp",
    "usr",
    "var",
];

/// A failed read as a diagnostic at the place that names the file, with the name that may have been meant. `literal` is
/// the text at that place: where it is `written` between quotes, it can be put right.
pub fn diagnose(
    files: &dyn Files,
    error: &FileError,
    (file, span): (FileId, Span),
    written: &str,
    literal: &str,
) -> Diagnostic {
    // A path from the project's folder that is meant to be one from the system's.
    let first = written.strip_prefix('/').and_then(|path| path.split('/').next());
    if let (FileError::Missing { .. }, Some(first)) = (error, first)
        && SYSTEM.contains(&first)
    {
        let forbidden = FileError::Forbidden { path: written.to_string() };
        return forbidden.diagnostic(file, span).note("a leading `/` means the project's folder");
    }
    let found = error.diagnostic(file, span);
    let fixable = literal.strip_prefix('"').and_then(|text| text.strip_suffix('"')) == Some(written);
    match error {
        FileError::Case { path, named } => match (fixable, as_named(written, path, named)) {
            (true, Some(put)) => {
                let put = format!("\"{put}\"");
                found.fix(Applicability::Safe, format!("write `{put}`"), file, span, put)
            }
            _ => found,
        },
        FileError::Missing { path } => {
            let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
            let names = files.names_in(folder);
            // A name that lacks nothing but its ending is nearer than any other.
            let ending = |known: &&String| known.rsplit_once('.').is_some_and(|(stem, _)| stem == name);
            let near = names.iter().find(ending).map(String::as_str);
            let Some(near) = near.or_else(|| suggest(name, names.iter().map(String::as_str)).first().copied()) else {
                return found;
            };
            let start = written.len() - written.rsplit('/').next().map_or(0, str::len);
            let put = format!("{}{near}", &written[..start]);
            match fixable {
                true => {
                    found.fix(Applicability::Maybe, format!("did you mean `{put}`?"), file, span, format!("\"{put}\""))
                }
                false => found.help(format!("did you mean `{put}`?")),
            }
        }
        _ => found,
    }
}

/// `written` with its last names as the disk has them.
fn as_named(written: &str, path: &str, named: &str) -> Option<String> {
    let mut parts: Vec<&str> = written.split('/').collect();
    for (part, (path, named)) in parts.iter_mut().rev().zip(path.rsplit('/').zip(named.rsplit('/'))) {
        if *part != path {
            break;
        }
        *part = named;
    }
    let put = parts.join("/");
    (put != written).then_some(put)
}

/// What comes of reading a scene file.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The text; where the bytes are no UTF-8, a readable approximation.
    pub source: Source,
    /// E0119, if the bytes are no UTF-8. The text is then not worth parsing.
    pub error: Option<Diagnostic>,
}

/// Reads a scene file.
///
/// # Errors
/// As [`Files::read_at_most`], with [`MAX_SOURCE_BYTES`].
pub fn load(files: &dyn Files, id: FileId, path: &str) -> Result<Loaded, FileError> {
    let bytes = files.read_at_most(path, MAX_SOURCE_BYTES as u64)?;
    let (source, error) = decode(id, path, &bytes);
    Ok(Loaded { source, error })
}

/// The path from the project's root that `written` means in the scene `from` (itself from the root).
///
/// ```
/// use kinora_lang::files::resolve;
/// assert_eq!(resolve("scenes/a.kin", "../lib/metals.kin").as_deref(), Ok("lib/metals.kin"));
/// assert_eq!(resolve("scenes/a.kin", "/lib/metals.kin").as_deref(), Ok("lib/metals.kin"));
/// assert!(resolve("scenes/a.kin", "../../etc/passwd").is_err());
/// ```
///
/// # Errors
/// [`FileError::Outside`] and [`FileError::Forbidden`]; the disk is not asked.
pub fn resolve(from: &str, written: &str) -> Result<String, FileError> {
    let forbidden = || FileError::Forbidden { path: written.to_string() };
    if written.is_empty() || written.contains(['\\', ':', '\0']) || written.starts_with("//") {
        return Err(forbidden());
    }
    let mut parts: Vec<&str> = match written.starts_with('/') {
        true => Vec::new(),
        false => from.split('/').filter(|part| !matches!(*part, "" | ".")).collect(),
    };
    parts.pop();
    for part in written.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.pop().is_none() => return Err(FileError::Outside { path: written.to_string() }),
            ".." => {}
            part if is_device(part) => return Err(forbidden()),
            part => parts.push(part),
        }
    }
    Ok(parts.join("/"))
}

fn same_but_for_case(a: &str, b: &str) -> bool {
    a.to_lowercase() == b.to_lowercase()
}

/// Names that mean a device on Windows, with any extension: refused everywhere, so that a project works everywhere.
fn is_device(part: &str) -> bool {
    let stem = part.split('.').next().unwrap_or(part).trim_end().to_ascii_uppercase();
    let numbered = |prefix: &str| {
        stem.strip_prefix(prefix).is_some_and(|rest| rest.len() == 1 && rest.bytes().all(|b| b.is_ascii_digit()))
    };
    matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL") || numbered("COM") || numbered("LPT")
}

/// The list behind [`Files::dependencies`].
#[derive(Debug, Default)]
struct Asked(Mutex<BTreeMap<String, bool>>);

impl Asked {
    fn note<T>(&self, path: &str, result: Result<T, FileError>) -> Result<T, FileError> {
        let mut asked = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        asked.insert(path.to_string(), result.is_ok());
        result
    }

    fn list(&self) -> Vec<Dependency> {
        let asked = self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        asked.iter().map(|(path, found)| Dependency { path: path.clone(), found: *found }).collect()
    }
}

/// A project folder on the disk.
#[derive(Debug)]
pub struct Folder {
    root: PathBuf,
    dir: Dir,
    asked: Asked,
    listed: AtomicUsize,
    cache: Option<Arc<Cache>>,
    /// Texts that count instead of what is on the disk, by path from the root.
    open: BTreeMap<String, Arc<[u8]>>,
}

/// Within so short a time, two changes of a file may have the same date; and where dates have no fractions of seconds.
const DATE_STEP: Duration = Duration::from_millis(100);
const COARSE_DATE_STEP: Duration = Duration::from_millis(2500);

/// Folders that are listed for suggestions: behind so many mistakes nobody looks for help.
const LISTED: usize = 200;

impl Folder {
    /// The project that `scene` belongs to, and the scene's path from its root.
    ///
    /// # Errors
    /// The folder of the scene does not exist, or the path has no file name or is no Unicode. The scene itself need not
    /// exist yet.
    pub fn of(scene: &Path) -> std::io::Result<(Folder, String)> {
        let bad = |what: &str| std::io::Error::new(std::io::ErrorKind::InvalidInput, what);
        let name = scene.file_name().ok_or_else(|| bad("the path names no file"))?;
        let parent = match scene.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let parent = parent.canonicalize()?;
        let root = parent.ancestors().find(|folder| folder.join(PROJECT).is_file()).unwrap_or(&parent);
        // Whoever calls the scene by another case means the scene; only what is written in scenes must work everywhere.
        let real = parent.join(name).canonicalize().ok();
        let real = real
            .as_deref()
            .and_then(Path::file_name)
            .filter(|real| real.to_str().zip(name.to_str()).is_some_and(|(real, name)| same_but_for_case(real, name)));
        let inside = parent.strip_prefix(root).unwrap_or(Path::new("")).join(real.unwrap_or(name));
        let parts: Option<Vec<&str>> = inside.iter().map(|part| part.to_str()).collect();
        let parts = parts.ok_or_else(|| bad("the path is not Unicode"))?;
        let dir = Dir::open_ambient_dir(root, ambient_authority())?;
        Ok((
            Folder {
                root: root.to_path_buf(),
                dir,
                asked: Asked::default(),
                listed: AtomicUsize::new(0),
                cache: None,
                open: BTreeMap::new(),
            },
            parts.join("/"),
        ))
    }

    /// The same folder; what is made of its files is kept in `cache`, and taken from there.
    #[must_use]
    pub fn with_cache(self, cache: Arc<Cache>) -> Folder {
        Folder { cache: Some(cache), ..self }
    }

    /// The same folder; these texts, by absolute path, count instead of what is on the disk: what an editor has open.
    #[must_use]
    pub fn with_open(mut self, open: &BTreeMap<PathBuf, Arc<[u8]>>) -> Folder {
        let below = |path: &Path| {
            let parts: Option<Vec<&str>> =
                path.strip_prefix(&self.root).ok()?.iter().map(|part| part.to_str()).collect();
            Some(parts?.join("/"))
        };
        self.open = open.iter().filter_map(|(path, text)| Some((below(path)?, text.clone()))).collect();
        self
    }

    fn version_now(&self, path: &str) -> Option<Version> {
        let data = self.dir.metadata(resolve("", path).ok()?).ok()?;
        let modified = data.modified().ok()?.into_std();
        let age = SystemTime::now().duration_since(modified).ok()?;
        let fine = modified.duration_since(SystemTime::UNIX_EPOCH).is_ok_and(|since| since.subsec_nanos() != 0);
        let trusted = data.is_file() && age > if fine { DATE_STEP } else { COARSE_DATE_STEP };
        trusted.then(|| Version { len: data.len(), modified, identity: identity(&data) })
    }

    /// The root, canonical.
    pub fn root(&self) -> &Path {
        &self.root
    }

    fn entries(&self, folder: &str) -> Vec<String> {
        const MOST_ENTRIES: usize = 10_000;
        let folder = if folder.is_empty() { "." } else { folder };
        let Ok(entries) = self.dir.read_dir(folder) else { return Vec::new() };
        entries.take(MOST_ENTRIES).flatten().filter_map(|entry| entry.file_name().into_string().ok()).collect()
    }

    /// The path as the disk has it, where only upper and lower case differ.
    fn named(&self, path: &str) -> Option<String> {
        let mut named = String::new();
        for part in path.split('/') {
            let mut like = self.entries(&named);
            like.retain(|name| same_but_for_case(name, part));
            like.sort_by_key(|name| (name != part, name.clone()));
            if !named.is_empty() {
                named.push('/');
            }
            named += &like.into_iter().next()?;
        }
        Some(named)
    }

    /// Where a path leads that the door does not let through: a link whose end lies in the project after all, though it
    /// is written from the system's root, is followed to there.
    fn followed(&self, path: &str) -> Option<PathBuf> {
        let real = self.root.join(path).canonicalize().ok()?;
        real.strip_prefix(&self.root).ok().map(Path::to_path_buf)
    }

    fn fetch(&self, path: &str, limit: u64) -> Result<Arc<[u8]>, FileError> {
        let path = resolve("", path)?;
        let unreadable = |reason: &str| FileError::Unreadable { path: path.clone(), reason: reason.to_string() };
        if path.is_empty() {
            return Err(unreadable("is a directory"));
        }
        let failed = |error: std::io::Error| match error.kind() {
            std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory => match self.named(&path) {
                Some(named) if named != path => FileError::Case { path: path.clone(), named },
                _ => FileError::Missing { path: path.clone() },
            },
            std::io::ErrorKind::PermissionDenied => unreadable("permission denied"),
            _ => {
                let reason = error.to_string();
                unreadable(reason.split(" (os error").next().unwrap_or(&reason))
            }
        };
        // Asked before opening: opening a pipe would wait for its other end.
        let mut inside = PathBuf::from(&path);
        let kind = match self.dir.metadata(&inside) {
            Err(error) if led_outside(&error) => {
                inside = self.followed(&path).ok_or_else(|| FileError::Link { path: path.clone() })?;
                self.dir.metadata(&inside).map_err(failed)?
            }
            kind => kind.map_err(failed)?,
        };
        // What the disk finds although it is called otherwise.
        if let Some(named) = self.followed(&path)
            && let Some(named) = named.to_str().map(|name| name.replace('\\', "/"))
            && named != path
            && same_but_for_case(&named, &path)
        {
            return Err(FileError::Case { path, named });
        }
        if kind.is_dir() {
            return Err(unreadable("is a directory"));
        }
        if !kind.is_file() {
            return Err(unreadable("is not a regular file"));
        }
        let file = self.dir.open(&inside).map_err(failed)?;
        let bytes = file.metadata().map_err(failed)?.len();
        let too_large = |bytes| FileError::TooLarge { path: path.clone(), bytes, limit };
        if bytes > limit {
            return Err(too_large(bytes));
        }
        let mut content = Vec::new();
        file.take(limit.saturating_add(1)).read_to_end(&mut content).map_err(failed)?;
        match content.len() as u64 {
            read if read > limit => Err(too_large(read)),
            _ => Ok(content.into()),
        }
    }
}

/// Whether cap-std refused a path because of where it leads. It says so by an error that has no number of the system's,
/// as opposed to a file whose permissions forbid to read it.
fn led_outside(error: &std::io::Error) -> bool {
    error.kind() == std::io::ErrorKind::PermissionDenied && error.raw_os_error().is_none()
}

#[cfg(unix)]
fn identity(data: &cap_std::fs::Metadata) -> (u64, u64, i64, i64) {
    use cap_std::fs::MetadataExt;
    (data.dev(), data.ino(), data.ctime(), data.ctime_nsec())
}

#[cfg(not(unix))]
fn identity(_: &cap_std::fs::Metadata) -> (u64, u64, i64, i64) {
    (0, 0, 0, 0)
}

impl Files for Folder {
    fn cache(&self) -> Option<&Cache> {
        self.cache.as_deref()
    }

    fn version(&self, path: &str) -> Option<Version> {
        let version = self.version_now(path).filter(|_| !self.open.contains_key(path))?;
        self.asked.note(path, Ok(version)).ok()
    }

    fn read_at_most(&self, path: &str, limit: u64) -> Result<Arc<[u8]>, FileError> {
        let open = self.open.get(path).filter(|text| text.len() as u64 <= limit);
        self.asked.note(path, open.map_or_else(|| self.fetch(path, limit), |text| Ok(text.clone())))
    }

    fn dependencies(&self) -> Vec<Dependency> {
        self.asked.list()
    }

    fn names_in(&self, folder: &str) -> Vec<String> {
        if self.listed.fetch_add(1, Ordering::Relaxed) >= LISTED {
            return Vec::new();
        }
        let mut names = self.entries(folder);
        names.sort();
        names
    }
}

/// A project in memory: for tests, and for texts that are not saved.
#[derive(Debug, Default)]
pub struct Memory {
    files: BTreeMap<String, Arc<[u8]>>,
    asked: Asked,
}

impl Memory {
    /// A project of these files, by path from its root.
    pub fn new<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Memory {
        let files = files.into_iter().map(|(path, bytes)| (path.to_string(), bytes.into())).collect();
        Memory { files, asked: Asked::default() }
    }

    fn fetch(&self, path: &str, limit: u64) -> Result<Arc<[u8]>, FileError> {
        let path = resolve("", path)?;
        match self.files.get(&path) {
            None => Err(match self.files.keys().find(|name| same_but_for_case(name, &path)) {
                Some(named) => FileError::Case { named: named.clone(), path },
                None => FileError::Missing { path },
            }),
            Some(bytes) if bytes.len() as u64 > limit => {
                Err(FileError::TooLarge { path, bytes: bytes.len() as u64, limit })
            }
            Some(bytes) => Ok(bytes.clone()),
        }
    }
}

impl Files for Memory {
    fn read_at_most(&self, path: &str, limit: u64) -> Result<Arc<[u8]>, FileError> {
        self.asked.note(path, self.fetch(path, limit))
    }

    fn dependencies(&self) -> Vec<Dependency> {
        self.asked.list()
    }

    fn names_in(&self, folder: &str) -> Vec<String> {
        let parts = self.files.keys().map(|path| path.rsplit_once('/').unwrap_or(("", path)));
        parts.filter(|(inside, _)| *inside == folder).map(|(_, name)| name.to_string()).collect()
    }
}
