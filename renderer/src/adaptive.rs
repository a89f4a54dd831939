//! How many samples each pixel gets where `render.adaptive` asks for a relative error.
//!
//! Whoever stops a pixel once its own samples agree stops those that have not seen yet what is rare and bright, and the
//! picture darkens (Kirk and Arvo, "Unbiased sampling techniques for image synthesis", SIGGRAPH 1991). Their remedy is to
//! decide by pilot samples and to throw these away. Here nothing is thrown away: **a pixel's number of samples is decided
//! once, by the pilot samples of its neighbours, never by its own**, and all pilots are equally long. So the number is
//! independent of the samples that it counts, and the mean of these has no bias, whatever the estimate is worth.
//!
//! The pilot is `min_samples`, in [`BLOCKS`] blocks of one Sobol sequence; between the means of a pixel's blocks lies the
//! variance that counts (so stratification within a block does). The neighbours of a pixel are those of its own kind: where
//! paths scatter, or where only the sky and lamps are seen. Which kind it is of, the eight pixels around it say. Of the
//! 3 × 3 around it two estimates are made of variance / mean², and the larger counts:
//! - the sum of variances over the squared sum of means, in which a bright event that one pixel of many has seen counts in
//!   full; the 13 × 13 around it join in with the weight of six pixels and the 33 × 33 with that of one, for what is so rare
//!   that nobody near by has seen it;
//! - the mean over the pixels of variance / mean², which sees dark pixels beside bright ones.
//!
//! The number itself: where the squared error of a pixel falls as r² / nᵃ, r being the relative standard deviation of one
//! sample, a given sum of samples leaves the least sum of squared errors if n ~ r^(2 / (1 + a)) (Neyman, "On the Two Different
//! Aspects of the Representative Method", 1934, has a = 1). Numbers that would give all pixels the same error, n ~ r² at
//! a = 1, are no better than the same number everywhere: what is saved where there is little noise goes to where a sample
//! helps least. Sobol points have a between 1 and 2, and n ~ r^(2/3) turns out best; beyond [`NOISY`], n ~ r² again, so
//! that no pixel is far from the target.

use glam::{UVec2, Vec4};
use kinora_kernel::PASS_SAMPLES;
use kinora_scene::Render;
use rayon::prelude::*;

use crate::film::Window;
use crate::moments::Blocks;

/// Blocks of the pilot.
const BLOCKS: u32 = 4;
/// How far neighbours reach, in pixels.
const NEAR: u32 = 1;
/// How far those reach that join in with the weight of [`MIDDLE_WEIGHT`] pixels.
const MIDDLE: u32 = 6;
const MIDDLE_WEIGHT: f64 = 6.0;
/// How far those reach that join in with the weight of one pixel; as far are pixels traced around a crop.
const FAR: u32 = 16;
/// Variance of one sample / mean² above which pixels get samples in proportion to it; there the error is expected to be
/// twice the target, if it falls as 1 / √n. It is the target where this number is 1 / √8.
const NOISY: f64 = 2.828_427_1;
/// Side of a tile in pixels: pixels that are traced together lie together.
const TILE: u32 = 16;

/// What the pilot says of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Pilot {
    /// Sum of luminance over the block that is not yet full.
    block: f32,
    /// Mean of the means of full blocks, and the sum of the squares of their distances from it.
    mean: f32,
    squares: f32,
    /// Whether a path went on from something.
    scatters: bool,
}

/// The state of adaptive sampling: first a pilot of all pixels and a margin, then a number for each.
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptive {
    target: f64,
    /// Samples of a block.
    block: u32,
    most: u32,
    window: Window,
    traced: Window,
    /// Of `traced`; empty when it is over.
    pilots: Vec<Pilot>,
    /// Samples wanted of the pixels of `window`; empty before the pilot is over.
    counts: Vec<u32>,
    /// The pixels of `window` that want more, tile by tile.
    active: Vec<u32>,
    /// Samples taken and wanted, all pixels of the window together.
    taken: f64,
    wanted: f64,
}

/// Most bytes a pixel.
pub const BYTES: usize = size_of::<Pilot>() + 2 * size_of::<u32>() + size_of::<UVec2>();

/// The part of a picture that has to be traced for `window`.
pub fn traced(render: &Render, window: Window) -> Window {
    match is_on(render) {
        true => with_margin(window, render.resolution),
        false => window,
    }
}

