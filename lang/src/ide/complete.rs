//! What may be written at a place.

use super::Analysis;
use super::cursor::{Owner, Slot, called, owner, schema_kind, set_in, slot};
use super::walk::{Seen, walk};
use crate::builtin::{self, BUILTINS, Builtin, ease};
use crate::dimension::{Dimension, UNITS};
use crate::eval::items::kind_text;
use crate::eval::keys;
use crate::eval::surface::POINT_NAMES;
use crate::files::{Files, resolve};
use crate::library;
use crate::schema::{self, Default, Holds, KINDS, Kind, Place, Property, Since, Sort, TYPES, Type};
use crate::source::{Source, Span};
use crate::suggest::any_of;
use crate::syntax::ast::{self, Item};
use crate::syntax::{Part, SyntaxKind as K, parse};

/// Words of the language that cannot be names.
pub const KEYWORDS: &[&str] = &[
    "after", "as", "ease", "else", "false", "fn", "for", "from", "if", "import", "in", "keys", "lang", "let", "like",
    "param", "prefab", "return", "true",
];

/// What a suggestion is, for its icon.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum CompletionKind {
    Keyword,
    Kind,
    Property,
    Function,
    Value,
    Param,
    Node,
    Prefab,
    Module,
    Word,
    Unit,
    Type,
    File,
    Folder,
}

/// One suggestion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Completion {
    /// What the list shows.
    pub label: String,
    /// What it is.
    pub kind: CompletionKind,
    /// In a few words, beside the label: its type and default.
    pub detail: String,
    /// What is written, as a snippet: `radius: ${1:1m}`.
    pub snippet: String,
    /// What is written where the editor knows no snippets.
    pub plain: String,
    /// What it takes the place of.
    pub replace: Span,
    /// What fits best has the lowest.
    pub rank: u8,
    /// For [`document`]; empty where there is nothing to say.
    pub about: String,
}

/// What stands for the cursor while the text round it is parsed; no one writes it.
const HERE: &str = "kinora_here_";

/// What may be written at an offset, whatever is there; what is typed already is for the editor to compare with.
pub fn completions(analysis: &Analysis, offset: u32, files: &dyn Files) -> Vec<Completion> {
    let source = &analysis.tree.source;
    let offset = source.clamp(offset);
    let before = source.slice(Span::new(0, offset));
    let word = |letter: char| unicode_ident::is_xid_continue(letter);
    let start =
        offset - before.chars().rev().take_while(|letter| word(*letter)).map(|l| l.len_utf8() as u32).sum::<u32>();
    let behind = source.slice(Span::new(offset, source.len()));
    // Of a word that the cursor is inside of, all of it is replaced.
    let rest = behind.chars().take_while(|letter| word(*letter)).map(|l| l.len_utf8() as u32).sum::<u32>();
    let end = if start < offset { offset + rest } else { offset };
    // What is typed so far, and the rest of the word behind the cursor, stay: only where there is no word, one is put.
    let put = if start == offset && !behind.starts_with(word) { HERE } else { "" };
    let text = format!("{before}{put}{behind}");
    let tree = parse(&Source::new(source.id, source.name.clone(), text));
    let at = if put.is_empty() { offset.saturating_sub(u32::from(start < offset)) } else { start };
    let Some(token) = tree.root().token_at(at) else { return Vec::new() };
    let mut list = List {
        analysis,
        files,
        items: &tree.file().items,
        replace: Span::new(start, end),
        offset,
        at,
        found: Vec::new(),
    };
    list.fill(token, before);
    list.found.sort_by(|a, b| (a.rank, &a.label).cmp(&(b.rank, &b.label)));
    list.found.dedup_by(|a, b| a.label == b.label && a.kind == b.kind);
    list.found
}

struct List<'a> {
    analysis: &'a Analysis,
    files: &'a dyn Files,
    /// The text with a word where the cursor is.
    items: &'a [Item],
    replace: Span,
    /// Where the cursor is.
    offset: u32,
    /// A place inside of the word that is typed.
    at: u32,
    found: Vec<Completion>,
}

impl<'a> List<'a> {
    fn add(&mut self, label: &str, kind: CompletionKind, detail: impl Into<String>, rank: u8) -> &mut Completion {
        self.found.push(Completion {
            label: label.into(),
            kind,
            detail: detail.into(),
            snippet: escape(label),
            plain: label.into(),
            replace: self.replace,
            rank,
            about: String::new(),
        });
        let last = self.found.len() - 1;
        &mut self.found[last]
    }

    fn keywords(&mut self, words: &[&str]) {
        for word in words {
            let snippet = match *word {
                "let" => "let ${1:name} = $0",
                "param" => "param ${1:name} = ${2:0.5} in ${3:0}..${4:1}",
                "fn" => "fn ${1:name}(${2:x}) = $0",
                "prefab" => "prefab ${1:name}(${2:size: length = 1m}) {\n    $0\n}",
                "for" => "for ${1:i} in ${2:0..10} {\n    $0\n}",
                "if" => "if ${1:condition} {\n    $0\n}",
                "import" => "import { $2 } from \"$1\"",
                "lang" => "lang 1",
                "return" => "return $0",
                "keys" => "keys {\n    0s: $1\n    ${2:1s}: $0\n}",
                "ease" => "ease ${1:in_out_cubic}",
                "after" => "after ${1:1s}: $0",
                other => other,
            };
            let entry = self.add(word, CompletionKind::Keyword, "", 4);
            entry.snippet = snippet.into();
            entry.about = format!("keyword {word}");
        }
    }

