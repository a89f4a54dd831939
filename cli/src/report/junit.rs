//! JUnit's XML: what passed, what failed and what could not be tried, suite by suite.

use kinora_lang::diagnostic::Diagnostic;

use super::Report;

/// The cases of one file.
pub struct Suite {
    pub file: String,
    pub cases: Vec<TestCase>,
    /// What else there is to say; may be empty.
    pub out: String,
}

/// One case.
pub struct TestCase {
    pub name: String,
    /// In the suite's file, from 1.
    pub line: Option<u32>,
    pub seconds: Option<f64>,
    /// `None` where it passed.
    pub fault: Option<Fault>,
}

/// Why a case did not pass.
pub struct Fault {
    /// Whether it could not be tried; else it failed.
    pub is_error: bool,
    pub kind: String,
    /// In one line.
    pub message: String,
    pub text: String,
}

/// Findings as a report: a suite a file, an error a case that failed, and a file without errors one that passed.
/// Warnings are what their file's suite says.
pub fn junit(report: &Report<'_>) -> String {
    let mut files: Vec<&str> = report.files.iter().map(String::as_str).collect();
    for found in report.found {
        if !files.contains(&report.file_of(found)) {
            files.push(report.file_of(found));
        }
    }
    let suites: Vec<Suite> = files.iter().map(|file| suite(report, file)).collect();
    xml("kinora", &suites)
}

fn suite(report: &Report<'_>, file: &str) -> Suite {
    let plain = |found: &Diagnostic| super::plain(found, report.sources);
    let own = report.found.iter().filter(|found| report.file_of(found) == file);
    let (errors, warnings): (Vec<&Diagnostic>, Vec<&Diagnostic>) = own.partition(|found| found.is_error());
    let case = |found: &&Diagnostic| {
        let (line, _) = report.lines(found);
        let (kind, message) = (found.code.to_string(), found.message.clone());
        let fault = Some(Fault { is_error: false, kind, message, text: plain(found) });
        TestCase { name: format!("{} line {line}", found.code), line: Some(line), seconds: None, fault }
    };
    let passed = || TestCase { name: "check".into(), line: None, seconds: None, fault: None };
    let cases = if errors.is_empty() { vec![passed()] } else { errors.iter().map(case).collect() };
    let out: Vec<String> = warnings.into_iter().map(plain).collect();
    Suite { file: file.into(), cases, out: out.join("\n") }
}

/// The XML of a report.
pub fn xml(title: &str, suites: &[Suite]) -> String {
    let all: Vec<&TestCase> = suites.iter().flat_map(|suite| &suite.cases).collect();
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{}\"{}>\n",
        escaped(title),
        counts(&all)
    );
    for Suite { file, cases, out } in suites {
        let own: Vec<&TestCase> = cases.iter().collect();
        let file = escaped(file);
        text += &format!("  <testsuite name=\"{file}\"{}>\n", counts(&own));
        for case in cases {
            text += &xml_of(&file, case);
        }
        if !out.is_empty() {
            text += &format!("    <system-out>{}</system-out>\n", escaped(out));
        }
        text += "  </testsuite>\n";
    }
    text + "</testsuites>\n"
}

fn counts(cases: &[&TestCase]) -> String {
    let count = |is_error| {
        cases.iter().filter(|case| case.fault.as_ref().is_some_and(|fault| fault.is_error == is_error)).count()
    };
    let mut text = format!(" tests=\"{}\" failures=\"{}\" errors=\"{}\"", cases.len(), count(false), count(true));
    let seconds: Vec<f64> = cases.iter().filter_map(|case| case.seconds).collect();
    if !seconds.is_empty() {
        text += &format!(" time=\"{:.3}\"", seconds.iter().sum::<f64>());
    }
    text
}

fn xml_of(file: &str, case: &TestCase) -> String {
    let mut text = format!("    <testcase name=\"{}\" classname=\"{file}\" file=\"{file}\"", escaped(&case.name));
    if let Some(line) = case.line {
        text += &format!(" line=\"{line}\"");
    }
    if let Some(seconds) = case.seconds {
        text += &format!(" time=\"{seconds:.3}\"");
    }
    let Some(Fault { is_error, kind, message, text: said }) = &case.fault else { return text + "/>\n" };
    let element = if *is_error { "error" } else { "failure" };
    let (kind, message, said) = (escaped(kind), escaped(message), escaped(said));
    text += &format!(">\n      <{element} type=\"{kind}\" message=\"{message}\">{said}</{element}>\n");
    text + "    </testcase>\n"
}

/// As XML may have it: control characters are not allowed in it at all.
fn escaped(text: &str) -> String {
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
