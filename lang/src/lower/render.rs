//! The `render` block.

use std::rc::Rc;

use kinora_scene::{Animated, Background, Clock, Filter, Look, Mis, Render, Sampler, Shown, Tonemap};

use super::{Lower, read};
use crate::diagnostic::Diagnostic;
use crate::eval::machine::NodeValue;

impl<'a> Lower<'_, 'a> {
    pub(super) fn render(&mut self, node: &Rc<NodeValue<'a>>) -> (Render, Look<Animated>, Clock) {
        self.light_probability(node);
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
            adaptive: read::number(node, "adaptive"),
            min_samples: count("min_samples"),
            max_bounces: count("max_bounces"),
            roulette_from: count("roulette_from"),
            filter,
            filter_width: read::number_if_set(node, "filter_width").unwrap_or(width),
            sampler: if read::word(node, "sampler") == "random" { Sampler::Random } else { Sampler::Sobol },
            seed: count("seed"),
            mis: match read::word(node, "mis") {
                "one_sample" => Mis::OneSample(read::number(node, "light_probability")),
                "bsdf" => Mis::BSDF,
                "light" => Mis::LIGHT,
                _ => Mis::Nee,
            },
            clamp: read::number_if_set(node, "clamp"),
            background: match read::word(node, "background") {
                "transparent" => Background::Transparent,
                _ => Background::Sky,
            },
            view: match read::word(node, "view") {
                "albedo" => Shown::Albedo,
                "normal" => Shown::Normal,
                "depth" => Shown::Depth,
                "id" => Shown::Id,
                "samples" => Shown::Samples,
                "cost" => Shown::Cost,
                "bvh" => Shown::Bvh,
                _ => Shown::Beauty,
            },
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

    /// W0416: a chance of what never happens.
    fn light_probability(&mut self, node: &Rc<NodeValue<'a>>) {
        let Some(set) = read::set(node, "light_probability") else { return };
        if read::word(node, "mis") == "one_sample" {
            return;
        }
        let file = self.machine.file();
        let diagnostic = Diagnostic::new("W0416", "`light_probability` has no effect without `mis: one_sample`")
            .primary(file, set.name, "how often the one sample is the light's");
        self.machine.report(match read::set(node, "mis") {
            Some(mis) => diagnostic.label(file, mis.expr.span, "takes more than one sample, or always the same"),
            None => diagnostic.help("add `mis: one_sample`"),
        });
    }
}
