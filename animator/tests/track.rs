//! Tracks and tapes against closed forms.

use std::f64::consts::{E, FRAC_1_SQRT_2, FRAC_PI_2, FRAC_PI_4};

use glam::{DQuat, DVec3};
use kinora_animator::{Blend, value};
use kinora_scene::{
    Binary, Color, Direction, Ease, Family, Instruction, Jump, Key, Keys, Orient, Outside, Tape, Track, Unary, Way,
};

const FPS: f64 = 24.0;

fn keys<T>(keys: impl IntoIterator<Item = (f64, T, Ease)>) -> Keys<T> {
    let keys = keys.into_iter().map(|(time_s, value, ease)| Key { time_s, value, ease }).collect();
    Keys { keys, way: Way::Straight, outside: Outside::Hold }
}

fn curve<T>(code: Vec<Instruction>, outputs: &[u32]) -> Track<T> {
    Track::Curve(Box::new(Tape { code, outputs: outputs.to_vec(), ..Tape::default() }))
}

fn check<T: Blend + PartialEq + std::fmt::Debug>(track: &Track<T>, time_s: f64, expected: T) {
    assert_eq!(value(track, time_s, FPS), expected, "{track:?} at {time_s}");
}

fn check_near<T: Blend + std::fmt::Debug>(track: &Track<T>, time_s: f64, expected: T, tolerance: f64) {
    let found = value(track, time_s, FPS);
    let off = found.components().iter().zip(expected.components()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{track:?} at {time_s}: {found:?}, expected {expected:?}");
}

#[test]
fn constants_stand_still() {
    check(&Track::Const(2.5), 7.0, 2.5);
    check(&Track::Const(true), 7.0, true);
    check(&Track::Const(DVec3::X), 7.0, DVec3::X);
}

#[test]
fn keys_hold_outside_and_ease_to_the_key_they_reach() {
    let quad = Ease::Penner(Family::Quad, Direction::In);
    // The first key's ease governs nothing.
    let track = Track::Keys(keys([(1.0, 10.0, Ease::Step), (3.0, 20.0, quad), (4.0, 0.0, Ease::Linear)]));
    let table = [
        (f64::NEG_INFINITY, 10.0),
        (0.0, 10.0),
        (1.0, 10.0),
        (2.0, 12.5),
        (2.5, 10.0 + 10.0 * 0.5625),
        (3.0, 20.0),
        (3.5, 10.0),
        (4.0, 0.0),
        (9.0, 0.0),
        (f64::INFINITY, 0.0),
    ];
    for (time_s, expected) in table {
        check(&track, time_s, expected);
    }
}

#[test]
fn one_key_is_a_constant_and_none_is_no_number() {
    let one = Track::Keys(keys([(1.0, 5.0, Ease::Linear)]));
    for time_s in [0.0, 1.0, 2.0] {
        check(&one, time_s, 5.0);
    }
    assert!(value::<f64>(&Track::Keys(keys([])), 0.0, FPS).is_nan());
    assert!(value::<DQuat>(&Track::Keys(keys([])), 0.0, FPS).is_nan());
}

#[test]
fn keys_are_found_among_many() {
    let track = Track::Keys(keys((0..1000).map(|i| (f64::from(i), f64::from(i * i), Ease::Linear))));
    for i in 0..999 {
        check(&track, f64::from(i), f64::from(i * i));
        check(&track, f64::from(i) + 0.5, f64::from(i * i + i) + 0.5);
    }
}

#[test]
fn steps_and_switches_change_at_their_key() {
    let stepped = Track::Keys(keys([(0.0, 0.1, Ease::Linear), (1.0, 0.7, Ease::Step)]));
    let switched = Track::Keys(keys([(0.0, false, Ease::Linear), (1.0, true, Ease::Linear)]));
    for (time_s, after) in [(0.0, false), (0.999, false), (1.0, true), (2.0, true)] {
        check(&stepped, time_s, if after { 0.7 } else { 0.1 });
        check(&switched, time_s, after);
    }
    // A step that is the last lands on the key's very value.
    let early = Ease::Steps(2, Jump::Start);
    check(&Track::Keys(keys([(0.0, 0.1, Ease::Linear), (1.0, 0.7, early)])), 0.5, 0.7);
}

#[test]
fn vectors_and_colours_are_linear() {
    let (a, b) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(3.0, -2.0, 3.0));
    check(&Track::Keys(keys([(0.0, a, Ease::Linear), (2.0, b, Ease::Linear)])), 0.5, DVec3::new(1.5, 1.0, 3.0));
    let (dark, light) = (Color::new(0.0, 0.25, 1.0), Color::new(1.0, 0.75, 0.0));
    check(
        &Track::Keys(keys([(0.0, dark, Ease::Linear), (1.0, light, Ease::Linear)])),
        0.25,
        Color::new(0.25, 0.375, 0.75),
    );
}

