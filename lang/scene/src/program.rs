//! Tapes over the point of a surface, made ready for the kernel: few registers, and next to none of the constants in them.

use std::collections::HashMap;

use crate::{Binary, Cell, Instruction, Point, Register, Tape, Unary, gradient_noise};

/// The most steps of a program.
pub const STEPS: usize = 1024;
/// The most values that a program keeps at once, the point and constants not counted.
pub const VALUES: usize = 52;

/// A tape as the kernel runs it: the steps in order, on [`VALUES`] registers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Program {
    /// At most [`STEPS`].
    pub steps: Vec<Step>,
    /// Where the outputs are in the end.
    pub outputs: Vec<Operand>,
}

/// One operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// What is done.
    pub operation: Operation,
    /// The register that is written, below [`VALUES`].
    pub to: u8,
    /// What it is done with; what the operation does not need repeats the first.
    pub from: [Operand; 3],
    /// What [`Operand::Number`] stands for.
    pub number: f32,
}

/// What a step does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// Gives the first operand.
    Copy,
    /// See [`Unary::apply`].
    Unary(Unary),
    /// See [`Binary::apply`].
    Binary(Binary),
    /// The second where the first is not 0, else the third.
    Select,
    /// [`crate::gradient_noise`].
    Noise,
    /// [`crate::cellular_noise`].
    Cell(Cell, u8),
}

/// Where a step finds a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A register, below [`VALUES`].
    Register(u8),
    /// The step's own number.
    Number,
    /// A component of what is known of the point.
    Point(Point, u8),
}

/// Why a tape makes no program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// It has more than [`STEPS`] steps.
    Steps,
    /// More than [`VALUES`] values are needed at once.
    Values,
    /// A rotation is made from a direction that differs from point to point.
    Rotation,
}

impl Program {
    /// The program of a tape. What only moves with time must be a constant by then, else it is NaN.
    ///
    /// # Errors
    /// It does not fit.
    pub fn new(tape: &Tape) -> Result<Program, Unfit> {
        let flow = Flow::new(tape);
        let order = flow.needed()?;
        let deep = flow.depth_first();
        // As written, values are used soon after they are made; from the outputs down, no value is made before it is
        // needed. Which of the two keeps fewer differs from tape to tape.
        let [written, deep] = [flow.emit(&order), flow.emit(&deep)];
        let (program, values) = match (written, deep) {
            (Some(written), Some(deep)) if deep.1 < written.1 => deep,
            (Some(written), _) => written,
            (None, Some(deep)) => deep,
            (None, None) => return Err(Unfit::Rotation),
        };
        match values {
            _ if program.steps.len() > STEPS => Err(Unfit::Steps),
            values if values > VALUES => Err(Unfit::Values),
            _ => Ok(program),
        }
    }
}

impl Program {
    /// What the outputs are where `point` tells of the point of a surface, in f64.
    pub fn run(&self, point: impl Fn(Point, u8) -> f64) -> Vec<f64> {
        let mut registers = [f64::NAN; VALUES];
        let read = |registers: &[f64; VALUES], operand, number: f32| match operand {
            Operand::Register(register) => registers.get(usize::from(register)).copied().unwrap_or(f64::NAN),
            Operand::Number => f64::from(number),
            Operand::Point(of, part) => point(of, part),
        };
        for step in &self.steps {
            let [a, b, c] = step.from.map(|operand| read(&registers, operand, step.number));
            let value = match step.operation {
                Operation::Copy => a,
                Operation::Unary(unary) => unary.apply(a),
                Operation::Binary(binary) => binary.apply(a, b),
                Operation::Select => {
                    if a != 0.0 {
                        b
                    } else {
                        c
                    }
                }
                Operation::Noise => gradient_noise([a, b, c]),
                Operation::Cell(cell, axes) => cell.apply(axes, [a, b, c]),
            };
            if let Some(register) = registers.get_mut(usize::from(step.to)) {
                *register = value;
            }
        }
        self.outputs.iter().map(|&output| read(&registers, output, 0.0)).collect()
    }
}

