//! Runs tapes: an f64 register an instruction, no branch, no state.

use glam::{DQuat, DVec3};
use kinora_scene::{Binary, Instruction, Orient, Register, Tape, Unary};

use crate::{
    aim::facing,
    track::{at, unit},
};

/// The outputs of a tape at `time_s`. Total: what refers to nothing is NaN.
pub(crate) fn run(tape: &Tape, time_s: f64, fps: f64) -> Vec<f64> {
    let mut registers = Vec::with_capacity(tape.code.len());
    for &instruction in &tape.code {
        let result = step(tape, instruction, &registers, time_s, fps);
        registers.push(result);
    }
    tape.outputs.iter().map(|&output| read(&registers, output)).collect()
}

fn read(registers: &[f64], index: Register) -> f64 {
    registers.get(index as usize).copied().unwrap_or(f64::NAN)
}

fn step(tape: &Tape, instruction: Instruction, registers: &[f64], time_s: f64, fps: f64) -> f64 {
    let read = |index| read(registers, index);
    let vector = |[x, y, z]: [Register; 3]| DVec3::new(read(x), read(y), read(z));
    let component = |q: DQuat, index: u8| q.to_array().get(usize::from(index)).copied().unwrap_or(f64::NAN);
    match instruction {
        Instruction::Const(number) => number,
        Instruction::Time => time_s,
        Instruction::Frame => frame(time_s, fps),
        Instruction::Keys(i) => tape.curves.get(i as usize).map_or(f64::NAN, |keys| at(keys, time_s)),
        Instruction::Turn(i, part) => {
            tape.turns.get(i as usize).map_or(f64::NAN, |keys| component(at(keys, time_s), part))
        }
        Instruction::Unary(operation, a) => unary(operation, read(a)),
        Instruction::Binary(operation, a, b) => binary(operation, read(a), read(b)),
        Instruction::Select(condition, yes, no) => read(if read(condition) != 0.0 { yes } else { no }),
        Instruction::Orient(kind, direction, up, part) => component(orient(kind, vector(direction), vector(up)), part),
    }
}

/// `time` · fps, and a whole number at the time of a frame, where that product may be one rounding error beside it.
fn frame(time_s: f64, fps: f64) -> f64 {
    let frame = time_s * fps;
    let whole = frame.round();
    if (frame - whole).abs() <= 4.0 * f64::EPSILON * whole.abs() { whole } else { frame }
}

fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

fn unary(operation: Unary, a: f64) -> f64 {
    match operation {
        Unary::Neg => -a,
        Unary::Not => truth(a == 0.0),
        Unary::Abs => a.abs(),
        Unary::Sign if a == 0.0 => 0.0,
        Unary::Sign => a.signum(),
        Unary::Floor => a.floor(),
        Unary::Ceil => a.ceil(),
        Unary::Round => a.round(),
        Unary::Sqrt => a.sqrt(),
        Unary::Exp => a.exp(),
        Unary::Log => a.ln(),
        Unary::Sin => a.sin(),
        Unary::Cos => a.cos(),
        Unary::Tan => a.tan(),
        Unary::Asin => a.asin(),
        Unary::Acos => a.acos(),
        Unary::Atan => a.atan(),
    }
}

fn binary(operation: Binary, a: f64, b: f64) -> f64 {
    match operation {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div => a / b,
        Binary::Mod => modulo(a, b),
        Binary::Pow => a.powf(b),
        Binary::Atan2 => a.atan2(b),
        // Not f64::min and max: they drop a NaN, and a fault is to be seen.
        Binary::Min => {
            if a < b || a.is_nan() {
                a
            } else {
                b
            }
        }
        Binary::Max => {
            if a > b || a.is_nan() {
                a
            } else {
                b
            }
        }
        Binary::Less => truth(a < b),
        Binary::LessEqual => truth(a <= b),
        Binary::Equal => truth(a == b),
        Binary::And => truth(a != 0.0 && b != 0.0),
        Binary::Or => truth(a != 0.0 || b != 0.0),
    }
}

/// The remainder with the sign of the divisor.
fn modulo(a: f64, b: f64) -> f64 {
    let rest = a % b;
    if rest == 0.0 {
        0.0_f64.copysign(b)
    } else if (rest < 0.0) != (b < 0.0) {
        rest + b
    } else {
        rest
    }
}

/// NaN where the direction has no length or `up` lies along it.
fn orient(kind: Orient, direction: DVec3, up: DVec3) -> DQuat {
    let z = match kind {
        Orient::FaceTowards => direction,
        Orient::LookAlong => -direction,
    };
    facing(z, up).map_or(DQuat::NAN, |turn| unit(DQuat::from_mat3(&turn)))
}
