//! A scene file's text and the arithmetic of places in it.
//!
//! Everything else speaks of byte offsets ([`Span`]); lines, columns and UTF-16 units exist only at the border, where a
//! message is shown or an editor asks. CRLF stays as it is, so that an offset means the same in the file on disk.

use crate::diagnostic::Diagnostic;
use crate::syntax::words;
use std::sync::Arc;

/// Which file of a compilation a span lies in: an index into its list of sources.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct FileId(pub u32);

/// A range of bytes in one source, `start <= end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Span {
    /// Offset of the first byte.
    pub start: u32,
    /// Offset behind the last byte.
    pub end: u32,
}

impl Span {
    /// The bytes from `start` up to `end`; an `end` before the `start` gives an empty span at `start`.
    pub fn new(start: u32, end: u32) -> Span {
        Span { start, end: end.max(start) }
    }

    /// An empty span: a place between two characters.
    pub fn at(offset: u32) -> Span {
        Span { start: offset, end: offset }
    }

    /// The smallest span that covers both.
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start.min(other.start), end: self.end.max(other.end) }
    }

    /// Whether the span covers no byte.
    pub fn is_empty(self) -> bool {
        self.start == self.end
    }

    /// Length in bytes.
    pub fn len(self) -> u32 {
        self.end - self.start
    }
}

/// A place as people and editors count it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Position {
    /// Line, from 1.
    pub line: u32,
    /// Column in characters, from 1.
    pub column: u32,
    /// Column in UTF-16 code units, from 1.
    pub utf16: u32,
}

/// One file's text with the table of its lines. Cloning shares both.
#[derive(Debug, Clone)]
pub struct Source {
    /// Its number in the compilation.
    pub id: FileId,
    /// Path relative to the project, with `/`: for messages.
    pub name: Arc<str>,
    /// The text, byte for byte.
    pub text: Arc<str>,
    line_starts: Arc<[u32]>,
    /// Where letters of more than one byte end, and how many bytes there are up to there that UTF-16 does not count.
    wide: Arc<[(u32, u32)]>,
}

/// Most bytes a scene file may have.
pub const MAX_SOURCE_BYTES: usize = 64 << 20;

impl Source {
    /// The source `name` with its text. Text beyond 4 GiB is cut off: the reader refuses far smaller files.
    pub fn new(id: FileId, name: impl Into<Arc<str>>, text: impl Into<Arc<str>>) -> Source {
        let mut text: Arc<str> = text.into();
        if text.len() > u32::MAX as usize {
            text = text[..text.floor_char_boundary(u32::MAX as usize)].into();
        }
        let breaks = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        let line_starts = std::iter::once(0).chain(breaks.map(|(offset, _)| offset as u32 + 1)).collect();
        let mut uncounted = 0;
        let wide = match text.is_ascii() {
            true => Arc::default(),
            false => {
                let letters = text.char_indices().filter(|(_, letter)| !letter.is_ascii());
                let wide = letters.map(|(at, letter)| {
                    uncounted += (letter.len_utf8() - letter.len_utf16()) as u32;
                    ((at + letter.len_utf8()) as u32, uncounted)
                });
                wide.collect()
            }
        };
        Source { id, name: name.into(), text, line_starts, wide }
    }

    /// Length in bytes.
    pub fn len(&self) -> u32 {
        self.text.len() as u32
    }

    /// Whether there is no text at all.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    /// Number of lines; an empty file has one.
    pub fn line_count(&self) -> u32 {
        self.line_starts.len() as u32
    }

    /// Line of an offset, from 0; an offset behind the end counts as the end.
    pub fn line_index(&self, offset: u32) -> u32 {
        (self.line_starts.partition_point(|start| *start <= offset) as u32).saturating_sub(1)
    }

    /// Where the line (from 0) starts; behind the last line, the end of the text.
    pub fn line_start(&self, line: u32) -> u32 {
        self.line_starts.get(line as usize).copied().unwrap_or(self.len())
    }

    /// The line (from 0) without its line break.
    pub fn line_span(&self, line: u32) -> Span {
        let start = self.line_start(line);
        let text = self.slice(Span::new(start, self.line_start(line + 1)));
        Span::new(start, start + text.trim_end_matches(['\n', '\r']).len() as u32)
    }

    /// An offset as line and columns. Offsets inside a character or behind the end are moved back to a border.
    pub fn position(&self, offset: u32) -> Position {
        let offset = self.clamp(offset);
        let line = self.line_index(offset);
        let before = self.slice(Span::new(self.line_start(line), offset));
        Position {
            line: line + 1,
            column: before.chars().count() as u32 + 1,
            utf16: self.utf16_len(Span::new(self.line_start(line), offset)) + 1,
        }
    }

    /// UTF-16 units before an offset on a border of characters.
    fn units(&self, offset: u32) -> u32 {
        let before = self.wide.partition_point(|(end, _)| *end <= offset);
        offset - before.checked_sub(1).and_then(|last| self.wide.get(last)).map_or(0, |(_, uncounted)| *uncounted)
    }

