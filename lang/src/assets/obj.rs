//! Wavefront OBJ, by tobj: polygons are cut into triangles here, and files of materials are asked for.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

use glam::{Vec2, Vec3, Vec4};
use kinora_scene::Mesh;
use tobj::{LoadError, LoadOptions};

use super::AssetError;
use super::shape::add_polygon;

/// What an OBJ file has.
#[derive(Debug, Default)]
pub struct Object {
    /// All of its triangles.
    pub mesh: Mesh,
    /// Runs of them that are one object of one material.
    pub parts: Vec<ObjectPart>,
    /// The materials of its files of materials.
    pub materials: Vec<tobj::Material>,
    /// What cannot be found or read of them, each a clause.
    pub missing: Vec<String>,
}

/// Triangles of one object and one material.
#[derive(Debug)]
pub struct ObjectPart {
    /// Of the object or group.
    pub name: String,
    /// Index into the materials; none if the file names none, or one that is not there.
    pub material: Option<usize>,
    /// Which triangles.
    pub triangles: Range<usize>,
}

/// Reads an OBJ file; `library` gives the bytes of a file of materials by its name, or says why there are none.
pub fn read(bytes: &[u8], library: &dyn Fn(&str) -> Result<Vec<u8>, String>) -> Result<Object, AssetError> {
    let options = LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };
    // Comments of other days are in other encodings.
    let text = String::from_utf8_lossy(bytes);
    let missing = RefCell::new(Vec::new());
    let materials = |written: &std::path::Path| {
        let written = written.to_string_lossy();
        let (found, errors) = libraries(&written, library);
        missing.borrow_mut().extend(errors);
        let mut all = (Vec::new(), HashMap::new());
        for (name, bytes) in found {
            match tobj::load_mtl_buf(&mut String::from_utf8_lossy(&bytes).as_bytes()) {
                Ok((more, map)) => {
                    let first = all.0.len();
                    all.0.extend(more);
                    let names: &mut HashMap<String, usize> = &mut all.1;
                    names.extend(map.into_iter().map(|(name, at)| (name, at + first)));
                }
                Err(error) => missing
                    .borrow_mut()
                    .push(format!("materials in `{name}` that cannot be read: {}", lower_first(&error.to_string()))),
            }
        }
        Ok::<_, LoadError>(all)
    };
    let (models, materials) = tobj::load_obj_buf(&mut text.as_bytes(), &options, materials).map_err(|error| {
        let outside = matches!(
            error,
            LoadError::FaceVertexOutOfBounds
                | LoadError::FaceTexCoordOutOfBounds
                | LoadError::FaceNormalOutOfBounds
                | LoadError::FaceColorOutOfBounds
        );
        match outside {
            true => AssetError::unusable("a face refers to a vertex that is not there"),
            false => AssetError::unreadable(format!("is not a valid OBJ file: {}", lower_first(&error.to_string()))),
        }
    })?;
    let materials = materials.unwrap_or_default();
    let mut missing = missing.into_inner();
    if missing.is_empty() {
        unknown_names(&text, &materials, &mut missing);
    }
    let mut object = Object { materials, missing, ..Object::default() };
    let mesh = &mut object.mesh;
    let any = |has: &dyn Fn(&tobj::Mesh) -> bool| models.iter().any(|model| has(&model.mesh));
    // What only some of the models have is filled up: a mesh has one set of everything.
    let with_normals = any(&|part| !part.normals.is_empty());
    let with_uvs = any(&|part| !part.texcoords.is_empty());
    let with_colors = any(&|part| !part.vertex_color.is_empty());
    for model in &models {
        let part = &model.mesh;
        let base = u32::try_from(mesh.positions.len()).map_err(|_| AssetError::unusable("has too many vertices"))?;
        mesh.positions.extend(part.positions.as_chunks::<3>().0.iter().map(|p| Vec3::from_array(*p)));
        let count = mesh.positions.len();
        if with_normals {
            let whole = part.normals.len() == part.positions.len();
            let normals = part.normals.as_chunks::<3>().0.iter().filter(|_| whole);
            mesh.normals.extend(normals.map(|n| Vec3::from_array(*n).normalize_or_zero()));
            mesh.normals.resize(count, Vec3::ZERO);
        }
        if with_uvs {
            let whole = part.texcoords.len() / 2 == part.positions.len() / 3;
            let uvs = part.texcoords.as_chunks::<2>().0.iter().filter(|_| whole);
            mesh.uvs.extend(uvs.map(|uv| Vec2::from_array(*uv)));
            mesh.uvs.resize(count, Vec2::ZERO);
        }
        if with_colors {
            let whole = part.vertex_color.len() == part.positions.len();
            let colors = part.vertex_color.as_chunks::<3>().0.iter().filter(|_| whole);
            mesh.colors.extend(colors.map(|&[r, g, b]| Vec4::new(r, g, b, 1.0)));
            mesh.colors.resize(count, Vec4::ONE);
        }
        let mut corners = Vec::with_capacity(part.indices.len());
        for index in &part.indices {
            corners.push(index.checked_add(base).ok_or_else(|| AssetError::unusable("has too many vertices"))?);
        }
        let first = mesh.triangles.len();
        if part.face_arities.is_empty() {
            mesh.triangles.extend_from_slice(corners.as_chunks::<3>().0);
        } else {
            let mut rest = corners.as_slice();
            for count in &part.face_arities {
                let Some((face, after)) = rest.split_at_checked(*count as usize) else { break };
                add_polygon(&mesh.positions, face, &mut mesh.triangles);
                rest = after;
            }
        }
        let triangles = first..mesh.triangles.len();
        if !triangles.is_empty() {
            let material = part.material_id.filter(|at| *at < object.materials.len());
            object.parts.push(ObjectPart { name: model.name.clone(), material, triangles });
        }
    }
    Ok(object)
}

type Files = Vec<(String, Vec<u8>)>;

/// The files that a line names: all of it is one name with spaces, or each word is one.
fn libraries(written: &str, library: &dyn Fn(&str) -> Result<Vec<u8>, String>) -> (Files, Vec<String>) {
    let whole = match library(written) {
        Ok(bytes) => return (vec![(written.to_string(), bytes)], Vec::new()),
        Err(error) => error,
    };
    // Some programs write a backslash before a space that belongs to a name.
    let escaped = written.replace("\\ ", "\u{1}");
    let words: Vec<String> = escaped.split_whitespace().map(|word| word.replace('\u{1}', " ")).collect();
    if words.len() < 2 {
        return (Vec::new(), vec![whole]);
    }
    let (mut found, mut errors) = (Vec::new(), Vec::new());
    for word in words {
        match library(&word) {
            Ok(bytes) => found.push((word, bytes)),
            Err(error) => errors.push(error),
        }
    }
    (found, errors)
}

/// Materials that the file uses and that nothing says more about.
fn unknown_names(text: &str, materials: &[tobj::Material], missing: &mut Vec<String>) {
    let known: HashSet<&str> = materials.iter().map(|material| material.name.as_str()).collect();
    let mut unknown = HashSet::new();
    for name in text.lines().filter_map(|line| line.trim_start().strip_prefix("usemtl ")).map(str::trim) {
        if !known.contains(name) && unknown.insert(name) {
            missing.push(format!("a material `{name}` that its file of materials does not have"));
        }
    }
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    match characters.next() {
        Some(first) => first.to_lowercase().chain(characters).collect(),
        None => String::new(),
    }
}
