//! What varies over a surface: pictures, patterns, and which property of a material they scale.

use std::sync::Arc;

use glam::{Vec2, Vec4};
use serde::{Deserialize, Serialize};

use crate::Tape;

/// One property of a material that a texture scales: at every point, the property's own value is multiplied by the
/// texture's. Several maps of one slot all multiply.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Map {
    /// Which property.
    pub slot: Slot,
    /// By what. A colour slot takes its red, green and blue, a ratio its red; see [`Channel`].
    pub texture: Arc<Texture>,
}

/// The properties that a texture can scale. A slot that the kind of material does not have is ignored.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Slot {
    /// diffuse, metal (at normal incidence), emitter: `color`. glossy: `tint`. dielectric: of white light that has passed a sheet, or gone
    /// into a body and out again.
    Color,
    /// metal: `edge_tint`.
    EdgeTint,
    /// diffuse, metal, dielectric, glossy: `roughness`, perceptual.
    Roughness,
    /// metal: `anisotropy`.
    Anisotropy,
    /// metal: which way it is stretched and how far, as KHR_materials_anisotropy has it. Red and green are a direction of the
    /// tangent plane, each stored as (x + 1) / 2, to which `anisotropy_rotation` is added. Blue scales `anisotropy`, which then
    /// means that α is widened along that direction to mix(α, 1, anisotropy²) and kept across it.
    Stretch,
    /// glossy: `metalness`.
    Metalness,
    /// mix: `amount`.
    Amount,
    /// All: `opacity`; before [`crate::Material::cutoff`] decides.
    Opacity,
    /// All: [`crate::Material::emission`].
    Emission,
    /// All: the shading normal, in tangent space: x along growing u, y along growing v, z outwards, each stored as
    /// (x + 1) / 2. It replaces the normal instead of scaling it.
    Normal {
        /// Scales x and y: 0 is no map, 1 the map as it is.
        strength: f64,
    },
}

/// A colour or a number for every point of a surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Texture {
    /// A picture.
    Image(ImageTexture),
    /// Squares of two kinds; the one at uv (0, 0) is `a`.
    Checker {
        /// Squares whose two indices have an even sum.
        a: Paint,
        /// The others.
        b: Paint,
        /// Squares a unit of u and of v.
        scale: Vec2,
        /// Which coordinates of a mesh.
        uv_set: UvSet,
    },
    /// What a tape comes to, of 3 outputs for a colour or 1 for a number; clamped where it leaves what the slot takes, and
    /// 0 where it is not finite. It must fit: see [`crate::Program`].
    Tape(Tape),
    /// The colours of a mesh's vertices, interpolated; white where it has none.
    VertexColor {
        /// What of them.
        channel: Channel,
    },
}

/// What a square of a checker is filled with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Paint {
    /// A colour: linear Rec. 709 and opacity.
    Color(Vec4),
    /// Another texture.
    Texture(Arc<Texture>),
}

/// A picture, and how it is read: at `offset + rotation · (scale · uv)`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageTexture {
    /// The picture; one that several textures read is stored once.
    pub image: Arc<Image>,
    /// How its red, green and blue are encoded; alpha never is.
    pub space: ColorSpace,
    /// What is outside of 0..1, along u and along v.
    pub wrap: [Wrap; 2],
    /// What is between texels.
    pub filter: TexelFilter,
    /// Along u and v; 2 repeats the picture twice.
    pub scale: Vec2,
    /// Added last, in widths and heights of the picture.
    pub offset: Vec2,
    /// Radians, counter-clockwise.
    pub rotation: f64,
    /// What of it is read.
    pub channel: Channel,
    /// Which coordinates of a mesh.
    pub uv_set: UvSet,
    /// Where scale, offset and rotation change over time, the five numbers, in this order. Not in a world.
    #[serde(default)]
    pub moving: Option<Arc<Tape>>,
}

impl Texture {
    /// Whether it changes over time.
    pub fn moves(&self) -> bool {
        let inside = |paint: &Paint| matches!(paint, Paint::Texture(inside) if inside.moves());
        match self {
            Texture::Tape(tape) => tape.moves(),
            Texture::Image(image) => image.moving.is_some(),
            Texture::Checker { a, b, .. } => inside(a) || inside(b),
            _ => false,
        }
    }
}

