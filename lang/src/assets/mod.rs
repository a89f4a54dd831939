//! Files that a scene names: meshes, read once each, checked, smoothed and fitted.

pub mod cache;
pub mod gltf;
pub mod hdr;
pub mod memory;
mod model;
mod mtl;
mod obj;
pub mod picture;
mod ply;
mod shape;
mod stl;
mod texture;

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use kinora_scene::{Image, Mesh, Node, Placing, Scene, Shape, SkyLight, Texels};

pub use model::load_models;

use crate::diagnostic::Diagnostic;
use crate::eval::limits;
use crate::files::{Files, diagnose, resolve};
use crate::lower::{Lowered, MeshFrom, MeshRequest};
use crate::source::{Span, Texts};
use mtl::Library;
use obj::{Object, ObjectPart};
pub use texture::load_textures;

/// Why a mesh cannot be used: a code and one clause.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssetError {
    /// E0801, E0803 or E0806.
    pub code: &'static str,
    /// What is wrong, without the file's name.
    pub message: String,
    /// An action.
    pub help: &'static str,
}

impl AssetError {
    fn unreadable(message: impl Into<String>) -> AssetError {
        AssetError { code: "E0801", message: message.into(), help: "" }
    }

    fn unusable(message: impl Into<String>) -> AssetError {
        AssetError { code: "E0803", message: message.into(), help: "" }
    }
}

/// Reads a mesh from the bytes of a file; `name` decides the format by its ending. Materials are not looked at.
///
/// # Errors
/// E0801 for bytes that are not such a file, E0803 for a mesh that cannot be used, E0806 for too many triangles.
pub fn read_mesh(name: &str, bytes: &[u8]) -> Result<Mesh, AssetError> {
    Ok(read_object(name, bytes, &|_| Err(String::new()))?.mesh)
}

/// The same with all that an OBJ file has; other files have one part. `library`: see [`obj::read`].
fn read_object(
    name: &str,
    bytes: &[u8],
    library: &dyn Fn(&str) -> Result<Vec<u8>, String>,
) -> Result<Object, AssetError> {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    let mut object = match ending.as_str() {
        "obj" => obj::read(bytes, library)?,
        "ply" => Object { mesh: ply::read(bytes)?, ..Object::default() },
        "stl" => Object { mesh: stl::read(bytes)?, ..Object::default() },
        _ => {
            let mut error = AssetError::unreadable("is not a mesh file this program knows");
            error.help = "meshes are read from `.obj`, `.ply` and `.stl`";
            return Err(error);
        }
    };
    let count = object.mesh.triangles.len();
    object.mesh.name = name.to_string();
    if count > limits::TRIANGLES {
        let message = format!("has {} M triangles, limit {} M", count / 1_000_000, limits::TRIANGLES / 1_000_000);
        return Err(AssetError { code: "E0806", message, help: "decimate it" });
    }
    if object.parts.is_empty() {
        object.parts.push(ObjectPart { name: String::new(), material: None, triangles: 0..count });
    }
    Ok(object)
}

/// Files of materials beside the file at `path`.
fn beside<'a>(files: &'a dyn Files, path: &'a str) -> impl Fn(&str) -> Result<Vec<u8>, String> + 'a {
    move |written: &str| {
        let written = written.replace('\\', "/");
        let missing =
            |error: crate::files::FileError| format!("a file of materials that is not there: {}", error.message());
        let at = resolve(path, written.trim_start_matches("./")).map_err(missing)?;
        files.read(&at).map(|bytes| bytes.to_vec()).map_err(missing)
    }
}

/// Checks a mesh and makes it what the scene asks for.
fn finish(mut mesh: Mesh, smooth: Option<bool>, fit: Option<f64>) -> Result<Mesh, AssetError> {
    mesh.validate().map_err(|error| AssetError::unusable(error.to_string()))?;
    match smooth {
        Some(true) => mesh.normals = mesh.smooth_normals(),
        Some(false) => mesh.normals.clear(),
        None => mesh.repair_normals(),
    }
    if let Some(length) = fit
        && !shape::fit(&mut mesh, length)
    {
        return Err(AssetError::unusable("has no extent to `fit`"));
    }
    mesh.validate().map_err(|error| AssetError::unusable(error.to_string()))?;
    Ok(mesh)
}

/// A mesh, and of which materials it is.
#[derive(Clone)]
struct Loaded {
    /// All of it.
    mesh: Arc<Mesh>,
    /// What has a material of its own, with its name and index; none if the scene says what the mesh is made of.
    parts: Vec<(String, Arc<Mesh>, usize)>,
}

