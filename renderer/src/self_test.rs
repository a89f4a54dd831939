//! Whether a device computes what it should: a picture of a few thousand samples whose every pixel is known.

use glam::{DAffine3, DVec3, Vec3};
use kinora_scene::{Bsdf, Color, Emission, Mesh, Shape, World};
use std::sync::Arc;

use crate::backend::Backend;
use crate::render::{RenderError, Renderer};
use crate::suite::{add, diffuse, glass, metal, quad, view, world};

/// What [`self_test`] may find on a sound device: the noise of the picture, with room to spare.
pub const SELF_TEST_TOLERANCE: f64 = 0.02;

/// Renders a room whose walls shine with radiance 1, and in it what keeps all light: a diffuse ball, a mesh, a mirror, glass.
/// Wherever one looks there is radiance 1. Gives how far a quarter of the picture is off in some channel.
///
/// # Errors
/// The backend fails.
pub fn self_test(backend: Box<dyn Backend>) -> Result<f64, RenderError> {
    let pixels = Renderer::new(backend).render(&room(), &())?.mean();
    let quarter = |i: usize| 2 * (i / SIZE / (SIZE / 2)) + i % SIZE / (SIZE / 2);
    let mut sums = [[0.0_f64; 3]; 4];
    for (i, pixel) in pixels.iter().enumerate() {
        for (sum, value) in sums[quarter(i)].iter_mut().zip(pixel.to_array()) {
            *sum += f64::from(value);
        }
    }
    let count = (SIZE * SIZE / 4) as f64;
    Ok(sums.as_flattened().iter().map(|sum| (sum / count - 1.0).abs()).fold(0.0, f64::max))
}

/// Pixels of a side.
const SIZE: usize = 32;

fn room() -> World {
    let mut w = world([SIZE as u32; 2], 16, view(DVec3::new(0.0, 0.0, 1.8), DVec3::ZERO, 0.9));
    w.render.max_bounces = 16;
    let place = |x, y| DAffine3::from_translation(DVec3::new(x, y, 0.0));
    let lit = Bsdf::Emitter { color: Color::ONE, emission: Emission::Radiance(1.0), two_sided: true }.into();
    add(&mut w, Shape::Box { size_m: DVec3::splat(4.0) }, DAffine3::IDENTITY, lit);
    let ball = || Shape::Sphere { radius_m: 0.4 };
    add(&mut w, ball(), place(-0.5, 0.5), diffuse(1.0, 0.0));
    add(&mut w, ball(), place(0.5, 0.5), metal(Color::ONE, 0.0));
    add(&mut w, ball(), place(0.5, -0.5), glass(1.5, Color::ONE, f64::INFINITY));
    let mesh = Mesh {
        positions: vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::splat(-0.5)],
        triangles: vec![[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]],
        ..Mesh::default()
    };
    let small = place(-0.5, -0.5) * DAffine3::from_scale(DVec3::splat(0.5));
    add(&mut w, Shape::Mesh(Arc::new(mesh)), small, diffuse(1.0, 0.5));
    add(&mut w, quad(DVec3::Y, 1.0, 1.0), place(0.0, -1.2), diffuse(1.0, 0.0));
    w
}
