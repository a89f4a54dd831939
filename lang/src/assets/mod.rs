//! Files that a scene names: meshes, read once each, checked, smoothed and fitted.

pub mod gltf;
pub mod hdr;
mod model;
mod obj;
pub mod picture;
mod ply;
mod shape;
mod texture;

use std::collections::HashMap;
use std::sync::Arc;

use kinora_scene::{Image, Mesh, Shape, SkyLight, Texels};

pub use model::load_models;

use crate::diagnostic::Diagnostic;
use crate::eval::limits;
use crate::eval::machine::not_yet;
use crate::files::{Files, diagnose, resolve};
use crate::lower::{Lowered, MeshFrom, MeshRequest};
use crate::source::{Span, Texts};
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

/// Reads a mesh from the bytes of a file; `name` decides the format by its ending.
///
/// # Errors
/// E0801 for bytes that are not such a file, E0803 for a mesh that cannot be used, E0806 for too many triangles.
pub fn read_mesh(name: &str, bytes: &[u8]) -> Result<Mesh, AssetError> {
    let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    let mut mesh = match ending.as_str() {
        "obj" => obj::read(bytes)?,
        "ply" => ply::read(bytes)?,
        _ => {
            let mut error = AssetError::unreadable("is not a mesh file this program knows");
            error.help = "meshes are read from `.obj` and `.ply`";
            return Err(error);
        }
    };
    mesh.name = name.to_string();
    if mesh.triangles.len() > limits::TRIANGLES {
        let millions = mesh.triangles.len() / 1_000_000;
        let message = format!("has {millions} M triangles, limit {} M", limits::TRIANGLES / 1_000_000);
        return Err(AssetError { code: "E0806", message, help: "decimate it" });
    }
    Ok(mesh)
}

/// Checks a mesh and makes it what the scene asks for.
fn finish(mut mesh: Mesh, smooth: Option<bool>, fit: Option<f64>) -> Result<Mesh, AssetError> {
    mesh.validate().map_err(|error| AssetError::unusable(error.to_string()))?;
    match smooth {
        Some(true) => mesh.normals = shape::smooth_normals(&mesh),
        Some(false) => mesh.normals.clear(),
        None => shape::repair_normals(&mut mesh),
    }
    if let Some(length) = fit
        && !shape::fit(&mut mesh, length)
    {
        return Err(AssetError::unusable("has no extent to `fit`"));
    }
    mesh.validate().map_err(|error| AssetError::unusable(error.to_string()))?;
    Ok(mesh)
}

/// Puts the meshes into the scene.
pub fn load_meshes(lowered: &mut Lowered, files: &dyn Files, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    type Key = (String, Option<bool>, Option<u64>);
    let mut known: HashMap<Key, Result<Arc<Mesh>, ()>> = HashMap::new();
    let mut open: HashMap<*const Mesh, usize> = HashMap::new();
    for request in &lowered.meshes {
        let key = match &request.from {
            MeshFrom::File(written) => {
                let from = &source.source(request.span.start).name;
                let path = resolve(from, written).unwrap_or_else(|_| written.to_string());
                Some((path, request.smooth, request.fit.map(f64::to_bits)))
            }
            MeshFrom::Lists(_) => None,
        };
        let before = key.as_ref().and_then(|key| known.get(key)).cloned();
        let mesh = match before {
            Some(mesh) => mesh,
            None => {
                let mesh =
                    load(request, files, source).map(Arc::new).map_err(|diagnostic| diagnostics.push(*diagnostic));
                if let Some(key) = key {
                    known.insert(key, mesh.clone());
                }
                mesh
            }
        };
        if let (Ok(mesh), Some(span)) = (&mesh, request.glass) {
            let count = *open.entry(Arc::as_ptr(mesh)).or_insert_with(|| shape::boundary_edges(mesh));
            diagnostics.extend((count > 0).then(|| open_glass(count, source, span)));
        }
        if let (Ok(mesh), Some(node)) = (mesh, lowered.scene.nodes.get_mut(request.node)) {
            node.shape = Some(Shape::Mesh(mesh));
        }
    }
}

