//! Tracks: values over time, as data. The animator evaluates them.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Color, Tape};

/// A value over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Track<T> {
    /// The same at all times.
    Const(T),
    /// Keyframes.
    Keys(Keys<T>),
    /// Keyframes by a clock of their own.
    Clocked {
        /// The keyframes, their times as the clock tells them.
        keys: Box<Keys<T>>,
        /// Seconds, over the scene's time.
        clock: Arc<Track<f64>>,
    },
    /// An expression over `time`; its outputs are the components of `T` (see [`Value`]).
    Curve(Box<Tape>),
}

impl<T> Track<T> {
    /// The value, if it is the same at all times.
    pub fn constant(&self) -> Option<&T> {
        match self {
            Track::Const(value) => Some(value),
            _ => None,
        }
    }
}

impl<T> From<T> for Track<T> {
    fn from(value: T) -> Self {
        Track::Const(value)
    }
}

/// Keyframes: at least one, times in seconds, strictly increasing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Keys<T> {
    /// The keys, by time.
    pub keys: Vec<Key<T>>,
    /// How the values between two keys come about.
    pub way: Way<T>,
    /// What holds before the first and after the last key.
    pub outside: Outside,
}

/// One keyframe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Key<T> {
    /// Seconds from the start of the scene.
    pub time_s: f64,
    /// The value reached at that time.
    pub value: T,
    /// The way **to** this key from the one before it: how far the segment has come, of whatever curve it is.
    pub ease: Ease,
}

/// The curve through the keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Way<T> {
    /// Straight from key to key; rotations along the shorter arc, colours in linear light.
    #[default]
    Straight,
    /// A cubic through each two keys, as glTF's CUBICSPLINE: of each key the tangent in and the tangent out, in the value's
    /// unit a second. Rotations by components, then made unit.
    Cubic(Vec<[T; 2]>),
    /// Rotations alone: Shoemake's squad, which turns without a jerk at its keys. Everything else goes straight.
    Squad,
}

/// What a track does before its first and after its last key.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Outside {
    /// The first and the last value hold.
    #[default]
    Hold,
    /// The keys repeat, the last being the first of the next turn.
    Loop,
    /// The keys repeat, every other time backwards.
    PingPong,
    /// It goes on as fast as it comes in.
    Extend,
    /// There is no value.
    Error,
}

/// How a segment runs from its first key (0) to the key it arrives at (1).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Ease {
    /// At constant speed.
    #[default]
    Linear,
    /// The old value holds until the key is reached.
    Step,
    /// A CSS cubic Bézier.
    Bezier(Bezier),
    /// Penner's curves (easings.net).
    Penner(Family, Direction),
    /// CSS `steps(n, jump)`; n is 1 or more (2 or more for [`Jump::None`]).
    Steps(u32, Jump),
    /// A weight on a spring that is let go.
    Spring(Spring),
    /// A function of the part of the segment's time that has passed: the first output of a tape, its
    /// [`Instruction::Input`](crate::Instruction::Input).
    Function(Arc<Tape>),
}

/// A weight on a damped spring, at rest at 0 and drawn to 1; without units, as time is counted in segments.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spring {
    /// Of the undamped spring, radians a segment: √(stiffness / mass) · seconds; 0 or more.
    pub frequency: f64,
    /// Damping over that at which it does not swing: c / (2 √(stiffness · mass)); 0 or more.
    pub damping: f64,
}

/// A CSS timing curve from (0, 0) to (1, 1) with two handles; `x1` and `x2` lie in 0..=1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct Bezier {
    pub x1: f64,
    pub y1: f64,
    pub x2: f64,
    pub y2: f64,
}

impl Bezier {
    /// CSS `ease`, here called `smooth`.
    pub const SMOOTH: Bezier = Bezier { x1: 0.25, y1: 0.1, x2: 0.25, y2: 1.0 };
    /// CSS `ease-in`.
    pub const EASE_IN: Bezier = Bezier { x1: 0.42, y1: 0.0, x2: 1.0, y2: 1.0 };
    /// CSS `ease-out`.
    pub const EASE_OUT: Bezier = Bezier { x1: 0.0, y1: 0.0, x2: 0.58, y2: 1.0 };
    /// CSS `ease-in-out`.
    pub const EASE_IN_OUT: Bezier = Bezier { x1: 0.42, y1: 0.0, x2: 0.58, y2: 1.0 };
}

/// Penner's families of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Family {
    Sine,
    Quad,
    Cubic,
    Quart,
    Quint,
    Expo,
    Circ,
    Back,
    Bounce,
    Elastic,
}

/// Which end of a Penner curve is shaped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Direction {
    In,
    Out,
    InOut,
}

/// Where a CSS `steps` curve jumps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Jump {
    Start,
    End,
    Both,
    None,
}

/// A value made of components, so that a [`Tape`] can compute it.
pub trait Value: Sized {
    /// How many components there are.
    const COMPONENTS: usize;
    /// The value with these components; `parts` has [`Value::COMPONENTS`] of them.
    fn from_components(parts: &[f64]) -> Self;
    /// The components, as [`Value::from_components`] takes them.
    fn components(&self) -> Vec<f64>;
}

impl Value for f64 {
    const COMPONENTS: usize = 1;
    fn from_components(parts: &[f64]) -> Self {
        parts[0]
    }
    fn components(&self) -> Vec<f64> {
        vec![*self]
    }
}

/// 0 is false, everything else true.
impl Value for bool {
    const COMPONENTS: usize = 1;
    fn from_components(parts: &[f64]) -> Self {
        parts[0] != 0.0
    }
    fn components(&self) -> Vec<f64> {
        vec![f64::from(u8::from(*self))]
    }
}

impl Value for DVec3 {
    const COMPONENTS: usize = 3;
    fn from_components(parts: &[f64]) -> Self {
        DVec3::new(parts[0], parts[1], parts[2])
    }
    fn components(&self) -> Vec<f64> {
        self.to_array().to_vec()
    }
}

impl Value for Color {
    const COMPONENTS: usize = 3;
    fn from_components(parts: &[f64]) -> Self {
        DVec3::new(parts[0], parts[1], parts[2]).as_vec3()
    }
    fn components(&self) -> Vec<f64> {
        self.as_dvec3().to_array().to_vec()
    }
}

/// x, y, z, w, as they are: a tangent is no unit quaternion.
impl Value for DQuat {
    const COMPONENTS: usize = 4;
    fn from_components(parts: &[f64]) -> Self {
        DQuat::from_xyzw(parts[0], parts[1], parts[2], parts[3])
    }
    fn components(&self) -> Vec<f64> {
        self.to_array().to_vec()
    }
}
