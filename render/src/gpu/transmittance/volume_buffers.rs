//! The density volume and the groom's points on the GPU.

use glam::UVec3;

use crate::gpu::sh9::VolumeParts;
use crate::gpu::voxel_paint::SegmentVoxels;
use crate::gpu::work_list::WorkList;
use crate::gpu::{Gpu, GpuError};
use crate::volume::{BRICK_VOXELS, DensityVolume, Grid, Neighbours, Strands};

/// The volume on the GPU.
pub(super) struct VolumeBuffers {
    pub(super) grid: wgpu::Buffer,
    pub(super) bricks: wgpu::Buffer,
    pub(super) density: wgpu::Buffer,
    pub(super) first_share: wgpu::Buffer,
    pub(super) shares: wgpu::Buffer,
    pub(super) forward: wgpu::Buffer,
    pub(super) behind: wgpu::Buffer,
    pub(super) points: wgpu::Buffer,
    pub(super) point_ends: wgpu::Buffer,
    /// [`Neighbours`] of every point.
    pub(super) neighbours: wgpu::Buffer,
    pub(super) every_point: wgpu::Buffer,
    pub(super) visibility_work: WorkList,
    pub(super) path_work: WorkList,
    /// Rays marched, then a mark for every point whose path sums changed.
    pub(super) path_marks: wgpu::Buffer,
    pub(super) point_count: u32,
    /// Places of the stored bricks, in bricks.
    pub(super) stored_bricks: Vec<UVec3>,
    pub(super) stored_voxels: u32,
    pub(super) brick_count: u32,
    /// Mean diameter of the fibres, voxels.
    pub(super) mean_diameter: f32,
    pub(super) segment_voxels: SegmentVoxels,
}

impl VolumeBuffers {
    pub(super) fn upload(gpu: &Gpu, volume: &DensityVolume, strands: &Strands<'_>) -> Result<Self, GpuError> {
        let grid: Grid = volume.grid;
        let paint_bytes = 16 * u64::from(grid.stored_voxels);
        let points: Vec<[f32; 4]> = strands
            .positions
            .iter()
            .zip(strands.diameters)
            .map(|(position, diameter)| {
                let p = grid.grid_from_world(*position).as_vec3();
                [p.x, p.y, p.z, diameter / grid.voxel_size]
            })
            .collect();
        let mut ends = vec![0_u32; points.len()];
        for index in 0..strands.strand_count() {
            let points = strands.strand(index);
            ends[points.clone()].fill((index as u32) << 2);
            ends[points.start] |= 1;
            ends[points.end - 1] |= 2;
        }
        Ok(Self {
            grid: gpu.uniform_of("volume grid", &grid),
            bricks: gpu.storage_of("volume bricks", &volume.bricks)?,
            density: gpu.storage_of("volume density", &volume.density)?,
            first_share: gpu.storage_of("voxel shares' ends", &volume.first_share)?,
            shares: gpu.storage_of("voxel shares", &volume.shares)?,
            forward: gpu.storage("voxel forward losses", paint_bytes)?,
            behind: gpu.storage("voxel decay", paint_bytes)?,
            points: gpu.storage_of("points in grid space", &points)?,
            point_ends: gpu.storage_of("strand ends", &ends)?,
            neighbours: gpu.storage_of("neighbours", &Neighbours::of(volume, strands))?,
            every_point: gpu.storage_of("every point", &vec![1_u32; points.len()])?,
            visibility_work: WorkList::new(gpu, "visibility to do", points.len() as u32)?,
            path_work: WorkList::new(gpu, "path sums to do", points.len() as u32)?,
            path_marks: gpu.storage("changed path sums", 4 * (points.len() as u64 + 1))?,
            stored_bricks: stored_bricks(volume),
            point_count: points.len() as u32,
            stored_voxels: grid.stored_voxels,
            brick_count: grid.brick_count() as u32,
            mean_diameter: points.iter().map(|p| p[3]).sum::<f32>() / points.len().max(1) as f32,
            segment_voxels: SegmentVoxels::new(volume, points.len()),
        })
    }

    pub(super) fn parts(&self) -> VolumeParts<'_> {
        VolumeParts {
            grid: &self.grid,
            bricks: &self.bricks,
            density: &self.density,
            points: &self.points,
            point_count: self.point_count,
            brick_count: self.brick_count,
            stored_bricks: self.stored_voxels / BRICK_VOXELS,
            mean_diameter: self.mean_diameter,
        }
    }
}

/// Places of the bricks that are stored, in the order they are stored in.
fn stored_bricks(volume: &DensityVolume) -> Vec<UVec3> {
    let grid = &volume.grid;
    let mut places = vec![UVec3::ZERO; (grid.stored_voxels / BRICK_VOXELS) as usize];
    for (brick, slot) in (0_u32..).zip(&volume.bricks) {
        // Empty and solid bricks have slots beyond all stored ones.
        if let Some(place) = places.get_mut(*slot as usize) {
            let row = brick / grid.bricks.x;
            *place = UVec3::new(brick % grid.bricks.x, row % grid.bricks.y, row / grid.bricks.y);
        }
    }
    places
}