/// Puts the meshes into the scene.
pub fn load_meshes(lowered: &mut Lowered, files: &dyn Files, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    type Key = (String, Option<bool>, Option<u64>, bool);
    let mut known: HashMap<Key, Result<Loaded, ()>> = HashMap::new();
    let mut open: HashMap<*const Mesh, usize> = HashMap::new();
    let mut whole = true;
    let requests = std::mem::take(&mut lowered.meshes);
    for request in &requests {
        let key = match &request.from {
            MeshFrom::File(written) => {
                let from = &source.source(request.span.start).name;
                let path = resolve(from, written).unwrap_or_else(|_| written.to_string());
                Some((path, request.smooth, request.fit.map(f64::to_bits), request.own_materials))
            }
            MeshFrom::Lists(_) => None,
        };
        let before = key.as_ref().and_then(|key| known.get(key)).cloned();
        let loaded = match before {
            Some(loaded) => loaded,
            None => {
                let loaded = load(request, files, source, &mut lowered.scene, diagnostics)
                    .map_err(|diagnostic| diagnostics.push(*diagnostic));
                if let Some(key) = key {
                    known.insert(key, loaded.clone());
                }
                loaded
            }
        };
        let Ok(Loaded { mesh, parts }) = loaded else {
            whole = false;
            continue;
        };
        if let Some(span) = request.glass {
            let count = *open.entry(Arc::as_ptr(&mesh)).or_insert_with(|| shape::boundary_edges(&mesh));
            diagnostics.extend((count > 0).then(|| open_glass(count, source, span)));
        }
        for (i, (name, part, material)) in parts.iter().enumerate() {
            if i > 0 {
                lowered.scene.nodes.push(Node {
                    name: name.clone(),
                    parent: Some(request.node),
                    placing: Placing::default(),
                    shape: Some(Shape::Mesh(part.clone())),
                    material: *material,
                    visible: true.into(),
                    copies: None,
                    only_copied: false,
                    form: None,
                    vanishes: false,
                });
            } else if let Some(node) = lowered.scene.nodes.get_mut(request.node) {
                node.shape = Some(Shape::Mesh(part.clone()));
                node.material = *material;
            }
        }
        if let (true, Some(node)) = (parts.is_empty(), lowered.scene.nodes.get_mut(request.node)) {
            node.shape = Some(Shape::Mesh(mesh));
        }
    }
    // What their materials shine was not known before.
    if whole && !lowered.unknown && lowered.models.is_empty() && requests.iter().any(MeshRequest::may_shine) {
        model::without_light(&lowered.scene, diagnostics);
    }
    lowered.meshes = requests;
}

/// Puts the picture of the sky into the scene.
pub fn load_sky(lowered: &mut Lowered, files: &dyn Files, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    let (Some(request), Some(sky)) = (lowered.sky.take(), &mut lowered.scene.sky) else { return };
    let (file, span) = (source.id, request.span);
    let picture = match picture(&request.path, files, source, span) {
        Ok(picture) => picture,
        Err(diagnostic) => return diagnostics.push(*diagnostic),
    };
    let (bad, image) = (picture.bad, picture.image.clone());
    if bad > 0 {
        let texels = if bad == 1 { "texel that is" } else { "texels that are" };
        let message = format!("`{}` has {bad} {texels} negative or not finite", request.path);
        diagnostics.push(
            Diagnostic::new("W0811", message)
                .primary(file, span, "no light comes from there")
                .note("what is negative or not a number is taken as 0, what is infinite as the largest finite value"),
        );
    }
    if let Some(image) = image {
        sky.light = SkyLight::Map { image, rotation: request.rotation };
    }
}

/// The picture of a sky.
struct SkyPicture {
    image: Option<Arc<Image>>,
    /// Texels that are no light.
    bad: usize,
}

fn picture(written: &str, files: &dyn Files, source: &Texts, span: Span) -> Result<Arc<SkyPicture>, Box<Diagnostic>> {
    let file = source.id;
    let path = resolve(&source.source(span.start).name, written).map_err(|error| error.diagnostic(file, span))?;
    cache::made(
        files,
        || format!("sky {written} {path}"),
        |files| {
            let bytes = files
                .read(&path)
                .map_err(|error| diagnose(files, &error, (file, span), written, source.slice(span)))?;
            let picture = hdr::read(&bytes).map_err(|error| {
                let diagnostic = Diagnostic::new(error.code, format!("`{written}` {}", error.message));
                let diagnostic = diagnostic.primary(file, span, "cannot be used");
                Box::new(if error.help.is_empty() { diagnostic } else { diagnostic.help(error.help) })
            })?;
            Ok(sky_picture(written, &picture))
        },
    )
}

