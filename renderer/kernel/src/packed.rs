//! The flat arrays that both backends read, laid out as `shaders/scene.wgsl` declares them.

use crate::generated::{BVH_STACK, Kernel, Light, Material, Params, Primitive, Shape};
use crate::query::{Isa, Native, Tree, compress};

/// Samples of one pass: the unit in which samples are summed in f32 on a backend, to be folded in f64 on the host.
pub const PASS_SAMPLES: u32 = 16;

/// A scene ready to be traced.
#[derive(Clone)]
pub struct Packed {
    /// What holds for the whole picture.
    pub params: Params,
    /// The tree over `primitives`.
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
        self.with_kernel_on(Isa::best(), f)
    }

    /// As [`Packed::with_kernel`], with the ray queries of `isa`.
    pub fn with_kernel_on<R>(&self, isa: Isa, f: impl FnOnce(&Kernel<'_>) -> R) -> R {
        let native = Native::new(&self.tree, isa);
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
        compress(&self.tree, &self.primitives, &self.shapes)
    }

    /// Checks that both walks can hold the tree's path on their stacks.
    ///
    /// # Errors
    /// The tree is too deep.
    pub fn check_depth(&self) -> Result<(), TooDeep> {
        // The shaders' nodes have a level more: that of the leaves.
        let depth = self.tree.levels(BVH_STACK) + 1;
        if depth >= BVH_STACK { Err(TooDeep { depth }) } else { Ok(()) }
    }
}
