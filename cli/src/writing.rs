//! Frames become files on a thread of their own, while the next one is rendered.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender};

use kinora_renderer::Film;
use kinora_scene::World;

use crate::encode::{self, Format, Stamp, Target};
use crate::films::{Head, Writer};

/// What is to be done, in the order of the frames.
pub enum Job {
    /// A frame becomes a file.
    Write(Box<Frame>),
    /// Its file is there already.
    There(PathBuf),
    /// It has none and gets none.
    Missing,
}

/// A frame and its file.
pub struct Frame {
    pub number: i64,
    pub film: Film,
    pub world: World,
    pub stamp: Stamp,
    pub target: Target,
}

/// What became of it.
pub enum Told {
    Written,
    /// This frame has no file: why.
    Failed(i64, String),
    /// There will be no film in one file, whatever comes: why.
    FilmFailed(String),
}

/// A film in one file that is made of the frames' files.
#[derive(Clone, Debug)]
pub struct OneFile {
    pub head: Head,
    pub beside: PathBuf,
}

/// Does all jobs; gives the film of all frames, as far as there is one and no frame is missing.
pub fn write_all(jobs: Receiver<Job>, told: &Sender<Told>, format: Format, film: Option<&OneFile>) -> Option<Writer> {
    // Threads of its own: in rayon's common ones the next frame's tree would wait behind this one's pixels.
    let cores = std::thread::available_parallelism().map_or(1, |cores| cores.get());
    match rayon::ThreadPoolBuilder::new().num_threads(cores.div_ceil(2)).build() {
        Ok(pool) => pool.install(|| each(jobs, told, format, film)),
        Err(_) => each(jobs, told, format, film),
    }
}

fn each(jobs: Receiver<Job>, told: &Sender<Told>, format: Format, film: Option<&OneFile>) -> Option<Writer> {
    // Nobody listens any more where this fails.
    let tell = |what| drop(told.send(what));
    let mut film = film.map(Reel::Waiting);
    for job in jobs {
        let path = match job {
            Job::There(path) => path,
            Job::Missing => {
                film = None;
                continue;
            }
            Job::Write(frame) => match write(&frame, format) {
                Ok(()) => {
                    tell(Told::Written);
                    frame.target.path().to_path_buf()
                }
                Err(why) => {
                    film = None;
                    tell(Told::Failed(frame.number, why));
                    continue;
                }
            },
        };
        film = match film.map(|reel| add(reel, &path)) {
            Some(Ok(writer)) => Some(Reel::Running(writer)),
            Some(Err(why)) => {
                tell(Told::FilmFailed(why));
                None
            }
            None => None,
        };
    }
    match film {
        Some(Reel::Running(writer)) => Some(writer),
        _ => None,
    }
}

enum Reel<'a> {
    Waiting(&'a OneFile),
    Running(Writer),
}

fn add(reel: Reel<'_>, path: &Path) -> Result<Writer, String> {
    let mut writer = match reel {
        Reel::Running(writer) => writer,
        Reel::Waiting(OneFile { head, beside }) => {
            let mut head = head.clone();
            // The first frame knows it, even where another run rendered it.
            const BACKEND: &str = "kinora:backend";
            head.facts.extend(encode::text_of_png(path, BACKEND).map(|backend| (BACKEND, backend)));
            Writer::begin(&head, beside)?
        }
    };
    writer.frame(path)?;
    Ok(writer)
}

fn write(frame: &Frame, format: Format) -> Result<(), String> {
    frame.target.write(&encode::encode(&frame.film, &frame.world, format, &frame.stamp)?)
}
