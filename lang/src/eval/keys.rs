//! `keys { 0s: a  1s: b ease out_quad }`

use std::sync::Arc;

use kinora_scene::{Bezier, Ease, Instruction, Jump, Outside, Spring};

use crate::builtin::{self, Call, ease, quaternion};
use crate::diagnostic::{Applicability, Diagnostic, Edit, Fix};
use crate::dimension::{Dimension, short};
use crate::eval::curve::{shared, slope_of, spun};
use crate::eval::expr::{Argument, Env, same_type};
use crate::eval::graph::Scalar;
use crate::eval::limits;
use crate::eval::machine::Machine;
use crate::eval::scope::Binding;
use crate::source::Span;
use crate::suggest::{any_of, suggest};
use crate::syntax::ast::{self, Arg, Block, Expr, ExprKind, Item, KeyValue};
use crate::value::{KeyItem, Keyed, Number, Through, Value};

/// How the values between keys come about.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Eased,
    Linear,
    Step,
    Spline,
    Hermite,
}

/// The words of `interpolate`.
const WAYS: [(&str, Way); 5] = [
    ("eased", Way::Eased),
    ("linear", Way::Linear),
    ("step", Way::Step),
    ("spline", Way::Spline),
    ("hermite", Way::Hermite),
];

/// The words of `outside`.
const OUTSIDE: [(&str, Outside); 5] = [
    ("hold", Outside::Hold),
    ("loop", Outside::Loop),
    ("pingpong", Outside::PingPong),
    ("extend", Outside::Extend),
    ("error", Outside::Error),
];

/// The words of `space`: whether it is OKLCh.
const SPACES: [(&str, bool); 2] = [("linear", false), ("oklch", true)];

/// The options of `keys(..)` and the words of each.
pub fn options() -> [(&'static str, Vec<&'static str>); 3] {
    [
        ("interpolate", WAYS.map(|row| row.0).to_vec()),
        ("outside", OUTSIDE.map(|row| row.0).to_vec()),
        ("space", SPACES.map(|row| row.0).to_vec()),
    ]
}

/// What `keys(..)` says.
#[derive(Clone, Copy)]
struct Options {
    way: Way,
    outside: Outside,
    oklch: bool,
    /// Where `interpolate` and `space` are said.
    way_at: Option<Span>,
    space_at: Option<Span>,
}

/// What one key says, before it is put in order.
struct Reached {
    value: Value,
    /// Where the value is written.
    place: Span,
    tangents: Option<Box<[Value; 2]>>,
}

