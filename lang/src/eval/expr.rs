//! Expressions to values.

use std::rc::Rc;
use std::sync::Arc;

use kinora_scene::{Binary, Unary};
use smallvec::SmallVec;

use crate::builtin::{self, Call};
use crate::diagnostic::{Applicability, Diagnostic};
use crate::dimension::{self, Dimension};
use crate::eval::graph::Scalar;
use crate::eval::limits;
use crate::eval::machine::{Given, Machine};
use crate::eval::scope::{Binding, LetCell, LetState, Scope};
use crate::schema::{self, Choice};
use crate::source::Span;
use crate::syntax::ast::{self, BinaryOp, Expr, ExprKind, UnaryOp};
use crate::value::{Number, Value};

/// The words that are values where the expression stands.
pub type Words = &'static [Choice];

/// A scope, shared.
pub type Env<'a> = Rc<Scope<'a>>;

/// A value given to a parameter.
pub struct Argument<'a> {
    /// The value.
    pub value: Value,
    /// What is written for it; nothing where a node is `like` another.
    pub expr: Option<&'a Expr>,
    /// Where.
    pub span: Span,
}

impl<'a> Machine<'a> {
    /// The value of an expression.
    pub fn expr(&mut self, expr: &'a Expr, env: &Env<'a>, words: Words) -> Value {
        // What is written out or named takes no step of its own: the operation that it is for takes one.
        let cost = match &expr.kind {
            ExprKind::Number(number) => {
                let value = self.literal(number, expr.span);
                return self.watched.see(expr.span, value);
            }
            ExprKind::Color(_) | ExprKind::Str(_) | ExprKind::Bool(_) => {
                let value = self.expr_inside(expr, env, words);
                return self.watched.see(expr.span, value);
            }
            ExprKind::Path(path) => match path.segments.as_slice() {
                [name] if words.is_empty() => match env.value(&name.text) {
                    Some(value) => return self.watched.see(expr.span, value),
                    None => 0,
                },
                _ => 0,
            },
            ExprKind::Tuple(items) | ExprKind::List(items) => 1 + items.len() as u64 / 4,
            ExprKind::Binary { rest, .. } => rest.len() as u64,
            // The function takes one more.
            ExprKind::Call { args, .. } => args.len() as u64 / 4,
            _ => 1,
        };
        if !self.enter(cost, expr.span) {
            return Value::Error;
        }
        let value = self.expr_inside(expr, env, words);
        self.leave();
        self.watched.see(expr.span, value)
    }

    fn expr_inside(&mut self, expr: &'a Expr, env: &Env<'a>, words: Words) -> Value {
        match &expr.kind {
            ExprKind::Missing => Value::Error,
            ExprKind::Number(number) => self.literal(number, expr.span),
            ExprKind::Color([r, g, b, alpha]) => {
                if *alpha != 255 {
                    let diagnostic = Diagnostic::new("W0315", "the alpha of a colour has no effect")
                        .primary(self.file(), expr.span, "the last two digits")
                        .help("what lets light pass is a material's `opacity`")
                        .fix(Applicability::Safe, "leave it out", self.file(), expr.span, &self.text(expr.span)[..7]);
                    self.report(diagnostic);
                }
                Value::Color([*r, *g, *b].map(|c| builtin::srgb_to_linear(f64::from(c) / 255.0).into()))
            }
            ExprKind::Str(text) => Value::Text(text.clone()),
            ExprKind::Bool(value) => Value::Bool(f64::from(u8::from(*value)).into()),
            ExprKind::Path(path) => self.path(path, env, words),
            ExprKind::Tuple(items) => self.tuple(items, env),
            ExprKind::List(items) => self.list(items, env),
            ExprKind::Comp(comp) => self.comprehension(comp, expr.span, env),
            ExprKind::Unary { op, op_span, value } => {
                let operand = self.plain(value, env);
                self.unary(*op, *op_span, operand, value.span)
            }
            ExprKind::Binary { first, rest } => self.chain(first, rest, env),
            ExprKind::Call { callee, args } => self.call(callee, args, expr.span, env),
            ExprKind::Field { base, name } => {
                let base_value = self.expr(base, env, &[]);
                self.field(base_value, base.span, name)
            }
            ExprKind::Index { base, index } => {
                let base_value = self.plain(base, env);
                let index_value = self.plain(index, env);
                self.index(base_value, base.span, index_value, index.span)
            }
            ExprKind::Node(node) => self.inline_node(node, env),
            ExprKind::Keys(keys) => self.keys(keys, expr.span, env),
            ExprKind::If(value) => self.if_value(value, expr.span, env, words),
        }
    }

    /// The value of an expression that something is computed with: keys become curves.
    pub fn plain(&mut self, expr: &'a Expr, env: &Env<'a>) -> Value {
        let value = self.expr(expr, env, &[]);
        self.flatten(value)
    }

    fn literal(&mut self, number: &ast::Number, span: Span) -> Value {
        if !number.value.is_finite() {
            let diagnostic = Diagnostic::new("E0410", "number is too large")
                .primary(self.file(), span, "more than a number can hold")
                .note("the largest number is about 1.8e308");
            return self.error(diagnostic);
        }
        let Some(unit) = &number.unit else {
            return match number.int {
                Some(_) if number.value.abs() <= limits::WHOLE => Value::Number(Number::int(number.value)),
                _ if number.whole => {
                    let diagnostic = Diagnostic::new("E0410", "number is too large")
                        .primary(self.file(), span, "whole numbers go up to 2^53")
                        .help("write it with a point, `1.0e16`, if it need not be exact");
                    self.error(diagnostic)
                }
                _ => Value::number(number.value),
            };
        };
        let Some((factor, of)) = unit.si else { return Value::Error };
        let mut value = number.value * factor;
        if unit.frames != 0 {
            match self.frames_per_second() {
                // Frame n is at n / fps, to the last bit.
                Some(fps) if unit.frames > 0 => value /= fps.powi(unit.frames),
                Some(fps) => value *= fps.powi(-unit.frames),
                None => {
                    let diagnostic = Diagnostic::new("E0610", "frame times need `render { fps }`")
                        .primary(self.file(), span, "how long is a frame?")
                        .help("add `render { fps: 24 }`");
                    return self.error(diagnostic);
                }
            }
        }
        Value::quantity(value, of)
    }

