//! Tree to [`ast`](super::ast): values. Here the flat list of an expression gets its precedence.

use super::ast::*;
use super::kind::SyntaxKind;
use super::lower::*;
use super::part::Part;
use super::text::{color, number, unescape};
use crate::source::Span;

/// What an element adds to the depth of the values in it, at most: see [`MAX_DEPTH`].
pub(super) fn depth_cost(node: Part<'_>) -> u32 {
    use SyntaxKind as K;
    match node.kind() {
        K::Expr | K::Named => {
            let mut cost: u32 = 1;
            let mut levels = [false; 7];
            for part in node.parts() {
                match part.kind() {
                    K::Op => match binary_op(part.text()) {
                        BinaryOp::Pow => cost = cost.saturating_add(1),
                        op => levels[level(op)] = true,
                    },
                    K::Prefix | K::Field | K::Index | K::Args => cost = cost.saturating_add(1),
                    _ => {}
                }
            }
            cost.saturating_add(levels.iter().filter(|used| **used).count() as u32)
        }
        K::Tuple | K::List | K::Comp | K::Args | K::Index | K::Keys | K::IfValue | K::Block => 1,
        _ => 0,
    }
}

/// The value of a part; missing if it is none.
pub(super) fn value(part: Part<'_>) -> Expr {
    let kind = match part.kind() {
        SyntaxKind::Number => number_of(part),
        SyntaxKind::Expr => return flat(part),
        SyntaxKind::Named if is_node(part) => {
            scene_node(part, None).map_or(ExprKind::Missing, |node| ExprKind::Node(Box::new(node)))
        }
        SyntaxKind::Named => return flat(part),
        SyntaxKind::Tuple => tuple(part),
        SyntaxKind::List => list(part),
        SyntaxKind::Keys => ExprKind::Keys(Box::new(keys(part))),
        SyntaxKind::IfValue => if_value(part),
        SyntaxKind::Color => color(part.text()).map_or(ExprKind::Missing, ExprKind::Color),
        SyntaxKind::String => ExprKind::Str(unescape(part.text()).text.into()),
        SyntaxKind::Boolean => ExprKind::Bool(part.text() == "true"),
        SyntaxKind::Path => ExprKind::Path(path(part)),
        _ => ExprKind::Missing,
    };
    Expr { kind, span: part.span() }
}

fn is_node(named: Part<'_>) -> bool {
    named.nodes().any(|child| matches!(child.kind(), SyntaxKind::Block | SyntaxKind::Like))
}

fn number_of(node: Part<'_>) -> ExprKind {
    let mut digits = "";
    let mut unit = None;
    for part in node.parts() {
        match part.kind() {
            SyntaxKind::Digits => digits = part.text(),
            SyntaxKind::Unit => unit = Some(name(part)),
            _ => return ExprKind::Missing,
        }
    }
    ExprKind::Number(number(digits, unit))
}

/// Whether a bracket holds something that could not be read, so that nothing is known about the number of its values.
fn is_broken(node: Part<'_>) -> bool {
    node.parts().any(|part| {
        matches!(part.kind(), SyntaxKind::Unclosed | SyntaxKind::ExtraComma | SyntaxKind::BadElem | SyntaxKind::BadItem)
    })
}

/// The values of a bracket. A path token is a value only inside of an expression.
fn values(node: Part<'_>) -> Vec<Expr> {
    let found = parts(node).filter(|part| part.kind().is_value());
    let mut values = Vec::with_capacity(found.clone().count());
    values.extend(found.map(value));
    values
}

fn tuple(node: Part<'_>) -> ExprKind {
    let mut values = values(node);
    match values.len() {
        _ if is_broken(node) => ExprKind::Missing,
        1 => values.pop().map_or(ExprKind::Missing, |only| only.kind),
        _ => ExprKind::Tuple(values),
    }
}

fn list(node: Part<'_>) -> ExprKind {
    let Some(comp) = child(node, SyntaxKind::Comp) else {
        return if is_broken(node) { ExprKind::Missing } else { ExprKind::List(values(node)) };
    };
    let condition = value_after(comp, SyntaxKind::KwIf);
    let value = value_after(comp, SyntaxKind::Colon).unwrap_or_else(|| missing_in(comp));
    ExprKind::Comp(Box::new(Comp { head: for_head(comp), condition, value }))
}

