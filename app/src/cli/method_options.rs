//! Options that say how single scattering is evaluated.

use balayage_render::gpu::{Method, Model, Quality};
use clap::{Args, ValueEnum};

/// `--model` of a picture.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum ModelName {
    /// Marschner 2003: R, TT and TRT.
    #[default]
    Marschner,
    /// d'Eon 2011: conserves energy.
    Deon,
    /// Kajiya and Kay 1989: a highlight and a diffuse term in the hair's colour; no multiple scattering, whatever --multiple says.
    KajiyaKay,
}

impl From<ModelName> for Model {
    fn from(name: ModelName) -> Self {
        match name {
            ModelName::Marschner => Self::Marschner,
            ModelName::Deon => Self::Deon,
            ModelName::KajiyaKay => Self::KajiyaKay,
        }
    }
}

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
