//! What an expression has as its value.

use std::sync::Arc;

use kinora_scene::{Ease, Outside};
use smallvec::SmallVec;

use crate::builtin::texture::Texture;
use crate::dimension::{self, Dimension};
use crate::eval::graph::Scalar;
use crate::source::Span;

/// A node of the evaluation, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// A number in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number {
    /// How much.
    pub value: Scalar,
    /// Of what.
    pub dimension: Dimension,
    /// Whether it is a whole number by its type: `3`, not `3.0`.
    pub int: bool,
}

impl Number {
    /// A number of this dimension.
    pub fn new(value: impl Into<Scalar>, dimension: Dimension) -> Number {
        Number { value: value.into(), dimension, int: false }
    }

    /// A whole number.
    pub fn int(value: f64) -> Number {
        Number { value: value.into(), dimension: Dimension::NONE, int: true }
    }

    /// Whether it is a 0 that fits any dimension.
    pub fn is_bare_zero(&self) -> bool {
        self.dimension.is_none() && self.value == Scalar::Const(0.0)
    }
}

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Reported already: nothing derived from it is reported again.
    Error,
    /// A number with its dimension.
    Number(Number),
    /// 1 or 0.
    Bool(Scalar),
    /// Text.
    Text(Arc<str>),
    /// Linear Rec. 709.
    Color([Scalar; 3]),
    /// A unit quaternion: x, y, z, w.
    Turn([Scalar; 4]),
    /// `(a, b)`: a vector, where all are numbers.
    Tuple(Arc<[Value]>),
    /// `[a, b]`
    List(Arc<[Value]>),
    /// `a..b`
    Range(Number, Number),
    /// A node.
    Node(NodeId),
    /// A node or a camera of a model's file, by its path there.
    Inner(NodeId, Arc<str>),
    /// A word that a property takes.
    Word(&'static str),
    /// What varies over a surface.
    Texture(Arc<Texture>),
    /// Keyframes, kept whole until something is computed with them.
    Keys(Arc<Keyed>),
}

/// The components of a vector.
pub type Numbers = SmallVec<[Number; 4]>;

/// Evaluated keyframes: at least one, of one type, by time.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyed {
    /// The keys.
    pub keys: Vec<KeyItem>,
    /// The curve through them.
    pub through: Through,
    /// What holds before the first and after the last.
    pub outside: Outside,
    /// Of colours: whether lightness, chroma and hue are interpolated, by OKLCh.
    pub oklch: bool,
}

/// The curve through keys.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Through {
    /// Straight from key to key.
    Straight,
    /// Without a corner.
    Spline,
    /// With the tangents that each key has.
    Tangents,
}

/// One evaluated keyframe.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyItem {
    /// Seconds.
    pub time_s: f64,
    /// The value.
    pub value: Value,
    /// How much it changes a second, coming and going; of a rotation, as quaternions. Level where it is not given.
    pub tangents: Option<Box<[Value; 2]>>,
    /// The way to this key.
    pub ease: Ease,
    /// The place of the value.
    pub span: Span,
}

impl Value {
    /// A plain number.
    pub fn number(value: impl Into<Scalar>) -> Value {
        Value::Number(Number::new(value, Dimension::NONE))
    }

    /// A number of this dimension.
    pub fn quantity(value: impl Into<Scalar>, dimension: Dimension) -> Value {
        Value::Number(Number::new(value, dimension))
    }

    /// A vector of numbers of one dimension.
    pub fn vector(parts: &[Scalar], dimension: Dimension) -> Value {
        Value::Tuple(parts.iter().map(|part| Value::quantity(*part, dimension)).collect())
    }

    /// Whether anything in it is an error.
    pub fn is_error(&self) -> bool {
        match self {
            Value::Error => true,
            Value::Tuple(items) => items.iter().any(Value::is_error),
            _ => false,
        }
    }

    /// How many single values it holds, counting no further than `most`; `None` where it is nested deeper than `depth`.
    pub fn size(&self, most: usize, depth: u32) -> Option<usize> {
        let (Value::Tuple(items) | Value::List(items)) = self else { return Some(1) };
        let depth = depth.checked_sub(1)?;
        let mut size = 1;
        for item in items.iter() {
            if size > most {
                break;
            }
            size += item.size(most - size.min(most), depth)?;
        }
        Some(size)
    }

