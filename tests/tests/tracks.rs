//! What a scene says over time, from text to numbers, against closed forms.

use glam::{DQuat, DVec3};
use kinora_scene::{Bsdf, Instance, Shape, World};
use kinora_tests::world_at;

/// A scene of a thousand frames a second at a frame.
fn at(text: &str, millisecond: i64) -> World {
    let text =
        format!("lang 1\nrender {{ fps: 1000 }}\ncamera {{ position: (0, 0, 9) }}\nsky {{ color: #fff }}\n{text}");
    world_at(&text, &Default::default(), millisecond)
}

fn shapes(text: &str, millisecond: i64) -> Vec<Instance> {
    at(text, millisecond).instances
}

/// Where the shapes of a scene are.
fn places(text: &str, millisecond: i64) -> Vec<DVec3> {
    shapes(text, millisecond).iter().map(|shape| shape.world_from_object.translation).collect()
}

/// Where the first shape is, as a number along x.
fn x(text: &str, millisecond: i64) -> f64 {
    places(text, millisecond)[0].x
}

fn near(found: DVec3, expected: DVec3, tolerance: f64, what: impl std::fmt::Debug) {
    assert!((found - expected).length() <= tolerance, "{what:?}: {found}, expected {expected}");
}

/// The diffuse colour of the first shape.
fn color(text: &str, millisecond: i64) -> DVec3 {
    let world = at(text, millisecond);
    match &world.materials[world.instances[0].material].bsdf {
        Bsdf::Diffuse { color, .. } => color.as_dvec3(),
        other => panic!("{other:?}"),
    }
}

/// The pyramid of Barry and Goldman (1988), which shares nothing with tangents.
fn pyramid(points: [DVec3; 4], s: f64) -> DVec3 {
    let knot = |a: DVec3, b: DVec3| (b - a).length().sqrt();
    let t1 = knot(points[0], points[1]);
    let t2 = t1 + knot(points[1], points[2]);
    let t3 = t2 + knot(points[2], points[3]);
    let t = t1 + s * (t2 - t1);
    let mix = |a: DVec3, b: DVec3, from: f64, to: f64| a * ((to - t) / (to - from)) + b * ((t - from) / (to - from));
    let a = [mix(points[0], points[1], 0.0, t1), mix(points[1], points[2], t1, t2), mix(points[2], points[3], t2, t3)];
    let b = [mix(a[0], a[1], 0.0, t2), mix(a[1], a[2], t1, t3)];
    mix(b[0], b[1], t1, t2)
}

#[test]
fn splines_are_centripetal() {
    let points = [(0.0, 0.0, 0.0), (1.0, 2.0, 0.0), (3.0, 2.0, 1.0), (3.0, -1.0, 1.5), (0.0, 0.0, 2.0)];
    let points = points.map(|(x, y, z)| DVec3::new(x, y, z));
    let times = [0, 1000, 1500, 3000, 4000];
    let keys: String =
        points.iter().zip(times).map(|(p, ms)| format!("{ms}ms: ({}, {}, {})  ", p.x, p.y, p.z)).collect();
    let text = format!(
        "let way = keys(interpolate: spline) {{ {keys} }}\nsphere a {{ position: way }}\n\
         sphere b {{ position: (way.x, way.y, way.z) }}"
    );
    for i in 1..3 {
        let four = [points[i - 1], points[i], points[i + 1], points[i + 2]];
        for tenth in 0..=10 {
            let ms = times[i] + (times[i + 1] - times[i]) * tenth / 10;
            let expected = pyramid(four, f64::from(tenth as i32) / 10.0);
            for found in places(&text, ms) {
                near(found, expected, 1e-12, (i, tenth));
            }
        }
    }
    // Equal neighbours: no overshoot.
    let flat =
        "sphere { position: keys(interpolate: spline) { 0s: (0, 0, 0)  1s: (1, 0, 0)  2s: (1, 0, 0)  3s: (5, 0, 0) } }";
    for ms in [1000, 1250, 1500, 1900, 2000] {
        assert_eq!(x(flat, ms), 1.0, "{ms}");
    }
    // An ease warps the parameter of its segment.
    let eased = text.replace("1500ms: (3, 2, 1)", "1500ms: (3, 2, 1) ease in_quad");
    near(places(&eased, 1250)[0], pyramid([points[0], points[1], points[2], points[3]], 0.25), 1e-12, "eased");
}

