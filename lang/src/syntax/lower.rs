//! Tree to [`ast`](super::ast): items and statements. Values are in [`super::expr`].

use super::ast::*;
use super::expr::value;
use super::kind::{SyntaxElement, SyntaxKind, SyntaxNode, SyntaxToken};
use super::text::unescape;
use crate::source::Span;
use rowan::NodeOrToken;
use std::sync::Arc;

/// The items of a file's root node.
pub(super) fn file(root: &SyntaxNode) -> File {
    File { items: items(root), span: node_span(root) }
}

/// The elements of a node that mean something.
pub(super) fn parts(node: &SyntaxNode) -> impl Iterator<Item = SyntaxElement> {
    node.children_with_tokens().filter(|part| !part.kind().is_trivia())
}

pub(super) fn span(element: &SyntaxElement) -> Span {
    let range = element.text_range();
    Span::new(range.start().into(), range.end().into())
}

pub(super) fn node_span(node: &SyntaxNode) -> Span {
    let range = node.text_range();
    Span::new(range.start().into(), range.end().into())
}

pub(super) fn token_span(token: &SyntaxToken) -> Span {
    let range = token.text_range();
    Span::new(range.start().into(), range.end().into())
}

pub(super) fn missing(span: Span) -> Expr {
    Expr { kind: ExprKind::Missing, span }
}

/// A missing value at a node's end.
pub(super) fn missing_in(node: &SyntaxNode) -> Expr {
    missing(Span::at(node_span(node).end))
}

/// The value behind the first token of this kind.
pub(super) fn value_after(node: &SyntaxNode, kind: SyntaxKind) -> Option<Expr> {
    let mut rest = parts(node).skip_while(|part| part.kind() != kind);
    rest.next()?;
    rest.next().filter(|part| part.kind().is_value()).map(|part| value(&part))
}

pub(super) fn child(node: &SyntaxNode, kind: SyntaxKind) -> Option<SyntaxNode> {
    node.children().find(|child| child.kind() == kind)
}

pub(super) fn name(token: &SyntaxToken) -> Name {
    let quoted = token.kind() == SyntaxKind::String;
    let text: Arc<str> = if quoted { unescape(token.text()).text.into() } else { token.text().into() };
    Name { text, span: token_span(token), quoted }
}

/// The first token of these kinds as a name.
fn find_name(node: &SyntaxNode, kinds: &[SyntaxKind]) -> Option<Name> {
    parts(node).find_map(|part| match part {
        NodeOrToken::Token(token) if kinds.contains(&token.kind()) => Some(name(&token)),
        _ => None,
    })
}

/// The name behind the first token of this kind.
fn name_after(node: &SyntaxNode, kind: SyntaxKind) -> Option<Name> {
    let mut rest = parts(node).skip_while(|part| part.kind() != kind);
    rest.next()?;
    match rest.next()? {
        NodeOrToken::Token(token) if token.kind() == SyntaxKind::Ident => Some(name(&token)),
        _ => None,
    }
}

pub(super) fn path(token: &SyntaxToken) -> Path {
    let whole = token_span(token);
    let mut start = whole.start;
    let segments = token.text().split('.').map(|text| {
        let span = Span::new(start, start + text.len() as u32);
        start = span.end + 1;
        Name { text: text.into(), span, quoted: false }
    });
    Path { segments: segments.collect(), span: whole }
}

pub(super) fn block(node: &SyntaxNode) -> Block {
    Block { items: items(node), span: node_span(node) }
}

