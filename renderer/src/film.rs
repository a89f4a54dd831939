//! The film: what all passes so far add up to.

use glam::{DVec3, Vec3, Vec4};

/// Sums of radiance, one a pixel, row by row from the top.
///
/// Passes are added in their order and in f64, each being an f32 sum over its samples, so that a film depends on which
/// samples it holds and on nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    samples: u32,
    rays: u64,
    sums: Vec<DVec3>,
}

impl Film {
    /// An empty film of `width` × `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, samples: 0, rays: 0, sums: vec![DVec3::ZERO; width as usize * height as usize] }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Samples a pixel so far: also the index of the next sample.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Rays traced so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Adds the next pass of `samples` samples: one sum a pixel, w counting rays.
    ///
    /// # Panics
    /// If `pass` is not one value a pixel.
    pub fn add(&mut self, pass: &[Vec4], samples: u32) {
        assert_eq!(pass.len(), self.sums.len(), "a pass has one sum a pixel");
        for (sum, part) in self.sums.iter_mut().zip(pass) {
            *sum += part.truncate().as_dvec3();
            self.rays += part.w as u64;
        }
        self.samples += samples;
    }

    /// Mean radiance, one a pixel; black before the first sample.
    pub fn mean(&self) -> Vec<Vec3> {
        let scale = 1.0 / f64::from(self.samples.max(1));
        self.sums.iter().map(|sum| (*sum * scale).as_vec3()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_the_mean_of_its_samples() {
        let mut film = Film::new(2, 1);
        assert_eq!(film.mean(), [Vec3::ZERO; 2]);
        film.add(&[Vec4::new(1.0, 2.0, 3.0, 5.0), Vec4::ZERO], 2);
        film.add(&[Vec4::new(3.0, 2.0, 1.0, 1.0), Vec4::ONE], 2);
        assert_eq!(film.mean(), [Vec3::ONE, Vec3::splat(0.25)]);
        assert_eq!((film.samples(), film.rays(), film.size()), (4, 7, [2, 1]));
    }
}
