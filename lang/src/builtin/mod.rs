//! The built-in functions, all pure: a table of names, parameters and what they compute.
//!
//! Numbers may move with time, so a function is written once over [`Scalar`]s and its constants fold.

pub mod color;
pub mod ease;
mod math;
mod random;
mod table;
pub mod texture;
pub mod turn;

pub use color::{linear_to_srgb, srgb_to_linear};
pub use table::BUILTINS;
pub use turn::{quaternion, turn_after, turned};

use std::sync::LazyLock;

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::eval::graph::{Graph, Scalar};
use crate::eval::surface::{Points, points};
use crate::schema::Choice;
use crate::source::{FileId, Span};
use crate::value::{Number, Value};

/// What a function is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Topic {
    Number,
    List,
    Vector,
    Rotation,
    Color,
    Random,
    Texture,
    Node,
}

/// A parameter of a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Param {
    /// As written in `name: value`.
    pub name: &'static str,
    /// What it takes: types of the language, or words like "vector".
    pub takes: &'static str,
    /// Whether it may be left out.
    pub optional: bool,
    /// The words that it takes instead of a value, if any.
    pub words: &'static [Choice],
}

/// A built-in function.
pub struct Builtin {
    /// What it is about.
    pub topic: Topic,
    /// As written.
    pub name: &'static str,
    /// Its parameters, in order.
    pub params: &'static [Param],
    /// What it takes any number of, if it does; `params` are then given by name.
    pub rest: Option<&'static str>,
    /// The type of the result.
    pub gives: &'static str,
    /// What it computes.
    pub run: fn(&mut Call<'_>) -> Value,
    /// One line.
    pub doc: &'static str,
}

impl Builtin {
    /// How many of the parameters are given by place.
    pub fn fixed(&self) -> usize {
        if self.rest.is_some() { 0 } else { self.params.len() }
    }

    /// `clamp(x, low, high)`
    pub fn signature(&self) -> String {
        let mut parts: Vec<String> = Vec::new();
        if self.rest.is_some() {
            parts.push("..".into());
        }
        parts.extend(self.params.iter().map(|param| match (param.optional, self.rest.is_some()) {
            (true, _) => format!("{}: ..", param.name),
            (false, _) => param.name.to_string(),
        }));
        format!("{}({})", self.name, parts.join(", "))
    }
}

/// The function of that name.
pub fn find(name: &str) -> Option<&'static Builtin> {
    static TABLE: LazyLock<FxHashMap<&str, &Builtin>> =
        LazyLock::new(|| BUILTINS.iter().map(|function| (function.name, function)).collect());
    TABLE.get(name).copied()
}

/// A call in progress: arguments, and what is wrong with them.
pub struct Call<'c> {
    /// Where moving numbers go.
    pub graph: &'c mut Graph,
    /// What was found.
    pub problems: Vec<Diagnostic>,
    /// Bare numbers where one with a unit is needed: which argument, and the unit of what.
    pub bare: Vec<(usize, Number, Dimension)>,
    function: &'static Builtin,
    given: Given,
    rest: More,
    file: FileId,
    span: Span,
}

/// The arguments of a call by parameter, with their places.
pub type Given = SmallVec<[(Option<Value>, Span); 4]>;

/// What is given beyond the parameters.
pub type More = SmallVec<[(Value, Span); 2]>;

