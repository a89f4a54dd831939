//! What is wrong with a text: what `kinora check` says of it.

use std::path::Path;
use std::sync::Arc;

use kinora_lang::assets::cache::Cache;
use kinora_lang::diagnostic::{Applicability, Diagnostic, Severity, codes};
use kinora_lang::library;
use kinora_lang::source::{FileId, Source, Span};
use lsp_types as lsp;

use super::position::Encoding;
use super::project::{Open, Project};
use super::uri;
use crate::commands::check::findings;
use crate::session::{self, Changes, Kept};

/// What was found in a text and in what it imports.
pub struct Findings {
    pub found: Vec<Diagnostic>,
    /// The texts that the findings point into, with their addresses; the text itself first.
    pub sources: Vec<(Source, Option<lsp::Uri>)>,
    /// Frames a second and seconds, where there is a scene.
    pub clock: Option<(f64, f64)>,
}

/// Most findings that are sent of a text; editors choke on more.
const MOST: usize = 1_000;

/// Reads, evaluates and samples a text that is open.
pub fn diagnose(path: &Path, open: &Arc<Open>, cache: &Arc<Cache>) -> Findings {
    let changes = Changes { kept: Kept(Some(cache.clone())), open: open.clone(), ..Changes::default() };
    let project = Project::of(path, open);
    // A text whose folder is not there is read without one.
    let Ok(loaded) = session::load_as(FileId(0), path, &changes) else { return nowhere(&project) };
    let address = |source: &Source| match source.id == FileId(0) {
        true => uri::of(path),
        false => project.uri(&source.name),
    };
    let sources = loaded.sources.iter().map(|source| (source.clone(), address(source))).collect();
    let clock = loaded.scene.as_ref().map(|scene| (scene.clock.fps, scene.clock.duration_s));
    Findings { found: findings(&loaded, None, false), sources, clock }
}

fn nowhere(project: &Project) -> Findings {
    let name = project.name();
    let tree = kinora_lang::parse(&project.source(name).unwrap_or_else(|| Source::new(FileId(0), name, "")));
    let (result, sources) = kinora_lang::eval_project(&tree, project.files(), &kinora_lang::Overrides::default());
    let (found, clock) = match result {
        Ok(evaluated) => (evaluated.warnings, Some((evaluated.scene.clock.fps, evaluated.scene.clock.duration_s))),
        Err(found) => (found, None),
    };
    let address = |source: &Source| project.uri(&source.name).filter(|_| !library::is_path(&source.name));
    let sources = sources.into_iter().map(|source| (source.clone(), address(&source))).collect();
    Findings { found, sources, clock }
}

impl Findings {
    fn source(&self, id: FileId) -> Option<&(Source, Option<lsp::Uri>)> {
        self.sources.iter().find(|(source, _)| source.id == id)
    }

    /// The findings by the text that they are in: address, and what to say there. `own` is the text itself, which is among
    /// them even if nothing is wrong with it.
    pub fn by_file(&self, own: &lsp::Uri, encoding: Encoding) -> Vec<(lsp::Uri, Vec<lsp::Diagnostic>)> {
        let mut files: Vec<(lsp::Uri, Vec<lsp::Diagnostic>)> = vec![(own.clone(), Vec::new())];
        for found in self.found.iter().take(MOST) {
            let (id, span) = found.place().unwrap_or((FileId(0), Span::default()));
            let Some((source, address)) = self.source(id) else { continue };
            if library::is_path(&source.name) {
                continue;
            }
            let address = if id == FileId(0) { Some(own.clone()) } else { address.clone() };
            let Some(address) = address else { continue };
            let said = self.say(found, source, span, own, encoding);
            match files.iter_mut().find(|(file, _)| *file == address) {
                Some((_, list)) => list.push(said),
                None => files.push((address, vec![said])),
            }
        }
        files
    }

