//! Strands: files and generator in, a sound [`Groom`] out.

use glam::Vec3;

/// Fibre diameter where a file states none, in metres (0.08 mm).
pub const DEFAULT_DIAMETER_M: f32 = 0.08e-3;

/// A sound set of strands: finite points, at least two per strand, no zero-length segment, positive diameters.
///
/// Positions and diameters are in the file's unit; [`Groom::metres_per_unit`] converts.
#[derive(Clone, Debug, PartialEq)]
pub struct Groom {
    positions: Vec<Vec3>,
    diameters: Vec<f32>,
    first_point: Vec<u32>,
    metres_per_unit: f32,
}

impl Groom {
    /// Number of strands.
    pub fn strand_count(&self) -> usize {
        self.first_point.len() - 1
    }

    /// Number of points of all strands.
    pub fn point_count(&self) -> usize {
        self.positions.len()
    }

    /// Index range of the points of strand `strand`, root first.
    pub fn strand(&self, strand: usize) -> std::ops::Range<usize> {
        self.first_point[strand] as usize..self.first_point[strand + 1] as usize
    }

    /// Positions of all points, strand after strand, in file units.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Fibre diameter at every point, in file units.
    pub fn diameters(&self) -> &[f32] {
        &self.diameters
    }

    /// First point of every strand, and the point count at the end: `strand_count() + 1` entries.
    pub fn first_point(&self) -> &[u32] {
        &self.first_point
    }

    /// Metres per file unit.
    pub fn metres_per_unit(&self) -> f32 {
        self.metres_per_unit
    }
}
