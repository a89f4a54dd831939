//! `keys { 0s: a  1s: b ease out_quad }`

use std::sync::Arc;

use kinora_scene::{Bezier, Ease, Jump};

use crate::builtin::{ease, quaternion};
use crate::diagnostic::{Applicability, Diagnostic};
use crate::dimension::{Dimension, short};
use crate::eval::expr::{Env, same_type};
use crate::eval::graph::Scalar;
use crate::eval::limits;
use crate::eval::machine::Machine;
use crate::eval::surface::points;
use crate::source::Span;
use crate::suggest::{any_of, suggest};
use crate::syntax::ast::{self, Arg, Expr, ExprKind, KeyValue};
use crate::value::{KeyItem, Number, Value};

/// How the values between keys come about.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Eased,
    Linear,
    Step,
}

impl<'a> Machine<'a> {
    /// The value of a `keys` block.
    pub fn keys(&mut self, keys: &'a ast::Keys, span: Span, env: &Env<'a>) -> Value {
        let way = self.key_options(&keys.args);
        let mut failed = way.is_none();
        if keys.keys.is_empty() {
            let Some(block) = keys.block else { return Value::Error };
            let diagnostic = Diagnostic::new("E0604", "`keys` needs at least one key")
                .primary(self.file(), block, "nothing in here")
                .help("write `0s: value`");
            return self.error(diagnostic);
        }
        if keys.keys.len() > limits::KEYS {
            return self.too_many("keys in a curve", limits::KEYS, span);
        }
        let mut items: Vec<KeyItem> = Vec::with_capacity(keys.keys.len());
        let mut previous: Option<(f64, Span)> = None;
        for (i, key) in keys.keys.iter().enumerate() {
            let time = self.key_time(key, previous, env);
            let ease = match &key.ease {
                Some(expr) if i == 0 => {
                    let diagnostic = Diagnostic::new("W0605", "easing on the first key has no effect")
                        .primary(self.file(), expr.span, "no key before this one")
                        .help("an easing shapes the way *to* its key: move it to the next one");
                    self.report(diagnostic);
                    self.ease(expr, env)
                }
                Some(expr) => self.ease(expr, env),
                None => Some(Ease::Linear),
            };
            let (value, place) = match &key.value {
                KeyValue::Value(expr) => (self.plain(expr, env), expr.span),
                KeyValue::Block(block) => {
                    (self.later("keys with tangents (`interpolate: hermite`)", block.span), block.span)
                }
            };
            let (Some(time_s), Some(ease), false) = (time, ease, value.is_error()) else {
                failed = true;
                continue;
            };
            self.key_order(previous, (time_s, key.time.span), &mut failed);
            previous = Some((time_s, key.time.span));
            let ease = match way {
                Some(Way::Linear) => Ease::Linear,
                Some(Way::Step) => Ease::Step,
                _ => ease,
            };
            failed |= !self.key_value(&value, place, items.first());
            items.push(KeyItem { time_s, value, ease, span: place });
        }
        for pair in items.windows(2) {
            if let (Value::Turn(a), Value::Turn(b)) = (&pair[0].value, &pair[1].value)
                && let (Some(a), Some(b)) = (quaternion(a), quaternion(b))
                && a.dot(b).abs() < 1e-9
            {
                let (from, to) = (short(pair[0].time_s), short(pair[1].time_s));
                let message = format!("rotation from the key at {from}s to the key at {to}s has no shortest way");
                let diagnostic = Diagnostic::new("E0607", message)
                    .primary(self.file(), pair[1].span, "exactly half a turn away")
                    .label(self.file(), pair[0].span, "from here")
                    .help("add a key in between, or animate an angle: `rotate_y(keys { .. })`");
                self.report(diagnostic);
                failed = true;
            }
        }
        if failed { Value::Error } else { Value::Keys(Arc::new(items)) }
    }

