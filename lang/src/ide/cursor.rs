//! What stands around a place in a text: in which block, and which value is written there.

use crate::schema::{self, Kind, Property};
use crate::syntax::{Part, SyntaxKind as K};

/// What a block belongs to.
#[derive(Clone, Copy)]
pub enum Owner<'t> {
    /// The file itself.
    Top,
    /// A node or a material written as a value.
    Node(Part<'t>),
    /// A prefab, or a loop at the top.
    Scene,
    /// A function.
    Function,
    /// Keyframes.
    Keys,
    /// What a key of `interpolate: hermite` holds.
    KeyValue,
    /// The names of an import.
    Import(Part<'t>),
    /// Something that could not be read.
    Nowhere,
}

/// What is in the innermost braces around a part of the tree.
pub fn owner(part: Part<'_>) -> Owner<'_> {
    let mut scene = false;
    let mut up = part.parent();
    while let Some(at) = up {
        let parent = at.parent();
        match at.kind() {
            K::File | K::OneValue => return if scene { Owner::Scene } else { Owner::Top },
            K::KeyBlock => return Owner::Keys,
            K::Names => return Owner::Import(at),
            K::Arm => return Owner::Nowhere,
            K::Block => match parent.map(Part::kind) {
                Some(K::Node | K::Named | K::Like) => {
                    let node = parent.filter(|parent| parent.kind() != K::Like).or_else(|| parent?.parent());
                    return node.map_or(Owner::Nowhere, Owner::Node);
                }
                Some(K::FnDecl) => return Owner::Function,
                Some(K::PrefabDecl) => return Owner::Scene,
                Some(K::Key) => return Owner::KeyValue,
                Some(K::ForStmt | K::IfStmt) => scene = true,
                _ => return Owner::Nowhere,
            },
            _ => {}
        }
        up = parent;
    }
    Owner::Top
}

/// The kind of a node as it is written: `sphere`, `metals.gold`.
pub fn kind_of<'t>(node: Part<'t>) -> Option<Part<'t>> {
    node.parts().find(|part| part.kind() == K::Path)
}

/// Whether a path is the kind of a node, written as an item or as a value.
pub fn is_kind(path: Part<'_>) -> bool {
    let body = |part: Part<'_>| matches!(part.kind(), K::Block | K::Like);
    path.parent().is_some_and(|parent| match parent.kind() {
        K::Node => true,
        K::Named => parent.nodes().any(body),
        _ => false,
    })
}

/// The schema's kind of a node.
pub fn schema_kind(node: Part<'_>) -> Option<&'static Kind> {
    schema::kind(kind_of(node)?.text())
}

/// The names of the properties that are set in a node, but for one.
pub fn set_in<'t>(node: Part<'t>, but: Part<'t>) -> impl Iterator<Item = &'t str> {
    let holder = node.nodes().find(|part| part.kind() == K::Like).unwrap_or(node);
    let body = holder.nodes().find(|part| part.kind() == K::Block);
    body.into_iter()
        .flat_map(Part::nodes)
        .filter(move |part| matches!(part.kind(), K::Property | K::EqProperty) && !part.holds(but))
        .filter_map(|property| property.first_token().map(Part::text))
}

/// What a value is for.
#[derive(Clone, Copy)]
pub enum Slot<'t> {
    /// A property of a node: the node, its name, the row of the schema, and whether the value is a component of it.
    Property { node: Part<'t>, name: &'t str, row: Option<&'static Property>, inside: bool },
    /// An argument of a call or of `keys`: the part with the brackets, which one it is, and its name, if it is given.
    Argument { args: Part<'t>, index: usize, name: Option<&'t str> },
    /// What is behind `ease`.
    Ease,
    /// What is behind `like`: the kind of the node.
    Like(Option<Part<'t>>),
    /// A type.
    Type,
    /// When a key is reached.
    KeyTime,
    /// Anything else.
    Any,
}

/// What the value is for that a part of the tree stands in.
pub fn slot(part: Part<'_>) -> Slot<'_> {
    let mut inside = false;
    let mut below = part;
    for at in part.ancestors().skip(1) {
        match at.kind() {
            K::Property | K::EqProperty => {
                let Some(name) = at.first_token() else { return Slot::Any };
                if name.holds(part) {
                    return Slot::Any;
                }
                let name = name.text();
                return match owner(at) {
                    Owner::Node(node) => {
                        let row = schema_kind(node).and_then(|kind| kind.property(name));
                        Slot::Property { node, name, row, inside }
                    }
                    _ => Slot::Any,
                };
            }
            K::NamedArg => {
                let name = at.first_token().filter(|name| !name.holds(part)).map(Part::text);
                let Some(args) = at.parent() else { return Slot::Any };
                return Slot::Argument { args, index: index_in(args, at), name };
            }
            K::Args => return Slot::Argument { args: at, index: index_in(at, below), name: None },
            K::Tuple | K::List => inside = true,
            K::Comp | K::Index | K::LetDecl | K::ParamDecl | K::Formal | K::FnDecl | K::ForStmt | K::IfStmt => {
                return Slot::Any;
            }
            K::Key => {
                let before = |kind: K| {
                    at.parts().take_while(|part| part.span().start < below.span().start).any(|part| part.kind() == kind)
                };
                if before(K::KwEase) {
                    return Slot::Ease;
                }
                if !before(K::Colon) {
                    return Slot::KeyTime;
                }
            }
            K::Like => return Slot::Like(at.parent().and_then(kind_of)),
            K::Ty => return Slot::Type,
            K::Block | K::File | K::KeyBlock if below.kind() != K::Key => return Slot::Any,
            _ => {}
        }
        below = at;
    }
    Slot::Any
}

/// How many arguments stand before a part.
fn index_in(args: Part<'_>, part: Part<'_>) -> usize {
    let start = part.span().start;
    args.parts().filter(|other| other.kind() == K::Comma && other.span().start < start).count()
}

/// What is called with these arguments: its name with the path, `keys` of keyframes.
pub fn called(args: Part<'_>) -> Option<&str> {
    let callee = args.previous().or_else(|| args.previous_token())?;
    match callee.kind() {
        K::KwKeys | K::Path => Some(callee.text()),
        kind if kind.is_trivia() => {
            let before = callee.previous_token()?;
            matches!(before.kind(), K::KwKeys).then(|| before.text())
        }
        _ => None,
    }
}
