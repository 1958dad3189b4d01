//! Which voxels an occluder fills, for rays on the CPU.

use glam::Vec3;

use super::density::SOLID_RHO;
use super::{BRICK_VOXELS, DensityVolume, EMPTY_BRICK, Grid, SOLID_BRICK};

/// An occluder counts from this far on, voxels: roots may lie a little under the skin (`OCCLUDER_CLEARANCE` of `shaders/lib/volume.wgsl`).
const CLEARANCE: f32 = 1.5;

/// The voxels of a volume that lie inside its occluder.
pub struct SolidVoxels {
    grid: Grid,
    /// One flag per voxel, in the order of [`Grid::address`].
    solid: Vec<bool>,
}

impl SolidVoxels {
    /// Those of `volume`; `None` where there are none.
    pub fn of(volume: &DensityVolume) -> Option<Self> {
        let is_solid = |voxel: usize, slot: u32| match slot {
            SOLID_BRICK => true,
            EMPTY_BRICK => false,
            slot => {
                volume.density[(slot * BRICK_VOXELS) as usize + voxel][0] & 0xffff
                    == u32::from(half::f16::from_f32(SOLID_RHO).to_bits())
            }
        };
        let solid: Vec<bool> = volume
            .bricks
            .iter()
            .flat_map(|&slot| (0..BRICK_VOXELS as usize).map(move |voxel| is_solid(voxel, slot)))
            .collect();
        solid.contains(&true).then_some(Self {
            grid: volume.grid,
            solid,
        })
    }

    /// Whether a step of one voxel along the ray from `origin` (groom's unit), unit vector `direction`, falls into the occluder before `distance`.
    pub fn blocks(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        let start = self.grid.grid_from_world(origin).as_vec3();
        let size = self.grid.voxels().as_vec3();
        let end = distance / self.grid.voxel_size;
        let mut t = CLEARANCE;
        while t < end {
            let p = start + direction * t;
            if p.cmplt(Vec3::ZERO).any() || p.cmpge(size).any() {
                // Rays leave the box once; hair lies inside it.
                return false;
            }
            if self.solid[self.grid.address(p.as_ivec3()) as usize] {
                return true;
            }
            t += 1.0;
        }
        false
    }
}
