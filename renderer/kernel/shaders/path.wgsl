// Path tracing with next-event estimation. Light arrives in two ways, by sampling a light and by chance of the BSDF, and
// heuristics weigh them (Veach 1997, §9.2). A path is a value that advances from one ray query to the next, so that a
// backend may keep many of them going at once.

/// How much of the way to a light must be free: rounding must not let the light shade itself.
const SHADOW_REACH: f32 = 0.9999;
/// Surfaces that a path may pass as if they were not there, before it is given up.
const MAX_PASSES: u32 = 4096u;

struct Path {
    key: SampleKey,
    /// The next ray, and the primitive that it starts on or NONE.
    o: vec3<f32>,
    d: vec3<f32>,
    start: u32,
    /// Where it was scattered last; cut-outs between there and `o` do not count.
    vertex: vec3<f32>,
    /// The normal there on the side from which it came, as `light_sample` was asked with.
    facing: vec3<f32>,
    /// What has arrived so far.
    light: vec3<f32>,
    /// The share of what lies ahead that arrives.
    beta: vec3<f32>,
    /// With which `d` was drawn; DELTA_PDF where sampling a light cannot find what lies ahead.
    pdf: f32,
    /// Whether a light was sampled in its stead.
    lit: bool,
    /// Undoes the η² in `beta`, so that roulette does not kill what only passes through glass.
    eta_scale: f32,
    /// The media around `o`: see media.wgsl.
    media: vec4<u32>,
    bounce: u32,
    passes: u32,
    /// Whether there is a next ray.
    alive: bool,
    rays: f32,
    /// Light that arrives as far as nothing is between `shadow_o` and `shadow_t` metres along `shadow_d`; no ray if that is
    /// 0. It starts on the primitive that the next ray starts on.
    shadow_light: vec3<f32>,
    shadow_o: vec3<f32>,
    shadow_d: vec3<f32>,
    shadow_t: f32,
}

/// A point of a path: the surface seen from the side of `wo`.
struct Vertex {
    /// Geometric normal on the side of `wo`.
    ng: vec3<f32>,
    /// About the shading normal on the side of `wo`.
    frame: Frame,
    /// Local direction to where the path came from.
    wo: vec3<f32>,
    /// Whether that is the outer side.
    front: bool,
}

fn vertex_at(s: Surface, d: vec3<f32>) -> Vertex {
    let front = dot(s.ng, d) < 0.0;
    let ng = select(-s.ng, s.ng, front);
    var ns = select(-s.ns, s.ns, front);
    // A shading normal that looks away from the eye cannot be shaded from there.
    if dot(ns, d) > -1e-4 {
        ns = ng;
    }
    let frame = frame_about(ns);
    return Vertex(ng, frame, to_local(frame, -d), front);
}

/// The weight of light that a light sample found, whose pdf is `pdf`, if the BSDF's is `other`.
fn light_weight(pdf: f32, other: f32) -> f32 {
    if params.light_chance < 0.0 {
        let ratio = other / pdf;
        return 1.0 / (1.0 + ratio * ratio);
    }
    return pdf / (params.light_chance * pdf + (1.0 - params.light_chance) * other);
}

/// The weight of light that a BSDF sample found, whose pdf is `pdf`, if a light sample finds it with `other`; `lit`: the
/// coin fell for the light sample.
fn bsdf_weight(pdf: f32, other: f32, lit: bool) -> f32 {
    if pdf == DELTA_PDF || other == 0.0 {
        return 1.0;
    }
    if params.light_chance < 0.0 {
        let ratio = other / pdf;
        return 1.0 / (1.0 + ratio * ratio);
    }
    if lit {
        return 0.0;
    }
    return pdf / (params.light_chance * other + (1.0 - params.light_chance) * pdf);
}

fn limited(share: vec3<f32>) -> vec3<f32> {
    return min(share, vec3<f32>(params.clamp));
}

/// The path of one sample of a pixel, at the camera.
fn path_start(pixel: vec2<u32>, sample: u32) -> Path {
    var path: Path;
    path.key = sample_key(pixel, sample);
    let ray = camera_ray(pixel, path.key);
    path.o = ray.o;
    path.d = ray.d;
    path.start = NONE;
    path.vertex = ray.o;
    path.beta = vec3<f32>(1.0);
    path.pdf = DELTA_PDF;
    path.eta_scale = 1.0;
    path.media = params.media;
    path.alive = (params.features & FEATURE_FISHEYE) == 0u || dot(ray.d, ray.d) > 0.0;
    return path;
}

