//! The simulation itself: bodies, joints and time steps, by rapier. What it leaves inexact is put right after each step:
//! flight in [`super::flight`], bounces in [`super::bounce`], soft springs in [`super::spring`].

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use kinora_scene::{BodyKind, JointKind};
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use super::BakeError;
use super::bounce::{self, Touch};
use super::collider::colliders;
use super::convert::{double, pose, single};
use super::flight::{self, Free};
use super::plan::{Plan, Planned, dynamic};
use super::spring::{self, Spring};

/// Solver iterations a step; each is a smaller step of its own.
const ITERATIONS: usize = 8;

/// What bodies at joints have besides: chains give way less, and swing longer.
const MORE_ITERATIONS: usize = 24;

/// How far contacts are looked for ahead, besides, by the size of things.
const AHEAD: f32 = 0.04;

/// The steps are cut into no more than this.
const MOST_CUTS: f64 = 32.0;

/// What moves less than this, for as long as [`REST_S`], may rest, in m/s and rad/s; it wakes when it is touched.
const REST: [f32; 2] = [2e-3, 1e-2];
const REST_S: f32 = 0.5;

/// What is smaller than this, in metres, counts as this large.
const SMALLEST_M: f64 = 0.02;

/// Further away than this, in metres, a body has left the world.
const WORLD_M: f64 = 1e6;

/// A simulation that runs.
pub struct Simulator<'p> {
    plan: &'p Plan<'p>,
    world: PhysicsWorld,
    /// Which bodies are held by joints of the solver.
    jointed: Vec<bool>,
    /// And which by joints or springs.
    sprung: Vec<bool>,
    /// Whether a joint has an end that is run against.
    limited: bool,
    /// Of each body before a step, if it is free to move.
    before: Vec<Option<Free>>,
    /// What goes on from step to step besides the solver's own.
    more: More,
}

/// What a state has besides the solver's own.
#[derive(Default, Serialize, Deserialize)]
struct More {
    /// Steps done.
    step: u64,
    /// Into how many the solver's steps are cut.
    cuts: u32,
    springs: Vec<Spring>,
    /// What each body touched in the last step.
    touches: Vec<Touch>,
    /// Where each body that flies is, with all its bits.
    flights: Vec<Option<Free>>,
}

/// The handle of a body: they are inserted in order, and none is ever removed.
pub fn handle(index: usize) -> RigidBodyHandle {
    RigidBodyHandle::from_raw_parts(index as u32, 0)
}

/// The body of a collider.
pub fn body_of(collider: &Collider) -> Option<usize> {
    collider.parent().map(|handle| handle.into_raw_parts().0 as usize)
}

impl<'p> Simulator<'p> {
    /// The bodies as they are at 0 s.
    pub fn new(plan: &'p Plan<'p>) -> Result<Self, BakeError> {
        let more = More { cuts: 1, flights: vec![None; plan.bodies.len()], ..More::default() };
        let mut simulator = Self::over(plan, PhysicsWorld::new(), more);
        let world = &mut simulator.world;
        world.gravity = single(plan.simulation.gravity);
        let settings = &mut world.integration_parameters;
        settings.num_solver_iterations = ITERATIONS;
        settings.warmstart_joints = true;
        settings.normalized_prediction_distance = AHEAD;
        settings.normalized_max_linear_velocity = f32::MAX;
        for (index, planned) in plan.bodies.iter().enumerate() {
            simulator.insert(index, planned)?;
        }
        simulator.join();
        simulator.measure();
        simulator.cut();
        Ok(simulator)
    }

    fn over(plan: &'p Plan<'p>, world: PhysicsWorld, more: More) -> Self {
        let [jointed, sprung] = [false, true].map(|springs| held(plan, springs));
        let limited = plan.joints.iter().any(|joint| {
            matches!(joint.kind, JointKind::Hinge { limits: Some(_), .. } | JointKind::Slider { limits: Some(_), .. })
        });
        let before = vec![None; plan.bodies.len()];
        Self { plan, world, jointed, sprung, limited, before, more }
    }

