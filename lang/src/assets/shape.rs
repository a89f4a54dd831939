//! Triangles, normals and size of a mesh.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};
use kinora_scene::Mesh;

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

/// Corners of a polygon that is cut into triangles by its shape; larger ones, which no program writes, are taken as convex.
const MOST_CORNERS: usize = 1000;

/// Appends the triangles of a polygon, which need not be convex: ears are cut off one by one (Meisters, "Polygons Have
/// Ears", 1975). All corners must be positions.
pub(super) fn add_polygon(positions: &[Vec3], corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let at = |i: usize| positions[corners[i] as usize].as_dvec3();
    let count = corners.len();
    let fan = |triangles: &mut Vec<[u32; 3]>| {
        if let [first, rest @ ..] = corners {
            triangles.extend(rest.windows(2).map(|pair| [*first, pair[0], pair[1]]));
        }
    };
    if !(4..=MOST_CORNERS).contains(&count) {
        return fan(triangles);
    }
    // Newell's normal, and the plane in which the polygon is largest.
    let normal: DVec3 = (0..count).map(|i| at(i).cross(at((i + 1) % count))).sum();
    let sizes = normal.abs();
    let flat = |p: DVec3| {
        if sizes.x >= sizes.y && sizes.x >= sizes.z {
            DVec2::new(p.y, p.z) * DVec2::new(1.0, normal.x.signum())
        } else if sizes.y >= sizes.z {
            DVec2::new(p.z, p.x) * DVec2::new(1.0, normal.y.signum())
        } else {
            DVec2::new(p.x, p.y) * DVec2::new(1.0, normal.z.signum())
        }
    };
    let points: Vec<DVec2> = (0..count).map(|i| flat(at(i))).collect();
    let turn = |a: usize, b: usize, c: usize| (points[b] - points[a]).perp_dot(points[c] - points[b]);
    if (0..count).all(|i| turn(i, (i + 1) % count, (i + 2) % count) >= 0.0) {
        return fan(triangles);
    }
    let mut left: Vec<usize> = (0..count).collect();
    while left.len() > 3 {
        let size = left.len();
        let around = |i: usize| [left[(i + size - 1) % size], left[i], left[(i + 1) % size]];
        let is_ear = |&i: &usize| {
            let [a, b, c] = around(i);
            let inside = |p: usize| {
                let [u, v, w] = [[a, b], [b, c], [c, a]].map(|[from, to]| turn(from, to, p));
                let same = [a, b, c].into_iter().any(|corner| points[corner] == points[p]);
                !same && u >= 0.0 && v >= 0.0 && w >= 0.0
            };
            turn(a, b, c) > 0.0 && !left.iter().any(|&p| inside(p))
        };
        // Where a polygon meets itself there may be none.
        let ear = (0..size).find(is_ear).unwrap_or(0);
        triangles.push(around(ear).map(|i| corners[i]));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]].map(|i| corners[i]));
}

/// The part of a mesh that these triangles are, with the vertices that they have.
pub(super) fn part(mesh: &Mesh, triangles: &[[u32; 3]], name: &str) -> Mesh {
    let mut new = vec![u32::MAX; mesh.positions.len()];
    let mut old: Vec<usize> = Vec::new();
    let mut made = Mesh { name: name.to_string(), ..Mesh::default() };
    for triangle in triangles {
        made.triangles.push(triangle.map(|corner| {
            let slot = &mut new[corner as usize];
            if *slot == u32::MAX {
                *slot = old.len() as u32;
                old.push(corner as usize);
            }
            *slot
        }));
    }
    fn pick<T: Copy>(from: &[T], old: &[usize]) -> Vec<T> {
        old.iter().filter_map(|&i| from.get(i).copied()).collect()
    }
    made.positions = pick(&mesh.positions, &old);
    made.normals = pick(&mesh.normals, &old);
    made.uvs = pick(&mesh.uvs, &old);
    made.more_uvs = pick(&mesh.more_uvs, &old);
    made.colors = pick(&mesh.colors, &old);
    made.tangents = pick(&mesh.tangents, &old);
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_is_cut_inside_of_itself() {
        // An arrow head that points to the left, in each of the planes, from both sides.
        let points = [[0.0, 0.0], [4.0, -2.0], [1.0, 0.0], [4.0, 2.0]];
        let area = |p: &[Vec3], t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| p[i as usize]);
            0.5 * (b - a).cross(c - a)
        };
        for axis in 0..3 {
            let place = |[x, y]: [f32; 2]| {
                let mut p = [x, y, 0.5];
                p.rotate_right(axis);
                Vec3::from_array(p)
            };
            let positions: Vec<Vec3> = points.iter().map(|p| place(*p)).collect();
            for corners in [[0, 1, 2, 3], [3, 2, 1, 0], [1, 2, 3, 0]] {
                let mut triangles = Vec::new();
                add_polygon(&positions, &corners, &mut triangles);
                let areas: Vec<Vec3> = triangles.iter().map(|t| area(&positions, t)).collect();
                let (sum, sizes) = (areas.iter().sum::<Vec3>(), areas.iter().map(|a| a.length()).sum::<f32>());
                assert!((sum.length() - 2.0).abs() < 1e-6 && (sizes - 2.0).abs() < 1e-6, "{triangles:?}");
            }
        }
    }
}
