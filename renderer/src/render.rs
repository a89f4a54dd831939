//! The renderer: a world in, a film out, on whatever backend there is.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{UVec2, UVec4, Vec4};
use kinora_kernel::Packed;
use kinora_scene::{Shown, View, World};

use crate::backend::{Backend, BackendError, Control};
use crate::film::{Film, Parts, Request, Survey, TooLarge, Window};
use crate::moments::Blocks;
use crate::motion::{Motion, Moved};
use crate::pack::{Changes, PackError, Packer, aim};
use crate::project::Projector;
use crate::wires::Wires;

// Whether two worlds have the same arrays, but for what the camera and the settings of the picture decide.
fn is_seen_otherwise(a: &World, b: &World) -> bool {
    // The look is of the finished picture, the shutter of nothing that stays where it is, and each moment is a world.
    let World {
        render: _,
        look: _,
        shutter: _,
        view: _,
        moments: _,
        next,
        instances,
        copies,
        parts,
        materials,
        sky,
        lights,
    } = a;
    next.is_none()
        && b.next.is_none()
        && *sky == b.sky
        && *lights == b.lights
        && *instances == b.instances
        && *copies == b.copies
        && *materials == b.materials
        && *parts == b.parts
}

/// Why a world was not rendered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RenderError {
    /// The scene is beyond what the renderer can hold.
    Pack(PackError),
    /// The backend failed.
    Backend(BackendError),
    /// The part of the picture that is wanted is empty or does not lie in it.
    Outside {
        /// The part.
        window: Window,
        /// Width and height of the picture.
        picture: [u32; 2],
    },
    /// Memory does not hold the picture.
    Memory {
        /// Width and height in pixels.
        size: [u32; 2],
        /// What they need.
        bytes: u64,
    },
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            RenderError::Pack(error) => error.fmt(f),
            RenderError::Backend(error) => error.fmt(f),
            RenderError::Outside { window: Window { left, top, width, height }, picture } => write!(
                f,
                "the crop {left},{top},{width},{height} is not a part of the picture, which is {} × {}",
                picture[0], picture[1]
            ),
            RenderError::Memory { size, bytes } => write!(
                f,
                "a picture of {} × {} pixels needs {:.1} GiB of memory: render parts of it with --crop",
                size[0],
                size[1],
                *bytes as f64 / f64::from(1 << 30)
            ),
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

/// Renders worlds one after the other on one backend. What a world has in common with the one before it is not built
/// again, which changes no bit.
pub struct Renderer {
    backend: Box<dyn Backend>,
    build: Duration,
    changes: Changes,
    moments: Moments,
    packer: Packer,
    held: Option<Held>,
}

/// What the backend holds.
struct Held {
    packed: Arc<Packed>,
    view: View,
    /// `None` of a first world, which may stay the only one.
    world: Option<Box<World>>,
}

/// The moments that the next passes show, where there are several.
#[derive(Default)]
struct Moments {
    worlds: Arc<Vec<World>>,
    /// Of the picture: the part that is traced.
    window: UVec4,
    /// The moment that the backend holds.
    held: Option<usize>,
}

/// What the pixels of a pass add up to; what nobody wants is empty.
#[derive(Default)]
struct Sums {
    light: Vec<Vec4>,
    parts: Vec<Parts>,
    surveys: Vec<Survey>,
}

impl Renderer {
    /// A renderer on `backend`.
    pub fn new(backend: Box<dyn Backend>) -> Self {
        Self {
            backend,
            build: Duration::ZERO,
            changes: Changes::default(),
            moments: Moments::default(),
            packer: Packer::default(),
            held: None,
        }
    }

    /// The backend.
    pub fn backend(&self) -> &dyn Backend {
        &*self.backend
    }

    /// Whether a core is to be left to others from the next pass on: see [`Backend::leave_core`].
    pub fn leave_core(&mut self, leave: bool) {
        self.backend.leave_core(leave);
    }

    /// How long the last [`Renderer::load`] took.
    pub fn build_time(&self) -> Duration {
        self.build
    }

    /// What had to be made anew by the last [`Renderer::load`].
    pub fn changes(&self) -> Changes {
        self.changes
    }

    /// Takes `world`; gives its empty film.
    ///
    /// # Errors
    /// The world is too large or the backend fails. Then passes of the world before it may fail, too.
    pub fn load(&mut self, world: &World) -> Result<Film, RenderError> {
        self.load_for(world, &Request::default())
    }

