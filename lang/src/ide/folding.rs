//! What can be folded away.

use crate::source::Span;
use crate::syntax::{SyntaxKind as K, Tree};

/// What is folded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum FoldKind {
    Block,
    Comment,
    Imports,
}

/// Text that can be folded away: more than one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fold {
    /// What it is.
    pub kind: FoldKind,
    /// Where; of a block with its brackets.
    pub span: Span,
}

/// What can be folded in a text, in its order.
pub fn folds(tree: &Tree) -> Vec<Fold> {
    let source = &tree.source;
    let line = |offset: u32| source.line_index(offset);
    let mut found: Vec<Fold> = Vec::new();
    // Comments of the line below one another, and imports.
    let mut run: Option<Fold> = None;
    for part in tree.root().all() {
        let kind = match part.kind() {
            K::Block | K::KeyBlock | K::Arm | K::Tuple | K::List | K::Args | K::Params | K::Names => FoldKind::Block,
            K::LineComment | K::DocComment | K::BlockComment => FoldKind::Comment,
            K::ImportDecl => FoldKind::Imports,
            _ => continue,
        };
        let text = part.text();
        let end = part.span().start + text.trim_end().len() as u32;
        let span = Span::new(part.span().start, end);
        if kind == FoldKind::Block {
            if line(span.start) < line(span.end) {
                found.push(Fold { kind, span });
            }
            continue;
        }
        match &mut run {
            Some(open) if open.kind == kind && line(span.start) <= line(open.span.end) + 1 => open.span.end = span.end,
            _ => {
                found.extend(run.take());
                run = Some(Fold { kind, span });
            }
        }
    }
    found.extend(run);
    found.retain(|fold| line(fold.span.start) < line(fold.span.end));
    found.sort_by_key(|fold| (fold.span.start, std::cmp::Reverse(fold.span.end)));
    found
}