/// A tape and what is known of its registers.
struct Flow<'t> {
    tape: &'t Tape,
    varying: Vec<bool>,
}

/// A value before it has a register.
#[derive(Clone, Copy, PartialEq)]
enum Read {
    Made(Register),
    Number(f32),
    Point(Point, u8),
}

impl<'t> Flow<'t> {
    fn new(tape: &'t Tape) -> Self {
        Flow { tape, varying: tape.varying() }
    }

    fn at(&self, register: Register) -> Instruction {
        self.tape.code.get(register as usize).copied().unwrap_or(Instruction::Const(f64::NAN))
    }

    fn read(&self, register: Register) -> Read {
        match self.at(register) {
            Instruction::Point(point, part) => Read::Point(point, part),
            Instruction::Const(number) => Read::Number(number as f32),
            _ if self.varying.get(register as usize) == Some(&true) => Read::Made(register),
            _ => Read::Number(f32::NAN),
        }
    }

    /// What a step of its own makes, from registers that do so too.
    fn below(&self, register: Register) -> Vec<Register> {
        let mut below = Vec::new();
        self.at(register).reads(|other| {
            if let Read::Made(other) = self.read(other)
                && !below.contains(&other)
            {
                below.push(other);
            }
        });
        below
    }

    fn roots(&self) -> impl Iterator<Item = Register> {
        self.tape.outputs.iter().copied().filter(|&output| matches!(self.read(output), Read::Made(_)))
    }

    /// All that is needed, as written.
    fn needed(&self) -> Result<Vec<Register>, Unfit> {
        let mut needed = std::collections::BTreeSet::new();
        let mut open: Vec<Register> = self.roots().collect();
        while let Some(register) = open.pop() {
            if needed.insert(register) {
                open.extend(self.below(register));
            }
            if needed.len() > STEPS {
                return Err(Unfit::Steps);
            }
        }
        Ok(needed.into_iter().collect())
    }

    /// All that is needed, each after what it needs, and of two the one that keeps more values at once first (Sethi and
    /// Ullman 1970).
    fn depth_first(&self) -> Vec<Register> {
        let mut weights = HashMap::new();
        for root in self.roots() {
            self.weigh(root, &mut weights);
        }
        let mut order = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for root in self.roots() {
            self.visit(root, &weights, &mut seen, &mut order);
        }
        order
    }

    // No deeper than there are steps.
    fn weigh(&self, register: Register, weights: &mut HashMap<Register, usize>) -> usize {
        if let Some(known) = weights.get(&register) {
            return *known;
        }
        let mut below: Vec<usize> = self.below(register).into_iter().map(|other| self.weigh(other, weights)).collect();
        below.sort_unstable_by(|a, b| b.cmp(a));
        let weight = below.iter().enumerate().map(|(i, weight)| i + weight).max().unwrap_or(1).max(1);
        weights.insert(register, weight);
        weight
    }

    fn visit(
        &self,
        register: Register,
        weights: &HashMap<Register, usize>,
        seen: &mut std::collections::HashSet<Register>,
        order: &mut Vec<Register>,
    ) {
        if !seen.insert(register) {
            return;
        }
        let mut below = self.below(register);
        below.sort_by_key(|other| std::cmp::Reverse(weights.get(other).copied().unwrap_or(0)));
        for other in below {
            self.visit(other, weights, seen, order);
        }
        order.push(register);
    }

