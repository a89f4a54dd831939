//! The elementary functions against f64, to the bounds that `shaders/math.wgsl` states.

mod common;

use std::f64::consts::{PI, TAU};

use common::Random;
use kinora_kernel::generated::FAR;
use kinora_kernel::{Kernel, Packed};

/// A dense grid over low..=high, and as many random numbers again.
fn arguments(low: f32, high: f32) -> impl Iterator<Item = f32> {
    const COUNT: u32 = 500_000;
    let mut random = Random(1);
    let grid = (0..=COUNT).map(move |i| low + (high - low) * (i as f32 / COUNT as f32));
    grid.chain((0..COUNT).map(move |_| random.within(low, high))).map(move |x| x.clamp(low, high))
}

/// Normal numbers above 0, all magnitudes alike.
fn normal_numbers() -> impl Iterator<Item = f32> {
    let mut random = Random(2);
    let ends = [f32::MIN_POSITIVE, f32::MAX, 1.0, 1.0_f32.next_up(), 1.0_f32.next_down()];
    (0..1_000_000)
        .map(move |_| f32::from_bits(0x0080_0000 + (random.bits() % 0x7f00_0000) as u32))
        .chain(ends)
        .chain(arguments(0.25, 4.0))
}

#[track_caller]
fn check(name: &str, bound: f64, errors: impl Iterator<Item = (f32, f64)>) {
    let mut worst = (0.0, 0.0);
    for (x, error) in errors {
        assert!(error.is_finite(), "{name}({x:e}) is not finite");
        if error > worst.1 {
            worst = (x, error);
        }
    }
    println!("{name}: {:.3e} at {:e}", worst.1, worst.0);
    assert!(worst.1 <= bound, "{name}({:e}) is off by {:e}, more than {bound:e}", worst.0, worst.1);
    assert!(worst.1 > 0.0, "{name}: no error at all is no measurement");
}

fn with(f: impl FnOnce(&Kernel<'_>)) {
    Packed::empty().with_kernel(f);
}

fn cos_sin_error(got: glam::Vec2, radians: f64) -> f64 {
    (f64::from(got.x) - radians.cos()).abs().max((f64::from(got.y) - radians.sin()).abs())
}

#[test]
fn cos_sin_turn() {
    with(|k| {
        let turn = |u: f32| TAU * (f64::from(u) - f64::from(u).round());
        check("near", 2e-7, arguments(-1.0, 1.0).map(|u| (u, cos_sin_error(k.cos_sin_turn(u), turn(u)))));
        check("far", 2e-7, arguments(-1000.0, 1000.0).map(|u| (u, cos_sin_error(k.cos_sin_turn(u), turn(u)))));
        for quarter in -4000..=4000 {
            let want = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][(quarter & 3) as usize];
            let got = k.cos_sin_turn(0.25 * quarter as f32);
            assert_eq!((got.x, got.y), want, "at {quarter} quarter turns");
        }
    });
}

#[test]
fn cos_sin() {
    with(|k| {
        let error = |x| (x, cos_sin_error(k.cos_sin(x), f64::from(x)));
        check("near", 2e-7, arguments(-7.0, 7.0).map(error));
        check("far", 2e-7, arguments(-1000.0, 1000.0).map(error));
        assert_eq!(k.cos_sin(0.0), glam::Vec2::new(1.0, 0.0));
        // Where the reduction cancels most: floats next to multiples of π/2.
        let multiples = (1..=636).flat_map(|i| {
            let x = (f64::from(i) * 0.5 * PI) as f32;
            [x.next_down(), x, x.next_up(), -x]
        });
        check("at multiples of π/2", 2e-7, multiples.map(error));
    });
}

