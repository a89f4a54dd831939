// The surface at a hit.

struct Surface {
    p: vec3<f32>,
    /// Geometric normal, outwards.
    ng: vec3<f32>,
    /// Shading normal, on the side of `ng`.
    ns: vec3<f32>,
    /// Growing u: along the surface, not normalised.
    tangent: vec3<f32>,
    /// The largest coordinate that `p` was computed from: what its rounding errors are in proportion to.
    reach: f32,
    shape: u32,
    /// Index of the primitive in its shape.
    primitive: u32,
    /// Of textures; without them, 0.
    uv: vec2<f32>,
    /// 1 where growing v is to the left of growing u, seen from outside, else -1.
    side: f32,
    /// Of a triangle: where what its mesh's vertices have is among `words`, or 0.
    mesh: u32,
    /// Of a triangle: the shares of its second and third corner.
    at: vec2<f32>,
    /// Of an instance: its shape and 1, else 0.
    copy: u32,
}

/// Octahedral normal from two 16-bit signed fractions (Cigolle et al., JCGT 3(2), 2014).
fn decode_normal(packed: u32) -> vec3<f32> {
    let e = unpack2x16snorm(packed);
    var n = vec3<f32>(e, 1.0 - abs(e.x) - abs(e.y));
    let fold = max(-n.z, 0.0);
    n.x += select(fold, -fold, n.x >= 0.0);
    n.y += select(fold, -fold, n.y >= 0.0);
    return normalize(n);
}

fn surface_of_flat(hit: Hit) -> Surface {
    let x = primitives[hit.id].x;
    let y = primitives[hit.id].y;
    let z = primitives[hit.id].z;
    let shade = primitives[hit.id].shade;
    let triangle = (shade.w & PRIMITIVE_KIND) == PRIMITIVE_TRIANGLE;
    let a = vec3<f32>(x.x, y.x, z.x);
    let ab = vec3<f32>(x.y, y.y, z.y) - a;
    let ac = select(vec3<f32>(x.w, y.w, z.w), vec3<f32>(x.z, y.z, z.z), triangle) - a;
    let ng = normalize(cross(ab, ac));
    var ns = ng;
    if (shade.x | shade.y | shade.z) != 0u {
        let n = (1.0 - hit.uv.x - hit.uv.y) * decode_normal(shade.x) + hit.uv.x * decode_normal(shade.y)
            + hit.uv.y * decode_normal(shade.z);
        let length_2 = dot(n, n);
        if length_2 > 1e-8 {
            ns = n / sqrt(length_2);
            ns = select(ns, -ns, dot(ns, ng) < 0.0);
        }
    }
    let p = a + hit.uv.x * ab + hit.uv.y * ac;
    let far = max(max(abs(x), abs(y)), abs(z));
    let reach = max(max(far.x, far.y), max(far.z, far.w));
    let index = primitives[hit.id].index;
    let turned = !triangle && index.y != 0u;
    let tangent = select(ab, ac, turned);
    let side = select(1.0, -1.0, turned);
    let shape = shade.w & ~PRIMITIVE_KIND;
    let mesh = select(0u, index.y, triangle);
    var s = Surface(p, ng, ns, tangent, reach, shape, index.x, select(hit.uv, hit.uv.yx, turned), side, mesh, hit.uv, 0u);
    if has_textures() && mesh != 0u {
        place_on_mesh(&s, ab, ac);
    }
    return s;
}

