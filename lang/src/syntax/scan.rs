//! The brackets of a text, counted before it is parsed.
//!
//! Recursion in the grammar goes through brackets only, so a limit on their nesting limits the parser's stack. The count
//! is never below the grammar's own nesting, because strings and comments are jumped over as the grammar does.

/// Most brackets inside one another.
pub const MAX_NESTING: usize = 128;

/// Bytes from which on a text is cut: pieces stay in the cache, and their pairs are dropped one by one.
const PIECE: usize = 16 << 10;

/// What the brackets of a text tell.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Scan {
    /// The offset of the first bracket that is nested too deep.
    pub too_deep: Option<u32>,
    /// Where the text may be cut: each piece then means by itself what it means in the text. None where a bracket, a
    /// string or a comment has no end.
    pub cuts: Vec<u32>,
}

pub(super) fn scan(text: &str) -> Scan {
    let bytes = text.as_bytes();
    let mut open: Vec<u8> = Vec::new();
    let mut cuts: Vec<u32> = Vec::new();
    let mut whole = true;
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'"' => {
                let closed;
                (at, closed) = string_end(bytes, at);
                whole &= closed;
            }
            b'/' if bytes.get(at + 1) == Some(&b'/') => at = line_end(bytes, at),
            b'/' if bytes.get(at + 1) == Some(&b'*') => {
                at = comment_end(bytes, at);
                whole &= at < bytes.len();
            }
            b'(' | b'[' | b'{' => {
                if open.len() == MAX_NESTING {
                    return Scan { too_deep: Some(at as u32), cuts: Vec::new() };
                }
                open.push(byte);
                at += 1;
            }
            b')' | b']' => {
                if open.last().is_some_and(|top| *top != b'{') {
                    whole &= open.pop() == Some(if byte == b')' { b'(' } else { b'[' });
                } else {
                    whole = false;
                }
                at += 1;
            }
            b'}' => {
                whole &= open.last() == Some(&b'{');
                while let Some(top) = open.pop() {
                    if top == b'{' {
                        break;
                    }
                }
                at += 1;
                if open.is_empty() && at - cuts.last().map_or(0, |cut| *cut as usize) >= PIECE {
                    cuts.extend(cut_behind(bytes, at));
                }
            }
            _ => at += 1,
        }
    }
    if !whole || !open.is_empty() {
        cuts.clear();
    }
    Scan { too_deep: None, cuts }
}

/// The line behind a `}` that closes a block of the file, where the `}` ends its line and a new item follows.
fn cut_behind(bytes: &[u8], close: usize) -> Option<u32> {
    let is_space = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\r');
    let line = close + bytes[close..].iter().position(|byte| !is_space(byte))?;
    let mut at = line + 1;
    if bytes[line] != b'\n' {
        return None;
    }
    loop {
        match &bytes[at..] {
            [b' ' | b'\t'..=b'\r', ..] => at += 1,
            [b'/', b'/', ..] => at = line_end(bytes, at),
            [b'/', b'*', ..] => at = comment_end(bytes, at),
            [byte, ..] if byte.is_ascii_alphabetic() => break,
            _ => return None,
        }
    }
    let word = bytes[at..].split(|byte| !(byte.is_ascii_alphanumeric() || *byte == b'_')).next()?;
    // What may follow a `}` within an item.
    let goes_on = [&b"else"[..], b"from", b"in", b"as", b"ease", b"like"].contains(&word);
    (!goes_on).then_some(line as u32 + 1)
}

/// Where the line comments of a text start: neither in strings nor in other comments.
pub fn line_comments(text: &str) -> impl Iterator<Item = usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < bytes.len() {
            let start = at;
            let is_comment = bytes[at..].starts_with(b"//");
            at = match (bytes.get(at), bytes.get(at + 1)) {
                (Some(b'"'), _) => string_end(bytes, at).0,
                _ if is_comment => line_end(bytes, at),
                (Some(b'/'), Some(b'*')) => comment_end(bytes, at),
                _ => at + 1,
            };
            if is_comment {
                return Some(start);
            }
        }
        None
    })
}

