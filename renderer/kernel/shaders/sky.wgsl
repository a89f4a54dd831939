// The sky as a map of all directions, equirectangular and bilinear, sampled by cells: a row by a tree of sums over rows,
// then a column by a tree over the row. A cell holds what the interpolated map brings in the mean over it, so that no
// direction with light has none of the density; and trees of sums keep faint cells beside bright ones, which running sums
// in f32 would not. Cells are evenly filled by solid angle.

/// Where a direction lies in the map: from the left and from the top, 0..1.
fn sky_uv(d: vec3<f32>) -> vec2<f32> {
    let r = sqrt(d.x * d.x + d.z * d.z);
    // Turns from -z towards +x, and half turns from the nearer pole; by half angles, which are exact at the poles too.
    let ahead = INV_PI * atan_(d.x / max(r + abs(d.z), 1e-30));
    let turn = select(ahead, select(0.5, -0.5, d.x < 0.0) - ahead, d.z > 0.0);
    let polar = 2.0 * INV_PI * atan_(r / max(1.0 + abs(d.y), 1e-30));
    let u = 0.5 + turn + params.sky_turn;
    return vec2<f32>(u - floor(u), select(polar, 1.0 - polar, d.y < 0.0));
}

fn sky_texel(x: u32, y: u32) -> vec3<f32> {
    let at = params.sky_map.x + 3u * (y * params.sky_map.y + x);
    return vec3<f32>(word_float(at), word_float(at + 1u), word_float(at + 2u));
}

/// The map's light from the direction `d`.
fn sky_map(d: vec3<f32>) -> vec3<f32> {
    let width = params.sky_map.y;
    let height = params.sky_map.z;
    let uv = sky_uv(d);
    let s = uv.x * f32(width) + 0.5;
    let t = clamp(uv.y * f32(height) - 0.5, 0.0, f32(height - 1u));
    // One more than the left texel, so that it is not negative.
    let right = min(u32(s), width);
    let x0 = select(right - 1u, width - 1u, right == 0u);
    let x1 = select(right, 0u, right == width);
    let y0 = min(u32(t), height - 1u);
    let y1 = min(y0 + 1u, height - 1u);
    let along = s - f32(right);
    let top = mix(sky_texel(x0, y0), sky_texel(x1, y0), vec3<f32>(along));
    let bottom = mix(sky_texel(x0, y1), sky_texel(x1, y1), vec3<f32>(along));
    return mix(top, bottom, vec3<f32>(t - f32(y0)));
}

// 1 - cos of the angle from the nearer pole at both edges of a row of cells, the upper one first.
fn sky_row(row: u32) -> vec2<f32> {
    let rows = params.sky_cells.z;
    let from_top = 2u * row < rows;
    let near = select(rows - 1u - row, row, from_top);
    let quarter = 0.25 / f32(rows);
    let low = cos_sin_turn(quarter * f32(near)).y;
    let high = cos_sin_turn(quarter * f32(near + 1u)).y;
    let edges = 2.0 * vec2<f32>(low * low, high * high);
    return select(edges.yx, edges, from_top);
}

// Pdf a steradian within a cell, whose edges are those of its row.
fn sky_cell_pdf(column: u32, row: u32, edges: vec2<f32>) -> f32 {
    let columns = params.sky_cells.y;
    let rows = params.sky_cells.z;
    let first = params.sky_cells.x;
    let cell = word_float(first + 2u * rows + 2u * columns * row + columns + column);
    let solid_angle = TWO_PI / f32(columns) * abs(edges.y - edges.x);
    return cell / (word_float(first + 1u) * solid_angle);
}

/// The pdf a steradian with which `sky_sample` draws the direction `d`.
fn sky_pdf(d: vec3<f32>) -> f32 {
    let columns = params.sky_cells.y;
    let rows = params.sky_cells.z;
    let uv = sky_uv(d);
    let column = min(u32(uv.x * f32(columns)), columns - 1u);
    let row = min(u32(uv.y * f32(rows)), rows - 1u);
    return sky_cell_pdf(column, row, sky_row(row));
}

// Walks down a tree of sums with `count` leaves: which leaf; u becomes a fresh number in 0 <= u < 1.
fn sum_tree(first: u32, count: u32, u: ptr<function, f32>) -> u32 {
    var i = 1u;
    while i < count {
        let left = word_float(first + 2u * i);
        let share = left / (left + word_float(first + 2u * i + 1u));
        let is_left = *u < share;
        *u = clamp(select((*u - share) / (1.0 - share), *u / share, is_left), 0.0, 0.99999994);
        i = select(2u * i + 1u, 2u * i, is_left);
    }
    return i - count;
}

/// A direction of the sky; w: its pdf a steradian.
fn sky_sample(u: vec2<f32>) -> vec4<f32> {
    let first = params.sky_cells.x;
    let columns = params.sky_cells.y;
    let rows = params.sky_cells.z;
    var across = u.x;
    var down = u.y;
    let row = sum_tree(first, rows, &down);
    let column = sum_tree(first + 2u * rows + 2u * columns * row, columns, &across);
    let edges = sky_row(row);
    let h = mix(edges.x, edges.y, down);
    let turn = cos_sin_turn((f32(column) + across) / f32(columns) - 0.5 - params.sky_turn);
    let r = sqrt(max(0.0, h * (2.0 - h)));
    let y = select(h - 1.0, 1.0 - h, 2u * row < rows);
    return vec4<f32>(r * turn.y, y, -r * turn.x, sky_cell_pdf(column, row, edges));
}
