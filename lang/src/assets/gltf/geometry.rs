//! Primitives to meshes: triangles of every mode, only the vertices that are used, uv turned so that v grows upwards, and
//! what changes their form: morph targets and joints.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, Vec2, Vec3, Vec4};
use kinora_scene::{Influences, Mesh, Target};
use serde_json::Value;

use super::Fault;
use super::accessor::{Accessor, Buffers};
use super::json::{index, list, number, text};

/// Most bytes that the meshes of one model may take.
pub const MESH_BYTES: usize = 2 << 30;

/// A primitive before anything is done to it.
#[derive(Clone)]
pub struct Primitive {
    /// Its triangles.
    pub mesh: Arc<Mesh>,
    /// Its morph targets.
    pub targets: Arc<Vec<Target>>,
    /// The joints that hold its vertices, if it has some.
    pub influences: Option<Arc<Influences>>,
}

/// What a primitive is made of, as triangles; none where it has only points or lines, or no positions.
pub fn triangles(root: &Value, buffers: &Buffers<'_>, primitive: &Value) -> Result<Option<Vec<[u32; 3]>>, Fault> {
    let mode = index(primitive, "mode").unwrap_or(4);
    let attributes = primitive.get("attributes").unwrap_or(&Value::Null);
    let Some(position) = index(attributes, "POSITION") else { return Ok(None) };
    if !(4..=6).contains(&mode) {
        return Ok(None);
    }
    let indices = match index(primitive, "indices") {
        Some(at) => Some(Accessor::open(root, buffers, at)?),
        None => None,
    };
    let vertices = list(root, "accessors").get(position).and_then(|accessor| index(accessor, "count")).unwrap_or(0);
    let count = indices.as_ref().map_or(vertices, |indices| indices.count);
    let corner = |i: usize| indices.as_ref().map_or(i as u32, |indices| indices.whole(i));
    let triangle = |i: usize| match mode {
        4 => [3 * i, 3 * i + 1, 3 * i + 2],
        5 => [i, i + 1 + i % 2, i + 2 - i % 2],
        _ => [i + 1, i + 2, 0],
    };
    let triangles = (0..triangle_count(mode, count)).map(|i| triangle(i).map(corner));
    Ok(Some(triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect()))
}

fn triangle_count(mode: usize, corners: usize) -> usize {
    match mode {
        4 => corners / 3,
        5 | 6 => corners.saturating_sub(2),
        _ => 0,
    }
}

/// How many vertices and triangles a primitive says that it has.
pub fn counts(root: &Value, primitive: &Value) -> [usize; 2] {
    let count = |at: Option<usize>| at.and_then(|at| index(list(root, "accessors").get(at)?, "count"));
    let attributes = primitive.get("attributes").unwrap_or(&Value::Null);
    let vertices = count(index(attributes, "POSITION")).unwrap_or(0);
    let corners = count(index(primitive, "indices")).unwrap_or(vertices);
    [vertices, triangle_count(index(primitive, "mode").unwrap_or(4), corners)]
}

/// The vertices of `triangles`, which are renumbered: only those that are used, in the order of their first use.
fn compact(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    let mut used = Vec::new();
    if triangles.len() * 12 > vertices {
        let mut new = vec![u32::MAX; vertices];
        for corner in triangles.iter_mut().flatten() {
            let Some(slot) = new.get_mut(*corner as usize) else { continue };
            if *slot == u32::MAX {
                *slot = used.len() as u32;
                used.push(*corner);
            }
            *corner = *slot;
        }
    } else {
        let mut new: HashMap<u32, u32> = HashMap::new();
        for corner in triangles.iter_mut().flatten() {
            *corner = *new.entry(*corner).or_insert_with(|| {
                used.push(*corner);
                used.len() as u32 - 1
            });
        }
    }
    used
}

/// Bytes that a mesh of so many triangles and vertices takes at most, with so many morph targets and sets of joints.
pub fn bytes(triangles: usize, vertices: usize, targets: usize, sets: usize) -> usize {
    12 * triangles + (72 + 36 * targets + 32 * sets) * vertices
}

