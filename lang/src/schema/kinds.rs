//! The table. One row a property, as in the vocabulary; a test there compares the two.

use super::Bare::{Allowed, Refused};
use super::{Bare, Check, Choice, Default, Holds, Kind, Place, Property, Since, Sort, Type};
use crate::dimension::Dimension;

const fn row(name: &'static str, ty: Type, default: Default, doc: &'static str) -> Property {
    Property { name, ty, default, check: Check::Any, animatable: false, varies: false, since: Since::Now, doc }
}

impl Property {
    const fn moving(self) -> Property {
        Property { animatable: true, ..self }
    }

    const fn varying(self) -> Property {
        Property { varies: true, ..self }
    }

    const fn check(self, check: Check) -> Property {
        Property { check, ..self }
    }

    const fn later(self) -> Property {
        Property { since: Since::Later, ..self }
    }

    const fn only_default(self) -> Property {
        Property { since: Since::Default, ..self }
    }
}

const fn now(name: &'static str) -> Choice {
    Choice { name, since: Since::Now }
}

const fn si(dimension: Dimension, bare: Bare) -> Type {
    Type::Number(dimension, bare)
}

const NUMBER: Type = si(Dimension::NONE, Allowed);
const LENGTH: Type = si(Dimension::LENGTH, Allowed);
const ANGLE: Type = si(Dimension::ANGLE, Refused);
const TIME: Type = si(Dimension::TIME, Refused);
const POWER: Type = si(Dimension::POWER, Refused);
const POINT: Type = Type::Vec3(Dimension::LENGTH, Allowed);
const VECTOR: Type = Type::Vec3(Dimension::NONE, Allowed);

const ZERO: Default = Default::Number(0.0);
const ONE: Default = Default::Number(1.0);
const UP: Default = Default::Three([0.0, 1.0, 0.0]);

const fn kind(name: &'static str, sort: Sort, properties: &'static [&'static [Property]], doc: &'static str) -> Kind {
    let place = match sort {
        Sort::Render | Sort::Simulation => Place::Top,
        _ => Place::Scene,
    };
    let holds = match sort {
        Sort::Group => Holds::Scene,
        Sort::Shape => Holds::Parts,
        _ => Holds::Nothing,
    };
    Kind { name, sort, place, holds, properties, since: Since::Now, doc }
}

impl Kind {
    const fn later(self) -> Kind {
        Kind { since: Since::Later, ..self }
    }

    const fn inside(self, kinds: &'static [&'static str]) -> Kind {
        Kind { place: Place::Inside(kinds), ..self }
    }
}

/// Every kind.
pub static KINDS: &[Kind] = &[
    kind("render", Sort::Render, &[RENDER], "how the picture is made; once per entry file"),
    kind("camera", Sort::Camera, &[CAMERA], "looks along its own -z, x to the right, y up"),
    kind("sky", Sort::Sky, &[SKY], "light from infinitely far away; at most one"),
    kind("sun", Sort::Light, &[SUN], "light from one direction"),
    kind("point_light", Sort::Light, &[POINT_LIGHT], "light from one point"),
    kind("spot_light", Sort::Light, &[POINT_LIGHT, SPOT_LIGHT], "light in a cone"),
    kind("diffuse", Sort::Material, &[DIFFUSE, MATERIAL], "a matt surface: energy-preserving Oren-Nayar"),
    kind("metal", Sort::Material, &[METAL, MATERIAL], "a GGX conductor"),
    kind("dielectric", Sort::Material, &[DIELECTRIC, MATERIAL], "glass, water"),
    kind("glossy", Sort::Material, &[GLOSSY, MATERIAL], "a GGX coat over a base"),
    kind("sheen", Sort::Material, &[SHEEN, MATERIAL], "fibres over a base: velvet, dust"),
    kind("emitter", Sort::Material, &[EMITTER, MATERIAL], "light from the outer side of a surface; reflects nothing"),
    kind("sphere", Sort::Shape, &[SPHERE, SHAPE], "all points one radius from its origin"),
    kind("box", Sort::Shape, &[BOX, SHAPE], "a box, centred on its origin"),
    kind("quad", Sort::Shape, &[QUAD, SHAPE], "a rectangle, centred on its origin"),
    kind("disk", Sort::Shape, &[DISK, SHAPE], "a disk, centred on its origin"),
    kind("plane", Sort::Shape, &[PLANE, SHAPE], "an infinite plane"),
    kind("cylinder", Sort::Shape, &[CYLINDER, SHAPE], "a cylinder along y"),
    kind("cone", Sort::Shape, &[CYLINDER, SHAPE], "a cone along y, its tip up"),
    kind("capsule", Sort::Shape, &[CAPSULE, SHAPE], "a cylinder along y with round ends"),
    kind("torus", Sort::Shape, &[TORUS, SHAPE], "a ring about y"),
    kind("mesh", Sort::Shape, &[MESH, SHAPE], "triangles, from a file or from lists"),
    kind("model", Sort::Shape, &[MODEL, SHAPE], "the whole scene of a file, with its materials, lights and cameras"),
    kind("group", Sort::Group, &[PLACING], "nodes that share a transform"),
    kind("instance", Sort::Shape, &[INSTANCE, SHAPE], "one more copy of a shape, with its geometry shared"),
    kind("simulation", Sort::Simulation, &[SIMULATION], "rigid bodies over time; at most one"),
    kind("rigid_body", Sort::Part, &[RIGID_BODY], "makes its shape, or all of its group, a body of the simulation")
        .inside(&[]),
    kind("joint", Sort::Joint, &[JOINT], "holds two bodies together"),
    kind("cloth", Sort::Part, &[CLOTH], "makes its shape a cloth").later().inside(&["quad", "mesh"]),
    kind("override", Sort::Part, &[OVERRIDE], "replaces a material of a model").inside(&["model"]),
    kind("denoise", Sort::Part, &[], "reserved").later().inside(&["render"]),
    kind("fluid", Sort::Simulation, &[], "reserved").later(),
    kind("forces", Sort::Simulation, &[], "reserved").later(),
];

