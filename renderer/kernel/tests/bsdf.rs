//! Every lobe: samplers against densities, energy, reciprocity, formulas, and albedos against tables.

mod common;

use std::f64::consts::PI;

use common::{
    Mean, Random, SphereBins, check_rejects, compensated, diffuse, direction, fibres, gauss, glass, glossy, integrate,
    measured, metal, number, rows, scene, widths,
};
use glam::{DVec3, Vec3, Vec4};
use kinora_kernel::generated::{
    Bsdf, COMPENSATE, DELTA_PDF, DIELECTRIC_THIN, DIFFUSE_EON, DIFFUSE_FON, DIFFUSE_QON, MATERIAL_METAL,
    MATERIAL_SHEEN, MIRROR_ALPHA,
};
use kinora_kernel::{Kernel, Material, Packed, albedo};

const DIFFUSE_ALBEDO: &str = include_str!("data/diffuse_albedo.csv");
const GGX_ALBEDO: &str = include_str!("data/ggx_albedo.csv");
const ROUGH_DIELECTRIC: &str = include_str!("data/rough_dielectric_albedo.csv");
const CONDUCTORS: &str = include_str!("data/fresnel_conductor.csv");

const GOLD: Vec3 = Vec3::new(1.0, 0.78, 0.34);

/// A material, seen from a side.
struct Lobe {
    name: String,
    /// The first is seen; it may refer to the others.
    materials: Vec<Material>,
    /// Relative refractive index, instead of entering from vacuum.
    eta: Option<f32>,
    /// What chooses among mixed materials.
    choice: f32,
}

impl Lobe {
    fn with<R>(&self, f: impl FnOnce(&Kernel<'_>) -> R) -> R {
        scene(&self.materials).with_kernel(f)
    }

    fn at(&self, k: &Kernel<'_>, wo: Vec3) -> Bsdf {
        let mut b = k.bsdf_at(0, wo.z, self.choice);
        b.eta = self.eta.unwrap_or(b.eta);
        b
    }

    fn root(&self) -> Material {
        self.materials[0]
    }

    fn transmits(&self, k: &Kernel<'_>) -> bool {
        k.bsdf_transmits(self.at(k, Vec3::Z))
    }

    /// The narrowest α of its coat and base.
    fn narrowest(&self, k: &Kernel<'_>) -> f32 {
        let b = self.at(k, Vec3::Z);
        let of = |x: f32| if x < MIRROR_ALPHA { 1.0 } else { x };
        of(b.alpha.min_element()).min(of(b.coat.x))
    }
}

fn lobe(name: impl Into<String>, materials: &[Material]) -> Lobe {
    Lobe { name: name.into(), materials: materials.to_vec(), eta: None, choice: 0.0 }
}

fn lambert() -> Material {
    diffuse(0.8, 0.0, DIFFUSE_EON)
}

fn diffuses() -> Vec<Lobe> {
    let mut all = Vec::new();
    for (model, name) in [(DIFFUSE_EON, "EON"), (DIFFUSE_FON, "FON"), (DIFFUSE_QON, "QON")] {
        for (roughness, rho) in [(0.0, 0.5), (0.07, 0.9), (0.43, 0.8), (0.68, 1.0), (1.0, 0.2)] {
            all.push(lobe(format!("{name} {rho} of roughness {roughness}"), &[diffuse(rho, roughness, model)]));
        }
    }
    all
}

fn metals() -> Vec<Lobe> {
    let mut all = Vec::new();
    for roughness in [0.0333, 0.05, 0.14, 0.27, 0.5, 0.78, 1.0] {
        for (color, tint) in [(Vec3::ONE, Vec3::ONE), (GOLD, Vec3::new(1.0, 0.9, 0.5)), (GOLD * 0.2, Vec3::splat(0.2))]
        {
            let m = metal(color, tint, widths(roughness, 0.0));
            all.push(lobe(format!("metal {color} with edge {tint} of roughness {roughness}"), &[m]));
        }
    }
    for (roughness, anisotropy) in [(0.2, 0.0), (0.45, 0.0), (1.0, 0.0), (0.3, 0.5), (0.66, 0.9), (1.0, 0.37)] {
        let m = measured(Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603), widths(roughness, anisotropy));
        let name = format!("gold of roughness {roughness}, stretched {anisotropy}");
        all.push(lobe(name.clone(), &[m]));
        all.push(lobe(name + ", compensated", &[compensated(m)]));
    }
    all
}

fn rough_glass(flags: u32) -> Vec<Lobe> {
    let mut all = Vec::new();
    for (ior, roughness) in [(1.5, 0.2), (1.5, 0.63), (1.333, 1.0), (1.03, 0.5), (4.0, 0.4), (2.2, 0.85)] {
        for eta in [ior, 1.0 / ior] {
            let m = glass(ior, roughness, flags);
            all.push(Lobe { eta: Some(eta), ..lobe(format!("glass by {eta} of roughness {roughness}"), &[m]) });
        }
    }
    all
}

