//! Rigid bodies against closed forms, and what is kept of them.
#![cfg(feature = "physics")]

mod common;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use common::{node, scene};
use glam::{DQuat, DVec3};
use kinora_animator::physics::{Bake, BakeError, Cache, Next, NoCache, Progress, bake};
use kinora_animator::sample;
use kinora_scene::{Animated, Body, BodyKind, Collider, Frame, Joint, JointKind, Mass, Mesh, Scene, Shape, Shutter};

const G: f64 = 9.81;

fn no_bodies() -> Scene {
    let mut scene = scene();
    scene.nodes.clear();
    scene
}

/// A body of this shape at this place.
fn add(scene: &mut Scene, name: &str, shape: Shape<Animated>, at: [f64; 3], kind: BodyKind) -> usize {
    let index = scene.nodes.len();
    let mut node = node(name, None, Some(shape));
    node.placing.position = DVec3::from_array(at).into();
    scene.nodes.push(node);
    scene.physics.bodies.push(Body {
        node: index,
        kind,
        mass: Mass::Density(1000.0),
        friction: 0.5,
        restitution: 0.0,
        velocity: DVec3::ZERO,
        angular_velocity: DVec3::ZERO,
        linear_damping: 0.0,
        angular_damping: 0.0,
        collider: Collider::Auto,
        impulse: DVec3::ZERO,
        impulse_at_s: 0.0,
    });
    index
}

fn ball(radius: f64) -> Shape<Animated> {
    Shape::Sphere { radius_m: radius.into() }
}

fn cuboid(size: [f64; 3]) -> Shape<Animated> {
    Shape::Box { size_m: DVec3::from_array(size) }
}

fn ground(scene: &mut Scene) -> usize {
    let frame = Frame::facing(DVec3::Y, DVec3::Y).unwrap();
    add(scene, "ground", Shape::Plane { frame }, [0.0; 3], BodyKind::Fixed)
}

/// The body that was added last.
fn last(scene: &mut Scene) -> &mut Body {
    scene.physics.bodies.last_mut().unwrap()
}

fn baked(scene: &Scene, duration_s: f64) -> Scene {
    let mut scene = scene.clone();
    scene.physics.simulation.duration_s = duration_s;
    let bake = bake(&scene, &mut NoCache, false, &mut |_| Next::Step).unwrap().unwrap();
    scene.physics.baked = Some(bake.baked);
    scene
}

fn place(scene: &Scene, node: usize, time_s: f64) -> glam::DAffine3 {
    let world = sample(scene, Shutter { open_s: time_s, close_s: time_s }).unwrap();
    world.instances.iter().find(|instance| instance.node == node).unwrap().world_from_object
}

fn at(scene: &Scene, node: usize, time_s: f64) -> DVec3 {
    place(scene, node, time_s).translation
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: {found} is not {expected} ± {tolerance}");
}

#[test]
fn falls_and_throws() {
    let mut scene = no_bodies();
    let falling = add(&mut scene, "ball", ball(0.1), [0.0, 100.0, 0.0], BodyKind::Dynamic);
    let thrown = add(&mut scene, "thrown", cuboid([0.2, 0.3, 0.4]), [50.0, 0.0, 0.0], BodyKind::Dynamic);
    let v = 20.0 * (0.25 * PI).sin();
    last(&mut scene).velocity = DVec3::new(v, v, 0.0);
    last(&mut scene).angular_velocity = DVec3::new(0.0, 3.0, 0.0);
    let damped = add(&mut scene, "damped", ball(0.1), [-50.0, 0.0, 0.0], BodyKind::Dynamic);
    last(&mut scene).velocity = DVec3::new(0.0, 0.0, 5.0);
    last(&mut scene).linear_damping = 0.8;
    let pushed = add(&mut scene, "pushed", ball(0.1), [0.0, 0.0, 50.0], BodyKind::Dynamic);
    last(&mut scene).mass = Mass::Total(2.0);
    last(&mut scene).impulse = DVec3::new(3.0, 0.0, 0.0);
    // Not at a step.
    last(&mut scene).impulse_at_s = 0.503;
    let scene = baked(&scene, 2.5);
    for t in [0.0, 0.25, 1.0, 1.5, 2.0, 2.0 + 1.0 / 24.0] {
        near("fall", at(&scene, falling, t).y, 100.0 - 0.5 * G * t * t, 1e-4);
        let p = at(&scene, thrown, t);
        near("range", p.x, 50.0 + v * t, 1e-4);
        near("height", p.y, v * t - 0.5 * G * t * t, 1e-4);
        let p = at(&scene, damped, t);
        near("damped way", p.z, 5.0 * (1.0 - (-0.8 * t).exp()) / 0.8, 1e-4);
        near("damped fall", p.y, -G / 0.8 * (t - (1.0 - (-0.8 * t).exp()) / 0.8), 2e-4);
        near("push", at(&scene, pushed, t).x, 1.5 * (t - 0.503f64).max(0.0), if t > 0.6 { 2e-5 } else { 3e-3 });
    }
    // After the end they rest.
    assert_eq!(at(&scene, falling, 2.5), at(&scene, falling, 100.0));
    assert_eq!(at(&scene, falling, 0.0), at(&scene, falling, -3.0));
}

