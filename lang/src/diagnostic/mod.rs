//! What a mistake in a scene is answered with: one type for the parser, the evaluator and the assets.
//!
//! The message is one lower-case clause that stands alone. The primary label says what is wrong *here*, other labels
//! show the other party, notes are facts, helps are actions, and a fix is an action that a program can take.
//!
//! ```
//! use kinora_lang::diagnostic::{Applicability, Diagnostic};
//! use kinora_lang::source::{FileId, Span};
//!
//! let file = FileId(0);
//! let diagnostic = Diagnostic::new("E0201", "unknown property `raduis` on `sphere`")
//!     .primary(file, Span::new(18, 24), "not a property of `sphere`")
//!     .fix(Applicability::Safe, "a property with a similar name exists: `radius`", file, Span::new(18, 24), "radius");
//! assert!(diagnostic.is_error());
//! ```

mod allow;
pub mod codes;
mod derived;
mod fix;
mod json;
mod levels;
mod limit;
mod render;

pub use allow::honour;
pub use derived::without_derived;
pub use fix::{apply, choose};
pub use json::{JSON_VERSION, to_json, to_json_lines};
pub use levels::{Level, Levels, levels_of_project, no_code};
pub use limit::{Kept, Listing, MAX_SHOWN, MOST, list, sort};
pub use render::{Style, render, render_short};

use crate::source::{FileId, Span};

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The scene cannot be used.
    Error,
    /// The scene can be used, but perhaps not as it was meant.
    Warning,
}

impl Severity {
    /// `error` or `warning`.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
        }
    }
}

/// The severity of a code by itself: its letter is `E` or `W`.
pub fn severity(code: &str) -> Severity {
    if code.starts_with('W') { Severity::Warning } else { Severity::Error }
}

/// A place in the text and what to say about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// The file.
    pub file: FileId,
    /// The place; may be empty.
    pub span: Span,
    /// What to say; may be empty.
    pub text: String,
    /// Whether this is what the message is about. A diagnostic has at most one such label, its first.
    pub primary: bool,
}

/// How far a fix may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Applicability {
    /// Means what the author meant: may be applied without asking.
    Safe,
    /// Likely what the author meant: apply on request.
    Maybe,
    /// Shows the shape only: something is left to fill in.
    Manual,
}

impl Applicability {
    /// `safe`, `maybe` or `manual`.
    pub fn name(self) -> &'static str {
        match self {
            Applicability::Safe => "safe",
            Applicability::Maybe => "maybe",
            Applicability::Manual => "manual",
        }
    }
}

/// Text to put in place of a span.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edit {
    /// The file.
    pub file: FileId,
    /// What goes; empty to insert only.
    pub span: Span,
    /// What comes.
    pub insert: String,
}

/// A change of the text that answers the diagnostic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fix {
    /// How far it may be trusted.
    pub applicability: Applicability,
    /// What it does: "write `radius`". It is shown as a help of its own, so [`Diagnostic::helps`] need not repeat it.
    pub message: String,
    /// The edits; they do not overlap.
    pub edits: Vec<Edit>,
}

/// One finding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// A code of [`codes::all`].
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// One lower-case clause that stands alone.
    pub message: String,
    /// Places, the primary one first. Empty when the finding has no place, such as a wrong command line argument.
    pub labels: Vec<Label>,
    /// Facts.
    pub notes: Vec<String>,
    /// Actions that only the author can take.
    pub helps: Vec<String>,
    /// Actions that a program can take.
    pub fixes: Vec<Fix>,
}

impl Diagnostic {
    /// A diagnostic without places. The severity comes from the code's letter: `E` or `W`.
    pub fn new(code: &'static str, message: impl Into<String>) -> Diagnostic {
        let (labels, notes, helps, fixes) = Default::default();
        Diagnostic { code, severity: severity(code), message: message.into(), labels, notes, helps, fixes }
    }

    /// Sets the primary label.
    pub fn primary(mut self, file: FileId, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.retain(|label| !label.primary);
        self.labels.insert(0, Label { file, span, text: text.into(), primary: true });
        self
    }

    /// Adds a secondary label.
    pub fn label(mut self, file: FileId, span: Span, text: impl Into<String>) -> Diagnostic {
        self.labels.push(Label { file, span, text: text.into(), primary: false });
        self
    }

    /// Adds a fact.
    pub fn note(mut self, text: impl Into<String>) -> Diagnostic {
        self.notes.push(text.into());
        self
    }

    /// Adds an action.
    pub fn help(mut self, text: impl Into<String>) -> Diagnostic {
        self.helps.push(text.into());
        self
    }

    /// Adds a fix of one edit.
    pub fn fix(
        self,
        applicability: Applicability,
        message: impl Into<String>,
        file: FileId,
        span: Span,
        insert: impl Into<String>,
    ) -> Diagnostic {
        self.fix_edits(applicability, message, vec![Edit { file, span, insert: insert.into() }])
    }

    /// Adds a fix of several edits, which must not overlap.
    pub fn fix_edits(
        mut self,
        applicability: Applicability,
        message: impl Into<String>,
        edits: Vec<Edit>,
    ) -> Diagnostic {
        self.fixes.push(Fix { applicability, message: message.into(), edits });
        self
    }

    /// The place that the message is about: the primary label's, else the first one's.
    pub fn place(&self) -> Option<(FileId, Span)> {
        self.labels.first().map(|label| (label.file, label.span))
    }

    /// Whether it forbids the use of the scene.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}
