//! Flags that several commands share.

use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Arg, ArgAction, ArgMatches, Command};
use kinora_lang::claims::pair;
use kinora_lang::diagnostic::{Level, Levels};

use crate::paths::{self, Search};
use crate::session::Changes;

/// A scene and what is changed in it.
#[derive(Clone, Debug, clap::Args)]
pub struct SceneFlags {
    /// The scene, a .kin file
    pub file: PathBuf,
    #[command(flatten)]
    pub values: ValueFlags,
}

/// What is changed in a scene.
#[derive(Clone, Debug, clap::Args)]
pub struct ValueFlags {
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
        self.values.changes()
    }
}

impl ValueFlags {
    /// What these flags change.
    pub fn changes(&self) -> Changes {
        Changes { params: self.define.clone(), sets: self.set.clone(), ..Changes::default() }
    }
}

/// Files and folders.
#[derive(Clone, Debug, clap::Args)]
pub struct FileFlags {
    /// Scenes, and folders to look for *.kin in; - is standard input
    #[arg(required = true)]
    pub paths: Vec<PathBuf>,
    /// Leave out what is named so in folders, as in .gitignore: --exclude 'old/**'
    #[arg(long, value_name = "PATTERN")]
    pub exclude: Vec<String>,
    /// Leave out what --exclude says also where it is named itself
    #[arg(long)]
    pub force_exclude: bool,
    /// Look also into what .gitignore leaves out
    #[arg(long)]
    pub no_ignore: bool,
    /// Finding no scene at all is fine
    #[arg(long)]
    pub allow_empty: bool,
}

impl FileFlags {
    /// The scenes that are meant.
    ///
    /// # Errors
    /// As [`paths::find`].
    pub fn find(&self) -> Result<Vec<PathBuf>, String> {
        let FileFlags { exclude, force_exclude, no_ignore, allow_empty, .. } = self.clone();
        paths::find(&self.paths, &Search { exclude, force_exclude, no_ignore, allow_empty })
    }
}

/// How warnings are taken: `--deny`, `--warn` and `--allow`, the last of which holds.
#[derive(Clone, Debug, Default)]
pub struct LevelFlags(pub Levels);

const LEVELS: [(&str, Level, &str); 3] = [
    ("deny", Level::Deny, "Take a warning, or all `warnings`, as errors: --deny warnings"),
    ("warn", Level::Warn, "Take a warning as one, whatever kinora.toml says"),
    ("allow", Level::Allow, "Leave out a warning: --allow W0201,W0202"),
];

impl clap::Args for LevelFlags {
    fn augment_args(command: Command) -> Command {
        let flag = |(name, _, help): (&'static str, Level, &'static str)| {
            Arg::new(name).long(name).value_name("CODE").value_delimiter(',').action(ArgAction::Append).help(help)
        };
        LEVELS.into_iter().fold(command, |command, row| command.arg(flag(row)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        LevelFlags::augment_args(command)
    }
}

impl clap::FromArgMatches for LevelFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<LevelFlags, clap::Error> {
        let mut said = Vec::new();
        for (name, level, _) in LEVELS {
            let words = matches.get_many::<String>(name).into_iter().flatten();
            said.extend(matches.indices_of(name).into_iter().flatten().zip(words).map(|at| (at, name, level)));
        }
        said.sort_by_key(|((at, _), ..)| *at);
        let mut levels = Levels::default();
        for ((_, word), name, level) in said {
            levels
                .set(word.trim(), level)
                .map_err(|message| clap::Error::raw(ErrorKind::ValueValidation, format!("--{name}: {message}\n")))?;
        }
        Ok(LevelFlags(levels))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = LevelFlags::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(feature = "render")]
pub use picture::*;

#[cfg(feature = "render")]
mod picture {
    use kinora_lang::claims::size;
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
        /// Take where bodies are as it is kept; a bake that is not there or not right is an error
        #[arg(long)]
        pub frozen_bake: bool,
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

    impl BackendName {
        /// Opens the backend, with so many threads if it is the CPU.
        ///
        /// # Errors
        /// There is no such device.
        pub fn open(self, threads: usize) -> Result<Box<dyn Backend>, BackendError> {
            let choice = match self {
                BackendName::Auto => Choice::Auto,
                BackendName::Gpu => Choice::Gpu,
                BackendName::Cpu => Choice::Cpu,
                BackendName::Vulkan => Choice::Api(Api::Vulkan),
                BackendName::Metal => Choice::Api(Api::Metal),
                BackendName::Dx12 => Choice::Api(Api::Dx12),
                BackendName::Gl => Choice::Api(Api::Gl),
            };
            kinora_renderer::open(choice, Options { threads, checks: gpu_checks() })
        }
    }

    impl PictureFlags {
        /// Opens the backend.
        ///
        /// # Errors
        /// There is no such device.
        pub fn open(&self) -> Result<Box<dyn Backend>, BackendError> {
            self.backend.open(self.threads)
        }
    }

    impl SceneFlags {
        /// What these flags and those of the picture change.
        pub fn changes_with(&self, picture: &PictureFlags) -> Changes {
            let PictureFlags { size, samples, camera, seed, frozen_bake, .. } = picture.clone();
            Changes { size, samples, camera, seed, frozen_bake, ..self.changes() }
        }
    }
}
