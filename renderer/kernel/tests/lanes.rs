//! Shading on lanes against the scalar translation, bit by bit: paths of every state over scenes of every material and
//! light, the lanes' states unlike each other.
#![cfg(target_arch = "x86_64")]
// The call of what the CPU was seen to have.
#![allow(unsafe_code)]

mod common;

use common::{Random, compensated, diffuse, flat, glass, glossy, measured, metal, placed, round, widths};
use glam::{DAffine3, UVec2, UVec4, Vec2, Vec3, Vec4};
use kinora_kernel::generated::{
    CHOICE, COMPENSATE, DELTA_PDF, DIELECTRIC_THIN, EMITTER_TWO_SIDED, FAR, FEATURE_BLADES, FEATURE_CUTOUT,
    FEATURE_FISHEYE, FEATURE_ORTHOGRAPHIC, FEATURE_PANORAMA, Hit, MATERIAL_EMITTER, MATERIAL_MIX, NONE, PLANE_BIT,
    PRIMITIVE_PARALLELOGRAM, PRIMITIVE_TRIANGLE, Parts, Path,
};
use kinora_kernel::lanes::{Width, eight, sixteen};
use kinora_kernel::{Kernel, Light, Material, Packed};

const SHAPES: u32 = 8;
const PRIMITIVES: u32 = 24;

fn emitter(r: &mut Random, next: u32) -> Material {
    Material {
        color: r.cube(4.0).abs().extend(0.0),
        more: Vec4::W,
        kind: UVec4::new(MATERIAL_EMITTER, EMITTER_TWO_SIDED * (r.bits() as u32 % 2), NONE, next),
        ..Material::default()
    }
}

fn materials(r: &mut Random) -> Vec<Material> {
    let lobe = |r: &mut Random| widths([0.0, 0.05, 0.3, 1.0][r.bits() as usize % 4], [0.0, 0.7][r.bits() as usize % 2]);
    let mut list = Vec::new();
    for model in 0..3 {
        list.push(diffuse(r.unit(), [0.0, 0.5, 1.0][r.bits() as usize % 3], model));
    }
    let (color, rough) = (r.cube(1.0).abs(), lobe(r));
    list.push(metal(color, Vec3::splat(0.7), rough));
    list.push(measured(Vec3::new(0.2, 0.9, 1.3), Vec3::new(3.9, 2.4, 1.7), rough));
    list.push(compensated(metal(color, Vec3::ONE, widths(0.6, 0.0))));
    list.push(glass(1.5, 0.0, 0));
    list.push(glass(1.3, r.unit(), COMPENSATE));
    list.push(glass(1.5, 0.0, DIELECTRIC_THIN));
    list.push(glossy(1.5, 0.2, 0));
    list.push(glossy(1.5, 0.0, 1));
    list.push(Material {
        lobe: Vec4::X * r.unit(),
        more: Vec4::W,
        kind: UVec4::new(MATERIAL_MIX, CHOICE, 0, 3),
        ..Material::default()
    });
    list.push(emitter(r, NONE));
    list.push(emitter(r, 12));
    for material in &mut list {
        if r.unit() < 0.2 {
            material.more.w = r.unit();
        }
    }
    list
}

fn light(r: &mut Random, i: u32, count: u32) -> Light {
    let (u, v) = (r.cube(1.0), r.cube(1.0));
    let normal = u.cross(v).normalize_or_zero();
    let chance = 1.0 / count as f32;
    Light {
        origin: r.cube(3.0).extend(i as f32 * chance),
        edge_u: u.extend(chance),
        edge_v: v.extend((12 + i % 2) as f32),
        normal: normal.extend(1.0 / u.cross(v).length()),
        kind: UVec4::new(i % 5, r.bits() as u32 % SHAPES, 0, 0),
    }
}