#[test]
fn spins() {
    // I = (1, 2, 3) up to a factor, w = (0.1, 2, 0.1): values of two integrators.
    let mut scene = no_bodies();
    scene.physics.simulation.gravity = DVec3::ZERO;
    // y² + z², x² + z² and x² + y² are as 1 : 2 : 3.
    let top = add(&mut scene, "top", cuboid([2f64.sqrt(), 1.0, 1e-4]), [0.0; 3], BodyKind::Dynamic);
    last(&mut scene).angular_velocity = DVec3::new(0.1, 2.0, 0.1);
    let wheel = add(&mut scene, "wheel", ball(0.5), [5.0, 0.0, 0.0], BodyKind::Dynamic);
    last(&mut scene).angular_velocity = DVec3::new(0.0, 50.0, 0.0);
    let slowed = add(&mut scene, "slowed", ball(0.5), [9.0, 0.0, 0.0], BodyKind::Dynamic);
    last(&mut scene).angular_velocity = DVec3::new(0.0, 0.0, 4.0);
    last(&mut scene).angular_damping = 0.5;
    let scene = baked(&scene, 5.5);
    let turn = |node: usize, t: f64| glam::DQuat::from_mat3(&place(&scene, node, t).matrix3);
    // Its spin at 5 s, in its own axes, from the turn of one step.
    let dt = 1.0 / 240.0;
    let between = (turn(top, 5.0).inverse() * turn(top, 5.0 + dt)).to_scaled_axis() / dt;
    for (found, expected) in between.to_array().into_iter().zip([-1.206774, -1.598029, 0.701499]) {
        near("spin of a top", found, expected, 2e-2);
    }
    let angle = |q: DQuat, axis: DVec3| 2.0 * DVec3::new(q.x, q.y, q.z).dot(axis).atan2(q.w);
    let off = |found: f64, expected: f64| (found - expected + PI).rem_euclid(TAU) - PI;
    near("a wheel", off(angle(turn(wheel, 4.0), DVec3::Y), 200.0), 0.0, 1e-3);
    let expected = 4.0 * (1.0 - (-0.5 * 3.0f64).exp()) / 0.5;
    near("a slowed one", off(angle(turn(slowed, 3.0), DVec3::Z), expected), 0.0, 1e-3);
}

#[test]
fn slides_and_rolls() {
    let mut scene = no_bodies();
    ground(&mut scene);
    last(&mut scene).friction = 0.4;
    let slid = add(&mut scene, "box", cuboid([0.4, 0.2, 0.4]), [0.0, 0.1, 0.0], BodyKind::Dynamic);
    last(&mut scene).friction = 0.2;
    last(&mut scene).velocity = DVec3::new(2.0, 0.0, 0.0);
    let rolled = add(&mut scene, "ball", ball(0.1), [0.0, 0.1, 5.0], BodyKind::Dynamic);
    // The mean with the ground's is 0.2.
    last(&mut scene).friction = 0.0;
    last(&mut scene).velocity = DVec3::new(3.0, 0.0, 0.0);
    let scene = baked(&scene, 3.0);
    near("slide", at(&scene, slid, 3.0).x, 4.0 / (2.0 * 0.3 * G), 3e-3);
    near("height", at(&scene, slid, 3.0).y, 0.1, 1e-4);
    let speed = (at(&scene, rolled, 2.5).x - at(&scene, rolled, 1.5).x) / 1.0;
    near("rolling", speed, 2.142857, 1e-2);

    // Down a slope of 30 degrees.
    let mut scene = no_bodies();
    let frame = Frame::facing(DVec3::new(0.5, 0.75f64.sqrt(), 0.0), DVec3::Y).unwrap();
    add(&mut scene, "slope", Shape::Plane { frame }, [0.0; 3], BodyKind::Fixed);
    let from = 0.1 * DVec3::new(0.5, 0.75f64.sqrt(), 0.0);
    let rolled = add(&mut scene, "ball", ball(0.1), from.to_array(), BodyKind::Dynamic);
    let stuck = add(&mut scene, "stuck", cuboid([0.2, 0.2, 0.2]), [0.0, 0.0, 3.0], BodyKind::Dynamic);
    last(&mut scene).friction = 0.8;
    scene.nodes[stuck].placing.rotation = DQuat::from_rotation_z(-PI / 6.0).into();
    scene.nodes[stuck].placing.position = (from + DVec3::Z * 3.0).into();
    let scene = baked(&scene, 2.0);
    for t in [1.0, 2.0] {
        let way = (at(&scene, rolled, t) - from).length();
        near("roll down", way, 0.5 * 3.503571 * t * t, 5e-3 * way);
    }
    near("sticks", (at(&scene, stuck, 2.0) - at(&scene, stuck, 0.0)).length(), 0.0, 1e-3);
}

