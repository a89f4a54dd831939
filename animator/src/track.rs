//! One track at one time.

use glam::{DQuat, DVec3};
use kinora_scene::{Color, Key, Keys, Outside, Track, Value, Way};

use crate::{
    ease::{ease, end_slope},
    tape,
};

/// A value of which there is something between two.
pub trait Blend: Value + Clone {
    /// The value the part `t` of the way from `self` to `to`; `t` may leave 0..=1.
    fn blend(&self, to: &Self, t: f64) -> Self;

    /// The value a tape's outputs make; `parts` has [`Value::COMPONENTS`] of them. What cannot be made comes out as NaN.
    fn assemble(parts: &[f64]) -> Self {
        Self::from_components(parts)
    }

    /// The value the part `t` of the way along the cubic from `self` to `to` that leaves with `out` and arrives with `into`,
    /// both a second, in `seconds`: glTF 2.0, appendix C.4.
    fn cubic(&self, out: &Self, to: &Self, into: &Self, seconds: f64, t: f64) -> Self {
        let (t2, t3) = (t * t, t * t * t);
        let weights =
            [2.0 * t3 - 3.0 * t2 + 1.0, seconds * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, seconds * (t3 - t2)];
        let points = [self, out, to, into].map(Value::components);
        let sum = |i: usize| weights.iter().zip(&points).map(|(weight, parts)| weight * parts[i]).sum();
        Self::assemble(&(0..Self::COMPONENTS).map(sum).collect::<Vec<f64>>())
    }

    /// The value after so much more of `tangent`.
    fn extend(&self, tangent: &Self, far: f64) -> Self {
        let (parts, tangent) = (self.components(), tangent.components());
        Self::assemble(&parts.iter().zip(tangent).map(|(part, tangent)| part + tangent * far).collect::<Vec<f64>>())
    }

    /// The value the part `t` of the way along the squad from the second to the third of four neighbours.
    fn squad(_: Option<&Self>, from: &Self, to: &Self, _: Option<&Self>, t: f64) -> Self {
        from.blend(to, t)
    }
}

impl Blend for f64 {
    fn blend(&self, to: &Self, t: f64) -> Self {
        self + (to - self) * t
    }
}

/// The old value holds until the key is reached.
impl Blend for bool {
    fn blend(&self, to: &Self, t: f64) -> Self {
        if t < 1.0 { *self } else { *to }
    }

    fn cubic(&self, _: &Self, to: &Self, _: &Self, _: f64, t: f64) -> Self {
        self.blend(to, t)
    }

    fn extend(&self, _: &Self, _: f64) -> Self {
        *self
    }
}

impl Blend for DVec3 {
    fn blend(&self, to: &Self, t: f64) -> Self {
        *self + (*to - *self) * t
    }
}

/// In linear light.
impl Blend for Color {
    fn blend(&self, to: &Self, t: f64) -> Self {
        self.as_dvec3().blend(&to.as_dvec3(), t).as_vec3()
    }
}

/// Along the shorter arc, at constant speed.
impl Blend for DQuat {
    fn blend(&self, to: &Self, t: f64) -> Self {
        slerp(*self, near(*to, *self), t)
    }

    fn assemble(parts: &[f64]) -> Self {
        match parts {
            &[x, y, z, w] => unit(DQuat::from_xyzw(x, y, z, w)),
            _ => DQuat::NAN,
        }
    }

    /// At the angular velocity that the tangent, a quaternion a second, has at this rotation.
    fn extend(&self, tangent: &Self, far: f64) -> Self {
        let spin = self.conjugate() * *tangent;
        unit(*self * exp(DVec3::new(spin.x, spin.y, spin.z) * far))
    }

    /// Shoemake 1987: keys count as evenly spaced.
    fn squad(before: Option<&Self>, from: &Self, to: &Self, after: Option<&Self>, t: f64) -> Self {
        let from = *from;
        let to = near(*to, from);
        // At an end the control is the key itself, and the way goes on as the arc does.
        let control = |beyond: Option<&DQuat>, here: DQuat, other: DQuat| match beyond {
            Some(beyond) => {
                let back = here.conjugate();
                here * exp((log(back * near(*beyond, here)) + log(back * other)) * -0.25)
            }
            None => here,
        };
        let (out, into) = (control(before, from, to), control(after, to, from));
        slerp(slerp(from, to, t), slerp(out, into, t), 2.0 * t * (1.0 - t))
    }
}

