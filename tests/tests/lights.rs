//! Suns, points, spots and skies against closed forms, by every estimator; and many lights chosen by a tree.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec4};
use kinora_lang::files::Memory;
use kinora_renderer::Choice;
use kinora_scene::{
    Bsdf, Color, DiffuseModel, Image, Map, Material, Mis, Paint, Projection, Sky, SkyLight, Slot, Texels, Texture,
    UvSet, World,
};
use kinora_tests::measure::{Estimate, Kernel, Report};
use kinora_tests::{world, world_with};

/// A floor of albedo 1/2 seen from above, a millimetre of it.
const FLOOR: &str = "lang 1
render { resolution: (4, 4), filter: box, samples: 256, max_bounces: 1 }
camera { position: (0, 1, 0), look_at: (0, 0, 0), up: (0, 0, -1), fov: 0.1deg }
quad { size: (2, 2), material: diffuse { color: linear(0.5, 0.5, 0.5) } }
";

const SEEDS: u32 = 6;

const ALL: [Mis; 4] = [Mis::Nee, Mis::OneSample(0.4), Mis::BSDF, Mis::LIGHT];

struct Case {
    name: String,
    world: World,
    /// Irradiance on the floor.
    truth: DVec3,
    estimators: Vec<Mis>,
}

fn case(name: &str, scene: &str, truth: f64, estimators: &[Mis]) -> Case {
    let world = world(&format!("{FLOOR}{scene}"));
    Case { name: name.into(), world, truth: DVec3::splat(truth), estimators: estimators.to_vec() }
}

fn under(sky: SkyLight<kinora_scene::Still>, truth: f64, name: &str, estimators: &[Mis]) -> Case {
    let mut case = case(name, "sky { color: linear(1, 1, 1) }", truth, estimators);
    case.world.sky = Some(Sky { light: sky, strength: 1.0, visible: true });
    case
}

