//! The trees of a picture, made of those of the picture before. A large mesh has a branch to itself: while its place stays,
//! so does its branch; where it moves, only boxes are fitted anew. What is over the branches, and over all that is small, is
//! built again unless it is the same. What comes of it depends on the world alone and not on what was there before.

use std::sync::Arc;

use glam::DAffine3;
use kinora_kernel::Primitive;
use kinora_kernel::Shape as PackedShape;
use kinora_kernel::generated::{PRIMITIVE_KIND, PRIMITIVE_SPHERE, PRIMITIVE_TRIANGLE};
use kinora_kernel::packed::Shared;
use kinora_kernel::query::{Bounds, Plan, Start, Tree};
use kinora_scene::Mesh;
use rayon::prelude::*;

use super::geometry::Triangles;

/// Meshes of so many triangles have a branch to themselves.
const BRANCH_FROM: usize = 1024;
/// Worlds for which a plan is kept that none of them needs: a picture has several moments, and each is a world.
const KEPT_FOR: u32 = 64;
/// Triangles of all plans that are kept so.
const KEPT_TRIANGLES: usize = 2_000_000;

/// What is found once of a mesh.
pub struct Planned {
    mesh: Arc<Mesh>,
    plan: Plan,
    /// In the mesh's own space.
    bounds: Bounds,
}

/// The plans of large meshes.
#[derive(Default)]
pub struct Plans {
    all: Vec<(Arc<Planned>, u32)>,
    /// How many were made since [`Plans::begin`].
    pub made: usize,
}

impl Plans {
    /// Another world: what many worlds did not need goes.
    pub fn begin(&mut self) {
        self.made = 0;
        self.all.sort_by_key(|(_, idle)| *idle);
        let mut triangles = 0;
        self.all.retain_mut(|(planned, idle)| {
            *idle += 1;
            triangles += planned.mesh.triangles.len();
            // What the last world needed stays in any case.
            *idle == 1 || (*idle <= KEPT_FOR && triangles <= KEPT_TRIANGLES)
        });
    }

    /// The plan of a mesh, if it is large.
    pub fn of(&mut self, mesh: &Arc<Mesh>) -> Option<Arc<Planned>> {
        if !is_large(mesh) {
            return None;
        }
        let known = self.all.iter_mut().find(|(known, _)| Arc::ptr_eq(&known.mesh, mesh));
        let known = match known {
            Some(known) => Some(known),
            None => self.all.iter_mut().find(|(known, _)| same_form(&known.mesh, mesh)),
        };
        if let Some((planned, idle)) = known {
            *idle = 0;
            return Some(planned.clone());
        }
        let of = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
            Bounds { low: a.min(b).min(c), high: a.max(b).max(c) }
        };
        let boxes: Vec<Bounds> = mesh.triangles.par_iter().map(of).collect();
        let plan = Plan::new(&boxes)?;
        let bounds = boxes.into_iter().reduce(Bounds::join)?;
        let planned = Arc::new(Planned { mesh: mesh.clone(), plan, bounds });
        self.all.push((planned.clone(), 0));
        self.made += 1;
        Some(planned)
    }
}

/// Whether a mesh has a branch to itself.
pub fn is_large(mesh: &Mesh) -> bool {
    mesh.triangles.len() >= BRANCH_FROM
}

// Whether two meshes have the same triangles, whatever else they have.
fn same_form(a: &Mesh, b: &Mesh) -> bool {
    a.triangles == b.triangles && a.positions == b.positions && a.normals == b.normals
}

/// A large mesh in the world.
#[derive(Clone)]
pub struct Branch {
    pub planned: Arc<Planned>,
    pub place: DAffine3,
    pub shape: u32,
    /// The place of what its vertices have.
    pub vertices: u32,
}

impl Branch {
    /// A box around it, not the smallest.
    pub fn bounds(&self) -> Bounds {
        let rows = [0, 1, 2].map(|i| self.place.matrix3.row(i).extend(self.place.translation[i]));
        self.planned.bounds.placed(rows)
    }

    fn is(&self, other: &Self) -> bool {
        self.is_there(other) && (self.shape, self.vertices) == (other.shape, other.vertices)
    }

    // Whether it is the same mesh in the same place.
    fn is_there(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.planned, &other.planned) && self.place == other.place
    }
}

