// Lights. Emissive shapes are sampled by the solid angle that they fill: spheres by their cone (Shirley, Wang and
// Zimmerman 1996), rectangles (Ureña, Fajardo and King 2013) and triangles (Arvo 1995) where they are near; what is far
// away or seen from the side by its area. A few are chosen by power, many by a tree of them (Conty Estevez and Kulla,
// "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018), those from infinitely far away beside both.

struct LightSample {
    /// On the light; of a light that is infinitely far away, the unit vector to it.
    p: vec3<f32>,
    /// The light's outward normal there.
    n: vec3<f32>,
    /// A steradian, seen from the point that asked; includes the choice of the light, and is only that for a light that
    /// has no extent. 0 if the light cannot be sampled.
    pdf: f32,
    /// The light's shape.
    shape: u32,
    light: u32,
}

/// Of the lights `begin` to `end`, the one chosen by u, which is changed to a fresh number in 0 <= u < 1.
fn light_choose(begin: u32, end: u32, u: ptr<function, f32>) -> u32 {
    var first = begin;
    var last = end - 1u;
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
        return LightSample(centre + radius * n, n, 0.25 * INV_PI, shape, light);
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
    return LightSample(centre + radius * n, n, 0.5 * INV_PI / height, shape, light);
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
    return LightSample(p, normal.xyz, pdf_of_area(normal.w, eye, p, normal.xyz), lights[light].kind.y, light);
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
    return LightSample(p, lights[light].normal.xyz, 1.0 / r.solid_angle, lights[light].kind.y, light);
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
    return LightSample(eye + distance * d, n, 1.0 / s.solid_angle, lights[light].kind.y, light);
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
    return LightSample(p, unit, pdf_of_area(per_area, eye, p, unit), shape, light);
}

