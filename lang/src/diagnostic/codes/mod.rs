//! Every code there is, with what `kinora explain` says about it.
//!
//! A code keeps its meaning for ever and is never used again. The first two digits are the group: 01 syntax, 02 names,
//! 03 types and units, 04 values, 05 scene, 06 time, 07 files, 08 assets, 09 physics, 10 limits, 11 not yet.

mod scene;
mod syntax;

/// One code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// `E0201`, `W0306`: the letter is the severity.
    pub code: &'static str,
    /// What is wrong, in one lower-case clause.
    pub title: &'static str,
    /// Why it is wrong and what to do: sentences.
    pub text: &'static str,
    /// A scene, or a piece of one, that gets the code. Empty where it takes more than a text, such as a missing file.
    pub bad: &'static str,
    /// The same, put right.
    pub good: &'static str,
}

/// All codes, sorted.
pub fn all() -> Vec<Row> {
    let mut rows: Vec<Row> = syntax::ROWS.iter().chain(scene::ROWS).copied().collect();
    rows.sort_by_key(|row| (row.code.get(1..), row.code));
    rows
}

/// What is known about a code; upper and lower case are the same.
///
/// ```
/// use kinora_lang::diagnostic::codes;
/// assert_eq!(codes::find("e0115").map(|row| row.title), Some("extra comma"));
/// assert_eq!(codes::find("E9999"), None);
/// ```
pub fn find(code: &str) -> Option<Row> {
    all().into_iter().find(|row| row.code.eq_ignore_ascii_case(code))
}

/// The text that `kinora explain` shows.
pub fn explain(row: &Row) -> String {
    let mut text = format!("{}: {}\n\n{}\n", row.code, row.title, row.text);
    let indented = |scene: &str| scene.lines().map(|line| format!("    {line}\n")).collect::<String>();
    if !row.bad.is_empty() {
        text += &format!("\nGets this code:\n\n{}", indented(row.bad));
    }
    if !row.good.is_empty() {
        text += &format!("\nBetter:\n\n{}", indented(row.good));
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
            assert!(pair[0].code != pair[1].code, "{} is there twice", pair[0].code);
        }
        for row in rows {
            let (letter, digits) = row.code.split_at(1);
            assert!(matches!(letter, "E" | "W") && digits.len() == 4, "{}", row.code);
            assert!(digits.bytes().all(|byte| byte.is_ascii_digit()), "{}", row.code);
            assert!(!row.title.is_empty() && row.text.ends_with('.'), "{}", row.code);
        }
    }
}
