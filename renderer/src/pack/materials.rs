//! Materials as the kernel reads them: a tree of records each, whose roots stand where the world has them. What follows
//! from the tree alone (opacity, colours beneath coats, compensation) is worked out here, once.

use std::collections::BTreeMap;

use glam::{IVec4, UVec4, Vec3, Vec4};
use kinora_kernel::generated::{
    CHOICE, COMPENSATE, DIELECTRIC_THIN, DIELECTRIC_TINTED, DIFFUSE_EON, DIFFUSE_FON, DIFFUSE_QON, EMITTER_GLOW,
    EMITTER_TWO_SIDED, MAPS_FLAGS, MAPS_LIST, MAPS_NORMAL, MAPS_OPACITY, MAPS_OPEN, MAPS_SPLIT, MATERIAL_DIELECTRIC,
    MATERIAL_DIFFUSE, MATERIAL_EMITTER, MATERIAL_GLOSSY, MATERIAL_METAL, MATERIAL_MIX, MATERIAL_SHEEN, MAX_DEPTH,
    METAL_SPECTRUM, METAL_STRETCHED, MIRROR_ALPHA, NONE, SLOT_AMOUNT, SLOT_ANISOTROPY, SLOT_COLOR, SLOT_EDGE_TINT,
    SLOT_METALNESS, SLOT_ROUGHNESS, SLOT_STRETCH,
};
use kinora_kernel::{Material as Packed, Packed as Scene, albedo};
use kinora_scene::{Bsdf, DiffuseModel, Emission, Map, Material, Reflectance, Slot, Still};

use super::opacity::{self, Factor, Opacity};
use super::textures::{Maps, Textures};
use super::{PackError, spectra, tapes};

/// One emitter of a material's tree, on a shape.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// W/(m² sr), by channel, with the share that the emitter has in the mixture. The mean, where it varies.
    pub radiance: Vec3,
    /// Whether the inner side shines too.
    pub two_sided: bool,
    /// The coats over it, from the outside.
    pub coats: Vec<usize>,
    /// If it varies over the surface: how.
    pub glow: Option<Glow>,
}

/// Light that varies over a surface.
#[derive(Clone, Debug)]
pub struct Glow {
    /// W/(m² sr), by channel, before `color` and `share`.
    radiance: Vec3,
    color: Vec<Map>,
    /// Of all rays, those that cut-outs let pass included.
    share: Opacity,
}

/// The records of the world's materials, and what its shapes must know of them.
pub struct Materials {
    /// Those of the world at their own indices; others that they refer to follow.
    pub records: Vec<Packed>,
    /// What each of the world's reads of a mesh's vertices.
    pub reads: Vec<Reads>,
    /// Whether each of the world's shines in some part.
    pub shines: Vec<bool>,
}

/// What a material, parts included, reads of a mesh's vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reads {
    /// Coordinates or colours.
    pub textures: bool,
    /// The direction of growing u.
    pub tangents: bool,
    /// A normal map.
    normals: bool,
    /// Where a point is in the shape's own space.
    pub local: bool,
}

impl Reads {
    fn and(self, other: Reads) -> Reads {
        Reads {
            textures: self.textures || other.textures,
            tangents: self.tangents || other.tangents,
            normals: self.normals || other.normals,
            local: self.local || other.local,
        }
    }
}

/// The records of `materials`; their maps go to `textures`.
///
/// # Errors
/// A tree is too deep, or textures are too many or too large.
pub fn pack(materials: &[Material<Still>], textures: &mut Textures) -> Result<Materials, PackError> {
    let mut packer = Packer {
        materials,
        textures,
        records: Vec::with_capacity(materials.len()),
        more: Vec::new(),
        colors: Vec::with_capacity(materials.len()),
        reads: Vec::with_capacity(materials.len()),
        opacities: Vec::with_capacity(materials.len()),
    };
    let mut depths: Vec<u32> = Vec::with_capacity(materials.len());
    for (index, material) in materials.iter().enumerate() {
        let beneath = |i: usize| depths.get(i).copied().unwrap_or(0);
        let depth = 1 + material.bsdf.parts().map_or(0, |[a, b]| beneath(a).max(beneath(b)));
        if depth >= MAX_DEPTH {
            return Err(PackError::Materials { limit: MAX_DEPTH as usize });
        }
        depths.push(depth);
        packer.add(index, material)?;
    }
    let Packer { records, more, reads, .. } = packer;
    Ok(Materials { records: records.into_iter().chain(more).collect(), reads, shines: shining(materials) })
}

