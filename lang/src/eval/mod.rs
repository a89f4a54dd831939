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
pub mod expr;
pub mod graph;
pub mod items;
pub mod keys;
pub mod limits;
pub mod machine;
mod params;
mod resolve;
pub mod scope;

use kinora_scene::Scene;

use crate::assets;
use crate::diagnostic::{self, Diagnostic};
use crate::files::{Dependency, Files};
use crate::lower::{Lowered, lower};
use crate::schema;
use crate::source::{Source, Span};
use crate::syntax::{Tree, ast};
use machine::Machine;
pub use params::Param;

/// What the command line says about a scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// `-D name=value`: the parameter's name and its value, in the scene's own syntax.
    pub params: Vec<(String, String)>,
    /// `--set render.max_bounces=2`: a property of the `render` block or of a named node, and its value.
    pub sets: Vec<(String, String)>,
    /// `--camera NAME`
    pub camera: Option<String>,
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
}

/// Evaluates a tree.
///
/// # Errors
/// Everything that is wrong, syntax errors included, with the warnings, in the order of the text; at least one of them
/// is an error.
pub fn eval(tree: &Tree, files: &dyn Files, overrides: &Overrides) -> Result<Evaluated, Vec<Diagnostic>> {
    let file = tree.file();
    let source = &tree.source;
    // The stack of the evaluation is its own, so that its depth does not hang on who calls.
    let nothing = Nothing::new();
    let run = || evaluate(&file, source, tree.errors(), overrides, &nothing);
    let (lowered, mut diagnostics, params, imports) = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().name("eval".into()).stack_size(limits::STACK_BYTES);
        match thread.spawn_scoped(scope, run).map(std::thread::ScopedJoinHandle::join) {
            Ok(Ok(done)) => done,
            Ok(Err(_)) => (None, vec![internal("evaluation ended early")], Vec::new(), Vec::new()),
            Err(error) => (None, vec![internal(&format!("no thread: {error}"))], Vec::new(), Vec::new()),
        }
    });
    for (path, span) in imports {
        diagnostics.push(assets::import(files, source, &path, span));
    }
    let mut lowered = lowered;
    if let Some(lowered) = &mut lowered {
        assets::load_meshes(lowered, files, source, &mut diagnostics);
        assets::load_models(lowered, files, source, &mut diagnostics);
    }
    let mut diagnostics = diagnostic::list(diagnostics, usize::MAX).shown;
    let failed = diagnostics.iter().any(Diagnostic::is_error);
    match lowered {
        Some(Lowered { scene, .. }) if !failed => {
            Ok(Evaluated { scene, warnings: diagnostics, params, dependencies: files.dependencies() })
        }
        _ if failed => Err(diagnostics),
        _ => {
            diagnostics.push(internal("evaluation gave no scene"));
            Err(diagnostics)
        }
    }
}

/// E1007.
fn internal(what: &str) -> Diagnostic {
    Diagnostic::new("E1007", "this is a bug in the tool")
        .note(what)
        .help("please report it, with the scene that shows it")
}

type Done = (Option<Lowered>, Vec<Diagnostic>, Vec<Param>, Vec<(String, Span)>);

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

fn evaluate<'a>(
    file: &'a ast::File,
    source: &'a Source,
    errors: &[Diagnostic],
    overrides: &Overrides,
    nothing: &'a Nothing,
) -> Done {
    let whole = !errors.iter().any(Diagnostic::is_error);
    let mut machine = Machine::new(source, &nothing.mix);
    let resolved = resolve::resolve(file, source);
    let known = !resolved.iter().any(Diagnostic::is_error);
    machine.render = file.items.iter().find_map(|item| match item {
        ast::Item::Node(node) if items::kind_text(node) == "render" => Some(node),
        _ => None,
    });
    machine.fps = params::set_number(overrides, "render.fps").map(Some);
    let globals = machine.globals.clone();
    params::check_overrides(&mut machine, file, overrides);
    params::declare(&mut machine, file, overrides);
    machine.hoist(&file.items, &globals);
    let params = params::list(&mut machine, file, overrides);
    let (mut properties, mut roots) = (Vec::new(), Vec::new());
    let mut owner = items::Owner { kind: None, properties: &mut properties, children: &mut roots };
    machine.run(&file.items, &globals, &mut owner);
    if let Some(render) = machine.slot(&nothing.render, &globals) {
        params::apply_sets(&mut machine, &mut roots, overrides, render, &nothing.value);
    }
    let lowered = match machine.stopped {
        true => None,
        false => lower(&mut machine, &roots, overrides.camera.as_deref(), whole && known),
    };
    let mut diagnostics = errors.to_vec();
    diagnostics.extend(resolved);
    diagnostics.append(&mut machine.diagnostics);
    let imports = file.items.iter().filter_map(|item| match item {
        ast::Item::Import(import) => import.path.as_ref().map(|path| (path.text.to_string(), path.span)),
        _ => None,
    });
    (lowered, diagnostics, params, imports.collect())
}