#[test]
fn rotations_take_the_shorter_arc() {
    let mut count = 0;
    for line in include_str!("data/slerp.csv").lines() {
        let Some(row) = line.split(',').map(|cell| cell.parse().ok()).collect::<Option<Vec<f64>>>() else { continue };
        let quat = |at: usize| DQuat::from_xyzw(row[at + 1], row[at + 2], row[at + 3], row[at]);
        let (p, q, expected) = (quat(1), quat(5), quat(9));
        // q and −q are the same rotation.
        for (p, q) in [(p, q), (p, -q), (-p, q), (-p, -q)] {
            let found = value(&Track::Keys(keys([(0.0, p, Ease::Linear), (1.0, q, Ease::Linear)])), row[0], FPS);
            let off = (found - expected).length().min((found + expected).length());
            assert!(off < 1e-12, "{line}: {found}");
            assert!((found.length() - 1.0).abs() < 1e-15);
        }
        count += 1;
    }
    assert_eq!(count, 10);
}

#[test]
fn rotations_swing_past_their_key() {
    let back = Ease::Penner(Family::Back, Direction::Out);
    let track =
        Track::Keys(keys([(0.0, DQuat::IDENTITY, Ease::Linear), (1.0, DQuat::from_rotation_y(1.0), back.clone())]));
    let t = kinora_animator::ease(&back, 0.6);
    assert!(t > 1.0);
    check_near(&track, 0.6, DQuat::from_rotation_y(t), 1e-14);
}

/// Keys that go on in some way outside.
fn going_on<T>(outside: Outside, of: impl IntoIterator<Item = (f64, T, Ease)>) -> Track<T> {
    Track::Keys(Keys { outside, ..keys(of) })
}

#[test]
fn keys_repeat_and_turn_back() {
    let of = || [(1.0, 0.0, Ease::Linear), (2.0, 4.0, Ease::Linear), (4.0, 2.0, Ease::Linear)];
    let looped = [(1.0, 0.0), (1.5, 2.0), (4.0, 0.0), (4.5, 2.0), (5.0, 4.0), (0.0, 3.0), (-1.5, 2.0), (100.0, 0.0)];
    for (time_s, expected) in looped {
        check(&going_on(Outside::Loop, of()), time_s, expected);
    }
    let turned = [(1.0, 0.0), (4.0, 2.0), (5.0, 3.0), (6.5, 2.0), (7.0, 0.0), (7.5, 2.0), (0.5, 2.0), (-2.0, 2.0)];
    for (time_s, expected) in turned {
        check(&going_on(Outside::PingPong, of()), time_s, expected);
    }
    // A period that has no exact number begins with every turn all the same.
    let tenth = going_on(Outside::Loop, [(0.0, 1.0, Ease::Linear), (0.1, 2.0, Ease::Linear)]);
    for n in 0..1000 {
        let found = value(&tenth, f64::from(n) * 0.1, FPS);
        assert!((1.0..1.0001).contains(&found), "{n}: {found}");
    }
    // One key has no period.
    check(&going_on(Outside::Loop, [(1.0, 5.0, Ease::Linear)]), 7.0, 5.0);
    check(&going_on(Outside::PingPong, [(1.0, 5.0, Ease::Linear)]), 7.0, 5.0);
    check(&going_on(Outside::Extend, [(1.0, 5.0, Ease::Linear)]), 7.0, 5.0);
}

