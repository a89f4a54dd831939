//! Materials, as the literature writes them.

use std::collections::HashMap;
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};
use kinora_scene::{Bsdf, DiffuseModel, Emission, Material, Reflectance, Still};

use super::Rng;

/// Roughness α below which a surface is a mirror or clear glass.
const SMOOTH: f64 = 1e-3;

/// Scattering at one point: the new direction in the frame of the surface (z on the side of `wo`), and f · |cos| / pdf.
pub type Scattered = Option<(DVec3, DVec3)>;

/// What a path finds at a point of a material tree.
pub enum Lobe {
    /// A hole.
    Nothing,
    /// The coat of a glossy material.
    Coat { alpha: f64, ior: f64, tint: DVec3 },
    /// The fibres of the material with this index.
    Fibres { material: usize },
    /// The material with this index, or the metal of a metallic glossy material.
    Leaf { material: usize, metal: bool },
}

/// The materials of a world with what has to be integrated beforehand.
pub struct Matter<'w> {
    materials: &'w [Material<Still>],
    /// Of each material that is a metal, or glossy.
    metals: Vec<Option<Metal>>,
    /// Of each coat, each thin sheet, and white fibres.
    whole: Vec<Option<Albedo>>,
    /// What a rough dielectric keeps, by material and relative index.
    kept: HashMap<(usize, u64), Albedo>,
}

struct Metal {
    fresnel: Fresnel,
    alpha: DVec2,
    rotation: f64,
    /// Kulla and Conty's: 1 − albedo, and the factor of the added lobe.
    lost: Option<(Albedo, DVec3)>,
}

enum Fresnel {
    /// Reflectance at 0° and tint at 82°.
    Tint(DVec3, DVec3),
    /// n and k.
    Conductor(DVec3, DVec3),
}

impl<'w> Matter<'w> {
    pub fn new(materials: &'w [Material<Still>]) -> Self {
        let metals = (0..materials.len()).map(|i| metal_of(materials, i)).collect();
        let whole = materials.iter().map(|material| match material.bsdf {
            Bsdf::Glossy { ior, roughness, .. } if roughness * roughness >= SMOOTH => {
                let alpha = DVec2::splat(roughness * roughness);
                Some(Albedo::new(true, |wo| {
                    facets(wo, alpha, |m| both_see(wo, reflect(wo, m), alpha) * fresnel(wo.dot(m), ior))
                }))
            }
            Bsdf::Dielectric { thin: true, roughness, energy_compensation: true, .. } => {
                let alpha = DVec2::splat(roughness * roughness);
                Some(Albedo::new(true, |wo| facets(wo, alpha, |m| both_see(wo, reflect(wo, m), alpha))))
            }
            Bsdf::Sheen { roughness, .. } => Some(Albedo::new(true, |wo| {
                let steps = 200;
                let at = |i: i32| (f64::from(i) + 0.5) / f64::from(steps);
                let cosines =
                    (0..steps).flat_map(|i| (0..steps).map(move |j| (at(i).powi(2), TAU * at(j), 2.0 * at(i))));
                let sum: f64 = cosines
                    .map(|(z, phi, step)| {
                        let r = (1.0 - z * z).sqrt();
                        step * fibres(roughness, wo, DVec3::new(r * phi.cos(), r * phi.sin(), z))
                    })
                    .sum();
                TAU * sum / f64::from(steps * steps)
            })),
            _ => None,
        });
        let mut kept = HashMap::new();
        let all: Vec<f64> = std::iter::once(1.0).chain(materials.iter().filter_map(ior_of)).collect();
        for (i, material) in materials.iter().enumerate() {
            let Bsdf::Dielectric { ior, roughness, energy_compensation: true, thin: false, .. } = material.bsdf else {
                continue;
            };
            let alpha = DVec2::splat(roughness * roughness);
            for eta in all.iter().flat_map(|other| [ior / other, other / ior]) {
                kept.entry((i, eta.to_bits())).or_insert_with(|| {
                    Albedo::new(true, |wo| {
                        facets(wo, alpha, |m| {
                            let f = fresnel(wo.dot(m), eta);
                            let through = refract(wo, m, eta).filter(|wi| wi.z < 0.0);
                            let through = through.map_or(0.0, |wi| masking(wo, wi, alpha));
                            f * both_see(wo, reflect(wo, m), alpha) + (1.0 - f) * through
                        })
                    })
                });
            }
        }
        Matter { materials, metals, whole: whole.collect(), kept }
    }

