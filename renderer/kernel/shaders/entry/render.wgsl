// The GPU's schedule: a band of rows of the window, a few samples each, summed in the order of the samples.

struct Dispatch {
    /// Rows of the window.
    first_row: u32,
    end_row: u32,
    first_sample: u32,
    end_sample: u32,
    /// The row that `film` begins with.
    film_row: u32,
}

@group(1) @binding(0) var<uniform> dispatch: Dispatch;
/// A value or several a pixel, row by row from the top.
@group(1) @binding(1) var<storage, read_write> film: array<vec4<f32>>;

// Where an invocation works.
struct Place {
    pixel: vec2<u32>,
    /// Its place in `film`, in pixels.
    i: u32,
    outside: bool,
}

fn place_of(band: Dispatch, id: vec2<u32>) -> Place {
    let row = id.y + band.first_row;
    let pixel = params.window.xy + vec2<u32>(id.x, row);
    let outside = id.x >= params.window.z || row >= band.end_row;
    return Place(pixel, (row - band.film_row) * params.window.z + id.x, outside);
}

/// Sums of radiance and rays.
@compute @workgroup_size(8, 8)
fn render(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = place_of(dispatch, id.xy);
    if at.outside {
        return;
    }
    let i = at.i;
    var sum = film[i];
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum += radiance(at.pixel, sample);
    }
    film[i] = sum;
}

/// Three values a pixel, as `features_add` sums them.
@compute @workgroup_size(8, 8)
fn survey(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = place_of(dispatch, id.xy);
    if at.outside {
        return;
    }
    let i = 3u * at.i;
    var sum = FeatureSum(film[i], film[i + 1u], film[i + 2u]);
    for (var sample = dispatch.first_sample; sample < dispatch.end_sample; sample++) {
        sum = features_add(sum, at.pixel, sample);
    }
    film[i] = sum.albedo;
    film[i + 1u] = sum.normal;
    film[i + 2u] = sum.position;
}
