//! Values of functions, units and colour spaces, read off the pixels of what shines with them. What is expected is computed
//! here, in f64, or known from elsewhere.

use glam::DVec3;
use kinora_renderer::Choice;
use kinora_scene::{cellular_noise, gradient_noise};
use kinora_tests::measure::Kernel;
use kinora_tests::world;

/// Rows of squares of one metre, each of which shines with one of the colours; one pixel is in the middle of each.
fn shown(declarations: &str, colours: &[String]) -> Vec<(&'static str, Vec<DVec3>)> {
    let count = colours.len();
    let mut text = format!(
        "lang 1
render {{ resolution: ({count}, 1), filter: box, filter_width: 0.000001, samples: 1, max_bounces: 0, tonemap: none }}
camera {{ position: ({}, 0, 5), look_at: ({}, 0, 0), projection: orthographic, height: 1 }}
{declarations}",
        0.5 * (count as f64 - 1.0),
        0.5 * (count as f64 - 1.0),
    );
    for (i, colour) in colours.iter().enumerate() {
        text += &format!(
            "quad {{ position: ({i}, 0, 0), normal: (0, 0, 1), size: (1, 1), material: emitter {{ {colour} }} }}\n"
        );
    }
    let world = world(&text);
    let mut found = vec![("cpu", Kernel::open(Choice::Cpu).picture(&world))];
    found.extend(Kernel::gpu().as_deref_mut().map(|gpu| ("gpu", gpu.picture(&world))));
    found
}

/// Expects numbers, each of which is at least 0: what is below is no light.
fn numbers(declarations: &str, cases: &[(&str, f64)]) {
    let colours: Vec<String> =
        cases.iter().map(|(text, _)| format!("color: linear(1, 1, 1) * (10 + ({text}))")).collect();
    for (backend, picture) in shown(declarations, &colours) {
        for ((text, expected), got) in cases.iter().zip(picture) {
            let off = (got - DVec3::splat(10.0 + expected)).abs().max_element();
            assert!(off <= 2e-6 * (10.0 + expected.abs()), "{backend}, {text}: {}, expected {expected}", got.x - 10.0);
        }
    }
}

#[test]
fn functions() {
    let fbm = |q: [f64; 3]| {
        let octave = |i: i32| 0.5_f64.powi(i) * gradient_noise(q.map(|x| x * 2.0_f64.powi(i)));
        (0..5).map(octave).sum::<f64>() / (0..5).map(|i| 0.5_f64.powi(i)).sum::<f64>()
    };
    numbers(
        "fn square(x: float) -> float = x * x
let list = [4, 1, 7]
let turned = rotate_z(90deg) * (1, 0, 0)\n",
        &[
            ("7 / 2", 3.5),
            ("2 + 3 * 4 ^ 2", 50.0),
            ("-2 ^ 2", -4.0),
            ("2 ^ 0.5", 2_f64.sqrt()),
            ("mod(-7, 3)", 2.0),
            ("mod(5.5, -2)", -0.5),
            ("abs(-3.25)", 3.25),
            ("sign(-3) + 2 * sign(4) + sign(0)", 1.0),
            ("floor(-2.5)", -3.0),
            ("ceil(-2.5)", -2.0),
            ("round(2.5) + round(-2.5) + round(1.4)", 1.0),
            ("fract(2.75)", 0.75),
            ("sqrt(2)", 2_f64.sqrt()),
            ("exp(1.5)", 1.5_f64.exp()),
            ("log(10)", 10_f64.ln()),
            ("sin(30deg) + sin(1)", 0.5 + 1_f64.sin()),
            ("cos(60deg) + cos(2)", 0.5 + 2_f64.cos()),
            ("tan(45deg)", 1.0),
            ("asin(0.5) / 1deg", 30.0),
            ("acos(0.5) / 1deg", 60.0),
            ("atan(1) / 1deg", 45.0),
            ("atan2(-1, -1) / 1turn", -0.375),
            ("turn(0.25) / 1deg", 90.0),
            ("mix(2, 6, 0.25)", 3.0),
            ("step(2, 1.9) + 3 * step(2, 2)", 3.0),
            ("smoothstep(0, 4, 1)", 0.156_25),
            ("clamp(9, 1, 5) + clamp(-9, 1, 5)", 6.0),
            ("saturate(1.5) + saturate(-1)", 1.0),
            ("f_number(8, focal_length: 50mm) / 1mm", 6.25),
            ("min(3, 1, 2) + max(3, 1, 2) + min(list)", 5.0),
            ("sum(list) + count(list) + list[2]", 22.0),
            ("length((3, 4, 12))", 13.0),
            ("normalize((3, 0, 4)).z", 0.8),
            ("dot((1, 2, 3), (4, 5, 6))", 32.0),
            ("cross((1, 0, 0), (0, 1, 0)).z", 1.0),
            ("distance((1, 1, 1), (1, 4, 5))", 5.0),
            ("turned.y - turned.x", 1.0),
            ("(rotate_y(90deg) * (0, 0, 1)).x", 1.0),
            ("(rotate_x(90deg) * (0, 1, 0)).z", 1.0),
            ("(axis_angle((0, 0, 2), 180deg) * (3, 0, 0)).x", -3.0),
            ("(euler(x: 90deg, y: 90deg, z: 0deg) * (0, 1, 0)).x", 1.0),
            ("(face_towards((5, 0, 0), up: (0, 1, 0)) * (0, 0, 1)).x", 1.0),
            ("(look_at((0, 0, 0), (5, 0, 0)) * (0, 0, -1)).x", 1.0),
            ("square(1.5)", 2.25),
            ("if 2 > 1 && !(1 == 2) || false { 5 } else { 6 }", 5.0),
            ("sum([for i in 0..5 if i != 3: i * i])", 21.0),
            ("noise((0.3, 1.7, 2.9)) * 8", 8.0 * gradient_noise([0.3, 1.7, 2.9])),
            ("fbm((0.3, 1.7, 2.9), octaves: 5) * 8", 8.0 * fbm([0.3, 1.7, 2.9])),
            ("cell((0.3, 1.7, 2.9))", cellular_noise([0.3, 1.7, 2.9], 3)[0]),
            ("cell_id((0.3, 1.7, 2.9))", cellular_noise([0.3, 1.7, 2.9], 3)[1]),
        ],
    );
}