    /// Radiance that a surface of `material` and `area` sends at cosine `c` with its outer normal.
    pub fn emitted(&self, material: usize, c: f64, area: f64) -> DVec3 {
        let Material { opacity, bsdf, .. } = &self.materials[material];
        *opacity
            * match bsdf {
                Bsdf::Emitter { color, emission, two_sided } if c > 0.0 || *two_sided => {
                    let sides = if *two_sided { 2.0 } else { 1.0 };
                    color.as_dvec3()
                        * match emission {
                            Emission::Radiance(radiance) => *radiance,
                            Emission::Power(power) => power / (PI * area * sides),
                        }
                }
                Bsdf::Mix { a, b, amount } => {
                    (1.0 - amount) * self.emitted(*a, c, area) + amount * self.emitted(*b, c, area)
                }
                Bsdf::Glossy { base, metalness, .. } => {
                    (1.0 - metalness) * (1.0 - self.coat_albedo(material, c.abs())) * self.emitted(*base, c, area)
                }
                Bsdf::Sheen { base, .. } => self.emitted(*base, c, area),
                _ => DVec3::ZERO,
            }
    }

    /// Chooses one of what a material is made of, seen at cosine `c`; the factor makes up for the choice.
    pub fn choose(&self, material: usize, c: f64, rng: &mut Rng) -> (Lobe, f64) {
        let (mut at, mut factor) = (material, 1.0);
        loop {
            if rng.next() >= self.materials[at].opacity {
                return (Lobe::Nothing, factor);
            }
            match self.materials[at].bsdf {
                Bsdf::Mix { a, b, amount } => at = if rng.next() < amount { b } else { a },
                Bsdf::Glossy { metalness, .. } if rng.next() < metalness => {
                    return (Lobe::Leaf { material: at, metal: true }, factor);
                }
                Bsdf::Glossy { ior, tint, roughness, base, .. } => {
                    factor *= 2.0;
                    if rng.next() < 0.5 {
                        return (Lobe::Coat { alpha: roughness * roughness, ior, tint: tint.as_dvec3() }, factor);
                    }
                    factor *= 1.0 - self.coat_albedo(at, c);
                    at = base;
                }
                Bsdf::Sheen { base, color, .. } => {
                    factor *= 2.0;
                    if rng.next() < 0.5 {
                        return (Lobe::Fibres { material: at }, factor);
                    }
                    factor *= 1.0 - f64::from(color.max_element()) * self.coat_albedo(at, c);
                    at = base;
                }
                Bsdf::Metal { .. } => return (Lobe::Leaf { material: at, metal: true }, factor),
                _ => return (Lobe::Leaf { material: at, metal: false }, factor),
            }
        }
    }

    fn coat_albedo(&self, material: usize, c: f64) -> f64 {
        match (&self.whole[material], &self.materials[material].bsdf) {
            (Some(albedo), _) => albedo.at(DVec3::new((1.0 - c * c).max(0.0).sqrt(), 0.0, c)),
            (None, Bsdf::Glossy { ior, .. }) => fresnel(c, *ior),
            _ => 0.0,
        }
    }

    /// How far the frame of a material's surface is turned about its outer normal, in radians.
    pub fn rotation(&self, lobe: &Lobe) -> f64 {
        match lobe {
            Lobe::Leaf { material, metal: true } => self.metals[*material].as_ref().map_or(0.0, |metal| metal.rotation),
            _ => 0.0,
        }
    }

    /// Whether the lobe bounds a medium.
    pub fn is_boundary(&self, lobe: &Lobe) -> Option<usize> {
        match lobe {
            Lobe::Leaf { material, .. } => {
                matches!(self.materials[*material].bsdf, Bsdf::Dielectric { thin: false, .. }).then_some(*material)
            }
            _ => None,
        }
    }

