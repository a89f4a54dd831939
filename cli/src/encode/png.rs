//! PNG: display values in sRGB, with alpha where the picture has some.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use kinora_renderer::Image;

use super::{Bits, SOFTWARE, Stamp};

pub(super) fn encode(image: &Image, bits: Bits, stamp: &Stamp) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    write(&mut bytes, image, bits, stamp).map_err(|error| format!("cannot make a PNG: {error}"))?;
    Ok(bytes)
}

fn write(bytes: &mut Vec<u8>, image: &Image, bits: Bits, stamp: &Stamp) -> Result<(), png::EncodingError> {
    let [width, height] = image.size;
    let mut encoder = png::Encoder::new(bytes, width, height);
    encoder.set_color(if image.alpha.is_empty() { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_depth(match bits {
        Bits::Eight => png::BitDepth::Eight,
        Bits::Sixteen => png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
    for (name, value) in stamp.entries() {
        encoder.add_text_chunk(name.into(), value)?;
    }
    let mut writer = encoder.write_header()?;
    match bits {
        Bits::Eight => writer.write_image_data(&image.codes8())?,
        Bits::Sixteen => {
            let big_endian: Vec<u8> = image.codes16().into_iter().flat_map(u16::to_be_bytes).collect();
            writer.write_image_data(&big_endian)?;
        }
    }
    writer.finish()
}

/// The values of a PNG that this program wrote: rows from the top, 16 bits with the higher byte first.
///
/// # Errors
/// It is not there or damaged.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    let failed = |error: &dyn std::fmt::Display| format!("cannot read `{}`: {error}", path.display());
    let file = File::open(path).map_err(|error| failed(&error))?;
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().map_err(|error| failed(&error))?;
    let size = reader.output_buffer_size().ok_or_else(|| failed(&"it is too large"))?;
    let mut codes = vec![0; size];
    let info = reader.next_frame(&mut codes).map_err(|error| failed(&error))?;
    codes.truncate(info.buffer_size());
    Ok(codes)
}

/// What a PNG says under a name.
pub fn text(path: &Path, name: &str) -> Option<String> {
    let reader = png::Decoder::new(BufReader::new(File::open(path).ok()?)).read_info().ok()?;
    let texts = &reader.info().uncompressed_latin1_text;
    texts.iter().find(|chunk| chunk.keyword == name).map(|chunk| chunk.text.clone())
}
