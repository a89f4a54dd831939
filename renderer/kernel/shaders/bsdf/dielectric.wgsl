// Smooth glass: exact Fresnel, total reflection, refraction.

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

/// `front`: whether `wo` is outside.
fn dielectric_sample(m: Material, wo: vec3<f32>, front: bool, u: f32) -> BsdfSample {
    let eta = select(1.0 / m.extra.w, m.extra.w, front);
    let reflectance = dielectric_fresnel(wo.z, eta);
    if u < reflectance {
        return BsdfSample(vec3<f32>(-wo.xy, wo.z), vec3<f32>(1.0), DELTA_PDF, 1.0);
    }
    let ct = sqrt(max(0.0, 1.0 - (1.0 - wo.z * wo.z) / (eta * eta)));
    // Radiance is squeezed into a narrower cone in the denser medium (Veach 1997, §5.2).
    return BsdfSample(vec3<f32>(-wo.xy / eta, -ct), vec3<f32>(1.0 / (eta * eta)), DELTA_PDF, eta);
}
