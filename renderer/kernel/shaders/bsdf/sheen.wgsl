// Cloth and dust: fibres that stand up from a surface and catch light at grazing angles (Estevez and Kulla, "Production
// Friendly Microfacet Sheen BRDF", Sony Pictures Imageworks 2017), with the parameters of glTF's KHR_materials_sheen. What
// the fibres send back is taken from what lies beneath them.

/// Below this, nothing but a line at the horizon would be left.
const SHEEN_ROUGHNESS: f32 = 0.07;

/// The width of the distribution: the square of the roughness.
fn sheen_width(roughness: f32) -> f32 {
    return square(max(roughness, SHEEN_ROUGHNESS));
}

// L of the paper (equation 3): its table 1, at roughness 0 and 1.
fn sheen_curve(x: f32, t: f32) -> f32 {
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow_(x, c)) + d * x + e;
}

// Λ, the masking by other fibres (equation 2).
fn sheen_lambda(mu: f32, width: f32) -> f32 {
    let t = square(1.0 - width);
    if mu < 0.5 {
        return exp_(sheen_curve(mu, t));
    }
    return exp_(2.0 * sheen_curve(0.5, t) - sheen_curve(1.0 - mu, t));
}

/// f · cos of white fibres.
fn sheen_eval(roughness: f32, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let width = sheen_width(roughness);
    let h = normalize(wo + wi);
    let sin_2 = max(1.0 - h.z * h.z, 1e-12);
    let d = (2.0 + 1.0 / width) * pow_(sin_2, 0.5 / width) * (0.5 * INV_PI);
    return d / ((1.0 + sheen_lambda(wo.z, width) + sheen_lambda(wi.z, width)) * 4.0 * wo.z);
}

// Directions are drawn evenly over the hemisphere.
const SHEEN_PDF: f32 = 0.5 * INV_PI;

fn sheen_pdf(wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    return select(0.0, SHEEN_PDF, wi.z > 0.0 && wo.z > 0.0);
}

fn sheen_sample(b: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let r = sqrt(max(0.0, 1.0 - u.x * u.x));
    let wi = vec3<f32>(r * cos_sin_turn(u.y), u.x);
    if !(wi.z > 0.0) {
        return no_sample();
    }
    return BsdfSample(wi, b.color * (sheen_eval(b.roughness, wo, wi) / SHEEN_PDF), SHEEN_PDF, 1.0);
}
