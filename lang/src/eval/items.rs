//! Items: declarations, nodes, loops and conditions.

use std::cell::RefCell;
use std::rc::Rc;

use glam::{DQuat, DVec3};
use kinora_scene::Placement;

use crate::diagnostic::Diagnostic;
use crate::dimension::{Dimension, short};
use crate::eval::coerce::{Data, Site};
use crate::eval::expr::{Argument, Env, Words, spaced};
use crate::eval::graph::Scalar;
use crate::eval::limits;
use crate::eval::machine::{Given, Machine, NodeKind, NodeSlot, NodeState, NodeValue, Set};
use crate::eval::scope::{Binding, LetCell, LetState, Scope};
use crate::schema::{self, Kind, Since, Type};
use crate::source::{FileId, Span};
use crate::syntax::ast::{self, Expr, ExprKind, Item};
use crate::value::{NodeId, Number, Value};

/// What the items of a block go into.
pub struct Owner<'a, 'o> {
    /// The kind whose properties are set, in a node's body.
    pub kind: Option<&'static Kind>,
    /// The properties set.
    pub properties: &'o mut Vec<Set<'a>>,
    /// The nodes made.
    pub children: &'o mut Vec<NodeId>,
}

impl<'a> Machine<'a> {
    /// Declares what a block's items declare.
    pub fn hoist(&mut self, items: &'a [Item], env: &Env<'a>) {
        for item in items {
            match item {
                Item::Let(decl) => {
                    if let Some(name) = &decl.name {
                        let state = RefCell::new(LetState::Waiting);
                        let (ty, value) = (decl.ty.as_ref(), &decl.value);
                        let cell = LetCell { name: Some(name), ty, value, overridden: false, state };
                        env.declare(&name.text, Binding::Let(Rc::new(cell)));
                    }
                }
                Item::Fn(decl) => {
                    if let Some(name) = &decl.name {
                        env.declare(&name.text, Binding::Fn(decl));
                    }
                }
                Item::Prefab(decl) => {
                    if let Some(name) = &decl.name {
                        env.declare(&name.text, Binding::Prefab(decl));
                    }
                }
                Item::Node(node) => {
                    if let Some(name) = &node.name
                        && let Some(id) = self.slot(node, env)
                    {
                        env.declare(&name.text, Binding::Node(id));
                    }
                }
                Item::Import(import) => {
                    for rename in import.names.iter().flatten() {
                        env.declare(&rename.alias.as_ref().unwrap_or(&rename.name).text, Binding::Opaque);
                    }
                    if let Some(alias) = &import.alias {
                        env.declare(&alias.text, Binding::Opaque);
                    }
                }
                _ => {}
            }
        }
    }

    /// A place for a node's value.
    pub fn slot(&mut self, node: &'a ast::Node, env: &Env<'a>) -> Option<NodeId> {
        if self.nodes.len() >= limits::NODES {
            self.too_many("nodes", limits::NODES, node.kind.span);
            return None;
        }
        let id = NodeId(self.nodes.len() as u32);
        let (scope, trace) = (env.clone(), self.trace.clone());
        let state = NodeState::Waiting;
        self.nodes.push(NodeSlot { ast: node, mixed: None, scope, trace, state, copies: Vec::new() });
        Some(id)
    }

