//! glTF 2.0: `.gltf` and `.glb`, everything checked before anything is read.
//!
//! The file is kept as JSON. [`table`] and [`check`] hold it against the specification, as the Khronos validator does, so
//! that what comes after can follow every index; [`geometry`] and [`material`] make our types of it.

mod accessor;
mod build;
mod check;
mod clip;
mod container;
mod geometry;
mod json;
mod material;
mod table;

use std::collections::HashMap;
use std::sync::Arc;

use glam::DAffine3;
use kinora_scene::{Animated, Image, Influences, Material, Mesh, Placing, Target, Texels};
use serde_json::Value;

use super::picture;
use crate::files::{FileError, Files};
use accessor::Buffers;
use build::build;
pub use clip::{Channel, Clip, Moved};
use json::{index, list, text};

/// What is wrong with a model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// E07xx of files, E08xx of assets.
    pub code: &'static str,
    /// JSON pointer, or the byte of a GLB; empty for the whole.
    pub at: String,
    /// One clause.
    pub message: String,
    /// A way out.
    pub help: &'static str,
}

impl Fault {
    fn new(at: &str, message: impl Into<String>, help: &'static str) -> Fault {
        Fault { code: "E0801", at: at.to_string(), message: message.into(), help }
    }

    fn file(at: &str, error: &FileError) -> Fault {
        let help = match error {
            FileError::Missing { .. } | FileError::Case { .. } => "put the file there, or correct the `uri`",
            _ => "copy the file beside the model, and name it in `uri`",
        };
        Fault { code: error.code(), at: at.to_string(), message: error.message(), help }
    }
}

/// The faults of one model: the first ones in full, the rest by number.
#[derive(Debug, Default)]
pub struct Faults {
    first: Vec<Fault>,
    count: usize,
}

impl Faults {
    const MOST: usize = 8;

    fn push(&mut self, fault: Fault) {
        self.count += 1;
        if self.first.len() < Faults::MOST {
            self.first.push(fault);
        }
    }

    fn done(&mut self) -> Result<(), Faults> {
        // What a mesh cannot be made of comes before what the file says of itself.
        self.first.sort_by_key(|fault| fault.code != "E0803");
        if self.count > 0 { Err(std::mem::take(self)) } else { Ok(()) }
    }

    /// The first faults, at least one.
    pub fn first(&self) -> &[Fault] {
        &self.first
    }