// Asks for a ray to a light, and for what that would bring.
fn sample_light(path: ptr<function, Path>, s: Surface, v: Vertex, b: Bsdf, beyond: vec4<u32>, facing: vec3<f32>,
    wanted: bool, u: vec2<f32>) {
    let to_light = light_sample(s.p, facing, u);
    if !(to_light.pdf > 0.0) {
        return;
    }
    var delta = false;
    var distant = false;
    if (params.features & (FEATURE_DISTANT | FEATURE_DELTA)) != 0u {
        delta = light_is_delta(to_light.light);
        distant = lights[to_light.light].kind.x >= LIGHT_SUN;
    }
    if !wanted && !delta {
        return;
    }
    let above = dot(select(to_light.p - s.p, to_light.p, distant), v.ng) > 0.0;
    if !above && !bsdf_transmits(b) {
        return;
    }
    let start = offset_point(s, select(-v.ng, v.ng, above));
    let to = to_light.p - start;
    let distance = select(length(to), FAR, distant);
    if distance == 0.0 {
        return;
    }
    let d = select(to / distance, to_light.p, distant);
    let wi = to_local(v.frame, d);
    if above != (wi.z > 0.0) {
        return;
    }
    let emitted = light_emission(to_light, d, distance);
    let f = bsdf_eval(b, v.wo, wi);
    if max_component(f * emitted) <= 0.0 {
        return;
    }
    let media = select(beyond, (*path).media, above);
    let share = f * transmittance(media_absorption(media), distance);
    // What only light samples find counts whole.
    let weight = select(light_weight(to_light.pdf, bsdf_pdf(b, v.wo, wi)), 1.0, delta) / to_light.pdf;
    (*path).shadow_light = limited((*path).beta * share * weight) * emitted;
    (*path).shadow_o = start;
    (*path).shadow_d = d;
    (*path).shadow_t = distance * SHADOW_REACH;
}

// Goes on along the same line behind a surface that is not there.
fn go_through(path: ptr<function, Path>, s: Surface) {
    (*path).o = offset_point(s, select(-s.ng, s.ng, dot(s.ng, (*path).d) > 0.0));
    (*path).passes++;
    (*path).alive = (*path).passes < MAX_PASSES;
}

// The first of the random numbers of the path's next scattering.
fn bounce_dimension(path: ptr<function, Path>) -> u32 {
    return DIM_BOUNCE + (*path).bounce * DIM_STRIDE;
}

// Whether this ray passes `material` at `s` where not all of them meet it.
fn is_cut_out(path: ptr<function, Path>, material: u32, s: Surface) -> bool {
    if (params.features & FEATURE_CUTOUT) == 0u {
        return false;
    }
    let opacity = opacity_on(material, s);
    let dimension = DIM_CUTOUT + bounce_dimension(path) * MAX_PASSES + (*path).passes;
    return opacity < 1.0 && random_1d((*path).key, dimension) >= opacity;
}

// The numbers that choose among what `material` is made of.
fn material_choice(path: ptr<function, Path>, material: u32) -> vec2<f32> {
    if (materials[material].kind.y & CHOICE) == 0u {
        return vec2<f32>(0.0);
    }
    return random_2d((*path).key, bounce_dimension(path) + DIM_CHOICE);
}

