//! The same tree as `shaders/bvh.wgsl` reads it: nodes of 80 bytes with boxes of eight bits a coordinate (Ylitie, Karras
//! and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017, §3).

use glam::Vec3;

use super::build::Bounds;
use super::lanes::WIDTH;
use super::tree::{ITEM_KIND, ITEM_NODE, Node, Tree};
use crate::generated::{NONE, PRIMITIVE_KIND, PRIMITIVE_SPHERE, Primitive, Shape};

/// A node: its corner; exponents of its grid and the mask of the children that are nodes; the indices of the first of
/// those and of the first primitive; what each child is; lower and upper x, y, z of each, on the grid.
#[derive(Clone, Copy, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Compressed {
    corner: [f32; 3],
    exponents: [u8; 3],
    inner: u8,
    first_node: u32,
    first_primitive: u32,
    meta: [u8; WIDTH],
    bounds: [[[u8; WIDTH]; 2]; 3],
}

/// Primitives of one child, and of all children of a node, at most.
const MOST_OF_CHILD: u32 = 3;
const MOST_OF_NODE: u32 = 24;

/// What becomes a node.
#[derive(Clone, Copy)]
enum Source {
    Node(u32),
    Leaf { first: u32, count: u32 },
}

/// A child of a node: its slot, its box, and either primitives or what becomes a node.
struct Child {
    slot: usize,
    bounds: Bounds,
    first: u32,
    count: u32,
    source: Source,
}

/// The nodes' bytes, the root first; one empty node where there are none.
pub fn compress(tree: &Tree, primitives: &[Primitive], shapes: &[Shape]) -> Vec<u8> {
    let mut nodes = vec![Compressed::default()];
    let mut waiting = Vec::new();
    if let Some(root) = tree.root {
        waiting.push((0, source(tree, root)));
    }
    while let Some((at, from)) = waiting.pop() {
        let children = match from {
            Source::Node(node) => tree.nodes.get(node as usize).map(|node| of_node(tree, node)).unwrap_or_default(),
            Source::Leaf { first, count } => of_leaf(tree, first, count, primitives, shapes),
        };
        let first_node = nodes.len();
        let (node, inner) = node(&children, first_node as u32);
        nodes[at] = node;
        for (i, source) in inner.into_iter().enumerate() {
            nodes.push(Compressed::default());
            waiting.push((first_node + i, source));
        }
    }
    bytemuck::cast_slice(&nodes).to_vec()
}

fn source(tree: &Tree, item: u32) -> Source {
    if item & ITEM_KIND == ITEM_NODE {
        return Source::Node(item);
    }
    let ids = tree.ids(item);
    Source::Leaf { first: ids[0], count: ids.iter().filter(|&&id| id != NONE).count() as u32 }
}

fn of_node(tree: &Tree, node: &Node) -> Vec<Child> {
    let corner = |slot: usize, side: usize| Vec3::from_array([0, 1, 2].map(|axis| node.bounds[axis][side].0[slot]));
    let mut children: Vec<Child> = (0..WIDTH)
        .map(|slot| Bounds { low: corner(slot, 0), high: corner(slot, 1) })
        .enumerate()
        .filter(|(_, bounds)| bounds.low.x <= bounds.high.x)
        .map(|(slot, bounds)| {
            let source = source(tree, node.items[slot]);
            let (first, count) = match source {
                Source::Leaf { first, count } if count <= MOST_OF_CHILD => (first, count),
                _ => (0, 0),
            };
            // Axes count from the other end there.
            let slot = slot >> 2 & 1 | slot & 2 | (slot & 1) << 2;
            Child { slot, bounds, first, count, source }
        })
        .collect();
    // A node counts its primitives from the first of them.
    let base = children.iter().filter(|child| child.count > 0).map(|child| child.first).min().unwrap_or(0);
    for child in children.iter_mut().filter(|child| child.count > 0) {
        if child.first - base + child.count > MOST_OF_NODE {
            child.count = 0;
        }
    }
    children
}

fn of_leaf(tree: &Tree, first: u32, count: u32, primitives: &[Primitive], shapes: &[Shape]) -> Vec<Child> {
    let mut children = Vec::new();
    for slot in 0..count {
        let Some(primitive) = primitives.get((first + slot) as usize) else { continue };
        let bounds = bounds_of(primitive, shapes, tree.reach);
        let first = first + slot;
        children.push(Child { slot: slot as usize, bounds, first, count: 1, source: Source::Leaf { first, count: 1 } });
    }
    children
}

/// The box of a primitive, wide enough for rounding where the largest coordinate is `reach`.
fn bounds_of(primitive: &Primitive, shapes: &[Shape], reach: f32) -> Bounds {
    let pad = Vec3::splat((reach * 4.0 * f32::EPSILON).max(f32::MIN_POSITIVE));
    if primitive.shade.w & PRIMITIVE_KIND == PRIMITIVE_SPHERE {
        let shape = shapes.get((primitive.shade.w & !PRIMITIVE_KIND) as usize).copied().unwrap_or_default();
        let rows = [shape.world_from_object_x, shape.world_from_object_y, shape.world_from_object_z];
        let (centre, half) =
            (Vec3::from_array(rows.map(|r| r.w)), Vec3::from_array(rows.map(|r| r.truncate().length())));
        return Bounds { low: centre - half - pad, high: centre + half + pad };
    }
    let rows = [primitive.x, primitive.y, primitive.z];
    let (low, high) = (rows.map(|row| row.min_element()), rows.map(|row| row.max_element()));
    Bounds { low: Vec3::from_array(low) - pad, high: Vec3::from_array(high) + pad }
}

// The node of `children`, and those of them that become nodes, the first of which has that index.
fn node(children: &[Child], first_node: u32) -> (Compressed, Vec<Source>) {
    let low = children.iter().fold(Vec3::INFINITY, |low, child| low.min(child.bounds.low));
    let high = children.iter().fold(Vec3::NEG_INFINITY, |high, child| high.max(child.bounds.high));
    let mut node = Compressed { first_node, ..Compressed::default() };
    if children.is_empty() {
        return (node, Vec::new());
    }
    node.corner = low.to_array();
    let own = children.iter().filter(|child| child.count > 0);
    node.first_primitive = own.map(|child| child.first).min().unwrap_or(0);
    for axis in 0..3 {
        let size = (f64::from(high[axis]) - f64::from(low[axis])).max(1e-30);
        let exponent = (size / 255.0).log2().ceil().clamp(-126.0, 127.0);
        node.exponents[axis] = (exponent + 127.0) as u8;
        let step = exponent.exp2();
        let place = |x: f32| (f64::from(x) - f64::from(low[axis])) / step;
        for child in children {
            node.bounds[axis][0][child.slot] = place(child.bounds.low[axis]).floor() as u8;
            node.bounds[axis][1][child.slot] = place(child.bounds.high[axis]).ceil() as u8;
        }
    }
    let mut inner = Vec::new();
    let mut in_order: Vec<&Child> = children.iter().collect();
    in_order.sort_by_key(|child| child.slot);
    for child in in_order {
        if child.count > 0 {
            let unary = (1_u32 << child.count) - 1;
            node.meta[child.slot] = (unary << 5 | (child.first - node.first_primitive)) as u8;
        } else {
            node.inner |= 1 << child.slot;
            node.meta[child.slot] = 0b0010_0000 | (24 + child.slot as u8);
            inner.push(child.source);
        }
    }
    (node, inner)
}
