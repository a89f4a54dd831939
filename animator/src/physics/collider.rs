//! What bodies collide with: a primitive where the shape is one, hulls of convex parts of everything else.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use kinora_scene::{Collider, Mesh, Shape, Still, corners};
use rapier3d::parry::transformation::vhacd::VHACDParameters;
use rapier3d::prelude::{Pose, SharedShape, TriMeshFlags, Vector};

use super::convert::{double, pose, single};
use super::plan::{Planned, PlannedPart, dynamic};

/// Flat shapes are as thick as this where forces move them, in metres: without any volume they would have no mass.
const SHEET_M: f64 = 1e-3;

/// And so where they do not, so that what lies on them lies on their surface.
const THIN_M: f64 = 1e-4;

/// Axes may be off a right angle, and scales from one another, by so much before that counts.
const SLACK: f64 = 1e-6;

/// A mesh that leaves less than this of its hull empty is as good as convex.
const EMPTY: f64 = 0.03;

/// A collider, placed in its body's pose.
pub type Placed = (Pose, SharedShape);

/// The colliders of a body.
///
/// # Errors
/// Why it has none, in one clause.
pub fn colliders(planned: &Planned<'_>) -> Result<Vec<Placed>, &'static str> {
    let moves = dynamic(planned.body);
    if moves && planned.parts.iter().any(PlannedPart::is_plane) {
        return Err("an infinite `plane` is in it");
    }
    let found = match planned.body.collider {
        Collider::Auto => {
            let mut found = Vec::new();
            for part in &planned.parts {
                automatic(part, moves, &mut found)?;
            }
            found
        }
        Collider::Mesh => planned.parts.iter().map(mesh).collect::<Result<_, _>>()?,
        other => {
            if planned.parts.iter().any(PlannedPart::is_plane) {
                return Err("an infinite `plane` is in it");
            }
            vec![about(&planned.parts, other)?]
        }
    };
    if moves && !found.iter().any(|(_, shape)| shape.mass_properties(1.0).mass() > 0.0) {
        return Err("it has no volume");
    }
    Ok(found)
}

/// Its rotation in the body, with the scale that is left along its own axes, that along x negative where it is reflected;
/// none where it is sheared.
fn straight(place: DAffine3) -> Option<(DQuat, DVec3)> {
    let scale = DVec3::new(place.matrix3.x_axis.length(), place.matrix3.y_axis.length(), place.matrix3.z_axis.length());
    let [x, y, z] = [place.matrix3.x_axis / scale.x, place.matrix3.y_axis / scale.y, place.matrix3.z_axis / scale.z];
    if [x.dot(y), y.dot(z), z.dot(x)].into_iter().any(|cosine| cosine.abs() > SLACK) {
        return None;
    }
    let mirrored = DVec3::new(x.dot(y.cross(z)).signum(), 1.0, 1.0);
    Some((DQuat::from_mat3(&DMat3::from_cols(y.cross(z), y, z)).normalize(), scale * mirrored))
}

fn alike(a: f64, b: f64) -> bool {
    (a - b).abs() <= SLACK * a.max(b)
}

fn automatic(part: &PlannedPart, moves: bool, found: &mut Vec<Placed>) -> Result<(), &'static str> {
    let place = part.pose_from_shape;
    if let Shape::Plane { frame } = &part.shape {
        let normal = place.matrix3.inverse().transpose() * frame.z;
        let normal = single(normal.try_normalize().ok_or("a plane in it is flattened")?);
        found.push((Pose::from_translation(single(place.translation)), SharedShape::halfspace(normal)));
        return Ok(());
    }
    let open = matches!(part.shape, Shape::Cylinder { capped: false, .. } | Shape::Cone { capped: false, .. });
    if open && !moves {
        // A tube: what is put into it stays in it.
        found.push(mesh(part)?);
        return Ok(());
    }
    if let Some(primitive) = straight(place).and_then(|(rotation, scale)| primitive(part, rotation, scale, moves)) {
        found.push(primitive);
        return Ok(());
    }
    match &part.shape {
        Shape::Mesh(_) if !moves => found.push(mesh(part)?),
        Shape::Mesh(triangles) => found.extend(convex_parts(triangles, place)?),
        Shape::Torus { radius_m, tube_m } => {
            // Hulls of pieces of the ring.
            const PIECES: usize = 24;
            for piece in 0..PIECES {
                let ring = |at: usize| torus_ring(*radius_m, *tube_m, TAU * at as f64 / PIECES as f64, 16);
                let points: Vec<DVec3> = ring(piece).into_iter().chain(ring(piece + 1)).collect();
                found.push(hull(points.into_iter().map(|p| place.transform_point3(p)))?);
            }
        }
        other => found.push(hull(points(other).into_iter().map(|p| place.transform_point3(p)))?),
    }
    Ok(())
}

