//! Names: where they are declared, and where they are used.

use super::walk::{Seen, walk};
use super::{Analysis, Index};
use crate::eval::{Symbol, Use};
use crate::source::{Source, Span, Texts};
use crate::syntax::ast::{self, Item, Name};

/// A place in one of several files.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// The file's path from the project's root; `std/...` of what is part of this program.
    pub file: std::sync::Arc<str>,
    /// Where in it.
    pub span: Span,
}

/// Whether a text can be a name.
pub fn is_name(text: &str) -> bool {
    let mut letters = text.chars();
    let first = letters.next().is_some_and(|first| first == '_' || unicode_ident::is_xid_start(first));
    first && letters.all(unicode_ident::is_xid_continue) && !super::complete::KEYWORDS.contains(&text)
}

/// What declares a name.
#[derive(Clone, Copy)]
#[allow(missing_docs)]
pub enum Declaration<'a> {
    Let(&'a ast::LetDecl),
    Param(&'a ast::ParamDecl),
    Fn(&'a ast::FnDecl),
    Prefab(&'a ast::PrefabDecl),
    Node(&'a ast::Node),
    Formal(&'a ast::Formal),
    Loop(&'a ast::ForHead),
    Import(&'a ast::ImportDecl),
}

impl<'a> Declaration<'a> {
    /// The text above it.
    pub fn docs(&self) -> Option<&'a str> {
        match self {
            Declaration::Let(decl) => decl.docs.as_deref(),
            Declaration::Param(decl) => decl.docs.as_deref(),
            Declaration::Fn(decl) => decl.docs.as_deref(),
            Declaration::Prefab(decl) => decl.docs.as_deref(),
            Declaration::Node(node) => node.docs.as_deref(),
            Declaration::Formal(_) | Declaration::Loop(_) | Declaration::Import(_) => None,
        }
    }

    /// What is written, in one line and without bodies.
    pub fn line(&self, texts: &Texts) -> String {
        let text = |span: Span| {
            let line = texts.slice(span).split_whitespace().collect::<Vec<_>>().join(" ");
            line.replace("( ", "(").replace(", )", ")").replace(" )", ")")
        };
        let short = |span: Span| {
            let text = text(span);
            match text.char_indices().nth(90) {
                Some((at, _)) => format!("{} …", &text[..at]),
                None => text,
            }
        };
        match self {
            Declaration::Let(decl) => short(decl.span),
            Declaration::Param(decl) => short(decl.span),
            Declaration::Fn(decl) => match &decl.body {
                ast::FnBody::Value(value) => short(decl.head.to(value.span)),
                _ => text(decl.head),
            },
            Declaration::Prefab(decl) => text(decl.head),
            Declaration::Node(node) => match &node.body {
                Some(body) => text(Span::new(node.span.start, body.span.start)),
                None => text(node.span),
            },
            Declaration::Formal(formal) => short(formal.span),
            Declaration::Loop(head) => short(head.span),
            Declaration::Import(import) => short(import.span),
        }
    }
}

impl Analysis {
    /// The declaration whose name stands at a place.
    pub fn declaration(&self, name: Span) -> Option<Declaration<'_>> {
        let module = self.modules.list.iter().rev().find(|module| module.file.span.start <= name.start)?;
        let is = |found: &Option<Name>| found.as_ref().is_some_and(|found| found.span == name);
        let holds = |span: Span| span.start <= name.start && name.end <= span.end;
        let mut found = None;
        walk(&module.file.items, &mut |seen| {
            let inside = match seen {
                Seen::Item(item) => {
                    match item {
                        Item::Let(decl) if is(&decl.name) => found = Some(Declaration::Let(decl)),
                        Item::Param(decl) if is(&decl.name) => found = Some(Declaration::Param(decl)),
                        Item::Fn(decl) if is(&decl.name) => found = Some(Declaration::Fn(decl)),
                        Item::Prefab(decl) if is(&decl.name) => found = Some(Declaration::Prefab(decl)),
                        Item::Node(node) if is(&node.name) => found = Some(Declaration::Node(node)),
                        Item::Import(import) if holds(import.span) => found = Some(Declaration::Import(import)),
                        _ => {}
                    }
                    holds(item.span())
                }
                Seen::Node(node) => holds(node.span),
                Seen::Expr(expr) => holds(expr.span),
                Seen::Formal(formal) => {
                    if formal.name.span == name {
                        found = Some(Declaration::Formal(formal));
                    }
                    holds(formal.span)
                }
                Seen::Key(key) => holds(key.span),
                Seen::Head(head) => {
                    if head.names.iter().any(|own| own.span == name) {
                        found = Some(Declaration::Loop(head));
                    }
                    holds(head.span)
                }
            };
            inside && found.is_none()
        });
        found
    }

    /// The name at an offset of the text itself: what it is declared as, and where it is written here.
    pub fn name_at(&self, offset: u32) -> Option<(Span, Span)> {
        let index = self.index();
        let touches = |span: &Span| span.start <= offset && offset <= span.end;
        let before = index.uses.partition_point(|found| found.at.start <= offset);
        // Names do not overlap, but one may be used for two things at one place.
        let used = index.uses[..before].iter().rev().take(4).map(|found| found.at).find(|at| touches(at));
        if let Some(at) = used {
            return Some((at, index.follow(at, false)));
        }
        let own = index.declared.keys().find(|span| touches(span) && !span.is_empty())?;
        Some((*own, *own))
    }

    /// What a name is, where it is declared or used; of an imported one, what it is in the other file.
    pub fn symbol(&self, name: Span) -> Option<Symbol> {
        let index = self.index();
        let ends = [index.follow(name, false), index.follow(name, true), name];
        ends.iter().find_map(|end| index.declared.get(end)).copied()
    }

    /// Where the name at an offset is declared, and the names between, from here to there.
    pub fn definition(&self, offset: u32) -> Option<(Span, Place)> {
        let (at, to) = self.name_at(offset)?;
        Some((at, self.place(to)))
    }

    /// A place of [`Modules::texts`](crate::modules::Modules::texts) in its own file.
    pub fn place(&self, span: Span) -> Place {
        let source = self.modules.texts.source(span.start);
        Place { file: source.name.clone(), span: self.modules.texts.settled(span).1 }
    }

    /// The source of a file that is part of this, by its name.
    pub fn source(&self, file: &str) -> Option<&Source> {
        self.modules.list.iter().map(|module| &module.source).find(|source| *source.name == *file)
    }

    /// Every place in these files that means what is declared at `declared`, which is among them if it is here. With
    /// `same_word`, only those that are the same word: an import may give it another one.
    pub fn references(&self, declared: &Place, same_word: bool) -> Vec<Place> {
        let index = self.index();
        let mut found: Vec<Place> = Vec::new();
        let here = |span: Span| self.place(span) == *declared;
        found.extend(index.declared.keys().filter(|span| here(**span)).map(|span| self.place(*span)));
        for used in &index.uses {
            let to = index.follow(used.at, same_word);
            if to != used.at && here(to) {
                found.push(self.place(used.at));
            }
        }
        found.sort();
        found.dedup();
        found
    }

    /// What the name at an offset is called: where it is declared as the same word, and every place between.
    pub fn word_at(&self, offset: u32) -> Option<(Span, Place)> {
        let (at, _) = self.name_at(offset)?;
        Some((at, self.place(self.index().follow(at, true))))
    }

    /// Whether all names of these files still mean the same in `after`, where each place has moved as `now` says.
    pub fn means_the_same(&self, after: &Analysis, now: &dyn Fn(&Place) -> Place) -> bool {
        let pairs = |analysis: &Analysis, now: &dyn Fn(&Place) -> Place| {
            let of = |used: &Use| (now(&analysis.place(used.at)), now(&analysis.place(used.to)));
            let mut pairs: Vec<(Place, Place)> = analysis.index().uses.iter().map(of).collect();
            pairs.sort();
            pairs
        };
        let declared = |analysis: &Analysis, now: &dyn Fn(&Place) -> Place| {
            let mut all: Vec<Place> = analysis.index().declared.keys().map(|at| now(&analysis.place(*at))).collect();
            all.sort();
            all
        };
        let stay = |place: &Place| place.clone();
        pairs(self, now) == pairs(after, &stay) && declared(self, now) == declared(after, &stay)
    }
}

impl Index {
    /// Goes from name to name up to a declaration; with `same_word` no further than where the word changes.
    fn follow(&self, from: Span, same_word: bool) -> Span {
        const MOST: usize = 64;
        let mut at = from;
        for _ in 0..MOST {
            let of = self.uses.partition_point(|found| found.at < at);
            let Some(next) = self.uses.get(of).filter(|found| found.at == at && found.to != at) else { break };
            if same_word && !next.same_word {
                break;
            }
            at = next.to;
        }
        at
    }
}
