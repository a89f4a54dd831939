//! What moves of a part of the scene: its curves over time and the times of its keys.

use kinora_animator::{Blend, value};
use kinora_scene::{
    Aim, Animated, Beam, Bsdf, Camera, Emission, Light, LightKind, Material, Projection, Reflectance, Scene, Shape,
    SkyLight, Track,
};

use super::outline::Part;

/// Points of a curve, beside those at keys.
const POINTS: usize = 240;
/// More keys than these are not marked.
const MOST_KEYS: usize = 2000;

/// A number over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// `position.x`
    pub name: String,
    /// Seconds and value.
    pub points: Vec<[f64; 2]>,
}

/// What moves of a part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Moves {
    /// Its numbers.
    pub curves: Vec<Curve>,
    /// When they have keys, in seconds, ascending.
    pub keys_s: Vec<f64>,
}

/// What moves of `part` from 0 to `end_s`.
pub fn of_part(scene: &Scene, part: Part, end_s: f64) -> Moves {
    let mut reader = Reader { moves: Moves::default(), end_s: end_s.max(0.0), fps: scene.clock.fps };
    match part {
        Part::Node(at) => {
            if let Some(node) = scene.nodes.get(at) {
                reader.vector("position", &node.placing.position);
                reader.turn("rotation", &node.placing.rotation);
                reader.vector("scale", &node.placing.scale);
                reader.track("visible", &[""], &node.visible, |on| vec![f64::from(u8::from(*on))]);
                if let Some(Shape::Sphere { radius_m }) = &node.shape {
                    reader.number("radius", radius_m);
                }
                let weights = node.form.iter().filter_map(|form| form.morph.as_ref()).flat_map(|morph| &morph.weights);
                for (at, weight) in weights.enumerate() {
                    reader.number(&format!("morph {at}"), weight);
                }
                if node.shape.is_some() {
                    reader.material(scene, node.material, 0);
                }
                reader.body(scene, at);
            }
        }
        Part::Camera(at) => {
            if let Some(camera) = scene.cameras.get(at) {
                reader.camera(camera);
            }
        }
        Part::Light(at) => {
            if let Some(light) = scene.lights.get(at) {
                reader.light(light);
            }
        }
        Part::Sky => {
            if let Some(sky) = &scene.sky {
                match &sky.light {
                    SkyLight::Color(color) => reader.color("color", color),
                    SkyLight::Map { rotation, .. } => reader.degrees("rotation", rotation),
                    SkyLight::Nishita { sun_elevation, sun_azimuth, turbidity } => {
                        reader.degrees("sun_elevation", sun_elevation);
                        reader.degrees("sun_azimuth", sun_azimuth);
                        reader.number("turbidity", turbidity);
                    }
                }
                reader.number("strength", &sky.strength);
            }
        }
        Part::Render => reader.number("exposure", &scene.look.exposure),
    }
    let Moves { mut curves, mut keys_s } = reader.moves;
    // What stays is no curve.
    curves.retain(|curve| curve.points.windows(2).any(|pair| pair[0][1] != pair[1][1]));
    keys_s.retain(|time| (0.0..=end_s).contains(time));
    keys_s.sort_by(f64::total_cmp);
    keys_s.dedup();
    keys_s.truncate(MOST_KEYS);
    Moves { curves, keys_s }
}

/// How deep materials are looked into.
const MIXES: u32 = 4;

struct Reader {
    moves: Moves,
    end_s: f64,
    fps: f64,
}