/// The shape itself, where it is still one after it was scaled.
fn primitive(part: &PlannedPart, rotation: DQuat, scale: DVec3, moves: bool) -> Option<Placed> {
    let origin = part.pose_from_shape.translation;
    // All but flat shapes are the same on both sides of x.
    let (signed, scale) = (scale, scale.abs());
    let round = alike(scale.x, scale.z);
    let even = round && alike(scale.x, scale.y);
    let half = |m: f64| (0.5 * m) as f32;
    let thickness = if moves { SHEET_M } else { THIN_M };
    let turned = |by: DQuat| pose(origin, rotation * by);
    Some(match &part.shape {
        Shape::Sphere { radius_m } if even => (turned(DQuat::IDENTITY), SharedShape::ball((radius_m * scale.x) as f32)),
        Shape::Box { size_m } => {
            let size = *size_m * scale;
            (turned(DQuat::IDENTITY), SharedShape::cuboid(half(size.x), half(size.y), half(size.z)))
        }
        Shape::Quad { frame, size_m } => {
            // Its own axes need not be those that are scaled.
            let [x, y, z] = [frame.x, frame.y, frame.z].map(|axis| signed * axis);
            if [x.dot(y), y.dot(z)].into_iter().any(|cosine| cosine.abs() > SLACK * scale.max_element().powi(2)) {
                return None;
            }
            let own = DQuat::from_mat3(&DMat3::from_cols(x.normalize(), y.normalize(), x.cross(y).normalize()));
            let (width, height) = (size_m.x * x.length(), size_m.y * y.length());
            (turned(own), SharedShape::cuboid(half(width), half(height), half(thickness)))
        }
        Shape::Disk { frame, radius_m } if even => {
            let own = DQuat::from_rotation_arc(DVec3::Y, (signed * frame.z).normalize());
            (turned(own), SharedShape::cylinder(half(thickness), (radius_m * scale.x) as f32))
        }
        Shape::Cylinder { radius_m, height_m, .. } if round => {
            let shape = SharedShape::cylinder(half(height_m * scale.y), (radius_m * scale.x) as f32);
            (turned(DQuat::IDENTITY), shape)
        }
        Shape::Cone { radius_m, height_m, .. } if round => {
            // The rotation keeps y, so a cone that is turned over is so by it.
            let shape = SharedShape::cone(half(height_m * scale.y), (radius_m * scale.x) as f32);
            (turned(DQuat::IDENTITY), shape)
        }
        Shape::Capsule { radius_m, height_m, .. } if even => {
            let along = (0.5 * height_m - radius_m).max(0.0) * scale.y;
            (turned(DQuat::IDENTITY), SharedShape::capsule_y(along as f32, (radius_m * scale.x) as f32))
        }
        _ => return None,
    })
}

