//! `kinora check`: everything short of rendering.

use std::collections::HashSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::ValueEnum;
use kinora_lang::diagnostic::{Diagnostic, MAX_SHOWN, list, to_json};
use kinora_lang::source::{FileId, Source};

use crate::exit::{self, Outcome};
use crate::session::{self, Changes, Loaded};
use crate::{paths, report, terminal};

/// The environment's say in the format.
const FORMAT: &str = "KINORA_FORMAT";

/// Find mistakes in scenes: everything short of rendering, the first and the last frame included.
///
/// Example: kinora check examples --deny warnings
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scenes, and folders to look for *.kin in; - reads a scene from standard input
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// How findings are written; KINORA_FORMAT says it too [default: full]
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// End with exit code 1 for these too
    #[arg(long, value_enum)]
    deny: Option<Deny>,
    /// What a scene from standard input is called, and where its files are looked for
    #[arg(long, value_name = "PATH", default_value = "stdin.kin", hide_default_value = true)]
    stdin_path: PathBuf,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// With the lines they are about, on stderr
    Full,
    /// path:line:col: error[E0201]: message, on stderr
    Short,
    /// An array of records, on stdout
    Json,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Deny {
    /// Every warning
    Warnings,
}

pub fn run(args: &Args) -> Outcome {
    let start = Instant::now();
    let format = match (args.format, std::env::var(FORMAT)) {
        (Some(format), _) => format,
        (None, Ok(name)) if !name.is_empty() => Format::from_str(&name, true)
            .map_err(|_| format!("{FORMAT} is `{name}`: full, short and json are known"))?,
        _ => Format::Full,
    };
    let files = paths::find(&args.paths)?;
    let (mut checked, mut sources) = (Vec::new(), Vec::new());
    for file in &files {
        let loaded = load(file, FileId(sources.len() as u32), &args.stdin_path)?;
        sources.extend(if matches!(format, Format::Json) { loaded.sources.clone() } else { loaded.sources_as_given() });
        let found = loaded.diagnostics.iter().cloned().chain(ends(&loaded)).collect();
        checked.push(Checked { sources: loaded.sources_as_given(), found, has_camera: loaded.has_camera() });
        // The process ends with the last one: to take a large scene apart would be for nothing.
        if checked.len() == files.len() {
            std::mem::forget(loaded);
        }
    }
    let found = merge(checked);
    let limit = if matches!(format, Format::Json) { usize::MAX } else { MAX_SHOWN };
    let listing = list(found, limit);
    match format {
        Format::Full => terminal::err(&report::full(&listing, &sources)),
        Format::Short => terminal::err(&report::short(&listing, &sources)),
        Format::Json => terminal::out(&to_json(&listing.shown, &sources))?,
    }
    let counts = report::counts(listing.errors, listing.warnings);
    let (count, ms) = (files.len(), start.elapsed().as_millis());
    terminal::err(&format!("checked {count} file{} in {ms} ms: {counts}\n", if count == 1 { "" } else { "s" }));
    let faulty = listing.errors > 0 || (args.deny.is_some() && listing.warnings > 0);
    Ok(if faulty { exit::FINDINGS } else { exit::CLEAN })
}

/// A file that was checked, under the names that the user gave.
struct Checked {
    sources: Vec<Source>,
    found: Vec<Diagnostic>,
    has_camera: bool,
}

/// The findings of all files, each once: what several scenes import is checked with the first of them, and a file
/// without a camera that a scene here imports is no scene of its own.
fn merge(checked: Vec<Checked>) -> Vec<Diagnostic> {
    let imported: HashSet<Arc<str>> =
        checked.iter().flat_map(|file| file.sources.iter().skip(1)).map(|source| source.name.clone()).collect();
    let is_part =
        |file: &Checked| !file.has_camera && file.sources.first().is_some_and(|source| imported.contains(&source.name));
    let mut seen = HashSet::new();
    let mut merged = Vec::new();
    for file in checked.iter().filter(|file| !is_part(file)) {
        let name = |id: FileId| file.sources.iter().find(|source| source.id == id).map(|source| source.name.clone());
        for found in &file.found {
            let place = found.place().and_then(|(id, span)| Some((name(id)?, span)));
            if place.is_none_or(|place| seen.insert((place, found.code, found.message.clone()))) {
                merged.push(found.clone());
            }
        }
    }
    merged
}

fn load(file: &Path, id: FileId, stdin_path: &Path) -> Result<Loaded, String> {
    if file != Path::new("-") {
        return session::load_as(id, file, &Changes::default());
    }
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).map_err(|error| format!("cannot read standard input: {error}"))?;
    session::load_bytes(id, stdin_path, &bytes, &Changes::default())
}

/// What is wrong in the first frame, else in the last.
fn ends(loaded: &Loaded) -> Option<Diagnostic> {
    // A file that shows nothing is there for others to import.
    let clock = loaded.scene.as_ref().filter(|scene| !scene.cameras.is_empty())?.clock;
    let last = clock.frame_count() - 1;
    std::iter::once(0)
        .chain((last > 0).then_some(last))
        .find_map(|frame| loaded.sample(clock.shutter_of(frame)).err())
        .map(|found| *found)
}