const RENDER: &[Property] = &[
    row("resolution", Type::Counts, Default::Two([1280.0, 720.0]), "width, height in pixels").check(Check::Resolution),
    row("camera", Type::Node(Sort::Camera), Default::Computed, "which camera takes the picture"),
    row("samples", Type::Count, Default::Number(128.0), "samples a pixel").check(Check::Within(1, u32::MAX as i64)),
    row("adaptive", NUMBER, ZERO, "target relative error (standard error / mean of a pixel's luminance); 0 = off")
        .check(Check::AtLeast0),
    row("min_samples", Type::Count, Default::Number(16.0), "before a pixel may stop")
        .check(Check::Within(0, u32::MAX as i64)),
    row("max_bounces", Type::Count, Default::Number(8.0), "scatterings of one path: 0 = only emission seen directly")
        .check(Check::Within(0, 65_535)),
    row(
        "mis",
        Type::Choice(&[now("nee"), now("one_sample"), now("bsdf"), now("light")]),
        Default::Word("nee"),
        "how direct light is found; all have the same mean",
    ),
    row("light_probability", NUMBER, Default::Number(0.2), "of `mis: one_sample`: how often it is the light")
        .check(Check::Ratio),
    row("clamp", NUMBER, Default::Computed, "limit of a sample's weight; absent = unbiased").check(Check::Above0),
    row("roulette_from", Type::Count, Default::Number(4.0), "bounce from which Russian roulette may end a path")
        .check(Check::Within(0, u32::MAX as i64)),
    row(
        "filter",
        Type::Choice(&[now("box"), now("gaussian"), now("blackman_harris")]),
        Default::Word("blackman_harris"),
        "pixel filter",
    ),
    row("filter_width", NUMBER, Default::Computed, "full width in pixels: box 1, else 1.5").check(Check::Above0),
    row(
        "sampler",
        Type::Choice(&[now("sobol"), now("random")]),
        Default::Word("sobol"),
        "where random numbers come from",
    ),
    row("seed", Type::Count, ZERO, "another seed gives another noise").check(Check::Within(0, u32::MAX as i64)),
    row("exposure", NUMBER, ZERO, "stops: linear * 2^exposure before the tone curve").moving(),
    row(
        "tonemap",
        Type::Choice(&[now("agx"), now("aces"), now("reinhard"), now("none")]),
        Default::Word("agx"),
        "tone curve of PNG, JPEG and the viewer",
    ),
    row(
        "background",
        Type::Choice(&[now("sky"), now("transparent")]),
        Default::Word("sky"),
        "what is seen where nothing is hit; `transparent` is alpha 0",
    ),
    row(
        "view",
        Type::Choice(&[
            now("beauty"),
            now("albedo"),
            now("normal"),
            now("depth"),
            now("id"),
            now("samples"),
            now("cost"),
            now("bvh"),
        ]),
        Default::Word("beauty"),
        "what the picture shows",
    ),
    row("fps", NUMBER, Default::Number(24.0), "frames a second; frame n is at n / fps").check(Check::Above0),
    row("duration", TIME, ZERO, "length of the film: frames 0 up to duration times fps, which is left out")
        .check(Check::AtLeast0),
    row("shutter", ANGLE, ZERO, "how long the shutter is open; 360deg = the whole frame").check(Check::Shutter),
];

