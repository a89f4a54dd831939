//! Colours that are computed at a point, read off the pixels of what reflects an even sky: each shows its own colour. What
//! is expected is computed here, in f64.

use glam::{DQuat, DVec2, DVec3};
use kinora_renderer::Choice;
use kinora_scene::{World, cellular_noise, gradient_noise};
use kinora_tests::measure::Kernel;
use kinora_tests::world;

/// A picture of what is 2 m wide and lies about z = 0, each pixel a point in its middle.
const HEAD: &str = "lang 1
render { resolution: (8, 8), filter: box, filter_width: 0.000001, samples: 1, max_bounces: 1 }
camera { position: (0, 0, 10), look_at: (0, 0, 0), projection: orthographic, height: 2 }
sky { color: linear(1, 1, 1) }
";
const QUAD: &str = "quad { normal: (0, 0, 1), size: (2, 2), material: m }\n";
/// A number as a colour within 0..1.
const LEVEL: &str = "fn level(x: float) -> color = linear(0.5 + x / 20, 0.5 + x / 20, 0.5 + x / 20)\n";

/// The middles of the pixels, row by row from the top.
fn pixels() -> impl Iterator<Item = DVec2> {
    let at = |i: u32| -1.0 + (f64::from(i) + 0.5) / 4.0;
    (0..64).map(move |i| DVec2::new(at(i % 8), -at(i / 8)))
}

/// Renders on every backend and compares each pixel's first channel, or where the second is set, all three.
fn check(name: &str, world: &World, tolerance: f64, expected: impl Fn(DVec2) -> DVec3) {
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut gpu = Kernel::gpu();
    for (backend, kernel) in [("cpu", Some(&mut cpu)), ("gpu", gpu.as_deref_mut())] {
        let Some(kernel) = kernel else { continue };
        for (got, at) in kernel.picture(world).iter().zip(pixels()) {
            let expected = expected(at);
            let off = (got - expected).abs().max_element();
            assert!(off < tolerance, "{backend}, {name} at {at}: {got}, expected {expected}");
        }
    }
}

fn level(x: f64) -> DVec3 {
    DVec3::splat(0.5 + x / 20.0)
}

