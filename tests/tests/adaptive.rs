//! What adaptive sampling saves at equal error, and that what is rare keeps its mean.

use std::sync::LazyLock;

use glam::Vec3;
use kinora_renderer::{Choice, Film};
use kinora_tests::{render, scene_of};

const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

fn draw(settings: &str, scene: &str) -> Film {
    let text = format!("lang 1\nrender {{ {settings} }}\n{scene}");
    render(&scene_of(&text, &Default::default()), 0, Choice::Cpu)
}

/// A sky that fills half of the picture over a floor.
const HALF: &str = "camera { position: (0, 1.2, 6), look_at: (0, 1.2, 0), fov: 45deg }
plane { material: diffuse { color: #aaa } }
";

/// With the target that brings the error of some 150 samples everywhere.
static SCENES: LazyLock<[(&str, &str, String); 4]> = LazyLock::new(|| {
    let scene = |rest: &str| format!("{HALF}{rest}");
    [
        (
            "a bare floor under a lamp",
            "1.4%",
            scene(
                "sky { color: linear(0.3, 0.4, 0.6) }
                sphere { position: (0.5, 4, 1), radius: 0.15, material: emitter { radiance: 200W/m^2/sr } }",
            ),
        ),
        (
            "a ball under the sky",
            "4%",
            scene(
                "sky { color: linear(0.5, 0.7, 1) }
                sphere { position: (0, 0.6, 0), radius: 0.6, material: diffuse { color: #c44 } }",
            ),
        ),
        (
            "a box in the sun",
            "2.2%",
            scene(
                "sky { color: linear(0.5, 0.7, 1) }
                box { position: (0, 0.5, 0), rotation: axis_angle((0, 1, 0), 30deg), material: diffuse { color: #4c4 } }
                sun { direction: (1, -1.2, -0.6), irradiance: 3W/m^2, angle: 2deg }",
            ),
        ),
        (
            "a square lamp",
            "2.7%",
            scene(
                "sky { color: linear(0.2, 0.25, 0.3) }
                box { position: (0.8, 0.5, 0), material: diffuse { color: #48c } }
                quad { position: (-0.5, 2.2, 0.5), normal: (0, -1, 0), size: (0.6, 0.6), material: emitter { radiance: 12W/m^2/sr } }",
            ),
        ),
    ]
});

/// Mean of (luminance − truth)² / (truth² + 0.0001).
fn relative_error(film: &Film, truth: &Film) -> f64 {
    let of = |film: &Film| -> Vec<f64> { film.mean().iter().map(|light| f64::from(light.dot(LUMINANCE))).collect() };
    let (film, truth) = (of(film), of(truth));
    let off = film.iter().zip(&truth).map(|(a, b)| (a - b).powi(2) / (b * b + 1e-4));
    off.sum::<f64>() / truth.len() as f64
}

#[test]
fn half_a_sky_saves_samples_at_equal_error() {
    const SIZE: &str = "resolution: (64, 64), max_bounces: 3";
    const SEEDS: u32 = 4;
    for (name, target, scene) in SCENES.iter() {
        let truth = draw(&format!("{SIZE}, samples: 4096, seed: 9"), scene);
        let mean = |settings: &str| {
            let films = (0..SEEDS).map(|seed| draw(&format!("{SIZE}, {settings}, seed: {seed}"), scene));
            let both = films.map(|film| (relative_error(&film, &truth), film.mean_samples()));
            let (error, samples) = both.fold((0.0, 0.0), |sum, film| (sum.0 + film.0, sum.1 + film.1));
            (error / f64::from(SEEDS), samples / f64::from(SEEDS))
        };
        let uniform = [64, 96, 128, 192, 256, 384].map(|samples| mean(&format!("samples: {samples}")));
        let (error, samples) = mean(&format!("samples: 1024, adaptive: {target}"));
        // How many samples everywhere have that error: between two numbers along a power of them.
        let (a, b) =
            uniform.windows(2).map(|pair| (pair[0], pair[1])).find(|(_, b)| b.0 <= error).expect("more samples");
        assert!(error <= a.0, "{name}: an error of {error} is not among {uniform:?}");
        let equal = a.1 * (b.1 / a.1).powf((a.0 / error).ln() / (a.0 / b.0).ln());
        assert!(samples <= 0.65 * equal, "{name}: {samples} samples are as good as {equal} everywhere");
    }
}

#[test]
fn what_is_rare_keeps_its_mean() {
    // 500 in one sample of 500.
    let veil = "camera { position: (0, 0, 3), look_at: (0, 0, 0) }
        quad { normal: (0, 0, 1), size: (20, 20), material: emitter { radiance: 500W/m^2/sr, opacity: 0.002 } }";
    let mean = |seed: u32| {
        let film = draw(&format!("resolution: (64, 64), samples: 1024, adaptive: 10%, seed: {seed}"), veil);
        let light = film.mean();
        light.iter().map(|light| f64::from(light.x)).sum::<f64>() / light.len() as f64
    };
    // The standard deviation of one is 1.1 %.
    let mean = (0..4).map(mean).sum::<f64>() / 4.0;
    assert!((mean - 1.0).abs() < 0.02, "{mean}");
}
