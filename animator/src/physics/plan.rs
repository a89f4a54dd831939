//! What physics sees of a scene, and nothing else: a material, a camera or a light makes no difference here.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use kinora_scene::{Body, BodyKind, Collider, JointKind, Mass, Mesh, Placing, Scene, Shape, Simulation, Still};
use serde::Serialize;

use super::BakeError;
use crate::{
    error::{Fault, Place},
    material::shape,
    pose::{Pose, local, poses},
    read::Now,
};

/// Poses that one bake may hold, 4 GiB of them.
pub const MOST_POSES: u64 = (4 << 30) / size_of::<kinora_scene::Pose>() as u64;

/// Shapes that one body may be made of.
const MOST_PARTS: usize = 100_000;

/// A simulation that is ready to be set up.
pub struct Plan<'s> {
    pub scene: &'s Scene,
    pub simulation: &'s Simulation,
    pub steps: u64,
    /// What positions are measured from: in the middle of what moves, so that they have all their bits.
    pub origin: DVec3,
    /// By node.
    pub bodies: Vec<Planned<'s>>,
    pub joints: Vec<PlannedJoint>,
}

/// A body at 0 s.
pub struct Planned<'s> {
    pub body: &'s Body,
    /// The node's origin in the world.
    pub position: DVec3,
    /// How it is turned; what else there is of its transform is in its parts.
    pub rotation: DQuat,
    /// From the node's space to that of the pose.
    pub pose_from_node: DAffine3,
    /// What it is made of.
    pub parts: Vec<PlannedPart>,
}

/// A shape of a body.
pub struct PlannedPart {
    pub pose_from_shape: DAffine3,
    pub shape: Shape<Still>,
}

/// A joint between two of the bodies, by their indices.
pub struct PlannedJoint {
    pub a: usize,
    pub b: usize,
    /// In the world at 0 s.
    pub anchor: DVec3,
    pub kind: JointKind,
}

/// The plan of a scene's simulation; `None` where forces move nothing.
///
/// # Errors
/// Something has no place at 0 s, or there are too many poses.
pub fn plan(scene: &Scene) -> Result<Option<Plan<'_>>, BakeError> {
    let physics = &scene.physics;
    if !physics.is_dynamic() {
        return Ok(None);
    }
    let simulation = &physics.simulation;
    let (steps, moving) = (simulation.step_count(), physics.bodies.iter().filter(|body| dynamic(body)).count() as u64);
    if steps.saturating_add(1).saturating_mul(moving) > MOST_POSES {
        return Err(BakeError::TooLarge { poses: steps.saturating_add(1).saturating_mul(moving) });
    }
    let stage = Stage::of(scene);
    let mut order: Vec<&Body> = physics.bodies.iter().collect();
    order.sort_by_key(|body| body.node);
    let mut bodies = Vec::with_capacity(order.len());
    for body in order {
        bodies.push(stage.body(body)?);
    }
    let places = bodies.iter().filter(|planned| dynamic(planned.body)).map(|planned| planned.position);
    let (low, high) = places.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let origin = (0.5 * (low + high)).round();
    let find = |node: usize| bodies.binary_search_by_key(&node, |planned| planned.body.node).ok();
    let mut joints = Vec::with_capacity(physics.joints.len());
    for joint in &physics.joints {
        let (Some(a), Some(b)) = (find(joint.a), find(joint.b)) else { continue };
        let anchor = joint.anchor.unwrap_or(bodies[a].position);
        joints.push(PlannedJoint { a, b, anchor, kind: joint.kind });
    }
    let origin = if origin.is_finite() { origin } else { DVec3::ZERO };
    Ok(Some(Plan { scene, simulation, steps, origin, bodies, joints }))
}

/// How many bodies, and triangles of meshes to be taken apart into convex ones, are set up without one having to wait.
const QUICK_BODIES: usize = 5_000;
const QUICK_TRIANGLES: usize = 3_000;

impl Plan<'_> {
    /// Whether it is set up in a moment.
    pub fn is_quick(&self) -> bool {
        let apart =
            self.bodies.iter().filter(|planned| dynamic(planned.body) && planned.body.collider == Collider::Auto);
        let triangles = apart.flat_map(|planned| &planned.parts).map(|part| match &part.shape {
            Shape::Mesh(mesh) => mesh.triangles.len(),
            _ => 0,
        });
        self.bodies.len() <= QUICK_BODIES && triangles.sum::<usize>() <= QUICK_TRIANGLES
    }
}

pub fn dynamic(body: &Body) -> bool {
    body.kind == BodyKind::Dynamic
}

/// A scene at 0 s.
struct Stage<'s> {
    scene: &'s Scene,
    now: Now,
    poses: Vec<Pose>,
    children: Vec<Vec<usize>>,
    /// Whether each node is a body.
    is_body: Vec<bool>,
}

