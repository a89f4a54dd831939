//! What the viewer wants to know of a scene, and of two versions of it.

use kinora_scene::{
    Aim, Animated, Beam, Bsdf, Camera, Emission, Light, LightKind, Material, Projection, Reflectance, Scene, Shape,
    Sky, SkyLight, Track,
};

/// Whether the picture is taken as before: by a camera of the same name, place and aim. Where nodes come and go their
/// indices change, so the nodes that the cameras refer to are compared by name.
pub fn same_camera(old: &Scene, new: &Scene) -> bool {
    let taker = |scene: &Scene| -> Option<(Camera<Animated>, [Option<String>; 2])> {
        let mut camera = scene.cameras.get(scene.camera?)?.clone();
        let name = |index: usize| scene.nodes.get(index).map(|node| node.name.clone());
        let parent = camera.parent.take().and_then(name);
        let target = match &mut camera.aim {
            Aim::Node { target, .. } => name(std::mem::take(target)),
            _ => None,
        };
        Some((camera, [parent, target]))
    };
    taker(old) == taker(new)
}

/// Whether anything in the picture depends on time.
pub fn moves(scene: &Scene) -> bool {
    let cameras = scene.cameras.iter().any(camera_moves);
    let nodes = scene.nodes.iter().any(|node| {
        let place = &node.placing;
        runs(&place.position)
            || runs(&place.rotation)
            || runs(&place.scale)
            || runs(&node.visible)
            || node
                .form
                .as_ref()
                .and_then(|form| form.morph.as_ref())
                .is_some_and(|morph| morph.weights.iter().any(runs))
            || matches!(&node.shape, Some(Shape::Sphere { radius_m }) if runs(radius_m))
    });
    let sky = scene.sky.as_ref().is_some_and(sky_moves);
    let lights = scene.lights.iter().any(light_moves);
    cameras || nodes || sky || lights || scene.materials.iter().any(material_moves) || runs(&scene.look.exposure)
}

fn runs<T>(track: &Track<T>) -> bool {
    track.constant().is_none()
}

fn sky_moves(sky: &Sky<Animated>) -> bool {
    let light = match &sky.light {
        SkyLight::Color(color) => runs(color),
        SkyLight::Map { rotation, .. } => runs(rotation),
        SkyLight::Nishita { sun_elevation, sun_azimuth, turbidity } => {
            runs(sun_elevation) || runs(sun_azimuth) || runs(turbidity)
        }
    };
    light || runs(&sky.strength)
}

fn light_moves(light: &Light<Animated>) -> bool {
    match &light.kind {
        LightKind::Sun { direction, irradiance, .. } => runs(direction) || runs(irradiance),
        LightKind::Point { position, power, .. } => runs(position) || runs(power),
        LightKind::Spot { position, aim, power, .. } => {
            let aim = match aim {
                Beam::Direction(to) | Beam::Point(to) => runs(to),
                Beam::Node(_) => false,
            };
            aim || runs(position) || runs(power)
        }
    }
}

fn camera_moves(camera: &Camera<Animated>) -> bool {
    let aim = match &camera.aim {
        Aim::Rotation(rotation) => runs(rotation),
        Aim::Point { target, up } => runs(target) || runs(up),
        Aim::Node { up, .. } => runs(up),
    };
    aim || runs(&camera.position)
        || projection_moves(&camera.projection)
        || runs(&camera.aperture_m)
        || camera.focus_m.as_ref().is_some_and(runs)
}

fn projection_moves(projection: &Projection<Animated>) -> bool {
    match projection {
        Projection::Perspective { fov } | Projection::Fisheye { fov } => runs(fov),
        Projection::Orthographic { .. } | Projection::Panorama => false,
    }
}

