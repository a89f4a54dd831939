//! A [`World`](kinora_scene::World) to pixels. [`pack()`] lays the scene out in flat arrays, a [`Backend`] traces them,
//! a [`Film`] collects the passes, [`develop()`] makes display values of it.
//!
//! Two backends run the same kernel: [`cpu`], its Rust translation over all cores, and [`gpu`], its WGSL through wgpu.
//! A pixel is a function of world, settings, pixel and sample index: the same bits on the same backend, whatever the
//! threads, tiles or interruptions.

mod adaptive;
pub mod backend;
pub mod cpu;
mod develop;
mod film;
pub mod gpu;
mod moments;
mod motion;
mod pack;
mod project;
mod render;
mod self_test;
pub mod suite;
mod wires;

pub use backend::{Backend, BackendError, Choice, Control, Options, open};
pub use develop::{Image, develop, measure};
pub use film::{Film, Light, Parts, Request, Seen, Survey, TooLarge, Window};
pub use pack::{Changes, PackError, pack};
pub use render::{RenderError, Renderer};
pub use self_test::{SELF_TEST_TOLERANCE, self_test};