impl<'s> Stage<'s> {
    fn of(scene: &'s Scene) -> Self {
        let now = Now { time_s: 0.0, fps: scene.clock.fps };
        let mut children = vec![Vec::new(); scene.nodes.len()];
        for (index, node) in scene.nodes.iter().enumerate() {
            if let Some(children) = node.parent.and_then(|parent| children.get_mut(parent)) {
                children.push(index);
            }
        }
        let mut is_body = vec![false; scene.nodes.len()];
        for body in &scene.physics.bodies {
            if let Some(slot) = is_body.get_mut(body.node) {
                *slot = true;
            }
        }
        Self { scene, now, poses: poses(scene, now), children, is_body }
    }

    fn fault(&self, node: usize, property: &'static str, fault: Fault) -> BakeError {
        let name = self.scene.nodes.get(node).map_or("", |node| &node.name);
        BakeError::Sample(self.now.reader(Place::Node(node), name).error(property, fault))
    }

    fn body(&self, body: &'s Body) -> Result<Planned<'s>, BakeError> {
        let pose = self.poses.get(body.node).ok_or_else(|| self.fault(body.node, "parent", Fault::Dangling))?;
        let world = pose.world_from_node.clone().map_err(BakeError::Sample)?;
        if !world.matrix3.determinant().is_normal() {
            return Err(self.fault(body.node, "scale", Fault::Singular));
        }
        let rotation = rotation_of(world.matrix3);
        let frame = DAffine3::from_rotation_translation(rotation, world.translation);
        let pose_from_node = DAffine3 {
            // What is taken out again, so that nothing is lost but the rotation.
            matrix3: DMat3::from_quat(rotation.inverse()) * world.matrix3,
            translation: DVec3::ZERO,
        };
        let mut parts = Vec::new();
        self.parts(body.node, frame.inverse() * world, &mut parts)?;
        if parts.is_empty() {
            return Err(self.shapeless(body.node, "there is no shape in it"));
        }
        Ok(Planned { body, position: world.translation, rotation, pose_from_node, parts })
    }

    fn shapeless(&self, node: usize, why: &'static str) -> BakeError {
        let name = self.scene.nodes.get(node).map_or(String::new(), |node| node.name.clone());
        BakeError::Shapeless { name, why }
    }

    /// What the body of a node is made of: its own shape, else all that is in it and no body itself.
    fn parts(&self, root: usize, place: DAffine3, parts: &mut Vec<PlannedPart>) -> Result<(), BakeError> {
        let Some(node) = self.scene.nodes.get(root) else { return Ok(()) };
        if let Some(own) = &node.shape {
            self.part(root, place, parts)?;
            // A mesh of several materials has a node for each of them.
            if let Shape::Mesh(mesh) = own {
                for child in self.children.get(root).into_iter().flatten() {
                    let Some(node) = self.scene.nodes.get(*child) else { continue };
                    let same = matches!(&node.shape, Some(Shape::Mesh(part)) if part.name == mesh.name);
                    if same && node.placing == Placing::default() {
                        self.part(*child, place, parts)?;
                    }
                }
            }
            return Ok(());
        }
        // What is still to be looked at, and from where to the body's pose; copies may hold copies.
        let mut open = vec![(root, place, true)];
        while let Some((index, place, is_root)) = open.pop() {
            let Some(node) = self.scene.nodes.get(index) else { continue };
            if !is_root && self.is_body.get(index) == Some(&true) {
                continue;
            }
            if node.shape.is_some() {
                self.part(index, place, parts)?;
            }
            if parts.len() > MOST_PARTS || open.len() > MOST_PARTS {
                return Err(self.shapeless(root, "it is made of too many shapes"));
            }
            for child in self.children.get(index).into_iter().flatten().rev() {
                open.push((*child, place * self.local(*child)?, false));
            }
            if let Some(copies) = &node.copies {
                for at in copies.at.iter().rev() {
                    let own = DAffine3::from_scale_rotation_translation(at.scale, at.rotation, at.position);
                    open.push((copies.of, place * own * self.local(copies.of)?, true));
                }
            }
        }
        Ok(())
    }

    /// How a node is placed in what it moves with.
    fn local(&self, index: usize) -> Result<DAffine3, BakeError> {
        if index >= self.scene.nodes.len() {
            return Err(self.fault(index, "of", Fault::Dangling));
        }
        local(self.scene, self.now, index).map_err(BakeError::Sample)
    }

    fn part(&self, index: usize, place: DAffine3, parts: &mut Vec<PlannedPart>) -> Result<(), BakeError> {
        let Some(node) = self.scene.nodes.get(index) else { return Ok(()) };
        let read = self.now.reader(Place::Node(index), &node.name);
        if let Some(geometry) = &node.shape {
            let shape = shape(read, geometry).map_err(BakeError::Sample)?;
            parts.push(PlannedPart { pose_from_shape: place, shape });
        }
        Ok(())
    }
}

/// The rotation nearest to a transform, by its first two axes where it has no shear; always one.
pub fn rotation_of(matrix: DMat3) -> DQuat {
    let x = matrix.x_axis.try_normalize().unwrap_or(DVec3::X);
    let y = (matrix.y_axis - x * matrix.y_axis.dot(x)).try_normalize().unwrap_or(x.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()
}

impl Plan<'_> {
    /// Where the node of a body is by its own tracks and those of what it moves with: its origin and its rotation.
    pub fn pose_at(&self, time_s: f64, body: usize) -> Result<(DVec3, DQuat), BakeError> {
        let now = Now { time_s, fps: self.scene.clock.fps };
        let mut world = DAffine3::IDENTITY;
        let mut at = Some(self.bodies[body].body.node);
        // A parent's index is smaller: this ends.
        while let Some(index) = at {
            world = local(self.scene, now, index).map_err(BakeError::Sample)? * world;
            at = self.scene.nodes[index].parent.filter(|parent| *parent < index);
        }
        Ok((world.translation, rotation_of(world.matrix3)))
    }

    /// The bodies that forces move, by their indices among all.
    pub fn moving(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.bodies.len()).filter(|index| dynamic(self.bodies[*index].body))
    }

