//! A tree to a [`Scene`]: names, values, nodes, and what is wrong with them.
//!
//! ```
//! use kinora_lang::eval::{Overrides, eval};
//! use kinora_lang::files::Memory;
//! use kinora_lang::source::{FileId, Source};
//!
//! let text = "lang 1\ncamera main { position: (0, 0, 4) }\nsphere ball { radius: 50cm }\nsky { color: #fff }";
//! let tree = kinora_lang::parse(&Source::new(FileId(0), "ball.kin", text));
//! let evaluated = eval(&tree, &Memory::default(), &Overrides::default()).unwrap();
//! assert_eq!(evaluated.scene.nodes[0].name, "ball");
//! ```

pub mod coerce;
pub mod curve;
pub mod expr;
pub mod graph;
pub mod items;
pub mod keys;
pub mod limits;
pub mod machine;
mod origin;
mod params;
mod resolve;
pub mod scope;
pub mod shared;
pub mod surface;
mod watch;

use std::rc::Rc;
use std::sync::{Arc, mpsc};

use kinora_scene::Scene;

use crate::assets;
use crate::claims;
use crate::diagnostic::{self, Diagnostic};
use crate::files::{Dependency, Files};
use crate::lower::{Lowered, Places, lower};
use crate::modules::{self, Module, Modules};
use crate::schema;
use crate::source::{FileId, Source, Span};
use crate::syntax::{Tree, ast};
use crate::value::NodeId;
use machine::Machine;
pub use params::{Param, Plain};
pub use resolve::{Symbol, Use, Uses, uses};
use scope::{Binding, Scope};
pub use watch::{Amount, Moving, Watched, values_at};

/// What the command line says about a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// `-D name=value`: the parameter's name and its value, in the scene's own syntax.
    pub params: Vec<(String, String)>,
    /// `--set render.max_bounces=2`: a property of the `render` block or of a named node, and its value.
    pub sets: Vec<(String, String)>,
    /// `--camera NAME`
    pub camera: Option<String>,
    /// `--no-assets`: meshes, models and pictures are not opened, and the scene lacks them.
    pub no_assets: bool,
    /// Bytes that the machine has for the scene; at least 8 GiB are taken to be there.
    pub memory: Option<u64>,
}

/// What comes of a scene without errors.
#[derive(Debug, Clone)]
pub struct Evaluated {
    /// The scene.
    pub scene: Scene,
    /// What may not be as it was meant.
    pub warnings: Vec<Diagnostic>,
    /// The file's parameters.
    pub params: Vec<Param>,
    /// Every file that was asked for, found or not.
    pub dependencies: Vec<Dependency>,
    /// Where the parts of the scene are written.
    pub places: Places<(FileId, Span)>,
}

/// Evaluates a tree.
///
/// # Errors
/// Everything that is wrong, syntax errors included, with the warnings, in the order of the text; at least one of them
/// is an error.
pub fn eval(tree: &Tree, files: &dyn Files, overrides: &Overrides) -> Result<Evaluated, Vec<Diagnostic>> {
    eval_project(tree, files, overrides).0
}

/// As [`eval`], and the texts that the diagnostics point into: the tree's own first, then what it imports, numbered from
/// the tree's number up.
pub fn eval_project(
    tree: &Tree,
    files: &dyn Files,
    overrides: &Overrides,
) -> (Result<Evaluated, Vec<Diagnostic>>, Vec<Source>) {
    let modules = Arc::new(modules::load(tree, files));
    (eval_modules(&modules, files, overrides), modules.sources())
}

fn eval_modules(
    modules: &Arc<Modules>,
    files: &dyn Files,
    overrides: &Overrides,
) -> Result<Evaluated, Vec<Diagnostic>> {
    let (give, done) = mpsc::channel();
    let (its_modules, its_overrides) = (modules.clone(), overrides.clone());
    // The scene is given before what led to it is taken down.
    let spawned = thread("eval").spawn(move || evaluate(&its_modules, &its_overrides, &Nothing::new(), &give));
    let ended = |what: String| (None, vec![internal(&what)], Vec::new());
    let (lowered, mut diagnostics, params) = match spawned {
        Ok(_) => done.recv().unwrap_or_else(|_| ended("evaluation ended early".into())),
        Err(error) => ended(format!("no thread: {error}")),
    };
    let mut lowered = lowered;
    if let Some(lowered) = lowered.as_mut().filter(|_| !overrides.no_assets) {
        assets::load_meshes(lowered, files, &modules.texts, &mut diagnostics);
        assets::load_textures(lowered, files, &modules.texts, &mut diagnostics);
        assets::load_sky(lowered, files, &modules.texts, &mut diagnostics);
        assets::load_models(lowered, files, &modules.texts, &mut diagnostics);
        let limit = overrides.memory.unwrap_or_default().max(limits::MEMORY);
        diagnostics.extend(assets::memory::judge(lowered, &modules.texts, limit));
    }
    for found in &mut diagnostics {
        modules.texts.settle(found);
        modules.explain(found);
    }
    let sources = modules.sources();
    diagnostic::without_derived(&mut diagnostics, &modules.diagnostics, &sources);
    diagnostics.extend(modules.diagnostics.iter().cloned());
    diagnostics.extend(sources.iter().flat_map(claims::misread));
    diagnostics = diagnostic::honour(diagnostics, &sources);
    diagnostic::sort(&mut diagnostics);
    let failed = diagnostics.iter().any(Diagnostic::is_error);
    match lowered {
        Some(Lowered { scene, places, .. }) if !failed => {
            let (dependencies, places) = (files.dependencies(), places.settled(&modules.texts));
            Ok(Evaluated { scene, warnings: diagnostics, params, dependencies, places })
        }
        _ if failed => Err(diagnostics),
        _ => {
            diagnostics.push(internal("evaluation gave no scene"));
            Err(diagnostics)
        }
    }
}

