//! What a text does not say, shown beside it: names of arguments, values, the shape of easings.

use super::Analysis;
use super::names::Declaration;
use super::walk::{Seen, walk};
use crate::builtin;
use crate::eval::items::is_literal;
use crate::source::Span;
use crate::syntax::ast::{Expr, ExprKind, FnDecl, Item};

/// What a hint shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum HintKind {
    Parameter,
    Value,
    Easing,
}

/// Something to show at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hint {
    /// Before or behind which byte.
    pub offset: u32,
    /// What it is.
    pub kind: HintKind,
    /// What is shown; of a value empty, it is the value of [`Hint::value`].
    pub text: String,
    /// The expression whose value is shown.
    pub value: Option<Span>,
}

/// The hints within a span.
pub fn hints(analysis: &Analysis, within: Span) -> Vec<Hint> {
    let mut found = Vec::new();
    let Some(own) = analysis.modules.list.first() else { return found };
    let meets = |span: Span| span.start <= within.end && within.start <= span.end;
    walk(&own.file.items, &mut |seen| match seen {
        Seen::Item(item) => {
            if let Item::Let(decl) = item
                && let Some(value) = Some(&decl.value).filter(|value| worth_showing(value) && meets(value.span))
            {
                found.push(Hint {
                    offset: value.span.end,
                    kind: HintKind::Value,
                    text: String::new(),
                    value: Some(value.span),
                });
            }
            meets(item.span())
        }
        Seen::Node(node) => meets(node.span),
        Seen::Formal(formal) => meets(formal.span),
        Seen::Head(head) => meets(head.span),
        Seen::Expr(expr) => {
            if let ExprKind::Call { callee, args } = &expr.kind {
                let names = names_of(analysis, callee);
                for (arg, name) in args.iter().zip(names) {
                    let same = matches!(&arg.value.kind, ExprKind::Path(path) if path.segments.last().is_some_and(|last| *last.text == *name));
                    if arg.name.is_none() && !same && !arg.value.is_missing() && name.len() > 1 && meets(arg.span) {
                        found.push(Hint {
                            offset: arg.span.start,
                            kind: HintKind::Parameter,
                            text: format!("{name}:"),
                            value: None,
                        });
                    }
                }
            }
            meets(expr.span)
        }
        Seen::Key(key) => {
            if let Some(ease) = key.ease.as_ref().filter(|ease| meets(ease.span))
                && let ExprKind::Path(path) = &ease.kind
                && let [name] = path.segments.as_slice()
                && let Some(shape) = shape(&name.text)
            {
                found.push(Hint { offset: ease.span.end, kind: HintKind::Easing, text: shape.into(), value: None });
            }
            meets(key.span)
        }
    });
    found.retain(|hint| within.start <= hint.offset && hint.offset <= within.end);
    found.sort_by_key(|hint| hint.offset);
    found
}

/// The expressions whose values hints need.
pub fn watched(hints: &[Hint]) -> Vec<Span> {
    hints.iter().filter_map(|hint| hint.value).collect()
}

/// Whether the value of a `let` is not plain to see.
fn worth_showing(value: &Expr) -> bool {
    let plain = |expr: &Expr| is_literal(expr) || matches!(expr.kind, ExprKind::Number(_) | ExprKind::Color(_));
    match &value.kind {
        ExprKind::Missing | ExprKind::Node(_) | ExprKind::Keys(_) | ExprKind::Comp(_) | ExprKind::List(_) => false,
        ExprKind::Tuple(items) => !items.iter().all(plain),
        ExprKind::Unary { value, .. } => worth_showing(value),
        _ => !plain(value),
    }
}

/// The names of what a function takes by place, where they help: more than one value.
fn names_of(analysis: &Analysis, callee: &Expr) -> Vec<String> {
    let ExprKind::Path(path) = &callee.kind else { return Vec::new() };
    let Some(last) = path.segments.last() else { return Vec::new() };
    let of_fn = |decl: &FnDecl| decl.params.iter().map(|formal| formal.name.text.to_string()).collect();
    match analysis.name_at(last.span.end).and_then(|(_, to)| analysis.declaration(to)) {
        Some(Declaration::Fn(decl)) => of_fn(decl),
        Some(_) => Vec::new(),
        None if path.segments.len() > 1 => Vec::new(),
        None => match builtin::find(&last.text) {
            Some(row) if row.rest.is_none() && row.params.len() > 1 => {
                row.params.iter().map(|param| param.name.to_string()).collect()
            }
            _ => Vec::new(),
        },
    }
}

/// An easing as a line: how it begins and ends.
fn shape(name: &str) -> Option<&'static str> {
    Some(match name {
        "linear" => "⟋",
        "step" | "hold" => "▁▁█",
        "ease_in" => "▁▂▄█",
        "ease_out" => "▁▅▇█",
        "ease_in_out" | "smooth" => "▁▂▆█",
        _ if name.ends_with("_bounce") => "▁▆▄█",
        _ if name.ends_with("_elastic") || name.ends_with("_back") => "▁▇█▇",
        _ if name.starts_with("in_out_") => "▁▂▆█",
        _ if name.starts_with("in_") => "▁▂▄█",
        _ if name.starts_with("out_") => "▁▅▇█",
        _ => return None,
    })
}
