//! Lights that exact rays are traced to.

use crate::gpu::{Gpu, GpuError};
use crate::light::SrbfLight;
use crate::volume::lobe::exact_tables;

/// The lights with the directions of exact rays, so many to a light.
pub(super) struct ExactLights {
    pub(super) rays: u32,
    pub(super) total_rays: u64,
    /// Rays to each light, and the weight of the marched record beside them.
    pub(super) rays_and_prior: Vec<(u32, f32)>,
    pub(super) lights: wgpu::Buffer,
    pub(super) directions: wgpu::Buffer,
}

/// Exact rays that the march through the voxels is worth, measured: its root mean square error is theirs.
const MARCH_WORTH: f32 = 16.0;

/// Rays per light above which the march has nothing to add.
const REFERENCE_RAYS: u32 = 128;

/// Weight of the marched record beside `count` rays, where `rays` were asked for.
fn prior(rays: u32, count: u32) -> f32 {
    if rays >= REFERENCE_RAYS {
        return 0.0;
    }
    MARCH_WORTH / (MARCH_WORTH + count as f32)
}

impl ExactLights {
    pub(super) fn new(gpu: &Gpu, lights: &[SrbfLight], rays: u32) -> Result<Self, GpuError> {
        let (frames, directions) = exact_tables(lights, rays);
        Ok(Self {
            rays,
            rays_and_prior: frames
                .iter()
                .map(|frame| (frame.visibility_count, prior(rays, frame.visibility_count)))
                .collect(),
            total_rays: frames.iter().map(|frame| u64::from(frame.visibility_count)).sum(),
            lights: gpu.storage_of("lights of exact rays", &frames)?,
            directions: gpu.storage_of("directions of exact rays", &directions)?,
        })
    }
}
