//! Progress on a terminal: how much is done, how fast, how long it will take. Nobody else sees it.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

use indicatif::{HumanDuration, MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::terminal;

/// Steps of a bar: finer than any terminal is wide.
const STEPS: u64 = 10_000;
/// So many frames tell how long the next ones take.
const RECENT: usize = 12;
/// A share of a picture that says something about the rest.
const TELLING: f64 = 0.02;

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Told {
    /// As lines on stderr where someone watches
    #[default]
    Auto,
    /// As lines of JSON on stdout, for programs: `progress` (0 to 1), and of films `frame` (those done) and `frames`
    Json,
}

/// Lines of JSON are not told more often.
const TELL_EVERY: Duration = Duration::from_millis(100);

/// The lines that show the work, or nothing.
pub enum Progress {
    /// To nobody.
    Silent,
    /// To people.
    Lines(Box<Lines>),
    /// To programs.
    Json(Json),
}

/// What was told to a program, and when.
pub struct Json {
    frames: Option<usize>,
    done: Cell<usize>,
    told: Cell<Option<Instant>>,
}

/// A line for a program.
#[derive(serde::Serialize)]
struct Line {
    progress: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    frames: Option<usize>,
}

impl Json {
    /// `done`: of the picture in work. What is `due` is told however short ago the last line was.
    fn tell(&self, done: f64, due: bool) {
        if !due && self.told.get().is_some_and(|told| told.elapsed() < TELL_EVERY) {
            return;
        }
        self.told.set(Some(Instant::now()));
        let whole = self.frames.map_or(1.0, |frames| frames.max(1) as f64);
        let progress = ((self.done.get() as f64 + done) / whole).clamp(0.0, 1.0);
        let line = Line { progress, frame: self.frames.map(|_| self.done.get()), frames: self.frames };
        // Whoever listened and is gone is no reason to stop.
        let _ = terminal::out(&(serde_json::to_string(&line).unwrap_or_default() + "\n"));
    }
}

/// Bars and what they show.
pub struct Lines {
    whole: Option<Whole>,
    picture: ProgressBar,
    samples: Cell<u32>,
    pixels: Cell<u64>,
    start: Cell<Instant>,
}

struct Whole {
    bar: ProgressBar,
    count: usize,
    done: Cell<usize>,
    pace: RefCell<Pace>,
}

impl Progress {
    /// Lines on stderr where someone watches: one for the samples, above it one for the frames if there are several.
    pub fn new(quiet: bool, told: Told, frames: Option<usize>) -> Progress {
        if told == Told::Json {
            return Progress::Json(Json { frames, done: Cell::new(0), told: Cell::new(None) });
        }
        if quiet || !terminal::watched() {
            return Progress::Silent;
        }
        let lines = MultiProgress::with_draw_target(ProgressDrawTarget::stderr_with_hz(10));
        let bar = |template: &str| {
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = lines.add(ProgressBar::new(STEPS));
            bar.set_style(style.progress_chars("━╸ "));
            bar
        };
        let whole = frames.map(|count| Whole {
            bar: bar("frames  {bar:30} {msg}"),
            count,
            done: Cell::new(0),
            pace: RefCell::default(),
        });
        let picture = bar("samples {bar:30} {msg}");
        let (samples, pixels, start) = (Cell::new(0), Cell::new(0), Cell::new(Instant::now()));
        Progress::Lines(Box::new(Lines { whole, picture, samples, pixels, start }))
    }

    fn lines(&self) -> Option<&Lines> {
        match self {
            Progress::Lines(lines) => Some(lines),
            Progress::Silent | Progress::Json(_) => None,
        }
    }

    /// A picture begins.
    pub fn begin(&self, size: [u32; 2], samples: u32) {
        if let Progress::Json(json) = self {
            json.tell(0.0, true);
        }
        let Some(lines) = self.lines() else { return };
        lines.samples.set(samples);
        lines.pixels.set(size.map(u64::from).iter().product());
        lines.start.set(Instant::now());
        lines.picture.reset();
        self.picture(0.0);
    }

    /// `done` of the picture, in 0..=1.
    pub fn picture(&self, done: f64) {
        if let Progress::Json(json) = self {
            json.tell(done, false);
        }
        let Some(Lines { whole, picture, samples, pixels, start }) = self.lines() else { return };
        let all = f64::from(samples.get());
        let taken = start.get().elapsed();
        let seconds = taken.max(Duration::from_millis(1)).as_secs_f64();
        let rate = done * all * pixels.get() as f64 / seconds / 1e6;
        picture.set_position((done * STEPS as f64) as u64);
        let left = if done >= TELLING { time_left(seconds / done * (1.0 - done)) } else { String::new() };
        picture.set_message(format!("{}/{all} · {rate:.2} Msamples/s{left}", (done * all) as u32));
        if let Some(whole) = whole {
            whole.show(done, seconds);
        }
    }

    /// One frame more is done.
    pub fn rendered(&self) {
        self.count_for_program();
        let Some(Lines { whole: Some(whole), start, .. }) = self.lines() else { return };
        whole.pace.borrow_mut().took(start.get().elapsed().as_secs_f64());
        whole.count_one();
    }

    /// One frame more needs no work.
    pub fn skipped(&self) {
        self.count_for_program();
        if let Some(Lines { whole: Some(whole), .. }) = self.lines() {
            whole.count_one();
        }
    }

    fn count_for_program(&self) {
        if let Progress::Json(json) = self {
            json.done.set(json.done.get() + 1);
            json.tell(0.0, true);
        }
    }

    /// All frames are there, and something else goes on.
    pub fn say(&self, what: &str) {
        let Some(lines) = self.lines() else { return };
        lines.picture.set_message(what.to_string());
        lines.picture.tick();
    }

    /// Prints something without breaking the lines.
    pub fn beside(&self, print: impl FnOnce()) {
        match self.lines() {
            Some(lines) => lines.picture.suspend(print),
            None => print(),
        }
    }

    /// Says what became of it, to those who watched; nothing if that is empty.
    pub fn end(self, summary: impl FnOnce() -> String) {
        if let Progress::Json(json) = &self {
            json.tell(if json.frames.is_some() { 0.0 } else { 1.0 }, true);
        }
        let Progress::Lines(lines) = self else { return };
        lines.picture.finish_and_clear();
        if let Some(whole) = lines.whole {
            whole.bar.finish_and_clear();
        }
        let text = summary();
        if !text.is_empty() {
            terminal::err(&format!("{text}\n"));
        }
    }
}

impl Whole {
    fn count_one(&self) {
        self.done.set(self.done.get() + 1);
        self.show(0.0, 0.0);
    }

    // With `done` of the picture in work, for `seconds`.
    fn show(&self, done: f64, seconds: f64) {
        let (count, ended) = (self.count, self.done.get());
        let share = (ended as f64 + done) / count.max(1) as f64;
        self.bar.set_position((share * STEPS as f64) as u64);
        let left = self.pace.borrow().left(done, seconds, count.saturating_sub(ended)).map(time_left);
        self.bar.set_message(format!("{ended}/{count}{}", left.unwrap_or_default()));
    }
}

fn time_left(seconds: f64) -> String {
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) => format!(" · {:#} left", HumanDuration(time)),
        Err(_) => String::new(),
    }
}

