//! OpenEXR: linear Rec. 709 light and layers in 32-bit floats (`id`: whole numbers), scanlines from the top, ZIP over 16
//! of them. A part of a picture lies in its place in the whole: the data window in the display window.

use std::io::Cursor;
use std::path::Path;

use exr::image::{self, AnyChannel, AnyChannels, Encoding, FlatSamples, Image};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, LineOrder, Rational, Text, TimeCode};
use exr::meta::header::LayerAttributes;
use exr::prelude::{Blocks, Compression, WritableImage};
use glam::{DMat4, DVec4, Vec3};
use kinora_renderer::{Film, Seen, measure};
use kinora_scene::{Projection, World};

use super::{Layer, Layers, Rate, SOFTWARE, Stamp};

const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

pub(super) fn encode(film: &Film, world: &World, layers: Layers, stamp: &Stamp) -> Result<Vec<u8>, String> {
    // Tiles, or lines in any order, come out in the order in which threads finish them.
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let mut attributes = LayerAttributes { software_name: Some(text_of(SOFTWARE)), ..Default::default() };
    attributes.comments = Some(text_of(&stamp.name));
    attributes.frames_per_second = Some(rational(Rate::of(stamp.fps)));
    attributes.exposure = Some((world.shutter.close_s - world.shutter.open_s) as f32);
    let (to_camera, to_device) = matrices(world);
    attributes.world_to_camera = Some(to_camera);
    attributes.world_to_normalized_device = to_device;
    let entries = stamp.entries().into_iter();
    attributes.other = entries.map(|(name, value)| (text_of(name), AttributeValue::Text(text_of(&value)))).collect();
    let window = film.window();
    // Both are below 2¹⁴.
    attributes.layer_position = Vec2(window.left as i32, window.top as i32);
    let size = (window.width as usize, window.height as usize);
    let mut image = Image::from_layer(image::Layer::new(size, attributes, encoding, channels(film, layers)));
    let [width, height] = film.picture();
    image.attributes.display_window = IntegerBounds::from_dimensions((width as usize, height as usize));
    image.attributes.chromaticities = Some(REC_709);
    image.attributes.time_code = time_code(stamp.frame, stamp.fps);
    let mut bytes = Vec::new();
    image.write().to_buffered(Cursor::new(&mut bytes)).map_err(|error| format!("cannot make an EXR: {error}"))?;
    sort_attributes(&mut bytes).ok_or("cannot make an EXR: its header makes no sense")?;
    Ok(bytes)
}

// The picture, its alpha if it has one, and the layers; sorted by name.
fn channels(film: &Film, layers: Layers) -> AnyChannels<FlatSamples> {
    let mut channels = Vec::new();
    let mut add = |name: String, samples| channels.push(AnyChannel::new(text_of(&name), samples));
    let colors = measure(film);
    for (axis, name) in ["R", "G", "B"].into_iter().enumerate() {
        add(name.into(), FlatSamples::F32(colors.iter().map(|color| color[axis]).collect()));
    }
    let pixels = || 0..film.window().pixels();
    let seen: Vec<Seen> = pixels().map_while(|i| film.seen(i)).collect();
    if film.is_transparent() {
        add("A".into(), FlatSamples::F32(seen.iter().map(|seen| seen.cover).collect()));
    }
    const RGB: [&str; 3] = ["R", "G", "B"];
    const XYZ: [&str; 3] = ["X", "Y", "Z"];
    for (layer, kind) in layers.wanted() {
        let mut each = |channel: &str, value: &dyn Fn(usize) -> f32| {
            add(format!("{layer}.{channel}"), FlatSamples::F32(pixels().map(value).collect()));
        };
        let mut vector = |channels: [&str; 3], value: &dyn Fn(usize) -> Vec3| {
            for (axis, channel) in channels.into_iter().enumerate() {
                each(channel, &|i| value(i)[axis]);
            }
        };
        let light = |i: usize| film.parts(i).unwrap_or_default();
        match kind {
            Layer::Albedo => vector(RGB, &|i| seen[i].albedo),
            Layer::Diffuse => vector(RGB, &|i| light(i).diffuse),
            Layer::Emission => vector(RGB, &|i| light(i).emission),
            Layer::Specular => vector(RGB, &|i| light(i).specular),
            Layer::Variance => vector(RGB, &|i| light(i).variance),
            Layer::Normal => vector(XYZ, &|i| seen[i].normal),
            Layer::Position => vector(XYZ, &|i| seen[i].position),
            Layer::Motion => {
                let motion = |i: usize| film.motion(i).unwrap_or_default();
                each("X", &|i| motion(i).x);
                each("Y", &|i| motion(i).y);
            }
            Layer::Depth => each("Z", &|i| seen[i].depth),
            Layer::Id => add(layer.into(), FlatSamples::U32(seen.iter().map(|seen| seen.id).collect())),
            Layer::Samples => {
                add(layer.into(), FlatSamples::F32(pixels().map(|i| film.samples_of(i) as f32).collect()))
            }
        }
    }
    AnyChannels::sort(channels.into())
}