// What the vertices of its mesh say about a point of a triangle with these edges.
fn place_on_mesh(s: ptr<function, Surface>, ab: vec3<f32>, ac: vec3<f32>) {
    let mesh = (*s).mesh;
    let at = (*s).at;
    let corners = mesh_corners(mesh, (*s).primitive);
    let uvs = words[mesh + MESH_UVS];
    if uvs == 0u {
        return;
    }
    (*s).uv = mesh_pair(uvs, corners, at);
    let tangents = words[mesh + MESH_TANGENTS];
    if tangents != 0u {
        let packed = vec3<u32>(words[tangents + corners.x], words[tangents + corners.y], words[tangents + corners.z]);
        // The lowest bit is the side.
        let same = ((packed.x ^ packed.y) | (packed.x ^ packed.z)) & 1u;
        if packed.x != 0u && packed.y != 0u && packed.z != 0u && same == 0u {
            (*s).tangent = (1.0 - at.x - at.y) * decode_normal(packed.x) + at.x * decode_normal(packed.y)
                + at.y * decode_normal(packed.z);
            (*s).side = select(1.0, -1.0, (packed.x & 1u) != 0u);
            return;
        }
    }
    let origin = word_pair(uvs + 2u * corners.x);
    let u = word_pair(uvs + 2u * corners.y) - origin;
    let v = word_pair(uvs + 2u * corners.z) - origin;
    let det = u.x * v.y - u.y * v.x;
    if det != 0.0 {
        (*s).side = select(1.0, -1.0, det < 0.0);
        (*s).tangent = (ab * v.y - ac * u.y) * (*s).side;
    }
}

// (u, v) of a point of the unit sphere.
fn sphere_uv(p: vec3<f32>) -> vec2<f32> {
    return vec2<f32>(0.5 + turn_of(p.z, p.x), 0.5 + 2.0 * turn_of(length(p.xz), p.y));
}

fn surface_of_sphere(hit: Hit, o: vec3<f32>, d: vec3<f32>) -> Surface {
    let shape = primitives[hit.id].shade.w & ~PRIMITIVE_KIND;
    let p = normalize(object_point(shape, o) + hit.t * object_vector(shape, d));
    let n = normalize(world_normal(shape, p));
    // Round the object's y axis.
    let tangent = vec3<f32>(p.z, 0.0, -p.x);
    let along_u = world_vector(shape, tangent);
    var uv = vec2<f32>(0.0);
    var side = 1.0;
    if has_textures() {
        uv = sphere_uv(p);
        side = handedness(shape, n, along_u, vec3<f32>(-p.x * p.y, 1.0 - p.y * p.y, -p.z * p.y));
    }
    return Surface(world_point(shape, p), n, n, along_u, shape_reach(shape, 1.0), shape, 0u, uv, side, 0u, uv, 0u);
}

fn surface_of_plane(hit: Hit, o: vec3<f32>, d: vec3<f32>) -> Surface {
    let shape = hit.id & ~PLANE_BIT;
    let p = object_point(shape, o + hit.t * d);
    let n = normalize(world_normal(shape, vec3<f32>(0.0, 0.0, 1.0)));
    let reach = shape_reach(shape, max(abs(p.x), abs(p.y)));
    let tangent = world_vector(shape, vec3<f32>(1.0, 0.0, 0.0));
    let side = handedness(shape, n, tangent, vec3<f32>(0.0, 1.0, 0.0));
    return Surface(world_point(shape, vec3<f32>(p.xy, 0.0)), n, n, tangent, reach, shape, 0u, p.xy, side, 0u, p.xy, 0u);
}

// 1, or -1 where the object's direction of growing v is to the right of growing u, seen from outside.
fn handedness(shape: u32, n: vec3<f32>, along_u: vec3<f32>, along_v: vec3<f32>) -> f32 {
    return select(1.0, -1.0, dot(cross(n, along_u), world_vector(shape, along_v)) < 0.0);
}

// The largest coordinate of a point within `r` of the origin of the shape's own space, about.
fn shape_reach(shape: u32, r: f32) -> f32 {
    let x = shapes[shape].world_from_object_x;
    let y = shapes[shape].world_from_object_y;
    let z = shapes[shape].world_from_object_z;
    let at = max(abs(x.w), max(abs(y.w), abs(z.w)));
    let size = max(dot(abs(x.xyz), vec3<f32>(1.0)), max(dot(abs(y.xyz), vec3<f32>(1.0)), dot(abs(z.xyz), vec3<f32>(1.0))));
    return at + r * size;
}

