//! `develop`: what a film holds as display values. Light goes through exposure and a tone curve (light-transport.md's
//! sources: Sobotka's AgX, Hill's fit of ACES, IEC 61966-2-1); what is no light is shown as plainly as can be:
//!
//! | view | picture |
//! |---|---|
//! | albedo | the colour, sRGB-encoded |
//! | normal | 0.5 + 0.5 n a channel, x y z as red green blue; black where nothing is |
//! | depth | 1 / (1 + (depth / focus)⁴): half grey at the camera's plane in focus, white near, black far and where nothing is |
//! | id | a colour of its own for every node, black where nothing is |
//! | samples | samples taken, from black over violet, red and yellow to white for `samples`, the most |
//! | cost | rays a sample, in the same colours, white for 2 · (max_bounces + 1) |
//! | bvh | the boxes of the tree, down to a level that can still be read, over a dim picture of the scene |

use glam::{DMat3, DVec3, Vec3};
use kinora_scene::{Look, Shown, Still, Tonemap};
use rayon::prelude::*;

use crate::film::{Film, Seen};
use crate::wires::Canvas;

/// Display values in 0..=1, one a pixel, row by row from the top; already encoded as the display expects them.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Red, green and blue; not multiplied by alpha.
    pub pixels: Vec<Vec3>,
    /// How much of a pixel is covered, 0..=1; empty if all of all is.
    pub alpha: Vec<f32>,
}

impl Image {
    /// Three bytes a pixel, rounded to the nearest code, or four with alpha.
    pub fn codes8(&self) -> Vec<u8> {
        self.codes(|v| (v * 255.0 + 0.5) as u8)
    }

    /// Three 16-bit values a pixel, rounded to the nearest code, or four with alpha.
    pub fn codes16(&self) -> Vec<u16> {
        self.codes(|v| (v * 65535.0 + 0.5) as u16)
    }

    fn codes<T>(&self, code: impl Fn(f32) -> T) -> Vec<T> {
        let channels = if self.alpha.is_empty() { 3 } else { 4 };
        let mut codes = Vec::with_capacity(self.pixels.len() * channels);
        for (i, pixel) in self.pixels.iter().enumerate() {
            codes.extend(pixel.to_array().into_iter().chain(self.alpha.get(i).copied()).map(&code));
        }
        codes
    }

    /// Four bytes a pixel for a screen, before black.
    pub fn screen(&self) -> Vec<u8> {
        let alpha = |i: usize| self.alpha.get(i).copied().unwrap_or(1.0);
        let pixels = self.pixels.iter().enumerate().map(|(i, pixel)| *pixel * alpha(i));
        pixels.flat_map(|p| (p * 255.0 + 0.5).extend(255.0).to_array().map(|v| v as u8)).collect()
    }
}

/// The picture that a film holds, for a display.
pub fn develop(film: &Film, look: &Look<Still>) -> Image {
    let count = film.window().pixels();
    let alpha: Vec<f32> = match film.is_transparent() {
        true => (0..count).into_par_iter().map(|i| film.seen(i).map_or(0.0, |seen| seen.cover)).collect(),
        false => Vec::new(),
    };
    // A mean over all samples as a mean over those that met something.
    let straight = |i: usize, value: Vec3| match alpha.get(i) {
        Some(&alpha) if alpha > 0.0 => value / alpha,
        _ => value,
    };
    let each = |pixel: &(dyn Fn(usize) -> Vec3 + Sync)| (0..count).into_par_iter().map(pixel).collect::<Vec<Vec3>>();
    let seen = |i: usize| film.seen(i).unwrap_or(NOTHING);
    let encoded = |color: Vec3| srgb(color.as_dvec3()).as_vec3();
    let pixels = match film.view() {
        Shown::Beauty => {
            let scale = look.exposure.exp2();
            each(&|i| display(straight(i, film.light(i)).as_dvec3() * scale, look.tonemap).as_vec3())
        }
        Shown::Albedo => each(&|i| encoded(straight(i, seen(i).albedo))),
        Shown::Normal => each(&|i| straight(i, 0.5 * (seen(i).normal + seen(i).cover)).clamp(Vec3::ZERO, Vec3::ONE)),
        // Of its own pixel alone, so that a crop shows what the whole does, and films do not flicker.
        Shown::Depth => each(&|i| Vec3::splat(1.0 / (1.0 + (seen(i).depth.max(0.0) / film.middle_m).powi(4)))),
        Shown::Id => each(&|i| color_of(seen(i).id)),
        Shown::Samples => each(&|i| heat(film.samples_of(i) as f32 / film.most_samples().max(1) as f32)),
        Shown::Cost => each(&|i| heat(film.cost(i) / film.most_rays())),
        Shown::Bvh => {
            let pixels = wired(film);
            each(&|i| encoded(straight(i, pixels[i])))
        }
    };
    Image { size: film.size(), pixels, alpha }
}

