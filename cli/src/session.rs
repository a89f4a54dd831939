//! The one place where the crates meet: a path and the changes of the command line become a scene with its findings, a
//! scene and a shutter a world. Every command and the viewer go through here.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

#[cfg(feature = "physics")]
use kinora_animator::physics::BakeError;
use kinora_animator::{Fault, Place, SampleError};
use kinora_lang::assets::cache::Cache;
use kinora_lang::diagnostic::{Diagnostic, Level, Levels, MAX_SHOWN, levels_of_project, list};
use kinora_lang::files::{self, FileError, Files, Folder, PROJECT};
use kinora_lang::lower::Places;
use kinora_lang::source::{FileId, Source, Span, decode};
use kinora_lang::syntax::ast::{Block, Item};
use kinora_lang::syntax::{Part, SyntaxKind};
use kinora_lang::{Evaluated, Overrides, Param, Tree, library};
use kinora_scene::{Scene, Shutter, World};

use crate::{exit, report, terminal};

/// A fault of the program, not of the scene.
const INTERNAL: &str = "E1007";

/// What the command line changes in a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Values of `param`s: name and text.
    pub params: Vec<(String, String)>,
    /// Properties: `node.property` and text.
    pub sets: Vec<(String, String)>,
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// Samples a pixel.
    pub samples: Option<u32>,
    /// Seed of the noise.
    pub seed: Option<u32>,
    /// Name of the camera.
    pub camera: Option<String>,
    /// Leave meshes, models and pictures unopened.
    pub no_assets: bool,
    /// How warnings are taken, whatever the project says.
    pub levels: Levels,
    /// Where bodies are is taken as it is kept, and never computed.
    pub frozen_bake: bool,
    /// What is kept of a reading for the next.
    pub kept: Kept,
    /// Texts that an editor has open, by absolute path: they count instead of what is on the disk.
    pub open: Arc<BTreeMap<PathBuf, Arc<[u8]>>>,
}

/// What was made of meshes, models and pictures, if whoever reads scenes again and again keeps it. It changes nothing in
/// what is read.
#[derive(Clone, Debug, Default)]
pub struct Kept(pub Option<Arc<Cache>>);

impl PartialEq for Kept {
    fn eq(&self, _: &Kept) -> bool {
        true
    }
}

impl Eq for Kept {}

/// What comes of loading a scene.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene; `None` where a finding is an error.
    pub scene: Option<Arc<Scene>>,
    /// Its parameters.
    pub params: Vec<Param>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that the diagnostics point into, named as in the project.
    pub sources: Vec<Source>,
    /// Every file that was asked for, found or not, the scene itself first. Absolute.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "only the viewer watches files"))]
    pub dependencies: Vec<PathBuf>,
    /// How its warnings are taken. Those that are not shown are not among the diagnostics.
    pub levels: Levels,
    /// As [`Changes::frozen_bake`].
    #[cfg_attr(not(feature = "physics"), expect(dead_code, reason = "only a simulation is kept"))]
    pub frozen_bake: bool,
    /// The file in which it is kept where its bodies are, if they move. Absolute.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "only the viewer watches files"))]
    pub bake: Option<PathBuf>,
    /// How long it took to parse the scene's own text, and to evaluate it with all that it uses.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "only the viewer tells of it"))]
    pub times: [Duration; 2],
    /// Where the parts of the scene are written.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "only the viewer looks for them"))]
    pub places: Places<(FileId, Span)>,
    tree: Tree,
    path: PathBuf,
    root: PathBuf,
}

/// Reads, parses and evaluates the scene at `path`.
///
/// # Errors
/// The file itself cannot be read. What is wrong inside it is a finding.
pub fn load(path: &Path, changes: &Changes) -> Result<Loaded, String> {
    load_as(FileId::default(), path, changes)
}

/// As [`load`], with the number that its findings carry.
pub fn load_as(id: FileId, path: &Path, changes: &Changes) -> Result<Loaded, String> {
    let (mut folder, name) = project(path)?;
    if let Kept(Some(cache)) = &changes.kept {
        cache.begin();
        folder = folder.with_cache(cache.clone());
    }
    if !changes.open.is_empty() {
        folder = folder.with_open(&changes.open);
    }
    match files::load(&folder, id, &name) {
        Ok(files::Loaded { source, error }) => Ok(evaluate(source, error, folder, path, changes)),
        Err(error @ FileError::TooLarge { .. }) => {
            let source = Source::new(id, name, "");
            let found = error.diagnostic(id, Span::default());
            Ok(evaluate(source, Some(found), folder, path, changes))
        }
        Err(FileError::Missing { .. }) => Err(format!("there is no file `{}`", path.display())),
        Err(FileError::Unreadable { reason, .. }) => Err(format!("cannot read `{}`: {reason}", path.display())),
        Err(error) => Err(error.message()),
    }
}

