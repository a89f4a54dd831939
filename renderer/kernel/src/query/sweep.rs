//! A few primitives against many rays: each primitive in turn, a ray a lane. Where a tree has so few of them, nothing is
//! faster.

use super::lanes::{BATCH, Lanes, Row};
use super::ray::{Hits, Prepared, Rays, load};
use super::shapes::{LaneHits, Probe, balls, flats, others, spheres};
use super::tree::{ITEM_BALLS, ITEM_KIND, ITEM_OTHERS, ITEM_SPHERES, ITEM_TRIANGLES, Leaf, Tree};
use crate::generated::Kernel;

/// The rays in the mask `active`: the nearest hits, or any; gives the mask of those that hit something.
#[inline(always)]
pub fn many<L: Lanes, const ANY: bool>(kernel: &Kernel<'_>, rays: &Rays, active: u32, hits: &mut Hits) -> u32 {
    let tree = kernel.native.tree;
    let prepared = Prepared::<BATCH>::new::<L>(&rays.o, &rays.d, tree.reach);
    let mut found = 0;
    for at in (0..BATCH).step_by(L::COUNT) {
        let here = active >> at & ((1_u64 << L::COUNT) - 1) as u32;
        if here != 0 {
            found |= sweep::<L, ANY>(kernel, rays, &prepared, at, here, hits) << at;
        }
    }
    found & active
}

#[inline(always)]
fn sweep<L: Lanes, const ANY: bool>(
    kernel: &Kernel<'_>,
    rays: &Rays,
    prepared: &Prepared<BATCH>,
    at: usize,
    active: u32,
    hits: &mut Hits,
) -> u32 {
    let tree = kernel.native.tree;
    let ray = Probe {
        o: load::<L, BATCH>(&prepared.o, at),
        x: load(&prepared.x, at),
        y: load(&prepared.y, at),
        d: load(&prepared.d, at),
    };
    let starts: &[f32; BATCH] = bytemuck::cast_ref(&rays.start);
    let start = L::load(&starts[at..]);
    let slack = L::load(&prepared.slack[at..]);
    let zero = L::splat(0.0);
    let mut t = L::load(&rays.t_max[at..]);
    let (mut u, mut v, mut id) = (zero, zero, zero);
    let mut found = 0;
    for leaf in &tree.leaves {
        let open = L::bits(meets::<L>(leaf, prepared, at, t.add(slack))) & active;
        if open == 0 || (ANY && open & !found == 0) {
            continue;
        }
        for lane in 0..leaf.count {
            let met = if leaf.item & ITEM_KIND == ITEM_OTHERS {
                other::<L>(kernel, leaf, lane, rays, at, open, t)
            } else {
                primitive::<L>(tree, leaf, lane, ray, start, t)
            };
            let Some((new, own)) = met else { continue };
            // Of two hits at one distance the lower index wins; nothing is below the first, whose index is 0 still.
            let mask = L::and(new.mask, L::or(new.t.lt(t), own.bits_lt(id)));
            let bits = L::bits(mask);
            found |= bits;
            if ANY {
                if found & active == active {
                    return found;
                }
            } else if bits != 0 {
                t = L::select(t, new.t, mask);
                u = L::select(u, new.u, mask);
                v = L::select(v, new.v, mask);
                id = L::select(id, own, mask);
            }
        }
    }
    if !ANY {
        let (mut ts, mut us, mut vs, mut ids) = ([0.0; BATCH], [0.0; BATCH], [0.0; BATCH], [0.0; BATCH]);
        t.store(&mut ts);
        u.store(&mut us);
        v.store(&mut vs);
        id.store(&mut ids);
        for i in (0..L::COUNT).filter(|i| (found & active) >> i & 1 == 1) {
            (hits.t[at + i], hits.id[at + i]) = (ts[i], ids[i].to_bits());
            (hits.u[at + i], hits.v[at + i]) = (us[i], vs[i]);
        }
    }
    found
}

