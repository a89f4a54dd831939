//! The picture on the surface.
//!
//! Not as an image of egui's, whose shader divides so much that a software GPU needs a fifth of a second for a window.

use wgpu::util::DeviceExt;

/// Where the picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Left, top, width and height in pixels of the window, beyond which it may reach.
    pub pixels: [f32; 4],
    /// Left, top, right and bottom of where it is seen.
    pub clip: [f32; 4],
    /// Whether its pixels are shown as squares.
    pub squares: bool,
}

impl Place {
    // The viewport, and of the target what is seen: left, top, width and height. `None` where that is nothing, or more than
    // a device can draw.
    fn on(&self, target: [u32; 2], max_side: u32) -> Option<([f32; 4], [u32; 4])> {
        let [x, y, width, height] = self.pixels;
        let along = |start: f32, length: f32, clip: [f32; 2], all: u32| {
            let first = start.max(clip[0]).clamp(0.0, all as f32);
            let end = (start + length).min(clip[1]).clamp(0.0, all as f32);
            let fits = length >= 1.0 && length <= max_side as f32 && start >= -2.0 * max_side as f32;
            (fits && end > first && start + length < 2.0 * max_side as f32 - 1.0)
                .then_some((first as u32, (end - first) as u32))
        };
        let [left, top, right, bottom] = self.clip;
        let (first, wide) = along(x, width, [left, right], target[0])?;
        let (above, high) = along(y, height, [top, bottom], target[1])?;
        (wide > 0 && high > 0).then_some((self.pixels, [first, above, wide, high]))
    }
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

    /// Draws it; `target` is the size of what is drawn upon, of which no side is longer than `max_side`.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, place: Place, target: [u32; 2], max_side: u32) {
        let Some(picture) = &self.picture else { return };
        let Some(([x, y, width, height], seen)) = place.on(target, max_side) else { return };
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &picture[usize::from(place.squares)], &[]);
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
        pass.set_scissor_rect(seen[0], seen[1], seen[2], seen[3]);
        pass.draw(0..3, 0..1);
        pass.set_scissor_rect(0, 0, target[0], target[1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_cut_to_what_is_seen() {
        let on = |pixels, clip| Place { pixels, clip, squares: false }.on([100, 80], 1000).map(|(_, seen)| seen);
        let whole = [0.0, 0.0, 100.0, 80.0];
        assert_eq!(on([10.0, 20.0, 50.0, 40.0], whole), Some([10, 20, 50, 40]));
        assert_eq!(on([-10.0, -20.0, 300.0, 200.0], whole), Some([0, 0, 100, 80]));
        assert_eq!(on([-10.0, -20.0, 300.0, 200.0], [5.0, 8.0, 90.0, 70.0]), Some([5, 8, 85, 62]));
        assert_eq!(on([-400.0, 0.0, 300.0, 80.0], whole), None, "beside it");
        assert_eq!(on([-400.0, 0.0, 1001.0, 80.0], whole), None, "too large");
        assert_eq!(on([0.0, 0.0, 0.5, 80.0], whole), None, "too small");
    }
}
