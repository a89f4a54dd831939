//! The Kinora scene language: text to [`Scene`](kinora_scene), with diagnostics.

pub mod diagnostic;
pub mod files;
pub mod source;
pub mod syntax;

pub use syntax::{Tree, parse};
