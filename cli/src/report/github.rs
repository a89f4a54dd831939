//! Workflow commands of GitHub's actions: annotations beside the lines of a pull request, and the summary of the step.
//!
//! A command that is not written exactly so is dropped without a word, and so are all but the first ten errors and ten
//! warnings of a step: errors come first.

use kinora_lang::diagnostic::Diagnostic;

use super::Report;

/// Most rows of a summary, which may have 1 MiB.
const MOST_ROWS: usize = 500;

/// A command a finding, errors first.
pub fn github(report: &Report<'_>) -> String {
    errors_first(report).into_iter().map(|found| command(report, found) + "\n").collect()
}

/// What the page of the step shows, in Markdown.
pub fn summary(report: &Report<'_>, last_line: &str) -> String {
    let mut text = format!("### kinora\n\n{last_line}\n");
    if !report.found.is_empty() {
        text += "\n| | place | |\n|---|---|---|\n";
    }
    for found in errors_first(report).into_iter().take(MOST_ROWS) {
        let place = match report.start(found) {
            Some((name, at)) => format!("{name}:{}:{}", at.line, at.column),
            None => report.file_of(found).to_string(),
        };
        let message = found.message.replace('|', "\\|");
        text += &format!("| {}[{}] | {place} | {message} |\n", found.severity.name(), found.code);
    }
    if report.found.len() > MOST_ROWS {
        text += &format!("\nand {} more\n", report.found.len() - MOST_ROWS);
    }
    text
}

fn errors_first<'a>(report: &Report<'a>) -> Vec<&'a Diagnostic> {
    let mut found: Vec<&Diagnostic> = report.found.iter().collect();
    found.sort_by_key(|found| !found.is_error());
    found
}

fn command(report: &Report<'_>, found: &Diagnostic) -> String {
    let mut properties = format!("title={}", property(&format!("kinora ({})", found.code)));
    properties += &format!(",file={}", property(report.file_of(found)));
    if let Some((source, span)) = found.place().and_then(|(file, span)| Some((report.source(file)?, span))) {
        let (start, end) = (source.position(span.start), source.position(span.end));
        // Columns of several lines would be dropped, and the command with them.
        properties += &match start.line == end.line {
            true => format!(",line={},col={},endLine={},endColumn={}", start.line, start.column, end.line, end.column),
            false => format!(",line={},endLine={}", start.line, end.line),
        };
    }
    format!("::{} {properties}::{}", found.severity.name(), data(&found.message))
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
