//! What a glTF document may say: glTF 2.0 and the extensions that are read, as tables, and the check against them.

use std::collections::HashSet;

use serde_json::{Map, Value};

use super::json::{escape, index, list, whole};
use super::{Fault, Faults};

/// What a property is.
pub enum Kind {
    /// `true` or `false`.
    Bool,
    /// Text.
    Text,
    /// The index of an object in this array of the root.
    Index(&'static str),
    /// A whole number within.
    Whole(u64, u64),
    /// A number within.
    Number(f64, f64),
    /// A number above.
    Above(f64),
    /// As many numbers, within.
    Numbers(usize, usize, f64, f64),
    /// An object of these properties.
    Object(&'static [Row]),
    /// One or more.
    List(&'static Kind),
    /// One or more different indices into this array of the root.
    Indices(&'static str),
    /// One or more different texts.
    Names,
    /// One or more names with accessors.
    Attributes,
}

/// A property.
pub struct Row(&'static str, Kind, bool);

const fn may(name: &'static str, kind: Kind) -> Row {
    Row(name, kind, false)
}

const fn must(name: &'static str, kind: Kind) -> Row {
    Row(name, kind, true)
}

const MAX: f64 = f64::MAX;
const ANY: Kind = Kind::Number(-MAX, MAX);
const RATIO: Kind = Kind::Number(0.0, 1.0);
const SOME: Kind = Kind::Number(0.0, MAX);
const COUNT: Kind = Kind::Whole(1, u64::MAX);
const OFFSET: Kind = Kind::Whole(0, u64::MAX);
const CODE: Kind = Kind::Whole(0, u64::MAX);

const fn vector(count: usize) -> Kind {
    Kind::Numbers(count, count, -MAX, MAX)
}

const fn ratios(count: usize) -> Kind {
    Kind::Numbers(count, count, 0.0, 1.0)
}

pub static ROOT: &[Row] = &[
    must("asset", Kind::Object(ASSET)),
    may("extensionsUsed", Kind::Names),
    may("extensionsRequired", Kind::Names),
    may("accessors", Kind::List(&Kind::Object(ACCESSOR))),
    may("animations", Kind::List(&Kind::Object(ANIMATION))),
    may(
        "buffers",
        Kind::List(&Kind::Object(&[may("uri", Kind::Text), must("byteLength", COUNT), may("name", Kind::Text)])),
    ),
    may("bufferViews", Kind::List(&Kind::Object(BUFFER_VIEW))),
    may("cameras", Kind::List(&Kind::Object(CAMERA))),
    may("images", Kind::List(&Kind::Object(IMAGE))),
    may("materials", Kind::List(&Kind::Object(MATERIAL))),
    may("meshes", Kind::List(&Kind::Object(MESH))),
    may("nodes", Kind::List(&Kind::Object(NODE))),
    may("samplers", Kind::List(&Kind::Object(SAMPLER))),
    may("scene", Kind::Index("scenes")),
    may("scenes", Kind::List(&Kind::Object(&[may("nodes", Kind::Indices("nodes")), may("name", Kind::Text)]))),
    may("skins", Kind::List(&Kind::Object(SKIN))),
    may(
        "textures",
        Kind::List(&Kind::Object(&[
            may("sampler", Kind::Index("samplers")),
            may("source", Kind::Index("images")),
            may("name", Kind::Text),
        ])),
    ),
];

static ASSET: &[Row] = &[
    must("version", Kind::Text),
    may("minVersion", Kind::Text),
    may("generator", Kind::Text),
    may("copyright", Kind::Text),
];

static ACCESSOR: &[Row] = &[
    may("bufferView", Kind::Index("bufferViews")),
    may("byteOffset", OFFSET),
    must("componentType", CODE),
    may("normalized", Kind::Bool),
    must("count", COUNT),
    must("type", Kind::Text),
    may("max", Kind::Numbers(1, 16, -MAX, MAX)),
    may("min", Kind::Numbers(1, 16, -MAX, MAX)),
    may("name", Kind::Text),
    may(
        "sparse",
        Kind::Object(&[
            must("count", COUNT),
            must(
                "indices",
                Kind::Object(&[
                    must("bufferView", Kind::Index("bufferViews")),
                    may("byteOffset", OFFSET),
                    must("componentType", CODE),
                ]),
            ),
            must("values", Kind::Object(&[must("bufferView", Kind::Index("bufferViews")), may("byteOffset", OFFSET)])),
        ]),
    ),
];

static ANIMATION: &[Row] = &[
    must(
        "channels",
        Kind::List(&Kind::Object(&[
            must("sampler", Kind::Whole(0, u64::MAX)),
            must("target", Kind::Object(&[may("node", Kind::Index("nodes")), must("path", Kind::Text)])),
        ])),
    ),
    must(
        "samplers",
        Kind::List(&Kind::Object(&[
            must("input", Kind::Index("accessors")),
            must("output", Kind::Index("accessors")),
            may("interpolation", Kind::Text),
        ])),
    ),
    may("name", Kind::Text),
];

static BUFFER_VIEW: &[Row] = &[
    must("buffer", Kind::Index("buffers")),
    may("byteOffset", OFFSET),
    must("byteLength", COUNT),
    may("byteStride", Kind::Whole(4, 252)),
    may("target", CODE),
    may("name", Kind::Text),
];

static CAMERA: &[Row] = &[
    must("type", Kind::Text),
    may(
        "perspective",
        Kind::Object(&[
            may("aspectRatio", Kind::Above(0.0)),
            must("yfov", Kind::Above(0.0)),
            may("zfar", Kind::Above(0.0)),
            must("znear", Kind::Above(0.0)),
        ]),
    ),
    may(
        "orthographic",
        Kind::Object(&[must("xmag", ANY), must("ymag", ANY), must("zfar", Kind::Above(0.0)), must("znear", SOME)]),
    ),
    may("name", Kind::Text),
];

static IMAGE: &[Row] = &[
    may("uri", Kind::Text),
    may("mimeType", Kind::Text),
    may("bufferView", Kind::Index("bufferViews")),
    may("name", Kind::Text),
];

macro_rules! texture {
    () => {
        Kind::Object(&[must("index", Kind::Index("textures")), may("texCoord", CODE)])
    };
}

macro_rules! normal {
    () => {
        Kind::Object(&[must("index", Kind::Index("textures")), may("texCoord", CODE), may("scale", ANY)])
    };
}

static MATERIAL: &[Row] = &[
    may(
        "pbrMetallicRoughness",
        Kind::Object(&[
            may("baseColorFactor", ratios(4)),
            may("baseColorTexture", texture!()),
            may("metallicFactor", RATIO),
            may("roughnessFactor", RATIO),
            may("metallicRoughnessTexture", texture!()),
        ]),
    ),
    may("normalTexture", normal!()),
    may(
        "occlusionTexture",
        Kind::Object(&[must("index", Kind::Index("textures")), may("texCoord", CODE), may("strength", RATIO)]),
    ),
    may("emissiveTexture", texture!()),
    may("emissiveFactor", ratios(3)),
    may("alphaMode", Kind::Text),
    may("alphaCutoff", SOME),
    may("doubleSided", Kind::Bool),
    may("name", Kind::Text),
];

static MESH: &[Row] = &[
    must(
        "primitives",
        Kind::List(&Kind::Object(&[
            must("attributes", Kind::Attributes),
            may("indices", Kind::Index("accessors")),
            may("material", Kind::Index("materials")),
            may("mode", CODE),
            may("targets", Kind::List(&Kind::Attributes)),
        ])),
    ),
    may("weights", Kind::Numbers(1, usize::MAX, -MAX, MAX)),
    may("name", Kind::Text),
];

static NODE: &[Row] = &[
    may("camera", Kind::Index("cameras")),
    may("children", Kind::Indices("nodes")),
    may("skin", Kind::Index("skins")),
    may("matrix", vector(16)),
    may("mesh", Kind::Index("meshes")),
    may("rotation", Kind::Numbers(4, 4, -1.0, 1.0)),
    may("scale", vector(3)),
    may("translation", vector(3)),
    may("weights", Kind::Numbers(1, usize::MAX, -MAX, MAX)),
    may("name", Kind::Text),
];

static SAMPLER: &[Row] =
    &[may("magFilter", CODE), may("minFilter", CODE), may("wrapS", CODE), may("wrapT", CODE), may("name", Kind::Text)];

static SKIN: &[Row] = &[
    may("inverseBindMatrices", Kind::Index("accessors")),
    may("skeleton", Kind::Index("nodes")),
    must("joints", Kind::Indices("nodes")),
    may("name", Kind::Text),
];

/// The extensions that are read.
static EXTENSIONS: &[(&str, &[Row])] = &[
    (
        "KHR_texture_transform",
        &[may("offset", vector(2)), may("rotation", ANY), may("scale", vector(2)), may("texCoord", CODE)],
    ),
    ("KHR_lights_punctual", &[may("lights", Kind::List(&Kind::Object(LIGHT))), may("light", CODE)]),
    ("KHR_materials_transmission", &[may("transmissionFactor", RATIO), may("transmissionTexture", texture!())]),
    ("KHR_materials_ior", &[may("ior", SOME)]),
    (
        "KHR_materials_volume",
        &[
            may("thicknessFactor", SOME),
            may("thicknessTexture", texture!()),
            may("attenuationDistance", Kind::Above(0.0)),
            may("attenuationColor", ratios(3)),
        ],
    ),
    (
        "KHR_materials_specular",
        &[
            may("specularFactor", RATIO),
            may("specularTexture", texture!()),
            may("specularColorFactor", Kind::Numbers(3, 3, 0.0, MAX)),
            may("specularColorTexture", texture!()),
        ],
    ),
    (
        "KHR_materials_clearcoat",
        &[
            may("clearcoatFactor", RATIO),
            may("clearcoatTexture", texture!()),
            may("clearcoatRoughnessFactor", RATIO),
            may("clearcoatRoughnessTexture", texture!()),
            may("clearcoatNormalTexture", normal!()),
        ],
    ),
    (
        "KHR_materials_sheen",
        &[
            may("sheenColorFactor", ratios(3)),
            may("sheenColorTexture", texture!()),
            may("sheenRoughnessFactor", RATIO),
            may("sheenRoughnessTexture", texture!()),
        ],
    ),
    ("KHR_materials_emissive_strength", &[may("emissiveStrength", SOME)]),
    (
        "KHR_materials_anisotropy",
        &[may("anisotropyStrength", RATIO), may("anisotropyRotation", ANY), may("anisotropyTexture", texture!())],
    ),
    ("KHR_materials_unlit", &[]),
    ("KHR_mesh_quantization", &[]),
    ("EXT_texture_webp", &[must("source", Kind::Index("images"))]),
];

static LIGHT: &[Row] = &[
    must("type", Kind::Text),
    may("color", Kind::Numbers(3, 3, 0.0, MAX)),
    may("intensity", SOME),
    may("range", Kind::Above(0.0)),
    may(
        "spot",
        Kind::Object(&[
            may("innerConeAngle", Kind::Number(0.0, std::f64::consts::FRAC_PI_2)),
            may("outerConeAngle", Kind::Number(0.0, std::f64::consts::FRAC_PI_2)),
        ]),
    ),
    may("name", Kind::Text),
];

/// Whether the extension is read.
pub fn is_known(extension: &str) -> bool {
    EXTENSIONS.iter().any(|(name, _)| *name == extension)
}

/// Checks the whole document against the tables.
pub fn check(root: &Value, faults: &mut Faults) {
    let used: HashSet<&str> = list(root, "extensionsUsed").iter().filter_map(Value::as_str).collect();
    let mut check = Check { root, used, faults };
    check.object(root, ROOT, "");
}

struct Check<'c> {
    root: &'c Value,
    used: HashSet<&'c str>,
    faults: &'c mut Faults,
}

impl Check<'_> {
    fn report(&mut self, at: &str, message: impl Into<String>) {
        self.faults.push(Fault::new(
            at,
            message,
            "export the model again, or check it with the Khronos glTF validator",
        ));
    }

    fn object(&mut self, value: &Value, rows: &[Row], at: &str) {
        let Some(map) = self.map(value, at) else { return };
        for Row(name, kind, needed) in rows {
            match map.get(*name) {
                Some(value) => self.value(value, kind, &format!("{at}/{name}")),
                None if *needed => self.report(at, format!("`{name}` is missing")),
                None => {}
            }
        }
        if let Some(extensions) = map.get("extensions") {
            let at = format!("{at}/extensions");
            let Some(extensions) = self.map(extensions, &at) else { return };
            for (name, value) in extensions {
                let at = format!("{at}/{}", escape(name));
                if !self.used.contains(name.as_str()) {
                    self.report(&at, format!("the extension `{name}` is not named in `extensionsUsed`"));
                }
                let rows = EXTENSIONS.iter().find(|(known, _)| known == name).map_or(&[][..], |(_, rows)| *rows);
                self.object(value, rows, &at);
            }
        }
    }

    fn map<'v>(&mut self, value: &'v Value, at: &str) -> Option<&'v Map<String, Value>> {
        let map = value.as_object();
        if map.is_none() {
            self.report(at, format!("an object is expected, found {}", what(value)));
        }
        map
    }

    fn array<'v>(&mut self, value: &'v Value, at: &str) -> &'v [Value] {
        match value.as_array() {
            Some(items) => {
                if items.is_empty() {
                    self.report(at, "the array is empty; one without items is left out");
                }
                items
            }
            None => {
                self.report(at, format!("an array is expected, found {}", what(value)));
                &[]
            }
        }
    }

    fn reference(&mut self, value: &Value, array: &str, at: &str) {
        let count = self.root.get(array).and_then(Value::as_array).map_or(0, Vec::len);
        match whole(value) {
            None => self.report(at, format!("an index is expected, found {}", what(value))),
            Some(index) if index >= count as u64 => {
                self.report(at, format!("index {index}, and `{array}` has {count}"));
            }
            Some(_) => {}
        }
    }

    fn number(&mut self, value: &Value, from: f64, to: f64, at: &str) {
        match value.as_f64() {
            None => self.report(at, format!("a number is expected, found {}", what(value))),
            Some(number) if !(from..=to).contains(&number) => {
                let range = match (from > -MAX, to < MAX) {
                    (_, true) => format!("{from} to {to} is allowed"),
                    (true, false) => format!("{from} or more is allowed"),
                    _ => "it is too large".to_string(),
                };
                self.report(at, format!("{number} is out of range: {range}"));
            }
            Some(_) => {}
        }
    }

    fn value(&mut self, value: &Value, kind: &Kind, at: &str) {
        match kind {
            Kind::Bool => {
                if !value.is_boolean() {
                    self.report(at, format!("true or false is expected, found {}", what(value)));
                }
            }
            Kind::Text => {
                if !value.is_string() {
                    self.report(at, format!("text is expected, found {}", what(value)));
                }
            }
            Kind::Index(array) => self.reference(value, array, at),
            Kind::Whole(from, to) => match whole(value) {
                None => self.report(at, format!("a whole number of 0 or more is expected, found {}", what(value))),
                Some(number) if !(from..=to).contains(&&number) => {
                    let range = match *to {
                        u64::MAX => format!("{from} or more"),
                        _ => format!("{from} to {to}"),
                    };
                    self.report(at, format!("{number} is out of range: {range} is allowed"));
                }
                Some(_) => {}
            },
            Kind::Number(from, to) => self.number(value, *from, *to, at),
            Kind::Above(limit) => {
                self.number(value, -MAX, MAX, at);
                if value.as_f64().is_some_and(|number| number <= *limit) {
                    self.report(at, format!("must be above {limit}"));
                }
            }
            Kind::Numbers(least, most, from, to) => {
                let items = self.array(value, at);
                if !items.is_empty() && !(*least..=*most).contains(&items.len()) {
                    let wanted = if least == most { least.to_string() } else { format!("{least} to {most}") };
                    self.report(at, format!("{wanted} numbers are expected, found {}", items.len()));
                }
                for (i, item) in items.iter().enumerate() {
                    self.number(item, *from, *to, &format!("{at}/{i}"));
                }
            }
            Kind::Object(rows) => self.object(value, rows, at),
            Kind::List(kind) => {
                for (i, item) in self.array(value, at).iter().enumerate() {
                    self.value(item, kind, &format!("{at}/{i}"));
                }
            }
            Kind::Indices(array) => {
                let mut seen = HashSet::new();
                for (i, item) in self.array(value, at).iter().enumerate() {
                    let at = format!("{at}/{i}");
                    self.reference(item, array, &at);
                    if whole(item).is_some_and(|index| !seen.insert(index)) {
                        self.report(&at, "the same index is there twice");
                    }
                }
            }
            Kind::Names => {
                let mut seen = HashSet::new();
                for (i, item) in self.array(value, at).iter().enumerate() {
                    let at = format!("{at}/{i}");
                    match item.as_str() {
                        None => self.report(&at, format!("text is expected, found {}", what(item))),
                        Some(name) if !seen.insert(name) => self.report(&at, format!("`{name}` is there twice")),
                        Some(_) => {}
                    }
                }
            }
            Kind::Attributes => {
                let Some(map) = self.map(value, at) else { return };
                if map.is_empty() {
                    self.report(at, "there are no attributes");
                }
                for (name, accessor) in map {
                    self.reference(accessor, "accessors", &format!("{at}/{}", escape(name)));
                }
            }
        }
    }
}

/// A value as a message names it.
fn what(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "true or false",
        Value::Number(_) => "a number",
        Value::String(_) => "text",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}

/// Follows an index that the tables have checked.
pub fn follow<'v>(root: &'v Value, array: &str, object: &Value, name: &str) -> Option<(usize, &'v Value)> {
    let at = index(object, name)?;
    Some((at, list(root, array).get(at)?))
}
