//! Smooth glass: reflectances against a table, refraction against Snell.

mod common;

use common::{Random, direction, glass, number, rows, scene};
use glam::{Vec2, Vec3};
use kinora_kernel::generated::{Bsdf, DELTA_PDF, DIELECTRIC_THIN};
use kinora_kernel::{Kernel, Packed};

const FRESNEL: &str = include_str!("data/fresnel_dielectric.csv");
const IORS: [f32; 5] = [1.0, 1.05, 1.333, 1.5, 4.0];

fn with(f: impl FnOnce(&Kernel<'_>)) {
    Packed::empty().with_kernel(f);
}

/// Smooth glass of relative index `eta`.
fn smooth(eta: f32, flags: u32) -> Bsdf {
    scene(&[glass(eta, 0.0, flags)]).with_kernel(|k| k.bsdf_at(0, 1.0, 0.0))
}

#[test]
fn reflectance_is_the_tables() {
    with(|k| {
        let mut checked = 0;
        for row in rows(FRESNEL) {
            let (ior, angle, want) = (number(row[0]), number(row[2]).to_radians(), number(row[6]));
            let eta = if row[1] == "enter" { ior } else { 1.0 / ior };
            let got = f64::from(k.dielectric_fresnel(angle.cos() as f32, eta as f32));
            // At the critical angle the slope is infinite: a rounded cosine tells it to 1e-2.
            let tolerance = if row[3] == "critical" { 1e-2 } else { 2e-6 };
            assert!((got - want).abs() < tolerance, "{row:?}: {got}");
            checked += 1;
        }
        assert!(checked > 150, "{checked} rows");
    });
}

#[test]
fn no_parallel_light_at_brewsters_angle() {
    with(|k| {
        for row in rows(FRESNEL).filter(|row| row[3] == "brewster") {
            assert!(number(row[5]) < 1e-9, "{row:?}");
            let (ior, angle) = (number(row[0]), number(row[2]).to_radians());
            let eta = if row[1] == "enter" { ior } else { 1.0 / ior };
            let got = f64::from(k.dielectric_fresnel(angle.cos() as f32, eta as f32));
            assert!((got - 0.5 * number(row[4])).abs() < 1e-6, "{row:?}: {got}");
        }
    });
}

#[test]
fn ends_of_the_reflectance() {
    with(|k| {
        for ior in IORS {
            let normal = ((ior - 1.0) / (ior + 1.0)).powi(2);
            for eta in [ior, 1.0 / ior] {
                assert!((k.dielectric_fresnel(1.0, eta) - normal).abs() < 1e-6);
            }
            if ior > 1.0 {
                assert!((k.dielectric_fresnel(0.0, ior) - 1.0).abs() < 1e-6);
                let critical = (1.0 - 1.0 / (ior * ior)).sqrt();
                for part in [0.0, 0.3, 0.9, 0.999] {
                    assert_eq!(k.dielectric_fresnel(part * critical, 1.0 / ior), 1.0, "total reflection in {ior}");
                }
            }
        }
    });
}

#[test]
fn samples_are_split_by_reflectance() {
    const STEPS: u32 = 1 << 16;
    with(|k| {
        for ior in IORS {
            for front in [true, false] {
                let eta = if front { ior } else { 1.0 / ior };
                let b = smooth(eta, 0);
                for i in 1..=40 {
                    let wo = direction(f64::from(i) / 40.0, 2.0);
                    let sample = |u| k.bsdf_sample(b, wo, Vec2::new(u, 0.3), 0.7);
                    let reflected = (0..STEPS).filter(|&i| sample(i as f32 / STEPS as f32).wi.z > 0.0).count();
                    let want = f64::from(k.dielectric_fresnel(wo.z, eta)) * f64::from(STEPS);
                    assert!((reflected as f64 - want).abs() <= 1.0, "{reflected} not {want} at {} in {ior}", wo.z);
                }
            }
        }
    });
}

#[test]
fn samples_obey_snell_and_reverse() {
    let both = IORS.map(|ior| [1.0 / ior, ior].map(|eta| smooth(eta, 0)));
    with(|k| {
        let mut random = Random(1);
        let mut refracted = 0;
        for _ in 0..100_000 {
            let which = (random.bits() % 5) as usize;
            let ior = IORS[which];
            let front = random.bits().is_multiple_of(2);
            let b = both[which][usize::from(front)];
            let wo =
                direction(f64::from(random.within(1e-3, 1.0)), f64::from(random.within(0.0, std::f32::consts::TAU)));
            let s = k.bsdf_sample(b, wo, random.square(), random.unit());
            assert_eq!(s.pdf, DELTA_PDF);
            if s.wi.z > 0.0 {
                assert_eq!((s.wi, s.weight, s.eta), (Vec3::new(-wo.x, -wo.y, wo.z), Vec3::ONE, 1.0));
                continue;
            }
            refracted += 1;
            let eta = if front { ior } else { 1.0 / ior };
            assert_eq!(s.eta, eta);
            assert!((s.wi.length() - 1.0).abs() < 1e-6, "{} is no unit vector", s.wi);
            let snell = s.wi.truncate() * eta + wo.truncate();
            assert!(snell.abs().max_element() < 1e-6, "{wo} to {} in {ior}", s.wi);
            assert!((s.weight * eta * eta - Vec3::ONE).abs().max_element() < 1e-6, "{}", s.weight);

            // Back the way it came, seen from the other side: the frame is turned about x.
            let turned = |w: Vec3| Vec3::new(w.x, -w.y, -w.z);
            let there = both[which][usize::from(!front)];
            let back = k.bsdf_sample(there, turned(s.wi), Vec2::new(1.0_f32.next_down(), 0.5), 0.5);
            if back.wi.z > 0.0 {
                let reflectance = k.dielectric_fresnel(-s.wi.z, 1.0 / eta);
                assert!(reflectance > 0.99, "{wo} reached {} in {ior}, but cannot return", s.wi);
                continue;
            }
            // Next to the critical angle, rounding of the cosine is magnified.
            let slack = 1e-6 / wo.z.min(-s.wi.z);
            assert!((turned(back.wi) - wo).abs().max_element() < slack, "{wo} came back as {}", turned(back.wi));
            assert!((back.eta * s.eta - 1.0).abs() < 1e-6);
            assert!((back.weight * s.weight - Vec3::ONE).abs().max_element() < 1e-6);
            let (there, here) = (k.dielectric_fresnel(wo.z, eta), k.dielectric_fresnel(-s.wi.z, 1.0 / eta));
            assert!((here - there).abs() < 8.0 * slack, "{there} reflected, but {here} on the way back, at {}", wo.z);
        }
        assert!(refracted > 50_000);
    });
}

#[test]
fn a_sheet_counts_its_inner_reflections() {
    with(|k| {
        for ior in [1.1, 1.5, 2.4] {
            let b = smooth(ior, DIELECTRIC_THIN);
            for i in 1..=20 {
                let wo = direction(f64::from(i) / 20.0, 1.0);
                let f = k.dielectric_fresnel(wo.z, ior);
                // Reflected once, or after any odd number of times within.
                let want: f32 = f + (0..200).map(|n| (1.0 - f).powi(2) * f.powi(2 * n + 1)).sum::<f32>();
                let at = |u: f32| k.bsdf_sample(b, wo, Vec2::new(u, 0.3), 0.5);
                let (below, above) = (at(want - 1e-4), at((want + 1e-4).min(1.0_f32.next_down())));
                assert_eq!((below.wi, below.weight), (Vec3::new(-wo.x, -wo.y, wo.z), Vec3::ONE));
                assert_eq!((above.wi, above.weight, above.eta), (-wo, Vec3::ONE, 1.0), "straight through");
            }
        }
    });
}

#[test]
fn glass_has_nothing_to_evaluate() {
    with(|k| {
        let wo = direction(0.5, 1.0);
        for flags in [0, DIELECTRIC_THIN] {
            assert_eq!(k.bsdf_eval(smooth(1.5, flags), wo, Vec3::Z), Vec3::ZERO);
            assert_eq!(k.bsdf_pdf(smooth(1.5, flags), wo, Vec3::Z), 0.0);
        }
    });
}
