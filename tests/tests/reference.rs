//! The classic Cornell box against another renderer's picture: the only test whose truth another path tracer made.

use glam::Vec3;
use kinora_renderer::Choice;
use kinora_tests::{gpu, render, scene};
use serde_json::Value;

/// Tiles a side, pixels a tile's side.
const TILES: usize = 32;
const TILE: usize = 8;

fn colour(value: &Value) -> Vec3 {
    let channel = |i: usize| value[i].as_f64().expect("a number") as f32;
    Vec3::new(channel(0), channel(1), channel(2))
}

// The mean of each channel within `mean`, and 97 tiles of 100 within `tile` of max(reference, 0.02).
fn check(choice: Choice, samples: u32, mean: f32, tile: f32) {
    let reference: Value = serde_json::from_str(include_str!("../data/cornell_classic.json")).expect("JSON");
    let mut scene = scene("tests/scenes/cornell_classic.kin", &[]);
    scene.render.samples = samples;
    let pixels = render(&scene, 0, choice).mean();
    let size = TILES * TILE;
    let got = pixels.iter().sum::<Vec3>() / pixels.len() as f32;
    let off = (got / colour(&reference["mean"]) - Vec3::ONE).abs().max_element();
    println!("{choice:?}: means off by {:.3} %", 100.0 * off);
    assert!(off < mean, "the means are {got}, off by {off}");
    let near = (0..TILES * TILES)
        .filter(|&i| {
            let rows = (0..TILE).map(|y| (i / TILES * TILE + y) * size + i % TILES * TILE);
            let sum: Vec3 = rows.flat_map(|row| &pixels[row..row + TILE]).sum();
            let expected = colour(&reference["tiles"][i]);
            let off = (sum / (TILE * TILE) as f32 - expected).abs() / expected.max(Vec3::splat(0.02));
            off.max_element() < tile
        })
        .count();
    println!("{choice:?}: {near} of {} tiles within {:.0} %", TILES * TILES, 100.0 * tile);
    assert!(near * 100 >= TILES * TILES * 97, "only {near} tiles are within {tile}");
}

#[test]
fn cpu() {
    check(Choice::Cpu, 128, 0.004, 0.05);
}

#[test]
fn on_a_gpu() {
    if gpu().is_some() {
        check(Choice::Gpu, 32, 0.006, 0.10);
    }
}
