//! Where a scene's bodies are at all times: computed once, kept in the project, and put into the scene.

use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use kinora_animator::physics::{Bake, BakeError, Cache, Next, Progress, bake, overlaps};
use kinora_lang::diagnostic::{Diagnostic, Level};

use crate::exit;
use crate::session::Loaded;
use crate::terminal;
use crate::write;

/// What is done is kept this often at most, so that a kill costs no more.
const KEEP: Duration = Duration::from_secs(2);

/// And so seldom that it takes a part of the time no larger than one in this many.
const KEEP_SHARE: u32 = 20;

/// What is larger is no bake.
const MOST_BYTES: u64 = 5 << 30;

/// How a bake goes on.
pub struct Baking<'a> {
    /// Show no progress.
    pub quiet: bool,
    /// The exit code to end with, if the work is to stop.
    pub stop: &'a dyn Fn() -> Option<u8>,
    /// Hears of each step.
    pub told: &'a dyn Fn(&Progress<'_>),
}

/// What became of a bake.
pub struct Baked {
    /// What came of it.
    pub bake: Bake,
    /// Where it is kept.
    pub path: PathBuf,
    /// How long it took.
    pub time: Duration,
}

/// Why there is none.
pub enum End {
    /// The scene is at fault.
    Found(Box<Diagnostic>),
    /// It was stopped; the exit code.
    Stopped(u8),
}

impl End {
    /// Says so; gives the exit code.
    pub fn finish(self, loaded: &Loaded) -> u8 {
        match self {
            End::Found(found) => {
                loaded.report_one(&found);
                exit::FINDINGS
            }
            End::Stopped(code) => {
                terminal::err("stopped; the next bake goes on from here\n");
                code
            }
        }
    }
}

impl Loaded {
    /// Puts the bodies of its scene where they are at all times. Warnings are printed; `None` where there is nothing to
    /// compute.
    ///
    /// # Errors
    /// See [`End`].
    pub fn bake(&mut self, how: &Baking<'_>) -> Result<Option<Baked>, End> {
        let Some(scene) = self.scene.clone().filter(|scene| scene.physics.is_dynamic()) else { return Ok(None) };
        let start = Instant::now();
        let path = self.root().join(&scene.physics.simulation.bake);
        let mut cache = Folder { path: path.clone(), root: self.root().to_path_buf(), part: None };
        let bar = Bar::new(how.quiet);
        let stopped = Cell::new(None);
        let (mut kept, mut pause, mut keeping) = (Instant::now(), KEEP, None);
        let mut watch = |progress: Progress<'_>| {
            bar.at(&progress);
            (how.told)(&progress);
            if let Some(begun) = keeping.take() {
                let took: Duration = Instant::elapsed(&begun);
                (kept, pause) = (Instant::now(), KEEP.max(took * KEEP_SHARE));
            }
            stopped.set((how.stop)());
            if stopped.get().is_some() {
                return Next::Stop;
            }
            if kept.elapsed() >= pause {
                keeping = Some(Instant::now());
                return Next::Keep;
            }
            Next::Step
        };
        let found = bake(&scene, &mut cache, self.frozen_bake, &mut watch);
        bar.end();
        drop(scene);
        let bake = match found {
            Ok(Some(bake)) => bake,
            Ok(None) => return Ok(None),
            Err(BakeError::Stopped) => return Err(End::Stopped(stopped.get().unwrap_or(exit::FAILED))),
            Err(error) => return Err(End::Found(Box::new(self.bake_fault(&error)))),
        };
        self.warn(&bake, &path);
        if let Some(scene) = &mut self.scene {
            Arc::make_mut(scene).physics.baked = Some(bake.baked.clone());
        }
        Ok(Some(Baked { bake, path, time: start.elapsed() }))
    }

    /// As [`Loaded::bake`], for a window: a fault is one of the scene's findings. False if it was stopped, as `stale` says.
    /// `told` hears of each step.
    #[cfg(feature = "viewer")]
    pub fn bake_to_show(&mut self, stale: &dyn Fn() -> bool, told: &dyn Fn(&Progress<'_>)) -> bool {
        match self.bake(&Baking { quiet: true, stop: &|| stale().then_some(exit::STOPPED), told }) {
            Ok(_) => true,
            Err(End::Found(found)) => {
                self.scene = None;
                self.diagnostics.push(*found);
                true
            }
            Err(End::Stopped(_)) => false,
        }
    }

    /// What is wrong with its bodies at 0 s, as far as that is seen without a bake.
    pub fn bodies_at_start(&self) -> Vec<Diagnostic> {
        let Some(scene) = self.scene.as_ref().filter(|scene| scene.physics.is_dynamic()) else { return Vec::new() };
        match overlaps(scene) {
            Ok(overlaps) => self.overlapping(&overlaps),
            Err(error) => vec![self.bake_fault(&error)],
        }
    }

    /// W0907 for pairs of nodes: once for those that the text calls the same.
    fn overlapping(&self, overlaps: &[([usize; 2], f64)]) -> Vec<Diagnostic> {
        /// More of them would say nothing new.
        const MOST: usize = 8;
        let name = |node: usize| {
            let node = self.scene.as_ref().and_then(|scene| scene.nodes.get(node));
            node.map_or(String::new(), |node| node.name.clone())
        };
        let mut pairs: Vec<([String; 2], f64, usize)> = Vec::new();
        for (pair, depth) in overlaps {
            let names = pair.map(name);
            match pairs.iter().position(|(known, ..)| *known == names) {
                Some(at) => pairs[at] = (names, pairs[at].1.max(*depth), pairs[at].2 + 1),
                None if pairs.len() < MOST => pairs.push((names, *depth, 1)),
                None => {}
            }
        }
        let warning = |([a, b], depth, times): ([String; 2], f64, usize)| {
            let mm = (depth * 1e4).round() / 10.0;
            let found = Diagnostic::new("W0907", format!("bodies `{a}` and `{b}` overlap by {mm} mm at 0s"));
            let found = match (self.node_place(&a, ""), self.node_place(&b, "")) {
                (Some((file, span)), Some((other, at))) if (file, span) != (other, at) => {
                    found.primary(file, span, "is inside the other").label(other, at, "is the other")
                }
                (Some((file, span)), _) | (None, Some((file, span))) => {
                    found.primary(file, span, "is inside the other")
                }
                (None, None) => found,
            };
            let found = if times > 1 { found.note(format!("and {} more of them do", times - 1)) } else { found };
            found.help("move them apart: they are pushed out of one another in the first steps")
        };
        pairs.into_iter().map(warning).collect()
    }

    /// W0907 and W0908.
    fn warn(&self, bake: &Bake, path: &Path) {
        let shown = |code: &str| self.levels.level(code) != Level::Allow;
        if shown("W0907") {
            self.overlapping(&bake.overlaps).iter().for_each(|found| self.report_one(found));
        }
        if let Some(machine) = bake.other_machine.as_ref().filter(|_| shown("W0908")) {
            let found = Diagnostic::new("W0908", format!("bake was made on another kind of processor, {machine}"))
                .note(format!("it is used as it is: `{}`", path.display()))
                .help("remove the file for one that is made here");
            self.report_one(&found);
        }
    }
}

