//! What an editor offers to do: fixes of findings, and allowances of warnings.

use kinora_lang::diagnostic::{Applicability, Edit};
use kinora_lang::source::{FileId, Source, Span};
use lsp_types as lsp;

use super::diagnose::Findings;
use super::position::Encoding;
use super::server::Changed;

/// The kind of the action that puts everything right which is certain.
pub const FIX_ALL: &str = "source.fixAll.kinora";

/// The actions for a span of a text.
pub fn actions(
    findings: &Findings,
    (source, own): (&Source, &lsp::Uri),
    within: Span,
    only: Option<&[lsp::CodeActionKind]>,
    encoding: Encoding,
    changed: &dyn Fn(Changed) -> lsp::WorkspaceEdit,
) -> Vec<lsp::CodeAction> {
    // `quickfix` also stands for the kinds below it.
    let wanted = |kind: &str| {
        only.is_none_or(|only| {
            only.iter().any(|only| {
                only.as_str().is_empty() || kind == only.as_str() || kind.starts_with(&format!("{}.", only.as_str()))
            })
        })
    };
    let mut found = Vec::new();
    // The text itself is the first.
    let said = findings.by_file(own, encoding).into_iter().next().map(|file| file.1).unwrap_or_default();
    if wanted("quickfix") {
        for (finding, fix) in findings.fixes_in(within) {
            let Some(edits) = findings.edits(&fix.edits, own, encoding) else { continue };
            found.push(lsp::CodeAction {
                title: fix.message.clone(),
                kind: Some(lsp::CodeActionKind::QUICKFIX),
                diagnostics: diagnostics_of(&said, findings, finding, encoding),
                edit: Some(changed(edits)),
                is_preferred: Some(fix.applicability == Applicability::Safe),
                ..lsp::CodeAction::default()
            });
        }
        let mut allowed: Vec<&str> = Vec::new();
        for finding in &findings.found {
            let Some((id, span)) = finding.place().filter(|(id, _)| *id == FileId(0)) else { continue };
            let touches = span.start <= within.end && within.start <= span.end;
            // What is wrong with allowances is not allowed by another.
            let can =
                !finding.is_error() && !matches!(finding.code, "W0902" | "W0903") && !allowed.contains(&finding.code);
            if !touches || !can {
                continue;
            }
            allowed.push(finding.code);
            let line = source.line_span(source.line_index(span.start));
            let text = source.slice(line);
            let indent = &text[..text.len() - text.trim_start().len()];
            let insert = format!("{indent}// allow({}): ", finding.code);
            let edit = Edit { file: id, span: Span::at(line.start), insert: format!("{insert}\n") };
            let Some(edits) = findings.edits(&[edit], own, encoding) else { continue };
            found.push(lsp::CodeAction {
                title: format!("allow {} here", finding.code),
                kind: Some(lsp::CodeActionKind::QUICKFIX),
                diagnostics: diagnostics_of(&said, findings, finding, encoding),
                edit: Some(changed(edits)),
                ..lsp::CodeAction::default()
            });
        }
    }
    // Asked for by name only, as when a text is saved, or where there is more than one thing to put right.
    let safe = findings.safe_edits();
    let by_name = only.is_some() && wanted(FIX_ALL);
    if !safe.is_empty()
        && (by_name || only.is_none() && !found.is_empty())
        && let Some(edits) = findings.edits(&safe, own, encoding)
    {
        found.push(lsp::CodeAction {
            title: "put right everything that is certain".into(),
            kind: Some(lsp::CodeActionKind::new(FIX_ALL)),
            edit: Some(changed(edits)),
            ..lsp::CodeAction::default()
        });
    }
    found
}

fn diagnostics_of(
    all: &[lsp::Diagnostic],
    findings: &Findings,
    finding: &kinora_lang::diagnostic::Diagnostic,
    encoding: Encoding,
) -> Option<Vec<lsp::Diagnostic>> {
    let (_, span) = finding.place()?;
    let source = &findings.sources.first()?.0;
    let range = encoding.range(source, span);
    let same = |said: &&lsp::Diagnostic| {
        said.range == range && said.code == Some(lsp::NumberOrString::String(finding.code.into()))
    };
    Some(all.iter().filter(same).cloned().collect())
}
