//! What must stand between two things.

use super::*;
use crate::diagnostic::Applicability::Safe;

impl Finder<'_> {
    /// `(1 2)`
    pub(super) fn no_comma(&mut self, node: Part<'_>) {
        let at = node.span().end;
        if let Some(bad) = self.bad_after(at) {
            return self.bad_with(bad, None);
        }
        if node.parent().is_some_and(|bracket| is_unclosed(bracket)) || self.is_lost(at) {
            return;
        }
        let found = self.error("E0118", "expected `,` between values", self.gap(at), "no `,` here");
        self.push(found.fix(Safe, "insert `,`", self.file(), Span::at(at), ","));
    }

    /// Whether unread text is in a list that was meant to end on a line before it.
    pub(super) fn runs_on(&self, token: Part<'_>) -> bool {
        if token.kind() != SyntaxKind::BadElem || super::bad::open_quote(token.text()).is_some() {
            return false;
        }
        let Some(bracket) = token.parent().filter(|bracket| is_unclosed(*bracket)) else { return false };
        let first_line = self.source.line_index(bracket.span().start);
        self.source.line_index(token.span().start) > first_line
    }

    /// `radius: 1 position: 2` on one line
    pub(super) fn separators(&mut self, block: Part<'_>) {
        let mut previous: Option<Part<'_>> = None;
        for part in block.parts() {
            match part.kind() {
                SyntaxKind::Whitespace | SyntaxKind::BlockComment if !part.text().contains('\n') => {}
                kind if kind.is_node() => {
                    if let Some(first) = previous.filter(|first| !self.value_is_next(*first, part)) {
                        self.no_separator(first.kind(), kind, first.span().end);
                    }
                    // Behind a brace it is plain where an item ends, unless the brace belongs to a value.
                    let needs_end = match part.last_token().map(Part::kind) {
                        Some(SyntaxKind::CloseBrace) => kind == SyntaxKind::Property,
                        Some(_) => kind.is_item(),
                        None => false,
                    };
                    previous = needs_end.then_some(part);
                }
                _ => previous = None,
            }
        }
    }

    /// `let r =` and, on the next line, `sphere ball { }`, whose first word was taken for the value; E0108.
    fn value_is_next(&mut self, first: Part<'_>, second: Part<'_>) -> bool {
        use SyntaxKind::{Colon, EqProperty, Equals, LetDecl, Node, ParamDecl, Property};
        let is_kind = matches!(first.kind(), LetDecl | ParamDecl | Property | EqProperty) && second.kind() == Node;
        let Some(value) = parts(first).last().filter(|value| is_kind && value.kind().is_value()).map(Part::span) else {
            return false;
        };
        let sign = parts(first).filter(|part| matches!(part.kind(), Colon | Equals)).last().map(Part::span);
        let Some(sign) = sign.filter(|sign| self.source.line_index(sign.end) < self.source.line_index(value.start))
        else {
            return false;
        };
        let Some(name) = parts(first).find(|part| part.span().start >= first.span().start && !is_word(*part)) else {
            return false;
        };
        let name = self.text(name.span()).trim_matches('"').to_string();
        let head = Span::new(value.start, second.first_token().map_or(value.end, |kind| kind.span().end));
        let found = self
            .error("E0108", format!("missing value for `{name}`"), Span::at(sign.end), "expected a value")
            .label(self.file(), head, "this is the next item")
            .help(format!("write a value behind the `{}`", self.text(sign)));
        self.push(found);
        true
    }

    fn no_separator(&mut self, first: SyntaxKind, second: SyntaxKind, at: u32) {
        let is_property = |kind| matches!(kind, SyntaxKind::Property | SyntaxKind::EqProperty);
        let what = if is_property(first) && is_property(second) { "properties" } else { "items" };
        let message = format!("expected a new line or `,` between {what}");
        let found = self.error("E0118", message, self.gap(at), "nothing separates them");
        self.push(found.fix(Safe, "insert `,`", self.file(), Span::at(at), ","));
    }

    /// The spaces at an offset.
    fn gap(&self, at: u32) -> Span {
        let rest = self.text(Span::new(at, self.source.len()));
        Span::new(at, at + (rest.len() - rest.trim_start_matches([' ', '\t']).len()) as u32)
    }

    /// A block that belongs to nothing, unless what is before it on its line is reported already.
    pub(super) fn orphan(&mut self, block: Part<'_>) {
        let is_item = |parent: Part<'_>| {
            use SyntaxKind::*;
            matches!(parent.kind(), File | Block | Arm | KeyBlock)
        };
        if !block.parent().is_some_and(is_item) {
            return;
        }
        let mut at = before(block);
        while let Some(part) = at {
            if part.kind().is_error() {
                return;
            }
            at = part.last_part();
        }
        let start = block.span().start;
        if self.braced.contains(&start) {
            return;
        }
        let found =
            self.error("E0127", "this block belongs to nothing", Span::new(start, start + 1), "no kind before it");
        self.push(found.help("write what it is before it: `sphere ball { ... }`"));
    }
}

/// Whether it is the word that a declaration begins with.
fn is_word(part: Part<'_>) -> bool {
    matches!(part.kind(), SyntaxKind::KwLet | SyntaxKind::KwParam)
}

fn is_unclosed(bracket: Part<'_>) -> bool {
    bracket.last_part().is_some_and(|last| last.kind() == SyntaxKind::Unclosed)
}
