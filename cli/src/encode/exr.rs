//! OpenEXR: linear Rec. 709 light in 32-bit floats, scanlines from the top, ZIP over 16 of them.

use std::io::Cursor;
use std::path::Path;

use exr::image::{Encoding, Image, Layer, SpecificChannels};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Rational, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{Blocks, Compression, WritableImage};
use glam::Vec3;

use super::{SOFTWARE, Stamp};

const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

pub(super) fn encode(radiance: &[Vec3], [width, height]: [u32; 2], stamp: &Stamp) -> Result<Vec<u8>, String> {
    let (width, height) = (width as usize, height as usize);
    let channels = SpecificChannels::rgb(|Vec2(x, y): Vec2<usize>| {
        let color = radiance.get(y * width + x).copied().unwrap_or_default();
        (color.x, color.y, color.z)
    });
    // Tiles, or lines in any order, come out in the order in which threads finish them.
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let mut attributes = LayerAttributes { software_name: Some(text_of(SOFTWARE)), ..Default::default() };
    attributes.frames_per_second = Some(rational(stamp.fps));
    let entries = stamp.entries().into_iter();
    attributes.other = entries.map(|(name, value)| (text_of(name), AttributeValue::Text(text_of(&value)))).collect();
    let mut image = Image::from_layer(Layer::new((width, height), attributes, encoding, channels));
    image.attributes.chromaticities = Some(REC_709);
    let mut bytes = Vec::new();
    image.write().to_buffered(Cursor::new(&mut bytes)).map_err(|error| format!("cannot make an EXR: {error}"))?;
    sort_attributes(&mut bytes).ok_or("cannot make an EXR: its header makes no sense")?;
    Ok(bytes)
}

fn text_of(text: &str) -> Text {
    Text::from(text)
}

// Frames a second as film knows them: whole, or n · 1000 / 1001.
fn rational(fps: f64) -> Rational {
    let ntsc = fps * 1.001;
    let near = |value: f64| (value - value.round()).abs() < 1e-6 && value < 1e6;
    match (near(fps), near(ntsc)) {
        (true, _) => (fps.round() as i32, 1),
        (_, true) => (ntsc.round() as i32 * 1000, 1001),
        _ => ((fps * 1000.0).round() as i32, 1000),
    }
}

/// Sorts the attributes of the header, which is 8 bytes in: the crate writes those that are not OpenEXR's own in the
/// order of a hash map, another one in every run. No offset changes. `None` if this is no such header.
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    let mut at = 8;
    let mut attributes = Vec::new();
    while *file.get(at)? != 0 {
        let rest = &file[at..];
        // name, 0, type, 0, four bytes of length, value
        let name = rest.iter().position(|byte| *byte == 0)?;
        let kind = rest.get(name + 1..)?.iter().position(|byte| *byte == 0)?;
        let length = name + kind + 2;
        let size: [u8; 4] = rest.get(length..length + 4)?.try_into().ok()?;
        let end = (length + 4).checked_add(usize::try_from(u32::from_le_bytes(size)).ok()?)?;
        attributes.push(rest.get(..end)?.to_vec());
        at += end;
    }
    attributes.sort();
    file.get_mut(8..at)?.copy_from_slice(&attributes.concat());
    Some(())
}

pub(super) fn text(path: &Path, name: &str) -> Option<String> {
    let meta = MetaData::read_from_file(path, false).ok()?;
    let header = meta.headers.first()?;
    match header.own_attributes.other.get(&text_of(name))? {
        AttributeValue::Text(value) => Some(value.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_picture_is_the_same_bytes() {
        let stamp = Stamp {
            scene: "5ce0e".into(),
            seed: 3,
            frame: 7.0,
            samples: 16,
            backend: "cpu",
            fps: 24.0,
            key: Some("f00d".into()),
        };
        let radiance: Vec<Vec3> = (0..100 * 40).map(|i| Vec3::new(i as f32, 1.0 / (i as f32 + 1.0), -0.5)).collect();
        let first = encode(&radiance, [100, 40], &stamp).unwrap();
        for _ in 0..8 {
            assert!(encode(&radiance, [100, 40], &stamp).unwrap() == first);
        }
        let path = std::env::temp_dir().join(format!("kinora-exr-{}.exr", std::process::id()));
        std::fs::write(&path, &first).unwrap();
        let image = exr::prelude::read_first_rgba_layer_from_file(
            &path,
            |size, _| vec![Vec3::ZERO; size.area()],
            |pixels: &mut Vec<Vec3>, Vec2(x, y), (r, g, b, _): (f32, f32, f32, f32)| {
                pixels[y * 100 + x] = Vec3::new(r, g, b);
            },
        );
        let (key, scene) = (text(&path, "kinora:frameKey"), text(&path, "kinora:scene"));
        std::fs::remove_file(&path).unwrap();
        let image = image.unwrap();
        assert_eq!(image.layer_data.channel_data.pixels, radiance);
        assert_eq!(image.layer_data.attributes.software_name, Some(text_of(SOFTWARE)));
        assert_eq!(image.layer_data.attributes.frames_per_second, Some((24, 1)));
        assert_eq!((key.as_deref(), scene.as_deref()), (Some("f00d"), Some("5ce0e")));
    }

    #[test]
    fn frames_a_second() {
        for (fps, expected) in [(24.0, (24, 1)), (30000.0 / 1001.0, (30000, 1001)), (12.5, (12500, 1000))] {
            assert_eq!(rational(fps), expected);
        }
    }
}