impl<'a> Machine<'a> {
    /// The value of a `keys` block.
    pub fn keys(&mut self, keys: &'a ast::Keys, span: Span, env: &Env<'a>) -> Value {
        let options = self.key_options(&keys.args);
        let mut failed = options.is_none();
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
        let way = options.map_or(Way::Eased, |options| options.way);
        let mut items: Vec<KeyItem> = Vec::with_capacity(keys.keys.len());
        let mut times = Vec::with_capacity(keys.keys.len());
        let found = self.diagnostics.len();
        let mut previous: Option<(f64, Span)> = None;
        for (i, key) in keys.keys.iter().enumerate() {
            let time = self.key_time(key, previous, env);
            times.extend(time.filter(|_| !key.after));
            if let (Some(expr), Some(options)) = (&key.ease, options) {
                self.ease_counts(expr, i, options);
            }
            let ease = match &key.ease {
                Some(expr) => self.ease(expr, env),
                None => Some(Ease::Linear),
            };
            let reached = match &key.value {
                KeyValue::Value(expr) => {
                    Some(Reached { value: self.plain(expr, env), place: expr.span, tangents: None })
                }
                KeyValue::Block(block) => self.tangents(block, way, options.and_then(|options| options.way_at), env),
            };
            let (Some(time_s), Some(ease), Some(reached)) = (time, ease, reached.filter(|r| !r.value.is_error()))
            else {
                failed = true;
                continue;
            };
            let Reached { value, place, tangents } = reached;
            self.key_order(previous, (time_s, key.time.span), &mut failed);
            let seconds = time_s - previous.map_or(time_s, |previous| previous.0);
            previous = Some((time_s, key.time.span));
            let ease = match (way, ease) {
                (Way::Linear, _) => Ease::Linear,
                (Way::Step, _) => Ease::Step,
                // What is true or false holds until it changes, in a curve of numbers too.
                _ if matches!(value, Value::Bool(_)) => Ease::Step,
                (_, Ease::Spring(spring)) => Ease::Spring(Spring { frequency: spring.frequency * seconds, ..spring }),
                (_, ease) => ease,
            };
            // One mistake, however many keys are of that type.
            if failed && items.is_empty() && matches!(value, Value::Node(_)) {
                continue;
            }
            failed |= !self.key_value(&value, place, items.first());
            if !value.is_key() {
                continue;
            }
            items.push(KeyItem { time_s, value, tangents, ease, span: place });
        }
        if failed && times.len() == keys.keys.len() {
            self.sorted(&keys.keys, &times, found);
        }
        let Some(options) = options.filter(|_| !failed) else { return Value::Error };
        self.smooth_turns(&items, &mut failed);
        self.fitting_options(&items, options, &mut failed);
        if options.outside == Outside::Error {
            self.covered(&items);
        }
        let through = match way {
            Way::Spline => Through::Spline,
            Way::Hermite => Through::Tangents,
            _ => Through::Straight,
        };
        if failed {
            return Value::Error;
        }
        let color = items.first().is_some_and(|key| matches!(key.value, Value::Color(_)));
        shared(Keyed { keys: items, through, outside: options.outside, oklch: options.oklch && color })
    }

    /// Gives the first report of keys out of order a fix: the keys by their times.
    fn sorted(&mut self, keys: &'a [ast::Key], times: &[f64], found: usize) {
        let mut order: Vec<usize> = (0..keys.len()).collect();
        order.sort_by(|a, b| times[*a].total_cmp(&times[*b]));
        let file = self.file();
        let moved = order.iter().zip(keys).filter_map(|(from, to)| {
            let from = keys.get(*from)?.span;
            (from != to.span).then(|| Edit { file, span: to.span, insert: self.text(from).to_string() })
        });
        let edits: Vec<Edit> = moved.collect();
        let first = self.diagnostics.get_mut(found..).and_then(|new| new.iter_mut().find(|new| new.code == "E0602"));
        if let Some(diagnostic) = first.filter(|_| edits.len() <= 64) {
            diagnostic.helps.clear();
            let message = "sort the keys by time".to_string();
            diagnostic.fixes.push(Fix { applicability: Applicability::Maybe, message, edits });
        }
    }

    /// W0605 and W0416: an easing that shapes nothing.
    fn ease_counts(&mut self, expr: &'a Expr, index: usize, options: Options) {
        let word = WAYS.iter().find(|row| row.1 == options.way).map_or("", |row| row.0);
        let diagnostic = match options.way {
            _ if index == 0 => Diagnostic::new("W0605", "easing on the first key has no effect")
                .primary(self.file(), expr.span, "no key before this one")
                .help("an easing shapes the way *to* its key: move it to the next one"),
            Way::Linear | Way::Step => {
                let message = format!("`ease` has no effect with `interpolate: {word}`");
                let diagnostic = Diagnostic::new("W0416", message).primary(self.file(), expr.span, "changes nothing");
                let diagnostic = match options.way_at {
                    Some(at) => diagnostic.label(self.file(), at, "decides it for all keys"),
                    None => diagnostic,
                };
                diagnostic.help("remove one of them: `eased` is the default")
            }
            _ => return,
        };
        self.report(diagnostic);
    }