// One material after the other, with what those before it are.
struct Packer<'a> {
    materials: &'a [Material<Still>],
    textures: &'a mut Textures,
    records: Vec<Packed>,
    /// What follows the records of `materials`.
    more: Vec<Packed>,
    colors: Vec<Vec3>,
    reads: Vec<Reads>,
    opacities: Vec<Opacity>,
}

impl Packer<'_> {
    fn add(&mut self, index: usize, material: &Material<Still>) -> Result<(), PackError> {
        self.colors.push(color_of(material, &self.colors));
        self.opacities.push(opacity::of(material, &self.opacities)?);
        let own = self.own_reads(material);
        let parts = material.bsdf.parts().map_or(Reads::default(), |[a, b]| self.reads[a].and(self.reads[b]));
        self.reads.push(own.and(parts));
        let mut maps = Maps::default();
        maps[MAPS_LIST as usize] = self.list(&material.maps, slots_of(material))?;
        let mapped = maps[MAPS_LIST as usize] != 0;
        let mut record = self.record(material, mapped)?;
        let opacity = self.opacities[index].clone();
        record.more.w = opacity.mean(self.textures) as f32;
        if opacity.constant().is_none() {
            // Below 1 it is known that rays pass.
            record.more.w = record.more.w.min(1.0 - f32::EPSILON);
        }
        maps[MAPS_OPACITY as usize] = opacity.pack(self.textures)?;
        let normal = material.maps.iter().rev().find_map(|map| match map.slot {
            Slot::Normal { strength } => Some((map, strength)),
            _ => None,
        });
        if let Some((map, strength)) = normal {
            maps[MAPS_NORMAL as usize] = self.textures.normal_map(&map.texture, strength)?;
        }
        if mapped || record.kind.x == MATERIAL_MIX && self.is_open(material) {
            record.kind.y |= CHOICE;
        }
        if self.is_open(material) {
            maps[MAPS_FLAGS as usize] |= MAPS_OPEN;
        }
        if matches!(material.bsdf, Bsdf::Glossy { .. }) && parts.normals {
            maps[MAPS_FLAGS as usize] |= MAPS_SPLIT;
        }
        self.textures.set_maps(index, maps);
        self.records.push(record);
        Ok(())
    }

    fn own_reads(&self, material: &Material<Still>) -> Reads {
        let stretched = matches!(material.bsdf, Bsdf::Metal { anisotropy, .. } if anisotropy > 0.0)
            || has_slot(&material.maps, |slot| slot == Slot::Stretch);
        let normals = material.maps.iter().any(|map| matches!(map.slot, Slot::Normal { .. }));
        let local = tapes::reads_local(&material.maps);
        Reads { textures: !material.maps.is_empty(), tangents: stretched || normals, normals, local }
    }

    // Whether it is a mix whose parts are met by different shares of rays from point to point.
    fn is_open(&self, material: &Material<Still>) -> bool {
        let Bsdf::Mix { a, b, .. } = material.bsdf else { return false };
        match (self.opacities[a].constant(), self.opacities[b].constant()) {
            (Some(a), Some(b)) => a != b && has_slot(&material.maps, |slot| slot == Slot::Amount),
            _ => true,
        }
    }

    // The place of a list of those of the maps whose slots the kind has.
    fn list(&mut self, maps: &[Map], slots: &[Slot]) -> Result<u32, PackError> {
        list(self.textures, maps.iter().filter(|map| slots.contains(&map.slot)))
    }

    // Another record, with these maps.
    fn push(&mut self, record: Packed, maps: Maps) -> u32 {
        self.more.push(record);
        let index = self.materials.len() + self.more.len() - 1;
        self.textures.set_maps(index, maps);
        index as u32
    }

    // `mapped`: some of what it says is a factor only, and what follows from it is worked out at every point.
    fn record(&mut self, material: &Material<Still>, mapped: bool) -> Result<Packed, PackError> {
        Ok(match &material.bsdf {
            Bsdf::Diffuse { color, roughness, model } => {
                let model = match model {
                    DiffuseModel::Eon => DIFFUSE_EON,
                    DiffuseModel::Fon => DIFFUSE_FON,
                    DiffuseModel::Qon => DIFFUSE_QON,
                };
                let choice = if *roughness > 0.0 { CHOICE } else { 0 };
                Packed {
                    color: color.extend(0.0),
                    lobe: Vec4::new(0.0, 0.0, *roughness as f32, 0.0),
                    kind: UVec4::new(MATERIAL_DIFFUSE, model | choice, 0, 0),
                    ..Packed::default()
                }
            }
            &Bsdf::Metal { ref reflectance, roughness, anisotropy, anisotropy_rotation, energy_compensation } => {
                let (color, extra, flags) = match reflectance {
                    Reflectance::Tint { color, edge_tint } if mapped => (*color, *edge_tint, 0),
                    Reflectance::Tint { color, edge_tint } => (*color, f82_term(*color, *edge_tint), 0),
                    Reflectance::Spectrum(spectrum) => {
                        let [n, k] = spectra::constants(*spectrum);
                        (n, k, METAL_SPECTRUM)
                    }
                };
                let stretched = has_slot(&material.maps, |slot| slot == Slot::Stretch);
                let flags = flags | if stretched { METAL_STRETCHED } else { 0 };
                let record = Packed {
                    color: color.extend(anisotropy_rotation.cos() as f32),
                    extra: extra.extend(anisotropy_rotation.sin() as f32),
                    lobe: widths(roughness, anisotropy),
                    kind: UVec4::new(MATERIAL_METAL, flags | if energy_compensation { COMPENSATE } else { 0 }, 0, 0),
                    ..Packed::default()
                };
                if mapped { self.mapped_metal(record) } else { metal(record) }
            }
            &Bsdf::Dielectric {
                ior,
                roughness,
                energy_compensation,
                attenuation_color,
                attenuation_distance_m,
                thin,
                priority,
            } => {
                let absorption =
                    if thin { Vec3::ZERO } else { absorption_per_m(attenuation_color, attenuation_distance_m) };
                let lobe = widths(roughness, 0.0);
                let mut flags = if thin { DIELECTRIC_THIN } else { 0 };
                if has_slot(&material.maps, |slot| slot == Slot::Color) {
                    flags |= DIELECTRIC_TINTED;
                }
                if mapped || lobe.x >= MIRROR_ALPHA {
                    flags |= CHOICE | if energy_compensation { COMPENSATE } else { 0 };
                }
                Packed {
                    color: Vec4::ONE,
                    extra: absorption.extend(ior as f32),
                    lobe,
                    kind: IVec4::new(MATERIAL_DIELECTRIC as i32, flags as i32, priority, 0).as_uvec4(),
                    ..Packed::default()
                }
            }
            &Bsdf::Glossy { base, ior, tint, roughness, metalness } => {
                let lobe = widths(roughness, 0.0);
                // Never chosen where there is no metal.
                let metal = if metalness > 0.0 { self.metal_of(base, roughness, &material.maps)? } else { NONE };
                Packed {
                    color: tint.extend(0.0),
                    lobe: Vec4::new(lobe.x, ior as f32, roughness as f32, metalness as f32),
                    kind: UVec4::new(MATERIAL_GLOSSY, CHOICE, base as u32, metal),
                    ..Packed::default()
                }
            }
            &Bsdf::Sheen { base, color, roughness } => Packed {
                color: color.extend(0.0),
                lobe: Vec4::new(0.0, 0.0, roughness as f32, 0.0),
                kind: UVec4::new(MATERIAL_SHEEN, CHOICE, base as u32, 0),
                ..Packed::default()
            },
            &Bsdf::Mix { a, b, amount } => {
                let share = match (self.opacities[a].constant(), self.opacities[b].constant()) {
                    (Some(a), Some(b)) if !mapped => {
                        let share = amount * b;
                        let met = (1.0 - amount) * a + share;
                        if met > 0.0 { share / met } else { 0.0 }
                    }
                    // Worked out at every point, or the same because the parts are met by as many.
                    _ => amount,
                };
                Packed {
                    lobe: Vec4::new(share as f32, 0.0, 0.0, 0.0),
                    kind: UVec4::new(MATERIAL_MIX, CHOICE, a as u32, b as u32),
                    ..Packed::default()
                }
            }
            Bsdf::Emitter { .. } => Packed { kind: UVec4::new(MATERIAL_EMITTER, 0, NONE, NONE), ..Packed::default() },
        })
    }

    // What a metal with maps keeps for every point: where it is measured, its average reflectance.
    fn mapped_metal(&mut self, mut record: Packed) -> Packed {
        if record.kind.y & COMPENSATE != 0 {
            self.textures.needs_losses(record.lobe.w > 0.0);
            record.kind.y |= CHOICE;
        }
        if record.kind.y & METAL_SPECTRUM != 0 {
            record.more = average_reflectance(record).extend(record.more.w);
        }
        record
    }

    // The metal that a glossy material mixes in: of the colour of its base, whose maps it shares.
    fn metal_of(&mut self, base: usize, roughness: f64, coat: &[Map]) -> Result<u32, PackError> {
        let material = &self.materials[base];
        let is_rough = |slot: Slot| slot == Slot::Roughness;
        let rough = has_slot(coat, is_rough);
        match material.bsdf {
            Bsdf::Glossy { base, .. } | Bsdf::Sheen { base, .. } => return self.metal_of(base, roughness, coat),
            Bsdf::Mix { a, b, amount } if self.reads[base].textures => {
                let [a, b] = [self.metal_of(a, roughness, coat)?, self.metal_of(b, roughness, coat)?];
                let mut maps = Maps::default();
                maps[MAPS_LIST as usize] = self.list(&material.maps, &[Slot::Amount])?;
                let record = Packed {
                    more: Vec4::W,
                    lobe: Vec4::new(amount as f32, 0.0, 0.0, 0.0),
                    kind: UVec4::new(MATERIAL_MIX, CHOICE, a, b),
                    ..Packed::default()
                };
                return Ok(self.push(record, maps));
            }
            _ => {}
        }
        let colored = slots_of(material).contains(&Slot::Color);
        let shared = material.maps.iter().filter(|map| colored && map.slot == Slot::Color);
        let maps: Vec<Map> = shared.chain(coat.iter().filter(|map| is_rough(map.slot))).cloned().collect();
        let mut words = Maps::default();
        words[MAPS_LIST as usize] = self.list(&maps, &[Slot::Color, Slot::Roughness])?;
        let record = Packed {
            color: self.colors[base].extend(1.0),
            more: Vec4::W,
            lobe: widths(roughness, 0.0),
            kind: UVec4::new(MATERIAL_METAL, COMPENSATE, 0, 0),
            ..Packed::default()
        };
        if maps.is_empty() && !rough {
            return Ok(self.push(metal(record), words));
        }
        // A factor keeps the tint itself.
        let record = self.mapped_metal(Packed { extra: Vec3::ONE.extend(0.0), ..record });
        Ok(self.push(record, words))
    }
}

