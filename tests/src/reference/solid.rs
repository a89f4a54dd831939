//! Shapes in the world, one after the other: no tree.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec2, DVec3};
use kinora_scene::{Frame, Instance, Shape};

/// A shape, as the parts that a ray is tested against.
pub struct Solid {
    parts: Vec<Part>,
    pub material: usize,
    /// Square metres in the world.
    pub area: f64,
}

enum Part {
    /// The unit sphere, placed in the world, or the half of it with y of that sign.
    Ball { world_from_unit: DAffine3, unit_from_world: DAffine3, half: f64 },
    /// Where x² + z² = (1 − taper · y)² and y is from 0 to 1, placed in the world.
    Side { world_from_side: DAffine3, side_from_world: DAffine3, taper: f64 },
    /// A torus about y, by the radii of its ring and its tube.
    Ring { world_from_ring: DAffine3, ring_from_world: DAffine3, radius: f64, tube: f64 },
    /// All corner + u · x + v · y with (u, v) in `extent`.
    Flat { corner: DVec3, x: DVec3, y: DVec3, extent: Extent, outside: f64, look: Option<Box<Look>> },
}

enum Extent {
    Parallelogram,
    /// About the corner, x and y its radii.
    Disk,
    Triangle,
    Plane,
}

/// Of a mesh's triangle: the shading normals at its corners, and where u grows to.
struct Look {
    normals: Option<[DVec3; 3]>,
    tangent: DVec3,
}

/// Where a ray met a solid.
pub struct Hit {
    pub t: f64,
    pub p: DVec3,
    /// Geometric normal and shading normal, both outwards.
    pub ng: DVec3,
    pub ns: DVec3,
    /// Where u grows to; not of unit length.
    pub tangent: DVec3,
    pub solid: usize,
}

impl Solid {
    pub fn new(instance: &Instance) -> Solid {
        let place = instance.world_from_object;
        let outside = place.matrix3.determinant().signum();
        let flat = |corner, x, y, extent| {
            let (x, y) = (place.transform_vector3(x), place.transform_vector3(y));
            Part::Flat { corner: place.transform_point3(corner), x, y, extent, outside, look: None }
        };
        let rectangle = |centre: DVec3, frame: Frame, size: DVec2| {
            let (x, y) = (frame.x * size.x, frame.y * size.y);
            flat(centre - 0.5 * (x + y), x, y, Extent::Parallelogram)
        };
        let ball = |world_from_unit: DAffine3, half| Part::Ball {
            world_from_unit,
            unit_from_world: world_from_unit.inverse(),
            half,
        };
        let side = |bottom: f64, radius: f64, height: f64, taper| {
            let world_from_side = place
                * DAffine3::from_translation(DVec3::Y * bottom)
                * DAffine3::from_scale(DVec3::new(radius, height, radius));
            Part::Side { world_from_side, side_from_world: world_from_side.inverse(), taper }
        };
        let parts: Vec<Part> = match &instance.shape {
            Shape::Sphere { radius_m } => {
                let world_from_unit = place * DAffine3::from_scale(DVec3::splat(*radius_m));
                vec![ball(world_from_unit, 0.0)]
            }
            Shape::Disk { frame, radius_m } => {
                vec![flat(DVec3::ZERO, frame.x * *radius_m, frame.y * *radius_m, Extent::Disk)]
            }
            &Shape::Cylinder { radius_m, height_m, capped } => {
                let mut parts = vec![side(-0.5 * height_m, radius_m, height_m, 0.0)];
                let end =
                    |y: f64, across: DVec3| flat(DVec3::Y * y, across * radius_m, DVec3::X * radius_m, Extent::Disk);
                if capped {
                    parts.extend([end(0.5 * height_m, DVec3::Z), end(-0.5 * height_m, DVec3::NEG_Z)]);
                }
                parts
            }
            &Shape::Cone { radius_m, height_m, capped } => {
                let mut parts = vec![side(-0.5 * height_m, radius_m, height_m, 1.0)];
                if capped {
                    let (x, y) = (DVec3::NEG_Z * radius_m, DVec3::X * radius_m);
                    parts.push(flat(DVec3::Y * (-0.5 * height_m), x, y, Extent::Disk));
                }
                parts
            }
            &Shape::Capsule { radius_m, height_m, capped } => {
                let straight = height_m - 2.0 * radius_m;
                let mut parts = vec![];
                if straight > 0.0 {
                    parts.push(side(-0.5 * straight, radius_m, straight, 0.0));
                }
                if capped {
                    parts.extend([-1.0, 1.0].map(|half| {
                        let centre = DAffine3::from_translation(DVec3::Y * (0.5 * half * straight));
                        ball(place * centre * DAffine3::from_scale(DVec3::splat(radius_m)), half)
                    }));
                }
                parts
            }
            Shape::Torus { radius_m, tube_m } => {
                vec![Part::Ring {
                    world_from_ring: place,
                    ring_from_world: place.inverse(),
                    radius: *radius_m,
                    tube: *tube_m,
                }]
            }
            Shape::Quad { frame, size_m } => vec![rectangle(DVec3::ZERO, *frame, *size_m)],
            Shape::Plane { frame } => vec![flat(DVec3::ZERO, frame.x, frame.y, Extent::Plane)],
            Shape::Box { size_m } => (DVec3::AXES.into_iter().chain(DVec3::AXES.map(|axis| -axis)))
                .map(|normal| {
                    let frame = Frame::facing(normal, DVec3::Y).expect("an axis has a frame");
                    let size = DVec2::new(frame.x.abs().dot(*size_m), frame.y.abs().dot(*size_m));
                    rectangle(0.5 * normal * *size_m, frame, size)
                })
                .collect(),
            Shape::Mesh(mesh) => (mesh.triangles.iter())
                .map(|corners| {
                    let corners = corners.map(|i| i as usize);
                    let [a, b, c] = corners.map(|i| place.transform_point3(mesh.positions[i].as_dvec3()));
                    let upright = place.matrix3.inverse().transpose();
                    let normals = (!mesh.normals.is_empty())
                        .then(|| corners.map(|i| (upright * mesh.normals[i].as_dvec3()).normalize()));
                    let mut tangent = b - a;
                    if !mesh.uvs.is_empty() {
                        let [s, t, r] = corners.map(|i| mesh.uvs[i].as_dvec2());
                        let along = (b - a) * (r - s).y - (c - a) * (t - s).y;
                        tangent = along * (t - s).perp_dot(r - s).signum();
                    }
                    let look = Some(Box::new(Look { normals, tangent }));
                    Part::Flat { corner: a, x: b - a, y: c - a, extent: Extent::Triangle, outside, look }
                })
                .collect(),
        };
        let area = parts.iter().map(Part::area).sum();
        Solid { parts, material: instance.material, area }
    }
}

