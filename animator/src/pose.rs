//! Where the nodes are, and whether they are seen.

use glam::DAffine3;
use kinora_scene::{Node, Scene};

use crate::{
    baked::Bodies,
    error::{Fault, Place, SampleError},
    read::{Now, Reader},
};

/// A node at one instant.
#[derive(Clone)]
pub(crate) struct Pose {
    /// From the node's own space to the world. A fault of a hidden node is one only for who needs the node.
    pub world_from_node: Result<DAffine3, SampleError>,
    /// Whether it and all it moves with are visible.
    pub shown: bool,
}

/// One pose a node, in the scene's order.
pub(crate) fn poses(scene: &Scene, now: Now) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::with_capacity(scene.nodes.len());
    let mut bodies = Bodies::of(scene.physics.baked.as_deref());
    for (index, node) in scene.nodes.iter().enumerate() {
        let read = now.reader(Place::Node(index), &node.name);
        let shown = node.parent.and_then(|parent| poses.get(parent)).is_none_or(|parent| parent.shown);
        let mut world_from_node = match bodies.world_from_node(index, now.time_s) {
            Some(place) => Ok(place),
            None => world_from(&poses, node, read),
        };
        let visible = visible(node, read, &mut world_from_node);
        poses.push(Pose { world_from_node, shown: shown && !node.only_copied && visible });
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

/// The node `root` and all that moves with it, with their poses in the space that `root` is placed in; whether `root` is
/// visible does not count. `children`: those of each node.
pub(crate) fn within(
    scene: &Scene,
    now: Now,
    root: usize,
    children: &[Vec<usize>],
    poses: &[Pose],
) -> Vec<(usize, Pose)> {
    let mut found: Vec<(usize, Pose)> = Vec::new();
    // What is still to be placed, and what it moves with.
    let mut open = vec![(root, None)];
    while let Some((index, parent)) = open.pop() {
        let (Some(node), true) = (scene.nodes.get(index), found.len() < poses.len()) else { continue };
        let read = now.reader(Place::Node(index), &node.name);
        let above: Option<&Pose> = parent.and_then(|at: usize| found.get(at)).map(|(_, pose)| pose);
        let mut world_from_node = match above {
            Some(above) => above.world_from_node.clone().and_then(|above| placed(above, node, read)),
            None => placed(DAffine3::IDENTITY, node, read),
        };
        let shown = above.is_none_or(|above| above.shown && visible(node, read, &mut world_from_node));
        let at = Some(found.len());
        found.push((index, Pose { world_from_node, shown }));
        open.extend(children.get(index).into_iter().flatten().rev().map(|child| (*child, at)));
    }
    found
}

/// Whether a transform has an inverse that numbers can hold.
pub(crate) fn has_volume(pose: DAffine3) -> bool {
    pose.matrix3.determinant().is_normal() && pose.inverse().is_finite()
}

/// Whether the node itself is visible; where that cannot be said it is, and its pose tells who needs it.
fn visible(node: &Node, read: Reader<'_>, pose: &mut Result<DAffine3, SampleError>) -> bool {
    if node.vanishes && pose.as_ref().is_ok_and(|pose| !has_volume(*pose)) {
        return false;
    }
    read.flag("visible", &node.visible).unwrap_or_else(|error| {
        *pose = Err(error);
        true
    })
}

/// How a node is placed in what it moves with.
#[cfg(feature = "physics")]
pub(crate) fn local(scene: &Scene, now: Now, index: usize) -> Result<DAffine3, SampleError> {
    let node = &scene.nodes[index];
    placed(DAffine3::IDENTITY, node, now.reader(Place::Node(index), &node.name))
}

fn world_from(earlier: &[Pose], node: &Node, read: Reader<'_>) -> Result<DAffine3, SampleError> {
    let world_from_parent = match node.parent {
        Some(parent) => find(earlier, parent, read, "parent")?,
        None => DAffine3::IDENTITY,
    };
    placed(world_from_parent, node, read)
}

fn placed(world_from_parent: DAffine3, node: &Node, read: Reader<'_>) -> Result<DAffine3, SampleError> {
    let position = read.vector("position", &node.placing.position)?;
    let rotation = read.rotation("rotation", &node.placing.rotation)?;
    let scale = read.vector("scale", &node.placing.scale)?;
    if scale.cmpeq(glam::DVec3::ZERO).any() && !node.vanishes {
        return Err(read.error("scale", Fault::Singular));
    }
    let world_from_node = world_from_parent * DAffine3::from_scale_rotation_translation(scale, rotation, position);
    // Each part is finite: only a chain of parents can carry it off.
    if world_from_node.is_finite() { Ok(world_from_node) } else { Err(read.error("position", Fault::NotFinite)) }
}
