//! The names of easing curves.

use kinora_scene::{Bezier, Direction, Ease, Family, Jump};

use crate::suggest::suggest;

/// Names of the CSS curves.
const CSS: &[(&str, Ease)] = &[
    ("linear", Ease::Linear),
    ("step", Ease::Step),
    ("hold", Ease::Step),
    ("smooth", Ease::Bezier(Bezier::SMOOTH)),
    ("ease_in", Ease::Bezier(Bezier::EASE_IN)),
    ("ease_out", Ease::Bezier(Bezier::EASE_OUT)),
    ("ease_in_out", Ease::Bezier(Bezier::EASE_IN_OUT)),
];

const FAMILIES: &[(&str, Family)] = &[
    ("sine", Family::Sine),
    ("quad", Family::Quad),
    ("cubic", Family::Cubic),
    ("quart", Family::Quart),
    ("quint", Family::Quint),
    ("expo", Family::Expo),
    ("circ", Family::Circ),
    ("back", Family::Back),
    ("bounce", Family::Bounce),
    ("elastic", Family::Elastic),
];

const DIRECTIONS: &[(&str, Direction)] =
    &[("in_out_", Direction::InOut), ("in_", Direction::In), ("out_", Direction::Out)];

/// Where `steps` jumps.
pub const JUMPS: &[(&str, Jump)] =
    &[("jump_start", Jump::Start), ("jump_end", Jump::End), ("jump_both", Jump::Both), ("jump_none", Jump::None)];

/// The curve of that name.
///
/// ```
/// use kinora_lang::builtin::ease;
/// use kinora_scene::{Direction, Ease, Family};
/// assert_eq!(ease::named("in_out_cubic"), Some(Ease::Penner(Family::Cubic, Direction::InOut)));
/// assert_eq!(ease::named("inout_cubic"), None);
/// ```
pub fn named(name: &str) -> Option<Ease> {
    if let Some((_, ease)) = CSS.iter().find(|row| row.0 == name) {
        return Some(ease.clone());
    }
    let (direction, rest) =
        DIRECTIONS.iter().find_map(|(prefix, direction)| Some((*direction, name.strip_prefix(prefix)?)))?;
    let family = FAMILIES.iter().find(|row| row.0 == rest)?;
    Some(Ease::Penner(family.1, direction))
}

/// The name that was most likely meant, in the writing of CSS (`ease-in-out`) and of easings.net (`easeInOutCubic`), too.
///
/// ```
/// use kinora_lang::builtin::ease::nearest;
/// assert_eq!(nearest("easeInOutCubic").as_deref(), Some("in_out_cubic"));
/// assert_eq!(nearest("ease-in-out").as_deref(), Some("ease_in_out"));
/// assert_eq!(nearest("inout_cubic").as_deref(), Some("in_out_cubic"));
/// assert_eq!(nearest("zzz"), None);
/// ```
pub fn nearest(name: &str) -> Option<String> {
    let mut snake = String::new();
    for letter in name.chars().take(64) {
        if letter.is_uppercase() && !snake.is_empty() && !snake.ends_with('_') {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    let snake = snake.replace('-', "_");
    let known = |name: &str| named(name).map(|_| name.to_string());
    let bare = snake.strip_prefix("ease_").unwrap_or(&snake);
    known(&snake).or_else(|| known(bare)).or_else(|| {
        let names = names();
        suggest(bare, names.iter().map(String::as_str)).first().map(|near| near.to_string())
    })
}

/// Every name that [`named`] knows.
pub fn names() -> Vec<String> {
    let penner =
        FAMILIES.iter().flat_map(|(family, _)| DIRECTIONS.iter().map(move |(prefix, _)| format!("{prefix}{family}")));
    CSS.iter().map(|row| row.0.to_string()).chain(penner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known() {
        let names = names();
        assert_eq!(names.len(), 37);
        assert!(names.iter().all(|name| named(name).is_some()));
    }
}
