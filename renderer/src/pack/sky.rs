//! Skies that are not the same everywhere: the map's texels and the sums by which it is sampled, as words, and what the sun
//! makes of clear air.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec3, UVec4, Vec3};
use kinora_scene::{Image, SkyLight, Still, Texels};
use rayon::prelude::*;

use super::lights::luminance;

/// A picture of all directions.
struct Map {
    /// Texels in a row, rows.
    size: [usize; 2],
    /// Row by row from the top; finite and 0 or more.
    texels: Vec<Vec3>,
}

/// Most cells along a row; half as many rows. A cell of a larger map holds several texels.
const MAX_COLUMNS: usize = 2048;
/// Brighter texels are taken for this: sums over a picture of them are still finite.
const BRIGHTEST: f32 = 1e20;

/// The map of a picture; what is no light in it is 0.
fn map_of(image: &Image) -> Map {
    let clean = |c: f32| if c > 0.0 { c.min(BRIGHTEST) } else { 0.0 };
    let of = |rgb: [f32; 3]| Vec3::from_array(rgb.map(clean));
    let texels = match image.texels() {
        Texels::Rgba8(texels) => {
            texels.par_iter().map(|&[r, g, b, _]| of([r, g, b].map(|c| f32::from(c) / 255.0))).collect()
        }
        Texels::Rgba16(texels) => {
            texels.par_iter().map(|&[r, g, b, _]| of([r, g, b].map(|c| f32::from(c) / 65535.0))).collect()
        }
        Texels::Rgba32F(texels) => texels.par_iter().map(|&[r, g, b, _]| of([r, g, b])).collect(),
    };
    Map { size: [image.width as usize, image.height as usize], texels }
}

/// A sky as words, and the sun in it.
pub struct Laid {
    /// The light of which it is made.
    of: SkyLight<Still>,
    /// Its words, and where they lie if they are the first.
    words: Vec<u32>,
    placed: Placed,
    /// Where the sun of clear air stands, half the angle of its disc, and its irradiance where it is 1 above the air.
    pub sun: Option<(DVec3, f64, Vec3)>,
}

/// The last sky that was laid out: pictures of a film, and moments of a picture, mostly have the same.
static LAST: Mutex<Option<Arc<Laid>>> = Mutex::new(None);

/// Lays out a sky; `None` of one that is the same everywhere.
pub fn lay(light: &SkyLight<Still>) -> Option<Arc<Laid>> {
    let same = |laid: &&Arc<Laid>| match (&laid.of, light) {
        // However it is turned.
        (SkyLight::Map { image: a, .. }, SkyLight::Map { image: b, .. }) => Arc::ptr_eq(a, b),
        (a, b) => a == b,
    };
    let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(laid) = last.as_ref().filter(same) {
        return Some(laid.clone());
    }
    let (map, sun) = match light {
        SkyLight::Color(_) => return None,
        SkyLight::Map { image, .. } => (map_of(image), None),
        &SkyLight::Nishita { sun_elevation, sun_azimuth, turbidity } => {
            let Computed { map, to_sun, half_angle, sun } = nishita(sun_elevation, sun_azimuth, turbidity);
            (map, Some((to_sun, half_angle, sun)))
        }
    };
    let mut words = Vec::new();
    let placed = place(&map, &mut words);
    let laid = Arc::new(Laid { of: light.clone(), words, placed, sun });
    *last = Some(laid.clone());
    Some(laid)
}

impl Laid {
    /// How many words it has.
    pub fn len(&self) -> usize {
        self.words.len()
    }

    /// Appends it to `words`.
    pub fn append(&self, words: &mut Vec<u32>) -> Placed {
        let first = words.len() as u32;
        words.extend_from_slice(&self.words);
        let Placed { map, cells, irradiance } = self.placed;
        let at = UVec4::new(first, 0, 0, 0);
        Placed { map: map + at, cells: cells + at, irradiance }
    }
}

/// A map among the words of a scene.
#[derive(Clone, Copy)]
pub struct Placed {
    /// As `Params::sky_map`, without its light.
    pub map: UVec4,
    /// As `Params::sky_cells`.
    pub cells: UVec4,
    /// ∫ L dω, luminance.
    pub irradiance: f64,
}

