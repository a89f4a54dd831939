//! What is in the files that a scene was read from, briefly.

use std::collections::BTreeMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::Hasher;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How long an empty or unreadable file may be one that is just being written.
const WRITING: Duration = Duration::from_millis(100);
const RETRY: Duration = Duration::from_millis(10);

/// What is in files, by path.
pub type Contents = BTreeMap<PathBuf, Content>;

/// What is in a file.
#[derive(Clone, Copy, Debug, Default)]
pub struct Content {
    /// Its hash; none where it cannot be read.
    hash: Option<u64>,
    /// The file's date when that was found, if a later change must show in the date.
    date: Option<Date>,
}

/// Two files with the same in them are the same, whatever their dates.
impl PartialEq for Content {
    fn eq(&self, other: &Content) -> bool {
        self.hash == other.hash
    }
}

/// Length, date of the last change, and which file it is.
type Date = (u64, SystemTime, u64);

/// Dates of files that were just written do not tell apart what is written next: clocks of file systems are coarse, some
/// count in two seconds.
const DATE_STEP: Duration = Duration::from_millis(2500);

/// Reads all of `paths`. A file that is empty or unreadable and was not so in `before` gets a while to become better:
/// some editors truncate a file and then write it, or remove it and then put another in its place.
pub fn contents(paths: &[PathBuf], before: &Contents) -> Contents {
    contents_within(WRITING, paths, before)
}

fn contents_within(patience: Duration, paths: &[PathBuf], before: &Contents) -> Contents {
    let patience = Instant::now() + patience;
    let read = |path: &PathBuf| loop {
        let (old, date) = (before.get(path), date(path));
        if let Some(old) = old.filter(|old| old.date.is_some() && old.date == date) {
            return (path.clone(), *old);
        }
        let (hash, empty) = hash(path);
        let expected = old.is_some_and(|old| old.hash == hash);
        if !empty || expected || Instant::now() >= patience {
            let settled = |date: &Date| SystemTime::now().duration_since(date.1).is_ok_and(|age| age > DATE_STEP);
            return (path.clone(), Content { hash, date: date.filter(settled) });
        }
        std::thread::sleep(RETRY);
    };
    paths.iter().map(read).collect()
}

fn date(path: &Path) -> Option<Date> {
    let data = std::fs::metadata(path).ok().filter(|data| data.is_file())?;
    #[cfg(unix)]
    let which = std::os::unix::fs::MetadataExt::ino(&data);
    #[cfg(not(unix))]
    let which = 0;
    Some((data.len(), data.modified().ok()?, which))
}

/// The hash of what is in a file, and whether that is nothing.
fn hash(path: &Path) -> (Option<u64>, bool) {
    // Asked before opening: opening a pipe would wait for its other end.
    if !std::fs::metadata(path).is_ok_and(|data| data.is_file()) {
        return (None, true);
    }
    let Ok(mut file) = std::fs::File::open(path) else { return (None, true) };
    let mut hasher = DefaultHasher::new();
    let (mut buffer, mut total) = (vec![0; 1 << 16], 0);
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return (Some(hasher.finish()), total == 0),
            Ok(count) => {
                total += count;
                hasher.write(&buffer[..count]);
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(_) => return (None, true),
        }
    }
}

/// When files were last changed and how long they are: what tells cheaply that a look at their contents is due.
pub fn dates(paths: &[PathBuf]) -> Vec<Option<(SystemTime, u64)>> {
    let date = |path: &PathBuf| {
        let data = std::fs::metadata(path).ok()?;
        Some((data.modified().ok()?, data.len()))
    };
    paths.iter().map(date).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contents_count_and_dates_do_not() {
        let folder = std::env::temp_dir().join(format!("kinora-stamp-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let paths = [folder.join("a"), folder.join("missing")];
        std::fs::write(&paths[0], "one").unwrap();
        let first = contents(&paths, &Contents::new());
        assert!(first[&paths[0]].hash.is_some() && first[&paths[1]].hash.is_none());
        std::fs::write(&paths[0], "one").unwrap();
        assert_eq!(contents(&paths, &first), first);
        std::fs::write(&paths[0], "two").unwrap();
        assert_ne!(contents(&paths, &first), first);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn what_was_not_touched_for_long_is_not_read_again() {
        let path = std::env::temp_dir().join(format!("kinora-untouched-{}", std::process::id()));
        let long_ago = SystemTime::now() - Duration::from_secs(100);
        let write = |text: &str| {
            std::fs::write(&path, text).unwrap();
            std::fs::File::options().append(true).open(&path).unwrap().set_modified(long_ago).unwrap();
        };
        let paths = [path.clone()];
        write("one");
        let first = contents(&paths, &Contents::new());
        assert!(first[&path].date.is_some());
        // Nobody writes so that it does not show: this is how it is seen that the file was not read.
        write("two");
        assert_eq!(contents(&paths, &first), first);
        std::fs::write(&path, "two").unwrap();
        let second = contents(&paths, &first);
        assert_ne!(second, first);
        assert!(second[&path].date.is_none(), "it may be written again with the same date");
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_file_just_truncated_is_waited_for() {
        let path = std::env::temp_dir().join(format!("kinora-truncated-{}", std::process::id()));
        std::fs::write(&path, "one").unwrap();
        let paths = [path.clone()];
        let first = contents(&paths, &Contents::new());
        std::fs::write(&path, "").unwrap();
        let writer = std::thread::spawn({
            let path = path.clone();
            move || std::fs::write(path, "one").unwrap()
        });
        assert_eq!(contents_within(Duration::from_secs(60), &paths, &first), first);
        writer.join().unwrap();
        std::fs::remove_file(&path).unwrap();
    }
}
