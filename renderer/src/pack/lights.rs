//! Lights: every emissive triangle, rectangle and sphere, each with the chance to be chosen in proportion to its power.

use glam::{DVec3, UVec4, Vec3};
use kinora_kernel::Light as Packed;

/// A light before it is known what the others are.
#[derive(Clone, Debug)]
pub struct Light {
    /// As the kernel reads it, without the chances.
    pub packed: Packed,
    /// W, up to a factor that all lights share.
    pub power: f64,
}

/// A light of kind `kind` that belongs to `shape`; `power` per luminance is its area times the sides that shine.
pub fn light(kind: u32, shape: u32, origin: DVec3, edges: [DVec3; 2], area_m2: f64, power: f64) -> Light {
    Light {
        packed: Packed {
            origin: origin.as_vec3().extend(0.0),
            edge_u: edges[0].as_vec3().extend(0.0),
            edge_v: edges[1].as_vec3().extend(0.0),
            normal: edges[0].cross(edges[1]).normalize_or_zero().as_vec3().extend((1.0 / area_m2) as f32),
            kind: UVec4::new(kind, shape, 0, 0),
        },
        power,
    }
}

/// Rec. 709 luminance.
pub fn luminance(c: Vec3) -> f64 {
    0.2126 * f64::from(c.x) + 0.7152 * f64::from(c.y) + 0.0722 * f64::from(c.z)
}

/// Fills in the chances; gives the number of lights, 0 if none has any power.
pub fn choose_by_power(lights: &mut [Light]) -> u32 {
    let total: f64 = lights.iter().map(|light| light.power).sum();
    let Some(last) = lights.iter().rposition(|light| light.power > 0.0) else { return 0 };
    let mut before = 0.0;
    for (i, light) in lights.iter_mut().enumerate() {
        let chance = light.power / total;
        // Nothing may find a light that is never chosen, however the sums are rounded.
        light.packed.origin.w = if i > last { 2.0 } else { before as f32 };
        light.packed.edge_u.w = chance as f32;
        before += chance;
    }
    lights.len() as u32
}
