//! `kinora render`: one frame.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use kinora_renderer::{BackendError, Film, RenderError, Renderer, Request, Window};
use kinora_scene::{Scene, World};
use serde::Serialize;

use crate::encode::{self, Bits, Format, Layer, Layers, Stamp, Target};
use crate::exit::{self, Outcome};
use crate::flags::{PictureFlags, SceneFlags};
use crate::memory;
use crate::progress::{Progress, Told};
use crate::session::{self, Loaded};
use crate::stop::Stop;
use crate::terminal;

/// Render one frame.
///
/// Example: kinora render cornell.kin -o cornell.png --samples 64
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
    /// The picture: .png, .jpg (as a display shows it), .exr or .hdr (linear light) [default: the scene's name.png, here]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The frame's number [default: 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    frame: Option<i64>,
    /// The time instead of a frame's number: --time 2.5s
    #[arg(long, value_name = "TIME", value_parser = time, conflicts_with = "frame", allow_hyphen_values = true)]
    time: Option<Time>,
    #[command(flatten)]
    picture: PictureFlags,
    #[command(flatten)]
    output_flags: OutputFlags,
}

/// How the result is written and told.
#[derive(Clone, Debug, clap::Args)]
pub struct OutputFlags {
    /// Bits a channel of a PNG
    #[arg(long, value_name = "8|16", default_value = "8", hide_default_value = true, value_parser = bits)]
    pub bits: Bits,
    /// Layers of an EXR beside the picture: albedo, depth, diffuse, emission, id, motion, normal, position, samples, specular, variance
    #[arg(long, value_name = "LIST")]
    aov: Option<Layers>,
    /// Only a part of the picture, in pixels from the top left: --crop 100,50,320,180. The pixels are the same as in the whole
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop, allow_hyphen_values = true)]
    crop: Option<Window>,
    /// Show no progress
    #[arg(long, short)]
    pub quiet: bool,
    /// How to tell progress
    #[arg(long, value_enum, default_value_t, hide_default_value = true)]
    pub progress: Told,
    /// Print what it took on stdout, as one line of JSON
    #[arg(long)]
    pub json: bool,
}

impl OutputFlags {
    /// The format that `path` asks for.
    pub fn format(&self, path: &Path) -> Result<Format, String> {
        Format::of(path, self.bits, self.aov.unwrap_or_default())
    }

    /// What is wanted of a film for it, of which there are so many `at_once`.
    ///
    /// # Errors
    /// The scene has no such picture, the format does not hold it, or memory does not.
    pub fn request(&self, scene: &Scene, format: Format, at_once: u64) -> Result<Request, String> {
        format.check(&scene.render)?;
        let layers = format.layers();
        if layers.has(Layer::Variance) && scene.render.samples < 2 {
            return Err("one sample tells no variance: `--aov variance` needs 2 or more".into());
        }
        let request = Request { crop: self.crop, layers: layers.of_surfaces(), parts: layers.of_parts() };
        let picture = scene.render.resolution;
        let window = self.crop.unwrap_or(Window::whole(picture));
        if !Window::fits(picture, window) {
            return Err(RenderError::Outside { window, picture }.to_string());
        }
        // A file's values lie beside the film when it is written: of most layers three numbers a pixel.
        let written_bytes = 40 + 12 * layers.wanted().count() as u64;
        let bytes = Film::bytes(&scene.render, &request).saturating_mul(at_once);
        let bytes = bytes.saturating_add(written_bytes * window.pixels() as u64);
        match memory::free_bytes() {
            Some(free) if bytes > free => {
                let size = [window.width, window.height];
                let gib = free as f64 / f64::from(1 << 30);
                Err(format!("{}; {gib:.1} GiB are free", RenderError::Memory { size, bytes }))
            }
            _ => Ok(request),
        }
    }
}

/// A time on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Time {
    Seconds(f64),
    Frames(f64),
}

/// What it took.
#[derive(Default, Serialize)]
pub struct Statistics {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skipped: Option<usize>,
    /// A pixel: the mean, which is a whole number where all have as many.
    #[serde(serialize_with = "short")]
    pub samples: f64,
    pub load_s: f64,
    pub build_s: f64,
    pub render_s: f64,
    /// From when the scene was loaded until all files were written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_s: Option<f64>,
    pub rays: u64,
    pub peak_bytes: Option<u64>,
    pub backend: Option<&'static str>,
}

