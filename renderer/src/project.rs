//! Where the camera's projection shows a point: the inverse of `camera.wgsl`, without its lens.

use std::f64::consts::PI;

use glam::{DAffine3, DVec2, DVec3};
use kinora_scene::{Projection, Still, View};

/// A camera and its picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Projector {
    camera_from_world: DAffine3,
    projection: Projection<Still>,
    picture: DVec2,
}

impl Projector {
    /// What `view` shows in a picture of `width` × `height` pixels.
    pub fn new(view: &View, [width, height]: [u32; 2]) -> Self {
        Self {
            camera_from_world: view.world_from_camera.inverse(),
            projection: view.projection.clone(),
            picture: DVec2::new(width.into(), height.into()),
        }
    }

    /// How the world falls on the picture.
    pub fn projection(&self) -> &Projection<Still> {
        &self.projection
    }

    /// A point of the world in the camera's space; the camera looks along its own -z.
    pub fn in_camera(&self, p: DVec3) -> DVec3 {
        self.camera_from_world.transform_point3(p)
    }

    /// A point of the camera's space in the picture, in pixels from its top left corner; it may lie outside. `None` where
    /// the projection shows nothing: behind a perspective's eye.
    pub fn point(&self, p: DVec3) -> Option<DVec2> {
        let aside = DVec2::new(p.x, -p.y);
        // From the middle, in heights.
        let at = match self.projection {
            Projection::Perspective { fov } if p.z < 0.0 => aside / (-2.0 * p.z * (0.5 * fov).tan()),
            Projection::Perspective { .. } => return None,
            Projection::Orthographic { height_m } => aside / height_m,
            Projection::Panorama => {
                let aspect = self.picture.x / self.picture.y;
                let latitude = p.y.atan2(DVec2::new(p.x, p.z).length());
                DVec2::new(p.x.atan2(-p.z) / (2.0 * PI) * aspect, -latitude / PI)
            }
            Projection::Fisheye { fov } => aside.normalize_or_zero() * (aside.length().atan2(-p.z) / fov),
        };
        let at = at * self.picture.y + 0.5 * self.picture;
        at.is_finite().then_some(at)
    }

    /// As [`Projector::point`], of what is infinitely far away in a direction of the world; orthographic cameras show none.
    pub fn direction(&self, d: DVec3) -> Option<DVec2> {
        match self.projection {
            Projection::Orthographic { .. } => None,
            _ => self.point(self.camera_from_world.transform_vector3(d)),
        }
    }

    /// The way in pixels from one place in the picture to another: in a panorama, round the nearer side.
    pub fn way(&self, from: DVec2, to: DVec2) -> DVec2 {
        let mut way = to - from;
        if matches!(self.projection, Projection::Panorama) {
            way.x -= (way.x / self.picture.x).round() * self.picture.x;
        }
        way
    }
}
