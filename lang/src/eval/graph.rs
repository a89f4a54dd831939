//! Numbers that may depend on time, or on the point of a surface: constants fold at once, everything else becomes an operation in one arena, from
//! which the tape of a property is cut out.

use std::collections::{BTreeSet, HashMap};

use glam::DQuat;
use kinora_scene::{Binary, Cell, Instruction, Keys, Orient, Point, Rand, Tape, Unary, gradient_noise};

use crate::eval::surface::Points;

/// A number: known, or the result of an operation in a [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scalar {
    /// The same at all times and everywhere.
    Const(f64),
    /// The register of an operation.
    Moving(u32),
}

impl Scalar {
    /// The value, if it is the same at all times.
    pub fn constant(self) -> Option<f64> {
        match self {
            Scalar::Const(value) => Some(value),
            Scalar::Moving(_) => None,
        }
    }
}

impl From<f64> for Scalar {
    fn from(value: f64) -> Self {
        Scalar::Const(value)
    }
}

/// All operations of one evaluation, each once: instruction `i` reads registers below `i`, as in a [`Tape`].
#[derive(Debug, Default)]
pub struct Graph {
    code: Vec<Instruction>,
    /// What each operation needs to know of the point of a surface.
    points: Vec<Points>,
    curves: Vec<Keys<f64>>,
    turns: Vec<Keys<DQuat>>,
    known: HashMap<[u64; 4], u32>,
    /// Steps that noise and colours took, beside one a call; whoever counts steps takes them away.
    pub work: u64,
}

impl Graph {
    /// How many operations there are.
    pub fn size(&self) -> usize {
        self.code.len()
    }

    fn push(&mut self, key: [u64; 4], instruction: Instruction) -> Scalar {
        let next = self.code.len() as u32;
        let register = *self.known.entry(key).or_insert(next);
        if register == next {
            let mut points = match instruction {
                Instruction::Point(point, _) => Points::of(point),
                Instruction::Input => Points::INPUT,
                _ => Points::default(),
            };
            instruction.reads(|below| points = points.and(self.points[below as usize]));
            self.points.push(points);
            self.code.push(instruction);
        }
        Scalar::Moving(register)
    }

    fn register(&mut self, scalar: Scalar) -> u32 {
        match scalar {
            Scalar::Moving(register) => register,
            Scalar::Const(value) => match self.push([0, value.to_bits(), 0, 0], Instruction::Const(value)) {
                Scalar::Moving(register) => register,
                Scalar::Const(_) => 0,
            },
        }
    }

    /// Seconds from the start of the scene.
    pub fn time(&mut self) -> Scalar {
        self.push([1, 0, 0, 0], Instruction::Time)
    }

    /// `time` · fps.
    pub fn frame(&mut self) -> Scalar {
        self.push([2, 0, 0, 0], Instruction::Frame)
    }

    /// What a function is given that becomes an easing.
    pub fn input(&mut self) -> Scalar {
        self.push([26, 0, 0, 0], Instruction::Input)
    }

    /// A component of what is known of the point of a surface.
    pub fn point(&mut self, point: Point, part: u8) -> Scalar {
        self.push([16, point as u64, u64::from(part), 0], Instruction::Point(point, part))
    }

    /// What the numbers need to know of the point of a surface.
    pub fn points(&self, scalars: &[Scalar]) -> Points {
        let of = |scalar: &Scalar| match scalar {
            Scalar::Const(_) => Points::default(),
            Scalar::Moving(register) => self.points[*register as usize],
        };
        scalars.iter().map(of).fold(Points::default(), Points::and)
    }

    /// Gradient noise at a point.
    pub fn noise(&mut self, at: [Scalar; 3]) -> Scalar {
        if let [Scalar::Const(x), Scalar::Const(y), Scalar::Const(z)] = at {
            self.work += 2;
            return Scalar::Const(gradient_noise([x, y, z]));
        }
        let at = at.map(|part| self.register(part));
        self.push([17, at[0].into(), at[1].into(), at[2].into()], Instruction::Noise(at))
    }

