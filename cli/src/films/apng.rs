//! Animated PNG: every frame whole, without loss, for ever again.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use super::Head;
use crate::encode::{Bits, Rate, SOFTWARE};

pub struct Apng(png::Writer<BufWriter<File>>);

impl Apng {
    pub fn begin(head: &Head, path: &Path) -> Result<Apng, String> {
        let file = File::create(path).map_err(|error| error.to_string())?;
        let begin = || -> Result<_, png::EncodingError> {
            let [width, height] = head.size;
            let mut encoder = png::Encoder::new(BufWriter::new(file), width, height);
            encoder.set_color(if head.alpha { png::ColorType::Rgba } else { png::ColorType::Rgb });
            encoder.set_depth(match head.bits {
                Bits::Eight => png::BitDepth::Eight,
                Bits::Sixteen => png::BitDepth::Sixteen,
            });
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            encoder.set_animated(head.count, 0)?;
            let (seconds, frames) = delay(head.rate);
            encoder.set_frame_delay(seconds, frames)?;
            encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
            for (name, value) in &head.facts {
                encoder.add_text_chunk((*name).into(), value.clone())?;
            }
            encoder.write_header()
        };
        begin().map(Apng).map_err(|error| error.to_string())
    }

    pub fn frame(&mut self, codes: &[u8]) -> Result<(), String> {
        self.0.write_image_data(codes).map_err(|error| error.to_string())
    }

    pub fn finish(self) -> Result<(), String> {
        self.0.finish().map_err(|error| error.to_string())
    }
}

// How long a frame lasts, as a fraction of 16-bit numbers: exactly where that can be.
fn delay(rate: Rate) -> (u16, u16) {
    let Rate { frames, seconds } = rate;
    match (u16::try_from(seconds), u16::try_from(frames)) {
        (Ok(seconds), Ok(frames)) => (seconds, frames),
        _ => {
            let most = f64::from(u16::MAX);
            let scale = most / f64::from(frames.max(seconds));
            let part = |number: u32| (f64::from(number) * scale).round().clamp(1.0, most) as u16;
            (part(seconds), part(frames))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays() {
        for (frames, seconds, expected) in [
            (24, 1, (1, 24)),
            (30_000, 1001, (1001, 30_000)),
            (25, 2, (2, 25)),
            (1_000_000, 1, (1, 65_535)),
            (120_000, 1001, (547, 65_535)),
            (1, 1_000_000, (65_535, 1)),
        ] {
            assert_eq!(delay(Rate { frames, seconds }), expected, "{frames}/{seconds}");
        }
    }
}
