//! What was made of files, kept as long as they stay as they are: who reads a scene again after an edit does not decode
//! its meshes and pictures again.

use std::any::Any;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use crate::files::{Dependency, FileError, Files};

/// What tells one state of a file from another, without a look into it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Version {
    /// Bytes.
    pub len: u64,
    /// When it was changed.
    pub modified: SystemTime,
    /// Which file of the disk it is, and when anything about it was changed, where the system says so.
    pub identity: (u64, u64, i64, i64),
}

/// What was made of files. Bounded: what a reading that used anything did not use is dropped at the next.
#[derive(Default)]
pub struct Cache(Mutex<Kept>);

#[derive(Default)]
struct Kept {
    entries: HashMap<String, Entry>,
    reading: u64,
    used: bool,
}

struct Entry {
    value: Arc<dyn Any + Send + Sync>,
    from: Vec<(String, Version)>,
    reading: u64,
}

impl std::fmt::Debug for Cache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cache").finish_non_exhaustive()
    }
}

impl Cache {
    /// Another reading of a scene begins.
    pub fn begin(&self) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // A text with a mistake uses nothing, and is soon put right.
        if std::mem::take(&mut kept.used) {
            let reading = kept.reading;
            kept.entries.retain(|_, entry| entry.reading == reading);
        }
        kept.reading += 1;
    }

    fn find(&self, key: &str, files: &dyn Files) -> Option<Arc<dyn Any + Send + Sync>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Kept { entries, reading, used } = &mut *kept;
        let entry = entries.get_mut(key)?;
        // All of them are asked for, so that all are known to matter.
        let same = entry.from.iter().filter(|(path, version)| files.version(path) == Some(*version)).count();
        if same != entry.from.len() {
            entries.remove(key);
            return None;
        }
        (entry.reading, *used) = (*reading, true);
        Some(entry.value.clone())
    }

    fn keep(&self, key: String, value: Arc<dyn Any + Send + Sync>, from: Vec<(String, Version)>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let reading = kept.reading;
        kept.used = true;
        kept.entries.insert(key, Entry { value, from, reading });
    }
}

/// What `make` makes of the files that it reads, or made before. `key` says what that is: it must name everything besides
/// the files that it depends on.
///
/// # Errors
/// Those of `make`, each time.
pub fn made<T: Send + Sync + 'static, E>(
    files: &dyn Files,
    key: impl FnOnce() -> String,
    make: impl FnOnce(&dyn Files) -> Result<T, E>,
) -> Result<Arc<T>, E> {
    let Some(cache) = files.cache() else { return make(files).map(Arc::new) };
    let key = key();
    if let Some(found) = cache.find(&key, files).and_then(|found| found.downcast::<T>().ok()) {
        return Ok(found);
    }
    let noting = Noting { files, read: Mutex::default() };
    let value = Arc::new(make(&noting)?);
    let read = noting.read.into_inner().unwrap_or_else(PoisonError::into_inner);
    // Whoever reads a file twice may see two states of it.
    let from: Option<Vec<_>> =
        read.into_iter().map(|(path, version)| (files.version(&path) == version).then_some((path, version?))).collect();
    if let Some(from) = from {
        cache.keep(key, value.clone(), from);
    }
    Ok(value)
}

/// Notes what is read.
struct Noting<'a> {
    files: &'a dyn Files,
    read: Mutex<Vec<(String, Option<Version>)>>,
}

impl Files for Noting<'_> {
    fn read_at_most(&self, path: &str, limit: u64) -> Result<Arc<[u8]>, FileError> {
        let version = self.files.version(path);
        self.read.lock().unwrap_or_else(PoisonError::into_inner).push((path.to_string(), version));
        self.files.read_at_most(path, limit)
    }

    fn dependencies(&self) -> Vec<Dependency> {
        self.files.dependencies()
    }

    fn names_in(&self, folder: &str) -> Vec<String> {
        self.files.names_in(folder)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::path::PathBuf;
    use std::time::Duration;

    use super::*;
    use crate::files::Folder;

    struct Place(PathBuf);

    impl Place {
        fn new(name: &str) -> Place {
            let path = std::env::temp_dir().join(format!("kinora-cache-{name}-{}", std::process::id()));
            std::fs::create_dir_all(&path).unwrap();
            Place(path)
        }

        /// Long ago enough that its date tells.
        fn write(&self, name: &str, text: &str, seconds_ago: u64) {
            let path = self.0.join(name);
            std::fs::write(&path, text).unwrap();
            let date = SystemTime::now() - Duration::from_secs(seconds_ago);
            std::fs::File::options().append(true).open(path).unwrap().set_modified(date).unwrap();
        }
    }

    impl Drop for Place {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn what_was_made_is_kept_while_its_files_stay() {
        let place = Place::new("stay");
        place.write("a", "one", 100);
        place.write("b", "two", 100);
        let cache = Arc::new(Cache::default());
        let count = Cell::new(0);
        let read = || {
            cache.begin();
            let folder = Folder::of(&place.0.join("scene.kin")).unwrap().0.with_cache(cache.clone());
            let text = |files: &dyn Files| {
                count.set(count.get() + 1);
                let bytes = ["a", "b"].map(|path| files.read(path).map(|bytes| bytes.to_vec()));
                let [a, b] = bytes;
                Ok::<_, FileError>(String::from_utf8([a?, b?].concat()).unwrap())
            };
            let made = made(&folder, || "both".to_string(), text);
            assert_eq!(folder.dependencies().len(), 2, "what is kept is a dependency, too");
            (made.map(|text| text.to_string()).unwrap_or_default(), count.get())
        };
        assert_eq!(read(), ("onetwo".to_string(), 1));
        assert_eq!(read(), ("onetwo".to_string(), 1));
        place.write("b", "six", 90);
        assert_eq!(read(), ("onesix".to_string(), 2));
        assert_eq!(read(), ("onesix".to_string(), 2));
        // Just written: a later change might have the same date.
        place.write("a", "ten", 0);
        assert_eq!(read(), ("tensix".to_string(), 3));
        assert_eq!(read().0, "tensix");
        std::fs::remove_file(place.0.join("a")).unwrap();
        assert_eq!(read().0, "");
        place.write("a", "one", 80);
        assert_eq!(read().0, "onesix");
    }

    #[test]
    fn what_is_not_used_goes() {
        let place = Place::new("goes");
        place.write("a", "one", 100);
        place.write("b", "two", 100);
        let cache = Arc::new(Cache::default());
        let count = Cell::new(0);
        let read = |paths: &[&str]| {
            cache.begin();
            let folder = Folder::of(&place.0.join("scene.kin")).unwrap().0.with_cache(cache.clone());
            for path in paths {
                let make = |files: &dyn Files| {
                    count.set(count.get() + 1);
                    files.read(path)
                };
                made(&folder, || path.to_string(), make).unwrap();
            }
            count.get()
        };
        assert_eq!(read(&["a", "b"]), 2);
        assert_eq!(read(&[]), 2, "a text with a mistake");
        assert_eq!(read(&["a"]), 2);
        assert_eq!(read(&["a", "b"]), 3);
    }
}