/// How long frames took that were rendered. Those that were there already took no time, which says nothing of the others.
#[derive(Default)]
struct Pace(VecDeque<f64>);

impl Pace {
    fn took(&mut self, seconds: f64) {
        if self.0.len() == RECENT {
            self.0.pop_front();
        }
        self.0.push_back(seconds);
    }

    /// How long `frames` more will take, of which the first is in work: `done` of it took `seconds`. `None` if nothing says
    /// so yet.
    fn left(&self, done: f64, seconds: f64, frames: usize) -> Option<f64> {
        let usual = (!self.0.is_empty()).then(|| self.0.iter().sum::<f64>() / self.0.len() as f64);
        let this = (done >= TELLING).then(|| seconds / done).or(usual)?;
        let others = usual.unwrap_or(this) * frames.saturating_sub(1) as f64;
        Some(if frames == 0 { 0.0 } else { (this - seconds).max(0.0) + others })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_follows_the_frames_that_were_rendered() {
        let mut pace = Pace::default();
        assert_eq!(pace.left(0.0, 0.0, 10), None);
        // A quarter of the first frame took 2 s: 6 s for the rest of it, 8 s for each of the nine others.
        assert_eq!(pace.left(0.25, 2.0, 10), Some(6.0 + 72.0));
        pace.took(10.0);
        pace.took(20.0);
        assert_eq!(pace.left(0.0, 0.0, 4), Some(60.0));
        assert_eq!(pace.left(0.5, 15.0, 4), Some(15.0 + 45.0));
        assert_eq!(pace.left(0.0, 0.0, 0), Some(0.0));
        for _ in 0..RECENT {
            pace.took(1.0);
        }
        assert_eq!(pace.left(0.0, 0.0, 4), Some(4.0), "what was long ago is forgotten");
    }
}