fn other_light_sample(light: u32, eye: vec3<f32>, u: vec2<f32>) -> LightSample {
    let kind = lights[light].kind;
    let drawn = other_sample(kind.z, lights[light].edge_u.y, lights[light].edge_v.xyz, u);
    let p = world_point(kind.y, drawn.at.p);
    let n = world_normal(kind.y, drawn.at.n);
    let unit = normalize(n);
    return LightSample(p, unit, pdf_of_area(drawn.pdf / ellipsoid_stretch(light, n), eye, p, unit), kind.y, light);
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

/// A light, and the chance with which it was chosen.
struct Choice {
    light: u32,
    chance: f32,
}

/// Bits of the last word of a child in the tree of lights: the child is a light, it shines to both sides; the rest is
/// the light, or the first word of the child's own children.
const TREE_LIGHT: u32 = 0x80000000u;
const TREE_TWO_SIDED: u32 = 0x40000000u;
/// Words of a child; two of them stand side by side.
const TREE_CHILD: u32 = 8u;
/// The lower half of a child's word of cosines where its normals go to all sides: -1 in it.
const TREE_ALL_SIDES: u32 = 0x8001u;
/// Levels of the tree: as many as there are bits in a light's way down.
const TREE_LEVELS: u32 = 32u;

// cos(max(0, a - b)) of angles in 0..π, by their (cos, sin).
fn cos_less(a: vec2<f32>, b: vec2<f32>) -> f32 {
    return select(a.x * b.x + a.y * b.y, 1.0, a.x > b.x);
}

fn sin_of(cosine: f32) -> f32 {
    return sqrt(max(0.0, 1.0 - cosine * cosine));
}

/// Two children of the tree: a measure of how much light each brings, and what each is.
struct Children {
    brings: vec2<f32>,
    which: vec2<u32>,
}

// What the cone of a child leaves of its light along the unit vector `d` from it, 0 where none is sent; `child`: its last
// four words; `ball`: cosine and sine of half the angle that it fills.
fn cone_share(child: vec4<u32>, d: vec3<f32>, ball: vec2<f32>) -> f32 {
    let cosines = unpack2x16snorm(child.z);
    let along = dot(decode_normal(child.y), d);
    let off_axis = clamp(select(along, abs(along), (child.w & TREE_TWO_SIDED) != 0u), -1.0, 1.0);
    var off_cone = vec2<f32>(1.0, 0.0);
    if off_axis < cosines.x {
        let sines = vec2<f32>(sin_of(off_axis), sin_of(cosines.x));
        off_cone = vec2<f32>(off_axis * cosines.x + sines.x * sines.y, sines.x * cosines.x - off_axis * sines.y);
    }
    let sent = cos_less(off_cone, ball);
    return select(max(sent, 1e-3), 0.0, sent <= cosines.y);
}

// Whether a child with these last four words sends light to some sides only.
fn has_cone(child: vec4<u32>) -> bool {
    return (child.z & 0xffffu) != TREE_ALL_SIDES;
}

// The children at word `at`, as they light `p` on a surface with the normal `n`, or on any one if that is 0. Child: centre
// of its ball, radius, W/sr, axis of its normals (octahedral), cosines of their spread and of how far from a normal light
// is sent (as `unpack2x16snorm`), what it is.
fn light_children(at: u32, p: vec3<f32>, n: vec3<f32>) -> Children {
    let ball_a = bitcast<vec4<f32>>(words_from(at));
    let rest_a = words_from(at + 4u);
    let ball_b = bitcast<vec4<f32>>(words_from(at + TREE_CHILD));
    let rest_b = words_from(at + TREE_CHILD + 4u);
    let from_a = p - ball_a.xyz;
    let from_b = p - ball_b.xyz;
    let distance_2 = vec2<f32>(dot(from_a, from_a), dot(from_b, from_b));
    let radius = vec2<f32>(ball_a.w, ball_b.w);
    let within = distance_2 <= radius * radius;
    // Roots and divisions are what costs here.
    let inverse_2 = 1.0 / max(distance_2, radius * radius);
    let inverse = sqrt(inverse_2);
    let sines = radius * inverse;
    // cos a + sin b, cut at 1, for cos max(0, a - b), where a is the angle of the normal with the ball's centre, and b half
    // the angle that the ball fills: two roots less, and 0 just where that is, when all of the ball is below the surface.
    let facing = clamp(sines - inverse * vec2<f32>(dot(n, from_a), dot(n, from_b)), vec2<f32>(0.0), vec2<f32>(1.0));
    let any_side = vec2<bool>(dot(n, n) <= 0.0) | within;
    var brings = vec2<f32>(bitcast<f32>(rest_a.x), bitcast<f32>(rest_b.x)) * inverse_2;
    brings *= select(facing, vec2<f32>(1.0), any_side);
    if has_cone(rest_a) && !within.x {
        brings.x *= cone_share(rest_a, inverse.x * from_a, vec2<f32>(sin_of(sines.x), sines.x));
    }
    if has_cone(rest_b) && !within.y {
        brings.y *= cone_share(rest_b, inverse.y * from_b, vec2<f32>(sin_of(sines.y), sines.y));
    }
    return Children(brings, vec2<u32>(rest_a.w, rest_b.w));
}

// The light that the tree chooses by u, as `light_choose` does.
fn light_tree_choose(p: vec3<f32>, n: vec3<f32>, u: ptr<function, f32>) -> Choice {
    var at = params.light_tree;
    var chance = 1.0;
    var v = *u;
    for (var level = 0u; level < TREE_LEVELS; level++) {
        let children = light_children(at, p, n);
        let sum = children.brings.x + children.brings.y;
        if !(sum > 0.0) {
            return Choice(0u, 0.0);
        }
        let share = children.brings.x / sum;
        let is_first = v < share;
        let part = select(1.0 - share, share, is_first);
        v = clamp(select(v - share, v, is_first) / part, 0.0, 0.99999994);
        chance *= part;
        let child = select(children.which.y, children.which.x, is_first);
        if (child & TREE_LIGHT) != 0u {
            *u = v;
            return Choice(child & ~(TREE_LIGHT | TREE_TWO_SIDED), chance);
        }
        at = child & ~TREE_TWO_SIDED;
    }
    return Choice(0u, 0.0);
}

// The chance with which the tree chooses `light`.
fn light_tree_chance(light: u32, p: vec3<f32>, n: vec3<f32>) -> f32 {
    var at = params.light_tree;
    var way = lights[light].kind.w;
    var chance = 1.0;
    for (var level = 0u; level < TREE_LEVELS; level++) {
        let children = light_children(at, p, n);
        let sum = children.brings.x + children.brings.y;
        if !(sum > 0.0) {
            return 0.0;
        }
        let is_first = (way & 1u) == 0u;
        let share = children.brings.x / sum;
        chance *= select(1.0 - share, share, is_first);
        let child = select(children.which.y, children.which.x, is_first);
        if (child & TREE_LIGHT) != 0u {
            return chance;
        }
        at = child & ~TREE_TWO_SIDED;
        way >>= 1u;
    }
    return 0.0;
}

// The chance with which `light_sample` chooses a light that is not infinitely far away.
fn light_chance(light: u32, p: vec3<f32>, n: vec3<f32>) -> f32 {
    var chance = lights[light].edge_u.w;
    if (params.features & FEATURE_LIGHT_TREE) != 0u {
        chance = light_tree_chance(light, p, n);
    }
    if (params.features & FEATURE_DISTANT) != 0u {
        chance *= 1.0 - params.distant_chance;
    }
    return chance;
}

// Which light, for a surface at `p` with the normal `n`.
fn light_pick(p: vec3<f32>, n: vec3<f32>, u: ptr<function, f32>) -> Choice {
    var group = 1.0;
    if (params.features & FEATURE_DISTANT) != 0u {
        if *u < params.distant_chance {
            *u = min(*u / params.distant_chance, 0.99999994);
            let end = params.light_count + params.distant_count;
            let light = light_choose(params.light_count, end, u);
            return Choice(light, params.distant_chance * lights[light].edge_u.w);
        }
        group = 1.0 - params.distant_chance;
        *u = clamp((*u - params.distant_chance) / group, 0.0, 0.99999994);
    }
    if (params.features & FEATURE_LIGHT_TREE) != 0u {
        let choice = light_tree_choose(p, n, u);
        return Choice(choice.light, choice.chance * group);
    }
    let light = light_choose(0u, params.light_count, u);
    return Choice(light, group * lights[light].edge_u.w);
}

// A direction to a sun's disc; one without a disc has a pdf of 1.
fn sun_sample(light: u32, u: vec2<f32>) -> LightSample {
    let height = lights[light].edge_v.x;
    let axis = lights[light].origin.xyz;
    if height <= 0.0 {
        return LightSample(axis, -axis, 1.0, 0u, light);
    }
    let drop = u.x * height;
    let r = sqrt(max(0.0, drop * (2.0 - drop)));
    let d = from_local(frame_about(axis), vec3<f32>(r * cos_sin_turn(u.y), 1.0 - drop));
    return LightSample(d, -d, 0.5 * INV_PI / height, 0u, light);
}

/// A point of some light, as seen from a surface at `eye` with the normal `n`; 0: from both sides of any surface.
fn light_sample(eye: vec3<f32>, n: vec3<f32>, u: vec2<f32>) -> LightSample {
    var v = u;
    var fresh = u.x;
    let choice = light_pick(eye, n, &fresh);
    v.x = fresh;
    let light = choice.light;
    var s: LightSample;
    if choice.chance <= 0.0 {
        return s;
    }
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
        case LIGHT_POINT, LIGHT_SPOT: {
            s = LightSample(lights[light].origin.xyz, vec3<f32>(0.0), 1.0, 0u, light);
        }
        case LIGHT_SUN: {
            s = sun_sample(light, v);
        }
        case LIGHT_SKY: {
            let sky = sky_sample(v);
            s = LightSample(sky.xyz, -sky.xyz, sky.w, 0u, light);
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
    s.pdf *= choice.chance;
    return s;
}

/// Whether nothing but light samples can find the light.
fn light_is_delta(light: u32) -> bool {
    let kind = lights[light].kind.x;
    return kind == LIGHT_POINT || kind == LIGHT_SPOT || (kind == LIGHT_SUN && lights[light].edge_v.x <= 0.0);
}

// What a cone leaves of light in the direction `d`: 1 within the half angle whose 1 - cos is `heights.y`, 0 beyond
// `heights.x`, smooth between (smoothstep over the cosine).
fn beam_share(d: vec3<f32>, axis: vec3<f32>, heights: vec2<f32>) -> f32 {
    // 1 - cos from the chord, without cancellation.
    let chord = d - axis;
    let height = 0.5 * dot(chord, chord);
    if height >= heights.x {
        return 0.0;
    }
    if height <= heights.y {
        return 1.0;
    }
    let t = (heights.x - height) / (heights.x - heights.y);
    return t * t * (3.0 - 2.0 * t);
}

/// Radiance that arrives from the sample `s` along -`d` over `distance` metres; of a light without an extent, irradiance
/// on a surface facing it.
fn light_emission(s: LightSample, d: vec3<f32>, distance: f32) -> vec3<f32> {
    if (params.features & (FEATURE_DISTANT | FEATURE_DELTA)) != 0u {
        let light = lights[s.light];
        if light.kind.x == LIGHT_SKY {
            return params.sky.xyz * sky_map(d);
        }
        if light.kind.x == LIGHT_SUN {
            return light.edge_u.xyz;
        }
        if light.kind.x == LIGHT_POINT {
            return light.edge_u.xyz / (distance * distance);
        }
        if light.kind.x == LIGHT_SPOT {
            let share = beam_share(-d, light.edge_v.xyz, vec2<f32>(light.edge_v.w, light.normal.x));
            return light.edge_u.xyz * (share / (distance * distance));
        }
    }
    let emitted = emitters_eval(u32(lights[s.light].edge_v.w), -dot(s.n, d), -d) * light_cover(s.shape);
    if (params.features & FEATURE_GLOW) != 0u {
        return emitted + glow_eval(light_surface(s), -dot(s.n, d));
    }
    return emitted;
}

// The surface at a sample, as far as textures must know it.
fn light_surface(s: LightSample) -> Surface {
    let light = lights[s.light];
    var at: Surface;
    at.p = s.p;
    at.ng = s.n;
    at.ns = s.n;
    at.shape = s.shape;
    at.primitive = s.light - shapes[s.shape].index.y;
    switch light.kind.x {
        case LIGHT_SPHERE, LIGHT_ELLIPSOID: {
            at.uv = sphere_uv(normalize(object_point(s.shape, s.p)));
        }
        case LIGHT_OTHER: {
            if (params.features & FEATURE_OTHER) != 0u {
                let q = object_point(s.shape, s.p);
                let part = other_part(light.kind.z, q);
                let size = light.edge_u.y;
                at.uv = other_uv(light.kind.z, size, other_point(light.kind.z, size, q, part).p, part);
            }
        }
        default: {
            // Its coordinates along the edges.
            let n = cross(light.edge_u.xyz, light.edge_v.xyz);
            let d = s.p - light.origin.xyz;
            let place = vec2<f32>(dot(cross(d, light.edge_v.xyz), n), dot(cross(light.edge_u.xyz, d), n)) / dot(n, n);
            at.at = place;
            at.uv = place;
            if light.kind.x != LIGHT_TRIANGLE {
                at.uv = select(place, place.yx, light.kind.z != 0u);
            } else if light.kind.z != 0u {
                at.mesh = light.kind.z;
                let uvs = words[at.mesh + MESH_UVS];
                if uvs != 0u {
                    at.uv = mesh_pair(uvs, mesh_corners(at.mesh, at.primitive), place);
                }
            }
        }
    }
    return at;
}

/// Radiance that `s` sends at the cosine `c` with its outward normal, from emitters whose light varies over the surface;
/// cut-outs count as black.
fn glow_eval(s: Surface, c: f32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var m = shapes[s.shape].index.z; m != NONE; m = materials[m].kind.w) {
        let kind = materials[m].kind;
        if (kind.y & EMITTER_GLOW) == 0u || (c <= 0.0 && (kind.y & EMITTER_TWO_SIDED) == 0u) {
            continue;
        }
        var radiance = materials[m].color.xyz;
        let list = maps_of(m, MAPS_LIST);
        if list != 0u {
            for (var i = 0u; i < words[list]; i++) {
                radiance *= max(texture_value(words[list + 2u + 2u * i], s).xyz, vec3<f32>(0.0));
            }
        }
        let share = maps_of(m, MAPS_OPACITY);
        if share != 0u {
            radiance *= terms_value(share, s);
        }
        if has_material(MATERIAL_GLOSSY) {
            var coat = kind.z;
            for (var i = 0u; i < MAX_DEPTH && coat != NONE; i++) {
                let lobe = material_on(coat, s).lobe;
                radiance *= 1.0 - coat_albedo(lobe.x, lobe.z, lobe.y, abs(c));
                coat = materials[coat].kind.w;
            }
        }
        sum += radiance;
    }
    return sum;
}

/// The same of a point that a ray met: what cut-outs let through did not get there.
fn glow_met(s: Surface, c: f32) -> vec3<f32> {
    let emitted = glow_eval(s, c);
    if (params.features & FEATURE_CUTOUT) == 0u {
        return emitted;
    }
    return emitted / max(opacity_on(shapes[s.shape].index.x, s), 1e-6);
}

/// The pdf with which `light_sample` from `eye`, `n` draws the surface `s`; 0 if it is no light.
fn light_pdf(s: Surface, eye: vec3<f32>, n: vec3<f32>) -> f32 {
    let index = shapes[s.shape].index;
    if index.y == NONE {
        return 0.0;
    }
    let light = index.y + s.primitive;
    let chance = light_chance(light, eye, n);
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
            let normal = world_normal(s.shape, q);
            let per_area = 0.25 * INV_PI / ellipsoid_stretch(light, normal);
            return chance * pdf_of_area(per_area, eye, s.p, normalize(normal));
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

/// Radiance, the same all over the surface, that shape `shape` sends in the direction `d`, whose cosine with its outward normal is `c`.
fn light_eval(shape: u32, c: f32, d: vec3<f32>) -> vec3<f32> {
    return emitters_eval(shapes[shape].index.z, c, d);
}

// The same of the shape whose first emitter is `first`.
fn emitters_eval(first: u32, c: f32, d: vec3<f32>) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    for (var m = first; m != NONE; m = materials[m].kind.w) {
        let kind = materials[m].kind;
        if c <= 0.0 && (kind.y & EMITTER_TWO_SIDED) == 0u {
            continue;
        }
        if (params.features & FEATURE_GLOW) != 0u && (kind.y & EMITTER_GLOW) != 0u {
            continue;
        }
        var radiance = materials[m].color.xyz;
        if has_material(MATERIAL_GLOSSY) {
            var coat = kind.z;
            for (var i = 0u; i < MAX_DEPTH && coat != NONE; i++) {
                let lobe = materials[coat].lobe;
                radiance *= 1.0 - coat_albedo(lobe.x, lobe.z, lobe.y, abs(c));
                coat = materials[coat].kind.w;
            }
        }
        if (params.features & FEATURE_BEAM) != 0u && (kind.y & EMITTER_BEAM) != 0u {
            radiance *= beam_share(d, materials[m].extra.xyz, materials[m].lobe.xy);
        }
        sum += radiance;
    }
    return sum;
}

/// The share of rays that a light's surface meets.
fn light_cover(shape: u32) -> f32 {
    if (params.features & FEATURE_CUTOUT) == 0u {
        return 1.0;
    }
    return materials[shapes[shape].index.x].more.w;
}

/// Light from infinitely far away along the direction `d`, to a path that sampled it with `pdf`: each light by its weight.
/// `beta`: the path's share; `lit`: as `bsdf_weight`.
fn distant_light(d: vec3<f32>, beta: vec3<f32>, pdf: f32, lit: bool) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    if (params.features & FEATURE_SKY_MAP) == 0u {
        sum = limited(beta) * params.sky.xyz;
    } else {
        let sky_light = params.sky_map.w;
        var other = 0.0;
        if sky_light != NONE {
            other = params.distant_chance * lights[sky_light].edge_u.w * sky_pdf(d);
        }
        sum = limited(beta * bsdf_weight(pdf, other, lit)) * params.sky.xyz * sky_map(d);
    }
    if (params.features & FEATURE_DISTANT) == 0u {
        return sum;
    }
    let end = params.light_count + params.distant_count;
    for (var light = params.light_count; light < end; light++) {
        let height = lights[light].edge_v.x;
        let chord = d - lights[light].origin.xyz;
        if lights[light].kind.x == LIGHT_SUN && height > 0.0 && dot(chord, chord) <= 2.0 * height {
            let other = params.distant_chance * lights[light].edge_u.w * 0.5 * INV_PI / height;
            sum += limited(beta * bsdf_weight(pdf, other, lit)) * lights[light].edge_u.xyz;
        }
    }
    return sum;
}
