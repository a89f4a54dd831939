//! Numbers that look random and depend on nothing but their arguments. They must never change between versions.

use super::Call;
use super::math::try_arg;
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

pub(super) fn noise(call: &mut Call<'_>) -> Value {
    let point = match try_arg!(call.value(0)) {
        Value::Number(number) => vec![number.value],
        _ => try_arg!(call.vector(0)).0,
    };
    let mut at = [0.0; 3];
    for (to, part) in at.iter_mut().zip(&point) {
        match part.constant() {
            Some(value) => *to = value,
            None => return call.later(call.place(0)),
        }
    }
    Value::number(gradient_noise(at))
}

/// Perlin, "Improving Noise" (2002), with hashed instead of tabulated gradients.
fn gradient_noise(at: [f64; 3]) -> f64 {
    if at.iter().any(|part| !part.is_finite()) {
        return f64::NAN;
    }
    let cell = at.map(f64::floor);
    let inside = [0, 1, 2].map(|i| at[i] - cell[i]);
    let fade = inside.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let mut total = 0.0;
    for corner in 0..8u32 {
        let step = [corner & 1, corner >> 1 & 1, corner >> 2 & 1].map(f64::from);
        let hash = [0, 1, 2].iter().fold(0, |state, &i| absorb(state, (cell[i] + step[i] + 0.0).to_bits()));
        let away = [0, 1, 2].map(|i| inside[i] - step[i]);
        let weight: f64 = (0..3).map(|i| if step[i] == 0.0 { 1.0 - fade[i] } else { fade[i] }).product();
        total += weight * gradient(hash, away);
    }
    total.clamp(-1.0, 1.0)
}

/// The scalar product with one of the twelve edge directions of a cube.
fn gradient(hash: u64, d: [f64; 3]) -> f64 {
    let (a, b) = match hash % 3 {
        0 => (d[0], d[1]),
        1 => (d[1], d[2]),
        _ => (d[2], d[0]),
    };
    let signed = |bit: u32, value: f64| if hash >> bit & 1 == 0 { value } else { -value };
    signed(32, a) + signed(33, b)
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

    #[test]
    fn noise_is_zero_at_lattice_points_and_smooth() {
        assert_eq!(gradient_noise([3.0, -2.0, 7.0]), 0.0);
        let mut largest: f64 = 0.0;
        for i in 0..1000 {
            let x = f64::from(i) * 0.0317;
            let step = gradient_noise([x, 0.3, 0.7]) - gradient_noise([x + 1e-4, 0.3, 0.7]);
            assert!(step.abs() < 1e-3, "{x}");
            largest = largest.max(gradient_noise([x, 0.3, 0.7]).abs());
        }
        assert!(largest > 0.3 && largest <= 1.0, "{largest}");
    }
}
