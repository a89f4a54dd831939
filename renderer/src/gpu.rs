//! The GPU backend: the kernel's WGSL through wgpu, in dispatches short enough that no driver resets and a window on the
//! same device stays alive.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::{UVec2, Vec4, Vec4Swizzles};
use kinora_kernel::{Packed, WGSL};

use crate::backend::{Backend, BackendError, Control};
use crate::film::Survey;

/// What a dispatch should take.
const DISPATCH: Duration = Duration::from_millis(50);
/// Pixels of a workgroup's side, as `entry/render.wgsl` declares.
const WORKGROUP: u32 = 8;
/// Storage buffers that the kernel binds, the film included.
const STORAGE_BUFFERS: u32 = 7;

/// A GPU that wgpu found.
#[derive(Clone, Debug, PartialEq)]
pub struct AdapterReport {
    /// The device's name.
    pub name: String,
    /// Vulkan, Metal, Dx12 or Gl.
    pub api: String,
    /// The driver's name and version.
    pub driver: String,
    /// A program that computes on the CPU.
    pub software: bool,
    /// The largest array of a scene that it takes, in bytes.
    pub max_buffer_bytes: u64,
    /// Whether the kernel runs on it at all.
    pub usable: bool,
}

/// Every adapter there is, the preferred first.
pub fn adapters() -> Vec<AdapterReport> {
    found()
        .iter()
        .map(|adapter| {
            let info = adapter.get_info();
            let limits = adapter.limits();
            AdapterReport {
                software: is_software(&info),
                api: format!("{:?}", info.backend),
                driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
                name: info.name,
                max_buffer_bytes: limits.max_buffer_size.min(limits.max_storage_buffer_binding_size),
                usable: is_usable(adapter),
            }
        })
        .collect()
}

fn is_software(info: &wgpu::AdapterInfo) -> bool {
    matches!(info.device_type, wgpu::DeviceType::Cpu)
        || ["llvmpipe", "softpipe", "SwiftShader"].iter().any(|name| info.name.contains(name))
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

fn is_usable(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
        && adapter.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
}

// All adapters: hardware before software. OpenGL is asked only where nothing else is there: it talks to the window
// system, and Mesa prints a complaint of its own where there is none.
fn found() -> Vec<wgpu::Adapter> {
    let ask = |backends| {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
        descriptor.backends = backends;
        pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends))
    };
    let mut adapters = ask(wgpu::Backends::PRIMARY);
    if adapters.is_empty() {
        adapters = ask(wgpu::Backends::SECONDARY);
    }
    adapters.sort_by_key(|adapter| {
        let info = adapter.get_info();
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        (is_software(&info), kind)
    });
    adapters
}

// The same for all entry points: the scene, then a dispatch and the film.
fn layouts(device: &wgpu::Device) -> [wgpu::BindGroupLayout; 2] {
    let layout = |read_only: bool, buffers: u32| {
        let entries: Vec<_> = (0..buffers)
            .map(|binding| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: match binding {
                        0 => wgpu::BufferBindingType::Uniform,
                        _ => wgpu::BufferBindingType::Storage { read_only },
                    },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            })
            .collect();
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
    };
    [layout(true, STORAGE_BUFFERS), layout(false, 2)]
}

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layouts: &[wgpu::BindGroupLayout; 2],
    entry: &str,
) -> wgpu::ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry),
        bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[1])],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry),
        layout: Some(&layout),
        module,
        entry_point: Some(entry),
        compilation_options: Default::default(),
        cache: None,
    })
}

struct Scene {
    bindings: wgpu::BindGroup,
    dispatch: wgpu::Buffer,
    film: wgpu::Buffer,
    film_bindings: wgpu::BindGroup,
    read_back: wgpu::Buffer,
    size: UVec2,
}

/// One GPU.
pub struct Gpu {
    name: String,
    limits: wgpu::Limits,
    device: wgpu::Device,
    queue: wgpu::Queue,
    module: wgpu::ShaderModule,
    layouts: [wgpu::BindGroupLayout; 2],
    render: wgpu::ComputePipeline,
    /// Made when it is first wanted.
    survey: Option<wgpu::ComputePipeline>,
    scene: Option<Scene>,
    /// Pixel samples of the next dispatch.
    batch: f64,
    lost: Arc<Mutex<Option<String>>>,
}

impl Gpu {
    /// The best adapter, a software one if there is no other.
    ///
    /// # Errors
    /// There is none, or it does not start.
    pub fn any() -> Result<Self, BackendError> {
        Self::first(|_| true)
    }

    /// The best hardware adapter.
    ///
    /// # Errors
    /// There is none, or it does not start.
    pub fn hardware() -> Result<Self, BackendError> {
        if !may_have_hardware() {
            return Err(BackendError::NoAdapter);
        }
        Self::first(|info| !is_software(info))
    }

    fn first(wanted: impl Fn(&wgpu::AdapterInfo) -> bool) -> Result<Self, BackendError> {
        let adapter = found().into_iter().find(|a| wanted(&a.get_info()) && is_usable(a));
        Self::open(&adapter.ok_or(BackendError::NoAdapter)?)
    }

