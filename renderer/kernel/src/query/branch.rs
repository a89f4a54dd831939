//! The branch of a tree over one mesh. Which triangles go together is found once, in the mesh's own space; placed in the
//! world, the boxes are fitted to where the triangles are. So a mesh that moves costs a pass over its triangles, and one
//! that stays costs nothing.

use glam::Vec4;
use rayon::prelude::*;

use super::build::{Bounds, Draft, Extent, Item, NORMAL, Part, fill, nodes, slots};
use super::lanes::{Row, WIDTH};
use super::tree::{ITEM_KIND, ITEM_NODE, ITEM_TRIANGLES, NO_ITEM, Node, Tree};
use crate::generated::Primitive;

/// Rows of a leaf of triangles.
const ROWS: usize = 10;

/// Which triangles of a mesh go together.
pub struct Plan {
    /// Each before what is in it, the root first; leaves are numbers in `leaves`.
    items: Vec<[u32; WIDTH]>,
    /// First of the triangles in `order`, and how many.
    leaves: Vec<(u32, u8)>,
    order: Vec<u32>,
}

/// Where the branch of a mesh begins: among nodes, rows and primitives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Start {
    /// Its root.
    pub node: usize,
    /// The first row of its first leaf.
    pub row: usize,
    /// Its first triangle.
    pub primitive: usize,
}

impl Plan {
    /// Sorts triangles by their boxes, of which there must be more than eight: none of fewer.
    pub fn new(bounds: &[Bounds]) -> Option<Plan> {
        let item = |(i, b): (usize, &Bounds)| Item {
            low: b.low.extend(f32::from_bits(NORMAL | i as u32)).to_array(),
            high: b.high.extend(f32::from_bits(ITEM_TRIANGLES)).to_array(),
        };
        let mut items: Vec<Item> = bounds.par_iter().enumerate().map(item).collect();
        if items.len() <= WIDTH {
            return None;
        }
        let root = Part::new(&items, 0);
        let drafts = nodes(&mut items, root, 1);
        let mut plan = Plan { items: Vec::with_capacity(drafts.len()), leaves: Vec::new(), order: Vec::new() };
        plan.order.reserve_exact(items.len());
        for Draft { node, leaves } in drafts {
            plan.items.push(std::array::from_fn(|slot| match leaves[slot] {
                (_, 0) => node.items[slot],
                (first, count) => {
                    let first = first as usize;
                    plan.leaves.push((plan.order.len() as u32, count));
                    plan.order.extend(items[first..first + count as usize].iter().map(Item::id));
                    ITEM_TRIANGLES | (plan.leaves.len() - 1) as u32
                }
            }));
        }
        Some(plan)
    }

    /// Where what comes behind a branch at `start` begins.
    pub fn end(&self, start: Start) -> Start {
        Start {
            node: start.node + self.items.len(),
            row: start.row + self.leaves.len() * ROWS,
            primitive: start.primitive + self.order.len(),
        }
    }
}

impl Tree {
    /// Writes the branch of a mesh to `start`; `triangle` gives each of its triangles and its box. What was there before
    /// must have been a branch of the same plan, or nothing: then it is added.
    pub fn fit(
        &mut self,
        plan: &Plan,
        start: Start,
        primitives: &mut Vec<Primitive>,
        triangle: impl Fn(usize) -> (Primitive, Bounds) + Sync,
    ) {
        let end = plan.end(start);
        if self.nodes.len() < end.node {
            self.nodes.resize(end.node, Node::EMPTY);
        }
        if self.rows.len() < end.row {
            self.rows.resize(end.row, Row::default());
        }
        if primitives.len() < end.primitive {
            primitives.resize(end.primitive, Primitive::default());
        }
        let primitives = &mut primitives[start.primitive..end.primitive];
        let write = |(into, i): (&mut Primitive, &u32)| {
            let (primitive, bounds) = triangle(*i as usize);
            *into = primitive;
            bounds
        };
        let bounds: Vec<Bounds> = primitives.par_iter_mut().zip(&plan.order).map(write).collect();
        let primitives = &*primitives;
        let leaf = |(rows, &(first, count)): (&mut [Row], &(u32, u8))| {
            let own = first as usize..first as usize + count as usize;
            fill(rows, ITEM_TRIANGLES, start.primitive + own.start, &primitives[own.clone()], &[]);
            bounds[own].iter().fold(Extent::EMPTY, |extent, b| {
                extent.join(Extent { low: b.low.extend(0.0), high: b.high.extend(0.0) })
            })
        };
        let rows = self.rows[start.row..end.row].par_chunks_exact_mut(ROWS);
        let leaves: Vec<Extent> = rows.zip(&plan.leaves).with_min_len(256).map(leaf).collect();
        // From the leaves up.
        let mut extents = vec![Extent::EMPTY; plan.items.len()];
        let of = |extents: &[Extent], item: u32| match item & ITEM_KIND {
            ITEM_NODE => extents[item as usize],
            _ => leaves[(item & !ITEM_KIND) as usize],
        };
        for i in (0..plan.items.len()).rev() {
            let below = plan.items[i].iter().filter(|item| **item != NO_ITEM);
            extents[i] = below.map(|&item| of(&extents, item)).fold(Extent::EMPTY, Extent::join);
        }
        let centre = |extent: Extent| -> Vec4 { extent.low + extent.high };
        let place = |(i, node): (usize, &mut Node)| {
            *node = Node::EMPTY;
            let below = plan.items[i].iter().copied().filter(|item| *item != NO_ITEM);
            let centres = below.clone().map(|item| centre(of(&extents, item)));
            for (item, slot) in below.zip(slots(centre(extents[i]), centres)) {
                let extent = of(&extents, item);
                for axis in 0..3 {
                    node.bounds[axis][0].0[slot] = extent.low[axis];
                    node.bounds[axis][1].0[slot] = extent.high[axis];
                }
                node.items[slot] = match item & ITEM_KIND {
                    ITEM_NODE => item + start.node as u32,
                    _ => ITEM_TRIANGLES | (start.row + (item & !ITEM_KIND) as usize * ROWS) as u32,
                };
            }
        };
        self.nodes[start.node..end.node].par_iter_mut().enumerate().with_min_len(256).for_each(place);
    }

    /// Takes away what comes behind the branches that end here.
    pub fn cut(&mut self, end: Start) {
        self.nodes.truncate(end.node);
        self.rows.truncate(end.row);
        self.parts.clear();
        (self.root, self.leaves) = (None, Vec::new());
    }
}
