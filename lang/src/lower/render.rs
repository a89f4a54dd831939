//! The `render` block.

use std::rc::Rc;

use kinora_scene::{Animated, Clock, Filter, Look, Render, Sampler, Tonemap};

use super::{Lower, read};
use crate::eval::machine::NodeValue;

impl<'a> Lower<'_, 'a> {
    pub(super) fn render(&mut self, node: &Rc<NodeValue<'a>>) -> (Render, Look<Animated>, Clock) {
        let count = |name: &str| read::number(node, name).clamp(0.0, f64::from(u32::MAX)) as u32;
        let filter = match read::word(node, "filter") {
            "box" => Filter::Box,
            "gaussian" => Filter::Gaussian,
            _ => Filter::BlackmanHarris,
        };
        let width = if filter == Filter::Box { 1.0 } else { 1.5 };
        let resolution = read::parts(node, "resolution");
        let side = |i: usize| resolution.get(i).map_or(1, |side| side.clamp(1.0, 16384.0) as u32);
        let render = Render {
            resolution: [side(0), side(1)],
            samples: count("samples"),
            max_bounces: count("max_bounces"),
            roulette_from: count("roulette_from"),
            filter,
            filter_width: read::number_if_set(node, "filter_width").unwrap_or(width),
            sampler: if read::word(node, "sampler") == "random" { Sampler::Random } else { Sampler::Sobol },
            seed: count("seed"),
        };
        let look = Look {
            exposure: read::track(self.machine, node, "exposure"),
            tonemap: match read::word(node, "tonemap") {
                "aces" => Tonemap::Aces,
                "reinhard" => Tonemap::Reinhard,
                "none" => Tonemap::None,
                _ => Tonemap::Agx,
            },
        };
        let clock = Clock {
            fps: read::number(node, "fps"),
            duration_s: read::number(node, "duration"),
            shutter: read::number(node, "shutter") / std::f64::consts::TAU,
        };
        (render, look, clock)
    }
}
