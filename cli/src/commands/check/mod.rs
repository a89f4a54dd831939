//! `kinora check`: everything short of rendering.

mod fix;
mod flags;
mod output;

pub use fix::ROUNDS;

use std::collections::{HashMap, HashSet};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use kinora_lang::diagnostic::{Applicability, Diagnostic, sort};
use kinora_lang::source::{FileId, Source};
use kinora_scene::Shutter;

use crate::exit::{self, Outcome};
use crate::flags::{FileFlags, LevelFlags, ValueFlags};
use crate::session::{self, Changes, Loaded};
use crate::{report, terminal};
use flags::{Fix, Format, Frames};

/// Frames of all nodes together that are looked at unless the user says otherwise: about a tenth of a second.
const NODES_SAMPLED: usize = 100_000;

/// Find mistakes in scenes: everything short of rendering.
///
/// Example: kinora check examples --deny warnings
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    files: FileFlags,
    /// How findings are written; KINORA_FORMAT says it too [default: full]
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Write findings to a file
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    levels: LevelFlags,
    /// Put right what can be: what is safe, or with --fix=maybe also what is likely
    #[arg(long, value_enum, value_name = "WHICH", num_args = 0..=1, require_equals = true, default_missing_value = "safe")]
    fix: Option<Fix>,
    #[command(flatten)]
    values: ValueFlags,
    /// Leave meshes, models and pictures unopened
    #[arg(long)]
    no_assets: bool,
    /// Which frames are looked at: all, the ends, or N from end to end [default: as many as take no time]
    #[arg(long, value_name = "all|ends|N", value_parser = Frames::parse)]
    frames: Option<Frames>,
    /// How many findings are written [default: 50, and all for programs]
    #[arg(long, value_name = "N")]
    max_diagnostics: Option<usize>,
    /// Say how often each code occurs
    #[arg(long)]
    statistics: bool,
    /// Leave out the last line
    #[arg(long)]
    quiet: bool,
    /// What a scene from standard input is called, and where its files are looked for
    #[arg(long, value_name = "PATH", default_value = "stdin.kin", hide_default_value = true)]
    stdin_path: PathBuf,
}

pub fn run(args: &Args) -> Outcome {
    let start = Instant::now();
    let formats = output::formats(args)?;
    let files = args.files.find()?;
    let changes = Changes { no_assets: args.no_assets, levels: args.levels.0.clone(), ..args.values.changes() };
    let fixed = match args.fix {
        Some(which) => fix::fix(&files, which.least(), |file| check(args, file, FileId::default(), &changes))?,
        None => 0,
    };
    let (mut checked, mut sources) = (Vec::new(), output::Names::default());
    for file in &files {
        let one = check(args, file, FileId(sources.len() as u32), &changes)?;
        sources.add(&one.loaded);
        checked.push(one);
    }
    let mut found = merge(&checked);
    // The process ends soon: to take large scenes apart would be for nothing.
    std::mem::forget(checked);
    sort(&mut found);
    let counts = Counts::of(&found, fixed);
    let (count, ms) = (files.len(), start.elapsed().as_millis());
    let last_line = format!("checked {count} file{} in {ms} ms: {counts}", if count == 1 { "" } else { "s" });
    output::write(args, &formats, &files, &found, &sources, &last_line)?;
    if args.statistics {
        terminal::err(&output::statistics(&found));
    }
    if !args.quiet {
        terminal::err(&(last_line + "\n"));
    }
    Ok(if counts.errors > 0 { exit::FINDINGS } else { exit::CLEAN })
}

/// A file that was checked.
struct Checked {
    loaded: Loaded,
    /// As they are to be taken.
    found: Vec<Diagnostic>,
}

fn check(args: &Args, file: &Path, id: FileId, changes: &Changes) -> Result<Checked, String> {
    let loaded = match file == Path::new("-") {
        false => session::load_as(id, file, changes)?,
        true => {
            let mut bytes = Vec::new();
            let read = std::io::stdin().read_to_end(&mut bytes);
            read.map_err(|error| format!("cannot read standard input: {error}"))?;
            session::load_bytes(id, &args.stdin_path, &bytes, changes)?
        }
    };
    let found = findings(&loaded, args.frames, args.no_assets);
    Ok(Checked { loaded, found })
}

