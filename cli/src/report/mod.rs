//! Findings as text: with the lines they are about, one line each, or as other programs read them.

mod github;
mod gitlab;
mod junit;
mod sarif;

pub use github::{github, on_github, summarise, summary};
pub use gitlab::gitlab;
pub use junit::junit;
pub use sarif::sarif;
#[cfg(feature = "render")]
pub use {
    github::annotation,
    junit::{Fault, Suite, TestCase, xml},
};

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use kinora_lang::diagnostic::{Diagnostic, Listing, Style, render, render_short};
use kinora_lang::source::{FileId, Position, Source};

/// Columns where nobody says how many there are.
const WIDTH: u16 = 100;

/// Findings with the lines they are about, in colour, and how many more there are.
pub fn full(listing: &Listing, sources: &[Source]) -> String {
    let width = terminal_size::terminal_size_of(std::io::stderr()).map_or(WIDTH, |(width, _)| width.0);
    let style = Style { color: true, width, ..Style::default() };
    let texts: Vec<String> = listing.shown.iter().map(|found| render(found, sources, style) + "\n").collect();
    texts.concat() + &more(listing)
}

/// One finding a line, as editors read it, and how many more there are.
pub fn short(listing: &Listing, sources: &[Source]) -> String {
    let lines: Vec<String> = listing.shown.iter().map(|found| render_short(found, sources) + "\n").collect();
    lines.concat() + &more(listing)
}

/// One finding without colours.
pub fn plain(found: &Diagnostic, sources: &[Source]) -> String {
    render(found, sources, Style::default())
}

/// A path as a server knows it that has the current folder: relative, with `/`.
pub fn from_here(name: &str) -> String {
    let path = Path::new(name);
    let here = std::env::current_dir().unwrap_or_default();
    let below = path.strip_prefix(&here).or_else(|_| match here.canonicalize() {
        Ok(real) => path.strip_prefix(real).or(Ok(path)),
        Err(_) => Ok::<&Path, std::path::StripPrefixError>(path),
    });
    let parts: PathBuf = below.unwrap_or(path).components().collect();
    let name = parts.to_string_lossy().replace('\\', "/");
    name.strip_prefix("./").map_or(name.clone(), str::to_string)
}

/// What was found in some files, for other programs.
pub struct Report<'a> {
    /// The files that were checked.
    pub files: &'a [String],
    /// What was found, in order.
    pub found: &'a [Diagnostic],
    /// The texts, by names that other programs can find.
    pub sources: &'a [Source],
}

impl<'a> Report<'a> {
    /// A text.
    pub fn source(&self, file: FileId) -> Option<&'a Source> {
        self.sources.iter().find(|source| source.id == file)
    }

    /// The name of a text.
    pub fn name(&self, file: FileId) -> &'a str {
        self.source(file).map_or("", |source| &source.name)
    }

    /// Where a finding begins.
    pub fn start(&self, found: &Diagnostic) -> Option<(&'a str, Position)> {
        let (file, span) = found.place()?;
        let source = self.source(file)?;
        Some((&source.name, source.position(span.start)))
    }

    /// The file of a finding: without a place, the first one.
    pub fn file_of(&self, found: &Diagnostic) -> &'a str {
        let file = found.place().and_then(|(file, _)| self.source(file)).map(|source| &*source.name);
        file.or(self.files.first().map(String::as_str)).unwrap_or_default()
    }

    /// The first and the last line of a finding, from 1.
    pub fn lines(&self, found: &Diagnostic) -> (u32, u32) {
        let place = found.place().and_then(|(file, span)| Some((self.source(file)?, span)));
        place.map_or((1, 1), |(source, span)| (source.position(span.start).line, source.position(span.end).line))
    }
}

/// Of each finding, in order, what stays the same when lines above it come or go: a hash of its file, code, message and
/// line (FNV-1a, 64 bits), and which of several such it is.
fn fingerprints(report: &Report<'_>) -> Vec<String> {
    let mut times: HashMap<String, usize> = HashMap::new();
    let one = |found: &Diagnostic| {
        let line = found.place().and_then(|(file, span)| Some((report.source(file)?, span)));
        let line = line.map_or("", |(source, span)| source.slice(source.line_span(source.line_index(span.start))));
        let key = [report.file_of(found), found.code, &found.message, line.trim()].join("\0");
        let hash = key.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        let times = times.entry(key).or_default();
        *times += 1;
        format!("{hash:016x}:{times}")
    };
    report.found.iter().map(one).collect()
}

fn pretty(value: &serde_json::Value) -> String {
    format!("{value:#}\n")
}

/// A fault of the program itself.
pub fn internal(what: &str) -> String {
    let found = Diagnostic::new("E1007", "this is a bug in the tool")
        .note(what)
        .help("report it with the scene, the command and what `kinora info` prints");
    render(&found, &[], Style { color: true, ..Style::default() })
}

fn more(listing: &Listing) -> String {
    match listing.hidden {
        0 => String::new(),
        hidden => format!("and {hidden} more\n"),
    }
}

/// "2 errors, 1 warning".
pub fn counts(errors: usize, warnings: usize) -> String {
    let count = |number: usize, what: &str| format!("{number} {what}{}", if number == 1 { "" } else { "s" });
    match (errors, warnings) {
        (0, 0) => "no mistakes".into(),
        (errors, 0) => count(errors, "error"),
        (0, warnings) => count(warnings, "warning"),
        (errors, warnings) => format!("{}, {}", count(errors, "error"), count(warnings, "warning")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_of_the_program_is_no_raw_panic() {
        let text = internal("index out of bounds, at main.rs:7");
        for piece in ["E1007", "this is a bug in the tool", "index out of bounds, at main.rs:7", "`kinora info`"] {
            assert!(text.contains(piece), "{text}");
        }
    }

    #[test]
    fn numbers_of_findings() {
        for (errors, warnings, expected) in
            [(0, 0, "no mistakes"), (1, 0, "1 error"), (0, 2, "2 warnings"), (3, 1, "3 errors, 1 warning")]
        {
            assert_eq!(counts(errors, warnings), expected);
        }
    }
}
