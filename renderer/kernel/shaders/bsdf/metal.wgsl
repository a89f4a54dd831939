// GGX conductor: height-correlated Smith masking (Heitz 2014), visible normals by spherical caps (Dupuy and Benyoub,
// "Sampling Visible GGX Normals with Spherical Caps", CGF 42(8), 2023), F82-tint Fresnel (Kutz et al. 2021).

/// Below this α a metal is a mirror: the lobe is too narrow for f32.
const MIRROR_ALPHA: f32 = 1e-3;

// From the slope of h, since 1 − cos² cancels where α is small.
fn ggx_d(h: vec3<f32>, alpha: f32) -> f32 {
    let slope = dot(h.xy, h.xy) / (alpha * alpha) + h.z * h.z;
    return INV_PI / square(alpha * slope);
}

fn ggx_lambda(w: vec3<f32>, alpha: f32) -> f32 {
    let tan_2 = dot(w.xy, w.xy) / (w.z * w.z);
    return 0.5 * (sqrt(1.0 + alpha * alpha * tan_2) - 1.0);
}

/// Reflectance at cosine c.
fn metal_fresnel(m: Material, c: f32) -> vec3<f32> {
    let k = 1.0 - c;
    let k2 = k * k;
    let schlick = m.color.xyz + (vec3<f32>(1.0) - m.color.xyz) * (k2 * k2 * k);
    return clamp(schlick - m.extra.xyz * (c * k2 * k2 * k2), vec3<f32>(0.0), vec3<f32>(1.0));
}

/// f · cos.
fn metal_eval(m: Material, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 || m.color.w < MIRROR_ALPHA {
        return vec3<f32>(0.0);
    }
    let alpha = m.color.w;
    let h = normalize(wo + wi);
    let g2 = 1.0 / (1.0 + ggx_lambda(wo, alpha) + ggx_lambda(wi, alpha));
    return metal_fresnel(m, dot(wi, h)) * (ggx_d(h, alpha) * g2 / (4.0 * wo.z));
}

fn metal_pdf(m: Material, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 || m.color.w < MIRROR_ALPHA {
        return 0.0;
    }
    let alpha = m.color.w;
    let h = normalize(wo + wi);
    return ggx_d(h, alpha) / ((1.0 + ggx_lambda(wo, alpha)) * 4.0 * wo.z);
}

/// A normal in proportion to how much of it is seen from `wo`.
fn ggx_visible_normal(wo: vec3<f32>, alpha: f32, u: vec2<f32>) -> vec3<f32> {
    let w = normalize(vec3<f32>(alpha * wo.xy, wo.z));
    let z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    let c = vec3<f32>(sqrt(clamp(1.0 - z * z, 0.0, 1.0)) * cos_sin_turn(u.x), z);
    let h = c + w;
    return normalize(vec3<f32>(alpha * h.xy, max(1e-6, h.z)));
}

fn metal_sample(m: Material, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let alpha = m.color.w;
    if alpha < MIRROR_ALPHA {
        return BsdfSample(vec3<f32>(-wo.xy, wo.z), metal_fresnel(m, wo.z), DELTA_PDF, 1.0);
    }
    let h = ggx_visible_normal(wo, alpha, u);
    let cos_h = dot(wo, h);
    let wi = 2.0 * cos_h * h - wo;
    if wi.z <= 0.0 {
        return no_sample();
    }
    let lambda_o = ggx_lambda(wo, alpha);
    let weight = metal_fresnel(m, cos_h) * ((1.0 + lambda_o) / (1.0 + lambda_o + ggx_lambda(wi, alpha)));
    return BsdfSample(wi, weight, ggx_d(h, alpha) / ((1.0 + lambda_o) * 4.0 * wo.z), 1.0);
}
