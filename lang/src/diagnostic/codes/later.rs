//! What comes later.

use super::Row;

pub(super) const ROWS: &[Row] = &[Row {
    code: "E1101",
    title: "not yet",
    text: "What is written is part of the language, but this version of the program does not know it yet.",
    bad: scene!("fluid water { }\nsphere ball { }"),
    good: scene!("sphere ball { }"),
}];
