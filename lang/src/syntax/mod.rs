//! Text to tree, and tree to the shapes that the evaluator reads.
//!
//! [`parse`] never fails: whatever the text, there is a [`Tree`] whose leaves joined are the text, and the mistakes in it
//! are a list beside it.

pub mod ast;
mod errors;
mod expr;
mod grammar;
mod kind;
mod lower;
mod parse;
mod part;
mod scan;
mod shift;
mod text;
mod tree;

pub(crate) use expr::level_of;
pub use kind::SyntaxKind;
pub use part::Part;
pub use scan::MAX_NESTING;
pub(crate) use scan::{block_end, line_comments, words};
pub use tree::{Tree, parse, parse_value};
