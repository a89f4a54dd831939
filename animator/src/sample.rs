//! The stage itself: a scene and a shutter give a world.

use kinora_scene::{Bsdf, Instance, Lamp, Node, Scene, Shutter, World};

use crate::{
    camera::view,
    error::{Fault, Place, SampleError},
    light::light,
    material::{look, material, shape, sky},
    pose::poses,
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

    let mut instances = Vec::new();
    for (index, (node, pose)) in scene.nodes.iter().zip(poses).enumerate() {
        if !pose.shown {
            continue;
        }
        let read = now.reader(Place::Node(index), &node.name);
        let world_from_object = pose.world_from_node?;
        let Some(geometry) = &node.shape else { continue };
        if !world_from_object.matrix3.determinant().is_normal() || !world_from_object.inverse().is_finite() {
            return Err(read.error("scale", Fault::Singular));
        }
        if node.material >= scene.materials.len() {
            return Err(read.error("material", Fault::Dangling));
        }
        let shape = shape(read, geometry)?;
        instances.push(Instance { node: index, shape, world_from_object, material: node.material });
    }

    let materials = scene.materials.iter().enumerate().map(|(index, surface)| {
        material(now.reader(Place::Material(index), ""), index, surface)
            .map_err(|error| SampleError { name: wearer(scene, index), ..error })
    });
    Ok(World {
        render: scene.render.clone(),
        look,
        shutter,
        view,
        instances,
        materials: materials.collect::<Result<_, _>>()?,
        sky: scene.sky.as_ref().map(|scene_sky| sky(now.reader(Place::Sky, "sky"), scene_sky)).transpose()?,
        lights,
    })
}

/// The name of the first node that has the material, or one that it is a part of; empty where there is none.
fn wearer(scene: &Scene, index: usize) -> String {
    let mut found = vec![false; scene.materials.len()];
    for (at, material) in scene.materials.iter().enumerate() {
        let part = |part: &usize| found.get(*part) == Some(&true);
        let here = at == index
            || match &material.bsdf {
                Bsdf::Glossy { base, .. } => part(base),
                Bsdf::Mix { a, b, .. } => part(a) || part(b),
                _ => false,
            };
        if let Some(slot) = found.get_mut(at) {
            *slot = here;
        }
    }
    let has = |node: &&Node| node.shape.is_some() && found.get(node.material) == Some(&true);
    scene.nodes.iter().find(has).map_or(String::new(), |node| node.name.clone())
}
