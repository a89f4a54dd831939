//! The panel that makes pictures and films: it runs the same program as the command line, beside the viewer.

use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use egui::{Button, DragValue, Grid, Label, ProgressBar, RichText, ScrollArea, TextEdit, Ui};
use kinora_scene::Scene;
use serde::Deserialize;

use crate::flags::BackendName;
use crate::session::Changes;
use crate::view::wish::Desired;

/// How often progress is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// What is asked to stop and does not is ended after so long.
const PATIENCE: Duration = Duration::from_secs(5);
/// More of what went wrong is not kept, in bytes.
const MOST_TEXT: usize = 1 << 16;

/// The panel.
pub struct Render {
    still: String,
    film: String,
    size: Option<[u32; 2]>,
    samples: Option<u32>,
    frames: String,
    /// What the names are made of.
    scene: Option<PathBuf>,
    job: Option<Job>,
    ended: Option<Ended>,
}

impl Default for Render {
    fn default() -> Self {
        let empty = String::new;
        Self {
            still: empty(),
            film: empty(),
            size: None,
            samples: None,
            frames: empty(),
            scene: None,
            job: None,
            ended: None,
        }
    }
}

/// What is at work.
struct Job {
    output: PathBuf,
    child: Child,
    start: Instant,
    told: Arc<Mutex<Told>>,
    stopped: Option<Instant>,
}

/// What it tells.
#[derive(Default)]
struct Told {
    line: Line,
    /// What it wrote to stderr.
    text: String,
}

/// A line of progress, as `--progress json` tells it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
struct Line {
    progress: f32,
    #[serde(default)]
    frame: Option<u64>,
    #[serde(default)]
    frames: Option<u64>,
}

/// What became of the last one.
struct Ended {
    good: bool,
    text: String,
}

/// What is to be made.
#[derive(Clone, Debug, PartialEq)]
pub struct Order<'a> {
    /// The scene.
    pub scene: &'a Path,
    /// What is changed in it.
    pub changes: Changes,
    /// Where it goes.
    pub output: &'a str,
    /// One frame of that number, or a film of these.
    pub frames: Frames<'a>,
    /// What does the work.
    pub backend: BackendName,
}

/// Which frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frames<'a> {
    /// One.
    Still(i64),
    /// These, as `--frames` takes them; empty: all.
    Film(&'a str),
}

impl Order<'_> {
    /// The arguments of the program that makes it.
    pub fn arguments(&self) -> Vec<OsString> {
        let mut words: Vec<OsString> = Vec::new();
        let word = |words: &mut Vec<OsString>, text: String| words.push(text.into());
        word(&mut words, "--color=never".into());
        match self.frames {
            Frames::Still(frame) => {
                word(&mut words, "render".into());
                word(&mut words, format!("--frame={frame}"));
            }
            Frames::Film(list) => {
                word(&mut words, "animate".into());
                if !list.trim().is_empty() {
                    word(&mut words, format!("--frames={}", list.trim()));
                }
            }
        }
        let Changes {
            params,
            sets,
            size,
            samples,
            seed,
            camera,
            frozen_bake,
            no_assets: _,
            levels: _,
            kept: _,
            open: _,
        } = &self.changes;
        words.extend(params.iter().map(|(name, text)| format!("-D{name}={text}").into()));
        words.extend(sets.iter().map(|(name, text)| format!("--set={name}={text}").into()));
        words.extend(size.map(|[width, height]| format!("--size={width}x{height}").into()));
        words.extend(samples.map(|samples| format!("--samples={samples}").into()));
        words.extend(seed.map(|seed| format!("--seed={seed}").into()));
        words.extend(camera.as_ref().map(|camera| format!("--camera={camera}").into()));
        words.extend(frozen_bake.then(|| "--frozen-bake".into()));
        let backend = self.backend.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned());
        word(&mut words, format!("--backend={backend}"));
        word(&mut words, "--progress=json".into());
        let mut output = OsString::from("--output=");
        output.push(self.output);
        words.push(output);
        // A name may begin with a hyphen.
        words.push("--".into());
        words.push(self.scene.into());
        words
    }
}

impl Render {
    /// Whether something is at work.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// Looks what has become of the work, and when to look again.
    pub fn poll(&mut self) -> Option<Duration> {
        let job = self.job.as_mut()?;
        if job.stopped.is_some_and(|since| since.elapsed() > PATIENCE) {
            let _ = job.child.kill();
        }
        let status = match job.child.try_wait() {
            Ok(None) => return Some(LOOK_EVERY),
            Ok(Some(status)) => status.code(),
            Err(_) => None,
        };
        let job = self.job.take()?;
        let seconds = job.start.elapsed().as_secs_f64();
        // What was still in the pipe when it ended.
        std::thread::sleep(Duration::from_millis(20));
        let said = job.lock().text.trim().to_owned();
        let output = job.output.display();
        let (good, mut text) = match (status, job.stopped.is_some()) {
            (Some(0), _) => (true, format!("{output}: {seconds:.1} s")),
            (_, true) => (true, format!("{output}: stopped")),
            (Some(code), _) => (false, format!("{output}: failed with code {code}")),
            (None, _) => (false, format!("{output}: it was ended")),
        };
        if !said.is_empty() {
            text = format!("{text}\n\n{said}");
        }
        self.ended = Some(Ended { good, text });
        None
    }