    /// What the result depends on: two plans with one key have one result, on one kind of machine.
    pub fn key(&self) -> [u8; 32] {
        let mut key = Key { hasher: blake3::Hasher::new(), meshes: HashMap::new() };
        key.add(&(super::VERSION, rapier3d::VERSION, self.steps));
        key.add(&(self.simulation.gravity, self.simulation.rate_hz, self.origin));
        key.add(&(self.bodies.len(), self.joints.len()));
        for planned in &self.bodies {
            key.body(self, planned);
        }
        for joint in &self.joints {
            key.add(&(joint.a, joint.b, joint.anchor, joint.kind));
        }
        *key.hasher.finalize().as_bytes()
    }
}

/// A hash as it grows.
struct Key {
    hasher: blake3::Hasher,
    /// A mesh is there many times more often than it is looked at.
    meshes: HashMap<*const Mesh, [u8; 32]>,
}

impl Key {
    fn add<T: Serialize>(&mut self, value: &T) {
        // Plain data always serialises.
        let bytes = postcard::to_allocvec(value).unwrap_or_default();
        self.hasher.update(&(bytes.len() as u64).to_le_bytes());
        self.hasher.update(&bytes);
    }

    fn body(&mut self, plan: &Plan<'_>, planned: &Planned<'_>) {
        let body = planned.body;
        self.add(&(planned.position, planned.rotation, body.kind, body.friction, body.restitution, body.collider));
        match body.kind {
            BodyKind::Fixed => {}
            BodyKind::Kinematic => {
                self.add(&plan.scene.clock.fps);
                let mut at = Some(body.node);
                while let Some(index) = at {
                    let node = &plan.scene.nodes[index];
                    self.add(&node.placing);
                    at = node.parent.filter(|parent| *parent < index);
                }
            }
            BodyKind::Dynamic => {
                self.add(&(body.mass, body.velocity, body.angular_velocity));
                self.add(&(body.linear_damping, body.angular_damping, body.impulse, body.impulse_at_s));
            }
        }
        self.add(&planned.parts.len());
        for part in &planned.parts {
            self.add(&part.pose_from_shape);
            match &part.shape {
                Shape::Mesh(mesh) => {
                    let hash = *self.meshes.entry(Arc::as_ptr(mesh)).or_insert_with(|| hash(mesh));
                    self.add(&hash);
                }
                other => self.add(other),
            }
        }
    }
}

/// Of where its triangles are.
fn hash(mesh: &Mesh) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(mesh.positions.len() as u64).to_le_bytes());
    for p in &mesh.positions {
        let [x, y, z] = p.to_array().map(f32::to_le_bytes);
        hasher.update(&[x, y, z].concat());
    }
    for triangle in &mesh.triangles {
        hasher.update(&triangle.map(u32::to_le_bytes).concat());
    }
    *hasher.finalize().as_bytes()
}

impl PlannedPart {
    /// Whether it goes on without end.
    pub fn is_plane(&self) -> bool {
        matches!(self.shape, Shape::Plane { .. })
    }
}

impl Planned<'_> {
    /// Whether something was said of its mass as a whole.
    pub fn total_kg(&self) -> Option<f64> {
        match self.body.mass {
            Mass::Total(kg) => Some(kg),
            Mass::Density(_) => None,
        }
    }
}