fn has_slot(maps: &[Map], is: impl Fn(Slot) -> bool) -> bool {
    maps.iter().any(|map| is(map.slot))
}

// Those of a material that scale its own record.
fn slots_of(material: &Material<Still>) -> &'static [Slot] {
    match &material.bsdf {
        Bsdf::Diffuse { .. } => &[Slot::Color, Slot::Roughness],
        Bsdf::Metal { reflectance: Reflectance::Tint { .. }, .. } => {
            &[Slot::Color, Slot::EdgeTint, Slot::Roughness, Slot::Anisotropy, Slot::Stretch]
        }
        Bsdf::Metal { .. } => &[Slot::Roughness, Slot::Anisotropy, Slot::Stretch],
        Bsdf::Dielectric { .. } => &[Slot::Color, Slot::Roughness],
        Bsdf::Glossy { .. } => &[Slot::Color, Slot::Roughness, Slot::Metalness],
        Bsdf::Sheen { .. } => &[Slot::Color, Slot::Roughness],
        Bsdf::Mix { .. } => &[Slot::Amount],
        Bsdf::Emitter { .. } => &[],
    }
}

fn slot_code(slot: Slot) -> u32 {
    match slot {
        Slot::EdgeTint => SLOT_EDGE_TINT,
        Slot::Roughness => SLOT_ROUGHNESS,
        Slot::Anisotropy => SLOT_ANISOTROPY,
        Slot::Metalness => SLOT_METALNESS,
        Slot::Amount => SLOT_AMOUNT,
        Slot::Stretch => SLOT_STRETCH,
        _ => SLOT_COLOR,
    }
}

