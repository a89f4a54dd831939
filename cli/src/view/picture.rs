//! How the picture is looked at: what of it is shown and how bright, which part of it is rendered, and how large it is.

use kinora_scene::{Shown, Tonemap, World};

/// Doublings of light that the exposure can be changed by.
pub const STOPS: std::ops::RangeInclusive<f64> = -10.0..=10.0;
/// How much larger or smaller than the window a picture can be.
const FACTORS: std::ops::RangeInclusive<f32> = 0.1..=16.0;
/// Parts of the picture smaller than this along a side are slips of the hand.
const LEAST_REGION: f64 = 0.005;

/// What is done with a picture in the window, besides what the scene says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Looking {
    /// What it shows; `None`: what the scene says.
    pub shown: Option<Shown>,
    /// Doublings of light on top of the scene's exposure.
    pub stops: f64,
    /// Its tone curve; `None`: the scene's.
    pub tonemap: Option<Tonemap>,
    /// The part that is rendered: left, top, right and bottom as shares of its width and height.
    pub region: Option<[f64; 4]>,
    /// Whether no samples are added.
    pub paused: bool,
}

impl Looking {
    /// Whether two need other samples, and not only another development of the same.
    pub fn needs_others(&self, other: &Looking) -> bool {
        self.shown != other.shown || self.region != other.region
    }

    /// Has `world` show what is wanted.
    pub fn apply(&self, world: &mut World) {
        world.render.view = self.shown.unwrap_or(world.render.view);
        world.look.exposure += self.stops;
        world.look.tonemap = self.tonemap.unwrap_or(world.look.tonemap);
    }

    /// The part of a picture of `size` that is rendered, in whole pixels: left, top, width and height.
    pub fn window(&self, size: [u32; 2]) -> Option<[u32; 4]> {
        let [left, top, right, bottom] = self.region?;
        let along = |from: f64, to: f64, length: u32| {
            let first = ((from * f64::from(length)) as u32).min(length.saturating_sub(1));
            let end = ((to * f64::from(length)).ceil() as u32).clamp(first + 1, length.max(first + 1));
            (first, end - first)
        };
        let ((x, width), (y, height)) = (along(left, right, size[0]), along(top, bottom, size[1]));
        Some([x, y, width, height])
    }

    /// Takes the part between two corners, each a share of width and height; a part without area is the whole.
    pub fn choose(&mut self, a: [f64; 2], b: [f64; 2]) {
        let order = |i: usize| {
            let (a, b) = (a[i].clamp(0.0, 1.0), b[i].clamp(0.0, 1.0));
            (a.min(b), a.max(b))
        };
        let ((left, right), (top, bottom)) = (order(0), order(1));
        let large = right - left > LEAST_REGION && bottom - top > LEAST_REGION;
        self.region = large.then_some([left, top, right, bottom]);
    }
}

/// How large the picture is and where it lies, against one that fills its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zoom {
    /// Times as large.
    factor: f32,
    /// How far its middle is from the area's, in heights of a picture that fills it.
    offset: [f32; 2],
}

impl Default for Zoom {
    fn default() -> Self {
        Self { factor: 1.0, offset: [0.0; 2] }
    }
}

impl Zoom {
    /// Times as large as a picture that fills its area.
    pub fn factor(&self) -> f32 {
        self.factor
    }

    /// Where the middle of the picture is from the middle of the area, in heights of a picture that fills it.
    pub fn offset(&self) -> [f32; 2] {
        self.offset
    }

    /// Makes it `by` times as large, where `at` stays where it is: from the middle of the area, in heights.
    pub fn scale(&mut self, by: f32, at: [f32; 2]) {
        if !by.is_finite() || by <= 0.0 {
            return;
        }
        let factor = (self.factor * by).clamp(*FACTORS.start(), *FACTORS.end());
        let by = factor / self.factor;
        for (offset, at) in self.offset.iter_mut().zip(at) {
            *offset = at + (*offset - at) * by;
        }
        self.factor = factor;
        self.keep_near();
    }

    /// Moves it, in heights of a picture that fills its area.
    pub fn pan(&mut self, by: [f32; 2]) {
        for (offset, by) in self.offset.iter_mut().zip(by) {
            *offset += if by.is_finite() { by } else { 0.0 };
        }
        self.keep_near();
    }

    /// Some of it is always seen.
    fn keep_near(&mut self) {
        let reach = 0.5 * (self.factor + 1.0);
        self.offset = self.offset.map(|offset| offset.clamp(-reach, reach));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_under_the_pointer_stays_there() {
        let mut zoom = Zoom::default();
        zoom.scale(2.0, [0.25, 0.1]);
        // A point of the picture at `at` was `at` from its middle, and is twice that now.
        assert_eq!((zoom.factor(), zoom.offset()), (2.0, [-0.25, -0.1]));
        zoom.scale(0.5, [0.25, 0.1]);
        assert_eq!(zoom, Zoom::default());
    }

    #[test]
    fn a_picture_never_gets_lost() {
        let mut zoom = Zoom::default();
        zoom.pan([1e9, f32::NAN]);
        assert_eq!(zoom.offset(), [1.0, 0.0]);
        zoom.scale(f32::INFINITY, [0.0; 2]);
        zoom.scale(1e9, [0.0; 2]);
        assert_eq!(zoom.factor(), 16.0);
        zoom.scale(-1.0, [0.0; 2]);
        zoom.scale(1e-9, [0.0; 2]);
        assert!((zoom.factor() - 0.1).abs() < 1e-6);
    }

    #[test]
    fn regions_are_whole_pixels_of_the_picture() {
        let mut looking = Looking::default();
        assert_eq!(looking.window([100, 50]), None);
        looking.choose([0.751, 0.5], [0.25, -3.0]);
        assert_eq!(looking.region, Some([0.25, 0.0, 0.751, 0.5]));
        assert_eq!(looking.window([100, 50]), Some([25, 0, 51, 25]));
        assert_eq!(looking.window([1, 1]), Some([0, 0, 1, 1]));
        looking.choose([1.0, 1.0], [0.99, 0.99]);
        assert_eq!(looking.window([10, 10]), Some([9, 9, 1, 1]));
        looking.choose([0.5, 0.1], [0.5, 0.9]);
        assert_eq!(looking.region, None);
    }
}