/// What one tree is over: that of the scene or of a part.
#[derive(Default)]
pub struct Stand {
    /// The largest first.
    branches: Vec<Branch>,
    primitives: Vec<Primitive>,
    bounds: Vec<Bounds>,
    /// What boxes are widened for.
    reach: f32,
    digest: [u64; 2],
}

impl Stand {
    /// Branches, and small primitives with their boxes.
    pub fn new(
        mut branches: Vec<Branch>,
        primitives: Vec<Primitive>,
        mut bounds: Vec<Bounds>,
        shapes: &[PackedShape],
    ) -> Stand {
        branches.sort_by_key(|branch| std::cmp::Reverse(branch.planned.mesh.triangles.len()));
        let size = |b: &Bounds| b.low.abs().max(b.high.abs()).max_element();
        let of_branches = branches.iter().map(|branch| size(&branch.bounds())).fold(0.0, f32::max);
        let reach = bounds.par_iter().map(size).reduce(|| 0.0, f32::max).max(of_branches);
        // In steps, so that what grows a little leaves all others as they are.
        let reach = f32::from_bits((reach.to_bits() | 0x007f_ffff).wrapping_add(1));
        let reach = if reach.is_finite() { reach } else { f32::MAX };
        bounds.par_iter_mut().for_each(|b| *b = b.padded(reach));
        let mut digest = Digest::default();
        digest.add(bytemuck::cast_slice(&primitives));
        for Bounds { low, high } in &bounds {
            digest.add(bytemuck::bytes_of(&[low.to_array(), high.to_array()]));
        }
        for primitive in primitives.iter().filter(|p| p.shade.w & PRIMITIVE_KIND == PRIMITIVE_SPHERE) {
            let shape = shapes.get((primitive.shade.w & !PRIMITIVE_KIND) as usize).copied().unwrap_or_default();
            let rows = [shape.object_from_world_x, shape.object_from_world_y, shape.object_from_world_z];
            digest.add(bytemuck::bytes_of(&rows));
        }
        Stand { branches, primitives, bounds, reach, digest: digest.0 }
    }

    /// The box around it.
    pub fn whole(&self) -> Bounds {
        let own = self.bounds.iter().copied();
        let branches = self.branches.iter().map(|branch| branch.bounds().padded(self.reach));
        own.chain(branches).reduce(Bounds::join).unwrap_or(Bounds { low: Default::default(), high: Default::default() })
    }

    /// The small primitives.
    pub fn primitives(&self) -> &[Primitive] {
        &self.primitives
    }

    /// How many primitives there are in all.
    pub fn len(&self) -> usize {
        self.primitives.len() + self.branches.iter().map(|branch| branch.planned.mesh.triangles.len()).sum::<usize>()
    }

    fn is(&self, other: &Stand) -> bool {
        self.digest == other.digest
            && self.reach == other.reach
            && self.branches.len() == other.branches.len()
            && self.branches.iter().zip(&other.branches).all(|(a, b)| a.is(b))
    }

    /// The tree, of which `tree` and `primitives` are the one over `before`.
    fn grow(&self, before: &Stand, tree: &mut Tree, primitives: &mut Vec<Primitive>, shapes: &[PackedShape]) {
        let pairs = self.branches.iter().zip(&before.branches);
        let common = pairs.take_while(|(new, old)| Arc::ptr_eq(&new.planned, &old.planned)).count();
        let mut starts = vec![Start::default()];
        for branch in &self.branches {
            starts.push(branch.planned.plan.end(*starts.last().unwrap_or(&Start::default())));
        }
        let end = starts.get(common).copied().unwrap_or_default();
        tree.cut(end);
        primitives.truncate(end.primitive);
        for (i, (branch, start)) in self.branches.iter().zip(&starts).enumerate() {
            let old = before.branches[..common].get(i).filter(|_| before.reach == self.reach);
            match old {
                Some(old) if branch.is(old) => {}
                Some(old) if branch.is_there(old) => {
                    let own = start.primitive..branch.planned.plan.end(*start).primitive;
                    primitives[own].par_iter_mut().for_each(|primitive| {
                        primitive.shade.w = branch.shape | PRIMITIVE_TRIANGLE;
                        primitive.index.y = branch.vertices;
                    });
                }
                _ => {
                    let Branch { planned, place, shape, vertices } = branch;
                    let triangles = Triangles::new(&planned.mesh, *place, *shape, *vertices);
                    tree.fit(&planned.plan, *start, primitives, |i| {
                        let (primitive, bounds) = triangles.get(i);
                        (primitive, bounds.padded(self.reach))
                    });
                }
            }
        }
        let roots: Vec<u32> = starts[..self.branches.len()].iter().map(|start| start.node as u32).collect();
        tree.crown(&roots, (&self.primitives, &self.bounds), shapes, primitives);
    }

