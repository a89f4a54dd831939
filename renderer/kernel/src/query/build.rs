//! Builds the tree from the top: items are halved where the surface area heuristic says, over a few bins an axis (Wald,
//! "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007). Large parts become nodes by halving their
//! largest part again until there are eight, all of them side by side on all cores. A small part is halved down to single
//! items first; which of its halves to keep as nodes is then chosen at the least cost (Ylitie, Karras and Laine, HPG
//! 2017, §4.1). The result does not depend on the cores.

use glam::{DVec4, Vec3, Vec4};
use rayon::prelude::*;

use super::lanes::{Row, WIDTH};
use super::tree::{
    FEW, ITEM_BALLS, ITEM_INSTANCE, ITEM_KIND, ITEM_NODE, ITEM_OTHERS, ITEM_PARALLELOGRAMS, ITEM_SPHERES,
    ITEM_TRIANGLES, Leaf, NO_ITEM, Node, Tree,
};
use crate::generated::{
    NONE, OTHER_CAPSULE, OTHER_CONE, OTHER_CYLINDER, OTHER_DISK, OTHER_FUNNEL, OTHER_INSTANCE, OTHER_TUBE,
    PRIMITIVE_KIND, PRIMITIVE_OTHER, PRIMITIVE_PARALLELOGRAM, PRIMITIVE_SPHERE, Primitive, Shape,
};

/// The box of a primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least coordinates.
    pub low: Vec3,
    /// Greatest coordinates.
    pub high: Vec3,
}

impl Bounds {
    /// The box of one of PRIMITIVE_OTHER, not widened; `rows` are those of the map from its own space to the world.
    pub fn of_other(primitive: &Primitive, rows: [DVec4; 3]) -> Self {
        let size = f64::from(primitive.x.x);
        // How far the shape reaches along each axis of the world: its support function of the rows.
        let ends = rows.map(|row| {
            let (whole, across, up) = (row.truncate().length(), row.x.hypot(row.z), row.y);
            let (low, high) = match primitive.index.z {
                OTHER_DISK => (-across, across),
                OTHER_CYLINDER | OTHER_TUBE => (-across - up.abs(), across + up.abs()),
                OTHER_CONE | OTHER_FUNNEL => (f64::min(0.0, -up - across), f64::max(0.0, across - up)),
                OTHER_CAPSULE => (-whole - size * up.abs(), whole + size * up.abs()),
                _ => (-across - size * whole, across + size * whole),
            };
            (row.w + low, row.w + high)
        });
        Bounds {
            low: Vec3::from_array(ends.map(|(low, _)| low as f32)),
            high: Vec3::from_array(ends.map(|(_, high)| high as f32)),
        }
    }

    /// Both, and what lies between.
    #[must_use]
    pub fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box around this one after an affine map, not widened; `rows` are those of the map.
    #[must_use]
    pub fn placed(self, rows: [DVec4; 3]) -> Self {
        let (middle, half) =
            (self.low.as_dvec3().midpoint(self.high.as_dvec3()), (self.high - self.low).as_dvec3() * 0.5);
        let ends = rows.map(|row| {
            let (at, reach) = (row.truncate().dot(middle) + row.w, row.truncate().abs().dot(half));
            (at - reach, at + reach)
        });
        Bounds {
            low: Vec3::from_array(ends.map(|(low, _)| low as f32)),
            high: Vec3::from_array(ends.map(|(_, high)| high as f32)),
        }
    }

    /// Widened by what rounding in a ray's test of a box may cost where the largest coordinate is `reach`, so that no ray
    /// slips between two of them.
    #[must_use]
    pub fn padded(self, reach: f32) -> Self {
        let pad = Vec3::splat((reach * 4.0 * f32::EPSILON).max(f32::MIN_POSITIVE));
        Self { low: self.low - pad, high: self.high + pad }
    }
}

