//! Textures: what is known of them before any file is read.

use std::sync::Arc;

use kinora_scene::{Channel, ColorSpace, Tape, TexelFilter, Wrap};

use super::Call;
use super::math::try_arg;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::eval::graph::Scalar;
use crate::eval::surface;
use crate::schema::{Choice, Since};
use crate::source::Span;
use crate::value::Value;

/// A texture as the scene says it.
#[derive(Debug, Clone, PartialEq)]
pub enum Texture {
    /// A picture.
    Image(Picture),
    /// Squares.
    Checker {
        /// The square at uv (0, 0), and the others.
        squares: [Square; 2],
        /// Squares along u and v.
        scale: [f64; 2],
    },
    /// A colour or a number that is computed at every point.
    Tape(Tape),
    /// A picture of normals.
    Normal {
        /// The picture.
        picture: Picture,
        /// How much they are turned.
        strength: f64,
    },
}

/// A picture, and how it is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// As written.
    pub file: Arc<str>,
    /// The place that names it.
    pub span: Span,
    /// `space`, if set.
    pub space: Option<ColorSpace>,
    /// Outside of 0..1.
    pub wrap: Wrap,
    /// Between texels.
    pub filter: TexelFilter,
    /// Times uv.
    pub scale: [f64; 2],
    /// Added last.
    pub offset: [f64; 2],
    /// Radians.
    pub rotation: f64,
    /// `channel`, if set.
    pub channel: Option<Channel>,
    /// Where the numbers above change over time: scale, offset and rotation.
    pub moving: Option<Arc<Tape>>,
}

/// What a square of a checker is filled with, and the place that says so.
#[derive(Debug, Clone, PartialEq)]
pub struct Square {
    /// A colour, a number or a texture.
    pub value: Paint,
    /// Where.
    pub span: Span,
}

/// See [`Square`].
#[derive(Debug, Clone, PartialEq)]
pub enum Paint {
    /// Linear Rec. 709.
    Color([f64; 3]),
    /// A ratio.
    Number(f64),
    /// A texture inside.
    Texture(Arc<Texture>),
}

const fn word(name: &'static str) -> Choice {
    Choice { name, since: Since::Now }
}

pub(super) const SPACES: &[Choice] = &[word("srgb"), word("linear")];
pub(super) const WRAPS: &[Choice] = &[word("repeat"), word("mirror"), word("clamp")];
pub(super) const FILTERS: &[Choice] = &[word("linear"), word("nearest")];
pub(super) const CHANNELS: &[Choice] = &[word("r"), word("g"), word("b"), word("a")];

impl Texture {
    /// As a message names it.
    pub fn with_article(&self) -> &'static str {
        match self {
            Texture::Image(_) => "an image",
            Texture::Checker { .. } => "a checker",
            Texture::Tape(_) => "a value that differs from point to point",
            Texture::Normal { .. } => "a normal map",
        }
    }

    /// What is computed, if it is.
    pub fn tape(&self) -> Option<&Tape> {
        match self {
            Texture::Tape(tape) => Some(tape),
            _ => None,
        }
    }
}

