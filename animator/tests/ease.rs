//! Timing curves against tables and closed forms.

use std::f64::consts::PI;
use std::sync::Arc;

use kinora_animator::ease;
use kinora_scene::{Bezier, Binary, Direction, Ease, Family, Instruction, Jump, Spring, Tape};

const FAMILIES: [Family; 10] = [
    Family::Sine,
    Family::Quad,
    Family::Cubic,
    Family::Quart,
    Family::Quint,
    Family::Expo,
    Family::Circ,
    Family::Back,
    Family::Bounce,
    Family::Elastic,
];
const DIRECTIONS: [Direction; 3] = [Direction::In, Direction::Out, Direction::InOut];

fn check(curve: Ease, t: f64, expected: f64, tolerance: f64) {
    let found = ease(&curve, t);
    assert!((found - expected).abs() <= tolerance, "{curve:?} at {t:?}: {found}, expected {expected}");
}

/// Rows of numbers; lines of another first word than a number are headings, and the first `skip` columns names.
fn rows(table: &str, skip: usize) -> Vec<Vec<f64>> {
    let numbers = |line: &str| line.split(',').skip(skip).map(|cell| cell.parse().ok()).collect::<Option<Vec<f64>>>();
    table.lines().filter(|line| !line.starts_with('#')).filter_map(numbers).collect()
}

fn check_beziers(rows: &[Vec<f64>], tolerance: f64) {
    for row in rows {
        let &[x1, y1, x2, y2, x, y] = row.as_slice() else { panic!("{row:?}") };
        check(Ease::Bezier(Bezier { x1, y1, x2, y2 }), x, y, tolerance);
    }
}

#[test]
fn beziers_are_those_of_css() {
    let table = rows(include_str!("data/css_cubic_bezier.csv"), 1);
    assert_eq!(table.len(), 152);
    check_beziers(&table, 1e-9);
}

#[test]
fn steep_beziers_reach_1e_7() {
    let table = rows(include_str!("data/steep_bezier.csv"), 0);
    assert!(table.len() > 200);
    check_beziers(&table, 1e-7);
}

#[test]
fn the_steepest_bezier_is_a_cube_root() {
    for exponent in 1..=16 {
        for side in [-1.0, 1.0] {
            // x(½ + u) = ½ + 4u³ and y(½ + u) = ½ + 1.5u − 2u³.
            let x = 0.5 + side * 0.4 * 0.1_f64.powi(exponent);
            let u = ((x - 0.5) / 4.0).cbrt();
            let curve = Bezier { x1: 1.0, y1: 0.0, x2: 0.0, y2: 1.0 };
            check(Ease::Bezier(curve), x, 0.5 + 1.5 * u - 2.0 * u.powi(3), 1e-12);
        }
    }
}

#[test]
fn ends_are_exact() {
    let penner = FAMILIES.into_iter().flat_map(|family| DIRECTIONS.map(|direction| Ease::Penner(family, direction)));
    let beziers = [Bezier::SMOOTH, Bezier::EASE_IN, Bezier::EASE_OUT, Bezier::EASE_IN_OUT].map(Ease::Bezier);
    for curve in penner.chain(beziers).chain([Ease::Linear, Ease::Step]) {
        for (t, end) in [(0.0, 0.0), (-0.5, 0.0), (1.0, 1.0), (1.5, 1.0)] {
            check(curve.clone(), t, end, 0.0);
        }
    }
}

#[test]
fn step_holds_until_the_end() {
    check(Ease::Step, 0.999999, 0.0, 0.0);
    check(Ease::Linear, 0.3, 0.3, 0.0);
}

#[test]
fn penner_curves_are_those_of_easings_net() {
    use Direction::*;
    use Family::*;
    let (c1, c2, c3) = (1.70158, 1.70158 * 1.525, 2.70158);
    let (c4, c5) = (2.0 * PI / 3.0, 2.0 * PI / 4.5);
    let bounce = |x: f64| {
        let (n, d) = (7.5625, 2.75);
        if x < 1.0 / d {
            n * x * x
        } else if x < 2.0 / d {
            n * (x - 1.5 / d) * (x - 1.5 / d) + 0.75
        } else if x < 2.5 / d {
            n * (x - 2.25 / d) * (x - 2.25 / d) + 0.9375
        } else {
            n * (x - 2.625 / d) * (x - 2.625 / d) + 0.984375
        }
    };
    for i in 1..100 {
        let x = f64::from(i) / 100.0;
        let first = x < 0.5;
        let w = -2.0 * x + 2.0;
        let power = |n: i32| {
            let both = if first { 0.5 * (2.0 * x).powi(n) } else { 1.0 - w.powi(n) / 2.0 };
            [x.powi(n), 1.0 - (1.0 - x).powi(n), both]
        };
        let table = [
            (Sine, [1.0 - (x * PI / 2.0).cos(), (x * PI / 2.0).sin(), -((PI * x).cos() - 1.0) / 2.0]),
            (Quad, power(2)),
            (Cubic, power(3)),
            (Quart, power(4)),
            (Quint, power(5)),
            (
                Expo,
                [
                    2.0_f64.powf(10.0 * x - 10.0),
                    1.0 - 2.0_f64.powf(-10.0 * x),
                    if first {
                        2.0_f64.powf(20.0 * x - 10.0) / 2.0
                    } else {
                        (2.0 - 2.0_f64.powf(-20.0 * x + 10.0)) / 2.0
                    },
                ],
            ),
            (
                Circ,
                [
                    1.0 - (1.0 - x * x).sqrt(),
                    (1.0 - (x - 1.0).powi(2)).sqrt(),
                    if first {
                        (1.0 - (1.0 - (2.0 * x).powi(2)).sqrt()) / 2.0
                    } else {
                        ((1.0 - w * w).sqrt() + 1.0) / 2.0
                    },
                ],
            ),
            (
                Back,
                [
                    c3 * x.powi(3) - c1 * x * x,
                    1.0 + c3 * (x - 1.0).powi(3) + c1 * (x - 1.0).powi(2),
                    if first {
                        (2.0 * x).powi(2) * ((c2 + 1.0) * 2.0 * x - c2) / 2.0
                    } else {
                        ((2.0 * x - 2.0).powi(2) * ((c2 + 1.0) * (2.0 * x - 2.0) + c2) + 2.0) / 2.0
                    },
                ],
            ),
            (
                Bounce,
                [
                    1.0 - bounce(1.0 - x),
                    bounce(x),
                    if first { (1.0 - bounce(1.0 - 2.0 * x)) / 2.0 } else { (1.0 + bounce(2.0 * x - 1.0)) / 2.0 },
                ],
            ),
            (
                Elastic,
                [
                    -2.0_f64.powf(10.0 * x - 10.0) * ((x * 10.0 - 10.75) * c4).sin(),
                    2.0_f64.powf(-10.0 * x) * ((x * 10.0 - 0.75) * c4).sin() + 1.0,
                    if first {
                        -(2.0_f64.powf(20.0 * x - 10.0) * ((20.0 * x - 11.125) * c5).sin()) / 2.0
                    } else {
                        2.0_f64.powf(-20.0 * x + 10.0) * ((20.0 * x - 11.125) * c5).sin() / 2.0 + 1.0
                    },
                ],
            ),
        ];
        for (family, expected) in table {
            for (direction, expected) in [In, Out, InOut].into_iter().zip(expected) {
                check(Ease::Penner(family, direction), x, expected, 1e-12);
            }
        }
    }
}

