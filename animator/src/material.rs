//! Surfaces, shapes, the sky and the look at one instant.

use std::sync::Arc;

use glam::DVec2;
use kinora_scene::{
    Animated, Bsdf, Emission, ImageTexture, Look, Map, Material, Paint, Reflectance, Shape, Sky, SkyLight, Still, Tape,
    Texture,
};

use crate::{
    error::{Fault, SampleError},
    read::{Range, Reader},
};

/// Materials before this one are known: what it is made of must be among them.
pub(crate) fn material(
    read: Reader<'_>,
    index: usize,
    material: &Material<Animated>,
) -> Result<Material<Still>, SampleError> {
    let inner = |property, inner: usize| {
        if inner < index { Ok(inner) } else { Err(read.error(property, Fault::Dangling)) }
    };
    let bsdf = match &material.bsdf {
        Bsdf::Diffuse { color, roughness, model } => Bsdf::Diffuse {
            color: read.color("color", color, Range::ZeroToOne)?,
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
            model: *model,
        },
        Bsdf::Metal { reflectance, roughness, anisotropy, anisotropy_rotation, energy_compensation } => Bsdf::Metal {
            reflectance: match reflectance {
                Reflectance::Tint { color, edge_tint } => Reflectance::Tint {
                    color: read.color("color", color, Range::ZeroToOne)?,
                    edge_tint: read.color("edge_tint", edge_tint, Range::ZeroToOne)?,
                },
                Reflectance::Spectrum(metal) => Reflectance::Spectrum(*metal),
            },
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
            anisotropy: read.check("anisotropy", *anisotropy, Range::ZeroToOne)?,
            anisotropy_rotation: read.check("anisotropy_rotation", *anisotropy_rotation, Range::Any)?,
            energy_compensation: *energy_compensation,
        },
        &Bsdf::Dielectric {
            ref ior,
            ref roughness,
            energy_compensation,
            attenuation_color,
            attenuation_distance_m,
            thin,
            priority,
        } => Bsdf::Dielectric {
            ior: read.number("ior", ior, Range::FromOne)?,
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
            energy_compensation,
            attenuation_color: read.color("attenuation_color", &attenuation_color.into(), Range::ZeroToOne)?,
            // Infinite for clear glass.
            attenuation_distance_m: if attenuation_distance_m == f64::INFINITY {
                attenuation_distance_m
            } else {
                read.check("attenuation_distance", attenuation_distance_m, Range::AboveZero)?
            },
            thin,
            priority,
        },
        Bsdf::Glossy { base, ior, tint, roughness, metalness } => Bsdf::Glossy {
            base: inner("base", *base)?,
            ior: read.check("ior", *ior, Range::FromOne)?,
            tint: read.color("tint", tint, Range::ZeroToOne)?,
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
            metalness: read.number("metalness", metalness, Range::ZeroToOne)?,
        },
        Bsdf::Sheen { base, color, roughness } => Bsdf::Sheen {
            base: inner("base", *base)?,
            color: read.color("color", color, Range::ZeroToOne)?,
            roughness: read.number("roughness", roughness, Range::ZeroToOne)?,
        },
        Bsdf::Mix { a, b, amount } => Bsdf::Mix {
            a: inner("a", *a)?,
            b: inner("b", *b)?,
            amount: read.number("amount", amount, Range::ZeroToOne)?,
        },
        Bsdf::Emitter { color, emission, two_sided } => Bsdf::Emitter {
            color: read.color("color", color, Range::FromZero)?,
            emission: match emission {
                Emission::Radiance(radiance) => {
                    Emission::Radiance(read.number("radiance", radiance, Range::FromZero)?)
                }
                Emission::Power(power) => Emission::Power(read.number("power", power, Range::FromZero)?),
            },
            two_sided: *two_sided,
        },
    };
    Ok(Material {
        opacity: read.number("opacity", &material.opacity, Range::ZeroToOne)?,
        cutoff: material.cutoff.map(|cutoff| read.check("opacity", cutoff, Range::FromZero)).transpose()?,
        emission: read.color("emission", &material.emission.into(), Range::FromZero)?,
        maps: material
            .maps
            .iter()
            .map(|map| Ok(Map { slot: map.slot, texture: texture(read, &map.texture)? }))
            .collect::<Result<_, SampleError>>()?,
        bsdf,
    })
}

