//! The moments of a shutter's interval at which a scene is shown: enough that nothing visibly jumps from one to the next.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};
use kinora_scene::{Frame, Projection, Scene, Shape, Shutter, Sky, SkyLight, Still, View, World, corners};

use crate::error::SampleError;

/// Times at which is looked whether anything moves, as shares of the interval; at no even steps, so that what turns evenly
/// does not look still.
const PROBES: [f64; 9] = [0.0, 0.07, 0.2, 0.34, 0.47, 0.62, 0.78, 0.91, 1.0];
/// The way across the picture from one moment to the next, in pixels.
const STEP_PX: f64 = 0.5;
/// Moments of what changes without moving far, where the samples suffice.
const FEW: u32 = 16;
/// The most moments that one sample a pixel is shared out to.
const GROUPS: u32 = 8;
/// Shapes, copies and triangles of all moments together: each moment is laid out anew.
const MOST: usize = 8_000_000;
/// Shapes and copies of one world that are followed across the picture.
const FOLLOWED: usize = 10_000;

/// The worlds in the middle of equal steps of the interval; none where nothing moves. `at` gives the world at a time.
pub(crate) fn moments(
    scene: &Scene,
    shutter: Shutter,
    at: impl Fn(f64) -> Result<World, SampleError>,
) -> Result<Arc<Vec<World>>, SampleError> {
    let Shutter { open_s, close_s } = shutter;
    if close_s <= open_s {
        return Ok(Arc::default());
    }
    let at = |share: f64| at(open_s + share * (close_s - open_s));
    let probes = PROBES.into_iter().map(at).collect::<Result<Vec<World>, _>>()?;
    let (Some(first), Some(way_px)) = (probes.first(), way_px(&probes)) else { return Ok(Arc::default()) };
    let count = count(way_px, scene.render.samples, weight(first));
    let held = probes.last().and_then(|last| held_sky(first, last));
    drop(probes);
    let middles = (0..count).map(|k| {
        let mut world = at((f64::from(k) + 0.5) / f64::from(count))?;
        if held.is_some() {
            world.sky.clone_from(&held);
        }
        Ok(world)
    });
    Ok(Arc::new(middles.collect::<Result<Vec<World>, _>>()?))
}

/// Clear air whose sun moves by less than a fifth of its disc meanwhile: it stays, since the light of all of the air is worked
/// out anew for any other.
fn held_sky(first: &World, last: &World) -> Option<Sky<Still>> {
    let (from, to) = (first.sky.as_ref()?, last.sky.as_ref()?);
    let near = |a: f64, b: f64| (a - b).abs() < 0.1_f64.to_radians();
    match (&from.light, &to.light) {
        (
            &SkyLight::Nishita { sun_elevation: e, sun_azimuth: a, turbidity: t },
            &SkyLight::Nishita { sun_elevation, sun_azimuth, turbidity },
        ) if near(e, sun_elevation) && near(a, sun_azimuth) && (t - turbidity).abs() < 0.01 => {
            (from.strength == to.strength).then(|| from.clone())
        }
        _ => None,
    }
}

/// How many moments: either a divisor of `samples`, so that each sees as many, or a multiple.
fn count(way_px: f64, samples: u32, weight: usize) -> u32 {
    let samples = samples.max(1);
    let most = u32::try_from(MOST / weight.max(1)).unwrap_or(u32::MAX).max(2);
    let wanted = (way_px / STEP_PX).ceil().min(f64::from(samples.saturating_mul(GROUPS))) as u32;
    let wanted = wanted.max(FEW.min(samples)).min(most);
    if wanted > samples {
        return (wanted / samples).next_power_of_two().min(GROUPS).min(most / samples).max(1) * samples;
    }
    let divisors = |from: u32, to: u32| (from..=to).find(|count| samples.is_multiple_of(*count));
    let enough = divisors(wanted.max(1), samples).unwrap_or(samples);
    if enough <= most { enough } else { (1..=most).rev().find(|count| samples.is_multiple_of(*count)).unwrap_or(1) }
}

/// What it costs to lay a world out.
fn weight(world: &World) -> usize {
    let shape = |shape: &Shape<Still>| match shape {
        Shape::Mesh(mesh) => mesh.triangles.len(),
        _ => 1,
    };
    let parts = world.parts.iter().map(|part| (&part.instances, &part.copies));
    let all = std::iter::once((&world.instances, &world.copies)).chain(parts);
    all.map(|(instances, copies)| {
        instances.iter().map(|instance| shape(&instance.shape)).sum::<usize>()
            + copies.iter().map(|copies| copies.places.len()).sum::<usize>()
    })
    .sum()
}

