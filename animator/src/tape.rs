//! Runs tapes: an f64 register an instruction, no branch, no state.

use glam::{DQuat, DVec3};
use kinora_scene::{Instruction, Orient, Register, Tape, gradient_noise};

use crate::{
    aim::facing,
    track::{at, unit},
};

/// The outputs of a tape at `time_s`. Total: what refers to nothing is NaN.
pub(crate) fn run(tape: &Tape, time_s: f64, fps: f64) -> Vec<f64> {
    let registers = registers(tape, Given { time_s, fps, input: f64::NAN });
    tape.outputs.iter().map(|&output| read(&registers, output)).collect()
}

/// The first output of a tape that is a function of its input alone.
pub(crate) fn function(tape: &Tape, input: f64) -> f64 {
    let registers = registers(tape, Given { time_s: f64::NAN, fps: f64::NAN, input });
    tape.outputs.first().map_or(f64::NAN, |&output| read(&registers, output))
}

/// What a tape is run with.
#[derive(Clone, Copy)]
struct Given {
    time_s: f64,
    fps: f64,
    input: f64,
}

/// A texture's tape at `time_s`: what does not differ from point to point is a constant.
pub(crate) fn still(tape: &Tape, time_s: f64, fps: f64) -> Tape {
    let given = Given { time_s, fps, input: f64::NAN };
    let code = tape.code.iter().zip(registers(tape, given)).zip(tape.varying());
    let code = code.map(|((&instruction, value), varies)| if varies { instruction } else { Instruction::Const(value) });
    Tape { code: code.collect(), outputs: tape.outputs.clone(), ..Tape::default() }
}

fn registers(tape: &Tape, given: Given) -> Vec<f64> {
    let mut registers = Vec::with_capacity(tape.code.len());
    for &instruction in &tape.code {
        let result = step(tape, instruction, &registers, given);
        registers.push(result);
    }
    registers
}

fn read(registers: &[f64], index: Register) -> f64 {
    registers.get(index as usize).copied().unwrap_or(f64::NAN)
}

fn step(tape: &Tape, instruction: Instruction, registers: &[f64], Given { time_s, fps, input }: Given) -> f64 {
    let read = |index| read(registers, index);
    let vector = |[x, y, z]: [Register; 3]| DVec3::new(read(x), read(y), read(z));
    let component = |q: DQuat, index: u8| q.to_array().get(usize::from(index)).copied().unwrap_or(f64::NAN);
    match instruction {
        Instruction::Const(number) => number,
        Instruction::Time => time_s,
        Instruction::Frame => frame(time_s, fps),
        Instruction::Input => input,
        Instruction::Keys(i) => tape.curves.get(i as usize).map_or(f64::NAN, |keys| at(keys, time_s)),
        Instruction::Turn(i, part) => {
            tape.turns.get(i as usize).map_or(f64::NAN, |keys| component(at(keys, time_s), part))
        }
        Instruction::Unary(operation, a) => operation.apply(read(a)),
        Instruction::Binary(operation, a, b) => operation.apply(read(a), read(b)),
        Instruction::Select(condition, yes, no) => read(if read(condition) != 0.0 { yes } else { no }),
        Instruction::Noise(at) => gradient_noise(at.map(read)),
        Instruction::Cell(cell, axes, at) => cell.apply(axes, at.map(read)),
        Instruction::Rand(rand, of) => rand.apply(of.map(read)),
        // There is no surface here.
        Instruction::Point(..) => f64::NAN,
        Instruction::Orient(kind, direction, up, part) => component(orient(kind, vector(direction), vector(up)), part),
    }
}

/// `time` · fps, and a whole number at the time of a frame, where that product may be one rounding error beside it.
fn frame(time_s: f64, fps: f64) -> f64 {
    let frame = time_s * fps;
    let whole = frame.round();
    if (frame - whole).abs() <= 4.0 * f64::EPSILON * whole.abs() { whole } else { frame }
}

/// NaN where the direction has no length or `up` lies along it.
fn orient(kind: Orient, direction: DVec3, up: DVec3) -> DQuat {
    let z = match kind {
        Orient::FaceTowards => direction,
        Orient::LookAlong => -direction,
    };
    facing(z, up).map_or(DQuat::NAN, |turn| unit(DQuat::from_mat3(&turn)))
}
