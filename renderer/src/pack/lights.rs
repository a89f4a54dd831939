//! Lights: every emissive triangle, rectangle and sphere, points and spots, each with the chance to be chosen in proportion
//! to its power, and suns beside them. Where there are many, a tree chooses: Conty Estevez and Kulla, "Importance
//! Sampling of Many Lights with Adaptive Tree Splitting", 2018.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec3, UVec4, Vec3, Vec4};
use kinora_kernel::generated::{LIGHT_POINT, LIGHT_SKY, LIGHT_SPOT, LIGHT_SUN, LIGHT_TRIANGLE};
use kinora_kernel::{Light as Packed, Shape};
use kinora_scene::{Beam, LightKind, Still};

/// A light before it is known what the others are.
#[derive(Clone, Debug)]
pub struct Light {
    /// As the kernel reads it, without the chances.
    pub packed: Packed,
    /// W / π, luminance.
    pub power: f64,
    /// What the tree must know of it.
    pub reach: Reach,
}

/// Where a light is and where it shines.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    pub low: DVec3,
    pub high: DVec3,
    /// W/sr where it is brightest, luminance.
    pub intensity: f64,
    /// Of its normals; unit length.
    pub axis: DVec3,
    /// Radians from the axis to the farthest normal, and from a normal to where light is still sent.
    pub spread: f64,
    pub sent: f64,
    pub two_sided: bool,
}

impl Reach {
    /// A light that shines to all sides from within a box.
    pub fn round(low: DVec3, high: DVec3, intensity: f64) -> Self {
        Reach { low, high, intensity, axis: DVec3::Z, spread: PI, sent: FRAC_PI_2, two_sided: false }
    }
}

/// A flat light of kind `kind` that belongs to `shape`; `power` per luminance is its area times the sides that shine.
pub fn flat(
    kind: u32,
    shape: u32,
    origin: DVec3,
    edges: [DVec3; 2],
    area_m2: f64,
    power: f64,
    two_sided: bool,
) -> Light {
    let [u, v] = edges;
    let mut corners = [origin, origin + u, origin + v, origin + u + v];
    if kind == LIGHT_TRIANGLE {
        corners[3] = origin;
    }
    let reach = Reach {
        low: corners.into_iter().fold(origin, DVec3::min),
        high: corners.into_iter().fold(origin, DVec3::max),
        intensity: power / if two_sided { 2.0 } else { 1.0 },
        axis: u.cross(v).try_normalize().unwrap_or(DVec3::Z),
        spread: 0.0,
        sent: FRAC_PI_2,
        two_sided,
    };
    Light { packed: record(kind, shape, origin, edges, area_m2), power, reach }
}

/// A round light; `box_`: its lowest and highest corner.
pub fn round(kind: u32, shape: u32, centre: DVec3, size: f64, area_m2: f64, power: f64, box_: [DVec3; 2]) -> Light {
    let packed = record(kind, shape, centre, [DVec3::X * size, DVec3::ZERO], area_m2);
    Light { packed, power, reach: Reach::round(box_[0], box_[1], power / 4.0) }
}

/// A light of several parts, of which nothing is known but its box.
pub fn other(kind: u32, shape: u32, origin: DVec3, edges: [DVec3; 2], power: f64, box_: [DVec3; 2]) -> Light {
    let packed = Packed { normal: Vec4::ZERO, ..record(kind, shape, origin, edges, 1.0) };
    Light { packed, power, reach: Reach::round(box_[0], box_[1], power) }
}

fn record(kind: u32, shape: u32, origin: DVec3, edges: [DVec3; 2], area_m2: f64) -> Packed {
    Packed {
        origin: origin.as_vec3().extend(0.0),
        edge_u: edges[0].as_vec3().extend(0.0),
        edge_v: edges[1].as_vec3().extend(0.0),
        normal: edges[0].cross(edges[1]).normalize_or_zero().as_vec3().extend((1.0 / area_m2) as f32),
        kind: UVec4::new(kind, shape, 0, 0),
    }
}

/// Writes into a light the first emitter of its shape, if it has one; it is read for every sample of the light, and a
/// shape is long.
pub fn name_emitter(light: &mut Packed, shapes: &[Shape]) {
    if light.kind.x < LIGHT_POINT {
        light.edge_v.w = shapes.get(light.kind.y as usize).map_or(0.0, |shape| shape.index.z as f32);
    }
}