/// The longest way of anything across the picture, in pixels, as far as these worlds, one after the other, tell; `None` if
/// they are all the same.
fn way_px(probes: &[World]) -> Option<f64> {
    let (first, later) = probes.split_first()?;
    if later.iter().all(|world| world == first) {
        return None;
    }
    let eyes: Vec<DAffine3> = probes.iter().map(|world| world.view.world_from_camera.inverse()).collect();
    let mut longest: f64 = 0.0;
    // The same points in every world.
    let mut follow = |points: &dyn Fn(&World) -> Option<Vec<DVec3>>| {
        let (mut before, mut ways): (Vec<Option<DVec3>>, Vec<f64>) = Default::default();
        for (world, eye) in probes.iter().zip(&eyes) {
            let points = points(world).unwrap_or_default().into_iter();
            let seen: Vec<Option<DVec3>> = points.map(|point| pixel(world, eye.transform_point3(point))).collect();
            ways.resize(ways.len().max(seen.len()), 0.0);
            for (way, (from, to)) in ways.iter_mut().zip(before.iter().zip(&seen)) {
                *way += from.zip(*to).map_or(0.0, |(from, to)| from.distance(to));
            }
            before = seen;
        }
        longest = ways.into_iter().fold(longest, f64::max);
    };
    // What stands still moves with the camera.
    let View { world_from_camera, focus_m, .. } = &first.view;
    for depth in [0.3, 1.0, 10.0, 1e4] {
        for (x, y) in [(0.0, 0.0), (-0.3, -0.3), (0.3, -0.3), (-0.3, 0.3), (0.3, 0.3)] {
            let fixed = world_from_camera.transform_point3(DVec3::new(x, y, -1.0) * *focus_m * depth);
            follow(&|_| Some(vec![fixed]));
        }
    }
    let stride = first.instances.len().div_ceil(FOLLOWED).max(1);
    for i in (0..first.instances.len()).step_by(stride) {
        let node = first.instances[i].node;
        follow(&|world| {
            let instance = world.instances.get(i).filter(|instance| instance.node == node)?;
            let points = outline(&instance.shape)?;
            Some(points.into_iter().map(|point| instance.world_from_object.transform_point3(point)).collect())
        });
    }
    for (i, copies) in first.copies.iter().enumerate() {
        let stride = (first.copies.len() * copies.places.len()).div_ceil(FOLLOWED).max(1);
        for k in (0..copies.places.len()).step_by(stride) {
            follow(&|world| {
                let copies = world.copies.get(i)?;
                let place = copies.places.get(k)?;
                let shapes = world.parts.get(copies.part)?.instances.iter().take(4);
                let placed = |instance: &kinora_scene::Instance| {
                    let place = *place * instance.world_from_object;
                    outline(&instance.shape).into_iter().flatten().map(move |point| place.transform_point3(point))
                };
                Some(shapes.flat_map(placed).chain([place.translation]).collect())
            });
        }
    }
    Some(longest)
}

/// Points about a shape that go as far as it does; `None` of an infinite one.
fn outline(shape: &Shape<Still>) -> Option<Vec<DVec3>> {
    let flat = |frame: &Frame, at: [[f64; 2]; 4], size: DVec2| {
        at.map(|[x, y]| frame.matrix() * (DVec2::new(x, y) * size).extend(0.0)).to_vec()
    };
    Some(match shape {
        Shape::Quad { frame, size_m } => flat(frame, [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]], *size_m),
        Shape::Disk { frame, radius_m } => {
            flat(frame, [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]], DVec2::splat(*radius_m))
        }
        Shape::Mesh(mesh) => {
            // Some of its own points, which follow what bends it.
            let stride = mesh.positions.len().div_ceil(64).max(1);
            mesh.positions.iter().step_by(stride).map(|point| point.as_dvec3()).collect()
        }
        _ => corners(shape.half_size(|radius_m| Some(*radius_m))?).collect(),
    })
}

/// Where a point of the camera's space is seen, in pixels and but for its origin; behind or far beside the picture, nowhere. Of a panorama and a
/// fisheye: on a sphere on which a pixel is as long as in the picture.
fn pixel(world: &World, p: DVec3) -> Option<DVec3> {
    let [width, height] = world.render.resolution.map(f64::from);
    let flat = |x: f64, y: f64| {
        // Beside the picture nothing moves.
        let limit = DVec2::new(width, height);
        DVec2::new(x, y).clamp(-limit, limit).extend(0.0)
    };
    match &world.view.projection {
        Projection::Perspective { fov } => {
            let scale = 0.5 * height / (0.5 * fov).tan();
            (p.z < -1e-9).then(|| flat(scale * p.x / -p.z, scale * p.y / -p.z))
        }
        Projection::Orthographic { height_m } => {
            let scale = height / height_m;
            (p.z < 0.0).then(|| flat(scale * p.x, scale * p.y))
        }
        Projection::Panorama => Some(p.try_normalize()? * (height / std::f64::consts::PI)),
        Projection::Fisheye { fov } => Some(p.try_normalize()? * (height / fov)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_share_the_samples_evenly() {
        for (way_px, samples, weight, expected) in [
            (0.0, 64, 1, 16),
            (0.0, 8, 1, 8),
            (9.9, 64, 1, 32),
            (9.9, 100, 1, 20),
            (9.9, 97, 1, 97),
            (50.0, 64, 1, 64),
            (100.0, 64, 1, 256),
            (1e9, 16, 1, 128),
            (50.0, 64, 1_000_000, 8),
            (50.0, 64, 80_000_000, 2),
            (50.0, 1, 1, 8),
        ] {
            let got = count(way_px, samples, weight);
            assert_eq!(got, expected, "{way_px} px, {samples} samples, weight {weight}");
            assert!(u32::is_multiple_of(samples, got) || got.is_multiple_of(samples));
        }
    }
}