impl Reader {
    fn track<T: Blend>(&mut self, name: &str, parts: &[&str], track: &Track<T>, read: impl Fn(&T) -> Vec<f64>) {
        let mut times: Vec<f64> = (0..=POINTS).map(|at| self.end_s * at as f64 / POINTS as f64).collect();
        match track {
            Track::Const(_) => return,
            Track::Keys(keys) => {
                let own = keys.keys.iter().map(|key| key.time_s);
                self.moves.keys_s.extend(own.clone());
                times.extend(own.take(MOST_KEYS).filter(|time| (0.0..=self.end_s).contains(time)));
            }
            Track::Clocked { .. } | Track::Curve(_) => {}
        }
        times.sort_by(f64::total_cmp);
        times.dedup();
        let mut curves: Vec<Curve> = Vec::new();
        for part in parts {
            let name = if part.is_empty() { name.to_owned() } else { format!("{name}.{part}") };
            curves.push(Curve { name, points: Vec::with_capacity(times.len()) });
        }
        for time in times {
            let numbers = read(&value(track, time, self.fps));
            for (curve, number) in curves.iter_mut().zip(numbers) {
                if number.is_finite() {
                    curve.points.push([time, number]);
                }
            }
        }
        self.moves.curves.append(&mut curves);
    }

    fn number(&mut self, name: &str, track: &Track<f64>) {
        self.track(name, &[""], track, |number| vec![*number]);
    }

    fn degrees(&mut self, name: &str, track: &Track<f64>) {
        self.track(name, &["deg"], track, |angle| vec![angle.to_degrees()]);
    }

    fn vector(&mut self, name: &str, track: &Track<glam::DVec3>) {
        self.track(name, &["x", "y", "z"], track, |v| v.to_array().to_vec());
    }

    fn color(&mut self, name: &str, track: &Track<kinora_scene::Color>) {
        self.track(name, &["r", "g", "b"], track, |color| color.as_dvec3().to_array().to_vec());
    }

    /// A rotation as angles about y, x and z, in degrees.
    fn turn(&mut self, name: &str, track: &Track<glam::DQuat>) {
        self.track(name, &["y deg", "x deg", "z deg"], track, |turn| {
            let (y, x, z) = turn.to_euler(glam::EulerRot::YXZ);
            [y, x, z].map(f64::to_degrees).to_vec()
        });
    }

    /// Where forces move a body to, as far as it is known.
    fn body(&mut self, scene: &Scene, node: usize) {
        let Some(baked) = &scene.physics.baked else { return };
        let Some(index) = baked.bodies.iter().position(|body| body.node == node) else { return };
        let count = baked.bodies.len();
        let steps = baked.poses.len() / count;
        let mut curves = ["x", "y", "z"].map(|part| Curve { name: format!("body.{part}"), points: Vec::new() });
        for step in (0..steps).step_by((steps / POINTS).max(1)) {
            let Some(pose) = baked.poses.get(step * count + index) else { break };
            let time = step as f64 * baked.step_s;
            for (curve, number) in curves.iter_mut().zip((pose.place() + baked.origin).to_array()) {
                curve.points.push([time, number]);
            }
        }
        self.moves.curves.extend(curves);
    }

    fn camera(&mut self, camera: &Camera<Animated>) {
        self.vector("position", &camera.position);
        match &camera.aim {
            Aim::Rotation(rotation) => self.turn("rotation", rotation),
            Aim::Point { target, up } => {
                self.vector("look_at", target);
                self.vector("up", up);
            }
            Aim::Node { up, .. } => self.vector("up", up),
        }
        match &camera.projection {
            Projection::Perspective { fov } | Projection::Fisheye { fov } => self.degrees("fov", fov),
            Projection::Orthographic { .. } | Projection::Panorama => {}
        }
        self.number("aperture", &camera.aperture_m);
        if let Some(focus_m) = &camera.focus_m {
            self.number("focus", focus_m);
        }
    }

    fn light(&mut self, light: &Light<Animated>) {
        match &light.kind {
            LightKind::Sun { direction, irradiance, .. } => {
                self.vector("direction", direction);
                self.number("irradiance", irradiance);
            }
            LightKind::Point { position, power, .. } => {
                self.vector("position", position);
                self.number("power", power);
            }
            LightKind::Spot { position, aim, power, .. } => {
                self.vector("position", position);
                if let Beam::Direction(to) | Beam::Point(to) = aim {
                    self.vector("aim", to);
                }
                self.number("power", power);
            }
        }
    }

