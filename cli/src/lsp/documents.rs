//! The texts that an editor has open, and what is known of each.

use std::path::PathBuf;
use std::sync::Arc;

use kinora_lang::ide::Analysis;
use kinora_lang::source::{FileId, Source};
use lsp_types::{TextDocumentContentChangeEvent, Uri};

use super::diagnose::Findings;
use super::position::Encoding;

/// A text that is open.
pub struct Document {
    pub uri: Uri,
    /// Where it is, or would be: texts that were never saved have a place, too.
    pub path: PathBuf,
    pub version: i32,
    /// The text with its lines.
    pub source: Source,
    /// What its names mean, since the last change of any file.
    pub analysis: Option<Analysis>,
    /// What is wrong with it, since the last change of any file.
    pub findings: Option<Arc<Findings>>,
    /// Frames a second and seconds, as they were when there was a scene last.
    pub clock: Option<(f64, f64)>,
}

impl Document {
    pub fn new(uri: Uri, path: PathBuf, version: i32, text: &str) -> Document {
        let source = Source::new(FileId(0), "", text);
        Document { uri, path, version, source, analysis: None, findings: None, clock: None }
    }

    /// Takes changes in their order, each as seen after the one before.
    pub fn change(&mut self, version: i32, changes: Vec<TextDocumentContentChangeEvent>, encoding: Encoding) {
        for change in changes {
            let text = match change.range {
                None => change.text,
                Some(range) => {
                    let span = encoding.span(&self.source, range);
                    let old = &self.source.text;
                    let (before, behind) = (&old[..span.start as usize], &old[span.end as usize..]);
                    [before, &change.text, behind].concat()
                }
            };
            self.source = Source::new(FileId(0), "", text);
        }
        self.version = version;
    }

    /// Nothing that was found out holds any more.
    pub fn forget(&mut self) {
        (self.analysis, self.findings) = (None, None);
    }
}
