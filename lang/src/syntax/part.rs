//! The lossless tree: a list of its nodes and tokens in the order of the text, each node before what is in it.

use std::fmt;

use super::kind::SyntaxKind;
use crate::source::Span;

/// A node or token as it is kept.
#[derive(Debug, Clone, Copy)]
pub(super) struct Record {
    pub kind: SyntaxKind,
    pub span: Span,
    /// Index of the node that it is in; the root's own.
    pub parent: u32,
    /// Index behind the last record in it.
    pub after: u32,
}

/// A node or token of a tree, by reference.
#[derive(Clone, Copy)]
pub struct Part<'t> {
    text: &'t str,
    list: &'t [Record],
    at: u32,
}

impl fmt::Debug for Part<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}@{:?}", self.kind(), self.span())
    }
}

impl<'t> Part<'t> {
    /// The root of a list that is not empty; `text` is what its spans lie in.
    pub(super) fn root(text: &'t str, list: &'t [Record]) -> Part<'t> {
        Part { text, list, at: 0 }
    }

    fn record(self) -> &'t Record {
        &self.list[self.at as usize]
    }

    fn with(self, at: u32) -> Part<'t> {
        Part { at, ..self }
    }

    /// What it is.
    pub fn kind(self) -> SyntaxKind {
        self.record().kind
    }

    /// Its place, spaces and comments inside included.
    pub fn span(self) -> Span {
        self.record().span
    }

    /// Its text.
    pub fn text(self) -> &'t str {
        let span = self.span();
        self.text.get(span.start as usize..span.end as usize).unwrap_or_default()
    }

    /// Whether it is a node: what may have nodes and tokens in it.
    pub fn is_node(self) -> bool {
        self.kind().is_node()
    }

    /// Whether the other one is it or in it.
    pub fn holds(self, other: Part<'_>) -> bool {
        (self.at..self.record().after).contains(&other.at)
    }

    /// The node that it is in.
    pub fn parent(self) -> Option<Part<'t>> {
        (self.at > 0).then(|| self.with(self.record().parent))
    }

    /// It and all nodes around it, from the inside out.
    pub fn ancestors(self) -> impl Iterator<Item = Part<'t>> {
        std::iter::successors(Some(self), |part| part.parent())
    }

    /// The nodes and tokens directly in it.
    pub fn parts(self) -> impl Iterator<Item = Part<'t>> + Clone {
        let (mut next, end) = (self.at + 1, self.record().after);
        std::iter::from_fn(move || {
            let part = (next < end).then(|| self.with(next))?;
            next = part.record().after;
            Some(part)
        })
    }

    /// The nodes directly in it.
    pub fn nodes(self) -> impl Iterator<Item = Part<'t>> {
        self.parts().filter(|part| part.is_node())
    }

    /// It and all nodes and tokens in it, in the order of the text.
    pub fn all(self) -> impl DoubleEndedIterator<Item = Part<'t>> + ExactSizeIterator {
        (self.at..self.record().after).map(move |at| self.with(at))
    }

    /// All tokens in it, in the order of the text.
    pub fn tokens(self) -> impl DoubleEndedIterator<Item = Part<'t>> {
        self.all().filter(|part| !part.is_node())
    }

    /// The first token in it.
    pub fn first_token(self) -> Option<Part<'t>> {
        self.tokens().next()
    }

    /// The last token in it, if nothing that is missing stands behind it.
    pub fn last_token(self) -> Option<Part<'t>> {
        self.all().next_back().filter(|part| !part.kind().is_node())
    }

    /// Its last node or token.
    pub fn last_part(self) -> Option<Part<'t>> {
        // The last record in it, or what is directly in this one and holds that.
        let last = self.with(self.record().after - 1);
        last.ancestors().take_while(|part| part.at > self.at).last()
    }

    /// The node or token before it in the same node.
    pub fn previous(self) -> Option<Part<'t>> {
        let parent = self.parent()?.at;
        let before = self.with(self.at - 1);
        before.ancestors().take_while(|part| part.at > parent).last()
    }

    /// The token before it in the text.
    pub fn previous_token(self) -> Option<Part<'t>> {
        (0..self.at).rev().map(|at| self.with(at)).find(|part| !part.is_node())
    }

    /// The token behind it in the text.
    pub fn next_token(self) -> Option<Part<'t>> {
        (self.record().after..self.list.len() as u32).map(|at| self.with(at)).find(|part| !part.is_node())
    }
}

impl<'t> Part<'t> {
    /// The token that holds the byte at an offset; behind the end of the text, the last one. Nothing where there is no text.
    pub fn token_at(self, offset: u32) -> Option<Part<'t>> {
        let mut at = self;
        while at.is_node() {
            let behind = |part: &Part<'t>| part.span().start <= offset;
            let holds = |part: &Part<'t>| !part.span().is_empty();
            at = at.parts().take_while(behind).filter(holds).last()?;
        }
        Some(at)
    }

    /// The token at an offset that people would say the cursor is on: of two that meet there, the one that is a word.
    pub fn word_at(self, offset: u32) -> Option<Part<'t>> {
        let here = self.token_at(offset);
        let before =
            offset.checked_sub(1).and_then(|before| self.token_at(before)).filter(|token| offset <= token.span().end);
        let is_word = |token: &Part<'t>| {
            use SyntaxKind::*;
            let kind = token.kind();
            kind.is_keyword() || matches!(kind, Path | Ident | KeyName | Boolean | Color | Unit | Digits | String)
        };
        here.filter(is_word).or(before.filter(is_word)).or(here).or(before)
    }
}