/// The highest points of a body, in order.
fn peaks(scene: &Scene, node: usize, from_s: f64, to_s: f64) -> Vec<f64> {
    let heights: Vec<f64> =
        (0..).map(|i| from_s + f64::from(i) / 2400.0).take_while(|t| *t < to_s).map(|t| at(scene, node, t).y).collect();
    heights.windows(3).filter(|w| w[1] > w[0] && w[1] >= w[2]).map(|w| w[1]).collect()
}

#[test]
fn bounces() {
    for (restitution, expected) in
        [(0.8, [1.28, 0.8192, 0.524288, 0.335544]), (1.0, [2.0; 4]), (0.5, [0.5, 0.125, 0.03125, 0.0078125])]
    {
        let mut scene = no_bodies();
        ground(&mut scene);
        last(&mut scene).restitution = restitution;
        let dropped = add(&mut scene, "ball", ball(0.1), [0.0, 2.1, 0.0], BodyKind::Dynamic);
        last(&mut scene).restitution = restitution;
        let flat = add(&mut scene, "box", cuboid([0.3, 0.2, 0.3]), [3.0, 2.1, 0.0], BodyKind::Dynamic);
        last(&mut scene).restitution = restitution;
        let scene = baked(&scene, 6.0);
        for node in [dropped, flat] {
            let peaks = peaks(&scene, node, 0.1, 6.0);
            for (found, expected) in peaks.iter().zip(expected) {
                near(&format!("bounce of {node} with {restitution}"), found - 0.1, expected, 2e-3 * expected + 5e-4);
            }
            assert!(peaks.len() >= 3, "{peaks:?}");
        }
    }
    // Balls of one mass change their speeds.
    let mut scene = no_bodies();
    scene.physics.simulation.gravity = DVec3::ZERO;
    let a = add(&mut scene, "a", ball(0.1), [0.0; 3], BodyKind::Dynamic);
    last(&mut scene).restitution = 1.0;
    last(&mut scene).velocity = DVec3::new(2.0, 0.0, 0.0);
    let b = add(&mut scene, "b", ball(0.1), [1.0, 0.0, 0.0], BodyKind::Dynamic);
    last(&mut scene).restitution = 1.0;
    let scene = baked(&scene, 2.0);
    near("a stops", at(&scene, a, 2.0).x, 0.8, 1e-3);
    near("b goes on", at(&scene, b, 2.0).x, 1.0 + 2.0 * 1.6, 2e-3);
}

/// A bob that hangs from the origin, at this angle from straight down.
fn pendulum(degrees: f64) -> (Scene, usize) {
    let mut scene = no_bodies();
    let post = add(&mut scene, "post", ball(0.01), [0.0; 3], BodyKind::Fixed);
    let angle = degrees.to_radians();
    let bob = add(&mut scene, "bob", ball(0.005), [angle.sin(), -angle.cos(), 0.0], BodyKind::Dynamic);
    let joint = Joint { name: "pivot".into(), a: post, b: bob, anchor: None, kind: JointKind::Ball };
    scene.physics.joints.push(joint);
    (scene, bob)
}

/// Times when a body comes through x = 0 from the right.
fn crossings(scene: &Scene, node: usize, to_s: f64) -> Vec<f64> {
    let step = 1.0 / 240.0;
    let x = |t: f64| at(scene, node, t).x;
    let mut found = Vec::new();
    let mut t = 0.0;
    while t < to_s {
        let (from, to) = (x(t), x(t + step));
        if from > 0.0 && to <= 0.0 {
            found.push(t + step * from / (from - to));
        }
        t += step;
    }
    found
}

#[test]
fn pendulums_swing() {
    for (degrees, period) in [(30.0, 2.040990), (90.0, 2.367842)] {
        let (scene, bob) = pendulum(degrees);
        let scene = baked(&scene, 10.0);
        let found = crossings(&scene, bob, 10.0);
        near("first quarter", found[0], 0.25 * period, 2e-3);
        for pair in found.windows(2) {
            near(&format!("period from {degrees}°"), pair[1] - pair[0], period, 1e-3);
        }
        for t in [0.5, 3.0, 9.0] {
            near("length", at(&scene, bob, t).length(), 1.0, 1e-4);
        }
    }
}

