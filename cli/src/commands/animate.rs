//! `kinora animate`: a range of frames, each in a file of its own.

use std::path::{Path, PathBuf};
use std::time::Instant;

use kinora_renderer::{BackendError, Film, RenderError, Renderer, Request};
use kinora_scene::{Scene, World};

use super::render::{End, OutputFlags, Statistics, draw, name_of, refuse_input};
use crate::encode::{self, Format, Layer, Stamp, Target};
use crate::exit::{self, Outcome};
use crate::flags::{PictureFlags, SceneFlags};
use crate::frames::{self, Pattern};
use crate::progress::Progress;
use crate::session::{self, Loaded};
use crate::stop::Stop;
use crate::terminal;

/// Render many frames, each into a file of its own.
///
/// Example: kinora animate orbit.kin --frames 0..48 -o out/frame.####.png --resume
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// The files, with #### (or %04d, {frame:04}) for the number: .png, .jpg, .exr or .hdr
    #[arg(short, long, value_name = "PATTERN", default_value = "out/frame.####.png")]
    output: PathBuf,
    /// Which frames: 0..96 (without 96), 1-96 (with it), 0..96:4, 7, or several with commas [default: all]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Leave out frames whose file is there already and still right
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    picture: PictureFlags,
    #[command(flatten)]
    output_flags: OutputFlags,
}

pub fn run(args: &Args) -> Outcome {
    let format = args.output_flags.format(&args.output)?;
    let pattern = Pattern::parse(&args.output).ok_or_else(|| {
        let example = args.output.with_extension("####.png");
        format!("`{}` has no place for the frame's number: write it as in {}", args.output.display(), example.display())
    })?;
    let listed = args.frames.as_deref().map(frames::parse).transpose()?;
    let folder = Some(pattern.folder()).filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder `{}`: {error}", folder.display()))?;
    // Whether the folder takes files at all.
    Target::new(&pattern.file(0))?;
    let stop = Stop::listen().map_err(|error| format!("cannot listen for Ctrl-C: {error}"))?;

    let start = Instant::now();
    let mut loaded = session::load(&args.scene.file, &args.scene.changes_with(&args.picture))?;
    loaded.report();
    if let Some(code) = loaded.with_bodies(args.output_flags.quiet, &|| stop.asked())? {
        return Ok(code);
    }
    let Some(scene) = loaded.scene.as_deref() else { return Ok(loaded.fault_code()) };
    let request = args.output_flags.request(scene, format)?;
    let frames = listed.unwrap_or_else(|| (0..scene.clock.frame_count()).collect());
    let statistics = Statistics {
        frames: Some(0),
        skipped: Some(0),
        samples: scene.render.samples.into(),
        load_s: start.elapsed().as_secs_f64(),
        ..Statistics::default()
    };
    let progress = Progress::new(args.output_flags.quiet, Some(frames.len()));
    let mut film = Sequence {
        args,
        format,
        request,
        pattern,
        loaded: &loaded,
        scene,
        hash: encode::scene_hash(scene),
        renderer: None,
        progress: &progress,
        stop: &stop,
        statistics,
    };
    let mut worst = exit::CLEAN;
    for &frame in &frames {
        match film.frame(frame) {
            Ok(()) => {}
            Err(Fault::Frame(code)) => worst = worst.max(code),
            Err(Fault::All(code)) => {
                worst = code;
                break;
            }
        }
        progress.frame();
    }
    let statistics = film.statistics;
    let (done, skipped) = (statistics.frames.unwrap_or(0), statistics.skipped.unwrap_or(0));
    progress.end(|| {
        let kept = if skipped > 0 { format!(", {skipped} were there") } else { String::new() };
        format!(
            "{}: {done} of {} frames rendered{kept}, {:.1} s",
            args.output.display(),
            frames.len(),
            start.elapsed().as_secs_f64()
        )
    });
    if args.output_flags.json {
        statistics.print()?;
    }
    Ok(worst)
}

