//! What looks like a mistake in space: lights shut in, flat shapes in one plane, the tiny beside the huge. Only what
//! stands still is looked at, and only as much of it as takes no time to speak of.

use std::collections::HashMap;

use glam::{DAffine3, DVec2, DVec3};
use kinora_scene::{Animated, Bsdf, LightKind, Material, Node, Scene, Shape, corners};

use super::Lower;
use crate::diagnostic::Diagnostic;
use crate::value::NodeId;

/// Most pairs of shapes that are compared for one kind of mistake.
const PAIRS: usize = 1_000_000;

/// Sizes further apart than this leave too few bits of an f32 for the smaller.
const SPAN: f64 = 1e6;

impl Lower<'_, '_> {
    /// W0506.
    fn shut_in(&mut self, lamp: NodeId, shell: NodeId) {
        let message = format!("light `{}` is inside `{}` and cannot be seen", self.name(lamp), self.name(shell));
        let diagnostic = Diagnostic::new("W0506", message)
            .primary(self.machine.file(), self.span(lamp), "shines in here")
            .label(self.machine.file(), self.span(shell), "lets no light out")
            .help("move it out");
        self.report(lamp, diagnostic);
    }

    /// W0401, W0506 and W0510.
    pub(super) fn judge_space(&mut self, scene: &Scene, shining: &[bool]) {
        let worlds = worlds(&scene.nodes);
        let mut ids = vec![NodeId(u32::MAX); scene.nodes.len()];
        for ((id, _), index) in self.found.placed.iter().zip(&self.order) {
            if let Some(slot) = ids.get_mut(*index) {
                *slot = *id;
            }
        }
        // What is in error may be meant to be elsewhere.
        let whole = |id: &NodeId| {
            let node = self.machine.done(*id);
            node.is_none_or(|node| node.properties.iter().all(|set| set.data.is_some()))
        };
        let still: Vec<usize> = (0..scene.nodes.len())
            .filter(|index| worlds.get(*index).is_some_and(Option::is_some) && ids.get(*index).is_none_or(whole))
            .collect();
        let id = |index: usize| ids.get(index).copied().unwrap_or(NodeId(u32::MAX));
        let at = |index: usize| Some((scene.nodes.get(index)?, worlds.get(index).copied().flatten()?));
        for [lamp, shell] in shut_in(scene, shining, &still, &at) {
            self.shut_in(id(lamp), id(shell));
        }
        for (lamp, shell) in lamps_shut_in(scene, &worlds, &still, &at) {
            let Some(lamp) = self.lamps.get(lamp).copied() else { continue };
            self.shut_in(lamp, id(shell));
        }
        for [a, b] in coplanar(&still, &at) {
            let (a, b) = (id(a), id(b));
            let message = format!("z-fighting: `{}` and `{}` share a plane", self.name(a), self.name(b));
            let diagnostic = Diagnostic::new("W0510", message)
                .primary(self.machine.file(), self.span(b), "which of the two is seen here is left to chance")
                .label(self.machine.file(), self.span(a), "in the same place")
                .help("move one by 1mm");
            self.report(b, diagnostic);
        }
        if let Some((small, far, ratio)) = widest(shining, &still, &at) {
            let orders = ratio.log10().ceil();
            let message = format!("scene spans {orders} orders of magnitude; float precision will show");
            let (small, far) = (id(small), id(far));
            let diagnostic = Diagnostic::new("W0401", message)
                .primary(self.machine.file(), self.span(small), "smallest of all")
                .label(self.machine.file(), self.span(far), "larger or further away by so much")
                .help("check units: a length without one is in metres");
            self.report(small, diagnostic);
        }
    }
}

/// The transform of each node that stands still and is there.
fn worlds(nodes: &[Node]) -> Vec<Option<DAffine3>> {
    let mut worlds: Vec<Option<DAffine3>> = Vec::with_capacity(nodes.len());
    for node in nodes {
        let outer = match node.parent {
            Some(parent) => worlds.get(parent).copied().flatten(),
            None => Some(DAffine3::IDENTITY),
        };
        let placing = &node.placing;
        let own = match (placing.scale.constant(), placing.rotation.constant(), placing.position.constant()) {
            (Some(scale), Some(rotation), Some(position))
                if node.visible.constant() == Some(&true) && !node.only_copied =>
            {
                Some(DAffine3::from_scale_rotation_translation(*scale, *rotation, *position))
            }
            _ => None,
        };
        worlds.push(outer.zip(own).map(|(outer, own)| outer * own).filter(|world| world.is_finite()));
    }
    worlds
}

