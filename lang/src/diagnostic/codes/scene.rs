//! Codes of the evaluator: names, types, values, scene, time, files, assets, limits.

use super::Row;

pub(super) const ROWS: &[Row] = &[];
