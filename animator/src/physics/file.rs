//! A bake as bytes: a header that says what it is of, the poses by step, of each step those that changed, and a checksum.
//! Beside it, what is done of a bake that is not finished: records that are only ever added to, each with its own.

use kinora_scene::Pose;
use serde::{Deserialize, Serialize};

use super::plan::Plan;

const BAKE: &[u8] = b"kinora bake 1\n";
const PART: &[u8] = b"kinora part 1\n";

const SUM: usize = 32;

/// What a bake is of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    key: [u8; 32],
    /// The solver and its version.
    engine: String,
    /// The kind of processor.
    machine: String,
    steps: u64,
    bodies: u64,
}

impl Header {
    fn of(plan: &Plan<'_>, key: [u8; 32]) -> Self {
        Self {
            key,
            engine: engine(),
            machine: std::env::consts::ARCH.into(),
            steps: plan.steps,
            bodies: plan.moving().count() as u64,
        }
    }
}

fn engine() -> String {
    format!("rapier {}", rapier3d::VERSION)
}

/// What was read.
#[derive(Debug, PartialEq)]
pub struct Read {
    pub poses: Vec<Pose>,
    /// The kind of processor it was made on, where that is another.
    pub other_machine: Option<String>,
}

/// The bytes of a finished bake.
pub fn write(plan: &Plan<'_>, key: [u8; 32], poses: &[Pose]) -> Vec<u8> {
    let mut bytes = BAKE.to_vec();
    header(&mut bytes, &Header::of(plan, key));
    steps(&mut bytes, plan.moving().count(), None, poses);
    let sum = blake3::hash(&bytes);
    bytes.extend(sum.as_bytes());
    bytes
}

/// Reads a finished bake.
///
/// # Errors
/// Why it is not that of the plan, in one clause.
pub fn read(plan: &Plan<'_>, key: [u8; 32], bytes: &[u8]) -> Result<Read, String> {
    let inner = bytes.strip_prefix(BAKE).ok_or("it is no bake of this version")?;
    let (body, sum) = bytes.split_at_checked(bytes.len().saturating_sub(SUM)).ok_or("it is damaged")?;
    if blake3::hash(body).as_bytes() != sum || inner.len() < SUM {
        return Err("it is damaged".into());
    }
    let mut rest = &inner[..inner.len() - SUM];
    let found = take_header(&mut rest).ok_or("it is damaged")?;
    check(&found, &Header::of(plan, key))?;
    let poses = take_steps(&mut rest, plan.moving().count(), plan.steps + 1, None).ok_or("it is damaged")?;
    let other_machine = Some(found.machine).filter(|machine| machine != std::env::consts::ARCH);
    Ok(Read { poses, other_machine })
}

fn check(found: &Header, wanted: &Header) -> Result<(), String> {
    if found.engine != wanted.engine {
        return Err(format!("it was made by {}, and this is {}", found.engine, wanted.engine));
    }
    if found.key != wanted.key || (found.steps, found.bodies) != (wanted.steps, wanted.bodies) {
        return Err("it was made for other bodies".into());
    }
    Ok(())
}

fn header(bytes: &mut Vec<u8>, header: &Header) {
    // Plain data always serialises.
    let header = postcard::to_allocvec(header).unwrap_or_default();
    bytes.extend((header.len() as u32).to_le_bytes());
    bytes.extend(header);
}

fn take_header(bytes: &mut &[u8]) -> Option<Header> {
    let length = u32::from_le_bytes(take(bytes, 4)?.try_into().ok()?);
    postcard::from_bytes(take(bytes, length as usize)?).ok()
}

fn take<'b>(bytes: &mut &'b [u8], count: usize) -> Option<&'b [u8]> {
    let (taken, rest) = bytes.split_at_checked(count)?;
    *bytes = rest;
    Some(taken)
}

/// Poses by step: a bit a body that says whether it is elsewhere than a step before, and where those are.
fn steps(bytes: &mut Vec<u8>, count: usize, before: Option<&[Pose]>, poses: &[Pose]) {
    let mut last = before;
    for step in poses.chunks_exact(count.max(1)) {
        let changed = |index: usize| last.is_none_or(|last| !same(&last[index], &step[index]));
        let bits = bytes.len();
        bytes.resize(bits + count.div_ceil(8), 0);
        for (index, pose) in step.iter().enumerate().filter(|(index, _)| changed(*index)) {
            bytes[bits + index / 8] |= 1 << (index % 8);
            for number in pose.position.iter().chain(&pose.rotation) {
                bytes.extend(number.to_le_bytes());
            }
        }
        last = Some(step);
    }
}

