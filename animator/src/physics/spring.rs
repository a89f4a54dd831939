//! Springs as forces, half of a step's push before it and half after (velocity Verlet): what swings on them keeps its
//! energy. The solver's own springs lose some with each step, but hold however stiff they are.

use glam::DVec3;
use rapier3d::prelude::{PhysicsWorld, RigidBody, RigidBodySet};
use serde::{Deserialize, Serialize};

use super::convert::{double, double_turn, single};
use super::plan::{Plan, PlannedJoint};
use super::world::handle;

/// The phase, in radians, that a spring may run through in a step: its period is then right to 1 part in 10 000.
const SLOW: f64 = 0.05;

/// The most that it may run through; at 2 it would fly apart.
const STABLE: f64 = 0.5;

/// A spring between two bodies.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Spring {
    /// Their indices.
    pub bodies: [usize; 2],
    /// Its ends, in the space of each.
    pub at: [DVec3; 2],
    /// Metres at rest.
    pub length: f64,
    /// N/m.
    pub stiffness: f64,
    /// N·s/m.
    pub damping: f64,
    /// What it moves, in kg, as the bodies are at 0 s.
    pub mass: f64,
}

/// An end of a spring.
struct End {
    place: DVec3,
    velocity: DVec3,
    /// From the centre of mass.
    arm: DVec3,
}

fn end(body: &RigidBody, local: DVec3) -> End {
    let arm = double_turn(*body.rotation()) * (local - double(body.local_center_of_mass()));
    let velocity = double(body.linvel()) + double(body.angvel()).cross(arm);
    End { place: double(body.center_of_mass()) + arm, velocity, arm }
}

/// How much faster a push of 1 N·s along `along` makes a point of a body, 1/kg.
pub fn give(body: &RigidBody, arm: DVec3, along: DVec3) -> f64 {
    if !body.is_dynamic() {
        return 0.0;
    }
    let properties = &body.mass_properties().local_mprops;
    let axes = double_turn(*body.rotation()) * double_turn(properties.principal_inertia_local_frame);
    let torque = arm.cross(along);
    let local = axes.inverse() * torque;
    f64::from(properties.inv_mass) + local.dot(double(properties.inv_principal_inertia) * local)
}

/// A spring of a plan: `[length, stiffness, damping]`, a length below 0 being that at 0 s.
pub fn new(
    world: &PhysicsWorld,
    joint: &PlannedJoint,
    plan: &Plan<'_>,
    [length, stiffness, damping]: [f64; 3],
) -> Spring {
    let (a, b) = (&plan.bodies[joint.a], &plan.bodies[joint.b]);
    let at = [a.rotation.inverse() * (joint.anchor - a.position), DVec3::ZERO];
    let way = b.position - joint.anchor;
    let along = way.normalize_or(DVec3::Y);
    let bodies = [joint.a, joint.b];
    let pulled = |index: usize, place: DVec3| {
        let body = world.bodies.get(handle(index));
        body.map_or(0.0, |body| give(body, place - plan.origin - double(body.center_of_mass()), along))
    };
    let give = pulled(joint.a, joint.anchor) + pulled(joint.b, b.position);
    let length = if length < 0.0 { way.length() } else { length };
    Spring { bodies, at, length, stiffness, damping, mass: give.recip() }
}

impl Spring {
    /// Into how many a step has to be cut for the swing to be slow beside it, at `rate` steps a second.
    pub fn cuts(&self, rate: f64) -> f64 {
        ((self.stiffness / self.mass).sqrt() / (SLOW * rate)).ceil().max(1.0)
    }

    /// Makes it no stiffer than steps of this rate can follow: it then gives way by no more than can be seen.
    pub fn soften(&mut self, rate: f64) {
        self.stiffness = self.stiffness.min(self.mass * (STABLE * rate).powi(2));
    }
}

/// Pulls for `dt` seconds.
pub fn kick(springs: &[Spring], bodies: &mut RigidBodySet, dt: f64) {
    for spring in springs {
        let [a, b] = spring.bodies.map(handle);
        let (Some(first), Some(second)) = (bodies.get(a), bodies.get(b)) else { continue };
        let ends = [end(first, spring.at[0]), end(second, spring.at[1])];
        let way = ends[1].place - ends[0].place;
        let Some(along) = way.try_normalize() else { continue };
        let give = give(first, ends[0].arm, along) + give(second, ends[1].arm, along);
        let speed = (ends[1].velocity - ends[0].velocity).dot(along);
        let stretch = way.length() - spring.length;
        // The part of the speed that is lost, exactly as far as nothing else happens meanwhile.
        let lost = if give > 0.0 { -(-spring.damping * give * dt).exp_m1() * speed / give } else { 0.0 };
        let push = along * (spring.stiffness * stretch * dt + lost);
        for (index, (handle, sign)) in [(a, 1.0), (b, -1.0)].into_iter().enumerate() {
            if let Some(body) = bodies.get_mut(handle).filter(|body| body.is_dynamic()) {
                body.apply_impulse_at_point(single(push * sign), single(ends[index].place), true);
            }
        }
    }
}
