//! Every backend passes the same suite.

use kinora_renderer::backend::{Backend, BackendError};
use kinora_renderer::{Film, Renderer, Request, cpu::Cpu, gpu::Gpu, suite};

#[test]
fn cpu() {
    suite::run(&|| Box::new(Cpu::new(0).expect("threads start")) as Box<dyn Backend>);
}

#[test]
fn gpu() {
    match Gpu::any() {
        Ok(_) => suite::run(&|| Box::new(Gpu::any().expect("the GPU opens again")) as Box<dyn Backend>),
        Err(BackendError::NoAdapter) if std::env::var_os("KINORA_NO_GPU").is_some_and(|v| v == "1") => {}
        Err(error) => panic!("{error}; install Mesa's mesa-vulkan-drivers, or set KINORA_NO_GPU=1"),
    }
}

#[test]
fn both_see_the_same_surfaces() {
    let Ok(gpu) = Gpu::any() else { return };
    let mut world = suite::all_kinds();
    world.render.resolution = [160, 96];
    let survey = |backend: Box<dyn Backend>| -> Film {
        let request = Request { crop: None, layers: true };
        Renderer::new(backend).render_for(&world, &request, &()).expect("renders")
    };
    let (cpu, gpu) = (survey(Box::new(Cpu::new(0).expect("threads start"))), survey(Box::new(gpu)));
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
    // Normals are means: a sample that falls on the other side of an edge moves them.
    let apart = |i: &usize| match (cpu.seen(*i), gpu.seen(*i)) {
        (Some(a), Some(b)) => a.id == b.id && (a.normal - b.normal).abs().max_element() > 1e-4,
        _ => true,
    };
    let off = (0..count).filter(apart).count();
    assert!(off * 1000 <= count, "{off} of {count} normals differ");
}

/// However many paths a thread shades at once, the film has the same bits.
#[test]
fn cpu_widths() {
    let world = suite::all_kinds();
    let film = |width: Width| {
        let cpu = Cpu::new(0).expect("threads start").with_width(width);
        Renderer::new(Box::new(cpu)).render(&world, &()).expect("the world renders")
    };
    let one = film(Width::One);
    for width in [Width::Eight, Width::Sixteen].into_iter().filter(|width| width.is_here()) {
        let many = film(width);
        assert!(many == one, "{width:?} shows another picture");
    }
}
