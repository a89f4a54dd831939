//! Radiance HDR and JPEG. The image crate writes neither's comments, so they are put in here.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::Vec3;
use image::codecs::{hdr::HdrEncoder, jpeg::JpegEncoder};
use image::{ExtendedColorType, Rgb};
use kinora_renderer::Image;

use super::{SOFTWARE, Stamp};

/// Comments lie in the first bytes of a file.
const HEAD: u64 = 1 << 14;

pub(super) fn hdr(radiance: &[Vec3], [width, height]: [u32; 2], stamp: &Stamp) -> Result<Vec<u8>, String> {
    let pixels: Vec<Rgb<f32>> = radiance.iter().map(|color| Rgb(color.to_array())).collect();
    let mut bytes = Vec::new();
    let encoder = HdrEncoder::new(&mut bytes);
    encoder.encode(&pixels, width as usize, height as usize).map_err(|error| format!("cannot make an HDR: {error}"))?;
    let first_line = bytes.iter().position(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let lines = comments(stamp).into_iter().map(|line| format!("# {line}\n")).collect::<String>();
    bytes.splice(first_line..first_line, lines.into_bytes());
    Ok(bytes)
}

pub(super) fn jpg(picture: &Image, stamp: &Stamp) -> Result<Vec<u8>, String> {
    let [width, height] = picture.size;
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
    let encoded = encoder.encode(&picture.codes8(), width, height, ExtendedColorType::Rgb8);
    encoded.map_err(|error| format!("cannot make a JPEG: {error}"))?;
    // Behind the two bytes that start the file: marker COM, length with itself, text.
    let comment = comments(stamp).into_iter().map(|line| line + "\n").collect::<String>().into_bytes();
    let length = u16::try_from(comment.len() + 2).map_err(|_| "cannot make a JPEG: the comment is too long")?;
    bytes.splice(2..2, [vec![0xFF, 0xFE], length.to_be_bytes().to_vec(), comment].concat());
    Ok(bytes)
}

fn comments(stamp: &Stamp) -> Vec<String> {
    let entries = stamp.entries().into_iter().map(|(name, value)| format!("{name}={value}"));
    std::iter::once(format!("Software={SOFTWARE}")).chain(entries).collect()
}

pub(super) fn text(path: &Path, name: &str) -> Option<String> {
    let mut head = Vec::new();
    File::open(path).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
    let head = String::from_utf8_lossy(&head);
    let (_, value) = head.split_once(&format!("{name}="))?;
    value.lines().next().map(str::to_string)
}
