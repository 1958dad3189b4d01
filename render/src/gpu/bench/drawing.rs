//! Strands drawn for their time.

use std::time::Instant;

use bytemuck::Zeroable;

use super::Ribbons;
use crate::gpu::camera::CameraUniform;
use crate::gpu::head::HeadTarget;
use crate::gpu::raster::{PictureBuffers, Raster, ResolveInputs, ResolveUniform};
use crate::gpu::strands::StrandBuffers;
use crate::gpu::{Gpu, GpuError};

/// A way to draw strands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnBy {
    /// Lists of fragments per pixel: [`Raster`], which pictures are made with.
    Fragments,
    /// Hardware triangles: [`Ribbons`].
    Ribbons,
}

/// Seconds of the fastest of `runs` draws from nothing, after one that warms up, and the picture: premultiplied RGBA without a background.
///
/// # Errors
/// [`GpuError`] where the picture exceeds what the adapter holds, a shader is refused or the device is lost.
pub fn draw_strands(
    gpu: &Gpu,
    way: DrawnBy,
    camera: &CameraUniform,
    strands: &StrandBuffers,
    runs: u32,
) -> Result<(f64, Vec<[f32; 4]>), GpuError> {
    match way {
        DrawnBy::Fragments => fragments(gpu, camera, strands, runs),
        DrawnBy::Ribbons => ribbons(gpu, camera, strands, runs),
    }
}

/// Seconds of the fastest draw, after one that warms up.
fn fastest(gpu: &Gpu, runs: u32, mut draw: impl FnMut() -> Result<(), GpuError>) -> Result<f64, GpuError> {
    let mut fastest = f64::INFINITY;
    for run in 0..=runs {
        let start = Instant::now();
        draw()?;
        gpu.wait()?;
        if run > 0 {
            fastest = fastest.min(start.elapsed().as_secs_f64());
        }
    }
    Ok(fastest)
}

fn fragments(
    gpu: &Gpu,
    camera: &CameraUniform,
    strands: &StrandBuffers,
    runs: u32,
) -> Result<(f64, Vec<[f32; 4]>), GpuError> {
    let target = PictureBuffers::new(gpu, camera.size)?;
    let inputs = ResolveInputs {
        strands,
        head: &HeadTarget::new(gpu, [1, 1])?,
        background: &gpu.storage("background", 16)?,
        target: &target,
        has_head: false,
        interpolates_straight: false,
        touched_only: false,
    };
    let resolve = ResolveUniform {
        weight: 1.0,
        gain: [1.0; 3],
        ..Zeroable::zeroed()
    };
    let mut raster = Raster::new(gpu)?;
    let fastest = fastest(gpu, runs, || {
        raster.forget();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&target.picture, 0, None);
        gpu.queue.submit([encoder.finish()]);
        raster.draw(gpu, camera, &resolve, &inputs, || Ok(())).map(|_| ())
    })?;
    let pixels = camera.size[0] as usize * camera.size[1] as usize;
    Ok((fastest, gpu.read(&target.picture, pixels)?))
}

fn ribbons(
    gpu: &Gpu,
    camera: &CameraUniform,
    strands: &StrandBuffers,
    runs: u32,
) -> Result<(f64, Vec<[f32; 4]>), GpuError> {
    let ribbons = Ribbons::new(gpu, camera.size)?;
    let fastest = fastest(gpu, runs, || {
        ribbons.draw(gpu, camera, strands);
        Ok(())
    })?;
    let pixels = camera.size[0] as usize * camera.size[1] as usize;
    Ok((fastest, gpu.read(&ribbons.picture, pixels)?))
}
