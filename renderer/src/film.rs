//! The film: what all passes so far add up to.

use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, UVec2, UVec4, Vec2, Vec3, Vec4};
use kinora_kernel::PASS_SAMPLES;
use kinora_scene::{Background, Render, Shown};

use crate::adaptive::{self, Adaptive};
use crate::moments::Blocks;
use crate::motion::Motion;
use crate::wires::Wires;

/// A part of a picture, in pixels from its top left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Window {
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

impl Window {
    /// All of a picture of `width` × `height` pixels.
    pub fn whole([width, height]: [u32; 2]) -> Self {
        Self { left: 0, top: 0, width, height }
    }

    /// Whether it has pixels and all of them lie in a picture of `width` × `height`.
    pub fn fits([width, height]: [u32; 2], window: Window) -> bool {
        let inside = |start: u32, length: u32, all: u32| length > 0 && start < all && length <= all - start;
        inside(window.left, window.width, width) && inside(window.top, window.height, height)
    }

    /// How many pixels it has.
    pub fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    pub(crate) fn packed(self) -> UVec4 {
        UVec4::new(self.left, self.top, self.width, self.height)
    }
}

/// What a film is to hold beside what `render` asks for itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// The part of the picture that is wanted; its pixels are the same as in the whole.
    pub crop: Option<Window>,
    /// Whether the layers of surfaces are wanted: albedo, normal, depth, position, id, and motion if the world tells of
    /// its next frame.
    pub layers: bool,
    /// Whether the light is wanted in parts, with its variance.
    pub parts: bool,
}

/// The light of a pixel in parts, by what it did where the camera's rays were scattered first; means of all samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Light {
    /// From emitters and the sky that the camera's rays met themselves.
    pub emission: Vec3,
    /// Scattered first by a diffuse lobe.
    pub diffuse: Vec3,
    /// Scattered first by any other: metals, glass both ways, coats and sheen.
    pub specular: Vec3,
    /// Of the mean of all light: its standard error squared, as independent samples would have it; 0 of one sample.
    pub variance: Vec3,
}

/// The first surface that a pixel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its colour, the mean of all samples: of diffuse surfaces and metals how much they reflect to where light comes
    /// from, of glass white, of mixtures what chance chose, of emitters their radiance; 0..=1, black where nothing is.
    pub albedo: Vec3,
    /// Shading normal in the world, turned to the eye; the mean of all samples, hence not of unit length at edges, and 0
    /// where nothing is.
    pub normal: Vec3,
    /// Share of the samples that met something, 0..=1.
    pub cover: f32,
    /// Metres along the camera's axis, of the first sample; 1e10 where nothing is.
    pub depth: f32,
    /// In the world, metres, of the first sample; 0 where nothing is.
    pub position: Vec3,
    /// 1 + the node's place in the scene, of the first sample; 0 where nothing is.
    pub id: u32,
}

/// One pass over the surfaces that pixels show, four values each: the sum of albedo and of hits (w), the sum of normals
/// and the depth (w), position and id (w), shape and copy. What is no sum belongs to sample 0 and is 0 in passes without
/// it; see `FeatureSum`.
pub type Survey = [Vec4; 4];

/// One pass over the light of pixels, five values each: its sum and that of rays (w), squared distances from its mean, and
/// the sums of emission, diffuse and specular; see `PartsSum`.
pub type Parts = [Vec4; 5];

/// Sums over the samples of a picture's pixels, row by row from the top.
///
/// Passes are added in their order, light in f64, each pass being an f32 sum over its samples, so that a film depends on
/// which samples it holds and on nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    picture: [u32; 2],
    window: Window,
    view: Shown,
    transparent: bool,
    // The most rays that a sample takes where nothing is cut out.
    most_rays: f32,
    // The most that a pixel may get.
    most_samples: u32,
    samples: u32,
    rays: u64,
    // Each is empty if it is not wanted.
    light: Vec<DVec3>,
    parts: Vec<LightSums>,
    costs: Vec<u32>,
    surveys: Vec<Survey>,
    pub(crate) wires: Option<Arc<Wires>>,
    pub(crate) motion: Option<Arc<Motion>>,
    // Where pixels get different numbers of samples.
    adaptive: Option<Adaptive>,
    /// Which moment each sample sees, where there are several.
    pub(crate) blocks: Option<Blocks>,
    /// The depth that a picture of depths shows half grey, in metres.
    pub(crate) middle_m: f32,
}

// Sums over a pixel's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct LightSums {
    emission: DVec3,
    diffuse: DVec3,
    specular: DVec3,
    // Squared distances from the mean of all light.
    squares: DVec3,
}

