//! `param` lines, and what the command line makes of them.

use std::cell::RefCell;
use std::collections::HashSet;
use std::rc::Rc;
use std::sync::Arc;

use serde::Serialize;

use crate::diagnostic::Diagnostic;
use crate::dimension::{Dimension, short};
use crate::eval::Overrides;
use crate::eval::coerce::Site;
use crate::eval::expr::same_type;
use crate::eval::items::{Converted, convert};
use crate::eval::machine::{Machine, NodeKind, NodeState, NodeValue, Set};
use crate::eval::scope::{Binding, LetCell, LetState, Scope};
use crate::eval::surface::is_point;
use crate::modules::Modules;
use crate::schema::{Since, TYPES, Type};
use crate::source::{FileId, Source, Span, Texts};
use crate::suggest::{all_of, suggest};
use crate::syntax::ast::{self, Expr, ExprKind, Item};
use crate::syntax::parse_value;
use crate::value::{NodeId, Number, Value};

/// A parameter of a scene, for sliders and listings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Param {
    /// The name of `-D name=value`.
    pub name: String,
    /// The type, as written or as the default has it: `float`, `length`.
    #[serde(rename = "type")]
    pub ty: String,
    /// The default, as written.
    pub default: String,
    /// From where to where, as written.
    pub range: Option<[String; 2]>,
    /// The `///` lines above.
    pub doc: Option<String>,
    /// Its value as it is, the command line's included; none where it is nothing plain.
    #[serde(skip)]
    pub value: Option<Plain>,
    /// Its range, in SI units.
    #[serde(skip)]
    pub bounds: Option<[f64; 2]>,
    /// Where the default is written.
    #[serde(skip)]
    pub place: (FileId, Span),
}

/// A value that a slider, a picker or a switch can show.
#[derive(Debug, Clone, PartialEq)]
pub enum Plain {
    /// In SI units.
    Number {
        /// How much.
        value: f64,
        /// Of what.
        dimension: Dimension,
        /// Whether it is a whole number by its type.
        int: bool,
    },
    /// `true` or `false`
    Bool(bool),
    /// A string.
    Text(Arc<str>),
    /// Linear Rec. 709.
    Color([f64; 3]),
    /// Numbers of one dimension, in SI units.
    Vector(Vec<f64>, Dimension),
}

impl Plain {
    fn of(value: &Value) -> Option<Plain> {
        match value {
            Value::Number(Number { value, dimension, int }) => {
                Some(Plain::Number { value: value.constant()?, dimension: *dimension, int: *int })
            }
            Value::Bool(value) => Some(Plain::Bool(value.constant()? != 0.0)),
            Value::Text(text) => Some(Plain::Text(text.clone())),
            Value::Color([r, g, b]) => Some(Plain::Color([r.constant()?, g.constant()?, b.constant()?])),
            Value::Tuple(_) => {
                let numbers = value.numbers()?;
                let dimension = numbers.first()?.dimension;
                let same = numbers.iter().all(|number| number.dimension == dimension || number.is_bare_zero());
                let parts: Option<Vec<f64>> = numbers.iter().map(|number| number.value.constant()).collect();
                Some(Plain::Vector(parts?, dimension)).filter(|_| same)
            }
            _ => None,
        }
    }
}

/// A parameter and how the command line calls it.
pub struct Known<'a> {
    /// `name`, or `module.name` where the file is imported under a name.
    pub name: String,
    /// What is written.
    pub decl: &'a ast::ParamDecl,
    /// The file's names.
    pub scope: Rc<Scope<'a>>,
}

