//! Which GPUs there are, and whether the kernel fits them.

use std::fmt;

use super::kernel::{OUTPUT_BUFFERS, SCENE_BUFFERS, WORKGROUP};
use crate::backend::BackendError;

/// An interface to GPUs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Api {
    /// Linux, Android, Windows.
    Vulkan,
    /// macOS.
    Metal,
    /// Direct3D 12: Windows.
    Dx12,
    /// OpenGL 4.3 or OpenGL ES 3.1: where there is nothing else.
    Gl,
}

impl Api {
    /// All, the preferred first.
    pub const ALL: [Api; 4] = [Api::Vulkan, Api::Metal, Api::Dx12, Api::Gl];

    /// Whether this program can ask for it on this system.
    pub fn is_built_in(self) -> bool {
        wgpu::Instance::enabled_backend_features().contains(self.backends())
    }

    fn backends(self) -> wgpu::Backends {
        match self {
            Api::Vulkan => wgpu::Backends::VULKAN,
            Api::Metal => wgpu::Backends::METAL,
            Api::Dx12 => wgpu::Backends::DX12,
            Api::Gl => wgpu::Backends::GL,
        }
    }
}

impl fmt::Display for Api {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Api::Vulkan => "Vulkan",
            Api::Metal => "Metal",
            Api::Dx12 => "Direct3D 12",
            Api::Gl => "OpenGL",
        })
    }
}

/// A GPU that wgpu found.
#[derive(Clone)]
pub struct Adapter {
    pub(super) wgpu: wgpu::Adapter,
    pub(super) info: wgpu::AdapterInfo,
    pub(super) limits: wgpu::Limits,
    /// How it is reached.
    pub api: Api,
}

impl Adapter {
    /// The device's name.
    pub fn name(&self) -> &str {
        &self.info.name
    }

    /// Name and API.
    pub fn label(&self) -> String {
        format!("{} ({})", self.info.name, self.api)
    }

    /// The driver's name and version.
    pub fn driver(&self) -> String {
        format!("{} {}", self.info.driver, self.info.driver_info).trim().to_owned()
    }

    /// Whether it is a program that computes on the CPU.
    pub fn is_software(&self) -> bool {
        matches!(self.info.device_type, wgpu::DeviceType::Cpu)
            || ["llvmpipe", "softpipe", "SwiftShader"].iter().any(|name| self.info.name.contains(name))
    }

    /// What the kernel asks of a device, each beside what this one allows.
    pub fn demands(&self) -> Vec<Demand> {
        let flags = self.wgpu.get_downlevel_capabilities().flags;
        let computes = flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS);
        let limits = &self.limits;
        // One stage sees all of them; params and dispatch may be storage too: see kernel.rs.
        let storage = SCENE_BUFFERS + OUTPUT_BUFFERS + if self.inlines_uniforms() { 2 } else { 0 };
        let demand = |what, needed: u32, allowed: u32| Demand { what, needed: needed.into(), allowed: allowed.into() };
        vec![
            demand("compute shaders", 1, computes.into()),
            demand("storage buffers a shader", storage, limits.max_storage_buffers_per_shader_stage),
            demand("bind groups", 2, limits.max_bind_groups),
            demand("workgroup width", WORKGROUP, limits.max_compute_workgroup_size_x),
            demand("workgroup height", WORKGROUP, limits.max_compute_workgroup_size_y),
            demand("invocations a workgroup", WORKGROUP * WORKGROUP, limits.max_compute_invocations_per_workgroup),
        ]
    }

    /// The largest array of a scene that it takes, in bytes.
    pub fn max_array_bytes(&self) -> u64 {
        max_array_bytes(&self.limits)
    }

    /// Workgroups of one dispatch along each axis.
    pub fn max_workgroups(&self) -> u32 {
        self.limits.max_compute_workgroups_per_dimension
    }

    /// # Errors
    /// The first demand that it does not meet.
    pub fn check(&self) -> Result<(), BackendError> {
        match self.demands().into_iter().find(|demand| demand.needed > demand.allowed) {
            None => Ok(()),
            Some(demand) => Err(BackendError::Unfit { adapter: self.label(), demand }),
        }
    }

    // Mesa's lavapipe compiles a pipeline again for the values that its uniform buffers hold at each dispatch, where
    // they decide a branch; the compiled code is never freed. (`update_inline_shader_state` in Mesa 22.3.)
    pub(super) fn inlines_uniforms(&self) -> bool {
        self.is_software() && self.api == Api::Vulkan
    }
}

/// Something that the kernel asks of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Demand {
    /// What.
    pub what: &'static str,
    /// How much of it.
    pub needed: u64,
    /// How much there is.
    pub allowed: u64,
}

pub(super) fn max_array_bytes(limits: &wgpu::Limits) -> u64 {
    limits.max_buffer_size.min(limits.max_storage_buffer_binding_size)
}

/// Every adapter of `api`, hardware before software.
pub fn adapters_of(api: Api) -> Vec<Adapter> {
    let backends = api.backends();
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = backends;
    let found = pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends));
    let adapter = |wgpu: wgpu::Adapter| Adapter { info: wgpu.get_info(), limits: wgpu.limits(), wgpu, api };
    let mut adapters: Vec<Adapter> = found.into_iter().map(adapter).collect();
    adapters.sort_by_key(|adapter| {
        let kind = match adapter.info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        (adapter.is_software(), kind)
    });
    adapters
}

/// The best adapter that runs the kernel, of `api` or of any, that is hardware if it must be.
pub(super) fn best(api: Option<Api>, hardware: bool) -> Result<Adapter, BackendError> {
    if hardware && !may_have_hardware() {
        return Err(BackendError::NoAdapter);
    }
    let mut error = None;
    let mut software = None;
    for api in Api::ALL.into_iter().filter(|a| api.is_none_or(|api| *a == api) && a.is_built_in()) {
        // OpenGL talks to the window system, and Mesa prints a complaint of its own where there is none.
        if api == Api::Gl && software.is_some() && !may_have_hardware() {
            break;
        }
        for adapter in adapters_of(api) {
            match adapter.check() {
                Err(unfit) => error = error.or(Some(unfit)),
                Ok(()) if !adapter.is_software() => return Ok(adapter),
                Ok(()) => software = software.or(Some(adapter)),
            }
        }
    }
    match software {
        Some(adapter) if !hardware => Ok(adapter),
        _ => Err(error.unwrap_or(BackendError::NoAdapter)),
    }
}

// On Linux a GPU is a device file; without one there is no need to load drivers, which takes longer than a small picture
// and lets Mesa complain on stderr where there is no session.
fn may_have_hardware() -> bool {
    const DEVICES: &[&str] = &["dri", "nvidia", "nvhost", "nvgpu", "dxg", "mali", "kgsl", "pvr"];
    if !cfg!(target_os = "linux") {
        return true;
    }
    let Ok(entries) = std::fs::read_dir("/dev") else { return true };
    entries.flatten().any(|entry| {
        let name = entry.file_name();
        DEVICES.iter().any(|device| name.to_string_lossy().starts_with(device))
    })
}