#[test]
fn a_loop_that_ends_where_it_begins_has_no_corner() {
    let text = "sphere { position: keys(interpolate: spline, outside: loop) {
        0s: (0, 0, 0)  1s: (1, 0, 0)  2s: (1, 1, 0)  3s: (0, 1, 0)  4s: (0, 0, 0) } }";
    let here = |ms| places(text, ms)[0];
    near(here(4000), DVec3::ZERO, 1e-12, "whole turn");
    let (before, after) = (here(4000) - here(3999), here(4001) - here(4000));
    assert!((before - after).length() < 1e-5 && before.length() > 5e-4, "{before} {after}");
}

#[test]
fn tangents_count_a_second() {
    let text = "sphere { position: keys(interpolate: hermite) {
        0s: { value: (0, 0, 0), out: (1, 0, 0) }
        2s: { value: (4m, 0m, 0m), in: (2m/s, 0m/s, 0m/s), out: (0, 1, 0) }
        3s: (4, 0, 1) } }";
    let hermite = |p: f64, m: f64, q: f64, n: f64, t: f64| {
        (2.0 * t.powi(3) - 3.0 * t * t + 1.0) * p
            + (t.powi(3) - 2.0 * t * t + t) * m
            + (3.0 * t * t - 2.0 * t.powi(3)) * q
            + (t.powi(3) - t * t) * n
    };
    for (ms, t) in [(0, 0.0), (500, 0.25), (1000, 0.5), (1900, 0.95)] {
        near(places(text, ms)[0], DVec3::new(hermite(0.0, 2.0, 4.0, 4.0, t), 0.0, 0.0), 1e-12, ms);
    }
    let expected = DVec3::new(4.0, hermite(0.0, 1.0, 0.0, 0.0, 0.5), 0.5);
    near(places(text, 2500)[0], expected, 1e-12, "second segment");
    // A turn that starts at 90 degrees a second about y.
    let turning = "box { rotation: keys(interpolate: hermite) {
        0s: { value: rotate_x(20deg), out: (0, 90deg/s, 0) }  1s: rotate_x(30deg) } }";
    let turn = |ms| DQuat::from_mat3(&shapes(turning, ms)[0].world_from_object.matrix3);
    let spin = (turn(1) * turn(0).conjugate()).to_scaled_axis() * 1000.0;
    near(spin, DVec3::new(0.0, 90.0_f64.to_radians(), 0.0), 5e-3, "spin");
}

#[test]
fn functions_and_springs_ease() {
    let text = "fn late(x: float, power = 3) -> float { return x ^ power }
        sphere { position: (keys { 0s: 1m  2s: 5m ease late }, 0, 0) }";
    near(DVec3::X * x(text, 1000), DVec3::X * 1.5, 1e-12, "cube");
    let root = "sphere { position: (keys { 0s: 1m  2s: 5m ease sqrt }, 0, 0) }";
    near(DVec3::X * x(root, 500), DVec3::X * 3.0, 1e-12, "root");
    // Critically damped: 1 − (1 + ω t) e^(−ω t), whose t are seconds, however long the segment is.
    for length in [1, 2, 5] {
        let text = format!("sphere {{ position: (keys {{ 0s: 0m  {length}s: 1m ease spring(2, 50, 20) }}, 0, 0) }}");
        let w = 5.0;
        let t: f64 = 0.3;
        near(DVec3::X * x(&text, 300), DVec3::X * (1.0 - (1.0 + w * t) * (-w * t).exp()), 1e-12, length);
    }
}

