//! Arithmetic on numbers and vectors.

use kinora_scene::{Binary, Unary};

use super::{Call, one_dimension};
use crate::dimension::Dimension;
use crate::eval::expr::{common, met};
use crate::eval::graph::{Graph, Scalar};
use crate::source::Span;
use crate::value::{Number, Value};

/// Turns the `Option` of an argument into the value of the call.
macro_rules! try_arg {
    ($arg:expr) => {
        match $arg {
            Some(value) => value,
            None => return Value::Error,
        }
    };
}
pub(super) use try_arg;

pub(super) fn abs(call: &mut Call<'_>) -> Value {
    let value = try_arg!(call.value(0));
    let mut one = |x: Number| Value::Number(Number { value: call.graph.unary(Unary::Abs, x.value), ..x });
    match (&value, value.numbers()) {
        (Value::Number(x), _) => one(*x),
        (_, Some(parts)) => Value::Tuple(parts.into_iter().map(one).collect()),
        _ => {
            call.needs("a number or a vector", &value, call.place(0));
            Value::Error
        }
    }
}

pub(super) fn sign(call: &mut Call<'_>) -> Value {
    let x = try_arg!(call.number(0));
    Value::Number(Number { value: call.graph.unary(Unary::Sign, x.value), dimension: Dimension::NONE, int: true })
}

fn to_whole(call: &mut Call<'_>, op: Unary) -> Value {
    let x = try_arg!(call.plain(0));
    Value::Number(Number { value: call.graph.unary(op, x), dimension: Dimension::NONE, int: true })
}

pub(super) fn floor(call: &mut Call<'_>) -> Value {
    to_whole(call, Unary::Floor)
}

pub(super) fn ceil(call: &mut Call<'_>) -> Value {
    to_whole(call, Unary::Ceil)
}

pub(super) fn round(call: &mut Call<'_>) -> Value {
    to_whole(call, Unary::Round)
}

pub(super) fn fract(call: &mut Call<'_>) -> Value {
    let x = try_arg!(call.plain(0));
    Value::number(call.graph.binary(Binary::Mod, x, 1.0.into()))
}

/// Two numbers of one dimension.
fn pair(call: &mut Call<'_>, a: usize, b: usize) -> Option<(Number, Number, Dimension)> {
    let (x, y) = (call.number(a)?, call.number(b)?);
    match common(&x, &y) {
        Some(dimension) => Some((x, y, dimension)),
        None => {
            call.needs(&x.dimension.with_article(), &Value::Number(y), call.place(b));
            None
        }
    }
}

pub(super) fn modulo(call: &mut Call<'_>) -> Value {
    let (a, b, dimension) = try_arg!(pair(call, 0, 1));
    if b.value == Scalar::Const(0.0) {
        let span = call.place(1);
        call.problems.push(
            crate::diagnostic::Diagnostic::new("E0402", "division by zero gives no finite number")
                .primary(call.file, span, "`mod` divides by this, which is 0")
                .help("guard it with an `if`"),
        );
        return Value::Error;
    }
    let value = call.graph.binary(Binary::Mod, a.value, b.value);
    Value::Number(Number { value, dimension, int: a.int && b.int })
}

pub(super) fn sqrt(call: &mut Call<'_>) -> Value {
    let x = try_arg!(call.number(0));
    match x.dimension.root() {
        Some(dimension) => Value::quantity(call.graph.unary(Unary::Sqrt, x.value), dimension),
        None => {
            call.needs("a plain number or an area", &Value::Number(x), call.place(0));
            Value::Error
        }
    }
}

fn plain_unary(call: &mut Call<'_>, op: Unary, dimension: Dimension) -> Value {
    let x = try_arg!(call.plain(0));
    Value::quantity(call.graph.unary(op, x), dimension)
}

pub(super) fn exp(call: &mut Call<'_>) -> Value {
    plain_unary(call, Unary::Exp, Dimension::NONE)
}

pub(super) fn log(call: &mut Call<'_>) -> Value {
    plain_unary(call, Unary::Log, Dimension::NONE)
}

