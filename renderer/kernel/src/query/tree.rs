//! The tree that the CPU walks: nodes of eight boxes, and leaves of up to eight primitives of one kind whose numbers lie
//! side by side, so that a node or a leaf is one test in eight lanes.
//!
//! It is made of a binary tree by choosing which of its nodes to keep, at the least cost by the surface area heuristic
//! (Wald, Benthin and Boulos, "Getting Rid of Packets", RT 2008; the choice by dynamic programming as Ylitie, Karras and
//! Laine do, HPG 2017).

use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;

use super::lanes::{Row, WIDTH, prefetch};
use crate::generated::{NONE, PRIMITIVE_KIND, PRIMITIVE_PARALLELOGRAM, PRIMITIVE_SPHERE, Primitive, Shape};

/// What an item of a node is: its high bits. The others are the index of a node, or of a leaf's first row.
pub const ITEM_KIND: u32 = 0xc000_0000;
/// A node.
pub const ITEM_NODE: u32 = 0;
/// Up to eight triangles: x, y, z of three corners, then their indices.
pub const ITEM_TRIANGLES: u32 = 0x4000_0000;
/// Up to eight parallelograms: x, y, z of four corners, then their indices.
pub const ITEM_PARALLELOGRAMS: u32 = 0x8000_0000;
/// Up to eight spheres: the three rows of the map to the unit sphere, then their indices.
pub const ITEM_SPHERES: u32 = 0xc000_0000;

/// Levels beyond which a walk's stack could overflow.
pub const MAX_LEVELS: u32 = 32;

/// Eight boxes and what is in them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Node {
    /// Lower and upper x, lower and upper y, lower and upper z. A slot without an item has none that a ray could meet.
    pub bounds: [[Row; 2]; 3],
    /// Kind and index.
    pub items: [u32; WIDTH],
}

const EMPTY: Node = {
    let (low, high) = (Row([f32::INFINITY; WIDTH]), Row([f32::NEG_INFINITY; WIDTH]));
    Node { bounds: [[low, high]; 3], items: [0; WIDTH] }
};

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
    levels: u32,
}

/// Up to here a batch of rays tests all primitives.
const FEW: usize = 32;

/// What a leaf costs beside a node.
const LEAF_COST: f32 = 1.0;

impl Tree {
    /// The tree over `primitives` that `binary` is, whose leaves hold one primitive each.
    pub fn new(binary: &Bvh2, primitives: &[Primitive], shapes: &[Shape]) -> Tree {
        let Some(root) = binary.nodes.first() else { return Tree::default() };
        let reach = root.aabb().min.abs().max(root.aabb().max.abs()).max_element();
        let mut tree = Tree { reach, ..Tree::default() };
        let choices = Choices::new(binary, primitives);
        let mut builder = Builder { binary, primitives, shapes, choices, tree: &mut tree };
        builder.build();
        tree
    }

    /// Asks for the memory of an item that will be visited soon.
    #[inline(always)]
    pub(super) fn prefetch(&self, item: u32) {
        let index = (item & !ITEM_KIND) as usize;
        if item & ITEM_KIND == ITEM_NODE {
            prefetch(self.nodes.get(index..=index).unwrap_or_default());
        } else {
            prefetch(self.rows.get(index..index + 10).unwrap_or_default());
        }
    }

    /// Whether a batch of rays had better test all primitives.
    pub(super) fn has_few(&self) -> bool {
        !self.leaves.is_empty()
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.rows.as_slice())
    }

    /// Levels of nodes.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Nodes, and rows of leaves.
    pub fn counts(&self) -> (usize, usize) {
        (self.nodes.len(), self.rows.len())
    }
}

// The kind of an item that holds this primitive.
fn item_kind(primitive: &Primitive) -> u32 {
    match primitive.shade.w & PRIMITIVE_KIND {
        PRIMITIVE_SPHERE => ITEM_SPHERES,
        PRIMITIVE_PARALLELOGRAM => ITEM_PARALLELOGRAMS,
        _ => ITEM_TRIANGLES,
    }
}

/// Roots that a subtree may be represented by, at most, below another node.
const MOST: usize = WIDTH - 1;