    /// The material that `mix(a, b, amount: ..)` makes; each argument with its value.
    pub fn mix(&mut self, given: [(Value, &'a Expr); 3], span: Span, env: &Env<'a>) -> Value {
        let kind = &schema::MIX;
        let mut properties = Vec::with_capacity(given.len());
        for (property, (value, expr)) in kind.all().zip(given) {
            let site = Site { property, kind, name: expr.span, expr };
            let Some(data) = self.fit(&value, &site) else { return Value::Error };
            properties.push(Set { property, data: Some(data), value, name: expr.span, expr });
        }
        let Some(id) = self.slot(self.mix, env) else { return Value::Error };
        let node = NodeValue { kind: NodeKind::Schema(kind), properties, ..NodeValue::default() };
        if let Some(slot) = self.nodes.get_mut(id.0 as usize) {
            (slot.mixed, slot.state) = (Some(span), NodeState::Done(Rc::new(node)));
        }
        Value::Node(id)
    }

    /// Runs a block's items in a scope of their own.
    pub fn run_block(&mut self, items: &'a [Item], env: &Env<'a>, owner: &mut Owner<'a, '_>) {
        let inner = Scope::inside(env);
        self.hoist(items, &inner);
        self.run(items, &inner, owner);
    }

    /// Runs items whose names are declared.
    pub fn run(&mut self, items: &'a [Item], env: &Env<'a>, owner: &mut Owner<'a, '_>) {
        if let Some(first) = items.first()
            && !self.step(items.len() as u64 / 8, first.span())
        {
            return;
        }
        for item in items {
            let cost = u64::from(!matches!(item, Item::Property(_)));
            if !self.enter(cost, item.span()) {
                return;
            }
            self.run_item(item, env, owner);
            self.leave();
        }
    }

    fn run_item(&mut self, item: &'a Item, env: &Env<'a>, owner: &mut Owner<'a, '_>) {
        match item {
            Item::Property(property) => self.property(property, env, owner),
            Item::Node(node) => {
                let named = node.name.as_ref().and_then(|name| env.own(&name.text));
                let id = match named {
                    Some(Binding::Node(id)) if std::ptr::eq(self.nodes[id.0 as usize].ast, node) => Some(id),
                    // A second node of one name: reported, but worth checking.
                    _ => self.slot(node, env),
                };
                if let Some(id) = id {
                    self.force(id);
                    if !self.is_one_more(id, owner.children) {
                        owner.children.push(id);
                    }
                }
            }
            Item::Let(decl) => {
                if let Some(name) = &decl.name
                    && let Some(Binding::Let(cell)) = env.own(&name.text)
                {
                    self.force_let(&cell, env);
                }
            }
            Item::For(stmt) => {
                let Some(body) = &stmt.body else { return };
                self.each(&stmt.head, env, "nodes", |machine, scope| {
                    machine.hoist(&body.items, scope);
                    machine.run(&body.items, scope, owner);
                    true
                });
            }
            Item::If(stmt) => {
                if let Some(block) = self.branch(stmt, env, "the number of nodes") {
                    self.run_block(&block.items, env, owner);
                }
            }
            Item::Block(block) => {
                // Its head could not be read, so what it holds belongs to nothing: it is only checked.
                let (mut properties, mut children) = (Vec::new(), Vec::new());
                let mut nowhere = Owner { kind: None, properties: &mut properties, children: &mut children };
                self.run_block(&block.items, env, &mut nowhere);
            }
            Item::Fn(_) | Item::Prefab(_) | Item::Param(_) | Item::Import(_) | Item::Lang(_) | Item::Return(_) => {}
        }
    }

    /// Whether an instance stands still and differs from one before it in its place alone, as a loop makes them: then that
    /// one takes its place over and the node is gone, so that a million of them are a million places.
    fn is_one_more(&mut self, id: NodeId, siblings: &[NodeId]) -> bool {
        let at = id.0 as usize;
        let Some(slot) = self.nodes.last().filter(|slot| at + 1 == self.nodes.len() && slot.ast.name.is_none()) else {
            return false;
        };
        let ast: *const ast::Node = slot.ast;
        let NodeState::Done(value) = &slot.state else { return false };
        let Some(place) = placement(value) else { return false };
        let same = |set: &Set<'a>, other: &NodeValue<'a>| {
            let set_there = |of: &Set<'a>| of.property.name == set.property.name && of.data == set.data;
            place_property(set.property.name) || other.properties.iter().any(set_there)
        };
        let of_same = |sibling: &&NodeId| {
            let Some(other) = self.nodes.get(sibling.0 as usize).filter(|slot| std::ptr::eq(slot.ast, ast)) else {
                return false;
            };
            let NodeState::Done(other) = &other.state else { return false };
            placement(other).is_some()
                && value.properties.iter().all(|set| same(set, other))
                && other.properties.iter().all(|set| same(set, value))
        };
        let Some(first) = siblings.iter().rev().take(SIBLINGS).find(of_same).copied() else { return false };
        let span = slot.ast.kind.span;
        self.copies += 1;
        if self.copies >= limits::INSTANCES {
            self.too_many("instances", limits::INSTANCES, span);
            return true;
        }
        self.nodes.pop();
        if let Some(slot) = self.nodes.get_mut(first.0 as usize) {
            slot.copies.push(place);
        }
        true
    }

    /// The block of an `if` that is taken.
    fn branch(&mut self, stmt: &'a ast::IfStmt, env: &Env<'a>, what: &str) -> Option<&'a ast::Block> {
        for (condition, block) in &stmt.arms {
            match self.condition(condition, env)? {
                Scalar::Const(0.0) => {}
                Scalar::Const(_) => return block.as_ref(),
                moving => {
                    self.structure(what, moving, condition.span, stmt.span);
                    return None;
                }
            }
        }
        stmt.otherwise.as_ref()
    }

    /// Runs `body` once for each item of a loop's list, until it returns false. False if the loop could not be run.
    pub fn each(
        &mut self,
        head: &'a ast::ForHead,
        env: &Env<'a>,
        what: &str,
        mut body: impl FnMut(&mut Self, &Env<'a>) -> bool,
    ) -> bool {
        let over = self.rooted(&head.over, env, |machine| machine.plain(&head.over, env));
        let (count, item): (f64, Box<dyn Fn(usize) -> Value>) = match over {
            Value::Error => return false,
            Value::List(items) => {
                (items.len() as f64, Box::new(move |i| items.get(i).cloned().unwrap_or(Value::Error)))
            }
            Value::Range(from, to) => {
                let (Scalar::Const(start), Scalar::Const(end)) = (from.value, to.value) else {
                    let counted = if what == "nodes" { "the number of nodes" } else { "the length of a list" };
                    let moving = if from.value.constant().is_some() { to.value } else { from.value };
                    self.rooted(&head.over, env, |machine| {
                        machine.structure(counted, moving, head.over.span, head.span);
                    });
                    return false;
                };
                let count = (end - start).max(0.0).ceil();
                if count > limits::LOOP as f64 {
                    let limit = spaced(limits::LOOP as f64);
                    let message = format!("loop would run {} times, limit {limit}", spaced(count));
                    let diagnostic = Diagnostic::new("E1002", message)
                        .primary(self.file(), head.over.span, "too many")
                        .help("make the range shorter");
                    self.report(diagnostic);
                    return false;
                }
                for number in [from, to] {
                    if self.whole(&Value::Number(number), head.over.span).is_none() {
                        return false;
                    }
                }
                (count, Box::new(move |i| Value::Number(Number::int(start + i as f64))))
            }
            other => {
                let found = self.describe(&other);
                let diagnostic = Diagnostic::new("E0301", format!("expected a list or a range, found {found}"))
                    .primary(self.file(), head.over.span, format!("this is {found}"))
                    .help("count with `for i in 0..10`");
                self.report(diagnostic);
                return false;
            }
        };
        for i in 0..count as usize {
            if !self.step(1, head.span) {
                return false;
            }
            let scope = Scope::of_turn(env);
            let mut shown = Vec::with_capacity(head.names.len());
            let mut name = |name: &'a ast::Name, value: Value| {
                shown.push(Given { name: &name.text, value: value.clone(), expr: None });
                scope.declare(&name.text, Binding::Value(value));
            };
            match head.names.as_slice() {
                [only] => name(only, item(i)),
                [first, second, ..] => {
                    name(first, Value::Number(Number::int(i as f64)));
                    name(second, item(i));
                }
                [] => {}
            }
            if !self.traced(None, head.span, shown, env, |machine| body(machine, &scope)) {
                return false;
            }
        }
        true
    }

    /// Runs a function's items until one returns.
    pub fn run_function(&mut self, items: &'a [Item], env: &Env<'a>) -> Option<Value> {
        let inner = Scope::inside(env);
        self.hoist(items, &inner);
        for item in items {
            if !self.enter(1, item.span()) {
                return Some(Value::Error);
            }
            let result = self.run_statement(item, &inner);
            self.leave();
            if result.is_some() {
                return result;
            }
        }
        None
    }

    fn run_statement(&mut self, item: &'a Item, env: &Env<'a>) -> Option<Value> {
        match item {
            Item::Return(stmt) => Some(self.rooted(&stmt.value, env, |machine| machine.expr(&stmt.value, env, &[]))),
            Item::Let(decl) => {
                let name = decl.name.as_ref()?;
                if let Some(Binding::Let(cell)) = env.own(&name.text) {
                    self.force_let(&cell, env);
                }
                None
            }
            Item::If(stmt) => {
                for (condition, block) in &stmt.arms {
                    match self.condition(condition, env) {
                        None => return Some(Value::Error),
                        Some(Scalar::Const(0.0)) => {}
                        Some(Scalar::Const(_)) => return self.run_function(&block.as_ref()?.items, env),
                        Some(moving) => {
                            self.structure("which `return` is reached", moving, condition.span, condition.span);
                            return Some(Value::Error);
                        }
                    }
                }
                self.run_function(&stmt.otherwise.as_ref()?.items, env)
            }
            Item::For(stmt) => {
                let body = stmt.body.as_ref()?;
                let mut result = None;
                let complete = self.each(&stmt.head, env, "a list", |machine, scope| {
                    result = machine.run_function(&body.items, scope);
                    result.is_none()
                });
                if !complete && result.is_none() { Some(Value::Error) } else { result }
            }
            _ => None,
        }
    }

    /// What a node is, by its kind's name.
    pub fn kind_of(&self, id: NodeId) -> NodeKind<'a> {
        let Some(slot) = self.nodes.get(id.0 as usize) else { return NodeKind::Unknown };
        if slot.mixed.is_some() {
            return NodeKind::Schema(&schema::MIX);
        }
        let path = slot.ast.kind.segments.as_slice();
        let is_kind = |binding: &Binding<'_>| matches!(binding, Binding::Prefab(_) | Binding::Opaque);
        match (slot.scope.find_path(path, is_kind), path) {
            (Some((_, Binding::Prefab(decl), names)), _) if names == path.len() => NodeKind::Prefab(decl),
            (None, [name]) => schema::kind(&name.text).map_or(NodeKind::Unknown, NodeKind::Schema),
            _ => NodeKind::Unknown,
        }
    }

