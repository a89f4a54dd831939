//! SARIF 2.1.0, for code scanning.

use kinora_lang::diagnostic::{Diagnostic, Edit, Label, codes, severity};
use kinora_lang::source::{FileId, Span};
use serde_json::{Value, json};

use super::{Report, fingerprints};

/// GitHub ignores what comes behind these.
const MOST: usize = 5000;

/// One run with the findings, errors first.
pub fn sarif(report: &Report<'_>) -> String {
    let mut found: Vec<(&Diagnostic, String)> = report.found.iter().zip(fingerprints(report)).collect();
    found.sort_by_key(|(found, _)| !found.is_error());
    found.truncate(MOST);
    let mut used: Vec<&str> = found.iter().map(|(found, _)| found.code).collect();
    used.sort_unstable();
    used.dedup();
    let rules: Vec<Value> = used.iter().filter_map(|code| rule(code)).collect();
    let results: Vec<Value> = found.iter().map(|(found, hash)| result(report, found, hash, &used)).collect();
    super::pretty(&json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "kinora",
                "version": env!("CARGO_PKG_VERSION"),
                "informationUri": env!("CARGO_PKG_REPOSITORY"),
                "rules": rules,
            } },
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    }))
}

fn rule(code: &str) -> Option<Value> {
    let row = codes::find(code)?;
    Some(json!({
        "id": code,
        "shortDescription": { "text": row.title },
        "fullDescription": { "text": row.text },
        "help": { "text": format!("{}: {}\n\n{}", row.code, row.title, row.text), "markdown": codes::page(&row) },
        "helpUri": codes::url(code),
        "defaultConfiguration": { "level": severity(code).name() },
    }))
}

fn result(report: &Report<'_>, found: &Diagnostic, fingerprint: &str, used: &[&str]) -> Value {
    let mut result = json!({
        "ruleId": found.code,
        "ruleIndex": used.iter().position(|code| *code == found.code),
        "level": found.severity.name(),
        "message": { "text": found.message },
        "locations": [{ "physicalLocation": match found.labels.first() {
            Some(label) => physical(report, label),
            None => json!({ "artifactLocation": artifact(report.file_of(found)) }),
        } }],
        "partialFingerprints": { "primaryLocationLineHash": fingerprint },
    });
    let related: Vec<Value> = found.labels.iter().skip(1).enumerate().map(|(at, label)| {
        json!({ "id": at, "message": { "text": label.text }, "physicalLocation": physical(report, label) })
    }).collect();
    if !related.is_empty() {
        result["relatedLocations"] = related.into();
    }
    let fixes: Vec<Value> = found
        .fixes
        .iter()
        .map(|fix| {
            let change = |edit: &Edit| {
                json!({
                    "artifactLocation": artifact(report.name(edit.file)),
                    "replacements": [{
                        "deletedRegion": region(report, edit.file, edit.span),
                        "insertedContent": { "text": edit.insert },
                    }],
                })
            };
            let changes: Vec<Value> = fix.edits.iter().map(change).collect();
            json!({ "description": { "text": fix.message }, "artifactChanges": changes })
        })
        .collect();
    if !fixes.is_empty() {
        result["fixes"] = fixes.into();
    }
    result
}

fn physical(report: &Report<'_>, label: &Label) -> Value {
    let name = report.name(label.file);
    json!({ "artifactLocation": artifact(name), "region": region(report, label.file, label.span) })
}

fn artifact(name: &str) -> Value {
    json!({ "uri": encoded(name), "uriBaseId": "%SRCROOT%" })
}

fn region(report: &Report<'_>, file: FileId, span: Span) -> Value {
    let Some(source) = report.source(file) else { return json!({ "startLine": 1 }) };
    let (start, end) = (source.position(span.start), source.position(span.end));
    json!({
        "startLine": start.line,
        "startColumn": start.column,
        "endLine": end.line,
        "endColumn": end.column,
    })
}

/// A path as a relative URI.
fn encoded(path: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-._~".contains(&byte);
    let code = |byte: u8| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") };
    path.bytes().map(code).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn paths_are_uris() {
        assert_eq!(super::encoded("scenes/a b-1.kin"), "scenes/a%20b-1.kin");
        assert_eq!(super::encoded("é.kin"), "%C3%A9.kin");
    }
}
