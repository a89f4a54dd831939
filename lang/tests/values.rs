//! What expressions come to: against numbers known from elsewhere.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec3};
use kinora_lang::files::Memory;
use kinora_lang::source::{FileId, Source};
use kinora_lang::{Overrides, eval, parse};
use kinora_scene::{
    Animated, Background, Bsdf, Color, DiffuseModel, Ease, Instruction, Material, Mis, Reflectance, Scene, Shape,
    Shown, Spectrum, Tape, Track,
};

fn scene(text: &str) -> Scene {
    let (imports, rest): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with("import"));
    let (imports, rest) = (imports.join("\n"), rest.join("\n"));
    let text = format!("lang 1\n{imports}\ncamera main {{ position: (0, 0, 4) }}\nsky {{ color: #fff }}\n{rest}");
    match eval(&parse(&Source::new(FileId(0), "a.kin", text.as_str())), &Memory::default(), &Overrides::default()) {
        Ok(evaluated) => evaluated.scene,
        Err(found) => panic!("{text}: {:?}", found.iter().map(|found| &found.message).collect::<Vec<_>>()),
    }
}

fn vector(text: &str) -> DVec3 {
    *scene(&format!("sphere {{ position: {text} }}")).nodes[0].placing.position.constant().unwrap()
}

fn near(text: &str, expected: f64) {
    let found = vector(&format!("({text}, 0, 0)")).x;
    assert!((found - expected).abs() <= 1e-12 * expected.abs().max(1.0), "{text}: {found}, not {expected}");
}

#[test]
fn units() {
    near("50cm", 0.5);
    near("3mm", 0.003);
    near("2km", 2000.0);
    near("1in", 0.0254);
    near("1ft", 0.3048);
    near("9.81m/s^2 * 2s * 2s", 39.24);
    near("180deg / 1rad", PI);
    near("0.25turn / 1rad", FRAC_PI_2);
    near("1min / 1s", 60.0);
    near("50%", 0.5);
    near("1000kg/m^3 * 1m^3 / 1g", 1e6);
    near("sqrt(4m^2)", 2.0);
    near("1N / 1kg / 1m/s^2", 1.0);
    near("1J/s / 1W + 1rad^2 / 1sr + 1lm / 1cd / 1sr + 1lx * 1m^2 / 1lm + 1s^-1 / 1Hz", 5.0);
    near("3ft^2 / 1m", 0.278_709_12);
    near("12m/in * 1m", 12.0 / 0.0254);
    near("1g/cm^3 / 1kg/m^3", 1000.0);
    near("f_number(n: 2, focal_length: 0.1) + f_number(8, focal_length: 50mm)", 0.056_25);
    near("3m/s * 2s", 6.0);
    near("length((3m, 0, 4m) / 1m) + length(2s * (0, 3, 4)) / 1s", 15.0);
}

#[test]
fn arithmetic() {
    near("1 + 2 * 3 ^ 2", 19.0);
    near("2 ^ 3 ^ 2", 512.0);
    near("-2 ^ 2", -4.0);
    near("7 / 2", 3.5);
    near("10 - 3 - 2", 5.0);
    near("mod(-7, 3)", 2.0);
    near("mod(7.5, 2)", 1.5);
    near("abs(-3) + sign(-2) + floor(2.7) + ceil(2.1) + round(2.5)", 3.0 - 1.0 + 2.0 + 3.0 + 3.0);
    near("exp(log(5))", 5.0);
    near("if 1 < 2 && !(3 <= 2) { 4 } else { 5 }", 4.0);
    near("if true || 1 / 0 > 1 { 1 } else { 2 }", 1.0);
    near("[10, 20, 30][1]", 20.0);
    near("count(0..7) + count([1, 2])", 9.0);
    near("sum([for i in 0..5 if i != 3: i * 10cm])", 0.7);
    near("sum([for i, x in [5, 6]: i * x])", 6.0);
    near("min(3, 1, 2) + max([3, 1, 2])", 4.0);
    near("(2 ^ -1) + 4 ^ 3 ^ 0.5 - -3", 3.5 + 4f64.powf(3f64.sqrt()));
    near("16 / 4 * 2 + 2 * -3 + (-3) ^ 2", 11.0);
    near("if 1 > 2 && 2 < 3 || 1 < 2 { 1 } else { 0 }", 1.0);
    near("mod(7, -3) + mod(450deg, 360deg) / 1deg + fract(-2.25)", -2.0 + 90.0 + 0.75);
    near("smoothstep(3, 1, 1.5) + mix(2, 4, 150%)", 0.84375 + 5.0);
    near("min((1, 5, 3), (2, 4, 9)).y + max([(1, 5), (2, 4)]).x + abs((-1, 2, -3)).z", 9.0);
    near("sum([(1, 2), (3, 4)]).y + sum([]) + count(7..3) + (3..7)[2]", 11.0);
    near("sum([for r in [for i in 0..3: [for j in 0..i + 1: j]]: sum(r)])", 4.0);
    near("mix(1m, 3m, 0.25)", 1.5);
    near("clamp(5, 0, 2) + saturate(-1) + step(1, 1) + step(1, 0.9)", 3.0);
    near("smoothstep(0, 2, 0.5)", 0.15625);
    near("(3, 4, 5).y + (3, 4, 5).zx.y", 7.0);
}

