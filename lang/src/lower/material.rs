//! Materials, each once.

use std::rc::Rc;

use kinora_scene::{Animated, Color, Emission, Material};

use super::{Lower, read};
use crate::diagnostic::Diagnostic;
use crate::eval::machine::{NodeKind, NodeValue};
use crate::value::NodeId;

impl<'a> Lower<'_, 'a> {
    /// The index of a material; `None` stands for the default one.
    pub(super) fn material(&mut self, id: Option<NodeId>) -> usize {
        if let Some(index) = self.known_materials.get(&id) {
            return *index;
        }
        let material = match id.and_then(|id| Some((id, self.machine.done(id)?))) {
            Some((id, node)) => self.read_material(id, &node),
            None => Material::default_diffuse(),
        };
        let index = self.materials.len();
        self.materials.push(material);
        self.known_materials.insert(id, index);
        index
    }

    fn read_material(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) -> Material<Animated> {
        let NodeKind::Schema(kind) = node.kind else { return Material::default_diffuse() };
        let machine = &mut *self.machine;
        match kind.name {
            "metal" => Material::Metal {
                color: read::track(machine, node, "color"),
                edge_tint: read::track(machine, node, "edge_tint"),
                roughness: read::track(machine, node, "roughness"),
            },
            "dielectric" => Material::Dielectric {
                ior: read::track(machine, node, "ior"),
                attenuation_color: match read::parts(node, "attenuation_color").as_slice() {
                    [r, g, b] => Color::new(*r as f32, *g as f32, *b as f32),
                    _ => Color::ONE,
                },
                attenuation_distance_m: read::number(node, "attenuation_distance"),
            },
            "emitter" => {
                let (radiance, power) = (read::set(node, "radiance"), read::set(node, "power"));
                if let (Some(radiance), Some(power)) = (radiance, power) {
                    let file = machine.file();
                    let diagnostic = Diagnostic::new("E0206", "an emitter takes `radiance` or `power`, not both")
                        .primary(file, power.name, "says how much light")
                        .label(file, radiance.name, "says it too")
                        .help("remove one");
                    self.report(id, diagnostic);
                }
                let machine = &mut *self.machine;
                Material::Emitter {
                    color: read::track(machine, node, "color"),
                    emission: match read::track_if_set(machine, node, "power") {
                        Some(power) => Emission::Power(power),
                        None => Emission::Radiance(read::track(machine, node, "radiance")),
                    },
                    two_sided: read::number(node, "two_sided") != 0.0,
                }
            }
            _ => Material::Diffuse {
                color: read::track(machine, node, "color"),
                roughness: read::track(machine, node, "roughness"),
            },
        }
    }
}
