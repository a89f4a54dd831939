//! Animations: keyframes of what moves.

use std::collections::HashSet;

use glam::{DQuat, DVec3};
use kinora_scene::{Ease, Key, Keys, Outside, Way};
use serde_json::Value;

use super::accessor::{Accessor, Buffers};
use super::geometry::name_of;
use super::json::{index, list, text};
use super::{Fault, Warnings};

/// An animation of a file.
#[derive(Debug)]
pub struct Clip {
    /// As in the file; where it has none there, kind and number.
    pub name: String,
    /// What it moves.
    pub channels: Vec<Channel>,
}

impl Clip {
    /// When its last key is, in seconds.
    pub fn end_s(&self) -> f64 {
        fn last<T>(keys: &Keys<T>) -> f64 {
            keys.keys.last().map_or(0.0, |key| key.time_s)
        }
        let end = |channel: &Channel| match &channel.moved {
            Moved::Position(keys) | Moved::Scale(keys) => last(keys),
            Moved::Rotation(keys) => last(keys),
            Moved::Weights(all) => all.iter().map(last).fold(0.0, f64::max),
        };
        self.channels.iter().map(end).fold(0.0, f64::max)
    }
}

/// What moves something.
#[derive(Debug)]
pub struct Channel {
    /// Index of the part.
    pub part: usize,
    /// How.
    pub moved: Moved,
}

/// Keyframes of a property. Outside of them their ends hold.
#[derive(Debug)]
pub enum Moved {
    /// Metres, in the parent.
    Position(Keys<DVec3>),
    /// In the parent.
    Rotation(Keys<DQuat>),
    /// One factor an axis.
    Scale(Keys<DVec3>),
    /// Of each morph target.
    Weights(Vec<Keys<f64>>),
}

/// The nodes of a file that a clip scales, by their index.
pub fn scaled(root: &Value) -> HashSet<usize> {
    let channels = list(root, "animations").iter().flat_map(|clip| list(clip, "channels"));
    let targets = channels.filter_map(|channel| channel.get("target"));
    targets.filter(|target| text(target, "path") == Some("scale")).filter_map(|target| index(target, "node")).collect()
}

/// Reads the animations; `part_of`: the part that each node became, and how many morph targets its mesh has.
pub fn read(
    root: &Value,
    buffers: &Buffers<'_>,
    part_of: &[Option<usize>],
    targets: impl Fn(usize) -> usize,
    warnings: &mut Warnings,
) -> Vec<Clip> {
    let mut clips = Vec::new();
    for (i, animation) in list(root, "animations").iter().enumerate() {
        let name = name_of(animation, "animation", i);
        match channels(root, buffers, animation, part_of, &targets, warnings) {
            Ok(channels) => clips.push(Clip { name, channels }),
            // What is for an extension to fill, or lies elsewhere on purpose.
            Err(_) => warnings.add(format!("the clip `{name}` without its numbers"), "it is left out"),
        }
    }
    clips
}

fn channels(
    root: &Value,
    buffers: &Buffers<'_>,
    animation: &Value,
    part_of: &[Option<usize>],
    targets: &impl Fn(usize) -> usize,
    warnings: &mut Warnings,
) -> Result<Vec<Channel>, Fault> {
    let samplers = list(animation, "samplers");
    let mut channels = Vec::new();
    for channel in list(animation, "channels") {
        let target = channel.get("target").unwrap_or(&Value::Null);
        // Without a node an extension says what moves; and what is not in the scene is not seen.
        let Some(node) = index(target, "node") else { continue };
        let Some(part) = part_of.get(node).copied().flatten() else { continue };
        let Some(sampler) = index(channel, "sampler").and_then(|at| samplers.get(at)) else { continue };
        let sampler = Sampler::open(root, buffers, sampler)?;
        let moved = match text(target, "path").unwrap_or("") {
            "translation" => Moved::Position(sampler.keys(1, 0, vector)),
            "scale" => Moved::Scale(sampler.keys(1, 0, vector)),
            "rotation" => Moved::Rotation(sampler.rotations()),
            "weights" => {
                let count = targets(node);
                Moved::Weights((0..count).map(|at| sampler.keys(count, at, |[x, ..]| x)).collect())
            }
            other => {
                warnings.add(format!("a channel of `{other}`"), "it stands still");
                continue;
            }
        };
        channels.push(Channel { part, moved });
    }
    Ok(channels)
}

fn vector([x, y, z, _]: [f64; 4]) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Times and values.
struct Sampler<'b> {
    times: Accessor<'b>,
    values: Accessor<'b>,
    step: bool,
    cubic: bool,
}

impl<'b> Sampler<'b> {
    fn open(root: &Value, buffers: &'b Buffers<'_>, sampler: &Value) -> Result<Sampler<'b>, Fault> {
        let open = |name: &str| Accessor::open(root, buffers, index(sampler, name).unwrap_or(usize::MAX));
        let way = text(sampler, "interpolation").unwrap_or("LINEAR");
        Ok(Sampler { times: open("input")?, values: open("output")?, step: way == "STEP", cubic: way == "CUBICSPLINE" })
    }

    /// The keys of value `at` of `each` that a key has.
    fn keys<T>(&self, each: usize, at: usize, value: impl Fn([f64; 4]) -> T) -> Keys<T> {
        // Tangent in, value, tangent out.
        let rows = if self.cubic { 3 } else { 1 };
        let element = |key: usize, row: usize| {
            let element = (key * rows + row) * each + at;
            let known = self.values.components();
            value(std::array::from_fn(|c| if c < known { self.values.number(element, c) } else { 0.0 }))
        };
        let keys = (0..self.times.count).map(|key| Key {
            time_s: self.times.number(key, 0),
            value: element(key, if self.cubic { 1 } else { 0 }),
            ease: if self.step { Ease::Step } else { Ease::Linear },
        });
        let way = match self.cubic {
            true => Way::Cubic((0..self.times.count).map(|key| [element(key, 0), element(key, 2)]).collect()),
            false => Way::Straight,
        };
        Keys { keys: keys.collect(), way, outside: Outside::Hold }
    }

    /// Between keys of a cubic the sum is made unit, and its keys may have any length.
    fn rotations(&self) -> Keys<DQuat> {
        let mut keys = self.keys(1, 0, DQuat::from_array);
        for key in keys.keys.iter_mut().filter(|_| !self.cubic) {
            let unit = key.value.normalize();
            key.value = if unit.is_finite() { unit } else { DQuat::IDENTITY };
        }
        keys
    }
}