    /// The node's value; `None` while it is being evaluated, which is a cycle and reported.
    pub fn force(&mut self, id: NodeId) -> Option<Rc<NodeValue<'a>>> {
        let slot = self.nodes.get_mut(id.0 as usize)?;
        let (ast, span) = (slot.ast, slot.place());
        let name = |machine: &Self| ast.name.as_ref().map_or(machine.text(ast.kind.span), |name| &*name.text);
        match &slot.state {
            NodeState::Done(value) => Some(value.clone()),
            NodeState::Running => {
                self.cycle(name(self), span);
                None
            }
            NodeState::Waiting => {
                slot.state = NodeState::Running;
                let (scope, inner) = (slot.scope.clone(), slot.trace.clone());
                let name = name(self);
                let outer = std::mem::replace(&mut self.trace, inner);
                self.pending.push((name, span));
                let value = match self.enter(1, span) {
                    true => {
                        let value = self.node(id, ast, &scope);
                        self.leave();
                        value
                    }
                    false => NodeValue::default(),
                };
                self.pending.pop();
                self.trace = outer;
                let value = Rc::new(value);
                self.nodes[id.0 as usize].state = NodeState::Done(value.clone());
                Some(value)
            }
        }
    }

    fn node(&mut self, id: NodeId, ast: &'a ast::Node, env: &Env<'a>) -> NodeValue<'a> {
        match self.kind_of(id) {
            NodeKind::Unknown => NodeValue::default(),
            NodeKind::Prefab(decl) => self.prefab(ast, decl, env),
            NodeKind::Schema(kind) => self.schema_node(ast, kind, env),
        }
    }

    /// What a node is `like`, if it is one of the same kind.
    fn like(
        &mut self,
        ast: &'a ast::Node,
        env: &Env<'a>,
        same: impl Fn(&NodeKind<'a>) -> bool,
    ) -> Option<Rc<NodeValue<'a>>> {
        let like = ast.like.as_ref()?;
        let found = self.expr(like, env, &[]);
        let kind = kind_text(ast);
        let id = match found {
            Value::Error => return None,
            Value::Node(id) => id,
            other => {
                let found = self.describe(&other);
                let diagnostic = Diagnostic::new("E0301", format!("expected a `{kind}`, found {found}")).primary(
                    self.file(),
                    like.span,
                    format!("this is {found}"),
                );
                self.report(diagnostic);
                return None;
            }
        };
        let value = self.force(id)?;
        if same(&value.kind) {
            return Some(value);
        }
        if !matches!(value.kind, NodeKind::Unknown) {
            let other = self.nodes.get(id.0 as usize)?;
            let place = other.mixed.unwrap_or(other.ast.kind.span);
            let message = format!("`{}` is a `{}`, expected a `{kind}`", self.text(like.span), kind_text(other.ast));
            let diagnostic = Diagnostic::new("E0204", message)
                .primary(self.file(), like.span, format!("only a `{kind}` can be copied here"))
                .label(self.file(), place, "declared here");
            self.report(diagnostic);
        }
        None
    }

    fn schema_node(&mut self, ast: &'a ast::Node, kind: &'static Kind, env: &Env<'a>) -> NodeValue<'a> {
        let rows = ast.body.as_ref().map_or(0, |body| body.items.len());
        let (mut properties, mut children) = (Vec::with_capacity(rows.min(kind.count())), Vec::new());
        if kind.since != Since::Now {
            self.later(&format!("`{}`", kind.name), ast.kind.span);
            return NodeValue { kind: NodeKind::Schema(kind), ..NodeValue::default() };
        }
        let like = self.like(ast, env, |other| matches!(other, NodeKind::Schema(other) if other.name == kind.name));
        if let Some(body) = &ast.body {
            let mut owner = Owner { kind: Some(kind), properties: &mut properties, children: &mut children };
            self.run_block(&body.items, env, &mut owner);
        }
        if let Some(like) = like {
            for set in &like.properties {
                if properties.iter().all(|own: &Set<'a>| own.property.name != set.property.name) {
                    properties.push(set.clone());
                }
            }
            let own = std::mem::take(&mut children);
            children = like.children.iter().copied().chain(own).collect();
        }
        NodeValue { kind: NodeKind::Schema(kind), properties, children, ..NodeValue::default() }
    }

    fn property(&mut self, property: &'a ast::Property, env: &Env<'a>, owner: &mut Owner<'a, '_>) {
        let Some(kind) = owner.kind else { return };
        let Some(row) = kind.property(&property.name.text) else { return };
        if row.since == Since::Later {
            self.later(&format!("`{}` of `{}`", row.name, kind.name), property.name.span);
            return;
        }
        let words: Words = match row.ty {
            Type::Choice(choices) => choices,
            _ => &[],
        };
        let site = Site { property: row, kind, name: property.name.span, expr: &property.value };
        let (value, data) = self.rooted(&property.value, env, |machine| {
            let value = machine.expr(&property.value, env, words);
            let data = machine.fit(&value, &site);
            (value, data)
        });
        if let Some(first) = owner.properties.iter().find(|set| std::ptr::eq(set.property, row)) {
            let first = first.name;
            let diagnostic = set_twice(row.name, self.file(), property.name.span, first);
            self.report(diagnostic);
            return;
        }
        owner.properties.push(Set { property: row, data, value, name: property.name.span, expr: &property.value });
    }

    fn prefab(&mut self, ast: &'a ast::Node, decl: &'a ast::PrefabDecl, env: &Env<'a>) -> NodeValue<'a> {
        let name = kind_text(ast);
        if self.endless.contains(&decl.head) {
            return NodeValue::default();
        }
        let like = self.like(ast, env, |other| matches!(other, NodeKind::Prefab(other) if std::ptr::eq(*other, decl)));
        let mut given: Vec<Option<Argument<'a>>> = decl.params.iter().map(|_| None).collect();
        for item in ast.body.iter().flat_map(|body| &body.items) {
            if let Item::Property(property) = item
                && let Some(at) = decl.params.iter().position(|formal| formal.name.text == property.name.text)
            {
                let expr = &property.value;
                let value = self.rooted(expr, env, |machine| machine.expr(expr, env, &[]));
                given[at] = Some(Argument { value, expr: Some(expr), span: expr.span });
            }
        }
        let mut arguments: Vec<(&'a str, Value)> = Vec::new();
        for (formal, given) in decl.params.iter().zip(given.iter_mut()) {
            if given.is_none()
                && let Some(like) = &like
                && let Some((_, value)) = like.arguments.iter().find(|(name, _)| *name == &*formal.name.text)
            {
                *given = Some(Argument { value: value.clone(), expr: None, span: ast.kind.span });
            }
            if let Some(given) = given {
                arguments.push((&formal.name.text, given.value.clone()));
            }
        }
        let lexical = env.find_path(&ast.kind.segments, |binding| matches!(binding, Binding::Prefab(_)));
        let outer = lexical.map_or_else(|| self.globals.clone(), |(scope, ..)| scope);
        let Some((scope, given)) = self.bind(&decl.params, given, &outer, env) else { return NodeValue::default() };
        if self.calls >= limits::CALLS {
            self.endless.insert(decl.head);
            let diagnostic = Diagnostic::new("E0504", format!("prefab `{name}` contains itself without end"))
                .primary(self.file(), ast.kind.span, format!("more than {} inside one another", limits::CALLS))
                .label(self.file(), decl.head, "declared here")
                .help("add a depth parameter and an `if`");
            self.report(diagnostic);
            return NodeValue::default();
        }
        let mut children = Vec::new();
        let mut properties = Vec::new();
        let inner = Scope::inside(&scope);
        if let Some(body) = &decl.body {
            self.calls += 1;
            let called = Some(self.text(ast.kind.span));
            self.traced(called, ast.kind.span, given, env, |machine| {
                let mut owner = Owner { kind: None, properties: &mut properties, children: &mut children };
                machine.hoist(&body.items, &inner);
                machine.run(&body.items, &inner, &mut owner);
            });
            self.calls -= 1;
        }
        NodeValue { kind: NodeKind::Prefab(decl), properties, children, arguments, inner: Some(inner) }
    }

    /// `node.property`, or a node inside a prefab.
    pub fn node_field(&mut self, id: NodeId, span: Span, name: &'a ast::Name) -> Value {
        let Some(node) = self.force(id) else { return Value::Error };
        match node.kind {
            NodeKind::Unknown => Value::Error,
            NodeKind::Prefab(decl) => {
                if let Some(inner) = &node.inner
                    && let Some(Binding::Node(id)) = inner.own(&name.text)
                {
                    return Value::Node(id);
                }
                if let Some((_, value)) = node.arguments.iter().find(|(given, _)| *given == &*name.text) {
                    return value.clone();
                }
                let prefab = decl.name.as_ref().map_or("", |name| &name.text);
                let diagnostic = Diagnostic::new("E0214", format!("`{prefab}` has no node `{}`", name.text))
                    .primary(self.file(), name.span, "no such node inside")
                    .label(self.file(), decl.head, "declared here");
                self.error(diagnostic)
            }
            NodeKind::Schema(kind) => {
                if let Some(set) = node.properties.iter().find(|set| set.property.name == &*name.text) {
                    return set.value.clone();
                }
                if kind.since != Since::Now {
                    return Value::Error;
                }
                if let Some(value) = kind.property(&name.text).and_then(default_value) {
                    return value;
                }
                let known = kind.property(&name.text).is_some();
                if kind.name == "model" && !known {
                    return Value::Inner(id, name.text.as_ref().into());
                }
                let what = if known { "is not set here" } else { "is not a property of it" };
                let diagnostic = Diagnostic::new(
                    "E0214",
                    format!("`{}` has no value `{}`", self.text(span), name.text),
                )
                .primary(self.file(), name.span, what);
                self.error(diagnostic)
            }
        }
    }

    /// A property of the file's `render` block that other values depend on, with its place.
    fn clock(&mut self, property: &str, dimension: Dimension) -> Option<(f64, Span)> {
        let globals = self.globals.clone();
        let item = self.render?.body.as_ref()?.items.iter().find_map(|item| match item {
            Item::Property(row) if &*row.name.text == property => Some(row),
            _ => None,
        })?;
        match self.plain(&item.value, &globals) {
            Value::Number(number) if number.dimension == dimension || number.dimension.is_none() => {
                let value = number.value.constant().filter(|value| value.is_finite() && *value > 0.0)?;
                Some((value, item.value.span))
            }
            _ => None,
        }
    }

    /// Frames a second, if the scene says.
    pub fn frames_per_second(&mut self) -> Option<f64> {
        if self.fps.is_none() {
            self.fps = Some(None);
            self.fps = Some(self.clock("fps", Dimension::NONE).map(|found| found.0));
        }
        self.fps.flatten()
    }

    /// The scene's length in seconds, if it says.
    pub fn duration(&mut self) -> Option<(f64, Span)> {
        if self.end.is_none() {
            self.end = Some(None);
            self.end = Some(self.clock("duration", Dimension::TIME));
        }
        self.end.flatten()
    }

    /// The part of a frame during which the shutter is open, 0..=1.
    pub fn shutter(&mut self) -> f64 {
        self.clock("shutter", Dimension::ANGLE).map_or(0.0, |(angle, _)| angle / std::f64::consts::TAU)
    }

    /// The value as a declared type takes it; an error where it does not.
    pub fn convert(&mut self, value: Value, ty: &'a ast::Type, span: Span) -> Value {
        let names: Vec<&str> = ty.names.iter().map(|name| &*name.text).collect();
        let plain = match (&value, names.first()) {
            // Keys stay whole where nothing is asked of them but what each key has.
            (Value::Keys(keyed), _) => keyed.keys.first().map_or(Value::Error, |key| key.value.clone()),
            _ => value.clone(),
        };
        match convert(&plain, &names, &|id| self.kind_of(id)) {
            Converted::Fits => value,
            Converted::As(number) if !matches!(value, Value::Keys(_)) => number,
            Converted::As(_) => value,
            Converted::Whole => {
                let mut label = String::new();
                if let Value::Number(number) = &plain
                    && let Some(found) = number.value.constant()
                {
                    label = self.computed("this is", found, number.dimension, span);
                }
                let diagnostic = Diagnostic::new("E0310", "expected a whole number")
                    .primary(self.file(), span, label)
                    .label(self.file(), ty.span, "asked for here")
                    .help("use `floor()` or `round()`");
                self.error(diagnostic)
            }
            Converted::Unit(dimension) => {
                let number = match plain {
                    Value::Number(number) => number,
                    _ => Number::int(0.0),
                };
                let diagnostic = self.without_unit(dimension, number, span);
                self.error(diagnostic.label(self.file(), ty.span, "asked for here"))
            }
            Converted::Wrong(wanted) => {
                if plain.is_error() {
                    return Value::Error;
                }
                if let (Some(expected), Value::Tuple(items)) = (vector_type(&names), &plain)
                    && plain.numbers().is_some()
                {
                    let diagnostic = wrong_count(expected, items.len(), self.file(), span);
                    return self.error(diagnostic.label(self.file(), ty.span, "asked for here"));
                }
                if let (Some((_, inner)), Value::List(items)) = (names.split_first(), &plain)
                    && let Some(odd) = items.iter().find(|item| !fits(item, inner, &|id| self.kind_of(id)))
                {
                    let found = self.describe(odd);
                    let message = format!("expected {wanted} as each item of the list, found {found}");
                    let diagnostic = Diagnostic::new("E0313", message)
                        .primary(self.file(), span, format!("{found} is in this list"))
                        .label(self.file(), ty.span, "asked for here");
                    return self.error(diagnostic);
                }
                let found = self.describe(&plain);
                let code = match (&plain, wanted.as_str()) {
                    (Value::Node(_), _) => "E0204",
                    (Value::Number(_), _) if number_type(names.first().copied().unwrap_or("")).is_some() => "E0302",
                    (_, "a colour") => "E0309",
                    _ => "E0301",
                };
                let diagnostic = Diagnostic::new(code, format!("expected {wanted}, found {found}"))
                    .primary(self.file(), span, format!("this is {found}"))
                    .label(self.file(), ty.span, "asked for here");
                self.error(diagnostic)
            }
        }
    }
}

/// The components of a type of vectors.
fn vector_type(names: &[&str]) -> Option<usize> {
    match names {
        ["vec2"] => Some(2),
        ["vec3"] => Some(3),
        _ => None,
    }
}

fn fits<'a>(value: &Value, names: &[&str], kind: &dyn Fn(NodeId) -> NodeKind<'a>) -> bool {
    matches!(convert(value, names, kind), Converted::Fits | Converted::As(_))
}

/// E0306.
pub fn wrong_count(expected: usize, found: usize, file: FileId, span: Span) -> Diagnostic {
    let label = format!("{found} component{}", if found == 1 { "" } else { "s" });
    let diagnostic = Diagnostic::new("E0306", format!("expected {expected} components, found {found}"));
    let diagnostic = diagnostic.primary(file, span, label);
    match expected {
        2 => diagnostic.help("write two: `(x, y)`"),
        _ => diagnostic.help("write all three: `(x, y, z)`"),
    }
}

/// The dimension of a type of numbers.
fn number_type(name: &str) -> Option<Dimension> {
    schema::type_name(name)?.dimension
}

/// What comes of asking a value to be of a type.
#[allow(missing_docs)]
pub enum Converted {
    Fits,
    As(Value),
    Whole,
    Unit(Dimension),
    Wrong(String),
}

/// Asks a value to be of the type that these names say, from the outside in; none say nothing.
pub fn convert<'a>(value: &Value, names: &[&str], kind: &dyn Fn(NodeId) -> NodeKind<'a>) -> Converted {
    let Some((name, rest)) = names.split_first() else { return Converted::Fits };
    let fits = |fits: bool, wanted: &str| if fits { Converted::Fits } else { Converted::Wrong(wanted.into()) };
    if let Some(dimension) = number_type(name) {
        return match value {
            Value::Number(number) if number.dimension == dimension => {
                Converted::As(Value::Number(Number { int: false, ..*number }))
            }
            Value::Number(number) if number.is_bare_zero() => Converted::As(Value::quantity(0.0, dimension)),
            Value::Number(number) if number.dimension.is_none() && dimension == Dimension::LENGTH => {
                Converted::As(Value::quantity(number.value, dimension))
            }
            Value::Number(number) if number.dimension.is_none() => Converted::Unit(dimension),
            _ => Converted::Wrong(dimension.with_article()),
        };
    }
    let vector =
        |count: usize| matches!(value, Value::Tuple(items) if items.len() == count) && value.numbers().is_some();
    match *name {
        "int" => match value {
            Value::Number(number) if number.dimension.is_none() => match number.value.constant() {
                Some(v) if v.fract() == 0.0 && v.is_finite() => Converted::As(Value::Number(Number::int(v))),
                Some(_) => Converted::Whole,
                None => fits(number.int, "a whole number"),
            },
            _ => Converted::Wrong("a whole number".into()),
        },
        "bool" => fits(matches!(value, Value::Bool(_)), "true or false"),
        "string" => fits(matches!(value, Value::Text(_)), "text"),
        "color" => fits(matches!(value, Value::Color(_)), "a colour"),
        "vec2" => fits(vector(2), "a vector of 2 components"),
        "vec3" => fits(vector(3), "a vector of 3 components"),
        "quat" => fits(matches!(value, Value::Turn(_)), "a rotation"),
        "range" => fits(matches!(value, Value::Range(..)), "a range"),
        "texture" => fits(matches!(value, Value::Texture(_)), "a texture"),
        "node" => fits(matches!(value, Value::Node(_)), "a node"),
        "material" | "camera" => {
            let wanted = if *name == "material" { schema::Sort::Material } else { schema::Sort::Camera };
            match value {
                Value::Node(id) => match kind(*id) {
                    NodeKind::Schema(kind) => fits(kind.sort == wanted, wanted.with_article()),
                    NodeKind::Prefab(_) => Converted::Wrong(wanted.with_article().into()),
                    NodeKind::Unknown => Converted::Fits,
                },
                _ => Converted::Wrong(wanted.with_article().into()),
            }
        }
        "list" => match value {
            Value::List(_) if rest.is_empty() => Converted::Fits,
            Value::List(items) => {
                let mut list = Vec::with_capacity(items.len());
                for item in items.iter() {
                    list.push(match convert(item, rest, kind) {
                        Converted::Fits => item.clone(),
                        Converted::As(item) => item,
                        other => return other,
                    });
                }
                Converted::As(Value::List(list.into()))
            }
            _ => Converted::Wrong("a list".into()),
        },
        // An unknown type is reported where it stands.
        _ => Converted::Fits,
    }
}