fn of_angle(call: &mut Call<'_>, op: Unary) -> Value {
    let x = try_arg!(call.angle(0));
    Value::number(call.graph.unary(op, x))
}

pub(super) fn sin(call: &mut Call<'_>) -> Value {
    of_angle(call, Unary::Sin)
}

pub(super) fn cos(call: &mut Call<'_>) -> Value {
    of_angle(call, Unary::Cos)
}

pub(super) fn tan(call: &mut Call<'_>) -> Value {
    of_angle(call, Unary::Tan)
}

pub(super) fn asin(call: &mut Call<'_>) -> Value {
    plain_unary(call, Unary::Asin, Dimension::ANGLE)
}

pub(super) fn acos(call: &mut Call<'_>) -> Value {
    plain_unary(call, Unary::Acos, Dimension::ANGLE)
}

pub(super) fn atan(call: &mut Call<'_>) -> Value {
    plain_unary(call, Unary::Atan, Dimension::ANGLE)
}

pub(super) fn atan2(call: &mut Call<'_>) -> Value {
    let (y, x, _) = try_arg!(pair(call, 0, 1));
    Value::quantity(call.graph.binary(Binary::Atan2, y.value, x.value), Dimension::ANGLE)
}

pub(super) fn turn(call: &mut Call<'_>) -> Value {
    let x = try_arg!(call.plain(0));
    Value::quantity(call.graph.mul(x, std::f64::consts::TAU.into()), Dimension::ANGLE)
}

pub(super) fn f_number(call: &mut Call<'_>) -> Value {
    let n = try_arg!(call.plain(0));
    let focal = try_arg!(call.quantity(1, Dimension::LENGTH));
    if n.constant().is_some_and(|n| n <= 0.0) {
        let span = call.place(0);
        call.problems.push(
            crate::diagnostic::Diagnostic::new("E0401", "f-number must be greater than 0")
                .primary(call.file, span, "not above 0")
                .help("leave `aperture` out for a pinhole"),
        );
        return Value::Error;
    }
    Value::quantity(call.graph.div(focal, n), Dimension::LENGTH)
}

/// The arguments, or the items of the one list that is given.
fn items(call: &mut Call<'_>) -> Option<Vec<(Value, Span)>> {
    let list = match call.rest.as_slice() {
        [(Value::List(items), span)] => items.iter().map(|item| (item.clone(), *span)).collect(),
        [(value @ Value::Tuple(_), span)] => {
            let (value, span) = (value.clone(), *span);
            call.needs("numbers or a list", &value, span);
            return None;
        }
        rest => rest.to_vec(),
    };
    if list.is_empty() {
        let span = call.span;
        call.problems.push(
            crate::diagnostic::Diagnostic::new("E0308", format!("`{}` needs at least one number", call.function.name))
                .primary(call.file, span, "nothing to go through"),
        );
        return None;
    }
    Some(list)
}

/// The arguments, or the items of a list, taken together two at a time, place by place.
fn fold(call: &mut Call<'_>, op: Binary, what: &str) -> Value {
    let mut total: Option<Value> = None;
    for (value, span) in try_arg!(items(call)) {
        let next = match &total {
            None => together(call.graph, op, &value, &value).map(|_| value.clone()),
            Some(total) => together(call.graph, op, total, &value),
        };
        let Some(next) = next else {
            let what = match &total {
                Some(Value::Number(before)) if matches!(value, Value::Number(_)) => before.dimension.with_article(),
                _ => what.into(),
            };
            call.needs(&what, &value, span);
            return Value::Error;
        };
        total = Some(next);
    }
    total.unwrap_or(Value::Error)
}