impl LightSums {
    // Adds a pass of `samples` samples to `before` samples whose light has the sum `light` (Chan, Golub and LeVeque, "Updating
    // Formulae and a Pairwise Algorithm for Computing Sample Variances", 1979).
    fn add(&mut self, light: DVec3, before: f64, part: &Parts, samples: f64) {
        let [all, squares, emission, diffuse, specular] = part.map(|sum| sum.truncate().as_dvec3());
        self.emission += emission;
        self.diffuse += diffuse;
        self.specular += specular;
        self.squares += squares;
        if before > 0.0 {
            let off = all / samples - light / before;
            self.squares += off * off * (before * samples / (before + samples));
        }
    }
}

/// A film that memory does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// What the film and its passes need.
    pub bytes: u64,
}

impl Film {
    /// An empty film for what `render` asks for and `request` on top.
    ///
    /// # Errors
    /// Memory does not hold it.
    pub fn new(render: &Render, request: &Request) -> Result<Self, TooLarge> {
        let window = request.crop.unwrap_or(Window::whole(render.resolution));
        let Contents { light, parts, cost, surveys } = Contents::of(render, request);
        let too_large = TooLarge { bytes: Self::bytes(render, request) };
        let count = |wanted: bool| if wanted { window.pixels() } else { 0 };
        let adaptive = match light && adaptive::is_on(render) {
            true => Some(Adaptive::new(render, window).ok_or(too_large)?),
            false => None,
        };
        Ok(Self {
            picture: render.resolution,
            window,
            view: render.view,
            transparent: render.background == Background::Transparent,
            most_rays: 2.0 * (render.max_bounces as f32 + 1.0),
            most_samples: render.samples,
            samples: 0,
            rays: 0,
            light: zeros(count(light), DVec3::ZERO).ok_or(too_large)?,
            parts: zeros(count(parts), LightSums::default()).ok_or(too_large)?,
            costs: zeros(count(cost), 0).ok_or(too_large)?,
            surveys: zeros(count(surveys), [Vec4::ZERO; 4]).ok_or(too_large)?,
            wires: None,
            motion: None,
            adaptive,
            blocks: None,
            middle_m: 1.0,
        })
    }

    /// About how much memory such a film takes while it is made and written.
    pub fn bytes(render: &Render, request: &Request) -> u64 {
        let window = request.crop.unwrap_or(Window::whole(render.resolution));
        let Contents { light, parts, cost, surveys } = Contents::of(render, request);
        let part = |wanted: bool, kept: usize, passed: usize| if wanted { (kept + passed) as u64 } else { 0 };
        let a_pixel = part(light, size_of::<DVec3>(), size_of::<Vec4>())
            + part(parts, size_of::<LightSums>(), size_of::<Parts>())
            + part(cost, size_of::<u32>(), 0)
            + part(surveys, size_of::<Survey>(), size_of::<Survey>());
        let pixels = adaptive::traced(render, window).pixels() as u64;
        let adaptive = part(light && adaptive::is_on(render), adaptive::BYTES, 0);
        a_pixel.saturating_add(adaptive).saturating_mul(pixels)
    }

    /// Width and height in pixels: of the window, if that is not the whole picture.
    pub fn size(&self) -> [u32; 2] {
        [self.window.width, self.window.height]
    }

    /// The part of the picture that this is.
    pub fn window(&self) -> Window {
        self.window
    }

    /// The part of the picture that is traced for it: more than the window where pixels are judged by their neighbours.
    pub(crate) fn traced(&self) -> Window {
        self.adaptive.as_ref().map_or(self.window, Adaptive::traced)
    }

    /// Width and height of the whole picture in pixels.
    pub fn picture(&self) -> [u32; 2] {
        self.picture
    }

    /// What it shows.
    pub fn view(&self) -> Shown {
        self.view
    }

    /// Whether it has alpha.
    pub fn is_transparent(&self) -> bool {
        self.transparent
    }

    /// Samples a pixel so far, of those that still want some: also the index of the next sample.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Samples of a pixel so far, by its index.
    pub fn samples_of(&self, i: usize) -> u32 {
        let wanted = self.adaptive.as_ref().and_then(|adaptive| adaptive.count(i));
        wanted.map_or(self.samples, |wanted| wanted.min(self.samples))
    }

    /// Samples a pixel so far, the mean over all pixels.
    pub fn mean_samples(&self) -> f64 {
        match &self.adaptive {
            Some(adaptive) => adaptive.taken() / self.window.pixels() as f64,
            None => f64::from(self.samples),
        }
    }

