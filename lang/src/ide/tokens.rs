//! What each word of a text is, for colouring.

use rustc_hash::FxHashMap;

use super::Analysis;
use super::cursor::{Slot, is_kind, slot};
use crate::builtin;
use crate::eval::Symbol;
use crate::eval::surface::is_point;
use crate::schema::{self, Sort};
use crate::source::Span;
use crate::syntax::{Part, SyntaxKind as K};

/// What a word is: names of the protocol's standard types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum TokenKind {
    Keyword,
    Comment,
    String,
    Number,
    Operator,
    /// A kind of node, or a prefab.
    Class,
    /// A type.
    Type,
    Property,
    Function,
    Variable,
    Parameter,
    /// A module.
    Namespace,
    /// A word that a property takes, an easing.
    EnumMember,
}

impl TokenKind {
    /// All, in the order of their numbers.
    pub const ALL: &[(TokenKind, &str)] = &[
        (TokenKind::Keyword, "keyword"),
        (TokenKind::Comment, "comment"),
        (TokenKind::String, "string"),
        (TokenKind::Number, "number"),
        (TokenKind::Operator, "operator"),
        (TokenKind::Class, "class"),
        (TokenKind::Type, "type"),
        (TokenKind::Property, "property"),
        (TokenKind::Function, "function"),
        (TokenKind::Variable, "variable"),
        (TokenKind::Parameter, "parameter"),
        (TokenKind::Namespace, "namespace"),
        (TokenKind::EnumMember, "enumMember"),
    ];
}

/// What else is true of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Modifier {
    Declaration,
    /// It cannot change: `let`, `param`.
    Readonly,
    /// It is part of the language.
    DefaultLibrary,
    Documentation,
}

impl Modifier {
    /// All, in the order of their bits.
    pub const ALL: &[(Modifier, &str)] = &[
        (Modifier::Declaration, "declaration"),
        (Modifier::Readonly, "readonly"),
        (Modifier::DefaultLibrary, "defaultLibrary"),
        (Modifier::Documentation, "documentation"),
    ];
}

/// A word with what it is. On one line; words do not overlap and are in the text's order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Token {
    /// Where.
    pub span: Span,
    /// What it is.
    pub kind: TokenKind,
    /// What else is true.
    pub modifiers: &'static [Modifier],
}

/// What the words of a text are; with `within`, only those there.
pub fn tokens(analysis: &Analysis, within: Option<Span>) -> Vec<Token> {
    let index = analysis.index();
    let own = |span: &Span| span.end <= analysis.tree.source.len();
    let mut names: FxHashMap<Span, (Symbol, bool)> = FxHashMap::default();
    for (span, symbol) in index.declared.iter().filter(|(span, _)| own(span)) {
        names.insert(*span, (*symbol, true));
    }
    for used in index.uses.iter().filter(|used| own(&used.at)) {
        if let Some(symbol) = analysis.symbol(used.to) {
            let declares = names.contains_key(&used.at);
            names.insert(used.at, (symbol, declares));
        }
    }
    let mut found = Vec::new();
    let inside =
        |part: &Part<'_>| within.is_none_or(|within| part.span().start < within.end && within.start < part.span().end);
    for part in analysis.tree.root().tokens().filter(inside) {
        classify(part, &names, &mut found);
    }
    // A comment or a text that could not be read may have many lines; editors want one each.
    let source = &analysis.tree.source;
    let mut split = Vec::with_capacity(found.len());
    for token in found {
        let (first, last) = (source.line_index(token.span.start), source.line_index(token.span.end));
        for line in first..=last {
            let of = source.line_span(line);
            let span = Span::new(of.start.max(token.span.start), of.end.min(token.span.end));
            if !span.is_empty() {
                split.push(Token { span, ..token });
            }
        }
    }
    split
}