/// `None` where the two are not of one type.
fn together(graph: &mut Graph, op: Binary, a: &Value, b: &Value) -> Option<Value> {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => {
            let dimension = common(x, y)?;
            let value = graph.binary(op, x.value, y.value);
            Some(Value::Number(Number { value, dimension, int: x.int && y.int }))
        }
        (Value::Tuple(x), Value::Tuple(y)) if x.len() == y.len() => {
            let items: Option<Vec<Value>> =
                x.iter().zip(y.iter()).map(|(x, y)| together(graph, op, &met(x, y), &met(y, x))).collect();
            Some(Value::Tuple(items?.into()))
        }
        (Value::Color(x), Value::Color(y)) if op == Binary::Add => {
            Some(Value::Color([0, 1, 2].map(|i| graph.add(x[i], y[i]))))
        }
        _ => None,
    }
}

pub(super) fn min(call: &mut Call<'_>) -> Value {
    fold(call, Binary::Min, "numbers or vectors")
}

pub(super) fn max(call: &mut Call<'_>) -> Value {
    fold(call, Binary::Max, "numbers or vectors")
}

pub(super) fn sum(call: &mut Call<'_>) -> Value {
    if let [(Value::List(items), _)] = call.rest.as_slice()
        && items.is_empty()
    {
        return Value::Number(Number::int(0.0));
    }
    fold(call, Binary::Add, "numbers, vectors or colours")
}

pub(super) fn count(call: &mut Call<'_>) -> Value {
    match try_arg!(call.value(0)) {
        Value::List(items) => Value::Number(Number::int(items.len() as f64)),
        Value::Range(from, to) if from.value.constant().is_some() && to.value.constant().is_some() => {
            let length = to.value.constant().unwrap_or(0.0) - from.value.constant().unwrap_or(0.0);
            Value::Number(Number::int(length.max(0.0).ceil()))
        }
        other => {
            call.needs("a list", &other, call.place(0));
            Value::Error
        }
    }
}

pub(super) fn mix(call: &mut Call<'_>) -> Value {
    let (a, b) = (try_arg!(call.value(0)), try_arg!(call.value(1)));
    let t = try_arg!(call.plain(2));
    match blend(call.graph, &a, &b, t) {
        Some(value) => value,
        None => {
            call.needs(&a.with_article(), &b, call.place(1));
            Value::Error
        }
    }
}

fn blend(graph: &mut Graph, a: &Value, b: &Value, t: Scalar) -> Option<Value> {
    let mut one = |x: Scalar, y: Scalar| {
        let difference = graph.sub(y, x);
        let part = graph.mul(difference, t);
        graph.add(x, part)
    };
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => Some(Value::quantity(one(x.value, y.value), common(x, y)?)),
        (Value::Color(x), Value::Color(y)) => Some(Value::Color([0, 1, 2].map(|i| one(x[i], y[i])))),
        (Value::Tuple(x), Value::Tuple(y)) if x.len() == y.len() => {
            let items: Option<Vec<Value>> =
                x.iter().zip(y.iter()).map(|(x, y)| blend(graph, &met(x, y), &met(y, x), t)).collect();
            Some(Value::Tuple(items?.into()))
        }
        _ => None,
    }
}

pub(super) fn step(call: &mut Call<'_>) -> Value {
    let (edge, x, _) = try_arg!(pair(call, 0, 1));
    Value::number(call.graph.binary(Binary::LessEqual, edge.value, x.value))
}

fn clamped(graph: &mut Graph, x: Scalar, low: Scalar, high: Scalar) -> Scalar {
    let above = graph.binary(Binary::Max, x, low);
    graph.binary(Binary::Min, above, high)
}

pub(super) fn smoothstep(call: &mut Call<'_>) -> Value {
    let (low, high, _) = try_arg!(pair(call, 0, 1));
    let (_, x, _) = try_arg!(pair(call, 0, 2));
    let graph = &mut *call.graph;
    let (width, way) = (graph.sub(high.value, low.value), graph.sub(x.value, low.value));
    if width == Scalar::Const(0.0) {
        return Value::number(graph.binary(Binary::LessEqual, low.value, x.value));
    }
    let t = graph.div(way, width);
    let t = clamped(graph, t, 0.0.into(), 1.0.into());
    let double = graph.mul(t, 2.0.into());
    let rest = graph.sub(3.0.into(), double);
    let square = graph.mul(t, t);
    Value::number(graph.mul(square, rest))
}

