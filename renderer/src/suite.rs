//! The suite that every backend passes: small worlds with answers known in closed form, and what a [`Backend`] promises.
//!
//! A test of a backend is one line: `kinora_renderer::suite::run(Box::new(MyBackend::new()))`. A failure is a panic
//! that names the case; this module is for tests alone.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3, Vec4};
use kinora_scene::{
    Background, Binary, Blades, Bsdf, Cell, Clock, Color, Copied, DiffuseModel, Emission, Filter, Frame, Instance,
    Instruction, Look, Map, Material, Mesh, Mis, Paint, Part, Point, Program, Projection, Reflectance, Render, Sampler,
    Shape, Shown, Sky, SkyLight, Slot, Still, Tape, Texture, Tonemap, Unary, UvSet, View, World,
};

use crate::backend::{Backend, BackendError};
use crate::film::{Film, Light, Request, Seen, Window};
use crate::pack::pack;
use crate::render::{RenderError, Renderer};

/// Runs every case on one backend that was just opened, one after the other: what a case leaves behind must not matter.
///
/// # Panics
/// A case fails.
pub fn run(mut backend: Box<dyn Backend>) {
    println!("suite on {}: trace without a scene is an error", backend.device());
    assert_eq!(backend.trace(None, 0..1, &()), Err(BackendError::Nothing));
    assert_eq!(backend.trace_parts(None, 0..1, &()), Err(BackendError::Nothing));
    assert_eq!(backend.survey(None, 0..1, &()), Err(BackendError::Nothing));
    let mut renderer = Renderer::new(backend);
    for (name, case) in CASES {
        println!("suite: {name}");
        case(&mut renderer);
    }
}

type Case = fn(&mut Renderer);

/// Every case by name.
pub const CASES: &[(&str, Case)] = &[
    ("the same samples give the same bits", deterministic),
    ("passes add up to the whole", passes),
    ("a stopped pass changes nothing", stopping),
    ("what stays between two worlds changes no bit", one_after_another),
    ("an empty world shows its sky", empty_world),
    ("diffuse in a white furnace", furnace_diffuse),
    ("glass in a white furnace", furnace_glass),
    ("a mirror in a white furnace", furnace_mirror),
    ("absorption in a glass sphere", absorption),
    ("a square lamp over a floor", square_lamp),
    ("a lamp of each shape lights the same floor", lamp_shapes),
    ("a closed room of emitters", closed_room),
    ("bounces are counted as the language says", bounces),
    ("the camera's axes", camera_axes),
    ("points where each projection shows them", projections),
    ("nothing beside a fisheye's circle", fisheye_circle),
    ("what is out of focus has the lens's shape", lens_shapes),
    ("an odd size", odd_size),
    ("layers tell what a pixel shows", layers),
    ("layers pass what light passes", layers_pass),
    ("the parts of light add up to it", parts),
    ("coats and what they cover share light", coats_in_parts),
    ("variance is the spread of means", variance),
    ("motion is the way to the next frame", motion),
    ("copies show what their parts written out would", copies),
    ("colours computed at a point", computed),
    ("a map of stretches", stretched),
    ("copies move with their parts", copies_in_motion),
    ("what bends moves by its triangles", bent_in_motion),
    ("a window has the pixels of the whole", windows),
    ("a transparent background has alpha", transparent),
    ("pixels that have enough are left out", adaptive),
    ("what is rare and bright is not lost by stopping early", rare_events),
];

/// A camera at `eye` that looks at `target`.
pub fn view(eye: DVec3, target: DVec3, fov: f64) -> View {
    let back = (eye - target).normalize();
    let up = if back.cross(DVec3::Y).length() < 1e-6 { DVec3::NEG_Z } else { DVec3::Y };
    let right = up.cross(back).normalize();
    View {
        world_from_camera: DAffine3::from_cols(right, back.cross(right), back, eye),
        projection: Projection::Perspective { fov },
        aperture_m: 0.0,
        focus_m: (eye - target).length(),
        blades: Blades::default(),
    }
}

/// A world with nothing in it.
pub fn world(size: [u32; 2], samples: u32, view: View) -> World {
    World {
        render: Render { resolution: size, samples, filter: Filter::Box, filter_width: 1.0, ..Render::default() },
        look: Look { exposure: 0.0, tonemap: Tonemap::None },
        shutter: Clock::default().shutter_of(0),
        moments: Arc::default(),
        view,
        next: None,
        instances: Vec::new(),
        copies: Vec::new(),
        parts: Vec::new(),
        materials: Vec::new(),
        sky: None,
        lights: Vec::new(),
    }
}

/// Adds a shape with a material of its own.
pub fn add(world: &mut World, shape: Shape<Still>, world_from_object: DAffine3, material: Material<Still>) {
    world.materials.push(material);
    let node = world.instances.len();
    let material = world.materials.len() - 1;
    world.instances.push(Instance { node, shape, world_from_object, next: None, next_mesh: None, material });
}

/// A metal without an edge tint.
pub fn metal(color: Color, roughness: f64) -> Material<Still> {
    Bsdf::Metal {
        reflectance: Reflectance::Tint { color, edge_tint: Color::ONE },
        roughness,
        anisotropy: 0.0,
        anisotropy_rotation: 0.0,
        energy_compensation: true,
    }
    .into()
}

/// Smooth glass.
pub fn glass(ior: f64, attenuation_color: Color, attenuation_distance_m: f64) -> Material<Still> {
    Bsdf::Dielectric {
        ior,
        roughness: 0.0,
        energy_compensation: true,
        attenuation_color,
        attenuation_distance_m,
        thin: false,
        priority: 0,
    }
    .into()
}

/// A diffuse material.
pub fn diffuse(color: f32, roughness: f64) -> Material<Still> {
    Bsdf::Diffuse { color: Color::splat(color), roughness, model: DiffuseModel::Eon }.into()
}

/// A white emitter that shines to its outer side.
pub fn emitter(emission: Emission<Still>) -> Material<Still> {
    Bsdf::Emitter { color: Color::ONE, emission, two_sided: false }.into()
}

/// A quad facing `normal`.
pub fn quad(normal: DVec3, width_m: f64, height_m: f64) -> Shape<Still> {
    let frame = Frame::facing(normal, DVec3::Y).expect("a normal has a length");
    Shape::Quad { frame, size_m: DVec2::new(width_m, height_m) }
}

fn at(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

fn white_sky() -> Option<Sky<Still>> {
    Some(Sky { light: SkyLight::Color(Color::ONE), strength: 1.0, visible: true })
}

fn front() -> View {
    view(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.6)
}

fn trace(renderer: &mut Renderer, world: &World) -> Vec<Vec3> {
    renderer.render(world, &()).expect("the suite's worlds render").mean()
}

fn mean(pixels: &[Vec3]) -> f64 {
    pixels.iter().map(|p| f64::from(p.element_sum()) / 3.0).sum::<f64>() / pixels.len() as f64
}

fn near(case: &str, got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "{case}: {got}, expected {expected} ± {tolerance}");
}

fn some_world() -> World {
    let mut w = world([40, 24], 40, front());
    w.sky = Some(Sky { light: SkyLight::Color(Color::new(0.4, 0.6, 1.0)), strength: 1.0, visible: true });
    add(&mut w, Shape::Sphere { radius_m: 0.8 }, at(0.0, 0.0, 0.0), diffuse(0.7, 0.5));
    add(
        &mut w,
        Shape::Plane { frame: Frame::facing(DVec3::Y, DVec3::Y).expect("up") },
        at(0.0, -0.8, 0.0),
        diffuse(0.5, 0.0),
    );
    add(&mut w, Shape::Sphere { radius_m: 0.2 }, at(1.0, 1.0, 0.5), emitter(Emission::Radiance(8.0)));
    let metal = metal(Color::new(1.0, 0.8, 0.5), 0.3);
    add(&mut w, Shape::Box { size_m: DVec3::new(0.4, 0.6, 0.4) }, at(-1.0, -0.5, 0.5), metal);
    w
}

fn deterministic(renderer: &mut Renderer) {
    let w = some_world();
    assert!(trace(renderer, &w) == trace(renderer, &w), "two renders of one world differ");
    let seeded = World { render: Render { seed: 1, ..w.render.clone() }, ..w.clone() };
    assert!(trace(renderer, &w) != trace(renderer, &seeded), "the seed changes nothing");
}

fn passes(renderer: &mut Renderer) {
    let w = some_world();
    let whole = trace(renderer, &w);
    let mut film = renderer.load(&w).expect("loads");
    while renderer.trace_pass(&mut film, w.render.samples, &()).expect("traces") {}
    assert_eq!(film.samples(), w.render.samples);
    assert!(film.rays() > u64::from(film.samples()) * 40 * 24, "every sample has a ray");
    assert!(film.mean() == whole, "passes one by one differ from a whole render");
}

