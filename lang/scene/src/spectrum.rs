//! Metals whose reflectance was measured.

use serde::{Deserialize, Serialize};

/// A metal with measured optical constants, by its chemical symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Spectrum {
    Ag,
    Al,
    Au,
    Cr,
    Cu,
    Fe,
    Ni,
    Ti,
}

impl Spectrum {
    /// All of them, by symbol.
    pub const ALL: &[Spectrum] = &[
        Spectrum::Ag,
        Spectrum::Al,
        Spectrum::Au,
        Spectrum::Cr,
        Spectrum::Cu,
        Spectrum::Fe,
        Spectrum::Ni,
        Spectrum::Ti,
    ];

    /// The chemical symbol: `Au`.
    pub fn symbol(self) -> &'static str {
        match self {
            Spectrum::Ag => "Ag",
            Spectrum::Al => "Al",
            Spectrum::Au => "Au",
            Spectrum::Cr => "Cr",
            Spectrum::Cu => "Cu",
            Spectrum::Fe => "Fe",
            Spectrum::Ni => "Ni",
            Spectrum::Ti => "Ti",
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
