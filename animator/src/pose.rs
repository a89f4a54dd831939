//! Where the nodes are, and whether they are seen.

use glam::DAffine3;
use kinora_scene::{Node, Scene};

use crate::{
    error::{Fault, Place, SampleError},
    read::{Now, Reader},
};

/// A node at one instant.
pub(crate) struct Pose {
    /// From the node's own space to the world. A fault of a hidden node is one only for who needs the node.
    pub world_from_node: Result<DAffine3, SampleError>,
    /// Whether it and all it moves with are visible.
    pub shown: bool,
}

/// One pose a node, in the scene's order.
pub(crate) fn poses(scene: &Scene, now: Now) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::with_capacity(scene.nodes.len());
    for (index, node) in scene.nodes.iter().enumerate() {
        let read = now.reader(Place::Node(index), &node.name);
        let shown = node.parent.and_then(|parent| poses.get(parent)).is_none_or(|parent| parent.shown);
        let world_from_node = world_from(&poses, node, read);
        poses.push(Pose { world_from_node, shown: shown && read.flag(&node.visible) });
    }
    poses
}

/// The transform to the world of the node with this index, as `read`'s `property` refers to it.
pub(crate) fn find(
    poses: &[Pose],
    index: usize,
    read: Reader<'_>,
    property: &'static str,
) -> Result<DAffine3, SampleError> {
    match poses.get(index) {
        Some(pose) => pose.world_from_node.clone(),
        None => Err(read.error(property, Fault::Dangling)),
    }
}

fn world_from(earlier: &[Pose], node: &Node, read: Reader<'_>) -> Result<DAffine3, SampleError> {
    let world_from_parent = match node.parent {
        Some(parent) => find(earlier, parent, read, "parent")?,
        None => DAffine3::IDENTITY,
    };
    let position = read.vector("position", &node.placing.position)?;
    let rotation = read.rotation("rotation", &node.placing.rotation)?;
    let scale = read.vector("scale", &node.placing.scale)?;
    if scale.cmpeq(glam::DVec3::ZERO).any() {
        return Err(read.error("scale", Fault::Singular));
    }
    let world_from_node = world_from_parent * DAffine3::from_scale_rotation_translation(scale, rotation, position);
    // Each part is finite: only a chain of parents can carry it off.
    if world_from_node.is_finite() { Ok(world_from_node) } else { Err(read.error("position", Fault::NotFinite)) }
}
