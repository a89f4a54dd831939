//! A photograph of the window, for documentation and tests.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::{Duration, Instant};

use kinora_renderer::Image;

use super::shown::Shown;
use crate::encode::Target;

/// When a photograph is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum After {
    /// Once the picture has so many samples, or all it will have.
    Samples(u32),
    /// So long after the start.
    Time(Duration),
}

impl FromStr for After {
    type Err = String;

    fn from_str(text: &str) -> Result<After, String> {
        let seconds = |number: &str, scale: f64| {
            let seconds = number.parse::<f64>().ok()? * scale;
            Duration::try_from_secs_f64(seconds).ok().map(After::Time)
        };
        let after = match (text.strip_suffix("ms"), text.strip_suffix('s')) {
            (Some(number), _) => seconds(number, 1e-3),
            (_, Some(number)) => seconds(number, 1.0),
            _ => text.parse().ok().map(After::Samples),
        };
        after.ok_or_else(|| "write a number of samples, such as 16, or a time, such as 2.5s".into())
    }
}

/// A photograph wanted.
pub struct Photo {
    /// Where it goes.
    pub path: PathBuf,
    /// When.
    pub after: After,
    /// Whether the window is closed then.
    pub last: bool,
}

impl Photo {
    /// Whether it is time, `running` after the start. `hopeless`: there is no scene and the text is at fault.
    pub fn due(&self, shown: Option<&Shown>, running: Duration, hopeless: bool) -> bool {
        match self.after {
            After::Samples(samples) => shown.map_or(hopeless, |shown| shown.has(samples)),
            After::Time(time) => running >= time,
        }
    }

    /// When to look whether it is time, for a program that began at `start`.
    pub fn at(&self, start: Instant) -> Option<Instant> {
        match self.after {
            After::Samples(_) => None,
            After::Time(time) => start.checked_add(time),
        }
    }

    /// Writes it.
    ///
    /// # Errors
    /// The disk does not take it.
    pub fn save(&self, image: &Image) -> Result<(), String> {
        let bytes = png(image).map_err(|error| format!("cannot make a PNG: {error}"))?;
        Target::new(&self.path)?.write(&bytes)
    }
}

fn png(image: &Image) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.size[0], image.size[1]);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&image.codes8())?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_or_a_time() {
        let ms = |ms| Some(After::Time(Duration::from_millis(ms)));
        for (text, expected) in [
            ("16", Some(After::Samples(16))),
            ("2.5s", ms(2500)),
            ("40ms", ms(40)),
            ("-1s", None),
            ("1e999s", None),
            ("soon", None),
            ("", None),
        ] {
            assert_eq!(After::from_str(text).ok(), expected, "{text}");
        }
    }
}
