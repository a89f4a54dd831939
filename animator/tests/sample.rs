//! Whole scenes at one instant: closed forms, and every fault by its name.

mod common;

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use common::{camera, node, scene, sphere};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use kinora_animator::{Fault, Place, sample, sample_moving};
use kinora_scene::*;

fn world(scene: &Scene, time_s: f64) -> World {
    sample(scene, scene.clock.shutter_at(time_s)).unwrap()
}

fn time() -> Track<f64> {
    Track::Curve(Box::new(Tape { code: vec![Instruction::Time], outputs: vec![0], ..Tape::default() }))
}

fn diffuse<R: Rate>(color: R::Of<Color>, roughness: R::Of<f64>) -> Bsdf<R> {
    Bsdf::Diffuse { color, roughness, model: DiffuseModel::Fon }
}

fn glass<R: Rate>(ior: R::Of<f64>, roughness: R::Of<f64>) -> Bsdf<R> {
    Bsdf::Dielectric {
        ior,
        roughness,
        energy_compensation: true,
        attenuation_color: Color::ONE,
        attenuation_distance_m: f64::INFINITY,
        thin: true,
        priority: -3,
    }
}

/// A group that moves with time, and in it a ball that grows and a lamp; a copy of the ball, and a hidden one.
fn moving_scene() -> Scene {
    let along_x = || -> Track<DVec3> {
        Track::Curve(Box::new(Tape {
            code: vec![Instruction::Time, Instruction::Const(0.0)],
            outputs: vec![0, 1, 1],
            ..Tape::default()
        }))
    };
    let mut scene = scene();
    scene.nodes = vec![node("cart", None, None), node("ball", Some(0), Some(sphere())), node("copies", Some(0), None)];
    scene.nodes[0].placing.position = along_x();
    scene.nodes[1].shape = Some(Shape::Sphere { radius_m: time() });
    scene.nodes[2].copies = Some(Box::new(Copies { of: 1, at: vec![Placement::IDENTITY; 2], material: None }));
    scene.cameras[0].position = along_x();
    scene.cameras[0].aim = Aim::Rotation(DQuat::IDENTITY.into());
    scene.lights = vec![Light {
        name: "lamp".into(),
        parent: Some(0),
        color: Color::ONE,
        kind: LightKind::Point { position: DVec3::Y.into(), power: 1.0.into(), radius_m: 0.1 },
    }];
    scene
}

#[test]
fn the_next_frame_is_where_things_go() {
    let scene = moving_scene();
    let (time_s, step) = (2.0, 1.0 / 24.0);
    let plain = world(&scene, time_s);
    assert!(plain.next.is_none() && plain.instances[0].next.is_none() && plain.copies[0].next.is_empty());
    let now = sample_moving(&scene, scene.clock.shutter_at(time_s)).unwrap();
    let next = world(&scene, time_s + step);
    assert_eq!(now.next.as_ref(), Some(&next.view));
    assert_eq!((&now.view, &now.instances[0].shape), (&plain.view, &plain.instances[0].shape));
    let along = DAffine3::from_translation(DVec3::X * (time_s + step));
    let grown = DAffine3::from_scale(DVec3::splat((time_s + step) / time_s));
    // The ball itself grows; its copies move as wholes, and it grows in their space.
    let ball = now.instances[0].next.unwrap();
    assert!(ball.abs_diff_eq(along * grown, 1e-12), "{ball:?}");
    assert_eq!(now.copies[0].next, next.copies[0].places);
    let inner = now.parts[0].instances[0].next.unwrap();
    assert!(inner.abs_diff_eq(grown, 1e-12), "{inner:?}");
    let lamp = now.lights[0].next.unwrap();
    check_near(lamp.transform_point3(DVec3::new(time_s, 1.0, 0.0)), DVec3::new(time_s + step, 1.0, 0.0));

    // What stays has the very same place, and a lamp none.
    let still = sample_moving(&common::scene(), Clock::default().shutter_at(1.0)).unwrap();
    assert_eq!(still.instances[0].next, Some(still.instances[0].world_from_object));
    assert_eq!(still.next, Some(still.view));
    // Whoever hides is where it is all the same.
    let mut hiding = moving_scene();
    let key = |time_s, value| Key { time_s, value, ease: Ease::Linear };
    hiding.nodes[0].visible = Track::Keys(Keys {
        keys: vec![key(0.0, true), key(time_s + 0.5 * step, false)],
        way: Way::Straight,
        outside: Outside::Hold,
    });
    let hiding = sample_moving(&hiding, scene.clock.shutter_at(time_s)).unwrap();
    assert_eq!(hiding.instances[0].next, now.instances[0].next);
    // A place that the next frame lacks is a fault of those alone who ask.
    let mut gone = moving_scene();
    gone.nodes[1].shape = Some(Shape::Sphere {
        radius_m: Track::Keys(Keys {
            keys: vec![
                Key { time_s: 0.0, value: 1.0, ease: Ease::Linear },
                Key { time_s, value: 1.0, ease: Ease::Linear },
                Key { time_s: time_s + step, value: -1.0, ease: Ease::Linear },
            ],
            way: Way::Straight,
            outside: Outside::Hold,
        }),
    });
    world(&gone, time_s);
    let error = sample_moving(&gone, scene.clock.shutter_at(time_s)).unwrap_err();
    assert_eq!((error.place, error.property), (Place::Node(1), "radius"));
}