// α along and across the tangent, roughness, anisotropy; smooth only as a whole.
fn widths(roughness: f64, anisotropy: f64) -> Vec4 {
    let [along, across] = albedo::alphas(roughness, anisotropy).map(|alpha| alpha as f32);
    let narrowest = if along < MIRROR_ALPHA { 0.0 } else { MIRROR_ALPHA };
    Vec4::new(along.max(narrowest), across.max(narrowest), roughness as f32, anisotropy as f32)
}

// Fills in what light scattered more than once is worth (Kulla and Conty 2017): F²E / (1 − F(1 − E)) / (1 − E), with F
// and E the averages of reflectance and albedo.
fn metal(mut record: Packed) -> Packed {
    let compensates = record.lobe.x >= MIRROR_ALPHA && record.kind.y & COMPENSATE != 0;
    record.kind.y &= !COMPENSATE;
    if !compensates {
        return record;
    }
    let lost = albedo::average_lost(f64::from(record.lobe.z), f64::from(record.lobe.w)) as f32;
    if lost < 1e-5 {
        return record;
    }
    let reflectance = average_reflectance(record);
    let multiple = reflectance * reflectance * (1.0 - lost) / (Vec3::ONE - reflectance * lost);
    record.more = (multiple / lost).extend(record.more.w);
    record.kind.y |= COMPENSATE | CHOICE;
    record
}

