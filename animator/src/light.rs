//! Suns and lamps at one instant.

use glam::{DAffine3, DVec3};
use kinora_scene::{Animated, Beam, Light, LightKind, Still, Track};

use crate::{
    error::{Fault, Place, SampleError},
    pose::{Pose, find},
    read::{Now, Range, Reader},
};

/// The light in the world. What it moves with carries its place and direction along, and scales a lamp's radius by the
/// mean of its factors.
pub(crate) fn light(
    now: Now,
    index: usize,
    light: &Light<Animated>,
    poses: &[Pose],
) -> Result<Option<Light<Still>>, SampleError> {
    let read = now.reader(Place::Light(index), &light.name);
    if light.parent.and_then(|parent| poses.get(parent)).is_some_and(|parent| !parent.shown) {
        return Ok(None);
    }
    let parent = match light.parent {
        Some(parent) => find(poses, parent, read, "position")?,
        None => DAffine3::IDENTITY,
    };
    let place =
        |position: &Track<DVec3>| read.finite("position", parent.transform_point3(read.vector("position", position)?));
    let size = parent.matrix3.determinant().abs().cbrt();
    let radius = |radius_m: f64| read.check("radius", radius_m * size, Range::FromZero);
    let kind = match &light.kind {
        LightKind::Sun { direction, angle, irradiance } => {
            let direction = parent.transform_vector3(read.vector("direction", direction)?);
            LightKind::Sun {
                direction: unit(read, "direction", direction)?,
                angle: read.check("angle", *angle, Range::FromZero)?,
                irradiance: read.number("irradiance", irradiance, Range::FromZero)?,
            }
        }
        LightKind::Point { position, power, radius_m } => LightKind::Point {
            position: place(position)?,
            power: read.number("power", power, Range::FromZero)?,
            radius_m: radius(*radius_m)?,
        },
        LightKind::Spot { position, aim, power, radius_m, angle, blend } => {
            let from = place(position)?;
            let (property, direction) = match aim {
                Beam::Direction(direction) => {
                    ("direction", parent.transform_vector3(read.vector("direction", direction)?))
                }
                Beam::Point(target) => ("look_at", parent.transform_point3(read.vector("look_at", target)?) - from),
                Beam::Node(target) => ("look_at", find(poses, *target, read, "look_at")?.translation - from),
            };
            LightKind::Spot {
                position: from,
                aim: Beam::Direction(unit(read, property, direction)?),
                power: read.number("power", power, Range::FromZero)?,
                radius_m: radius(*radius_m)?,
                angle: read.check("angle", *angle, Range::AboveZero)?,
                blend: read.check("blend", *blend, Range::ZeroToOne)?,
            }
        }
    };
    let color = read.color("color", &light.color.into(), Range::FromZero)?;
    Ok(Some(Light { name: light.name.clone(), parent: None, color, kind }))
}

fn unit(read: Reader<'_>, property: &'static str, v: DVec3) -> Result<DVec3, SampleError> {
    v.try_normalize().ok_or_else(|| read.error(property, Fault::NoDirection))
}
