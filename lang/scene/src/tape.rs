//! Tapes: expressions over `time`, compiled to a list of f64 operations and kept as data.

use serde::{Deserialize, Serialize};

use crate::Keys;

/// The result of an instruction, by its index in [`Tape::code`].
pub type Register = u32;

/// A program over `time`. Instruction `i` writes register `i` and reads only registers below `i`, so a tape always ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tape {
    /// The instructions.
    pub code: Vec<Instruction>,
    /// Curves of keyframed numbers that [`Instruction::Keys`] reads.
    pub curves: Vec<Keys<f64>>,
    /// Curves of keyframed rotations that [`Instruction::Turn`] reads: their components do not move one by one.
    pub turns: Vec<Keys<glam::DQuat>>,
    /// The registers of the result's components.
    pub outputs: Vec<Register>,
}

/// One operation on f64 registers. Truth is 1, falsehood 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Instruction {
    /// A number.
    Const(f64),
    /// Seconds from the start of the scene.
    Time,
    /// `time` · fps.
    Frame,
    /// `curves[i]` at `time`.
    Keys(u32),
    /// Component 0..=3 (x, y, z, w) of `turns[i]` at `time`.
    Turn(u32, u8),
    /// One operand.
    Unary(Unary, Register),
    /// Two operands.
    Binary(Binary, Register, Register),
    /// The second register where the first is not 0, else the third.
    Select(Register, Register, Register),
    /// Component 0..=3 (x, y, z, w) of a rotation given by two directions.
    Orient(Orient, [Register; 3], [Register; 3], u8),
}

/// Operations on one number. Angles are radians.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Unary {
    Neg,
    Not,
    Abs,
    Sign,
    Floor,
    Ceil,
    Round,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
}

/// Operations on two numbers. `Mod` has the sign of the divisor, as the language's `mod`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Pow,
    Atan2,
    Min,
    Max,
    Less,
    LessEqual,
    Equal,
    And,
    Or,
}

/// A rotation from a direction and `up`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Orient {
    /// `face_towards(d, up:)`: local +z goes to d.
    FaceTowards,
    /// `look_at(from, to, up:)` with d = to − from: local −z goes to d.
    LookAlong,
}

impl Unary {
    /// What the operation computes: the one definition, for constants and for tapes.
    pub fn apply(self, a: f64) -> f64 {
        match self {
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
}

impl Binary {
    /// What the operation computes: the one definition, for constants and for tapes. A NaN is never dropped.
    pub fn apply(self, a: f64, b: f64) -> f64 {
        match self {
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
}

fn truth(condition: bool) -> f64 {
    f64::from(u8::from(condition))
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
