//! An independent judge: a path tracer in f64 that shares nothing with the kernel. It tests every shape, samples no
//! light, no microfacet and no filter, and plays no roulette; it chooses directions by the cosine alone and follows what
//! is smooth. So it is slow, and its scenes are small, with large lamps.

mod matter;
mod solid;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use kinora_scene::{Blades, Bsdf, Projection, Spectrum, World};

use crate::measure::{Estimate, Region};
use matter::{Lobe, Matter, ior_of};
use solid::{Solid, nearest};

/// Rays that start on a surface meet nothing nearer, in metres: the scenes are a few metres wide.
const NEAR: f64 = 1e-9;
const CHUNK: u64 = 4096;

/// The mean radiance of a region by `paths` paths or a few more.
///
/// # Panics
/// A thread panics.
pub fn measure(world: &World, [left, top, right, bottom]: Region, paths: u64, seed: u64) -> Estimate {
    let judge = Judge::new(world);
    let (low, high) = (DVec2::new(left.into(), top.into()), DVec2::new(right.into(), bottom.into()));
    let chunk = |index: u64| {
        let mut rng = Rng((seed << 32) ^ index.wrapping_mul(0xd134_2543_de82_ef95));
        let mut sums = (DVec3::ZERO, DVec3::ZERO);
        for _ in 0..CHUNK {
            let film = low + (high - low) * DVec2::new(rng.next(), rng.next());
            let ray = judge.camera_ray(film, &mut rng);
            let light = ray.map_or(DVec3::ZERO, |(o, d)| judge.radiance(o, d, &mut rng));
            sums = (sums.0 + light, sums.1 + light * light);
        }
        sums
    };
    let chunks = paths.div_ceil(CHUNK);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let mut sums: Vec<_> = std::thread::scope(|scope| {
        let work =
            |thread| scope.spawn(move || (thread..chunks).step_by(threads as usize).map(|i| (i, chunk(i))).collect());
        let workers: Vec<std::thread::ScopedJoinHandle<'_, Vec<_>>> = (0..threads).map(work).collect();
        workers.into_iter().flat_map(|worker| worker.join().expect("a thread of the judge")).collect()
    });
    sums.sort_by_key(|(index, _)| *index);
    let n = (chunks * CHUNK) as f64;
    let (sum, squares) = sums.iter().fold((DVec3::ZERO, DVec3::ZERO), |a, (_, b)| (a.0 + b.0, a.1 + b.1));
    let mean = sum / n;
    let variance = (squares / n - mean * mean).max(DVec3::ZERO) / (n - 1.0);
    Estimate { mean, error: DVec3::new(variance.x.sqrt(), variance.y.sqrt(), variance.z.sqrt()), degrees: n - 1.0 }
}

struct Judge<'w> {
    world: &'w World,
    solids: Vec<Solid>,
    matter: Matter<'w>,
    /// The media around the camera, the one entered last at the end, by material.
    media: Vec<usize>,
}

impl<'w> Judge<'w> {
    fn new(world: &'w World) -> Self {
        let solids: Vec<Solid> = world.instances.iter().map(Solid::new).collect();
        let matter = Matter::new(&world.materials);
        let media = media_around(world, &solids);
        Judge { world, solids, matter, media }
    }

    /// A ray through the point of the picture, in pixels from its upper left corner; `None` where there is no picture.
    fn camera_ray(&self, film: DVec2, rng: &mut Rng) -> Option<(DVec3, DVec3)> {
        let view = &self.world.view;
        let [width, height] = self.world.render.resolution.map(f64::from);
        // From the middle to the right and up, in halves of the height.
        let (x, y) = ((2.0 * film.x - width) / height, 1.0 - 2.0 * film.y / height);
        let (mut o, d) = (DVec3::ZERO, |x, y| DVec3::new(x, y, -1.0));
        let d = match view.projection {
            Projection::Perspective { fov } => {
                o = self.lens(rng);
                let half = (0.5 * fov).tan();
                view.focus_m * d(half * x, half * y) - o
            }
            Projection::Orthographic { height_m } => {
                o = 0.5 * height_m * DVec3::new(x, y, 0.0);
                DVec3::NEG_Z
            }
            Projection::Panorama => {
                let (longitude, latitude) = ((2.0 * film.x / width - 1.0) * PI, 0.5 * PI * y);
                DVec3::new(longitude.sin() * latitude.cos(), latitude.sin(), -longitude.cos() * latitude.cos())
            }
            Projection::Fisheye { fov } => {
                let r = x.hypot(y);
                if r > 1.0 {
                    return None;
                }
                let (sin, cos) = (0.5 * fov * r).sin_cos();
                DVec3::new(sin * x / r.max(1e-30), sin * y / r.max(1e-30), -cos)
            }
        };
        let place = view.world_from_camera;
        Some((place.transform_point3(o), place.transform_vector3(d).normalize()))
    }

    /// A point of the lens; of one with corners by rejection.
    fn lens(&self, rng: &mut Rng) -> DVec3 {
        let Blades { count, rotation } = self.world.view.blades;
        loop {
            let (r, phi) = (rng.next().sqrt(), TAU * rng.next());
            // The distance of the edge from the middle where it is nearest.
            let (inner, step) = ((PI / f64::from(count)).cos(), TAU / f64::from(count));
            if count == 0 || r * ((phi - rotation).rem_euclid(step) - 0.5 * step).cos() <= inner {
                return 0.5 * self.world.view.aperture_m * r * DVec3::new(phi.cos(), phi.sin(), 0.0);
            }
        }
    }