/// What happens where the path's ray met something: the path gets its next ray, or ends, and may ask for a shadow ray.
fn path_shade(path: ptr<function, Path>, hit: Hit) {
    (*path).shadow_t = 0.0;
    (*path).rays += 1.0;
    (*path).beta *= transmittance(media_absorption((*path).media), hit.t);
    if hit.id == NONE {
        if (*path).bounce > 0u || params.sky.w > 0.0 {
            (*path).light += distant_light((*path).d, (*path).beta, (*path).pdf, (*path).lit);
        }
        (*path).alive = false;
        return;
    }
    let s = surface_at(hit, (*path).o, (*path).d);
    let material = shapes[s.shape].index.x;
    (*path).start = start_of(hit);
    if is_cut_out(path, material, s) {
        go_through(path, s);
        return;
    }

    // Add what it emits; what sampling a light could have found counts in part.
    if shapes[s.shape].index.z != NONE {
        var emitted = light_eval(s.shape, -dot(s.ng, (*path).d), -(*path).d);
        if (params.features & FEATURE_GLOW) != 0u {
            emitted += glow_met(s, -dot(s.ng, (*path).d));
        }
        let weight = bsdf_weight((*path).pdf, light_pdf(s, (*path).vertex, (*path).facing), (*path).lit);
        (*path).light += limited((*path).beta * weight) * emitted;
    }

    // Choose one of the materials that it is mixed of, and see whether there is a boundary at all.
    var v = vertex_at(s, (*path).d);
    let choice = material_choice(path, material);
    var b = bsdf_on(material, s, &v, choice.x);
    if b.alpha.x != b.alpha.y {
        // Seen from within, what runs counter-clockwise runs clockwise.
        let turn = vec2<f32>(b.turn.x, select(-b.turn.y, b.turn.y, v.front));
        v.frame = frame_along(v.frame.z, s.tangent, turn);
        v.wo = to_local(v.frame, -(*path).d);
    }
    let crossing = boundary_at(b, (*path).media, v.front);
    if crossing.hidden {
        (*path).media = crossing.beyond;
        (*path).pdf = DELTA_PDF;
        go_through(path, s);
        return;
    }
    let beyond = crossing.beyond;
    b.eta = crossing.eta;

    if (*path).bounce >= params.max_bounces {
        (*path).alive = false;
        return;
    }

    // Sample a light.
    let dimension = bounce_dimension(path);
    (*path).lit = params.light_chance >= 0.0
        && random_1d((*path).key, dimension + DIM_TECHNIQUE) < params.light_chance;
    let facing = select(v.ng, vec3<f32>(0.0), bsdf_transmits(b));
    let wanted = (*path).lit || params.light_chance < 0.0;
    if params.light_count + params.distant_count > 0u && !bsdf_is_delta(b)
        && (wanted || (params.features & FEATURE_DELTA) != 0u) {
        sample_light(path, s, v, b, beyond, facing, wanted, random_2d((*path).key, dimension + DIM_LIGHT));
    }

    // Choose where to go on.
    let next = bsdf_sample(b, v.wo, random_2d((*path).key, dimension + DIM_BSDF), choice.y);
    let d = from_local(v.frame, next.wi);
    let above = dot(d, v.ng) > 0.0;
    if next.pdf == 0.0 || above != (next.wi.z > 0.0) {
        (*path).alive = false;
        return;
    }
    (*path).beta *= next.weight;
    (*path).pdf = next.pdf;
    (*path).vertex = s.p;
    (*path).facing = facing;
    (*path).o = offset_point(s, select(-v.ng, v.ng, above));
    (*path).d = normalize(d);
    (*path).bounce++;
    if !above {
        (*path).media = beyond;
        (*path).eta_scale *= next.eta * next.eta;
    }

    // End paths that carry little, and let the others carry their share.
    if (*path).bounce >= params.roulette_from {
        let survival = clamp(max_component((*path).beta) * (*path).eta_scale, 0.05, 1.0);
        (*path).alive = random_1d((*path).key, dimension + DIM_ROULETTE) < survival;
        (*path).beta /= survival;
    }
}

/// The share of light that comes through from `t_max` metres along `d`.
fn shadow_share(o: vec3<f32>, d: vec3<f32>, t_max: f32, start: u32) -> f32 {
    if (params.features & FEATURE_CUTOUT) == 0u {
        return select(1.0, 0.0, any_hit(o, d, t_max, start));
    }
    let end = o + t_max * d;
    var share = 1.0;
    var origin = o;
    var along = d;
    var left = t_max;
    var on = start;
    for (var passes = 0u; passes < MAX_PASSES; passes++) {
        let hit = closest_hit(origin, along, on);
        if hit.id == NONE || hit.t >= left {
            return share;
        }
        let s = surface_at(hit, origin, along);
        share *= 1.0 - opacity_on(shapes[s.shape].index.x, s);
        if share <= 0.0 {
            return 0.0;
        }
        // Still to the same end: the step off the surface may be longer than the way that the light is spared.
        origin = offset_point(s, select(-s.ng, s.ng, dot(s.ng, d) > 0.0));
        on = start_of(hit);
        if t_max >= SHADOW_REACH * FAR {
            continue;
        }
        along = end - origin;
        left = length(along);
        if dot(along, d) <= 0.0 {
            return share;
        }
        along /= left;
    }
    return 0.0;
}

/// Adds the light that the shadow ray asked for; `share` of it arrives.
fn path_shadow(path: ptr<function, Path>, share: f32) {
    (*path).rays += 1.0;
    (*path).light += (*path).shadow_light * share;
}

/// Whether it can be light. Bits are compared, since WGSL may assume that no value is infinite or not a number.
fn is_light(light: vec3<f32>) -> bool {
    let bits = bitcast<vec3<u32>>(light) & vec3<u32>(0x7f800000u);
    return !any(bits == vec3<u32>(0x7f800000u));
}

/// The light that the path brought to its pixel; w: the rays that it took.
fn path_light(path: Path) -> vec4<f32> {
    // What is not a number would spoil all samples of the pixel.
    if !is_light(path.light) {
        return vec4<f32>(0.0, 0.0, 0.0, path.rays);
    }
    return vec4<f32>(path.light, path.rays);
}

/// One sample of the light that a pixel receives; w: the rays that it took.
fn radiance(pixel: vec2<u32>, sample: u32) -> vec4<f32> {
    var path = path_start(pixel, sample);
    while path.alive {
        let hit = closest_hit(path.o, path.d, path.start);
        path_shade(&path, hit);
        if path.shadow_t > 0.0 {
            path_shadow(&path, shadow_share(path.shadow_o, path.shadow_d, path.shadow_t, path.start));
        }
    }
    return path_light(path);
}