#[test]
fn exp() {
    with(|k| {
        let error = |x: f32| {
            let want = f64::from(x).exp();
            (x, (f64::from(k.exp_(x)) - want).abs() / want)
        };
        check("exp_", 2e-7, arguments(-87.0, 88.0).map(error));
        check("exp_ near 0", 2e-7, arguments(-1.0, 1.0).map(error));
        assert_eq!(k.exp_(0.0), 1.0);
        for x in [-87.0_f32.next_up(), -88.0, -1e3, -FAR, f32::MIN] {
            assert_eq!(k.exp_(x), 0.0, "exp_({x})");
        }
        for x in [88.0, 88.8, 1e3, FAR, f32::MAX] {
            assert_eq!(k.exp_(x), k.exp_(88.0), "exp_({x})");
            assert!(k.exp_(x).is_finite());
        }
    });
}

#[test]
fn log() {
    with(|k| {
        let error = |x: f32| {
            let want = f64::from(x).ln();
            (x, (f64::from(k.log_(x)) - want).abs() / want.abs().max(1.0))
        };
        check("log_", 2e-7, normal_numbers().map(error));
        assert_eq!(k.log_(1.0), 0.0);
        for x in [0.0, -0.0, 1e-40, f32::MIN_POSITIVE.next_down(), -1.0, -FAR] {
            assert_eq!(k.log_(x), -FAR, "log_({x:e})");
        }
    });
}

#[test]
fn pow() {
    with(|k| {
        let mut random = Random(3);
        let errors = (0..2_000_000).filter_map(|_| {
            let x = f32::from_bits(0x2000_0000 + (random.bits() % 0x4000_0000) as u32);
            let y = random.within(-8.0, 8.0);
            let exponent = f64::from(y) * f64::from(x).ln();
            if exponent.abs() > 86.0 {
                return None;
            }
            let want = exponent.exp();
            Some((x, (f64::from(k.pow_(x, y)) - want).abs() / (want * (1.0 + exponent.abs()))))
        });
        check("pow_", 4e-7, errors);
        for (x, y, want) in [
            (0.0, 0.0, 1.0),
            (5.0, 0.0, 1.0),
            (0.0, 2.4, 0.0),
            (-1.0, 2.0, 0.0),
            (1.0, 1e30, 1.0),
            (1.0, -7.5, 1.0),
            (1e-30, 30.0, 0.0),
        ] {
            assert_eq!(k.pow_(x, y), want, "pow_({x}, {y})");
        }
        assert!(k.pow_(1e30, 30.0).is_finite());
    });
}

#[test]
fn atan() {
    with(|k| {
        let error = |x: f32| (x, (f64::from(k.atan_(x)) - f64::from(x).atan()).abs());
        check("atan_", 2e-7, arguments(-10.0, 10.0).map(error));
        check("atan_ of all magnitudes", 2e-7, normal_numbers().flat_map(|x| [x, -x]).map(error));
        assert_eq!(k.atan_(0.0), 0.0);
    });
}

#[test]
fn acos() {
    with(|k| {
        let error = |x: f32| (x, (f64::from(k.acos_(x)) - f64::from(x).acos()).abs());
        check("acos_", 5e-7, arguments(-1.0, 1.0).map(error));
        check("acos_ at its end", 5e-7, arguments(0.9999, 1.0).flat_map(|x| [x, -x]).map(error));
        assert_eq!(k.acos_(1.0), 0.0);
        assert_eq!(k.acos_(1.5), 0.0);
        assert_eq!(k.acos_(-1.0), PI as f32);
        assert_eq!(k.acos_(-2.0), PI as f32);
    });
}

#[test]
fn asin_small() {
    with(|k| {
        check(
            "asin_small",
            1e-7,
            arguments(0.0, 0.5).map(|x| (x, (f64::from(k.asin_small(x)) - f64::from(x).asin()).abs())),
        );
    });
}

#[test]
fn small_ones() {
    with(|k| {
        assert_eq!(k.square(-3.0), 9.0);
        for v in [[3.0, 1.0, 2.0], [1.0, 3.0, 2.0], [1.0, 2.0, 3.0]] {
            assert_eq!(k.max_component(v.into()), 3.0);
        }
        assert!((k.luminance(glam::Vec3::ONE) - 1.0).abs() < 1e-6);
        assert_eq!(k.luminance(glam::Vec3::Y), 0.7152);
    });
}
