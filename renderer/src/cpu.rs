//! The CPU backend: the translated kernel, run by rayon over tiles.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec4, Vec4Swizzles};
use kinora_kernel::generated::{self, FeatureSum, PartsSum};
use kinora_kernel::lanes::{self, PixelSample, Width};
use kinora_kernel::{Kernel, Packed};
use rayon::prelude::*;

use crate::backend::{Backend, BackendError, Control};
use crate::film::{Parts, Survey};

/// Side of a tile in pixels: small enough to share out evenly, large enough that a tile's rays meet the same nodes.
const TILE: u32 = 16;
/// Paths whose light is kept until their samples are summed in order.
const MOST_PATHS: usize = 1 << 16;

/// The CPU of this machine.
pub struct Cpu {
    pool: rayon::ThreadPool,
    /// One thread less, for when a core is to be left to others.
    smaller: Option<rayon::ThreadPool>,
    leaves: bool,
    packed: Option<Arc<Packed>>,
    width: Width,
}

impl Cpu {
    /// `threads` of them, 0 for one a core.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn new(threads: usize) -> Result<Self, BackendError> {
        Ok(Self { pool: pool(threads)?, smaller: None, leaves: false, packed: None, width: Width::best() })
    }

    /// Shades so many paths at once, for comparison: it changes the speed and nothing else.
    #[must_use]
    pub fn with_width(self, width: Width) -> Self {
        Self { width, ..self }
    }
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, BackendError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| BackendError::Threads(error.to_string()))
}