#[test]
fn steps_jump_as_in_css() {
    let table = [
        (4, Jump::End, [0.0, 0.0, 0.25, 0.5, 0.75, 1.0]),
        (4, Jump::Start, [0.25, 0.25, 0.5, 0.75, 1.0, 1.0]),
        (4, Jump::Both, [0.2, 0.2, 0.4, 0.6, 0.8, 1.0]),
        (4, Jump::None, [0.0, 0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0, 1.0]),
        (1, Jump::End, [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]),
        (1, Jump::Start, [1.0; 6]),
        (1, Jump::Both, [0.5, 0.5, 0.5, 0.5, 0.5, 1.0]),
    ];
    for (count, jump, expected) in table {
        for (t, expected) in [0.0, 0.2, 0.25, 0.5, 0.99, 1.0].into_iter().zip(expected) {
            check(Ease::Steps(count, jump), t, expected, 1e-15);
        }
    }
}

#[test]
fn steps_are_on_time_on_every_frame() {
    for count in 1..200_u32 {
        for i in 0..=count {
            let t = f64::from(i) / f64::from(count);
            check(Ease::Steps(count, Jump::End), t, t, 1e-15);
        }
    }
}

/// x'' = ω² (1 − x) − 2 ζ ω x' by classical Runge–Kutta, from rest at 0.
fn integrated(spring: Spring, t: f64) -> f64 {
    let steps = 20_000;
    let h = t / f64::from(steps);
    let (w, z) = (spring.frequency, spring.damping);
    let pull = |x: f64, v: f64| w * w * (1.0 - x) - 2.0 * z * w * v;
    let (mut x, mut v) = (0.0, 0.0);
    for _ in 0..steps {
        let (k1, l1) = (v, pull(x, v));
        let (k2, l2) = (v + 0.5 * h * l1, pull(x + 0.5 * h * k1, v + 0.5 * h * l1));
        let (k3, l3) = (v + 0.5 * h * l2, pull(x + 0.5 * h * k2, v + 0.5 * h * l2));
        let (k4, l4) = (v + h * l3, pull(x + h * k3, v + h * l3));
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
    }
    x
}

#[test]
fn springs_obey_their_equation() {
    for frequency in [0.5, 3.0, 10.0, 40.0] {
        for damping in [0.0, 0.1, 0.5, 0.999, 1.0, 1.001, 2.0, 8.0] {
            let spring = Spring { frequency, damping };
            for t in [0.05, 0.3, 0.5, 0.9] {
                check(Ease::Spring(spring), t, integrated(spring, t), 1e-9);
            }
        }
    }
    // Undamped, half way round it is as far on the other side.
    check(Ease::Spring(Spring { frequency: 2.0 * PI, damping: 0.0 }), 0.5, 2.0, 1e-15);
    check(Ease::Spring(Spring { frequency: 0.0, damping: 1.0 }), 0.5, 0.0, 0.0);
}

#[test]
fn functions_are_asked() {
    // x² + 0.25
    let code = vec![
        Instruction::Input,
        Instruction::Binary(Binary::Mul, 0, 0),
        Instruction::Const(0.25),
        Instruction::Binary(Binary::Add, 1, 2),
    ];
    let curve = Ease::Function(Arc::new(Tape { code, outputs: vec![3], ..Tape::default() }));
    for (t, expected) in [(-1.0, 0.25), (0.0, 0.25), (0.5, 0.5), (1.0, 1.25), (2.0, 1.25)] {
        check(curve.clone(), t, expected, 0.0);
    }
    // A function knows no time, and of what is not there nothing.
    let blind = Tape { code: vec![Instruction::Time], outputs: vec![0], ..Tape::default() };
    assert!(ease(&Ease::Function(Arc::new(blind)), 0.5).is_nan());
    assert!(ease(&Ease::Function(Arc::default()), 0.5).is_nan());
}