fn map(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Arc<Image> {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = texels.map(|(x, y)| [texel(x, y), texel(x, y), texel(x, y), 1.0]).collect();
    Arc::new(Image::new("sky", width, height, Texels::Rgba32F(texels)).expect("as many texels"))
}

/// E of a floor under one texel of a bilinear map, by the midpoint rule.
fn irradiance_of_texel(width: u32, height: u32, y: u32) -> f64 {
    const STEPS: u32 = 400;
    let (du, dv) = (1.0 / f64::from(width), 1.0 / f64::from(height));
    let mut sum = 0.0;
    for j in 0..STEPS {
        let t = -1.0 + 2.0 * (f64::from(j) + 0.5) / f64::from(STEPS);
        let theta = PI * (f64::from(y) + 0.5 + t) * dv;
        for i in 0..STEPS {
            let s = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(STEPS);
            let light = (1.0 - s.abs()) * (1.0 - t.abs());
            sum += light * theta.cos().max(0.0) * theta.sin();
        }
    }
    sum * (2.0 / f64::from(STEPS)).powi(2) * 2.0 * PI * du * PI * dv
}

fn check(cases: Vec<Case>) {
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut gpu = Kernel::gpu();
    let mut report = Report::new(5 * cases.len());
    for (i, case) in cases.into_iter().enumerate() {
        let truth = Estimate { mean: case.truth * 0.5 / PI, ..Estimate::known(0.0) };
        for (j, mis) in case.estimators.iter().enumerate() {
            let mut world = case.world.clone();
            world.render.mis = *mis;
            let on_gpu = gpu.as_deref_mut().filter(|_| j == 0 && i % 3 == 0);
            for (name, kernel) in [("cpu", Some(&mut cpu)), ("gpu", on_gpu)] {
                let Some(kernel) = kernel else { continue };
                let got = kernel.measure(&world, &[[0, 0, 4, 4]], SEEDS)[0];
                report.compare(&format!("{name}: {}, {mis:?}", case.name), &got, &truth, 2e-4, 0.15);
            }
        }
    }
    report.finish();
}

#[test]
fn suns_and_lamps() {
    let slant = (0.5_f64).cos();
    let mut cases = Vec::new();
    for angle in ["0deg", "0.53deg", "40deg"] {
        let sun = format!(
            "sun {{ direction: ({}, {}, 0), angle: {angle}, irradiance: 3W/m^2, color: linear(1, 1, 1) }}",
            0.5_f64.sin(),
            -slant
        );
        let estimators = if angle == "40deg" { &ALL[..] } else { &[Mis::Nee, Mis::OneSample(0.4), Mis::LIGHT][..] };
        cases.push(case(&format!("a sun of {angle}"), &sun, 3.0 * slant, estimators));
    }
    let delta = "sun { direction: (0, -1, 0), angle: 0deg, irradiance: 3W/m^2 }";
    cases.push(case("a sun of 0deg by BSDF samples", delta, 3.0, &[Mis::BSDF]));
    let both = "sun { irradiance: 1W/m^2, angle: 0deg }\nsun { direction: (1, -1, 0), irradiance: 2W/m^2 }
        quad { position: (0, 2, 0), normal: (0, -1, 0), size: (0.02, 0.02), material: emitter { power: 1W } }
        sky { color: linear(0.1, 0.1, 0.1) }";
    // The lamp shades the sun above, whose light is a point.
    let lamp = 1.0 / PI / 4.0;
    cases.push(case("two suns, a lamp and a sky", both, 2.0 * 0.5_f64.sqrt() + lamp + 0.1 * PI, &[Mis::Nee]));

    // A point 2 m above and 1 m aside.
    let cos = 2.0 / 5.0_f64.sqrt();
    let point = 40.0 / (4.0 * PI * 5.0) * cos;
    cases.push(case("a point", "point_light { position: (1, 2, 0), power: 40W }", point, &ALL));
    let ball = "point_light { position: (1, 2, 0), power: 40W, radius: 10cm }";
    cases.push(case("a small ball", ball, point, &[Mis::Nee, Mis::OneSample(0.4), Mis::LIGHT]));
    let group = "group { position: (1, 0, 0)\n point_light { position: (0, 2, 0), power: 40W } }";
    cases.push(case("a point in a group", group, point, &[Mis::Nee]));

    // At 20 degrees from the axis of a cone of 50 with a soft part of 60 %: between 10 and 25 degrees.
    let off = 20.0_f64.to_radians();
    let [inner, outer] = [10.0_f64, 25.0].map(|angle| angle.to_radians().cos());
    let t = (off.cos() - outer) / (inner - outer);
    let soft = t * t * (3.0 - 2.0 * t);
    let spot = |more: &str| {
        format!(
            "spot_light {{ position: (0, 2, 0), direction: ({}, {}, 0), power: 40W, angle: 50deg, {more} }}",
            off.sin(),
            -off.cos()
        )
    };
    let axial = 40.0 / (4.0 * PI * 4.0);
    cases.push(case("the edge of a spot", &spot("blend: 0.6"), axial * soft, &ALL));
    cases.push(case("the middle of a spot", &spot("blend: 0.1"), axial, &[Mis::Nee]));
    let ball = spot("blend: 0.6, radius: 1cm");
    cases.push(case("the edge of a ball that is a spot", &ball, axial * soft, &[Mis::Nee, Mis::LIGHT]));
    check(cases);
}

/// E under a corner of a parallel rectangle of radiance 1, a and b in heights.
fn under_corner(a: f64, b: f64) -> f64 {
    let part = |x: f64, y: f64| x / x.hypot(1.0) * (y / x.hypot(1.0)).atan();
    0.5 * (part(a, b) + part(b, a))
}

#[test]
fn lamps_with_pictures() {
    let half = "checker(linear(3, 3, 3), linear(0, 0, 0), scale: (2, 1))";
    // 2 m above, from x = 0 to 2, of which the nearer half shines.
    let truth = 3.0 * 2.0 * under_corner(0.5, 0.5);
    let quad = |material: &str| {
        format!("quad {{ position: (1, 2, 0), normal: (0, -1, 0), size: (2, 2), material: {material} }}")
    };
    let mesh = format!(
        "mesh {{ positions: [(0, 2, -1), (2, 2, -1), (2, 2, 1), (0, 2, 1)], indices: [0, 1, 2, 0, 2, 3],
        uvs: [(0, 0), (1, 0), (1, 1), (0, 1)], material: emitter {{ color: {half} }} }}"
    );
    // One metre square above, of which every second square shines.
    let share = "checker(1, 0, scale: (2, 1))";
    let mut cases = vec![
        case("half a quad", &quad(&format!("emitter {{ color: {half} }}")), truth, &ALL),
        case("half a mesh", &mesh, truth, &ALL),
        case(
            "two quarters",
            &format!(
                "quad {{ position: (0, 2, 0), normal: (0, -1, 0), size: (2, 2), material: emitter {{ color: {}, power: {}W }} }}",
                "checker(linear(1, 1, 1), linear(0, 0, 0), scale: 2)",
                4.0 * PI
            ),
            2.0 * under_corner(0.5, 0.5),
            &ALL,
        ),
        case(
            "half of it mixed in",
            &quad(&format!("mix(diffuse {{ color: #000 }}, emitter {{ radiance: 3W/m^2/sr }}, amount: {})", share)),
            truth,
            &ALL,
        ),
        case(
            "half of it cut out",
            &quad(&format!("emitter {{ radiance: 3W/m^2/sr, opacity: {} }}", share)),
            truth,
            &ALL,
        ),
        case(
            "under a coat that is cut out",
            &quad(&format!("glossy {{ base: emitter {{ color: {half} }}, ior: 1, opacity: 0.5 }}")),
            0.5 * truth,
            &[Mis::Nee, Mis::OneSample(0.4), Mis::LIGHT],
        ),
    ];
    let mut glowing = case("what glows besides", &quad("emitter { radiance: 2W/m^2/sr }"), truth, &ALL);
    let checker = Texture::Checker {
        a: Paint::Color(Vec4::ONE),
        b: Paint::Color(Vec4::ZERO),
        scale: Vec2::new(2.0, 1.0),
        uv_set: UvSet::First,
    };
    for material in &mut glowing.world.materials {
        if matches!(material.bsdf, Bsdf::Emitter { .. }) {
            let black = Bsdf::Diffuse { color: Color::ZERO, roughness: 0.0, model: DiffuseModel::Eon };
            let map = Map { slot: Slot::Emission, texture: Arc::new(checker.clone()) };
            *material = Material { emission: Color::splat(3.0), maps: vec![map], ..black.into() };
        }
    }
    cases.push(glowing);
    check(cases);
}

