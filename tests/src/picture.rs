//! Pictures that are kept: 8-bit RGB, as PNG.

use std::path::Path;

/// Writes a picture of `size`, and the folders that it lies in.
///
/// # Panics
/// It cannot be written.
pub fn write_png(path: &Path, size: [u32; 2], rgb: &[u8]) {
    std::fs::create_dir_all(path.parent().expect("a picture has a folder")).expect("the folder can be made");
    let mut encoder =
        png::Encoder::new(std::fs::File::create(path).expect("a picture can be written"), size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().expect("a header");
    writer.write_image_data(rgb).expect("pixels");
}

/// What [`write_png`] wrote.
///
/// # Panics
/// It is not there.
pub fn read_png(path: &Path) -> Vec<u8> {
    let file = std::fs::File::open(path)
        .unwrap_or_else(|error| panic!("{}: {error}; KINORA_BLESS=1 makes pictures", path.display()));
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
    let mut rgb = vec![0; reader.output_buffer_size().expect("a small picture")];
    reader.next_frame(&mut rgb).expect("pixels");
    rgb
}

/// The mean difference of two pictures' values.
///
/// # Panics
/// They differ in size.
pub fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len(), "the picture that is kept has another size");
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}
