//! Colours as they are written, for swatches and pickers.

use crate::builtin::srgb_to_linear;
use crate::source::Span;
use crate::syntax::{Part, SyntaxKind as K, Tree};

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

/// Linear light as a display takes it.
fn linear_to_srgb(x: f64) -> f64 {
    if x <= 0.003_130_8 { x * 12.92 } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The colours of a text: literals, and calls of `linear` and `srgb` with plain numbers.
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

/// `linear(0.1, 0.2, 0.3)`, and `srgb`: what a picker can write back.
fn called(part: Part<'_>) -> Option<ColorAt> {
    let mut parts = part.parts();
    let (name, args) = (parts.next()?, parts.next()?);
    if parts.next().is_some() || args.kind() != K::Args {
        return None;
    }
    let values: Option<Vec<f64>> = args.nodes().map(|value| plain(value.text())).collect();
    let [r, g, b] = values?.try_into().ok()?;
    let srgb = match name.text() {
        "linear" => [r, g, b].map(linear_to_srgb),
        "srgb" => [r, g, b],
        _ => return None,
    };
    let fits = srgb.iter().all(|channel| (0.0..=1.0).contains(channel));
    fits.then_some(ColorAt { span: part.span(), srgb })
}

fn plain(text: &str) -> Option<f64> {
    match text.strip_suffix('%') {
        Some(percent) => percent.parse::<f64>().ok().map(|value| value / 100.0),
        None => text.parse().ok(),
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
