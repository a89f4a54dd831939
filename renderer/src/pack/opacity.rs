//! How many of the rays a material's surface meets: a sum over the parts of its tree of products along the way to them,
//! constant or read from textures at every point.

use std::sync::Arc;

use kinora_scene::{Bsdf, Map, Material, Slot, Still, Texture};

use super::PackError;
use super::textures::Textures;

/// One factor: a number times textures, or 1 minus that; 0 or 1 where there is a cutoff.
#[derive(Clone, Debug)]
pub struct Factor {
    scale: f64,
    cutoff: Option<f64>,
    complement: bool,
    textures: Vec<Arc<Texture>>,
}

impl Factor {
    /// `scale` times the maps of `slot`.
    pub fn of(scale: f64, maps: &[Map], slot: Slot) -> Factor {
        let textures = maps.iter().filter(|map| map.slot == slot).map(|map| map.texture.clone()).collect();
        Factor { scale, cutoff: None, complement: false, textures }
    }

    /// The opacity of a material itself, without that of its parts.
    pub fn opacity(material: &Material<Still>) -> Factor {
        Factor { cutoff: material.cutoff, ..Factor::of(material.opacity, &material.maps, Slot::Opacity) }
    }

    /// 1 minus it.
    pub fn complement(self) -> Factor {
        Factor { complement: !self.complement, ..self }
    }

    fn constant(&self) -> Option<f64> {
        if !self.textures.is_empty() {
            return None;
        }
        let x = match self.cutoff {
            Some(cutoff) => f64::from(u8::from(self.scale >= cutoff)),
            None => self.scale,
        };
        Some(if self.complement { 1.0 - x } else { x })
    }

    // About; a cutoff is taken to be passed by the share that it would be without.
    fn mean(&self, textures: &mut Textures) -> f64 {
        let mut x = self.scale;
        for texture in &self.textures {
            x *= f64::from(textures.average(texture).x);
        }
        let x = x.clamp(0.0, 1.0);
        if self.complement { 1.0 - x } else { x }
    }
}

/// Terms that are added, each a product.
#[derive(Clone, Debug)]
pub struct Opacity(Vec<Vec<Factor>>);

/// Factors of one material; a tree of mixes whose opacities vary has as many as ways from its root to its parts.
const MAX_FACTORS: usize = 4_096;

/// That of a material; `known` are those of the materials before it.
///
/// # Errors
/// There are more than [`MAX_FACTORS`] factors.
pub fn of(material: &Material<Still>, known: &[Opacity]) -> Result<Opacity, PackError> {
    let own = Factor::opacity(material);
    let parts = match material.bsdf {
        Bsdf::Glossy { base, .. } | Bsdf::Sheen { base, .. } => known[base].clone(),
        Bsdf::Mix { a, b, amount } => {
            let second = Factor::of(amount, &material.maps, Slot::Amount);
            match (known[a].constant(), known[b].constant()) {
                // Whichever of them it is.
                (Some(a), Some(b)) if a == b => Opacity::from(a),
                _ => known[a].times(&second.clone().complement()).plus(&known[b].times(&second)),
            }
        }
        _ => Opacity::from(1.0),
    };
    let all = parts.times(&own);
    all.check()
}

impl From<f64> for Opacity {
    fn from(constant: f64) -> Self {
        Opacity(vec![vec![Factor { scale: constant, cutoff: None, complement: false, textures: Vec::new() }]])
    }
}

impl Opacity {
    /// The sum of both.
    pub fn plus(&self, other: &Opacity) -> Opacity {
        match (self.constant(), other.constant()) {
            (Some(a), Some(b)) => Opacity::from(a + b),
            _ => Opacity([self.0.clone(), other.0.clone()].concat()),
        }
    }

    /// # Errors
    /// There are more than [`MAX_FACTORS`] factors.
    pub fn check(self) -> Result<Opacity, PackError> {
        match self.0.iter().map(|term| term.len() + 1).sum::<usize>() > MAX_FACTORS {
            true => Err(PackError::CutOuts { limit: MAX_FACTORS }),
            false => Ok(self),
        }
    }

    /// The product of both.
    pub fn times(&self, factor: &Factor) -> Opacity {
        let all = self.0.iter().map(|term| term.iter().chain([factor]).cloned().collect()).collect();
        let all = Opacity(all);
        match all.constant() {
            Some(constant) => Opacity::from(constant),
            None => all,
        }
    }

    /// What it is everywhere, if that is the same.
    pub fn constant(&self) -> Option<f64> {
        let is_zero = |term: &Vec<Factor>| term.iter().any(|factor| factor.constant() == Some(0.0));
        self.0
            .iter()
            .filter(|term| !is_zero(term))
            .map(|term| term.iter().map(Factor::constant).product::<Option<f64>>())
            .sum()
    }

    /// Its mean, about.
    pub fn mean(&self, textures: &mut Textures) -> f64 {
        match self.constant() {
            Some(constant) => constant,
            None => {
                let mut term = |term: &Vec<Factor>| term.iter().map(|f| f.mean(textures)).product::<f64>();
                self.0.iter().map(&mut term).sum()
            }
        }
    }

    /// The place of its terms, as `terms_value` reads them; 0 where it is constant.
    pub fn pack(&self, textures: &mut Textures) -> Result<u32, PackError> {
        if self.constant().is_some() {
            return Ok(0);
        }
        let mut words = vec![self.0.len() as u32];
        for term in &self.0 {
            words.push(term.len() as u32);
            for factor in term {
                let cutoff = factor.cutoff.unwrap_or(-1.0);
                let count = (factor.textures.len() as u32) << 1 | u32::from(factor.complement);
                words.extend([(factor.scale as f32).to_bits(), (cutoff as f32).to_bits(), count]);
                for texture in &factor.textures {
                    words.push(textures.place(texture)?);
                }
            }
        }
        Ok(textures.push(words))
    }
}