/// Builds a mesh. `sets`: which texture coordinates become the first and the second of the mesh.
///
/// # Errors
/// An accessor cannot be read.
pub fn mesh(
    root: &Value,
    buffers: &Buffers<'_>,
    primitive: &Value,
    mut triangles: Vec<[u32; 3]>,
    sets: [usize; 2],
) -> Result<(Mesh, Vec<Target>, Option<Influences>), Fault> {
    let attributes = primitive.get("attributes").unwrap_or(&Value::Null);
    let open = |name: &str| index(attributes, name).map(|at| Accessor::open(root, buffers, at)).transpose();
    let Some(position) = open("POSITION")? else { return Ok((Mesh::default(), Vec::new(), None)) };
    let used = compact(&mut triangles, position.count);
    let read3 = |accessor: &Accessor<'_>| -> Vec<Vec3> {
        used.iter().map(|v| Vec3::from_array(accessor.get(*v as usize))).collect()
    };
    let positions = read3(&position);
    let normals = open("NORMAL")?.map(|accessor| read3(&accessor)).unwrap_or_default();
    let tangents: Vec<Vec4> = match open("TANGENT")? {
        Some(accessor) => used.iter().map(|v| Vec4::from_array(accessor.get(*v as usize))).collect(),
        None => Vec::new(),
    };
    let mut targets = Vec::new();
    for target in list(primitive, "targets") {
        let changes = |name: &str| -> Result<Vec<Vec3>, Fault> {
            let Some(at) = index(target, name) else { return Ok(Vec::new()) };
            Ok(read3(&Accessor::open(root, buffers, at)?))
        };
        targets.push(Target {
            positions: changes("POSITION")?,
            normals: changes("NORMAL")?,
            tangents: changes("TANGENT")?,
        });
    }
    let influences = influences(&open, &used)?;
    let coordinates = |set: usize| -> Result<Vec<Vec2>, Fault> {
        Ok(match open(&format!("TEXCOORD_{set}"))? {
            Some(accessor) => used
                .iter()
                .map(|v| Vec2::from_array(accessor.get::<2>(*v as usize)))
                .map(|uv| Vec2::new(uv.x, 1.0 - uv.y))
                .collect(),
            None => Vec::new(),
        })
    };
    let colors = match open("COLOR_0")? {
        Some(accessor) => {
            let opaque = accessor.components() < 4;
            let color = |v: &u32| {
                let [r, g, b, a] = accessor.get::<4>(*v as usize);
                Vec4::new(r, g, b, if opaque { 1.0 } else { a }).clamp(Vec4::ZERO, Vec4::ONE)
            };
            used.iter().map(color).collect()
        }
        None => Vec::new(),
    };
    let mut mesh = Mesh {
        name: String::new(),
        positions,
        normals,
        uvs: coordinates(sets[0])?,
        more_uvs: coordinates(sets[1])?,
        colors,
        tangents: Vec::new(),
        triangles,
    };
    mesh.repair_normals();
    // A tangent without length has no direction: then all follow from the coordinates.
    let unit: Option<Vec<Vec3>> = tangents.iter().map(|t| t.truncate().try_normalize()).collect();
    if let Some(unit) = unit.filter(|_| !mesh.normals.is_empty()) {
        let signed = |(t, old): (Vec3, &Vec4)| t.extend(if old.w < 0.0 { -1.0 } else { 1.0 });
        mesh.tangents = unit.into_iter().zip(&tangents).map(signed).collect();
    }
    Ok((mesh, targets, influences))
}

/// How many sets of joints a primitive has.
pub fn joint_sets(primitive: &Value) -> usize {
    let attributes = primitive.get("attributes").unwrap_or(&Value::Null);
    let has = |name: String| attributes.get(name).is_some();
    (0..).take_while(|set| has(format!("JOINTS_{set}")) && has(format!("WEIGHTS_{set}"))).count()
}

/// The joints that hold the used vertices, four a set.
fn influences<'b>(
    open: &impl Fn(&str) -> Result<Option<Accessor<'b>>, Fault>,
    used: &[u32],
) -> Result<Option<Influences>, Fault> {
    let mut sets = Vec::new();
    while let (Some(which), Some(weights)) =
        (open(&format!("JOINTS_{}", sets.len()))?, open(&format!("WEIGHTS_{}", sets.len()))?)
    {
        sets.push((which, weights));
    }
    if sets.is_empty() {
        return Ok(None);
    }
    let mut found = Influences { each: 4 * sets.len(), joints: Vec::new(), weights: Vec::new() };
    for vertex in used {
        for (which, weights) in &sets {
            for c in 0..4 {
                found.joints.push(which.number(*vertex as usize, c) as u32);
                found.weights.push(weights.number(*vertex as usize, c) as f32);
            }
        }
    }
    Ok(Some(found))
}

/// The weights that the morph targets of a node have at rest.
pub fn weights(node: &Value, mesh: &Value) -> Vec<f64> {
    let of = |object: &Value| list(object, "weights").iter().filter_map(Value::as_f64).collect::<Vec<_>>();
    if node.get("weights").is_some() { of(node) } else { of(mesh) }
}

