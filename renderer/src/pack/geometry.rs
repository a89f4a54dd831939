//! Shapes as primitives of the tree, with their boxes and lights.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec4, Vec3, Vec4};
use kinora_kernel::generated::{
    EMITTER_BEAM, LIGHT_ELLIPSOID, LIGHT_PARALLELOGRAM, LIGHT_RECTANGLE, LIGHT_SPHERE, LIGHT_TRIANGLE,
    MATERIAL_EMITTER, NONE, PRIMITIVE_OTHER, PRIMITIVE_PARALLELOGRAM, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE,
};
use kinora_kernel::query::Bounds;
use kinora_kernel::{Material as PackedMaterial, Primitive, Shape as PackedShape};
use kinora_scene::{Frame, Instance, Lamp, LightKind, Mesh, Shape, Still, World};
use rayon::prelude::*;

use crate::motion::Moved;

use super::grow::{Branch, Plans};
use super::lights::{self, Light, luminance};
use super::materials::{Emitter, Known, Reads, add_emitters, append_emitters, emitters};
use super::other::Other;
use super::textures::Textures;
use super::{NO_LIGHT, PackError, TURN};

/// What `pack` collects, primitives in the order in which they come.
#[derive(Default)]
pub struct Geometry {
    pub primitives: Vec<Primitive>,
    pub bounds: Vec<Bounds>,
    /// Large meshes, which have branches of the tree to themselves.
    pub branches: Vec<Branch>,
    /// Of all meshes so far.
    pub plans: Plans,
    pub shapes: Vec<PackedShape>,
    /// Where each of them goes, if motion is wanted.
    pub moved: Option<Vec<Moved>>,
    pub lights: Vec<Light>,
    /// Those of the world, then what belongs to them or to single shapes.
    pub materials: Vec<PackedMaterial>,
    /// What each of the world's materials reads of a mesh's vertices.
    pub reads: Vec<Reads>,
    /// Whether each of them shines.
    pub shines: Vec<bool>,
    /// Textures, and what meshes have for them.
    pub textures: Textures,
    /// Records of emitters that shapes may share.
    pub emitters: Known,
    /// Of the lamps that are spheres.
    pub lamp_material: Option<u32>,
}

/// How much a surface shines.
#[derive(Clone, Copy)]
struct Shining {
    /// Radiance, luminance, summed over the sides that shine.
    power_per_m2: f64,
    two_sided: bool,
}

pub fn is_far(v: Vec3) -> bool {
    !v.is_finite() || v.abs().max_element() > MAX_COORDINATE as f32
}

/// Larger coordinates lose more to rounding than any scene can bear, and their squares overflow.
const MAX_COORDINATE: f64 = 1e15;

impl Geometry {
    /// Adds one shape with everything that belongs to it.
    pub fn add(&mut self, instance: &Instance, world: &World) -> Result<(), PackError> {
        let place = instance.world_from_object;
        let shape = self.shapes.len() as u32;
        let first = self.primitives.len();
        let first_branch = self.branches.len();
        let first_light = self.lights.len() as u32;
        let mut record = PackedShape::default();
        let emission = self.emission(instance, world, &mut record)?;
        match &instance.shape {
            Shape::Sphere { radius_m } => {
                let place = place * DAffine3::from_scale(DVec3::splat(*radius_m));
                set_transform(&mut record, place);
                self.add_sphere(shape, place);
                if let Some(shining) = emission {
                    self.add_sphere_light(shape, place, shining);
                }
            }
            Shape::Box { size_m } => {
                for frame in box_faces() {
                    let place = place * DAffine3::from_translation(frame.z * *size_m * 0.5);
                    let size = DVec2::new((frame.x * *size_m).length(), (frame.y * *size_m).length());
                    self.add_quad(shape, first, place, frame, size, emission);
                }
            }
            Shape::Quad { frame, size_m } => {
                self.add_quad(shape, first, place, *frame, *size_m, emission);
            }
            Shape::Plane { frame } => {
                set_transform(&mut record, place * DAffine3::from_mat3(frame.matrix()));
            }
            Shape::Mesh(mesh) => self.add_mesh(shape, place, mesh, emission, instance.material),
            other => {
                if let Some(other) = Other::new(other, place) {
                    set_transform(&mut record, other.place);
                    self.add_other(shape, &other, emission);
                }
            }
        }
        let first_light = if self.lights.len() as u32 == first_light { NO_LIGHT } else { first_light };
        record.index = UVec4::new(instance.material as u32, first_light, record.index.z, instance.node as u32);
        if self.reads.get(instance.material).is_some_and(|reads| reads.local) {
            self.textures.local(self.shapes.len(), place);
        }
        let meshes = match (&instance.shape, &instance.next_mesh) {
            (Shape::Mesh(now), Some(next)) => Some([now.clone(), next.clone()]),
            _ => None,
        };
        self.push(record, place, instance.next, meshes);

        let branches = self.branches[first_branch..].iter().map(Branch::bounds);
        let outside = self.bounds[first..].iter().copied().chain(branches).any(|b| is_far(b.low) || is_far(b.high));
        let matrices = [record.object_from_world_x, record.object_from_world_y, record.object_from_world_z];
        if outside || matrices.iter().any(|row| !row.is_finite()) {
            return Err(PackError::Coordinates { node: instance.node });
        }
        Ok(())
    }

