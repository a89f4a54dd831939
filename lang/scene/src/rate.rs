//! The rate of a value: what may still move, and what stands still.

use std::fmt::Debug;

use serde::{Serialize, de::DeserializeOwned};

use crate::Track;

/// What a value of type `T` looks like at a rate: a [`Track`] in a [`crate::Scene`], a plain `T` in a [`crate::World`].
pub trait Rate: Copy + Clone + Debug + Default + PartialEq + 'static {
    /// A value of type `T` at this rate.
    type Of<T: Datum>: Datum;
}

/// What every plain value of a scene can do.
pub trait Datum: Clone + Debug + PartialEq + Serialize + DeserializeOwned {}
impl<T: Clone + Debug + PartialEq + Serialize + DeserializeOwned> Datum for T {}

/// Values that may change over time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Animated;

impl Rate for Animated {
    type Of<T: Datum> = Track<T>;
}

/// Values at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Still;

impl Rate for Still {
    type Of<T: Datum> = T;
}