/// Everything that one frame needs.
struct Sequence<'a> {
    args: &'a Args,
    format: Format,
    request: Request,
    pattern: Pattern,
    loaded: &'a Loaded,
    scene: &'a Scene,
    hash: String,
    // Opened for the first frame that is not there yet.
    renderer: Option<Renderer>,
    progress: &'a Progress,
    stop: &'a Stop,
    statistics: Statistics,
}

/// An exit code, and whether the other frames have any hope.
enum Fault {
    Frame(u8),
    All(u8),
}

impl Sequence<'_> {
    fn frame(&mut self, frame: i64) -> Result<(), Fault> {
        if let Some(code) = self.stop.asked() {
            return Err(self.all(End::Stopped(code)));
        }
        let shutter = self.scene.clock.shutter_of(frame);
        let moving = self.format.layers().has(Layer::Motion);
        let world = self.loaded.sample_moving(shutter, moving).map_err(|found| {
            self.progress.beside(|| {
                terminal::error(&format!("frame {frame} has no picture"));
                self.loaded.report_one(&found);
            });
            Fault::Frame(exit::FINDINGS)
        })?;
        let path = self.pattern.file(frame);
        let key = encode::frame_key(&world, self.format, &self.request);
        if self.args.resume && encode::key_of(&path, self.format).as_ref() == Some(&key) {
            self.statistics.skipped = self.statistics.skipped.map(|skipped| skipped + 1);
            return Ok(());
        }
        let progress = self.progress;
        let failed = |message: String| {
            progress.beside(|| terminal::error(&message));
            Fault::Frame(exit::FAILED)
        };
        let target = refuse_input(&path, &self.args.scene.file).and_then(|()| Target::new(&path)).map_err(failed)?;
        let started = Instant::now();
        let film = self.draw(frame, &world)?;
        self.write(frame, &world, &film, &target, key).map_err(failed)?;
        if let Some(renderer) = &self.renderer {
            self.statistics.add(renderer, &film, started.elapsed());
        }
        self.statistics.frames = self.statistics.frames.map(|frames| frames + 1);
        Ok(())
    }

    fn draw(&mut self, frame: i64, world: &World) -> Result<Film, Fault> {
        if self.renderer.is_none() {
            let backend = self.args.picture.open().map_err(|error| self.all(End::Failed(error.into())))?;
            self.renderer = Some(Renderer::new(backend));
        }
        let Some(renderer) = &mut self.renderer else { return Err(Fault::All(exit::FAILED)) };
        draw(renderer, world, &self.request, self.progress, self.stop).map_err(|end| match end {
            // The next frame may be smaller.
            End::Failed(RenderError::Pack(_) | RenderError::Backend(BackendError::TooLarge { .. })) => {
                self.progress.beside(|| terminal::error(&format!("frame {frame} has no picture")));
                Fault::Frame(self.finish(end))
            }
            end => self.all(end),
        })
    }

    fn write(&self, frame: i64, world: &World, film: &Film, target: &Target, key: String) -> Result<(), String> {
        let stamp = Stamp {
            name: name_of(&self.args.scene.file),
            scene: self.hash.clone(),
            seed: world.render.seed,
            frame: frame as f64,
            samples: film.samples(),
            backend: self.renderer.as_ref().map_or("", |renderer| renderer.backend().name()),
            fps: self.scene.clock.fps,
            key: Some(key),
        };
        target.write(&encode::encode(film, world, self.format, &stamp)?)
    }

    fn all(&self, end: End) -> Fault {
        Fault::All(self.finish(end))
    }

    // Says why there is no picture; gives the exit code.
    fn finish(&self, end: End) -> u8 {
        let mut code = exit::FAILED;
        self.progress.beside(|| match end.finish(self.loaded) {
            Ok(found) => code = found,
            Err(message) => terminal::error(&message),
        });
        code
    }
}