/// The hull of points of the body's pose.
fn hull(points: impl Iterator<Item = DVec3>) -> Result<Placed, &'static str> {
    // Counted from the middle, where numbers have most bits.
    let points: Vec<DVec3> = points.collect();
    let (low, high) = bounds(points.iter().copied());
    let middle = 0.5 * (low + high);
    if !middle.is_finite() {
        return Err("it has no points");
    }
    let points: Vec<Vector> = points.into_iter().map(|p| single(p - middle)).collect();
    let shape = SharedShape::convex_hull(&points).ok_or("it is flat")?;
    if shape.mass_properties(1.0).mass() <= 0.0 {
        return Err("it is flat");
    }
    Ok((Pose::from_translation(single(middle)), shape))
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// All corners of a shape, and of a round one enough points of its surface.
fn points(shape: &Shape<Still>) -> Vec<DVec3> {
    const AROUND: usize = 24;
    let circle = |radius: f64, y: f64| {
        (0..AROUND).map(move |i| {
            let (sin, cos) = (TAU * i as f64 / AROUND as f64).sin_cos();
            DVec3::new(radius * cos, y, radius * sin)
        })
    };
    let dome = |radius: f64, centre: f64, from: f64, to: f64| {
        (0..=16).flat_map(move |i| {
            let (sin, cos) = (from + (to - from) * f64::from(i) / 16.0).sin_cos();
            circle(radius * cos, centre + radius * sin)
        })
    };
    match shape {
        Shape::Sphere { radius_m } => dome(*radius_m, 0.0, -0.5 * PI, 0.5 * PI).collect(),
        Shape::Box { size_m } => corners(0.5 * *size_m).collect(),
        Shape::Quad { frame, size_m } => corners(0.5 * size_m.extend(SHEET_M)).map(|p| frame.matrix() * p).collect(),
        Shape::Disk { frame, radius_m } => {
            let own = DQuat::from_rotation_arc(DVec3::Y, frame.z);
            let both = [-0.5 * SHEET_M, 0.5 * SHEET_M].into_iter().flat_map(|y| circle(*radius_m, y));
            both.map(|p| own * p).collect()
        }
        Shape::Cylinder { radius_m, height_m, .. } => {
            [-0.5 * height_m, 0.5 * height_m].into_iter().flat_map(|y| circle(*radius_m, y)).collect()
        }
        Shape::Cone { radius_m, height_m, .. } => {
            circle(*radius_m, -0.5 * height_m).chain([DVec3::new(0.0, 0.5 * height_m, 0.0)]).collect()
        }
        Shape::Capsule { radius_m, height_m, .. } => {
            let along = (0.5 * height_m - radius_m).max(0.0);
            dome(*radius_m, -along, -0.5 * PI, 0.0).chain(dome(*radius_m, along, 0.0, 0.5 * PI)).collect()
        }
        Shape::Torus { radius_m, tube_m } => {
            (0..AROUND).flat_map(|i| torus_ring(*radius_m, *tube_m, TAU * i as f64 / AROUND as f64, 16)).collect()
        }
        Shape::Plane { .. } => Vec::new(),
        Shape::Mesh(mesh) => mesh.positions.iter().map(|p| p.as_dvec3()).collect(),
    }
}

/// A circle of the tube of a torus, at an angle about y.
fn torus_ring(radius: f64, tube: f64, angle: f64, count: usize) -> Vec<DVec3> {
    let turn = DQuat::from_rotation_y(angle);
    let point = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / count as f64).sin_cos();
        // A tube that is thicker than its ring is wide ends at the axis.
        turn * DVec3::new((radius + tube * cos).max(0.0), tube * sin, 0.0)
    };
    (0..count).map(point).collect()
}

