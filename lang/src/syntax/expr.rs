//! Tree to [`ast`](super::ast): values. Here the flat list of an expression gets its precedence.

use super::ast::*;
use super::kind::{SyntaxElement, SyntaxKind, SyntaxNode, SyntaxToken};
use super::lower::*;
use super::text::{color, number, unescape};
use crate::source::Span;
use rowan::NodeOrToken;

/// What an element adds to the depth of the values in it, at most: see [`MAX_DEPTH`].
pub(super) fn depth_cost(node: &SyntaxNode) -> u32 {
    use SyntaxKind as K;
    match node.kind() {
        K::Expr | K::Named => {
            let mut cost: u32 = 1;
            let mut levels = [false; 7];
            for part in node.children_with_tokens() {
                match part {
                    NodeOrToken::Token(token) if token.kind() == K::Op => match binary_op(token.text()) {
                        BinaryOp::Pow => cost = cost.saturating_add(1),
                        op => levels[level(op)] = true,
                    },
                    part if matches!(part.kind(), K::Prefix | K::Field | K::Index | K::Args) => {
                        cost = cost.saturating_add(1)
                    }
                    _ => {}
                }
            }
            cost.saturating_add(levels.iter().filter(|used| **used).count() as u32)
        }
        K::Tuple | K::List | K::Comp | K::Args | K::Index | K::Keys | K::IfValue | K::Block => 1,
        _ => 0,
    }
}

/// The value of an element; missing if it is none.
pub(super) fn value(element: &SyntaxElement) -> Expr {
    let span = span(element);
    let kind = match element {
        NodeOrToken::Token(token) => leaf(token),
        NodeOrToken::Node(node) => match node.kind() {
            SyntaxKind::Number => number_of(node),
            SyntaxKind::Expr => return flat(node),
            SyntaxKind::Named if is_node(node) => {
                scene_node(node, None).map_or(ExprKind::Missing, |node| ExprKind::Node(Box::new(node)))
            }
            SyntaxKind::Named => return flat(node),
            SyntaxKind::Tuple => tuple(node),
            SyntaxKind::List => list(node),
            SyntaxKind::Keys => ExprKind::Keys(Box::new(keys(node))),
            SyntaxKind::IfValue => if_value(node),
            _ => ExprKind::Missing,
        },
    };
    Expr { kind, span }
}

fn is_node(named: &SyntaxNode) -> bool {
    named.children().any(|child| matches!(child.kind(), SyntaxKind::Block | SyntaxKind::Like))
}

fn leaf(token: &SyntaxToken) -> ExprKind {
    match token.kind() {
        SyntaxKind::Color => color(token.text()).map_or(ExprKind::Missing, ExprKind::Color),
        SyntaxKind::String => ExprKind::Str(unescape(token.text()).text.into()),
        SyntaxKind::Boolean => ExprKind::Bool(token.text() == "true"),
        SyntaxKind::Path => ExprKind::Path(path(token)),
        _ => ExprKind::Missing,
    }
}

fn number_of(node: &SyntaxNode) -> ExprKind {
    let mut digits = String::new();
    let mut unit = None;
    for token in node.children_with_tokens().filter_map(|part| part.into_token()) {
        match token.kind() {
            SyntaxKind::Digits => digits.push_str(token.text()),
            SyntaxKind::Unit => unit = Some(name(&token)),
            _ => return ExprKind::Missing,
        }
    }
    ExprKind::Number(number(&digits, unit))
}

/// Whether a bracket holds something that could not be read, so that nothing is known about the number of its values.
fn is_broken(node: &SyntaxNode) -> bool {
    node.children_with_tokens().any(|part| {
        matches!(part.kind(), SyntaxKind::Unclosed | SyntaxKind::ExtraComma | SyntaxKind::BadElem | SyntaxKind::BadItem)
    })
}

/// The values of a bracket. A path token is a value only inside of an expression.
fn values(node: &SyntaxNode) -> Vec<Expr> {
    parts(node).filter(|part| part.kind().is_value()).map(|part| value(&part)).collect()
}

fn tuple(node: &SyntaxNode) -> ExprKind {
    let mut values = values(node);
    match values.len() {
        _ if is_broken(node) => ExprKind::Missing,
        1 => values.pop().map_or(ExprKind::Missing, |only| only.kind),
        _ => ExprKind::Tuple(values),
    }
}

fn list(node: &SyntaxNode) -> ExprKind {
    let Some(comp) = child(node, SyntaxKind::Comp) else {
        return if is_broken(node) { ExprKind::Missing } else { ExprKind::List(values(node)) };
    };
    let condition = value_after(&comp, SyntaxKind::KwIf);
    let value = value_after(&comp, SyntaxKind::Colon).unwrap_or_else(|| missing_in(&comp));
    ExprKind::Comp(Box::new(Comp { head: for_head(&comp), condition, value }))
}

/// The arguments of a call; nothing if they could not be read.
fn args(node: &SyntaxNode) -> Option<Vec<Arg>> {
    if is_broken(node) {
        return None;
    }
    let args = parts(node).filter_map(|part| {
        let span = span(&part);
        match part {
            NodeOrToken::Node(named) if named.kind() == SyntaxKind::NamedArg => {
                let key = parts(&named).find_map(|part| part.into_token())?;
                let value = value_after(&named, SyntaxKind::Colon).unwrap_or_else(|| missing_in(&named));
                Some(Arg { name: Some(name(&key)), value, span })
            }
            part if part.kind().is_value() => Some(Arg { name: None, value: value(&part), span }),
            _ => None,
        }
    });
    Some(args.collect())
}

