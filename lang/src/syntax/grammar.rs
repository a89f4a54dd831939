//! pest's parser, generated from `grammar.pest`. Only [`super::parse`] may know it.

// The derive writes a public enum without documentation.
#![allow(missing_docs)]

#[derive(pest_derive::Parser)]
#[grammar = "grammar.pest"]
pub(super) struct Grammar;