// The mean of a metal's reflectance over the hemisphere, weighted by the cosine.
fn average_reflectance(record: Packed) -> Vec3 {
    let mut scene = Scene::empty();
    scene.materials[0] = record;
    scene.with_kernel(|kernel| {
        let bsdf = kernel.bsdf_at(0, 1.0, 0.0);
        albedo::average(|c| kernel.metal_fresnel(bsdf, c))
    })
}

// The colour that a material has; 0 where it has none. `known`: those of the materials before it.
fn color_of(material: &Material<Still>, known: &[Vec3]) -> Vec3 {
    match &material.bsdf {
        Bsdf::Diffuse { color, .. } => *color,
        Bsdf::Metal { reflectance: Reflectance::Tint { color, .. }, .. } => *color,
        Bsdf::Metal { reflectance: Reflectance::Spectrum(spectrum), .. } => spectra::facing(*spectrum),
        &Bsdf::Glossy { base, .. } | &Bsdf::Sheen { base, .. } => known[base],
        &Bsdf::Mix { a, b, amount } => known[a].lerp(known[b], amount as f32),
        Bsdf::Dielectric { .. } | Bsdf::Emitter { .. } => Vec3::ZERO,
    }
}

/// What of a material's tree shines, on a shape whose area in the world is `area_m2`.
///
/// # Errors
/// More than [`MAX_EMITTERS`] parts shine, or how much they do depends on too many values.
pub fn emitters(
    materials: &[Material<Still>],
    root: usize,
    records: &[Packed],
    textures: &mut Textures,
    area_m2: impl Fn() -> f64,
) -> Result<Vec<Emitter>, PackError> {
    // Materials may share parts: a part is looked at once for all that mix it in, after all of them, since it stands
    // before them; but apart for each way of coats over it. Of each, its share of the rays that meet the material, where
    // that is the same everywhere, and its share of all rays.
    let mut open = BTreeMap::from([((root, Vec::new()), (1.0_f32, Opacity::from(1.0)))]);
    let mut found = Vec::new();
    let cover = records.get(root).map_or(0.0, |record| record.more.w).max(1e-6);
    let evenly_met = textures.maps_of(root)[MAPS_OPACITY as usize] == 0;
    while let Some(((index, coats), (share, met))) = open.pop_last() {
        let Some(material) = materials.get(index).filter(|_| share > 0.0) else { continue };
        let met = met.times(&Factor::opacity(material)).check()?;
        let mut shine = |radiance: Vec3, slot: Slot, two_sided: bool, coats: Vec<usize>| {
            let color: Vec<Map> = material.maps.iter().filter(|map| map.slot == slot).cloned().collect();
            let rough = |&coat: &usize| has_slot(&materials[coat].maps, |slot| slot == Slot::Roughness);
            if evenly_met && met.constant().is_some() && color.is_empty() && !coats.iter().any(rough) {
                found.push(Emitter { radiance: radiance * share, two_sided, coats, glow: None });
                return;
            }
            let mut mean = radiance * (met.mean(textures) as f32 / cover);
            for map in &color {
                mean *= textures.average(&map.texture).truncate().max(Vec3::ZERO);
            }
            let glow = Some(Glow { radiance, color, share: met.clone() });
            found.push(Emitter { radiance: mean, two_sided, coats, glow });
        };
        let coated = || coats.iter().copied().chain([index]).collect::<Vec<_>>();
        if material.emission.max_element() > 0.0 {
            let coats = if matches!(material.bsdf, Bsdf::Glossy { .. }) { coated() } else { coats.clone() };
            shine(material.emission, Slot::Emission, false, coats);
        }
        let mut add = |index, coats: Vec<usize>, share: f32, met: Opacity| {
            let all = open.entry((index, coats)).or_insert((0.0, Opacity::from(0.0)));
            *all = (all.0 + share, all.1.plus(&met));
        };
        match &material.bsdf {
            Bsdf::Emitter { color, emission, two_sided } => {
                let sides = if *two_sided { 2.0 } else { 1.0 };
                let radiance = match emission {
                    Emission::Radiance(radiance) => *radiance,
                    Emission::Power(power) => power / (std::f64::consts::PI * sides * area_m2()),
                };
                shine(*color * radiance as f32, Slot::Color, *two_sided, coats);
            }
            &Bsdf::Mix { a, b, amount } => {
                let second = records[index].lobe.x;
                let amount = Factor::of(amount, &material.maps, Slot::Amount);
                add(b, coats.clone(), share * second, met.times(&amount));
                // Where the amount is a factor only, some of the first is left.
                let first = if has_slot(&material.maps, |slot| slot == Slot::Amount) { 1.0 } else { 1.0 - second };
                add(a, coats, share * first, met.times(&amount.complement()));
            }
            &Bsdf::Glossy { base, metalness, .. } => {
                let metal = Factor::of(metalness, &material.maps, Slot::Metalness);
                let rest = if has_slot(&material.maps, |slot| slot == Slot::Metalness) { 1.0 } else { 1.0 - metalness };
                add(base, coated(), share * rest as f32, met.times(&metal.complement()));
            }
            // Light passes between the fibres.
            &Bsdf::Sheen { base, .. } => add(base, coats, share, met),
            _ => {}
        }
        if open.len() + found.len() > MAX_EMITTERS {
            return Err(PackError::Emitters { limit: MAX_EMITTERS });
        }
    }
    Ok(found)
}