    // What is only needed while trees grow.
    fn forget(&mut self) {
        (self.primitives, self.bounds) = (Vec::new(), Vec::new());
    }
}

/// What the trees of a picture are over.
#[derive(Default)]
pub struct Grown {
    main: Stand,
    parts: Vec<Stand>,
}

/// A tree and the primitives in the order of its leaves.
pub type Trees = (Shared<Tree>, Shared<Vec<Primitive>>);

impl Grown {
    /// The scene's tree and those of its parts, of which those in `before` are the last that were grown, and whether they
    /// differ from those.
    pub fn grow(
        &mut self,
        main: Stand,
        parts: Vec<Stand>,
        before: Option<Trees>,
        shapes: &[PackedShape],
    ) -> (Trees, bool) {
        let (had, had_parts) = (std::mem::take(&mut self.main), std::mem::take(&mut self.parts));
        let (had, had_parts) = if before.is_some() { (had, had_parts) } else { Default::default() };
        let same_parts = parts.len() == had_parts.len() && parts.iter().zip(&had_parts).all(|(a, b)| a.is(b));
        let grown = match before {
            Some(before) if same_parts && main.is(&had) => (before, false),
            before => {
                let (tree, primitives) = before.unzip();
                let mut tree = tree.map(Shared::into_inner).unwrap_or_default();
                let mut primitives = primitives.map(Shared::into_inner).unwrap_or_default();
                let mut old: Vec<_> = tree.take_parts(&mut primitives).into_iter().map(Some).collect();
                main.grow(&had, &mut tree, &mut primitives, shapes);
                for part in &parts {
                    let found = had_parts.iter().zip(&mut old).find(|(had, tree)| tree.is_some() && part.is(had));
                    let (own, mut its) = found.and_then(|(_, tree)| tree.take()).unwrap_or_else(|| {
                        let (mut own, mut its) = (Tree::default(), Vec::new());
                        part.grow(&Stand::default(), &mut own, &mut its, shapes);
                        (own, its)
                    });
                    let (first, count) = (primitives.len() as u32, its.len() as u32);
                    tree.add_part(own, first, count);
                    primitives.append(&mut its);
                }
                if primitives.is_empty() {
                    // A GPU cannot bind nothing.
                    primitives.push(Primitive::default());
                }
                ((tree.into(), primitives.into()), true)
            }
        };
        (self.main, self.parts) = (main, parts);
        self.main.forget();
        self.parts.iter_mut().for_each(Stand::forget);
        grown
    }
}

/// A number of 128 bits that tells bytes apart, almost surely.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Digest([u64; 2]);

impl Default for Digest {
    fn default() -> Self {
        Self([0x9e37_79b9_7f4a_7c15, 0xd1b5_4a32_d192_ed03])
    }
}

