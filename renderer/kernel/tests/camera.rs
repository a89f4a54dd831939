//! The camera, the filter, and the maps from the square.

mod common;

use std::f64::consts::PI;

use common::{Random, SphereBins, check_counts, check_rejects};
use glam::{Mat3, UVec2, Vec2, Vec3, Vec4};
use kinora_kernel::Packed;
use kinora_kernel::generated::{DIM_LENS, FEATURE_BLADES, FILTER_CELLS};

#[test]
fn the_square_fills_the_disc_evenly() {
    const RINGS: usize = 24;
    const SECTORS: usize = 32;
    const COUNT: usize = 1_000_000;
    Packed::empty().with_kernel(|k| {
        let mut random = Random(1);
        let mut observed = vec![0.0; RINGS * SECTORS];
        for _ in 0..COUNT {
            let p = k.square_to_disc(random.square());
            assert!(p.length() <= 1.0 + 1e-6, "{p}");
            let turn = f64::from(p.y).atan2(f64::from(p.x)) / (2.0 * PI);
            let ring = ((f64::from(p.length_squared()) * RINGS as f64) as usize).min(RINGS - 1);
            let sector = (((turn - turn.floor()) * SECTORS as f64) as usize).min(SECTORS - 1);
            observed[ring * SECTORS + sector] += 1.0;
        }
        let expected = vec![COUNT as f64 / (RINGS * SECTORS) as f64; RINGS * SECTORS];
        check_counts("disc", 2, &observed, &expected);
        check_rejects("disc", 2, &observed, &expected);
        assert_eq!(k.square_to_disc(Vec2::splat(0.5)), Vec2::ZERO);
        for (u, want) in [
            ((1.0, 0.5), (1.0, 0.0)),
            ((0.0, 0.5), (-1.0, 0.0)),
            ((0.5, 1.0), (0.0, 1.0)),
            ((0.5, 0.0), (0.0, -1.0)),
            ((1.0, 1.0), (0.5_f32.sqrt(), 0.5_f32.sqrt())),
        ] {
            let (u, want) = (Vec2::from(u), Vec2::from(want));
            assert!((k.square_to_disc(u) - want).length() < 1e-6, "{u} goes to {}", k.square_to_disc(u));
        }
        // Neighbours stay neighbours: the map is continuous.
        for _ in 0..100_000 {
            let u = random.square() * 0.999;
            let apart = k.square_to_disc(u + Vec2::splat(1e-4)) - k.square_to_disc(u);
            assert!(apart.length() < 1e-3, "torn at {u}");
        }
    });
}

#[test]
fn the_cosine_is_the_density() {
    Packed::empty().with_kernel(|k| {
        let mut random = Random(2);
        let bins = SphereBins { z_low: 0.0, rows: 24, columns: 32, jumps: false, off: 0.0 };
        let draw = || {
            let d = k.square_to_cosine(random.square());
            assert!((d.length() - 1.0).abs() < 1e-5 && d.z > 0.0, "{d}");
            Some(d)
        };
        let (observed, expected) = bins.check("cosine", 2, 1_000_000, draw, |d| f64::from(d.z) / PI);
        check_rejects("cosine", 2, &observed, &expected);
    });
}

/// A camera somewhere, 64 by 32 pixels, whose filter knows one offset only.
fn camera(lens_radius: f32, focus: f32, offset: f32) -> Packed {
    let axes = Mat3::from_euler(glam::EulerRot::XYZ, 0.3, -1.2, 0.5);
    let mut packed = Packed::empty();
    packed.params.camera_x = axes.x_axis.extend(0.0);
    packed.params.camera_y = axes.y_axis.extend(0.0);
    packed.params.camera_z = axes.z_axis.extend(0.0);
    packed.params.camera_eye = Vec4::new(1.0, 2.0, 3.0, lens_radius);
    packed.params.camera_film = Vec4::new(1.0, 0.5, focus, 0.0);
    packed.params.resolution = UVec2::new(64, 32);
    *packed.tables = vec![offset; FILTER_CELLS as usize + 1];
    packed
}

fn in_camera(packed: &Packed, v: Vec3) -> Vec3 {
    let p = &packed.params;
    Vec3::new(v.dot(p.camera_x.truncate()), v.dot(p.camera_y.truncate()), v.dot(p.camera_z.truncate()))
}

#[test]
fn the_camera_looks_along_minus_z_with_y_up() {
    for (x, y, offset, want) in [
        (32, 16, -0.5, [0.0, 0.0]),
        (0, 0, -0.5, [-1.0, 0.5]),
        (63, 31, 0.5, [1.0, -0.5]),
        (63, 0, 0.0, [1.0 - 1.0 / 64.0, 0.5 - 0.5 / 32.0]),
        (32, 16, 0.0, [1.0 / 64.0, -0.5 / 32.0]),
        (48, 24, -0.5, [0.5, -0.25]),
    ] {
        let packed = camera(0.0, 7.0, offset);
        packed.with_kernel(|k| {
            let pixel = UVec2::new(x, y);
            let ray = k.camera_ray(pixel, k.sample_key(pixel, 3));
            assert_eq!(ray.o, Vec3::new(1.0, 2.0, 3.0), "a pinhole");
            assert!((ray.d.length() - 1.0).abs() < 1e-6);
            let d = in_camera(&packed, ray.d);
            assert!(d.z < 0.0, "pixel {pixel} looks back");
            let got = d / -d.z;
            let off = (got - Vec3::new(want[0], want[1], -1.0)).length();
            assert!(off < 1e-5, "pixel {pixel}, {offset} off its centre, looks along {got}, not {want:?}");
        });
    }
}

