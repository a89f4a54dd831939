//! The CPU backend: the translated kernel, run by rayon over tiles.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec4};
use kinora_kernel::Packed;
use kinora_kernel::lanes::{self, Width};
use rayon::prelude::*;

use crate::backend::{Backend, BackendError, Control};

/// Side of a tile in pixels: small enough to share out evenly, large enough that a tile's rays meet the same nodes.
const TILE: u32 = 16;

/// The CPU of this machine.
pub struct Cpu {
    pool: rayon::ThreadPool,
    packed: Option<Arc<Packed>>,
    width: Width,
}

impl Cpu {
    /// `threads` of them, 0 for one a core.
    ///
    /// # Errors
    /// The system gives no threads.
    pub fn new(threads: usize) -> Result<Self, BackendError> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| BackendError::Threads(error.to_string()))?;
        Ok(Self { pool, packed: None, width: Width::best() })
    }

    /// Shades so many paths at once, for comparison: it changes the speed and nothing else.
    #[must_use]
    pub fn with_width(self, width: Width) -> Self {
        Self { width, ..self }
    }
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

    fn trace(&mut self, samples: Range<u32>, control: &dyn Control) -> Result<Option<Vec<Vec4>>, BackendError> {
        let packed = self.packed.as_deref().ok_or(BackendError::Nothing)?;
        let size = packed.params.resolution;
        let (columns, rows) = (size.x.div_ceil(TILE), size.y.div_ceil(TILE));
        let stop = AtomicBool::new(false);
        let mut sums = vec![Vec4::ZERO; size.x as usize * size.y as usize];
        let (sender, finished) = std::sync::mpsc::channel();
        let tiles: Vec<UVec2> = (0..rows).flat_map(|y| (0..columns).map(move |x| UVec2::new(x, y) * TILE)).collect();
        // The work runs in the pool, the caller's thread collects it and stays free to say stop.
        std::thread::scope(|scope| {
            let (pool, width, tiles, stop, samples) = (&self.pool, self.width, &tiles, &stop, &samples);
            scope.spawn(move || {
                pool.install(|| {
                    tiles.par_iter().with_max_len(1).for_each_with(sender, |sender, &tile| {
                        if !stop.load(Ordering::Relaxed) {
                            // The receiver is gone only after `stop`.
                            let _ = sender.send((tile, trace_tile(packed, width, tile, samples.clone())));
                        }
                    });
                });
            });
            let mut done = 0;
            for (tile, pixels) in finished {
                let width = TILE.min(size.x - tile.x) as usize;
                for (row, values) in pixels.chunks_exact(width).enumerate() {
                    let start = (tile.y as usize + row) * size.x as usize + tile.x as usize;
                    sums[start..start + width].copy_from_slice(values);
                }
                done += 1;
                if !control.keep_going(f64::from(done) / tiles.len() as f64) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        });
        Ok((!stop.into_inner()).then_some(sums))
    }
}

// The tile's sums, row by row.
fn trace_tile(packed: &Packed, width: Width, tile: UVec2, samples: Range<u32>) -> Vec<Vec4> {
    let size = (tile + UVec2::splat(TILE)).min(packed.params.resolution) - tile;
    let count = samples.len();
    let mut light = vec![Vec4::ZERO; (size.x * size.y) as usize * count];
    let pixel_sample = |i: usize| {
        let (pixel, sample) = ((i / count) as u32, (i % count) as u32);
        (tile + UVec2::new(pixel % size.x, pixel / size.x), samples.start + sample)
    };
    packed.with_kernel(|kernel| lanes::radiance(kernel, width, &pixel_sample, &mut light));
    light.chunks_exact(count.max(1)).map(|pixel| pixel.iter().sum()).collect()
}
