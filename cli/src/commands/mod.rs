//! The commands, one file each.

#[cfg(feature = "render")]
pub mod animate;
#[cfg(feature = "physics")]
pub mod bake;
pub mod check;
pub mod completions;
#[cfg(feature = "render")]
pub mod diff;
pub mod explain;
pub mod fmt;
pub mod info;
pub mod inspect;
pub mod man;
pub mod migrate;
pub mod new;
pub mod params;
#[cfg(feature = "render")]
pub mod render;
pub mod rewrite;
#[cfg(feature = "render")]
pub mod test;