fn stopping(renderer: &mut Renderer) {
    let w = some_world();
    let mut film = renderer.load(&w).expect("loads");
    assert!(!renderer.trace_pass(&mut film, 40, &|_| false).expect("stops"));
    assert_eq!(film.samples(), 0);
    while renderer.trace_pass(&mut film, 40, &()).expect("traces") {}
    assert!(film.mean() == trace(renderer, &w), "a stopped pass left a trace");
}

// The eye moves, also into glass and to another projection, then a shape does: each picture is the one that it would be alone.
fn one_after_another(renderer: &mut Renderer) {
    let mut w = some_world();
    add(&mut w, Shape::Sphere { radius_m: 1.0 }, at(0.0, 0.0, 6.0), glass(1.5, Color::new(0.2, 0.8, 0.4), 0.5));
    let mut worlds = vec![w.clone()];
    let eyes = [DVec3::new(1.0, 0.5, 5.0), DVec3::new(0.1, 0.0, 6.2), DVec3::new(0.0, 2.0, 9.0)];
    worlds.extend(eyes.map(|eye| World { view: view(eye, DVec3::ZERO, 0.9), ..w.clone() }));
    let mut flat = w.view.clone();
    flat.projection = Projection::Orthographic { height_m: 3.0 };
    worlds.push(World { view: flat, ..w.clone() });
    let mut moved = w.clone();
    moved.instances[0].world_from_object.translation.x += 0.3;
    worlds.push(moved.clone());
    moved.render.seed += 1;
    worlds.push(moved);
    let other = World { view: front(), ..world([4, 4], 1, front()) };
    let alone: Vec<_> = worlds
        .iter()
        .map(|w| {
            trace(renderer, &other);
            trace(renderer, w)
        })
        .collect();
    for (i, (w, alone)) in worlds.iter().zip(&alone).enumerate() {
        assert_eq!(&trace(renderer, w), alone, "world {i}");
        assert!(i == 0 || alone != &trace(renderer, &worlds[0]), "world {i} looks like the first");
        trace(renderer, w);
    }
}

fn empty_world(renderer: &mut Renderer) {
    let mut w = world([8, 8], 1, front());
    assert_eq!(mean(&trace(renderer, &w)), 0.0);
    w.sky = white_sky();
    assert!(trace(renderer, &w).iter().all(|p| *p == Vec3::ONE));
    w.sky = w.sky.map(|sky| Sky { visible: false, ..sky });
    assert_eq!(mean(&trace(renderer, &w)), 0.0, "a hidden sky is seen");
}

// A surface that keeps all light cannot be seen in a uniform world.
fn furnace(renderer: &mut Renderer, case: &str, shape: Shape<Still>, material: Material<Still>, tolerance: f64) {
    let mut w = world([24, 24], 64, front());
    w.render.max_bounces = 32;
    w.sky = white_sky();
    add(&mut w, shape, at(0.0, 0.0, 0.0), material);
    let pixels = trace(renderer, &w);
    near(case, mean(&pixels), 1.0, tolerance);
    let worst = pixels.iter().map(|p| (p.x - 1.0).abs()).fold(0.0, f32::max);
    assert!(worst < 0.3, "{case}: a pixel is off by {worst}");
}

fn furnace_diffuse(renderer: &mut Renderer) {
    for roughness in [0.0, 0.3, 1.0] {
        let case = format!("EON of roughness {roughness}");
        furnace(renderer, &case, Shape::Sphere { radius_m: 1.0 }, diffuse(1.0, roughness), 0.003);
    }
}

fn furnace_glass(renderer: &mut Renderer) {
    for ior in [1.0, 1.05, 1.5, 2.4] {
        let clear = || glass(ior, Color::ONE, f64::INFINITY);
        furnace(renderer, &format!("a glass sphere of ior {ior}"), Shape::Sphere { radius_m: 1.0 }, clear(), 0.003);
        furnace(renderer, &format!("a glass box of ior {ior}"), Shape::Box { size_m: DVec3::ONE }, clear(), 0.005);
    }
}

fn furnace_mirror(renderer: &mut Renderer) {
    let mirror = metal(Color::ONE, 0.0);
    furnace(renderer, "a mirror", Shape::Sphere { radius_m: 1.0 }, mirror, 1e-4);
}

// Straight through the centre: 0.96² t / (1 − 0.04² t²), t the colour after the diameter.
fn absorption(renderer: &mut Renderer) {
    let mut w = world([1, 1], 4096, view(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.001));
    w.sky = white_sky();
    w.render.max_bounces = 64;
    let glass = glass(1.5, Color::new(0.5, 0.25, 1.0), 1.0);
    add(&mut w, Shape::Sphere { radius_m: 1.0 }, at(0.0, 0.0, 0.0), glass);
    let pixel = trace(renderer, &w)[0];
    for (channel, colour) in [(pixel.x, 0.5_f64), (pixel.y, 0.25), (pixel.z, 1.0)] {
        let t = colour * colour;
        // What is reflected shows the sky too: 0.04 first, and 0.96² · 0.04 t² / (1 − 0.04² t²) from inside.
        let expected = (0.96 * 0.96 * t + 0.96 * 0.96 * 0.04 * t * t) / (1.0 - 0.0016 * t * t) + 0.04;
        near("a glass sphere", f64::from(channel), expected, 0.015);
    }
}

// Irradiance / radiance of a unit square, 1 above and parallel, centred.
const UNIT_SQUARE: f64 = 0.752_274_688_5;

fn lit_floor(lamp: impl FnOnce(&mut World)) -> World {
    let mut w = world([1, 1], 4096, view(DVec3::new(0.0, 0.5, 0.0), DVec3::ZERO, 0.002));
    w.render.max_bounces = 1;
    add(&mut w, quad(DVec3::Y, 4.0, 4.0), at(0.0, 0.0, 0.0), diffuse(0.5, 0.0));
    lamp(&mut w);
    w
}

fn square_lamp(renderer: &mut Renderer) {
    for (case, emission) in [("radiance", Emission::Radiance(3.0)), ("power", Emission::Power(3.0 * PI))] {
        let w = lit_floor(|w| add(w, quad(DVec3::NEG_Y, 1.0, 1.0), at(0.0, 1.0, 0.0), emitter(emission)));
        near(case, mean(&trace(renderer, &w)), 0.5 * 3.0 * UNIT_SQUARE / PI, 0.003);
    }
    let away = lit_floor(|w| add(w, quad(DVec3::Y, 1.0, 1.0), at(0.0, 1.0, 0.0), emitter(Emission::Radiance(3.0))));
    assert_eq!(mean(&trace(renderer, &away)), 0.0, "a lamp shines to its back");
}

