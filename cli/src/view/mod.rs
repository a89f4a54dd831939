//! `kinora view`: a window that shows a scene while its text is being written.
//!
//! Four threads: [`watch`] reads the text whenever it changes or the window has another [`wish`], [`work`] renders,
//! [`panels::look`] says what is where in the picture when that is asked, and the window, in the main thread, keeps the
//! state ([`model`]) and draws ([`overlay`], [`panels`], [`screen`]). They talk through the window's events and through
//! slots where the newest message wins, so that none ever waits for another.

mod app;
mod blit;
mod compare;
mod crew;
mod fit;
mod folders;
mod model;
mod orbit;
mod overlay;
mod pace;
mod panels;
mod photo;
mod picture;
mod picture_bar;
mod reloads;
mod screen;
mod settle;
mod shown;
mod slot;
mod stamp;
mod timeline;
mod transport;
mod watch;
mod wish;
mod work;

use std::path::PathBuf;
use std::sync::Arc;
use std::thread;

use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::exit::{self, Outcome};
use crate::flags::{BackendName, PictureFlags, ValueFlags};
use crate::session::{Changes, Kept};
use app::{App, Settings, Wake};
use crew::Worker;
use kinora_renderer::BackendError;
use panels::Panels;
use panels::prefs::Prefs;
use photo::{After, Photo};
use watch::Watch;
use wish::{Desired, Wish};

/// Watch a scene in a window while you write it.
///
/// Save the file, or a file that it uses, and the picture follows. Drag to turn the camera, with shift or the middle
/// button to move it, and scroll to come nearer; R goes back to the scene's camera, space plays, ? shows all keys.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The scene, a .kin file; without one the window shows examples
    file: Option<PathBuf>,
    #[command(flatten)]
    values: ValueFlags,
    #[command(flatten)]
    picture: PictureFlags,
    /// Print a line of JSON on every reload: reload_ms, first_pixel_ms, errors, rebuilt, stages
    #[arg(long)]
    json: bool,
    /// Look at the files' dates instead of asking the system for changes: for network folders and containers
    #[arg(long)]
    poll: bool,
    /// Save what the window shows as a PNG
    #[arg(long, value_name = "FILE.png")]
    screenshot: Option<PathBuf>,
    /// When to save it: after so many samples a pixel (all of them), or after a time, such as 2s
    #[arg(long, value_name = "N|TIME", requires = "screenshot")]
    after: Option<After>,
    /// Close the window after the screenshot
    #[arg(long, requires = "screenshot")]
    exit: bool,
}

/// Opens the window and stays until it is closed.
///
/// # Errors
/// There is no display, no device that can draw a window, or no such backend.
pub fn run(args: &Args) -> Outcome {
    let mut picture = args.picture.clone();
    let mut alone = None;
    let backend = match picture.open() {
        // A window without a GPU is better than none.
        Err(BackendError::NoAdapter) if picture.backend != BackendName::Cpu => {
            alone = Some("No GPU was found: the CPU renders.");
            picture.backend = BackendName::Cpu;
            picture.open()
        }
        opened => opened,
    };
    let backend = backend.map_err(|error| error.to_string())?;
    if picture.backend == BackendName::Auto && backend.name() == "cpu" {
        alone = Some("No GPU was found: the CPU renders.");
    }
    let events = EventLoop::<Wake>::with_user_event().build().map_err(no_window)?;

    let PictureFlags { size, samples, camera, seed, frozen_bake, .. } = picture.clone();
    let kept = Kept(Some(Arc::default()));
    let changes = Changes { size, samples, camera, seed, frozen_bake, kept, ..args.values.changes() };
    let wish = Arc::new(Wish::new(Desired { path: args.file.clone(), changes, live: Vec::new() }));
    let after = args.after.unwrap_or(After::Samples(u32::MAX));
    let photo = args.screenshot.clone().map(|path| Photo { path, after, last: args.exit });
    let settings = Settings { device: backend.device(), json: args.json, picture, alone };
    let panels = Panels::new(wish.clone(), crew::look(events.create_proxy()), Prefs::load());
    let worker = Worker::start(backend, events.create_proxy());
    let mut app = App::new(settings, panels, worker, events.create_proxy(), photo);

    let watch = Watch { wish, poll: args.poll };
    let proxy = events.create_proxy();
    thread::spawn(move || watch.run(|load| proxy.send_event(Wake::Loaded(Box::new(load))).is_ok()));

    let ended = events.run_app(&mut app);
    app.farewell();
    ended.map_err(no_window)?;
    app.error.map_or(Ok(exit::CLEAN), Err)
}

fn no_window(error: EventLoopError) -> String {
    let text = error.to_string();
    // winit puts the line of its own source before the cause.
    let cause = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(&*text, |(_, cause)| cause);
    format!("cannot open a window: {}", cause.trim_end_matches('.'))
}
