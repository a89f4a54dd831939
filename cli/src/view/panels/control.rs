//! What a hand can change in a text: today the values of its parameters. Nothing in here knows that a control stands for a
//! parameter, so that any literal can become one: it has a place in the text and a way to be written there.

use kinora_lang::Plain;
use kinora_lang::builtin::color::srgb_to_linear;
use kinora_lang::dimension::{self, Dimension};
use kinora_lang::eval::Param;
use kinora_lang::source::{FileId, Source, Span};
use kinora_lang::syntax::ast::{Expr, ExprKind};
use kinora_lang::syntax::parse_value;

/// Digits that a number keeps when it is written.
const DIGITS: i32 = 6;

/// Something with a value that can be changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Control {
    /// What it is called.
    pub name: String,
    /// What is said about it.
    pub doc: Option<String>,
    /// The type of its value, as the language calls it.
    pub ty: String,
    /// How it is changed.
    pub kind: Kind,
    /// Its value.
    pub value: Setting,
    /// What is written in the text.
    pub written: String,
    /// Where.
    pub place: (FileId, Span),
}

/// How a value is changed.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A number.
    Number {
        /// What it is counted in.
        unit: Unit,
        /// From where to where, in that unit.
        range: Option<[f64; 2]>,
        /// Whether it is whole.
        int: bool,
    },
    /// On or off.
    Switch,
    /// A colour.
    Color,
    /// Text.
    Text,
    /// Several numbers.
    Vector {
        /// What they are counted in.
        unit: Unit,
    },
}

/// A value as it is shown.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// In the control's unit.
    Number(f64),
    /// On or off.
    Switch(bool),
    /// Red, green and blue as displays have them.
    Color([u8; 3]),
    /// Without quotes.
    Text(String),
    /// In the control's unit.
    Vector(Vec<f64>),
}

/// What a number is counted in.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// As it is written behind a number: `cm`, `%`; empty for a bare number.
    pub text: String,
    /// How much of SI it is.
    pub factor: f64,
}

/// The controls of a scene's parameters. One whose value is nothing plain, such as a material, has none.
pub fn of_params(params: &[Param]) -> Vec<Control> {
    params.iter().filter_map(of_param).collect()
}

fn of_param(param: &Param) -> Option<Control> {
    let unit = |dimension| unit_of(&param.default, dimension);
    let (kind, value) = match param.value.as_ref()? {
        Plain::Number { value, dimension, int } => {
            let (unit, int) = (unit(*dimension), *int && dimension.is_none());
            let range = param.bounds.map(|bounds| bounds.map(|bound| tidy(bound / unit.factor)));
            let range = range.filter(|[low, high]| low.is_finite() && high.is_finite() && low < high);
            let value = tidy(value / unit.factor);
            (Kind::Number { unit, range, int }, Setting::Number(value))
        }
        Plain::Bool(on) => (Kind::Switch, Setting::Switch(*on)),
        Plain::Text(text) => (Kind::Text, Setting::Text(text.to_string())),
        Plain::Color(linear) => (Kind::Color, Setting::Color(linear.map(srgb8))),
        Plain::Vector(parts, dimension) => {
            let unit = unit(*dimension);
            let parts = parts.iter().map(|part| tidy(part / unit.factor)).collect();
            (Kind::Vector { unit }, Setting::Vector(parts))
        }
    };
    let Param { name, doc, ty, default, place, .. } = param.clone();
    Some(Control { name, doc, ty, kind, value, written: default, place })
}

impl Control {
    /// Its value as it is written in a scene.
    pub fn text(&self) -> String {
        match (&self.value, &self.kind) {
            (Setting::Number(value), Kind::Number { unit, int, .. }) => match int {
                true => format!("{}", value.round()),
                false => unit.write(*value),
            },
            (Setting::Vector(parts), Kind::Vector { unit }) => {
                let parts: Vec<String> = parts.iter().map(|part| unit.write(*part)).collect();
                format!("({})", parts.join(", "))
            }
            (Setting::Number(value), _) => short(*value),
            (Setting::Vector(parts), _) => {
                format!("({})", parts.iter().map(|p| short(*p)).collect::<Vec<_>>().join(", "))
            }
            (Setting::Switch(on), _) => on.to_string(),
            (Setting::Color([r, g, b]), _) => format!("#{r:02x}{g:02x}{b:02x}"),
            (Setting::Text(text), _) => quoted(text),
        }
    }
}

impl Unit {
    fn write(&self, value: f64) -> String {
        format!("{}{}", short(value), self.text)
    }
}

/// The unit that the number in `written` has, else the one of SI.
fn unit_of(written: &str, dimension: Dimension) -> Unit {
    let source = Source::new(FileId::default(), "value", written);
    let (expr, _) = parse_value(&source);
    let found = unit_in(&expr).and_then(|text| {
        let (factor, of) = dimension::unit(&text)?;
        // A frame is no length of time but for a clock.
        (of == dimension && dimension::frames(&text) == 0 && factor > 0.0).then_some(Unit { text, factor })
    });
    found.unwrap_or_else(|| match dimension == Dimension::ANGLE {
        true => Unit { text: "deg".into(), factor: 1f64.to_radians() },
        false => Unit { text: dimension.unit(), factor: 1.0 },
    })
}

fn unit_in(expr: &Expr) -> Option<String> {
    match &expr.kind {
        ExprKind::Number(number) => Some(number.unit.as_ref()?.name.text.to_string()),
        ExprKind::Unary { value, .. } => unit_in(value),
        ExprKind::Tuple(parts) => parts.iter().find_map(unit_in),
        _ => None,
    }
}