fn lamp_shapes(renderer: &mut Renderer) {
    // A sphere of radius R at height d over the floor: π (R / d)².
    let sphere =
        lit_floor(|w| add(w, Shape::Sphere { radius_m: 0.5 }, at(0.0, 2.0, 0.0), emitter(Emission::Radiance(4.0))));
    near("sphere", mean(&trace(renderer, &sphere)), 0.5 * 4.0 * 0.0625, 0.002);
    // The same sphere, with its size in the transform, and turned.
    let place =
        at(0.0, 2.0, 0.0) * DAffine3::from_quat(DQuat::from_rotation_z(1.0)) * DAffine3::from_scale(DVec3::splat(-0.5));
    let scaled = lit_floor(|w| add(w, Shape::Sphere { radius_m: 1.0 }, place, emitter(Emission::Power(4.0 * PI * PI))));
    near("scaled sphere of a power", mean(&trace(renderer, &scaled)), 0.5 * 4.0 * 0.0625, 0.002);
    // An ellipsoid shows the floor the solid angle of its outline: an ellipse seen from below, far away.
    let flat = at(0.0, 100.0, 0.0) * DAffine3::from_scale(DVec3::new(2.0, 0.5, 1.0));
    let ellipsoid = lit_floor(|w| add(w, Shape::Sphere { radius_m: 1.0 }, flat, emitter(Emission::Radiance(3e4))));
    near("ellipsoid", mean(&trace(renderer, &ellipsoid)), 0.5 * 3e4 * 2.0 / (100.0 * 100.0), 0.03);
    // A box shows its lower face alone.
    let lamp = Shape::Box { size_m: DVec3::new(1.0, 0.2, 1.0) };
    let boxed = lit_floor(|w| add(w, lamp, at(0.0, 1.1, 0.0), emitter(Emission::Radiance(3.0))));
    near("box", mean(&trace(renderer, &boxed)), 0.5 * 3.0 * UNIT_SQUARE / PI, 0.004);
    // The square again, as two triangles of a mirrored mesh.
    let mesh = Mesh {
        positions: [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, z)| Vec3::new(x, 0.0, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    };
    for (name, scale) in [("mesh", DVec3::ONE), ("mirrored mesh", DVec3::new(-1.0, 1.0, 1.0))] {
        let place = at(0.0, 1.0, 0.0) * DAffine3::from_scale(scale);
        let w = lit_floor(|w| add(w, Shape::Mesh(Arc::new(mesh.clone())), place, emitter(Emission::Radiance(3.0))));
        near(name, mean(&trace(renderer, &w)), 0.5 * 3.0 * UNIT_SQUARE / PI, 0.004);
    }
}

// All walls emit 1 and reflect nothing; a ball inside reflects half of it, whatever its shape.
fn closed_room(renderer: &mut Renderer) {
    let mut w = world([16, 16], 64, view(DVec3::new(0.0, 0.0, 1.5), DVec3::ZERO, 0.5));
    let lit = Bsdf::Emitter { color: Color::ONE, emission: Emission::Radiance(1.0), two_sided: true }.into();
    add(&mut w, Shape::Box { size_m: DVec3::splat(4.0) }, DAffine3::IDENTITY, lit);
    add(&mut w, Shape::Sphere { radius_m: 0.9 }, DAffine3::IDENTITY, diffuse(0.5, 0.0));
    let ball: Vec<Vec3> = trace(renderer, &w)
        .iter()
        .enumerate()
        .filter(|(i, _)| i % 16 > 4 && i % 16 < 12 && i / 16 > 4 && i / 16 < 12)
        .map(|(_, p)| *p)
        .collect();
    near("a ball in a closed room", mean(&ball), 0.5, 0.004);
}

fn bounces(renderer: &mut Renderer) {
    // Under a sky, a floor shows rho once it may scatter, and nothing before.
    let mut w = world([4, 4], 64, view(DVec3::new(0.0, 1.0, 0.0), DVec3::ZERO, 0.3));
    w.sky = white_sky();
    w.render.roulette_from = 100;
    add(&mut w, quad(DVec3::Y, 1e3, 1e3), DAffine3::IDENTITY, diffuse(0.5, 0.0));
    for (max_bounces, expected) in [(0, 0.0), (1, 0.5), (5, 0.5)] {
        w.render.max_bounces = max_bounces;
        near(&format!("{max_bounces} bounces"), mean(&trace(renderer, &w)), expected, 1e-3);
    }
    // In a furnace of rho 0.5 that emits by a lamp of the sky's kind: a glass box takes two bounces to look through.
    let mut w = world([4, 4], 64, view(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.01));
    w.sky = white_sky();
    let air = glass(1.0, Color::ONE, f64::INFINITY);
    add(&mut w, Shape::Box { size_m: DVec3::ONE }, DAffine3::IDENTITY, air);
    for (max_bounces, expected) in [(0, 0.0), (1, 0.0), (2, 1.0)] {
        w.render.max_bounces = max_bounces;
        near(&format!("glass, {max_bounces} bounces"), mean(&trace(renderer, &w)), expected, 1e-3);
    }
}

// Pixel (0, 0) is top left; x runs to the right.
fn camera_axes(renderer: &mut Renderer) {
    let mut w = world([8, 4], 16, front());
    for (x, y, color) in [(1.5, 0.75, Color::X), (-1.5, 0.75, Color::Y), (1.5, -0.75, Color::Z)] {
        let lamp = Bsdf::Emitter { color, emission: Emission::Radiance(1.0), two_sided: false }.into();
        add(&mut w, quad(DVec3::Z, 3.0, 1.5), at(x, y, 0.0), lamp);
    }
    let pixels = trace(renderer, &w);
    assert_eq!([pixels[1], pixels[6], pixels[30], pixels[25]], [Vec3::Y, Vec3::X, Vec3::Z, Vec3::ZERO]);
}

// Where a point of the camera's space is in the picture, from its middle to the right and down, in heights.
fn projected(projection: &Projection<Still>, p: DVec3, aspect: f64) -> DVec2 {
    let aside = DVec2::new(p.x, -p.y);
    match *projection {
        Projection::Perspective { fov } => aside / -p.z * 0.5 / (0.5 * fov).tan(),
        Projection::Orthographic { height_m } => aside / height_m,
        Projection::Panorama => {
            DVec2::new(p.x.atan2(-p.z) / (2.0 * PI) * aspect, -p.y.atan2(DVec2::new(p.x, p.z).length()) / PI)
        }
        Projection::Fisheye { fov } => aside.normalize() * aside.length().atan2(-p.z) / fov,
    }
}

// Small balls of light, as seen by a camera that is turned and moved.
fn projections(renderer: &mut Renderer) {
    let eye = DVec3::new(3.0, -2.0, 5.0);
    let place = view(eye, eye + DVec3::new(1.0, 0.7, 0.4), 1.0).world_from_camera;
    for (projection, balls) in [
        (Projection::Perspective { fov: 1.2 }, [[2.0, 0.5, -4.0], [-1.5, 1.0, -3.0], [0.2, -1.4, -5.0]]),
        (Projection::Orthographic { height_m: 3.0 }, [[2.0, 0.5, -4.0], [-1.5, 1.2, -0.3], [0.2, -1.4, -50.0]]),
        (Projection::Panorama, [[2.0, 0.5, -4.0], [-1.5, 2.0, 3.0], [3.0, -2.4, 1.0]]),
        (Projection::Fisheye { fov: PI }, [[2.0, 0.5, -1.0], [-1.5, 1.2, -4.0], [0.2, -2.0, -0.7]]),
        (Projection::Fisheye { fov: 2.0 * PI }, [[2.0, 0.5, 1.0], [-1.5, 1.2, -4.0], [0.5, -2.0, 3.0]]),
    ] {
        let [columns, rows] = [160.0, 96.0];
        let case = format!("{projection:?}");
        let mut w = world([160, 96], 16, View { world_from_camera: place, ..front() });
        w.view.projection = projection;
        for (channel, ball) in balls.into_iter().enumerate() {
            let p = DVec3::from_array(ball);
            // Three pixels wide: whatever sample the middle's pixel has first, it meets the ball.
            let radius_m = match w.view.projection {
                Projection::Orthographic { height_m } => 1.5 * height_m / rows,
                Projection::Perspective { fov } => -1.5 * p.z * 2.0 * (0.5 * fov).tan() / rows,
                Projection::Panorama => 1.5 * PI * p.length() / rows,
                Projection::Fisheye { fov } => 1.5 * fov * p.length() / rows,
            };
            let color = Color::from(Vec3::AXES[channel]);
            let lamp = Bsdf::Emitter { color, emission: Emission::Radiance(1.0), two_sided: false }.into();
            add(&mut w, Shape::Sphere { radius_m }, DAffine3::from_translation(place.transform_point3(p)), lamp);
        }
        let film = survey(renderer, &w);
        let pixels = film.mean();
        for (channel, ball) in balls.into_iter().enumerate() {
            let p = DVec3::from_array(ball);
            let (mut sum, mut middle) = (0.0, DVec2::ZERO);
            for (i, pixel) in pixels.iter().enumerate() {
                let light = f64::from(pixel[channel]);
                sum += light;
                middle += light * DVec2::new((i % 160) as f64 + 0.5, (i / 160) as f64 + 0.5);
            }
            let at = projected(&w.view.projection, p, columns / rows) * rows + 0.5 * DVec2::new(columns, rows);
            // A ball's outline is no circle, and its middle not the ball's: less than a tenth of a pixel.
            let off = (middle / sum - at).length();
            assert!(sum > 0.5 && off < 0.2, "{case}: ball {channel} is at {}, expected {at}", middle / sum);
            let s = seen(&film, at.x as usize, at.y as usize);
            let depth = match w.view.projection {
                Projection::Perspective { .. } | Projection::Orthographic { .. } => -p.z,
                Projection::Panorama | Projection::Fisheye { .. } => p.length(),
            };
            near(&format!("{case}: depth of ball {channel}"), f64::from(s.depth), depth, 0.1 * p.length().max(2.0));
            assert_eq!(s.id as usize, channel + 1, "{case}");
        }
    }
}

fn fisheye_circle(renderer: &mut Renderer) {
    // All of a fisheye sees the sky, and of a picture 32 by 20 the circle fills π / 4 · 20 / 32.
    let mut w = world([32, 20], 256, front());
    w.view.projection = Projection::Fisheye { fov: 2.0 * PI };
    w.sky = white_sky();
    let film = survey(renderer, &w);
    let pixels = film.mean();
    near("a fisheye's circle", mean(&pixels), PI / 4.0 * 20.0 / 32.0, 2e-3);
    assert_eq!((pixels[10 * 32 + 5], pixels[10 * 32 + 7]), (Vec3::ZERO, Vec3::ONE));
    w.render.background = Background::Transparent;
    add(&mut w, Shape::Sphere { radius_m: 100.0 }, DAffine3::IDENTITY, diffuse(0.5, 0.0));
    let film = survey(renderer, &w);
    let covers: f64 = (0..640).map(|i| f64::from(film.seen(i).expect("layers").cover)).sum();
    near("a fisheye's alpha", covers / 640.0, PI / 4.0 * 20.0 / 32.0, 2e-3);
    let corner = seen(&film, 0, 0);
    assert_eq!((corner.cover, corner.depth, corner.id), (0.0, 1e10, 0));
}

// A small ball behind the plane in focus shows the lens, one before it the lens upside down; however many corners there
// are, the light is the same.
fn lens_shapes(renderer: &mut Renderer) {
    const SIDE: usize = 48;
    let (focus_m, radius_m) = (2.0_f64, 0.05);
    let mut sums = Vec::new();
    for (count, rotation, distance_m) in [(0, 0.0, 4.0), (6, 0.0, 4.0), (5, 0.4, 4.0), (3, 0.25, 4.0), (5, 0.4, 1.0)] {
        let case = format!("{count} blades turned by {rotation}, a light at {distance_m} m");
        // On the plane in focus; a negative one turns the lens upside down.
        let scale = (distance_m - focus_m) / distance_m;
        let reach = radius_m * scale.abs();
        let ball_m = 0.15 * reach;
        // The picture is 1.25 discs wide.
        let fov = 2.0 * (1.25 * reach / focus_m).atan();
        let mut w = world([SIDE as u32; 2], 512, front());
        w.view = View {
            projection: Projection::Perspective { fov },
            aperture_m: 2.0 * radius_m,
            focus_m,
            blades: Blades { count, rotation },
            ..view(DVec3::ZERO, DVec3::NEG_Z, 1.0)
        };
        let ball = Shape::Sphere { radius_m: ball_m * distance_m / focus_m };
        let power = Emission::Radiance(100.0);
        add(&mut w, ball, at(0.0, 0.0, -distance_m), emitter(power));
        let pixels = trace(renderer, &w);
        // Of a ball that is a point the disc is even: the share of the lens that each point of the picture sees.
        let area = match count {
            0 => PI,
            n => 0.5 * f64::from(n) * (2.0 * PI / f64::from(n)).sin(),
        };
        // The ball blurs the edge by its size on the plane in focus, a pixel by its own.
        let blur = (ball_m + 1.25 * reach * 2.0 / SIDE as f64) / reach;
        let even = 100.0 * (ball_m / reach).powi(2) * PI / area;
        let (mut inside, mut inner) = (0.0, 0);
        for (i, pixel) in pixels.iter().enumerate() {
            let place = |k: usize| ((k as f64 + 0.5) / SIDE as f64 * 2.0 - 1.0) * 1.25 * scale.signum();
            let p = DVec2::new(place(i % SIDE), -place(i / SIDE));
            // How far beyond the edge.
            let beyond = match count {
                0 => p.length() - 1.0,
                n => (0..n)
                    .map(|k| {
                        let turn = rotation + (f64::from(k) + 0.5) * 2.0 * PI / f64::from(n);
                        p.dot(DVec2::from_angle(turn)) - (PI / f64::from(n)).cos()
                    })
                    .fold(f64::MIN, f64::max),
            };
            if beyond > blur {
                assert_eq!(*pixel, Vec3::ZERO, "{case}: light at {p}, which is {beyond} outside");
            } else if beyond < -blur {
                inside += f64::from(pixel.x);
                inner += 1;
            }
        }
        assert!(inner > 100, "{case}");
        near(&case, inside / f64::from(inner) / even, 1.0, 0.03);
        sums.push(mean(&pixels) * (2.5 * reach / ball_m).powi(2) / 100.0);
    }
    for sum in sums {
        near("exposure by a lens", sum, PI, 0.04);
    }
}

fn odd_size(renderer: &mut Renderer) {
    for size in [[1, 1], [1, 37], [33, 17]] {
        let mut w = world(size, 3, front());
        w.sky = white_sky();
        let pixels = trace(renderer, &w);
        assert_eq!(pixels.len(), (size[0] * size[1]) as usize);
        assert!(pixels.iter().all(|p| *p == Vec3::ONE), "{size:?} has gaps");
    }
    pack(&world([16384, 16384], 1, front())).expect("the largest picture packs");
}

fn survey(renderer: &mut Renderer, world: &World) -> Film {
    let request = Request { layers: true, ..Request::default() };
    renderer.render_for(world, &request, &()).expect("the suite's worlds render")
}

fn seen(film: &Film, x: usize, y: usize) -> Seen {
    film.seen(y * film.size()[0] as usize + x).expect("layers were asked for")
}

fn layers(renderer: &mut Renderer) {
    let mut w = world([9, 9], 20, front());
    w.render.view = Shown::Albedo;
    let gold = metal(Color::new(1.0, 0.8, 0.25), 0.5);
    let coated = |metalness| {
        move |base| Material::from(Bsdf::Glossy { base, ior: 1.5, tint: Vec3::ONE, roughness: 0.0, metalness })
    };
    for (x, z, material) in
        [(-0.8, 0.0, diffuse(0.25, 0.5)), (0.0, 1.0, gold), (0.8, 0.5, emitter(Emission::Radiance(0.5)))]
    {
        add(&mut w, quad(DVec3::Z, 0.6, 0.6), at(x, 0.0, z), material);
    }
    // Behind all others, seen from its back: its normal is turned to the eye.
    w.materials.push(diffuse(0.5, 0.0));
    let base = w.materials.len() - 1;
    add(&mut w, quad(DVec3::NEG_Z, 9.0, 9.0), at(0.0, 0.0, -2.0), coated(0.0)(base));
    let film = survey(renderer, &w);
    assert_eq!((film.rays(), film.samples()), (0, 20), "a picture of colours traces light");
    let fresnel = 0.04;
    for (x, id, depth, albedo) in
        [(1, 1, 4.0, Vec3::splat(0.25)), (4, 2, 3.0, Vec3::new(1.0, 0.8, 0.25)), (7, 3, 3.5, Vec3::splat(0.5))]
    {
        let s = seen(&film, x, 4);
        assert_eq!((s.id, s.cover), (id, 1.0), "pixel {x}: {s:?}");
        assert!((s.depth - depth).abs() < 1e-5 && (s.albedo - albedo).abs().max_element() < 1e-5, "pixel {x}: {s:?}");
        assert!((s.normal - Vec3::Z).length() < 1e-5, "pixel {x}: {s:?}");
        assert!((s.position.z - (4.0 - depth)).abs() < 1e-5 && s.position.y.abs() < 0.4, "pixel {x}: {s:?}");
    }
    let back = seen(&film, 4, 0);
    assert_eq!(back.id, 4);
    assert!((back.normal - Vec3::Z).length() < 1e-5, "{back:?}");
    let expected = fresnel + (1.0 - fresnel) * 0.5;
    assert!((back.albedo.x - expected).abs() < 3e-3, "{back:?}, expected {expected}");
    // Nothing is where nothing is.
    let empty = seen(&survey(renderer, &world([2, 2], 3, front())), 1, 1);
    assert_eq!((empty.id, empty.depth, empty.cover, empty.normal), (0, 1e10, 0.0, Vec3::ZERO));
}

// A quad that a quarter of the rays meet, before one of two colours.
fn layers_pass(renderer: &mut Renderer) {
    let mut w = world([1, 1], 4096, view(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 0.01));
    let half = Material { opacity: 0.25, ..diffuse(1.0, 0.0) };
    add(&mut w, quad(DVec3::Z, 4.0, 4.0), at(0.0, 0.0, 1.0), half);
    let both = |a: usize| Material::from(Bsdf::Mix { a, b: a + 1, amount: 0.25 });
    w.materials.extend([diffuse(0.8, 0.0), diffuse(0.2, 0.0)]);
    let mixed = both(w.materials.len() - 2);
    add(&mut w, quad(DVec3::Z, 4.0, 4.0), at(0.0, 0.0, 0.0), mixed);
    let s = seen(&survey(renderer, &w), 0, 0);
    near("albedo behind a cut-out", f64::from(s.albedo.x), 0.25 + 0.75 * (0.75 * 0.8 + 0.25 * 0.2), 0.02);
    assert_eq!(s.cover, 1.0);
    assert!(s.id == 1 && s.depth == 3.0 || s.id == 2 && s.depth == 4.0, "{s:?}");
}

/// A world with surfaces of every kind, for comparing backends.
pub fn all_kinds() -> World {
    let mut w = some_world();
    w.render.samples = 4;
    w.render.filter = Filter::BlackmanHarris;
    w.render.filter_width = 1.5;
    add(&mut w, Shape::Sphere { radius_m: 0.3 }, at(-0.9, 0.6, 0.3), glass(1.5, Color::ONE, f64::INFINITY));
    add(
        &mut w,
        quad(DVec3::new(0.3, 0.2, 1.0), 0.8, 0.6),
        at(0.9, 0.0, 0.9),
        Material { opacity: 0.5, ..diffuse(0.9, 0.0) },
    );
    w
}

/// A part with a shape of every kind, one of which shines, and copies of it: turned, mirrored, stretched, inside others,
/// and of another material.
pub fn many_copies() -> World {
    let mut w = world([48, 32], 8, view(DVec3::new(0.0, 3.0, 8.0), DVec3::new(0.0, 0.8, 0.0), 0.7));
    w.sky = Some(Sky { light: SkyLight::Color(Color::new(0.4, 0.6, 1.0)), strength: 1.0, visible: true });
    add(&mut w, quad(DVec3::Y, 20.0, 20.0), DAffine3::IDENTITY, diffuse(0.5, 0.0));
    let placed = w.instances.len();
    let tetrahedron = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X * 0.6, Vec3::Y * 0.6, Vec3::Z * 0.6],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        ..Mesh::default()
    };
    add(&mut w, Shape::Box { size_m: DVec3::new(0.5, 0.3, 0.7) }, at(0.0, 0.2, 0.0), diffuse(0.8, 0.3));
    add(&mut w, Shape::Sphere { radius_m: 0.3 }, at(0.2, 0.8, 0.0), glass(1.5, Color::ONE, f64::INFINITY));
    add(&mut w, Shape::Torus { radius_m: 0.4, tube_m: 0.1 }, at(0.0, 1.3, 0.0), metal(Color::ONE, 0.2));
    add(&mut w, Shape::Mesh(Arc::new(tetrahedron)), at(-0.6, 0.0, 0.4), diffuse(0.3, 0.0));
    add(&mut w, Shape::Sphere { radius_m: 0.1 }, at(-0.3, 1.0, 0.3), emitter(Emission::Radiance(15.0)));
    w.materials.push(diffuse(0.6, 1.0));
    let other = w.materials.len() - 1;
    let turned = |angle: f64, scale: DVec3, x: f64, z: f64| {
        DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_y(angle), DVec3::new(x, 0.0, z))
    };
    let part = Part { instances: w.instances.split_off(placed), ..Part::default() };
    let copied = |part, first, places, material| Copied { node: 7, first, part, places, next: Vec::new(), material };
    let inner = vec![turned(1.0, DVec3::splat(0.4), -0.4, 0.0), turned(2.0, DVec3::new(0.5, 0.3, 0.4), 0.5, 0.3)];
    let pair = Part { copies: vec![copied(0, 50, inner, None)], ..Part::default() };
    let places = vec![
        turned(0.3, DVec3::ONE, -2.4, 0.0),
        turned(2.0, DVec3::new(1.2, 0.8, -1.0), 0.0, -1.0),
        turned(-1.0, DVec3::new(0.7, 1.3, 0.9), 2.3, 0.5),
    ];
    w.copies = vec![
        copied(0, 10, places, None),
        copied(0, 20, vec![turned(0.0, DVec3::splat(0.6), 1.1, 1.6)], Some(other)),
        copied(1, 30, vec![turned(0.5, DVec3::ONE, -1.0, 2.5), turned(-0.5, DVec3::ONE, 2.5, 2.5)], None),
    ];
    w.parts = vec![part, pair];
    w
}