const CAMERA: &[Property] = &[
    row("position", POINT, ZERO, "where the eye is").moving(),
    row("look_at", Type::Target, Default::Computed, "the point or node it looks at").moving(),
    row("rotation", Type::Rotation, Default::Identity, "how it is turned, instead of `look_at`").moving(),
    row("up", VECTOR, UP, "what is up in the picture; with `look_at` only").check(Check::Direction).moving(),
    row("parent", Type::Placed, Default::Computed, "the node it moves with"),
    row(
        "projection",
        Type::Choice(&[now("perspective"), now("orthographic"), now("panorama"), now("fisheye")]),
        Default::Word("perspective"),
        "how the world falls on the picture",
    ),
    row("fov", ANGLE, Default::Number(40.0 * std::f64::consts::PI / 180.0), "field of view across the image's height")
        .check(Check::Fov)
        .moving(),
    row("height", LENGTH, Default::Computed, "metres across an orthographic picture's height").check(Check::Above0),
    row("aperture", LENGTH, ZERO, "diameter of the lens; 0 is a pinhole").check(Check::AtLeast0).moving(),
    row("focus", LENGTH, Default::Computed, "distance to the plane in focus").check(Check::Above0).moving(),
    row("blades", Type::Count, ZERO, "corners of the lens; 0 is round").check(Check::Blades),
    row("blade_rotation", ANGLE, ZERO, "first corner from +x, counter-clockwise in the picture"),
];

const SKY: &[Property] = &[
    row("color", Type::Color, ZERO, "radiance in every direction").check(Check::AtLeast0).moving(),
    row("strength", NUMBER, ONE, "scales the light").check(Check::AtLeast0).moving(),
    row("visible", Type::Bool, Default::Bool(true), "whether the camera itself sees it"),
    row("file", Type::Text, Default::Computed, "an equirectangular picture, HDR or EXR"),
    row("rotation", ANGLE, ZERO, "turns the picture about +y").moving(),
    row("model", Type::Choice(&[now("nishita")]), Default::Computed, "a computed sky"),
    row("sun_elevation", ANGLE, Default::Number(std::f64::consts::FRAC_PI_4), "of the sun above the horizon").moving(),
    row("sun_azimuth", ANGLE, ZERO, "of the sun, from -z towards +x").moving(),
    row("turbidity", NUMBER, ONE, "haze, as a multiple of what is in clear air").check(Check::AtLeast0).moving(),
];

const SUN: &[Property] = &[
    row("direction", VECTOR, Default::Three([0.0, -1.0, 0.0]), "in which its light travels")
        .check(Check::Direction)
        .moving(),
    row("angle", ANGLE, Default::Number(0.53 * std::f64::consts::PI / 180.0), "diameter of its disc")
        .check(Check::Disc),
    row("color", Type::Color, ONE, "scales its light").check(Check::AtLeast0),
    row("irradiance", si(Dimension::IRRADIANCE, Refused), ONE, "on a surface facing it")
        .check(Check::AtLeast0)
        .moving(),
];

const POINT_LIGHT: &[Property] = &[
    row("position", POINT, ZERO, "where it is").moving(),
    row("color", Type::Color, ONE, "scales its light").check(Check::AtLeast0),
    row("power", POWER, Default::Needed, "light sent in all directions").check(Check::AtLeast0).moving(),
    row("radius", LENGTH, ZERO, "above 0: a sphere").check(Check::AtLeast0),
];

const SPOT_LIGHT: &[Property] = &[
    row("look_at", Type::Target, Default::Computed, "the point or node it shines at").moving(),
    row("direction", VECTOR, Default::Computed, "in which it shines").check(Check::Direction).moving(),
    row("angle", ANGLE, Default::Number(std::f64::consts::FRAC_PI_4), "full cone").check(Check::Cone),
    row("blend", NUMBER, Default::Number(0.15), "soft part of the cone").check(Check::Ratio),
];

