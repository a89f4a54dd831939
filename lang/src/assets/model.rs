//! Models in the scene: their nodes under the node that stands for them, and what refers into them.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use kinora_scene::{
    Aim, Animated, Beam, Blades, Camera, Form, Keys, Light, LightKind, Material, Morph, Node, Placing, Scene, Shape,
    Skin, Track, Way,
};

use super::cache::made;
use super::gltf::{self, Clip, Faults, Lamp, LampKind, Model, Moved, Part, Projection, Rig, Warnings};
use super::mtl::Library;
use super::{AssetError, beside, finish, read_object, shape};
use crate::diagnostic::Diagnostic;
use crate::eval::limits;
use crate::files::{FileError, Files, diagnose, resolve};
use crate::lower::{InnerRequest, InnerUse, Lowered, ModelRequest, shining};
use crate::source::{Span, Texts};
use crate::suggest::{all_of, suggest};

/// A model that is in the scene.
struct Placed {
    model: Arc<Model>,
    /// Index of the model's first part in the scene's nodes.
    first: usize,
    /// Its cameras: name, and index in the scene's.
    cameras: Vec<(String, usize)>,
}

/// Puts the models into the scene.
pub fn load_models(lowered: &mut Lowered, files: &dyn Files, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    if lowered.models.is_empty() {
        return;
    }
    type Known = Option<(Arc<Model>, usize)>;
    let mut known: HashMap<String, Known> = HashMap::new();
    let mut placed: HashMap<usize, Placed> = HashMap::new();
    let mut whole = true;
    for request in &lowered.models {
        let from = &source.source(request.span.start).name;
        let path = resolve(from, &request.file).unwrap_or_else(|_| request.file.to_string());
        let loaded = match known.get(&path) {
            Some(loaded) => loaded.clone(),
            None => {
                let loaded = load(request, files, source, diagnostics).map(|model| {
                    let first = add_materials(&mut lowered.scene, &model.materials);
                    (model, first)
                });
                known.insert(path, loaded.clone());
                loaded
            }
        };
        let Some((model, materials)) = loaded else {
            whole = false;
            continue;
        };
        if lowered.scene.nodes.len() + model.nodes.len() > limits::NODES {
            let message = format!("more than {} nodes with `{}`", limits::NODES, request.file);
            diagnostics.push(Diagnostic::new("E1004", message).primary(source.id, request.span, "too many"));
            whole = false;
            continue;
        }
        let in_scene = add(&mut lowered.scene, request, model, materials, source, diagnostics);
        let (scene, places) = (&lowered.scene, &mut lowered.places);
        let place = places.nodes.get(request.node).copied().unwrap_or(request.span);
        places.nodes.resize(scene.nodes.len(), place);
        places.cameras.resize(scene.cameras.len(), place);
        places.lights.resize(scene.lights.len(), place);
        replace_materials(&mut lowered.scene, request, &in_scene, source, diagnostics);
        placed.insert(request.node, in_scene);
    }
    for inner in &lowered.inner {
        if let Some(model) = placed.get(&inner.model) {
            follow(&mut lowered.scene, inner, model, source, diagnostics);
        }
    }
    if whole && !lowered.unknown {
        which_camera(lowered, &placed, source, diagnostics);
        without_light(&lowered.scene, diagnostics);
    }
    put_in_order(&mut lowered.scene, &mut lowered.places.nodes, source, diagnostics);
}

