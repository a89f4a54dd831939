// Glass: exact Fresnel, total reflection and refraction at smooth boundaries, at rough ones (Walter et al.,
// "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007), and through thin sheets. A rough boundary is
// divided by the energy that it keeps, since light scattered more than once between its facets is not followed; what is
// drawn from it is drawn again until it gets away, so that paths in rough glass weigh the same.

/// Closer to 1 an index bends nothing that f32 could follow.
const MATCHED: f32 = 1e-3;

/// Unpolarised reflectance at cosine c (0..1) of a boundary with relative index eta, far side over near side.
fn dielectric_fresnel(c: f32, eta: f32) -> f32 {
    let sin2_t = (1.0 - c * c) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let ct = sqrt(1.0 - sin2_t);
    let rs = (c - eta * ct) / (c + eta * ct);
    let rp = (eta * c - ct) / (eta * c + ct);
    return 0.5 * (rs * rs + rp * rp);
}

fn is_thin(b: Bsdf) -> bool {
    return (b.flags & DIELECTRIC_THIN) != 0u;
}

// Reflectance of a facet; of a thin sheet with all inner reflections.
fn facet_reflectance(b: Bsdf, c: f32) -> f32 {
    if is_thin(b) {
        let f = dielectric_fresnel(c, b.eta);
        return 2.0 * f / (1.0 + f);
    }
    return dielectric_fresnel(c, b.eta);
}

fn dielectric_is_delta(b: Bsdf) -> bool {
    return b.alpha.x < MIRROR_ALPHA || abs(b.eta - 1.0) < MATCHED;
}

// The colour of what goes to `wi`.
fn dielectric_tint(b: Bsdf, wi: vec3<f32>) -> vec3<f32> {
    return select(vec3<f32>(1.0), b.color, wi.z < 0.0 && (b.flags & DIELECTRIC_TINTED) != 0u);
}

// 1 / what a rough boundary keeps.
fn dielectric_gain(b: Bsdf, mu: f32) -> f32 {
    if (b.flags & COMPENSATE) == 0u {
        return 1.0;
    }
    if is_thin(b) {
        return 1.0 / max(metal_albedo(mu, b.roughness), 1e-3);
    }
    return 1.0 / max(boundary_total(mu, b.roughness, b.eta), 1e-3);
}

/// The facet that refracts wo to wi, on the side of wo; z is 0 or below if none does.
fn refracting_facet(wo: vec3<f32>, wi: vec3<f32>, eta: f32) -> vec3<f32> {
    let m = wo + eta * wi;
    return normalize(select(m, -m, m.z < 0.0));
}

/// f · |cos| of radiance.
fn dielectric_eval(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if wo.z <= 0.0 || wi.z == 0.0 || dielectric_is_delta(b) {
        return vec3<f32>(0.0);
    }
    let gain = dielectric_gain(b, wo.z);
    let mirrored = vec3<f32>(wi.xy, abs(wi.z));
    if wi.z > 0.0 || is_thin(b) {
        let h = normalize(wo + mirrored);
        let r = facet_reflectance(b, dot(wo, h));
        let share = select(1.0 - r, r, wi.z > 0.0);
        return vec3<f32>(share * gain * ggx_d(h, b.alpha) * ggx_g2(wo, mirrored, b.alpha) / (4.0 * wo.z));
    }
    let m = refracting_facet(wo, wi, b.eta);
    let om = dot(wo, m);
    let im = dot(wi, m);
    if om <= 0.0 || im >= 0.0 {
        return vec3<f32>(0.0);
    }
    let share = 1.0 - dielectric_fresnel(om, b.eta);
    let bent = square(im + om / b.eta);
    let f = share * gain * ggx_d(m, b.alpha) * ggx_g2(wo, mirrored, b.alpha) * om * -im / (wo.z * bent);
    // Radiance is squeezed into a narrower cone in the denser medium (Veach 1997, §5.2).
    return vec3<f32>(f / (b.eta * b.eta));
}

