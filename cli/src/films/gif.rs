//! GIF: one palette for the whole film, so that nothing flickers between two; a pixel that stays is not written again.

use std::borrow::Cow;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use color_quant::NeuQuant;
use gif::{AnyExtension, DisposalMethod, Encoder, Frame, Repeat};

use super::Head;
use crate::encode::{Rate, read_png};

/// Colours of the palette; one more stands for what stays.
const COLORS: usize = 255;
const STAYS: u8 = 255;
/// Pixels that the palette is made from, of all frames together.
const SAMPLED: usize = 1 << 18;
/// A comment, among the blocks that players leave out.
const COMMENT: AnyExtension = AnyExtension(0xFE);

pub struct Gif {
    head: Head,
    path: PathBuf,
    frames: Vec<PathBuf>,
    // Red, green, blue, alpha.
    sampled: Vec<u8>,
}

impl Gif {
    pub fn begin(head: &Head, path: &Path) -> Result<Gif, String> {
        File::create(path).map_err(|error| error.to_string())?;
        Ok(Gif { head: head.clone(), path: path.to_path_buf(), frames: Vec::new(), sampled: Vec::new() })
    }

    // A second look at it is taken when the colours of all are known.
    pub fn frame(&mut self, codes: &[u8], png: &Path) {
        let (pixels, _) = codes.as_chunks::<3>();
        let step = (pixels.len() * self.head.count as usize).div_ceil(SAMPLED).max(1);
        // Another lattice in every frame.
        let first = self.frames.len() * 7 % step;
        self.sampled.extend(pixels.iter().skip(first).step_by(step).flat_map(|&[r, g, b]| [r, g, b, 255]));
        self.frames.push(png.to_path_buf());
    }

    pub fn finish(self) -> Result<(), String> {
        let colors = Colors::of(&self.sampled);
        let file = BufWriter::new(File::create(&self.path).map_err(|error| error.to_string())?);
        let failed = |error: gif::EncodingError| error.to_string();
        let size = self.head.size.map(|side| side as usize);
        let [width, height] = self.head.size.map(|side| u16::try_from(side).unwrap_or(u16::MAX));
        let mut encoder = Encoder::new(file, width, height, &colors.palette).map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        encoder.write_raw_extension(COMMENT, &[self.head.comment().as_bytes()]).map_err(failed)?;
        let mut colors = colors;
        let mut before: Vec<u8> = Vec::new();
        for (i, png) in self.frames.iter().enumerate() {
            let codes = read_png(png)?;
            let now: Vec<u8> = codes.as_chunks::<3>().0.iter().map(|&rgb| colors.nearest(rgb)).collect();
            let mut frame = changed(&before, &now, size);
            frame.delay = delay(self.head.rate, i as u64);
            encoder.write_frame(&frame).map_err(failed)?;
            before = now;
        }
        let mut file = encoder.into_inner().map_err(|error| error.to_string())?;
        std::io::Write::flush(&mut file).map_err(|error| error.to_string())
    }
}

/// A palette, and which of its colours is the nearest to any.
struct Colors {
    palette: Vec<u8>,
    // By six bits a channel; `NONE` where nobody asked yet.
    found: Vec<u16>,
}

const NONE: u16 = u16::MAX;

impl Colors {
    fn of(sampled: &[u8]) -> Colors {
        let mut palette = NeuQuant::new(1, COLORS, sampled).color_map_rgb();
        palette.truncate(3 * COLORS);
        // The one for what stays.
        palette.resize(3 * (COLORS + 1), 0);
        Colors { palette, found: vec![NONE; 1 << 18] }
    }

    fn nearest(&mut self, rgb: [u8; 3]) -> u8 {
        let cell = rgb.into_iter().fold(0, |cell, code| cell << 6 | usize::from(code >> 2));
        if self.found[cell] == NONE {
            // Of the middle of the cell, so that no pixel depends on those before it.
            let middle = rgb.map(|code| i32::from(code & !3) + 2);
            let distance =
                |color: &[u8; 3]| -> i32 { color.iter().zip(middle).map(|(&a, b)| (i32::from(a) - b).pow(2)).sum() };
            let (colors, _) = self.palette[..3 * COLORS].as_chunks::<3>();
            let nearest = colors.iter().enumerate().min_by_key(|(_, color)| distance(color));
            self.found[cell] = nearest.map_or(0, |(i, _)| i as u16);
        }
        self.found[cell] as u8
    }
}