/// Behind the `}` that closes a `{`, or the text's end.
pub fn block_end(text: &str, open: usize) -> usize {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (open, 0usize);
    while let Some(byte) = bytes.get(at) {
        at = match (byte, bytes.get(at + 1)) {
            (b'"', _) => string_end(bytes, at).0,
            (b'/', Some(b'/')) => line_end(bytes, at),
            (b'/', Some(b'*')) => comment_end(bytes, at),
            _ => at + 1,
        };
        match byte {
            b'{' => depth += 1,
            b'}' if depth <= 1 => break,
            b'}' => depth -= 1,
            _ => {}
        }
    }
    at
}

/// Where a word stands in a text, outside of strings and comments. It may have dashes inside.
pub fn words(text: &str, word: &str) -> Vec<usize> {
    let bytes = text.as_bytes();
    let in_word = |character: char| unicode_ident::is_xid_continue(character) || character == '-' && word.contains('-');
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        at = match (bytes[at], bytes.get(at + 1)) {
            (b'"', _) => string_end(bytes, at).0,
            (b'/', Some(b'/')) => line_end(bytes, at),
            (b'/', Some(b'*')) => comment_end(bytes, at),
            _ => {
                let rest = text.get(at..).unwrap_or_default();
                let length = rest.find(|next: char| !in_word(next)).unwrap_or(rest.len());
                if length > 0 && rest.get(..length).map(|found| found.trim_end_matches('-')) == Some(word) {
                    found.push(at);
                }
                at + length.max(rest.chars().next().map_or(1, char::len_utf8))
            }
        };
    }
    found
}

/// Behind the closing quote and true, or the line's end and false if there is none.
pub(super) fn string_end(bytes: &[u8], start: usize) -> (usize, bool) {
    let mut at = start + 1;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'"' => return (at + 1, true),
            b'\n' => return (at, false),
            b'\\' if bytes.get(at + 1).is_some_and(|next| *next != b'\n') => at += 2,
            _ => at += 1,
        }
    }
    (bytes.len(), false)
}

/// At the line break, or the end.
pub(super) fn line_end(bytes: &[u8], start: usize) -> usize {
    bytes.iter().skip(start).position(|byte| *byte == b'\n').map_or(bytes.len(), |length| start + length)
}

/// Behind `*/`, or the end.
pub(super) fn comment_end(bytes: &[u8], start: usize) -> usize {
    let inside = bytes.get(start + 2..).unwrap_or_default();
    inside.windows(2).position(|pair| pair == b"*/").map_or(bytes.len(), |length| start + 2 + length + 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expected: Option<usize>) {
        assert_eq!(scan(text).too_deep.map(|at| at as usize), expected, "{text}");
    }

    #[test]
    fn cuts() {
        let block = format!("a {{ {} }}", " ".repeat(PIECE));
        let check = |between: &str, cut: Option<usize>| {
            let text = format!("{block}{between}{block}");
            let expected: Vec<u32> = cut.map(|cut| (block.len() + cut) as u32).into_iter().collect();
            assert_eq!(scan(&text), Scan { too_deep: None, cuts: expected }, "{between:?}");
        };
        check("\n", Some(1));
        check(" \t\r\n\n// }\n/* { */  ", Some(4));
        check("", None);
        check(" // end\n", None);
        check("\nelse ", None);
        check("\nelsewhere ", Some(1));
        check("\n+ ", None);
        for open in ["(", "]", "\"", "/*", "} ", "{ ", "{ ( } "] {
            check(&format!("\nb: 1 {open}\n"), None);
        }
    }

    #[test]
    fn depth() {
        check(&"(".repeat(MAX_NESTING), None);
        check(&"(".repeat(MAX_NESTING + 1), Some(MAX_NESTING));
        check(&"()".repeat(1000), None);
        check(&"{ ( [ }".repeat(1000), None);
        check(&format!("\"{}\"", "(".repeat(1000)), None);
        check(&format!("// {}\n/* {} */", "(".repeat(1000), "[".repeat(1000)), None);
        check(&format!("\"\\\"{}", "(".repeat(1000)), None);
        check("/*", None);
        check("\"\\", None);
    }
}