/// As [`Shape::half_size`], of a shape that stays as it is.
fn half_size(shape: &Shape<Animated>) -> Option<DVec3> {
    shape.half_size(|radius_m| radius_m.constant().copied())
}

/// Whether no light goes through each material.
fn opaque(materials: &[Material<Animated>]) -> Vec<bool> {
    let mut opaque: Vec<bool> = Vec::with_capacity(materials.len());
    for material in materials {
        let part = |index: usize| opaque.get(index) == Some(&true);
        let solid = match &material.bsdf {
            Bsdf::Diffuse { .. } | Bsdf::Metal { .. } | Bsdf::Emitter { .. } => true,
            Bsdf::Dielectric { .. } => false,
            Bsdf::Glossy { .. } | Bsdf::Sheen { .. } | Bsdf::Mix { .. } => {
                material.bsdf.parts().is_some_and(|parts| parts.into_iter().all(part))
            }
        };
        opaque.push(solid && material.opacity.constant() == Some(&1.0));
    }
    opaque
}

/// Lights that are wholly inside a closed opaque shape, with that shape, where the camera is not inside as well.
fn shut_in<'s>(
    scene: &'s Scene,
    shining: &[bool],
    still: &[usize],
    at: &impl Fn(usize) -> Option<(&'s Node, DAffine3)>,
) -> Vec<[usize; 2]> {
    let Some((eye, shells)) = shells(scene, still, at) else { return Vec::new() };
    let mut found = Vec::new();
    let mut pairs = 0;
    for lamp in still {
        let Some((node, world)) = at(*lamp).filter(|(node, _)| shining.get(node.material) == Some(&true)) else {
            continue;
        };
        let Some(half) = node.shape.as_ref().and_then(half_size) else { continue };
        pairs += shells.len();
        if pairs > PAIRS {
            break;
        }
        let shell = shells.iter().find(|(index, shell, local)| {
            let within = |p: DVec3| inside(shell, local.transform_point3(p));
            *index != *lamp && !within(eye) && corners(half).all(|corner| within(world.transform_point3(corner)))
        });
        found.extend(shell.map(|(shell, ..)| [*lamp, *shell]));
    }
    found
}

/// As [`shut_in`], of lamps: the light's index, and the shape's.
fn lamps_shut_in<'s>(
    scene: &'s Scene,
    worlds: &[Option<DAffine3>],
    still: &[usize],
    at: &impl Fn(usize) -> Option<(&'s Node, DAffine3)>,
) -> Vec<(usize, usize)> {
    if scene.lights.is_empty() {
        return Vec::new();
    }
    let Some((eye, shells)) = shells(scene, still, at) else { return Vec::new() };
    let mut found = Vec::new();
    for (index, light) in scene.lights.iter().enumerate().take(PAIRS / shells.len().max(1)) {
        let (LightKind::Point { position, power, radius_m } | LightKind::Spot { position, power, radius_m, .. }) =
            &light.kind
        else {
            continue;
        };
        let around = match light.parent {
            Some(parent) => worlds.get(parent).copied().flatten(),
            None => Some(DAffine3::IDENTITY),
        };
        let (Some(around), Some(position)) = (around, position.constant()) else { continue };
        if power.constant() == Some(&0.0) {
            continue;
        }
        let place = around.transform_point3(*position);
        let shell = shells.iter().find(|(_, shell, local)| {
            let within = |p: DVec3| inside(shell, local.transform_point3(p));
            !within(eye) && corners(DVec3::splat(*radius_m)).all(|corner| within(place + corner))
        });
        found.extend(shell.map(|(shell, ..)| (index, *shell)));
    }
    found
}

/// Where the camera stands, and the closed opaque shapes with the way into their own space.
type Shells<'s> = (DVec3, Vec<(usize, &'s Node, DAffine3)>);

fn shells<'s>(
    scene: &'s Scene,
    still: &[usize],
    at: &impl Fn(usize) -> Option<(&'s Node, DAffine3)>,
) -> Option<Shells<'s>> {
    let camera = scene.camera.and_then(|camera| scene.cameras.get(camera)).filter(|camera| camera.parent.is_none())?;
    let eye = *camera.position.constant()?;
    let opaque = opaque(&scene.materials);
    let mut shells = Vec::new();
    for index in still {
        let Some((node, world)) = at(*index) else { continue };
        let closed = matches!(node.shape, Some(Shape::Sphere { .. } | Shape::Box { .. }));
        if closed && opaque.get(node.material) == Some(&true) && world.matrix3.determinant() != 0.0 {
            shells.push((*index, node, world.inverse()));
        }
    }
    Some((eye, shells))
}

