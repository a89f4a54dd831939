//! Fixes applied: which of them go together, and what a text becomes.

use super::{Applicability, Diagnostic, Edit};
use crate::source::{FileId, Span};

/// The edits of one fix a diagnostic, of those that may be trusted as far as `least` says. A fix that meets one chosen
/// before is left out whole: after the others the text is looked at again.
///
/// ```
/// use kinora_lang::diagnostic::{Applicability, Diagnostic, apply, choose};
/// use kinora_lang::source::{FileId, Span};
///
/// let file = FileId(0);
/// let found = Diagnostic::new("E0115", "extra comma").primary(file, Span::new(3, 4), "");
/// let found = found.fix(Applicability::Safe, "remove it", file, Span::new(3, 4), "");
/// let edits = choose(&[found], Applicability::Safe);
/// assert_eq!(apply("(0,, 1)", file, &edits), "(0, 1)");
/// ```
pub fn choose(diagnostics: &[Diagnostic], least: Applicability) -> Vec<Edit> {
    let mut chosen: Vec<Edit> = Vec::new();
    for found in diagnostics {
        if let Some(fix) = found.fixes.iter().find(|fix| fix.applicability <= least)
            && !fix.edits.iter().any(|edit| chosen.iter().any(|other| meet(edit, other)))
        {
            chosen.extend_from_slice(&fix.edits);
        }
    }
    chosen
}

/// The text of a file after its edits, which do not meet. Places outside the text are moved into it.
pub fn apply(text: &str, file: FileId, edits: &[Edit]) -> String {
    let mut own: Vec<&Edit> = edits.iter().filter(|edit| edit.file == file).collect();
    own.sort_by_key(|edit| edit.span);
    let (mut fixed, mut at) = (String::with_capacity(text.len()), 0);
    for Edit { span, insert, .. } in own {
        let border = |offset: u32| text.floor_char_boundary(offset as usize);
        let start = border(span.start).max(at);
        fixed += text.get(at..start).unwrap_or_default();
        fixed += insert;
        at = border(span.end).max(start);
    }
    fixed + text.get(at..).unwrap_or_default()
}

/// Whether the order of two edits would matter.
fn meet(a: &Edit, b: &Edit) -> bool {
    let Span { start, end } = a.span;
    a.file == b.file && (start == b.span.start || start < b.span.end && b.span.start < end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(applicability: Applicability, edits: &[(u32, u32, &str)]) -> Diagnostic {
        let edits = edits.iter().map(|(start, end, insert)| Edit {
            file: FileId(0),
            span: Span::new(*start, *end),
            insert: insert.to_string(),
        });
        Diagnostic::new("E0201", "m").fix_edits(applicability, "f", edits.collect())
    }

    fn check(found: &[Diagnostic], least: Applicability, expected: &str) {
        assert_eq!(apply("abcdef", FileId(0), &choose(found, least)), expected);
    }

    #[test]
    fn fixes_that_meet_wait() {
        use Applicability::{Manual, Maybe, Safe};
        let (first, second) = (with(Safe, &[(1, 3, "X")]), with(Safe, &[(0, 1, "Y"), (2, 4, "Z")]));
        check(&[first.clone(), second.clone()], Safe, "aXdef");
        check(&[second, first.clone()], Safe, "YbZef");
        check(&[first.clone(), with(Safe, &[(3, 3, "Y")])], Safe, "aXYdef");
        check(&[with(Safe, &[(3, 3, "X")]), with(Safe, &[(3, 3, "Y")])], Safe, "abcXdef");
        check(&[with(Maybe, &[(0, 1, "X")]), with(Manual, &[(1, 2, "Y")])], Safe, "abcdef");
        check(&[with(Maybe, &[(0, 1, "X")]), with(Manual, &[(1, 2, "Y")])], Maybe, "Xbcdef");
        check(&[with(Safe, &[(9, 12, "X")])], Safe, "abcdefX");
        check(&[first, with(Safe, &[(5, 6, "")])], Safe, "aXde");
    }
}
