//! The longitudinal factor M and integrals over theta_i.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::fibre::OpticsError;
use super::quadrature::{Estimate, Tolerance, integrate};

/// Where the logarithm of a longitudinal weight has fallen so far below its peak that no azimuthal factor makes up for it.
const LN_NEGLIGIBLE: f64 = -100.0;

/// Logarithm of the normal density of mean `mean` and standard deviation `std`.
pub(super) fn ln_normal(x: f64, mean: f64, std: f64) -> f64 {
    let z = (x - mean) / std;
    -0.5 * z * z - (TAU.sqrt() * std).ln()
}

/// M_t as a density of theta_i: normal around 2 alpha - theta_o with standard deviation 2 beta.
///
/// Marschner 2003 (section 5.1) and Xu 2011 (Eq 7) take the density in theta_h, which integrates to two over theta_i; this one
/// integrates to one, as d'Eon 2011 (section 4.1) asks for. Symmetric in theta_i and theta_o.
pub fn m(alpha: f64, beta: f64, theta_i: f64, theta_o: f64) -> f64 {
    ln_m(alpha, beta, theta_i, theta_o).exp()
}

/// Logarithm of [`m`].
pub(super) fn ln_m(alpha: f64, beta: f64, theta_i: f64, theta_o: f64) -> f64 {
    ln_normal(theta_i, 2.0 * alpha - theta_o, 2.0 * beta)
}

/// cos^2 theta_i / cos^2 theta_d: the solid angle's and the projection's cosine over the cone's compression (Xu 2011, Eq 11).
pub(super) fn cosine_ratio(theta_i: f64, theta_o: f64) -> f64 {
    let ratio = theta_i.cos() / (0.5 * (theta_o - theta_i)).cos();
    ratio * ratio
}

/// Integral over theta in [-pi/2, pi/2] of exp(ln_weight) times `inner`.
///
/// `precision` is the sum of the inverse variances of the weight's Gaussian factors; it sizes the first panels around the peak.
pub(super) fn integrate_theta<const N: usize>(
    ln_weight: impl Fn(f64) -> f64,
    precision: f64,
    mut inner: impl FnMut(f64) -> [f64; N],
    tolerance: impl Into<Tolerance>,
) -> Estimate<N> {
    let peak = peak_of(&ln_weight);
    let ln_peak = ln_weight(peak);
    let width = precision.recip().sqrt();
    let breaks = [-8.0, -3.0, 0.0, 3.0, 8.0].map(|k| peak + k * width);
    let scale = if ln_peak.is_finite() { ln_peak.exp() } else { 0.0 };

    // The weight is taken relative to its peak, so that far tails keep their digits.
    let integrand = |theta: f64| {
        let ln = ln_weight(theta) - ln_peak;
        if ln.is_nan() || ln < LN_NEGLIGIBLE {
            return [0.0; N];
        }
        inner(theta).map(|y| y * ln.exp())
    };
    let mut tolerance = tolerance.into();
    if scale > 0.0 {
        tolerance.absolute /= scale;
    }
    let relative = integrate(integrand, -FRAC_PI_2, FRAC_PI_2, &breaks, tolerance);
    Estimate {
        value: relative.value.map(|v| v * scale),
        error: relative.error.map(|e| e * scale),
    }
}

/// The place in [-pi/2, pi/2] where a smooth function with one basin is largest: a scan, then golden sections.
fn peak_of(f: &impl Fn(f64) -> f64) -> f64 {
    const STEPS: i32 = 256;
    let step = std::f64::consts::PI / f64::from(STEPS);
    let at = |k: i32| (-FRAC_PI_2 + f64::from(k) * step).clamp(-FRAC_PI_2, FRAC_PI_2);
    let best = (0..=STEPS)
        .map(at)
        .max_by(|a, b| f(*a).total_cmp(&f(*b)))
        .unwrap_or(0.0);
    let (mut low, mut high) = ((best - step).max(-FRAC_PI_2), (best + step).min(FRAC_PI_2));
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    while high - low > 1e-9 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if f(a) < f(b) { low = a } else { high = b }
    }
    0.5 * (low + high)
}

/// The value of an estimate that is good enough, else the reason.
pub(super) fn settled<const N: usize>(
    what: &'static str,
    estimate: &Estimate<N>,
    tolerance: impl Into<Tolerance>,
) -> Result<[f64; N], OpticsError> {
    let tolerance = tolerance.into();
    // Scaling a total and its bound may round them apart by a few bits.
    let slack = Tolerance {
        relative: 1.001 * tolerance.relative,
        absolute: 1.001 * tolerance.absolute,
    };
    if estimate.within(slack) {
        return Ok(estimate.value);
    }
    let (reached, wanted) = (estimate.relative_error(), tolerance.relative);
    Err(OpticsError::NotConverged {
        what,
        reached,
        wanted,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn m_integrates_to_one_over_the_line() {
        for (alpha, beta, theta_o) in [(-0.1, 0.08, 0.3), (0.05, 0.01, -1.2), (0.0, 0.6, 1.5)] {
            let centre = 2.0 * alpha - theta_o;
            let reach = 20.0 * beta;
            let whole = integrate(
                |t| [m(alpha, beta, t, theta_o)],
                centre - reach,
                centre + reach,
                &[centre],
                1e-11,
            );
            assert!((whole.value[0] - 1.0).abs() < 1e-10);
            assert!(
                (2.0 * whole.value[0] - 1.0).abs() > 0.5,
                "Eq 7 of Xu 2011 as printed must fail"
            );
        }
    }

    #[test]
    fn theta_integral_finds_narrow_peaks() {
        let width: f64 = 2e-4;
        let got = integrate_theta(|t| ln_normal(t, 0.777, width), width.powi(-2), |_| [1.0], 1e-10);
        assert!((got.value[0] - 1.0).abs() < 1e-9);
    }
}
