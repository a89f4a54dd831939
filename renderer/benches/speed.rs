//! Samples a second of the fixed scenes that performance is judged by: `cargo bench -p kinora-renderer [-- gpu]`.
//! Prints a table in Markdown; `docs/performance.md` keeps it.

use std::sync::Arc;
use std::time::Instant;

use glam::{DAffine3, DVec3, Vec3};
use kinora_renderer::suite::{add, diffuse, emitter, glass, metal, quad, view, world};
use kinora_renderer::{Choice, Options, Renderer, open};
use kinora_scene::{Bsdf, Color, DiffuseModel, Emission, Material, Mesh, Render, Shape, Sky, SkyLight, Still, World};

fn matt(color: Color) -> Material<Still> {
    Bsdf::Diffuse { color, roughness: 0.0, model: DiffuseModel::Eon }.into()
}

/// The classic Cornell box (Goral et al. 1984; the measured data of 1998), in units of 100 mm as everywhere else.
fn cornell() -> World {
    let mut w = world([512, 512], 16, view(DVec3::new(2.78, 2.73, -8.0), DVec3::new(2.78, 2.73, 0.0), 0.686));
    w.render.max_bounces = 7;
    let white = || matt(Color::new(0.725, 0.71, 0.68));
    let red = matt(Color::new(0.63, 0.065, 0.05));
    let green = matt(Color::new(0.14, 0.45, 0.091));
    let (half, side) = (2.78, 5.56);
    let place = |x, y, z| DAffine3::from_translation(DVec3::new(x, y, z));
    add(&mut w, quad(DVec3::Y, side, side), place(half, 0.0, half), white());
    add(&mut w, quad(DVec3::NEG_Y, side, side), place(half, side, half), white());
    add(&mut w, quad(DVec3::NEG_Z, side, side), place(half, half, side), white());
    add(&mut w, quad(DVec3::NEG_X, side, side), place(side, half, half), red);
    add(&mut w, quad(DVec3::X, side, side), place(0.0, half, half), green);
    let block = |x, y, z, turn| place(x, y, z) * DAffine3::from_rotation_y(turn);
    let sized = |y| Shape::Box { size_m: DVec3::new(1.65, y, 1.65) };
    add(&mut w, sized(1.65), block(1.86, 0.825, 1.69, -0.29), white());
    add(&mut w, sized(3.3), block(3.68, 1.65, 3.51, 0.31), white());
    let lamp =
        Bsdf::Emitter { color: Color::new(17.0, 12.0, 4.0), emission: Emission::Radiance(1.0), two_sided: false }
            .into();
    add(&mut w, quad(DVec3::NEG_Y, 1.3, 1.05), place(2.78, 5.487, 2.795), lamp);
    w
}

/// A bumpy ball of a million triangles under a sky and a lamp.
fn million() -> World {
    let mut w = world([512, 512], 16, view(DVec3::new(0.0, 1.0, 4.0), DVec3::ZERO, 0.7));
    w.render.max_bounces = 7;
    w.sky = Some(Sky::<Still> { light: SkyLight::Color(Color::new(0.6, 0.75, 1.0)), strength: 0.5, visible: true });
    let (rows, columns) = (500_u32, 1000_u32);
    let mut mesh = Mesh::default();
    for i in 0..=rows {
        for j in 0..=columns {
            let theta = std::f32::consts::PI * i as f32 / rows as f32;
            let phi = std::f32::consts::TAU * j as f32 / columns as f32;
            let d = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            mesh.positions.push(d * (1.0 + 0.05 * (20.0 * d.x).sin() * (23.0 * d.y).sin() * (17.0 * d.z).sin()));
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let a = i * (columns + 1) + j;
            let b = a + columns + 1;
            mesh.triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
        }
    }
    add(&mut w, Shape::Mesh(Arc::new(mesh)), DAffine3::IDENTITY, diffuse(0.7, 0.0));
    add(&mut w, quad(DVec3::Y, 20.0, 20.0), DAffine3::from_translation(DVec3::NEG_Y), diffuse(0.5, 0.0));
    let lamp = emitter(Emission::Radiance(20.0));
    add(&mut w, quad(DVec3::NEG_Y, 1.0, 1.0), DAffine3::from_translation(DVec3::new(1.0, 3.0, 1.0)), lamp);
    w
}

