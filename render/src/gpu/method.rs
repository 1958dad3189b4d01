//! How single scattering is evaluated: the model, the scheme that integrates it, and how finely; and which shader files that means.

use std::ops::RangeInclusive;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How finely the integrals of single scattering are evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quality {
    /// Fewest nodes: while something moves.
    Draft,
    /// The default.
    #[default]
    Standard,
    /// For final pictures and for checking.
    High,
}

/// Which scattering function a fibre has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// Marschner 2003: R, TT and TRT.
    #[default]
    Marschner,
    /// d'Eon 2011: conserves energy; p = 0 to 3 and the remainder, which count as R, TT and TRT (p >= 2).
    Deon,
    /// Kajiya and Kay 1989: a highlight (counts as R) and a diffuse term (counts as TRT) in the hair's colour. It knows no multiple
    /// scattering: the diffuse colour stands for it.
    KajiyaKay,
}

impl Model {
    /// Whether light that other fibres have scattered is added.
    pub fn scatters_often(self) -> bool {
        self != Self::KajiyaKay
    }
}

/// How Marschner's model is integrated over a light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Gauss nodes in inclination and offset, closed forms in azimuth.
    #[default]
    Nodes,
    /// Xu 2011 as printed: circular Gaussians in azimuth, linear segments in inclination.
    Xu2011 {
        /// Segments m, [`SEGMENTS`].
        segments: u32,
    },
    /// Brute force: samples of the light, each a direction.
    Directional {
        /// Samples of a light, [`DIRECTIONS`].
        directions: u32,
    },
}

/// Segments that `xu2011` can have; the paper takes 4.
pub const SEGMENTS: RangeInclusive<u32> = 2..=16;
/// Directions that `directional` can have; the paper takes 1,536 for all lights together.
pub const DIRECTIONS: RangeInclusive<u32> = 16..=4096;

/// `DIRECTIONAL_GAMMAS` of `shaders/lib/single_directional.wgsl`.
pub const DIRECTIONAL_GAMMAS: u32 = 10;

impl Scheme {
    /// The scheme, if its number is in range.
    ///
    /// # Errors
    /// What the number is and must be.
    pub fn checked(self) -> Result<Self, String> {
        let (name, number, range) = match self {
            Self::Nodes => return Ok(self),
            Self::Xu2011 { segments } => ("segments", segments, SEGMENTS),
            Self::Directional { directions } => ("directions", directions, DIRECTIONS),
        };
        if range.contains(&number) {
            return Ok(self);
        }
        Err(format!(
            "{name} is {number}; it must be {} to {}",
            range.start(),
            range.end()
        ))
    }
}

/// Model, scheme and quality: together they choose the shader files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Method {
    /// The scattering function.
    pub model: Model,
    /// How it is integrated.
    pub scheme: Scheme,
    /// How finely.
    pub quality: Quality,
}

impl Method {
    /// The method of a quality level with everything else as usual.
    pub fn of_quality(quality: Quality) -> Self {
        Self {
            quality,
            ..Self::default()
        }
    }

    /// Lights that one thread may go through: Mesa's software driver ends the loops of a thread after 65,535 rounds in all.
    pub fn lights_per_dispatch(&self) -> u32 {
        match self.scheme {
            Scheme::Nodes | Scheme::Xu2011 { .. } => u32::MAX,
            // A direction is a round; so is every pair of its nodes of gamma, and the end of their loop.
            Scheme::Directional { directions } => {
                (60_000 / (directions * (2 + DIRECTIONAL_GAMMAS / 2))).max(1)
            }
        }
    }

    /// Files that stand in for others where a pass is composed (`shader::compose`).
    pub fn files(&self) -> &'static [(&'static str, &'static str)] {
        match (self.model, self.scheme) {
            (Model::Marschner, Scheme::Nodes) => &[],
            (Model::Marschner, Scheme::Xu2011 { .. }) => &[("lib/single.wgsl", "lib/single_xu2011.wgsl")],
            (Model::Marschner, Scheme::Directional { .. }) => {
                &[("lib/single.wgsl", "lib/single_directional.wgsl")]
            }
            (Model::Deon, _) => &[
                ("lib/single.wgsl", "lib/single_deon.wgsl"),
                ("lib/global.wgsl", "lib/global_deon.wgsl"),
                ("lib/forward.wgsl", "lib/forward_deon.wgsl"),
                ("lib/averages.wgsl", "lib/averages_deon.wgsl"),
            ],
            (Model::KajiyaKay, _) => &[("lib/single.wgsl", "lib/single_kajiya_kay.wgsl")],
        }
    }

    /// Pipeline-overridable constants of those files, as far as the composed `text` declares them.
    pub fn constants(&self, text: &str) -> Vec<(&'static str, f64)> {
        let mut constants = vec![("quality", f64::from(self.quality as u8))];
        match self.scheme {
            Scheme::Nodes => {}
            Scheme::Xu2011 { segments } => constants.push(("segments", f64::from(segments))),
            Scheme::Directional { directions } => constants.push(("directions", f64::from(directions))),
        }
        constants.retain(|(name, _)| text.contains(&format!("override {name}:")));
        constants
    }
}
