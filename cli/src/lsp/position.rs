//! Places: bytes here, lines and columns in editors.

use kinora_lang::source::{Source, Span};
use lsp_types::{Position, PositionEncodingKind, Range};

/// What columns count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    Utf8,
    /// What every editor knows.
    #[default]
    Utf16,
}

impl Encoding {
    /// The one to speak with an editor that knows these.
    pub fn choose(known: Option<&[PositionEncodingKind]>) -> Encoding {
        match known.is_some_and(|known| known.contains(&PositionEncodingKind::UTF8)) {
            true => Encoding::Utf8,
            false => Encoding::Utf16,
        }
    }

    pub fn kind(self) -> PositionEncodingKind {
        match self {
            Encoding::Utf8 => PositionEncodingKind::UTF8,
            Encoding::Utf16 => PositionEncodingKind::UTF16,
        }
    }

    /// Where an offset is.
    pub fn position(self, source: &Source, offset: u32) -> Position {
        let offset = source.clamp(offset);
        let line = source.line_index(offset);
        // Behind the line's last letter, what ends it is not counted.
        let span = source.line_span(line);
        let before = Span::new(span.start, offset.min(span.end));
        let character = match self {
            Encoding::Utf8 => before.len(),
            Encoding::Utf16 => source.utf16_len(before),
        };
        Position { line, character }
    }

    /// How many columns a text has.
    pub fn len(self, text: &str) -> u32 {
        match self {
            Encoding::Utf8 => text.len() as u32,
            Encoding::Utf16 => text.chars().map(char::len_utf16).sum::<usize>() as u32,
        }
    }

    /// The offset of a place; behind the end of a line, that end.
    pub fn offset(self, source: &Source, position: Position) -> u32 {
        if position.line >= source.line_count() {
            return source.len();
        }
        let span = source.line_span(position.line);
        match self {
            Encoding::Utf8 => source.clamp(span.start.saturating_add(position.character).min(span.end)),
            Encoding::Utf16 => {
                let column = position.character.saturating_add(1);
                source.offset_utf16(position.line + 1, column)
            }
        }
    }

    pub fn range(self, source: &Source, span: Span) -> Range {
        Range { start: self.position(source, span.start), end: self.position(source, span.end) }
    }

    pub fn span(self, source: &Source, range: Range) -> Span {
        let start = self.offset(source, range.start);
        // An end before the start is taken as the start.
        Span::new(start, self.offset(source, range.end))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinora_lang::source::FileId;

    fn check(encoding: Encoding, text: &str, offset: u32, line: u32, character: u32) {
        let source = Source::new(FileId(0), "a.kin", text);
        let position = Position { line, character };
        assert_eq!(encoding.position(&source, offset), position, "{text:?} at {offset}");
        assert_eq!(encoding.offset(&source, position), source.clamp(offset), "{text:?} back to {offset}");
    }

    #[test]
    fn places() {
        for encoding in [Encoding::Utf8, Encoding::Utf16] {
            check(encoding, "", 0, 0, 0);
            check(encoding, "ab\r\ncd", 5, 1, 1);
            check(encoding, "ab\n", 3, 1, 0);
        }
        check(Encoding::Utf8, "é😀x", 6, 0, 6);
        check(Encoding::Utf16, "é😀x", 6, 0, 3);
        // Inside of a letter, behind the end of a line, and behind the text.
        let source = Source::new(FileId(0), "a.kin", "😀b\ncd");
        let at = |encoding: Encoding, line, character| encoding.offset(&source, Position { line, character });
        assert_eq!(at(Encoding::Utf8, 0, 2), 0);
        assert_eq!(at(Encoding::Utf16, 0, 99), 5);
        assert_eq!(at(Encoding::Utf16, u32::MAX, u32::MAX), 8);
        assert_eq!(at(Encoding::Utf8, 1, u32::MAX), 8);
    }
}
