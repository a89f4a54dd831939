//! Rigid bodies: what the author says of them, and what became of them.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Everything that only a simulation sees. Without bodies, nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Physics {
    /// How it runs.
    pub simulation: Simulation,
    /// The bodies, by node; no node has two.
    pub bodies: Vec<Body>,
    /// What holds them together.
    pub joints: Vec<Joint>,
    /// Where the dynamic bodies are at all times, once that is computed. It follows from the rest of the scene.
    #[serde(skip)]
    pub baked: Option<Arc<Baked>>,
}

impl Physics {
    /// Whether anything is moved by forces, so that there is something to compute.
    pub fn is_dynamic(&self) -> bool {
        self.bodies.iter().any(|body| body.kind == BodyKind::Dynamic)
    }
}

/// How a simulation runs; vocabulary.md, Physics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Simulation {
    /// Acceleration of all dynamic bodies, m/s².
    pub gravity: DVec3,
    /// Steps a second, above 0.
    pub rate_hz: f64,
    /// Seconds from 0 until everything rests; 0 or more.
    pub duration_s: f64,
    /// Where the result is kept: a path in the project.
    pub bake: String,
}

impl Default for Simulation {
    fn default() -> Self {
        Self { gravity: DVec3::new(0.0, -9.81, 0.0), rate_hz: 240.0, duration_s: 0.0, bake: String::new() }
    }
}

impl Simulation {
    /// How many steps it takes: ⌈duration · rate⌉ after rounding to 1e-6.
    pub fn step_count(&self) -> u64 {
        ((self.duration_s * self.rate_hz * 1e6).round() / 1e6).ceil().max(0.0) as u64
    }
}

/// A node as a rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Index into [`crate::Scene::nodes`].
    pub node: usize,
    /// What moves it.
    pub kind: BodyKind,
    /// How heavy it is.
    pub mass: Mass,
    /// Of its surface, 0 or more. A contact has the mean of two bodies.
    pub friction: f64,
    /// 0 (a dead stop) ..= 1 (no loss). A contact has the mean of two bodies.
    pub restitution: f64,
    /// At the start, m/s in the world.
    pub velocity: DVec3,
    /// At the start, rad/s about each axis of the world.
    pub angular_velocity: DVec3,
    /// The velocity falls by e^(−damping · t); 1/s, 0 or more.
    pub linear_damping: f64,
    /// The angular velocity falls by e^(−damping · t); 1/s, 0 or more.
    pub angular_damping: f64,
    /// The shape that meets others.
    pub collider: Collider,
    /// A push at the centre of mass, N·s in the world.
    pub impulse: DVec3,
    /// When, in seconds; 0 or more.
    pub impulse_at_s: f64,
}

/// What moves a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BodyKind {
    /// Forces.
    Dynamic,
    /// Nothing.
    Fixed,
    /// The tracks of its node, whatever is in the way.
    Kinematic,
}

/// How heavy a body is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mass {
    /// kg/m³ of its collider, above 0.
    Density(f64),
    /// kg, above 0.
    Total(f64),
}

/// The shape that a body meets others with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Collider {
    /// What is closest: a primitive of a primitive, hulls of the convex parts of a mesh, all of a model.
    Auto,
    /// The box about it.
    Box,
    /// The sphere about it.
    Sphere,
    /// A capsule about it, along its longest axis.
    Capsule,
    /// A cylinder about it, along y.
    Cylinder,
    /// The hull.
    ConvexHull,
    /// Its triangles. They have no inside, so a dynamic body cannot have them.
    Mesh,
}

/// What holds two bodies together. The two do not collide, but for those of a spring.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// The author's name, or the kind where there is none.
    pub name: String,
    /// The node of one body.
    pub a: usize,
    /// The node of the other.
    pub b: usize,
    /// Where they meet, in the world at 0 s; none: at the origin of `a`.
    pub anchor: Option<DVec3>,
    /// How they may move.
    pub kind: JointKind,
}

/// How the bodies of a joint may move. Angles and ways are those of `b` as seen from `a`, 0 at 0 s; angles count
/// counter-clockwise when the axis points at you.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// They turn about the anchor.
    Ball,
    /// They turn about an axis through the anchor.
    Hinge {
        /// Of any length but 0, in the world at 0 s.
        axis: DVec3,
        /// Smallest and largest angle in radians.
        limits: Option<[f64; 2]>,
        /// rad/s, kept up whatever it takes.
        motor_velocity: Option<f64>,
    },
    /// They slide along an axis.
    Slider {
        /// Of any length but 0, in the world at 0 s.
        axis: DVec3,
        /// Smallest and largest way in metres.
        limits: Option<[f64; 2]>,
        /// m/s, kept up whatever it takes.
        motor_velocity: Option<f64>,
    },
    /// A spring from the anchor, which is a point of `a`, to the origin of `b`.
    Spring {
        /// Metres at rest, 0 or more; none: as it is at 0 s.
        length_m: Option<f64>,
        /// N/m, 0 or more.
        stiffness: f64,
        /// N·s/m, 0 or more.
        damping: f64,
    },
}

/// Where the dynamic bodies are at each step.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// Seconds from one step to the next, above 0.
    pub step_s: f64,
    /// What positions are measured from.
    pub origin: DVec3,
    /// The bodies, in ascending order.
    pub bodies: Vec<BakedBody>,
    /// At 0 s the poses of all bodies, then those after each step: at least once all.
    pub poses: Vec<Pose>,
}

/// A body of a [`Baked`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakedBody {
    /// Index into [`crate::Scene::nodes`].
    pub node: usize,
    /// From the node's own space to that of its poses: what it is scaled and sheared by, and what of its place at 0 s the
    /// pose leaves out.
    pub pose_from_node: DAffine3,
}

/// A rotation and a place, without scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres from the origin of its bake.
    pub position: [f32; 3],
    /// A unit quaternion: x, y, z, w.
    pub rotation: [f32; 4],
}

impl Pose {
    /// The position as it is.
    pub fn place(&self) -> DVec3 {
        DVec3::from_array(self.position.map(f64::from))
    }

    /// The rotation, of unit length.
    pub fn turn(&self) -> DQuat {
        DQuat::from_array(self.rotation.map(f64::from)).normalize()
    }
}
