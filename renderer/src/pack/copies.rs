//! Parts of the scene that are there many times: a part's shapes lie once in a tree of their own, and each copy is one
//! primitive of the scene's tree. What cannot be shared is written out for every copy: lamps, shapes that shine, since
//! lights are chosen one by one, and infinite planes, which stand beside the tree.

use std::collections::HashMap;

use glam::{DAffine3, UVec4};
use kinora_kernel::generated::{NONE, OTHER_INSTANCE, PRIMITIVE_OTHER};
use kinora_kernel::query::Bounds;
use kinora_kernel::{Primitive, Shape as PackedShape};
use kinora_scene::{Beam, Copied, Instance, Lamp, LightKind, Shape, World};

use super::PackError;
use super::geometry::{Geometry, set_transform};
use super::grow::Stand;

/// Copies of a picture.
const MAX_COPIES: usize = 10_000_000;
/// Shapes and lamps that are written out for their copies.
const MAX_WRITTEN: usize = 4_000_000;
/// Parts inside one another.
const MAX_LEVELS: u32 = 64;

/// A part with what it is made of, if not of its own materials.
type Key = (usize, Option<usize>);

/// One copy of a part's tree.
pub struct Copy {
    key: Key,
    place: DAffine3,
    /// The same at the next frame; `None`: it stays.
    next: Option<DAffine3>,
    /// What it is called where pictures show which thing is seen.
    id: usize,
    /// The scene's node that shows it.
    node: usize,
}

/// The copies of copies, one by one.
#[derive(Default)]
pub struct Unfolded {
    pub copies: Vec<Copy>,
    /// What is written out.
    pub instances: Vec<Instance>,
    pub lights: Vec<Lamp>,
}

/// Follows copies into the parts that they are of. `shines`: whether each of the world's materials does.
///
/// # Errors
/// There are too many.
pub fn unfold(world: &World, shines: &[bool]) -> Result<Unfolded, PackError> {
    let mut all = Unfolded::default();
    for copied in &world.copies {
        for (k, place) in copied.places.iter().enumerate() {
            let place = (*place, copied.next.get(k).copied());
            follow(&mut all, world, shines, copied, place, (copied.first + k, copied.material), 0)?;
        }
    }
    Ok(all)
}

fn follow(
    all: &mut Unfolded,
    world: &World,
    shines: &[bool],
    copied: &Copied,
    (place, next): (DAffine3, Option<DAffine3>),
    (id, material): (usize, Option<usize>),
    level: u32,
) -> Result<(), PackError> {
    let Some(part) = world.parts.get(copied.part) else { return Ok(()) };
    if level > MAX_LEVELS || all.copies.len() >= MAX_COPIES {
        return Err(PackError::Copies { limit: MAX_COPIES });
    }
    if part.instances.iter().any(|instance| is_shared(instance, material, shines)) {
        all.copies.push(Copy { key: (copied.part, material), place, next, id, node: copied.node });
    }
    for instance in part.instances.iter().filter(|instance| !is_shared(instance, material, shines)) {
        all.instances.push(Instance {
            node: id,
            shape: instance.shape.clone(),
            world_from_object: place * instance.world_from_object,
            next: either(next, place, instance.next, instance.world_from_object),
            next_mesh: instance.next_mesh.clone(),
            material: material.unwrap_or(instance.material),
        });
    }
    all.lights.extend(part.lights.iter().map(|lamp| {
        let to = either(next, place, lamp.next, DAffine3::IDENTITY);
        Lamp { next: to.filter(|to| *to != place).map(|to| to * place.inverse()), ..carried(lamp, place) }
    }));
    if all.instances.len() + all.lights.len() > MAX_WRITTEN {
        return Err(PackError::Copies { limit: MAX_WRITTEN });
    }
    for inner in &part.copies {
        for (k, at) in inner.places.iter().enumerate() {
            let place = (place * *at, either(next, place, inner.next.get(k).copied(), *at));
            follow(all, world, shines, inner, place, (id, material.or(inner.material)), level + 1)?;
        }
    }
    Ok(())
}