#[test]
fn units() {
    numbers(
        "",
        &[
            ("250mm / 1m", 0.25),
            ("50cm / 1m", 0.5),
            ("0.002km / 1m", 2.0),
            ("10in / 1m", 0.254),
            ("10ft / 1m", 3.048),
            ("90deg / 1rad", std::f64::consts::FRAC_PI_2),
            ("0.5turn / 1deg", 180.0),
            ("250ms / 1s", 0.25),
            ("0.5min / 1s", 30.0),
            ("4Hz * 2s", 8.0),
            ("500g / 1kg", 0.5),
            ("6N / 2kg / 1m/s^2", 3.0),
            ("12J / 4s / 1W", 3.0),
            ("300K / 100K", 3.0),
            ("6lm / 3cd / 1sr", 2.0),
            ("6lx * 2m^2 / 4lm", 3.0),
            ("75%", 0.75),
            ("9.81m/s^2 * 2s / 1m/s", 19.62),
            ("1g/cm^3 / 1000kg/m^3", 1.0),
            ("0.002N*s / 1kg / 1mm/s", 2.0),
            ("3rad/s * 2s / 1rad", 6.0),
            ("5W/m^2/sr * 2m^2 * 1sr / 1W", 10.0),
        ],
    );
}

/// Quantities of light: each of them sends as much as closed forms say.
#[test]
fn light() {
    let pi = std::f64::consts::PI;
    let cases = [
        ("radiance: 3W/m^2/sr", 3.0),
        ("radiance: 300W/m^2/sr * 1%", 3.0),
        ("radiance: 0.0003W/cm^2/sr", 3.0),
        ("power: 2W", 2.0 / pi),
        ("power: 2J / 1s", 2.0 / pi),
        ("power: 2W, two_sided: true", 1.0 / pi),
        ("color: linear(0.5, 0.5, 0.5), power: 2W", 1.0 / pi),
    ];
    let colours: Vec<String> = cases.iter().map(|(text, _)| text.to_string()).collect();
    for (backend, picture) in shown("", &colours) {
        for ((text, expected), got) in cases.iter().zip(picture) {
            assert!((got - expected).abs().max_element() < 2e-6, "{backend}, {text}: {got}, expected {expected}");
        }
    }
}

