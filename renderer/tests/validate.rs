//! Arrays whose numbers lead out of other arrays are refused before a backend reads them.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec4};
use kinora_kernel::Packed;
use kinora_kernel::generated::{
    FEATURE_BLADES, FEATURE_FISHEYE, FEATURE_PANORAMA, MAPS_LIST, MAPS_SIZE, PRIMITIVE_OTHER, TAPE_READS_LOCAL,
    TEXTURE_TAPE,
};
use kinora_kernel::query::Compressed;
use kinora_renderer::suite::{add, diffuse, emitter, quad, view, world};
use kinora_renderer::{Backend, BackendError, pack};
use kinora_scene::{Emission, Instruction, Map, Paint, Point, Shape, Slot, Tape, Texture, Unary, UvSet, World};

fn scene() -> World {
    let mut w = world([8, 8], 1, view(DVec3::Z, DVec3::ZERO, 1.0));
    for i in 0..20 {
        let place = DAffine3::from_translation(DVec3::X * f64::from(i));
        add(&mut w, Shape::Sphere { radius_m: 0.5 }, place, diffuse(0.5, 0.0));
    }
    add(&mut w, quad(DVec3::Y, 1.0, 1.0), DAffine3::IDENTITY, emitter(Emission::Radiance(1.0)));
    w
}

fn check(what: &str, spoil: impl FnOnce(&mut Packed)) {
    let mut packed = pack(&scene()).expect("it packs");
    assert_eq!(packed.validate(), Ok(()));
    spoil(&mut packed);
    let invalid = packed.validate().expect_err(what);
    assert!(invalid.to_string().contains(what), "{invalid}, expected {what}");
}

fn check_nodes(what: &str, spoil: impl FnOnce(&mut Compressed)) {
    let mut compressed = pack(&scene()).expect("it packs").compressed().expect("a flat tree");
    assert_eq!(compressed.validate(), Ok(()));
    spoil(&mut compressed);
    let invalid = compressed.validate().expect_err(what);
    assert!(invalid.to_string().contains(what), "{invalid}, expected {what}");
}

#[test]
fn wrong_numbers() {
    check("the number of lights of params[0] is 100", |p| p.params.light_count = 100);
    check("the number of planes", |p| p.params.plane_count = 100);
    check("the number of primitives of params[0] is 100", |p| p.params.primitive_count = 100);
    check("the last entry of the tables", |p| p.tables.truncate(1000));
    check_nodes("the last child of nodes[0]", |c| c.bvh.nodes[0].child_base_idx = u32::MAX);
    check_nodes("its index of nodes[0]", |c| c.bvh.nodes[0].child_base_idx = 0);
    check_nodes("the last primitive of nodes", |c| c.primitives.truncate(1));
    check("the kind of primitives[3]", |p| {
        p.primitives[3].shade.w |= PRIMITIVE_OTHER;
        p.primitives[3].index.z = 1000;
    });
    check("the shape of primitives[3]", |p| p.primitives[3].shade.w += 1000);
    check("the material of shapes[5] is 1000", |p| p.shapes[5].index.x = 1000);
    check("the first light of shapes[5]", |p| p.shapes[5].index.y = 1);
    check("the light of primitives", |p| p.primitives.iter_mut().for_each(|q| q.index.x = 7));
    check("the kind of materials[20]", |p| p.materials[20].kind.x = 1000);
    check("the kind of lights[0]", |p| p.lights[0].kind.x = 1000);
    check("the shape of lights[0] is 21, and must be below 21", |p| p.lights[0].kind.y = 21);
    check("the emitter of lights[0] is 1000", |p| p.lights[0].edge_v.w = 1000.0);
    check("the number of projections", |p| p.params.features |= FEATURE_FISHEYE | FEATURE_PANORAMA);
    check("a lens without corners", |p| p.params.features |= FEATURE_BLADES);
    check("a lens's first corner", |p| {
        p.params.features |= FEATURE_BLADES;
        (p.params.camera_x.w, p.params.camera_y.w) = (5.0, f32::NAN);
    });
    check("a fisheye's edge", |p| p.params.features |= FEATURE_FISHEYE);
}

#[test]
fn wrong_tapes() {
    let code = vec![Instruction::Point(Point::Local, 0), Instruction::Unary(Unary::Sin, 0)];
    let tape = Texture::Tape(Tape { code, outputs: vec![1], ..Tape::default() });
    let paint = Paint::Color(Vec4::ONE);
    let inside =
        Texture::Checker { a: Paint::Texture(Arc::new(tape)), b: paint, scale: Vec2::ONE, uv_set: UvSet::First };
    let map = |slot| Map { slot, texture: Arc::new(inside.clone()) };
    let mut w = scene();
    w.materials[3].maps = vec![map(Slot::Color), map(Slot::Opacity)];
    let packed = pack(&w).expect("it packs");
    assert_eq!(packed.validate(), Ok(()));
    let spoiled = |what: &str, spoil: &dyn Fn(&mut Packed)| {
        let mut packed = packed.clone();
        spoil(&mut packed);
        let invalid = packed.validate().expect_err(what);
        assert!(invalid.to_string().contains(what), "{invalid}, expected {what}");
    };
    let is_tape = |word: &u32| *word == TEXTURE_TAPE | TAPE_READS_LOCAL;
    let tape = packed.words.iter().rposition(is_tape).expect("a tape");
    spoiled("the number of steps", &|p| p.words[tape + 1] = 2000);
    spoiled("the last step of a tape", &|p| p.words[tape + 1] = 1000);
    spoiled("the texture of a map", &|p| {
        let list = p.params.textures.x + 3 * MAPS_SIZE + MAPS_LIST;
        let list = p.words[list as usize] as usize;
        p.words[list] = u32::MAX;
    });
    spoiled("the places of own spaces", &|p| p.params.textures.y = p.words.len() as u32);
    spoiled("the rows of its own space", &|p| {
        let shape = p.params.textures.y as usize + 3;
        p.words[shape] = u32::MAX;
    });
}

#[test]
fn worlds_without_something() {
    for w in [world([1, 1], 1, view(DVec3::Z, DVec3::ZERO, 1.0)), scene()] {
        assert_eq!(pack(&w).expect("it packs").validate(), Ok(()));
    }
}

#[test]
fn a_backend_refuses_them() {
    let Ok(mut gpu) = kinora_renderer::gpu::Gpu::any(None, true) else { return };
    let mut packed = pack(&scene()).expect("it packs");
    packed.shapes[5].index.x = 1000;
    let error = gpu.upload(packed.into()).expect_err("a material is missing");
    assert!(matches!(error, BackendError::Invalid(_)) && error.to_string().contains("shapes[5]"), "{error}");
    assert_eq!(gpu.trace(None, 0..1, &()), Err(BackendError::Nothing), "the scene before stays");
}
