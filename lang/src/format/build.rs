//! A tree to a layout.

use std::collections::BTreeSet;

use super::doc::Doc;
use super::trivia::{Around, Trivia, is_between};
use crate::source::Span;
use crate::syntax::{Part, SyntaxKind, Tree, level_of};

/// How much round a mistake stays as it is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Round {
    /// The innermost item.
    Item,
    /// The item of the file.
    Top,
}

/// The layout of a whole file. What has mistakes stays as it is, with the lines it stands on.
pub(super) fn file(tree: &Tree, round: Round) -> Doc<'_> {
    let root = tree.root();
    let faulty = faulty(tree, round);
    let mut builder = Builder { text: &tree.source.text, trivia: Trivia::of(root), faulty, emitted: None };
    let mut parts = Vec::new();
    for (index, element) in builder.elements(root, true).into_iter().enumerate() {
        if index > 0 {
            parts.push(Doc::hard(builder.blank_before(element.first)));
        }
        parts.push(builder.element(element));
    }
    for comment in &builder.trivia.end().before {
        if !parts.is_empty() {
            parts.push(Doc::hard(comment.blank));
        }
        parts.push(Doc::text(comment.text.clone()));
    }
    Doc::concat(parts)
}

/// Starts of the items that no line of may be touched; nothing where there is no mistake.
fn faulty(tree: &Tree, round: Round) -> Option<BTreeSet<u32>> {
    if tree.errors().is_empty() {
        return None;
    }
    let root = tree.root();
    let start = |node: Part<'_>| node.span().start;
    // Unread text in a list is a member of its own.
    let is_alone = |part: Part<'_>| {
        let list =
            part.parent().filter(|list| is_list(*list) && (round == Round::Item || list.kind() == SyntaxKind::File));
        !part.kind().is_node() && part.kind().is_error() && list.is_some()
    };
    let mut faulty = BTreeSet::new();
    for part in root.all().filter(|part| part.kind().is_error() && !is_alone(*part)) {
        let mut items = part.ancestors().filter(|part| is_item(*part));
        faulty.extend(if round == Round::Item { items.next() } else { items.last() }.map(start));
    }
    // Of what has no error node, the item round each end.
    for (_, span) in tree.errors().iter().filter_map(|error| error.place()) {
        for offset in [span.start, span.end] {
            let is_round = |part: &Part<'_>| part.span().start <= offset && offset <= part.span().end;
            let (mut at, mut items) = (root, Vec::new());
            while let Some(child) = at.nodes().find(is_round) {
                items.extend(Some(child).filter(|child| is_item(*child)));
                at = child;
            }
            if !at.parts().any(|part| is_round(&part) && is_alone(part)) {
                faulty.extend(if round == Round::Item { items.pop() } else { items.into_iter().next() }.map(start));
            }
        }
    }
    Some(faulty)
}

fn is_list(node: Part<'_>) -> bool {
    matches!(node.kind(), SyntaxKind::File | SyntaxKind::Block)
}

fn is_item(node: Part<'_>) -> bool {
    node.kind().is_item() && node.parent().is_some_and(is_list)
}

struct Builder<'a> {
    text: &'a str,
    trivia: Trivia,
    faulty: Option<BTreeSet<u32>>,
    /// The token whose comments before it are written already.
    emitted: Option<u32>,
}

/// A member of a list.
struct Element<'t> {
    first: Option<Part<'t>>,
    last: Option<Part<'t>>,
    /// What it is; absent where it stays as it is.
    part: Option<Part<'t>>,
}

