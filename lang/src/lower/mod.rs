//! Evaluated nodes to a [`Scene`]: what has a place in it, in which order, and what only the whole scene can tell.

mod camera;
mod light;
mod material;
mod model;
mod physics;
mod place;
mod read;
mod render;
mod shape;
mod space;

use std::collections::{HashMap, HashSet};

use kinora_scene::{Animated, Clock, Light, LightKind, Look, Material, Node, Render, Scene, SkyLight, Tonemap};

use crate::diagnostic::{Applicability, Diagnostic};
use crate::eval::coerce::Data;
use crate::eval::items::kind_text;
use crate::eval::limits;
use crate::eval::machine::{Machine, NodeKind};
use crate::schema::{Since, Sort};
use crate::source::{FileId, Span, Texts};
use crate::suggest::suggest;
use crate::value::NodeId;

pub use light::SkyRequest;
use material::MadeOf;
pub use material::{TextureRequest, shining};
pub use model::{InnerRequest, InnerUse, ModelRequest};
pub use shape::{MeshFrom, MeshRequest};

/// A scene whose meshes are still to be read.
pub struct Lowered {
    /// The scene.
    pub scene: Scene,
    /// The meshes that come from files.
    pub meshes: Vec<MeshRequest>,
    /// The textures of its materials.
    pub textures: Vec<TextureRequest>,
    /// The picture of its sky.
    pub sky: Option<SkyRequest>,
    /// The models that come from files.
    pub models: Vec<ModelRequest>,
    /// What refers into them.
    pub inner: Vec<InnerRequest>,
    /// The camera that the command line asks for, where it may be one of a model.
    pub wanted: Option<String>,
    /// Something could not be read: nothing can be said about what is missing.
    pub unknown: bool,
    /// Where all that is written.
    pub places: Places,
}

/// Where the parts of a scene are written: the name of each, or its kind where it has none. What a model's file holds is
/// where the model is. One a part, in the scene's order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Places<P = Span> {
    /// Of the scene's nodes.
    pub nodes: Vec<P>,
    /// Of its cameras.
    pub cameras: Vec<P>,
    /// Of its lights.
    pub lights: Vec<P>,
}

impl Places {
    /// The same with the text that each place lies in.
    pub fn settled(&self, texts: &Texts) -> Places<(FileId, Span)> {
        let settle = |list: &Vec<Span>| list.iter().map(|span| texts.settled(*span)).collect();
        Places { nodes: settle(&self.nodes), cameras: settle(&self.cameras), lights: settle(&self.lights) }
    }
}

/// What a file's nodes are, sorted by what they are for.
#[derive(Default)]
struct Found {
    render: Vec<NodeId>,
    cameras: Vec<(NodeId, Option<usize>)>,
    skies: Vec<NodeId>,
    /// Suns and lamps with what they are written in.
    lights: Vec<(NodeId, Option<usize>)>,
    simulations: Vec<NodeId>,
    joints: Vec<NodeId>,
    /// Shapes, groups and named prefabs with what they are written in.
    placed: Vec<(NodeId, Option<usize>)>,
    /// The instances among them.
    instances: Vec<NodeId>,
    /// What is not in the scene but for its instances.
    only_copied: HashSet<NodeId>,
    /// Something could not be read: nothing can be said about what is missing.
    unknown: bool,
    /// How many nodes were met: what is copied by `like` may be met more often than it is written.
    met: usize,
    /// Where there were too many nodes, or too many inside one another.
    too_many: Option<NodeId>,
}

/// Everything that lowering needs at hand.
struct Lower<'m, 'a> {
    machine: &'m mut Machine<'a>,
    found: Found,
    /// Index in the scene's nodes by index in `found.placed`.
    order: Vec<usize>,
    first: HashMap<NodeId, usize>,
    materials: Vec<Material<Animated>>,
    /// One of each of `materials`.
    made_of: Vec<MadeOf>,
    known_materials: HashMap<Option<NodeId>, usize>,
    /// The materials that are being read, each inside the one before it.
    open_materials: Vec<NodeId>,
    meshes: Vec<MeshRequest>,
    textures: Vec<TextureRequest>,
    sky_picture: Option<SkyRequest>,
    models: Vec<ModelRequest>,
    inner: Vec<InnerRequest>,
    /// The nodes of the scene's lights, in their order.
    lamps: Vec<NodeId>,
}

