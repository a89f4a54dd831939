//! Which media the eye is in: the boundaries that a ray from it leaves without having entered them.

use std::collections::HashSet;

use glam::{UVec4, Vec3};
use kinora_kernel::Packed;
use kinora_kernel::generated::{
    DIELECTRIC_THIN, Kernel, MATERIAL_DIELECTRIC, MATERIAL_GLOSSY, MATERIAL_MIX, MATERIAL_SHEEN, Material, NONE,
};

/// Boundaries of one ray.
const MAX_BOUNDARIES: usize = 10_000;
/// Directions that no scene is likely to be aligned with.
const DIRECTIONS: [Vec3; 3] =
    [Vec3::new(0.43, 0.81, 0.29), Vec3::new(-0.61, 0.35, 0.73), Vec3::new(0.17, -0.53, -0.83)];

/// The media around `eye`, as `Params::media`.
pub fn media_around(packed: &Packed, eye: Vec3) -> UVec4 {
    if !packed.materials.iter().any(is_medium) {
        return UVec4::splat(NONE);
    }
    packed.with_kernel(|kernel| {
        let [a, b, c] = DIRECTIONS.map(|d| media_along(kernel, eye, d.normalize()));
        // A ray through a gap of a mesh is outvoted.
        if b == c { b } else { a }
    })
}

fn is_medium(material: &Material) -> bool {
    material.kind.x == MATERIAL_DIELECTRIC && material.kind.y & DIELECTRIC_THIN == 0
}

// The medium beneath a surface of this material: the first of its tree.
fn medium_of(kernel: &Kernel<'_>, material: u32) -> Option<u32> {
    let mut open = vec![material];
    let mut seen = HashSet::new();
    while let Some(index) = open.pop() {
        if !seen.insert(index) {
            continue;
        }
        let record = kernel.materials.get(index as usize)?;
        match record.kind.x {
            MATERIAL_MIX => open.extend([record.kind.w, record.kind.z]),
            MATERIAL_GLOSSY | MATERIAL_SHEEN => open.push(record.kind.z),
            _ if is_medium(record) => return Some(index),
            _ => {}
        }
    }
    None
}

fn media_along(kernel: &Kernel<'_>, eye: Vec3, d: Vec3) -> UVec4 {
    let mut around = Vec::new();
    let mut entered: Vec<u32> = Vec::new();
    let (mut o, mut start) = (eye, NONE);
    for _ in 0..MAX_BOUNDARIES {
        let hit = kernel.closest_hit(o, d, start);
        if hit.id == NONE {
            break;
        }
        let surface = kernel.surface_at(hit, o, d);
        let leaves = surface.ng.dot(d) > 0.0;
        if let Some(medium) = medium_of(kernel, kernel.shapes[surface.shape as usize].index.x) {
            if !leaves {
                entered.push(medium);
            } else if let Some(i) = entered.iter().rposition(|&m| m == medium) {
                entered.remove(i);
            } else {
                around.push(medium);
            }
        }
        o = kernel.offset_point(surface, if leaves { surface.ng } else { -surface.ng });
        start = hit.id;
    }
    // What is left first was entered last.
    around.resize(4, NONE);
    UVec4::new(around[0], around[1], around[2], around[3])
}
