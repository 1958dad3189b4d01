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
        // One pass: this runs after every dab.
        let mut sums = [0.0; 8];
        for p in params {
            let (alpha, beta) = (p.alpha_rad, p.beta_rad);
            let values = [
                p.eta,
                p.azimuthal_width,
                alpha,
                alpha * p.alpha_ratios[0],
                alpha * p.alpha_ratios[1],
                beta,
                beta * p.beta_ratios[0],
                beta * p.beta_ratios[1],
            ];
            for (k, (sum, value)) in sums.iter_mut().zip(values.map(f64::from)).enumerate() {
                *sum += if k < 5 { value } else { value * value };
            }
        }
        let mean = sums.map(|sum| sum / params.len().max(1) as f64);
        let beta_of = |k: usize| mean[k].sqrt() as f32;
        Self {
            sigma_a: [0.0; 3],
            eta: mean[0] as f32,
            alpha: [mean[2] as f32, mean[3] as f32, mean[4] as f32],
            eccentricity: 1.0,
            beta: [beta_of(5), beta_of(6), beta_of(7)],
            azimuthal_width: mean[1] as f32,
        }
    }
}
