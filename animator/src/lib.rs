//! Gives a [`Scene`] its time: a scene and an instant make a [`World`], where nothing moves any more.
//!
//! [`sample`] is the stage ([`sample_moving`] knows of the next frame too); [`value`] is one track and [`ease`] one timing curve, for whoever needs a part of it.
//! Everything here is a pure function of its arguments and keeps no state, so frames may be asked for in any order: frame
//! 37 alone equals frame 37 in a range.
//!
//! Numbers are f64 and `sin`, `cos`, `exp` and their like are the standard library's, which may round their last bit
//! differently on another platform. Results repeat bit for bit on one platform; across platforms they agree to rounding.
//!
//! ```
//! use kinora_animator::value;
//! use kinora_scene::{Ease, Key, Keys, Outside, Track, Way};
//!
//! let key = |time_s, value| Key { time_s, value, ease: Ease::Linear };
//! let keys = vec![key(0.0, 1.0), key(2.0, 5.0)];
//! let height = Track::Keys(Keys { keys, way: Way::Straight, outside: Outside::Hold });
//! assert_eq!(value(&height, 0.5, 24.0), 2.0);
//! ```
//!
//! [`Scene`]: kinora_scene::Scene
//! [`World`]: kinora_scene::World

mod aim;
mod baked;
mod camera;
mod ease;
mod error;
mod form;
mod light;
mod material;
mod moments;
#[cfg(feature = "physics")]
pub mod physics;
mod pose;
mod read;
mod sample;
mod tape;
mod track;

pub use ease::ease;
pub use error::{Fault, Place, SampleError};
pub use sample::{sample, sample_moving};
pub use track::{Blend, value};
