//! Rays against primitives in lanes: the twins of `hit_flat` and `hit_sphere` in `shaders/intersect.wgsl`, operation by
//! operation. A lane is a primitive beside others before one ray, or a ray beside others before one primitive.

use super::lanes::{BATCH, Lanes};
use crate::generated::{Hit, NONE};

/// A ray, or one a lane.
#[derive(Clone, Copy)]
pub struct Probe<L> {
    pub o: [L; 3],
    pub x: [L; 3],
    pub y: [L; 3],
    pub d: [L; 3],
}

/// Hits of the lanes in `mask`.
#[derive(Clone, Copy)]
pub struct LaneHits<L: Lanes> {
    pub mask: L::Mask,
    pub t: L,
    pub u: L,
    pub v: L,
}

#[inline(always)]
pub fn dot<L: Lanes>(a: [L; 3], b: [L; 3]) -> L {
    a[0].mul(b[0]).add(a[1].mul(b[1])).add(a[2].mul(b[2]))
}

/// `hit_flat` for primitives of N corners, in 0 < t <= t_max; `None` where all rays pass by.
#[inline(always)]
pub fn flats<L: Lanes, const N: usize>(ray: Probe<L>, corners: [[L; 3]; N], t_max: L) -> Option<LaneHits<L>> {
    let zero = L::splat(0.0);
    let mut p = corners;
    let (mut px, mut py) = ([zero; N], [zero; N]);
    for i in 0..N {
        let [x, y, z] = corners[i];
        p[i] = [x.sub(ray.o[0]), y.sub(ray.o[1]), z.sub(ray.o[2])];
        px[i] = dot(p[i], ray.x);
        py[i] = dot(p[i], ray.y);
    }
    let mut w = [zero; N];
    for i in 0..N {
        let j = (i + 1) % N;
        w[i] = px[i].mul(py[j]).sub(py[i].mul(px[j]));
    }
    // A NaN among them makes t one, too. The fourth edge of a triangle has no length and changes neither.
    let (mut low, mut high) = (w[0].min(w[1]), w[0].max(w[1]));
    for &w in &w[2..] {
        low = low.min(w);
        high = high.max(w);
    }
    let outside = L::and(low.lt(zero), zero.lt(high));
    if L::bits(outside) == ((1_u64 << L::COUNT) - 1) as u32 {
        return None;
    }
    let last = N - 1;
    let (opposite, whole) = if N == 3 {
        let area = w[0].add(w[1]).add(w[2]);
        (w[2], [area, area])
    } else {
        (w[last], [w[last].add(w[1]), w[0].add(w[2])])
    };
    let flat = L::or(whole[0].eq(zero), whole[1].eq(zero));
    let (u, v) = (opposite.div(whole[0]), w[0].div(whole[1]));
    let along = [dot(p[0], ray.d), dot(p[1], ray.d), dot(p[last], ray.d)];
    let t = along[0].add(u.mul(along[1].sub(along[0]))).add(v.mul(along[2].sub(along[0])));
    let mask = L::and(zero.lt(t), t.le(t_max));
    Some(LaneHits { mask: L::and_not(L::or(outside, flat), mask), t, u, v })
}

/// `hit_sphere`, in 0 < t <= t_max: `rows` are those of the map to the unit sphere; `None` where all rays pass by.
#[inline(always)]
pub fn spheres<L: Lanes>(ray: Probe<L>, rows: [[L; 4]; 3], starts_on: L::Mask, t_max: L) -> Option<LaneHits<L>> {
    let mut own = [[L::splat(0.0); 3]; 2];
    for i in 0..3 {
        let row = [rows[i][0], rows[i][1], rows[i][2]];
        own[0][i] = dot(row, ray.o).add(rows[i][3]);
        own[1][i] = dot(row, ray.d);
    }
    unit_spheres(own, starts_on, t_max)
}

/// [`spheres`] whose maps have `factor` on the diagonal, zeros beside it and `offsets`: the same bits.
#[inline(always)]
pub fn balls<L: Lanes>(ray: Probe<L>, factor: L, offsets: [L; 3], starts_on: L::Mask, t_max: L) -> Option<LaneHits<L>> {
    let mut own = [[L::splat(0.0); 3]; 2];
    for i in 0..3 {
        own[0][i] = factor.mul(ray.o[i]).add(offsets[i]);
        own[1][i] = factor.mul(ray.d[i]);
    }
    unit_spheres(own, starts_on, t_max)
}

/// A ray passes by a sphere for sure if its square distance from the centre, of a unit sphere, is greater than 1 and this
/// share of the square distance of its start: eight times what rounding does to the one by the other.
const SURELY: f32 = 4e-6;

// Rays in the space of unit spheres: where they start, and where they go.
#[inline(always)]
fn unit_spheres<L: Lanes>([f, v]: [[L; 3]; 2], starts_on: L::Mask, t_max: L) -> Option<LaneHits<L>> {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let a = dot(v, v);
    let fv = dot(f, v);
    let ff = dot(f, f);
    // Nearly all of a leaf are passed by, which is seen without a division.
    let least = a.mul(ff.mul(L::splat(1.0 - SURELY)).sub(one));
    if L::bits(fv.mul(fv).lt(least)) == ((1_u64 << L::COUNT) - 1) as u32 {
        return None;
    }
    let b = fv.mul(L::splat(-1.0));
    let along = b.div(a);
    let nearest = [f[0].add(along.mul(v[0])), f[1].add(along.mul(v[1])), f[2].add(along.mul(v[2]))];
    let discriminant = one.sub(dot(nearest, nearest));
    let beside = discriminant.lt(zero);
    if L::bits(beside) == ((1_u64 << L::COUNT) - 1) as u32 {
        return None;
    }
    let root = a.mul(discriminant).sqrt();
    let q = L::select(b.add(root), b.sub(root), b.lt(zero));
    let c = ff.sub(one);
    let (first, second) = (c.div(q), q.div(a));
    let swap = second.lt(first);
    let (near, far) = (L::select(first, second, swap), L::select(second, first, swap));
    let t = L::select(far, near, L::and_not(starts_on, zero.lt(near)));
    let mask = L::and(zero.lt(t), t.le(t_max));
    let mask = L::and_not(L::or(beside, L::and(starts_on, b.le(zero))), mask);
    Some(LaneHits { mask, t, u: zero, v: zero })
}

/// Hits of what lanes do not do together, in 0 < t <= t_max: `hit` gives that of one lane, FAR where there is none.
#[inline(always)]
pub fn others<L: Lanes>(lanes: u32, t_max: L, mut hit: impl FnMut(usize) -> Hit) -> LaneHits<L> {
    let (mut t, mut u, mut v) = ([-1.0; BATCH], [0.0; BATCH], [0.0; BATCH]);
    for i in (0..L::COUNT).filter(|i| lanes >> i & 1 == 1) {
        let hit = hit(i);
        if hit.id != NONE {
            (t[i], u[i], v[i]) = (hit.t, hit.uv.x, hit.uv.y);
        }
    }
    let (t, u, v) = (L::load(&t), L::load(&u), L::load(&v));
    LaneHits { mask: L::and(L::splat(0.0).lt(t), t.le(t_max)), t, u, v }
}
