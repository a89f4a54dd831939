//! Cameras.

use std::rc::Rc;

use glam::{DQuat, DVec3};
use kinora_scene::{Aim, Animated, Camera, Track};

use super::{InnerUse, Lower, read};
use crate::diagnostic::Diagnostic;
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
            fov: read::track(self.machine, &node, "fov"),
            aperture_m: read::track(self.machine, &node, "aperture"),
            focus_m: read::track_if_set(self.machine, &node, "focus"),
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