/// The same world without copies.
fn written_out(w: &World) -> World {
    type Place = (DAffine3, DAffine3);
    fn follow(w: &World, copied: &Copied, at: Place, id: Option<usize>, material: Option<usize>, to: &mut World) {
        for (k, place) in copied.places.iter().enumerate() {
            let (at, next) = (at.0 * *place, at.1 * *copied.next.get(k).unwrap_or(place));
            let id = id.unwrap_or(copied.first + k);
            let (part, material) = (&w.parts[copied.part], material.or(copied.material));
            for instance in &part.instances {
                to.instances.push(Instance {
                    node: id,
                    shape: instance.shape.clone(),
                    world_from_object: at * instance.world_from_object,
                    next: instance.next.map(|inner| next * inner),
                    next_mesh: instance.next_mesh.clone(),
                    material: material.unwrap_or(instance.material),
                });
            }
            part.copies.iter().for_each(|inner| follow(w, inner, (at, next), Some(id), material, to));
        }
    }
    let mut to = World { copies: Vec::new(), parts: Vec::new(), ..w.clone() };
    let whole = (DAffine3::IDENTITY, DAffine3::IDENTITY);
    w.copies.iter().for_each(|copied| follow(w, copied, whole, None, None, &mut to));
    to
}

fn copies(renderer: &mut Renderer) {
    let w = many_copies();
    let [copied, written] = [&w, &written_out(&w)].map(|w| survey(renderer, w));
    let (a, b) = (copied.mean(), written.mean());
    near("light of copies", mean(&a), mean(&b), 0.01 * mean(&b));
    let seen = (0..a.len()).filter(|i| copied.seen(*i).expect("layers").id > 10).count();
    assert!(seen > a.len() / 20, "copies are seen in {seen} pixels");
    // A ray along an edge may fall on either side of it.
    let edges = (0..a.len()).filter(|i| {
        let (x, y) = (copied.seen(*i).expect("layers"), written.seen(*i).expect("layers"));
        let far = |x: f32, y: f32| (x - y).abs() > 1e-4 * y.abs().max(1.0);
        x.id != y.id || far(x.depth, y.depth) || far(x.normal.dot(y.normal), y.normal.dot(y.normal))
    });
    let edges = edges.count();
    assert!(edges <= a.len() / 100, "{edges} pixels show something else");
}

