//! The schema in words: for the reference, and for editors. All of it is Markdown.

use super::{Bare, Check, Default, Property, Since, TYPES, Type};
use crate::dimension::{Dimension, show};

impl Property {
    /// Its type: `length`, `angle (deg)`, the words that it takes; with what is not there yet.
    pub fn type_text(&self) -> String {
        let number = |of: Dimension, bare: Bare| match (TYPES.iter().find(|row| row.dimension == Some(of)), bare) {
            (Some(row), Bare::Allowed) => row.name.to_string(),
            (Some(row), Bare::Refused) => {
                format!("{} ({})", row.name, if of == Dimension::ANGLE { "deg".into() } else { of.unit() })
            }
            (None, _) => of.unit(),
        };
        match self.ty {
            Type::Number(of, bare) => number(of, bare),
            Type::Count => "int".into(),
            Type::Bool => "bool".into(),
            Type::Text => "string".into(),
            Type::Color => "color".into(),
            Type::Vec2(Dimension::NONE, _) => "vec2".into(),
            Type::Vec3(Dimension::NONE, _) => "vec3".into(),
            Type::Vec2(of, bare) => format!("vec2 of {}", number(of, bare)),
            Type::Vec3(of, bare) => format!("vec3 of {}", number(of, bare)),
            Type::Scale => "float or vec3".into(),
            Type::Rotation => "quat".into(),
            Type::Choice(choices) => {
                let later = |since| if since == Since::Now { "" } else { " *(not yet)*" };
                choices
                    .iter()
                    .map(|choice| format!("`{}`{}", choice.name, later(choice.since)))
                    .collect::<Vec<_>>()
                    .join(" ")
            }
            Type::Counts => "two ints".into(),
            Type::Node(sort) => sort.with_article().trim_start_matches("a ").into(),
            Type::Placed => "shape or group".into(),
            Type::Target => "point (vec3), shape or group".into(),
            Type::NormalMap => "normal map".into(),
            Type::Points => "`list<vec3>`".into(),
            Type::Pairs => "`list<vec2>`".into(),
            Type::Indices => "`list<int>`".into(),
            Type::Limits => "range of angles (hinge) or lengths (slider)".into(),
            Type::Drive => "rad/s (hinge) or m/s (slider)".into(),
        }
    }

    /// What it is where it is not set; empty where that is computed from the rest.
    pub fn default_text(&self) -> String {
        let number = |value: f64| match self.ty {
            _ if value == f64::INFINITY => "∞".into(),
            _ if value == 0.0 => "0".into(),
            Type::Number(of, _) | Type::Vec2(of, _) | Type::Vec3(of, _) => show(value, of),
            _ => show(value, Dimension::NONE),
        };
        let tuple = |values: &[f64]| {
            let all: Vec<String> = values.iter().map(|value| number(*value)).collect();
            format!("`({})`", all.join(", "))
        };
        match (self.default, self.ty) {
            (Default::Computed, _) => "".into(),
            (Default::Needed, _) => "**needed**".into(),
            (Default::Number(value), Type::Color) => format!("`linear({0}, {0}, {0})`", number(value)),
            (Default::Number(value), Type::Vec3(..) | Type::Target) => tuple(&[value; 3]),
            (Default::Number(value), Type::Vec2(..)) => tuple(&[value; 2]),
            (Default::Number(value), _) => format!("`{}`", number(value)),
            (Default::Three(three), _) => tuple(&three),
            (Default::Two(two), _) => tuple(&two),
            (Default::Bool(value), _) => format!("`{value}`"),
            (Default::Word(word), _) => format!("`{word}`"),
            (Default::Identity, _) => "no turn".into(),
        }
    }
}

impl Check {
    /// The values that are allowed; empty where all are.
    pub fn text(self) -> String {
        match self {
            Check::Any => "".into(),
            Check::Above0 | Check::Mass => "above 0".into(),
            Check::AtLeast0 => "at least 0".into(),
            Check::Within(low, high) if high >= i64::from(i32::MAX) && low >= 0 => format!("at least {low}"),
            Check::Within(_, high) if high >= i64::from(i32::MAX) => "".into(),
            Check::Within(low, high) => format!("{low}..{high}"),
            Check::Ratio => "0..1".into(),
            Check::Reflectance => "channels 0..1".into(),
            Check::NotZero => "not 0".into(),
            Check::Ior => "at least 1".into(),
            Check::Fov => "above 0deg, at most 360deg; perspective below 180deg".into(),
            Check::Blades => "0 or 3..65535".into(),
            Check::Shutter => "0deg..360deg".into(),
            Check::Disc => "0deg.. below 180deg".into(),
            Check::Cone => "above 0deg, at most 360deg".into(),
            Check::Resolution => "1..16384 each".into(),
            Check::Direction => "not (0, 0, 0)".into(),
            Check::Spectrum => "a measured metal".into(),
        }
    }
}