/// What a film holds as numbers, three a pixel: light, albedo and the picture of the boxes as linear light, normals as x,
/// y and z, depth, id, samples and rays a sample three times the same. What is a mean is one over all samples, so that it is
/// already multiplied by alpha.
pub fn measure(film: &Film) -> Vec<Vec3> {
    let seen = |i: usize| film.seen(i).unwrap_or(NOTHING);
    let each = |pixel: &dyn Fn(usize) -> Vec3| (0..film.window().pixels()).map(pixel).collect();
    match film.view() {
        Shown::Beauty => film.mean(),
        Shown::Albedo => each(&|i| seen(i).albedo),
        Shown::Normal => each(&|i| seen(i).normal),
        Shown::Depth => each(&|i| Vec3::splat(seen(i).depth)),
        Shown::Id => each(&|i| Vec3::splat(seen(i).id as f32)),
        Shown::Samples => each(&|i| Vec3::splat(film.samples_of(i) as f32)),
        Shown::Cost => each(&|i| Vec3::splat(film.cost(i))),
        Shown::Bvh => wired(film),
    }
}

const NOTHING: Seen =
    Seen { albedo: Vec3::ZERO, normal: Vec3::ZERO, cover: 0.0, depth: 1e10, position: Vec3::ZERO, id: 0 };

// The boxes over surfaces lit from the eye, in linear light.
fn wired(film: &Film) -> Vec<Vec3> {
    let seen = |i: usize| film.seen(i).unwrap_or(NOTHING);
    let to_eye = |p: Vec3| film.wires.as_deref().map_or(Vec3::ZERO, |wires| wires.to_eye(p));
    let lit = |i: usize| {
        let seen = seen(i);
        let facing = seen.normal.dot(to_eye(seen.position)).abs();
        seen.albedo.lerp(Vec3::splat(0.5), 0.3) * (0.03 + 0.5 * facing * facing)
    };
    let mut pixels: Vec<Vec3> = (0..film.window().pixels()).into_par_iter().map(lit).collect();
    if let Some(wires) = &film.wires {
        let depth = |i: usize| seen(i).depth;
        wires.draw(&mut Canvas { window: film.window(), pixels: &mut pixels, depth: &depth });
    }
    pixels
}

// A colour that differs from those of the numbers next to it; black for 0.
fn color_of(id: u32) -> Vec3 {
    if id == 0 {
        return Vec3::ZERO;
    }
    // Steps by the golden section spread hues evenly, however many there are.
    let step = |factor: f64| (f64::from(id) * factor).fract() as f32;
    let (hue, value) = (step(0.618_033_988_75) * 6.0, 0.55 + 0.4 * step(0.754_877_666_25));
    let channel = |offset: f32| {
        let distance = (hue + offset).rem_euclid(6.0);
        1.0 - 0.75 * (2.0 - (distance - 3.0).abs()).clamp(0.0, 1.0)
    };
    value * Vec3::new(channel(3.0), channel(1.0), channel(5.0))
}