fn check_near(found: DVec3, expected: DVec3) {
    assert!((found - expected).length() < 1e-12, "{found}, expected {expected}");
}

/// Of a texture that is computed at a point, what only moves becomes a number; what does not move is shared.
#[test]
fn computed_textures_stand_still() {
    use std::sync::Arc;
    let tape = |first: Instruction| Tape {
        code: vec![
            first,
            Instruction::Const(2.0),
            Instruction::Binary(Binary::Mul, 0, 1),
            Instruction::Point(Point::Uv, 0),
            Instruction::Binary(Binary::Add, 2, 3),
        ],
        outputs: vec![4],
        ..Tape::default()
    };
    let moving = Arc::new(Texture::Tape(tape(Instruction::Time)));
    let still = Arc::new(Texture::Tape(tape(Instruction::Const(1.0))));
    let checker = Texture::Checker {
        a: Paint::Texture(moving.clone()),
        b: Paint::Texture(still.clone()),
        scale: glam::Vec2::ONE,
        uv_set: UvSet::First,
    };
    let mut scene = scene();
    let maps = [moving, still.clone(), Arc::new(checker)].map(|texture| Map { slot: Slot::Roughness, texture });
    scene.materials = vec![Material { maps: maps.to_vec(), ..diffuse(Color::ONE.into(), 1.0.into()).into() }];
    let maps = &world(&scene, 1.5).materials[0].maps;
    let Texture::Tape(found) = &*maps[0].texture else { panic!("{maps:?}") };
    assert_eq!(found.code[2], Instruction::Const(3.0));
    assert_eq!(found.code[4], Instruction::Binary(Binary::Add, 2, 3));
    assert!(!found.moves());
    assert!(Arc::ptr_eq(&maps[1].texture, &still));
    let Texture::Checker { a: Paint::Texture(a), b: Paint::Texture(b), .. } = &*maps[2].texture else {
        panic!("{maps:?}")
    };
    assert_eq!(**a, *maps[0].texture);
    assert!(Arc::ptr_eq(b, &still));
}

