//! What can be said: every kind with its properties, their types, defaults and ranges, as one table of data that the
//! checker, completion, hover and the documentation read.
//!
//! ```
//! use kinora_lang::schema::{self, Default};
//!
//! let radius = schema::kind("sphere").unwrap().property("radius").unwrap();
//! assert_eq!((radius.default, radius.animatable), (Default::Number(1.0), true));
//! ```

mod describe;
mod kinds;
mod types;

pub use kinds::{KINDS, MIX};
pub use types::{TYPES, TypeName, type_name};

use std::sync::LazyLock;

use rustc_hash::FxHashMap;

use crate::dimension::Dimension;

/// A kind of node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// As written: `sphere`.
    pub name: &'static str,
    /// What it can be used as.
    pub sort: Sort,
    /// Where it may stand.
    pub place: Place,
    /// Whether nodes may be written inside it.
    pub holds: Holds,
    /// Its properties, in tables that several kinds share.
    pub properties: &'static [&'static [Property]],
    /// Whether it works now.
    pub since: Since,
    /// One line.
    pub doc: &'static str,
}

/// What a node can be used as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Sort {
    Render,
    Camera,
    Sky,
    Light,
    Material,
    Shape,
    Group,
    Simulation,
    Joint,
    Part,
}

impl Sort {
    /// As a message names it.
    pub fn with_article(self) -> &'static str {
        match self {
            Sort::Render => "a `render` block",
            Sort::Camera => "a camera",
            Sort::Sky => "a sky",
            Sort::Light => "a light",
            Sort::Material => "a material",
            Sort::Shape => "a shape",
            Sort::Group => "a group",
            Sort::Simulation => "a simulation",
            Sort::Joint => "a joint",
            Sort::Part => "a part of another node",
        }
    }

    /// Whether it has a place in space that others can look at or move with.
    pub fn is_placed(self) -> bool {
        matches!(self, Sort::Shape | Sort::Group)
    }
}

/// Where a kind may stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Only at the top level of a file.
    Top,
    /// At the top level, in groups, prefabs and loops.
    Scene,
    /// Only inside nodes of these kinds; an empty list stands for every shape and for groups.
    Inside(&'static [&'static str]),
}

/// What may be written inside a node besides properties.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Holds {
    /// Nothing.
    Nothing,
    /// Kinds whose place is inside it.
    Parts,
    /// Everything that may stand in a scene.
    Scene,
}

/// Whether the program can do it already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Since {
    /// It works.
    Now,
    /// It is answered with "not yet".
    Later,
    /// Only the default works; every other value is answered with "not yet".
    Default,
}

/// One property of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Property {
    /// As written: `radius`.
    pub name: &'static str,
    /// What it takes.
    pub ty: Type,
    /// Its value where it is not set.
    pub default: Default,
    /// Which values are allowed.
    pub check: Check,
    /// Whether it may change over time.
    pub animatable: bool,
    /// Whether it may be a texture.
    pub varies: bool,
    /// Whether it works now.
    pub since: Since,
    /// One line.
    pub doc: &'static str,
}

/// What a property takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Type {
    /// A number of this dimension in SI; whether a bare number will do.
    Number(Dimension, Bare),
    /// A whole number.
    Count,
    /// `true` or `false`.
    Bool,
    /// Text.
    Text,
    /// A colour.
    Color,
    /// Two numbers of this dimension.
    Vec2(Dimension, Bare),
    /// Three numbers of this dimension.
    Vec3(Dimension, Bare),
    /// One factor, or three.
    Scale,
    /// A rotation.
    Rotation,
    /// One of these words.
    Choice(&'static [Choice]),
    /// Two whole numbers.
    Counts,
    /// A node that can be used so.
    Node(Sort),
    /// A node with a place in space.
    Placed,
    /// A point, or a node with a place in space.
    Target,
    /// A normal map.
    NormalMap,
    /// A list of points.
    Points,
    /// A list of pairs of numbers.
    Pairs,
    /// A list of whole numbers.
    Indices,
    /// A range of angles or lengths; which of the two, another property says.
    Limits,
    /// An angular speed or a speed; which of the two, another property says.
    Drive,
}

/// Whether a number without a unit is taken as SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bare {
    /// Yes.
    Allowed,
    /// No: E0304. A 0 is always allowed.
    Refused,
}

/// A word that a property takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// As written.
    pub name: &'static str,
    /// Whether it works now.
    pub since: Since,
}

/// The value of a property that is not set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Default {
    /// Computed from the rest, or absent.
    Computed,
    /// There is none: the property is needed.
    Needed,
    /// A number in SI; the same in every component of a vector or colour.
    Number(f64),
    /// Three numbers in SI.
    Three([f64; 3]),
    /// Two numbers in SI.
    Two([f64; 2]),
    /// A truth value.
    Bool(bool),
    /// A word.
    Word(&'static str),
    /// No turn.
    Identity,
}

