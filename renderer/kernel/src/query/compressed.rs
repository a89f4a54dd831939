//! The scene's geometry as `shaders/bvh.wgsl` walks it: obvhs' compressed wide tree (Ylitie, Karras and Laine, "Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017), and the primitives in the order of its
//! leaves. A CPU never needs it, so it is made when it is asked for.

use glam::Vec3;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb};

use super::build::Bounds;
use crate::generated::{
    BVH_STACK, OTHER_INSTANCE, PRIMITIVE_KIND, PRIMITIVE_OTHER, PRIMITIVE_SPHERE, Primitive, Shape,
};
use crate::packed::{Packed, TooDeep};

/// A compressed tree with its primitives.
#[derive(Clone)]
pub struct Compressed {
    /// The nodes, of 80 bytes each; none where there are no primitives.
    pub bvh: CwBvh,
    /// Those of the scene, reordered. Not empty.
    pub primitives: Vec<Primitive>,
}

/// Up to here the tree is built with the greatest care, which takes milliseconds.
const MAX_TUNED: usize = 2_000;

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb { min: self.low.into(), max: self.high.into() }
    }
}

impl Packed {
    /// The tree and the primitives as the shaders read them.
    ///
    /// # Errors
    /// The tree is deeper than the shaders' stack.
    pub fn compressed(&self) -> Result<Compressed, TooDeep> {
        let count = self.params.primitive_count as usize;
        let Some(primitives) = self.primitives.get(..count).filter(|primitives| !primitives.is_empty()) else {
            return Ok(Compressed { bvh: CwBvh::default(), primitives: self.primitives.to_vec() });
        };
        let mut compressed =
            Compressed { bvh: CwBvh::default(), primitives: Vec::with_capacity(self.primitives.len()) };
        // First the scene's own tree, whose root is node 0; instances learn where their parts' trees begin.
        let boxes: Vec<Bounds> = self
            .tree
            .parts
            .iter()
            .map(|part| {
                let own = self.primitives.iter().skip(part.first as usize).take(part.count as usize);
                let boxes = own.map(|p| bounds_of(p, &self.shapes, &[], part.reach));
                boxes.reduce(Bounds::join).unwrap_or(Bounds { low: Vec3::ZERO, high: Vec3::ZERO })
            })
            .collect();
        compressed.append(primitives, |p| bounds_of(p, &self.shapes, &boxes, self.tree.reach));
        let mut depth = compressed.depth(0);
        let mut below = 0;
        let mut roots = Vec::with_capacity(self.tree.parts.len());
        for part in &self.tree.parts {
            let own = self.primitives.get(part.first as usize..).and_then(|rest| rest.get(..part.count as usize));
            let root = compressed.bvh.nodes.len() as u32;
            compressed.append(own.unwrap_or_default(), |p| bounds_of(p, &self.shapes, &[], part.reach));
            roots.push(root);
            // On its way into a part a walk may leave two groups behind.
            below = below.max(compressed.depth(root) + 2);
        }
        for primitive in compressed.primitives.iter_mut().take(count).filter(|p| is_instance(p)) {
            primitive.index.y = roots.get(primitive.index.x as usize).copied().unwrap_or_default();
        }
        depth += below;
        if depth >= BVH_STACK {
            return Err(TooDeep { depth });
        }
        Ok(compressed)
    }
}

impl Compressed {
    /// The nodes as the shaders read them; one empty node where there are none.
    pub fn node_bytes(&self) -> Vec<u8> {
        match self.bvh.nodes.is_empty() {
            true => vec![0; size_of::<obvhs::cwbvh::node::CwBvhNode>()],
            false => bytemuck::cast_slice(&self.bvh.nodes).to_vec(),
        }
    }

    // Adds a tree over `primitives`, and them in the order of its leaves.
    fn append(&mut self, primitives: &[Primitive], bounds: impl Fn(&Primitive) -> Bounds) {
        let bounds: Vec<Bounds> = primitives.iter().map(bounds).collect();
        let config = match primitives.len() <= MAX_TUNED {
            true => BvhBuildParams::very_slow_build(),
            false => BvhBuildParams::fast_build(),
        };
        let mut bvh = build_cwbvh(&bounds, config, &mut std::time::Duration::default());
        let (node_base, base) = (self.bvh.nodes.len() as u32, self.primitives.len() as u32);
        self.primitives.extend(bvh.primitive_indices.iter().filter_map(|&i| primitives.get(i as usize).copied()));
        if node_base == 0 {
            self.bvh = bvh;
            return;
        }
        for node in &mut bvh.nodes {
            node.child_base_idx += node_base;
            node.primitive_base_idx += base;
        }
        self.bvh.nodes.append(&mut bvh.nodes);
    }

    // Levels of the tree below node `root`, at most BVH_STACK.
    fn depth(&self, root: u32) -> u32 {
        let mut level = vec![root];
        let mut depth = 0;
        while !level.is_empty() && depth < BVH_STACK {
            depth += 1;
            level = level
                .iter()
                .filter_map(|&node| self.bvh.nodes.get(node as usize))
                .flat_map(|node| node.child_base_idx..node.child_base_idx + node.imask.count_ones())
                .collect();
        }
        depth
    }
}

fn is_instance(primitive: &Primitive) -> bool {
    primitive.shade.w & PRIMITIVE_KIND == PRIMITIVE_OTHER && primitive.index.z == OTHER_INSTANCE
}

/// The box of a primitive, wide enough for rounding where the largest coordinate is `reach`; `parts`: the boxes of what
/// instances are copies of.
fn bounds_of(primitive: &Primitive, shapes: &[Shape], parts: &[Bounds], reach: f32) -> Bounds {
    if primitive.shade.w & PRIMITIVE_KIND == PRIMITIVE_SPHERE {
        let shape = shapes.get((primitive.shade.w & !PRIMITIVE_KIND) as usize).copied().unwrap_or_default();
        let rows = [shape.world_from_object_x, shape.world_from_object_y, shape.world_from_object_z];
        let (centre, half) =
            (Vec3::from_array(rows.map(|r| r.w)), Vec3::from_array(rows.map(|r| r.truncate().length())));
        return Bounds { low: centre - half, high: centre + half }.padded(reach);
    }
    if primitive.shade.w & PRIMITIVE_KIND == PRIMITIVE_OTHER {
        let shape = shapes.get((primitive.shade.w & !PRIMITIVE_KIND) as usize).copied().unwrap_or_default();
        let rows = [shape.world_from_object_x, shape.world_from_object_y, shape.world_from_object_z];
        if is_instance(primitive) {
            let part = parts.get(primitive.index.x as usize).copied();
            let part = part.unwrap_or(Bounds { low: Vec3::ZERO, high: Vec3::ZERO });
            return part.placed(rows.map(|row| row.as_dvec4())).padded(reach);
        }
        return Bounds::of_other(primitive, rows.map(|row| row.as_dvec4())).padded(reach);
    }
    let rows = [primitive.x, primitive.y, primitive.z];
    let (low, high) = (rows.map(|row| row.min_element()), rows.map(|row| row.max_element()));
    Bounds { low: Vec3::from_array(low), high: Vec3::from_array(high) }.padded(reach)
}
