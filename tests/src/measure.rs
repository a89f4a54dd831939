//! Radiance of parts of a picture with how far it may be off, and when two such measurements disagree.

use std::f64::consts::FRAC_PI_2;
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use kinora_renderer::{Choice, Options, Renderer, open};
use kinora_scene::World;

/// The pixels `[left, top, right, bottom]`, the last two not included.
pub type Region = [u32; 4];

/// The mean radiance of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// By channel.
    pub mean: DVec3,
    /// Standard error of `mean`, by channel; 0 of what is known.
    pub error: DVec3,
    /// Degrees of freedom of `error`.
    pub degrees: f64,
}

impl Estimate {
    /// What is known in closed form, in all channels.
    pub fn known(value: f64) -> Estimate {
        Estimate { mean: DVec3::splat(value), error: DVec3::ZERO, degrees: f64::INFINITY }
    }

    /// The mean of independent estimates of one number, and how far they scatter about it.
    pub fn of(values: &[DVec3]) -> Estimate {
        let n = values.len() as f64;
        let mean = values.iter().sum::<DVec3>() / n;
        let variance = values.iter().map(|v| (*v - mean) * (*v - mean)).sum::<DVec3>() / (n * (n - 1.0));
        Estimate { mean, error: variance.map(f64::sqrt), degrees: n - 1.0 }
    }
}

/// A backend that renders one world after the other.
pub struct Kernel(Renderer);

impl Kernel {
    /// Opens a backend.
    ///
    /// # Panics
    /// It cannot be opened.
    pub fn open(choice: Choice) -> Kernel {
        Kernel(Renderer::new(open(choice, Options::default()).expect("the backend opens")))
    }

    /// The GPU, once a process since its programs take long to compile; `None` as [`crate::gpu`] says.
    pub fn gpu() -> Option<MutexGuard<'static, Kernel>> {
        static GPU: LazyLock<Option<Mutex<Kernel>>> =
            LazyLock::new(|| crate::gpu().map(|_| Mutex::new(Kernel::open(Choice::Gpu))));
        GPU.as_ref().map(|kernel| kernel.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Linear radiance of the world, row by row from the top.
    ///
    /// # Panics
    /// The world cannot be rendered.
    pub fn picture(&mut self, world: &World) -> Vec<DVec3> {
        let film = self.0.render(world, &()).expect("the world renders");
        film.mean().iter().map(|pixel| pixel.as_dvec3()).collect()
    }

    /// What the world shows in each region, by as many pictures as `seeds`, each with the samples that the world asks for.
    pub fn measure(&mut self, world: &World, regions: &[Region], seeds: u32) -> Vec<Estimate> {
        let mut world = world.clone();
        let mut values = vec![Vec::new(); regions.len()];
        for seed in 0..seeds {
            world.render.seed = seed;
            let picture = self.picture(&world);
            for (region, values) in regions.iter().zip(&mut values) {
                values.push(mean(&picture, world.render.resolution, *region));
            }
        }
        values.iter().map(|values| Estimate::of(values)).collect()
    }
}

/// The mean of a region of a picture.
pub fn mean(picture: &[DVec3], [width, _]: [u32; 2], [left, top, right, bottom]: Region) -> DVec3 {
    let row = |y: u32| &picture[(y * width + left) as usize..(y * width + right) as usize];
    (top..bottom).flat_map(row).sum::<DVec3>() / f64::from((right - left) * (bottom - top))
}

/// The level at which each of `tests` is judged so that all of them together fail one time in a hundred (Šidák).
pub fn level(tests: usize) -> f64 {
    1.0 - 0.99_f64.powf(1.0 / tests as f64)
}

/// How many standard errors a mean is off with the chance `level` if nothing is wrong: Student's distribution, from
/// both sides.
pub fn quantile(level: f64, degrees: f64) -> f64 {
    // The chance of |t| > √degrees tan θ goes as ∫ cos^(degrees − 1).
    let degrees = degrees.min(1000.0);
    let tail = |from: f64| {
        let steps = 2000;
        let width = (FRAC_PI_2 - from) / f64::from(steps);
        (0..steps).map(|i| (from + width * (f64::from(i) + 0.5)).cos().powf(degrees - 1.0)).sum::<f64>() * width
    };
    let whole = tail(0.0);
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if tail(middle) > level * whole { low = middle } else { high = middle }
    }
    degrees.sqrt() * low.tan()
}

/// How two estimates compare.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    /// The largest relative difference of a channel.
    pub off: f64,
    /// The same in standard errors.
    pub sigmas: f64,
    /// The smallest relative difference that would have been noticed, in the worst channel.
    pub sharp: f64,
    /// Whether noise and `tolerance` explain the difference.
    pub agree: bool,
}

/// Compares a measurement with the truth at a level; `tolerance` is relative, what the truth or f32 may be off by.
pub fn compare(got: &Estimate, truth: &Estimate, level: f64, tolerance: f64) -> Verdict {
    let mut verdict = Verdict { off: 0.0, sigmas: 0.0, sharp: 0.0, agree: true };
    let largest = truth.mean.max_element();
    for i in 0..3 {
        let (a, b) = (got.error[i].powi(2), truth.error[i].powi(2));
        let error = (a + b).sqrt();
        // Welch and Satterthwaite.
        let degrees = (a + b).powi(2) / (a * a / got.degrees + b * b / truth.degrees);
        let noise = if error > 0.0 { quantile(level, degrees) * error } else { 0.0 };
        // A channel that is nearly dark is judged by the others.
        let scale = if largest > 0.0 { truth.mean[i].abs().max(0.05 * largest) } else { 1.0 };
        let off = (got.mean[i] - truth.mean[i]).abs();
        verdict.off = verdict.off.max(off / scale);
        verdict.sigmas = verdict.sigmas.max(if error > 0.0 { off / error } else { 0.0 });
        verdict.sharp = verdict.sharp.max(noise / scale + tolerance);
        verdict.agree &= off <= noise + tolerance * scale + 1e-9;
    }
    verdict
}

/// The comparisons of one test.
pub struct Report {
    level: f64,
    failed: String,
}

impl Report {
    /// A report of so many comparisons of all channels, which fails without a reason one time in a hundred.
    pub fn new(comparisons: usize) -> Report {
        Report { level: level(3 * comparisons), failed: String::new() }
    }

    /// Adds one; it fails too if a relative difference of `sharp` would not have been noticed.
    pub fn compare(&mut self, name: &str, got: &Estimate, truth: &Estimate, tolerance: f64, sharp: f64) {
        let verdict = compare(got, truth, self.level, tolerance);
        let line = format!(
            "{name}: {:.5} for {:.5}: off by {:.3} %, {:.1} sigma; {:.3} % would be noticed\n",
            got.mean,
            truth.mean,
            100.0 * verdict.off,
            verdict.sigmas,
            100.0 * verdict.sharp
        );
        print!("{line}");
        if !verdict.agree || verdict.sharp > sharp {
            self.failed += &line;
        }
    }

    /// Fails if a comparison failed.
    ///
    /// # Panics
    /// One failed.
    pub fn finish(self) {
        assert!(self.failed.is_empty(), "\n{}", self.failed);
    }
}