#[test]
fn every_value_is_taken_when_the_shutter_opens() {
    let mut scene = scene();
    scene.clock.shutter = 0.5;
    scene.look.exposure = time();
    scene.nodes[0].shape = Some(Shape::Sphere { radius_m: time() });
    scene.materials = vec![
        Material { opacity: time(), ..diffuse(Color::ONE.into(), time()).into() },
        Bsdf::Metal {
            reflectance: Reflectance::Tint { color: Color::ONE.into(), edge_tint: Color::ONE.into() },
            roughness: time(),
            anisotropy: 0.5,
            anisotropy_rotation: -9.0,
            energy_compensation: false,
        }
        .into(),
        Bsdf::Emitter { color: Color::X.into(), emission: Emission::Power(time()), two_sided: true }.into(),
        Bsdf::Emitter { color: Color::X.into(), emission: Emission::Radiance(time()), two_sided: false }.into(),
        glass(1.5.into(), time()).into(),
        Bsdf::Glossy { base: 1, ior: 1.3, tint: Color::ONE.into(), roughness: time(), metalness: time() }.into(),
        Bsdf::Mix { a: 5, b: 2, amount: time() }.into(),
    ];
    scene.sky = Some(Sky { light: SkyLight::Color(Color::Y.into()), strength: time(), visible: false });
    let world = world(&scene, 0.5);
    assert_eq!(world.shutter, Shutter { open_s: 0.5, close_s: 0.5 + 0.5 / 24.0 });
    let moments = world.moments.len() as f64;
    let Shape::Sphere { radius_m } = world.moments[1].instances[0].shape else { panic!() };
    assert!((radius_m - (0.5 + 0.5 / 24.0 * 1.5 / moments)).abs() < 1e-12, "{radius_m} of {moments}");
    assert_eq!(world.look, Look { exposure: 0.5, tonemap: Tonemap::None });
    assert_eq!(world.instances[0].shape, Shape::Sphere { radius_m: 0.5 });
    assert_eq!(world.sky, Some(Sky { light: SkyLight::Color(Color::Y), strength: 0.5, visible: false }));
    assert_eq!(
        world.materials,
        [
            Material { opacity: 0.5, ..diffuse(Color::ONE, 0.5).into() },
            Bsdf::Metal {
                reflectance: Reflectance::Tint { color: Color::ONE, edge_tint: Color::ONE },
                roughness: 0.5,
                anisotropy: 0.5,
                anisotropy_rotation: -9.0,
                energy_compensation: false,
            }
            .into(),
            Bsdf::Emitter { color: Color::X, emission: Emission::Power(0.5), two_sided: true }.into(),
            Bsdf::Emitter { color: Color::X, emission: Emission::Radiance(0.5), two_sided: false }.into(),
            glass(1.5, 0.5).into(),
            Bsdf::Glossy { base: 1, ior: 1.3, tint: Color::ONE, roughness: 0.5, metalness: 0.5 }.into(),
            Bsdf::Mix { a: 5, b: 2, amount: 0.5 }.into(),
        ]
    );
}

#[test]
fn rounding_over_an_end_is_the_end() {
    let mut scene = scene();
    scene.materials = vec![diffuse(Color::splat(1.000_000_1).into(), (-1e-17).into()).into()];
    assert_eq!(world(&scene, 0.0).materials, [diffuse(Color::ONE, 0.0).into()]);
}

#[test]
fn a_point_goes_through_scale_rotation_position_then_the_parents() {
    let mut scene = scene();
    let placing = |position: DVec3, rotation: DQuat, scale: DVec3| Placing {
        position: position.into(),
        rotation: rotation.into(),
        scale: scale.into(),
    };
    let quarter = DQuat::from_rotation_y(FRAC_PI_2);
    scene.nodes = vec![node("base", None, None), node("arm", Some(0), None), node("hand", Some(1), Some(sphere()))];
    scene.nodes[0].placing = placing(DVec3::X, quarter, DVec3::splat(2.0));
    scene.nodes[1].placing = placing(DVec3::Y, DQuat::IDENTITY, DVec3::new(1.0, 3.0, -1.0));
    scene.nodes[2].placing = placing(DVec3::Z, quarter, DVec3::new(1.0, 1.0, 5.0));
    let world = world(&scene, 0.0);
    assert_eq!(world.instances.len(), 1);
    assert_eq!(world.instances[0].node, 2);
    // Origin: hand (0 0 1), arm (0 1 -1), base: ×2 (0 2 -2), z to x (-2 2 0), moved (-1 2 0).
    let m = world.instances[0].world_from_object;
    check_near(m.translation, DVec3::new(-1.0, 2.0, 0.0));
    // Local z: ×5, z to x (5 0 0), arm (5 0 0), base ×2, x to −z (0 0 -10).
    check_near(m.transform_vector3(DVec3::Z), DVec3::new(0.0, 0.0, -10.0));
    check_near(m.transform_vector3(DVec3::Y), DVec3::new(0.0, 6.0, 0.0));
    check_near(m.transform_vector3(DVec3::X), DVec3::new(2.0, 0.0, 0.0));
}