impl Call<'_> {
    /// One of a parameter's words; none if it is not given.
    fn word(&mut self, index: usize) -> Option<Option<&'static str>> {
        match self.value(index) {
            None => Some(None),
            Some(Value::Word(word)) => Some(Some(word)),
            Some(other) => {
                let words = self.function.params.get(index).map_or(&[][..], |param| param.words);
                let list = crate::suggest::any_of(words.iter().map(|word| word.name));
                self.needs(&list, &other, self.place(index));
                None
            }
        }
    }

    /// These components, or one number for all of them; `default` if it is not given.
    fn pair(&mut self, index: usize, default: f64) -> Option<[Scalar; 2]> {
        let Some(value) = self.value(index) else { return Some([Scalar::Const(default); 2]) };
        let parts: Vec<Scalar> = match &value {
            Value::Number(number) if number.dimension.is_none() => vec![number.value; 2],
            _ => match value.numbers() {
                Some(numbers) if numbers.len() == 2 && numbers.iter().all(|number| number.dimension.is_none()) => {
                    numbers.iter().map(|number| number.value).collect()
                }
                _ => {
                    self.needs("a pair of plain numbers", &value, self.place(index));
                    return None;
                }
            },
        };
        <[Scalar; 2]>::try_from(parts).ok()
    }

    /// A pair that stands still.
    fn still_pair(&mut self, index: usize, default: f64) -> Option<[f64; 2]> {
        match self.pair(index, default)?.map(Scalar::constant) {
            [Some(x), Some(y)] => self.finite_pair(index, [x, y]),
            _ => {
                self.later(self.place(index));
                None
            }
        }
    }

    /// The numbers, if they stand still; 0 where they move, which is said at once where they do from point to point.
    fn known<const N: usize>(&mut self, index: usize, parts: [Scalar; N]) -> Option<[f64; N]> {
        if !self.graph.points(&parts).is_none() {
            self.later(self.place(index));
            return None;
        }
        let known = parts.map(|part| part.constant().unwrap_or(0.0));
        for pair in known.chunks(2) {
            self.finite_pair(index, [pair[0], pair[pair.len() - 1]])?;
        }
        Some(known)
    }

    fn finite_pair(&mut self, index: usize, pair: [f64; 2]) -> Option<[f64; 2]> {
        if pair.iter().all(|x| x.is_finite() && x.abs() <= 1e9) {
            return Some(pair);
        }
        let span = self.place(index);
        self.problems.push(Diagnostic::new("E0401", "a texture's coordinates must be within -1e9..1e9").primary(
            self.file,
            span,
            "too large",
        ));
        None
    }

    fn computed(&mut self, parts: &[Scalar], span: Span) -> Option<Arc<Texture>> {
        match surface::texture(self.graph, parts, self.file, span) {
            Ok(texture) => Some(texture),
            Err(diagnostic) => {
                self.problems.push(*diagnostic);
                None
            }
        }
    }

    fn file_name(&mut self) -> Option<(Arc<str>, Span)> {
        let span = self.place(0);
        match self.value(0)? {
            Value::Text(text) => Some((text, span)),
            other => {
                self.needs("the name of a file", &other, span);
                None
            }
        }
    }

    // What `image` and `normal_map` share, from parameter `first` on: wrap, scale, offset, rotation, filter.
    fn picture(&mut self, first: usize) -> Option<Picture> {
        let (file, span) = self.file_name()?;
        let wrap = match self.word(first)? {
            Some("mirror") => Wrap::Mirror,
            Some("clamp") => Wrap::Clamp,
            _ => Wrap::Repeat,
        };
        let scales = self.pair(first + 1, 1.0)?;
        let offsets = self.pair(first + 2, 0.0)?;
        let turn = match self.value(first + 3) {
            None => Scalar::Const(0.0),
            Some(_) => self.true_angle(first + 3)?,
        };
        let (scale, offset) = (self.known(first + 1, scales)?, self.known(first + 2, offsets)?);
        let [rotation] = self.known(first + 3, [turn])?;
        let all = [scales[0], scales[1], offsets[0], offsets[1], turn];
        let moves = all.iter().any(|part| part.constant().is_none());
        let moving = moves.then(|| Arc::new(self.graph.tape(&all)));
        let filter = match self.word(first + 4)? {
            Some("nearest") => TexelFilter::Nearest,
            _ => TexelFilter::Linear,
        };
        Some(Picture { file, span, space: None, wrap, filter, scale, offset, rotation, channel: None, moving })
    }
}

pub(super) fn image(call: &mut Call<'_>) -> Value {
    let mut picture = try_arg!(call.picture(2));
    picture.space = match try_arg!(call.word(1)) {
        Some("srgb") => Some(ColorSpace::Srgb),
        Some(_) => Some(ColorSpace::Linear),
        None => None,
    };
    picture.channel = match try_arg!(call.word(7)) {
        Some("r") => Some(Channel::R),
        Some("g") => Some(Channel::G),
        Some("b") => Some(Channel::B),
        Some(_) => Some(Channel::A),
        None => None,
    };
    Value::Texture(Arc::new(Texture::Image(picture)))
}

pub(super) fn normal_map(call: &mut Call<'_>) -> Value {
    let picture = try_arg!(call.picture(2));
    let strength = match call.value(1) {
        None => 1.0,
        Some(_) => match try_arg!(call.plain(1)).constant() {
            Some(strength) => try_arg!(call.finite_pair(1, [strength; 2]))[0],
            None => return call.later(call.place(1)),
        },
    };
    Value::Texture(Arc::new(Texture::Normal { picture, strength }))
}

pub(super) fn checker(call: &mut Call<'_>) -> Value {
    let scale = try_arg!(call.still_pair(2, 1.0));
    let mut squares = Vec::with_capacity(2);
    for index in 0..2 {
        let (value, span) = (try_arg!(call.value(index)), call.place(index));
        let value = match &value {
            Value::Color(parts) => match parts.map(|part| part.constant()) {
                [Some(r), Some(g), Some(b)] => Paint::Color([r, g, b]),
                _ => Paint::Texture(try_arg!(call.computed(parts, span))),
            },
            Value::Number(number) if number.dimension == Dimension::NONE => match number.value.constant() {
                Some(number) => Paint::Number(number),
                None => Paint::Texture(try_arg!(call.computed(&[number.value], span))),
            },
            Value::Texture(texture) if !matches!(**texture, Texture::Normal { .. }) => Paint::Texture(texture.clone()),
            other => {
                call.needs("a colour, a plain number or a texture", other, span);
                return Value::Error;
            }
        };
        squares.push(Square { value, span });
    }
    match <[Square; 2]>::try_from(squares) {
        Ok(squares) => Value::Texture(Arc::new(Texture::Checker { squares, scale })),
        Err(_) => Value::Error,
    }
}
