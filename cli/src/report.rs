//! Findings as text: with the lines they are about, or one line each.

use kinora_lang::diagnostic::{Diagnostic, Listing, Style, render, render_short};
use kinora_lang::source::Source;

/// Columns where nobody says how many there are.
const WIDTH: u16 = 100;

/// Findings with the lines they are about, in colour, and how many more there are.
pub fn full(listing: &Listing, sources: &[Source]) -> String {
    let width = terminal_size::terminal_size_of(std::io::stderr()).map_or(WIDTH, |(width, _)| width.0);
    let style = Style { color: true, width, ..Style::default() };
    let texts: Vec<String> = listing.shown.iter().map(|found| render(found, sources, style) + "\n").collect();
    texts.concat() + &more(listing)
}

/// One finding a line, as editors read it, and how many more there are.
pub fn short(listing: &Listing, sources: &[Source]) -> String {
    let lines: Vec<String> = listing.shown.iter().map(|found| render_short(found, sources) + "\n").collect();
    lines.concat() + &more(listing)
}

/// One finding without colours.
#[cfg(feature = "viewer")]
pub fn plain(found: &Diagnostic, sources: &[Source]) -> String {
    render(found, sources, Style::default())
}

/// A fault of the program itself.
pub fn internal(what: &str) -> String {
    let found = Diagnostic::new("E1007", "this is a bug in the tool")
        .note(what)
        .help("report it with the scene, the command and what `kinora info` prints");
    render(&found, &[], Style { color: true, ..Style::default() })
}

fn more(listing: &Listing) -> String {
    match listing.hidden {
        0 => String::new(),
        hidden => format!("and {hidden} more\n"),
    }
}

/// "2 errors, 1 warning".
pub fn counts(errors: usize, warnings: usize) -> String {
    let count = |number: usize, what: &str| format!("{number} {what}{}", if number == 1 { "" } else { "s" });
    match (errors, warnings) {
        (0, 0) => "no mistakes".into(),
        (errors, 0) => count(errors, "error"),
        (0, warnings) => count(warnings, "warning"),
        (errors, warnings) => format!("{}, {}", count(errors, "error"), count(warnings, "warning")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_of_the_program_is_no_raw_panic() {
        let text = internal("index out of bounds, at main.rs:7");
        for piece in ["E1007", "this is a bug in the tool", "index out of bounds, at main.rs:7", "`kinora info`"] {
            assert!(text.contains(piece), "{text}");
        }
    }

    #[test]
    fn numbers_of_findings() {
        for (errors, warnings, expected) in
            [(0, 0, "no mistakes"), (1, 0, "1 error"), (0, 2, "2 warnings"), (3, 1, "3 errors, 1 warning")]
        {
            assert_eq!(counts(errors, warnings), expected);
        }
    }
}
