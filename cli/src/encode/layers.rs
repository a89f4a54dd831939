//! The layers of an EXR beside the picture, as `--aov` names them.

use std::str::FromStr;

/// Which layers are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Layers {
    pub albedo: bool,
    pub normal: bool,
    pub depth: bool,
    pub id: bool,
    pub position: bool,
    pub samples: bool,
}

impl Layers {
    /// The names of those that are wanted.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        let Layers { albedo, normal, depth, id, position, samples } = self;
        let surfaces = [("albedo", albedo), ("normal", normal), ("depth", depth), ("id", id), ("position", position)];
        surfaces.into_iter().chain([("samples", samples)]).filter(|(_, wanted)| *wanted).map(|(name, _)| name)
    }

    /// Whether any of them is about the surfaces that pixels show.
    pub fn of_surfaces(self) -> bool {
        Layers { samples: false, ..self } != Layers::default()
    }
}

impl FromStr for Layers {
    type Err = String;

    fn from_str(text: &str) -> Result<Layers, String> {
        let mut layers = Layers::default();
        for name in text.split(',').map(str::trim) {
            match name {
                "albedo" => layers.albedo = true,
                "normal" => layers.normal = true,
                "depth" => layers.depth = true,
                "id" => layers.id = true,
                "position" => layers.position = true,
                "samples" => layers.samples = true,
                "motion" => return Err(format!("not yet: the layer `{name}` comes in a later version")),
                _ => {
                    let all = "albedo, normal, depth, id, position and samples";
                    return Err(format!("`{name}` is no layer: there are {all}"));
                }
            }
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
            ("id, normal,id", Ok("normal+id")),
            ("albedo,normal,depth,id,samples,position", Ok("albedo+normal+depth+id+position+samples")),
            ("motion", Err("not yet")),
            ("depth,motion", Err("not yet")),
            ("", Err("`` is no layer")),
            ("albedo,", Err("`` is no layer")),
            ("Albedo", Err("`Albedo` is no layer")),
        ] {
            let got = text.parse::<Layers>().map(|layers| layers.names().collect::<Vec<_>>().join("+"));
            match (got, expected) {
                (Ok(got), Ok(expected)) => assert_eq!(got, expected, "{text:?}"),
                (Err(got), Err(expected)) => assert!(got.contains(expected), "{text:?}: {got}"),
                (got, expected) => panic!("{text:?}: {got:?}, expected {expected:?}"),
            }
        }
    }
}
