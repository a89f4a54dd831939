//! The GPU backend: the kernel's WGSL through wgpu, in dispatches short enough that no driver resets and a window on the
//! same device stays alive.

mod adapter;
mod kernel;
mod pace;

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use glam::{UVec2, Vec4, Vec4Swizzles};
use kinora_kernel::Packed;
use kinora_kernel::packed::TooDeep;

use crate::backend::{Backend, BackendError, Control};
use crate::film::{Parts, Survey};
use crate::pack::Changes;
use kernel::{Kernel, WORKGROUP};
use pace::Pace;

pub use adapter::{Adapter, Api, Demand, adapters_of};

/// An entry point, and how many vectors it writes a pixel.
#[derive(Clone, Copy)]
struct Entry {
    name: &'static str,
    vectors: u64,
}

/// Traces paths.
const RENDER: Entry = Entry { name: "render", vectors: 1 };
/// Traces them with their light in parts.
const RENDER_PARTS: Entry = Entry { name: "render_parts", vectors: 5 };
/// Looks at the first surfaces.
const SURVEY: Entry = Entry { name: "survey", vectors: 4 };

/// What a dispatch does: `Dispatch` of `entry/`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Dispatch {
    /// Rows of the window, or places in the list, and samples.
    first: u32,
    end: u32,
    first_sample: u32,
    end_sample: u32,
    /// The row that the output begins with.
    output_row: u32,
    /// Threads of a device that gives each a block of consecutive workgroups; 1 for all others.
    threads: u32,
    /// 0, or the vector of the output that the list of pixels begins with: two in a vector.
    list: u32,
    padding: u32,
}

/// What an entry writes, for a band of the picture's rows: a whole picture can be more than a buffer may hold.
struct Output {
    dispatch: wgpu::Buffer,
    sums: wgpu::Buffer,
    read_back: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    rows: u32,
}

/// What an entry needs to run over a scene.
struct Job {
    entry: Entry,
    pipeline: wgpu::ComputePipeline,
    output: Output,
}

struct Scene {
    /// Parameters, nodes, primitives, shapes, materials, lights, tables and words.
    buffers: [wgpu::Buffer; 8],
    bindings: wgpu::BindGroup,
    features: u32,
    /// One an entry, made when it is first wanted.
    jobs: Vec<Job>,
    size: UVec2,
}

impl Scene {
    // Whether the same pipelines write the same numbers of pixels.
    fn is_like(&self, packed: &Packed) -> bool {
        self.size == packed.params.window.zw() && self.features == packed.params.features
    }
}

/// What went wrong on a device since it was asked last.
#[derive(Clone, Default)]
struct Faults(Arc<Mutex<Option<String>>>);

impl Faults {
    fn report(&self, message: String) {
        if let Ok(mut first) = self.0.lock() {
            first.get_or_insert(message);
        }
    }

    fn check(&self) -> Result<(), BackendError> {
        match self.0.lock().ok().and_then(|mut first| first.take()) {
            Some(message) => Err(BackendError::Device(message)),
            None => Ok(()),
        }
    }
}

/// One GPU.
pub struct Gpu {
    adapter: Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    kernel: Kernel,
    threads: u32,
    scene: Option<Scene>,
    pace: Pace,
    faults: Faults,
}

impl Gpu {
    /// The best adapter of `api` or of any, a software one if there is no other. `checks`: the shaders check every
    /// access to memory.
    ///
    /// # Errors
    /// There is none that the kernel runs on, or it does not start.
    pub fn any(api: Option<Api>, checks: bool) -> Result<Self, BackendError> {
        Self::open(&adapter::best(api, false)?, checks)
    }

    /// The best hardware adapter.
    ///
    /// # Errors
    /// As [`Gpu::any`].
    pub fn hardware(checks: bool) -> Result<Self, BackendError> {
        Self::open(&adapter::best(None, true)?, checks)
    }

