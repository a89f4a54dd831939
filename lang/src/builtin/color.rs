//! Colours: every function gives linear Rec. 709.

use glam::DMat3;
use kinora_scene::{Binary, Unary};

use super::Call;
use super::math::try_arg;
use crate::diagnostic::Diagnostic;
use crate::dimension::Dimension;
use crate::eval::graph::{Graph, Scalar};
use crate::value::Value;

/// The sRGB transfer function, decoding; IEC 61966-2-1.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB transfer function, encoding.
pub fn linear_to_srgb(light: f64) -> f64 {
    if light <= 0.003_130_8 { light * 12.92 } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 }
}

fn decode(graph: &mut Graph, encoded: Scalar) -> Scalar {
    if let Scalar::Const(value) = encoded {
        return srgb_to_linear(value).into();
    }
    let low = graph.div(encoded, 12.92.into());
    let shifted = graph.add(encoded, 0.055.into());
    let base = graph.div(shifted, 1.055.into());
    let high = graph.binary(Binary::Pow, base, 2.4.into());
    let is_low = graph.binary(Binary::LessEqual, encoded, 0.04045.into());
    graph.select(is_low, low, high)
}

fn channels(call: &mut Call<'_>) -> Option<[Scalar; 3]> {
    Some([call.plain(0)?, call.plain(1)?, call.plain(2)?])
}

pub(super) fn srgb(call: &mut Call<'_>) -> Value {
    let channels = try_arg!(channels(call));
    Value::Color(channels.map(|channel| decode(call.graph, channel)))
}

pub(super) fn linear(call: &mut Call<'_>) -> Value {
    Value::Color(try_arg!(channels(call)))
}

/// v − v s max(0, min(k, 4 − k, 1)) with k = (n + hue / 60°) mod 6 for n = 5, 3, 1.
pub(super) fn hsv(call: &mut Call<'_>) -> Value {
    call.graph.work += 3;
    let hue = try_arg!(call.true_angle(0));
    let (s, v) = (try_arg!(call.plain(1)), try_arg!(call.plain(2)));
    let graph = &mut *call.graph;
    let sixths = graph.div(hue, (std::f64::consts::PI / 3.0).into());
    let vs = graph.mul(v, s);
    Value::Color([5.0, 3.0, 1.0].map(|n: f64| {
        let at = graph.add(sixths, n.into());
        let k = graph.binary(Binary::Mod, at, 6.0.into());
        let rest = graph.sub(4.0.into(), k);
        let low = graph.binary(Binary::Min, k, rest);
        let low = graph.binary(Binary::Min, low, 1.0.into());
        let share = graph.binary(Binary::Max, low, 0.0.into());
        let part = graph.mul(vs, share);
        let encoded = graph.sub(v, part);
        decode(graph, encoded)
    }))
}

/// Ottosson, "A perceptual color space for image processing" (2020).
pub(super) fn oklch(call: &mut Call<'_>) -> Value {
    call.graph.work += 3;
    let (l, c) = (try_arg!(call.plain(0)), try_arg!(call.plain(1)));
    let h = try_arg!(call.true_angle(2));
    Value::Color(from_oklch(call.graph, [l, c, h]))
}

/// From OKLab to the roots of cone responses.
const ROOTS_FROM_LAB: [[f64; 3]; 3] = [
    [1.0, 0.396_337_777_4, 0.215_803_757_3],
    [1.0, -0.105_561_345_8, -0.063_854_172_8],
    [1.0, -0.089_484_177_5, -1.291_485_548],
];

