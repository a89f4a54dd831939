//! The stage itself: a scene and a shutter give a world.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use kinora_scene::{
    Animated, Copied, Form, Instance, Lamp, Light, LightKind, Node, Part, Placement, Scene, Shape, Shutter, Still,
    World,
};

use crate::{
    camera::view,
    error::{Fault, Place, SampleError},
    form::formed,
    light::light,
    material::{look, material, shape, sky},
    moments::moments,
    pose::{Pose, find, has_volume, poses, within},
    read::Now,
};

/// The scene when the shutter opens: every value, every transform in the world, what is invisible left out. A group that
/// is invisible hides what moves with it, but not a camera. With it come the moments of the time that the shutter is open:
/// the world in the middle of equal steps, each of them evaluated from the tracks, so that what turns runs on an arc. There
/// are so many that nothing goes farther than half a pixel from one to the next, as far as samples and the scene's size
/// let it.
///
/// # Errors
/// The first property, in the order look, camera, lights, nodes, materials, sky, that has no usable value at that time; see
/// [`Fault`]. Nodes that nobody sees or needs are not judged.
pub fn sample(scene: &Scene, shutter: Shutter) -> Result<World, SampleError> {
    exposed(scene, shutter, false)
}

/// As [`sample`], with where all of it is at the next frame: a frame's time after the shutter opens, whatever is seen then.
///
/// # Errors
/// As [`sample`], and what has no usable place at the next frame.
pub fn sample_moving(scene: &Scene, shutter: Shutter) -> Result<World, SampleError> {
    exposed(scene, shutter, true)
}

fn exposed(scene: &Scene, shutter: Shutter, moving: bool) -> Result<World, SampleError> {
    let open = world(scene, shutter, shutter.open_s, moving)?;
    let moments = moments(scene, shutter, |time_s| world(scene, shutter, time_s, false))?;
    Ok(World { moments, ..open })
}

/// Where the nodes are at an instant.
struct Stage {
    now: Now,
    poses: Vec<Pose>,
}

impl Stage {
    fn at(scene: &Scene, time_s: f64) -> Self {
        let now = Now { time_s, fps: scene.clock.fps };
        Self { now, poses: poses(scene, now) }
    }
}

fn world(scene: &Scene, shutter: Shutter, time_s: f64, moving: bool) -> Result<World, SampleError> {
    let stage = Stage::at(scene, time_s);
    let Stage { now, ref poses } = stage;
    let next = moving.then(|| Stage::at(scene, time_s + 1.0 / scene.clock.fps));

    let no_camera = || now.reader(Place::Render, "render").error("camera", Fault::NoCamera);
    let camera_index = scene.camera.ok_or_else(no_camera)?;
    let camera = scene.cameras.get(camera_index).ok_or_else(no_camera)?;

    let look = look(now.reader(Place::Render, "render"), &scene.look)?;
    let view_of = |now: Now, poses: &[Pose]| view(now.reader(Place::Camera(camera_index), &camera.name), camera, poses);
    let view = view_of(now, poses)?;
    let next_view = next.as_ref().map(|next| view_of(next.now, &next.poses)).transpose()?;

    let mut lights = Vec::new();
    for index in 0..scene.lights.len() {
        lights.extend(lamp(scene, index, &stage, next.as_ref())?);
    }

    let mut collected = Collected {
        scene,
        now,
        poses,
        next: next.as_ref(),
        name: scene.nodes.len() + scene.lights.len(),
        roots: Vec::new(),
    };
    let mut seen = Part::default();
    for (index, pose) in poses.iter().enumerate() {
        if pose.shown {
            let next = next.as_ref().and_then(|next| next.poses.get(index));
            collected.add(&mut seen, index, pose, next)?;
        }
    }
    let parts = collected.parts(poses)?;

    let materials = scene.materials.iter().enumerate().map(|(index, surface)| {
        material(now.reader(Place::Material(index), ""), index, surface)
            .map_err(|error| SampleError { name: wearer(scene, index), ..error })
    });
    Ok(World {
        render: scene.render.clone(),
        look,
        shutter,
        view,
        next: next_view,
        instances: seen.instances,
        copies: seen.copies,
        parts,
        materials: materials.collect::<Result<_, _>>()?,
        sky: scene.sky.as_ref().map(|scene_sky| sky(now.reader(Place::Sky, "sky"), scene_sky)).transpose()?,
        lights,
        moments: Arc::default(),
    })
}

/// What is seen, as far as it is gathered.
struct Collected<'s> {
    scene: &'s Scene,
    now: Now,
    /// Where the nodes are in the world.
    poses: &'s [Pose],
    /// The next frame, if motion is wanted.
    next: Option<&'s Stage>,
    /// What the next copy is called.
    name: usize,
    /// The nodes that are copied, by the index of their part.
    roots: Vec<usize>,
}