impl Part {
    fn area(&self) -> f64 {
        match self {
            Part::Ball { world_from_unit, half, .. } => image_area(world_from_unit.matrix3, |turn, height| {
                let (z, (sin, cos)) = (2.0 * height - 1.0, (TAU * turn).sin_cos());
                let r = (1.0 - z * z).sqrt();
                // Half of a sphere's image has half its area, whichever half.
                (if *half == 0.0 { 4.0 } else { 2.0 }) * PI * DVec3::new(r * cos, r * sin, z)
            }),
            Part::Side { world_from_side, taper, .. } => image_area(world_from_side.matrix3, |turn, height| {
                let (sin, cos) = (TAU * turn).sin_cos();
                TAU * (1.0 - taper * height) * DVec3::new(cos, *taper, sin)
            }),
            Part::Ring { world_from_ring, radius, tube, .. } => image_area(world_from_ring.matrix3, |turn, round| {
                let ((sin, cos), (up, out)) = ((TAU * turn).sin_cos(), (TAU * round).sin_cos());
                TAU * TAU * tube * (radius + tube * out) * DVec3::new(out * cos, up, out * sin)
            }),
            Part::Flat { x, y, extent, .. } => match extent {
                Extent::Parallelogram => x.cross(*y).length(),
                Extent::Triangle => 0.5 * x.cross(*y).length(),
                Extent::Disk => PI * x.cross(*y).length(),
                Extent::Plane => f64::INFINITY,
            },
        }
    }

