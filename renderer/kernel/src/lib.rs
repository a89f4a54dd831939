//! All light transport of Kinora. The source of truth is WGSL in `shaders/`; [`WGSL`] is that text for a GPU and
//! [`generated`] the same text as Rust, made by `kinora-translate` when this crate is built; [`lanes`] is the same once
//! more for many paths at once, where the CPU has the registers. Only the two ray queries are written twice: [`query`]
//! walks a tree of its own in lanes.
//!
//! This crate does no IO, knows no GPU API and nothing of scenes; it is where a picture's physics is tested.

pub mod albedo;
pub mod lanes;
pub mod packed;
pub mod query;
mod validate;

/// The shaders as one text, `entry/` included.
pub const WGSL: &str = include_str!(concat!(env!("OUT_DIR"), "/kernel.wgsl"));

/// The shaders as Rust: structures, constants, and the functions as methods of [`generated::Kernel`].
#[allow(
    missing_docs,
    clippy::all,
    clippy::pedantic,
    non_snake_case,
    non_upper_case_globals,
    unused_imports,
    unused_parens,
    unused_mut,
    unused_variables,
    unused_assignments,
    unreachable_code,
    dead_code
)]
pub mod generated {
    include!(concat!(env!("OUT_DIR"), "/kernel.rs"));
}

pub use generated::{Kernel, Light, Material, Params, Primitive, Shape};
pub use packed::{PASS_SAMPLES, Packed};
pub use validate::Invalid;