#[test]
fn what_is_hidden_hides_what_moves_with_it() {
    let at = |time_s, value| Key { time_s, value, ease: Ease::Linear };
    let mut scene = scene();
    scene.nodes = vec![
        node("group", None, None),
        node("inner", Some(0), None),
        node("leaf", Some(1), Some(sphere())),
        node("other", None, Some(sphere())),
    ];
    scene.nodes[0].visible =
        Track::Keys(Keys { keys: vec![at(0.0, true), at(1.0, false)], way: Way::Straight, outside: Outside::Hold });
    let nodes = |time_s| world(&scene, time_s).instances.iter().map(|i| i.node).collect::<Vec<_>>();
    assert_eq!(nodes(0.5), [2, 3]);
    assert_eq!(nodes(1.0), [3]);
}

#[test]
fn faults_of_what_is_hidden_do_not_matter_until_needed() {
    let mut scene = scene();
    scene.nodes[0].visible = false.into();
    scene.nodes[0].placing.scale = DVec3::ZERO.into();
    assert_eq!(world(&scene, 0.0).instances, []);
    scene.cameras[0].parent = Some(0);
    check_fault(&scene, Place::Node(0), "scale", Fault::Singular);
}

#[test]
fn a_frame_alone_is_that_frame_in_a_range() {
    let mut scene = scene();
    scene.nodes[0].shape = Some(Shape::Sphere {
        radius_m: Track::Keys(Keys {
            keys: (0..9)
                .map(|i| Key {
                    time_s: f64::from(i) / 3.0,
                    value: 1.0 + f64::from(i % 2),
                    ease: Ease::Bezier(Bezier::SMOOTH),
                })
                .collect(),
            way: Way::Straight,
            outside: Outside::Hold,
        }),
    });
    let range: Vec<_> = (0..96).map(|frame| sample(&scene, scene.clock.shutter_of(frame)).unwrap()).collect();
    assert_eq!(sample(&scene, scene.clock.shutter_of(37)).unwrap(), range[37]);
    assert_ne!(range[37].instances, range[38].instances);
}

/// The view is orthonormal, right-handed, at `eye`, along `direction`, and upright.
fn check_view(view: &View, eye: DVec3, direction: DVec3, up: DVec3) {
    let DAffine3 { matrix3: axes, translation } = view.world_from_camera;
    check_near(translation, eye);
    check_near(-axes.z_axis, direction.normalize());
    assert!((axes.transpose() * axes).abs_diff_eq(DMat3::IDENTITY, 1e-12));
    assert!((axes.determinant() - 1.0).abs() < 1e-12);
    assert!(axes.x_axis.dot(up).abs() < 1e-12 && axes.y_axis.dot(up) > 0.0);
}

#[test]
fn cameras_look_at_points_in_every_octant() {
    for octant in 0..8 {
        let sign = |bit: i32| if octant & bit == 0 { 1.0 } else { -1.0 };
        let direction = DVec3::new(3.0 * sign(1), 2.0 * sign(2), 6.0 * sign(4));
        let eye = DVec3::new(0.3, -1.0, 2.0);
        let mut scene = scene();
        scene.cameras[0] = camera(eye, eye + direction);
        let view = world(&scene, 0.0).view;
        check_view(&view, eye, direction, DVec3::Y);
        assert!((view.focus_m - 7.0).abs() < 1e-12);
    }
}

