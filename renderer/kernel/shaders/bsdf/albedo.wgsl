// Tables of what a rough surface sends back from light that comes from one direction, without what is scattered more
// than once (renderer/kernel/src/albedo.rs makes them). Nodes lie at equal steps of what the functions here call places,
// of roughness and of anisotropy. Places follow the slopes of the facets, so that the tables are smooth at every
// roughness: as a surface gets smoother, what is lost depends on them alone.

const METAL_COSINES: u32 = 40u;
const METAL_ROUGHNESSES: u32 = 32u;
const STRETCHED_COSINES: u32 = 28u;
const STRETCHED_TURNS: u32 = 6u;
const STRETCHED_ROUGHNESSES: u32 = 18u;
const STRETCHED_ANISOTROPIES: u32 = 12u;
/// Odd: the node in the middle is the critical angle.
const BOUNDARY_COSINES: u32 = 57u;
const BOUNDARY_ROUGHNESSES: u32 = 28u;
/// Of each side.
const BOUNDARY_INDICES: u32 = 28u;
/// The largest √((η − 1) / (η + 1)) of the table, an index of 9.5.
const BOUNDARY_REACH: f32 = 0.9;
const SHEEN_COSINES: u32 = 32u;
const SHEEN_ROUGHNESSES: u32 = 24u;
const TABLE_STRETCHED: u32 = TABLE_ALBEDO + METAL_COSINES * METAL_ROUGHNESSES;
const TABLE_SHEEN: u32 =
    TABLE_STRETCHED + STRETCHED_COSINES * STRETCHED_TURNS * STRETCHED_ROUGHNESSES * STRETCHED_ANISOTROPIES;
const TABLE_BOUNDARY: u32 = TABLE_SHEEN + SHEEN_COSINES * SHEEN_ROUGHNESSES;
const BOUNDARY_SIDE: u32 = 2u * BOUNDARY_COSINES * BOUNDARY_ROUGHNESSES * BOUNDARY_INDICES;
const TABLE_END: u32 = TABLE_BOUNDARY + 2u * BOUNDARY_SIDE;

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

// By the tangent of the direction's angle as facets of α = 1 would see it: close to the normal the place is linear in the
// angle, close to the horizon in the root of the cosine.
fn slope_place(mu: f32, slope: f32) -> f32 {
    return sqrt(mu / (mu + slope));
}

fn visible_place(mu: f32, alpha: f32) -> f32 {
    return slope_place(mu, alpha * sqrt(max(0.0, 1.0 - mu * mu)));
}

/// Albedo of a metal that would reflect everything, at cosine mu.
fn metal_albedo(mu: f32, roughness: f32) -> f32 {
    let c = cell_of(visible_place(mu, max(square(roughness), MIRROR_ALPHA)), METAL_COSINES);
    let r = cell_of(roughness, METAL_ROUGHNESSES);
    let at = TABLE_ALBEDO + r.i * METAL_COSINES;
    return mix(table_line(at, c, 1u), table_line(at + METAL_COSINES, c, 1u), r.f);
}

fn stretched_plane(at: u32, c: Cell, t: Cell) -> f32 {
    let line = at + t.i * STRETCHED_COSINES;
    return mix(table_line(line, c, 1u), table_line(line + STRETCHED_COSINES, c, 1u), t.f);
}

/// The same, of a metal whose facets are stretched along x.
fn stretched_albedo(w: vec3<f32>, alpha: vec2<f32>, roughness: f32, anisotropy: f32) -> f32 {
    let stretched = alpha * w.xy;
    let across = dot(stretched, stretched);
    let turn = select(0.0, stretched.y * stretched.y / across, across > 0.0);
    let c = cell_of(slope_place(w.z, sqrt(across)), STRETCHED_COSINES);
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

fn near_place(x: f32, alpha: f32) -> f32 {
    return x / (x + alpha);
}

// On the denser side close to 0, to the critical angle and, behind that, close to it again.
fn boundary_place(mu: f32, alpha: f32, eta: f32) -> f32 {
    if eta >= 1.0 {
        return visible_place(mu, alpha);
    }
    let critical = sqrt(1.0 - eta * eta);
    if mu < critical {
        let p = near_place(mu, alpha) - near_place(critical - mu, alpha);
        return 0.5 * sqrt(max(0.0, 0.5 + 0.5 * p / near_place(critical, alpha)));
    }
    return 0.5 + 0.5 * near_place(mu - critical, alpha) / near_place(1.0 - critical, alpha);
}

// The cosine with facets for which a boundary reflects about as much as with all that are seen at cosine mu.
fn facet_cosine(mu: f32, alpha: f32) -> f32 {
    return sqrt(mix(mu * mu, 0.44, alpha * alpha));
}

// `what`: 0 for what is reflected, over the reflectance at `facet_cosine` where eta is not below 1; 1 for what is
// reflected and what is refracted.
fn boundary_albedo(mu: f32, roughness: f32, eta: f32, what: u32) -> f32 {
    let c = cell_of(boundary_place(mu, max(square(roughness), MIRROR_ALPHA), eta), BOUNDARY_COSINES);
    let r = cell_of(roughness, BOUNDARY_ROUGHNESSES);
    let x = cell_of(sqrt(abs(eta - 1.0) / (eta + 1.0)) / BOUNDARY_REACH, BOUNDARY_INDICES);
    let line = 2u * BOUNDARY_COSINES;
    let side = select(TABLE_BOUNDARY, TABLE_BOUNDARY + BOUNDARY_SIDE, eta < 1.0);
    let at = side + what + (x.i * BOUNDARY_ROUGHNESSES + r.i) * line;
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
    let part = boundary_albedo(mu, roughness, ior, 0u);
    if ior < 1.0 {
        return part;
    }
    return min(1.0, part * dielectric_fresnel(facet_cosine(mu, alpha), ior));
}

/// What a rough boundary sends back or through.
fn boundary_total(mu: f32, roughness: f32, eta: f32) -> f32 {
    return boundary_albedo(mu, roughness, eta, 1u);
}

/// What white fibres send back of light at cosine mu.
fn sheen_albedo(mu: f32, roughness: f32) -> f32 {
    let c = cell_of(sqrt(mu), SHEEN_COSINES);
    let r = cell_of(roughness, SHEEN_ROUGHNESSES);
    let at = TABLE_SHEEN + r.i * SHEEN_COSINES;
    return mix(table_line(at, c, 1u), table_line(at + SHEEN_COSINES, c, 1u), r.f);
}
