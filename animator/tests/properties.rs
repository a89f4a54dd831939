//! Whatever the data, nothing panics, and what comes out of `sample` is sound.

mod common;

use std::sync::Arc;

use common::{node, scene, sphere};
use glam::{DQuat, DVec3};
use kinora_animator::{ease, sample, value};
use kinora_scene::*;
use proptest::{collection::vec, prelude::*, sample::select};

fn number() -> impl Strategy<Value = f64> + Clone {
    prop_oneof![3 => -3.0..3.0, 1 => any::<f64>(), 1 => select(vec![0.0, -0.0, 1.0, 0.5, f64::NAN, f64::INFINITY])]
}

fn any_ease() -> impl Strategy<Value = Ease> + Clone {
    use {Direction::*, Family::*};
    let families = vec![Sine, Quad, Cubic, Quart, Quint, Expo, Circ, Back, Bounce, Elastic];
    prop_oneof![
        Just(Ease::Linear),
        Just(Ease::Step),
        [number(), number(), number(), number()].prop_map(|[x1, y1, x2, y2]| Ease::Bezier(Bezier { x1, y1, x2, y2 })),
        (select(families), select(vec![In, Out, InOut]))
            .prop_map(|(family, direction)| Ease::Penner(family, direction)),
        (any::<u32>(), select(vec![Jump::Start, Jump::End, Jump::Both, Jump::None]))
            .prop_map(|(n, jump)| Ease::Steps(n, jump)),
        (number(), number()).prop_map(|(frequency, damping)| Ease::Spring(Spring { frequency, damping })),
        (vec(instruction(), 0..6), vec(0..6_u32, 0..2)).prop_map(|(code, outputs)| Ease::Function(Arc::new(Tape {
            code,
            outputs,
            ..Tape::default()
        }))),
    ]
}

