//! Disks, cylinders, cones, capsules and rings: see shapes.wgsl of the kernel.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec3};
use kinora_kernel::generated::{
    LIGHT_OTHER, OTHER_CAPSULE, OTHER_CONE, OTHER_CYLINDER, OTHER_DISK, OTHER_FUNNEL, OTHER_TORUS, OTHER_TUBE,
};
use kinora_scene::{Shape, Still};

use super::geometry::{ellipsoid_area, normal_matrix};
use super::lights::{self, Light};

/// Such a shape in the world.
pub struct Other {
    /// OTHER_….
    pub kind: u32,
    /// Half the length of a capsule's side, or the radius of a ring's tube, in its own space.
    pub size: f64,
    /// From its own space.
    pub place: DAffine3,
}

/// Points of an integral round a circle; it converges faster than any power of them.
const STEPS: u32 = 256;

impl Other {
    /// `None` for shapes of another sort. `place`: from the space of the scene's shape to the world.
    pub fn new(shape: &Shape<Still>, place: DAffine3) -> Option<Other> {
        let scaled = |x: f64, y: f64| place * DAffine3::from_scale(DVec3::new(x, y, x));
        let (kind, size, place) = match *shape {
            Shape::Disk { frame, radius_m } => {
                let axes = DMat3::from_cols(frame.x, frame.z, -frame.y) * radius_m;
                (OTHER_DISK, 0.0, place * DAffine3::from_mat3(axes))
            }
            Shape::Cylinder { radius_m, height_m, capped } => {
                (if capped { OTHER_CYLINDER } else { OTHER_TUBE }, 0.0, scaled(radius_m, 0.5 * height_m))
            }
            Shape::Cone { radius_m, height_m, capped } => {
                let tip = DAffine3::from_translation(DVec3::Y * (0.5 * height_m));
                let size = DAffine3::from_scale(DVec3::new(radius_m, height_m, radius_m));
                (if capped { OTHER_CONE } else { OTHER_FUNNEL }, 0.0, place * tip * size)
            }
            Shape::Capsule { radius_m, height_m, capped: true } => {
                (OTHER_CAPSULE, (0.5 * height_m / radius_m - 1.0).max(0.0), scaled(radius_m, radius_m))
            }
            Shape::Capsule { radius_m, height_m, capped: false } => {
                (OTHER_TUBE, 0.0, scaled(radius_m, 0.5 * height_m - radius_m))
            }
            Shape::Torus { radius_m, tube_m } => (OTHER_TORUS, tube_m / radius_m, scaled(radius_m, radius_m)),
            _ => return None,
        };
        Some(Other { kind, size, place })
    }

    /// Areas in the world, m²: the side, the top, the bottom; of a capsule, the side and both round ends.
    pub fn areas(&self) -> [f64; 3] {
        let by_normal = normal_matrix(self.place) * self.place.matrix3.determinant().abs();
        // The area in the world over that of a piece whose normal is `n`.
        let stretch = |n: DVec3| (by_normal * n).length();
        let round = |of: &dyn Fn(f64, f64) -> f64| {
            let angles = (0..STEPS).map(|i| (TAU * (f64::from(i) + 0.5) / f64::from(STEPS)).sin_cos());
            angles.map(|(x, z)| of(x, z)).sum::<f64>() * TAU / f64::from(STEPS)
        };
        let end = PI * stretch(DVec3::Y);
        let side = |height: f64| height * round(&|x, z| stretch(DVec3::new(x, 0.0, z)));
        let slope = || 0.5 * round(&|x, z| stretch(DVec3::new(x, 1.0, z)));
        match self.kind {
            OTHER_DISK => [end, 0.0, 0.0],
            OTHER_CYLINDER => [side(2.0), end, end],
            OTHER_TUBE => [side(2.0), 0.0, 0.0],
            OTHER_CONE => [slope(), 0.0, end],
            OTHER_FUNNEL => [slope(), 0.0, 0.0],
            OTHER_CAPSULE => [side(2.0 * self.size), ellipsoid_area(self.place), 0.0],
            _ => {
                // Round the tube as far as it is outside.
                let tube = self.size;
                let last = if tube > 1.0 { (-1.0 / tube).acos() } else { PI };
                let ring = |angle: f64| {
                    let (up, out) = angle.sin_cos();
                    let width = tube * (1.0 + tube * out);
                    width * round(&|x, z| stretch(DVec3::new(x * out, up, z * out)))
                };
                let angle = |i: u32| last * (2.0 * (f64::from(i) + 0.5) / f64::from(STEPS) - 1.0);
                let sum: f64 = (0..STEPS).map(|i| ring(angle(i))).sum();
                [sum * 2.0 * last / f64::from(STEPS), 0.0, 0.0]
            }
        }
    }

    /// The light that it is; `power_per_m2` up to a factor.
    pub fn light(&self, shape: u32, power_per_m2: f64, bounds: [DVec3; 2]) -> Light {
        let areas = DVec3::from_array(self.areas());
        let area = areas.element_sum();
        let sizes = DVec3::new(self.place.matrix3.determinant().abs(), self.size, 0.0);
        let mut found = lights::other(
            LIGHT_OTHER,
            shape,
            self.place.translation,
            [sizes, areas / area],
            area * power_per_m2,
            bounds,
        );
        found.packed.kind.z = self.kind;
        found
    }
}
