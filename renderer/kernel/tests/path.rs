//! Paths: weights of the techniques, and small scenes of planes whose light has a closed form.

mod common;

use std::f64::consts::PI;

use common::{Mean, compensated, diffuse, direction, flat, glass, glossy, measured, metal, placed, widths};
use glam::{DAffine3, DMat3, DVec3, UVec2, UVec4, Vec3, Vec4};
use kinora_kernel::generated::{
    COMPENSATE, DELTA_PDF, DIELECTRIC_THIN, DIFFUSE_EON, FAR, FEATURE_CUTOUT, LIGHT_PARALLELOGRAM, MATERIAL_EMITTER,
    NONE, PRIMITIVE_PARALLELOGRAM,
};
use kinora_kernel::query::{Bounds, build};
use kinora_kernel::{Kernel, Light, Material, Packed};

#[test]
fn weights_of_the_techniques_sum_to_one() {
    let densities = [1e-6_f32, 0.01, 0.3, 1.0, 7.0, 1e5];
    for chance in [-1.0, 0.0, 0.2, 0.5, 0.9, 1.0] {
        let mut packed = Packed::empty();
        packed.params.light_chance = chance;
        packed.with_kernel(|k| {
            for light in densities {
                for bsdf in densities {
                    let found = k.light_weight(light, bsdf);
                    // How often either is tried, times what it then counts.
                    let sum = if chance < 0.0 {
                        found + k.bsdf_weight(bsdf, light, false)
                    } else {
                        let (lit, unlit) = (k.bsdf_weight(bsdf, light, true), k.bsdf_weight(bsdf, light, false));
                        assert_eq!(lit, 0.0, "the coin fell for the light");
                        // Shares of the integrand in proportion to the densities.
                        chance * found + (1.0 - chance) * unlit
                    };
                    assert!((sum - 1.0).abs() < 1e-5, "{chance}: {sum} of {light} and {bsdf}");
                }
                // What no light sample finds counts in full, whatever the coin.
                for lit in [false, true] {
                    assert_eq!(k.bsdf_weight(DELTA_PDF, light, lit), 1.0);
                    assert_eq!(k.bsdf_weight(light, 0.0, lit), 1.0);
                }
                assert!((k.light_weight(light, 0.0) * chance.abs().max(1e-9) - 1.0).abs() < 1e-5 || chance == 0.0);
            }
            let share = k.bsdf_weight(1e30, 1e30, false);
            assert!(share.is_finite() && k.light_weight(1e30, 1e30).is_finite(), "{chance}");
        });
    }
}

/// Planes, and at most one lamp of one side, under a sky.
struct Scene(Packed);

impl Scene {
    /// Everything is lit by a sky of that radiance.
    fn new(sky: f32) -> Self {
        let mut packed = Packed::empty();
        packed.materials.clear();
        packed.shapes.clear();
        packed.params.sky = Vec3::splat(sky).extend(1.0);
        packed.params.max_bounces = 64;
        packed.params.roulette_from = 1000;
        packed.params.resolution = UVec2::ONE;
        Self(packed)
    }

    fn material(mut self, material: Material) -> Self {
        self.0.materials.push(material);
        self
    }

