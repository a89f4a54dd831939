//! A scene and the files that it imports: each read once, in the order in which they are first imported.
//!
//! What a file offers is what its top level declares, but for names that start with `_`; what it imports itself it does
//! not pass on. Imports form no circles: an import that would close one is reported and leads nowhere.

use std::collections::HashMap;
use std::sync::Arc;

use crate::diagnostic::Diagnostic;
use crate::eval::limits;
use crate::files::{self, Files, diagnose};
use crate::library;
use crate::source::{FileId, Source, Span, Texts};
use crate::suggest::{all_of, suggest};
use crate::syntax::{Tree, ast, parse};

/// A file with what it imports.
pub struct Module {
    /// The text.
    pub source: Source,
    /// What is written in it, its places moved to where its text lies in [`Modules::texts`].
    pub file: Arc<ast::File>,
    /// The imports at its top level: which module each leads to. `None` is reported.
    pub imports: Vec<Option<usize>>,
    /// The module that imports it first, and the place of the path there; `None` of the scene itself.
    pub importer: Option<(usize, Span)>,
    /// Whether it is part of this program.
    pub standard: bool,
}

impl Module {
    /// The imports at its top level with the module each leads to.
    pub fn imports(&self) -> impl Iterator<Item = (&ast::ImportDecl, Option<usize>)> {
        imports_of(&self.file).zip(self.imports.iter().copied().chain(std::iter::repeat(None)))
    }
}

fn imports_of(file: &ast::File) -> impl Iterator<Item = &ast::ImportDecl> {
    file.items.iter().filter_map(|item| match item {
        ast::Item::Import(import) => Some(import),
        _ => None,
    })
}

/// The scene and everything that it imports.
pub struct Modules {
    /// The scene first.
    pub list: Vec<Module>,
    /// Their texts.
    pub texts: Texts,
    /// Mistakes of the parser, and files that could not be imported. Their places are settled.
    pub diagnostics: Vec<Diagnostic>,
}

impl Modules {
    /// Every text, the scene's first.
    pub fn sources(&self) -> Vec<Source> {
        self.list.iter().map(|module| module.source.clone()).collect()
    }

    /// Says of a diagnostic in an imported file how the scene comes to it.
    pub fn explain(&self, found: &mut Diagnostic) {
        let Some((file, _)) = found.place() else { return };
        let mut at = self.list.iter().position(|module| module.source.id == file);
        let mut notes = Vec::new();
        while let Some((importer, span)) = at.and_then(|at| self.list.get(at)?.importer) {
            let source = &self.list[importer].source;
            let line = self.texts.position(span.start).line;
            let which = if notes.is_empty() { "" } else { "which is " };
            notes.push(format!("{which}imported by {}, line {line}", source.name));
            at = Some(importer);
        }
        // Of a long way the ends.
        if let Some(more @ 2..) = notes.len().checked_sub(4) {
            notes.splice(3..3 + more, [format!("and so on, {more} files more")]);
        }
        found.notes.append(&mut notes);
    }
}

struct Loader<'f> {
    files: &'f dyn Files,
    modules: Modules,
    known: HashMap<String, usize>,
    /// The modules whose imports are being read, each imported by the one before, with the place of the path.
    open: Vec<(usize, Span)>,
    full: bool,
    /// Files that could not be read.
    failed: usize,
}

/// Reads everything that a scene imports.
pub fn load(tree: &Tree, files: &dyn Files) -> Modules {
    let (source, file) = (tree.source.clone(), tree.file().clone());
    let own = Module { source, file, imports: Vec::new(), importer: None, standard: false };
    let known = HashMap::from([(tree.source.name.to_string(), 0)]);
    let texts = Texts::new(&tree.source);
    let modules = Modules { list: vec![own], texts, diagnostics: tree.errors().to_vec() };
    let mut loader = Loader { files, modules, known, open: vec![(0, Span::at(0))], full: false, failed: 0 };
    loader.imports(0);
    loader.modules
}

