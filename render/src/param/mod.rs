//! What a user paints, per groom point, and what the shaders read of it.

mod access;

use std::f64::consts::FRAC_PI_2;

use bytemuck::{Pod, Zeroable};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::optics::Fibre;

/// A painted channel; values live on the groom's points (design: angles in degrees here, radians in [`VertexParams`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Eumelanin concentration, >= 0.
    Eumelanin,
    /// Pheomelanin concentration, >= 0.
    Pheomelanin,
    /// Share of melanin removed, in [0, 1].
    Bleach,
    /// Dye absorption per fibre radius, linear Rec.709 (three values).
    Dye,
    /// Cuticle tilt of R in degrees; negative towards the root.
    AlphaDeg,
    /// Longitudinal roughness of R: standard deviation in theta_h, degrees.
    BetaDeg,
    /// Azimuthal roughness: standard deviation, degrees.
    AzimuthalDeg,
    /// Index of refraction.
    Eta,
    /// Eccentricity a of the cross-section (1 = circular), Xu 2011 Eq 24.
    Eccentricity,
    /// Share of a layer that shows, in [0, 1]. It belongs to a layer: points hold no value of it.
    Mask,
}

/// Unpainted values of every channel at one point. Widths are standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PointValues {
    /// Eumelanin concentration, >= 0.
    pub eumelanin: f32,
    /// Pheomelanin concentration, >= 0.
    pub pheomelanin: f32,
    /// Share of melanin removed, in [0, 1].
    pub bleach: f32,
    /// Dye absorption per fibre radius, linear Rec.709.
    pub dye: [f32; 3],
    /// Cuticle tilt of R, degrees.
    pub alpha_deg: f32,
    /// Longitudinal roughness of R, standard deviation in theta_h, degrees.
    pub beta_deg: f32,
    /// Azimuthal roughness, standard deviation, degrees.
    pub azimuthal_deg: f32,
    /// Index of refraction.
    pub eta: f32,
    /// Eccentricity a, 1 = circular.
    pub eccentricity: f32,
}

impl Default for PointValues {
    fn default() -> Self {
        Self {
            eumelanin: 1.3,
            pheomelanin: 0.2,
            bleach: 0.0,
            dye: [0.0; 3],
            alpha_deg: -5.0,
            beta_deg: 5.5,
            azimuthal_deg: 8.0,
            eta: 1.55,
            eccentricity: 1.0,
        }
    }
}

/// Absorption cross-sections of the two melanins per unit concentration and fibre radius, linear Rec.709.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PigmentSet {
    /// Set A: d'Eon 2011.
    #[default]
    Deon2011,
    /// Set B: Blender Cycles.
    Cycles,
}

impl PigmentSet {
    /// Every set.
    pub const ALL: [Self; 2] = [Self::Deon2011, Self::Cycles];

    /// The name in JSON and USD.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deon2011 => "deon2011",
            Self::Cycles => "cycles",
        }
    }

    /// The set that has this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|set| set.name() == name)
    }

    /// Eumelanin absorption per unit concentration.
    pub fn eumelanin(self) -> [f32; 3] {
        match self {
            Self::Deon2011 => [0.419, 0.697, 1.37],
            Self::Cycles => [0.506, 0.841, 1.653],
        }
    }

    /// Pheomelanin absorption per unit concentration.
    pub fn pheomelanin(self) -> [f32; 3] {
        match self {
            Self::Deon2011 => [0.187, 0.4, 1.05],
            Self::Cycles => [0.343, 0.733, 1.924],
        }
    }
}

/// Ratios of TT's and TRT's tilt and width to R's (defaults: Marschner 2003, table 1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LobeRatios {
    /// alpha_TT / alpha_R.
    pub alpha_tt: f32,
    /// alpha_TRT / alpha_R.
    pub alpha_trt: f32,
    /// beta_TT / beta_R.
    pub beta_tt: f32,
    /// beta_TRT / beta_R.
    pub beta_trt: f32,
}

impl Default for LobeRatios {
    fn default() -> Self {
        Self {
            alpha_tt: -0.5,
            alpha_trt: -1.5,
            beta_tt: 0.5,
            beta_trt: 2.0,
        }
    }
}