/// The parameters that can be set: the scene's own, and those of the files that it imports itself, by the names that
/// they have in the scene. `scopes` are the names of each module.
pub fn known<'a>(modules: &'a Modules, scopes: &[Rc<Scope<'a>>]) -> Vec<Known<'a>> {
    let (mut found, mut seen) = (Vec::new(), HashSet::new());
    let mut add = |name: String, decl: &'a ast::ParamDecl, module: usize| {
        if let Some(scope) = scopes.get(module)
            && seen.insert(std::ptr::from_ref(decl))
        {
            found.push(Known { name, decl, scope: scope.clone() });
        }
    };
    let Some(own) = modules.list.first() else { return found };
    for decl in declared(&own.file) {
        if let Some(name) = &decl.name {
            add(name.text.to_string(), decl, 0);
        }
    }
    for (import, to) in own.imports() {
        let Some((to, module)) = to.and_then(|to| Some((to, modules.list.get(to)?))) else { continue };
        for decl in declared(&module.file) {
            let Some(name) = decl.name.as_ref().filter(|name| !name.text.starts_with('_')) else { continue };
            let named = import.names.iter().flatten().find(|rename| rename.name.text == name.text);
            match (named, &import.alias) {
                (Some(rename), _) => add(rename.alias.as_ref().unwrap_or(&rename.name).text.to_string(), decl, to),
                (None, Some(alias)) => add(format!("{}.{}", alias.text, name.text), decl, to),
                (None, None) => {}
            }
        }
    }
    found
}

/// The parameters of a scene.
pub fn list<'a>(machine: &mut Machine<'a>, known: &[Known<'a>], overrides: &Overrides) -> Vec<Param> {
    let mut params = Vec::new();
    for Known { name: called, decl, scope: globals } in known {
        let decl = *decl;
        let Some(name) = &decl.name else { continue };
        let Some(Binding::Let(cell)) = globals.own(&name.text) else { continue };
        let mut value = machine.force_let(&cell, globals);
        if cell.overridden && decl.ty.is_none() {
            let default = machine.plain(&decl.value, globals);
            value = same_as_default(machine, (called, decl), value, &default, overrides);
            *cell.state.borrow_mut() = LetState::Done(value.clone());
        }
        let range = decl.range.as_ref().and_then(|range| machine.param_range(range, globals));
        if let (Some((low, high)), Value::Number(number)) = (&range, &value)
            && let Some(found) = number.value.constant()
            && !within(number, low, high)
        {
            let span = decl.value.span;
            let text = machine.text(span);
            let bounds = decl.range.as_ref().map_or(String::new(), |range| machine.text(range.span).to_string());
            if !cell.overridden {
                let mut diagnostic = Diagnostic::new("W0307", format!("{text} is outside {bounds}")).primary(
                    machine.file(),
                    span,
                    "outside its own range",
                );
                if number.dimension.is_none() && high.value.constant() == Some(1.0) && (1.0..=100.0).contains(&found) {
                    diagnostic = diagnostic.help(format!("did you mean `{}%`?", short(found)));
                }
                machine.report(diagnostic);
            } else {
                let got = value.show();
                let message = format!("`{called}` must be within {bounds}, got {got}");
                let diagnostic =
                    Diagnostic::new("E0413", message).label(machine.file(), decl.span, "declared here").help(format!(
                        "give a value from {} to {}",
                        Value::Number(*low).show(),
                        Value::Number(*high).show()
                    ));
                machine.report(diagnostic);
                *cell.state.borrow_mut() = LetState::Done(Value::Error);
            }
        }
        let bounds = range.as_ref().and_then(|(low, high)| Some([low.value.constant()?, high.value.constant()?]));
        let ty = match &decl.ty {
            Some(ty) => machine.text(ty.span).to_string(),
            None => type_name(&value),
        };
        let range = decl.range.as_ref().and_then(|range| {
            let (low, high) = machine.text(range.span).split_once("..")?;
            Some([low.trim().to_string(), high.trim().to_string()])
        });
        params.push(Param {
            name: called.clone(),
            ty,
            default: machine.text(decl.value.span).to_string(),
            range,
            doc: decl.docs.as_ref().map(|docs| docs.to_string()),
            value: Plain::of(&value),
            bounds,
            place: machine.source.settled(decl.value.span),
        });
    }
    params
}