    /// Cellular noise at a point, over the first `axes` of its coordinates.
    pub fn cell(&mut self, cell: Cell, axes: u8, at: [Scalar; 3]) -> Scalar {
        if let [Scalar::Const(x), Scalar::Const(y), Scalar::Const(z)] = at {
            self.work += 4;
            return Scalar::Const(cell.apply(axes, [x, y, z]));
        }
        let at = at.map(|part| self.register(part));
        let tag = 18 + 4 * cell as u64 + u64::from(axes);
        self.push([tag, at[0].into(), at[1].into(), at[2].into()], Instruction::Cell(cell, axes, at))
    }

    /// A step of `rand`.
    pub fn rand(&mut self, rand: Rand, of: [Scalar; 3]) -> Scalar {
        if let [Scalar::Const(high), Scalar::Const(low), Scalar::Const(word)] = of {
            return Scalar::Const(rand.apply([high, low, word]));
        }
        let of = of.map(|part| self.register(part));
        self.push([27 + rand as u64, of[0].into(), of[1].into(), of[2].into()], Instruction::Rand(rand, of))
    }

    /// A curve of keyframed numbers.
    pub fn curve(&mut self, keys: Keys<f64>) -> Scalar {
        let index = self.curves.len() as u32;
        self.curves.push(keys);
        self.push([3, u64::from(index), 0, 0], Instruction::Keys(index))
    }

    /// The four components of keyframed rotations.
    pub fn turn(&mut self, keys: Keys<DQuat>) -> [Scalar; 4] {
        let index = self.turns.len() as u32;
        self.turns.push(keys);
        [0, 1, 2, 3].map(|part| self.push([4, u64::from(index), part, 0], Instruction::Turn(index, part as u8)))
    }

    /// One operand.
    pub fn unary(&mut self, op: Unary, a: Scalar) -> Scalar {
        if let Scalar::Const(a) = a {
            return Scalar::Const(op.apply(a));
        }
        let a = self.register(a);
        self.push([5, op as u64, u64::from(a), 0], Instruction::Unary(op, a))
    }

    /// Two operands.
    pub fn binary(&mut self, op: Binary, a: Scalar, b: Scalar) -> Scalar {
        match (op, a, b) {
            (_, Scalar::Const(a), Scalar::Const(b)) => return Scalar::Const(op.apply(a, b)),
            (Binary::Add, Scalar::Const(0.0), other) => return other,
            (Binary::Add | Binary::Sub, other, Scalar::Const(0.0)) => return other,
            (Binary::Mul, Scalar::Const(1.0), other) => return other,
            (Binary::Mul | Binary::Div, other, Scalar::Const(1.0)) => return other,
            _ => {}
        }
        let (a, b) = (self.register(a), self.register(b));
        self.push([6, op as u64, u64::from(a), u64::from(b)], Instruction::Binary(op, a, b))
    }

    /// `yes` where `condition` is not 0, else `no`.
    pub fn select(&mut self, condition: Scalar, yes: Scalar, no: Scalar) -> Scalar {
        if let Scalar::Const(condition) = condition {
            return if condition != 0.0 { yes } else { no };
        }
        if yes == no {
            return yes;
        }
        let [c, y, n] = [condition, yes, no].map(|scalar| self.register(scalar));
        self.push([7, u64::from(c), u64::from(y), u64::from(n)], Instruction::Select(c, y, n))
    }

    /// The four components of a rotation given by two directions, where one of them moves.
    pub fn orient(&mut self, orient: Orient, direction: [Scalar; 3], up: [Scalar; 3]) -> [Scalar; 4] {
        let direction = direction.map(|scalar| self.register(scalar));
        let up = up.map(|scalar| self.register(scalar));
        let pack = |three: [u32; 3]| (u64::from(three[0]) << 32) | u64::from(three[1]);
        let third = (u64::from(direction[2]) << 32) | u64::from(up[2]);
        [0, 1, 2, 3].map(|part| {
            let tag = 8 + orient as u64 * 4 + part;
            let instruction = Instruction::Orient(orient, direction, up, part as u8);
            self.push([tag, pack(direction), pack(up), third], instruction)
        })
    }

    /// a + b
    pub fn add(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.binary(Binary::Add, a, b)
    }

