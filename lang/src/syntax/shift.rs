//! A file's items moved to where its text lies among others: see [`Texts`](crate::source::Texts).

use super::ast::*;
use crate::source::Span;

/// Adds `by` to every place in the file.
pub(super) fn file(file: &mut File, by: u32) {
    let shift = Shift(by);
    let File { items, span } = file;
    shift.items(items);
    shift.span(span);
}

struct Shift(u32);

impl Shift {
    fn span(&self, span: &mut Span) {
        *span = Span::new(span.start + self.0, span.end + self.0);
    }

    fn name(&self, Name { text: _, span, quoted: _ }: &mut Name) {
        self.span(span);
    }

    fn names<'n>(&self, names: impl IntoIterator<Item = &'n mut Name>) {
        names.into_iter().for_each(|name| self.name(name));
    }

    fn path(&self, Path { segments, span }: &mut Path) {
        self.names(segments);
        self.span(span);
    }

    fn ty(&self, ty: &mut Option<Type>) {
        if let Some(Type { names, span }) = ty {
            self.names(names);
            self.span(span);
        }
    }

    fn items(&self, items: &mut [Item]) {
        items.iter_mut().for_each(|item| self.item(item));
    }

    fn block(&self, Block { items, span }: &mut Block) {
        self.items(items);
        self.span(span);
    }

    fn maybe(&self, block: &mut Option<Block>) {
        block.iter_mut().for_each(|block| self.block(block));
    }

    fn formals(&self, formals: &mut [Formal]) {
        for Formal { name, ty, default, span } in formals {
            self.name(name);
            self.ty(ty);
            self.exprs(default);
            self.span(span);
        }
    }

    fn head(&self, ForHead { names, over, span }: &mut ForHead) {
        self.names(names);
        self.expr(over);
        self.span(span);
    }

    fn property(&self, Property { docs: _, name, value, span }: &mut Property) {
        self.name(name);
        self.expr(value);
        self.span(span);
    }

    fn node(&self, Node { docs: _, kind, name, like, body, span }: &mut Node) {
        self.path(kind);
        self.names(name);
        self.exprs(like);
        self.maybe(body);
        self.span(span);
    }

    fn item(&self, item: &mut Item) {
        match item {
            Item::Property(property) => self.property(property),
            Item::Node(node) => self.node(node),
            Item::Let(LetDecl { docs: _, name, ty, value, span }) => {
                self.names(name);
                self.ty(ty);
                self.expr(value);
                self.span(span);
            }
            Item::Param(ParamDecl { docs: _, name, ty, value, range, span }) => {
                self.names(name);
                self.ty(ty);
                self.expr(value);
                self.exprs(range);
                self.span(span);
            }
            Item::Fn(FnDecl { docs: _, name, params, result, body, head, span }) => {
                self.names(name);
                self.formals(params);
                self.ty(result);
                match body {
                    FnBody::Block(block) => self.block(block),
                    FnBody::Value(value) => self.expr(value),
                    FnBody::Missing => {}
                }
                self.span(head);
                self.span(span);
            }
            Item::Prefab(PrefabDecl { docs: _, name, params, body, head, span }) => {
                self.names(name);
                self.formals(params);
                self.maybe(body);
                self.span(head);
                self.span(span);
            }
            Item::For(ForStmt { head, body, span }) => {
                self.head(head);
                self.maybe(body);
                self.span(span);
            }
            Item::If(IfStmt { arms, otherwise, span }) => {
                for (condition, block) in arms {
                    self.expr(condition);
                    self.maybe(block);
                }
                self.maybe(otherwise);
                self.span(span);
            }
            Item::Return(ReturnStmt { value, span }) => {
                self.expr(value);
                self.span(span);
            }
            Item::Import(ImportDecl { path, names, alias, span }) => {
                self.names(path);
                for Rename { name, alias } in names.iter_mut().flatten() {
                    self.name(name);
                    self.names(alias);
                }
                self.names(alias);
                self.span(span);
            }
            Item::Lang(LangDecl { version, span }) => {
                self.expr(version);
                self.span(span);
            }
            Item::Block(block) => self.block(block),
        }
    }

    fn exprs<'e>(&self, exprs: impl IntoIterator<Item = &'e mut Expr>) {
        exprs.into_iter().for_each(|expr| self.expr(expr));
    }

    fn args(&self, args: &mut [Arg]) {
        for Arg { name, value, span } in args {
            self.names(name);
            self.expr(value);
            self.span(span);
        }
    }

    fn expr(&self, Expr { kind, span }: &mut Expr) {
        self.span(span);
        match kind {
            ExprKind::Missing | ExprKind::Color(_) | ExprKind::Str(_) | ExprKind::Bool(_) => {}
            ExprKind::Number(Number { value: _, int: _, whole: _, unit }) => {
                self.names(unit.iter_mut().map(|unit| &mut unit.name));
            }
            ExprKind::Path(path) => self.path(path),
            ExprKind::Tuple(items) | ExprKind::List(items) => self.exprs(items),
            ExprKind::Comp(comp) => {
                let Comp { head, condition, value } = &mut **comp;
                self.head(head);
                self.exprs(condition);
                self.expr(value);
            }
            ExprKind::Unary { op: _, op_span, value } => {
                self.span(op_span);
                self.expr(value);
            }
            ExprKind::Binary { first, rest } => {
                self.expr(first);
                for Step { op: _, op_span, value } in rest {
                    self.span(op_span);
                    self.expr(value);
                }
            }
            ExprKind::Call { callee, args } => {
                self.expr(callee);
                self.args(args);
            }
            ExprKind::Field { base, name } => {
                self.expr(base);
                self.name(name);
            }
            ExprKind::Index { base, index } => {
                self.expr(base);
                self.expr(index);
            }
            ExprKind::Node(node) => self.node(node),
            ExprKind::Keys(keys) => {
                let Keys { args, keys, block } = &mut **keys;
                self.args(args);
                for Key { after: _, time, value, ease, span } in keys {
                    self.expr(time);
                    match value {
                        KeyValue::Value(value) => self.expr(value),
                        KeyValue::Block(block) => self.block(block),
                    }
                    self.exprs(ease);
                    self.span(span);
                }
                block.iter_mut().for_each(|span| self.span(span));
            }
            ExprKind::If(value) => {
                let IfValue { arms, otherwise } = &mut **value;
                for (condition, arm) in arms {
                    self.expr(condition);
                    self.expr(arm);
                }
                self.expr(otherwise);
            }
        }
    }
}
