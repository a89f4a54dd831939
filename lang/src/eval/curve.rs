//! Keyframes as curves that can be computed with.

use std::sync::Arc;

use glam::DQuat;
use kinora_scene::{Binary, Ease, Key, Keys, Outside, Way};

use crate::builtin::color::{from_oklch, to_oklch};
use crate::builtin::{quaternion, turn};
use crate::dimension::Dimension;
use crate::eval::graph::{Graph, Scalar};
use crate::eval::machine::Machine;
use crate::value::{Keyed, Number, Through, Value};

/// Components of one key after the other.
type Rows = Vec<Vec<Scalar>>;

/// Chroma below which a colour has no hue (CSS Color 4, for OKLCh).
const NO_HUE: f64 = 4e-6;

impl Machine<'_> {
    /// Keys as curves that can be computed with; everything else as it is.
    pub fn flatten(&mut self, value: Value) -> Value {
        match &value {
            Value::Keys(keyed) => curve(&mut self.graph, keyed).unwrap_or(Value::Error),
            _ => value,
        }
    }
}

/// The value of the keys at `time`.
fn curve(graph: &mut Graph, keyed: &Keyed) -> Option<Value> {
    let first = keyed.keys.first()?;
    let mut rows: Rows = keyed.keys.iter().map(|key| leaves(&key.value)).collect::<Option<_>>()?;
    if rows.iter().any(|row| row.len() != rows[0].len()) {
        return None;
    }
    if let Value::Turn(_) = first.value {
        return rotation(graph, keyed, rows).map(Value::Turn);
    }
    let limit = if keyed.oklch { Some(hues(graph, &mut rows)) } else { None };
    let tangents = match keyed.through {
        Through::Straight => None,
        Through::Spline => Some(spline(graph, &times(keyed), &rows, keyed.outside)),
        Through::Tangents => Some(written(keyed, rows[0].len())?),
    };
    let mut run = Run { times: times(keyed), keyed, progress: Vec::new() };
    let mut parts = Vec::with_capacity(rows[0].len());
    for i in 0..rows[0].len() {
        let column: Vec<Scalar> = rows.iter().map(|row| row[i]).collect();
        let tangents = tangents.as_ref().map(|all| all.iter().map(|[a, b]| [a[i], b[i]]).collect::<Vec<_>>());
        parts.push(run.column(graph, &column, tangents.as_deref()));
    }
    if let (Some(limit), [l, c, h]) = (limit, parts.as_slice()) {
        let rgb = from_oklch(graph, [*l, *c, *h]);
        return Some(Value::Color(rgb.map(|channel| graph.binary(Binary::Min, channel, limit))));
    }
    let like: Vec<&Value> = keyed.keys.iter().map(|key| &key.value).collect();
    assemble(&like, &mut parts.into_iter())
}

/// The components of keys that stand still, with their tangents, as a property keeps them whole; `rows` are the values in
/// the property's own units, `slopes` the tangents that are written.
pub fn whole(
    graph: &mut Graph,
    keyed: &Keyed,
    rows: Vec<Vec<f64>>,
    slopes: Option<Vec<[Vec<f64>; 2]>>,
) -> Option<Keys<Vec<f64>>> {
    let turns = matches!(keyed.keys.first()?.value, Value::Turn(_));
    let (mut rows, mut slopes) = (rows, slopes);
    let way = match keyed.through {
        Through::Straight => Way::Straight,
        Through::Spline if turns => Way::Squad,
        Through::Spline => {
            let scalars: Rows = rows.iter().map(|row| row.iter().map(|part| Scalar::Const(*part)).collect()).collect();
            let known = |row: &Vec<Scalar>| row.iter().map(|part| part.constant()).collect::<Option<Vec<f64>>>();
            let tangents = spline(graph, &times(keyed), &scalars, keyed.outside);
            Way::Cubic(tangents.iter().map(|[a, b]| Some([known(a)?, known(b)?])).collect::<Option<_>>()?)
        }
        Through::Tangents => {
            let mut slopes = slopes.take()?;
            if turns {
                align(&mut rows, &mut slopes);
            }
            Way::Cubic(slopes)
        }
    };
    let keys = keyed.keys.iter().zip(rows);
    let keys = keys.map(|(key, value)| Key { time_s: key.time_s, value, ease: key.ease.clone() }).collect();
    Some(Keys { keys, way, outside: keyed.outside })
}