/// A primitive under sorting: its box, and beside it as bits of a normal float, so that arithmetic on all four lanes is
/// never slow, the index in `low` and the kind in `high`.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(super) struct Item {
    pub low: [f32; 4],
    pub high: [f32; 4],
}

pub(super) const NORMAL: u32 = 0x4000_0000;

/// A node of a branch, until it has its place.
const ITEM_BOUGH: u32 = 0xe000_0000;

impl Item {
    pub fn id(&self) -> u32 {
        self.low[3].to_bits() & !NORMAL
    }

    fn kind(&self) -> u32 {
        self.high[3].to_bits()
    }

    fn extent(&self) -> Extent {
        Extent { low: Vec4::from_array(self.low), high: Vec4::from_array(self.high) }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub low: Vec4,
    pub high: Vec4,
}

impl Extent {
    pub const EMPTY: Extent = Extent { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    pub fn join(self, other: Extent) -> Extent {
        Extent { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn with(self, p: Vec4) -> Extent {
        Extent { low: self.low.min(p), high: self.high.max(p) }
    }

    fn half_area(&self) -> f32 {
        let d = self.high - self.low;
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// A range of items that is to become a node or a leaf.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub first: usize,
    pub end: usize,
    /// Of the boxes.
    pub extent: Extent,
    /// Of twice the centres.
    centres: Extent,
    /// Of all items, else ITEM_NODE.
    kind: u32,
}

impl Part {
    pub fn new(items: &[Item], first: usize) -> Part {
        let mut part =
            Part { first, end: first + items.len(), extent: Extent::EMPTY, centres: Extent::EMPTY, kind: ITEM_NODE };
        part.kind = items.first().map_or(ITEM_NODE, |item| item.kind() & ITEM_KIND);
        for item in items {
            let extent = item.extent();
            part.extent = part.extent.join(extent);
            part.centres = part.centres.with(extent.low + extent.high);
            if item.kind() & ITEM_KIND != part.kind {
                part.kind = ITEM_NODE;
            }
        }
        part
    }

    fn len(&self) -> usize {
        self.end - self.first
    }

    fn is_leaf(&self) -> bool {
        self.len() <= self.most(WIDTH) && self.kind != ITEM_NODE
    }

    // How many of its items may be left together where others may be so many: instances and boughs are items of their own.
    fn most(&self, others: usize) -> usize {
        if self.kind == ITEM_INSTANCE || self.kind == ITEM_BOUGH { 1 } else { others }
    }
}

/// A node's eight items while their places are not known: a subtree's own nodes are numbered from 0, and what is in a
/// leaf is a range of items.
pub(super) struct Draft {
    pub node: Node,
    /// First item and how many, of leaves.
    pub leaves: [(u32, u8); WIDTH],
}

/// Below this level of nodes, or of halves in a small part, parts are halved by count, so that no tree is deep.
const SAFE_LEVEL: u32 = 8;
const SAFE_HALVES: u32 = 20;
/// Parts of fewer items are small.
const GRAIN: usize = 4096;
const MOST_BINS: usize = 16;

/// The tree over `primitives`, whose boxes are `bounds`. Puts `primitives` into the order of its leaves.
pub fn build(primitives: &mut Vec<Primitive>, bounds: &[Bounds], shapes: &[Shape]) -> Tree {
    let mut tree = Tree::default();
    let own = std::mem::take(primitives);
    tree.crown(&[], (&own, bounds), shapes, primitives);
    tree
}

/// Items that branches may be in the nodes above them: some, and some more for each.
const CUT: usize = 32;
const CUT_EACH: usize = 8;

/// A branch as an item of the nodes above it, or a part of one.
struct Bough {
    low: [f32; 3],
    high: [f32; 3],
    node: u32,
}

impl Bough {
    fn half_area(&self) -> f32 {
        let d = std::array::from_fn::<f32, 3, _>(|i| self.high[i] - self.low[i]);
        d[0] * d[1] + d[1] * d[2] + d[2] * d[0]
    }
}

impl Tree {
    // The roots of branches, the largest of which are opened: where branches reach into one another, or into what is
    // around them, their parts are better sorted (Benthin, Woop, Wald and Áfra, "Improved Two-Level BVHs using Partial
    // Re-Braiding", HPG 2017).
    fn boughs(&self, roots: &[u32], alone: bool) -> Vec<Bough> {
        let mut boughs: Vec<Bough> = roots.iter().filter_map(|&root| self.bough(root)).collect();
        let most = if alone { 0 } else { CUT + CUT_EACH * roots.len() };
        let mut shut = vec![false; boughs.len()];
        while boughs.len() < most {
            let open = (0..boughs.len()).filter(|&i| !shut[i]);
            let Some(largest) = open.max_by(|&a, &b| boughs[a].half_area().total_cmp(&boughs[b].half_area())) else {
                break;
            };
            let items = self.nodes.get(boughs[largest].node as usize).map_or([NO_ITEM; WIDTH], |node| node.items);
            let below = items.iter().filter(|item| **item != NO_ITEM);
            // A leaf stays where its node is.
            if below.clone().any(|item| item & ITEM_KIND != ITEM_NODE) {
                shut[largest] = true;
                continue;
            }
            let mut below = below.filter_map(|&item| self.bough(item));
            if let Some(first) = below.next() {
                boughs[largest] = first;
            }
            boughs.extend(below);
            shut.resize(boughs.len(), false);
        }
        boughs
    }

    fn bough(&self, node: u32) -> Option<Bough> {
        let bounds = &self.nodes.get(node as usize)?.bounds;
        let least = |axis: usize| bounds[axis][0].0.iter().copied().fold(f32::INFINITY, f32::min);
        let most = |axis: usize| bounds[axis][1].0.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        Some(Bough { low: [0, 1, 2].map(least), high: [0, 1, 2].map(most), node })
    }

    /// Adds the nodes over `own`, primitives and their boxes, and over the branches whose roots are these nodes; the
    /// primitives go behind those of the branches, in the order of leaves.
    pub fn crown(
        &mut self,
        roots: &[u32],
        (own, bounds): (&[Primitive], &[Bounds]),
        shapes: &[Shape],
        primitives: &mut Vec<Primitive>,
    ) {
        let count = own.len().min(bounds.len());
        let boughs = self.boughs(roots, count == 0 && roots.len() == 1);
        (self.root, self.reach, self.leaves) = (None, 0.0, Vec::new());
        if count + boughs.len() == 0 {
            return;
        }
        let item = |low: [f32; 3], high: [f32; 3], i: usize, kind: u32| Item {
            low: [low[0], low[1], low[2], f32::from_bits(NORMAL | i as u32)],
            high: [high[0], high[1], high[2], f32::from_bits(kind)],
        };
        let mut items: Vec<Item> = (own.par_iter(), bounds)
            .into_par_iter()
            .enumerate()
            .map(|(i, (primitive, b))| item(b.low.to_array(), b.high.to_array(), i, item_kind(primitive, shapes)))
            .collect();
        items.extend(boughs.iter().enumerate().map(|(i, b)| item(b.low, b.high, count + i, ITEM_BOUGH)));
        let root = Part::new(&items, 0);
        self.reach = root.extent.low.abs().max(root.extent.high.abs()).truncate().max_element();
        let mut drafts = Vec::new();
        if !root.is_leaf() {
            drafts = nodes(&mut items, root, 1);
        }
        // Where each item's primitive comes to lie; boughs have none.
        let mut places = Vec::with_capacity(items.len());
        let mut next = primitives.len() as u32;
        for item in &items {
            places.push(next);
            next += u32::from(item.kind() != ITEM_BOUGH);
        }
        let order = items.par_iter().filter(|item| item.kind() != ITEM_BOUGH);
        let order: Vec<Primitive> = order.map(|item| own[item.id() as usize]).collect();
        let before = primitives.len();
        primitives.extend_from_slice(&order);
        // Places of the leaves, in the order of the nodes.
        let (node_base, row_base) = (self.nodes.len() as u32, self.rows.len());
        let mut rows = row_base;
        let mut leaves = Vec::new();
        let mut leaf = |kind: u32, (first, count): (u32, u8), low: [f32; 3], high: [f32; 3]| {
            let first = first as usize;
            let item = match kind {
                ITEM_BOUGH => {
                    return items[first]
                        .id()
                        .checked_sub(own.len() as u32)
                        .map_or(NO_ITEM, |i| boughs[i as usize].node);
                }
                ITEM_INSTANCE => ITEM_INSTANCE | places[first],
                kind => kind | rows as u32,
            };
            leaves.push((Leaf { low, high, item, count: count as usize }, places[first] as usize - before));
            rows += rows_of(item);
            item
        };
        for draft in &mut drafts {
            for slot in 0..WIDTH {
                let corner = |side: usize| [0, 1, 2].map(|axis| draft.node.bounds[axis][side].0[slot]);
                let (low, high) = (corner(0), corner(1));
                let item = &mut draft.node.items[slot];
                if draft.leaves[slot].1 > 0 {
                    *item = leaf(*item, draft.leaves[slot], low, high);
                } else if *item & ITEM_KIND == ITEM_NODE {
                    *item += node_base;
                }
            }
        }
        self.root = Some(match root.is_leaf() {
            true => {
                let (low, high) = (root.extent.low.truncate().to_array(), root.extent.high.truncate().to_array());
                leaf(root.kind, (0, items.len() as u8), low, high)
            }
            false => ITEM_NODE | node_base,
        });
        self.nodes.extend(drafts.iter().map(|draft| draft.node));
        self.rows.resize(rows, Row::default());
        let mut rest = &mut self.rows[row_base..];
        let mut filled = Vec::with_capacity(leaves.len());
        for (leaf, first) in &leaves {
            let (own, others) = rest.split_at_mut(rows_of(leaf.item).min(rest.len()));
            filled.push((own, leaf, *first));
            rest = others;
        }
        filled.into_par_iter().with_min_len(256).for_each(|(rows, leaf, first)| {
            fill(rows, leaf.item & ITEM_KIND, before + first, &order[first..first + leaf.count], shapes);
        });
        let instances = leaves.iter().any(|(leaf, _)| leaf.item & ITEM_KIND == ITEM_INSTANCE);
        if count <= FEW && !instances && boughs.is_empty() {
            self.leaves = leaves.into_iter().map(|(leaf, _)| leaf).collect();
        }
    }
}

// The kind of an item that holds this primitive.
fn item_kind(primitive: &Primitive, shapes: &[Shape]) -> u32 {
    match primitive.shade.w & PRIMITIVE_KIND {
        PRIMITIVE_SPHERE if is_ball(shape_of(primitive, shapes)) => ITEM_BALLS,
        PRIMITIVE_SPHERE => ITEM_SPHERES,
        PRIMITIVE_PARALLELOGRAM => ITEM_PARALLELOGRAMS,
        PRIMITIVE_OTHER if primitive.index.z == OTHER_INSTANCE => ITEM_INSTANCE,
        PRIMITIVE_OTHER => ITEM_OTHERS,
        _ => ITEM_TRIANGLES,
    }
}

fn shape_of(primitive: &Primitive, shapes: &[Shape]) -> Shape {
    shapes.get((primitive.shade.w & !PRIMITIVE_KIND) as usize).copied().unwrap_or_default()
}

// Whether a sphere's map is one factor and an offset.
fn is_ball(shape: Shape) -> bool {
    let [x, y, z] = [shape.object_from_world_x, shape.object_from_world_y, shape.object_from_world_z];
    x.x == y.y && y.y == z.z && [x.y, x.z, y.x, y.z, z.x, z.y].iter().all(|beside| *beside == 0.0)
}

pub(super) fn rows_of(item: u32) -> usize {
    match item & ITEM_KIND {
        ITEM_INSTANCE => 0,
        ITEM_BALLS => 5,
        ITEM_TRIANGLES => 10,
        ITEM_OTHERS => 1,
        _ => 13,
    }
}

// The rows of a leaf whose primitives are `primitives`, the first of which has that index.
pub(super) fn fill(rows: &mut [Row], kind: u32, first: usize, primitives: &[Primitive], shapes: &[Shape]) {
    let Some((ids, numbers)) = rows.split_last_mut() else { return };
    *ids = Row::from_bits(std::array::from_fn(|i| if i < primitives.len() { (first + i) as u32 } else { NONE }));
    for (lane, p) in primitives.iter().enumerate().take(WIDTH) {
        let columns = if kind == ITEM_SPHERES || kind == ITEM_BALLS {
            let shape = shape_of(p, shapes);
            let [x, y, z] = [shape.object_from_world_x, shape.object_from_world_y, shape.object_from_world_z];
            match kind {
                ITEM_BALLS => [x.x, x.w, y.w, z.w, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                _ => [x.x, x.y, x.z, x.w, y.x, y.y, y.z, y.w, z.x, z.y, z.z, z.w],
            }
        } else {
            [p.x.x, p.y.x, p.z.x, p.x.y, p.y.y, p.z.y, p.x.z, p.y.z, p.z.z, p.x.w, p.y.w, p.z.w]
        };
        for (row, x) in numbers.iter_mut().zip(columns) {
            row.0[lane] = x;
        }
    }
}

// The node of `part`, which is no leaf, and all below it, itself first. `items` are those of the part.
pub(super) fn nodes(items: &mut [Item], part: Part, level: u32) -> Vec<Draft> {
    if part.len() <= GRAIN {
        return Twigs::grow(items, part).nodes();
    }
    let mut parts = [part; WIDTH];
    let mut count = 1;
    while count < WIDTH {
        let by_count = level > SAFE_LEVEL;
        let worth = |part: &Part| if by_count { part.len() as f32 } else { part.extent.half_area() };
        let open = parts[..count].iter().enumerate().filter(|(_, part)| !part.is_leaf());
        let Some((i, _)) = open.max_by(|a, b| worth(a.1).total_cmp(&worth(b.1))) else { break };
        let here = parts[i];
        let own = &mut items[here.first - part.first..here.end - part.first];
        (parts[i], parts[count]) = split(own, here, by_count);
        count += 1;
    }
    let parts = &mut parts[..count];
    parts.sort_unstable_by_key(|part| part.first);
    let mut draft = Draft::EMPTY;
    let mut rest = items;
    let mut inner = Vec::new();
    for (part, slot) in parts.iter().zip(slots(part.centre(), parts.iter().map(Part::centre))) {
        let (own, others) = rest.split_at_mut(part.len());
        rest = others;
        draft.put(slot, part, part.is_leaf());
        if !part.is_leaf() {
            inner.push((own, *part, slot));
        }
    }
    let below: Vec<(usize, Vec<Draft>)> =
        inner.into_par_iter().map(|(own, part, slot)| (slot, nodes(own, part, level + 1))).collect();
    let mut all = vec![draft];
    for (slot, mut drafts) in below {
        let base = all.len() as u32;
        all[0].node.items[slot] = ITEM_NODE | base;
        for draft in &mut drafts {
            for (item, leaf) in draft.node.items.iter_mut().zip(draft.leaves) {
                if leaf.1 == 0 && *item & ITEM_KIND == ITEM_NODE {
                    *item += base;
                }
            }
        }
        all.append(&mut drafts);
    }
    all
}

impl Draft {
    const EMPTY: Draft = Draft { node: Node::EMPTY, leaves: [(0, 0); WIDTH] };

    fn put(&mut self, slot: usize, part: &Part, leaf: bool) {
        for axis in 0..3 {
            self.node.bounds[axis][0].0[slot] = part.extent.low[axis];
            self.node.bounds[axis][1].0[slot] = part.extent.high[axis];
        }
        if leaf {
            self.node.items[slot] = part.kind;
            self.leaves[slot] = (part.first as u32, part.len() as u8);
        }
    }
}

/// Items that a subtree may become, at most, below another node.
const MOST: usize = WIDTH - 1;

/// What a leaf costs beside a node.
const LEAF_COST: f32 = 0.7;

/// A part, its halves, and how it becomes items of a node.
#[derive(Clone, Copy)]
struct Twig {
    part: Part,
    /// Places of the halves; 0: none.
    halves: [u32; 2],
    /// The cost of up to i + 1 items.
    cost: [f32; MOST],
    /// How many of up to i + 1 items come from the first half; 0: do as for one item less.
    from_first: [u8; MOST],
    /// How many of the eight come from the first half where this is a node; 0: it is a leaf.
    node_from_first: u8,
}

/// A part halved down to single items, or few of one kind, each twig before its halves.
struct Twigs(Vec<Twig>);

impl Twigs {
    fn grow(items: &mut [Item], whole: Part) -> Twigs {
        let twig = |part| Twig {
            part,
            halves: [0; 2],
            cost: [part.extent.half_area() * LEAF_COST; MOST],
            from_first: [0; MOST],
            node_from_first: 0,
        };
        let mut twigs = Vec::with_capacity(whole.len());
        twigs.push(twig(whole));
        let mut waiting = vec![(0, 0)];
        while let Some((at, depth)) = waiting.pop() {
            let part = twigs[at].part;
            if part.len() <= part.most(LEAST) && part.kind != ITEM_NODE {
                continue;
            }
            let own = &mut items[part.first - whole.first..part.end - whole.first];
            let (first, second) = split(own, part, depth > SAFE_HALVES);
            let place = twigs.len();
            twigs[at].halves = [place as u32, place as u32 + 1];
            twigs.extend([twig(first), twig(second)]);
            waiting.extend([(place, depth + 1), (place + 1, depth + 1)]);
        }
        for i in (0..twigs.len()).rev() {
            let [first, second] = twigs[i].halves.map(|half| half as usize);
            if first > 0 {
                let (a, b) = (twigs[first].cost, twigs[second].cost);
                twigs[i].choose(&a, &b);
            }
        }
        Twigs(twigs)
    }

    fn nodes(&self) -> Vec<Draft> {
        let mut drafts = vec![Draft::EMPTY];
        // Twigs, and the nodes that they become.
        let mut waiting = vec![(0, 0)];
        while let Some((twig, node)) = waiting.pop() {
            let twig = &self.0[twig];
            let from_first = twig.node_from_first as usize;
            let (mut children, mut count) = ([0; WIDTH], 0);
            self.items(twig.halves[0], from_first, &mut children, &mut count);
            self.items(twig.halves[1], WIDTH - from_first, &mut children, &mut count);
            let centres = children[..count].iter().map(|&child| self.0[child as usize].part.centre());
            for (&child, slot) in children[..count].iter().zip(slots(twig.part.centre(), centres)) {
                let twig = &self.0[child as usize];
                let leaf = twig.node_from_first == 0;
                drafts[node].put(slot, &twig.part, leaf);
                if !leaf {
                    drafts[node].node.items[slot] = ITEM_NODE | drafts.len() as u32;
                    waiting.push((child as usize, drafts.len()));
                    drafts.push(Draft::EMPTY);
                }
            }
        }
        drafts
    }

    // The twigs that stand for a twig as up to `most` items.
    fn items(&self, twig: u32, most: usize, into: &mut [u32; WIDTH], count: &mut usize) {
        let (mut waiting, mut height) = ([(twig, most); WIDTH], 1);
        while height > 0 {
            height -= 1;
            let (at, mut most) = waiting[height];
            let twig = &self.0[at as usize];
            while most > 1 && twig.from_first[most - 1] == 0 {
                most -= 1;
            }
            if most > 1 {
                let from_first = twig.from_first[most - 1] as usize;
                waiting[height] = (twig.halves[1], most - from_first);
                waiting[height + 1] = (twig.halves[0], from_first);
                height += 2;
            } else if *count < WIDTH {
                into[*count] = at;
                *count += 1;
            }
        }
    }
}

/// Items of one kind that are not halved further.
const LEAST: usize = 4;

impl Twig {
    // `a` and `b` are the costs of the halves.
    fn choose(&mut self, a: &[f32; MOST], b: &[f32; MOST]) {
        let best = |items: usize| {
            let (mut least, mut from) = (f32::INFINITY, 1);
            for first in items.saturating_sub(MOST).max(1)..=(items - 1).min(MOST) {
                let cost = a[first - 1] + b[items - first - 1];
                if cost < least {
                    (least, from) = (cost, first as u8);
                }
            }
            (least, from)
        };
        let area = self.part.extent.half_area();
        let (inside, from_first) = best(WIDTH);
        let (leaf, node) = (area * LEAF_COST, inside + area);
        if self.part.is_leaf() && leaf <= node {
            self.cost = [leaf; MOST];
        } else {
            self.node_from_first = from_first;
            self.cost = [node; MOST];
        }
        for items in 2..=MOST {
            let (cost, from_first) = best(items);
            self.cost[items - 1] = self.cost[items - 2];
            if cost < self.cost[items - 1] {
                self.cost[items - 1] = cost;
                self.from_first[items - 1] = from_first;
            }
        }
    }
}

impl Part {
    fn centre(&self) -> Vec4 {
        self.extent.low + self.extent.high
    }
}

/// Sorts the items of `part`, of which there are several, into two halves, neither of them empty.
fn split(items: &mut [Item], part: Part, by_count: bool) -> (Part, Part) {
    let middle = if part.len() <= WIDTH && part.kind == ITEM_NODE {
        by_kind(items)
    } else if by_count {
        None
    } else if part.len() < 64 {
        by_area::<8>(items, &part)
    } else {
        by_area::<MOST_BINS>(items, &part)
    };
    let middle = middle.filter(|&middle| middle > 0 && middle < items.len()).unwrap_or_else(|| {
        let size = part.centres.high - part.centres.low;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |a, b| {
            let centre = |item: &Item| item.low[axis] + item.high[axis];
            centre(a).total_cmp(&centre(b)).then(a.id().cmp(&b.id()))
        });
        middle
    });
    let (left, right) = items.split_at(middle);
    if items.len() > GRAIN * 4 {
        return rayon::join(|| Part::new(left, part.first), || Part::new(right, part.first + middle));
    }
    (Part::new(left, part.first), Part::new(right, part.first + middle))
}

// So few that only their kinds keep them from being a leaf.
fn by_kind(items: &mut [Item]) -> Option<usize> {
    let kind = items.first()?.kind();
    Some(partition(items, |item| item.kind() == kind))
}

// Keeps no order, but depends on the order alone.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let (mut low, mut high) = (0, items.len());
    loop {
        while low < high && first(&items[low]) {
            low += 1;
        }
        while low < high && !first(&items[high - 1]) {
            high -= 1;
        }
        if low >= high {
            return low;
        }
        items.swap(low, high - 1);
        low += 1;
        high -= 1;
    }
}

#[derive(Clone, Copy)]
struct Bin {
    extent: Extent,
    count: u32,
}

const NO_BIN: Bin = Bin { extent: Extent::EMPTY, count: 0 };

/// Where the items lie among the N bins of a part.
#[derive(Clone, Copy)]
struct Grid<const N: usize> {
    low: [f32; 4],
    scale: [f32; 4],
}

type Bins<const N: usize> = [[Bin; N]; 3];

impl<const N: usize> Grid<N> {
    fn of(part: &Part) -> Self {
        let size = part.centres.high - part.centres.low;
        let scale = |size: f32| {
            let scale = N as f32 * 0.999_999 / size;
            if scale.is_finite() { scale } else { 0.0 }
        };
        Grid { low: part.centres.low.to_array(), scale: [scale(size.x), scale(size.y), scale(size.z), 0.0] }
    }

    fn place(&self, item: &Item, axis: usize) -> usize {
        let at = (item.low[axis] + item.high[axis] - self.low[axis]) * self.scale[axis];
        (at as i32 as usize).min(N - 1)
    }

    fn fill(&self, items: &[Item]) -> Bins<N> {
        let mut bins = [[NO_BIN; N]; 3];
        for item in items {
            let extent = item.extent();
            for axis in 0..3 {
                let bin = &mut bins[axis][self.place(item, axis)];
                bin.extent = bin.extent.join(extent);
                bin.count += 1;
            }
        }
        bins
    }

    fn fill_on_all_cores(&self, items: &[Item]) -> Bins<N> {
        if items.len() <= GRAIN * 4 {
            return self.fill(items);
        }
        let (left, right) = items.split_at(items.len() / 2);
        let (mut left, right) = rayon::join(|| self.fill_on_all_cores(left), || self.fill_on_all_cores(right));
        for (bin, other) in left.as_flattened_mut().iter_mut().zip(right.as_flattened()) {
            bin.extent = bin.extent.join(other.extent);
            bin.count += other.count;
        }
        left
    }
}

// By the least sum of areas times items, as far as N bins an axis tell.
fn by_area<const N: usize>(items: &mut [Item], part: &Part) -> Option<usize> {
    let grid = Grid::<N>::of(part);
    let bins = grid.fill_on_all_cores(items);
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        if grid.scale[axis] == 0.0 {
            continue;
        }
        let bins = &bins[axis];
        let mut right_costs = [0.0; N];
        let (mut extent, mut count) = (Extent::EMPTY, 0);
        for i in (1..N).rev() {
            extent = extent.join(bins[i].extent);
            count += bins[i].count;
            right_costs[i] = cost(&extent, count);
        }
        (extent, count) = (Extent::EMPTY, 0);
        for i in 1..N {
            extent = extent.join(bins[i - 1].extent);
            count += bins[i - 1].count;
            let cost = cost(&extent, count) + right_costs[i];
            if count > 0 && count < items.len() as u32 && cost < best.0 {
                best = (cost, axis, i);
            }
        }
    }
    let (cost, axis, border) = best;
    cost.is_finite().then(|| partition(items, |item| grid.place(item, axis) < border))
}

fn cost(extent: &Extent, count: u32) -> f32 {
    if count == 0 { 0.0 } else { extent.half_area() * count as f32 }
}

// A slot a part, up to eight, by twice their centres: bit i of a slot says whether the part lies to the positive side of
// axis i from `middle`, as far as all can.
pub(super) fn slots(middle: Vec4, centres: impl Iterator<Item = Vec4>) -> [usize; WIDTH] {
    let mut fits = [[f32::NEG_INFINITY; WIDTH]; WIDTH];
    let mut count = 0;
    for (fits, centre) in fits.iter_mut().zip(centres) {
        count += 1;
        let offset = centre - middle;
        for (slot, fit) in fits.iter_mut().enumerate() {
            let along = |bit: usize, x: f32| if slot >> bit & 1 == 1 { x } else { -x };
            // A number greater than those of what is taken.
            *fit = (along(0, offset.x) + along(1, offset.y) + along(2, offset.z)).max(f32::MIN);
        }
    }
    let mut slots = [0; WIDTH];
    for _ in 0..count {
        let (mut best, mut at) = (f32::NEG_INFINITY, 0);
        for (i, &fit) in fits.as_flattened().iter().enumerate() {
            if fit > best {
                (best, at) = (fit, i);
            }
        }
        let (child, slot) = (at / WIDTH, at % WIDTH);
        slots[child] = slot;
        fits[child] = [f32::NEG_INFINITY; WIDTH];
        for fits in &mut fits {
            fits[slot] = f32::NEG_INFINITY;
        }
    }
    slots
}
