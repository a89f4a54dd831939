//! What can be wrong with a scene at one instant.

use std::fmt;

/// Why a scene has no picture at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleError {
    /// Whose property it is.
    pub place: Place,
    /// The name of the node, camera or setting; of a material, that of the first node that has it, or nothing.
    pub name: String,
    /// The property, as the language calls it.
    pub property: &'static str,
    /// When, in seconds from the start of the scene.
    pub time_s: f64,
    /// What is wrong with it.
    pub fault: Fault,
}

/// A part of a scene that has properties. Indices are those of the scene's own lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Place {
    Node(usize),
    Material(usize),
    Camera(usize),
    Light(usize),
    Sky,
    Render,
}

/// What is wrong with a property.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// It is NaN or infinite.
    NotFinite,
    /// It lies outside what it may be.
    OutOfRange {
        /// What it is.
        value: f64,
        /// What it may be, in words that follow "must be".
        range: &'static str,
    },
    /// It makes a transform without an inverse: something is flattened, or smaller or larger than numbers go.
    Singular,
    /// The camera is to look at the place where it is.
    AimedAtItself,
    /// It has no length: it says no direction.
    NoDirection,
    /// It has no length or lies along the camera's view.
    UpAlongView,
    /// It refers to a node, material or camera that is not there, or a parent to a later node.
    Dangling,
    /// It is needed: the camera has a lens and looks at no point.
    NoFocus,
    /// The scene has no camera.
    NoCamera,
    /// Its keys begin later or end sooner, and have no value outside.
    OutsideKeys,
}

impl fmt::Display for SampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.fault == Fault::NoCamera {
            return write!(f, "the scene has no camera");
        }
        write!(f, "`{}` of ", self.property)?;
        match self.place {
            Place::Material(index) if self.name.is_empty() => write!(f, "material {index}")?,
            Place::Material(_) => write!(f, "the material of `{}`", self.name)?,
            _ => write!(f, "`{}`", self.name)?,
        }
        match self.fault {
            Fault::NotFinite => write!(f, " is not a finite number")?,
            Fault::OutsideKeys => write!(f, " has no key before or after this time, and `outside: error`")?,
            Fault::OutOfRange { value, range } => write!(f, " is {value} and must be {range}")?,
            Fault::Singular => write!(f, " leaves no volume")?,
            Fault::AimedAtItself => write!(f, " is the camera's own position")?,
            Fault::NoDirection => write!(f, " has no length")?,
            Fault::UpAlongView => write!(f, " has no length or lies along the view")?,
            Fault::Dangling => write!(f, " refers to what is not there")?,
            Fault::NoFocus | Fault::NoCamera => write!(f, " is needed by a lens that looks at no point")?,
        }
        write!(f, ", at {} s", (self.time_s * 1e6).round() / 1e6)
    }
}

impl std::error::Error for SampleError {}
