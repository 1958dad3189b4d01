//! What surrounds each point of a strand: fibres so near that they hide it from the eye and from a light beside the eye alike.

use half::f16;
use rayon::prelude::*;

use super::density::{EMPTY_BRICK, SOLID_BRICK, SOLID_RHO};
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
        // Roots lie in voxels of the head, whose density is its mark.
        if area >= SOLID_RHO {
            return Self::default();
        }
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

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::volume::{Occluder, VolumeSettings};

    #[test]
    fn the_other_strand_of_a_voxel_counts_and_a_head_does_not() {
        let positions: Vec<Vec3> = [0.0, 0.01]
            .iter()
            .flat_map(|x| [-1.0_f32, 0.05, 1.0].map(|y| Vec3::new(*x, y, 0.0)))
            .collect();
        let strands = Strands {
            positions: &positions,
            diameters: &[0.002; 6],
            first_point: &[0, 3, 6],
        };
        let settings = VolumeSettings {
            voxel_size: Some(0.1),
            ..VolumeSettings::default()
        };
        let of = |occluder: Option<&Occluder<'_>>| {
            Neighbours::of(&DensityVolume::build(&strands, occluder, &settings), &strands)
        };
        // One straight fibre through the voxel: length times diameter squared over volume, a quarter of it.
        let expected = 0.25 * 0.1 * 0.002_f32.powi(2) / 0.1_f32.powi(3);
        let free = of(None)[1];
        assert!((free.filled.to_f32() / expected - 1.0).abs() < 0.01, "{free:?}");
        assert!(free.spread.to_f32() < 1e-3, "{free:?}");

        let corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)];
        let corners = corners.map(|(x, y, z)| 1.5 * Vec3::new(x as f32, y as f32, z as f32));
        let head = Occluder {
            positions: &corners,
            triangles: &[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
        };
        assert_eq!(of(Some(&head))[1], Neighbours::default());
    }
}