fn take_steps(bytes: &mut &[u8], count: usize, steps: u64, before: Option<&[Pose]>) -> Option<Vec<Pose>> {
    // As much as there can be, whatever the header says.
    let least = count.div_ceil(8).max(1) as u64;
    if steps > bytes.len() as u64 / least + 1 {
        return None;
    }
    let mut poses: Vec<Pose> = Vec::with_capacity(steps as usize * count);
    let mut last: Option<Vec<Pose>> = before.map(<[Pose]>::to_vec);
    for _ in 0..steps {
        let bits = take(bytes, count.div_ceil(8))?;
        let mut step = Vec::with_capacity(count);
        for index in 0..count {
            let pose = match (bits[index / 8] >> (index % 8)) & 1 {
                0 => *last.as_ref()?.get(index)?,
                _ => {
                    let mut numbers = [0.0f32; 7];
                    for number in &mut numbers {
                        *number = f32::from_le_bytes(take(bytes, 4)?.try_into().ok()?);
                    }
                    let [x, y, z, a, b, c, d] = numbers;
                    if !numbers.iter().all(|number| number.is_finite()) {
                        return None;
                    }
                    Pose { position: [x, y, z], rotation: [a, b, c, d] }
                }
            };
            step.push(pose);
        }
        poses.extend(&step);
        last = Some(step);
    }
    bytes.is_empty().then_some(poses)
}

/// Bit for bit.
fn same(a: &Pose, b: &Pose) -> bool {
    let bits = |pose: &Pose| (pose.position.map(f32::to_bits), pose.rotation.map(f32::to_bits));
    bits(a) == bits(b)
}

/// The bytes that begin an unfinished bake.
pub fn begin(plan: &Plan<'_>, key: [u8; 32]) -> Vec<u8> {
    let mut bytes = PART.to_vec();
    header(&mut bytes, &Header::of(plan, key));
    bytes
}

/// A record of an unfinished bake: the poses since the one before, and the state after them.
pub fn record(plan: &Plan<'_>, before: Option<&[Pose]>, poses: &[Pose], state: &[u8]) -> Vec<u8> {
    let count = plan.moving().count();
    let mut inner = ((poses.len() / count.max(1)) as u64).to_le_bytes().to_vec();
    let mut moved = Vec::new();
    steps(&mut moved, count, before, poses);
    inner.extend((moved.len() as u64).to_le_bytes());
    inner.extend(moved);
    inner.extend(state);
    let mut bytes = (inner.len() as u64).to_le_bytes().to_vec();
    bytes.extend(blake3::hash(&inner).as_bytes());
    bytes.extend(inner);
    bytes
}

/// What is done of an unfinished bake.
pub struct Part {
    pub poses: Vec<Pose>,
    pub state: Vec<u8>,
    /// How many of its bytes are whole.
    pub bytes: usize,
}

/// Reads as much of an unfinished bake as is whole; `None` where that is nothing, or is of another plan.
pub fn read_part(plan: &Plan<'_>, key: [u8; 32], bytes: &[u8]) -> Option<Part> {
    let mut rest = bytes.strip_prefix(PART)?;
    let found = take_header(&mut rest)?;
    let wanted = Header::of(plan, key);
    if found != wanted {
        return None;
    }
    let count = plan.moving().count();
    let mut part = Part { poses: Vec::new(), state: Vec::new(), bytes: 0 };
    while let Some(inner) = take_record(&mut rest) {
        let mut inner = inner;
        let number = |inner: &mut &[u8]| Some(u64::from_le_bytes(take(inner, 8)?.try_into().ok()?));
        let (Some(steps), Some(length)) = (number(&mut inner), number(&mut inner)) else { break };
        let Some(mut moved) = take(&mut inner, usize::try_from(length).unwrap_or(usize::MAX)) else { break };
        let last = part.poses.len().checked_sub(count).map(|from| part.poses[from..].to_vec());
        let Some(more) = take_steps(&mut moved, count, steps, last.as_deref()) else { break };
        part.poses.extend(more);
        part.state = inner.to_vec();
        part.bytes = bytes.len() - rest.len();
    }
    (part.bytes > 0).then_some(part)
}

fn take_record<'b>(bytes: &mut &'b [u8]) -> Option<&'b [u8]> {
    let mut rest = *bytes;
    let length = u64::from_le_bytes(take(&mut rest, 8)?.try_into().ok()?);
    let sum = take(&mut rest, SUM)?;
    let inner = take(&mut rest, usize::try_from(length).ok()?)?;
    if blake3::hash(inner).as_bytes() != sum {
        return None;
    }
    *bytes = rest;
    Some(inner)
}