/// Which values are allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Check {
    /// All finite ones.
    Any,
    /// Above 0 in every component: E0401.
    Above0,
    /// 0 or more in every component: E0401.
    AtLeast0,
    /// Whole numbers within: E0401.
    Within(i64, i64),
    /// Above 0: E0901.
    Mass,
    /// 0..1: E0407.
    Ratio,
    /// Every channel within 0..1: E0407 above, E0401 below.
    Reflectance,
    /// No component 0: E0404.
    NotZero,
    /// 1 or more: E0406.
    Ior,
    /// Above 0deg, at most 360deg: E0408. What else holds for a projection is the camera's own check.
    Fov,
    /// 0, or 3..65535: E0401.
    Blades,
    /// 0deg..360deg: E0401.
    Shutter,
    /// 0deg or more, below 180deg: E0401.
    Disc,
    /// Above 0deg, at most 360deg: E0401.
    Cone,
    /// 1..16384 each: E0411.
    Resolution,
    /// Not the zero vector: E0405.
    Direction,
    /// The symbol of a metal that was measured: E0203.
    Spectrum,
}

impl Kind {
    /// All properties, in the table's order.
    pub fn all(&self) -> impl Iterator<Item = &'static Property> + use<> {
        self.properties.iter().flat_map(|table| table.iter())
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.properties.iter().map(|table| table.len()).sum()
    }

    /// The property of that name.
    pub fn property(&self, name: &str) -> Option<&'static Property> {
        self.all().find(|property| property.name == name)
    }
}

/// The kind of that name.
pub fn kind(name: &str) -> Option<&'static Kind> {
    static TABLE: LazyLock<FxHashMap<&str, &Kind>> =
        LazyLock::new(|| KINDS.iter().map(|kind| (kind.name, kind)).collect());
    TABLE.get(name).or_else(|| TABLE.get(current(name)?)).copied()
}

/// Names of kinds that this version still understands and the next one will not, with the names that they have now.
pub const DEPRECATED: &[(&str, &str)] = &[("ggx", "metal")];

/// What a deprecated name of a kind is called now.
pub fn current(name: &str) -> Option<&'static str> {
    DEPRECATED.iter().find(|(old, _)| *old == name).map(|(_, new)| *new)
}

impl Type {
    /// As a message names it: "a length", "one of `a` or `b`".
    pub fn with_article(&self) -> String {
        match self {
            Type::Number(dimension, _) => dimension.with_article(),
            Type::Count => "a whole number".into(),
            Type::Bool => "true or false".into(),
            Type::Text => "text".into(),
            Type::Color => "a colour".into(),
            Type::Vec2(..) => "a vector of 2 components".into(),
            Type::Vec3(..) => "a vector of 3 components".into(),
            Type::Scale => "a number or a vector of 3 components".into(),
            Type::Rotation => "a rotation".into(),
            Type::Choice(choices) => crate::suggest::any_of(choices.iter().map(|choice| choice.name)),
            Type::Counts => "a pair of whole numbers".into(),
            Type::Node(sort) => sort.with_article().into(),
            Type::Placed => "a shape or a group".into(),
            Type::Target => "a point or a node".into(),
            Type::NormalMap => "a normal map".into(),
            Type::Points => "a list of points".into(),
            Type::Pairs => "a list of pairs".into(),
            Type::Indices => "a list of whole numbers".into(),
            Type::Limits => "a range of angles or lengths".into(),
            Type::Drive => "an angular speed or a speed".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_defaults_fit() {
        for (i, kind) in KINDS.iter().enumerate() {
            assert!(KINDS[..i].iter().all(|other| other.name != kind.name), "{}", kind.name);
            let properties: Vec<_> = kind.all().collect();
            for (i, property) in properties.iter().enumerate() {
                let place = format!("{}.{}", kind.name, property.name);
                assert!(properties[..i].iter().all(|other| other.name != property.name), "{place}");
                assert!(!property.doc.is_empty(), "{place}");
                let fits = match (property.default, property.ty) {
                    (Default::Computed | Default::Needed, _) => true,
                    (Default::Number(_), Type::Number(..) | Type::Count | Type::Color | Type::Scale) => true,
                    (Default::Number(_), Type::Vec3(..) | Type::Vec2(..) | Type::Target) => true,
                    (Default::Three(_), Type::Vec3(..) | Type::Target) => true,
                    (Default::Two(_), Type::Vec2(..) | Type::Counts) => true,
                    (Default::Bool(_), Type::Bool) => true,
                    (Default::Word(word), Type::Choice(choices)) => choices.iter().any(|choice| choice.name == word),
                    (Default::Identity, Type::Rotation) => true,
                    _ => false,
                };
                assert!(fits, "{place}");
                let only_default = property.since == Since::Default;
                assert!(!only_default || !matches!(property.default, Default::Computed | Default::Needed), "{place}");
            }
        }
    }

    #[test]
    fn kinds_of_the_vocabulary() {
        let names = "render camera sky sun point_light spot_light diffuse metal dielectric glossy emitter sphere box quad \
             disk plane cylinder cone capsule torus mesh model group instance simulation rigid_body joint cloth \
             override denoise fluid forces sheen";
        for name in names.split_whitespace() {
            assert!(kind(name).is_some(), "{name}");
        }
        assert_eq!(KINDS.len(), names.split_whitespace().count());
    }
}
