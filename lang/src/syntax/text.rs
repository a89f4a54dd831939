//! The inside of leaves: strings, numbers, colours.

use std::borrow::Cow;

use super::ast::{Name, Number, Unit};
use crate::dimension;
use crate::source::Span;

/// A string's text and the escapes in it that mean nothing.
pub(super) struct Unescaped {
    pub text: String,
    /// Ranges in the literal, quotes included.
    pub unknown: Vec<Span>,
}

/// Reads a string literal with its quotes. Unknown escapes stay as they are.
pub(super) fn unescape(literal: &str) -> Unescaped {
    let inside = literal.strip_prefix('"').unwrap_or(literal);
    let inside = inside.strip_suffix('"').unwrap_or(inside);
    let mut out = Unescaped { text: String::with_capacity(inside.len()), unknown: Vec::new() };
    let mut rest = inside;
    while let Some(at) = rest.find('\\') {
        out.text.push_str(&rest[..at]);
        let escape = &rest[at..];
        let length = match escape[1..].chars().next() {
            Some(plain @ ('"' | '\\' | 'n' | 't')) => {
                out.text.push(match plain {
                    'n' => '\n',
                    't' => '\t',
                    other => other,
                });
                2
            }
            other => match unicode_escape(escape) {
                Some((character, length)) => {
                    out.text.push(character);
                    length
                }
                None => {
                    let length = 1 + other.map_or(0, char::len_utf8);
                    out.text.push_str(&escape[..length]);
                    let start = 1 + (inside.len() - rest.len() + at) as u32;
                    out.unknown.push(Span::new(start, start + length as u32));
                    length
                }
            },
        };
        rest = &escape[length..];
    }
    out.text.push_str(rest);
    out
}

/// `\u{1F600}`: the character and the escape's length.
fn unicode_escape(escape: &str) -> Option<(char, usize)> {
    let digits = escape.strip_prefix("\\u{")?;
    let end = digits.find('}')?;
    let digits = digits.get(..end).filter(|digits| (1..=6).contains(&digits.len()))?;
    let all_hex = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    let character = u32::from_str_radix(digits, 16).ok().filter(|_| all_hex).and_then(char::from_u32)?;
    Some((character, end + 4))
}

/// Reads a number's digits as the grammar allows them: sign, `_`, point, exponent.
pub(super) fn number(digits: &str, unit: Option<Name>) -> Number {
    let plain = if digits.contains('_') { Cow::Owned(digits.replace('_', "")) } else { Cow::Borrowed(digits) };
    let whole = !plain.contains(['.', 'e', 'E']);
    let value = plain.parse().unwrap_or(f64::INFINITY);
    let int = if whole { plain.parse().ok() } else { None };
    let unit = unit
        .map(|name| Box::new(Unit { si: dimension::unit(&name.text), frames: dimension::frames(&name.text), name }));
    Number { value, int, whole, unit }
}

/// Reads `#rgb`, `#rrggbb`, `#rrggbbaa`; nothing for another number of digits.
pub(super) fn color(text: &str) -> Option<[u8; 4]> {
    let digits: Option<Vec<u8>> =
        text.strip_prefix('#')?.chars().map(|digit| digit.to_digit(16).map(|value| value as u8)).collect();
    match digits?.as_slice() {
        [r, g, b] => Some([r * 17, g * 17, b * 17, 255]),
        [r, rr, g, gg, b, bb] => Some([r * 16 + rr, g * 16 + gg, b * 16 + bb, 255]),
        [r, rr, g, gg, b, bb, a, aa] => Some([r * 16 + rr, g * 16 + gg, b * 16 + bb, a * 16 + aa]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings() {
        let check = |literal: &str, text: &str, unknown: &[(u32, u32)]| {
            let found = unescape(literal);
            let spans: Vec<(u32, u32)> = found.unknown.iter().map(|span| (span.start, span.end)).collect();
            assert_eq!((found.text.as_str(), spans.as_slice()), (text, unknown), "{literal}");
        };
        check(r#""""#, "", &[]);
        check(r#""a\"b\\c\n\t""#, "a\"b\\c\n\t", &[]);
        check(r#""\u{1F600}x""#, "😀x", &[]);
        check(r#""C:\mod\é""#, "C:\\mod\\é", &[(3, 5), (7, 10)]);
        check(r#""\u{}\u{d800}\u{+1}""#, "\\u{}\\u{d800}\\u{+1}", &[(1, 3), (5, 7), (13, 15)]);
    }

    #[test]
    fn numbers() {
        let check = |digits: &str, value: f64, int: Option<i64>| {
            let found = number(digits, None);
            assert_eq!((found.value, found.int), (value, int), "{digits}");
        };
        check("1_000", 1000.0, Some(1000));
        check("-3", -3.0, Some(-3));
        check("1.5e-3", 0.0015, None);
        check("1e400", f64::INFINITY, None);
        check("99999999999999999999", 1e20, None);
    }

    #[test]
    fn colors() {
        assert_eq!(color("#f80"), Some([255, 136, 0, 255]));
        assert_eq!(color("#0a0B0c"), Some([10, 11, 12, 255]));
        assert_eq!(color("#0a0B0c80"), Some([10, 11, 12, 128]));
        assert_eq!(color("#12345"), None);
    }
}
