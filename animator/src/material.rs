//! Surfaces, shapes, the sky and the look at one instant.

use kinora_scene::{Animated, Emission, Look, Material, Shape, Sky, Still};

use crate::{
    error::{Fault, SampleError},
    read::{Range, Reader},
};

pub(crate) fn material(read: Reader<'_>, material: &Material<Animated>) -> Result<Material<Still>, SampleError> {
    Ok(match material {
        Material::Diffuse { color, roughness } => Material::Diffuse {
            color: read.color("color", color, Range::ZeroToOne)?,
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
        },
        Material::Metal { color, edge_tint, roughness } => Material::Metal {
            color: read.color("color", color, Range::ZeroToOne)?,
            edge_tint: read.color("edge_tint", edge_tint, Range::ZeroToOne)?,
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
        },
        &Material::Dielectric { ref ior, attenuation_color, attenuation_distance_m } => Material::Dielectric {
            ior: read.number("ior", ior, Range::FromOne)?,
            attenuation_color: read.color("attenuation_color", &attenuation_color.into(), Range::ZeroToOne)?,
            // Infinite for clear glass.
            attenuation_distance_m: if attenuation_distance_m == f64::INFINITY {
                attenuation_distance_m
            } else {
                read.check("attenuation_distance", attenuation_distance_m, Range::AboveZero)?
            },
        },
        Material::Emitter { color, emission, two_sided } => Material::Emitter {
            color: read.color("color", color, Range::FromZero)?,
            emission: match emission {
                Emission::Radiance(radiance) => {
                    Emission::Radiance(read.number("radiance", radiance, Range::FromZero)?)
                }
                Emission::Power(power) => Emission::Power(read.number("power", power, Range::FromZero)?),
            },
            two_sided: *two_sided,
        },
    })
}

pub(crate) fn shape(read: Reader<'_>, shape: &Shape<Animated>) -> Result<Shape<Still>, SampleError> {
    let sizes = |sizes: &[f64]| sizes.iter().try_for_each(|&s| read.check("size", s, Range::AboveZero).map(drop));
    Ok(match shape {
        Shape::Sphere { radius_m } => Shape::Sphere { radius_m: read.number("radius", radius_m, Range::AboveZero)? },
        &Shape::Box { size_m } => {
            sizes(&size_m.to_array())?;
            Shape::Box { size_m }
        }
        &Shape::Quad { frame, size_m } => {
            sizes(&size_m.to_array())?;
            if !frame.matrix().is_finite() {
                return Err(read.error("normal", Fault::NotFinite));
            }
            Shape::Quad { frame, size_m }
        }
        &Shape::Plane { frame } => {
            if !frame.matrix().is_finite() {
                return Err(read.error("normal", Fault::NotFinite));
            }
            Shape::Plane { frame }
        }
        Shape::Mesh(mesh) => Shape::Mesh(mesh.clone()),
    })
}

pub(crate) fn sky(read: Reader<'_>, sky: &Sky<Animated>) -> Result<Sky<Still>, SampleError> {
    Ok(Sky {
        color: read.color("color", &sky.color, Range::FromZero)?,
        strength: read.number("strength", &sky.strength, Range::FromZero)?,
        visible: sky.visible,
    })
}

pub(crate) fn look(read: Reader<'_>, look: &Look<Animated>) -> Result<Look<Still>, SampleError> {
    Ok(Look { exposure: read.number("exposure", &look.exposure, Range::Any)?, tonemap: look.tonemap })
}