const MATERIAL: &[Property] = &[
    row("normal", Type::NormalMap, Default::Computed, "a normal map: `normal_map(..)`").varying(),
    row("opacity", NUMBER, ONE, "share of rays that meet it").check(Check::Ratio).moving().varying(),
    row("name", Type::Text, Default::Computed, "for imports").later(),
];

const DIFFUSE: &[Property] = &[
    row("color", Type::Color, Default::Number(0.8), "reflectance").check(Check::Reflectance).moving().varying(),
    row("roughness", NUMBER, ZERO, "0 is Lambert").check(Check::Ratio).moving().varying(),
    row(
        "model",
        Type::Choice(&[now("eon"), now("fon"), now("qon")]),
        Default::Word("eon"),
        "which formula of Oren-Nayar",
    ),
];

const METAL: &[Property] = &[
    row("color", Type::Color, Default::Number(0.9), "reflectance facing you")
        .check(Check::Reflectance)
        .moving()
        .varying(),
    row("edge_tint", Type::Color, ONE, "tint at 82deg").check(Check::Reflectance).moving().varying(),
    row(
        "spectrum",
        Type::Text,
        Default::Computed,
        "a measured metal by its symbol, \"Au\", instead of `color` and `edge_tint`",
    )
    .check(Check::Spectrum),
    row("roughness", NUMBER, Default::Number(0.2), "0 is a mirror; the facets' alpha is its square")
        .check(Check::Ratio)
        .moving()
        .varying(),
    row("anisotropy", NUMBER, ZERO, "stretched along the tangent").check(Check::Ratio).varying(),
    row("anisotropy_rotation", ANGLE, ZERO, "of the stretch from the tangent, counter-clockwise"),
    COMPENSATION,
];

const COMPENSATION: Property = row(
    "energy_compensation",
    Type::Bool,
    Default::Bool(true),
    "adds the light that is scattered more than once (Kulla-Conty)",
);

const DIELECTRIC: &[Property] = &[
    row("ior", NUMBER, Default::Number(1.5), "refractive index of the inside").check(Check::Ior).moving(),
    row("roughness", NUMBER, ZERO, "0 is clear; the facets' alpha is its square")
        .check(Check::Ratio)
        .moving()
        .varying(),
    COMPENSATION,
    row("attenuation_color", Type::Color, ONE, "colour of white light after `attenuation_distance`")
        .check(Check::Reflectance),
    row("attenuation_distance", LENGTH, Default::Number(f64::INFINITY), "path length of `attenuation_color`")
        .check(Check::Above0),
    row("thin", Type::Bool, Default::Bool(false), "a sheet without thickness"),
    row("priority", Type::Count, ZERO, "of nested media the higher wins")
        .check(Check::Within(i32::MIN as i64, i32::MAX as i64)),
];

const GLOSSY: &[Property] = &[
    row("base", Type::Node(Sort::Material), Default::Computed, "what is under the coat"),
    row("color", Type::Color, Default::Number(0.8), "of a Lambert base, instead of `base`")
        .check(Check::Reflectance)
        .moving()
        .varying(),
    row("ior", NUMBER, Default::Number(1.5), "of the coat").check(Check::Ior),
    row("tint", Type::Color, ONE, "of the coat's reflection straight on; it is white at grazing angles")
        .check(Check::Reflectance)
        .moving()
        .varying(),
    row("roughness", NUMBER, Default::Number(0.1), "of the coat").check(Check::Ratio).moving().varying(),
    row("metalness", NUMBER, ZERO, "share of a metal of the base's color").check(Check::Ratio).moving().varying(),
];

const SHEEN: &[Property] = &[
    row("base", Type::Node(Sort::Material), Default::Computed, "what is under the fibres"),
    row("color", Type::Color, ONE, "what the fibres reflect").check(Check::Reflectance).moving().varying(),
    row("roughness", NUMBER, Default::Number(0.3), "0 shines at the very edge only, 1 is dust")
        .check(Check::Ratio)
        .moving()
        .varying(),
];

/// What `mix(a, b, amount: ..)` makes of two materials; no block can be written of it.
pub static MIX: Kind = kind("mix", Sort::Material, &[MIXED], "two materials at once");

const MIXED: &[Property] = &[
    row("a", Type::Node(Sort::Material), Default::Needed, "the first material"),
    row("b", Type::Node(Sort::Material), Default::Needed, "the second material"),
    row("amount", NUMBER, Default::Needed, "the share of the second").check(Check::Ratio).moving().varying(),
];

