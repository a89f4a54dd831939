//! Materials of glTF as trees of ours; docs/models.md says which becomes what.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use kinora_scene::{
    Animated, Bsdf, Channel, Color, ColorSpace, DiffuseModel, Emission, Image, ImageTexture, Map, Material, Paint,
    Reflectance, Slot, TexelFilter, Texture, UvSet, Wrap,
};
use serde_json::Value;

use super::geometry::factor;
use super::json::{extension, index, list, numbers, text};
use super::{Fault, Warnings, table::follow};

/// The materials of a model, and what they share.
pub struct Materials<'m> {
    /// Root of the document.
    pub root: &'m Value,
    /// What one is made of stands before it.
    pub made: Vec<Material<Animated>>,
    /// What is left out.
    pub warnings: &'m mut Warnings,
    /// Decodes an image of the document, once.
    pub image: &'m mut dyn FnMut(usize) -> Result<Arc<Image>, Fault>,
    /// Pictures in use, read in the same way.
    pub textures: HashMap<String, Arc<Texture>>,
}

/// Which texture coordinates become the first and the second of a mesh with this material.
pub fn sets(material: Option<&Value>) -> [usize; 2] {
    let mut wanted = Vec::new();
    if let Some(material) = material {
        super::check::coordinates(material, "", &mut wanted);
    }
    let mut sets: Vec<usize> = wanted.into_iter().map(|(set, _)| set).collect();
    sets.sort_unstable();
    sets.dedup();
    match sets.as_slice() {
        [a, b, ..] => [*a, *b],
        [a] if *a > 1 => [*a, 0],
        _ => [0, 1],
    }
}

const REFLECTS_4_PERCENT: f64 = 1.5;

