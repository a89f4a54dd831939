//! The one place where the crates meet: a path and the changes of the command line become a scene with its findings, a
//! scene and a shutter a world. Every command and the viewer go through here.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use kinora_animator::{Fault, Place, SampleError};
use kinora_lang::diagnostic::{Diagnostic, Style, render};
use kinora_lang::files::{self, Files, Folder};
use kinora_lang::source::{FileId, Source, Span};
use kinora_lang::{Evaluated, Overrides, Param};
use kinora_scene::{Scene, Shutter, World};

/// What the command line changes in a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Values of `param`s: name and text.
    pub params: Vec<(String, String)>,
    /// Properties: `node.property` and text.
    pub sets: Vec<(String, String)>,
    /// Width and height in pixels.
    pub size: Option<[u32; 2]>,
    /// Samples a pixel.
    pub samples: Option<u32>,
    /// Seed of the noise.
    pub seed: Option<u32>,
    /// Name of the camera.
    pub camera: Option<String>,
}

/// What comes of loading a scene.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene; `None` where a finding is an error.
    pub scene: Option<Arc<Scene>>,
    /// Its parameters.
    pub params: Vec<Param>,
    /// Errors and warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// The texts that the diagnostics point into, named as in the project.
    pub sources: Vec<Source>,
    /// Every file that was asked for, found or not, the scene itself first. Absolute.
    #[cfg_attr(not(feature = "viewer"), expect(dead_code, reason = "only the viewer watches files"))]
    pub dependencies: Vec<PathBuf>,
    path: PathBuf,
}