impl<'t> Element<'t> {
    fn new(part: Part<'t>) -> Element<'t> {
        Element { first: first_token(part), last: last_token(part), part: Some(part) }
    }

    fn span(&self) -> Span {
        let start = self.first.map_or(0, |token| token.span().start);
        Span::new(start, self.last.map_or(start, |token| token.span().end))
    }
}

fn first_token(part: Part<'_>) -> Option<Part<'_>> {
    part.tokens().find(|token| !is_between(token.kind()))
}

fn last_token(part: Part<'_>) -> Option<Part<'_>> {
    part.tokens().rfind(|token| !is_between(token.kind()))
}

/// Whether a separator is among what has no meaning from here on.
fn is_separated<'t>(from: Option<Part<'t>>, next: fn(Part<'t>) -> Option<Part<'t>>) -> bool {
    std::iter::successors(from, |token| next(*token))
        .take_while(|token| is_between(token.kind()))
        .any(|token| matches!(token.kind(), SyntaxKind::Comma | SyntaxKind::Semicolon))
}

fn parts(node: Part<'_>) -> impl Iterator<Item = Part<'_>> {
    node.parts().filter(|part| !is_between(part.kind()) && !part.span().is_empty())
}

fn start(token: Part<'_>) -> u32 {
    token.span().start
}

/// The brackets of a list: between the outer ones a space or none, a comma at the end or none.
#[derive(Clone, Copy)]
struct Style {
    pad: &'static str,
    last_comma: &'static str,
    /// Lines end between the members, where otherwise commas stand; empty ones are kept.
    items: bool,
}

const BRACES: Style = Style { pad: " ", last_comma: "", items: true };
const NAMES: Style = Style { pad: " ", last_comma: ",", items: false };
const PARENS: Style = Style { pad: "", last_comma: ",", items: false };

impl<'a> Builder<'a> {
    /// The members of a list. Faulty ones are put together with all that is on their lines.
    fn elements<'t>(&self, list: Part<'t>, is_file: bool) -> Vec<Element<'t>> {
        let mut inside: Vec<Part<'t>> = parts(list).collect();
        if !is_file {
            // Without the brackets.
            inside.pop();
            inside = inside.split_off(1.min(inside.len()));
        }
        let mut elements: Vec<Element<'t>> = Vec::new();
        let mut was_faulty = false;
        for part in inside {
            let is_faulty = is_list(list)
                && self.faulty.as_ref().is_some_and(|faulty| {
                    let start = part.span().start;
                    !part.kind().is_node() || part.kind() == SyntaxKind::Block || faulty.contains(&start)
                });
            let mut element = Element::new(part);
            let joins = elements.last().is_some_and(|last| {
                (was_faulty || is_faulty)
                    && !self.slice(Span::new(last.span().end, element.span().start)).contains('\n')
            });
            if is_faulty {
                element.part = None;
            }
            match elements.last_mut().filter(|_| joins) {
                Some(last) => {
                    last.last = element.last;
                    last.part = None;
                    was_faulty = true;
                }
                None => {
                    elements.push(element);
                    was_faulty = is_faulty;
                }
            }
        }
        elements
    }

    fn slice(&self, span: Span) -> &'a str {
        self.text.get(span.start as usize..span.end as usize).unwrap_or_default()
    }

    /// Whether an empty line stands before a member and its comments.
    fn blank_before(&self, first: Option<Part<'_>>) -> bool {
        let around = first.and_then(|token| self.trivia.around(token));
        around.is_some_and(|around| around.before.first().map_or(around.blank, |comment| comment.blank))
    }

    /// A member with the comments before it, at the start of a line or behind a comma.
    fn element(&mut self, element: Element<'_>) -> Doc<'a> {
        let Some(first) = element.first else { return Doc::concat(Vec::new()) };
        let mut docs = Vec::new();
        if let Some(around) = self.trivia.around(first) {
            for (at, comment) in around.before.iter().enumerate() {
                docs.push(Doc::text(comment.text.clone()));
                let blank = around.before.get(at + 1).map_or(around.blank, |next| next.blank);
                docs.push(if comment.own_line { Doc::hard(blank) } else { Doc::space() });
            }
        }
        self.emitted = Some(start(first));
        match element.part {
            Some(part) => docs.push(self.any(part)),
            None => {
                // Where something could not be read, the next thing may be taken for a part of it but for a separator.
                let separator = |is_there: bool| Doc::text(if is_there { "," } else { "" });
                docs.push(separator(is_separated(first.previous_token(), Part::previous_token)));
                docs.push(Doc::text(self.slice(element.span()).trim_end()));
                let last = element.last.and_then(Part::next_token);
                docs.push(separator(is_separated(last, Part::next_token)));
                docs.extend(element.last.map(|token| self.after(token)));
            }
        }
        Doc::concat(docs)
    }

    /// The comments before a token, unless they are written.
    fn before(&mut self, token: Part<'_>) -> Doc<'a> {
        let mut docs = Vec::new();
        if self.emitted != Some(start(token))
            && let Some(around) = self.trivia.around(token)
        {
            for comment in &around.before {
                if comment.own_line {
                    docs.extend([Doc::fresh(), Doc::text(comment.text.clone()), Doc::hard(false)]);
                } else {
                    docs.extend([Doc::space(), Doc::text(comment.text.clone()), Doc::space()]);
                }
            }
        }
        self.emitted = Some(start(token));
        Doc::concat(docs)
    }

    fn after(&self, token: Part<'_>) -> Doc<'a> {
        let after = self.trivia.around(token).map(|around| around.after.as_slice()).unwrap_or_default();
        Doc::concat(after.iter().map(|text| Doc::suffix(text.clone())).collect())
    }

    fn token(&mut self, token: Part<'_>) -> Doc<'a> {
        let text = self.slice(token.span());
        let text = match token.kind() {
            SyntaxKind::Color => Doc::text(text.to_ascii_lowercase()),
            _ => Doc::text(text),
        };
        Doc::concat(vec![self.before(token), text, self.after(token)])
    }

    /// A group, with the comments before its first token outside.
    fn grouped(&mut self, first: Option<Part<'_>>, inside: impl FnOnce(&mut Self) -> Doc<'a>) -> Doc<'a> {
        let before = first.map(|first| self.before(first));
        let inside = inside(self).group();
        Doc::concat(before.into_iter().chain([inside]).collect())
    }

    fn any(&mut self, node: Part<'_>) -> Doc<'a> {
        use SyntaxKind as K;
        if !node.kind().is_node() {
            return self.token(node);
        }
        let first = node.first_token();
        match node.kind() {
            K::Block | K::KeyBlock => self.grouped(first, |builder| builder.bracketed(node, BRACES)),
            K::Names => self.grouped(first, |builder| builder.bracketed(node, NAMES)),
            K::Params => self.grouped(first, |builder| builder.bracketed(node, PARENS)),
            K::Tuple => {
                let last_comma = if node.nodes().nth(1).is_some() { "," } else { "" };
                self.grouped(first, |builder| builder.bracketed(node, Style { last_comma, ..PARENS }))
            }
            K::Args => match self.lone_block(node) {
                true => self.spaced(node),
                false => self.grouped(first, |builder| builder.bracketed(node, PARENS)),
            },
            K::List => self.grouped(first, |builder| builder.list(node)),
            K::IfStmt | K::IfValue => self.grouped(first, |builder| builder.branches(node)),
            K::Expr | K::Named => {
                let parts: Vec<Part<'_>> = parts(node).collect();
                self.operators(&parts)
            }
            K::Ty | K::Number | K::Index | K::Field => {
                let docs = parts(node).map(|part| self.any(part)).collect();
                Doc::concat(docs)
            }
            _ => self.spaced(node),
        }
    }

    /// The parts with a space between, where one belongs.
    fn spaced(&mut self, node: Part<'_>) -> Doc<'a> {
        let mut docs = Vec::new();
        self.spaced_into(&mut docs, node.parts().collect());
        Doc::concat(docs)
    }

    fn spaced_into(&mut self, docs: &mut Vec<Doc<'a>>, parts: Vec<Part<'_>>) {
        use SyntaxKind as K;
        let mut previous: Option<SyntaxKind> = None;
        for part in parts {
            let kind = part.kind();
            if kind == K::Comma {
                docs.push(Doc::text(","));
                previous = Some(kind);
            }
            if is_between(kind) || part.span().is_empty() {
                continue;
            }
            let glued = matches!(kind, K::Colon | K::Params | K::Args | K::Field | K::Index | K::Comma | K::CloseParen)
                || matches!(previous, Some(K::Prefix | K::OpenParen));
            if previous.is_some() && !glued {
                docs.push(Doc::space());
            }
            docs.push(self.any(part));
            previous = Some(kind);
        }
    }

    /// Whether an argument list is one value that brings its own brackets, which then needs no lines for itself.
    fn lone_block(&self, node: Part<'_>) -> bool {
        use SyntaxKind as K;
        let parts: Vec<Part<'_>> = parts(node).collect();
        let [_, only, close] = parts.as_slice() else { return false };
        let value = if only.kind() == K::NamedArg { only.last_part() } else { Some(*only) };
        let has_brackets = value.is_some_and(|value| match value.kind() {
            K::Keys | K::IfValue | K::List | K::Tuple => true,
            K::Named => value.nodes().any(|child| matches!(child.kind(), K::Block | K::Like)),
            _ => false,
        });
        let has_comments = |token: Option<Part<'_>>| {
            token.and_then(|token| self.trivia.around(token)).is_some_and(|around| !around.before.is_empty())
        };
        let open = node.first_token().and_then(|token| self.trivia.around(token));
        let open = open.is_some_and(|around| !around.after.is_empty());
        has_brackets && !open && !has_comments(first_token(*only)) && !has_comments(last_token(*close))
    }

    /// `( a, b )` and the like, without a group round it.
    fn bracketed(&mut self, node: Part<'_>, style: Style) -> Doc<'a> {
        let elements = self.elements(node, false);
        let (Some(open), Some(close)) = (node.first_token(), node.last_token()) else { return self.spaced(node) };
        let mut docs = vec![self.token(open)];
        let mut inside = Vec::new();
        if style.items && self.ends_line(open) {
            inside.push(Doc::forced_break());
        }
        let count = elements.len();
        // What could not be read would swallow a comma.
        if count > 1 && elements.iter().any(|element| element.part.is_none()) {
            inside.push(Doc::forced_break());
        }
        for (index, element) in elements.into_iter().enumerate() {
            let blank = style.items && index > 0 && self.blank_before(element.first);
            inside.push(Doc::line(if index == 0 { style.pad } else { ", " }, blank));
            inside.push(self.element(element));
            inside.push(Doc::if_broken(if style.items {
                ""
            } else if index + 1 < count {
                ","
            } else {
                style.last_comma
            }));
        }
        let has_end = self.end_of_list(&mut inside, close, style, count > 0);
        if count == 0 && !has_end {
            docs.push(self.close(close));
            return Doc::concat(docs);
        }
        docs.push(Doc::concat(inside).indent());
        docs.push(Doc::line(style.pad, false));
        docs.push(self.close(close));
        Doc::concat(docs)
    }

    /// Whether the line ends behind a token.
    fn ends_line(&self, token: Part<'_>) -> bool {
        let rest = self.text.get(token.span().end as usize..).unwrap_or_default();
        rest.trim_start_matches([' ', '\t', '\r']).starts_with('\n')
    }

    /// The comments between the last member and the closing bracket.
    fn end_of_list(&self, inside: &mut Vec<Doc<'a>>, close: Part<'_>, style: Style, has_members: bool) -> bool {
        let comments = self.trivia.around(close).map(|around: &Around| around.before.as_slice()).unwrap_or_default();
        for (at, comment) in comments.iter().enumerate() {
            let after_all = has_members || at > 0;
            let blank = style.items && after_all && comment.blank;
            inside.push(match comment.own_line {
                true => Doc::hard(blank),
                false => Doc::line(if after_all { " " } else { style.pad }, blank),
            });
            inside.push(Doc::text(comment.text.clone()));
        }
        !comments.is_empty()
    }

    /// A closing bracket, whose comments before it are written.
    fn close(&mut self, close: Part<'_>) -> Doc<'a> {
        self.emitted = Some(start(close));
        self.token(close)
    }

    /// `[a, b]`: lines that the author ended in it end where they did, if they begin behind the bracket.
    fn list(&mut self, node: Part<'_>) -> Doc<'a> {
        if node.nodes().any(|child| child.kind() == SyntaxKind::Comp) {
            return self.bracketed(node, Style { last_comma: "", ..PARENS });
        }
        let elements = self.elements(node, false);
        let (Some(open), Some(close)) = (node.first_token(), node.last_token()) else { return self.spaced(node) };
        let mut docs = vec![self.token(open)];
        let mut inside = Vec::new();
        if self.ends_line(open) && !elements.is_empty() {
            inside.push(Doc::forced_break());
        }
        let count = elements.len();
        let mut previous: Option<(bool, u32)> = None;
        for element in elements {
            let small = element.part.is_some_and(is_small);
            let Span { start, end } = element.span();
            match previous {
                None => inside.push(Doc::line("", false)),
                Some((true, before)) if small && !self.slice(Span::new(before, start)).contains('\n') => {
                    inside.push(Doc::fill());
                }
                Some(_) => inside.extend([Doc::if_broken(","), Doc::line(", ", false)]),
            }
            inside.push(self.element(element));
            previous = Some((small, end));
        }
        inside.push(Doc::if_broken(if count > 0 { "," } else { "" }));
        let has_end = self.end_of_list(&mut inside, close, PARENS, count > 0);
        if count > 0 || has_end {
            docs.push(Doc::concat(inside).indent());
            docs.push(Doc::line("", false));
        }
        docs.push(self.close(close));
        Doc::concat(docs)
    }

    /// `if a { x } else { y }`: all of it on one line, or none.
    fn branches(&mut self, node: Part<'_>) -> Doc<'a> {
        let mut docs = Vec::new();
        let mut previous = false;
        for part in parts(node) {
            if previous {
                docs.push(Doc::space());
            }
            previous = true;
            docs.push(match part.kind() {
                SyntaxKind::Block | SyntaxKind::Arm => {
                    let before = part.first_token().map(|first| self.before(first));
                    let arm = self.bracketed(part, BRACES);
                    Doc::concat(before.into_iter().chain([arm]).collect())
                }
                _ => self.any(part),
            });
        }
        Doc::concat(docs)
    }

    /// An expression: lines end before its loosest operators.
    fn operators(&mut self, parts: &[Part<'_>]) -> Doc<'a> {
        let op = |part: &Part<'_>| (part.kind() == SyntaxKind::Op).then(|| level_of(part.text()));
        let Some(loosest) = parts.iter().filter_map(op).min() else {
            let mut docs = Vec::new();
            self.spaced_into(&mut docs, parts.to_vec());
            return Doc::concat(docs);
        };
        let is_range = parts.iter().any(|part| !part.kind().is_node() && part.text() == "..");
        let first = parts.first().and_then(|part| first_token(*part));
        self.grouped(first, |builder| {
            let mut operands = parts.split(|part| op(part) == Some(loosest));
            let mut docs =
                vec![operands.next().map_or_else(|| Doc::concat(Vec::new()), |part| builder.operators(part))];
            let mut rest = Vec::new();
            for (sign, operand) in parts.iter().filter(|part| op(part) == Some(loosest)).zip(operands) {
                if !is_range {
                    rest.push(Doc::line(" ", false));
                }
                rest.push(builder.any(*sign));
                if !is_range {
                    rest.push(Doc::space());
                }
                rest.push(builder.operators(operand));
            }
            docs.push(Doc::concat(rest).indent());
            Doc::concat(docs)
        })
    }
}

/// What may share a line with its neighbours in a long list: numbers, and brackets of them.
fn is_small(part: Part<'_>) -> bool {
    use SyntaxKind as K;
    match part.kind() {
        K::Color | K::String | K::Boolean | K::Path | K::Number => true,
        K::Tuple => parts(part).all(|part| !part.kind().is_node() || is_small(part)),
        K::Expr => parts(part).all(|part| part.kind() == K::Prefix || is_small(part)),
        K::Named => parts(part).all(|part| part.kind() == K::Path),
        _ => false,
    }
}
