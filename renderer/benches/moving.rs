//! Whether a tree that is refitted would beat a new one where a mesh bends: a column of triangles that is twisted, its old
//! tree with new boxes beside a tree of its own. Both are obvhs' binary trees, so that only the tree's fit differs.

use std::time::{Duration, Instant};

use glam::{Quat, Vec3, Vec3A};
use kinora_kernel::Primitive;
use kinora_kernel::query::{self, Bounds};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, builder::build_bvh2};
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

/// Triangles round the column, and along it.
const AROUND: u32 = 500;
const RAYS: u32 = 400_000;

fn column(along: u32, turn: f32) -> Vec<Triangle> {
    let corner = |i: u32, k: u32| {
        let (angle, y) = (std::f32::consts::TAU * i as f32 / AROUND as f32, k as f32 / along as f32 * 4.0 - 2.0);
        let radius = 0.5 + 0.1 * (7.0 * angle).sin() + 0.05 * (9.0 * y).sin();
        Quat::from_rotation_y(turn * y) * Vec3::new(radius * angle.cos(), y, radius * angle.sin())
    };
    let cells = (0..along).flat_map(|k| (0..AROUND).map(move |i| (i, k)));
    let halves = cells.flat_map(|(i, k)| {
        let [a, b, c, d] = [corner(i, k), corner(i + 1, k), corner(i + 1, k + 1), corner(i, k + 1)];
        [[a, b, c], [a, c, d]]
    });
    halves.map(|[a, b, c]| Triangle { v0: a.into(), v1: b.into(), v2: c.into() }).collect()
}

/// The best of three, in seconds.
fn timed<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let start = Instant::now();
        let made = work();
        (start.elapsed().as_secs_f64(), made)
    };
    let all = [once(), once(), once()];
    let least = all.iter().map(|(seconds, _)| *seconds).fold(f64::INFINITY, f64::min);
    let [.., (_, last)] = all;
    (least, last)
}

fn new_tree(triangles: &[Triangle]) -> Bvh2 {
    build_bvh2(triangles, BvhBuildParams::fast_build(), &mut Duration::default())
}

fn refit(tree: &mut Bvh2, triangles: &[Triangle]) {
    for node in tree.nodes.iter_mut().filter(|node| node.is_leaf()) {
        let own = &tree.primitive_indices[node.first_index as usize..][..node.prim_count as usize];
        let boxes = own.iter().map(|i| triangles[*i as usize].aabb());
        node.set_aabb(boxes.fold(Aabb::empty(), |all, one| all.union(&one)));
    }
    tree.refit_all();
}

/// Nanoseconds a ray, between points of a ball about the column; and the sum of distances, so that both see the same.
fn traced(tree: &Bvh2, triangles: &[Triangle]) -> (f64, f64) {
    let point = |i: u32| {
        let unit = |salt: u32| {
            let mut h = i.wrapping_mul(0x9e37_79b1) ^ salt.wrapping_mul(0x85eb_ca77);
            h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
            h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
            (h ^ (h >> 15)) as f32 / u32::MAX as f32
        };
        let (z, angle) = (2.0 * unit(1) - 1.0, std::f32::consts::TAU * unit(2));
        let across = (1.0 - z * z).sqrt();
        Vec3A::new(across * angle.cos(), z, across * angle.sin()) * 2.5
    };
    let (seconds, sum) = timed(|| {
        (0..RAYS).fold(0.0, |sum, i| {
            let (from, to) = (point(2 * i), point(2 * i + 1));
            let ray = Ray::new_inf(from, (to - from).normalize());
            let mut hit = RayHit::none();
            tree.ray_traverse(ray, &mut hit, |ray, id| triangles[tree.primitive_indices[id] as usize].intersect(ray));
            sum + if hit.t.is_finite() && hit.t < 100.0 { f64::from(hit.t) } else { 0.0 }
        })
    });
    (seconds * 1e9 / f64::from(RAYS), sum)
}

fn own_tree(triangles: &[Triangle]) -> f64 {
    let bounds: Vec<Bounds> = triangles
        .iter()
        .map(|triangle| {
            let around = triangle.aabb();
            Bounds { low: around.min.into(), high: around.max.into() }
        })
        .collect();
    let primitives = vec![Primitive::default(); triangles.len()];
    timed(|| query::build(&mut primitives.clone(), &bounds, &[])).0
}

fn main() {
    println!("| triangles | twisted by | refit s | new s | Kinora's s | ns a ray: refitted | new |");
    println!("| --- | --- | --- | --- | --- | --- | --- |");
    for along in [10, 100, 1000] {
        let still = column(along, 0.0);
        for degrees in [5.0_f32, 45.0, 180.0, 720.0] {
            // From one end to the other, which are 4 m apart.
            let bent = column(along, degrees.to_radians() / 4.0);
            let mut tree = new_tree(&still);
            let (refit_s, ()) = timed(|| refit(&mut tree, &bent));
            let (new_s, new) = timed(|| new_tree(&bent));
            let own_s = own_tree(&bent);
            let ((refitted_ns, a), (new_ns, b)) = (traced(&tree, &bent), traced(&new, &bent));
            assert!((a - b).abs() <= 1e-3 * b, "{a} {b}");
            println!(
                "| {} | {degrees}° | {refit_s:.4} | {new_s:.4} | {own_s:.4} | {refitted_ns:.0} | {new_ns:.0} |",
                bent.len()
            );
        }
    }
}