    fn fill(&mut self, token: Part<'a>, before: &str) {
        match token.kind() {
            K::LineComment | K::DocComment | K::BlockComment => {}
            K::String | K::BadString => self.paths(token),
            K::Digits | K::Unit | K::BadUnit => self.units(token),
            K::Color => {}
            K::KeyName if token.parent().is_some_and(|parent| parent.kind() == K::NamedArg) => {
                if let Slot::Argument { args, .. } = slot(token) {
                    self.argument_names(args, false);
                }
            }
            K::KeyName => self.items(token, true),
            K::BadItem => self.unread(token, before),
            K::Ident => match token.parent().map(Part::kind) {
                // Behind `as` comes a name of one's own.
                Some(K::Rename) if previous(token).is_none_or(|before| before.kind() != K::KwAs) => {
                    self.offered_names(token);
                }
                Some(K::Ty) => self.types(),
                _ => {}
            },
            K::Path => match token.parent() {
                Some(parent) if parent.kind() == K::Node => match token.text().rsplit_once('.') {
                    Some((base, _)) => self.members(base, |what| matches!(what, Visible::Prefab(_))),
                    None => self.items(token, false),
                },
                _ => self.values(token),
            },
            kind if kind.is_keyword() || kind == K::Boolean => {
                // A word that is one of the language so far: `in` of `in_out_cubic`.
                match slot(token) {
                    Slot::Ease => self.easings(),
                    Slot::Any if token.parent().is_some_and(|parent| parent.kind().is_item()) => {
                        self.items(token, false)
                    }
                    _ => self.values(token),
                }
            }
            _ => {}
        }
    }

    /// Where an item or a key should be and what stands there is neither, so far.
    fn unread(&mut self, token: Part<'a>, before: &str) {
        let start = (token.span().start as usize).min(self.replace.start as usize);
        let line = before.get(start..self.replace.start as usize).unwrap_or_default();
        let head = line.trim_end();
        let written: Vec<&str> = head.split_whitespace().collect();
        let ahead = previous(token);
        let is_after = |kind: K| written.is_empty() && ahead.is_some_and(|ahead| ahead.kind() == kind);
        if written.last() == Some(&"ease") || is_after(K::KwEase) {
            return self.easings();
        }
        if matches!(owner(token), Owner::Keys) {
            return self.keywords(&["ease", "after"]);
        }
        if let Some(named) = head.strip_suffix('.').filter(|head| head.len() == line.len() - 1) {
            let base = named.rsplit(|letter| !unicode_ident::is_xid_continue(letter)).next().unwrap_or_default();
            return self.members(base, |what| matches!(what, Visible::Prefab(_)));
        }
        if !written.is_empty() {
            // A kind, and what the node is called.
            let is_kind = schema::kind(written[0]).is_some() || self.prefab(written[0]).is_some();
            match written.as_slice() {
                [_] | [_, _] if is_kind => self.keywords(&["like"]),
                ["for", _] => self.keywords(&["in"]),
                _ => {}
            }
            return;
        }
        let Some(ahead) = ahead else { return self.items(token, false) };
        let gap = self.analysis.tree.source.slice(Span::new(ahead.span().end, self.replace.start));
        let parents = [ahead.parent(), ahead.parent().and_then(Part::parent)].map(|part| part.map(Part::kind));
        // What goes on with what stands on this line.
        let goes_on: &[&str] = match (ahead.kind(), parents) {
            _ if gap.contains('\n') => &[],
            (K::KwImport | K::KwFrom | K::KwAs | K::KwLet | K::KwParam | K::KwFn | K::KwPrefab | K::KwFor, _) => return,
            (K::String, [Some(K::ImportDecl), _]) => &["as"],
            (_, [Some(K::Names), _]) => &["from"],
            (_, [Some(K::Block), Some(K::IfStmt)]) => &["else"],
            (_, [Some(K::ForStmt), _]) => &["in"],
            (_, [Some(K::ParamDecl), _] | [_, Some(K::ParamDecl)]) => &["in"],
            _ => &[],
        };
        self.keywords(goes_on);
        self.found.iter_mut().for_each(|found| found.rank = 0);
        if !matches!(goes_on, ["as" | "from"]) {
            self.items(token, false);
        }
    }

    /// What may stand in a block: properties, kinds, declarations.
    fn items(&mut self, token: Part<'a>, key_only: bool) {
        let stands =
            token.parent().filter(|parent| parent.kind() != K::File && parent.kind() != K::Block).unwrap_or(token);
        match owner(stands) {
            Owner::Top => {
                self.kinds(|kind| matches!(kind.place, Place::Top | Place::Scene));
                self.prefabs();
                self.keywords(&["let", "param", "fn", "prefab", "for", "if", "import", "lang"]);
            }
            Owner::Scene => {
                self.kinds(|kind| kind.place == Place::Scene);
                self.prefabs();
                self.keywords(&["let", "for", "if"]);
            }
            Owner::Node(node) => match schema_kind(node) {
                Some(kind) if self.prefab(super::cursor::kind_of(node).map_or("", Part::text)).is_none() => {
                    let set: Vec<&str> = set_in(node, stands).collect();
                    self.properties(kind, &set, key_only);
                    if key_only {
                        return;
                    }
                    match kind.holds {
                        Holds::Nothing => {}
                        Holds::Parts => self.kinds(|part| fits_inside(part, kind)),
                        Holds::Scene => {
                            self.kinds(|part| part.place == Place::Scene || fits_inside(part, kind));
                            self.prefabs();
                        }
                    }
                    self.keywords(&["let", "for", "if"]);
                }
                _ => {
                    let kind = super::cursor::kind_of(node).map_or("", Part::text);
                    let Some(prefab) = self.prefab(kind) else { return };
                    let set: Vec<&str> = set_in(node, stands).collect();
                    for formal in prefab.params.iter().filter(|formal| !set.contains(&&*formal.name.text)) {
                        self.formal(formal, key_only);
                    }
                }
            },
            Owner::Function => self.keywords(&["let", "return", "if", "for"]),
            Owner::KeyValue => {
                for name in ["value", "in", "out"] {
                    let entry = self.add(name, CompletionKind::Property, "", 0);
                    entry.snippet = if key_only { name.into() } else { format!("{name}: $0") };
                }
            }
            Owner::Keys | Owner::Import(_) | Owner::Nowhere => {}
        }
    }

