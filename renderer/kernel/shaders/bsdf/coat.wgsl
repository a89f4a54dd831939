// The coat of glossy surfaces: reflection at a dielectric boundary of GGX microfacets. What passes the coat is left to
// the material beneath, scaled by what a white coat does not reflect (albedo scaling, as OpenPBR 1.1).

/// What a facet of the coat reflects at cosine c: `tint` times what the boundary does where it is seen straight on, and
/// white at grazing angles, by Schlick's power.
fn coat_fresnel(ior: f32, tint: vec3<f32>, c: f32) -> vec3<f32> {
    let k = 1.0 - c;
    let k2 = k * k;
    // Exactly the boundary's where it is white.
    return dielectric_fresnel(c, ior) * (vec3<f32>(1.0) - (vec3<f32>(1.0) - tint) * (1.0 - k2 * k2 * k));
}

/// f · cos.
fn coat_eval(alpha: f32, ior: f32, tint: vec3<f32>, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 || alpha < MIRROR_ALPHA {
        return vec3<f32>(0.0);
    }
    let h = normalize(wo + wi);
    let widths = vec2<f32>(alpha);
    return coat_fresnel(ior, tint, dot(wi, h)) * (ggx_d(h, widths) * ggx_g2(wo, wi, widths) / (4.0 * wo.z));
}

fn coat_pdf(alpha: f32, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 || alpha < MIRROR_ALPHA {
        return 0.0;
    }
    let widths = vec2<f32>(alpha);
    return ggx_d(normalize(wo + wi), widths) * ggx_bounded_pdf(wo, widths);
}

fn coat_sample(alpha: f32, ior: f32, tint: vec3<f32>, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    if alpha < MIRROR_ALPHA {
        return mirror_sample(wo, coat_fresnel(ior, tint, wo.z));
    }
    let h = ggx_bounded_normal(wo, vec2<f32>(alpha), u);
    let wi = 2.0 * dot(wo, h) * h - wo;
    let pdf = coat_pdf(alpha, wo, wi);
    if !(pdf > 0.0) {
        return no_sample();
    }
    return BsdfSample(wi, coat_eval(alpha, ior, tint, wo, wi) / pdf, pdf, 1.0);
}
