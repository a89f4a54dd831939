// Tables of what a rough surface sends back from light that comes from one direction, without what is scattered more
// than once (renderer/kernel/src/albedo.rs makes them). Nodes lie at equal steps of √cos, roughness, sin² of the angle
// about the normal, anisotropy, and (η − 1) / (η + 1).

const METAL_COSINES: u32 = 32u;
const METAL_ROUGHNESSES: u32 = 32u;
const STRETCHED_COSINES: u32 = 16u;
const STRETCHED_TURNS: u32 = 8u;
const STRETCHED_ROUGHNESSES: u32 = 16u;
const STRETCHED_ANISOTROPIES: u32 = 12u;
const BOUNDARY_COSINES: u32 = 16u;
const BOUNDARY_ROUGHNESSES: u32 = 16u;
const BOUNDARY_INDICES: u32 = 33u;
/// The largest (η − 1) / (η + 1) of the table, an index of 9.
const BOUNDARY_REACH: f32 = 0.8;
const TABLE_STRETCHED: u32 = TABLE_ALBEDO + METAL_COSINES * METAL_ROUGHNESSES;
const TABLE_BOUNDARY: u32 =
    TABLE_STRETCHED + STRETCHED_COSINES * STRETCHED_TURNS * STRETCHED_ROUGHNESSES * STRETCHED_ANISOTROPIES;
const TABLE_END: u32 = TABLE_BOUNDARY + 2u * BOUNDARY_COSINES * BOUNDARY_ROUGHNESSES * BOUNDARY_INDICES;

/// Where x lies among nodes: the one before it, and how far behind that.
struct Cell {
    i: u32,
    f: f32,
}

// x of 0..1 among `nodes` at equal steps.
fn cell_of(x: f32, nodes: u32) -> Cell {
    let at = clamp(x, 0.0, 1.0) * f32(nodes - 1u);
    let i = min(u32(at), nodes - 2u);
    return Cell(i, at - f32(i));
}

fn table_line(at: u32, c: Cell, step: u32) -> f32 {
    return mix(tables[at + c.i * step], tables[at + (c.i + 1u) * step], c.f);
}

/// Albedo of a metal that would reflect everything, at cosine mu.
fn metal_albedo(mu: f32, roughness: f32) -> f32 {
    let c = cell_of(sqrt(mu), METAL_COSINES);
    let r = cell_of(roughness, METAL_ROUGHNESSES);
    let at = TABLE_ALBEDO + r.i * METAL_COSINES;
    return mix(table_line(at, c, 1u), table_line(at + METAL_COSINES, c, 1u), r.f);
}

fn stretched_plane(at: u32, c: Cell, t: Cell) -> f32 {
    let line = at + t.i * STRETCHED_COSINES;
    return mix(table_line(line, c, 1u), table_line(line + STRETCHED_COSINES, c, 1u), t.f);
}

/// The same, of a metal whose facets are stretched along x.
fn stretched_albedo(w: vec3<f32>, roughness: f32, anisotropy: f32) -> f32 {
    let across = dot(w.xy, w.xy);
    let turn = select(0.0, w.y * w.y / across, across > 0.0);
    let c = cell_of(sqrt(abs(w.z)), STRETCHED_COSINES);
    let t = cell_of(turn, STRETCHED_TURNS);
    let r = cell_of(roughness, STRETCHED_ROUGHNESSES);
    let a = cell_of(anisotropy, STRETCHED_ANISOTROPIES);
    let plane = STRETCHED_COSINES * STRETCHED_TURNS;
    let at = TABLE_STRETCHED + (a.i * STRETCHED_ROUGHNESSES + r.i) * plane;
    let next = at + STRETCHED_ROUGHNESSES * plane;
    return mix(
        mix(stretched_plane(at, c, t), stretched_plane(at + plane, c, t), r.f),
        mix(stretched_plane(next, c, t), stretched_plane(next + plane, c, t), r.f),
        a.f,
    );
}

// `what`: 0 for what is reflected, 1 for that and what is refracted.
fn boundary_albedo(mu: f32, roughness: f32, eta: f32, what: u32) -> f32 {
    let c = cell_of(sqrt(mu), BOUNDARY_COSINES);
    let r = cell_of(roughness, BOUNDARY_ROUGHNESSES);
    let x = cell_of(0.5 + 0.5 / BOUNDARY_REACH * (eta - 1.0) / (eta + 1.0), BOUNDARY_INDICES);
    let line = 2u * BOUNDARY_COSINES;
    let at = TABLE_BOUNDARY + what + (x.i * BOUNDARY_ROUGHNESSES + r.i) * line;
    let next = at + BOUNDARY_ROUGHNESSES * line;
    return mix(
        mix(table_line(at, c, 2u), table_line(at + line, c, 2u), r.f),
        mix(table_line(next, c, 2u), table_line(next + line, c, 2u), r.f),
        x.f,
    );
}

/// What a coat of this α, roughness and index reflects of light at cosine mu.
fn coat_albedo(alpha: f32, roughness: f32, ior: f32, mu: f32) -> f32 {
    if alpha < MIRROR_ALPHA {
        return dielectric_fresnel(mu, ior);
    }
    return boundary_albedo(mu, roughness, ior, 0u);
}

/// What a rough boundary sends back or through.
fn boundary_total(mu: f32, roughness: f32, eta: f32) -> f32 {
    return boundary_albedo(mu, roughness, eta, 1u);
}