/// Rows of diffuse, metal and glass balls under a sky and a lamp.
fn nine_spheres() -> World {
    let mut w = world([512, 512], 16, view(DVec3::new(0.0, 3.0, 7.0), DVec3::new(0.0, 0.8, 0.0), 0.7));
    w.render.max_bounces = 7;
    w.sky = Some(Sky::<Still> { light: SkyLight::Color(Color::new(0.6, 0.75, 1.0)), strength: 0.5, visible: true });
    add(&mut w, quad(DVec3::Y, 30.0, 30.0), DAffine3::IDENTITY, diffuse(0.5, 0.0));
    for i in 0..9 {
        let (row, column) = (f64::from(i / 3) - 1.0, f64::from(i % 3) - 1.0);
        let material = match i % 3 {
            0 => matt(Color::new(0.8, 0.3, 0.2)),
            1 => metal(Color::new(1.0, 0.8, 0.4), 0.2),
            _ => glass(1.5, Color::ONE, 1.0),
        };
        let place = DAffine3::from_translation(DVec3::new(1.6 * column, 0.7, 1.6 * row));
        add(&mut w, Shape::Sphere { radius_m: 0.7 }, place, material);
    }
    let lamp = emitter(Emission::Radiance(20.0));
    add(&mut w, quad(DVec3::NEG_Y, 1.5, 1.5), DAffine3::from_translation(DVec3::new(2.0, 5.0, 2.0)), lamp);
    w
}
/// Every material at once: the case with most branches.
fn materials() -> World {
    let mut w = cornell();
    let ball_of_glass = glass(1.5, Color::new(0.9, 0.8, 0.6), 1.0);
    let ball_of_metal = metal(Color::new(1.0, 0.8, 0.4), 0.3);
    let ball = |x, y, z| DAffine3::from_translation(DVec3::new(x, y, z));
    add(&mut w, Shape::Sphere { radius_m: 0.8 }, ball(1.8, 2.5, 1.7), ball_of_glass);
    add(&mut w, Shape::Sphere { radius_m: 0.6 }, ball(4.2, 0.6, 1.2), ball_of_metal);
    add(&mut w, Shape::Sphere { radius_m: 0.5 }, ball(0.7, 0.5, 0.8), diffuse(0.8, 1.0));
    w
}

/// Mean over pixels of (picture − truth)² / (truth² + 0.01), luminance as the mean of the channels, of so many samples a
/// pixel; the truth has 32 times as many, of another seed, and its own noise is taken off.
fn error(renderer: &mut Renderer, mut world: World, samples: u32) -> f64 {
    world.render.samples = samples;
    let picture = renderer.render(&world, &()).expect("renders").mean();
    world.render = Render { samples: 32 * samples, seed: 1, ..world.render };
    let truth = renderer.render(&world, &()).expect("renders").mean();
    let y = |v: &Vec3| f64::from(v.element_sum()) / 3.0;
    let off = picture.iter().zip(&truth).map(|(a, b)| (y(a) - y(b)).powi(2) / (y(b).powi(2) + 0.01));
    off.sum::<f64>() / picture.len() as f64 * 32.0 / 33.0
}

fn main() {
    let gpu = std::env::args().any(|arg| arg == "gpu");
    // `cargo bench -- only=Cornell` measures the scenes with that in their name.
    let only = std::env::args().find_map(|arg| arg.strip_prefix("only=").map(str::to_owned)).unwrap_or_default();
    let choice = if gpu { Choice::Gpu } else { Choice::Cpu };
    let mut renderer = Renderer::new(open(choice, Options::default()).expect("the backend opens"));
    let device = renderer.backend().device();
    println!("| scene, {device} | build s | Msamples/s | Mrays/s | samples a pixel, relative error² after 2 s |");
    println!("| --- | --- | --- | --- | --- |");
    let scenes = [
        ("Cornell box", cornell()),
        ("nine spheres", nine_spheres()),
        ("1M triangles", million()),
        ("all materials", materials()),
    ];
    for (name, world) in scenes {
        if !name.contains(&only) {
            continue;
        }
        let mut film = renderer.load(&world).expect("the scene packs");
        // The first pass warms caches and, on a GPU, compiles.
        renderer.trace_pass(&mut film, 16, &()).expect("traces");
        let mut best = (f64::INFINITY, 0);
        for _ in 0..3 {
            let mut film = renderer.load(&world).expect("the scene packs");
            let start = Instant::now();
            renderer.trace_pass(&mut film, 16, &()).expect("traces");
            let seconds = start.elapsed().as_secs_f64();
            if seconds < best.0 {
                best = (seconds, film.rays());
            }
        }
        let (seconds, rays) = best;
        let samples = 512.0 * 512.0 * 16.0;
        let build = renderer.build_time().as_secs_f64();
        let (speed, rays) = (samples / seconds * 1e-6, rays as f64 / seconds * 1e-6);
        let taken = (2.0 * speed * 1e6 / (512.0 * 512.0)).round().max(1.0) as u32;
        let error = error(&mut renderer, world, taken);
        println!("| {name} | {build:.2} | {speed:.2} | {rays:.1} | {taken}, {error:.4} |");
    }
}