fn dielectric_pdf(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    if (b.flags & COMPENSATE) != 0u {
        // Nothing is lost, so what is sent where is a density itself; of energy, which is not squeezed.
        let energy = select(1.0, b.eta * b.eta, wi.z < 0.0 && !is_thin(b));
        return dielectric_eval(b, wo, wi).x * energy;
    }
    if wo.z <= 0.0 || wi.z == 0.0 || dielectric_is_delta(b) {
        return 0.0;
    }
    if wi.z > 0.0 || is_thin(b) {
        let h = normalize(wo + vec3<f32>(wi.xy, abs(wi.z)));
        let r = facet_reflectance(b, dot(wo, h));
        return select(1.0 - r, r, wi.z > 0.0) * ggx_d(h, b.alpha) * ggx_visible_pdf(wo, b.alpha);
    }
    let m = refracting_facet(wo, wi, b.eta);
    let om = dot(wo, m);
    let im = dot(wi, m);
    if om <= 0.0 || im >= 0.0 {
        return 0.0;
    }
    let visible = 4.0 * ggx_visible_pdf(wo, b.alpha) * om * ggx_d(m, b.alpha);
    return (1.0 - dielectric_fresnel(om, b.eta)) * visible * -im / square(im + om / b.eta);
}

fn smooth_sample(b: Bsdf, wo: vec3<f32>, u: f32) -> BsdfSample {
    if is_thin(b) {
        if u < facet_reflectance(b, wo.z) {
            return mirror_sample(wo, vec3<f32>(1.0));
        }
        return BsdfSample(-wo, vec3<f32>(1.0), DELTA_PDF, 1.0);
    }
    if abs(b.eta - 1.0) < MATCHED {
        return BsdfSample(-wo, vec3<f32>(1.0 / (b.eta * b.eta)), DELTA_PDF, b.eta);
    }
    if u < dielectric_fresnel(wo.z, b.eta) {
        return mirror_sample(wo, vec3<f32>(1.0));
    }
    let ct = sqrt(max(0.0, 1.0 - (1.0 - wo.z * wo.z) / (b.eta * b.eta)));
    return BsdfSample(vec3<f32>(-wo.xy / b.eta, -ct), vec3<f32>(1.0 / (b.eta * b.eta)), DELTA_PDF, b.eta);
}

/// Tries to leave a rough boundary; at worst (leaving, roughness 1) every second one fails.
const MAX_TRIES: u32 = 32u;

fn dielectric_sample(b: Bsdf, wo: vec3<f32>, u: vec2<f32>, lobe: f32) -> BsdfSample {
    if dielectric_is_delta(b) {
        return smooth_sample(b, wo, u.x);
    }
    var v = vec3<f32>(u, lobe);
    var state = pcg(bitcast<u32>(u.x) ^ pcg(bitcast<u32>(u.y) ^ pcg(bitcast<u32>(lobe))));
    let seen = 1.0 + ggx_lambda(wo, b.alpha);
    for (var i = 0u; i < MAX_TRIES; i++) {
        let m = ggx_visible_normal(wo, b.alpha, v.xy);
        let om = dot(wo, m);
        var wi = 2.0 * om * m - wo;
        var eta = 1.0;
        let reflected = v.z < facet_reflectance(b, om);
        if !reflected {
            if is_thin(b) {
                wi.z = -wi.z;
            } else {
                let ct = sqrt(max(0.0, 1.0 - (1.0 - om * om) / (b.eta * b.eta)));
                wi = (om / b.eta - ct) * m - wo / b.eta;
                eta = b.eta;
            }
        }
        // What other facets are in the way of starts anew where it is compensated, and is lost where it is not.
        let free = select(0.0, seen / (seen + ggx_lambda(wi, b.alpha)), reflected == (wi.z > 0.0) && wi.z != 0.0);
        let compensated = (b.flags & COMPENSATE) != 0u;
        state = pcg(state);
        if !compensated || unit_float(state) < free {
            let pdf = dielectric_pdf(b, wo, wi);
            if !(free > 0.0 && pdf > 0.0) {
                return no_sample();
            }
            return BsdfSample(wi, vec3<f32>(select(free, 1.0, compensated) / (eta * eta)), pdf, eta);
        }
        let x = pcg(state);
        let y = pcg(x);
        state = pcg(y);
        v = vec3<f32>(unit_float(x), unit_float(y), unit_float(state));
    }
    return no_sample();
}