#[test]
fn vectors_and_angles() {
    near("length((3, 4, 12))", 13.0);
    near("dot((1, 2, 3), (4, 5, 6))", 32.0);
    near("distance((0, 0), (3cm, 4cm))", 0.05);
    near("sin(30deg) + cos(60deg) + tan(45deg)", 2.0);
    near("sin(1)", 1f64.sin());
    near("asin(1) / 1deg + atan2(1m, 1m) / 1deg", 135.0);
    near("cos(turn(0.5))", -1.0);
    assert_eq!(vector("cross((1, 0, 0), (0, 1, 0))"), DVec3::Z);
    assert_eq!(vector("normalize((0, 0, 2m))"), DVec3::Z);
    let near = |text: &str, expected: DVec3| {
        let found = vector(text);
        assert!((found - expected).length() < 1e-12, "{text}: {found}");
    };
    near("(1m, 2m, 3m) + 2 * (0, 10cm, 0) - (1m, 1m, 1m) / 2", DVec3::new(0.5, 1.7, 2.5));
    // Bare numbers in vectors are metres where they meet lengths.
    near("(1, 2, 3) + (0, 50cm, 1m)", DVec3::new(1.0, 2.5, 4.0));
    near("mix((2, 2, 2), (1m, 3m, 2m), 0.5)", DVec3::new(1.5, 2.5, 2.0));
    near("[(1, 2, 3), (4cm, 0, 1)][1] - (1, 1, 1)", DVec3::new(-0.96, -1.0, 0.0));
    near("rotate_y(90deg) * (0, 0, 1)", DVec3::X);
    near("rotate_x(90deg) * (0, 1, 0)", DVec3::Z);
    near("rotate_z(90deg) * (1, 0, 0)", DVec3::Y);
    near("(rotate_y(90deg) * rotate_x(90deg)) * (0, 1, 0)", DVec3::X);
    near("euler(x: 90deg, y: 90deg, z: 0deg) * (0, 1, 0)", DVec3::X);
    near("axis_angle((0, 2, 0), 90deg) * (0, 0, 1)", DVec3::X);
    near("face_towards((2, 0, 0), up: (0, 1, 0)) * (0, 0, 1)", DVec3::X);
    near("face_towards((2, 0, 0)) * (0, 1, 0)", DVec3::Y);
    near("look_at((0, 0, 0), (0, 0, 5), (0, 1, 0)) * (0, 0, -1)", DVec3::Z);
}

#[test]
fn colours() {
    let near = |text: &str, expected: [f64; 3]| {
        let scene = scene(&format!("emitter lamp {{ color: {text} }}\nsphere {{ material: lamp }}"));
        let Bsdf::Emitter { color, .. } = &scene.materials[0].bsdf else { panic!("{text}") };
        let found = color.constant().unwrap().as_dvec3();
        assert!((found - DVec3::from_array(expected)).length() < 1e-5, "{text}: {found}");
    };
    // The sRGB curve at table values.
    near("srgb(0.735356983052449, 0.461356129500441, 0.01292)", [0.5, 0.18, 0.001]);
    near("#bc7b00", [0.502_886_458_033_25, 0.198_069_319_620_25, 0.0]);
    near("#f00", [1.0, 0.0, 0.0]);
    near("linear(2, 0.25, 0)", [2.0, 0.25, 0.0]);
    near("hsv(0deg, 100%, 100%)", [1.0, 0.0, 0.0]);
    near("hsv(120deg, 1, 1)", [0.0, 1.0, 0.0]);
    near("hsv(480deg, 1, 1)", [0.0, 1.0, 0.0]);
    near("hsv(60deg, 0, 0.735356983052449)", [0.5, 0.5, 0.5]);
    // OKLab of white and of the sRGB primaries (Ottosson 2020).
    near("oklch(1, 0, 0deg)", [1.0, 1.0, 1.0]);
    near("oklch(0.627955, 0.257683, 29.2339deg)", [1.0, 0.0, 0.0]);
    near("mix(linear(0, 0, 0), linear(1, 1, 1), 0.5)", [0.5, 0.5, 0.5]);
    near("2 * linear(0.25, 0, 1) + #000", [0.5, 0.0, 2.0]);
    near("linear(1, 2, 3) * linear(2, 2, 2) / 2", [1.0, 2.0, 3.0]);
    near("linear(#fff.r, (0.1, 0.2).y, 0)", [1.0, 0.2, 0.0]);
}