/// Of q and −q, which are one rotation, takes the one that is nearer to the key before.
fn align(rows: &mut [Vec<f64>], slopes: &mut [[Vec<f64>; 2]]) {
    for i in 1..rows.len().min(slopes.len()) {
        let dot: f64 = rows[i].iter().zip(&rows[i - 1]).map(|(a, b)| a * b).sum();
        if dot < 0.0 {
            rows[i].iter_mut().chain(slopes[i].iter_mut().flatten()).for_each(|part| *part = -*part);
        }
    }
}

fn times(keyed: &Keyed) -> Vec<f64> {
    keyed.keys.iter().map(|key| key.time_s).collect()
}

/// The numbers in a value, from left to right.
fn leaves(value: &Value) -> Option<Vec<Scalar>> {
    Some(match value {
        Value::Number(number) => vec![number.value],
        Value::Bool(part) => vec![*part],
        Value::Color(parts) => parts.to_vec(),
        Value::Turn(parts) => parts.to_vec(),
        Value::Tuple(items) => items.iter().map(leaves).collect::<Option<Vec<_>>>()?.concat(),
        _ => return None,
    })
}

/// The inverse of [`leaves`]; a number has the dimension of the first key that has one there.
fn assemble(like: &[&Value], parts: &mut impl Iterator<Item = Scalar>) -> Option<Value> {
    Some(match like.first()? {
        Value::Number(first) => {
            let measured = like.iter().find_map(|value| match value {
                Value::Number(number) if !number.dimension.is_none() => Some(number.dimension),
                _ => None,
            });
            Value::Number(Number::new(parts.next()?, measured.unwrap_or(first.dimension)))
        }
        Value::Bool(_) => Value::Bool(parts.next()?),
        Value::Color(_) => Value::Color([parts.next()?, parts.next()?, parts.next()?]),
        Value::Tuple(items) => {
            let items = (0..items.len()).map(|i| {
                let inside: Option<Vec<&Value>> = like
                    .iter()
                    .map(|value| match value {
                        Value::Tuple(items) => items.get(i),
                        _ => None,
                    })
                    .collect();
                assemble(&inside?, parts)
            });
            Value::Tuple(items.collect::<Option<Vec<_>>>()?.into())
        }
        _ => return None,
    })
}

/// The tangents as they are written; 0 where none is.
fn written(keyed: &Keyed, count: usize) -> Option<Vec<[Vec<Scalar>; 2]>> {
    let level = || vec![Scalar::Const(0.0); count];
    let of = |value: &Value| leaves(value).filter(|parts| parts.len() == count);
    let all = keyed.keys.iter().map(|key| match &key.tangents {
        Some(two) => Some([of(&two[0])?, of(&two[1])?]),
        None => Some([level(), level()]),
    });
    all.collect()
}

