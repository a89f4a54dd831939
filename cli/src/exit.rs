//! The exit codes, the same for every command.

/// Done, nothing to complain about.
pub const CLEAN: u8 = 0;
/// The scene is at fault.
pub const FINDINGS: u8 = 1;
/// The program could not do its work: flags, files, device, or a fault of its own.
pub const FAILED: u8 = 2;
/// SIGTERM or a lost device: what is finished stays.
#[cfg(any(feature = "render", feature = "physics"))]
pub const STOPPED: u8 = 75;
/// Ctrl-C.
#[cfg(any(feature = "render", feature = "physics"))]
pub const INTERRUPTED: u8 = 130;

/// What a command comes back with: an exit code, or why it could not do its work, which is shown and ends in
/// [`FAILED`].
pub type Outcome = Result<u8, String>;
