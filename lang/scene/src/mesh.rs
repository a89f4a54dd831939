//! Triangle meshes.

use glam::{Vec2, Vec3, Vec4};
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

impl Mesh {
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