    fn say(
        &self,
        found: &Diagnostic,
        source: &Source,
        span: Span,
        own: &lsp::Uri,
        encoding: Encoding,
    ) -> lsp::Diagnostic {
        let severity = match found.severity {
            Severity::Error => lsp::DiagnosticSeverity::ERROR,
            Severity::Warning => lsp::DiagnosticSeverity::WARNING,
        };
        let mut message = found.message.clone();
        let primary = found.labels.first().filter(|label| label.primary).map_or("", |label| &label.text);
        if !primary.is_empty() {
            message += &format!("\n{primary}");
        }
        for note in &found.notes {
            message += &format!("\nnote: {note}");
        }
        for help in found.helps.iter().chain(found.fixes.iter().map(|fix| &fix.message)) {
            message += &format!("\nhelp: {help}");
        }
        let related =
            found.labels.iter().filter(|label| !label.primary && !label.text.is_empty()).filter_map(|label| {
                let (source, address) = self.source(label.file)?;
                let uri = if label.file == FileId(0) { own.clone() } else { address.clone()? };
                let location = lsp::Location { uri, range: encoding.range(source, label.span) };
                Some(lsp::DiagnosticRelatedInformation { location, message: label.text.clone() })
            });
        let related: Vec<_> = related.collect();
        // What is never used is shown faded; what has an old name, struck through.
        let tags = match found.code {
            "W0201" => Some(vec![lsp::DiagnosticTag::UNNECESSARY]),
            "W0901" => Some(vec![lsp::DiagnosticTag::DEPRECATED]),
            _ => None,
        };
        lsp::Diagnostic {
            range: encoding.range(source, span),
            severity: Some(severity),
            code: Some(lsp::NumberOrString::String(found.code.into())),
            code_description: codes::url(found.code).parse().ok().map(|href| lsp::CodeDescription { href }),
            source: Some("kinora".into()),
            message,
            related_information: (!related.is_empty()).then_some(related),
            tags,
            data: None,
        }
    }

    /// The fixes of what is found in a span of the text itself, and how far each may be trusted.
    pub fn fixes_in(&self, within: Span) -> Vec<(&Diagnostic, &kinora_lang::diagnostic::Fix)> {
        let touches = |found: &&Diagnostic| {
            found
                .place()
                .is_some_and(|(id, span)| id == FileId(0) && span.start <= within.end && within.start <= span.end)
        };
        let found = self.found.iter().filter(touches);
        let mut fixes: Vec<_> = found.flat_map(|found| found.fixes.iter().map(move |fix| (found, fix))).collect();
        fixes.sort_by_key(|(_, fix)| fix.applicability);
        fixes
    }

    /// What is certain to be right, all of it, in the text itself.
    pub fn safe_edits(&self) -> Vec<kinora_lang::diagnostic::Edit> {
        let edits = kinora_lang::diagnostic::choose(&self.found, Applicability::Safe);
        edits.into_iter().filter(|edit| edit.file == FileId(0)).collect()
    }

    /// The edits of a fix by address; `None` where one of the texts has none.
    pub fn edits(
        &self,
        edits: &[kinora_lang::diagnostic::Edit],
        own: &lsp::Uri,
        encoding: Encoding,
    ) -> Option<Vec<(lsp::Uri, Vec<lsp::TextEdit>)>> {
        let mut files: Vec<(lsp::Uri, Vec<lsp::TextEdit>)> = Vec::new();
        for edit in edits {
            let (source, address) = self.source(edit.file)?;
            let address = if edit.file == FileId(0) { own.clone() } else { address.clone()? };
            if library::is_path(&source.name) {
                return None;
            }
            let edit = lsp::TextEdit { range: encoding.range(source, edit.span), new_text: edit.insert.clone() };
            match files.iter_mut().find(|(file, _)| *file == address) {
                Some((_, list)) => list.push(edit),
                None => files.push((address, vec![edit])),
            }
        }
        Some(files)
    }
}