/// The tape's outputs at a time, with 24 frames a second and no keys.
fn run(tape: &Tape, time: f64) -> Vec<f64> {
    let mut registers: Vec<f64> = Vec::new();
    for instruction in &tape.code {
        let at = |register: u32| registers[register as usize];
        registers.push(match *instruction {
            Instruction::Const(value) => value,
            Instruction::Time => time,
            Instruction::Frame => time * 24.0,
            Instruction::Unary(op, a) => op.apply(at(a)),
            Instruction::Binary(op, a, b) => op.apply(at(a), at(b)),
            Instruction::Select(c, a, b) => at(if at(c) != 0.0 { a } else { b }),
            other => panic!("{other:?}"),
        });
    }
    tape.outputs.iter().map(|register| registers[*register as usize]).collect()
}

#[test]
fn moving_values_become_tapes() {
    let check = |property: &str, expected: &dyn Fn(f64) -> Vec<f64>| {
        let scene = scene(&format!("box {{ {property} }}"));
        let placing = &scene.nodes[0].placing;
        let tapes =
            [curve(&placing.position), curve(&placing.rotation), curve(&placing.scale), curve(&scene.nodes[0].visible)];
        let tape = tapes.into_iter().flatten().next().unwrap_or_else(|| panic!("{property}: no tape"));
        for time in [0.0, 0.3, 1.7, 12.5] {
            let (found, expected) = (run(tape, time), expected(time));
            let far = found.iter().zip(&expected).any(|(a, b)| (a - b).abs() > 1e-9);
            assert!(!far && found.len() == expected.len(), "{property} at {time}: {found:?}, not {expected:?}");
        }
    };
    check("position: (-0.8, 0.5 + 0.2 * sin(turn(time / 2s)), 0)", &|t| vec![-0.8, 0.5 + 0.2 * (PI * t).sin(), 0.0]);
    check("position: (1m/s * time, frame, mod(time / 1s, 1))", &|t| vec![t, 24.0 * t, t.rem_euclid(1.0)]);
    check("rotation: rotate_y(90deg/s * time)", &|t| DQuat::from_rotation_y(FRAC_PI_2 * t).to_array().to_vec());
    check("rotation: rotate_x(30deg) * rotate_y(time * 1rad/s)", &|t| {
        (DQuat::from_rotation_x(PI / 6.0) * DQuat::from_rotation_y(t)).to_array().to_vec()
    });
    check("scale: 1 + time / 1s", &|t| vec![1.0 + t; 3]);
    check("visible: time > 1s && time < 2s", &|t| vec![f64::from(u8::from(t > 1.0 && t < 2.0))]);
    check("position: if time < 1s { (1, 2, 3) } else { (4, 5, time / 1s) }", &|t| {
        if t < 1.0 { vec![1.0, 2.0, 3.0] } else { vec![4.0, 5.0, t] }
    });
    check("position: rotate_z(time * 1rad/s) * (2, 0, 0)", &|t| vec![2.0 * t.cos(), 2.0 * t.sin(), 0.0]);
}

fn curve<T>(track: &Track<T>) -> Option<&Tape> {
    match track {
        Track::Curve(tape) => Some(tape),
        _ => None,
    }
}

