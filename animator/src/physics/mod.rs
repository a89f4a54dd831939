//! Rigid bodies: [`bake`] turns them into poses at each step, once, and keeps those for the next time. After that a scene
//! with bodies is like any other: [`crate::sample`] puts them where they are.
//!
//! The solver is rapier, in f32, with its determinism that is the same on all machines of a kind, fixed steps and one
//! thread. The same bodies give the same bytes.
//!
//! ```
//! use kinora_animator::physics::{self, NoCache, bake};
//! use kinora_scene::{Body, Scene};
//!
//! fn baked(scene: &Scene) -> Result<Scene, physics::BakeError> {
//!     let mut scene = scene.clone();
//!     if let Some(bake) = bake(&scene, &mut NoCache, false, &mut |_| physics::Next::Step)? {
//!         scene.physics.baked = Some(bake.baked);
//!     }
//!     Ok(scene)
//! }
//! ```

mod bounce;
mod collider;
mod convert;
mod error;
mod file;
mod flight;
mod plan;
mod spring;
mod world;

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use kinora_scene::{Baked, BakedBody, Pose, Scene};

pub use error::BakeError;
use plan::{Plan, plan};
use world::Simulator;

/// Counts up whenever the same bodies come to move differently.
const VERSION: u32 = 1;

/// Where bakes are kept.
pub trait Cache {
    /// The finished bake, if there is one.
    fn read(&mut self) -> Option<Vec<u8>>;
    /// Keeps a finished bake, and forgets what was unfinished.
    ///
    /// # Errors
    /// Why it cannot, for the user.
    fn write(&mut self, bytes: &[u8]) -> Result<(), String>;
    /// What is done of an unfinished bake, if anything is.
    fn read_part(&mut self) -> Option<Vec<u8>>;
    /// Keeps what is done: the first `keep` bytes of what there is, then these.
    ///
    /// # Errors
    /// Why it cannot, for the user.
    fn write_part(&mut self, keep: usize, bytes: &[u8]) -> Result<(), String>;
}

/// Nothing is kept.
pub struct NoCache;

impl Cache for NoCache {
    fn read(&mut self) -> Option<Vec<u8>> {
        None
    }
    fn write(&mut self, _: &[u8]) -> Result<(), String> {
        Ok(())
    }
    fn read_part(&mut self) -> Option<Vec<u8>> {
        None
    }
    fn write_part(&mut self, _: usize, _: &[u8]) -> Result<(), String> {
        Ok(())
    }
}

/// How far a bake is.
#[derive(Clone, Copy)]
pub struct Progress<'p> {
    /// Steps done.
    pub step: u64,
    /// Of so many.
    pub steps: u64,
    /// Makes what there is so far: where the bodies are until the last step done, at which they then rest.
    pub baked: &'p dyn Fn() -> Baked,
}

/// What happens after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The next one.
    Step,
    /// What is done is kept, so that another process may go on; then the next one.
    Keep,
    /// What is done is kept, and that is all.
    Stop,
}

/// What comes of a bake.
#[derive(Clone, Debug)]
pub struct Bake {
    /// Where the bodies are.
    pub baked: Arc<Baked>,
    /// Whether it was kept from before, and nothing was computed.
    pub kept: bool,
    /// The kind of processor that a kept bake was made on, where that is another one.
    pub other_machine: Option<String>,
    /// Of a new bake: pairs of nodes that are inside one another at the start, and how deep in metres.
    pub overlaps: Vec<([usize; 2], f64)>,
    /// Why a new bake could not be kept. It is none the worse for that.
    pub not_kept: Option<String>,
    /// How many bodies forces move.
    pub bodies: usize,
    /// How many steps there are.
    pub steps: u64,
    /// What it depends on, as hexadecimal digits.
    pub key: String,
}

