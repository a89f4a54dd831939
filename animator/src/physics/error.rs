//! Why a scene has no bake.

use std::fmt;

use super::plan::MOST_POSES;
use crate::SampleError;

/// Why a scene has no bake.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeError {
    /// Something has no place at a time.
    Sample(SampleError),
    /// A body has nothing to collide with.
    Shapeless {
        /// Its node's name.
        name: String,
        /// Why, in one clause.
        why: &'static str,
    },
    /// A body left the world.
    BlewUp {
        /// Its node's name.
        name: String,
        /// When.
        time_s: f64,
    },
    /// There would be more poses than a bake may hold.
    TooLarge {
        /// How many.
        poses: u64,
    },
    /// What is kept is not the bake of the scene, and none may be made.
    Stale {
        /// Why it is not, in one clause.
        why: String,
    },
    /// It was stopped.
    Stopped,
}

impl fmt::Display for BakeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BakeError::Sample(error) => error.fmt(f),
            BakeError::Shapeless { name, why } => write!(f, "the body `{name}` has no shape to collide with: {why}"),
            BakeError::BlewUp { name, time_s } => {
                write!(f, "body `{name}` left the world at {}s", (time_s * 1e3).round() / 1e3)
            }
            BakeError::TooLarge { poses } => {
                let gib = |poses: u64| poses as f64 * size_of::<kinora_scene::Pose>() as f64 / f64::from(1 << 30);
                write!(f, "the bake would take {:.1} GiB, limit {} GiB", gib(*poses), gib(MOST_POSES).round())
            }
            BakeError::Stale { why } => write!(f, "bake does not match the scene: {why}"),
            BakeError::Stopped => write!(f, "stopped"),
        }
    }
}

impl std::error::Error for BakeError {}
