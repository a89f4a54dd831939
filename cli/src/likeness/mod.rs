//! How alike two pictures are: by FLIP, which says what an eye sees when it flips between them (Andersson, Nilsson,
//! Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for Alternating Images", HPG 2020), and
//! by the relative error of their light.

mod page;

use std::io::Cursor;
use std::path::Path;

use flip_rs::{DEFAULT_PPD, ErrorMap, FlipError, HdrOptions, RgbImage, hdr_flip, ldr_flip};
use image::{ImageFormat, ImageReader};

pub use page::{Shown, page};

/// Files larger than this are no pictures to compare.
pub const MOST_BYTES: u64 = 2 << 30;
/// Pixels of the largest picture.
const MOST_PIXELS: u64 = 1 << 28;

/// A picture to compare.
pub struct Picture {
    /// In pixels.
    pub size: [usize; 2],
    /// Three a pixel, row by row from the top; transparent pictures stand before grey.
    pub rgb: Vec<f32>,
    /// Whether they are linear light, which may exceed 1; else display values, 0..=1.
    pub linear: bool,
}

/// What lies between two pictures.
pub struct Difference {
    /// The mean of FLIP, 0..=1: 0 is no difference that is seen.
    pub flip: f64,
    /// The mean of (test − reference)² / (reference² + 0.01) over all channels, in linear light.
    pub error: f64,
    /// Whether any number differs.
    pub any: bool,
    /// FLIP of each pixel.
    map: ErrorMap,
}

impl Picture {
    /// Reads a PNG, JPEG, EXR or HDR.
    ///
    /// # Errors
    /// There is no such file, or it is no picture.
    pub fn read(path: &Path) -> Result<Picture, String> {
        let cannot = |what: &dyn std::fmt::Display| format!("cannot read `{}`: {what}", path.display());
        let size = std::fs::metadata(path).map_err(|error| cannot(&error))?.len();
        if size > MOST_BYTES {
            return Err(cannot(&"it is too large"));
        }
        let bytes = std::fs::read(path).map_err(|error| cannot(&error))?;
        Picture::decode(path, &bytes).map_err(|error| cannot(&error))
    }

    /// As [`Picture::read`], of the bytes of a file of that name.
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Picture, String> {
        match path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase().as_str() {
            "exr" => exr(bytes),
            "hdr" => other(bytes, ImageFormat::Hdr),
            "png" => other(bytes, ImageFormat::Png),
            "jpg" | "jpeg" => other(bytes, ImageFormat::Jpeg),
            _ => Err("pictures are compared as .png, .jpg, .exr or .hdr".into()),
        }
    }

    /// As a PNG for looking at: linear light by the sRGB curve, what is above 1 as 1.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let shown = |value: &f32| {
            let value = if self.linear { encoded(*value) } else { *value };
            (value.clamp(0.0, 1.0) * 255.0).round() as u8
        };
        png(self.size, self.rgb.iter().map(shown).collect())
    }

    fn light(&self, i: usize) -> f64 {
        let value = f64::from(self.rgb[i]);
        match self.linear {
            true => value,
            false if value <= 0.04045 => value / 12.92,
            false => ((value + 0.055) / 1.055).powf(2.4),
        }
    }
}

impl Difference {
    /// Between a reference and another picture.
    ///
    /// # Errors
    /// They are not of one size or kind, or a number in them is none.
    pub fn between(reference: &Picture, test: &Picture) -> Result<Difference, String> {
        if reference.size != test.size {
            return Err(sizes(reference, test));
        }
        if reference.linear != test.linear {
            return Err(
                "one of them is linear light (.exr, .hdr), the other as a display shows it: compare two of a kind"
                    .into(),
            );
        }
        let said = |error: FlipError| match error {
            FlipError::NonFiniteInput => "a pixel is no number".to_string(),
            error => error.to_string(),
        };
        let image = |picture: &Picture| RgbImage::new(picture.size[0], picture.size[1], picture.rgb.clone());
        let (a, b) = (image(reference).map_err(said)?, image(test).map_err(said)?);
        let map = match reference.linear {
            true => {
                let mut options = HdrOptions::default();
                options.return_exposure_map = false;
                if reference.rgb.iter().all(|value| *value <= 0.0) {
                    // A black picture has no exposure of its own.
                    (options.start_exposure, options.stop_exposure) = (Some(0.0), Some(0.0));
                }
                hdr_flip(&a, &b, options).map_err(said)?.error_map
            }
            false => ldr_flip(&a, &b, DEFAULT_PPD).map_err(said)?,
        };
        let square = |i: usize| {
            let (a, b) = (reference.light(i), test.light(i));
            (b - a) * (b - a) / (a * a + 0.01)
        };
        let count = reference.rgb.len();
        let error = (0..count).map(square).sum::<f64>() / count as f64;
        let flip = map.pixels().iter().map(|pixel| f64::from(*pixel)).sum::<f64>() / map.pixels().len() as f64;
        Ok(Difference { flip, error, any: reference.rgb != test.rgb, map })
    }