#[test]
fn springs_swing() {
    for (mass, stiffness) in [(1.0, 100.0), (2.0, 20.0), (0.5, 4000.0)] {
        let mut scene = no_bodies();
        let post = add(&mut scene, "post", ball(0.01), [0.0; 3], BodyKind::Fixed);
        let bob = add(&mut scene, "bob", ball(0.05), [0.0, -1.0, 0.0], BodyKind::Dynamic);
        last(&mut scene).mass = Mass::Total(mass);
        let kind = JointKind::Spring { length_m: None, stiffness, damping: 0.0 };
        scene.physics.joints.push(Joint { name: "spring".into(), a: post, b: bob, anchor: None, kind });
        let scene = baked(&scene, 4.0);
        let (sag, omega) = (mass * G / stiffness, (stiffness / mass).sqrt());
        for i in 0..40 {
            let t = 0.1 * f64::from(i);
            let expected = -1.0 - sag * (1.0 - (omega * t).cos());
            near(&format!("spring of {stiffness} N/m at {t}"), at(&scene, bob, t).y, expected, 0.04 * sag);
        }
    }
    // One with damping, and one that is stiffer than the steps are short.
    let mut scene = no_bodies();
    scene.physics.simulation.gravity = DVec3::ZERO;
    let post = add(&mut scene, "post", ball(0.01), [0.0; 3], BodyKind::Fixed);
    let mut ends = Vec::new();
    for (z, stiffness, damping) in [(0.0, 100.0, 4.0), (1.0, 1e9, 0.0)] {
        let bob = add(&mut scene, "bob", ball(0.05), [1.0, 0.0, z], BodyKind::Dynamic);
        last(&mut scene).mass = Mass::Total(1.0);
        let kind = JointKind::Spring { length_m: Some(if z == 0.0 { 0.8 } else { 1.0 }), stiffness, damping };
        let anchor = Some(DVec3::new(0.0, 0.0, z));
        scene.physics.joints.push(Joint { name: "spring".into(), a: post, b: bob, anchor, kind });
        ends.push(bob);
    }
    let scene = baked(&scene, 3.0);
    for i in 0..30 {
        let t = 0.1 * f64::from(i);
        let (decay, omega) = (2.0, (100.0f64 - 4.0).sqrt());
        let expected = 0.8 + 0.2 * (-decay * t).exp() * ((omega * t).cos() + decay / omega * (omega * t).sin());
        near("damped spring", at(&scene, ends[0], t).x, expected, 2e-3);
        near("stiff spring", at(&scene, ends[1], t).x, 1.0, 1e-3);
    }
}

#[test]
fn hinges_and_sliders() {
    let mut scene = no_bodies();
    scene.physics.simulation.gravity = DVec3::ZERO;
    let frame = add(&mut scene, "frame", ball(0.01), [0.0; 3], BodyKind::Fixed);
    let mut bodies = Vec::new();
    let hinge =
        |limits: Option<[f64; 2]>, motor_velocity| JointKind::Hinge { axis: DVec3::Y * 2.0, limits, motor_velocity };
    let slider =
        |limits: Option<[f64; 2]>, motor_velocity| JointKind::Slider { axis: DVec3::X, limits, motor_velocity };
    for (i, kind) in [
        hinge(None, Some(1.5)),
        hinge(Some([-0.5, 1.0]), Some(2.0)),
        slider(None, Some(0.25)),
        slider(Some([-0.2, 0.3]), Some(-1.0)),
        JointKind::Fixed,
    ]
    .into_iter()
    .enumerate()
    {
        let y = 2.0 * i as f64;
        let body = add(&mut scene, "part", cuboid([0.4, 0.2, 0.1]), [0.5, y, 0.0], BodyKind::Dynamic);
        if kind == JointKind::Fixed {
            last(&mut scene).velocity = DVec3::new(1.0, 2.0, 3.0);
        }
        let anchor = Some(DVec3::new(0.0, y, 0.0));
        scene.physics.joints.push(Joint { name: "joint".into(), a: frame, b: body, anchor, kind });
        bodies.push(body);
    }
    let scene = baked(&scene, 2.0);
    let angle = |node: usize, t: f64| {
        let x = place(&scene, node, t).matrix3.x_axis;
        // About +y, z goes to x.
        (-x.z).atan2(x.x)
    };
    near("motor of a hinge", angle(bodies[0], 1.2), 1.8, 1e-2);
    let p = at(&scene, bodies[0], 1.2);
    near("on its arc", (p - DVec3::new(0.5 * 1.8f64.cos(), 0.0, -0.5 * 1.8f64.sin())).length(), 0.0, 1e-2);
    near("limit of a hinge", angle(bodies[1], 2.0), 1.0, 1e-2);
    near("motor of a slider", at(&scene, bodies[2], 2.0).x, 1.0, 1e-2);
    near("limit of a slider", at(&scene, bodies[3], 2.0).x, 0.3, 5e-3);
    near("fixed", (at(&scene, bodies[4], 2.0) - DVec3::new(0.5, 8.0, 0.0)).length(), 0.0, 1e-3);
}

