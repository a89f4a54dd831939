//! The renderer: a world in, a film out, on whatever backend there is.

use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use kinora_kernel::PASS_SAMPLES;
use kinora_scene::World;

use crate::backend::{Backend, BackendError, Control};
use crate::film::Film;
use crate::pack::{PackError, pack};

/// Why a world was not rendered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RenderError {
    /// The scene is beyond what the renderer can hold.
    Pack(PackError),
    /// The backend failed.
    Backend(BackendError),
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RenderError::Pack(error) => error.fmt(f),
            RenderError::Backend(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for RenderError {}

impl From<PackError> for RenderError {
    fn from(error: PackError) -> Self {
        RenderError::Pack(error)
    }
}

impl From<BackendError> for RenderError {
    fn from(error: BackendError) -> Self {
        RenderError::Backend(error)
    }
}

/// Renders worlds one after the other on one backend.
pub struct Renderer {
    backend: Box<dyn Backend>,
    build: Duration,
}

impl Renderer {
    /// A renderer on `backend`.
    pub fn new(backend: Box<dyn Backend>) -> Self {
        Self { backend, build: Duration::ZERO }
    }

    /// The backend.
    pub fn backend(&self) -> &dyn Backend {
        &*self.backend
    }

    /// How long the last [`Renderer::load`] took.
    pub fn build_time(&self) -> Duration {
        self.build
    }

    /// Takes `world`; gives its empty film.
    ///
    /// # Errors
    /// The world is too large or the backend fails; the world before it stays.
    pub fn load(&mut self, world: &World) -> Result<Film, RenderError> {
        let start = Instant::now();
        let packed = pack(world)?;
        self.backend.upload(Arc::new(packed))?;
        self.build = start.elapsed();
        let [width, height] = world.render.resolution;
        Ok(Film::new(width, height))
    }

    /// Adds one pass to `film`, of [`PASS_SAMPLES`] samples or as many as are missing to `samples`; false if there was
    /// nothing to add or `control` ended it, in which case the film is as it was.
    ///
    /// # Errors
    /// The backend fails.
    pub fn trace_pass(&mut self, film: &mut Film, samples: u32, control: &dyn Control) -> Result<bool, RenderError> {
        let first = film.samples();
        let end = samples.min(first.saturating_add(PASS_SAMPLES));
        if first >= end {
            return Ok(false);
        }
        let Some(pass) = self.backend.trace(first..end, control)? else { return Ok(false) };
        film.add(&pass, end - first);
        Ok(true)
    }

    /// Renders `world` with the samples it asks for. `control` hears of the whole picture; where it ends the work, the
    /// film holds the passes finished so far.
    ///
    /// # Errors
    /// As [`Renderer::load`] and [`Renderer::trace_pass`].
    pub fn render(&mut self, world: &World, control: &dyn Control) -> Result<Film, RenderError> {
        let mut film = self.load(world)?;
        let samples = world.render.samples;
        loop {
            let first = film.samples();
            let end = samples.min(first.saturating_add(PASS_SAMPLES));
            let whole = |done: f64| (f64::from(first) + done * f64::from(end - first)) / f64::from(samples.max(1));
            if !self.trace_pass(&mut film, samples, &|done| control.keep_going(whole(done)))? {
                return Ok(film);
            }
        }
    }
}
