//! Triangle meshes.

use glam::{Vec2, Vec3};
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
    /// A position, normal or uv is NaN or infinite.
    NotFinite {
        /// Which vertex.
        vertex: usize,
    },
    /// `normals` or `uvs` is neither empty nor as long as `positions`.
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
            MeshError::Length => write!(f, "normals or uvs do not match the positions in number"),
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
        if !fits(self.normals.len()) || !fits(self.uvs.len()) {
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
        };
        match (0..count).find(|&v| !finite(v)) {
            Some(vertex) => Err(MeshError::NotFinite { vertex }),
            None => Ok(()),
        }
    }
}
