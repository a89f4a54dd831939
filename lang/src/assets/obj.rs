//! Wavefront OBJ, by tobj. Its materials are not looked at.

use glam::{Vec2, Vec3};
use kinora_scene::Mesh;
use tobj::LoadOptions;

use super::AssetError;

pub(super) fn read(bytes: &[u8]) -> Result<Mesh, AssetError> {
    let options = LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let mut reader = bytes;
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, |_| Ok(Default::default())).map_err(|error| {
        AssetError::unreadable(format!("is not a valid OBJ file: {}", lower_first(&error.to_string())))
    })?;
    let mut mesh = Mesh::default();
    // Attributes that only some of the models have belong to none: a mesh has one set of them.
    let with_normals = models.iter().all(|model| model.mesh.normals.len() == model.mesh.positions.len());
    let with_uvs = models.iter().all(|model| model.mesh.texcoords.len() / 2 == model.mesh.positions.len() / 3);
    for model in &models {
        let part = &model.mesh;
        let base = u32::try_from(mesh.positions.len()).map_err(|_| AssetError::unusable("has too many vertices"))?;
        mesh.positions.extend(part.positions.as_chunks::<3>().0.iter().map(|p| Vec3::from_array(*p)));
        if with_normals {
            mesh.normals
                .extend(part.normals.as_chunks::<3>().0.iter().map(|n| Vec3::from_array(*n).normalize_or_zero()));
        }
        if with_uvs {
            mesh.uvs.extend(part.texcoords.as_chunks::<2>().0.iter().map(|uv| Vec2::from_array(*uv)));
        }
        for triangle in part.indices.as_chunks::<3>().0 {
            let mut corners = [0; 3];
            for (to, index) in corners.iter_mut().zip(triangle) {
                *to = index.checked_add(base).ok_or_else(|| AssetError::unusable("has too many vertices"))?;
            }
            mesh.triangles.push(corners);
        }
    }
    Ok(mesh)
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    match characters.next() {
        Some(first) => first.to_lowercase().chain(characters).collect(),
        None => String::new(),
    }
}
