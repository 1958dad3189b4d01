//! What a fibre does to light on average over azimuths: attenuations, shifts and widths (Xu 2011, section 4.3.2; Zinke 2008).

use super::azimuthal::CrossSection;
use super::circular::AzimuthShare;
use super::fibre::{Fibre, Lobe, OpticsError, Rgb, check_inclination, check_tolerance};
use super::longitudinal::{integrate_theta, ln_m, settled};
use super::quadrature::Tolerance;
use super::single::INNER;

/// Shares of light below this are rounding: TT of an index near one leaves within 1e-16 of the azimuth where its backward
/// share vanishes.
const ROUNDING: f64 = 1e-13;

/// Averages at one inclination; forward is the half circle of azimuths away from the light, backward the one towards it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Averages {
    /// Average forward attenuation, Eq 32.
    pub a_f: Rgb,
    /// Average backward attenuation.
    pub a_b: Rgb,
    /// Average forward shift, radians in theta_h.
    pub alpha_f: Rgb,
    /// Average backward shift.
    pub alpha_b: Rgb,
    /// Average forward standard deviation, radians in theta_h: the root of the mean of beta^2.
    pub beta_f: Rgb,
    /// Average backward standard deviation.
    pub beta_b: Rgb,
}

/// a_f or a_b per lobe at inclination `theta`: Eq 32 of Xu 2011 with both cosines and cos^2 theta_d inside the integral.
///
/// Eq 33 puts theta_d = theta and takes N out of the integral, 16 to 22 % off beyond 60 degrees. Of the circular fibre.
///
/// # Errors
/// Values that the model refuses; an integral that does not settle.
pub fn attenuation(
    fibre: &Fibre,
    theta: f64,
    share: AzimuthShare,
    tolerance: f64,
) -> Result<[Rgb; 3], OpticsError> {
    fibre.check()?;
    check_inclination("theta_j", theta)?;
    check_tolerance(tolerance)?;
    let outer = Tolerance {
        relative: tolerance,
        absolute: ROUNDING,
    };
    let inside = Tolerance {
        relative: INNER * tolerance,
        absolute: INNER * ROUNDING,
    };
    let of_lobe = |lobe: Lobe| {
        let (alpha, beta) = (fibre.alpha[lobe as usize], fibre.beta[lobe as usize]);
        let inner = |theta_o: f64| {
            let theta_d = 0.5 * (theta_o - theta);
            let section = CrossSection::new(fibre.eta, theta_d);
            let n = section
                .integrate(lobe.p(), &fibre.sigma_a, &share, 0.0, inside)
                .value;
            let cos_theta_d = theta_d.cos();
            n.map(|n| n * theta.cos() * theta_o.cos() / (cos_theta_d * cos_theta_d))
        };
        let ln_weight = |theta_o: f64| ln_m(alpha, beta, theta_o, theta);
        let a = integrate_theta(ln_weight, 0.25 / (beta * beta), inner, outer);
        settled("average attenuation", &a, outer)
    };
    let [r, tt, trt] = Lobe::ALL.map(of_lobe);
    Ok([r?, tt?, trt?])
}

/// All averages of the fibre at inclination `theta`, radians.
///
/// # Errors
/// As [`attenuation`].
pub fn scattering_averages(fibre: &Fibre, theta: f64, tolerance: f64) -> Result<Averages, OpticsError> {
    let forward = attenuation(fibre, theta, AzimuthShare::Forward, tolerance)?;
    let backward = attenuation(fibre, theta, AzimuthShare::Backward, tolerance)?;
    Ok(Averages::of_lobes(fibre, &forward, &backward))
}

impl Averages {
    /// From what each lobe scatters forward and backward.
    pub(super) fn of_lobes(fibre: &Fibre, forward: &[Rgb; 3], backward: &[Rgb; 3]) -> Self {
        let beta_squared = fibre.beta.map(|beta| beta * beta);
        Self {
            a_f: sum(forward),
            a_b: sum(backward),
            alpha_f: weighted(forward, &fibre.alpha),
            alpha_b: weighted(backward, &fibre.alpha),
            beta_f: weighted(forward, &beta_squared).map(f64::sqrt),
            beta_b: weighted(backward, &beta_squared).map(f64::sqrt),
        }
    }
}

/// Sum over the lobes.
fn sum(weights: &[Rgb; 3]) -> Rgb {
    std::array::from_fn(|c| weights.iter().map(|w| w[c]).sum())
}

/// Mean over the lobes of `values` with `weights`; R's value where nothing is scattered at all.
fn weighted(weights: &[Rgb; 3], values: &[f64; 3]) -> Rgb {
    std::array::from_fn(|c| {
        let total: f64 = weights.iter().map(|w| w[c]).sum();
        if total == 0.0 {
            return values[0];
        }
        weights.iter().zip(values).map(|(w, v)| w[c] * v).sum::<f64>() / total
    })
}
