//! A camera in the hand: it turns about a point, moves across the picture, and nears what it looks at.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use kinora_scene::{Aim, Projection, Scene, Shutter, View};

/// How near to straight up or down the view may turn, in radians.
const POLE: f64 = 1e-3;
/// Looking around is slower than turning about what is seen.
const LOOK: f64 = 0.5;
/// How near to and how far from the pivot the eye may be, in metres.
const REACH_M: std::ops::RangeInclusive<f64> = 1e-4..=1e7;

/// A view and the point that it turns about, which lies on the camera's axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// The camera.
    pub view: View,
    /// Distance from the eye to the pivot along the axis, in metres.
    pub distance_m: f64,
}

/// The scene's own camera during `shutter`; it turns about the point that it looks at, else about the one in focus.
/// `None` where the scene has no picture at that time.
pub fn begin(scene: &Scene, shutter: Shutter) -> Option<Orbit> {
    let shutter = Shutter { close_s: shutter.open_s, ..shutter };
    let view = kinora_animator::sample(scene, shutter).ok()?.view;
    let distance_m = aimed_m(scene, shutter).unwrap_or(view.focus_m);
    Some(Orbit { view, distance_m: distance_m.clamp(*REACH_M.start(), *REACH_M.end()) })
}

/// How far the point is that the camera looks at.
fn aimed_m(scene: &Scene, shutter: Shutter) -> Option<f64> {
    let index = scene.camera?;
    if matches!(scene.cameras.get(index)?.aim, Aim::Rotation(_)) {
        return None;
    }
    // Without a focus of its own, a camera is focused on what it looks at.
    let mut scene = scene.clone();
    scene.cameras[index].focus_m = None;
    kinora_animator::sample(&scene, shutter).ok().map(|world| world.view.focus_m)
}

impl Orbit {
    fn axes(&self) -> DMat3 {
        self.view.world_from_camera.matrix3
    }

    /// The point that it turns about.
    pub fn pivot(&self) -> DVec3 {
        self.view.world_from_camera.translation - self.axes().z_axis * self.distance_m
    }

    /// Turns by a drag, given in heights of the picture, to the right and down: a whole height is half a turn. What was
    /// dragged follows the hand.
    pub fn turn(&mut self, drag: [f64; 2]) {
        let pivot = self.pivot();
        let axes = DMat3::from_quat(DQuat::from_rotation_y(-drag[0] * PI)) * self.axes();
        let tilted = DMat3::from_quat(DQuat::from_axis_angle(axes.x_axis.normalize_or(DVec3::X), -drag[1] * PI)) * axes;
        // Steeper than the poles allow is taken only on the way back, and never across.
        let height = |axes: DMat3| axes.z_axis.y.clamp(-1.0, 1.0).asin().abs();
        let upright = tilted.y_axis.y * axes.y_axis.y >= 0.0;
        let tilts = upright && (height(tilted) <= FRAC_PI_2 - POLE || height(tilted) < height(axes));
        let axes = orthonormal(if tilts { tilted } else { axes });
        self.view.world_from_camera = DAffine3::from_mat3_translation(axes, pivot + axes.z_axis * self.distance_m);
    }

    /// Moves across the picture by a drag, given in heights of the picture, to the right and down. What lies at the
    /// pivot's distance follows the hand.
    pub fn pan(&mut self, drag: [f64; 2]) {
        // In the middle of the picture.
        let height_m = match self.view.projection {
            Projection::Perspective { fov } => 2.0 * self.distance_m * (fov * 0.5).tan(),
            Projection::Orthographic { height_m } => height_m,
            Projection::Panorama => self.distance_m * PI,
            Projection::Fisheye { fov } => self.distance_m * fov,
        };
        let axes = self.axes();
        self.view.world_from_camera.translation += (axes.y_axis * drag[1] - axes.x_axis * drag[0]) * height_m;
    }

    /// Looks around from where the eye is, by a drag given in heights of the picture, to the right and down: the view turns
    /// to where the hand goes. The pivot comes along.
    pub fn look(&mut self, drag: [f64; 2]) {
        let eye = self.view.world_from_camera.translation;
        // Seen from the eye the world turns the other way than round the pivot.
        self.turn([drag[0] * LOOK, drag[1] * LOOK]);
        self.view.world_from_camera.translation = eye;
    }

    /// Flies so many metres to the right, up and forward, as the camera sees it. What is in focus comes along.
    pub fn fly(&mut self, way_m: DVec3) {
        let eye = self.view.world_from_camera.translation + self.axes() * DVec3::new(way_m.x, way_m.y, -way_m.z);
        if eye.is_finite() && eye.abs().max_element() <= *REACH_M.end() {
            self.view.world_from_camera.translation = eye;
        }
    }

    /// Focuses on what is so far away along the axis, in metres.
    pub fn focus(&mut self, depth_m: f64) {
        if REACH_M.contains(&depth_m) {
            self.view.focus_m = depth_m;
        }
    }