#[test]
fn a_camera_rotates_as_it_is_told() {
    let mut scene = scene();
    scene.cameras[0].aim = Aim::Rotation(DQuat::from_rotation_y(FRAC_PI_2).into());
    // Counter-clockwise about y: z goes to x, so −z goes to −x.
    check_view(&world(&scene, 0.0).view, DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_X, DVec3::Y);
    scene.cameras[0].aperture_m = 0.1.into();
    check_fault(&scene, Place::Camera(0), "focus", Fault::NoFocus);
    scene.cameras[0].focus_m = Some(2.0.into());
    assert_eq!(world(&scene, 0.0).view.focus_m, 2.0);
}

/// A group turned by 90° about y, scaled unevenly and mirrored, moved to (10, 0, 0), that the camera moves with.
fn riding() -> Scene {
    let mut scene = scene();
    scene.nodes.push(node("cart", None, None));
    scene.nodes[1].placing = Placing {
        position: DVec3::new(10.0, 0.0, 0.0).into(),
        rotation: DQuat::from_rotation_y(FRAC_PI_2).into(),
        scale: DVec3::new(-2.0, 3.0, 4.0).into(),
    };
    scene.cameras[0].parent = Some(1);
    scene.cameras[0].position = DVec3::new(1.0, 1.0, 1.0).into();
    scene
}

#[test]
fn the_scale_of_a_cameras_parent_moves_it_but_keeps_its_axes() {
    let mut scene = riding();
    // (1 1 1) × (−2 3 4) = (−2 3 4); z to x, x to −z: (4 3 2); moved: (14 3 2).
    let eye = DVec3::new(14.0, 3.0, 2.0);
    scene.cameras[0].aim = Aim::Rotation(DQuat::IDENTITY.into());
    check_view(&world(&scene, 0.0).view, eye, DVec3::NEG_X, DVec3::Y);
    scene.cameras[0].aim = Aim::Rotation(DQuat::from_rotation_x(FRAC_PI_4).into());
    check_view(&world(&scene, 0.0).view, eye, DVec3::new(-1.0, 1.0, 0.0), DVec3::Y);
}

#[test]
fn a_point_aimed_at_is_in_the_parents_space_and_a_node_in_the_world() {
    let mut scene = riding();
    let eye = DVec3::new(14.0, 3.0, 2.0);
    scene.cameras[0].aim = Aim::Point { target: DVec3::new(1.0, 1.0, 0.0).into(), up: DVec3::Y.into() };
    let view = world(&scene, 0.0).view;
    check_view(&view, eye, DVec3::NEG_X, DVec3::Y);
    assert!((view.focus_m - 4.0).abs() < 1e-12);

    // `ball` is at the world's origin.
    scene.cameras[0].aim = Aim::Node { target: 0, up: DVec3::X.into() };
    let view = world(&scene, 0.0).view;
    // The parent turns x to −z.
    check_view(&view, eye, -eye, DVec3::NEG_Z);
    assert!((view.focus_m - eye.length()).abs() < 1e-12);
    scene.cameras[0].focus_m = Some(0.5.into());
    assert_eq!(world(&scene, 0.0).view.focus_m, 0.5);
}

#[test]
fn a_hidden_node_may_be_aimed_at() {
    let mut scene = scene();
    scene.nodes[0].visible = false.into();
    scene.cameras[0].aim = Aim::Node { target: 0, up: DVec3::Y.into() };
    check_view(&world(&scene, 0.0).view, DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z, DVec3::Y);
}

fn check_fault(scene: &Scene, place: Place, property: &str, fault: Fault) {
    let error = sample(scene, scene.clock.shutter_at(0.25)).unwrap_err();
    assert_eq!((error.place, error.property, error.fault, error.time_s), (place, property, fault, 0.25));
    let text = error.to_string();
    assert!(text.contains(&error.name) && !text.ends_with('.'), "{text}");
}

fn check_edit(edit: impl FnOnce(&mut Scene), place: Place, property: &str, fault: Fault) {
    let mut scene = scene();
    edit(&mut scene);
    check_fault(&scene, place, property, fault);
}

fn too(value: f64, range: &'static str) -> Fault {
    Fault::OutOfRange { value, range }
}

