//! Bodies that touch nothing: where they are is known exactly, so the solver's steps, which are right to first order
//! only, are replaced by that.

use glam::{DQuat, DVec3};
use rapier3d::prelude::RigidBody;
use serde::{Deserialize, Serialize};

use super::convert::{double, double_turn, pose, single, single_turn};

/// A body before a step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Free {
    /// Its centre of mass.
    pub centre: DVec3,
    pub rotation: DQuat,
    pub velocity: DVec3,
    /// rad/s about each axis of the world.
    pub spin: DVec3,
    /// 1 / kg.
    pub inverse_mass: f64,
    /// The push that it gets during the step, N·s, and how long before the step's end.
    pub push: DVec3,
    pub push_left_s: f64,
}

/// The body as it is; `flight` is where its flight brought it, if it was flying.
pub fn before(body: &RigidBody, flight: Option<&Free>) -> Free {
    if let Some(flight) = flight
        && single_turn(flight.rotation) == *body.rotation()
        && single(flight.centre - flight.rotation * double(body.local_center_of_mass())) == body.translation()
        && (single(flight.velocity), single(flight.spin)) == (body.linvel(), body.angvel())
    {
        return *flight;
    }
    Free {
        centre: double(body.center_of_mass()),
        rotation: double_turn(*body.rotation()),
        velocity: double(body.linvel()),
        spin: double(body.angvel()),
        inverse_mass: f64::from(body.mass_properties().local_mprops.inv_mass),
        push: DVec3::ZERO,
        push_left_s: 0.0,
    }
}

/// Where the body is `dt` seconds later by `gravity` and its damping alone.
pub fn after(body: &RigidBody, before: &Free, gravity: DVec3, dt: f64) -> Free {
    let (damping, spin_damping) = (f64::from(body.linear_damping()), f64::from(body.angular_damping()));
    let kick = before.push * before.inverse_mass;
    // By the solution of v' = g - damping · v.
    let (once, twice) = decayed(damping, dt);
    let way = before.velocity * once + gravity * twice + kick * decayed(damping, before.push_left_s).0;
    let fall = gravity * once + kick * (-damping * before.push_left_s).exp();
    let properties = &body.mass_properties().local_mprops;
    let inverse_inertia = double(properties.inv_principal_inertia);
    let frame = double_turn(properties.principal_inertia_local_frame);
    let (rotation, spin) = turn(before.rotation, before.spin, frame, inverse_inertia, spin_damping, dt);
    Free {
        centre: before.centre + way,
        rotation,
        velocity: before.velocity * (-damping * dt).exp() + fall,
        spin,
        push: DVec3::ZERO,
        push_left_s: 0.0,
        ..*before
    }
}

/// Whether the solver stopped the body short of where it would fly: there is something that it would go through.
pub fn is_stopped(body: &RigidBody, before: &Free, after: &Free) -> bool {
    let way = after.centre - before.centre;
    let done = (double(body.center_of_mass()) - before.centre).dot(way.normalize_or_zero());
    // Its own steps are right to first order only.
    done < 0.97 * way.length() - 1e-4
}

/// Puts the body there.
pub fn put(body: &mut RigidBody, free: &Free) {
    let local_centre = double(body.local_center_of_mass());
    body.set_position(pose(free.centre - free.rotation * local_centre, free.rotation), false);
    body.set_linvel(single(free.velocity), false);
    body.set_angvel(single(free.spin), false);
}

/// The integrals of e^(−damping · t) from 0 to `t`, once and twice.
fn decayed(damping: f64, t: f64) -> (f64, f64) {
    let x = damping * t;
    if x.abs() < 1e-3 {
        // By their series: the quotients below would be of differences of nearly equal numbers.
        let once = t * (1.0 - x / 2.0 + x * x / 6.0 - x * x * x / 24.0);
        return (once, t * t * (0.5 - x / 6.0 + x * x / 24.0 - x * x * x / 120.0));
    }
    let once = -(-x).exp_m1() / damping;
    (once, (t - once) / damping)
}

/// The rotation and the spin of a body that nothing turns, after `dt` seconds. Its angular momentum stays as it is, but for
/// damping; where that is not along an axis of inertia the spin wobbles, which is followed by Runge and Kutta's method.
fn turn(rotation: DQuat, spin: DVec3, frame: DQuat, inverse: DVec3, damping: f64, dt: f64) -> (DQuat, DVec3) {
    let inertia = inverse.map(|part| if part > 0.0 { part.recip() } else { 0.0 });
    let axes = |rotation: DQuat| rotation * frame;
    let local = axes(rotation).inverse() * spin;
    let momentum = axes(rotation) * (inertia * local);
    // How far it turns in all: what it loses to damping counts as less time.
    let (time, left) = (decayed(damping, dt).0, (-damping * dt).exp());
    let even = (inertia.max_element() - inertia.min_element()).abs() <= 1e-5 * inertia.max_element();
    if even || inertia.min_element() <= 0.0 {
        return ((DQuat::from_scaled_axis(spin * time) * rotation).normalize(), spin * left);
    }
    let spin_of = |rotation: DQuat| {
        let axes = axes(rotation);
        axes * (inverse * (axes.inverse() * momentum))
    };
    let steps = (spin.length() * time / 0.02).ceil().clamp(1.0, 1000.0);
    let h = time / steps;
    let mut at = rotation;
    for _ in 0..steps as u32 {
        let slope = |q: DQuat| DQuat::from_xyzw(spin_of(q).x, spin_of(q).y, spin_of(q).z, 0.0) * q * 0.5;
        let k1 = slope(at);
        let k2 = slope((at + k1 * (0.5 * h)).normalize());
        let k3 = slope((at + k2 * (0.5 * h)).normalize());
        let k4 = slope((at + k3 * h).normalize());
        at = (at + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0)).normalize();
    }
    (at, spin_of(at) * left)
}
