//! `develop`: linear light to display values, by exposure and a tone curve (light-transport.md's sources: Sobotka's AgX,
//! Hill's fit of ACES, IEC 61966-2-1).

use glam::{DMat3, DVec3, Vec3};
use kinora_scene::{Look, Still, Tonemap};

/// Display values in 0..=1, one a pixel, row by row from the top; already encoded as the display expects them.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Red, green and blue.
    pub pixels: Vec<Vec3>,
}

impl Image {
    /// Three bytes a pixel, rounded to the nearest code.
    pub fn rgb8(&self) -> Vec<u8> {
        self.pixels.iter().flat_map(|p| p.to_array()).map(|v| (v * 255.0 + 0.5) as u8).collect()
    }

    /// Three 16-bit values a pixel, rounded to the nearest code.
    pub fn rgb16(&self) -> Vec<u16> {
        self.pixels.iter().flat_map(|p| p.to_array()).map(|v| (v * 65535.0 + 0.5) as u16).collect()
    }
}

/// Display values of linear radiance.
pub fn develop(radiance: &[Vec3], size: [u32; 2], look: &Look<Still>) -> Image {
    let scale = look.exposure.exp2();
    let pixels = radiance.iter().map(|c| display(c.as_dvec3() * scale, look.tonemap).as_vec3()).collect();
    Image { size, pixels }
}

/// A display value of one colour after exposure.
fn display(c: DVec3, tonemap: Tonemap) -> DVec3 {
    let c = if c.is_finite() { c.max(DVec3::ZERO) } else { DVec3::ONE };
    match tonemap {
        // AgX has an encoding of its own.
        Tonemap::Agx => agx(c),
        Tonemap::Aces => srgb(aces(c)),
        Tonemap::Reinhard => srgb(c / (DVec3::ONE + c)),
        Tonemap::None => srgb(c.min(DVec3::ONE)),
    }
    .clamp(DVec3::ZERO, DVec3::ONE)
}

/// The sRGB transfer curve of values in 0..=1.
fn srgb(c: DVec3) -> DVec3 {
    map(
        c.clamp(DVec3::ZERO, DVec3::ONE),
        |v| if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 },
    )
}

fn map(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

fn rows(rows: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&rows).transpose()
}

/// Hill's fit of the ACES reference and output transforms, without a scale of its own.
fn aces(c: DVec3) -> DVec3 {
    let input = rows([[0.59719, 0.35458, 0.04823], [0.076, 0.90834, 0.01566], [0.0284, 0.13383, 0.83777]]);
    let output = rows([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]]);
    let v = input * c;
    let fitted = (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (v * 0.983_729 + 0.432_951) + 0.238_081);
    output * fitted
}

/// Sobotka's AgX, base look, with the exact curve; the result is encoded for a display of gamma 2.2.
fn agx(c: DVec3) -> DVec3 {
    let inset = rows([
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]);
    let curve = |x: f64| {
        let d = x - 20.0 / 33.0;
        let (power, a) = if d >= 0.0 { (3.25, 69.862_789_135_455_39) } else { (3.0, 59.507_875) };
        0.5 + 2.0 * d * (1.0 + a * d.abs().powf(power)).powf(-1.0 / power)
    };
    let log = |v: f64| ((v.max(1e-30).log2() + 12.473_93) / 16.499_999).clamp(0.0, 1.0);
    inset.inverse() * map(inset * c, |v| curve(log(v)))
}

#[cfg(test)]
mod tests {
    use super::*;

    // (tone curve, linear grey, expected display value): an independent f64 script; ACES and Reinhard then through sRGB.
    #[test]
    fn known_greys() {
        for (t, v, expected, tolerance) in [
            (Tonemap::None, 0.18, 0.461_356, 1e-6),
            (Tonemap::None, 2.0, 1.0, 1e-12),
            (Tonemap::Agx, 0.001, 0.015_154_2, 1e-6),
            (Tonemap::Agx, 0.18, 0.5, 6e-5),
            (Tonemap::Agx, 1.0, 0.787_5, 1e-4),
            (Tonemap::Agx, 8.0, 0.976_3, 2e-4),
            (Tonemap::Reinhard, 1.0, srgb(DVec3::splat(0.5)).x, 1e-9),
            (Tonemap::Aces, 0.18, srgb(DVec3::splat(0.105_591)).x, 2e-6),
            (Tonemap::Aces, 2.0, srgb(DVec3::splat(0.803_562)).x, 2e-5),
        ] {
            let got = display(DVec3::splat(v), t);
            assert!((got - DVec3::splat(expected)).abs().max_element() <= tolerance, "{t:?}({v}) = {got}");
        }
    }

    #[test]
    fn what_is_no_number_is_white_and_negative_is_black() {
        assert!(display(DVec3::splat(f64::NAN), Tonemap::None).min_element() > 0.999_999);
        assert_eq!(display(DVec3::splat(-1.0), Tonemap::None), DVec3::ZERO);
    }

    #[test]
    fn every_srgb_code_survives() {
        for code in 0..=255u8 {
            let v = f64::from(code) / 255.0;
            let linear = if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
            let image = Image { size: [1, 1], pixels: vec![display(DVec3::splat(linear), Tonemap::None).as_vec3()] };
            assert_eq!(image.rgb8(), [code; 3]);
        }
    }
}