/// As [`load_as`], of a text that is not saved: `path` says where its files are looked for.
pub fn load_bytes(id: FileId, path: &Path, bytes: &[u8], changes: &Changes) -> Result<Loaded, String> {
    let (folder, name) = project(path)?;
    let (source, error) = decode(id, &name, bytes);
    Ok(evaluate(source, error, folder, path, changes))
}

/// The project that a file belongs to, and the path of the file in it.
///
/// # Errors
/// The folder is not there or cannot be read.
pub fn project(path: &Path) -> Result<(Folder, String), String> {
    Folder::of(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("there is no file `{}`", path.display()),
        _ => format!("cannot read `{}`: {error}", path.display()),
    })
}

// `error` is what makes the text not worth evaluating.
fn evaluate(source: Source, error: Option<Diagnostic>, folder: Folder, path: &Path, changes: &Changes) -> Loaded {
    let start = Instant::now();
    let tree = kinora_lang::parse(&source);
    let parse = start.elapsed();
    let Changes { params, sets, camera, no_assets, .. } = changes.clone();
    #[cfg(feature = "render")]
    let memory = crate::memory::free_bytes();
    #[cfg(not(feature = "render"))]
    let memory = None;
    let overrides = Overrides { params, sets, camera, no_assets, memory };
    let (evaluated, mut sources) = match error {
        Some(error) => (Err(vec![error]), vec![source.clone()]),
        None => kinora_lang::eval_project(&tree, &folder, &overrides),
    };
    let (mut scene, mut diagnostics, params, places) = match evaluated {
        Ok(Evaluated { scene, warnings, params, places, .. }) => (Some(scene), warnings, params, places),
        Err(diagnostics) => (None, diagnostics, Vec::new(), Places::default()),
    };
    if let Some(scene) = &mut scene {
        changes.apply(scene);
    }
    let next = FileId(source.id.0 + sources.len() as u32);
    let (levels, mut of_project) = levels(&folder, next, &mut sources);
    if of_project.iter().any(Diagnostic::is_error) {
        scene = None;
    }
    diagnostics.append(&mut of_project);
    let levels = levels.then(&changes.levels);
    diagnostics.retain(|found| found.is_error() || levels.level(found.code) != Level::Allow);
    let evaluate = start.elapsed() - parse;
    let root = folder.root();
    let others = folder.dependencies().into_iter().filter(|found| *found.path != *source.name);
    let others = others.map(|found| root.join(&found.path));
    let bake = scene.as_ref().filter(|scene| scene.physics.is_dynamic());
    let bake = bake.map(|scene| root.join(&scene.physics.simulation.bake));
    let dependencies = std::iter::once(root.join(&*source.name)).chain(others).chain(bake.clone()).collect();
    let (scene, path) = (scene.map(Arc::new), path.to_path_buf());
    let (root, frozen_bake) = (root.to_path_buf(), changes.frozen_bake);
    Loaded {
        scene,
        params,
        diagnostics,
        sources,
        dependencies,
        levels,
        frozen_bake,
        bake,
        places,
        times: [parse, evaluate],
        tree,
        path,
        root,
    }
}

/// How the project takes warnings, and what is wrong with its file, which then is one of the texts.
fn levels(folder: &Folder, id: FileId, sources: &mut Vec<Source>) -> (Levels, Vec<Diagnostic>) {
    const MOST_BYTES: u64 = 1 << 20;
    let (source, error) = match folder.read_at_most(PROJECT, MOST_BYTES) {
        Ok(bytes) => decode(id, PROJECT, &bytes),
        Err(FileError::Missing { .. }) => return Default::default(),
        Err(error) => {
            let source = Source::new(id, PROJECT, "");
            let found = error.diagnostic(id, Span::default());
            (source, Some(found))
        }
    };
    let (levels, wrong) = match error {
        Some(error) => (Levels::default(), vec![error]),
        None => levels_of_project(&source),
    };
    sources.push(source);
    (levels, wrong)
}