/// From cone responses to linear Rec. 709.
const RGB_FROM_CONES: [[f64; 3]; 3] = [
    [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
    [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
    [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701],
];

fn rows(graph: &mut Graph, matrix: [[f64; 3]; 3], of: [Scalar; 3]) -> [Scalar; 3] {
    matrix.map(|row| graph.dot(&row.map(Scalar::Const), &of))
}

fn inverse(matrix: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    DMat3::from_cols_array_2d(&matrix).inverse().to_cols_array_2d()
}

/// Linear Rec. 709 of lightness, chroma and hue; what lies below 0 is clipped.
pub fn from_oklch(graph: &mut Graph, [l, c, h]: [Scalar; 3]) -> [Scalar; 3] {
    let (cos, sin) = (graph.unary(Unary::Cos, h), graph.unary(Unary::Sin, h));
    let lab = [l, graph.mul(c, cos), graph.mul(c, sin)];
    let cones = rows(graph, ROOTS_FROM_LAB, lab).map(|root| {
        let square = graph.mul(root, root);
        graph.mul(square, root)
    });
    rows(graph, RGB_FROM_CONES, cones).map(|channel| graph.binary(Binary::Max, channel, 0.0.into()))
}

/// The inverse of [`from_oklch`], but for what is clipped.
pub fn to_oklch(graph: &mut Graph, rgb: [Scalar; 3]) -> [Scalar; 3] {
    let roots = rows(graph, inverse(RGB_FROM_CONES), rgb).map(|cone| {
        let (size, sign) = (graph.unary(Unary::Abs, cone), graph.unary(Unary::Sign, cone));
        let root = graph.binary(Binary::Pow, size, (1.0 / 3.0).into());
        graph.mul(root, sign)
    });
    let [l, a, b] = rows(graph, inverse(ROOTS_FROM_LAB), roots);
    let square = graph.dot(&[a, b], &[a, b]);
    [l, graph.unary(Unary::Sqrt, square), graph.binary(Binary::Atan2, b, a)]
}

pub(super) fn blackbody(call: &mut Call<'_>) -> Value {
    call.graph.work += 3;
    let kelvin = try_arg!(call.quantity(0, Dimension::TEMPERATURE));
    let span = call.place(0);
    let Some(kelvin) = kelvin.constant() else { return Value::Color(glowing(call.graph, kelvin)) };
    match planck(kelvin) {
        Some(rgb) => Value::Color(rgb.map(Scalar::Const)),
        None => {
            call.problems.push(
                Diagnostic::new("E0401", "temperature must be at least 500K")
                    .primary(call.file, span, "nothing glows visibly at this temperature")
                    .help("daylight is 6500K, a light bulb 2700K, a candle 1900K"),
            );
            Value::Error
        }
    }
}

/// As [`planck`] of a temperature that is not known yet.
fn glowing(graph: &mut Graph, kelvin: Scalar) -> [Scalar; 3] {
    let mut less_one = |nm: f64| {
        let x = graph.div((C2 / nm).into(), kelvin);
        let exp = graph.unary(Unary::Exp, x);
        graph.sub(exp, 1.0.into())
    };
    let green = less_one(560.0);
    let powers: Vec<Scalar> = (0..CIE_1931.len()).map(|i| less_one(wavelength(i))).collect();
    let powers: Vec<Scalar> = powers.into_iter().map(|power| graph.div(green, power)).collect();
    let xyz = [0, 1, 2].map(|part| {
        let weight = |(i, row): (usize, &[f64; 3])| Scalar::Const(row[part] * (560.0 / wavelength(i)).powi(5));
        let weights: Vec<Scalar> = CIE_1931.iter().enumerate().map(weight).collect();
        graph.dot(&weights, &powers)
    });
    let rgb = rows(graph, RGB_FROM_XYZ, xyz).map(|channel| graph.binary(Binary::Max, channel, 0.0.into()));
    let luminance = graph.dot(&LUMINANCE.map(Scalar::Const), &rgb);
    rgb.map(|channel| graph.div(channel, luminance))
}

/// Second radiation constant hc/k, in nm K (CODATA 2018).
const C2: f64 = 1.438_776_877e7;

/// XYZ to linear Rec. 709 with its white point D65.
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_969_941_904_521, -1.537_383_177_570_093, -0.498_610_760_293_003],
    [-0.969_243_636_280_88, 1.875_967_501_507_72, 0.041_555_057_407_176],
    [0.055_630_079_696_994, -0.203_976_958_888_977, 1.056_971_514_242_879],
];

/// Of linear Rec. 709.
const LUMINANCE: [f64; 3] = [0.212_639_005_871_51, 0.715_168_678_767_756, 0.072_192_315_360_734];

/// Of a row of [`CIE_1931`], in nm.
fn wavelength(row: usize) -> f64 {
    380.0 + 10.0 * row as f64
}

/// Planck's chromaticity at luminance 1, what lies outside Rec. 709 clipped. `None` below 500 K.
fn planck(kelvin: f64) -> Option<[f64; 3]> {
    if !(500.0..=1e9).contains(&kelvin) {
        return None;
    }
    let mut xyz = [0.0; 3];
    for (i, row) in CIE_1931.iter().enumerate() {
        let nm = wavelength(i);
        // Scaled by the value at 560 nm, so that no temperature overflows.
        let ratio = (C2 / (560.0 * kelvin)).exp_m1() / (C2 / (nm * kelvin)).exp_m1();
        let power = (560.0_f64 / nm).powi(5) * ratio;
        for (sum, weight) in xyz.iter_mut().zip(row) {
            *sum += power * weight;
        }
    }
    let xyz = xyz.map(|sum| sum / xyz[1]);
    let rgb = RGB_FROM_XYZ.map(|[x, y, z]| (x * xyz[0] + y * xyz[1] + z * xyz[2]).max(0.0));
    let luminance = LUMINANCE[0] * rgb[0] + LUMINANCE[1] * rgb[1] + LUMINANCE[2] * rgb[2];
    (luminance > 0.0 && luminance.is_finite()).then(|| rgb.map(|channel| channel / luminance))
}

