// Energy-preserving Oren–Nayar, EON (Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF",
// JCGT 14(1), 2025). Roughness 0 is Lambert's.

/// 1/2 − 2/(3π) and 2/3 − 28/(15π) of Fujii's model.
const FON_A: f32 = 0.287793409210806;
const FON_B: f32 = 0.0724882125136;

// Directional albedo of Fujii's model with reflectance 1, in a form that does not cancel at grazing angles.
fn fon_albedo(mu: f32, roughness: f32) -> f32 {
    let a = 1.0 / (1.0 + FON_A * roughness);
    let s = sqrt(max(0.0, 1.0 - mu * mu));
    let g = s * (acos_(mu) - s * mu) + (2.0 / 3.0) * s * (mu * (1.0 + s + s * s) / (1.0 + s) - 1.0);
    return a * (1.0 + roughness * INV_PI * g);
}

/// f · cos.
fn diffuse_eval(m: Material, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let rho = m.color.xyz;
    let roughness = m.color.w;
    if roughness == 0.0 {
        return rho * (INV_PI * wi.z);
    }
    let s = dot(wi, wo) - wi.z * wo.z;
    let t = select(s, s / max(wi.z, wo.z), s > 0.0);
    let a = 1.0 / (1.0 + FON_A * roughness);
    let single = rho * (a * (1.0 + roughness * t));
    let average = a * (1.0 + FON_B * roughness);
    let rho_ms = rho * rho * average / (vec3<f32>(1.0) - rho * (1.0 - average));
    let lost = max(1e-7, 1.0 - fon_albedo(wo.z, roughness)) * max(1e-7, 1.0 - fon_albedo(wi.z, roughness));
    return (single + rho_ms * (lost / max(1e-7, 1.0 - average))) * (INV_PI * wi.z);
}

fn diffuse_pdf(m: Material, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    return select(0.0, wi.z * INV_PI, wi.z > 0.0 && wo.z > 0.0);
}

fn diffuse_sample(m: Material, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let wi = square_to_cosine(u);
    if m.color.w == 0.0 {
        return BsdfSample(wi, m.color.xyz, wi.z * INV_PI, 1.0);
    }
    let pdf = wi.z * INV_PI;
    return BsdfSample(wi, diffuse_eval(m, wo, wi) / pdf, pdf, 1.0);
}