    /// E0607: two rotations between which no way is the shorter one.
    fn smooth_turns(&mut self, items: &[KeyItem], failed: &mut bool) {
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
                *failed = true;
            }
        }
    }

    /// Options that values of this type do not have.
    fn fitting_options(&mut self, items: &[KeyItem], options: Options, failed: &mut bool) {
        let Some(first) = items.first() else { return };
        let color = matches!(first.value, Value::Color(_));
        if let (true, Some(at)) = (options.oklch, options.space_at) {
            if options.way == Way::Hermite {
                let diagnostic = Diagnostic::new("E0616", "tangents are in linear light")
                    .primary(self.file(), at, "not by hue")
                    .help("use `interpolate: spline`, or leave `space` out");
                self.report(diagnostic);
                *failed = true;
            } else if !color {
                let found = self.describe(&first.value);
                let diagnostic = Diagnostic::new("W0416", "`space` has no effect without colours")
                    .primary(self.file(), at, "changes nothing")
                    .label(self.file(), first.span, format!("this is {found}"))
                    .help("remove it");
                self.report(diagnostic);
            }
        }
    }

    /// E0614: frames for which there is no value.
    fn covered(&mut self, items: &[KeyItem]) {
        let (Some(first), Some(last)) = (items.first(), items.last()) else { return };
        let fps = self.frames_per_second().unwrap_or(24.0);
        let (end, place) = self.duration().map_or((0.0, None), |(end, place)| (end, Some(place)));
        let frames = ((end * fps * 1e6).round() / 1e6).ceil().max(1.0);
        // What is seen of the last frame ends when the shutter closes.
        let last_frame = (frames - 1.0 + self.shutter()) / fps;
        let (message, span, label) = if first.time_s > 1e-9 {
            (format!("keys begin at {}s, after the first frame", short(first.time_s)), first.span, "the first key")
        } else if last.time_s < last_frame - 1e-9 {
            let message = format!(
                "keys end at {}s, before the end of the last frame ({}s)",
                short(last.time_s),
                short(last_frame)
            );
            (message, last.span, "the last key")
        } else {
            return;
        };
        let mut diagnostic = Diagnostic::new("E0614", message).primary(self.file(), span, label);
        if let Some(place) = place {
            diagnostic = diagnostic.label(self.file(), place, "the end");
        }
        self.report(diagnostic.help("add a key, or choose `outside: hold`, `loop`, `pingpong` or `extend`"));
    }

    /// `{ value: 1, in: 0, out: 2 }`
    fn tangents(&mut self, block: &'a Block, way: Way, way_at: Option<Span>, env: &Env<'a>) -> Option<Reached> {
        let mut failed = false;
        if way != Way::Hermite {
            let mut diagnostic = Diagnostic::new("E0616", "tangents need `interpolate: hermite`").primary(
                self.file(),
                block.span,
                "a key with tangents",
            );
            if let Some(at) = way_at {
                diagnostic = diagnostic.label(self.file(), at, "says otherwise");
            }
            self.report(diagnostic.help("write `keys(interpolate: hermite) { .. }`"));
            failed = true;
        }
        let mut found: [Option<(&'a Expr, Span)>; 3] = [None; 3];
        const NAMES: [&str; 3] = ["value", "in", "out"];
        for item in &block.items {
            let Item::Property(property) = item else {
                let diagnostic = Diagnostic::new("E0215", "a key holds `value`, `in` and `out` alone").primary(
                    self.file(),
                    item.span(),
                    "cannot be here",
                );
                self.report(diagnostic);
                failed = true;
                continue;
            };
            let name = &property.name;
            let Some(at) = NAMES.iter().position(|known| *known == &*name.text) else {
                let message = format!("unknown property `{}` of a key", name.text);
                let diagnostic =
                    Diagnostic::new("E0201", message).primary(self.file(), name.span, "not a property of a key");
                let diagnostic = match suggest(&name.text, NAMES).first() {
                    Some(near) => {
                        diagnostic.fix(Applicability::Safe, format!("write `{near}`"), self.file(), name.span, *near)
                    }
                    None => diagnostic.help("a key has `value`, `in` and `out`"),
                };
                self.report(diagnostic);
                failed = true;
                continue;
            };
            match found[at] {
                Some((_, first)) => {
                    let diagnostic = Diagnostic::new("E0206", format!("`{}` is set twice", name.text))
                        .primary(self.file(), name.span, "again")
                        .label(self.file(), first, "already set here")
                        .help("remove one of them");
                    self.report(diagnostic);
                    failed = true;
                }
                None => found[at] = Some((&property.value, name.span)),
            }
        }
        let [value, into, out] = found;
        let Some((value_expr, _)) = value else {
            if !failed {
                let diagnostic = Diagnostic::new("E0207", "a key needs `value`")
                    .primary(self.file(), block.span, "what is reached?")
                    .help("add `value: ..`");
                self.report(diagnostic);
            }
            return None;
        };
        let value = self.plain(value_expr, env);
        let slopes = [into, out].map(|slope| match slope {
            Some((expr, _)) => {
                let tangent = self.plain(expr, env);
                self.slope(&value, tangent, expr.span)
            }
            None => Some(level(&value)),
        });
        let [Some(into), Some(out)] = slopes else { return None };
        if failed || value.is_error() {
            return None;
        }
        Some(Reached { value, place: value_expr.span, tangents: Some(Box::new([into, out])) })
    }

    /// A tangent as what it adds to the value in a second.
    fn slope(&mut self, value: &Value, tangent: Value, span: Span) -> Option<Value> {
        let numbers = match &tangent {
            Value::Error => return None,
            Value::Number(number) => vec![*number],
            Value::Color(parts) => parts.map(|part| Number::new(part, Dimension::NONE)).to_vec(),
            other => other.numbers().map(|numbers| numbers.to_vec()).unwrap_or_default(),
        };
        let wanted = match value {
            Value::Error => return None,
            Value::Turn(_) => vec![Number::new(0.0, Dimension::ANGLE); 3],
            Value::Number(number) => vec![*number],
            Value::Color(_) => vec![Number::new(0.0, Dimension::NONE); 3],
            other => other.numbers().map(|numbers| numbers.to_vec()).unwrap_or_default(),
        };
        let of = wanted.iter().map(|number| number.dimension).find(|of| !of.is_none()).unwrap_or(Dimension::NONE);
        let dimensions: Option<Vec<Dimension>> = numbers.iter().map(|number| slope_of(of, number.dimension)).collect();
        let shape = wanted.len() == numbers.len() && !wanted.is_empty();
        let Some(dimensions) = dimensions.filter(|_| shape) else {
            let found = self.describe(&tangent);
            let mut diagnostic = Diagnostic::new("E0301", format!("expected a change a second, found {found}"))
                .primary(self.file(), span, format!("this is {found}"));
            diagnostic = match value {
                Value::Turn(_) => diagnostic.help("of a rotation it is how fast it turns: `(0, 90deg/s, 0)`"),
                _ => diagnostic.help(format!("of {} it is as much a second", self.describe(value))),
            };
            self.report(diagnostic);
            return None;
        };
        let bare = |number: &Number, to: &Dimension| to.is_none() && !number.is_bare_zero();
        let measured = of != Dimension::LENGTH && !of.is_none();
        if measured && numbers.iter().zip(&dimensions).any(|(number, to)| bare(number, to)) {
            self.needs_unit(of, numbers[0], span);
            return None;
        }
        let parts: Vec<Value> = numbers
            .iter()
            .zip(dimensions)
            .map(|(number, dimension)| Value::Number(Number { dimension, int: false, ..*number }))
            .collect();
        Some(match (value, parts.as_slice(), numbers.as_slice()) {
            (Value::Turn(q), _, [x, y, z]) => {
                let spin = [x.value, y.value, z.value];
                Value::Turn(spun(&mut self.graph, q, spin))
            }
            (Value::Color(_), _, [r, g, b]) => Value::Color([r.value, g.value, b.value]),
            (Value::Number(_), [one], _) => one.clone(),
            _ => Value::Tuple(parts.into()),
        })
    }

    fn key_options(&mut self, args: &'a [Arg]) -> Option<Options> {
        let mut options =
            Options { way: Way::Eased, outside: Outside::Hold, oklch: false, way_at: None, space_at: None };
        let mut fine = true;
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
                fine = false;
                continue;
            };
            let at = arg.value.span;
            let known = match &*name.text {
                "interpolate" => {
                    options.way_at = Some(at);
                    chosen(&WAYS, word).map(|way| options.way = way).ok_or(WAYS.map(|row| row.0).to_vec())
                }
                "outside" => chosen(&OUTSIDE, word)
                    .map(|outside| options.outside = outside)
                    .ok_or(OUTSIDE.map(|row| row.0).to_vec()),
                "space" => {
                    options.space_at = Some(at);
                    chosen(&SPACES, word).map(|oklch| options.oklch = oklch).ok_or(SPACES.map(|row| row.0).to_vec())
                }
                _ => {
                    let names = ["interpolate", "outside", "space"];
                    let mut diagnostic = Diagnostic::new("E0208", format!("`keys` has no parameter `{}`", name.text))
                        .primary(self.file(), name.span, "no such parameter");
                    diagnostic = match suggest(&name.text, names).first() {
                        Some(near) => {
                            let file = self.file();
                            diagnostic.fix(Applicability::Safe, format!("write `{near}`"), file, name.span, *near)
                        }
                        None => diagnostic.help(format!("it takes {}", any_of(names))),
                    };
                    self.report(diagnostic);
                    fine = false;
                    continue;
                }
            };
            let Err(words) = known else { continue };
            let message = format!("expected {}, found `{word}`", any_of(words.iter().copied()));
            let mut diagnostic =
                Diagnostic::new("E0301", message).primary(self.file(), at, format!("not an `{}` of `keys`", name.text));
            if let Some(near) = suggest(word, words.iter().copied()).first() {
                let file = self.file();
                diagnostic = diagnostic.fix(Applicability::Safe, format!("write `{near}`"), file, at, *near);
            }
            self.report(diagnostic);
            fine = false;
        }
        fine.then_some(options)
    }

    fn key_time(&mut self, key: &'a ast::Key, previous: Option<(f64, Span)>, env: &Env<'a>) -> Option<f64> {
        let span = key.time.span;
        let value = self.plain(&key.time, env);
        let time = match value {
            Value::Error => return None,
            Value::Number(number) if number.dimension == Dimension::TIME || number.is_bare_zero() => number.value,
            Value::Number(number) if number.dimension.is_none() => {
                self.needs_unit(Dimension::TIME, number, key.time.span);
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
        if !value.is_key() {
            let found = self.describe(value);
            let message = match first {
                Some(_) => "keys have different types".to_string(),
                None => format!("keys cannot hold {found}"),
            };
            let mut diagnostic = Diagnostic::new("E0606", message)
                .primary(self.file(), span, format!("this is {found}"))
                .help(match value {
                    Value::Node(_) => "keys hold values: animate a share, as in `mix(a, b, amount: keys { .. })`",
                    _ => "keys hold numbers, vectors, colours, rotations, `true` and `false`",
                });
            if let Some(first) = first {
                let first_is = format!("the first key is {}", self.describe(&first.value));
                diagnostic = diagnostic.label(self.file(), first.span, first_is);
            }
            self.report(diagnostic);
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
                let is_fn = |binding: &Binding<'_>| matches!(binding, Binding::Fn(_));
                if let Some((scope, Binding::Fn(decl), names)) = env.find_path(&path.segments, is_fn) {
                    return match names == path.segments.len() {
                        true => self.own_ease(decl, &scope, expr.span, env),
                        false => None,
                    };
                }
                // What a module does not have is said where names are looked up.
                if path.segments.len() > 1 {
                    return None;
                }
                if let Some(found) = ease::named(name) {
                    return Some(found);
                }
                let one = |function: &&builtin::Builtin| {
                    function.rest.is_none() && function.params.iter().filter(|param| !param.optional).count() == 1
                };
                if let Some(function) = builtin::find(name).filter(one) {
                    return self.built_in_ease(function, expr.span);
                }
                let mut diagnostic = Diagnostic::new("E0609", format!("no easing `{}`", short_name(name))).primary(
                    self.file(),
                    expr.span,
                    "not an easing",
                );
                diagnostic = match ease::nearest(name) {
                    Some(near) => {
                        let file = self.file();
                        diagnostic.fix(Applicability::Safe, format!("write `{near}`"), file, expr.span, near)
                    }
                    None => diagnostic.help("for example `linear`, `step`, `ease_in_out` or `out_cubic`"),
                };
                self.report(diagnostic);
                None
            }
            ExprKind::Call { callee, args } => match self.text(callee.span) {
                "bezier" => self.bezier(args, expr.span, env),
                "steps" => self.steps(args, expr.span, env),
                "spring" => self.spring(args, expr.span, env),
                name => {
                    let name = short_name(name);
                    let diagnostic = Diagnostic::new("E0609", format!("no easing `{name}`")).primary(
                        self.file(),
                        callee.span,
                        "not an easing",
                    );
                    let diagnostic = match self.is_function(callee, env) {
                        true => diagnostic.help(format!("a function is named alone: `ease {name}`")),
                        false => diagnostic.help(
                            "curves with arguments are `bezier(x1, y1, x2, y2)`, `steps(n, jump_end)` and \
                             `spring(mass, stiffness, damping)`",
                        ),
                    };
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

    fn is_function(&self, callee: &Expr, env: &Env<'a>) -> bool {
        let ExprKind::Path(path) = &callee.kind else { return false };
        env.find_path(&path.segments, |binding| matches!(binding, Binding::Fn(_))).is_some()
    }

    /// A function of the scene, given the part of the time that has passed.
    fn own_ease(&mut self, decl: &'a ast::FnDecl, scope: &Env<'a>, span: Span, env: &Env<'a>) -> Option<Ease> {
        let name = decl.name.as_ref().map_or("", |name| &name.text);
        let needed = decl.params.iter().skip(1).filter(|param| param.default.is_none()).count();
        if decl.params.is_empty() || needed > 0 {
            let takes = match decl.params.len() {
                0 => "nothing".to_string(),
                count => format!("{count} values"),
            };
            let diagnostic = Diagnostic::new("E0615", format!("an easing takes one number, `{name}` takes {takes}"))
                .primary(self.file(), span, "not an easing")
                .label(self.file(), decl.head, "declared here")
                .help("write a function of one number: how much of the time has passed, 0 to 1");
            self.report(diagnostic);
            return None;
        }
        let input = Value::number(self.graph.input());
        let first = Argument { value: input, expr: None, span };
        let given = std::iter::once(Some(first)).chain(decl.params.iter().skip(1).map(|_| None)).collect();
        let result = self.run_fn(decl, scope, given, span, env);
        self.as_ease(name, result, span, Some(decl.head))
    }

    fn built_in_ease(&mut self, function: &'static builtin::Builtin, span: Span) -> Option<Ease> {
        let mut given: builtin::Given = function.params.iter().map(|_| (None, span)).collect();
        if let Some(at) = function.params.iter().position(|param| !param.optional) {
            given[at].0 = Some(Value::number(self.graph.input()));
        }
        let mut call = Call::new(&mut self.graph, function, given, builtin::More::new(), self.source.id, span);
        let value = (function.run)(&mut call);
        let problems = std::mem::take(&mut call.problems);
        for problem in problems {
            self.report(problem);
        }
        self.as_ease(function.name, value, span, None)
    }

    /// The result of a function as an easing: a number that depends on nothing but the function's argument.
    fn as_ease(&mut self, name: &str, result: Value, span: Span, head: Option<Span>) -> Option<Ease> {
        let result = self.flatten(result);
        let wrong = |machine: &mut Self, message: String, label: String, help: &str| {
            let mut diagnostic = Diagnostic::new("E0615", message).primary(machine.file(), span, label);
            if let Some(head) = head {
                diagnostic = diagnostic.label(machine.file(), head, "declared here");
            }
            machine.report(diagnostic.help(help));
            None
        };
        let number = match &result {
            Value::Error => return None,
            Value::Number(number) if number.dimension.is_none() => number.value,
            other => {
                let found = self.describe(other);
                let message = format!("an easing gives a plain number, `{name}` gives {found}");
                return wrong(self, message, format!("gives {found}"), "0 is the value before, 1 the value reached");
            }
        };
        let tape = self.graph.tape(&[number]);
        let on = tape.code.iter().find_map(|instruction| match instruction {
            Instruction::Time => Some("`time`"),
            Instruction::Frame => Some("`frame`"),
            Instruction::Keys(_) | Instruction::Turn(..) => Some("keys"),
            Instruction::Point(..) => Some("the point of a surface"),
            _ => None,
        });
        if let Some(on) = on {
            let message = format!("`{name}` depends on {on}, not on its argument alone");
            let help = "an easing is a function of how much of the time has passed, 0 to 1";
            return wrong(self, message, format!("depends on {on}"), help);
        }
        Some(Ease::Function(Arc::new(tape)))
    }

    /// `spring(mass, stiffness, damping)`, its frequency in radians a second.
    fn spring(&mut self, args: &'a [Arg], span: Span, env: &Env<'a>) -> Option<Ease> {
        if args.len() != 3 {
            self.arity("spring", "3 values", args.len(), span, "spring(mass, stiffness, damping)");
            return None;
        }
        let of = [Dimension::MASS, Dimension::STIFFNESS, Dimension::DAMPING];
        let names = ["mass", "stiffness", "damping"];
        let mut numbers = [0.0; 3];
        let mut fine = true;
        for (i, arg) in args.iter().enumerate() {
            let Some(number) = self.ease_quantity(&arg.value, of[i], env) else {
                fine = false;
                continue;
            };
            let (least, fits) = if i == 2 { ("at least 0", number >= 0.0) } else { ("greater than 0", number > 0.0) };
            if !fits {
                fine = false;
                let found = self.computed("this is", number, of[i], arg.value.span);
                let diagnostic = Diagnostic::new("E0401", format!("{} must be {least}", names[i])).primary(
                    self.file(),
                    arg.value.span,
                    found,
                );
                self.report(diagnostic);
            }
            numbers[i] = number;
        }
        let [mass, stiffness, damping] = numbers;
        let frequency = (stiffness / mass).sqrt();
        fine.then(|| Ease::Spring(Spring { frequency, damping: damping / (2.0 * (stiffness * mass).sqrt()) }))
    }

    fn ease_number(&mut self, expr: &'a Expr, env: &Env<'a>) -> Option<f64> {
        self.ease_quantity(expr, Dimension::NONE, env)
    }

    /// A constant, plain or of this dimension.
    fn ease_quantity(&mut self, expr: &'a Expr, of: Dimension, env: &Env<'a>) -> Option<f64> {
        match self.plain(expr, env) {
            Value::Error => None,
            Value::Number(Number { value: Scalar::Const(value), dimension, .. })
                if (dimension.is_none() || dimension == of) && value.is_finite() =>
            {
                Some(value)
            }
            other => {
                let found = self.describe(&other);
                let wanted = match of.is_none() {
                    true => "a plain number".to_string(),
                    false => format!("a plain number or {}", of.with_article()),
                };
                let diagnostic = Diagnostic::new("E0301", format!("expected {wanted}, found {found}")).primary(
                    self.file(),
                    expr.span,
                    "not a constant number of that kind",
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

/// The row of this name.
fn chosen<T: Copy>(rows: &[(&str, T)], word: &str) -> Option<T> {
    rows.iter().find(|row| row.0 == word).map(|row| row.1)
}

/// No change, of a value like this one.
fn level(value: &Value) -> Value {
    let zero = Scalar::Const(0.0);
    match value {
        Value::Number(number) => Value::Number(Number { value: zero, int: false, ..*number }),
        Value::Color(_) => Value::Color([zero; 3]),
        Value::Turn(_) => Value::Turn([zero; 4]),
        Value::Tuple(items) => Value::Tuple(items.iter().map(level).collect()),
        other => other.clone(),
    }
}

fn short_name(name: &str) -> String {
    crate::eval::expr::short_text(name)
}