    /// The steps in this order, and how many registers they take; `None` where one of them is no step.
    fn emit(&self, order: &[Register]) -> Option<(Program, usize)> {
        let mut uses: HashMap<Register, usize> = HashMap::new();
        for &register in order {
            for other in self.below(register) {
                *uses.entry(other).or_default() += 1;
            }
        }
        for root in self.roots() {
            *uses.entry(root).or_default() += 1;
        }
        let mut emitter = Emitter::default();
        for &register in order {
            let (operation, reads) = match self.at(register) {
                // A product has the sign that a power by logarithms must work out.
                Instruction::Binary(Binary::Pow, a, b) if self.read(b) == Read::Number(2.0) => {
                    (Operation::Binary(Binary::Mul), vec![a, a])
                }
                other => operation(other)?,
            };
            let from = reads.iter().map(|&other| self.read(other));
            let below = self.below(register);
            emitter.step(operation, &from.collect::<Vec<_>>(), Some(register), || {
                let mut done = Vec::new();
                for other in below {
                    let left = uses.entry(other).or_default();
                    *left -= 1;
                    if *left == 0 {
                        done.push(other);
                    }
                }
                done
            });
        }
        let outputs = self.tape.outputs.iter().map(|&output| match self.read(output) {
            Read::Made(register) => emitter.place(register),
            Read::Point(point, part) => Operand::Point(point, part),
            number => emitter.step(Operation::Copy, &[number], None, Vec::new),
        });
        let outputs = outputs.collect();
        Some((Program { steps: emitter.steps, outputs }, emitter.most))
    }
}

/// What a tape's instruction does and reads.
fn operation(instruction: Instruction) -> Option<(Operation, Vec<Register>)> {
    Some(match instruction {
        Instruction::Unary(unary, a) => (Operation::Unary(unary), vec![a]),
        Instruction::Binary(binary, a, b) => (Operation::Binary(binary), vec![a, b]),
        Instruction::Select(a, b, c) => (Operation::Select, vec![a, b, c]),
        Instruction::Noise(at) => (Operation::Noise, at.to_vec()),
        Instruction::Cell(cell, axes, at) => (Operation::Cell(cell, axes), at.to_vec()),
        _ => return None,
    })
}

/// Steps as they are made, and which registers are free.
#[derive(Default)]
struct Emitter {
    steps: Vec<Step>,
    places: HashMap<Register, usize>,
    taken: Vec<bool>,
    most: usize,
}

impl Emitter {
    fn take(&mut self) -> usize {
        let free = self.taken.iter().position(|taken| !taken).unwrap_or_else(|| {
            self.taken.push(false);
            self.taken.len() - 1
        });
        self.taken[free] = true;
        self.most = self.most.max(free + 1);
        free
    }

    fn place(&self, register: Register) -> Operand {
        Operand::Register(self.places.get(&register).copied().unwrap_or(0) as u8)
    }

    /// Adds a step; `done` gives what is not read after it. Numbers beyond the first get steps of their own.
    fn step(
        &mut self,
        operation: Operation,
        from: &[Read],
        result: Option<Register>,
        done: impl FnOnce() -> Vec<Register>,
    ) -> Operand {
        let mut number: Option<f32> = None;
        let mut copies = Vec::new();
        let mut operands = Vec::with_capacity(3);
        for &from in from {
            operands.push(match from {
                Read::Made(register) => self.place(register),
                Read::Point(point, part) => Operand::Point(point, part),
                Read::Number(value) if number.is_none_or(|number| number.to_bits() == value.to_bits()) => {
                    number = Some(value);
                    Operand::Number
                }
                Read::Number(value) => {
                    let to = self.take();
                    copies.push(to);
                    let from = [Operand::Number; 3];
                    self.steps.push(Step { operation: Operation::Copy, to: to as u8, from, number: value });
                    Operand::Register(to as u8)
                }
            });
        }
        for copy in copies {
            self.taken[copy] = false;
        }
        for register in done() {
            if let Some(place) = self.places.remove(&register) {
                self.taken[place] = false;
            }
        }
        let to = self.take();
        if let Some(result) = result {
            self.places.insert(result, to);
        }
        let first = operands.first().copied().unwrap_or(Operand::Number);
        operands.resize(3, first);
        let from = [operands[0], operands[1], operands[2]];
        self.steps.push(Step { operation, to: to as u8, from, number: number.unwrap_or(0.0) });
        Operand::Register(to as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: [f64; 3] = [0.3, -0.7, 1.9];

    fn tape(code: Vec<Instruction>, outputs: &[Register]) -> Tape {
        Tape { code, outputs: outputs.to_vec(), ..Tape::default() }
    }

    /// Runs a program and the same tape by its definition.
    fn check(tape: &Tape) -> Program {
        let program = Program::new(tape).expect("it fits");
        let mut registers: Vec<f64> = Vec::new();
        for instruction in &tape.code {
            let read = |register: &Register| registers[*register as usize];
            let value = match instruction {
                Instruction::Const(value) => *value,
                Instruction::Point(_, part) => POINT[usize::from(*part)],
                Instruction::Unary(unary, a) => unary.apply(read(a)),
                Instruction::Binary(binary, a, b) => binary.apply(read(a), read(b)),
                Instruction::Select(a, b, c) => read(if read(a) != 0.0 { b } else { c }),
                Instruction::Noise(at) => gradient_noise([0, 1, 2].map(|i| read(&at[i]))),
                Instruction::Cell(cell, axes, at) => cell.apply(*axes, [0, 1, 2].map(|i| read(&at[i]))),
                other => panic!("{other:?}"),
            };
            registers.push(value);
        }
        let expected: Vec<f64> = tape.outputs.iter().map(|output| registers[*output as usize]).collect();
        let found = program.run(|_, part| POINT[usize::from(part)]);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}: {program:?}");
        }
        program
    }