    /// A direction for light that leaves along `wo`; `eta`: index beyond the surface over index before it, of boundaries.
    pub fn scatter(&self, lobe: &Lobe, wo: DVec3, eta: f64, rng: &mut Rng) -> Scattered {
        match *lobe {
            Lobe::Nothing => None,
            Lobe::Coat { alpha, ior, tint } => {
                let (m, seen) = facet(wo, DVec2::splat(alpha), rng);
                let wi = reflect(wo, m);
                let c = wo.dot(m);
                let white = seen * fresnel(c, ior) * both_see(wo, wi, DVec2::splat(alpha));
                Some((wi, white * tint.lerp(DVec3::ONE, (1.0 - c).powi(5))))
            }
            Lobe::Fibres { material } => {
                let Bsdf::Sheen { color, roughness, .. } = &self.materials[material].bsdf else { return None };
                let wi = rng.cosine();
                Some((wi, color.as_dvec3() * (PI * fibres(*roughness, wo, wi) / wi.z)))
            }
            Lobe::Leaf { material, metal: true } => self.metals[material].as_ref()?.scatter(wo, rng),
            Lobe::Leaf { material, metal: false } => match &self.materials[material].bsdf {
                Bsdf::Diffuse { color, roughness, model } => {
                    let wi = rng.cosine();
                    Some((wi, diffuse(color.as_dvec3(), *roughness, *model, wo, wi)))
                }
                Bsdf::Dielectric { thin: true, ior, roughness, .. } => {
                    self.thin(material, *ior, roughness * roughness, wo, rng)
                }
                Bsdf::Dielectric { roughness, .. } => self.boundary(material, roughness * roughness, eta, wo, rng),
                _ => None,
            },
        }
    }

    /// A sheet reflects 2F / (1 + F) and lets the rest through; where it is rough, mirrored at the sheet.
    fn thin(&self, material: usize, ior: f64, alpha: f64, wo: DVec3, rng: &mut Rng) -> Scattered {
        let alpha = DVec2::splat(alpha);
        let (m, seen) = facet(wo, alpha, rng);
        let f = fresnel(wo.dot(m), ior);
        let wi = reflect(wo, m);
        let gain = self.whole[material].as_ref().map_or(1.0, |albedo| 1.0 / albedo.at(wo));
        let side = if rng.next() < 2.0 * f / (1.0 + f) { 1.0 } else { -1.0 };
        Some((DVec3::new(wi.x, wi.y, side * wi.z), DVec3::splat(gain * seen * both_see(wo, wi, alpha))))
    }

    /// The boundary of a dielectric (Walter et al. 2007), of radiance: what comes from the far side is η² times as bright
    /// there.
    fn boundary(&self, material: usize, alpha: f64, eta: f64, wo: DVec3, rng: &mut Rng) -> Scattered {
        let alpha = DVec2::splat(alpha);
        let (m, seen) = facet(wo, alpha, rng);
        let gain = self.kept.get(&(material, eta.to_bits())).map_or(1.0, |albedo| 1.0 / albedo.at(wo));
        if rng.next() < fresnel(wo.dot(m), eta) {
            let wi = reflect(wo, m);
            return Some((wi, DVec3::splat(gain * seen * both_see(wo, wi, alpha))));
        }
        let wi = refract(wo, m, eta)?;
        let through = if wi.z < 0.0 { masking(wo, wi, alpha) } else { 0.0 };
        Some((wi, DVec3::splat(gain * seen * through / (eta * eta))))
    }
}

/// Refractive index of a material that is a medium.
pub fn ior_of(material: &Material<Still>) -> Option<f64> {
    match material.bsdf {
        Bsdf::Dielectric { ior, thin: false, .. } => Some(ior),
        _ => None,
    }
}