#[test]
fn samples_stay_in_their_filter() {
    let mut packed = camera(0.0, 7.0, 0.0);
    *packed.tables = (0..=FILTER_CELLS).map(|i| i as f32 / FILTER_CELLS as f32 - 0.5).collect();
    packed.with_kernel(|k| {
        const CELLS: usize = 16;
        const COUNT: u32 = 65536;
        let pixel = UVec2::new(5, 9);
        let mut seen = vec![0.0; CELLS * CELLS];
        for sample in 0..COUNT {
            let d = in_camera(&packed, k.camera_ray(pixel, k.sample_key(pixel, sample)).d);
            let at = Vec2::new((d.x / -d.z + 1.0) * 32.0 - 5.0, (1.0 - 2.0 * d.y / -d.z) * 16.0 - 9.0);
            assert!(at.min_element() > -1e-4 && at.max_element() < 1.0 + 1e-4, "{at} is outside of the pixel");
            let cell = (at * CELLS as f32).clamp(Vec2::ZERO, Vec2::splat(CELLS as f32 - 1.0)).as_usizevec2();
            seen[cell.y * CELLS + cell.x] += 1.0;
        }
        let expected = vec![f64::from(COUNT) / (CELLS * CELLS) as f64; CELLS * CELLS];
        check_counts("pixel", 1, &seen, &expected);
    });
}

#[test]
fn all_of_the_lens_looks_at_the_focus() {
    let (radius, focus) = (0.3, 4.0);
    let packed = camera(radius, focus, 0.25);
    packed.with_kernel(|k| {
        let mut random = Random(3);
        let eye = Vec3::new(1.0, 2.0, 3.0);
        let mut outer = 0;
        const COUNT: u32 = 20_000;
        for sample in 0..COUNT {
            let pixel = UVec2::new((random.bits() % 64) as u32, (random.bits() % 32) as u32);
            let at = Vec2::new(
                2.0 * (pixel.x as f32 + 0.75) / 64.0 - 1.0,
                -0.5 * (2.0 * (pixel.y as f32 + 0.75) / 32.0 - 1.0),
            );
            let key = k.sample_key(pixel, sample);
            let ray = k.camera_ray(pixel, key);
            let o = in_camera(&packed, ray.o - eye);
            let d = in_camera(&packed, ray.d);
            assert!(o.z.abs() < 1e-6 && o.length() <= radius + 1e-6, "{o} is not on the lens");
            let lens = radius * k.square_to_disc(k.random_2d(key, DIM_LENS));
            assert!((o.truncate() - lens).length() < 1e-5, "{o} is not {lens}");
            outer += u32::from(o.length() > radius * 0.5_f32.sqrt());
            let seen = o + d * ((-focus - o.z) / d.z);
            assert!((seen - (at * focus).extend(-focus)).length() < 1e-4, "{seen} is not {at} at the focus");
            assert!((ray.d.length() - 1.0).abs() < 1e-6 && d.z < 0.0);
        }
        assert!((f64::from(outer) / f64::from(COUNT) - 0.5).abs() < 0.02, "{outer} in the outer half of the lens");
    });
}

/// The polygon's triangles about its middle are filled evenly, and nothing else is.
#[test]
fn a_lens_with_corners_is_filled_evenly() {
    const RINGS: usize = 8;
    const COUNT: usize = 400_000;
    for (corners, turn) in [(3, 0.0), (5, 0.13), (6, 0.0), (11, 0.9)] {
        let mut packed = Packed::empty();
        packed.params.features = FEATURE_BLADES;
        (packed.params.camera_x.w, packed.params.camera_y.w) = (corners as f32, turn);
        packed.with_kernel(|k| {
            let mut random = Random(5);
            // By triangle, by ring between similar polygons, by half of the edge.
            let mut observed = vec![0.0; corners * RINGS * 2];
            for _ in 0..COUNT {
                let p = k.lens_point(random.square());
                let (radius, angle) = (f64::from(p.length()), f64::from(p.y).atan2(f64::from(p.x)) / (2.0 * PI));
                let along = (angle - f64::from(turn)).rem_euclid(1.0) * corners as f64;
                let from_middle = (along.fract() - 0.5) * 2.0 * PI / corners as f64;
                let reach = radius * from_middle.cos() / (PI / corners as f64).cos();
                assert!(reach < 1.0 + 1e-5, "{p} is outside of {corners} corners turned by {turn}");
                let ring = ((reach * reach * RINGS as f64) as usize).min(RINGS - 1);
                let triangle = (along as usize).min(corners - 1);
                observed[(triangle * RINGS + ring) * 2 + usize::from(from_middle > 0.0)] += 1.0;
            }
            let expected = vec![COUNT as f64 / observed.len() as f64; observed.len()];
            check_counts("a lens with corners", 4, &observed, &expected);
        });
    }
}

#[test]
fn the_filter_is_its_table() {
    let mut packed = Packed::empty();
    *packed.tables = (0..=FILTER_CELLS).map(|i| (i as f32 / 128.0 - 1.0).powi(3)).collect();
    packed.with_kernel(|k| {
        assert_eq!(k.filter_offset(0.0), -1.0);
        assert_eq!(k.filter_offset(0.5), 0.0);
        assert!((k.filter_offset(1.0_f32.next_down()) - 1.0).abs() < 1e-5);
        assert_eq!(k.filter_offset(1.0), 1.0);
        let mut before = -1.0;
        for i in 0..=100_000 {
            let u = i as f32 / 100_000.0;
            let x = k.filter_offset(u);
            assert!(x >= before, "falls at {u}");
            assert!((x - (2.0 * u - 1.0).powi(3)).abs() < 1e-4, "{x} at {u}");
            before = x;
        }
    });
}