    /// Takes `world`; gives the empty film that `request` asks for.
    ///
    /// # Errors
    /// As [`Renderer::load`], or the request cannot be met.
    pub fn load_for(&mut self, world: &World, request: &Request) -> Result<Film, RenderError> {
        let start = Instant::now();
        let picture = world.render.resolution;
        if let Some(window) = request.crop.filter(|window| !Window::fits(picture, *window)) {
            return Err(RenderError::Outside { window, picture });
        }
        let film = Film::new(&world.render, request);
        let size = request.crop.map_or(picture, |window| [window.width, window.height]);
        let mut film = film.map_err(|TooLarge { bytes }| RenderError::Memory { size, bytes })?;
        let window = film.traced().packed();
        let (packed, moved) = self.take(world, window)?;
        film.motion = world.next.as_ref().zip(moved).map(|(next, shapes)| {
            let [now, next] = [&world.view, next].map(|view| Projector::new(view, picture));
            Arc::new(Motion { now, next, shapes })
        });
        film.middle_m = world.view.focus_m as f32;
        film.wires = (world.render.view == Shown::Bvh).then(|| Arc::new(Wires::of(&packed, &world.view, picture)));
        film.blocks = Blocks::new(world.moments.len(), world.render.samples);
        self.moments = Moments { worlds: world.moments.clone(), window, held: None };
        self.build = start.elapsed();
        Ok(film)
    }

    /// Has the backend hold a world; gives its arrays, and where each shape goes until the next frame.
    fn take(&mut self, world: &World, window: UVec4) -> Result<(Arc<Packed>, Option<Vec<Moved>>), RenderError> {
        let same_view = self.held.as_ref().is_some_and(|held| held.view == world.view);
        if let Some(Held { packed, view, world: Some(before) }) = &mut self.held
            && is_seen_otherwise(before, world)
        {
            let mut aimed = Packed::clone(packed);
            // The shape of the picture is no part of the camera.
            self.changes = Changes { camera: !same_view, ..aim(&mut aimed, world)? };
            aimed.params.window = window;
            let aimed = Arc::new(aimed);
            self.backend.update(aimed.clone(), self.changes)?;
            *packed = aimed.clone();
            *view = world.view.clone();
            return Ok((aimed, None));
        }
        let mut prepared = self.packer.prepare(world)?;
        prepared.packed.params.window = window;
        let moved = prepared.moved.take();
        let before = self.held.take();
        let several = before.is_some();
        // What nobody else holds is changed where it lies.
        self.backend.release();
        let before = before.map(|held| Arc::unwrap_or_clone(held.packed));
        let (packed, changes) = prepared.finish(before)?;
        let packed = Arc::new(packed);
        self.changes = Changes { camera: changes.camera && !same_view, ..changes };
        self.backend.update(packed.clone(), changes)?;
        let view = world.view.clone();
        self.held = Some(Held { packed: packed.clone(), view, world: several.then(|| Box::new(world.clone())) });
        Ok((packed, moved))
    }

    /// Has the backend hold a moment.
    fn hold(&mut self, moment: usize) -> Result<(), RenderError> {
        if self.moments.held == Some(moment) || moment >= self.moments.worlds.len() {
            return Ok(());
        }
        let start = Instant::now();
        self.moments.held = None;
        let (worlds, window) = (self.moments.worlds.clone(), self.moments.window);
        if let Some(world) = worlds.get(moment) {
            self.take(world, window)?;
        }
        self.moments.held = Some(moment);
        self.build += start.elapsed();
        Ok(())
    }

    /// Adds one pass to `film`, of [`PASS_SAMPLES`](kinora_kernel::PASS_SAMPLES) samples or as many as are missing to
    /// `samples` (fewer where the pilot of adaptive sampling ends); false if there was nothing to add or `control` ended
    /// it, in which case the film is as it was.
    ///
    /// # Errors
    /// The backend fails.
    pub fn trace_pass(&mut self, film: &mut Film, samples: u32, control: &dyn Control) -> Result<bool, RenderError> {
        let Some(pass) = film.next_pass(samples) else { return Ok(false) };
        let places = film.places();
        let sums = match film.blocks.clone() {
            Some(blocks) if blocks.groups() > 1 => {
                let places = places.unwrap_or_else(|| film.all_places());
                self.groups(film, &blocks, &places, &pass, control)?
            }
            blocks => {
                if let Some(blocks) = blocks {
                    self.hold(blocks.moment(pass.start, 0))?;
                }
                self.sums(film, places.as_deref(), &pass, control)?
            }
        };
        let Some(Sums { light, parts, surveys }) = sums else { return Ok(false) };
        film.add(&light, &parts, &surveys, pass.end - pass.start);
        Ok(true)
    }