    fn material(&mut self, scene: &Scene, at: usize, depth: u32) {
        let Some(material) = scene.materials.get(at).filter(|_| depth < MIXES) else { return };
        let Material { bsdf, opacity, .. } = material;
        match bsdf {
            Bsdf::Diffuse { color, roughness, .. } | Bsdf::Sheen { color, roughness, .. } => {
                self.color("color", color);
                self.number("roughness", roughness);
            }
            Bsdf::Metal { reflectance, roughness, .. } => {
                if let Reflectance::Tint { color, edge_tint } = reflectance {
                    self.color("color", color);
                    self.color("edge_tint", edge_tint);
                }
                self.number("roughness", roughness);
            }
            Bsdf::Dielectric { ior, roughness, .. } => {
                self.number("ior", ior);
                self.number("roughness", roughness);
            }
            Bsdf::Glossy { tint, roughness, metalness, .. } => {
                self.color("tint", tint);
                self.number("roughness", roughness);
                self.number("metalness", metalness);
            }
            Bsdf::Mix { a, b, amount } => {
                self.number("amount", amount);
                self.material(scene, *a, depth + 1);
                self.material(scene, *b, depth + 1);
            }
            Bsdf::Emitter { color, emission, .. } => {
                self.color("color", color);
                match emission {
                    Emission::Radiance(amount) => self.number("radiance", amount),
                    Emission::Power(amount) => self.number("power", amount),
                }
            }
        }
        self.number("opacity", opacity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{self, Changes};

    fn moves(node: &str) -> Moves {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.kin");
        let text = format!(
            "lang 1\nrender {{ duration: 4s, fps: 10 }}\ncamera {{ position: (0, 0, 5), look_at: (0, 0, 0) }}\n\
            sky {{ color: #fff }}\nsphere {{ {node} }}\n"
        );
        std::fs::write(&path, &text).unwrap();
        let loaded = session::load(&path, &Changes::default()).unwrap();
        let scene = loaded.scene.unwrap_or_else(|| panic!("{text}\n{:?}", loaded.diagnostics));
        of_part(&scene, Part::Node(0), 4.0)
    }

    #[test]
    fn what_moves_has_curves_and_keys() {
        let names = |moves: &Moves| moves.curves.iter().map(|curve| curve.name.clone()).collect::<Vec<_>>();
        assert_eq!(moves("radius: 1"), Moves::default());
        let up = moves("radius: 1, position: keys { 0s: (0, 0, 0)  1s: (0, 2, 0)  3s: (1, 0, 0)  9s: (0, 0, 0) }");
        assert_eq!(
            (names(&up), up.keys_s.clone()),
            (vec!["position.x".into(), "position.y".into()], vec![0.0, 1.0, 3.0])
        );
        let top = up.curves[1].points.iter().find(|point| point[0] == 1.0).unwrap();
        assert_eq!(top[1], 2.0, "a key is on its curve");
        let swing = moves("radius: 1 + 0.5 * sin(time / 1s * 1rad)");
        assert_eq!((names(&swing), swing.keys_s.len()), (vec!["radius".into()], 0));
        for [time, radius] in &swing.curves[0].points {
            assert!((radius - 1.0 - 0.5 * time.sin()).abs() < 1e-12);
        }
        let glow = moves("radius: 1, material: emitter { color: #fff, power: keys { 0s: 1W  2s: 5W } }");
        assert_eq!((names(&glow), glow.keys_s), (vec!["power".into()], vec![0.0, 2.0]));
        let turn = moves("radius: 1, rotation: rotate_y(time / 1s * 45deg)");
        let quarter = turn.curves[0].points.iter().find(|point| point[0] == 2.0).unwrap();
        assert_eq!(names(&turn), ["rotation.y deg"]);
        assert!((quarter[1] - 90.0).abs() < 1e-9);
    }
}
