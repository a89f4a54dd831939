//! What single expressions come to, for whoever points at them in an editor.

use std::sync::{Arc, mpsc};

use kinora_scene::Track;
use rustc_hash::FxHashMap;

use crate::dimension::Dimension;
use crate::eval::graph::Scalar;
use crate::eval::machine::Machine;
use crate::eval::surface::points;
use crate::eval::{Nothing, Overrides, compute, thread};
use crate::modules::Modules;
use crate::source::Span;
use crate::value::{Number, Value};

/// Expressions whose values are kept as they are computed: the first value of each, and whether there were others.
#[derive(Debug, Default)]
pub struct Watching(Option<FxHashMap<Span, Option<(Value, bool)>>>);

impl Watching {
    fn of(spans: &[Span]) -> Watching {
        Watching(Some(spans.iter().map(|span| (*span, None)).collect()))
    }

    /// Looks at a value and gives it back.
    #[inline]
    pub fn see(&mut self, span: Span, value: Value) -> Value {
        if let Some(kept) = &mut self.0 {
            keep(kept, span, &value);
        }
        value
    }
}

fn keep(kept: &mut FxHashMap<Span, Option<(Value, bool)>>, span: Span, value: &Value) {
    match kept.get_mut(&span) {
        Some(Some((first, others))) => *others |= first != value,
        Some(first) => *first = Some((value.clone(), false)),
        None => {}
    }
}

/// What an expression comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Watched {
    /// What it is: "a length".
    pub what: String,
    /// The value.
    pub value: Amount,
}

/// The value of an expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Amount {
    /// A value, as a message shows it; and whether other turns of a loop or other calls give other ones.
    Is(String, bool),
    /// It changes over time.
    Moves(Moving),
    /// It depends on the point of a surface.
    Surface,
}

/// A value that changes over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Moving {
    /// Its numbers.
    pub parts: Vec<Track<f64>>,
    form: Form,
}

#[derive(Debug, Clone, PartialEq)]
enum Form {
    Number(Dimension),
    Vector(Vec<Dimension>),
    Color,
    Turn,
    Bool,
}

impl Moving {
    /// The value with these numbers, one for each of the parts.
    pub fn show(&self, numbers: &[f64]) -> String {
        let at = |i: usize| Scalar::Const(numbers.get(i).copied().unwrap_or(f64::NAN));
        let value = match &self.form {
            Form::Number(of) => Value::quantity(at(0), *of),
            Form::Vector(of) => {
                Value::Tuple(of.iter().enumerate().map(|(i, of)| Value::quantity(at(i), *of)).collect())
            }
            Form::Color => Value::Color([at(0), at(1), at(2)]),
            Form::Turn => Value::Turn([at(0), at(1), at(2), at(3)]),
            Form::Bool => Value::Bool(at(0)),
        };
        value.show()
    }
}

/// What the expressions at these places, in [`Modules::texts`], come to when the scene is evaluated; those that are
/// never computed, or are in error, are not among them.
pub fn values_at(modules: &Arc<Modules>, overrides: &Overrides, spans: &[Span]) -> Vec<(Span, Watched)> {
    let (give, done) = mpsc::channel();
    let (modules, overrides, spans) = (modules.clone(), overrides.clone(), spans.to_vec());
    let spawned = thread("watch").spawn(move || {
        let nothing = Nothing::new();
        let mut machine = Machine::new(&modules.texts, &nothing.mix);
        machine.watched = Watching::of(&spans);
        compute(&modules, &overrides, &nothing, &mut machine);
        let mut kept = std::mem::take(&mut machine.watched).0.unwrap_or_default();
        let values = spans.iter().filter_map(|span| Some((*span, kept.remove(span)??)));
        let values: Vec<_> = values.collect();
        let shown = values
            .into_iter()
            .filter_map(|(span, (value, others))| machine.shown(value, others).map(|shown| (span, shown)));
        // Nobody waits for it only where the caller is gone.
        let _ = give.send(shown.collect());
    });
    spawned.ok().and_then(|_| done.recv().ok()).unwrap_or_default()
}

impl Machine<'_> {
    fn shown(&mut self, value: Value, others: bool) -> Option<Watched> {
        let value = self.flatten(value);
        // What a node is, its text says better.
        if value.is_error() || matches!(value, Value::Node(_) | Value::Inner(..) | Value::Texture(_) | Value::Word(_)) {
            return None;
        }
        let what = value.with_article();
        Some(Watched { what, value: self.amount(&value, others) })
    }

    fn amount(&mut self, value: &Value, others: bool) -> Amount {
        if !points(&self.graph, value).is_none() {
            return Amount::Surface;
        }
        let constant = Amount::Is(value.show(), others);
        if value.is_constant() {
            return constant;
        }
        let (form, scalars): (Form, Vec<Scalar>) = match value {
            Value::Number(number) => (Form::Number(number.dimension), vec![number.value]),
            Value::Bool(scalar) => (Form::Bool, vec![*scalar]),
            Value::Color(parts) => (Form::Color, parts.to_vec()),
            Value::Turn(parts) => (Form::Turn, parts.to_vec()),
            value => {
                let Some(numbers) = value.numbers() else { return constant };
                let of = |number: &Number| number.dimension;
                (Form::Vector(numbers.iter().map(of).collect()), numbers.iter().map(|number| number.value).collect())
            }
        };
        let part = |scalar: &Scalar| match scalar.constant() {
            Some(value) => Track::Const(value),
            None => Track::Curve(Box::new(self.graph.tape(&[*scalar]))),
        };
        Amount::Moves(Moving { parts: scalars.iter().map(part).collect(), form })
    }
}
