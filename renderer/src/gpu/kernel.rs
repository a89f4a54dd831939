//! The kernel's text as one device compiles it, and its entry points as pipelines. All of them read the scene through
//! one bind group; what an entry writes is in a group of its own.

use std::collections::HashMap;

use kinora_kernel::WGSL;

/// Pixels of a workgroup's side, as `entry/` declares.
pub const WORKGROUP: u32 = 8;
/// Storage buffers of a scene: all of group 0 but `params`.
pub const SCENE_BUFFERS: u32 = 7;
/// Storage buffers that an entry writes: all of group 1 but `dispatch`.
pub const OUTPUT_BUFFERS: u32 = 1;

/// The shader as text: what does not change while a scene is shown is written into it.
struct Source {
    /// Uniform buffers are declared as storage buffers.
    storage_only: bool,
}

impl Source {
    fn text(&self, features: u32) -> String {
        // What a scene does not use costs registers everywhere, and time where a branch not taken is run all the same.
        let text = WGSL.replace("params.features", &format!("{features}u"));
        match self.storage_only {
            true => text.replace("var<uniform>", "var<storage, read>"),
            false => text,
        }
    }
}

/// The kernel on one device.
pub struct Kernel {
    source: Source,
    checks: bool,
    scene: wgpu::BindGroupLayout,
    output: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    modules: HashMap<u32, wgpu::ShaderModule>,
    pipelines: HashMap<(&'static str, u32), wgpu::ComputePipeline>,
}

impl Kernel {
    /// Nothing is compiled yet. `storage_only`: uniform buffers become storage buffers; `checks`: naga's runtime checks.
    pub fn new(device: &wgpu::Device, storage_only: bool, checks: bool) -> Self {
        let constants = match storage_only {
            true => wgpu::BufferBindingType::Storage { read_only: true },
            false => wgpu::BufferBindingType::Uniform,
        };
        let group = |label, others: u32, read_only| {
            let types =
                std::iter::once(constants).chain((0..others).map(|_| wgpu::BufferBindingType::Storage { read_only }));
            let entries: Vec<_> = (0..).zip(types).map(|(binding, ty)| entry(binding, ty)).collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let scene = group("scene", SCENE_BUFFERS, true);
        let output = group("output", OUTPUT_BUFFERS, false);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("kernel"),
            bind_group_layouts: &[Some(&scene), Some(&output)],
            immediate_size: 0,
        });
        let source = Source { storage_only };
        Self { source, checks, scene, output, layout, modules: HashMap::new(), pipelines: HashMap::new() }
    }

    /// How `params` and `dispatch` are used.
    pub fn constants_usage(&self) -> wgpu::BufferUsages {
        match self.source.storage_only {
            true => wgpu::BufferUsages::STORAGE,
            false => wgpu::BufferUsages::UNIFORM,
        }
    }

    /// Group 0, in the order of `scene.wgsl`.
    pub fn bind_scene(&self, device: &wgpu::Device, buffers: &[wgpu::Buffer]) -> wgpu::BindGroup {
        bind(device, &self.scene, buffers)
    }

    /// Group 1: `dispatch`, then what an entry writes.
    pub fn bind_output(&self, device: &wgpu::Device, buffers: &[wgpu::Buffer]) -> wgpu::BindGroup {
        bind(device, &self.output, buffers)
    }

    /// Entry point `entry` for scenes with these features (`Params::features`), compiled when first asked for.
    pub fn pipeline(&mut self, device: &wgpu::Device, entry: &'static str, features: u32) -> &wgpu::ComputePipeline {
        let Self { source, checks, layout, modules, pipelines, .. } = self;
        pipelines.entry((entry, features)).or_insert_with(|| {
            let module = modules.entry(features).or_insert_with(|| compile(device, source.text(features), *checks));
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(layout),
                module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: false,
                    ..Default::default()
                },
                cache: None,
            })
        })
    }
}

fn entry(binding: u32, ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

fn bind(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, buffers: &[wgpu::Buffer]) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

// The shader is ours, and so are its inputs: every index in the arrays of a scene was checked when they were uploaded
// (`Packed::validate`), all loops end, and nothing is divided by an integer 0. Checking that again for every access on
// the device costs up to 100 times the time where loops are many.
#[allow(unsafe_code)]
fn compile(device: &wgpu::Device, text: String, checks: bool) -> wgpu::ShaderModule {
    let descriptor =
        wgpu::ShaderModuleDescriptor { label: Some("kernel"), source: wgpu::ShaderSource::Wgsl(text.into()) };
    if checks {
        return device.create_shader_module(descriptor);
    }
    // SAFETY: see above.
    unsafe { device.create_shader_module_trusted(descriptor, wgpu::ShaderRuntimeChecks::unchecked()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bindings_are_counted_as_the_shaders_declare_them() {
        let count = |group: u32| WGSL.lines().filter(|line| line.starts_with(&format!("@group({group})"))).count();
        assert_eq!(count(0), 1 + SCENE_BUFFERS as usize);
        assert!(count(1) > OUTPUT_BUFFERS as usize);
        assert!(WGSL.contains(&format!("@workgroup_size({WORKGROUP}, {WORKGROUP})")));
    }

    #[test]
    fn uniform_buffers_go_where_they_are_compiled_in() {
        let text = |storage_only| Source { storage_only }.text(5);
        assert!(text(false).contains("var<uniform> params") && text(false).contains("var<uniform> dispatch"));
        assert!(!text(true).contains("uniform>") && text(true).contains("var<storage, read> params"));
        assert!(!text(false).contains("params.features"));
    }

    #[test]
    fn a_dispatch_is_laid_out_as_the_shaders_declare_it() {
        let body =
            WGSL.split_once("struct Dispatch {").and_then(|(_, rest)| rest.split_once('}')).expect("it is there").0;
        let fields = body.lines().filter(|line| line.trim().ends_with(": u32,")).count();
        assert_eq!(fields * 4, size_of::<super::super::Dispatch>());
    }
}
