//! Properties of an evaluated node, with the schema's defaults where they are not set.

use std::rc::Rc;
use std::sync::Arc;

use glam::DVec3;
use kinora_scene::{Key, Keys, Track, Value, Way};

use crate::builtin::texture::Texture;
use crate::eval::coerce::Data;
use crate::eval::items::default_parts;
use crate::eval::machine::{Machine, NodeKind, NodeValue, Set};
use crate::schema::Default;
use crate::value::NodeId;

/// The property, if it is set.
pub fn set<'n, 'a>(node: &'n Rc<NodeValue<'a>>, name: &str) -> Option<&'n Set<'a>> {
    node.properties.iter().find(|set| set.property.name == name)
}

/// What it is set to, if it is and is no error.
pub fn data<'n>(node: &'n Rc<NodeValue<'_>>, name: &str) -> Option<&'n Data> {
    set(node, name).and_then(|set| set.data.as_ref())
}

/// The node, if it is one.
pub fn node(data: Option<&Data>) -> Option<NodeId> {
    match data {
        Some(Data::Node(id)) => Some(*id),
        _ => None,
    }
}

/// The default of a property, by components.
fn default(node: &Rc<NodeValue<'_>>, name: &str) -> Option<Vec<f64>> {
    match node.kind {
        NodeKind::Schema(kind) => default_parts(kind.property(name)?),
        _ => None,
    }
}

/// A texture, if it is one.
pub fn texture(data: &Data) -> Option<&Arc<Texture>> {
    match data {
        Data::Texture(texture) => Some(texture),
        _ => None,
    }
}

/// Data as a track; 1 where a texture says how much.
pub fn to_track<T: Value>(machine: &mut Machine<'_>, data: &Data) -> Option<Track<T>> {
    match data {
        Data::Texture(_) => Some(Track::Const(T::from_components(&vec![1.0; T::COMPONENTS]))),
        Data::Parts(parts) if parts.len() == T::COMPONENTS => Some(match data.constants() {
            Some(parts) => Track::Const(T::from_components(&parts)),
            None => Track::Curve(Box::new(machine.graph.tape(parts))),
        }),
        Data::Keys(keys) if keys.keys.iter().all(|key| key.value.len() == T::COMPONENTS) => {
            let way = match &keys.way {
                Way::Straight => Way::Straight,
                Way::Squad => Way::Squad,
                Way::Cubic(all) if all.iter().flatten().any(|slope| slope.len() != T::COMPONENTS) => return None,
                Way::Cubic(all) => {
                    Way::Cubic(all.iter().map(|two| two.each_ref().map(|slope| T::from_components(slope))).collect())
                }
            };
            let key = |key: &Key<Vec<f64>>| Key {
                time_s: key.time_s,
                value: T::from_components(&key.value),
                ease: key.ease.clone(),
            };
            Some(Track::Keys(Keys { keys: keys.keys.iter().map(key).collect(), way, outside: keys.outside }))
        }
        _ => None,
    }
}

/// A property as a track, if it is set.
pub fn track_if_set<T: Value>(machine: &mut Machine<'_>, node: &Rc<NodeValue<'_>>, name: &str) -> Option<Track<T>> {
    to_track(machine, data(node, name)?)
}

/// A property as a track.
pub fn track<T: Value>(machine: &mut Machine<'_>, node: &Rc<NodeValue<'_>>, name: &str) -> Track<T> {
    if let Some(track) = track_if_set(machine, node, name) {
        return track;
    }
    let parts = default(node, name).filter(|parts| parts.len() == T::COMPONENTS);
    Track::Const(T::from_components(&parts.unwrap_or_else(|| vec![0.0; T::COMPONENTS])))
}

/// A property that does not move, by components; 1 where a texture says how much.
pub fn parts(node: &Rc<NodeValue<'_>>, name: &str) -> Vec<f64> {
    if let Some(Data::Texture(_)) = data(node, name) {
        return vec![1.0];
    }
    data(node, name).and_then(Data::constants).or_else(|| default(node, name)).unwrap_or_default()
}

/// A number that does not move; 0 where there is none.
pub fn number(node: &Rc<NodeValue<'_>>, name: &str) -> f64 {
    parts(node, name).first().copied().unwrap_or(0.0)
}

/// A truth value that does not change.
pub fn flag(node: &Rc<NodeValue<'_>>, name: &str) -> bool {
    number(node, name) != 0.0
}

/// A number that does not move, if it is set.
pub fn number_if_set(node: &Rc<NodeValue<'_>>, name: &str) -> Option<f64> {
    data(node, name)?.constants()?.first().copied()
}

/// A vector that does not move.
pub fn vector(node: &Rc<NodeValue<'_>>, name: &str) -> DVec3 {
    match parts(node, name).as_slice() {
        [x, y, z] => DVec3::new(*x, *y, *z),
        _ => DVec3::ZERO,
    }
}

/// A word.
pub fn word(node: &Rc<NodeValue<'_>>, name: &str) -> &'static str {
    match (data(node, name), node.kind) {
        (Some(Data::Word(word)), _) => word,
        (_, NodeKind::Schema(kind)) => match kind.property(name).map(|property| property.default) {
            Some(Default::Word(word)) => word,
            _ => "",
        },
        _ => "",
    }
}