#[test]
fn keys_go_on_as_fast_as_they_come() {
    let of = |first: Ease, last: Ease| {
        going_on(Outside::Extend, [(1.0, 0.0, Ease::Linear), (2.0, 4.0, first), (4.0, 0.0, last)])
    };
    check(&of(Ease::Linear, Ease::Linear), 0.0, -4.0);
    check(&of(Ease::Linear, Ease::Linear), 6.0, -4.0);
    let quad = |direction| Ease::Penner(Family::Quad, direction);
    // t² is twice as fast at its end, and stands at its beginning.
    check_near(&of(quad(Direction::In), quad(Direction::In)), 6.0, -8.0, 1e-8);
    check_near(&of(quad(Direction::In), quad(Direction::In)), -1.0, 0.0, 1e-8);
    check_near(&of(quad(Direction::Out), quad(Direction::Out)), 0.0, -8.0, 1e-8);
    // 2^(10 t − 10) has a slope of 10 ln 2 at its end, and a jump at its beginning.
    let expo = of(Ease::Penner(Family::Expo, Direction::In), Ease::Penner(Family::Expo, Direction::In));
    check_near(&expo, 5.0, -2.0 * 10.0 * 2.0_f64.ln(), 1e-5);
    check_near(&expo, 0.0, -4.0 * 10.0 * 2.0_f64.ln() / 1024.0, 1e-5);
    check(&of(Ease::Linear, Ease::Step), 6.0, 0.0);
    check(&going_on(Outside::Extend, [(0.0, false, Ease::Linear), (1.0, true, Ease::Linear)]), 3.0, true);
    // Rotations keep turning.
    let y = DQuat::from_rotation_y;
    let spin = going_on(Outside::Extend, [(0.0, y(0.0), Ease::Linear), (1.0, y(1.0), Ease::Linear)]);
    for time_s in [-1.5, 2.0, 7.0] {
        let off = value(&spin, time_s, FPS).angle_between(y(time_s));
        assert!(off < 1e-7, "{time_s}: {off}");
    }
}

#[test]
fn keys_may_have_a_clock_of_their_own() {
    let of = keys([(1.0, 0.0, Ease::Linear), (2.0, 4.0, Ease::Linear)]);
    let clocked = |clock: Track<f64>| Track::Clocked { keys: Box::new(of.clone()), clock: std::sync::Arc::new(clock) };
    check(&clocked(Track::Const(1.5)), 9.0, 2.0);
    check(&clocked(Track::Keys(keys([(0.0, 1.0, Ease::Linear), (10.0, 2.0, Ease::Linear)]))), 2.5, 1.0);
    assert!(value(&clocked(Track::Const(f64::NAN)), 1.0, FPS).is_nan());
}

#[test]
fn there_may_be_no_value_outside() {
    let of = [(1.0, 0.0, Ease::Linear), (2.0, 4.0, Ease::Linear)];
    let track = going_on(Outside::Error, of);
    check(&track, 1.0, 0.0);
    check(&track, 2.0, 4.0);
    assert!(value(&track, 0.99, FPS).is_nan() && value(&track, 2.01, FPS).is_nan());
}

/// Keys 0, 1, … 2 seconds apart, with these tangents in and out.
fn cubic<T: Clone>(of: &[(T, T, T)]) -> Track<T> {
    let key = |(i, (_, value, _)): (usize, &(T, T, T))| (2.0 * i as f64, value.clone(), Ease::Linear);
    let tangents = of.iter().map(|(into, _, out)| [into.clone(), out.clone()]).collect();
    Track::Keys(Keys { way: Way::Cubic(tangents), ..keys(of.iter().enumerate().map(key)) })
}

#[test]
fn cubics_are_those_of_hermite() {
    // The table of the reference, whose segment is one second: tangents of two seconds are half of it.
    let track = cubic(&[(0.0, 0.0, 0.5), (-0.5, 2.0, 0.0)]);
    for (t, expected) in [(0.0, 0.0), (0.25, 0.5), (0.5, 1.25), (0.75, 1.875), (1.0, 2.0)] {
        check_near(&track, 2.0 * t, expected, 1e-15);
    }
    // t³ of each component, whose slope is 3 t².
    let at = |t: f64| DVec3::new(t, 2.0 * t, -t) * t * t;
    let slope = |t: f64| DVec3::new(1.0, 2.0, -1.0) * 3.0 * t * t;
    let track = cubic(&[
        (slope(0.0), at(0.0), slope(0.0)),
        (slope(2.0), at(2.0), slope(2.0)),
        (slope(4.0), at(4.0), slope(4.0)),
    ]);
    for time_s in [0.0, 0.3, 1.0, 2.0, 2.7, 4.0] {
        check_near(&track, time_s, at(time_s), 1e-12);
    }
    let Track::Keys(inside) = track else { unreachable!() };
    let extended = Track::Keys(Keys { outside: Outside::Extend, ..inside });
    check_near(&extended, 5.0, at(4.0) + slope(4.0), 1e-12);
}