// Of every pixel, the point that it shows, and what a tape makes of it.
fn computed(renderer: &mut Renderer) {
    use Instruction::{Const, Point as At};
    let half = 4.0 * 0.3_f64.tan();
    let code = vec![
        At(Point::World, 0),
        At(Point::World, 1),
        Const(3.0),
        Instruction::Binary(Binary::Mul, 0, 2),
        Instruction::Binary(Binary::Mul, 1, 2),
        Const(0.4),
        Instruction::Noise([3, 4, 5]),
        Instruction::Cell(Cell::Distance, 3, [3, 4, 5]),
        Instruction::Unary(Unary::Sin, 4),
        Const(2.0),
        Instruction::Binary(Binary::Add, 6, 9),
        Instruction::Binary(Binary::Less, 3, 5),
        Instruction::Select(11, 8, 9),
        Instruction::Binary(Binary::Max, 12, 7),
    ];
    let tape = Tape { code, outputs: vec![10, 7, 13], ..Tape::default() };
    let program = Program::new(&tape).expect("a short tape");
    let size = 16;
    let mut w = world([size; 2], 1, front());
    w.render.filter_width = 1e-6;
    w.render.max_bounces = 0;
    let map = Map { slot: Slot::Color, texture: Arc::new(Texture::Tape(tape)) };
    let light = Material { maps: vec![map], ..emitter(Emission::Radiance(1.0)) };
    add(&mut w, quad(DVec3::Z, 9.0, 9.0), at(0.0, 0.0, 0.0), light);
    let along = |i: usize| (2.0 * (i as f64 + 0.5) / f64::from(size) - 1.0) * half;
    for (i, pixel) in trace(renderer, &w).iter().enumerate() {
        let point = [along(i % size as usize), -along(i / size as usize), 0.0];
        let expected = program.run(|_, part| point[usize::from(part)]);
        for (got, expected) in pixel.to_array().into_iter().zip(expected) {
            near(&format!("pixel {i}"), f64::from(got), expected, 1e-4);
        }
    }
}

