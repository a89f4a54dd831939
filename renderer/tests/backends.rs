//! Every backend passes the same suite; a GPU through each API that computes on this system.

use glam::Vec3;
use kinora_kernel::lanes::Width;
use kinora_renderer::cpu::Cpu;
use kinora_renderer::gpu::{Api, adapters_of};
use kinora_renderer::{Backend, Film, Renderer, Request};
use kinora_renderer::{BackendError, Choice, Options, SELF_TEST_TOLERANCE, open, self_test, suite};

fn without_gpu() -> bool {
    std::env::var_os("KINORA_NO_GPU").is_some_and(|v| v == "1")
}

fn check(choice: Choice, packages: &str) {
    let backend = |checks| open(choice, Options { checks, ..Options::default() });
    match backend(true) {
        Ok(backend) => suite::run(backend),
        Err(BackendError::NoAdapter) if without_gpu() => return,
        Err(error) => panic!("{choice:?}: {error}; install Mesa's {packages}, or set KINORA_NO_GPU=1"),
    }
    // What the checks look for is not there: without them the picture is the same.
    let [with, without] = [true, false].map(|checks| {
        let backend = backend(checks).expect("it opens again");
        self_test(backend).expect("the self-test runs")
    });
    assert!(with > 0.0 && with < SELF_TEST_TOLERANCE, "{choice:?}: {with}");
    assert_eq!(with, without, "{choice:?}");
}

#[test]
fn cpu() {
    check(Choice::Cpu, "");
}

#[test]
fn gpu() {
    check(Choice::Gpu, "mesa-vulkan-drivers");
}

#[test]
#[cfg(target_os = "linux")]
fn opengl() {
    check(Choice::Api(Api::Gl), "libegl1 and libgl1-mesa-dri");
}

#[test]
fn an_api_of_another_system() {
    let foreign = if cfg!(target_os = "macos") { Api::Dx12 } else { Api::Metal };
    assert!(adapters_of(foreign).is_empty());
    assert_eq!(open(Choice::Api(foreign), Options::default()).err(), Some(BackendError::NoAdapter));
}

#[test]
fn every_adapter_says_what_it_lacks() {
    for adapter in Api::ALL.into_iter().flat_map(adapters_of) {
        let lacks = adapter.demands().iter().any(|demand| demand.needed > demand.allowed);
        assert_eq!(adapter.check().is_err(), lacks, "{}", adapter.label());
        assert!(adapter.max_array_bytes() >= 1 << 20, "{}", adapter.label());
    }
}

#[test]
fn both_see_the_same_surfaces() {
    let opened = |choice| open(choice, Options::default());
    let gpu = match opened(Choice::Gpu) {
        Ok(gpu) => gpu,
        Err(BackendError::NoAdapter) if without_gpu() => return,
        Err(error) => panic!("{error}"),
    };
    let mut world = suite::all_kinds();
    world.render.resolution = [160, 96];
    let survey = |backend: Box<dyn Backend>| -> Film {
        let request = Request { layers: true, parts: true, ..Request::default() };
        Renderer::new(backend).render_for(&world, &request, &()).expect("renders")
    };
    let (cpu, gpu) = (survey(opened(Choice::Cpu).expect("threads start")), survey(gpu));
    let count = 160 * 96;
    let mut same = 0;
    for i in 0..count {
        let (a, b) = (cpu.seen(i).expect("a layer"), gpu.seen(i).expect("a layer"));
        if a.id != b.id {
            continue;
        }
        same += 1;
        assert!((a.depth - b.depth).abs() <= 1e-4 * a.depth.abs().max(1.0), "pixel {i}: {a:?}, {b:?}");
        assert!((a.position - b.position).abs().max_element() <= 1e-4 * a.depth.max(1.0), "pixel {i}: {a:?}, {b:?}");
    }
    assert!(same * 1000 >= count * 999, "{same} of {count} pixels show the same");
    // Of light only the mean: a path that goes another way brings another.
    let sum = |film: &Film| {
        let light = (0..count).map(|i| film.parts(i).expect("a layer"));
        light.fold([Vec3::ZERO; 4], |sum, light| {
            let parts = [light.emission, light.diffuse, light.specular, light.variance];
            std::array::from_fn(|k| sum[k] + parts[k])
        })
    };
    for (a, b) in sum(&cpu).into_iter().zip(sum(&gpu)) {
        assert!((a - b).abs().max_element() < 0.01 * a.max_element(), "{a} and {b}");
    }
    // Normals are means: a sample that falls on the other side of an edge moves them.
    let apart = |i: &usize| match (cpu.seen(*i), gpu.seen(*i)) {
        (Some(a), Some(b)) => a.id == b.id && (a.normal - b.normal).abs().max_element() > 1e-4,
        _ => true,
    };
    let off = (0..count).filter(apart).count();
    assert!(off * 1000 <= count, "{off} of {count} normals differ");
}

/// However many paths a thread shades at once, the film has the same bits; and whole light those of its parts.
#[test]
fn cpu_widths() {
    let world = suite::all_kinds();
    let film = |width: Width, parts: bool| {
        let cpu = Cpu::new(0).expect("threads start").with_width(width);
        let request = Request { parts, ..Request::default() };
        Renderer::new(Box::new(cpu)).render_for(&world, &request, &()).expect("the world renders")
    };
    let one = film(Width::One, true);
    assert!(film(Width::One, false).mean() == one.mean(), "in parts the picture is another");
    for width in [Width::Eight, Width::Sixteen].into_iter().filter(|width| width.is_here()) {
        for parts in [false, true] {
            let many = film(width, parts);
            let same = if parts { many == one } else { many.mean() == one.mean() };
            assert!(same, "{width:?} shows another picture");
        }
    }
}