/// Reads a model and says what is wrong with it.
fn load(
    request: &ModelRequest,
    files: &dyn Files,
    source: &Texts,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<Arc<Model>> {
    let (file, span, written) = (source.id, request.span, &request.file);
    let ending = written.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    let is_mesh = ["obj", "ply", "stl"].contains(&ending.as_str());
    if !is_mesh && !["gltf", "glb"].contains(&ending.as_str()) {
        let message = format!("`{written}` is not a model by its name");
        let diagnostic = Diagnostic::new("E0801", message)
            .primary(file, span, "`.gltf` or `.glb` is expected")
            .help("export it as glTF");
        diagnostics.push(diagnostic);
        return None;
    }
    let cannot_read = |error: FileError| Box::new(diagnose(files, &error, (file, span), written, source.slice(span)));
    let model = resolve(&source.source(span.start).name, written).map_err(cannot_read).and_then(|path| {
        made(
            files,
            || format!("model {path}"),
            |files| {
                let bytes = files.read(&path).map_err(cannot_read)?;
                if !is_mesh {
                    let faulty = |faults| Box::new(diagnostic(&faults, written, source, span));
                    return gltf::read(&path, &bytes, files).map_err(faulty);
                }
                of_mesh(&path, &bytes, files).map_err(|error| {
                    let message = match error.code {
                        "E0803" => format!("`{path}`: {}", error.message),
                        _ => format!("`{path}` {}", error.message),
                    };
                    let diagnostic = Diagnostic::new(error.code, message).primary(file, span, "cannot be used");
                    Box::new(if error.help.is_empty() { diagnostic } else { diagnostic.help(error.help) })
                })
            },
        )
    });
    match model {
        Ok(model) => {
            warn(&model.warnings, written, source, span, diagnostics);
            Some(model)
        }
        Err(diagnostic) => {
            diagnostics.push(*diagnostic);
            None
        }
    }
}

/// A mesh file as a model: a node for each of its objects, or of their parts where one has several materials.
fn of_mesh(path: &str, bytes: &[u8], files: &dyn Files) -> Result<Model, AssetError> {
    let mut object = read_object(path, bytes, &beside(files, path))?;
    let mesh = finish(std::mem::take(&mut object.mesh), None, None)?;
    let mut library = Library::new(files, path, !mesh.colors.is_empty());
    let mut roots: HashMap<Option<usize>, usize> = HashMap::new();
    let mut model = Model::default();
    for part in &object.parts {
        let said = part.material.and_then(|at| object.materials.get(at));
        let root = *roots.entry(part.material).or_insert_with(|| library.build(said));
        let name = if part.name.is_empty() { "mesh" } else { &part.name };
        let shape = shape::part(&mesh, mesh.triangles.get(part.triangles.clone()).unwrap_or_default(), name);
        model.meshes.push((name.to_string(), shape.triangles.len()));
        model.nodes.push(Part {
            name: name.to_string(),
            path: Some(name.to_string()),
            parent: None,
            placing: Placing::default(),
            shape: Some((Arc::new(shape), root)),
            of: None,
            form: None,
            camera: None,
            light: None,
        });
    }
    for what in object.missing {
        library.warnings.add(what, "what it is about is matt and grey");
    }
    model.material_names = object.materials.iter().map(|material| material.name.clone()).collect();
    model.materials = library.made;
    model.warnings = library.warnings;
    Ok(model)
}

/// W0810: what is left out.
pub(super) fn warn(warnings: &Warnings, written: &str, source: &Texts, span: Span, diagnostics: &mut Vec<Diagnostic>) {
    for (what, then, count) in warnings.iter() {
        let times = if *count > 1 { format!(" ({count} times)") } else { String::new() };
        let message = format!("`{written}` has {what}{times}: {then}");
        diagnostics.push(Diagnostic::new("W0810", message).primary(source.id, span, "not all of it is shown"));
    }
}

/// What is wrong with a model, in one message.
fn diagnostic(faults: &Faults, written: &str, source: &Texts, span: Span) -> Diagnostic {
    let Some((first, rest)) = faults.first().split_first() else {
        return Diagnostic::new("E0801", format!("`{written}` is not a valid glTF file"));
    };
    let at = if first.at.is_empty() { String::new() } else { format!("{}: ", first.at) };
    let message = match first.code {
        "E0801" => format!("`{written}` is not a valid glTF file: {at}{}", first.message),
        "E0802" => format!("`{written}` {}", first.message),
        _ => format!("`{written}`: {at}{}", first.message),
    };
    let label = if first.at.is_empty() { "cannot be used".to_string() } else { format!("wrong at {}", first.at) };
    let mut diagnostic = Diagnostic::new(first.code, message).primary(source.id, span, label);
    for fault in rest {
        diagnostic = diagnostic.note(format!("{}: {}", fault.at, fault.message));
    }
    let more = faults.count() - faults.first().len();
    if more > 0 {
        diagnostic = diagnostic.note(format!("and {more} more"));
    }
    diagnostic.help(first.help)
}

/// Appends materials that refer to one another; gives the index of the first.
pub(super) fn add_materials(scene: &mut Scene, materials: &[Material<Animated>]) -> usize {
    let first = scene.materials.len();
    for material in materials {
        let mut material = material.clone();
        match &mut material.bsdf {
            kinora_scene::Bsdf::Glossy { base, .. } | kinora_scene::Bsdf::Sheen { base, .. } => *base += first,
            kinora_scene::Bsdf::Mix { a, b, .. } => {
                *a += first;
                *b += first;
            }
            _ => {}
        }
        scene.materials.push(material);
    }
    first
}

/// Appends a model's nodes, cameras and lights.
fn add(
    scene: &mut Scene,
    request: &ModelRequest,
    model: Arc<Model>,
    materials: usize,
    source: &Texts,
    diagnostics: &mut Vec<Diagnostic>,
) -> Placed {
    let first = scene.nodes.len();
    let play = Play::new(&model, clip(request, &model, source, diagnostics), request);
    let mut cameras = Vec::new();
    for (i, part) in model.nodes.iter().enumerate() {
        if let Some(lens) = &part.camera {
            cameras.push((lens.name.clone(), scene.cameras.len()));
            scene.cameras.push(camera(&format!("{}.{}", request.name, lens.name), first + i, lens.projection));
        }
        if let Some(lamp) = &part.light {
            scene.lights.push(light(&format!("{}.{}", request.name, lamp.name), first + i, lamp));
        }
        scene.nodes.push(Node {
            name: part.name.clone(),
            parent: Some(part.parent.map_or(request.node, |parent| first + parent)),
            placing: play.placing(i, part),
            shape: part.shape.as_ref().map(|(mesh, _)| Shape::Mesh(mesh.clone())),
            form: part.form.as_ref().and_then(|rig| play.form(rig, first)).map(Box::new),
            vanishes: true,
            material: part.shape.as_ref().map_or(0, |(_, material)| materials + material),
            visible: true.into(),
            copies: None,
            only_copied: false,
        });
    }
    Placed { model, first, cameras }
}

/// The clip that a model plays; E0804.
fn clip<'m>(
    request: &ModelRequest,
    model: &'m Model,
    source: &Texts,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<&'m Clip> {
    let (name, span) = request.clip.as_ref()?;
    let found = model.clips.iter().find(|clip| *clip.name == **name);
    if found.is_none() {
        let names = || model.clips.iter().map(|clip| clip.name.as_str());
        let diagnostic = Diagnostic::new("E0804", format!("no clip `{name}` in the model")).primary(
            source.id,
            *span,
            "no such clip",
        );
        diagnostics.push(match suggest(name, names()).first() {
            Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
            None if model.clips.is_empty() => diagnostic.note("the model has no clips"),
            None => {
                let more = if model.clips.len() > 8 { " and more" } else { "" };
                diagnostic.help(format!("it has {}{more}", all_of(names().take(8))))
            }
        });
    }
    found
}