/// Whether each material can shine, in some part of it.
fn shining(materials: &[Material<Still>]) -> Vec<bool> {
    let mut shining: Vec<bool> = Vec::with_capacity(materials.len());
    for material in materials {
        let part = |index: usize| shining.get(index) == Some(&true);
        shining.push(
            material.emission.max_element() > 0.0
                || matches!(material.bsdf, Bsdf::Emitter { .. })
                || material.bsdf.parts().is_some_and(|parts| parts.into_iter().any(part)),
        );
    }
    shining
}

/// Parts of one material that may shine, each under coats of its own.
const MAX_EMITTERS: usize = 1000;

/// Of emitters that neither vary nor have coats: radiance as bits and whether both sides shine.
type Plain = ([u32; 3], bool);

/// First records of emitters that are there already.
pub type Known = BTreeMap<Vec<Plain>, u32>;

/// Appends records of `emitters`, one linked to the next, or finds them among the `known` ones: thousands of lamps that
/// are alike have one, which stays in a CPU's caches. Gives the first's index, or NONE.
///
/// # Errors
/// Textures are too deep or too large.
pub fn add_emitters(
    records: &mut Vec<Packed>,
    known: &mut Known,
    textures: &mut Textures,
    emitters: &[Emitter],
) -> Result<u32, PackError> {
    let plain = |emitter: &Emitter| {
        let bits = emitter.radiance.to_array().map(f32::to_bits);
        (emitter.glow.is_none() && emitter.coats.is_empty()).then_some((bits, emitter.two_sided))
    };
    let Some(key) = emitters.iter().map(plain).collect::<Option<Vec<_>>>() else {
        return append_emitters(records, textures, emitters);
    };
    if let Some(&first) = known.get(&key) {
        return Ok(first);
    }
    let first = append_emitters(records, textures, emitters)?;
    known.insert(key, first);
    Ok(first)
}

