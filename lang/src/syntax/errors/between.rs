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
        let mut previous: Option<(SyntaxKind, u32)> = None;
        for part in block.parts() {
            let here = part.span();
            match part.kind() {
                SyntaxKind::Whitespace | SyntaxKind::BlockComment if !part.text().contains('\n') => {}
                kind if kind.is_node() => {
                    if let Some((first, end)) = previous {
                        self.no_separator(first, kind, end);
                    }
                    // Behind a brace it is plain where an item ends, unless the brace belongs to a value.
                    let needs_end = match part.last_token().map(Part::kind) {
                        Some(SyntaxKind::CloseBrace) => kind == SyntaxKind::Property,
                        Some(_) => kind.is_item(),
                        None => false,
                    };
                    previous = needs_end.then_some((kind, here.end));
                }
                _ => previous = None,
            }
        }
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
        let found =
            self.error("E0127", "this block belongs to nothing", Span::new(start, start + 1), "no kind before it");
        self.push(found.help("write what it is before it: `sphere ball { ... }`"));
    }
}

fn is_unclosed(bracket: Part<'_>) -> bool {
    bracket.last_part().is_some_and(|last| last.kind() == SyntaxKind::Unclosed)
}