    fn path(&mut self, path: &'a ast::Path, env: &Env<'a>, words: Words) -> Value {
        let Some(first) = path.segments.first() else { return Value::Error };
        let name = &*first.text;
        if path.segments.len() == 1
            && let Some(word) = words.iter().find(|word| word.name == name)
        {
            return Value::Word(word.name);
        }
        let is_value =
            |binding: &Binding<'_>| !matches!(binding, Binding::Fn(_) | Binding::Prefab(_) | Binding::Module(_));
        let own = matches!(name, "time" | "frame") && env.find_path(&path.segments, is_value).is_some();
        let (mut value, names) = match name {
            // Declared anew, which is said there.
            _ if own => return Value::Error,
            "time" => (Value::quantity(self.graph.time(), Dimension::TIME), 1),
            "frame" => (Value::number(self.graph.frame()), 1),
            _ => match env.find_path(&path.segments, is_value) {
                Some((scope, Binding::Let(cell), names)) => (self.force_let(&cell, &scope), names),
                Some((_, Binding::Value(value), names)) => (value, names),
                Some((_, Binding::Node(id), names)) => (Value::Node(id), names),
                _ => match self.point(name) {
                    Some(value) => (value, 1),
                    None => return Value::Error,
                },
            },
        };
        let (known, fields) = path.segments.split_at(names);
        let mut span = first.span.to(known.last().unwrap_or(first).span);
        for field in fields {
            value = self.field(value, span, field);
            span = span.to(field.span);
        }
        value
    }

    /// The value of a `let`.
    pub fn force_let(&mut self, cell: &LetCell<'a>, scope: &Env<'a>) -> Value {
        let span = cell.name.map_or(cell.value.span, |name| name.span);
        let text = cell.name.map_or("", |name| &*name.text);
        let state = cell.state.borrow().clone();
        match state {
            LetState::Done(value) => value,
            LetState::Running => {
                self.cycle(text, span);
                Value::Error
            }
            LetState::Waiting => {
                *cell.state.borrow_mut() = LetState::Running;
                self.pending.push((text, span));
                let value = self.rooted(cell.value, scope, |machine| {
                    let value = machine.expr(cell.value, scope, &[]);
                    match cell.ty {
                        Some(ty) => machine.convert(value, ty, cell.value.span),
                        None => value,
                    }
                });
                self.pending.pop();
                *cell.state.borrow_mut() = LetState::Done(value.clone());
                value
            }
        }
    }

    /// Reports that what is declared at `span` depends on itself.
    pub fn cycle(&mut self, name: &str, span: Span) {
        let start = self.pending.iter().rposition(|(_, place)| *place == span).unwrap_or(0);
        let ring: Vec<(&str, Span)> = self.pending.iter().skip(start).copied().collect();
        let mut diagnostic = Diagnostic::new("E0213", format!("`{name}` depends on itself")).primary(
            self.file(),
            span,
            match ring.get(1) {
                Some((next, _)) => format!("`{name}` needs `{next}`"),
                None => format!("`{name}` needs `{name}`"),
            },
        );
        for (i, (here, place)) in ring.iter().enumerate().skip(1).take(6) {
            let next = ring.get(i + 1).map_or(name, |(next, _)| next);
            diagnostic = diagnostic.label(self.file(), *place, format!("`{here}` needs `{next}`"));
        }
        self.report(diagnostic.help("break the cycle"));
    }

    fn tuple(&mut self, items: &'a [Expr], env: &Env<'a>) -> Value {
        let values: Arc<[Value]> = items.iter().map(|item| self.plain(item, env)).collect();
        if values.iter().any(Value::is_error) {
            return Value::Error;
        }
        let value = Value::Tuple(values);
        if !self.fits(&value, items.first().map_or(Span::at(0), |item| item.span)) {
            return Value::Error;
        }
        if let Some(numbers) = value.numbers() {
            let mut measured = numbers.iter().map(|number| number.dimension).filter(|of| !of.is_none());
            let first = measured.next();
            if measured.any(|of| Some(of) != first) {
                let mut diagnostic = Diagnostic::new("E0307", "components have different dimensions");
                for (i, (item, number)) in items.iter().zip(&numbers).enumerate() {
                    let text = number.dimension.with_article();
                    diagnostic = match i {
                        0 => diagnostic.primary(self.file(), item.span, text),
                        _ => diagnostic.label(self.file(), item.span, text),
                    };
                }
                return self.error(diagnostic);
            }
        }
        in_metres(value)
    }

    fn list(&mut self, items: &'a [Expr], env: &Env<'a>) -> Value {
        let values: Vec<Value> = items.iter().map(|item| self.plain(item, env)).collect();
        let spans: Vec<Span> = items.iter().map(|item| item.span).collect();
        self.finish_list(values, |i| spans.get(i).copied().unwrap_or_default())
    }

    /// A list of what is given, if its items are of one type.
    fn finish_list(&mut self, values: Vec<Value>, place: impl Fn(usize) -> Span) -> Value {
        if values.iter().any(Value::is_error) {
            return Value::Error;
        }
        if values.len() > limits::LIST {
            return self.too_many("items in a list", limits::LIST, place(0));
        }
        if let Some(first) = values.first()
            && let Some(odd) = values.iter().position(|value| !same_type(first, value))
        {
            let diagnostic = Diagnostic::new("E0313", "list items have different types")
                .primary(self.file(), place(odd), format!("this is {}", self.describe(&values[odd])))
                .label(self.file(), place(0), format!("the first item is {}", self.describe(first)));
            return self.error(diagnostic);
        }
        let list = Value::List(values.into());
        if self.fits(&list, place(0)) { list } else { Value::Error }
    }

    /// Uses up the steps that a list or tuple costs; false where it is too large or too deep.
    fn fits(&mut self, value: &Value, span: Span) -> bool {
        match value.size(limits::LIST + 1, limits::NESTING) {
            Some(size) if size > limits::LIST + 1 => {
                self.too_many("items in a list", limits::LIST, span);
                false
            }
            Some(size) => self.step(size as u64 / 8, span),
            None => {
                let message = format!("lists are nested deeper than {} levels", limits::NESTING);
                let diagnostic = Diagnostic::new("E1004", message)
                    .primary(self.file(), span, "too deep here")
                    .help("make one long list of them");
                self.stop(diagnostic);
                false
            }
        }
    }

