//! The scene while the shutter is open: no tracks, every transform in the world.

use std::sync::Arc;

use glam::DAffine3;
use serde::{Deserialize, Serialize};

use crate::{Blades, Color, Light, Look, Material, Mesh, Projection, Render, Shape, Shutter, Sky, SkyLight, Still};

/// What the renderer draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct World {
    /// How the picture is made.
    pub render: Render,
    /// Exposure and tone curve of display files.
    pub look: Look<Still>,
    /// When the shutter is open.
    pub shutter: Shutter,
    /// The camera that takes the picture.
    pub view: View,
    /// The same camera at the next frame; `None` where nobody asks for motion. Then all that moves until then has a `next`.
    #[serde(default)]
    pub next: Option<View>,
    /// Every visible shape that is there once.
    pub instances: Vec<Instance>,
    /// What is there many times.
    #[serde(default)]
    pub copies: Vec<Copied>,
    /// What `copies` are copies of, each in a space of its own.
    #[serde(default)]
    pub parts: Vec<Part>,
    /// The materials that `instances` refer to, indexed as in the scene.
    pub materials: Vec<Material<Still>>,
    /// The light from infinitely far away, if any.
    pub sky: Option<Sky<Still>>,
    /// Suns and lamps, in the world: they have no parents, and spot lights have directions.
    #[serde(default)]
    pub lights: Vec<Lamp>,
    /// The same scene in the middle of each of so many equal steps of the time that the shutter is open; empty where it is
    /// open for no time or nothing moves meanwhile. All else in here is as it is when the shutter opens.
    #[serde(default)]
    pub moments: Arc<Vec<World>>,
}

/// A sun or lamp in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lamp {
    /// A number that no node of the scene has: what it is called where pictures show which thing is seen.
    pub node: usize,
    /// The light.
    pub light: Light<Still>,
    /// From where the points of its surface are to where they are at the next frame; `None`: they stay.
    #[serde(default)]
    pub next: Option<DAffine3>,
}

/// What is copied: shapes and lamps, and copies of other parts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Its visible shapes.
    pub instances: Vec<Instance>,
    /// What is there many times in it. No part is in itself.
    pub copies: Vec<Copied>,
    /// Its lamps.
    pub lights: Vec<Lamp>,
}

/// Copies of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Copied {
    /// Index of the scene's node that shows them.
    pub node: usize,
    /// What the first of them is called where pictures show which thing is seen; the others follow.
    pub first: usize,
    /// Index into [`World::parts`].
    pub part: usize,
    /// From the part's space to the world, or to the space of the part that they are in.
    pub places: Vec<DAffine3>,
    /// The same at the next frame; empty: they stay.
    #[serde(default)]
    pub next: Vec<DAffine3>,
    /// What all of it is made of, instead of its own: index into [`World::materials`].
    pub material: Option<usize>,
}

/// A camera in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Rotation and position, no scale. The camera looks along its own −z, x to the right, y up.
    pub world_from_camera: DAffine3,
    /// How the world falls on the picture.
    pub projection: Projection<Still>,
    /// Lens diameter in metres, 0 or more; 0 unless it is a perspective.
    pub aperture_m: f64,
    /// Distance along the axis to the plane in focus, in metres, above 0.
    pub focus_m: f64,
    /// The lens's edge.
    pub blades: Blades,
}

/// A shape in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    /// Index into the scene's nodes.
    pub node: usize,
    /// Its geometry.
    pub shape: Shape<Still>,
    /// From the shape's own space to the world, when the shutter opens. Not singular.
    pub world_from_object: DAffine3,
    /// The same at the next frame, a sphere's growth included; `None`: it stays.
    #[serde(default)]
    pub next: Option<DAffine3>,
    /// Its mesh at the next frame, of the same triangles; `None`: it keeps its form.
    #[serde(default)]
    pub next_mesh: Option<Arc<Mesh>>,
    /// Index into [`World::materials`].
    pub material: usize,
}

impl World {
    /// The radiance of a sky that is the same everywhere; the factor of any other; 0 where there is no sky.
    pub fn sky_radiance(&self) -> Color {
        self.sky.as_ref().map_or(Color::ZERO, |sky| match sky.light {
            SkyLight::Color(color) => color * sky.strength as f32,
            SkyLight::Map { .. } | SkyLight::Nishita { .. } => Color::splat(sky.strength as f32),
        })
    }
}
