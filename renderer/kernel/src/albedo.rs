//! Directional albedos of rough surfaces: how the tables are made that `shaders/bsdf/albedo.wgsl` reads. What single
//! scattering between microfacets loses, compensation adds again, so the tables must belong to exactly the same
//! microfacets: GGX with height-correlated Smith masking.
//!
//! The tables are kept in `data/albedo.f32` (little-endian), since making them takes half a minute; a test makes some
//! entries again, and all of them with `KINORA_BLESS=1`.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

use glam::{DVec2, DVec3, Vec3};

use crate::generated::{
    BOUNDARY_COSINES, BOUNDARY_INDICES, BOUNDARY_REACH, BOUNDARY_ROUGHNESSES, BOUNDARY_SIDE, METAL_COSINES,
    METAL_ROUGHNESSES, MIRROR_ALPHA, SHEEN_COSINES, SHEEN_ROUGHNESSES, STRETCHED_ANISOTROPIES, STRETCHED_COSINES,
    STRETCHED_ROUGHNESSES, STRETCHED_TURNS, TABLE_ALBEDO, TABLE_BOUNDARY, TABLE_END, TABLE_SHEEN, TABLE_STRETCHED,
};
use crate::{Kernel, Packed};

static TABLES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let bytes = include_bytes!("../data/albedo.f32");
    bytes.as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word)).collect()
});

/// All tables, one after the other, as they stand in `tables` from `TABLE_ALBEDO` on.
pub fn tables() -> &'static [f32] {
    &TABLES
}

/// How many entries the tables have.
pub const ENTRIES: u32 = TABLE_END - TABLE_ALBEDO;

/// α along and across the tangent (OpenPBR 1.1, "Microfacet model"): `roughness` and `anisotropy` in 0..=1.
pub fn alphas(roughness: f64, anisotropy: f64) -> [f64; 2] {
    let across = 1.0 - anisotropy;
    let along = roughness * roughness * (2.0 / (1.0 + across * across)).sqrt();
    [along, across * along]
}

/// Points at which integrands are taken, and the generator of the lattice that they form: Fibonacci numbers.
const POINTS: u32 = 6_765;
const GENERATOR: u32 = 4_181;

// Cosine and sine of the lattice's second coordinate, as a turn.
static TURNS: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| {
    let turn = |i: u32| TAU * f64::from(i * GENERATOR % POINTS) / f64::from(POINTS);
    (0..POINTS).map(|i| [turn(i).cos(), turn(i).sin()]).collect()
});

/// Narrower lobes are not distinguished; a table's first nodes would be 0 / 0 else.
const NARROWEST: f64 = MIRROR_ALPHA as f64;

// The cosine whose place is node `i` of `nodes`. A cosine of 0 has no albedo, only a limit.
fn cosine(i: u32, nodes: u32, place: impl Fn(f32) -> f32) -> f64 {
    let (mut low, mut high) = (1e-7_f32, 1.0);
    let want = i as f32 / (nodes - 1) as f32;
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        *(if place(middle) < want { &mut low } else { &mut high }) = middle;
    }
    f64::from(high)
}

fn node(i: u32, nodes: u32) -> f64 {
    f64::from(i) / f64::from(nodes - 1)
}

fn metal_entry(k: &Kernel<'_>, i: u32) -> f64 {
    let (c, r) = (i % METAL_COSINES, i / METAL_COSINES);
    let alpha = alphas(node(r, METAL_ROUGHNESSES), 0.0)[0].max(NARROWEST);
    let mu = cosine(c, METAL_COSINES, |mu| k.visible_place(mu, alpha as f32));
    metal(direction(mu, 0.0), alpha, alpha)
}

fn stretched_entry(k: &Kernel<'_>, i: u32) -> f64 {
    let (c, i) = (i % STRETCHED_COSINES, i / STRETCHED_COSINES);
    let (turn, i) = (i % STRETCHED_TURNS, i / STRETCHED_TURNS);
    let (r, a) = (i % STRETCHED_ROUGHNESSES, i / STRETCHED_ROUGHNESSES);
    let [along, across] = alphas(node(r, STRETCHED_ROUGHNESSES), node(a, STRETCHED_ANISOTROPIES));
    let (along, across) = (along.max(NARROWEST), across.max(NARROWEST));
    // The azimuth after stretching, and before.
    let turned = node(turn, STRETCHED_TURNS).sqrt().asin().min(FRAC_PI_2);
    let phi = (turned.sin() * along).atan2(turned.cos() * across);
    let alpha = (along * phi.cos()).hypot(across * phi.sin());
    let mu = cosine(c, STRETCHED_COSINES, |mu| k.visible_place(mu, alpha as f32));
    metal(direction(mu, phi), along, across)
}