/// Everything that is found in a scene, as it is to be taken.
pub fn findings(loaded: &Loaded, frames: Option<Frames>, no_assets: bool) -> Vec<Diagnostic> {
    let found = loaded.diagnostics.iter().cloned().chain(in_time(loaded, frames));
    #[cfg(feature = "physics")]
    let found = found.chain(if no_assets { Vec::new() } else { loaded.bodies_at_start() });
    // Warnings that only assets give are not found without them.
    let found = found.filter(|found| !(no_assets && found.code == "W0903"));
    found.filter_map(|found| loaded.levels.apply(found)).collect()
}

/// The findings of all files, each once: what several scenes import is checked with the first of them, and a file
/// without a camera that a scene here imports is no scene of its own.
fn merge(checked: &[Checked]) -> Vec<Diagnostic> {
    let sources: Vec<Vec<Source>> = checked.iter().map(|file| file.loaded.sources_as_given()).collect();
    let imported: HashSet<Arc<str>> =
        sources.iter().flat_map(|sources| sources.iter().skip(1)).map(|source| source.name.clone()).collect();
    let mut scenes: Vec<(&Checked, &Vec<Source>)> = checked.iter().zip(&sources).collect();
    scenes.retain(|(file, sources)| {
        file.loaded.has_camera() || !sources.first().is_some_and(|source| imported.contains(&source.name))
    });
    let mut times_read: HashMap<&str, usize> = HashMap::new();
    for source in scenes.iter().flat_map(|(_, sources)| *sources) {
        *times_read.entry(&source.name).or_default() += 1;
    }
    let mut times_found = HashMap::new();
    let mut merged: Vec<Diagnostic> = Vec::new();
    for (file, sources) in &scenes {
        let name = |id: FileId| sources.iter().find(|source| source.id == id).map(|source| source.name.clone());
        for found in &file.found {
            let Some(place) = found.place().and_then(|(id, span)| Some((name(id)?, span))) else {
                merged.push(found.clone());
                continue;
            };
            let times: &mut usize = times_found.entry((place.clone(), found.code, found.message.clone())).or_default();
            *times += 1;
            // What one scene needs an allowance for, another need not have.
            let enough = match found.code {
                "W0903" => *times == times_read.get(&*place.0).copied().unwrap_or(1),
                _ => *times == 1,
            };
            if enough {
                merged.push(found.clone());
            }
        }
    }
    merged
}

/// The first frame, of those looked at, in which something is wrong.
fn in_time(loaded: &Loaded, frames: Option<Frames>) -> Option<Diagnostic> {
    // A file that shows nothing is there for others to import.
    let scene = loaded.scene.as_ref().filter(|scene| !scene.cameras.is_empty())?;
    let all = scene.clock.frame_count();
    let wanted = match frames {
        Some(Frames::All) => all,
        Some(Frames::Ends) => 2,
        Some(Frames::Evenly(count)) => i64::try_from(count).unwrap_or(all),
        None => (NODES_SAMPLED / scene.nodes.len().max(1)).max(2) as i64,
    };
    let count = wanted.min(all);
    (0..count).find_map(|at| {
        let frame = (i128::from(at) * i128::from(all - 1) / i128::from((count - 1).max(1))) as i64;
        let Shutter { open_s, close_s } = scene.clock.shutter_of(frame);
        // A picture of all that the shutter sees is many worlds; the first, the middle and the last of them tell enough.
        let mut instants = vec![open_s, (open_s + close_s) / 2.0, close_s];
        instants.dedup();
        instants.into_iter().find_map(|time| {
            let found = loaded.sample(Shutter { open_s: time, close_s: time }).err();
            found.map(|found| *found)
        })
    })
}

/// How much was found.
struct Counts {
    errors: usize,
    warnings: usize,
    safe: usize,
    maybe: usize,
    fixed: usize,
}

impl Counts {
    fn of(found: &[Diagnostic], fixed: usize) -> Counts {
        let errors = found.iter().filter(|found| found.is_error()).count();
        let best = |found: &Diagnostic| found.fixes.iter().map(|fix| fix.applicability).min();
        let fixable = |by| found.iter().filter(|found| best(found) == Some(by)).count();
        let (safe, maybe) = (fixable(Applicability::Safe), fixable(Applicability::Maybe));
        Counts { errors, warnings: found.len() - errors, safe, maybe, fixed }
    }
}

impl std::fmt::Display for Counts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&report::counts(self.errors, self.warnings))?;
        for (count, what) in
            [(self.safe, "fixable with --fix"), (self.maybe, "with --fix=maybe"), (self.fixed, "fixed")]
        {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        Ok(())
    }
}
