//! Where a baked body is at any time.

use glam::{DAffine3, DVec3};
use kinora_scene::Baked;

use crate::track::Blend;

/// From the space of the node of body `index` to the world at `time_s`: on the way between the poses of two steps, at
/// constant speed. Before the first step it waits, and after the last one it rests. `None` where there is no such body.
pub(crate) fn world_from_body(baked: &Baked, index: usize, time_s: f64) -> Option<DAffine3> {
    let count = baked.bodies.len();
    let body = baked.bodies.get(index)?;
    let last = (baked.poses.len() / count).checked_sub(1)?;
    let at = (time_s / baked.step_s).clamp(0.0, last as f64);
    // A frame's time is a quotient: what is a step but for rounding is that step.
    let at = if (at - at.round()).abs() < 1e-6 { at.round() } else { at };
    let (step, part) = (at.floor() as usize, at.fract());
    let pose = |step: usize| baked.poses.get(step * count + index);
    let from = pose(step)?;
    let (position, rotation) = match pose(step + 1).filter(|_| part > 0.0) {
        Some(to) => (from.place().blend(&to.place(), part), from.turn().blend(&to.turn(), part)),
        None => (from.place(), from.turn()),
    };
    Some(DAffine3::from_scale_rotation_translation(DVec3::ONE, rotation, position + baked.origin) * body.pose_from_node)
}

/// The bodies among the scene's nodes, met in ascending order.
pub(crate) struct Bodies<'b> {
    baked: Option<&'b Baked>,
    next: usize,
}

impl<'b> Bodies<'b> {
    pub fn of(baked: Option<&'b Baked>) -> Self {
        Self { baked, next: 0 }
    }

    /// Where the node is, if it is a body that forces move.
    pub fn world_from_node(&mut self, node: usize, time_s: f64) -> Option<DAffine3> {
        let baked = self.baked?;
        if baked.bodies.get(self.next)?.node != node {
            return None;
        }
        self.next += 1;
        world_from_body(baked, self.next - 1, time_s)
    }
}
