// The GGX distribution of microfacets, stretched along x and y: height-correlated Smith masking (Heitz, "Understanding
// the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014) and visible normals by spherical caps
// (Dupuy and Benyoub, CGF 42(8), 2023), bounded for reflection (Eto and Tokuyoshi, SIGGRAPH Asia 2023).

/// Below this α a surface is smooth: the lobe is too narrow for f32.
const MIRROR_ALPHA: f32 = 1e-3;

/// Density of microfacet normals. From the slope of h, since 1 − cos² cancels where α is small.
fn ggx_d(h: vec3<f32>, alpha: vec2<f32>) -> f32 {
    let stretched = h.xy / alpha;
    let slope = dot(stretched, stretched) + h.z * h.z;
    return INV_PI / (alpha.x * alpha.y * square(slope));
}

/// Λ of Smith's masking.
fn ggx_lambda(w: vec3<f32>, alpha: vec2<f32>) -> f32 {
    let stretched = alpha * w.xy;
    return 0.5 * (sqrt(1.0 + dot(stretched, stretched) / (w.z * w.z)) - 1.0);
}

/// The share of facets seen from both directions.
fn ggx_g2(wo: vec3<f32>, wi: vec3<f32>, alpha: vec2<f32>) -> f32 {
    return 1.0 / (1.0 + ggx_lambda(wo, alpha) + ggx_lambda(wi, alpha));
}

// A normal of the cap above −limit · w.z.
fn cap_normal(w: vec3<f32>, limit: f32, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    let low = limit * w.z;
    let z = (1.0 - u.y) * (1.0 + low) - low;
    let c = vec3<f32>(sqrt(clamp(1.0 - z * z, 0.0, 1.0)) * cos_sin_turn(u.x), z);
    let h = c + w;
    return normalize(vec3<f32>(alpha * h.xy, max(1e-6, h.z)));
}

/// A normal in proportion to how much of it is seen from `wo`.
fn ggx_visible_normal(wo: vec3<f32>, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    return cap_normal(normalize(vec3<f32>(alpha * wo.xy, wo.z)), 1.0, alpha, u);
}

// How far below the horizon normals that reflect upwards may lie (equation 5 of Eto and Tokuyoshi).
fn bounded_limit(wo: vec3<f32>, alpha: vec2<f32>) -> f32 {
    let a = min(min(alpha.x, alpha.y), 1.0);
    let s = 1.0 + length(wo.xy);
    return (1.0 - a * a) * s * s / (s * s + a * a * wo.z * wo.z);
}

/// A normal in proportion to how much of it is seen from `wo`, but fewer of those that reflect below the horizon.
fn ggx_bounded_normal(wo: vec3<f32>, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    return cap_normal(normalize(vec3<f32>(alpha * wo.xy, wo.z)), bounded_limit(wo, alpha), alpha, u);
}

/// The density a steradian of the direction that `ggx_bounded_normal` reflects to, over D.
fn ggx_bounded_pdf(wo: vec3<f32>, alpha: vec2<f32>) -> f32 {
    let t = sqrt(dot(alpha * wo.xy, alpha * wo.xy) + wo.z * wo.z);
    return 0.5 / (bounded_limit(wo, alpha) * wo.z + t);
}

/// The density of the direction that `ggx_visible_normal` reflects to, over D.
fn ggx_visible_pdf(wo: vec3<f32>, alpha: vec2<f32>) -> f32 {
    return 0.25 / ((1.0 + ggx_lambda(wo, alpha)) * wo.z);
}
