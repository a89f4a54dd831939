//! The film: what all passes so far add up to.

use std::sync::Arc;

use glam::{DVec3, UVec4, Vec3, Vec4};
use kinora_scene::{Background, Render, Shown};

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
    /// Whether the layers are wanted: albedo, normal, depth, position and id.
    pub layers: bool,
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

/// One pass over the surfaces that pixels show, three values each: the sum of albedo and of hits (w), the sum of normals
/// and the depth (w), position and id (w). What is no sum belongs to sample 0 and is 0 in passes without it.
pub type Survey = [Vec4; 3];

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
    samples: u32,
    rays: u64,
    // Each is empty if it is not wanted.
    light: Vec<DVec3>,
    costs: Vec<u32>,
    surveys: Vec<Survey>,
    pub(crate) wires: Option<Arc<Wires>>,
    /// The depth that a picture of depths shows half grey, in metres.
    pub(crate) middle_m: f32,
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
        let Contents { light, cost, surveys } = Contents::of(render, request);
        let too_large = TooLarge { bytes: Self::bytes(render, request) };
        let count = |wanted: bool| if wanted { window.pixels() } else { 0 };
        Ok(Self {
            picture: render.resolution,
            window,
            view: render.view,
            transparent: render.background == Background::Transparent,
            most_rays: 2.0 * (render.max_bounces as f32 + 1.0),
            samples: 0,
            rays: 0,
            light: zeros(count(light), DVec3::ZERO).ok_or(too_large)?,
            costs: zeros(count(cost), 0).ok_or(too_large)?,
            surveys: zeros(count(surveys), [Vec4::ZERO; 3]).ok_or(too_large)?,
            wires: None,
            middle_m: 1.0,
        })
    }

    /// About how much memory such a film takes while it is made and written.
    pub fn bytes(render: &Render, request: &Request) -> u64 {
        let window = request.crop.unwrap_or(Window::whole(render.resolution));
        let Contents { light, cost, surveys } = Contents::of(render, request);
        let part = |wanted: bool, kept: usize, passed: usize| if wanted { (kept + passed) as u64 } else { 0 };
        let a_pixel = part(light, size_of::<DVec3>(), size_of::<Vec4>())
            + part(cost, size_of::<u32>(), 0)
            + part(surveys, size_of::<Survey>(), size_of::<Survey>());
        a_pixel.saturating_mul(window.pixels() as u64)
    }

    /// Width and height in pixels: of the window, if that is not the whole picture.
    pub fn size(&self) -> [u32; 2] {
        [self.window.width, self.window.height]
    }

    /// The part of the picture that this is.
    pub fn window(&self) -> Window {
        self.window
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

    /// Samples a pixel so far: also the index of the next sample.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Rays traced so far, those for layers not counted.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Whether it collects light.
    pub(crate) fn wants_light(&self) -> bool {
        !self.light.is_empty()
    }

    /// Whether it collects what pixels show.
    pub(crate) fn wants_surveys(&self) -> bool {
        !self.surveys.is_empty()
    }

    /// Adds the next pass of `samples` samples: a sum of light a pixel, w counting rays, and a survey, each where wanted.
    ///
    /// # Panics
    /// A part that is wanted is not one value a pixel.
    pub fn add(&mut self, light: &[Vec4], surveys: &[Survey], samples: u32) {
        assert_eq!(light.len(), self.light.len(), "a pass has one sum a pixel");
        assert_eq!(surveys.len(), self.surveys.len(), "a pass has one survey a pixel");
        for (sum, part) in self.light.iter_mut().zip(light) {
            *sum += part.truncate().as_dvec3();
            self.rays += part.w as u64;
        }
        for (sum, part) in self.costs.iter_mut().zip(light) {
            *sum = sum.saturating_add(part.w as u32);
        }
        for (sum, part) in self.surveys.iter_mut().zip(surveys) {
            let [albedo, normal, position] = part;
            sum[0] += albedo;
            // The first pass begins with the first sample.
            let depth = if self.samples == 0 { normal.w } else { sum[1].w };
            sum[1] = (sum[1].truncate() + normal.truncate()).extend(depth);
            if self.samples == 0 {
                sum[2] = *position;
            }
        }
        self.samples += samples;
    }

    fn scale(&self) -> f64 {
        1.0 / f64::from(self.samples.max(1))
    }

    /// Mean radiance, one a pixel, over what the background leaves of it; black before the first sample. Empty if the
    /// view shows something else.
    pub fn mean(&self) -> Vec<Vec3> {
        let scale = self.scale();
        self.light.iter().map(|sum| (*sum * scale).as_vec3()).collect()
    }

    /// Mean radiance of a pixel by its index.
    pub(crate) fn light(&self, i: usize) -> Vec3 {
        self.light.get(i).map_or(Vec3::ZERO, |sum| (*sum * self.scale()).as_vec3())
    }

    /// Rays a sample of a pixel by its index; 0 unless the view shows them.
    pub fn cost(&self, i: usize) -> f32 {
        self.costs.get(i).map_or(0.0, |rays| (f64::from(*rays) * self.scale()) as f32)
    }

    pub(crate) fn most_rays(&self) -> f32 {
        self.most_rays
    }

    /// What a pixel shows, by its index; `None` where nobody asked for it.
    pub fn seen(&self, i: usize) -> Option<Seen> {
        let [albedo, normal, position] = *self.surveys.get(i)?;
        let scale = self.scale() as f32;
        let means = albedo * scale;
        Some(Seen {
            albedo: means.truncate(),
            normal: normal.truncate() * scale,
            cover: means.w,
            depth: normal.w,
            position: position.truncate(),
            id: position.w as u32,
        })
    }
}

