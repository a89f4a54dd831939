//! How long reloads take, from the first word of a change to the first new pixel; one line of JSON each.

use std::time::{Duration, Instant};

use serde::Serialize;

use super::work::Making;

/// One reload.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reload {
    /// Until the text was read and understood, in milliseconds.
    pub reload_ms: f64,
    /// Until the first pixel of it was shown, in milliseconds; none if there was none: an error, or a newer text.
    pub first_pixel_ms: Option<f64>,
    /// Errors found.
    pub errors: usize,
    /// What of the picture had to be made anew; none where there was none.
    pub rebuilt: Option<Vec<&'static str>>,
    /// How long each step took.
    pub stages: Stages,
}

/// How long the steps of a reload took, in milliseconds; none of what did not come to pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Stages {
    /// To parse the scene's own text.
    pub parse_ms: Option<f64>,
    /// To evaluate it with all that it uses.
    pub evaluate_ms: Option<f64>,
    /// To evaluate the scene at the playhead.
    pub sample_ms: Option<f64>,
    /// To make the renderer's arrays.
    pub build_ms: Option<f64>,
    /// To trace the first picture.
    pub trace_ms: Option<f64>,
}

/// The reloads so far.
#[derive(Default)]
pub struct Reloads {
    /// How long the last one took.
    pub last: Option<Duration>,
    /// What it made anew, in words.
    pub anew: String,
    /// How long each step of it took, in words.
    pub steps: String,
    pending: Option<Pending>,
}

struct Pending {
    load: u64,
    since: Instant,
    took: Duration,
    stages: Stages,
    rebuilt: Option<Vec<&'static str>>,
}

impl Pending {
    fn told(self, first_pixel_ms: Option<f64>, errors: usize) -> Reload {
        let Pending { took, stages, rebuilt, .. } = self;
        Reload { reload_ms: milliseconds(took), first_pixel_ms, errors, rebuilt, stages }
    }
}

impl Reloads {
    /// A text was read, `took` after `since`; `times`: to parse and to evaluate it. `load`: the scene that came of it, none
    /// where there are `errors`. Gives what is known of this reload and of the one before it, as far as they will not be
    /// known better.
    pub fn read(
        &mut self,
        since: Instant,
        took: Duration,
        times: Option<[Duration; 2]>,
        load: Option<u64>,
        errors: usize,
    ) -> Vec<Reload> {
        self.last = Some(took);
        (self.anew, self.steps) = Default::default();
        let mut lines: Vec<Reload> = self.give_up(0).into_iter().collect();
        let [parse_ms, evaluate_ms] = [0, 1].map(|i| times.map(|times| milliseconds(times[i])));
        let stages = Stages { parse_ms, evaluate_ms, ..Stages::default() };
        let pending = Pending { load: load.unwrap_or_default(), since, took, stages, rebuilt: None };
        match load {
            Some(_) => self.pending = Some(pending),
            None => lines.push(pending.told(None, errors)),
        }
        lines
    }

    /// A picture of `load` came, in this way.
    pub fn made(&mut self, load: u64, making: &Making) {
        let Some(pending) = self.pending.as_mut().filter(|pending| pending.load <= load && pending.rebuilt.is_none())
        else {
            return;
        };
        let rebuilt = making.anew.names();
        let times = [making.sample, making.build, making.trace].map(|time| Some(milliseconds(time)));
        [pending.stages.sample_ms, pending.stages.build_ms, pending.stages.trace_ms] = times;
        self.anew = if rebuilt.is_empty() { "nothing".into() } else { rebuilt.join(", ") };
        pending.rebuilt = Some(rebuilt);
        let stages = &pending.stages;
        let named = [
            ("parse", stages.parse_ms),
            ("evaluate", stages.evaluate_ms),
            ("sample", stages.sample_ms),
            ("build", stages.build_ms),
            ("trace", stages.trace_ms),
        ];
        let words = named.into_iter().filter_map(|(name, ms)| Some(format!("{name} {:.1} ms", ms?)));
        self.steps = words.collect::<Vec<_>>().join("\n");
    }

    /// A picture of `load` is on the screen.
    pub fn pixel(&mut self, load: u64, now: Instant) -> Option<Reload> {
        let pending = self.pending.take_if(|pending| pending.load <= load)?;
        let first_pixel_ms = Some(milliseconds(now.duration_since(pending.since)));
        Some(pending.told(first_pixel_ms, 0))
    }

    /// There will be no picture, for `errors` reasons.
    pub fn give_up(&mut self, errors: usize) -> Option<Reload> {
        Some(self.pending.take()?.told(None, errors))
    }
}

/// Rounded to a hundredth.
fn milliseconds(time: Duration) -> f64 {
    (time.as_secs_f64() * 1e5).round() / 100.0
}

#[cfg(test)]
mod tests {
    use kinora_renderer::Changes;

    use super::*;

    #[test]
    fn every_reload_gives_one_line() {
        let (start, ms) = (Instant::now(), Duration::from_millis);
        let line = |reload_ms, first_pixel_ms, errors| Reload {
            reload_ms,
            first_pixel_ms,
            errors,
            rebuilt: None,
            stages: Stages::default(),
        };
        let mut reloads = Reloads::default();
        assert_eq!(reloads.pixel(1, start), None, "the first picture is no reload");
        assert_eq!(reloads.read(start, ms(30), None, Some(2), 0), []);
        assert_eq!(reloads.pixel(1, start + ms(40)), None, "still the picture before");
        assert_eq!(reloads.pixel(2, start + ms(50)), Some(line(30.0, Some(50.0), 0)));
        assert_eq!(reloads.pixel(2, start + ms(60)), None);
        assert_eq!(reloads.read(start, ms(20), None, None, 3), [line(20.0, None, 3)]);
        assert_eq!(reloads.read(start, ms(30), None, Some(3), 0), []);
        assert_eq!(reloads.read(start, ms(31), None, Some(4), 0), [line(30.0, None, 0)], "overtaken");
        assert_eq!(reloads.give_up(1), Some(line(31.0, None, 1)));
    }

    #[test]
    fn a_line_is_json() {
        let (start, ms) = (Instant::now(), Duration::from_millis);
        let mut reloads = Reloads::default();
        let none = r#""rebuilt":null,"stages":{"parse_ms":null,"evaluate_ms":null,"sample_ms":null,"build_ms":null,"trace_ms":null}"#;
        let failed = reloads.read(start, ms(2), None, None, 2);
        let text = serde_json::to_string(&failed[0]).unwrap();
        assert_eq!(text, format!(r#"{{"reload_ms":2.0,"first_pixel_ms":null,"errors":2,{none}}}"#));
        reloads.read(start, ms(9), Some([ms(1), ms(2)]), Some(1), 0);
        let anew = Changes { materials: true, camera: true, ..Changes::default() };
        let making = Making { anew, sample: ms(3), build: ms(4), trace: ms(5) };
        reloads.made(0, &making);
        reloads.made(1, &making);
        reloads.made(1, &Making::default());
        let told = reloads.pixel(1, start + ms(12)).unwrap();
        let stages = r#"{"parse_ms":1.0,"evaluate_ms":2.0,"sample_ms":3.0,"build_ms":4.0,"trace_ms":5.0}"#;
        let expected = format!(
            r#"{{"reload_ms":9.0,"first_pixel_ms":12.0,"errors":0,"rebuilt":["materials","camera"],"stages":{stages}}}"#
        );
        assert_eq!(serde_json::to_string(&told).unwrap(), expected);
        assert_eq!(reloads.anew, "materials, camera");
    }
}
