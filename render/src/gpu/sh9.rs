//! Visibility from nine spherical harmonics per block of voxels, with gradients: the transmittance of Xing 2012, section 5, for comparison.
//!
//! `sh9_project` marches from the middle of every block of 2 x 2 x 2 voxels that holds fibres into directions all over the sphere and keeps
//! coefficients and their gradients; `visibility_sh9` interpolates them at the listed points (Eq 7) and reads every light's lobe off them. It fills the same
//! records as the march towards each light. The samples depend on the strands alone: new lights cost one pass over the points.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::lights::fibonacci_direction;
use super::transmittance::LightBatch;
use super::{Gpu, GpuError, Kernel};

/// Directions that a sample marches into.
const DIRECTIONS: u32 = 64;

/// Directions of one dispatch: Mesa's software driver ends a thread's loops after 65,535 rounds.
const DIRECTIONS_PER_DISPATCH: u32 = 8;

/// Blocks of a brick and bytes of a block, as in `shaders/lib/sh9_samples.wgsl`.
const BLOCKS_OF_BRICK: u32 = 8;
const SAMPLE_BYTES: u64 = 10 * 16;

/// Layout of `Projection` in `shaders/pass/sh9_project.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Projection {
    first_direction: u32,
    direction_count: u32,
    all_directions: u32,
    diameter: f32,
}

/// What the passes read of a volume and of the strands in it.
pub(super) struct VolumeParts<'a> {
    pub grid: &'a wgpu::Buffer,
    pub bricks: &'a wgpu::Buffer,
    pub density: &'a wgpu::Buffer,
    pub points: &'a wgpu::Buffer,
    pub point_count: u32,
    /// Entries of the brick table, stored or not.
    pub brick_count: u32,
    /// Bricks that are stored.
    pub stored_bricks: u32,
    /// Mean diameter of the fibres, voxels.
    pub mean_diameter: f32,
}

/// The passes and the samples of the strands that were projected last.
pub(super) struct Harmonics {
    project: Kernel,
    visibility: Kernel,
    directions: wgpu::Buffer,
    samples: Option<wgpu::Buffer>,
}

impl Harmonics {
    /// Compiles the passes.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let directions: Vec<[f32; 4]> = (0..DIRECTIONS as usize)
            .map(|k| fibonacci_direction(k, DIRECTIONS as usize))
            .map(|Vec3 { x, y, z }| [x, y, z, 0.0])
            .collect();
        Ok(Self {
            project: Kernel::new(gpu, "pass/sh9_project.wgsl", &[])?,
            visibility: Kernel::new(gpu, "pass/visibility_sh9.wgsl", &[])?,
            directions: gpu.storage_of("directions of harmonics", &directions)?,
            samples: None,
        })
    }

    /// The strands changed: samples of earlier ones are worth nothing.
    pub fn forget(&mut self) {
        self.samples = None;
    }

    /// Writes the visibility of all `batches` at the `listed` points of `work`; projects the samples where there are none.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        volume: &VolumeParts<'_>,
        lights: &wgpu::Buffer,
        batches: &[LightBatch],
        work: &wgpu::Buffer,
        listed: u32,
    ) -> Result<(), GpuError> {
        let samples = match &self.samples {
            Some(samples) => samples,
            None => self
                .samples
                .insert(project(gpu, &self.project, &self.directions, volume)?),
        };
        for batch in batches {
            let uniform = [
                batch.lights.start,
                batch.lights.len() as u32,
                volume.point_count,
                0,
            ];
            let bindings = [
                (0, volume.grid),
                (1, volume.bricks),
                (3, volume.points),
                (4, samples),
                (5, lights),
                (6, work),
                (7, &batch.visibility),
                (8, &gpu.uniform_of("batch of lights", &uniform)),
            ];
            self.visibility
                .run(gpu, &self.visibility.bind(gpu, &bindings), listed);
        }
        Ok(())
    }
}

/// Samples of all blocks that hold fibres.
fn project(
    gpu: &Gpu,
    kernel: &Kernel,
    directions: &wgpu::Buffer,
    volume: &VolumeParts<'_>,
) -> Result<wgpu::Buffer, GpuError> {
    let blocks = u64::from(volume.stored_bricks * BLOCKS_OF_BRICK);
    let samples = gpu.storage("harmonics of visibility", SAMPLE_BYTES * blocks)?;
    for first_direction in (0..DIRECTIONS).step_by(DIRECTIONS_PER_DISPATCH as usize) {
        let projection = Projection {
            first_direction,
            direction_count: DIRECTIONS_PER_DISPATCH,
            all_directions: DIRECTIONS,
            diameter: volume.mean_diameter,
        };
        let bindings = [
            (0, volume.grid),
            (1, volume.bricks),
            (2, volume.density),
            (3, &gpu.uniform_of("projection", &projection)),
            (4, directions),
            (5, &samples),
        ];
        kernel.run(
            gpu,
            &kernel.bind(gpu, &bindings),
            volume.brick_count * BLOCKS_OF_BRICK,
        );
    }
    Ok(samples)
}
