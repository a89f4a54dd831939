//! The threads beside the window: who renders, who looks, who reads.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use kinora_renderer::Backend;
use winit::event_loop::EventLoopProxy;

use super::app::Wake;
use super::panels::device::Choice;
use super::panels::look::{self, Window};
use super::work::{self, Desk};
use crate::flags::PictureFlags;

/// How long a closed window waits for what is being rendered.
const FAREWELL: Duration = Duration::from_millis(500);

/// Who renders.
pub struct Worker {
    /// Where jobs are left and pictures fetched.
    pub desk: Arc<Desk>,
    end: Receiver<()>,
}

impl Worker {
    /// Starts on `backend`.
    pub fn start(backend: Box<dyn Backend>, proxy: EventLoopProxy<Wake>) -> Worker {
        let desk = Arc::new(Desk::default());
        let (done, end) = channel::<()>();
        let working = desk.clone();
        thread::spawn(move || {
            let _dropped_at_the_end = done;
            // A window that is gone needs no pictures.
            work::run(backend, &working, &|| drop(proxy.send_event(Wake::Rendered)));
        });
        Worker { desk, end }
    }

    /// Waits a moment for the end of the work: not for its sake, but for the device, which is better not torn down under it.
    pub fn farewell(&self) {
        self.desk.jobs.close();
        let _ = self.end.recv_timeout(FAREWELL);
    }
}

/// Another one takes its place.
impl Drop for Worker {
    fn drop(&mut self) {
        self.desk.jobs.close();
    }
}

/// Starts who looks what is where.
pub fn look(proxy: EventLoopProxy<Wake>) -> Arc<Window> {
    let window = Arc::new(Window::default());
    let looking = window.clone();
    thread::spawn(move || look::run(&looking, &|| drop(proxy.send_event(Wake::Looked))));
    window
}

/// Opens what is to render beside the window, as drivers take their time.
pub fn open(choice: Choice, picture: PictureFlags, proxy: EventLoopProxy<Wake>) {
    thread::spawn(move || {
        let backend = choice.open(&picture);
        let _ = proxy.send_event(Wake::Opened(choice, Box::new(backend)));
    });
}
