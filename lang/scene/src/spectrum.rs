//! Metals whose reflectance was measured.

use serde::{Deserialize, Serialize};

/// A metal with measured optical constants, by its chemical symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Spectrum {
    Ag,
    Al,
    Au,
    Co,
    Cr,
    Cu,
    Fe,
    Ni,
    Pd,
    Pt,
    Ti,
    V,
    W,
}

impl Spectrum {
    /// All of them, by symbol.
    pub const ALL: &[Spectrum] = &[
        Spectrum::Ag,
        Spectrum::Al,
        Spectrum::Au,
        Spectrum::Co,
        Spectrum::Cr,
        Spectrum::Cu,
        Spectrum::Fe,
        Spectrum::Ni,
        Spectrum::Pd,
        Spectrum::Pt,
        Spectrum::Ti,
        Spectrum::V,
        Spectrum::W,
    ];

    /// The chemical symbol: `Au`.
    pub fn symbol(self) -> &'static str {
        match self {
            Spectrum::Ag => "Ag",
            Spectrum::Al => "Al",
            Spectrum::Au => "Au",
            Spectrum::Co => "Co",
            Spectrum::Cr => "Cr",
            Spectrum::Cu => "Cu",
            Spectrum::Fe => "Fe",
            Spectrum::Ni => "Ni",
            Spectrum::Pd => "Pd",
            Spectrum::Pt => "Pt",
            Spectrum::Ti => "Ti",
            Spectrum::V => "V",
            Spectrum::W => "W",
        }
    }

    /// The metal of that symbol.
    ///
    /// ```
    /// use kinora_scene::Spectrum;
    /// assert_eq!(Spectrum::find("Au"), Some(Spectrum::Au));
    /// assert_eq!(Spectrum::find("gold"), None);
    /// ```
    pub fn find(symbol: &str) -> Option<Spectrum> {
        Spectrum::ALL.iter().copied().find(|metal| metal.symbol() == symbol)
    }
}