    fn formal(&mut self, formal: &ast::Formal, key_only: bool) {
        let texts = &self.analysis.modules.texts;
        let detail = texts.slice(formal.span).to_string();
        let name = &*formal.name.text;
        let default = formal.default.as_ref().map_or("", |value| texts.slice(value.span)).to_string();
        let entry = self.add(name, CompletionKind::Param, detail, u8::from(formal.default.is_some()));
        if !key_only {
            let value = if default.is_empty() { "$1".into() } else { format!("${{1:{}}}", escape(&default)) };
            entry.snippet = format!("{}: {value}", escape(name));
            entry.plain = format!("{name}: ");
        }
    }

    fn properties(&mut self, kind: &'static Kind, set: &[&str], key_only: bool) {
        for property in kind.all().filter(|row| row.since != Since::Later && !set.contains(&row.name)) {
            let needed = property.default == Default::Needed;
            let entry = self.add(property.name, CompletionKind::Property, detail_of(property), u8::from(!needed));
            if !key_only {
                entry.snippet = format!("{}: {}", property.name, placeholder(property));
                entry.plain = format!("{}: ", property.name);
            }
            entry.about = format!("property {} {}", kind.name, property.name);
        }
    }

    fn kinds(&mut self, wanted: impl Fn(&Kind) -> bool) {
        for kind in KINDS.iter().filter(|kind| kind.since == Since::Now && wanted(kind)) {
            let entry = self.add(kind.name, CompletionKind::Kind, kind.sort.with_article(), 2);
            let mut stop = 1;
            let name = match kind.sort {
                Sort::Render | Sort::Sky | Sort::Simulation | Sort::Part => String::new(),
                _ => {
                    stop += 1;
                    format!("${{1:{}}} ", if kind.sort == Sort::Camera { "main" } else { "name" })
                }
            };
            let needed = kind.all().filter(|row| row.default == Default::Needed && row.since == Since::Now);
            let lines: String = needed
                .map(|row| {
                    stop += 1;
                    format!("    {}: {}\n", row.name, placeholder_at(row, stop - 1))
                })
                .collect();
            entry.snippet = format!("{} {name}{{\n{lines}    $0\n}}", kind.name);
            entry.about = format!("kind {}", kind.name);
        }
    }

