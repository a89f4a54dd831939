//! Pictures of linear light: Radiance HDR and OpenEXR.
//!
//! Sizes are checked in the header, before anything is allocated for them. Lights of an EXR are its channels R, G and B, or
//! Y alone, of its first part that has them, on the canvas of its display window: what the data window leaves out is 0.

use std::io::Cursor;

use exr::prelude::{ReadChannels as _, ReadLayers as _, ReadSpecificChannel as _, Vec2};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder as _};

use super::AssetError;

/// Texels of a picture: 16384 × 8192 takes 1.5 GiB.
pub const MAX_TEXELS: u64 = 1 << 27;

/// A picture of linear light, rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct LightPicture {
    /// Width and height in texels, 1 or more.
    pub size: [u32; 2],
    /// Red, green and blue of every texel, as the file has them: not a number, infinite or negative ones too.
    pub rgb: Vec<f32>,
    /// Coverage, one a texel, where the file has it.
    pub alpha: Option<Vec<f32>>,
}

impl AssetError {
    /// E0805.
    pub(super) fn picture(message: impl Into<String>) -> AssetError {
        AssetError { code: "E0805", message: message.into(), help: "" }
    }
}

/// Whether the bytes are those of a Radiance HDR file.
pub fn is_hdr(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?")
}

/// Whether the bytes are those of an OpenEXR file.
pub fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// Reads a picture of linear light, whatever its name.
///
/// # Errors
/// E0805: the bytes are of neither format, damaged, of a kind that is not supported, or of too many texels.
pub fn read(bytes: &[u8]) -> Result<LightPicture, AssetError> {
    if is_exr(bytes) {
        return read_exr(bytes);
    }
    if is_hdr(bytes) {
        return read_hdr(bytes);
    }
    let mut error = AssetError::picture("is neither a Radiance HDR nor an OpenEXR file");
    error.help = "light is read from `.hdr` and `.exr`";
    Err(error)
}

fn check_size(width: u64, height: u64) -> Result<[u32; 2], AssetError> {
    if width == 0 || height == 0 {
        return Err(AssetError::picture("has no texels"));
    }
    if width.checked_mul(height).is_none_or(|texels| texels > MAX_TEXELS) {
        let limit = MAX_TEXELS >> 20;
        let mut error = AssetError::picture(format!("is {width} × {height} texels, limit {limit} Mi"));
        error.help = "scale it down";
        return Err(error);
    }
    Ok([width as u32, height as u32])
}

fn read_hdr(bytes: &[u8]) -> Result<LightPicture, AssetError> {
    let damaged = |error: image::ImageError| AssetError::picture(format!("cannot be decoded: {}", plain(&error)));
    // Not strict: `#?RGBE` opens as many files as `#?RADIANCE`.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let size = check_size(width.into(), height.into())?;
    // The shortest a row can be: a texel, then runs of up to 255, four bytes each, that count more by their place.
    if bytes.len() < 4 * size[1] as usize {
        return Err(AssetError::picture("cannot be decoded: unexpected end of file"));
    }
    // What the file's numbers were multiplied with.
    let exposure = decoder.metadata().exposure.filter(|e| e.is_normal() && *e > 0.0).unwrap_or(1.0);
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let mut rgb = picture.into_rgb32f().into_raw();
    if exposure != 1.0 {
        for value in &mut rgb {
            *value /= exposure;
        }
    }
    Ok(LightPicture { size, rgb, alpha: None })
}

/// A message as one clause on one line.
pub(super) fn plain(error: &dyn std::error::Error) -> String {
    let mut deepest = error;
    while let Some(source) = deepest.source() {
        deepest = source;
    }
    let text = deepest.to_string();
    let line = text.lines().next().unwrap_or_default().trim_end_matches('.');
    if line == "failed to fill whole buffer" || line.contains("Not enough bytes") || line.contains("nexpected end") {
        return "unexpected end of file".into();
    }
    let line = line.strip_prefix("invalid: ").map_or(line.to_string(), |what| format!("not valid: {what}"));
    let mut letters = line.chars();
    let lower = letters.next().map(|first| first.to_lowercase().chain(letters).collect::<String>());
    lower.unwrap_or_else(|| "it is damaged".into())
}

/// Which channels of a part give its light.
#[derive(Clone, Copy)]
enum Light {
    Color,
    Luminance,
}

