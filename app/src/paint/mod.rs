//! Strokes onto strands: what is recorded, which points it covers, what it does to their values.
//!
//! A stroke is a list of dabs in groom space, so it needs no camera. Every point takes the largest coverage that any dab
//! of the stroke gives it, and its value is blended once, from the value before the stroke: the result does not depend
//! on how the dabs were batched, on their order or on a frame rate.

mod affine;
mod coverage;
mod dirty;
mod layer_maps;
mod strand_index;
mod stroke;

pub use affine::Affine;
pub use coverage::{Coverage, profile};
pub use dirty::DirtyRanges;
pub use layer_maps::{LayerMaps, LiveStroke, TouchedMaps};
pub use strand_index::StrandIndex;
pub use stroke::{
    Dab, Extra, Falloff, Mode, Operation, OperationId, Reach, STROKE_VERSION, StrokeFile, StrokeValue,
};
pub(crate) use stroke::{check_dabs, check_operations};