    /// Adds the record of a shape that is placed by `from`, and by `next` at the next frame; `None`: it stays. `meshes`: as
    /// in [`Moved`].
    pub fn push(
        &mut self,
        record: PackedShape,
        from: DAffine3,
        next: Option<DAffine3>,
        meshes: Option<[Arc<Mesh>; 2]>,
    ) {
        self.shapes.push(record);
        if let Some(moved) = &mut self.moved {
            moved.push(Moved { from, to: next.unwrap_or(from), meshes });
        }
    }

    /// Adds a lamp that is a sphere.
    pub fn add_lamp(&mut self, lamp: &Lamp) -> Result<(), PackError> {
        let (LightKind::Point { position, power, radius_m } | LightKind::Spot { position, power, radius_m, .. }) =
            lamp.light.kind
        else {
            return Ok(());
        };
        let area = 2.0 * TURN * radius_m * radius_m;
        let radiance = lamp.light.color * (power / (std::f64::consts::PI * area)) as f32;
        let shape = self.shapes.len() as u32;
        let mut record = PackedShape::default();
        let place = DAffine3::from_scale_rotation_translation(DVec3::splat(radius_m), DQuat::IDENTITY, position);
        set_transform(&mut record, place);
        // A lamp reflects nothing: one record of an emitter serves all of them.
        let black = match self.lamp_material {
            Some(black) => black,
            None => {
                self.materials.push(PackedMaterial {
                    more: Vec4::W,
                    kind: UVec4::new(MATERIAL_EMITTER, 0, NONE, NONE),
                    ..PackedMaterial::default()
                });
                *self.lamp_material.insert(self.materials.len() as u32 - 1)
            }
        };
        let emitter = Emitter { radiance, two_sided: false, coats: Vec::new(), glow: None };
        let first_emitter = match lights::cone(&lamp.light.kind) {
            None => add_emitters(&mut self.materials, &mut self.emitters, &mut self.textures, &[emitter])?,
            Some((axis, [outer, inner])) => {
                let first = append_emitters(&mut self.materials, &mut self.textures, &[emitter])?;
                if let Some(record) = self.materials.get_mut(first as usize) {
                    record.kind.y |= EMITTER_BEAM;
                    record.extra = axis.as_vec3().extend(0.0);
                    record.lobe = Vec4::new(outer as f32, inner as f32, 0.0, 0.0);
                }
                first
            }
        };
        record.index = UVec4::new(black, self.lights.len() as u32, first_emitter, lamp.node as u32);
        self.add_sphere(shape, place);
        self.add_sphere_light(shape, place, Shining { power_per_m2: luminance(radiance), two_sided: false });
        self.push(record, DAffine3::IDENTITY, lamp.next, None);
        match self.bounds.last() {
            Some(b) if is_far(b.low) || is_far(b.high) => Err(PackError::Coordinates { node: lamp.node }),
            _ => Ok(()),
        }
    }