// A map that is the same everywhere is what its numbers say: α 0.16 across, mix(0.16, 1, 0.56²) along, turned by 90° + 20°.
fn stretched(renderer: &mut Renderer) {
    let (across, strength) = (0.16_f64, 0.7 * 0.8);
    let along = across + (1.0 - across) * strength * strength;
    let ratio = across / along;
    let roughness = (along / (2.0 / (1.0 + ratio * ratio)).sqrt()).sqrt();
    let brushed = |roughness, anisotropy, degrees: f64, maps| Material {
        maps,
        ..Bsdf::Metal {
            reflectance: Reflectance::Tint { color: Color::splat(0.8), edge_tint: Color::ONE },
            roughness,
            anisotropy,
            anisotropy_rotation: degrees.to_radians(),
            energy_compensation: true,
        }
        .into()
    };
    let paint = || Paint::Color(Vec4::new(0.5, 1.0, 0.8, 1.0));
    let texture = Texture::Checker { a: paint(), b: paint(), scale: Vec2::ONE, uv_set: UvSet::First };
    let map = Map { slot: Slot::Stretch, texture: Arc::new(texture) };
    let mut pictures = Vec::new();
    for material in [brushed(roughness, 1.0 - ratio, 110.0, vec![]), brushed(0.4, 0.7, 20.0, vec![map])] {
        let mut w = world([16, 16], 64, front());
        add(&mut w, Shape::Sphere { radius_m: 1.0 }, DAffine3::IDENTITY, material);
        let lamp = emitter(Emission::Radiance(4.0));
        add(&mut w, quad(DVec3::Z, 2.0, 2.0), at(-1.5, 2.0, -2.0), lamp.clone());
        add(&mut w, quad(-DVec3::Z, 2.0, 1.0), at(2.0, 2.0, 5.0), lamp);
        pictures.push(trace(renderer, &w));
    }
    let all = mean(&pictures[0]);
    assert!(all > 0.05, "{all}");
    for (i, (plain, mapped)) in pictures[0].iter().zip(&pictures[1]).enumerate() {
        let off = f64::from((*plain - *mapped).abs().max_element());
        assert!(off < 0.02 * all, "pixel {i} is {mapped} by a map, {plain} without");
    }
}

fn windows(renderer: &mut Renderer) {
    let w = all_kinds();
    let whole = survey(renderer, &w);
    let light = whole.mean();
    for window in [
        Window { left: 0, top: 0, width: 40, height: 24 },
        Window { left: 7, top: 5, width: 19, height: 17 },
        Window { left: 39, top: 23, width: 1, height: 1 },
        Window { left: 13, top: 0, width: 3, height: 2 },
    ] {
        let request = Request { crop: Some(window), layers: true, ..Request::default() };
        let film = renderer.render_for(&w, &request, &()).expect("a part renders");
        let part = film.mean();
        assert_eq!((film.size(), film.picture()), ([window.width, window.height], [40, 24]));
        for y in 0..window.height {
            for x in 0..window.width {
                let i = (y * window.width + x) as usize;
                let j = ((y + window.top) * 40 + x + window.left) as usize;
                assert!(part[i] == light[j] && film.seen(i) == whole.seen(j), "{window:?} differs at {x}, {y}");
            }
        }
    }
    let outside = Request { crop: Some(Window { left: 30, top: 0, width: 11, height: 1 }), ..Request::default() };
    let refused = renderer.render_for(&w, &outside, &());
    assert!(matches!(refused, Err(RenderError::Outside { .. })), "a window outside of the picture");
}

fn transparent(renderer: &mut Renderer) {
    let mut w = world([8, 8], 64, front());
    w.sky = white_sky();
    w.render.background = Background::Transparent;
    // The left half, whose light comes from a sky that the camera does not see.
    add(&mut w, quad(DVec3::Z, 4.0, 4.0), at(-2.0, 0.0, 0.0), diffuse(0.5, 0.0));
    let film = renderer.render(&w, &()).expect("renders");
    let light = film.mean();
    for (i, light) in light.iter().enumerate() {
        let cover = film.seen(i).expect("alpha needs it").cover;
        let expected = if i % 8 < 4 { 1.0 } else { 0.0 };
        assert_eq!(cover, expected, "pixel {i}");
        assert!((light.x - 0.5 * cover).abs() < 0.02, "pixel {i}: {light}");
    }
    let image = crate::develop(&film, &w.look);
    assert_eq!(image.codes8().len(), 4 * 64);
}

// The upper half shows a sky, the lower a floor under a lamp.
fn adaptive(renderer: &mut Renderer) {
    let mut w = world([40, 40], 200, view(DVec3::new(0.0, 1.0, 4.0), DVec3::new(0.0, 1.0, 0.0), 0.8));
    w.sky = white_sky();
    w.render.adaptive = 0.006;
    add(&mut w, quad(DVec3::Y, 1e3, 1e3), DAffine3::IDENTITY, diffuse(0.5, 0.0));
    add(&mut w, Shape::Sphere { radius_m: 0.3 }, at(1.0, 3.2, 0.0), emitter(Emission::Radiance(30.0)));
    let film = renderer.render(&w, &()).expect("renders");
    let taken: Vec<u32> = (0..1600).map(|i| film.samples_of(i)).collect();
    // The horizon is in the middle.
    assert!(taken[..40 * 18].iter().all(|taken| *taken == 16), "a sky takes no more than `min_samples`");
    let floor = &taken[40 * 24..];
    let more = floor.iter().filter(|taken| **taken > 16).count();
    assert!(3 * more > 2 * floor.len(), "most of a floor does: {more} of {} pixels", floor.len());
    assert_eq!(film.mean_samples(), taken.iter().map(|taken| f64::from(*taken)).sum::<f64>() / 1600.0);
    // A part has the pixels of the whole, whatever the passes are, and a pixel those of as many samples everywhere.
    let window = Window { left: 3, top: 15, width: 9, height: 20 };
    let request = Request { crop: Some(window), layers: true, ..Request::default() };
    let mut part = renderer.load_for(&w, &request).expect("a part packs");
    assert!(!renderer.trace_pass(&mut part, 200, &|_| false).expect("stops"));
    while renderer.trace_pass(&mut part, 200, &()).expect("traces") {}
    let (whole, means) = (film.mean(), part.mean());
    for (i, mean) in means.iter().enumerate() {
        let j = (i / 9 + 15) * 40 + i % 9 + 3;
        assert!(*mean == whole[j] && part.samples_of(i) == taken[j], "the part differs at {i}");
        // Row 20 sees past the floor's end.
        if j / 40 != 20 {
            let cover = if j / 40 < 20 { 0.0 } else { 1.0 };
            assert_eq!(part.seen(i).map(|seen| seen.cover), Some(cover), "the part's layers");
        }
    }
    // Nobody near by to ask: all samples.
    w.render.resolution = [1, 1];
    assert_eq!(renderer.render(&w, &()).expect("renders").samples_of(0), 200);
    // With fewer samples than the pilot has, there is nothing to decide.
    w.render = Render { resolution: [4, 4], samples: 7, ..w.render };
    assert_eq!(renderer.render(&w, &()).expect("renders").mean_samples(), 7.0);
}

// 50 in one sample of 50: after 16 samples most pixels have seen nothing but black.
fn rare_events(renderer: &mut Renderer) {
    let mut w = world([40, 40], 256, front());
    w.render.adaptive = 0.3;
    let veil = Material { opacity: 0.02, ..emitter(Emission::Radiance(50.0)) };
    add(&mut w, quad(DVec3::Z, 10.0, 10.0), DAffine3::IDENTITY, veil);
    let film = renderer.render(&w, &()).expect("renders");
    // Its standard deviation is 1.1 % with all samples.
    near("the mean of rare events", mean(&film.mean()), 1.0, 0.06);
    assert!(film.mean_samples() > 128.0, "{} samples are enough", film.mean_samples());
}

fn in_parts(renderer: &mut Renderer, world: &World) -> Film {
    let request = Request { parts: true, ..Request::default() };
    renderer.render_for(world, &request, &()).expect("the suite's worlds render")
}

fn light(film: &Film, i: usize) -> Light {
    film.parts(i).expect("parts were asked for")
}

