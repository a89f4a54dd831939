//! Tapes: expressions over `time` and over the point of a surface, compiled to a list of f64 operations and kept as data.

use serde::{Deserialize, Serialize};

use crate::Keys;
use crate::noise::cellular_noise;

/// The result of an instruction, by its index in [`Tape::code`].
pub type Register = u32;

/// A program over `time`, and over the point of a surface where it is a texture's. Instruction `i` writes register `i` and reads only registers below `i`, so a tape always ends.
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
    /// What the tape is given, where it is an easing: the part of a segment's time that has passed, 0..=1.
    Input,
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
    /// Component 0..=2 of what is known of the point of a surface; only in a texture's tape.
    Point(Point, u8),
    /// [`crate::gradient_noise`] at a point.
    Noise([Register; 3]),
    /// [`cellular_noise`] at a point, over so many of its coordinates.
    Cell(Cell, u8, [Register; 3]),
    /// A step of `rand`: of the first two registers, the halves of a state, and the third, which is absorbed.
    Rand(Rand, [Register; 3]),
    /// Component 0..=3 (x, y, z, w) of a rotation given by two directions.
    Orient(Orient, [Register; 3], [Register; 3], u8),
}

/// What is known of the point of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Point {
    /// Where it is in the world, metres: x, y, z.
    World,
    /// Where it is in the shape's own space, before it is placed, metres: x, y, z.
    Local,
    /// Its texture coordinates: u, v.
    Uv,
    /// The outward unit normal that it is shaded with, in the world: x, y, z.
    Normal,
}

/// What is told of the nearest point of [`cellular_noise`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cell {
    /// How far it is.
    Distance,
    /// Its number.
    Id,
}

impl Cell {
    /// What the operation computes.
    pub fn apply(self, axes: u8, at: [f64; 3]) -> f64 {
        cellular_noise(at, axes)[self as usize]
    }
}

impl Instruction {
    /// The registers that it reads.
    pub fn reads(&self, mut read: impl FnMut(Register)) {
        match *self {
            Instruction::Const(_)
            | Instruction::Time
            | Instruction::Frame
            | Instruction::Input
            | Instruction::Keys(_)
            | Instruction::Turn(..)
            | Instruction::Point(..) => {}
            Instruction::Unary(_, a) => read(a),
            Instruction::Binary(_, a, b) => [a, b].into_iter().for_each(read),
            Instruction::Select(a, b, c)
            | Instruction::Noise([a, b, c])
            | Instruction::Cell(_, _, [a, b, c])
            | Instruction::Rand(_, [a, b, c]) => {
                [a, b, c].into_iter().for_each(read);
            }
            Instruction::Orient(_, a, b, _) => a.into_iter().chain(b).for_each(&mut read),
        }
    }
}

impl Tape {
    /// Whether it reads this of the point of a surface.
    pub fn reads(&self, point: Point) -> bool {
        self.code.iter().any(|instruction| matches!(instruction, Instruction::Point(other, _) if *other == point))
    }

    /// Whether it changes over time.
    pub fn moves(&self) -> bool {
        let moving = |instruction: &Instruction| {
            use Instruction::{Frame, Keys, Time, Turn};
            matches!(instruction, Time | Frame | Keys(_) | Turn(..))
        };
        self.code.iter().any(moving)
    }

    /// Of each register, whether it differs from point to point of a surface.
    pub fn varying(&self) -> Vec<bool> {
        let mut varying: Vec<bool> = Vec::with_capacity(self.code.len());
        for instruction in &self.code {
            let mut varies = matches!(instruction, Instruction::Point(..));
            instruction.reads(|register| varies |= varying.get(register as usize) == Some(&true));
            varying.push(varies);
        }
        varying
    }
}

/// What is wanted of a step of `rand`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rand {
    /// The upper 32 bits of the next state.
    High,
    /// The lower 32 bits of it.
    Low,
    /// The state as a number in 0..1; nothing is absorbed.
    Unit,
}

impl Rand {
    /// What the operation computes.
    pub fn apply(self, [high, low, word]: [f64; 3]) -> f64 {
        let state = ((high as u64) << 32) | low as u64;
        match self {
            Rand::High => (absorb(state, word.to_bits()) >> 32) as f64,
            Rand::Low => f64::from(absorb(state, word.to_bits()) as u32),
            Rand::Unit => unit(state),
        }
    }
}

/// The finaliser of SplitMix64 (Steele et al. 2014, variant 13 of Stafford).
fn scramble(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

fn absorb(state: u64, word: u64) -> u64 {
    scramble(state.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ scramble(word.wrapping_add(0xd1b5_4a32_d192_ed03)))
}

/// The top 53 bits as a number in 0..1, 1 excluded.
fn unit(state: u64) -> f64 {
    (scramble(state) >> 11) as f64 / (1u64 << 53) as f64
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
