//! Whether mip levels would beat plain samples of pixels: a picture that is seen smaller than it is, read as it is and read
//! from the level that a ray cone would choose. Levels are pictures of their own here, so that both cost what they would.

use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DVec3, UVec2, Vec4};
use kinora_kernel::lanes::{Width, radiance};
use kinora_kernel::{Kernel, Packed};
use kinora_renderer::pack;
use kinora_renderer::suite::{add, diffuse, emitter, quad, view, world};
use kinora_scene::{
    Color, ColorSpace, Emission, Image, ImageTexture, Map, Material, Projection, Shape, Sky, SkyLight, Slot, Texels,
    Texture, World,
};
use rayon::prelude::*;

const SIZE: u32 = 96;
/// Texels across a pixel, along u and v.
const SHRUNK: u32 = 8;
const TRUTH: u32 = 8192;

/// Leaves, gravel, print: texels of 0 and 1 in patches of a few texels, and a gradient over all.
fn picture() -> Vec<f32> {
    let size = SIZE * SHRUNK;
    let hash = |x: u32, y: u32| {
        let mut h = x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77);
        h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
        h ^ (h >> 13)
    };
    let texel = |x: u32, y: u32| {
        let patch = f32::from(hash(x / 3, y / 3) % 100 < 40);
        0.1 + 0.6 * patch * (0.5 + 0.5 * x as f32 / size as f32)
    };
    (0..size * size).map(|i| texel(i % size, i / size)).collect()
}

/// Each texel the mean of four.
fn halved(texels: &[f32], size: usize) -> Vec<f32> {
    let half = size / 2;
    let at = |x: usize, y: usize| texels[y * size + x];
    (0..half * half)
        .map(|i| {
            let (x, y) = (i % half * 2, i / half * 2);
            0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
        })
        .collect()
}

fn seen(texels: &[f32], lit: Lit) -> World {
    let size = (texels.len() as f64).sqrt() as u32;
    let mut eye = view(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, 0.7);
    eye.projection = Projection::Orthographic { height_m: 2.0 };
    let mut w = world([SIZE; 2], 1, eye);
    w.render.filter_width = 1.5;
    w.render.max_bounces = 3;
    let texels = Texels::Rgba32F(texels.iter().map(|t| [*t, *t, *t, 1.0]).collect());
    let image = Arc::new(Image::new("picture", size, size, texels).expect("as many texels as it says"));
    let texture = Arc::new(Texture::Image(ImageTexture::new(image, ColorSpace::Linear)));
    let printed = |material| Material { maps: vec![Map { slot: Slot::Color, texture: texture.clone() }], ..material };
    let sky = |x: f32| Some(Sky { light: SkyLight::Color(Color::splat(x)), strength: 1.0, visible: true });
    match lit {
        Lit::Glows => {
            add(&mut w, quad(DVec3::Z, 2.0, 2.0), DAffine3::IDENTITY, printed(emitter(Emission::Radiance(1.0))));
        }
        Lit::Sky => {
            w.sky = sky(1.0);
            add(&mut w, quad(DVec3::Z, 2.0, 2.0), DAffine3::IDENTITY, printed(diffuse(1.0, 0.0)));
        }
        Lit::Room => {
            w.sky = sky(0.05);
            add(&mut w, quad(DVec3::Z, 2.0, 2.0), DAffine3::IDENTITY, printed(diffuse(1.0, 0.0)));
            let place = |x, y, z| DAffine3::from_translation(DVec3::new(x, y, z));
            for i in 0..12 {
                let at = place(f64::from(i % 4) * 0.5 - 0.75, f64::from(i / 4) * 0.6 - 0.6, 0.25);
                add(&mut w, Shape::Sphere { radius_m: 0.08 }, at, diffuse(0.7, 0.0));
            }
            let lamp = emitter(Emission::Radiance(12.0));
            add(&mut w, quad(-DVec3::Z, 1.0, 1.0), place(1.8, 1.2, 2.0), lamp);
        }
    }
    w
}

#[derive(Clone, Copy)]
enum Lit {
    /// Of itself: there is no noise but the picture's.
    Glows,
    /// By an even sky.
    Sky,
    /// By a lamp, with shadows and light from walls.
    Room,
}

/// Means of `samples` samples a pixel from the first of them on, and the seconds that it took.
fn trace(packed: &Packed, first: u32, samples: u32) -> (Vec<f64>, f64) {
    let start = Instant::now();
    let rows = (0..SIZE).into_par_iter().flat_map_iter(|y| {
        packed.with_kernel(|kernel: &Kernel<'_>| {
            let mut light = vec![Vec4::ZERO; (SIZE * samples) as usize];
            let place = |i: usize| (UVec2::new(i as u32 / samples, y), first + i as u32 % samples);
            radiance(kernel, Width::best(), &place, &mut light);
            let mean = |of: &[Vec4]| of.iter().map(|v| f64::from(v.x)).sum::<f64>() / f64::from(samples);
            light.chunks(samples as usize).map(mean).collect::<Vec<_>>()
        })
    });
    (rows.collect(), start.elapsed().as_secs_f64())
}

fn relative_error(a: &[f64], b: &[f64]) -> f64 {
    let off = a.iter().zip(b).map(|(a, b)| (a - b).powi(2) / (b * b + 1e-4));
    off.sum::<f64>() / a.len() as f64
}

fn main() {
    println!("{SHRUNK} × {SHRUNK} texels a pixel; relative error² by samples a pixel");
    println!("| lit by | level | Msamples/s | 4 | 16 | 64 | 256 | 1024 |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for (name, lit) in [("itself", Lit::Glows), ("an even sky", Lit::Sky), ("a lamp", Lit::Room)] {
        let mut texels = picture();
        let mut truth = Vec::new();
        for level in 0..=SHRUNK.ilog2() {
            if level > 0 {
                texels = halved(&texels, (texels.len() as f64).sqrt() as usize);
            }
            let packed = pack(&seen(&texels, lit)).expect("it packs");
            if level == 0 {
                truth = trace(&packed, 1 << 20, TRUTH).0;
            }
            trace(&packed, 0, 4);
            let mut line = String::new();
            let mut pace: f64 = 0.0;
            for samples in [4, 16, 64, 256, 1024] {
                let (got, seconds) = trace(&packed, 0, samples);
                pace = pace.max(f64::from(SIZE * SIZE * samples) / seconds * 1e-6);
                line += &format!(" {:.6} |", relative_error(&got, &truth));
            }
            println!("| {name} | {level} | {pace:.2} |{line}");
        }
    }
}
