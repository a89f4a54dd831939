//! Where values come from: notes beside what is wrong with a value that was computed.

use std::rc::Rc;

use crate::diagnostic::Diagnostic;
use crate::eval::expr::{Env, short_text};
use crate::eval::machine::{Machine, Trace};
use crate::eval::scope::{Binding, LetState};
use crate::source::Span;
use crate::syntax::ast::{self, Expr, ExprKind};
use crate::value::Value;

/// Notes beside one finding.
const MOST: usize = 4;

/// Where an expression is read.
struct Reader<'a> {
    env: Env<'a>,
    trace: Option<Rc<Trace<'a>>>,
    /// Names that stand for something else in there: parameters, and variables of comprehensions.
    hidden: Vec<&'a str>,
}

impl<'a> Machine<'a> {
    /// Runs what evaluates `expr`. What it finds wrong with the values in there gets notes of where they come from.
    pub fn rooted<T>(&mut self, expr: &'a Expr, env: &Env<'a>, body: impl FnOnce(&mut Self) -> T) -> T {
        let before = self.diagnostics.len();
        let result = body(self);
        for at in before..self.diagnostics.len() {
            self.explain(at, expr, env);
        }
        result
    }

    fn explain(&mut self, at: usize, expr: &'a Expr, env: &Env<'a>) {
        let Some(diagnostic) = self.diagnostics.get(at) else { return };
        let about_values = ["E03", "E04", "E0601", "E0901"].iter().any(|group| diagnostic.code.starts_with(group));
        let inside = |span: Span| expr.span.start <= span.start && span.end <= expr.span.end;
        if self.stopped || !about_values || !diagnostic.place().is_some_and(|(_, span)| inside(span)) {
            return;
        }
        if self.explained.insert(at) {
            self.explain_value(at, expr, env);
        }
    }

    /// Adds to a finding where the values at its labels in `expr` come from.
    pub fn explain_value(&mut self, at: usize, expr: &'a Expr, env: &Env<'a>) {
        let Some(diagnostic) = self.diagnostics.get(at).filter(|_| !self.stopped) else { return };
        let inside = |span: Span| expr.span.start <= span.start && span.end <= expr.span.end;
        let spans: Vec<Span> = diagnostic.labels.iter().map(|label| label.span).filter(|span| inside(*span)).collect();
        if spans.is_empty() {
            return;
        }
        let mut notes = Vec::new();
        let reader = Reader { env: env.clone(), trace: self.trace.clone(), hidden: Vec::new() };
        self.origins(expr, &reader, Some(&spans), &mut notes);
        if let Some(diagnostic) = self.diagnostics.get_mut(at) {
            add(diagnostic, notes);
        }
    }

