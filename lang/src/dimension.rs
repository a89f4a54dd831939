//! Dimensions and units: what a number measures, kept as exponents, and the factors that bring every literal to SI.
//!
//! ```
//! use kinora_lang::dimension::{Dimension, unit};
//!
//! let (factor, dimension) = unit("kg/m^3").unwrap();
//! assert_eq!((factor, dimension), (1.0, Dimension::DENSITY));
//! assert_eq!(Dimension::LENGTH.per(Dimension::TIME), Some(Dimension::SPEED));
//! assert_eq!(Dimension::ANGLE.with_article(), "an angle");
//! ```

use std::fmt::Write;

/// Exponents of length, mass, time, temperature, luminous intensity and angle (a steradian is an angle squared).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[allow(missing_docs)]
pub struct Dimension {
    pub length: i8,
    pub mass: i8,
    pub time: i8,
    pub temperature: i8,
    pub luminous: i8,
    pub angle: i8,
}

const fn of(length: i8, mass: i8, time: i8, temperature: i8, luminous: i8, angle: i8) -> Dimension {
    Dimension { length, mass, time, temperature, luminous, angle }
}

#[allow(missing_docs)]
impl Dimension {
    pub const NONE: Dimension = of(0, 0, 0, 0, 0, 0);
    pub const LENGTH: Dimension = of(1, 0, 0, 0, 0, 0);
    pub const AREA: Dimension = of(2, 0, 0, 0, 0, 0);
    pub const VOLUME: Dimension = of(3, 0, 0, 0, 0, 0);
    pub const MASS: Dimension = of(0, 1, 0, 0, 0, 0);
    pub const TIME: Dimension = of(0, 0, 1, 0, 0, 0);
    pub const TEMPERATURE: Dimension = of(0, 0, 0, 1, 0, 0);
    pub const CANDELA: Dimension = of(0, 0, 0, 0, 1, 0);
    pub const ANGLE: Dimension = of(0, 0, 0, 0, 0, 1);
    pub const SOLID_ANGLE: Dimension = of(0, 0, 0, 0, 0, 2);
    pub const RATE: Dimension = of(0, 0, -1, 0, 0, 0);
    pub const SPEED: Dimension = of(1, 0, -1, 0, 0, 0);
    pub const ACCELERATION: Dimension = of(1, 0, -2, 0, 0, 0);
    pub const SPIN: Dimension = of(0, 0, -1, 0, 0, 1);
    pub const FORCE: Dimension = of(1, 1, -2, 0, 0, 0);
    pub const ENERGY: Dimension = of(2, 1, -2, 0, 0, 0);
    pub const POWER: Dimension = of(2, 1, -3, 0, 0, 0);
    pub const DENSITY: Dimension = of(-3, 1, 0, 0, 0, 0);
    pub const AREA_DENSITY: Dimension = of(-2, 1, 0, 0, 0, 0);
    pub const IMPULSE: Dimension = of(1, 1, -1, 0, 0, 0);
    pub const STIFFNESS: Dimension = of(0, 1, -2, 0, 0, 0);
    pub const DAMPING: Dimension = of(0, 1, -1, 0, 0, 0);
    pub const IRRADIANCE: Dimension = of(0, 1, -3, 0, 0, 0);
    pub const RADIANCE: Dimension = of(0, 1, -3, 0, 0, -2);
    pub const LUMEN: Dimension = of(0, 0, 0, 0, 1, 2);
    pub const LUX: Dimension = of(-2, 0, 0, 0, 1, 2);
}

/// Dimensions with a name of their own, and the unit that shows such a value.
const NAMES: &[(Dimension, &str, &str)] = &[
    (Dimension::NONE, "a number", ""),
    (Dimension::LENGTH, "a length", "m"),
    (Dimension::AREA, "an area", "m^2"),
    (Dimension::VOLUME, "a volume", "m^3"),
    (Dimension::MASS, "a mass", "kg"),
    (Dimension::TIME, "a time", "s"),
    (Dimension::TEMPERATURE, "a temperature", "K"),
    (Dimension::CANDELA, "a luminous intensity", "cd"),
    (Dimension::ANGLE, "an angle", "rad"),
    (Dimension::SOLID_ANGLE, "a solid angle", "sr"),
    (Dimension::RATE, "a rate", "Hz"),
    (Dimension::SPEED, "a speed", "m/s"),
    (Dimension::ACCELERATION, "an acceleration", "m/s^2"),
    (Dimension::SPIN, "an angular speed", "rad/s"),
    (Dimension::FORCE, "a force", "N"),
    (Dimension::ENERGY, "an energy", "J"),
    (Dimension::POWER, "a power", "W"),
    (Dimension::DENSITY, "a density", "kg/m^3"),
    (Dimension::AREA_DENSITY, "a density per area", "kg/m^2"),
    (Dimension::IMPULSE, "an impulse", "N*s"),
    (Dimension::STIFFNESS, "a stiffness", "N/m"),
    (Dimension::DAMPING, "a damping", "N*s/m"),
    (Dimension::IRRADIANCE, "an irradiance", "W/m^2"),
    (Dimension::RADIANCE, "a radiance", "W/m^2/sr"),
    (Dimension::LUMEN, "a luminous flux", "lm"),
    (Dimension::LUX, "an illuminance", "lx"),
];

