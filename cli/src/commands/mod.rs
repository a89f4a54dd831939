//! The commands, one file each.

#[cfg(feature = "render")]
pub mod animate;
#[cfg(feature = "physics")]
pub mod bake;
pub mod check;
pub mod explain;
pub mod fmt;
pub mod info;
pub mod inspect;
pub mod params;
#[cfg(feature = "render")]
pub mod render;