#[test]
fn stacks_stand() {
    for (count, size) in [(5, 0.2), (10, 0.2), (6, 1.0), (8, 0.03)] {
        let mut scene = no_bodies();
        ground(&mut scene);
        let boxes: Vec<usize> = (0..count)
            .map(|i| {
                let y = size * (f64::from(i) + 0.5);
                add(&mut scene, "box", cuboid([size; 3]), [0.0, y, 0.0], BodyKind::Dynamic)
            })
            .collect();
        let scene = baked(&scene, 5.0);
        for (i, node) in boxes.into_iter().enumerate() {
            let expected = DVec3::new(0.0, size * (i as f64 + 0.5), 0.0);
            near(&format!("box {i} of {count} of {size}"), (at(&scene, node, 5.0) - expected).length(), 0.0, 1e-3);
        }
    }
}

#[test]
fn what_rests_wakes() {
    let mut scene = no_bodies();
    ground(&mut scene);
    let pushed = add(&mut scene, "box", cuboid([0.2; 3]), [0.0, 0.1, 0.0], BodyKind::Dynamic);
    last(&mut scene).mass = Mass::Total(2.0);
    last(&mut scene).impulse = DVec3::new(4.0, 0.0, 0.0);
    last(&mut scene).impulse_at_s = 4.0;
    let drifting = add(&mut scene, "ball", ball(0.1), [0.0, 0.1, 5.0], BodyKind::Dynamic);
    last(&mut scene).friction = 0.0;
    last(&mut scene).velocity = DVec3::new(0.05, 0.0, 0.0);
    let moved = add(&mut scene, "pusher", cuboid([0.2; 3]), [-1.0, 0.1, 9.0], BodyKind::Kinematic);
    let key =
        |time_s, x| kinora_scene::Key { time_s, value: DVec3::new(x, 0.1, 9.0), ease: kinora_scene::Ease::Linear };
    scene.nodes[moved].placing.position = kinora_scene::Track::Keys(kinora_scene::Keys {
        keys: vec![key(0.0, -1.0), key(3.0, -1.0), key(5.0, 1.0)],
        outside: kinora_scene::Outside::Hold,
        way: kinora_scene::Way::Straight,
    });
    let shoved = add(&mut scene, "shoved", cuboid([0.2; 3]), [0.0, 0.1, 9.0], BodyKind::Dynamic);
    let scene = baked(&scene, 6.0);
    near("waits", at(&scene, pushed, 3.9).x, 0.0, 1e-4);
    near("slides", at(&scene, pushed, 6.0).x, 4.0 / (2.0 * 0.5 * G), 4e-3);
    assert!(at(&scene, drifting, 6.0).x > 0.2, "{}", at(&scene, drifting, 6.0));
    near("waits for the pusher", at(&scene, shoved, 3.0).x, 0.0, 1e-4);
    near("is pushed", at(&scene, shoved, 6.0).x, 1.2 + 1.0 / (2.0 * 0.5 * G), 1e-2);
    near("goes its way", at(&scene, moved, 4.0).x, 0.0, 1e-9);
}

/// A tetrahedron of these corners.
fn tetrahedron() -> Shape<Animated> {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(glam::Vec3::from_array);
    let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    Shape::Mesh(Arc::new(Mesh { positions: positions.to_vec(), triangles, ..Mesh::default() }))
}

#[test]
fn colliders_have_the_scale() {
    let frame = Frame::facing(DVec3::Y, DVec3::Y).unwrap();
    let scaled = [
        ("box", cuboid([1.0, 1.0, 1.0]), [0.3, 0.2, 0.5], 0.1),
        ("sphere", ball(0.5), [0.4, 0.4, 0.4], 0.2),
        ("ellipsoid", ball(0.5), [1.0, 0.4, 1.0], 0.2),
        ("cylinder", Shape::Cylinder { radius_m: 0.5, height_m: 1.0, capped: true }, [0.4, 0.2, 0.4], 0.1),
        ("cone", Shape::Cone { radius_m: 0.5, height_m: 1.0, capped: true }, [0.4, 0.2, 0.4], 0.1),
        ("mirrored", Shape::Cylinder { radius_m: 0.5, height_m: 1.0, capped: true }, [-0.4, 0.2, 0.4], 0.1),
        ("torus", Shape::Torus { radius_m: 0.5, tube_m: 0.1 }, [0.5, 0.5, 0.5], 0.05),
        ("quad", Shape::Quad { frame, size_m: glam::DVec2::ONE }, [0.5, 1.0, 0.2], 0.0005),
        ("disk", Shape::Disk { frame, radius_m: 0.5 }, [0.5, 0.5, 0.5], 0.0005),
        ("mesh", tetrahedron(), [0.5, 0.25, 0.5], 0.0),
    ];
    for (name, shape, scale, height) in scaled {
        let mut scene = no_bodies();
        ground(&mut scene);
        let node = add(&mut scene, name, shape, [0.0, height + 0.001, 0.0], BodyKind::Dynamic);
        scene.nodes[node].placing.scale = DVec3::from_array(scale).into();
        let scene = baked(&scene, 2.0);
        // A hull of points rests on one of its faces.
        near(name, at(&scene, node, 2.0).y, height, if name == "ellipsoid" { 1e-2 } else { 1e-3 });
        let matrix = place(&scene, node, 2.0).matrix3;
        near("scale", matrix.determinant(), scale.iter().product(), 1e-5);
    }
}

