//! Measured metals as one pair of optical constants a channel: what the exact Fresnel formula makes of them is what the
//! whole spectrum would reflect, seen in Rec. 709.
//!
//! Reflectance at an angle is weighed over 380..=780 nm by what each channel of linear Rec. 709 sees of CIE illuminant
//! D65 (CIE 1931 observer), so that a perfect mirror is (1, 1, 1). Then n and k of a channel are those that reflect as
//! much, both looked at straight on and in the cosine-weighted mean over all directions; at every angle they are within
//! 0.01 of it. A channel that is all mirror or more, such as the red of gold, whose colour lies outside Rec. 709, is
//! clipped to 0.999 first. The measurements and their sources are in `data/metals`; a test computes the table anew from
//! them.

use glam::Vec3;
use kinora_scene::Spectrum;

/// Refractive index and absorption index, n and k, of a metal, one of each a channel.
pub fn constants(metal: Spectrum) -> [Vec3; 2] {
    let [n, k] = match metal {
        Spectrum::Ag => [[0.05729, 0.05536, 0.04329], [4.50171, 3.56521, 2.59237]],
        Spectrum::Al => [[1.50037, 0.98961, 0.60708], [7.65667, 6.56103, 5.35602]],
        Spectrum::Au => [[0.00214, 0.48899, 1.48329], [2.75110, 2.24024, 1.77995]],
        Spectrum::Co => [[2.26031, 2.03948, 1.71571], [4.22565, 3.79951, 3.23989]],
        Spectrum::Cr => [[3.24042, 3.12093, 2.28677], [3.28535, 3.33721, 3.11732]],
        Spectrum::Cu => [[0.26768, 1.04306, 1.29989], [3.68057, 2.62995, 2.36492]],
        Spectrum::Fe => [[2.92122, 2.92137, 2.54662], [3.07491, 2.93846, 2.74999]],
        Spectrum::Ni => [[2.04719, 1.90751, 1.73282], [4.20478, 3.57659, 2.89852]],
        Spectrum::Pd => [[1.80258, 1.62527, 1.39828], [4.36657, 3.81772, 3.21518]],
        Spectrum::Pt => [[2.36801, 2.07229, 1.83050], [4.25564, 3.68432, 3.09403]],
        Spectrum::Ti => [[2.75899, 2.50940, 2.24322], [3.84410, 3.39976, 3.01581]],
        Spectrum::V => [[3.48932, 3.96025, 3.61576], [2.98326, 3.07530, 3.47506]],
        Spectrum::W => [[3.63541, 3.49615, 3.31666], [2.92179, 2.74857, 2.50548]],
    };
    [n.into(), k.into()]
}

