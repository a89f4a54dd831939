//! Small scenes for tests.

use glam::DVec3;
use kinora_scene::{
    Aim, Animated, Blades, Camera, Clock, Look, Material, Node, Placing, Projection, Render, Scene, Shape, Tonemap,
    Track,
};

/// A camera at (0, 0, 5) that looks along −z and one white sphere, `ball`, at the origin.
pub fn scene() -> Scene {
    Scene {
        render: Render::default(),
        look: Look { exposure: 0.0.into(), tonemap: Tonemap::None },
        clock: Clock { duration_s: 4.0, shutter: 0.0, ..Clock::default() },
        cameras: vec![camera(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO)],
        camera: Some(0),
        nodes: vec![node("ball", None, Some(sphere()))],
        materials: vec![Material::default_diffuse()],
        sky: None,
        lights: Vec::new(),
        physics: kinora_scene::Physics::default(),
    }
}

pub fn camera(position: DVec3, target: DVec3) -> Camera<Animated> {
    Camera {
        name: "eye".into(),
        parent: None,
        position: position.into(),
        aim: Aim::Point { target: target.into(), up: DVec3::Y.into() },
        projection: Projection::Perspective { fov: 0.7.into() },
        aperture_m: 0.0.into(),
        focus_m: None,
        blades: Blades::default(),
    }
}

pub fn sphere() -> Shape<Animated> {
    Shape::Sphere { radius_m: 1.0.into() }
}

pub fn node(name: &str, parent: Option<usize>, shape: Option<Shape<Animated>>) -> Node {
    Node {
        name: name.into(),
        parent,
        placing: Placing::default(),
        shape,
        material: 0,
        visible: Track::Const(true),
        copies: None,
        only_copied: false,
        form: None,
        vanishes: false,
    }
}
