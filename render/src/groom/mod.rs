//! Strands: files and generator in, a sound [`Groom`] out.
//!
//! [`read_groom`] or [`generate`] -> [`GroomBuilder`], which cleans and counts -> [`Groom`] -> [`RefinedGroom`], the smooth curve through
//! its points.

mod abc;
mod ball;
mod barber;
mod builder;
mod bytes;
mod error;
mod file;
mod generate;
mod hair;
mod mesh;
mod refined;
mod report;
mod resample;
mod scalp;
mod spline;
mod tfx;
mod undergrowth;
mod usd;

use glam::Vec3;

pub use abc::parse_abc;
pub use ball::{BALL_RADIUS, ball};
pub use builder::{GroomBuilder, MAX_COORDINATE, MAX_POINTS};
pub use error::GroomError;
pub use file::{
    GROOM_EXTENSIONS, LoadedGroom, is_usd, read_groom, read_painted_groom, write_groom, write_painted_groom,
};
pub use generate::{GeneratorSettings, HairStyle, generate};
pub use hair::{hair_bytes, parse_hair};
pub use mesh::Mesh;
pub use refined::{DEFAULT_MAX_TURN_RAD, RefinedGroom};
pub use report::{GroomReport, UnitSource};
pub use tfx::{parse_tfx, tfx_bytes};
pub use undergrowth::undergrowth;
pub use usd::{LoadedUsd, PaintedValues, ReadOptions, parse_usd, usda_bytes};

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
    /// Cleans strands of one fibre diameter (file units) into a groom; see [`GroomBuilder`] for files with more to tell.
    ///
    /// # Errors
    /// When no strand is usable or `metres_per_unit` is not a positive number.
    pub fn from_strands<S: AsRef<[Vec3]>>(
        strands: impl IntoIterator<Item = S>,
        diameter: f32,
        metres_per_unit: f32,
    ) -> Result<(Self, GroomReport), GroomError> {
        let mut builder = GroomBuilder::new();
        for strand in strands {
            builder.push_strand(strand.as_ref().iter().map(|&p| (p, Some(diameter))));
        }
        builder.finish("strands", Some((metres_per_unit, UnitSource::Given)))
    }

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

    /// Smallest and largest coordinates of the points, in file units.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        builder::bounds(&self.positions)
    }

    /// Length of every strand along its points' polyline, in file units.
    pub fn lengths(&self) -> Vec<f32> {
        (0..self.strand_count())
            .map(|strand| {
                let points = &self.positions[self.strand(strand)];
                points
                    .windows(2)
                    .map(|p| f64::from(p[0].distance(p[1])))
                    .sum::<f64>() as f32
            })
            .collect()
    }

    /// Root-to-tip coordinate of every point: arc length along the polyline, 0 at the root, 1 at the tip.
    pub fn arc(&self) -> Vec<f32> {
        let mut arc = Vec::with_capacity(self.point_count());
        for strand in 0..self.strand_count() {
            let points = &self.positions[self.strand(strand)];
            let total: f64 = points.windows(2).map(|p| f64::from(p[0].distance(p[1]))).sum();
            // The same sum in the same order, so that the tip is exactly one.
            let mut travelled = 0.0;
            arc.push(0.0);
            arc.extend(points.windows(2).map(|p| {
                travelled += f64::from(p[0].distance(p[1]));
                (travelled / total) as f32
            }));
        }
        arc
    }

    /// Identity of the geometry: BLAKE3 of positions, diameters and first points (little endian, in this order), as 64 hex digits.
    pub fn content_hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let floats = self
            .positions
            .iter()
            .flat_map(Vec3::to_array)
            .chain(self.diameters.iter().copied());
        let words = floats.map(f32::to_bits).chain(self.first_point.iter().copied());
        // Feed the hasher in pieces that are worth its while.
        let mut piece = Vec::with_capacity(HASH_PIECE);
        for word in words {
            piece.extend_from_slice(&word.to_le_bytes());
            if piece.len() == HASH_PIECE {
                hasher.update(&piece);
                piece.clear();
            }
        }
        hasher.update(&piece);
        hasher.finalize().to_hex().to_string()
    }
}

/// Bytes handed to the hasher at once.
const HASH_PIECE: usize = 1 << 16;
