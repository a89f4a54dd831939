//! Rays as the walks need them, prepared many at a time.

use super::lanes::{BATCH, Lanes};

/// Rays to ask about together, a lane each.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Rays {
    /// Where they start: x, y, z.
    pub o: [[f32; BATCH]; 3],
    /// Where they go, of unit length: x, y, z.
    pub d: [[f32; BATCH]; 3],
    /// How far they reach, at most.
    pub t_max: [f32; BATCH],
    /// The primitives that they start on, or NONE.
    pub start: [u32; BATCH],
}

impl Default for Rays {
    fn default() -> Self {
        Self { o: [[0.0; BATCH]; 3], d: [[0.0; BATCH]; 3], t_max: [0.0; BATCH], start: [0; BATCH] }
    }
}

/// What they met, a lane each, as in `Hit`.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Hits {
    /// Distance along the ray; FAR where nothing was hit.
    pub t: [f32; BATCH],
    /// Primitive or NONE.
    pub id: [u32; BATCH],
    /// Of a flat primitive: how far along the edge to the second corner.
    pub u: [f32; BATCH],
    /// How far along the edge to the last corner.
    pub v: [f32; BATCH],
    /// Shape of the instance, or NONE.
    pub instance: [u32; BATCH],
}

impl Default for Hits {
    fn default() -> Self {
        use crate::generated::{FAR, NONE};
        Self { t: [FAR; BATCH], id: [NONE; BATCH], u: [0.0; BATCH], v: [0.0; BATCH], instance: [NONE; BATCH] }
    }
}

/// A number a ray.
pub type Of<const N: usize> = [f32; N];

/// N rays: against boxes `inverse`, `near`, `far` and `slack`, against primitives the others, which are `Probe`'s.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct Prepared<const N: usize> {
    pub o: [Of<N>; 3],
    pub d: [Of<N>; 3],
    pub x: [Of<N>; 3],
    pub y: [Of<N>; 3],
    pub inverse: [Of<N>; 3],
    pub near: [Of<N>; 3],
    pub far: [Of<N>; 3],
    /// By how much a hit may lie before its box.
    pub slack: Of<N>,
    /// Bit i: whether the ray goes towards negative values of axis i.
    pub negative: [u8; N],
}

/// A ray of no length along an axis never leaves a box there.
const LEAST_DIRECTION: f32 = 1e-20;

/// By how much, of the largest coordinate, rounding may move a hit against the box around it. Boxes are that much
/// larger, so that no ray slips between two, and what is found depends on the primitives alone.
const SLACK: f32 = 16.0 * f32::EPSILON;

#[inline(always)]
pub fn load<L: Lanes, const N: usize>(numbers: &[Of<N>; 3], at: usize) -> [L; 3] {
    [L::load(&numbers[0][at..]), L::load(&numbers[1][at..]), L::load(&numbers[2][at..])]
}

#[inline(always)]
pub fn splat<L: Lanes, const N: usize>(numbers: &[Of<N>; 3], i: usize) -> [L; 3] {
    [L::splat(numbers[0][i]), L::splat(numbers[1][i]), L::splat(numbers[2][i])]
}

impl<const N: usize> Prepared<N> {
    /// Rays from `o` along `d` in a scene whose largest coordinate is `reach`.
    #[inline(always)]
    pub fn new<L: Lanes>(o: &[Of<N>; 3], d: &[Of<N>; 3], reach: f32) -> Self {
        let none = [[0.0; N]; 3];
        let mut all = Self {
            o: *o,
            d: *d,
            x: none,
            y: none,
            inverse: none,
            near: none,
            far: none,
            slack: [0.0; N],
            negative: [0; N],
        };
        for at in (0..N).step_by(L::COUNT) {
            all.prepare::<L>(at, reach);
        }
        all
    }

    #[inline(always)]
    fn prepare<L: Lanes>(&mut self, at: usize, reach: f32) {
        let (zero, one, minus) = (L::splat(0.0), L::splat(1.0), L::splat(-1.0));
        let (o, d) = (load::<L, N>(&self.o, at), load::<L, N>(&self.d, at));
        let size = |v: L| v.max(v.mul(minus));
        let slack = size(o[0]).max(size(o[1])).max(size(o[2])).add(L::splat(reach)).mul(L::splat(SLACK));
        slack.store(&mut self.slack[at..]);
        let mut signs = [0; 3];
        for axis in 0..3 {
            let least = L::splat(LEAST_DIRECTION);
            let negative = d[axis].lt(zero);
            let tiny = size(d[axis]).lt(least);
            let safe = L::select(d[axis], L::select(least, least.mul(minus), negative), tiny);
            let inverse = one.div(safe);
            let (start, margin) = (o[axis].mul(inverse).mul(minus), slack.mul(size(inverse)));
            inverse.store(&mut self.inverse[axis][at..]);
            start.sub(margin).store(&mut self.near[axis][at..]);
            start.add(margin).store(&mut self.far[axis][at..]);
            signs[axis] = L::bits(negative);
        }
        for i in 0..L::COUNT {
            if let Some(negative) = self.negative.get_mut(at + i) {
                *negative = ((signs[0] >> i & 1) | (signs[1] >> i & 1) << 1 | (signs[2] >> i & 1) << 2) as u8;
            }
        }
        // `frame_about` of shaders/math.wgsl.
        let s = L::select(one, minus, d[2].lt(zero));
        let a = minus.div(s.add(d[2]));
        let b = d[0].mul(d[1]).mul(a);
        one.add(s.mul(d[0]).mul(d[0]).mul(a)).store(&mut self.x[0][at..]);
        s.mul(b).store(&mut self.x[1][at..]);
        s.mul(minus).mul(d[0]).store(&mut self.x[2][at..]);
        b.store(&mut self.y[0][at..]);
        s.add(d[1].mul(d[1]).mul(a)).store(&mut self.y[1][at..]);
        d[1].mul(minus).store(&mut self.y[2][at..]);
    }
}