/// Appends a map to `words`.
fn place(map: &Map, words: &mut Vec<u32>) -> Placed {
    let [width, height] = map.size;
    let first = words.len();
    words.extend(map.texels.iter().flat_map(|texel| texel.to_array().map(f32::to_bits)));
    let columns = width.next_power_of_two().clamp(2, MAX_COLUMNS);
    let rows = height.next_power_of_two().clamp(2, MAX_COLUMNS / 2);

    // The mean over every cell of the map as it is interpolated: a texel is a tent over its neighbours, so that the mean
    // is above 0 wherever the map is.
    let across = tents(width, columns, true);
    let down = tents(height, rows, false);
    let squeezed: Vec<Vec<f64>> = map
        .texels
        .par_chunks(width)
        .map(|row| {
            let mut cells = vec![0.0; columns];
            for (texel, shares) in row.iter().zip(&across) {
                let light = luminance(*texel);
                if light > 0.0 {
                    shares.iter().for_each(|&(cell, share)| cells[cell] += light * share);
                }
            }
            cells
        })
        .collect();
    let mut means = vec![0.0; columns * rows];
    for (row, shares) in squeezed.iter().zip(&down) {
        for &(cell, share) in shares {
            let into = &mut means[cell * columns..(cell + 1) * columns];
            into.iter_mut().zip(row).for_each(|(sum, light)| *sum += light * share);
        }
    }
    let edge = |row: usize| (PI * row as f64 / rows as f64).cos();
    for (row, cells) in means.chunks_mut(columns).enumerate() {
        let solid_angle = TAU / columns as f64 * (edge(row) - edge(row + 1));
        cells.iter_mut().for_each(|cell| *cell *= solid_angle);
    }
    let irradiance: f64 = means.iter().sum();

    // In units of the whole, so that the smallest and the largest light give the same sums.
    let at = words.len();
    words.resize(at + 2 * rows + 2 * columns * rows, 0);
    let (row_tree, trees) = words[at..].split_at_mut(2 * rows);
    let whole = if irradiance > 0.0 { irradiance } else { 1.0 };
    for (row, cells) in means.chunks(columns).enumerate() {
        let tree = &mut trees[2 * columns * row..2 * columns * (row + 1)];
        let leaves: Vec<f32> = cells.iter().map(|cell| (cell / whole) as f32).collect();
        row_tree[rows + row] = sum_tree(&leaves, tree).to_bits();
    }
    let leaves: Vec<f32> = row_tree[rows..].iter().map(|word| f32::from_bits(*word)).collect();
    sum_tree(&leaves, row_tree);
    Placed {
        map: UVec4::new(first as u32, width as u32, height as u32, 0),
        cells: UVec4::new(at as u32, columns as u32, rows as u32, 0),
        irradiance,
    }
}

// Fills a tree of sums, the root at 1, whose second half are the leaves; gives the sum of all.
fn sum_tree(leaves: &[f32], tree: &mut [u32]) -> f32 {
    let count = leaves.len();
    for (word, leaf) in tree[count..].iter_mut().zip(leaves) {
        *word = leaf.to_bits();
    }
    for i in (1..count).rev() {
        tree[i] = (f32::from_bits(tree[2 * i]) + f32::from_bits(tree[2 * i + 1])).to_bits();
    }
    f32::from_bits(tree[1])
}