/// As [`add_emitters`], but the records are new.
///
/// # Errors
/// As there.
pub fn append_emitters(
    records: &mut Vec<Packed>,
    textures: &mut Textures,
    emitters: &[Emitter],
) -> Result<u32, PackError> {
    let mut next = NONE;
    for emitter in emitters.iter().rev() {
        let mut coat = NONE;
        for &index in &emitter.coats {
            let kind = UVec4::new(MATERIAL_GLOSSY, 0, records[index].kind.z, coat);
            records.push(Packed { lobe: records[index].lobe, kind, ..Packed::default() });
            coat = records.len() as u32 - 1;
            if emitter.glow.is_some() {
                let list = textures.maps_of(index)[MAPS_LIST as usize];
                let mut maps = Maps::default();
                maps[MAPS_LIST as usize] = list;
                textures.set_maps(records.len() - 1, maps);
            }
        }
        let mut flags = if emitter.two_sided { EMITTER_TWO_SIDED } else { 0 };
        let mut radiance = emitter.radiance;
        let mut maps = Maps::default();
        if let Some(glow) = &emitter.glow {
            flags |= EMITTER_GLOW;
            radiance = glow.radiance * glow.share.constant().unwrap_or(1.0) as f32;
            maps[MAPS_OPACITY as usize] = glow.share.pack(textures)?;
            maps[MAPS_LIST as usize] = list(textures, glow.color.iter())?;
            textures.begin();
        }
        records.push(Packed {
            color: radiance.extend(0.0),
            kind: UVec4::new(MATERIAL_EMITTER, flags, coat, next),
            ..Packed::default()
        });
        next = records.len() as u32 - 1;
        textures.set_maps(next as usize, maps);
    }
    Ok(next)
}

// The place of a list of maps; 0 where there are none.
fn list<'a>(textures: &mut Textures, maps: impl Iterator<Item = &'a Map>) -> Result<u32, PackError> {
    let mut words = vec![0];
    for map in maps {
        words.extend([slot_code(map.slot), textures.place(&map.texture)?]);
    }
    if words.len() == 1 {
        return Ok(0);
    }
    words[0] = (words.len() / 2) as u32;
    Ok(textures.push(words))
}

// The factor a of F82-tint (Kutz et al. 2021): Schlick(1/7) · (1 − tint) / (c (1 − c)⁶) at c = 1/7.
fn f82_term(color: Vec3, tint: Vec3) -> Vec3 {
    let schlick = color + (Vec3::ONE - color) * 0.462_664_36;
    schlick * (Vec3::ONE - tint) / 0.056_652_78
}

