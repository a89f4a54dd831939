//! All that is written in a file, from the outside in.

use crate::syntax::ast::{Arg, Expr, ExprKind, FnBody, ForHead, Formal, Item, Key, KeyValue, Node};

/// Something that is written.
#[derive(Clone, Copy)]
pub enum Seen<'a> {
    Item(&'a Item),
    /// As an item or as a value.
    Node(&'a Node),
    Expr(&'a Expr),
    Formal(&'a Formal),
    Key(&'a Key),
    Head(&'a ForHead),
}

/// Shows everything to `see`, which says whether to go inside.
pub fn walk<'a>(items: &'a [Item], see: &mut dyn FnMut(Seen<'a>) -> bool) {
    items.iter().for_each(|item| walk_item(item, see));
}

fn walk_item<'a>(item: &'a Item, see: &mut dyn FnMut(Seen<'a>) -> bool) {
    if !see(Seen::Item(item)) {
        return;
    }
    match item {
        Item::Property(property) => walk_expr(&property.value, see),
        Item::Node(node) => walk_node(node, see),
        Item::Let(decl) => walk_expr(&decl.value, see),
        Item::Param(decl) => {
            walk_expr(&decl.value, see);
            decl.range.iter().for_each(|range| walk_expr(range, see));
        }
        Item::Fn(decl) => {
            formals(&decl.params, see);
            match &decl.body {
                FnBody::Block(block) => walk(&block.items, see),
                FnBody::Value(value) => walk_expr(value, see),
                FnBody::Missing => {}
            }
        }
        Item::Prefab(decl) => {
            formals(&decl.params, see);
            decl.body.iter().for_each(|body| walk(&body.items, see));
        }
        Item::For(stmt) => {
            walk_head(&stmt.head, see);
            stmt.body.iter().for_each(|body| walk(&body.items, see));
        }
        Item::If(stmt) => {
            for (condition, block) in &stmt.arms {
                walk_expr(condition, see);
                block.iter().for_each(|block| walk(&block.items, see));
            }
            stmt.otherwise.iter().for_each(|block| walk(&block.items, see));
        }
        Item::Return(stmt) => walk_expr(&stmt.value, see),
        Item::Import(_) => {}
        Item::Lang(lang) => walk_expr(&lang.version, see),
        Item::Block(block) => walk(&block.items, see),
    }
}

fn formals<'a>(formals: &'a [Formal], see: &mut dyn FnMut(Seen<'a>) -> bool) {
    for formal in formals {
        if see(Seen::Formal(formal)) {
            formal.default.iter().for_each(|default| walk_expr(default, see));
        }
    }
}

fn walk_head<'a>(head: &'a ForHead, see: &mut dyn FnMut(Seen<'a>) -> bool) {
    if see(Seen::Head(head)) {
        walk_expr(&head.over, see);
    }
}

fn walk_node<'a>(node: &'a Node, see: &mut dyn FnMut(Seen<'a>) -> bool) {
    if see(Seen::Node(node)) {
        node.like.iter().for_each(|like| walk_expr(like, see));
        node.body.iter().for_each(|body| walk(&body.items, see));
    }
}

fn arguments<'a>(args: &'a [Arg], see: &mut dyn FnMut(Seen<'a>) -> bool) {
    args.iter().for_each(|arg| walk_expr(&arg.value, see));
}

fn walk_expr<'a>(expr: &'a Expr, see: &mut dyn FnMut(Seen<'a>) -> bool) {
    if !see(Seen::Expr(expr)) {
        return;
    }
    match &expr.kind {
        ExprKind::Missing
        | ExprKind::Number(_)
        | ExprKind::Color(_)
        | ExprKind::Str(_)
        | ExprKind::Bool(_)
        | ExprKind::Path(_) => {}
        ExprKind::Tuple(items) | ExprKind::List(items) => items.iter().for_each(|item| walk_expr(item, see)),
        ExprKind::Comp(comp) => {
            walk_head(&comp.head, see);
            comp.condition.iter().for_each(|condition| walk_expr(condition, see));
            walk_expr(&comp.value, see);
        }
        ExprKind::Unary { value, .. } => walk_expr(value, see),
        ExprKind::Binary { first, rest } => {
            walk_expr(first, see);
            rest.iter().for_each(|step| walk_expr(&step.value, see));
        }
        ExprKind::Call { callee, args } => {
            walk_expr(callee, see);
            arguments(args, see);
        }
        ExprKind::Field { base, .. } => walk_expr(base, see),
        ExprKind::Index { base, index } => {
            walk_expr(base, see);
            walk_expr(index, see);
        }
        ExprKind::Node(node) => walk_node(node, see),
        ExprKind::Keys(keys) => {
            arguments(&keys.args, see);
            for key in &keys.keys {
                if !see(Seen::Key(key)) {
                    continue;
                }
                walk_expr(&key.time, see);
                match &key.value {
                    KeyValue::Value(value) => walk_expr(value, see),
                    KeyValue::Block(block) => walk(&block.items, see),
                }
                key.ease.iter().for_each(|ease| walk_expr(ease, see));
            }
        }
        ExprKind::If(value) => {
            for (condition, arm) in &value.arms {
                walk_expr(condition, see);
                walk_expr(arm, see);
            }
            walk_expr(&value.otherwise, see);
        }
    }
}
