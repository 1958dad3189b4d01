//! Fibre density of a groom and what light loses and gains on its way through it.
//!
//! A [`DensityVolume`] holds, per voxel of about one fibre spacing, how much fibre crosses it and in which directions. It is built
//! once per groom on the CPU (exact clipping, ordered sums: the same bits on every machine and thread count) and uploaded;
//! [`crate::gpu::Transmittance`] marches through it. [`lobe`] spreads directions over a light, [`SegmentGrid`] is the exact
//! reference that the marches are held against.

mod clip;
mod density;
mod exact;
mod grid;
pub mod lobe;
mod neighbours;
mod occluder;
mod solid;
mod strands;

pub(crate) use clip::clip_segment;
pub use density::{DensityVolume, EMPTY_BRICK, SOLID_BRICK, Share, VolumeSettings};
pub use exact::{Hit, SegmentGrid};
pub(crate) use grid::occupied_cells;
pub use grid::{BRICK_SIDE, BRICK_VOXELS, Grid};
pub use neighbours::Neighbours;
pub use occluder::Occluder;
pub use solid::SolidVoxels;
pub use strands::Strands;
