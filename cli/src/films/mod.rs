//! Films in one file. Their frames come one after the other, as display values; how many there are is known before.
//! A film is written beside its place and takes it when it is whole, so that no half of one ever looks like a film.

mod apng;
mod ffmpeg;
mod gif;

use std::fs::{self, File};
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::encode::{Bits, FILM_KEY, Rate, read_png};

/// The ways to write a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// PNGs in one file, without loss.
    Apng,
    /// 255 colours.
    Gif,
    /// H.264, by ffmpeg.
    Mp4,
    /// VP9, by ffmpeg.
    Webm,
}

impl Kind {
    /// The kind that the ending of `path` names, if it is one of a film.
    pub fn of(path: &Path) -> Option<Kind> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "apng" => Some(Kind::Apng),
            "gif" => Some(Kind::Gif),
            "mp4" => Some(Kind::Mp4),
            "webm" => Some(Kind::Webm),
            _ => None,
        }
    }

    /// Its ending.
    pub fn ending(self) -> &'static str {
        match self {
            Kind::Apng => "apng",
            Kind::Gif => "gif",
            Kind::Mp4 => "mp4",
            Kind::Webm => "webm",
        }
    }

    /// Whether it can hold such frames, and this machine can write it.
    ///
    /// # Errors
    /// It cannot, or the program that does is not there.
    pub fn check(self, transparent: bool, bits: Bits, rate: Rate) -> Result<(), String> {
        let ending = self.ending();
        if self == Kind::Apng {
            return Ok(());
        }
        if transparent {
            return Err(format!(
                "a .{ending} cannot be transparent here: write an .apng or a sequence of .png, or set render.background \
                 to sky"
            ));
        }
        if bits != Bits::Eight {
            return Err(format!("a .{ending} has 8 bits a channel: `--bits 16` is for .png and .apng"));
        }
        match self {
            // What lasts a hundredth of a second is shown for a tenth by most programs.
            Kind::Gif if f64::from(rate.frames) > 50.0 * f64::from(rate.seconds) => {
                Err("a .gif shows at most 50 frames a second: write another kind of film, or --set render.fps=50"
                    .into())
            }
            Kind::Gif | Kind::Apng => Ok(()),
            Kind::Mp4 | Kind::Webm => ffmpeg::find().map(|_| ()).ok_or_else(|| {
                format!(
                    "a .{ending} is written by the program ffmpeg, which is not there: install it (apt install ffmpeg, \
                     brew install ffmpeg, winget install ffmpeg) so that it is on the PATH; .apng, .gif and sequences \
                     such as out/frame.####.png need nothing"
                )
            }),
        }
    }
}

/// What is known of a film before its first frame.
#[derive(Clone, Debug)]
pub struct Head {
    /// The way it is written.
    pub kind: Kind,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Whether its frames have alpha.
    pub alpha: bool,
    /// Of a channel.
    pub bits: Bits,
    /// How fast it plays.
    pub rate: Rate,
    /// How many frames it has: 1 or more.
    pub count: u32,
    /// Facts for whoever looks into the file: names and values.
    pub facts: Vec<(&'static str, String)>,
}

impl Head {
    fn comment(&self) -> String {
        self.facts.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join("; ")
    }
}

/// A film in work.
pub struct Writer {
    stream: Stream,
    beside: PathBuf,
    wanted: u32,
    written: u32,
}

enum Stream {
    Apng(apng::Apng),
    Gif(gif::Gif),
    Ffmpeg(ffmpeg::Ffmpeg),
}

impl Writer {
    /// Begins a film at `beside`.
    ///
    /// # Errors
    /// There can be no such file, or ffmpeg does not start.
    pub fn begin(head: &Head, beside: &Path) -> Result<Writer, String> {
        let stream = match head.kind {
            Kind::Apng => Stream::Apng(apng::Apng::begin(head, beside)?),
            Kind::Gif => Stream::Gif(gif::Gif::begin(head, beside)?),
            Kind::Mp4 | Kind::Webm => Stream::Ffmpeg(ffmpeg::Ffmpeg::begin(head, beside)?),
        };
        Ok(Writer { stream, beside: beside.to_path_buf(), wanted: head.count, written: 0 })
    }

