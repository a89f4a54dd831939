//! Normals and size of a mesh.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use kinora_scene::Mesh;

/// Normals that are the mean of the triangles around a point, weighted by their angles there (Thürmer and Wüthrich,
/// "Computing Vertex Normals from Polygonal Facets", 1998). Vertices in one place share them, so that seams of uv
/// coordinates do not show.
pub(super) fn smooth_normals(mesh: &Mesh) -> Vec<Vec3> {
    // -0 and 0 are one place.
    let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut sums: HashMap<[u32; 3], DVec3> = HashMap::with_capacity(mesh.positions.len());
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| mesh.positions[corner as usize].as_dvec3());
        let Some(normal) = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize() else { continue };
        for i in 0..3 {
            let (a, b) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            let place = key(mesh.positions[triangle[i] as usize]);
            *sums.entry(place).or_default() += normal * a.angle_between(b);
        }
    }
    let of = |p: &Vec3| sums.get(&key(*p)).and_then(|sum| sum.try_normalize()).unwrap_or(DVec3::Y).as_vec3();
    mesh.positions.iter().map(of).collect()
}

/// How many edges belong to an odd number of triangles: 0 where the surface is closed. Vertices in one place are one.
pub(super) fn boundary_edges(mesh: &Mesh) -> usize {
    let key = |corner: u32| {
        let place = mesh.positions.get(corner as usize).copied().unwrap_or_default() + Vec3::ZERO;
        place.to_array().iter().fold(0, |hash, part| mixed(hash ^ u64::from(part.to_bits())))
    };
    let edges = || {
        mesh.triangles.iter().flat_map(|triangle| {
            let [a, b, c] = triangle.map(key);
            [(a, b), (b, c), (c, a)].map(|(a, b)| if a < b { (a, b) } else { (b, a) })
        })
    };
    // Edges that come twice cancel: one look tells of almost every mesh that it is closed.
    if edges().fold(0, |sum, (a, b)| sum ^ if a == b { 0 } else { mixed(a ^ mixed(b)) }) == 0 {
        return 0;
    }
    let mut odd: HashMap<(u64, u64), bool> = HashMap::new();
    for edge in edges().filter(|(a, b)| a != b) {
        let odd = odd.entry(edge).or_default();
        *odd = !*odd;
    }
    odd.values().filter(|odd| **odd).count()
}

/// SplitMix64's last step.
fn mixed(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Replaces normals without length, which some programs write, by computed ones.
pub(super) fn repair_normals(mesh: &mut Mesh) {
    let unit = |normal: &Vec3| (normal.length_squared() - 1.0).abs() < 1e-3;
    if mesh.normals.iter().all(unit) {
        return;
    }
    let computed = smooth_normals(mesh);
    for (normal, computed) in mesh.normals.iter_mut().zip(computed) {
        if !unit(normal) {
            *normal = normal.try_normalize().unwrap_or(computed);
        }
    }
}

/// Centres the mesh's box on the origin, its longest side `length` metres. False if it has no extent.
pub(super) fn fit(mesh: &mut Mesh, length: f64) -> bool {
    let all = || mesh.positions.iter().map(|p| p.as_dvec3());
    let (low, high) = all().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let longest = (high - low).max_element();
    if !(longest > 0.0 && longest.is_finite()) {
        return false;
    }
    let (centre, scale) = ((low + high) * 0.5, length / longest);
    for position in &mut mesh.positions {
        *position = ((position.as_dvec3() - centre) * scale).as_vec3();
    }
    true
}