fn sky_picture(written: &str, picture: &hdr::LightPicture) -> SkyPicture {
    let [width, height] = picture.size;
    let is_light = |c: &f32| *c >= 0.0 && c.is_finite();
    let bad = picture.rgb.as_chunks::<3>().0.iter().filter(|texel| !texel.iter().all(is_light)).count();
    let largest = picture.rgb.iter().copied().filter(|c| c.is_finite()).fold(0.0, f32::max);
    let clean = |c: f32| match c {
        c if is_light(&c) => c,
        f32::INFINITY => largest,
        _ => 0.0,
    };
    let texels = picture.rgb.as_chunks::<3>().0.iter().map(|&[r, g, b]| [clean(r), clean(g), clean(b), 1.0]).collect();
    SkyPicture { image: Image::new(written, width, height, Texels::Rgba32F(texels)).map(Arc::new), bad }
}

/// W0509.
fn open_glass(count: usize, source: &Texts, span: Span) -> Diagnostic {
    let edges = if count == 1 { "edge" } else { "edges" };
    Diagnostic::new("W0509", format!("glass needs a closed mesh; {count} boundary {edges}"))
        .primary(source.id, span, "light would go in and never come out, or the other way round")
        .note("absorption will be wrong")
        .help("close the mesh, or make it a sheet: `dielectric { thin: true }`")
}

fn load(
    request: &MeshRequest,
    files: &dyn Files,
    source: &Texts,
    scene: &mut Scene,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Loaded, Box<Diagnostic>> {
    let (file, span) = (source.id, request.span);
    let fault = |name: &str, error: AssetError| {
        let message = match error.code {
            "E0803" => format!("mesh `{name}`: {}", error.message),
            _ => format!("`{name}` {}", error.message),
        };
        let diagnostic = Diagnostic::new(error.code, message).primary(file, span, "cannot be used");
        Box::new(if error.help.is_empty() { diagnostic } else { diagnostic.help(error.help) })
    };
    let written = match &request.from {
        MeshFrom::Lists(mesh) => {
            let mesh = finish(mesh.clone(), request.smooth, request.fit).map_err(|error| fault(&mesh.name, error))?;
            return Ok(Loaded { mesh: Arc::new(mesh), parts: Vec::new() });
        }
        MeshFrom::File(written) => written,
    };
    let ending = written.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    if ["gltf", "glb"].contains(&ending.as_str()) {
        return Err(Diagnostic::new("E0801", format!("`{written}` is not a mesh file"))
            .primary(file, span, "a whole glTF scene")
            .help("write `model { file: .. }`")
            .into());
    }
    let path = resolve(&source.source(span.start).name, written).map_err(|error| error.diagnostic(file, span))?;
    let key = || format!("mesh {path} {:?} {:?} {}", request.smooth, request.fit, request.own_materials);
    let made = cache::made(files, key, |files| -> Result<_, Box<Diagnostic>> {
        let bytes =
            files.read(&path).map_err(|error| diagnose(files, &error, (file, span), written, source.slice(span)))?;
        let nothing = |_: &str| Ok(Vec::new());
        let library = beside(files, &path);
        let library: &dyn Fn(&str) -> Result<Vec<u8>, String> = if request.own_materials { &library } else { &nothing };
        let mut object = read_object(&path, &bytes, library).map_err(|error| fault(&path, error))?;
        let mesh = std::mem::take(&mut object.mesh);
        let mesh = finish(mesh, request.smooth, request.fit).map_err(|error| fault(&path, error))?;
        Ok((object, Arc::new(mesh)))
    })?;
    let (object, mesh) = &*made;
    let colored = !mesh.colors.is_empty();
    let mut parts = Vec::new();
    if request.own_materials && (colored || !object.materials.is_empty() || !object.missing.is_empty()) {
        let mut by_material: BTreeMap<Option<usize>, Vec<[u32; 3]>> = BTreeMap::new();
        for part in &object.parts {
            let triangles = mesh.triangles.get(part.triangles.clone()).unwrap_or_default();
            by_material.entry(part.material).or_default().extend_from_slice(triangles);
        }
        let mut library = Library::new(files, &path, colored);
        let first = scene.materials.len();
        let whole = by_material.len() == 1;
        for (material, triangles) in by_material {
            let said = material.and_then(|at| object.materials.get(at));
            let root = library.build(said);
            let name = said.map_or("plain", |said| said.name.as_str());
            let part = if whole { mesh.clone() } else { Arc::new(shape::part(mesh, &triangles, &path)) };
            parts.push((name.to_string(), part, first + root));
        }
        for what in &object.missing {
            library.warnings.add(what.as_str(), "what it is about is matt and grey");
        }
        model::warn(&library.warnings, written, source, span, diagnostics);
        model::add_materials(scene, &library.made);
    }
    Ok(Loaded { mesh: mesh.clone(), parts })
}