// Whatever the settings: surfaces of every kind, coats among them.
fn parts(renderer: &mut Renderer) {
    let mut w = all_kinds();
    w.materials.push(diffuse(0.8, 0.3));
    let base = w.materials.len() - 1;
    for (x, roughness) in [(0.3, 0.3), (-0.4, 0.0)] {
        let coated = Bsdf::Glossy { base, ior: 1.5, tint: Vec3::ONE, roughness, metalness: 0.2 };
        add(&mut w, Shape::Sphere { radius_m: 0.25 }, at(x, 0.9, 0.8), coated.into());
    }
    let pixels = 40 * 24;
    let plain = w.render.clone();
    for (case, render) in [
        ("as it is", plain.clone()),
        ("one sample", Render { mis: Mis::OneSample(0.5), ..plain.clone() }),
        ("by chance", Render { mis: Mis::BSDF, clamp: Some(2.0), ..plain.clone() }),
        ("lights alone", Render { mis: Mis::LIGHT, roulette_from: 1, ..plain.clone() }),
        ("adaptive", Render { adaptive: 0.2, min_samples: 4, samples: 40, ..plain.clone() }),
        ("transparent", Render { background: Background::Transparent, sampler: Sampler::Random, ..plain.clone() }),
    ] {
        let w = World { render, ..w.clone() };
        let film = in_parts(renderer, &w);
        let (mean, whole) = (film.mean(), trace(renderer, &w));
        let mut sums = [Vec3::ZERO; 3];
        for i in 0..pixels {
            let (light, all) = (light(&film, i), mean[i]);
            let parts = [light.emission, light.diffuse, light.specular];
            let off = (parts.iter().sum::<Vec3>() - all).abs().max_element();
            assert!(off <= 1e-5 * all.max_element(), "{case}: the parts of pixel {i} are {parts:?}, all is {all}");
            assert!(parts.iter().all(|part| part.min_element() >= 0.0), "{case}: pixel {i} has {parts:?}");
            // Another entry point of the same steps, compiled anew.
            let off = (whole[i] - all).abs().max_element();
            assert!(off <= 1e-4 * all.max_element(), "{case}: pixel {i} is {all} in parts, {} without", whole[i]);
            sums = std::array::from_fn(|k| sums[k] + parts[k]);
        }
        assert!(sums.iter().all(|sum| sum.min_element() > 1.0), "{case}: {sums:?}");
        // A part of the picture has the same pixels.
        let window = Window { left: 7, top: 5, width: 19, height: 17 };
        let request = Request { crop: Some(window), parts: true, ..Request::default() };
        let part = renderer.render_for(&w, &request, &()).expect("a part renders");
        for i in 0..window.pixels() {
            let j = (i / 19 + 5) * 40 + i % 19 + 7;
            assert!(part.parts(i) == film.parts(j), "{case}: a window differs at {i}");
        }
    }
    // A picture of something else has the same light.
    w.render.view = Shown::Normal;
    let film = in_parts(renderer, &w);
    let other = in_parts(renderer, &World { render: plain, ..w });
    assert!((0..pixels).all(|i| film.parts(i) == other.parts(i)), "the light depends on what is shown");
}

// In a room of light a coat shows its albedo, and what it covers the rest: whatever finds the light.
fn coats_in_parts(renderer: &mut Renderer) {
    let rho = 0.5;
    let lit = Bsdf::Emitter { color: Color::ONE, emission: Emission::Radiance(1.0), two_sided: true };
    for (roughness, tilt) in [(0.0, 0.0), (0.3, 0.0), (0.3, 1.0)] {
        let mut found = Vec::new();
        for mis in [Mis::Nee, Mis::LIGHT, Mis::BSDF] {
            let case = format!("a coat of roughness {roughness}, {mis:?}");
            let mut w = world([8, 8], 512, view(DVec3::new(0.0, 0.0, 1.5), DVec3::ZERO, 0.05));
            w.render.mis = mis;
            w.render.max_bounces = 1;
            add(&mut w, Shape::Box { size_m: DVec3::splat(4.0) }, DAffine3::IDENTITY, lit.clone().into());
            w.materials.push(diffuse(rho, 0.0));
            let coated =
                Bsdf::Glossy { base: w.materials.len() - 1, ior: 1.5, tint: Vec3::ONE, roughness, metalness: 0.0 };
            let turned = DAffine3::from_rotation_y(tilt);
            add(&mut w, quad(DVec3::Z, 1.0, 1.0), turned, coated.into());
            let film = in_parts(renderer, &w);
            let mean =
                |part: fn(&Light) -> Vec3| (0..64).map(|i| f64::from(part(&light(&film, i)).x)).sum::<f64>() / 64.0;
            let [emission, diffuse, specular] = [mean(|l| l.emission), mean(|l| l.diffuse), mean(|l| l.specular)];
            assert_eq!(emission, 0.0, "{case}");
            near(&case, specular + diffuse / f64::from(rho), 1.0, 0.02);
            if roughness == 0.0 {
                near(&case, specular, 0.04, 0.002);
            }
            found.push(specular);
        }
        for specular in &found {
            near(&format!("a coat of roughness {roughness}, {found:?}"), *specular, found[0], 0.005);
        }
    }
    // The room itself shines at the eye.
    let mut w = world([4, 4], 8, view(DVec3::ZERO, DVec3::Z, 1.0));
    add(&mut w, Shape::Box { size_m: DVec3::splat(4.0) }, DAffine3::IDENTITY, lit.into());
    let film = in_parts(renderer, &w);
    let seen = |i| Light { variance: Vec3::ZERO, ..light(&film, i) };
    let expected = Light { emission: Vec3::ONE, ..Light::default() };
    assert!((0..16).all(|i| seen(i) == expected), "{:?}", light(&film, 0));
}

// What seeds make of the means of pixels, against what one film says of it.
fn variance(renderer: &mut Renderer) {
    const SEEDS: u32 = 40;
    const PIXELS: usize = 20 * 12;
    for sampler in [Sampler::Random, Sampler::Sobol] {
        let mut w = some_world();
        // A whole pass and a part of one.
        w.render = Render { resolution: [20, 12], samples: 24, sampler, ..w.render };
        // Of red light: its sum, that of its squares, and that of what is told.
        let mut sums = [DVec3::ZERO; PIXELS];
        for seed in 0..SEEDS {
            w.render.seed = seed;
            let film = in_parts(renderer, &w);
            for (i, mean) in film.mean().iter().enumerate() {
                let red = f64::from(mean.x);
                sums[i] += DVec3::new(red, red * red, light(&film, i).variance.x.into());
            }
        }
        let n = f64::from(SEEDS);
        let spread = |sums: &DVec3| (sums.y - sums.x * sums.x / n) / (n - 1.0);
        let ratios: Vec<f64> = sums.iter().filter(|s| s.z > 1e-9).map(|s| spread(s) / (s.z / n)).collect();
        let ratio = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!(ratios.len() > PIXELS / 3, "{sampler:?}: {} pixels vary", ratios.len());
        match sampler {
            Sampler::Random => near("the variance of independent samples", ratio, 1.0, 0.08),
            // Their mean is better than they say one by one.
            Sampler::Sobol => assert!(ratio < 0.8, "the variance of Sobol points is {ratio} of what is told"),
        }
    }
    // Samples that are all the same have none, however many there are.
    let mut w = world([2, 2], 50, front());
    w.sky = Some(Sky { light: SkyLight::Color(Color::new(0.1, 0.3, 0.7)), strength: 1.0, visible: true });
    let film = in_parts(renderer, &w);
    assert!((0..4).all(|i| light(&film, i).variance.max_element() < 1e-14), "{:?}", light(&film, 0));
}

/// Where everything is at the next frame, if `carried` says so of each shape.
fn moving(w: &mut World, next: View, carried: impl Fn(usize) -> DAffine3) {
    w.next = Some(next);
    for (i, instance) in w.instances.iter_mut().enumerate() {
        instance.next = Some(carried(i) * instance.world_from_object);
    }
}

fn turn_about(point: DVec3, angle: f64, scale: f64, step: DVec3) -> DAffine3 {
    let axis = DVec3::new(0.3, 1.0, -0.2).normalize();
    DAffine3::from_translation(point + step)
        * DAffine3::from_scale_rotation_translation(
            DVec3::splat(scale),
            DQuat::from_axis_angle(axis, angle),
            DVec3::ZERO,
        )
        * DAffine3::from_translation(-point)
}