    fn add_sphere_light(&mut self, shape: u32, place: DAffine3, shining: Shining) {
        let area = ellipsoid_area(place);
        let power = area * shining.power_per_m2;
        let bounds = self.bounds.last().map_or([DVec3::ZERO; 2], |b| [b.low.as_dvec3(), b.high.as_dvec3()]);
        let (kind, size) = match radius_of(place) {
            Some(radius) => (LIGHT_SPHERE, radius),
            None => (LIGHT_ELLIPSOID, place.matrix3.determinant().abs()),
        };
        self.lights.push(lights::round(kind, shape, place.translation, size, area, power, bounds));
    }

    // The power of a square metre of the shape, if it shines; the record gets its emitters.
    fn emission(
        &mut self,
        instance: &Instance,
        world: &World,
        record: &mut PackedShape,
    ) -> Result<Option<Shining>, PackError> {
        let area = || area_m2(&instance.shape, instance.world_from_object);
        let found = match self.shines.get(instance.material) {
            Some(true) => emitters(&world.materials, instance.material, &self.materials, &mut self.textures, area)?,
            _ => Vec::new(),
        };
        record.index.z = add_emitters(&mut self.materials, &mut self.emitters, &mut self.textures, &found)?;
        let cover = self.materials.get(instance.material).map_or(0.0, |m| f64::from(m.more.w));
        let sides = |two_sided| if two_sided { 2.0 } else { 1.0 };
        let power_per_m2 = found.iter().map(|e| cover * luminance(e.radiance) * sides(e.two_sided)).sum();
        let two_sided = found.iter().any(|e| e.two_sided);
        Ok((!found.is_empty()).then_some(Shining { power_per_m2, two_sided }))
    }

    fn add_sphere(&mut self, shape: u32, place: DAffine3) {
        let rows = place.matrix3.transpose();
        let half = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let centre = place.translation;
        self.bounds.push(Bounds { low: (centre - half).as_vec3(), high: (centre + half).as_vec3() });
        self.primitives
            .push(Primitive { shade: UVec4::new(0, 0, 0, shape | PRIMITIVE_SPHERE), ..Primitive::default() });
    }

    fn add_other(&mut self, shape: u32, other: &Other, emission: Option<Shining>) {
        let primitive = Primitive {
            x: Vec4::new(other.size as f32, 0.0, 0.0, 0.0),
            shade: UVec4::new(0, 0, 0, shape | PRIMITIVE_OTHER),
            index: UVec4::new(0, 0, other.kind, 0),
            ..Primitive::default()
        };
        let place = other.place;
        let rows = [0, 1, 2].map(|i| place.matrix3.row(i).extend(place.translation[i]));
        self.bounds.push(Bounds::of_other(&primitive, rows));
        self.primitives.push(primitive);
        if let (Some(shining), Some(b)) = (emission, self.bounds.last()) {
            let bounds = [b.low.as_dvec3(), b.high.as_dvec3()];
            self.lights.push(other.light(shape, shining.power_per_m2, bounds));
        }
    }

    // A rectangle about the origin of `place`, as one primitive and one light.
    fn add_quad(
        &mut self,
        shape: u32,
        first: usize,
        place: DAffine3,
        frame: Frame,
        size: DVec2,
        emission: Option<Shining>,
    ) {
        let mut u = place.transform_vector3(frame.x * size.x);
        let mut v = place.transform_vector3(frame.y * size.y);
        let mirrored = place.matrix3.determinant() < 0.0;
        if mirrored {
            std::mem::swap(&mut u, &mut v);
        }
        let origin = place.translation - (u + v) * 0.5;
        let corners = [origin, origin + u, origin + u + v, origin + v];
        let index = self.primitives.len() - first;
        let (mut primitive, bounds) = flat(shape | PRIMITIVE_PARALLELOGRAM, index, corners, [0; 3]);
        primitive.index.y = u32::from(mirrored);
        self.primitives.push(primitive);
        self.bounds.push(bounds);
        if let Some(Shining { power_per_m2, two_sided }) = emission {
            let area = u.cross(v).length();
            let square = u.dot(v).abs() <= 1e-7 * u.length() * v.length();
            let kind = if square { LIGHT_RECTANGLE } else { LIGHT_PARALLELOGRAM };
            let mut light = lights::flat(kind, shape, origin, [u, v], area, area * power_per_m2, two_sided);
            light.packed.kind.z = u32::from(mirrored);
            self.lights.push(light);
        }
    }