    #[test]
    fn numbers_ride_along() {
        use Instruction::{Const, Point as P, Select};
        let code = vec![
            P(Point::World, 0),
            Const(2.0),
            Instruction::Binary(Binary::Pow, 0, 1),
            Const(0.25),
            Instruction::Binary(Binary::Less, 2, 3),
            Const(5.0),
            Select(4, 3, 5),
            Instruction::Noise([0, 3, 3]),
            Instruction::Binary(Binary::Add, 6, 7),
        ];
        let program = check(&tape(code, &[8, 5, 0]));
        // The square, the comparison, a number of its own, the choice, noise, the sum; then the constant output.
        assert_eq!(program.steps.len(), 7);
        assert_eq!(program.outputs[2], Operand::Point(Point::World, 0));
    }

    #[test]
    fn values_made_early_and_used_late_do_not_pile_up() {
        use Instruction::{Const, Point as P};
        let mut code = vec![P(Point::World, 0)];
        let mut values = Vec::new();
        for i in 0..100 {
            code.push(Const(f64::from(i)));
            code.push(Instruction::Binary(Binary::Mul, 0, code.len() as u32 - 1));
            values.push(code.len() as u32 - 1);
        }
        let mut sum = values[0];
        for value in &values[1..] {
            code.push(Instruction::Binary(Binary::Add, sum, *value));
            sum = code.len() as u32 - 1;
        }
        check(&tape(code, &[sum]));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        use Instruction::{Point as P, Unary as U};
        let mut code = vec![P(Point::Uv, 0)];
        for i in 0..=STEPS as u32 {
            code.push(U(Unary::Sin, i));
        }
        assert_eq!(Program::new(&tape(code.clone(), &[STEPS as u32])).map(|p| p.steps.len()), Ok(STEPS));
        assert_eq!(Program::new(&tape(code, &[STEPS as u32 + 1])).err(), Some(Unfit::Steps));
        // Each of many values is used by each of two sums that run in opposite directions.
        let mut code = vec![P(Point::Uv, 0)];
        for i in 0..VALUES as u32 + 2 {
            code.push(U(Unary::Sin, i));
        }
        let last = VALUES as u32 + 2;
        let mut sum = [1, last];
        for i in 1..last {
            for (sum, next) in sum.iter_mut().zip([i + 1, last - i]) {
                code.push(Instruction::Binary(Binary::Add, *sum, next));
                *sum = code.len() as u32 - 1;
            }
        }
        assert_eq!(Program::new(&tape(code, &sum)).err(), Some(Unfit::Values));
    }
}