    /// The plane z = `height`, facing up or down.
    fn plane(mut self, height: f64, up: bool, material: u32) -> Self {
        let turn = if up { DMat3::IDENTITY } else { DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0)) };
        let place = DAffine3::from_mat3_translation(turn, DVec3::Z * height);
        let mut shape = placed(place);
        shape.index.x = material;
        self.0.shapes.push(shape);
        self.0.params.plane_count += 1;
        self
    }

    /// The unit square one above the origin, shining downwards with radiance 1.
    fn lamp(mut self) -> Self {
        let corner = Vec3::new(-0.5, -0.5, 1.0);
        let (u, v) = (Vec3::Y, Vec3::X);
        let shape = self.0.shapes.len() as u32;
        *self.0.primitives =
            vec![flat(PRIMITIVE_PARALLELOGRAM, shape, 0, [corner, corner + u, corner + u + v, corner + v])];
        let bounds = [Bounds { low: corner - 1e-5, high: corner + u + v + 1e-5 }];
        *self.0.tree = build(&mut self.0.primitives, &bounds, &self.0.shapes);
        let emitter = self.0.materials.len() as u32;
        self.0.materials.push(Material {
            color: Vec4::ONE,
            more: Vec4::W,
            kind: UVec4::new(MATERIAL_EMITTER, 0, NONE, NONE),
            ..Material::default()
        });
        let mut lamp = placed(DAffine3::IDENTITY);
        lamp.index = UVec4::new(emitter, 0, emitter, 0);
        self.0.shapes.push(lamp);
        *self.0.lights = vec![Light {
            origin: corner.extend(0.0),
            edge_u: u.extend(1.0),
            edge_v: v.extend(emitter as f32),
            normal: u.cross(v).extend(1.0),
            kind: UVec4::new(LIGHT_PARALLELOGRAM, shape, 0, 0),
        }];
        self.0.params.light_count = 1;
        self.0.params.primitive_count = 1;
        self
    }

    /// Seen from `eye` along `d`, by every ray.
    fn seen(mut self, eye: Vec3, d: Vec3) -> Self {
        let z = -d.normalize();
        let x = z.any_orthonormal_vector();
        let p = &mut self.0.params;
        (p.camera_x, p.camera_y, p.camera_z) = (x.extend(0.0), z.cross(x).extend(0.0), z.extend(0.0));
        p.camera_eye = eye.extend(0.0);
        p.camera_film = Vec4::new(1e-6, 1e-6, 1.0, 0.0);
        self
    }

    fn with(mut self, f: impl FnOnce(&mut Packed)) -> Self {
        f(&mut self.0);
        self
    }

    fn mean(&self, samples: u32) -> Mean {
        self.0.with_kernel(|k| {
            let mut mean = Mean::default();
            for i in 0..samples {
                let light = k.radiance(UVec2::ZERO, i);
                assert!(light.w >= 1.0, "no ray");
                mean.add(light.x.into());
            }
            mean
        })
    }

    #[track_caller]
    fn check(&self, name: &str, samples: u32, want: f64, tolerance: f64) {
        let mean = self.mean(samples);
        assert!((mean.mean() - want).abs() <= tolerance, "{name}: {} ± {}, not {want}", mean.mean(), mean.error());
    }
}

fn black(opacity: f32) -> Material {
    Material { more: Vec4::new(0.0, 0.0, 0.0, opacity), ..diffuse(0.0, 0.0, DIFFUSE_EON) }
}

fn cutouts(opacities: &[f32]) -> Scene {
    let mut scene = Scene::new(1.0).with(|p| p.params.features |= FEATURE_CUTOUT);
    for (i, &opacity) in opacities.iter().enumerate() {
        scene = scene.material(black(opacity)).plane(-(i as f64) - 1.0, true, i as u32);
    }
    scene.seen(Vec3::ZERO, Vec3::new(0.3, 0.1, -1.0))
}

#[test]
fn opacity_is_the_share_of_rays_that_meet() {
    for opacities in [&[0.3_f32][..], &[0.0], &[1.0], &[0.5, 0.25], &[0.1, 0.9, 0.4]] {
        let want: f64 = opacities.iter().map(|o| 1.0 - f64::from(*o)).product();
        cutouts(opacities).check(&format!("{opacities:?}"), 1 << 14, want, 0.012);
        let scene = cutouts(opacities);
        scene.0.with_kernel(|k| {
            let d = Vec3::new(0.3, 0.1, -1.0).normalize();
            let share = k.shadow_share(Vec3::ZERO, d, 1e4, NONE);
            assert!((f64::from(share) - want).abs() < 1e-6, "{opacities:?}: a shadow ray keeps {share}");
            // Only what lies before the light counts.
            assert_eq!(k.shadow_share(Vec3::ZERO, d, 0.9, NONE), 1.0);
        });
    }
}

#[test]
fn cutouts_do_not_count_as_bounces() {
    cutouts(&[0.0; 20]).with(|p| p.params.max_bounces = 0).check("twenty holes", 4, 1.0, 0.0);
}

#[test]
fn a_lambertian_floor_sends_back_its_colour() {
    let floor = |bounces| {
        Scene::new(2.0)
            .material(diffuse(0.7, 0.0, DIFFUSE_EON))
            .plane(0.0, true, 0)
            .seen(Vec3::new(0.2, 0.1, 1.0), Vec3::new(0.2, 0.5, -0.4))
            .with(|p| p.params.max_bounces = bounces)
    };
    floor(1).check("one bounce", 64, 1.4, 1e-5);
    floor(0).check("none", 64, 0.0, 0.0);
    // From below too: both sides reflect.
    floor(1).seen(Vec3::new(0.0, 0.0, -1.0), Vec3::new(0.1, 0.0, 1.0)).check("from below", 64, 1.4, 1e-5);
    floor(1).with(|p| p.params.sky.w = 0.0).check("a sky that the camera does not see", 64, 1.4, 1e-5);
}