fn boundary_entry(k: &Kernel<'_>, i: u32) -> [f64; 2] {
    let (c, i) = (i % BOUNDARY_COSINES, i / BOUNDARY_COSINES);
    let (r, i) = (i % BOUNDARY_ROUGHNESSES, i / BOUNDARY_ROUGHNESSES);
    let (x, leaving) = (i % BOUNDARY_INDICES, i / BOUNDARY_INDICES == 1);
    let x = (node(x, BOUNDARY_INDICES) * f64::from(BOUNDARY_REACH)).powi(2);
    let eta = if leaving { (1.0 - x) / (1.0 + x) } else { (1.0 + x) / (1.0 - x) };
    let alpha = alphas(node(r, BOUNDARY_ROUGHNESSES), 0.0)[0].max(NARROWEST);
    let mu = cosine(c, BOUNDARY_COSINES, |mu| k.boundary_place(mu, alpha as f32, eta as f32));
    let [reflected, refracted] = boundary_albedo(mu, alpha, eta);
    let part = if leaving {
        reflected
    } else {
        reflected / fresnel(k.facet_cosine(mu as f32, alpha as f32).into(), eta).max(1e-9)
    };
    [part, reflected + refracted]
}

fn sheen_entry(k: &Kernel<'_>, i: u32) -> f64 {
    let (c, r) = (i % SHEEN_COSINES, i / SHEEN_COSINES);
    sheen(k, cosine(c, SHEEN_COSINES, f32::sqrt), node(r, SHEEN_ROUGHNESSES))
}

/// What white fibres send back of light at cosine `mu`: the mean over directions, which lie closer towards the horizon.
pub fn sheen(k: &Kernel<'_>, mu: f64, roughness: f64) -> f64 {
    let wo = direction(mu, 0.0).as_vec3();
    let points = (0..POINTS).zip(TURNS.iter()).map(|(i, [cos, sin])| {
        let t = (f64::from(i) + 0.5) / f64::from(POINTS);
        let (z, step) = (t * t, 2.0 * t);
        let r = (1.0 - z * z).sqrt();
        step * f64::from(k.sheen_eval(roughness as f32, wo, DVec3::new(r * cos, r * sin, z).as_vec3()))
    });
    TAU * points.sum::<f64>() / f64::from(POINTS)
}

/// Row `row` of the tables: one entry, or the two of a boundary.
pub fn row(row: u32) -> Vec<f32> {
    let [metals, stretched, fibres] = [TABLE_STRETCHED, TABLE_SHEEN, TABLE_BOUNDARY].map(|end| end - TABLE_ALBEDO);
    Packed::empty().with_kernel(|k| {
        if row < metals {
            vec![metal_entry(k, row) as f32]
        } else if row < stretched {
            vec![stretched_entry(k, row - metals) as f32]
        } else if row < fibres {
            vec![sheen_entry(k, row - stretched) as f32]
        } else {
            boundary_entry(k, row - fibres).map(|x| x as f32).to_vec()
        }
    })
}

/// How many rows the tables have.
pub const ROWS: u32 = TABLE_BOUNDARY - TABLE_ALBEDO + BOUNDARY_SIDE;

/// The mean over the hemisphere, weighted by the cosine, of what a metal that would reflect everything loses.
pub fn average_lost(roughness: f64, anisotropy: f64) -> f64 {
    let (cosines, turns) = (256, if anisotropy == 0.0 { 1 } else { 32 });
    let alpha = DVec2::from(alphas(roughness, anisotropy)).max(DVec2::splat(NARROWEST)).as_vec2();
    Packed::empty().with_kernel(|kernel| {
        let mut sum = 0.0;
        for i in 0..cosines {
            // More of those at grazing angles, where smooth surfaces lose most.
            let t = (f64::from(i) + 0.5) / f64::from(cosines);
            let (mu, step) = (t.powi(3), 3.0 * t * t / f64::from(cosines));
            for j in 0..turns {
                let w = direction(mu, FRAC_PI_2 * (f64::from(j) + 0.5) / f64::from(turns)).as_vec3();
                let albedo = if anisotropy == 0.0 {
                    kernel.metal_albedo(w.z, roughness as f32)
                } else {
                    kernel.stretched_albedo(w, alpha, roughness as f32, anisotropy as f32)
                };
                sum += 2.0 * mu * step * (1.0 - f64::from(albedo)) / f64::from(turns);
            }
        }
        sum
    })
}

