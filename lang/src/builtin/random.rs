//! Numbers that look random and depend on nothing but their arguments. They must never change between versions.

use kinora_scene::Cell;

use super::Call;
use super::math::try_arg;
use crate::diagnostic::Diagnostic;
use crate::eval::graph::Scalar;
use crate::value::Value;

/// The finaliser of SplitMix64 (Steele et al. 2014, variant 13 of Stafford).
fn scramble(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn absorb(state: u64, word: u64) -> u64 {
    scramble(state.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ scramble(word.wrapping_add(0xd1b5_4a32_d192_ed03)))
}

/// The top 53 bits as a number in 0..1, 1 excluded.
fn unit(state: u64) -> f64 {
    (scramble(state) >> 11) as f64 / (1u64 << 53) as f64
}

/// `Err` where a value moves, `Ok(None)` where it cannot be hashed.
fn absorb_value(state: u64, value: &Value) -> Result<Option<u64>, ()> {
    let number = |state: u64, scalar: &Scalar| match scalar.constant() {
        // -0 and 0 are equal, so they hash alike.
        Some(value) => Ok(absorb(state, (value + 0.0).to_bits())),
        None => Err(()),
    };
    Ok(Some(match value {
        Value::Number(n) => number(state, &n.value)?,
        Value::Bool(scalar) => number(absorb(state, 1), scalar)?,
        Value::Text(text) => text.bytes().fold(absorb(state, 2), |state, byte| absorb(state, u64::from(byte))),
        Value::Color(parts) => {
            let mut state = absorb(state, 3);
            for part in parts {
                state = number(state, part)?;
            }
            state
        }
        Value::Tuple(items) | Value::List(items) => {
            let mut state = absorb(state, 4 + items.len() as u64);
            for item in items.iter() {
                match absorb_value(state, item)? {
                    Some(next) => state = next,
                    None => return Ok(None),
                }
            }
            state
        }
        _ => return Ok(None),
    }))
}

pub(super) fn rand(call: &mut Call<'_>) -> Value {
    let mut state = 0;
    let seed = call.value(0).map(|seed| (seed, call.place(0)));
    for (value, span) in seed.into_iter().chain(call.rest.clone()) {
        match absorb_value(state, &value) {
            Ok(Some(next)) => state = next,
            Ok(None) => {
                call.needs("numbers or text", &value, span);
                return Value::Error;
            }
            Err(()) => return call.later(span),
        }
    }
    Value::number(unit(state))
}

/// A number or a vector of up to three components, the rest 0, and how many there are.
fn place(call: &mut Call<'_>) -> Option<([Scalar; 3], u8)> {
    let point = match call.value(0)? {
        Value::Number(number) => vec![number.value],
        _ => call.vector(0)?.0,
    };
    let mut at = [Scalar::Const(0.0); 3];
    for (to, part) in at.iter_mut().zip(&point) {
        *to = *part;
    }
    Some((at, point.len().min(3) as u8))
}

pub(super) fn noise(call: &mut Call<'_>) -> Value {
    let (at, _) = try_arg!(place(call));
    Value::number(call.graph.noise(at))
}

/// Σ gainⁱ noise(lacunarityⁱ p) / Σ gainⁱ.
pub(super) fn fbm(call: &mut Call<'_>) -> Value {
    let (mut at, _) = try_arg!(place(call));
    let octaves = try_arg!(call.octaves(1));
    let mut factor = |index: usize, default: f64| match call.value(index) {
        Some(_) => call.plain(index),
        None => Some(default.into()),
    };
    let (gain, lacunarity) = (try_arg!(factor(2, 0.5)), try_arg!(factor(3, 2.0)));
    let graph = &mut *call.graph;
    let (mut sum, mut total, mut share) = (Scalar::Const(0.0), Scalar::Const(0.0), Scalar::Const(1.0));
    for octave in 0..octaves {
        if octave > 0 {
            share = graph.mul(share, gain);
            at = at.map(|part| graph.mul(part, lacunarity));
        }
        let noise = graph.noise(at);
        let part = graph.mul(noise, share);
        sum = graph.add(sum, part);
        total = graph.add(total, share);
    }
    Value::number(graph.div(sum, total))
}

fn cellular(call: &mut Call<'_>, cell: Cell) -> Value {
    let (at, axes) = try_arg!(place(call));
    Value::number(call.graph.cell(cell, axes, at))
}

pub(super) fn cell(call: &mut Call<'_>) -> Value {
    cellular(call, Cell::Distance)
}

pub(super) fn cell_id(call: &mut Call<'_>) -> Value {
    cellular(call, Cell::Id)
}

/// The most octaves of `fbm`.
const OCTAVES: u32 = 16;

impl Call<'_> {
    /// A whole number of octaves, 5 if it is not given.
    fn octaves(&mut self, index: usize) -> Option<u32> {
        if self.value(index).is_none() {
            return Some(5);
        }
        let span = self.place(index);
        let Some(octaves) = self.plain(index)?.constant() else {
            self.later(span);
            return None;
        };
        if octaves.fract() == 0.0 && (1.0..=f64::from(OCTAVES)).contains(&octaves) {
            return Some(octaves as u32);
        }
        let message = format!("`octaves` must be a whole number within 1..{OCTAVES}");
        self.problems.push(Diagnostic::new("E0401", message).primary(self.file, span, "this many layers of noise"));
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::value::Number;

    #[test]
    fn rand_is_even_and_stays_what_it_is() {
        let of = |i: f64| unit(absorb_value(0, &Value::Number(Number::int(i))).unwrap().unwrap());
        let mean = (0..10_000).map(|i| of(f64::from(i))).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert_eq!(of(0.0).to_bits(), of(-0.0).to_bits());
        // Written down once: a change breaks every scene that was ever made.
        assert_eq!(of(1.0).to_bits(), RAND_OF_1, "{:#x}", of(1.0).to_bits());
    }

    const RAND_OF_1: u64 = 0x3feb_ace0_9927_bd2a;
}