#[test]
fn faults_of_nodes() {
    let check = |edit: &dyn Fn(&mut Node), property, fault| {
        check_edit(|scene| edit(&mut scene.nodes[0]), Place::Node(0), property, fault);
    };
    check(&|n| n.placing.position = DVec3::NAN.into(), "position", Fault::NotFinite);
    check(&|n| n.placing.rotation = DQuat::NAN.into(), "rotation", Fault::NotFinite);
    check(&|n| n.placing.rotation = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0).into(), "rotation", Fault::NotFinite);
    check(&|n| n.placing.scale = DVec3::INFINITY.into(), "scale", Fault::NotFinite);
    check(&|n| n.placing.scale = DVec3::new(1.0, 0.0, 1.0).into(), "scale", Fault::Singular);
    check(&|n| n.placing.scale = DVec3::splat(1e-150).into(), "scale", Fault::Singular);
    check(&|n| n.placing.scale = DVec3::splat(1e150).into(), "scale", Fault::Singular);
    check(&|n| n.parent = Some(0), "parent", Fault::Dangling);
    check(&|n| n.parent = Some(7), "parent", Fault::Dangling);
    check(&|n| n.material = 1, "material", Fault::Dangling);
    check(&|n| n.shape = Some(Shape::Sphere { radius_m: 0.0.into() }), "radius", too(0.0, "above 0"));
    check(&|n| n.shape = Some(Shape::Sphere { radius_m: f64::NAN.into() }), "radius", Fault::NotFinite);
    check(&|n| n.shape = Some(Shape::Box { size_m: DVec3::new(1.0, -2.0, 1.0) }), "size", too(-2.0, "above 0"));
    let frame = Frame::facing(DVec3::Y, DVec3::Y).unwrap();
    check(&|n| n.shape = Some(Shape::Quad { frame, size_m: glam::DVec2::ZERO }), "size", too(0.0, "above 0"));
    let broken = Frame { z: DVec3::NAN, ..frame };
    check(&|n| n.shape = Some(Shape::Plane { frame: broken }), "normal", Fault::NotFinite);
}

#[test]
fn a_chain_of_parents_may_leave_the_numbers() {
    let mut scene = scene();
    scene.nodes = vec![node("a", None, None), node("b", Some(0), None), node("c", Some(1), Some(sphere()))];
    scene.nodes[0].placing.scale = DVec3::splat(1e200).into();
    scene.nodes[1].placing.scale = DVec3::splat(1e200).into();
    check_fault(&scene, Place::Node(1), "position", Fault::NotFinite);
}

#[test]
fn faults_of_materials_name_who_wears_them() {
    let check = |bsdf: Bsdf<Animated>, property, fault| {
        check_edit(|scene| scene.materials[0] = bsdf.into(), Place::Material(0), property, fault);
    };
    let (white, bad) = (|| Track::Const(Color::ONE), || Track::Const(Color::new(0.0, 1.5, 0.0)));
    check(diffuse(bad(), 0.0.into()), "color", too(1.5, "0 to 1"));
    check(diffuse(white(), 1.5.into()), "roughness", too(1.5, "0 to 1"));
    let metal = |color, edge_tint, roughness: f64, anisotropy, anisotropy_rotation| Bsdf::Metal {
        reflectance: Reflectance::Tint { color, edge_tint },
        roughness: roughness.into(),
        anisotropy,
        anisotropy_rotation,
        energy_compensation: true,
    };
    check(metal(bad(), white(), 0.0, 0.0, 0.0), "color", too(1.5, "0 to 1"));
    check(metal(white(), bad(), 0.0, 0.0, 0.0), "edge_tint", too(1.5, "0 to 1"));
    check(metal(white(), white(), -0.5, 0.0, 0.0), "roughness", too(-0.5, "0 to 1"));
    check(metal(white(), white(), 0.0, 1.5, 0.0), "anisotropy", too(1.5, "0 to 1"));
    check(metal(white(), white(), 0.0, 1.0, f64::NAN), "anisotropy_rotation", Fault::NotFinite);
    check(glass(0.5.into(), 0.0.into()), "ior", too(0.5, "1 or more"));
    check(glass(1.5.into(), 1.5.into()), "roughness", too(1.5, "0 to 1"));
    let absorbing = |attenuation_distance_m| match glass(1.5.into(), 0.0.into()) {
        Bsdf::Dielectric { ior, roughness, energy_compensation, attenuation_color, thin, priority, .. } => {
            Bsdf::Dielectric {
                ior,
                roughness,
                energy_compensation,
                attenuation_color,
                attenuation_distance_m,
                thin,
                priority,
            }
        }
        other => other,
    };
    check(absorbing(0.0), "attenuation_distance", too(0.0, "above 0"));
    check(absorbing(f64::NAN), "attenuation_distance", Fault::NotFinite);
    let lamp = |color, emission| Bsdf::Emitter { color, emission, two_sided: false };
    check(lamp(white(), Emission::Power((-1.0).into())), "power", too(-1.0, "0 or more"));
    check(lamp(white(), Emission::Radiance((-1.0).into())), "radiance", too(-1.0, "0 or more"));
    check(lamp(Color::new(2.0, -1.0, 0.0).into(), Emission::Power(1.0.into())), "color", too(-1.0, "0 or more"));
    let made_of_itself =
        Bsdf::Glossy { base: 0, ior: 1.5, tint: Color::ONE.into(), roughness: 0.0.into(), metalness: 0.0.into() };
    check(made_of_itself, "base", Fault::Dangling);
    let opaque = |opacity: f64| Material { opacity: opacity.into(), ..diffuse(white(), 0.0.into()).into() };
    check_edit(|scene| scene.materials[0] = opaque(1.5), Place::Material(0), "opacity", too(1.5, "0 to 1"));
}

