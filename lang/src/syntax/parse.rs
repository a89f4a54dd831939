//! Text to tree. The parser behind it is pest, and nothing outside this module knows.
//!
//! pest gives the beginning and end of each rule; the builder walks them in order and turns the text between them into
//! tokens of its own, so that the leaves of the tree joined are the text, whatever the text is.

use super::grammar::{Grammar, Rule};
use super::kind::{Kinora, SyntaxKind, of_rule};
use super::scan;
use pest::{Parser, Token};
use rowan::{GreenNode, GreenNodeBuilder, Language};

/// The tree of a text, and where parsing stopped if it had to: at the bracket that is nested too deep.
pub(super) struct Green {
    pub node: GreenNode,
    pub stopped: Option<u32>,
    /// Whether some text could not be read, or a comment may be open to the end.
    pub has_bad: bool,
}

/// Parses a whole file, or one value as after `-D name=`.
pub(super) fn green(text: &str, one_value: bool) -> Green {
    let (rule, root) = match one_value {
        true => (Rule::one_value, SyntaxKind::OneValue),
        false => (Rule::file, SyntaxKind::File),
    };
    let stopped = scan::too_deep(text);
    let good = &text[..stopped.unwrap_or(text.len())];
    let mut builder = Builder { builder: GreenNodeBuilder::new(), text, at: 0, open: Vec::new(), has_bad: false };
    // The grammar matches every text; what remains is pest's guard of the stack, on a thread with a very small one.
    let stopped = match Grammar::parse(rule, good) {
        Ok(pairs) => {
            for token in pairs.tokens() {
                match token {
                    Token::Start { rule, pos } => builder.start(rule, pos.pos()),
                    Token::End { rule, pos } => builder.end(rule, pos.pos(), root),
                }
            }
            stopped
        }
        Err(_) => {
            builder.builder.start_node(Kinora::kind_to_raw(root));
            builder.bad_text();
            builder.builder.finish_node();
            Some(0)
        }
    };
    let has_bad = builder.has_bad;
    Green { node: builder.builder.finish(), stopped: stopped.map(|offset| offset as u32), has_bad }
}

struct Builder<'a> {
    builder: GreenNodeBuilder<'static>,
    text: &'a str,
    at: usize,
    open: Vec<SyntaxKind>,
    has_bad: bool,
}

impl Builder<'_> {
    fn start(&mut self, rule: Rule, offset: usize) {
        let Some((kind, is_token)) = of_rule(rule) else { return };
        self.gap(offset);
        if !is_token {
            self.builder.start_node(Kinora::kind_to_raw(kind));
            self.open.push(kind);
        }
    }

    fn end(&mut self, rule: Rule, offset: usize, root: SyntaxKind) {
        match of_rule(rule) {
            Some((kind, true)) => self.token(kind, offset),
            Some((kind, false)) => {
                self.gap(offset);
                if kind == root {
                    self.bad_text();
                }
                self.builder.finish_node();
                self.open.pop();
            }
            None => {}
        }
    }

    fn token(&mut self, kind: SyntaxKind, end: usize) {
        if end > self.at {
            use SyntaxKind::{BadElem, BadItem, BadString, BlockComment};
            let reaches_end = end == self.text.len();
            self.has_bad |= matches!(kind, BadItem | BadElem | BadString) || kind == BlockComment && reaches_end;
            self.builder.token(Kinora::kind_to_raw(kind), &self.text[self.at..end]);
            self.at = end;
        }
    }

    fn bad_text(&mut self) {
        self.token(SyntaxKind::BadText, self.text.len());
    }

    /// Tokens for what the grammar matched without a rule of its own.
    fn gap(&mut self, end: usize) {
        if self.open.last() == Some(&SyntaxKind::Number) {
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