    /// a - b
    pub fn sub(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.binary(Binary::Sub, a, b)
    }

    /// a · b
    pub fn mul(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.binary(Binary::Mul, a, b)
    }

    /// a / b
    pub fn div(&mut self, a: Scalar, b: Scalar) -> Scalar {
        self.binary(Binary::Div, a, b)
    }

    /// The scalar product.
    pub fn dot(&mut self, a: &[Scalar], b: &[Scalar]) -> Scalar {
        let mut sum = Scalar::Const(0.0);
        for (a, b) in a.iter().zip(b) {
            let product = self.mul(*a, *b);
            sum = self.add(sum, product);
        }
        sum
    }

    /// The tape that computes `outputs`, with nothing in it that they do not need.
    pub fn tape(&mut self, outputs: &[Scalar]) -> Tape {
        let outputs: Vec<u32> = outputs.iter().map(|scalar| self.register(*scalar)).collect();
        let mut needed = BTreeSet::new();
        let mut open = outputs.clone();
        while let Some(register) = open.pop() {
            if needed.insert(register) {
                self.code[register as usize].reads(|below| open.push(below));
            }
        }
        let mut tape = Tape::default();
        let mut renamed = HashMap::new();
        let (mut curves, mut turns) = (HashMap::new(), HashMap::new());
        for register in needed {
            let to = |old: u32| renamed.get(&old).copied().unwrap_or(0);
            let instruction = match self.code[register as usize] {
                Instruction::Keys(index) => Instruction::Keys(*curves.entry(index).or_insert_with(|| {
                    tape.curves.push(self.curves[index as usize].clone());
                    tape.curves.len() as u32 - 1
                })),
                Instruction::Turn(index, part) => {
                    let index = *turns.entry(index).or_insert_with(|| {
                        tape.turns.push(self.turns[index as usize].clone());
                        tape.turns.len() as u32 - 1
                    });
                    Instruction::Turn(index, part)
                }
                Instruction::Unary(op, a) => Instruction::Unary(op, to(a)),
                Instruction::Binary(op, a, b) => Instruction::Binary(op, to(a), to(b)),
                Instruction::Select(a, b, c) => Instruction::Select(to(a), to(b), to(c)),
                Instruction::Orient(orient, a, b, part) => Instruction::Orient(orient, a.map(to), b.map(to), part),
                Instruction::Noise(at) => Instruction::Noise(at.map(to)),
                Instruction::Rand(rand, of) => Instruction::Rand(rand, of.map(to)),
                Instruction::Cell(cell, axes, at) => Instruction::Cell(cell, axes, at.map(to)),
                other => other,
            };
            renamed.insert(register, tape.code.len() as u32);
            tape.code.push(instruction);
        }
        tape.outputs = outputs.iter().map(|old| renamed.get(old).copied().unwrap_or(0)).collect();
        tape
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_fold_and_twins_merge() {
        let mut graph = Graph::default();
        let sum = graph.add(2.0.into(), 3.0.into());
        assert_eq!((sum, graph.size()), (Scalar::Const(5.0), 0));
        let time = graph.time();
        let unused = graph.mul(time, 7.0.into());
        let a = graph.mul(time, 2.0.into());
        let b = graph.mul(time, 2.0.into());
        assert_eq!(a, b);
        assert_eq!(graph.add(unused, 0.0.into()), unused);
        let tape = graph.tape(&[a, 1.5.into(), a]);
        assert_eq!(
            tape.code,
            [
                Instruction::Time,
                Instruction::Const(2.0),
                Instruction::Binary(Binary::Mul, 0, 1),
                Instruction::Const(1.5)
            ]
        );
        assert_eq!(tape.outputs, [2, 3, 2]);
    }

    #[test]
    fn mod_takes_the_sign_of_the_divisor() {
        for (a, b, expected) in [(7.0, 3.0, 1.0), (-7.0, 3.0, 2.0), (7.0, -3.0, -2.0), (-7.0, -3.0, -1.0)] {
            assert_eq!(Binary::Mod.apply(a, b), expected, "{a} {b}");
        }
    }
}