    /// Goes along the axis until the pivot is `factor` times as far away. What is in focus stays in focus. Where nearness
    /// makes nothing larger, the picture spans less.
    pub fn dolly(&mut self, factor: f64) {
        let distance_m = self.distance_m * factor;
        if !REACH_M.contains(&distance_m) {
            return;
        }
        let back_m = distance_m - self.distance_m;
        let axis = self.axes().z_axis;
        self.view.world_from_camera.translation += axis * back_m;
        self.view.focus_m = (self.view.focus_m + back_m).max(*REACH_M.start());
        self.distance_m = distance_m;
        if let Projection::Orthographic { height_m } = &mut self.view.projection {
            *height_m = (*height_m * factor).clamp(*REACH_M.start(), *REACH_M.end());
        }
    }
}

/// Takes away what rounding added to a rotation.
fn orthonormal(axes: DMat3) -> DMat3 {
    DMat3::from_quat(DQuat::from_mat3(&axes).normalize())
}

#[cfg(test)]
mod tests {
    use kinora_scene::Blades;

    use super::*;

    fn orbit() -> Orbit {
        let world_from_camera = DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0));
        let projection = Projection::Perspective { fov: FRAC_PI_2 };
        let view = View { world_from_camera, projection, aperture_m: 0.1, focus_m: 6.0, blades: Blades::default() };
        Orbit { view, distance_m: 5.0 }
    }

    fn eye(orbit: &Orbit) -> DVec3 {
        orbit.view.world_from_camera.translation
    }

    #[track_caller]
    fn close(got: DVec3, expected: DVec3) {
        assert!(got.distance(expected) < 1e-9, "{got} is not {expected}");
    }

    #[test]
    fn turning_goes_round_the_pivot() {
        // (drag, where the eye comes to be)
        for (drag, expected) in [
            ([0.0, 0.0], DVec3::new(0.0, 0.0, 5.0)),
            ([0.5, 0.0], DVec3::new(-5.0, 0.0, 0.0)),
            ([-1.0, 0.0], DVec3::new(0.0, 0.0, -5.0)),
            ([0.0, 0.25], DVec3::new(0.0, 5.0, 5.0) * 0.5_f64.sqrt()),
            ([0.0, -0.25], DVec3::new(0.0, -5.0, 5.0) * 0.5_f64.sqrt()),
        ] {
            let mut orbit = orbit();
            orbit.turn(drag);
            close(eye(&orbit), expected);
            close(orbit.pivot(), DVec3::ZERO);
        }
    }

    #[test]
    fn the_poles_are_not_crossed() {
        let mut orbit = orbit();
        for step in 0..1000 {
            orbit.turn([0.013, if step % 7 == 0 { 0.3 } else { 0.02 }]);
            assert!(orbit.axes().y_axis.y > 0.0, "upside down after {step} steps");
        }
        assert!(orbit.axes().z_axis.y > 0.99);
        assert!((orbit.axes().determinant() - 1.0).abs() < 1e-12);
        orbit.turn([0.0, -0.25]);
        assert!(orbit.axes().z_axis.y < 0.8, "the way back is open");
    }

    #[test]
    fn flying_goes_where_the_camera_looks() {
        let mut orbit = orbit();
        orbit.fly(DVec3::new(1.0, 2.0, 3.0));
        close(eye(&orbit), DVec3::new(1.0, 2.0, 2.0));
        // A quarter turn to the right: forward is along +x.
        orbit.look([1.0, 0.0]);
        close(eye(&orbit), DVec3::new(1.0, 2.0, 2.0));
        orbit.fly(DVec3::new(0.0, 0.0, 3.0));
        close(eye(&orbit), DVec3::new(4.0, 2.0, 2.0));
        assert_eq!(orbit.view.focus_m, 6.0);
        orbit.fly(DVec3::new(f64::NAN, 0.0, 0.0));
        close(eye(&orbit), DVec3::new(4.0, 2.0, 2.0));
        orbit.focus(2.5);
        orbit.focus(-1.0);
        orbit.focus(f64::INFINITY);
        assert_eq!(orbit.view.focus_m, 2.5);
    }

    #[test]
    fn panning_follows_the_hand() {
        let mut orbit = orbit();
        orbit.pan([0.5, 0.25]);
        close(eye(&orbit), DVec3::new(-5.0, 2.5, 5.0));
    }

    #[test]
    fn every_projection_is_in_the_hand() {
        // (projection, how far a drag of a height goes)
        for (projection, expected) in [
            (Projection::Orthographic { height_m: 3.0 }, 3.0),
            (Projection::Panorama, 5.0 * PI),
            (Projection::Fisheye { fov: 2.0 }, 10.0),
        ] {
            let mut orbit = orbit();
            orbit.view.projection = projection;
            orbit.pan([0.0, 1.0]);
            close(eye(&orbit), DVec3::new(0.0, expected, 5.0));
        }
        let mut orbit = orbit();
        orbit.view.projection = Projection::Orthographic { height_m: 3.0 };
        orbit.dolly(0.5);
        close(eye(&orbit), DVec3::new(0.0, 0.0, 2.5));
        assert_eq!(orbit.view.projection, Projection::Orthographic { height_m: 1.5 });
    }

    #[test]
    fn dollying_keeps_the_focus_where_it_was() {
        let mut orbit = orbit();
        orbit.dolly(0.5);
        close(eye(&orbit), DVec3::new(0.0, 0.0, 2.5));
        assert_eq!((orbit.view.focus_m, orbit.distance_m), (3.5, 2.5));
        for factor in [0.0, -1.0, 1e300, f64::NAN] {
            let before = orbit.clone();
            orbit.dolly(factor);
            assert_eq!(orbit, before);
        }
    }
}