#[test]
fn keys_that_move_are_the_keys_where_they_are() {
    // `time - time` is 0 and no constant: the same curve, once kept and once computed.
    let curves = [
        "keys { 0s: (1, 0, 2)  1s: (2, 1, 0) ease out_back  3s: (0, 0, 5) ease in_out_sine }",
        "keys(outside: loop) { 0s: (1, 0, 2)  1s: (2, 1, 0)  3s: (0, 0, 5) ease steps(4) }",
        "keys(outside: pingpong) { 1s: (1, 0, 2)  2s: (2, 1, 0)  3s: (0, 0, 5) }",
        "keys(outside: extend) { 1s: (1, 0, 2)  2s: (2, 1, 0) ease in_quad  3s: (0, 0, 5) ease in_quad }",
        "keys(interpolate: spline) { 0s: (1, 0, 2)  1s: (2, 1, 0) ease in_quad  3s: (0, 0, 5)  4s: (1, 1, 1) }",
        "keys(interpolate: spline, outside: extend) { 1s: (1, 0, 2)  2s: (2, 1, 0)  3s: (0, 0, 5) ease in_quad }",
        "keys(interpolate: hermite) { 1s: { value: (1, 0, 2), out: (1, 2, 3) }  3s: { value: (0, 0, 5), in: (1, 0, 0) } }",
    ];
    for curve in curves {
        let moving = curve.replace("(1, 0, 2)", "(1 + (time - time) / 1s, 0, 2)");
        let text = format!("sphere {{ position: {curve} }}\nsphere {{ position: {moving} }}");
        for ms in [0, 300, 1000, 1500, 2200, 2999, 3500, 4700] {
            let [kept, computed] = places(&text, ms)[..] else { panic!() };
            near(computed, kept, 1e-7, (curve, ms));
        }
    }
    let turns = [
        "keys { 0s: rotate_y(10deg)  1s: rotate_x(100deg) ease out_back  3s: rotate_z(50deg) }",
        "keys(interpolate: spline) { 0s: rotate_y(10deg)  1s: rotate_x(100deg)  2s: rotate_z(50deg)  3s: rotate_y(-90deg) }",
        "keys(interpolate: hermite) { 0s: { value: rotate_y(10deg), out: (1rad/s, 0, 0) }  1s: rotate_x(100deg) }",
    ];
    for turn in turns {
        let moving = turn.replace("rotate_y(10deg)", "rotate_y(10deg + (time - time) * 1deg / 1s)");
        // Kept whole, a curve in an expression, and computed.
        let text = format!(
            "let way = {turn}\nbox {{ rotation: {turn} }}\nbox {{ rotation: rotate_x(0deg) * way }}\nbox {{ rotation: {moving} }}"
        );
        for ms in [0, 300, 1000, 1500, 2200, 2999, 3500] {
            let found = shapes(&text, ms);
            for other in &found[1..] {
                let off = (other.world_from_object.matrix3 - found[0].world_from_object.matrix3).to_cols_array();
                assert!(off.iter().all(|part| part.abs() < 1e-7), "{turn} at {ms}");
            }
        }
    }
    // A goal that moves is reached.
    let chase = "sphere { position: (keys { 0s: 0m  1s: 2m * time / 1s }, 0, 0) }";
    near(DVec3::X * x(chase, 500), DVec3::X * 0.5, 1e-12, "half way to 1");
    near(DVec3::X * x(chase, 3000), DVec3::X * 6.0, 1e-12, "held by a goal that moves on");
}

#[test]
fn what_is_true_holds_until_its_key() {
    let text = "let on = keys { 0s: false  1s: true }
        sphere { position: (if on { 1m } else { 0m }, 0, 0), visible: on || time < 2s }";
    for (ms, expected) in [(0, 0.0), (500, 0.0), (999, 0.0), (1000, 1.0), (1500, 1.0)] {
        assert_eq!(x(text, ms), expected, "{ms}");
    }
    let blinking = "sphere { visible: keys(outside: loop) { 0s: true  500ms: false  1s: true } }";
    for (ms, expected) in [(0, 1), (499, 1), (500, 0), (999, 0), (1000, 1), (1700, 0), (2100, 1)] {
        assert_eq!(shapes(blinking, ms).len(), expected, "{ms}");
    }
}