fn scene(r: &mut Random) -> Packed {
    let mut packed = Packed { materials: materials(r).into(), ..Packed::empty() };
    let count = packed.materials.len() as u32;
    packed.shapes.clear();
    for i in 0..SHAPES {
        let place = DAffine3::from_translation(r.cube(2.0).as_dvec3());
        let turn = DAffine3::from_rotation_y(f64::from(r.unit()));
        let mut shape = placed(place * turn);
        let lamp = if r.unit() < 0.4 { 12 + r.bits() as u32 % 2 } else { NONE };
        shape.index = UVec4::new(r.bits() as u32 % count, if lamp == NONE { NONE } else { i % 5 }, lamp, 0);
        packed.shapes.push(shape);
    }
    packed.primitives.clear();
    for i in 0..PRIMITIVES {
        let shape = r.bits() as u32 % SHAPES;
        let (a, b, c) = (r.cube(2.0), r.cube(2.0), r.cube(2.0));
        packed.primitives.push(match i % 3 {
            0 => round(shape),
            1 => flat(PRIMITIVE_PARALLELOGRAM, shape, i % 4, [a, b, b + c - a, c]),
            _ => flat(PRIMITIVE_TRIANGLE, shape, i % 4, [a, b, c, a]),
        });
        if i % 6 == 2 {
            packed.primitives[i as usize].shade += UVec4::new(r.bits() as u32, r.bits() as u32, r.bits() as u32, 0);
        }
    }
    *packed.lights = (0..5).map(|i| light(r, i, 5)).collect();
    let params = &mut packed.params;
    (params.resolution, params.window) = (UVec2::splat(64), UVec4::new(0, 0, 64, 64));
    params.camera_x = Vec4::X;
    params.camera_y = Vec4::Y;
    params.camera_z = Vec4::Z;
    params.camera_eye = Vec4::new(0.0, 0.5, 4.0, [0.0, 0.2][r.bits() as usize % 2]);
    params.camera_film = Vec4::new(0.5, 0.5, 3.0, 0.0);
    params.sky = r.cube(1.0).abs().extend(r.bits() as u32 as f32 % 2.0);
    params.seed = r.bits() as u32;
    params.sampler = r.bits() as u32 % 2;
    params.max_bounces = 6;
    params.roulette_from = r.bits() as u32 % 5;
    params.light_count = [0, 5][usize::from(r.unit() < 0.8)];
    params.plane_count = 2;
    params.primitive_count = PRIMITIVES;
    params.features = [0, FEATURE_CUTOUT][r.bits() as usize % 2];
    // A fisheye has pixels without a path.
    params.features |=
        [0, FEATURE_BLADES, FEATURE_ORTHOGRAPHIC, FEATURE_PANORAMA, FEATURE_FISHEYE][r.bits() as usize % 5];
    (params.camera_x.w, params.camera_y.w, params.camera_z.w) = (5.0, 0.1, 0.3);
    params.light_chance = [-1.0, 0.3, 1.0][r.bits() as usize % 3];
    params.clamp = [f32::MAX, 2.0][r.bits() as usize % 2];
    packed
}

fn hit(r: &mut Random) -> Hit {
    let id = match r.bits() % 8 {
        0 => NONE,
        1 => PLANE_BIT | (r.bits() as u32 % 2),
        _ => r.bits() as u32 % PRIMITIVES,
    };
    let u = r.square();
    Hit {
        t: if id == NONE { FAR } else { r.within(0.01, 5.0) },
        id,
        uv: Vec2::new(u.x, u.y * (1.0 - u.x)),
        instance: NONE,
    }
}

/// A path as it may be anywhere on its way.
fn path(kernel: &Kernel<'_>, r: &mut Random) -> Path {
    let pixel = UVec2::new(r.bits() as u32 % 64, r.bits() as u32 % 64);
    let mut path = kernel.path_start(pixel, r.bits() as u32 % 64);
    if r.unit() < 0.6 {
        path.o = r.cube(2.0);
        path.d = r.direction();
        path.vertex = r.cube(2.0);
        path.beta = r.cube(1.0).abs();
        path.pdf = if r.unit() < 0.3 { DELTA_PDF } else { r.unit() };
        path.lit = r.unit() < 0.5;
        path.bounce = r.bits() as u32 % 8;
        path.passes = r.bits() as u32 % 3;
        path.media = UVec4::new([NONE, 6, 7][r.bits() as usize % 3], NONE, NONE, NONE);
        // What is no number has to come out as none.
        if r.unit() < 0.02 {
            path.beta.y = [f32::NAN, f32::INFINITY][r.bits() as usize % 2];
        }
    }
    path
}