/// The tangents in and out, a second, of the centripetal Catmull–Rom spline (Yuksel et al. 2011): its knots are apart by
/// the roots of the distances. At its ends it runs straight, unless it is a loop that ends where it begins.
fn spline(graph: &mut Graph, times: &[f64], rows: &Rows, outside: Outside) -> Vec<[Vec<Scalar>; 2]> {
    let count = rows.len();
    let knots: Vec<(Vec<Scalar>, Scalar)> = rows
        .windows(2)
        .map(|two| {
            let apart: Vec<Scalar> = two[0].iter().zip(&two[1]).map(|(a, b)| graph.sub(*b, *a)).collect();
            let square = graph.dot(&apart, &apart);
            (apart, graph.binary(Binary::Pow, square, 0.25.into()))
        })
        .collect();
    let same = |a: &Scalar, b: &Scalar| match (a.constant(), b.constant()) {
        (Some(a), Some(b)) => (a - b).abs() < 1e-9,
        _ => a == b,
    };
    let closed = outside == Outside::Loop && count > 2 && rows[0].iter().zip(&rows[count - 1]).all(|(a, b)| same(a, b));
    let level = || vec![Scalar::Const(0.0); rows.first().map_or(0, Vec::len)];
    let mut tangents = Vec::with_capacity(count);
    for i in 0..count {
        let before = i.checked_sub(1).or(closed.then_some(count.wrapping_sub(2)));
        let after = if i + 1 < count { Some(i) } else { closed.then_some(0) };
        let straight = |graph: &mut Graph, segment: usize| -> Vec<Scalar> {
            let seconds = times[segment + 1] - times[segment];
            knots[segment].0.iter().map(|part| graph.div(*part, seconds.into())).collect()
        };
        tangents.push(match (before, after) {
            (Some(before), Some(after)) => {
                let ((a, d), (b, e)) = (&knots[before], &knots[after]);
                let sum = graph.add(*d, *e);
                let mut speed = Vec::with_capacity(a.len());
                for (a, b) in a.iter().zip(b) {
                    let across = graph.add(*a, *b);
                    let (one, two) = (over(graph, *a, *d), over(graph, *b, *e));
                    let three = over(graph, across, sum);
                    let ends = graph.add(one, two);
                    speed.push(graph.sub(ends, three));
                }
                let scaled = |graph: &mut Graph, knot: Scalar, segment: usize| -> Vec<Scalar> {
                    let factor = graph.div(knot, (times[segment + 1] - times[segment]).into());
                    speed.iter().map(|part| graph.mul(*part, factor)).collect()
                };
                [scaled(graph, *d, before), scaled(graph, *e, after)]
            }
            (Some(before), None) => [straight(graph, before), level()],
            (None, Some(after)) => [level(), straight(graph, after)],
            (None, None) => [level(), level()],
        });
    }
    tangents
}

/// a / b, and 0 where b is 0.
fn over(graph: &mut Graph, a: Scalar, b: Scalar) -> Scalar {
    let quotient = graph.div(a, b);
    graph.select(b, quotient, 0.0.into())
}

/// Makes lightness, chroma and hue of linear colours, each hue the nearer way round from the one before; returns what no
/// channel of the curve may exceed: 1, or the greatest channel of a key.
fn hues(graph: &mut Graph, rows: &mut Rows) -> Scalar {
    let mut limit = Scalar::Const(1.0);
    for row in rows.iter_mut() {
        for channel in row.iter() {
            limit = graph.binary(Binary::Max, limit, *channel);
        }
        if let [r, g, b] = *row.as_slice() {
            *row = to_oklch(graph, [r, g, b]).to_vec();
        }
    }
    // A grey has the hue of the colour before it, or else of the first after it.
    let grey = |graph: &mut Graph, row: &[Scalar]| graph.binary(Binary::Less, row[1], NO_HUE.into());
    let mut hue = Scalar::Const(0.0);
    for row in rows.iter().rev() {
        let no_hue = grey(graph, row);
        hue = graph.select(no_hue, hue, row[2]);
    }
    let (half, whole) = (std::f64::consts::PI, std::f64::consts::TAU);
    for row in rows.iter_mut() {
        let no_hue = grey(graph, row);
        let own = graph.select(no_hue, hue, row[2]);
        let apart = graph.sub(own, hue);
        let shifted = graph.add(apart, half.into());
        let round = graph.binary(Binary::Mod, shifted, whole.into());
        let step = graph.sub(round, half.into());
        hue = graph.add(hue, step);
        row[2] = hue;
    }
    limit
}

/// What the columns of one curve share.
struct Run<'k> {
    times: Vec<f64>,
    keyed: &'k Keyed,
    /// How far each segment has come, as often as it was asked for.
    progress: Vec<Scalar>,
}

