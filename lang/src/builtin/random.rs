//! Numbers that look random and depend on nothing but their arguments. They must never change between versions.

use kinora_scene::{Binary, Cell, Rand, Unary};

use super::Call;
use super::math::try_arg;
use crate::diagnostic::Diagnostic;
use crate::eval::graph::{Graph, Scalar};
use crate::eval::surface::{Points, points};
use crate::value::Value;

/// What `rand` has absorbed so far: the upper and the lower half, 32 bits each.
type State = [Scalar; 2];

fn absorb(graph: &mut Graph, [high, low]: State, word: Scalar) -> State {
    [Rand::High, Rand::Low].map(|half| graph.rand(half, [high, low, word]))
}

/// A whole number that tells one kind of value from another: its bits, not its value, are absorbed.
fn mark(graph: &mut Graph, state: State, word: u64) -> State {
    absorb(graph, state, f64::from_bits(word).into())
}

/// `None` where it cannot be hashed.
fn absorb_value(graph: &mut Graph, state: State, value: &Value) -> Option<State> {
    // -0 and 0 are equal, so they hash alike. Adding 0 folds away where the number moves.
    let number = |graph: &mut Graph, state: State, scalar: &Scalar| match scalar {
        Scalar::Const(value) => absorb(graph, state, (value + 0.0).into()),
        moving => {
            let positive = graph.unary(Unary::Abs, *moving);
            let zero = graph.binary(Binary::Equal, positive, 0.0.into());
            let same = graph.select(zero, positive, *moving);
            absorb(graph, state, same)
        }
    };
    Some(match value {
        Value::Number(n) => number(graph, state, &n.value),
        Value::Bool(scalar) => {
            let state = mark(graph, state, 1);
            number(graph, state, scalar)
        }
        Value::Text(text) => {
            let state = mark(graph, state, 2);
            text.bytes().fold(state, |state, byte| mark(graph, state, u64::from(byte)))
        }
        Value::Color(parts) => {
            let state = mark(graph, state, 3);
            parts.iter().fold(state, |state, part| number(graph, state, part))
        }
        Value::Tuple(items) | Value::List(items) => {
            let mut state = mark(graph, state, 4 + items.len() as u64);
            for item in items.iter() {
                state = absorb_value(graph, state, item)?;
            }
            state
        }
        _ => return None,
    })
}

pub(super) fn rand(call: &mut Call<'_>) -> Value {
    let mut state = [Scalar::Const(0.0); 2];
    let seed = call.value(0).map(|seed| (seed, call.place(0)));
    for (value, span) in seed.into_iter().chain(call.rest.clone()) {
        if !points(call.graph, &value).is_none() {
            return call.later(span);
        }
        match absorb_value(call.graph, state, &value) {
            Some(next) => state = next,
            None => {
                call.needs("numbers or text", &value, span);
                return Value::Error;
            }
        }
    }
    let [high, low] = state;
    Value::number(call.graph.rand(Rand::Unit, [high, low, 0.0.into()]))
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
            let message = "the number of octaves may not depend on time";
            let found = self.value(index).map_or(Points::default(), |value| points(self.graph, &value));
            let diagnostic = match found.is_none() {
                true => Diagnostic::new("E0601", message).primary(self.file, span, "depends on time"),
                false => Diagnostic::new("E0613", "the number of octaves may not depend on the point of a surface")
                    .primary(self.file, span, "differs from point to point"),
            };
            self.problems.push(diagnostic.help("let `gain` depend on it instead"));
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
        let mut graph = Graph::default();
        let mut of = |i: f64| {
            let [high, low] =
                absorb_value(&mut graph, [Scalar::Const(0.0); 2], &Value::Number(Number::int(i))).unwrap();
            graph.rand(Rand::Unit, [high, low, 0.0.into()]).constant().unwrap()
        };
        let mean = (0..10_000).map(|i| of(f64::from(i))).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01, "{mean}");
        assert_eq!(of(0.0).to_bits(), of(-0.0).to_bits());
        // Written down once: a change breaks every scene that was ever made.
        assert_eq!(of(1.0).to_bits(), RAND_OF_1, "{:#x}", of(1.0).to_bits());
    }

    const RAND_OF_1: u64 = 0x3feb_ace0_9927_bd2a;
}
