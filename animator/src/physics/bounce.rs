//! Bounces at the moment they happen. The solver lets a body reach what it hits at the end of a step and sends it back with
//! the speed that it had at its beginning, which costs height; here it turns round where it touches.

use glam::DVec3;
use rapier3d::prelude::{PhysicsWorld, Pose, RigidBody};
use serde::{Deserialize, Serialize};

use super::convert::{double, double_turn};
use super::flight::{self, Free};
use super::spring::give;
use super::world::{body_of, handle};

/// What a body touched in a step.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Touch {
    /// Pairs of colliders that pushed it.
    pub pairs: u32,
}

/// Counts what each of `count` bodies touched.
pub fn touches(world: &PhysicsWorld, count: usize, touches: &mut Vec<Touch>) {
    touches.clear();
    touches.resize(count, Touch::default());
    for pair in world.narrow_phase.contact_pairs() {
        let pushed =
            pair.manifolds().iter().any(|manifold| manifold.points.iter().any(|point| point.data.impulse != 0.0))
                || pair
                    .solver_manifolds()
                    .iter()
                    .any(|cluster| cluster.points.iter().any(|point| point.data.impulse != 0.0));
        if !pushed {
            continue;
        }
        for collider in [pair.collider1, pair.collider2] {
            if let Some(touch) = world.colliders.get(collider).and_then(body_of).and_then(|body| touches.get_mut(body))
            {
                touch.pairs += 1;
            }
        }
    }
}

/// A bounce that is to be put right.
struct Bounce {
    bodies: [usize; 2],
    /// From the first to the second.
    normal: DVec3,
    /// Where they touch, in the space of each: in the middle of all points that are as near as the nearest.
    at: [DVec3; 2],
    restitution: f64,
    friction: f64,
}

/// Puts right what bounced in a step of `dt` seconds: bodies that touch nothing but one another. `flights`: where bodies are
/// that are put right.
pub fn put_right(
    world: &mut PhysicsWorld,
    before: &[Option<Free>],
    touches: &[Touch],
    gravity: DVec3,
    dt: f64,
    flights: &mut [Option<Free>],
) {
    let mut found = Vec::new();
    for pair in world.narrow_phase.contact_pairs() {
        let colliders = [pair.collider1, pair.collider2].map(|collider| world.colliders.get(collider));
        let [Some(first), Some(second)] = colliders else { continue };
        let (Some(a), Some(b)) = (body_of(first), body_of(second)) else { continue };
        let restitution = 0.5 * f64::from(first.restitution() + second.restitution());
        let friction = 0.5 * f64::from(first.friction() + second.friction());
        let alone = |body: usize| {
            let driven = world.bodies.get(handle(body)).is_some_and(|body| !body.is_dynamic());
            driven
                || (touches.get(body).is_some_and(|touch| touch.pairs == 1)
                    && before.get(body).is_some_and(Option::is_some))
        };
        if restitution <= 0.0 || !alone(a) || !alone(b) {
            continue;
        }
        let parts = [(first, a), (second, b)];
        let places = parts.map(|(collider, _)| collider.position_wrt_parent().copied().unwrap_or(Pose::IDENTITY));
        let mut normal = DVec3::ZERO;
        let mut points: Vec<([DVec3; 2], f64)> = Vec::new();
        for manifold in pair.manifolds() {
            if manifold.points.is_empty() {
                continue;
            }
            normal = double(manifold.data.normal);
            let inner = |pose: Option<&Pose>| pose.copied().unwrap_or(Pose::IDENTITY);
            let (one, two) = (inner(manifold.subshape_pos1()), inner(manifold.subshape_pos2()));
            for point in &manifold.points {
                let local = [places[0] * (one * point.local_p1), places[1] * (two * point.local_p2)].map(double);
                points.push((local, f64::from(point.dist)));
            }
        }
        let nearest = points.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
        points.retain(|point| point.1 <= nearest + 1e-4);
        let count = points.len() as f64;
        if points.is_empty() || normal.length() < 0.5 {
            continue;
        }
        let middle = |side: usize| points.iter().map(|point| point.0[side]).sum::<DVec3>() / count;
        found.push(Bounce { bodies: [a, b], normal, at: [middle(0), middle(1)], restitution, friction });
    }
    for bounce in found {
        turn_round(world, &bounce, before, gravity, dt, flights);
    }
}

/// One side of a bounce.
#[derive(Clone, Copy)]
enum Side {
    /// What forces move.
    Free(Free),
    /// What nothing moves, or its keys: the place of its point and how fast that is, over the step.
    Driven(DVec3, DVec3),
}

impl Side {
    /// From its centre of mass to its point, which is `at` in its own space.
    fn arm(&self, body: &RigidBody, at: DVec3) -> DVec3 {
        match self {
            Side::Free(free) => free.rotation * (at - double(body.local_center_of_mass())),
            Side::Driven(..) => DVec3::ZERO,
        }
    }

