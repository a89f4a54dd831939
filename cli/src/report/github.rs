//! Workflow commands of GitHub's actions: annotations beside the lines of a pull request, and the summary of the step.
//!
//! A command that is not written exactly so is dropped without a word, and so are all but the first ten errors and ten
//! warnings of a step: errors come first.

use std::io::Write;
use std::path::Path;

use kinora_lang::diagnostic::Diagnostic;

use super::Report;

/// Most rows of a summary, which may have 1 MiB.
const MOST_ROWS: usize = 500;

/// A command a finding, errors first.
pub fn github(report: &Report<'_>) -> String {
    errors_first(report).into_iter().map(|found| command(report, found) + "\n").collect()
}

/// Whether a workflow of GitHub runs this.
pub fn on_github() -> bool {
    std::env::var("GITHUB_ACTIONS").as_deref() == Ok("true")
}

/// Each finding for [`summarise`]: what it is, where, and what is said of it.
pub fn summary(report: &Report<'_>) -> Vec<[String; 3]> {
    let row = |found: &Diagnostic| {
        let place = match report.start(found) {
            Some((name, at)) => format!("{name}:{}:{}", at.line, at.column),
            None => report.file_of(found).to_string(),
        };
        [format!("{}[{}]", found.severity.name(), found.code), place, found.message.clone()]
    };
    errors_first(report).into_iter().map(row).collect()
}

/// Adds to what the page of the step shows, where there is one: a line, and a table of what is wrong.
///
/// # Errors
/// The file of the summary cannot be written.
pub fn summarise(last_line: &str, rows: &[[String; 3]]) -> Result<(), String> {
    let Some(path) = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty()) else { return Ok(()) };
    let mut text = format!("### kinora\n\n{last_line}\n");
    if !rows.is_empty() {
        text += "\n| | place | |\n|---|---|---|\n";
    }
    for row in rows.iter().take(MOST_ROWS) {
        let row = row.each_ref().map(|cell| cell.replace('|', "\\|"));
        text += &format!("| {} |\n", row.join(" | "));
    }
    if rows.len() > MOST_ROWS {
        text += &format!("\nand {} more\n", rows.len() - MOST_ROWS);
    }
    let file = std::fs::OpenOptions::new().append(true).create(true).open(&path);
    file.and_then(|mut file| file.write_all(text.as_bytes()))
        .map_err(|error| format!("cannot write `{}`: {error}", Path::new(&path).display()))
}

fn errors_first<'a>(report: &Report<'a>) -> Vec<&'a Diagnostic> {
    let mut found: Vec<&Diagnostic> = report.found.iter().collect();
    found.sort_by_key(|found| !found.is_error());
    found
}

fn command(report: &Report<'_>, found: &Diagnostic) -> String {
    let mut place = String::new();
    if let Some((source, span)) = found.place().and_then(|(file, span)| Some((report.source(file)?, span))) {
        let (start, end) = (source.position(span.start), source.position(span.end));
        // Columns of several lines would be dropped, and the command with them.
        place = match start.line == end.line {
            true => format!(",line={},col={},endLine={},endColumn={}", start.line, start.column, end.line, end.column),
            false => format!(",line={},endLine={}", start.line, end.line),
        };
    }
    let title = format!("kinora ({})", found.code);
    annotation(found.severity.name(), &title, report.file_of(found), &place, &found.message)
}

/// A command: `place` is empty, or begins with `,line=`.
pub fn annotation(level: &str, title: &str, file: &str, place: &str, message: &str) -> String {
    format!("::{level} title={},file={}{place}::{}", property(title), property(file), data(message))
}

fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinora_lang::source::{FileId, Source, Span};

    fn check(found: Diagnostic, expected: &str) {
        let sources = [Source::new(FileId(0), "a,b:c%.kin", "ab\ncd\n")];
        let report = Report { files: &["a.kin".to_string()], found: &[found], sources: &sources };
        assert_eq!(github(&report), format!("{expected}\n"));
    }

    #[test]
    fn commands_are_escaped() {
        let file = "title=kinora (E0201),file=a%2Cb%3Ac%25.kin";
        check(
            Diagnostic::new("E0201", "50% of\r\na, b: c").primary(FileId(0), Span::new(3, 4), ""),
            &format!("::error {file},line=2,col=1,endLine=2,endColumn=2::50%25 of%0D%0Aa, b: c"),
        );
        check(
            Diagnostic::new("E0201", "m").primary(FileId(0), Span::new(1, 4), ""),
            &format!("::error {file},line=1,endLine=2::m"),
        );
        check(Diagnostic::new("W0402", "m"), "::warning title=kinora (W0402),file=a.kin::m");
    }
}
