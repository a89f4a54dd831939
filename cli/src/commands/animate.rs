//! `kinora animate`: a range of frames, each in a file of its own or all in one.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::time::Instant;

use kinora_renderer::{BackendError, Film, RenderError, Renderer, Request};
use kinora_scene::{Background, Scene, World};

use super::render::{End, OutputFlags, Statistics, draw, name_of, refuse_input};
use crate::encode::{self, Format, Layer, Rate, Stamp, Target};
use crate::exit::{self, Outcome};
use crate::films::{self, Cache, Head, Kind};
use crate::flags::{PictureFlags, SceneFlags};
use crate::frames::{self, Pattern};
use crate::progress::Progress;
use crate::session::{self, Loaded};
use crate::stop::Stop;
use crate::terminal;
use crate::writing::{Frame, Job, OneFile, Told, write_all};

/// Films up to this size wait for their turn while the next one is rendered.
const WAITING_BYTES: u64 = 64 << 20;

/// Render many frames, each into a file of its own, or all into one.
///
/// Examples: kinora animate orbit.kin -o orbit.mp4
/// kinora animate orbit.kin --frames 0..48 -o out/frame.####.png --resume
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// The files, with #### (or %04d, {frame:04}) for the number: .png, .jpg, .exr or .hdr; or one film: .mp4, .webm, .apng or .gif
    #[arg(short, long, value_name = "PATTERN", default_value = "out/frame.####.png")]
    output: PathBuf,
    /// Which frames: 0..96 (without 96), 1-96 (with it), 0..96:4, 7, or several with commas [default: all]
    #[arg(long, value_name = "LIST", allow_hyphen_values = true)]
    frames: Option<String>,
    /// Only every N-th of them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    step: Option<u32>,
    /// Leave out frames whose file is there already and still right
    #[arg(long, overrides_with = "force")]
    resume: bool,
    /// Render all frames, whatever is there: so it is without --resume, and what comes last holds
    #[arg(long, overrides_with = "resume")]
    force: bool,
    #[command(flatten)]
    picture: PictureFlags,
    #[command(flatten)]
    output_flags: OutputFlags,
}

/// Where the frames go.
enum Output {
    Sequence { pattern: Pattern, format: Format },
    Film { kind: Kind, format: Format },
}

impl Output {
    fn of(args: &Args) -> Result<Output, String> {
        let path = &*args.output;
        let pattern = Pattern::parse(path);
        match (Kind::of(path), pattern) {
            (Some(kind), None) => {
                // Its frames are kept as pictures until all are there.
                let format = args.output_flags.format(Path::new("frame.png"))?;
                Ok(Output::Film { kind, format })
            }
            (Some(kind), Some(_)) => Err(format!(
                "an .{} is one file of all frames: leave the place for the frame's number out of `{}`",
                kind.ending(),
                path.display()
            )),
            (None, pattern) => {
                let format = args.output_flags.format(path)?;
                let pattern = pattern.ok_or_else(|| {
                    let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
                    let example = path.with_extension(format!("####.{ending}"));
                    let film = path.with_extension("mp4");
                    format!(
                        "`{}` has no place for the frame's number: write it as in {}, or name a film in one file, such as \
                         {} (.webm, .apng, .gif)",
                        path.display(),
                        example.display(),
                        film.display()
                    )
                })?;
                Ok(Output::Sequence { pattern, format })
            }
        }
    }
}