    fn open(adapter: &wgpu::Adapter) -> Result<Self, BackendError> {
        let info = adapter.get_info();
        let limits = adapter.limits();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("kinora"),
            required_limits: limits.clone(),
            ..Default::default()
        }))
        .map_err(|error| BackendError::Device(error.to_string()))?;
        let lost = Arc::new(Mutex::new(None));
        let report = |lost: &Arc<Mutex<Option<String>>>| {
            let lost = Arc::clone(lost);
            move |message: String| {
                if let Ok(mut lost) = lost.lock() {
                    lost.get_or_insert(message);
                }
            }
        };
        let on_lost = report(&lost);
        device.set_device_lost_callback(move |reason, message| {
            // A device that its owner drops is lost in wgpu's words too.
            if reason != wgpu::DeviceLostReason::Destroyed {
                on_lost(message);
            }
        });
        let on_error = report(&lost);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| on_error(error.to_string())));
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("kernel"),
            source: wgpu::ShaderSource::Wgsl(WGSL.into()),
        });
        let layouts = layouts(&device);
        let render = pipeline(&device, &module, &layouts, "render");
        let gpu = Self {
            name: format!("{} ({:?})", info.name, info.backend),
            limits,
            device,
            queue,
            module,
            layouts,
            render,
            survey: None,
            scene: None,
            batch: 65536.0,
            lost,
        };
        gpu.check()?;
        Ok(gpu)
    }

    fn check(&self) -> Result<(), BackendError> {
        match self.lost.lock().ok().and_then(|mut lost| lost.take()) {
            Some(message) => Err(BackendError::Device(message)),
            None => Ok(()),
        }
    }

    fn check_size(&self, what: &'static str, bytes: u64) -> Result<(), BackendError> {
        let limit = self.limits.max_buffer_size.min(self.limits.max_storage_buffer_binding_size);
        if bytes > limit {
            return Err(BackendError::TooLarge { what, bytes, limit, adapter: self.name.clone() });
        }
        Ok(())
    }

    fn buffer(
        &self,
        what: &'static str,
        bytes: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, BackendError> {
        self.check_size(what, bytes.len() as u64)?;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: bytes.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    fn bind(&self, group: usize, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        let entries: Vec<_> = buffers
            .iter()
            .enumerate()
            .map(|(i, buffer)| wgpu::BindGroupEntry { binding: i as u32, resource: buffer.as_entire_binding() })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.layouts[group],
            entries: &entries,
        })
    }

    fn make_scene(&self, packed: &Packed) -> Result<Scene, BackendError> {
        let storage = |what, bytes: &[u8]| self.buffer(what, bytes, wgpu::BufferUsages::STORAGE);
        let uniform = |what, bytes: &[u8]| self.buffer(what, bytes, wgpu::BufferUsages::UNIFORM);
        let params = uniform("parameters", bytemuck::bytes_of(&packed.params))?;
        let nodes = storage("nodes of the tree", &packed.node_bytes())?;
        let primitives = storage("primitives", bytemuck::cast_slice(&packed.primitives))?;
        let shapes = storage("shapes", bytemuck::cast_slice(&packed.shapes))?;
        let materials = storage("materials", bytemuck::cast_slice(&packed.materials))?;
        let lights = storage("lights", bytemuck::cast_slice(&packed.lights))?;
        let tables = storage("tables", bytemuck::cast_slice(&packed.tables))?;
        let bindings = self.bind(0, &[&params, &nodes, &primitives, &shapes, &materials, &lights, &tables]);

        let size = packed.params.window.zw();
        // At least one row of a survey.
        let film_bytes = u64::from(size.x) * u64::from(size.y.max(3)) * size_of::<Vec4>() as u64;
        self.check_size("pixels of the film", film_bytes)?;
        let buffer = |label, size, usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let film = buffer("film", film_bytes, Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST);
        let read_back = buffer("read back", film_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let dispatch = uniform("dispatch", &[0; 32])?;
        let film_bindings = self.bind(1, &[&dispatch, &film]);
        Ok(Scene { bindings, dispatch, film, film_bindings, read_back, size })
    }

    // Waits until the GPU has done what it was given.
    fn wait(&self) -> Result<(), BackendError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| BackendError::Device(error.to_string()))?;
        self.check()
    }

    fn submit(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        record(&mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        scene: &Scene,
        film_row: u32,
        rows: Range<u32>,
        samples: Range<u32>,
    ) -> Result<(), BackendError> {
        let bounds = [rows.start, rows.end, samples.start, samples.end, film_row, 0, 0, 0];
        self.queue.write_buffer(&scene.dispatch, 0, bytemuck::cast_slice(&bounds));
        self.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &scene.bindings, &[]);
            pass.set_bind_group(1, &scene.film_bindings, &[]);
            pass.dispatch_workgroups(scene.size.x.div_ceil(WORKGROUP), (rows.end - rows.start).div_ceil(WORKGROUP), 1);
        });
        self.wait()
    }

    // Runs `pipeline` over these rows, which fill the film from its start; false if `control`, which hears of rows times
    // samples, ended it.
    fn sum(
        &mut self,
        pipeline: &wgpu::ComputePipeline,
        rows: Range<u32>,
        samples: Range<u32>,
        control: &dyn Fn(f64) -> bool,
    ) -> Result<bool, BackendError> {
        let scene = self.scene.as_ref().ok_or(BackendError::Nothing)?;
        self.submit(|encoder| encoder.clear_buffer(&scene.film, 0, None));
        let mut batch = self.batch;
        let mut done = 0.0;
        let mut row = rows.start;
        let mut goes_on = true;
        while row < rows.end && goes_on {
            // A band takes all its samples before the next begins, so that each pixel adds them in their order.
            let row_cost = f64::from(scene.size.x) * f64::from(samples.len() as u32);
            let height = ((batch / row_cost) as u32).max(WORKGROUP);
            let band = row..row.saturating_add(height).min(rows.end);
            let mut sample = samples.start;
            while sample < samples.end && goes_on {
                let pixels = f64::from(scene.size.x) * f64::from(band.end - band.start);
                let count = ((batch / pixels) as u32).clamp(1, samples.end - sample);
                let start = Instant::now();
                self.dispatch(pipeline, scene, rows.start, band.clone(), sample..sample + count)?;
                let ratio = DISPATCH.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6);
                batch = (pixels * f64::from(count) * ratio.clamp(0.25, 4.0)).clamp(1024.0, 1e9);
                sample += count;
                done += f64::from(count) * f64::from(band.end - band.start);
                goes_on = control(done);
            }
            row = band.end;
        }
        self.batch = batch;
        Ok(goes_on)
    }

    fn read(&self, scene: &Scene) -> Result<Vec<Vec4>, BackendError> {
        self.submit(|encoder| encoder.copy_buffer_to_buffer(&scene.film, 0, &scene.read_back, 0, scene.film.size()));
        let failed = Arc::new(Mutex::new(None));
        let result = Arc::clone(&failed);
        scene.read_back.map_async(wgpu::MapMode::Read, .., move |mapped| {
            if let (Err(error), Ok(mut failed)) = (mapped, result.lock()) {
                *failed = Some(error.to_string());
            }
        });
        self.wait()?;
        if let Some(message) = failed.lock().ok().and_then(|mut failed| failed.take()) {
            return Err(BackendError::Device(message));
        }
        let view = scene.read_back.get_mapped_range(..).map_err(|error| BackendError::Device(error.to_string()))?;
        let sums = view.chunks_exact(size_of::<Vec4>()).map(bytemuck::pod_read_unaligned).collect();
        drop(view);
        scene.read_back.unmap();
        Ok(sums)
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        self.name.clone()
    }

    fn upload(&mut self, packed: Arc<Packed>) -> Result<(), BackendError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let scene = self.make_scene(&packed);
        if let Some(error) = pollster::block_on(memory.pop()) {
            return Err(BackendError::Device(error.to_string()));
        }
        self.check()?;
        self.scene = Some(scene?);
        Ok(())
    }

    fn trace(&mut self, samples: Range<u32>, control: &dyn Control) -> Result<Option<Vec<Vec4>>, BackendError> {
        let height = self.scene.as_ref().ok_or(BackendError::Nothing)?.size.y;
        let total = f64::from(samples.len() as u32) * f64::from(height);
        let render = self.render.clone();
        let finished = self.sum(&render, 0..height, samples, &|done| control.keep_going(done / total))?;
        match &self.scene {
            Some(scene) if finished => self.read(scene).map(|mut sums| {
                sums.truncate(scene.size.x as usize * height as usize);
                Some(sums)
            }),
            _ => Ok(None),
        }
    }

    fn survey(&mut self, samples: Range<u32>, control: &dyn Control) -> Result<Option<Vec<Survey>>, BackendError> {
        let size = self.scene.as_ref().ok_or(BackendError::Nothing)?.size;
        if self.survey.is_none() {
            self.survey = Some(pipeline(&self.device, &self.module, &self.layouts, "survey"));
            self.check()?;
        }
        let Some(survey) = self.survey.clone() else { return Ok(None) };
        let total = f64::from(samples.len() as u32) * f64::from(size.y);
        let mut surveys = Vec::with_capacity(size.x as usize * size.y as usize);
        // The film holds a third of the picture at a time.
        let height = size.y.max(3) / 3;
        let mut row = 0;
        while row < size.y {
            let rows = row..row.saturating_add(height).min(size.y);
            let before = f64::from(samples.len() as u32) * f64::from(row);
            let go_on = |done: f64| control.keep_going((before + done) / total);
            if !self.sum(&survey, rows.clone(), samples.clone(), &go_on)? {
                return Ok(None);
            }
            let Some(scene) = &self.scene else { return Ok(None) };
            let count = size.x as usize * rows.len();
            let values = self.read(scene)?;
            surveys.extend(values.chunks_exact(3).take(count).map(|v| [v[0], v[1], v[2]]));
            row = rows.end;
        }
        Ok(Some(surveys))
    }
}
