// What all materials share: `sample`, `eval` and `pdf` in the frame of the shading normal, with `wo` above it (z > 0).
// A point shows one material of a tree, chosen by chance where materials are mixed, under at most one coat.

/// The pdf of a direction that only one direction of `wo` leads to.
const DELTA_PDF: f32 = -1.0;
/// Materials from the root of a tree to a leaf; deeper trees are refused when the scene is packed.
const MAX_DEPTH: u32 = 64u;

/// A material at a point. What is stated for some kinds is unused by the others.
struct Bsdf {
    /// Index of the material, MATERIAL_…, and flags.
    material: u32,
    kind: u32,
    flags: u32,
    /// As in `Material`.
    color: vec3<f32>,
    extra: vec3<f32>,
    more: vec3<f32>,
    /// GGX α along x and y.
    alpha: vec2<f32>,
    roughness: f32,
    anisotropy: f32,
    /// Cosine and sine of the tangent's turn.
    turn: vec2<f32>,
    /// dielectric: refractive index of the side away from `wo` over that of its own.
    eta: f32,
    /// Of the coat: α, ior, roughness. ior 0: there is none.
    coat: vec3<f32>,
    /// Of the coat: what it reflects straight on, over what its ior does.
    coat_tint: vec3<f32>,
    /// What comes through the coat: 1 − its albedo seen from `wo`.
    under: f32,
}

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

fn mirror_sample(wo: vec3<f32>, weight: vec3<f32>) -> BsdfSample {
    return BsdfSample(vec3<f32>(-wo.xy, wo.z), weight, DELTA_PDF, 1.0);
}

// `b` with the chance `share`, else `a`; u is changed to a fresh number in 0 <= u < 1.
fn branch(u: ptr<function, f32>, share: f32, a: u32, b: u32) -> u32 {
    let second = *u < share;
    let rest = select((*u - share) / (1.0 - share), *u / share, second);
    *u = clamp(rest, 0.0, 0.99999994);
    return select(a, b, second);
}

/// The BSDF of `material` without textures seen at cosine `c`; `u`, uniform in 0 <= u < 1, chooses where there is a
/// choice.
fn bsdf_at(material: u32, c: f32, u: f32) -> Bsdf {
    var s: Surface;
    var v: Vertex;
    v.wo.z = c;
    return bsdf_on(material, s, &v, u);
}

/// The BSDF of `material` at a point; `u`, uniform in 0 <= u < 1, chooses where there is a choice. A normal map turns
/// the vertex's frame.
fn bsdf_on(material: u32, s: Surface, v: ptr<function, Vertex>, u: f32) -> Bsdf {
    var index = material;
    var choice = u;
    var mapped = false;
    var coat = vec3<f32>(0.0);
    var coat_tint = vec3<f32>(1.0);
    var under = 1.0;
    var inner = 0.0;
    let tree = has_material(MATERIAL_MIX) || has_material(MATERIAL_GLOSSY) || has_material(MATERIAL_SHEEN);
    for (var depth = 0u; tree && depth < MAX_DEPTH; depth++) {
        let kind = materials[index].kind;
        if kind.x != MATERIAL_MIX && kind.x != MATERIAL_GLOSSY && kind.x != MATERIAL_SHEEN {
            break;
        }
        var lobe = materials[index].lobe;
        // Of fibres, or of a coat.
        var color = materials[index].color.xyz;
        var split = false;
        if has_textures() {
            let here = material_on(index, s);
            lobe = here.lobe;
            color = here.color.xyz;
            split = (maps_of(index, MAPS_FLAGS) & MAPS_SPLIT) != 0u;
            mapped = turn_normal(index, s, v) || mapped;
        }
        if kind.x == MATERIAL_MIX {
            index = branch(&choice, lobe.x, kind.z, kind.w);
            continue;
        }
        if has_material(MATERIAL_SHEEN) && kind.x == MATERIAL_SHEEN {
            // The fibres alone as often as light comes back from them, else what they cover.
            let share = min(max_component(color) * sheen_albedo(max((*v).wo.z, MIN_COSINE), lobe.z), 1.0);
            index = branch(&choice, 1.0 - share, index, kind.z);
            if index != kind.z {
                inner = 1.0 / share;
                break;
            }
            continue;
        }
        let metal = choice < lobe.w;
        let below = branch(&choice, lobe.w, kind.z, kind.w);
        if metal {
            index = below;
            continue;
        }
        let albedo = coat_albedo(lobe.x, lobe.z, lobe.y, max((*v).wo.z, MIN_COSINE));
        if coat.y == 0.0 && !split {
            coat = vec3<f32>(lobe.x, lobe.y, lobe.z);
            coat_tint = color;
            under = 1.0 - albedo;
            index = below;
            continue;
        }
        // A coat below a coat, or over another normal: the coat alone as often as light comes back from it, else what it covers.
        index = branch(&choice, 1.0 - albedo, index, below);
        if index != below {
            inner = 1.0 / albedo;
            break;
        }
    }
    var m = materials[index];
    if has_textures() {
        m = material_on(index, s);
        if inner == 0.0 {
            mapped = turn_normal(index, s, v) || mapped;
        }
        if mapped {
            bend_normal(v, m.kind.x == MATERIAL_DIFFUSE && coat.y == 0.0);
        }
    }
    if inner > 0.0 {
        let color = inner * select(vec3<f32>(1.0), m.color.xyz, m.kind.x == MATERIAL_SHEEN);
        return Bsdf(index, m.kind.x, 0u, color, m.color.xyz, color, m.lobe.xx, m.lobe.z, 0.0, vec2<f32>(1.0, 0.0),
            m.lobe.y, coat, coat_tint, under);
    }
    return Bsdf(index, m.kind.x, m.kind.y, m.color.xyz, m.extra.xyz, m.more.xyz, m.lobe.xy, m.lobe.z, m.lobe.w,
        vec2<f32>(m.color.w, m.extra.w), m.extra.w, coat, coat_tint, under);
}