/// The same one where it does not move, so that what is shared stays so.
fn texture(read: Reader<'_>, moving: &Arc<Texture>) -> Result<Arc<Texture>, SampleError> {
    let paint = |paint: &Paint| match paint {
        Paint::Texture(inside) => texture(read, inside).map(Paint::Texture),
        color => Ok(color.clone()),
    };
    Ok(match &**moving {
        Texture::Tape(tape) if tape.moves() => Arc::new(Texture::Tape(read.still(tape))),
        Texture::Checker { a, b, scale, uv_set } if moving.moves() => {
            Arc::new(Texture::Checker { a: paint(a)?, b: paint(b)?, scale: *scale, uv_set: *uv_set })
        }
        Texture::Image(image) => match &image.moving {
            Some(tape) => Arc::new(Texture::Image(moved(read, image, tape)?)),
            None => moving.clone(),
        },
        _ => moving.clone(),
    })
}

/// A picture where its tape places it.
fn moved(read: Reader<'_>, image: &ImageTexture, tape: &Tape) -> Result<ImageTexture, SampleError> {
    match read.run(tape).as_slice() {
        &[su, sv, ou, ov, rotation] if [su, sv, ou, ov, rotation].iter().all(|x| x.is_finite()) => Ok(ImageTexture {
            scale: DVec2::new(su, sv).as_vec2(),
            offset: DVec2::new(ou, ov).as_vec2(),
            rotation,
            moving: None,
            ..image.clone()
        }),
        _ => Err(read.error("offset", Fault::NotFinite)),
    }
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
        &Shape::Disk { frame, radius_m } => {
            sizes(&[radius_m])?;
            if !frame.matrix().is_finite() {
                return Err(read.error("normal", Fault::NotFinite));
            }
            Shape::Disk { frame, radius_m }
        }
        &Shape::Cylinder { radius_m, height_m, capped } => {
            sizes(&[radius_m, height_m])?;
            Shape::Cylinder { radius_m, height_m, capped }
        }
        &Shape::Cone { radius_m, height_m, capped } => {
            sizes(&[radius_m, height_m])?;
            Shape::Cone { radius_m, height_m, capped }
        }
        &Shape::Capsule { radius_m, height_m, capped } => {
            sizes(&[radius_m, height_m])?;
            Shape::Capsule { radius_m, height_m, capped }
        }
        &Shape::Torus { radius_m, tube_m } => {
            sizes(&[radius_m, tube_m])?;
            Shape::Torus { radius_m, tube_m }
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
        light: match &sky.light {
            SkyLight::Color(color) => SkyLight::Color(read.color("color", color, Range::FromZero)?),
            SkyLight::Map { image, rotation } => {
                SkyLight::Map { image: image.clone(), rotation: read.number("rotation", rotation, Range::Any)? }
            }
            SkyLight::Nishita { sun_elevation, sun_azimuth, turbidity } => SkyLight::Nishita {
                sun_elevation: read.number("sun_elevation", sun_elevation, Range::Any)?,
                sun_azimuth: read.number("sun_azimuth", sun_azimuth, Range::Any)?,
                turbidity: read.number("turbidity", turbidity, Range::FromZero)?,
            },
        },
        strength: read.number("strength", &sky.strength, Range::FromZero)?,
        visible: sky.visible,
    })
}

pub(crate) fn look(read: Reader<'_>, look: &Look<Animated>) -> Result<Look<Still>, SampleError> {
    Ok(Look { exposure: read.number("exposure", &look.exposure, Range::Any)?, tonemap: look.tonemap })
}