fn light_of(header: &exr::meta::header::Header) -> Result<Light, AssetError> {
    let list = &header.channels.list;
    let has = |name: &str| list.iter().any(|channel| channel.name.eq_case_insensitive(name));
    if header.deep {
        return Err(AssetError::picture("holds deep data, which is not supported"));
    }
    let light = if ["R", "G", "B"].iter().all(|name| has(name)) {
        Light::Color
    } else if has("Y") && !has("RY") {
        Light::Luminance
    } else if has("Y") {
        let mut error = AssetError::picture("stores luminance and chroma (Y, RY, BY), which is not supported");
        error.help = "save it with channels R, G and B";
        return Err(error);
    } else {
        let names: Vec<String> = list.iter().take(8).map(|channel| format!("`{}`", channel.name)).collect();
        let mut error = AssetError::picture(format!("has channels {}, and no R, G and B", names.join(", ")));
        error.help = "save it with channels R, G and B, or Y";
        return Err(error);
    };
    if list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        let mut error = AssetError::picture("has subsampled channels, which are not supported");
        error.help = "save all channels at full resolution";
        return Err(error);
    }
    Ok(light)
}

/// What a part is read into: its data window, on the canvas of the display window.
struct Canvas {
    size: [usize; 2],
    rgb: Vec<f32>,
    alpha: Option<Vec<f32>>,
    /// Of the data window in the canvas.
    offset: [i64; 2],
}

impl Canvas {
    fn set(&mut self, at: Vec2<usize>, rgb: [f32; 3], alpha: f32) {
        let [x, y] = [at.x() as i64 + self.offset[0], at.y() as i64 + self.offset[1]];
        let [width, height] = self.size.map(|size| size as i64);
        if !(0..width).contains(&x) || !(0..height).contains(&y) {
            return;
        }
        let index = (y * width + x) as usize;
        self.rgb[3 * index..3 * index + 3].copy_from_slice(&rgb);
        if let Some(alphas) = &mut self.alpha {
            alphas[index] = alpha;
        }
    }
}

fn read_exr(bytes: &[u8]) -> Result<LightPicture, AssetError> {
    let damaged = |error: exr::error::Error| {
        let text = match error {
            exr::error::Error::NotSupported(what) => format!("needs what is not supported: {what}"),
            other => format!("cannot be decoded: {}", plain(&other)),
        };
        AssetError::picture(text)
    };
    let chunks = exr::block::read(Cursor::new(bytes), false).map_err(damaged)?;
    let headers = chunks.headers();
    let lights: Vec<_> = headers.iter().map(light_of).collect();
    let first = lights.iter().position(Result::is_ok);
    let (header, light) = match (first.and_then(|first| headers.get(first)), lights.into_iter().find(Result::is_ok)) {
        (Some(header), Some(Ok(light))) => (header.clone(), light),
        _ => {
            let first = headers.first().map(light_of);
            return Err(first.and_then(Result::err).unwrap_or_else(|| AssetError::picture("has no picture")));
        }
    };
    let display = header.shared_attributes.display_window;
    let data = header.layer_size;
    let size = check_size(display.size.x() as u64, display.size.y() as u64)?;
    check_size(data.x() as u64, data.y() as u64)?;
    let offset = [0, 1].map(|i| {
        let of = |at: Vec2<i32>| i64::from(if i == 0 { at.x() } else { at.y() });
        of(header.own_attributes.layer_position) - of(display.position)
    });
    let texels = size[0] as usize * size[1] as usize;
    let has_alpha = header.channels.list.iter().any(|channel| channel.name.eq_case_insensitive("A"));
    let create = move || Canvas {
        size: size.map(|size| size as usize),
        rgb: vec![0.0; 3 * texels],
        alpha: has_alpha.then(|| vec![0.0; texels]),
        offset,
    };
    let flat = exr::prelude::read().no_deep_data().largest_resolution_level();
    let canvas = match light {
        Light::Color => {
            let image = flat
                .specific_channels()
                .required("R")
                .required("G")
                .required("B")
                .optional("A", 1.0_f32)
                .collect_pixels(
                    move |_, _| create(),
                    |canvas: &mut Canvas, at, (r, g, b, a): (f32, f32, f32, f32)| canvas.set(at, [r, g, b], a),
                )
                .first_valid_layer()
                .all_attributes()
                .from_chunks(chunks)
                .map_err(damaged)?;
            image.layer_data.channel_data.pixels
        }
        Light::Luminance => {
            let image = flat
                .specific_channels()
                .required("Y")
                .optional("A", 1.0_f32)
                .collect_pixels(
                    move |_, _| create(),
                    |canvas: &mut Canvas, at, (y, a): (f32, f32)| canvas.set(at, [y; 3], a),
                )
                .first_valid_layer()
                .all_attributes()
                .from_chunks(chunks)
                .map_err(damaged)?;
            image.layer_data.channel_data.pixels
        }
    };
    Ok(LightPicture { size, rgb: canvas.rgb, alpha: canvas.alpha })
}