#[test]
fn cubic_rotations_are_made_unit() {
    // glTF 2.0, appendix C.4: by components, then made unit.
    let (a, b) = (DQuat::from_rotation_y(0.0), DQuat::from_rotation_y(FRAC_PI_2));
    let still = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    let track = cubic(&[(still, a, still), (still, b, still)]);
    check_near(&track, 1.0, (a + b).normalize(), 1e-15);
    let half = ((a * 0.84375) + (b * 0.15625)).normalize();
    check_near(&track, 0.5, half, 1e-15);
    // What turns at 1 rad/s goes on so.
    let tangent = |q: DQuat| DQuat::from_xyzw(0.0, 0.5, 0.0, 0.0) * q;
    let Track::Keys(inside) = cubic(&[(tangent(a), a, tangent(a)), (tangent(b), b, tangent(b))]) else {
        unreachable!()
    };
    let extended = Track::Keys(Keys { outside: Outside::Extend, ..inside });
    check_near(&extended, 5.0, DQuat::from_rotation_y(FRAC_PI_2 + 3.0), 1e-12);
    check_near(&extended, -1.0, DQuat::from_rotation_y(-1.0), 1e-12);
}

#[test]
fn squads_turn_evenly_and_without_a_jerk() {
    // About one axis at even speed it is the turn itself, also past half a turn and whatever the signs.
    let y = DQuat::from_rotation_y;
    let even =
        keys((0..6).map(|i| (f64::from(i), y(f64::from(i)) * if i % 2 == 0 { 1.0 } else { -1.0 }, Ease::Linear)));
    let even = Track::Keys(Keys { way: Way::Squad, ..even });
    for i in 0..=50 {
        let time_s = f64::from(i) / 10.0;
        assert!(value(&even, time_s, FPS).angle_between(y(time_s)) < 1e-7, "{time_s}");
    }
    // Any turns: through the keys, and as fast after each as before it.
    let turns: Vec<DQuat> = (0..5)
        .map(|i| DQuat::from_euler(glam::EulerRot::XYZ, f64::from(i) * 0.7, f64::from(i * i) * 0.3, -0.5))
        .collect();
    let all = keys(turns.iter().enumerate().map(|(i, turn)| (i as f64, *turn, Ease::Linear)));
    let track = Track::Keys(Keys { way: Way::Squad, ..all });
    let h = 1e-5;
    for (i, turn) in turns.iter().enumerate() {
        let time_s = i as f64;
        check_near(&track, time_s, *turn, 1e-14);
        if (1..4).contains(&i) {
            let spin = |a: DQuat, b: DQuat| (b * a.conjugate()).to_scaled_axis() / h;
            let before = spin(value(&track, time_s - h, FPS), *turn);
            let after = spin(*turn, value(&track, time_s + h, FPS));
            assert!((before - after).length() < 1e-3, "{i}: {before} {after}");
        }
    }
}

/// The result of one operation on constants.
fn check_number(operands: &[f64], operation: Instruction, expected: f64) {
    let mut code: Vec<_> = operands.iter().map(|&number| Instruction::Const(number)).collect();
    code.push(operation);
    let found: f64 = value(&curve(code, &[operands.len() as u32]), 0.0, FPS);
    let same = found == expected || (found - expected).abs() < 1e-15 || (found.is_nan() && expected.is_nan());
    assert!(same, "{operation:?} of {operands:?}: {found}, expected {expected}");
}