// --- what lies below the coat

fn base_is_delta(b: Bsdf) -> bool {
    switch b.kind {
        case MATERIAL_DIFFUSE, MATERIAL_SHEEN: {
            return false;
        }
        case MATERIAL_DIELECTRIC: {
            return dielectric_is_delta(b);
        }
        default: {
            return max(b.alpha.x, b.alpha.y) < MIRROR_ALPHA;
        }
    }
}

fn base_eval(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    switch b.kind {
        case MATERIAL_DIFFUSE: {
            return diffuse_eval(b, wo, wi);
        }
        case MATERIAL_METAL: {
            if !has_material(MATERIAL_METAL) {
                return vec3<f32>(0.0);
            }
            return metal_eval(b, wo, wi);
        }
        case MATERIAL_DIELECTRIC: {
            if !has_material(MATERIAL_DIELECTRIC) {
                return vec3<f32>(0.0);
            }
            return dielectric_eval(b, wo, wi) * dielectric_tint(b, wi);
        }
        case MATERIAL_GLOSSY: {
            if !has_material(MATERIAL_GLOSSY) {
                return vec3<f32>(0.0);
            }
            return b.color * coat_eval(b.alpha.x, b.eta, b.extra, wo, wi);
        }
        case MATERIAL_SHEEN: {
            if !has_material(MATERIAL_SHEEN) {
                return vec3<f32>(0.0);
            }
            return b.color * sheen_eval(b.roughness, wo, wi);
        }
        default: {
            return vec3<f32>(0.0);
        }
    }
}

fn base_pdf(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    switch b.kind {
        case MATERIAL_DIFFUSE: {
            return diffuse_pdf(b, wo, wi);
        }
        case MATERIAL_METAL: {
            if !has_material(MATERIAL_METAL) {
                return 0.0;
            }
            return metal_pdf(b, wo, wi);
        }
        case MATERIAL_DIELECTRIC: {
            if !has_material(MATERIAL_DIELECTRIC) {
                return 0.0;
            }
            return dielectric_pdf(b, wo, wi);
        }
        case MATERIAL_GLOSSY: {
            if !has_material(MATERIAL_GLOSSY) {
                return 0.0;
            }
            return coat_pdf(b.alpha.x, wo, wi);
        }
        case MATERIAL_SHEEN: {
            if !has_material(MATERIAL_SHEEN) {
                return 0.0;
            }
            return sheen_pdf(wo, wi);
        }
        default: {
            return 0.0;
        }
    }
}

fn base_sample(b: Bsdf, wo: vec3<f32>, u: vec2<f32>, lobe: f32) -> BsdfSample {
    switch b.kind {
        case MATERIAL_DIFFUSE: {
            return diffuse_sample(b, wo, u, lobe);
        }
        case MATERIAL_METAL: {
            if !has_material(MATERIAL_METAL) {
                return no_sample();
            }
            return metal_sample(b, wo, u, lobe);
        }
        case MATERIAL_DIELECTRIC: {
            if !has_material(MATERIAL_DIELECTRIC) {
                return no_sample();
            }
            var s = dielectric_sample(b, wo, u, lobe);
            s.weight *= dielectric_tint(b, s.wi);
            return s;
        }
        case MATERIAL_GLOSSY: {
            if !has_material(MATERIAL_GLOSSY) {
                return no_sample();
            }
            var s = coat_sample(b.alpha.x, b.eta, b.extra, wo, u);
            s.weight *= b.color;
            return s;
        }
        case MATERIAL_SHEEN: {
            if !has_material(MATERIAL_SHEEN) {
                return no_sample();
            }
            return sheen_sample(b, wo, u);
        }
        default: {
            return no_sample();
        }
    }
}