    /// Adds a frame, from a PNG that stays until the film is finished.
    ///
    /// # Errors
    /// It is no such PNG, the disk does not take the film, or ffmpeg ended.
    pub fn frame(&mut self, png: &Path) -> Result<(), String> {
        let codes = read_png(png)?;
        match &mut self.stream {
            Stream::Apng(film) => film.frame(&codes)?,
            Stream::Gif(film) => film.frame(&codes, png),
            Stream::Ffmpeg(film) => film.frame(&codes)?,
        }
        self.written += 1;
        Ok(())
    }

    /// Ends the film, which then is a whole file.
    ///
    /// # Errors
    /// As [`Writer::frame`], or frames are missing.
    pub fn finish(self) -> Result<(), String> {
        if self.written != self.wanted {
            return Err(format!("of {} frames {} came", self.wanted, self.written));
        }
        match self.stream {
            Stream::Apng(film) => film.finish()?,
            Stream::Gif(film) => film.finish()?,
            Stream::Ffmpeg(film) => film.finish(self.wanted)?,
        }
        // Some programs tell of success that there was none of.
        let whole = File::open(&self.beside).and_then(|file| file.sync_all().map(|()| file.metadata()));
        match whole.and_then(|data| data) {
            Ok(data) if data.len() > 0 => Ok(()),
            Ok(_) => Err("the file is empty".into()),
            Err(error) => Err(error.to_string()),
        }
    }
}

/// The key in a film; `None` if there is no such file or it has no key.
pub fn key_of(path: &Path) -> Option<String> {
    // A film's facts stand at its beginning or, in some containers, at its end.
    const PART: u64 = 1 << 22;
    const KEY: usize = 64;
    let mut file = BufReader::new(File::open(path).ok()?);
    let length = file.get_ref().metadata().ok()?.len();
    [0, length.saturating_sub(PART)].into_iter().find_map(|start| {
        let mut part = Vec::new();
        file.seek(SeekFrom::Start(start)).ok()?;
        file.by_ref().take(PART).read_to_end(&mut part).ok()?;
        let name = FILM_KEY.as_bytes();
        let at = part.windows(name.len()).position(|piece| piece == name)? + name.len();
        let key = part.get(at + 1..at + 1 + KEY)?;
        key.iter().all(u8::is_ascii_hexdigit).then(|| String::from_utf8_lossy(key).into_owned())
    })
}

/// The frames of a film that is not whole yet, in a folder beside it.
pub struct Cache {
    folder: PathBuf,
    // Locked as long as it is open.
    _lock: File,
}

impl Cache {
    /// Opens the folder of the film at `path`, `empty` or with the frames that are there.
    ///
    /// # Errors
    /// There can be no such folder, or another process has it.
    pub fn open(path: &Path, empty: bool) -> Result<Cache, String> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let folder = path.with_file_name(format!(".{name}.frames"));
        let place = folder.display().to_string();
        let failed = |error: std::io::Error| format!("cannot make the folder `{place}`: {error}");
        fs::create_dir_all(&folder).map_err(failed)?;
        let lock = File::create(folder.join("lock")).map_err(failed)?;
        if let Err(fs::TryLockError::WouldBlock) = lock.try_lock() {
            return Err(format!("another process is making `{}`", path.display()));
        }
        let cache = Cache { folder, _lock: lock };
        for entry in fs::read_dir(&cache.folder).map_err(failed)?.flatten() {
            let name = entry.file_name();
            if name != "lock" && (empty || !name.to_string_lossy().ends_with(".png")) {
                // What cannot be removed is in nobody's way.
                let _ = fs::remove_file(entry.path());
            }
        }
        Ok(cache)
    }

    /// The names of its frames.
    pub fn pattern(&self) -> PathBuf {
        self.folder.join("frame.####.png")
    }

    /// Where the film is written before it takes its place.
    pub fn beside(&self) -> PathBuf {
        self.folder.join(format!("film.{}.tmp", std::process::id()))
    }

    /// Removes the folder with all that is in it.
    pub fn remove(self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}
