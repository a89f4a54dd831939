// The two ray queries, the only functions with a twin: on the CPU, src/query/ walks the same tree in lanes. Here: an
// eight-wide compressed BVH (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
// Wide BVHs", HPG 2017) whose nodes, as src/query/compressed.rs makes them, are 80 bytes: five vec4<u32>.

/// Deeper trees are refused when the scene is packed.
const BVH_STACK: u32 = 32u;
const NODE_VECTORS: u32 = 5u;

// Not a local of the walk: WGSL would set it to zero for every ray.
var<private> bvh_stack: array<vec2<u32>, BVH_STACK>;

struct NodeRay {
    o: vec3<f32>,
    inv_d: vec3<f32>,
    negative: vec3<bool>,
    octant: u32,
}

fn node_ray(o: vec3<f32>, d: vec3<f32>) -> NodeRay {
    let tiny = abs(d) < vec3<f32>(1e-20);
    let safe = select(d, select(vec3<f32>(1e-20), vec3<f32>(-1e-20), d < vec3<f32>(0.0)), tiny);
    let negative = d < vec3<f32>(0.0);
    let octant = select(0x04040404u, 0u, negative.x) | select(0x02020202u, 0u, negative.y)
        | select(0x01010101u, 0u, negative.z);
    return NodeRay(o, vec3<f32>(1.0) / safe, negative, octant);
}

fn byte_of(word: u32, i: u32) -> u32 {
    return (word >> (8u * i)) & 0xffu;
}