    fn add_mesh(&mut self, shape: u32, place: DAffine3, mesh: &Arc<Mesh>, emission: Option<Shining>, material: usize) {
        let indices = corners_in(place);
        let reads = self.reads.get(material).copied().unwrap_or_default();
        let vertices = if reads.textures || reads.tangents && !mesh.uvs.is_empty() {
            self.textures.mesh(mesh, place, indices, reads.tangents)
        } else {
            0
        };
        match self.plans.of(mesh) {
            Some(planned) => self.branches.push(Branch { planned, place, shape, vertices }),
            None => {
                let triangles = Triangles::new(mesh, place, shape, vertices);
                let all = (0..mesh.triangles.len()).into_par_iter().map(|i| triangles.get(i));
                let (primitives, bounds): (Vec<_>, Vec<_>) = all.unzip();
                self.primitives.extend(primitives);
                self.bounds.extend(bounds);
            }
        }
        let positions = mesh.positions.as_slice();
        let positions = |v: usize| place.transform_point3(positions[v].as_dvec3());
        let Some(Shining { power_per_m2, two_sided }) = emission else { return };
        for triangle in &mesh.triangles {
            let [a, b, c] = indices(triangle).map(positions);
            let area = 0.5 * (b - a).cross(c - a).length();
            let power = area * power_per_m2;
            let mut light = lights::flat(LIGHT_TRIANGLE, shape, a, [b - a, c - a], area, power, two_sided);
            light.packed.kind.z = vertices;
            self.lights.push(light);
        }
    }
}

/// The corners of triangles, turned round where `place` mirrors.
fn corners_in(place: DAffine3) -> impl Fn(&[u32; 3]) -> [usize; 3] + Sync + Copy {
    let mirrored = place.matrix3.determinant() < 0.0;
    move |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| v as usize);
        if mirrored { [a, c, b] } else { [a, b, c] }
    }
}

/// The triangles of a mesh in the world.
pub struct Triangles<'a> {
    mesh: &'a Mesh,
    place: DAffine3,
    positions: Vec<DVec3>,
    /// Encoded; empty for flat triangles.
    normals: Vec<u32>,
    kind_and_shape: u32,
    vertices: u32,
}

impl<'a> Triangles<'a> {
    /// Of shape `shape`, placed by `place`; `vertices`: the place of what its vertices have.
    pub fn new(mesh: &'a Mesh, place: DAffine3, shape: u32, vertices: u32) -> Self {
        let by_normal = normal_matrix(place);
        let normal = |n: &Vec3| encode_normal((by_normal * n.as_dvec3()).normalize_or_zero().as_vec3());
        Self {
            mesh,
            place,
            positions: mesh.positions.par_iter().map(|p| place.transform_point3(p.as_dvec3())).collect(),
            normals: mesh.normals.par_iter().map(normal).collect(),
            kind_and_shape: shape | PRIMITIVE_TRIANGLE,
            vertices,
        }
    }

    /// One of them and its box.
    pub fn get(&self, i: usize) -> (Primitive, Bounds) {
        let [a, b, c] = corners_in(self.place)(&self.mesh.triangles[i]);
        let shade = match self.normals.as_slice() {
            [] => [0; 3],
            n if n[a] == 0 || n[b] == 0 || n[c] == 0 => [0; 3],
            n => [n[a], n[b], n[c]],
        };
        let [a, b, c] = [self.positions[a], self.positions[b], self.positions[c]];
        let (mut primitive, bounds) = flat(self.kind_and_shape, i, [a, b, c, a], shade);
        primitive.index.y = self.vertices;
        (primitive, bounds)
    }
}

// A flat primitive and its box. `index`: of the primitive in its shape.
fn flat(kind_and_shape: u32, index: usize, corners: [DVec3; 4], normals: [u32; 3]) -> (Primitive, Bounds) {
    let [a, b, c, d] = corners.map(|p| p.as_vec3());
    let bounds = Bounds { low: a.min(b).min(c).min(d), high: a.max(b).max(c).max(d) };
    let primitive = Primitive {
        x: Vec4::new(a.x, b.x, c.x, d.x),
        y: Vec4::new(a.y, b.y, c.y, d.y),
        z: Vec4::new(a.z, b.z, c.z, d.z),
        shade: UVec4::new(normals[0], normals[1], normals[2], kind_and_shape),
        index: UVec4::new(index as u32, 0, 0, 0),
    };
    (primitive, bounds)
}