fn thin_glass(flags: u32) -> Vec<Lobe> {
    [(1.5, 0.3), (1.9, 0.8)]
        .map(|(ior, roughness)| {
            let m = glass(ior, roughness, DIELECTRIC_THIN | flags);
            lobe(format!("a sheet of {ior}, roughness {roughness}"), &[m])
        })
        .into()
}

fn coated() -> Vec<Lobe> {
    let bronze = compensated(metal(GOLD * 0.6, Vec3::ONE, widths(0.6, 0.4)));
    vec![
        lobe("a coat over diffuse", &[glossy(1.5, 0.35, 1), diffuse(0.7, 0.5, DIFFUSE_EON)]),
        lobe("a rough coat of 2.4 over diffuse", &[glossy(2.4, 0.9, 1), lambert()]),
        lobe("a smooth coat over diffuse", &[glossy(1.5, 0.0, 1), lambert()]),
        lobe("a coat over metal", &[glossy(1.6, 0.25, 1), bronze]),
        lobe("a coat over glass", &[glossy(1.4, 0.5, 1), glass(1.7, 0.4, COMPENSATE)]),
        Lobe {
            eta: Some(1.0 / 1.7),
            ..lobe("a coat over glass, from inside", &[glossy(1.4, 0.5, 1), glass(1.7, 0.4, COMPENSATE)])
        },
        lobe("a coat over a coat, which reflects", &[glossy(1.5, 0.6, 1), glossy(1.7, 0.4, 2), lambert()]),
        Lobe {
            choice: 0.999,
            ..lobe("a coat over a coat, which lets through", &[glossy(1.5, 0.6, 1), glossy(1.7, 0.4, 2), lambert()])
        },
    ]
}

/// The fibres themselves, as heavy as they are where they are chosen.
fn cloth() -> Vec<Lobe> {
    let shines = |name: &str, materials: &[Material]| Lobe { choice: 0.999, ..lobe(name, materials) };
    vec![
        shines("fibres", &[fibres(Vec3::ONE, 0.3, 1), lambert()]),
        shines("coloured fibres", &[fibres(GOLD, 0.6, 1), lambert()]),
        shines("rough fibres under a coat", &[glossy(1.5, 0.3, 1), fibres(Vec3::ONE, 1.0, 2), lambert()]),
    ]
}

fn lobes() -> Vec<Lobe> {
    let mut all = diffuses();
    all.extend(cloth());
    all.extend(metals());
    for flags in [0, COMPENSATE] {
        all.extend(rough_glass(flags));
        all.extend(thin_glass(flags));
    }
    all.extend(coated());
    all
}

/// Above the surface, more often grazing than by chance.
fn above(random: &mut Random) -> Vec3 {
    let z = f64::from(random.within(0.03, 1.0));
    direction(z * z, f64::from(random.within(0.0, std::f32::consts::TAU)))
}

#[test]
fn samples_follow_the_density() {
    // Lobes that bins can hold, each at a cosine of its own.
    // Light that is hardly bent stays close together.
    let bent = |lobe: &Lobe| lobe.eta.is_none_or(|eta| (eta - 1.0).abs() > 0.1);
    let held = |lobe: &Lobe| lobe.with(|k| lobe.narrowest(k)) > 0.05 && bent(lobe);
    let coloured = |lobe: &Lobe| lobe.root().kind.x == MATERIAL_METAL && lobe.root().color.y < 0.3;
    let all: Vec<Lobe> = lobes().into_iter().filter(|lobe| held(lobe) && !coloured(lobe)).collect();
    let tests = 2 * all.len();
    let mut least = 1.0_f64;
    for (i, lobe) in all.iter().enumerate() {
        lobe.with(|k| {
            let mu = [0.9, 0.06, 0.35, 0.62, 1.0][i % 5];
            let wo = direction(mu, 2.0);
            let b = lobe.at(k, wo);
            let mut random = Random(i as u64);
            // So few bins that a pdf wrong by 2 % in one half is seen.
            let bins = if lobe.transmits(k) {
                SphereBins { z_low: -1.0, rows: 16, columns: 16, jumps: false, off: 3e-3 }
            } else {
                SphereBins { z_low: 0.0, rows: 12, columns: 16, jumps: false, off: 0.0 }
            };
            let name = format!("{} at cosine {mu}", lobe.name);
            let draw = || {
                let s = k.bsdf_sample(b, wo, random.square(), random.unit());
                (s.pdf > 0.0).then_some(s.wi)
            };
            let (observed, expected) = bins.check(&name, tests, 600_000, draw, |wi| f64::from(k.bsdf_pdf(b, wo, wi)));
            least = least.min(expected.iter().sum::<f64>() / 600_000.0);
            // What all falls into a few bins says nothing about halves.
            if expected.iter().copied().fold(0.0, f64::max) < 0.05 * 600_000.0 {
                check_rejects(&name, tests, &observed, &expected);
            }
        });
    }
    println!("{} lobes; the least that a density integrates to is {least}", all.len());
}

