//! The tables of albedos: made again in part, against the published numbers, and between their nodes.

mod common;

use std::f64::consts::TAU;

use common::{Random, number, rows};
use glam::{DVec2, DVec3};
use kinora_kernel::albedo::{ENTRIES, ROWS, alphas, average_lost, row, tables};
use kinora_kernel::{Kernel, Packed};

const GGX_ALBEDO: &str = include_str!("data/ggx_albedo.csv");
const ROUGH_DIELECTRIC: &str = include_str!("data/rough_dielectric_albedo.csv");

#[test]
fn tables_are_what_they_were_made_from() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/albedo.f32");
    if std::env::var_os("KINORA_BLESS").is_some() {
        let part = |i: u32| (ROWS * i / 4..ROWS * (i + 1) / 4).flat_map(row).collect::<Vec<f32>>();
        let threads: Vec<_> = (0..4).map(|i| std::thread::spawn(move || part(i))).collect();
        let values: Vec<Vec<f32>> = threads.into_iter().map(|t| t.join().expect("a part is computed")).collect();
        let bytes: Vec<u8> = values.concat().iter().flat_map(|v| v.to_le_bytes()).collect();
        std::fs::write(path, bytes).expect("the tables can be written");
        return;
    }
    assert_eq!(tables().len(), ENTRIES as usize);
    // A prime step visits every table at all kinds of nodes.
    let pairs = 2 * ROWS - ENTRIES;
    for i in (0..ROWS).step_by(97) {
        for (j, made) in row(i).into_iter().enumerate() {
            let at = if i < pairs { i } else { 2 * i - pairs } as usize + j;
            let kept = tables()[at];
            assert!((kept - made).abs() <= 1e-6, "entry {at}: {kept} is kept, {made} is right");
        }
    }
}

fn lambda(w: DVec3, alpha: DVec2) -> f64 {
    let tan2 = (alpha * w.truncate()).length_squared() / (w.z * w.z);
    0.5 * tan2 / (1.0 + (1.0 + tan2).sqrt())
}

// G2 / G1 of light that leaves along wi.
fn unmasked(wo: DVec3, wi: DVec3, alpha: DVec2) -> f64 {
    let seen = 1.0 + lambda(wo, alpha);
    seen / (seen + lambda(wi, alpha))
}

/// Means over visible normals by their disc (Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018),
/// which is not how the tables are made.
fn over_visible_normals(wo: DVec3, alpha: DVec2, f: impl Fn(DVec3) -> [f64; 2]) -> [f64; 2] {
    const POINTS: u32 = 8192;
    let v = (alpha * wo.truncate()).extend(wo.z).normalize();
    let t1 = if v.z < 1.0 { DVec3::new(-v.y, v.x, 0.0).normalize() } else { DVec3::X };
    let t2 = v.cross(t1);
    let s = 0.5 * (1.0 + v.z);
    let mut sums = [0.0; 2];
    for i in 0..POINTS {
        let r = ((f64::from(i) + 0.5) / f64::from(POINTS)).sqrt();
        let (sin, cos) = (TAU * (f64::from(i) * 0.618_033_988_749_894_9).fract()).sin_cos();
        let x = r * cos;
        let y = (1.0 - s) * (1.0 - x * x).max(0.0).sqrt() + s * r * sin;
        let n = x * t1 + y * t2 + (1.0 - x * x - y * y).max(0.0).sqrt() * v;
        let m = (alpha * n.truncate()).extend(n.z.max(1e-12)).normalize();
        let values = f(m);
        sums = [sums[0] + values[0], sums[1] + values[1]];
    }
    sums.map(|sum| sum / f64::from(POINTS))
}

fn metal(wo: DVec3, alpha: DVec2) -> f64 {
    over_visible_normals(wo, alpha, |m| {
        let wi = 2.0 * wo.dot(m) * m - wo;
        [if wi.z > 0.0 { unmasked(wo, wi, alpha) } else { 0.0 }, 0.0]
    })[0]
}

/// What is reflected, and that with what is refracted.
fn boundary(mu: f64, alpha: f64, eta: f64) -> [f64; 2] {
    let wo = slant(mu, 0.4);
    let alpha = DVec2::splat(alpha);
    let [reflected, refracted] = over_visible_normals(wo, alpha, |m| {
        let c = wo.dot(m).min(1.0);
        let g2 = eta * eta - 1.0 + c * c;
        let g = g2.max(0.0).sqrt();
        let (p, q) = ((g - c) / (g + c), (c * (g + c) - 1.0) / (c * (g - c) + 1.0));
        let f = if g2 <= 0.0 { 1.0 } else { 0.5 * p * p * (1.0 + q * q) };
        let up = 2.0 * c * m - wo;
        let down = ((c - g) * m - wo) / eta;
        [
            if up.z > 0.0 { f * unmasked(wo, up, alpha) } else { 0.0 },
            if f < 1.0 && down.z < 0.0 { (1.0 - f) * unmasked(wo, down, alpha) } else { 0.0 },
        ]
    });
    [reflected, reflected + refracted]
}