impl Dimension {
    fn exponents(self) -> [i8; 6] {
        [self.length, self.mass, self.time, self.temperature, self.luminous, self.angle]
    }

    fn from_exponents(e: [i8; 6]) -> Dimension {
        of(e[0], e[1], e[2], e[3], e[4], e[5])
    }

    fn combine(self, other: Dimension, f: impl Fn(i8, i8) -> Option<i8>) -> Option<Dimension> {
        let mut out = [0; 6];
        for (to, (a, b)) in out.iter_mut().zip(self.exponents().into_iter().zip(other.exponents())) {
            *to = f(a, b)?;
        }
        Some(Dimension::from_exponents(out))
    }

    /// Whether a value of this dimension is a plain number.
    pub fn is_none(self) -> bool {
        self == Dimension::NONE
    }

    /// The dimension of a product; `None` where an exponent leaves its range.
    pub fn times(self, other: Dimension) -> Option<Dimension> {
        self.combine(other, i8::checked_add)
    }

    /// The dimension of a quotient; `None` where an exponent leaves its range.
    pub fn per(self, other: Dimension) -> Option<Dimension> {
        self.combine(other, i8::checked_sub)
    }

    /// The dimension of a power; `None` where an exponent leaves its range.
    pub fn power(self, exponent: i8) -> Option<Dimension> {
        self.combine(Dimension::NONE, |a, _| a.checked_mul(exponent))
    }

    /// The dimension of a square root; `None` where an exponent is odd.
    pub fn root(self) -> Option<Dimension> {
        self.combine(Dimension::NONE, |a, _| (a % 2 == 0).then_some(a / 2))
    }

    /// As a message names it: `a length`, `a quantity in m^2*K`.
    pub fn with_article(self) -> String {
        match NAMES.iter().find(|row| row.0 == self) {
            Some(row) => row.1.into(),
            None => format!("a quantity in {}", self.unit()),
        }
    }

    /// The SI unit that shows a value of this dimension; empty for plain numbers.
    pub fn unit(self) -> String {
        if let Some(row) = NAMES.iter().find(|row| row.0 == self) {
            return row.2.into();
        }
        let symbols = ["m", "kg", "s", "K", "cd", "rad"];
        let mut text = String::new();
        let mut part = |sign: &str, symbol: &str, exponent: i32| {
            let _ = match exponent {
                1 => write!(text, "{sign}{symbol}"),
                _ => write!(text, "{sign}{symbol}^{exponent}"),
            };
        };
        let parts = || self.exponents().into_iter().map(i32::from).zip(symbols);
        for (i, (exponent, symbol)) in parts().filter(|part| part.0 > 0).enumerate() {
            part(if i == 0 { "" } else { "*" }, symbol, exponent);
        }
        for (exponent, symbol) in parts().filter(|part| part.0 < 0) {
            part("/", symbol, -exponent);
        }
        text
    }
}

/// A number in SI as a message shows it: with its unit, short.
pub fn show(value: f64, dimension: Dimension) -> String {
    if dimension == Dimension::ANGLE {
        return format!("{}deg", short(value.to_degrees()));
    }
    format!("{}{}", short(value), dimension.unit())
}

/// A number with at most six significant digits.
pub fn short(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return if value.is_nan() { "not a number".into() } else { format!("{value}") };
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..15).contains(&magnitude) {
        return format!("{value:e}");
    }
    let digits = (5 - magnitude).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// Every unit: its word, its factor to SI and its dimension. `f` (frames) has the factor 1: the evaluator divides by fps.
