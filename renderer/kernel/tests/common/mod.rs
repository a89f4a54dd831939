//! What the tests share: random numbers that are not the kernel's, χ² tests, quadrature and tables.
#![allow(dead_code, reason = "every test file is a program of its own and uses a part")]

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3, UVec4, Vec2, Vec3, Vec4};
use kinora_kernel::generated::{
    CHOICE, COMPENSATE, MATERIAL_DIELECTRIC, MATERIAL_DIFFUSE, MATERIAL_GLOSSY, MATERIAL_METAL, MATERIAL_SHEEN,
    METAL_SPECTRUM, MIRROR_ALPHA, NONE, PRIMITIVE_SPHERE,
};
use kinora_kernel::{Material, Packed, Primitive, Shape, albedo};

/// SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// 0 <= u < 1, a multiple of 2⁻²⁴ as the kernel's own numbers are.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }

    pub fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub fn square(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }

    pub fn cube(&mut self, half: f32) -> Vec3 {
        Vec3::new(self.within(-half, half), self.within(-half, half), self.within(-half, half))
    }

    pub fn direction(&mut self) -> Vec3 {
        let u = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        let phi = TAU * (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        direction(1.0 - 2.0 * u, phi)
    }
}

/// The unit vector with that z and azimuth.
pub fn direction(z: f64, phi: f64) -> Vec3 {
    let s = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(s * phi.cos(), s * phi.sin(), z).normalize().as_vec3()
}

/// A flat primitive of that kind; a triangle's last corner is its first.
pub fn flat(kind: u32, shape: u32, index: u32, [a, b, c, d]: [Vec3; 4]) -> Primitive {
    Primitive {
        x: Vec4::new(a.x, b.x, c.x, d.x),
        y: Vec4::new(a.y, b.y, c.y, d.y),
        z: Vec4::new(a.z, b.z, c.z, d.z),
        shade: UVec4::new(0, 0, 0, kind | shape),
        index: UVec4::new(index, 0, 0, 0),
    }
}

/// The unit sphere of that shape.
pub fn round(shape: u32) -> Primitive {
    Primitive { shade: UVec4::new(0, 0, 0, PRIMITIVE_SPHERE | shape), ..Primitive::default() }
}

/// A shape whose unit sphere, or plane z = 0, lies there.
pub fn placed(place: DAffine3) -> Shape {
    let row = |m: &DAffine3, i: usize| m.matrix3.row(i).extend(m.translation[i]).as_vec4();
    let inverse = place.inverse();
    Shape {
        world_from_object_x: row(&place, 0),
        world_from_object_y: row(&place, 1),
        world_from_object_z: row(&place, 2),
        object_from_world_x: row(&inverse, 0),
        object_from_world_y: row(&inverse, 1),
        object_from_world_z: row(&inverse, 2),
        index: UVec4::new(0, NONE, NONE, 0),
    }
}

/// The scene whose only materials are these, of which the first is looked at.
pub fn scene(materials: &[Material]) -> Packed {
    Packed { materials: materials.to_vec().into(), ..Packed::empty() }
}

/// `model`: DIFFUSE_….
pub fn diffuse(rho: f32, roughness: f32, model: u32) -> Material {
    Material {
        color: Vec3::splat(rho).extend(0.0),
        more: Vec4::W,
        lobe: Vec4::new(0.0, 0.0, roughness, 0.0),
        kind: UVec4::new(MATERIAL_DIFFUSE, model | if roughness > 0.0 { CHOICE } else { 0 }, 0, 0),
        ..Material::default()
    }
}

/// GGX of that roughness and anisotropy as the kernel is told of it.
pub fn widths(roughness: f32, anisotropy: f32) -> Vec4 {
    let [along, across] = albedo::alphas(roughness.into(), anisotropy.into()).map(|alpha| alpha as f32);
    let narrowest = if along < MIRROR_ALPHA { 0.0 } else { MIRROR_ALPHA };
    Vec4::new(along.max(narrowest), across.max(narrowest), roughness, anisotropy)
}

/// A metal that loses what is scattered more than once. `tint`: F82-tint's, the colour at 82° over Schlick's there.
pub fn metal(color: Vec3, tint: Vec3, lobe: Vec4) -> Material {
    let c = 1.0 / 7.0_f32;
    let schlick = color + (Vec3::ONE - color) * (1.0 - c).powi(5);
    Material {
        color: color.extend(1.0),
        extra: (schlick * (Vec3::ONE - tint) / (c * (1.0 - c).powi(6))).extend(0.0),
        more: Vec4::W,
        lobe,
        kind: UVec4::new(MATERIAL_METAL, 0, 0, 0),
    }
}

