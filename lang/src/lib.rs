//! The Kinora scene language: text to [`Scene`](kinora_scene), with diagnostics.

// The parser's derive names it, as `std` may be absent.
extern crate alloc;

pub mod assets;
pub mod builtin;
pub mod claims;
pub mod diagnostic;
pub mod dimension;
pub mod eval;
pub mod files;
pub mod format;
pub mod ide;
pub mod library;
pub mod lower;
pub mod modules;
pub mod schema;
pub mod source;
pub mod suggest;
pub mod syntax;
pub mod value;

pub use eval::{Evaluated, Overrides, Param, Plain, eval, eval_project};
pub use syntax::{Tree, parse};
