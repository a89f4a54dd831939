//! What a scene means, as plain data: the author's [`Scene`], whose values may move, and the [`World`], the scene at one
//! instant of a frame, where nothing moves any more.
//!
//! Both are built from the same types, written once over a [`Rate`]: `Material<Animated>` holds [`Track`]s,
//! `Material<Still>` holds plain values. This crate knows no parser, no GPU and no file.
//!
//! Lengths are metres, angles radians, times seconds, colours linear Rec. 709, radiance W/(m² sr); the world is
//! right-handed with y up.

mod form;
mod mesh;
mod noise;
mod physics;
mod program;
mod rate;
mod scene;
mod spectrum;
mod tape;
mod texture;
mod track;
mod world;

pub use form::{Form, Influences, Morph, Skin, Target};
pub use mesh::{Mesh, MeshError};
pub use noise::{cellular_noise, gradient_noise};
pub use physics::{Baked, BakedBody, Body, BodyKind, Collider, Joint, JointKind, Mass, Physics, Pose, Simulation};
pub use program::{Operand, Operation, Program, STEPS, Step, Unfit, VALUES};
pub use rate::{Animated, Rate, Still};
pub use scene::*;
pub use spectrum::Spectrum;
pub use tape::{Binary, Cell, Instruction, Orient, Point, Rand, Register, Tape, Unary};
pub use texture::{
    Channel, ColorSpace, Image, ImageTexture, Map, Paint, Slot, TexelFilter, Texels, Texture, UvSet, Wrap,
};
pub use track::{Bezier, Direction, Ease, Family, Jump, Key, Keys, Outside, Spring, Track, Value, Way};
pub use world::*;

/// A colour: linear Rec. 709 red, green and blue, each 0 or more.
pub type Color = glam::Vec3;