#[test]
fn groups_and_other_bodies() {
    // A dumb-bell is one body; a body in it is none of its parts.
    let mut scene = no_bodies();
    ground(&mut scene);
    let whole = add(&mut scene, "whole", ball(1.0), [0.0, 1.0, 0.0], BodyKind::Dynamic);
    scene.nodes[whole].shape = None;
    for x in [-0.5, 0.5] {
        let mut part = node("part", Some(whole), Some(ball(0.2)));
        part.placing.position = DVec3::new(x, 0.0, 0.0).into();
        scene.nodes.push(part);
    }
    let inner = add(&mut scene, "inner", ball(0.1), [0.0, 0.0, 3.0], BodyKind::Dynamic);
    scene.nodes[inner].parent = Some(whole);
    let scene = baked(&scene, 2.0);
    near("a group lies on its parts", at(&scene, 2, 2.0).y, 0.2, 1e-3);
    near("a body in it falls by itself", at(&scene, inner, 2.0).y, 0.1, 1e-3);
    near("where it was", at(&scene, inner, 2.0).z, 3.0, 1e-3);
}

/// A cache that remembers, and whose writes may fail.
#[derive(Clone, Default)]
struct Memory {
    bake: Option<Vec<u8>>,
    part: Vec<u8>,
    broken: bool,
}

impl Cache for Memory {
    fn read(&mut self) -> Option<Vec<u8>> {
        self.bake.clone()
    }
    fn write(&mut self, bytes: &[u8]) -> Result<(), String> {
        if self.broken {
            return Err("the disk is full".into());
        }
        (self.bake, self.part) = (Some(bytes.to_vec()), Vec::new());
        Ok(())
    }
    fn read_part(&mut self) -> Option<Vec<u8>> {
        Some(self.part.clone())
    }
    fn write_part(&mut self, keep: usize, bytes: &[u8]) -> Result<(), String> {
        if self.broken {
            return Err("the disk is full".into());
        }
        self.part.truncate(keep);
        self.part.extend(bytes);
        Ok(())
    }
}

/// A few bodies that meet, with joints and a spring.
fn busy() -> Scene {
    let mut scene = no_bodies();
    ground(&mut scene);
    for i in 0..20 {
        let (x, y) = (0.3 * f64::from(i % 5), 0.3 + 0.25 * f64::from(i / 5));
        add(&mut scene, "box", cuboid([0.2, 0.2, 0.3]), [x, y, 0.02 * f64::from(i)], BodyKind::Dynamic);
        last(&mut scene).restitution = 0.3;
    }
    let post = add(&mut scene, "post", ball(0.01), [-1.0, 2.0, 0.0], BodyKind::Fixed);
    for (x, kind) in
        [(-0.4, JointKind::Ball), (-1.5, JointKind::Spring { length_m: None, stiffness: 30.0, damping: 0.1 })]
    {
        let bob = add(&mut scene, "bob", ball(0.1), [x, 2.0, 0.0], BodyKind::Dynamic);
        scene.physics.joints.push(Joint { name: "joint".into(), a: post, b: bob, anchor: None, kind });
    }
    scene.physics.simulation.duration_s = 1.5;
    scene
}