fn short<S: serde::Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if number.fract() == 0.0 { serializer.serialize_u64(*number as u64) } else { serializer.serialize_f64(*number) }
}

impl Statistics {
    /// Prints the line.
    pub fn print(mut self) -> Result<(), String> {
        self.peak_bytes = memory::peak_bytes();
        // Strings and numbers always serialise.
        terminal::out(&(serde_json::to_string(&self).unwrap_or_default() + "\n"))
    }
}

pub fn run(args: &Args) -> Outcome {
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.scene.file));
    let format = args.output_flags.format(&output)?;
    refuse_input(&output, &args.scene.file)?;
    let target = Target::new(&output)?;
    let stop = Stop::listen().map_err(|error| format!("cannot listen for Ctrl-C: {error}"))?;

    let start = Instant::now();
    let mut loaded = session::load(&args.scene.file, &args.scene.changes_with(&args.picture))?;
    loaded.report();
    if let Some(code) = loaded.with_bodies(args.output_flags.quiet, &|| stop.asked())? {
        return Ok(code);
    }
    let Some(scene) = loaded.scene.as_deref() else { return Ok(loaded.fault_code()) };
    let request = args.output_flags.request(scene, format, 1)?;
    let frame = match (args.frame, args.time) {
        (_, Some(Time::Seconds(seconds))) => seconds * scene.clock.fps,
        (_, Some(Time::Frames(frame))) => frame,
        (frame, None) => frame.unwrap_or(0) as f64,
    };
    let shutter = scene.clock.shutter_at(frame / scene.clock.fps);
    let world = match loaded.sample_moving(shutter, format.layers().has(Layer::Motion)) {
        Ok(world) => world,
        Err(found) => {
            loaded.report_one(&found);
            return Ok(exit::FINDINGS);
        }
    };
    let load = start.elapsed();

    let mut renderer = Renderer::new(args.picture.open().map_err(|error| error.to_string())?);
    let progress = Progress::new(args.output_flags.quiet, args.output_flags.progress, None);
    let started = Instant::now();
    let film = match draw(&mut renderer, &world, &request, &progress, &stop) {
        Ok(film) => film,
        Err(end) => {
            progress.end(String::new);
            return end.finish(&loaded);
        }
    };
    let stamp = stamp(&args.scene.file, scene, frame, &world, &film, &renderer);
    target.write(&encode::encode(&film, &world, format, &stamp)?)?;
    progress.end(|| summary(target.path(), &film, started.elapsed()));
    if args.output_flags.json {
        let mut statistics = Statistics { load_s: load.as_secs_f64(), ..Statistics::default() };
        statistics.add(&renderer, &film, started.elapsed());
        statistics.print()?;
    }
    Ok(exit::CLEAN)
}

impl Statistics {
    /// Adds a picture; `whole` is the time since before its tree was built.
    pub fn add(&mut self, renderer: &Renderer, film: &Film, whole: Duration) {
        let build = renderer.build_time();
        self.samples = film.mean_samples();
        self.build_s += build.as_secs_f64();
        self.render_s += whole.saturating_sub(build).as_secs_f64();
        self.rays += film.rays();
        self.backend = Some(renderer.backend().name());
    }
}

/// The facts that a picture of one frame carries.
pub fn stamp(path: &Path, scene: &Scene, frame: f64, world: &World, film: &Film, renderer: &Renderer) -> Stamp {
    Stamp {
        name: name_of(path),
        scene: encode::scene_hash(scene),
        seed: world.render.seed,
        frame,
        samples: film.samples(),
        backend: renderer.backend().name(),
        fps: scene.clock.fps,
        key: None,
    }
}

/// Why there is no picture.
pub enum End {
    /// Someone asked to stop: the exit code.
    Stopped(u8),
    /// The renderer could not.
    Failed(RenderError),
}

impl End {
    /// Says so; gives the exit code.
    pub fn finish(self, loaded: &Loaded) -> Outcome {
        match self {
            End::Stopped(code) => {
                terminal::err("stopped; the unfinished picture was not written\n");
                Ok(code)
            }
            End::Failed(RenderError::Pack(error)) => {
                loaded.report_one(&session::too_large(&error));
                Ok(exit::FINDINGS)
            }
            End::Failed(RenderError::Backend(error @ BackendError::Device(_))) => {
                terminal::error(&error.to_string());
                Ok(exit::STOPPED)
            }
            End::Failed(error) => Err(error.to_string()),
        }
    }
}

