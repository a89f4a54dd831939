//! `kinora inspect`: what became of a scene's text, or what is in a model's file.

use std::path::Path;

use glam::Vec3;
use kinora_lang::assets::gltf::{self, LampKind, Model, Projection};
use kinora_lang::assets::read_mesh;
use kinora_lang::dimension::short;
use kinora_lang::files::Files;
use kinora_scene::{Animated, BodyKind, Bsdf, Emission, JointKind, LightKind, Material, Mesh, Scene, Shape};

use crate::exit::{self, Outcome};
use crate::flags::SceneFlags;
use crate::{session, terminal};

/// Show what a scene contains, all names resolved and all values computed; or what is in a model or a mesh.
///
/// Examples: kinora inspect hello.kin --ron, kinora inspect robot.glb
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// Everything, in Rusty Object Notation
    #[arg(long)]
    ron: bool,
}

pub fn run(args: &Args) -> Outcome {
    if let Some(ending) = ending(&args.scene.file) {
        return file(&args.scene.file, &ending);
    }
    let loaded = session::load(&args.scene.file, &args.scene.changes())?;
    loaded.report();
    let Some(scene) = loaded.scene.as_deref() else { return Ok(loaded.fault_code()) };
    terminal::out(&if args.ron { ron(scene)? } else { overview(scene) })?;
    Ok(exit::CLEAN)
}

/// The ending of a file that is a model or a mesh.
fn ending(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    ["gltf", "glb", "obj", "ply", "stl"].contains(&ending.as_str()).then_some(ending)
}

fn file(path: &Path, ending: &str) -> Outcome {
    let (folder, name) = session::project(path)?;
    let bytes = folder.read(&name).map_err(|error| error.message())?;
    if ending != "gltf" && ending != "glb" {
        return match read_mesh(&name, &bytes) {
            Ok(mesh) => {
                terminal::out(&mesh_overview(&mesh))?;
                Ok(exit::CLEAN)
            }
            Err(error) => fault(&format!("`{name}` {}", error.message), error.help),
        };
    }
    match gltf::read(&name, &bytes, &folder) {
        Ok(model) => {
            terminal::out(&model_overview(&model))?;
            Ok(exit::CLEAN)
        }
        Err(faults) => {
            let list: Vec<String> =
                faults.first().iter().map(|fault| format!("{}: {}", fault.at, fault.message)).collect();
            let more = faults.count() - list.len();
            let more = if more > 0 { format!("\nand {more} more") } else { String::new() };
            fault(&format!("`{name}` is not a valid glTF file\n{}{more}", list.join("\n")), "")
        }
    }
}

fn fault(message: &str, help: &str) -> Outcome {
    terminal::out(&format!("{message}\n{help}{}", if help.is_empty() { "" } else { "\n" }))?;
    Ok(exit::FINDINGS)
}

fn mesh_overview(mesh: &Mesh) -> String {
    let (low, high) =
        mesh.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let size = high - low;
    let has = |list: usize| if list > 0 { "yes" } else { "no" };
    let rows = [
        ("vertices", mesh.positions.len().to_string()),
        ("triangles", mesh.triangles.len().to_string()),
        ("size", format!("{} × {} × {} m", size.x, size.y, size.z)),
        ("normals", has(mesh.normals.len()).into()),
        ("uvs", has(mesh.uvs.len()).into()),
        ("colors", has(mesh.colors.len()).into()),
    ];
    rows.into_iter().map(|(name, value)| format!("{name:<10}{value}\n")).collect()
}

