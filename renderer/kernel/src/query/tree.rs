//! The tree that the CPU walks: nodes of eight boxes, and leaves of up to eight primitives of one kind whose numbers lie
//! side by side, so that a node or a leaf is one test in eight lanes.

use super::lanes::{Row, WIDTH};
use crate::generated::{NONE, Primitive};

/// What an item of a node is: its high bits. The others are the index of a node, or of a leaf's first row.
pub const ITEM_KIND: u32 = 0xe000_0000;
/// A node.
pub const ITEM_NODE: u32 = 0;
/// Up to eight triangles: x, y, z of three corners, then their indices.
pub const ITEM_TRIANGLES: u32 = 0x2000_0000;
/// Up to eight parallelograms: x, y, z of four corners, then their indices.
pub const ITEM_PARALLELOGRAMS: u32 = 0x4000_0000;
/// Up to eight spheres: the three rows of the map to the unit sphere, then their indices.
pub const ITEM_SPHERES: u32 = 0x6000_0000;
/// Up to eight of PRIMITIVE_OTHER: their indices.
pub const ITEM_OTHERS: u32 = 0x8000_0000;

/// One of OTHER_INSTANCE: its index among the primitives.
pub const ITEM_INSTANCE: u32 = 0xa000_0000;
/// Up to eight spheres that are neither turned nor stretched: the factor and the three offsets of the map to the unit
/// sphere, then their indices. A third of what ITEM_SPHERES reads.
pub const ITEM_BALLS: u32 = 0xc000_0000;

/// A leaf that is not there: rays without a direction visit even empty slots.
pub const NO_ITEM: u32 = ITEM_TRIANGLES | !ITEM_KIND;

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Node {
    /// Lower and upper x, lower and upper y, lower and upper z. A slot without an item has none that a ray could meet.
    pub bounds: [[Row; 2]; 3],
    /// Kind and index; [`NO_ITEM`] in slots without.
    pub items: [u32; WIDTH],
}

impl Node {
    /// Without items.
    pub const EMPTY: Node = {
        let (low, high) = (Row([f32::INFINITY; WIDTH]), Row([f32::NEG_INFINITY; WIDTH]));
        Node { bounds: [[low, high]; 3], items: [NO_ITEM; WIDTH] }
    };
}

/// A leaf with its box.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    pub low: [f32; 3],
    pub high: [f32; 3],
    pub item: u32,
    /// Primitives in it.
    pub count: usize,
}

/// A part of the scene that has a tree of its own, in a space of its own.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// First of its primitives, and how many.
    pub first: u32,
    /// How many primitives it has.
    pub count: u32,
    /// First of its nodes and of its rows.
    node: u32,
    row: u32,
    pub(super) root: Option<u32>,
    pub(super) reach: f32,
}

/// The tree.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// What instances are copies of.
    pub parts: Vec<Part>,
    pub(super) nodes: Vec<Node>,
    pub(super) rows: Vec<Row>,
    pub(super) root: Option<u32>,
    /// The largest coordinate of a box.
    pub(super) reach: f32,
    /// All leaves where there are so few primitives that rays had better test them all.
    pub(super) leaves: Vec<Leaf>,
}

/// Up to here a batch of rays tests all primitives.
pub const FEW: usize = 32;

impl Tree {
    /// Levels of nodes, as far as `most`.
    pub fn levels(&self, most: u32) -> u32 {
        // On its way into a part a walk may leave two groups behind.
        let parts = self.parts.iter().map(|part| self.levels_below(part.root, most) + 2).max();
        self.levels_below(self.root, most) + parts.unwrap_or(0)
    }

    fn levels_below(&self, root: Option<u32>, most: u32) -> u32 {
        let mut level: Vec<u32> = root.into_iter().filter(|root| root & ITEM_KIND == ITEM_NODE).collect();
        let mut levels = 0;
        while !level.is_empty() && levels < most {
            levels += 1;
            let nodes = level.iter().filter_map(|&node| self.nodes.get(node as usize));
            level = nodes.flat_map(|node| node.items).filter(|item| item & ITEM_KIND == ITEM_NODE).collect();
        }
        levels
    }

    /// Whether a batch of rays had better test all primitives.
    pub(super) fn has_few(&self) -> bool {
        !self.leaves.is_empty()
    }

    /// Takes in the tree of a part, whose primitives are those from `first` on.
    pub fn add_part(&mut self, part: Tree, first: u32, count: u32) {
        let Tree { mut nodes, mut rows, root, reach, .. } = part;
        let begin @ [node, row, _] = [self.nodes.len() as u32, self.rows.len() as u32, first];
        let root = relocate((root, &mut nodes, &mut rows), [0; 3], begin);
        self.nodes.append(&mut nodes);
        self.rows.append(&mut rows);
        self.parts.push(Part { first, count, node, row, root, reach });
        // Those who test all primitives do not go into parts.
        self.leaves = Vec::new();
    }

    /// Gives back the trees of all parts, which were taken in last, with their primitives.
    pub fn take_parts(&mut self, primitives: &mut Vec<Primitive>) -> Vec<(Tree, Vec<Primitive>)> {
        let mut trees = Vec::with_capacity(self.parts.len());
        while let Some(Part { first, node, row, root, reach, .. }) = self.parts.pop() {
            let begin = [node, row, first];
            let mut nodes = self.nodes.split_off(self.nodes.len().min(node as usize));
            let mut rows = self.rows.split_off(self.rows.len().min(row as usize));
            let root = relocate((root, &mut nodes, &mut rows), begin, [0; 3]);
            let own = primitives.split_off(primitives.len().min(first as usize));
            trees.push((Tree { nodes, rows, root, reach, ..Tree::default() }, own));
        }
        trees.reverse();
        trees
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.rows.as_slice())
    }

    /// Nodes, and rows of leaves.
    pub fn counts(&self) -> (usize, usize) {
        (self.nodes.len(), self.rows.len())
    }
}

/// Where a tree begins among nodes, rows and primitives.
type Begin = [u32; 3];

/// An item of a tree that begins elsewhere now.
fn moved(item: u32, from: Begin, to: Begin) -> u32 {
    let axis = match item & ITEM_KIND {
        _ if item == NO_ITEM => return NO_ITEM,
        ITEM_NODE => 0,
        _ => 1,
    };
    item & ITEM_KIND | ((item & !ITEM_KIND) - from[axis] + to[axis])
}

/// Has a tree without instances begin elsewhere; gives its root there.
fn relocate((root, nodes, rows): (Option<u32>, &mut [Node], &mut [Row]), from: Begin, to: Begin) -> Option<u32> {
    let mut place = |item: u32| {
        if item & ITEM_KIND != ITEM_NODE && item != NO_ITEM {
            let last = ((item & !ITEM_KIND) - from[1]) as usize + super::build::rows_of(item) - 1;
            if let Some(ids) = rows.get_mut(last) {
                let id = |id: f32| match id.to_bits() {
                    NONE => NONE,
                    id => id - from[2] + to[2],
                };
                *ids = Row::from_bits(ids.0.map(id));
            }
        }
        moved(item, from, to)
    };
    for node in nodes {
        node.items = node.items.map(&mut place);
    }
    // A root that is a leaf is in no node.
    root.map(|root| if root & ITEM_KIND == ITEM_NODE { moved(root, from, to) } else { place(root) })
}