// What is another than `before`, which is empty for the first frame: the smallest rectangle, transparent where all stays.
fn changed(before: &[u8], now: &[u8], [width, height]: [usize; 2]) -> Frame<'static> {
    let same = |x: usize, y: usize| before.get(y * width + x) == now.get(y * width + x);
    let rows: Vec<usize> = (0..height).filter(|&y| (0..width).any(|x| !same(x, y))).collect();
    let columns: Vec<usize> = (0..width).filter(|&x| rows.iter().any(|&y| !same(x, y))).collect();
    // Where nothing changes one pixel is said to stay.
    let bounds = |list: &[usize]| match list {
        [first, .., last] => (*first, last + 1),
        [only] => (*only, only + 1),
        [] => (0, 1),
    };
    let ((top, bottom), (left, right)) = (bounds(&rows), bounds(&columns));
    let pixel = |x: usize, y: usize| if same(x, y) { STAYS } else { now[y * width + x] };
    let buffer: Vec<u8> = (top..bottom).flat_map(|y| (left..right).map(move |x| pixel(x, y))).collect();
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left) as u16,
        height: (bottom - top) as u16,
        dispose: DisposalMethod::Keep,
        transparent: (!before.is_empty()).then_some(STAYS),
        buffer: Cow::Owned(buffer),
        ..Frame::default()
    }
}

/// How long frame `i` lasts, in hundredths of a second: from its time to the next one's, both rounded, so that the whole
/// film lasts as long as it should.
fn delay(rate: Rate, i: u64) -> u16 {
    let (frames, seconds) = (u128::from(rate.frames), u128::from(rate.seconds));
    let time = |i: u64| (200 * u128::from(i) * seconds + frames) / (2 * frames);
    u16::try_from(time(i + 1) - time(i)).unwrap_or(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_add_up() {
        for (frames, seconds, first) in [
            (24, 1, vec![4, 4, 5, 4, 4, 4]),
            (25, 1, vec![4, 4]),
            (30, 1, vec![3, 4, 3]),
            (1, 10, vec![1000]),
            (50, 1, vec![2, 2]),
        ] {
            let rate = Rate { frames, seconds };
            let got: Vec<u16> = (0..first.len() as u64).map(|i| delay(rate, i)).collect();
            assert_eq!(got, first, "{frames}/{seconds}");
            let sum: u64 = (0..u64::from(frames) * 8).map(|i| u64::from(delay(rate, i))).sum();
            assert_eq!(sum, 800 * u64::from(seconds), "{frames}/{seconds}");
        }
        assert_eq!(delay(Rate { frames: 1, seconds: 1_000_000 }, 0), u16::MAX);
    }

    #[test]
    fn only_what_changes_is_written() {
        let size = [4, 3];
        let before = [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1];
        let now = [1, 1, 1, 1, 1, 2, 1, 1, 1, 1, 3, 1];
        let frame = changed(&before, &now, size);
        assert_eq!((frame.left, frame.top, frame.width, frame.height), (1, 1, 2, 2));
        assert_eq!(*frame.buffer, [2, STAYS, STAYS, 3]);
        let frame = changed(&now, &now, size);
        assert_eq!((frame.width, frame.height, frame.transparent), (1, 1, Some(STAYS)));
        assert_eq!(*frame.buffer, [STAYS]);
        let frame = changed(&[], &now, size);
        assert_eq!((frame.width, frame.height, frame.transparent), (4, 3, None));
        assert_eq!(*frame.buffer, now);
    }

    #[test]
    fn near_colors() {
        let sampled: Vec<u8> =
            (0..4096).flat_map(|i| if i % 2 == 0 { [200, 10, 10, 255] } else { [10, 10, 200, 255] }).collect();
        let mut colors = Colors::of(&sampled);
        assert_eq!(colors.palette.len(), 768);
        for rgb in [[200, 10, 10], [10, 10, 200]] {
            let i = 3 * usize::from(colors.nearest(rgb));
            let got = &colors.palette[i..i + 3];
            assert!(got.iter().zip(rgb).all(|(a, b)| a.abs_diff(b) < 12), "{got:?} for {rgb:?}");
        }
    }
}