fn run(scene: &Scene, cache: &mut Memory, next: &mut dyn FnMut(Progress<'_>) -> Next) -> Result<Bake, BakeError> {
    Ok(bake(scene, cache, false, next)?.unwrap())
}

#[test]
fn the_same_bytes() {
    let scene = busy();
    let mut first = Memory::default();
    let made = run(&scene, &mut first, &mut |_| Next::Step).unwrap();
    assert!(!made.kept && first.part.is_empty());
    for _ in 0..2 {
        let mut again = Memory::default();
        assert_eq!(run(&scene, &mut again, &mut |_| Next::Step).unwrap().baked, made.baked);
        assert!(again.bake == first.bake);
    }
    let kept = run(&scene, &mut first, &mut |_| panic!("nothing is to be done")).unwrap();
    assert!(kept.kept && kept.baked == made.baked && kept.key == made.key);
}

#[test]
fn what_is_known_meanwhile_is_the_beginning_of_the_whole() {
    let scene = busy();
    let whole = run(&scene, &mut Memory::default(), &mut |_| Next::Step).unwrap().baked;
    let bodies = whole.bodies.len();
    let mut looks = 0;
    let mut look = |done: Progress<'_>| {
        if done.step.is_multiple_of(50) || done.step == done.steps {
            let so_far = (done.baked)();
            assert_eq!(so_far.poses.len() as u64, (done.step + 1) * bodies as u64);
            assert_eq!(so_far.poses, whole.poses[..so_far.poses.len()]);
            assert_eq!((so_far.bodies, so_far.origin), (whole.bodies.clone(), whole.origin));
            looks += 1;
        }
        Next::Step
    };
    run(&scene, &mut Memory::default(), &mut look).unwrap();
    assert!(looks >= 3, "{looks}");
}

#[test]
fn stopped_and_resumed() {
    let scene = busy();
    let mut whole = Memory::default();
    run(&scene, &mut whole, &mut |_| Next::Step).unwrap();
    // Stopped after every so many steps, with some more lost as a kill would lose them, and torn records.
    let mut cache = Memory::default();
    let mut runs = 0;
    loop {
        let mut steps = 0;
        let result = run(&scene, &mut cache, &mut |_| {
            steps += 1;
            match steps {
                30 | 60 => Next::Keep,
                75 => Next::Stop,
                _ => Next::Step,
            }
        });
        runs += 1;
        match result {
            Ok(_) => break,
            Err(error) => assert_eq!(error, BakeError::Stopped),
        }
        if runs % 2 == 0 {
            let torn = cache.part.len() - 7;
            cache.part.truncate(torn);
        }
        assert!(runs < 30 && !cache.part.is_empty());
    }
    assert!(runs > 4, "{runs}");
    assert!(cache.bake == whole.bake && cache.part.is_empty());
    // What is unfinished of other bodies, or is no such thing, is no help and no harm.
    let mut other = busy();
    other.physics.bodies[1].friction = 0.9;
    let mut cache = Memory::default();
    run(&other, &mut cache, &mut |done| if done.step == 100 { Next::Stop } else { Next::Step }).unwrap_err();
    run(&scene, &mut cache, &mut |_| Next::Step).unwrap();
    assert!(cache.bake == whole.bake);
    let mut cache = Memory { part: vec![7; 1000], ..Memory::default() };
    run(&scene, &mut cache, &mut |_| Next::Keep).unwrap();
    assert!(cache.bake == whole.bake);
    // Where nothing can be kept, the result is the same.
    let mut cache = Memory { broken: true, ..Memory::default() };
    let made = run(&scene, &mut cache, &mut |_| Next::Keep).unwrap();
    assert_eq!(made.not_kept.as_deref(), Some("the disk is full"));
}