fn metal_of(materials: &[Material<Still>], index: usize) -> Option<Metal> {
    let (fresnel, roughness, anisotropy, rotation, compensate) = match &materials[index].bsdf {
        Bsdf::Metal { reflectance, roughness, anisotropy, anisotropy_rotation, energy_compensation } => {
            let fresnel = match reflectance {
                Reflectance::Tint { color, edge_tint } => Fresnel::Tint(color.as_dvec3(), edge_tint.as_dvec3()),
                Reflectance::Spectrum(spectrum) => {
                    let (n, k) = super::optical_constants(*spectrum);
                    Fresnel::Conductor(n, k)
                }
            };
            (fresnel, *roughness, *anisotropy, *anisotropy_rotation, *energy_compensation)
        }
        Bsdf::Glossy { base, roughness, metalness, .. } if *metalness > 0.0 => {
            let color = match &materials[*base].bsdf {
                Bsdf::Diffuse { color, .. } => color.as_dvec3(),
                Bsdf::Metal { reflectance: Reflectance::Tint { color, .. }, .. } => color.as_dvec3(),
                _ => DVec3::ZERO,
            };
            (Fresnel::Tint(color, DVec3::ONE), *roughness, 0.0, 0.0, true)
        }
        _ => return None,
    };
    // OpenPBR 1.1, section "Microfacet model".
    let along = roughness * roughness * (2.0 / (1.0 + (1.0 - anisotropy).powi(2))).sqrt();
    let alpha = DVec2::new(along, (1.0 - anisotropy) * along);
    let lost = (compensate && alpha.max_element() >= SMOOTH).then(|| {
        let albedo = Albedo::new(anisotropy == 0.0, |wo| facets(wo, alpha, |m| both_see(wo, reflect(wo, m), alpha)));
        let average = albedo.average();
        let steps = 4096;
        let cosines = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps));
        let f = cosines.map(|c| fresnel.at(c) * 2.0 * c).sum::<DVec3>() / f64::from(steps);
        let factor = f * f * average / (DVec3::ONE - f * (1.0 - average)) / (PI * (1.0 - average));
        (albedo, factor)
    });
    Some(Metal { fresnel, alpha, rotation, lost })
}

impl Metal {
    fn scatter(&self, wo: DVec3, rng: &mut Rng) -> Scattered {
        if let Some((albedo, factor)) = &self.lost
            && rng.next() < 1.0 - albedo.at(wo)
        {
            let wi = rng.cosine();
            return Some((wi, PI * *factor * (1.0 - albedo.at(wi))));
        }
        let kept = self.lost.as_ref().map_or(1.0, |(albedo, _)| albedo.at(wo));
        let (m, seen) = facet(wo, self.alpha, rng);
        let wi = reflect(wo, m);
        Some((wi, self.fresnel.at(wo.dot(m)) * seen * both_see(wo, wi, self.alpha) / kept))
    }
}

impl Fresnel {
    fn at(&self, c: f64) -> DVec3 {
        match *self {
            Fresnel::Tint(f0, tint) => {
                let schlick = |c: f64| f0 + (1.0 - f0) * (1.0 - c).powi(5);
                let edge = 1.0 / 7.0;
                let a = schlick(edge) * (1.0 - tint) / (edge * (1.0_f64 - edge).powi(6));
                (schlick(c) - a * c * (1.0 - c).powi(6)).clamp(DVec3::ZERO, DVec3::ONE)
            }
            Fresnel::Conductor(n, k) => {
                let channel = |i: usize| conductor(n[i], k[i], c);
                DVec3::new(channel(0), channel(1), channel(2))
            }
        }
    }
}

/// Reflectance of a conductor n + ik: the amplitudes in complex arithmetic.
fn conductor(n: f64, k: f64, c: f64) -> f64 {
    type Complex = (f64, f64);
    let mul = |(a, b): Complex, (x, y): Complex| (a * x - b * y, a * y + b * x);
    let norm = |(a, b): Complex| a * a + b * b;
    let eta2 = mul((n, k), (n, k));
    // The root of η² − sin².
    let z = (eta2.0 - (1.0 - c * c), eta2.1);
    let size = norm(z).sqrt();
    let root = ((0.5 * (size + z.0)).max(0.0).sqrt(), (0.5 * (size - z.0)).max(0.0).sqrt());
    let s = norm((c - root.0, -root.1)) / norm((c + root.0, root.1));
    let p = (eta2.0 * c, eta2.1 * c);
    let p = norm((p.0 - root.0, p.1 - root.1)) / norm((p.0 + root.0, p.1 + root.1));
    0.5 * (s + p)
}