fn classify(part: Part<'_>, names: &FxHashMap<Span, (Symbol, bool)>, found: &mut Vec<Token>) {
    const NONE: &[Modifier] = &[];
    const BUILT_IN: &[Modifier] = &[Modifier::DefaultLibrary];
    let span = part.span();
    let mut add = |span: Span, kind: TokenKind, modifiers: &'static [Modifier]| {
        found.push(Token { span, kind, modifiers });
    };
    let parent = part.parent().map_or(K::File, Part::kind);
    match part.kind() {
        K::LineComment | K::BlockComment => add(span, TokenKind::Comment, NONE),
        K::DocComment => add(span, TokenKind::Comment, &[Modifier::Documentation]),
        K::String | K::BadString => match names.get(&span) {
            Some((symbol, declares)) => add(span, kind_of(symbol), modifiers_of(symbol, *declares)),
            None => add(span, TokenKind::String, NONE),
        },
        K::Digits | K::Unit | K::Color => add(span, TokenKind::Number, NONE),
        K::Op | K::Prefix => add(span, TokenKind::Operator, NONE),
        kind if kind.is_keyword() || kind == K::Boolean => add(span, TokenKind::Keyword, NONE),
        K::KeyName => match names.get(&span) {
            Some((symbol, declares)) => add(span, kind_of(symbol), modifiers_of(symbol, *declares)),
            None if parent == K::NamedArg => add(span, TokenKind::Parameter, NONE),
            None => add(span, TokenKind::Property, NONE),
        },
        K::Ident => match names.get(&span) {
            Some((symbol, declares)) => add(span, kind_of(symbol), modifiers_of(symbol, *declares)),
            None if parent == K::Ty => add(span, TokenKind::Type, BUILT_IN),
            None if parent == K::Field => add(span, TokenKind::Property, NONE),
            None if parent == K::Node => add(span, TokenKind::Variable, &[Modifier::Declaration]),
            None => add(span, TokenKind::Variable, NONE),
        },
        K::Path => {
            let mut at = span.start;
            let is_kind = is_kind(part);
            for (i, segment) in part.text().split('.').enumerate() {
                let own = Span::new(at, at + segment.len() as u32);
                at = own.end + 1;
                if segment.is_empty() {
                    continue;
                }
                let (kind, modifiers) = match names.get(&own) {
                    Some((symbol, declares)) => (kind_of(symbol), modifiers_of(symbol, *declares)),
                    None if i > 0 => (TokenKind::Property, NONE),
                    None if is_kind => {
                        let known = schema::kind(segment).is_some();
                        (TokenKind::Class, if known { BUILT_IN } else { NONE })
                    }
                    None => plain(part, segment),
                };
                add(own, kind, modifiers);
            }
        }
        _ => {}
    }
}

/// A word of the language where a value stands.
fn plain(part: Part<'_>, text: &str) -> (TokenKind, &'static [Modifier]) {
    const BUILT_IN: &[Modifier] = &[Modifier::DefaultLibrary];
    let called = part.parent().is_some_and(|named| named.nodes().any(|node| node.kind() == K::Args));
    match slot(part) {
        Slot::Ease => return (TokenKind::EnumMember, BUILT_IN),
        Slot::Property { row: Some(row), .. } => {
            if let schema::Type::Choice(words) = row.ty
                && words.iter().any(|word| word.name == text)
            {
                return (TokenKind::EnumMember, BUILT_IN);
            }
        }
        Slot::Argument { name: Some(_), .. }
            if !called && builtin::find(text).is_none() && !is_point(text) && !matches!(text, "time" | "frame") =>
        {
            return (TokenKind::EnumMember, BUILT_IN);
        }
        _ => {}
    }
    if called && builtin::find(text).is_some() {
        return (TokenKind::Function, BUILT_IN);
    }
    if is_point(text) || matches!(text, "time" | "frame") {
        return (TokenKind::Variable, BUILT_IN);
    }
    (TokenKind::Variable, &[])
}

fn kind_of(symbol: &Symbol) -> TokenKind {
    match symbol {
        Symbol::Let | Symbol::Param | Symbol::Loop | Symbol::Unknown => TokenKind::Variable,
        Symbol::Formal => TokenKind::Parameter,
        Symbol::Fn => TokenKind::Function,
        Symbol::Prefab => TokenKind::Class,
        Symbol::Node(_) => TokenKind::Variable,
        Symbol::Module => TokenKind::Namespace,
    }
}

fn modifiers_of(symbol: &Symbol, declares: bool) -> &'static [Modifier] {
    let fixed = match symbol {
        Symbol::Let | Symbol::Param => true,
        Symbol::Node(Some(kind)) => kind.sort == Sort::Material,
        _ => false,
    };
    match (declares, fixed) {
        (true, true) => &[Modifier::Declaration, Modifier::Readonly],
        (true, false) => &[Modifier::Declaration],
        (false, true) => &[Modifier::Readonly],
        (false, false) => &[],
    }
}