impl ImageTexture {
    /// The whole picture once over 0..1, repeated, bilinear, as a colour.
    pub fn new(image: Arc<Image>, space: ColorSpace) -> Self {
        Self {
            image,
            space,
            wrap: [Wrap::Repeat; 2],
            filter: TexelFilter::Linear,
            scale: Vec2::ONE,
            offset: Vec2::ZERO,
            rotation: 0.0,
            channel: Channel::Color,
            uv_set: UvSet::First,
            moving: None,
        }
    }
}

/// How numbers stand for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ColorSpace {
    /// sRGB-encoded (IEC 61966-2-1).
    Srgb,
    /// As they are.
    Linear,
}

/// What a picture shows outside of 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wrap {
    /// Itself again.
    Repeat,
    /// Itself, every second time mirrored.
    Mirror,
    /// Its edge.
    Clamp,
}

/// What is between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TexelFilter {
    /// Bilinear, in linear light.
    Linear,
    /// The nearest texel.
    Nearest,
}

/// What of a texture is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// Red, green and blue.
    Color,
    /// Red, in all three.
    R,
    /// Green, in all three.
    G,
    /// Blue, in all three.
    B,
    /// Alpha, in all three.
    A,
}

/// Which of a mesh's texture coordinates; other shapes have one set only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum UvSet {
    /// [`crate::Mesh::uvs`].
    First,
    /// [`crate::Mesh::more_uvs`].
    Second,
}

/// A picture. Scenes are written without its texels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Where it came from, for messages: a path in the project.
    pub name: String,
    /// Texels in a row, 1 or more.
    pub width: u32,
    /// Rows, 1 or more.
    pub height: u32,
    /// Of `texels`, so that scenes with different pictures differ when they are written.
    digest: u64,
    #[serde(skip)]
    texels: Texels,
}

/// The texels of an image, row by row, the top row first: red, green, blue, alpha (not premultiplied).
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 255 is 1.
    Rgba8(Vec<[u8; 4]>),
    /// 65535 is 1.
    Rgba16(Vec<[u16; 4]>),
    /// Any finite number.
    Rgba32F(Vec<[f32; 4]>),
}

impl Default for Texels {
    fn default() -> Self {
        Texels::Rgba8(Vec::new())
    }
}

impl Texels {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Texels::Rgba8(texels) => texels.len(),
            Texels::Rgba16(texels) => texels.len(),
            Texels::Rgba32F(texels) => texels.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What they take, in bytes.
    pub fn bytes(&self) -> u64 {
        let each = match self {
            Texels::Rgba8(_) => 4,
            Texels::Rgba16(_) => 8,
            Texels::Rgba32F(_) => 16,
        };
        self.len() as u64 * each
    }

    // FNV-1a over the words of all texels.
    fn digest(&self) -> u64 {
        let fold = |words: &mut dyn Iterator<Item = u64>| {
            words.fold(0xcbf2_9ce4_8422_2325, |hash: u64, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3))
        };
        match self {
            Texels::Rgba8(texels) => fold(&mut texels.iter().map(|t| u64::from(u32::from_le_bytes(*t)))),
            Texels::Rgba16(texels) => {
                fold(&mut texels.iter().map(|t| t.iter().rev().fold(0, |word, &c| word << 16 | u64::from(c))))
            }
            Texels::Rgba32F(texels) => fold(&mut texels.iter().flatten().map(|c| u64::from(c.to_bits()))),
        }
    }
}

/// Texels are numbers: a picture is equal to itself, so that one in the memory need not be looked at twice.
impl Eq for Image {}

impl Image {
    /// A picture of `width` times `height` texels; `None` if there are not so many, or none.
    pub fn new(name: impl Into<String>, width: u32, height: u32, texels: Texels) -> Option<Image> {
        let fits = !texels.is_empty() && texels.len() as u64 == u64::from(width) * u64::from(height);
        fits.then(|| Image { name: name.into(), width, height, digest: texels.digest(), texels })
    }

    /// Row by row, the top row first.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// A number that tells different texels apart, almost surely.
    pub fn digest(&self) -> u64 {
        self.digest
    }
}
