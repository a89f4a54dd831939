//! Which diagnostics are shown, and in which order.

use super::Diagnostic;

/// How many diagnostics are shown unless the user says otherwise.
pub const MAX_SHOWN: usize = 50;

/// So many errors and so many warnings are kept of each pass over a scene: nobody reads more.
pub const MOST: usize = 20_000;

/// Counts what is kept of a pass, errors and warnings apart.
#[derive(Debug, Clone, Copy, Default)]
pub struct Kept([usize; 2]);

impl Kept {
    /// Whether there is room for one more like this; counts it.
    pub fn takes(&mut self, found: &Diagnostic) -> bool {
        let count = &mut self.0[usize::from(found.is_error())];
        *count += 1;
        *count <= MOST
    }
}

/// Diagnostics ready to be shown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listing {
    /// By file, then by place; each once.
    pub shown: Vec<Diagnostic>,
    /// How many more there are.
    pub hidden: usize,
    /// Errors, shown or not.
    pub errors: usize,
    /// Warnings, shown or not.
    pub warnings: usize,
}

/// Sorts diagnostics by file and place, those without one first, and drops repetitions.
pub fn sort(diagnostics: &mut Vec<Diagnostic>) {
    let place = |found: &Diagnostic| found.place().map(|(file, span)| (file, span.start, span.end));
    diagnostics.sort_by(|a, b| (place(a), a.code, &a.message).cmp(&(place(b), b.code, &b.message)));
    diagnostics.dedup_by(|a, b| a.code == b.code && a.message == b.message && a.place() == b.place());
}

/// [`sort`]s diagnostics and keeps the first `max`.
pub fn list(mut diagnostics: Vec<Diagnostic>, max: usize) -> Listing {
    sort(&mut diagnostics);
    let errors = diagnostics.iter().filter(|found| found.is_error()).count();
    let warnings = diagnostics.len() - errors;
    let hidden = diagnostics.len().saturating_sub(max);
    diagnostics.truncate(max);
    Listing { shown: diagnostics, hidden, errors, warnings }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{FileId, Span};

    #[test]
    fn sorted_once_each_and_counted() {
        let at = |code, file, start| Diagnostic::new(code, "m").primary(FileId(file), Span::at(start), "");
        let many = vec![
            at("E0201", 1, 0),
            at("W0201", 0, 9),
            at("E0202", 0, 3),
            at("E0202", 0, 3),
            Diagnostic::new("E0413", "m"),
        ];
        let listing = list(many, 3);
        let codes: Vec<&str> = listing.shown.iter().map(|found| found.code).collect();
        assert_eq!(codes, ["E0413", "E0202", "W0201"]);
        assert_eq!((listing.hidden, listing.errors, listing.warnings), (1, 3, 1));
    }
}
