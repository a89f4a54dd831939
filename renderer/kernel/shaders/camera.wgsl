// The camera: a perspective with a thin lens.

struct Ray {
    o: vec3<f32>,
    /// Of unit length.
    d: vec3<f32>,
}

// An offset from the pixel's centre in pixels, drawn from the filter through its inverse distribution function, so that
// every sample counts the same and touches its own pixel only.
fn filter_offset(u: f32) -> f32 {
    let x = u * f32(FILTER_CELLS);
    let cell = min(u32(x), FILTER_CELLS - 1u);
    return mix(tables[cell], tables[cell + 1u], x - f32(cell));
}

/// A ray of the sample `key` through the pixel.
fn camera_ray(pixel: vec2<u32>, key: SampleKey) -> Ray {
    let u_filter = random_2d(key, DIM_FILTER);
    let at = vec2<f32>(pixel) + vec2<f32>(0.5) + vec2<f32>(filter_offset(u_filter.x), filter_offset(u_filter.y));
    let plane = (2.0 * at / vec2<f32>(params.resolution) - vec2<f32>(1.0)) * params.camera_film.xy;
    var d = vec3<f32>(plane.x, -plane.y, -1.0);
    var o = vec3<f32>(0.0);
    if params.camera_eye.w > 0.0 {
        o = vec3<f32>(params.camera_eye.w * square_to_disc(random_2d(key, DIM_LENS)), 0.0);
        d = params.camera_film.z * d - o;
    }
    let frame = Frame(params.camera_x.xyz, params.camera_y.xyz, params.camera_z.xyz);
    return Ray(params.camera_eye.xyz + from_local(frame, o), normalize(from_local(frame, d)));
}
