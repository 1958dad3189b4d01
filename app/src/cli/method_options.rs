//! Options that say how single scattering is evaluated.

use balayage_render::gpu::{Method, Quality};
use clap::{Args, ValueEnum};

/// `--quality`.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct MethodOptions {
    /// Accuracy of the light integrals.
    #[arg(long, value_enum, default_value_t)]
    pub quality: QualityName,
}

/// Names of the quality levels.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum QualityName {
    /// Fewest nodes.
    Draft,
    /// The default.
    #[default]
    Standard,
    /// For final pictures and comparisons.
    High,
}

impl MethodOptions {
    /// What the options ask for.
    pub fn method(&self) -> Method {
        Method::of_quality(match self.quality {
            QualityName::Draft => Quality::Draft,
            QualityName::Standard => Quality::Standard,
            QualityName::High => Quality::High,
        })
    }
}
