//! Environment maps and the SRBF lights that stand for them.
//!
//! World: right-handed, y up. Map pixel (u, v) in [0,1]^2, row 0 on top, is the direction
//! (sin 2 pi u sin pi v, cos pi v, -cos 2 pi u sin pi v).
//!
//! The way of a map: a file is read by `radiance_hdr` or `open_exr` and cleaned into an [`EnvironmentMap`]; [`fit()`] turns it
//! into a [`LightSet`] (`cells` sums energy, `mixture` seeds by expectation maximisation, `refine` minimises the relative
//! residual through `products`); the [`frames()`] of a sequence are fitted each from the lights of the one before. [`HairProbe`] says
//! what hair will see of the difference, and [`preview()`] what an eye will.

mod bands;
mod cells;
mod error;
mod fit;
mod hair;
mod harmonics;
mod json;
mod map;
mod mixture;
mod nnls;
mod open_exr;
mod preset;
mod preview;
mod products;
mod radiance_hdr;
mod refine;
mod sequence;
mod sight;
mod srbf;

use glam::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use error::InputError;
pub use fit::{
    Fit, FitError, FitSettings, MAX_LIGHTS, Objective, Progress, fit, fit_counted, fit_lights, fit_to_error,
};
pub use hair::{HairKernel, HairProbe};
pub use harmonics::Harmonics;
pub use map::{MAX_PIXELS, MapReport};
pub use preset::{GradientSky, PRESETS, Preset};
pub use preview::{Picture, panorama, preview};
pub use refine::Work;
pub use sequence::frames;
pub use srbf::{MAX_BANDWIDTH, luminance};

/// One spherical radial basis function: radiance * exp(2 (w . direction - 1) / bandwidth^2), peak 1 (Xu 2011, Eq 1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SrbfLight {
    /// Unit vector towards the light, world space.
    #[schemars(with = "[f32; 3]")]
    pub direction: Vec3,
    /// Bandwidth lambda, radians-like, > 0.
    pub bandwidth: f32,
    /// Radiance at the centre, linear Rec.709.
    #[schemars(with = "[f32; 3]")]
    pub radiance: Vec3,
}

/// The content of a LIGHTS.json: lights and an optional uniform environment that is evaluated exactly.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightSet {
    /// The SRBF lights.
    pub lights: Vec<SrbfLight>,
    /// Radiance of a uniform environment, linear Rec.709.
    #[serde(default)]
    pub constant: Vec3,
}

/// An equirectangular map of linear Rec.709 radiance, row 0 on top, finite and non-negative.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels, row after row.
    pub pixels: Vec<Vec3>,
}
