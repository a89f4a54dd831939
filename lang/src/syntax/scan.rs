//! The brackets of a text, counted before it is parsed.
//!
//! Recursion in the grammar goes through brackets only, so a limit on their nesting limits the parser's stack. The count
//! is never below the grammar's own nesting, because strings and comments are jumped over as the grammar does.

/// Most brackets inside one another.
pub const MAX_NESTING: usize = 128;

/// The offset of the first bracket that is nested too deep.
pub(super) fn too_deep(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut open: Vec<u8> = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'"' => (at, _) = string_end(bytes, at),
            b'/' if bytes.get(at + 1) == Some(&b'/') => at = line_end(bytes, at),
            b'/' if bytes.get(at + 1) == Some(&b'*') => at = comment_end(bytes, at),
            b'(' | b'[' | b'{' => {
                if open.len() == MAX_NESTING {
                    return Some(at);
                }
                open.push(byte);
                at += 1;
            }
            b')' | b']' => {
                if open.last().is_some_and(|top| *top != b'{') {
                    open.pop();
                }
                at += 1;
            }
            b'}' => {
                while let Some(top) = open.pop() {
                    if top == b'{' {
                        break;
                    }
                }
                at += 1;
            }
            _ => at += 1,
        }
    }
    None
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
        assert_eq!(too_deep(text), expected, "{text}");
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