    fn key_options(&mut self, args: &'a [Arg]) -> Option<Way> {
        let mut way = Some(Way::Eased);
        for arg in args {
            let word = match &arg.value.kind {
                ExprKind::Path(path) if path.segments.len() == 1 => path.segments.first().map(|name| &*name.text),
                _ => None,
            };
            let (Some(name), Some(word)) = (&arg.name, word) else {
                let diagnostic = Diagnostic::new("E0301", "expected an option such as `interpolate: linear`").primary(
                    self.file(),
                    arg.span,
                    "not an option of `keys`",
                );
                self.report(diagnostic);
                way = None;
                continue;
            };
            let known: &[&str] = match &*name.text {
                "interpolate" => &["eased", "linear", "step", "spline", "hermite"],
                "outside" => &["hold", "loop", "pingpong", "extend", "error"],
                "space" => &["linear", "oklch"],
                _ => {
                    let options = ["interpolate", "outside", "space"];
                    let mut diagnostic = Diagnostic::new("E0208", format!("`keys` has no parameter `{}`", name.text))
                        .primary(self.file(), name.span, "no such parameter");
                    diagnostic = match suggest(&name.text, options).first() {
                        Some(near) => {
                            let file = self.file();
                            diagnostic.fix(Applicability::Safe, format!("write `{near}`"), file, name.span, *near)
                        }
                        None => diagnostic.help(format!("it takes {}", any_of(options))),
                    };
                    self.report(diagnostic);
                    way = None;
                    continue;
                }
            };
            match (&*name.text, word) {
                ("interpolate", "eased") | ("outside", "hold") | ("space", "linear") => {}
                ("interpolate", "linear") => way = way.map(|_| Way::Linear),
                ("interpolate", "step") => way = way.map(|_| Way::Step),
                (option, word) if known.contains(&word) => {
                    self.later(&format!("`keys({option}: {word})`"), arg.value.span);
                    way = None;
                }
                (option, word) => {
                    let message = format!("expected {}, found `{word}`", any_of(known.iter().copied()));
                    let mut diagnostic = Diagnostic::new("E0301", message).primary(
                        self.file(),
                        arg.value.span,
                        format!("not an `{option}` of `keys`"),
                    );
                    if let Some(near) = suggest(word, known.iter().copied()).first() {
                        let file = self.file();
                        let now = ["eased", "linear", "step", "hold"].contains(near);
                        let trust = if now { Applicability::Safe } else { Applicability::Maybe };
                        diagnostic = diagnostic.fix(trust, format!("write `{near}`"), file, arg.value.span, *near);
                    }
                    self.report(diagnostic);
                    way = None;
                }
            }
        }
        way
    }

    fn key_time(&mut self, key: &'a ast::Key, previous: Option<(f64, Span)>, env: &Env<'a>) -> Option<f64> {
        let span = key.time.span;
        let value = self.plain(&key.time, env);
        let time = match value {
            Value::Error => return None,
            Value::Number(number) if number.dimension == Dimension::TIME || number.is_bare_zero() => number.value,
            Value::Number(number) if number.dimension.is_none() => {
                self.needs_unit(Dimension::TIME, number, &key.time);
                return None;
            }
            other => {
                let found = self.describe(&other);
                let code = if matches!(other, Value::Number(_)) { "E0302" } else { "E0301" };
                let diagnostic = Diagnostic::new(code, format!("expected a time, found {found}")).primary(
                    self.file(),
                    span,
                    format!("this is {found}"),
                );
                self.report(diagnostic);
                return None;
            }
        };
        match time {
            Scalar::Const(time) if !time.is_finite() => {
                let diagnostic = Diagnostic::new("E0403", "the time of a key is not a finite number").primary(
                    self.file(),
                    span,
                    "not a finite number",
                );
                self.report(diagnostic);
                None
            }
            Scalar::Const(time) if key.after => Some(previous.map_or(0.0, |previous| previous.0) + time),
            Scalar::Const(time) => Some(time),
            moving => {
                self.structure("the time of a key", moving, span, span);
                None
            }
        }
    }

