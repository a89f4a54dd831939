//! Colours as they are written, for swatches and pickers.

use crate::builtin::{self, Call, Given, More, Topic, linear_to_srgb, srgb_to_linear};
use crate::dimension::unit;
use crate::eval::graph::Graph;
use crate::source::{FileId, Span};
use crate::syntax::{Part, SyntaxKind as K, Tree};
use crate::value::Value;

/// A colour in a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorAt {
    /// Where it is written.
    pub span: Span,
    /// Red, green, blue as a display takes them (sRGB), 0 to 1.
    pub srgb: [f64; 3],
}

/// The channels of `#rgb`, `#rrggbb` or `#rrggbbaa`.
pub fn channels(text: &str) -> Option<[u8; 4]> {
    let digits = text.strip_prefix('#')?;
    let at = |i: usize, n: usize| u8::from_str_radix(digits.get(i..i + n)?, 16).ok();
    match digits.len() {
        3 => Some([at(0, 1)? * 17, at(1, 1)? * 17, at(2, 1)? * 17, 255]),
        6 => Some([at(0, 2)?, at(2, 2)?, at(4, 2)?, 255]),
        8 => Some([at(0, 2)?, at(2, 2)?, at(4, 2)?, at(6, 2)?]),
        _ => None,
    }
}

/// The colours of a text: literals, and calls of functions of colours with plain numbers.
pub fn colors(tree: &Tree) -> Vec<ColorAt> {
    let mut found = Vec::new();
    for part in tree.root().all() {
        match part.kind() {
            K::Color => {
                if let Some([r, g, b, _]) = channels(part.text()) {
                    found
                        .push(ColorAt { span: part.span(), srgb: [r, g, b].map(|channel| f64::from(channel) / 255.0) });
                }
            }
            K::Named => found.extend(called(part)),
            _ => {}
        }
    }
    found
}

/// `linear(0.1, 0.2, 0.3)`, `hsv(40deg, 50%, 1)`: a call by place with plain numbers.
fn called(part: Part<'_>) -> Option<ColorAt> {
    let mut parts = part.parts();
    let (name, args) = (parts.next()?, parts.next()?);
    if parts.next().is_some() || args.kind() != K::Args {
        return None;
    }
    let function = builtin::find(name.text()).filter(|function| function.topic == Topic::Color)?;
    let values = args.nodes().map(|value| Some((Some(plain(value.text())?), value.span())));
    let mut given: Given = values.collect::<Option<_>>()?;
    if given.len() > function.params.len() {
        return None;
    }
    given.resize(function.params.len(), (None, part.span()));
    let mut graph = Graph::default();
    let mut call = Call::new(&mut graph, function, given, More::new(), FileId::default(), part.span());
    let Value::Color(linear) = (function.run)(&mut call) else { return None };
    if !call.problems.is_empty() {
        return None;
    }
    let srgb = linear.map(|channel| channel.constant().map_or(f64::NAN, linear_to_srgb));
    // What a display cannot show has no swatch.
    let fits = srgb.iter().all(|channel| (-1e-6..=1.0 + 1e-6).contains(channel));
    fits.then(|| ColorAt { span: part.span(), srgb: srgb.map(|channel| channel.clamp(0.0, 1.0)) })
}

/// A number with its unit, if it has one.
fn plain(text: &str) -> Option<Value> {
    let digits = text.find(|letter: char| !letter.is_ascii_digit() && !"._-+eE".contains(letter)).unwrap_or(text.len());
    let (digits, with) = text.split_at(digits);
    let value: f64 = digits.replace('_', "").parse().ok()?;
    match with {
        "" => Some(Value::number(value)),
        with => unit(with).map(|(factor, of)| Value::quantity(value * factor, of)),
    }
}

/// The ways to write a colour, the one that fits what is there first.
pub fn spellings(srgb: [f64; 3], there: &str) -> Vec<String> {
    let srgb = srgb.map(|channel| if channel.is_finite() { channel.clamp(0.0, 1.0) } else { 0.0 });
    let [r, g, b] = srgb.map(|channel| (channel * 255.0).round() as u8);
    let hex = format!("#{r:02x}{g:02x}{b:02x}");
    let short = |value: f64| crate::dimension::short((value * 1e4).round() / 1e4);
    let linear = srgb.map(|channel| short(srgb_to_linear(channel)));
    let linear = format!("linear({})", linear.join(", "));
    let encoded = format!("srgb({})", srgb.map(short).join(", "));
    let mut all = vec![hex, linear, encoded];
    let first = match there.split('(').next() {
        Some("linear") => 1,
        Some("srgb") => 2,
        _ => 0,
    };
    all[..=first].rotate_right(1);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Source;
    use crate::syntax::parse;

    fn check(text: &str, expected: Option<[f64; 3]>) {
        let text = format!("let a = {text}");
        let found = colors(&parse(&Source::new(FileId(0), "a.kin", text.as_str())));
        let near = |found: [f64; 3], expected: [f64; 3]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-3);
        match (found.as_slice(), expected) {
            ([], None) => {}
            ([found], Some(expected)) if near(found.srgb, expected) => {}
            _ => panic!("{text}: {found:?}"),
        }
    }

    #[test]
    fn swatches() {
        check("#f80", Some([1.0, 0.533, 0.0]));
        check("#ff880040", Some([1.0, 0.533, 0.0]));
        check("linear(50%, 0.25, 1)", Some([0.735, 0.537, 1.0]));
        check("srgb(0.1, 0.2, 0.3)", Some([0.1, 0.2, 0.3]));
        check("hsv(0deg, 100%, 1)", Some([1.0, 0.0, 0.0]));
        // White has no hue: the published coordinates of OKLCh.
        check("oklch(1, 0, 0deg)", Some([1.0, 1.0, 1.0]));
        check("linear(2, 0, 0)", None);
        check("linear(time, 0, 0)", None);
        check("linear(1, 0)", None);
        check("hsv(h: 0deg, s: 1, v: 1)", None);
        check("linear(1m, 0, 0)", None);
    }

    #[test]
    fn written_as_it_was() {
        assert_eq!(spellings([1.0, 0.5, 0.0], "#000")[0], "#ff8000");
        assert_eq!(spellings([1.0, 0.5, 0.0], "linear(0, 0, 0)")[0], "linear(1, 0.214, 0)");
        assert_eq!(spellings([1.0, 0.5, f64::NAN], "srgb(0, 0, 0)")[0], "srgb(1, 0.5, 0)");
    }
}