/// Text between quotes.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out += "\\\"",
            '\\' => out += "\\\\",
            '\n' => out += "\\n",
            '\t' => out += "\\t",
            c if c.is_control() => {}
            c => out.push(c),
        }
    }
    out + "\""
}

/// A number with a few digits.
pub fn short(value: f64) -> String {
    dimension::short(value)
}

/// A number without what a change of units added to it.
fn tidy(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10f64.powi(DIGITS + 3 - value.abs().log10().ceil() as i32);
    if scale.is_finite() && scale > 0.0 { (value * scale).round() / scale } else { value }
}

/// One channel as displays have it, IEC 61966-2-1.
fn srgb8(linear: f64) -> u8 {
    let code = |at: u8| srgb_to_linear(f64::from(at) / 255.0);
    // The code whose light is nearest: its inverse, without a second formula.
    let above = (0..=255u8).position(|at| code(at) >= linear).map_or(255, |at| at as u8);
    let below = above.saturating_sub(1);
    if linear - code(below) < code(above) - linear { below } else { above }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{self, Changes};

    const REST: &str =
        "\nrender { fps: 24 }\ncamera { position: (0, 0, 5), look_at: (0, 0, 0) }\nsky { color: #fff }\n";

    fn params(text: &str, changes: &Changes) -> Vec<Param> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.kin");
        std::fs::write(&path, format!("lang 1\n{text}{REST}")).unwrap();
        let loaded = session::load(&path, changes).unwrap();
        assert!(loaded.scene.is_some(), "{text}: {:?}", loaded.diagnostics);
        loaded.params
    }

    fn control(text: &str) -> Control {
        of_params(&params(text, &Changes::default())).remove(0)
    }

    #[test]
    fn each_type_has_its_control() {
        let number =
            |unit: &str, factor, range, int| Kind::Number { unit: Unit { text: unit.into(), factor }, range, int };
        let degree = 1f64.to_radians();
        for (text, kind, written) in [
            ("param a: float = 0.25 in 0..1", number("", 1.0, Some([0.0, 1.0]), false), "0.25"),
            ("param a = 3", number("", 1.0, None, true), "3"),
            ("param a: int = 3 in 1..9", number("", 1.0, Some([1.0, 9.0]), true), "3"),
            ("param a: float = 3", number("", 1.0, None, false), "3"),
            ("param a = 40cm in 10cm..2m", number("cm", 0.01, Some([10.0, 200.0]), false), "40cm"),
            ("param a: length = 0.5", number("m", 1.0, None, false), "0.5m"),
            ("param a = -30deg", number("deg", degree, None, false), "-30deg"),
            ("param a = 1rad", number("rad", 1.0, None, false), "1rad"),
            ("param a = 1rad + 10deg", number("deg", degree, None, false), "67.2958deg"),
            ("param a = 12f", number("s", 1.0, None, false), "0.5s"),
            ("param a = 50%", number("%", 0.01, None, false), "50%"),
            ("param a = 5W/m^2/sr", number("W/m^2/sr", 1.0, None, false), "5W/m^2/sr"),
            ("param a = true", Kind::Switch, "true"),
            ("param a = #D0402A", Kind::Color, "#d0402a"),
            ("param a = \"say \\\"x\\\"\"", Kind::Text, "\"say \\\"x\\\"\""),
            ("param a = (1, 2.5, -3)", Kind::Vector { unit: Unit { text: "".into(), factor: 1.0 } }, "(1, 2.5, -3)"),
            ("param a = (10cm, 2m)", Kind::Vector { unit: Unit { text: "cm".into(), factor: 0.01 } }, "(10cm, 200cm)"),
        ] {
            let control = control(text);
            assert_eq!((&control.kind, control.text()), (&kind, written.to_string()), "{text}");
        }
        assert_eq!(of_params(&params("param a: material = diffuse { color: #fff }", &Changes::default())), []);
    }

    #[test]
    fn what_is_written_is_taken_and_says_the_same() {
        for (text, setting) in [
            ("param a: float = 0.25 in 0..1", Setting::Number(0.123456)),
            ("param a: int = 3 in 1..9", Setting::Number(7.0)),
            ("param a = 40cm in 10cm..2m", Setting::Number(123.4)),
            ("param a = 1 / 3", Setting::Number(0.5)),
            ("param a = -30deg", Setting::Number(15.5)),
            ("param a: length = 0.5", Setting::Number(1e-7)),
            ("param a = 4000K", Setting::Number(6500.0)),
            ("param a = 50%", Setting::Number(12.5)),
            ("param a = 100N*s/m", Setting::Number(3.0)),
            ("param a = true", Setting::Switch(false)),
            ("param a = #123", Setting::Color([1, 128, 254])),
            ("param a = \"x\"", Setting::Text("a \"b\" \\ c".into())),
            ("param a = (1, 2, 3)", Setting::Vector(vec![0.5, -2.0, 0.0])),
            ("param a = (1m, 20cm, 3m)", Setting::Vector(vec![0.5, -2.0, 0.25])),
        ] {
            let mut control = control(text);
            control.value = setting;
            let changes = Changes { params: vec![("a".into(), control.text())], ..Changes::default() };
            let again = of_params(&params(text, &changes)).remove(0);
            assert_eq!(again.value, control.value, "{text} as {}", control.text());
            assert_eq!(again.kind, control.kind, "{text}");
        }
    }

    #[test]
    fn a_place_is_that_of_the_literal() {
        let control = control("/// How red.\nparam red: float = 0.25 in 0..1");
        let text = format!("lang 1\n/// How red.\nparam red: float = 0.25 in 0..1{REST}");
        assert_eq!(&text[control.place.1.start as usize..control.place.1.end as usize], "0.25");
        assert_eq!((control.written.as_str(), control.doc.as_deref()), ("0.25", Some("How red.")));
    }
}
