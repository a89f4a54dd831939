//! Diagnostics for programs: one record each.

use super::{Diagnostic, Edit, Fix, Label, codes};
use crate::source::{FileId, Source, Span};
use serde::Serialize;

/// Version of the records. It grows when a field changes its meaning or goes; new fields may come at any time.
pub const JSON_VERSION: u32 = 1;

#[derive(Serialize)]
struct Record<'a> {
    version: u32,
    code: &'a str,
    severity: &'a str,
    message: &'a str,
    /// Path from the project's root; null where the finding has no place.
    file: Option<&'a str>,
    /// Path from the current folder.
    path: Option<&'a str>,
    span: Option<Place>,
    labels: Vec<LabelRecord<'a>>,
    notes: &'a [String],
    helps: &'a [String],
    fixes: Vec<FixRecord<'a>>,
    /// The page about the code.
    url: String,
}

/// Offsets are bytes from 0; lines and columns count from 1, `col` in characters, `utf16` in UTF-16 units.
#[derive(Serialize)]
struct Place {
    start: u32,
    end: u32,
    line: u32,
    col: u32,
    utf16: u32,
    end_line: u32,
    end_col: u32,
    end_utf16: u32,
}

#[derive(Serialize)]
struct LabelRecord<'a> {
    file: Option<&'a str>,
    span: Option<Place>,
    text: &'a str,
    primary: bool,
}

#[derive(Serialize)]
struct FixRecord<'a> {
    applicability: &'a str,
    message: &'a str,
    edits: Vec<EditRecord<'a>>,
}

#[derive(Serialize)]
struct EditRecord<'a> {
    file: Option<&'a str>,
    span: Option<Place>,
    insert: &'a str,
}

/// The diagnostics as a JSON array, with a line break at its end. Spans of files that are not in `sources` are null.
/// `from_here` are the same texts, named from the current folder.
pub fn to_json(diagnostics: &[Diagnostic], sources: &[Source], from_here: &[Source]) -> String {
    let records: Vec<Record<'_>> = diagnostics.iter().map(|found| record(found, sources, from_here)).collect();
    // Strings and integers always serialise.
    let text = serde_json::to_string_pretty(&records).unwrap_or_else(|_| "[]".to_string());
    text + "\n"
}

/// The same records, one a line.
pub fn to_json_lines(diagnostics: &[Diagnostic], sources: &[Source], from_here: &[Source]) -> String {
    let line = |found| serde_json::to_string(&record(found, sources, from_here)).unwrap_or_default() + "\n";
    diagnostics.iter().map(line).collect()
}

fn record<'a>(found: &'a Diagnostic, sources: &'a [Source], from_here: &'a [Source]) -> Record<'a> {
    let first = found.labels.first();
    Record {
        version: JSON_VERSION,
        code: found.code,
        severity: found.severity.name(),
        message: &found.message,
        file: first.and_then(|label| name(label.file, sources)),
        path: first.and_then(|label| name(label.file, from_here)),
        span: first.and_then(|label| place(label.file, label.span, sources)),
        labels: found.labels.iter().map(|label| label_record(label, sources)).collect(),
        notes: &found.notes,
        helps: &found.helps,
        fixes: found.fixes.iter().map(|fix| fix_record(fix, sources)).collect(),
        url: codes::url(found.code),
    }
}

fn label_record<'a>(label: &'a Label, sources: &'a [Source]) -> LabelRecord<'a> {
    let Label { file, span, text, primary } = label;
    LabelRecord { file: name(*file, sources), span: place(*file, *span, sources), text, primary: *primary }
}

fn fix_record<'a>(fix: &'a Fix, sources: &'a [Source]) -> FixRecord<'a> {
    let edit = |edit: &'a Edit| EditRecord {
        file: name(edit.file, sources),
        span: place(edit.file, edit.span, sources),
        insert: &edit.insert,
    };
    FixRecord {
        applicability: fix.applicability.name(),
        message: &fix.message,
        edits: fix.edits.iter().map(edit).collect(),
    }
}

fn name(file: FileId, sources: &[Source]) -> Option<&str> {
    sources.iter().find(|source| source.id == file).map(|source| &*source.name)
}

fn place(file: FileId, span: Span, sources: &[Source]) -> Option<Place> {
    let source = sources.iter().find(|source| source.id == file)?;
    let (start, end) = (source.clamp(span.start), source.clamp(span.end));
    let (first, last) = (source.position(start), source.position(end));
    Some(Place {
        start,
        end,
        line: first.line,
        col: first.column,
        utf16: first.utf16,
        end_line: last.line,
        end_col: last.column,
        end_utf16: last.utf16,
    })
}