    fn key_order(&mut self, previous: Option<(f64, Span)>, (time, span): (f64, Span), failed: &mut bool) {
        if let Some((before, at)) = previous {
            if time == before {
                let diagnostic = Diagnostic::new("E0603", format!("two keys at {}s", short(time)))
                    .primary(self.file(), span, "again")
                    .label(self.file(), at, "already here")
                    .help("use `ease step` for a jump");
                self.report(diagnostic);
                *failed = true;
            } else if time < before {
                let message = format!("key at {}s comes after key at {}s", short(time), short(before));
                let diagnostic = Diagnostic::new("E0602", message)
                    .primary(self.file(), span, "earlier than the key before it")
                    .label(self.file(), at, "the key before it")
                    .help("sort the keys by time");
                self.report(diagnostic);
                *failed = true;
            } else {
                let fps = self.frames_per_second().unwrap_or(24.0);
                if (time - before) * fps < 1.0 - 1e-9 {
                    let apart = short((time - before) * 1000.0);
                    let diagnostic =
                        Diagnostic::new("W0612", format!("two keys {apart} ms apart at {} fps", short(fps)))
                            .primary(self.file(), span, "less than a frame after the key before it")
                            .label(self.file(), at, "the key before it");
                    self.report(diagnostic);
                }
            }
        }
        if let Some((duration, place)) = self.duration()
            && duration > 0.0
            && time > duration + 1e-9
        {
            let message = format!("key at {}s is after the end ({}s)", short(time), short(duration));
            let diagnostic = Diagnostic::new("W0611", message).primary(self.file(), span, "never reached").label(
                self.file(),
                place,
                "the end",
            );
            self.report(diagnostic);
        }
    }

    /// Whether the value can be a key beside the first one.
    fn key_value(&mut self, value: &Value, span: Span, first: Option<&KeyItem>) -> bool {
        let fits = match value {
            Value::Number(_) | Value::Bool(_) | Value::Color(_) | Value::Turn(_) => true,
            value => value.numbers().is_some(),
        };
        if !fits {
            let found = self.describe(value);
            let diagnostic = Diagnostic::new("E0606", format!("keys cannot hold {found}"))
                .primary(self.file(), span, format!("this is {found}"))
                .help("keys hold numbers, vectors, colours, rotations, `true` and `false`");
            self.report(diagnostic);
            return false;
        }
        if !value.is_constant() {
            let differ =
                if points(&self.graph, value).is_none() { "change over time" } else { "differ from point to point" };
            self.later(&format!("keys whose values {differ}"), span);
            return false;
        }
        if let Some(first) = first
            && !same_type(&first.value, value)
        {
            let diagnostic = Diagnostic::new("E0606", "keys have different types")
                .primary(self.file(), span, format!("this is {}", self.describe(value)))
                .label(self.file(), first.span, format!("the first key is {}", self.describe(&first.value)));
            self.report(diagnostic);
            return false;
        }
        true
    }

    fn ease(&mut self, expr: &'a Expr, env: &Env<'a>) -> Option<Ease> {
        match &expr.kind {
            ExprKind::Missing => None,
            ExprKind::Path(path) => {
                let name = self.text(path.span);
                if let Some(found) = ease::named(name) {
                    return Some(found);
                }
                let names = ease::names();
                let mut diagnostic = Diagnostic::new("E0609", format!("no easing `{}`", short_name(name))).primary(
                    self.file(),
                    expr.span,
                    "not an easing",
                );
                diagnostic = match suggest(name, names.iter().map(String::as_str)).first() {
                    Some(near) => {
                        let file = self.file();
                        diagnostic.fix(Applicability::Safe, format!("write `{near}`"), file, expr.span, *near)
                    }
                    None => diagnostic.help("for example `linear`, `step`, `ease_in_out` or `out_cubic`"),
                };
                self.report(diagnostic);
                None
            }
            ExprKind::Call { callee, args } => match self.text(callee.span) {
                "bezier" => self.bezier(args, expr.span, env),
                "steps" => self.steps(args, expr.span, env),
                "spring" => {
                    self.later("`ease spring(..)`", expr.span);
                    None
                }
                name => {
                    let diagnostic = Diagnostic::new("E0609", format!("no easing `{}`", short_name(name)))
                        .primary(self.file(), callee.span, "not an easing")
                        .help("curves with arguments are `bezier(x1, y1, x2, y2)` and `steps(n, jump_end)`");
                    self.report(diagnostic);
                    None
                }
            },
            _ => {
                let diagnostic = Diagnostic::new("E0609", "expected the name of an easing")
                    .primary(self.file(), expr.span, "not an easing")
                    .help("for example `linear`, `step`, `ease_in_out` or `out_cubic`");
                self.report(diagnostic);
                None
            }
        }
    }