impl Collected<'_> {
    /// Adds what the node itself shows, placed by `pose` and at the next frame by `next`.
    fn add(&mut self, part: &mut Part, index: usize, pose: &Pose, next: Option<&Pose>) -> Result<(), SampleError> {
        let Some(node) = self.scene.nodes.get(index) else { return Ok(()) };
        let read = self.now.reader(Place::Node(index), &node.name);
        let place = pose.world_from_node.clone()?;
        let next = next.map(|next| next.world_from_node.clone()).transpose()?;
        if (node.shape.is_some() || node.copies.is_some()) && !has_volume(place) {
            return Err(read.error("scale", Fault::Singular));
        }
        let unknown = |material: usize| material >= self.scene.materials.len();
        if let Some(geometry) = &node.shape {
            if unknown(node.material) {
                return Err(read.error("material", Fault::Dangling));
            }
            let form = |now: Now, form: &Form, poses: &[Pose]| {
                let read = now.reader(Place::Node(index), &node.name);
                formed(read, form, find(poses, index, read, "clip")?, poses)
            };
            let (still, next_mesh) = match (&node.form, self.next) {
                (Some(bends), later) => {
                    let mesh = form(self.now, bends, self.poses)?;
                    let next = later.map(|later| form(later.now, bends, &later.poses)).transpose()?;
                    let next = next.filter(|next| next.positions != mesh.positions);
                    (Shape::Mesh(mesh), next)
                }
                (None, _) => (shape(read, geometry)?, None),
            };
            let next = match (next, &still) {
                (Some(next), Shape::Sphere { radius_m }) => {
                    let later = self.next.map_or(self.now, |stage| stage.now).reader(Place::Node(index), &node.name);
                    match shape(later, geometry)? {
                        Shape::Sphere { radius_m: later_m } if later_m != *radius_m => {
                            Some(next * DAffine3::from_scale(DVec3::splat(later_m / radius_m)))
                        }
                        _ => Some(next),
                    }
                }
                (next, _) => next,
            };
            part.instances.push(Instance {
                node: index,
                shape: still,
                world_from_object: place,
                next,
                next_mesh,
                material: node.material,
            });
        }
        if let Some(copies) = &node.copies {
            if copies.material.is_some_and(unknown) {
                return Err(read.error("material", Fault::Dangling));
            }
            if copies.of >= self.scene.nodes.len() {
                return Err(read.error("of", Fault::Dangling));
            }
            let places = |from: DAffine3| {
                let own = |at: &Placement| {
                    from * DAffine3::from_scale_rotation_translation(at.scale, at.rotation, at.position)
                };
                copies.at.iter().map(own).collect::<Vec<_>>()
            };
            let found = self.roots.iter().position(|root| *root == copies.of);
            let part_index = found.unwrap_or_else(|| {
                self.roots.push(copies.of);
                self.roots.len() - 1
            });
            let (first, material) = (self.name, copies.material);
            self.name += copies.at.len();
            let (places, next) = (places(place), next.map_or_else(Vec::new, places));
            part.copies.push(Copied { node: index, first, part: part_index, places, next, material });
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
            // The same nodes in the same order.
            let later = self.next.map(|next| within(self.scene, next.now, root, &children, &next.poses));
            for (k, (index, pose)) in inner.iter().enumerate().filter(|(_, (_, pose))| pose.shown) {
                let next = later.as_ref().and_then(|later| later.get(k)).map(|(_, pose)| pose);
                self.add(&mut part, *index, pose, next)?;
            }
            part.lights = self.lamps(inner, later, poses)?;
            parts.push(part);
        }
        Ok(parts)
    }

    /// The lamps that move with the nodes of a part: these, with their poses in it now and at the next frame.
    fn lamps(
        &self,
        inner: Vec<(usize, Pose)>,
        later: Option<Vec<(usize, Pose)>>,
        poses: &[Pose],
    ) -> Result<Vec<Lamp>, SampleError> {
        let of_part = |light: &Light<Animated>| {
            light.parent.is_some_and(|parent| inner.iter().any(|(index, _)| *index == parent))
        };
        if !self.scene.lights.iter().any(of_part) {
            return Ok(Vec::new());
        }
        let wanted: Vec<usize> = (0..self.scene.lights.len()).filter(|i| of_part(&self.scene.lights[*i])).collect();
        let stage = |now: Now, poses: &[Pose], inner: Vec<(usize, Pose)>| {
            let mut poses = poses.to_vec();
            for (index, pose) in inner {
                if let Some(slot) = poses.get_mut(index) {
                    *slot = pose;
                }
            }
            Stage { now, poses }
        };
        let now = stage(self.now, poses, inner);
        let next = self.next.zip(later).map(|(next, later)| stage(next.now, &next.poses, later));
        let mut lamps = Vec::new();
        for index in wanted {
            lamps.extend(lamp(self.scene, index, &now, next.as_ref())?);
        }
        Ok(lamps)
    }
}

/// The light with this index, as it is placed now and at the next frame.
fn lamp(scene: &Scene, index: usize, now: &Stage, next: Option<&Stage>) -> Result<Option<Lamp>, SampleError> {
    let placed = |stage: &Stage| light(stage.now, index, &scene.lights[index], &stage.poses);
    let Some(still) = placed(now)? else { return Ok(None) };
    let next = next.map(placed).transpose()?.flatten().and_then(|later| {
        let ((from, from_m), (to, to_m)) = (ball(&still)?, ball(&later)?);
        let carried = DAffine3::from_translation(to) * DAffine3::from_scale(DVec3::splat(to_m / from_m));
        ((from, from_m) != (to, to_m)).then(|| carried * DAffine3::from_translation(-from))
    });
    Ok(Some(Lamp { node: scene.nodes.len() + index, light: still, next }))
}

/// Centre and radius of a lamp that is a sphere.
fn ball(light: &Light<Still>) -> Option<(DVec3, f64)> {
    match light.kind {
        LightKind::Point { position, radius_m, .. } | LightKind::Spot { position, radius_m, .. } if radius_m > 0.0 => {
            Some((position, radius_m))
        }
        _ => None,
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
