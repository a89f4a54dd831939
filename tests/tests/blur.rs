//! Motion blur: what pixels show of the time that the shutter is open, in closed form, on every backend.

use glam::Vec3;
use kinora_lang::files::Memory;
use kinora_renderer::{Choice, Film, Options, Renderer, Request, Window, open};
use kinora_scene::World;
use kinora_tests::world_at;

const SIZE: u32 = 64;

/// The world of frame 1, which lasts from 1 s to 2 s: 64 × 64 pixels of 64 samples show 2 m × 2 m, black but for `scene`.
fn world(render: &str, scene: &str) -> World {
    let text = format!(
        "lang 1\nrender {{ resolution: ({SIZE}, {SIZE}), filter: box, fps: 1, duration: 2s, shutter: 360deg, \
         {render} }}\n{scene}"
    );
    world_at(&text, &Memory::default(), 1)
}

const CAMERA: &str = "camera { projection: orthographic, height: 2m, position: (0, 0, 5) }\n";

fn draw(world: &World, choice: Choice) -> Film {
    let mut renderer = Renderer::new(open(choice, Options::default()).expect("the backend opens"));
    renderer.render(world, &()).expect("it renders")
}

fn choices() -> Vec<Choice> {
    let no_gpu = std::env::var_os("KINORA_NO_GPU").is_some_and(|value| value == "1");
    if no_gpu { vec![Choice::Cpu] } else { vec![Choice::Cpu, Choice::Gpu] }
}

/// Compares the means of patches of 4 × 4 pixels with the truth at their middles, in metres.
#[track_caller]
fn check(world: &World, tolerance: f32, truth: impl Fn(f32, f32) -> Option<f32>) {
    assert!(world.moments.len() > 1, "nothing moves");
    for choice in choices() {
        let mean = draw(world, choice).mean();
        let mut compared = 0;
        for y in (0..SIZE).step_by(4) {
            for x in (0..SIZE).step_by(4) {
                let metres = |p: u32| (p as f32 + 2.0) / SIZE as f32 * 2.0 - 1.0;
                let Some(expected) = truth(metres(x), -metres(y)) else { continue };
                let pixels = (0..16).map(|i| mean[((y + i / 4) * SIZE + x + i % 4) as usize].x);
                let got = pixels.sum::<f32>() / 16.0;
                assert!((got - expected).abs() < tolerance, "{choice:?} at {x}, {y}: {got}, expected {expected}");
                compared += 1;
            }
        }
        assert!(compared > 20, "{compared} patches");
    }
}

/// A square lamp of 0.5 m goes from x = −0.5 to 0.5 m: the share of the time that it covers x, times 2.
fn streak(x: f32, y: f32) -> Option<f32> {
    let edge = (y.abs() - 0.25).abs() < 0.1 || (x.abs() - 0.75).abs() < 0.1;
    let covered = (0.5_f32.min(x + 0.25) - (-0.5_f32).max(x - 0.25)).clamp(0.0, 0.5);
    (!edge).then_some(if y.abs() < 0.25 { 2.0 * covered } else { 0.0 })
}

const LAMP: &str = "normal: (0, 0, 1), size: (0.5, 0.5), material: emitter { radiance: 2W/m^2/sr }";

#[test]
fn a_square_leaves_a_streak() {
    let moving = format!("quad {{ position: ((time / 1s - 1.5) * 1m, 0, 0), {LAMP} }}");
    check(&world("samples: 64", &format!("{CAMERA}{moving}")), 0.03, streak);
    check(&world("samples: 12", &format!("{CAMERA}{moving}")), 0.12, streak);
    // The same seen by a camera that moves the other way, and of a copy.
    let camera = "camera { projection: orthographic, height: 2m, position: ((1.5 - time / 1s) * 1m, 0, 5) }\n";
    check(&world("samples: 64", &format!("{camera}quad {{ {LAMP} }}")), 0.03, streak);
    let copy = format!(
        "quad lamp {{ visible: false, {LAMP} }}\ninstance {{ of: lamp, position: ((time / 1s - 1.5) * 1m, 0, 0) }}"
    );
    check(&world("samples: 64", &format!("{CAMERA}{copy}")), 0.03, streak);
    // Pixels that stop early see all of the time too.
    check(&world("samples: 512, adaptive: 5%", &format!("{CAMERA}{moving}")), 0.04, streak);
}

