//! The picture as last rendered, as a texture in the window.

use std::sync::Arc;
use std::time::Duration;

use egui::{ColorImage, Context, Image, Rect, TextureHandle, TextureOptions, Ui};

use super::fit::fit;
use super::work::Picture;

/// A picture on the screen.
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
    texture: TextureHandle,
    image: Arc<ColorImage>,
    squares: bool,
}

impl Shown {
    /// Shows `picture` in the place of `before`.
    pub fn new(context: &Context, picture: Picture, before: Option<Shown>) -> Shown {
        let preview = picture.preview();
        let Picture { image, full, samples, wanted, time, .. } = picture;
        let image = Arc::new(image);
        let squares = before.as_ref().is_some_and(|before| before.squares);
        let texture = match before {
            Some(mut before) => {
                before.texture.set(image.clone(), filter(squares && !preview));
                before.texture
            }
            None => context.load_texture("picture", image.clone(), filter(false)),
        };
        Shown { full, preview, samples, wanted, time, texture, image, squares }
    }

    /// Whether it has at least `samples` samples, or all it will have.
    pub fn has(&self, samples: u32) -> bool {
        !self.preview && self.samples >= samples.min(self.wanted)
    }

    /// Draws the picture in the middle of `area`; gives its height in points.
    pub fn paint(&mut self, ui: &Ui, area: Rect) -> Option<f32> {
        let place = fit(self.full, area.size().into())?;
        let squares = place.squares(ui.pixels_per_point());
        if squares != self.squares {
            self.squares = squares;
            // A preview is blurred rather than blocky: its pixels are not those of the picture.
            self.texture.set(self.image.clone(), filter(squares && !self.preview));
        }
        let rect = Rect::from_center_size(area.center(), place.size.into());
        Image::new((self.texture.id(), rect.size())).paint_at(ui, rect);
        Some(rect.height())
    }
}

fn filter(squares: bool) -> TextureOptions {
    if squares {
        TextureOptions { minification: egui::TextureFilter::Linear, ..TextureOptions::NEAREST }
    } else {
        TextureOptions::LINEAR
    }
}
