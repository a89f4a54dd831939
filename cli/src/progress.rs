//! Progress on a terminal: how much is done, how fast, how long it will take. Nobody else sees it.

use std::cell::Cell;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::terminal;

/// Steps of a picture's bar: finer than any terminal is wide.
const STEPS: u64 = 10_000;

/// The lines that show the work, or nothing.
pub struct Progress(Option<Lines>);

struct Lines {
    frames: Option<ProgressBar>,
    picture: ProgressBar,
    samples: Cell<u32>,
    pixels: Cell<u64>,
    start: Cell<Instant>,
}

impl Progress {
    /// Lines on stderr where someone watches: one for the samples, above it one for the frames if there are several.
    pub fn new(quiet: bool, frames: Option<usize>) -> Progress {
        if quiet || !terminal::watched() {
            return Progress(None);
        }
        let lines = MultiProgress::with_draw_target(ProgressDrawTarget::stderr_with_hz(10));
        let style = |template: &str| {
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            style.progress_chars("━╸ ")
        };
        let frames = frames.map(|count| {
            let bar = lines.add(ProgressBar::new(count as u64));
            bar.set_style(style("frames  {bar:30} {pos}/{len} · {eta} left"));
            bar
        });
        let picture = lines.add(ProgressBar::new(STEPS));
        picture.set_style(style("samples {bar:30} {msg} · {eta} left"));
        let (samples, pixels, start) = (Cell::new(0), Cell::new(0), Cell::new(Instant::now()));
        Progress(Some(Lines { frames, picture, samples, pixels, start }))
    }

    /// A picture begins.
    pub fn begin(&self, size: [u32; 2], samples: u32) {
        let Some(lines) = &self.0 else { return };
        lines.samples.set(samples);
        lines.pixels.set(size.map(u64::from).iter().product());
        lines.start.set(Instant::now());
        lines.picture.reset();
        self.picture(0.0);
        if let Some(frames) = &lines.frames {
            frames.tick();
        }
    }

    /// `done` of the picture, in 0..=1.
    pub fn picture(&self, done: f64) {
        let Some(Lines { picture, samples, pixels, start, .. }) = &self.0 else { return };
        let all = f64::from(samples.get());
        let seconds = start.get().elapsed().max(Duration::from_millis(1)).as_secs_f64();
        let rate = done * all * pixels.get() as f64 / seconds / 1e6;
        picture.set_position((done * STEPS as f64) as u64);
        picture.set_message(format!("{}/{all} · {rate:.2} Msamples/s", (done * all) as u32));
    }

    /// One frame more is done or skipped.
    pub fn frame(&self) {
        if let Some(frames) = self.0.as_ref().and_then(|lines| lines.frames.as_ref()) {
            frames.inc(1);
        }
    }

    /// Prints something without breaking the lines.
    pub fn beside(&self, print: impl FnOnce()) {
        match &self.0 {
            Some(lines) => lines.picture.suspend(print),
            None => print(),
        }
    }

    /// Says what became of it, to those who watched.
    pub fn end(self, summary: impl FnOnce() -> String) {
        let Some(lines) = self.0 else { return };
        lines.picture.finish_and_clear();
        if let Some(frames) = lines.frames {
            frames.finish_and_clear();
        }
        terminal::err(&format!("{}\n", summary()));
    }
}