/// What the shaders read of one groom point: 12 floats, same layout as `VertexParams` in `shaders/lib/types.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct VertexParams {
    /// Absorption per fibre radius, linear Rec.709.
    pub sigma_a: [f32; 3],
    /// Cuticle tilt of R, radians.
    pub alpha_rad: f32,
    /// Longitudinal roughness of R, standard deviation in theta_h, radians.
    pub beta_rad: f32,
    /// Azimuthal bandwidth w_c of Xu 2011, radians (sqrt(2) times the standard deviation).
    pub azimuthal_width: f32,
    /// Index of refraction.
    pub eta: f32,
    /// Eccentricity a.
    pub eccentricity: f32,
    /// Tilt of TT and TRT over R's.
    pub alpha_ratios: [f32; 2],
    /// Width of TT and TRT over R's.
    pub beta_ratios: [f32; 2],
}

impl VertexParams {
    /// The fibre between the point of these parameters (`share` 0) and that of `next` (1), inside the range that scattering is built for, as
    /// `fibre_from_params` of `shaders/lib/fibre.wgsl` has it.
    pub fn fibre_towards(&self, next: &Self, share: f32) -> Fibre {
        let mixed = |of: fn(&Self) -> f32| f64::from(of(self) + (of(next) - of(self)) * share);
        let guarded = |x: f64, [low, high]: [f64; 2], otherwise: f64| {
            if x.is_nan() { otherwise } else { x.clamp(low, high) }
        };
        let alpha = mixed(|p| p.alpha_rad);
        let beta = mixed(|p| p.beta_rad);
        let sigma_a = [
            mixed(|p| p.sigma_a[0]),
            mixed(|p| p.sigma_a[1]),
            mixed(|p| p.sigma_a[2]),
        ];
        let alphas =
            [1.0, mixed(|p| p.alpha_ratios[0]), mixed(|p| p.alpha_ratios[1])].map(|ratio| alpha * ratio);
        let betas = [1.0, mixed(|p| p.beta_ratios[0]), mixed(|p| p.beta_ratios[1])].map(|ratio| beta * ratio);
        Fibre {
            eta: guarded(mixed(|p| p.eta), [1.0, 3.0], 1.55),
            eccentricity: 1.0,
            sigma_a: sigma_a.map(|x| guarded(x, [0.0, 1e4], 0.0)),
            alpha: alphas.map(|x| guarded(x, [-FRAC_PI_2, FRAC_PI_2], 0.0)),
            beta: betas.map(|x| guarded(x, [1e-3, 1.5], 0.1)),
            azimuthal_width: guarded(mixed(|p| p.azimuthal_width), [1e-3, 4.0], 0.2),
        }
    }
}

impl LobeRatios {
    /// The ratios between these and `other`, at `share` in [0, 1].
    #[must_use]
    pub fn towards(&self, other: &Self, share: f32) -> Self {
        let mixed = |a: f32, b: f32| (1.0 - share) * a + share * b;
        Self {
            alpha_tt: mixed(self.alpha_tt, other.alpha_tt),
            alpha_trt: mixed(self.alpha_trt, other.alpha_trt),
            beta_tt: mixed(self.beta_tt, other.beta_tt),
            beta_trt: mixed(self.beta_trt, other.beta_trt),
        }
    }
}

impl PointValues {
    /// The shader's view of this point: sigma_a = (1 - bleach)(c_e sigma_e + c_p sigma_p) + dye.
    pub fn vertex_params(&self, pigments: PigmentSet, ratios: &LobeRatios) -> VertexParams {
        let (e, p) = (pigments.eumelanin(), pigments.pheomelanin());
        let kept = 1.0 - self.bleach;
        VertexParams {
            sigma_a: std::array::from_fn(|c| {
                kept * (self.eumelanin * e[c] + self.pheomelanin * p[c]) + self.dye[c]
            }),
            alpha_rad: self.alpha_deg.to_radians(),
            beta_rad: self.beta_deg.to_radians(),
            azimuthal_width: std::f32::consts::SQRT_2 * self.azimuthal_deg.to_radians(),
            eta: self.eta,
            eccentricity: self.eccentricity,
            alpha_ratios: [ratios.alpha_tt, ratios.alpha_trt],
            beta_ratios: [ratios.beta_tt, ratios.beta_trt],
        }
    }
}