/// IEC 61966-2-1.
fn decoded(x: f64) -> f64 {
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Smith (1978): hue in degrees.
fn from_hsv(h: f64, s: f64, v: f64) -> DVec3 {
    let channel = |n: f64| {
        let k = (n + h / 60.0).rem_euclid(6.0);
        decoded(v - v * s * k.min(4.0 - k).clamp(0.0, 1.0))
    };
    DVec3::new(channel(5.0), channel(3.0), channel(1.0))
}

/// Ottosson (2020), hue in degrees.
fn from_oklch(l: f64, c: f64, h: f64) -> DVec3 {
    let (sin, cos) = h.to_radians().sin_cos();
    let (a, b) = (c * cos, c * sin);
    let cone = |x: f64, y: f64| (l + x * a + y * b).powi(3);
    let (l, m, s) = (
        cone(0.396_337_777_4, 0.215_803_757_3),
        cone(-0.105_561_345_8, -0.063_854_172_8),
        cone(-0.089_484_177_5, -1.291_485_548_0),
    );
    DVec3::new(
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    )
    .max(DVec3::ZERO)
}

#[test]
fn colours() {
    let bytes = |r: u8, g: u8, b: u8| DVec3::from([r, g, b].map(|x| decoded(f64::from(x) / 255.0)));
    let cases = [
        ("#d9402b", bytes(0xd9, 0x40, 0x2b)),
        ("#f80", bytes(0xff, 0x88, 0x00)),
        ("srgb(0.73, 0.02, 0.5)", DVec3::new(decoded(0.73), decoded(0.02), decoded(0.5))),
        ("srgb(50%, 25%, 100%)", DVec3::new(decoded(0.5), decoded(0.25), 1.0)),
        ("linear(0.73, 2.5, 0)", DVec3::new(0.73, 2.5, 0.0)),
        ("hsv(30deg, 80%, 90%)", from_hsv(30.0, 0.8, 0.9)),
        ("hsv(-100deg, 0.4, 0.6)", from_hsv(-100.0, 0.4, 0.6)),
        ("hsv(2.5turn, 1, 1)", from_hsv(180.0, 1.0, 1.0)),
        ("oklch(0.7, 0.1, 150deg)", from_oklch(0.7, 0.1, 150.0)),
        ("oklch(0.5, 0.05, 300deg)", from_oklch(0.5, 0.05, 300.0)),
        ("mix(#000, #fff, 0.25)", DVec3::splat(0.25)),
        ("#fff * 0.5 + linear(0.25, 0, 0)", DVec3::new(0.75, 0.5, 0.5)),
        ("linear(srgb(0.5, 0, 0).r, 0, 1)", DVec3::new(decoded(0.5), 0.0, 1.0)),
    ];
    let colours: Vec<String> = cases.iter().map(|(text, _)| format!("color: {text}")).collect();
    for (backend, picture) in shown("", &colours) {
        for ((text, expected), got) in cases.iter().zip(picture) {
            assert!((got - expected).abs().max_element() < 3e-6, "{backend}, {text}: {got}, expected {expected}");
        }
    }
}

/// The chromaticity of Planck's law under the 2° observer, at luminance 1: that of 2856 K is illuminant A's.
#[test]
fn blackbody() {
    let cases = [("2856K", 0.447_57, 0.407_45), ("4000K", 0.380_45, 0.376_75), ("6500K", 0.313_52, 0.323_63)];
    let colours: Vec<String> = cases.iter().map(|(text, ..)| format!("color: blackbody({text})")).collect();
    for (backend, picture) in shown("", &colours) {
        for ((text, x, y), got) in cases.iter().zip(picture) {
            let big_x = 0.412_390_8 * got.x + 0.357_584_3 * got.y + 0.180_480_8 * got.z;
            let luminance = 0.212_639 * got.x + 0.715_168_7 * got.y + 0.072_192_3 * got.z;
            let big_z = 0.019_330_8 * got.x + 0.119_194_8 * got.y + 0.950_532_2 * got.z;
            let sum = big_x + luminance + big_z;
            let off = (big_x / sum - x).abs().max((luminance / sum - y).abs());
            assert!((luminance - 1.0).abs() < 1e-4, "{backend}, {text}: luminance {luminance}");
            assert!(off < 5e-4, "{backend}, {text}: {} {}, expected {x} {y}", big_x / sum, luminance / sum);
        }
    }
}