// Of every texel along an axis, the share that it has in the mean of the cells that it reaches.
fn tents(texels: usize, cells: usize, wraps: bool) -> Vec<Vec<(usize, f64)>> {
    let width = texels as f64 / cells as f64;
    // ∫ of the tent about 0 from −∞.
    let below = |t: f64| match t {
        t if t <= -1.0 => 0.0,
        t if t <= 0.0 => 0.5 * (t + 1.0).powi(2),
        t if t <= 1.0 => 1.0 - 0.5 * (1.0 - t).powi(2),
        _ => 1.0,
    };
    (0..texels)
        .map(|i| {
            let centre = i as f64 + 0.5;
            let mut shares: Vec<(usize, f64)> = Vec::new();
            let (from, to) = (((centre - 1.0) / width).floor() as i64, ((centre + 1.0) / width).ceil() as i64);
            for cell in from..to {
                let edge = |cell: i64| below(cell as f64 * width - centre);
                let share = (edge(cell + 1) - edge(cell)) / width;
                let inside = (0..cells as i64).contains(&cell);
                let place = if wraps { cell.rem_euclid(cells as i64) as usize } else { cell.max(0) as usize };
                if share > 0.0 && (wraps || inside) {
                    shares.push((place, share));
                }
            }
            // Beyond the poles there is no texel: the last one reaches as far as its edge. A single one is both the first
            // and the last.
            let first = |x: f64| x.min(0.5);
            let last = |x: f64| x.max(texels as f64 - 0.5);
            let mut beyond = |clip: &dyn Fn(f64) -> f64| {
                for cell in 0..cells {
                    let (low, high) = (clip(cell as f64 * width), clip((cell + 1) as f64 * width));
                    let edge = |x: f64| below(x - centre);
                    let share = ((high - low) - (edge(high) - edge(low))) / width;
                    if share > 0.0 {
                        shares.push((cell, share));
                    }
                }
            };
            if !wraps && i == 0 {
                beyond(&first);
            }
            if !wraps && i + 1 == texels {
                beyond(&last);
            }
            shares
        })
        .collect()
}

// --- Nishita et al. 1993, single scattering; light-transport: Rayleigh and Mie, each with its own height

const EARTH_M: f64 = 6_360e3;
const AIR_M: f64 = 6_420e3;
const RAYLEIGH: DVec3 = DVec3::new(5.8e-6, 13.5e-6, 33.1e-6);
const RAYLEIGH_HEIGHT_M: f64 = 8_000.0;
const MIE: f64 = 21e-6;
const MIE_HEIGHT_M: f64 = 1_200.0;
/// Haze takes away more than it scatters.
const MIE_EXTINCTION: f64 = 1.1;
const MIE_ANISOTROPY: f64 = 0.76;
const EYE_M: f64 = 1.0;
/// Half of the sun's disc as seen from the earth, in radians.
const SUN_HALF_ANGLE: f64 = 0.2665 * PI / 180.0;

/// Texels in a row and rows of a computed sky.
const SIZE: [usize; 2] = [1024, 512];
/// Directions round half of the horizon at which the integrals are worked out; between them they are interpolated.
const AZIMUTHS: usize = 48;
const VIEW_NODES: usize = 40;
const SUN_NODES: usize = 20;

/// A computed sky under a sun of irradiance 1 above the air, and its sun.
struct Computed {
    /// Without the disc.
    map: Map,
    /// From the eye to the sun.
    to_sun: DVec3,
    /// Half angle of the sun's disc.
    half_angle: f64,
    /// W/m² of the disc on a surface that faces it; 0 below the horizon.
    sun: Vec3,
}

/// The sky when the sun stands so high above the horizon, so far from −z towards +x.
fn nishita(elevation: f64, azimuth: f64, turbidity: f64) -> Computed {
    let air = Air { turbidity, view: nodes(VIEW_NODES), sun: nodes(SUN_NODES) };
    let (sin, cos) = elevation.sin_cos();
    // In the plane of azimuth 0.
    let sun = DVec3::new(0.0, sin, -cos);
    let [width, height] = SIZE;
    let rows: Vec<Vec<Vec3>> = (0..height)
        .into_par_iter()
        .map(|row| {
            let theta = PI * (row as f64 + 0.5) / height as f64;
            let (r, y) = theta.sin_cos();
            let toward = |turn: f64| DVec3::new(r * turn.sin(), y, -r * turn.cos());
            let integrals: Vec<[DVec3; 2]> =
                (0..=AZIMUTHS).map(|i| air.scattered(toward(PI * i as f64 / AZIMUTHS as f64), sun)).collect();
            (0..width)
                .map(|column| {
                    let turn = TAU * ((column as f64 + 0.5) / width as f64 - 0.5) - azimuth;
                    let turn = (turn.rem_euclid(TAU) - if turn.rem_euclid(TAU) > PI { TAU } else { 0.0 }).abs();
                    let at = turn / PI * AZIMUTHS as f64;
                    let i = (at as usize).min(AZIMUTHS - 1);
                    let mix = |k: usize| integrals[i][k].lerp(integrals[i + 1][k], at - i as f64);
                    let c = toward(turn).dot(sun);
                    (mix(0) * rayleigh_phase(c) + mix(1) * mie_phase(c)).as_vec3().max(Vec3::ZERO)
                })
                .collect()
        })
        .collect();
    let (turn_sin, turn_cos) = azimuth.sin_cos();
    let eye = DVec3::Y * (EARTH_M + EYE_M);
    let direct = match air.depth(eye, sun) {
        Some(depth) => air.transmittance(depth),
        None => DVec3::ZERO,
    };
    Computed {
        map: Map { size: SIZE, texels: rows.concat() },
        to_sun: DVec3::new(cos * turn_sin, sin, -cos * turn_cos),
        half_angle: SUN_HALF_ANGLE,
        sun: direct.as_vec3(),
    }
}