    /// `adapter`.
    ///
    /// # Errors
    /// The kernel does not run on it, or it does not start.
    pub fn open(adapter: &Adapter, checks: bool) -> Result<Self, BackendError> {
        adapter.check()?;
        let (device, queue) = pollster::block_on(adapter.wgpu.request_device(&wgpu::DeviceDescriptor {
            label: Some("kinora"),
            required_limits: adapter.limits.clone(),
            ..Default::default()
        }))
        .map_err(|error| BackendError::Device(error.to_string()))?;
        let faults = Faults::default();
        let on_lost = faults.clone();
        device.set_device_lost_callback(move |reason, message| {
            // A device that its owner drops is lost in wgpu's words too.
            if reason != wgpu::DeviceLostReason::Destroyed {
                on_lost.report(message);
            }
        });
        let on_error = faults.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| on_error.report(error.to_string())));
        let kernel = Kernel::new(&device, adapter.inlines_uniforms(), checks);
        let threads = match adapter.is_software() {
            true => std::thread::available_parallelism().map_or(1, |n| n.get() as u32),
            false => 1,
        };
        let adapter = adapter.clone();
        faults.check()?;
        Ok(Self { adapter, device, queue, kernel, threads, scene: None, pace: Pace::default(), faults })
    }

    fn check_size(&self, what: &'static str, bytes: u64) -> Result<(), BackendError> {
        let limit = self.adapter.max_array_bytes();
        if bytes > limit {
            return Err(BackendError::TooLarge { what, bytes, limit, adapter: self.adapter.label() });
        }
        Ok(())
    }

    fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
        self.device.create_buffer(&descriptor)
    }

    fn array(&self, what: &'static str, bytes: &[u8], usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, BackendError> {
        self.check_size(what, bytes.len() as u64)?;
        let buffer = self.buffer(what, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytes);
        Ok(buffer)
    }

    // Makes a scene where the device may run out of memory.
    fn scope(&self, make: impl FnOnce(&Self) -> Result<Scene, BackendError>) -> Result<Scene, BackendError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let scene = make(self);
        if let Some(error) = pollster::block_on(memory.pop()) {
            return Err(BackendError::Device(error.to_string()));
        }
        self.faults.check()?;
        scene
    }

    fn make_scene(&self, packed: &Packed) -> Result<Scene, BackendError> {
        let [nodes, primitives] = self.make_tree(packed)?;
        let storage = |what, bytes: &[u8]| self.array(what, bytes, wgpu::BufferUsages::STORAGE);
        let buffers = [
            self.array("parameters", bytemuck::bytes_of(&packed.params), self.kernel.constants_usage())?,
            nodes,
            primitives,
            storage("shapes", bytemuck::cast_slice(&packed.shapes))?,
            storage("materials", bytemuck::cast_slice(&packed.materials))?,
            storage("lights", bytemuck::cast_slice(&packed.lights))?,
            storage("tables", bytemuck::cast_slice(&packed.tables))?,
            storage("texels and tables of lights", bytemuck::cast_slice(&packed.words))?,
        ];
        Ok(self.bind(buffers, packed))
    }

    fn make_tree(&self, packed: &Packed) -> Result<[wgpu::Buffer; 2], BackendError> {
        let compressed = packed.compressed().map_err(|TooDeep { depth }| BackendError::TooDeep { depth })?;
        compressed.validate().map_err(BackendError::Invalid)?;
        let storage = |what, bytes: &[u8]| self.array(what, bytes, wgpu::BufferUsages::STORAGE);
        let nodes = storage("nodes of the tree", &compressed.node_bytes())?;
        Ok([nodes, storage("primitives", bytemuck::cast_slice(&compressed.primitives))?])
    }

    // The scene with the arrays that changed; the others stay on the device.
    fn change_scene(&self, before: &Scene, packed: &Packed, changes: Changes) -> Result<Scene, BackendError> {
        let mut buffers = before.buffers.clone();
        if changes.tree {
            [buffers[1], buffers[2]] = self.make_tree(packed)?;
        }
        let arrays: [(bool, &'static str, &[u8]); 6] = [
            (true, "parameters", bytemuck::bytes_of(&packed.params)),
            (changes.shapes, "shapes", bytemuck::cast_slice(&packed.shapes)),
            (changes.materials, "materials", bytemuck::cast_slice(&packed.materials)),
            (changes.lights, "lights", bytemuck::cast_slice(&packed.lights)),
            (changes.tables, "tables", bytemuck::cast_slice(&packed.tables)),
            (changes.textures, "texels and tables of lights", bytemuck::cast_slice(&packed.words)),
        ];
        for (at, (_, what, bytes)) in [0, 3, 4, 5, 6, 7].into_iter().zip(arrays).filter(|(_, (changed, ..))| *changed) {
            let buffer = &mut buffers[at];
            if buffer.size() == bytes.len() as u64 {
                self.queue.write_buffer(buffer, 0, bytes);
            } else {
                *buffer = self.array(what, bytes, buffer.usage())?;
            }
        }
        if buffers == before.buffers {
            let bindings = before.bindings.clone();
            let (size, features) = (packed.params.window.zw(), packed.params.features);
            return Ok(Scene { buffers, bindings, features, jobs: Vec::new(), size });
        }
        Ok(self.bind(buffers, packed))
    }

    fn bind(&self, buffers: [wgpu::Buffer; 8], packed: &Packed) -> Scene {
        let bindings = self.kernel.bind_scene(&self.device, &buffers);
        let (size, features) = (packed.params.window.zw(), packed.params.features);
        Scene { buffers, bindings, features, jobs: Vec::new(), size }
    }

    fn make_job(&mut self, entry: Entry, size: UVec2, features: u32) -> Result<Job, BackendError> {
        let output = self.make_output(size, entry.vectors * size_of::<Vec4>() as u64)?;
        let pipeline = self.kernel.pipeline(&self.device, entry.name, features).clone();
        Ok(Job { entry, pipeline, output })
    }

    fn make_output(&self, size: UVec2, pixel_bytes: u64) -> Result<Output, BackendError> {
        let groups = u64::from(self.adapter.max_workgroups());
        let row_bytes = u64::from(size.x) * pixel_bytes;
        // Rows are traced in whole workgroups.
        let group_bytes = row_bytes * u64::from(WORKGROUP);
        self.check_size("pixels of eight rows", group_bytes)?;
        if u64::from(size.x.div_ceil(WORKGROUP)) > groups {
            let limit = groups * u64::from(WORKGROUP) * pixel_bytes;
            let adapter = self.adapter.label();
            return Err(BackendError::TooLarge { what: "pixels of a row", bytes: row_bytes, limit, adapter });
        }
        let bands = (self.adapter.max_array_bytes() / group_bytes).min(groups);
        let rows = size.y.min((bands as u32).saturating_mul(WORKGROUP));
        let bytes = u64::from(rows) * row_bytes;
        use wgpu::BufferUsages as Usage;
        // A list of one pixel lies behind what is written of it.
        let room = bytes.max(pixel_bytes + size_of::<Vec4>() as u64);
        let sums = self.buffer("sums", room, Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST);
        let read_back = self.buffer("read back", bytes, Usage::MAP_READ | Usage::COPY_DST);
        let usage = self.kernel.constants_usage() | Usage::COPY_DST;
        let dispatch = self.buffer("dispatch", size_of::<Dispatch>() as u64, usage);
        let bindings = self.kernel.bind_output(&self.device, &[dispatch.clone(), sums.clone()]);
        Ok(Output { dispatch, sums, read_back, bindings, rows })
    }

    // Waits until the GPU has done what it was given.
    fn wait(&self) -> Result<(), BackendError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| BackendError::Device(error.to_string()))?;
        self.faults.check()
    }

    fn submit(&self, record: impl FnOnce(&mut wgpu::CommandEncoder)) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        record(&mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    fn dispatch(&self, scene: &Scene, job: &Job, bounds: Dispatch, groups: [u32; 2]) -> Result<(), BackendError> {
        self.queue.write_buffer(&job.output.dispatch, 0, bytemuck::bytes_of(&bounds));
        self.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&job.pipeline);
            pass.set_bind_group(0, &scene.bindings, &[]);
            pass.set_bind_group(1, &job.output.bindings, &[]);
            pass.dispatch_workgroups(groups[0], groups[1], 1);
        });
        self.wait()
    }

    // Appends the first `bytes` of the output.
    fn read(&self, output: &Output, bytes: u64, sums: &mut Vec<Vec4>) -> Result<(), BackendError> {
        self.submit(|encoder| encoder.copy_buffer_to_buffer(&output.sums, 0, &output.read_back, 0, bytes));
        let faults = self.faults.clone();
        output.read_back.map_async(wgpu::MapMode::Read, ..bytes, move |mapped| {
            if let Err(error) = mapped {
                faults.report(error.to_string());
            }
        });
        self.wait()?;
        let view =
            output.read_back.get_mapped_range(..bytes).map_err(|error| BackendError::Device(error.to_string()))?;
        sums.extend(view.chunks_exact(size_of::<Vec4>()).map(bytemuck::pod_read_unaligned::<Vec4>));
        drop(view);
        output.read_back.unmap();
        Ok(())
    }

    // All samples of `rows`, which the output holds; false if `control` ended it.
    fn trace_rows(
        &self,
        pace: &mut Pace,
        (scene, job): (&Scene, &Job),
        rows: Range<u32>,
        samples: Range<u32>,
        mut keep_going: impl FnMut(f64) -> bool,
    ) -> Result<bool, BackendError> {
        self.submit(|encoder| encoder.clear_buffer(&job.output.sums, 0, None));
        let mut row = rows.start;
        while row < rows.end {
            // A band takes all its samples before the next begins, so that each pixel adds them in their order.
            let row_cost = f64::from(scene.size.x) * f64::from(samples.len() as u32);
            let height = ((pace.work() / row_cost) as u32 / WORKGROUP * WORKGROUP).max(WORKGROUP);
            let band = row..row.saturating_add(height).min(rows.end);
            let pixels = f64::from(scene.size.x) * f64::from(band.end - band.start);
            let mut sample = samples.start;
            while sample < samples.end {
                let count = ((pace.work() / pixels) as u32).clamp(1, samples.end - sample);
                let start = Instant::now();
                let bounds = Dispatch {
                    first: band.start,
                    end: band.end,
                    first_sample: sample,
                    end_sample: sample + count,
                    output_row: rows.start,
                    threads: self.threads,
                    list: 0,
                    padding: 0,
                };
                let groups = [scene.size.x, band.end - band.start].map(|side| side.div_ceil(WORKGROUP));
                self.dispatch(scene, job, bounds, groups)?;
                pace.took(pixels * f64::from(count), start.elapsed().as_secs_f64());
                sample += count;
                if !keep_going(f64::from(count) * f64::from(band.end - band.start)) {
                    return Ok(false);
                }
            }
            row = band.end;
        }
        Ok(true)
    }

    // As `run`, with the job of `entry`.
    fn work(
        &mut self,
        entry: Entry,
        pace: &mut Pace,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec4>>, BackendError> {
        let mut scene = self.scene.take().ok_or(BackendError::Nothing)?;
        let job = match scene.jobs.iter().position(|job| job.entry.name == entry.name) {
            Some(found) => Ok(found),
            None => self.make_job(entry, scene.size, scene.features).and_then(|job| {
                self.faults.check()?;
                scene.jobs.push(job);
                Ok(scene.jobs.len() - 1)
            }),
        };
        let sums = job.and_then(|job| self.run(pace, &scene, &scene.jobs[job], pixels, samples, control));
        self.scene = Some(scene);
        sums
    }

    // All that `job` writes about the window, or about these pixels; `None` if `control` ended it.
    fn run(
        &self,
        pace: &mut Pace,
        scene: &Scene,
        job: &Job,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec4>>, BackendError> {
        if let Some(pixels) = pixels {
            return self.run_list(pace, (scene, job), pixels, samples, control);
        }
        let row_vectors = u64::from(scene.size.x) * job.entry.vectors;
        let total = f64::from(samples.len() as u32) * f64::from(scene.size.y);
        let mut done = 0.0;
        let mut sums = Vec::with_capacity((row_vectors * u64::from(scene.size.y)) as usize);
        for first in (0..scene.size.y).step_by(job.output.rows.max(1) as usize) {
            let rows = first..first.saturating_add(job.output.rows).min(scene.size.y);
            let bytes = row_vectors * u64::from(rows.end - rows.start) * size_of::<Vec4>() as u64;
            let keep_going = |more| {
                done += more;
                control.keep_going(done / total)
            };
            if !self.trace_rows(pace, (scene, job), rows, samples.clone(), keep_going)? {
                return Ok(None);
            }
            self.read(&job.output, bytes, &mut sums)?;
        }
        Ok(Some(sums))
    }

    // As `run`, about these pixels.
    fn run_list(
        &self,
        pace: &mut Pace,
        (scene, job): (&Scene, &Job),
        pixels: &[UVec2],
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec4>>, BackendError> {
        const VECTOR: u64 = size_of::<Vec4>() as u64;
        const GROUP: u32 = WORKGROUP * WORKGROUP;
        let total = f64::from(samples.len() as u32) * pixels.len() as f64;
        let mut done = 0.0;
        let mut sums = Vec::with_capacity(pixels.len() * job.entry.vectors as usize);
        // Behind what is written of each lies the list, half a vector each.
        let room = 2 * (job.output.sums.size() / VECTOR) / (2 * job.entry.vectors + 1);
        for pixels in pixels.chunks((room as usize).max(1)) {
            let length = pixels.len() as u32;
            let written = u64::from(length) * job.entry.vectors;
            let list: Vec<[f32; 2]> = pixels.iter().map(|pixel| pixel.as_vec2().to_array()).collect();
            self.submit(|encoder| encoder.clear_buffer(&job.output.sums, 0, Some(written * VECTOR)));
            self.queue.write_buffer(&job.output.sums, written * VECTOR, bytemuck::cast_slice(&list));
            let mut first = 0;
            while first < length {
                let wanted = (pace.work() / f64::from(samples.len() as u32)) as u32 / GROUP * GROUP;
                let end = first.saturating_add(wanted.max(GROUP)).min(length);
                let groups = (end - first).div_ceil(GROUP);
                let columns = groups.min(self.adapter.max_workgroups());
                let mut sample = samples.start;
                while sample < samples.end {
                    let count = ((pace.work() / f64::from(end - first)) as u32).clamp(1, samples.end - sample);
                    let start = Instant::now();
                    let bounds = Dispatch {
                        first,
                        end,
                        first_sample: sample,
                        end_sample: sample + count,
                        output_row: 0,
                        threads: self.threads,
                        list: written as u32,
                        padding: 0,
                    };
                    self.dispatch(scene, job, bounds, [columns, groups.div_ceil(columns)])?;
                    let work = f64::from(end - first) * f64::from(count);
                    pace.took(work, start.elapsed().as_secs_f64());
                    sample += count;
                    done += work;
                    if !control.keep_going(done / total) {
                        return Ok(None);
                    }
                }
                first = end;
            }
            self.read(&job.output, written * VECTOR, &mut sums)?;
        }
        Ok(Some(sums))
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        self.adapter.label()
    }

    fn upload(&mut self, packed: Arc<Packed>) -> Result<(), BackendError> {
        packed.validate().map_err(BackendError::Invalid)?;
        let mut scene = self.scope(|gpu| gpu.make_scene(&packed))?;
        if let Some(before) = self.scene.take_if(|before| before.is_like(&packed)) {
            scene.jobs = before.jobs;
        }
        self.scene = Some(scene);
        Ok(())
    }

    fn update(&mut self, packed: Arc<Packed>, changes: Changes) -> Result<(), BackendError> {
        let Some(before) = self.scene.take() else { return self.upload(packed) };
        packed.validate().map_err(BackendError::Invalid)?;
        let mut scene = self.scope(|gpu| gpu.change_scene(&before, &packed, changes))?;
        if before.is_like(&packed) {
            scene.jobs = before.jobs;
        }
        self.scene = Some(scene);
        Ok(())
    }

    fn trace(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Vec4>>, BackendError> {
        let mut pace = self.pace;
        let sums = self.work(RENDER, &mut pace, pixels, samples, control);
        self.pace = pace;
        sums
    }

    fn trace_parts(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Parts>>, BackendError> {
        let mut pace = self.pace;
        let sums = self.work(RENDER_PARTS, &mut pace, pixels, samples, control);
        self.pace = pace;
        Ok(sums?.map(|sums| sums.as_chunks().0.to_vec()))
    }

    fn survey(
        &mut self,
        pixels: Option<&[UVec2]>,
        samples: Range<u32>,
        control: &dyn Control,
    ) -> Result<Option<Vec<Survey>>, BackendError> {
        let sums = self.work(SURVEY, &mut Pace::default(), pixels, samples, control)?;
        Ok(sums.map(|sums| sums.as_chunks().0.to_vec()))
    }
}
