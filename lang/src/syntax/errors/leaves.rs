//! Mistakes inside a leaf: strings, comments, colours, units, characters.

use super::*;
use crate::diagnostic::Applicability::{Maybe, Safe};
use crate::syntax::scan;
use crate::syntax::text::unescape;

/// Where a comment opens in unread text, or in a comment token, that never closes.
pub(super) fn open_comment(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let next = bytes.get(at + 1);
        match byte {
            b'"' => (at, _) = scan::string_end(bytes, at),
            b'/' if next == Some(&b'/') => at = scan::line_end(bytes, at),
            b'/' if next == Some(&b'*') => {
                let end = scan::comment_end(bytes, at);
                if end < at + 4 || !text[..end].ends_with("*/") {
                    return Some(at);
                }
                at = end;
            }
            _ => at += 1,
        }
    }
    None
}

/// Characters that are not seen, or that change what is seen, anywhere in the text.
pub(super) fn control_characters(finder: &mut Finder<'_>, inside: Span) {
    lone_returns(finder, inside);
    let text = finder.text(inside);
    let plain = |byte: u8| matches!(byte, b'\t'..=b'\r' | b' '..=b'~');
    if text.bytes().all(plain) {
        return;
    }
    for (at, character) in text.char_indices() {
        let at = inside.start as usize + at;
        let is_control = match character {
            '\t'..='\r' => false,
            '\0'..'\u{20}' | '\u{7F}'..'\u{A0}' => true,
            other => is_bidi(other),
        };
        if is_control {
            if finder.found.len() >= MOST {
                return;
            }
            let span = Span::new(at as u32, (at + character.len_utf8()) as u32);
            let message = format!("control character U+{:04X} in source", u32::from(character));
            let mut found = finder.error("E0120", message, span, "this character").help("remove it");
            if is_bidi(character) {
                found = found.note("it changes the order in which text is shown, so the scene is not what it seems");
            }
            finder.push_urgent(found);
        }
    }
}

/// Carriage returns that end no line: a comment would go on behind them unseen. Behind the last one of a text nothing does.
fn lone_returns(finder: &mut Finder<'_>, inside: Span) {
    let text = finder.text(inside);
    if !text.contains('\r') {
        return;
    }
    let bytes = text.as_bytes();
    let ends = (finder.source.len() - inside.start) as usize;
    let is_lone = |at: &usize| bytes[*at] == b'\r' && bytes.get(at + 1) != Some(&b'\n') && at + 1 != ends;
    let (mut lone, place) = ((0..bytes.len()).filter(is_lone), |at: usize| inside.start + at as u32);
    let Some(first) = lone.next() else { return };
    let last = lone.next_back().unwrap_or(first);
    // One edit, as there may be millions of them.
    let put: Vec<String> = text[first..=last].split("\r\n").map(|part| part.replace('\r', "\n")).collect();
    let found = finder.error(
        "E0120",
        "a carriage return ends no line by itself",
        Span::new(place(first), place(first) + 1),
        if last == first { "here" } else { "here, and more of them below" },
    );
    let whole = Span::new(place(first), place(last) + 1);
    finder.push_urgent(found.fix(Safe, "end lines as `\\n` or `\\r\\n`", finder.file(), whole, put.join("\r\n")));
}

fn is_bidi(character: char) -> bool {
    matches!(character, '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
}

impl Finder<'_> {
    pub(super) fn block_comment(&mut self, token: Part<'_>) {
        if open_comment(token.text()).is_some() {
            self.open_comment(token.span().start);
        }
    }

    pub(super) fn open_comment(&mut self, start: u32) {
        let found = self.error("E0110", "unterminated comment", Span::new(start, start + 2), "no `*/` follows");
        self.push_urgent(found.help("close it with `*/`").note("comments do not nest: the first `*/` ends one"));
    }

    pub(super) fn string(&mut self, token: Part<'_>) {
        let start = token.span().start;
        // Of a line one is reported.
        if let Some(unknown) = unescape(token.text()).unknown.first() {
            let span = Span::new(start + unknown.start, start + unknown.end);
            let escape = self.text(span);
            let found = self.error("E0111", format!("unknown escape `{escape}`"), span, "means nothing");
            let found = match escape {
                "\\u" => found.help("write a character's code as `\\u{1F600}`"),
                _ => found.help("use `/` in paths; write `\\\\` for a backslash"),
            };
            self.push(found.note("escapes are `\\\"`, `\\\\`, `\\n`, `\\t` and `\\u{...}`"));
        }
    }

    pub(super) fn bad_string(&mut self, span: Span) {
        let line = self.source.line_span(self.source.line_index(span.start));
        let text = self.text(Span::new(span.start, line.end)).trim_end();
        let span = Span::new(span.start, span.start + text.len() as u32);
        let inside = text.trim_end_matches([' ', ',', ';', '(', ')', '[', ']', '{', '}']);
        let applicability = if inside.len() < text.len() || text.ends_with('\\') { Maybe } else { Safe };
        let end = span.start + inside.len() as u32;
        let found = self.error("E0109", "unterminated string", span, "no `\"` before the end of the line").fix(
            applicability,
            "add `\"`",
            self.file(),
            Span::at(end),
            "\"",
        );
        self.push_urgent(found);
    }

    pub(super) fn color(&mut self, token: Part<'_>) {
        let digits = token.text().len() - 1;
        if !matches!(digits, 3 | 6 | 8) {
            let label = if digits == 1 { "1 digit".to_string() } else { format!("{digits} digits") };
            self.bad_color(token.span(), label);
        }
    }

    pub(super) fn bad_color(&mut self, span: Span, label: String) {
        let message = "colours are `#rgb`, `#rrggbb` or `#rrggbbaa`";
        let found = self.error("E0117", message, span, label).help("for example `#d94` or `#d9402b`");
        self.push(found);
    }

    pub(super) fn bad_unit(&mut self, token: Part<'_>) {
        let span = token.span();
        let found = self.error("E0305", format!("unknown unit `{}`", token.text()), span, "not a unit");
        let found = match units::suggest(token.text()) {
            Some(unit) => found.fix(Safe, format!("did you mean `{unit}`?"), self.file(), span, unit),
            None => found.note(format!("units are {}", units::UNITS.join(" "))),
        };
        self.push(found);
    }

    pub(super) fn extra_comma(&mut self, span: Span) {
        let found = self.error("E0115", "extra comma", span, "no value before this comma");
        self.push(found.fix(Safe, "remove it", self.file(), span, ""));
    }

    pub(super) fn keyword_as_name(&mut self, span: Span) {
        let message = format!("`{}` is a keyword", self.text(span));
        let found = self.error("E0113", message, span, "cannot be a name").help("pick another name");
        self.push(found);
    }
}