    fn radiance(&self, mut o: DVec3, mut d: DVec3, rng: &mut Rng) -> DVec3 {
        let (mut light, mut share) = (DVec3::ZERO, DVec3::ONE);
        let mut media = self.media.clone();
        let mut bounces = 0;
        loop {
            let hit = nearest(&self.solids, o, d, NEAR);
            let Some(hit) = hit else {
                let seen = bounces > 0 || self.world.sky.as_ref().is_some_and(|sky| sky.visible);
                let sky = if seen { self.world.sky_radiance().as_dvec3() } else { DVec3::ZERO };
                return light + share * sky;
            };
            if let Some(medium) = self.ruling(&media) {
                share *= self.transmittance(medium, hit.t);
            }
            o = hit.p;
            let solid = &self.solids[hit.solid];
            let front = hit.ng.dot(d) < 0.0;
            light += share * self.matter.emitted(solid.material, -hit.ng.dot(d), solid.area);

            // The frame of the surface, z towards where the light goes.
            let side = if front { 1.0 } else { -1.0 };
            let outwards = if side * hit.ns.dot(d) < -1e-4 { hit.ns } else { hit.ng };
            let (lobe, factor) = self.matter.choose(solid.material, -side * outwards.dot(d), rng);
            if let Lobe::Nothing = lobe {
                continue;
            }
            let flat = hit.tangent - outwards * outwards.dot(hit.tangent);
            let tangent = flat.try_normalize().unwrap_or_else(|| outwards.any_orthonormal_vector());
            let (sin, cos) = self.matter.rotation(&lobe).sin_cos();
            let x = cos * tangent + sin * outwards.cross(tangent);
            let z = side * outwards;
            let y = z.cross(x);

            // Boundaries between media: Schmidt and Budge 2002.
            let (mut beyond, mut eta) = (media.clone(), 1.0);
            if let Some(medium) = self.matter.is_boundary(&lobe) {
                if front {
                    beyond.push(medium);
                } else if let Some(at) = beyond.iter().rposition(|m| *m == medium) {
                    beyond.remove(at);
                } else {
                    media.insert(0, medium);
                }
                let (before, after) = (self.ruling(&media), self.ruling(&beyond));
                if before == after {
                    media = beyond;
                    continue;
                }
                eta = self.ior(after) / self.ior(before);
            }
            if bounces >= self.world.render.max_bounces {
                return light;
            }
            bounces += 1;
            let wo = -DVec3::new(x.dot(d), y.dot(d), z.dot(d));
            let Some((wi, weight)) = self.matter.scatter(&lobe, wo, eta, rng) else { return light };
            share *= factor * weight;
            d = (wi.x * x + wi.y * y + wi.z * z).normalize();
            let crossed = d.dot(hit.ng) * side < 0.0;
            if crossed != (wi.z < 0.0) || share.max_element() <= 0.0 {
                return light;
            }
            if crossed {
                media = beyond;
            }
        }
    }

    /// Of the media at a point the one with the highest priority, of equals the one entered last.
    fn ruling(&self, media: &[usize]) -> Option<usize> {
        let priority = |m: &usize| match self.world.materials[*m].bsdf {
            Bsdf::Dielectric { priority, .. } => priority,
            _ => i32::MIN,
        };
        media.iter().max_by_key(|m| priority(m)).copied()
    }

    fn ior(&self, medium: Option<usize>) -> f64 {
        medium.and_then(|m| ior_of(&self.world.materials[m])).unwrap_or(1.0)
    }

    fn transmittance(&self, medium: usize, distance: f64) -> DVec3 {
        match self.world.materials[medium].bsdf {
            Bsdf::Dielectric { attenuation_color, attenuation_distance_m, .. }
                if attenuation_distance_m.is_finite() =>
            {
                attenuation_color.as_dvec3().powf(distance / attenuation_distance_m)
            }
            _ => DVec3::ONE,
        }
    }
}

/// What the camera lies in: the dielectrics that a ray from it leaves more often than it enters them.
fn media_around(world: &World, solids: &[Solid]) -> Vec<usize> {
    let o = world.view.world_from_camera.translation;
    let d = DVec3::new(0.36, 0.48, 0.8);
    let mut entered = vec![0; solids.len()];
    let mut media = Vec::new();
    let mut t = NEAR;
    while let Some(hit) = nearest(solids, o, d, t) {
        t = hit.t * (1.0 + NEAR);
        let material = solids[hit.solid].material;
        if ior_of(&world.materials[material]).is_none() {
            continue;
        }
        entered[hit.solid] += if hit.ng.dot(d) < 0.0 { 1 } else { -1 };
        if entered[hit.solid] < 0 {
            entered[hit.solid] = 0;
            media.insert(0, material);
        }
    }
    media
}

/// The generator of Steele, Lea and Flood's SplittableRandom.
pub struct Rng(u64);

impl Rng {
    /// Uniform in 0 ≤ u < 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A direction above z = 0 by its cosine: pdf cos / π.
    fn cosine(&mut self) -> DVec3 {
        let (u, phi) = (self.next(), TAU * self.next());
        DVec3::new(u.sqrt() * phi.cos(), u.sqrt() * phi.sin(), (1.0 - u).sqrt())
    }
}

/// n and k a channel: numbers that the renderer made of measurements, and tests where it makes them.
fn optical_constants(spectrum: Spectrum) -> (DVec3, DVec3) {
    match spectrum {
        Spectrum::Au => (DVec3::new(0.00214, 0.48899, 1.48329), DVec3::new(2.75110, 2.24024, 1.77995)),
        Spectrum::Cr => (DVec3::new(3.24042, 3.12093, 2.28677), DVec3::new(3.28535, 3.33721, 3.11732)),
        other => panic!("the judge does not know {other:?}"),
    }
}