#[test]
fn operations_on_one_number() {
    use Unary::*;
    let nan = f64::NAN;
    let table = [
        (Neg, 2.0, -2.0),
        (Not, 0.0, 1.0),
        (Not, 1.0, 0.0),
        (Abs, -2.0, 2.0),
        (Sign, -2.0, -1.0),
        (Sign, 0.0, 0.0),
        (Sign, 5.0, 1.0),
        (Sign, nan, nan),
        (Floor, -1.5, -2.0),
        (Ceil, -1.5, -1.0),
        (Round, 0.5, 1.0),
        (Round, -0.5, -1.0),
        (Round, 2.5, 3.0),
        (Round, 0.49999999999999994, 0.0),
        (Sqrt, 9.0, 3.0),
        (Sqrt, -1.0, nan),
        (Exp, 1.0, E),
        (Log, E, 1.0),
        (Log, 0.0, f64::NEG_INFINITY),
        (Sin, FRAC_PI_2, 1.0),
        (Cos, 0.0, 1.0),
        (Tan, FRAC_PI_4, 1.0),
        (Asin, 1.0, FRAC_PI_2),
        (Acos, 0.0, FRAC_PI_2),
        (Acos, 2.0, nan),
        (Atan, 1.0, FRAC_PI_4),
    ];
    for (operation, a, expected) in table {
        check_number(&[a], Instruction::Unary(operation, 0), expected);
    }
}

#[test]
fn operations_on_two_numbers() {
    use Binary::*;
    let (nan, infinite) = (f64::NAN, f64::INFINITY);
    let table = [
        (Add, 2.0, 3.0, 5.0),
        (Sub, 2.0, 3.0, -1.0),
        (Mul, 2.0, 3.0, 6.0),
        (Div, 3.0, 2.0, 1.5),
        (Div, 1.0, 0.0, infinite),
        (Div, 0.0, 0.0, nan),
        (Mod, 7.5, 2.0, 1.5),
        (Mod, -7.5, 2.0, 0.5),
        (Mod, 7.5, -2.0, -0.5),
        (Mod, -7.5, -2.0, -1.5),
        (Mod, 4.0, 2.0, 0.0),
        (Mod, 1.0, 0.0, nan),
        (Pow, 2.0, -2.0, 0.25),
        (Pow, -8.0, 0.5, nan),
        (Atan2, 1.0, -1.0, 3.0 * FRAC_PI_4),
        (Min, 2.0, 3.0, 2.0),
        (Min, nan, 3.0, nan),
        (Min, 3.0, nan, nan),
        (Max, 2.0, 3.0, 3.0),
        (Max, nan, 3.0, nan),
        (Max, 3.0, nan, nan),
        (Less, 1.0, 2.0, 1.0),
        (Less, 2.0, 2.0, 0.0),
        (LessEqual, 2.0, 2.0, 1.0),
        (LessEqual, 3.0, 2.0, 0.0),
        (Equal, 2.0, 2.0, 1.0),
        (Equal, nan, nan, 0.0),
        (And, 1.0, 0.0, 0.0),
        (And, 1.0, 1.0, 1.0),
        (Or, 0.0, 0.0, 0.0),
        (Or, 0.0, 1.0, 1.0),
    ];
    for (operation, a, b, expected) in table {
        check_number(&[a, b], Instruction::Binary(operation, 0, 1), expected);
    }
}

#[test]
fn selection_takes_the_second_unless_the_first_is_0() {
    for (condition, expected) in [(1.0, 10.0), (-0.5, 10.0), (0.0, 20.0), (-0.0, 20.0)] {
        check_number(&[condition, 10.0, 20.0], Instruction::Select(0, 1, 2), expected);
    }
}

#[test]
fn time_and_frame() {
    check(&curve(vec![Instruction::Time], &[0]), 1.25, 1.25);
    check(&curve(vec![Instruction::Frame], &[0]), 1.25, 30.0);
    check(&curve(vec![Instruction::Frame], &[0]), 0.01, 0.24);
    for fps in [24.0, 25.0, 29.97, 30000.0 / 1001.0, 60.0, 1000.0 / 3.0] {
        for n in 0..5000 {
            let n = f64::from(n);
            assert_eq!(value::<f64>(&curve(vec![Instruction::Frame], &[0]), n / fps, fps), n, "{fps}");
        }
    }
}

