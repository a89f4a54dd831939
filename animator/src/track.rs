//! One track at one time.

use glam::{DQuat, DVec3};
use kinora_scene::{Color, Keys, Space, Track, Value};

use crate::{ease::ease, tape};

/// A value of which there is something between two.
pub trait Blend: Value + Clone {
    /// The value the part `t` of the way from `self` to `to`; `t` may leave 0..=1.
    fn blend(&self, to: &Self, t: f64) -> Self;

    /// The value a tape's outputs make; `parts` has [`Value::COMPONENTS`] of them. What cannot be made comes out as NaN.
    fn assemble(parts: &[f64]) -> Self {
        Self::from_components(parts)
    }
}

impl Blend for f64 {
    fn blend(&self, to: &Self, t: f64) -> Self {
        self + (to - self) * t
    }
}

/// The old value holds until the key is reached.
impl Blend for bool {
    fn blend(&self, _: &Self, _: f64) -> Self {
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
        let to = if self.dot(*to) < 0.0 { -*to } else { *to };
        // Half the chord over half the diagonal: exact for small angles, where the cosine is not.
        let angle = 2.0 * (*self - to).length().atan2((*self + to).length());
        let (from_share, to_share) =
            if angle > 1e-8 { (((1.0 - t) * angle).sin(), (t * angle).sin()) } else { (1.0 - t, t) };
        unit(*self * from_share + to * to_share)
    }

    fn assemble(parts: &[f64]) -> Self {
        match parts {
            &[x, y, z, w] => unit(DQuat::from_xyzw(x, y, z, w)),
            _ => DQuat::NAN,
        }
    }
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
        Track::Curve(tape) => {
            let mut parts = tape::run(tape, time_s, fps);
            parts.resize(T::COMPONENTS, f64::NAN);
            T::assemble(&parts)
        }
    }
}

/// The value of keyframes: the ease of the key being reached, and the first and last value outside.
pub(crate) fn at<T: Blend>(keys: &Keys<T>, time_s: f64) -> T {
    let Space::Linear = keys.space;
    let kinora_scene::Outside::Hold = keys.outside;
    let passed = keys.keys.partition_point(|key| key.time_s <= time_s);
    let from = passed.checked_sub(1).and_then(|last| keys.keys.get(last));
    match (from, keys.keys.get(passed)) {
        (Some(from), Some(to)) => {
            let t = ease(to.ease, (time_s - from.time_s) / (to.time_s - from.time_s));
            match t {
                0.0 => from.value.clone(),
                1.0 => to.value.clone(),
                _ => from.value.blend(&to.value, t),
            }
        }
        (Some(held), None) | (None, Some(held)) => held.value.clone(),
        (None, None) => T::assemble(&vec![f64::NAN; T::COMPONENTS]),
    }
}