    /// Whether pixels may get different numbers of samples.
    pub fn is_adaptive(&self) -> bool {
        self.adaptive.is_some()
    }

    /// The samples of the next pass, if each pixel is to have up to `samples`; `None` if no pixel wants more.
    pub fn next_pass(&self, samples: u32) -> Option<Range<u32>> {
        let first = self.samples;
        let end = match &self.adaptive {
            Some(adaptive) => adaptive.end_of_pass(first)?,
            None => first.saturating_add(PASS_SAMPLES),
        };
        let end = end.min(samples).min(self.blocks.as_ref().map_or(u32::MAX, |blocks| blocks.end(first)));
        (first < end).then_some(first..end)
    }

    /// How much of all work is done, in 0..=1, if each pixel is to have up to `samples` and the next pass has got on by
    /// `more` samples a pixel.
    pub(crate) fn share(&self, samples: u32, more: f64) -> f64 {
        match self.adaptive.as_ref().filter(|adaptive| adaptive.is_decided()) {
            Some(adaptive) => adaptive.share(more),
            None => (f64::from(self.samples) + more) / f64::from(samples.max(1)),
        }
    }

    /// Where the next pass has to look; `None` for everywhere.
    pub(crate) fn places(&self) -> Option<Vec<UVec2>> {
        let adaptive = self.adaptive.as_ref().filter(|adaptive| adaptive.is_decided())?;
        let Window { left, top, width, .. } = self.window;
        let place = |i: &u32| UVec2::new(left + i % width, top + i / width);
        Some(adaptive.active().iter().map(place).collect())
    }

    /// Everywhere, in the order in which a pass has it.
    pub(crate) fn all_places(&self) -> Vec<UVec2> {
        let Window { left, top, width, height } = self.traced();
        (top..top + height).flat_map(|y| (left..left + width).map(move |x| UVec2::new(x, y))).collect()
    }

    /// Rays traced so far, those for layers not counted.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Whether it collects light.
    pub(crate) fn wants_light(&self) -> bool {
        !self.light.is_empty()
    }

    /// Whether it collects light in parts.
    pub(crate) fn wants_parts(&self) -> bool {
        !self.parts.is_empty()
    }

    /// Whether it collects what pixels show.
    pub(crate) fn wants_surveys(&self) -> bool {
        !self.surveys.is_empty()
    }

    /// Adds the next pass of `samples` samples: a sum of light, w counting rays, its parts, and a survey, each where wanted,
    /// for all that is traced or for what [`Film::places`] lists.
    ///
    /// # Panics
    /// A part that is wanted is not one value a pixel.
    pub fn add(&mut self, light: &[Vec4], parts: &[Parts], surveys: &[Survey], samples: u32) {
        self.rays += light.iter().map(|part| part.w as u64).sum::<u64>();
        let mut adaptive = self.adaptive.take();
        let pass = Pass { light, parts, surveys, samples };
        match adaptive.as_ref().filter(|adaptive| adaptive.is_decided()) {
            Some(adaptive) => self.add_at(adaptive.active().iter().map(|i| *i as usize), &pass),
            None => {
                let traced = adaptive.as_ref().map_or(self.window, Adaptive::traced);
                self.add_all(traced, &pass);
            }
        }
        self.samples += samples;
        if let Some(adaptive) = &mut adaptive {
            adaptive.learn(light, samples, self.samples, self.blocks.as_ref());
        }
        self.adaptive = adaptive;
    }

    // A pass over `traced`, of which the window is a part.
    fn add_all(&mut self, traced: Window, pass: &Pass<'_>) {
        let values = |wanted: bool| if wanted { traced.pixels() } else { 0 };
        assert_eq!(pass.light.len(), values(self.wants_light()), "a pass has one sum a pixel");
        assert_eq!(pass.parts.len(), values(self.wants_parts()), "a pass has the parts of every pixel");
        assert_eq!(pass.surveys.len(), values(self.wants_surveys()), "a pass has one survey a pixel");
        let width = self.window.width as usize;
        for y in 0..self.window.height {
            let start = (y + self.window.top - traced.top) as usize * traced.width as usize;
            let start = start + (self.window.left - traced.left) as usize;
            let row = y as usize * width;
            self.add_at(row..row + width, &pass.row(start..start + width));
        }
    }