/// How a subtree becomes items of a node.
#[derive(Clone, Copy)]
struct Choice {
    /// Of representing it by up to i + 1 items.
    cost: [f32; MOST],
    /// How many of the up to i + 1 items the left child may give; 0: use the choice for one item less.
    left: [u8; MOST],
    /// How many of eight items the left child may give where this is a node; 0: it is a leaf.
    node_left: u8,
    /// Primitives in it, up to WIDTH + 1.
    count: u8,
    /// Of all of them, else ITEM_NODE.
    kind: u32,
}

struct Choices(Vec<Choice>);

impl Choices {
    fn new(binary: &Bvh2, primitives: &[Primitive]) -> Self {
        let empty =
            Choice { cost: [0.0; MOST], left: [0; MOST], node_left: 0, count: 0, kind: ITEM_NODE };
        let mut all = vec![empty; binary.nodes.len()];
        let mut order = Vec::with_capacity(binary.nodes.len());
        order.push(0_u32);
        let mut next = 0;
        while let Some(&i) = order.get(next) {
            let node = &binary.nodes[i as usize];
            if !node.is_leaf() {
                order.extend([node.first_index, node.first_index + 1]);
            }
            next += 1;
        }
        for &i in order.iter().rev() {
            let node = &binary.nodes[i as usize];
            let area = node.aabb().half_area();
            all[i as usize] = if node.is_leaf() {
                let id = binary.primitive_indices[node.first_index as usize];
                let kind = item_kind(&primitives[id as usize]);
                Choice { cost: [area * LEAF_COST; MOST], left: [0; MOST], node_left: 0, count: 1, kind }
            } else {
                let first = node.first_index as usize;
                join(&all[first], &all[first + 1], area)
            };
        }
        Choices(all)
    }

    /// The roots that represent subtree `i` by up to `most` items.
    fn items(&self, binary: &Bvh2, i: u32, most: usize, into: &mut Vec<u32>) {
        let mut waiting = vec![(i, most)];
        while let Some((i, mut most)) = waiting.pop() {
            let choice = &self.0[i as usize];
            while most > 1 && choice.left[most - 1] == 0 {
                most -= 1;
            }
            if most <= 1 {
                into.push(i);
                continue;
            }
            let left = choice.left[most - 1] as usize;
            let first = binary.nodes[i as usize].first_index;
            waiting.extend([(first, left), (first + 1, most - left)]);
        }
    }
}

fn join(l: &Choice, r: &Choice, area: f32) -> Choice {
    let best = |items: usize| {
        (1..items).fold((f32::INFINITY, 0), |best: (f32, u8), left| {
            if left > MOST || items - left > MOST {
                return best;
            }
            let cost = l.cost[left - 1] + r.cost[items - left - 1];
            if cost < best.0 { (cost, left as u8) } else { best }
        })
    };
    let count = (l.count + r.count).min(WIDTH as u8 + 1);
    let kind = if l.kind == r.kind { l.kind } else { ITEM_NODE };
    let (inside, node_left) = best(WIDTH);
    let mut choice = Choice { cost: [inside + area; MOST], left: [0; MOST], node_left, count, kind };
    if count as usize <= WIDTH && kind != ITEM_NODE && area * LEAF_COST <= choice.cost[0] {
        choice.node_left = 0;
        choice.cost = [area * LEAF_COST; MOST];
    }
    for items in 2..=MOST {
        let (cost, left) = best(items);
        choice.cost[items - 1] = choice.cost[items - 2];
        if cost < choice.cost[items - 1] {
            choice.cost[items - 1] = cost;
            choice.left[items - 1] = left;
        }
    }
    choice
}

struct Builder<'a> {
    binary: &'a Bvh2,
    primitives: &'a [Primitive],
    shapes: &'a [Shape],
    choices: Choices,
    tree: &'a mut Tree,
}

