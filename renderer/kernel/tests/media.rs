//! Nested media: which of them holds, and what a boundary between them is.

mod common;

use common::{Random, glass, scene};
use glam::{UVec4, Vec3};
use kinora_kernel::generated::NONE;
use kinora_kernel::{Material, Packed};

/// Materials 0.. with these indices and priorities.
fn media(all: &[(f32, i32)]) -> Packed {
    let materials: Vec<Material> = all
        .iter()
        .map(|&(ior, priority)| {
            let mut m = glass(ior, 0.0, 0);
            m.kind.z = priority as u32;
            m.extra.x = ior - 1.0;
            m
        })
        .collect();
    scene(&materials)
}

fn stack(inside: &[u32]) -> UVec4 {
    let at = |i: usize| inside.get(i).copied().unwrap_or(NONE);
    UVec4::new(at(0), at(1), at(2), at(3))
}

/// Water, glass of higher priority, oil of water's priority, air in the glass, a diamond of priority below 0.
const WATER: u32 = 0;
const GLASS: u32 = 1;
const OIL: u32 = 2;
const BUBBLE: u32 = 3;
const DIAMOND: u32 = 4;

fn bar() -> Packed {
    media(&[(1.333, 0), (1.5, 1), (1.47, 0), (1.0, 2), (2.4, -1)])
}

/// Crossing from `before` (the one entered last first) through `material`: what is beyond, and η or nothing if hidden.
#[track_caller]
fn check(before: &[u32], material: u32, front: bool, beyond: &[u32], eta: Option<f32>) {
    bar().with_kernel(|k| {
        let got = k.media_cross(stack(before), material, front);
        assert_eq!(got.beyond, stack(beyond), "beyond");
        assert_eq!(got.hidden, eta.is_none(), "hidden");
        if let Some(eta) = eta {
            assert!((got.eta - eta).abs() < 1e-6, "{} instead of {eta}", got.eta);
        }
    });
}

#[test]
fn boundaries_by_table() {
    // Into and out of one, from air.
    check(&[], GLASS, true, &[GLASS], Some(1.5));
    check(&[GLASS], GLASS, false, &[], Some(1.0 / 1.5));
    // Water behind glass, that overlaps it: first hidden, then the glass's own boundary is one to water.
    check(&[GLASS], WATER, true, &[WATER, GLASS], None);
    check(&[WATER, GLASS], GLASS, false, &[WATER], Some(1.333 / 1.5));
    // And back.
    check(&[WATER], GLASS, true, &[GLASS, WATER], Some(1.5 / 1.333));
    check(&[GLASS, WATER], WATER, false, &[GLASS], None);
    // Of equals the one entered last.
    check(&[WATER], OIL, true, &[OIL, WATER], Some(1.47 / 1.333));
    check(&[OIL, WATER], WATER, false, &[OIL], None);
    check(&[OIL, WATER], OIL, false, &[WATER], Some(1.333 / 1.47));
    // A bubble of air above all.
    check(&[GLASS], BUBBLE, true, &[BUBBLE, GLASS], Some(1.0 / 1.5));
    check(&[BUBBLE, GLASS], BUBBLE, false, &[GLASS], Some(1.5));
    check(&[BUBBLE, GLASS], GLASS, false, &[BUBBLE], None);
    // Below 0 is below 0, and the air outside has no priority at all.
    check(&[WATER], DIAMOND, true, &[DIAMOND, WATER], None);
    check(&[], DIAMOND, true, &[DIAMOND], Some(2.4));
    check(&[DIAMOND, WATER], WATER, false, &[DIAMOND], Some(2.4 / 1.333));
    // Left without having been entered: it was there all the time.
    check(&[], GLASS, false, &[], Some(1.0 / 1.5));
    check(&[WATER], GLASS, false, &[WATER], Some(1.333 / 1.5));
    // Entered twice (a mesh in itself): only the outermost boundary counts.
    check(&[GLASS], GLASS, true, &[GLASS, GLASS], None);
    check(&[GLASS, GLASS], GLASS, false, &[GLASS], None);
}

#[test]
fn a_fifth_medium_forgets_the_first() {
    check(&[OIL, GLASS, WATER, DIAMOND], BUBBLE, true, &[BUBBLE, OIL, GLASS, WATER], Some(1.0 / 1.5));
    check(&[WATER, OIL, WATER, OIL], GLASS, true, &[GLASS, WATER, OIL, WATER], Some(1.5 / 1.333));
}

#[test]
fn the_highest_priority_holds() {
    bar().with_kernel(|k| {
        assert_eq!(k.medium_of(stack(&[])), NONE);
        let mut random = Random(1);
        for _ in 0..10_000 {
            let count = (random.bits() % 5) as usize;
            let inside: Vec<u32> = (0..count).map(|_| (random.bits() % 5) as u32).collect();
            // Of equals the first, which was entered last.
            let want = inside.iter().copied().rev().max_by_key(|&m| k.medium_priority(m)).unwrap_or(NONE);
            assert_eq!(k.medium_of(stack(&inside)), want, "{inside:?}");
            let absorbed = if want == NONE { 0.0 } else { k.medium_ior(want) - 1.0 };
            assert_eq!(k.media_absorption(stack(&inside)).x, absorbed, "{inside:?}");
        }
    });
}

#[test]
fn leaving_undoes_entering() {
    bar().with_kernel(|k| {
        let mut random = Random(2);
        for _ in 0..10_000 {
            let count = (random.bits() % 4) as usize;
            let inside: Vec<u32> = (0..count).map(|_| (random.bits() % 5) as u32).collect();
            let material = (random.bits() % 5) as u32;
            let into = k.media_cross(stack(&inside), material, true);
            let out = k.media_cross(into.beyond, material, false);
            assert_eq!(out.beyond, stack(&inside), "{inside:?} and {material}");
            assert_eq!(out.hidden, into.hidden);
            assert!((out.eta * into.eta - 1.0).abs() < 1e-6);
        }
    });
}

#[test]
fn light_is_absorbed_by_the_metre() {
    Packed::empty().with_kernel(|k| {
        // The colour .5 after half a metre, as the origin of the numbers has it.
        let half = Vec3::new(0.5_f32.ln() / -0.5, 0.0, 3.0);
        let left = k.transmittance(half, 1.0);
        assert!((left - Vec3::new(0.25, 1.0, (-3.0_f32).exp())).abs().max_element() < 1e-6, "{left}");
        assert_eq!(k.transmittance(Vec3::ZERO, 1e30), Vec3::ONE, "vacuum, however far");
        assert!(k.transmittance(half, 1e30).is_finite());
    });
}