/// Declares the parameters of a file, with the values that the command line gives.
pub fn declare<'a>(
    machine: &mut Machine<'a>,
    file: &'a ast::File,
    scope: &Rc<Scope<'a>>,
    known: &[Known<'a>],
    overrides: &Overrides,
) {
    let set = |known: &&Known<'_>| overrides.params.iter().any(|(name, _)| *name == known.name);
    let set: Vec<&Known<'_>> = known.iter().filter(set).collect();
    for decl in declared(file) {
        let Some(name) = &decl.name else { continue };
        let called = set.iter().find(|known| std::ptr::eq(known.decl, decl)).map(|known| &*known.name);
        let given = called.and_then(|called| overridden(machine, called, decl, overrides));
        let cell = LetCell {
            name: Some(name),
            ty: decl.ty.as_ref(),
            value: &decl.value,
            overridden: given.is_some(),
            state: RefCell::new(given.map_or(LetState::Waiting, LetState::Done)),
        };
        scope.declare(&name.text, Binding::Let(Rc::new(cell)));
    }
}

/// The `param` lines of a file.
pub fn declared(file: &ast::File) -> impl Iterator<Item = &ast::ParamDecl> {
    file.items.iter().filter_map(|item| match item {
        Item::Param(decl) => Some(decl),
        _ => None,
    })
}

fn within(number: &Number, low: &Number, high: &Number) -> bool {
    let (Some(value), Some(low), Some(high)) = (number.value.constant(), low.value.constant(), high.value.constant())
    else {
        return true;
    };
    (low..=high).contains(&value)
}

fn type_name(value: &Value) -> String {
    match value {
        Value::Number(number) if number.int => "int".into(),
        Value::Number(number) => match TYPES.iter().find(|row| row.dimension == Some(number.dimension)) {
            Some(row) => row.name.into(),
            None => number.dimension.unit(),
        },
        Value::Bool(_) => "bool".into(),
        Value::Text(_) => "string".into(),
        Value::Color(_) => "color".into(),
        Value::Turn(_) => "quat".into(),
        Value::Tuple(items) => format!("vec{}", items.len()),
        Value::List(_) => "list".into(),
        Value::Range(..) => "range".into(),
        _ => "node".into(),
    }
}

impl<'a> Machine<'a> {
    fn param_range(&mut self, range: &'a Expr, scope: &Rc<Scope<'a>>) -> Option<(Number, Number)> {
        match self.plain(range, scope) {
            Value::Range(low, high) => Some((low, high)),
            Value::Error => None,
            other => {
                let found = self.describe(&other);
                let diagnostic = Diagnostic::new("E0301", format!("expected a range, found {found}"))
                    .primary(self.file(), range.span, format!("this is {found}"))
                    .help("write `in 0..1`");
                self.report(diagnostic);
                None
            }
        }
    }
}

/// A value on the command line: its own little file.
fn outside_value(text: &str) -> Result<(Value, Option<String>), String> {
    let source = Source::new(FileId(u32::MAX), "command line", text);
    let (expr, errors) = parse_value(&source);
    if let Some(error) = errors.iter().find(|error| error.is_error()) {
        return Err(error.message.clone());
    }
    let word = match &expr.kind {
        ExprKind::Path(path) => match path.segments.as_slice() {
            [name] if !matches!(&*name.text, "time" | "frame") => Some(name.text.to_string()),
            _ => None,
        },
        _ => None,
    };
    let nothing = super::Nothing::new();
    let texts = Texts::new(&source);
    let mut machine = Machine::new(&texts, &nothing.mix);
    let scope = Rc::new(Scope::default());
    let value = match &word {
        Some(word) if is_point(word) => Value::Error,
        _ => machine.plain(&expr, &scope),
    };
    if let Some(error) = machine.diagnostics.iter().find(|error| error.is_error()) {
        return Err(error.message.clone());
    }
    if !value.is_constant() {
        return Err("expected a value that does not change over time".into());
    }
    if matches!(value, Value::Node(_)) {
        return Err("expected a value, found a node".into());
    }
    Ok((value, word))
}

