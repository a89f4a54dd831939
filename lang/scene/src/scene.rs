//! The scene as its author wrote it, names resolved and expressions folded; only what depends on `time` is left open.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Animated, Color, Form, Image, Map, Mesh, Physics, Rate, Spectrum, Track};

/// A whole scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// How the picture is made.
    pub render: Render,
    /// Exposure and tone curve of display files.
    pub look: Look<Animated>,
    /// Frames and shutter.
    pub clock: Clock,
    /// Every camera, by declaration.
    pub cameras: Vec<Camera<Animated>>,
    /// Which of `cameras` takes the picture; none only where the scene has none.
    pub camera: Option<usize>,
    /// Groups and shapes, parents before their children.
    pub nodes: Vec<Node>,
    /// The materials that `nodes` refer to, what one is made of before itself.
    pub materials: Vec<Material<Animated>>,
    /// The light from infinitely far away.
    pub sky: Option<Sky<Animated>>,
    /// Suns and lamps that are no shapes of their own.
    #[serde(default)]
    pub lights: Vec<Light<Animated>>,
    /// Rigid bodies.
    #[serde(default)]
    pub physics: Physics,
}

/// How the picture is made; vocabulary.md, `render`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Render {
    /// Width and height in pixels, 1..=16384 each.
    pub resolution: [u32; 2],
    /// Samples a pixel, 1 or more: the most, where `adaptive` is above 0.
    pub samples: u32,
    /// Relative error (standard error / mean of a pixel's luminance) that is enough; 0 for the same samples everywhere.
    pub adaptive: f64,
    /// Samples before a pixel may have enough.
    pub min_samples: u32,
    /// Scatterings of one path: 0 = only emission seen directly.
    pub max_bounces: u32,
    /// Bounce from which Russian roulette may end a path.
    pub roulette_from: u32,
    /// Pixel filter.
    pub filter: Filter,
    /// Full width of the filter in pixels, above 0.
    pub filter_width: f64,
    /// Where the random numbers come from.
    pub sampler: Sampler,
    /// Another seed, another noise.
    pub seed: u32,
    /// How direct light is found.
    pub mis: Mis,
    /// The most that throughput · MIS weight may be where light is added, above 0; none leaves it unbiased.
    pub clamp: Option<f64>,
    /// What is where no shape is.
    pub background: Background,
    /// What the picture shows.
    pub view: Shown,
}

impl Default for Render {
    fn default() -> Self {
        Self {
            resolution: [1280, 720],
            samples: 128,
            adaptive: 0.0,
            min_samples: 16,
            max_bounces: 8,
            roulette_from: 4,
            filter: Filter::BlackmanHarris,
            filter_width: 1.5,
            sampler: Sampler::Sobol,
            seed: 0,
            mis: Mis::Nee,
            clamp: None,
            background: Background::Sky,
            view: Shown::Beauty,
        }
    }
}

/// The pixel filters; all separable and sampled by importance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Filter {
    /// Constant over the width.
    Box,
    /// σ = width / 6, cut at the ends.
    Gaussian,
    /// The four-term Blackman–Harris window.
    BlackmanHarris,
}

/// The sources of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sampler {
    /// Owen-scrambled Sobol points.
    Sobol,
    /// PCG hashes, independent.
    Random,
}

/// How direct light is found. All have the same mean; what one technique cannot find is left to the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mis {
    /// A light sample and a BSDF sample at every point, weighed by the power heuristic.
    Nee,
    /// One of the two, the light with this chance (0..=1), weighed by the balance heuristic.
    OneSample(f64),
}

impl Mis {
    /// BSDF samples alone.
    pub const BSDF: Mis = Mis::OneSample(0.0);
    /// Light samples alone.
    pub const LIGHT: Mis = Mis::OneSample(1.0);
}

/// What is where no shape is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Background {
    /// The sky.
    Sky,
    /// Nothing: alpha is 0 where only the sky is seen.
    Transparent,
}

