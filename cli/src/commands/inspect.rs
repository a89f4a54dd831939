//! `kinora inspect`: what became of a scene's text.

use kinora_scene::{Animated, Bsdf, Emission, Material, Scene, Shape};

use crate::exit::{self, Outcome};
use crate::flags::SceneFlags;
use crate::{session, terminal};

/// Show what a scene contains, all names resolved and all values computed.
///
/// Example: kinora inspect hello.kin --ron
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// Everything, in Rusty Object Notation
    #[arg(long)]
    ron: bool,
}

pub fn run(args: &Args) -> Outcome {
    let loaded = session::load(&args.scene.file, &args.scene.changes())?;
    loaded.report();
    let Some(scene) = loaded.scene.as_deref() else { return Ok(loaded.fault_code()) };
    terminal::out(&if args.ron { ron(scene)? } else { overview(scene) })?;
    Ok(exit::CLEAN)
}

fn ron(scene: &Scene) -> Result<String, String> {
    let pretty = ron::ser::PrettyConfig::new().new_line("\n").compact_arrays(true);
    let text = ron::ser::to_string_pretty(scene, pretty).map_err(|error| format!("cannot write the scene: {error}"))?;
    Ok(text + "\n")
}

fn overview(scene: &Scene) -> String {
    let [width, height] = scene.render.resolution;
    let cameras: Vec<String> = scene
        .cameras
        .iter()
        .enumerate()
        .map(|(at, camera)| {
            let chosen = scene.camera == Some(at) && scene.cameras.len() > 1;
            format!("{}{}", camera.name, if chosen { " (takes the picture)" } else { "" })
        })
        .collect();
    let shapes = || scene.nodes.iter().filter_map(|node| node.shape.as_ref().map(|shape| (node, shape)));
    let triangles: usize = shapes()
        .map(|(_, shape)| match shape {
            Shape::Mesh(mesh) => mesh.triangles.len(),
            _ => 0,
        })
        .sum();
    let shining = shining(&scene.materials);
    let lamps = shapes().filter(|(node, _)| shining.get(node.material) == Some(&true)).count();
    let sky = if scene.sky.is_some() { ", a sky" } else { "" };
    let frames = scene.clock.frame_count();
    let rows = [
        ("picture", format!("{width} × {height}, {} samples", scene.render.samples)),
        ("cameras", if cameras.is_empty() { "none".into() } else { cameras.join(", ") }),
        ("shapes", format!("{}{}", shapes().count(), kinds(shapes().map(|(_, shape)| kind(shape))))),
        ("triangles", format!("{triangles} in meshes")),
        ("materials", format!("{}{}", scene.materials.len(), kinds(scene.materials.iter().map(surface)))),
        ("lights", format!("{lamps} of the shapes{sky}")),
        (
            "duration",
            format!(
                "{} s, {frames} frame{} at {} a second",
                scene.clock.duration_s,
                if frames == 1 { "" } else { "s" },
                scene.clock.fps
            ),
        ),
    ];
    rows.into_iter().map(|(name, value)| format!("{name:<10}{value}\n")).collect()
}

// ": 2 box, 1 sphere", in the order of their first use.
fn kinds(names: impl Iterator<Item = &'static str>) -> String {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for name in names {
        match counts.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => counts.push((name, 1)),
        }
    }
    let counts: Vec<String> = counts.into_iter().map(|(name, count)| format!("{count} {name}")).collect();
    if counts.is_empty() { String::new() } else { format!(": {}", counts.join(", ")) }
}

fn kind<R: kinora_scene::Rate>(shape: &Shape<R>) -> &'static str {
    match shape {
        Shape::Sphere { .. } => "sphere",
        Shape::Disk { .. } => "disk",
        Shape::Cylinder { .. } => "cylinder",
        Shape::Cone { .. } => "cone",
        Shape::Capsule { .. } => "capsule",
        Shape::Torus { .. } => "torus",
        Shape::Box { .. } => "box",
        Shape::Quad { .. } => "quad",
        Shape::Plane { .. } => "plane",
        Shape::Mesh(_) => "mesh",
    }
}

fn surface<R: kinora_scene::Rate>(material: &Material<R>) -> &'static str {
    match material.bsdf {
        Bsdf::Diffuse { .. } => "diffuse",
        Bsdf::Metal { .. } => "metal",
        Bsdf::Dielectric { .. } => "dielectric",
        Bsdf::Glossy { .. } => "glossy",
        Bsdf::Mix { .. } => "mix",
        Bsdf::Emitter { .. } => "emitter",
    }
}

// Whether each can give light at some time; what a mix is made of stands before it.
fn shining(materials: &[Material<Animated>]) -> Vec<bool> {
    let mut shining: Vec<bool> = Vec::new();
    for material in materials {
        shining.push(match &material.bsdf {
            Bsdf::Emitter { emission: Emission::Radiance(amount) | Emission::Power(amount), .. } => {
                amount.constant() != Some(&0.0)
            }
            Bsdf::Mix { a, b, .. } => [a, b].into_iter().any(|part| shining.get(*part) == Some(&true)),
            _ => false,
        });
    }
    shining
}