/// One shape about all parts.
fn about(parts: &[PlannedPart], wanted: Collider) -> Result<Placed, &'static str> {
    // A shape that stands alone has its own axes; several have those of the body.
    let own = match parts {
        [part] => straight(part.pose_from_shape).map(|(rotation, _)| rotation),
        _ => None,
    };
    let rotation = own.unwrap_or(DQuat::IDENTITY);
    let all: Vec<DVec3> = parts
        .iter()
        .flat_map(|part| points(&part.shape).into_iter().map(|p| part.pose_from_shape.transform_point3(p)))
        .collect();
    if wanted == Collider::ConvexHull {
        return hull(all.into_iter());
    }
    let back = rotation.inverse();
    let local: Vec<DVec3> = all.into_iter().map(|p| back * p).collect();
    let (low, high) = bounds(local.iter().copied());
    let (middle, half) = (0.5 * (low + high), (0.5 * (high - low)).max(DVec3::splat(0.5 * SHEET_M)));
    if !half.is_finite() {
        return Err("it has no points");
    }
    let place = |by: DQuat| pose(rotation * middle, rotation * by);
    // The largest distance from an axis through the middle, and from the middle itself.
    let reach = |along: DVec3| {
        let across = |p: &DVec3| {
            let p = *p - middle;
            (p - along * p.dot(along)).length()
        };
        local.iter().map(across).fold(0.5 * SHEET_M, f64::max)
    };
    Ok(match wanted {
        Collider::Sphere => (place(DQuat::IDENTITY), SharedShape::ball(reach(DVec3::ZERO) as f32)),
        Collider::Cylinder => (place(DQuat::IDENTITY), SharedShape::cylinder(half.y as f32, reach(DVec3::Y) as f32)),
        Collider::Capsule => {
            let longest = if half.y >= half.max_element() { 1 } else { half.max_position() };
            let axis = DVec3::AXES[longest];
            let radius = reach(axis);
            // What is inside the cylinder about it is, and its ends are round.
            let along = (half[longest] - radius).max(0.0);
            (place(DQuat::from_rotation_arc(DVec3::Y, axis)), SharedShape::capsule_y(along as f32, radius as f32))
        }
        _ => (place(DQuat::IDENTITY), SharedShape::cuboid(half.x as f32, half.y as f32, half.z as f32)),
    })
}

/// The triangles of a shape, in the body's pose.
fn triangles(part: &PlannedPart) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const AROUND: usize = 64;
    /// Rows of points, each closed to a ring, with triangles between one and the next.
    fn between(rows: &[Vec<DVec3>], closed: bool) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let count = rows.first().map_or(0, Vec::len);
        let pairs = if closed { rows.len() } else { rows.len().saturating_sub(1) };
        let mut triangles = Vec::new();
        for row in 0..pairs {
            let next = (row + 1) % rows.len();
            for i in 0..count {
                let j = (i + 1) % count;
                let [a, b, c, d] =
                    [row * count + i, row * count + j, next * count + j, next * count + i].map(|index| index as u32);
                triangles.extend([[a, d, c], [a, c, b]]);
            }
        }
        (rows.concat(), triangles)
    }
    let circle = |radius: f64, y: f64| {
        let point = |i: usize| {
            let (sin, cos) = (TAU * i as f64 / AROUND as f64).sin_cos();
            DVec3::new(radius * cos, y, radius * sin)
        };
        (0..AROUND).map(point).collect::<Vec<_>>()
    };
    let capped = |rows: Vec<Vec<DVec3>>, capped: bool| {
        let (mut points, mut triangles) = between(&rows, false);
        if capped {
            for (row, flip) in [(0, false), (rows.len() - 1, true)] {
                let centre = points.len() as u32;
                points.push(rows[row].iter().sum::<DVec3>() / AROUND as f64);
                for i in 0..AROUND {
                    let [a, b] = [i, (i + 1) % AROUND].map(|index| (row * AROUND + index) as u32);
                    triangles.push(if flip { [centre, b, a] } else { [centre, a, b] });
                }
            }
        }
        (points, triangles)
    };
    match &part.shape {
        Shape::Mesh(mesh) => (mesh.positions.iter().map(|p| p.as_dvec3()).collect(), mesh.triangles.clone()),
        Shape::Cylinder { radius_m, height_m, capped: closed } => {
            capped([-0.5, 0.5].map(|y| circle(*radius_m, y * height_m)).to_vec(), *closed)
        }
        Shape::Cone { radius_m, height_m, capped: closed } => {
            capped([(*radius_m, -0.5), (0.0, 0.5)].map(|(radius, y)| circle(radius, y * height_m)).to_vec(), *closed)
        }
        Shape::Torus { radius_m, tube_m } => {
            let ring = |i: usize| torus_ring(*radius_m, *tube_m, TAU * i as f64 / AROUND as f64, 24);
            between(&(0..AROUND).map(ring).collect::<Vec<_>>(), true)
        }
        Shape::Quad { frame, size_m } => {
            let half = 0.5 * *size_m;
            let corner = |x: f64, y: f64| frame.x * (x * half.x) + frame.y * (y * half.y);
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            (corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])
        }
        Shape::Disk { frame, radius_m } => {
            let own = DQuat::from_rotation_arc(DVec3::Y, frame.z);
            let mut points: Vec<DVec3> = circle(*radius_m, 0.0).into_iter().map(|p| own * p).collect();
            points.push(DVec3::ZERO);
            let [count, centre] = [AROUND as u32; 2];
            (points, (0..count).map(|i| [centre, (i + 1) % count, i]).collect())
        }
        other => match SharedShape::convex_hull(&points(other).into_iter().map(single).collect::<Vec<_>>()) {
            Some(hull) => match hull.as_convex_polyhedron().map(|hull| hull.to_trimesh()) {
                Some((points, triangles)) => (points.into_iter().map(double).collect(), triangles),
                None => (Vec::new(), Vec::new()),
            },
            None => (Vec::new(), Vec::new()),
        },
    }
}