/// Colour matching functions of the CIE 1931 2° observer, 380 to 780 nm by 10 nm (CIE 015).
const CIE_1931: [[f64; 3]; 41] = [
    [0.001368, 0.000039, 0.006450],
    [0.004243, 0.000120, 0.020050],
    [0.014310, 0.000396, 0.067850],
    [0.043510, 0.001210, 0.207400],
    [0.134380, 0.004000, 0.645600],
    [0.283900, 0.011600, 1.385600],
    [0.348280, 0.023000, 1.747060],
    [0.336200, 0.038000, 1.772110],
    [0.290800, 0.060000, 1.669200],
    [0.195360, 0.090980, 1.287640],
    [0.095640, 0.139020, 0.812950],
    [0.032010, 0.208020, 0.465180],
    [0.004900, 0.323000, 0.272000],
    [0.009300, 0.503000, 0.158200],
    [0.063270, 0.710000, 0.078250],
    [0.165500, 0.862000, 0.042160],
    [0.290400, 0.954000, 0.020300],
    [0.433450, 0.994950, 0.008750],
    [0.594500, 0.995000, 0.003900],
    [0.762100, 0.952000, 0.002100],
    [0.916300, 0.870000, 0.001650],
    [1.026300, 0.757000, 0.001100],
    [1.062200, 0.631000, 0.000800],
    [1.002600, 0.503000, 0.000340],
    [0.854450, 0.381000, 0.000190],
    [0.642400, 0.265000, 0.000050],
    [0.447900, 0.175000, 0.000020],
    [0.283500, 0.107000, 0.000000],
    [0.164900, 0.061000, 0.000000],
    [0.087400, 0.032000, 0.000000],
    [0.046770, 0.017000, 0.000000],
    [0.022700, 0.008210, 0.000000],
    [0.011359, 0.004102, 0.000000],
    [0.005790, 0.002091, 0.000000],
    [0.002899, 0.001047, 0.000000],
    [0.001440, 0.000520, 0.000000],
    [0.000690, 0.000249, 0.000000],
    [0.000332, 0.000120, 0.000000],
    [0.000166, 0.000060, 0.000000],
    [0.000083, 0.000030, 0.000000],
    [0.000042, 0.000015, 0.000000],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_of_closed_numbers() {
        // Encoded values and their linear light, computed independently.
        for (linear, encoded) in [
            (0.0, 0.0),
            (0.001, 0.012_920_000_000_000_001),
            (0.01, 0.099_852_822_734_128_32),
            (0.18, 0.461_356_129_500_441_64),
            (0.5, 0.735_356_983_052_449_5),
            (1.0, 1.0),
        ] {
            assert!((srgb_to_linear(encoded) - linear).abs() < 1e-12, "{encoded}");
        }
    }

    #[test]
    fn chromaticity_of_black_bodies() {
        // Chromaticities of the Planckian locus (CIE 015; 2856 K is illuminant A).
        for (kelvin, x, y) in [(2856.0, 0.4476, 0.4074), (6500.0, 0.3135, 0.3237), (10_000.0, 0.2807, 0.2884)] {
            let [r, g, b] = planck(kelvin).unwrap();
            let xyz = [
                0.412_390_8 * r + 0.357_584_3 * g + 0.180_480_8 * b,
                0.212_639_0 * r + 0.715_168_7 * g + 0.072_192_3 * b,
                0.019_330_8 * r + 0.119_194_8 * g + 0.950_532_2 * b,
            ];
            let sum: f64 = xyz.iter().sum();
            assert!((xyz[1] - 1.0).abs() < 1e-6, "{kelvin}: {xyz:?}");
            assert!((xyz[0] / sum - x).abs() < 2e-4, "{kelvin}: {}", xyz[0] / sum);
            assert!((xyz[1] / sum - y).abs() < 2e-4, "{kelvin}: {}", xyz[1] / sum);
        }
        assert_eq!(planck(100.0), None);
        assert!(planck(1e9).is_some());
        assert!(planck(500.0).is_some());
    }
}