impl<'c> Call<'c> {
    /// A call of `function`: one entry of `given` a parameter, `rest` beyond them.
    pub fn new(
        graph: &'c mut Graph,
        function: &'static Builtin,
        given: Given,
        rest: More,
        file: FileId,
        span: Span,
    ) -> Call<'c> {
        Call { graph, problems: Vec::new(), bare: Vec::new(), function, given, rest, file, span }
    }

    /// Whether every known number in the value is finite.
    pub fn finite(&self, value: &Value) -> bool {
        let finite = |parts: &[Scalar]| parts.iter().all(|part| part.constant().is_none_or(f64::is_finite));
        match value {
            Value::Number(number) => finite(&[number.value]),
            Value::Color(parts) => finite(parts),
            Value::Turn(parts) => finite(parts),
            Value::Tuple(items) => items.iter().all(|item| self.finite(item)),
            _ => true,
        }
    }

    /// Whether every known number in the arguments is finite.
    pub fn finite_arguments(&self) -> bool {
        let given = self.given.iter().filter_map(|given| given.0.as_ref());
        given.chain(self.rest.iter().map(|given| &given.0)).all(|value| self.finite(value))
    }

    fn value(&self, index: usize) -> Option<Value> {
        self.given.get(index).and_then(|given| given.0.clone())
    }

    fn place(&self, index: usize) -> Span {
        self.given.get(index).map_or(self.span, |given| given.1)
    }

    /// E0308: argument `index` is not what the function needs.
    fn needs(&mut self, what: &str, value: &Value, span: Span) {
        let found = value.with_article();
        let mut diagnostic = Diagnostic::new("E0308", format!("`{}` needs {what}", self.function.name)).primary(
            self.file,
            span,
            format!("this is {found}"),
        );
        if let Value::Number(number) = value
            && !number.dimension.is_none()
        {
            diagnostic = diagnostic.help(format!("divide by {found} first"));
        }
        self.problems.push(diagnostic);
    }

    /// "Not yet": the argument moves or differs from point to point, and the function cannot follow.
    fn later(&mut self, span: Span) -> Value {
        let given =
            self.given.iter().filter_map(|given| given.0.as_ref()).chain(self.rest.iter().map(|given| &given.0));
        let points = given.fold(Points::default(), |all, value| all.and(points(self.graph, value)));
        let how = if points.is_none() { "changes over time" } else { "differs from point to point" };
        let what = format!("`{}` of a value that {how}", self.function.name);
        self.problems.push(crate::eval::machine::not_yet(&what, self.file, span));
        Value::Error
    }

    /// E0405.
    fn no_direction(&mut self, index: usize, message: &str) -> Value {
        let span = self.place(index);
        self.problems.push(Diagnostic::new("E0405", message).primary(self.file, span, "gives no direction"));
        Value::Error
    }

    fn number(&mut self, index: usize) -> Option<Number> {
        match self.value(index)? {
            Value::Number(number) => Some(number),
            other => {
                self.needs("a number", &other, self.place(index));
                None
            }
        }
    }

    /// A plain number.
    fn plain(&mut self, index: usize) -> Option<Scalar> {
        self.quantity(index, Dimension::NONE)
    }

    /// A number of this dimension; a bare one is metres.
    fn quantity(&mut self, index: usize, dimension: Dimension) -> Option<Scalar> {
        let metres = dimension == Dimension::LENGTH;
        match self.value(index)? {
            Value::Number(number) if number.dimension == dimension || number.is_bare_zero() => Some(number.value),
            Value::Number(number) if metres && number.dimension.is_none() => Some(number.value),
            Value::Number(number) if number.dimension.is_none() => {
                self.bare.push((index, number, dimension));
                None
            }
            other => {
                let what = if dimension.is_none() { "a plain number".into() } else { dimension.with_article() };
                self.needs(&what, &other, self.place(index));
                None
            }
        }
    }

    /// An angle or a plain number, in radians.
    fn angle(&mut self, index: usize) -> Option<Scalar> {
        match self.value(index)? {
            Value::Number(number) if number.dimension.is_none() || number.dimension == Dimension::ANGLE => {
                Some(number.value)
            }
            other => {
                self.needs("an angle or a plain number", &other, self.place(index));
                None
            }
        }
    }

    /// An angle with a unit, in radians.
    fn true_angle(&mut self, index: usize) -> Option<Scalar> {
        match self.value(index)? {
            Value::Number(number) if number.dimension == Dimension::ANGLE || number.is_bare_zero() => {
                Some(number.value)
            }
            Value::Number(number) if number.dimension.is_none() => {
                self.bare.push((index, number, Dimension::ANGLE));
                None
            }
            other => {
                self.needs("an angle", &other, self.place(index));
                None
            }
        }
    }

    /// A node of a model's file; that it is a model is for who uses it.
    fn node(&mut self) -> Value {
        match (self.value(0), self.value(1)) {
            (Some(Value::Node(model)), Some(Value::Text(path))) => Value::Inner(model, path),
            (Some(Value::Node(_)), Some(other)) => {
                self.needs("a path, `\"Arm/Hand\"`", &other, self.place(1));
                Value::Error
            }
            (Some(other), _) => {
                self.needs("a model", &other, self.place(0));
                Value::Error
            }
            _ => Value::Error,
        }
    }

    /// The components of a vector and their common dimension.
    fn vector(&mut self, index: usize) -> Option<(Vec<Scalar>, Dimension)> {
        let value = self.value(index)?;
        match value.numbers().and_then(|numbers| one_dimension(&numbers)) {
            Some(found) => Some(found),
            None => {
                self.needs("a vector", &value, self.place(index));
                None
            }
        }
    }

    fn vec3(&mut self, index: usize) -> Option<([Scalar; 3], Dimension)> {
        let (parts, dimension) = self.vector(index)?;
        match parts.as_slice() {
            [x, y, z] => Some(([*x, *y, *z], dimension)),
            _ => {
                let value = self.value(index)?;
                self.needs("a vector of 3 components", &value, self.place(index));
                None
            }
        }
    }
}

/// The values and the one dimension of numbers; a 0 fits any.
fn one_dimension(numbers: &[Number]) -> Option<(Vec<Scalar>, Dimension)> {
    let dimension = numbers.iter().find(|n| !n.is_bare_zero()).map_or(Dimension::NONE, |n| n.dimension);
    let fits = numbers.iter().all(|number| number.dimension == dimension || number.is_bare_zero());
    fits.then(|| (numbers.iter().map(|number| number.value).collect(), dimension))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique() {
        for (i, function) in BUILTINS.iter().enumerate() {
            assert!(BUILTINS[..i].iter().all(|other| other.name != function.name), "{}", function.name);
            assert!(!function.doc.is_empty(), "{}", function.name);
        }
    }
}
