//! Where the findings go, and as what.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::ValueEnum;
use kinora_lang::diagnostic::{Diagnostic, MAX_SHOWN, codes, list, to_json, to_json_lines};
use kinora_lang::source::Source;

use super::{Args, Format};
use crate::report::{self, Report};
use crate::session::Loaded;
use crate::terminal;
use crate::write::create;

/// The environment's say in the format.
const FORMAT: &str = "KINORA_FORMAT";

/// The texts of all files, by each of their names.
#[derive(Default)]
pub struct Names {
    /// As the user named the scene.
    as_given: Vec<Source>,
    /// From the folder of its project.
    in_project: Vec<Source>,
    /// From the current folder.
    from_here: Vec<Source>,
}

impl Names {
    pub fn len(&self) -> usize {
        self.as_given.len()
    }

    pub fn add(&mut self, loaded: &Loaded) {
        let as_given = loaded.sources_as_given();
        self.in_project.extend(loaded.sources.iter().cloned());
        self.from_here.extend(as_given.iter().cloned().map(|mut source| {
            source.name = report::from_here(&source.name).into();
            source
        }));
        self.as_given.extend(as_given);
    }
}

/// The format, and on GitHub its annotations beside it where no format is asked for.
pub fn formats(args: &Args) -> Result<Vec<Format>, String> {
    let set = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    Ok(match (args.format, set(FORMAT)) {
        (Some(format), _) => vec![format],
        (None, Some(name)) => {
            let known = || Format::value_variants().iter().filter_map(|format| format.to_possible_value());
            let names: Vec<String> = known().map(|value| value.get_name().to_string()).collect();
            let names = names.join(", ");
            vec![Format::from_str(&name, true).map_err(|_| format!("{FORMAT} is `{name}`: known are {names}"))?]
        }
        (None, None) if report::on_github() => vec![Format::Full, Format::Github],
        (None, None) => vec![Format::Full],
    })
}

/// Writes the findings, which are in order; the first format into the file, if there is to be one.
pub fn write(
    args: &Args,
    formats: &[Format],
    files: &[PathBuf],
    found: &[Diagnostic],
    names: &Names,
    last_line: &str,
) -> Result<(), String> {
    let files: Vec<String> = files.iter().map(|file| report::from_here(&file.to_string_lossy())).collect();
    for (at, format) in formats.iter().enumerate() {
        let text = text(args, *format, &files, found, names);
        match (&args.output, format) {
            (Some(path), _) if at == 0 => create(path, &terminal::plain(&text))?,
            (_, Format::Full | Format::Short) => terminal::err(&text),
            _ => terminal::out(&text)?,
        }
    }
    if formats.contains(&Format::Github) {
        let report = Report { files: &files, found, sources: &names.from_here };
        report::summarise(last_line, &report::summary(&report))?;
    }
    Ok(())
}

fn text(args: &Args, format: Format, files: &[String], found: &[Diagnostic], names: &Names) -> String {
    let most = args.max_diagnostics.unwrap_or(match format {
        Format::Full | Format::Short => MAX_SHOWN,
        _ => usize::MAX,
    });
    let listing = list(found.to_vec(), most);
    let report = Report { files, found: &listing.shown, sources: &names.from_here };
    match format {
        Format::Full => report::full(&listing, &names.as_given),
        Format::Short => report::short(&listing, &names.as_given),
        Format::Json => to_json(&listing.shown, &names.in_project, &names.from_here),
        Format::Jsonl => to_json_lines(&listing.shown, &names.in_project, &names.from_here),
        Format::Sarif => report::sarif(&report),
        Format::Github => report::github(&report),
        Format::Gitlab => report::gitlab(&report),
        Format::Junit => report::junit(&report),
    }
}

/// How often each code occurs, the most frequent first.
pub fn statistics(found: &[Diagnostic]) -> String {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for found in found {
        *counts.entry(found.code).or_default() += 1;
    }
    let mut counts: Vec<(&str, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let title = |code| codes::find(code).map_or("", |row| row.title);
    counts.into_iter().map(|(code, count)| format!("{count:6}  {code}  {}\n", title(code))).collect()
}
