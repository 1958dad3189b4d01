//! The density volume: how much fibre there is in every voxel, and which way it runs.

use glam::{DVec3, IVec3, Vec3};
use half::f16;
use rayon::prelude::*;

use super::clip::clip_segment;
use super::grid::fibre_spacing;
use super::{BRICK_VOXELS, Grid, Occluder, Strands};

/// Brick table entry of a brick without fibres.
pub const EMPTY_BRICK: u32 = u32::MAX;

/// Brick table entry of a brick that lies inside an occluder.
pub const SOLID_BRICK: u32 = u32::MAX - 1;

/// Density of a voxel inside an occluder: the largest half float, which no hair reaches.
pub(super) const SOLID_RHO: f32 = 65504.0;

/// Largest density that is stored for fibres.
const MAX_RHO: f64 = 60000.0;

/// Resolution and memory of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeSettings {
    /// Voxel size in fibre spacings; from 1 to 2 the error of visibility changes little, time falls with it.
    pub voxel_spacings: f32,
    /// Voxel size in the groom's unit; takes the place of that in spacings.
    pub voxel_size: Option<f32>,
    /// Most voxels that may be stored (8 bytes each for the density, 32 for what paint adds); voxels grow until they fit.
    pub max_stored_voxels: u32,
    /// Most parts that segments may be cut into (8 bytes each); voxels grow until they fit.
    pub max_shares: u32,
}

impl Default for VolumeSettings {
    fn default() -> Self {
        Self {
            voxel_spacings: 1.25,
            voxel_size: None,
            max_stored_voxels: 4 << 20,
            max_shares: 12 << 20,
        }
    }
}

/// One fibre's part in one voxel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Share {
    /// First point of the segment.
    pub point: u32,
    /// Where on the segment, in [0, 1], the part has its middle.
    pub fraction: f16,
    /// The part's share of the projected area of all fibres in the voxel, in [0, 1].
    pub weight: f16,
}

/// Fibre density in bricks of 4 x 4 x 4 voxels; empty bricks cost four bytes.
///
/// With Q = sum over the fibres in a voxel of D * length * (1 - t t^T) / edge^2 (t the unit tangent), the expected number of fibres that a path of
/// one voxel edge along w crosses is D * length * sin(angle) / edge^2 summed, taken as sqrt(rho * w^T Q w) with rho = tr Q / 2.
pub struct DensityVolume {
    /// Placement and size.
    pub grid: Grid,
    /// First stored voxel of every brick divided by 64, or [`EMPTY_BRICK`] or [`SOLID_BRICK`]; x fastest.
    pub bricks: Vec<u32>,
    /// Per stored voxel: rho as f16, then Qxx/rho and Qyy/rho as 8-bit unorm; 2 Qyz/rho, 2 Qxz/rho and 2 Qxy/rho as 8-bit snorm.
    pub density: Vec<[u32; 2]>,
    /// First entry in `shares` of every stored voxel, and the number of entries at the end.
    pub first_share: Vec<u32>,
    /// What crosses the voxels, voxel after voxel, along the strands inside a voxel.
    pub shares: Vec<Share>,
}

/// A segment's part inside a voxel.
struct Clip {
    address: u32,
    segment: u32,
    t0: f32,
    t1: f32,
}

impl DensityVolume {
    /// Voxelizes strands and an optional occluder.
    pub fn build(strands: &Strands<'_>, occluder: Option<&Occluder<'_>>, settings: &VolumeSettings) -> Self {
        let _scope = tracing::info_span!("density volume").entered();
        let (low, high) = bounds_with_occluder(strands, occluder);
        let usual = || fibre_spacing(strands) * settings.voxel_spacings;
        let mut voxel_size = settings.voxel_size.unwrap_or_else(usual);
        loop {
            let grid = Grid::around(low, high, voxel_size);
            let clips = clip_strands(strands, &grid);
            let solid = occluder
                .map(|occluder| occluder.solid_voxels(&grid))
                .unwrap_or_default();
            let (bricks, stored) = number_bricks(&grid, &clips, &solid);
            let too_many_voxels = stored as f32 / settings.max_stored_voxels.max(1) as f32;
            let too_many_shares = clips.len() as f32 / settings.max_shares.max(1) as f32;
            if too_many_voxels.max(too_many_shares) <= 1.0 || grid.brick_count() == 1 {
                return Self::fill(
                    strands,
                    Grid {
                        stored_voxels: stored,
                        ..grid
                    },
                    bricks,
                    &clips,
                    &solid,
                );
            }
            // Voxels fall with the cube of their size, parts with the size itself.
            voxel_size = grid.voxel_size * 1.05 * too_many_voxels.cbrt().max(too_many_shares).max(1.0);
        }
    }

