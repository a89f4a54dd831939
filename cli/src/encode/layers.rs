//! The layers of an EXR beside the picture, as `--aov` names them; docs/layers.md says what they hold.

use std::str::FromStr;

use kinora_lang::suggest::{any_of, suggest};

/// One of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Layer {
    Albedo,
    Depth,
    Diffuse,
    Emission,
    Id,
    Motion,
    Normal,
    Position,
    Samples,
    Specular,
    Variance,
}

impl Layer {
    /// All of them by name, in the order of their names.
    pub const ALL: [(&'static str, Layer); 11] = [
        ("albedo", Layer::Albedo),
        ("depth", Layer::Depth),
        ("diffuse", Layer::Diffuse),
        ("emission", Layer::Emission),
        ("id", Layer::Id),
        ("motion", Layer::Motion),
        ("normal", Layer::Normal),
        ("position", Layer::Position),
        ("samples", Layer::Samples),
        ("specular", Layer::Specular),
        ("variance", Layer::Variance),
    ];

    /// Whether it is of the surfaces that pixels show.
    fn is_of_surfaces(self) -> bool {
        use Layer::{Albedo, Depth, Id, Motion, Normal, Position};
        matches!(self, Albedo | Depth | Id | Motion | Normal | Position)
    }

    /// Whether it is of their light in parts.
    fn is_of_parts(self) -> bool {
        matches!(self, Layer::Diffuse | Layer::Emission | Layer::Specular | Layer::Variance)
    }
}

/// Which layers are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers(u16);

impl Layers {
    /// Whether this one is wanted.
    pub fn has(self, layer: Layer) -> bool {
        self.0 & 1 << layer as u16 != 0
    }

    /// Those that are wanted, by name.
    pub fn wanted(self) -> impl Iterator<Item = (&'static str, Layer)> {
        Layer::ALL.into_iter().filter(move |(_, layer)| self.has(*layer))
    }

    /// Whether any of them is about the surfaces that pixels show.
    pub fn of_surfaces(self) -> bool {
        self.wanted().any(|(_, layer)| layer.is_of_surfaces())
    }

    /// Whether any of them is about their light in parts.
    pub fn of_parts(self) -> bool {
        self.wanted().any(|(_, layer)| layer.is_of_parts())
    }
}

impl FromStr for Layers {
    type Err = String;

    fn from_str(text: &str) -> Result<Layers, String> {
        let mut layers = Layers::default();
        for name in text.split(',').map(str::trim) {
            let Some((_, layer)) = Layer::ALL.into_iter().find(|(known, _)| *known == name) else {
                let names = Layer::ALL.map(|(known, _)| known);
                return Err(match suggest(name, names).as_slice() {
                    [] => format!("`{name}` is no layer: there are {}", names.join(", ")),
                    near => format!("`{name}` is no layer; did you mean {}?", any_of(near.iter().copied())),
                });
            };
            layers.0 |= 1 << layer as u16;
        }
        Ok(layers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers() {
        for (text, expected) in [
            ("albedo", Ok("albedo")),
            ("id, normal,id", Ok("id+normal")),
            ("variance,albedo,normal,depth,id,samples", Ok("albedo+depth+id+normal+samples+variance")),
            ("specular,diffuse,motion,position,emission", Ok("diffuse+emission+motion+position+specular")),
            ("", Err("`` is no layer: there are albedo, depth,")),
            ("albedo,", Err("`` is no layer")),
            ("Albedo", Err("`Albedo` is no layer; did you mean `albedo`?")),
            ("depth,difuse", Err("`difuse` is no layer; did you mean `diffuse`?")),
            ("colour", Err("`colour` is no layer: there are")),
        ] {
            let wanted = |layers: Layers| layers.wanted().map(|(name, _)| name).collect::<Vec<_>>().join("+");
            match (text.parse::<Layers>().map(wanted), expected) {
                (Ok(got), Ok(expected)) => assert_eq!(got, expected, "{text:?}"),
                (Err(got), Err(expected)) => assert!(got.contains(expected), "{text:?}: {got}"),
                (got, expected) => panic!("{text:?}: {got:?}, expected {expected:?}"),
            }
        }
    }

    #[test]
    fn each_layer_has_its_name_and_needs_what_it_is_of() {
        for (i, (name, layer)) in Layer::ALL.into_iter().enumerate() {
            assert_eq!((layer as usize, format!("{layer:?}").to_lowercase()), (i, name.into()));
            let only: Layers = name.parse().unwrap();
            assert_eq!((only.of_surfaces(), only.of_parts()), (layer.is_of_surfaces(), layer.is_of_parts()));
            assert!(layer == Layer::Samples || layer.is_of_surfaces() != layer.is_of_parts(), "{name}");
        }
    }
}