    /// What a name or `module.name` is at the top of the text or in an import, as analysed, for its places: the text with
    /// a word in it has others.
    fn named(&self, name: &str) -> Option<Visible<'a>> {
        let found = match name.split_once('.') {
            Some((module, name)) => named_in(self.module(module)?, name)?,
            None => named_in(&self.analysis.modules.list.first()?.file.items, name)?,
        };
        Some(self.followed(name, found))
    }

    /// Of an imported name, what it is in its own file.
    fn followed(&self, name: &str, what: Visible<'a>) -> Visible<'a> {
        let Visible::Imported = what else { return what };
        let modules = &self.analysis.modules;
        let there =
            modules.list.first().into_iter().flat_map(crate::modules::Module::imports).find_map(|(import, to)| {
                let mut renamed = import.names.iter().flatten();
                let own = renamed.find(|rename| &*rename.alias.as_ref().unwrap_or(&rename.name).text == name)?;
                named_in(&modules.list.get(to?)?.file.items, &own.name.text)
            });
        there.unwrap_or(what)
    }

    /// The prefab of this name: of the text itself or of an import.
    fn prefab(&self, name: &str) -> Option<&'a ast::PrefabDecl> {
        match self.named(name)? {
            Visible::Prefab(decl) => Some(decl),
            _ => None,
        }
    }

    /// What a file that is imported under a name holds.
    fn module(&self, name: &str) -> Option<&'a [Item]> {
        let modules = &self.analysis.modules;
        let to = modules
            .list
            .first()?
            .imports()
            .find_map(|(import, to)| import.alias.as_ref().filter(|alias| &*alias.text == name).and(to))?;
        Some(&modules.list.get(to)?.file.items)
    }

    fn prefabs(&mut self) {
        for (name, what) in self.visible() {
            match what {
                Visible::Prefab(decl) => self.call_of_prefab(name, decl, 1),
                Visible::Module => {
                    self.add(name, CompletionKind::Module, "an imported file", 3);
                }
                _ => {}
            }
        }
    }

    fn call_of_prefab(&mut self, name: &str, decl: &ast::PrefabDecl, rank: u8) {
        let needed = decl.params.iter().filter(|formal| formal.default.is_none());
        let values: Vec<String> =
            needed.enumerate().map(|(i, formal)| format!("{}: ${}", escape(&formal.name.text), i + 1)).collect();
        let inside = if values.is_empty() { "$0".to_string() } else { values.join(", ") };
        let about = decl.docs.as_deref().map_or(String::new(), |docs| format!("text {docs}"));
        let entry = self.add(name, CompletionKind::Prefab, "a prefab", rank);
        entry.snippet = format!("{} {{ {inside} }}", escape(name));
        entry.about = about;
    }

    /// What the text declares that can be seen from where the cursor is.
    fn visible(&self) -> Vec<(&'a str, Visible<'a>)> {
        let mut found = Vec::new();
        let at = self.at;
        let holds = |span: Span| span.start <= at && at <= span.end;
        declared(self.items, &mut found);
        walk(self.items, &mut |seen| {
            match seen {
                Seen::Item(item) if !holds(item.span()) => return false,
                Seen::Item(Item::Fn(decl)) => {
                    found.extend(decl.params.iter().map(|formal| (&*formal.name.text, Visible::Value("a parameter"))));
                    if let ast::FnBody::Block(block) = &decl.body {
                        declared(&block.items, &mut found);
                    }
                }
                Seen::Item(Item::Prefab(decl)) => {
                    found.extend(decl.params.iter().map(|formal| (&*formal.name.text, Visible::Value("a parameter"))));
                    decl.body.iter().for_each(|body| declared(&body.items, &mut found));
                }
                Seen::Item(Item::For(stmt)) => {
                    if let Some(body) = stmt.body.as_ref().filter(|body| holds(body.span)) {
                        declared(&body.items, &mut found);
                    }
                }
                Seen::Item(Item::If(stmt)) => {
                    let blocks = stmt.arms.iter().filter_map(|(_, block)| block.as_ref()).chain(&stmt.otherwise);
                    blocks.filter(|block| holds(block.span)).for_each(|block| declared(&block.items, &mut found));
                }
                Seen::Node(node) => match &node.body {
                    Some(body) if holds(body.span) => declared(&body.items, &mut found),
                    _ => {}
                },
                Seen::Head(head) => {
                    found.extend(head.names.iter().map(|name| (&*name.text, Visible::Value("of a loop"))));
                }
                _ => {}
            }
            true
        });
        // What is being declared is not there yet.
        let unfinished: Vec<&str> = self
            .items
            .iter()
            .filter_map(|item| match item {
                Item::Let(decl) if holds(decl.value.span) => decl.name.as_ref(),
                Item::Param(decl) if holds(decl.value.span) => decl.name.as_ref(),
                Item::Node(node) if node.like.as_ref().is_some_and(|like| holds(like.span)) => node.name.as_ref(),
                _ => None,
            })
            .map(|name| &*name.text)
            .collect();
        found.retain(|(name, _)| *name != HERE && !unfinished.contains(name));
        found.iter_mut().for_each(|(name, what)| *what = self.followed(name, *what));
        found
    }

    /// What an imported file has for others.
    fn offered_names(&mut self, token: Part<'a>) {
        let Owner::Import(names) = owner(token) else { return };
        let Some(import) = names.parent() else { return };
        let start = import.span().start;
        let modules = &self.analysis.modules;
        let Some(own) = modules.list.first() else { return };
        let Some((decl, Some(to))) = own.imports().find(|(decl, _)| decl.span.start == start) else { return };
        let Some(module) = modules.list.get(to) else { return };
        let taken: Vec<&str> = decl.names.iter().flatten().map(|rename| &*rename.name.text).collect();
        let mut found = Vec::new();
        declared(&module.file.items, &mut found);
        for (name, what) in found {
            let own = !matches!(what, Visible::Imported | Visible::Module);
            if own && !name.starts_with('_') && !taken.contains(&name) {
                let (kind, detail) = what.shown();
                self.add(name, kind, detail, 1);
            }
        }
    }

    fn types(&mut self) {
        for row in TYPES {
            let entry = self.add(row.name, CompletionKind::Type, "a type", 1);
            entry.about = format!("text {}", row.doc);
        }
    }

    fn easings(&mut self) {
        for name in ease::names() {
            self.add(&name, CompletionKind::Word, "an easing", 1);
        }
        for (name, snippet) in [
            ("cubic_bezier", "cubic_bezier(${1:0.4}, ${2:0}, ${3:0.2}, ${4:1})"),
            ("steps", "steps(${1:4})"),
            ("spring", "spring($0)"),
        ] {
            self.add(name, CompletionKind::Function, "an easing", 2).snippet = snippet.into();
        }
        for (name, what) in self.visible() {
            if let Visible::Fn(_) = what {
                self.add(name, CompletionKind::Function, "a function of your own", 1);
            }
        }
    }

    fn argument_names(&mut self, args: Part<'a>, with_colon: bool) {
        let Some(name) = called(args) else { return };
        let end = |name: &str| if with_colon { format!("{name}: ") } else { name.to_string() };
        let given: Vec<&str> = args
            .nodes()
            .filter(|part| part.kind() == K::NamedArg && !(part.span().start <= self.at && self.at < part.span().end))
            .filter_map(|part| part.first_token().map(Part::text))
            .collect();
        let mut names: Vec<(String, String)> = Vec::new();
        if name == "keys" {
            names = keys::options().map(|(name, words)| (name.to_string(), any_of(words).replace('`', ""))).into();
        } else if let Some(Visible::Fn(decl)) = self.named(name) {
            names.extend(decl.params.iter().map(|formal| (formal.name.text.to_string(), String::new())));
        } else if let Some(function) = builtin::find(name) {
            names.extend(function.params.iter().map(|param| (param.name.to_string(), param.takes.to_string())));
        }
        for (name, detail) in names.iter().filter(|(name, _)| !given.contains(&name.as_str())) {
            let text = end(name);
            let entry = self.add(name, CompletionKind::Param, detail.clone(), 0);
            (entry.snippet, entry.plain) = (escape(&text), text);
        }
    }

    /// What may be a value here.
    fn values(&mut self, token: Part<'a>) {
        if let Some((base, _)) = token.text().rsplit_once('.') {
            return match slot(token) {
                Slot::Property { row: Some(Property { ty: Type::Node(sort), .. }), .. } => {
                    self.members(base, |what| fits_sort(what, Some(*sort)) || matches!(what, Visible::Value(_)));
                }
                Slot::Like(kind) => {
                    let sort = kind.and_then(|kind| schema::kind(kind.text())).map(|kind| kind.sort);
                    self.members(base, |what| fits_sort(what, sort));
                }
                _ => self.members(base, |what| !matches!(what, Visible::Prefab(_))),
            };
        }
        match slot(token) {
            Slot::Ease => self.easings(),
            Slot::Type => self.types(),
            Slot::Like(kind) => {
                let sort = kind.and_then(|kind| schema::kind(kind.text())).map(|kind| kind.sort);
                self.names(|what| fits_sort(what, sort) || matches!(what, Visible::Module), 1);
            }
            Slot::Property { row: Some(row), inside, .. } => self.values_of(row, inside),
            Slot::KeyTime => {
                self.keywords(&["ease", "after"]);
                self.found.iter_mut().for_each(|found| found.rank = 0);
                self.expressions(None);
            }
            Slot::Property { .. } | Slot::Any => self.expressions(None),
            Slot::Argument { args, index, name } => self.argument(args, index, name),
        }
    }

    fn argument(&mut self, args: Part<'a>, index: usize, name: Option<&str>) {
        let function = called(args);
        let words: Vec<&str> = match (function, name) {
            (Some("keys"), Some(name)) => {
                let option = keys::options().into_iter().find(|(option, _)| *option == name);
                option.map_or_else(Vec::new, |(_, words)| words)
            }
            (Some(function), name) => {
                let row = builtin::find(function);
                let param = row.and_then(|row| match name {
                    Some(name) => row.params.iter().find(|param| param.name == name),
                    None if row.rest.is_some() => None,
                    None => row.params.get(index),
                });
                param.map_or(&[][..], |param| param.words).iter().map(|word| word.name).collect()
            }
            _ => Vec::new(),
        };
        let only_words = !words.is_empty();
        for word in words {
            self.add(word, CompletionKind::Word, "", 0);
        }
        if name.is_none() {
            self.argument_names(args, true);
        }
        if function == Some("mix") {
            self.names(|what| fits_sort(what, Some(Sort::Material)), 1);
        }
        if function != Some("keys") && !only_words {
            self.expressions(None);
        }
    }

    fn values_of(&mut self, row: &'static Property, inside: bool) {
        match row.ty {
            Type::Choice(words) => {
                for word in words.iter().filter(|word| word.since == Since::Now) {
                    let default = row.default == Default::Word(word.name);
                    self.add(word.name, CompletionKind::Word, if default { "if nothing is said" } else { "" }, 0);
                }
                return;
            }
            Type::Bool => {
                for word in ["true", "false"] {
                    self.add(word, CompletionKind::Word, "", 0);
                }
            }
            Type::Node(Sort::Material) => {
                for kind in KINDS.iter().filter(|kind| kind.sort == Sort::Material && kind.since == Since::Now) {
                    let first = kind.all().find(|row| matches!(row.name, "color" | "spectrum" | "ior"));
                    let inside = first.map_or("$0".to_string(), |row| format!("{}: {}", row.name, placeholder(row)));
                    let entry = self.add(kind.name, CompletionKind::Kind, "a material", 1);
                    entry.snippet = format!("{} {{ {inside} }}", kind.name);
                    entry.about = format!("kind {}", kind.name);
                }
                self.function("mix", 2);
                self.names(|what| fits_sort(what, Some(Sort::Material)), 0);
                self.names(|what| matches!(what, Visible::Module | Visible::Value(_) | Visible::Imported), 3);
                return;
            }
            Type::Node(sort) => {
                self.names(|what| fits_sort(what, Some(sort)), 0);
                self.names(|what| matches!(what, Visible::Module), 3);
                return;
            }
            Type::Placed => {
                self.other_nodes();
                self.function("node", 1);
                return;
            }
            Type::Target => self.other_nodes(),
            Type::Color if !inside => {
                let entry = self.add("#", CompletionKind::Value, "a colour, red green blue", 0);
                (entry.snippet, entry.plain) = ("#${1:808080}".into(), "#808080".into());
            }
            Type::Text => {
                let entry = self.add("\"\"", CompletionKind::Value, "text", 0);
                entry.snippet = "\"$0\"".into();
            }
            _ => {}
        }
        if row.animatable && !inside {
            self.keywords(&["keys"]);
        }
        self.expressions(Some(row));
    }

    /// Names, functions and what is always there, for an expression.
    fn expressions(&mut self, row: Option<&'static Property>) {
        self.names(|what| matches!(what, Visible::Value(_) | Visible::Imported | Visible::Module | Visible::Fn(_)), 2);
        if row.is_none() {
            self.names(|what| matches!(what, Visible::Node(_)), 3);
        }
        for (name, detail) in [("time", "seconds since the start"), ("frame", "time times fps")] {
            if row.is_none_or(|row| row.animatable) {
                self.add(name, CompletionKind::Value, detail, 3);
            }
        }
        if row.is_none_or(|row| row.varies) {
            for name in POINT_NAMES {
                let entry = self.add(name, CompletionKind::Value, "of the point of a surface", 3);
                entry.about = format!("word {name}");
            }
        }
        let wanted = row.map(|row| gives(row.ty));
        for function in BUILTINS {
            let fits = wanted.is_some_and(|wanted| wanted.contains(&function.gives));
            self.function(function.name, if fits { 3 } else { 5 });
        }
        let entry = self.add("if", CompletionKind::Keyword, "", 4);
        entry.snippet = "if ${1:condition} { $2 } else { $3 }".into();
        entry.about = "keyword if".into();
    }

    fn function(&mut self, name: &str, rank: u8) {
        let Some(function) = builtin::find(name) else { return };
        let snippet = call_snippet(function);
        let entry =
            self.add(name, CompletionKind::Function, format!("{} → {}", function.signature(), function.gives), rank);
        (entry.snippet, entry.plain) = (snippet, name.to_string());
        entry.about = format!("function {name}");
    }

    fn names(&mut self, wanted: impl Fn(&Visible<'a>) -> bool, rank: u8) {
        for (name, what) in self.visible() {
            if wanted(&what) {
                self.name(name, what, rank);
            }
        }
    }

    /// Nodes but for those that the cursor is in.
    fn other_nodes(&mut self) {
        let mut around: Vec<&str> = Vec::new();
        walk(self.items, &mut |seen| match seen {
            Seen::Node(node) if node.span.start <= self.at && self.at <= node.span.end => {
                around.extend(node.name.as_ref().map(|name| &*name.text));
                true
            }
            Seen::Node(_) => false,
            _ => true,
        });
        for (name, what) in self.visible() {
            if matches!(what, Visible::Node(_)) && !around.contains(&name) {
                self.name(name, what, 0);
            }
        }
    }

    fn name(&mut self, name: &str, what: Visible<'a>, rank: u8) {
        match what {
            Visible::Fn(decl) => {
                let values: Vec<String> = decl
                    .params
                    .iter()
                    .filter(|formal| formal.default.is_none())
                    .enumerate()
                    .map(|(i, formal)| format!("${{{}:{}}}", i + 1, escape(&formal.name.text)))
                    .collect();
                let about = decl.docs.as_deref().map_or(String::new(), |docs| format!("text {docs}"));
                let entry = self.add(name, CompletionKind::Function, "a function", rank);
                entry.snippet = format!("{}({})", escape(name), values.join(", "));
                entry.about = about;
            }
            Visible::Prefab(decl) => self.call_of_prefab(name, decl, rank),
            what => {
                let (kind, detail) = what.shown();
                self.add(name, kind, detail, rank);
            }
        }
    }

    /// What stands behind a `.`.
    fn members(&mut self, base: &str, wanted: impl Fn(&Visible<'a>) -> bool) {
        if let Some(items) = self.module(base) {
            let mut found = Vec::new();
            declared(items, &mut found);
            for (name, what) in found {
                let own = !matches!(what, Visible::Imported | Visible::Module);
                if own && wanted(&what) && !name.starts_with('_') {
                    self.name(name, what, 0);
                }
            }
            return;
        }
        let node = self.visible().into_iter().find_map(|(name, what)| match what {
            Visible::Node(Some(kind)) if name == base => Some(kind),
            _ => None,
        });
        if let Some(kind) = node {
            return self.properties(kind, &[], true);
        }
        for (name, detail) in [
            ("x", "of a vector"),
            ("y", "of a vector"),
            ("z", "of a vector"),
            ("r", "of a colour"),
            ("g", "of a colour"),
            ("b", "of a colour"),
        ] {
            self.add(name, CompletionKind::Property, detail, 0);
        }
    }

    /// Behind a number.
    fn units(&mut self, token: Part<'a>) {
        let wanted: Option<Dimension> = match slot(token) {
            Slot::Property { row: Some(row), .. } => match row.ty {
                Type::Number(of, _) | Type::Vec2(of, _) | Type::Vec3(of, _) => Some(of),
                Type::Target => Some(Dimension::LENGTH),
                _ => None,
            },
            Slot::KeyTime => Some(Dimension::TIME),
            _ => None,
        };
        // The number stays.
        self.replace.start = match token.kind() {
            K::Digits if !token.text().ends_with(|last: char| last.is_ascii_digit()) => return,
            K::Digits if token.span().end != self.offset => return,
            K::Digits => token.span().end,
            _ => token.span().start,
        };
        for (name, factor, of) in UNITS {
            let rank = match wanted {
                Some(wanted) if wanted == *of => 0,
                Some(wanted) if !wanted.is_none() && UNITS.iter().any(|row| row.2 == wanted) => continue,
                _ => 2,
            };
            let detail = match *name {
                "f" => "a frame".to_string(),
                _ => crate::dimension::show(*factor, *of),
            };
            self.add(name, CompletionKind::Unit, detail, rank);
        }
        if wanted.is_none_or(Dimension::is_none) {
            self.add("%", CompletionKind::Unit, "a hundredth", 1);
        }
    }

    /// Files, where a text names one.
    fn paths(&mut self, token: Part<'a>) {
        let import = token.parent().is_some_and(|parent| parent.kind() == K::ImportDecl);
        let file = match slot(token) {
            Slot::Property { name, .. } => matches!(name, "file" | "bake"),
            Slot::Argument { args, .. } => matches!(called(args), Some("image" | "normal_map")),
            _ => false,
        };
        if !import && !file {
            return;
        }
        let start = token.span().start + 1;
        let at = self.offset;
        let source = &self.analysis.tree.source;
        let typed = source.slice(Span::new(start.min(at), at));
        let (folder, part) = typed.rsplit_once('/').unwrap_or(("", typed));
        // The part of the path that the cursor is in, up to the next one.
        let rest = source.slice(Span::new(at, source.len()));
        let rest = rest.split(['/', '"', '\n', '\r']).next().filter(|_| token.kind() == K::String);
        self.replace = Span::new(at - part.len() as u32, at + rest.map_or(0, str::len) as u32);
        let goes_on = source.slice(Span::new(self.replace.end, source.len())).starts_with('/');
        if import {
            for (path, _) in library::FILES {
                match path.strip_prefix("std/") {
                    Some(name) if folder == "std" => {
                        self.add(name, CompletionKind::Module, "part of this program", 0);
                    }
                    Some(_) if folder.is_empty() => {
                        self.add(path, CompletionKind::Module, "part of this program", 2);
                    }
                    _ => {}
                }
            }
        }
        let inside = match (folder.is_empty(), typed.starts_with('/')) {
            (true, true) => "/x".to_string(),
            (true, false) => "x".to_string(),
            (false, _) => format!("{folder}/x"),
        };
        let Ok(path) = resolve(&source.name, &inside) else { return };
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        for name in self.files.names_in(folder) {
            let ending = name.rsplit_once('.').map(|(stem, ending)| (stem.is_empty(), ending));
            match ending {
                _ if name.starts_with('.') || path_of(folder, &name) == *source.name => {}
                None => {
                    let entry = self.add(&name, CompletionKind::Folder, "", 1);
                    if !goes_on {
                        (entry.snippet, entry.plain) = (format!("{}/", escape(&name)), format!("{name}/"));
                    }
                }
                Some((_, "kin")) if import => {
                    self.add(&name, CompletionKind::File, "", 0);
                }
                Some((_, ending)) if !import && ASSETS.contains(&ending.to_ascii_lowercase().as_str()) => {
                    self.add(&name, CompletionKind::File, "", 0);
                }
                _ => {}
            }
        }
    }
}

fn path_of(folder: &str, name: &str) -> String {
    if folder.is_empty() { name.to_string() } else { format!("{folder}/{name}") }
}

/// Endings of the files that scenes read.
const ASSETS: &[&str] = &["obj", "ply", "stl", "gltf", "glb", "png", "jpg", "jpeg", "webp", "exr", "hdr", "bake"];

/// What a name is, seen from a place.
#[derive(Clone, Copy)]
enum Visible<'a> {
    Value(&'static str),
    Fn(&'a ast::FnDecl),
    Prefab(&'a ast::PrefabDecl),
    Node(Option<&'static Kind>),
    Module,
    /// A name that is imported from a file.
    Imported,
}

impl Visible<'_> {
    fn shown(&self) -> (CompletionKind, String) {
        match self {
            Visible::Value(what) => (CompletionKind::Value, (*what).to_string()),
            Visible::Fn(_) => (CompletionKind::Function, "a function".into()),
            Visible::Prefab(_) => (CompletionKind::Prefab, "a prefab".into()),
            Visible::Node(kind) => {
                (CompletionKind::Node, kind.map_or("a node", |kind| kind.sort.with_article()).into())
            }
            Visible::Module => (CompletionKind::Module, "an imported file".into()),
            Visible::Imported => (CompletionKind::Value, "imported".into()),
        }
    }
}

/// What a block declares.
fn declared<'a>(items: &'a [Item], found: &mut Vec<(&'a str, Visible<'a>)>) {
    for item in items {
        let (name, what) = match item {
            Item::Let(decl) => (&decl.name, Visible::Value("a value")),
            Item::Param(decl) => (&decl.name, Visible::Value("a parameter of the scene")),
            Item::Fn(decl) => (&decl.name, Visible::Fn(decl)),
            Item::Prefab(decl) => (&decl.name, Visible::Prefab(decl)),
            Item::Node(node) => (&node.name, Visible::Node(schema::kind(&kind_text(node)))),
            Item::Import(import) => {
                let names = import.names.iter().flatten();
                found.extend(names.map(|rename| {
                    let name = rename.alias.as_ref().unwrap_or(&rename.name);
                    (&*name.text, Visible::Imported)
                }));
                (&import.alias, Visible::Module)
            }
            _ => continue,
        };
        if let Some(name) = name.as_ref().filter(|name| !name.quoted) {
            found.push((&name.text, what));
        }
    }
}

/// What a file declares by a name at its top.
fn named_in<'a>(items: &'a [Item], name: &str) -> Option<Visible<'a>> {
    let mut found = Vec::new();
    declared(items, &mut found);
    found.into_iter().find(|(own, _)| *own == name).map(|found| found.1)
}

