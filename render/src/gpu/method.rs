//! How single scattering is evaluated: the model, the scheme that integrates it, and how finely; and which shader files that means.

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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scheme {
    /// Gauss nodes in inclination and offset, closed forms in azimuth.
    #[default]
    Nodes,
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

    /// Files that stand in for others where a pass is composed (`shader::compose`).
    pub fn files(&self) -> &'static [(&'static str, &'static str)] {
        match (self.model, self.scheme) {
            (Model::Marschner, Scheme::Nodes) => &[],
            (Model::Deon, _) => &[
                ("lib/single.wgsl", "lib/single_deon.wgsl"),
                ("lib/global.wgsl", "lib/global_deon.wgsl"),
                ("lib/forward.wgsl", "lib/forward_deon.wgsl"),
                ("lib/averages.wgsl", "lib/averages_deon.wgsl"),
            ],
            (Model::KajiyaKay, _) => &[("lib/single.wgsl", "lib/single_kajiya_kay.wgsl")],
        }
    }

    /// Pipeline-overridable constants of those files.
    pub fn constants(&self) -> Vec<(&'static str, f64)> {
        vec![("quality", f64::from(self.quality as u8))]
    }
}