#[test]
fn functions() {
    type Case = (&'static str, fn(f64, f64) -> f64);
    // x and y are the point's coordinates in metres.
    let cases: &[Case] = &[
        ("x + 2 * y - x * y / 3", |x, y| x + 2.0 * y - x * y / 3.0),
        ("-x ^ 2 + y ^ 3", |x, y| -x * x + y * y * y),
        ("abs(y) ^ 1.5 + (2 + x) ^ y", |x, y| y.abs().powf(1.5) + (2.0 + x).powf(y)),
        ("mod(3 * x, 0.7) + mod(y, -0.4)", |x, y| (3.0 * x).rem_euclid(0.7) - (-y).rem_euclid(0.4)),
        ("floor(3 * x) + 0.1 * ceil(3 * y)", |x, y| (3.0 * x).floor() + 0.1 * (3.0 * y).ceil()),
        ("round(3 * x) + 0.1 * sign(y)", |x, y| (3.0 * x).round() + 0.1 * y.signum()),
        ("sqrt(abs(x)) + exp(y) + log(2 + x)", |x, y| x.abs().sqrt() + y.exp() + (2.0 + x).ln()),
        ("sin(20 * x) + cos(3 * y) + tan(x)", |x, y| (20.0 * x).sin() + (3.0 * y).cos() + x.tan()),
        ("sin(2000 * x)", |x, _| (2000.0 * x).sin()),
        ("(asin(x) + acos(y) + atan(3 * x)) / 1rad", |x, y| x.asin() + y.acos() + (3.0 * x).atan()),
        ("atan2(y, x) / 1rad", |x, y| y.atan2(x)),
        ("min(x, y, 0.3) + max(x, -y)", |x, y| x.min(y).min(0.3) + x.max(-y)),
        ("if x + 0.1 < y && y > 0 || floor(4 * x) == 1 { 3 } else { -3 }", |x, y| {
            if x + 0.1 < y && y > 0.0 || (4.0 * x).floor() == 1.0 { 3.0 } else { -3.0 }
        }),
        ("if !(x <= 0.1) { x } else { if y >= 0.2 { y } else { 5 } }", |x, y| {
            if x > 0.1 {
                x
            } else if y >= 0.2 {
                y
            } else {
                5.0
            }
        }),
        ("smoothstep(-0.5, 0.5, x) + step(0.2, y) + mix(x, y, 0.3) + clamp(x, -0.1, 0.2)", |x, y| {
            let t = (x + 0.5).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t) + f64::from(u8::from(y >= 0.2)) + x + 0.3 * (y - x) + x.clamp(-0.1, 0.2)
        }),
        ("length((x, y)) + dot((x, y), (3, 1)) + normalize((x, y, 1)).z", |x, y| {
            DVec2::new(x, y).length() + 3.0 * x + y + DVec3::new(x, y, 1.0).normalize().z
        }),
        ("(rotate_z(30deg) * (x, y, 0)).x + cross((x, y, 1), (0, 1, 0)).z", |x, y| {
            (DQuat::from_rotation_z(30_f64.to_radians()) * DVec3::new(x, y, 0.0)).x + x
        }),
        ("5 * noise((4 * x, 4 * y, 0.3))", |x, y| 5.0 * gradient_noise([4.0 * x, 4.0 * y, 0.3])),
        ("5 * noise(p * 7)", |x, y| 5.0 * gradient_noise([7.0 * x, 7.0 * y, 0.0])),
        ("5 * fbm((3 * x, y, 1.5), octaves: 4, gain: 0.6, lacunarity: 2.2)", |x, y| {
            let octave = |i: i32| {
                let f = 2.2_f64.powi(i);
                0.6_f64.powi(i) * gradient_noise([3.0 * x * f, y * f, 1.5 * f])
            };
            5.0 * (0..4).map(octave).sum::<f64>() / (0..4).map(|i| 0.6_f64.powi(i)).sum::<f64>()
        }),
        ("5 * cell((4 * x, 4 * y, 0.3)) + cell_id((4 * x, 4 * y, 0.3))", |x, y| {
            let [distance, id] = cellular_noise([4.0 * x, 4.0 * y, 0.3], 3);
            5.0 * distance + id
        }),
        ("5 * cell((4 * x, 4 * y)) + cell(7 * x) + cell_id(7 * x)", |x, y| {
            let line = cellular_noise([7.0 * x, 0.0, 0.0], 1);
            5.0 * cellular_noise([4.0 * x, 4.0 * y, 0.0], 2)[0] + line[0] + line[1]
        }),
    ];
    for (text, expected) in cases {
        let function = format!("fn f(x: float, y: float) -> float = {text}\n");
        let text = format!("{HEAD}{LEVEL}{QUAD}{function}diffuse m {{ color: level(f(p.x / 1m, p.y / 1m)) }}");
        check(&text, &world(&text), 3e-5, |at| level(expected(at.x, at.y)));
    }
}

#[test]
fn colours() {
    let srgb = |x: f64| if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
    let text = format!("{HEAD}{QUAD}diffuse m {{ color: srgb(uv.x, uv.y, 0.5) }}");
    check("srgb", &world(&text), 1e-5, |at| DVec3::new(srgb(0.5 + 0.5 * at.x), srgb(0.5 + 0.5 * at.y), srgb(0.5)));
    let text = format!("{HEAD}{QUAD}diffuse m {{ color: mix(linear(1, 0, 0), linear(0, 0.5, 1), uv.x) * uv.y }}");
    check("mix", &world(&text), 1e-5, |at| {
        let t = 0.5 + 0.5 * at.x;
        DVec3::new(1.0 - t, 0.5 * t, t) * (0.5 + 0.5 * at.y)
    });
    // A hue that runs round twice: at whole sixths of it the channels are 0 or 1.
    let text = format!("{HEAD}{QUAD}diffuse m {{ color: hsv(turn(uv.x * 4 + 1 / 12), 100%, 100%) }}");
    check("hsv", &world(&text), 2e-4, |at| {
        let hue = (0.5 + 0.5 * at.x) * 4.0 + 1.0 / 12.0;
        DVec3::new(5.0, 3.0, 1.0).map(|n| {
            let k = (n + hue * 6.0).rem_euclid(6.0);
            srgb(1.0 - k.min(4.0 - k).clamp(0.0, 1.0))
        })
    });
    // Squares of two computed colours.
    let text = format!("{HEAD}{QUAD}diffuse m {{ color: checker(linear(uv.x, 0, 0), linear(0, uv.y, 0), scale: 4) }}");
    check("checker", &world(&text), 1e-5, |at| {
        let uv = 0.5 + 0.5 * at;
        let odd = (uv * 4.0).floor().element_sum() % 2.0 != 0.0;
        if odd { DVec3::new(0.0, uv.y, 0.0) } else { DVec3::new(uv.x, 0.0, 0.0) }
    });
    // What leaves 0..1 is held there, and what is no number is 0.
    let text = format!("{HEAD}{QUAD}diffuse m {{ color: linear(3 * p.x / 1m, sqrt(p.y / 1m), log(0 * p.x / 1m)) }}");
    check("out of range", &world(&text), 1e-5, |at| {
        DVec3::new((3.0 * at.x).clamp(0.0, 1.0), if at.y < 0.0 { 0.0 } else { at.y.sqrt() }, 0.0)
    });
}