/// Whether it is a node of this sort, of any without one.
fn fits_sort(what: &Visible<'_>, sort: Option<Sort>) -> bool {
    matches!(what, Visible::Node(Some(kind)) if sort.is_none_or(|sort| kind.sort == sort))
}

/// What is written before a part, spaces and comments aside.
fn previous(part: Part<'_>) -> Option<Part<'_>> {
    let mut before = part.previous_token();
    while let Some(token) = before.filter(|token| token.kind().is_trivia() || token.span().is_empty()) {
        before = token.previous_token();
    }
    before
}

fn fits_inside(part: &Kind, parent: &Kind) -> bool {
    match part.place {
        Place::Inside([]) => parent.sort.is_placed(),
        Place::Inside(kinds) => kinds.contains(&parent.name),
        _ => false,
    }
}

/// What functions give that a property of this type takes.
fn gives(ty: Type) -> &'static [&'static str] {
    match ty {
        Type::Color => &["color", "texture"],
        Type::Rotation => &["quat"],
        Type::NormalMap => &["normal map", "normal_map"],
        Type::Vec3(..) | Type::Target => &["vec3", "vector"],
        Type::Number(..) | Type::Count => &["number", "float", "the same", "as a", "texture"],
        Type::Points | Type::Pairs | Type::Indices => &["list"],
        _ => &[],
    }
}

