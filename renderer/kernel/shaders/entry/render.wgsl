// The GPU's schedule: a band of rows of the window, or of a list of pixels, a few samples each, summed in the order of the
// samples.

struct Dispatch {
    /// Rows of the window, or places in the list.
    first: u32,
    end: u32,
    first_sample: u32,
    end_sample: u32,
    /// The row that the output begins with.
    output_row: u32,
    /// Threads of a device that gives each a block of consecutive workgroups; 1 for all others.
    threads: u32,
    /// 0, or where in `film` the list of pixels begins: two in a vector.
    list: u32,
    padding: u32,
}

@group(1) @binding(0) var<uniform> dispatch: Dispatch;
/// A value or several a pixel, row by row from `output_row`, or as they are listed; then the list.
@group(1) @binding(1) var<storage, read_write> film: array<vec4<f32>>;

// Where an invocation works.
struct Place {
    pixel: vec2<u32>,
    /// Its place in `film`, in pixels; of a list, which says what `pixel` is, its place there.
    i: u32,
    outside: bool,
}

// Where each thread gets a block of workgroups, neighbours in the picture go to different threads: parts of a picture
// that take long would keep one busy while the others wait.
fn place_of(d: Dispatch, group: vec3<u32>, groups: vec3<u32>, local: vec3<u32>) -> Place {
    let i = group.y * groups.x + group.x;
    let block = max(groups.x * groups.y / d.threads, 1u);
    let spread = select(i, (i % block) * d.threads + i / block, i < block * d.threads);
    if d.list != 0u {
        let place = d.first + 64u * spread + 8u * local.y + local.x;
        return Place(vec2<u32>(0u), place, place >= d.end);
    }
    let at = 8u * vec2<u32>(spread % groups.x, spread / groups.x) + local.xy + vec2<u32>(0u, d.first);
    let outside = at.x >= params.window.z || at.y >= d.end;
    return Place(params.window.xy + at, (at.y - d.output_row) * params.window.z + at.x, outside);
}

// The pixel at place `i` of the list, of which `pair` is the vector at `i` / 2.
fn listed(pair: vec4<f32>, i: u32) -> vec2<u32> {
    return vec2<u32>(select(pair.xy, pair.zw, i % 2u == 1u));
}

/// Sums of radiance and rays.
@compute @workgroup_size(8, 8)
fn render(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>) {
    var at = place_of(dispatch, group, groups, local);
    if at.outside {
        return;
    }
    if dispatch.list != 0u {
        at.pixel = listed(film[dispatch.list + at.i / 2u], at.i);
    }
    let i = at.i;
    var sum = film[i];
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum += radiance(at.pixel, sample);
    }
    film[i] = sum;
}

/// The same in parts: five values a pixel, as `parts_sum` sums them.
@compute @workgroup_size(8, 8)
fn render_parts(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>) {
    var at = place_of(dispatch, group, groups, local);
    if at.outside {
        return;
    }
    if dispatch.list != 0u {
        at.pixel = listed(film[dispatch.list + at.i / 2u], at.i);
    }
    let i = 5u * at.i;
    var sum = PartsSum(film[i], film[i + 1u], film[i + 2u], film[i + 3u], film[i + 4u]);
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum = parts_sum(sum, radiance_parts(at.pixel, sample));
    }
    film[i] = sum.light;
    film[i + 1u] = sum.squares;
    film[i + 2u] = sum.emission;
    film[i + 3u] = sum.diffuse;
    film[i + 4u] = sum.specular;
}

/// Four values a pixel, as `features_add` sums them.
@compute @workgroup_size(8, 8)
fn survey(@builtin(workgroup_id) group: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>) {
    var at = place_of(dispatch, group, groups, local);
    if at.outside {
        return;
    }
    if dispatch.list != 0u {
        at.pixel = listed(film[dispatch.list + at.i / 2u], at.i);
    }
    let i = 4u * at.i;
    var sum = FeatureSum(film[i], film[i + 1u], film[i + 2u], film[i + 3u]);
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum = features_add(sum, at.pixel, sample);
    }
    film[i] = sum.albedo;
    film[i + 1u] = sum.normal;
    film[i + 2u] = sum.position;
    film[i + 3u] = sum.shape;
}