    /// Notes on the names and calls in an expression, of those within `spans` where they are given.
    fn origins(&mut self, expr: &'a Expr, reader: &Reader<'a>, spans: Option<&[Span]>, notes: &mut Vec<String>) {
        if notes.len() >= MOST {
            return;
        }
        let here = spans.is_none_or(|spans| spans.iter().any(|s| s.start <= expr.span.start && expr.span.end <= s.end));
        match &expr.kind {
            ExprKind::Path(path) if here => self.origin_of_name(path, reader, notes),
            ExprKind::Call { callee, args } => {
                for arg in args {
                    self.origins(&arg.value, reader, spans, notes);
                }
                if let (true, ExprKind::Path(path)) = (here, &callee.kind) {
                    self.origin_of_call(expr, path, reader, notes);
                }
            }
            ExprKind::Comp(comp) => {
                self.origins(&comp.head.over, reader, spans, notes);
                let mut hidden = reader.hidden.clone();
                hidden.extend(comp.head.names.iter().map(|name| &*name.text));
                let inner = Reader { env: reader.env.clone(), trace: reader.trace.clone(), hidden };
                for part in comp.condition.iter().chain([&comp.value]) {
                    self.origins(part, &inner, spans, notes);
                }
            }
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                for item in items {
                    self.origins(item, reader, spans, notes);
                }
            }
            ExprKind::Unary { value, .. } => self.origins(value, reader, spans, notes),
            ExprKind::Binary { first, rest } => {
                self.origins(first, reader, spans, notes);
                for step in rest {
                    self.origins(&step.value, reader, spans, notes);
                }
            }
            ExprKind::Field { base, .. } => self.origins(base, reader, spans, notes),
            ExprKind::Index { base, index } => {
                self.origins(base, reader, spans, notes);
                self.origins(index, reader, spans, notes);
            }
            ExprKind::If(value) => {
                for (condition, arm) in &value.arms {
                    self.origins(condition, reader, spans, notes);
                    self.origins(arm, reader, spans, notes);
                }
                self.origins(&value.otherwise, reader, spans, notes);
            }
            _ => {}
        }
    }

    fn origin_of_name(&mut self, path: &'a ast::Path, reader: &Reader<'a>, notes: &mut Vec<String>) {
        let Some(first) = path.segments.first().filter(|first| !reader.hidden.contains(&&*first.text)) else { return };
        let is_value = |binding: &Binding<'_>| matches!(binding, Binding::Let(_) | Binding::Value(_));
        match reader.env.find_path(&path.segments, is_value) {
            Some((scope, Binding::Let(cell), names)) => {
                let LetState::Done(value) = cell.state.borrow().clone() else { return };
                let moves = !value.is_constant();
                let Some(shown) = shown(&value) else { return };
                let name: Vec<&str> = path.segments.iter().take(names).map(|name| &*name.text).collect();
                let name = name.join(".");
                if cell.overridden {
                    return note(notes, format!("`{name}` is {shown}, by the command line"));
                }
                let written = short_text(self.text(cell.value.span));
                let line = self.source.line(cell.value.span.start);
                note(
                    notes,
                    match written == shown {
                        _ if moves => format!("`{name}` changes over time: `{written}`, {line}"),
                        true => format!("`{name}` is {shown}, {line}"),
                        false => format!("`{name}` is {shown}: `{written}`, {line}"),
                    },
                );
                let inner = Reader { env: scope, trace: reader.trace.clone(), hidden: Vec::new() };
                self.origins(cell.value, &inner, None, notes);
            }
            // The calls and loops are noted with their values; what those were computed of is not.
            Some((_, Binding::Value(_), _)) => {
                let mut trace = reader.trace.clone();
                while let Some(here) = trace {
                    if let Some(given) = here.given.iter().find(|given| given.name == &*first.text) {
                        let Some(expr) = given.expr else { return };
                        let inner = Reader { env: here.env.clone(), trace: here.parent.clone(), hidden: Vec::new() };
                        return self.origins(expr, &inner, None, notes);
                    }
                    trace = here.parent.clone();
                }
            }
            _ => {}
        }
    }

    fn origin_of_call(&mut self, call: &'a Expr, path: &'a ast::Path, reader: &Reader<'a>, notes: &mut Vec<String>) {
        let is_fn = |binding: &Binding<'_>| matches!(binding, Binding::Fn(_));
        let Some((scope, Binding::Fn(decl), _)) = reader.env.find_path(&path.segments, is_fn) else { return };
        if !reader.hidden.is_empty() || self.endless.contains(&decl.head) {
            return;
        }
        // Functions are pure: what the call gave, it gives again.
        let kept = std::mem::take(&mut self.diagnostics);
        let outer = std::mem::replace(&mut self.trace, reader.trace.clone());
        let value = self.plain(call, &reader.env);
        self.trace = outer;
        self.diagnostics = kept;
        let (Some(shown), line) = (shown(&value), self.source.line(decl.head.start)) else { return };
        let text = short_text(self.text(call.span));
        match &decl.body {
            ast::FnBody::Value(body) => {
                note(notes, format!("`{text}` is {shown}: `{}`, {line}", short_text(self.text(body.span))));
                let hidden = decl.params.iter().map(|formal| &*formal.name.text).collect();
                self.origins(body, &Reader { env: scope, trace: None, hidden }, None, notes);
            }
            _ => note(notes, format!("`{text}` is {shown}, by the function on {line}")),
        }
    }
}

/// What a note can say of a value.
fn shown(value: &Value) -> Option<String> {
    let plain = matches!(
        value,
        Value::Number(_)
            | Value::Bool(_)
            | Value::Text(_)
            | Value::Color(_)
            | Value::Turn(_)
            | Value::Tuple(_)
            | Value::List(_)
            | Value::Range(..)
    );
    plain.then(|| value.show())
}

fn note(notes: &mut Vec<String>, text: String) {
    if notes.len() < MOST && !notes.contains(&text) {
        notes.push(text);
    }
}

/// Adds notes, each in the place of one that says less.
fn add(diagnostic: &mut Diagnostic, notes: Vec<String>) {
    for text in notes {
        if diagnostic.notes.contains(&text) {
            continue;
        }
        let less = |old: &&mut String| text.strip_prefix(old.as_str()).is_some_and(|rest| rest.starts_with([':', ',']));
        match diagnostic.notes.iter_mut().find(less) {
            Some(old) => *old = text,
            None => diagnostic.notes.push(text),
        }
    }
}