/// Of q and −q, which are one rotation, the one that is nearer to `other`.
fn near(q: DQuat, other: DQuat) -> DQuat {
    if other.dot(q) < 0.0 { -q } else { q }
}

/// Along the arc between two unit quaternions as they are, at constant speed.
fn slerp(from: DQuat, to: DQuat, t: f64) -> DQuat {
    // Half the chord over half the diagonal: exact for small angles, where the cosine is not.
    let angle = 2.0 * (from - to).length().atan2((from + to).length());
    let (from_share, to_share) =
        if angle > 1e-8 { (((1.0 - t) * angle).sin(), (t * angle).sin()) } else { (1.0 - t, t) };
    unit(from * from_share + to * to_share)
}

/// Half the angle times the axis of a unit quaternion.
fn log(q: DQuat) -> DVec3 {
    let axis = DVec3::new(q.x, q.y, q.z);
    let sine = axis.length();
    if sine > 1e-12 { axis * (sine.atan2(q.w) / sine) } else { axis }
}

/// The inverse of [`log`].
fn exp(v: DVec3) -> DQuat {
    let angle = v.length();
    let axis = if angle > 1e-12 { v * (angle.sin() / angle) } else { v };
    DQuat::from_xyzw(axis.x, axis.y, axis.z, angle.cos())
}

/// The rotation without its length; NaN where it has none.
pub(crate) fn unit(q: DQuat) -> DQuat {
    let length = q.length();
    if length > 0.0 && length.is_finite() { q / length } else { DQuat::NAN }
}

/// The value of a track at `time_s` seconds from the start of a scene with `fps` frames a second.
///
/// Total: whatever the track holds, something comes out. Where there is no value (a tape that divides by 0, keys without
/// a key) its numbers are NaN or infinite, which [`crate::sample`] reports.
pub fn value<T: Blend>(track: &Track<T>, time_s: f64, fps: f64) -> T {
    match track {
        Track::Const(value) => value.clone(),
        Track::Keys(keys) => at(keys, time_s),
        Track::Clocked { keys, clock } => at(keys, value(clock, time_s, fps)),
        Track::Curve(tape) => {
            let mut parts = tape::run(tape, time_s, fps);
            parts.resize(T::COMPONENTS, f64::NAN);
            T::assemble(&parts)
        }
    }
}

/// Keys that are so little late, in seconds, are reached: a sum of key times is rounded.
const SNAP_S: f64 = 1e-9;

/// The value of keyframes: between keys the curve, its parameter by the ease of the key being reached, and outside what
/// [`Outside`] says.
pub(crate) fn at<T: Blend>(keys: &Keys<T>, time_s: f64) -> T {
    let nothing = || T::assemble(&vec![f64::NAN; T::COMPONENTS]);
    let (Some(first), Some(last), false) = (keys.keys.first(), keys.keys.last(), time_s.is_nan()) else {
        return nothing();
    };
    let length = last.time_s - first.time_s;
    let since = time_s - first.time_s;
    let before = since < -SNAP_S;
    let outside = before || since > length + SNAP_S;
    match keys.outside {
        Outside::Loop if length > 0.0 => within(keys, first.time_s + wrapped(since, length)),
        Outside::PingPong if length > 0.0 => {
            let there = wrapped(since, 2.0 * length);
            within(keys, first.time_s + if there > length { 2.0 * length - there } else { there })
        }
        Outside::Extend if outside => beyond(keys, before, time_s),
        Outside::Error if outside => nothing(),
        _ => within(keys, time_s),
    }
}

/// Whether the keys have no value at this time because they end before it, or begin after it.
pub(crate) fn lacks<T>(keys: &Keys<T>, time_s: f64) -> bool {
    let beside = |first: &Key<T>, last: &Key<T>| time_s < first.time_s - SNAP_S || time_s > last.time_s + SNAP_S;
    keys.outside == Outside::Error
        && keys.keys.first().zip(keys.keys.last()).is_none_or(|(first, last)| beside(first, last))
}