fn rayleigh_phase(c: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + c * c)
}

fn mie_phase(c: f64) -> f64 {
    let g = MIE_ANISOTROPY;
    3.0 / (8.0 * PI) * (1.0 - g * g) * (1.0 + c * c) / ((2.0 + g * g) * (1.0 + g * g - 2.0 * g * c).powf(1.5))
}

struct Air {
    turbidity: f64,
    view: Vec<[f64; 2]>,
    sun: Vec<[f64; 2]>,
}

impl Air {
    // Optical depth of Rayleigh and Mie scattering at 1/m each from `p` to the edge of the air; none through the earth.
    fn depth(&self, p: DVec3, d: DVec3) -> Option<[f64; 2]> {
        if sphere(p, d, EARTH_M).is_some_and(|[near, _]| near > 0.0) {
            return None;
        }
        let length = sphere(p, d, AIR_M).map_or(0.0, |[_, far]| far.max(0.0));
        let mut sum = [0.0; 2];
        for [at, weight] in &self.sun {
            let [rayleigh, mie] = densities(p + d * (at * length));
            sum[0] += rayleigh * weight * length;
            sum[1] += mie * weight * length;
        }
        Some(sum)
    }

    fn transmittance(&self, [rayleigh, mie]: [f64; 2]) -> DVec3 {
        let depth = RAYLEIGH * rayleigh + MIE * self.turbidity * MIE_EXTINCTION * mie;
        DVec3::new((-depth.x).exp(), (-depth.y).exp(), (-depth.z).exp())
    }

    // What the eye receives along `d` from Rayleigh and from Mie scattering, phase functions apart.
    fn scattered(&self, d: DVec3, sun: DVec3) -> [DVec3; 2] {
        let eye = DVec3::Y * (EARTH_M + EYE_M);
        let length = match sphere(eye, d, EARTH_M) {
            Some([near, _]) if near > 0.0 => near,
            _ => sphere(eye, d, AIR_M).map_or(0.0, |[_, far]| far),
        };
        let mut sums = [DVec3::ZERO; 2];
        for [at, weight] in &self.view {
            // Air is thin far away: nodes gather near the eye.
            let s = at * at * length;
            let step = 2.0 * at * weight * length;
            let p = eye + d * s;
            let Some(from_sun) = self.depth(p, sun) else { continue };
            // To the eye: what is left of the way through the air, without what lies behind.
            let mut to_eye = [0.0; 2];
            for [at, weight] in &self.sun {
                let [rayleigh, mie] = densities(eye + d * (at * s));
                to_eye[0] += rayleigh * weight * s;
                to_eye[1] += mie * weight * s;
            }
            let arrives = self.transmittance([from_sun[0] + to_eye[0], from_sun[1] + to_eye[1]]);
            let [rayleigh, mie] = densities(p);
            sums[0] += arrives * (rayleigh * step);
            sums[1] += arrives * (mie * step);
        }
        [sums[0] * RAYLEIGH, sums[1] * (MIE * self.turbidity)]
    }
}

