//! Where the voxels are: a box of bricks around the hair, voxels of about one fibre spacing.

use std::collections::HashSet;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, IVec3, UVec3, Vec3};

use super::Strands;

/// Voxels along one edge of a brick; the same constant stands in `shaders/lib/volume.wgsl`.
pub const BRICK_SIDE: u32 = 4;

/// Voxels of a brick.
pub const BRICK_VOXELS: u32 = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE;

/// Most bricks along one axis.
const MAX_BRICKS_PER_AXIS: u32 = 128;

/// Placement of a volume, same layout as `VolumeGrid` in `shaders/lib/volume.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Grid {
    /// Lower corner, in the groom's unit.
    pub origin: Vec3,
    /// Edge of a voxel, in the groom's unit.
    pub voxel_size: f32,
    /// Bricks along each axis.
    pub bricks: UVec3,
    /// Voxels that are stored: those of bricks that hold fibres or a part of an occluder.
    pub stored_voxels: u32,
}

impl Grid {
    /// The grid that encloses the box from `low` to `high` with one voxel to spare; voxels grow where the box would need more
    /// than 128 bricks along an axis.
    pub fn around(low: Vec3, high: Vec3, voxel_size: f32) -> Self {
        let longest = (high - low).max_element();
        let most_voxels = (MAX_BRICKS_PER_AXIS * BRICK_SIDE - 2) as f32;
        let voxel_size = voxel_size.max(longest / most_voxels);
        let voxels = ((high - low) / voxel_size).ceil() + 2.0;
        let bricks = (voxels / BRICK_SIDE as f32)
            .ceil()
            .as_uvec3()
            .clamp(UVec3::ONE, UVec3::splat(MAX_BRICKS_PER_AXIS));
        Self {
            origin: low - voxel_size,
            voxel_size,
            bricks,
            stored_voxels: 0,
        }
    }

    /// Position in voxels from the grid's lower corner.
    pub fn grid_from_world(&self, position: Vec3) -> DVec3 {
        (position.as_dvec3() - self.origin.as_dvec3()) / f64::from(self.voxel_size)
    }

    /// Voxels along each axis.
    pub fn voxels(&self) -> UVec3 {
        self.bricks * BRICK_SIDE
    }

    /// Number of bricks, stored or not.
    pub fn brick_count(&self) -> usize {
        self.bricks.x as usize * self.bricks.y as usize * self.bricks.z as usize
    }

    /// Brick number times 64 plus the voxel's number inside its brick, both x first; voxels outside are moved to the border.
    pub fn address(&self, voxel: IVec3) -> u32 {
        let voxel = voxel.clamp(IVec3::ZERO, self.voxels().as_ivec3() - 1).as_uvec3();
        let (brick, inside) = (voxel / BRICK_SIDE, voxel % BRICK_SIDE);
        let brick = brick.x + self.bricks.x * (brick.y + self.bricks.y * brick.z);
        brick * BRICK_VOXELS + inside.x + BRICK_SIDE * (inside.y + BRICK_SIDE * inside.z)
    }
}

/// Typical distance between neighbouring fibres: sqrt(volume that holds fibres / length of the fibres).
///
/// The volume is counted in cells of the current guess, starting coarse; two refinements settle it (finer cells would
/// only ever see single fibres).
pub fn fibre_spacing(strands: &Strands<'_>) -> f32 {
    let (low, high) = strands.bounds();
    let length = strands.total_length();
    let diagonal = f64::from(high.distance(low));
    if length <= 0.0 || diagonal <= 0.0 {
        return 1.0;
    }
    let mut spacing = diagonal / 48.0;
    for _ in 0..2 {
        let occupied = occupied_cells(strands, low, spacing) as f64;
        spacing = (occupied * spacing.powi(3) / length)
            .sqrt()
            .clamp(diagonal / 2048.0, diagonal / 4.0);
    }
    spacing as f32
}

/// Number of cells of edge `cell` in which a segment has a sample; samples are at most half a cell apart.
pub(crate) fn occupied_cells(strands: &Strands<'_>, low: Vec3, cell: f64) -> usize {
    let mut cells = HashSet::new();
    for strand in 0..strands.strand_count() {
        for i in strands.segments(strand) {
            let (a, b) = (strands.positions[i], strands.positions[i + 1]);
            let samples = (f64::from(a.distance(b)) / (0.5 * cell)).ceil().max(1.0) as u32;
            for s in 0..samples {
                let p = a.lerp(b, (s as f32 + 0.5) / samples as f32) - low;
                cells.insert((p.as_dvec3() / cell).floor().as_ivec3());
            }
        }
    }
    cells.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_unique_and_dense() {
        let grid = Grid::around(Vec3::ZERO, Vec3::new(9.0, 5.0, 3.0), 1.0);
        let voxels = grid.voxels().as_ivec3();
        let mut seen = HashSet::new();
        for z in 0..voxels.z {
            for y in 0..voxels.y {
                for x in 0..voxels.x {
                    assert!(seen.insert(grid.address(IVec3::new(x, y, z))));
                }
            }
        }
        assert_eq!(seen.len(), grid.brick_count() * BRICK_VOXELS as usize);
        assert_eq!(seen.iter().max(), Some(&(seen.len() as u32 - 1)));
    }

    #[test]
    fn spacing_of_a_square_lattice_is_its_pitch() {
        // 30 x 30 straight strands of length 30, one unit apart.
        let mut positions = Vec::new();
        for i in 0..900 {
            let (x, y) = ((i % 30) as f32, (i / 30) as f32);
            positions.extend([Vec3::new(x, y, 0.0), Vec3::new(x, y, 30.0)]);
        }
        let diameters = vec![0.01; positions.len()];
        let first_point: Vec<u32> = (0..=900).map(|i| 2 * i).collect();
        let strands = Strands {
            positions: &positions,
            diameters: &diameters,
            first_point: &first_point,
        };
        let spacing = fibre_spacing(&strands);
        assert!((0.9..1.2).contains(&spacing), "spacing {spacing}");
    }
}