    /// E1004.
    pub fn too_many(&mut self, what: &str, limit: usize, span: Span) -> Value {
        let diagnostic = Diagnostic::new("E1004", format!("more than {} {what}", spaced(limit as f64)))
            .primary(self.file(), span, "made here")
            .help("make fewer of them");
        self.stop(diagnostic);
        Value::Error
    }

    fn comprehension(&mut self, comp: &'a ast::Comp, span: Span, env: &Env<'a>) -> Value {
        let mut values = Vec::new();
        let mut failed = false;
        let complete = self.each(&comp.head, env, "a list", |machine, scope| {
            if let Some(condition) = &comp.condition {
                match machine.condition(condition, scope) {
                    Some(Scalar::Const(0.0)) => return true,
                    Some(Scalar::Const(_)) => {}
                    Some(moving) => {
                        machine.structure("the length of a list", moving, condition.span, comp.head.span);
                        failed = true;
                        return false;
                    }
                    None => {
                        failed = true;
                        return false;
                    }
                }
            }
            let value = machine.plain(&comp.value, scope);
            failed |= value.is_error();
            values.push(value);
            !failed
        });
        if failed || !complete {
            return Value::Error;
        }
        let _ = span;
        self.finish_list(values, |_| comp.value.span)
    }

    /// The value of a condition as a number, if it is one.
    pub fn condition(&mut self, expr: &'a Expr, env: &Env<'a>) -> Option<Scalar> {
        self.rooted(expr, env, |machine| machine.truth(expr, env))
    }

    fn truth(&mut self, expr: &'a Expr, env: &Env<'a>) -> Option<Scalar> {
        match self.plain(expr, env) {
            Value::Bool(scalar) => Some(scalar),
            Value::Error => None,
            value => {
                let mut diagnostic = Diagnostic::new("E0311", "a condition must be true or false").primary(
                    self.file(),
                    expr.span,
                    format!("this is {}", self.describe(&value)),
                );
                if matches!(value, Value::Number(_)) {
                    diagnostic = diagnostic.help(format!("compare it: `{} > 0`", self.text(expr.span)));
                }
                self.report(diagnostic);
                None
            }
        }
    }

    fn if_value(&mut self, value: &'a ast::IfValue, span: Span, env: &Env<'a>, words: Words) -> Value {
        let mut arms: Vec<(Scalar, Value, Span)> = Vec::new();
        let mut last = None;
        for (condition, arm) in &value.arms {
            match self.condition(condition, env) {
                None => return Value::Error,
                Some(Scalar::Const(0.0)) => {}
                Some(Scalar::Const(_)) => {
                    last = Some((self.expr(arm, env, words), arm.span));
                    break;
                }
                Some(moving) => arms.push((moving, self.plain(arm, env), arm.span)),
            }
        }
        let (mut result, mut place) = match last {
            Some(last) => last,
            None => (self.expr(&value.otherwise, env, words), value.otherwise.span),
        };
        if !arms.is_empty() {
            result = self.flatten(result);
        }
        while let Some((condition, yes, yes_span)) = arms.pop() {
            if yes.is_error() || result.is_error() {
                return Value::Error;
            }
            match self.select(condition, &yes, &result) {
                Some(chosen) => result = chosen,
                None if same_type(&yes, &result) => {
                    self.structure(&format!("the choice of {}", self.describe(&yes)), condition, span, span);
                    return Value::Error;
                }
                None => {
                    let diagnostic = Diagnostic::new("E0312", "`if` arms have different types")
                        .primary(self.file(), place, format!("this is {}", self.describe(&result)))
                        .label(self.file(), yes_span, format!("this is {}", self.describe(&yes)));
                    return self.error(diagnostic);
                }
            }
            place = yes_span;
        }
        result
    }

    /// `yes` or `no`, component by component; `None` where that cannot be.
    fn select(&mut self, condition: Scalar, yes: &Value, no: &Value) -> Option<Value> {
        if yes == no {
            return Some(yes.clone());
        }
        let graph = &mut self.graph;
        Some(match (yes, no) {
            (Value::Number(a), Value::Number(b)) => {
                let dimension = common(a, b)?;
                Value::Number(Number {
                    value: graph.select(condition, a.value, b.value),
                    dimension,
                    int: a.int && b.int,
                })
            }
            (Value::Bool(a), Value::Bool(b)) => Value::Bool(graph.select(condition, *a, *b)),
            (Value::Color(a), Value::Color(b)) => Value::Color([0, 1, 2].map(|i| graph.select(condition, a[i], b[i]))),
            (Value::Turn(a), Value::Turn(b)) => Value::Turn([0, 1, 2, 3].map(|i| graph.select(condition, a[i], b[i]))),
            (Value::Tuple(a), Value::Tuple(b)) if a.len() == b.len() => {
                let items: Option<Vec<Value>> =
                    a.iter().zip(b.iter()).map(|(a, b)| self.select(condition, &met(a, b), &met(b, a))).collect();
                Value::Tuple(items?.into())
            }
            _ => return None,
        })
    }

    fn chain(&mut self, first: &'a Expr, rest: &'a [ast::Step], env: &Env<'a>) -> Value {
        let mut left = self.plain(first, env);
        let mut place = first.span;
        for step in rest {
            // A known left side decides `&&` and `||` alone: the right one may be what it guards.
            match (step.op, &left) {
                (BinaryOp::And, Value::Bool(Scalar::Const(0.0))) => return left,
                (BinaryOp::Or, Value::Bool(Scalar::Const(value))) if *value != 0.0 => return left,
                _ => {}
            }
            let right = self.plain(&step.value, env);
            left = self.binary(step.op, step.op_span, (left, place), (right, step.value.span));
            place = place.to(step.value.span);
        }
        left
    }