/// The mean over the hemisphere, weighted by the cosine, of a reflectance by cosine.
pub fn average(reflectance: impl Fn(f32) -> Vec3) -> Vec3 {
    let steps = 256;
    let at = |i| (i as f32 + 0.5) / steps as f32;
    (0..steps).map(|i| reflectance(at(i)) * (2.0 * at(i) / steps as f32)).sum()
}

fn direction(mu: f64, phi: f64) -> DVec3 {
    let s = (1.0 - mu * mu).max(0.0).sqrt();
    DVec3::new(s * phi.cos(), s * phi.sin(), mu)
}

fn lambda(w: DVec3, along: f64, across: f64) -> f64 {
    let tan2 = ((along * w.x).powi(2) + (across * w.y).powi(2)) / (w.z * w.z);
    0.5 * ((1.0 + tan2).sqrt() - 1.0)
}

// Means over the visible normals from `wo` (Dupuy and Benyoub 2023), at the points of a lattice.
fn over_visible_normals<const N: usize>(wo: DVec3, along: f64, across: f64, f: impl Fn(DVec3) -> [f64; N]) -> [f64; N] {
    let w = DVec3::new(along * wo.x, across * wo.y, wo.z).normalize();
    let mut sums = [0.0; N];
    for (i, [cos, sin]) in (0..POINTS).zip(TURNS.iter()) {
        let z = (f64::from(i) + 0.5) / f64::from(POINTS) * (1.0 + w.z) - w.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let h = DVec3::new(r * cos, r * sin, z) + w;
        let m = DVec3::new(along * h.x, across * h.y, h.z.max(1e-12)).normalize();
        for (sum, value) in sums.iter_mut().zip(f(m)) {
            *sum += value;
        }
    }
    sums.map(|sum| sum / f64::from(POINTS))
}

// G2 / G1 of light that leaves along wi.
fn unmasked(wo: DVec3, wi: DVec3, along: f64, across: f64) -> f64 {
    let seen = 1.0 + lambda(wo, along, across);
    seen / (seen + lambda(wi, along, across))
}

fn metal(wo: DVec3, along: f64, across: f64) -> f64 {
    let (along, across) = (along.max(NARROWEST), across.max(NARROWEST));
    let [albedo] = over_visible_normals(wo, along, across, |m| {
        let wi = 2.0 * wo.dot(m) * m - wo;
        [if wi.z > 0.0 { unmasked(wo, wi, along, across) } else { 0.0 }]
    });
    albedo
}

fn fresnel(c: f64, eta: f64) -> f64 {
    let sin2_t = (1.0 - c * c) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let ct = (1.0 - sin2_t).sqrt();
    let rs = (c - eta * ct) / (c + eta * ct);
    let rp = (eta * c - ct) / (eta * c + ct);
    0.5 * (rs * rs + rp * rp)
}

/// What a boundary of relative index `eta` (far side over near side) sends back and through of light at cosine `mu`,
/// scattered once (Walter et al. 2007): [reflected, refracted].
pub fn boundary_albedo(mu: f64, alpha: f64, eta: f64) -> [f64; 2] {
    let alpha = alpha.max(NARROWEST);
    let wo = direction(mu, 0.0);
    over_visible_normals(wo, alpha, alpha, |m| {
        let c = wo.dot(m).clamp(0.0, 1.0);
        let f = fresnel(c, eta);
        let reflected = 2.0 * c * m - wo;
        let ct = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
        let refracted = (c / eta - ct) * m - wo / eta;
        [
            if reflected.z > 0.0 { f * unmasked(wo, reflected, alpha, alpha) } else { 0.0 },
            if f < 1.0 && refracted.z < 0.0 { (1.0 - f) * unmasked(wo, refracted, alpha, alpha) } else { 0.0 },
        ]
    })
}