    fn insert(&mut self, index: usize, planned: &Planned<'_>) -> Result<(), BakeError> {
        let (body, plan) = (planned.body, self.plan);
        let builder = match body.kind {
            BodyKind::Dynamic => RigidBodyBuilder::dynamic(),
            BodyKind::Fixed => RigidBodyBuilder::fixed(),
            BodyKind::Kinematic => RigidBodyBuilder::kinematic_position_based(),
        };
        // Without gravity, what is slow is not at rest.
        let may_rest = !self.sprung[index] && plan.simulation.gravity != DVec3::ZERO;
        let more = if self.jointed[index] { MORE_ITERATIONS } else { 0 };
        let rigid = builder
            .pose(pose(planned.position - plan.origin, planned.rotation))
            .linvel(single(body.velocity))
            .angvel(single(body.angular_velocity))
            .linear_damping(body.linear_damping as f32)
            .angular_damping(body.angular_damping as f32)
            .can_sleep(may_rest)
            .allow_fast_rotation(true)
            // Contacts are looked for as far ahead as the body gets in a step, however fast it is.
            .soft_ccd_prediction(1e3)
            .additional_solver_iterations(more)
            .build();
        let shapeless = |why| BakeError::Shapeless { name: plan.name(index).to_string(), why };
        let shapes = colliders(planned).map_err(shapeless)?;
        let handle = self.world.insert_body(rigid);
        let volume: f64 = shapes.iter().map(|(_, shape)| f64::from(shape.mass_properties(1.0).mass())).sum();
        let density = match (planned.total_kg(), planned.body.mass) {
            (Some(kg), _) => kg / volume,
            (None, kinora_scene::Mass::Density(density)) => density,
            (None, kinora_scene::Mass::Total(_)) => 1000.0,
        };
        let density = if dynamic(body) { density as f32 } else { 0.0 };
        if dynamic(body) && !(density.is_normal() && (f64::from(density) * volume).is_normal()) {
            return Err(shapeless("its mass is beyond what numbers reach"));
        }
        for (at, shape) in shapes {
            let collider = ColliderBuilder::new(shape)
                .position(at)
                .density(density)
                .friction(body.friction as f32)
                .restitution(body.restitution as f32)
                .friction_combine_rule(CoefficientCombineRule::Average)
                .restitution_combine_rule(CoefficientCombineRule::Average);
            self.world.insert_collider(collider, Some(handle));
        }
        if let Some(body) = self.world.bodies.get_mut(handle) {
            body.recompute_mass_properties_from_colliders(&self.world.colliders);
        }
        Ok(())
    }

    /// Tells the solver how large things are: a small thing touches later than a large one, and is pushed apart slower.
    fn measure(&mut self) {
        let mut sizes: Vec<f64> = self.plan.moving().map(|index| 2.0 * self.size(index)).collect();
        sizes.sort_by(f64::total_cmp);
        let unit = sizes.get(sizes.len() / 2).map_or(1.0, |size| size.clamp(SMALLEST_M, 1.0)) as f32;
        self.world.integration_parameters.length_unit = unit;
        for (_, body) in self.world.bodies.iter_mut() {
            let activation = body.activation_mut();
            if activation.normalized_linear_threshold > 0.0 {
                activation.normalized_linear_threshold = REST[0] / unit;
                activation.angular_threshold = REST[1];
                activation.time_until_sleep = REST_S;
            }
        }
    }

    /// Puts the joints in.
    fn join(&mut self) {
        let plan = self.plan;
        for joint in &plan.joints {
            let anchor = joint.anchor - plan.origin;
            let frame = |index: usize, turn: DQuat| {
                let planned = &plan.bodies[index];
                let back = planned.rotation.inverse();
                pose(back * (anchor - (planned.position - plan.origin)), back * turn)
            };
            let (axes, axis, limits, motor) = match joint.kind {
                JointKind::Fixed => (JointAxesMask::LOCKED_FIXED_AXES, JointAxis::AngX, None, None),
                JointKind::Ball => (JointAxesMask::LOCKED_SPHERICAL_AXES, JointAxis::AngX, None, None),
                JointKind::Hinge { limits, motor_velocity, .. } => {
                    (JointAxesMask::LOCKED_REVOLUTE_AXES, JointAxis::AngX, limits, motor_velocity)
                }
                JointKind::Slider { limits, motor_velocity, .. } => {
                    (JointAxesMask::LOCKED_PRISMATIC_AXES, JointAxis::LinX, limits, motor_velocity)
                }
                JointKind::Spring { length_m, stiffness, damping } => {
                    let of = [length_m.unwrap_or(-1.0), stiffness, damping];
                    self.more.springs.push(spring::new(&self.world, joint, plan, of));
                    continue;
                }
            };
            let turn = match joint.kind {
                JointKind::Hinge { axis, .. } | JointKind::Slider { axis, .. } => {
                    DQuat::from_rotation_arc(DVec3::X, axis.normalize_or(DVec3::X))
                }
                _ => DQuat::IDENTITY,
            };
            let mut built = GenericJointBuilder::new(axes)
                .local_frame1(frame(joint.a, turn))
                .local_frame2(frame(joint.b, turn))
                .contacts_enabled(false);
            if let Some([low, high]) = limits.filter(|[low, high]| axis == JointAxis::LinX || high - low < 2.0 * PI) {
                built = built.limits(axis, [low as f32, high as f32]);
            }
            if let Some(velocity) = motor {
                built =
                    built.motor_model(axis, MotorModel::AccelerationBased).motor_velocity(axis, velocity as f32, 1e6);
            }
            self.world.impulse_joints.insert(handle(joint.a), handle(joint.b), built, true);
        }
    }

