//! What the window wants to see: which scene, and what is changed in it. The thread that reads fulfils the newest wish.

use std::path::{Path, PathBuf};
use std::sync::mpsc::Sender;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::watch::Heard;
use crate::session::{self, Changes, Loaded};

/// A value that a parameter has by hand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Live {
    /// As `-D` names it.
    pub name: String,
    /// The type that it had then.
    pub ty: String,
    /// The value, as it is written in a scene.
    pub text: String,
}

/// A scene, and what is changed in it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Desired {
    /// The file; none before one is chosen.
    pub path: Option<PathBuf>,
    /// What the command line changes.
    pub changes: Changes,
    /// What is changed in the window, which comes after it.
    pub live: Vec<Live>,
}

impl Desired {
    /// All changes.
    pub fn all_changes(&self) -> Changes {
        with(&self.changes, &self.live)
    }
}

/// The newest wish.
#[derive(Default)]
pub struct Wish(Mutex<Inner>);

#[derive(Default)]
struct Inner {
    desired: Desired,
    number: u64,
    ear: Option<Sender<Heard>>,
}

impl Wish {
    /// The first one.
    pub fn new(desired: Desired) -> Wish {
        Wish(Mutex::new(Inner { desired, ..Inner::default() }))
    }

    /// Tells `ear` of every change from now on.
    pub fn listen(&self, ear: Sender<Heard>) {
        self.lock().ear = Some(ear);
    }

    /// What is wanted, and the number of that wish.
    pub fn get(&self) -> (Desired, u64) {
        let inner = self.lock();
        (inner.desired.clone(), inner.number)
    }

    /// The number of the newest wish.
    pub fn number(&self) -> u64 {
        self.lock().number
    }

    /// Wants something else, if it is something else.
    pub fn change(&self, change: impl FnOnce(&mut Desired)) {
        let mut inner = self.lock();
        let before = inner.desired.clone();
        change(&mut inner.desired);
        if inner.desired != before {
            inner.number += 1;
            // Nobody hears it only when the window closes.
            let _ = inner.ear.as_ref().map(|ear| ear.send(Heard::Wish));
        }
    }

    /// What the text no longer takes is no longer wished for, unless there is a newer wish.
    pub fn settle(&self, live: &[Live], number: u64) {
        let mut inner = self.lock();
        if inner.number == number {
            inner.desired.live = live.to_vec();
        }
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads the scene with the values that it takes; gives those, too. A value by hand holds as long as the text has the
/// parameter, with the same type and a range that it is in.
///
/// # Errors
/// As [`session::load`].
pub fn load(path: &Path, changes: &Changes, live: &[Live]) -> (Result<Loaded, String>, Vec<Live>) {
    let read = |live: &[Live]| session::load(path, &with(changes, live));
    let loaded = read(live);
    let Ok(found) = &loaded else { return (loaded, live.to_vec()) };
    let refused = found.scene.is_none() && found.diagnostics.iter().any(|found| is_refusal(found.code));
    let other_type = found.scene.is_some() && live.iter().any(|live| !fits(found, live));
    if live.is_empty() || !(refused || other_type) {
        return (loaded, live.to_vec());
    }
    let plain = read(&[]);
    let Ok(found) = &plain else { return (plain, live.to_vec()) };
    if found.scene.is_none() {
        // Something else is wrong, too: what is by hand is judged when it is mended.
        return (loaded, live.to_vec());
    }
    let mut kept: Vec<Live> = live.iter().filter(|live| fits(found, live)).cloned().collect();
    while !kept.is_empty() {
        let again = read(&kept);
        match &again {
            Ok(found) if found.diagnostics.iter().any(|found| is_refusal(found.code)) => {
                let of = |live: &Live, text: &str| {
                    text.contains(&format!("`{}`", live.name)) || text.contains(&format!("`-D {}=", live.name))
                };
                let told: Vec<&str> = found
                    .diagnostics
                    .iter()
                    .filter(|found| is_refusal(found.code))
                    .map(|found| &*found.message)
                    .collect();
                let before = kept.len();
                kept.retain(|live| !told.iter().any(|text| of(live, text)));
                if kept.len() == before {
                    kept.clear();
                }
            }
            _ => return (again, kept),
        }
    }
    (plain, kept)
}

/// Whether a finding says that a `-D` is not taken.
fn is_refusal(code: &str) -> bool {
    matches!(code, "E0413" | "E0414")
}

fn fits(loaded: &Loaded, live: &Live) -> bool {
    loaded.params.iter().any(|param| param.name == live.name && param.ty == live.ty)
}

fn with(changes: &Changes, live: &[Live]) -> Changes {
    let mut changes = changes.clone();
    changes.params.extend(live.iter().map(|live| (live.name.clone(), live.text.clone())));
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn live(name: &str, ty: &str, text: &str) -> Live {
        Live { name: name.into(), ty: ty.into(), text: text.into() }
    }

    #[test]
    fn values_hold_as_long_as_the_text_takes_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.kin");
        let rest = "\ncamera { position: (0, 0, 5), look_at: (0, 0, 0) }\nsky { color: #fff }\n";
        let by_hand = [live("a", "float", "0.5"), live("b", "length", "2m")];
        let both = "param a: float = 0.1 in 0..1\nparam b: length = 1m";
        for (params, kept, scene) in [
            (both, vec!["a", "b"], true),
            ("param a: float = 0.1 in 0..1", vec!["a"], true),
            ("param a: float = 0.1 in 0..0.2\nparam b: length = 1m", vec!["b"], true),
            ("param a: int = 1\nparam b: length = 1m", vec!["b"], true),
            ("param a: length = 1m\nparam b = 1m", vec!["b"], true),
            ("", vec![], true),
            // A mistake elsewhere is no reason to forget anything.
            ("param a: float = 0.1 in 0..1\nlet x = nothing", vec!["a", "b"], false),
        ] {
            std::fs::write(&path, format!("lang 1\n{params}{rest}")).unwrap();
            let (loaded, now) = load(&path, &Changes::default(), &by_hand);
            let names: Vec<&str> = now.iter().map(|live| &*live.name).collect();
            let loaded = loaded.unwrap();
            assert_eq!((names, loaded.scene.is_some()), (kept, scene), "{params}: {:?}", loaded.diagnostics);
        }
    }

    #[test]
    fn the_newest_wish_counts() {
        let (sender, heard) = std::sync::mpsc::channel();
        let wish = Wish::new(Desired::default());
        wish.listen(sender);
        wish.change(|_| ());
        assert!(heard.try_recv().is_err(), "the same is no wish");
        wish.change(|desired| desired.path = Some("a.kin".into()));
        assert!(matches!(heard.try_recv(), Ok(Heard::Wish)));
        assert_eq!(wish.number(), 1);
        wish.change(|desired| desired.live = vec![live("a", "int", "1")]);
        wish.settle(&[], 1);
        assert_eq!(wish.get().0.live.len(), 1, "an older answer");
        wish.settle(&[], 2);
        assert_eq!((wish.get().0.live.len(), wish.number()), (0, 2));
    }
}