/// OKLCh as CSS Color 4 has it: linear Rec. 709 to lightness, chroma and hue.
fn oklch(rgb: DVec3) -> [f64; 3] {
    let cone = |a: f64, b: f64, c: f64| (a * rgb.x + b * rgb.y + c * rgb.z).cbrt();
    let l = cone(0.412_221_469_470_763, 0.536_332_537_261_734_8, 0.051_445_993_267_502_2);
    let m = cone(0.211_903_495_823_582_4, 0.680_699_550_645_234_5, 0.107_396_953_531_183_1);
    let s = cone(0.088_302_459_190_056_4, 0.281_718_839_136_121, 0.629_978_701_673_822_2);
    let a = 1.977_998_532_431_168_4 * l - 2.428_592_242_048_579_6 * m + 0.450_593_709_617_411_1 * s;
    let b = 0.025_904_042_465_547_8 * l + 0.782_771_712_457_529_6 * m - 0.808_675_754_923_077_4 * s;
    [0.210_454_268_309_314 * l + 0.793_617_774_702_305_4 * m - 0.004_072_043_011_619_2 * s, a.hypot(b), b.atan2(a)]
}

#[test]
fn colours_go_round_by_hue_the_nearer_way() {
    let text = "sphere { material: diffuse { color: keys(space: oklch) { 0s: linear(0.5, 0.1, 0.1)  1s: linear(0.2, 0.1, 0.4) } } }";
    let (from, to) = (DVec3::new(0.5, 0.1, 0.1), DVec3::new(0.2, 0.1, 0.4));
    near(color(text, 0), from, 1e-6, 0);
    near(color(text, 1000), to, 1e-6, 1000);
    let (a, b) = (oklch(from), oklch(to));
    for ms in [250, 500, 750] {
        let t = ms as f64 / 1000.0;
        let found = oklch(color(text, ms));
        let turn = (b[2] - a[2] + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        assert!(turn < 0.0);
        let hue = a[2] + t * turn;
        assert!((found[0] - (a[0] + t * (b[0] - a[0]))).abs() < 1e-5, "{ms}");
        assert!((found[1] - (a[1] + t * (b[1] - a[1]))).abs() < 1e-5, "{ms}");
        assert!(((found[2] - hue).sin()).abs() < 1e-4 && (found[2] - hue).cos() > 0.0, "{ms}");
    }
    // Grey has no hue of its own, so that the way there is straight; colours stay within what reflects.
    let grey = "sphere { material: diffuse { color: keys(space: oklch) { 0s: linear(0.5, 0.1, 0.1)  1s: linear(0.3, 0.3, 0.3) } } }";
    let hue = oklch(color(grey, 500))[2];
    assert!((hue - a[2]).abs() < 1e-4, "{hue} {}", a[2]);
    let vivid = "sphere { material: diffuse { color: keys(space: oklch) { 0s: linear(1, 0, 0)  1s: linear(0, 1, 0)  2s: linear(0, 0, 1) } } }";
    for ms in (0..2000).step_by(50) {
        let found = color(vivid, ms);
        assert!(found.min_element() >= 0.0 && found.max_element() <= 1.0, "{ms}: {found}");
    }
    // And without it, linear light.
    let linear =
        "sphere { material: diffuse { color: keys { 0s: linear(0.5, 0.1, 0.1)  1s: linear(0.2, 0.1, 0.4) } } }";
    near(color(linear, 250), from + (to - from) * 0.25, 1e-6, "linear");
}

#[test]
fn functions_follow_time() {
    // The same at each instant as for the number that it is.
    for ms in [0, 400, 1700] {
        let seconds = ms as f64 / 1000.0;
        let pair = |moving: &str, still: String| {
            let text = format!("sphere {{ position: ({moving}, 0, 0) }}\nsphere {{ position: ({still}, 0, 0) }}");
            let [a, b] = places(&text, ms)[..] else { panic!() };
            near(a, b, 1e-12, (moving, ms));
        };
        pair("rand(time / 1s, \"a\", seed: 3)", format!("rand({seconds:?}, \"a\", seed: 3)"));
        pair("rand((time / 1s, -time / 1s), true)", format!("rand(({seconds:?}, -{seconds:?}), true)"));
        pair("blackbody(2000K + time * 1000K / 1s).b", format!("blackbody({:?}K).b", 2000.0 + 1000.0 * seconds));
    }
}

#[test]
fn everything_that_may_move_does() {
    let text = "
        let t = keys { 0s: 0  1s: 1 }
        camera c { position: (t, 0, 5), look_at: (0, t, 0), up: (t, 1, 0), fov: keys { 0s: 40deg  1s: 50deg }, aperture: 1mm * t, focus: 1m + t * 1m }
        render { camera: c, exposure: t }
        sun { direction: (t, -1, 0), irradiance: 1W/m^2 * t }
        point_light { position: (0, t, 0), power: 1W * t }
        spot_light { position: (0, t, 2), direction: (t, -1, 0), power: 1W * t }
        sky { color: linear(t, t, t), strength: 1 + t }
        sphere { radius: 1m + t * 1m, scale: 1 + t, rotation: rotate_y(t * 10deg), material: diffuse { color: linear(t, t, t), roughness: t, opacity: t } }
        sphere { material: metal { color: linear(t, t, t), edge_tint: linear(t, t, t), roughness: t } }
        sphere { material: dielectric { ior: 1 + t, roughness: t } }
        sphere { material: glossy { color: linear(t, t, t), roughness: t, metalness: t } }
        sphere { material: emitter { color: linear(t, t, t), radiance: 1W/m^2/sr * t } }
        sphere { material: emitter { power: 1W * t } }
        sphere { material: mix(diffuse { }, metal { }, amount: t) }";
    let [early, late] = [250, 750].map(|ms| {
        let text = format!("lang 1\n{}", text.replace("render { ", "render { fps: 1000, "));
        world_at(&text, &Default::default(), ms)
    });
    assert_ne!(early.view.projection, late.view.projection);
    assert_eq!((early.look.exposure, late.look.exposure), (0.25, 0.75));
    assert!(early.lights.iter().zip(&late.lights).all(|(a, b)| a.light != b.light));
    assert_ne!(early.sky, late.sky);
    assert_eq!((early.view.aperture_m, early.view.focus_m), (0.25e-3, 1.25));
    for (a, b) in early.materials.iter().zip(&late.materials) {
        let still = matches!(&a.bsdf, Bsdf::Diffuse { color, .. } if color.x == 0.8)
            || matches!(&a.bsdf, Bsdf::Metal { roughness, .. } if *roughness == 0.2);
        assert!(still || a != b, "{a:?}");
    }
    let radius = |world: &World| match world.instances[0].shape {
        Shape::Sphere { radius_m } => radius_m,
        _ => 0.0,
    };
    assert_eq!((radius(&early), radius(&late)), (1.25, 1.75));
}

#[test]
fn pictures_slide_turn_and_grow() {
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255, 0, 0]).unwrap();
    let files = kinora_lang::files::Memory::new([("a.png", png.as_slice())]);
    let text = "lang 1
        render { fps: 1000 }
        camera { position: (0, 0, 9) }
        sky { color: #fff }
        let slide = image(\"a.png\", offset: (time / 2s, 0), rotation: keys { 0s: 0deg  1s: 90deg }, scale: 1 + time / 1s)
        sphere { material: diffuse { color: slide } }";
    for ms in [0, 500, 1000] {
        let world = world_at(text, &files, ms);
        let map = &world.materials[world.instances[0].material].maps[0];
        let kinora_scene::Texture::Image(image) = &*map.texture else { panic!("{map:?}") };
        let t = ms as f32 / 1000.0;
        assert_eq!(image.offset, glam::Vec2::new(t / 2.0, 0.0));
        assert_eq!(image.scale, glam::Vec2::splat(1.0 + t));
        assert!((image.rotation - f64::from(t) * std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert!(image.moving.is_none());
    }
}
