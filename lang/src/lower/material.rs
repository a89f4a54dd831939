//! Materials, each once, what they are made of before themselves.

use std::rc::Rc;
use std::sync::Arc;

use kinora_scene::{Animated, Bsdf, Color, DiffuseModel, Emission, Material, Reflectance, Slot, Spectrum, Track};

use super::{Lower, read};
use crate::builtin::texture::Texture;
use crate::diagnostic::Diagnostic;
use crate::eval::coerce::Data;
use crate::eval::limits;
use crate::eval::machine::{NodeKind, NodeValue};
use crate::schema::{Sort, Type};
use crate::source::Span;
use crate::value::NodeId;

/// What must be known of a material, parts included.
#[derive(Clone, Copy, Default)]
pub(super) struct MadeOf {
    /// Where the power of its light is set, if it is.
    pub power: Option<Span>,
    /// How many materials are inside one another below it.
    pub layers: usize,
    /// Whether it has an inside.
    pub glass: bool,
}

/// A texture that is still to be read.
#[derive(Debug, Clone)]
pub struct TextureRequest {
    /// Index into the scene's materials.
    pub material: usize,
    /// What it scales.
    pub slot: Slot,
    /// What the scene says.
    pub texture: Arc<Texture>,
    /// Whether the property is a colour, not a ratio.
    pub color: bool,
    /// The place of the value.
    pub span: Span,
}

// What a texture of a property scales.
fn slot_of(name: &str, texture: &Texture) -> Option<Slot> {
    Some(match (name, texture) {
        ("normal", Texture::Normal { strength, .. }) => Slot::Normal { strength: *strength },
        // What differs from point to point scales a radiance of 1, as a colour does.
        ("color" | "tint" | "radiance", _) => Slot::Color,
        ("edge_tint", _) => Slot::EdgeTint,
        ("roughness", _) => Slot::Roughness,
        ("anisotropy", _) => Slot::Anisotropy,
        ("metalness", _) => Slot::Metalness,
        ("amount", _) => Slot::Amount,
        ("opacity", _) => Slot::Opacity,
        _ => return None,
    })
}