/// Keys in any order, or none.
fn keys<T: std::fmt::Debug + Clone>(value: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = Keys<T>> + Clone {
    let key = (number(), value.clone(), any_ease()).prop_map(|(time_s, value, ease)| Key { time_s, value, ease });
    let way = prop_oneof![
        Just(Way::Straight),
        Just(Way::Squad),
        vec((value.clone(), value), 0..6).prop_map(|all| Way::Cubic(all.into_iter().map(|(a, b)| [a, b]).collect())),
    ];
    let outside = select(vec![Outside::Hold, Outside::Loop, Outside::PingPong, Outside::Extend, Outside::Error]);
    (vec(key, 0..6), way, outside).prop_map(|(keys, way, outside)| Keys { keys, way, outside })
}

fn quat() -> impl Strategy<Value = DQuat> + Clone {
    let calm = || -1.0..1.0;
    prop_oneof![5 => [calm(), calm(), calm(), calm()], 1 => [number(), number(), number(), number()]]
        .prop_map(DQuat::from_array)
}

fn instruction() -> impl Strategy<Value = Instruction> + Clone {
    use {Binary::*, Unary::*};
    let unary = vec![Neg, Not, Abs, Sign, Floor, Ceil, Round, Sqrt, Exp, Log, Sin, Cos, Tan, Asin, Acos, Atan];
    let binary = vec![Add, Sub, Mul, Div, Mod, Pow, Atan2, Min, Max, Less, LessEqual, Equal, And, Or];
    let register = || prop_oneof![20 => 0..16_u32, 1 => any::<u32>()];
    let three = move || [register(), register(), register()];
    prop_oneof![
        3 => number().prop_map(Instruction::Const),
        1 => Just(Instruction::Time),
        1 => Just(Instruction::Frame),
        1 => Just(Instruction::Input),
        1 => (0..3_u32).prop_map(Instruction::Keys),
        1 => (0..3_u32, 0..6_u8).prop_map(|(i, part)| Instruction::Turn(i, part)),
        3 => (select(unary), register()).prop_map(|(operation, a)| Instruction::Unary(operation, a)),
        3 => (select(binary), register(), register()).prop_map(|(operation, a, b)| Instruction::Binary(operation, a, b)),
        1 => three().prop_map(|[a, b, c]| Instruction::Select(a, b, c)),
        1 => (select(vec![Orient::FaceTowards, Orient::LookAlong]), three(), three(), 0..6_u8)
            .prop_map(|(kind, direction, up, part)| Instruction::Orient(kind, direction, up, part)),
    ]
}

fn tape() -> impl Strategy<Value = Tape> + Clone {
    (vec(instruction(), 0..16), vec(keys(number()), 0..3), vec(keys(quat()), 0..3), vec(0..16_u32, 0..6))
        .prop_map(|(code, curves, turns, outputs)| Tape { code, curves, turns, outputs })
}

fn track<T: std::fmt::Debug + Clone>(constant: impl Strategy<Value = T> + Clone) -> impl Strategy<Value = Track<T>> {
    prop_oneof![
        4 => constant.clone().prop_map(Track::Const),
        1 => keys(constant).prop_map(Track::Keys),
        1 => tape().prop_map(|tape| Track::Curve(Box::new(tape))),
    ]
}

fn vector() -> impl Strategy<Value = DVec3> + Clone {
    let calm = || -3.0..3.0;
    prop_oneof![5 => [calm(), calm(), calm()], 1 => [number(), number(), number()]].prop_map(DVec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn tapes_never_panic_and_repeat(tape in tape(), time_s in number(), fps in number()) {
        let curve = Box::new(tape);
        value::<bool>(&Track::Curve(curve.clone()), time_s, fps);
        value::<DVec3>(&Track::Curve(curve.clone()), time_s, fps);
        value::<Color>(&Track::Curve(curve.clone()), time_s, fps);
        let turn = value::<DQuat>(&Track::Curve(curve.clone()), time_s, fps);
        prop_assert!(turn.is_nan() || (turn.length() - 1.0).abs() < 1e-12);
        let once = value::<f64>(&Track::Curve(curve.clone()), time_s, fps);
        prop_assert_eq!(once.to_bits(), value::<f64>(&Track::Curve(curve), time_s, fps).to_bits());
    }

    #[test]
    fn easing_never_panics(curve in any_ease(), t in number()) {
        ease(&curve, t);
    }

    #[test]
    fn beziers_rise_with_their_y(x1 in 0.0..=1.0, x2 in 0.0..=1.0, y1 in 0.0..=1.0, y2 in 0.0..=1.0, s in 0.0..1.0, t in 0.0..1.0) {
        let curve = Ease::Bezier(Bezier { x1, y1, x2, y2 });
        let (early, late) = (f64::min(s, t), f64::max(s, t));
        prop_assert!(ease(&curve, early) <= ease(&curve, late) + 1e-12);
        // The curve turned by half a turn is the curve of the turned handles.
        let turned = Ease::Bezier(Bezier { x1: 1.0 - x2, y1: 1.0 - y2, x2: 1.0 - x1, y2: 1.0 - y1 });
        prop_assert!((ease(&curve, s) + ease(&turned, 1.0 - s) - 1.0).abs() < 1e-7);
    }

    #[test]
    fn worlds_are_sound(
        position in track(vector()),
        rotation in track(quat()),
        scale in track(vector()),
        eye in track(vector()),
        target in track(vector()),
        radius_m in track(number()),
        fov in track(number()),
        visible in track(any::<bool>()),
        time_s in number(),
    ) {
        let mut scene = scene();
        scene.nodes.push(node("child", Some(0), Some(sphere())));
        scene.nodes[0].placing = Placing { position, rotation, scale };
        scene.nodes[1].shape = Some(Shape::Sphere { radius_m });
        scene.nodes[1].visible = visible;
        scene.cameras[0].parent = Some(0);
        scene.cameras[0].position = eye;
        scene.cameras[0].projection = Projection::Perspective { fov };
        scene.cameras[0].aim = Aim::Point { target, up: DVec3::Y.into() };
        match sample(&scene, scene.clock.shutter_at(time_s)) {
            Err(error) => prop_assert!(!error.to_string().is_empty()),
            Ok(world) => {
                let axes = world.view.world_from_camera.matrix3;
                prop_assert!((axes.determinant() - 1.0).abs() < 1e-9);
                prop_assert!(world.view.world_from_camera.is_finite() && world.view.focus_m > 0.0);
                let Projection::Perspective { fov } = world.view.projection else { panic!("not a perspective") };
                prop_assert!(fov > 0.0 && fov < std::f64::consts::PI);
                for instance in world.instances {
                    prop_assert!(instance.world_from_object.inverse().is_finite());
                    let Shape::Sphere { radius_m } = instance.shape else { panic!("not a sphere") };
                    prop_assert!(radius_m > 0.0 && radius_m.is_finite());
                }
            }
        }
    }
}