#[test]
fn between_two_walls_light_decays_by_bounces() {
    // Between planes that shine with 1 and reflect ρ, by so many bounces.
    for (bounces, roulette) in [(0, 1000), (1, 1000), (5, 1000), (60, 2)] {
        let rho = 0.5;
        let mut emitter = diffuse(rho, 0.0, DIFFUSE_EON);
        emitter.more.w = 1.0;
        let scene = Scene::new(0.0)
            .material(emitter)
            .material(Material {
                color: Vec4::ONE,
                kind: UVec4::new(MATERIAL_EMITTER, 0, NONE, NONE),
                ..Material::default()
            })
            .plane(0.0, true, 0)
            .plane(3.0, false, 0)
            .seen(Vec3::Z, Vec3::new(0.3, 0.2, -1.0))
            .with(|p| {
                for shape in p.shapes.iter_mut() {
                    shape.index.z = 1;
                }
                p.params.max_bounces = bounces;
                p.params.roulette_from = roulette;
            });
        let want = (1.0 - f64::from(rho).powi(bounces as i32 + 1)) / (1.0 - f64::from(rho));
        scene.check(&format!("{bounces} bounces"), 20_000, want, if roulette < 1000 { 0.03 } else { 1e-4 });
    }
}

const FLAT: Vec3 = Vec3::new(0.6, 0.0, -0.8);

/// A slab of material 0 between z = −`thickness` and 0.
fn slab(material: Material, thickness: f64, sky: f32) -> Scene {
    Scene::new(sky).material(material).plane(0.0, true, 0).plane(-thickness, false, 0).seen(Vec3::Z, FLAT)
}

#[test]
fn clear_slabs_are_invisible() {
    for ior in [1.0, 1.05, 1.5, 2.5] {
        slab(glass(ior, 0.0, 0), 0.3, 1.0).check(&format!("ior {ior}"), 256, 1.0, 1e-4);
        let sheet = glass(ior, 0.0, DIELECTRIC_THIN);
        slab(sheet, 0.3, 1.0).check(&format!("two sheets of {ior}"), 256, 1.0, 1e-4);
    }
    // Without a path that lives on: roulette takes some, others carry more.
    let scene = slab(glass(1.5, 0.0, 0), 0.3, 1.0).with(|p| p.params.roulette_from = 1);
    scene.check("with roulette", 4096, 1.0, 1e-3);
}

#[test]
fn rough_slabs_are_nearly_invisible() {
    for (ior, roughness) in [(1.5, 0.3), (1.5, 0.7), (1.33, 1.0), (2.1, 0.5)] {
        let scene = slab(glass(ior, roughness, COMPENSATE), 0.3, 1.0).with(|p| {
            p.params.max_bounces = 400;
            p.params.roulette_from = 100;
        });
        let mean = scene.mean(30_000);
        let name = format!("ior {ior}, roughness {roughness}: {} ± {}", mean.mean(), mean.error());
        println!("{name}");
        assert!((mean.mean() - 1.0).abs() < 0.01 + 3.0 * mean.error() && mean.error() < 0.006, "{name}");
    }
}

#[test]
fn absorbing_slabs_have_a_closed_form() {
    let ior = 1.5;
    for (thickness, absorption) in [(0.2, 1.0), (1.0, 0.7), (0.5, 4.0)] {
        let mut material = glass(ior as f32, 0.0, 0);
        material.extra.x = absorption as f32;
        let (sin, cos) = (0.6_f64, 0.8_f64);
        let inner = (1.0 - (sin / ior).powi(2)).sqrt();
        let (rs, rp) = ((cos - ior * inner) / (cos + ior * inner), (ior * cos - inner) / (ior * cos + inner));
        let r = 0.5 * (rs * rs + rp * rp);
        let t = (-absorption * thickness / inner).exp();
        let through = (1.0 - r).powi(2) * t / (1.0 - (r * t).powi(2));
        let back = r + r * (1.0 - r).powi(2) * t * t / (1.0 - (r * t).powi(2));
        let scene = slab(material, thickness, 1.0);
        scene.check(&format!("{thickness} m of {absorption} a metre"), 1 << 14, through + back, 2e-3);
    }
}