/// The value that `-D` gives a parameter.
pub fn overridden(
    machine: &mut Machine<'_>,
    called: &str,
    decl: &ast::ParamDecl,
    overrides: &Overrides,
) -> Option<Value> {
    let (_, text) = overrides.params.iter().rev().find(|(given, _)| given == called)?;
    let names: Vec<&str> = decl.ty.iter().flat_map(|ty| &ty.names).map(|name| &*name.text).collect();
    let wrong = |reason: String| format!("`-D {called}={text}`: {reason}");
    let mut help = None;
    let result = match outside_value(text) {
        Err(reason) => Err(wrong(reason)),
        Ok((value, word)) => match convert(&value, &names, &|_| NodeKind::Unknown) {
            Converted::Fits if value.is_error() => Err(wrong(match (word, expected(&names)) {
                (_, Some(wanted)) => format!("expected {wanted}"),
                (Some(word), None) => format!("no value named `{word}` here"),
                (None, None) => "expected a value".into(),
            })),
            Converted::Fits => Ok(value),
            Converted::As(value) => Ok(value),
            Converted::Whole => Err(wrong("expected a whole number".into())),
            Converted::Unit(dimension) => {
                let unit = if dimension == Dimension::ANGLE { "deg".to_string() } else { dimension.unit() };
                help = Some(format!("write `-D {called}={text}{unit}`"));
                Err(wrong(format!("{} needs a unit", dimension.with_article())))
            }
            Converted::Wrong(wanted) => Err(wrong(format!("expected {wanted}"))),
        },
    };
    match result {
        Ok(value) => Some(value),
        Err(message) => {
            let diagnostic = Diagnostic::new("E0414", message)
                .label(machine.file(), decl.span, "declared here")
                .note("the value is written as in a scene");
            Some(machine.error(match help {
                Some(help) => diagnostic.help(help),
                None => diagnostic,
            }))
        }
    }
}

fn expected(names: &[&str]) -> Option<String> {
    match convert(&Value::Word(""), names, &|_| NodeKind::Unknown) {
        Converted::Wrong(wanted) => Some(wanted),
        _ => None,
    }
}

/// Reports `-D` names that are no parameters.
pub fn check_overrides(machine: &mut Machine<'_>, known: &[Known<'_>], overrides: &Overrides) {
    for (name, text) in &overrides.params {
        let known: Vec<&str> = known.iter().map(|known| &*known.name).collect();
        if known.contains(&&**name) {
            continue;
        }
        let mut diagnostic = Diagnostic::new("E0414", format!("`-D {name}={text}`: no parameter named `{name}`"));
        diagnostic = match (suggest(name, known.iter().copied()).first(), known.is_empty()) {
            (Some(near), _) => diagnostic.help(format!("did you mean `{near}`?")),
            (None, true) => diagnostic.note("the scene has no `param` lines"),
            (None, false) => diagnostic.help(format!("the scene has {}", all_of(known))),
        };
        machine.report(diagnostic);
    }
}

/// The `-D` value, if it may stand where the default stood.
fn same_as_default(
    machine: &mut Machine<'_>,
    (name, decl): (&str, &ast::ParamDecl),
    value: Value,
    default: &Value,
    overrides: &Overrides,
) -> Value {
    if value.is_error() || default.is_error() || same_type(default, &value) {
        return value;
    }
    let text = overrides.params.iter().rev().find(|(given, _)| given == name).map_or("", |(_, text)| text);
    let message = format!("`-D {name}={text}`: expected {}", default.with_article());
    let diagnostic = Diagnostic::new("E0414", message).label(machine.file(), decl.span, "declared here");
    machine.error(diagnostic)
}

