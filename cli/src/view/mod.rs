//! `kinora view`: a window that shows a scene while its text is being written.
//!
//! Three threads: [`watch`] reads the text whenever it changes, [`work`] renders, and the window, in the main thread,
//! keeps the state ([`model`]) and draws ([`overlay`], [`screen`]). They talk through the window's events and through
//! slots where the newest message wins, so that none ever waits for another.

mod app;
mod blit;
mod compare;
mod fit;
mod folders;
mod model;
mod orbit;
mod overlay;
mod pace;
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
mod watch;
mod work;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::exit::{self, Outcome};
use crate::flags::{PictureFlags, SceneFlags};
use crate::session::Kept;
use app::{App, Settings, Wake};
use photo::{After, Photo};
use watch::Watch;
use work::Desk;

/// How long a closed window waits for what is being rendered.
const FAREWELL: Duration = Duration::from_millis(500);

/// Watch a scene in a window while you write it.
///
/// Save the file, or a file that it uses, and the picture follows. Drag to turn the camera, with shift or the middle
/// button to move it, and scroll to come nearer; R goes back to the scene's camera, space plays.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneFlags,
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
    let backend = args.picture.open().map_err(|error| error.to_string())?;
    let events = EventLoop::<Wake>::with_user_event().build().map_err(no_window)?;

    let name = args.scene.file.file_name().unwrap_or(args.scene.file.as_os_str()).to_string_lossy().into_owned();
    let settings = Settings { title: format!("{name} — Kinora"), device: backend.device(), json: args.json };
    let after = args.after.unwrap_or(After::Samples(u32::MAX));
    let photo = args.screenshot.clone().map(|path| Photo { path, after, last: args.exit });
    let desk = Arc::new(Desk::default());
    let mut app = App::new(settings, desk.clone(), photo);

    let mut changes = args.scene.changes_with(&args.picture);
    changes.kept = Kept(Some(Arc::default()));
    let watch = Watch { path: args.scene.file.clone(), changes, poll: args.poll };
    let proxy = events.create_proxy();
    thread::spawn(move || watch.run(|load| proxy.send_event(Wake::Loaded(Box::new(load))).is_ok()));
    let (done, end) = channel::<()>();
    let (proxy, working) = (events.create_proxy(), desk.clone());
    thread::spawn(move || {
        let _dropped_at_the_end = done;
        // A window that is gone needs no pictures.
        work::run(backend, &working, &|| drop(proxy.send_event(Wake::Rendered)));
    });

    let ended = events.run_app(&mut app);
    desk.jobs.close();
    // Not for the work, but for the device, which is better not torn down under it.
    let _ = end.recv_timeout(FAREWELL);
    ended.map_err(no_window)?;
    app.error.map_or(Ok(exit::CLEAN), Err)
}

fn no_window(error: EventLoopError) -> String {
    let text = error.to_string();
    // winit puts the line of its own source before the cause.
    let cause = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(&*text, |(_, cause)| cause);
    format!("cannot open a window: {}", cause.trim_end_matches('.'))
}