/// The surface where the ray from `o` along `d` was hit.
fn surface_at(hit: Hit, o: vec3<f32>, d: vec3<f32>) -> Surface {
    if (params.features & FEATURE_INSTANCE) == 0u {
        return surface_of_own(hit, o, d);
    }
    // In an instance it is found in its part's space and carried out.
    var own = hit;
    var from_there = o;
    var along = d;
    let shape = hit.instance;
    if shape != NONE {
        let v = object_vector(shape, d);
        let scale = length(v);
        own.t = hit.t * scale;
        from_there = object_point(shape, o);
        along = v / scale;
    }
    var s = surface_of_own(own, from_there, along);
    if shape != NONE {
        s.copy = shape + 1u;
        s.p = world_point(shape, s.p);
        s.ng = normalize(world_normal(shape, s.ng));
        s.ns = normalize(world_normal(shape, s.ns));
        s.tangent = world_vector(shape, s.tangent);
        // As far again, since nothing else keeps a ray from meeting the primitive that it starts on.
        s.reach = 4.0 * shape_reach(shape, s.reach);
        let x = shapes[shape].world_from_object_x.xyz;
        let y = shapes[shape].world_from_object_y.xyz;
        let z = shapes[shape].world_from_object_z.xyz;
        s.side *= select(1.0, -1.0, dot(cross(x, y), z) < 0.0);
    }
    return s;
}

fn surface_of_own(hit: Hit, o: vec3<f32>, d: vec3<f32>) -> Surface {
    if (hit.id & PLANE_BIT) != 0u {
        return surface_of_plane(hit, o, d);
    }
    if (primitives[hit.id].shade.w & PRIMITIVE_KIND) == PRIMITIVE_SPHERE {
        return surface_of_sphere(hit, o, d);
    }
    if (params.features & FEATURE_OTHER) != 0u && (primitives[hit.id].shade.w & PRIMITIVE_KIND) == PRIMITIVE_OTHER {
        return surface_of_other(hit, o, d);
    }
    return surface_of_flat(hit);
}

/// How far a point is moved off its surface, in parts of the largest coordinate that it was computed from: about 16
/// units in the last place. What is flat cannot be met again anyway; this is for its neighbours.
const OFFSET: f32 = 1e-6;

/// `p` moved off its surface to the side that `n` points to.
fn offset_point(s: Surface, n: vec3<f32>) -> vec3<f32> {
    return s.p + n * (OFFSET * s.reach);
}

/// Axes x, y, n of a right-handed frame about the unit vector n (Duff et al., JCGT 6(1), 2017).
struct Frame {
    x: vec3<f32>,
    y: vec3<f32>,
    z: vec3<f32>,
}

fn frame_about(n: vec3<f32>) -> Frame {
    let s = select(1.0, -1.0, n.z < 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return Frame(
        vec3<f32>(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3<f32>(b, s + n.y * n.y * a, -n.y),
        n,
    );
}

/// The frame about the unit vector n whose x is nearest to `tangent` turned about n by the angle with this cosine and sine.
fn frame_along(n: vec3<f32>, tangent: vec3<f32>, cos_sin: vec2<f32>) -> Frame {
    let across = cross(n, tangent);
    let length_2 = dot(across, across);
    if !(length_2 > 0.0) {
        return frame_about(n);
    }
    let y = across / sqrt(length_2);
    let x = cross(y, n);
    return Frame(cos_sin.x * x + cos_sin.y * y, cos_sin.x * y - cos_sin.y * x, n);
}

fn to_local(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(frame.x, v), dot(frame.y, v), dot(frame.z, v));
}

fn from_local(frame: Frame, v: vec3<f32>) -> vec3<f32> {
    return frame.x * v.x + frame.y * v.y + frame.z * v.z;
}