/// How many different instances of a loop's body are looked at.
const SIBLINGS: usize = 16;

fn place_property(name: &str) -> bool {
    matches!(name, "position" | "rotation" | "scale")
}

/// Where an instance stands, if it stands still, is seen, and is placed by itself.
pub fn placement(node: &NodeValue<'_>) -> Option<Placement> {
    if !matches!(node.kind, NodeKind::Schema(kind) if kind.name == "instance") || !node.children.is_empty() {
        return None;
    }
    let mut place = Placement::IDENTITY;
    for set in &node.properties {
        let name = set.property.name;
        match name {
            "of" | "material" => {
                set.data.as_ref()?;
            }
            _ if place_property(name) => {
                let Some(Data::Parts(parts)) = &set.data else { return None };
                let part = |i: usize| parts.get(i).and_then(|part| part.constant());
                let vector = || Some(DVec3::new(part(0)?, part(1)?, part(2)?));
                match name {
                    "position" => place.position = vector()?,
                    "scale" => place.scale = vector()?,
                    _ => place.rotation = DQuat::from_xyzw(part(0)?, part(1)?, part(2)?, part(3)?),
                }
            }
            _ => return None,
        }
    }
    (place.scale.cmpne(DVec3::ZERO).all()).then_some(place)
}

/// E0206.
pub fn set_twice(name: &str, file: crate::source::FileId, second: Span, first: Span) -> Diagnostic {
    Diagnostic::new("E0206", format!("`{name}` is set twice"))
        .primary(file, second, "set again")
        .label(file, first, "set here")
        .help("the last does *not* win: remove one")
}