impl Changes {
    fn apply(&self, scene: &mut Scene) {
        let render = &mut scene.render;
        render.resolution = self.size.unwrap_or(render.resolution);
        render.samples = self.samples.unwrap_or(render.samples);
        render.seed = self.seed.unwrap_or(render.seed);
    }
}

impl Loaded {
    /// The scene while the shutter is open.
    ///
    /// # Errors
    /// There is no scene, or a value has no use at that time.
    pub fn sample(&self, shutter: Shutter) -> Result<World, Box<Diagnostic>> {
        self.sample_with(kinora_animator::sample, shutter)
    }

    /// As [`Loaded::sample`], with where all of it is at the next frame if `moving`.
    ///
    /// # Errors
    /// As [`Loaded::sample`], also at the next frame.
    #[cfg(feature = "render")]
    pub fn sample_moving(&self, shutter: Shutter, moving: bool) -> Result<World, Box<Diagnostic>> {
        let sample = if moving { kinora_animator::sample_moving } else { kinora_animator::sample };
        self.sample_with(sample, shutter)
    }

    fn sample_with(
        &self,
        sample: fn(&Scene, Shutter) -> Result<World, SampleError>,
        shutter: Shutter,
    ) -> Result<World, Box<Diagnostic>> {
        let scene = self.scene.as_deref().ok_or_else(|| Box::new(no_scene()))?;
        sample(scene, shutter).map_err(|error| Box::new(self.fault(&error)))
    }

    /// The project's folder.
    #[cfg(feature = "physics")]
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Where the node of this name, or of this kind, sets a property, else where it stands: in the scene's file, or else in one
    /// that it imports.
    pub fn node_place(&self, name: &str, property: &str) -> Option<(FileId, Span)> {
        let own = place_of(&self.tree.file().items, name, property).map(|span| (self.tree.source.id, span));
        own.or_else(|| {
            let imported = self.sources.iter().filter(|source| source.id != self.tree.source.id);
            imported.filter(|source| source.name.ends_with(".kin") || library::is_path(&source.name)).find_map(
                |source| {
                    place_of(&kinora_lang::parse(source).file().items, name, property).map(|span| (source.id, span))
                },
            )
        })
    }

    /// Why there is no bake, as a finding.
    #[cfg(feature = "physics")]
    pub fn bake_fault(&self, error: &BakeError) -> Diagnostic {
        let message = error.to_string();
        let (found, place) = match error {
            BakeError::Sample(error) => return self.fault(error),
            BakeError::Shapeless { name, .. } => {
                let found = Diagnostic::new("E0902", message).help("write `collider: convex_hull`, or `kind: fixed`");
                (found, self.node_place(name, ""))
            }
            BakeError::BlewUp { name, .. } => {
                let help = "raise the `rate` of the `simulation`, and look for bodies that overlap at the start";
                (Diagnostic::new("E0905", message).help(help), self.node_place(name, ""))
            }
            BakeError::TooLarge { .. } => {
                let found = Diagnostic::new("E1004", message).help("lower the `rate` or the `duration`");
                (found, self.simulation_place())
            }
            BakeError::Stale { .. } => {
                (Diagnostic::new("E0906", message).help("run `kinora bake`"), self.simulation_place())
            }
            BakeError::Stopped => (Diagnostic::new(INTERNAL, message), None),
        };
        match place {
            Some((file, span)) => found.primary(file, span, ""),
            None => found,
        }
    }

    /// Where the scene says how it is simulated: the file of the bake, if it does.
    #[cfg(feature = "physics")]
    fn simulation_place(&self) -> Option<(FileId, Span)> {
        let node = self.tree.file().items.iter().find_map(|item| match item {
            Item::Node(node) => node.kind.segments.last().filter(|kind| &*kind.text == "simulation").map(|_| node),
            _ => None,
        })?;
        let set = node.body.iter().flat_map(|block| &block.items).find_map(|item| match item {
            Item::Property(set) if &*set.name.text == "bake" => Some(set.span),
            _ => None,
        });
        Some((self.tree.source.id, set.unwrap_or(node.kind.span)))
    }