/// The scene that `roots` make; none where it has too many nodes. Problems are reported to the machine; `whole` says that the text had no error before.
pub fn lower<'a>(machine: &mut Machine<'a>, roots: &[NodeId], camera: Option<&str>, whole: bool) -> Option<Lowered> {
    let mut found = Found { unknown: !whole, ..Found::default() };
    for id in roots {
        gather(machine, *id, None, 0, &mut found);
    }
    gather_copied(machine, &mut found);
    // A camera that is chosen is in the scene, wherever it is declared.
    if let Some(render) = found.render.first().and_then(|id| machine.done(*id))
        && let Some(id) = read::node(read::data(&render, "camera"))
        && found.cameras.iter().all(|(camera, _)| *camera != id)
    {
        found.cameras.push((id, None));
    }
    if let Some(id) = found.too_many {
        let span = machine.nodes.get(id.0 as usize).map_or(Span::at(0), |slot| slot.ast.kind.span);
        machine.too_many("nodes", limits::NODES, span);
        return None;
    }
    let mut lower = Lower {
        machine,
        found,
        order: Vec::new(),
        first: HashMap::new(),
        materials: Vec::new(),
        made_of: Vec::new(),
        known_materials: HashMap::new(),
        open_materials: Vec::new(),
        meshes: Vec::new(),
        textures: Vec::new(),
        sky_picture: None,
        models: Vec::new(),
        inner: Vec::new(),
        lamps: Vec::new(),
    };
    Some(lower.scene(camera))
}

fn gather(machine: &Machine<'_>, id: NodeId, parent: Option<usize>, depth: u32, found: &mut Found) {
    found.met += 1;
    if found.met > limits::NODES || depth > limits::GROUPS {
        found.too_many = found.too_many.or(Some(id));
    }
    if found.too_many.is_some() {
        return;
    }
    let Some(node) = machine.done(id) else {
        found.unknown = true;
        return;
    };
    let mut inner = parent;
    match node.kind {
        NodeKind::Unknown => found.unknown = true,
        NodeKind::Schema(kind) if kind.since != Since::Now => found.unknown = true,
        NodeKind::Schema(kind) => match kind.sort {
            Sort::Render => found.render.push(id),
            Sort::Camera => found.cameras.push((id, parent)),
            Sort::Sky => found.skies.push(id),
            Sort::Light => found.lights.push((id, parent)),
            Sort::Simulation => found.simulations.push(id),
            Sort::Joint => found.joints.push(id),
            Sort::Shape | Sort::Group => {
                inner = Some(found.placed.len());
                found.placed.push((id, parent));
                if kind.name == "instance" {
                    found.instances.push(id);
                }
            }
            _ => {}
        },
        NodeKind::Prefab(_) => {
            let named = machine.nodes.get(id.0 as usize).is_some_and(|slot| slot.ast.name.is_some());
            if named || found.only_copied.contains(&id) {
                inner = Some(found.placed.len());
                found.placed.push((id, parent));
            }
        }
    }
    for child in &node.children {
        gather(machine, *child, inner, depth + 1, found);
    }
}

/// What instances are of, where it is not in the scene already.
fn gather_copied(machine: &mut Machine<'_>, found: &mut Found) {
    let mut known: HashSet<NodeId> = found.placed.iter().map(|placed| placed.0).collect();
    let (mut next, mut from) = (0, found.placed.len());
    while let Some(id) = found.instances.get(next).copied() {
        next += 1;
        let of = machine.done(id).and_then(|node| match read::data(&node, "of") {
            Some(Data::Node(of) | Data::Inner(of, _)) => Some(*of),
            _ => None,
        });
        let Some(of) = of.filter(|of| !known.contains(of)) else { continue };
        machine.force(of);
        found.only_copied.insert(of);
        gather(machine, of, None, 0, found);
        known.extend(found.placed.iter().skip(from).map(|placed| placed.0));
        from = found.placed.len();
    }
}

