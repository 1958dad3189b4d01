//! The picture as a display shows it: exposure, view transform, sRGB.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use super::raster::PictureBuffers;
use super::{Gpu, GpuError, Kernel};

/// How scene-linear colour becomes display colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ViewTransform {
    /// Khronos PBR Neutral.
    #[default]
    Neutral,
    /// AgX (Sobotka), base look.
    Agx,
    /// Clipped at 1.
    Raw,
}

/// Layout of `ViewUniform` in `shaders/pass/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ViewUniform {
    /// Display-linear colour behind the picture; a = 0 keeps the picture's alpha instead.
    pub backdrop: [f32; 4],
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Factor on the picture before the transform.
    pub scale: f32,
    /// 0 neutral, 1 AgX, 2 raw.
    pub transform: u32,
}

/// The pass and its target.
pub struct ViewPass {
    kernel: Kernel,
    bad_pixels: wgpu::Buffer,
    /// What is shown: sRGB-encoded, straight alpha.
    pub shown: wgpu::Texture,
}

impl ViewPass {
    /// Compiles the pass.
    ///
    /// # Errors
    /// [`GpuError::Refused`].
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            kernel: Kernel::new(gpu, "pass/view.wgsl", &[])?,
            bad_pixels: gpu.storage("non-finite pixels", 4)?,
            shown: target(gpu, [1, 1]),
        })
    }

    /// Fills [`Self::shown`] from the picture.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        buffers: &PictureBuffers,
        transform: ViewTransform,
        scale: f32,
        backdrop: [f32; 4],
    ) {
        let size = buffers.size;
        if [self.shown.width(), self.shown.height()] != size {
            self.shown = target(gpu, size);
        }
        let transform = match transform {
            ViewTransform::Neutral => 0,
            ViewTransform::Agx => 1,
            ViewTransform::Raw => 2,
        };
        let uniform = gpu.uniform_of(
            "view",
            &ViewUniform {
                backdrop,
                size,
                scale,
                transform,
            },
        );
        let view = self.shown.create_view(&Default::default());
        let bound = self.kernel.bind_entries(
            gpu,
            &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: uniform.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 1,
                    resource: buffers.picture.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 2,
                    resource: self.bad_pixels.as_entire_binding(),
                },
                wgpu::BindGroupEntry {
                    binding: 3,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
            ],
        );
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.bad_pixels, 0, None);
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            self.kernel
                .dispatch(&mut pass, &bound, [size[0].div_ceil(8), size[1].div_ceil(8), 1]);
        }
        gpu.queue.submit([encoder.finish()]);
    }

    /// Pixels of the last run that were not finite (shown in magenta).
    ///
    /// # Errors
    /// [`GpuError::Lost`].
    pub fn non_finite(&self, gpu: &Gpu) -> Result<u32, GpuError> {
        Ok(gpu.read::<u32>(&self.bad_pixels, 1)?[0])
    }

    /// RGBA bytes of what is shown, row after row.
    ///
    /// # Errors
    /// [`GpuError::Lost`], [`GpuError::TooLarge`].
    pub fn bytes(&self, gpu: &Gpu) -> Result<Vec<u8>, GpuError> {
        let (width, height) = (self.shown.width(), self.shown.height());
        let row = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let staging = gpu.storage("shown bytes", u64::from(row) * u64::from(height))?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.shown.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row),
                    rows_per_image: None,
                },
            },
            self.shown.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let padded = gpu.read::<u8>(&staging, (row * height) as usize)?;
        Ok(padded
            .chunks(row as usize)
            .flat_map(|r| &r[..4 * width as usize])
            .copied()
            .collect())
    }
}

fn target(gpu: &Gpu, size: [u32; 2]) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shown"),
        size: wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}