    /// What is needed to go on from here, in another process too.
    pub fn state(&self) -> Vec<u8> {
        // Plain data always serialises.
        postcard::to_allocvec(&(&self.more, &self.world)).unwrap_or_default()
    }

    /// Goes on from there; `None` where the bytes are no state.
    pub fn resume(plan: &'p Plan<'p>, state: &[u8]) -> Option<Self> {
        let (more, world): (More, PhysicsWorld) = postcard::from_bytes(state).ok()?;
        let count = plan.bodies.len();
        let fits =
            world.bodies.len() == count && more.flights.len() == count && more.step <= plan.steps && more.cuts > 0;
        fits.then(|| Self::over(plan, world, more))
    }

    /// How many steps are done.
    pub fn done(&self) -> u64 {
        self.more.step
    }

    /// The pose of a body, from the plan's origin.
    pub fn pose(&self, index: usize) -> kinora_scene::Pose {
        let pose = self.world.bodies.get(handle(index)).map_or(Pose::IDENTITY, |body| *body.position());
        kinora_scene::Pose { position: pose.translation.to_array(), rotation: pose.rotation.to_array() }
    }

    /// Nodes of bodies that are inside one another at the start, each pair once with how deep in metres.
    pub fn overlaps(&mut self) -> Vec<([usize; 2], f64)> {
        self.world.detect_collisions(&(), &());
        let mut found: BTreeMap<[usize; 2], f64> = BTreeMap::new();
        for pair in self.world.narrow_phase.contact_pairs() {
            let body = |collider| self.world.colliders.get(collider).and_then(body_of);
            let (Some(a), Some(b)) = (body(pair.collider1), body(pair.collider2)) else { continue };
            let points = pair.manifolds().iter().flat_map(|manifold| &manifold.points);
            let depth = points.map(|point| -f64::from(point.dist)).fold(0.0, f64::max);
            let known = found.entry([a.min(b), a.max(b)]).or_insert(0.0);
            *known = known.max(depth);
        }
        for joint in &self.plan.joints {
            found.remove(&[joint.a.min(joint.b), joint.a.max(joint.b)]);
        }
        let deep = |[a, b]: [usize; 2], depth: f64| depth > 1e-3 * self.size(a).min(self.size(b)).min(1.0);
        let node = |index: usize| self.plan.bodies[index].body.node;
        let found = found.into_iter().filter(|(pair, depth)| deep(*pair, *depth));
        found.map(|(pair, depth)| (pair.map(node), depth)).collect()
    }

    /// Half the extent of a body, in metres.
    fn size(&self, index: usize) -> f64 {
        let Some(body) = self.world.bodies.get(handle(index)) else { return 0.0 };
        let shapes = body.colliders().iter().filter_map(|collider| self.world.colliders.get(*collider));
        shapes.map(|collider| f64::from(collider.compute_aabb().half_extents().max_element())).fold(0.0, f64::max)
    }

    /// Cuts the steps until springs swing slowly beside them, and makes softer what is too stiff for that.
    fn cut(&mut self) {
        let rate = self.plan.simulation.rate_hz;
        let cuts = self.more.springs.iter().map(|spring| spring.cuts(rate)).fold(1.0, f64::max).min(MOST_CUTS);
        for spring in &mut self.more.springs {
            spring.soften(rate * cuts);
        }
        self.more.cuts = cuts as u32;
        let settings = &mut self.world.integration_parameters;
        settings.dt = (1.0 / (rate * cuts)) as f32;
        settings.min_ccd_dt = settings.dt / 100.0;
        // A contact gives way less the shorter the steps are. A quarter of their rate is as hard as is stable (Catto,
        // "Solver2D", 2024), but stacks begin to creep before that.
        for softness in [&mut settings.contact_softness, &mut settings.static_contact_softness] {
            softness.natural_frequency = softness.natural_frequency.max((rate * cuts) as f32);
        }
    }

