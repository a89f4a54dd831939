// What all materials share: `sample`, `eval` and `pdf` in the frame of the shading normal, with `wo` above it (z > 0).

/// The pdf of a direction that only one direction of `wo` leads to.
const DELTA_PDF: f32 = -1.0;

struct BsdfSample {
    /// Below the surface (z < 0) after refraction.
    wi: vec3<f32>,
    /// f · |cos| / pdf.
    weight: vec3<f32>,
    /// A steradian; DELTA_PDF for a mirror or a refraction, 0 if there is no direction.
    pdf: f32,
    /// Refractive index beyond the boundary crossed over that before it; 1 without crossing.
    eta: f32,
}

fn no_sample() -> BsdfSample {
    return BsdfSample(vec3<f32>(0.0, 0.0, 1.0), vec3<f32>(0.0), 0.0, 1.0);
}

/// Whether light sampling can find anything through this material.
fn bsdf_is_delta(m: Material) -> bool {
    return m.kind.x == MATERIAL_DIELECTRIC || (m.kind.x == MATERIAL_METAL && m.color.w < MIRROR_ALPHA);
}

/// f · cos; 0 for delta lobes.
fn bsdf_eval(m: Material, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    switch m.kind.x {
        case MATERIAL_DIFFUSE: {
            return diffuse_eval(m, wo, wi);
        }
        case MATERIAL_METAL: {
            return metal_eval(m, wo, wi);
        }
        default: {
            return vec3<f32>(0.0);
        }
    }
}

/// The density with which `bsdf_sample` draws `wi`, a steradian; 0 for delta lobes.
fn bsdf_pdf(m: Material, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    switch m.kind.x {
        case MATERIAL_DIFFUSE: {
            return diffuse_pdf(m, wo, wi);
        }
        case MATERIAL_METAL: {
            return metal_pdf(m, wo, wi);
        }
        default: {
            return 0.0;
        }
    }
}

/// A direction in proportion to what it carries, as far as possible. `front`: whether `wo` is on the outer side.
fn bsdf_sample(m: Material, wo: vec3<f32>, front: bool, u: vec2<f32>) -> BsdfSample {
    switch m.kind.x {
        case MATERIAL_DIFFUSE: {
            return diffuse_sample(m, wo, u);
        }
        case MATERIAL_METAL: {
            return metal_sample(m, wo, u);
        }
        case MATERIAL_DIELECTRIC: {
            return dielectric_sample(m, wo, front, u.x);
        }
        default: {
            return no_sample();
        }
    }
}
