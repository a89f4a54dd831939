//! The stage itself: a scene and a shutter give a world.

use glam::DAffine3;
use kinora_scene::{Animated, Copied, Instance, Lamp, Light, Node, Part, Scene, Shutter, World};

use crate::{
    camera::view,
    error::{Fault, Place, SampleError},
    light::light,
    material::{look, material, shape, sky},
    pose::{Pose, poses, within},
    read::Now,
};

/// The scene when the shutter opens: every value, every transform in the world, what is invisible left out. A group that
/// is invisible hides what moves with it, but not a camera.
///
/// # Errors
/// The first property, in the order look, camera, lights, nodes, materials, sky, that has no usable value at that time; see
/// [`Fault`]. Nodes that nobody sees or needs are not judged.
pub fn sample(scene: &Scene, shutter: Shutter) -> Result<World, SampleError> {
    let now = Now { time_s: shutter.open_s, fps: scene.clock.fps };
    let poses = poses(scene, now);

    let no_camera = || now.reader(Place::Render, "render").error("camera", Fault::NoCamera);
    let camera_index = scene.camera.ok_or_else(no_camera)?;
    let camera = scene.cameras.get(camera_index).ok_or_else(no_camera)?;

    let look = look(now.reader(Place::Render, "render"), &scene.look)?;
    let view = view(now.reader(Place::Camera(camera_index), &camera.name), camera, &poses)?;

    let mut lights = Vec::new();
    for (index, scene_light) in scene.lights.iter().enumerate() {
        let node = scene.nodes.len() + index;
        lights.extend(light(now, index, scene_light, &poses)?.map(|light| Lamp { node, light }));
    }

    let mut collected = Collected { scene, now, next: scene.nodes.len() + scene.lights.len(), roots: Vec::new() };
    let mut seen = Part::default();
    for (index, pose) in poses.iter().enumerate() {
        if pose.shown {
            collected.add(&mut seen, index, pose.world_from_node.clone()?)?;
        }
    }
    let parts = collected.parts(&poses)?;

    let materials = scene.materials.iter().enumerate().map(|(index, surface)| {
        material(now.reader(Place::Material(index), ""), index, surface)
            .map_err(|error| SampleError { name: wearer(scene, index), ..error })
    });
    Ok(World {
        render: scene.render.clone(),
        look,
        shutter,
        view,
        instances: seen.instances,
        copies: seen.copies,
        parts,
        materials: materials.collect::<Result<_, _>>()?,
        sky: scene.sky.as_ref().map(|scene_sky| sky(now.reader(Place::Sky, "sky"), scene_sky)).transpose()?,
        lights,
    })
}

/// What is seen, as far as it is gathered.
struct Collected<'s> {
    scene: &'s Scene,
    now: Now,
    /// What the next copy is called.
    next: usize,
    /// The nodes that are copied, by the index of their part.
    roots: Vec<usize>,
}

impl Collected<'_> {
    /// Adds what the node itself shows.
    fn add(&mut self, part: &mut Part, index: usize, place: DAffine3) -> Result<(), SampleError> {
        let Some(node) = self.scene.nodes.get(index) else { return Ok(()) };
        let read = self.now.reader(Place::Node(index), &node.name);
        let singular = || !place.matrix3.determinant().is_normal() || !place.inverse().is_finite();
        if (node.shape.is_some() || node.copies.is_some()) && singular() {
            return Err(read.error("scale", Fault::Singular));
        }
        let unknown = |material: usize| material >= self.scene.materials.len();
        if let Some(geometry) = &node.shape {
            if unknown(node.material) {
                return Err(read.error("material", Fault::Dangling));
            }
            let shape = shape(read, geometry)?;
            part.instances.push(Instance { node: index, shape, world_from_object: place, material: node.material });
        }
        if let Some(copies) = &node.copies {
            if copies.material.is_some_and(unknown) {
                return Err(read.error("material", Fault::Dangling));
            }
            if copies.of >= self.scene.nodes.len() {
                return Err(read.error("of", Fault::Dangling));
            }
            let places = copies
                .at
                .iter()
                .map(|at| place * DAffine3::from_scale_rotation_translation(at.scale, at.rotation, at.position));
            let found = self.roots.iter().position(|root| *root == copies.of);
            let part_index = found.unwrap_or_else(|| {
                self.roots.push(copies.of);
                self.roots.len() - 1
            });
            let (first, places) = (self.next, places.collect::<Vec<_>>());
            self.next += places.len();
            part.copies.push(Copied { node: index, first, part: part_index, places, material: copies.material });
        }
        Ok(())
    }

    /// The parts of what was added, and of what is added by them.
    fn parts(mut self, poses: &[Pose]) -> Result<Vec<Part>, SampleError> {
        let mut parts = Vec::new();
        if self.roots.is_empty() {
            return Ok(parts);
        }
        let mut children = vec![Vec::new(); self.scene.nodes.len()];
        for (index, node) in self.scene.nodes.iter().enumerate() {
            if let Some(children) = node.parent.and_then(|parent| children.get_mut(parent)) {
                children.push(index);
            }
        }
        while let Some(root) = self.roots.get(parts.len()).copied() {
            let mut part = Part::default();
            let inner = within(self.scene, self.now, root, &children, poses);
            for (index, pose) in inner.iter().filter(|(_, pose)| pose.shown) {
                self.add(&mut part, *index, pose.world_from_node.clone()?)?;
            }
            part.lights = self.lamps(inner, poses)?;
            parts.push(part);
        }
        Ok(parts)
    }

    /// The lamps that move with the nodes of a part.
    fn lamps(&self, inner: Vec<(usize, Pose)>, poses: &[Pose]) -> Result<Vec<Lamp>, SampleError> {
        let of_part = |light: &Light<Animated>| {
            light.parent.is_some_and(|parent| inner.iter().any(|(index, _)| *index == parent))
        };
        if !self.scene.lights.iter().any(of_part) {
            return Ok(Vec::new());
        }
        let wanted: Vec<usize> = (0..self.scene.lights.len()).filter(|i| of_part(&self.scene.lights[*i])).collect();
        let mut poses = poses.to_vec();
        for (index, pose) in inner {
            if let Some(slot) = poses.get_mut(index) {
                *slot = pose;
            }
        }
        let mut lamps = Vec::new();
        for index in wanted {
            let node = self.scene.nodes.len() + index;
            let light = light(self.now, index, &self.scene.lights[index], &poses)?;
            lamps.extend(light.map(|light| Lamp { node, light }));
        }
        Ok(lamps)
    }
}

/// The name of the first node that has the material, or one that it is a part of; empty where there is none.
fn wearer(scene: &Scene, index: usize) -> String {
    let mut found = vec![false; scene.materials.len()];
    for (at, material) in scene.materials.iter().enumerate() {
        let part = |part: &usize| found.get(*part) == Some(&true);
        let here = at == index || material.bsdf.parts().is_some_and(|parts| parts.iter().any(part));
        if let Some(slot) = found.get_mut(at) {
            *slot = here;
        }
    }
    let has = |node: &&Node| node.shape.is_some() && found.get(node.material) == Some(&true);
    scene.nodes.iter().find(has).map_or(String::new(), |node| node.name.clone())
}
