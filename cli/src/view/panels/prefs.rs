//! What the viewer remembers from one time to the next: a small file in the user's folder of settings.

use std::ffi::OsString;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::Tab;
use crate::view::timeline::Speed;
use crate::write;

/// A file that is larger is none of ours.
const MOST_BYTES: u64 = 1 << 16;
/// Sides of a window, in points.
const SIDES: std::ops::RangeInclusive<f32> = 200.0..=16384.0;

/// What is remembered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Prefs {
    /// Width and height of the window, in points.
    pub size: [f32; 2],
    /// Whether the panel at the side is there: `None` leaves it to the scene, which has parameters or not.
    pub side: Option<bool>,
    /// What it shows.
    pub tab: Option<Tab>,
    /// Its width in points.
    pub side_width: f32,
    /// Whether curves are shown over the timeline.
    pub curves: bool,
    /// Dark or light.
    pub theme: Theme,
    /// How it plays.
    pub speed: Speed,
    /// Whether it plays again from the end.
    pub looping: bool,
    /// The command of the editor; empty: `$VISUAL`, or VS Code.
    pub editor: String,
}

/// Dark or light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Theme {
    /// Light on dark.
    #[default]
    Dark,
    /// Dark on light.
    Light,
    /// As the system has it.
    System,
}

impl Default for Prefs {
    fn default() -> Self {
        Self {
            size: [1120.0, 760.0],
            side: None,
            tab: None,
            side_width: 290.0,
            curves: false,
            theme: Theme::Dark,
            speed: Speed::RealTime,
            looping: true,
            editor: String::new(),
        }
    }
}

impl Prefs {
    /// What was remembered. A file that is not there or damaged is no mistake: then all is as it is at first.
    pub fn load() -> Prefs {
        let text = file().and_then(|path| {
            let small = std::fs::metadata(&path).ok()?.len() <= MOST_BYTES;
            small.then(|| std::fs::read_to_string(path).ok()).flatten()
        });
        text.map_or_else(Prefs::default, |text| Prefs::read(&text))
    }

    fn read(text: &str) -> Prefs {
        let mut prefs: Prefs = ron::from_str(text).unwrap_or_default();
        let usual = Prefs::default();
        if !prefs.size.iter().all(|side| SIDES.contains(side)) {
            prefs.size = usual.size;
        }
        if !(150.0..=2000.0).contains(&prefs.side_width) {
            prefs.side_width = usual.side_width;
        }
        prefs
    }

    /// Remembers it. Where that cannot be done nothing is lost but convenience.
    pub fn save(&self) {
        let Some(path) = file() else { return };
        let Ok(text) = ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new()) else { return };
        let folder = path.parent().map(std::fs::create_dir_all);
        if folder.is_some_and(|made| made.is_ok()) {
            let _ = write::create_bytes(&path, (text + "\n").as_bytes());
        }
    }
}

/// Where it is kept.
fn file() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    folder(cfg!(windows), &set).map(|folder| folder.join("kinora").join("viewer.ron"))
}

/// The user's folder of settings: `$XDG_CONFIG_HOME` where it is an absolute path, as the XDG base directory specification
/// has it, else `~/.config`; on Windows `%APPDATA%`.
fn folder(windows: bool, set: &dyn Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let absolute = |path: PathBuf| path.is_absolute().then_some(path);
    let xdg = set("XDG_CONFIG_HOME").map(PathBuf::from).and_then(absolute);
    xdg.or_else(|| match windows {
        true => set("APPDATA").map(PathBuf::from),
        false => set("HOME").map(|home| PathBuf::from(home).join(".config")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damage_is_no_mistake() {
        let usual = Prefs::default();
        for (text, expected) in [
            ("", usual.clone()),
            ("(", usual.clone()),
            ("\0\u{ffff}", usual.clone()),
            ("()", usual.clone()),
            ("(size: (1e9, -3.0))", usual.clone()),
            ("(side_width: 0.0)", usual.clone()),
            ("(theme: Light)", Prefs { theme: Theme::Light, ..usual.clone() }),
            (
                "(size: (800.0, 600.0), side: Some(false))",
                Prefs { size: [800.0, 600.0], side: Some(false), ..usual.clone() },
            ),
            // From another version.
            ("(theme: Light, unknown: 3)", usual.clone()),
        ] {
            let got = Prefs::read(text);
            let lenient = Prefs { theme: Theme::Light, ..usual.clone() };
            assert!(got == expected || (text.contains("unknown") && got == lenient), "{text}: {got:?}");
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let prefs =
            Prefs { tab: Some(Tab::Render), editor: "ed \"x\"".into(), speed: Speed::EveryFrame, ..Prefs::default() };
        let text = ron::ser::to_string_pretty(&prefs, ron::ser::PrettyConfig::new()).unwrap();
        assert_eq!(Prefs::read(&text), prefs);
    }

    #[cfg(unix)]
    #[test]
    fn the_folder_is_the_one_of_xdg() {
        let env = |pairs: &'static [(&str, &str)]| {
            move |name: &str| pairs.iter().find(|(key, _)| *key == name).map(|(_, value)| OsString::from(value))
        };
        for (pairs, expected) in [
            (&[("XDG_CONFIG_HOME", "/x"), ("HOME", "/home/a")][..], Some("/x")),
            (&[("HOME", "/home/a")], Some("/home/a/.config")),
            (&[("XDG_CONFIG_HOME", "relative"), ("HOME", "/home/a")], Some("/home/a/.config")),
            (&[], None),
        ] {
            assert_eq!(folder(false, &env(pairs)), expected.map(PathBuf::from));
        }
    }
}