/// Where what is placed by `inner` in what is placed by `outer` is at the next frame, if one of them moves.
fn either(
    outer_next: Option<DAffine3>,
    outer: DAffine3,
    inner_next: Option<DAffine3>,
    inner: DAffine3,
) -> Option<DAffine3> {
    let moves = outer_next.is_some() || inner_next.is_some();
    moves.then(|| outer_next.unwrap_or(outer) * inner_next.unwrap_or(inner))
}

fn is_shared(instance: &Instance, material: Option<usize>, shines: &[bool]) -> bool {
    let shines = shines.get(material.unwrap_or(instance.material)) == Some(&true);
    !shines && !matches!(instance.shape, Shape::Plane { .. })
}

/// A lamp of a part where a copy is.
fn carried(lamp: &Lamp, place: DAffine3) -> Lamp {
    let mut lamp = lamp.clone();
    let size = place.matrix3.determinant().abs().cbrt();
    let turn = |v: &mut glam::DVec3| *v = place.transform_vector3(*v).try_normalize().unwrap_or(*v);
    match &mut lamp.light.kind {
        LightKind::Sun { direction, .. } => turn(direction),
        LightKind::Point { position, radius_m, .. } => {
            *position = place.transform_point3(*position);
            *radius_m *= size;
        }
        LightKind::Spot { position, radius_m, aim, .. } => {
            *position = place.transform_point3(*position);
            *radius_m *= size;
            if let Beam::Direction(direction) = aim {
                turn(direction);
            }
        }
    }
    lamp
}

/// Adds a primitive for each copy, and the shapes of the parts. Gives what the trees of the parts are over.
///
/// # Errors
/// What a part's shapes may have; a copy lies outside of what single precision can hold.
pub fn add(geometry: &mut Geometry, world: &World, copies: Vec<Copy>) -> Result<Vec<Stand>, PackError> {
    let mut parts: Vec<Stand> = Vec::new();
    let mut known: HashMap<Key, (usize, Bounds)> = HashMap::new();
    geometry.primitives.reserve(copies.len());
    geometry.shapes.reserve(copies.len());
    for copy in copies {
        let (part, bounds) = match known.get(&copy.key) {
            Some(found) => *found,
            None => {
                let part = part_of(geometry, world, copy.key)?;
                let bounds = part.whole();
                parts.push(part);
                *known.entry(copy.key).or_insert((parts.len() - 1, bounds))
            }
        };
        let mut record = PackedShape::default();
        set_transform(&mut record, copy.place);
        record.index = UVec4::new(0, NONE, NONE, copy.id as u32);
        let rows = [0, 1, 2].map(|i| copy.place.matrix3.row(i).extend(copy.place.translation[i]));
        let bounds = bounds.placed(rows);
        let rows = [record.object_from_world_x, record.object_from_world_y, record.object_from_world_z];
        if super::geometry::is_far(bounds.low)
            || super::geometry::is_far(bounds.high)
            || rows.iter().any(|row| !row.is_finite())
        {
            return Err(PackError::Coordinates { node: copy.node });
        }
        geometry.bounds.push(bounds);
        geometry.primitives.push(Primitive {
            shade: UVec4::new(0, 0, 0, geometry.shapes.len() as u32 | PRIMITIVE_OTHER),
            index: UVec4::new(part as u32, 0, OTHER_INSTANCE, 0),
            ..Primitive::default()
        });
        geometry.push(record, copy.place, copy.next, None);
    }
    Ok(parts)
}

/// The shapes of a part that its copies share.
fn part_of(geometry: &mut Geometry, world: &World, (part, material): Key) -> Result<Stand, PackError> {
    let (first, first_branch) = (geometry.primitives.len(), geometry.branches.len());
    let instances = world.parts.get(part).map_or(&[][..], |part| &part.instances);
    for instance in instances {
        if !is_shared(instance, material, &geometry.shines) {
            continue;
        }
        match material {
            Some(material) => geometry.add(&Instance { material, ..instance.clone() }, world)?,
            None => geometry.add(instance, world)?,
        }
    }
    let primitives = geometry.primitives.split_off(first);
    let bounds = geometry.bounds.split_off(first);
    Ok(Stand::new(geometry.branches.split_off(first_branch), primitives, bounds, &geometry.shapes))
}
