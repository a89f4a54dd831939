//! Nodes written as values inside loops and calls: those that do not depend on the turn are made once.

use std::rc::Rc;

use crate::eval::expr::Env;
use crate::eval::machine::Machine;
use crate::eval::scope::Scope;
use crate::syntax::ast::{Arg, Block, Expr, ExprKind, FnBody, ForHead, Formal, Item, KeyValue, Node, Path};
use crate::value::{NodeId, Value};

impl<'a> Machine<'a> {
    /// A node written as a value.
    pub fn inline_node(&mut self, node: &'a Node, env: &Env<'a>) -> Value {
        let shared = self.outside_of_turns(node, env);
        let key = shared.as_ref().map(|scope| (std::ptr::from_ref(node), Rc::as_ptr(scope)));
        if let Some((id, _)) = key.and_then(|key| self.inline.get(&key)) {
            return Value::Node(*id);
        }
        let Some(id) = self.slot(node, env) else { return Value::Error };
        self.force(id);
        if let Some((key, scope)) = key.zip(shared) {
            self.inline.insert(key, (id, scope));
        }
        Value::Node(id)
    }

    /// The innermost scope that declares a name of the node, if a loop or a call lies between it and the node.
    fn outside_of_turns(&mut self, node: &'a Node, env: &Env<'a>) -> Option<Rc<Scope<'a>>> {
        if !env.around().any(|scope| scope.is_of_turn()) {
            return None;
        }
        let names = self.inline_names.entry(std::ptr::from_ref(node)).or_insert_with(|| {
            let mut names = Names::default();
            names.node(node);
            names.0.sort_unstable();
            names.0.dedup();
            names.0.into()
        });
        let mut inside_turn = false;
        for scope in env.around() {
            if names.iter().any(|name| scope.has(name)) {
                return inside_turn.then(|| scope.clone());
            }
            inside_turn |= scope.is_of_turn();
            if scope.is_outermost() {
                return inside_turn.then(|| scope.clone());
            }
        }
        None
    }
}

/// A node that was made once: what it is found by, and what keeps that alive.
pub type Inline<'a> = rustc_hash::FxHashMap<(*const Node, *const Scope<'a>), (NodeId, Rc<Scope<'a>>)>;

/// The names that a node may ask its surroundings for: too many rather than too few.
#[derive(Default)]
struct Names<'a>(Vec<&'a str>);

impl<'a> Names<'a> {
    fn path(&mut self, path: &'a Path) {
        self.0.extend(path.segments.first().map(|name| &*name.text));
    }

    fn node(&mut self, node: &'a Node) {
        self.path(&node.kind);
        self.exprs(&node.like);
        self.blocks(&node.body);
    }

    fn blocks(&mut self, blocks: impl IntoIterator<Item = &'a Block>) {
        blocks.into_iter().flat_map(|block| &block.items).for_each(|item| self.item(item));
    }

    fn head(&mut self, head: &'a ForHead) {
        self.expr(&head.over);
    }

    fn formals(&mut self, formals: &'a [Formal]) {
        self.exprs(formals.iter().filter_map(|formal| formal.default.as_ref()));
    }

    fn item(&mut self, item: &'a Item) {
        match item {
            Item::Property(property) => self.expr(&property.value),
            Item::Node(node) => self.node(node),
            Item::Let(decl) => self.expr(&decl.value),
            Item::Param(decl) => self.expr(&decl.value),
            Item::Fn(decl) => {
                self.formals(&decl.params);
                match &decl.body {
                    FnBody::Block(block) => self.blocks([block]),
                    FnBody::Value(value) => self.expr(value),
                    FnBody::Missing => {}
                }
            }
            Item::Prefab(decl) => {
                self.formals(&decl.params);
                self.blocks(&decl.body);
            }
            Item::For(stmt) => {
                self.head(&stmt.head);
                self.blocks(&stmt.body);
            }
            Item::If(stmt) => {
                for (condition, block) in &stmt.arms {
                    self.expr(condition);
                    self.blocks(block);
                }
                self.blocks(&stmt.otherwise);
            }
            Item::Return(stmt) => self.expr(&stmt.value),
            Item::Block(block) => self.blocks([block]),
            Item::Import(_) | Item::Lang(_) => {}
        }
    }

    fn exprs(&mut self, exprs: impl IntoIterator<Item = &'a Expr>) {
        exprs.into_iter().for_each(|expr| self.expr(expr));
    }

    fn args(&mut self, args: &'a [Arg]) {
        self.exprs(args.iter().map(|arg| &arg.value));
    }

    fn expr(&mut self, expr: &'a Expr) {
        match &expr.kind {
            ExprKind::Missing | ExprKind::Number(_) | ExprKind::Color(_) | ExprKind::Str(_) | ExprKind::Bool(_) => {}
            ExprKind::Path(path) => self.path(path),
            ExprKind::Tuple(items) | ExprKind::List(items) => self.exprs(items),
            ExprKind::Comp(comp) => {
                self.head(&comp.head);
                self.exprs(&comp.condition);
                self.expr(&comp.value);
            }
            ExprKind::Unary { value, .. } => self.expr(value),
            ExprKind::Binary { first, rest } => {
                self.expr(first);
                self.exprs(rest.iter().map(|step| &step.value));
            }
            ExprKind::Call { callee, args } => {
                self.expr(callee);
                self.args(args);
            }
            ExprKind::Field { base, .. } => self.expr(base),
            ExprKind::Index { base, index } => self.exprs([&**base, &**index]),
            ExprKind::Node(node) => self.node(node),
            ExprKind::Keys(keys) => {
                self.args(&keys.args);
                for key in &keys.keys {
                    self.expr(&key.time);
                    self.exprs(&key.ease);
                    match &key.value {
                        KeyValue::Value(value) => self.expr(value),
                        KeyValue::Block(block) => self.blocks([block]),
                    }
                }
            }
            ExprKind::If(value) => {
                for (condition, arm) in &value.arms {
                    self.exprs([condition, arm]);
                }
                self.expr(&value.otherwise);
            }
        }
    }
}