/// Bakes in the project's folder.
struct Folder {
    path: PathBuf,
    root: PathBuf,
    /// What is unfinished, held so that no other process writes to it.
    part: Option<File>,
}

impl Folder {
    /// The file beside it for what is unfinished.
    fn part_path(&self) -> PathBuf {
        let mut name = self.path.as_os_str().to_owned();
        name.push(".part");
        name.into()
    }

    /// Whether the file is in the project, wherever links lead.
    fn inside(&self) -> std::io::Result<()> {
        let folder = self.path.parent().unwrap_or(&self.root).canonicalize()?;
        let linked = self.path.canonicalize().map_or(true, |path| path.starts_with(&folder));
        match folder.starts_with(self.root.canonicalize()?) && linked {
            true => Ok(()),
            false => Err(std::io::Error::other("it is outside the project")),
        }
    }

    fn make(&self) -> std::io::Result<()> {
        if let Some(folder) = self.path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        self.inside()
    }

    /// Opens what is unfinished, if nobody else has it.
    fn open(&mut self) -> std::io::Result<&mut File> {
        let file = match self.part.take() {
            Some(file) => file,
            None => {
                let file =
                    OpenOptions::new().read(true).write(true).create(true).truncate(false).open(self.part_path())?;
                file.try_lock()?;
                file
            }
        };
        Ok(self.part.insert(file))
    }

    fn said(&self, error: &std::io::Error) -> String {
        format!("cannot write `{}`: {error}", self.path.display())
    }
}

impl Cache for Folder {
    fn read(&mut self) -> Option<Vec<u8>> {
        self.inside().ok()?;
        let file = File::open(&self.path).ok()?;
        let length = file.metadata().ok().filter(|data| data.is_file())?.len();
        let mut bytes = Vec::new();
        if length > MOST_BYTES || file.take(MOST_BYTES).read_to_end(&mut bytes).is_err() {
            return None;
        }
        Some(bytes)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.make().map_err(|error| self.said(&error))?;
        write::create_bytes(&self.path, bytes)?;
        if self.part.is_some() {
            // What is left behind is found to be of no use.
            let _ = std::fs::remove_file(self.part_path());
        }
        self.part = None;
        Ok(())
    }

    fn read_part(&mut self) -> Option<Vec<u8>> {
        if !self.part_path().is_file() || self.inside().is_err() {
            return None;
        }
        let mut bytes = Vec::new();
        self.open().ok()?.take(MOST_BYTES).read_to_end(&mut bytes).ok()?;
        Some(bytes)
    }

    fn write_part(&mut self, keep: usize, bytes: &[u8]) -> Result<(), String> {
        let mut put = || {
            self.make()?;
            let file = self.open()?;
            file.set_len(keep as u64)?;
            file.seek(SeekFrom::Start(keep as u64))?;
            file.write_all(bytes)
        };
        put().map_err(|error| self.said(&error))
    }
}

/// Steps done, where someone watches.
struct Bar(Option<ProgressBar>);

impl Bar {
    fn new(quiet: bool) -> Bar {
        if quiet || !terminal::watched() {
            return Bar(None);
        }
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr_with_hz(10));
        let style = ProgressStyle::with_template("bake    {bar:30} {pos}/{len} steps · {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━╸ "));
        Bar(Some(bar))
    }

    fn at(&self, progress: &Progress<'_>) {
        let Some(bar) = &self.0 else { return };
        if bar.length().is_none() {
            bar.set_length(progress.steps);
            // Of a bake that goes on, what was done before says nothing of the time that is left.
            bar.set_position(progress.step);
            bar.reset_eta();
        }
        bar.set_position(progress.step);
    }

    fn end(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