/// Reflectance at normal incidence, by channel.
pub fn facing(metal: Spectrum) -> Vec3 {
    let [n, k] = constants(metal);
    let (less, more) = (n - Vec3::ONE, n + Vec3::ONE);
    (less * less + k * k) / (more * more + k * k)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wavelengths in nm at which spectra are looked at.
    fn wavelengths() -> impl Iterator<Item = f64> {
        (380..=780).map(f64::from)
    }

    /// Measured n and k by wavelength in nm.
    fn measured(metal: Spectrum) -> Vec<[f64; 3]> {
        let text = match metal {
            Spectrum::Ag => include_str!("../../data/metals/Ag.csv"),
            Spectrum::Al => include_str!("../../data/metals/Al.csv"),
            Spectrum::Au => include_str!("../../data/metals/Au.csv"),
            Spectrum::Co => include_str!("../../data/metals/Co.csv"),
            Spectrum::Cr => include_str!("../../data/metals/Cr.csv"),
            Spectrum::Cu => include_str!("../../data/metals/Cu.csv"),
            Spectrum::Fe => include_str!("../../data/metals/Fe.csv"),
            Spectrum::Ni => include_str!("../../data/metals/Ni.csv"),
            Spectrum::Pd => include_str!("../../data/metals/Pd.csv"),
            Spectrum::Pt => include_str!("../../data/metals/Pt.csv"),
            Spectrum::Ti => include_str!("../../data/metals/Ti.csv"),
            Spectrum::V => include_str!("../../data/metals/V.csv"),
            Spectrum::W => include_str!("../../data/metals/W.csv"),
        };
        let row = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
        text.lines().skip(1).map(row).collect()
    }

    fn interpolated<const N: usize>(rows: &[[f64; N]], x: f64) -> [f64; N] {
        let next = rows.iter().position(|row| row[0] > x).unwrap();
        let (a, b) = (rows[next - 1], rows[next]);
        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * (x - a[0]) / (b[0] - a[0]))
    }

    /// CIE standard illuminant D65, relative, 380..=780 nm by 10 nm (CIE 15).
    #[rustfmt::skip]
    const D65: [f64; 41] = [
        49.9755, 54.6482, 82.7549, 91.486, 93.4318, 86.6823, 104.865, 117.008, 117.812, 114.861, 115.923, 108.811,
        109.354, 107.802, 104.79, 107.689, 104.405, 104.046, 100.0, 96.3342, 95.788, 88.6856, 90.0062, 89.5991,
        87.6987, 83.2886, 83.6992, 80.0268, 80.2146, 82.2778, 78.2842, 69.7213, 71.6091, 74.349, 61.604, 69.8856,
        75.087, 63.5927, 46.4182, 66.8054, 63.3828,
    ];

    /// The CIE 1931 colour matching functions, by the fit of Wyman, Sloan and Shirley 2013, "Simple analytic
    /// approximations to the CIE XYZ color matching functions", multi-lobe.
    fn matching(nm: f64) -> [f64; 3] {
        let lobe = |height: f64, centre: f64, below: f64, above: f64| {
            let t = (nm - centre) / if nm < centre { below } else { above };
            height * (-0.5 * t * t).exp()
        };
        [
            lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
            lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
            lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
        ]
    }

    /// What each channel of linear Rec. 709 makes of light at a wavelength.
    fn raw_weights() -> Vec<[f64; 3]> {
        const RGB_FROM_XYZ: [[f64; 3]; 3] = [
            [3.2409699419045213, -1.5373831775700935, -0.4986107602930033],
            [-0.9692436362808798, 1.8759675015077206, 0.0415550574071756],
            [0.0556300796969936, -0.2039769588889765, 1.0569715142428786],
        ];
        let daylight: Vec<[f64; 2]> = D65.iter().enumerate().map(|(i, s)| [380.0 + 10.0 * i as f64, *s]).collect();
        let daylight = [daylight, vec![[790.0, 0.0]]].concat();
        let channels = |nm: f64| {
            let (light, xyz) = (interpolated(&daylight, nm)[1], matching(nm));
            RGB_FROM_XYZ.map(|row| light * (0..3).map(|i| row[i] * xyz[i]).sum::<f64>())
        };
        wavelengths().map(channels).collect()
    }

    /// The same of reflectance: sums to 1 a channel, whatever the fit of the matching functions leaves.
    fn weights() -> Vec<[f64; 3]> {
        let mut weights = raw_weights();
        for channel in 0..3 {
            let sum: f64 = weights.iter().map(|row| row[channel]).sum();
            weights.iter_mut().for_each(|row| row[channel] /= sum);
        }
        weights
    }

    /// The share of unpolarised light that a conductor reflects.
    fn fresnel(n: f64, k: f64, cos: f64) -> f64 {
        let (c2, s2) = (cos * cos, 1.0 - cos * cos);
        let t = n * n - k * k - s2;
        let q = (t * t + 4.0 * n * n * k * k).sqrt();
        let a = (0.5 * (q + t)).max(0.0).sqrt();
        let rs = (q + c2 - 2.0 * a * cos) / (q + c2 + 2.0 * a * cos);
        let rp = rs * (c2 * q + s2 * s2 - 2.0 * a * cos * s2) / (c2 * q + s2 * s2 + 2.0 * a * cos * s2);
        0.5 * (rs + rp)
    }

    /// The mean over all directions, by cosine.
    fn mean(reflectance: impl Fn(f64) -> f64) -> f64 {
        const STEPS: usize = 200;
        let squares = (0..STEPS).map(|i| (i as f64 + 0.5) / STEPS as f64);
        squares.map(|square| reflectance(square.sqrt())).sum::<f64>() / STEPS as f64
    }

    /// The integrated reflectance, a channel each.
    fn seen(rows: &[[f64; 3]], weights: &[[f64; 3]], cos: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (nm, weight) in wavelengths().zip(weights) {
            let [_, n, k] = interpolated(rows, nm);
            let share = fresnel(n, k, cos);
            (0..3).for_each(|channel| sum[channel] += weight[channel] * share);
        }
        sum
    }

    /// The most that n and k are to reflect straight on.
    const MIRROR: f64 = 0.999;

    /// The n and k whose reflectance is `straight` at normal incidence and `all` in the mean over all directions, or as
    /// near to that as n and k come.
    fn fitted(straight: f64, all: f64) -> [f64; 2] {
        let (straight, all) = (straight.min(MIRROR), all.min(MIRROR));
        let k = |n: f64| ((straight * (n + 1.0).powi(2) - (n - 1.0).powi(2)) / (1.0 - straight)).max(0.0).sqrt();
        // All n of this range reflect `straight` at normal incidence; the greater it is, the less in the mean.
        let root = straight.sqrt();
        let (mut low, mut high) = ((1.0 - root) / (1.0 + root), (1.0 + root) / (1.0 - root));
        for _ in 0..60 {
            let n = (low * high).sqrt();
            match mean(|cos| fresnel(n, k(n), cos)) > all {
                true => low = n,
                false => high = n,
            }
        }
        [low, k(low)]
    }

    /// What `constants` should say of a metal.
    fn computed(metal: Spectrum, weights: &[[f64; 3]]) -> [[f64; 2]; 3] {
        let rows = measured(metal);
        let straight = seen(&rows, weights, 1.0);
        [0, 1, 2].map(|channel| fitted(straight[channel], mean(|cos| seen(&rows, weights, cos)[channel])))
    }

    #[test]
    fn the_table_is_what_the_measurements_give() {
        let weights = weights();
        let mut wrong = String::new();
        for metal in Spectrum::ALL {
            let [n, k] = constants(*metal);
            let fitted = computed(*metal, &weights);
            let near = |channel: usize| {
                let [fitted_n, fitted_k] = fitted[channel];
                (f64::from(n[channel]) - fitted_n).abs() < 2e-5 && (f64::from(k[channel]) - fitted_k).abs() < 2e-5
            };
            if !(0..3).all(near) {
                let row = |i: usize| fitted.map(|pair| format!("{:.5}", pair[i])).join(", ");
                wrong += &format!("Spectrum::{} => [[{}], [{}]],\n", metal.symbol(), row(0), row(1));
            }
        }
        assert!(wrong.is_empty(), "these rows should be\n{wrong}");
    }

    #[test]
    fn two_numbers_a_channel_follow_the_spectrum() {
        let weights = weights();
        for metal in Spectrum::ALL {
            let (rows, [n, k]) = (measured(*metal), constants(*metal));
            for cos in (0..=50).map(|i| f64::from(i) / 50.0) {
                let seen = seen(&rows, &weights, cos);
                for channel in 0..3 {
                    let (n, k, seen) = (f64::from(n[channel]), f64::from(k[channel]), seen[channel].min(1.0));
                    let found = fresnel(n, k, cos);
                    assert!((found - seen).abs() < 0.01, "{metal:?} {channel} {cos}: {found}, expected {seen}");
                }
            }
        }
    }

    #[test]
    fn colours_are_those_of_the_literature() {
        // Akenine-Möller et al. 2018, Real-Time Rendering, table 9.2: partly from other measurements.
        for (metal, expected, tolerance) in [
            (Spectrum::Ag, [0.972, 0.960, 0.915], 0.07),
            (Spectrum::Al, [0.913, 0.922, 0.924], 0.01),
            (Spectrum::Au, [1.000, 0.782, 0.344], 0.06),
            (Spectrum::Cr, [0.549, 0.556, 0.554], 0.005),
            (Spectrum::Cu, [0.955, 0.638, 0.538], 0.03),
            (Spectrum::Ni, [0.660, 0.609, 0.526], 0.04),
            (Spectrum::Pd, [0.733, 0.697, 0.652], 0.005),
            (Spectrum::Pt, [0.673, 0.637, 0.585], 0.01),
        ] {
            let [n, k] = constants(metal);
            for channel in 0..3 {
                let found = fresnel(f64::from(n[channel]), f64::from(k[channel]), 1.0);
                assert!((found - expected[channel]).abs() < tolerance, "{metal:?} {channel}: {found}");
            }
        }
    }

    #[test]
    fn daylight_is_white() {
        let daylight: f64 = wavelengths().zip(raw_weights()).map(|(_, row)| row[1]).sum();
        for channel in 0..3 {
            let sum: f64 = raw_weights().iter().map(|row| row[channel]).sum();
            assert!((sum / daylight - 1.0).abs() < 0.01, "{channel}: {}", sum / daylight);
        }
    }
}