/// A point 2 m above and 1 m aside, a sun at 30 degrees, and a spot whose edge is at 20 degrees, of a model that is
/// larger than life.
#[test]
fn lights_of_a_model() {
    let (half, full) = (15_f64.to_radians(), 30_f64.to_radians());
    let down = |tilt: f64| {
        let angle = -0.25 * PI + 0.5 * tilt;
        format!("[{}, 0, 0, {}]", angle.sin(), angle.cos())
    };
    let model = format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {{ "KHR_lights_punctual": {{ "lights": [
            {{ "type": "point", "intensity": 5, "color": [1, 0.5, 0] }},
            {{ "type": "directional", "intensity": 3 }},
            {{ "type": "spot", "intensity": 7, "spot": {{ "innerConeAngle": {half}, "outerConeAngle": {full} }} }} ] }} }},
        "nodes": [
            {{ "translation": [0.5, 1, 0], "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }} }},
            {{ "rotation": {}, "extensions": {{ "KHR_lights_punctual": {{ "light": 1 }} }} }},
            {{ "translation": [0, 0.5, 0], "rotation": {}, "extensions": {{ "KHR_lights_punctual": {{ "light": 2 }} }} }} ],
        "scenes": [{{ "nodes": [0, 1, 2] }}], "scene": 0 }}"#,
        down(full),
        down(20_f64.to_radians()),
    );
    let files = Memory::new([("lamps.gltf", model.as_bytes())]);
    let world = world_with(&format!("{FLOOR}model lamps {{ file: \"lamps.gltf\", scale: 2 }}"), &files);
    let cos = 2.0 / 5.0_f64.sqrt();
    let (inner, outer, off) = (half.cos(), full.cos(), 20_f64.to_radians().cos());
    let t = (off - outer) / (inner - outer);
    let others = 3.0 * full.cos() + 7.0 * t * t * (3.0 - 2.0 * t);
    let truth = DVec3::new(1.0, 0.5, 0.0) * (5.0 / 5.0 * cos) + others;
    check(vec![Case { name: "lights of a model".into(), world, truth, estimators: vec![Mis::Nee, Mis::LIGHT] }]);
}

#[test]
fn skies() {
    let turned = |image: &Arc<Image>, rotation| SkyLight::Map { image: image.clone(), rotation };
    let mut cases = Vec::new();
    let even = map(7, 5, |_, _| 0.75);
    cases.push(under(turned(&even, 0.3), 0.75 * PI, "an even map", &ALL));
    for (x, y) in [(0, 3), (15, 7), (3, 0), (20, 6)] {
        let bright = map(32, 16, |i, j| if (i, j) == (x, y) { 1e5 } else { 0.0 });
        let truth = 1e5 * irradiance_of_texel(32, 16, y);
        // A texel at the pole is the pole too.
        if y > 0 {
            let name = format!("one bright texel at {x}, {y}");
            cases.push(under(turned(&bright, 1.0), truth, &name, &[Mis::Nee, Mis::LIGHT, Mis::OneSample(0.5)]));
        }
    }
    check(cases);
}