/// Reflectance of a dielectric boundary at cosine `c`, by angles: Fresnel's sine and tangent laws.
pub fn fresnel(c: f64, eta: f64) -> f64 {
    let sin_t = (1.0 - c * c).max(0.0).sqrt() / eta;
    if sin_t >= 1.0 {
        return 1.0;
    }
    let (i, t) = (c.clamp(0.0, 1.0).acos(), sin_t.asin());
    if i < 1e-4 {
        return ((eta - 1.0) / (eta + 1.0)).powi(2);
    }
    let s = ((i - t).sin() / (i + t).sin()).powi(2);
    let p = ((i - t).tan() / (i + t).tan()).powi(2);
    0.5 * (s + p)
}

fn reflect(wo: DVec3, m: DVec3) -> DVec3 {
    2.0 * wo.dot(m) * m - wo
}

fn refract(wo: DVec3, m: DVec3, eta: f64) -> Option<DVec3> {
    let c = wo.dot(m);
    let cos2 = 1.0 - (1.0 - c * c) / (eta * eta);
    (cos2 > 0.0).then(|| -wo / eta + (c / eta - cos2.sqrt()) * m)
}

/// Smith's masking and shadowing of GGX facets, correlated by height (Heitz 2014, equation 99).
fn masking(wo: DVec3, wi: DVec3, alpha: DVec2) -> f64 {
    let lambda = |w: DVec3| {
        let tan2 = ((alpha.x * w.x).powi(2) + (alpha.y * w.y).powi(2)) / (w.z * w.z);
        0.5 * ((1.0 + tan2).sqrt() - 1.0)
    };
    1.0 / (1.0 + lambda(wo) + lambda(wi))
}

/// The share of a facet that is seen from both directions, if light is reflected above the horizon at all.
fn both_see(wo: DVec3, wi: DVec3, alpha: DVec2) -> f64 {
    if wi.z > 0.0 { masking(wo, wi, alpha) } else { 0.0 }
}

/// The facet whose slope a share `u` of all facets does not reach, towards `turn` of a whole one, and how large it is
/// seen from `wo` without masking: ⟨wo, m⟩ / (cos · m.z). Not at all from behind.
fn facet_at(wo: DVec3, alpha: DVec2, u: f64, turn: f64) -> (DVec3, f64) {
    let slope = (u / (1.0 - u)).sqrt();
    let (sin, cos) = (TAU * turn).sin_cos();
    let m = DVec3::new(alpha.x * slope * cos, alpha.y * slope * sin, 1.0).normalize();
    (m, wo.dot(m).max(0.0) / (wo.z * m.z))
}

/// A facet by GGX's density; of a smooth surface, the surface.
fn facet(wo: DVec3, alpha: DVec2, rng: &mut Rng) -> (DVec3, f64) {
    if alpha.max_element() < SMOOTH {
        return (DVec3::Z, 1.0);
    }
    facet_at(wo, alpha, rng.next(), rng.next())
}

/// The mean of `share` over the facets, as large as they are seen from `wo`.
fn facets(wo: DVec3, alpha: DVec2, share: impl Fn(DVec3) -> f64) -> f64 {
    let steps = 64;
    let mut sum = 0.0;
    for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
        // Denser among the steep ones, which are seen large.
        let rest = 1.0 - (f64::from(i) + 0.5) / f64::from(steps);
        let (m, seen) = facet_at(wo, alpha, 1.0 - rest * rest, (f64::from(j) + 0.5) / f64::from(steps));
        if seen > 0.0 {
            sum += 2.0 * rest * seen * share(m);
        }
    }
    sum / f64::from(steps * steps)
}

/// A function of direction, symmetric about x and y, at nodes.
struct Albedo {
    turns: usize,
    values: Vec<f64>,
}

const COSINES: usize = 96;

impl Albedo {
    fn new(round: bool, f: impl Fn(DVec3) -> f64) -> Albedo {
        let turns = if round { 1 } else { 17 };
        let node = |i: usize| {
            // Denser where light grazes.
            let c = ((i / turns) as f64 / (COSINES - 1) as f64).powi(2).max(1e-4);
            let phi = FRAC_PI_2 * (i % turns) as f64 / (turns.max(2) - 1) as f64;
            let s = (1.0 - c * c).max(0.0).sqrt();
            f(DVec3::new(s * phi.cos(), s * phi.sin(), c))
        };
        Albedo { turns, values: (0..COSINES * turns).map(node).collect() }
    }