pub(super) fn clamp(call: &mut Call<'_>) -> Value {
    let (x, low, dimension) = try_arg!(pair(call, 0, 1));
    let (_, high, other) = try_arg!(pair(call, 0, 2));
    let dimension = if dimension.is_none() { other } else { dimension };
    let value = clamped(call.graph, x.value, low.value, high.value);
    Value::Number(Number { value, dimension, int: x.int && low.int && high.int })
}

pub(super) fn saturate(call: &mut Call<'_>) -> Value {
    let x = try_arg!(call.plain(0));
    Value::number(clamped(call.graph, x, 0.0.into(), 1.0.into()))
}

/// The length of a vector without squaring overflowing for no reason.
pub(super) fn norm(graph: &mut Graph, parts: &[Scalar]) -> Scalar {
    let square = graph.dot(parts, parts);
    graph.unary(Unary::Sqrt, square)
}

pub(super) fn length(call: &mut Call<'_>) -> Value {
    let (parts, dimension) = try_arg!(call.vector(0));
    Value::quantity(norm(call.graph, &parts), dimension)
}

pub(super) fn normalize(call: &mut Call<'_>) -> Value {
    let (parts, _) = try_arg!(call.vector(0));
    let length = norm(call.graph, &parts);
    if length == Scalar::Const(0.0) {
        return call.no_direction(0, "direction has zero length");
    }
    let parts: Vec<Scalar> = parts.into_iter().map(|part| call.graph.div(part, length)).collect();
    Value::vector(&parts, Dimension::NONE)
}

/// The cross product.
pub(super) fn crossed(graph: &mut Graph, a: [Scalar; 3], b: [Scalar; 3]) -> [Scalar; 3] {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| {
        let (x, y) = (graph.mul(a[i], b[j]), graph.mul(a[j], b[i]));
        graph.sub(x, y)
    })
}

pub(super) fn cross(call: &mut Call<'_>) -> Value {
    let ((a, x), (b, y)) = (try_arg!(call.vec3(0)), try_arg!(call.vec3(1)));
    match x.times(y) {
        Some(dimension) => Value::vector(&crossed(call.graph, a, b), dimension),
        None => Value::Error,
    }
}

/// Two vectors with the same number of components.
fn vectors(call: &mut Call<'_>) -> Option<[(Vec<Scalar>, Dimension); 2]> {
    let (a, b) = (call.vector(0)?, call.vector(1)?);
    if a.0.len() != b.0.len() {
        let value = call.value(1)?;
        call.needs(&format!("a vector of {} components", a.0.len()), &value, call.place(1));
        return None;
    }
    Some([a, b])
}

pub(super) fn dot(call: &mut Call<'_>) -> Value {
    let [(a, x), (b, y)] = try_arg!(vectors(call));
    match x.times(y) {
        Some(dimension) => Value::quantity(call.graph.dot(&a, &b), dimension),
        None => Value::Error,
    }
}

pub(super) fn distance(call: &mut Call<'_>) -> Value {
    let [(a, x), (b, y)] = try_arg!(vectors(call));
    let all: Vec<Number> = a.iter().map(|v| Number::new(*v, x)).chain(b.iter().map(|v| Number::new(*v, y))).collect();
    // A point written in bare metres may be compared with a measured one.
    let lengths = [Dimension::NONE, Dimension::LENGTH];
    let dimension = match one_dimension(&all) {
        Some((_, dimension)) => dimension,
        None if lengths.contains(&x) && lengths.contains(&y) => Dimension::LENGTH,
        None => {
            let value = try_arg!(call.value(1));
            call.needs(&x.with_article(), &value, call.place(1));
            return Value::Error;
        }
    };
    let parts: Vec<Scalar> = a.iter().zip(&b).map(|(a, b)| call.graph.sub(*a, *b)).collect();
    Value::quantity(norm(call.graph, &parts), dimension)
}
