//! The flat arrays that both backends read, laid out as `shaders/scene.wgsl` declares them.

use glam::{UVec4, Vec4};

use crate::albedo;
use crate::generated::{
    BVH_STACK, FEATURE_MATERIAL, FEATURE_OTHER, Kernel, Light, Material, NONE, Params, Primitive, Shape, TABLE_ALBEDO,
};
use crate::query::{Isa, Native, Tree};

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
    /// `params.light_count` of them, then `params.distant_count`, are real. Not empty.
    pub lights: Vec<Light>,
    /// The filter's inverse distribution function, `FILTER_CELLS + 1` offsets in pixels, and from `TABLE_ALBEDO` on the
    /// albedos of [`crate::albedo::tables`].
    pub tables: Vec<f32>,
    /// Texels, and tables of the lights. Not empty.
    pub words: Vec<u32>,
}

/// A tree too deep for the walk's stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooDeep {
    /// Levels of the tree.
    pub depth: u32,
}

impl Packed {
    /// A scene with nothing in it: every array as short as it may be, and a filter that is a point.
    pub fn empty() -> Self {
        let mut tables = vec![0.0; TABLE_ALBEDO as usize];
        tables.extend_from_slice(albedo::tables());
        Self {
            params: Params {
                clamp: f32::MAX,
                light_chance: -1.0,
                media: UVec4::splat(NONE),
                features: (FEATURE_MATERIAL * 0xff) | FEATURE_OTHER,
                ..Params::default()
            },
            tree: Tree::default(),
            primitives: vec![Primitive::default()],
            shapes: vec![Shape { index: UVec4::new(0, NONE, NONE, 0), ..Shape::default() }],
            materials: vec![Material { more: Vec4::W, ..Material::default() }],
            lights: vec![Light::default()],
            tables,
            words: vec![0],
        }
    }

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
            words: &self.words,
            native: &native,
        })
    }

    /// Checks that the walk can hold the tree's path on its stack.
    ///
    /// # Errors
    /// The tree is too deep.
    pub fn check_depth(&self) -> Result<(), TooDeep> {
        let depth = self.tree.levels(BVH_STACK);
        if depth >= BVH_STACK { Err(TooDeep { depth }) } else { Ok(()) }
    }
}