#[test]
fn faults_of_what_is_made_of_materials() {
    let check = |outer: Bsdf<Animated>, at: usize, property, fault| {
        check_edit(
            |scene| {
                let dull = diffuse(Color::ONE.into(), if at == 0 { 2.0.into() } else { 0.0.into() });
                scene.materials = vec![dull.into(), outer.into()];
                scene.nodes[0].material = 1;
            },
            Place::Material(at),
            property,
            fault,
        );
    };
    let coat = |base, ior, roughness: f64, metalness: f64| Bsdf::Glossy {
        base,
        ior,
        tint: Color::ONE.into(),
        roughness: roughness.into(),
        metalness: metalness.into(),
    };
    let mix = |a, b, amount: f64| Bsdf::Mix { a, b, amount: amount.into() };
    check(coat(0, 1.5, 0.0, 0.0), 0, "roughness", too(2.0, "0 to 1"));
    check(mix(0, 0, 0.0), 0, "roughness", too(2.0, "0 to 1"));
    check(coat(1, 1.5, 0.0, 0.0), 1, "base", Fault::Dangling);
    check(coat(0, 0.5, 0.0, 0.0), 1, "ior", too(0.5, "1 or more"));
    check(coat(0, 1.5, 2.0, 0.0), 1, "roughness", too(2.0, "0 to 1"));
    check(coat(0, 1.5, 0.0, -1.0), 1, "metalness", too(-1.0, "0 to 1"));
    check(mix(1, 0, 0.5), 1, "a", Fault::Dangling);
    check(mix(0, 2, 0.5), 1, "b", Fault::Dangling);
    check(mix(0, 0, 1.5), 1, "amount", too(1.5, "0 to 1"));
}

#[test]
fn faults_of_sky_and_look() {
    let sky = |color, strength: f64| Sky {
        light: SkyLight::Color(Track::Const(color)),
        strength: strength.into(),
        visible: true,
    };
    let check = |value, property, fault| check_edit(|scene| scene.sky = Some(value), Place::Sky, property, fault);
    check(sky(Color::ONE, -1.0), "strength", too(-1.0, "0 or more"));
    check(sky(Color::new(f32::INFINITY, 0.0, 0.0), 1.0), "color", Fault::NotFinite);
    check_edit(|scene| scene.look.exposure = f64::NAN.into(), Place::Render, "exposure", Fault::NotFinite);
}

