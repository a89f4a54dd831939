//! Timing curves: how far a segment between two keys has come. CSS Easing Functions Level 2, Robert Penner's families in
//! the form of easings.net, damped springs, and functions.

use std::f64::consts::{FRAC_PI_2, PI};

use kinora_scene::{Bezier, Direction, Ease, Family, Jump, Spring};

use crate::tape;

/// How far a segment has come, 0 at its first key and 1 at the key it arrives at, when the part `t` of its time has
/// passed; `t` outside 0..=1 counts as the nearer end.
///
/// The ends are exact, 0 and 1, for every curve but `steps`, which may jump at either, and functions, which are asked.
/// Between them a curve may leave 0..=1. Béziers are exact to 1e-7 for all handles with x in 0..=1; an x outside is moved
/// to the nearer end. A spring is where it is: what is left of its way at the end, it jumps.
pub fn ease(ease: &Ease, t: f64) -> f64 {
    match ease {
        Ease::Steps(count, jump) => return steps(*count, *jump, t.clamp(0.0, 1.0)),
        Ease::Function(function) => {
            return tape::function(function, t.clamp(0.0, 1.0));
        }
        _ if t <= 0.0 => return 0.0,
        _ if t >= 1.0 => return 1.0,
        _ => {}
    }
    match *ease {
        Ease::Linear => t,
        Ease::Step | Ease::Steps(..) | Ease::Function(_) => 0.0,
        Ease::Bezier(curve) => bezier(curve, t),
        Ease::Penner(family, direction) => penner(family, direction, t),
        Ease::Spring(of) => spring(of, t),
    }
}

/// How fast a segment is at its first key or, `at_end`, at its last, as a multiple of constant speed: the slope of its curve
/// there, from inside.
pub(crate) fn end_slope(curve: &Ease, at_end: bool) -> f64 {
    match curve {
        Ease::Linear => 1.0,
        Ease::Step | Ease::Steps(..) => 0.0,
        curve => {
            // Penner's expo has its jump at the end itself: of the parabola through three points beside it.
            const H: f64 = 1e-5;
            let inside = |far: f64| match at_end {
                true => -ease(curve, 1.0 - far),
                false => ease(curve, far),
            };
            (8.0 * inside(2.0 * H) - 5.0 * inside(H) - 3.0 * inside(3.0 * H)) / (2.0 * H)
        }
    }
}

/// x'' + 2 ζ ω x' + ω² x = ω² from rest at 0, by its three cases.
fn spring(Spring { frequency, damping }: Spring, t: f64) -> f64 {
    let decay = frequency * damping;
    let left = if damping < 1.0 {
        let swing = frequency * (1.0 - damping * damping).sqrt();
        // ζω / ω' · sin ω't, where ω' may be 0.
        let sine = if swing > 0.0 { (swing * t).sin() * decay / swing } else { 0.0 };
        (-decay * t).exp() * ((swing * t).cos() + sine)
    } else if damping == 1.0 {
        (-decay * t).exp() * (1.0 + decay * t)
    } else {
        // Of two large numbers far apart, the small root is not their difference.
        let fast = frequency * (damping + (damping * damping - 1.0).sqrt());
        let slow = frequency * frequency / fast;
        if fast > slow { (fast * (-slow * t).exp() - slow * (-fast * t).exp()) / (fast - slow) } else { 1.0 }
    };
    1.0 - left
}

/// CSS `steps(count, jump)`.
fn steps(count: u32, jump: Jump, t: f64) -> f64 {
    let count = f64::from(count.max(1));
    // A time written as n / count of the segment may come out a rounding error early.
    let done = (t * count + 1e-9).floor();
    let (early, jumps) = match jump {
        Jump::Start => (1.0, count),
        Jump::End => (0.0, count),
        Jump::Both => (1.0, count + 1.0),
        Jump::None => (0.0, (count - 1.0).max(1.0)),
    };
    ((done + early) / jumps).min(1.0)
}

/// CSS `cubic-bezier`: y where the curve has this x, 0 < x < 1.
fn bezier(curve: Bezier, x: f64) -> f64 {
    let (x1, x2) = (curve.x1.clamp(0.0, 1.0), curve.x2.clamp(0.0, 1.0));
    // x never falls along the curve, and bisection, unlike Newton's steps, does not mind where it stands still.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if x_beyond(x1, x2, middle, x) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    bernstein(curve.y1, curve.y2, 0.5 * (low + high))
}

/// The curve's x at parameter `s`, minus `x`.
///
/// The curve can stand still in three places: at its start, at its end, and in the middle, the last for handles near
/// x1 = 1, x2 = 0. There an error of 1e-16 in x is one of 5e-6 in s, so each has a form of its own, in which what is
/// small there has a small error too.
fn x_beyond(x1: f64, x2: f64, s: f64, x: f64) -> f64 {
    if s < 0.25 {
        bernstein(x1, x2, s) - x
    } else if s > 0.75 {
        (1.0 - x) - bernstein(1.0 - x2, 1.0 - x1, 1.0 - s)
    } else {
        let (sum, difference, u) = (1.0 - x1 + x2, 1.0 - x1 - x2, s - 0.5);
        let risen = u * (0.75 * sum + u * (1.5 * difference + u * (4.0 - 3.0 * sum)));
        risen - 0.375 * difference - (x - 0.5)
    }
}

/// The cubic Bézier polynomial with control values 0, `a`, `b`, 1.
fn bernstein(a: f64, b: f64, s: f64) -> f64 {
    let r = 1.0 - s;
    s * (3.0 * r * (r * a + s * b) + s * s)
}

/// Penner's curves, 0 < t < 1: `Out` is `In` turned by half a turn, `InOut` is `In` followed by `Out`.
fn penner(family: Family, direction: Direction, t: f64) -> f64 {
    match direction {
        Direction::In => rise(family, false, t),
        Direction::Out => 1.0 - rise(family, false, 1.0 - t),
        Direction::InOut if t < 0.5 => 0.5 * rise(family, true, 2.0 * t),
        Direction::InOut => 1.0 - 0.5 * rise(family, true, 2.0 - 2.0 * t),
    }
}

/// The `In` curve of a family, for 0 < t ≤ 1. Back and elastic swing differently as the half of an `InOut`.
fn rise(family: Family, half: bool, t: f64) -> f64 {
    match family {
        Family::Sine => 1.0 - (t * FRAC_PI_2).cos(),
        Family::Quad => t * t,
        Family::Cubic => t.powi(3),
        Family::Quart => t.powi(4),
        Family::Quint => t.powi(5),
        Family::Expo => (10.0 * t - 10.0).exp2(),
        Family::Circ => 1.0 - (1.0 - t * t).sqrt(),
        Family::Back => {
            let overshoot = if half { 1.70158 * 1.525 } else { 1.70158 };
            t * t * ((overshoot + 1.0) * t - overshoot)
        }
        Family::Bounce => 1.0 - bounce_out(1.0 - t),
        Family::Elastic => {
            let (period, phase) = if half { (4.5, 11.125) } else { (3.0, 10.75) };
            -(10.0 * t - 10.0).exp2() * ((10.0 * t - phase) * 2.0 * PI / period).sin()
        }
    }
}

/// Four parabolas, each bounce shorter and lower than the last.
fn bounce_out(t: f64) -> f64 {
    let (middle, floor) = match t * 2.75 {
        u if u < 1.0 => (0.0, 0.0),
        u if u < 2.0 => (1.5, 0.75),
        u if u < 2.5 => (2.25, 0.9375),
        _ => (2.625, 0.984375),
    };
    let u = t - middle / 2.75;
    7.5625 * u * u + floor
}
