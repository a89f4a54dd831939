// The GPU's schedule: a band of rows, a few samples each, summed in the order of the samples.

struct Dispatch {
    first_row: u32,
    end_row: u32,
    first_sample: u32,
    end_sample: u32,
    /// The row that the output begins with.
    output_row: u32,
    /// Threads of a device that gives each a block of consecutive workgroups; 1 for all others.
    threads: u32,
    padding_0: u32,
    padding_1: u32,
}

@group(1) @binding(0) var<uniform> dispatch: Dispatch;
/// Sums of radiance and rays, one a pixel, row by row from `output_row`.
@group(1) @binding(1) var<storage, read_write> film: array<vec4<f32>>;

// The pixel of an invocation. Where each thread gets a block of workgroups, neighbours in the picture go to different
// threads: parts of a picture that take long would keep one busy while the others wait.
fn dispatched_pixel(d: Dispatch, group: vec3<u32>, groups: vec3<u32>, local: vec3<u32>) -> vec2<u32> {
    let i = group.y * groups.x + group.x;
    let block = max(groups.x * groups.y / d.threads, 1u);
    let spread = select(i, (i % block) * d.threads + i / block, i < block * d.threads);
    return 8u * vec2<u32>(spread % groups.x, spread / groups.x) + local.xy + vec2<u32>(0u, d.first_row);
}

@compute @workgroup_size(8, 8)
fn render(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>) {
    let pixel = dispatched_pixel(dispatch, group, groups, local);
    if pixel.x >= params.resolution.x || pixel.y >= dispatch.end_row {
        return;
    }
    let i = (pixel.y - dispatch.output_row) * params.resolution.x + pixel.x;
    var sum = film[i];
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum += radiance(pixel, sample);
    }
    film[i] = sum;
}