/// Where the bodies of a scene are at all times; `None` where forces move none. A bake that is kept and still right is used;
/// if not, a new one is made and kept, unless `frozen`. `watch` hears of each step.
///
/// # Errors
/// See [`BakeError`].
pub fn bake(
    scene: &Scene,
    cache: &mut dyn Cache,
    frozen: bool,
    watch: &mut dyn FnMut(Progress<'_>) -> Next,
) -> Result<Option<Bake>, BakeError> {
    let Some(plan) = plan(scene)? else { return Ok(None) };
    let key = plan.key();
    let hex = key.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let made = |poses: Vec<Pose>, kept: bool| Bake {
        baked: Arc::new(baked(&plan, poses)),
        kept,
        other_machine: None,
        overlaps: Vec::new(),
        not_kept: None,
        bodies: plan.moving().count(),
        steps: plan.steps,
        key: hex.clone(),
    };
    let found = match cache.read() {
        Some(bytes) => file::read(&plan, key, &bytes),
        None => Err("it is not there".into()),
    };
    match found {
        Ok(read) => return Ok(Some(Bake { other_machine: read.other_machine, ..made(read.poses, true) })),
        Err(why) if frozen => return Err(BakeError::Stale { why }),
        Err(_) => {}
    }
    let new = simulate(&plan, key, cache, watch)?;
    let not_kept = cache.write(&file::write(&plan, key, &new.poses)).err();
    Ok(Some(Bake { overlaps: new.overlaps, not_kept, ..made(new.poses, false) }))
}

/// What a bake would say before its first step: pairs of nodes that are inside one another at 0 s, and how deep in metres.
/// Nothing is looked for in scenes where that alone would take long: of very many bodies, or with large meshes that fall.
///
/// # Errors
/// See [`BakeError`].
pub fn overlaps(scene: &Scene) -> Result<Vec<([usize; 2], f64)>, BakeError> {
    match plan(scene)? {
        Some(plan) if plan.is_quick() => Ok(Simulator::new(&plan)?.overlaps()),
        _ => Ok(Vec::new()),
    }
}

/// A new bake.
struct New {
    poses: Vec<Pose>,
    overlaps: Vec<([usize; 2], f64)>,
}

fn simulate(
    plan: &Plan<'_>,
    key: [u8; 32],
    cache: &mut dyn Cache,
    watch: &mut dyn FnMut(Progress<'_>) -> Next,
) -> Result<New, BakeError> {
    let mut new = New { poses: Vec::new(), overlaps: Vec::new() };
    // Whether what is unfinished can be kept: if not, there is no more to do about it.
    let mut keeps = true;
    // How many bytes of what is unfinished are whole, and how many poses those are.
    let (mut whole, mut saved) = (0, 0);
    let mut resumed = None;
    if let Some(part) = cache.read_part().and_then(|bytes| file::read_part(plan, key, &bytes))
        && let Some(simulator) = Simulator::resume(plan, &part.state)
        && part.poses.len() as u64 == (simulator.done() + 1) * plan.moving().count() as u64
    {
        (whole, saved) = (part.bytes, part.poses.len());
        new.poses = part.poses;
        resumed = Some(simulator);
    }
    let mut simulator = match resumed {
        Some(simulator) => simulator,
        None => {
            let mut simulator = Simulator::new(plan)?;
            new.overlaps = simulator.overlaps();
            new.poses.extend(plan.moving().map(|index| simulator.pose(index)));
            simulator
        }
    };
    let moving: Vec<usize> = plan.moving().collect();
    while simulator.done() < plan.steps {
        let so_far = || baked(plan, new.poses.clone());
        let next = watch(Progress { step: simulator.done(), steps: plan.steps, baked: &so_far });
        if next != Next::Step && keeps && new.poses.len() > saved {
            let before = saved.checked_sub(moving.len()).map(|from| &new.poses[from..saved]);
            let mut bytes = if whole == 0 { file::begin(plan, key) } else { Vec::new() };
            bytes.extend(file::record(plan, before, &new.poses[saved..], &simulator.state()));
            match cache.write_part(whole, &bytes) {
                Ok(()) => (whole, saved) = (whole + bytes.len(), new.poses.len()),
                Err(_) => keeps = false,
            }
        }
        if next == Next::Stop {
            return Err(BakeError::Stopped);
        }
        simulator.advance()?;
        new.poses.extend(moving.iter().map(|index| simulator.pose(*index)));
    }
    watch(Progress { step: plan.steps, steps: plan.steps, baked: &|| baked(plan, new.poses.clone()) });
    Ok(new)
}

fn baked(plan: &Plan<'_>, poses: Vec<Pose>) -> Baked {
    let bodies = plan.moving().enumerate().map(|(at, index)| {
        let planned = &plan.bodies[index];
        let world = DAffine3::from_rotation_translation(planned.rotation, planned.position) * planned.pose_from_node;
        // So that it is at 0 s where it is written, to the last bit of what its pose has.
        let pose_from_node = match poses.get(at) {
            Some(first) => {
                let place = plan.origin + first.place();
                DAffine3::from_scale_rotation_translation(DVec3::ONE, first.turn(), place).inverse() * world
            }
            None => planned.pose_from_node,
        };
        BakedBody { node: planned.body.node, pose_from_node }
    });
    Baked { step_s: 1.0 / plan.simulation.rate_hz, origin: plan.origin, bodies: bodies.collect(), poses }
}

impl Plan<'_> {
    /// What a body is called.
    fn name(&self, index: usize) -> &str {
        self.scene.nodes.get(self.bodies[index].body.node).map_or("", |node| &node.name)
    }
}