fn densities(p: DVec3) -> [f64; 2] {
    let height = p.length() - EARTH_M;
    [(-height / RAYLEIGH_HEIGHT_M).exp(), (-height / MIE_HEIGHT_M).exp()]
}

// Where a line meets a sphere about the earth's centre.
fn sphere(p: DVec3, d: DVec3, radius: f64) -> Option<[f64; 2]> {
    let b = p.dot(d);
    let across = (p - d * b).length();
    let half = ((radius - across) * (radius + across)).sqrt();
    (across <= radius).then(|| [-b - half, -b + half])
}

// Nodes and weights of Gauss and Legendre over 0..1, by Newton's method.
fn nodes(count: usize) -> Vec<[f64; 2]> {
    let n = count as f64;
    (0..count)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                let (mut p, mut before) = (1.0, 0.0);
                for k in 0..count {
                    let k = k as f64;
                    (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
                }
                slope = n * (x * p - before) / (x * x - 1.0);
                x -= p / slope;
            }
            [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    // L / E of six directions, integrated by Gauss and Legendre and by Simpson's rule in f64 by other programs:
    // zenith angles of the view and of the sun, azimuth between them.
    const SKIES: [([f64; 3], [f64; 3]); 6] = [
        ([0.0, 45.0, 0.0], [0.005_694_235, 0.009_970_339, 0.018_129_482]),
        ([60.0, 45.0, 0.0], [0.056_164_285, 0.062_304_632, 0.070_636_007]),
        ([60.0, 45.0, 180.0], [0.005_492_921, 0.011_113_547, 0.020_545_235]),
        ([85.0, 45.0, 90.0], [0.018_933_091, 0.030_120_291, 0.035_308_473]),
        ([30.0, 80.0, 0.0], [0.004_943_095, 0.007_983_652, 0.011_198_951]),
        ([80.0, 80.0, 180.0], [0.019_658_850, 0.031_682_972, 0.031_753_288]),
    ];

    fn interpolated(map: &Map, d: DVec3) -> DVec3 {
        let [width, height] = map.size;
        let s = (0.5 + d.x.atan2(-d.z) / TAU) * width as f64 - 0.5;
        let t = (d.y.acos() / PI * height as f64 - 0.5).clamp(0.0, height as f64 - 1.0);
        let texel = |x: f64, y: f64| {
            let y = (y as usize).min(height - 1);
            map.texels[y * width + x.rem_euclid(width as f64) as usize].as_dvec3()
        };
        let row = |y: f64| texel(s.floor(), y).lerp(texel(s.floor() + 1.0, y), s - s.floor());
        row(t.floor()).lerp(row(t.floor() + 1.0), t - t.floor())
    }

    #[test]
    fn a_computed_sky_is_the_integral() {
        for ([view, sun, azimuth], truth) in SKIES {
            let turned = 0.7;
            let sky = nishita((90.0 - sun).to_radians(), turned, 1.0);
            let ((r, y), turn) = (view.to_radians().sin_cos(), azimuth.to_radians() + turned);
            let got = interpolated(&sky.map, DVec3::new(r * turn.sin(), y, -r * turn.cos()));
            let truth = DVec3::from_array(truth);
            let off = ((got - truth) / truth).abs().max_element();
            // Straight up a map shows what is half a texel away.
            let most = if view == 0.0 { 6e-3 } else { 3e-3 };
            assert!(off < most, "view {view}, sun {sun}, azimuth {azimuth}: {got}, not {truth}");
        }
    }

    #[test]
    fn shares_of_all_texels_make_one() {
        for (texels, cells) in [(1, 2), (3, 4), (256, 256), (551, 1024), (4096, 2048)] {
            for wraps in [true, false] {
                let mut sums = vec![0.0; cells];
                for (cell, share) in tents(texels, cells, wraps).into_iter().flatten() {
                    sums[cell] += share;
                }
                assert!(sums.iter().all(|sum: &f64| (sum - 1.0).abs() < 1e-9), "{texels} {cells} {wraps}: {sums:?}");
            }
        }
    }
}
