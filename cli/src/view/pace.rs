//! How much to render at once, so that there is soon something new to see.

/// What a preview may take, in seconds.
const PREVIEW_S: f64 = 0.05;
/// What one pass of the full picture is meant to take, in seconds.
const PASS_S: f64 = 0.2;
/// A full picture whose first sample takes no longer than this, in seconds, needs no preview.
const SOON_S: f64 = 0.1;
/// No preview is smaller, in pixels along its shorter side.
const MIN_SIDE: f64 = 16.0;

/// The speed of the backend on the present scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    samples_per_s: f64,
}

impl Default for Pace {
    /// A slow machine: the first preview must come soon on any.
    fn default() -> Self {
        Self { samples_per_s: 3e5 }
    }
}

impl Pace {
    /// Learns from a pass of `samples` samples a pixel.
    pub fn learn(&mut self, size: [u32; 2], samples: u32, seconds: f64) {
        let rate = pixels(size) * f64::from(samples) / seconds;
        if rate.is_finite() && rate > 0.0 {
            self.samples_per_s = rate;
        }
    }

    /// The size of a preview of a picture of `size`; none if the picture itself comes as soon. `moving`: a newer one will
    /// be wanted at once.
    pub fn preview(&self, size: [u32; 2], moving: bool) -> Option<[u32; 2]> {
        let budget_s = if moving { PREVIEW_S } else { SOON_S };
        if pixels(size) <= self.samples_per_s * budget_s {
            return None;
        }
        let shorter = f64::from(size[0].min(size[1]));
        let factor = (self.samples_per_s * PREVIEW_S / pixels(size)).sqrt().max(MIN_SIDE / shorter);
        let small = size.map(|side| ((f64::from(side) * factor).round() as u32).clamp(1, side));
        (small != size).then_some(small)
    }

    /// How many samples to add to a picture that has `done`, 1..=`most`: never more than twice what is there.
    pub fn pass(&self, size: [u32; 2], done: u32, most: u32) -> u32 {
        let fitting = (self.samples_per_s * PASS_S / pixels(size)) as u32;
        fitting.min(done.max(1)).clamp(1, most.max(1))
    }
}

fn pixels(size: [u32; 2]) -> f64 {
    f64::from(size[0]) * f64::from(size[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn previews_are_as_large_as_the_pace_allows() {
        let slow = Pace { samples_per_s: 1e5 };
        for (size, moving, expected) in [
            ([64, 64], true, None),
            ([100, 100], false, None),
            ([100, 100], true, Some([71, 71])),
            ([1000, 500], true, Some([100, 50])),
            ([16384, 16384], true, Some([71, 71])),
            ([16384, 16], true, None),
            ([1, 1], true, None),
        ] {
            assert_eq!(slow.preview(size, moving), expected, "{size:?} {moving}");
        }
        assert_eq!(Pace { samples_per_s: 1e9 }.preview([1920, 1080], true), None);
    }

    #[test]
    fn passes_grow_to_the_time_they_may_take() {
        let pace = Pace { samples_per_s: 1e6 };
        for (done, expected) in [(0, 1), (1, 1), (2, 2), (4, 4), (8, 8), (100, 16)] {
            assert_eq!(pace.pass([100, 100], done, 16), expected, "after {done}");
        }
        assert_eq!(pace.pass([1000, 1000], 100, 16), 1);
        assert_eq!(pace.pass([1000, 1000], 100, 0), 1);
    }

    #[test]
    fn what_teaches_nothing_changes_nothing() {
        let mut pace = Pace::default();
        pace.learn([100, 100], 1, 0.0);
        assert_eq!(pace, Pace::default());
        pace.learn([100, 100], 2, 0.5);
        assert_eq!(pace, Pace { samples_per_s: 4e4 });
    }
}