    /// Puts bodies where they are at all times, before anything is sampled. The exit code where there is no going on.
    ///
    /// # Errors
    /// The program cannot do it.
    #[cfg(feature = "render")]
    pub fn with_bodies(&mut self, quiet: bool, stop: &dyn Fn() -> Option<u8>) -> Result<Option<u8>, String> {
        #[cfg(feature = "physics")]
        match self.bake(&crate::bake::Baking { quiet, stop, told: &|_| () }) {
            Ok(baked) => {
                // The picture is none the worse for it.
                if let Some(why) = baked.and_then(|baked| baked.bake.not_kept) {
                    terminal::err(&format!("{why}: the next time bodies are computed anew\n"));
                }
                Ok(None)
            }
            Err(end) => Ok(Some(end.finish(self))),
        }
        #[cfg(not(feature = "physics"))]
        {
            let _ = (quiet, stop);
            match self.scene.as_ref().is_some_and(|scene| scene.physics.is_dynamic()) {
                true => Err("this program was built without `physics`, and forces move bodies of the scene".into()),
                false => Ok(None),
            }
        }
    }

    /// The texts named as the user named the scene, and what it imports in the same way: so that an editor finds them.
    pub fn sources_as_given(&self) -> Vec<Source> {
        let mut sources = self.sources.clone();
        let Some((own, imported)) = sources.split_first_mut() else { return sources };
        let given = self.path.to_string_lossy().replace('\\', "/");
        let before = given.strip_suffix(&*own.name).filter(|before| before.is_empty() || before.ends_with('/'));
        for source in imported.iter_mut().filter(|source| !library::is_path(&source.name)) {
            source.name = match before {
                Some(before) => format!("{before}{}", source.name).into(),
                None => self.seen_from_here(&source.name).into(),
            };
        }
        own.name = self.path.to_string_lossy().into();
        sources
    }

    /// The scene's own text as a tree.
    #[cfg(feature = "viewer")]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The file on the disk that a text comes from; `None` where it comes from nowhere.
    pub fn path_of(&self, id: FileId) -> Option<PathBuf> {
        let (own, others) = self.sources.split_first()?;
        match own.id == id {
            true => Some(self.path.clone()),
            false => others.iter().find(|source| source.id == id).map(|source| self.root.join(&*source.name)),
        }
    }

    /// Whether a camera is written in the scene's own text, in a group or not.
    pub fn has_camera(&self) -> bool {
        fn among(items: &[Item]) -> bool {
            items.iter().any(|item| match item {
                Item::Node(node) => {
                    let kind = node.kind.segments.last().map_or("", |kind| &kind.text);
                    kind == "camera" || node.body.as_ref().is_some_and(|body| among(&body.items))
                }
                _ => false,
            })
        }
        among(&self.tree.file().items)
    }

    /// A path of the project, from the current folder where it lies below that.
    fn seen_from_here(&self, name: &str) -> String {
        let path = self.root.join(name);
        let here = std::env::current_dir().and_then(|here| here.canonicalize());
        let below = here.ok().and_then(|here| path.strip_prefix(here).ok().map(Path::to_path_buf));
        below.unwrap_or(path).to_string_lossy().into_owned()
    }

    /// Findings as text for a terminal, in colour.
    pub fn show(&self, found: &[Diagnostic]) -> String {
        report::full(&list(found.to_vec(), MAX_SHOWN), &self.sources_as_given())
    }

    /// One finding as text without colour.
    #[cfg(feature = "render")]
    pub fn plain(&self, found: &Diagnostic) -> String {
        report::plain(found, &self.sources_as_given())
    }

    /// The exit code where there is no scene.
    pub fn fault_code(&self) -> u8 {
        let internal = self.diagnostics.iter().any(|found| found.code == INTERNAL);
        if internal { exit::FAILED } else { exit::FINDINGS }
    }

    /// Prints every finding.
    pub fn report(&self) {
        terminal::err(&self.show(&self.diagnostics));
    }

    /// Prints one more.
    #[cfg(any(feature = "render", feature = "physics"))]
    pub fn report_one(&self, found: &Diagnostic) {
        terminal::err(&self.show(std::slice::from_ref(found)));
    }