fn slant(mu: f64, phi: f64) -> DVec3 {
    ((1.0 - mu * mu).max(0.0).sqrt() * DVec2::from_angle(phi)).extend(mu)
}

#[test]
fn tables_are_the_published_numbers() {
    Packed::empty().with_kernel(|k| {
        let mut worst = [0.0_f64; 4];
        for r in rows(GGX_ALBEDO) {
            let (roughness, want) = (number(r[0]), number(r[2]));
            if r[1] == "avg" {
                worst[1] = worst[1].max((1.0 - average_lost(roughness, 0.0) - want).abs());
            } else {
                let got = f64::from(k.metal_albedo(number(r[1]) as f32, roughness as f32));
                worst[0] = worst[0].max((got - want).abs());
            }
        }
        for r in rows(ROUGH_DIELECTRIC) {
            let [ior, roughness, mu, reflected, total] = [0, 2, 3, 4, 6].map(|i| number(r[i]));
            let eta = if r[1] == "enter" { ior } else { 1.0 / ior } as f32;
            let got = k.boundary_total(mu as f32, roughness as f32, eta);
            worst[2] = worst[2].max((f64::from(got) / total - 1.0).abs());
            if eta > 1.0 {
                let got = k.coat_albedo((roughness * roughness) as f32, roughness as f32, eta, mu as f32);
                worst[3] = worst[3].max((f64::from(got) - reflected).abs());
            }
        }
        println!("off by {worst:?}: metals, their average, boundaries, coats");
        assert!(worst.iter().zip([1e-3, 7e-4, 5e-3, 2e-3]).all(|(error, bound)| *error < bound), "{worst:?}");
    });
}

/// Random parameters, more often smooth and grazing than by chance.
struct Point {
    roughness: f64,
    mu: f64,
    phi: f64,
    anisotropy: f64,
    eta: f64,
}

fn points(count: u32) -> impl Iterator<Item = Point> {
    let mut random = Random(1);
    (0..count).map(move |i| {
        let mut within = |low: f64, high: f64| low + (high - low) * f64::from(random.unit());
        let eta = if i % 2 == 0 { within(1.02, 1.8) } else { within(1.02, 6.0) };
        Point {
            roughness: if i % 4 < 2 { within(0.032, 1.0) } else { within(0.032, 0.3) },
            mu: if i % 3 == 0 { within(2e-3, 0.15) } else { within(2e-3, 1.0) },
            phi: within(0.0, TAU),
            anisotropy: within(0.0, 1.0),
            eta: if i % 8 < 4 { eta } else { 1.0 / eta },
        }
    })
}

/// Fails if the worst of the errors is above `bound`, or one in a hundred above `most`.
#[track_caller]
fn check(name: &str, most: f64, bound: f64, error: impl Fn(&Kernel<'_>, &Point) -> f64) {
    Packed::empty().with_kernel(|k| {
        let mut errors: Vec<(f64, Point)> = points(1000).map(|p| (error(k, &p).abs(), p)).collect();
        errors.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Point { roughness, mu, phi, anisotropy, eta } = errors[0].1;
        let place = format!("roughness {roughness}, cosine {mu}, azimuth {phi}, anisotropy {anisotropy}, eta {eta}");
        println!("{name}: {:.1e} in 99 of 100, at most {:.1e} at {place}", errors[10].0, errors[0].0);
        assert!(errors[10].0 < most && errors[0].0 < bound, "{name}: {} at {place}", errors[0].0);
    });
}

#[test]
fn metals_between_nodes() {
    check("metals", 1e-3, 1.5e-3, |k, p| {
        let want = metal(slant(p.mu, p.phi), DVec2::splat(p.roughness * p.roughness));
        f64::from(k.metal_albedo(p.mu as f32, p.roughness as f32)) - want
    });
}

#[test]
fn stretched_metals_between_nodes() {
    check("stretched metals", 2e-3, 3e-3, |k, p| {
        let alpha = DVec2::from(alphas(p.roughness, p.anisotropy)).max(DVec2::splat(1e-3));
        let w = slant(p.mu, p.phi);
        let got = k.stretched_albedo(w.as_vec3(), alpha.as_vec2(), p.roughness as f32, p.anisotropy as f32);
        f64::from(got) - metal(w, alpha)
    });
}

#[test]
fn boundaries_between_nodes() {
    check("boundaries", 4e-3, 1.2e-2, |k, p| {
        let [_, want] = boundary(p.mu, p.roughness * p.roughness, p.eta);
        f64::from(k.boundary_total(p.mu as f32, p.roughness as f32, p.eta as f32)) / want - 1.0
    });
}

#[test]
fn coats_between_nodes() {
    check("coats", 4e-3, 6e-3, |k, p| {
        let alpha = p.roughness * p.roughness;
        let eta = p.eta.max(1.0 / p.eta);
        let [want, _] = boundary(p.mu, alpha, eta);
        f64::from(k.coat_albedo(alpha as f32, p.roughness as f32, eta as f32, p.mu as f32)) - want
    });
}
