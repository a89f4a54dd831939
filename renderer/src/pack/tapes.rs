//! Tapes as words that the kernel runs.

use glam::{Vec3, Vec4};
use kinora_kernel::generated::{
    TAPE_ABS, TAPE_ACOS, TAPE_ADD, TAPE_AND, TAPE_ASIN, TAPE_ATAN, TAPE_ATAN2, TAPE_CEIL, TAPE_CELL_1, TAPE_CELL_ID_1,
    TAPE_COPY, TAPE_COS, TAPE_DIV, TAPE_EQUAL, TAPE_EXP, TAPE_FLOOR, TAPE_LESS, TAPE_LESS_EQUAL, TAPE_LOCAL, TAPE_LOG,
    TAPE_LONGEST, TAPE_MAX, TAPE_MIN, TAPE_MOD, TAPE_MUL, TAPE_NEG, TAPE_NOISE, TAPE_NORMAL, TAPE_NOT, TAPE_NUMBER,
    TAPE_OR, TAPE_POW, TAPE_READS_LOCAL, TAPE_ROUND, TAPE_SELECT, TAPE_SIGN, TAPE_SIN, TAPE_SQRT, TAPE_SUB, TAPE_TAN,
    TAPE_UV, TAPE_WORLD, TEXTURE_TAPE,
};
use kinora_scene::{Binary, Cell, Map, Operand, Operation, Paint, Point, Program, STEPS, Tape, Texture, Unary, VALUES};

use super::PackError;

// What fits into a program fits into the kernel.
const _: () = assert!(VALUES == TAPE_NUMBER as usize && STEPS == TAPE_LONGEST as usize);

/// The header and the steps of a tape.
///
/// # Errors
/// It is too long.
pub fn words(tape: &Tape) -> Result<Vec<u32>, PackError> {
    let program = program(tape)?;
    let output = |i: usize| program.outputs.get(i).or(program.outputs.first()).map_or(TAPE_NUMBER, |&o| place(o));
    let local = if tape.reads(Point::Local) { TAPE_READS_LOCAL } else { 0 };
    let outputs = output(0) | output(1) << 6 | output(2) << 12;
    let mut words = vec![TEXTURE_TAPE | local, program.steps.len() as u32, outputs];
    for step in &program.steps {
        let [a, b, c] = step.from.map(place);
        words.push(code(step.operation) | u32::from(step.to) << 8 | a << 14 | b << 20 | c << 26);
        words.push(step.number.to_bits());
    }
    Ok(words)
}

fn program(tape: &Tape) -> Result<Program, PackError> {
    Program::new(tape).map_err(|_| PackError::Tape { limit: STEPS })
}

/// Whether any of the maps, textures inside others included, reads where its point is in the shape's own space.
pub fn reads_local(maps: &[Map]) -> bool {
    fn reads(texture: &Texture) -> bool {
        let inside = |paint: &Paint| matches!(paint, Paint::Texture(inside) if reads(inside));
        match texture {
            Texture::Tape(tape) => tape.reads(Point::Local),
            Texture::Checker { a, b, .. } => inside(a) || inside(b),
            _ => false,
        }
    }
    maps.iter().any(|map| reads(&map.texture))
}

/// About the mean of a tape over a surface somewhere about the origin; above 0, since nobody knows where the surface is.
pub fn average(tape: &Tape) -> Vec4 {
    const SAMPLES: u32 = 256;
    let Ok(program) = program(tape) else { return Vec4::ONE };
    let mut sum = Vec3::ZERO;
    for i in 1..=SAMPLES {
        // The additive recurrence of Roberts (2018).
        let u = |power: i32| (0.5 + f64::from(i) / 1.324_717_957_244_746_f64.powi(power)).fract();
        let z = 2.0 * u(1) - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * u(2)).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let normal = [r * cos, r * sin, z];
        let value = program.run(|point, part| match point {
            Point::World | Point::Local | Point::Normal => normal[usize::from(part) % 3],
            Point::Uv => [u(1), u(2)][usize::from(part) % 2],
        });
        let channel = |i: usize| match value.get(i).or(value.first()) {
            Some(x) if x.is_finite() => x.max(0.0) as f32,
            _ => 0.0,
        };
        sum += Vec3::new(channel(0), channel(1), channel(2));
    }
    (sum / SAMPLES as f32).max(Vec3::splat(0.01)).extend(1.0)
}

fn place(operand: Operand) -> u32 {
    match operand {
        Operand::Register(register) => u32::from(register),
        Operand::Number => TAPE_NUMBER,
        Operand::Point(point, part) => {
            let (first, count) = match point {
                Point::World => (TAPE_WORLD, 3),
                Point::Local => (TAPE_LOCAL, 3),
                Point::Uv => (TAPE_UV, 2),
                Point::Normal => (TAPE_NORMAL, 3),
            };
            first + u32::from(part) % count
        }
    }
}

fn code(operation: Operation) -> u32 {
    match operation {
        Operation::Copy => TAPE_COPY,
        Operation::Unary(unary) => match unary {
            Unary::Neg => TAPE_NEG,
            Unary::Not => TAPE_NOT,
            Unary::Abs => TAPE_ABS,
            Unary::Sign => TAPE_SIGN,
            Unary::Floor => TAPE_FLOOR,
            Unary::Ceil => TAPE_CEIL,
            Unary::Round => TAPE_ROUND,
            Unary::Sqrt => TAPE_SQRT,
            Unary::Exp => TAPE_EXP,
            Unary::Log => TAPE_LOG,
            Unary::Sin => TAPE_SIN,
            Unary::Cos => TAPE_COS,
            Unary::Tan => TAPE_TAN,
            Unary::Asin => TAPE_ASIN,
            Unary::Acos => TAPE_ACOS,
            Unary::Atan => TAPE_ATAN,
        },
        Operation::Binary(binary) => match binary {
            Binary::Add => TAPE_ADD,
            Binary::Sub => TAPE_SUB,
            Binary::Mul => TAPE_MUL,
            Binary::Div => TAPE_DIV,
            Binary::Mod => TAPE_MOD,
            Binary::Pow => TAPE_POW,
            Binary::Atan2 => TAPE_ATAN2,
            Binary::Min => TAPE_MIN,
            Binary::Max => TAPE_MAX,
            Binary::Less => TAPE_LESS,
            Binary::LessEqual => TAPE_LESS_EQUAL,
            Binary::Equal => TAPE_EQUAL,
            Binary::And => TAPE_AND,
            Binary::Or => TAPE_OR,
        },
        Operation::Select => TAPE_SELECT,
        Operation::Noise => TAPE_NOISE,
        Operation::Cell(cell, axes) => {
            let first = match cell {
                Cell::Distance => TAPE_CELL_1,
                Cell::Id => TAPE_CELL_ID_1,
            };
            first + u32::from(axes.clamp(1, 3)) - 1
        }
    }
}