fn model_overview(model: &Model) -> String {
    let mut text = String::new();
    let mut section = |title: &str, lines: Vec<String>| {
        if !lines.is_empty() {
            text += &format!("{title} {}\n", lines.len());
            text.extend(lines.into_iter().map(|line| format!("  {line}\n")));
        }
    };
    let mut shown: Vec<Option<&str>> = vec![None; model.nodes.len()];
    for (at, part) in model.nodes.iter().enumerate() {
        if let (Some((mesh, _)), Some(slot)) = (&part.shape, shown.get_mut(part.of.unwrap_or(at))) {
            slot.get_or_insert(&mesh.name);
        }
    }
    let nodes = model.nodes.iter().zip(shown).filter_map(|(part, mesh)| {
        let mut line = part.path.clone()?;
        if let Some(mesh) = mesh {
            line += &format!("  (mesh {mesh})");
        }
        Some(line)
    });
    section("nodes", nodes.collect());
    section("meshes", model.meshes.iter().map(|(name, triangles)| format!("{name}  {triangles} triangles")).collect());
    section("materials", model.material_names.clone());
    section("clips", model.clips.iter().map(|clip| format!("{}  {}s", clip.name, short(clip.end_s()))).collect());
    let cameras = model.nodes.iter().filter_map(|part| part.camera.as_ref()).map(|lens| match lens.projection {
        Projection::Perspective(fov) => format!("{}  perspective, fov {:.1}deg", lens.name, fov.to_degrees()),
        Projection::Orthographic(height) => format!("{}  orthographic, height {height}", lens.name),
    });
    section("cameras", cameras.collect());
    let lights = model.nodes.iter().filter_map(|part| part.light.as_ref()).map(|lamp| match lamp.kind {
        LampKind::Sun => format!("{}  sun, {} W/m^2", lamp.name, lamp.intensity),
        LampKind::Point => format!("{}  point, {} W/sr", lamp.name, lamp.intensity),
        LampKind::Spot([_, outer]) => {
            format!("{}  spot, {} W/sr, angle {:.1}deg", lamp.name, lamp.intensity, 2.0 * outer.to_degrees())
        }
    });
    section("lights", lights.collect());
    section("left out", model.warnings.iter().map(|(what, then, _)| format!("{what}: {then}")).collect());
    text
}

fn ron(scene: &Scene) -> Result<String, String> {
    let pretty = ron::ser::PrettyConfig::new().new_line("\n").compact_arrays(true);
    let text = ron::ser::to_string_pretty(scene, pretty).map_err(|error| format!("cannot write the scene: {error}"))?;
    Ok(text + "\n")
}

/// What a scene consists of, a line each.
pub fn overview(scene: &Scene) -> String {
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
    let others = kinds(scene.lights.iter().map(|light| match light.kind {
        LightKind::Sun { .. } => "sun",
        LightKind::Point { .. } => "point_light",
        LightKind::Spot { .. } => "spot_light",
    }));
    let frames = scene.clock.frame_count();
    let mut rows = vec![
        ("picture", format!("{width} × {height}, {} samples", scene.render.samples)),
        ("cameras", if cameras.is_empty() { "none".into() } else { cameras.join(", ") }),
        ("shapes", format!("{}{}", shapes().count(), kinds(shapes().map(|(_, shape)| kind(shape))))),
        ("triangles", format!("{triangles} in meshes")),
        ("materials", format!("{}{}", scene.materials.len(), kinds(scene.materials.iter().map(surface)))),
        ("lights", format!("{lamps} of the shapes{sky}{}", others.replacen(": ", ", ", 1))),
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
    let physics = &scene.physics;
    if !physics.bodies.is_empty() {
        let moved = kinds(physics.bodies.iter().map(|body| match body.kind {
            BodyKind::Dynamic => "dynamic",
            BodyKind::Fixed => "fixed",
            BodyKind::Kinematic => "kinematic",
        }));
        rows.push(("bodies", format!("{}{moved}", physics.bodies.len())));
        let joints = kinds(physics.joints.iter().map(|joint| match joint.kind {
            JointKind::Fixed => "fixed",
            JointKind::Ball => "ball",
            JointKind::Hinge { .. } => "hinge",
            JointKind::Slider { .. } => "slider",
            JointKind::Spring { .. } => "spring",
        }));
        rows.push(("joints", format!("{}{joints}", physics.joints.len())));
        let simulation = &physics.simulation;
        let (steps, rate) = (simulation.step_count(), simulation.rate_hz);
        rows.push(("simulation", format!("{steps} steps at {rate} a second, kept in {}", simulation.bake)));
    }
    let width = rows.iter().map(|(name, _)| name.len() + 1).max().unwrap_or(0).max(10);
    rows.into_iter().map(|(name, value)| format!("{name:<width$}{value}\n")).collect()
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
        Bsdf::Sheen { .. } => "sheen",
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