    /// How many there are in all.
    pub fn count(&self) -> usize {
        self.count
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Faults {
        Faults { first: vec![fault], count: 1 }
    }
}

/// What a model has and is left out: what, what becomes of it, and how often.
#[derive(Debug, Default)]
pub struct Warnings(Vec<(String, &'static str, usize)>);

impl Warnings {
    pub(in crate::assets) fn add(&mut self, what: impl Into<String>, then: &'static str) {
        let what = what.into();
        match self.0.iter_mut().find(|(known, ..)| *known == what) {
            Some((.., count)) => *count += 1,
            None => self.0.push((what, then, 1)),
        }
    }

    /// Each kind once.
    pub fn iter(&self) -> impl Iterator<Item = &(String, &'static str, usize)> {
        self.0.iter()
    }
}

/// The scene of a glTF file.
#[derive(Debug, Default)]
pub struct Model {
    /// Parents before their children.
    pub nodes: Vec<Part>,
    /// Names of all meshes, with their triangles.
    pub meshes: Vec<(String, usize)>,
    /// What the parts refer to; what one is made of stands before it.
    pub materials: Vec<Material<Animated>>,
    /// Names of the file's own materials.
    pub material_names: Vec<String>,
    /// The animations.
    pub clips: Vec<Clip>,
    /// What is left out.
    pub warnings: Warnings,
}

/// A node of the file, or a part of one.
#[derive(Debug)]
pub struct Part {
    /// As in the file; where it has none there, kind and number.
    pub name: String,
    /// Names from the root of the scene, joined by `/`; none for what is not a node of the file.
    pub path: Option<String>,
    /// Index of the part that it moves with.
    pub parent: Option<usize>,
    /// How it is placed there.
    pub placing: Placing,
    /// Of what belongs to another part, whether it moves with it or not, that part.
    pub of: Option<usize>,
    /// Its triangles, as they are at rest, and their material.
    pub shape: Option<(Arc<Mesh>, usize)>,
    /// What changes its form.
    pub form: Option<Rig>,
    /// A camera in it.
    pub camera: Option<Lens>,
    /// A light in it.
    pub light: Option<Lamp>,
}

/// What changes a mesh's form where a clip moves it.
#[derive(Debug)]
pub struct Rig {
    /// Before anything is done to it.
    pub mesh: Arc<Mesh>,
    /// Morph targets, empty without.
    pub targets: Arc<Vec<Target>>,
    /// Their weights at rest.
    pub weights: Vec<f64>,
    /// Index of the part whose weights they are.
    pub part: usize,
    /// Joints, if it has a skin.
    pub skin: Option<Bones>,
}

/// The skin of a mesh.
#[derive(Debug)]
pub struct Bones {
    /// Indices of parts; none for what is not in the scene.
    pub joints: Vec<Option<usize>>,
    /// From the mesh to each joint.
    pub bind: Arc<Vec<DAffine3>>,
    /// What follows which.
    pub influences: Arc<Influences>,
}

/// A camera that looks along -z of its node.
#[derive(Debug, Clone)]
pub struct Lens {
    /// Of the camera; where it has none, of its node.
    pub name: String,
    /// How wide it sees.
    pub projection: Projection,
}

/// How the world falls on the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// Vertical field of view in radians.
    Perspective(f64),
    /// Metres across the picture's height.
    Orthographic(f64),
}

/// A light of KHR_lights_punctual; it shines along -z of its node.
#[derive(Debug, Clone)]
pub struct Lamp {
    /// Of the light; where it has none, of its node.
    pub name: String,
    /// Linear Rec. 709.
    pub color: [f64; 3],
    /// W/sr; of the sun W/m².
    pub intensity: f64,
    /// Which kind.
    pub kind: LampKind,
}

/// Kinds of lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LampKind {
    /// From infinitely far away.
    Sun,
    /// In all directions.
    Point,
    /// Within a cone: half angles in radians, to where it is full and to where it ends.
    Spot([f64; 2]),
}

/// Reads a model; `name` is its path from the project's root. Buffers and images beside it come through `files`.
///
/// # Errors
/// Everything that is wrong with it, as the Khronos validator would say, with JSON pointers.
pub fn read(name: &str, bytes: &[u8], files: &dyn Files) -> Result<Model, Faults> {
    let parts = container::open(name, bytes)?;
    let mut faults = Faults::default();
    table::check(&parts.root, &mut faults);
    check::asset(&parts.root, &mut faults);
    faults.done()?;
    check::document(&parts.root, &mut faults);
    let buffers = Buffers::read(&parts, name, files, &mut faults);
    faults.done()?;
    check::content(&parts.root, &buffers, &mut faults);
    faults.done()?;
    let mut images = Images { root: &parts.root, buffers: &buffers, name, files, known: HashMap::new(), bytes: 0 };
    images.check(&mut faults);
    faults.done()?;
    let mut model = Model::default();
    build(&parts.root, &buffers, &mut images, &mut model)?;
    Ok(model)
}

/// The pictures of a model, each decoded once.
struct Images<'m, 'b> {
    root: &'m Value,
    buffers: &'m Buffers<'b>,
    name: &'m str,
    files: &'m dyn Files,
    known: HashMap<usize, Result<Arc<Image>, Fault>>,
    bytes: u64,
}

impl Images<'_, '_> {
    /// Most bytes that the pictures of one model may take, decoded.
    const MOST: u64 = 1 << 30;

    /// Whether every picture that a texture shows can be decoded.
    fn check(&mut self, faults: &mut Faults) {
        for i in 0..list(self.root, "images").len() {
            // What lies elsewhere is a fault only where it is used.
            if let Err(fault) = self.get(i)
                && fault.code != "E0704"
                && !fault.at.is_empty()
            {
                faults.push(fault);
            }
        }
    }

    fn get(&mut self, at: usize) -> Result<Arc<Image>, Fault> {
        if let Some(image) = self.known.get(&at) {
            return image.clone();
        }
        let image = self.decode(at);
        self.known.insert(at, image.clone());
        image
    }

    fn decode(&mut self, at: usize) -> Result<Arc<Image>, Fault> {
        let pointer = format!("/images/{at}");
        let image = list(self.root, "images").get(at).unwrap_or(&Value::Null);
        let (file, own);
        let mut path = format!("{}{pointer}", self.name);
        let bytes: &[u8] = match text(image, "uri") {
            Some(written) => match container::uri(self.name, written, &format!("{pointer}/uri"))? {
                container::Uri::Data(_, data) => {
                    own = data;
                    &own
                }
                container::Uri::File(at) => {
                    path = at;
                    file = container::fetch(self.files, &path, &format!("{pointer}/uri"))?;
                    &file
                }
                container::Uri::Elsewhere => return Err(container::elsewhere(&format!("{pointer}/uri"), written)),
            },
            None => self.buffers.view(self.root, index(image, "bufferView").unwrap_or(usize::MAX))?,
        };
        let image = picture::read(&path, bytes).map_err(|error| Fault {
            code: error.code,
            at: pointer.clone(),
            message: error.message,
            help: "pictures of glTF are PNG, JPEG or WebP; export it again",
        })?;
        self.bytes += image.texels().len() as u64 * each(image.texels());
        if self.bytes > Images::MOST {
            let message = format!("the pictures take more than {} MiB", Images::MOST >> 20);
            return Err(Fault { code: "E0805", at: pointer, message, help: "make them smaller" });
        }
        Ok(Arc::new(image))
    }
}

/// Bytes of a texel.
fn each(texels: &Texels) -> u64 {
    match texels {
        Texels::Rgba8(_) => 4,
        Texels::Rgba16(_) => 8,
        Texels::Rgba32F(_) => 16,
    }
}
