// Lights: emissive shapes, chosen by power, sampled by the solid angle that they fill: spheres by their cone (Shirley,
// Wang and Zimmerman 1996), rectangles (Ureña, Fajardo and King 2013) and triangles (Arvo 1995) where they are near; what
// is far away or seen from the side by its area.

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

/// Solid angles below this cancel in f32; such lights are sampled by area, which is as good there.
const NEAR_SOLID_ANGLE: f32 = 0.01;
/// A triangle that fills almost the whole hemisphere is no longer one to f32.
const MAX_SOLID_ANGLE: f32 = 6.2;

/// A rectangle seen from a point: its solid angle, and what a point of it is found with.
struct SphericalRectangle {
    solid_angle: f32,
    k: f32,
    b0: f32,
    b1: f32,
    /// The rectangle in the frame of its edges, its plane at z0 < 0.
    low: vec2<f32>,
    high: vec2<f32>,
    z0: f32,
}

fn spherical_rectangle(light: u32, eye: vec3<f32>) -> SphericalRectangle {
    let width = length(lights[light].edge_u.xyz);
    let height = length(lights[light].edge_v.xyz);
    let d = lights[light].origin.xyz - eye;
    let low = vec2<f32>(dot(d, lights[light].edge_u.xyz) / width, dot(d, lights[light].edge_v.xyz) / height);
    let high = low + vec2<f32>(width, height);
    let z0 = -abs(dot(d, lights[light].normal.xyz));
    // Normals of the planes through the eye and an edge, from the lower edge on.
    let n0 = vec2<f32>(z0, -low.y) / length(vec2<f32>(z0, low.y));
    let n1 = vec2<f32>(-z0, high.x) / length(vec2<f32>(z0, high.x));
    let n2 = vec2<f32>(-z0, high.y) / length(vec2<f32>(z0, high.y));
    let n3 = vec2<f32>(z0, -low.x) / length(vec2<f32>(z0, low.x));
    let g0 = acos_(-n0.y * n1.y);
    let g1 = acos_(-n1.y * n2.y);
    let g2 = acos_(-n2.y * n3.y);
    let g3 = acos_(-n3.y * n0.y);
    let k = TWO_PI - g2 - g3;
    return SphericalRectangle(g0 + g1 - k, k, n0.y, n2.y, low, high, z0);
}

fn rectangle_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    let r = spherical_rectangle(light, eye);
    if !(r.solid_angle >= NEAR_SOLID_ANGLE) {
        return flat_sample(light, eye, u);
    }
    let turn = cos_sin(u.x * r.solid_angle + r.k);
    let f = (turn.x * r.b0 - r.b1) / turn.y;
    let c = clamp(select(1.0, -1.0, f < 0.0) / sqrt(f * f + r.b0 * r.b0), -0.9999999, 0.9999999);
    let x = clamp(-c * r.z0 / sqrt(1.0 - c * c), r.low.x, r.high.x);
    let d = sqrt(x * x + r.z0 * r.z0);
    let h0 = r.low.y / sqrt(d * d + r.low.y * r.low.y);
    let h1 = r.high.y / sqrt(d * d + r.high.y * r.high.y);
    let h = h0 + u.y * (h1 - h0);
    let y = clamp(select(r.high.y, h * d / sqrt(1.0 - h * h), h * h < 0.999999), r.low.y, r.high.y);
    let share = (vec2<f32>(x, y) - r.low) / (r.high - r.low);
    let p = lights[light].origin.xyz + share.x * lights[light].edge_u.xyz + share.y * lights[light].edge_v.xyz;
    return LightSample(p, lights[light].normal.xyz, 1.0 / r.solid_angle, lights[light].kind.y);
}

/// A triangle seen from a point: directions to its corners, and its solid angle.
struct SphericalTriangle {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    solid_angle: f32,
}

fn spherical_triangle(light: u32, eye: vec3<f32>) -> SphericalTriangle {
    let origin = lights[light].origin.xyz - eye;
    let a = normalize(origin);
    let b = normalize(origin + lights[light].edge_u.xyz);
    let c = normalize(origin + lights[light].edge_v.xyz);
    // Van Oosterom and Strackee 1983.
    let volume = abs(dot(a, cross(b, c)));
    let sum = 1.0 + dot(a, b) + dot(b, c) + dot(c, a);
    let half = atan_(volume / select(sum, 1e-20, abs(sum) < 1e-20));
    return SphericalTriangle(a, b, c, 2.0 * select(half, half + PI, half < 0.0));
}

