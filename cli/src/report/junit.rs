//! JUnit's XML: a suite a file, a failed case an error. Warnings are what their file's case says.

use kinora_lang::diagnostic::Diagnostic;

use super::Report;

/// The report; a file without errors is a case that passed.
pub fn junit(report: &Report<'_>) -> String {
    let mut files: Vec<&str> = report.files.iter().map(String::as_str).collect();
    for found in report.found {
        if !files.contains(&report.file_of(found)) {
            files.push(report.file_of(found));
        }
    }
    let suites: Vec<String> = files.iter().map(|file| suite(report, file)).collect();
    let errors = report.found.iter().filter(|found| found.is_error()).count();
    let tests: usize = files.iter().map(|file| of(report, file, true).len().max(1)).sum();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"kinora\" tests=\"{tests}\" \
         failures=\"{errors}\" errors=\"0\">\n{}</testsuites>\n",
        suites.concat()
    )
}

fn of<'a>(report: &Report<'a>, file: &str, errors: bool) -> Vec<&'a Diagnostic> {
    report.found.iter().filter(|found| found.is_error() == errors && report.file_of(found) == file).collect()
}

fn suite(report: &Report<'_>, file: &str) -> String {
    let (errors, warnings) = (of(report, file, true), of(report, file, false));
    let (name, failed) = (escaped(file), errors.len());
    let mut text =
        format!("  <testsuite name=\"{name}\" tests=\"{}\" failures=\"{failed}\" errors=\"0\">\n", failed.max(1));
    for found in &errors {
        let (line, _) = report.lines(found);
        let message = escaped(&found.message);
        text += &format!("    <testcase name=\"{} line {line}\" classname=\"{name}\">\n", found.code);
        text += &format!("      <failure type=\"{}\" message=\"{message}\">", found.code);
        text += &format!("{}</failure>\n    </testcase>\n", escaped(&super::plain(found, report.sources)));
    }
    if errors.is_empty() {
        text += &format!("    <testcase name=\"check\" classname=\"{name}\"/>\n");
    }
    if !warnings.is_empty() {
        let said: Vec<String> = warnings.iter().map(|found| super::plain(found, report.sources)).collect();
        text += &format!("    <system-out>{}</system-out>\n", escaped(&said.join("\n")));
    }
    text + "  </testsuite>\n"
}

/// As XML may have it: control characters are not allowed in it at all.
pub fn escaped(text: &str) -> String {
    let one = |character: char| match character {
        '&' => "&amp;".to_string(),
        '<' => "&lt;".to_string(),
        '>' => "&gt;".to_string(),
        '"' => "&quot;".to_string(),
        '\n' | '\t' => character.to_string(),
        '\u{FFFE}' | '\u{FFFF}' => "\u{FFFD}".to_string(),
        character if character.is_control() => "\u{FFFD}".to_string(),
        character => character.to_string(),
    };
    text.chars().map(one).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn xml_is_escaped() {
        assert_eq!(super::escaped("<a & \"b\">\u{0}\n"), "&lt;a &amp; &quot;b&quot;&gt;\u{FFFD}\n");
    }
}