    /// Starts what is ordered.
    fn begin(&mut self, order: &Order<'_>) {
        let program = std::env::current_exe().map_err(|error| error.to_string());
        let job = program.and_then(|program| Job::spawn(&program, order));
        match job {
            Ok(job) => (self.job, self.ended) = (Some(job), None),
            Err(why) => {
                self.ended = Some(Ended { good: false, text: format!("cannot start the program that renders: {why}") })
            }
        }
    }

    /// Draws the panel. `frame`: at the playhead; `moved`: whether the camera was moved by hand.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        scene: &Scene,
        frame: i64,
        moved: bool,
        desired: &Desired,
        backend: BackendName,
    ) {
        let Some(path) = &desired.path else { return };
        if self.scene.as_ref() != Some(path) {
            self.scene = Some(path.clone());
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            (self.still, self.film) = (format!("{stem}.png"), format!("out/{stem}.####.png"));
        }
        let busy = self.is_busy();
        let changes = Changes {
            size: self.size.or(desired.changes.size),
            samples: self.samples.or(desired.changes.samples),
            ..desired.all_changes()
        };
        // Whether it is a film.
        let mut begin = None;
        ui.add_enabled_ui(!busy, |ui| {
            Grid::new("quality").num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| self.quality(ui, scene));
            ui.separator();
            ui.strong("Picture");
            name(ui, &mut self.still, ".png, .jpg, .exr or .hdr");
            if ui.button(format!("Render frame {frame}")).clicked() {
                begin = Some(false);
            }
            let frames = scene.clock.frame_count();
            if frames > 1 {
                ui.separator();
                ui.strong("Film");
                name(ui, &mut self.film, "pictures with #### for the number, or one .mp4, .webm, .apng or .gif");
                ui.horizontal(|ui| {
                    ui.label("Frames");
                    let hint = format!("all: 0..{frames}");
                    ui.add(TextEdit::singleline(&mut self.frames).hint_text(hint).desired_width(f32::INFINITY))
                        .on_hover_text("0..96 (without 96), 1-96 (with it), 0..96:4, 7, or several with commas");
                });
                if ui.button("Render film").clicked() {
                    begin = Some(true);
                }
            }
        });
        if moved {
            ui.add_space(4.0);
            ui.label(RichText::new("What is rendered is the scene's own camera, not the view moved by hand. Copy that as text into the scene to keep it.").small().weak());
        }
        if let Some(film) = begin {
            let list = self.frames.clone();
            let (output, frames) = match film {
                true => (self.film.clone(), Frames::Film(&list)),
                false => (self.still.clone(), Frames::Still(frame)),
            };
            self.begin(&Order { scene: path, changes, output: output.trim(), frames, backend });
        }
        self.progress(ui);
    }

    fn quality(&mut self, ui: &mut Ui, scene: &Scene) {
        let [width, height] = self.size.unwrap_or(scene.render.resolution);
        ui.label("Size");
        ui.horizontal(|ui| {
            let mut size = [width, height];
            let [w, h] = &mut size;
            ui.add(DragValue::new(w).range(1..=16384));
            ui.label("×");
            ui.add(DragValue::new(h).range(1..=16384));
            if size != [width, height] {
                self.size = Some(size);
            }
            as_written(ui, &mut self.size);
        });
        ui.end_row();
        ui.label("Samples");
        ui.horizontal(|ui| {
            let now = self.samples.unwrap_or(scene.render.samples);
            let mut samples = now;
            ui.add(DragValue::new(&mut samples).range(1..=1_000_000));
            if samples != now {
                self.samples = Some(samples);
            }
            as_written(ui, &mut self.samples);
        });
        ui.end_row();
    }

    fn progress(&mut self, ui: &mut Ui) {
        if let Some(job) = &mut self.job {
            ui.separator();
            let Line { progress, frame, frames } = job.lock().line;
            let what = match (frame, frames) {
                (Some(frame), Some(frames)) => format!("{frame} of {frames} frames"),
                _ => format!("{:.0} %", progress * 100.0),
            };
            ui.add(Label::new(job.output.display().to_string()).truncate());
            ui.add(ProgressBar::new(progress.clamp(0.0, 1.0)).text(what));
            ui.horizontal(|ui| {
                let cancel = ui.add_enabled(job.stopped.is_none(), Button::new("Cancel"));
                if cancel.clicked() {
                    job.stop();
                }
                ui.label(RichText::new(format!("{:.0} s", job.start.elapsed().as_secs_f64())).weak());
            });
        } else if let Some(ended) = &self.ended {
            ui.separator();
            ScrollArea::vertical().max_height(ui.available_height().max(60.0)).show(ui, |ui| {
                let color = if ended.good { ui.visuals().text_color() } else { ui.visuals().error_fg_color };
                ui.add(Label::new(RichText::new(&ended.text).color(color)).wrap().selectable(true));
            });
        }
    }
}

