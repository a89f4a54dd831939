//! Materials as the kernel reads them.

use glam::{UVec4, Vec3};
use kinora_kernel::Material as Packed;
use kinora_kernel::generated::{MATERIAL_DIELECTRIC, MATERIAL_DIFFUSE, MATERIAL_EMITTER, MATERIAL_METAL};
use kinora_scene::{Material, Still};

/// What follows from the material alone; emission belongs to the shapes.
pub fn pack(material: &Material<Still>) -> Packed {
    let of = |kind, color: Vec3, color_w: f64, extra: Vec3, extra_w: f64| Packed {
        color: color.extend(color_w as f32),
        extra: extra.extend(extra_w as f32),
        kind: UVec4::new(kind, 0, 0, 0),
    };
    match material {
        Material::Diffuse { color, roughness } => of(MATERIAL_DIFFUSE, *color, *roughness, Vec3::ZERO, 0.0),
        Material::Metal { color, edge_tint, roughness } => {
            of(MATERIAL_METAL, *color, roughness * roughness, f82_term(*color, *edge_tint), 0.0)
        }
        Material::Dielectric { ior, attenuation_color, attenuation_distance_m } => {
            let absorption = absorption_per_m(*attenuation_color, *attenuation_distance_m);
            of(MATERIAL_DIELECTRIC, Vec3::ONE, 0.0, absorption, *ior)
        }
        Material::Emitter { .. } => Packed { kind: UVec4::new(MATERIAL_EMITTER, 0, 0, 0), ..Packed::default() },
    }
}

// The factor a of F82-tint (Kutz et al. 2021): Schlick(1/7) · (1 − tint) / (c (1 − c)⁶) at c = 1/7.
fn f82_term(color: Vec3, tint: Vec3) -> Vec3 {
    let schlick = color + (Vec3::ONE - color) * 0.462_664_36;
    schlick * (Vec3::ONE - tint) / 0.056_652_78
}

// −ln(colour) / distance; a channel of 0 counts as 1e-4, since it would absorb everything at once.
fn absorption_per_m(color: Vec3, distance_m: f64) -> Vec3 {
    let channel = |c: f32| (-f64::from(c.clamp(1e-4, 1.0)).ln() / distance_m) as f32;
    Vec3::new(channel(color.x), channel(color.y), channel(color.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absorption_gives_the_colour_after_its_distance() {
        let a = absorption_per_m(Vec3::new(0.5, 1.0, 0.0), 0.5);
        assert!(((-a.x).exp() - 0.25).abs() < 1e-6, "after 1 m: {}", (-a.x).exp());
        assert_eq!(a.y, 0.0);
        assert!(a.z.is_finite());
        assert_eq!(absorption_per_m(Vec3::splat(0.5), f64::INFINITY), Vec3::ZERO);
    }

    #[test]
    fn a_white_edge_leaves_schlick_alone() {
        assert_eq!(f82_term(Vec3::splat(0.9), Vec3::ONE), Vec3::ZERO);
    }
}