    /// UTF-16 units from one offset to another one behind it.
    pub fn utf16_len(&self, span: Span) -> u32 {
        self.units(self.clamp(span.end)).saturating_sub(self.units(self.clamp(span.start)))
    }

    /// The offset of a line and a UTF-16 column, both from 1, clamped to the line. In the middle of a character, its end.
    pub fn offset_utf16(&self, line: u32, utf16: u32) -> u32 {
        let span = self.line_span(line.saturating_sub(1));
        let units = self.units(span.start).saturating_add(utf16.saturating_sub(1));
        let before = self.wide.partition_point(|(end, uncounted)| end - uncounted <= units);
        let uncounted =
            before.checked_sub(1).and_then(|last| self.wide.get(last)).map_or(0, |(_, uncounted)| *uncounted);
        let offset = units.saturating_add(uncounted).min(span.end);
        let border = self.clamp(offset);
        // What is left belongs to the next character, which is wide.
        match self.wide.get(before).filter(|(end, _)| border < offset && *end <= span.end) {
            Some((end, _)) => *end,
            None => border,
        }
    }

    /// The text under a span, clamped to the file and to borders of characters.
    pub fn slice(&self, span: Span) -> &str {
        &self.text[self.clamp(span.start) as usize..self.clamp(span.end) as usize]
    }

    /// The offset moved back to the nearest border of a character in the file.
    pub fn clamp(&self, offset: u32) -> u32 {
        self.text.floor_char_boundary(offset as usize) as u32
    }
}

/// The texts of a scene and of what it imports, laid end to end: a span of one of them is a span of the whole, so that
/// places in different files can stand side by side. The scene's own spans are what they are in its text.
#[derive(Debug, Clone)]
pub struct Texts {
    /// The number that places of the whole carry until [`Texts::settle`] says whose they are: the scene's own.
    pub id: FileId,
    /// Where each begins, in ascending order, the scene first.
    parts: Vec<(u32, Source)>,
}

impl Texts {
    /// One text.
    pub fn new(source: &Source) -> Texts {
        Texts { id: source.id, parts: vec![(0, source.clone())] }
    }

    /// Adds a text; where it begins, or `None` where all of them would be longer than `most` bytes.
    pub fn add(&mut self, source: &Source, most: u32) -> Option<u32> {
        // One place between two texts, so that the end of one is not the start of the next.
        let base = self.parts.last().map_or(0, |(base, source)| base + source.len() + 1);
        base.checked_add(source.len()).filter(|end| *end < most)?;
        self.parts.push((base, source.clone()));
        Some(base)
    }

    fn part(&self, offset: u32) -> (u32, &Source) {
        let at = self.parts.partition_point(|(base, _)| *base <= offset).saturating_sub(1);
        let (base, source) = &self.parts[at];
        (*base, source)
    }

    /// The text that a place lies in.
    pub fn source(&self, offset: u32) -> &Source {
        self.part(offset).1
    }

    /// The text under a span.
    pub fn slice(&self, span: Span) -> &str {
        let (base, source) = self.part(span.start);
        source.slice(Span::new(span.start - base, span.end.max(base) - base))
    }

    /// Where a word stands in the text that a place lies in, outside of strings and comments.
    pub fn words(&self, offset: u32, word: &str) -> Vec<Span> {
        let (base, source) = self.part(offset);
        let place = |at: usize| Span::new(base + at as u32, base + (at + word.len()) as u32);
        words(&source.text, word).into_iter().map(place).collect()
    }

    /// A place as people count it, in its own text.
    pub fn position(&self, offset: u32) -> Position {
        let (base, source) = self.part(offset);
        source.position(offset - base)
    }

    /// Length of the scene's own text in bytes.
    pub fn len(&self) -> u32 {
        self.parts[0].1.len()
    }

    /// Whether the scene's own text is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether a place lies in the scene's own text.
    pub fn is_own(&self, offset: u32) -> bool {
        self.part(offset).0 == 0
    }

    /// A place in a sentence: `line 7`, or `lib/metals.kin, line 7` where it is not in the scene's own text.
    pub fn line(&self, offset: u32) -> String {
        let line = self.position(offset).line;
        match self.is_own(offset) {
            true => format!("line {line}"),
            false => format!("{}, line {line}", self.source(offset).name),
        }
    }

    /// A place in its own text, and that text's number.
    pub fn settled(&self, span: Span) -> (FileId, Span) {
        let (base, source) = self.part(span.start);
        (source.id, Span::new(span.start - base, span.end.max(base) - base))
    }