/// The area in the world; infinite for a plane.
fn area_m2(shape: &Shape<Still>, place: DAffine3) -> f64 {
    match shape {
        Shape::Sphere { radius_m } => ellipsoid_area(place * DAffine3::from_scale(DVec3::splat(*radius_m))),
        Shape::Box { size_m } => box_faces()
            .iter()
            .map(|f| place.transform_vector3(f.x * *size_m).cross(place.transform_vector3(f.y * *size_m)).length())
            .sum(),
        Shape::Quad { frame, size_m } => {
            place.transform_vector3(frame.x * size_m.x).cross(place.transform_vector3(frame.y * size_m.y)).length()
        }
        Shape::Plane { .. } => f64::INFINITY,
        Shape::Mesh(mesh) => mesh_area(mesh, place),
        other => Other::new(other, place).map_or(0.0, |other| other.areas().iter().sum()),
    }
}

fn mesh_area(mesh: &Mesh, place: DAffine3) -> f64 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| place.transform_point3(mesh.positions[v as usize].as_dvec3()));
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles.iter().map(area).sum()
}

// |det M| ∫ |M⁻ᵀ n| over the unit sphere: exact for spheres, by the midpoint rule for ellipsoids.
pub fn ellipsoid_area(place: DAffine3) -> f64 {
    let det = place.matrix3.determinant().abs();
    let by_normal = normal_matrix(place) * det;
    if let Some(radius) = radius_of(place) {
        return 2.0 * TURN * radius * radius;
    }
    let (rows, columns) = (256, 512);
    let mut sum = 0.0;
    for i in 0..rows {
        let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(rows);
        let r = (1.0 - z * z).sqrt();
        for j in 0..columns {
            let phi = TURN * (f64::from(j) + 0.5) / f64::from(columns);
            sum += (by_normal * DVec3::new(r * phi.cos(), r * phi.sin(), z)).length();
        }
    }
    sum * 2.0 * TURN / f64::from(rows * columns)
}

// The radius, if the unit sphere stays a sphere.
fn radius_of(place: DAffine3) -> Option<f64> {
    let m = place.matrix3;
    let product = m.transpose() * m;
    let radius_2 = product.x_axis.x;
    let difference = product - DMat3::from_diagonal(DVec3::splat(radius_2));
    let largest = difference.to_cols_array().iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    (largest <= radius_2 * 1e-9).then(|| radius_2.sqrt())
}

pub fn normal_matrix(place: DAffine3) -> DMat3 {
    place.matrix3.inverse().transpose()
}

pub fn set_transform(record: &mut PackedShape, place: DAffine3) {
    let row = |m: &DAffine3, i: usize| {
        let r = m.matrix3.row(i);
        Vec4::new(r.x as f32, r.y as f32, r.z as f32, m.translation[i] as f32)
    };
    let inverse = place.inverse();
    record.world_from_object_x = row(&place, 0);
    record.world_from_object_y = row(&place, 1);
    record.world_from_object_z = row(&place, 2);
    record.object_from_world_x = row(&inverse, 0);
    record.object_from_world_y = row(&inverse, 1);
    record.object_from_world_z = row(&inverse, 2);
}

// The six faces of a box: each as a quad with that normal.
fn box_faces() -> [Frame; 6] {
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    axes.map(|normal| Frame::facing(normal, DVec3::Y).unwrap_or(Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z }))
}

/// Octahedral, two 16-bit signed fractions (Cigolle et al., JCGT 3(2), 2014). 0 means: no normal, so the direction +z,
/// whose code that would be, takes the one next to it.
pub fn encode_normal(n: Vec3) -> u32 {
    if n == Vec3::ZERO {
        return 0;
    }
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(f32::MIN_POSITIVE);
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let (x, y) = if n.z >= 0.0 { (n.x, n.y) } else { ((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y)) };
    let code = |x: f32| u32::from((x * 32767.0).round() as i16 as u16);
    let packed = code(x) | code(y) << 16;
    if packed == 0 { 1 } else { packed }
}