#[test]
fn keys() {
    let scene_of = |text: &str| scene(&format!("render {{ fps: 25 }}\nsphere {{ {text} }}"));
    let track = |text: &str| match scene_of(text).nodes.remove(0).shape {
        Some(Shape::Sphere { radius_m }) => radius_m,
        other => panic!("{other:?}"),
    };
    let Track::Keys(keys) =
        track("radius: keys { 0s: 1m  1s: 2m ease in_out_cubic  after 50f: 3cm ease bezier(0.3, 0, 0.1, 1) }")
    else {
        panic!("no keys")
    };
    let rows: Vec<_> = keys.keys.iter().map(|key| (key.time_s, key.value)).collect();
    assert_eq!(rows, [(0.0, 1.0), (1.0, 2.0), (3.0, 0.03)]);
    assert!(matches!(keys.keys[2].ease, Ease::Bezier(curve) if curve.x1 == 0.3));
    let Track::Keys(keys) = track("radius: keys(interpolate: step) { 0s: 1  1s: 2 ease out_quad }") else { panic!() };
    assert_eq!(keys.keys[1].ease, Ease::Step);
    let Track::Curve(tape) = track("radius: 1 + abs(keys { 0s: 1  1s: 2 })") else { panic!("no tape") };
    assert_eq!((tape.curves.len(), tape.curves[0].keys[1].value), (1, 2.0));
    let moved = scene_of("position: keys { 0s: (0, 0, 0)  1s: (1m, 2, 3) }");
    let Track::Keys(keys) = &moved.nodes[0].placing.position else { panic!("no keys") };
    assert_eq!(keys.keys[1].value, DVec3::new(1.0, 2.0, 3.0));
    let turned = scene(
        "let swing = keys { 0s: rotate_y(0deg)  1s: rotate_y(90deg) }\nbox { rotation: rotate_y(90deg) * swing }",
    );
    let Track::Curve(tape) = &turned.nodes[0].placing.rotation else { panic!("no tape") };
    assert_eq!(tape.turns.len(), 1);
    let named = scene(
        "let path = keys { 0s: (0, 0, 0)  1s: (0, 1, 0) }\nsphere { position: path, radius: 1 + distance(path, (0, 0, 1)) }\nbox { position: path }",
    );
    assert_eq!(named.nodes.len(), 2);
}

