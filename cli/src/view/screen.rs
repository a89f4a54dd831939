//! The window's surface; the picture and egui are drawn upon it.

use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

use egui::{ClippedPrimitive, TexturesDelta};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use kinora_renderer::Image;
use wgpu::CurrentSurfaceTexture::{Lost, Outdated, Suboptimal, Success};
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::blit::{Blit, Place};
use crate::terminal;

/// How long a photograph of the window may take.
const READ_BACK: Duration = Duration::from_secs(10);

/// What is seen beside the picture.
const BACKGROUND: wgpu::Color = wgpu::Color { r: 24.0 / 255.0, g: 24.0 / 255.0, b: 24.0 / 255.0, a: 1.0 };

/// What is drawn upon.
pub struct Screen {
    instance: wgpu::Instance,
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    device: wgpu::Device,
    queue: wgpu::Queue,
    config: wgpu::SurfaceConfiguration,
    egui: egui_wgpu::Renderer,
    blit: Blit,
}

impl Screen {
    /// Opens the device that shows `window`: a GPU, or one in software.
    ///
    /// # Errors
    /// There is none, in words.
    pub fn open(events: &ActiveEventLoop, window: Arc<Window>) -> Result<Screen, String> {
        // OpenGL is asked only where nothing else is there: merely looking for it takes time.
        let (instance, surface, adapter) =
            find(wgpu::Backends::PRIMARY, events, &window).or_else(|_| find(wgpu::Backends::GL, events, &window))?;
        let limits = wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits());
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).map_err(|error| no_device(&error))?;
        // Whatever goes wrong on the screen, the viewer stays.
        device.on_uncaptured_error(Arc::new(|error| terminal::err(&format!("the window's device: {error}\n"))));

        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| no_device(&"it cannot show a window"))?;
        // egui and the picture are display values already: the surface must not encode them again.
        let formats = surface.get_capabilities(&adapter).formats;
        config.format = formats.iter().copied().find(|format| !format.is_srgb()).unwrap_or(config.format);
        surface.configure(&device, &config);
        let options = RendererOptions { dithering: false, ..Default::default() };
        let egui = egui_wgpu::Renderer::new(&device, config.format, options);
        let blit = Blit::new(&device, config.format);
        Ok(Screen { instance, window, surface, device, queue, config, egui, blit })
    }

    /// The longest side of a texture in pixels.
    pub fn max_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// Takes a new size in pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        let limit = self.max_side();
        (self.config.width, self.config.height) = (width.clamp(1, limit), height.clamp(1, limit));
        self.surface.configure(&self.device, &self.config);
    }

    /// Takes the next picture: its size in pixels and four bytes of each.
    pub fn take(&mut self, size: [u32; 2], rgba: &[u8]) {
        self.blit.take(&self.device, &self.queue, size, rgba);
    }

    /// Shows the picture at `place` and what egui drew over it; gives all that as an image, too, if `photo` is set.
    pub fn paint(
        &mut self,
        place: Option<Place>,
        shapes: &[ClippedPrimitive],
        mut textures: TexturesDelta,
        pixels_per_point: f32,
        photo: bool,
    ) -> Option<Result<Image, String>> {
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                self.egui.update_texture(&self.device, &self.queue, id, &delta);
            }
        }
        let size_in_pixels = [self.config.width, self.config.height];
        let screen = ScreenDescriptor { size_in_pixels, pixels_per_point };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut commands = self.egui.update_buffers(&self.device, &self.queue, &mut encoder, shapes, &screen);

        let frame = self.next_frame();
        if let Some(frame) = &frame {
            self.draw(&mut encoder, &frame.texture, place, shapes, &screen);
        }
        // Drawn once more, because not every surface can be read.
        let copy = photo.then(|| self.copy());
        if let Some(copy) = &copy {
            self.draw(&mut encoder, copy, place, shapes, &screen);
        }
        commands.push(encoder.finish());
        self.queue.submit(commands);
        if let Some(frame) = frame {
            self.window.pre_present_notify();
            self.queue.present(frame);
        }
        for id in textures.free.drain() {
            self.egui.free_texture(&id);
        }
        copy.map(|copy| self.read(&copy))
    }

    /// What to draw on next, unless the window cannot be seen.
    fn next_frame(&mut self) -> Option<wgpu::SurfaceTexture> {
        match self.surface.get_current_texture() {
            Success(frame) | Suboptimal(frame) => return Some(frame),
            Outdated => {}
            Lost => match self.instance.create_surface(self.window.clone()) {
                Ok(surface) => self.surface = surface,
                Err(error) => terminal::err(&format!("the window is lost: {error}\n")),
            },
            _ => return None,
        }
        self.surface.configure(&self.device, &self.config);
        match self.surface.get_current_texture() {
            Success(frame) | Suboptimal(frame) => Some(frame),
            _ => None,
        }
    }

    fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::Texture,
        place: Option<Place>,
        shapes: &[ClippedPrimitive],
        screen: &ScreenDescriptor,
    ) {
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(BACKGROUND), store: wgpu::StoreOp::Store };
        let color = wgpu::RenderPassColorAttachment { view: &view, resolve_target: None, ops, depth_slice: None };
        let pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor { color_attachments: &[Some(color)], ..Default::default() });
        let mut pass = pass.forget_lifetime();
        if let Some(place) = place {
            self.blit.draw(&mut pass, place, screen.size_in_pixels, self.max_side());
        }
        self.egui.render(&mut pass, shapes, screen);
    }

    fn copy(&self) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: self.config.width, height: self.config.height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.config.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    fn read(&self, texture: &wgpu::Texture) -> Result<Image, String> {
        use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
        let order = match texture.format() {
            Rgba8Unorm | Rgba8UnormSrgb => [0, 1, 2],
            Bgra8Unorm | Bgra8UnormSrgb => [2, 1, 0],
            other => return Err(format!("cannot read a window of format {other:?}")),
        };
        let (width, height) = (texture.width(), texture.height());
        let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(row) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        let target = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(texture.as_image_copy(), target, texture.size());
        self.queue.submit([encoder.finish()]);

        let failed = |error: &dyn std::fmt::Display| format!("cannot read the window: {error}");
        let (sender, mapped) = channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // Nobody waits any more only after a time-out.
            let _ = sender.send(result);
        });
        self.device
            .poll(wgpu::PollType::Wait { submission_index: None, timeout: Some(READ_BACK) })
            .map_err(|error| failed(&error))?;
        mapped.recv_timeout(READ_BACK).map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        let bytes = buffer.get_mapped_range(..).map_err(|error| failed(&error))?;
        let rows = bytes.chunks_exact(row as usize).map(|row| &row[..width as usize * 4]);
        let value = |pixel: &[u8], channel: usize| f32::from(pixel[channel]) / 255.0;
        let pixels = rows
            .flat_map(|row| row.chunks_exact(4))
            .map(|pixel| order.map(|channel| value(pixel, channel)).into())
            .collect();
        Ok(Image { size: [width, height], pixels, alpha: Vec::new() })
    }
}

/// A device that can show `window`, one in software if need be.
fn find(
    backends: wgpu::Backends,
    events: &ActiveEventLoop,
    window: &Arc<Window>,
) -> Result<(wgpu::Instance, wgpu::Surface<'static>, wgpu::Adapter), String> {
    let display = Box::new(events.owned_display_handle());
    let descriptor =
        wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_with_display_handle(display) };
    let instance = wgpu::Instance::new(descriptor);
    let surface = instance.create_surface(window.clone()).map_err(|error| no_device(&error))?;
    let request = |fallback| {
        let options = wgpu::RequestAdapterOptions {
            compatible_surface: Some(&surface),
            force_fallback_adapter: fallback,
            ..Default::default()
        };
        pollster::block_on(instance.request_adapter(&options))
    };
    let adapter = request(false).or_else(|_| request(true)).map_err(|error| no_device(&error))?;
    Ok((instance, surface, adapter))
}

fn no_device(error: &dyn std::fmt::Display) -> String {
    format!(
        "no graphics device can show a window ({error}); on Linux, install your GPU's Vulkan driver, or \
        mesa-vulkan-drivers to do without a GPU"
    )
}
