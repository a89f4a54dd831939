// Elementary functions as polynomials, so that every device gives the same bits: a builtin's result may differ per
// device and std's per platform. Polynomials: S. Moshier, Cephes Mathematical Library, single precision. The errors
// stated were measured against f64 and are held by renderer/kernel/tests/elementary.rs.

const PI: f32 = 3.14159265358979;
const INV_PI: f32 = 0.318309886183791;
const HALF_PI: f32 = 1.5707963267948966;
const TWO_PI: f32 = 6.28318530717959;
/// Farther than anything; finite, because WGSL may assume that infinities do not occur.
const FAR: f32 = 1e30;

fn square(x: f32) -> f32 {
    return x * x;
}

fn max_component(v: vec3<f32>) -> f32 {
    return max(v.x, max(v.y, v.z));
}

/// Rec. 709 luminance.
fn luminance(c: vec3<f32>) -> f32 {
    return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
}

// sin and cos of r in -π/4..π/4, then turned by `quadrant` quarter turns.
fn cos_sin_reduced(r: f32, quadrant: i32) -> vec2<f32> {
    let z = r * r;
    let s = r + r * z * ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1);
    let c = 1.0 - 0.5 * z + z * z * ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2);
    let swapped = select(vec2<f32>(c, s), vec2<f32>(s, c), (quadrant & 1) == 1);
    let cos_sign = select(1.0, -1.0, ((quadrant + 1) & 2) == 2);
    let sin_sign = select(1.0, -1.0, (quadrant & 2) == 2);
    return vec2<f32>(swapped.x * cos_sign, swapped.y * sin_sign);
}

// The nearest whole number, for |x| < 2³⁰. Half goes away from zero; `round` is a library call on some CPUs.
fn nearest(x: f32) -> i32 {
    return i32(x + select(0.5, -0.5, x < 0.0));
}

/// (cos 2πu, sin 2πu) for |u| <= 1000. Absolute error below 2e-7.
fn cos_sin_turn(u: f32) -> vec2<f32> {
    let k = nearest(4.0 * u);
    return cos_sin_reduced((u - 0.25 * f32(k)) * TWO_PI, k);
}

/// (cos x, sin x) for |x| <= 1000 radians. Absolute error below 2e-7.
fn cos_sin(x: f32) -> vec2<f32> {
    let quadrant = nearest(x * 0.6366197723675814);
    let k = f32(quadrant);
    // π/2 in three parts (Cody and Waite), so that the products with a small k are exact.
    let r = ((x - k * 1.5703125) - k * 4.837512969970703125e-4) - k * 7.549789948768648e-8;
    return cos_sin_reduced(r, quadrant);
}

/// eˣ. Relative error below 2e-7; 0 below -87, and at most e⁸⁸.
fn exp_(x: f32) -> f32 {
    if x < -87.0 {
        return 0.0;
    }
    let y = min(x, 88.0);
    let exponent = nearest(y * 1.44269504088896341);
    let n = f32(exponent);
    let r = (y - n * 0.693359375) + n * 2.12194440e-4;
    let p = (((((1.9875691500e-4 * r + 1.3981999507e-3) * r + 8.3334519073e-3) * r + 4.1665795894e-2) * r
        + 1.6666665459e-1) * r + 5.0000001201e-1) * r * r + r + 1.0;
    return p * bitcast<f32>(u32(exponent + 127) << 23u);
}

/// ln x for normal x above 0; -FAR for 0 and below. Error below 2e-7 · max(1, |ln x|).
fn log_(x: f32) -> f32 {
    if x < 1.1754944e-38 {
        return -FAR;
    }
    let bits = bitcast<u32>(x);
    var e = f32(i32(bits >> 23u) - 126);
    var m = bitcast<f32>((bits & 0x007fffffu) | 0x3f000000u);
    if m < 0.70710678 {
        m = m + m;
        e = e - 1.0;
    }
    let r = m - 1.0;
    let z = r * r;
    var p = 7.0376836292e-2;
    p = p * r - 1.1514610310e-1;
    p = p * r + 1.1676998740e-1;
    p = p * r - 1.2420140846e-1;
    p = p * r + 1.4249322787e-1;
    p = p * r - 1.6668057665e-1;
    p = p * r + 2.0000714765e-1;
    p = p * r - 2.4999993993e-1;
    p = p * r + 3.3333331174e-1;
    let tail = p * r * z - 2.12194440e-4 * e - 0.5 * z;
    return (r + tail) + 0.693359375 * e;
}

/// xʸ for x >= 0; 0⁰ is 1, 0 to any other power 0. Relative error below 4e-7 · (1 + |y ln x|).
fn pow_(x: f32, y: f32) -> f32 {
    if y == 0.0 {
        return 1.0;
    }
    if x <= 0.0 {
        return 0.0;
    }
    return exp_(y * log_(x));
}

/// Arc tangent. Absolute error below 2e-7.
fn atan_(x: f32) -> f32 {
    let a = abs(x);
    var base = 0.0;
    var r = a;
    if a > 2.414213562373095 {
        base = HALF_PI;
        r = -1.0 / a;
    } else if a > 0.4142135623730950 {
        base = 0.7853981633974483;
        r = (a - 1.0) / (a + 1.0);
    }
    let z = r * r;
    let p = (((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * r + r;
    return select(base + p, -(base + p), x < 0.0);
}

/// The angle of (x, y) from +x to +y in turns, -0.5 to 0.5.
fn turn_of(x: f32, y: f32) -> f32 {
    let wide = abs(y) > abs(x);
    let small = select(y, x, wide);
    let large = select(x, y, wide);
    if large == 0.0 {
        return 0.0;
    }
    let angle = atan_(small / large) / TWO_PI;
    if wide {
        return select(0.25, -0.25, y < 0.0) - angle;
    }
    if x < 0.0 {
        return angle + select(0.5, -0.5, y < 0.0);
    }
    return angle;
}

// asin for 0 <= x <= 0.5.
fn asin_small(x: f32) -> f32 {
    let z = x * x;
    return ((((4.2163199048e-2 * z + 2.4181311049e-2) * z + 4.5470025998e-2) * z + 7.4953002686e-2) * z
        + 1.6666752422e-1) * z * x + x;
}

/// Arc cosine; x is clamped to -1..1. Absolute error below 5e-7.
fn acos_(x: f32) -> f32 {
    let a = min(abs(x), 1.0);
    var y = 0.0;
    if a > 0.5 {
        y = 2.0 * asin_small(sqrt(0.5 * (1.0 - a)));
    } else {
        y = HALF_PI - asin_small(a);
    }
    return select(y, PI - y, x < 0.0);
}