    fn fault(&self, error: &SampleError) -> Diagnostic {
        let code = match (error.fault, error.property) {
            (Fault::NotFinite, _) => "E0403",
            (Fault::OutsideKeys, _) => "E0614",
            (Fault::OutOfRange { .. }, "ior") => "E0406",
            (Fault::OutOfRange { .. }, "color" | "edge_tint" | "tint" | "roughness" | "attenuation_color")
                if !matches!(error.place, Place::Sky | Place::Light(_)) =>
            {
                "E0407"
            }
            (Fault::OutOfRange { .. }, "fov") => "E0408",
            (Fault::OutOfRange { .. }, _) => "E0401",
            (Fault::Singular, _) => "E0404",
            (Fault::AimedAtItself | Fault::UpAlongView | Fault::NoDirection, _) => "E0405",
            (Fault::NoFocus, _) => "E0207",
            (Fault::NoCamera, _) => "E0501",
            (Fault::Dangling, _) => INTERNAL,
        };
        let found = Diagnostic::new(code, error.to_string());
        let name = match (error.place, &*error.name) {
            (Place::Sky, _) => "sky",
            (Place::Render, _) => "render",
            (_, name) => name,
        };
        match self.node_place(name, error.property) {
            Some((file, span)) => {
                let label = match error.fault {
                    Fault::OutOfRange { value, .. } => format!("comes to {value}"),
                    Fault::NotFinite => "comes to no number".to_string(),
                    _ => String::new(),
                };
                let mut found = found.primary(file, span, label);
                if file == self.tree.source.id {
                    self.note_lets(span, &mut found);
                }
                found
            }
            None => found,
        }
    }

    /// Notes of the values at the top of the scene that a text names, and of those that these name.
    fn note_lets(&self, span: Span, found: &mut Diagnostic) {
        /// More of them are not read.
        const MOST: usize = 4;
        let source = &self.tree.source;
        let lets = self.tree.file().items.iter().filter_map(|item| match item {
            Item::Let(decl) => Some((&*decl.name.as_ref()?.text, decl.value.span)),
            _ => None,
        });
        let lets: Vec<(&str, Span)> = lets.collect();
        let names: Vec<Part<'_>> = self.tree.root().tokens().filter(|part| part.kind() == SyntaxKind::Path).collect();
        let (mut open, mut noted) = (vec![span], Vec::new());
        while let Some(span) = open.pop() {
            let inside = names.iter().map(|part| (part.span(), part.text()));
            let inside = inside.filter(|(name, _)| span.start <= name.start && name.end <= span.end);
            for (_, path) in inside {
                let word = path.split('.').next().unwrap_or(path).trim_end();
                let Some((name, value)) = lets.iter().find(|(name, _)| *name == word) else { continue };
                if noted.contains(name) || noted.len() >= MOST {
                    continue;
                }
                noted.push(name);
                open.push(*value);
                let (text, line) = (source.slice(*value), source.line_index(value.start) + 1);
                if text.len() < 80 && !text.contains('\n') {
                    found.notes.push(format!("`{name}` is `{text}`, line {line}"));
                } else {
                    found.notes.push(format!("`{name}` is computed on line {line}"));
                }
            }
        }
    }
}

fn no_scene() -> Diagnostic {
    Diagnostic::new("E0503", "there is no scene to show")
}

/// What the renderer cannot hold, as a finding.
#[cfg(feature = "render")]
pub fn too_large(error: &kinora_renderer::PackError) -> Diagnostic {
    use kinora_renderer::PackError;
    let code = match error {
        PackError::Coordinates { .. } | PackError::Camera => "E0401",
        PackError::TooMany { .. }
        | PackError::TooDeep { .. }
        | PackError::Words { .. }
        | PackError::Copies { .. }
        | PackError::Materials { .. }
        | PackError::Records { .. }
        | PackError::Emitters { .. }
        | PackError::CutOuts { .. }
        | PackError::Tape { .. }
        | PackError::Textures { .. } => "E1004",
        PackError::Texels { .. } => "E0807",
    };
    Diagnostic::new(code, error.to_string())
}

/// Where the node called `name` (or of that kind, without a name) sets the property, else where the node stands.
fn place_of(items: &[Item], name: &str, property: &str) -> Option<Span> {
    let inside = |block: &Option<Block>| block.as_ref().and_then(|block| place_of(&block.items, name, property));
    items.iter().find_map(|item| match item {
        Item::Node(node) => {
            let called = node.name.as_ref().or(node.kind.segments.last());
            if called.is_none_or(|called| &*called.text != name) {
                return inside(&node.body);
            }
            let set = node.body.iter().flat_map(|block| &block.items).find_map(|item| match item {
                Item::Property(set) if &*set.name.text == property => Some(set.value.span),
                _ => None,
            });
            set.or(called.map(|called| called.span))
        }
        Item::For(turns) => inside(&turns.body),
        Item::Prefab(prefab) => inside(&prefab.body),
        _ => None,
    })
}
