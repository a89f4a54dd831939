//! What a backend is: something that holds packed arrays and sums samples over them.

use std::{fmt, ops::Range, sync::Arc};

use glam::{UVec2, Vec4};
use kinora_kernel::{Invalid, Packed};

use crate::gpu::{Api, Demand, Gpu};
use crate::pack::Changes;

use crate::film::{Parts, Survey};

/// How a caller follows long work, and ends it.
pub trait Control {
    /// Called often, from the thread that asked for the work: `done` of the pass, in 0..=1. False ends it.
    fn keep_going(&self, done: f64) -> bool;
}

/// Work that nobody watches.
impl Control for () {
    fn keep_going(&self, _done: f64) -> bool {
        true
    }
}

impl<F: Fn(f64) -> bool> Control for F {
    fn keep_going(&self, done: f64) -> bool {
        self(done)
    }
}

/// Traces packed scenes. Two calls with the same arrays and samples give the same bits.
pub trait Backend: Send {
    /// `cpu` or `gpu`.
    fn name(&self) -> &'static str;

    /// The device, in words.
    fn device(&self) -> String;

    /// Takes the scene that the next passes show.
    ///
    /// # Errors
    /// The scene does not fit, or the device is lost. The scene before it stays.
    fn upload(&mut self, packed: Arc<Packed>) -> Result<(), BackendError>;

    /// Takes another scene, of which only these arrays are not as in the one that was taken last.
    ///
    /// # Errors
    /// As `upload`, but of the scene before it nothing need be left.
    fn update(&mut self, packed: Arc<Packed>, _changes: Changes) -> Result<(), BackendError> {
        self.upload(packed)
    }

    /// Whether a core of the host is to be left to others from the next pass on, if there are several. It changes no bit.
    fn leave_core(&mut self, _leave: bool) {}

    /// Lets go of arrays in the host's memory, so that they can be changed where they lie. What is called next is `update`.
    fn release(&mut self) {}

    /// One pass over the uploaded scene's window, row by row, or over these pixels of the picture alone: the sum of these
    /// samples in their order, one a pixel, w counting rays; `None` if `control` ended it. A pixel's sum is the same
    /// however it was asked for.
    ///
    /// # Errors
    /// Nothing was uploaded, or the device is lost.
    fn trace(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec4>>, BackendError>;

    /// As `trace`, with the light in parts.
    ///
    /// # Errors
    /// As `trace`.
    fn trace_parts(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Parts>>, BackendError>;

    /// As `trace`, but what these samples show instead of their light.
    ///
    /// # Errors
    /// As `trace`.
    fn survey(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Survey>>, BackendError>;
}

/// Why a backend cannot do its work.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum BackendError {
    /// There is no GPU that wgpu can use.
    NoAdapter,
    /// An array is larger than the device allows.
    TooLarge {
        /// Which array.
        what: &'static str,
        /// What it needs.
        bytes: u64,
        /// What the device allows.
        limit: u64,
        /// The device.
        adapter: String,
    },
    /// The device lacks something that the kernel needs.
    Unfit {
        /// The device.
        adapter: String,
        /// What it lacks.
        demand: Demand,
    },
    /// The arrays of a scene contradict each other: a fault of the program.
    Invalid(Invalid),
    /// The geometry lies so that its tree is too deep for a GPU, for example many shapes in the same place.
    TooDeep {
        /// Levels of the tree.
        depth: u32,
    },
    /// The device stopped working, or refused the work.
    Device(String),
    /// The threads could not be started.
    Threads(String),
    /// `trace` before `upload`.
    Nothing,
}

impl fmt::Display for BackendError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BackendError::NoAdapter => write!(f, "no GPU was found; `--backend cpu` needs none"),
            BackendError::TooLarge { what, bytes, limit, adapter } => {
                let mib = |b: u64| b as f64 / f64::from(1 << 20);
                write!(
                    f,
                    "the {what} need {:.1} MiB in one buffer, {adapter} allows {:.1} MiB",
                    mib(*bytes),
                    mib(*limit)
                )
            }
            BackendError::Unfit { adapter, demand: Demand { what, needed, allowed } } => {
                write!(f, "{adapter} cannot run the kernel: {needed} {what} are needed, it has {allowed}")
            }
            BackendError::Invalid(invalid) => write!(f, "the packed scene is wrong: {invalid}"),
            BackendError::TooDeep { depth } => {
                write!(f, "the tree over the shapes is {depth} levels deep, too many for a GPU; `--backend cpu` may do")
            }
            BackendError::Device(message) => write!(f, "the GPU stopped working: {message}"),
            BackendError::Threads(message) => write!(f, "cannot start the threads: {message}"),
            BackendError::Nothing => write!(f, "there is no scene to trace"),
        }
    }
}

impl std::error::Error for BackendError {}

/// Which backend a caller wants.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// A hardware GPU if there is one, else the CPU.
    #[default]
    Auto,
    /// The best GPU, also one in software.
    Gpu,
    /// The best GPU that this API reaches, also one in software.
    Api(Api),
    /// The CPU.
    Cpu,
}

/// How a backend is set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Of the CPU; 0 for one a core.
    pub threads: usize,
    /// Whether a GPU's shaders check every access to memory: slower, for finding faults of the kernel.
    pub checks: bool,
}

/// Checks in debug builds.
impl Default for Options {
    fn default() -> Self {
        Self { threads: 0, checks: cfg!(debug_assertions) }
    }
}

/// Opens a backend.
///
/// # Errors
/// The device is not there or does not start.
pub fn open(choice: Choice, options: Options) -> Result<Box<dyn Backend>, BackendError> {
    let Options { threads, checks } = options;
    let cpu = || Ok(Box::new(crate::cpu::Cpu::new(threads)?) as Box<dyn Backend>);
    let gpu = |gpu: Result<Gpu, BackendError>| Ok(Box::new(gpu?) as Box<dyn Backend>);
    match choice {
        Choice::Cpu => cpu(),
        Choice::Gpu => gpu(Gpu::any(None, checks)),
        Choice::Api(api) => gpu(Gpu::any(Some(api), checks)),
        Choice::Auto => gpu(Gpu::hardware(checks)).or_else(|_| cpu()),
    }
}