fn with_margin(window: Window, [width, height]: [u32; 2]) -> Window {
    let (left, top) = (window.left.saturating_sub(FAR), window.top.saturating_sub(FAR));
    let end = |start: u32, length: u32, all: u32| start.saturating_add(length).saturating_add(FAR).min(all);
    let (right, bottom) = (end(window.left, window.width, width), end(window.top, window.height, height));
    Window { left, top, width: right - left, height: bottom - top }
}

/// Whether pixels may get different numbers of samples.
pub fn is_on(render: &Render) -> bool {
    render.adaptive > 0.0 && render.samples > BLOCKS * block_of(render.min_samples)
}

fn block_of(min_samples: u32) -> u32 {
    min_samples.div_ceil(BLOCKS).max(1)
}

impl Adaptive {
    /// Before the first sample; `None` if memory does not hold it.
    pub fn new(render: &Render, window: Window) -> Option<Self> {
        let traced = traced(render, window);
        let mut pilots = Vec::new();
        pilots.try_reserve_exact(traced.pixels()).ok()?;
        pilots.resize(traced.pixels(), Pilot::default());
        Some(Self {
            target: render.adaptive,
            block: block_of(render.min_samples),
            most: render.samples,
            window,
            traced,
            pilots,
            counts: Vec::new(),
            active: Vec::new(),
            taken: 0.0,
            wanted: 0.0,
        })
    }

    /// The end of the next pass, which begins with sample `first`; `None` if no pixel wants it.
    pub fn end_of_pass(&self, first: u32) -> Option<u32> {
        let next = |step: u32| (first / step + 1).saturating_mul(step);
        match self.is_decided() {
            false => Some(next(self.block).min(first.saturating_add(PASS_SAMPLES))),
            true => (!self.active.is_empty()).then(|| next(PASS_SAMPLES)),
        }
    }

    /// Whether every pixel has its number.
    pub fn is_decided(&self) -> bool {
        self.pilots.is_empty()
    }

    /// The part of the picture that the pilot is traced of.
    pub fn traced(&self) -> Window {
        self.traced
    }

    /// The pixels of the window that want more, by their index; none before the pilot is over.
    pub fn active(&self) -> &[u32] {
        &self.active
    }

    /// Samples wanted of a pixel of the window; `None` before the pilot is over.
    pub fn count(&self, i: usize) -> Option<u32> {
        self.counts.get(i).copied()
    }

    /// Samples taken of the window's pixels, all together.
    pub fn taken(&self) -> f64 {
        self.taken
    }

    /// How much of all work will be done, in 0..=1, `more` samples later; once the pilot is over.
    pub fn share(&self, more: f64) -> f64 {
        (self.taken + more * self.active.len() as f64) / self.wanted.max(1.0)
    }

    /// Takes a pass that ends with sample `end`: sums of light and rays of `samples` samples, of all that is traced.
    /// `blocks` where samples see several moments.
    pub fn learn(&mut self, light: &[Vec4], samples: u32, end: u32, blocks: Option<&Blocks>) {
        if self.is_decided() {
            self.taken += f64::from(samples) * self.active.len() as f64;
            self.active.retain(|i| self.counts[*i as usize] > end);
            return;
        }
        self.taken += f64::from(samples) * self.window.pixels() as f64;
        let full = end.is_multiple_of(self.block);
        let (length, nth) = (self.block as f32, (end / self.block) as f32);
        self.pilots.par_iter_mut().zip(light).for_each(|(pilot, part)| {
            pilot.block += part.truncate().dot(LUMINANCE);
            pilot.scatters |= part.w > samples as f32;
            if full {
                // Welford's recurrence: what does not vary has no variance at all.
                let mean = pilot.block / length;
                let off = mean - pilot.mean;
                pilot.mean += off / nth;
                pilot.squares += off * (mean - pilot.mean);
                pilot.block = 0.0;
            }
        });
        if end >= BLOCKS * self.block {
            self.decide(end, blocks);
        }
    }

    fn decide(&mut self, end: u32, blocks: Option<&Blocks>) {
        let Window { width, height, .. } = self.window;
        self.counts = (0..height).into_par_iter().flat_map_iter(|y| self.row(y, blocks)).collect();
        self.wanted = self.counts.iter().map(|count| f64::from(*count)).sum();
        self.pilots = Vec::new();
        let tiles =
            (0..height).step_by(TILE as usize).flat_map(|y| (0..width).step_by(TILE as usize).map(move |x| (x, y)));
        let pixels = tiles.flat_map(|(x, y)| {
            let (right, bottom) = ((x + TILE).min(width), (y + TILE).min(height));
            (y..bottom).flat_map(move |y| (x..right).map(move |x| y * width + x))
        });
        self.active = pixels.filter(|i| self.counts[*i as usize] > end).collect();
    }