impl<'a> Lower<'_, 'a> {
    fn scene(&mut self, camera: Option<&str>) -> Lowered {
        self.only_one("render", |found| &found.render);
        self.only_one("sky", |found| &found.skies);
        self.judge_materials();
        let parents = self.order();
        let mut nodes = self.nodes(&parents);
        let places = self.places(nodes.len());
        self.copied_into_itself(&mut nodes);
        let cameras: Vec<_> = self
            .found
            .cameras
            .clone()
            .into_iter()
            .enumerate()
            .map(|(at, (id, parent))| self.camera(id, parent, at))
            .collect();
        let (render, look, clock) = match self.found.render.first().and_then(|id| self.machine.done(*id)) {
            Some(node) => self.render(&node),
            None => (Render::default(), Look { exposure: 0.0.into(), tonemap: Tonemap::Agx }, Clock::default()),
        };
        let sky = self.found.skies.first().and_then(|id| self.machine.done(*id)).map(|node| self.sky(&node));
        let lights = self.lights();
        let physics = self.physics(&nodes, &clock);
        let wanted = camera.filter(|_| !self.models.is_empty()).map(String::from);
        let camera = self.which_camera(camera);
        let scene = Scene {
            render,
            look,
            clock,
            cameras,
            camera,
            nodes,
            materials: std::mem::take(&mut self.materials),
            sky,
            lights,
            physics,
        };
        let shining = shining(&scene.materials);
        self.judge_space(&scene, &shining);
        self.what_is_missing(&scene, &shining);
        Lowered {
            scene,
            meshes: std::mem::take(&mut self.meshes),
            textures: std::mem::take(&mut self.textures),
            sky: self.sky_picture.take(),
            models: std::mem::take(&mut self.models),
            inner: std::mem::take(&mut self.inner),
            wanted: wanted.filter(|_| camera.is_none()),
            unknown: self.found.unknown,
            places,
        }
    }

    fn places(&self, nodes: usize) -> Places {
        let mut of_nodes = vec![Span::at(0); nodes];
        for ((id, _), index) in self.found.placed.iter().zip(&self.order) {
            if let Some(place) = of_nodes.get_mut(*index) {
                *place = self.span(*id);
            }
        }
        let of = |list: &[(NodeId, Option<usize>)]| list.iter().map(|(id, _)| self.span(*id)).collect();
        Places { nodes: of_nodes, cameras: of(&self.found.cameras), lights: of(&self.found.lights) }
    }

    /// The place that stands for a node in a message: its name, or its kind.
    fn span(&self, id: NodeId) -> Span {
        self.machine.nodes.get(id.0 as usize).map_or(Span::at(0), |slot| slot.place())
    }

    /// The author's name, or the kind.
    fn name(&self, id: NodeId) -> String {
        let ast = self.machine.nodes.get(id.0 as usize).map(|slot| slot.ast);
        ast.map_or(String::new(), |ast| match &ast.name {
            Some(name) => name.text.to_string(),
            None => kind_text(ast),
        })
    }

    fn report(&mut self, id: NodeId, diagnostic: Diagnostic) {
        let trace = self.machine.nodes.get(id.0 as usize).and_then(|slot| slot.trace.clone());
        let outer = std::mem::replace(&mut self.machine.trace, trace);
        let found = self.machine.diagnostics.len();
        self.machine.report(diagnostic);
        if self.machine.diagnostics.len() > found {
            self.origins(id, found);
        }
        self.machine.trace = outer;
    }

    /// Notes of where the values come from that a finding points to.
    fn origins(&mut self, id: NodeId, found: usize) {
        let (Some(node), Some(slot)) = (self.machine.done(id), self.machine.nodes.get(id.0 as usize)) else { return };
        let (whole, scope) = (slot.ast.span, slot.scope.clone());
        // What is copied from another node is read where that one stands.
        let own = |span: Span| whole.start <= span.start && span.end <= whole.end;
        for set in node.properties.iter().filter(|set| own(set.expr.span)) {
            self.machine.explain_value(found, set.expr, &scope);
        }
    }

    /// E0507.
    fn only_one(&mut self, kind: &str, of: impl Fn(&Found) -> &Vec<NodeId>) {
        let found = of(&self.found).clone();
        let Some((first, rest)) = found.split_first() else { return };
        for id in rest {
            let place =
                |id: NodeId| self.machine.nodes.get(id.0 as usize).map_or(Span::at(0), |slot| slot.ast.kind.span);
            let diagnostic = Diagnostic::new("E0507", format!("only one `{kind}` block is allowed"))
                .primary(self.machine.file(), place(*id), "a second one")
                .label(self.machine.file(), place(*first), "the first one")
                .help("merge them");
            self.report(*id, diagnostic);
        }
    }

    fn which_camera(&mut self, wanted: Option<&str>) -> Option<usize> {
        let names: Vec<String> = self.found.cameras.iter().map(|(id, _)| self.name(*id)).collect();
        let file = self.machine.file();
        if let Some(wanted) = wanted {
            let found = names.iter().position(|name| name == wanted);
            if found.is_none() && self.models.is_empty() {
                let mut diagnostic = Diagnostic::new("E0203", format!("no camera named `{wanted}` here"));
                let near = suggest(wanted, names.iter().map(String::as_str));
                diagnostic = match (near.first(), names.is_empty()) {
                    (Some(near), _) => diagnostic.help(format!("did you mean `{near}`?")),
                    (None, false) => {
                        let list = crate::suggest::all_of(names.iter().map(String::as_str));
                        diagnostic.help(format!("the scene has {list}"))
                    }
                    (None, true) => diagnostic.note("the scene has no camera"),
                };
                self.machine.report(diagnostic);
            }
            return found;
        }
        let render = self.found.render.first().and_then(|id| self.machine.done(*id));
        if let Some(set) = render.as_ref().and_then(|node| read::set(node, "camera")) {
            if let Some(Data::Inner(id, path)) = &set.data {
                let (path, span) = (path.clone(), set.expr.span);
                let model = self.index_of(*id)?;
                self.inner.push(InnerRequest { by: InnerUse::Picture, model, path, span });
                return None;
            }
            let id = read::node(set.data.as_ref())?;
            return self.found.cameras.iter().position(|(camera, _)| *camera == id);
        }
        match self.found.cameras.as_slice() {
            // A model may have one.
            [] if self.found.unknown || self.machine.library || !self.models.is_empty() => None,
            [] => {
                let end = self.machine.source.len();
                let text = "camera main { position: (0, 1, 4), look_at: (0, 0, 0) }";
                let diagnostic = Diagnostic::new("E0501", "the scene has no camera")
                    .primary(file, Span::at(0), "nothing takes a picture here")
                    .fix(Applicability::Manual, format!("add `{text}`"), file, Span::at(end), format!("\n{text}\n"));
                self.machine.report(diagnostic);
                None
            }
            [_] => Some(0),
            several => {
                let several: Vec<Span> = several.iter().map(|(id, _)| self.span(*id)).collect();
                let mut diagnostic = Diagnostic::new("E0502", format!("choose one of {} cameras", several.len()));
                for (i, span) in several.iter().enumerate().take(6) {
                    diagnostic = match i {
                        0 => diagnostic.primary(file, *span, "one camera"),
                        _ => diagnostic.label(file, *span, "another camera"),
                    };
                }
                let first = names.first().map_or("main", String::as_str);
                self.machine
                    .report(diagnostic.help(format!("add `render {{ camera: {first} }}` or `--camera {first}`")));
                None
            }
        }
    }

    /// E0503 and W0402.
    fn what_is_missing(&mut self, scene: &Scene, shining: &[bool]) {
        // What a model has is not known yet.
        if self.found.unknown || self.machine.library || !self.models.is_empty() {
            return;
        }
        let file = self.machine.file();
        let shapes = scene.nodes.iter().any(|node| node.shape.is_some());
        // A lamp with a radius is a sphere that is seen, and the disc of a sun is a part of the sky.
        let seen = |light: &Light<Animated>| match light.kind {
            LightKind::Sun { .. } => true,
            LightKind::Point { radius_m, .. } | LightKind::Spot { radius_m, .. } => radius_m > 0.0,
        };
        if !shapes && scene.sky.is_none() && !scene.lights.iter().any(seen) {
            let diagnostic = Diagnostic::new("E0503", "the scene has no geometry")
                .primary(file, Span::at(0), "there is nothing to see here")
                .help("add a shape, for example `sphere { radius: 0.5 }`");
            self.machine.report(diagnostic);
            return;
        }
        if self.meshes.iter().any(MeshRequest::may_shine) {
            return;
        }
        let shines = |node: &Node| node.shape.is_some() && shining.get(node.material) == Some(&true);
        let emitter = scene.nodes.iter().any(shines);
        // A sky whose light is in error is dark only because of that.
        let failed = self.found.skies.iter().filter_map(|id| self.machine.done(*id)).any(|node| {
            let light = node
                .properties
                .iter()
                .filter(|set| ["color", "strength", "file", "model"].contains(&set.property.name));
            light.into_iter().any(|set| set.data.is_none())
        });
        if failed {
            return;
        }
        let sky = scene.sky.as_ref().is_some_and(|sky| {
            let light = match &sky.light {
                SkyLight::Color(color) => color.constant().is_none_or(|color| color.max_element() > 0.0),
                SkyLight::Map { .. } | SkyLight::Nishita { .. } => true,
            };
            // A picture is put in later.
            (light || self.sky_picture.is_some()) && sky.strength.constant() != Some(&0.0)
        });
        let lamp = |light: &Light<Animated>| {
            let (LightKind::Sun { irradiance: amount, .. }
            | LightKind::Point { power: amount, .. }
            | LightKind::Spot { power: amount, .. }) = &light.kind;
            amount.constant() != Some(&0.0) && light.color.max_element() > 0.0
        };
        if !emitter && !sky && !scene.lights.iter().any(lamp) {
            let diagnostic = Diagnostic::new("W0402", "no light reaches the scene")
                .help("add a light: `sky { color: #bcd7ff }`, or a shape with an `emitter` material");
            self.machine.report(diagnostic);
        }
    }
}