    /// One step.
    ///
    /// # Errors
    /// A body is nowhere, or the track of a kinematic one is.
    pub fn advance(&mut self) -> Result<(), BakeError> {
        let cuts = u64::from(self.more.cuts);
        let dt = 1.0 / (self.plan.simulation.rate_hz * cuts as f64);
        for cut in 0..cuts {
            let at = (self.more.step * cuts + cut) as f64;
            self.advance_cut(at * dt, (at + 1.0) * dt, dt)?;
        }
        self.more.step += 1;
        self.judge()
    }

    fn advance_cut(&mut self, from_s: f64, to_s: f64, dt: f64) -> Result<(), BakeError> {
        for (index, planned) in self.plan.bodies.iter().enumerate() {
            if planned.body.kind == BodyKind::Kinematic {
                let (position, rotation) = self.plan.pose_at(to_s, index)?;
                if let Some(body) = self.world.bodies.get_mut(handle(index)) {
                    body.set_next_kinematic_position(pose(position - self.plan.origin, rotation));
                }
            }
        }
        spring::kick(&self.more.springs, &mut self.world.bodies, 0.5 * dt);
        for index in 0..self.plan.bodies.len() {
            self.before[index] = self.free(index, from_s, to_s);
        }
        // Taking their own speed out of what joints hold keeps stacks at rest, but costs pendulums energy.
        let calm = self.limited || self.more.touches.iter().any(|touch| touch.pairs > 0);
        self.world.integration_parameters.num_internal_stabilization_iterations = usize::from(calm);
        self.world.step();
        bounce::touches(&self.world, self.plan.bodies.len(), &mut self.more.touches);
        let gravity = self.plan.simulation.gravity;
        for (index, before) in self.before.iter().enumerate() {
            let touched = self.more.touches.get(index).is_some_and(|touch| touch.pairs > 0);
            self.more.flights[index] = match before.filter(|_| !touched && !self.jointed[index]) {
                Some(before) => self.world.bodies.get_mut(handle(index)).and_then(|body| {
                    let after = flight::after(body, &before, gravity, dt);
                    if flight::is_stopped(body, &before, &after) {
                        return None;
                    }
                    flight::put(body, &after);
                    Some(after)
                }),
                None => None,
            };
        }
        let More { touches, flights, .. } = &mut self.more;
        bounce::put_right(&mut self.world, &self.before, touches, gravity, dt, flights);
        spring::kick(&self.more.springs, &mut self.world.bodies, 0.5 * dt);
        Ok(())
    }

    /// The body before a step, with the push that it gets, if it is awake and forces move it.
    fn free(&mut self, index: usize, from_s: f64, to_s: f64) -> Option<Free> {
        let planned = self.plan.bodies[index].body;
        if !dynamic(planned) {
            return None;
        }
        // What is at a step but for rounding is at it.
        let slack = 1e-6 * (to_s - from_s);
        let pushed = planned.impulse != DVec3::ZERO
            && planned.impulse_at_s > from_s - slack
            && planned.impulse_at_s <= to_s - slack;
        if !pushed && self.world.bodies.get(handle(index)).is_none_or(|body| body.is_sleeping()) {
            return None;
        }
        let body = self.world.bodies.get_mut(handle(index))?;
        let mut free = flight::before(body, self.more.flights[index].as_ref());
        if pushed {
            free.push = planned.impulse;
            free.push_left_s = (to_s - planned.impulse_at_s).min(to_s - from_s);
            body.apply_impulse(single(planned.impulse), true);
        }
        Some(free)
    }

    /// E0905.
    fn judge(&self) -> Result<(), BakeError> {
        for index in self.plan.moving() {
            let place = self.world.bodies.get(handle(index)).map_or(DVec3::NAN, |body| double(body.translation()));
            let lost = self.world.quarantine().bodies().contains(&handle(index));
            if lost || !place.is_finite() || place.length() > WORLD_M {
                let time_s = self.more.step as f64 / self.plan.simulation.rate_hz;
                return Err(BakeError::BlewUp { name: self.plan.name(index).to_string(), time_s });
            }
        }
        Ok(())
    }
}

/// Which bodies are held by joints, with springs or without.
fn held(plan: &Plan<'_>, springs: bool) -> Vec<bool> {
    let mut held = vec![false; plan.bodies.len()];
    for joint in plan.joints.iter().filter(|joint| springs || !matches!(joint.kind, JointKind::Spring { .. })) {
        held[joint.a] = true;
        held[joint.b] = true;
    }
    held
}
