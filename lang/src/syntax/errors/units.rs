//! Units that the grammar knows, for suggestions. A test compares the list with the grammar.

/// `unit_word` of the grammar, and `%`.
pub(super) const UNITS: &[&str] = &[
    "mm", "ms", "min", "m", "cm", "cd", "km", "kg", "deg", "sr", "s", "rad", "turn", "ft", "f", "in", "Hz", "K", "W",
    "N", "J", "g", "lm", "lx", "%",
];

/// Names in full, as far as their beginning tells them apart.
const IN_FULL: &[(&str, &str)] = &[
    ("millim", "mm"),
    ("centim", "cm"),
    ("kilom", "km"),
    ("millis", "ms"),
    ("msec", "ms"),
    ("met", "m"),
    ("sec", "s"),
    ("minu", "min"),
    ("deg", "deg"),
    ("rad", "rad"),
    ("turn", "turn"),
    ("rev", "turn"),
    ("feet", "ft"),
    ("foot", "ft"),
    ("inch", "in"),
    ("frame", "f"),
    ("her", "Hz"),
    ("kel", "K"),
    ("wat", "W"),
    ("new", "N"),
    ("jou", "J"),
    ("kilog", "kg"),
    ("gram", "g"),
    ("lum", "lm"),
    ("lux", "lx"),
    ("candela", "cd"),
    ("ster", "sr"),
    ("per", "%"),
    ("pct", "%"),
];

/// The unit that is most likely meant.
pub(super) fn suggest(written: &str) -> Option<&'static str> {
    let lower = written.to_lowercase();
    let same = UNITS.iter().find(|unit| unit.to_lowercase() == lower);
    let in_full = || IN_FULL.iter().find(|(start, _)| lower.starts_with(start)).map(|(_, unit)| *unit);
    same.copied().or_else(in_full)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grammar_has_the_same_units() {
        let grammar = include_str!("../../grammar.pest");
        let rule = grammar.split("unit_word = _{").nth(1).and_then(|rest| rest.split('}').next()).unwrap();
        let words: Vec<&str> = rule.split('"').skip(1).step_by(2).collect();
        assert_eq!(words, UNITS[..UNITS.len() - 1]);
    }

    #[test]
    fn suggestions() {
        let check = |written: &str, unit: Option<&str>| assert_eq!(suggest(written), unit, "{written}");
        check("degrees", Some("deg"));
        check("meters", Some("m"));
        check("hz", Some("Hz"));
        check("millimetres", Some("mm"));
        check("px", None);
    }
}