const EMITTER: &[Property] = &[
    row("color", Type::Color, ONE, "scales the light; may exceed 1").check(Check::AtLeast0).moving().varying(),
    row("radiance", si(Dimension::RADIANCE, Refused), ONE, "light per area and solid angle")
        .check(Check::AtLeast0)
        .moving()
        .varying(),
    row("power", POWER, Default::Computed, "light of the whole surface, instead of `radiance`")
        .check(Check::AtLeast0)
        .moving(),
    row("two_sided", Type::Bool, Default::Bool(false), "whether the inner side shines too"),
];

const PLACING: &[Property] = &[
    row("position", POINT, ZERO, "where its origin is").moving(),
    row("rotation", Type::Rotation, Default::Identity, "how it is turned").moving(),
    row("scale", Type::Scale, ONE, "one factor, or one an axis").check(Check::NotZero).moving(),
    row("visible", Type::Bool, Default::Bool(true), "false: not there for any ray").moving(),
    row("parent", Type::Placed, Default::Computed, "the node it moves with"),
];

const SHAPE: &[Property] = &[
    PLACING[0],
    PLACING[1],
    PLACING[2],
    PLACING[3],
    PLACING[4],
    row("material", Type::Node(Sort::Material), Default::Computed, "its surface; `diffuse {}` without"),
];

const SPHERE: &[Property] =
    &[row("radius", LENGTH, ONE, "how far its surface is from its origin").check(Check::Above0).moving()];

const BOX: &[Property] = &[row("size", POINT, ONE, "lengths of its edges").check(Check::Above0)];

const QUAD: &[Property] = &[
    row("normal", VECTOR, UP, "the side it faces").check(Check::Direction),
    row("up", VECTOR, UP, "width runs along `up` x `normal`").check(Check::Direction),
    row("size", Type::Vec2(Dimension::LENGTH, Allowed), ONE, "width, height").check(Check::Above0),
    row("cells", Type::Counts, Default::Two([1.0, 1.0]), "how finely it is divided, for cloth").only_default(),
];

const DISK: &[Property] = &[
    row("normal", VECTOR, UP, "the side it faces").check(Check::Direction),
    row("radius", LENGTH, ONE, "its radius").check(Check::Above0),
];

const PLANE: &[Property] = &[
    row("normal", VECTOR, UP, "the side it faces").check(Check::Direction),
    row("up", VECTOR, UP, "u runs along `up` x `normal`").check(Check::Direction),
];

const CYLINDER: &[Property] = &[
    row("radius", LENGTH, Default::Number(0.5), "its radius").check(Check::Above0),
    row("height", LENGTH, ONE, "along y").check(Check::Above0),
    row("capped", Type::Bool, Default::Bool(true), "whether its ends are closed"),
];

const CAPSULE: &[Property] = &[
    row("radius", LENGTH, Default::Number(0.5), "its radius").check(Check::Above0),
    row("height", LENGTH, Default::Number(2.0), "along y, round ends included").check(Check::Above0),
    row("capped", Type::Bool, Default::Bool(true), "whether its round ends are there"),
];

const TORUS: &[Property] = &[
    row("radius", LENGTH, ONE, "to the centre of the ring").check(Check::Above0),
    row("tube", LENGTH, Default::Number(0.25), "radius of the tube").check(Check::Above0),
];

const MESH: &[Property] = &[
    row("file", Type::Text, Default::Computed, "an OBJ, PLY or STL file"),
    row("positions", Type::Points, Default::Computed, "vertices, instead of `file`"),
    row("indices", Type::Indices, Default::Computed, "three a triangle"),
    row("normals", Type::Points, Default::Computed, "one a vertex"),
    row("uvs", Type::Pairs, Default::Computed, "one a vertex"),
    row("smooth", Type::Bool, Default::Computed, "true makes normals by angle, false drops them; else the file's"),
    row("fit", LENGTH, Default::Computed, "centres it on its origin, the longest side so long").check(Check::Above0),
];

const MODEL: &[Property] = &[
    row("file", Type::Text, Default::Needed, "a glTF, GLB, OBJ, PLY or STL file"),
    row("clip", Type::Text, Default::Computed, "which of its animations plays; without, it rests"),
    row("clip_time", TIME, Default::Computed, "how far the clip has come; `time` without").moving(),
];

const INSTANCE: &[Property] = &[row("of", Type::Placed, Default::Needed, "what is shown once more")];