#[test]
fn faults_of_cameras() {
    let check = |edit: &dyn Fn(&mut Camera<Animated>), property, fault| {
        check_edit(|scene| edit(&mut scene.cameras[0]), Place::Camera(0), property, fault);
    };
    let at = |target: DVec3, up: DVec3| Aim::Point { target: target.into(), up: up.into() };
    check(&|c| c.position = DVec3::NAN.into(), "position", Fault::NotFinite);
    check(&|c| c.parent = Some(3), "parent", Fault::Dangling);
    check(&|c| c.aim = at(DVec3::new(0.0, 0.0, 5.0), DVec3::Y), "look_at", Fault::AimedAtItself);
    check(&|c| c.aim = at(DVec3::new(0.0, 0.0, 5.0 + 1e-15), DVec3::Y), "look_at", Fault::AimedAtItself);
    check(&|c| c.aim = at(DVec3::NAN, DVec3::Y), "look_at", Fault::NotFinite);
    check(&|c| c.aim = at(DVec3::ZERO, DVec3::Z), "up", Fault::UpAlongView);
    check(&|c| c.aim = at(DVec3::ZERO, DVec3::NEG_Z), "up", Fault::UpAlongView);
    check(&|c| c.aim = at(DVec3::ZERO, DVec3::ZERO), "up", Fault::UpAlongView);
    check(&|c| c.aim = at(DVec3::ZERO, DVec3::NAN), "up", Fault::NotFinite);
    check(&|c| c.aim = Aim::Node { target: 9, up: DVec3::Y.into() }, "look_at", Fault::Dangling);
    check(&|c| c.aim = Aim::Rotation(DQuat::NAN.into()), "rotation", Fault::NotFinite);
    let perspective = |fov: f64| Projection::Perspective { fov: fov.into() };
    check(&|c| c.projection = perspective(0.0), "fov", too(0.0, "above 0 and below 180 degrees"));
    check(&|c| c.projection = perspective(PI), "fov", too(PI, "above 0 and below 180 degrees"));
    let fisheye = |fov: f64| Projection::Fisheye { fov: fov.into() };
    check(&|c| c.projection = fisheye(0.0), "fov", too(0.0, "above 0 and at most 360 degrees"));
    check(&|c| c.projection = fisheye(7.0), "fov", too(7.0, "above 0 and at most 360 degrees"));
    let orthographic = |height_m| Projection::Orthographic { height_m };
    check(&|c| c.projection = orthographic(0.0), "height", too(0.0, "above 0"));
    check(&|c| c.aperture_m = (-1.0).into(), "aperture", too(-1.0, "0 or more"));
    check(&|c| c.focus_m = Some(0.0.into()), "focus", too(0.0, "above 0"));
}

#[test]
fn a_scene_without_a_camera() {
    for camera in [None, Some(1)] {
        let mut scene = scene();
        scene.camera = camera;
        let error = sample(&scene, scene.clock.shutter_of(0)).unwrap_err();
        assert_eq!(error.to_string(), "the scene has no camera");
    }
}

#[test]
fn errors_read_as_one_clause() {
    let text = |edit: &dyn Fn(&mut Scene), time_s| {
        let mut scene = scene();
        edit(&mut scene);
        sample(&scene, scene.clock.shutter_at(time_s)).unwrap_err().to_string()
    };
    let rough = |scene: &mut Scene| {
        scene.materials[0] = diffuse(Color::ONE.into(), time()).into();
    };
    assert_eq!(text(&rough, 1.5), "`roughness` of the material of `ball` is 1.5 and must be 0 to 1, at 1.5 s");
    let unworn = |scene: &mut Scene| {
        scene.materials.push(diffuse(Color::ONE.into(), f64::NAN.into()).into());
    };
    assert_eq!(text(&unworn, 1.0 / 24.0), "`roughness` of material 1 is not a finite number, at 0.041667 s");
    let aimed = |scene: &mut Scene| scene.cameras[0] = camera(DVec3::ONE, DVec3::ONE);
    assert_eq!(text(&aimed, 0.0), "`look_at` of `eye` is the camera's own position, at 0 s");
}