    fn call(&mut self, callee: &'a Expr, args: &'a [ast::Arg], span: Span, env: &Env<'a>) -> Value {
        let ExprKind::Path(path) = &callee.kind else { return Value::Error };
        let is_fn = |binding: &Binding<'_>| matches!(binding, Binding::Fn(_));
        if let Some((scope, Binding::Fn(decl), names)) = env.find_path(&path.segments, is_fn) {
            return match names == path.segments.len() {
                true => self.call_fn(decl, &scope, args, span, env),
                false => Value::Error,
            };
        }
        let [name] = path.segments.as_slice() else { return Value::Error };
        let Some(function) = builtin::find(&name.text) else { return Value::Error };
        let mut given: builtin::Given = function.params.iter().map(|_| (None, span)).collect();
        let mut written: SmallVec<[Option<&'a Expr>; 4]> = function.params.iter().map(|_| None).collect();
        let mut more = builtin::More::new();
        for (i, arg) in args.iter().enumerate() {
            let at = match &arg.name {
                Some(name) => function.params.iter().position(|param| param.name == &*name.text),
                None if i < function.params.len() && !(function.rest.is_some() && i >= function.fixed()) => Some(i),
                None => None,
            };
            let words = at.and_then(|at| function.params.get(at)).map_or(&[][..], |param| param.words);
            let value = self.expr(&arg.value, env, words);
            let value = self.flatten(value);
            if value.is_error() {
                return Value::Error;
            }
            match at.and_then(|at| Some((given.get_mut(at)?, written.get_mut(at)?))) {
                Some((slot, expr)) => (*slot, *expr) = ((Some(value), arg.value.span), Some(&arg.value)),
                None => more.push((value, arg.value.span)),
            }
        }
        if function.name == schema::MIX.name
            && let [(Some(a), _), (Some(b), _), (Some(amount), _)] = given.as_slice()
            && let [Some(at_a), Some(at_b), Some(at_amount)] = *written.as_slice()
            && (matches!(a, Value::Node(_)) || matches!(b, Value::Node(_)))
        {
            return self.mix([(a.clone(), at_a), (b.clone(), at_b), (amount.clone(), at_amount)], span, env);
        }
        let arguments = given.iter().filter_map(|given| given.0.as_ref()).chain(more.iter().map(|given| &given.0));
        let size: usize = arguments.map(|value| value.size(limits::LIST, limits::NESTING).unwrap_or(0)).sum();
        if !self.step(1 + size as u64 / 4, span) {
            return Value::Error;
        }
        let missing = |(param, given): (&builtin::Param, &(Option<Value>, Span))| !param.optional && given.0.is_none();
        if function.params.iter().zip(&given).any(missing) {
            return Value::Error;
        }
        let mut call = Call::new(&mut self.graph, function, given, more, self.source.id, span);
        let before = call.finite_arguments();
        let value = (function.run)(&mut call);
        let finite = !before || call.finite(&value);
        let work = std::mem::take(&mut call.graph.work);
        let problems = std::mem::take(&mut call.problems);
        let bare = std::mem::take(&mut call.bare);
        if !self.step(work, span) {
            return Value::Error;
        }
        if !finite {
            self.not_finite = Some(span);
        }
        for problem in problems {
            self.report(problem);
        }
        for (index, number, dimension) in bare {
            let place = written.get(index).copied().flatten().map_or(span, |expr| expr.span);
            let diagnostic = self.without_unit(dimension, number, place);
            self.report(diagnostic.note(format!("`{}` takes {}", function.name, dimension.with_article())));
        }
        value
    }

    fn call_fn(
        &mut self,
        decl: &'a ast::FnDecl,
        scope: &Env<'a>,
        args: &'a [ast::Arg],
        span: Span,
        env: &Env<'a>,
    ) -> Value {
        if self.endless.contains(&decl.head) {
            return Value::Error;
        }
        let given = self.arguments(&decl.params, args, env);
        self.run_fn(decl, scope, given, span, env)
    }

    /// What a function gives for these arguments, given from `env`.
    pub fn run_fn(
        &mut self,
        decl: &'a ast::FnDecl,
        scope: &Env<'a>,
        given: Vec<Option<Argument<'a>>>,
        span: Span,
        env: &Env<'a>,
    ) -> Value {
        let name = decl.name.as_ref().map_or("", |name| &name.text);
        let Some((inner, given)) = self.bind(&decl.params, given, scope, env) else { return Value::Error };
        if self.calls >= limits::CALLS {
            self.endless.insert(decl.head);
            let diagnostic =
                Diagnostic::new("E1001", format!("`{name}` calls itself more than {} times", limits::CALLS))
                    .primary(self.file(), span, "one call too many")
                    .label(self.file(), decl.head, "declared here")
                    .help("add a condition that stops it");
            return self.error(diagnostic);
        }
        self.calls += 1;
        let result = self.traced(Some(name), span, given, env, |machine| match &decl.body {
            ast::FnBody::Missing => Value::Error,
            ast::FnBody::Value(body) => machine.rooted(body, &inner, |machine| {
                let value = machine.expr(body, &inner, &[]);
                match &decl.result {
                    Some(ty) => machine.convert(value, ty, body.span),
                    None => value,
                }
            }),
            ast::FnBody::Block(block) => match machine.run_function(&block.items, &inner) {
                Some(value) => value,
                None => {
                    let diagnostic = Diagnostic::new("E0207", format!("`{name}` needs a `return`"))
                        .primary(machine.file(), decl.head, "ends without a value")
                        .help("add `return ...`");
                    machine.error(diagnostic)
                }
            },
        });
        self.calls -= 1;
        match (&decl.result, &decl.body) {
            (Some(ty), ast::FnBody::Block(_)) => self.convert(result, ty, span),
            _ => result,
        }
    }

    fn arguments(
        &mut self,
        formals: &'a [ast::Formal],
        args: &'a [ast::Arg],
        env: &Env<'a>,
    ) -> Vec<Option<Argument<'a>>> {
        let mut given: Vec<Option<Argument<'a>>> = formals.iter().map(|_| None).collect();
        for (i, arg) in args.iter().enumerate() {
            let at = match &arg.name {
                Some(name) => formals.iter().position(|formal| formal.name.text == name.text),
                None => Some(i),
            };
            let value = self.expr(&arg.value, env, &[]);
            if let Some(slot) = at.and_then(|at| given.get_mut(at)) {
                *slot = Some(Argument { value, expr: Some(&arg.value), span: arg.value.span });
            }
        }
        given
    }