// −ln(colour) / distance; a channel of 0 counts as 1e-4, since it would absorb everything at once.
fn absorption_per_m(color: Vec3, distance_m: f64) -> Vec3 {
    let channel = |c: f32| (-f64::from(c.clamp(1e-4, 1.0)).ln() / distance_m) as f32;
    Vec3::new(channel(color.x), channel(color.y), channel(color.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn emitter() -> Material<Still> {
        Bsdf::Emitter { color: Vec3::ONE, emission: Emission::Radiance(2.0), two_sided: false }.into()
    }

    fn matt() -> Material<Still> {
        Bsdf::Diffuse { color: Vec3::splat(0.5), roughness: 0.0, model: DiffuseModel::Eon }.into()
    }

    #[test]
    fn absorption_gives_the_colour_after_its_distance() {
        let a = absorption_per_m(Vec3::new(0.5, 1.0, 0.0), 0.5);
        assert!(((-a.x).exp() - 0.25).abs() < 1e-6, "after 1 m: {}", (-a.x).exp());
        assert_eq!(a.y, 0.0);
        assert!(a.z.is_finite());
        assert_eq!(absorption_per_m(Vec3::splat(0.5), f64::INFINITY), Vec3::ZERO);
    }

    #[test]
    fn a_white_edge_leaves_schlick_alone() {
        assert_eq!(f82_term(Vec3::splat(0.9), Vec3::ONE), Vec3::ZERO);
    }

    #[test]
    fn a_mixture_shares_opacity_and_light() {
        let half = Material { opacity: 0.5, ..matt() };
        let mix = Material { opacity: 0.8, ..Bsdf::Mix { a: 0, b: 1, amount: 0.5 }.into() };
        let materials = [emitter(), half, mix];
        let mut textures = Textures::default();
        let records = pack(&materials, &mut textures).expect("a shallow tree").records;
        // Of the rays that meet it, one third meets the half that is cut out by half.
        assert!((records[2].more.w - 0.8 * 0.75).abs() < 1e-6);
        assert!((records[2].lobe.x - 1.0 / 3.0).abs() < 1e-6);
        let found = emitters(&materials, 2, &records, &mut textures, || 1.0).expect("one shines");
        assert_eq!(found.len(), 1);
        assert!((found[0].radiance.x - 4.0 / 3.0).abs() < 1e-6);
    }

    #[test]
    fn emitters_that_are_alike_have_one_record() {
        let plain = |radiance: f32, two_sided: bool| Emitter {
            radiance: Vec3::splat(radiance),
            two_sided,
            coats: Vec::new(),
            glow: None,
        };
        let (mut records, mut known, mut textures) = (Vec::new(), Known::new(), Textures::default());
        let mut add = |emitters: &[Emitter]| {
            let first = add_emitters(&mut records, &mut known, &mut textures, emitters).expect("no textures");
            (first, records.len())
        };
        assert_eq!(add(&[plain(1.0, false)]), (0, 1));
        assert_eq!(add(&[plain(1.0, false)]), (0, 1));
        assert_eq!(add(&[plain(1.0, true)]), (1, 2));
        assert_eq!(add(&[plain(2.0, false)]), (2, 3));
        // A list is its own, whatever it begins with.
        assert_eq!(add(&[plain(1.0, false), plain(2.0, false)]), (4, 5));
        assert_eq!(add(&[plain(1.0, false), plain(2.0, false)]), (4, 5));
        assert_eq!(add(&[]), (NONE, 5));
    }

    #[test]
    fn a_tree_too_deep_is_refused() {
        let mut materials = vec![matt()];
        for i in 0..MAX_DEPTH as usize {
            materials.push(Bsdf::Mix { a: i, b: i, amount: 0.5 }.into());
        }
        assert_eq!(
            pack(&materials, &mut Textures::default()).err(),
            Some(PackError::Materials { limit: MAX_DEPTH as usize })
        );
    }
}
