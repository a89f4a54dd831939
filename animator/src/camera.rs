//! The camera at one instant.

use glam::{DAffine3, DMat3, DVec3};
use kinora_scene::{Aim, Animated, Camera, Projection, Still, Track, View};

use crate::{
    aim::{facing, rotation_of},
    error::{Fault, SampleError},
    pose::{Pose, find},
    read::{Range, Reader},
};

/// Distance of the plane in focus where nothing depends on it: a pinhole that looks at no point.
const PINHOLE_FOCUS_M: f64 = 1.0;

/// Where the camera is and how it looks. The scale of what it moves with carries its position along but neither its
/// lens nor its axes.
pub(crate) fn view(read: Reader<'_>, camera: &Camera<Animated>, poses: &[Pose]) -> Result<View, SampleError> {
    let parent = match camera.parent {
        Some(parent) => find(poses, parent, read, "parent")?,
        None => DAffine3::IDENTITY,
    };
    let turned = rotation_of(parent.matrix3).ok_or_else(|| read.error("parent", Fault::Singular))?;
    let place =
        |property, point: &Track<DVec3>| read.finite(property, parent.transform_point3(read.vector(property, point)?));
    let eye = place("position", &camera.position)?;

    let (axes, target_m) = match &camera.aim {
        Aim::Rotation(rotation) => (turned * DMat3::from_quat(read.rotation("rotation", rotation)?), None),
        Aim::Point { target, up } => look(read, eye, place("look_at", target)?, turned * read.vector("up", up)?)?,
        Aim::Node { target, up } => {
            let target = find(poses, *target, read, "look_at")?.translation;
            look(read, eye, target, turned * read.vector("up", up)?)?
        }
    };

    let projection = projection(read, &camera.projection)?;
    let aperture_m = match projection {
        Projection::Perspective { .. } => read.number("aperture", &camera.aperture_m, Range::FromZero)?,
        _ => 0.0,
    };
    let focus_m = match (&camera.focus_m, target_m) {
        (Some(focus_m), _) => read.number("focus", focus_m, Range::AboveZero)?,
        (None, Some(target_m)) => read.check("focus", target_m, Range::AboveZero)?,
        (None, None) if aperture_m == 0.0 => PINHOLE_FOCUS_M,
        (None, None) => return Err(read.error("focus", Fault::NoFocus)),
    };
    Ok(View {
        world_from_camera: DAffine3::from_mat3_translation(axes, eye),
        projection,
        aperture_m,
        focus_m,
        blades: camera.blades,
    })
}

fn projection(read: Reader<'_>, projection: &Projection<Animated>) -> Result<Projection<Still>, SampleError> {
    Ok(match projection {
        Projection::Perspective { fov } => Projection::Perspective { fov: read.number("fov", fov, Range::ZeroToPi)? },
        Projection::Orthographic { height_m } => {
            Projection::Orthographic { height_m: read.check("height", *height_m, Range::AboveZero)? }
        }
        Projection::Panorama => Projection::Panorama,
        Projection::Fisheye { fov } => Projection::Fisheye { fov: read.number("fov", fov, Range::ZeroToTwoPi)? },
    })
}

/// The axes of a camera that looks from `eye` to `target`, and how far that is; all in the world.
fn look(read: Reader<'_>, eye: DVec3, target: DVec3, up: DVec3) -> Result<(DMat3, Option<f64>), SampleError> {
    let back = eye - target;
    // Nearer than rounding leaves the direction to chance.
    if back.length() <= 1e-12 * eye.length().max(target.length()) {
        return Err(read.error("look_at", Fault::AimedAtItself));
    }
    let axes = facing(back, up).ok_or_else(|| read.error("up", Fault::UpAlongView))?;
    Ok((axes, Some(back.length())))
}