/// What a clip does to the parts of a model.
struct Play<'m> {
    /// What moves each part.
    moved: Vec<Vec<&'m Moved>>,
    /// Whether each part or one that it moves with is moved.
    carried: Vec<bool>,
    clock: Option<Arc<Track<f64>>>,
}

impl<'m> Play<'m> {
    fn new(model: &Model, clip: Option<&'m Clip>, request: &ModelRequest) -> Play<'m> {
        let mut moved: Vec<Vec<&Moved>> = vec![Vec::new(); model.nodes.len()];
        for channel in clip.iter().flat_map(|clip| &clip.channels) {
            if let Some(part) = moved.get_mut(channel.part) {
                part.push(&channel.moved);
            }
        }
        let mut carried = Vec::with_capacity(model.nodes.len());
        for (part, moved) in model.nodes.iter().zip(&moved) {
            let own = moved.iter().any(|moved| !matches!(moved, Moved::Weights(_)));
            carried.push(own || part.parent.is_some_and(|parent| carried.get(parent) == Some(&true)));
        }
        Play { moved, carried, clock: request.clock.clone() }
    }

    /// Keys as the model's clock runs through them; what stays the same is a constant.
    fn track<T: Clone + PartialEq>(&self, keys: &Keys<T>) -> Track<T> {
        match (keys.keys.split_first(), &keys.way, &self.clock) {
            (Some((first, rest)), Way::Straight, _) if rest.iter().all(|key| key.value == first.value) => {
                Track::Const(first.value.clone())
            }
            (_, _, None) => Track::Keys(keys.clone()),
            (_, _, Some(clock)) => Track::Clocked { keys: Box::new(keys.clone()), clock: clock.clone() },
        }
    }

    fn placing(&self, index: usize, part: &Part) -> Placing {
        let mut placing = part.placing.clone();
        for moved in self.moved.get(index).into_iter().flatten() {
            match moved {
                Moved::Position(keys) => placing.position = self.track(keys),
                Moved::Rotation(keys) => placing.rotation = self.track(keys),
                Moved::Scale(keys) => placing.scale = self.track(keys),
                Moved::Weights(_) => {}
            }
        }
        placing
    }

    /// What changes a mesh's form, if the clip does; `first`: index of the model's first part in the scene.
    fn form(&self, rig: &Rig, first: usize) -> Option<Form> {
        let weights = self.moved.get(rig.part)?.iter().find_map(|moved| match moved {
            Moved::Weights(weights) => Some(weights),
            _ => None,
        });
        let joint_moves = |joint: &Option<usize>| joint.is_some_and(|joint| self.carried.get(joint) == Some(&true));
        let carried = rig.skin.as_ref().is_some_and(|skin| skin.joints.iter().any(joint_moves));
        if weights.is_none() && !carried {
            return None;
        }
        let morph = (!rig.targets.is_empty()).then(|| Morph {
            targets: rig.targets.clone(),
            weights: match weights {
                Some(weights) => weights.iter().map(|keys| self.track(keys)).collect(),
                None => rig.weights.iter().map(|weight| Track::Const(*weight)).collect(),
            },
        });
        let skin = rig.skin.as_ref().map(|skin| Skin {
            joints: skin.joints.iter().map(|joint| joint.map(|joint| first + joint)).collect(),
            bind: skin.bind.clone(),
            influences: skin.influences.clone(),
        });
        Some(Form { mesh: rig.mesh.clone(), morph, skin })
    }
}

fn camera(name: &str, parent: usize, projection: Projection) -> Camera<kinora_scene::Animated> {
    let projection = match projection {
        Projection::Perspective(fov) => kinora_scene::Projection::Perspective { fov: fov.into() },
        Projection::Orthographic(height_m) => kinora_scene::Projection::Orthographic { height_m },
    };
    Camera {
        name: name.to_string(),
        parent: Some(parent),
        position: DVec3::ZERO.into(),
        aim: Aim::Rotation(DQuat::IDENTITY.into()),
        projection,
        aperture_m: 0.0.into(),
        focus_m: None,
        blades: Blades::default(),
    }
}

/// glTF's candela and lux are W/sr and W/m², one to one.
fn light(name: &str, parent: usize, lamp: &Lamp) -> Light<Animated> {
    let (position, direction) = (DVec3::ZERO.into(), DVec3::NEG_Z.into());
    let power = (4.0 * PI * lamp.intensity).into();
    let kind = match lamp.kind {
        LampKind::Sun => LightKind::Sun { direction, angle: 0.0, irradiance: lamp.intensity.into() },
        LampKind::Point => LightKind::Point { position, power, radius_m: 0.0 },
        LampKind::Spot([inner, outer]) => LightKind::Spot {
            position,
            aim: Beam::Direction(direction),
            power,
            radius_m: 0.0,
            angle: 2.0 * outer,
            blend: (1.0 - inner / outer).clamp(0.0, 1.0),
        },
    };
    Light { name: name.to_string(), parent: Some(parent), color: DVec3::from_array(lamp.color).as_vec3(), kind }
}

/// The part of a path: the one of that whole path, or the only one whose path ends so.
fn find(model: &Model, path: &str) -> Result<usize, Vec<String>> {
    let path = path.trim_matches('/');
    let paths = || model.nodes.iter().enumerate().filter_map(|(i, part)| Some((i, part.path.as_deref()?)));
    if let Some((i, _)) = paths().find(|(_, known)| *known == path) {
        return Ok(i);
    }
    let ends = |known: &str| known.strip_suffix(path).is_some_and(|rest| rest.ends_with('/'));
    let found: Vec<(usize, &str)> = paths().filter(|(_, known)| ends(known)).collect();
    match found.as_slice() {
        [(i, _)] => Ok(*i),
        several => Err(several.iter().map(|(_, path)| path.to_string()).collect()),
    }
}

/// E0804, or E0508 of an `override`: there is no such node, or more than one.
fn no_node(code: &'static str, model: &Model, path: &str, found: &[String], source: &Texts, span: Span) -> Diagnostic {
    if !found.is_empty() {
        let list = all_of(found.iter().take(6).map(String::as_str));
        return Diagnostic::new(code, format!("`{path}` is {} nodes of the model", found.len()))
            .primary(source.id, span, "which one?")
            .help(format!("write more of the path: {list}"));
    }
    let paths: Vec<&str> = model.nodes.iter().filter_map(|part| part.path.as_deref()).collect();
    let names: Vec<&str> = paths.iter().map(|path| path.rsplit('/').next().unwrap_or(path)).collect();
    let diagnostic =
        Diagnostic::new(code, format!("model has no node `{path}`")).primary(source.id, span, "no such node");
    let near = suggest(path, paths.iter().copied());
    let near_name = suggest(path.rsplit('/').next().unwrap_or(path), names.iter().copied());
    match (near.first(), near_name.first()) {
        (Some(near), _) | (None, Some(near)) => diagnostic.help(format!("did you mean `{near}`?")),
        (None, None) if paths.is_empty() => diagnostic.note("the model has no nodes"),
        (None, None) => {
            let list = all_of(paths.iter().take(8).copied());
            diagnostic.help(format!("it has {list}{}", if paths.len() > 8 { " and more" } else { "" }))
        }
    }
}

/// `material` of the model, and its overrides: what is nearer to a shape counts.
fn replace_materials(
    scene: &mut Scene,
    request: &ModelRequest,
    placed: &Placed,
    source: &Texts,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let parts = &placed.model.nodes;
    let mut own: Vec<Option<usize>> = vec![None; parts.len()];
    for (path, span, material) in &request.overrides {
        match find(&placed.model, path) {
            Ok(part) => own[part] = Some(*material),
            Err(found) => diagnostics.push(
                no_node("E0508", &placed.model, path, &found, source, *span)
                    .help(format!("`kinora inspect {}` lists its nodes", request.file)),
            ),
        }
    }
    let mut given: Vec<Option<usize>> = Vec::with_capacity(parts.len());
    for (i, part) in parts.iter().enumerate() {
        let outer = part.of.or(part.parent).map_or(request.material, |outer| given[outer]);
        let material = own[i].or(outer);
        given.push(material);
        if let (Some(material), Some(_), Some(node)) = (material, &part.shape, scene.nodes.get_mut(placed.first + i)) {
            node.material = material;
        }
    }
}

/// Follows a reference into a model.
fn follow(scene: &mut Scene, inner: &InnerRequest, placed: &Placed, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    if inner.by == InnerUse::Picture {
        let camera = placed.cameras.iter().find(|(name, _)| **name == *inner.path);
        let in_node = || {
            let node = placed.first + find(&placed.model, &inner.path).ok()?;
            placed
                .cameras
                .iter()
                .find(|(_, at)| scene.cameras.get(*at).is_some_and(|camera| camera.parent == Some(node)))
        };
        match camera.or_else(in_node) {
            Some((_, at)) => scene.camera = Some(*at),
            None => {
                let names = || placed.cameras.iter().map(|(name, _)| name.as_str());
                let diagnostic = Diagnostic::new("E0804", format!("no camera `{}` in the model", inner.path)).primary(
                    source.id,
                    inner.span,
                    "no such camera",
                );
                diagnostics.push(match suggest(&inner.path, names()).first() {
                    Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
                    None if placed.cameras.is_empty() => diagnostic.note("the model has no camera"),
                    None => diagnostic.help(format!("it has {}", all_of(names()))),
                });
            }
        }
        return;
    }
    let node = match find(&placed.model, &inner.path) {
        Ok(part) => placed.first + part,
        Err(found) => {
            diagnostics.push(no_node("E0804", &placed.model, &inner.path, &found, source, inner.span));
            return;
        }
    };
    match inner.by {
        InnerUse::Parent(at) => {
            if let Some(slot) = scene.nodes.get_mut(at) {
                slot.parent = Some(node);
            }
        }
        InnerUse::CameraParent(at) => {
            if let Some(slot) = scene.cameras.get_mut(at) {
                slot.parent = Some(node);
            }
        }
        InnerUse::Copied(at) => {
            if let Some(copies) = scene.nodes.get_mut(at).and_then(|slot| slot.copies.as_mut()) {
                copies.of = node;
            }
        }
        InnerUse::CameraTarget(at) => {
            if let Some(Aim::Node { target, .. }) = scene.cameras.get_mut(at).map(|camera| &mut camera.aim) {
                *target = node;
            }
        }
        InnerUse::LightTarget(at) => {
            if let Some(LightKind::Spot { aim: Beam::Node(target), .. }) =
                scene.lights.get_mut(at).map(|light| &mut light.kind)
            {
                *target = node;
            }
        }
        InnerUse::Picture => {}
    }
}

/// E0501, E0502 and E0203: which camera takes the picture, where the scene itself does not say.
fn which_camera(
    lowered: &mut Lowered,
    placed: &HashMap<usize, Placed>,
    source: &Texts,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let scene = &mut lowered.scene;
    if let Some(wanted) = &lowered.wanted {
        scene.camera = scene.cameras.iter().position(|camera| camera.name == *wanted);
        if scene.camera.is_none() {
            let diagnostic = Diagnostic::new("E0203", format!("no camera named `{wanted}` here"));
            let names = || scene.cameras.iter().map(|camera| camera.name.as_str());
            diagnostics.push(match suggest(wanted, names()).first() {
                Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
                None if scene.cameras.is_empty() => diagnostic.note("the scene has no camera"),
                None => diagnostic.help(format!("the scene has {}", all_of(names().take(8)))),
            });
        }
        return;
    }
    let asked = lowered.inner.iter().any(|inner| inner.by == InnerUse::Picture);
    let own = scene.cameras.len() - placed.values().map(|model| model.cameras.len()).sum::<usize>();
    if scene.camera.is_some() || asked || own > 0 {
        return;
    }
    let span = lowered.models.first().map_or(Span::at(0), |request| request.span);
    match scene.cameras.as_slice() {
        [] => {
            let text = "camera main { position: (0, 1, 4), look_at: (0, 0, 0) }";
            let diagnostic = Diagnostic::new("E0501", "the scene has no camera")
                .primary(source.id, span, "nor has the model")
                .help(format!("add `{text}`"));
            diagnostics.push(diagnostic);
        }
        [_] => scene.camera = Some(0),
        [first, ..] => {
            let list = all_of(scene.cameras.iter().take(8).map(|camera| camera.name.as_str()));
            let diagnostic = Diagnostic::new("E0502", format!("choose one of {} cameras", scene.cameras.len()))
                .primary(source.id, span, "the model has several")
                .note(format!("they are {list}"))
                .help(format!("add `render {{ camera: {} }}` or `--camera \"{}\"`", first.name, first.name));
            diagnostics.push(diagnostic);
        }
    }
}

/// W0402, which only the whole scene can tell. A model without a mesh has nothing to light.
pub(super) fn without_light(scene: &Scene, diagnostics: &mut Vec<Diagnostic>) {
    let shining = shining(&scene.materials);
    let mut shapes = scene.nodes.iter().filter(|node| node.shape.is_some()).peekable();
    let lamp = scene.lights.iter().any(|light| light.color.max_element() > 0.0);
    let dark = !lamp && shapes.peek().is_some() && !shapes.any(|node| shining.get(node.material) == Some(&true));
    if dark && scene.sky.is_none() {
        let diagnostic = Diagnostic::new("W0402", "no light reaches the scene")
            .help("add a light: `sky { color: #bcd7ff }`, or a shape with an `emitter` material");
        diagnostics.push(diagnostic);
    }
}

/// Parents before children again: what moves with a model's node stands before it.
fn put_in_order(scene: &mut Scene, places: &mut Vec<Span>, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    if scene.nodes.iter().enumerate().all(|(at, node)| node.parent.is_none_or(|parent| parent < at)) {
        return;
    }
    let count = scene.nodes.len();
    let mut order = Vec::with_capacity(count);
    let mut new = vec![usize::MAX; count];
    for start in 0..count {
        let mut path = Vec::new();
        let mut at = Some(start);
        while let Some(here) = at.filter(|here| new[*here] == usize::MAX) {
            if path.len() > count {
                let name = scene.nodes[start].name.clone();
                let diagnostic = Diagnostic::new("E0505", format!("`{name}` is positioned relative to itself"))
                    .primary(source.id, Span::at(0), "a model moves with what moves with its own node")
                    .help("give one of them a fixed position");
                diagnostics.push(diagnostic);
                return;
            }
            path.push(here);
            at = scene.nodes[here].parent;
        }
        for here in path.into_iter().rev() {
            new[here] = order.len();
            order.push(here);
        }
    }
    let mut old: Vec<Option<Node>> = std::mem::take(&mut scene.nodes).into_iter().map(Some).collect();
    scene.nodes = order.iter().filter_map(|at| old[*at].take()).collect();
    *places = order.iter().filter_map(|at| places.get(*at).copied()).collect();
    let moved = |at: &mut usize| *at = new.get(*at).copied().unwrap_or(*at);
    for node in &mut scene.nodes {
        node.parent.iter_mut().for_each(moved);
        node.copies.iter_mut().for_each(|copies| moved(&mut copies.of));
        let skin = node.form.as_mut().and_then(|form| form.skin.as_mut());
        skin.into_iter().flat_map(|skin| skin.joints.iter_mut().flatten()).for_each(moved);
    }
    for camera in &mut scene.cameras {
        camera.parent.iter_mut().for_each(moved);
        if let Aim::Node { target, .. } = &mut camera.aim {
            moved(target);
        }
    }
    for body in &mut scene.physics.bodies {
        moved(&mut body.node);
    }
    for joint in &mut scene.physics.joints {
        moved(&mut joint.a);
        moved(&mut joint.b);
    }
    for light in &mut scene.lights {
        light.parent.iter_mut().for_each(moved);
        if let LightKind::Spot { aim: Beam::Node(target), .. } = &mut light.kind {
            moved(target);
        }
    }
}