fn material_moves(material: &Material<Animated>) -> bool {
    let bsdf = match &material.bsdf {
        Bsdf::Diffuse { color, roughness, .. } => runs(color) || runs(roughness),
        Bsdf::Metal { reflectance, roughness, .. } => {
            runs(roughness)
                || match reflectance {
                    Reflectance::Tint { color, edge_tint } => runs(color) || runs(edge_tint),
                    Reflectance::Spectrum(_) => false,
                }
        }
        Bsdf::Dielectric { ior, roughness, .. } => runs(ior) || runs(roughness),
        Bsdf::Glossy { tint, roughness, metalness, .. } => runs(tint) || runs(roughness) || runs(metalness),
        Bsdf::Sheen { color, roughness, .. } => runs(color) || runs(roughness),
        Bsdf::Mix { amount, .. } => runs(amount),
        Bsdf::Emitter { color, emission, .. } => {
            runs(color)
                || match emission {
                    Emission::Radiance(value) | Emission::Power(value) => runs(value),
                }
        }
    };
    bsdf || runs(&material.opacity) || material.maps.iter().any(|map| map.texture.moves())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use kinora_scene::{
        Blades, Clock, Form, Instruction, Key, Keys, Look, Map, Morph, Node, Outside, Placing, Render, Slot, Tape,
        Texture, Tonemap, Way,
    };

    use super::*;

    fn node(name: &str) -> Node {
        let placing = Placing::default();
        Node {
            name: name.into(),
            parent: None,
            placing,
            shape: None,
            material: 0,
            visible: true.into(),
            copies: None,
            only_copied: false,
            form: None,
            vanishes: false,
        }
    }

    fn scene() -> Scene {
        let aim = Aim::Node { target: 0, up: DVec3::Y.into() };
        let camera = Camera {
            name: "camera".into(),
            parent: None,
            position: DVec3::Z.into(),
            aim,
            projection: Projection::Perspective { fov: 0.7.into() },
            aperture_m: 0.0.into(),
            focus_m: None,
            blades: Blades::default(),
        };
        Scene {
            render: Render::default(),
            look: Look { exposure: 0.0.into(), tonemap: Tonemap::Agx },
            clock: Clock::default(),
            cameras: vec![camera],
            camera: Some(0),
            nodes: vec![node("target")],
            materials: vec![Material::default_diffuse()],
            sky: None,
            lights: Vec::new(),
            physics: kinora_scene::Physics::default(),
        }
    }

    fn keys<T: Clone>(value: T) -> Track<T> {
        let keys = vec![Key { time_s: 0.0, value, ease: Default::default() }];
        Track::Keys(Keys { keys, way: Way::Straight, outside: Outside::Hold })
    }

    #[test]
    fn a_camera_stays_the_same_while_others_come_and_go() {
        let check = |expected, change: fn(&mut Scene)| {
            let mut new = scene();
            change(&mut new);
            assert_eq!(same_camera(&scene(), &new), expected);
        };
        check(true, |_| ());
        check(true, |new| new.materials.clear());
        check(true, |new| {
            new.nodes.insert(0, node("another"));
            new.cameras[0].aim = Aim::Node { target: 1, up: DVec3::Y.into() };
        });
        check(true, |new| {
            new.cameras.insert(0, Camera { name: "spare".into(), ..new.cameras[0].clone() });
            new.camera = Some(1);
        });
        check(false, |new| new.cameras[0].projection = Projection::Perspective { fov: 0.8.into() });
        check(false, |new| new.cameras[0].projection = Projection::Panorama);
        check(false, |new| new.nodes[0].name = "another".into());
        check(false, |new| new.camera = None);
    }

    #[test]
    fn whatever_has_a_track_moves() {
        let check = |expected, change: fn(&mut Scene)| {
            let mut scene = scene();
            change(&mut scene);
            assert_eq!(moves(&scene), expected);
        };
        check(false, |_| ());
        check(true, |scene| scene.nodes[0].placing.position = keys(DVec3::X));
        check(true, |scene| scene.nodes[0].visible = keys(false));
        check(true, |scene| scene.nodes[0].shape = Some(Shape::Sphere { radius_m: keys(1.0) }));
        check(true, |scene| scene.cameras[0].focus_m = Some(keys(1.0)));
        check(true, |scene| scene.cameras[0].projection = Projection::Fisheye { fov: keys(1.0) });
        check(true, |scene| scene.cameras[0].aim = Aim::Node { target: 0, up: keys(DVec3::Y) });
        check(true, |scene| scene.look.exposure = keys(1.0));
        check(true, |scene| scene.materials[0].opacity = keys(0.5));
        check(true, |scene| scene.materials.push(Bsdf::Mix { a: 0, b: 0, amount: keys(0.5) }.into()));
        check(true, |scene| {
            let morph = Some(Morph { targets: Default::default(), weights: vec![keys(0.5)] });
            scene.nodes[0].form = Some(Box::new(Form { mesh: Default::default(), morph, skin: None }));
        });
        check(true, |scene| {
            let tape = Tape { code: vec![Instruction::Time], outputs: vec![0], ..Tape::default() };
            scene.materials[0].maps = vec![Map { slot: Slot::Opacity, texture: Texture::Tape(tape).into() }];
        });
        check(true, |scene| {
            let light = SkyLight::Color(keys(glam::Vec3::ONE));
            let sky = Sky { light, strength: 1.0.into(), visible: true };
            scene.sky = Some(sky);
        });
    }
}