pub fn run(args: &Args) -> Outcome {
    let output = Output::of(args)?;
    let listed = args.frames.as_deref().map(frames::parse).transpose()?;
    refuse_input(&args.output, &args.scene.file)?;
    let folder = args.output.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder `{}`: {error}", folder.display()))?;
    // Whether the folder takes files at all.
    let whole = match &output {
        Output::Sequence { pattern, .. } => Target::new(&pattern.file(0))?,
        Output::Film { kind, .. } => {
            kind.check(false, args.output_flags.bits, Rate { frames: 1, seconds: 1 })?;
            Target::new(&args.output)?
        }
    };
    let stop = Stop::listen().map_err(|error| format!("cannot listen for Ctrl-C: {error}"))?;

    let start = Instant::now();
    let mut loaded = session::load(&args.scene.file, &args.scene.changes_with(&args.picture))?;
    loaded.report();
    if let Some(code) = loaded.with_bodies(args.output_flags.quiet, &|| stop.asked())? {
        return Ok(code);
    }
    let Some(scene) = loaded.scene.as_deref() else { return Ok(loaded.fault_code()) };
    let (Output::Sequence { format, .. } | Output::Film { format, .. }) = output;
    // One is written while the next one is rendered.
    let request = args.output_flags.request(scene, format, 2)?;
    let mut frames = listed.unwrap_or_else(|| (0..scene.clock.frame_count()).collect());
    frames = frames.into_iter().step_by(args.step.map_or(1, |step| step as usize)).collect();
    let hash = encode::scene_hash(scene);
    let mut statistics = Statistics {
        frames: Some(0),
        skipped: Some(0),
        samples: scene.render.samples.into(),
        load_s: start.elapsed().as_secs_f64(),
        ..Statistics::default()
    };

    let mut film = None;
    let pattern = match output {
        Output::Sequence { pattern, .. } => pattern,
        Output::Film { kind, .. } => {
            let rate = Rate::of(scene.clock.fps);
            let transparent = scene.render.background == Background::Transparent;
            kind.check(transparent, args.output_flags.bits, rate)?;
            let key = encode::film_key(&hash, &frames, kind.ending(), format, &request);
            if args.resume && films::key_of(&args.output).as_ref() == Some(&key) {
                statistics.skipped = Some(frames.len());
                return end(args, statistics, start, exit::CLEAN);
            }
            let cache = Cache::open(&args.output, !args.resume)?;
            let window = request.crop.map_or(scene.render.resolution, |window| [window.width, window.height]);
            let head = Head {
                kind,
                size: window,
                alpha: transparent,
                bits: args.output_flags.bits,
                rate,
                count: u32::try_from(frames.len()).unwrap_or(u32::MAX),
                facts: vec![
                    ("kinora:scene", hash.clone()),
                    ("kinora:version", env!("CARGO_PKG_VERSION").into()),
                    ("kinora:seed", scene.render.seed.to_string()),
                    ("kinora:frames", frames::list(&frames)),
                    ("kinora:samples", scene.render.samples.to_string()),
                    (encode::FILM_KEY, key),
                ],
            };
            let pattern = Pattern::parse(&cache.pattern()).ok_or("the film has no name")?;
            film = Some((cache, OneFile { head, beside: PathBuf::new() }));
            pattern
        }
    };
    let folder = Some(pattern.folder()).filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    encode::sweep(folder, |name| pattern.is_of(name));
    if let Some((cache, file)) = &mut film {
        file.beside = cache.beside();
    }

    let progress = Progress::new(args.output_flags.quiet, args.output_flags.progress, Some(frames.len()));
    let bytes = Film::bytes(&scene.render, &request);
    let (jobs, to_do) = sync_channel(usize::from(bytes <= WAITING_BYTES));
    let (tell, told) = channel();
    let one_file = film.as_ref().map(|(_, file)| file);
    let mut sequence = Sequence {
        args,
        format,
        request,
        pattern,
        loaded: &loaded,
        scene,
        hash,
        renderer: None,
        progress: &progress,
        stop: &stop,
        statistics,
        told,
        missing: Vec::new(),
        worst: exit::CLEAN,
        ended: false,
    };
    let writer = std::thread::scope(|scope| {
        let writer = scope.spawn(move || write_all(to_do, &tell, format, one_file));
        sequence.all(&frames, &jobs);
        // The writer comes to an end.
        drop(jobs);
        writer.join().unwrap_or(None)
    });
    sequence.listen();
    let Sequence { statistics, mut missing, mut worst, ended, .. } = sequence;
    missing.sort_unstable();
    if let Some((cache, file)) = film {
        match writer {
            Some(writer) if !ended && missing.is_empty() => {
                progress.say("writing the film");
                let written =
                    writer.finish().and_then(|()| whole.take(&file.beside).map_err(|error| error.to_string()));
                match written {
                    Ok(()) => cache.remove(),
                    Err(why) => {
                        worst = exit::FAILED;
                        progress
                            .beside(|| terminal::error(&format!("cannot write `{}`: {why}", args.output.display())));
                    }
                }
            }
            // Said already.
            None if !ended && missing.is_empty() => worst = worst.max(exit::FAILED),
            unfinished => drop(unfinished),
        }
        if worst != exit::CLEAN {
            let _ = std::fs::remove_file(&file.beside);
            progress.beside(|| {
                terminal::err(&format!(
                    "`{}` was not written; its finished frames are kept, and --resume goes on with them\n",
                    args.output.display()
                ))
            });
        }
    }
    if !missing.is_empty() {
        progress.beside(|| {
            let (count, all) = (missing.len(), frames.len());
            terminal::error(&format!("{count} of {all} frames have no picture: {}", frames::list(&missing)));
        });
    }
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
    end(args, statistics, start, worst)
}

