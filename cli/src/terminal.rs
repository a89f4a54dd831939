//! What is printed: results on stdout, everything about them on stderr. Colours are put in always and taken out where
//! the stream does not want them.

use std::io::{ErrorKind, Write};

/// When to print in colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Color {
    /// Also into pipes and files
    Always,
    /// Nowhere
    Never,
    /// On a terminal, as NO_COLOR, CLICOLOR_FORCE, CLICOLOR and TERM say
    #[default]
    Auto,
}

impl Color {
    /// Decides for both streams. Without it `auto` holds.
    pub fn apply(self) {
        let choice = match self {
            Color::Always => anstream::ColorChoice::AlwaysAnsi,
            Color::Never => anstream::ColorChoice::Never,
            Color::Auto => anstream::ColorChoice::Auto,
        };
        choice.write_global();
    }
}

/// Writes to stdout. A reader that has seen enough is no error.
///
/// # Errors
/// What stdout leads to does not take it, such as a full disk.
pub fn out(text: &str) -> Result<(), String> {
    let mut stdout = anstream::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(format!("cannot write to standard output: {error}")),
        _ => Ok(()),
    }
}

/// Writes to stderr, as far as it is open.
pub fn err(text: &str) {
    let mut stderr = anstream::stderr().lock();
    // There is nowhere to say that this failed.
    let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
}

/// A text for a file: without colours.
pub fn plain(text: &str) -> String {
    anstream::adapter::strip_str(text).to_string()
}

/// `error: …` on stderr.
pub fn error(message: &str) {
    err(&format!("\x1b[1;31merror\x1b[0m\x1b[1m: {message}\x1b[0m\n"));
}

/// Whether a person is likely to watch stderr: it is a terminal, and no build server's.
#[cfg(any(feature = "render", feature = "physics"))]
pub fn watched() -> bool {
    use std::io::IsTerminal;
    std::io::stderr().is_terminal() && std::env::var_os("CI").is_none_or(|ci| ci.is_empty() || ci == "false")
}

/// JSON for people and programs, with a line break at its end.
pub fn json(value: &impl serde::Serialize) -> String {
    // Strings and numbers always serialise.
    serde_json::to_string_pretty(value).unwrap_or_default() + "\n"
}
