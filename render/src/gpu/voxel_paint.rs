//! Which voxels a change of paint touches: those that fibres between changed points cross.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::{Gpu, GpuError};
use crate::volume::DensityVolume;

/// Layout of `PaintRun` in `shaders/pass/density_paint.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct PaintRun {
    /// Voxels to paint.
    pub count: u32,
    /// 0: the first ones; 1: those of the list.
    pub is_listed: u32,
    pub pad: [u32; 2],
}

/// Points whose paint has changed since voxels were painted.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum DirtyPoints {
    /// All of them.
    All,
    /// Those of the ranges, which may overlap; none where there is no range.
    Some(Vec<Range<u32>>),
}

impl DirtyPoints {
    pub const NONE: Self = Self::Some(Vec::new());

    /// These as well; no range at all stands for all points.
    pub fn add(&mut self, ranges: &[Range<u32>]) {
        match self {
            Self::All => {}
            Self::Some(_) if ranges.is_empty() => *self = Self::All,
            Self::Some(dirty) => dirty.extend_from_slice(ranges),
        }
    }
}

/// The stored voxels that each segment of the strands crosses.
pub(super) struct SegmentVoxels {
    /// First entry of every segment (named by its first point) in `voxels`, and the number of entries.
    first: Vec<u32>,
    voxels: Vec<u32>,
}

impl SegmentVoxels {
    /// Turns a volume's table of fibres per voxel round.
    pub fn new(volume: &DensityVolume, point_count: usize) -> Self {
        let mut first = vec![0; point_count + 1];
        for share in &volume.shares {
            first[share.point as usize + 1] += 1;
        }
        for i in 0..point_count {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut voxels = vec![0; volume.shares.len()];
        for (voxel, ends) in volume.first_share.windows(2).enumerate() {
            for share in &volume.shares[ends[0] as usize..ends[1] as usize] {
                let at = &mut next[share.point as usize];
                voxels[*at as usize] = voxel as u32;
                *at += 1;
            }
        }
        Self { first, voxels }
    }

    /// The voxels whose fibres' paint lies at one of the dirty points, each once, in their order; `None`: all.
    pub fn touched(&self, dirty: &DirtyPoints) -> Option<Vec<u32>> {
        let DirtyPoints::Some(ranges) = dirty else {
            return None;
        };
        let last = self.first.len() - 1;
        // Most of the points: a list would cost more than it saves.
        if ranges.iter().map(ExactSizeIterator::len).sum::<usize>() > last / 2 {
            return None;
        }
        let mut touched: Vec<u32> = ranges
            .iter()
            .flat_map(|range| {
                // A segment takes paint from both its points.
                let points =
                    (range.start.saturating_sub(1) as usize).min(last)..(range.end as usize).min(last);
                let entries =
                    self.first[points.start] as usize..self.first[points.end.max(points.start)] as usize;
                &self.voxels[entries]
            })
            .copied()
            .collect();
        touched.sort_unstable();
        touched.dedup();
        Some(touched)
    }
}

/// The uniform and the list that `pass/density_paint.wgsl` takes for `touched` of `stored` voxels.
pub(super) fn paint_run(
    gpu: &Gpu,
    touched: Option<&[u32]>,
    stored: u32,
) -> Result<(wgpu::Buffer, wgpu::Buffer, u32), GpuError> {
    let count = touched.map_or(stored, |voxels| voxels.len() as u32);
    let run = PaintRun {
        count,
        is_listed: u32::from(touched.is_some()),
        pad: [0; 2],
    };
    Ok((
        gpu.uniform_of("voxels to paint", &run),
        gpu.storage_of("list of voxels to paint", touched.unwrap_or_default())?,
        count,
    ))
}