/// The same metal by refractive index and extinction.
pub fn measured(n: Vec3, k: Vec3, lobe: Vec4) -> Material {
    Material {
        color: n.extend(1.0),
        extra: k.extend(0.0),
        more: Vec4::W,
        lobe,
        kind: UVec4::new(MATERIAL_METAL, METAL_SPECTRUM, 0, 0),
    }
}

/// That metal with what is scattered more than once (Kulla and Conty 2017): F²E / (1 − F(1 − E)) / (1 − E), with F and E
/// the averages of reflectance and albedo.
pub fn compensated(mut metal: Material) -> Material {
    let lost = albedo::average_lost(metal.lobe.z.into(), metal.lobe.w.into());
    let average = scene(&[metal]).with_kernel(|k| {
        let b = k.bsdf_at(0, 1.0, 0.0);
        albedo::average(|c| k.metal_fresnel(b, c))
    });
    let multiple = average.as_dvec3().map(|f| f * f * (1.0 - lost) / (1.0 - f * lost) / lost);
    metal.more = multiple.as_vec3().extend(1.0);
    metal.kind.y |= COMPENSATE | CHOICE;
    metal
}

/// `flags`: of COMPENSATE and DIELECTRIC_THIN.
pub fn glass(ior: f32, roughness: f32, flags: u32) -> Material {
    Material {
        color: Vec4::ONE,
        extra: Vec3::ZERO.extend(ior),
        more: Vec4::W,
        lobe: widths(roughness, 0.0),
        kind: UVec4::new(MATERIAL_DIELECTRIC, flags | if roughness > 0.0 { CHOICE } else { 0 }, 0, 0),
    }
}

/// A coat over the material of that index, never metal.
pub fn glossy(ior: f32, roughness: f32, base: u32) -> Material {
    Material {
        color: Vec4::ONE,
        more: Vec4::W,
        lobe: Vec4::new(widths(roughness, 0.0).x, ior, roughness, 0.0),
        kind: UVec4::new(MATERIAL_GLOSSY, CHOICE, base, base),
        ..Material::default()
    }
}

/// Fibres over the material of that index.
pub fn fibres(color: Vec3, roughness: f32, base: u32) -> Material {
    Material {
        color: color.extend(0.0),
        more: Vec4::W,
        lobe: Vec4::new(0.0, 0.0, roughness, 0.0),
        kind: UVec4::new(MATERIAL_SHEEN, CHOICE, base, 0),
        ..Material::default()
    }
}

/// The rows of a table below its header.
pub fn rows(csv: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    csv.lines().skip(1).map(|line| line.split(',').collect())
}

pub fn number(field: &str) -> f64 {
    field.parse().unwrap_or_else(|_| panic!("not a number: {field:?}"))
}

/// Of all tests of a file together, how often they may fail by chance.
const FAMILY_LEVEL: f64 = 0.01;

/// The level of one of `tests` tests (Šidák).
pub fn level(family: f64, tests: usize) -> f64 {
    1.0 - (1.0 - family).powf(1.0 / tests as f64)
}

/// How many standard errors a mean may be off in one of `tests` tests.
pub fn sigmas(tests: usize) -> f64 {
    let level = level(FAMILY_LEVEL, tests);
    // P(|z| > x) = Q(1/2, x²/2).
    let (mut low, mut high) = (0.0, 20.0);
    for _ in 0..60 {
        let x = 0.5 * (low + high);
        if gamma_q(0.5, 0.5 * x * x) > level { low = x } else { high = x }
    }
    high
}