// --- with the coat

/// Whether light can pass to the other side.
fn bsdf_transmits(b: Bsdf) -> bool {
    return b.kind == MATERIAL_DIELECTRIC;
}

/// Whether light sampling can find nothing through it.
fn bsdf_is_delta(b: Bsdf) -> bool {
    return b.kind == MATERIAL_EMITTER && b.coat.y == 0.0 || base_is_delta(b) && coat_is_delta(b);
}

fn has_coat(b: Bsdf) -> bool {
    return has_material(MATERIAL_GLOSSY) && b.coat.y != 0.0;
}

fn coat_is_delta(b: Bsdf) -> bool {
    return !has_coat(b) || b.coat.x < MIRROR_ALPHA;
}

// How often a direction is drawn from the coat.
fn coat_chance(b: Bsdf) -> f32 {
    if !has_coat(b) {
        return 0.0;
    }
    let coat = 1.0 - b.under;
    let base = b.under * clamp(luminance(b.color), 0.0, 1.0);
    return clamp(coat / max(coat + base, 1e-6), 0.1, 0.9);
}

/// f · |cos|; 0 for delta lobes.
fn bsdf_eval(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    let base = base_eval(b, wo, wi);
    if !has_coat(b) {
        return base;
    }
    return coat_eval(b.coat.x, b.coat.y, b.coat_tint, wo, wi) + b.under * base;
}

/// The share of `bsdf_eval` that a diffuse lobe has, by channel; 0 where there is nothing.
fn bsdf_diffuse(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    if b.kind != MATERIAL_DIFFUSE {
        return vec3<f32>(0.0);
    }
    if !has_coat(b) {
        return vec3<f32>(1.0);
    }
    let base = b.under * diffuse_eval(b, wo, wi);
    let all = base + coat_eval(b.coat.x, b.coat.y, b.coat_tint, wo, wi);
    return select(vec3<f32>(0.0), base / all, all > vec3<f32>(0.0));
}

/// The density with which `bsdf_sample` draws `wi`, a steradian; 0 for delta lobes.
fn bsdf_pdf(b: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    let base = base_pdf(b, wo, wi);
    if !has_coat(b) {
        return base;
    }
    return mix(base, coat_pdf(b.coat.x, wo, wi), coat_chance(b));
}

/// A direction in proportion to what it carries, as far as possible; `lobe`, uniform, chooses among lobes.
fn bsdf_sample(b: Bsdf, wo: vec3<f32>, u: vec2<f32>, lobe: f32) -> BsdfSample {
    if !has_coat(b) {
        return base_sample(b, wo, u, lobe);
    }
    let chance = coat_chance(b);
    var s: BsdfSample;
    if lobe < chance {
        s = coat_sample(b.coat.x, b.coat.y, b.coat_tint, wo, u);
        s.weight /= chance;
    } else {
        s = base_sample(b, wo, u, min((lobe - chance) / (1.0 - chance), 0.99999994));
        s.weight *= b.under / (1.0 - chance);
    }
    if s.pdf > 0.0 {
        s.pdf = bsdf_pdf(b, wo, s.wi);
        s.weight = bsdf_eval(b, wo, s.wi) / s.pdf;
    }
    return s;
}

/// What colour it has, for pictures of colours: of a metal what it reflects to where it came from, of glass white; under
/// a coat, seen at the cosine of `bsdf_at`.
fn bsdf_colour(b: Bsdf) -> vec3<f32> {
    var base = vec3<f32>(0.0);
    switch b.kind {
        case MATERIAL_DIFFUSE: {
            base = b.color;
        }
        case MATERIAL_METAL: {
            base = metal_fresnel(b, 1.0);
        }
        case MATERIAL_DIELECTRIC: {
            base = vec3<f32>(1.0);
        }
        case MATERIAL_GLOSSY: {
            base = b.extra;
        }
        case MATERIAL_SHEEN: {
            base = b.color / max(max_component(b.color), 1e-6);
        }
        default: {}
    }
    return (1.0 - b.under) * b.coat_tint + b.under * base;
}
