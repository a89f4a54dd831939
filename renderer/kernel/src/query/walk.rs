//! The walk through the tree: one ray before eight boxes or primitives, or many rays before one box.

use glam::Vec3;

use super::lanes::{BATCH, Eight, Lanes, Row, Stack, WIDTH};
use super::ray::{Hits, Of, Prepared, Rays, splat};
use super::shapes::{LaneHits, Probe, balls, flats, others, spheres};
use super::tree::{
    ITEM_BALLS, ITEM_INSTANCE, ITEM_KIND, ITEM_NODE, ITEM_OTHERS, ITEM_PARALLELOGRAMS, ITEM_SPHERES, ITEM_TRIANGLES,
    NO_ITEM, Node,
};
use crate::generated::{FAR, Hit, Kernel, NONE, PRIMITIVE_KIND};

/// Orders of visit by the signs of a ray's direction and the mask of the slots that it meets, the slots as bytes: the
/// nearest in the last byte, the others in the first ones, farthest first.
static ORDERS: [[u64; 256]; 8] = orders();

const fn orders() -> [[u64; 256]; 8] {
    let mut all = [[0; 256]; 8];
    let mut negative = 0;
    while negative < 8 {
        let mut mask = 0;
        while mask < 256 {
            let (mut order, mut count, mut rank, mut nearest) = (0_u64, 0, 0, 0);
            while rank < 8 {
                // Bits set: axes along which the slot lies on the far side.
                let far = [7, 6, 5, 3, 4, 2, 1, 0][rank];
                let slot = far ^ negative;
                if mask >> slot & 1 == 1 {
                    order |= (slot as u64) << (8 * count);
                    count += 1;
                    nearest = slot as u64;
                }
                rank += 1;
            }
            all[negative][mask] = order & (u64::MAX >> 8) | nearest << 56;
            mask += 1;
        }
        negative += 1;
    }
    all
}

/// How far a ray is.
struct Walk {
    item: u32,
    start: u32,
    best: Hit,
    found: bool,
    /// What lies farther need not be visited.
    cull: f32,
}

const NOTHING: Hit = Hit { t: FAR, id: NONE, uv: glam::Vec2::ZERO, instance: NONE };

impl Walk {
    #[inline(always)]
    fn new(root: u32, t_max: f32, start: u32, slack: f32) -> Self {
        // Of two hits at one distance the lower instance and index win; nothing is below the first.
        let best = Hit { t: t_max, id: 0, ..Hit::default() };
        Self { item: root, start, best, found: false, cull: t_max + slack }
    }