// Lanczos, g = 7, n = 9; relative error 1e-15.
fn ln_gamma(x: f64) -> f64 {
    const C: [f64; 9] = [
        0.999_999_999_999_809_9,
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    if x < 0.5 {
        return (PI / (PI * x).sin()).ln() - ln_gamma(1.0 - x);
    }
    let x = x - 1.0;
    let t = x + 7.5;
    let sum = C[0] + (1..9).map(|i| C[i] / (x + i as f64)).sum::<f64>();
    0.5 * TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

/// The regularised upper incomplete gamma function Q(a, x).
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..100_000 {
            term *= x / (a + n as f64);
            sum += term;
            if term < sum * 1e-16 {
                break;
            }
        }
        return 1.0 - front * sum;
    }
    // Lentz's continued fraction.
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for n in 1..100_000 {
        let k = -(n as f64) * (n as f64 - a);
        b += 2.0;
        d = 1.0 / (k * d + b);
        c = b + k / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// What came out of a χ² test.
pub struct ChiSquare {
    pub chi2: f64,
    pub dof: usize,
    pub p: f64,
}

/// Pools the bins of fewer than 5 expected. What must not occur may occur 1e-5 times a sample.
pub fn chi_square(observed: &[f64], expected: &[f64]) -> ChiSquare {
    assert_eq!(observed.len(), expected.len());
    let samples: f64 = observed.iter().sum();
    let mut bins: Vec<(f64, f64)> = expected.iter().copied().zip(observed.iter().copied()).collect();
    bins.sort_by(|a, b| a.0.total_cmp(&b.0));
    let forbidden: f64 = bins.iter().filter(|bin| bin.0 <= 0.0).map(|bin| bin.1).sum();
    if forbidden > samples * 1e-5 {
        return ChiSquare { chi2: f64::INFINITY, dof: 0, p: 0.0 };
    }
    let mut pool = (0.0, 0.0);
    let mut chi2 = 0.0;
    let mut kept = 0;
    for (e, o) in bins {
        if e < 5.0 || (pool.0 > 0.0 && pool.0 < 5.0) {
            pool = (pool.0 + e, pool.1 + o);
        } else {
            chi2 += (o - e) * (o - e) / e;
            kept += 1;
        }
    }
    if pool.0 > 0.0 {
        chi2 += (pool.1 - pool.0) * (pool.1 - pool.0) / pool.0;
        kept += 1;
    }
    let dof = kept - 1;
    ChiSquare { chi2, dof, p: gamma_q(0.5 * dof as f64, 0.5 * chi2) }
}

/// Fails if the counts are too unlikely for one of `tests` tests.
#[track_caller]
pub fn check_counts(name: &str, tests: usize, observed: &[f64], expected: &[f64]) {
    let result = chi_square(observed, expected);
    assert!(
        result.p >= level(FAMILY_LEVEL, tests),
        "{name}: p = {:e} (χ² = {}, {} degrees of freedom)",
        result.p,
        result.chi2,
        result.dof
    );
}

/// Shows that [`check_counts`] sees what it should: `expected` scaled by 1.02 in the first half of its mass, and by as
/// much less in the rest, must be rejected.
#[track_caller]
pub fn check_rejects(name: &str, tests: usize, observed: &[f64], expected: &[f64]) {
    let total: f64 = expected.iter().sum();
    let mut before = 0.0;
    let first: Vec<bool> = expected
        .iter()
        .map(|e| {
            before += e;
            before <= 0.5 * total
        })
        .collect();
    let half: f64 = expected.iter().zip(&first).filter(|(_, first)| **first).map(|(e, _)| e).sum();
    let rest = (total - 1.02 * half) / (total - half);
    let wrong: Vec<f64> = expected.iter().zip(&first).map(|(e, f)| if *f { 1.02 * e } else { rest * e }).collect();
    let p = chi_square(observed, &wrong).p;
    assert!(p < level(FAMILY_LEVEL, tests), "{name}: a pdf wrong by 2 % passes with p = {p}");
}

/// Mean and standard error.
#[derive(Clone, Copy, Default)]
pub struct Mean {
    count: f64,
    sum: f64,
    squares: f64,
}

impl Mean {
    pub fn add(&mut self, x: f64) {
        self.count += 1.0;
        self.sum += x;
        self.squares += x * x;
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.count
    }

    pub fn error(&self) -> f64 {
        ((self.squares / self.count - self.mean() * self.mean()).max(0.0) / (self.count - 1.0)).sqrt()
    }

    /// Fails if the mean is not `truth` by one of `tests` tests, or too uncertain to say so.
    #[track_caller]
    pub fn check(&self, name: &str, tests: usize, truth: f64, tolerance: f64, uncertainty: f64) {
        let (mean, error) = (self.mean(), self.error());
        assert!(error <= uncertainty * truth, "{name}: an error of {error} at {truth} proves nothing");
        assert!(
            (mean - truth).abs() <= sigmas(tests) * error + tolerance,
            "{name}: {mean} ± {error}, but should be {truth}"
        );
    }
}

/// Nodes and weights of Gauss and Legendre's rule on 0..1.
pub fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    (p0, p1) = (p1, ((2 * k - 1) as f64 * x * p1 - (k - 1) as f64 * p0) / k as f64);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// The integral over a rectangle, split until it is good to `relative` or `absolute`.
pub fn integrate(
    rule: &[(f64, f64)],
    low: [f64; 2],
    high: [f64; 2],
    [relative, absolute]: [f64; 2],
    f: &mut impl FnMut(f64, f64) -> f64,
) -> f64 {
    let whole = panel(rule, low, high, f);
    refine(rule, low, high, [relative, absolute], whole, 7, f)
}

fn panel(rule: &[(f64, f64)], low: [f64; 2], high: [f64; 2], f: &mut impl FnMut(f64, f64) -> f64) -> f64 {
    let size = [high[0] - low[0], high[1] - low[1]];
    let mut sum = 0.0;
    for (x, wx) in rule {
        for (y, wy) in rule {
            sum += wx * wy * f(low[0] + x * size[0], low[1] + y * size[1]);
        }
    }
    sum * size[0] * size[1]
}

fn refine(
    rule: &[(f64, f64)],
    low: [f64; 2],
    high: [f64; 2],
    [relative, absolute]: [f64; 2],
    whole: f64,
    depth: u32,
    f: &mut impl FnMut(f64, f64) -> f64,
) -> f64 {
    let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
    let parts = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[i, j]: [usize; 2]| {
        let low = [if i == 0 { low[0] } else { middle[0] }, if j == 0 { low[1] } else { middle[1] }];
        let high = [if i == 0 { middle[0] } else { high[0] }, if j == 0 { middle[1] } else { high[1] }];
        (low, high, panel(rule, low, high, f))
    });
    let sum: f64 = parts.iter().map(|part| part.2).sum();
    if depth == 0 || (sum - whole).abs() <= (relative * sum.abs()).max(absolute) {
        return sum;
    }
    parts
        .into_iter()
        .map(|(low, high, whole)| refine(rule, low, high, [relative, 0.25 * absolute], whole, depth - 1, f))
        .sum()
}

/// Bins of equal solid angle over the sphere or, with `z_low` 0, the upper hemisphere.
pub struct SphereBins {
    pub z_low: f64,
    pub rows: usize,
    pub columns: usize,
    /// Whether the density jumps, so that a bin is integrated by many midpoints.
    pub jumps: bool,
    /// By how much the density may be off as a whole, because it is divided by a number from a table.
    pub off: f64,
}

impl SphereBins {
    fn of(&self, d: Vec3) -> Option<usize> {
        let z = f64::from(d.z);
        if z < self.z_low {
            return None;
        }
        let turn = f64::from(d.y).atan2(f64::from(d.x)) / TAU;
        let row = ((z - self.z_low) / (1.0 - self.z_low) * self.rows as f64) as usize;
        let column = ((turn - turn.floor()) * self.columns as f64) as usize;
        Some(row.min(self.rows - 1) * self.columns + column.min(self.columns - 1))
    }

    /// The integral of a density a steradian over each bin, for so many samples.
    pub fn expected(&self, samples: f64, mut pdf: impl FnMut(Vec3) -> f64) -> Vec<f64> {
        let rule = gauss(6);
        let height = (1.0 - self.z_low) / self.rows as f64;
        let width = TAU / self.columns as f64;
        (0..self.rows * self.columns)
            .map(|i| {
                let low = [self.z_low + (i / self.columns) as f64 * height, (i % self.columns) as f64 * width];
                let high = [low[0] + height, low[1] + width];
                if self.jumps {
                    const STEPS: usize = 48;
                    let middle = |k: usize| (k as f64 + 0.5) / STEPS as f64;
                    let sum: f64 = (0..STEPS * STEPS)
                        .map(|k| (low[0] + height * middle(k / STEPS), low[1] + width * middle(k % STEPS)))
                        .map(|(z, phi)| pdf(direction(z, phi)))
                        .sum();
                    return samples * sum * height * width / (STEPS * STEPS) as f64;
                }
                samples * integrate(&rule, low, high, [1e-4, 1e-2 / samples], &mut |z, phi| pdf(direction(z, phi)))
            })
            .collect()
    }

    /// Draws `samples` directions and compares their counts with the density, those that are none with what the density
    /// lacks. Gives both counts.
    #[track_caller]
    pub fn check(
        &self,
        name: &str,
        tests: usize,
        samples: usize,
        mut draw: impl FnMut() -> Option<Vec3>,
        pdf: impl FnMut(Vec3) -> f64,
    ) -> (Vec<f64>, Vec<f64>) {
        let mut observed = vec![0.0; self.rows * self.columns];
        let mut lost = 0.0;
        for _ in 0..samples {
            match draw() {
                Some(d) => {
                    let bin = self.of(d).unwrap_or_else(|| panic!("{name}: {d} is no possible direction"));
                    observed[bin] += 1.0;
                }
                None => lost += 1.0,
            }
        }
        let count = samples as f64;
        let mut expected = self.expected(count, pdf);
        let inside: f64 = expected.iter().sum();
        let share = (1.0 - inside / count).clamp(0.0, 1.0);
        let slack = sigmas(tests) * (share * (1.0 - share) / count).sqrt() + 1e-4 + self.off;
        assert!(inside / count < 1.0 + 1e-3 + self.off, "{name}: the pdf integrates to {}", inside / count);
        assert!((lost / count - share).abs() <= slack, "{name}: {} have no direction, not {share}", lost / count);
        for e in &mut expected {
            *e *= (count - lost) / inside;
        }
        check_counts(name, tests, &observed, &expected);
        (observed, expected)
    }
}
