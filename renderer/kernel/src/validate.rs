//! Whether packed arrays hold together. The shaders follow their indices without looking, on a GPU too: what is out of
//! range there reads whatever lies behind the array.

use std::collections::HashSet;
use std::fmt;

use crate::albedo;
use crate::generated::{
    FEATURE_BLADES, FEATURE_FISHEYE, FEATURE_LIGHT_TREE, FEATURE_ORTHOGRAPHIC, FEATURE_PANORAMA, FEATURE_SKY_MAP,
    FEATURE_TAPE, FEATURE_TEXTURE, LIGHT_POINT, LIGHT_SKY, LIGHT_SUN, LIGHT_TRIANGLE, MAPS_LIST, MAPS_OPACITY,
    MAPS_SIZE, MATERIAL_EMITTER, MATERIAL_GLOSSY, MATERIAL_MIX, MATERIAL_SHEEN, MESH_SIZE, Material, NONE,
    OTHER_INSTANCE, OTHER_TORUS, PRIMITIVE_KIND, PRIMITIVE_OTHER, PRIMITIVE_TRIANGLE, TABLE_ALBEDO, TAPE_LONGEST,
    TAPE_STEP, TAPE_STEPS, TEXTURE_CHECKER, TEXTURE_KIND, TEXTURE_TAPE, TREE_CHILD, TREE_LIGHT, TREE_TWO_SIDED,
};
use crate::packed::Packed;
use crate::query::Compressed;

/// An index or a count that leads out of its array, or a kind that there is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Invalid {
    /// What holds the number: `nodes`, `primitives`, ….
    pub array: &'static str,
    /// Which element.
    pub index: usize,
    /// What the number says.
    pub what: &'static str,
    /// The number.
    pub value: u64,
    /// It must be below this.
    pub limit: u64,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { array, index, what, value, limit } = self;
        write!(f, "{what} of {array}[{index}] is {value}, and must be below {limit}")
    }
}

impl std::error::Error for Invalid {}

