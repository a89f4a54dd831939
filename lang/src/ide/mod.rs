//! What an editor asks about a text: what stands here, what may stand here, where a name comes from.
//!
//! Everything here is a function of texts and offsets in bytes and answers any text, however broken. Lines, columns and
//! the protocol are the server's (`cli/src/lsp`).

mod colors;
mod complete;
mod cursor;
mod folding;
mod hints;
mod hover;
mod names;
mod outline;
mod paths;
mod selection;
mod signature;
mod tokens;
mod walk;

pub use colors::{ColorAt, colors, spellings};
pub use complete::{Completion, CompletionKind, completions, document};
pub use folding::{Fold, FoldKind, folds};
pub use hints::{Hint, HintKind, hints, watched};
pub use hover::{Hover, hover};
pub use names::{Declaration, Place, is_name};
pub use outline::{Entry, What, outline};
pub use paths::{PathAt, moved, paths};
pub use selection::selection;
pub use signature::{Signature, signature};
pub use tokens::{Modifier, Token, TokenKind, tokens};

use std::sync::{Arc, OnceLock};

use crate::eval::{Symbol, Use, Uses, uses};
use crate::files::Files;
use crate::modules::{Modules, load};
use crate::source::{FileId, Source, Span};
use crate::syntax::{Tree, parse};

/// A text with the files that it imports, and what its names mean.
#[derive(Clone)]
pub struct Analysis {
    /// The text itself.
    pub tree: Tree,
    /// It and what it imports.
    pub modules: Arc<Modules>,
    names: Arc<OnceLock<Index>>,
}

/// What means what, by place.
struct Index {
    declared: rustc_hash::FxHashMap<Span, Symbol>,
    /// By where they are.
    uses: Vec<Use>,
}

impl Analysis {
    /// Reads a text, named as in its project, and what it imports.
    pub fn new(name: &str, text: &str, files: &dyn Files) -> Analysis {
        let tree = parse(&Source::new(FileId(0), name, text));
        let modules = Arc::new(load(&tree, files));
        Analysis { tree, modules, names: Arc::default() }
    }

    fn index(&self) -> &Index {
        self.names.get_or_init(|| {
            let Uses { declared, mut uses } = uses(&self.modules);
            uses.sort_by_key(|found| found.at);
            Index { declared: declared.into_iter().collect(), uses }
        })
    }
}