    /// A scope with the parameters in it, given from `env`; `None` where one is missing (the resolver reports that).
    pub fn bind(
        &mut self,
        formals: &'a [ast::Formal],
        given: Vec<Option<Argument<'a>>>,
        scope: &Env<'a>,
        env: &Env<'a>,
    ) -> Option<(Env<'a>, Vec<Given<'a>>)> {
        let inner = Scope::of_turn(scope);
        let mut named = Vec::with_capacity(formals.len());
        for (formal, given) in formals.iter().zip(given) {
            let (given, env) = match (given, &formal.default) {
                (Some(given), _) => (given, env),
                (None, Some(default)) => {
                    let value = self.rooted(default, &inner, |machine| machine.expr(default, &inner, &[]));
                    (Argument { value, expr: Some(default), span: default.span }, &inner)
                }
                (None, None) => return None,
            };
            let Argument { value, expr, span } = given;
            let value = match (&formal.ty, expr) {
                (Some(ty), Some(expr)) => self.rooted(expr, env, |machine| machine.convert(value, ty, span)),
                (Some(ty), None) => self.convert(value, ty, span),
                (None, _) => value,
            };
            let name = &*formal.name.text;
            named.push(Given { name, value: value.clone(), expr: expr.filter(|_| !Rc::ptr_eq(env, &inner)) });
            inner.declare(name, Binding::Value(value));
        }
        Some((inner, named))
    }

    fn field(&mut self, value: Value, span: Span, name: &'a ast::Name) -> Value {
        if value.is_error() {
            return Value::Error;
        }
        if let Value::Node(id) = value {
            return self.node_field(id, span, name);
        }
        let value = self.flatten(value);
        let letters = &*name.text;
        let pick = |letter: char, sets: &[&str], count: usize| {
            sets.iter().find_map(|set| set.chars().take(count).position(|known| known == letter))
        };
        let (parts, sets, what): (Vec<Value>, &[&str], String) = match &value {
            Value::Tuple(items) => (items.to_vec(), &["xyzw", "rgba", "uv"], format!("vec{}", items.len())),
            Value::Color(channels) => {
                (channels.iter().map(|channel| Value::number(*channel)).collect(), &["rgb"], "color".into())
            }
            Value::Turn(q) => (q.iter().map(|part| Value::number(*part)).collect(), &["xyzw"], "quat".into()),
            other => {
                let what = self.describe(other);
                let diagnostic = Diagnostic::new("E0214", format!("{what} has no fields"))
                    .primary(self.file(), name.span, "no such field")
                    .label(self.file(), span, format!("this is {what}"));
                return self.error(diagnostic);
            }
        };
        let picked: Option<Vec<Value>> =
            letters.chars().take(5).map(|letter| pick(letter, sets, parts.len()).map(|i| parts[i].clone())).collect();
        match picked {
            Some(mut picked) if picked.len() == 1 => picked.pop().unwrap_or(Value::Error),
            Some(picked) if (2..=4).contains(&picked.len()) => Value::Tuple(picked.into()),
            _ => {
                let list = |set: &&str| set.chars().take(parts.len()).map(String::from).collect::<Vec<_>>().join(" ");
                let has = sets.iter().map(list).collect::<Vec<_>>().join(", ");
                let diagnostic = Diagnostic::new("E0214", format!("`{what}` has no field `{letters}`"))
                    .primary(self.file(), name.span, "no such field")
                    .help(format!("it has {has}"));
                self.error(diagnostic)
            }
        }
    }

    fn index(&mut self, base: Value, base_span: Span, index: Value, span: Span) -> Value {
        if base.is_error() || index.is_error() {
            return Value::Error;
        }
        let count = match &base {
            Value::List(items) | Value::Tuple(items) => items.len(),
            Value::Range(from, to) => match (from.value.constant(), to.value.constant()) {
                (Some(from), Some(to)) => (to - from).max(0.0).ceil() as usize,
                _ => 0,
            },
            other => {
                let diagnostic = Diagnostic::new("E0301", format!("expected a list, found {}", self.describe(other)))
                    .primary(self.file(), base_span, "only lists and vectors have items");
                return self.error(diagnostic);
            }
        };
        let Some(number) = self.whole(&index, span) else { return Value::Error };
        let Scalar::Const(at) = number else {
            self.structure("the choice of an item", number, span, span);
            return Value::Error;
        };
        if at >= 0.0 && at < count as f64 {
            return match &base {
                Value::List(items) | Value::Tuple(items) => items.get(at as usize).cloned().unwrap_or(Value::Error),
                Value::Range(from, _) => {
                    Value::Number(Number::int(from.value.constant().map_or(0.0, |from| from.trunc() + at)))
                }
                _ => Value::Error,
            };
        }
        let plural = if count == 1 { "" } else { "s" };
        let mut diagnostic = Diagnostic::new("E0409", format!("list has {count} item{plural}, index {at}"))
            .primary(self.file(), span, "there is no such item")
            .label(self.file(), base_span, format!("{count} item{plural}"));
        if count == 1 {
            diagnostic = diagnostic.help("the only item is 0");
        } else if count > 1 {
            diagnostic = diagnostic.help(format!("items are 0..{}", count - 1));
        }
        self.error(diagnostic)
    }

    /// A whole number; E0310 and E0301.
    pub fn whole(&mut self, value: &Value, span: Span) -> Option<Scalar> {
        match value {
            Value::Error => None,
            Value::Number(number) if number.dimension.is_none() => match number.value {
                Scalar::Const(value) if value.fract() != 0.0 || !value.is_finite() => {
                    let found = self.computed("found", value, Dimension::NONE, span);
                    let diagnostic = Diagnostic::new("E0310", "expected a whole number")
                        .primary(self.file(), span, found)
                        .help("use `floor()` or `round()`");
                    self.report(diagnostic);
                    None
                }
                value => Some(value),
            },
            other => {
                let found = self.describe(other);
                let diagnostic = Diagnostic::new("E0301", format!("expected a whole number, found {found}")).primary(
                    self.file(),
                    span,
                    format!("this is {found}"),
                );
                self.report(diagnostic);
                None
            }
        }
    }

