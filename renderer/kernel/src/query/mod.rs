//! The two ray queries on the CPU: the twins of `bvh_closest` and `bvh_any` in `shaders/bvh.wgsl`. They walk a tree of
//! their own in lanes of eight, with the best instructions that this CPU has.
//!
//! What they find depends on the primitives alone, not on the tree or the instructions: lanes do what the translated
//! `hit_primitive` does, in its order, boxes are wide enough for rounding, and of two hits at exactly one distance the
//! lower index wins.

mod branch;
mod build;
mod compressed;
mod lanes;
mod ray;
mod shapes;
mod sweep;
mod tree;
pub mod walk;

use glam::Vec3;

use crate::generated::{Hit, Kernel};

pub use branch::{Plan, Start};
pub use build::{Bounds, build};
pub use compressed::Compressed;
pub use lanes::{BATCH, Isa};
pub use ray::{Hits, Rays};
pub use tree::{Part, Tree};

/// What the queries need beside the arrays.
#[derive(Clone, Copy)]
pub struct Native<'a> {
    tree: &'a Tree,
    isa: Isa,
}

impl<'a> Native<'a> {
    /// Queries over `tree` with the instructions of `isa`, or the plain ones where this CPU lacks them.
    pub fn new(tree: &'a Tree, isa: Isa) -> Self {
        Self { tree, isa: if isa.is_there() { isa } else { Isa::Portable } }
    }
}

macro_rules! compiled {
    ($isa:ident, $eight:ident, $widest:ident, $features:literal) => {
        mod $isa {
            use super::*;

            #[target_feature(enable = $features)]
            pub fn one<const ANY: bool>(kernel: &Kernel<'_>, o: [f32; 3], d: [f32; 3], t_max: f32, start: u32) -> Hit {
                walk::one::<lanes::$eight, ANY>(kernel, o, d, t_max, start)
            }

            #[target_feature(enable = $features)]
            pub fn many<const ANY: bool, const PARTS: bool>(
                kernel: &Kernel<'_>,
                rays: &Rays,
                active: u32,
                hits: &mut Hits,
            ) -> u32 {
                walk::many::<lanes::$eight, lanes::$widest, ANY, PARTS>(kernel, rays, active, hits)
            }

            #[target_feature(enable = $features)]
            pub fn sweep<const ANY: bool>(kernel: &Kernel<'_>, rays: &Rays, active: u32, hits: &mut Hits) -> u32 {
                sweep::many::<lanes::$widest, ANY>(kernel, rays, active, hits)
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
compiled!(avx2, Avx2, Avx2, "avx2,fma,bmi1,bmi2,lzcnt,popcnt");
#[cfg(target_arch = "x86_64")]
compiled!(avx512, Avx512, Avx512x16, "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl");

#[inline]
#[allow(unsafe_code)]
fn one<const ANY: bool>(kernel: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> Hit {
    let (o, d) = (o.to_array(), d.to_array());
    match kernel.native.isa {
        Isa::Portable => walk::one::<lanes::Portable, ANY>(kernel, o, d, t_max, start),
        // SAFETY: `Native::new` saw that the CPU has them.
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => unsafe { avx2::one::<ANY>(kernel, o, d, t_max, start) },
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => unsafe { avx512::one::<ANY>(kernel, o, d, t_max, start) },
    }
}

#[inline]
#[allow(unsafe_code)]
fn many<const ANY: bool>(kernel: &Kernel<'_>, rays: &Rays, active: u32, hits: &mut Hits) -> u32 {
    let Native { tree, isa } = *kernel.native;
    // Where there are no instances, what they need is not in the walk's way.
    match (isa, tree.has_few(), tree.parts.is_empty()) {
        (Isa::Portable, false, _) => {
            walk::many::<lanes::Portable, lanes::Portable, ANY, true>(kernel, rays, active, hits)
        }
        (Isa::Portable, true, _) => sweep::many::<lanes::Portable, ANY>(kernel, rays, active, hits),
        // SAFETY: `Native::new` saw that the CPU has them.
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx2, false, true) => unsafe { avx2::many::<ANY, false>(kernel, rays, active, hits) },
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx2, false, false) => unsafe { avx2::many::<ANY, true>(kernel, rays, active, hits) },
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx2, true, _) => unsafe { avx2::sweep::<ANY>(kernel, rays, active, hits) },
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx512, false, true) => unsafe { avx512::many::<ANY, false>(kernel, rays, active, hits) },
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx512, false, false) => unsafe { avx512::many::<ANY, true>(kernel, rays, active, hits) },
        #[cfg(target_arch = "x86_64")]
        (Isa::Avx512, true, _) => unsafe { avx512::sweep::<ANY>(kernel, rays, active, hits) },
    }
}

/// The nearest primitive in 0 < t < t_max of a ray that starts on primitive `start`, or NONE.
#[inline]
pub fn bvh_closest(kernel: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> Hit {
    one::<false>(kernel, o, d, t_max, start)
}

/// Whether a primitive lies in 0 < t < t_max of a ray that starts on primitive `start`, or NONE.
#[inline]
pub fn bvh_any(kernel: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> bool {
    one::<true>(kernel, o, d, t_max, start).id != crate::generated::NONE
}

/// [`bvh_closest`] of the rays whose bits are set in `active`. The other rays may be anything; their hits are not
/// changed, nor are those of rays that hit nothing: let `hits` be [`Hits::default`]. Gives the mask of the rays that hit.
pub fn bvh_closest_many(kernel: &Kernel<'_>, rays: &Rays, active: u32, hits: &mut Hits) -> u32 {
    many::<false>(kernel, rays, active, hits)
}

/// [`bvh_any`] of the rays whose bits are set in `active`: the mask of those that hit something.
pub fn bvh_any_many(kernel: &Kernel<'_>, rays: &Rays, active: u32) -> u32 {
    many::<true>(kernel, rays, active, &mut Hits::default())
}