fn bytes_of(word: u32) -> vec4<f32> {
    return vec4<f32>((vec4<u32>(word) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(0xffu));
}

// Four children at once: the mask of those hit, in the bit order of the traversal.
fn node_hits(ray: NodeRay, scale: vec3<f32>, offset: vec3<f32>, t_max: f32, meta_word: u32, lower_x: u32, upper_x: u32,
    lower_y: u32, upper_y: u32, lower_z: u32, upper_z: u32) -> u32 {
    let near_x = bytes_of(select(lower_x, upper_x, ray.negative.x)) * scale.x + offset.x;
    let far_x = bytes_of(select(upper_x, lower_x, ray.negative.x)) * scale.x + offset.x;
    let near_y = bytes_of(select(lower_y, upper_y, ray.negative.y)) * scale.y + offset.y;
    let far_y = bytes_of(select(upper_y, lower_y, ray.negative.y)) * scale.y + offset.y;
    let near_z = bytes_of(select(lower_z, upper_z, ray.negative.z)) * scale.z + offset.z;
    let far_z = bytes_of(select(upper_z, lower_z, ray.negative.z)) * scale.z + offset.z;
    let near = max(max(near_x, near_y), max(near_z, vec4<f32>(0.0)));
    let far = min(min(far_x, far_y), min(far_z, vec4<f32>(t_max)));
    let hit = near <= far;

    let inner = ((meta_word & (meta_word << 1u)) & 0x10101010u) >> 4u;
    let slots = (meta_word ^ (ray.octant & (inner * 0xffu))) & 0x1f1f1f1fu;
    let bits = (meta_word >> 5u) & 0x07070707u;
    return select(0u, byte_of(bits, 0u) << byte_of(slots, 0u), hit.x)
        | select(0u, byte_of(bits, 1u) << byte_of(slots, 1u), hit.y)
        | select(0u, byte_of(bits, 2u) << byte_of(slots, 2u), hit.z)
        | select(0u, byte_of(bits, 3u) << byte_of(slots, 3u), hit.w);
}

// Bits 24..32: children to visit, nearest first from the top; bits 0..24: primitives.
fn node_children(node: u32, ray: NodeRay, t_max: f32) -> u32 {
    let a = nodes[node * NODE_VECTORS];
    let b = nodes[node * NODE_VECTORS + 1u];
    let x = nodes[node * NODE_VECTORS + 2u];
    let y = nodes[node * NODE_VECTORS + 3u];
    let z = nodes[node * NODE_VECTORS + 4u];
    let extent = bitcast<vec3<f32>>(vec3<u32>(byte_of(a.w, 0u), byte_of(a.w, 1u), byte_of(a.w, 2u)) << vec3<u32>(23u));
    let scale = extent * ray.inv_d;
    let offset = (bitcast<vec3<f32>>(a.xyz) - ray.o) * ray.inv_d;
    return node_hits(ray, scale, offset, t_max, b.z, x.x, x.z, y.x, y.z, z.x, z.z)
        | node_hits(ray, scale, offset, t_max, b.w, x.y, x.w, y.y, y.w, z.y, z.w);
}

// Both queries: the first hit found if `any`, else the nearest.
fn bvh_walk(o: vec3<f32>, d: vec3<f32>, t_max: f32, start: u32, any: bool) -> Hit {
    var best = no_hit();
    best.t = t_max;
    if arrayLength(&nodes) < NODE_VECTORS || params.primitive_count == 0u {
        best.t = FAR;
        return best;
    }
    var ray = node_ray(o, d);
    var probe = probe_along(o, d);
    var depth = 0u;
    // The instance inside which the walk is, where the stack was as it went in, and how long a metre is in there.
    var inside = NONE;
    var way_out = 0u;
    var scale = 1.0;
    // How far it looks, in that space.
    var far = t_max;
    // A group: index of its first member, and a mask of members to visit.
    var group = vec2<u32>(0u, 0x80000000u);
    loop {
        var leaves = vec2<u32>(0u);
        if (group.y & 0xff000000u) != 0u {
            let slot = firstLeadingBit(group.y);
            let others = group.y & ~(1u << slot);
            if (others & 0xff000000u) != 0u && depth < BVH_STACK {
                bvh_stack[depth] = vec2<u32>(group.x, others);
                depth++;
            }
            let child = (slot - 24u) ^ (ray.octant & 0xffu);
            let node = group.x + countOneBits(group.y & ~(0xffffffffu << child));
            let mask = node_children(node, ray, far);
            let base = nodes[node * NODE_VECTORS + 1u].xy;
            group = vec2<u32>(base.x, (mask & 0xff000000u) | (nodes[node * NODE_VECTORS].w >> 24u));
            leaves = vec2<u32>(base.y, mask & 0x00ffffffu);
        } else {
            // Primitives that were left when the walk went into an instance.
            leaves = group;
            group.y = 0u;
        }
        while leaves.y != 0u {
            let i = firstLeadingBit(leaves.y);
            leaves.y &= ~(1u << i);
            let id = leaves.x + i;
            if inside == NONE && is_instance(id) {
                if depth + 2u > BVH_STACK {
                    continue;
                }
                if leaves.y != 0u {
                    bvh_stack[depth] = leaves;
                    depth++;
                }
                if (group.y & 0xff000000u) != 0u {
                    bvh_stack[depth] = group;
                    depth++;
                }
                inside = primitives[id].shade.w & ~PRIMITIVE_KIND;
                way_out = depth;
                let v = object_vector(inside, d);
                scale = length(v);
                let from_there = object_point(inside, o);
                ray = node_ray(from_there, v / scale);
                probe = probe_along(from_there, v / scale);
                // A little farther than the best so far, so that rounding decides nothing.
                far = min(best.t * scale * 1.000001, FAR);
                group = vec2<u32>(primitives[id].index.y, 0x80000000u);
                break;
            }
            let hit = hit_primitive(id, probe, far, select(NONE, start, inside == NONE));
            if hit.id != NONE && (inside == NONE || hit.t / scale < best.t) {
                best = hit;
                far = hit.t;
                if inside != NONE {
                    best.t = hit.t / scale;
                    best.instance = inside;
                }
                if any {
                    return best;
                }
            }
        }
        if (group.y & 0xff000000u) == 0u {
            if inside != NONE && depth == way_out {
                inside = NONE;
                ray = node_ray(o, d);
                probe = probe_along(o, d);
                far = best.t;
            }
            if depth == 0u {
                break;
            }
            depth--;
            group = bvh_stack[depth];
        }
    }
    if best.id == NONE {
        best.t = FAR;
    }
    return best;
}

/// The nearest primitive in 0 < t < t_max; planes are not in the BVH.
fn bvh_closest(o: vec3<f32>, d: vec3<f32>, t_max: f32, start: u32) -> Hit {
    return bvh_walk(o, d, t_max, start, false);
}

/// Whether a primitive lies in 0 < t < t_max.
fn bvh_any(o: vec3<f32>, d: vec3<f32>, t_max: f32, start: u32) -> bool {
    return bvh_walk(o, d, t_max, start, true).id != NONE;
}
