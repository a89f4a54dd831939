//! Choosing among many lights: samples a second with 10 and with 10 000, and the error at equal time of the tree beside
//! choosing by power and choosing evenly.

use std::f64::consts::TAU;
use std::time::Instant;

use glam::{DAffine3, DVec3, UVec2, Vec4};
use kinora_kernel::generated::FEATURE_LIGHT_TREE;
use kinora_kernel::lanes::{Width, radiance};
use kinora_kernel::{Kernel, Packed};
use kinora_renderer::pack;
use kinora_renderer::suite::{add, diffuse, quad, view, world};
use kinora_scene::{Color, Lamp, Light, LightKind, Shape, World};
use rayon::prelude::*;

const SIZE: [u32; 2] = [160, 120];
/// Samples of the picture that the others are compared with.
const TRUTH: u32 = 8192;

/// A floor of 100 m × 100 m with boxes on it and `count` lamps of a radius, or points, among them, some of them a hundred times as bright as most.
fn town(count: u32, radius_m: f64) -> World {
    let mut w = world(SIZE, 1, view(DVec3::new(0.0, 18.0, 45.0), DVec3::new(0.0, 0.0, 5.0), 0.7));
    w.render.max_bounces = 1;
    add(&mut w, quad(DVec3::Y, 100.0, 100.0), DAffine3::IDENTITY, diffuse(0.5, 0.0));
    for i in 0..100 {
        let at = DVec3::new(f64::from(i % 10) * 9.0 - 40.0, 1.5, f64::from(i / 10) * 9.0 - 45.0);
        let place = DAffine3::from_translation(at);
        add(&mut w, Shape::Box { size_m: DVec3::new(3.0, 3.0, 3.0) }, place, diffuse(0.6, 0.0));
    }
    // Lamps along a low-discrepancy sequence (the plastic number's), so that their places are the same everywhere.
    let share = |i: u32, step: f64| (f64::from(i) * step).fract();
    for i in 0..count {
        let (x, z, y) = (share(i, 0.819_172_513_4), share(i, 0.671_043_606_7), share(i, 0.549_700_477_9));
        let bright = if i % 50 == 0 { 100.0 } else { 1.0 };
        w.lights.push(Lamp {
            node: i as usize,
            light: Light {
                name: String::new(),
                parent: None,
                color: Color::ONE,
                kind: LightKind::Point {
                    position: DVec3::new(100.0 * x - 50.0, 0.5 + 4.0 * y, 100.0 * z - 50.0),
                    power: bright * 2.0 * TAU * 1e4 / f64::from(count),
                    radius_m,
                },
            },
            next: None,
        });
    }
    w
}

/// Means of `samples` samples a pixel from the first of them on, and the seconds that it took.
fn trace(packed: &Packed, first: u32, samples: u32) -> (Vec<Vec4>, f64) {
    let start = Instant::now();
    let [width, height] = SIZE;
    let rows = (0..height).into_par_iter().flat_map_iter(|y| {
        packed.with_kernel(|kernel: &Kernel<'_>| {
            let mut light = vec![Vec4::ZERO; (width * samples) as usize];
            let place = |i: usize| (UVec2::new(i as u32 / samples, y), first + i as u32 % samples);
            radiance(kernel, Width::best(), &place, &mut light);
            let mean = |of: &[Vec4]| of.iter().sum::<Vec4>() / samples as f32;
            light.chunks(samples as usize).map(mean).collect::<Vec<_>>()
        })
    });
    (rows.collect(), start.elapsed().as_secs_f64())
}

/// Mean of (a − b)² / (b² + 0.01 of its mean square), without the thousandth part that is farthest off.
fn relative_error(a: &[Vec4], b: &[Vec4]) -> f64 {
    let y = |v: &Vec4| f64::from(v.x + v.y + v.z) / 3.0;
    let floor = 0.01 * b.iter().map(|b| y(b).powi(2)).sum::<f64>() / b.len() as f64;
    let mut off: Vec<f64> = a.iter().zip(b).map(|(a, b)| (y(a) - y(b)).powi(2) / (y(b).powi(2) + floor)).collect();
    off.sort_by(f64::total_cmp);
    off.truncate(off.len() - off.len() / 1000);
    off.iter().sum::<f64>() / off.len() as f64
}

/// Chances of the first `light_count` lights, in place of the tree.
fn choose(packed: &Packed, chance: impl Fn(usize) -> f32) -> Packed {
    let mut packed = packed.clone();
    packed.params.features &= !FEATURE_LIGHT_TREE;
    let mut before = 0.0;
    for (i, light) in packed.lights.iter_mut().take(packed.params.light_count as usize).enumerate() {
        light.origin.w = before;
        light.edge_u.w = chance(i);
        before += light.edge_u.w;
    }
    packed
}

fn main() {
    println!("| lamps | chosen | Msamples/s | relative error² in the time of 64 samples by the tree |");
    println!("| --- | --- | --- | --- |");
    for (count, radius_m) in [(10, 0.0), (10_000, 0.0), (10, 0.05), (1000, 0.05), (10_000, 0.05)] {
        let tree = pack(&town(count, radius_m)).expect("it packs");
        let lights = tree.params.light_count as usize;
        let power: Vec<f32> = tree.lights[..lights].iter().map(|light| light.edge_u.w).collect();
        let (truth, _) = trace(&tree, 1 << 20, TRUTH);
        let by_power = choose(&tree, |i| power[i]);
        let evenly = choose(&tree, |_| 1.0 / lights as f32);
        let mut seconds = 0.0;
        for (name, packed) in [("by the tree", &tree), ("by power", &by_power), ("evenly", &evenly)] {
            trace(packed, 0, 4);
            let pace = (0..3).map(|_| trace(packed, 0, 64).1).fold(f64::INFINITY, f64::min);
            if seconds == 0.0 {
                seconds = pace;
            }
            let samples = (64.0 * seconds / pace).round().max(1.0) as u32;
            let (picture, _) = trace(packed, 0, samples);
            let error = relative_error(&picture, &truth);
            let speed = f64::from(SIZE[0] * SIZE[1]) * 64.0 / pace * 1e-6;
            let lamps = if radius_m > 0.0 { "balls" } else { "points" };
            println!("| {count} {lamps} | {name} | {speed:.2} | {error:.5} |");
        }
    }
}