/// Whether a point in a shape's own space is inside of it.
fn inside(node: &Node, p: DVec3) -> bool {
    match &node.shape {
        Some(Shape::Sphere { radius_m }) => radius_m.constant().is_some_and(|radius| p.length() < *radius),
        Some(Shape::Box { size_m }) => (2.0 * p.abs()).cmplt(*size_m).all(),
        _ => false,
    }
}

/// A rectangle or an infinite plane in the world.
struct Flat {
    index: usize,
    normal: DVec3,
    centre: DVec3,
    /// Half the width and half the height; none for a plane.
    half: Option<[DVec3; 2]>,
}

/// Flat shapes that lie over one another in one plane; of each the first other one.
fn coplanar<'s>(still: &[usize], at: &impl Fn(usize) -> Option<(&'s Node, DAffine3)>) -> Vec<[usize; 2]> {
    let mut planes: HashMap<[i64; 4], Vec<Flat>> = HashMap::new();
    let mut found = Vec::new();
    let mut pairs = 0;
    for index in still {
        let Some((node, world)) = at(*index) else { continue };
        let (frame, size) = match &node.shape {
            Some(Shape::Quad { frame, size_m }) => (frame, Some(*size_m)),
            Some(Shape::Plane { frame }) => (frame, None),
            _ => continue,
        };
        let side = |axis: DVec3| world.transform_vector3(axis);
        let Some(normal) = side(frame.x).cross(side(frame.y)).try_normalize() else { continue };
        // One of the two normals of the plane, the same for shapes that face away from one another.
        let first = normal.to_array().into_iter().find(|part| part.abs() > 1e-9).unwrap_or(1.0);
        let normal = normal * first.signum();
        let half = size.map(|size: DVec2| [0.5 * size.x * side(frame.x), 0.5 * size.y * side(frame.y)]);
        let flat = Flat { index: *index, normal, centre: world.translation, half };
        // Neighbours over the edge of a cell are missed; what is written to be in one plane is in one cell, though.
        let cell = |x: f64| (x * 1e6).round() as i64;
        let key = [cell(normal.x), cell(normal.y), cell(normal.z), cell(normal.dot(flat.centre))];
        let others = planes.entry(key).or_default();
        pairs += others.len();
        if pairs > PAIRS {
            break;
        }
        let other = others.iter().find(|other| overlap(other, &flat));
        found.extend(other.map(|other| [other.index, *index]));
        others.push(flat);
    }
    found
}

/// Whether two shapes in one plane have an area in common: no side of either parts them.
fn overlap(a: &Flat, b: &Flat) -> bool {
    let (Some(a_half), Some(b_half)) = (a.half, b.half) else { return true };
    let between = b.centre - a.centre;
    a_half.into_iter().chain(b_half).all(|side| {
        let axis = a.normal.cross(side).normalize_or_zero();
        let reach = |half: [DVec3; 2]| half.into_iter().map(|side| side.dot(axis).abs()).sum::<f64>();
        let (a, b) = (reach(a_half), reach(b_half));
        between.dot(axis).abs() < a + b - 1e-6 * a.min(b)
    })
}

/// The smallest shape and the one that is largest or furthest from it, where they are too far apart. A light may be as
/// far away as it likes.
fn widest<'s>(
    shining: &[bool],
    still: &[usize],
    at: &impl Fn(usize) -> Option<(&'s Node, DAffine3)>,
) -> Option<(usize, usize, f64)> {
    let mut sizes = Vec::new();
    for index in still {
        let Some((node, world)) = at(*index) else { continue };
        let Some(half) = node.shape.as_ref().and_then(half_size) else { continue };
        let reach = corners(half).map(|corner| world.transform_vector3(corner).length()).fold(0.0, f64::max);
        let lit = shining.get(node.material) == Some(&true);
        if reach > 0.0 && reach.is_finite() {
            sizes.push((*index, world.translation, reach, lit));
        }
    }
    let (small, centre, size, _) = *sizes.iter().min_by(|a, b| a.2.total_cmp(&b.2))?;
    let away = |(_, other, reach, _): &(usize, DVec3, f64, bool)| (*other - centre).length() + *reach;
    let far = sizes.iter().filter(|shape| !shape.3).max_by(|a, b| away(a).total_cmp(&away(b)))?;
    let ratio = away(far) / size;
    (ratio > SPAN && far.0 != small).then_some((small, far.0, ratio))
}