    /// A label for a number: as written, or with what it came to.
    pub fn computed(&self, verb: &str, value: f64, of: Dimension, span: Span) -> String {
        let written = self.text(span);
        if written.starts_with(|c: char| c.is_ascii_digit() || c == '-')
            && !written.contains([' ', '(', '+', '*'])
            && written.len() < 24
        {
            format!("{verb} {written}")
        } else {
            format!("{verb} {}", dimension::show(value, of))
        }
    }

    fn unary(&mut self, op: UnaryOp, op_span: Span, value: Value, span: Span) -> Value {
        let graph = &mut self.graph;
        match (op, &value) {
            (_, Value::Error) => Value::Error,
            (UnaryOp::Neg, Value::Number(number)) => {
                Value::Number(Number { value: graph.unary(Unary::Neg, number.value), ..*number })
            }
            (UnaryOp::Not, Value::Bool(scalar)) => Value::Bool(graph.unary(Unary::Not, *scalar)),
            (UnaryOp::Neg, Value::Tuple(_)) if value.numbers().is_some() => {
                let numbers = value.numbers().unwrap_or_default();
                let negated = numbers
                    .into_iter()
                    .map(|number| Value::Number(Number { value: graph.unary(Unary::Neg, number.value), ..number }));
                Value::Tuple(negated.collect())
            }
            _ => {
                let sign = if op == UnaryOp::Neg { "-" } else { "!" };
                let found = self.describe(&value);
                let diagnostic = Diagnostic::new("E0314", format!("`{sign}` does not apply to {found}"))
                    .primary(self.file(), op_span, "cannot be applied")
                    .label(self.file(), span, format!("this is {found}"));
                self.error(diagnostic)
            }
        }
    }

    /// Reports what is not finite about a result; the result, or an error.
    fn checked(&mut self, value: Scalar, finite_before: bool, span: Span) -> Option<Scalar> {
        match value {
            Scalar::Const(value) if value.is_infinite() && finite_before => {
                let diagnostic = Diagnostic::new("E0410", "number is too large")
                    .primary(self.file(), span, "more than a number can hold")
                    .note("the largest number is about 1.8e308");
                self.report(diagnostic);
                None
            }
            Scalar::Const(value) if value.is_nan() && finite_before => {
                self.not_finite = Some(span);
                Some(Scalar::Const(value))
            }
            value => Some(value),
        }
    }

    fn binary(&mut self, op: BinaryOp, op_span: Span, left: (Value, Span), right: (Value, Span)) -> Value {
        let (a, b) = (&left.0, &right.0);
        if a.is_error() || b.is_error() {
            return Value::Error;
        }
        let span = left.1.to(right.1);
        if matches!(a, Value::List(_) | Value::Tuple(_))
            && !self.step(a.size(limits::LIST, limits::NESTING).unwrap_or(0) as u64 / 4, span)
        {
            return Value::Error;
        }
        let result = match (op, a, b) {
            (BinaryOp::And | BinaryOp::Or, Value::Bool(x), Value::Bool(y)) => {
                let op = if op == BinaryOp::And { Binary::And } else { Binary::Or };
                Some(Value::Bool(self.graph.binary(op, *x, *y)))
            }
            (BinaryOp::Eq | BinaryOp::Ne, _, _) => self.equal(a, b).map(|equal| {
                let equal = if op == BinaryOp::Ne { self.graph.unary(Unary::Not, equal) } else { equal };
                Value::Bool(equal)
            }),
            (BinaryOp::Range, Value::Number(x), Value::Number(y)) if common(x, y).is_some() => {
                Some(Value::Range(*x, *y))
            }
            (BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge, Value::Number(x), Value::Number(y))
                if common(x, y).is_some() =>
            {
                let (x, y) = (x.value, y.value);
                Some(Value::Bool(match op {
                    BinaryOp::Lt => self.graph.binary(Binary::Less, x, y),
                    BinaryOp::Le => self.graph.binary(Binary::LessEqual, x, y),
                    BinaryOp::Gt => self.graph.binary(Binary::Less, y, x),
                    _ => self.graph.binary(Binary::LessEqual, y, x),
                }))
            }
            (BinaryOp::Add, Value::Text(x), Value::Text(y)) => {
                if x.len() + y.len() > limits::TEXT {
                    return self.too_many("bytes in a text", limits::TEXT, span);
                }
                Some(Value::Text(format!("{x}{y}").into()))
            }
            (BinaryOp::Add, Value::List(x), Value::List(y)) => {
                if x.len() + y.len() > limits::LIST {
                    return self.too_many("items in a list", limits::LIST, span);
                }
                if !self.step((x.len() + y.len()) as u64 / 8, span) {
                    return Value::Error;
                }
                let values = x.iter().chain(y.iter()).cloned().collect();
                return self.finish_list(values, |_| span);
            }
            (BinaryOp::Mul, Value::Turn(x), Value::Turn(y)) => {
                Some(Value::Turn(builtin::turn_after(&mut self.graph, x, y)))
            }
            (BinaryOp::Mul, Value::Turn(q), Value::Tuple(_)) if b.numbers().is_some_and(|n| n.len() == 3) => {
                let numbers = b.numbers().unwrap_or_default();
                let parts = [0, 1, 2].map(|i| numbers[i].value);
                let dimension = numbers.iter().map(|n| n.dimension).find(|d| !d.is_none()).unwrap_or_default();
                Some(Value::vector(&builtin::turned(&mut self.graph, q, parts), dimension))
            }
            _ => match self.arithmetic(op, op_span, (a, left.1), (b, right.1)) {
                Ok(value) => value,
                Err(()) => return Value::Error,
            },
        };
        match result {
            Some(value) => value,
            None => {
                let diagnostic = self.mismatch(op, op_span, &left, &right);
                self.error(diagnostic)
            }
        }
    }