    /// A pass over `places`, group by group; `None` if `control` ended it.
    fn groups(
        &mut self,
        film: &Film,
        blocks: &Blocks,
        places: &[UVec2],
        pass: &Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Sums>, RenderError> {
        let mut all = Sums::default();
        let count = |wanted: bool| if wanted { places.len() } else { 0 };
        all.light.resize(count(film.wants_light()), Vec4::ZERO);
        all.parts.resize(count(film.wants_parts()), [Vec4::ZERO; 5]);
        all.surveys.resize(count(film.wants_surveys()), [Vec4::ZERO; 4]);
        let groups = blocks.groups();
        for group in 0..groups {
            let of_group = |(_, place): &(usize, &UVec2)| blocks.group(**place, pass.start) == group;
            let (at, own): (Vec<usize>, Vec<UVec2>) = places.iter().enumerate().filter(of_group).unzip();
            if own.is_empty() {
                continue;
            }
            self.hold(blocks.moment(pass.start, group))?;
            let done = |share: f64| (f64::from(group) + share) / f64::from(groups);
            let go_on = |share: f64| control.keep_going(done(share));
            let Some(sums) = self.sums(film, Some(&own), pass, &go_on)? else { return Ok(None) };
            scatter(&mut all.light, &at, &sums.light);
            scatter(&mut all.parts, &at, &sums.parts);
            scatter(&mut all.surveys, &at, &sums.surveys);
        }
        Ok(Some(all))
    }

    /// A pass over what the backend holds; `None` if `control` ended it.
    fn sums(
        &mut self,
        film: &Film,
        places: Option<&[UVec2]>,
        pass: &Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Sums>, RenderError> {
        // A survey has one ray a sample, a path about ten.
        let share = match (film.wants_light(), film.wants_surveys()) {
            (true, true) => 0.9,
            (light, _) => f64::from(u8::from(light)),
        };
        let mut all = Sums::default();
        let go_on = |done| control.keep_going(done * share);
        if film.wants_parts() {
            let Some(sums) = self.backend.trace_parts(places, pass.clone(), &go_on)? else { return Ok(None) };
            all.light = sums.iter().map(|[light, ..]| *light).collect();
            all.parts = sums;
        } else if film.wants_light() {
            let Some(sums) = self.backend.trace(places, pass.clone(), &go_on)? else { return Ok(None) };
            all.light = sums;
        }
        if film.wants_surveys() {
            let go_on = |done| control.keep_going(share + done * (1.0 - share));
            let Some(sums) = self.backend.survey(places, pass.clone(), &go_on)? else { return Ok(None) };
            all.surveys = sums;
        }
        Ok(Some(all))
    }

    /// Renders `world` with the samples it asks for. `control` hears of the whole picture; where it ends the work, the
    /// film holds the passes finished so far.
    ///
    /// # Errors
    /// As [`Renderer::load`] and [`Renderer::trace_pass`].
    pub fn render(&mut self, world: &World, control: &dyn Control) -> Result<Film, RenderError> {
        self.render_for(world, &Request::default(), control)
    }

    /// Renders what `request` asks for.
    ///
    /// # Errors
    /// As [`Renderer::load_for`] and [`Renderer::trace_pass`].
    pub fn render_for(&mut self, world: &World, request: &Request, control: &dyn Control) -> Result<Film, RenderError> {
        let mut film = self.load_for(world, request)?;
        let samples = world.render.samples;
        while let Some(pass) = film.next_pass(samples) {
            // What is wanted in all is known once the pilot is over: the share jumps ahead, but never back.
            let shares = [0.0, f64::from(pass.end - pass.start)].map(|more| film.share(samples, more));
            let whole = |done: f64| shares[0] + done * (shares[1] - shares[0]);
            if !self.trace_pass(&mut film, samples, &|done| control.keep_going(whole(done)))? {
                break;
            }
        }
        Ok(film)
    }
}

// Puts values to their places; none where nobody wants them.
fn scatter<T: Copy>(into: &mut [T], places: &[usize], values: &[T]) {
    for (place, value) in places.iter().zip(values) {
        into[*place] = *value;
    }
}