// What a film has to hold.
struct Contents {
    light: bool,
    cost: bool,
    surveys: bool,
}

impl Contents {
    fn of(render: &Render, request: &Request) -> Self {
        let light = matches!(render.view, Shown::Beauty | Shown::Cost);
        let surveys = !light || request.layers || render.background == Background::Transparent;
        Self { light, cost: render.view == Shown::Cost, surveys }
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
        Film::new(&render, &Request { crop: None, layers }).unwrap()
    }

    #[test]
    fn a_film_is_the_mean_of_its_samples() {
        let mut film = film(Shown::Beauty, false);
        assert_eq!(film.mean(), [Vec3::ZERO; 2]);
        film.add(&[Vec4::new(1.0, 2.0, 3.0, 5.0), Vec4::ZERO], &[], 2);
        film.add(&[Vec4::new(3.0, 2.0, 1.0, 1.0), Vec4::ONE], &[], 2);
        assert_eq!(film.mean(), [Vec3::ONE, Vec3::splat(0.25)]);
        assert_eq!((film.samples(), film.rays(), film.size()), (4, 7, [2, 1]));
        assert_eq!(film.seen(0), None);
    }

    #[test]
    fn layers_are_means_but_for_those_of_the_first_sample() {
        let mut film = film(Shown::Normal, false);
        let nothing = [Vec4::ZERO, Vec4::ZERO.with_w(1e10), Vec4::ZERO];
        let first = [Vec4::new(1.0, 0.5, 0.0, 2.0), Vec4::new(0.0, 2.0, 0.0, 7.0), Vec4::new(1.0, 2.0, 3.0, 9.0)];
        let second = [Vec4::new(1.0, 0.5, 0.0, 2.0), Vec4::new(2.0, 0.0, 0.0, 0.0), Vec4::ZERO];
        film.add(&[], &[first, nothing], 2);
        film.add(&[], &[second, [Vec4::ZERO; 3]], 2);
        let seen = film.seen(0).unwrap();
        assert_eq!((seen.albedo, seen.cover), (Vec3::new(0.5, 0.25, 0.0), 1.0));
        assert_eq!((seen.normal, seen.depth), (Vec3::new(0.5, 0.5, 0.0), 7.0));
        assert_eq!((seen.position, seen.id), (Vec3::new(1.0, 2.0, 3.0), 9));
        let seen = film.seen(1).unwrap();
        assert_eq!((seen.cover, seen.depth, seen.id), (0.0, 1e10, 0));
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
