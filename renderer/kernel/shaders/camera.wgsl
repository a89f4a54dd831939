// The camera: a perspective with a thin lens, or another projection without one.

struct Ray {
    o: vec3<f32>,
    /// Of unit length.
    d: vec3<f32>,
}

/// Any projection but the perspective.
const FEATURE_PROJECTIONS: u32 = FEATURE_ORTHOGRAPHIC | FEATURE_PANORAMA | FEATURE_FISHEYE;

// An offset from the pixel's centre in pixels, drawn from the filter through its inverse distribution function, so that
// every sample counts the same and touches its own pixel only.
fn filter_offset(u: f32) -> f32 {
    let x = u * f32(FILTER_CELLS);
    let cell = min(u32(x), FILTER_CELLS - 1u);
    return mix(tables[cell], tables[cell + 1u], x - f32(cell));
}

/// A point of the lens, whose radius is 1: the disc, or the regular polygon inscribed in it, evenly filled.
fn lens_point(u: vec2<f32>) -> vec2<f32> {
    if (params.features & FEATURE_BLADES) == 0u {
        return square_to_disc(u);
    }
    // One of the triangles about the middle, then a point between two corners, nearer to the middle by the root of chance.
    let x = u.x * params.camera_x.w;
    let blade = min(floor(x), params.camera_x.w - 1.0);
    let a = cos_sin_turn(params.camera_y.w + blade / params.camera_x.w);
    let b = cos_sin_turn(params.camera_y.w + (blade + 1.0) / params.camera_x.w);
    return sqrt(u.y) * mix(a, b, x - blade);
}

// The ray through a point of the image, whose half extents are 1, in the camera's space, where it is no perspective. It has
// no direction where there is no picture.
fn projected_ray(at: vec2<f32>) -> Ray {
    let plane = at * params.camera_film.xy;
    if (params.features & FEATURE_ORTHOGRAPHIC) != 0u {
        return Ray(vec3<f32>(plane.x, -plane.y, 0.0), vec3<f32>(0.0, 0.0, -1.0));
    }
    if (params.features & FEATURE_PANORAMA) != 0u {
        let longitude = cos_sin_turn(0.5 * plane.x);
        let latitude = cos_sin_turn(-0.25 * plane.y);
        return Ray(vec3<f32>(0.0), vec3<f32>(latitude.x * longitude.y, latitude.y, -latitude.x * longitude.x));
    }
    let radius = length(plane);
    if radius > 1.0 {
        return Ray(vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let angle = cos_sin_turn(radius * params.camera_z.w);
    let aside = angle.y / max(radius, 1e-30);
    return Ray(vec3<f32>(0.0), vec3<f32>(aside * plane.x, -aside * plane.y, -angle.x));
}

/// A ray of the sample `key` through the pixel; its direction is 0 where there is no picture.
fn camera_ray(pixel: vec2<u32>, key: SampleKey) -> Ray {
    let u_filter = random_2d(key, DIM_FILTER);
    let at = vec2<f32>(pixel) + vec2<f32>(0.5) + vec2<f32>(filter_offset(u_filter.x), filter_offset(u_filter.y));
    let frame = Frame(params.camera_x.xyz, params.camera_y.xyz, params.camera_z.xyz);
    if (params.features & FEATURE_PROJECTIONS) != 0u {
        let ray = projected_ray(2.0 * at / vec2<f32>(params.resolution) - vec2<f32>(1.0));
        let turned = from_local(frame, ray.d);
        let d = turned / max(length(turned), 0.5);
        return Ray(params.camera_eye.xyz + from_local(frame, ray.o), d);
    }
    let plane = (2.0 * at / vec2<f32>(params.resolution) - vec2<f32>(1.0)) * params.camera_film.xy;
    var d = vec3<f32>(plane.x, -plane.y, -1.0);
    var o = vec3<f32>(0.0);
    if params.camera_eye.w > 0.0 {
        o = vec3<f32>(params.camera_eye.w * lens_point(random_2d(key, DIM_LENS)), 0.0);
        d = params.camera_film.z * d - o;
    }
    return Ray(params.camera_eye.xyz + from_local(frame, o), normalize(from_local(frame, d)));
}