    // Values of the pixels with these indices.
    fn add_at(&mut self, pixels: impl Iterator<Item = usize> + Clone, pass: &Pass<'_>) {
        let (before, samples) = (f64::from(self.samples), f64::from(pass.samples));
        for (i, part) in pixels.clone().zip(pass.parts) {
            if let (Some(sums), Some(light)) = (self.parts.get_mut(i), self.light.get(i)) {
                sums.add(*light, before, part, samples);
            }
        }
        for (i, part) in pixels.clone().zip(pass.light) {
            if let Some(sum) = self.light.get_mut(i) {
                *sum += part.truncate().as_dvec3();
            }
            if let Some(sum) = self.costs.get_mut(i) {
                *sum = sum.saturating_add(part.w as u32);
            }
        }
        for (i, [albedo, normal, position, shape]) in pixels.zip(pass.surveys) {
            let Some(sum) = self.surveys.get_mut(i) else { continue };
            sum[0] += albedo;
            // The first pass begins with the first sample.
            let depth = if self.samples == 0 { normal.w } else { sum[1].w };
            sum[1] = (sum[1].truncate() + normal.truncate()).extend(depth);
            if self.samples == 0 {
                (sum[2], sum[3]) = (*position, *shape);
            }
        }
    }

    fn scale(&self, i: usize) -> f64 {
        1.0 / f64::from(self.samples_of(i).max(1))
    }

    /// Mean radiance, one a pixel, over what the background leaves of it; black before the first sample. Empty if the
    /// view shows something else.
    pub fn mean(&self) -> Vec<Vec3> {
        self.light.iter().enumerate().map(|(i, sum)| (*sum * self.scale(i)).as_vec3()).collect()
    }

    /// Mean radiance of a pixel by its index.
    pub(crate) fn light(&self, i: usize) -> Vec3 {
        self.light.get(i).map_or(Vec3::ZERO, |sum| (*sum * self.scale(i)).as_vec3())
    }

    /// The parts of a pixel's light, by its index; `None` where nobody asked for them.
    pub fn parts(&self, i: usize) -> Option<Light> {
        let LightSums { emission, diffuse, specular, squares } = *self.parts.get(i)?;
        let scale = self.scale(i);
        // From the samples' own variance to that of their mean.
        let count = f64::from(self.samples_of(i));
        let of_mean = if count > 1.0 { scale / (count - 1.0) } else { 0.0 };
        Some(Light {
            emission: (emission * scale).as_vec3(),
            diffuse: (diffuse * scale).as_vec3(),
            specular: (specular * scale).as_vec3(),
            variance: (squares * of_mean).as_vec3(),
        })
    }

    /// Rays a sample of a pixel by its index; 0 unless the view shows them.
    pub fn cost(&self, i: usize) -> f32 {
        self.costs.get(i).map_or(0.0, |rays| (f64::from(*rays) * self.scale(i)) as f32)
    }

    pub(crate) fn most_rays(&self) -> f32 {
        self.most_rays
    }

    /// The most samples that a pixel may get.
    pub(crate) fn most_samples(&self) -> u32 {
        self.most_samples
    }

    /// What a pixel shows, by its index; `None` where nobody asked for it.
    pub fn seen(&self, i: usize) -> Option<Seen> {
        let [albedo, normal, position, _] = *self.surveys.get(i)?;
        let scale = self.scale(i) as f32;
        let means = albedo * scale;
        let id = position.w as u32;
        Some(Seen {
            albedo: means.truncate(),
            normal: normal.truncate() * scale,
            cover: means.w,
            depth: normal.w,
            position: if id == 0 { Vec3::ZERO } else { position.truncate() },
            id,
        })
    }

    /// Pixels to the right and up that what a pixel shows moves until the next frame, of its first sample, by its index: 0
    /// where nothing moves, or what moves cannot be seen in both frames. `None` where nobody asked for it.
    pub fn motion(&self, i: usize) -> Option<Vec2> {
        let way = self.motion.as_ref()?.of(self.surveys.get(i)?);
        // Not -0.
        Some(Vec2::new(way.x, 0.0 - way.y))
    }
}

// A pass, or a row of it; what is not wanted is empty.
struct Pass<'a> {
    light: &'a [Vec4],
    parts: &'a [Parts],
    surveys: &'a [Survey],
    samples: u32,
}

impl Pass<'_> {
    fn row(&self, range: Range<usize>) -> Pass<'_> {
        Pass {
            light: self.light.get(range.clone()).unwrap_or(&[]),
            parts: self.parts.get(range.clone()).unwrap_or(&[]),
            surveys: self.surveys.get(range).unwrap_or(&[]),
            samples: self.samples,
        }
    }
}

// What a film has to hold.
struct Contents {
    light: bool,
    parts: bool,
    cost: bool,
    surveys: bool,
}