fn motion(renderer: &mut Renderer) {
    let eye = DVec3::new(3.0, -2.0, 5.0);
    let place = view(eye, eye + DVec3::new(1.0, 0.7, 0.4), 1.0).world_from_camera;
    // The camera moves and turns; of the balls one stays, one moves, one turns and grows.
    let next_place = turn_about(eye, 0.03, 1.0, DVec3::new(0.05, -0.03, 0.02)) * place;
    let balls = [DVec3::new(1.0, 0.5, -4.0), DVec3::new(-1.2, 1.0, -3.0), DVec3::new(0.2, -1.2, -5.0)];
    let balls = balls.map(|p| place.transform_point3(p));
    let carried = [
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::new(0.2, 0.1, -0.3)),
        turn_about(balls[2], 0.2, 1.1, DVec3::ZERO),
    ];
    for (projection, next_projection) in [
        (Projection::Perspective { fov: 1.2 }, Projection::Perspective { fov: 1.1 }),
        (Projection::Orthographic { height_m: 5.0 }, Projection::Orthographic { height_m: 5.0 }),
        (Projection::Panorama, Projection::Panorama),
        (Projection::Fisheye { fov: PI }, Projection::Fisheye { fov: 3.0 }),
    ] {
        let case = format!("{projection:?}");
        let [columns, rows] = [80.0, 48.0];
        let mut w = world([80, 48], 1, View { world_from_camera: place, projection, ..front() });
        w.render.view = Shown::Albedo;
        for ball in balls {
            let lamp = emitter(Emission::Radiance(1.0));
            add(&mut w, Shape::Sphere { radius_m: 0.7 }, DAffine3::from_translation(ball), lamp);
        }
        let now = w.view.clone();
        moving(&mut w, now.clone(), |_| DAffine3::IDENTITY);
        let film = survey(renderer, &w);
        let still = |i: &usize| film.motion(*i) == Some(glam::Vec2::ZERO);
        assert_eq!((0..80 * 48).filter(still).count(), 80 * 48, "{case}: what stays moves");

        let next = View { world_from_camera: next_place, projection: next_projection, ..front() };
        moving(&mut w, next.clone(), |i| carried[i]);
        let film = survey(renderer, &w);
        let seen_at = |view: &View, p: DVec3, far: bool| {
            let into = view.world_from_camera.inverse();
            let p = if far { into.transform_vector3(p) } else { into.transform_point3(p) };
            projected(&view.projection, p, columns / rows) * rows
        };
        let mut met = [0; 4];
        for i in 0..80 * 48 {
            let got = film.motion(i).expect("motion was asked for").as_dvec2();
            let s = film.seen(i).expect("layers");
            met[s.id as usize] += 1;
            let (expected, tolerance) = match s.id {
                0 => {
                    // What lies infinitely far away in the pixel's middle, unless all rays are parallel.
                    let at = DVec2::new((i % 80) as f64 + 0.5 - 40.0, (i / 80) as f64 + 0.5 - 24.0) / rows;
                    // Across a fisheye's edge the first sample may see nothing.
                    if matches!(now.projection, Projection::Fisheye { .. }) && (at.length() - 0.5).abs() < 0.03 {
                        continue;
                    }
                    let Some(d) = unprojected(&now.projection, at) else {
                        assert_eq!(got, DVec2::ZERO, "{case}: pixel {i}");
                        continue;
                    };
                    let d = now.world_from_camera.transform_vector3(d);
                    (seen_at(&next, d, true) - at * rows, 0.4)
                }
                id => {
                    let p = s.position.as_dvec3();
                    let moved = carried[id as usize - 1].transform_point3(p);
                    (seen_at(&next, moved, false) - seen_at(&now, p, false), 2e-3)
                }
            };
            let mut off = got - DVec2::new(expected.x, -expected.y);
            if matches!(now.projection, Projection::Panorama) {
                // Near its poles the middle of a pixel says little.
                if s.id == 0 && !(8..40).contains(&(i / 80)) {
                    continue;
                }
                off.x -= (off.x / columns).round() * columns;
            }
            assert!(off.length() < tolerance, "{case}: pixel {i} of {} moves by {got}, not {expected}", s.id);
        }
        assert!(met.iter().all(|met| *met > 5), "{case}: {met:?} pixels show each thing");
    }
}

// The direction in the camera's space that a place in the picture shows, from its middle to the right and down, in heights.
fn unprojected(projection: &Projection<Still>, at: DVec2) -> Option<DVec3> {
    match *projection {
        Projection::Perspective { fov } => Some(DVec3::new(at.x, -at.y, -0.5 / (0.5 * fov).tan())),
        Projection::Orthographic { .. } => None,
        Projection::Panorama => {
            let (longitude, latitude) = (at.x * PI * 48.0 / 40.0, -at.y * PI);
            Some(DVec3::new(latitude.cos() * longitude.sin(), latitude.sin(), -latitude.cos() * longitude.cos()))
        }
        Projection::Fisheye { fov } => {
            let angle = at.length() * fov;
            let aside = at.normalize_or_zero() * angle.sin();
            (at.length() < 0.5).then_some(DVec3::new(aside.x, -aside.y, -angle.cos()))
        }
    }
}

// A sheet whose right half is stretched and lifted, once by itself and once as a mirrored copy.
fn bent_in_motion(renderer: &mut Renderer) {
    let stretched = |p: DVec3| if p.x > 0.0 { DVec3::new(1.3 * p.x, p.y + 0.2 * p.x, 0.3 * p.x) } else { p };
    let side = 5;
    let at_grid = |i: usize| DVec3::new((i % side) as f64 - 2.0, (i / side) as f64 - 2.0, 0.0) * 0.4;
    let sheet = |place: &dyn Fn(DVec3) -> DVec3| {
        let corner = |x: usize, y: usize| (y * side + x) as u32;
        let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y)));
        let triangles = cells.flat_map(|(x, y)| {
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            [[a, b, c], [a, c, d]]
        });
        let positions = (0..side * side).map(|i| place(at_grid(i)).as_vec3()).collect();
        Arc::new(Mesh { positions, triangles: triangles.collect(), ..Mesh::default() })
    };
    let mut w = world([64, 32], 1, front());
    w.render.view = Shown::Albedo;
    let mesh = sheet(&|p| p);
    let turn = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.4), DVec3::new(-1.1, 0.0, 0.0));
    add(&mut w, Shape::Mesh(mesh.clone()), turn, emitter(Emission::Radiance(1.0)));
    add(&mut w, Shape::Mesh(mesh), DAffine3::from_rotation_z(0.3), diffuse(0.5, 0.0));
    let lifted = DAffine3::from_translation(DVec3::new(0.0, 0.1, 0.0));
    let view = w.view.clone();
    moving(&mut w, view, |i| if i == 0 { lifted } else { DAffine3::IDENTITY });
    for instance in &mut w.instances {
        instance.next_mesh = Some(sheet(&stretched));
    }
    let part = Part { instances: w.instances.split_off(1), ..Part::default() };
    let own = part.instances[0].world_from_object;
    let mirrored = DAffine3::from_scale_rotation_translation(
        DVec3::new(-1.0, 1.0, 1.0),
        DQuat::from_rotation_y(-0.3),
        DVec3::new(1.1, 0.0, 0.0),
    );
    let (places, next) = (vec![mirrored], vec![lifted * mirrored]);
    w.copies = vec![Copied { node: 7, first: 8, part: 0, places, next, material: None }];
    w.parts = vec![part];

    let film = survey(renderer, &w);
    let (mut moved, mut stayed) = (0, 0);
    for i in 0..64 * 32 {
        let seen = film.seen(i).expect("layers");
        let from = match seen.id {
            0 => continue,
            1 => turn,
            _ => mirrored * own,
        };
        let p = seen.position.as_dvec3();
        let object = from.inverse().transform_point3(p);
        // Which half a point on the fold is in is a matter of rounding, and the same to both.
        let to = (lifted * from).transform_point3(stretched(object));
        let place = |p: DVec3| {
            let into = w.view.world_from_camera.inverse();
            projected(&w.view.projection, into.transform_point3(p), 2.0) * 32.0
        };
        let way = place(to) - place(p);
        let got = film.motion(i).expect("motion").as_dvec2();
        let off = (got - DVec2::new(way.x, -way.y)).length();
        assert!(off < 2e-3, "pixel {i} of {} moves by {got}, not {way}", seen.id);
        *(if object.x > 0.0 { &mut moved } else { &mut stayed }) += 1;
    }
    assert!(moved > 100 && stayed > 100, "{moved} pixels show what is stretched, {stayed} the rest");
}

// Copies that move as wholes, and a shape that moves within all of them, as if all were written out.
fn copies_in_motion(renderer: &mut Renderer) {
    let mut w = many_copies();
    w.render = Render { view: Shown::Albedo, samples: 1, ..w.render };
    let step = DAffine3::from_translation(DVec3::new(0.1, 0.05, 0.0));
    let view = w.view.clone();
    moving(&mut w, view, |_| DAffine3::IDENTITY);
    for copied in &mut w.copies {
        copied.next = copied.places.iter().map(|place| step * *place).collect();
    }
    for part in &mut w.parts {
        for (i, instance) in part.instances.iter_mut().enumerate() {
            let turned = turn_about(DVec3::ZERO, if i % 2 == 0 { 0.1 } else { 0.0 }, 1.0, DVec3::ZERO);
            instance.next = Some(turned * instance.world_from_object);
        }
        for copied in &mut part.copies {
            copied.next = copied.places.clone();
        }
    }
    let [copied, written] = [&w, &written_out(&w)].map(|w| survey(renderer, w));
    let mut moved = 0;
    for i in 0..48 * 32 {
        let (a, b) = (copied.seen(i).expect("layers"), written.seen(i).expect("layers"));
        let (there, here) = (copied.motion(i).expect("motion"), written.motion(i).expect("motion"));
        // A ray along an edge may fall on either side of it.
        if a.id != b.id || (a.position - b.position).length() > 1e-3 {
            continue;
        }
        assert!((there - here).length() < 2e-3, "pixel {i} moves by {there}, written out by {here}");
        assert_eq!(a.id < 10, there == glam::Vec2::ZERO, "pixel {i} of {} moves by {there}", a.id);
        moved += usize::from(a.id >= 10);
    }
    assert!(moved > 48 * 32 / 20, "{moved} pixels show copies");
}