    /// Gives every place of a diagnostic the number of its own text and its offset there.
    pub fn settle(&self, found: &mut Diagnostic) {
        let settle = |file: &mut FileId, span: &mut Span| {
            if *file == self.id {
                (*file, *span) = self.settled(*span);
            }
        };
        for label in &mut found.labels {
            settle(&mut label.file, &mut label.span);
        }
        for edit in found.fixes.iter_mut().flat_map(|fix| &mut fix.edits) {
            settle(&mut edit.file, &mut edit.span);
        }
    }
}

/// Makes a source of a file's bytes. Bytes that are no UTF-8 give E0119 and a readable approximation of the text, which is
/// for showing the place only.
pub fn decode(id: FileId, name: &str, bytes: &[u8]) -> (Source, Option<Diagnostic>) {
    let utf16 = match bytes {
        [0xFF, 0xFE, rest @ ..] => Some((rest, u16::from_le_bytes as fn([u8; 2]) -> u16)),
        [0xFE, 0xFF, rest @ ..] => Some((rest, u16::from_be_bytes as fn([u8; 2]) -> u16)),
        _ => None,
    };
    if let Some((rest, unit)) = utf16 {
        let units: Vec<u16> = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
        let source = Source::new(id, name, String::from_utf16_lossy(&units));
        let error = Diagnostic::new("E0119", "file is UTF-16, not UTF-8")
            .primary(id, Span::at(0), "starts with the byte order mark of UTF-16")
            .help("save the file as UTF-8");
        return (source, Some(error));
    }
    let error = match std::str::from_utf8(bytes) {
        Ok(text) => return (Source::new(id, name, text), None),
        Err(error) => error,
    };
    // The approximation has the same bytes up to the fault, so the offset is the same in both.
    let source = Source::new(id, name, String::from_utf8_lossy(bytes));
    let offset = error.valid_up_to();
    let byte = bytes.get(offset).copied().unwrap_or_default();
    let line = source.position(offset as u32).line;
    let mut found = Diagnostic::new("E0119", "file is not valid UTF-8")
        .primary(
            id,
            Span::new(offset as u32, offset as u32 + '\u{FFFD}'.len_utf8() as u32),
            format!("byte 0x{byte:02X}"),
        )
        .note(format!("byte {offset}, line {line}"));
    if byte >= 0xA0 {
        found = found.note(format!("byte 0x{byte:02X} looks like Latin-1, where it is `{}`", char::from(byte)));
    }
    (source, Some(found.help("save the file as UTF-8")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, offset: u32, expected: (u32, u32, u32)) {
        let source = Source::new(FileId(0), "a.kin", text);
        let position = source.position(offset);
        assert_eq!((position.line, position.column, position.utf16), expected, "{text:?} at {offset}");
        assert_eq!(
            source.offset_utf16(position.line, position.utf16),
            source.clamp(offset),
            "{text:?} back to {offset}"
        );
    }

    #[test]
    fn places() {
        check("", 0, (1, 1, 1));
        check("", 9, (1, 1, 1));
        check("ab\ncd", 4, (2, 2, 2));
        check("ab\r\ncd", 4, (2, 1, 1));
        check("ab\n", 3, (2, 1, 1));
        check("é😀x", 6, (1, 3, 4));
        check("é😀x", 4, (1, 2, 2));
        let text = "a\n😀é\u{301}b\r\nü😀";
        let source = Source::new(FileId(0), "a.kin", text);
        for (offset, _) in text.char_indices().filter(|(_, letter)| *letter != '\n') {
            let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
            let units = text[start..offset].encode_utf16().count() as u32 + 1;
            check(
                text,
                offset as u32,
                (source.line_index(offset as u32) + 1, text[start..offset].chars().count() as u32 + 1, units),
            );
        }
        // In the middle of a letter, and behind the line.
        assert_eq!((source.offset_utf16(2, 2), source.offset_utf16(2, 99), source.offset_utf16(3, 99)), (6, 11, 19));
    }

    #[test]
    fn texts_end_to_end() {
        let mut texts = Texts::new(&Source::new(FileId(3), "a.kin", "ab\nc"));
        assert_eq!(texts.add(&Source::new(FileId(4), "b.kin", "x\nyz"), 100), Some(5));
        assert_eq!(texts.add(&Source::new(FileId(5), "c.kin", "too long"), 16), None);
        assert_eq!((texts.slice(Span::new(3, 4)), texts.slice(Span::new(7, 9))), ("c", "yz"));
        assert_eq!((texts.line(4).as_str(), texts.line(7).as_str()), ("line 2", "b.kin, line 2"));
        let mut found = Diagnostic::new("E0201", "m").primary(FileId(3), Span::new(7, 9), "");
        found = found.label(FileId(3), Span::at(4), "").label(FileId(4), Span::at(1), "");
        texts.settle(&mut found);
        let places: Vec<_> =
            found.labels.iter().map(|label| (label.file.0, label.span.start, label.span.end)).collect();
        assert_eq!(places, [(4, 2, 4), (3, 4, 4), (4, 1, 1)]);
    }
}
