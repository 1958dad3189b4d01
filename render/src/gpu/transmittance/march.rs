//! Marches from points to lights and the records that they write.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::light_buffers::LightBuffers;
use super::volume_buffers::VolumeBuffers;
use super::{ExactLights, LightBatch, PATH_BYTES, Transmittance, VISIBILITY_BYTES};
use crate::gpu::{Gpu, GpuError};

/// One light of a march, same layout as `LightRun` in the passes.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct LightRun {
    point_count: u32,
    light: u32,
    first_record: u32,
    prior: f32,
    first_ray: u32,
    end_ray: u32,
    is_again: u32,
}

/// Exact rays that one thread traces to a light: Mesa's software driver ends a thread's loops after 65,535 rounds in all, and a ray may cross a
/// thousand voxels.
const RAYS_PER_RUN: u32 = 32;

/// Pairs of a light and a point that are marched in one submission, where the points of one light are not more.
const MARCHED_AT_ONCE: u32 = 1 << 15;

impl Transmittance {
    /// Marches from the listed points to those of `lights` that are numbered, in submissions small enough that a slow adapter stays
    /// responsive between them.
    pub(super) fn march_lights(
        &self,
        gpu: &Gpu,
        volume: &VolumeBuffers,
        lights: &LightBuffers,
        records: Records<'_>,
        listed_points: u32,
        numbered: &[u32],
    ) -> Result<(), GpuError> {
        let lights_at_once = (MARCHED_AT_ONCE / listed_points.max(1)).max(1) as usize;
        let (light_table, directions) = match records {
            Records::Exact(exact) => (&exact.lights, &exact.directions),
            _ => (&lights.lights, &lights.directions),
        };
        let run = |batch: &LightBatch, light: u32| LightRun {
            point_count: volume.point_count,
            light,
            first_record: (light - batch.lights.start) * volume.point_count,
            prior: 0.0,
            first_ray: 0,
            end_ray: 0,
            is_again: u32::from(matches!(records, Records::PathAgain(_))),
        };
        for batch in self.batches.iter().filter(|_| listed_points > 0) {
            let numbered = numbered.iter().copied();
            let runs: Vec<LightRun> = numbered
                .filter(|light| batch.lights.contains(light))
                .map(|light| run(batch, light))
                .collect();
            // Runs of one light add up in one record: each waits for the one before.
            let rounds = match records {
                Records::Exact(exact) => (0..exact.rays)
                    .step_by(RAYS_PER_RUN as usize)
                    .map(|first| exact.runs(&runs, first..first + RAYS_PER_RUN))
                    .collect(),
                _ => vec![runs],
            };
            for runs in rounds.iter().flat_map(|runs| runs.chunks(lights_at_once)) {
                let run_table = gpu.storage_of("light runs", runs)?;
                let common = [
                    (0, &volume.grid),
                    (1, &volume.bricks),
                    (2, &volume.density),
                    (3, &volume.points),
                    (4, &volume.point_ends),
                    (5, light_table),
                    (6, directions),
                    (7, &run_table),
                ];
                let boxes = match records {
                    Records::PathAgain(boxes) => boxes,
                    // Not read.
                    _ => &volume.points,
                };
                let (kernel, own): (_, &[(u32, &wgpu::Buffer)]) = match records {
                    Records::Visibility => (
                        &self.visibility,
                        &[(8, &batch.visibility), (9, &volume.visibility_work.items)],
                    ),
                    Records::Exact(_) => (
                        &self.visibility_exact,
                        &[
                            (8, &batch.visibility),
                            (9, &volume.visibility_work.items),
                            (10, &volume.first_share),
                            (11, &volume.shares),
                        ],
                    ),
                    Records::Path | Records::PathAgain(_) => (
                        &self.path,
                        &[
                            (8, &volume.forward),
                            (9, &volume.behind),
                            (10, &batch.path),
                            (11, &volume.path_work.items),
                            (12, boxes),
                            (13, &volume.path_marks),
                        ],
                    ),
                };
                let bindings = kernel.bind(gpu, &[&common, own].concat());
                kernel.run(gpu, &bindings, listed_points * runs.len() as u32);
            }
        }
        Ok(())
    }
}

impl ExactLights {
    /// The runs that trace `rays` of their lights, as far as those have so many.
    fn runs(&self, runs: &[LightRun], rays: Range<u32>) -> Vec<LightRun> {
        let of_light = |run: &LightRun| {
            let (count, prior) = self.rays_and_prior[run.light as usize];
            (rays.start < count).then_some(LightRun {
                prior,
                first_ray: rays.start,
                end_ray: rays.end.min(count),
                ..*run
            })
        };
        runs.iter().filter_map(of_light).collect()
    }
}

/// Which of the two records is written, and how.
#[derive(Clone, Copy)]
pub(super) enum Records<'a> {
    Visibility,
    Exact(&'a ExactLights),
    Path,
    /// Where the way crosses one of these boxes; points whose record changes are marked.
    PathAgain(&'a wgpu::Buffer),
}

/// As many lights a batch as the adapter's limits allow.
pub(super) fn allocate_batches(
    gpu: &Gpu,
    point_count: u32,
    light_count: u32,
) -> Result<Vec<LightBatch>, GpuError> {
    let limit = gpu.most_bound_bytes();
    let per_light = PATH_BYTES * u64::from(point_count).max(1);
    let lights_per_batch = (limit / per_light).clamp(1, u64::from(light_count.max(1))) as usize;
    (0..light_count)
        .step_by(lights_per_batch)
        .map(|first| {
            let lights = first..(first + lights_per_batch as u32).min(light_count);
            let records = lights.len() as u64 * u64::from(point_count);
            Ok(LightBatch {
                lights,
                visibility: gpu.storage("visibility records", VISIBILITY_BYTES * records)?,
                path: gpu.storage("path records", PATH_BYTES)?,
            })
        })
        .collect()
}
