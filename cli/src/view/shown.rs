//! What is known of the picture on the screen.

use std::time::Duration;

use egui::{Rect, Ui};

use super::blit::Place;
use super::fit::fit;
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
    /// Which load of the scene it is of.
    pub load: u64,
    /// Where it was last drawn.
    pub place: Option<Place>,
}

impl From<&Picture> for Shown {
    fn from(picture: &Picture) -> Shown {
        let &Picture { size, full, samples, wanted, time, load, .. } = picture;
        Shown { full, preview: size != full, samples, wanted, time, load, place: None }
    }
}

impl Shown {
    /// Whether it has at least `samples` samples, or all it will have.
    pub fn has(&self, samples: u32) -> bool {
        !self.preview && self.samples >= samples.min(self.wanted)
    }

    /// Places the picture in the middle of `area`; gives its height in points.
    pub fn put(&mut self, ui: &Ui, area: Rect) -> Option<f32> {
        let scale = ui.pixels_per_point();
        self.place = None;
        let fit = fit(self.full, area.size().into())?;
        let rect = Rect::from_center_size(area.center(), fit.size.into());
        // On whole pixels of the window, so that edges are sharp.
        let [left, top] = [rect.min.x, rect.min.y].map(|at| (at * scale).round());
        let [width, height] = fit.size.map(|side| (side * scale).floor());
        // A preview is blurred rather than blocky: its pixels are not those of the picture.
        let squares = fit.squares(scale) && !self.preview;
        self.place = Some(Place { pixels: [left, top, width, height], squares });
        Some(rect.height())
    }
}
