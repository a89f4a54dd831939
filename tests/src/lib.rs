//! What the end-to-end tests share.

/// A GPU device, a software one if need be, with the adapter's own limits; `None` where the machine has no adapter and
/// `KINORA_NO_GPU=1` says that this is known.
///
/// # Panics
/// Where no adapter is found, or it gives no device, and `KINORA_NO_GPU` is not 1: a test that silently tests nothing is
/// worse than one that fails.
pub fn gpu() -> Option<(wgpu::Device, wgpu::Queue)> {
    if std::env::var_os("KINORA_NO_GPU").is_some_and(|value| value == "1") {
        return None;
    }
    // Not OpenGL: Mesa's software OpenGL had not run the construct tests after a minute, its software Vulkan needs seconds.
    let backends = wgpu::Backends::PRIMARY;
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let instance = wgpu::Instance::new(descriptor);
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
        .expect("no GPU adapter: install mesa-vulkan-drivers, or set KINORA_NO_GPU=1 to do without");
    let descriptor = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
    Some(pollster::block_on(adapter.request_device(&descriptor)).expect("the GPU adapter gives no device"))
}
