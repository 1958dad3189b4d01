//! Options that say how single scattering is evaluated.

use balayage_render::gpu::{
    DIRECTIONS, Method, Model, Multiple, Quality, SEGMENTS, Scheme, VisibilitySource,
};
use clap::{Args, ValueEnum};

/// `--model` of a picture.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ModelName {
    /// Marschner 2003: R, TT and TRT.
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

/// `--multiple` of a picture.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum MultipleName {
    /// Light traced from the lights from fibre to fibre, kept in cells of the hair.
    Traced,
    /// S + D + U: two streams carry what turned round, scattered light diffuses over the inclinations.
    M3,
    /// S + 1.1 D + 0.2 L + 0.25 U.
    M2,
    /// Zinke 2008 as printed.
    Zinke2008,
    /// Single scattering only.
    Off,
}

impl From<MultipleName> for Multiple {
    fn from(name: MultipleName) -> Self {
        match name {
            MultipleName::Traced => Self::Traced,
            MultipleName::M3 => Self::M3,
            MultipleName::M2 => Self::M2,
            MultipleName::Zinke2008 => Self::Zinke2008,
            MultipleName::Off => Self::Off,
        }
    }
}

/// `--transmittance` of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum TransmittanceName {
    /// Marches through the density of the hair towards every light; exact rays can refine them.
    #[default]
    Voxel,
    /// Nine spherical harmonics per block of voxels (Xing 2012), for comparison.
    Sh9,
}

impl From<TransmittanceName> for VisibilitySource {
    fn from(name: TransmittanceName) -> Self {
        match name {
            TransmittanceName::Voxel => Self::Voxel,
            TransmittanceName::Sh9 => Self::Sh9,
        }
    }
}

/// `--scheme`, `--segments`, `--directions`, `--quality`.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct MethodOptions {
    /// How scattering is integrated over a light (the project's way if not given).
    #[arg(long, value_enum)]
    pub scheme: Option<SchemeName>,
    /// Segments of the scheme xu2011, 2 to 16 (4 if not given).
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(i64::from(*SEGMENTS.start())..=i64::from(*SEGMENTS.end())))]
    pub segments: Option<u32>,
    /// Samples of each light of the scheme directional, 16 to 4096 (1024 if not given).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(i64::from(*DIRECTIONS.start())..=i64::from(*DIRECTIONS.end())))]
    pub directions: Option<u32>,
    /// Accuracy of the light integrals.
    #[arg(long, value_enum, default_value_t)]
    pub quality: QualityName,
}

/// Names of the schemes.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum SchemeName {
    /// Gauss nodes and closed forms: the usual one.
    Nodes,
    /// The published method of Xu 2011, for comparison.
    Xu2011,
    /// Brute force: many directions per light.
    Directional,
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
    /// What the options ask for; the project's scheme where they name none.
    pub fn method(&self, of_project: Scheme) -> Method {
        let quality = match self.quality {
            QualityName::Draft => Quality::Draft,
            QualityName::Standard => Quality::Standard,
            QualityName::High => Quality::High,
        };
        let mut scheme = match self.scheme {
            None => of_project,
            Some(SchemeName::Nodes) => Scheme::Nodes,
            Some(SchemeName::Xu2011) => Scheme::Xu2011 { segments: 4 },
            Some(SchemeName::Directional) => Scheme::Directional { directions: 1024 },
        };
        match &mut scheme {
            Scheme::Nodes => {}
            Scheme::Xu2011 { segments } => *segments = self.segments.unwrap_or(*segments),
            Scheme::Directional { directions } => *directions = self.directions.unwrap_or(*directions),
        }
        Method {
            scheme,
            ..Method::of_quality(quality)
        }
    }
}
