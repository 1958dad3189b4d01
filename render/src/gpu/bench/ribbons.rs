//! Strands as hardware ribbons: the way to draw them that was not kept, for `balayage bench volume --only drawing`.

use crate::gpu::camera::CameraUniform;
use crate::gpu::kernel::with_module;
use crate::gpu::strands::StrandBuffers;
use crate::gpu::{Gpu, GpuError, Kernel};

const SUM_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
const LEFT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// Camera-facing ribbons of the true projected width, at least a pixel wide with coverage as alpha, blended without order.
pub struct Ribbons {
    pipeline: wgpu::RenderPipeline,
    compose: Kernel,
    sums: wgpu::Texture,
    left: wgpu::Texture,
    /// Premultiplied scene-linear RGBA of the whole picture.
    pub picture: wgpu::Buffer,
}

impl Ribbons {
    /// Compiles the passes for pictures of `size` pixels.
    ///
    /// # Errors
    /// [`GpuError::Refused`], [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let texture = |label, format| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: size[0],
                    height: size[1],
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        Ok(Self {
            pipeline: pipeline(gpu)?,
            compose: Kernel::new(gpu, "pass/bench_ribbons_compose.wgsl", &[])?,
            sums: texture("ribbons' sums", SUM_FORMAT),
            left: texture("left behind ribbons", LEFT_FORMAT),
            picture: gpu.storage("ribbons' picture", 16 * u64::from(size[0]) * u64::from(size[1]))?,
        })
    }

    /// Draws the strands with the radiance of their vertices; `camera` has to be of the size that was given.
    pub fn draw(&self, gpu: &Gpu, camera: &CameraUniform, strands: &StrandBuffers) {
        let uniform = gpu.uniform_of("camera", camera);
        let [sums, left] = [&self.sums, &self.left].map(|t| t.create_view(&Default::default()));
        let buffers = [
            (0, &uniform),
            (1, &strands.vertices),
            (2, &strands.segments),
            (3, &strands.radiance),
        ]
        .map(|(binding, buffer)| buffer_entry(binding, buffer));
        let bound = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ribbons"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &buffers,
        });
        let attachment = |view, clear| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("ribbons"),
                color_attachments: &[
                    attachment(&sums, wgpu::Color::TRANSPARENT),
                    attachment(&left, wgpu::Color::WHITE),
                ],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bound, &[]);
            pass.draw(0..6 * camera.segment_count, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);

        let texture_entry = |binding, view| wgpu::BindGroupEntry {
            binding,
            resource: wgpu::BindingResource::TextureView(view),
        };
        let entries = [
            buffer_entry(0, &uniform),
            texture_entry(1, &sums),
            texture_entry(2, &left),
            buffer_entry(3, &self.picture),
        ];
        let bound = self.compose.bind_entries(gpu, &entries);
        self.compose.run(gpu, &bound, camera.size[0] * camera.size[1]);
    }
}

fn buffer_entry(binding: u32, buffer: &wgpu::Buffer) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    }
}

/// The ribbons' pipeline: no depth test, sums are added up and what is left is multiplied.
fn pipeline(gpu: &Gpu) -> Result<wgpu::RenderPipeline, GpuError> {
    let path = "pass/bench_ribbons.wgsl";
    let target = |format, src_factor, dst_factor| {
        let component = wgpu::BlendComponent {
            src_factor,
            dst_factor,
            operation: wgpu::BlendOperation::Add,
        };
        Some(wgpu::ColorTargetState {
            format,
            blend: Some(wgpu::BlendState {
                color: component,
                alpha: component,
            }),
            write_mask: wgpu::ColorWrites::ALL,
        })
    };
    use wgpu::BlendFactor::{One, OneMinusSrc, Zero};
    with_module(gpu, path, &[], |module| {
        gpu.device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(path),
                layout: None,
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some("fragment"),
                    compilation_options: Default::default(),
                    targets: &[
                        target(SUM_FORMAT, One, One),
                        target(LEFT_FORMAT, Zero, OneMinusSrc),
                    ],
                }),
                multiview_mask: None,
                cache: None,
            })
    })
}
