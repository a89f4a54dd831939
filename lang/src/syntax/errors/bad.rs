//! Text that no rule could read: which mistake is it most likely?

use super::confusable::confusable;
use super::missing::{Missing, is_keyword};
use super::*;
use crate::diagnostic::Applicability::{Maybe, Safe};
use crate::diagnostic::Edit;
use crate::syntax::scan;
use unicode_ident::{is_xid_continue, is_xid_start};

impl Finder<'_> {
    /// Unread text behind something that is missing: one mistake, not two. `missing` is reported unless the text says more.
    pub(super) fn bad_with(&mut self, bad: Bad, missing: Option<Missing>) {
        self.merged.insert(bad.span.start);
        let span = self.trimmed(bad.span);
        let text = self.text(span);
        if self.confusables(span)
            || self.open_string(span)
            || self.single_equals(span, text, missing.as_ref(), bad.is_elem)
            || missing.is_none() && !bad.is_elem && self.nameless_vector(span, text)
            || self.literal(span, text)
            || self.name(span, text, missing.as_ref())
        {
            return;
        }
        match missing {
            Some(missing) => self.push(missing.found),
            None if bad.is_elem => self.element(span, text),
            None => self.item(span, text),
        }
    }

    /// `“quotes”`, `2 × 3`
    fn confusables(&mut self, span: Span) -> bool {
        let text = self.text(span);
        let mut first = None;
        let mut edits = Vec::new();
        let mut at = 0;
        while let Some(character) = text.get(at..).and_then(|rest| rest.chars().next()) {
            let end = at + character.len_utf8();
            if character == '"' {
                (at, _) = scan::string_end(text.as_bytes(), at);
                continue;
            }
            if let Some((insert, what)) = confusable(character) {
                let place = Span::new(span.start + at as u32, span.start + end as u32);
                first = first.or(Some((place, character, insert, what)));
                edits.push(Edit { file: self.file(), span: place, insert: insert.to_string() });
            }
            at = end;
        }
        let Some((place, character, insert, what)) = first else { return false };
        let shown = match what {
            "a space" => format!("U+{:04X}", u32::from(character)),
            _ => character.to_string(),
        };
        let help = match what {
            "a space" => "replace it with a space".to_string(),
            _ => format!("replace it with `{insert}`"),
        };
        let found = self
            .error("E0121", format!("`{shown}` is not {what}"), place, "looks like it, but is another character")
            .fix_edits(Safe, help, edits);
        self.push_urgent(found);
        true
    }

    /// A quote without its partner somewhere in the text.
    fn open_string(&mut self, span: Span) -> bool {
        match open_quote(self.text(span)) {
            Some(at) => self.bad_string(Span::new(span.start + at as u32, span.end)),
            None => return false,
        }
        true
    }

    /// `euler(x = 30deg)`, `if a = 2 {`
    fn single_equals(&mut self, span: Span, text: &str, missing: Option<&Missing>, is_elem: bool) -> bool {
        let Some(rest) = text.strip_prefix('=').filter(|rest| !rest.starts_with('=')) else { return false };
        let value = Span::new(span.start, span.end - rest.trim_start().len() as u32);
        let sign = Span::new(span.start, span.start + 1);
        let before = self.text(Span::new(0, span.start)).trim_end();
        let gap = Span::new(before.len() as u32, value.end);
        let found = match missing {
            Some(missing) if missing.found.message.ends_with("after the condition") => missing
                .found
                .clone()
                .primary(self.file(), sign, "does not compare")
                .fix(Safe, "two values are compared with `==`", self.file(), sign, "=="),
            None if is_elem && before.ends_with(is_xid_continue) && !rest.trim().is_empty() => self
                .error("E0106", "arguments use `:`, not `=`", sign, "use `:`")
                .fix(Safe, "use `:`", self.file(), gap, ": "),
            _ => return false,
        };
        self.push(found);
        true
    }

    /// `sphere { <0, 1, 0>, 2 }`: what POV-Ray's shapes begin with has a name here.
    fn nameless_vector(&mut self, span: Span, text: &str) -> bool {
        let Some(end) = text.strip_prefix('<').and_then(|rest| rest.find('>')) else { return false };
        let Some(written) = text.get(1..1 + end).map(super::shape::written_vector) else { return false };
        let found = self
            .error(
                "E0125",
                "vectors are written `(0, 1, 0)`",
                Span::new(span.start, span.start + 1),
                "`<` compares two values",
            )
            .help(format!("every value has a name here: `position: {written}`"));
        self.push(found);
        true
    }

    /// `#12g`, `.5`, `<0, 1, 0>`, a bracket that closes nothing
    fn literal(&mut self, span: Span, text: &str) -> bool {
        let mut rest = text.chars();
        let sign = rest.next();
        let next = rest.next();
        match (sign, next) {
            (Some('#'), _) => {
                let digits = text[1..].find(|digit: char| !is_xid_continue(digit)).unwrap_or(text.len() - 1);
                let odd = text[1..1 + digits].chars().find(|digit| !digit.is_ascii_hexdigit());
                let label = odd.map_or("no digits".to_string(), |odd| format!("`{odd}` is not a digit of base 16"));
                self.bad_color(Span::new(span.start, span.start + 1 + digits as u32), label);
            }
            (Some('.'), Some('0'..='9')) => self.bare_point(span, text, 0),
            (Some('-'), Some('.')) if text[2..].starts_with(|digit: char| digit.is_ascii_digit()) => {
                self.bare_point(span, text, 1)
            }
            (Some('<'), Some(after)) if after == '-' || after == '.' || after == ' ' || after.is_alphanumeric() => {
                self.angle_vector(span.start)
            }
            (Some(close @ (')' | ']')), _) => {
                let span = Span::new(span.start, span.start + 1);
                let found =
                    self.error("E0102", format!("unmatched `{close}`"), span, "closes nothing").help("remove it");
                self.push(found);
            }
            _ => return false,
        }
        true
    }

    /// `.5`
    fn bare_point(&mut self, span: Span, text: &str, point: usize) {
        let length = text[point + 1..].find(|digit: char| !(is_xid_continue(digit) || digit == '%'));
        let end = length.map_or(text.len(), |length| point + 1 + length);
        let written = format!("{}0{}", &text[..point], &text[point..end]);
        let place = Span::new(span.start, span.start + end as u32);
        let found = self
            .error("E0116", "numbers need a digit on both sides of the point", place, "no digit before the point")
            .fix(Safe, format!("write `{written}`"), self.file(), Span::at(span.start + point as u32), "0");
        self.push(found);
    }

    /// Names that cannot be names: `3rd`, `my-ball`, `for`. Also `elseif`.
    fn name(&mut self, span: Span, text: &str, missing: Option<&Missing>) -> bool {
        let (first, rest) = split_name(text);
        let word = Span::new(span.start, span.start + first.len() as u32);
        if super::shape::is_else_if(first) {
            self.write_else_if(word);
            return true;
        }
        let wants_name = missing.is_some_and(|missing| missing.wants_name);
        if missing.is_some() && !wants_name {
            return false;
        }
        let before_block = self.text(Span::new(span.end, self.source.len())).trim_start().starts_with('{');
        let heads =
            |rest: &str| before_block && rest.trim().is_empty() || rest.trim_start().starts_with([':', '=', '{', '(']);
        if starts_digit(first) && (heads(rest) || wants_name) {
            self.digit_name(word, first);
            return true;
        }
        if is_dashed(first) && heads(rest.trim_start_matches(|next: char| next == ' ' || is_xid_continue(next))) {
            self.dashed_name(word);
            return true;
        }
        // `sphere 3rd {`: the second word is the name.
        let (second, after) = split_name(rest.trim_start());
        let start = span.start + (text.len() - rest.trim_start().len()) as u32;
        let second_word = Span::new(start, start + second.len() as u32);
        if !before_block || is_keyword(first) || !first.starts_with(is_xid_start) || !after.trim().is_empty() {
            return false;
        }
        if starts_digit(second) {
            self.digit_name(second_word, second);
        } else if is_dashed(second) {
            self.dashed_name(second_word);
        } else if is_keyword(second) {
            self.keyword_as_name(second_word);
        } else {
            return false;
        }
        true
    }

    fn digit_name(&mut self, span: Span, name: &str) {
        let digits = name.find(|digit: char| !digit.is_ascii_digit()).unwrap_or(name.len());
        let (digits, rest) = name.split_at(digits);
        let other = match rest.trim_start_matches('_') {
            "" => format!("n{digits}"),
            rest => format!("{}_{digits}", rest.replace('-', "_")),
        };
        let found = self
            .error("E0112", "a name cannot start with a digit", span, "starts with a digit")
            .help(format!("write `{other}` or `\"{name}\"`"));
        self.push(found);
    }

    /// The rest of a line that starts no item.
    fn item(&mut self, span: Span, text: &str) {
        let (word, rest) = split_name(text);
        let is_name = word.starts_with(|first: char| is_xid_start(first) || first == '_') && !is_dashed(word);
        let name_span = Span::new(span.start, span.start + word.len() as u32);
        let value = rest.trim_start();
        if word == "else" {
            let found = self.error("E0127", "`else` without `if`", name_span, "no `if` before it");
            return self.push(found.help("put it right behind the `}` of the `if`"));
        }
        if is_name && units::UNITS.contains(&word) && value.is_empty() && self.number_before(span.start) {
            let spaces = Span::new(self.text(Span::new(0, span.start)).trim_end().len() as u32, span.start);
            let found =
                self.error("E0127", format!("unexpected `{word}`"), name_span, "a unit stands right behind its number");
            let found = found.fix(Safe, "remove the space", self.file(), spaces, "");
            return self.push(found);
        }
        if !is_name || is_keyword(word) {
            return self.unexpected(span, text);
        }
        let gap = Span::new(name_span.end, name_span.end + (rest.len() - value.len()) as u32);
        let is_value = value.starts_with(|first: char| is_xid_continue(first) || "\"#([-{!".contains(first));
        let message = format!("expected `:` after `{word}`");
        let found = match value {
            "" => self.error(
                "E0105",
                format!("expected `:` or `{{` after `{word}`"),
                Span::at(name_span.end),
                "expected `:` or `{`",
            ),
            _ if !is_value => return self.unexpected(span, text),
            _ => {
                let colon = if gap.is_empty() { ": " } else { ":" };
                let help = format!("write `{word}: {}`", excerpt(value));
                let is_word = value.starts_with(|first: char| is_xid_start(first) || first == '_');
                let applicability = if is_word { Maybe } else { Safe };
                let found = self.error("E0105", message, gap, "expected `:`");
                found.fix(applicability, help, self.file(), Span::at(name_span.end), colon)
            }
        };
        self.push(found);
    }

    fn unexpected(&mut self, span: Span, text: &str) {
        if let Some(at) = text.find("*/") {
            let place = Span::new(span.start + at as u32, span.start + at as u32 + 2);
            let found = self.error("E0127", "unexpected `*/`", place, "no comment is open here");
            return self.push(found.help("comments do not nest: the first `*/` ends one"));
        }
        let (word, _) = split_name(text);
        let length = word.len().max(text.chars().next().map_or(0, char::len_utf8));
        let place = Span::new(span.start, span.start + length as u32);
        let word = self.text(place);
        let found = match is_keyword(word) {
            true => self.error("E0127", format!("`{word}` cannot stand here"), place, "a keyword"),
            false => self.error("E0127", format!("unexpected `{word}`"), place, "starts nothing"),
        };
        let help = match self.value_before(span.start) {
            true => "put `,`, an operator or a new line before it",
            false => "a line is `name: value`, `kind name { ... }` or a declaration",
        };
        self.push(found.help(help));
    }

    /// Text between two commas that is no value.
    fn element(&mut self, span: Span, text: &str) {
        let length = text.chars().next().map_or(0, char::len_utf8).max(split_name(text).0.len());
        let place = Span::new(span.start, span.start + length as u32);
        let word = self.text(place);
        let found = self.error("E0127", format!("unexpected `{word}`"), place, "not a value");
        self.push(match word {
            ";" => found.fix(Maybe, "separate values with `,`", self.file(), place, ","),
            _ => found.help("values in brackets are separated by `,`"),
        });
    }

    /// Whether something that may be a value ends before the offset on its line.
    fn value_before(&self, offset: u32) -> bool {
        let line = self.text(Span::new(self.source.line_start(self.source.line_index(offset)), offset));
        line.trim_end().ends_with(|last: char| is_xid_continue(last) || "\")]%".contains(last))
    }

    /// Whether a number is right before the offset on its line.
    fn number_before(&self, offset: u32) -> bool {
        let line = self.text(Span::new(self.source.line_start(self.source.line_index(offset)), offset));
        line.trim_end().ends_with(|last: char| last.is_ascii_digit())
    }
}

/// Where a string opens that never closes.
pub(super) fn open_quote(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(next) = text.get(at..).and_then(|rest| rest.find(['"', '/'])) {
        let start = at + next;
        at = match &bytes[start..] {
            [b'/', b'/', ..] => scan::line_end(bytes, start),
            [b'/', b'*', ..] => scan::comment_end(bytes, start),
            [b'/', ..] => start + 1,
            _ => match scan::string_end(bytes, start) {
                (end, true) => end,
                (_, false) => return Some(start),
            },
        };
    }
    None
}

/// The text up to the first character that is neither of a name nor `-` within one, and the rest.
fn split_name(text: &str) -> (&str, &str) {
    let end = text.find(|next: char| !(is_xid_continue(next) || next == '-')).unwrap_or(text.len());
    let (word, _) = text.split_at(end);
    text.split_at(word.trim_end_matches('-').len())
}

fn starts_digit(word: &str) -> bool {
    word.starts_with(|first: char| first.is_ascii_digit())
}

/// `my-ball`, but not `-ball`
fn is_dashed(word: &str) -> bool {
    word.starts_with(|first: char| is_xid_start(first) || first == '_') && word.contains('-')
}
