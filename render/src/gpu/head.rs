//! The head: hardware triangles at 2 x 2 sub-samples a pixel, that the strands are composed over.

use bytemuck::{Pod, Zeroable};
use wgpu::util::DeviceExt;

use super::camera::CameraUniform;
use super::kernel::with_module;
use super::transmittance::Transmittance;
use super::{Gpu, GpuError, Kernel};
use crate::groom::Mesh;

const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;
const Z_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Colour and depth of the head, twice the picture's size.
pub struct HeadTarget {
    /// Scene-linear radiance, alpha 1 where the head is.
    pub colour: wgpu::Texture,
    /// Depth along the camera's axis, world units.
    pub depth: wgpu::Texture,
    z: wgpu::Texture,
}

impl HeadTarget {
    /// Targets for a picture of `size` pixels.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if 2 * size[0].max(size[1]) > limit {
            return Err(GpuError::TooLarge {
                what: format!(
                    "a picture of {} x {} pixels with a head (2 x 2 sub-samples)",
                    size[0], size[1]
                ),
                needed: u64::from(2 * size[0].max(size[1])),
                limit: u64::from(limit),
            });
        }
        let texture = |label, format| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: 2 * size[0],
                    height: 2 * size[1],
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
            colour: texture("head colour", COLOUR_FORMAT),
            depth: texture("head depth", DEPTH_FORMAT),
            z: texture("head z", Z_FORMAT),
        })
    }
}

/// The pass that draws the head.
pub struct HeadPass {
    pipeline: wgpu::RenderPipeline,
}

impl HeadPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let path = "pass/head.wgsl";
        let target = |format| {
            Some(wgpu::ColorTargetState {
                format,
                blend: None,
                write_mask: wgpu::ColorWrites::ALL,
            })
        };
        let pipeline = with_module(gpu, path, &[], |module| {
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
                    depth_stencil: Some(wgpu::DepthStencilState {
                        format: Z_FORMAT,
                        depth_write_enabled: Some(true),
                        depth_compare: Some(wgpu::CompareFunction::Less),
                        stencil: Default::default(),
                        bias: Default::default(),
                    }),
                    multisample: wgpu::MultisampleState::default(),
                    fragment: Some(wgpu::FragmentState {
                        module,
                        entry_point: Some("fragment"),
                        compilation_options: Default::default(),
                        targets: &[target(COLOUR_FORMAT), target(DEPTH_FORMAT)],
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        })?;
        Ok(Self { pipeline })
    }

    /// Clears the target and draws the mesh, if there is one, into it.
    pub fn draw(&self, gpu: &Gpu, camera: &CameraUniform, head: &HeadBuffers, target: &HeadTarget) {
        let camera = gpu.uniform_of("head camera", camera);
        let entries = [(0, &camera), (1, &head.positions), (2, &head.radiance)].map(|(binding, buffer)| {
            wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            }
        });
        let bound = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("head"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let [colour, depth, z] =
            [&target.colour, &target.depth, &target.z].map(|t| t.create_view(&Default::default()));
        let attachment = |view| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("head"),
                color_attachments: &[attachment(&colour), attachment(&depth)],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &z,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Clear(1.0),
                        store: wgpu::StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &bound, &[]);
            pass.set_index_buffer(head.triangles.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..head.index_count, 0, 0..1);
        }
        gpu.queue.submit([encoder.finish()]);
    }
}

/// The head's mesh on the GPU.
pub struct HeadBuffers {
    /// World positions and the share of the skin that is grown over with hair, vec4 a vertex.
    pub positions: wgpu::Buffer,
    /// Outward normals, vec4 a vertex.
    pub normals: wgpu::Buffer,
    /// Scene-linear radiance, vec4 a vertex.
    pub radiance: wgpu::Buffer,
    /// Vertex indices, three a triangle.
    pub triangles: wgpu::Buffer,
    /// Number of vertices.
    pub vertex_count: u32,
    /// Number of indices.
    pub index_count: u32,
}

impl HeadBuffers {
    /// Uploads `mesh` with the [`undergrowth`](crate::groom::undergrowth) of its vertices.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`].
    pub fn new(gpu: &Gpu, mesh: &Mesh, undergrowth: &[f32]) -> Result<Self, GpuError> {
        let normals: Vec<_> = mesh.normals().iter().map(|n| n.extend(0.0).to_array()).collect();
        let positions: Vec<_> = mesh
            .positions()
            .iter()
            .zip(undergrowth)
            .map(|(p, share)| p.extend(*share).to_array())
            .collect();
        let indices = mesh.triangles().as_flattened();
        let triangles = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("head triangles"),
            contents: bytemuck::cast_slice(indices),
            usage: wgpu::BufferUsages::INDEX,
        });
        Ok(Self {
            positions: gpu.storage_of("head positions", &positions)?,
            normals: gpu.storage_of("head normals", &normals)?,
            radiance: gpu.storage("head radiance", 16 * mesh.positions().len() as u64)?,
            triangles,
            vertex_count: mesh.positions().len() as u32,
            index_count: indices.len() as u32,
        })
    }
}

/// Diffuse reflectance of the head: a quiet grey, so that the hair is the only colourful thing.
const HEAD_ALBEDO: f32 = 0.2;

/// How far above the skin shadow rays start, voxels.
const SHADOW_OFFSET: f32 = 0.5;

/// Layout of `HeadUniform` in `shaders/pass/head_shade.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct HeadUniform {
    vertex_count: u32,
    light_count: u32,
    albedo: f32,
    offset: f32,
}

/// The pass that lights the head's vertices.
pub struct HeadShade {
    kernel: Kernel,
}

impl HeadShade {
    /// Compiles the pass.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            kernel: Kernel::new(gpu, "pass/head_shade.wgsl", &[])?,
        })
    }

    /// Fills the head's radiance from the lights that `transmittance` and `lights` (the same ones) hold.
    pub fn run(
        &self,
        gpu: &Gpu,
        head: &HeadBuffers,
        transmittance: &Transmittance,
        lights: &wgpu::Buffer,
        light_count: usize,
    ) {
        let parts = (
            transmittance.volume_buffers(),
            transmittance.light_buffer(),
            transmittance.direction_buffer(),
        );
        let (Some([grid, bricks, density]), Some(frames), Some(directions)) = parts else {
            return;
        };
        let uniform = gpu.uniform_of(
            "head",
            &HeadUniform {
                vertex_count: head.vertex_count,
                light_count: light_count as u32,
                albedo: HEAD_ALBEDO,
                offset: SHADOW_OFFSET,
            },
        );
        let bound = self.kernel.bind(
            gpu,
            &[
                (0, grid),
                (1, bricks),
                (2, density),
                (3, frames),
                (4, directions),
                (5, lights),
                (6, &uniform),
                (7, &head.positions),
                (8, &head.normals),
                (9, &head.radiance),
            ],
        );
        self.kernel.run(gpu, &bound, head.vertex_count);
    }
}
