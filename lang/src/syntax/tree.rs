//! A parsed text.

use super::kind::{SyntaxKind, SyntaxNode};
use super::parse::{Green, green};
use super::{ast, errors, expr, lower, shift};
use crate::diagnostic::Diagnostic;
use crate::source::Source;
use rowan::GreenNode;

/// A text as a lossless tree, and the mistakes in it. May be sent between threads; [`Tree::root`] may not.
#[derive(Debug, Clone)]
pub struct Tree {
    /// The text.
    pub source: Source,
    green: GreenNode,
    errors: Vec<Diagnostic>,
    too_deep: bool,
}

/// Parses a file. Never fails: the leaves of the tree, joined, are the text.
///
/// ```
/// use kinora_lang::source::{FileId, Source};
/// let tree = kinora_lang::parse(&Source::new(FileId(0), "a.kin", "sphere ball { radius: 50cm"));
/// assert_eq!(tree.root().text().to_string(), "sphere ball { radius: 50cm");
/// assert_eq!(tree.errors()[0].message, "this `{` is never closed");
/// ```
pub fn parse(source: &Source) -> Tree {
    Tree::new(source, false)
}

/// Parses a single value, as the one behind `-D name=`; returns it with the mistakes in it. Text behind the value is one.
pub fn parse_value(source: &Source) -> (ast::Expr, Vec<Diagnostic>) {
    let tree = Tree::new(source, true);
    let root = tree.root();
    let found = lower::parts(&root).find(|part| part.kind().is_value());
    let value = match found {
        Some(part) if !tree.too_deep => expr::value(&part),
        _ => lower::missing_in(&root),
    };
    (value, tree.errors)
}

impl Tree {
    fn new(source: &Source, one_value: bool) -> Tree {
        let Green { node, stopped, has_bad } = green(&source.text, one_value);
        let mut tree = Tree { source: source.clone(), green: node, errors: Vec::new(), too_deep: false };
        let found = errors::find(source, &tree.root(), stopped, has_bad);
        tree.errors = found.errors;
        tree.too_deep = found.too_deep;
        tree
    }

    /// The root node: every space and comment is in it.
    pub fn root(&self) -> SyntaxNode {
        SyntaxNode::new_root(self.green.clone())
    }

    /// The mistakes, in the order of the text, at most one a line.
    pub fn errors(&self) -> &[Diagnostic] {
        &self.errors
    }

    /// The file as the evaluator reads it. Expressions beyond [`ast::MAX_DEPTH`] are reported, and the file is then empty.
    pub fn file(&self) -> ast::File {
        let root = self.root();
        match self.too_deep || root.kind() != SyntaxKind::File {
            true => ast::File { items: Vec::new(), span: lower::node_span(&root) },
            false => lower::file(&root),
        }
    }

    /// The file with all its places moved by `base`: to where its text lies in [`Texts`](crate::source::Texts).
    pub fn file_at(&self, base: u32) -> ast::File {
        let mut file = self.file();
        if base > 0 {
            shift::file(&mut file, base);
        }
        file
    }
}