/// Renders `world`.
pub fn draw(
    renderer: &mut Renderer,
    world: &World,
    request: &Request,
    progress: &Progress,
    stop: &Stop,
) -> Result<Film, End> {
    let stopped = || stop.asked().map_or(Ok(()), |code| Err(End::Stopped(code)));
    stopped()?;
    let size = request.crop.map_or(world.render.resolution, |window| [window.width, window.height]);
    progress.begin(size, world.render.samples);
    let film = renderer.render_for(world, request, &|done| {
        progress.picture(done);
        stop.asked().is_none()
    });
    let film = film.map_err(End::Failed)?;
    stopped()?;
    Ok(film)
}

/// `name: 640 × 360, 128 samples, 12.3 s`
fn summary(path: &Path, film: &Film, time: Duration) -> String {
    let [width, height] = film.size();
    let samples = match film.is_adaptive() {
        true => format!("{:.1} samples in the mean", film.mean_samples()),
        false => format!("{} samples", film.samples()),
    };
    format!("{}: {width} × {height}, {samples}, {:.1} s", path.display(), time.as_secs_f64())
}

fn default_output(scene: &Path) -> PathBuf {
    Path::new(scene.file_name().unwrap_or("kinora".as_ref())).with_extension("png")
}

/// A picture must not take the place of the scene.
pub fn refuse_input(output: &Path, input: &Path) -> Result<(), String> {
    let same = match (output.canonicalize(), input.canonicalize()) {
        (Ok(output), Ok(input)) => output == input,
        _ => output == input,
    };
    if same { Err(format!("`{}` is the scene itself; choose another output", output.display())) } else { Ok(()) }
}

fn time(text: &str) -> Result<Time, String> {
    let text = text.trim();
    let at = text.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len();
    let (number, unit) = text.split_at(at);
    let number = number.parse::<f64>().ok().filter(|number| number.is_finite());
    match (number, unit) {
        (Some(seconds), "s") => Ok(Time::Seconds(seconds)),
        (Some(ms), "ms") => Ok(Time::Seconds(ms / 1000.0)),
        (Some(minutes), "min") => Ok(Time::Seconds(minutes * 60.0)),
        (Some(frames), "f") => Ok(Time::Frames(frames)),
        (Some(0.0), "") => Ok(Time::Seconds(0.0)),
        (Some(number), "") => Err(format!("times need a unit: {number}s, or {number}f for frames")),
        _ => Err("write a number and s, ms, min or f".into()),
    }
}

fn bits(text: &str) -> Result<Bits, String> {
    match text {
        "8" => Ok(Bits::Eight),
        "16" => Ok(Bits::Sixteen),
        _ => Err("a PNG has 8 or 16 bits a channel".into()),
    }
}

fn crop(text: &str) -> Result<Window, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[left, top, width, height]) if width > 0 && height > 0 => Ok(Window { left, top, width, height }),
        _ => Err("write left, top, width and height in pixels: 100,50,320,180".into()),
    }
}

/// What a scene is called in its pictures.
pub fn name_of(scene: &Path) -> String {
    scene.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops() {
        let window = |left, top, width, height| Some(Window { left, top, width, height });
        for (text, expected) in [
            ("1,2,3,4", window(1, 2, 3, 4)),
            (" 0, 0, 1, 1", window(0, 0, 1, 1)),
            ("0,0,0,1", None),
            ("-1,0,1,1", None),
            ("1,2,3", None),
            ("1,2,3,4,5", None),
            ("0,0,4294967296,1", None),
            ("", None),
        ] {
            assert_eq!(crop(text).ok(), expected, "{text:?}");
        }
    }

    #[test]
    fn times() {
        for (text, expected) in [
            ("2.5s", Some(Time::Seconds(2.5))),
            ("400ms", Some(Time::Seconds(0.4))),
            ("1min", Some(Time::Seconds(60.0))),
            ("-1s", Some(Time::Seconds(-1.0))),
            ("48f", Some(Time::Frames(48.0))),
            ("0", Some(Time::Seconds(0.0))),
            ("2", None),
            ("s", None),
            ("", None),
            ("2h", None),
            ("infs", None),
            ("nans", None),
        ] {
            assert_eq!(time(text).ok(), expected, "{text:?}");
        }
    }
}