/// What the picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shown {
    /// The light.
    Beauty,
    /// The colour of the first surface.
    Albedo,
    /// Its shading normal.
    Normal,
    /// The distance to it along the camera's axis.
    Depth,
    /// Which shape it is.
    Id,
    /// The samples that a pixel took.
    Samples,
    /// The rays that a pixel took.
    Cost,
    /// The boxes of the tree.
    Bvh,
}

/// What turns linear light into display values. EXR files do not see it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Look<R: Rate> {
    /// Stops: linear light · 2^exposure.
    pub exposure: R::Of<f64>,
    /// Tone curve.
    pub tonemap: Tonemap,
}

/// Tone curves; light-transport.md §16.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tonemap {
    /// Sobotka's AgX, base look, exact curve.
    Agx,
    /// Hill's fit of the ACES curve.
    Aces,
    /// x / (1 + x) a channel.
    Reinhard,
    /// Clipped to 0..=1.
    None,
}

/// Frames over time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Frames a second, above 0.
    pub fps: f64,
    /// Length in seconds, 0 or more.
    pub duration_s: f64,
    /// The part of a frame's interval during which the shutter is open, 0..=1 (the language's angle / 360°).
    pub shutter: f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { fps: 24.0, duration_s: 0.0, shutter: 0.0 }
    }
}

impl Clock {
    /// How many frames the scene has: ⌈duration · fps⌉ after rounding to 1e-6, and at least one.
    pub fn frame_count(&self) -> i64 {
        let frames = (self.duration_s * self.fps * 1e6).round() / 1e6;
        (frames.ceil() as i64).max(1)
    }

    /// The shutter of frame `frame`.
    pub fn shutter_of(&self, frame: i64) -> Shutter {
        self.shutter_at(frame as f64 / self.fps)
    }

    /// The shutter that opens at `time_s`.
    pub fn shutter_at(&self, time_s: f64) -> Shutter {
        Shutter { open_s: time_s, close_s: time_s + self.shutter / self.fps }
    }
}

/// When the shutter opens and closes, in seconds; `open_s <= close_s`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct Shutter {
    pub open_s: f64,
    pub close_s: f64,
}

/// A camera. It looks along its own −z, x to the right, y up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Camera<R: Rate> {
    /// The author's name, or the kind where there is none.
    pub name: String,
    /// The node it moves with.
    pub parent: Option<usize>,
    /// Where the eye is, in the parent's space.
    pub position: R::Of<DVec3>,
    /// Where it looks.
    pub aim: Aim<R>,
    /// How the world falls on the picture.
    pub projection: Projection<R>,
    /// Lens diameter in metres; 0 is a pinhole. Only a perspective has a lens.
    pub aperture_m: R::Of<f64>,
    /// Distance along the axis to the plane in focus, in metres. `None`: that of the point aimed at.
    pub focus_m: Option<R::Of<f64>>,
    /// The lens's edge.
    pub blades: Blades,
}

/// How the world falls on the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Projection<R: Rate> {
    /// Straight lines stay straight; what is far is small.
    Perspective {
        /// Field of view in radians, across the image's height; above 0, below π.
        fov: R::Of<f64>,
    },
    /// All rays are parallel to the axis.
    Orthographic {
        /// Metres across the image's height, above 0.
        height_m: f64,
    },
    /// All directions, equirectangular: longitude from −x over −z in the middle to +x, latitude from +y down to −y.
    Panorama,
    /// Equidistant: the distance from the picture's middle is proportional to the angle from the axis. The circle is as wide
    /// as the image is high, and outside of it is nothing.
    Fisheye {
        /// Field of view in radians, across the circle; above 0, at most 2π.
        fov: R::Of<f64>,
    },
}

/// The edge of a lens: a regular polygon inscribed in the circle of its aperture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Blades {
    /// Corners, 3 or more; 0: the circle itself.
    pub count: u32,
    /// Angle of the first corner, from +x towards +y, in radians.
    pub rotation: f64,
}