impl Run<'_> {
    /// One component over time.
    fn column(&mut self, graph: &mut Graph, values: &[Scalar], tangents: Option<&[[Scalar; 2]]>) -> Scalar {
        let known: Option<Vec<f64>> = values.iter().map(|value| value.constant()).collect();
        let slopes: Option<Option<Vec<[f64; 2]>>> = tangents
            .map(|all| all.iter().map(|[a, b]| Some([a.constant()?, b.constant()?])).collect::<Option<_>>())
            .map_or(Some(None), |known| known.map(Some));
        if let (Some(values), Some(slopes)) = (known, slopes) {
            let keys = self.keyed.keys.iter().zip(values);
            let keys = keys.map(|(key, value)| Key { time_s: key.time_s, value, ease: key.ease.clone() }).collect();
            let way = slopes.map_or(Way::Straight, Way::Cubic);
            return graph.curve(Keys { keys, way, outside: self.keyed.outside });
        }
        self.moving(graph, values, tangents)
    }

    /// The same where keys move themselves: the first one, and of each segment as much as it has come.
    fn moving(&mut self, graph: &mut Graph, values: &[Scalar], tangents: Option<&[[Scalar; 2]]>) -> Scalar {
        // A cubic that goes on beyond its end goes on straight.
        let extend = tangents.is_some() && self.keyed.outside == Outside::Extend;
        let outside = if extend { Outside::Hold } else { self.keyed.outside };
        self.follow(graph, outside);
        let Some(mut sum) = values.first().copied() else { return Scalar::Const(f64::NAN) };
        for (i, two) in values.windows(2).enumerate() {
            let t = self.progress[i];
            let apart = graph.sub(two[1], two[0]);
            let Some(tangents) = tangents else {
                let part = graph.mul(apart, t);
                sum = graph.add(sum, part);
                continue;
            };
            let seconds = Scalar::Const(self.times[i + 1] - self.times[i]);
            let (square, cube) = {
                let square = graph.mul(t, t);
                (square, graph.mul(square, t))
            };
            let level = weighed(graph, [(3.0, square), (-2.0, cube)]);
            let back = weighed(graph, [(1.0, cube), (-1.0, square)]);
            let out = weighed(graph, [(1.0, back), (-1.0, square)]);
            let out = graph.add(out, t);
            for (value, weight, length) in
                [(apart, level, None), (tangents[i][1], out, Some(seconds)), (tangents[i + 1][0], back, Some(seconds))]
            {
                let part = graph.mul(value, weight);
                let part = length.map_or(part, |length| graph.mul(part, length));
                sum = graph.add(sum, part);
            }
        }
        let last = values.len() - 1;
        if let (true, Some(tangents), true) = (extend, tangents, last > 0) {
            for (segment, slope) in [(0, tangents[0][1]), (last - 1, tangents[last][0])] {
                let seconds = self.times[segment + 1] - self.times[segment];
                let on = progress(graph, self.keyed, segment, Outside::Extend);
                let held = progress(graph, self.keyed, segment, Outside::Hold);
                let over = graph.sub(on, held);
                // Within the other end, both are the same.
                let part = graph.mul(over, slope);
                let part = graph.mul(part, seconds.into());
                sum = graph.add(sum, part);
            }
        }
        sum
    }

    fn follow(&mut self, graph: &mut Graph, outside: Outside) {
        if self.progress.is_empty() {
            let segments = 0..self.times.len().saturating_sub(1);
            self.progress = segments.map(|segment| progress(graph, self.keyed, segment, outside)).collect();
        }
    }
}

fn weighed(graph: &mut Graph, parts: [(f64, Scalar); 2]) -> Scalar {
    let [a, b] = parts.map(|(weight, of)| graph.mul(weight.into(), of));
    graph.add(a, b)
}

/// How far a segment has come: 0 before it, 1 after it, as its key's ease says within.
fn progress(graph: &mut Graph, keyed: &Keyed, segment: usize, outside: Outside) -> Scalar {
    let key =
        |index: usize, value: f64, ease: Ease| keyed.keys.get(index).map(|key| Key { time_s: key.time_s, value, ease });
    let last = keyed.keys.len().saturating_sub(1);
    let arriving = keyed.keys.get(segment + 1).map_or(Ease::Linear, |key| key.ease.clone());
    let mut keys = Vec::with_capacity(4);
    if segment > 0 {
        keys.extend(key(0, 0.0, Ease::Linear));
    }
    keys.extend(key(segment, 0.0, Ease::Step));
    keys.extend(key(segment + 1, 1.0, arriving));
    if segment + 1 < last {
        keys.extend(key(last, 1.0, Ease::Step));
    }
    graph.curve(Keys { keys, way: Way::Straight, outside })
}

