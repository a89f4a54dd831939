//! How long reloads take, from the first word of a change to the first new pixel; one line of JSON each.

use std::time::{Duration, Instant};

use serde::Serialize;

/// One reload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Reload {
    /// Until the text was read and understood, in milliseconds.
    pub reload_ms: f64,
    /// Until the first pixel of it was shown, in milliseconds; none if there was none: an error, or a newer text.
    pub first_pixel_ms: Option<f64>,
    /// Errors found.
    pub errors: usize,
}

/// The reloads so far.
#[derive(Default)]
pub struct Reloads {
    /// The last one.
    pub last: Option<Duration>,
    pending: Option<(u64, Instant, Duration)>,
}

impl Reloads {
    /// A text was read, `took` after `since`. `load`: the scene that came of it, none where there are `errors`. Gives
    /// what is known of this reload and of the one before it, as far as they will not be known better.
    pub fn read(&mut self, since: Instant, took: Duration, load: Option<u64>, errors: usize) -> Vec<Reload> {
        self.last = Some(took);
        let mut lines: Vec<Reload> = self.give_up(0).into_iter().collect();
        match load {
            Some(load) => self.pending = Some((load, since, took)),
            None => lines.push(Reload { reload_ms: milliseconds(took), first_pixel_ms: None, errors }),
        }
        lines
    }

    /// A picture of `load` is on the screen.
    pub fn pixel(&mut self, load: u64, now: Instant) -> Option<Reload> {
        let (_, since, took) = self.pending.take_if(|(pending, ..)| *pending <= load)?;
        let first_pixel_ms = Some(milliseconds(now.duration_since(since)));
        Some(Reload { reload_ms: milliseconds(took), first_pixel_ms, errors: 0 })
    }

    /// There will be no picture, for `errors` reasons.
    pub fn give_up(&mut self, errors: usize) -> Option<Reload> {
        let (_, _, took) = self.pending.take()?;
        Some(Reload { reload_ms: milliseconds(took), first_pixel_ms: None, errors })
    }
}

/// Rounded to a hundredth.
fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e5).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reload_gives_one_line() {
        let (start, ms) = (Instant::now(), Duration::from_millis);
        let line = |reload_ms, first_pixel_ms, errors| Reload { reload_ms, first_pixel_ms, errors };
        let mut reloads = Reloads::default();
        assert_eq!(reloads.pixel(1, start), None, "the first picture is no reload");
        assert_eq!(reloads.read(start, ms(30), Some(2), 0), []);
        assert_eq!(reloads.pixel(1, start + ms(40)), None, "still the picture before");
        assert_eq!(reloads.pixel(2, start + ms(50)), Some(line(30.0, Some(50.0), 0)));
        assert_eq!(reloads.pixel(2, start + ms(60)), None);
        assert_eq!(reloads.read(start, ms(20), None, 3), [line(20.0, None, 3)]);
        assert_eq!(reloads.read(start, ms(30), Some(3), 0), []);
        assert_eq!(reloads.read(start, ms(31), Some(4), 0), [line(30.0, None, 0)], "overtaken");
        assert_eq!(reloads.give_up(1), Some(line(31.0, None, 1)));
    }

    #[test]
    fn a_line_is_json() {
        let reload = Reload { reload_ms: 1.5, first_pixel_ms: None, errors: 2 };
        let text = serde_json::to_string(&reload).unwrap();
        assert_eq!(text, r#"{"reload_ms":1.5,"first_pixel_ms":null,"errors":2}"#);
    }
}