// One element of one array.
#[derive(Clone, Copy)]
struct At(&'static str, usize);

impl At {
    fn below(self, what: &'static str, value: u64, limit: usize) -> Result<(), Invalid> {
        let limit = limit as u64;
        if value < limit { Ok(()) } else { Err(Invalid { array: self.0, index: self.1, what, value, limit }) }
    }

    fn below_or_none(self, what: &'static str, value: u32, limit: usize) -> Result<(), Invalid> {
        if value == NONE { Ok(()) } else { self.below(what, value.into(), limit) }
    }

    // `count` elements from `first`.
    fn range(self, what: &'static str, first: u32, count: u32, len: usize) -> Result<(), Invalid> {
        self.below(what, u64::from(first) + u64::from(count), len + 1)
    }
}

impl Packed {
    /// Checks every number that the shaders use as an index, a count or a kind. The tree's depth is
    /// [`Packed::check_depth`]'s.
    ///
    /// # Errors
    /// The first that is wrong.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.validate_params()?;
        for (i, shape) in self.shapes.iter().enumerate() {
            let at = At("shapes", i);
            at.below("the material", shape.index.x.into(), self.materials.len())?;
            at.below_or_none("the first light", shape.index.y, self.lights.len())?;
            at.below_or_none("the first emitter", shape.index.z, self.materials.len())?;
        }
        self.validate_primitives()?;
        for (i, material) in self.materials.iter().enumerate() {
            self.validate_material(At("materials", i), material)?;
        }
        for (i, light) in self.lights.iter().enumerate() {
            let near = i < self.params.light_count as usize || self.params.distant_count == 0;
            let kinds = if near { LIGHT_SUN } else { LIGHT_SKY + 1 };
            At("lights", i).below("the kind", light.kind.x.into(), kinds as usize)?;
            match light.kind.x {
                LIGHT_TRIANGLE if light.kind.z != 0 => {
                    At("lights", i).range("what its vertices have", light.kind.z, MESH_SIZE, self.words.len())?;
                }
                _ => At("lights", i).below("the kind of shape", light.kind.z.into(), OTHER_TORUS as usize + 1)?,
            }
            At("lights", i).below("the shape", light.kind.y.into(), self.shapes.len())?;
            if light.kind.x < LIGHT_POINT {
                At("lights", i).below("the emitter", light.edge_v.w as u64, self.materials.len())?;
            }
        }
        self.validate_sky()?;
        self.validate_textures()?;
        self.validate_light_tree()
    }

    fn validate_params(&self) -> Result<(), Invalid> {
        let at = At("params", 0);
        at.range("the number of lights", self.params.light_count, self.params.distant_count, self.lights.len())?;
        at.below_or_none("the sky's light", self.params.sky_map.w, self.lights.len())?;
        at.range("the number of planes", 0, self.params.plane_count, self.shapes.len())?;
        at.range("the number of primitives", 0, self.params.primitive_count, self.primitives.len())?;
        for (i, part) in self.tree.parts.iter().enumerate() {
            At("parts", i).range("the last primitive", part.first, part.count, self.primitives.len())?;
        }
        if self.params.features & FEATURE_TEXTURE != 0 && self.params.textures.x != 0 {
            let maps = self.materials.len() as u32 * MAPS_SIZE;
            at.range("the maps of materials", self.params.textures.x, maps, self.words.len())?;
        }
        if self.params.textures.y != 0 {
            let shapes = self.shapes.len() as u32;
            at.range("the places of own spaces", self.params.textures.y, shapes, self.words.len())?;
            let first = self.params.textures.y as usize;
            for (i, &rows) in self.words[first..first + self.shapes.len()].iter().enumerate() {
                At("shapes", i).range("the rows of its own space", rows, 12, self.words.len())?;
            }
        }
        for medium in self.params.media.to_array() {
            at.below_or_none("a medium around the eye", medium, self.materials.len())?;
        }
        self.validate_camera(at)?;
        let tables = TABLE_ALBEDO as usize + albedo::tables().len();
        at.below("the last entry of the tables", tables as u64 - 1, self.tables.len())
    }

    // No index depends on the camera, but what is out of range has no ray.
    fn validate_camera(&self, at: At) -> Result<(), Invalid> {
        let params = &self.params;
        let projections = params.features & (FEATURE_ORTHOGRAPHIC | FEATURE_PANORAMA | FEATURE_FISHEYE);
        at.below("the number of projections", projections.count_ones().into(), 2)?;
        if params.features & FEATURE_BLADES != 0 {
            let corners = params.camera_x.w;
            at.below(
                "a lens without corners",
                u64::from(!(3.0..=65_535.0).contains(&corners) || corners.fract() != 0.0),
                1,
            )?;
            at.below("a lens's first corner, beyond a turn", u64::from(!(0.0..=1.0).contains(&params.camera_y.w)), 1)?;
        }
        if params.features & FEATURE_FISHEYE != 0 {
            let edge = params.camera_z.w;
            at.below("a fisheye's edge, which is no angle", u64::from(!(f32::MIN_POSITIVE..=0.5).contains(&edge)), 1)?;
        }
        Ok(())
    }

    // What `kind` refers to; walks down a tree of materials count their steps, that along emitters ends by itself.
    fn validate_material(&self, at: At, material: &Material) -> Result<(), Invalid> {
        let count = self.materials.len();
        let [kind, _, z, w] = material.kind.to_array();
        at.below("the kind", kind.into(), MATERIAL_SHEEN as usize + 1)?;
        match kind {
            MATERIAL_GLOSSY => {
                at.below("the material beneath", z.into(), count)?;
                at.below_or_none("the metal mixed in", w, count)
            }
            MATERIAL_SHEEN => at.below("the material beneath", z.into(), count),
            MATERIAL_MIX => {
                at.below("the first part", z.into(), count)?;
                at.below("the second part", w.into(), count)
            }
            MATERIAL_EMITTER => {
                at.below_or_none("the coat", z, count)?;
                // The one linked last stands first, so that no walk goes in circles.
                at.below_or_none("the next emitter", w, at.1)
            }
            _ => Ok(()),
        }
    }

    fn validate_sky(&self) -> Result<(), Invalid> {
        if self.params.features & FEATURE_SKY_MAP == 0 {
            return Ok(());
        }
        let at = At("params", 0);
        let [first, width, height, _] = self.params.sky_map.to_array().map(u64::from);
        at.below("the sky's last texel", (first + 3 * width * height).max(1) - 1, self.words.len())?;
        at.below("a sky without texels", u64::from(width * height == 0), 1)?;
        let [first, columns, rows, _] = self.params.sky_cells.to_array().map(u64::from);
        for count in [columns, rows] {
            at.below("the sky's cells, which make no tree", u64::from(!count.is_power_of_two()), 1)?;
        }
        at.below("the sky's last sum", first + 2 * rows + 2 * rows * columns - 1, self.words.len())
    }

    // Of the textures that the maps of materials lead to: what the shaders read of tapes, and where they go on from there.
    fn validate_textures(&self) -> Result<(), Invalid> {
        if self.params.features & FEATURE_TAPE == 0 || self.params.textures.x == 0 {
            return Ok(());
        }
        let word = |i: usize, what: &'static str| {
            At("words", i).below(what, i as u64, self.words.len())?;
            Ok(self.words[i] as usize)
        };
        let mut open = Vec::new();
        for material in 0..self.materials.len() {
            let maps = self.params.textures.x as usize + material * MAPS_SIZE as usize;
            let list = word(maps + MAPS_LIST as usize, "the list of maps")?;
            if list != 0 {
                for i in 0..word(list, "the number of maps")? {
                    open.push(word(list + 2 + 2 * i, "the texture of a map")?);
                }
            }
            let mut at = word(maps + MAPS_OPACITY as usize, "the terms of opacity")?;
            if at != 0 {
                let terms = word(at, "the number of terms")?;
                at += 1;
                for _ in 0..terms {
                    let factors = word(at, "the number of factors")?;
                    at += 1;
                    for _ in 0..factors {
                        let textures = word(at + 2, "the number of textures")? >> 1;
                        for i in 0..textures {
                            open.push(word(at + 3 + i, "the texture of a factor")?);
                        }
                        at += 3 + textures;
                    }
                }
            }
        }
        let mut seen = HashSet::new();
        while let Some(texture) = open.pop() {
            if !seen.insert(texture) {
                continue;
            }
            match word(texture, "a texture")? as u32 & TEXTURE_KIND {
                TEXTURE_CHECKER => {
                    open.extend([word(texture + 1, "a checker")?, word(texture + 2, "a checker")?]);
                }
                TEXTURE_TAPE => {
                    let steps = word(texture + 1, "the steps of a tape")?;
                    let at = At("words", texture);
                    at.below("the number of steps", steps as u64, TAPE_LONGEST as usize + 1)?;
                    let count = TAPE_STEPS + TAPE_STEP * steps as u32;
                    at.range("the last step of a tape", texture as u32, count, self.words.len())?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn validate_light_tree(&self) -> Result<(), Invalid> {
        if self.params.features & FEATURE_LIGHT_TREE == 0 {
            return Ok(());
        }
        // Children come after their parents, so that no walk goes in circles; it counts its steps besides.
        let (child, pair) = (TREE_CHILD as usize, 2 * TREE_CHILD as usize);
        let mut open = vec![self.params.light_tree as usize];
        while let Some(first) = open.pop() {
            At("words", first).below("the end of a pair", (first + pair) as u64, self.words.len() + 1)?;
            for at in [first, first + child] {
                let word = self.words[at + child - 1];
                let index = word & !(TREE_LIGHT | TREE_TWO_SIDED);
                if word & TREE_LIGHT != 0 {
                    At("words", at).below("the light", index.into(), self.params.light_count as usize)?;
                } else {
                    At("words", at).below("its place", at as u64, index as usize)?;
                    open.push(index as usize);
                }
            }
        }
        Ok(())
    }

    fn validate_primitives(&self) -> Result<(), Invalid> {
        for (i, primitive) in self.primitives.iter().enumerate() {
            let at = At("primitives", i);
            let (kind, shape) = (primitive.shade.w & PRIMITIVE_KIND, primitive.shade.w & !PRIMITIVE_KIND);
            if kind == PRIMITIVE_TRIANGLE && primitive.index.y != 0 {
                at.range("what its vertices have", primitive.index.y, MESH_SIZE, self.words.len())?;
            }
            if kind == PRIMITIVE_OTHER {
                at.below("the kind", primitive.index.z.into(), OTHER_INSTANCE as usize + 1)?;
                if primitive.index.z == OTHER_INSTANCE {
                    at.below("the part", primitive.index.x.into(), self.tree.parts.len())?;
                    // Parts have no instances of their own.
                    at.below("its own place", i as u64, self.params.primitive_count as usize)?;
                }
            }
            at.below("the shape", shape.into(), self.shapes.len())?;
            let Some(shape) = self.shapes.get(shape as usize) else { continue };
            if shape.index.y != NONE {
                let light = u64::from(shape.index.y) + u64::from(primitive.index.x);
                at.below("the light", light, self.lights.len())?;
            }
        }
        Ok(())
    }
}

impl Compressed {
    /// Checks every number of the nodes that the shaders use as an index or a count.
    ///
    /// # Errors
    /// The first that is wrong.
    pub fn validate(&self) -> Result<(), Invalid> {
        let nodes = self.bvh.nodes.len();
        for (i, node) in self.bvh.nodes.iter().enumerate() {
            let at = At("nodes", i);
            if node.imask != 0 {
                at.range("the last child", node.child_base_idx, node.imask.count_ones(), nodes)?;
                // Children come after their parents, so that no walk goes in circles.
                at.below("its index", i as u64, node.child_base_idx as usize)?;
            }
            for (slot, &meta) in node.child_meta.iter().enumerate() {
                let (offset, count) = (u32::from(meta & 0x1f), u32::from(meta >> 5).count_ones());
                if node.imask & (1 << slot) != 0 {
                    at.below("the slot of a child", u64::from(offset).abs_diff(24 + slot as u64), 1)?;
                } else if count != 0 {
                    let first = u64::from(node.primitive_base_idx) + u64::from(offset);
                    let end = first + u64::from(count);
                    at.below("the last primitive", end, self.primitives.len() + 1)?;
                    at.below("the offset of a leaf", u64::from(offset + count), 25)?;
                }
            }
        }
        Ok(())
    }
}
