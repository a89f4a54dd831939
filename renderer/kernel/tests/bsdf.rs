//! Diffuse and metal: samplers against densities, energy, reciprocity, and albedos against tables.

mod common;

use std::f64::consts::PI;

use common::{
    Mean, Random, SphereBins, check_rejects, diffuse, direction, gauss, glass, integrate, metal, nothing, number, rows,
};
use glam::{DVec3, Vec3};
use kinora_kernel::generated::{DELTA_PDF, MIRROR_ALPHA};
use kinora_kernel::{Kernel, Material};

const DIFFUSE_ALBEDO: &str = include_str!("data/diffuse_albedo.csv");
const GGX_ALBEDO: &str = include_str!("data/ggx_albedo.csv");

const GOLD: Vec3 = Vec3::new(1.0, 0.78, 0.34);

fn with(f: impl FnOnce(&Kernel<'_>)) {
    nothing().with_kernel(f);
}

/// Both kinds, across their parameters.
fn materials() -> Vec<(String, Material)> {
    let mut all = Vec::new();
    for roughness in [0.0, 0.25, 0.6, 1.0] {
        for rho in [0.2, 0.8, 1.0] {
            all.push((format!("diffuse {rho} of roughness {roughness}"), diffuse(rho, roughness)));
        }
    }
    for alpha in [1.01e-3, 0.0025, 0.02, 0.073, 0.25, 0.61, 1.0] {
        for (color, tint) in [(Vec3::ONE, Vec3::ONE), (GOLD, Vec3::new(1.0, 0.9, 0.5)), (GOLD * 0.2, Vec3::splat(0.2))]
        {
            all.push((format!("metal {color} with edge {tint} of alpha {alpha}"), metal(color, tint, alpha)));
        }
    }
    all
}

/// Above the surface, more often grazing than by chance.
fn above(random: &mut Random) -> Vec3 {
    let z = f64::from(random.within(1e-3, 1.0));
    direction(z * z, f64::from(random.within(0.0, std::f32::consts::TAU)))
}

#[test]
fn samples_follow_the_density() {
    with(|k| {
        let cosines = [0.02, 0.3, 0.8, 1.0];
        let mut cases = vec![(diffuse(0.8, 0.0), 0.5), (diffuse(0.8, 0.7), 0.1)];
        for alpha in [0.05, 0.073, 0.25, 0.61, 1.0] {
            cases.extend(cosines.map(|mu| (metal(GOLD, Vec3::ONE, alpha), mu)));
        }
        let bins = SphereBins { z_low: 0.0, rows: 24, columns: 32, jumps: false };
        for (i, &(m, mu)) in cases.iter().enumerate() {
            let wo = direction(mu, 2.0);
            let mut random = Random(i as u64);
            let name = format!("kind {} with {} at cosine {mu}", m.kind.x, m.color.w);
            // So many bins that a pdf wrong by 2 % in one half is seen: with 12 800 it would not be.
            let (observed, expected) = bins.check(
                &name,
                2 * cases.len(),
                1_000_000,
                || {
                    let s = k.bsdf_sample(m, wo, true, random.square());
                    (s.pdf > 0.0).then_some(s.wi)
                },
                |wi| f64::from(k.bsdf_pdf(m, wo, wi)),
            );
            check_rejects(&name, 2 * cases.len(), &observed, &expected);
        }
    });
}

#[test]
fn samples_agree_with_eval_and_pdf() {
    with(|k| {
        let mut failures = Vec::new();
        for (name, m) in materials() {
            let metal = name.starts_with("metal");
            let mut random = Random(3);
            let mut worst = (0.0_f32, String::new());
            for _ in 0..20_000 {
                let wo = above(&mut random);
                let s = k.bsdf_sample(m, wo, true, random.square());
                if s.pdf == 0.0 {
                    continue;
                }
                assert!(s.wi.is_finite() && s.weight.is_finite() && s.weight.min_element() >= 0.0, "{name}: {s:?}");
                assert!((s.wi.length() - 1.0).abs() < 1e-5, "{name}: {} is no unit vector", s.wi);
                assert!(s.wi.z > 0.0 && s.eta == 1.0, "{name}: {s:?}");
                assert!(!metal || s.weight.max_element() <= 1.0 + 1e-4, "{name}: {s:?} weighs more than 1");
                if s.wi.z.min(wo.z) < 0.01 {
                    continue;
                }
                let pdf = k.bsdf_pdf(m, wo, s.wi);
                let weight = k.bsdf_eval(m, wo, s.wi) / pdf;
                let slack = 1e-4 + if metal { rounding(m.color.w, wo, s.wi) } else { 0.0 };
                let error = (s.pdf / pdf - 1.0).abs() / slack;
                let error = error.max((weight - s.weight).abs().max_element() / 1e-4);
                if error > worst.0 {
                    worst = (error, format!("pdf {pdf}, weight {weight} of {wo} to {s:?}"));
                }
            }
            println!("{name}: {} of what is allowed", worst.0);
            if worst.0 > 1.0 {
                failures.push((name, worst));
            }
        }
        assert!(failures.is_empty(), "{failures:#?}");
    });
}

/// Directions are given to 6e-8, which is that much of the lobe's width: relative error of a density.
fn rounding(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    4e-7 / (alpha * (wo + wi).length())
}

#[test]
fn eval_is_reciprocal() {
    with(|k| {
        for (name, m) in materials() {
            let mut random = Random(4);
            for _ in 0..10_000 {
                let (a, b) = (above(&mut random), above(&mut random));
                let (ab, ba) = (k.bsdf_eval(m, a, b) / b.z, k.bsdf_eval(m, b, a) / a.z);
                let scale = ab.abs().max_element().max(1e-20);
                assert!((ab - ba).abs().max_element() <= 1e-4 * scale, "{name}: {ab} but {ba} for {a} {b}");
            }
        }
    });
}

#[test]
fn nothing_leaves_below_the_surface() {
    with(|k| {
        for (name, m) in materials() {
            for (wo, wi) in [(Vec3::Z, -Vec3::Z), (-Vec3::Z, Vec3::Z), (Vec3::Z, Vec3::X), (Vec3::X, Vec3::Z)] {
                assert_eq!(k.bsdf_eval(m, wo, wi), Vec3::ZERO, "{name}: eval of {wo} {wi}");
                assert_eq!(k.bsdf_pdf(m, wo, wi), 0.0, "{name}: pdf of {wo} {wi}");
            }
        }
    });
}

const BATCH: u32 = 100_000;

/// How often that which a batch never meets may occur: directions that the far tail of a narrow lobe loses.
const UNSEEN: f64 = 7.0 / BATCH as f64;

/// Samples until the error is small enough to prove something.
fn albedo_by_sampling(k: &Kernel<'_>, m: Material, mu: f64, seed: u64) -> Mean {
    let wo = direction(mu, 0.7);
    let mut random = Random(seed);
    let mut mean = Mean::default();
    for _ in 0..50 {
        for _ in 0..BATCH {
            let s = k.bsdf_sample(m, wo, true, random.square());
            mean.add(if s.pdf > 0.0 { f64::from(s.weight.x) } else { 0.0 });
        }
        if mean.error() <= 0.0018 * mean.mean() {
            break;
        }
    }
    mean
}

fn albedo_by_quadrature(k: &Kernel<'_>, m: Material, mu: f64) -> f64 {
    const PANELS: u32 = 16;
    let wo = direction(mu, 0.0);
    let rule = gauss(6);
    let side = 1.0 / f64::from(PANELS);
    let mut sum = 0.0;
    for i in 0..PANELS {
        for j in 0..PANELS {
            let low = [f64::from(i) * side, f64::from(j) * side * PI];
            let high = [low[0] + side, low[1] + side * PI];
            // z = t² spreads the grazing directions.
            sum += integrate(&rule, low, high, [1e-6, 1e-9], &mut |t, phi| {
                2.0 * t * f64::from(k.bsdf_eval(m, wo, direction(t * t, phi)).x)
            });
        }
    }
    2.0 * sum
}

#[test]
fn diffuse_albedo_is_the_tables() {
    with(|k| {
        let table: Vec<_> = rows(DIFFUSE_ALBEDO).map(|r| [0, 1, 2, 3].map(|i| number(r[i]))).collect();
        for (i, &[roughness, rho, mu, want]) in table.iter().enumerate() {
            let m = diffuse(rho as f32, roughness as f32);
            let name = format!("diffuse {rho} of roughness {roughness} at {mu}");
            let sampled = albedo_by_sampling(k, m, mu, i as u64);
            sampled.check(&name, table.len(), want, 1e-5 + UNSEEN, 2e-3);
            if mu == 0.1 || mu == 0.5 || mu == 1.0 {
                let got = albedo_by_quadrature(k, m, mu);
                assert!((got - want).abs() < 2e-5, "{name}: {got} by quadrature, but should be {want}");
            }
        }
    });
}

#[test]
fn metal_albedo_is_the_tables() {
    with(|k| {
        let table: Vec<_> =
            rows(GGX_ALBEDO).filter(|r| r[1] != "avg").map(|r| [0, 1, 2].map(|i| number(r[i]))).collect();
        for (i, &[roughness, mu, want]) in table.iter().enumerate() {
            let m = metal(Vec3::ONE, Vec3::ONE, (roughness * roughness) as f32);
            let name = format!("metal of roughness {roughness} at {mu}");
            albedo_by_sampling(k, m, mu, i as u64).check(&name, table.len(), want, 1e-5 + UNSEEN, 2e-3);
            if roughness >= 0.3 && (mu == 0.1 || mu == 0.5 || mu == 1.0) {
                let got = albedo_by_quadrature(k, m, mu);
                assert!((got - want).abs() < 1e-4, "{name}: {got} by quadrature, but should be {want}");
            }
        }
    });
}

#[test]
fn white_diffuse_keeps_all_and_none_gain() {
    with(|k| {
        for mu in [0.01, 0.2, 0.6, 0.95] {
            for roughness in [0.05, 0.33, 0.75, 1.0] {
                let got = albedo_by_quadrature(k, diffuse(1.0, roughness), mu);
                assert!((got - 1.0).abs() < 1e-4, "roughness {roughness} at {mu}: {got}");
            }
            for alpha in [0.12, 0.4, 0.9] {
                for tint in [Vec3::ONE, Vec3::splat(0.3)] {
                    let got = albedo_by_quadrature(k, metal(Vec3::splat(0.95), tint, alpha), mu);
                    assert!(got <= 1.0 + 1e-3, "alpha {alpha} at {mu}: {got}");
                }
            }
        }
    });
}

fn diffuse_exact(rho: f64, r: f64, wo: DVec3, wi: DVec3) -> f64 {
    let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let albedo = |mu: f64| {
        let s = (1.0 - mu * mu).max(0.0).sqrt();
        let g = s * (mu.acos() - s * mu) + 2.0 / 3.0 * (s / mu * (1.0 - s * s * s) - s);
        a * (1.0 + r / PI * g)
    };
    let average = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    let s = wi.dot(wo) - wi.z * wo.z;
    let t = if s > 0.0 { s / wi.z.max(wo.z) } else { s };
    let rho_ms = rho * rho * average / (1.0 - rho * (1.0 - average));
    let lost = if r == 0.0 { 0.0 } else { (1.0 - albedo(wi.z)) * (1.0 - albedo(wo.z)) / (1.0 - average) };
    (rho * a * (1.0 + r * t) + rho_ms * lost) / PI * wi.z
}

fn metal_exact(color: f64, tint: f64, alpha: f64, wo: DVec3, wi: DVec3) -> f64 {
    let h = (wo + wi).normalize();
    let schlick = |c: f64| color + (1.0 - color) * (1.0 - c).powi(5);
    let c = h.dot(wi);
    let c82: f64 = 1.0 / 7.0;
    let edge = schlick(c82) * (1.0 - tint) / (c82 * (1.0 - c82).powi(6));
    let fresnel = (schlick(c) - edge * c * (1.0 - c).powi(6)).clamp(0.0, 1.0);
    // The form without cancellation.
    let d = 1.0 / (PI * alpha * alpha * ((h.x * h.x + h.y * h.y) / (alpha * alpha) + h.z * h.z).powi(2));
    let lambda = |w: DVec3| 0.5 * ((1.0 + alpha * alpha * (1.0 - w.z * w.z) / (w.z * w.z)).sqrt() - 1.0);
    fresnel * d / (1.0 + lambda(wo) + lambda(wi)) / (4.0 * wo.z)
}

#[test]
fn eval_is_the_formula() {
    with(|k| {
        let mut random = Random(8);
        let unit = |w: Vec3| w.as_dvec3().normalize();
        for _ in 0..100_000 {
            let (wo, wi) = (above(&mut random), above(&mut random));
            let (rho, r) = (random.unit(), random.unit());
            let got = f64::from(k.bsdf_eval(diffuse(rho, r), wo, wi).y);
            let want = diffuse_exact(rho.into(), r.into(), unit(wo), unit(wi));
            assert!((got - want).abs() <= 1e-5 * want + 1e-7, "diffuse {rho} {r}: {got}, not {want}, for {wo} {wi}");
        }
        // Where the lobe is: the directions that are sampled.
        let mut failures = Vec::new();
        for alpha in [0.0025, 0.01, 0.05, 0.3, 1.0] {
            let mut worst = (0.0, Vec3::ZERO, Vec3::ZERO);
            for _ in 0..20_000 {
                let wo = direction(f64::from(random.within(0.1, 1.0)), 1.0);
                let (color, tint) = (random.within(0.2, 1.0), random.within(0.2, 1.0));
                let m = metal(Vec3::splat(color), Vec3::splat(tint), alpha);
                let s = k.bsdf_sample(m, wo, true, random.square() * 0.98 + 0.01);
                if s.pdf == 0.0 || s.wi.z < 0.05 {
                    continue;
                }
                let got = f64::from(k.bsdf_eval(m, wo, s.wi).x);
                let want = metal_exact(color.into(), tint.into(), alpha.into(), unit(wo), unit(s.wi));
                let slack = 5e-5 + f64::from(rounding(alpha, wo, s.wi));
                let error = (got / want - 1.0).abs() / slack;
                if error > worst.0 {
                    worst = (error, wo, s.wi);
                }
            }
            println!("alpha {alpha}: {} of what is allowed", worst.0);
            if worst.0 > 1.0 {
                failures.push((alpha, worst));
            }
        }
        assert!(failures.is_empty(), "metal: {failures:#?}");
    });
}

#[test]
fn mirrors_reflect() {
    with(|k| {
        let mut random = Random(9);
        for alpha in [0.0, 1e-5, MIRROR_ALPHA.next_down()] {
            let m = metal(GOLD, Vec3::splat(0.7), alpha);
            assert!(k.bsdf_is_delta(m));
            for _ in 0..1000 {
                let wo = above(&mut random);
                let s = k.bsdf_sample(m, wo, true, random.square());
                assert_eq!(s.wi, Vec3::new(-wo.x, -wo.y, wo.z));
                assert_eq!((s.pdf, s.eta), (DELTA_PDF, 1.0));
                assert_eq!(s.weight, k.metal_fresnel(m, wo.z));
                assert_eq!(k.bsdf_eval(m, wo, s.wi), Vec3::ZERO, "eval of alpha {alpha} at {wo}");
                assert_eq!(k.bsdf_pdf(m, wo, s.wi), 0.0, "pdf of alpha {alpha} at {wo}");
            }
        }
        assert!(!k.bsdf_is_delta(metal(GOLD, Vec3::ONE, MIRROR_ALPHA)));
        assert!(!k.bsdf_is_delta(diffuse(1.0, 0.0)));
        assert!(k.bsdf_is_delta(glass(1.5)));
    });
}

#[test]
fn metal_fresnel_has_its_colours() {
    with(|k| {
        let tint = Vec3::new(1.0, 0.6, 0.0);
        let m = metal(GOLD, tint, 0.2);
        let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-6;
        assert!(near(k.metal_fresnel(m, 1.0), GOLD));
        assert!(near(k.metal_fresnel(m, 0.0), Vec3::ONE));
        let schlick = GOLD + (Vec3::ONE - GOLD) * 0.462_664_36;
        assert!(near(k.metal_fresnel(m, 1.0 / 7.0), schlick * tint), "{}", k.metal_fresnel(m, 1.0 / 7.0));
        for i in 0..=1000 {
            let f = k.metal_fresnel(m, i as f32 / 1000.0);
            assert!(f.min_element() >= 0.0 && f.max_element() <= 1.0, "{f}");
        }
    });
}
