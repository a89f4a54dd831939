// What a pixel shows, apart from its light: the first surface that the camera's ray of a sample meets. It is the same ray
// as that of the sample's path, and passes the same cut-outs and hidden boundaries.

/// The depth where nothing is, in metres.
const NO_DEPTH: f32 = 1e10;

struct Features {
    /// Colour of the surface, an emitter's radiance added to it, at most 1; black where nothing is.
    albedo: vec3<f32>,
    /// 1 where something is, else 0.
    cover: f32,
    /// Shading normal in the world, on the side of the eye.
    normal: vec3<f32>,
    /// Metres from the eye along the camera's axis; of a panorama or a fisheye, along the ray.
    depth: f32,
    /// In the world, metres; where nothing is, the unit vector along which nothing was met.
    position: vec3<f32>,
    /// 1 + the node's place in the scene, 0 where nothing is.
    id: u32,
    /// The shape, the copy that it is seen in or NONE, and which primitive of the shape: of a mesh, the triangle.
    shape: u32,
    copied: u32,
    primitive: u32,
}

/// What the camera's ray of one sample of a pixel meets.
fn features(pixel: vec2<u32>, sample: u32) -> Features {
    var seen: Features;
    seen.depth = NO_DEPTH;
    var path = path_start(pixel, sample);
    while path.alive {
        let hit = closest_hit(path.o, path.d, path.start);
        if hit.id == NONE {
            seen.position = path.d;
            return seen;
        }
        let s = surface_at(hit, path.o, path.d);
        let material = shapes[s.shape].index.x;
        path.start = start_of(hit);
        if is_cut_out(&path, material, s) {
            go_through(&path, s);
            continue;
        }
        var v = vertex_at(s, path.d);
        let b = bsdf_on(material, s, &v, material_choice(&path, material).x);
        let crossing = boundary_at(b, path.media, v.front);
        if crossing.hidden {
            path.media = crossing.beyond;
            go_through(&path, s);
            continue;
        }
        var emitted = light_eval(s.shape, -dot(s.ng, path.d), -path.d);
        if (params.features & FEATURE_GLOW) != 0u {
            emitted += glow_met(s, -dot(s.ng, path.d));
        }
        seen.albedo = min(bsdf_colour(b) + emitted, vec3<f32>(1.0));
        seen.cover = 1.0;
        seen.normal = v.frame.z;
        let to_eye = params.camera_eye.xyz - s.p;
        seen.depth = dot(to_eye, params.camera_z.xyz);
        if (params.features & (FEATURE_PANORAMA | FEATURE_FISHEYE)) != 0u {
            seen.depth = length(to_eye);
        }
        seen.position = s.p;
        seen.shape = s.shape;
        seen.copied = hit.instance;
        seen.primitive = s.primitive;
        seen.id = shapes[select(hit.instance, s.shape, hit.instance == NONE)].index.w + 1u;
        return seen;
    }
    return seen;
}

/// Several samples of a pixel. Colours and normals are summed; depth, position, id and shape are those of the pixel's first
/// sample, so that they belong together.
struct FeatureSum {
    /// w: how many samples met something.
    albedo: vec4<f32>,
    /// w: depth.
    normal: vec4<f32>,
    /// w: id, a whole number.
    position: vec4<f32>,
    /// The high 24 bits of shape, copy and primitive, then their low 8 bits together: whole numbers that a float holds.
    shape: vec4<f32>,
}

/// `sum` and one sample more.
fn features_add(sum: FeatureSum, pixel: vec2<u32>, sample: u32) -> FeatureSum {
    let seen = features(pixel, sample);
    var next = sum;
    next.albedo += vec4<f32>(seen.albedo, seen.cover);
    next.normal += vec4<f32>(seen.normal, 0.0);
    if sample == 0u {
        next.normal.w = seen.depth;
        next.position = vec4<f32>(seen.position, f32(seen.id));
        let low = (seen.shape & 0xffu) << 16u | (seen.copied & 0xffu) << 8u | seen.primitive & 0xffu;
        next.shape = vec4<f32>(vec4<u32>(seen.shape >> 8u, seen.copied >> 8u, seen.primitive >> 8u, low));
    }
    return next;
}
