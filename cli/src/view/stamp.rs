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

/// Hashes of files by path; none where a file cannot be read.
pub type Contents = BTreeMap<PathBuf, Option<u64>>;

/// Reads all of `paths`. A file that is empty or unreadable and was not so in `before` gets a while to become better:
/// some editors truncate a file and then write it, or remove it and then put another in its place.
pub fn contents(paths: &[PathBuf], before: &Contents) -> Contents {
    contents_within(WRITING, paths, before)
}

fn contents_within(patience: Duration, paths: &[PathBuf], before: &Contents) -> Contents {
    let patience = Instant::now() + patience;
    let read = |path: &PathBuf| loop {
        let (hash, empty) = hash(path);
        let expected = before.get(path).is_some_and(|old| *old == hash);
        if !empty || expected || Instant::now() >= patience {
            return (path.clone(), hash);
        }
        std::thread::sleep(RETRY);
    };
    paths.iter().map(read).collect()
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
        assert!(first[&paths[0]].is_some() && first[&paths[1]].is_none());
        std::fs::write(&paths[0], "one").unwrap();
        assert_eq!(contents(&paths, &first), first);
        std::fs::write(&paths[0], "two").unwrap();
        assert_ne!(contents(&paths, &first), first);
        std::fs::remove_dir_all(&folder).unwrap();
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