fn keys(node: &SyntaxNode) -> Keys {
    let block = child(node, SyntaxKind::KeyBlock);
    let keys = block.iter().flat_map(|block| block.children()).filter(|key| key.kind() == SyntaxKind::Key);
    Keys {
        args: child(node, SyntaxKind::Args).and_then(|node| args(&node)).unwrap_or_default(),
        keys: keys.map(|node| key(&node)).collect(),
        block: block.as_ref().map(node_span),
    }
}

fn key(node: &SyntaxNode) -> Key {
    let at_end = || missing_in(node);
    let mut rest = parts(node);
    let mut first = rest.next();
    let after = first.as_ref().is_some_and(|part| part.kind() == SyntaxKind::KwAfter);
    if after {
        first = rest.next();
    }
    let time = first.map_or_else(at_end, |part| value(&part));
    let reached = match rest.next().map(|part| part.kind()) {
        Some(SyntaxKind::Colon) => rest.next(),
        _ => None,
    };
    let reached = match reached {
        Some(NodeOrToken::Node(node)) if node.kind() == SyntaxKind::Block => KeyValue::Block(block(&node)),
        Some(part) => KeyValue::Value(value(&part)),
        None => KeyValue::Value(at_end()),
    };
    Key { after, time, value: reached, ease: value_after(node, SyntaxKind::KwEase), span: node_span(node) }
}

fn if_value(node: &SyntaxNode) -> ExprKind {
    let Branches { arms, otherwise } = branches(node);
    let arm = |arm: Option<SyntaxNode>| {
        let found = arm.as_ref().and_then(|arm| parts(arm).find(|part| part.kind().is_value()));
        found.map_or_else(|| missing_in(arm.as_ref().unwrap_or(node)), |part| value(&part))
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

enum Part {
    Prefix(UnaryOp, Span),
    Operand(Expr),
    Op(BinaryOp, Span),
}

/// `prefix* primary postfix* (op prefix* primary postfix*)*`
fn flat(node: &SyntaxNode) -> Expr {
    let mut list: Vec<Part> = Vec::new();
    for part in parts(node) {
        let place = span(&part);
        match part {
            NodeOrToken::Token(token) if token.kind() == SyntaxKind::Prefix => {
                let op = if token.text() == "!" { UnaryOp::Not } else { UnaryOp::Neg };
                list.push(Part::Prefix(op, place));
            }
            NodeOrToken::Token(token) if token.kind() == SyntaxKind::Op => {
                list.push(Part::Op(binary_op(token.text()), place));
            }
            NodeOrToken::Node(postfix)
                if matches!(postfix.kind(), SyntaxKind::Args | SyntaxKind::Field | SyntaxKind::Index) =>
            {
                if let Some(Part::Operand(base)) = list.pop() {
                    let span = base.span.to(place);
                    list.push(Part::Operand(Expr { kind: postfixed(base, &postfix), span }));
                }
            }
            part => list.push(Part::Operand(value(&part))),
        }
    }
    let mut list = list.into_iter().peekable();
    binary(&mut list, 0, node_span(node))
}

fn postfixed(base: Expr, postfix: &SyntaxNode) -> ExprKind {
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
                ExprKind::Index { base: Box::new(base), index: Box::new(value(&index)) }
            }
            _ => ExprKind::Missing,
        },
        _ => field(base, postfix),
    }
}

fn field(base: Expr, postfix: &SyntaxNode) -> ExprKind {
    let found = parts(postfix).filter_map(|part| part.into_token()).find(|token| token.kind() == SyntaxKind::Ident);
    match (found, base.kind) {
        // `1.` and what follows: reported.
        (None, _) | (_, ExprKind::Number(_)) => ExprKind::Missing,
        (Some(token), ExprKind::Path(mut path)) => {
            path.span = path.span.to(token_span(&token));
            path.segments.push(name(&token));
            ExprKind::Path(path)
        }
        (Some(token), kind) => ExprKind::Field { base: Box::new(Expr { kind, span: base.span }), name: name(&token) },
    }
}

type Parts = std::iter::Peekable<std::vec::IntoIter<Part>>;

fn next_op(parts: &mut Parts, wanted: usize) -> Option<(BinaryOp, Span)> {
    match parts.peek() {
        Some(&Part::Op(op, span)) if level(op) == wanted => {
            parts.next();
            Some((op, span))
        }
        _ => None,
    }
}

fn binary(parts: &mut Parts, wanted: usize, whole: Span) -> Expr {
    if wanted == level(BinaryOp::Pow) {
        return unary(parts, whole);
    }
    let first = binary(parts, wanted + 1, whole);
    let mut rest = Vec::new();
    while let Some((op, op_span)) = next_op(parts, wanted) {
        rest.push(Step { op, op_span, value: binary(parts, wanted + 1, whole) });
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
fn unary(parts: &mut Parts, whole: Span) -> Expr {
    let first = match parts.next() {
        Some(Part::Prefix(op, op_span)) => {
            let value = unary(parts, whole);
            let span = op_span.to(value.span);
            return Expr { kind: ExprKind::Unary { op, op_span, value: Box::new(value) }, span };
        }
        Some(Part::Operand(operand)) => operand,
        Some(Part::Op(..)) | None => return missing(Span::at(whole.end)),
    };
    match next_op(parts, level(BinaryOp::Pow)) {
        None => first,
        Some((op, op_span)) => {
            let value = unary(parts, whole);
            let span = first.span.to(value.span);
            let rest = vec![Step { op, op_span, value }];
            Expr { kind: ExprKind::Binary { first: Box::new(first), rest }, span }
        }
    }
}
