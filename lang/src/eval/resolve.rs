//! Names, before anything is computed: what each one means, what is unknown, twice, unused or in the wrong place.
//!
//! It sees every branch and every function, called or not; the evaluator relies on it and says nothing about names.

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::builtin;
use crate::diagnostic::{Applicability, Diagnostic, Edit, Kept};
use crate::dimension;
use crate::eval::coerce::{nearest_word, wrong_word};
use crate::eval::expr::short_text;
use crate::eval::items::{kind_text, set_twice};
use crate::eval::surface::is_point;
use crate::library;
use crate::modules::Modules;
use crate::schema::{self, Choice, Holds, Kind, Place, Sort, Type};
use crate::source::{FileId, Span, Texts};
use crate::suggest::{all_of, nearest_kind, suggest, trust, trust_value, value_for};
use crate::syntax::ast::{self, Expr, ExprKind, Item, Name};

/// What is wrong with the names of a scene and of the files that it imports.
pub fn resolve(modules: &Modules) -> Vec<Diagnostic> {
    walk(modules, false).0
}

/// Which name means which declaration, in a scene and in the files that it imports.
pub fn uses(modules: &Modules) -> Uses {
    walk(modules, true).1
}

/// Names and what they mean. All places lie in [`Modules::texts`].
#[derive(Debug, Clone, Default)]
pub struct Uses {
    /// The names where something is declared.
    pub declared: Vec<(Span, Symbol)>,
    /// Names and the name of what they mean. One that an import brings leads to the import, and that to the other file.
    pub uses: Vec<Use>,
}

/// A name that means something which is declared elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Use {
    /// The name.
    pub at: Span,
    /// The name where it is declared; of an imported file, its start.
    pub to: Span,
    /// Whether it is the same word there: an import may give it another one.
    pub same_word: bool,
}

/// What a name is declared as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Symbol {
    /// `let`
    Let,
    /// `param`
    Param,
    /// A parameter of a function or prefab.
    Formal,
    /// What a loop counts with.
    Loop,
    /// `fn`
    Fn,
    /// `prefab`
    Prefab,
    /// A node of this kind; `None` where it is a prefab's or unknown.
    Node(Option<&'static Kind>),
    /// A file under a name of its own.
    Module,
    /// Of an import that leads nowhere.
    Unknown,
}

fn walk(modules: &Modules, keep_uses: bool) -> (Vec<Diagnostic>, Uses) {
    let mut all_uses = keep_uses.then(Uses::default);
    let offers: Vec<Offers<'_>> = modules.list.iter().map(|module| offers(&module.file.items)).collect();
    let mut all = Vec::new();
    for (at, module) in modules.list.iter().enumerate() {
        let mut resolver = Resolver {
            source: &modules.texts,
            modules,
            offers: &offers,
            imports: module.imports().map(|(import, to)| (import.span.start, to)).collect(),
            hoisting: false,
            library: at > 0 || is_library(&module.file.items),
            scopes: Vec::new(),
            found: Vec::new(),
            unknown: BTreeMap::new(),
            siblings: FxHashSet::default(),
            lets: Vec::new(),
            inside: Vec::new(),
            early: Vec::new(),
            guessed: 0,
            renamed: 0,
            hidden: FxHashSet::default(),
            around: Vec::new(),
            ended: FxHashMap::default(),
            kept: Kept::default(),
            uses: all_uses.take(),
        };
        resolver.head(&module.file);
        resolver.block(&module.file.items, Where::Top, false);
        all_uses = resolver.uses.take();
        all.append(&mut resolver.finish());
    }
    (all, all_uses.unwrap_or_default())
}

/// Whether a file only declares what others use: it shows nothing, and that is no mistake.
pub fn is_library(items: &[Item]) -> bool {
    let material = |node: &ast::Node| {
        node.name.is_some() && schema::kind(&kind_text(node)).is_some_and(|kind| kind.sort == Sort::Material)
    };
    let declares = |item: &Item| match item {
        Item::Fn(_) | Item::Prefab(_) => true,
        Item::Node(node) => material(node),
        _ => false,
    };
    let only =
        |item: &Item| declares(item) || matches!(item, Item::Let(_) | Item::Param(_) | Item::Import(_) | Item::Lang(_));
    items.iter().all(only) && items.iter().any(declares)
}

/// What a file declares at its top level.
type Offers<'a> = BTreeMap<&'a str, (Declared<'a>, Span)>;

fn offers(items: &[Item]) -> Offers<'_> {
    let mut offers = Offers::new();
    let prefabs: FxHashSet<&str> = items
        .iter()
        .filter_map(|item| match item {
            Item::Prefab(decl) => decl.name.as_ref().map(|name| &*name.text),
            _ => None,
        })
        .collect();
    for item in items {
        let (name, what) = match item {
            Item::Let(decl) => (&decl.name, Declared::Value),
            Item::Param(decl) => (&decl.name, Declared::Param),
            Item::Fn(decl) => (&decl.name, Declared::Fn(decl)),
            Item::Prefab(decl) => (&decl.name, Declared::Prefab(decl)),
            Item::Node(node) => {
                let kind = kind_text(node);
                let kind = if prefabs.contains(&*kind) { None } else { schema::kind(&kind) };
                (&node.name, Declared::Node(kind))
            }
            _ => continue,
        };
        if let Some(name) = name {
            offers.entry(&*name.text).or_insert((what, name.span));
        }
    }
    offers
}

/// What a name is declared as.
#[derive(Clone, Copy)]
enum Declared<'a> {
    Let(usize),
    Param,
    Formal,
    Loop,
    Fn(&'a ast::FnDecl),
    Prefab(&'a ast::PrefabDecl),
    Node(Option<&'static Kind>),
    /// A `let` of another file.
    Value,
    /// An imported file under a name of its own.
    Module(usize),
    /// An import that leads nowhere, which is reported.
    Import,
}

impl Declared<'_> {
    fn symbol(&self) -> Symbol {
        match self {
            Declared::Let(_) | Declared::Value => Symbol::Let,
            Declared::Param => Symbol::Param,
            Declared::Formal => Symbol::Formal,
            Declared::Loop => Symbol::Loop,
            Declared::Fn(_) => Symbol::Fn,
            Declared::Prefab(_) => Symbol::Prefab,
            Declared::Node(kind) => Symbol::Node(*kind),
            Declared::Module(_) => Symbol::Module,
            Declared::Import => Symbol::Unknown,
        }
    }

    fn is_variable(&self) -> bool {
        matches!(self, Declared::Let(_) | Declared::Param | Declared::Formal | Declared::Loop | Declared::Value)
    }
}

struct Decl<'a> {
    what: Declared<'a>,
    span: Span,
    used: bool,
    /// Of an import: what to take out so that it is gone.
    import: Option<Span>,
}

#[derive(Default)]
struct Names<'a> {
    names: FxHashMap<&'a str, Decl<'a>>,
    order: Vec<&'a str>,
    /// The body of a function or prefab: it runs later than where it is written.
    deferred: bool,
}

/// Where items stand.
#[derive(Clone, Copy)]
enum Where {
    /// At the top level.
    Top,
    /// In a prefab or a loop.
    Scene,
    /// In a node.
    Node(&'static Kind),
    /// In a function.
    Function,
    /// In something that could not be read.
    Nowhere,
}

struct Resolver<'a> {
    source: &'a Texts,
    modules: &'a Modules,
    offers: &'a [Offers<'a>],
    /// The module that each import of the file leads to, by where the import starts.
    imports: FxHashMap<u32, Option<usize>>,
    /// What the file declares is for other files.
    library: bool,
    /// Names of an import are being declared.
    hoisting: bool,
    scopes: Vec<Names<'a>>,
    found: Vec<Diagnostic>,
    /// Unknown names: the first report and where else they are used.
    unknown: BTreeMap<(String, String), (usize, Vec<Span>)>,
    /// The properties set in the block at hand: they are not suggested.
    siblings: FxHashSet<&'a str>,
    /// Which lets each let asks for.
    lets: Vec<Vec<usize>>,
    inside: Vec<usize>,
    /// Uses above the `let`, which are fine where the let is in a cycle: that is reported instead.
    early: Vec<(usize, Diagnostic)>,
    /// How many names were compared with unknown ones.
    guessed: usize,
    /// How many names have been looked for in the whole text.
    renamed: usize,
    /// Names of built-in kinds and functions that the file declares anew, which is reported.
    hidden: FxHashSet<&'a str>,
    /// The kinds of the nodes that are around what is looked at.
    around: Vec<Span>,
    /// Where names are declared in blocks that are over.
    ended: FxHashMap<&'a str, Span>,
    kept: Kept,
    /// What means what, if somebody asks.
    uses: Option<Uses>,
}

/// Most names of the scene that are compared with unknown ones: behind so many mistakes nobody looks for help.
const GUESSES: usize = 500_000;

/// So many names are looked for in the whole text, so that a fix changes all of them.
const RENAMED: usize = 16;