fn escape(text: &str) -> String {
    text.replace('\\', "\\\\").replace('$', "\\$").replace('}', "\\}")
}

fn call_snippet(function: &Builtin) -> String {
    let needed = function.params.iter().filter(|param| !param.optional);
    let mut at = 0;
    let mut next = || {
        at += 1;
        at
    };
    let mut parts: Vec<String> = Vec::new();
    if function.rest.is_some() {
        parts.push(format!("${}", next()));
        parts.extend(needed.map(|param| format!("{}: ${}", param.name, next())));
    } else {
        // A word of the language would be no value.
        parts.extend(needed.map(|param| match KEYWORDS.contains(&param.name) {
            true => format!("${}", next()),
            false => format!("${{{}:{}}}", next(), param.name),
        }));
    }
    format!("{}({})", function.name, parts.join(", "))
}

/// Type and default in a few words.
fn detail_of(property: &Property) -> String {
    let default = property.default_text().replace(['`', '*'], "");
    let ty = property.type_text().replace('`', "");
    match property.default {
        Default::Computed => ty,
        Default::Needed => format!("{ty}, needed"),
        _ => format!("{ty} = {default}"),
    }
}

fn placeholder(property: &Property) -> String {
    placeholder_at(property, 1)
}

fn placeholder_at(property: &Property, stop: usize) -> String {
    let default = property.default_text().replace(['`', '*'], "");
    match (property.ty, property.default) {
        (Type::Choice(words), _) => {
            let words: Vec<&str> = words.iter().filter(|word| word.since == Since::Now).map(|word| word.name).collect();
            format!("${{{stop}|{}|}}", words.join(","))
        }
        (Type::Text, _) => format!("\"${stop}\""),
        (Type::Color, _) => format!("${{{stop}:#808080}}"),
        (_, Default::Computed | Default::Needed | Default::Identity) => format!("${stop}"),
        (_, Default::Number(value)) if !value.is_finite() => format!("${stop}"),
        _ => format!("${{{stop}:{}}}", escape(&default)),
    }
}