/// 1 − cos, without cancellation.
pub fn cap_height(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// The cone of a spot light: the unit vector along it, 1 − cos of its half angle, and of that within which it is brightest.
pub fn cone(kind: &LightKind<Still>) -> Option<(DVec3, [f64; 2])> {
    match kind {
        LightKind::Spot { aim: Beam::Direction(direction), angle, blend, .. } => {
            let inner = (1.0 - blend) * 0.5 * angle;
            Some((direction.normalize_or(DVec3::NEG_Y), [cap_height(0.5 * angle), cap_height(inner)]))
        }
        _ => None,
    }
}

/// A point or spot light without extent; none for others.
pub fn point(color: Vec3, kind: &LightKind<Still>) -> Option<Light> {
    let (LightKind::Point { position, power, .. } | LightKind::Spot { position, power, .. }) = kind else {
        return None;
    };
    let per_sr = color * (power / (4.0 * PI)) as f32;
    let intensity = luminance(per_sr);
    let packed = Packed {
        origin: position.as_vec3().extend(0.0),
        edge_u: per_sr.extend(0.0),
        kind: UVec4::new(LIGHT_POINT, 0, 0, 0),
        ..Packed::default()
    };
    let round = Reach::round(*position, *position, intensity);
    let Some((axis, [outer, inner])) = cone(kind) else {
        return Some(Light { packed, power: 4.0 * intensity, reach: round });
    };
    let packed = Packed {
        edge_v: axis.as_vec3().extend(outer as f32),
        normal: Vec4::new(inner as f32, 0.0, 0.0, 0.0),
        kind: UVec4::new(LIGHT_SPOT, 0, 0, 0),
        ..packed
    };
    let reach = Reach { axis, spread: 0.0, sent: (1.0 - outer).acos(), ..round };
    Some(Light { packed, power: intensity * 2.0 * outer, reach })
}

/// A light from infinitely far away.
#[derive(Clone, Debug)]
pub struct Distant {
    /// As the kernel reads it, without the chances.
    pub packed: Packed,
    /// W/m², luminance.
    pub irradiance: f64,
}

/// A sun whose light travels along `direction`; `half_angle` of its disc.
pub fn sun(direction: DVec3, half_angle: f64, irradiance: Vec3) -> Distant {
    let height = cap_height(half_angle);
    let share = if height > 0.0 { 1.0 / (PI * half_angle.sin().powi(2)) } else { 1.0 };
    let packed = Packed {
        origin: (-direction.normalize_or(DVec3::NEG_Y)).as_vec3().extend(0.0),
        edge_u: (irradiance.as_dvec3() * share).as_vec3().extend(0.0),
        edge_v: Vec4::new(height as f32, 0.0, 0.0, 0.0),
        kind: UVec4::new(LIGHT_SUN, 0, 0, 0),
        ..Packed::default()
    };
    Distant { packed, irradiance: luminance(irradiance) }
}

/// The sky's map.
pub fn sky(irradiance: f64) -> Distant {
    Distant { packed: Packed { kind: UVec4::new(LIGHT_SKY, 0, 0, 0), ..Packed::default() }, irradiance }
}

/// Rec. 709 luminance.
pub fn luminance(c: Vec3) -> f64 {
    0.2126 * f64::from(c.x) + 0.7152 * f64::from(c.y) + 0.0722 * f64::from(c.z)
}

fn fill_chances<'a>(lights: impl Iterator<Item = &'a mut Packed>, powers: &[f64]) -> bool {
    let total: f64 = powers.iter().sum();
    let Some(last) = powers.iter().rposition(|power| *power > 0.0) else { return false };
    let mut before = 0.0;
    for (i, (light, power)) in lights.zip(powers).enumerate() {
        let chance = power / total;
        // Nothing may find a light that is never chosen, however the sums are rounded.
        light.origin.w = if i > last { 2.0 } else { before as f32 };
        light.edge_u.w = chance as f32;
        before += chance;
    }
    true
}

/// Fills in the chances; gives the number of lights, 0 if none has any power.
pub fn choose_by_power(lights: &mut [Light]) -> u32 {
    let powers: Vec<f64> = lights.iter().map(|light| light.power).collect();
    match fill_chances(lights.iter_mut().map(|light| &mut light.packed), &powers) {
        true => lights.len() as u32,
        false => 0,
    }
}

/// Each of several distant lights has at least its part of this: the brightest may be behind a house.
const EVEN: f64 = 0.1;

/// The same among lights from infinitely far away.
pub fn choose_distant(lights: &mut [Distant]) -> u32 {
    let total: f64 = lights.iter().map(|light| light.irradiance).sum();
    let shining = lights.iter().filter(|light| light.irradiance > 0.0).count() as f64;
    let share = |light: &Distant| match light.irradiance > 0.0 {
        true => light.irradiance / total * (1.0 - EVEN) + EVEN / shining,
        false => 0.0,
    };
    let powers: Vec<f64> = lights.iter().map(share).collect();
    match fill_chances(lights.iter_mut().map(|light| &mut light.packed), &powers) {
        true => lights.len() as u32,
        false => 0,
    }
}