/// The arguments of a call; nothing if they could not be read.
fn args(node: Part<'_>) -> Option<Vec<Arg>> {
    if is_broken(node) {
        return None;
    }
    let args = parts(node).filter_map(|part| {
        let span = part.span();
        match part.kind() {
            SyntaxKind::NamedArg => {
                let key = parts(part).find(|part| !part.kind().is_node())?;
                let value = value_after(part, SyntaxKind::Colon).unwrap_or_else(|| missing_in(part));
                Some(Arg { name: Some(name(key)), value, span })
            }
            kind if kind.is_value() => Some(Arg { name: None, value: value(part), span }),
            _ => None,
        }
    });
    let mut list = Vec::with_capacity(node.parts().filter(|part| part.kind() == SyntaxKind::Comma).count() + 1);
    list.extend(args);
    Some(list)
}

fn keys(node: Part<'_>) -> Keys {
    let block = child(node, SyntaxKind::KeyBlock);
    let keys = block.into_iter().flat_map(Part::nodes).filter(|key| key.kind() == SyntaxKind::Key);
    Keys {
        args: child(node, SyntaxKind::Args).and_then(args).unwrap_or_default(),
        keys: keys.map(key).collect(),
        block: block.map(Part::span),
    }
}

fn key(node: Part<'_>) -> Key {
    let at_end = || missing_in(node);
    let mut rest = parts(node);
    let mut first = rest.next();
    let after = first.is_some_and(|part| part.kind() == SyntaxKind::KwAfter);
    if after {
        first = rest.next();
    }
    let time = first.map_or_else(at_end, value);
    let reached = match rest.next().map(Part::kind) {
        Some(SyntaxKind::Colon) => rest.next(),
        _ => None,
    };
    let reached = match reached {
        Some(part) if part.kind() == SyntaxKind::Block => KeyValue::Block(block(part)),
        Some(part) => KeyValue::Value(value(part)),
        None => KeyValue::Value(at_end()),
    };
    Key { after, time, value: reached, ease: value_after(node, SyntaxKind::KwEase), span: node.span() }
}

fn if_value(node: Part<'_>) -> ExprKind {
    let Branches { arms, otherwise } = branches(node);
    let arm = |arm: Option<Part<'_>>| {
        let found = arm.and_then(|arm| parts(arm).find(|part| part.kind().is_value()));
        found.map_or_else(|| missing_in(arm.unwrap_or(node)), value)
    };
    let arms = arms.into_iter().map(|(condition, node)| (condition, arm(node))).collect();
    ExprKind::If(Box::new(IfValue { arms, otherwise: arm(otherwise) }))
}

/// Reads an operator; the grammar lets no other text through.
pub(super) fn binary_op(text: &str) -> BinaryOp {
    match text {
        ".." => BinaryOp::Range,
        "||" => BinaryOp::Or,
        "&&" => BinaryOp::And,
        "==" => BinaryOp::Eq,
        "!=" => BinaryOp::Ne,
        "<" => BinaryOp::Lt,
        "<=" => BinaryOp::Le,
        ">" => BinaryOp::Gt,
        ">=" => BinaryOp::Ge,
        "-" => BinaryOp::Sub,
        "*" => BinaryOp::Mul,
        "/" => BinaryOp::Div,
        "^" => BinaryOp::Pow,
        _ => BinaryOp::Add,
    }
}

/// The level of `..`.
pub(super) const RANGE: usize = 0;
/// The level of `==`, `<` and the like.
pub(super) const COMPARISON: usize = 3;

/// Precedence, from the loosest 0 to the tightest 6.
pub(super) fn level(op: BinaryOp) -> usize {
    match op {
        BinaryOp::Range => RANGE,
        BinaryOp::Or => 1,
        BinaryOp::And => 2,
        BinaryOp::Eq | BinaryOp::Ne | BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge => COMPARISON,
        BinaryOp::Add | BinaryOp::Sub => 4,
        BinaryOp::Mul | BinaryOp::Div => 5,
        BinaryOp::Pow => 6,
    }
}

/// The [`level`] of an operator as written.
pub(crate) fn level_of(op: &str) -> usize {
    level(binary_op(op))
}

enum Term {
    Prefix(UnaryOp, Span),
    Operand(Expr),
    Op(BinaryOp, Span),
}

