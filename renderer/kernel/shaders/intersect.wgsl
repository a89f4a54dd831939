// Rays against primitives. The BVH walks call these on both backends, so a hit is decided once.

struct Hit {
    /// Distance along the ray; FAR where nothing was hit.
    t: f32,
    /// Primitive, or PLANE_BIT | shape, or NONE.
    id: u32,
    /// Of a flat primitive: how far along the edges from the first corner to the second and to the last. Of a cylinder or
    /// a cone: which part, PART_….
    uv: vec2<f32>,
    /// Shape of the instance that the primitive was met in, or NONE.
    instance: u32,
}

fn no_hit() -> Hit {
    return Hit(FAR, NONE, vec2<f32>(0.0), NONE);
}

/// A ray with two axes across it.
struct Probe {
    o: vec3<f32>,
    /// Of unit length.
    d: vec3<f32>,
    x: vec3<f32>,
    y: vec3<f32>,
}

fn probe_along(o: vec3<f32>, d: vec3<f32>) -> Probe {
    let frame = frame_about(d);
    return Probe(o, d, frame.x, frame.y);
}

// x as it is. A GPU's compiler may fuse a product with the sum that it goes into, and then a · b − b · a is not 0: it does
// not know that the word is 0, and leaves the product alone. WGSL has no other word for it.
fn rounded(x: vec4<f32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bitcast<vec4<u32>>(x) | vec4<u32>(params.textures.w));
}

// Watertight as Woop, Benthin and Wald's ("Watertight Ray/Triangle Intersection", JCGT 2(1), 2013): a corner's place as
// seen along the ray depends on the corner alone, an edge's sign on its two corners alone, and both belong to all the
// primitives around them. An edge through the ray counts as hit.
fn hit_flat(id: u32, ray: Probe, t_max: f32) -> Hit {
    let x = primitives[id].x - vec4<f32>(ray.o.x);
    let y = primitives[id].y - vec4<f32>(ray.o.y);
    let z = primitives[id].z - vec4<f32>(ray.o.z);
    let px = x * ray.x.x + y * ray.x.y + z * ray.x.z;
    let py = x * ray.y.x + y * ray.y.y + z * ray.y.z;
    // Lane i: the edge from corner i to corner i + 1.
    let w = rounded(px * py.yzwx) - rounded(py * px.yzwx);
    let low = min(min(w.x, w.y), min(w.z, w.w));
    let high = max(max(w.x, w.y), max(w.z, w.w));
    if low < 0.0 && high > 0.0 {
        return no_hit();
    }
    let along = x * ray.d.x + y * ray.d.y + z * ray.d.z;
    var uv = vec2<f32>(w.z, w.x);
    var last = along.z;
    // Opposite edges of a parallelogram share its width between them, all edges of a triangle its area.
    var whole = vec2<f32>(w.x + w.y + w.z);
    if (primitives[id].shade.w & PRIMITIVE_KIND) == PRIMITIVE_PARALLELOGRAM {
        uv = vec2<f32>(w.w, w.x);
        last = along.w;
        whole = vec2<f32>(w.w + w.y, w.x + w.z);
    }
    if whole.x == 0.0 || whole.y == 0.0 {
        return no_hit();
    }
    uv /= whole;
    let t = along.x + uv.x * (along.y - along.x) + uv.y * (last - along.x);
    if !(t > 0.0 && t < t_max) {
        return no_hit();
    }
    return Hit(t, id, uv, NONE);
}

// The robust quadratic of Haines et al., Ray Tracing Gems ch. 7, on the unit sphere of the shape's own space, whose rays
// are not of unit length. A ray that starts on the sphere meets it once more if it goes inside, else never.
fn hit_sphere(id: u32, ray: Probe, t_max: f32, starts_on: bool) -> Hit {
    let shape = primitives[id].shade.w & ~PRIMITIVE_KIND;
    let f = object_point(shape, ray.o);
    let v = object_vector(shape, ray.d);
    let a = dot(v, v);
    let b = -dot(f, v);
    let nearest = f + (b / a) * v;
    let discriminant = 1.0 - dot(nearest, nearest);
    if discriminant < 0.0 {
        return no_hit();
    }
    let root = sqrt(a * discriminant);
    let q = b + select(root, -root, b < 0.0);
    let c = dot(f, f) - 1.0;
    var near = c / q;
    var far = q / a;
    if near > far {
        let swap = near;
        near = far;
        far = swap;
    }
    let t = select(far, near, near > 0.0 && !starts_on);
    if !(t > 0.0 && t < t_max) || (starts_on && b <= 0.0) {
        return no_hit();
    }
    return Hit(t, id, vec2<f32>(0.0), NONE);
}

/// Primitive `id` of the BVH against a ray, in 0 < t < t_max. `start` is the primitive on which the ray starts, or NONE:
/// what is flat cannot be met again, however the hit would be rounded.
fn hit_primitive(id: u32, ray: Probe, t_max: f32, start: u32) -> Hit {
    if (primitives[id].shade.w & PRIMITIVE_KIND) == PRIMITIVE_SPHERE {
        return hit_sphere(id, ray, t_max, id == start);
    }
    if (params.features & FEATURE_OTHER) != 0u && (primitives[id].shade.w & PRIMITIVE_KIND) == PRIMITIVE_OTHER {
        let hit = hit_other(id, ray.o, ray.d, id == start);
        if hit.t < t_max {
            return hit;
        }
        return no_hit();
    }
    if id == start {
        return no_hit();
    }
    return hit_flat(id, ray, t_max);
}

/// The primitive that a ray starts on which leaves from this hit. An instance's primitives are in many places: there, the
/// step off the surface must do.
fn start_of(hit: Hit) -> u32 {
    return select(NONE, hit.id, hit.instance == NONE);
}

/// Whether primitive `id` is a copy of a part.
fn is_instance(id: u32) -> bool {
    return (params.features & FEATURE_INSTANCE) != 0u && (primitives[id].shade.w & PRIMITIVE_KIND) == PRIMITIVE_OTHER
        && primitives[id].index.z == OTHER_INSTANCE;
}

// Plane `shape`: z = 0 in its own space.
fn hit_plane(shape: u32, o: vec3<f32>, d: vec3<f32>, t_max: f32) -> f32 {
    let height = dot(shapes[shape].object_from_world_z, vec4<f32>(o, 1.0));
    let fall = dot(shapes[shape].object_from_world_z.xyz, d);
    if fall == 0.0 {
        return FAR;
    }
    let t = -height / fall;
    return select(FAR, t, t > 0.0 && t < t_max);
}

/// The nearest hit of the ray from `o` on primitive `start` (or NONE) along `d`, a unit vector.
fn closest_hit(o: vec3<f32>, d: vec3<f32>, start: u32) -> Hit {
    var hit = bvh_closest(o, d, FAR, start);
    for (var shape = 0u; shape < params.plane_count; shape++) {
        let t = hit_plane(shape, o, d, hit.t);
        if t < hit.t && (PLANE_BIT | shape) != start {
            hit = Hit(t, PLANE_BIT | shape, vec2<f32>(0.0), NONE);
        }
    }
    return hit;
}

/// Whether anything lies in 0 < t < t_max of the ray from `o` on primitive `start` (or NONE) along `d`, a unit vector.
fn any_hit(o: vec3<f32>, d: vec3<f32>, t_max: f32, start: u32) -> bool {
    for (var shape = 0u; shape < params.plane_count; shape++) {
        if hit_plane(shape, o, d, t_max) < t_max && (PLANE_BIT | shape) != start {
            return true;
        }
    }
    return bvh_any(o, d, t_max, start);
}