/// Applies `--set node.property=value`. `render` is a node to fall back on where the scene has no `render` block.
pub fn apply_sets<'a>(
    machine: &mut Machine<'a>,
    roots: &mut Vec<NodeId>,
    overrides: &Overrides,
    render: NodeId,
    expr: &'a Expr,
) {
    for (path, text) in &overrides.sets {
        if let Err((code, reason)) = apply_set(machine, roots, path, text, render, expr) {
            let diagnostic = Diagnostic::new(code, format!("`--set {path}={text}`: {reason}"));
            machine.report(diagnostic);
        }
    }
}

fn apply_set<'a>(
    machine: &mut Machine<'a>,
    roots: &mut Vec<NodeId>,
    path: &str,
    text: &str,
    render: NodeId,
    expr: &'a Expr,
) -> Result<(), (&'static str, String)> {
    let Some((node, property)) = path.rsplit_once('.') else {
        return Err(("E0414", "write `node.property=value`, for example `render.samples=16`".into()));
    };
    let named = |machine: &Machine<'a>| match machine.globals.own(node) {
        Some(Binding::Node(id)) => Some(id),
        _ => {
            roots.iter().copied().find(|id| matches!(machine.kind_of(*id), NodeKind::Schema(kind) if kind.name == node))
        }
    };
    let id = match named(machine) {
        Some(id) => id,
        None if node == "render" => {
            roots.push(render);
            render
        }
        None => return Err(("E0203", format!("no node named `{node}` here"))),
    };
    let Some(value) = machine.force(id) else { return Ok(()) };
    let NodeKind::Schema(kind) = value.kind else { return Err(("E0203", format!("`{node}` has no properties"))) };
    let Some(row) = kind.property(property) else {
        let near = suggest(property, kind.all().map(|row| row.name))
            .first()
            .map_or(String::new(), |near| format!(", did you mean `{near}`?"));
        return Err(("E0201", format!("unknown property `{property}` on `{}`{near}", kind.name)));
    };
    if row.since == Since::Later {
        return Err(("E1101", format!("not yet: `{property}` of `{}`", kind.name)));
    }
    let (found, word) = outside_value(text).map_err(|reason| ("E0414", reason))?;
    let found = match (row.ty, word) {
        (Type::Choice(choices), Some(word)) => match choices.iter().find(|choice| choice.name == word) {
            Some(choice) => Value::Word(choice.name),
            None => return Err(("E0301", format!("expected {}, found `{word}`", row.ty.with_article()))),
        },
        (Type::Node(_) | Type::Placed | Type::Target, Some(word)) => match machine.globals.own(&word) {
            Some(Binding::Node(id)) => Value::Node(id),
            _ => return Err(("E0203", format!("no node named `{word}` here"))),
        },
        (_, Some(word)) if found.is_error() => return Err(("E0203", format!("no value named `{word}` here"))),
        _ => found,
    };
    let site = Site { property: row, kind, name: Span::at(0), expr };
    let kept = std::mem::take(&mut machine.diagnostics);
    let data = machine.fit(&found, &site);
    let problems = std::mem::replace(&mut machine.diagnostics, kept);
    if let Some(problem) = problems.into_iter().find(Diagnostic::is_error) {
        return Err((problem.code, problem.message));
    }
    let mut properties: Vec<Set<'a>> =
        value.properties.iter().filter(|set| set.property.name != property).cloned().collect();
    properties.push(Set { property: row, data, value: found, name: Span::at(0), expr });
    let changed = NodeValue {
        kind: value.kind,
        properties,
        children: value.children.clone(),
        arguments: value.arguments.clone(),
        inner: value.inner.clone(),
    };
    machine.nodes[id.0 as usize].state = NodeState::Done(Rc::new(changed));
    Ok(())
}

/// A number that `--set` gives, for what is asked before the sets are applied.
pub fn set_number(overrides: &Overrides, path: &str) -> Option<f64> {
    let (_, text) = overrides.sets.iter().rev().find(|(given, _)| given == path)?;
    match outside_value(text).ok()?.0 {
        Value::Number(number) => number.value.constant().filter(|value| value.is_finite() && *value > 0.0),
        _ => None,
    }
}
