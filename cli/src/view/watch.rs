//! The thread that reads the scene: once at the start, and again whenever a file that it was read from has changed.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant, SystemTime};

#[cfg(feature = "physics")]
use kinora_animator::physics::Progress;
use notify::event::{AccessKind, AccessMode, ModifyKind};
use notify::{Event, EventKind, RecommendedWatcher, RecursiveMode, Watcher};

use super::folders::{concerns, folders};
use super::settle::Settle;
use super::stamp::{Contents, contents, dates};
use super::wish::{Desired, Wish, load};
use crate::session::Loaded;
use crate::terminal;

/// How often dates are looked at where the system tells of changes: a net below the net.
const SLOW_POLL: Duration = Duration::from_secs(1);
/// How often they are looked at where it does not.
const FAST_POLL: Duration = Duration::from_millis(200);
/// A file changed this shortly before it was read may have changed after it, too: clocks of file systems are coarse.
const DATE_STEP: Duration = Duration::from_millis(10);
/// A simulation that takes longer is shown while it goes on.
#[cfg(feature = "physics")]
const FIRST_PARTIAL: Duration = Duration::from_millis(300);
/// And so often.
#[cfg(feature = "physics")]
const NEXT_PARTIAL: Duration = Duration::from_millis(500);

/// A scene just read.
pub struct Load {
    /// What came of it; a clause where the file cannot be read at all.
    pub loaded: Result<Loaded, String>,
    /// When the change that caused it was first heard of; none for the first.
    pub since: Option<Instant>,
    /// From then until here; for the first, how long it took.
    pub took: Duration,
    /// What it was read with.
    pub path: PathBuf,
    /// Which reading it comes of.
    pub reading: u64,
    /// While bodies are still being moved: the steps that are done, and of how many.
    pub baking: Option<[u64; 2]>,
}

/// What the thread hears.
pub enum Heard {
    /// Of the system: files.
    Disk(notify::Result<Event>),
    /// Of the window: there is another wish.
    Wish,
}

/// What to read, and how to hear of changes.
pub struct Watch {
    /// The scene, and what is changed in it.
    pub wish: Arc<Wish>,
    /// Look at dates instead of asking the system.
    pub poll: bool,
}

impl Watch {
    /// Reads and waits, until `deliver` says that nobody listens any more.
    pub fn run(self, deliver: impl Fn(Load) -> bool) {
        let (sender, events) = channel();
        self.wish.listen(sender.clone());
        let mut watcher = if self.poll { None } else { watcher(sender.clone()) };
        let _keeps_the_channel_open: Sender<_> = sender;
        let every = if watcher.is_some() { SLOW_POLL } else { FAST_POLL };

        let mut known = Contents::new();
        let mut change: Option<Instant> = None;
        let mut bake = None;
        let (mut files, mut of): (Vec<PathBuf>, Option<PathBuf>) = Default::default();
        let mut reading = 0;
        loop {
            let (Desired { path, changes, live }, wish) = self.wish.get();
            let asked = || self.wish.number() != wish;
            let Some(path) = path else {
                // Nothing is watched before there is a scene.
                match events.recv() {
                    Ok(_) => continue,
                    Err(_) => return,
                }
            };
            if of.as_ref() != Some(&path) {
                // Before there is a list, and where there is none: the scene itself.
                files = vec![std::path::absolute(&path).unwrap_or_else(|_| path.clone())];
                of = Some(path.clone());
            }
            reading += 1;
            let start = Instant::now();
            let date = SystemTime::now() - DATE_STEP;
            let (mut loaded, live) = load(&path, &changes, &live);
            self.wish.settle(&live, wish);
            let whole = |loaded, took| Load { loaded, since: change, took, path: path.clone(), reading, baking: None };
            if let Ok(loaded) = &mut loaded {
                files.clone_from(&loaded.dependencies);
                bake.clone_from(&loaded.bake);
                #[cfg(feature = "physics")]
                {
                    let shown = Shown::new(loaded);
                    let stale = stale(&files);
                    let told = |progress: &Progress<'_>| {
                        if let Some((partial, baking)) = shown.partial(progress) {
                            deliver(Load { baking: Some(baking), since: None, ..whole(Ok(partial), Duration::ZERO) });
                        }
                    };
                    if !loaded.bake_to_show(&|| asked() || stale(), &told) {
                        change = Some(Instant::now());
                        continue;
                    }
                }
            }
            if !deliver(whole(loaded, change.unwrap_or(start).elapsed())) {
                return;
            }
            rewatch(&mut watcher, &files);
            let mut seen = dates(&files);
            learn(&mut known, &files, date, bake.as_deref());
            change = loop {
                let Some(changed) = wait(&events, &files, &mut seen, every, &asked) else {
                    break Some(Instant::now());
                };
                rewatch(&mut watcher, &files);
                let now = contents(&files, &known);
                if now != known {
                    known = now;
                    break Some(changed);
                }
            };
        }
    }
}

/// What is shown of a simulation while it goes on.
#[cfg(feature = "physics")]
struct Shown {
    loaded: Loaded,
    next: std::cell::Cell<Instant>,
}

#[cfg(feature = "physics")]
impl Shown {
    /// Nothing is shown of what does not take long.
    fn new(loaded: &Loaded) -> Shown {
        Shown { loaded: loaded.clone(), next: std::cell::Cell::new(Instant::now() + FIRST_PARTIAL) }
    }

