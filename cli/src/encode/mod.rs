//! Pictures as files: the format by the name's ending, the facts that every file carries, and writing that never leaves
//! half a file. There is no date in a file, so that the same picture is the same bytes.

mod exr;
mod layers;
mod other;
mod png;

use std::ffi::OsString;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use kinora_renderer::{Film, Request, Window, develop, measure};
use kinora_scene::{Background, Render, Scene, Shown, World};

pub use layers::{Layer, Layers};
pub use png::{read as read_png, text as text_of_png};

/// What every file says about its program.
pub const SOFTWARE: &str = concat!("kinora ", env!("CARGO_PKG_VERSION"));
/// The name under which a frame of a sequence carries its key.
const FRAME_KEY: &str = "kinora:frameKey";
/// The name under which a film in one file carries its key.
pub const FILM_KEY: &str = "kinora:filmKey";

/// A way to write a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Display values, without loss.
    Png {
        /// Of a channel.
        bits: Bits,
    },
    /// Linear light and layers, 32-bit float.
    Exr {
        /// Beside the picture.
        layers: Layers,
    },
    /// Linear light, shared exponent.
    Hdr,
    /// Display values, quality 95.
    Jpg,
}

/// Bits of a PNG's channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Bits {
    #[default]
    Eight,
    Sixteen,
}

impl Format {
    /// The format that the ending of `path` asks for.
    ///
    /// # Errors
    /// The ending is none that pictures have, or there is no place for layers.
    pub fn of(path: &Path, bits: Bits, layers: Layers) -> Result<Format, String> {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or("").to_ascii_lowercase();
        match ending.as_str() {
            "png" | "hdr" | "jpg" | "jpeg" if layers != Layers::default() => {
                Err(format!("`--aov` adds layers to an .exr; an .{ending} has none"))
            }
            "png" => Ok(Format::Png { bits }),
            "exr" => Ok(Format::Exr { layers }),
            "hdr" => Ok(Format::Hdr),
            "jpg" | "jpeg" => Ok(Format::Jpg),
            "mp4" | "gif" | "webm" | "apng" => Err(format!(
                "an .{ending} is a whole film in one file: `kinora animate` writes it, to a name without a place for \
                 the frame's number; a picture can be a png, exr, hdr or jpg"
            )),
            "" => Err(format!("`{}` has no ending that names a format: png, exr, hdr or jpg", path.display())),
            other => Err(format!("pictures cannot be written as `.{other}`: png, exr, hdr and jpg can")),
        }
    }

    /// Whether it can hold what `render` asks for.
    ///
    /// # Errors
    /// It cannot.
    pub fn check(self, render: &Render) -> Result<(), String> {
        let ending = match self {
            Format::Png { .. } | Format::Exr { .. } => return Ok(()),
            Format::Hdr => "hdr",
            Format::Jpg => "jpg",
        };
        if render.background == Background::Transparent {
            return Err(format!(
                "an .{ending} cannot be transparent: write a .png or an .exr, or set render.background to sky"
            ));
        }
        if self == Format::Hdr && render.view == Shown::Normal {
            return Err(
                "an .hdr has no negative numbers, which normals need: write an .exr, or a .png to look at".into()
            );
        }
        Ok(())
    }

    /// The layers that a film needs for it.
    pub fn layers(self) -> Layers {
        match self {
            Format::Exr { layers } => layers,
            _ => Layers::default(),
        }
    }

    // A name that a frame's key depends on.
    fn name(self) -> String {
        match self {
            Format::Png { bits: Bits::Eight } => "png8".into(),
            Format::Png { bits: Bits::Sixteen } => "png16".into(),
            Format::Exr { layers } => {
                let names = layers.wanted().map(|(name, _)| name);
                std::iter::once("exr").chain(names).collect::<Vec<_>>().join("+")
            }
            Format::Hdr => "hdr".into(),
            Format::Jpg => "jpg".into(),
        }
    }
}

