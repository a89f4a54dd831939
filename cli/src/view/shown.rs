//! What is known of the picture on the screen.

use std::time::Duration;

use egui::{Rect, Ui, Vec2};

use super::blit::Place;
use super::fit::fit;
use super::picture::Zoom;
use super::work::Picture;

/// A picture on the screen.
#[derive(Clone, Copy, Debug)]
pub struct Shown {
    /// Its size in pixels when it is no preview.
    pub full: [u32; 2],
    /// Whether it is smaller than that.
    pub preview: bool,
    /// Samples a pixel so far.
    pub samples: u32,
    /// Samples a pixel when it is done.
    pub wanted: u32,
    /// How long these took.
    pub time: Duration,
    /// The rays that they took.
    pub rays: u64,
    /// When the shutter opens, in seconds.
    pub open_s: f64,
    /// Which load of the scene it is of.
    pub load: u64,
    /// Where it was last drawn.
    pub place: Option<Place>,
    /// Window pixels a pixel of the picture then.
    scale: Option<f32>,
}

impl From<&Picture> for Shown {
    fn from(picture: &Picture) -> Shown {
        let &Picture { size, full, samples, wanted, time, rays, open_s, load, .. } = picture;
        Shown { full, preview: size != full, samples, wanted, time, rays, open_s, load, place: None, scale: None }
    }
}

impl Shown {
    /// Whether it has at least `samples` samples, or all it will have.
    pub fn has(&self, samples: u32) -> bool {
        !self.preview && self.samples >= samples.min(self.wanted)
    }

    /// How large it is on the screen, where a pixel of the picture on one of the window is 100.
    pub fn percent(&self) -> Option<f32> {
        self.scale.map(|scale| scale * 100.0)
    }

    /// Places the picture in `area`, in its middle unless it is moved; gives where it lies, in points.
    pub fn put(&mut self, ui: &Ui, area: Rect, zoom: Zoom) -> Option<Rect> {
        let scale = ui.pixels_per_point();
        (self.place, self.scale) = (None, None);
        let whole = fit(self.full, area.size().into())?;
        let most = ui.input(|input| input.max_texture_side) as f32 / (whole.size[0].max(whole.size[1]) * scale);
        let fit = whole.scaled(zoom.factor().min(most));
        let middle = area.center() + Vec2::from(zoom.offset()) * whole.size[1];
        let rect = Rect::from_center_size(middle, fit.size.into());
        // On whole pixels of the window, so that edges are sharp.
        let [left, top] = [rect.min.x, rect.min.y].map(|at| (at * scale).round());
        let [width, height] = fit.size.map(|side| (side * scale).floor());
        // A preview is blurred rather than blocky: its pixels are not those of the picture.
        let squares = fit.squares(scale) && !self.preview;
        let clip = [area.min.x, area.min.y, area.max.x, area.max.y].map(|at| (at * scale).round());
        self.place = Some(Place { pixels: [left, top, width, height], clip, squares });
        self.scale = Some(fit.scale * scale);
        Some(rect)
    }
}