    /// The scene with where its bodies are as far as it is known, if it is time; and how many steps of how many that is.
    fn partial(&self, progress: &Progress<'_>) -> Option<(Loaded, [u64; 2])> {
        if Instant::now() < self.next.get() {
            return None;
        }
        let mut loaded = self.loaded.clone();
        Arc::make_mut(loaded.scene.as_mut()?).physics.baked = Some(Arc::new((progress.baked)()));
        self.next.set(Instant::now() + NEXT_PARTIAL);
        Some((loaded, [progress.step, progress.steps]))
    }
}

/// Whether one of the files changes from now on; looked for a few times a second.
#[cfg(feature = "physics")]
fn stale(files: &[PathBuf]) -> impl Fn() -> bool {
    let (seen, looked) = (dates(files), std::cell::Cell::new(Instant::now()));
    move || {
        if looked.get().elapsed() < FAST_POLL {
            return false;
        }
        looked.set(Instant::now());
        dates(files) != seen
    }
}

/// Adds the files that were not known before the scene was read. What may have changed since `date`, the start of the
/// reading, stays unknown, and so counts as changed; but for `bake`, which is written while the scene is read.
fn learn(known: &mut Contents, files: &[PathBuf], date: SystemTime, bake: Option<&Path>) {
    let fresh = |path: &PathBuf| {
        let changed = std::fs::metadata(path).and_then(|data| data.modified());
        Some(&**path) != bake && changed.is_ok_and(|modified| modified >= date)
    };
    known.retain(|path, _| files.contains(path) && Some(&**path) != bake);
    let new: Vec<PathBuf> = files.iter().filter(|path| !known.contains_key(*path)).cloned().collect();
    for (path, hash) in contents(&new, &new.iter().map(|path| (path.clone(), Default::default())).collect()) {
        if !fresh(&path) {
            known.insert(path, hash);
        }
    }
}

fn watcher(sender: Sender<Heard>) -> Option<RecommendedWatcher> {
    let cannot = |error| terminal::err(&format!("cannot watch files ({error}): looking at their dates instead\n"));
    let hear = move |event| drop(sender.send(Heard::Disk(event)));
    notify::recommended_watcher(hear).map_err(cannot).ok()
}

/// Begins anew each time: a folder that was removed and made again has lost its watch.
fn rewatch(watcher: &mut Option<RecommendedWatcher>, files: &[PathBuf]) {
    let Some(watcher) = watcher else { return };
    for folder in folders(files) {
        // What cannot be watched is found by its date.
        let _ = watcher.unwatch(&folder);
        let _ = watcher.watch(&folder, RecursiveMode::NonRecursive);
    }
}

/// Waits for a burst of changes to end; gives when it began. `None` as soon as something else is `asked` for.
fn wait(
    events: &Receiver<Heard>,
    files: &[PathBuf],
    seen: &mut Vec<Option<(SystemTime, u64)>>,
    every: Duration,
    asked: &dyn Fn() -> bool,
) -> Option<Instant> {
    let start = Instant::now();
    let mut burst: Option<Settle> = None;
    loop {
        let timeout = burst.map_or(every, |settle| settle.due().saturating_sub(start.elapsed()));
        if asked() {
            return None;
        }
        let happened = match events.recv_timeout(timeout) {
            Ok(Heard::Disk(event)) => event.map_or(true, |event| matters(&event, files)),
            Ok(Heard::Wish) => continue,
            Err(RecvTimeoutError::Disconnected) => false,
            Err(RecvTimeoutError::Timeout) => false,
        };
        if happened {
            let now = start.elapsed();
            burst.get_or_insert(Settle::begin(now)).event(now);
        }
        if let Some(settle) = burst {
            if settle.due() <= start.elapsed() {
                *seen = dates(files);
                return Some(start + settle.begun());
            }
        } else if !happened {
            let now = dates(files);
            if now != *seen {
                *seen = now;
                burst = Some(Settle::begin(start.elapsed()));
            }
        }
    }
}

/// Whether an event may mean that a file has other contents.
fn matters(event: &Event, files: &[PathBuf]) -> bool {
    let kind = match event.kind {
        EventKind::Access(AccessKind::Close(AccessMode::Write)) => true,
        EventKind::Access(_) | EventKind::Modify(ModifyKind::Metadata(_)) => false,
        _ => true,
    };
    // An event without a path says that some were lost.
    kind && (event.paths.is_empty() || event.paths.iter().any(|path| concerns(path, files)))
}

#[cfg(test)]
mod tests {
    use notify::event::{CreateKind, DataChange, MetadataKind, RemoveKind, RenameMode};

    use super::*;

    #[test]
    fn reading_a_file_is_no_change_of_it() {
        let files = [PathBuf::from("/project/a.kin")];
        for (kind, expected) in [
            (EventKind::Access(AccessKind::Open(AccessMode::Any)), false),
            (EventKind::Access(AccessKind::Close(AccessMode::Read)), false),
            (EventKind::Access(AccessKind::Close(AccessMode::Write)), true),
            (EventKind::Modify(ModifyKind::Metadata(MetadataKind::Any)), false),
            (EventKind::Modify(ModifyKind::Data(DataChange::Any)), true),
            (EventKind::Modify(ModifyKind::Name(RenameMode::To)), true),
            (EventKind::Create(CreateKind::File), true),
            (EventKind::Remove(RemoveKind::File), true),
        ] {
            let event = |path: &str| Event::new(kind).add_path(PathBuf::from(path));
            assert_eq!(matters(&event("/project/a.kin"), &files), expected, "{kind:?}");
            assert!(!matters(&event("/project/b.kin"), &files), "{kind:?} elsewhere");
        }
    }
}
