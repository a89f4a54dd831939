//! The table of built-in functions.

use super::texture::{self, CHANNELS, FILTERS, SPACES, WRAPS};
use super::{Builtin, Call, Param, color, math, random, turn};
use crate::schema::Choice;
use crate::value::Value;

const fn param(name: &'static str) -> Param {
    Param { name, optional: false, words: &[] }
}

const fn optional(name: &'static str) -> Param {
    Param { name, optional: true, words: &[] }
}

const fn words(name: &'static str, words: &'static [Choice]) -> Param {
    Param { name, optional: true, words }
}

const fn of(
    name: &'static str,
    params: &'static [Param],
    run: fn(&mut Call<'_>) -> Value,
    doc: &'static str,
) -> Builtin {
    Builtin { name, params, rest: false, run, doc }
}

const fn any(
    name: &'static str,
    params: &'static [Param],
    run: fn(&mut Call<'_>) -> Value,
    doc: &'static str,
) -> Builtin {
    Builtin { name, params, rest: true, run, doc }
}

const X: &[Param] = &[param("x")];
const AB: &[Param] = &[param("a"), param("b")];
const ANGLE: &[Param] = &[param("angle")];
const RGB: &[Param] = &[param("r"), param("g"), param("b")];

/// Every built-in function.
pub static BUILTINS: &[Builtin] = &[
    of("abs", X, math::abs, "x without its sign"),
    of("sign", X, math::sign, "-1, 0 or 1"),
    of("floor", X, math::floor, "the whole number at or below x"),
    of("ceil", X, math::ceil, "the whole number at or above x"),
    of("round", X, math::round, "the nearest whole number, halves away from 0"),
    of("mod", AB, math::modulo, "a - b floor(a / b): has the sign of b"),
    of("sqrt", X, math::sqrt, "square root"),
    of("exp", X, math::exp, "e to the power of x"),
    of("log", X, math::log, "natural logarithm"),
    of("sin", ANGLE, math::sin, "sine"),
    of("cos", ANGLE, math::cos, "cosine"),
    of("tan", ANGLE, math::tan, "tangent"),
    of("asin", X, math::asin, "the angle whose sine is x"),
    of("acos", X, math::acos, "the angle whose cosine is x"),
    of("atan", X, math::atan, "the angle whose tangent is x"),
    of("atan2", &[param("y"), param("x")], math::atan2, "the angle of the point (x, y)"),
    any("min", &[], math::min, "the least of its arguments, or of a list"),
    any("max", &[], math::max, "the greatest of its arguments, or of a list"),
    any("sum", &[], math::sum, "the sum of its arguments, or of a list"),
    of("count", &[param("list")], math::count, "how many items a list has"),
    of(
        "mix",
        &[param("a"), param("b"), param("amount")],
        math::mix,
        "a (1 - amount) + b amount, of numbers, vectors, colours or materials",
    ),
    of("step", &[param("edge"), param("x")], math::step, "0 below the edge, else 1"),
    of("smoothstep", &[param("low"), param("high"), param("x")], math::smoothstep, "0 to 1, smooth at both ends"),
    of("clamp", &[param("x"), param("low"), param("high")], math::clamp, "x, but not below low or above high"),
    of("saturate", X, math::saturate, "x, but not below 0 or above 1"),
    of("length", &[param("v")], math::length, "the length of a vector"),
    of("normalize", &[param("v")], math::normalize, "the vector of length 1 in the same direction"),
    of("cross", AB, math::cross, "the cross product"),
    of("dot", AB, math::dot, "the scalar product"),
    of("distance", AB, math::distance, "how far two points are apart"),
    of("turn", X, math::turn, "a share of a full turn as an angle"),
    of("f_number", &[param("n"), param("focal_length")], math::f_number, "the diameter of a lens"),
    any("rand", &[optional("seed")], random::rand, "a number in 0..1 that depends on its arguments only"),
    of("noise", &[param("p")], random::noise, "smooth gradient noise in -1..1 at a point"),
    of(
        "fbm",
        &[param("p"), optional("octaves"), optional("gain"), optional("lacunarity")],
        random::fbm,
        "noise of several sizes in -1..1 at a point",
    ),
    of("cell", &[param("p")], random::cell, "how far the nearest of scattered points is, 0..1"),
    of("cell_id", &[param("p")], random::cell_id, "a number in 0..1 of the nearest of scattered points"),
    of("rotate_x", ANGLE, turn::rotate_x, "a turn about x"),
    of("rotate_y", ANGLE, turn::rotate_y, "a turn about y: 90deg takes z to x"),
    of("rotate_z", ANGLE, turn::rotate_z, "a turn about z"),
    of("axis_angle", &[param("axis"), param("angle")], turn::axis_angle, "a turn about an axis"),
    of("euler", &[param("x"), param("y"), param("z")], turn::euler, "turns about the fixed x, then y, then z"),
    of(
        "look_at",
        &[param("from"), param("to"), optional("up")],
        turn::look_at,
        "the rotation of a camera: local -z goes from `from` to `to`",
    ),
    of("face_towards", &[param("direction"), optional("up")], turn::face_towards, "turns local +z to a direction"),
    of("srgb", RGB, color::srgb, "a colour by sRGB-encoded channels"),
    of("linear", RGB, color::linear, "a colour by linear Rec. 709 channels"),
    of("hsv", &[param("h"), param("s"), param("v")], color::hsv, "a colour by hue, saturation and value, of sRGB"),
    of("oklch", &[param("l"), param("c"), param("h")], color::oklch, "a colour by lightness, chroma and hue"),
    of("blackbody", &[param("temperature")], color::blackbody, "the colour of a glowing body at luminance 1"),
    of(
        "image",
        &[
            param("file"),
            words("space", SPACES),
            words("wrap", WRAPS),
            optional("scale"),
            optional("offset"),
            optional("rotation"),
            words("filter", FILTERS),
            words("channel", CHANNELS),
        ],
        texture::image,
        "a picture as a texture",
    ),
    of(
        "checker",
        &[param("a"), param("b"), optional("scale")],
        texture::checker,
        "squares of two colours, numbers or textures",
    ),
    of(
        "normal_map",
        &[
            param("file"),
            optional("strength"),
            words("wrap", WRAPS),
            optional("scale"),
            optional("offset"),
            optional("rotation"),
            words("filter", FILTERS),
        ],
        texture::normal_map,
        "turns the normal by a picture",
    ),
    of("node", &[param("model"), param("path")], |call| call.node(), "a node in a model: `node(robot, \"Arm/Hand\")`"),
];