    fn ease_number(&mut self, expr: &'a Expr, env: &Env<'a>) -> Option<f64> {
        match self.plain(expr, env) {
            Value::Error => None,
            Value::Number(Number { value: Scalar::Const(value), dimension, .. })
                if dimension.is_none() && value.is_finite() =>
            {
                Some(value)
            }
            other => {
                let found = self.describe(&other);
                let diagnostic = Diagnostic::new("E0301", format!("expected a plain number, found {found}")).primary(
                    self.file(),
                    expr.span,
                    "not a constant plain number",
                );
                self.report(diagnostic);
                None
            }
        }
    }

    fn arity(&mut self, name: &str, takes: &str, found: usize, span: Span, signature: &str) {
        let diagnostic = Diagnostic::new("E0211", format!("`{name}` takes {takes}, got {found}"))
            .primary(self.file(), span, "")
            .help(format!("it is `{signature}`"));
        self.report(diagnostic);
    }

    fn bezier(&mut self, args: &'a [Arg], span: Span, env: &Env<'a>) -> Option<Ease> {
        let numbers: Vec<Option<f64>> = args.iter().map(|arg| self.ease_number(&arg.value, env)).collect();
        let [x1, y1, x2, y2] = numbers.as_slice() else {
            self.arity("bezier", "4 values", args.len(), span, "bezier(x1, y1, x2, y2)");
            return None;
        };
        let (x1, y1, x2, y2) = ((*x1)?, (*y1)?, (*x2)?, (*y2)?);
        let mut fine = true;
        for (x, arg) in [(x1, 0), (x2, 2)] {
            if !(0.0..=1.0).contains(&x)
                && let Some(arg) = args.get(arg)
            {
                fine = false;
                let found = self.computed("this is", x, Dimension::NONE, arg.value.span);
                let diagnostic = Diagnostic::new("E0412", "x of a bezier handle must be within 0..1")
                    .primary(self.file(), arg.value.span, found)
                    .note("time cannot run backwards");
                self.report(diagnostic);
            }
        }
        fine.then_some(Ease::Bezier(Bezier { x1, y1, x2, y2 }))
    }

    fn steps(&mut self, args: &'a [Arg], span: Span, env: &Env<'a>) -> Option<Ease> {
        let (first, second) = match args {
            [first] => (first, None),
            [first, second] => (first, Some(second)),
            _ => {
                self.arity("steps", "1 or 2 values", args.len(), span, "steps(n, jump_end)");
                return None;
            }
        };
        let jump = match second {
            None => Jump::End,
            Some(arg) => {
                let word = self.text(arg.value.span);
                match ease::JUMPS.iter().find(|row| row.0 == word) {
                    Some(row) => row.1,
                    None => {
                        let message = format!(
                            "expected {}, found `{}`",
                            any_of(ease::JUMPS.iter().map(|row| row.0)),
                            short_name(word)
                        );
                        let diagnostic = Diagnostic::new("E0301", message).primary(
                            self.file(),
                            arg.value.span,
                            "where the value jumps",
                        );
                        self.report(diagnostic);
                        return None;
                    }
                }
            }
        };
        let n = self.ease_number(&first.value, env)?;
        let least = if jump == Jump::None { 2.0 } else { 1.0 };
        if n.fract() != 0.0 {
            let diagnostic = Diagnostic::new("E0310", "expected a whole number")
                .primary(self.file(), first.value.span, "not a whole number")
                .help("use `floor()` or `round()`");
            self.report(diagnostic);
            return None;
        }
        if !(least..=1e6).contains(&n) {
            let diagnostic = Diagnostic::new("E0401", format!("steps must be within {least}..1000000")).primary(
                self.file(),
                first.value.span,
                self.computed("this is", n, Dimension::NONE, first.value.span),
            );
            self.report(diagnostic);
            return None;
        }
        Some(Ease::Steps(n as u32, jump))
    }
}

fn short_name(name: &str) -> String {
    crate::eval::expr::short_text(name)
}