#[test]
fn what_makes_a_bake_stale() {
    let scene = busy();
    let mut cache = Memory::default();
    let made = run(&scene, &mut cache, &mut |_| Next::Step).unwrap();
    let kept = |scene: &Scene| bake(scene, &mut cache.clone(), true, &mut |_| Next::Step).is_ok();
    assert!(kept(&scene));
    // What physics does not see.
    let mut same = scene.clone();
    same.materials.push(kinora_scene::Material::default_diffuse());
    same.cameras.push(common::camera(DVec3::X, DVec3::ZERO));
    same.nodes[3].material = 1;
    same.nodes[4].visible = false.into();
    same.nodes[5].name = "other".into();
    same.nodes.push(node("decoration", None, Some(ball(3.0))));
    same.clock.duration_s = 9.0;
    same.render.samples = 7;
    assert!(kept(&same));
    // What it sees.
    type Edit = fn(&mut Scene);
    let edits: [Edit; 12] = [
        |scene| scene.nodes[2].placing.position = DVec3::new(9.0, 0.0, 0.0).into(),
        |scene| scene.nodes[2].placing.scale = DVec3::splat(1.1).into(),
        |scene| scene.nodes[2].shape = Some(cuboid([0.2, 0.2, 0.31])),
        |scene| scene.physics.bodies[2].mass = Mass::Density(999.0),
        |scene| scene.physics.bodies[2].restitution = 0.31,
        |scene| scene.physics.bodies[2].collider = Collider::Sphere,
        |scene| scene.physics.bodies[2].velocity.x = 1.0,
        |scene| scene.physics.joints[1].kind = JointKind::Spring { length_m: None, stiffness: 31.0, damping: 0.1 },
        |scene| scene.physics.joints[0].anchor = Some(DVec3::X),
        |scene| scene.physics.simulation.gravity.x = 0.1,
        |scene| scene.physics.simulation.rate_hz = 241.0,
        |scene| scene.physics.simulation.duration_s = 1.6,
    ];
    for (i, edit) in edits.into_iter().enumerate() {
        let mut other = scene.clone();
        edit(&mut other);
        let found = bake(&other, &mut cache.clone(), true, &mut |_| Next::Step).map(|_| ());
        assert!(matches!(found, Err(BakeError::Stale { .. })), "edit {i}: {found:?}");
    }
    // A file that is damaged or none.
    let whole = cache.bake.clone().unwrap();
    for damage in [0, 20, 60, whole.len() / 2, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[damage] ^= 1;
        let mut broken = Memory { bake: Some(bytes), ..Memory::default() };
        let found = bake(&scene, &mut broken, true, &mut |_| Next::Step).map(|_| ());
        assert!(matches!(found, Err(BakeError::Stale { .. })), "damage at {damage}: {found:?}");
        let again = run(&scene, &mut broken, &mut |_| Next::Step).unwrap();
        assert!(!again.kept && again.baked == made.baked && broken.bake.as_ref() == Some(&whole));
    }
    // One from another kind of processor, and one from another solver, with their checksums right.
    for (what, other) in [(std::env::consts::ARCH, true), ("rapier", false)] {
        let mut bytes = whole.clone();
        let at = bytes.windows(what.len()).position(|window| window == what.as_bytes()).unwrap();
        bytes[at] = b'z';
        let body = bytes.len() - 32;
        let sum = *blake3::hash(&bytes[..body]).as_bytes();
        bytes[body..].copy_from_slice(&sum);
        let mut foreign = Memory { bake: Some(bytes), ..Memory::default() };
        match bake(&scene, &mut foreign, true, &mut |_| Next::Step) {
            Ok(found) => assert!(other && found.unwrap().other_machine.unwrap().starts_with('z')),
            Err(error) => assert!(!other && error.to_string().contains("it was made by zapier"), "{error}"),
        }
    }
    for bytes in [Vec::new(), vec![0; 10], whole[..whole.len() - 100].to_vec()] {
        let mut broken = Memory { bake: Some(bytes), ..Memory::default() };
        assert!(bake(&scene, &mut broken, true, &mut |_| Next::Step).is_err());
    }
}

#[test]
fn what_cannot_be_baked() {
    let fails = |scene: &Scene| bake(scene, &mut NoCache, false, &mut |_| Next::Step).unwrap_err();
    let mut scene = no_bodies();
    let node_of_nothing = add(&mut scene, "nothing", ball(1.0), [0.0; 3], BodyKind::Dynamic);
    scene.physics.simulation.duration_s = 1.0;
    scene.nodes[node_of_nothing].shape = None;
    assert!(matches!(fails(&scene), BakeError::Shapeless { .. }));
    // Flat, and all in one point.
    for z in [0.0, f32::NAN] {
        let positions = [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]].map(glam::Vec3::from_array).to_vec();
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
        scene.nodes[0].shape = Some(Shape::Mesh(Arc::new(mesh)));
        assert!(matches!(fails(&scene), BakeError::Shapeless { .. }));
    }
    let point = Mesh { positions: vec![glam::Vec3::ONE; 3], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    scene.nodes[0].shape = Some(Shape::Mesh(Arc::new(point)));
    assert!(matches!(fails(&scene), BakeError::Shapeless { .. }));
    scene.nodes[0].shape = Some(ball(1.0));
    scene.physics.bodies[0].velocity.x = 1e8;
    assert!(matches!(fails(&scene), BakeError::BlewUp { .. }));
    scene.physics.bodies[0].velocity.x = 0.0;
    scene.physics.simulation.duration_s = 1e9;
    assert!(matches!(fails(&scene), BakeError::TooLarge { .. }));
    // Nothing that forces move: no bake.
    scene.physics.bodies[0].kind = BodyKind::Fixed;
    assert!(bake(&scene, &mut NoCache, true, &mut |_| Next::Step).unwrap().is_none());
}

#[test]
fn bodies_inside_one_another_are_told() {
    let mut scene = no_bodies();
    ground(&mut scene);
    let a = add(&mut scene, "a", ball(0.5), [0.0, 0.5, 0.0], BodyKind::Dynamic);
    let b = add(&mut scene, "b", ball(0.5), [0.9, 0.5, 0.0], BodyKind::Dynamic);
    add(&mut scene, "c", ball(0.5), [1.9, 0.5, 0.0], BodyKind::Dynamic);
    let made = bake(&scene, &mut NoCache, false, &mut |_| Next::Step).unwrap().unwrap();
    let found: Vec<_> = made.overlaps.iter().map(|(pair, _)| *pair).collect();
    assert_eq!(found, [[a, b]]);
    near("how deep", made.overlaps[0].1, 0.1, 1e-3);
}
