//! What surrounds each point of a strand: fibres so near that they hide it from the eye and from a light beside the eye alike.

use half::f16;
use rayon::prelude::*;

use super::density::{EMPTY_BRICK, SOLID_BRICK};
use super::{BRICK_VOXELS, DensityVolume, Strands};

/// The fibres in the voxel of a point, its own strand left out; what `shaders/lib/hot_spot.wgsl` reads.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Neighbours {
    /// A quarter of length times diameter squared over the voxel's volume: 1 / pi of the share that fibres fill.
    pub filled: f16,
    /// Mean squared sine of the angles between them and the point's strand, weighted alike, in [0, 1].
    pub spread: f16,
}

impl Neighbours {
    /// One per point of `strands`, which are those that `volume` was built from.
    pub fn of(volume: &DensityVolume, strands: &Strands<'_>) -> Vec<Self> {
        (0..strands.strand_count())
            .into_par_iter()
            .flat_map_iter(|strand| {
                strands
                    .strand(strand)
                    .map(move |point| Self::around(volume, strands, strand, point))
            })
            .collect()
    }

    fn around(volume: &DensityVolume, strands: &Strands<'_>, strand: usize, point: usize) -> Self {
        let grid = &volume.grid;
        let address = grid.address(grid.grid_from_world(strands.positions[point]).floor().as_ivec3());
        let slot = volume.bricks[(address / BRICK_VOXELS) as usize];
        let own = strands.segments(strand);
        if slot == EMPTY_BRICK || slot == SOLID_BRICK || own.is_empty() {
            return Self::default();
        }
        let at = (slot * BRICK_VOXELS + address % BRICK_VOXELS) as usize;
        let area = f16::from_bits(volume.density[at][0] as u16).to_f32();
        let along = |p: usize| (strands.positions[p + 1] - strands.positions[p]).normalize_or_zero();
        let tangent = along(point.min(own.end - 1));
        let shares = volume.first_share[at] as usize..volume.first_share[at + 1] as usize;
        let (mut filled, mut across) = (0.0, 0.0);
        for share in &volume.shares[shares] {
            let i = share.point as usize;
            if own.contains(&i) {
                continue;
            }
            let diameter = 0.5 * (strands.diameters[i] + strands.diameters[i + 1]) / grid.voxel_size;
            let part = 0.25 * area * share.weight.to_f32() * diameter;
            filled += part;
            across += part * (1.0 - along(i).dot(tangent).powi(2));
        }
        let spread = if filled > 0.0 { across / filled } else { 0.0 };
        Self {
            filled: f16::from_f32(filled.min(1.0)),
            spread: f16::from_f32(spread.clamp(0.0, 1.0)),
        }
    }
}
