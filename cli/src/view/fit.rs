//! Where the picture lies in the window.

/// Above this many window pixels a picture's pixel, pixels are shown as squares.
const SQUARES_ABOVE: f32 = 2.0;

/// How a picture is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Width and height in the area's unit.
    pub size: [f32; 2],
    /// Area units a pixel of the picture.
    pub scale: f32,
}

impl Fit {
    /// So many times as large.
    pub fn scaled(&self, factor: f32) -> Fit {
        Fit { size: self.size.map(|side| side * factor), scale: self.scale * factor }
    }

    /// Whether pixels are so large that they are better shown as squares. `pixels_per_unit`: window pixels an area unit.
    pub fn squares(&self, pixels_per_unit: f32) -> bool {
        self.scale * pixels_per_unit > SQUARES_ABOVE
    }
}

/// The largest place for a picture of `picture` pixels in `area` that keeps its shape; none where there is no room.
pub fn fit(picture: [u32; 2], area: [f32; 2]) -> Option<Fit> {
    let [width, height] = picture.map(|side| side as f32);
    let scale = (area[0] / width).min(area[1] / height);
    (scale.is_finite() && scale > 0.0).then_some(Fit { size: [width * scale, height * scale], scale })
}

/// `picture` made smaller, in its shape, so that no side is longer than `max_side`.
pub fn limit(picture: [u32; 2], max_side: u32) -> [u32; 2] {
    let longest = picture[0].max(picture[1]);
    if longest <= max_side {
        return picture;
    }
    let factor = f64::from(max_side) / f64::from(longest);
    picture.map(|side| ((f64::from(side) * factor).round() as u32).clamp(1, max_side.max(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_fills_one_direction() {
        let check = |picture, area, size, squares| {
            let got = fit(picture, area).unwrap();
            assert_eq!((got.size, got.squares(1.0)), (size, squares), "{picture:?} in {area:?}");
        };
        check([100, 100], [300.0, 200.0], [200.0, 200.0], false);
        check([100, 50], [300.0, 200.0], [300.0, 150.0], true);
        check([1600, 900], [800.0, 900.0], [800.0, 450.0], false);
        assert_eq!(fit([10, 10], [0.0, 5.0]), None);
        assert_eq!(fit([0, 0], [5.0, 5.0]), None);
    }

    #[test]
    fn a_limit_keeps_the_shape() {
        assert_eq!(limit([640, 480], 8192), [640, 480]);
        assert_eq!(limit([16384, 8192], 8192), [8192, 4096]);
        assert_eq!(limit([16384, 1], 8192), [8192, 1]);
    }
}
