//! Strokes onto strands: what is recorded, which points it covers, what it does to their values.
//!
//! A stroke is a list of dabs in groom space, so it needs no camera. Every point takes the largest coverage that any dab
//! of the stroke gives it, and its value is blended once, from the value before the stroke: the result does not depend
//! on how the dabs were batched or on a frame rate, nor, at full flow, on their order. A salon operation has a shape instead of
//! dabs: its coverage is a function of the strand and the place along it.

mod affine;
mod coverage;
mod curve;
mod dirty;
mod layer_maps;
mod mask;
mod parameter;
mod salon;
mod scalp;
mod strand_index;
mod stroke;
mod work;

pub use affine::Affine;
pub use coverage::{Coverage, profile};
pub use curve::Curve;
pub use dirty::DirtyRanges;
pub use layer_maps::{ChannelMaps, LayerMaps, LiveStroke, TouchedMaps};
pub use mask::{Mask, MaskKind, MaskPart};
pub use parameter::Parameter;
pub use salon::{Balayage, Fill, Foils, Gradient, Grey, Parting, Regrowth, Shape, TipFade};
pub use scalp::{Outline, Section, StrandFacts};
pub use strand_index::StrandIndex;
pub use stroke::{
    Dab, Extra, Falloff, Mode, Nearest, Operation, OperationId, Reach, STROKE_VERSION, StrokeFile,
    StrokeValue,
};
pub(crate) use stroke::{check_dabs, check_operations};
pub use work::PaintWork;
