//! The code quality report of GitLab.

use kinora_lang::diagnostic::Diagnostic;
use serde_json::{Value, json};

use super::{Report, fingerprints};

/// An array of findings.
pub fn gitlab(report: &Report<'_>) -> String {
    let one = |(found, fingerprint): (&Diagnostic, String)| {
        let (begin, end) = report.lines(found);
        json!({
            "description": found.message,
            "check_name": found.code,
            "fingerprint": fingerprint,
            "severity": if found.is_error() { "major" } else { "minor" },
            "location": { "path": report.file_of(found), "lines": { "begin": begin, "end": end } },
        })
    };
    super::pretty(&Value::Array(report.found.iter().zip(fingerprints(report)).map(one).collect()))
}
