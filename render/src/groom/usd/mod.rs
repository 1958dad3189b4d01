//! USD: `UsdGeomBasisCurves` in (`.usda`, `.usdc`), linear curves with painted primvars out (`.usda`).
//!
//! One layer is read, not a stage: references, payloads, sublayers, instances and variants are counted in the report and not followed.

mod basis;
mod binary;
mod curves;
mod layer;
mod packed;
mod paint;
mod primvar;
mod text;
mod transform;
mod write;

use super::bytes::FileBytes;
use super::{Groom, GroomError, LoadedGroom};
use crate::param::{LobeRatios, PigmentSet, PointValues};

pub(super) use curves::collect;
pub(super) use layer::{Attribute, Layer, MAX_DEPTH, Prim, Value};
pub use write::usda_bytes;

/// `metersPerUnit` of a layer that states none, as the schema prescribes.
const USD_METRES_PER_UNIT: f32 = 0.01;

/// First bytes of a binary layer.
const BINARY_MAGIC: &[u8] = b"PXR-USDC";

/// How a groom's file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Overrides what the file states and what its size suggests.
    pub metres_per_unit: Option<f32>,
    /// Time code of a USD file's samples; none takes the values without a time, else the first sample.
    pub time: Option<f64>,
}

/// The painted values that a USD file brings, one of every channel a point of the groom; channels that it lacks have their usual values,
/// and the report says which.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintedValues {
    /// A value for every point of the groom.
    pub values: Vec<PointValues>,
    /// Tilt and width of TT and TRT over R's at every point.
    pub ratios: Vec<LobeRatios>,
    /// The pigments that its melanin is measured in.
    pub pigments: PigmentSet,
}

/// What a USD file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedUsd {
    /// The strands and what reading them found.
    pub loaded: LoadedGroom,
    /// Curves that the file's prims hold, before cleaning.
    pub curves: usize,
    /// Control points that they have.
    pub control_points: usize,
    /// The painted values, where the file has some.
    pub painted: Option<PaintedValues>,
}

/// Reads all curves of a USD file from memory, its first bytes choose text or binary; `name` is for messages.
///
/// Curves come out y up and in the file's unit, with the transforms of their prims applied. Linear curves keep their points bit for bit
/// where no transform stands above them; cubic ones become polylines of [`basis::POINTS_PER_SEGMENT`] points a segment.
///
/// # Errors
/// [`GroomError::Format`] for bytes that break the format, [`GroomError::Refused`] when counts disagree or no strand is usable.
pub fn parse_usd(bytes: &[u8], name: &str, options: ReadOptions) -> Result<LoadedUsd, GroomError> {
    let file = FileBytes { name, bytes };
    let layer = if bytes.starts_with(BINARY_MAGIC) {
        binary::parse(file)?
    } else {
        text::parse(file)?
    };
    collect(&layer, name, options, Some(USD_METRES_PER_UNIT))
}

/// A groom with a value for every point.
pub(super) fn check_values(groom: &Groom, painted: &PaintedValues) -> Result<(), GroomError> {
    let (values, ratios) = (painted.values.len(), painted.ratios.len());
    if [values, ratios] == [groom.point_count(); 2] {
        return Ok(());
    }
    Err(GroomError::refused(
        "painted values",
        format!(
            "{values} values and {ratios} lobe ratios for {} points",
            groom.point_count()
        ),
        "give a value for every point",
    ))
}
