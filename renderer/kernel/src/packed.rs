//! The flat arrays that both backends read, laid out as `shaders/scene.wgsl` declares them.

use obvhs::cwbvh::CwBvh;

use crate::generated::{BVH_STACK, Kernel, Light, Material, Params, Primitive, Shape};
use crate::query::{Native, Tree};

/// Samples of one pass: the unit in which samples are summed in f32 on a backend, to be folded in f64 on the host.
pub const PASS_SAMPLES: u32 = 16;

/// A scene ready to be traced.
#[derive(Clone)]
pub struct Packed {
    /// What holds for the whole picture.
    pub params: Params,
    /// The tree over `primitives`, without a node if there are none.
    pub bvh: CwBvh,
    /// The tree over `primitives` that a CPU walks.
    pub tree: Tree,
    /// In the order of the tree's leaves. Not empty: a GPU cannot bind nothing.
    pub primitives: Vec<Primitive>,
    /// Planes first. Not empty.
    pub shapes: Vec<Shape>,
    /// Not empty.
    pub materials: Vec<Material>,
    /// `params.light_count` of them are real. Not empty.
    pub lights: Vec<Light>,
    /// The filter's inverse distribution function, `FILTER_CELLS + 1` offsets in pixels.
    pub tables: Vec<f32>,
}

/// A tree too deep for the walk's stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooDeep {
    /// Levels of the tree.
    pub depth: u32,
}

impl Packed {
    /// Runs `f` with the translated shaders over these arrays.
    pub fn with_kernel<R>(&self, f: impl FnOnce(&Kernel<'_>) -> R) -> R {
        let native = Native::new(&self.tree);
        f(&Kernel {
            params: &self.params,
            nodes: &[],
            primitives: &self.primitives,
            shapes: &self.shapes,
            materials: &self.materials,
            lights: &self.lights,
            tables: &self.tables,
            native: &native,
        })
    }

    /// The tree's nodes as the shaders read them; one empty node where there are none.
    pub fn node_bytes(&self) -> Vec<u8> {
        if self.bvh.nodes.is_empty() {
            return vec![0; size_of::<obvhs::cwbvh::node::CwBvhNode>()];
        }
        bytemuck::cast_slice(&self.bvh.nodes).to_vec()
    }

    /// Checks that both walks can hold the tree's path on their stacks.
    ///
    /// # Errors
    /// The tree is too deep.
    pub fn check_depth(&self) -> Result<(), TooDeep> {
        let mut level: Vec<u32> = if self.bvh.nodes.is_empty() { vec![] } else { vec![0] };
        let mut depth = 0;
        while !level.is_empty() {
            depth += 1;
            if depth >= BVH_STACK {
                return Err(TooDeep { depth });
            }
            level = level
                .iter()
                .flat_map(|&node| {
                    let node = &self.bvh.nodes[node as usize];
                    node.child_base_idx..node.child_base_idx + node.imask.count_ones()
                })
                .collect();
        }
        Ok(())
    }
}