impl Loader<'_> {
    fn imports(&mut self, at: usize) {
        let paths: Vec<Option<ast::Name>> =
            imports_of(&self.modules.list[at].file).map(|import| import.path.clone()).collect();
        let found = paths.into_iter().map(|path| path.and_then(|path| self.import(at, &path)));
        let found: Vec<Option<usize>> = found.collect();
        self.modules.list[at].imports = found;
    }

    fn report(&mut self, mut found: Diagnostic) {
        self.modules.texts.settle(&mut found);
        self.modules.explain(&mut found);
        self.modules.diagnostics.push(found);
    }

    /// The module behind a path that is written in module `at`.
    fn import(&mut self, at: usize, path: &ast::Name) -> Option<usize> {
        let (id, span) = (self.modules.texts.id, path.span);
        if path.text.is_empty() && !path.quoted {
            return None;
        }
        let standard = library::is_path(&path.text);
        let name = if standard {
            path.text.to_string()
        } else {
            match files::resolve(&self.modules.list[at].source.name, &path.text) {
                Ok(name) => name,
                Err(error) => {
                    let literal = self.modules.texts.slice(span).to_string();
                    self.report(diagnose(self.files, &error, (id, span), &path.text, &literal));
                    return None;
                }
            }
        };
        if let Some(known) = self.known.get(&name).copied() {
            if let Some(start) = self.open.iter().position(|(open, _)| *open == known) {
                self.circle(start, span);
                return None;
            }
            return Some(known);
        }
        if self.full {
            return None;
        }
        let many = self.modules.list.len() + self.failed >= limits::FILES;
        if self.open.len() > limits::IMPORTS_DEEP || many {
            let (message, label) = match many {
                true => (format!("the scene has more than {} files", limits::FILES), "one file too many"),
                false => (format!("imports are nested deeper than {} files", limits::IMPORTS_DEEP), "one too deep"),
            };
            self.full = true;
            self.report(
                Diagnostic::new("E1005", message)
                    .primary(id, span, label)
                    .help("flatten it: put what belongs together into one file"),
            );
            return None;
        }
        let next = FileId(id.0.saturating_add(self.modules.list.len() as u32));
        let (source, errors) =
            match standard {
                true => match library::find(&name) {
                    Some(text) => (Source::new(next, name.as_str(), text), Vec::new()),
                    None => {
                        let known = library::FILES.iter().map(|file| file.0);
                        let mut found = Diagnostic::new("E0701", format!("the standard library has no `{name}`"))
                            .primary(id, span, "no such part");
                        found = match suggest(&name, known.clone()).first() {
                            Some(near) => {
                                let text = format!("\"{near}\"");
                                let help = format!("did you mean `{near}`?");
                                found.fix(crate::diagnostic::Applicability::Safe, help, id, span, text)
                            }
                            None => found.help(format!("it has {}", all_of(known))),
                        };
                        self.report(found);
                        return None;
                    }
                },
                false => match files::load(self.files, next, &name) {
                    Ok(loaded) => (loaded.source, Vec::from_iter(loaded.error)),
                    Err(error) => {
                        self.failed += 1;
                        let literal = self.modules.texts.slice(span).to_string();
                        self.report(diagnose(self.files, &error, (id, span), &path.text, &literal));
                        return None;
                    }
                },
            };
        let Some(base) = self.modules.texts.add(&source, limits::TEXT_OF_ALL_FILES) else {
            self.full = true;
            let most = limits::TEXT_OF_ALL_FILES >> 20;
            self.report(
                Diagnostic::new("E0712", format!("the scene's files have more than {most} MiB together"))
                    .primary(id, span, "with this one")
                    .help("put large data into meshes or images of their own"),
            );
            return None;
        };
        let index = self.modules.list.len();
        self.known.insert(name, index);
        // A text that is no text is not worth parsing: its names are unknown, and nothing is said about them.
        let readable = errors.is_empty();
        let tree = parse(&source);
        let file = match readable {
            true => tree.file_at(base),
            false => Arc::new(ast::File { items: Vec::new(), span: Span::at(base) }),
        };
        let importer = Some((at, span));
        self.modules.list.push(Module { source, file, imports: Vec::new(), importer, standard });
        let wrong = if readable { tree.errors().to_vec() } else { errors };
        for mut found in wrong {
            self.modules.explain(&mut found);
            self.modules.diagnostics.push(found);
        }
        self.open.push((index, span));
        self.imports(index);
        self.open.pop();
        readable.then_some(index)
    }

    /// E0702: the import at `span` leads back to the module that `open[start]` is about.
    fn circle(&mut self, start: usize, span: Span) {
        let id = self.modules.texts.id;
        let name = |loader: &Self, at: usize| loader.modules.list[loader.open[at].0].source.name.clone();
        let last = self.open.len() - 1;
        let closes = format!("`{}` imports `{}`", name(self, last), name(self, start));
        let mut found = Diagnostic::new("E0702", "import cycle").primary(id, span, closes);
        for at in start + 1..self.open.len().min(start + 9) {
            let text = format!("`{}` imports `{}`", name(self, at - 1), name(self, at));
            found = found.label(id, self.open[at].1, text);
        }
        let help = match start == last {
            true => "remove it: a file knows its own names",
            false => "move what both need into a third file",
        };
        self.report(found.help(help));
    }
}