    /// Visits a node or a leaf with ray `i`; false after the last.
    #[inline(always)]
    fn step<L: Eight, const ANY: bool, const PARTS: bool, const N: usize>(
        &mut self,
        kernel: &Kernel<'_>,
        rays: &Prepared<N>,
        i: usize,
        stack: &mut Stack,
    ) -> bool {
        let tree = kernel.native.tree;
        if self.item & ITEM_KIND == ITEM_NODE {
            let Some(node) = tree.nodes.get(self.item as usize) else { return false };
            let (near, mask) = meets::<L, N>(node, rays, i, L::splat(self.cull));
            if mask != 0 {
                let order = ORDERS[rays.negative[i] as usize & 7][mask as usize & 0xff];
                let items = L::load(bytemuck::cast_ref::<_, [f32; WIDTH]>(&node.items)).permute(order);
                stack.push(near.permute(order), items, mask.count_ones() as usize - 1);
                self.item = node.items[(order >> 56) as usize % WIDTH];
                return true;
            }
        } else if PARTS && self.item & ITEM_KIND == ITEM_INSTANCE {
            let (o, d) = (rays.o.map(|o| o[i]), rays.d.map(|d| d[i]));
            if let Some(hit) = inside::<L, ANY>(kernel, self.item & !ITEM_KIND, o, d, self.best.t) {
                if ANY {
                    self.found = true;
                    return false;
                }
                let before = (hit.instance, hit.id) < (self.best.instance, self.best.id);
                if hit.t < self.best.t || (hit.t == self.best.t && before) {
                    self.found = true;
                    self.best = hit;
                    self.cull = hit.t + rays.slack[i];
                }
            }
        } else if let Some((hits, ids)) = leaf::<L, N>(kernel, self.item, rays, i, L::splat(self.best.t), self.start) {
            if ANY {
                if L::bits(L::and(hits.mask, hits.t.lt(L::splat(self.best.t)))) != 0 {
                    self.found = true;
                    return false;
                }
            } else {
                self.improve(&hits, ids, rays.slack[i]);
            }
        }
        while let Some((near, next)) = stack.pop() {
            if ANY || near <= self.cull {
                self.item = next;
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn improve<L: Eight>(&mut self, hits: &LaneHits<L>, ids: &Row, slack: f32) {
        let mut mask = L::bits(hits.mask);
        if mask == 0 {
            return;
        }
        let (mut t, mut u, mut v) = (Row::default(), Row::default(), Row::default());
        hits.t.store(&mut t.0);
        hits.u.store(&mut u.0);
        hits.v.store(&mut v.0);
        while mask != 0 {
            let i = mask.trailing_zeros() as usize % WIDTH;
            mask &= mask - 1;
            let id = ids.0[i].to_bits();
            let before = self.best.instance == NONE && id < self.best.id;
            if t.0[i] < self.best.t || (t.0[i] == self.best.t && before) {
                self.best = Hit { t: t.0[i], id, uv: glam::Vec2::new(u.0[i], v.0[i]), instance: NONE };
                self.found = true;
            }
        }
        self.cull = self.best.t + slack;
    }

    #[inline(always)]
    fn hit(&self) -> Hit {
        if self.found { self.best } else { NOTHING }
    }
}

/// The hit of the ray from `o` along `d` in an instance, which is primitive `id`, as far as `t_max`. The nearest may be a
/// little farther away: a ray's distance inside is rounded, and what lies at one distance is for the caller to decide.
#[inline(always)]
fn inside<L: Eight, const ANY: bool>(
    kernel: &Kernel<'_>,
    id: u32,
    o: [f32; 3],
    d: [f32; 3],
    t_max: f32,
) -> Option<Hit> {
    let instance = kernel.primitives.get(id as usize)?;
    let part = kernel.native.tree.parts.get(instance.index.x as usize)?;
    let shape = instance.shade.w & !PRIMITIVE_KIND;
    let (o, v) = (kernel.object_point(shape, o.into()), kernel.object_vector(shape, d.into()));
    let scale = v.length();
    let d = v / scale;
    let all = |v: Vec3| v.to_array().map(|x| [x; WIDTH]);
    let rays = Prepared::<WIDTH>::new::<L>(&all(o), &all(d), part.reach);
    let reach = t_max * scale * if ANY { 1.0 } else { 1.000_001 };
    let mut walk = Walk::new(part.root?, reach.min(FAR), NONE, rays.slack[0]);
    let mut stack = Stack::new();
    while walk.step::<L, ANY, false, WIDTH>(kernel, &rays, 0, &mut stack) {}
    walk.found.then(|| Hit { t: walk.best.t / scale, instance: shape, ..walk.best })
}

/// Where ray `i` enters a node's boxes, and which of them it meets before `cull`.
#[inline(always)]
fn meets<L: Eight, const N: usize>(node: &Node, rays: &Prepared<N>, i: usize, cull: L) -> (L, u32) {
    let negative = rays.negative[i] as usize;
    let (mut near, mut far) = (L::splat(0.0), cull);
    for axis in 0..3 {
        let side = negative >> axis & 1;
        let inverse = L::splat(rays.inverse[axis][i]);
        let enter = L::load(&node.bounds[axis][side].0).mul_add(inverse, L::splat(rays.near[axis][i]));
        let leave = L::load(&node.bounds[axis][side ^ 1].0).mul_add(inverse, L::splat(rays.far[axis][i]));
        // What is no number is the first operand and so has no say.
        near = enter.max(near);
        far = leave.min(far);
    }
    (near, L::bits(near.le(far)))
}

/// The leaf's primitives against ray `i`, up to and with `t_max`, and their indices.
#[inline(always)]
fn leaf<'a, L: Eight, const N: usize>(
    kernel: &Kernel<'a>,
    item: u32,
    rays: &Prepared<N>,
    i: usize,
    t_max: L,
    start: u32,
) -> Option<(LaneHits<L>, &'a Row)> {
    let ray = Probe { o: splat(&rays.o, i), x: splat(&rays.x, i), y: splat(&rays.y, i), d: splat(&rays.d, i) };
    let rows = kernel.native.tree.rows.get((item & !ITEM_KIND) as usize..)?;
    if item & ITEM_KIND == ITEM_OTHERS {
        let ids = rows.first()?;
        let (o, d) = (rays.o.map(|o| o[i]).into(), rays.d.map(|d| d[i]).into());
        let there = (0..WIDTH).filter(|&lane| ids.0[lane].to_bits() != NONE).fold(0, |mask, lane| mask | 1 << lane);
        let hit = |lane: usize| {
            let id = ids.0[lane].to_bits();
            kernel.hit_other(id, o, d, id == start)
        };
        return Some((others(there, t_max, hit), ids));
    }
    let start = L::splat(f32::from_bits(start));
    let (hits, ids) = match item & ITEM_KIND {
        ITEM_TRIANGLES => {
            let (rows, rest) = rows.split_first_chunk::<9>()?;
            (flats(ray, corners::<L, 3>(bytemuck::cast_ref(rows)), t_max)?, rest.first()?)
        }
        ITEM_PARALLELOGRAMS => {
            let (rows, rest) = rows.split_first_chunk::<12>()?;
            (flats(ray, corners::<L, 4>(bytemuck::cast_ref(rows)), t_max)?, rest.first()?)
        }
        ITEM_BALLS => {
            let (rows, rest) = rows.split_first_chunk::<4>()?;
            let ids = rest.first()?;
            let [factor, x, y, z] = rows.each_ref().map(|row| L::load(&row.0));
            return Some((balls(ray, factor, [x, y, z], L::load(&ids.0).same_bits(start), t_max)?, ids));
        }
        ITEM_SPHERES => {
            let (rows, rest) = rows.split_first_chunk::<12>()?;
            let ids = rest.first()?;
            let rows: &[[Row; 4]; 3] = bytemuck::cast_ref(rows);
            let mut lanes = [[L::splat(0.0); 4]; 3];
            for axis in 0..3 {
                for column in 0..4 {
                    lanes[axis][column] = L::load(&rows[axis][column].0);
                }
            }
            return Some((spheres(ray, lanes, L::load(&ids.0).same_bits(start), t_max)?, ids));
        }
        _ => return None,
    };
    let mask = L::and_not(L::load(&ids.0).same_bits(start), hits.mask);
    Some((LaneHits { mask, ..hits }, ids))
}

#[inline(always)]
fn corners<L: Eight, const C: usize>(rows: &[[Row; 3]; C]) -> [[L; 3]; C] {
    let mut lanes = [[L::splat(0.0); 3]; C];
    for corner in 0..C {
        for axis in 0..3 {
            lanes[corner][axis] = L::load(&rows[corner][axis].0);
        }
    }
    lanes
}

/// One ray: the nearest hit, or any.
#[inline(always)]
pub fn one<L: Eight, const ANY: bool>(kernel: &Kernel<'_>, o: [f32; 3], d: [f32; 3], t_max: f32, start: u32) -> Hit {
    let tree = kernel.native.tree;
    let Some(root) = tree.root else { return NOTHING };
    let all = |x: f32| [x; WIDTH];
    let rays =
        Prepared::<WIDTH>::new::<L>(&[all(o[0]), all(o[1]), all(o[2])], &[all(d[0]), all(d[1]), all(d[2])], tree.reach);
    let mut walk = Walk::new(root, t_max, start, rays.slack[0]);
    let mut stack = Stack::new();
    while walk.step::<L, ANY, true, WIDTH>(kernel, &rays, 0, &mut stack) {}
    walk.hit()
}

/// Rays that go on together; fewer are walked one by one.
const TOGETHER: u32 = 4;

/// Slots of a node by the signs of a ray's direction, the farthest first.
static FARTHEST: [[u8; WIDTH]; 8] = farthest();

const fn farthest() -> [[u8; WIDTH]; 8] {
    let mut all = [[0; WIDTH]; 8];
    let mut negative = 0;
    while negative < 8 {
        let mut rank = 0;
        while rank < WIDTH {
            all[negative][rank] = [7, 6, 5, 3, 4, 2, 1, 0][rank] ^ negative as u8;
            rank += 1;
        }
        negative += 1;
    }
    all
}

/// A child that some rays may meet: its node, and in one number its slot and the mask of the rays.
#[derive(Clone, Copy, Default)]
struct Child {
    node: u32,
    slot_and_rays: u32,
}

/// Children still to visit by several rays; where there is no room for more, rays go one by one.
const CHILDREN: usize = 256;

/// The rays in the mask `active`: the nearest hits, or any; gives the mask of those that hit something. They go down
/// together, a ray a lane, as long as there are several of them at a node, and then one by one with its boxes in lanes:
/// E for what is one by one, W for all of them. PARTS: whether there are instances in the tree.
#[inline(always)]
pub fn many<E: Eight, W: Lanes, const ANY: bool, const PARTS: bool>(
    kernel: &Kernel<'_>,
    rays: &Rays,
    active: u32,
    hits: &mut Hits,
) -> u32 {
    let tree = kernel.native.tree;
    let Some(root) = tree.root else { return 0 };
    let prepared = Prepared::<BATCH>::new::<W>(&rays.o, &rays.d, tree.reach);
    let mut cull: Of<BATCH> = std::array::from_fn(|i| rays.t_max[i] + prepared.slack[i]);
    let mut found = 0;
    let mut waiting = [Child::default(); CHILDREN];
    let mut height = 0;
    let (mut item, mut mask) = (root, active);
    loop {
        let together = mask.count_ones() > TOGETHER && height + WIDTH <= CHILDREN;
        let node = (together && item & ITEM_KIND == ITEM_NODE).then(|| tree.nodes.get(item as usize)).flatten();
        if let Some(node) = node {
            let first = mask.trailing_zeros() as usize % BATCH;
            for slot in FARTHEST[prepared.negative[first] as usize & 7] {
                if node.items[slot as usize % WIDTH] != NO_ITEM {
                    waiting[height] = Child { node: item, slot_and_rays: u32::from(slot) << BATCH | mask };
                    height += 1;
                }
            }
        } else {
            while mask != 0 {
                let i = mask.trailing_zeros() as usize % BATCH;
                mask &= mask - 1;
                let mut walk = Walk::new(item, rays.t_max[i], rays.start[i], prepared.slack[i]);
                if !ANY && found >> i & 1 == 1 {
                    let uv = glam::Vec2::new(hits.u[i], hits.v[i]);
                    walk.best = Hit { t: hits.t[i], id: hits.id[i], uv, instance: hits.instance[i] };
                    walk.cull = cull[i];
                }
                let mut stack = Stack::new();
                while walk.step::<E, ANY, PARTS, BATCH>(kernel, &prepared, i, &mut stack) {}
                if walk.found {
                    found |= 1 << i;
                    if !ANY {
                        let hit = walk.best;
                        (hits.t[i], hits.id[i], hits.u[i], hits.v[i]) = (hit.t, hit.id, hit.uv.x, hit.uv.y);
                        hits.instance[i] = hit.instance;
                        cull[i] = walk.cull;
                    }
                }
            }
        }
        // The nearest child that is met still.
        loop {
            if height == 0 {
                return found;
            }
            height -= 1;
            let Child { node, slot_and_rays } = waiting[height % CHILDREN];
            mask = slot_and_rays & ((1 << BATCH) - 1);
            if ANY {
                mask &= !found;
            }
            if mask == 0 {
                continue;
            }
            let Some(node) = tree.nodes.get(node as usize) else { continue };
            let slot = (slot_and_rays >> BATCH) as usize % WIDTH;
            mask &= met_by::<W>(node, slot, &prepared, &cull, mask);
            if mask != 0 {
                item = node.items[slot];
                break;
            }
        }
    }
}

/// Which rays meet a child of `node` before `cull`, of those in `mask` at least.
#[inline(always)]
fn met_by<W: Lanes>(node: &Node, slot: usize, rays: &Prepared<BATCH>, cull: &Of<BATCH>, mask: u32) -> u32 {
    let mut met = 0;
    for at in (0..BATCH).step_by(W::COUNT) {
        if mask >> at & ((1_u64 << W::COUNT) - 1) as u32 == 0 {
            continue;
        }
        let (mut near, mut far) = (W::splat(0.0), W::load(&cull[at..]));
        for axis in 0..3 {
            let inverse = W::load(&rays.inverse[axis][at..]);
            let [low, high] = &node.bounds[axis];
            let (low, high) = (W::splat(low.0[slot]), W::splat(high.0[slot]));
            let negative = inverse.lt(W::splat(0.0));
            let (enter, leave) = (W::select(low, high, negative), W::select(high, low, negative));
            near = enter.mul_add(inverse, W::load(&rays.near[axis][at..])).max(near);
            far = leave.mul_add(inverse, W::load(&rays.far[axis][at..])).min(far);
        }
        met |= W::bits(near.le(far)) << at;
    }
    met
}