/// The matrix of a node in its parent.
pub fn local(node: &Value) -> DMat4 {
    if let Some(matrix) = super::json::numbers::<16>(node, "matrix") {
        return DMat4::from_cols_array(&matrix);
    }
    let (scale, rotation, position) = parts(node);
    DMat4::from_scale_rotation_translation(scale, rotation, position)
}

/// Scale, rotation and translation of a node without a matrix.
pub fn parts(node: &Value) -> (DVec3, glam::DQuat, DVec3) {
    let vector = |name: &str, default| super::json::numbers::<3>(node, name).map_or(default, DVec3::from_array);
    let rotation = super::json::numbers::<4>(node, "rotation").map(glam::DQuat::from_array);
    let rotation = rotation.map_or(glam::DQuat::IDENTITY, |q| q.normalize());
    (vector("scale", DVec3::ONE), rotation, vector("translation", DVec3::ZERO))
}

/// What a message calls an object of an array.
pub fn name_of(object: &Value, kind: &str, at: usize) -> String {
    match text(object, "name").filter(|name| !name.is_empty()) {
        Some(name) => name.to_string(),
        None => format!("{kind}_{at}"),
    }
}

/// A matrix as two placings, the outer one first: the singular value decomposition, U · (Σ Vᵀ). For a matrix without
/// shear the second is none.
pub fn decompose(matrix: DMat4) -> ([DVec3; 2], [glam::DQuat; 2], bool) {
    let linear = DMat3::from_mat4(matrix);
    let (scale, rotation, _) = matrix.to_scale_rotation_translation();
    let rotation = rotation.normalize();
    let again = DMat3::from_quat(rotation) * DMat3::from_diagonal(scale);
    let size = linear.to_cols_array().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let apart = (linear - again).to_cols_array().iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if rotation.is_finite() && apart <= 1e-5 * size {
        return ([scale, DVec3::ONE], [rotation, glam::DQuat::IDENTITY], false);
    }
    // Jacobi's rotations make MᵀM diagonal; their product is V.
    let mut square = linear.transpose() * linear;
    let mut v = DMat3::IDENTITY;
    for _ in 0..32 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = square.col(q)[p];
            if off.abs() <= 1e-300 {
                continue;
            }
            let angle = 0.5 * (2.0 * off).atan2(square.col(q)[q] - square.col(p)[p]);
            let (sin, cos) = angle.sin_cos();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cos;
            turn.col_mut(q)[q] = cos;
            turn.col_mut(q)[p] = sin;
            turn.col_mut(p)[q] = -sin;
            square = turn.transpose() * square * turn;
            v *= turn;
        }
    }
    let turned = linear * v;
    let mut sigma = DVec3::new(turned.x_axis.length(), turned.y_axis.length(), turned.z_axis.length());
    let column = |i: usize| turned.col(i) / sigma[i].max(1e-300);
    let mut u = DMat3::from_cols(column(0), column(1), column(2));
    if u.determinant() < 0.0 {
        u = DMat3::from_cols(u.x_axis, u.y_axis, -u.z_axis);
        sigma.z = -sigma.z;
    }
    let inner = glam::DQuat::from_mat3(&v.transpose()).normalize();
    ([sigma, DVec3::ONE], [glam::DQuat::from_mat3(&u).normalize(), inner], true)
}

/// A number with its default.
pub fn factor(object: &Value, name: &str, default: f64) -> f64 {
    number(object, name).unwrap_or(default)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheared_matrix_is_two_placings() {
        let matrix =
            DMat4::from_cols_array(&[1.0, 0.2, 0.0, 0.0, 0.7, 2.0, -0.3, 0.0, 0.1, 0.4, -1.5, 0.0, 1.0, 2.0, 3.0, 1.0]);
        let ([scale, _], [outer, inner], sheared) = decompose(matrix);
        assert!(sheared);
        let again = DMat3::from_quat(outer) * DMat3::from_diagonal(scale) * DMat3::from_quat(inner);
        assert!((again - DMat3::from_mat4(matrix)).to_cols_array().iter().all(|x| x.abs() < 1e-9), "{again}");
        let mirror = DMat4::from_scale(DVec3::new(-1.0, 2.0, 3.0));
        let ([scale, _], [outer, _], sheared) = decompose(mirror);
        assert!(!sheared);
        let again = DMat3::from_quat(outer) * DMat3::from_diagonal(scale);
        assert!((again - DMat3::from_mat4(mirror)).to_cols_array().iter().all(|x| x.abs() < 1e-9));
    }
}
