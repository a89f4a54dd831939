//! The thread that renders: it takes the newest job, shows something soon and then something better, and drops it as
//! soon as there is a newer one.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use kinora_renderer::{Backend, Changes, Film, Renderer, Request, Window, develop};
use kinora_scene::{Look, Shutter, Still, View, World};

use super::fit::limit;
use super::pace::Pace;
use super::picture::Looking;
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
    /// How the picture is looked at.
    pub looking: Looking,
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
    /// The rays that they took.
    pub rays: u64,
    /// When the shutter opens, in seconds.
    pub open_s: f64,
    /// The load of [`Job::load`].
    pub load: u64,
    /// How it came about.
    pub making: Making,
}

/// How the first picture of a load came about.
#[derive(Clone, Debug, Default)]
pub struct Making {
    /// What of the scene had to be made anew.
    pub anew: Changes,
    /// How long it took to evaluate the scene at its time.
    pub sample: Duration,
    /// To make the renderer's arrays.
    pub build: Duration,
    /// To trace the first samples, and to make a picture of them.
    pub trace: Duration,
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
    /// When the window was used last.
    used: Mutex<Option<Instant>>,
}

/// For so long after the last move of the hand a core is left to the window.
const IN_USE: Duration = Duration::from_secs(2);

impl Desk {
    /// The window is in use.
    pub fn touch(&self) {
        *self.used.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
    }

    fn in_use(&self) -> bool {
        self.used.lock().unwrap_or_else(PoisonError::into_inner).is_some_and(|used| used.elapsed() < IN_USE)
    }
}

/// Works until `desk.jobs` is closed; `wake` tells of every result.
pub fn run(backend: Box<dyn Backend>, desk: &Desk, wake: &dyn Fn()) {
    let mut worker = Worker {
        renderer: Renderer::new(backend),
        pace: Pace::default(),
        current: None,
        making: (0, Making::default()),
        whole: None,
        desk,
        wake,
    };
    while let Some(job) = desk.jobs.wait() {
        let load = job.load;
        if let Err(text) = worker.draw(job) {
            worker.current = None;
            desk.results.put(Err(Failure { text, load }));
            wake();
        }
    }
}

struct Worker<'a> {
    renderer: Renderer,
    pace: Pace,
    /// What is being refined, which the renderer holds.
    current: Option<Current>,
    /// How the first picture of a load comes about.
    making: (u64, Making),
    /// The last whole picture, on which parts of it are shown.
    whole: Option<([u32; 2], Vec<u8>)>,
    desk: &'a Desk,
    wake: &'a dyn Fn(),
}

/// A picture at work.
struct Current {
    job: Job,
    world: World,
    /// As the scene has it.
    look: Look<Still>,
    film: Film,
    /// Width and height that it has when it is no preview.
    full: [u32; 2],
    time: Duration,
}

impl Current {
    /// Whether its samples are what `job` asks for.
    fn serves(&self, job: &Job) -> bool {
        let own = &self.job;
        !own.moving
            && !job.moving
            && own.load == job.load
            && own.shutter == job.shutter
            && own.view == job.view
            && own.max_side == job.max_side
            && !own.looking.needs_others(&job.looking)
    }

    /// How many samples it is to have.
    fn wanted(&self) -> u32 {
        let samples = self.world.render.samples;
        match self.job.looking.paused {
            // Something is to be seen.
            true => self.film.samples().max(1).min(samples),
            false => samples,
        }
    }
}

