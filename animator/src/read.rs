//! Reads tracks and judges what they give.

use glam::{DQuat, DVec3};
use kinora_scene::{Color, Tape, Track};

use crate::{
    error::{Fault, Place, SampleError},
    tape,
    track::{Blend, lacks, unit, value},
};

/// Rounding may carry a value so far over the end of its range; it is taken as the end.
const SLACK: f64 = 1e-6;

/// An instant of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Now {
    pub time_s: f64,
    pub fps: f64,
}

impl Now {
    pub fn reader(self, place: Place, name: &str) -> Reader<'_> {
        Reader { now: self, place, name }
    }
}

/// What a number may be.
#[derive(Clone, Copy)]
pub(crate) enum Range {
    Any,
    AboveZero,
    FromZero,
    ZeroToOne,
    FromOne,
    ZeroToPi,
    ZeroToTwoPi,
}

impl Range {
    /// The number, moved to the nearer end if it is over it by no more than rounding.
    fn fit(self, x: f64) -> Result<f64, Fault> {
        let (low, high, fits, range) = match self {
            Range::Any => (f64::MIN, f64::MAX, true, "a number"),
            Range::AboveZero => (0.0, f64::MAX, x > 0.0, "above 0"),
            Range::FromZero => (0.0, f64::MAX, x >= -SLACK, "0 or more"),
            Range::ZeroToOne => (0.0, 1.0, (-SLACK..=1.0 + SLACK).contains(&x), "0 to 1"),
            Range::FromOne => (1.0, f64::MAX, x >= 1.0 - SLACK, "1 or more"),
            Range::ZeroToPi => {
                (0.0, std::f64::consts::PI, x > 0.0 && x < std::f64::consts::PI, "above 0 and below 180 degrees")
            }
            Range::ZeroToTwoPi => (
                0.0,
                std::f64::consts::TAU,
                x > 0.0 && x <= std::f64::consts::TAU + SLACK,
                "above 0 and at most 360 degrees",
            ),
        };
        if !x.is_finite() {
            Err(Fault::NotFinite)
        } else if fits {
            Ok(x.clamp(low, high))
        } else {
            Err(Fault::OutOfRange { value: x, range })
        }
    }
}

/// Reads the properties of one part of a scene at one instant.
#[derive(Clone, Copy)]
pub(crate) struct Reader<'a> {
    now: Now,
    place: Place,
    name: &'a str,
}

impl Reader<'_> {
    pub fn error(self, property: &'static str, fault: Fault) -> SampleError {
        SampleError { place: self.place, name: self.name.to_owned(), property, time_s: self.now.time_s, fault }
    }

    /// A texture's tape at the time.
    pub fn still(self, tape: &Tape) -> Tape {
        tape::still(tape, self.now.time_s, self.now.fps)
    }

    /// The outputs of a tape at the time.
    pub fn run(self, tape: &Tape) -> Vec<f64> {
        tape::run(tape, self.now.time_s, self.now.fps)
    }

    fn value<T: Blend>(self, track: &Track<T>) -> T {
        value(track, self.now.time_s, self.now.fps)
    }

    /// An error of a value: where it is no number because keys have none at this time, that.
    fn fault<T>(self, property: &'static str, track: &Track<T>, fault: Fault) -> SampleError {
        let time_s = self.now.time_s;
        let lacking = match track {
            Track::Const(_) => false,
            Track::Clocked { keys, clock } => lacks(keys, self.value(clock)),
            Track::Keys(keys) => lacks(keys, time_s),
            Track::Curve(tape) => {
                tape.curves.iter().any(|keys| lacks(keys, time_s)) || tape.turns.iter().any(|keys| lacks(keys, time_s))
            }
        };
        self.error(property, if fault == Fault::NotFinite && lacking { Fault::OutsideKeys } else { fault })
    }

    pub fn flag(self, property: &'static str, track: &Track<bool>) -> Result<bool, SampleError> {
        let known = match track {
            Track::Const(_) => true,
            Track::Clocked { keys, clock } => !lacks(keys, self.value(clock)),
            Track::Keys(keys) => !lacks(keys, self.now.time_s),
            Track::Curve(tape) => tape::run(tape, self.now.time_s, self.now.fps).iter().all(|part| !part.is_nan()),
        };
        if known { Ok(self.value(track)) } else { Err(self.fault(property, track, Fault::NotFinite)) }
    }

    pub fn number(self, property: &'static str, track: &Track<f64>, range: Range) -> Result<f64, SampleError> {
        range.fit(self.value(track)).map_err(|fault| self.fault(property, track, fault))
    }

    /// A number that stands still.
    pub fn check(self, property: &'static str, x: f64, range: Range) -> Result<f64, SampleError> {
        range.fit(x).map_err(|fault| self.error(property, fault))
    }

    pub fn vector(self, property: &'static str, track: &Track<DVec3>) -> Result<DVec3, SampleError> {
        let v: DVec3 = self.value(track);
        if v.is_finite() { Ok(v) } else { Err(self.fault(property, track, Fault::NotFinite)) }
    }

    pub fn finite(self, property: &'static str, v: DVec3) -> Result<DVec3, SampleError> {
        if v.is_finite() { Ok(v) } else { Err(self.error(property, Fault::NotFinite)) }
    }

    pub fn rotation(self, property: &'static str, track: &Track<DQuat>) -> Result<DQuat, SampleError> {
        let q = unit(self.value(track));
        if q.is_finite() { Ok(q) } else { Err(self.fault(property, track, Fault::NotFinite)) }
    }

    pub fn color(self, property: &'static str, track: &Track<Color>, range: Range) -> Result<Color, SampleError> {
        let mut color = self.value(track);
        for channel in color.as_mut() {
            let fit = range.fit(f64::from(*channel));
            *channel = fit.map_err(|fault| self.fault(property, track, fault))? as f32;
        }
        Ok(color)
    }
}