fn items(node: &SyntaxNode) -> Vec<Item> {
    let mut items = Vec::new();
    let mut docs: Vec<String> = Vec::new();
    for part in node.children_with_tokens() {
        match part {
            NodeOrToken::Token(token) if token.kind() == SyntaxKind::DocComment => {
                docs.push(doc_line(token.text()).to_string());
            }
            NodeOrToken::Token(token) if token.kind().is_trivia() => {}
            NodeOrToken::Token(_) => docs.clear(),
            NodeOrToken::Node(node) => {
                let text = (!docs.is_empty()).then(|| docs.join("\n").into());
                items.extend(item(&node, text));
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

fn item(node: &SyntaxNode, docs: Docs) -> Option<Item> {
    use SyntaxKind as K;
    let span = node_span(node);
    let value_of = |kind| value_after(node, kind).unwrap_or_else(|| missing_in(node));
    let ty = || child(node, K::Ty).map(|ty| type_of(&ty));
    let name_of = || find_name(node, &[K::Ident]);
    let body = || child(node, K::Block).map(|body| block(&body));
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
            let result = child(node, K::Ty).map(|ty| type_of(&ty));
            let (body, at) = match (child(node, K::Block), value_after(node, K::Equals)) {
                (Some(body), _) => (FnBody::Block(block(&body)), node_span(&body).start),
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
            let head = head(node, child(node, K::Block).map_or(span.end, |body| node_span(&body).start));
            Item::Prefab(PrefabDecl { docs, name: name_of(), params: formals(node), body: body(), head, span })
        }
        K::ForStmt => Item::For(ForStmt { head: for_head(node), body: body(), span }),
        K::IfStmt => {
            let Branches { arms, otherwise } = branches(node);
            let arms = arms.into_iter().map(|(condition, arm)| (condition, arm.map(|arm| block(&arm)))).collect();
            Item::If(IfStmt { arms, otherwise: otherwise.map(|arm| block(&arm)), span })
        }
        K::ReturnStmt => Item::Return(ReturnStmt { value: value_of(K::KwReturn), span }),
        K::ImportDecl => Item::Import(ImportDecl {
            path: find_name(node, &[K::String]),
            names: child(node, K::Names).map(|names| renames(&names)),
            alias: name_after(node, K::KwAs),
            span,
        }),
        K::LangDecl => Item::Lang(LangDecl { version: value_of(K::KwLang), span }),
        K::Block => Item::Block(block(node)),
        _ => return None,
    })
}

/// A node as an item or, from [`SyntaxKind::Named`], as a value; nothing if it has no kind.
pub(super) fn scene_node(node: &SyntaxNode, docs: Docs) -> Option<Node> {
    use SyntaxKind as K;
    let kind = parts(node).find_map(|part| part.into_token().filter(|token| token.kind() == K::Path))?;
    let like = child(node, K::Like);
    let body = child(like.as_ref().unwrap_or(node), K::Block);
    Some(Node {
        docs,
        kind: path(&kind),
        name: find_name(node, &[K::Ident, K::String]),
        like: like.map(|like| value_after(&like, K::KwLike).unwrap_or_else(|| missing_in(&like))),
        body: body.map(|body| block(&body)),
        span: node_span(node),
    })
}

/// From the node's start to the last thing before the offset `until`.
fn head(node: &SyntaxNode, until: u32) -> Span {
    let whole = node_span(node);
    let before = parts(node).map(|part| span(&part)).take_while(|part| part.end <= until && part.start < until);
    before.fold(Span::at(whole.start), Span::to)
}

fn type_of(node: &SyntaxNode) -> Type {
    let names = parts(node).filter_map(|part| part.into_token()).filter(|token| token.kind() == SyntaxKind::Ident);
    Type { names: names.map(|token| name(&token)).collect(), span: node_span(node) }
}

fn formals(node: &SyntaxNode) -> Vec<Formal> {
    let Some(params) = child(node, SyntaxKind::Params) else { return Vec::new() };
    let formals = params.children().filter(|formal| formal.kind() == SyntaxKind::Formal);
    let formals = formals.filter_map(|formal| {
        Some(Formal {
            name: find_name(&formal, &[SyntaxKind::Ident])?,
            ty: child(&formal, SyntaxKind::Ty).map(|ty| type_of(&ty)),
            default: value_after(&formal, SyntaxKind::Equals),
            span: node_span(&formal),
        })
    });
    formals.collect()
}

fn renames(names: &SyntaxNode) -> Vec<Rename> {
    let renames = names.children().filter(|rename| rename.kind() == SyntaxKind::Rename);
    let renames = renames.filter_map(|rename| {
        Some(Rename { name: find_name(&rename, &[SyntaxKind::Ident])?, alias: name_after(&rename, SyntaxKind::KwAs) })
    });
    renames.collect()
}

/// The head of a `for` statement or a comprehension.
pub(super) fn for_head(node: &SyntaxNode) -> ForHead {
    let over = value_after(node, SyntaxKind::KwIn).unwrap_or_else(|| missing_in(node));
    let names = parts(node).take_while(|part| part.kind() != SyntaxKind::KwIn);
    let names = names.filter_map(|part| part.into_token()).filter(|token| token.kind() == SyntaxKind::Ident);
    ForHead {
        names: names.map(|token| name(&token)).collect(),
        span: Span::new(node_span(node).start, over.span.end),
        over,
    }
}

/// The arms of an `if` as nodes; an arm is absent where it is missing.
pub(super) struct Branches {
    pub arms: Vec<(Expr, Option<SyntaxNode>)>,
    pub otherwise: Option<SyntaxNode>,
}

pub(super) fn branches(node: &SyntaxNode) -> Branches {
    let is_arm = |part: SyntaxElement| {
        part.into_node().filter(|node| matches!(node.kind(), SyntaxKind::Block | SyntaxKind::Arm))
    };
    let mut branches = Branches { arms: Vec::new(), otherwise: None };
    let mut rest = parts(node);
    while let Some(part) = rest.next() {
        match part.kind() {
            SyntaxKind::KwIf => {
                let condition = rest.next().map_or_else(|| missing_in(node), |part| value(&part));
                branches.arms.push((condition, rest.next().and_then(is_arm)));
            }
            SyntaxKind::Block | SyntaxKind::Arm => branches.otherwise = part.into_node(),
            _ => {}
        }
    }
    branches
}