    // Samples for row `y` of the window.
    fn row(&self, y: u32, blocks: Option<&Blocks>) -> Vec<u32> {
        let Window { left, top, width, height } = self.traced;
        let (x_first, y) = (self.window.left - left, y + self.window.top - top);
        let row = |y: u32| &self.pilots[y as usize * width as usize..][..width as usize];
        let around = |at: u32, reach: u32, end: u32| at.saturating_sub(reach)..(at + reach + 1).min(end);
        // Of each column as far as it reaches, kind by kind.
        let columns = [MIDDLE, FAR].map(|reach| {
            let mut columns = vec![[Sums::default(); 2]; width as usize];
            for y in around(y, reach, height) {
                for (column, pilot) in columns.iter_mut().zip(row(y)) {
                    column[usize::from(pilot.scatters)].add(self.variance(pilot), pilot.mean);
                }
            }
            columns
        });
        let count = |x: u32| {
            let others = |reach: u32| {
                let rows = around(y, reach, height);
                rows.flat_map(move |j| around(x, reach, width).map(move |i| (i, j)))
                    .filter(move |place| *place != (x, y))
                    .map(|(i, j)| &row(j)[i as usize])
            };
            let kind = others(1).any(|pilot| pilot.scatters);
            let mut near = Sums::default();
            for pilot in others(NEAR).filter(|pilot| pilot.scatters == kind) {
                near.add(self.variance(pilot), pilot.mean);
            }
            let wide = |columns: &[[Sums; 2]], reach: u32| {
                let mut sums = Sums::default();
                // Without the pixel's own column, which its own samples are in.
                for i in around(x, reach, width).filter(|i| *i != x) {
                    sums.join(&columns[i as usize][usize::from(kind)]);
                }
                sums
            };
            let (middle, far) = (wide(&columns[0], MIDDLE), wide(&columns[1], FAR));
            if near.pixels + far.pixels == 0.0 {
                return self.most;
            }
            let weights = [near.pixels, MIDDLE_WEIGHT.min(middle.pixels), 1.0_f64.min(far.pixels)];
            let relative = [near, middle, far].map(|sums| sums.relative());
            let sum: f64 = relative.iter().zip(weights).map(|(relative, weight)| weight * relative).sum();
            let together = sum / weights.iter().sum::<f64>();
            // A mean near 0 says as little as the few samples behind it.
            let least = 0.1 * near.mean().powi(2);
            let each = others(NEAR)
                .filter(|pilot| pilot.scatters == kind)
                .map(|pilot| ratio(self.variance(pilot), f64::from(pilot.mean).powi(2) + least));
            let each = ratio(each.sum::<f64>(), near.pixels);
            self.samples_for(together.max(each), blocks)
        };
        (x_first..x_first + self.window.width).map(count).collect()
    }

    // Of one sample, as far as blocks tell.
    fn variance(&self, pilot: &Pilot) -> f64 {
        f64::from(self.block) * f64::from(pilot.squares) / f64::from(BLOCKS - 1)
    }

    // Samples for a pixel by the variance of one of them / mean².
    fn samples_for(&self, relative: f64, blocks: Option<&Blocks>) -> u32 {
        let least = BLOCKS * self.block;
        let noise = if relative < NOISY { 0.5 * relative.cbrt() } else { 0.25 * relative };
        let wanted = noise / (self.target * self.target);
        let wanted = wanted.min(f64::from(u32::MAX - PASS_SAMPLES)).ceil() as u32;
        if wanted <= least {
            return least;
        }
        // Whole passes; all moments as often, which is the same for all pixels and so no noise that a neighbour takes off.
        blocks.map_or(wanted.next_multiple_of(PASS_SAMPLES), |blocks| blocks.even(wanted)).min(self.most)
    }
}

const LUMINANCE: glam::Vec3 = glam::Vec3::new(0.2126, 0.7152, 0.0722);

/// Sums over pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: f64,
    variance: f64,
    mean: f64,
}

impl Sums {
    fn add(&mut self, variance: f64, mean: f32) {
        self.pixels += 1.0;
        self.variance += variance;
        self.mean += f64::from(mean);
    }

    fn join(&mut self, other: &Sums) {
        self.pixels += other.pixels;
        self.variance += other.variance;
        self.mean += other.mean;
    }

    fn mean(&self) -> f64 {
        ratio(self.mean, self.pixels)
    }

    // Mean variance over the squared mean.
    fn relative(&self) -> f64 {
        ratio(ratio(self.variance, self.pixels), self.mean().powi(2))
    }
}

// 0 where there is nothing.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
