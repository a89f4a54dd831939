//! The tree that the CPU walks: nodes of eight boxes, and leaves of up to eight primitives of one kind whose numbers lie
//! side by side, so that a node or a leaf is one test in eight lanes.

use super::lanes::{Row, WIDTH};

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

/// The tree.
#[derive(Clone, Debug, Default)]
pub struct Tree {
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
        let mut level: Vec<u32> = self.root.into_iter().filter(|root| root & ITEM_KIND == ITEM_NODE).collect();
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

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.rows.as_slice())
    }

    /// Nodes, and rows of leaves.
    pub fn counts(&self) -> (usize, usize) {
        (self.nodes.len(), self.rows.len())
    }
}