/// The time within a period; what a rounding error alone keeps from its end is its beginning.
fn wrapped(time_s: f64, period_s: f64) -> f64 {
    let rest = time_s.rem_euclid(period_s);
    if period_s - rest <= SNAP_S.min(1e-6 * period_s) { 0.0 } else { rest }
}

fn within<T: Blend>(keys: &Keys<T>, time_s: f64) -> T {
    let passed = keys.keys.partition_point(|key| key.time_s <= time_s + SNAP_S);
    match (passed.checked_sub(1), keys.keys.get(passed)) {
        (Some(from), Some(_)) => segment(keys, from, time_s),
        (Some(held), None) => keys.keys[held].value.clone(),
        (None, Some(held)) => held.value.clone(),
        (None, None) => T::assemble(&vec![f64::NAN; T::COMPONENTS]),
    }
}

/// The value on the way from the key with this index to the next.
fn segment<T: Blend>(keys: &Keys<T>, index: usize, time_s: f64) -> T {
    let (from, to) = (&keys.keys[index], &keys.keys[index + 1]);
    let length = to.time_s - from.time_s;
    let t = ease(&to.ease, (time_s - from.time_s) / length);
    match (t, &keys.way) {
        (0.0, _) => from.value.clone(),
        (1.0, _) => to.value.clone(),
        (_, Way::Cubic(tangents)) => match (tangents.get(index), tangents.get(index + 1)) {
            (Some([_, out]), Some([into, _])) => from.value.cubic(out, &to.value, into, length, t),
            _ => from.value.blend(&to.value, t),
        },
        (_, Way::Squad) => {
            let (before, after) = neighbours(keys, index);
            T::squad(before, &from.value, &to.value, after, t)
        }
        (_, Way::Straight) => from.value.blend(&to.value, t),
    }
}

/// The keys before and after a segment; those of a loop that ends where it begins are its neighbours' too.
fn neighbours<T: Blend>(keys: &Keys<T>, index: usize) -> (Option<&T>, Option<&T>) {
    let count = keys.keys.len();
    let value = |index: usize| keys.keys.get(index).map(|key| &key.value);
    let closed = || {
        let ends = keys.keys.first().zip(keys.keys.last());
        let off = ends.map(|(first, last)| {
            let (a, b) = (first.value.components(), last.value.components());
            let apart = |sign: f64| a.iter().zip(&b).map(|(a, b)| (a - sign * b).abs()).fold(0.0, f64::max);
            apart(1.0).min(apart(-1.0))
        });
        keys.outside == Outside::Loop && count > 2 && off.is_some_and(|off| off < 1e-9)
    };
    let before = match index.checked_sub(1) {
        Some(before) => value(before),
        None => value(count.wrapping_sub(2)).filter(|_| closed()),
    };
    let after = match index + 2 < count {
        true => value(index + 2),
        false => value(1).filter(|_| closed()),
    };
    (before, after)
}

/// The value before the first or after the last key of what goes on as fast as it comes in.
fn beyond<T: Blend>(keys: &Keys<T>, before: bool, time_s: f64) -> T {
    let held = |index: usize| keys.keys.get(index).map(|key| &key.value);
    let count = keys.keys.len();
    let end = if before { 0 } else { count - 1 };
    let nothing = || T::assemble(&vec![f64::NAN; T::COMPONENTS]);
    let Some(value) = held(end) else { return nothing() };
    let Some(inner) = (if before { (count > 1).then_some(1) } else { end.checked_sub(1) }) else {
        return value.clone();
    };
    let (near, far) = (&keys.keys[end], &keys.keys[inner]);
    let slope = end_slope(&keys.keys[end.max(inner)].ease, !before);
    if slope == 0.0 {
        return value.clone();
    }
    match &keys.way {
        Way::Cubic(tangents) => match tangents.get(end) {
            Some([into, out]) => value.extend(if before { out } else { into }, slope * (time_s - near.time_s)),
            None => value.clone(),
        },
        // A squad leaves its ends as the arc beside them.
        Way::Straight | Way::Squad => {
            far.value.blend(value, 1.0 + slope * (time_s - near.time_s) / (near.time_s - far.time_s))
        }
    }
}
