//! The two ray queries on the CPU: the twins of `bvh_closest` and `bvh_any` in `shaders/bvh.wgsl`. Nodes are tested by
//! obvhs' SIMD code, primitives by the translated `hit_primitive`.

use glam::{Vec3, Vec3A};
use obvhs::{
    bvh2::Bvh2,
    cwbvh::CwBvh,
    faststack::StackStack,
    ray::{Ray, RayHit},
};

use crate::generated::{FAR, Hit, Kernel, NONE};

/// obvhs ignores boxes that a ray leaves before t = 1e-4. Its node tests get distances in units so small that this is
/// less than an atom for scenes in metres; a power of two, so that scaling is exact.
const NODE_UNITS: f32 = (1u32 << 20) as f32;

/// Levels of a narrow tree: clearing a deeper stack for every ray would cost more than such a tree saves.
pub const NARROW_STACK: usize = 32;

/// What the queries need beside the arrays.
#[derive(Clone, Copy)]
pub struct Native<'a> {
    bvh: &'a CwBvh,
    narrow: Option<&'a Bvh2>,
}

impl<'a> Native<'a> {
    /// Queries over `narrow` if there is one, else over `bvh`.
    pub fn new(bvh: &'a CwBvh, narrow: Option<&'a Bvh2>) -> Self {
        Self { bvh, narrow }
    }
}

fn safe_inverse(d: f32) -> f32 {
    // obvhs takes -0.0 for positive.
    let tiny = if d < 0.0 { -1e-20 } else { 1e-20 };
    NODE_UNITS / if d.abs() < 1e-20 { tiny } else { d }
}

fn node_ray(o: Vec3, d: Vec3, t_max: f32) -> Ray {
    Ray {
        origin: o.into(),
        direction: d.into(),
        inv_direction: Vec3A::new(safe_inverse(d.x), safe_inverse(d.y), safe_inverse(d.z)),
        tmin: 0.0,
        tmax: (t_max * NODE_UNITS).min(f32::MAX),
    }
}

/// The nearest primitive in 0 < t < t_max of a ray that starts on primitive `start`, or NONE.
#[inline]
pub fn bvh_closest(kernel: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> Hit {
    let probe = kernel.probe_along(o, d);
    let ray = node_ray(o, d, t_max);
    let mut best = Hit { t: t_max, id: NONE, ..Hit::default() };
    let mut test = |id: u32| {
        let hit = kernel.hit_primitive(id, probe, best.t, start);
        if hit.id == NONE {
            return f32::INFINITY;
        }
        best = hit;
        hit.t * NODE_UNITS
    };
    if let Some(bvh) = kernel.native.narrow {
        let mut stack = StackStack::<u32, NARROW_STACK>::default();
        bvh.ray_traverse_dynamic(&mut stack, ray, &mut RayHit::none(), |node, ray, _| {
            for i in node.first_index..node.first_index + node.prim_count {
                ray.tmax = ray.tmax.min(test(bvh.primitive_indices[i as usize]));
            }
            true
        });
    } else {
        kernel.native.bvh.ray_traverse(ray, &mut RayHit::none(), |_, id| test(id as u32));
    }
    if best.id == NONE {
        best.t = FAR;
    }
    best
}

/// Whether a primitive lies in 0 < t < t_max of a ray that starts on primitive `start`, or NONE.
#[inline]
pub fn bvh_any(kernel: &Kernel<'_>, o: Vec3, d: Vec3, t_max: f32, start: u32) -> bool {
    let probe = kernel.probe_along(o, d);
    let ray = node_ray(o, d, t_max);
    let test = |id: u32| kernel.hit_primitive(id, probe, t_max, start).id != NONE;
    let Some(bvh) = kernel.native.narrow else {
        return !kernel.native.bvh.ray_traverse_miss(ray, |_, id| if test(id as u32) { 0.0 } else { f32::INFINITY });
    };
    let mut found = false;
    let mut stack = StackStack::<u32, NARROW_STACK>::default();
    bvh.ray_traverse_dynamic(&mut stack, ray, &mut RayHit::none(), |node, _, _| {
        let mut primitives = node.first_index..node.first_index + node.prim_count;
        found = primitives.any(|i| test(bvh.primitive_indices[i as usize]));
        !found
    });
    found
}