impl Builder<'_> {
    fn build(&mut self) {
        let root = self.item(0);
        self.tree.root = Some(root);
        if root & ITEM_KIND != ITEM_NODE {
            return;
        }
        // Nodes of the binary tree, the places of the wide ones, and their levels.
        let mut waiting = vec![(0, root, 1)];
        let mut children = Vec::new();
        while let Some((from, to, level)) = waiting.pop() {
            self.tree.levels = self.tree.levels.max(level);
            children.clear();
            let first = self.binary.nodes[from as usize].first_index;
            let left = self.choices.0[from as usize].node_left as usize;
            self.choices.items(self.binary, first, left, &mut children);
            self.choices.items(self.binary, first + 1, WIDTH - left, &mut children);
            let slots = self.slots(from, &children);
            let mut node = EMPTY;
            for (&child, slot) in children.iter().zip(slots) {
                let bounds = self.binary.nodes[child as usize].aabb();
                for axis in 0..3 {
                    node.bounds[axis][0].0[slot] = bounds.min[axis];
                    node.bounds[axis][1].0[slot] = bounds.max[axis];
                }
                let item = self.item(child);
                node.items[slot] = item;
                if item & ITEM_KIND == ITEM_NODE {
                    waiting.push((child, item, level + 1));
                }
            }
            self.tree.nodes[to as usize] = node;
        }
    }

    // A place for subtree `i`: a node to be filled, or a leaf.
    fn item(&mut self, i: u32) -> u32 {
        let choice = self.choices.0[i as usize];
        if choice.node_left != 0 {
            self.tree.nodes.push(EMPTY);
            return ITEM_NODE | (self.tree.nodes.len() - 1) as u32;
        }
        let place = self.tree.rows.len() as u32;
        let mut ids = [NONE; WIDTH];
        let mut count = 0;
        let mut waiting = vec![i];
        while let Some(i) = waiting.pop() {
            let node = &self.binary.nodes[i as usize];
            if node.is_leaf() {
                ids[count] = self.binary.primitive_indices[node.first_index as usize];
                count += 1;
            } else {
                waiting.extend([node.first_index + 1, node.first_index]);
            }
        }
        let corners = match choice.kind {
            ITEM_TRIANGLES => 3,
            _ => 4,
        };
        let numbers = ids.map(|id| match self.primitives.get(id as usize) {
            None => [0.0; 12],
            Some(p) if choice.kind == ITEM_SPHERES => {
                let shape = self.shapes.get((p.shade.w & !PRIMITIVE_KIND) as usize).copied().unwrap_or_default();
                let rows = [shape.object_from_world_x, shape.object_from_world_y, shape.object_from_world_z];
                std::array::from_fn(|i| rows[i / 4][i % 4])
            }
            Some(p) => std::array::from_fn(|i| [p.x, p.y, p.z][i % 3][i / 3]),
        });
        self.tree.rows.extend((0..3 * corners).map(|i| Row(numbers.map(|n| n[i]))));
        self.tree.rows.push(Row::from_bits(ids));
        let item = choice.kind | place;
        if self.primitives.len() <= FEW {
            let bounds = self.binary.nodes[i as usize].aabb();
            self.tree.leaves.push(Leaf { low: bounds.min.into(), high: bounds.max.into(), item, count });
        }
        item
    }

    // A slot a child: bit i of a slot says whether the child lies to the positive side of axis i, as far as all can.
    fn slots(&self, node: u32, children: &[u32]) -> [usize; WIDTH] {
        let centre = |b: &Aabb| b.center();
        let middle = centre(self.binary.nodes[node as usize].aabb());
        let offsets: Vec<_> =
            children.iter().map(|&c| centre(self.binary.nodes[c as usize].aabb()) - middle).collect();
        let mut slots = [0; WIDTH];
        let (mut placed, mut taken) = ([false; WIDTH], [false; WIDTH]);
        for _ in 0..children.len() {
            let mut best = (f32::NEG_INFINITY, 0, 0);
            for (child, offset) in offsets.iter().enumerate().filter(|&(child, _)| !placed[child]) {
                for slot in (0..WIDTH).filter(|&slot| !taken[slot]) {
                    let along = |bit: usize, x: f32| if slot >> bit & 1 == 1 { x } else { -x };
                    let fit = along(0, offset.x) + along(1, offset.y) + along(2, offset.z);
                    if fit > best.0 {
                        best = (fit, child, slot);
                    }
                }
            }
            let (_, child, slot) = best;
            // Where nothing fits, since numbers overflowed, any free slot will do.
            let (child, slot) = if placed[child] || taken[slot] {
                let free = |all: &[bool; WIDTH]| all.iter().position(|&used| !used).unwrap_or(0);
                (free(&placed), free(&taken))
            } else {
                (child, slot)
            };
            (placed[child], taken[slot], slots[child]) = (true, true, slot);
        }
        slots
    }
}
