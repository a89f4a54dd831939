// Rough diffuse surfaces: energy-preserving Oren–Nayar (EON) and Fujii's variant (FON), sampled by clipped linearly
// transformed cosines (Portsmouth, Kutz and Hill, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1),
// 2025), and the qualitative model of Oren and Nayar (QON, 1994). Roughness 0 is Lambert's.

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
fn diffuse_eval(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return vec3<f32>(0.0);
    }
    let rho = b.color;
    let roughness = b.roughness;
    if roughness == 0.0 {
        return rho * (INV_PI * wi.z);
    }
    let model = b.flags & DIFFUSE_MODEL;
    let s = dot(wi, wo) - wi.z * wo.z;
    let over = s / max(wi.z, wo.z);
    if model == DIFFUSE_QON {
        let sigma_2 = square(HALF_PI * roughness);
        let a = 1.0 - 0.5 * sigma_2 / (sigma_2 + 0.33);
        return rho * ((a + 0.45 * sigma_2 / (sigma_2 + 0.09) * max(over, 0.0)) * INV_PI * wi.z);
    }
    let t = select(s, over, s > 0.0);
    let a = 1.0 / (1.0 + FON_A * roughness);
    let single = rho * (a * (1.0 + roughness * t));
    if model == DIFFUSE_FON {
        return single * (INV_PI * wi.z);
    }
    let average = a * (1.0 + FON_B * roughness);
    let rho_ms = rho * rho * average / (vec3<f32>(1.0) - rho * (1.0 - average));
    let lost = max(1e-7, 1.0 - fon_albedo(wo.z, roughness)) * max(1e-7, 1.0 - fon_albedo(wi.z, roughness));
    return (single + rho_ms * (lost / max(1e-7, 1.0 - average))) * (INV_PI * wi.z);
}

/// The linear map of the clipped cosine, by the direction and roughness it is for (listing 2 of the paper).
struct Cltc {
    a: f32,
    b: f32,
    c: f32,
    d: f32,
    /// Half the width of the clipped disc, as a share of the whole.
    s: f32,
    /// Chance of a direction of the uniform hemisphere instead.
    uniform_chance: f32,
    /// Horizontal direction of `wo`.
    x: vec2<f32>,
}

fn cltc_for(wo: vec3<f32>, r: f32) -> Cltc {
    let mu = min(wo.z, 1.0);
    let d = r * (0.540852 + (-1.01625 + 0.475392 * mu) * mu) / (-1.0743 + mu * (0.0725628 + mu));
    let across = dot(wo.xy, wo.xy);
    return Cltc(
        1.0 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu + (-0.276266 + 0.335918 * mu) * r),
        r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r) / (mu * mu * mu - 1.43545),
        1.0 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r,
        d,
        0.5 + 0.5 / sqrt(1.0 + d * d),
        pow_(r, 0.1) * (0.162925 + mu * (-0.372058 + (0.538233 - 0.290822 * mu) * mu)),
        select(vec2<f32>(1.0, 0.0), wo.xy / sqrt(across), across > 0.0),
    );
}

fn cltc_pdf(m: Cltc, wi: vec3<f32>) -> f32 {
    let x = wi.x * m.x.x + wi.y * m.x.y;
    let y = wi.y * m.x.x - wi.x * m.x.y;
    let det = m.c * (m.a - m.b * m.d);
    let h = vec3<f32>(m.c * (x - m.b * wi.z), (m.a - m.b * m.d) * y, m.c * (m.a * wi.z - m.d * x));
    let clipped = square(det / dot(h, h)) * max(h.z, 0.0) / (PI * m.s);
    return mix(clipped, 0.5 * INV_PI, m.uniform_chance);
}

fn has_cltc(b: Bsdf) -> bool {
    return b.roughness > 0.0 && (b.flags & DIFFUSE_MODEL) != DIFFUSE_QON;
}

fn diffuse_pdf(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    if !has_cltc(b) {
        return wi.z * INV_PI;
    }
    return cltc_pdf(cltc_for(wo, b.roughness), wi);
}

fn diffuse_sample(b: Bsdf, wo: vec3<f32>, u: vec2<f32>, lobe: f32) -> BsdfSample {
    if !has_cltc(b) {
        let wi = square_to_cosine(u);
        let pdf = wi.z * INV_PI;
        if b.roughness == 0.0 {
            return BsdfSample(wi, b.color, pdf, 1.0);
        }
        return BsdfSample(wi, diffuse_eval(b, wo, wi) / pdf, pdf, 1.0);
    }
    let m = cltc_for(wo, b.roughness);
    var wi: vec3<f32>;
    if lobe < m.uniform_chance {
        wi = vec3<f32>(sqrt(max(0.0, 1.0 - u.x * u.x)) * cos_sin_turn(u.y), u.x);
    } else {
        let disc = sqrt(u.x) * cos_sin_turn(u.y);
        // Half of the disc, squeezed over the part of it that stays above the horizon.
        let x = -mix(sqrt(max(0.0, 1.0 - disc.y * disc.y)), disc.x, m.s);
        let z = sqrt(max(0.0, 1.0 - x * x - disc.y * disc.y));
        let w = normalize(vec3<f32>(m.a * x + m.b * z, m.c * disc.y, m.d * x + z));
        wi = vec3<f32>(w.x * m.x.x - w.y * m.x.y, w.x * m.x.y + w.y * m.x.x, w.z);
    }
    if wi.z <= 0.0 {
        return no_sample();
    }
    let pdf = cltc_pdf(m, wi);
    return BsdfSample(wi, diffuse_eval(b, wo, wi) / pdf, pdf, 1.0);
}