#[test]
fn keys_in_a_tape() {
    let tape = Tape {
        code: vec![
            Instruction::Keys(0),
            Instruction::Const(2.0),
            Instruction::Binary(Binary::Mul, 0, 1),
            Instruction::Keys(1),
        ],
        curves: vec![keys([(0.0, 0.0, Ease::Linear), (4.0, 8.0, Ease::Linear)])],
        outputs: vec![2],
        ..Tape::default()
    };
    check(&Track::Curve(Box::new(tape)), 1.0, 4.0);
}

#[test]
fn turns_in_a_tape() {
    let quarter = DQuat::from_rotation_y(FRAC_PI_2);
    let tape = Tape {
        code: (0..4).map(|part| Instruction::Turn(0, part)).collect(),
        turns: vec![keys([(0.0, DQuat::IDENTITY, Ease::Linear), (1.0, quarter, Ease::Linear)])],
        outputs: vec![0, 1, 2, 3],
        ..Tape::default()
    };
    check_near(&Track::Curve(Box::new(tape)), 0.5, DQuat::from_rotation_y(FRAC_PI_4), 1e-15);
}

/// A tape of a rotation by two directions, from six constants.
fn oriented(kind: Orient, direction: DVec3, up: DVec3) -> DQuat {
    let numbers = direction.to_array().into_iter().chain(up.to_array()).map(Instruction::Const);
    let parts = (0..4).map(|part| Instruction::Orient(kind, [0, 1, 2], [3, 4, 5], part));
    value(&curve(numbers.chain(parts).collect(), &[6, 7, 8, 9]), 0.0, FPS)
}

#[test]
fn orientations_face_their_direction() {
    for octant in 0..8 {
        let sign = |bit: i32| if octant & bit == 0 { 1.0 } else { -1.0 };
        let direction = DVec3::new(sign(1) * 1.0, sign(2) * 2.0, sign(4) * 3.0);
        for (kind, forward) in [(Orient::FaceTowards, DVec3::Z), (Orient::LookAlong, DVec3::NEG_Z)] {
            let turn = oriented(kind, direction, DVec3::Y);
            assert!((turn * forward - direction.normalize()).length() < 1e-14, "{kind:?} {direction}");
            assert!((turn * DVec3::X).y.abs() < 1e-14 && (turn * DVec3::Y).y > 0.0, "{kind:?} {direction}");
        }
    }
    assert_eq!(oriented(Orient::LookAlong, DVec3::NEG_Z, DVec3::Y), DQuat::IDENTITY);
    for (direction, up) in
        [(DVec3::ZERO, DVec3::Y), (DVec3::Y, DVec3::Y), (DVec3::NEG_Y, DVec3::Y), (DVec3::X, DVec3::ZERO)]
    {
        assert!(oriented(Orient::FaceTowards, direction, up).is_nan());
    }
}

#[test]
fn tapes_make_every_kind_of_value() {
    let numbers = vec![Instruction::Const(0.5), Instruction::Const(0.0), Instruction::Time];
    check(&curve(numbers.clone(), &[0, 1, 2]), 2.0, DVec3::new(0.5, 0.0, 2.0));
    check(&curve(numbers.clone(), &[2, 1, 0]), 2.0, Color::new(2.0, 0.0, 0.5));
    check(&curve(numbers.clone(), &[0]), 2.0, true);
    check(&curve(numbers.clone(), &[1]), 2.0, false);
    // Rotations are made unit.
    let half = DQuat::from_xyzw(FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);
    check_near(&curve(numbers.clone(), &[0, 1, 1, 0]), 2.0, half, 1e-15);
    assert!(value::<DQuat>(&curve(numbers, &[1, 1, 1, 1]), 2.0, FPS).is_nan());
}

#[test]
fn what_refers_to_nothing_is_no_number() {
    let instructions = [
        Instruction::Unary(Unary::Neg, 0),
        Instruction::Unary(Unary::Neg, u32::MAX),
        Instruction::Keys(0),
        Instruction::Turn(0, 0),
        Instruction::Orient(Orient::LookAlong, [9; 3], [9; 3], 7),
    ];
    for instruction in instructions {
        check_number(&[], instruction, f64::NAN);
    }
    assert!(value::<f64>(&curve(vec![], &[]), 0.0, FPS).is_nan());
    assert!(value::<DVec3>(&curve(vec![Instruction::Time], &[0]), 0.0, FPS).is_nan());
}