impl Contents {
    fn of(render: &Render, request: &Request) -> Self {
        let shown = matches!(render.view, Shown::Beauty | Shown::Cost | Shown::Samples);
        let surveys = !shown || request.layers || render.background == Background::Transparent;
        Self { light: shown || request.parts, parts: request.parts, cost: render.view == Shown::Cost, surveys }
    }
}

fn zeros<T: Clone>(count: usize, zero: T) -> Option<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).ok()?;
    values.resize(count, zero);
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film(view: Shown, layers: bool) -> Film {
        let render = Render { resolution: [2, 1], view, ..Render::default() };
        Film::new(&render, &Request { layers, ..Request::default() }).unwrap()
    }

    #[test]
    fn a_film_is_the_mean_of_its_samples() {
        let mut film = film(Shown::Beauty, false);
        assert_eq!(film.mean(), [Vec3::ZERO; 2]);
        film.add(&[Vec4::new(1.0, 2.0, 3.0, 5.0), Vec4::ZERO], &[], &[], 2);
        film.add(&[Vec4::new(3.0, 2.0, 1.0, 1.0), Vec4::ONE], &[], &[], 2);
        assert_eq!(film.mean(), [Vec3::ONE, Vec3::splat(0.25)]);
        assert_eq!((film.samples(), film.rays(), film.size()), (4, 7, [2, 1]));
        assert_eq!(film.seen(0), None);
    }

    #[test]
    fn layers_are_means_but_for_those_of_the_first_sample() {
        let mut film = film(Shown::Normal, false);
        // Where nothing is, a direction takes the place of the position.
        let nothing = [Vec4::ZERO, Vec4::ZERO.with_w(1e10), Vec4::X, Vec4::ZERO];
        let met = Vec4::new(1.0, 0.5, 0.0, 2.0);
        let first = [met, Vec4::new(0.0, 2.0, 0.0, 7.0), Vec4::new(1.0, 2.0, 3.0, 9.0), Vec4::ZERO];
        let second = [met, Vec4::new(2.0, 0.0, 0.0, 0.0), Vec4::ZERO, Vec4::ZERO];
        film.add(&[], &[], &[first, nothing], 2);
        film.add(&[], &[], &[second, [Vec4::ZERO; 4]], 2);
        let seen = film.seen(0).unwrap();
        assert_eq!((seen.albedo, seen.cover), (Vec3::new(0.5, 0.25, 0.0), 1.0));
        assert_eq!((seen.normal, seen.depth), (Vec3::new(0.5, 0.5, 0.0), 7.0));
        assert_eq!((seen.position, seen.id), (Vec3::new(1.0, 2.0, 3.0), 9));
        let seen = film.seen(1).unwrap();
        assert_eq!((seen.cover, seen.depth, seen.position, seen.id), (0.0, 1e10, Vec3::ZERO, 0));
    }

    // Of the samples 1 2 3 | 4 6: their mean is 3.2, and the squares of their distances add up to 14.8.
    #[test]
    fn variance_over_passes() {
        let request = Request { parts: true, ..Request::default() };
        let render = Render { resolution: [1, 1], view: Shown::Normal, ..Render::default() };
        let mut film = Film::new(&render, &request).unwrap();
        for (sum, squares, samples) in [(6.0, 2.0, 3), (10.0, 2.0, 2)] {
            let part = Vec4::new(0.25 * sum, 0.0, 0.0, 0.0);
            let parts = [Vec4::splat(sum), Vec4::splat(squares), part, part + part, Vec4::ZERO];
            film.add(&[parts[0]], &[parts], &[[Vec4::ZERO; 4]], samples);
        }
        let light = film.parts(0).unwrap();
        assert_eq!((light.emission.x, light.diffuse.x, light.specular.x), (0.8, 1.6, 0.0));
        assert!((light.variance - 14.8 / (5.0 * 4.0)).abs().max_element() < 1e-6, "{light:?}");
        assert_eq!(film.mean(), [Vec3::splat(3.2)]);
    }

    #[test]
    fn windows() {
        let fits = |left, top, width, height| Window::fits([8, 4], Window { left, top, width, height });
        assert!(fits(0, 0, 8, 4) && fits(7, 3, 1, 1));
        assert!(!fits(0, 0, 9, 4) && !fits(8, 0, 1, 1) && !fits(0, 0, 0, 1) && !fits(1, 0, u32::MAX, 1));
    }

    #[test]
    fn what_memory_does_not_hold_is_refused() {
        let render = Render { resolution: [u32::MAX; 2], ..Render::default() };
        assert!(Film::new(&render, &Request::default()).is_err());
    }
}
