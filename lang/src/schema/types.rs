//! The words for types, as `param`, `let`, functions and prefabs write them.

use crate::dimension::Dimension;

/// A type that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TypeName {
    /// As written.
    pub name: &'static str,
    /// What a number of it measures; `None` where it is no number with a unit of its own.
    pub dimension: Option<Dimension>,
    /// One line.
    pub doc: &'static str,
}

const fn of(name: &'static str, doc: &'static str) -> TypeName {
    TypeName { name, dimension: None, doc }
}

const fn number(name: &'static str, dimension: Dimension, doc: &'static str) -> TypeName {
    TypeName { name, dimension: Some(dimension), doc }
}

/// Every type.
pub static TYPES: &[TypeName] = &[
    number("float", Dimension::NONE, "a number without a unit: `0.5`, `50%`, `3`"),
    of("int", "a whole number, up to 2^53"),
    of("bool", "`true` or `false`"),
    of("string", "text"),
    of("color", "a colour"),
    of("vec2", "two numbers of one dimension"),
    of("vec3", "three numbers of one dimension"),
    of("quat", "a rotation"),
    number("length", Dimension::LENGTH, "`2m`; a bare number is metres"),
    number("area", Dimension::AREA, "`2m^2`"),
    number("volume", Dimension::VOLUME, "`2m^3`"),
    number("angle", Dimension::ANGLE, "`40deg`"),
    number("solid_angle", Dimension::SOLID_ANGLE, "`1sr`"),
    number("time", Dimension::TIME, "`2s`, `24f`"),
    number("frequency", Dimension::RATE, "`50Hz`"),
    number("speed", Dimension::SPEED, "`3m/s`"),
    number("acceleration", Dimension::ACCELERATION, "`9.81m/s^2`"),
    number("angular_speed", Dimension::SPIN, "`3rad/s`"),
    number("mass", Dimension::MASS, "`70kg`"),
    number("density", Dimension::DENSITY, "`1000kg/m^3`"),
    number("force", Dimension::FORCE, "`5N`"),
    number("impulse", Dimension::IMPULSE, "`0.1N*s`"),
    number("stiffness", Dimension::STIFFNESS, "`100N/m`"),
    number("damping", Dimension::DAMPING, "`2N*s/m`"),
    number("energy", Dimension::ENERGY, "`5J`"),
    number("power", Dimension::POWER, "`40W`"),
    number("irradiance", Dimension::IRRADIANCE, "`1000W/m^2`"),
    number("radiance", Dimension::RADIANCE, "`5W/m^2/sr`"),
    number("temperature", Dimension::TEMPERATURE, "`4000K`"),
    of("material", "a material"),
    of("texture", "an `image`, a `checker` or a `normal_map`"),
    of("camera", "a camera"),
    of("node", "any node"),
    of("list", "`list<T>`: a list of `T`, as in `list<length>`; `list` alone takes any"),
    of("range", "`a..b`"),
];

/// The type of that name.
pub fn type_name(name: &str) -> Option<&'static TypeName> {
    TYPES.iter().find(|row| row.name == name)
}
