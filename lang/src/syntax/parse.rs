//! Text to tree. The parser behind it is pest, and nothing outside this module knows.
//!
//! pest gives the beginning and end of each rule; the builder walks them in order and turns the text between them into
//! tokens of its own, so that the leaves of the tree joined are the text, whatever the text is.

use super::grammar::{Grammar, Rule};
use super::kind::{SyntaxKind, of_rule};
use super::part::{Part, Record};
use super::scan;
use crate::source::Span;
use pest::{Parser, Token};

/// The tree of a text or of a piece of it.
#[derive(Debug, Clone)]
pub(super) struct Records {
    list: Vec<Record>,
    /// Whether some text could not be read, or a comment may be open to the end.
    pub has_bad: bool,
}

impl Records {
    /// The root; `text` is the whole text.
    pub fn root<'t>(&'t self, text: &'t str) -> Part<'t> {
        Part::root(text, &self.list)
    }
}

/// Parses the text under a span, as a file or as one value behind `-D name=`. Of that, what lies from `stop` on is kept
/// as one token.
pub(super) fn records(text: &str, span: Span, stop: u32, one_value: bool) -> Records {
    let (rule, root) = match one_value {
        true => (Rule::one_value, SyntaxKind::OneValue),
        false => (Rule::file, SyntaxKind::File),
    };
    let (start, end) = (span.start as usize, span.end as usize);
    let good = &text[start..(stop as usize).clamp(start, end)];
    let mut builder = Builder { list: Vec::new(), text, at: start, end, open: Vec::new(), has_bad: false };
    // The grammar matches every text.
    match Grammar::parse(rule, good) {
        Ok(pairs) => {
            for token in pairs.tokens() {
                match token {
                    Token::Start { rule, pos } => builder.start_rule(rule, start + pos.pos()),
                    Token::End { rule, pos } => builder.end_rule(rule, start + pos.pos(), root),
                }
            }
        }
        Err(_) => {
            builder.start_node(root);
            builder.bad_text();
            builder.end_node();
        }
    }
    Records { list: builder.list, has_bad: builder.has_bad }
}

struct Builder<'a> {
    list: Vec<Record>,
    text: &'a str,
    /// How far the tokens reach.
    at: usize,
    /// Where what is parsed ends.
    end: usize,
    open: Vec<u32>,
    has_bad: bool,
}

impl Builder<'_> {
    fn start_rule(&mut self, rule: Rule, offset: usize) {
        let Some(kind) = of_rule(rule) else { return };
        self.gap(offset);
        if kind.is_node() {
            self.start_node(kind);
        }
    }

    fn end_rule(&mut self, rule: Rule, offset: usize, root: SyntaxKind) {
        match of_rule(rule) {
            Some(kind) if kind.is_node() => {
                self.gap(offset);
                if kind == root {
                    self.bad_text();
                }
                self.end_node();
            }
            Some(kind) => self.token(kind, offset),
            None => {}
        }
    }

    fn push(&mut self, kind: SyntaxKind, end: usize) {
        let next = self.list.len() as u32;
        let parent = self.open.last().copied().unwrap_or(next);
        let span = Span::new(self.at as u32, end as u32);
        self.list.push(Record { kind, span, parent, after: next + 1 });
    }

    fn start_node(&mut self, kind: SyntaxKind) {
        self.push(kind, self.at);
        self.open.push(self.list.len() as u32 - 1);
    }

    fn end_node(&mut self) {
        let after = self.list.len() as u32;
        if let Some(node) = self.open.pop().and_then(|open| self.list.get_mut(open as usize)) {
            node.after = after;
            node.span.end = self.at as u32;
        }
    }

    fn token(&mut self, kind: SyntaxKind, end: usize) {
        if end > self.at {
            use SyntaxKind::{BadElem, BadItem, BadString, BlockComment};
            let reaches_end = end == self.end;
            self.has_bad |= matches!(kind, BadItem | BadElem | BadString) || kind == BlockComment && reaches_end;
            self.push(kind, end);
            self.at = end;
        }
    }

    fn bad_text(&mut self) {
        self.token(SyntaxKind::BadText, self.end);
    }

    /// Tokens for what the grammar matched without a rule of its own.
    fn gap(&mut self, end: usize) {
        if self.at == end {
            return;
        }
        let open = self.open.last().and_then(|open| self.list.get(*open as usize));
        if open.is_some_and(|open| open.kind == SyntaxKind::Number) {
            return self.token(SyntaxKind::Digits, end);
        }
        while self.at < end {
            let (kind, length) = first_token(&self.text[self.at..end]);
            self.token(kind, self.at + length);
        }
    }
}

fn first_token(text: &str) -> (SyntaxKind, usize) {
    use SyntaxKind::*;
    let bytes = text.as_bytes();
    let is_space = |byte: &u8| matches!(byte, b' ' | b'\t'..=b'\r');
    let one = |kind| (kind, 1);
    match bytes {
        [b'/', b'/', b'/', rest @ ..] if rest.first() != Some(&b'/') => (DocComment, scan::line_end(bytes, 0)),
        [b'/', b'/', ..] => (LineComment, scan::line_end(bytes, 0)),
        [b'/', b'*', ..] => (BlockComment, scan::comment_end(bytes, 0)),
        [b'-', b'>', ..] => (Arrow, 2),
        [b'{', ..] => one(OpenBrace),
        [b'}', ..] => one(CloseBrace),
        [b'(', ..] => one(OpenParen),
        [b')', ..] => one(CloseParen),
        [b'[', ..] => one(OpenBracket),
        [b']', ..] => one(CloseBracket),
        [b',', ..] => one(Comma),
        [b';', ..] => one(Semicolon),
        [b':', ..] => one(Colon),
        [b'=', ..] => one(Equals),
        [b'<', ..] => one(Less),
        [b'>', ..] => one(Greater),
        [b'.', ..] => one(Dot),
        [byte, ..] if is_space(byte) => {
            (Whitespace, bytes.iter().position(|byte| !is_space(byte)).unwrap_or(bytes.len()))
        }
        _ => {
            let length = text.chars().next().map_or(text.len(), char::len_utf8);
            (if text.starts_with('\u{FEFF}') { Bom } else { BadText }, length)
        }
    }
}