// From black over violet, red and yellow to white.
fn heat(share: f32) -> Vec3 {
    const STOPS: [Vec3; 6] = [
        Vec3::new(0.0, 0.0, 0.02),
        Vec3::new(0.27, 0.05, 0.45),
        Vec3::new(0.7, 0.12, 0.35),
        Vec3::new(0.95, 0.4, 0.1),
        Vec3::new(0.98, 0.8, 0.2),
        Vec3::new(1.0, 1.0, 1.0),
    ];
    let at = share.clamp(0.0, 1.0) * 5.0;
    let i = (at as usize).min(4);
    STOPS[i].lerp(STOPS[i + 1], at - i as f32)
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
    use glam::Vec4;
    use kinora_scene::{Background, Render};

    use super::*;
    use crate::film::Request;

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
            let pixels = vec![display(DVec3::splat(linear), Tonemap::None).as_vec3()];
            let image = Image { size: [1, 1], pixels, alpha: vec![] };
            assert_eq!(image.codes8(), [code; 3]);
        }
    }

    #[test]
    fn exposure_is_in_stops() {
        for stops in [-2.0_f64, 0.0, 1.5] {
            let render = Render { resolution: [1, 1], ..Render::default() };
            let mut film = Film::new(&render, &Request::default()).unwrap();
            film.add(&[Vec4::new(0.1, 0.2, 0.3, 1.0)], &[], &[], 1);
            let image = develop(&film, &Look { exposure: stops, tonemap: Tonemap::None });
            let expected = srgb(DVec3::new(0.1, 0.2, 0.3) * 2.0_f64.powf(stops));
            assert!((image.pixels[0].as_dvec3() - expected).abs().max_element() < 1e-6, "{stops} stops");
        }
    }

    #[test]
    fn codes() {
        let mut image = Image { size: [2, 1], pixels: vec![Vec3::new(0.0, 0.5, 1.0), Vec3::ONE], alpha: vec![] };
        assert_eq!(image.codes8(), [0, 128, 255, 255, 255, 255]);
        image.alpha = vec![1.0, 0.0];
        assert_eq!(image.codes16(), [0, 32768, 65535, 65535, 65535, 65535, 65535, 0]);
        assert_eq!(image.screen(), [0, 128, 255, 255, 0, 0, 0, 255]);
    }

    // A film of four pixels: a surface near, one far, half a pixel of one, nothing.
    fn surfaces(view: Shown) -> Film {
        let background = Background::Transparent;
        let render = Render { resolution: [4, 1], view, background, max_bounces: 1, ..Render::default() };
        let mut film = Film::new(&render, &Request::default()).unwrap();
        let survey = |cover: f32, depth: f32, id: f32| {
            let albedo = Vec4::new(0.2, 0.4, 0.8, 1.0) * cover;
            [albedo, Vec4::new(0.0, cover, 0.0, depth), Vec4::new(1.0, 2.0, 3.0, id), Vec4::ZERO]
        };
        let light = [Vec4::new(0.5, 0.5, 0.5, 8.0); 4];
        let surveys = [survey(2.0, 1.0, 1.0), survey(2.0, 5.0, 2.0), survey(1.0, 2.0, 2.0), survey(0.0, 1e10, 0.0)];
        film.add(if film.wants_light() { &light } else { &[] }, &[], &surveys, 2);
        film
    }

    #[test]
    fn views() {
        let albedo = srgb(DVec3::new(0.2, 0.4, 0.8)).as_vec3();
        let normal = Vec3::new(0.5, 1.0, 0.5);
        let [near, far, edge] = [1.0_f32, 5.0, 2.0].map(|depth| Vec3::splat(1.0 / (1.0 + depth.powi(4))));
        let four_rays = heat(1.0);
        let zero = Vec3::ZERO;
        for (view, expected) in [
            (Shown::Albedo, [albedo, albedo, albedo, zero]),
            (Shown::Normal, [normal, normal, normal, zero]),
            (Shown::Depth, [near, far, edge, zero]),
            (Shown::Id, [color_of(1), color_of(2), color_of(2), zero]),
            (Shown::Cost, [four_rays; 4]),
        ] {
            let image = develop(&surfaces(view), &Look { exposure: 3.0, tonemap: Tonemap::Agx });
            for (got, expected) in image.pixels.iter().zip(expected) {
                assert!((*got - expected).abs().max_element() < 1e-6, "{view:?}: {got}, expected {expected}");
            }
            assert_eq!(image.alpha, [1.0, 1.0, 0.5, 0.0]);
        }
        for (view, expected) in [
            (Shown::Albedo, Vec3::new(0.1, 0.2, 0.4)),
            (Shown::Normal, Vec3::new(0.0, 0.5, 0.0)),
            (Shown::Depth, Vec3::splat(2.0)),
            (Shown::Id, Vec3::splat(2.0)),
            (Shown::Cost, Vec3::splat(4.0)),
        ] {
            assert_eq!(measure(&surfaces(view))[2], expected, "{view:?}");
        }
    }

    #[test]
    fn colours_of_nodes_differ() {
        let colors: Vec<Vec3> = (0..64).map(color_of).collect();
        for (i, a) in colors.iter().enumerate() {
            assert!(a.min_element() >= 0.0 && a.max_element() <= 1.0);
            for b in &colors[..i] {
                assert!((*a - *b).abs().max_element() > 0.02, "{i}: {a} and {b}");
            }
        }
    }

    // x or r g b, curve, what it gives: tests/data/README.md.
    #[test]
    fn the_curves_of_the_reference() {
        let mut count = 0;
        for line in include_str!("../tests/data/tonemap.csv").lines().skip(1) {
            let (curve, numbers) = line.split_once(',').unwrap();
            let numbers: Vec<f64> = numbers.split(',').map(|n| n.parse().unwrap()).collect();
            let [input, expected] = [0, 3].map(|at| DVec3::from_slice(&numbers[at..at + 3]));
            let got = match curve {
                "agx" => display(input, Tonemap::Agx),
                // The others are linear, and go through sRGB after.
                "aces" => aces(input).clamp(DVec3::ZERO, DVec3::ONE),
                "reinhard" => input / (DVec3::ONE + input),
                curve => panic!("{curve}"),
            };
            let expected = expected.min(DVec3::ONE);
            assert!((got - expected).abs().max_element() < 1e-9, "{curve} of {input}: {got}, expected {expected}");
            if curve != "agx" {
                let tonemap = if curve == "aces" { Tonemap::Aces } else { Tonemap::Reinhard };
                let shown = display(input, tonemap);
                assert!((shown - srgb(expected)).abs().max_element() < 1e-9, "{curve} of {input}: {shown}");
            }
            count += 1;
        }
        assert_eq!(count, 40);
    }
}