#[test]
fn structure() {
    let text = "
group all {
    position: (1, 0, 0)
    box inner { }
    group deeper { quad { parent: other } }
}
prefab pair(at: vec3, mat: material = white) {
    sphere left { position: at, material: mat }
    sphere { position: -at, visible: false }
}
pair { at: (1, 2, 3) }
pair named { at: (1, 2, 3), mat: gold }
pair again like named { at: (0, 0, 0) }
diffuse white { color: linear(0.5, 0.5, 0.5) }
metal gold { color: #ffd700, roughness: 30% }
sphere copy like other { position: (3, 0, 0) }
sphere other { radius: 2, material: gold }
camera second { look_at: named.left, parent: all }
render { camera: second }
let sizes = [1, 2]
fn area(r: length) -> area {
    let square = r * r
    if square > 100m^2 { return 0m^2 }
    return 3 * square
}
for i, size in sizes { box { size: (size, area(1m) / 1m, i + 1) } }
if count(sizes) > 5 { sphere { } } else if true { plane { } }
";
    let scene = scene(text);
    let names: Vec<&str> = scene.nodes.iter().map(|node| node.name.as_str()).collect();
    let index = |name: &str| names.iter().position(|known| *known == name).unwrap();
    assert_eq!(scene.nodes[index("inner")].parent, Some(index("all")));
    assert_eq!(scene.nodes[index("quad")].parent, Some(index("other")));
    for (i, node) in scene.nodes.iter().enumerate() {
        assert!(node.parent.is_none_or(|parent| parent < i), "{}", node.name);
    }
    let radius = |name: &str| match &scene.nodes[index(name)].shape {
        Some(Shape::Sphere { radius_m }) => *radius_m.constant().unwrap(),
        other => panic!("{other:?}"),
    };
    assert_eq!((radius("copy"), radius("other")), (2.0, 2.0));
    assert_eq!(scene.nodes[index("copy")].material, scene.nodes[index("other")].material);
    assert!(matches!(scene.materials[scene.nodes[index("copy")].material].bsdf, Bsdf::Metal { .. }));
    assert_eq!(scene.nodes.iter().filter(|node| node.visible.constant() == Some(&false)).count(), 3);
    let sizes: Vec<DVec3> = scene
        .nodes
        .iter()
        .filter_map(|node| match node.shape {
            Some(Shape::Box { size_m }) if node.name == "box" => Some(size_m),
            _ => None,
        })
        .collect();
    assert_eq!(sizes, [DVec3::new(1.0, 3.0, 1.0), DVec3::new(2.0, 3.0, 2.0)]);
    assert_eq!(scene.nodes.iter().filter(|node| matches!(node.shape, Some(Shape::Plane { .. }))).count(), 1);
    assert_eq!((scene.cameras.len(), scene.camera), (2, Some(1)));
    let camera = &scene.cameras[1];
    assert_eq!(camera.parent, Some(index("all")));
    let kinora_scene::Aim::Node { target, .. } = camera.aim else { panic!("{:?}", camera.aim) };
    assert_eq!((names[target], scene.nodes[target].parent), ("left", Some(index("named"))));
}

#[test]
fn materials_and_estimators() {
    let text = "render { mis: one_sample, clamp: 3, background: transparent, view: cost }
        sphere { material: mix(glossy { base: metal { spectrum: \"Pt\", anisotropy: 50% }, roughness: 0 }, glossy { color: #fff },
            amount: time / 1s) }
        sphere { material: dielectric { thin: true, priority: -7, opacity: 25% } }
        sphere { material: diffuse { model: qon } }";
    let scene = scene(text);
    let render = &scene.render;
    assert_eq!((render.mis, render.clamp), (Mis::OneSample(0.2), Some(3.0)));
    assert_eq!((render.background, render.view), (Background::Transparent, Shown::Cost));
    let glossy = |base, roughness: f64| Bsdf::Glossy {
        base,
        ior: 1.5,
        tint: Color::ONE.into(),
        roughness: roughness.into(),
        metalness: 0.0.into(),
    };
    let diffuse = |color: f32, model| Bsdf::Diffuse { color: Color::splat(color).into(), roughness: 0.0.into(), model };
    let expected: [Material<Animated>; 7] = [
        Bsdf::Metal {
            reflectance: Reflectance::Spectrum(Spectrum::Pt),
            roughness: 0.2.into(),
            anisotropy: 0.5,
            anisotropy_rotation: 0.0,
            energy_compensation: true,
        }
        .into(),
        glossy(0, 0.0).into(),
        diffuse(1.0, DiffuseModel::Eon).into(),
        glossy(2, 0.1).into(),
        scene.materials[4].clone(),
        Material {
            opacity: 0.25.into(),
            ..Bsdf::Dielectric {
                ior: 1.5.into(),
                roughness: 0.0.into(),
                energy_compensation: true,
                attenuation_color: Color::ONE,
                attenuation_distance_m: f64::INFINITY,
                thin: true,
                priority: -7,
            }
            .into()
        },
        diffuse(0.8, DiffuseModel::Qon).into(),
    ];
    assert_eq!(scene.materials, expected);
    let Bsdf::Mix { a: 1, b: 3, amount } = &scene.materials[4].bsdf else { panic!("{:?}", scene.materials[4]) };
    assert!(matches!(amount, Track::Curve(_)));
    assert_eq!(scene.nodes.iter().map(|node| node.material).collect::<Vec<_>>(), [4, 5, 6]);
    for (word, mis) in [("nee", Mis::Nee), ("bsdf", Mis::BSDF), ("light", Mis::LIGHT)] {
        assert_eq!(self::scene(&format!("render {{ mis: {word} }}")).render.mis, mis);
    }
    let seldom = self::scene("render { mis: one_sample, light_probability: 75% }");
    assert_eq!((seldom.render.mis, seldom.render.clamp), (Mis::OneSample(0.75), None));
}

#[test]
fn lists_of_a_type_take_bare_metres() {
    let scene = scene(
        "fn second(list: list<length>) -> length = list[1] + 50cm\nsphere { position: (second([1, 2]), 0, 0) }\nprefab at(look: texture, r: radiance) { sphere { material: emitter { color: look, radiance: r } } }\nat { look: checker(#fff, #000), r: 2W/m^2/sr }",
    );
    assert_eq!(scene.nodes[0].placing.position.constant(), Some(&DVec3::new(2.5, 0.0, 0.0)));
}

/// Prefabs of the library take points in bare metres, and what they make is where it should be.
#[test]
fn library() {
    let scene = scene(
        "import { tube, rounded_box, lathe, frustum } from \"std/shapes\"
import { three_lights, turntable } from \"std/studio\"
tube { a: (0, 1, 0), b: (0, 1, 4), radius: 0.1 }
tube { a: (0, 0, 0), b: (0, 3, 0), radius: 10cm }
rounded_box { size: (1, 2, 3), radius: 0.1, position: (0, 1, 0) }
lathe { profile: [(0, 0), (0.5, 0), (0.2, 1), (0, 1)], segments: 16 }
frustum { below: 0.4, above: 0.2 }
three_lights { look_at: (0, 1, 0) }
turntable { position: (0, 1, 0) }",
    );
    let tubes: Vec<_> = scene.nodes.iter().filter(|node| matches!(node.shape, Some(Shape::Cylinder { .. }))).collect();
    for (node, middle, along) in
        [(tubes[0], DVec3::new(0.0, 1.0, 2.0), DVec3::Z), (tubes[1], DVec3::new(0.0, 1.5, 0.0), DVec3::Y)]
    {
        assert_eq!(node.placing.position.constant(), Some(&middle));
        assert!((*node.placing.rotation.constant().unwrap() * DVec3::Y - along).length() < 1e-9);
    }
}
