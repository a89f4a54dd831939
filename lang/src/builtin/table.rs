//! The table of built-in functions.

use super::texture::{self, CHANNELS, FILTERS, SPACES, WRAPS};
use super::{Builtin, Call, Param, Topic, color, math, random, turn};
use crate::schema::Choice;
use crate::value::Value;

// What a parameter takes or a function gives, besides the types of the language.
const NUMBER: &str = "number";
const VECTOR: &str = "vector";
const ANGLE_OR_FLOAT: &str = "angle or float";
const SAME: &str = "the same";

const fn param(name: &'static str, takes: &'static str) -> Param {
    Param { name, takes, optional: false, words: &[] }
}

const fn optional(name: &'static str, takes: &'static str) -> Param {
    Param { name, takes, optional: true, words: &[] }
}

const fn words(name: &'static str, words: &'static [Choice]) -> Param {
    Param { name, takes: "word", optional: true, words }
}

const fn of(
    topic: Topic,
    name: &'static str,
    params: &'static [Param],
    gives: &'static str,
    run: fn(&mut Call<'_>) -> Value,
    doc: &'static str,
) -> Builtin {
    Builtin { topic, name, params, rest: None, gives, run, doc }
}

impl Builtin {
    /// Takes any number of arguments of this kind before its own, which are then given by name.
    const fn any(self, rest: &'static str) -> Builtin {
        Builtin { rest: Some(rest), ..self }
    }
}

const X: &[Param] = &[param("x", NUMBER)];
const FLOAT_X: &[Param] = &[param("x", "float")];
const PLACEWISE_X: &[Param] = &[param("x", "number or vector")];
const AB: &[Param] = &[param("a", NUMBER), param("b", NUMBER)];
const ANGLE: &[Param] = &[param("angle", "angle")];
const OF_ANGLE: &[Param] = &[param("angle", ANGLE_OR_FLOAT)];
const V: &[Param] = &[param("v", VECTOR)];
const VECTORS: &[Param] = &[param("a", VECTOR), param("b", VECTOR)];
const RGB: &[Param] = &[param("r", "float"), param("g", "float"), param("b", "float")];

use Topic::{Color, List, Node, Number, Random, Rotation, Texture, Vector};

/// Every built-in function, by topic.
pub static BUILTINS: &[Builtin] = &[
    of(Number, "abs", PLACEWISE_X, SAME, math::abs, "x without its sign"),
    of(Number, "sign", X, "int", math::sign, "-1, 0 or 1"),
    of(Number, "floor", FLOAT_X, "int", math::floor, "the whole number at or below x"),
    of(Number, "ceil", FLOAT_X, "int", math::ceil, "the whole number at or above x"),
    of(Number, "round", FLOAT_X, "int", math::round, "the nearest whole number, halves away from 0"),
    of(Number, "fract", FLOAT_X, "float", math::fract, "x - floor(x)"),
    of(Number, "mod", AB, SAME, math::modulo, "a - b floor(a / b): has the sign of b"),
    of(Number, "sqrt", X, NUMBER, math::sqrt, "the square root: of an area a length"),
    of(Number, "exp", FLOAT_X, "float", math::exp, "e to the power of x"),
    of(Number, "log", FLOAT_X, "float", math::log, "the natural logarithm"),
    of(Number, "sin", OF_ANGLE, "float", math::sin, "the sine; a plain number is in radians"),
    of(Number, "cos", OF_ANGLE, "float", math::cos, "the cosine"),
    of(Number, "tan", OF_ANGLE, "float", math::tan, "the tangent"),
    of(Number, "asin", FLOAT_X, "angle", math::asin, "the angle whose sine is x, -90deg..90deg"),
    of(Number, "acos", FLOAT_X, "angle", math::acos, "the angle whose cosine is x, 0deg..180deg"),
    of(Number, "atan", FLOAT_X, "angle", math::atan, "the angle whose tangent is x, -90deg..90deg"),
    of(
        Number,
        "atan2",
        &[param("y", NUMBER), param("x", NUMBER)],
        "angle",
        math::atan2,
        "the angle of the point (x, y), -180deg..180deg",
    ),
    of(Number, "turn", FLOAT_X, "angle", math::turn, "a share of a full turn as an angle: turn(0.5) is 180deg"),
    of(
        Number,
        "mix",
        &[param("a", "number, vector, color or material"), param("b", "as a"), param("amount", "float")],
        "as a",
        math::mix,
        "a (1 - amount) + b amount; colours in linear light",
    ),
    of(
        Number,
        "step",
        &[param("edge", NUMBER), param("x", NUMBER)],
        "float",
        math::step,
        "0 below the edge, 1 from it on",
    ),
    of(
        Number,
        "smoothstep",
        &[param("low", NUMBER), param("high", NUMBER), param("x", NUMBER)],
        "float",
        math::smoothstep,
        "0 to 1 between low and high, smooth at both ends: t t (3 - 2 t)",
    ),
    of(
        Number,
        "clamp",
        &[param("x", NUMBER), param("low", NUMBER), param("high", NUMBER)],
        SAME,
        math::clamp,
        "x, but not below low or above high",
    ),
    of(Number, "saturate", FLOAT_X, "float", math::saturate, "x, but not below 0 or above 1"),
    of(
        Number,
        "f_number",
        &[param("n", "float"), param("focal_length", "length")],
        "length",
        math::f_number,
        "the diameter of a lens, focal_length / n, for `aperture`",
    ),
    of(List, "min", &[], SAME, math::min, "the least of its arguments or of a list; of vectors, place by place")
        .any("numbers, vectors or list"),
    of(List, "max", &[], SAME, math::max, "the greatest of its arguments or of a list; of vectors, place by place")
        .any("numbers, vectors or list"),
    of(List, "sum", &[], SAME, math::sum, "the sum of its arguments or of a list; of an empty list 0")
        .any("numbers, vectors, colours or list"),
    of(List, "count", &[param("list", "list or range")], "int", math::count, "how many items a list or range has"),
    of(Vector, "length", V, NUMBER, math::length, "how long a vector is"),
    of(Vector, "normalize", V, VECTOR, math::normalize, "the vector of length 1 in the same direction"),
    of(Vector, "dot", VECTORS, NUMBER, math::dot, "the scalar product"),
    of(
        Vector,
        "cross",
        &[param("a", "vec3"), param("b", "vec3")],
        "vec3",
        math::cross,
        "the cross product: of x and y it is z",
    ),
    of(Vector, "distance", VECTORS, NUMBER, math::distance, "how far two points are apart"),
    of(Rotation, "rotate_x", ANGLE, "quat", turn::rotate_x, "a turn about x: 90deg takes y to z"),
    of(Rotation, "rotate_y", ANGLE, "quat", turn::rotate_y, "a turn about y: 90deg takes z to x"),
    of(Rotation, "rotate_z", ANGLE, "quat", turn::rotate_z, "a turn about z: 90deg takes x to y"),
    of(
        Rotation,
        "axis_angle",
        &[param("axis", "vec3"), param("angle", "angle")],
        "quat",
        turn::axis_angle,
        "a turn about an axis, counter-clockwise when it points at you",
    ),
    of(
        Rotation,
        "euler",
        &[param("x", "angle"), param("y", "angle"), param("z", "angle")],
        "quat",
        turn::euler,
        "turns about the fixed x, then y, then z",
    ),
    of(
        Rotation,
        "face_towards",
        &[param("direction", "vec3"), optional("up", "vec3")],
        "quat",
        turn::face_towards,
        "turns local +z to a direction; up is (0, 1, 0) if it is not given",
    ),
    of(
        Rotation,
        "look_at",
        &[param("from", "vec3"), param("to", "vec3"), optional("up", "vec3")],
        "quat",
        turn::look_at,
        "the rotation of a camera: turns local -z to the direction from `from` to `to`",
    ),
    of(Color, "srgb", RGB, "color", color::srgb, "a colour by channels as in a picture file, sRGB-encoded"),
    of(Color, "linear", RGB, "color", color::linear, "a colour by amounts of light, linear Rec. 709"),
    of(
        Color,
        "hsv",
        &[param("h", "angle"), param("s", "float"), param("v", "float")],
        "color",
        color::hsv,
        "a colour by hue, saturation and value, of sRGB-encoded channels",
    ),
    of(
        Color,
        "oklch",
        &[param("l", "float"), param("c", "float"), param("h", "angle")],
        "color",
        color::oklch,
        "a colour by OKLab's lightness, chroma and hue; what is below 0 is cut off",
    ),
    of(
        Color,
        "blackbody",
        &[param("temperature", "temperature")],
        "color",
        color::blackbody,
        "the colour of a glowing body, at luminance 1; from 500K",
    ),
    of(
        Random,
        "rand",
        &[optional("seed", "number, text, vector or list")],
        "float",
        random::rand,
        "a number in 0..1 that looks random and depends on its arguments only",
    )
    .any("numbers, texts, vectors or lists"),
    of(
        Random,
        "noise",
        &[param("p", "number or vector")],
        "float",
        random::noise,
        "Perlin's gradient noise in -1..1, 0 where all of p is whole",
    ),
    of(
        Random,
        "fbm",
        &[
            param("p", "number or vector"),
            optional("octaves", "int"),
            optional("gain", "float"),
            optional("lacunarity", "float"),
        ],
        "float",
        random::fbm,
        "noise of several sizes in -1..1 at a point",
    ),
    of(
        Random,
        "cell",
        &[param("p", "number or vector")],
        "float",
        random::cell,
        "how far the nearest of scattered points is, 0..1",
    ),
    of(
        Random,
        "cell_id",
        &[param("p", "number or vector")],
        "float",
        random::cell_id,
        "a number in 0..1 of the nearest of scattered points",
    ),
    of(
        Texture,
        "image",
        &[
            param("file", "string"),
            words("space", SPACES),
            words("wrap", WRAPS),
            optional("scale", "float or vec2"),
            optional("offset", "float or vec2"),
            optional("rotation", "angle"),
            words("filter", FILTERS),
            words("channel", CHANNELS),
        ],
        "texture",
        texture::image,
        "a picture, read at offset + rotation (scale uv)",
    ),
    of(
        Texture,
        "checker",
        &[
            param("a", "color, float or texture"),
            param("b", "color, float or texture"),
            optional("scale", "float or vec2"),
        ],
        "texture",
        texture::checker,
        "squares, `scale` of them along u and along v; the one at uv (0, 0) is a",
    ),
    of(
        Texture,
        "normal_map",
        &[
            param("file", "string"),
            optional("strength", "float"),
            words("wrap", WRAPS),
            optional("scale", "float or vec2"),
            optional("offset", "float or vec2"),
            optional("rotation", "angle"),
            words("filter", FILTERS),
        ],
        "normal map",
        texture::normal_map,
        "turns normals by a picture in tangent space, +y where v grows",
    ),
    of(
        Node,
        "node",
        &[param("model", "node"), param("path", "string")],
        "node",
        |call| call.node(),
        "a node in a model's file: `node(robot, \"Arm/Hand\")`",
    ),
];