/// What an unknown name was expected to be.
#[derive(Clone, Copy)]
struct Wanted {
    what: &'static str,
    sort: Option<Sort>,
    words: &'static [Choice],
    /// Whether it is a text, where a bare name has most likely lost its quotes.
    text: bool,
    /// Whether it may be a colour.
    colour: bool,
    property: &'static str,
}

const VALUE: Wanted = Wanted { what: "value", sort: None, words: &[], text: false, colour: true, property: "" };

impl Wanted {
    fn by(property: &'static schema::Property) -> Wanted {
        match property.ty {
            Type::Node(sort) => {
                let what = match sort {
                    Sort::Camera => "camera",
                    Sort::Material => "material",
                    _ => "node",
                };
                Wanted { what, sort: Some(sort), property: property.name, ..VALUE }
            }
            Type::Placed => Wanted { what: "node", property: property.name, ..VALUE },
            Type::Choice(words) => Wanted { words, property: property.name, ..VALUE },
            Type::Text => Wanted { text: true, property: property.name, ..VALUE },
            Type::Color => Wanted { property: property.name, ..VALUE },
            _ => Wanted { colour: false, ..VALUE },
        }
    }
}

/// The kinds of materials.
fn materials() -> impl Iterator<Item = &'static str> {
    schema::KINDS.iter().filter(|kind| kind.sort == Sort::Material).map(|kind| kind.name)
}

impl<'a> Resolver<'a> {
    fn file(&self) -> FileId {
        self.source.id
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if self.kept.takes(&diagnostic) {
            self.found.push(diagnostic);
        }
    }

    fn finish(mut self) -> Vec<Diagnostic> {
        let file = self.file();
        for (index, more) in std::mem::take(&mut self.unknown).into_values() {
            let Some(found) = self.found.get_mut(index).filter(|_| !more.is_empty()) else { continue };
            let count = more.len();
            found.notes.push(format!("and {count} more use{}", if count == 1 { "" } else { "s" }));
            for fix in &mut found.fixes {
                let Some(insert) = fix.edits.first().map(|edit| edit.insert.clone()) else { continue };
                fix.edits.extend(more.iter().map(|span| Edit { file, span: *span, insert: insert.clone() }));
            }
        }
        let early = std::mem::take(&mut self.early);
        if !early.is_empty() {
            let endless = self.endless();
            let ends = |(target, _): &(usize, Diagnostic)| endless.get(*target) != Some(&true);
            let fine = early.into_iter().filter(ends).map(|(_, diagnostic)| diagnostic);
            for diagnostic in fine {
                self.report(diagnostic);
            }
        }
        self.found
    }

    /// Of each let, whether what it asks for leads into a circle: of what is left when all that asks for nothing more is
    /// taken away, again and again.
    fn endless(&self) -> Vec<bool> {
        let mut asked_by = vec![Vec::new(); self.lets.len()];
        let mut open: Vec<usize> = self.lets.iter().map(Vec::len).collect();
        for (asks, targets) in self.lets.iter().enumerate() {
            for target in targets {
                asked_by[*target].push(asks);
            }
        }
        let mut done: Vec<usize> = (0..open.len()).filter(|id| open[*id] == 0).collect();
        while let Some(id) = done.pop() {
            for &asks in &asked_by[id] {
                open[asks] -= 1;
                if open[asks] == 0 {
                    done.push(asks);
                }
            }
        }
        open.into_iter().map(|open| open > 0).collect()
    }

    /// The `lang` line and the imports.
    fn head(&mut self, file: &'a ast::File) {
        let file_id = self.file();
        let start = file.span.start;
        let lang = file.items.iter().find_map(|item| match item {
            Item::Lang(lang) => Some(lang),
            _ => None,
        });
        match lang {
            None => self.report(
                Diagnostic::new("W0710", "no `lang` line, assuming version 1")
                    .primary(file_id, Span::at(start), "the first line says the version")
                    .fix(Applicability::Safe, "add `lang 1`", file_id, Span::at(start), "lang 1\n\n"),
            ),
            Some(lang) => {
                if let ExprKind::Number(number) = &lang.version.kind
                    && number.value != 1.0
                {
                    let version = self.source.slice(lang.version.span);
                    let message = if number.value > 1.0 {
                        format!("this file needs version {version}, this program knows up to 1")
                    } else {
                        format!("there is no version {version}")
                    };
                    let diagnostic = Diagnostic::new("E0709", message)
                        .primary(file_id, lang.version.span, "not known")
                        .help(if number.value > 1.0 { "upgrade this program" } else { "write `lang 1`" });
                    self.report(diagnostic);
                }
            }
        }
        let mut late = false;
        let mut head = None;
        let mut version: Option<Span> = None;
        for (at, item) in file.items.iter().enumerate() {
            match item {
                Item::Lang(lang) if at > 0 => {
                    let found = Diagnostic::new("E0707", "`lang` must come first");
                    let found = found.primary(file_id, lang.span, "below other items");
                    let text = self.source.slice(lang.span);
                    let remove = (lang.span, String::new());
                    let (message, edits) = match version {
                        None => ("move it into the first line", vec![(Span::at(start), format!("{text}\n\n")), remove]),
                        Some(_) => ("remove it: the file says its version already", vec![remove]),
                    };
                    // Of two versions nobody knows which is meant.
                    let clear = version.is_none_or(|span| self.source.slice(span) == text);
                    let edits = edits.into_iter().map(|(span, insert)| Edit { file: file_id, span, insert });
                    self.report(match matches!(lang.version.kind, ExprKind::Number(_)) && clear {
                        true => found.fix_edits(Applicability::Safe, message, edits.collect()),
                        false => found,
                    });
                    version = version.or(Some(lang.span));
                }
                Item::Import(import) if late => {
                    let text = self.source.slice(import.span);
                    let (place, text) = match head {
                        Some(end) => (Span::at(end), format!("\n{text}")),
                        None => (Span::at(start), format!("{text}\n")),
                    };
                    let edits = [(place, text), (import.span, String::new())];
                    let edits = edits.map(|(span, insert)| Edit { file: file_id, span, insert });
                    self.report(
                        Diagnostic::new("E0707", "imports must come first")
                            .primary(file_id, import.span, "after other items")
                            .fix_edits(Applicability::Safe, "move it up, below `lang`", edits.into()),
                    );
                }
                Item::Lang(lang) => {
                    version = Some(lang.span);
                    head = Some(lang.span.end);
                }
                Item::Import(import) => head = Some(import.span.end),
                _ => late = true,
            }
        }
    }

    fn block(&mut self, items: &'a [Item], place: Where, deferred: bool) {
        self.scopes.push(Names { deferred, ..Names::default() });
        self.hoist(items);
        self.items(items, place);
        self.leave();
    }

    /// Ends a scope: what was never used in it?
    fn leave(&mut self) {
        let Some(scope) = self.scopes.pop() else { return };
        // What is at the top is seen from everywhere.
        for name in scope.order.iter().filter(|_| !self.scopes.is_empty()) {
            if let Some(decl) = scope.names.get(name) {
                self.ended.entry(name).or_insert(decl.span);
            }
        }
        let offered = self.library && self.scopes.is_empty();
        for name in &scope.order {
            let Some(decl) = scope.names.get(name) else { continue };
            let counts = match decl.what {
                // One that leads nowhere is reported already.
                Declared::Import => false,
                _ if decl.import.is_some() => true,
                _ if offered => false,
                Declared::Let(_) | Declared::Param | Declared::Prefab(_) => true,
                Declared::Node(kind) => kind.is_some_and(|kind| kind.sort == Sort::Material),
                _ => false,
            };
            if counts && !decl.used && !name.starts_with('_') {
                let file = self.file();
                if let Some(span) = decl.import {
                    let diagnostic = Diagnostic::new("W0201", format!("`{name}` is never used"))
                        .primary(file, decl.span, "imported, but never used")
                        .fix(Applicability::Safe, "remove it", file, span, "");
                    self.report(diagnostic);
                    continue;
                }
                let fix = format!("remove it, or name it `_{name}`");
                let diagnostic = Diagnostic::new("W0201", format!("`{name}` is never used"))
                    .primary(file, decl.span, "never used")
                    .fix(Applicability::Safe, fix, file, decl.span, format!("_{name}"));
                self.report(diagnostic);
            }
        }
    }