pub const UNITS: &[(&str, f64, Dimension)] = &[
    ("mm", 1e-3, Dimension::LENGTH),
    ("cm", 1e-2, Dimension::LENGTH),
    ("m", 1.0, Dimension::LENGTH),
    ("km", 1e3, Dimension::LENGTH),
    ("in", 0.0254, Dimension::LENGTH),
    ("ft", 0.3048, Dimension::LENGTH),
    ("deg", std::f64::consts::PI / 180.0, Dimension::ANGLE),
    ("rad", 1.0, Dimension::ANGLE),
    ("turn", std::f64::consts::TAU, Dimension::ANGLE),
    ("ms", 1e-3, Dimension::TIME),
    ("s", 1.0, Dimension::TIME),
    ("min", 60.0, Dimension::TIME),
    ("f", 1.0, Dimension::TIME),
    ("Hz", 1.0, Dimension::RATE),
    ("g", 1e-3, Dimension::MASS),
    ("kg", 1.0, Dimension::MASS),
    ("N", 1.0, Dimension::FORCE),
    ("J", 1.0, Dimension::ENERGY),
    ("W", 1.0, Dimension::POWER),
    ("K", 1.0, Dimension::TEMPERATURE),
    ("lm", 1.0, Dimension::LUMEN),
    ("cd", 1.0, Dimension::CANDELA),
    ("lx", 1.0, Dimension::LUX),
    ("sr", 1.0, Dimension::SOLID_ANGLE),
];

/// The factor to SI and the dimension of a unit as written: `m`, `%`, `W/m^2/sr`. `None` for what is no unit.
pub fn unit(text: &str) -> Option<(f64, Dimension)> {
    if text == "%" {
        return Some((0.01, Dimension::NONE));
    }
    let mut factor = 1.0;
    let mut dimension = Dimension::NONE;
    let mut rest = text;
    let mut divide = false;
    loop {
        let end = rest.find(['*', '/']).unwrap_or(rest.len());
        let (word, exponent) = match rest[..end].split_once('^') {
            Some((word, exponent)) => (word, exponent.parse::<i8>().ok()?),
            None => (&rest[..end], 1),
        };
        let row = UNITS.iter().find(|row| row.0 == word)?;
        let exponent = if divide { exponent.checked_neg()? } else { exponent };
        factor *= row.1.powi(i32::from(exponent));
        dimension = dimension.times(row.2.power(exponent)?)?;
        match rest.as_bytes().get(end) {
            None => return Some((factor, dimension)),
            Some(operator) => divide = *operator == b'/',
        }
        rest = &rest[end + 1..];
    }
}

/// How often `f` stands in a unit: 1 in `24f`, -1 in `m/f`.
pub fn frames(unit: &str) -> i32 {
    let mut total = 0;
    let mut sign = 1;
    let mut rest = unit;
    loop {
        let end = rest.find(['*', '/']).unwrap_or(rest.len());
        let (word, exponent) = rest[..end].split_once('^').unwrap_or((&rest[..end], "1"));
        if word == "f" {
            total += sign * exponent.parse::<i32>().unwrap_or(1);
        }
        match rest.as_bytes().get(end) {
            None => return total,
            Some(operator) => sign = if *operator == b'/' { -1 } else { 1 },
        }
        rest = &rest[end + 1..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, factor: f64, dimension: Dimension) {
        let (found, of) = unit(text).unwrap_or_else(|| panic!("{text}"));
        assert!((found - factor).abs() <= 1e-12 * factor.abs(), "{text}: {found}");
        assert_eq!(of, dimension, "{text}");
    }

    #[test]
    fn units() {
        check("mm", 1e-3, Dimension::LENGTH);
        check("in", 0.0254, Dimension::LENGTH);
        check("%", 0.01, Dimension::NONE);
        check("turn", std::f64::consts::TAU, Dimension::ANGLE);
        check("m/s^2", 1.0, Dimension::ACCELERATION);
        check("W/m^2/sr", 1.0, Dimension::RADIANCE);
        check("N*s", 1.0, Dimension::IMPULSE);
        check("N/m", 1.0, Dimension::STIFFNESS);
        check("g/cm^3", 1000.0, Dimension::DENSITY);
        check("m^-1", 1.0, of(-1, 0, 0, 0, 0, 0));
        for bad in ["", "meters", "m/", "m//s", "m^9^9", "m^999", "/s"] {
            assert_eq!(unit(bad), None, "{bad}");
        }
        let huge = vec!["m^9"; 40].join("*");
        assert_eq!(unit(&huge), None);
    }

    #[test]
    fn names() {
        for row in NAMES.iter().filter(|row| !row.2.is_empty()) {
            assert_eq!(unit(row.2), Some((1.0, row.0)), "{}", row.2);
        }
        assert_eq!(of(2, 0, 0, 1, 0, 0).with_article(), "a quantity in m^2*K");
        assert_eq!(of(-1, 0, -1, 0, 0, 0).unit(), "/m/s");
        assert_eq!(show(0.125, Dimension::LENGTH), "0.125m");
        assert_eq!(show(std::f64::consts::PI, Dimension::ANGLE), "180deg");
        assert_eq!(short(-0.1 - 0.2), "-0.3");
        assert_eq!(short(1234567.0), "1234567");
        assert_eq!(short(1e300), "1e300");
    }
}