/// Where a camera looks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Aim<R: Rate> {
    /// As this rotation turns it.
    Rotation(R::Of<DQuat>),
    /// At a point of the parent's space.
    Point {
        /// The point.
        target: R::Of<DVec3>,
        /// What is up in the picture; not along the view.
        up: R::Of<DVec3>,
    },
    /// At a node's origin in the world.
    Node {
        /// Index into [`Scene::nodes`].
        target: usize,
        /// What is up in the picture; not along the view.
        up: R::Of<DVec3>,
    },
}

/// A shape, or a group that others move with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    /// The author's name, or the kind where there is none.
    pub name: String,
    /// Index of the node it moves with, smaller than its own.
    pub parent: Option<usize>,
    /// How it is placed in its parent.
    pub placing: Placing,
    /// Its geometry; none for a group.
    pub shape: Option<Shape<Animated>>,
    /// Of a mesh: how it changes its form.
    #[serde(default)]
    pub form: Option<Box<Form>>,
    /// Where its scale leaves no volume it is hidden, with what moves with it, as glTF wants it; else that is a mistake.
    #[serde(default)]
    pub vanishes: bool,
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Not there for any ray while false.
    pub visible: Track<bool>,
    /// What it shows once more.
    #[serde(default)]
    pub copies: Option<Box<Copies>>,
    /// Neither it nor what moves with it is seen itself: it is there for its copies.
    #[serde(default)]
    pub only_copied: bool,
}

/// A node once more, with all that moves with it: its geometry is there once, however many copies there are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Copies {
    /// Index of the node, which is copied as it is placed in its parent; its own `visible` does not count.
    pub of: usize,
    /// Where, in the space of the node that shows them. Not empty.
    pub at: Vec<Placement>,
    /// What all of it is made of, instead of its own: index into [`Scene::materials`].
    pub material: Option<usize>,
}

/// As [`Placing`], at all times.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Metres.
    pub position: DVec3,
    /// A unit quaternion.
    pub rotation: DQuat,
    /// One factor an axis, none 0.
    pub scale: DVec3,
}

impl Placement {
    /// Where its node is.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };
}

/// A point goes through `scale`, then `rotation`, then `position`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placing {
    /// Metres.
    pub position: Track<DVec3>,
    /// A unit quaternion.
    pub rotation: Track<DQuat>,
    /// One factor an axis, none 0.
    pub scale: Track<DVec3>,
}

impl Default for Placing {
    fn default() -> Self {
        Self { position: DVec3::ZERO.into(), rotation: DQuat::IDENTITY.into(), scale: DVec3::ONE.into() }
    }
}

/// Geometry in its own space, centred on its own origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Shape<R: Rate> {
    /// All points `radius_m` from the origin.
    Sphere {
        /// Above 0.
        radius_m: R::Of<f64>,
    },
    /// A box.
    Box {
        /// Lengths of the edges, above 0.
        size_m: DVec3,
    },
    /// A rectangle.
    Quad {
        /// Its axes.
        frame: Frame,
        /// Along `frame.x` and `frame.y`, above 0.
        size_m: DVec2,
    },
    /// A disk.
    Disk {
        /// Its axes.
        frame: Frame,
        /// Above 0.
        radius_m: f64,
    },
    /// A cylinder along y.
    Cylinder {
        /// Above 0.
        radius_m: f64,
        /// Above 0.
        height_m: f64,
        /// Whether its ends are closed.
        capped: bool,
    },
    /// A cone along y, its tip up.
    Cone {
        /// Of its base, above 0.
        radius_m: f64,
        /// Above 0.
        height_m: f64,
        /// Whether its base is closed.
        capped: bool,
    },
    /// A cylinder along y with round ends.
    Capsule {
        /// Above 0.
        radius_m: f64,
        /// Round ends included; twice the radius or more.
        height_m: f64,
        /// Whether the round ends are there; if not, the height must be more.
        capped: bool,
    },
    /// The infinite plane through the origin.
    Plane {
        /// Its axes.
        frame: Frame,
    },
    /// A ring about the y axis: all points `tube_m` from a circle, those outside alone where the tube is thicker than that.
    Torus {
        /// From the origin to the centre of the ring, above 0.
        radius_m: f64,
        /// Radius of the ring itself, above 0.
        tube_m: f64,
    },
    /// Triangles.
    Mesh(Arc<Mesh>),
}