impl Materials<'_> {
    fn push(&mut self, bsdf: Bsdf<Animated>, maps: Vec<Map>) -> usize {
        self.made.push(Material { maps, ..Material::from(bsdf) });
        self.made.len() - 1
    }

    /// The root of a material's tree. `colored`: meshes with it have colours at their vertices; `sets`: see [`sets`].
    pub fn build(&mut self, at: Option<usize>, colored: bool) -> Result<usize, Fault> {
        let nothing = Value::Null;
        let material = at.and_then(|at| list(self.root, "materials").get(at)).unwrap_or(&nothing);
        let sets = sets(Some(material));
        let pbr = material.get("pbrMetallicRoughness").unwrap_or(&nothing);
        let [r, g, b, alpha] = numbers::<4>(pbr, "baseColorFactor").unwrap_or([1.0; 4]);
        let color = Color::new(r as f32, g as f32, b as f32);
        let base = pbr.get("baseColorTexture");

        let mut colors = Vec::new();
        if let Some(base) = base {
            colors.extend(self.map(base, Slot::Color, Channel::Color, ColorSpace::Srgb, sets)?);
        }
        if colored {
            colors.push(vertex(Slot::Color, Channel::Color));
        }
        let mut covers = Vec::new();
        let mut cutoff = None;
        let mut opacity = 1.0;
        let mode = text(material, "alphaMode").unwrap_or("OPAQUE");
        if mode == "MASK" || mode == "BLEND" {
            opacity = alpha;
            cutoff = (mode == "MASK").then(|| factor(material, "alphaCutoff", 0.5));
            if let Some(base) = base {
                covers.extend(self.map(base, Slot::Opacity, Channel::A, ColorSpace::Linear, sets)?);
            }
            if colored {
                covers.push(vertex(Slot::Opacity, Channel::A));
            }
        }

        let mut root = match extension(material, "KHR_materials_unlit") {
            Some(_) => {
                let emission = Emission::Radiance(1.0.into());
                self.push(Bsdf::Emitter { color: color.into(), emission, two_sided: true }, colors)
            }
            None => self.lit(material, pbr, color, &colors, sets)?,
        };
        let glow = numbers::<3>(material, "emissiveFactor").unwrap_or([0.0; 3]);
        let strength = extension(material, "KHR_materials_emissive_strength")
            .map_or(1.0, |strength| factor(strength, "emissiveStrength", 1.0));
        let glow = Vec3::from_array(glow.map(|part| (part * strength) as f32));
        let unlit = extension(material, "KHR_materials_unlit").is_some();
        let shines = glow.max_element() > 0.0 && !unlit;
        let mut maps = covers;
        if shines {
            if let Some(texture) = material.get("emissiveTexture") {
                maps.extend(self.map(texture, Slot::Emission, Channel::Color, ColorSpace::Srgb, sets)?);
            }
            // Light is added over the coats, not under them: a mixture of nothing but one.
            if matches!(self.made.get(root).map(|material| &material.bsdf), Some(Bsdf::Glossy { .. })) {
                root = self.push(Bsdf::Mix { a: root, b: root, amount: 0.0.into() }, Vec::new());
            }
        }
        if let Some(top) = self.made.get_mut(root) {
            top.opacity = opacity.into();
            top.cutoff = cutoff;
            top.emission = if shines { glow } else { Vec3::ZERO };
            top.maps.extend(maps);
        }
        Ok(root)
    }

    fn lit(
        &mut self,
        material: &Value,
        pbr: &Value,
        color: Color,
        colors: &[Map],
        sets: [usize; 2],
    ) -> Result<usize, Fault> {
        let roughness = factor(pbr, "roughnessFactor", 1.0);
        let metalness = factor(pbr, "metallicFactor", 1.0);
        let (mut rough, mut metallic) = (Vec::new(), Vec::new());
        if let Some(texture) = pbr.get("metallicRoughnessTexture") {
            rough.extend(self.map(texture, Slot::Roughness, Channel::G, ColorSpace::Linear, sets)?);
            metallic.extend(self.map(texture, Slot::Metalness, Channel::B, ColorSpace::Linear, sets)?);
        }
        let ior = match extension(material, "KHR_materials_ior").map_or(1.5, |ior| factor(ior, "ior", 1.5)) {
            // 0 stands for a surface that reflects everything.
            ior if ior < 1.0 => 1e3,
            ior => ior,
        };

        // The coat of a dielectric: F0 scaled by KHR_materials_specular.
        let mut f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
        let (mut tint, mut tints, mut shares) = (Color::ONE, Vec::new(), Vec::new());
        if let Some(specular) = extension(material, "KHR_materials_specular") {
            let factors = numbers::<3>(specular, "specularColorFactor").unwrap_or([1.0; 3]);
            // The brightest channel goes into the index of refraction, since a tint has none above 1.
            let most = factors.into_iter().fold(0.0, f64::max);
            if most > 0.0 {
                tint = Vec3::from_array(factors.map(|part| (part / most) as f32));
            }
            f0 = (f0 * factor(specular, "specularFactor", 1.0) * most).clamp(0.0, 0.999);
            if let Some(texture) = specular.get("specularColorTexture") {
                tints.extend(self.map(texture, Slot::Color, Channel::Color, ColorSpace::Srgb, sets)?);
            }
            if let Some(texture) = specular.get("specularTexture") {
                shares.extend(self.map(texture, Slot::Amount, Channel::A, ColorSpace::Linear, sets)?);
            }
        }
        let coat = (1.0 + f0.sqrt()) / (1.0 - f0.sqrt());

        let anisotropy = extension(material, "KHR_materials_anisotropy");
        let strength = anisotropy.map_or(0.0, |set| factor(set, "anisotropyStrength", 0.0));
        let mut stretch = None;
        if let Some(texture) = anisotropy.filter(|_| strength > 0.0).and_then(|set| set.get("anisotropyTexture")) {
            stretch = self.map(texture, Slot::Stretch, Channel::Color, ColorSpace::Linear, sets)?;
        }
        if strength > 0.0 && (metalness < 1.0 || !metallic.is_empty()) {
            self.warnings.add("KHR_materials_anisotropy of what is not metal", "it is round there");
        }
        let transmission = extension(material, "KHR_materials_transmission");
        let through = transmission.map_or(0.0, |set| factor(set, "transmissionFactor", 0.0));
        let apart = metalness > 0.0 && (strength > 0.0 || through > 0.0);

        let matt = Bsdf::Diffuse { color: color.into(), roughness: 0.0.into(), model: DiffuseModel::Eon };
        let matt = self.push(matt, colors.to_vec());
        let glossy = |materials: &mut Self, ior: f64| {
            let metal = if apart { (0.0, [].as_slice()) } else { (metalness, metallic.as_slice()) };
            let (metalness, roughness) = (metal.0.into(), roughness.into());
            let maps = rough.iter().chain(&tints).chain(metal.1).cloned().collect();
            materials.push(Bsdf::Glossy { base: matt, ior, tint: tint.into(), roughness, metalness }, maps)
        };
        let mut stack = glossy(self, coat);
        if !shares.is_empty() {
            let without = glossy(self, 1.0);
            stack = self.push(Bsdf::Mix { a: without, b: stack, amount: 1.0.into() }, shares);
        }
        if let Some(set) = transmission.filter(|_| through > 0.0) {
            let volume = extension(material, "KHR_materials_volume");
            let thick = volume.map_or(0.0, |volume| factor(volume, "thicknessFactor", 0.0)) > 0.0;
            let inside = numbers::<3>(volume.unwrap_or(&Value::Null), "attenuationColor").unwrap_or([1.0; 3]);
            let glass = Bsdf::Dielectric {
                ior: ior.min(100.0).into(),
                roughness: roughness.into(),
                energy_compensation: true,
                attenuation_color: Vec3::from_array(inside.map(|part| part as f32)),
                attenuation_distance_m: volume
                    .map_or(f64::INFINITY, |set| factor(set, "attenuationDistance", f64::INFINITY)),
                thin: !thick,
                priority: 0,
            };
            let mut tints = colors.to_vec();
            if color != Color::ONE {
                tints.push(constant(Slot::Color, color));
            }
            let glass = self.push(glass, tints.into_iter().chain(rough.iter().cloned()).collect());
            let mut maps = Vec::new();
            if let Some(texture) = set.get("transmissionTexture") {
                maps.extend(self.map(texture, Slot::Amount, Channel::R, ColorSpace::Linear, sets)?);
            }
            stack = self.push(Bsdf::Mix { a: stack, b: glass, amount: through.into() }, maps);
        }
        if apart {
            let turn = anisotropy.map_or(0.0, |set| factor(set, "anisotropyRotation", 0.0));
            let [roughness, anisotropy] = match &stretch {
                Some(_) => [roughness, strength],
                None => stretched(roughness, strength),
            };
            let metal = Bsdf::Metal {
                reflectance: Reflectance::Tint { color: color.into(), edge_tint: Color::ONE.into() },
                roughness: roughness.into(),
                anisotropy,
                anisotropy_rotation: turn,
                energy_compensation: true,
            };
            let metal = self.push(metal, colors.iter().chain(&rough).chain(&stretch).cloned().collect());
            let amounts = metallic.iter().map(|map| Map { slot: Slot::Amount, ..map.clone() }).collect();
            stack = self.push(Bsdf::Mix { a: stack, b: metal, amount: metalness.into() }, amounts);
        }
        if let Some(set) = extension(material, "KHR_materials_sheen") {
            stack = self.sheen(stack, set, sets)?;
        }
        // A clear coat has normals of its own.
        let normals = self.normals(material.get("normalTexture"), sets)?;
        if let Some(top) = self.made.get_mut(stack) {
            top.maps.extend(normals);
        }
        if let Some(set) = extension(material, "KHR_materials_clearcoat") {
            stack = self.clearcoat(stack, set, sets)?;
        }
        Ok(stack)
    }

    fn normals(&mut self, texture: Option<&Value>, sets: [usize; 2]) -> Result<Option<Map>, Fault> {
        let Some(texture) = texture else { return Ok(None) };
        let slot = Slot::Normal { strength: factor(texture, "scale", 1.0) };
        self.map(texture, slot, Channel::Color, ColorSpace::Linear, sets)
    }

    fn sheen(&mut self, base: usize, set: &Value, sets: [usize; 2]) -> Result<usize, Fault> {
        let color = numbers::<3>(set, "sheenColorFactor").unwrap_or([0.0; 3]);
        if color == [0.0; 3] {
            return Ok(base);
        }
        let mut maps = Vec::new();
        if let Some(texture) = set.get("sheenColorTexture") {
            maps.extend(self.map(texture, Slot::Color, Channel::Color, ColorSpace::Srgb, sets)?);
        }
        if let Some(texture) = set.get("sheenRoughnessTexture") {
            maps.extend(self.map(texture, Slot::Roughness, Channel::A, ColorSpace::Linear, sets)?);
        }
        let color = Vec3::from_array(color.map(|part| part as f32)).into();
        let roughness = factor(set, "sheenRoughnessFactor", 0.0).into();
        Ok(self.push(Bsdf::Sheen { base, color, roughness }, maps))
    }

    fn clearcoat(&mut self, stack: usize, set: &Value, sets: [usize; 2]) -> Result<usize, Fault> {
        let amount = factor(set, "clearcoatFactor", 0.0);
        if amount == 0.0 {
            return Ok(stack);
        }
        let (mut rough, mut amounts) = (Vec::new(), Vec::new());
        if let Some(texture) = set.get("clearcoatRoughnessTexture") {
            rough.extend(self.map(texture, Slot::Roughness, Channel::G, ColorSpace::Linear, sets)?);
        }
        if let Some(texture) = set.get("clearcoatTexture") {
            amounts.extend(self.map(texture, Slot::Amount, Channel::R, ColorSpace::Linear, sets)?);
        }
        rough.extend(self.normals(set.get("clearcoatNormalTexture"), sets)?);
        let coat = Bsdf::Glossy {
            base: stack,
            ior: REFLECTS_4_PERCENT,
            tint: Color::ONE.into(),
            roughness: factor(set, "clearcoatRoughnessFactor", 0.0).into(),
            metalness: 0.0.into(),
        };
        let coat = self.push(coat, rough);
        if amount == 1.0 && amounts.is_empty() {
            return Ok(coat);
        }
        Ok(self.push(Bsdf::Mix { a: stack, b: coat, amount: amount.into() }, amounts))
    }

    /// A texture of a material as a map; none where it has no picture.
    fn map(
        &mut self,
        info: &Value,
        slot: Slot,
        channel: Channel,
        space: ColorSpace,
        sets: [usize; 2],
    ) -> Result<Option<Map>, Fault> {
        let Some((at, texture)) = follow(self.root, "textures", info, "index") else { return Ok(None) };
        let webp = extension(texture, "EXT_texture_webp").and_then(|webp| index(webp, "source"));
        let Some(source) = webp.or_else(|| index(texture, "source")) else {
            self.warnings.add("a texture without a picture that is known", "it is left out");
            return Ok(None);
        };
        let moved = extension(info, "KHR_texture_transform");
        let set = moved.and_then(|moved| index(moved, "texCoord")).or_else(|| index(info, "texCoord")).unwrap_or(0);
        let uv_set = match sets.iter().position(|known| *known == set) {
            Some(0) => UvSet::First,
            Some(_) => UvSet::Second,
            None => {
                self.warnings.add("more than two sets of texture coordinates of one material", "the third is left out");
                return Ok(None);
            }
        };
        let key = format!("{at} {source} {channel:?} {space:?} {uv_set:?} {}", moved.unwrap_or(&Value::Null));
        if let Some(texture) = self.textures.get(&key) {
            return Ok(Some(Map { slot, texture: texture.clone() }));
        }
        let image = (self.image)(source)?;
        let sampler = follow(self.root, "samplers", texture, "sampler").map(|(_, sampler)| sampler);
        let wrap = |name: &str| match sampler.and_then(|sampler| index(sampler, name)) {
            Some(33_071) => Wrap::Clamp,
            Some(33_648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let nearest = sampler.and_then(|sampler| index(sampler, "magFilter")) == Some(9728);
        let vector =
            |name: &str, default: f64| moved.and_then(|moved| numbers::<2>(moved, name)).unwrap_or([default; 2]);
        let ([u, v], [across, along]) = (vector("offset", 0.0), vector("scale", 1.0));
        let rotation = moved.map_or(0.0, |moved| factor(moved, "rotation", 0.0));
        let (sin, cos) = rotation.sin_cos();
        let texture = ImageTexture {
            space,
            wrap: [wrap("wrapS"), wrap("wrapT")],
            filter: if nearest { TexelFilter::Nearest } else { TexelFilter::Linear },
            scale: Vec2::new(across as f32, along as f32),
            // The file turns about the picture's upper left corner, with v downwards; we about the lower left, upwards.
            offset: Vec2::new((u + sin * along) as f32, (1.0 - v - cos * along) as f32),
            rotation,
            channel,
            uv_set,
            ..ImageTexture::new(image, space)
        };
        let texture = Arc::new(Texture::Image(texture));
        self.textures.insert(key, texture.clone());
        Ok(Some(Map { slot, texture }))
    }
}

/// The same everywhere: a checker of one colour.
fn constant(slot: Slot, color: Color) -> Map {
    let paint = || Paint::Color(color.extend(1.0));
    let texture = Texture::Checker { a: paint(), b: paint(), scale: Vec2::ONE, uv_set: UvSet::First };
    Map { slot, texture: Arc::new(texture) }
}

fn vertex(slot: Slot, channel: Channel) -> Map {
    Map { slot, texture: Arc::new(Texture::VertexColor { channel }) }
}

/// Roughness and anisotropy. The file widens α along the tangent to mix(α, 1, strength²) and keeps it across;
/// ours keeps α's mean square: αx = α √(2 / (1 + (1 − a)²)), αy = (1 − a) αx.
fn stretched(roughness: f64, strength: f64) -> [f64; 2] {
    if strength <= 0.0 {
        return [roughness, 0.0];
    }
    let across = (roughness * roughness).max(1e-4);
    let along = across + (1.0 - across) * strength * strength;
    let ratio = across / along;
    let mean = along / (2.0 / (1.0 + ratio * ratio)).sqrt();
    [mean.sqrt().min(1.0), 1.0 - ratio]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn anisotropy_keeps_both_widths() {
        let [roughness, anisotropy] = stretched(0.4, 0.7);
        let alpha = roughness * roughness;
        let ratio = 1.0 - anisotropy;
        let along = alpha * (2.0 / (1.0 + ratio * ratio)).sqrt();
        assert!((along * ratio - 0.16).abs() < 1e-9);
        assert!((along - (0.16 + 0.84 * 0.49)).abs() < 1e-9);
    }
}
