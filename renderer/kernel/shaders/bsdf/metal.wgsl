// Metals: GGX microfacets with F82-tint (Kutz, Hašan and Edmondson 2021) or measured reflectance, and what is scattered
// more than once between them (Kulla and Conty, "Revisiting Physically Based Shading at Imageworks", 2017).

/// Exact reflectance of refractive index n and extinction k at cosine c, from vacuum.
fn conductor_fresnel(n: f32, k: f32, c: f32) -> f32 {
    let c2 = c * c;
    let s2 = 1.0 - c2;
    let t0 = n * n - k * k - s2;
    let q = sqrt(t0 * t0 + 4.0 * n * n * k * k);
    let a = sqrt(max(0.0, 0.5 * (q + t0)));
    let rs = (q + c2 - 2.0 * a * c) / (q + c2 + 2.0 * a * c);
    let rp = rs * (c2 * q + s2 * s2 - 2.0 * a * c * s2) / (c2 * q + s2 * s2 + 2.0 * a * c * s2);
    return 0.5 * (rs + rp);
}

/// Reflectance of a microfacet at cosine c.
fn metal_fresnel(b: Bsdf, c: f32) -> vec3<f32> {
    if (b.flags & METAL_SPECTRUM) != 0u {
        return vec3<f32>(
            conductor_fresnel(b.color.x, b.extra.x, c),
            conductor_fresnel(b.color.y, b.extra.y, c),
            conductor_fresnel(b.color.z, b.extra.z, c),
        );
    }
    let k = 1.0 - c;
    let k2 = k * k;
    let schlick = b.color + (vec3<f32>(1.0) - b.color) * (k2 * k2 * k);
    return clamp(schlick - b.extra * (c * k2 * k2 * k2), vec3<f32>(0.0), vec3<f32>(1.0));
}

// What is lost without scattering more than once, of light from w.
fn metal_lost(b: Bsdf, w: vec3<f32>) -> f32 {
    if (b.flags & COMPENSATE) == 0u {
        return 0.0;
    }
    if b.anisotropy == 0.0 {
        return 1.0 - metal_albedo(w.z, b.roughness);
    }
    return 1.0 - stretched_albedo(w, b.alpha, b.roughness, b.anisotropy);
}

/// f · cos.
fn metal_eval(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 || max(b.alpha.x, b.alpha.y) < MIRROR_ALPHA {
        return vec3<f32>(0.0);
    }
    let h = normalize(wo + wi);
    let single = metal_fresnel(b, dot(wi, h)) * (ggx_d(h, b.alpha) * ggx_g2(wo, wi, b.alpha) / (4.0 * wo.z));
    return single + b.more * (metal_lost(b, wo) * metal_lost(b, wi) * INV_PI * wi.z);
}

fn metal_pdf(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 || max(b.alpha.x, b.alpha.y) < MIRROR_ALPHA {
        return 0.0;
    }
    let h = normalize(wo + wi);
    return mix(ggx_d(h, b.alpha) * ggx_bounded_pdf(wo, b.alpha), INV_PI * wi.z, metal_lost(b, wo));
}

fn metal_sample(b: Bsdf, wo: vec3<f32>, u: vec2<f32>, lobe: f32) -> BsdfSample {
    if max(b.alpha.x, b.alpha.y) < MIRROR_ALPHA {
        return mirror_sample(wo, metal_fresnel(b, wo.z));
    }
    var wi: vec3<f32>;
    if lobe < metal_lost(b, wo) {
        wi = square_to_cosine(u);
    } else {
        let h = ggx_bounded_normal(wo, b.alpha, u);
        wi = 2.0 * dot(wo, h) * h - wo;
    }
    let pdf = metal_pdf(b, wo, wi);
    if !(pdf > 0.0) {
        return no_sample();
    }
    return BsdfSample(wi, metal_eval(b, wo, wi) / pdf, pdf, 1.0);
}