impl<R: Rate> Shape<R> {
    /// Half of its extent along x, y and z about its own origin; `None` of planes, meshes, and where `known` does not tell a
    /// sphere's radius.
    pub fn half_size(&self, known: impl Fn(&R::Of<f64>) -> Option<f64>) -> Option<DVec3> {
        match self {
            Shape::Sphere { radius_m } => known(radius_m).map(DVec3::splat),
            Shape::Box { size_m } => Some(0.5 * *size_m),
            Shape::Quad { frame, size_m } => Some(0.5 * ((frame.x * size_m.x).abs() + (frame.y * size_m.y).abs())),
            Shape::Disk { frame, radius_m } => {
                Some(*radius_m * (DVec3::ONE - frame.z * frame.z).max(DVec3::ZERO).map(f64::sqrt))
            }
            Shape::Cylinder { radius_m, height_m, .. }
            | Shape::Cone { radius_m, height_m, .. }
            | Shape::Capsule { radius_m, height_m, .. } => Some(DVec3::new(*radius_m, 0.5 * height_m, *radius_m)),
            Shape::Torus { radius_m, tube_m } => Some(DVec3::new(radius_m + tube_m, *tube_m, radius_m + tube_m)),
            Shape::Plane { .. } | Shape::Mesh(_) => None,
        }
    }
}

/// The corners of a box about the origin, of half its size.
pub fn corners(half: DVec3) -> impl Iterator<Item = DVec3> {
    let sign = |bit: i32| if bit == 0 { -1.0 } else { 1.0 };
    (0..8).map(move |i| half * DVec3::new(sign(i & 1), sign(i & 2), sign(i & 4)))
}

/// An orthonormal right-handed frame of a flat shape: u runs along x, v along y, z is the normal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Width direction.
    pub x: DVec3,
    /// Height direction.
    pub y: DVec3,
    /// The normal.
    pub z: DVec3,
}

impl Frame {
    /// The frame of a `quad`, `disk` or `plane`: width along `up × normal`, height along `normal × width`; where the
    /// normal is ±`up`, width along +x. `None` if `normal` or `up` has no length, or the normal is ±`up` along x.
    pub fn facing(normal: DVec3, up: DVec3) -> Option<Frame> {
        let z = normal.try_normalize()?;
        let up = up.try_normalize()?;
        let across = up.cross(z);
        let x = if across.length() > 1e-6 {
            across.normalize()
        } else {
            (DVec3::X - z * DVec3::X.dot(z)).try_normalize()?
        };
        Some(Frame { x, y: z.cross(x), z })
    }

    /// The matrix whose columns are x, y and z.
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_cols(self.x, self.y, self.z)
    }
}

/// What a surface does with light; vocabulary.md, Materials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Material<R: Rate> {
    /// The share of rays that meet the surface, 0..=1; the others pass as if it were not there.
    pub opacity: R::Of<f64>,
    /// Where the opacity, maps included, is at least this it counts as 1, elsewhere as 0.
    pub cutoff: Option<f64>,
    /// Light that leaves the outer side besides, W/(m² sr), 0 or more; of glossy it is under the coat.
    pub emission: Color,
    /// What varies over the surface.
    pub maps: Vec<Map>,
    /// What happens to those that do.
    pub bsdf: Bsdf<R>,
}

