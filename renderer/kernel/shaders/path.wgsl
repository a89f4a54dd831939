// Path tracing with next-event estimation. Light arrives in two ways, by sampling a light and by chance of the BSDF; the
// power heuristic weighs both (Veach 1997, §9.2).

/// How much of the way to a light must be free: rounding must not let the light shade itself.
const SHADOW_REACH: f32 = 0.9999;

fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    return 1.0 / (1.0 + ratio * ratio);
}

/// A point of a path: the surface seen from the side of `wo`.
struct Vertex {
    p: vec3<f32>,
    /// Geometric normal on the side of `wo`.
    ng: vec3<f32>,
    /// About the shading normal on the side of `wo`.
    frame: Frame,
    /// Local direction to where the path came from.
    wo: vec3<f32>,
    /// Whether that is the outer side.
    front: bool,
    /// The primitive that it lies on.
    primitive: u32,
}

fn vertex_at(s: Surface, hit: Hit, d: vec3<f32>) -> Vertex {
    let front = dot(s.ng, d) < 0.0;
    let ng = select(-s.ng, s.ng, front);
    var ns = select(-s.ns, s.ns, front);
    // A shading normal that looks away from the eye cannot be shaded from there.
    if dot(ns, d) > -1e-4 {
        ns = ng;
    }
    let frame = frame_about(ns);
    return Vertex(s.p, ng, frame, to_local(frame, -d), front, hit.id);
}

// Light that comes straight from a light, through `absorption` a metre; w: the rays that it took.
fn direct_light(m: Material, v: Vertex, absorption: vec3<f32>, u: vec2<f32>) -> vec4<f32> {
    let s = light_sample(v.p, u);
    if !(s.pdf > 0.0) {
        return vec4<f32>(0.0);
    }
    if dot(s.p - v.p, v.ng) <= 0.0 {
        return vec4<f32>(0.0);
    }
    let start = offset_point(v.p, v.ng);
    let to = s.p - start;
    let facing = dot(s.n, to) < 0.0;
    let distance = length(to);
    if distance == 0.0 {
        return vec4<f32>(0.0);
    }
    let d = to / distance;
    let wi = to_local(v.frame, d);
    let carried = bsdf_eval(m, v.wo, wi) * light_eval(s.shape, facing);
    if max_component(carried) <= 0.0 {
        return vec4<f32>(0.0);
    }
    if any_hit(start, d, distance * SHADOW_REACH, v.primitive) {
        return vec4<f32>(0.0, 0.0, 0.0, 1.0);
    }
    let weight = power_heuristic(s.pdf, bsdf_pdf(m, v.wo, wi)) / s.pdf;
    return vec4<f32>(carried * transmittance(absorption, distance) * weight, 1.0);
}

fn transmittance(absorption: vec3<f32>, distance: f32) -> vec3<f32> {
    if max_component(absorption) <= 0.0 {
        return vec3<f32>(1.0);
    }
    let depth = absorption * distance;
    return vec3<f32>(exp_(-depth.x), exp_(-depth.y), exp_(-depth.z));
}

/// One sample of the light that a pixel receives; w: the rays that it took.
fn radiance(pixel: vec2<u32>, sample: u32) -> vec4<f32> {
    let key = sample_key(pixel, sample);
    var ray = camera_ray(pixel, key);
    var light = vec3<f32>(0.0);
    var beta = vec3<f32>(1.0);
    // Undoes the η² in `beta`, so that roulette does not kill what only passes through glass.
    var eta_scale = 1.0;
    var pdf = DELTA_PDF;
    var absorption = vec3<f32>(0.0);
    var rays = 0.0;
    var start = NONE;
    for (var bounce = 0u; ; bounce++) {
        // Find what the ray meets, through the medium that it crosses.
        let hit = closest_hit(ray.o, ray.d, start);
        rays += 1.0;
        beta *= transmittance(absorption, hit.t);
        if hit.id == NONE {
            light += beta * params.sky.xyz * select(1.0, params.sky.w, bounce == 0u);
            break;
        }
        let s = surface_at(hit, ray.o, ray.d);
        let m = materials[shapes[s.shape].index.x];

        // Add what it emits; what light sampling could have found counts in part.
        if m.kind.x == MATERIAL_EMITTER {
            let emitted = light_eval(s.shape, dot(s.ng, ray.d) < 0.0);
            var weight = 1.0;
            if pdf != DELTA_PDF {
                weight = power_heuristic(pdf, light_pdf(s, ray.o));
            }
            light += beta * emitted * weight;
            break;
        }
        if bounce >= params.max_bounces {
            break;
        }

        // Sample a light.
        let v = vertex_at(s, hit, ray.d);
        let dimension = DIM_BOUNCE + bounce * DIM_STRIDE;
        if params.light_count > 0u && !bsdf_is_delta(m) {
            let direct = direct_light(m, v, absorption, random_2d(key, dimension + DIM_LIGHT));
            light += beta * direct.xyz;
            rays += direct.w;
        }

        // Choose where to go on.
        let next = bsdf_sample(m, v.wo, v.front, random_2d(key, dimension + DIM_BSDF));
        let d = from_local(v.frame, next.wi);
        let above = dot(d, v.ng) > 0.0;
        if next.pdf == 0.0 || above != (next.wi.z > 0.0) {
            break;
        }
        beta *= next.weight;
        pdf = next.pdf;
        start = hit.id;
        ray = Ray(offset_point(v.p, select(-v.ng, v.ng, above)), normalize(d));
        if !above {
            absorption = select(vec3<f32>(0.0), m.extra.xyz, v.front);
            eta_scale *= next.eta * next.eta;
        }

        // End paths that carry little, and let the others carry their share.
        if bounce + 1u >= params.roulette_from {
            let survival = clamp(max_component(beta) * eta_scale, 0.05, 1.0);
            if random_1d(key, dimension + DIM_ROULETTE) >= survival {
                break;
            }
            beta /= survival;
        }
    }
    // What is not a number would spoil all samples of the pixel. Bits are compared, since WGSL may assume that no
    // such value occurs.
    let bits = bitcast<vec3<u32>>(light) & vec3<u32>(0x7f800000u);
    if any(bits == vec3<u32>(0x7f800000u)) {
        return vec4<f32>(0.0, 0.0, 0.0, rays);
    }
    return vec4<f32>(light, rays);
}
