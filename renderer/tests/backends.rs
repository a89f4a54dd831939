//! Every backend passes the same suite.

use kinora_renderer::backend::{Backend, BackendError};
use kinora_renderer::{cpu::Cpu, gpu::Gpu, suite};

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
