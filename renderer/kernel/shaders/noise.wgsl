// Functions of a point that look random and depend on nothing else: those of lang/scene/src/noise.rs, with the same
// hashes.

/// Farther than this there is only the last cell.
const NOISE_FARTHEST: f32 = 1e9;

// The scalar product with one of the twelve edge directions of a cube, four of them twice.
fn noise_gradient(hash: u32, d: vec3<f32>) -> f32 {
    let h = hash >> 28u;
    let u = select(d.y, d.x, h < 8u);
    let v = select(select(d.z, d.x, h == 12u || h == 14u), d.y, h < 4u);
    return select(-u, u, (h & 1u) == 0u) + select(-v, v, (h & 2u) == 0u);
}

/// Gradient noise, -1..1 (Perlin, "Improving Noise", 2002, with hashed gradients).
fn gradient_noise(point: vec3<f32>) -> f32 {
    let at = clamp(point, vec3<f32>(-NOISE_FARTHEST), vec3<f32>(NOISE_FARTHEST));
    let low = floor(at);
    let f = at - low;
    let g = f - vec3<f32>(1.0);
    let cell = vec3<u32>(bitcast<u32>(i32(low.x)), bitcast<u32>(i32(low.y)), bitcast<u32>(i32(low.z)));
    let fade = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let z0 = pcg(cell.z);
    let z1 = pcg(cell.z + 1u);
    let y00 = pcg(cell.y + z0);
    let y10 = pcg(cell.y + 1u + z0);
    let y01 = pcg(cell.y + z1);
    let y11 = pcg(cell.y + 1u + z1);
    let x = cell.x + 1u;
    let a = mix(
        noise_gradient(pcg(cell.x + y00), f),
        noise_gradient(pcg(x + y00), vec3<f32>(g.x, f.y, f.z)),
        fade.x,
    );
    let b = mix(
        noise_gradient(pcg(cell.x + y10), vec3<f32>(f.x, g.y, f.z)),
        noise_gradient(pcg(x + y10), vec3<f32>(g.x, g.y, f.z)),
        fade.x,
    );
    let c = mix(
        noise_gradient(pcg(cell.x + y01), vec3<f32>(f.x, f.y, g.z)),
        noise_gradient(pcg(x + y01), vec3<f32>(g.x, f.y, g.z)),
        fade.x,
    );
    let d = mix(
        noise_gradient(pcg(cell.x + y11), vec3<f32>(f.x, g.y, g.z)),
        noise_gradient(pcg(x + y11), g),
        fade.x,
    );
    return clamp(mix(mix(a, b, fade.y), mix(c, d, fade.y), fade.z), -1.0, 1.0);
}

/// Cellular noise over the first `axes` coordinates (Worley, "A Cellular Texture Basis Function", 1996): the distance to
/// the nearest point, at most 1, and its number.
fn cellular_noise(point: vec3<f32>, axes: u32) -> vec2<f32> {
    let at = clamp(point, vec3<f32>(-NOISE_FARTHEST), vec3<f32>(NOISE_FARTHEST));
    let low = floor(at);
    let f = at - low;
    let cell = vec3<u32>(bitcast<u32>(i32(low.x)), bitcast<u32>(i32(low.y)), bitcast<u32>(i32(low.z)));
    let reach_y = select(0, 1, axes > 1u);
    let reach_z = select(0, 1, axes > 2u);
    var nearest = FAR;
    var found = 0u;
    for (var k = -reach_z; k <= reach_z; k++) {
        let along_z = pcg(cell.z + bitcast<u32>(k));
        for (var j = -reach_y; j <= reach_y; j++) {
            let along_y = pcg(cell.y + bitcast<u32>(j) + along_z);
            for (var i = -1; i <= 1; i++) {
                let hash = pcg(cell.x + bitcast<u32>(i) + along_y);
                let second = pcg(hash);
                let third = pcg(second);
                let dx = f32(i) + unit_float(hash) - f.x;
                let dy = select(0.0, f32(j) + unit_float(second) - f.y, axes > 1u);
                let dz = select(0.0, f32(k) + unit_float(third) - f.z, axes > 2u);
                let distance_2 = dx * dx + dy * dy + dz * dz;
                if distance_2 < nearest {
                    nearest = distance_2;
                    found = third;
                }
            }
        }
    }
    return vec2<f32>(min(sqrt(nearest), 1.0), unit_float(pcg(found)));
}