fn end(args: &Args, mut statistics: Statistics, start: Instant, code: u8) -> Outcome {
    statistics.wall_s = Some(start.elapsed().as_secs_f64());
    if args.output_flags.json {
        statistics.print()?;
    }
    Ok(code)
}

/// Everything that one frame needs, and what became of those before it.
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
    told: Receiver<Told>,
    /// Frames without a picture.
    missing: Vec<i64>,
    worst: u8,
    /// Whether the frames that are left were not tried.
    ended: bool,
}

/// An exit code, and whether the other frames have any hope.
enum Fault {
    Frame(u8),
    All(u8),
}

impl Sequence<'_> {
    fn all(&mut self, frames: &[i64], jobs: &SyncSender<Job>) {
        for &frame in frames {
            let job = match self.frame(frame) {
                Ok(job) => job,
                Err(Fault::Frame(code)) => {
                    self.worst = self.worst.max(code);
                    self.missing.push(frame);
                    self.progress.skipped();
                    Job::Missing
                }
                Err(Fault::All(code)) => {
                    self.worst = code;
                    self.ended = true;
                    return;
                }
            };
            // The writer is gone only where it failed, which is told.
            let _ = jobs.send(job);
            self.listen();
            if self.ended {
                return;
            }
        }
    }

    // Hears what became of the files.
    fn listen(&mut self) {
        while let Ok(told) = self.told.try_recv() {
            match told {
                Told::Written => self.statistics.frames = self.statistics.frames.map(|frames| frames + 1),
                Told::Failed(frame, why) => {
                    self.progress.beside(|| terminal::error(&format!("frame {frame}: {why}")));
                    self.missing.push(frame);
                    self.worst = self.worst.max(exit::FAILED);
                }
                Told::FilmFailed(why) => {
                    let output = self.args.output.display();
                    self.progress.beside(|| terminal::error(&format!("cannot write `{output}`: {why}")));
                    self.worst = self.worst.max(exit::FAILED);
                    self.ended = true;
                }
            }
        }
    }

    fn frame(&mut self, frame: i64) -> Result<Job, Fault> {
        if let Some(code) = self.stop.asked() {
            return Err(self.end(End::Stopped(code)));
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
            self.progress.skipped();
            return Ok(Job::There(path));
        }
        let progress = self.progress;
        let failed = |message: String| {
            progress.beside(|| terminal::error(&format!("frame {frame}: {message}")));
            Fault::Frame(exit::FAILED)
        };
        let target = refuse_input(&path, &self.args.scene.file).and_then(|()| Target::new(&path)).map_err(failed)?;
        let started = Instant::now();
        let film = self.draw(frame, &world)?;
        if let Some(renderer) = &self.renderer {
            self.statistics.add(renderer, &film, started.elapsed());
        }
        let stamp = self.stamp(frame, &world, &film, key);
        progress.rendered();
        Ok(Job::Write(Box::new(Frame { number: frame, film, world, stamp, target })))
    }

    fn draw(&mut self, frame: i64, world: &World) -> Result<Film, Fault> {
        if self.renderer.is_none() {
            let backend = self.args.picture.open().map_err(|error| self.end(End::Failed(error.into())))?;
            self.renderer = Some(Renderer::new(backend));
        }
        let Some(renderer) = &mut self.renderer else { return Err(Fault::All(exit::FAILED)) };
        draw(renderer, world, &self.request, self.progress, self.stop).map_err(|end| match end {
            // The next frame may be smaller.
            End::Failed(RenderError::Pack(_) | RenderError::Backend(BackendError::TooLarge { .. })) => {
                self.progress.beside(|| terminal::error(&format!("frame {frame} has no picture")));
                Fault::Frame(self.finish(end))
            }
            end => self.end(end),
        })
    }

    fn stamp(&self, frame: i64, world: &World, film: &Film, key: String) -> Stamp {
        Stamp {
            name: name_of(&self.args.scene.file),
            scene: self.hash.clone(),
            seed: world.render.seed,
            frame: frame as f64,
            samples: film.samples(),
            backend: self.renderer.as_ref().map_or("", |renderer| renderer.backend().name()),
            fps: self.scene.clock.fps,
            key: Some(key),
        }
    }

    fn end(&self, end: End) -> Fault {
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
