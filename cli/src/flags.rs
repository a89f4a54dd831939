//! Flags that several commands share.

use std::path::PathBuf;

use crate::session::Changes;

/// A scene and what is changed in it.
#[derive(Clone, Debug, clap::Args)]
pub struct SceneFlags {
    /// The scene, a .kin file
    pub file: PathBuf,
    /// Give a `param` of the scene another value, written as in the scene: -D count=40
    #[arg(short = 'D', value_name = "NAME=VALUE", value_parser = pair)]
    pub define: Vec<(String, String)>,
    /// Give a property another value: --set render.max_bounces=2
    #[arg(long, value_name = "NODE.PROPERTY=VALUE", value_parser = pair)]
    pub set: Vec<(String, String)>,
}

impl SceneFlags {
    /// What these flags change.
    pub fn changes(&self) -> Changes {
        Changes { params: self.define.clone(), sets: self.set.clone(), ..Changes::default() }
    }
}

fn pair(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => Ok((name.trim().into(), value.trim().into())),
        _ => Err("write a name, `=` and a value".into()),
    }
}

#[cfg(feature = "render")]
pub use picture::*;

#[cfg(feature = "render")]
mod picture {
    use kinora_renderer::{Backend, BackendError, Choice, Options, gpu::Api};

    use super::SceneFlags;
    use crate::session::Changes;

    /// How a picture is made.
    #[derive(Clone, Debug, clap::Args)]
    pub struct PictureFlags {
        /// Width and height in pixels: --size 640x360
        #[arg(long, value_name = "WxH", value_parser = size)]
        pub size: Option<[u32; 2]>,
        /// Samples a pixel
        #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
        pub samples: Option<u32>,
        /// The camera that takes the picture
        #[arg(long, value_name = "NAME")]
        pub camera: Option<String>,
        /// Another seed gives another noise
        #[arg(long, value_name = "N")]
        pub seed: Option<u32>,
        /// What does the work
        #[arg(long, value_enum, default_value_t)]
        pub backend: BackendName,
        /// Threads of the CPU backend; 0 is one a core
        #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
        pub threads: usize,
    }

    /// The names of the backends.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
    pub enum BackendName {
        /// A hardware GPU if there is one, else the CPU
        #[default]
        Auto,
        /// Any GPU, also one in software
        Gpu,
        /// The CPU
        Cpu,
        /// Any GPU, through Vulkan
        Vulkan,
        /// Any GPU, through Metal
        Metal,
        /// Any GPU, through Direct3D 12
        Dx12,
        /// Any GPU, through OpenGL
        Gl,
    }

    /// Whether the shaders of a GPU check every access to memory: as `KINORA_GPU_CHECKS` says, else in debug builds.
    pub fn gpu_checks() -> bool {
        match std::env::var("KINORA_GPU_CHECKS").as_deref() {
            Ok("1") => true,
            Ok("0") => false,
            _ => Options::default().checks,
        }
    }

    impl PictureFlags {
        /// Opens the backend.
        ///
        /// # Errors
        /// There is no such device.
        pub fn open(&self) -> Result<Box<dyn Backend>, BackendError> {
            let choice = match self.backend {
                BackendName::Auto => Choice::Auto,
                BackendName::Gpu => Choice::Gpu,
                BackendName::Cpu => Choice::Cpu,
                BackendName::Vulkan => Choice::Api(Api::Vulkan),
                BackendName::Metal => Choice::Api(Api::Metal),
                BackendName::Dx12 => Choice::Api(Api::Dx12),
                BackendName::Gl => Choice::Api(Api::Gl),
            };
            kinora_renderer::open(choice, Options { threads: self.threads, checks: gpu_checks() })
        }
    }

    impl SceneFlags {
        /// What these flags and those of the picture change.
        pub fn changes_with(&self, picture: &PictureFlags) -> Changes {
            let PictureFlags { size, samples, camera, seed, .. } = picture.clone();
            Changes { size, samples, camera, seed, ..self.changes() }
        }
    }

    fn size(text: &str) -> Result<[u32; 2], String> {
        let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
        let sides = text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([side(w)?, side(h)?]));
        sides.ok_or_else(|| "write width x height, each 1 to 16384: 640x360".into())
    }
}
