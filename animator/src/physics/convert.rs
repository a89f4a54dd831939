//! Numbers of the scene, f64, to those of the solver, f32, and back.

use glam::{DQuat, DVec3};
use rapier3d::prelude::{Pose, Rotation, Vector};

pub fn single(v: DVec3) -> Vector {
    Vector::new(v.x as f32, v.y as f32, v.z as f32)
}

pub fn double(v: Vector) -> DVec3 {
    DVec3::new(v.x.into(), v.y.into(), v.z.into())
}

pub fn single_turn(q: DQuat) -> Rotation {
    Rotation::from_xyzw(q.x as f32, q.y as f32, q.z as f32, q.w as f32).normalize()
}

pub fn double_turn(q: Rotation) -> DQuat {
    DQuat::from_xyzw(q.x.into(), q.y.into(), q.z.into(), q.w.into()).normalize()
}

pub fn pose(position: DVec3, rotation: DQuat) -> Pose {
    Pose::from_parts(single(position), single_turn(rotation))
}