/// Rotations over time.
fn rotation(graph: &mut Graph, keyed: &Keyed, rows: Rows) -> Option<[Scalar; 4]> {
    let four = |row: &Vec<Scalar>| <[Scalar; 4]>::try_from(row.as_slice()).ok();
    let mut keys: Vec<[Scalar; 4]> = rows.iter().map(four).collect::<Option<_>>()?;
    let mut tangents = match keyed.through {
        Through::Tangents => {
            let two = |[a, b]: &[Vec<Scalar>; 2]| Some([four(a)?, four(b)?]);
            Some(written(keyed, 4)?.iter().map(two).collect::<Option<Vec<_>>>()?)
        }
        _ => None,
    };
    let known: Option<Vec<DQuat>> = keys.iter().map(quaternion).collect();
    let slopes = tangents.as_ref().map(|all| {
        let two =
            |[a, b]: &[[Scalar; 4]; 2]| Some([quaternion(a)?.to_array().to_vec(), quaternion(b)?.to_array().to_vec()]);
        all.iter().map(two).collect::<Option<Vec<_>>>()
    });
    if let (Some(known), Some(slopes)) = (known, slopes.map_or(Some(None), |known| known.map(Some))) {
        let known = known.iter().map(|q| q.to_array().to_vec()).collect();
        let Keys { keys, way, outside } = whole(graph, keyed, known, slopes)?;
        let turn = |parts: Vec<f64>| <[f64; 4]>::try_from(parts).ok().map(DQuat::from_array);
        let way = match way {
            Way::Straight => Way::Straight,
            Way::Squad => Way::Squad,
            Way::Cubic(all) => {
                Way::Cubic(all.into_iter().map(|[a, b]| Some([turn(a)?, turn(b)?])).collect::<Option<_>>()?)
            }
        };
        let keys =
            keys.into_iter().map(|key| Some(Key { time_s: key.time_s, value: turn(key.value)?, ease: key.ease }));
        return Some(graph.turn(Keys { keys: keys.collect::<Option<_>>()?, way, outside }));
    }
    // They move themselves: each after the one before, of its two signs the nearer.
    for i in 1..keys.len() {
        let (signed, sign) = turn::near(graph, &keys[i], &keys[i - 1]);
        keys[i] = signed;
        if let Some(tangents) = &mut tangents {
            tangents[i] = tangents[i].map(|tangent| tangent.map(|part| graph.mul(part, sign)));
        }
    }
    let mut run = Run { times: times(keyed), keyed, progress: Vec::new() };
    if let Some(tangents) = tangents {
        let parts = [0, 1, 2, 3].map(|i| {
            let column: Vec<Scalar> = keys.iter().map(|key| key[i]).collect();
            let tangents: Vec<[Scalar; 2]> = tangents.iter().map(|[a, b]| [a[i], b[i]]).collect();
            run.moving(graph, &column, Some(&tangents))
        });
        return Some(turn::unit(graph, &parts));
    }
    run.follow(graph, keyed.outside);
    let mut value = *keys.first()?;
    for (i, t) in run.progress.iter().enumerate() {
        let (from, to) = (keys[i], keys[i + 1]);
        let inside = match keyed.through {
            Through::Spline => {
                let before = i.checked_sub(1).map(|before| keys[before]);
                turn::squad(graph, before, from, to, keys.get(i + 2).copied(), *t)
            }
            _ => turn::slerp(graph, &from, &to, *t),
        };
        value = [0, 1, 2, 3].map(|part| graph.select(*t, inside[part], value[part]));
    }
    Some(value)
}

/// Tangents of a rotation: the change of the quaternion where it turns at this angular velocity.
pub fn spun(graph: &mut Graph, q: &[Scalar; 4], spin: [Scalar; 3]) -> [Scalar; 4] {
    let [x, y, z] = spin.map(|part| graph.mul(part, 0.5.into()));
    turn::turn_after(graph, &[x, y, z, Scalar::Const(0.0)], q)
}

/// The dimension that a tangent written in this one has as a part of the value: both in the value's own unit and in that a
/// second are understood. `None` where it is neither.
pub fn slope_of(value: Dimension, tangent: Dimension) -> Option<Dimension> {
    if tangent.is_none() || tangent == value {
        return Some(tangent);
    }
    tangent
        .times(Dimension::TIME)
        .filter(|of| *of == value || value.is_none() && matches!(*of, Dimension::NONE | Dimension::LENGTH))
}

/// The keys, shared.
pub fn shared(keyed: Keyed) -> Value {
    Value::Keys(Arc::new(keyed))
}