/// `prefix* primary postfix* (op prefix* primary postfix*)*`
fn flat(node: Part<'_>) -> Expr {
    let mut list: Vec<Term> = Vec::new();
    for part in parts(node) {
        let place = part.span();
        match part.kind() {
            SyntaxKind::Prefix => {
                let op = if part.text() == "!" { UnaryOp::Not } else { UnaryOp::Neg };
                list.push(Term::Prefix(op, place));
            }
            SyntaxKind::Op => list.push(Term::Op(binary_op(part.text()), place)),
            SyntaxKind::Args | SyntaxKind::Field | SyntaxKind::Index => {
                if let Some(Term::Operand(base)) = list.pop() {
                    let span = base.span.to(place);
                    list.push(Term::Operand(Expr { kind: postfixed(base, part), span }));
                }
            }
            _ => list.push(Term::Operand(value(part))),
        }
    }
    let mut list = list.into_iter().peekable();
    binary(&mut list, 0, node.span())
}

fn postfixed(base: Expr, postfix: Part<'_>) -> ExprKind {
    if base.is_missing() {
        return ExprKind::Missing;
    }
    match postfix.kind() {
        SyntaxKind::Args => match args(postfix) {
            Some(args) => ExprKind::Call { callee: Box::new(base), args },
            None => ExprKind::Missing,
        },
        SyntaxKind::Index => match parts(postfix).nth(1) {
            Some(index) if !is_broken(postfix) => {
                ExprKind::Index { base: Box::new(base), index: Box::new(value(index)) }
            }
            _ => ExprKind::Missing,
        },
        _ => field(base, postfix),
    }
}

fn field(base: Expr, postfix: Part<'_>) -> ExprKind {
    let found = parts(postfix).find(|part| part.kind() == SyntaxKind::Ident);
    match (found, base.kind) {
        // `1.` and what follows: reported.
        (None, _) | (_, ExprKind::Number(_)) => ExprKind::Missing,
        (Some(token), ExprKind::Path(mut path)) => {
            path.span = path.span.to(token.span());
            path.segments.push(name(token));
            ExprKind::Path(path)
        }
        (Some(token), kind) => ExprKind::Field { base: Box::new(Expr { kind, span: base.span }), name: name(token) },
    }
}

type Terms = std::iter::Peekable<std::vec::IntoIter<Term>>;

fn next_op(terms: &mut Terms, wanted: usize) -> Option<(BinaryOp, Span)> {
    match terms.peek() {
        Some(&Term::Op(op, span)) if level(op) == wanted => {
            terms.next();
            Some((op, span))
        }
        _ => None,
    }
}

fn binary(terms: &mut Terms, wanted: usize, whole: Span) -> Expr {
    if wanted == level(BinaryOp::Pow) {
        return unary(terms, whole);
    }
    let first = binary(terms, wanted + 1, whole);
    let mut rest = Vec::new();
    while let Some((op, op_span)) = next_op(terms, wanted) {
        rest.push(Step { op, op_span, value: binary(terms, wanted + 1, whole) });
    }
    let Some(last) = rest.last() else { return first };
    let span = first.span.to(last.value.span);
    // `0..1..2` and `a < b < c` are reported.
    match matches!(wanted, RANGE | COMPARISON) && rest.len() > 1 {
        true => missing(span),
        false => Expr { kind: ExprKind::Binary { first: Box::new(first), rest }, span },
    }
}

/// A prefix binds looser than `^` on its right and tighter than all else: `-a^2` is `-(a^2)`, `a^-b` is `a^(-b)`.
fn unary(terms: &mut Terms, whole: Span) -> Expr {
    let first = match terms.next() {
        Some(Term::Prefix(op, op_span)) => {
            let value = unary(terms, whole);
            let span = op_span.to(value.span);
            return Expr { kind: ExprKind::Unary { op, op_span, value: Box::new(value) }, span };
        }
        Some(Term::Operand(operand)) => operand,
        Some(Term::Op(..)) | None => return missing(Span::at(whole.end)),
    };
    match next_op(terms, level(BinaryOp::Pow)) {
        None => first,
        Some((op, op_span)) => {
            let value = unary(terms, whole);
            let span = first.span.to(value.span);
            let rest = vec![Step { op, op_span, value }];
            Expr { kind: ExprKind::Binary { first: Box::new(first), rest }, span }
        }
    }
}
