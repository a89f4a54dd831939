//! A place of the text in the user's editor.

use std::path::Path;
use std::process::{Command, Stdio};

/// What is run where nothing else is said.
const DEFAULT: &str = "code -g {file}:{line}:{column}";

/// The command that opens `file` at a line and a column, from 1: as `configured`, with `{file}`, `{line}` and `{column}` in
/// it; else `visual`, the value of `$VISUAL`; else VS Code. None where the command is empty or a quote is not closed.
pub fn command(
    configured: Option<&str>,
    visual: Option<&str>,
    file: &Path,
    [line, column]: [u32; 2],
) -> Option<Vec<String>> {
    let said = |text: Option<&str>| text.map(str::trim).filter(|text| !text.is_empty()).map(str::to_owned);
    let file = file.to_string_lossy();
    let template = said(configured).or_else(|| said(visual)).unwrap_or_else(|| DEFAULT.into());
    let mut words = words(&template)?;
    let knows_places = words.iter().any(|word| word.contains("{file}"));
    if !knows_places {
        words.extend(arguments(words.first()?).iter().map(|word| (*word).to_owned()));
    }
    let fill = |word: &String| {
        // Each once, so that a brace in the file's name means nothing.
        let mut out = String::new();
        let mut rest = word.as_str();
        while let Some(at) = rest.find('{') {
            out += &rest[..at];
            rest = &rest[at..];
            let known = [("{file}", &*file), ("{line}", &line.to_string()), ("{column}", &column.to_string())]
                .into_iter()
                .find_map(|(name, value)| Some((rest.strip_prefix(name)?, value.to_owned())));
            match known {
                Some((after, value)) => (out, rest) = (out + &value, after),
                None => (out, rest) = (out + "{", &rest[1..]),
            }
        }
        out + rest
    };
    Some(words.iter().map(fill).collect())
}

/// How the editors that people have take a place.
fn arguments(program: &str) -> &'static [&'static str] {
    let name = Path::new(program).file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    match &*name {
        "code" | "code-insiders" | "codium" | "vscodium" | "cursor" => &["-g", "{file}:{line}:{column}"],
        "subl" | "sublime_text" | "zed" | "zeditor" | "hx" | "helix" => &["{file}:{line}:{column}"],
        "vi" | "vim" | "nvim" | "gvim" | "nvim-qt" | "kak" => &["+{line}", "{file}"],
        "emacs" | "emacsclient" | "nano" | "micro" => &["+{line},{column}", "{file}"],
        "gedit" | "gnome-text-editor" => &["+{line}:{column}", "{file}"],
        "kate" | "kwrite" => &["-l", "{line}", "-c", "{column}", "{file}"],
        "idea" | "rustrover" | "clion" | "pycharm" => &["--line", "{line}", "--column", "{column}", "{file}"],
        "notepad++" => &["-n{line}", "-c{column}", "{file}"],
        _ => &["{file}"],
    }
}

/// The words of a command line, as a shell splits them; quotes keep spaces.
fn words(text: &str) -> Option<Vec<String>> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in text.chars() {
        match quote {
            Some(end) if c == end => quote = None,
            Some(_) => word.get_or_insert_default().push(c),
            None if c == '"' || c == '\'' => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            None if c.is_whitespace() => words.extend(word.take()),
            None => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    (quote.is_none() && !words.is_empty()).then_some(words)
}

/// Opens it, and does not wait for it.
///
/// # Errors
/// There is no such program, in words.
pub fn open(command: &[String]) -> Result<(), String> {
    let (program, arguments) = command.split_first().ok_or("there is no command for the editor")?;
    let spawned = Command::new(program).args(arguments).stdout(Stdio::null()).spawn();
    let mut child = spawned.map_err(|error| format!("cannot start `{program}`: {error}"))?;
    std::thread::spawn(move || {
        // An editor that has ended must not stay as a zombie.
        let _ = child.wait();
    });
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands() {
        for (configured, visual, expected) in [
            (None, None, "code|-g|/a b/{line}.kin:12:3"),
            (None, Some("  "), "code|-g|/a b/{line}.kin:12:3"),
            (None, Some("vim"), "vim|+12|/a b/{line}.kin"),
            (None, Some("/usr/bin/emacsclient -n"), "/usr/bin/emacsclient|-n|+12,3|/a b/{line}.kin"),
            (None, Some("subl -w"), "subl|-w|/a b/{line}.kin:12:3"),
            (None, Some("my-editor"), "my-editor|/a b/{line}.kin"),
            (Some("ed --at={line}:{column} '{file}'"), Some("vim"), "ed|--at=12:3|/a b/{line}.kin"),
            (Some("'my ed' {file} {x}"), None, "my ed|/a b/{line}.kin|{x}"),
            (Some("kate"), None, "kate|-l|12|-c|3|/a b/{line}.kin"),
        ] {
            let got = command(configured, visual, Path::new("/a b/{line}.kin"), [12, 3]).unwrap();
            assert_eq!(got.join("|"), expected);
        }
        assert_eq!(command(Some("'open"), None, Path::new("a"), [1, 1]), None);
    }
}
