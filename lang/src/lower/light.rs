//! The sky, suns and lamps.

use std::rc::Rc;

use glam::DVec3;
use kinora_scene::{Animated, Beam, Color, Light, LightKind, Sky, SkyLight, Track};

use super::{InnerUse, Lower, read};
use crate::diagnostic::Diagnostic;
use crate::eval::coerce::Data;
use crate::eval::machine::{NodeKind, NodeValue};
use crate::source::Span;
use crate::value::NodeId;

/// A picture that is to become the scene's sky.
pub struct SkyRequest {
    /// Where the file is, as written.
    pub path: String,
    /// Where that is written.
    pub span: Span,
    /// As [`SkyLight::Map`].
    pub rotation: Track<f64>,
}

impl<'a> Lower<'_, 'a> {
    pub(super) fn sky(&mut self, node: &Rc<NodeValue<'a>>) -> Sky<Animated> {
        let Some(&id) = self.found.skies.first() else { return black() };
        for [one, other] in [["file", "color"], ["model", "color"], ["file", "model"]] {
            self.not_both(id, node, "a sky", [one, other], "what it shines with");
        }
        let of_model = ["sun_elevation", "sun_azimuth", "turbidity"].map(|name| (name, "model", "model: nishita"));
        for (name, needs, what) in of_model.into_iter().chain([("rotation", "file", "file: \"sky.hdr\"")]) {
            if let (Some(set), None) = (read::set(node, name), read::set(node, needs)) {
                let diagnostic = Diagnostic::new("W0416", format!("`{name}` has no effect without `{needs}`"))
                    .primary(self.machine.file(), set.name, "changes nothing")
                    .help(format!("remove it, or add `{what}`"));
                self.report(id, diagnostic);
            }
        }
        let mut light = SkyLight::Color(read::track(self.machine, node, "color"));
        if let Some(Data::Word(_)) = read::data(node, "model") {
            light = SkyLight::Nishita {
                sun_elevation: read::track(self.machine, node, "sun_elevation"),
                sun_azimuth: read::track(self.machine, node, "sun_azimuth"),
                turbidity: read::track(self.machine, node, "turbidity"),
            };
        } else if let Some(Data::Text(path)) = read::data(node, "file") {
            let span = read::set(node, "file").map_or(Span::at(0), |set| set.expr.span);
            let path = path.to_string();
            self.sky_picture = Some(SkyRequest { path, span, rotation: read::track(self.machine, node, "rotation") });
        }
        Sky { light, strength: read::track(self.machine, node, "strength"), visible: read::flag(node, "visible") }
    }

    pub(super) fn lights(&mut self) -> Vec<Light<Animated>> {
        let found = std::mem::take(&mut self.found.lights);
        let mut lights = Vec::with_capacity(found.len());
        for (id, enclosing) in found {
            let node = self.machine.done(id).unwrap_or_default();
            let NodeKind::Schema(kind) = node.kind else { continue };
            if kind.name != "sun" {
                self.has(id, &node, "power", "`power: 40W`");
            }
            let kind = match kind.name {
                "sun" => LightKind::Sun {
                    direction: read::track(self.machine, &node, "direction"),
                    angle: read::number(&node, "angle"),
                    irradiance: read::track(self.machine, &node, "irradiance"),
                },
                "spot_light" => LightKind::Spot {
                    position: read::track(self.machine, &node, "position"),
                    aim: self.beam(id, &node, lights.len()),
                    power: read::track(self.machine, &node, "power"),
                    radius_m: read::number(&node, "radius"),
                    angle: read::number(&node, "angle"),
                    blend: read::number(&node, "blend"),
                },
                _ => LightKind::Point {
                    position: read::track(self.machine, &node, "position"),
                    power: read::track(self.machine, &node, "power"),
                    radius_m: read::number(&node, "radius"),
                },
            };
            let color = match read::parts(&node, "color").as_slice() {
                [r, g, b] => Color::new(*r as f32, *g as f32, *b as f32),
                _ => Color::ONE,
            };
            let parent = enclosing.and_then(|at| self.order.get(at).copied());
            self.lamps.push(id);
            lights.push(Light { name: self.name(id), parent, color, kind });
        }
        lights
    }

    /// `at`: the light's index in the scene.
    fn beam(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, at: usize) -> Beam<Animated> {
        self.not_both(id, node, "a spot light", ["look_at", "direction"], "where it shines");
        let down = Beam::Direction(DVec3::NEG_Y.into());
        if let Some(direction) = read::track_if_set(self.machine, node, "direction") {
            return Beam::Direction(direction);
        }
        let Some(set) = read::set(node, "look_at") else {
            if read::set(node, "direction").is_none() {
                let diagnostic = Diagnostic::new("E0207", "`spot_light` needs `look_at` or `direction`")
                    .primary(self.machine.file(), self.span(id), "where does it shine?")
                    .help("add `direction: (0, -1, 0)`");
                self.report(id, diagnostic);
            }
            return down;
        };
        let span = set.expr.span;
        let data = set.data.clone();
        let target: Track<DVec3> = match &data {
            Some(Data::Node(_) | Data::Inner(..)) => {
                return self.placed_node(node, "look_at", InnerUse::LightTarget(at)).map_or(down, Beam::Node);
            }
            Some(data) => read::to_track(self.machine, data).unwrap_or(Track::Const(DVec3::ZERO)),
            None => return down,
        };
        let position: Track<DVec3> = read::track(self.machine, node, "position");
        if let (Some(from), Some(to)) = (position.constant(), target.constant())
            && from == to
            && read::set(node, "position").is_none_or(|set| set.data.is_some())
        {
            let diagnostic = Diagnostic::new("E0405", "spot light shines at its own position")
                .primary(self.machine.file(), span, "shines here")
                .help("move one of them");
            self.report(id, diagnostic);
        }
        Beam::Point(target)
    }
}

fn black() -> Sky<Animated> {
    Sky { light: SkyLight::Color(Color::ZERO.into()), strength: 1.0.into(), visible: true }
}
