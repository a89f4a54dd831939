//! The picture on the surface.
//!
//! Not as an image of egui's, whose shader divides so much that a software GPU needs a fifth of a second for a window.

use wgpu::util::DeviceExt;

/// Where the picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Left, top, width and height in pixels of the window.
    pub pixels: [f32; 4],
    /// Whether its pixels are shown as squares.
    pub squares: bool,
}

/// A way to draw a picture.
pub struct Blit {
    pipeline: wgpu::RenderPipeline,
    format: wgpu::TextureFormat,
    smooth: wgpu::Sampler,
    squares: wgpu::Sampler,
    /// The picture, smooth and in squares.
    picture: Option<[wgpu::BindGroup; 2]>,
}

impl Blit {
    /// Onto targets of `format`.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Blit {
        let module = device.create_shader_module(wgpu::include_wgsl!("blit.wgsl"));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("texel"),
                compilation_options: Default::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = |filter| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: filter,
                min_filter: filter,
                ..Default::default()
            })
        };
        // Values are for the display already: what the target encodes, the texture must decode.
        let format = match format.is_srgb() {
            true => wgpu::TextureFormat::Rgba8UnormSrgb,
            false => wgpu::TextureFormat::Rgba8Unorm,
        };
        let (smooth, squares) = (sampler(wgpu::FilterMode::Linear), sampler(wgpu::FilterMode::Nearest));
        Blit { pipeline, format, smooth, squares, picture: None }
    }

    /// Takes the next picture: display values, four bytes a pixel. One that is not of that size is not taken.
    pub fn take(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, [width, height]: [u32; 2], rgba: &[u8]) {
        if rgba.is_empty() || rgba.len() as u64 != u64::from(width) * u64::from(height) * 4 {
            return;
        }
        let descriptor = wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let texture = device.create_texture_with_data(queue, &descriptor, Default::default(), rgba);
        let view = texture.create_view(&Default::default());
        let layout = self.pipeline.get_bind_group_layout(0);
        self.picture = Some([&self.smooth, &self.squares].map(|sampler| {
            let resources = [wgpu::BindingResource::TextureView(&view), wgpu::BindingResource::Sampler(sampler)];
            let mut binding = 0..;
            let entries =
                resources.map(|resource| wgpu::BindGroupEntry { binding: binding.next().unwrap_or(0), resource });
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
        }));
    }

    /// Draws it; `target` is the size of what is drawn upon.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, place: Place, target: [u32; 2]) {
        let Some(picture) = &self.picture else { return };
        let [x, y, width, height] = place.pixels;
        let inside = x >= 0.0 && y >= 0.0 && x + width <= target[0] as f32 && y + height <= target[1] as f32;
        if !inside || width < 1.0 || height < 1.0 {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &picture[usize::from(place.squares)], &[]);
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
        pass.draw(0..3, 0..1);
    }
}