    fn declare(&mut self, name: &'a Name, what: Declared<'a>) {
        let text = &*name.text;
        let file = self.file();
        let built_in = match what {
            Declared::Fn(_) => builtin::find(text).is_some(),
            Declared::Prefab(_) => schema::kind(text).is_some(),
            Declared::Import => false,
            _ => matches!(text, "time" | "frame") && !name.quoted,
        };
        if built_in {
            self.hidden.insert(text);
            let diagnostic = Diagnostic::new("E0217", format!("`{text}` is built in and cannot be redeclared"))
                .primary(file, name.span, "already means something")
                .help("pick another name");
            return self.report(diagnostic);
        }
        if what.is_variable() {
            if let Some(unit) = dimension::UNITS.iter().find(|unit| unit.0 == text) {
                let quotient = dimension::Dimension::LENGTH.per(unit.2).unwrap_or_default();
                let message =
                    format!("`{text}` is also a unit; `3m/{text}` will be read as {}", quotient.with_article());
                let diagnostic = Diagnostic::new("W0306", message)
                    .primary(file, name.span, "a unit, too")
                    .help(format!("rename it, or write `3m / {text}`"));
                self.report(diagnostic);
            }
            let outer = self.scopes.iter().rev().skip(1).find_map(|scope| scope.names.get(text));
            if let Some(outer) = outer.filter(|outer| outer.what.is_variable()) {
                let diagnostic = Diagnostic::new("W0202", format!("`{text}` hides an earlier `{text}`"))
                    .primary(file, name.span, "hides the other one")
                    .label(file, outer.span, "the other one");
                self.report(diagnostic);
            }
        }
        let Some(scope) = self.scopes.last_mut() else { return };
        if let Some(first) = scope.names.get(text) {
            let diagnostic = Diagnostic::new("E0205", format!("`{text}` is declared twice"))
                .primary(file, name.span, "declared again")
                .label(file, first.span, "declared here")
                .help("rename one");
            self.report(diagnostic);
            return;
        }
        scope.order.push(text);
        scope.names.insert(text, Decl { what, span: name.span, used: false, import: None });
        if let Some(uses) = &mut self.uses {
            uses.declared.push((name.span, what.symbol()));
        }
    }

    /// Keeps what a name means.
    fn means(&mut self, at: Span, to: Span, same_word: bool) {
        if let Some(uses) = &mut self.uses {
            uses.uses.push(Use { at, to, same_word });
        }
    }

    /// Declares what an import brings.
    fn hoist_import(&mut self, import: &'a ast::ImportDecl) {
        let to = self.imports.get(&import.span.start).copied().flatten();
        let names = import.names.as_deref().unwrap_or(&[]);
        let whole = |rename: &ast::Rename| rename.name.span.to(rename.alias.as_ref().unwrap_or(&rename.name).span);
        let brings = names.len() + usize::from(import.alias.is_some());
        for (i, rename) in names.iter().enumerate() {
            self.hoisting = true;
            let what = to.map_or(Declared::Import, |to| self.offered(to, &rename.name));
            self.hoisting = false;
            // With the comma behind it, or, of the last one, before it.
            let own = whole(rename);
            let span = match (names.get(i + 1), i.checked_sub(1).and_then(|before| names.get(before))) {
                _ if brings == 1 => import.span,
                (Some(next), _) => Span::new(own.start, whole(next).start),
                (None, Some(before)) => Span::new(whole(before).end, own.end),
                (None, None) => own,
            };
            if let Some(alias) = &rename.alias {
                self.means(alias.span, rename.name.span, false);
            }
            self.declare_import(rename.alias.as_ref().unwrap_or(&rename.name), what, span);
        }
        if let Some(alias) = &import.alias {
            let span = if brings == 1 { import.span } else { alias.span };
            if let Some(module) = to.and_then(|to| self.modules.list.get(to)) {
                self.means(alias.span, Span::at(module.file.span.start), false);
            }
            self.declare_import(alias, to.map_or(Declared::Import, Declared::Module), span);
        }
    }

    fn declare_import(&mut self, name: &'a Name, what: Declared<'a>, span: Span) {
        self.declare(name, what);
        let declared = self.scopes.last_mut().and_then(|scope| scope.names.get_mut(&*name.text));
        if let Some(declared) = declared.filter(|declared| declared.span == name.span) {
            declared.import = Some(span);
        }
    }