#[test]
fn what_is_known_of_the_point() {
    // A board that is scaled, turned and moved in a group.
    let placed = "group { position: (0.1, 0.2, 0), rotation: rotate_z(90deg)
        group { scale: (2, 1, 1), quad { normal: (0, 0, 1), size: (4, 8), position: (0.1, 0, 0), material: m } } }\n";
    let color = |of: &str| format!("{HEAD}diffuse m {{ color: linear({of}) }}\n");
    let world_point = "0.5 + p.x / 4m, 0.5 + p.y / 4m, 0.5 + p.z / 4m";
    check("p", &world(&(color(world_point) + placed)), 1e-5, |at| (at / 4.0).extend(0.0) + 0.5);
    let local = "0.5 + p_local.x / 8m, 0.5 + p_local.y / 8m, 0.5 + p_local.z / 8m";
    check("p_local", &world(&(color(local) + placed)), 1e-5, |at| {
        let q = at - DVec2::new(0.1, 0.2);
        // Turned back by 90 degrees, then scaled and moved back.
        (DVec2::new(q.y / 2.0 - 0.1, -q.x) / 8.0).extend(0.0) + 0.5
    });
    // Of copies, the copied shape's own.
    let copies = "quad tile { normal: (0, 0, 1), size: (1, 2), position: (-0.5, 0, 0), material: m }
        instance { of: tile, position: (1, 0, 0) }\n";
    check("p_local of an instance", &world(&(color(local) + copies)), 1e-5, |at| {
        (DVec2::new(at.x + if at.x < 0.0 { 0.5 } else { -0.5 }, at.y) / 8.0).extend(0.0) + 0.5
    });
    let facing = "0.5 + normal.x / 2, 0.5 + normal.y / 2, 0.5 + normal.z / 2";
    let ball = "sphere { radius: 2, material: m }\n";
    check("normal", &world(&(color(facing) + ball)), 1e-5, |at| {
        let normal = at.extend((4.0 - at.length_squared()).sqrt()) / 2.0;
        0.5 + normal / 2.0
    });
    let file = "mesh { positions: [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], indices: [0, 1, 2, 0, 2, 3],
        scale: 2, position: (0.5, 0, 0), material: m }\n";
    check("p_local of a mesh", &world(&(color(local) + file)), 1e-5, |at| {
        ((at - DVec2::new(0.5, 0.0)) / 16.0).extend(0.0) + 0.5
    });
}