#[test]
fn a_map_lies_as_it_is_written_and_turns() {
    // Red towards -z, green towards +x, blue straight up.
    let texels = (0..32 * 64)
        .map(|i| {
            let (x, y) = (i % 64, i / 64);
            let near = |at: i32, around: i32| f32::from((at - around).abs() <= 2);
            [near(x, 32), near(x, 48), f32::from(y < 4), 1.0]
        })
        .collect();
    let image = Arc::new(Image::new("sky", 64, 32, Texels::Rgba32F(texels)).expect("as many texels"));
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut seen = |to: DVec3, rotation: f64| {
        let text = format!(
            "lang 1\nrender {{ resolution: (1, 1), samples: 1, filter: box }}\ncamera {{ look_at: ({}, {}, {}), up: (0.1, 0.9, 0.2), fov: 0.01deg }}\nsky {{ color: #fff }}",
            to.x, to.y, to.z
        );
        let mut world = world(&text);
        let light = SkyLight::Map { image: image.clone(), rotation };
        world.sky = Some(Sky { light, strength: 1.0, visible: true });
        cpu.picture(&world)[0]
    };
    let quarter = PI / 2.0;
    for (to, rotation, expected) in [
        (DVec3::NEG_Z, 0.0, DVec3::X),
        (DVec3::X, 0.0, DVec3::Y),
        (DVec3::Y, 0.0, DVec3::Z),
        (DVec3::Z, 0.0, DVec3::ZERO),
        // Turned by a quarter about +y, which takes z to x, x goes to -z and -z to -x.
        (DVec3::NEG_Z, quarter, DVec3::Y),
        (DVec3::NEG_X, quarter, DVec3::X),
    ] {
        // A little aside, so that a direction straight up is one.
        let got = seen(to + DVec3::new(0.003, 0.004, 0.002), rotation);
        let got = if expected == DVec3::Z { DVec3::Z * got.z } else { got };
        assert!((got - expected).length() < 1e-3, "{to} turned by {rotation}: {got}");
    }
}

#[test]
fn many_lights_by_a_tree() {
    let mut cases = Vec::new();
    for scale in [1.0, 1e3, 1e-3] {
        let (mut lamps, mut truth) = (String::new(), 0.0);
        for i in 0..60 {
            let (a, r) = (f64::from(i) * 2.4, 0.2 + 0.05 * f64::from(i));
            let p = DVec3::new(r * a.cos(), 1.0 + 0.7 * (a * 1.7).sin(), r * a.sin()) * scale;
            let power = if i % 10 == 9 { 0.0 } else { f64::from(i % 7 + 1) } * scale * scale;
            writeln!(lamps, "point_light {{ position: ({}, {}, {}), power: {power}W }}", p.x, p.y, p.z)
                .expect("memory");
            truth += power / (4.0 * PI * p.length_squared()) * p.y / p.length();
        }
        let mut case = case(&format!("60 points, scale {scale}"), &lamps, truth, &[Mis::Nee, Mis::BSDF]);
        // A few micrometres: the smallest lamps are as near as a millimetre.
        if let Projection::Perspective { fov } = &mut case.world.view.projection {
            *fov *= 3e-3;
        }
        cases.push(case);
    }
    // A square of 1 m² 1 m above, in 20 000 triangles: one light as before.
    let n = 100;
    let mut mesh = "mesh { positions: [".to_owned();
    for i in 0..=n {
        for j in 0..=n {
            let at = |k: i32| f64::from(k) / f64::from(n) - 0.5;
            write!(mesh, "({:.4}, 1, {:.4}),", at(i), at(j)).expect("memory");
        }
    }
    mesh += "], indices: [";
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            let b = a + n + 1;
            write!(mesh, "{a},{b},{},{a},{},{},", b + 1, b + 1, a + 1).expect("memory");
        }
    }
    mesh += "], material: emitter { radiance: 2W/m^2/sr, two_sided: true } }";
    cases.push(case("a lamp in 20 000 triangles", &mesh, 2.0 * 0.752_274_688_5, &ALL));
    check(cases);
}
