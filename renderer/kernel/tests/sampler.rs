//! The random numbers: known vectors, and that they are as even as they promise.

mod common;

use common::{Mean, Random, check_counts, check_rejects, chi_square, gamma_q, level, number, rows};
use glam::{UVec2, Vec2};
use kinora_kernel::generated::{DIM_BOUNCE, SAMPLER_RANDOM, SAMPLER_SOBOL};
use kinora_kernel::{Kernel, Packed};

const VECTORS: &str = include_str!("data/sampling.csv");

fn vectors(kind: &str) -> impl Iterator<Item = [f64; 3]> {
    let found: Vec<_> = rows(VECTORS)
        .filter(|row| row[0] == kind)
        .map(|row| [1, 2, 3].map(|i| if row[i].is_empty() { 0.0 } else { number(row[i]) }))
        .collect();
    assert!(!found.is_empty(), "no vectors of {kind}");
    found.into_iter()
}

fn with<R>(sampler: u32, seed: u32, f: impl FnOnce(&Kernel<'_>) -> R) -> R {
    let mut packed = Packed::empty();
    packed.params.sampler = sampler;
    packed.params.seed = seed;
    packed.with_kernel(f)
}

const SAMPLERS: [u32; 2] = [SAMPLER_SOBOL, SAMPLER_RANDOM];

#[test]
fn hashes_give_the_published_numbers() {
    with(SAMPLER_SOBOL, 0, |k| {
        for [x, _, want] in vectors("pcg") {
            assert_eq!(f64::from(k.pcg(x as u32)), want, "pcg({x})");
        }
        // The vectors are of whole scrambles; the kernel's function takes and gives reversed bits.
        for [x, seed, want] in vectors("owen_hash") {
            let got = k.owen_hash((x as u32).reverse_bits(), seed as u32).reverse_bits();
            assert_eq!(f64::from(got), want, "owen_hash({x}, {seed})");
        }
    });
}

#[test]
fn points_are_sobols() {
    with(SAMPLER_SOBOL, 0, |k| {
        let unscrambled = |i: u32| [i.reverse_bits(), k.sobol_second_reversed(i).reverse_bits()];
        for [i, dimension, want] in vectors("sobol_point") {
            assert_eq!(f64::from(unscrambled(i as u32)[dimension as usize]), want, "point {i}");
        }
        for [bit, dimension, want] in vectors("sobol_direction") {
            assert_eq!(f64::from(unscrambled(1 << bit as u32)[dimension as usize]), want, "direction {bit}");
        }
        let mut random = Random(1);
        for _ in 0..1000 {
            let (a, b) = (random.bits() as u32, random.bits() as u32);
            let sum = k.sobol_second_reversed(a) ^ k.sobol_second_reversed(b);
            assert_eq!(k.sobol_second_reversed(a ^ b), sum, "not linear");
        }
        let seeds = UVec2::new(0x9e37_79b9, 0x9e37_79b9_u32.wrapping_mul(2));
        for [i, dimension, want] in vectors("owen_sobol") {
            let got = k.owen_sobol(i as u32, seeds)[dimension as usize];
            assert_eq!(f64::from(got), want, "scrambled point {i}");
        }
    });
}

// Every elementary interval of area 2⁻ⁿ holds one of 2ⁿ points.
fn is_net(points: &[UVec2]) -> bool {
    let n = points.len().ilog2();
    (0..=n).all(|bits| {
        let mut seen = vec![false; points.len()];
        points.iter().all(|p| {
            let x = if bits == 0 { 0 } else { p.x >> (32 - bits) };
            let y = if bits == n { 0 } else { p.y >> (32 - (n - bits)) };
            !std::mem::replace(&mut seen[((x << (n - bits)) | y) as usize], true)
        })
    })
}

#[test]
fn scrambled_points_are_nets() {
    with(SAMPLER_SOBOL, 0, |k| {
        let mut random = Random(2);
        for n in 0..=12 {
            for first in [0, 1, 5] {
                let seeds = UVec2::new(random.bits() as u32, random.bits() as u32);
                let points: Vec<_> = (0..1 << n).map(|i| k.owen_sobol((first << n) + i, seeds)).collect();
                assert!(is_net(&points), "{} points from block {first} with {seeds}", points.len());
            }
        }
        let points: Vec<_> = (1..257).map(|i| k.owen_sobol(i, UVec2::new(1, 2))).collect();
        assert!(!is_net(&points), "256 points across two blocks cannot be a net");
    });
}

#[test]
fn samples_of_a_pixel_are_nets() {
    with(SAMPLER_SOBOL, 7, |k| {
        for pixel in [UVec2::ZERO, UVec2::new(1919, 1079)] {
            for dimension in [0, 1, DIM_BOUNCE, 40] {
                for count in [16, 64, 256, 4096] {
                    let points: Vec<_> = (0..count)
                        .map(|i| (k.random_2d(k.sample_key(pixel, i), dimension) * 4_294_967_296.0).as_uvec2())
                        .collect();
                    assert!(is_net(&points), "{count} samples of {pixel} in dimension {dimension}");
                }
            }
        }
    });
}

#[test]
fn numbers_are_below_1() {
    with(SAMPLER_SOBOL, 0, |k| {
        assert_eq!(k.unit_float(0), 0.0);
        assert_eq!(k.unit_float(u32::MAX), 1.0_f32.next_down());
        assert_eq!(k.unit_float(1 << 31), 0.5);
    });
    for sampler in SAMPLERS {
        with(sampler, u32::MAX, |k| {
            for i in 0..200_000 {
                let key = k.sample_key(UVec2::new(i, !i), i.wrapping_mul(0x9e37_79b9));
                let u = k.random_2d(key, i);
                let v = k.random_1d(key, i);
                assert!([u.x, u.y, v].iter().all(|u| (0.0..1.0).contains(u)), "{u} {v}");
            }
        });
    }
}

#[test]
fn numbers_depend_on_the_key_alone() {
    for sampler in SAMPLERS {
        let draw = |seed, pixel, sample, dimension| {
            with(sampler, seed, |k| {
                let key = k.sample_key(pixel, sample);
                (k.random_2d(key, dimension), k.random_1d(key, dimension))
            })
        };
        let pixel = UVec2::new(3, 4);
        let one = draw(1, pixel, 2, 5);
        assert_eq!(one, draw(1, pixel, 2, 5));
        let others = [draw(2, pixel, 2, 5), draw(1, pixel.yx(), 2, 5), draw(1, pixel, 3, 5), draw(1, pixel, 2, 6)];
        for other in others {
            assert!(one.0.x != other.0.x && one.0.y != other.0.y && one.1 != other.1);
        }
    }
}

trait Swap {
    fn yx(self) -> Self;
}

impl Swap for UVec2 {
    fn yx(self) -> Self {
        UVec2::new(self.y, self.x)
    }
}

const CELLS: usize = 32;
const COUNT: usize = 1_000_000;

fn cell(u: f32) -> usize {
    (u * CELLS as f32) as usize
}

// Counts of pairs of numbers over a grid.
fn pairs(draws: impl Iterator<Item = Vec2>) -> Vec<f64> {
    let mut bins = vec![0.0; CELLS * CELLS];
    for u in draws {
        bins[cell(u.x) * CELLS + cell(u.y)] += 1.0;
    }
    bins
}

fn evenly() -> Vec<f64> {
    vec![COUNT as f64 / (CELLS * CELLS) as f64; CELLS * CELLS]
}

#[test]
fn numbers_are_independent_over_pixels() {
    let tests = 2 * 8;
    for sampler in SAMPLERS {
        with(sampler, 11, |k| {
            let pixel = |i: usize| UVec2::new(i as u32 % 1000, i as u32 / 1000);
            let of = |i: usize, sample, dimension| k.random_2d(k.sample_key(pixel(i), sample), dimension);
            let one = |i: usize, sample, dimension| k.random_1d(k.sample_key(pixel(i), sample), dimension);
            let check = |name: &str, f: &dyn Fn(usize) -> Vec2| {
                let bins = pairs((0..COUNT).map(f));
                check_counts(&format!("{name} of sampler {sampler}"), tests, &bins, &evenly());
            };
            // One sample of many pixels.
            check("a pair", &|i| of(i, 0, 0));
            check("a pair of a later bounce", &|i| of(i, 3, DIM_BOUNCE + 20));
            check("x of neighbouring dimensions", &|i| Vec2::new(of(i, 0, 0).x, of(i, 0, 1).x));
            check("y and x of neighbouring dimensions", &|i| Vec2::new(of(i, 1, 2).y, of(i, 1, 3).x));
            check("neighbouring samples and dimensions", &|i| Vec2::new(of(i, 0, 4).x, of(i, 1, 5).x));
            check("neighbouring pixels", &|i| Vec2::new(of(i, 0, 0).x, of(i + 1, 0, 0).x));
            check("single numbers", &|i| Vec2::new(one(i, 0, 4), one(i, 0, 7)));
            check("a single number and a pair", &|i| Vec2::new(one(i, 0, 4), of(i, 0, 4).x));
        });
    }
}

#[test]
fn dimensions_are_independent_over_samples() {
    let tests = 2 * 4;
    for sampler in SAMPLERS {
        with(sampler, 5, |k| {
            let check = |name: &str, f: &dyn Fn(kinora_kernel::generated::SampleKey) -> Vec2| {
                // Many samples of few pixels: 4096 of each, more even than chance, never less.
                let bins = pairs((0..COUNT).map(|i| {
                    let pixel = UVec2::new((i / 4096) as u32, 17);
                    f(k.sample_key(pixel, (i % 4096) as u32))
                }));
                check_counts(&format!("{name} of sampler {sampler}"), tests, &bins, &evenly());
            };
            check("x, x", &|key| Vec2::new(k.random_2d(key, 0).x, k.random_2d(key, 1).x));
            check("x, y", &|key| Vec2::new(k.random_2d(key, 2).x, k.random_2d(key, 5).y));
            check("y, y", &|key| Vec2::new(k.random_2d(key, 3).y, k.random_2d(key, 4).y));
            check("roulette, x", &|key| Vec2::new(k.random_1d(key, 4), k.random_2d(key, 5).x));
        });
    }
}

#[test]
fn error_falls_faster_than_by_chance() {
    // A smooth integrand with integral 1.
    let f = |u: Vec2| f64::from(u.x * u.y * 4.0) * (1.0 + (f64::from(u.x) - f64::from(u.y)) * 0.5);
    let rms = |sampler, count: u32| {
        with(sampler, 3, |k| {
            let squares: f64 = (0..200)
                .map(|pixel| {
                    let pixel = UVec2::new(pixel, 0);
                    let sum: f64 = (0..count).map(|i| f(k.random_2d(k.sample_key(pixel, i), 2))).sum();
                    (sum / f64::from(count) - 1.0).powi(2)
                })
                .sum();
            (squares / 200.0).sqrt()
        })
    };
    let slope = |sampler| (rms(sampler, 1024) / rms(sampler, 16)).ln() / 64.0_f64.ln();
    let (sobol, random) = (slope(SAMPLER_SOBOL), slope(SAMPLER_RANDOM));
    assert!(sobol < -1.2, "N^{sobol}");
    assert!((random + 0.5).abs() < 0.1, "N^{random}");
}

#[test]
fn means_are_right() {
    for sampler in SAMPLERS {
        let mut mean = Mean::default();
        for seed in 0..500 {
            let estimate = with(sampler, seed, |k| {
                (0..64)
                    .map(|i| {
                        let key = k.sample_key(UVec2::new(9, 9), i);
                        let (u, v) = (k.random_2d(key, 2), k.random_2d(key, 3));
                        f64::from(u.x * u.y * v.x * v.y) * 16.0
                    })
                    .sum::<f64>()
                    / 64.0
            });
            mean.add(estimate);
        }
        mean.check(&format!("sampler {sampler}"), 2, 1.0, 1e-5, 0.02);
    }
}

#[test]
fn the_judge_is_right() {
    for [a, x, want] in vectors("gamma_q") {
        assert!((gamma_q(a, x) - want).abs() < 1e-10, "Q({a}, {x}) = {}", gamma_q(a, x));
    }
    for [family, tests, want] in vectors("sidak") {
        assert!((level(family, tests as usize) - want).abs() < 1e-12);
    }
    let expected = [40.0, 30.0, 20.0, 10.0, 4.0, 3.0, 2.0, 1.5, 0.4, 0.1];
    let observed = [37.0, 35.0, 18.0, 9.0, 6.0, 2.0, 2.0, 1.0, 1.0, 0.0];
    let result = chi_square(&observed, &expected);
    assert!((result.chi2 - 1.449_242_424_242).abs() < 1e-9, "{}", result.chi2);
    assert_eq!(result.dof, 4);
    assert!((result.p - 0.835_592_877_7).abs() < 1e-9, "{}", result.p);
    with(SAMPLER_RANDOM, 1, |k| {
        let bins = pairs((0..COUNT).map(|i| k.random_2d(k.sample_key(UVec2::new(i as u32, 0), 0), 0)));
        check_rejects("pairs", 1, &bins, &evenly());
    });
}