/// The kinds of material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Bsdf<R: Rate> {
    /// A matt surface.
    Diffuse {
        /// Reflectance, 0..=1 a channel.
        color: R::Of<Color>,
        /// 0 (Lambert) ..= 1.
        roughness: R::Of<f64>,
        /// What becomes of it where it is rough.
        model: DiffuseModel,
    },
    /// A GGX conductor.
    Metal {
        /// How much it reflects at which angle.
        reflectance: Reflectance<R>,
        /// Perceptual, 0..=1; α = roughness².
        roughness: R::Of<f64>,
        /// 0 (round) ..= 1, stretched along the tangent.
        anisotropy: f64,
        /// Radians from the tangent, counter-clockwise.
        anisotropy_rotation: f64,
        /// Whether light scattered more than once in the microsurface is added (Kulla–Conty).
        energy_compensation: bool,
    },
    /// Glass, water, and the like.
    Dielectric {
        /// Refractive index of the inside, 1 or more.
        ior: R::Of<f64>,
        /// Perceptual, 0 (smooth) ..= 1; α = roughness².
        roughness: R::Of<f64>,
        /// Whether light scattered more than once in the microsurface is added.
        energy_compensation: bool,
        /// The colour of white light after `attenuation_distance_m`, 0..=1 a channel.
        attenuation_color: Color,
        /// Metres; infinite for clear glass.
        attenuation_distance_m: f64,
        /// A sheet without thickness: light goes straight through.
        thin: bool,
        /// Where media overlap the higher wins; of equals, the one entered last.
        priority: i32,
    },
    /// A dielectric coat over another material. What it lets through of an emitter's light shines.
    Glossy {
        /// Index of the material beneath, smaller than its own.
        base: usize,
        /// Refractive index of the coat, 1 or more.
        ior: f64,
        /// Of what the coat reflects where it is seen straight on, 0..=1 a channel; at grazing angles it is white.
        tint: R::Of<Color>,
        /// Of the coat, perceptual, 0..=1.
        roughness: R::Of<f64>,
        /// 0..=1: mixes in a metal of the base's colour and the coat's roughness.
        metalness: R::Of<f64>,
    },
    /// Fibres over another material, as of velvet and dust: they are bright at grazing angles.
    Sheen {
        /// Index of the material beneath, smaller than its own; its own light passes the fibres.
        base: usize,
        /// What the fibres reflect, 0..=1 a channel.
        color: R::Of<Color>,
        /// Perceptual, 0 (fibres that stand up straight) ..= 1.
        roughness: R::Of<f64>,
    },
    /// Two materials at once.
    Mix {
        /// Index of the first, smaller than its own.
        a: usize,
        /// Index of the second, smaller than its own.
        b: usize,
        /// The share of the second, 0..=1.
        amount: R::Of<f64>,
    },
    /// Light.
    Emitter {
        /// Scales `emission` by channel; 0 or more.
        color: R::Of<Color>,
        /// How much light.
        emission: Emission<R>,
        /// Whether the inner side shines too.
        two_sided: bool,
    },
}

impl<R: Rate> Bsdf<R> {
    /// Indices of the materials that it is made of; twice the same where it is one.
    pub fn parts(&self) -> Option<[usize; 2]> {
        match *self {
            Bsdf::Glossy { base, .. } | Bsdf::Sheen { base, .. } => Some([base; 2]),
            Bsdf::Mix { a, b, .. } => Some([a, b]),
            _ => None,
        }
    }
}

impl<R: Rate> From<Bsdf<R>> for Material<R>
where
    R::Of<f64>: From<f64>,
{
    /// An opaque material.
    fn from(bsdf: Bsdf<R>) -> Self {
        Material { opacity: 1.0.into(), cutoff: None, emission: Color::ZERO, maps: Vec::new(), bsdf }
    }
}

impl Material<Animated> {
    /// `diffuse {}`: what a shape without a material has.
    pub fn default_diffuse() -> Self {
        let (color, roughness) = (Color::splat(0.8).into(), 0.0.into());
        Bsdf::Diffuse { color, roughness, model: DiffuseModel::Eon }.into()
    }
}