    /// Where its point is, and how fast.
    fn point(&self, arm: DVec3) -> (DVec3, DVec3) {
        match self {
            Side::Free(free) => (free.centre + arm, free.velocity + free.spin.cross(arm)),
            Side::Driven(place, velocity) => (*place, *velocity),
        }
    }

    fn after(self, body: &RigidBody, gravity: DVec3, dt: f64) -> Self {
        match self {
            Side::Free(free) => Side::Free(flight::after(body, &free, gravity, dt)),
            Side::Driven(place, velocity) => Side::Driven(place + velocity * dt, velocity),
        }
    }

    /// Pushes its point.
    fn push(&mut self, body: &RigidBody, arm: DVec3, push: DVec3) {
        if let Side::Free(free) = self {
            let properties = &body.mass_properties().local_mprops;
            let axes = free.rotation * double_turn(properties.principal_inertia_local_frame);
            free.velocity += push * free.inverse_mass;
            free.spin += axes * (double(properties.inv_principal_inertia) * (axes.inverse() * arm.cross(push)));
        }
    }
}

fn turn_round(
    world: &mut PhysicsWorld,
    bounce: &Bounce,
    before: &[Option<Free>],
    gravity: DVec3,
    dt: f64,
    flights: &mut [Option<Free>],
) {
    let normal = bounce.normal;
    let [Some(first), Some(second)] = bounce.bodies.map(|index| world.bodies.get(handle(index))) else { return };
    let bodies = [first, second];
    let mut sides = [0, 1].map(|side| {
        let body = bodies[side];
        match before.get(bounce.bodies[side]).copied().flatten() {
            Some(free) => Side::Free(free),
            None => {
                let arm = double_turn(*body.rotation()) * bounce.at[side];
                let place = double(body.translation()) + arm;
                let arm = place - double(body.center_of_mass());
                let velocity = double(body.linvel()) + double(body.angvel()).cross(arm);
                Side::Driven(place - velocity * dt, velocity)
            }
        }
    });
    let arms = [0, 1].map(|side| sides[side].arm(bodies[side], bounce.at[side]));
    let points = [0, 1].map(|side| sides[side].point(arms[side]));
    // Everything along the normal: how far apart, and how fast they come together.
    let pulled = |body: &RigidBody| if body.is_dynamic() { gravity } else { DVec3::ZERO };
    let gap = (points[1].0 - points[0].0).dot(normal).max(0.0);
    let closing = (points[0].1 - points[1].1).dot(normal);
    let faster = (pulled(first) - pulled(second)).dot(normal);
    // The solver begins a step with the push of the last one, though what bounced is on its way back.
    if closing + faster.max(0.0) * dt < 0.0 {
        for side in [0, 1] {
            sides[side] = sides[side].after(bodies[side], gravity, dt);
        }
        settle(world, bounce, sides, flights);
        return;
    }
    // What lies on something is pressed against it anew in each step; that is no bounce.
    if closing <= 2.0 * faster.abs() * dt + 1e-3 {
        return;
    }
    let root = (closing * closing + 2.0 * faster * gap).max(0.0).sqrt();
    let until = (2.0 * gap / (closing + root)).min(dt);
    let left = dt - until;
    let away = bounce.restitution * (closing + faster * until);
    // What comes down again in the same step is left to the solver.
    if away <= faster * left {
        return;
    }
    for side in [0, 1] {
        sides[side] = sides[side].after(bodies[side], gravity, until);
    }
    let arms = [0, 1].map(|side| sides[side].arm(bodies[side], bounce.at[side]));
    let points = [0, 1].map(|side| sides[side].point(arms[side]));
    let give_along = |along: DVec3| give(first, arms[0], along) + give(second, arms[1], along);
    let meeting = points[0].1 - points[1].1;
    let hit = meeting.dot(normal);
    let push = (1.0 + bounce.restitution) * hit / give_along(normal);
    if !(push > 0.0 && push.is_finite()) {
        return;
    }
    let across = meeting - normal * hit;
    let drag = match across.try_normalize() {
        Some(along) => along * (bounce.friction * push).min(across.length() / give_along(along)),
        None => DVec3::ZERO,
    };
    let push = normal * push + drag;
    for (side, sign) in [(0, -1.0), (1, 1.0)] {
        sides[side].push(bodies[side], arms[side], push * sign);
        sides[side] = sides[side].after(bodies[side], gravity, left);
    }
    settle(world, bounce, sides, flights);
}

/// Puts both bodies where they are.
fn settle(world: &mut PhysicsWorld, bounce: &Bounce, sides: [Side; 2], flights: &mut [Option<Free>]) {
    for (index, side) in bounce.bodies.into_iter().zip(sides) {
        if let (Side::Free(free), Some(body)) = (side, world.bodies.get_mut(handle(index))) {
            flight::put(body, &free);
            if let Some(slot) = flights.get_mut(index) {
                *slot = Some(free);
            }
        }
    }
}