    /// What a module declares by this name; E0216 and E0706.
    fn offered(&mut self, module: usize, name: &'a Name) -> Declared<'a> {
        let text = &*name.text;
        let modules = self.modules;
        let (Some(offers), Some(other)) = (self.offers.get(module), modules.list.get(module)) else {
            return Declared::Import;
        };
        let path = &*other.source.name;
        let file = self.file();
        match offers.get(text) {
            Some(_) if text.starts_with('_') => {
                if self.first_use(path, name) {
                    let diagnostic = Diagnostic::new("E0216", format!("`{text}` is private to {path}"))
                        .primary(file, name.span, "for that file alone")
                        .help("names that start with `_` are private: rename it there, if others may use it");
                    self.report(diagnostic);
                }
                Declared::Import
            }
            Some((what, span)) => {
                self.means(name.span, *span, true);
                *what
            }
            None => {
                if self.first_use(path, name) {
                    let diagnostic = Diagnostic::new("E0706", format!("`{path}` has no `{text}`")).primary(
                        file,
                        name.span,
                        "not declared there",
                    );
                    let public: Vec<&str> = offers.keys().copied().filter(|name| !name.starts_with('_')).collect();
                    let passes = |(import, to): (&ast::ImportDecl, Option<usize>)| {
                        let mut names = import.names.iter().flatten();
                        let here = names.find(|name| *name.alias.as_ref().unwrap_or(&name.name).text == *text)?;
                        Some((modules.list.get(to?)?, here.name.text.clone()))
                    };
                    let near = match self.guessed > GUESSES {
                        true => Vec::new(),
                        false => suggest(text, public.iter().copied()),
                    };
                    self.guessed += public.len();
                    let diagnostic = match (near.first(), other.imports().find_map(passes)) {
                        (_, Some((origin, there))) => {
                            let origin = &origin.source.name;
                            diagnostic.help(format!("it imports it itself: import `{there}` from \"{origin}\""))
                        }
                        (Some(near), _) => {
                            let help = format!("did you mean `{near}`?");
                            // Where it is imported by name, its uses have that name, too.
                            let (at, all) = (name.span.start, self.source);
                            self.renamed += usize::from(self.hoisting);
                            let rename = self.hoisting && self.renamed <= RENAMED;
                            let places = if rename { all.words(at, text) } else { vec![name.span] };
                            let taken = self.hoisting && !(rename && all.words(at, near).is_empty());
                            let sure = if taken { Applicability::Maybe } else { Applicability::Safe };
                            let edit = |span| Edit { file, span, insert: near.to_string() };
                            diagnostic.fix_edits(sure, help, places.into_iter().map(edit).collect())
                        }
                        (None, _) if public.is_empty() => diagnostic.note("it declares nothing that others may use"),
                        (None, _) => {
                            const SHOWN: usize = 12;
                            let more = if public.len() > SHOWN { " and more" } else { "" };
                            let names = public.iter().take(SHOWN).copied();
                            diagnostic.help(format!("it has {}{more}", all_of(names)))
                        }
                    };
                    self.report(diagnostic);
                }
                Declared::Import
            }
        }
    }

    fn hoist(&mut self, items: &'a [Item]) {
        // Prefabs first: a node's kind may be one that is declared further down.
        for item in items {
            match item {
                Item::Prefab(decl) => {
                    if let Some(name) = &decl.name {
                        self.declare(name, Declared::Prefab(decl));
                    }
                }
                Item::Import(import) => self.hoist_import(import),
                _ => {}
            }
        }
        for item in items {
            match item {
                Item::Let(decl) => {
                    if let Some(name) = &decl.name {
                        let id = self.lets.len();
                        self.lets.push(Vec::new());
                        self.declare(name, Declared::Let(id));
                    }
                }
                Item::Param(decl) => {
                    if let Some(name) = &decl.name {
                        self.declare(name, Declared::Param);
                    }
                }
                Item::Fn(decl) => {
                    if let Some(name) = &decl.name {
                        self.declare(name, Declared::Fn(decl));
                    }
                }
                Item::Node(node) => {
                    if let Some(name) = &node.name {
                        let kind = match node.kind.segments.as_slice() {
                            [kind] if self.find(&kind.text, |d| matches!(d, Declared::Prefab(_))).is_none() => {
                                schema::kind(&kind.text)
                            }
                            _ => None,
                        };
                        // The name of an override is a path in a model.
                        if kind.is_none_or(|kind| kind.name != "override") {
                            self.declare(name, Declared::Node(kind));
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// The innermost declaration that `wanted` accepts: its scope, and whether a function lies in between.
    fn find(&self, name: &str, wanted: impl Fn(&Declared<'a>) -> bool) -> Option<(usize, bool)> {
        let mut crossed = false;
        for (i, scope) in self.scopes.iter().enumerate().rev() {
            if scope.names.get(name).is_some_and(|decl| wanted(&decl.what)) {
                return Some((i, crossed));
            }
            crossed |= scope.deferred;
        }
        None
    }

    /// Finds a name and counts the use.
    fn use_name(&mut self, name: &Name, wanted: impl Fn(&Declared<'a>) -> bool) -> Option<(Declared<'a>, Span, bool)> {
        let (scope, crossed) = self.find(&name.text, wanted)?;
        let decl = self.scopes.get_mut(scope)?.names.get_mut(&*name.text)?;
        decl.used = true;
        let (what, span) = (decl.what, decl.span);
        self.means(name.span, span, true);
        Some((what, span, crossed))
    }

    fn items(&mut self, items: &'a [Item], place: Where) {
        let mut set: FxHashMap<&str, Span> = FxHashMap::default();
        let names = items.iter().filter_map(|item| match item {
            Item::Property(property) => Some(&*property.name.text),
            _ => None,
        });
        let outer = std::mem::replace(&mut self.siblings, names.collect());
        for item in items {
            if let (Item::Property(property), Where::Node(_)) = (item, place) {
                match set.get(&*property.name.text) {
                    Some(first) => {
                        let twice = set_twice(&property.name.text, self.file(), property.name.span, *first);
                        self.report(twice);
                    }
                    None => {
                        set.insert(&property.name.text, property.name.span);
                    }
                }
            }
            self.item(item, place);
        }
        self.siblings = outer;
    }

    fn misplaced(&mut self, message: String, span: Span, label: &str, help: &str) {
        let mut diagnostic = Diagnostic::new("E0215", message).primary(self.file(), span, label);
        if let Some(around) = self.around.last() {
            let kind = self.source.slice(*around);
            diagnostic = diagnostic.label(self.file(), *around, format!("inside this `{kind}`"));
        }
        if !help.is_empty() {
            diagnostic = diagnostic.help(help);
        }
        self.report(diagnostic);
    }

    fn item(&mut self, item: &'a Item, place: Where) {
        match item {
            Item::Property(property) => self.property(property, place),
            Item::Node(node) => self.node(node, Some(place)),
            Item::Let(decl) => {
                if let Some(ty) = &decl.ty {
                    self.ty(ty);
                }
                let id = decl.name.as_ref().and_then(|name| match self.scopes.last()?.names.get(&*name.text)?.what {
                    Declared::Let(id) => Some(id),
                    _ => None,
                });
                self.inside.extend(id);
                self.value(&decl.value, VALUE);
                if id.is_some() {
                    self.inside.pop();
                }
            }
            Item::Param(decl) => {
                if !matches!(place, Where::Top | Where::Nowhere) {
                    self.misplaced(
                        "`param` must be at the top level".into(),
                        decl.span,
                        "not at the top level",
                        "move it up, or write `let`",
                    );
                }
                if let Some(ty) = &decl.ty {
                    self.ty(ty);
                }
                self.value(&decl.value, VALUE);
                if let Some(range) = &decl.range {
                    self.value(range, VALUE);
                }
            }
            Item::Fn(decl) => {
                self.formals(&decl.params);
                if let Some(ty) = &decl.result {
                    self.ty(ty);
                }
                match &decl.body {
                    ast::FnBody::Block(block) => self.block(&block.items, Where::Function, false),
                    ast::FnBody::Value(value) => self.value(value, VALUE),
                    ast::FnBody::Missing => {}
                }
                self.leave();
            }
            Item::Prefab(decl) => {
                self.formals(&decl.params);
                if let Some(body) = &decl.body {
                    self.block(&body.items, Where::Scene, false);
                }
                self.leave();
            }
            Item::For(stmt) => {
                self.value(&stmt.head.over, VALUE);
                let inner = match place {
                    Where::Top => Where::Scene,
                    other => other,
                };
                self.scopes.push(Names::default());
                for name in &stmt.head.names {
                    self.declare(name, Declared::Loop);
                }
                if let Some(body) = &stmt.body {
                    self.hoist(&body.items);
                    self.items(&body.items, inner);
                }
                self.leave();
            }
            Item::If(stmt) => {
                for (condition, block) in &stmt.arms {
                    self.value(condition, VALUE);
                    if let Some(block) = block {
                        self.block(&block.items, place, false);
                    }
                }
                if let Some(block) = &stmt.otherwise {
                    self.block(&block.items, place, false);
                }
            }
            Item::Return(stmt) => {
                if !matches!(place, Where::Function | Where::Nowhere) {
                    self.misplaced("`return` must be inside a function".into(), stmt.span, "not in a function", "");
                }
                self.value(&stmt.value, VALUE);
            }
            Item::Import(import) => {
                if !matches!(place, Where::Top | Where::Nowhere) {
                    self.misplaced("`import` must be at the top level".into(), import.span, "not at the top level", "");
                }
            }
            Item::Lang(lang) => {
                if !matches!(place, Where::Top | Where::Nowhere) {
                    self.misplaced("`lang` must be at the top level".into(), lang.span, "not at the top level", "");
                }
            }
            Item::Block(block) => self.block(&block.items, Where::Nowhere, false),
        }
    }

    /// Opens the scope of a function or prefab.
    fn formals(&mut self, formals: &'a [ast::Formal]) {
        self.scopes.push(Names { deferred: true, ..Names::default() });
        for formal in formals {
            if let Some(ty) = &formal.ty {
                self.ty(ty);
            }
            if let Some(default) = &formal.default {
                self.value(default, VALUE);
            }
            self.declare(&formal.name, Declared::Formal);
        }
    }

    fn ty(&mut self, ty: &'a ast::Type) {
        for name in &ty.names {
            if schema::type_name(&name.text).is_some() {
                continue;
            }
            let file = self.file();
            let foreign = match &*name.text {
                "number" | "double" | "f64" | "f32" | "real" => Some("float"),
                "integer" | "i32" | "u32" | "count" => Some("int"),
                "text" | "str" | "String" => Some("string"),
                "colour" | "rgb" => Some("color"),
                "vector" | "point" | "float3" => Some("vec3"),
                "rotation" | "quaternion" => Some("quat"),
                "boolean" => Some("bool"),
                _ => None,
            };
            let near =
                foreign.or_else(|| suggest(&name.text, schema::TYPES.iter().map(|row| row.name)).first().copied());
            let mut diagnostic = Diagnostic::new("E0203", format!("no type named `{}` here", name.text)).primary(
                file,
                name.span,
                "not a type",
            );
            diagnostic = match near {
                Some(near) => diagnostic.fix(Applicability::Safe, format!("write `{near}`"), file, name.span, near),
                None => diagnostic.help(format!("types are {}", all_of(schema::TYPES.iter().map(|row| row.name)))),
            };
            self.report(diagnostic);
        }
    }

    fn property(&mut self, property: &'a ast::Property, place: Where) {
        let name = &*property.name.text;
        let mut wanted = VALUE;
        match place {
            Where::Node(kind) => match kind.property(name) {
                Some(row) => wanted = Wanted::by(row),
                None => self.unknown_property(property, kind),
            },
            Where::Nowhere => {}
            _ => self.misplaced(
                format!("`{name}` must be inside a node"),
                property.name.span,
                "a property of nothing",
                "write it between the braces of a node; a value of your own is `let name = value`",
            ),
        }
        self.value(&property.value, wanted);
    }

    fn unknown_property(&mut self, property: &'a ast::Property, kind: &'static Kind) {
        let name = &*property.name.text;
        if kind.properties.is_empty() {
            return;
        }
        let known: Vec<&str> = kind.all().map(|property| property.name).collect();
        let near = suggest(name, known.iter().copied().filter(|known| !self.siblings.contains(known)));
        let file = self.file();
        let mut diagnostic = Diagnostic::new("E0201", format!("unknown property `{name}` on `{}`", kind.name)).primary(
            file,
            property.name.span,
            format!("not a property of `{}`", kind.name),
        );
        diagnostic = match near.as_slice() {
            [] if kind.property("material").is_some() && material_with(name).is_some() => {
                let of = material_with(name).unwrap_or("diffuse");
                let written = short_text(self.source.slice(property.value.span));
                let text = format!("it belongs to a material: write `material: {of} {{ {name}: {written} }}`");
                match self.siblings.contains("material") {
                    true => diagnostic.help("it belongs to the material: write it there"),
                    false => {
                        let edits = [
                            (Span::at(property.name.span.start), format!("material: {of} {{ ")),
                            (Span::at(property.value.span.end), " }".to_string()),
                        ];
                        let edits = edits.map(|(span, insert)| Edit { file, span, insert });
                        diagnostic.fix_edits(Applicability::Maybe, text, edits.into())
                    }
                }
            }
            [] if kind.sort == Sort::Material && GLOW.contains(&name) => diagnostic.help(
                "what gives off light is an `emitter { color: #fff, radiance: 5W/m^2/sr }`; `mix` it with another",
            ),
            [] => diagnostic.help(format!("`{}` has: {}", kind.name, known.join(", "))),
            [only] => {
                let text = format!("a property with a similar name exists: `{only}`");
                match trust_value(name, only) {
                    Applicability::Safe => diagnostic.fix(Applicability::Safe, text, file, property.name.span, *only),
                    _ => diagnostic.help(match *only {
                        "size" => "its extents are one property: `size: (x, y, z)`".to_string(),
                        "resolution" => "width and height are one property: `resolution: (1280, 720)`".to_string(),
                        "rotation" => "it is turned by `rotation: rotate_y(45deg)`".to_string(),
                        _ => text,
                    }),
                }
            }
            several => {
                diagnostic.help(format!("properties with similar names exist: {}", all_of(several.iter().copied())))
            }
        };
        self.report(diagnostic);
    }

    /// A node: as an item where `place` is given, else as a value.
    fn node(&mut self, node: &'a ast::Node, place: Option<Where>) {
        if let Some(like) = &node.like {
            self.value(like, VALUE);
        }
        let Some(first) = node.kind.segments.first() else { return };
        if node.kind.segments.len() > 1 {
            return match self.member(&node.kind) {
                Some(Declared::Prefab(decl)) => {
                    if let Some(Where::Function) = place {
                        self.no_node_here(first);
                    }
                    self.prefab_call(node, decl);
                }
                Some(Declared::Import) => self.body(node, Where::Nowhere),
                other => {
                    let text = kind_text(node);
                    let mut diagnostic = Diagnostic::new("E0202", format!("unknown kind `{text}`")).primary(
                        self.file(),
                        node.kind.span,
                        "not a prefab",
                    );
                    if let Some(Declared::Node(kind)) = other {
                        let kind = kind.map_or("kind", |kind| kind.name);
                        diagnostic = diagnostic.help(format!("copy it: `{kind} like {text} {{ }}`"));
                    }
                    if other.is_some() {
                        self.report(diagnostic);
                    }
                    self.body(node, Where::Nowhere)
                }
            };
        }
        let used = self.use_name(first, |decl| matches!(decl, Declared::Prefab(_) | Declared::Import));
        match used {
            Some((Declared::Prefab(decl), ..)) => {
                if let Some(Where::Function) = place {
                    self.no_node_here(first);
                }
                self.prefab_call(node, decl);
            }
            Some(_) => self.body(node, Where::Nowhere),
            None => match schema::kind(&first.text) {
                Some(_) if self.hidden.contains(&*first.text) => self.body(node, Where::Nowhere),
                Some(kind) => {
                    if kind.name != &*first.text {
                        let new = kind.name;
                        let diagnostic = Diagnostic::new("W0901", format!("`{}` is now `{new}`", first.text))
                            .primary(self.file(), first.span, "the old name, which the next version will not know")
                            .fix(Applicability::Safe, format!("write `{new}`"), self.file(), first.span, new);
                        self.report(diagnostic);
                    }
                    if let Some(place) = place {
                        self.placement(kind, first, place);
                    }
                    self.body(node, Where::Node(kind));
                }
                None => {
                    match place {
                        Some(Where::Node(parent)) if parent.property(&first.text).is_some() => self.no_colon(first),
                        _ => self.unknown_kind(first),
                    }
                    self.body(node, Where::Nowhere);
                }
            },
        }
    }

    /// E0105: `material diffuse { }` looks like a node.
    fn no_colon(&mut self, property: &Name) {
        let at = Span::at(property.span.end);
        let diagnostic = Diagnostic::new("E0105", format!("expected `:` after `{}`", property.text))
            .primary(self.file(), at, "expected `:`")
            .fix(Applicability::Safe, format!("write `{}: ..`", property.text), self.file(), at, ":");
        self.report(diagnostic);
    }

    /// What `module.name` stands for: reported where it is nothing. `None` where there is no such module.
    fn member(&mut self, path: &'a ast::Path) -> Option<Declared<'a>> {
        let (first, second) = (path.segments.first()?, path.segments.get(1)?);
        let module = |decl: &Declared<'_>| matches!(decl, Declared::Module(_) | Declared::Import);
        match self.use_name(first, module) {
            Some((Declared::Module(module), ..)) => {
                let what = self.offered(module, second);
                Some(if path.segments.len() > 2 && !matches!(what, Declared::Import) { Declared::Loop } else { what })
            }
            Some(_) => Some(Declared::Import),
            None => {
                let message = format!("no module named `{}` here", first.text);
                let diagnostic = Diagnostic::new("E0203", message)
                    .primary(self.file(), first.span, "not an import")
                    .help("add `import \"file.kin\" as name`");
                self.report(diagnostic);
                None
            }
        }
    }

    fn body(&mut self, node: &'a ast::Node, place: Where) {
        if let Some(body) = &node.body {
            self.around.push(node.kind.span);
            self.block(&body.items, place, false);
            self.around.pop();
        }
    }

    fn no_node_here(&mut self, kind: &Name) {
        self.misplaced(
            format!("`{}` cannot be inside a function", kind.text),
            kind.span,
            "a function makes values, no nodes",
            "use a `prefab`",
        );
    }

    fn placement(&mut self, kind: &'static Kind, name: &Name, place: Where) {
        match (kind.place, place) {
            (_, Where::Nowhere) => {}
            (_, Where::Function) => self.no_node_here(name),
            (Place::Top, Where::Top) => {}
            (Place::Top, _) => {
                let message = format!("`{}` must be at the top level", kind.name);
                self.misplaced(message, name.span, "not at the top level", "move it out of all braces");
            }
            (Place::Scene, Where::Top | Where::Scene) => {}
            (Place::Scene, Where::Node(parent)) if parent.holds == Holds::Scene => {}
            (Place::Scene, Where::Node(parent)) => {
                let help = match kind.sort {
                    Sort::Material => format!("write `material: {} {{ .. }}`", kind.name),
                    _ => "write it beside, and let it move along with `parent`, or in a `group`".into(),
                };
                let message = format!("`{}` cannot be inside `{}`", kind.name, parent.name);
                self.misplaced(message, name.span, "not here", &help);
            }
            (Place::Inside(kinds), Where::Node(parent)) => {
                let fits = match kinds {
                    [] => parent.sort.is_placed(),
                    kinds => kinds.contains(&parent.name),
                };
                if !fits {
                    self.outside(kind, kinds, name);
                }
            }
            (Place::Inside(kinds), _) => self.outside(kind, kinds, name),
        }
    }

    fn outside(&mut self, kind: &Kind, kinds: &[&str], name: &Name) {
        let wanted =
            if kinds.is_empty() { "a shape or a group".into() } else { crate::suggest::any_of(kinds.iter().copied()) };
        self.misplaced(format!("`{}` must be inside {wanted}", kind.name), name.span, "not here", "");
    }

    /// The visible names that `wanted` accepts.
    fn visible(&self, wanted: impl Fn(&Declared<'a>) -> bool) -> Vec<&'a str> {
        let mut names: Vec<&str> = self
            .scopes
            .iter()
            .flat_map(|scope| scope.names.iter())
            .filter(|(_, decl)| wanted(&decl.what))
            .map(|(name, _)| *name)
            .collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The built-in names and the visible ones that are most like an unknown one.
    fn guess(
        &mut self,
        name: &str,
        built_in: impl Iterator<Item = &'a str>,
        wanted: impl Fn(&Declared<'a>) -> bool,
    ) -> Vec<&'a str> {
        if self.guessed > GUESSES {
            return Vec::new();
        }
        let known: Vec<&str> = built_in.chain(self.visible(wanted)).collect();
        // Those that do not fit are looked at as well.
        let walked: usize = self.scopes.iter().map(|scope| scope.names.len()).sum();
        self.guessed += known.len() + walked / 8;
        suggest(name, known)
    }

    /// Counts a use of an unknown name; true for the first one, which is then to be reported.
    fn first_use(&mut self, what: &str, name: &Name) -> bool {
        let next = self.found.len();
        match self.unknown.get_mut(&(what.to_string(), name.text.to_string())) {
            Some((_, more)) => {
                more.push(name.span);
                false
            }
            None => {
                self.unknown.insert((what.to_string(), name.text.to_string()), (next, Vec::new()));
                true
            }
        }
    }

    /// A name that was meant, however misspelt, is not unused.
    fn meant(&mut self, name: &str) {
        for scope in &mut self.scopes {
            if let Some(decl) = scope.names.get_mut(name) {
                decl.used = true;
            }
        }
    }

    fn unknown_kind(&mut self, name: &'a Name) {
        if !self.first_use("kind", name) {
            return;
        }
        let is_prefab = |decl: &Declared<'_>| matches!(decl, Declared::Prefab(_));
        let near = self.guess(&name.text, schema::KINDS.iter().map(|kind| kind.name), is_prefab);
        near.first().inspect(|near| self.meant(near));
        let file = self.file();
        let mut diagnostic = Diagnostic::new("E0202", format!("unknown kind `{}`", name.text)).primary(
            file,
            name.span,
            "not a kind of node",
        );
        diagnostic = match near.first() {
            Some(near) => {
                diagnostic.fix(trust(&name.text, near), format!("did you mean `{near}`?"), file, name.span, *near)
            }
            None if &*name.text == schema::MIX.name => {
                diagnostic.help("two materials are mixed by a call: `mix(a, b, amount: 0.5)`")
            }
            None if nearest_kind(&name.text).is_some() => diagnostic.help(nearest_kind(&name.text).unwrap_or_default()),
            None => {
                let of = |sort: Sort| {
                    let names: Vec<&str> =
                        schema::KINDS.iter().filter(|kind| kind.sort == sort).map(|kind| kind.name).collect();
                    names.join(", ")
                };
                diagnostic
                    .help(format!("shapes: {}, group", of(Sort::Shape)))
                    .help(format!("materials: {}", of(Sort::Material)))
                    .help(format!("lights: sky, {}; and render, camera", of(Sort::Light)))
            }
        };
        self.report(diagnostic);
    }

    fn prefab_call(&mut self, node: &'a ast::Node, decl: &'a ast::PrefabDecl) {
        let prefab = &*kind_text(node);
        let file = self.file();
        let mut given: FxHashMap<&str, Span> = FxHashMap::default();
        let mut meant: Vec<&str> = Vec::new();
        let all: FxHashSet<&str> = node
            .body
            .iter()
            .flat_map(|body| &body.items)
            .filter_map(|item| match item {
                Item::Property(property) => Some(&*property.name.text),
                _ => None,
            })
            .collect();
        for item in node.body.iter().flat_map(|body| &body.items) {
            let Item::Property(property) = item else {
                self.misplaced(
                    format!("`{prefab}` takes only its parameters"),
                    item.span(),
                    "not a parameter",
                    "write `name: value`",
                );
                continue;
            };
            let name = &*property.name.text;
            if let Some(first) = given.insert(name, property.name.span) {
                let twice = set_twice(name, file, property.name.span, first);
                self.report(twice);
            }
            if let Some(formal) = decl.params.iter().find(|formal| &*formal.name.text == name) {
                self.means(property.name.span, formal.name.span, true);
            } else {
                let known: Vec<&str> = decl.params.iter().map(|formal| &*formal.name.text).collect();
                let mut diagnostic = Diagnostic::new("E0208", format!("`{prefab}` has no parameter `{name}`"))
                    .primary(file, property.name.span, "no such parameter")
                    .label(file, decl.head, "declared here");
                let free = known.iter().copied().filter(|known| !all.contains(known));
                let near = suggest(name, free).first().copied();
                meant.extend(near);
                diagnostic = match near {
                    Some(near) => diagnostic.fix(
                        Applicability::Safe,
                        format!("did you mean `{near}`?"),
                        file,
                        property.name.span,
                        near,
                    ),
                    None if matches!(name, "position" | "rotation" | "scale" | "parent" | "visible") => diagnostic
                        .help(format!("put the call into a group: `group {{ {name}: .., {prefab} {{ .. }} }}`")),
                    None if known.is_empty() => diagnostic.help("it takes none"),
                    None => diagnostic.help(format!("it takes {}", all_of(known))),
                };
                self.report(diagnostic);
            }
            self.value(&property.value, VALUE);
        }
        if node.like.is_some() {
            return;
        }
        for formal in &decl.params {
            let name = &*formal.name.text;
            if formal.default.is_none() && !given.contains_key(name) && !meant.contains(&name) {
                let diagnostic = Diagnostic::new("E0209", format!("`{prefab}` needs `{name}`"))
                    .primary(file, node.kind.span, format!("`{name}` is not given"))
                    .label(file, formal.span, "asked for here")
                    .help(format!("add `{name}: ..`"));
                self.report(diagnostic);
            }
        }
    }

    fn value(&mut self, expr: &'a Expr, wanted: Wanted) {
        match &expr.kind {
            ExprKind::Missing | ExprKind::Number(_) | ExprKind::Color(_) | ExprKind::Str(_) | ExprKind::Bool(_) => {}
            ExprKind::Path(_) | ExprKind::Binary { .. } if wanted.text && self.bare_text(expr) => {}
            ExprKind::Path(path) => self.path(path, wanted),
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                items.iter().for_each(|item| self.value(item, VALUE));
            }
            ExprKind::Comp(comp) => {
                self.value(&comp.head.over, VALUE);
                self.scopes.push(Names::default());
                for name in &comp.head.names {
                    self.declare(name, Declared::Loop);
                }
                if let Some(condition) = &comp.condition {
                    self.value(condition, VALUE);
                }
                self.value(&comp.value, VALUE);
                self.leave();
            }
            ExprKind::Unary { value, .. } => self.value(value, VALUE),
            ExprKind::Binary { first, rest } => {
                self.value(first, VALUE);
                for step in rest {
                    match &step.value.kind {
                        ExprKind::Path(path) if self.glued_unit(path, step.op_span) => {}
                        _ => self.value(&step.value, VALUE),
                    }
                }
            }
            ExprKind::Call { callee, args } => self.call(callee, args, expr.span, wanted),
            ExprKind::Field { base, .. } => self.value(base, VALUE),
            ExprKind::Index { base, index } => {
                self.value(base, VALUE);
                self.value(index, VALUE);
            }
            ExprKind::Node(node) => self.node(node, None),
            ExprKind::Keys(keys) => self.keys(keys),
            ExprKind::If(value) => {
                for (condition, arm) in &value.arms {
                    self.value(condition, VALUE);
                    self.value(arm, wanted);
                }
                self.value(&value.otherwise, wanted);
                self.arms(value);
            }
        }
    }

    /// `assets/bunny.obj` without quotes, where a text is wanted: whether that is what stands there, which is reported.
    fn bare_text(&mut self, expr: &'a Expr) -> bool {
        let text = self.source.slice(expr.span);
        let text = &*text.replace(' ', "");
        let first = text.split(['.', '/']).next().unwrap_or(text);
        let plain = |letter: char| letter.is_alphanumeric() || "_-./".contains(letter);
        if !text.contains(['.', '/']) || !text.chars().all(plain) || self.find(first, |_| true).is_some() {
            return false;
        }
        let file = self.file();
        let quoted = format!("\"{text}\"");
        let diagnostic = Diagnostic::new("E0203", format!("no value named `{first}` here"))
            .primary(file, expr.span, "a text without quotes")
            .fix(Applicability::Maybe, format!("write `{quoted}`"), file, expr.span, quoted);
        self.report(diagnostic);
        true
    }

    /// `600kg/m3`: what is glued to a unit and means nothing was meant as a unit, too; E0305.
    fn glued_unit(&mut self, path: &'a ast::Path, op: Span) -> bool {
        let [name] = path.segments.as_slice() else { return false };
        let line = self.source.slice(Span::new(op.start.saturating_sub(24), op.start));
        let before = line.trim_end();
        let unit = before.trim_end_matches(|letter: char| letter.is_alphanumeric() || "./*^".contains(letter));
        let number = before[unit.len()..].starts_with(|digit: char| digit.is_ascii_digit())
            && before.ends_with(|letter: char| letter.is_alphabetic());
        if !number || self.find(&name.text, |_| true).is_some() {
            return false;
        }
        let file = self.file();
        let letters = name.text.trim_end_matches(|digit: char| digit.is_ascii_digit());
        let known = |word: &str| dimension::UNITS.iter().any(|unit| unit.0 == word);
        let glued = before.len() == line.len() && op.end == name.span.start;
        let meant = match &name.text[letters.len()..] {
            power @ ("2" | "3" | "4") if known(letters) => Some(format!("{letters}^{power}")),
            _ if !glued => return false,
            _ => suggest(&name.text, dimension::UNITS.iter().map(|unit| unit.0)).first().map(|near| near.to_string()),
        };
        let diagnostic =
            Diagnostic::new("E0305", format!("unknown unit `{}`", name.text)).primary(file, name.span, "not a unit");
        let diagnostic = match meant {
            Some(meant) => {
                let place = Span::new(op.start - (line.len() - before.len()) as u32, name.span.end);
                let insert = format!("{}{meant}", self.source.slice(op));
                diagnostic.fix(Applicability::Safe, format!("did you mean `{meant}`?"), file, place, insert)
            }
            None => diagnostic.help("put spaces round the sign, if a value of that name was meant"),
        };
        self.report(diagnostic);
        true
    }

    /// E0312, where it can be seen without computing.
    fn arms(&mut self, value: &'a ast::IfValue) {
        let last = value.arms.iter().map(|(_, arm)| arm).chain([&value.otherwise]);
        if let Some([(before, at), (shape, span)]) = unlike(last) {
            let diagnostic = Diagnostic::new("E0312", "`if` arms have different types")
                .primary(self.file(), span, format!("this is {shape}"))
                .label(self.file(), at, format!("this is {before}"));
            self.report(diagnostic);
        }
    }

    fn keys(&mut self, keys: &'a ast::Keys) {
        for key in &keys.keys {
            self.value(&key.time, VALUE);
            match &key.value {
                ast::KeyValue::Value(value) => self.value(value, VALUE),
                ast::KeyValue::Block(block) => {
                    for item in &block.items {
                        if let Item::Property(property) = item {
                            self.value(&property.value, VALUE);
                        }
                    }
                }
            }
            // The names of easings and of where steps jump are words, not values.
            match key.ease.as_ref().map(|ease| &ease.kind) {
                Some(ExprKind::Call { callee, args }) => {
                    let words = self.source.slice(callee.span) == "steps";
                    for arg in args.iter().take(if words { 1 } else { usize::MAX }) {
                        self.value(&arg.value, VALUE);
                    }
                }
                Some(ExprKind::Path(path)) => self.easing(path),
                _ => {}
            }
        }
    }

    /// An easing may be a function; else it is a word.
    fn easing(&mut self, path: &'a ast::Path) {
        match path.segments.as_slice() {
            [name] => {
                self.use_name(name, |decl| matches!(decl, Declared::Fn(_) | Declared::Import));
            }
            _ => {
                self.member(path);
            }
        }
    }

    fn path(&mut self, path: &'a ast::Path, wanted: Wanted) {
        let Some(first) = path.segments.first() else { return };
        let name = &*first.text;
        let single = path.segments.len() == 1;
        if single && wanted.words.iter().any(|word| word.name == name) || matches!(name, "time" | "frame") {
            return;
        }
        let used = self.use_name(first, |decl| !matches!(decl, Declared::Fn(_) | Declared::Prefab(_)));
        if let Some((what, span, crossed)) = used {
            if let Declared::Module(module) = what {
                return self.value_of(module, path, wanted);
            }
            if let Declared::Let(id) = what {
                if let Some(inside) = self.inside.last() {
                    self.lets[*inside].push(id);
                }
                if !crossed && path.span.start < span.start {
                    let diagnostic = Diagnostic::new("E0212", format!("`{name}` is used before its `let`"))
                        .primary(self.file(), first.span, "used here")
                        .label(self.file(), span, "declared here")
                        .help("move the `let` up");
                    self.early.push((id, diagnostic));
                }
            }
            return;
        }
        if is_point(name) {
            return;
        }
        if single && !wanted.words.is_empty() {
            let file = self.file();
            let diagnostic = wrong_word(&format!("`{name}`"), wanted.words, wanted.property).primary(
                file,
                first.span,
                "not one of its words",
            );
            return self.report(nearest_word(diagnostic, name, wanted.words, file, first.span));
        }
        if !single && self.unknown_module(first, wanted) {
            return;
        }
        self.unknown_value(first, wanted);
    }

    /// `metals.gold` without its import: whether that is what it is, which is reported.
    fn unknown_module(&mut self, name: &'a Name, wanted: Wanted) -> bool {
        let path = format!("std/{}", name.text);
        let known = library::find(&path).is_some();
        if !known && wanted.sort != Some(Sort::Material)
            || !self.guess(&name.text, std::iter::empty(), |_| true).is_empty()
        {
            return false;
        }
        if self.first_use("module", name) {
            let from = if known { path } else { format!("{}.kin", name.text) };
            let diagnostic = Diagnostic::new("E0203", format!("no module named `{}` here", name.text))
                .primary(self.file(), name.span, "not an import")
                .help(format!("add `import \"{from}\" as {}` on top", name.text));
            self.report(diagnostic);
        }
        true
    }

    /// A value out of a module.
    fn value_of(&mut self, module: usize, path: &'a ast::Path, wanted: Wanted) {
        let file = self.file();
        let Some(name) = path.segments.get(1) else {
            let text = self.source.slice(path.span);
            let diagnostic = Diagnostic::new("E0204", format!("`{text}` is a file, expected a {}", wanted.what))
                .primary(file, path.span, "an imported file")
                .help(format!("say what of it: `{text}.name`"));
            return self.report(diagnostic);
        };
        let (what, help) = match self.offered(module, name) {
            Declared::Fn(_) => ("function", "(..)"),
            Declared::Prefab(_) => ("prefab", " { .. }"),
            _ => return,
        };
        let text = short_text(self.source.slice(path.segments[0].span.to(name.span)));
        let diagnostic = Diagnostic::new("E0204", format!("`{text}` is a {what}, expected a {}", wanted.what))
            .primary(file, path.span, format!("a {what}"))
            .help(format!("call it: `{text}{help}`"));
        self.report(diagnostic);
    }

    fn unknown_value(&mut self, name: &'a Name, wanted: Wanted) {
        if !self.first_use(wanted.what, name) {
            return;
        }
        let file = self.file();
        let mut diagnostic = Diagnostic::new("E0203", format!("no {} named `{}` here", wanted.what, name.text))
            .primary(file, name.span, "not found");
        let is_function = |decl: &Declared<'_>| matches!(decl, Declared::Fn(_));
        if self.find(&name.text, is_function).is_some() || builtin::find(&name.text).is_some() {
            diagnostic = diagnostic.help(format!("there is a function of that name: call it, `{}(..)`", name.text));
            return self.report(diagnostic);
        }
        let fits = |decl: &Declared<'_>| match (wanted.sort, decl) {
            (_, Declared::Fn(_) | Declared::Prefab(_) | Declared::Import | Declared::Module(_)) => false,
            (Some(sort), Declared::Node(Some(kind))) => kind.sort == sort,
            (None, Declared::Node(_)) => wanted.what == "node",
            _ => true,
        };
        let near = self.guess(&name.text, std::iter::empty(), fits);
        near.first().inspect(|near| self.meant(near));
        if let Some(near) = near.first() {
            let declared = self.find(near, fits).and_then(|(scope, _)| self.scopes.get(scope)?.names.get(near));
            let span = declared.map(|decl| decl.span);
            let text = format!("did you mean `{near}`?");
            diagnostic = diagnostic.fix(Applicability::Safe, text, file, name.span, *near);
            if let Some(span) = span {
                diagnostic = diagnostic.label(file, span, format!("`{near}` is declared here"));
            }
        } else if wanted.text {
            let text = format!("\"{}\"", name.text);
            diagnostic = diagnostic.fix(Applicability::Maybe, format!("write `{text}`"), file, name.span, text);
        } else if wanted.sort == Some(Sort::Material)
            && schema::kind(&name.text).is_some_and(|kind| kind.sort == Sort::Material)
        {
            diagnostic = diagnostic.help(format!("write `{} {{ .. }}`", name.text));
        } else if let Some(path) = library::declares(&name.text).filter(|_| wanted.sort == Some(Sort::Material)) {
            diagnostic = diagnostic.help(format!("add `import {{ {} }} from \"{path}\"` on top", name.text));
        } else if let Some(near) =
            suggest(&name.text, materials()).first().filter(|_| wanted.sort == Some(Sort::Material))
        {
            let text = &name.text;
            diagnostic = diagnostic.help(format!("write `{near} {{ }}`, or declare it: `{near} {text} {{ }}`"));
        } else if let Some(value) =
            value_for(&name.text).filter(|value| wanted.sort.is_none() && (!value.starts_with('#') || wanted.colour))
        {
            diagnostic = diagnostic.fix(Applicability::Maybe, format!("write `{value}`"), file, name.span, value);
        } else if matches!(&*name.text, "pi" | "PI" | "Pi" | "tau") && wanted.sort.is_none() {
            diagnostic = diagnostic.help("an angle has a unit: half a turn is `180deg` or `0.5turn`").help(format!(
                "for the number itself write `let {} = {}`",
                name.text,
                if &*name.text == "tau" { "6.283185307179586" } else { "3.141592653589793" }
            ));
        } else if let Some(span) = self.ended.get(&*name.text).copied() {
            diagnostic = diagnostic
                .label(file, span, "declared inside a block")
                .help("names of a block are not seen outside: move it out, before the block");
        } else {
            const MOST: usize = 6;
            let here = match wanted.sort {
                Some(sort) => self.visible(|decl| matches!(decl, Declared::Node(Some(kind)) if kind.sort == sort)),
                None => self.visible(fits),
            };
            diagnostic = match here.len() {
                0 if wanted.sort == Some(Sort::Material) => {
                    diagnostic.help(format!("declare it, for example `diffuse {} {{ color: #d9402b }}`", name.text))
                }
                1 => diagnostic.help(format!("there is {}", all_of(here))),
                2..=MOST => diagnostic.help(format!("there are {}", all_of(here))),
                _ => diagnostic,
            };
        }
        self.report(diagnostic);
    }

    /// The words that an argument of a built-in function may be.
    fn argument_words(&self, callee: &Expr, index: usize, arg: &ast::Arg) -> Wanted {
        let name = self.source.slice(callee.span);
        let own = self.find(name, |decl| matches!(decl, Declared::Fn(_) | Declared::Import)).is_some();
        let Some(function) = builtin::find(name).filter(|_| !own) else { return VALUE };
        let param = match &arg.name {
            Some(name) => function.params.iter().find(|param| param.name == &*name.text),
            None if function.rest.is_some() => None,
            None => function.params.get(index),
        };
        param.map_or(VALUE, |param| Wanted { words: param.words, property: param.name, ..VALUE })
    }

    fn call(&mut self, callee: &'a Expr, args: &'a [ast::Arg], span: Span, wanted: Wanted) {
        let mixes = wanted.sort == Some(Sort::Material) && self.source.slice(callee.span) == schema::MIX.name;
        for (i, arg) in args.iter().enumerate() {
            // What is given to a parameter that is not there may be one of its words.
            let known = |function: &builtin::Builtin| match &arg.name {
                Some(name) => function.params.iter().any(|param| param.name == &*name.text),
                None => true,
            };
            let plain = matches!(arg.value.kind, ExprKind::Path(_));
            if plain && builtin::find(self.source.slice(callee.span)).is_some_and(|function| !known(function)) {
                continue;
            }
            let name = arg.name.as_ref().map_or(["a", "b"].get(i).copied().unwrap_or(""), |name| &*name.text);
            let words = self.argument_words(callee, i, arg);
            self.value(&arg.value, if mixes && matches!(name, "a" | "b") { wanted } else { words });
        }
        let file = self.file();
        let path = match &callee.kind {
            ExprKind::Missing => return,
            ExprKind::Path(path) => path,
            _ => {
                self.value(callee, VALUE);
                let diagnostic =
                    Diagnostic::new("E0210", "this is not a function").primary(file, callee.span, "cannot be called");
                return self.report(diagnostic);
            }
        };
        let Some(name) = path.segments.first() else { return };
        let text = short_text(self.source.slice(path.span));
        if path.segments.len() > 1 {
            let is_module = |decl: &Declared<'_>| matches!(decl, Declared::Module(_) | Declared::Import);
            if self.find(&name.text, is_module).is_none() {
                let module = &name.text;
                let diagnostic = Diagnostic::new("E0210", format!("no function `{text}`"))
                    .primary(file, path.span, "not found")
                    .help(format!("add `import \"{module}.kin\" as {module}` on top"));
                return self.report(diagnostic);
            }
            match self.member(path) {
                Some(Declared::Fn(decl)) => self.own_arguments(&text, decl, args, span),
                None | Some(Declared::Import) => {}
                Some(what) => {
                    let mut diagnostic = Diagnostic::new("E0210", format!("`{text}` is not a function")).primary(
                        file,
                        path.span,
                        "cannot be called",
                    );
                    if let Declared::Prefab(_) = what {
                        diagnostic = diagnostic.help(format!("nodes are written with braces: `{text} {{ .. }}`"));
                    }
                    self.report(diagnostic);
                }
            }
            return;
        }
        let used = self.use_name(name, |decl| matches!(decl, Declared::Fn(_) | Declared::Import));
        match used {
            Some((Declared::Fn(decl), ..)) => self.own_arguments(&text, decl, args, span),
            Some(_) => {}
            None => match builtin::find(&name.text) {
                Some(function) => {
                    let params: Vec<(&str, bool)> =
                        function.params.iter().map(|param| (param.name, param.optional)).collect();
                    self.arguments(
                        &name.text,
                        &params,
                        function.rest.is_some(),
                        args,
                        span,
                        function.signature(),
                        None,
                    );
                }
                None => self.unknown_function(name),
            },
        }
    }

    fn own_arguments(&mut self, name: &str, decl: &'a ast::FnDecl, args: &'a [ast::Arg], span: Span) {
        let params: Vec<(&str, bool)> =
            decl.params.iter().map(|formal| (&*formal.name.text, formal.default.is_some())).collect();
        let list: Vec<&str> = params.iter().map(|param| param.0).collect();
        let signature = format!("{name}({})", list.join(", "));
        for name in args.iter().filter_map(|arg| arg.name.as_ref()) {
            if let Some(formal) = decl.params.iter().find(|formal| formal.name.text == name.text) {
                self.means(name.span, formal.name.span, true);
            }
        }
        self.arguments(name, &params, false, args, span, signature, Some(decl.head));
    }

    fn unknown_function(&mut self, name: &'a Name) {
        if !self.first_use("function", name) {
            return;
        }
        let file = self.file();
        let mut diagnostic =
            Diagnostic::new("E0210", format!("no function `{}`", name.text)).primary(file, name.span, "not found");
        let is_function = |decl: &Declared<'_>| matches!(decl, Declared::Fn(_));
        let near = self.guess(&name.text, builtin::BUILTINS.iter().map(|function| function.name), is_function);
        near.first().inspect(|near| self.meant(near));
        let is_prefab = self.find(&name.text, |decl| matches!(decl, Declared::Prefab(_))).is_some();
        if is_prefab {
            self.meant(&name.text);
        }
        if is_prefab || schema::kind(&name.text).is_some() {
            diagnostic = diagnostic.help(format!("nodes are written with braces: `{} {{ .. }}`", name.text));
        } else if &*name.text == "pow" {
            diagnostic = diagnostic.help("a power is written `a ^ b`");
        } else if let Some(near) = near.first() {
            let text = format!("did you mean `{near}`?");
            diagnostic = diagnostic.fix(trust(&name.text, near), text, file, name.span, *near);
        }
        self.report(diagnostic);
    }

    #[allow(clippy::too_many_arguments)]
    fn arguments(
        &mut self,
        name: &str,
        params: &[(&str, bool)],
        rest: bool,
        args: &'a [ast::Arg],
        span: Span,
        signature: String,
        head: Option<Span>,
    ) {
        let file = self.file();
        let plain = args.iter().filter(|arg| arg.name.is_none()).count();
        let mut given: FxHashMap<&str, Span> = FxHashMap::default();
        for (param, arg) in params.iter().zip(args).filter(|(_, arg)| arg.name.is_none() && !rest) {
            given.insert(param.0, arg.span);
        }
        for arg in args {
            let Some(key) = &arg.name else { continue };
            if !params.iter().any(|param| param.0 == &*key.text) {
                let known: Vec<&str> = params.iter().map(|param| param.0).collect();
                let mut diagnostic = Diagnostic::new("E0208", format!("`{name}` has no parameter `{}`", key.text))
                    .primary(file, key.span, "no such parameter");
                if let Some(head) = head {
                    diagnostic = diagnostic.label(file, head, "declared here");
                }
                diagnostic = match suggest(&key.text, known).first() {
                    Some(near) => {
                        let text = format!("did you mean `{near}`?");
                        diagnostic.fix(Applicability::Safe, text, file, key.span, *near)
                    }
                    None => diagnostic.help(format!("it is `{signature}`")),
                };
                return self.report(diagnostic);
            }
            if let Some(first) = given.insert(&key.text, arg.span) {
                let twice = set_twice(&key.text, file, arg.span, first);
                return self.report(twice);
            }
        }
        if rest {
            return;
        }
        let missing = params.iter().any(|param| !param.1 && !given.contains_key(param.0));
        if missing || plain > params.len() {
            let most = params.len();
            let least = params.iter().filter(|param| !param.1).count();
            let takes = match (least, most) {
                (0, 0) => "no values".to_string(),
                (least, most) if least == most => format!("{most} value{}", if most == 1 { "" } else { "s" }),
                (least, most) => format!("{least} to {most} values"),
            };
            let mut diagnostic = Diagnostic::new("E0211", format!("`{name}` takes {takes}, got {}", args.len()))
                .primary(file, span, "")
                .help(format!("it is `{signature}`"));
            if let Some(head) = head {
                diagnostic = diagnostic.label(file, head, "declared here");
            }
            self.report(diagnostic);
        }
    }
}

/// Words of other programs for light that a surface gives off.
const GLOW: &[&str] = &["emission", "emissive", "emission_color", "emit", "glow", "light", "luminance", "emittance"];

/// The kind of material that a shape's would-be property is most likely one of.
fn material_with(name: &str) -> Option<&'static str> {
    Some(match name {
        "color" | "roughness" | "opacity" => "diffuse",
        "ior" | "attenuation_color" | "attenuation_distance" => "dielectric",
        "metalness" => "glossy",
        "spectrum" | "edge_tint" | "anisotropy" => "metal",
        "radiance" | "power" => "emitter",
        _ => return None,
    })
}

/// Whether the arms of an `if` are not of one type, as far as their text alone tells: E0312 is then said of them.
pub fn has_unlike_arms(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::If(value) => unlike(value.arms.iter().map(|(_, arm)| arm).chain([&value.otherwise])).is_some(),
        _ => false,
    }
}

/// The first two arms of different types: what they are, and where.
fn unlike<'e>(arms: impl Iterator<Item = &'e Expr>) -> Option<[(String, Span); 2]> {
    let mut first: Option<(String, Option<bool>, Span)> = None;
    for arm in arms {
        let Some((shape, has_unit)) = shape(arm) else { continue };
        match first.take() {
            None => first = Some((shape, has_unit, arm.span)),
            // A bare number may be a length, and 0 is anything.
            Some((before, Some(had_unit), at)) if has_unit.is_some_and(|has| !has || !had_unit) => {
                first = Some((before, Some(had_unit), at));
            }
            Some((before, _, at)) if before != shape => return Some([(before, at), (shape, arm.span)]),
            same => first = same,
        }
    }
    None
}

/// What an expression is, as far as its text alone tells; of a number, whether it has a unit.
fn shape(expr: &Expr) -> Option<(String, Option<bool>)> {
    if let ExprKind::Unary { op: ast::UnaryOp::Neg, value, .. } = &expr.kind {
        return shape(value);
    }
    if let ExprKind::Number(number) = &expr.kind {
        let of = number.unit.as_ref().and_then(|unit| unit.si).map(|(_, of)| of);
        return Some((of.unwrap_or_default().with_article(), Some(number.unit.is_some())));
    }
    Some((simple_shape(expr)?.to_string(), None))
}

fn simple_shape(expr: &Expr) -> Option<&'static str> {
    Some(match &expr.kind {
        ExprKind::Color(_) => "a colour",
        ExprKind::Str(_) => "text",
        ExprKind::Bool(_) => "true or false",
        ExprKind::Tuple(items) => match items.len() {
            2 => "a vector of 2 components",
            3 => "a vector of 3 components",
            _ => "a tuple",
        },
        ExprKind::List(_) | ExprKind::Comp(_) => "a list",
        ExprKind::Unary { .. } => "true or false",
        ExprKind::Node(node) if schema::kind(&kind_text(node)).is_some() => "a node",
        _ => return None,
    })
}
