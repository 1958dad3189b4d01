//! The fibre that stands for a whole groom where light passes it.

use bytemuck::{Pod, Zeroable};

use crate::param::VertexParams;

/// The fibre whose averages stand for the whole groom, whatever its absorption; same layout as `Fibre` in `shaders/lib/fibre.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct MeanFibre {
    /// Not read: the table runs over absorption.
    sigma_a: [f32; 3],
    /// Index of refraction.
    pub eta: f32,
    /// Tilt of R, TT, TRT, radians.
    pub alpha: [f32; 3],
    /// Not read: the averages are a circular fibre's.
    eccentricity: f32,
    /// Standard deviation of R, TT, TRT in theta_h, radians.
    pub beta: [f32; 3],
    /// Azimuthal bandwidth w_c, radians.
    pub azimuthal_width: f32,
}

impl MeanFibre {
    /// Mean of all points' parameters; of the default parameters where there are none. beta is the root of the mean of beta^2.
    pub fn of(params: &[VertexParams]) -> Self {
        let count = params.len().max(1) as f64;
        let mean = |value: fn(&VertexParams) -> f64| params.iter().map(value).sum::<f64>() / count;
        let alpha_of = |lobe: fn(&VertexParams) -> f64| mean(lobe) as f32;
        let beta_of = |lobe: fn(&VertexParams) -> f64| mean(lobe).sqrt() as f32;
        Self {
            sigma_a: [0.0; 3],
            eta: mean(|p| f64::from(p.eta)) as f32,
            alpha: [
                alpha_of(|p| f64::from(p.alpha_rad)),
                alpha_of(|p| f64::from(p.alpha_rad * p.alpha_ratios[0])),
                alpha_of(|p| f64::from(p.alpha_rad * p.alpha_ratios[1])),
            ],
            eccentricity: 1.0,
            beta: [
                beta_of(|p| f64::from(p.beta_rad).powi(2)),
                beta_of(|p| f64::from(p.beta_rad * p.beta_ratios[0]).powi(2)),
                beta_of(|p| f64::from(p.beta_rad * p.beta_ratios[1]).powi(2)),
            ],
            azimuthal_width: mean(|p| f64::from(p.azimuthal_width)) as f32,
        }
    }
}