#[test]
fn the_camera_may_be_in_a_medium() {
    let mut material = glass(1.5, 0.0, 0);
    material.extra.x = 0.8;
    // Up from half a metre below the surface: the first way out, and nothing comes back from below.
    let scene = |media| {
        Scene::new(1.0)
            .material(material)
            .plane(0.0, true, 0)
            .seen(-0.5 * Vec3::Z, Vec3::Z)
            .with(|p| p.params.media = UVec4::new(media, NONE, NONE, NONE))
    };
    let t = (-0.4_f64).exp();
    // Radiance is squeezed on the way in: η² times as much is in there.
    let want = t * 0.96 * 2.25;
    scene(0).check("in it", 1 << 14, want, 5e-3);
    // A camera that is not told is in air until it has left what it never entered.
    scene(NONE).check("not told", 1 << 14, 0.96 * 2.25 + 0.04 * 0.0, 0.05);
}

#[test]
fn estimators_have_one_mean() {
    // E / L of the unit square one above, in a diffuse floor; others by agreement.
    let lambert = 0.752_274_688_5 / PI * 0.6;
    let gold = measured(Vec3::new(0.143, 0.375, 1.442), Vec3::new(3.983, 2.386, 1.603), widths(0.5, 0.4));
    let floors: [(&str, Vec<Material>, Option<f64>); 5] = [
        ("Lambert", vec![diffuse(0.6, 0.0, DIFFUSE_EON)], Some(lambert)),
        ("rough diffuse", vec![diffuse(0.6, 0.8, DIFFUSE_EON)], None),
        ("gold", vec![compensated(gold)], None),
        ("glossy", vec![glossy(1.5, 0.4, 1), diffuse(0.6, 0.0, DIFFUSE_EON)], None),
        ("smooth coat", vec![glossy(1.5, 0.0, 1), diffuse(0.6, 0.0, DIFFUSE_EON)], None),
    ];
    for (name, materials, want) in floors {
        let means = [-1.0_f32, 0.2, 0.0, 1.0].map(|chance| {
            let mut scene = Scene::new(0.0);
            for m in &materials {
                scene = scene.material(*m);
            }
            let scene =
                scene.plane(0.0, true, 0).lamp().seen(Vec3::new(-1.5, 0.0, 1.2), Vec3::new(1.5, 0.0, -1.2)).with(|p| {
                    p.params.light_chance = chance;
                    p.params.max_bounces = 1;
                });
            scene.mean(1 << 15)
        });
        for (mean, mode) in means.iter().zip(["nee", "one_sample", "bsdf", "light"]) {
            let want = want.unwrap_or(means[0].mean());
            let slack = 4.5 * (mean.error().powi(2) + means[0].error().powi(2)).sqrt() + 1e-5;
            assert!(mean.error() < 0.05 * want, "{name}, {mode}: an error of {} proves nothing", mean.error());
            assert!(
                (mean.mean() - want).abs() < slack,
                "{name}, {mode}: {} ± {}, not {want}",
                mean.mean(),
                mean.error()
            );
        }
    }
}

#[test]
fn a_tangent_turns_counter_clockwise() {
    Packed::empty().with_kernel(|k: &Kernel<'_>| {
        for angle in [0.0_f32, 0.5, 1.57, -2.0] {
            let turn = glam::Vec2::from_angle(angle);
            let frame = k.frame_along(Vec3::Z, Vec3::new(3.0, 0.0, 0.7), turn);
            assert!((frame.x - turn.extend(0.0)).length() < 1e-6, "{angle}: {}", frame.x);
            assert!((frame.x.cross(frame.y) - frame.z).length() < 1e-6, "right-handed");
        }
        let n = direction(0.4, 1.0);
        let none = k.frame_along(n, Vec3::ZERO, glam::Vec2::X);
        assert!((none.x.cross(none.y) - n).length() < 1e-5, "without a tangent any frame does");
    });
}

#[test]
fn a_clamp_bounds_what_one_path_brings() {
    let floor = |clamp| {
        Scene::new(1.0)
            .material(metal(Vec3::splat(0.9), Vec3::ONE, widths(0.0, 0.0)))
            .plane(0.0, true, 0)
            .seen(Vec3::Z, FLAT)
            .with(|p| p.params.clamp = clamp)
    };
    floor(0.25).check("clamped", 16, 0.25, 1e-6);
    let fresnel = 0.9 + 0.1 * 0.2_f64.powi(5);
    floor(FAR).check("not clamped", 16, fresnel, 1e-5);
}
