//! Meshes that change their form, at one instant.

use std::sync::Arc;

use glam::DAffine3;
use kinora_scene::{Form, Mesh};

use crate::{
    error::{Fault, SampleError},
    pose::{Pose, find},
    read::{Range, Reader},
};

/// The mesh as its weights and joints make it, in the space of its node; `poses` are those of the scene's nodes in the
/// world, the node's own is `place`.
pub(crate) fn formed(read: Reader<'_>, form: &Form, place: DAffine3, poses: &[Pose]) -> Result<Arc<Mesh>, SampleError> {
    let (targets, weights) = match &form.morph {
        Some(morph) => {
            let weights = morph.weights.iter().map(|weight| read.number("clip", weight, Range::Any));
            (morph.targets.as_slice(), weights.collect::<Result<Vec<f64>, _>>()?)
        }
        None => (&[][..], Vec::new()),
    };
    let joints = form.skin.as_ref().map(|skin| {
        let node_from_world = place.inverse();
        let joints = skin.joints.iter().zip(skin.bind.iter()).map(|(joint, bind)| match joint {
            Some(joint) => Ok(node_from_world * find(poses, *joint, read, "clip")? * *bind),
            None => Ok(*bind),
        });
        joints.collect::<Result<Vec<DAffine3>, SampleError>>()
    });
    let joints = joints.transpose()?;
    let skin = form.skin.as_ref().zip(joints.as_deref()).map(|(skin, joints)| (&*skin.influences, joints));
    let mesh = form.mesh.formed(targets, &weights, skin);
    match mesh.validate() {
        Ok(()) => Ok(Arc::new(mesh)),
        Err(_) => Err(read.error("clip", Fault::NotFinite)),
    }
}