const SIMULATION: &[Property] = &[
    row("gravity", Type::Vec3(Dimension::ACCELERATION, Refused), Default::Three([0.0, -9.81, 0.0]), "pulls all bodies"),
    row("rate", si(Dimension::RATE, Refused), Default::Number(240.0), "steps a second").check(Check::Above0),
    row("duration", TIME, Default::Computed, "how long it runs; the duration of `render` where it is not set")
        .check(Check::AtLeast0),
    row("bake", Type::Text, Default::Computed, "where the result is kept: \"cache/NAME.bake\" where it is not set"),
];

const RIGID_BODY: &[Property] = &[
    row(
        "kind",
        Type::Choice(&[now("dynamic"), now("fixed"), now("kinematic")]),
        Default::Word("dynamic"),
        "what moves it: forces, nothing, or the keys of its shape",
    ),
    row("density", si(Dimension::DENSITY, Refused), Default::Number(1000.0), "mass per volume").check(Check::Mass),
    row("mass", si(Dimension::MASS, Refused), Default::Computed, "instead of `density`").check(Check::Mass),
    row("friction", NUMBER, Default::Number(0.5), "of its surface; a contact has the mean of two bodies")
        .check(Check::AtLeast0),
    row("restitution", NUMBER, ZERO, "how much it bounces; a contact has the mean of two bodies").check(Check::Ratio),
    row("velocity", Type::Vec3(Dimension::SPEED, Refused), ZERO, "at the start, in the world"),
    row("angular_velocity", Type::Vec3(Dimension::SPIN, Refused), ZERO, "at the start, about each axis of the world"),
    row("linear_damping", NUMBER, ZERO, "its velocity falls by exp(-damping * t)").check(Check::AtLeast0),
    row("angular_damping", NUMBER, ZERO, "its turning falls by exp(-damping * t)").check(Check::AtLeast0),
    row(
        "collider",
        Type::Choice(&[
            now("auto"),
            now("box"),
            now("sphere"),
            now("capsule"),
            now("cylinder"),
            now("convex_hull"),
            now("mesh"),
        ]),
        Default::Word("auto"),
        "the shape it collides with",
    ),
    row("impulse", Type::Vec3(Dimension::IMPULSE, Refused), ZERO, "a push at the centre of mass, in the world"),
    row("impulse_at", TIME, ZERO, "when it is pushed").check(Check::AtLeast0),
];

const JOINT: &[Property] = &[
    row(
        "kind",
        Type::Choice(&[now("fixed"), now("ball"), now("hinge"), now("slider"), now("spring")]),
        Default::Needed,
        "how the bodies may move",
    ),
    row("a", Type::Placed, Default::Needed, "one body"),
    row("b", Type::Placed, Default::Needed, "the other body"),
    row(
        "anchor",
        POINT,
        Default::Computed,
        "where they meet, in the world at 0s; the origin of `a` where it is not set",
    ),
    row("axis", VECTOR, Default::Computed, "what a hinge turns about and a slider slides along, in the world at 0s")
        .check(Check::Direction),
    row("limits", Type::Limits, Default::Computed, "how far `b` may turn or slide from where it is at 0s"),
    row("motor_velocity", Type::Drive, Default::Computed, "drives `b`, whatever it takes"),
    row("length", LENGTH, Default::Computed, "of a spring at rest; as it is at 0s where it is not set")
        .check(Check::AtLeast0),
    row("stiffness", si(Dimension::STIFFNESS, Refused), Default::Computed, "of a spring").check(Check::AtLeast0),
    row("damping", si(Dimension::DAMPING, Refused), ZERO, "of a spring").check(Check::AtLeast0),
];

const CLOTH: &[Property] = &[
    row("density", si(Dimension::AREA_DENSITY, Refused), Default::Number(0.2), "mass per area"),
    row("stretch", NUMBER, ZERO, "0..1, softness"),
    row("bend", NUMBER, Default::Number(0.5), "0..1, softness"),
    row("thickness", LENGTH, Default::Number(0.005), "of the cloth"),
    row("friction", NUMBER, Default::Number(0.5), "of its surface"),
    row("wind", Type::Vec3(Dimension::SPEED, Refused), ZERO, "blows on it"),
    row("pins", Type::Indices, Default::Computed, "vertices that do not move"),
];

const OVERRIDE: &[Property] = &[row("material", Type::Node(Sort::Material), Default::Needed, "instead of the model's")];