impl Worker<'_> {
    fn draw(&mut self, job: Job) -> Result<(), String> {
        let mut current = match self.current.take() {
            Some(mut current) if current.serves(&job) => {
                let before = std::mem::replace(&mut current.job, job).looking;
                let now = &current.job.looking;
                if (before.stops, before.tonemap) != (now.stops, now.tonemap) {
                    current.world.look = current.look.clone();
                    now.apply(&mut current.world);
                    if current.film.samples() > 0 {
                        self.show(&current);
                    }
                }
                current
            }
            _ => match self.begin(job)? {
                Some(current) => current,
                None => return Ok(()),
            },
        };
        let wanted = current.wanted();
        self.refine(&mut current, wanted)?;
        self.current = Some(current);
        Ok(())
    }

    /// A picture of which a preview was shown if it is to take long; `None` where nothing is to follow.
    fn begin(&mut self, job: Job) -> Result<Option<Current>, String> {
        let start = Instant::now();
        // What is still moving is shown as it is at an instant.
        let close_s = if job.moving { job.shutter.open_s } else { job.shutter.close_s };
        let shutter = Shutter { close_s, ..job.shutter };
        let mut world = job.loaded.sample(shutter).map_err(|found| job.loaded.plain(&found))?;
        if self.making.0 != job.load {
            self.making = (job.load, Making { sample: start.elapsed(), ..Making::default() });
        }
        if let Some(view) = &job.view {
            for moment in Arc::make_mut(&mut world.moments) {
                moment.view = view.clone();
            }
            world.view = view.clone();
        }
        let look = world.look.clone();
        job.looking.apply(&mut world);
        let full = limit(world.render.resolution, job.max_side);
        let window = job.looking.window(full).filter(|_| !job.moving);
        let small = self.pace.preview(full, job.moving).filter(|_| window.is_none());
        world.render.resolution = small.unwrap_or(full);
        let film = self.load(&world, window)?;
        let mut current = Current { job, world, look, film, full, time: Duration::ZERO };
        if small.is_none() && !current.job.moving {
            return Ok(Some(current));
        }
        let samples = if current.job.moving { PREVIEW_SAMPLES.min(current.world.render.samples) } else { 1 };
        if !self.refine(&mut current, samples)? || current.job.moving {
            return Ok(None);
        }
        current.world.render.resolution = full;
        current.film = self.load(&current.world, None)?;
        current.time = Duration::ZERO;
        Ok(Some(current))
    }

    fn load(&mut self, world: &World, window: Option<[u32; 4]>) -> Result<Film, String> {
        let crop = window.map(|[left, top, width, height]| Window { left, top, width, height });
        let film = self.renderer.load_for(world, &Request { crop, ..Request::default() }).map_err(said)?;
        let making = &mut self.making.1;
        if making.trace.is_zero() {
            making.anew = making.anew.and(self.renderer.changes());
            making.build += self.renderer.build_time();
        }
        Ok(film)
    }

    /// Adds samples up to `samples`; false if a newer job came in between.
    fn refine(&mut self, current: &mut Current, samples: u32) -> Result<bool, String> {
        let (size, before, start) = (current.film.size(), current.time, Instant::now());
        let preview = current.world.render.resolution != current.full;
        let mut shown: Option<Instant> = None;
        while let Some(next) = current.film.next_pass(samples) {
            let done = current.film.samples();
            let end = done.saturating_add(self.pace.pass(size, done, LONGEST_PASS)).min(next.end);
            // However fast jobs follow each other, each shows at least its preview.
            let first = done == 0 && (preview || current.job.moving);
            let jobs = &self.desk.jobs;
            let go_on = |_: f64| if first { !jobs.closed() } else { !jobs.calls() };
            let begun = Instant::now();
            self.renderer.leave_core(current.job.moving || self.desk.in_use());
            if !self.renderer.trace_pass(&mut current.film, end, &go_on).map_err(said)? {
                return Ok(false);
            }
            self.pace.learn(size, end - done, begun.elapsed().as_secs_f64());
            current.time = before + start.elapsed();
            let last = current.film.next_pass(samples).is_none();
            if last || shown.is_none_or(|shown| shown.elapsed() >= SHOW_EVERY) {
                if self.making.1.trace.is_zero() {
                    self.making.1.trace = begun.elapsed();
                }
                self.show(current);
                shown = Some(Instant::now());
            }
            if self.desk.jobs.calls() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Sends what there is of a picture to the window.
    fn show(&mut self, current: &Current) {
        let Current { job, world, film, full, time, .. } = current;
        let rgba = develop(film, &world.look).screen();
        let samples = film.samples();
        // Pixels may have enough before they have all.
        let enough = film.is_adaptive() && film.next_pass(world.render.samples).is_none();
        let wanted = if enough { samples } else { world.render.samples };
        let rgba = match film.size() == film.picture() {
            true => rgba,
            false => self.on_whole(film.window(), *full, &rgba),
        };
        let size = film.picture();
        if size == *full && film.size() == size {
            self.whole = Some((size, rgba.clone()));
        }
        let picture = Picture {
            rgba,
            size,
            full: *full,
            samples,
            wanted,
            time: *time,
            rays: film.rays(),
            open_s: job.shutter.open_s,
            load: job.load,
            making: self.making.1.clone(),
        };
        self.desk.results.put(Ok(picture));
        (self.wake)();
    }

    /// A part of a picture on the last whole one of its size.
    fn on_whole(&self, window: Window, size: [u32; 2], rgba: &[u8]) -> Vec<u8> {
        let [width, height] = size.map(|side| side as usize);
        let mut all = match &self.whole {
            Some((of, whole)) if *of == size => whole.clone(),
            _ => [0, 0, 0, 255].repeat(width * height),
        };
        let row = window.width as usize * 4;
        for (y, own) in rgba.chunks_exact(row.max(4)).enumerate() {
            let start = ((window.top as usize + y) * width + window.left as usize) * 4;
            if let Some(line) = all.get_mut(start..start + row) {
                line.copy_from_slice(own);
            }
        }
        all
    }
}

fn said(error: kinora_renderer::RenderError) -> String {
    format!("error: {error}")
}