#[test]
fn ratios_and_light() {
    // Opacity: what is behind shows through.
    let behind =
        "quad { position: (0, 0, -1), normal: (0, 0, 1), size: (4, 4), material: emitter { radiance: 3W/m^2/sr } }";
    let head = HEAD.replace("samples: 1,", "samples: 4096,");
    let text =
        format!("{head}{QUAD}{behind}\ndiffuse m {{ color: #000, opacity: if p.x > 0 {{ uv.y }} else {{ 1 }} }}");
    check("opacity", &world(&text), 0.12, |at| DVec3::splat(if at.x > 0.0 { 3.0 * (0.5 - 0.5 * at.y) } else { 0.0 }));
    // The amount of a mixture.
    let text = format!(
        "{head}diffuse a {{ color: #000 }}\ndiffuse b {{ color: linear(1, 1, 1) }}
quad {{ normal: (0, 0, 1), size: (2, 2), material: mix(a, b, amount: uv.x) }}"
    );
    check("amount", &world(&text), 0.04, |at| DVec3::splat(0.5 + 0.5 * at.x));
    let text = format!("{HEAD}{QUAD}emitter m {{ color: linear(uv.x, uv.y, 0), radiance: 5W/m^2/sr }}");
    check("emitter", &world(&text), 1e-5, |at| DVec3::new(2.5 + 2.5 * at.x, 2.5 + 2.5 * at.y, 0.0));
    // Its radiance, alone and times a colour that differs as well; below 0 there is no light.
    let text = format!("{HEAD}{QUAD}emitter m {{ radiance: 4W/m^2/sr * p.x / 1m }}");
    check("radiance", &world(&text), 1e-5, |at| DVec3::splat((4.0 * at.x).max(0.0)));
    let text = format!("{HEAD}{QUAD}emitter m {{ color: linear(1, uv.y, 2), radiance: 5W/m^2/sr * uv.x }}");
    check("radiance and colour", &world(&text), 1e-5, |at| {
        let radiance = 2.5 + 2.5 * at.x;
        DVec3::new(radiance, radiance * (0.5 + 0.5 * at.y), 2.0 * radiance)
    });
}

/// A lamp whose light is computed lights a floor as the same lamp of parts does.
#[test]
fn lamps() {
    let floor = "render { resolution: (8, 8), samples: 512, max_bounces: 1, filter: box, filter_width: 1 }
camera { position: (0, 0, 10), look_at: (0, 0, 0), projection: orthographic, height: 2 }
quad { normal: (0, 0, 1), size: (4, 4), material: diffuse { } }\n";
    let whole = "quad { position: (0, 0, 12), normal: (0, 0, -1), size: (10, 10)
        material: emitter { color: if p.x > 0 { linear(9, 1, 1) } else { linear(0, 0, 0) } } }";
    let half = "quad { position: (2.5, 0, 12), normal: (0, 0, -1), size: (5, 10)
        material: emitter { color: linear(9, 1, 1) } }";
    let mut cpu = Kernel::open(Choice::Cpu);
    let mut mean = |lamp: &str| {
        let picture = cpu.picture(&world(&format!("lang 1\n{floor}{lamp}")));
        picture.iter().sum::<DVec3>() / 64.0
    };
    let radiant = "quad { position: (0, 0, 12), normal: (0, 0, -1), size: (10, 10)
        material: emitter { color: linear(9, 1, 1), radiance: 1W/m^2/sr * step(0, p.x / 1m) } }";
    let radiant = mean(radiant);
    let (whole, half) = (mean(whole), mean(half));
    assert!((radiant - half).abs().max_element() < 0.02 * half.x, "{radiant} {half}");
    assert!((whole - half).abs().max_element() < 0.02 * half.x, "{whole} {half}");
}

/// What moves is computed once a frame, the rest at every point.
#[test]
fn time() {
    let text = format!(
        "{HEAD}{QUAD}let rise = keys {{ 0s: 0  4s: 0.5 }}
diffuse m {{ color: linear(uv.x * time / 4s, 0.25 + rise * uv.y, 0) }}"
    );
    let text = text.replace("render {", "render { fps: 1, duration: 4s,");
    let source = kinora_lang::source::Source::new(kinora_lang::source::FileId(0), "a.kin", text.as_str());
    let files = kinora_lang::files::Memory::default();
    let evaluated = kinora_lang::eval(&kinora_lang::parse(&source), &files, &Default::default()).expect("a scene");
    for frame in [0, 1, 3] {
        let scene = &evaluated.scene;
        let world = kinora_animator::sample(scene, scene.clock.shutter_of(frame)).expect("a world");
        let share = frame as f64 / 4.0;
        check(&format!("frame {frame}"), &world, 1e-5, |at| {
            let uv = 0.5 + 0.5 * at;
            DVec3::new(uv.x * share, 0.25 + 0.5 * share * uv.y, 0.0)
        });
    }
}