/// The triangles themselves; they are met from both sides.
fn mesh(part: &PlannedPart) -> Result<Placed, &'static str> {
    if part.is_plane() {
        let mut found = Vec::new();
        automatic(part, false, &mut found)?;
        return found.pop().ok_or("it has no points");
    }
    let (points, triangles) = triangles(part);
    let place = part.pose_from_shape;
    let points: Vec<Vector> = points.into_iter().map(|p| single(place.transform_point3(p))).collect();
    let flags = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED | TriMeshFlags::DELETE_DEGENERATE_TRIANGLES;
    let shape = SharedShape::trimesh_with_flags(points, triangles, flags).map_err(|_| "it has no triangles")?;
    Ok((Pose::IDENTITY, shape))
}

/// Hulls of the convex parts of a mesh: one, where it is as good as convex.
fn convex_parts(mesh: &Mesh, place: DAffine3) -> Result<Vec<Placed>, &'static str> {
    let points: Vec<DVec3> = mesh.positions.iter().map(|p| place.transform_point3(p.as_dvec3())).collect();
    let whole = hull(points.iter().copied())?;
    let (low, high) = bounds(points.iter().copied());
    let middle = 0.5 * (low + high);
    // By the divergence theorem; nonsense for what is open, which then gets one hull if it is flat enough.
    let corner = |index: u32| points.get(index as usize).copied().unwrap_or(middle) - middle;
    let signed = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
    let volume: f64 = mesh.triangles.iter().map(signed).sum::<f64>().abs();
    let hull_volume = f64::from(whole.1.mass_properties(1.0).mass());
    if volume > (1.0 - EMPTY) * hull_volume {
        return Ok(vec![whole]);
    }
    let local: Vec<Vector> = points.iter().map(|p| single(*p - middle)).collect();
    let params = VHACDParameters { resolution: 64, concavity: 0.01, ..VHACDParameters::default() };
    let parts = SharedShape::convex_decomposition_with_params(&local, &mesh.triangles, &params);
    let Some(compound) = parts.as_compound() else { return Ok(vec![whole]) };
    let moved = |(at, shape): &(Pose, SharedShape)| {
        (Pose::from_parts(at.translation + single(middle), at.rotation), shape.clone())
    };
    let found: Vec<Placed> = compound.shapes().iter().map(moved).collect();
    Ok(if found.is_empty() { vec![whole] } else { found })
}
