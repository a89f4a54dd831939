//! Cameras.

use std::rc::Rc;

use glam::{DQuat, DVec3};
use kinora_scene::{Aim, Animated, Blades, Camera, Projection, Track};

use super::{InnerUse, Lower, read};
use crate::diagnostic::Diagnostic;
use crate::dimension::short;
use crate::eval::coerce::Data;
use crate::eval::machine::NodeValue;
use crate::value::NodeId;

impl<'a> Lower<'_, 'a> {
    pub(super) fn camera(&mut self, id: NodeId, enclosing: Option<usize>, at: usize) -> Camera<Animated> {
        let node: Rc<NodeValue<'a>> = self.machine.done(id).unwrap_or_default();
        let position: Track<DVec3> = read::track(self.machine, &node, "position");
        let aim = self.aim(id, &node, &position, at);
        let parent = match read::set(&node, "parent") {
            Some(_) => self.placed_node(&node, "parent", InnerUse::CameraParent(at)),
            None => enclosing.and_then(|at| self.order.get(at).copied()),
        };
        Camera {
            name: self.name(id),
            parent,
            position,
            aim,
            projection: self.projection(id, &node),
            aperture_m: read::track(self.machine, &node, "aperture"),
            focus_m: read::track_if_set(self.machine, &node, "focus"),
            blades: Blades {
                count: read::number(&node, "blades") as u32,
                rotation: read::number(&node, "blade_rotation"),
            },
        }
    }

    fn projection(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) -> Projection<Animated> {
        let word = read::word(node, "projection");
        self.without_effect(id, node, word);
        match word {
            "orthographic" => {
                if read::set(node, "height").is_none() {
                    let place = read::set(node, "projection").map_or(self.span(id), |set| set.expr.span);
                    let diagnostic = Diagnostic::new("E0207", "an orthographic camera needs `height`")
                        .primary(self.machine.file(), place, "how much does it see?")
                        .help("add the metres across the picture's height: `height: 2m`");
                    self.report(id, diagnostic);
                }
                Projection::Orthographic { height_m: read::number(node, "height") }
            }
            "panorama" => Projection::Panorama,
            "fisheye" => {
                let half_of_all = Track::Const(std::f64::consts::PI);
                Projection::Fisheye { fov: read::track_if_set(self.machine, node, "fov").unwrap_or(half_of_all) }
            }
            _ => {
                self.not_too_wide(id, node);
                Projection::Perspective { fov: read::track(self.machine, node, "fov") }
            }
        }
    }

    /// E0408: more than a flat picture can show.
    fn not_too_wide(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) {
        let Some(set) = read::set(node, "fov") else { return };
        let widest = match &set.data {
            Some(Data::Keys(keys)) => keys.keys.iter().flat_map(|key| key.value.iter().copied()).fold(0.0, f64::max),
            Some(data) => data.constants().and_then(|parts| parts.first().copied()).unwrap_or(0.0),
            None => 0.0,
        };
        if widest >= std::f64::consts::PI {
            let label = format!("this is {}deg", short(widest.to_degrees()));
            let diagnostic = Diagnostic::new("E0408", "field of view must be between 0 and 180deg")
                .primary(self.machine.file(), set.expr.span, label)
                .help("a wider one needs `projection: fisheye`");
            self.report(id, diagnostic);
        }
    }

    /// W0416: what another property, or its absence, makes meaningless.
    fn without_effect(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, projection: &str) {
        let file = self.machine.file();
        let is_zero = |name: &str| {
            read::data(node, name)
                .is_none_or(|data| data.constants().is_some_and(|parts| parts.iter().all(|v| *v == 0.0)))
        };
        let flat = projection == "perspective";
        let mut report = |name: &str, why: &str, help: String| {
            let Some(set) = read::set(node, name) else { return };
            let mut diagnostic = Diagnostic::new("W0416", format!("`{name}` has no effect {why}"))
                .primary(file, set.name, "changes nothing")
                .help(help);
            if let Some(word) = read::set(node, "projection").filter(|_| why.starts_with("with `")) {
                diagnostic = diagnostic.label(file, word.expr.span, "of another kind");
            }
            self.report(id, diagnostic);
        };
        let with = format!("with `projection: {projection}`");
        let all = projection == "panorama";
        if all || projection == "orthographic" {
            let help = if all { "remove it: a panorama shows all directions" } else { "write `height`" };
            report("fov", &with, help.into());
        }
        if projection != "orthographic" {
            let help = if all { "remove it" } else { "write `fov`, or add the projection" };
            report("height", "without `projection: orthographic`", help.into());
        }
        for name in ["aperture", "blades"].into_iter().filter(|name| !flat && !is_zero(name)) {
            report(name, &with, "remove it: only a perspective has a lens".into());
        }
        if flat && !is_zero("blades") && is_zero("aperture") {
            report("blades", "without `aperture`", "add the diameter of the lens: `aperture: 2cm`".into());
        }
        if !is_zero("blade_rotation") && is_zero("blades") {
            report("blade_rotation", "without `blades`", "add the number of corners: `blades: 6`".into());
        }
    }

    fn aim(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>, position: &Track<DVec3>, at: usize) -> Aim<Animated> {
        let file = self.machine.file();
        let (look_at, rotation) = (read::set(node, "look_at"), read::set(node, "rotation"));
        if let (Some(look_at), Some(rotation)) = (look_at, rotation) {
            let diagnostic = Diagnostic::new("E0206", "a camera takes `look_at` or `rotation`, not both")
                .primary(file, rotation.name, "turns it")
                .label(file, look_at.name, "turns it too")
                .help("remove one");
            self.report(id, diagnostic);
        }
        let Some(look_at) = look_at else {
            return Aim::Rotation(match read::track_if_set(self.machine, node, "rotation") {
                Some(track) => track,
                None => DQuat::IDENTITY.into(),
            });
        };
        let up: Track<DVec3> = read::track(self.machine, node, "up");
        let data = look_at.data.clone();
        let target = match &data {
            Some(Data::Node(_) | Data::Inner(..)) => {
                return match self.placed_node(node, "look_at", InnerUse::CameraTarget(at)) {
                    Some(target) => Aim::Node { target, up },
                    None => Aim::Point { target: DVec3::ZERO.into(), up },
                };
            }
            Some(data) => read::to_track(self.machine, data).unwrap_or(Track::Const(DVec3::ZERO)),
            None => return Aim::Point { target: DVec3::ZERO.into(), up },
        };
        let place = |name: &str| read::set(node, name).map_or(look_at.name, |set| set.expr.span);
        if let (Some(from), Some(to), Some(sky)) = (position.constant(), target.constant(), up.constant()) {
            let failed =
                ["position", "up"].into_iter().any(|name| read::set(node, name).is_some_and(|set| set.data.is_none()));
            let view = *to - *from;
            if failed {
                // Reported: nothing can be said about where it looks.
            } else if view.length() == 0.0 {
                let diagnostic = Diagnostic::new("E0405", "camera looks at its own position")
                    .primary(file, look_at.expr.span, "looks here")
                    .label(file, place("position"), "is here")
                    .help("move one of them");
                self.report(id, diagnostic);
            } else if view.normalize().cross(sky.normalize_or_zero()).length() < 1e-9 && sky.length() > 0.0 {
                let diagnostic = Diagnostic::new("E0405", "`up` is parallel to the view")
                    .primary(file, place("up"), "no side of the picture is up")
                    .label(file, look_at.expr.span, "looks here")
                    .help("give another `up`, for example `up: (0, 0, -1)` when looking straight down");
                self.report(id, diagnostic);
            }
        }
        Aim::Point { target, up }
    }
}