fn is_near(solid_angle: f32) -> bool {
    return solid_angle >= NEAR_SOLID_ANGLE && solid_angle <= MAX_SOLID_ANGLE;
}

// The part of v across the unit vector n, of unit length.
fn across(v: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    return normalize(v - dot(v, n) * n);
}

fn triangle_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    let s = spherical_triangle(light, eye);
    if !is_near(s.solid_angle) {
        return flat_sample(light, eye, u);
    }
    // The angle at a, by its cosine and sine.
    let ab = across(s.b, s.a);
    let ac = across(s.c, s.a);
    let corner = vec2<f32>(dot(ab, ac), length(cross(ab, ac)));
    let area = cos_sin(u.x * s.solid_angle);
    let t = area.x * corner.x + area.y * corner.y;
    let r = area.y * corner.x - area.x * corner.y;
    let p = t - corner.x;
    let q = r + corner.y * dot(s.a, s.b);
    let cos_b = clamp(((q * t - p * r) * corner.x - q) / ((q * r + p * t) * corner.y), -1.0, 1.0);
    let c = cos_b * s.a + sqrt(max(0.0, 1.0 - cos_b * cos_b)) * ac;
    let z = 1.0 - u.y * (1.0 - dot(c, s.b));
    var d = s.b;
    if z < 0.9999999 {
        d = z * s.b + sqrt(max(0.0, 1.0 - z * z)) * across(c, s.b);
    }
    let n = lights[light].normal.xyz;
    let distance = dot(lights[light].origin.xyz - eye, n) / dot(d, n);
    return LightSample(eye + distance * d, n, 1.0 / s.solid_angle, lights[light].kind.y);
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

fn other_light_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    let kind = lights[light].kind;
    let drawn = other_sample(kind.z, lights[light].edge_u.y, lights[light].edge_v.xyz, u);
    let p = world_point(kind.y, drawn.at.p);
    let n = world_normal(kind.y, drawn.at.n);
    let unit = normalize(n);
    return LightSample(p, unit, pdf_of_area(drawn.pdf / ellipsoid_stretch(light, n), eye, p, unit), kind.y);
}

// The density of a place of such a light, a square metre of the world.
fn other_light_density(light: u32, p: vec3<f32>) -> f32 {
    let kind = lights[light].kind;
    let size = lights[light].edge_u.y;
    let q = object_point(kind.y, p);
    let part = other_part(kind.z, q);
    let at = other_point(kind.z, size, q, part);
    let density = other_density(kind.z, size, at.p, part, lights[light].edge_v.xyz);
    return density / ellipsoid_stretch(light, world_normal(kind.y, at.n));
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
        case LIGHT_RECTANGLE: {
            s = rectangle_sample(light, eye, v);
        }
        case LIGHT_TRIANGLE: {
            s = triangle_sample(light, eye, v);
        }
        case LIGHT_OTHER: {
            if (params.features & FEATURE_OTHER) != 0u {
                s = other_light_sample(light, eye, v);
            }
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
        case LIGHT_OTHER: {
            if (params.features & FEATURE_OTHER) == 0u {
                return 0.0;
            }
            return chance * pdf_of_area(other_light_density(light, s.p), eye, s.p, s.ng);
        }
        case LIGHT_RECTANGLE: {
            let solid_angle = spherical_rectangle(light, eye).solid_angle;
            if solid_angle >= NEAR_SOLID_ANGLE {
                return chance / solid_angle;
            }
            return chance * pdf_of_area(lights[light].normal.w, eye, s.p, s.ng);
        }
        case LIGHT_TRIANGLE: {
            let solid_angle = spherical_triangle(light, eye).solid_angle;
            if is_near(solid_angle) {
                return chance / solid_angle;
            }
            return chance * pdf_of_area(lights[light].normal.w, eye, s.p, s.ng);
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
        if has_material(MATERIAL_GLOSSY) && kind.z != NONE {
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