fn name(ui: &mut Ui, name: &mut String, hint: &str) {
    ui.horizontal(|ui| {
        ui.label("Name");
        ui.add(TextEdit::singleline(name).desired_width(f32::INFINITY)).on_hover_text(format!(
            "{hint}; in {}",
            std::env::current_dir().map_or_else(|_| "the current folder".into(), |folder| folder.display().to_string())
        ));
    });
    if Path::new(name.trim()).is_file() {
        ui.label(
            RichText::new("This takes the place of a file that is there.").small().color(ui.visuals().warn_fg_color),
        );
    }
}

fn as_written<T>(ui: &mut Ui, value: &mut Option<T>) {
    if value.is_some() && ui.small_button("Reset").on_hover_text("As the text says").clicked() {
        *value = None;
    }
}

impl Job {
    fn spawn(program: &Path, order: &Order<'_>) -> Result<Job, String> {
        if order.output.is_empty() {
            return Err("the file has no name".into());
        }
        let output = PathBuf::from(order.output);
        if let Some(folder) = output.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            std::fs::create_dir_all(folder).map_err(|error| format!("cannot make `{}`: {error}", folder.display()))?;
        }
        let mut command = Command::new(program);
        command.args(order.arguments()).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| error.to_string())?;
        let told: Arc<Mutex<Told>> = Arc::default();
        if let Some(stdout) = child.stdout.take() {
            let told = told.clone();
            std::thread::spawn(move || {
                hear(stdout, |line| {
                    if let Ok(line) = serde_json::from_str(&line) {
                        lock(&told).line = line;
                    }
                })
            });
        }
        if let Some(stderr) = child.stderr.take() {
            let told = told.clone();
            std::thread::spawn(move || {
                hear(stderr, |line| {
                    let mut told = lock(&told);
                    if told.text.len() + line.len() < MOST_TEXT {
                        told.text += &(line + "\n");
                    }
                })
            });
        }
        Ok(Job { output, child, start: Instant::now(), told, stopped: None })
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Told> {
        lock(&self.told)
    }

    /// Asks it to stop, as Ctrl-C does: what is finished stays.
    fn stop(&mut self) {
        self.stopped = Some(Instant::now());
        #[cfg(unix)]
        {
            let id = i32::try_from(self.child.id()).ok().and_then(rustix::process::Pid::from_raw);
            if let Some(id) = id {
                // It may have ended just now.
                let _ = rustix::process::kill_process(id, rustix::process::Signal::INT);
            }
        }
        #[cfg(not(unix))]
        let _ = self.child.kill();
    }
}

/// A window that is closed leaves nothing behind that works.
impl Drop for Job {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn lock(told: &Mutex<Told>) -> std::sync::MutexGuard<'_, Told> {
    told.lock().unwrap_or_else(PoisonError::into_inner)
}

fn hear(pipe: impl Read, mut line: impl FnMut(String)) {
    for text in BufReader::new(pipe).lines().map_while(Result::ok) {
        line(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_a_command_line() {
        let changes = Changes {
            params: vec![("a".into(), "-1m".into())],
            sets: vec![("render.max_bounces".into(), "2".into())],
            size: Some([64, 32]),
            samples: Some(4),
            seed: Some(7),
            camera: Some("main".into()),
            frozen_bake: true,
            ..Changes::default()
        };
        let scene = Path::new("-s.kin");
        let still = Order { scene, changes, output: "a b.png", frames: Frames::Still(-3), backend: BackendName::Cpu };
        let words = |order: &Order<'_>| {
            order.arguments().iter().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join("|")
        };
        assert_eq!(
            words(&still),
            "--color=never|render|--frame=-3|-Da=-1m|--set=render.max_bounces=2|--size=64x32|--samples=4|--seed=7|\
            --camera=main|--frozen-bake|--backend=cpu|--progress=json|--output=a b.png|--|-s.kin"
        );
        let film = Order { changes: Changes::default(), frames: Frames::Film(" 0..4 "), ..still.clone() };
        assert_eq!(
            words(&film),
            "--color=never|animate|--frames=0..4|--backend=cpu|--progress=json|--output=a b.png|--|-s.kin"
        );
        assert!(words(&Order { frames: Frames::Film(""), ..film }).starts_with("--color=never|animate|--backend"));
    }

    #[test]
    fn progress_is_read() {
        let line = |text| serde_json::from_str::<Line>(text).ok();
        assert_eq!(line("{\"progress\":0.5}"), Some(Line { progress: 0.5, frame: None, frames: None }));
        let film = Line { progress: 0.25, frame: Some(1), frames: Some(4) };
        assert_eq!(line("{\"progress\":0.25,\"frame\":1,\"frames\":4}"), Some(film));
        assert_eq!(line("{\"samples\":4}"), None);
    }
}
