//! The scene's geometry as `shaders/bvh.wgsl` walks it: obvhs' compressed wide tree (Ylitie, Karras and Laine, "Efficient
//! Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017), and the primitives in the order of its
//! leaves. A CPU never needs it, so it is made when it is asked for.

use glam::Vec3;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb};

use super::build::Bounds;
use crate::generated::{BVH_STACK, PRIMITIVE_KIND, PRIMITIVE_OTHER, PRIMITIVE_SPHERE, Primitive, Shape};
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
            return Ok(Compressed { bvh: CwBvh::default(), primitives: self.primitives.clone() });
        };
        let bounds: Vec<Bounds> = primitives.iter().map(|p| bounds_of(p, &self.shapes, self.tree.reach)).collect();
        let config = match count <= MAX_TUNED {
            true => BvhBuildParams::very_slow_build(),
            false => BvhBuildParams::fast_build(),
        };
        let bvh = build_cwbvh(&bounds, config, &mut std::time::Duration::default());
        let reordered = bvh.primitive_indices.iter().filter_map(|&i| primitives.get(i as usize).copied()).collect();
        let compressed = Compressed { bvh, primitives: reordered };
        compressed.check_depth()?;
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

    fn check_depth(&self) -> Result<(), TooDeep> {
        let mut level = vec![0_u32];
        let mut depth = 0;
        while !level.is_empty() {
            depth += 1;
            if depth >= BVH_STACK {
                return Err(TooDeep { depth });
            }
            level = level
                .iter()
                .filter_map(|&node| self.bvh.nodes.get(node as usize))
                .flat_map(|node| node.child_base_idx..node.child_base_idx + node.imask.count_ones())
                .collect();
        }
        Ok(())
    }
}

/// The box of a primitive, wide enough for rounding where the largest coordinate is `reach`.
fn bounds_of(primitive: &Primitive, shapes: &[Shape], reach: f32) -> Bounds {
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
        return Bounds::of_other(primitive, rows.map(|row| row.as_dvec4())).padded(reach);
    }
    let rows = [primitive.x, primitive.y, primitive.z];
    let (low, high) = (rows.map(|row| row.min_element()), rows.map(|row| row.max_element()));
    Bounds { low: Vec3::from_array(low), high: Vec3::from_array(high) }.padded(reach)
}
