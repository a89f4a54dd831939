//! Characters that look like the language's own but are not: from word processors, web pages and other keyboards.

/// What `character` is taken for: the text to write, and what it is not.
pub(super) fn confusable(character: char) -> Option<(&'static str, &'static str)> {
    Some(match character {
        '“' | '”' | '„' | '‟' | '«' | '»' | '″' | '＂' | '‘' | '’' | '‚' | '′' | '\'' | '`' => {
            ("\"", "a quote")
        }
        '×' | '·' | '⋅' | '∗' | '∙' | '＊' => ("*", "an operator"),
        '÷' | '∕' | '⁄' | '／' => ("/", "an operator"),
        '＋' => ("+", "an operator"),
        '−' | '–' | '—' | '‐' | '‑' | '‒' | '－' => ("-", "a minus sign"),
        '≤' => ("<=", "an operator"),
        '≥' => (">=", "an operator"),
        '≠' => ("!=", "an operator"),
        '…' => ("..", "an operator"),
        '°' | 'º' => ("deg", "a unit"),
        '：' => (":", "a colon"),
        '，' | '、' => (",", "a comma"),
        '；' => (";", "a semicolon"),
        '＝' => ("=", "an equals sign"),
        '（' => ("(", "a bracket"),
        '）' => (")", "a bracket"),
        '［' | '【' => ("[", "a bracket"),
        '］' | '】' => ("]", "a bracket"),
        '｛' => ("{", "a bracket"),
        '｝' => ("}", "a bracket"),
        '\u{A0}' | '\u{2000}'..='\u{200B}' | '\u{202F}' | '\u{205F}' | '\u{2060}' | '\u{3000}' | '\u{FEFF}' => {
            (" ", "a space")
        }
        _ => return None,
    })
}
