// Lights: emissive shapes, chosen by power, sampled by area or, for spheres, by the cone that they fill.

struct LightSample {
    /// On the light.
    p: vec3<f32>,
    /// The light's outward normal there.
    n: vec3<f32>,
    /// A steradian, seen eye the point that asked; includes the choice of the light. 0 if the light cannot be sampled.
    pdf: f32,
    /// The light's shape.
    shape: u32,
}

/// The light chosen by u, which is changed to a fresh number in 0 <= u < 1.
fn light_choose(u: ptr<function, f32>) -> u32 {
    var first = 0u;
    var last = params.light_count - 1u;
    while first < last {
        let middle = (first + last + 1u) / 2u;
        if lights[middle].origin.w <= *u {
            first = middle;
        } else {
            last = middle - 1u;
        }
    }
    *u = clamp((*u - lights[first].origin.w) / lights[first].edge_u.w, 0.0, 0.99999994);
    return first;
}

// 1 − cos of the half angle of a sphere's cone, eye (radius / distance)², without cancellation.
fn cone_height(sin2: f32) -> f32 {
    return sin2 / (1.0 + sqrt(max(0.0, 1.0 - sin2)));
}

fn sphere_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    let centre = lights[light].origin.xyz;
    let radius = lights[light].edge_u.x;
    let shape = lights[light].kind.y;
    let to_centre = centre - eye;
    let distance_2 = dot(to_centre, to_centre);
    let sin2_max = radius * radius / distance_2;
    if sin2_max >= 1.0 {
        // From within: every direction meets it.
        let z = 1.0 - 2.0 * u.x;
        let d = vec3<f32>(sqrt(max(0.0, 1.0 - z * z)) * cos_sin_turn(u.y), z);
        let b = dot(to_centre, d);
        let t = b + sqrt(max(0.0, b * b + radius * radius - distance_2));
        let n = normalize(eye + t * d - centre);
        return LightSample(centre + radius * n, n, 0.25 * INV_PI, shape);
    }
    let height = cone_height(sin2_max);
    let drop = u.x * height;
    let cos_theta = 1.0 - drop;
    let sin2_theta = drop * (2.0 - drop);
    let frame = frame_about(to_centre / sqrt(distance_2));
    let d = from_local(frame, vec3<f32>(sqrt(max(0.0, sin2_theta)) * cos_sin_turn(u.y), cos_theta));
    let distance = sqrt(distance_2);
    let t = distance * cos_theta - sqrt(max(0.0, radius * radius - distance_2 * sin2_theta));
    let n = normalize(eye + t * d - centre);
    return LightSample(centre + radius * n, n, 0.5 * INV_PI / height, shape);
}

// pdf a steradian of a point with pdf `per_area` a square metre.
fn pdf_of_area(per_area: f32, eye: vec3<f32>, p: vec3<f32>, n: vec3<f32>) -> f32 {
    let d = p - eye;
    let distance_2 = dot(d, d);
    let projected = abs(dot(d, n));
    return select(0.0, per_area * distance_2 * sqrt(distance_2) / projected, projected > 1e-20);
}

fn flat_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    var st = u;
    if lights[light].kind.x == LIGHT_TRIANGLE {
        // Heitz, "A Low-Distortion Map Between Triangle and Square", 2019.
        if u.y > u.x {
            st = vec2<f32>(0.5 * u.x, u.y - 0.5 * u.x);
        } else {
            st = vec2<f32>(u.x - 0.5 * u.y, 0.5 * u.y);
        }
    }
    let edge_u = lights[light].edge_u.xyz;
    let edge_v = lights[light].edge_v.xyz;
    let p = lights[light].origin.xyz + st.x * edge_u + st.y * edge_v;
    let normal = lights[light].normal;
    return LightSample(p, normal.xyz, pdf_of_area(normal.w, eye, p, normal.xyz), lights[light].kind.y);
}

// Area of the ellipsoid about a point, over that of the unit sphere about its image.
fn ellipsoid_stretch(light: u32, normal_unscaled: vec3<f32>) -> f32 {
    return lights[light].edge_u.x * length(normal_unscaled);
}

fn ellipsoid_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    let shape = lights[light].kind.y;
    let z = 1.0 - 2.0 * u.x;
    let q = vec3<f32>(sqrt(max(0.0, 1.0 - z * z)) * cos_sin_turn(u.y), z);
    let p = world_point(shape, q);
    let n = world_normal(shape, q);
    let per_area = 0.25 * INV_PI / ellipsoid_stretch(light, n);
    let unit = normalize(n);
    return LightSample(p, unit, pdf_of_area(per_area, eye, p, unit), shape);
}

/// A point of some light, as seen from `eye`.
fn light_sample(eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    var v = u;
    var choice = u.x;
    let light = light_choose(&choice);
    v.x = choice;
    var s: LightSample;
    switch lights[light].kind.x {
        case LIGHT_SPHERE: {
            s = sphere_sample(light, eye, v);
        }
        case LIGHT_ELLIPSOID: {
            s = ellipsoid_sample(light, eye, v);
        }
        default: {
            s = flat_sample(light, eye, v);
        }
    }
    s.pdf *= lights[light].edge_u.w;
    return s;
}

/// The pdf with which `light_sample` from `eye` draws the surface `s`; 0 if it is no light.
fn light_pdf(s: Surface, eye: vec3<f32>) -> f32 {
    let index = shapes[s.shape].index;
    if index.y == NONE {
        return 0.0;
    }
    let light = index.y + s.primitive;
    let chance = lights[light].edge_u.w;
    switch lights[light].kind.x {
        case LIGHT_SPHERE: {
            let d = lights[light].origin.xyz - eye;
            let radius = lights[light].edge_u.x;
            let sin2_max = radius * radius / dot(d, d);
            if sin2_max >= 1.0 {
                return chance * 0.25 * INV_PI;
            }
            return chance * 0.5 * INV_PI / cone_height(sin2_max);
        }
        case LIGHT_ELLIPSOID: {
            let q = normalize(object_point(s.shape, s.p));
            let n = world_normal(s.shape, q);
            return chance * pdf_of_area(0.25 * INV_PI / ellipsoid_stretch(light, n), eye, s.p, normalize(n));
        }
        default: {
            return chance * pdf_of_area(lights[light].normal.w, eye, s.p, s.ng);
        }
    }
}

/// Radiance that shape `shape` sends in a direction whose cosine with its outward normal is `c`.
fn light_eval(shape: u32, c: f32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var m = shapes[shape].index.z; m != NONE; m = materials[m].kind.w) {
        let kind = materials[m].kind;
        if c <= 0.0 && (kind.y & EMITTER_TWO_SIDED) == 0u {
            continue;
        }
        var radiance = materials[m].color.xyz;
        if kind.z != NONE {
            let coat = materials[kind.z].lobe;
            radiance *= 1.0 - coat_albedo(coat.x, coat.z, coat.y, abs(c));
        }
        sum += radiance;
    }
    return sum;
}

/// The share of rays that a light's surface meets.
fn light_cover(shape: u32) -> f32 {
    return materials[shapes[shape].index.x].more.w;
}