    /// FLIP of each pixel in the colours of "magma", black where there is none, as a PNG.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        png([self.map.width(), self.map.height()], colored(&self.map).map_err(|error| error.to_string())?)
    }
}

fn colored(map: &ErrorMap) -> Result<Vec<u8>, FlipError> {
    Ok(map.colorize()?.pixels().iter().map(|value| (value.clamp(0.0, 1.0) * 255.0).round() as u8).collect())
}

/// The colours of FLIP from 0 to 1, in equal steps, as CSS has them.
fn colors() -> Vec<String> {
    const STEPS: usize = 17;
    let steps = (0..STEPS).map(|step| step as f32 / (STEPS - 1) as f32).collect();
    let bytes = ErrorMap::new(STEPS, 1, steps).and_then(|map| colored(&map)).unwrap_or_default();
    bytes.chunks_exact(3).map(|color| format!("#{:02x}{:02x}{:02x}", color[0], color[1], color[2])).collect()
}

/// What is said of two pictures that are not of one size.
pub fn sizes(reference: &Picture, test: &Picture) -> String {
    let [a, b] = [reference.size, test.size].map(|[width, height]| format!("{width} × {height}"));
    format!("the reference is {a}, the picture {b}")
}

fn encoded(light: f32) -> f32 {
    if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

fn png([width, height]: [usize; 2], rgb: Vec<u8>) -> Result<Vec<u8>, String> {
    let picture = image::RgbImage::from_raw(width as u32, height as u32, rgb).ok_or("a picture without pixels")?;
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// What shines through where a picture is transparent.
const BEHIND: f32 = 0.5;

fn other(bytes: &[u8], format: ImageFormat) -> Result<Picture, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| error.to_string())?;
    let size = [picture.width() as usize, picture.height() as usize];
    let linear = format == ImageFormat::Hdr;
    let rgb = picture.into_rgba32f().pixels().flat_map(|pixel| before([0, 1, 2].map(|i| pixel[i]), pixel[3])).collect();
    Ok(Picture { size, rgb, linear })
}

fn before(color: [f32; 3], alpha: f32) -> [f32; 3] {
    if alpha >= 1.0 { color } else { color.map(|value| value * alpha + BEHIND * (1.0 - alpha)) }
}

fn exr(bytes: &[u8]) -> Result<Picture, String> {
    use exr::prelude::*;
    let read = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| ([size.width(), size.height()], vec![0.0_f32; size.area() * 3]),
            // Colours are premultiplied.
            |(size, rgb), at, (r, g, b, a): (f32, f32, f32, f32)| {
                let behind = BEHIND * (1.0 - a);
                if let Some(pixel) = rgb.get_mut(3 * (at.y() * size[0] + at.x())..).and_then(|rest| rest.get_mut(..3)) {
                    pixel.copy_from_slice(&[r + behind, g + behind, b + behind]);
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel();
    // The pixels are there before the file shows that it has them.
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| error.to_string())?;
    let pixels = meta.headers.iter().map(|header| header.layer_size.area() as u64).max().unwrap_or(0);
    if pixels > MOST_PIXELS {
        return Err("it is too large".into());
    }
    let found = read.from_buffered(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let (size, rgb) = found.layer_data.channel_data.pixels;
    Ok(Picture { size, rgb, linear: true })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(size: [usize; 2], value: f32, linear: bool) -> Picture {
        Picture { size, rgb: vec![value; size[0] * size[1] * 3], linear }
    }

    #[test]
    fn differences() {
        let grey = flat([20, 10], 0.5, false);
        let same = Difference::between(&grey, &flat([20, 10], 0.5, false)).unwrap();
        assert_eq!((same.flip, same.error, same.any), (0.0, 0.0, false));
        let lighter = Difference::between(&grey, &flat([20, 10], 0.6, false)).unwrap();
        assert!(lighter.flip > 0.05 && lighter.error > 0.05 && lighter.any, "{} {}", lighter.flip, lighter.error);
        // In linear light the relative error is what it says.
        let double = Difference::between(&flat([9, 9], 1.0, true), &flat([9, 9], 2.0, true)).unwrap();
        assert!((double.error - 1.0 / 1.01).abs() < 1e-6, "{}", double.error);
        let black = Difference::between(&flat([9, 9], 0.0, true), &flat([9, 9], 0.0, true)).unwrap();
        assert_eq!((black.flip, black.error), (0.0, 0.0));
    }

    #[test]
    fn what_cannot_be_compared() {
        let grey = flat([2, 1], 0.5, false);
        let error = |test: &Picture| Difference::between(&grey, test).err().unwrap();
        assert_eq!(error(&flat([1, 2], 0.5, false)), "the reference is 2 × 1, the picture 1 × 2");
        assert!(error(&flat([2, 1], 0.5, true)).contains("linear"));
        assert_eq!(error(&flat([2, 1], f32::NAN, false)), "a pixel is no number");
        assert!(Picture::decode(Path::new("a.png"), b"no picture").is_err());
        assert!(Picture::decode(Path::new("a.exr"), b"no picture").is_err());
        assert!(Picture::decode(Path::new("a.gif"), b"").err().unwrap().contains(".png"));
    }
}