impl Backend for Cpu {
    fn name(&self) -> &'static str {
        "cpu"
    }

    fn device(&self) -> String {
        let threads = self.pool.current_num_threads();
        format!("CPU, {threads} thread{}", if threads == 1 { "" } else { "s" })
    }

    fn upload(&mut self, packed: Arc<Packed>) -> Result<(), BackendError> {
        self.packed = Some(packed);
        Ok(())
    }

    fn leave_core(&mut self, leave: bool) {
        let threads = self.pool.current_num_threads();
        self.leaves = leave && threads > 1;
        if self.leaves && self.smaller.is_none() {
            // Without it, the work goes on as before.
            self.smaller = pool(threads - 1).ok();
        }
    }

    fn release(&mut self) {
        self.packed = None;
    }

    fn trace(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec4>>, BackendError> {
        self.each(pixels, control, |kernel, pixels| {
            let trace = |place: PixelSample<'_>, light: &mut [Vec4]| lanes::radiance(kernel, self.width, place, light);
            sums(pixels, &samples, trace, |light| light.iter().sum())
        })
    }

    fn trace_parts(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Parts>>, BackendError> {
        self.each(pixels, control, |kernel, pixels| {
            let trace = |place: PixelSample<'_>, parts: &mut [generated::Parts]| {
                lanes::radiance_parts(kernel, self.width, place, parts);
            };
            sums(pixels, &samples, trace, |parts| {
                let sum = parts.iter().fold(PartsSum::default(), |sum, sample| kernel.parts_sum(sum, *sample));
                [sum.light, sum.squares, sum.emission, sum.diffuse, sum.specular]
            })
        })
    }

    fn survey(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Survey>>, BackendError> {
        self.each(pixels, control, |kernel, pixels| {
            let survey = |&pixel: &UVec2| {
                let zero = FeatureSum::default();
                let sum = samples.clone().fold(zero, |sum, sample| kernel.features_add(sum, pixel, sample));
                [sum.albedo, sum.normal, sum.position, sum.shape]
            };
            pixels.iter().map(survey).collect()
        })
    }
}

// The sums over these samples of each of the pixels. `trace` fills a list with what it finds, `MOST_PATHS` at once.
fn sums<T: Clone + Default, S>(
    pixels: &[UVec2],
    samples: &Range<u32>,
    trace: impl Fn(PixelSample<'_>, &mut [T]),
    sum: impl Fn(&[T]) -> S,
) -> Vec<S> {
    let count = samples.len();
    let mut sums = Vec::with_capacity(pixels.len());
    for pixels in pixels.chunks((MOST_PATHS / count.max(1)).max(1)) {
        let mut found = vec![T::default(); pixels.len() * count];
        trace(&|i| (pixels[i / count], samples.start + (i % count) as u32), &mut found);
        sums.extend((0..pixels.len()).map(|i| sum(&found[i * count..][..count])));
    }
    sums
}

/// A part of a pass.
#[derive(Clone, Copy)]
enum Part<'a> {
    /// Tile of the window, from its corner.
    Tile(UVec2),
    /// Pixels of a list, from this one on.
    List(usize, &'a [UVec2]),
}

impl Cpu {
    // Works on the window tile by tile, or on a list of pixels part by part: `work` gives a value for each of a part's
    // pixels; `None` if `control` ended it.
    fn each<T: Copy + Default + Send>(
        &self,
        listed: Option<&[UVec2]>,
        control: &dyn Control,
        work: impl Fn(&Kernel<'_>, &[UVec2]) -> Vec<T> + Sync,
    ) -> Result<Option<Vec<T>>, BackendError> {
        let packed = self.packed.as_deref().ok_or(BackendError::Nothing)?;
        let window = packed.params.window;
        let size = window.zw();
        const LENGTH: usize = (TILE * TILE) as usize;
        let parts: Vec<Part<'_>> = match listed {
            Some(list) => list.chunks(LENGTH).enumerate().map(|(i, list)| Part::List(i * LENGTH, list)).collect(),
            None => {
                let (columns, rows) = (size.x.div_ceil(TILE), size.y.div_ceil(TILE));
                let row = |y| (0..columns).map(move |x| Part::Tile(UVec2::new(x, y) * TILE));
                (0..rows).flat_map(row).collect()
            }
        };
        let stop = AtomicBool::new(false);
        let mut values = vec![T::default(); listed.map_or(size.x as usize * size.y as usize, <[UVec2]>::len)];
        let (sender, finished) = std::sync::mpsc::channel();
        // The work runs in the pool, the caller's thread collects it and stays free to say stop.
        std::thread::scope(|scope| {
            let pool = self.smaller.as_ref().filter(|_| self.leaves).unwrap_or(&self.pool);
            let (parts, stop, work) = (&parts, &stop, &work);
            scope.spawn(move || {
                pool.install(|| {
                    parts.par_iter().with_max_len(1).for_each_with(sender, |sender, &part| {
                        if !stop.load(Ordering::Relaxed) {
                            let pixels = packed.with_kernel(|kernel| match part {
                                Part::List(_, list) => work(kernel, list),
                                Part::Tile(tile) => {
                                    let end = (tile + UVec2::splat(TILE)).min(size);
                                    let places: Vec<_> = (tile.y..end.y)
                                        .flat_map(|y| (tile.x..end.x).map(move |x| window.xy() + UVec2::new(x, y)))
                                        .collect();
                                    work(kernel, &places)
                                }
                            });
                            // The receiver is gone only after `stop`.
                            let _ = sender.send((part, pixels));
                        }
                    });
                });
            });
            let mut done = 0;
            for (part, pixels) in finished {
                match part {
                    Part::List(start, list) => values[start..start + list.len()].copy_from_slice(&pixels),
                    Part::Tile(tile) => {
                        let width = TILE.min(size.x - tile.x) as usize;
                        for (row, line) in pixels.chunks_exact(width).enumerate() {
                            let start = (tile.y as usize + row) * size.x as usize + tile.x as usize;
                            values[start..start + width].copy_from_slice(line);
                        }
                    }
                }
                done += 1;
                if !control.keep_going(f64::from(done) / parts.len() as f64) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        });
        Ok((!stop.into_inner()).then_some(values))
    }
}