/// A thread with a stack of its own, so that the depth of what it does does not hang on who calls.
fn thread(name: &str) -> std::thread::Builder {
    std::thread::Builder::new().name(name.into()).stack_size(limits::STACK_BYTES)
}

/// E1007.
fn internal(what: &str) -> Diagnostic {
    Diagnostic::new("E1007", "this is a bug in the tool")
        .note(what)
        .help("please report it, with the scene that shows it")
}

type Done = (Option<Lowered>, Vec<Diagnostic>, Vec<Param>);

/// What is nowhere written: an empty `render` block and a missing value, for what only the command line says, and what
/// stands for mixes of materials.
struct Nothing {
    render: ast::Node,
    mix: ast::Node,
    value: ast::Expr,
}

impl Nothing {
    fn new() -> Nothing {
        let span = Span::at(0);
        let node = |kind: &str| {
            let name = ast::Name { text: kind.into(), span, quoted: false };
            let kind = ast::Path { segments: vec![name], span };
            ast::Node { docs: None, kind, name: None, like: None, body: None, span }
        };
        let value = ast::Expr { kind: ast::ExprKind::Missing, span };
        Nothing { render: node("render"), mix: node(schema::MIX.name), value }
    }
}

fn evaluate(modules: &Modules, overrides: &Overrides, nothing: &Nothing, give: &mpsc::Sender<Done>) {
    // Names are judged beside the evaluation, which takes them as they are.
    std::thread::scope(|scope| {
        let done = match thread("names").spawn_scoped(scope, || resolve::resolve(modules)) {
            Ok(names) => {
                let resolved = || names.join().unwrap_or_else(|_| vec![internal("names were not resolved")]);
                return run(modules, overrides, nothing, resolved, give);
            }
            Err(error) => (None, vec![internal(&format!("no thread: {error}"))], Vec::new()),
        };
        let _ = give.send(done);
    });
}

fn run<'a>(
    modules: &'a Modules,
    overrides: &Overrides,
    nothing: &'a Nothing,
    resolved: impl FnOnce() -> Vec<Diagnostic>,
    give: &mpsc::Sender<Done>,
) {
    let whole = !modules.diagnostics.iter().any(Diagnostic::is_error);
    let mut machine = Machine::new(&modules.texts, &nothing.mix);
    let Some((roots, params)) = compute(modules, overrides, nothing, &mut machine) else { return };
    let resolved = resolved();
    let known = !resolved.iter().any(Diagnostic::is_error);
    let lowered = match machine.stopped {
        true => None,
        false => lower(&mut machine, &roots, overrides.camera.as_deref(), whole && known),
    };
    let mut diagnostics = resolved;
    diagnostics.append(&mut machine.diagnostics);
    // Nobody waits for it only where the caller is gone.
    let _ = give.send((lowered, diagnostics, params));
}

/// Computes everything that is written; the nodes at the top of the scene, and its parameters.
fn compute<'a>(
    modules: &'a Modules,
    overrides: &Overrides,
    nothing: &'a Nothing,
    machine: &mut Machine<'a>,
) -> Option<(Vec<NodeId>, Vec<Param>)> {
    let (own, imported) = modules.list.split_first()?;
    let file = &own.file;
    machine.render = file.items.iter().find_map(|item| match item {
        ast::Item::Node(node) if items::kind_text(node) == "render" => Some(node),
        _ => None,
    });
    machine.fps = params::set_number(overrides, "render.fps").map(Some);
    machine.library = resolve::is_library(&file.items);
    let globals = machine.globals.clone();
    let scopes: Vec<Rc<Scope<'a>>> =
        std::iter::once(globals.clone()).chain(imported.iter().map(|_| Rc::default())).collect();
    for (module, scope) in modules.list.iter().zip(&scopes) {
        import(module, scope, &scopes);
    }
    let all = params::known(modules, &scopes);
    params::check_overrides(machine, &all, overrides);
    for (module, scope) in modules.list.iter().zip(&scopes) {
        params::declare(machine, &module.file, scope, &all, overrides);
        machine.hoist(&module.file.items, scope);
    }
    let params = params::list(machine, &all, overrides);
    let (mut properties, mut roots) = (Vec::new(), Vec::new());
    let mut owner = items::Owner { kind: None, properties: &mut properties, children: &mut roots };
    machine.run(&file.items, &globals, &mut owner);
    // What an imported file shows is checked, but stands in no scene.
    for (module, scope) in imported.iter().zip(scopes.iter().skip(1)) {
        let (mut properties, mut nowhere) = (Vec::new(), Vec::new());
        let mut owner = items::Owner { kind: None, properties: &mut properties, children: &mut nowhere };
        machine.run(&module.file.items, scope, &mut owner);
    }
    if let Some(render) = machine.slot(&nothing.render, &globals) {
        params::apply_sets(machine, &mut roots, overrides, render, &nothing.value);
    }
    Some((roots, params))
}

/// Declares what a file's imports bring, before anything of its own.
fn import<'a>(module: &'a Module, scope: &Rc<Scope<'a>>, scopes: &[Rc<Scope<'a>>]) {
    for (import, to) in module.imports() {
        let to = to.and_then(|to| scopes.get(to));
        for rename in import.names.iter().flatten() {
            let binding = to.map_or(Binding::Opaque, |to| Binding::Import(to.clone(), &rename.name.text));
            scope.declare(&rename.alias.as_ref().unwrap_or(&rename.name).text, binding);
        }
        if let Some(alias) = &import.alias {
            scope.declare(&alias.text, to.map_or(Binding::Opaque, |to| Binding::Module(to.clone())));
        }
    }
}