    fn mismatch(&self, op: BinaryOp, op_span: Span, left: &(Value, Span), right: &(Value, Span)) -> Diagnostic {
        let describe = |value: &Value| match value {
            Value::Tuple(items) => format!("{} of {} components", value.with_article(), items.len()),
            value => self.describe(value),
        };
        let (a, b) = (describe(&left.0), describe(&right.0));
        let verb = match op {
            BinaryOp::Add => format!("cannot add {a} and {b}"),
            BinaryOp::Sub => format!("cannot subtract {b} from {a}"),
            BinaryOp::Mul => format!("cannot multiply {a} and {b}"),
            BinaryOp::Div => format!("cannot divide {a} by {b}"),
            BinaryOp::Pow => format!("cannot raise {a} to the power of {b}"),
            BinaryOp::And | BinaryOp::Or => format!("`{}` takes true or false, found {a} and {b}", op.text()),
            BinaryOp::Range => format!("a range cannot run from {a} to {b}"),
            _ => format!("cannot compare {a} and {b}"),
        };
        let diagnostic = Diagnostic::new("E0303", verb)
            .primary(self.file(), op_span, "")
            .label(self.file(), left.1, format!("this is {a}"))
            .label(self.file(), right.1, format!("this is {b}"));
        let sums = matches!(op, BinaryOp::Add | BinaryOp::Sub) || op.is_comparison();
        match (&left.0, &right.0) {
            (Value::Number(x), Value::Number(y)) if sums && x.dimension.is_none() != y.dimension.is_none() => {
                let (plain, unit) = match x.dimension.is_none() {
                    true => (left.1, y.dimension.unit()),
                    false => (right.1, x.dimension.unit()),
                };
                let unit = if unit == "rad" { "deg".into() } else { unit };
                let text = short_text(self.text(plain));
                match text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.') {
                    true => diagnostic.fix(
                        Applicability::Maybe,
                        format!("write `{text}{unit}`"),
                        self.file(),
                        Span::at(plain.end),
                        unit,
                    ),
                    false => diagnostic.help(format!("multiply `{text}` by `1{unit}`")),
                }
            }
            _ => diagnostic,
        }
    }

    /// Whether two values are equal; `None` if they cannot be compared.
    fn equal(&mut self, a: &Value, b: &Value) -> Option<Scalar> {
        let truth = |value: bool| Some(Scalar::Const(f64::from(u8::from(value))));
        match (a, b) {
            (Value::Number(x), Value::Number(y)) => {
                common(x, y)?;
                Some(self.graph.binary(Binary::Equal, x.value, y.value))
            }
            (Value::Bool(x), Value::Bool(y)) => Some(self.graph.binary(Binary::Equal, *x, *y)),
            (Value::Color(x), Value::Color(y)) => {
                let mut all = Scalar::Const(1.0);
                for (x, y) in x.iter().zip(y) {
                    let one = self.graph.binary(Binary::Equal, *x, *y);
                    all = self.graph.binary(Binary::And, all, one);
                }
                Some(all)
            }
            (Value::Text(x), Value::Text(y)) => truth(x == y),
            (Value::Node(x), Value::Node(y)) => truth(x == y),
            (Value::Tuple(x), Value::Tuple(y)) | (Value::List(x), Value::List(y)) => {
                if x.len() != y.len() {
                    return truth(false);
                }
                let mut all = Scalar::Const(1.0);
                for (x, y) in x.iter().zip(y.iter()) {
                    let one = self.equal(&met(x, y), &met(y, x))?;
                    all = self.graph.binary(Binary::And, all, one);
                }
                Some(all)
            }
            _ => None,
        }
    }

    /// `+ - * / ^` of numbers, vectors and colours. `Ok(None)` where the types do not fit, `Err` where it is reported.
    fn arithmetic(
        &mut self,
        op: BinaryOp,
        op_span: Span,
        left: (&Value, Span),
        right: (&Value, Span),
    ) -> Result<Option<Value>, ()> {
        let span = left.1.to(right.1);
        let scalar_op = match op {
            BinaryOp::Add => Binary::Add,
            BinaryOp::Sub => Binary::Sub,
            BinaryOp::Mul => Binary::Mul,
            BinaryOp::Div => Binary::Div,
            BinaryOp::Pow => Binary::Pow,
            _ => return Ok(None),
        };
        let plain = |value: Scalar| Number::new(value, Dimension::NONE);
        match (left.0, right.0) {
            (Value::Number(x), Value::Number(y)) => {
                Ok(self.numbers(scalar_op, op_span, *x, (*y, right.1), span)?.map(Value::Number))
            }
            (Value::Tuple(_), Value::Tuple(_)) if op != BinaryOp::Pow => {
                let (Some(x), Some(y)) = (left.0.numbers(), right.0.numbers()) else { return Ok(None) };
                if x.len() != y.len() {
                    return Ok(None);
                }
                let pairs: Vec<_> = match op {
                    BinaryOp::Add | BinaryOp::Sub => x.into_iter().zip(y).map(|(x, y)| meet(x, y)).collect(),
                    _ => x.into_iter().zip(y).collect(),
                };
                self.componentwise(scalar_op, op_span, &pairs, right.1, span)
            }
            (Value::Tuple(_), Value::Number(y)) if matches!(op, BinaryOp::Mul | BinaryOp::Div) => {
                let Some(x) = left.0.numbers() else { return Ok(None) };
                let pairs: Vec<_> = measured(&x).map(|x| (x, *y)).collect();
                self.componentwise(scalar_op, op_span, &pairs, right.1, span)
            }
            (Value::Number(x), Value::Tuple(_)) if op == BinaryOp::Mul => {
                let Some(y) = right.0.numbers() else { return Ok(None) };
                let pairs: Vec<_> = measured(&y).map(|y| (*x, y)).collect();
                self.componentwise(scalar_op, op_span, &pairs, right.1, span)
            }
            (Value::Color(x), Value::Color(y)) if !matches!(op, BinaryOp::Pow | BinaryOp::Div) => {
                let pairs = [0, 1, 2].map(|i| (plain(x[i]), plain(y[i])));
                let value = self.componentwise(scalar_op, op_span, &pairs, right.1, span)?;
                Ok(value.and_then(as_color))
            }
            (Value::Color(x), Value::Number(y)) if matches!(op, BinaryOp::Mul | BinaryOp::Div) => {
                if !y.dimension.is_none() {
                    return Ok(None);
                }
                let pairs = [0, 1, 2].map(|i| (plain(x[i]), *y));
                let value = self.componentwise(scalar_op, op_span, &pairs, right.1, span)?;
                Ok(value.and_then(as_color))
            }
            (Value::Number(x), Value::Color(y)) if op == BinaryOp::Mul && x.dimension.is_none() => {
                let pairs = [0, 1, 2].map(|i| (*x, plain(y[i])));
                let value = self.componentwise(scalar_op, op_span, &pairs, right.1, span)?;
                Ok(value.and_then(as_color))
            }
            _ => Ok(None),
        }
    }

    fn componentwise(
        &mut self,
        op: Binary,
        op_span: Span,
        pairs: &[(Number, Number)],
        right: Span,
        span: Span,
    ) -> Result<Option<Value>, ()> {
        let mut parts = Vec::with_capacity(pairs.len());
        for (x, y) in pairs {
            match self.numbers(op, op_span, *x, (*y, right), span)? {
                Some(number) => parts.push(Value::Number(number)),
                None => return Ok(None),
            }
        }
        Ok(Some(Value::Tuple(parts.into())))
    }

    fn numbers(
        &mut self,
        op: Binary,
        op_span: Span,
        x: Number,
        (y, right): (Number, Span),
        span: Span,
    ) -> Result<Option<Number>, ()> {
        let dimension = match op {
            Binary::Add | Binary::Sub => common(&x, &y),
            Binary::Mul => x.dimension.times(y.dimension),
            Binary::Div => x.dimension.per(y.dimension),
            _ if !y.dimension.is_none() => None,
            _ if x.dimension.is_none() => Some(Dimension::NONE),
            _ => match y.value.constant() {
                Some(exponent) if exponent.fract() == 0.0 && exponent.abs() < 100.0 => {
                    x.dimension.power(exponent as i8)
                }
                Some(0.5) => x.dimension.root(),
                _ => None,
            },
        };
        let Some(dimension) = dimension else { return Ok(None) };
        if op == Binary::Div && y.value == Scalar::Const(0.0) {
            let divisor = match self.text(right) {
                written if written.len() < 24 && written.starts_with(|c: char| c.is_ascii_digit()) => String::new(),
                written => format!(", from `{}`", short_text(written)),
            };
            let diagnostic = Diagnostic::new("E0402", "division by zero gives no finite number")
                .primary(self.file(), op_span, "divides by zero")
                .label(self.file(), right, format!("this is 0{divisor}"))
                .help("guard it with an `if`");
            self.report(diagnostic);
            return Err(());
        }
        let finite = |number: &Number| number.value.constant().is_none_or(f64::is_finite);
        let before = finite(&x) && finite(&y);
        let whole_power = op != Binary::Pow || y.value.constant().is_some_and(|exponent| exponent >= 0.0);
        let int = x.int && y.int && op != Binary::Div && whole_power;
        let value = self.graph.binary(op, x.value, y.value);
        let Some(value) = self.checked(value, before, span) else { return Err(()) };
        if int && value.constant().is_some_and(|value| value.abs() > limits::WHOLE) {
            let diagnostic = Diagnostic::new("E0410", "number is too large")
                .primary(self.file(), span, "whole numbers go up to 2^53")
                .help("compute with a point in one of the numbers, `2.0`, if it need not be exact");
            self.report(diagnostic);
            return Err(());
        }
        Ok(Some(Number { value, dimension, int }))
    }
}