/// What is to be said about a suggestion, by its [`Completion::about`]. Markdown.
pub fn document(about: &str) -> Option<String> {
    let (what, rest) = about.split_once(' ')?;
    match what {
        "property" => {
            let (kind, property) = rest.split_once(' ')?;
            Some(super::hover::property(kind, schema::kind(kind)?.property(property)?))
        }
        "kind" => Some(super::hover::kind(schema::kind(rest)?)),
        "function" => Some(super::hover::function(builtin::find(rest)?)),
        "keyword" | "word" => super::hover::word(rest).map(str::to_string),
        "text" => Some(rest.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::Memory;
    use crate::source::FileId;

    /// A snippet as it is once somebody has gone through it.
    fn filled(snippet: &str) -> String {
        let mut text = snippet.replace("    $0\n", "").replace("{ $0 }", "{ }").replace("\\}", "}").replace("\\$", "$");
        while let Some(start) = text.find('$') {
            let behind = &text[start + 1..];
            let (end, value) = match behind.strip_prefix('{') {
                Some(inner) => {
                    let end = inner.find('}').unwrap();
                    let value = inner[..end].trim_start_matches(|digit: char| digit.is_ascii_digit());
                    let value =
                        value.strip_prefix('|').map_or(&value[1..], |words| words.split([',', '|']).next().unwrap());
                    (start + 1 + end + 2, value.to_string())
                }
                None => (
                    start + 1 + behind.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(behind.len()),
                    "x".into(),
                ),
            };
            text.replace_range(start..end, &value);
        }
        text
    }

    /// Takes each suggestion at the cursor of a text, which has no errors without it.
    fn take_all(text: &str) -> usize {
        let at = text.find('|').unwrap();
        let text = text.replacen('|', "", 1);
        let nothing = Memory::default();
        let analysis = Analysis::new("a.kin", &text, &nothing);
        let found = completions(&analysis, at as u32, &nothing);
        for one in &found {
            // The rest of these is for people to write.
            if matches!(one.label.as_str(), "ease" | "after" | "like") {
                continue;
            }
            let mut filled = filled(&one.snippet);
            if filled.ends_with(": ") {
                filled += "x";
            }
            let plain = if one.plain.ends_with(": ") { format!("{}x", one.plain) } else { one.plain.clone() };
            for new in [
                Some(filled),
                Some(plain).filter(|_| {
                    !matches!(
                        one.kind,
                        CompletionKind::Keyword
                            | CompletionKind::Kind
                            | CompletionKind::Prefab
                            | CompletionKind::Property
                    )
                }),
            ]
            .into_iter()
            .flatten()
            {
                let mut result = text.clone();
                result.replace_range(one.replace.start as usize..one.replace.end as usize, &new);
                let tree = parse(&Source::new(FileId(0), "a.kin", result.as_str()));
                let wrong: Vec<&str> = tree.errors().iter().map(|found| found.message.as_str()).collect();
                assert!(wrong.is_empty(), "{result}\n{wrong:?}");
            }
        }
        found.len()
    }

    #[test]
    fn what_is_taken_can_be_read() {
        let declared = "lang 1\nprefab tower(height: length, n = 3) { box { } }\nfn twice(x, times = 2) = x * times\nmetal gold { }\n";
        let mut count = take_all(&format!("{declared}|")) + take_all(&format!("{declared}tower {{ | }}"));
        for text in [
            "let a = |",
            "let a = (|)",
            "let a = twice(|)",
            "let a = mix(|)",
            "fn f(x) {{ |\n return x }}",
            "param a: | = 1",
            "group g {{ | }}",
            "for i in 0..3 {{ | }}",
            "let a = keys {{ 0s: 1 1s: 2 ease | }}",
            "let a = keys(|) {{ 0s: 1 1s: 2 }}",
            "let a = keys {{ 0s: | }}",
        ] {
            count += take_all(&format!("{declared}{}", text.replace("{{", "{").replace("}}", "}")));
        }
        for kind in KINDS.iter().filter(|kind| kind.since == Since::Now) {
            let around = match kind.place {
                Place::Inside(kinds) => Some(kinds.first().copied().unwrap_or("sphere")),
                _ => None,
            };
            let inside = |body: &str| match around {
                Some(outer) => format!("{declared}{outer} {{ {} {{ {body} }} }}", kind.name),
                None => format!("{declared}{} {{ {body} }}", kind.name),
            };
            count += take_all(&inside("|"));
            for property in kind.all().filter(|row| row.since != Since::Later) {
                count += take_all(&inside(&format!("{}: |", property.name)));
            }
        }
        assert!(count > 5_000, "{count}");
    }
}