/// Models of rough diffuse surfaces; light-transport.md §1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DiffuseModel {
    /// Energy-preserving Oren–Nayar (Portsmouth, Kutz and Hill 2025).
    Eon,
    /// Fujii's variant.
    Fon,
    /// The qualitative model, with σ = roughness · 90°.
    Qon,
}

/// How much a metal reflects at which angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Reflectance<R: Rate> {
    /// F82-tint (Kutz et al. 2021).
    Tint {
        /// At normal incidence, 0..=1 a channel.
        color: R::Of<Color>,
        /// Tint at 82°, 0..=1 a channel.
        edge_tint: R::Of<Color>,
    },
    /// As measured.
    Spectrum(Spectrum),
}

/// How much light an emitter gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Emission<R: Rate> {
    /// W/(m² sr), 0 or more.
    Radiance(R::Of<f64>),
    /// W over the whole surface in the world (both sides if two-sided), 0 or more.
    Power(R::Of<f64>),
}

/// The light from infinitely far away.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Sky<R: Rate> {
    /// Where it comes from.
    pub light: SkyLight<R>,
    /// Scales it; 0 or more.
    pub strength: R::Of<f64>,
    /// Whether the camera itself sees it.
    pub visible: bool,
}

/// What a sky shines with, before its strength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum SkyLight<R: Rate> {
    /// This radiance in every direction.
    Color(R::Of<Color>),
    /// A picture of all directions, equirectangular, 32-bit floats: its middle lies towards -z, right of it is +x, its
    /// top row is +y. Bilinear; what is negative or not a number is 0.
    Map {
        /// The picture.
        image: Arc<Image>,
        /// Radians, about +y.
        rotation: R::Of<f64>,
    },
    /// Single scattering in clear air and haze (Nishita et al. 1993), the sun's disc included; `strength` is the sun's
    /// irradiance above the air.
    Nishita {
        /// Radians above the horizon.
        sun_elevation: R::Of<f64>,
        /// Radians from -z towards +x.
        sun_azimuth: R::Of<f64>,
        /// Scales the haze; 0 or more.
        turbidity: R::Of<f64>,
    },
}

/// A light that is no shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Light<R: Rate> {
    /// The author's name, or the kind where there is none.
    pub name: String,
    /// The node it moves with.
    pub parent: Option<usize>,
    /// Scales its light by channel; 0 or more.
    pub color: Color,
    /// What it is.
    pub kind: LightKind<R>,
}

/// The kinds of light.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum LightKind<R: Rate> {
    /// Light from one direction.
    Sun {
        /// In which it travels, of any length but 0.
        direction: R::Of<DVec3>,
        /// Diameter of its disc in radians, below π; 0 is a point.
        angle: f64,
        /// W/m² on a surface facing it, whatever the angle; 0 or more.
        irradiance: R::Of<f64>,
    },
    /// Light in all directions.
    Point {
        /// Where it is.
        position: R::Of<DVec3>,
        /// W in all directions; 0 or more.
        power: R::Of<f64>,
        /// Metres; above 0 it is a sphere that is seen.
        radius_m: f64,
    },
    /// Light in a cone.
    Spot {
        /// Where it is.
        position: R::Of<DVec3>,
        /// Where it shines.
        aim: Beam<R>,
        /// W that it would send if it sent as much in all directions as along its axis; 0 or more.
        power: R::Of<f64>,
        /// Metres; above 0 it is a sphere that is seen.
        radius_m: f64,
        /// Full angle of the cone in radians, above 0, at most 2π.
        angle: f64,
        /// The soft part of the cone, 0..=1: intensity is scaled by smoothstep(cos(angle / 2), cos((1 - blend) · angle / 2),
        /// cos θ).
        blend: f64,
    },
}

/// Where a spot light shines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub enum Beam<R: Rate> {
    /// In this direction, of any length but 0.
    Direction(R::Of<DVec3>),
    /// At a point of the parent's space.
    Point(R::Of<DVec3>),
    /// At a node's origin in the world.
    Node(usize),
}
