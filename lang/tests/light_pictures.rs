//! Pictures of linear light from files.

use std::io::Cursor;

use exr::prelude::*;
use kinora_lang::assets::hdr;

fn hdr_of(header: &str, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(texels.as_flattened());
    bytes
}

#[test]
fn radiance_files() {
    let texels = [[128, 64, 32, 129], [128, 128, 128, 128], [0, 0, 0, 0], [255, 0, 0, 136]];
    let picture = hdr::read(&hdr_of("#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n", &texels)).expect("it is one");
    assert_eq!(picture.size, [2, 2]);
    assert_eq!(picture.rgb, [1.0, 0.5, 0.25, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0, 255.0, 0.0, 0.0]);
    let brighter = hdr_of("#?RADIANCE\nEXPOSURE=4\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n", &texels[..2]);
    assert_eq!(hdr::read(&brighter).expect("it is one").rgb, [0.25, 0.125, 0.0625, 0.125, 0.125, 0.125]);
    for (bytes, said) in [
        (hdr_of("#?RADIANCE\n\n-Y 2 +X 2\n", &texels[..3]), "end of file"),
        (hdr_of("#?RADIANCE\n\n-Y 99999 +X 99999\n", &texels), "limit"),
        (hdr_of("#?RADIANCE\n\n-Y 0 +X 4\n", &[]), "no texels"),
        (hdr_of("#?RADIANCE\n", &[]), ""),
        (b"P6 2 2 255\n".to_vec(), "neither"),
    ] {
        let error = hdr::read(&bytes).expect_err(said);
        assert!(error.code == "E0805" && error.message.contains(said), "{error:?}");
    }
}

#[test]
fn exr_files_lie_in_their_display_window() {
    let pixel = |at: Vec2<usize>| (at.x() as f32, at.y() as f32, -1.5_f32);
    let mut layer =
        Layer::new((3, 2), LayerAttributes::named("light"), Encoding::SMALL_LOSSLESS, SpecificChannels::rgb(pixel));
    layer.attributes.layer_position = Vec2(-1, 1);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new(Vec2(0, 0), Vec2(4, 2));
    let mut bytes = Vec::new();
    image.write().to_buffered(Cursor::new(&mut bytes)).expect("memory");
    let picture = hdr::read(&bytes).expect("it is one");
    assert_eq!((picture.size, picture.alpha), ([4, 2], None));
    // The first row and the last columns are outside of the data, the data's first column outside of the picture.
    let expected = [[0.0; 3]; 4].into_iter().chain([[1.0, 0.0, -1.5], [2.0, 0.0, -1.5], [0.0; 3], [0.0; 3]]);
    assert_eq!(picture.rgb, expected.collect::<Vec<_>>().as_flattened());
    for cut in 0..bytes.len() {
        assert_eq!(hdr::read(&bytes[..cut]).expect_err("it is cut off").code, "E0805");
    }
}

#[test]
fn luminance_alone_is_grey() {
    let channels = SpecificChannels::build().with_channel("A").with_channel("Y");
    let channels = channels.with_pixel_fn(|at: Vec2<usize>| (0.5_f32, f16::from_f32(at.x() as f32)));
    let mut bytes = Vec::new();
    let image = Image::from_channels((2, 1), channels);
    image.write().to_buffered(Cursor::new(&mut bytes)).expect("memory");
    let picture = hdr::read(&bytes).expect("it is one");
    assert_eq!((picture.rgb, picture.alpha), (vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], Some(vec![0.5, 0.5])));
}
