//! Pictures as textures: PNG, JPEG, WebP, and those of linear light. A file is what its first bytes say, not its name.
//!
//! Sizes are checked in the header, before anything is allocated for texels.

use std::io::Cursor;

use image::codecs::{jpeg::JpegDecoder, png::PngDecoder, webp::WebPDecoder};
use image::{ColorType, DynamicImage, ImageDecoder, ImageError};
use kinora_scene::{Image, Texels};

use super::{AssetError, hdr};

/// Bytes that the texels of one picture may take.
const MAX_BYTES: u64 = 512 << 20;

/// Reads a picture.
///
/// # Errors
/// E0805: the bytes are of no format that is known, damaged, or of too many texels.
pub fn read(name: &str, bytes: &[u8]) -> Result<Image, AssetError> {
    let (size, texels) = if hdr::is_exr(bytes) || hdr::is_hdr(bytes) {
        light(bytes)?
    } else if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        decode(PngDecoder::new(Cursor::new(bytes)))?
    } else if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        decode(JpegDecoder::new(Cursor::new(bytes)))?
    } else if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        decode(WebPDecoder::new(Cursor::new(bytes)))?
    } else {
        let mut error = AssetError::picture("is not a picture that this program knows");
        error.help = "pictures are read from PNG, JPEG, WebP, OpenEXR and Radiance HDR";
        return Err(error);
    };
    Image::new(name, size[0], size[1], texels).ok_or_else(|| AssetError::picture("has no texels"))
}

fn too_large(size: [u32; 2], bytes: u64) -> AssetError {
    let message =
        format!("has {} × {} texels, which take {} MiB; limit {} MiB", size[0], size[1], bytes >> 20, MAX_BYTES >> 20);
    AssetError { help: "scale it down", ..AssetError::picture(message) }
}

fn light(bytes: &[u8]) -> Result<([u32; 2], Texels), AssetError> {
    let picture = hdr::read(bytes)?;
    let size = picture.size;
    let count = u64::from(size[0]) * u64::from(size[1]);
    if count * 16 > MAX_BYTES {
        return Err(too_large(size, count * 16));
    }
    if !picture.rgb.iter().chain(picture.alpha.iter().flatten()).all(|value| value.is_finite()) {
        return Err(AssetError::picture("has texels that are not finite numbers"));
    }
    let alpha = |i: usize| picture.alpha.as_ref().and_then(|alpha| alpha.get(i)).copied().unwrap_or(1.0);
    let texels = picture.rgb.as_chunks::<3>().0.iter().enumerate().map(|(i, &[r, g, b])| [r, g, b, alpha(i)]);
    Ok((size, Texels::Rgba32F(texels.collect())))
}

fn decode<D: ImageDecoder>(decoder: Result<D, ImageError>) -> Result<([u32; 2], Texels), AssetError> {
    let damaged = |error: ImageError| AssetError::picture(format!("cannot be decoded: {}", hdr::plain(&error)));
    let mut decoder = decoder.map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let size = [width, height];
    let deep = matches!(decoder.color_type(), ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16);
    let count = u64::from(width) * u64::from(height);
    let bytes = count * if deep { 8 } else { 4 };
    if bytes > MAX_BYTES {
        return Err(too_large(size, bytes));
    }
    // Decoders may need some of their own besides.
    let mut limits = image::Limits::no_limits();
    limits.max_alloc = Some(2 * MAX_BYTES);
    decoder.set_limits(limits).map_err(damaged)?;
    let image = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let texels = match deep {
        true => Texels::Rgba16(image.into_rgba16().into_raw().as_chunks::<4>().0.to_vec()),
        false => Texels::Rgba8(image.into_rgba8().into_raw().as_chunks::<4>().0.to_vec()),
    };
    Ok((size, texels))
}
