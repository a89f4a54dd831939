//! What a file holds, as a tree of names.

use crate::eval::items::kind_text;
use crate::schema::{self, Sort};
use crate::source::Span;
use crate::syntax::ast::{Expr, ExprKind, Item, Node};

/// A named part of a file, or a node without a name.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Its name; of a node without one its kind.
    pub name: String,
    /// What it is: `sphere`, `param`, `fn (a, b)`.
    pub detail: String,
    /// What it is, for an icon.
    pub what: What,
    /// All of it.
    pub span: Span,
    /// Its name.
    pub name_span: Span,
    /// Whether other files can import it.
    pub is_declaration: bool,
    /// What is in it.
    pub children: Vec<Entry>,
}

/// What an entry is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum What {
    Value,
    Param,
    Function,
    Prefab,
    Node,
    Material,
    Group,
    Camera,
    Settings,
    Property,
    Module,
}

/// What items hold.
pub fn outline(items: &[Item]) -> Vec<Entry> {
    let mut found = Vec::new();
    items.iter().for_each(|item| entry(item, &mut found));
    found
}

fn entry(item: &Item, found: &mut Vec<Entry>) {
    let mut add = |name: &str, detail: String, what: What, span: Span, name_span: Span, children: Vec<Entry>| {
        let is_declaration = !matches!(what, What::Module | What::Settings | What::Property);
        found.push(Entry { name: name.into(), detail, what, span, name_span, is_declaration, children });
    };
    match item {
        Item::Let(decl) => {
            if let Some(name) = &decl.name {
                add(&name.text, "let".into(), What::Value, decl.span, name.span, Vec::new());
            }
        }
        Item::Param(decl) => {
            if let Some(name) = &decl.name {
                add(&name.text, "param".into(), What::Param, decl.span, name.span, Vec::new());
            }
        }
        Item::Fn(decl) => {
            if let Some(name) = &decl.name {
                let params: Vec<&str> = decl.params.iter().map(|formal| &*formal.name.text).collect();
                add(
                    &name.text,
                    format!("fn ({})", params.join(", ")),
                    What::Function,
                    decl.span,
                    name.span,
                    Vec::new(),
                );
            }
        }
        Item::Prefab(decl) => {
            if let Some(name) = &decl.name {
                let children = decl.body.iter().flat_map(|body| outline(&body.items)).collect();
                add(&name.text, "prefab".into(), What::Prefab, decl.span, name.span, children);
            }
        }
        Item::Node(node) => node_entry(node, found),
        Item::For(stmt) => found.extend(stmt.body.iter().flat_map(|body| outline(&body.items))),
        Item::If(stmt) => {
            let blocks = stmt.arms.iter().filter_map(|(_, block)| block.as_ref()).chain(&stmt.otherwise);
            found.extend(blocks.flat_map(|block| outline(&block.items)));
        }
        Item::Import(import) => {
            if let Some(alias) = &import.alias {
                let path = import.path.as_ref().map_or("", |path| &*path.text);
                add(&alias.text, format!("import \"{path}\""), What::Module, import.span, alias.span, Vec::new());
            }
        }
        Item::Block(block) => found.extend(outline(&block.items)),
        // A material written as a value holds properties of its own, but no names.
        Item::Property(_) | Item::Return(_) | Item::Lang(_) => {}
    }
}

fn node_entry(node: &Node, found: &mut Vec<Entry>) {
    let kind = kind_text(node);
    let what = match schema::kind(&kind).map(|kind| kind.sort) {
        Some(Sort::Material) => What::Material,
        Some(Sort::Group) => What::Group,
        Some(Sort::Camera) => What::Camera,
        Some(Sort::Render | Sort::Simulation) => What::Settings,
        _ => What::Node,
    };
    let (name, name_span) = match &node.name {
        Some(name) => (name.text.to_string(), name.span),
        None => (kind.clone(), node.kind.span),
    };
    let mut children = Vec::new();
    for item in node.body.iter().flat_map(|body| &body.items) {
        match item {
            Item::Property(property) => children.extend(keyed(&property.value).then(|| Entry {
                name: property.name.text.to_string(),
                detail: "keys".into(),
                what: What::Property,
                span: property.span,
                name_span: property.name.span,
                is_declaration: false,
                children: Vec::new(),
            })),
            item => entry(item, &mut children),
        }
    }
    let is_declaration = node.name.is_some();
    found.push(Entry { name, detail: kind, what, span: node.span, name_span, is_declaration, children });
}

/// Whether a value has keys: those are worth finding again.
fn keyed(value: &Expr) -> bool {
    matches!(value.kind, ExprKind::Keys(_))
}
