//! The flat arrays that both backends read, laid out as `shaders/scene.wgsl` declares them.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use glam::{UVec4, Vec4};

use crate::albedo;
use crate::generated::{
    BVH_STACK, FEATURE_MATERIAL, FEATURE_OTHER, Kernel, Light, Material, NONE, Params, Primitive, Shape, TABLE_ALBEDO,
};
use crate::query::{Isa, Native, Tree};

/// Samples of one pass: the unit in which samples are summed in f32 on a backend, to be folded in f64 on the host.
pub const PASS_SAMPLES: u32 = 16;

/// What is shared until it is changed.
#[derive(Debug)]
pub struct Shared<T>(Arc<T>);

impl<T> Shared<T> {
    /// Whether both are one and the same, so that nothing in them differs.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// The value itself: a copy where somebody else has it, too.
    pub fn into_inner(self) -> T
    where
        T: Clone,
    {
        Arc::unwrap_or_clone(self.0)
    }
}

impl<T> Clone for Shared<T> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<T> From<T> for Shared<T> {
    fn from(value: T) -> Self {
        Self(Arc::new(value))
    }
}

impl<T> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

/// Makes a copy where somebody else has it, too.
impl<T: Clone> DerefMut for Shared<T> {
    fn deref_mut(&mut self) -> &mut T {
        Arc::make_mut(&mut self.0)
    }
}

/// A scene ready to be traced.
#[derive(Clone)]
pub struct Packed {
    /// What holds for the whole picture.
    pub params: Params,
    /// The tree over `primitives`.
    pub tree: Shared<Tree>,
    /// In the order of the tree's leaves. Not empty: a GPU cannot bind nothing.
    pub primitives: Shared<Vec<Primitive>>,
    /// Planes first. Not empty.
    pub shapes: Shared<Vec<Shape>>,
    /// Not empty.
    pub materials: Shared<Vec<Material>>,
    /// `params.light_count` of them, then `params.distant_count`, are real. Not empty.
    pub lights: Shared<Vec<Light>>,
    /// The filter's inverse distribution function, `FILTER_CELLS + 1` offsets in pixels, and from `TABLE_ALBEDO` on the
    /// albedos of [`crate::albedo::tables`].
    pub tables: Shared<Vec<f32>>,
    /// Texels, and tables of the lights. Not empty.
    pub words: Shared<Vec<u32>>,
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
            tree: Tree::default().into(),
            primitives: vec![Primitive::default()].into(),
            shapes: vec![Shape { index: UVec4::new(0, NONE, NONE, 0), ..Shape::default() }].into(),
            materials: vec![Material { more: Vec4::W, ..Material::default() }].into(),
            lights: vec![Light::default()].into(),
            tables: tables.into(),
            words: vec![0].into(),
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
