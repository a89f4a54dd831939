//! Ctrl-C and SIGTERM: the first one asks the work to end after the current tile, the second one ends the process at
//! once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::exit;

/// What has been asked for so far.
pub struct Stop(Arc<AtomicUsize>);

impl Stop {
    /// Listens from now on.
    ///
    /// # Errors
    /// The system lets nobody listen.
    pub fn listen() -> std::io::Result<Stop> {
        let (code, again) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for (signal, exit) in [(SIGINT, exit::INTERRUPTED), (SIGTERM, exit::STOPPED)] {
            // Handlers run in this order: a first signal finds `again` unset.
            flag::register_conditional_shutdown(signal, i32::from(exit), again.clone())?;
            flag::register(signal, again.clone())?;
            flag::register_usize(signal, code.clone(), usize::from(exit))?;
        }
        Ok(Stop(code))
    }

    /// The exit code to end with, if someone asked to stop.
    pub fn asked(&self) -> Option<u8> {
        u8::try_from(self.0.load(Ordering::Relaxed)).ok().filter(|code| *code != 0)
    }
}