    fn at(&self, w: DVec3) -> f64 {
        let x = w.z.clamp(0.0, 1.0).sqrt() * (COSINES - 1) as f64;
        let phi = w.y.abs().atan2(w.x.abs()) / FRAC_PI_2 * (self.turns - 1) as f64;
        let (i, j) = ((x as usize).min(COSINES - 2), phi as usize);
        let line = |i: usize| {
            let value = |j: usize| self.values[i * self.turns + j.min(self.turns - 1)];
            value(j) + (phi - j as f64) * (value(j + 1) - value(j))
        };
        line(i) + (x - i as f64) * (line(i + 1) - line(i))
    }

    /// Over the hemisphere, by cosine.
    fn average(&self) -> f64 {
        let steps = 256;
        let mut sum = 0.0;
        for (i, j) in (0..steps).flat_map(|i| (0..steps).map(move |j| (i, j))) {
            let z2 = (f64::from(i) + 0.5) / f64::from(steps);
            let (sin, cos) = (TAU * (f64::from(j) + 0.5) / f64::from(steps)).sin_cos();
            let r = (1.0 - z2).sqrt();
            sum += self.at(DVec3::new(r * cos, r * sin, z2.sqrt()));
        }
        sum / f64::from(steps * steps)
    }
}

/// f · cos of white fibres (Estevez and Kulla 2017), α the square of the roughness, as in KHR_materials_sheen.
fn fibres(roughness: f64, wo: DVec3, wi: DVec3) -> f64 {
    let alpha = roughness.max(0.07).powi(2);
    let l = |x: f64| {
        let at = |i: usize| {
            let (smooth, rough) =
                ([25.3245, 3.32435, 0.16801, -1.27393, -4.85967], [21.5473, 3.82987, 0.19823, -1.97760, -4.32054]);
            rough[i] + (1.0 - alpha).powi(2) * (smooth[i] - rough[i])
        };
        at(0) / (1.0 + at(1) * x.powf(at(2))) + at(3) * x + at(4)
    };
    let lambda = |c: f64| if c < 0.5 { l(c).exp() } else { (2.0 * l(0.5) - l(1.0 - c)).exp() };
    let h = (wo + wi).normalize();
    let d = (2.0 + 1.0 / alpha) * (1.0 - h.z * h.z).max(0.0).sqrt().powf(1.0 / alpha) / TAU;
    d / ((1.0 + lambda(wo.z) + lambda(wi.z)) * 4.0 * wo.z)
}

/// π f of a diffuse surface.
fn diffuse(rho: DVec3, r: f64, model: DiffuseModel, wo: DVec3, wi: DVec3) -> DVec3 {
    let s = wi.dot(wo) - wi.z * wo.z;
    if model == DiffuseModel::Qon {
        let sigma2 = (r * FRAC_PI_2).powi(2);
        let (a, b) = (1.0 - 0.5 * sigma2 / (sigma2 + 0.33), 0.45 * sigma2 / (sigma2 + 0.09));
        return rho * (a + b * s.max(0.0) / wi.z.max(wo.z));
    }
    let t = if s > 0.0 { wi.z.max(wo.z) } else { 1.0 };
    let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let single = rho * a * (1.0 + r * s / t);
    if model == DiffuseModel::Fon || r == 0.0 {
        return single;
    }
    // Portsmouth, Kutz and Hill 2025.
    let albedo = |mu: f64| {
        let sin = (1.0 - mu * mu).max(0.0).sqrt();
        let g = sin * (mu.min(1.0).acos() - sin * mu) + 2.0 / 3.0 * (sin / mu * (1.0 - sin.powi(3)) - sin);
        a * (1.0 + r * FRAC_1_PI * g)
    };
    let average = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    let many = rho * rho * average / (DVec3::ONE - rho * (1.0 - average));
    single + many * (1.0 - albedo(wo.z)) * (1.0 - albedo(wi.z)) / (1.0 - average)
}