/// The kind as written.
pub fn kind_text(ast: &ast::Node) -> String {
    let names: Vec<&str> = ast.kind.segments.iter().map(|name| &*name.text).collect();
    names.join(".")
}

/// The default of a property as a value, where it can be told.
fn default_value(property: &'static schema::Property) -> Option<Value> {
    use schema::Default;
    Some(match (property.default, property.ty) {
        (Default::Number(value), Type::Number(dimension, _)) => Value::quantity(value, dimension),
        (Default::Number(value), Type::Count) => Value::Number(Number::int(value)),
        (Default::Number(value), Type::Color) => Value::Color([value.into(); 3]),
        (Default::Number(value), Type::Scale) => Value::vector(&[value.into(); 3], Dimension::NONE),
        (Default::Number(value), Type::Vec3(dimension, _)) => Value::vector(&[value.into(); 3], dimension),
        (Default::Number(value), Type::Vec2(dimension, _)) => Value::vector(&[value.into(); 2], dimension),
        (Default::Three(parts), Type::Vec3(dimension, _)) => Value::vector(&parts.map(Scalar::Const), dimension),
        (Default::Two([a, b]), Type::Counts) => {
            Value::Tuple(vec![Value::Number(Number::int(a)), Value::Number(Number::int(b))].into())
        }
        (Default::Bool(value), _) => Value::Bool(f64::from(u8::from(value)).into()),
        (Default::Identity, _) => Value::Turn([0.0, 0.0, 0.0, 1.0].map(Scalar::Const)),
        _ => return None,
    })
}

/// Whether an expression is nothing but a literal, so that a message need not say what it comes to.
pub fn is_literal(expr: &Expr) -> bool {
    matches!(expr.kind, ExprKind::Number(_) | ExprKind::Color(_) | ExprKind::Str(_) | ExprKind::Bool(_))
}

/// Data with its defaults: the components that a property has at all times.
pub fn default_parts(property: &schema::Property) -> Option<Vec<f64>> {
    use schema::Default;
    Some(match (property.default, property.ty) {
        (Default::Number(value), Type::Number(..) | Type::Count) => vec![value],
        (Default::Number(value), Type::Vec2(..)) => vec![value; 2],
        (Default::Number(value), _) => vec![value; 3],
        (Default::Three(parts), _) => parts.to_vec(),
        (Default::Two(parts), _) => parts.to_vec(),
        (Default::Bool(value), _) => vec![f64::from(u8::from(value))],
        (Default::Identity, _) => vec![0.0, 0.0, 0.0, 1.0],
        _ => return None,
    })
}

/// A number as the data of a property, for what is given on the command line.
pub fn number_data(value: f64) -> Data {
    Data::Parts(vec![value.into()])
}

/// As a message shows a time.
pub fn seconds(value: f64) -> String {
    format!("{}s", short(value))
}