    /// The nearest t above `t_min`, and (u, v) of what is flat.
    fn meet(&self, o: DVec3, d: DVec3, t_min: f64) -> Option<(f64, DVec2)> {
        match self {
            Part::Ball { unit_from_world, half, .. } => {
                let (o, d) = (unit_from_world.transform_point3(o), unit_from_world.transform_vector3(d));
                let (a, b, c) = (d.length_squared(), o.dot(d), o.length_squared() - 1.0);
                let root = (b * b - a * c).sqrt();
                let roots = [(-b - root) / a, (-b + root) / a];
                let there = |t: &f64| *t > t_min && (o.y + t * d.y) * half >= 0.0;
                roots.into_iter().find(there).map(|t| (t, DVec2::ZERO))
            }
            Part::Side { side_from_world, taper, .. } => {
                let (o, d) = (side_from_world.transform_point3(o), side_from_world.transform_vector3(d));
                let (r, slope) = (1.0 - taper * o.y, -taper * d.y);
                let a = d.x * d.x + d.z * d.z - slope * slope;
                let b = o.x * d.x + o.z * d.z - r * slope;
                let c = o.x * o.x + o.z * o.z - r * r;
                let root = (b * b - a * c).sqrt();
                let mut roots = [(-b - root) / a, (-b + root) / a];
                roots.sort_by(f64::total_cmp);
                let there = |t: &f64| *t > t_min && (0.0..=1.0).contains(&(o.y + t * d.y));
                roots.into_iter().find(there).map(|t| (t, DVec2::ZERO))
            }
            Part::Ring { ring_from_world, radius, tube, .. } => {
                let (o, d) = (ring_from_world.transform_point3(o), ring_from_world.transform_vector3(d));
                let apart = |t: f64| ring_distance(o + t * d, *radius, *tube);
                // No step goes farther than the surface may be, but for the last bit of the way.
                let mut t = t_min;
                let outside = apart(t) > 0.0;
                let far = (o.length() + radius + tube) / d.length();
                while t < far {
                    let next = t + (apart(t).abs() / d.length()).max(1e-6);
                    if (apart(next) > 0.0) != outside {
                        let (mut near, mut far) = (t, next);
                        for _ in 0..60 {
                            let middle = 0.5 * (near + far);
                            if (apart(middle) > 0.0) == outside { near = middle } else { far = middle }
                        }
                        return Some((far, DVec2::ZERO));
                    }
                    t = next;
                }
                None
            }
            Part::Flat { corner, x, y, extent, .. } => {
                let n = x.cross(*y);
                let t = n.dot(*corner - o) / n.dot(d);
                let q = o + t * d - *corner;
                let uv = DVec2::new(q.cross(*y).dot(n), x.cross(q).dot(n)) / n.length_squared();
                let inside = match extent {
                    Extent::Parallelogram => uv.min_element() >= 0.0 && uv.max_element() <= 1.0,
                    Extent::Triangle => uv.min_element() >= 0.0 && uv.element_sum() <= 1.0,
                    Extent::Disk => uv.length() <= 1.0,
                    Extent::Plane => true,
                };
                (t > t_min && t.is_finite() && inside).then_some((t, uv))
            }
        }
    }

    fn hit(&self, p: DVec3, t: f64, uv: DVec2, solid: usize) -> Hit {
        match self {
            Part::Ball { world_from_unit, unit_from_world, .. } => {
                let q = unit_from_world.transform_point3(p);
                let n = (unit_from_world.matrix3.transpose() * q).normalize();
                let tangent = world_from_unit.transform_vector3(DVec3::Y.cross(q));
                Hit { t, p, ng: n, ns: n, tangent, solid }
            }
            Part::Side { world_from_side, side_from_world, taper } => {
                let q = side_from_world.transform_point3(p);
                let slope = DVec3::new(q.x, *taper * (1.0 - taper * q.y), q.z);
                let n = (side_from_world.matrix3.transpose() * slope).normalize();
                let tangent = world_from_side.transform_vector3(DVec3::Y.cross(q));
                Hit { t, p, ng: n, ns: n, tangent, solid }
            }
            Part::Ring { world_from_ring, ring_from_world, radius, .. } => {
                let q = ring_from_world.transform_point3(p);
                let centre = DVec3::new(q.x, 0.0, q.z).normalize() * *radius;
                let n = (ring_from_world.matrix3.transpose() * (q - centre)).normalize();
                let tangent = world_from_ring.transform_vector3(DVec3::Y.cross(q));
                Hit { t, p, ng: n, ns: n, tangent, solid }
            }
            Part::Flat { x, y, outside, look, .. } => {
                let ng = x.cross(*y).normalize() * *outside;
                let normals = look.as_ref().and_then(|look| look.normals);
                let ns = normals.map_or(ng, |[a, b, c]| ((1.0 - uv.x - uv.y) * a + uv.x * b + uv.y * c).normalize());
                Hit { t, p, ng, ns, tangent: look.as_ref().map_or(*x, |look| look.tangent), solid }
            }
        }
    }
}

/// The nearest hit of a ray of unit length, farther than `t_min`.
pub fn nearest(solids: &[Solid], o: DVec3, d: DVec3, t_min: f64) -> Option<Hit> {
    let mut best: Option<(f64, DVec2, usize, &Part)> = None;
    for (solid, part) in solids.iter().enumerate().flat_map(|(i, solid)| solid.parts.iter().map(move |part| (i, part)))
    {
        if let Some((t, uv)) = part.meet(o, d, t_min)
            && best.is_none_or(|(least, ..)| t < least)
        {
            best = Some((t, uv, solid, part));
        }
    }
    best.map(|(t, uv, solid, part)| part.hit(o + t * d, t, uv, solid))
}

fn ring_distance(p: DVec3, radius: f64, tube: f64) -> f64 {
    (p.x.hypot(p.z) - radius).hypot(p.y) - tube
}

/// Area of the image of a surface under a linear map, ∫ |det M| |M⁻ᵀ n| dA over parameters in 0..1; `n_area` gives n
/// dA.
fn image_area(m: DMat3, n_area: impl Fn(f64, f64) -> DVec3) -> f64 {
    let upright = m.inverse().transpose();
    let steps = 400;
    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(steps);
    let places = (0..steps).flat_map(|i| (0..steps).map(move |j| (at(i), at(j))));
    let sum: f64 = places.map(|(u, v)| (upright * n_area(u, v)).length()).sum();
    m.determinant().abs() * sum / f64::from(steps * steps)
}