/// Puts the picture of the sky into the scene.
pub fn load_sky(lowered: &mut Lowered, files: &dyn Files, source: &Texts, diagnostics: &mut Vec<Diagnostic>) {
    let (Some(request), Some(sky)) = (lowered.sky.take(), &mut lowered.scene.sky) else { return };
    let (file, span) = (source.id, request.span);
    let picture = match picture(&request.path, files, source, span) {
        Ok(picture) => picture,
        Err(diagnostic) => return diagnostics.push(*diagnostic),
    };
    let [width, height] = picture.size;
    let is_light = |c: &f32| *c >= 0.0 && c.is_finite();
    let bad = picture.rgb.as_chunks::<3>().0.iter().filter(|texel| !texel.iter().all(is_light)).count();
    if bad > 0 {
        let texels = if bad == 1 { "texel that is" } else { "texels that are" };
        let message = format!("`{}` has {bad} {texels} negative or not finite", request.path);
        diagnostics.push(
            Diagnostic::new("W0811", message)
                .primary(file, span, "no light comes from there")
                .note("what is negative or not a number is taken as 0, what is infinite as the largest finite value"),
        );
    }
    let largest = picture.rgb.iter().copied().filter(|c| c.is_finite()).fold(0.0, f32::max);
    let clean = |c: f32| match c {
        c if is_light(&c) => c,
        f32::INFINITY => largest,
        _ => 0.0,
    };
    let texels = picture.rgb.as_chunks::<3>().0.iter().map(|&[r, g, b]| [clean(r), clean(g), clean(b), 1.0]).collect();
    if let Some(image) = Image::new(request.path, width, height, Texels::Rgba32F(texels)) {
        sky.light = SkyLight::Map { image: Arc::new(image), rotation: request.rotation };
    }
}

fn picture(written: &str, files: &dyn Files, source: &Texts, span: Span) -> Result<hdr::LightPicture, Box<Diagnostic>> {
    let file = source.id;
    let path = resolve(&source.source(span.start).name, written).map_err(|error| error.diagnostic(file, span))?;
    let bytes = files.read(&path).map_err(|error| error.diagnostic(file, span))?;
    hdr::read(&bytes).map_err(|error| {
        let diagnostic = Diagnostic::new(error.code, format!("`{written}` {}", error.message));
        let diagnostic = diagnostic.primary(file, span, "cannot be used");
        Box::new(if error.help.is_empty() { diagnostic } else { diagnostic.help(error.help) })
    })
}

/// W0509.
fn open_glass(count: usize, source: &Texts, span: Span) -> Diagnostic {
    let edges = if count == 1 { "edge" } else { "edges" };
    Diagnostic::new("W0509", format!("glass needs a closed mesh; {count} boundary {edges}"))
        .primary(source.id, span, "light would go in and never come out, or the other way round")
        .note("absorption will be wrong")
        .help("close the mesh, or make it a sheet: `dielectric { thin: true }`")
}

fn load(request: &MeshRequest, files: &dyn Files, source: &Texts) -> Result<Mesh, Box<Diagnostic>> {
    let (file, span) = (source.id, request.span);
    let (name, mesh) = match &request.from {
        MeshFrom::Lists(mesh) => (mesh.name.clone(), Ok(mesh.clone())),
        MeshFrom::File(written) => {
            let ending = written.rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
            let models = ["gltf", "glb"];
            if ending == "stl" {
                return Err(not_yet("meshes from `.stl`", file, span).into());
            }
            if models.contains(&ending.as_str()) {
                return Err(Diagnostic::new("E0801", format!("`{written}` is not a mesh file"))
                    .primary(file, span, "a whole glTF scene")
                    .help("write `model { file: .. }`")
                    .into());
            }
            let path =
                resolve(&source.source(span.start).name, written).map_err(|error| error.diagnostic(file, span))?;
            let bytes = files
                .read(&path)
                .map_err(|error| diagnose(files, &error, (file, span), written, source.slice(span)))?;
            let mesh = read_mesh(&path, &bytes);
            (path, mesh)
        }
    };
    mesh.and_then(|mesh| finish(mesh, request.smooth, request.fit)).map_err(|error| {
        let message = match error.code {
            "E0803" => format!("mesh `{name}`: {}", error.message),
            _ => format!("`{name}` {}", error.message),
        };
        let diagnostic = Diagnostic::new(error.code, message).primary(file, span, "cannot be used");
        Box::new(if error.help.is_empty() { diagnostic } else { diagnostic.help(error.help) })
    })
}
