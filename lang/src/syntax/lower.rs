//! Tree to [`ast`](super::ast): items and statements. Values are in [`super::expr`].

use super::ast::*;
use super::expr::value;
use super::kind::SyntaxKind;
use super::part::Part;
use super::text::unescape;
use crate::source::Span;
use std::sync::Arc;

/// The items of a file's root node.
pub(super) fn file(root: Part<'_>) -> File {
    File { items: items(root), span: root.span() }
}

/// The parts of a node that mean something.
pub(super) fn parts(node: Part<'_>) -> impl Iterator<Item = Part<'_>> + Clone {
    node.parts().filter(|part| !part.kind().is_trivia())
}

pub(super) fn missing(span: Span) -> Expr {
    Expr { kind: ExprKind::Missing, span }
}

/// A missing value at a node's end.
pub(super) fn missing_in(node: Part<'_>) -> Expr {
    missing(Span::at(node.span().end))
}

/// The value behind the first token of this kind.
pub(super) fn value_after(node: Part<'_>, kind: SyntaxKind) -> Option<Expr> {
    let mut rest = parts(node).skip_while(|part| part.kind() != kind);
    rest.next()?;
    rest.next().filter(|part| part.kind().is_value()).map(value)
}

pub(super) fn child(node: Part<'_>, kind: SyntaxKind) -> Option<Part<'_>> {
    node.nodes().find(|child| child.kind() == kind)
}

pub(super) fn name(token: Part<'_>) -> Name {
    let quoted = token.kind() == SyntaxKind::String;
    let text: Arc<str> = if quoted { unescape(token.text()).text.into() } else { token.text().into() };
    Name { text, span: token.span(), quoted }
}

/// The first token of these kinds as a name.
fn find_name(node: Part<'_>, kinds: &[SyntaxKind]) -> Option<Name> {
    parts(node).find(|part| kinds.contains(&part.kind())).map(name)
}

/// The name behind the first token of this kind.
fn name_after(node: Part<'_>, kind: SyntaxKind) -> Option<Name> {
    let mut rest = parts(node).skip_while(|part| part.kind() != kind);
    rest.next()?;
    rest.next().filter(|part| part.kind() == SyntaxKind::Ident).map(name)
}

pub(super) fn path(token: Part<'_>) -> Path {
    let whole = token.span();
    let mut start = whole.start;
    let mut segments = Vec::with_capacity(1);
    segments.extend(token.text().split('.').map(|text| {
        let span = Span::new(start, start + text.len() as u32);
        start = span.end + 1;
        Name { text: text.into(), span, quoted: false }
    }));
    Path { segments, span: whole }
}

pub(super) fn block(node: Part<'_>) -> Block {
    Block { items: items(node), span: node.span() }
}

fn items(node: Part<'_>) -> Vec<Item> {
    let mut items = Vec::with_capacity(node.nodes().count());
    let mut docs: Vec<&str> = Vec::new();
    for part in node.parts() {
        match part.kind() {
            SyntaxKind::DocComment => docs.push(doc_line(part.text())),
            kind if kind.is_trivia() => {}
            kind => {
                if kind.is_node() {
                    let text = (!docs.is_empty()).then(|| docs.join("\n").into());
                    items.extend(item(part, text));
                }
                docs.clear();
            }
        }
    }
    items
}

fn doc_line(text: &str) -> &str {
    let text = text.strip_prefix("///").unwrap_or(text).trim_end();
    text.strip_prefix(' ').unwrap_or(text)
}

fn item(node: Part<'_>, docs: Docs) -> Option<Item> {
    use SyntaxKind as K;
    let span = node.span();
    let value_of = |kind| value_after(node, kind).unwrap_or_else(|| missing_in(node));
    let ty = || child(node, K::Ty).map(type_of);
    // A keyword is no name, which is reported; it is what the rest of the file calls it by, though.
    let name_of = || find_name(node, &[K::Ident, K::BadName]);
    let body = || child(node, K::Block).map(block);
    Some(match node.kind() {
        K::Property | K::EqProperty => Item::Property(Property {
            docs,
            name: find_name(node, &[K::KeyName, K::String])?,
            value: value_of(if node.kind() == K::Property { K::Colon } else { K::Equals }),
            span,
        }),
        K::Node => Item::Node(scene_node(node, docs)?),
        K::LetDecl => Item::Let(LetDecl { docs, name: name_of(), ty: ty(), value: value_of(K::Equals), span }),
        K::ParamDecl => Item::Param(ParamDecl {
            docs,
            name: name_of(),
            ty: ty(),
            value: value_of(K::Equals),
            range: value_after(node, K::KwIn),
            span,
        }),
        K::FnDecl => {
            let result = child(node, K::Ty).map(type_of);
            let (body, at) = match (child(node, K::Block), value_after(node, K::Equals)) {
                (Some(body), _) => (FnBody::Block(block(body)), body.span().start),
                (None, Some(value)) => {
                    let at = value.span.start;
                    (FnBody::Value(value), at)
                }
                (None, None) => (FnBody::Missing, span.end),
            };
            let head = head(node, at);
            Item::Fn(FnDecl { docs, name: name_of(), params: formals(node), result, body, head, span })
        }
        K::PrefabDecl => {
            let head = head(node, child(node, K::Block).map_or(span.end, |body| body.span().start));
            Item::Prefab(PrefabDecl { docs, name: name_of(), params: formals(node), body: body(), head, span })
        }
        K::ForStmt => Item::For(ForStmt { head: for_head(node), body: body(), span }),
        K::IfStmt => {
            let Branches { arms, otherwise } = branches(node);
            let arms = arms.into_iter().map(|(condition, arm)| (condition, arm.map(block))).collect();
            Item::If(IfStmt { arms, otherwise: otherwise.map(block), span })
        }
        K::ReturnStmt => Item::Return(ReturnStmt { value: value_of(K::KwReturn), span }),
        K::ImportDecl => Item::Import(ImportDecl {
            path: find_name(node, &[K::String]),
            names: child(node, K::Names).map(renames),
            alias: name_after(node, K::KwAs),
            span,
        }),
        K::LangDecl => Item::Lang(LangDecl { version: value_of(K::KwLang), span }),
        K::Block => Item::Block(block(node)),
        _ => return None,
    })
}

/// A node as an item or, from [`SyntaxKind::Named`], as a value; nothing if it has no kind.
pub(super) fn scene_node(node: Part<'_>, docs: Docs) -> Option<Node> {
    use SyntaxKind as K;
    let kind = parts(node).find(|part| part.kind() == K::Path)?;
    let like = child(node, K::Like);
    let body = child(like.unwrap_or(node), K::Block);
    Some(Node {
        docs,
        kind: path(kind),
        name: find_name(node, &[K::Ident, K::String]),
        like: like.map(|like| value_after(like, K::KwLike).unwrap_or_else(|| missing_in(like))),
        body: body.map(block),
        span: node.span(),
    })
}

/// From the node's start to the last thing before the offset `until`.
fn head(node: Part<'_>, until: u32) -> Span {
    let whole = node.span();
    let before = parts(node).map(Part::span).take_while(|part| part.end <= until && part.start < until);
    before.fold(Span::at(whole.start), Span::to)
}

fn type_of(node: Part<'_>) -> Type {
    let names = parts(node).filter(|part| part.kind() == SyntaxKind::Ident);
    Type { names: names.map(name).collect(), span: node.span() }
}

fn formals(node: Part<'_>) -> Vec<Formal> {
    let Some(params) = child(node, SyntaxKind::Params) else { return Vec::new() };
    let formals = params.nodes().filter(|formal| formal.kind() == SyntaxKind::Formal);
    let formals = formals.filter_map(|formal| {
        Some(Formal {
            name: find_name(formal, &[SyntaxKind::Ident, SyntaxKind::BadName])?,
            ty: child(formal, SyntaxKind::Ty).map(type_of),
            default: value_after(formal, SyntaxKind::Equals),
            span: formal.span(),
        })
    });
    formals.collect()
}

fn renames(names: Part<'_>) -> Vec<Rename> {
    let renames = names.nodes().filter(|rename| rename.kind() == SyntaxKind::Rename);
    let renames = renames.filter_map(|rename| {
        Some(Rename { name: find_name(rename, &[SyntaxKind::Ident])?, alias: name_after(rename, SyntaxKind::KwAs) })
    });
    renames.collect()
}

/// The head of a `for` statement or a comprehension.
pub(super) fn for_head(node: Part<'_>) -> ForHead {
    let over = value_after(node, SyntaxKind::KwIn).unwrap_or_else(|| missing_in(node));
    let names = parts(node).take_while(|part| part.kind() != SyntaxKind::KwIn);
    let names = names.filter(|part| part.kind() == SyntaxKind::Ident);
    ForHead { names: names.map(name).collect(), span: Span::new(node.span().start, over.span.end), over }
}

/// The arms of an `if` as nodes; an arm is absent where it is missing.
pub(super) struct Branches<'t> {
    pub arms: Vec<(Expr, Option<Part<'t>>)>,
    pub otherwise: Option<Part<'t>>,
}

pub(super) fn branches(node: Part<'_>) -> Branches<'_> {
    let is_arm = |part: &Part<'_>| matches!(part.kind(), SyntaxKind::Block | SyntaxKind::Arm);
    let mut branches = Branches { arms: Vec::new(), otherwise: None };
    let mut rest = parts(node);
    while let Some(part) = rest.next() {
        match part.kind() {
            SyntaxKind::KwIf => {
                let condition = rest.next().map_or_else(|| missing_in(node), value);
                branches.arms.push((condition, rest.next().filter(is_arm)));
            }
            SyntaxKind::Block | SyntaxKind::Arm => branches.otherwise = Some(part),
            _ => {}
        }
    }
    branches
}