    /// Whether it is the same at all times.
    pub fn is_constant(&self) -> bool {
        let all = |parts: &[Scalar]| parts.iter().all(|part| part.constant().is_some());
        match self {
            Value::Number(number) => all(&[number.value]),
            Value::Bool(part) => all(&[*part]),
            Value::Color(parts) => all(parts),
            Value::Turn(parts) => all(parts),
            Value::Tuple(items) | Value::List(items) => items.iter().all(Value::is_constant),
            Value::Range(from, to) => all(&[from.value, to.value]),
            Value::Keys(_) => false,
            Value::Error | Value::Text(_) | Value::Node(_) | Value::Inner(..) | Value::Word(_) | Value::Texture(_) => {
                true
            }
        }
    }

    /// Whether keys can hold it.
    pub fn is_key(&self) -> bool {
        match self {
            Value::Number(_) | Value::Bool(_) | Value::Color(_) | Value::Turn(_) => true,
            value => value.numbers().is_some(),
        }
    }

    /// The numbers of a vector.
    pub fn numbers(&self) -> Option<Numbers> {
        match self {
            Value::Tuple(items) => items
                .iter()
                .map(|item| match item {
                    Value::Number(number) => Some(*number),
                    _ => None,
                })
                .collect(),
            _ => None,
        }
    }

    /// As a message names it: "a length", "text". Nodes are named by the evaluator.
    pub fn with_article(&self) -> String {
        match self {
            Value::Error => "an error".into(),
            Value::Number(number) => number.dimension.with_article(),
            Value::Bool(_) => "true or false".into(),
            Value::Text(_) => "text".into(),
            Value::Color(_) => "a colour".into(),
            Value::Turn(_) => "a rotation".into(),
            Value::Tuple(_) if self.numbers().is_some() => "a vector".into(),
            Value::Tuple(_) => "a tuple".into(),
            Value::List(_) => "a list".into(),
            Value::Range(..) => "a range".into(),
            Value::Node(_) | Value::Inner(..) => "a node".into(),
            Value::Word(word) => format!("`{word}`"),
            Value::Texture(texture) => texture.with_article().into(),
            Value::Keys(keyed) => match keyed.keys.first() {
                Some(key) => key.value.with_article(),
                None => "keys".into(),
            },
        }
    }

    /// As a note shows it: `0.5m`, `(1, 2, 3)`.
    pub fn show(&self) -> String {
        let part = |part: &Scalar| part.constant().map_or("(moving)".to_string(), dimension::short);
        let parts = |parts: &[Scalar]| parts.iter().map(part).collect::<Vec<_>>().join(", ");
        match self {
            Value::Number(number) => match number.value.constant() {
                Some(value) => dimension::show(value, number.dimension),
                None => "(moving)".into(),
            },
            Value::Bool(value) => {
                value.constant().map_or("(moving)", |v| if v != 0.0 { "true" } else { "false" }).into()
            }
            Value::Text(text) => {
                let short: String = text.chars().take(40).collect();
                if short.len() < text.len() { format!("\"{short}…\"") } else { format!("\"{short}\"") }
            }
            Value::Color(channels) => format!("linear({})", parts(channels)),
            Value::Turn(q) => format!("quaternion ({})", parts(q)),
            Value::Tuple(items) => {
                let items: Vec<String> = items.iter().take(4).map(Value::show).collect();
                format!("({})", items.join(", "))
            }
            Value::List(items) => format!("a list of {}", items.len()),
            Value::Range(from, to) => format!("{}..{}", Value::Number(*from).show(), Value::Number(*to).show()),
            Value::Error => "an error".into(),
            Value::Node(_) => "a node".into(),
            Value::Inner(_, path) => format!("node \"{path}\""),
            Value::Word(word) => (*word).into(),
            Value::Texture(texture) => texture.with_article().into(),
            Value::Keys(_) => "keys".into(),
        }
    }
}