impl Digest {
    pub fn add(&mut self, bytes: &[u8]) {
        let [a, b] = &mut self.0;
        let (words, rest) = bytes.as_chunks::<8>();
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        for word in words.iter().chain(std::iter::once(&last).filter(|_| !rest.is_empty())) {
            let word = u64::from_le_bytes(*word);
            *a = (*a ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(29);
            *b = (*b ^ word.rotate_left(32)).wrapping_mul(0xc4ce_b9fe_1a85_ec53).rotate_left(31);
        }
        *a ^= bytes.len() as u64;
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::TAU;

    use glam::{DVec3, Vec3};
    use kinora_kernel::Packed;
    use kinora_scene::{Copied, Instance, Part, Shape, World};

    use super::*;
    use crate::pack::{Changes, Packer};
    use crate::suite::{add, diffuse, many_copies, view, world};

    /// A ring with waves, of `2 n²` triangles.
    fn ring(n: u32, waves: f32) -> Arc<Mesh> {
        let point = |i: u32| {
            let (u, v) = ((i % n) as f32 / n as f32 * TAU, (i / n) as f32 / n as f32 * TAU);
            let r = 0.3 + 0.05 * (waves * u).sin() * (3.0 * v).cos();
            Vec3::new((1.0 + r * v.cos()) * u.cos(), r * v.sin(), (1.0 + r * v.cos()) * u.sin())
        };
        let square = |i: u32| {
            let (x, y) = (i % n, i / n);
            let at = |x: u32, y: u32| y % n * n + x % n;
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [[a, c, b], [a, d, c]]
        };
        let positions: Vec<Vec3> = (0..n * n).map(point).collect();
        let triangles = (0..n * n).flat_map(square).collect();
        let mut mesh = Mesh { positions, triangles, ..Mesh::default() };
        mesh.normals = mesh.smooth_normals();
        Arc::new(mesh)
    }

    fn at(x: f64, y: f64, z: f64) -> DAffine3 {
        DAffine3::from_translation(DVec3::new(x, y, z))
    }

    fn mesh(world: &mut World, mesh: &Arc<Mesh>, place: DAffine3) {
        add(world, Shape::Mesh(mesh.clone()), place, diffuse(0.5, 0.0));
    }

    /// Copies, some small shapes, and rings that reach into one another.
    fn scene(rings: &[Arc<Mesh>]) -> World {
        let mut w =
            World { materials: Vec::new(), ..world([8, 8], 1, view(DVec3::new(1.0, 2.0, 6.0), DVec3::ZERO, 0.7)) };
        let copies = many_copies();
        (w.parts, w.copies, w.materials) = (copies.parts, copies.copies, copies.materials);
        for (i, ring) in rings.iter().enumerate() {
            mesh(&mut w, ring, at(0.7 * i as f64, 0.1, 0.0) * DAffine3::from_rotation_x(i as f64));
        }
        add(&mut w, Shape::Sphere { radius_m: 0.5 }, at(0.0, 0.0, 0.0), diffuse(0.8, 0.0));
        add(&mut w, Shape::Sphere { radius_m: 0.3 }, at(1.0, 0.4, 0.5), diffuse(0.8, 0.0));
        add(&mut w, Shape::Box { size_m: DVec3::ONE }, at(-1.0, 0.0, 0.0), diffuse(0.3, 0.0));
        let part = w.parts.len();
        w.parts.push(Part {
            instances: vec![Instance {
                node: 0,
                shape: Shape::Mesh(rings[0].clone()),
                world_from_object: at(0.0, 1.0, 0.0),
                next: None,
                next_mesh: None,
                material: 0,
            }],
            ..Part::default()
        });
        let places = vec![at(3.0, 0.0, 0.0), at(-3.0, 0.5, 1.0)];
        w.copies.push(Copied { node: 0, first: 900, part, places, next: Vec::new(), material: None });
        w
    }

    #[track_caller]
    fn check(packer: &mut Packer, before: &mut Option<Packed>, world: &World, names: &[&str]) {
        let (packed, changes) = packer.prepare(world).unwrap().finish(before.take()).unwrap();
        let (fresh, _) = Packer::default().prepare(world).unwrap().finish(None).unwrap();
        assert_eq!(bytemuck::bytes_of(&packed.params), bytemuck::bytes_of(&fresh.params));
        // As text, since indices among rows are no numbers.
        assert!(format!("{:?}", *packed.tree) == format!("{:?}", *fresh.tree), "the trees differ");
        assert!(*packed.primitives == *fresh.primitives, "the primitives differ");
        assert!(*packed.shapes == *fresh.shapes && *packed.materials == *fresh.materials);
        assert!(*packed.lights == *fresh.lights && *packed.words == *fresh.words && *packed.tables == *fresh.tables);
        packed.validate().unwrap();
        match names {
            ["tree", "and more"] => assert!(changes.tree && changes.transforms && !changes.meshes && !changes.camera),
            names => assert_eq!(changes.names(), names),
        }
        *before = Some(packed);
    }

    #[test]
    fn what_is_kept_is_what_would_be_made() {
        let rings = [ring(32, 5.0), ring(40, 7.0), ring(25, 2.0)];
        let (mut packer, mut before) = (Packer::default(), None);
        let check = |packer: &mut Packer, before: &mut Option<Packed>, world: &World, names: &[&str]| {
            check(packer, before, world, names);
        };
        let mut w = scene(&rings);
        check(&mut packer, &mut before, &w, &Changes::ALL.names());
        check(&mut packer, &mut before, &w, &[]);
        w.materials[0] = diffuse(0.1, 0.0);
        check(&mut packer, &mut before, &w, &["materials"]);
        w.view.world_from_camera.translation.y += 0.5;
        check(&mut packer, &mut before, &w, &["camera"]);
        // A small shape, then a large mesh, then a copy.
        w.instances[3].world_from_object = at(0.0, 0.1, 0.0);
        check(&mut packer, &mut before, &w, &["tree", "transforms"]);
        w.instances[1].world_from_object = at(0.5, 0.1, 0.0) * DAffine3::from_rotation_z(0.5);
        check(&mut packer, &mut before, &w, &["tree", "transforms"]);
        w.copies.last_mut().unwrap().places[0] = at(3.0, 0.2, 0.0);
        check(&mut packer, &mut before, &w, &["tree", "transforms"]);
        // The form of a mesh, and one that comes from elsewhere with the same form.
        w.instances[2].shape = Shape::Mesh(ring(25, 4.0));
        check(&mut packer, &mut before, &w, &["meshes", "tree"]);
        w.instances[2].shape = Shape::Mesh(ring(25, 4.0));
        check(&mut packer, &mut before, &w, &[]);
        // Small shapes and large meshes come and go.
        let gone = w.instances.remove(4);
        check(&mut packer, &mut before, &w, &["tree", "and more"]);
        w.instances.insert(0, gone);
        check(&mut packer, &mut before, &w, &["tree", "and more"]);
        w.instances.remove(1);
        check(&mut packer, &mut before, &w, &["tree", "and more"]);
        // Far away: all boxes are wider.
        w.instances[0].world_from_object = at(0.0, 900.0, 0.0);
        check(&mut packer, &mut before, &w, &["tree", "and more"]);
        w.copies.pop();
        check(&mut packer, &mut before, &w, &["tree", "and more"]);
        w.instances.clear();
        w.copies.clear();
        check(&mut packer, &mut before, &w, &["tree", "and more"]);
    }

    // Where boxes are fitted to a mesh that was turned, rays find what they find in a tree made for it.
    #[test]
    fn a_branch_hides_nothing() {
        let rings = [ring(32, 5.0), ring(40, 7.0)];
        let (packed, _) = Packer::default().prepare(&scene(&rings)).unwrap().finish(None).unwrap();
        let mut plain = packed.clone();
        let count = packed.params.primitive_count as usize;
        plain.primitives.truncate(count);
        plain.tree = Tree::default().into();
        let mut own = packed.primitives[..count].to_vec();
        own.retain(|p| p.shade.w & PRIMITIVE_KIND == PRIMITIVE_TRIANGLE);
        let bounds = |p: &Primitive| {
            let rows = [p.x, p.y, p.z];
            let (low, high) = (rows.map(|row| row.min_element()), rows.map(|row| row.max_element()));
            Bounds { low: low.into(), high: high.into() }.padded(4.0)
        };
        let boxes: Vec<Bounds> = own.iter().map(bounds).collect();
        *plain.tree = kinora_kernel::query::build(&mut own, &boxes, &packed.shapes);
        *plain.primitives = own;
        let mut hits = 0;
        for i in 0..4000_u32 {
            let t = i as f32;
            let o = Vec3::new((t * 0.37).sin() * 3.0, (t * 0.11).cos() * 3.0, (t * 0.53).cos() * 3.0);
            let target = Vec3::new((t * 0.71).cos(), 0.3 * (t * 0.29).sin(), (t * 0.13).sin());
            let d = (target - o).normalize();
            let found =
                |packed: &Packed| packed.with_kernel(|k| kinora_kernel::query::bvh_closest(k, o, d, 1e10, u32::MAX));
            let (a, b) = (found(&packed), found(&plain));
            let triangle =
                |packed: &Packed, id: u32| packed.primitives.get(id as usize).map(|p| (p.shade.w, p.index.x));
            // Other shapes may lie before it.
            let is_triangle =
                triangle(&packed, a.id).is_some_and(|(shade, _)| shade & PRIMITIVE_KIND == PRIMITIVE_TRIANGLE);
            if is_triangle && a.instance == u32::MAX {
                assert_eq!((a.t, triangle(&packed, a.id)), (b.t, triangle(&plain, b.id)), "ray {i}");
                hits += 1;
            } else {
                assert!(a.t <= b.t, "ray {i}");
            }
        }
        assert!(hits > 500, "{hits}");
    }
}
