//! The thread that renders: it takes the newest job, shows something soon and then something better, and drops it as
//! soon as there is a newer one.

use std::sync::Arc;
use std::time::{Duration, Instant};

use kinora_renderer::{Backend, Renderer, develop};
use kinora_scene::{Shutter, View, World};

use super::fit::limit;
use super::pace::Pace;
use super::slot::Slot;
use crate::session::Loaded;

/// Samples of the longest pass.
const LONGEST_PASS: u32 = 16;
/// Samples of a preview that nothing follows: whatever it shows is still moving.
const PREVIEW_SAMPLES: u32 = 16;
/// Pictures are not shown more often than this.
const SHOW_EVERY: Duration = Duration::from_millis(100);

/// A picture wanted.
pub struct Job {
    /// The scene.
    pub loaded: Arc<Loaded>,
    /// When the shutter is open.
    pub shutter: Shutter,
    /// Another camera than the scene's.
    pub view: Option<View>,
    /// Whether another job will soon follow.
    pub moving: bool,
    /// Longest side of a picture that the window can show, in pixels.
    pub max_side: u32,
    /// Which load of the scene this is.
    pub load: u64,
}

/// A picture made.
pub struct Picture {
    /// Display values, four bytes a pixel, row by row from the top.
    pub rgba: Vec<u8>,
    /// Its width and height in pixels.
    pub size: [u32; 2],
    /// Width and height that it has when it is no preview.
    pub full: [u32; 2],
    /// Samples a pixel so far.
    pub samples: u32,
    /// Samples a pixel when it is done.
    pub wanted: u32,
    /// How long these samples took.
    pub time: Duration,
    /// The load of [`Job::load`].
    pub load: u64,
}

/// Why there is no picture.
pub struct Failure {
    /// A finding with its place, as text.
    pub text: String,
    /// The load of [`Job::load`].
    pub load: u64,
}

/// Where jobs are left and pictures are fetched.
#[derive(Default)]
pub struct Desk {
    /// To the thread; closed when the window is.
    pub jobs: Slot<Job>,
    /// From the thread.
    pub results: Slot<Result<Picture, Failure>>,
}

/// Works until `desk.jobs` is closed; `wake` tells of every result.
pub fn run(backend: Box<dyn Backend>, desk: &Desk, wake: &dyn Fn()) {
    let mut worker = Worker { renderer: Renderer::new(backend), pace: Pace::default(), desk, wake };
    while let Some(job) = desk.jobs.wait() {
        if let Err(text) = worker.draw(&job) {
            desk.results.put(Err(Failure { text, load: job.load }));
            wake();
        }
    }
}

struct Worker<'a> {
    renderer: Renderer,
    pace: Pace,
    desk: &'a Desk,
    wake: &'a dyn Fn(),
}

impl Worker<'_> {
    fn draw(&mut self, job: &Job) -> Result<(), String> {
        // What is still moving is shown as it is at an instant.
        let close_s = if job.moving { job.shutter.open_s } else { job.shutter.close_s };
        let shutter = Shutter { close_s, ..job.shutter };
        let mut world = job.loaded.sample(shutter).map_err(|found| job.loaded.plain(&found))?;
        if let Some(view) = &job.view {
            for moment in Arc::make_mut(&mut world.moments) {
                moment.view = view.clone();
            }
            world.view = view.clone();
        }
        let full = limit(world.render.resolution, job.max_side);
        let wanted = world.render.samples;
        if let Some(small) = self.pace.preview(full, job.moving) {
            world.render.resolution = small;
            let samples = if job.moving { PREVIEW_SAMPLES.min(wanted) } else { 1 };
            if !self.refine(&world, samples, full, job)? || job.moving {
                return Ok(());
            }
        }
        world.render.resolution = full;
        self.refine(&world, wanted, full, job).map(|_| ())
    }

    /// Adds samples up to `samples`; false if a newer job came in between.
    fn refine(&mut self, world: &World, samples: u32, full: [u32; 2], job: &Job) -> Result<bool, String> {
        let mut film = self.renderer.load(world).map_err(said)?;
        let size = film.size();
        let start = Instant::now();
        let mut shown: Option<Instant> = None;
        while let Some(next) = film.next_pass(samples) {
            let done = film.samples();
            let end = done.saturating_add(self.pace.pass(size, done, LONGEST_PASS)).min(next.end);
            // However fast jobs follow each other, each shows at least its preview.
            let preview = done == 0 && size != full;
            let jobs = &self.desk.jobs;
            let go_on = |_: f64| if preview { !jobs.closed() } else { !jobs.calls() };
            let begun = Instant::now();
            if !self.renderer.trace_pass(&mut film, end, &go_on).map_err(said)? {
                return Ok(false);
            }
            self.pace.learn(size, end - done, begun.elapsed().as_secs_f64());
            let last = film.next_pass(samples).is_none();
            if last || shown.is_none_or(|shown| shown.elapsed() >= SHOW_EVERY) {
                let time = start.elapsed();
                let rgba = develop(&film, &world.look).screen();
                // Pixels may have enough before they have all.
                let wanted = if last && film.is_adaptive() { end } else { world.render.samples };
                let picture = Picture { rgba, size, full, samples: end, wanted, time, load: job.load };
                self.desk.results.put(Ok(picture));
                (self.wake)();
                shown = Some(Instant::now());
            }
            if jobs.calls() {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

fn said(error: kinora_renderer::RenderError) -> String {
    format!("error: {error}")
}
