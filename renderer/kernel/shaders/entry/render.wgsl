// The GPU's schedule: a band of rows, a few samples each, summed in the order of the samples.

struct Dispatch {
    first_row: u32,
    end_row: u32,
    first_sample: u32,
    end_sample: u32,
}

@group(1) @binding(0) var<uniform> dispatch: Dispatch;
/// Sums of radiance and rays, one a pixel, row by row from the top.
@group(1) @binding(1) var<storage, read_write> film: array<vec4<f32>>;

@compute @workgroup_size(8, 8)
fn render(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = vec2<u32>(id.x, id.y + dispatch.first_row);
    if pixel.x >= params.resolution.x || pixel.y >= dispatch.end_row {
        return;
    }
    let i = pixel.y * params.resolution.x + pixel.x;
    var sum = film[i];
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum += radiance(pixel, sample);
    }
    film[i] = sum;
}