// From the world to the camera, which looks along its own -z, and to the picture: x and y from -1, left and bottom, to 1.
// OpenEXR's vectors are rows. No matrix bends straight lines.
fn matrices(world: &World) -> ([f32; 16], Option<[f32; 16]>) {
    let camera = DMat4::from(world.view.world_from_camera.inverse());
    let [width, height] = world.render.resolution.map(f64::from);
    let device = match world.view.projection {
        // Depth runs from -1 at 1 cm to 1 infinitely far away.
        Projection::Perspective { fov } => {
            let (scale, near) = (1.0 / (0.5 * fov).tan(), 0.01);
            Some(DMat4::from_cols(
                DVec4::X * (scale * height / width),
                DVec4::Y * scale,
                DVec4::new(0.0, 0.0, -1.0, -1.0),
                DVec4::Z * (-2.0 * near),
            ))
        }
        // Depth runs from -1 at the eye to 1 at twice the distance in focus.
        Projection::Orthographic { height_m } => {
            let scale = 2.0 / height_m;
            Some(DMat4::from_cols(
                DVec4::X * (scale * height / width),
                DVec4::Y * scale,
                DVec4::Z * (-1.0 / world.view.focus_m),
                DVec4::new(0.0, 0.0, -1.0, 1.0),
            ))
        }
        Projection::Panorama | Projection::Fisheye { .. } => None,
    };
    let to_device = device.map(|device| (device * camera).as_mat4().to_cols_array());
    (camera.as_mat4().to_cols_array(), to_device)
}

// Hours, minutes, seconds and frames, as long as a tape has them: of whole frames of the first day at up to 30 a second.
fn time_code(frame: f64, fps: f64) -> Option<TimeCode> {
    let (rate, frame) = (fps.round() as u64, (frame >= 0.0 && frame.fract() == 0.0).then_some(frame as u64)?);
    let seconds = frame.checked_div(rate).filter(|seconds| rate <= 30 && *seconds < 24 * 3600)?;
    Some(TimeCode {
        hours: (seconds / 3600) as u8,
        minutes: (seconds / 60 % 60) as u8,
        seconds: (seconds % 60) as u8,
        frame: (frame % rate) as u8,
        drop_frame: false,
        color_frame: false,
        field_phase: false,
        binary_group_flags: [false; 3],
        binary_groups: [0; 8],
    })
}

fn text_of(text: &str) -> Text {
    Text::from(text)
}

fn rational(rate: Rate) -> Rational {
    // At most 2³¹ - 1.
    (rate.frames as i32, rate.seconds)
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
    fn time_codes() {
        let told = |code: TimeCode| [code.hours, code.minutes, code.seconds, code.frame];
        for (frame, fps, expected) in [
            (0.0, 24.0, Some([0, 0, 0, 0])),
            (49.0, 24.0, Some([0, 0, 2, 1])),
            (24.0 * 3725.0 + 3.0, 24.0, Some([1, 2, 5, 3])),
            (1e9, 24.0, None),
            (-1.0, 24.0, None),
            (0.5, 24.0, None),
            (3.0, 60.0, None),
            (3.0, 0.1, None),
        ] {
            assert_eq!(time_code(frame, fps).map(told), expected, "frame {frame} at {fps}");
        }
    }
}