fn as_color(value: Value) -> Option<Value> {
    let numbers = value.numbers()?;
    match numbers.as_slice() {
        [r, g, b] => Some(Value::Color([r.value, g.value, b.value])),
        _ => None,
    }
}

/// The dimension that two numbers share; a 0 fits any.
pub fn common(a: &Number, b: &Number) -> Option<Dimension> {
    if a.dimension == b.dimension || b.is_bare_zero() {
        Some(a.dimension)
    } else if a.is_bare_zero() {
        Some(b.dimension)
    } else {
        None
    }
}

/// The components of a vector, each 0 that fits any dimension in that of the others.
fn measured(numbers: &[Number]) -> impl Iterator<Item = Number> {
    let of = numbers.iter().find(|number| !number.is_bare_zero()).map_or(Dimension::NONE, |number| number.dimension);
    numbers.iter().map(move |number| match number.is_bare_zero() && !of.is_none() {
        true => Number::new(0.0, of),
        false => *number,
    })
}

/// Components of two vectors that are put together: a bare one is in metres where the other is a length.
pub fn meet(a: Number, b: Number) -> (Number, Number) {
    let metres = |number: Number, beside: Number| match number.dimension.is_none() && !number.is_bare_zero() {
        true if beside.dimension == Dimension::LENGTH => Number { dimension: Dimension::LENGTH, int: false, ..number },
        _ => number,
    };
    (metres(a, b), metres(b, a))
}

/// The component `a` beside `b`, as by [`meet`].
pub fn met(a: &Value, b: &Value) -> Value {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => Value::Number(meet(*x, *y).0),
        _ => a.clone(),
    }
}

/// The components of a vector: bare ones are in metres where one of them is a length.
fn in_metres(value: Value) -> Value {
    let Value::Tuple(items) = &value else { return value };
    let length = |item: &&Value| matches!(item, Value::Number(number) if number.dimension == Dimension::LENGTH);
    match items.iter().find(length) {
        Some(length) => Value::Tuple(items.iter().map(|item| met(item, length)).collect()),
        None => value,
    }
}

/// Whether two values may stand in one list or be keys of one curve.
pub fn same_type(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(x), Value::Number(y)) => common(x, y).is_some(),
        (Value::Tuple(x), Value::Tuple(y)) => {
            x.len() == y.len() && x.iter().zip(y.iter()).all(|(x, y)| same_type(&met(x, y), &met(y, x)))
        }
        (Value::List(_), Value::List(_)) => true,
        (Value::Keys(x), _) => x.keys.first().is_some_and(|key| same_type(&key.value, b)),
        (_, Value::Keys(y)) => y.keys.first().is_some_and(|key| same_type(a, &key.value)),
        _ => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}

/// A number with its thousands apart: `1 000 000`.
pub fn spaced(value: f64) -> String {
    if !(0.0..1e15).contains(&value) {
        return dimension::short(value);
    }
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Source text for a message: one line, not too long.
pub fn short_text(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    match line.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}