impl<'a> Lower<'_, 'a> {
    /// The index of a material; `None` stands for the default one.
    pub(super) fn material(&mut self, id: Option<NodeId>) -> usize {
        if let Some(index) = self.known_materials.get(&id) {
            return *index;
        }
        let material = match id.and_then(|id| Some((id, self.machine.done(id)?))) {
            Some((id, node)) => {
                self.open_materials.push(id);
                let material = self.read_material(id, &node);
                self.open_materials.pop();
                material
            }
            None => Material::default_diffuse(),
        };
        let part = |index: usize| self.made_of.get(index).copied().unwrap_or_default();
        let made_of = match &material.bsdf {
            Bsdf::Emitter { emission: Emission::Power(_), .. } => MadeOf {
                power: id.and_then(|id| read::set(&self.machine.done(id)?, "power").map(|set| set.name)),
                ..MadeOf::default()
            },
            Bsdf::Dielectric { thin, .. } => MadeOf { glass: !thin, ..MadeOf::default() },
            Bsdf::Glossy { base, .. } | Bsdf::Sheen { base, .. } => {
                let base = part(*base);
                MadeOf { power: None, layers: base.layers + 1, ..base }
            }
            Bsdf::Mix { a, b, .. } => {
                let (a, b) = (part(*a), part(*b));
                let layers = a.layers.max(b.layers) + 1;
                MadeOf { power: a.power.or(b.power), layers, glass: a.glass || b.glass }
            }
            _ => MadeOf::default(),
        };
        if made_of.layers >= limits::LAYERS {
            self.too_deep(id);
        }
        let index = self.push_material(material, made_of);
        self.known_materials.insert(id, index);
        if let Some(node) = id.and_then(|id| self.machine.done(id)) {
            // The colour of a coat is that of the base beneath.
            let glossy = matches!(node.kind, NodeKind::Schema(kind) if kind.name == "glossy");
            self.textures_of(&node, index, |name| !glossy || name != "color");
        }
        index
    }

    fn textures_of(&mut self, node: &Rc<NodeValue<'a>>, material: usize, of: impl Fn(&str) -> bool) {
        let mut seen = Vec::new();
        for set in &node.properties {
            let name = set.property.name;
            if seen.contains(&name) || !of(name) {
                continue;
            }
            seen.push(name);
            let Some(texture) = set.data.as_ref().and_then(read::texture) else { continue };
            let Some(slot) = slot_of(name, texture) else { continue };
            let color = set.property.ty == Type::Color;
            let (texture, span) = (texture.clone(), set.expr.span);
            self.textures.push(TextureRequest { material, slot, texture, color, span });
        }
    }

    fn push_material(&mut self, material: Material<Animated>, made_of: MadeOf) -> usize {
        self.materials.push(material);
        self.made_of.push(made_of);
        self.materials.len() - 1
    }

    /// The index of a material that `outer` is made of.
    fn inner_material(&mut self, outer: NodeId, node: &Rc<NodeValue<'a>>, name: &str) -> usize {
        let Some(inner) = read::node(read::data(node, name)) else { return self.material(None) };
        if let Some(start) = self.open_materials.iter().position(|open| *open == inner) {
            self.made_of_itself(start);
            return self.material(None);
        }
        if self.open_materials.len() >= limits::LAYERS {
            self.too_deep(Some(outer));
            return self.material(None);
        }
        self.material(Some(inner))
    }

    /// E1004.
    fn too_deep(&mut self, id: Option<NodeId>) {
        let span = id.map_or(Span::at(0), |id| self.span(id));
        self.machine.too_many("materials inside one another", limits::LAYERS, span);
    }

    /// E0505.
    fn made_of_itself(&mut self, start: usize) {
        let ring: Vec<NodeId> = self.open_materials.iter().skip(start).copied().collect();
        let Some(first) = ring.first().copied() else { return };
        let mut diagnostic = Diagnostic::new("E0505", format!("`{}` is made of itself", self.name(first)));
        for (i, id) in ring.iter().enumerate().take(6) {
            let inner = ring.get(i + 1).copied().unwrap_or(first);
            let text = format!("`{}` contains `{}`", self.name(*id), self.name(inner));
            let node = self.machine.done(*id).unwrap_or_default();
            let span = read::set(&node, "base").map_or(self.span(*id), |set| set.expr.span);
            diagnostic = match i {
                0 => diagnostic.primary(self.machine.file(), span, text),
                _ => diagnostic.label(self.machine.file(), span, text),
            };
        }
        self.report(first, diagnostic.help("put another material in one of these places"));
    }

    fn read_material(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) -> Material<Animated> {
        let NodeKind::Schema(kind) = node.kind else { return Material::default_diffuse() };
        let bsdf = match kind.name {
            "metal" => self.metal(node),
            "dielectric" => self.dielectric(node),
            "glossy" => {
                let base = match read::set(node, "base") {
                    Some(_) => self.inner_material(id, node, "base"),
                    None => {
                        let color = read::track(self.machine, node, "color");
                        let lambert = Bsdf::Diffuse { color, roughness: 0.0.into(), model: DiffuseModel::Eon };
                        let base = self.push_material(lambert.into(), MadeOf::default());
                        self.textures_of(node, base, |name| name == "color");
                        base
                    }
                };
                Bsdf::Glossy {
                    base,
                    ior: read::number(node, "ior"),
                    tint: read::track(self.machine, node, "tint"),
                    roughness: read::track(self.machine, node, "roughness"),
                    metalness: read::track(self.machine, node, "metalness"),
                }
            }
            "sheen" => Bsdf::Sheen {
                base: self.inner_material(id, node, "base"),
                color: read::track(self.machine, node, "color"),
                roughness: read::track(self.machine, node, "roughness"),
            },
            "mix" => {
                let a = self.inner_material(id, node, "a");
                let b = self.inner_material(id, node, "b");
                Bsdf::Mix { a, b, amount: read::track(self.machine, node, "amount") }
            }
            "emitter" => Bsdf::Emitter {
                color: read::track(self.machine, node, "color"),
                emission: match read::track_if_set(self.machine, node, "power") {
                    Some(power) => Emission::Power(power),
                    None => Emission::Radiance(read::track(self.machine, node, "radiance")),
                },
                two_sided: read::flag(node, "two_sided"),
            },
            _ => Bsdf::Diffuse {
                color: read::track(self.machine, node, "color"),
                roughness: read::track(self.machine, node, "roughness"),
                model: match read::word(node, "model") {
                    "fon" => DiffuseModel::Fon,
                    "qon" => DiffuseModel::Qon,
                    _ => DiffuseModel::Eon,
                },
            },
        };
        let opacity = match kind.property("opacity") {
            Some(_) => read::track(self.machine, node, "opacity"),
            None => Track::Const(1.0),
        };
        Material { opacity, ..bsdf.into() }
    }

    fn metal(&mut self, node: &Rc<NodeValue<'a>>) -> Bsdf<Animated> {
        let spectrum = match read::data(node, "spectrum") {
            Some(Data::Text(symbol)) => Spectrum::find(symbol),
            _ => None,
        };
        Bsdf::Metal {
            reflectance: match spectrum {
                Some(spectrum) => Reflectance::Spectrum(spectrum),
                None => Reflectance::Tint {
                    color: read::track(self.machine, node, "color"),
                    edge_tint: read::track(self.machine, node, "edge_tint"),
                },
            },
            roughness: read::track(self.machine, node, "roughness"),
            anisotropy: read::number(node, "anisotropy"),
            anisotropy_rotation: read::number(node, "anisotropy_rotation"),
            energy_compensation: read::flag(node, "energy_compensation"),
        }
    }

    fn dielectric(&mut self, node: &Rc<NodeValue<'a>>) -> Bsdf<Animated> {
        Bsdf::Dielectric {
            ior: read::track(self.machine, node, "ior"),
            roughness: read::track(self.machine, node, "roughness"),
            energy_compensation: read::flag(node, "energy_compensation"),
            attenuation_color: match read::parts(node, "attenuation_color").as_slice() {
                [r, g, b] => Color::new(*r as f32, *g as f32, *b as f32),
                _ => Color::ONE,
            },
            attenuation_distance_m: read::number(node, "attenuation_distance"),
            thin: read::flag(node, "thin"),
            priority: read::number(node, "priority").clamp(f64::from(i32::MIN), f64::from(i32::MAX)) as i32,
        }
    }

    /// What of each material, used or not, no property alone can tell.
    pub(super) fn judge_materials(&mut self) {
        for index in 0..self.machine.nodes.len() {
            let id = NodeId(index as u32);
            let Some(node) = self.machine.done(id) else { continue };
            let NodeKind::Schema(kind) = node.kind else { continue };
            if kind.sort != Sort::Material {
                continue;
            }
            let either = match kind.name {
                "metal" => Some(("a metal", "spectrum", ["color", "edge_tint"].as_slice(), "how much it reflects")),
                "glossy" => Some(("a glossy", "base", ["color"].as_slice(), "what is under the coat")),
                "emitter" => Some(("an emitter", "radiance", ["power"].as_slice(), "how much light")),
                _ => None,
            };
            if let Some((a_kind, one, others, what)) = either {
                for other in others {
                    self.not_both(id, &node, a_kind, [one, other], what);
                }
            }
            if kind.name == "dielectric" {
                self.attenuation(id, &node);
            }
        }
    }

    /// W0416: a colour of glass that no light will have.
    fn attenuation(&mut self, id: NodeId, node: &Rc<NodeValue<'a>>) {
        let Some(color) = read::set(node, "attenuation_color") else { return };
        let (distance, thin) = (read::set(node, "attenuation_distance"), read::set(node, "thin"));
        let file = self.machine.file();
        let diagnostic = match thin.filter(|_| read::flag(node, "thin")) {
            Some(thin) => Diagnostic::new("W0416", "`attenuation_color` has no effect on a thin sheet")
                .primary(file, color.name, "colours light on its way through the inside")
                .label(file, thin.name, "so that there is no inside")
                .help("remove one"),
            None if distance.is_none() => {
                Diagnostic::new("W0416", "`attenuation_color` has no effect without `attenuation_distance`")
                    .primary(file, color.name, "after which way?")
                    .help("add the way after which light has this colour: `attenuation_distance: 10cm`")
            }
            None => return,
        };
        self.report(id, diagnostic);
    }

    /// E0206: two properties that say the same.
    pub(super) fn not_both(
        &mut self,
        id: NodeId,
        node: &Rc<NodeValue<'a>>,
        a_kind: &str,
        names: [&str; 2],
        what: &str,
    ) {
        let [one, other] = names;
        let (Some(first), Some(second)) = (read::set(node, one), read::set(node, other)) else { return };
        let file = self.machine.file();
        let diagnostic = Diagnostic::new("E0206", format!("{a_kind} takes `{one}` or `{other}`, not both"))
            .primary(file, second.name, format!("says {what}"))
            .label(file, first.name, "says it too")
            .help("remove one");
        self.report(id, diagnostic);
    }
}

/// Whether each material can give light, at some time and in some part of it.
pub fn shining(materials: &[Material<Animated>]) -> Vec<bool> {
    let mut shining: Vec<bool> = Vec::with_capacity(materials.len());
    for material in materials {
        let part = |index: usize| shining.get(index) == Some(&true);
        let shines = match &material.bsdf {
            Bsdf::Emitter { emission: Emission::Radiance(light) | Emission::Power(light), color, .. } => {
                light.constant() != Some(&0.0) && color.constant().is_none_or(|color| color.max_element() > 0.0)
            }
            Bsdf::Mix { a, b, amount } => {
                let amount = amount.constant();
                amount != Some(&1.0) && part(*a) || amount != Some(&0.0) && part(*b)
            }
            Bsdf::Glossy { base, metalness, .. } => metalness.constant() != Some(&1.0) && part(*base),
            Bsdf::Sheen { base, .. } => part(*base),
            _ => false,
        };
        shining.push((shines || material.emission.max_element() > 0.0) && material.opacity.constant() != Some(&0.0));
    }
    shining
}