#[inline(always)]
fn meets<L: Lanes>(leaf: &Leaf, rays: &Prepared<BATCH>, at: usize, cull: L) -> L::Mask {
    let (mut near, mut far) = (L::splat(0.0), cull);
    for axis in 0..3 {
        let inverse = L::load(&rays.inverse[axis][at..]);
        let (low, high) = (L::splat(leaf.low[axis]), L::splat(leaf.high[axis]));
        let negative = inverse.lt(L::splat(0.0));
        let (enter, leave) = (L::select(low, high, negative), L::select(high, low, negative));
        near = enter.mul_add(inverse, L::load(&rays.near[axis][at..])).max(near);
        far = leave.mul_add(inverse, L::load(&rays.far[axis][at..])).min(far);
    }
    near.le(far)
}

// One primitive that lanes do not do together, before the rays in the mask `active`, and its index.
#[inline(always)]
fn other<L: Lanes>(
    kernel: &Kernel<'_>,
    leaf: &Leaf,
    lane: usize,
    rays: &Rays,
    at: usize,
    active: u32,
    t_max: L,
) -> Option<(LaneHits<L>, L)> {
    let own = kernel.native.tree.rows.get((leaf.item & !ITEM_KIND) as usize)?.0[lane & 7];
    let id = own.to_bits();
    let hit = |i: usize| {
        let (o, d) = (rays.o.map(|o| o[at + i]).into(), rays.d.map(|d| d[at + i]).into());
        kernel.hit_other(id, o, d, rays.start[at + i] == id)
    };
    Some((others(active, t_max, hit), L::splat(own)))
}

// One primitive of a leaf before all rays, and its index.
#[inline(always)]
fn primitive<L: Lanes>(
    tree: &Tree,
    leaf: &Leaf,
    lane: usize,
    ray: Probe<L>,
    start: L,
    t_max: L,
) -> Option<(LaneHits<L>, L)> {
    let rows = tree.rows.get((leaf.item & !ITEM_KIND) as usize..)?;
    match leaf.item & ITEM_KIND {
        ITEM_TRIANGLES => {
            let (rows, rest) = rows.split_first_chunk::<9>()?;
            let own = L::splat(rest.first()?.0[lane]);
            let hits = flats(ray, corners::<L, 3>(bytemuck::cast_ref(rows), lane), t_max)?;
            Some((LaneHits { mask: L::and_not(own.same_bits(start), hits.mask), ..hits }, own))
        }
        ITEM_BALLS => {
            let (rows, rest) = rows.split_first_chunk::<4>()?;
            let own = L::splat(rest.first()?.0[lane]);
            let [factor, x, y, z] = rows.each_ref().map(|row| L::splat(row.0[lane]));
            Some((balls(ray, factor, [x, y, z], own.same_bits(start), t_max)?, own))
        }
        ITEM_SPHERES => {
            let (rows, rest) = rows.split_first_chunk::<12>()?;
            let own = L::splat(rest.first()?.0[lane]);
            let rows: &[[Row; 4]; 3] = bytemuck::cast_ref(rows);
            let mut lanes = [[L::splat(0.0); 4]; 3];
            for axis in 0..3 {
                for column in 0..4 {
                    lanes[axis][column] = L::splat(rows[axis][column].0[lane]);
                }
            }
            Some((spheres(ray, lanes, own.same_bits(start), t_max)?, own))
        }
        _ => {
            let (rows, rest) = rows.split_first_chunk::<12>()?;
            let own = L::splat(rest.first()?.0[lane]);
            let hits = flats(ray, corners::<L, 4>(bytemuck::cast_ref(rows), lane), t_max)?;
            Some((LaneHits { mask: L::and_not(own.same_bits(start), hits.mask), ..hits }, own))
        }
    }
}

#[inline(always)]
fn corners<L: Lanes, const C: usize>(rows: &[[Row; 3]; C], lane: usize) -> [[L; 3]; C] {
    let mut lanes = [[L::splat(0.0); 3]; C];
    for corner in 0..C {
        for axis in 0..3 {
            lanes[corner][axis] = L::splat(rows[corner][axis].0[lane & 7]);
        }
    }
    lanes
}