#[test]
fn what_turns_runs_on_an_arc() {
    // A rod from the origin to 0.9 m turns by 170°: of the half disk above, a share in proportion to how wide it is there.
    let rod = "box { size: (0.9, 0.06, 0.06), position: (0.45, 0, 0), material: emitter { } }";
    let turning = format!("{CAMERA}group {{ rotation: rotate_z((time / 1s - 1) * 170deg)\n{rod} }}");
    check(&world("samples: 64", &turning), 0.03, |x, y| {
        let (r, angle) = (x.hypot(y), y.atan2(x).to_degrees());
        let inside = (0.3..0.8).contains(&r) && (12.0..158.0).contains(&angle);
        let outside = r > 1.0 || (-150.0..-30.0).contains(&angle) && r > 0.2;
        let share = 2.0 * (0.03 / r).asin().to_degrees() / 170.0;
        if inside { Some(share) } else { outside.then_some(0.0) }
    });
    // Three whole turns are an even disk.
    let spinning = format!("{CAMERA}group {{ rotation: rotate_z(time / 1s * 1080deg)\n{rod} }}");
    check(&world("samples: 64", &spinning), 0.04, |x, y| {
        let r = x.hypot(y);
        let share = 2.0 * (0.03 / r).asin().to_degrees() / 360.0;
        if (0.3..0.8).contains(&r) { Some(share) } else { (r > 1.0).then_some(0.0) }
    });
}

#[test]
fn what_changes_is_averaged() {
    let whole = |scene: &str, expected: f32| {
        check(&world("samples: 64", &format!("{CAMERA}{scene}")), 0.02, |_, _| Some(expected));
    };
    let wall = |material: &str| format!("quad {{ normal: (0, 0, 1), size: (4, 4), material: {material} }}");
    whole(&wall("emitter { radiance: keys { 1s: 0W/m^2/sr  2s: 1W/m^2/sr } }"), 0.5);
    whole(
        &format!(
            "sky {{ color: #fff, strength: (time / 1s - 1) ^ 2 }}\n{}",
            wall("diffuse { color: linear(1, 1, 1) }")
        ),
        1.0 / 3.0,
    );
    // Seen for a quarter of the time.
    whole("quad { normal: (0, 0, 1), size: (4, 4), visible: time < 1.25s, material: emitter { } }", 0.25);
}

#[test]
fn a_crop_has_the_pixels_of_the_whole() {
    for render in ["samples: 8", "samples: 64", "samples: 256, adaptive: 10%"] {
        let moving = format!("quad {{ position: ((time / 1s - 1.5) * 1m, 0, 0), {LAMP} }}");
        let w = world(render, &format!("{CAMERA}{moving}"));
        let whole = draw(&w, Choice::Cpu).mean();
        let window = Window { left: 11, top: 20, width: 30, height: 9 };
        let request = Request { crop: Some(window), layers: true, ..Request::default() };
        let mut renderer = Renderer::new(open(Choice::Cpu, Options { threads: 1, checks: true }).expect("it opens"));
        let part = renderer.render_for(&w, &request, &()).expect("it renders");
        for (i, pixel) in part.mean().iter().enumerate() {
            let (x, y) = (i as u32 % 30 + 11, i as u32 / 30 + 20);
            assert_eq!(*pixel, whole[(y * SIZE + x) as usize], "{render} at {x}, {y}");
        }
        // Layers are means over the time, too: of what covers half of a pixel's time, half.
        let seen = part.seen(4 * 30 + 15).expect("layers");
        assert!((seen.cover - 0.5).abs() < 0.1 && seen.normal.abs_diff_eq(0.5 * Vec3::Z, 0.1), "{seen:?}");
    }
}

#[test]
fn what_stands_still_has_no_moments() {
    let w = world(
        "samples: 64",
        &format!("{CAMERA}quad {{ {LAMP} }}\nsphere {{ visible: false, radius: (1 + time / 1s) * 1m }}"),
    );
    assert_eq!(w.moments.len(), 0);
}
