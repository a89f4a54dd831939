//! Every code there is, with what `kinora explain` says about it.
//!
//! A code keeps its meaning for ever and is never used again. The first two digits are the group: 01 syntax, 02 names,
//! 03 types and units, 04 values, 05 scene, 06 time, 07 files, 08 assets, 09 physics and allowances, 10 limits, 11 not yet.

/// A piece of a scene behind what it needs to be one.
macro_rules! scene {
    ($text:expr) => {
        concat!("lang 1\ncamera main { position: (0, 0, 4) }\nsky { color: #fff }\n", $text)
    };
}

mod assets;
mod files;
mod later;
mod limits;
mod lints;
mod names;
mod structure;
mod syntax;
mod time;
mod types;
mod values;

/// One code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// `E0201`, `W0306`: the letter is the severity.
    pub code: &'static str,
    /// What is wrong, in one lower-case clause.
    pub title: &'static str,
    /// Why it is wrong and what to do: sentences.
    pub text: &'static str,
    /// A scene that gets the code. Empty where it takes more than texts, such as a link or a file too large. Other files
    /// of the scene follow under lines `// --- lib/paint.kin`, and `// -D name=value` stands for that flag.
    pub bad: &'static str,
    /// The same, put right.
    pub good: &'static str,
}

const GROUPS: [&[Row]; 11] = [
    syntax::ROWS,
    names::ROWS,
    types::ROWS,
    values::ROWS,
    structure::ROWS,
    time::ROWS,
    files::ROWS,
    assets::ROWS,
    lints::ROWS,
    limits::ROWS,
    later::ROWS,
];

/// All codes, sorted.
pub fn all() -> Vec<Row> {
    GROUPS.concat()
}

/// The page about a code.
pub fn url(code: &str) -> String {
    format!("https://github.com/kinora/kinora/blob/main/docs/diagnostics/{code}.md")
}

/// The codes that a word that is none was perhaps meant to be: those that differ in one place or begin like it, at most
/// three.
pub fn near(word: &str) -> Vec<&'static str> {
    let upper = word.trim().to_ascii_uppercase();
    let near = |code: &&str| {
        let same = code.chars().zip(upper.chars()).filter(|(a, b)| a == b).count();
        let begins = upper.len() > 2 && code.starts_with(&upper);
        begins || same + 1 == code.len().max(upper.chars().count()) || code.get(1..) == Some(&*upper)
    };
    all().iter().map(|row| row.code).filter(near).take(3).collect()
}

/// What is known about a code; upper and lower case are the same.
///
/// ```
/// use kinora_lang::diagnostic::codes;
/// assert_eq!(codes::find("e0115").map(|row| row.title), Some("extra comma"));
/// assert_eq!(codes::find("E9999"), None);
/// ```
pub fn find(code: &str) -> Option<Row> {
    GROUPS.into_iter().flatten().find(|row| row.code.eq_ignore_ascii_case(code)).copied()
}

/// The page that `kinora explain` shows, in Markdown.
pub fn page(row: &Row) -> String {
    let mut text = format!("# {}: {}\n\n{}\n", row.code, row.title, row.text);
    for (title, scene) in [("Gets this code", row.bad), ("Better", row.good)] {
        if !scene.is_empty() {
            text += &format!("\n{title}:\n\n```text\n{}\n```\n", scene.trim_end());
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_complete_and_no_code_is_used_twice() {
        let rows = all();
        for pair in rows.windows(2) {
            let key = |row: &Row| (row.code[1..].to_string(), row.code);
            assert!(key(&pair[0]) < key(&pair[1]), "{} stands before {}", pair[0].code, pair[1].code);
        }
        for row in rows {
            let (letter, digits) = row.code.split_at(1);
            assert!(matches!(letter, "E" | "W") && digits.len() == 4, "{}", row.code);
            assert!(digits.bytes().all(|byte| byte.is_ascii_digit()), "{}", row.code);
            assert!(!row.title.is_empty() && row.text.ends_with('.'), "{}", row.code);
        }
    }
}