/// The facts that a file carries.
#[derive(Clone, Debug)]
pub struct Stamp {
    /// The scene's name.
    pub name: String,
    /// [`scene_hash`].
    pub scene: String,
    /// Of the noise.
    pub seed: u32,
    /// The frame's number; between two frames, time · fps.
    pub frame: f64,
    /// Samples a pixel.
    pub samples: u32,
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// Frames a second.
    pub fps: f64,
    /// [`frame_key`], of a frame in a sequence.
    pub key: Option<String>,
}

impl Stamp {
    /// Names and values.
    pub fn entries(&self) -> Vec<(&'static str, String)> {
        let mut entries = vec![
            ("kinora:scene", self.scene.clone()),
            ("kinora:version", env!("CARGO_PKG_VERSION").into()),
            ("kinora:seed", self.seed.to_string()),
            ("kinora:frame", self.frame.to_string()),
            ("kinora:samples", self.samples.to_string()),
            ("kinora:backend", self.backend.into()),
        ];
        entries.extend(self.key.clone().map(|key| (FRAME_KEY, key)));
        entries
    }
}

/// A hash of all that the scene says, meshes included; the same in every run.
pub fn scene_hash(scene: &Scene) -> String {
    hash(scene, &[])
}

/// A hash of all that one frame's file depends on, but for the device.
pub fn frame_key(world: &World, format: Format, request: &Request) -> String {
    hash(world, &[env!("CARGO_PKG_VERSION"), &format.name(), &crop_name(request)])
}

fn crop_name(request: &Request) -> String {
    let name = |Window { left, top, width, height }| format!("{left},{top},{width},{height}");
    request.crop.map(name).unwrap_or_default()
}

fn hash(value: &impl serde::Serialize, more: &[&str]) -> String {
    let mut hasher = blake3::Hasher::new();
    for text in more {
        hasher.update(text.as_bytes());
        hasher.update(&[0]);
    }
    // Neither plain data nor a hasher can fail to take the other.
    let _ = postcard::to_io(value, io::BufWriter::with_capacity(1 << 16, &mut hasher));
    hasher.finalize().to_hex().to_string()
}

/// A hash of all that a film in one file depends on, but for the device: its scene by [`scene_hash`], its frames in their
/// order, and how it is written.
pub fn film_key(scene: &str, frames: &[i64], kind: &str, format: Format, request: &Request) -> String {
    hash(&frames, &[env!("CARGO_PKG_VERSION"), scene, kind, &format.name(), &crop_name(request)])
}

/// Frames a second, as a fraction of whole numbers of 1 or more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    /// So many frames
    pub frames: u32,
    /// in so many seconds.
    pub seconds: u32,
}

impl Rate {
    /// Frames a second as film knows them, whole or n · 1000 / 1001; others to three places.
    pub fn of(fps: f64) -> Rate {
        let ntsc = fps * 1.001;
        let near = |value: f64| (value - value.round()).abs() < 1e-6 && (0.5..1e6).contains(&value);
        let (frames, seconds) = match (near(fps), near(ntsc)) {
            (true, _) => (fps.round() as u32, 1),
            (_, true) => (ntsc.round() as u32 * 1000, 1001),
            _ => (((fps * 1000.0).round() as u32).clamp(1, i32::MAX as u32), 1000),
        };
        let (mut a, mut b) = (frames, seconds);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        Rate { frames: frames / a.max(1), seconds: seconds / a.max(1) }
    }
}

/// The picture as the bytes of a file.
///
/// # Errors
/// The picture is larger than the format allows.
pub fn encode(film: &Film, world: &World, format: Format, stamp: &Stamp) -> Result<Vec<u8>, String> {
    match format {
        Format::Png { bits } => png::encode(&develop(film, &world.look), bits, stamp),
        Format::Exr { layers } => exr::encode(film, world, layers, stamp),
        Format::Hdr => other::hdr(&measure(film), film.size(), stamp),
        Format::Jpg => other::jpg(&develop(film, &world.look), stamp),
    }
}

