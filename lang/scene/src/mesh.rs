//! Triangle meshes.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

/// An indexed triangle mesh. Normals point outwards; corners run counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Mesh {
    /// Where it came from, for messages: a path in the project, or the node's name.
    pub name: String,
    /// Metres, in the shape's own space.
    pub positions: Vec<Vec3>,
    /// One a position, unit length; empty for flat triangles.
    pub normals: Vec<Vec3>,
    /// One a position, v up; empty if there are none.
    pub uvs: Vec<Vec2>,
    /// A second set of them, for textures that ask for it; empty if there is none.
    #[serde(default)]
    pub more_uvs: Vec<Vec2>,
    /// One a position, linear Rec. 709 and opacity; empty if there are none.
    #[serde(default)]
    pub colors: Vec<Vec4>,
    /// One a position: the unit direction of growing u along the surface, and 1, or -1 where v grows to the right of it,
    /// seen from outside. Empty: they follow from `uvs`.
    #[serde(default)]
    pub tangents: Vec<Vec4>,
    /// Three indices a triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// What is wrong with a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MeshError {
    /// A triangle refers to a vertex that is not there.
    Index {
        /// The vertex referred to.
        vertex: u32,
        /// How many there are.
        count: usize,
    },
    /// A position, normal, uv, colour or tangent is NaN or infinite.
    NotFinite {
        /// Which vertex.
        vertex: usize,
    },
    /// What a vertex has besides its position is neither empty nor as long as `positions`.
    Length,
    /// There is no triangle.
    Empty,
}

impl std::fmt::Display for MeshError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MeshError::Index { vertex, count } => {
                write!(f, "a triangle refers to vertex {vertex} of {count}")
            }
            MeshError::NotFinite { vertex } => write!(f, "vertex {vertex} is not a finite number"),
            MeshError::Length => write!(f, "normals, uvs, colours or tangents do not match the positions in number"),
            MeshError::Empty => write!(f, "there are no triangles"),
        }
    }
}

impl std::error::Error for MeshError {}

/// What is not finite is no mesh: each is equal to itself, so that one in the memory need not be looked at twice.
impl Eq for Mesh {}

impl Mesh {
    /// Normals that are the mean of the triangles around a point, weighted by their angles there (Thürmer and Wüthrich,
    /// "Computing Vertex Normals from Polygonal Facets", 1998). Vertices in one place share them, so that seams of uv
    /// coordinates do not show. The mesh must be valid.
    pub fn smooth_normals(&self) -> Vec<Vec3> {
        // -0 and 0 are one place.
        let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut sums: HashMap<[u32; 3], DVec3> = HashMap::with_capacity(self.positions.len());
        for triangle in &self.triangles {
            let corners = triangle.map(|corner| self.positions[corner as usize].as_dvec3());
            let Some(normal) = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize() else {
                continue;
            };
            for i in 0..3 {
                let (a, b) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
                let place = key(self.positions[triangle[i] as usize]);
                *sums.entry(place).or_default() += normal * a.angle_between(b);
            }
        }
        let of = |p: &Vec3| sums.get(&key(*p)).and_then(|sum| sum.try_normalize()).unwrap_or(DVec3::Y).as_vec3();
        self.positions.iter().map(of).collect()
    }

    /// Replaces normals without length, which some programs write, by computed ones, and makes the others unit. The mesh
    /// must be valid.
    pub fn repair_normals(&mut self) {
        let unit = |normal: &Vec3| (normal.length_squared() - 1.0).abs() < 1e-3;
        if self.normals.iter().all(unit) {
            return;
        }
        let computed = self.smooth_normals();
        for (normal, computed) in self.normals.iter_mut().zip(computed) {
            if !unit(normal) {
                *normal = normal.try_normalize().unwrap_or(computed);
            }
        }
    }

    /// Checks what everything that reads a mesh relies on.
    ///
    /// # Errors
    /// The first fault found, as [`MeshError`] describes.
    pub fn validate(&self) -> Result<(), MeshError> {
        let count = self.positions.len();
        let fits = |len: usize| len == 0 || len == count;
        let lengths = [self.normals.len(), self.uvs.len(), self.more_uvs.len(), self.colors.len(), self.tangents.len()];
        if !lengths.into_iter().all(fits) {
            return Err(MeshError::Length);
        }
        if self.triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        if let Some(&vertex) = self.triangles.iter().flatten().find(|&&v| v as usize >= count) {
            return Err(MeshError::Index { vertex, count });
        }
        let finite = |v: usize| {
            self.positions[v].is_finite()
                && self.normals.get(v).is_none_or(|n| n.is_finite())
                && self.uvs.get(v).is_none_or(|uv| uv.is_finite())
                && self.more_uvs.get(v).is_none_or(|uv| uv.is_finite())
                && self.colors.get(v).is_none_or(|color| color.is_finite())
                && self.tangents.get(v).is_none_or(|tangent| tangent.is_finite())
        };
        match (0..count).find(|&v| !finite(v)) {
            Some(vertex) => Err(MeshError::NotFinite { vertex }),
            None => Ok(()),
        }
    }
}
