//! Codes of allowances.

use super::Row;

pub(super) const ROWS: &[Row] = &[
    Row {
        code: "W0902",
        title: "an allowance that is none",
        text: "A warning is allowed by `// allow(W0401): why` on a line of its own above the line that gets it. The \
            code must be a warning's: what is an error cannot be allowed.",
        bad: scene!(
            r#"// allow(W9999): no such code
sphere ball { radius: 1 }"#
        ),
        good: scene!("sphere ball { radius: 1 }"),
    },
    Row {
        code: "W0903",
        title: "an allowance of what does not occur",
        text: "The next line does not get the warning that the comment allows: it was put right meanwhile, or the \
            comment stands above another line.",
        bad: scene!(
            r#"// allow(W0201): used later
let size = 1
sphere ball { radius: size }"#
        ),
        good: scene!(
            r#"let size = 1
sphere ball { radius: size }"#
        ),
    },
];