/// The key in a file that was written as a frame of a sequence; `None` if there is no such file or it has no key.
pub fn key_of(path: &Path, format: Format) -> Option<String> {
    match format {
        Format::Png { .. } => png::text(path, FRAME_KEY),
        Format::Exr { .. } => exr::text(path, FRAME_KEY),
        Format::Hdr | Format::Jpg => other::text(path, FRAME_KEY),
    }
}

/// The ending of a file that is not whole yet; before it stand the name of the file that it will be, and a process.
const TEMPORARY: &str = ".tmp";

/// Removes what processes that were killed left behind of files in `folder`, of those that are `meant`.
pub fn sweep(folder: &Path, meant: impl Fn(&str) -> bool) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let of = name.to_str().and_then(|name| name.strip_prefix('.')?.strip_suffix(TEMPORARY)?.rsplit_once('.'));
        let left = of.is_some_and(|(file, process)| process.bytes().all(|byte| byte.is_ascii_digit()) && meant(file));
        // Whoever still writes it has locked it.
        if left && fs::File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// A place to write a file to, tried out before there is anything to write.
pub struct Target {
    path: PathBuf,
    beside: PathBuf,
}

impl Target {
    /// A file at `path`; it is not touched yet.
    ///
    /// # Errors
    /// There cannot be a file there.
    pub fn new(path: &Path) -> Result<Target, String> {
        let fault = |what: &dyn std::fmt::Display| format!("cannot write `{}`: {what}", path.display());
        let name = path.file_name().ok_or_else(|| fault(&"the path names no file"))?;
        if path.is_dir() {
            return Err(fault(&"it is a folder"));
        }
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}{TEMPORARY}", std::process::id()));
        let target = Target { path: path.to_path_buf(), beside: path.with_file_name(hidden) };
        if !target.folder().is_dir() {
            return Err(fault(&format_args!("there is no folder `{}`", target.folder().display())));
        }
        let tried = fs::File::create(&target.beside).and_then(|_| fs::remove_file(&target.beside));
        tried.map_err(|error| fault(&error)).map(|()| target)
    }

    /// Where the file will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn folder(&self) -> &Path {
        self.path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }

    /// Writes the file: beside its place first, then all of it at once.
    ///
    /// # Errors
    /// The disk does not take it. Nothing is left behind.
    pub fn write(&self, bytes: &[u8]) -> Result<(), String> {
        let written = self.place(bytes);
        if written.is_err() {
            // It may not even have come to be.
            let _ = fs::remove_file(&self.beside);
        }
        written.map_err(|error| format!("cannot write `{}`: {error}", self.path.display()))
    }

    fn place(&self, bytes: &[u8]) -> io::Result<()> {
        let mut file = fs::File::create(&self.beside)?;
        // Tells `sweep` that someone is at work; without locks it leaves the file alone.
        let _ = file.try_lock();
        file.write_all(bytes)?;
        file.sync_all()?;
        drop(file);
        self.take(&self.beside)
    }

    /// Gives a finished file its place.
    ///
    /// # Errors
    /// The system does not do it.
    pub fn take(&self, from: &Path) -> io::Result<()> {
        fs::rename(from, &self.path)?;
        // The new name itself; not every system lets a folder be opened.
        if let Ok(folder) = fs::File::open(self.folder()) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_a_second() {
        for (fps, frames, seconds) in [
            (24.0, 24, 1),
            (30000.0 / 1001.0, 30000, 1001),
            (12.5, 25, 2),
            (0.25, 1, 4),
            (1e-9, 1, 1000),
            (23.9764, 2997, 125),
            (1e12, i32::MAX as u32, 1000),
        ] {
            assert_eq!(Rate::of(fps), Rate { frames, seconds }, "{fps}");
        }
    }
}