    /// Bytes of all tables.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.bricks[..])
            + size_of_val(&self.density[..])
            + size_of_val(&self.first_share[..])
            + size_of_val(&self.shares[..])
    }

    fn fill(strands: &Strands<'_>, grid: Grid, bricks: Vec<u32>, clips: &[Clip], solid: &[bool]) -> Self {
        let stored = grid.stored_voxels as usize;
        let mut density = vec![[0; 2]; stored];
        let mut first_share = vec![0; stored + 1];
        let mut shares = vec![
            Share {
                point: 0,
                fraction: f16::ZERO,
                weight: f16::ZERO
            };
            clips.len()
        ];

        // The clips are sorted by voxel, so that one voxel's clips are one run and its sums have one order.
        let mut start = 0;
        for run in clips.chunk_by(|a, b| a.address == b.address) {
            let voxel = stored_voxel(&bricks, run[0].address);
            let parts: Vec<_> = run.iter().map(|clip| part(strands, &grid, clip)).collect();
            let area: f64 = parts.iter().map(|p| p.area).sum();
            density[voxel] = pack_density(&parts, area);
            for (share, (clip, part)) in shares[start..].iter_mut().zip(run.iter().zip(&parts)) {
                *share = Share {
                    point: clip.segment,
                    fraction: f16::from_f32(0.5 * (clip.t0 + clip.t1)),
                    weight: f16::from_f64(if area > 0.0 { part.area / area } else { 0.0 }),
                };
            }
            start += run.len();
            first_share[voxel + 1] = run.len() as u32;
        }
        for i in 0..stored {
            first_share[i + 1] += first_share[i];
        }

        // Voxels inside the occluder stop everything, whatever fibre they hold.
        for (address, _) in solid.iter().enumerate().filter(|(_, solid)| **solid) {
            if bricks[address / BRICK_VOXELS as usize] < SOLID_BRICK {
                let rho = u32::from(f16::from_f32(SOLID_RHO).to_bits());
                density[stored_voxel(&bricks, address as u32)] = [rho, 0];
            }
        }
        Self {
            grid,
            bricks,
            density,
            first_share,
            shares,
        }
    }
}

/// What one clip adds: projected area D * length in voxel edges squared, and the unit tangent.
struct Part {
    area: f64,
    tangent: DVec3,
}

fn part(strands: &Strands<'_>, grid: &Grid, clip: &Clip) -> Part {
    let i = clip.segment as usize;
    let segment = (strands.positions[i + 1] - strands.positions[i]).as_dvec3();
    let middle = 0.5 * (clip.t0 + clip.t1);
    let diameter =
        f64::from(strands.diameters[i] + (strands.diameters[i + 1] - strands.diameters[i]) * middle);
    let length = segment.length() * f64::from(clip.t1 - clip.t0);
    Part {
        area: diameter * length / f64::from(grid.voxel_size).powi(2),
        tangent: segment.normalize_or_zero(),
    }
}

/// The two words of a voxel with fibres of the given parts.
fn pack_density(parts: &[Part], area: f64) -> [u32; 2] {
    if area <= 0.0 {
        return [0; 2];
    }
    let mean = |i: usize, j: usize| {
        parts
            .iter()
            .map(|p| p.area * p.tangent[i] * p.tangent[j])
            .sum::<f64>()
            / area
    };
    let unorm = |x: f64| (x.clamp(0.0, 1.0) * 255.0).round() as u32;
    let snorm = |x: f64| u32::from(((x.clamp(-1.0, 1.0) * 127.0).round() as i8).cast_unsigned());
    let rho = u32::from(f16::from_f64(area.min(MAX_RHO)).to_bits());
    [
        rho | unorm(1.0 - mean(0, 0)) << 16 | unorm(1.0 - mean(1, 1)) << 24,
        snorm(-2.0 * mean(1, 2)) | snorm(-2.0 * mean(0, 2)) << 8 | snorm(-2.0 * mean(0, 1)) << 16,
    ]
}

/// The hair's box, grown by what the occluder has within one box diagonal of it.
fn bounds_with_occluder(strands: &Strands<'_>, occluder: Option<&Occluder<'_>>) -> (Vec3, Vec3) {
    let (low, high) = strands.bounds();
    let reach = Vec3::splat(low.distance(high));
    match occluder.and_then(Occluder::bounds) {
        Some((head_low, head_high)) => (
            low.min(head_low.max(low - reach)),
            high.max(head_high.min(high + reach)),
        ),
        None => (low, high),
    }
}

/// All clips, sorted by voxel and then by segment.
fn clip_strands(strands: &Strands<'_>, grid: &Grid) -> Vec<Clip> {
    let mut clips: Vec<Clip> = (0..strands.strand_count())
        .into_par_iter()
        .flat_map_iter(|strand| {
            let mut clips = Vec::new();
            for segment in strands.segments(strand) {
                let a = grid.grid_from_world(strands.positions[segment]);
                let b = grid.grid_from_world(strands.positions[segment + 1]);
                clip_segment(a, b, |voxel, t0, t1| {
                    let address = grid.address(IVec3::from_array(voxel));
                    clips.push(Clip {
                        address,
                        segment: segment as u32,
                        t0: t0 as f32,
                        t1: t1 as f32,
                    });
                });
            }
            clips
        })
        .collect();
    clips.par_sort_by_key(|clip| (clip.address, clip.segment));
    clips
}

/// The brick table and the number of stored voxels.
fn number_bricks(grid: &Grid, clips: &[Clip], solid: &[bool]) -> (Vec<u32>, u32) {
    let mut bricks = vec![EMPTY_BRICK; grid.brick_count()];
    for (brick, voxels) in solid.chunks(BRICK_VOXELS as usize).enumerate() {
        match voxels.iter().filter(|solid| **solid).count() as u32 {
            0 => {}
            BRICK_VOXELS => bricks[brick] = SOLID_BRICK,
            _ => bricks[brick] = 0,
        }
    }
    for clip in clips {
        bricks[(clip.address / BRICK_VOXELS) as usize] = 0;
    }
    let mut count = 0;
    for brick in bricks.iter_mut().filter(|brick| **brick == 0) {
        *brick = count;
        count += 1;
    }
    (bricks, count * BRICK_VOXELS)
}

/// Index of a voxel of a stored brick.
fn stored_voxel(bricks: &[u32], address: u32) -> usize {
    (bricks[(address / BRICK_VOXELS) as usize] * BRICK_VOXELS + address % BRICK_VOXELS) as usize
}
