//! Meshes that change their form: morph targets and skins, as glTF has them.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::{Mesh, Track};

/// What a node's mesh is made of at each time, instead of standing still.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Form {
    /// The mesh before anything is done to it.
    pub mesh: Arc<Mesh>,
    /// What is added to it first.
    pub morph: Option<Morph>,
    /// What carries it then.
    pub skin: Option<Skin>,
}

/// Changes to a mesh, by weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Morph {
    /// The changes.
    pub targets: Arc<Vec<Target>>,
    /// How much of each; targets without one are left out.
    pub weights: Vec<Track<f64>>,
}

/// One change: what is added to each vertex at weight 1. Empty where nothing is; else one a vertex.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Metres.
    pub positions: Vec<Vec3>,
    /// To unit normals, which are made unit again.
    pub normals: Vec<Vec3>,
    /// To the directions of tangents, which are made unit again.
    pub tangents: Vec<Vec3>,
}

/// Joints that carry vertices. Where the mesh's node is does not count: its vertices follow the joints alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skin {
    /// Indices into [`crate::Scene::nodes`]; none: a joint that stays where the mesh's node is.
    pub joints: Vec<Option<usize>>,
    /// From the mesh to each joint, as both were when the one was bound to the other.
    pub bind: Arc<Vec<DAffine3>>,
    /// What follows which.
    pub influences: Arc<Influences>,
}

/// Which joints each vertex follows, and how much.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Influences {
    /// How many a vertex.
    pub each: usize,
    /// Indices into [`Skin::joints`], `each` a vertex.
    pub joints: Vec<u32>,
    /// 0 or more, as many; made to sum to 1 where a vertex is placed.
    pub weights: Vec<f32>,
}

impl Mesh {
    /// The mesh with these targets by these weights added, then carried by joints: from the mesh in bind pose to where it
    /// is, a matrix a joint. glTF 2.0, 3.7.2.2 and 3.7.3. A vertex that no joint holds stays.
    ///
    /// Total: what there is too little of is left out.
    pub fn formed(&self, targets: &[Target], weights: &[f64], skin: Option<(&Influences, &[DAffine3])>) -> Mesh {
        let double = |v: &Vec3| v.as_dvec3();
        let mut positions: Vec<DVec3> = self.positions.iter().map(double).collect();
        let mut normals: Vec<DVec3> = self.normals.iter().map(double).collect();
        let mut tangents: Vec<DVec3> = self.tangents.iter().map(|t| t.truncate().as_dvec3()).collect();
        for (target, weight) in targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            let add = |values: &mut [DVec3], changes: &[Vec3]| {
                for (value, change) in values.iter_mut().zip(changes) {
                    *value += *weight * change.as_dvec3();
                }
            };
            add(&mut positions, &target.positions);
            add(&mut normals, &target.normals);
            add(&mut tangents, &target.tangents);
        }
        if let Some((influences, joints)) = skin {
            for (vertex, position) in positions.iter_mut().enumerate() {
                let Some(matrix) = influences.of(vertex, joints) else { continue };
                *position = matrix.transform_point3(*position);
                let linear = matrix.matrix3;
                if let Some(tangent) = tangents.get_mut(vertex) {
                    *tangent = linear * *tangent;
                }
                if let Some(normal) = normals.get_mut(vertex) {
                    // The cofactors: no inverse is needed, and a mirror keeps the outside outside.
                    let cofactors = DMat3::from_cols(
                        linear.y_axis.cross(linear.z_axis),
                        linear.z_axis.cross(linear.x_axis),
                        linear.x_axis.cross(linear.y_axis),
                    );
                    *normal = cofactors * *normal;
                }
            }
        }
        let single = |v: &DVec3| v.as_vec3();
        // Lengths may be tiny or huge, and singles are too small for their squares.
        let unit = |v: &DVec3| v.try_normalize().map_or(Vec3::ZERO, |v| v.as_vec3());
        let mut mesh = Mesh {
            positions: positions.iter().map(single).collect(),
            normals: normals.iter().map(unit).collect(),
            tangents: Vec::new(),
            ..self.clone()
        };
        mesh.repair_normals();
        // A tangent without length has no direction: then all follow from the coordinates.
        let unit: Option<Vec<_>> = tangents.iter().map(|tangent| tangent.try_normalize()).collect();
        if let Some(unit) = unit {
            let signed = |(tangent, old): (DVec3, &glam::Vec4)| tangent.as_vec3().extend(old.w);
            mesh.tangents = unit.into_iter().zip(&self.tangents).map(signed).collect();
        }
        mesh
    }
}

impl Influences {
    /// The mean of the joints' matrices that carries a vertex; none where no joint holds it.
    fn of(&self, vertex: usize, joints: &[DAffine3]) -> Option<DAffine3> {
        let span = vertex * self.each..(vertex + 1) * self.each;
        let (which, weights) = (self.joints.get(span.clone())?, self.weights.get(span)?);
        let (mut linear, mut moved, mut sum) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for (joint, weight) in which.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
            let Some(joint) = joints.get(*joint as usize) else { continue };
            let weight = f64::from(*weight);
            linear += joint.matrix3 * weight;
            moved += joint.translation * weight;
            sum += weight;
        }
        (sum > 0.0).then(|| DAffine3 { matrix3: linear * (1.0 / sum), translation: moved / sum })
    }
}
