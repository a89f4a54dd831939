//! Brackets that do not match. The parser knows that one is missing; the indentation tells where.

use super::*;
use crate::diagnostic::Applicability::{Maybe, Safe};

/// How many things before a stray `}` are looked at, and how many parts of them for all strays together: what is far above
/// is no evidence.
const STRAY_SEARCH: usize = 64;
const STRAY_PARTS: usize = 1_000_000;

/// The brackets in a text that starts at an offset.
pub(super) fn brackets_in(text: &str, start: u32) -> impl Iterator<Item = (u32, char)> {
    text.char_indices()
        .filter(|(_, sign)| matches!(sign, '(' | ')' | '[' | ']' | '{' | '}'))
        .map(move |(at, sign)| (start + at as u32, sign))
}

impl Finder<'_> {
    pub(super) fn unclosed(&mut self, node: Part<'_>) {
        let at = node.span().end;
        let (false, Some(bracket)) = (self.is_lost(at), node.parent()) else { return };
        let open = bracket.parts().filter(|part| {
            matches!(part.kind(), SyntaxKind::OpenBrace | SyntaxKind::OpenParen | SyntaxKind::OpenBracket)
        });
        let Some(open) = open.map(Part::span).next() else { return };
        let close = match self.text(open) {
            "{" => '}',
            "[" => ']',
            _ => ')',
        };
        let inside = bracket.span();
        let first = self.swallowed.partition_point(|(at, _)| *at < inside.start);
        let mut swallowed = self.swallowed.iter().skip(first).take_while(|(at, _)| *at < inside.end);
        if swallowed.any(|(_, sign)| *sign == close) {
            return;
        }
        match self.text(open) {
            "{" if bracket.kind() == SyntaxKind::Names => self.unclosed_bracket("E0101", "{", "}", open, bracket),
            "{" => self.unclosed_brace(bracket),
            "[" => self.unclosed_bracket("E0104", "[", "]", open, bracket),
            _ => self.unclosed_bracket("E0103", "(", ")", open, bracket),
        }
    }

    fn unclosed_bracket(&mut self, code: &'static str, sign: &str, close: &str, open: Span, bracket: Part<'_>) {
        let mut last = open;
        for part in parts(bracket) {
            // What follows a missing comma does not belong to the bracket any more.
            if matches!(part.kind(), SyntaxKind::NoComma | SyntaxKind::Unclosed) {
                break;
            }
            // The comma before it stays outside: `(1, 2,` closes behind the `2`.
            if part.kind() != SyntaxKind::Comma {
                last = part.span();
            }
        }
        let message = format!("this `{sign}` is never closed");
        let found = self.error(code, message, open, "opened here");
        let help = match last == open {
            true => format!("add `{close}`"),
            false => format!("add `{close}` after `{}`", excerpt(self.text(last))),
        };
        let line = self.source.line_span(self.source.line_index(last.end));
        let next = self.text(Span::new(last.end, line.end)).trim_start();
        // What follows on the line would then be an item of its own.
        let insert = match close {
            "}" => " }".to_string(),
            _ if next.starts_with(unicode_ident::is_xid_start) => format!("{close},"),
            _ => close.to_string(),
        };
        self.push(found.fix(Safe, help, self.file(), Span::at(last.end), insert));
    }

    fn unclosed_brace(&mut self, block: Part<'_>) {
        let suspect = block.all().find(|inner| self.closes_askew(*inner));
        let block = suspect.unwrap_or(block);
        let Some(open) = brace(block, SyntaxKind::OpenBrace) else { return };
        let mut found = self.error("E0101", "this `{` is never closed", open, "opened here");
        let line = self.source.line_index(open.start);
        let indent = self.indent(line).unwrap_or_default();
        let end = self.source.line_index(block.span().end);
        let mut inside = line;
        let mut outside = None;
        for next in line + 1..=end {
            let text = self.text(self.source.line_span(next)).trim_start();
            match self.indent(next) {
                Some(width) if width <= indent && !text.starts_with("//") => {
                    outside = Some(next);
                    break;
                }
                Some(_) => inside = next,
                None => {}
            }
        }
        let margin = self.text(self.source.line_span(line));
        let margin = &margin[..margin.len() - margin.trim_start().len()];
        let place = Span::at(self.code_end(inside));
        let insert = if inside == line { " }".to_string() } else { format!("\n{margin}}}") };
        if let Some(next) = outside.filter(|next| self.starts_item(*next)) {
            let word = self.first_word(next);
            found = found.label(self.file(), word, "by the indentation, the block ends before this");
            found = found.fix(Safe, format!("add `}}` before line {}", next + 1), self.file(), place, insert);
        } else {
            let applicability = if outside.is_none() { Safe } else { Maybe };
            found = found.fix(applicability, "add `}`", self.file(), place, insert);
        }
        self.push(found);
    }

    pub(super) fn stray_close(&mut self, token: Part<'_>) {
        let start = token.span().start;
        if self.swallowed_brace.is_some_and(|at| at < start) {
            return;
        }
        let mut found = self.error("E0102", "unmatched `}`", token.span(), "closes nothing").help("remove it");
        // Properties right before it belong to a block that was closed above them.
        let above = std::iter::successors(token.previous(), |part| part.previous());
        let mut above = above.take(STRAY_SEARCH).filter(|part| part.is_node()).peekable();
        if above.peek().is_some_and(|part| part.kind() == SyntaxKind::Property)
            && let Some(node) = above.find(|part| part.kind() != SyntaxKind::Property)
            && let Some(close) = node.last_token().filter(|close| close.kind() == SyntaxKind::CloseBrace)
        {
            let found = found.label(self.file(), close.span(), "this closes the block too early");
            return self.push(found.help("or remove the one that closes too early"));
        }
        let mut at = token.previous();
        let mut steps = 0;
        while let Some(part) = at.filter(|_| steps < STRAY_SEARCH) {
            at = part.previous();
            steps += 1;
            self.searched += part.all().len();
            if self.searched > STRAY_PARTS {
                break;
            }
            if let Some(early) = part.all().rfind(|block| self.closes_askew(*block)) {
                if let Some(close) = brace(early, SyntaxKind::CloseBrace) {
                    found = found.label(self.file(), close, "by the indentation, this closes a block too early");
                }
                break;
            }
        }
        self.push(found);
    }

    /// Whether a block's `}` starts a line at another column than the line of its `{`.
    fn closes_askew(&self, block: Part<'_>) -> bool {
        let (Some(open), Some(close)) = (brace(block, SyntaxKind::OpenBrace), brace(block, SyntaxKind::CloseBrace))
        else {
            return false;
        };
        let (first, last) = (self.source.line_index(open.start), self.source.line_index(close.start));
        first != last && self.first_word(last).start == close.start && self.indent(first) != self.indent(last)
    }

    /// Columns before the first word of a line; nothing for an empty one. A tab counts as four.
    fn indent(&self, line: u32) -> Option<usize> {
        let text = self.text(self.source.line_span(line));
        let margin = &text[..text.len() - text.trim_start().len()];
        (margin.len() < text.len()).then(|| margin.chars().map(|space| if space == '\t' { 4 } else { 1 }).sum())
    }

    fn first_word(&self, line: u32) -> Span {
        let span = self.source.line_span(line);
        let text = self.text(span);
        let start = span.start + (text.len() - text.trim_start().len()) as u32;
        let word = text.trim_start().chars().take_while(|character| character.is_alphanumeric() || *character == '_');
        let length: usize = word.map(char::len_utf8).sum();
        Span::new(start, (start + length.max(1) as u32).min(span.end))
    }

    fn starts_item(&self, line: u32) -> bool {
        self.text(self.first_word(line)).starts_with(|character: char| character.is_alphabetic() || character == '_')
    }

    /// The end of a line's text without a `//` comment.
    fn code_end(&self, line: u32) -> u32 {
        let span = self.source.line_span(line);
        let text = self.text(span);
        let code = text.split("//").next().unwrap_or(text).trim_end();
        if code.is_empty() || code.matches('"').count() % 2 == 1 { span.end } else { span.start + code.len() as u32 }
    }
}

fn brace(block: Part<'_>, kind: SyntaxKind) -> Option<Span> {
    block.parts().find(|part| part.kind() == kind).map(Part::span)
}