#[test]
fn samples_agree_with_eval_and_pdf() {
    let mut failures = Vec::new();
    for lobe in lobes() {
        lobe.with(|k| {
            let mut random = Random(3);
            let mut worst = (0.0_f32, String::new());
            let mut checked = 0;
            for _ in 0..10_000 {
                let wo = above(&mut random);
                let b = lobe.at(k, wo);
                let s = k.bsdf_sample(b, wo, random.square(), random.unit());
                if s.pdf == 0.0 {
                    continue;
                }
                let name = &lobe.name;
                assert!(s.wi.is_finite() && s.weight.is_finite() && s.weight.min_element() >= 0.0, "{name}: {s:?}");
                assert!((s.wi.length() - 1.0).abs() < 1e-5, "{name}: {} is no unit vector", s.wi);
                assert!(s.wi.z > 0.0 || k.bsdf_transmits(b), "{name}: {s:?}");
                assert_eq!(s.eta, if s.wi.z > 0.0 || k.is_thin(b) { 1.0 } else { b.eta }, "{name}: {s:?}");
                if s.pdf == DELTA_PDF {
                    continue;
                }
                if s.wi.z.abs().min(wo.z) < 0.01 {
                    continue;
                }
                checked += 1;
                let pdf = k.bsdf_pdf(b, wo, s.wi);
                let weight = k.bsdf_eval(b, wo, s.wi) / pdf;
                let width = lobe.narrowest(k);
                let straight = if s.wi.z < 0.0 { (wo + s.wi * b.eta).length() } else { 1.0 };
                let slack = 1e-4 + rounding(width, wo, s.wi) / straight;
                let error = (s.pdf / pdf - 1.0).abs() / slack;
                let error =
                    error.max((weight - s.weight).abs().max_element() / (1e-4 * s.weight.max_element().max(1.0)));
                if error > worst.0 || error.is_nan() {
                    worst = (error, format!("pdf {pdf}, weight {weight} of {wo} to {s:?}"));
                }
            }
            assert!(checked > 1000, "{}: {checked} checked", lobe.name);
            if worst.0 > 1.0 || worst.0.is_nan() {
                failures.push((lobe.name.clone(), worst));
            }
        });
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Directions are given to 6e-8, which is that much of the lobe's width: relative error of a density.
fn rounding(alpha: f32, wo: Vec3, wi: Vec3) -> f32 {
    4e-7 / (alpha * Vec3::new(wo.x + wi.x, wo.y + wi.y, wo.z + wi.z.abs()).length())
}

#[test]
fn no_sample_of_a_single_lobe_weighs_more_than_it_reflects() {
    let single = |m: &Material| m.kind.x == MATERIAL_METAL && m.kind.y & COMPENSATE == 0;
    let metals = metals().into_iter().filter(|lobe| single(&lobe.root()));
    for lobe in metals.chain(rough_glass(0)).chain(thin_glass(0)) {
        lobe.with(|k| {
            let mut random = Random(5);
            for _ in 0..5_000 {
                let wo = above(&mut random);
                let s = k.bsdf_sample(lobe.at(k, wo), wo, random.square(), random.unit());
                // Radiance is squeezed at a refraction, energy is not.
                let weight = s.weight.max_element() * s.eta * s.eta;
                assert!(s.pdf == 0.0 || weight <= 1.0 + 2e-4, "{}: {weight}, {s:?} of {wo}", lobe.name);
            }
        });
    }
}

#[test]
fn eval_is_reciprocal() {
    for lobe in diffuses().into_iter().chain(metals()) {
        lobe.with(|k| {
            let mut random = Random(4);
            for _ in 0..3_000 {
                let (a, b) = (above(&mut random), above(&mut random));
                let ab = k.bsdf_eval(lobe.at(k, a), a, b) / b.z;
                let ba = k.bsdf_eval(lobe.at(k, b), b, a) / a.z;
                let scale = ab.abs().max_element().max(1e-20);
                assert!((ab - ba).abs().max_element() <= 2e-4 * scale, "{}: {ab} but {ba} for {a} {b}", lobe.name);
            }
        });
    }
    // Compensated glass is not: it is divided by what is kept of light from one of the two directions.
    for lobe in rough_glass(0) {
        lobe.with(|k| {
            let mut random = Random(6);
            let mut through = 0;
            for _ in 0..6_000 {
                let wo = above(&mut random);
                let b = lobe.at(k, wo);
                let s = k.bsdf_sample(b, wo, random.square(), random.unit());
                if s.pdf == 0.0 || s.wi.z.abs().min(wo.z) < 0.02 {
                    continue;
                }
                // The frame of the other side is turned about x.
                let crossed = s.wi.z < 0.0;
                let turned = |w: Vec3| if crossed { Vec3::new(w.x, -w.y, -w.z) } else { w };
                let mut back = b;
                back.eta = if crossed { 1.0 / b.eta } else { b.eta };
                let there = k.bsdf_eval(b, wo, s.wi).x / s.wi.z.abs();
                let here = k.bsdf_eval(back, turned(s.wi), turned(wo)).x / wo.z;
                let here = if crossed { here / (b.eta * b.eta) } else { here };
                through += usize::from(crossed);
                let straight = if crossed { (wo + s.wi * b.eta).length() } else { 1.0 };
                let slack = if crossed { 3e-3 } else { 5e-4 } + 1e-5 / straight;
                // Next to the critical angle the reflectance has no slope.
                if (there - here).abs() > slack * there.max(here) {
                    let m = k.refracting_facet(wo, s.wi, b.eta);
                    let critical = 1.0 - (1.0 - wo.dot(m).powi(2)) / (b.eta * b.eta);
                    assert!(crossed && critical < 1e-3, "{}: {there} but {here} for {wo} {}", lobe.name, s.wi);
                }
            }
            assert!(through > 40, "{}: {through} refracted", lobe.name);
        });
    }
}

#[test]
fn nothing_comes_from_below_what_is_opaque() {
    for lobe in diffuses().into_iter().chain(metals()).chain(coated()) {
        lobe.with(|k| {
            for (wo, wi) in [(Vec3::Z, -Vec3::Z), (-Vec3::Z, Vec3::Z), (Vec3::Z, Vec3::X), (Vec3::X, Vec3::Z)] {
                if lobe.transmits(k) {
                    continue;
                }
                let b = lobe.at(k, wo);
                assert_eq!(k.bsdf_eval(b, wo, wi), Vec3::ZERO, "{}: eval of {wo} {wi}", lobe.name);
                assert_eq!(k.bsdf_pdf(b, wo, wi), 0.0, "{}: pdf of {wo} {wi}", lobe.name);
            }
        });
    }
}

const BATCH: u32 = 40_000;

/// How often that which a batch never meets may occur: directions that the far tail of a narrow lobe loses.
const UNSEEN: f64 = 7.0 / BATCH as f64;

/// What is reflected and what is refracted (as energy), by samples until the error is small enough to prove something.
fn split_by_sampling(lobe: &Lobe, mu: f64, seed: u64, uncertainty: f64) -> [Mean; 3] {
    let wo = direction(mu, 0.7);
    let mut random = Random(seed);
    let mut means = [Mean::default(); 3];
    lobe.with(|k| {
        let b = lobe.at(k, wo);
        for _ in 0..50 {
            for _ in 0..BATCH {
                let s = k.bsdf_sample(b, wo, random.square(), random.unit());
                let weight = if s.pdf == 0.0 { 0.0 } else { f64::from(s.weight.x) * f64::from(s.eta).powi(2) };
                let up = s.wi.z > 0.0;
                means[0].add(if up { weight } else { 0.0 });
                means[1].add(if up { 0.0 } else { weight });
                means[2].add(weight);
            }
            if means[2].error() <= uncertainty * means[2].mean() {
                break;
            }
        }
    });
    means
}

fn albedo_by_sampling(lobe: &Lobe, mu: f64, seed: u64) -> Mean {
    split_by_sampling(lobe, mu, seed, 0.0018)[2]
}

fn albedo_by_quadrature(k: &Kernel<'_>, lobe: &Lobe, mu: f64) -> f64 {
    const PANELS: u32 = 8;
    let wo = direction(mu, 0.0);
    let b = lobe.at(k, wo);
    let rule = gauss(6);
    let side = 1.0 / f64::from(PANELS);
    let mut sum = 0.0;
    for i in 0..PANELS {
        for j in 0..PANELS {
            let low = [f64::from(i) * side, f64::from(j) * side * PI];
            let high = [low[0] + side, low[1] + side * PI];
            // z = t² spreads the grazing directions.
            sum += integrate(&rule, low, high, [1e-6, 1e-8], &mut |t, phi| {
                2.0 * t * f64::from(k.bsdf_eval(b, wo, direction(t * t, phi)).x)
            });
        }
    }
    2.0 * sum
}

#[test]
fn diffuse_albedo_is_the_tables() {
    let table: Vec<_> = rows(DIFFUSE_ALBEDO).collect();
    assert_eq!(table.len(), 360);
    for (i, row) in table.iter().enumerate() {
        let model = match row[0] {
            "EON" => DIFFUSE_EON,
            "FON" => DIFFUSE_FON,
            _ => DIFFUSE_QON,
        };
        let [roughness, rho, mu, want] = [1, 2, 3, 4].map(|i| number(row[i]));
        // QON is told of σ, by its share of a right angle.
        let roughness = if model == DIFFUSE_QON { roughness / (0.5 * PI) } else { roughness };
        let lobe = lobe(format!("{row:?}"), &[diffuse(rho as f32, roughness as f32, model)]);
        albedo_by_sampling(&lobe, mu, i as u64).check(&lobe.name, table.len(), want, 1e-5 + UNSEEN, 2e-3);
        if mu == 0.1 || mu == 0.5 {
            let got = lobe.with(|k| albedo_by_quadrature(k, &lobe, mu));
            assert!((got - want).abs() < 2e-5, "{}: {got} by quadrature, but should be {want}", lobe.name);
        }
    }
}

fn white(roughness: f64, anisotropy: f64) -> Material {
    metal(Vec3::ONE, Vec3::ONE, widths(roughness as f32, anisotropy as f32))
}

#[test]
fn metal_albedo_is_the_tables() {
    let table: Vec<_> = rows(GGX_ALBEDO).filter(|r| r[1] != "avg").map(|r| [0, 1, 2].map(|i| number(r[i]))).collect();
    for (i, &[roughness, mu, want]) in table.iter().enumerate() {
        let lobe = lobe(format!("metal of roughness {roughness} at {mu}"), &[white(roughness, 0.0)]);
        albedo_by_sampling(&lobe, mu, i as u64).check(&lobe.name, table.len(), want, 1e-5 + UNSEEN, 2e-3);
        if roughness >= 0.4 && (mu == 0.1 || mu == 0.5 || mu == 1.0) {
            let got = lobe.with(|k| albedo_by_quadrature(k, &lobe, mu));
            assert!((got - want).abs() < 1e-4, "{}: {got} by quadrature, but should be {want}", lobe.name);
        }
    }
}

#[test]
fn rough_glass_splits_light_as_the_tables() {
    let table: Vec<_> = rows(ROUGH_DIELECTRIC).collect();
    for (i, row) in table.iter().enumerate() {
        let [ior, roughness, mu, reflected, refracted] = [0, 2, 3, 4, 5].map(|i| number(row[i]));
        let eta = if row[1] == "enter" { ior } else { 1.0 / ior } as f32;
        let m = glass(ior as f32, roughness as f32, 0);
        let lobe = Lobe { eta: Some(eta), ..lobe(format!("{row:?}"), &[m]) };
        let means = split_by_sampling(&lobe, mu, i as u64, 2e-3);
        for (mean, want) in means.iter().zip([reflected, refracted]) {
            mean.check(&lobe.name, 2 * table.len(), want, 4e-4 + UNSEEN, 2e-2 + 2e-3 / want.max(1e-9));
        }
    }
}

#[test]
fn compensated_lobes_keep_all() {
    let mut random = Random(20);
    let mut all = Vec::new();
    for (i, roughness) in
        [0.04, 0.08, 0.13, 0.21, 0.29, 0.37, 0.46, 0.55, 0.64, 0.73, 0.81, 0.92, 1.0].iter().enumerate()
    {
        all.push(lobe(format!("metal of roughness {roughness}"), &[compensated(white(*roughness, 0.0))]));
        let anisotropy = f64::from(random.within(0.1, 1.0));
        let m = compensated(white(*roughness, anisotropy));
        all.push(lobe(format!("metal of roughness {roughness} stretched {anisotropy}"), &[m]));
        let ior = [1.07, 1.2, 1.45, 1.5, 1.9, 3.0][i % 6];
        let m = glass(ior, *roughness as f32, COMPENSATE);
        for eta in [ior, 1.0 / ior] {
            all.push(Lobe { eta: Some(eta), ..lobe(format!("glass by {eta} of roughness {roughness}"), &[m]) });
        }
        let m = glass(ior, *roughness as f32, COMPENSATE | DIELECTRIC_THIN);
        all.push(lobe(format!("a sheet of {ior} of roughness {roughness}"), &[m]));
        let coat = glossy(ior, *roughness as f32, 1);
        all.push(lobe(format!("a coat of {ior} and roughness {roughness}"), &[coat, diffuse(1.0, 0.3, DIFFUSE_EON)]));
    }
    let tests = 4 * all.len();
    let mut worst = (0.0_f64, String::new());
    let mut failures = Vec::new();
    for (i, lobe) in all.iter().enumerate() {
        for mu in [0.05, 0.3, 0.68, 1.0] {
            let name = format!("{} at {mu}", lobe.name);
            let mean = split_by_sampling(lobe, mu, i as u64, 0.001)[2];
            let off = (mean.mean() - 1.0).abs();
            let slack = 0.003 + common::sigmas(tests) * mean.error();
            assert!(mean.error() < 0.0015, "{name}: an error of {} proves nothing", mean.error());
            if off > slack {
                failures.push(format!("{name}: {} ± {}", mean.mean(), mean.error()));
            }
            if off > worst.0 {
                worst = (off, name);
            }
        }
    }
    println!("{} lobes; farthest from 1: {worst:?}", all.len());
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn white_diffuse_keeps_all_and_none_gain() {
    for mu in [0.01, 0.2, 0.6, 0.95] {
        for roughness in [0.05, 0.33, 0.75, 1.0] {
            let lobe = lobe("EON", &[diffuse(1.0, roughness, DIFFUSE_EON)]);
            let got = lobe.with(|k| albedo_by_quadrature(k, &lobe, mu));
            assert!((got - 1.0).abs() < 1e-4, "roughness {roughness} at {mu}: {got}");
        }
        for roughness in [0.35, 0.63, 0.95] {
            for tint in [Vec3::ONE, Vec3::splat(0.3)] {
                let m = metal(Vec3::splat(0.95), tint, widths(roughness, 0.0));
                for lobe in [lobe("metal", &[m]), lobe("metal, compensated", &[compensated(m)])] {
                    let got = lobe.with(|k| albedo_by_quadrature(k, &lobe, mu));
                    assert!(got <= 1.0 + 2e-3, "{} of roughness {roughness} at {mu}: {got}", lobe.name);
                }
            }
        }
    }
}

fn diffuse_exact(model: u32, rho: f64, r: f64, wo: DVec3, wi: DVec3) -> f64 {
    let s = wi.dot(wo) - wi.z * wo.z;
    if model == DIFFUSE_QON {
        let s2 = (r * 0.5 * PI).powi(2);
        let (a, b) = (1.0 - 0.5 * s2 / (s2 + 0.33), 0.45 * s2 / (s2 + 0.09));
        return rho / PI * (a + b * s.max(0.0) / wi.z.max(wo.z)) * wi.z;
    }
    let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let albedo = |mu: f64| {
        let s = (1.0 - mu * mu).max(0.0).sqrt();
        let g = s * (mu.acos() - s * mu) + 2.0 / 3.0 * (s / mu * (1.0 - s * s * s) - s);
        a * (1.0 + r / PI * g)
    };
    let average = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    let t = if s > 0.0 { s / wi.z.max(wo.z) } else { s };
    let rho_ms = rho * rho * average / (1.0 - rho * (1.0 - average));
    let many = r > 0.0 && model == DIFFUSE_EON;
    let lost = if many { (1.0 - albedo(wi.z)) * (1.0 - albedo(wo.z)) / (1.0 - average) } else { 0.0 };
    (rho * a * (1.0 + r * t) + rho_ms * lost) / PI * wi.z
}

/// D and height-correlated G2 over 4 cos θo, and the facet.
fn microfacets(alpha: [f64; 2], wo: DVec3, wi: DVec3) -> (f64, DVec3) {
    let h = (wo + wi).normalize();
    let d =
        1.0 / (PI * alpha[0] * alpha[1] * ((h.x / alpha[0]).powi(2) + (h.y / alpha[1]).powi(2) + h.z * h.z).powi(2));
    (d * shadowing(alpha, wo, wi) / (4.0 * wo.z), h)
}

fn shadowing([ax, ay]: [f64; 2], wo: DVec3, wi: DVec3) -> f64 {
    let lambda = |w: DVec3| 0.5 * ((1.0 + ((ax * w.x).powi(2) + (ay * w.y).powi(2)) / (w.z * w.z)).sqrt() - 1.0);
    1.0 / (1.0 + lambda(wo) + lambda(wi))
}

fn f82(color: f64, tint: f64, c: f64) -> f64 {
    let schlick = |c: f64| color + (1.0 - color) * (1.0 - c).powi(5);
    let c82: f64 = 1.0 / 7.0;
    let edge = schlick(c82) * (1.0 - tint) / (c82 * (1.0 - c82).powi(6));
    (schlick(c) - edge * c * (1.0 - c).powi(6)).clamp(0.0, 1.0)
}

/// By g = √(η² − 1 + c²), unlike the kernel.
fn fresnel(c: f64, eta: f64) -> f64 {
    let g = eta * eta - 1.0 + c * c;
    if g <= 0.0 {
        return 1.0;
    }
    let g = g.sqrt();
    let (p, q) = ((g - c) / (g + c), (c * (g + c) - 1.0) / (c * (g - c) + 1.0));
    0.5 * p * p * (1.0 + q * q)
}

fn glass_exact(alpha: f64, eta: f64, wo: DVec3, wi: DVec3) -> f64 {
    if wi.z > 0.0 {
        let (f, h) = microfacets([alpha; 2], wo, wi);
        return fresnel(wo.dot(h), eta) * f;
    }
    let m = (wo + eta * wi).normalize();
    let m = if m.dot(wo) < 0.0 { -m } else { m };
    let (om, im) = (wo.dot(m), wi.dot(m));
    let d = 1.0 / (PI * alpha * alpha * ((1.0 - m.z * m.z) / (alpha * alpha) + m.z * m.z).powi(2));
    let energy = (1.0 - fresnel(om, eta)) * d * shadowing([alpha; 2], wo, wi) * im.abs() * om.abs()
        / (wo.z * (im + om / eta).powi(2));
    energy / (eta * eta)
}

fn unit(w: Vec3) -> DVec3 {
    w.as_dvec3().normalize()
}

#[test]
fn diffuse_is_the_formula() {
    let mut random = Random(8);
    for i in 0..600 {
        let (rho, r, model) = (random.unit(), random.unit(), i % 3);
        lobe("diffuse", &[diffuse(rho, r, model)]).with(|k| {
            for _ in 0..100 {
                let (wo, wi) = (above(&mut random), above(&mut random));
                let got = f64::from(k.bsdf_eval(k.bsdf_at(0, wo.z, 0.0), wo, wi).y);
                let want = diffuse_exact(model, rho.into(), r.into(), unit(wo), unit(wi));
                assert!((got - want).abs() <= 2e-5 * want + 2e-7, "{model} {rho} {r}: {got}, not {want}: {wo} {wi}");
            }
        });
    }
}

/// Compares where the lobe is: in the directions that are sampled.
#[track_caller]
fn check_formula(lobe: &Lobe, seed: u64, exact: impl Fn(&Kernel<'_>, Bsdf, DVec3, DVec3) -> f64) {
    lobe.with(|k| {
        let mut random = Random(seed);
        for _ in 0..4_000 {
            let wo = direction(f64::from(random.within(0.1, 1.0)), f64::from(random.within(0.0, 6.3)));
            let b = lobe.at(k, wo);
            let s = k.bsdf_sample(b, wo, random.square() * 0.98 + 0.01, random.unit());
            if s.pdf <= 0.0 || s.wi.z.abs() < 0.05 {
                continue;
            }
            let got = f64::from(k.bsdf_eval(b, wo, s.wi).x);
            let want = exact(k, b, unit(wo), unit(s.wi));
            let straight = if s.wi.z < 0.0 { (wo + s.wi * b.eta).length() } else { 1.0 };
            let slack = 3e-4 + f64::from((rounding(lobe.narrowest(k), wo, s.wi) + 1e-6) / straight);
            let name = &lobe.name;
            assert!((got - want).abs() <= slack * want, "{name}: {got}, not {want} ± {slack}, for {wo} to {}", s.wi);
        }
    });
}

#[test]
fn metal_is_the_formula() {
    let mut random = Random(9);
    let averages: Vec<[f64; 2]> =
        rows(GGX_ALBEDO).filter(|r| r[1] == "avg").map(|r| [0, 2].map(|i| number(r[i]))).collect();
    for i in 0..60 {
        let [roughness, average] = averages[i % averages.len()];
        let anisotropy = if i % 2 == 0 { 0.0 } else { f64::from(random.within(0.0, 0.95)) };
        let (color, tint) = (random.within(0.2, 1.0), random.within(0.2, 1.0));
        let alpha = albedo::alphas(roughness, anisotropy);
        let m = metal(Vec3::splat(color), Vec3::splat(tint), widths(roughness as f32, anisotropy as f32));
        let single = move |wo: DVec3, wi: DVec3| {
            let (f, h) = microfacets(alpha, wo, wi);
            f * f82(color.into(), tint.into(), wo.dot(h))
        };
        check_formula(&lobe(format!("{m:?}"), &[m]), i as u64, |_, _, wo, wi| single(wo, wi));
        if anisotropy > 0.0 || roughness < 0.2 {
            continue;
        }
        // Kulla and Conty's sum, with the hemisphere's average of a published table.
        let favg = (20.0 * f64::from(color) + 1.0) / 21.0 - f64::from(m.extra.x) / 126.0;
        let fms = favg * favg * average / (1.0 - favg * (1.0 - average));
        let lobe = lobe(format!("compensated {m:?}"), &[compensated(m)]);
        lobe.with(|k| {
            for _ in 0..1000 {
                let (wo, wi) = (above(&mut random), above(&mut random));
                let b = lobe.at(k, wo);
                let lost = |w: Vec3| 1.0 - f64::from(k.metal_albedo(w.z, roughness as f32));
                let many = fms * lost(wo) * lost(wi) / (PI * (1.0 - average)) * f64::from(wi.z);
                let (got, want) = (f64::from(k.bsdf_eval(b, wo, wi).x), single(unit(wo), unit(wi)) + many);
                assert!(
                    (got - want).abs() <= (3e-3 + 7e-4 / (1.0 - average)) * many + 2e-4 * want,
                    "{}: {got}, not {want}",
                    lobe.name
                );
            }
        });
    }
}

#[test]
fn rough_glass_is_the_formula() {
    for (i, lobe) in rough_glass(0).iter().enumerate() {
        let alpha = f64::from(lobe.root().lobe.x);
        check_formula(lobe, i as u64, |_, b, wo, wi| glass_exact(alpha, b.eta.into(), wo, wi));
    }
    for (i, lobe) in rough_glass(COMPENSATE).iter().enumerate() {
        let m = lobe.root();
        check_formula(lobe, i as u64, |k, b, wo, wi| {
            let kept = k.boundary_total(wo.z as f32, m.lobe.z, b.eta);
            glass_exact(m.lobe.x.into(), b.eta.into(), wo, wi) / f64::from(kept)
        });
    }
    for (i, lobe) in thin_glass(0).iter().enumerate() {
        let m = lobe.root();
        check_formula(lobe, i as u64, |_, _, wo, wi| {
            let (f, h) = microfacets([f64::from(m.lobe.x); 2], wo, DVec3::new(wi.x, wi.y, wi.z.abs()));
            let one = fresnel(wo.dot(h), m.extra.w.into());
            let all = 2.0 * one / (1.0 + one);
            if wi.z > 0.0 { all * f } else { (1.0 - all) * f }
        });
    }
}

#[test]
fn a_coat_is_the_formula() {
    let (ior, roughness, rho, r) = (1.6_f32, 0.55_f32, 0.7_f32, 0.4_f32);
    let alpha = f64::from(roughness * roughness);
    let lobe = lobe("a coat", &[glossy(ior, roughness, 1), diffuse(rho, r, DIFFUSE_EON)]);
    check_formula(&lobe, 1, |_, _, wo, wi| {
        let (f, h) = microfacets([alpha; 2], wo, wi);
        let [covered, _] = albedo::boundary_albedo(wo.z, alpha, ior.into());
        let base = diffuse_exact(DIFFUSE_EON, rho.into(), r.into(), wo, wi);
        fresnel(wo.dot(h), ior.into()) * f + (1.0 - covered) * base
    });
}

#[test]
fn conductors_reflect_as_the_table() {
    Packed::empty().with_kernel(|k| {
        let mut checked = 0;
        for row in rows(CONDUCTORS) {
            let [n, kappa, mu, want] = [1, 2, 3, 4].map(|i| number(row[i]));
            let got = f64::from(k.conductor_fresnel(n as f32, kappa as f32, mu as f32));
            assert!((got - want).abs() < 5e-6, "{row:?}: {got}");
            checked += 1;
        }
        assert_eq!(checked, 81);
    });
}

#[test]
fn mirrors_reflect() {
    let mut random = Random(9);
    for alpha in [0.0, 1e-5, MIRROR_ALPHA.next_down()] {
        let lobe = lobe("mirror", &[metal(GOLD, Vec3::splat(0.7), Vec4::new(alpha, alpha, alpha.sqrt(), 0.0))]);
        lobe.with(|k| {
            for _ in 0..1000 {
                let wo = above(&mut random);
                let b = lobe.at(k, wo);
                assert!(k.bsdf_is_delta(b));
                let s = k.bsdf_sample(b, wo, random.square(), random.unit());
                assert_eq!(s.wi, Vec3::new(-wo.x, -wo.y, wo.z));
                assert_eq!((s.pdf, s.eta), (DELTA_PDF, 1.0));
                assert_eq!(s.weight, k.metal_fresnel(b, wo.z));
                assert_eq!(k.bsdf_eval(b, wo, s.wi), Vec3::ZERO, "eval of alpha {alpha} at {wo}");
                assert_eq!(k.bsdf_pdf(b, wo, s.wi), 0.0, "pdf of alpha {alpha} at {wo}");
            }
        });
    }
    let delta = |materials: &[Material]| scene(materials).with_kernel(|k| k.bsdf_is_delta(k.bsdf_at(0, 0.5, 0.0)));
    let narrow = Vec4::new(MIRROR_ALPHA, MIRROR_ALPHA, MIRROR_ALPHA.sqrt(), 0.0);
    assert!(!delta(&[metal(GOLD, Vec3::ONE, narrow)]));
    assert!(!delta(&[lambert()]));
    assert!(delta(&[glass(1.5, 0.0, 0)]));
    assert!(delta(&[glossy(1.5, 0.0, 1), glass(1.5, 0.0, 0)]));
    assert!(!delta(&[glossy(1.5, 0.0, 1), lambert()]));
    assert!(!delta(&[glossy(1.5, 0.3, 1), glass(1.5, 0.0, 0)]));
}

#[test]
fn metal_fresnel_has_its_colours() {
    let tint = Vec3::new(1.0, 0.6, 0.0);
    scene(&[metal(GOLD, tint, widths(0.4, 0.0))]).with_kernel(|k| {
        let b = k.bsdf_at(0, 1.0, 0.0);
        let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-6;
        assert!(near(k.metal_fresnel(b, 1.0), GOLD));
        assert!(near(k.metal_fresnel(b, 0.0), Vec3::ONE));
        let schlick = GOLD + (Vec3::ONE - GOLD) * 0.462_664_36;
        assert!(near(k.metal_fresnel(b, 1.0 / 7.0), schlick * tint), "{}", k.metal_fresnel(b, 1.0 / 7.0));
        for i in 0..=1000 {
            let f = k.metal_fresnel(b, i as f32 / 1000.0);
            assert!(f.min_element() >= 0.0 && f.max_element() <= 1.0, "{f}");
        }
    });
}

#[test]
fn fibres_take_from_what_is_beneath_what_they_send_back() {
    // Over white, fibres and base together send back everything.
    for (roughness, mu) in [(0.2, 0.9), (0.3, 0.15), (0.5, 0.5), (0.8, 0.05), (1.0, 0.7)] {
        let packed = scene(&[fibres(Vec3::ONE, roughness, 1), diffuse(1.0, 0.0, DIFFUSE_EON)]);
        packed.with_kernel(|k| {
            let own = albedo::sheen(k, mu, roughness.into());
            let share = f64::from(k.sheen_albedo(mu as f32, roughness));
            assert!((own - share).abs() < 4e-3, "roughness {roughness}, cosine {mu}: {own} and {share}");
            let chosen = (0..1000).filter(|i| k.bsdf_at(0, mu as f32, *i as f32 / 1000.0).kind == MATERIAL_SHEEN);
            assert!(
                (chosen.count() as f64 / 1000.0 - share.min(1.0)).abs() < 2e-3,
                "roughness {roughness}, cosine {mu}"
            );
        });
    }
}