/// One step of some paths: what they become and the light that they brought then, whole and in parts, by `Debug`, which
/// tells all bits apart but those of what is no number.
type Steps = Vec<(String, String)>;

fn scalar(kernel: &Kernel<'_>, paths: &[Path], hits: &[Hit], shares: &[f32]) -> Steps {
    let step = |k: usize| {
        let (mut path, mut parted, mut parts) = (paths[k], paths[k], Parts::default());
        kernel.path_shade(&mut path, hits[k]);
        kernel.parts_shade(&mut parts, &mut parted, hits[k]);
        if path.shadow_t > 0.0 {
            kernel.path_shadow(&mut path, shares[k]);
            kernel.parts_shadow(&mut parts, &mut parted, shares[k]);
        }
        let light = (kernel.path_light(path), kernel.parts_end(parts, parted));
        (format!("{path:?}"), format!("{light:?}"))
    };
    (0..paths.len()).map(step).collect()
}

macro_rules! on_lanes {
    ($name:ident, $module:ident, $features:literal) => {
        #[target_feature(enable = $features)]
        fn $name(kernel: &Kernel<'_>, active: u32, paths: &[Path], hits: &[Hit], shares: &[f32]) -> Steps {
            use $module::{HitLanes, Lanes, PartsLanes, PathLanes, w};
            let (lanes, active) = (Lanes(kernel), w::M::from_bits(active));
            let (mut path, mut parted) = (PathLanes::gather(|k| paths[k]), PathLanes::gather(|k| paths[k]));
            let mut parts = PartsLanes::splat(Parts::default());
            lanes.path_shade(active, &mut path, HitLanes::gather(|k| hits[k]));
            lanes.parts_shade(active, &mut parts, &mut parted, HitLanes::gather(|k| hits[k]));
            let asks = active.and(path.shadow_t.gt(w::F::splat(0.0)));
            lanes.path_shadow(asks, &mut path, w::F::gather(|k| shares[k]));
            lanes.parts_shadow(asks, &mut parts, &mut parted, w::F::gather(|k| shares[k]));
            let (light, parts) = (lanes.path_light(active, path), lanes.parts_end(active, parts, parted));
            let step = |k: usize| (format!("{:?}", path.get(k)), format!("{:?}", (light.get(k), parts.get(k))));
            (0..w::LANES).map(step).collect()
        }
    };
}
on_lanes!(on_eight, eight, "avx2,bmi1,bmi2,lzcnt,popcnt");
on_lanes!(on_sixteen, sixteen, "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt");

/// Steps of the lanes whose bits are set.
type Run = dyn Fn(&Kernel<'_>, u32, &[Path], &[Hit], &[f32]) -> Steps;

fn check(count: usize, run: &Run) {
    for seed in 0..60 {
        let mut r = Random(seed);
        let packed = scene(&mut r);
        packed.with_kernel(|kernel| {
            for turn in 0..40 {
                let paths: Vec<_> = (0..count).map(|_| path(kernel, &mut r)).collect();
                let hits: Vec<_> = (0..count).map(|_| hit(&mut r)).collect();
                let shares: Vec<_> = (0..count).map(|_| r.unit()).collect();
                let active = if turn % 2 == 0 { u32::MAX } else { r.bits() as u32 } & ((1 << count) - 1);
                let expected = scalar(kernel, &paths, &hits, &shares);
                let found = run(kernel, active, &paths, &hits, &shares);
                for k in 0..count {
                    if active >> k & 1 == 1 {
                        assert_eq!(found[k], expected[k], "scene {seed}, lane {k}: {:?} {:?}", paths[k], hits[k]);
                    } else {
                        assert_eq!(found[k].0, format!("{:?}", paths[k]), "scene {seed}: a lane that did not ask");
                    }
                }
            }
        });
    }
}

#[test]
fn eight_lanes_shade_as_one() {
    if Width::Eight.is_here() {
        // SAFETY: the CPU has them.
        check(8, &|kernel, active, paths, hits, shares| unsafe { on_eight(kernel, active, paths, hits, shares) });
    }
}

#[test]
fn sixteen_lanes_shade_as_one() {
    if Width::Sixteen.is_here() {
        // SAFETY: the CPU has them.
        check(16, &|kernel, active, paths, hits, shares| unsafe { on_sixteen(kernel, active, paths, hits, shares) });
    }
}
