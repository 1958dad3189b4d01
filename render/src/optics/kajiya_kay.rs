//! Kajiya and Kay 1989 under an SRBF light.

use std::f64::consts::{FRAC_PI_2, PI};

use super::fibre::{OpticsError, SrbfLight, check_tolerance};
use super::quadrature::integrate;

/// The diffuse term with K_d = 1: integral of G cos(theta_i) over the sphere, by quadrature over theta_i and phi_i.
///
/// It depends on theta_j and lambda_j alone: the table of the notes on Ren 2010, whose lambda is the sharpness 2 / lambda_j^2.
///
/// # Errors
/// A tolerance out of range; an integral that does not settle.
pub fn diffuse(light: &SrbfLight, tolerance: f64) -> Result<f64, OpticsError> {
    check_tolerance(tolerance)?;
    let over_phi = |theta: f64| {
        let lit = light.azimuthal_sharpness(theta);
        let width = lit.recip().sqrt();
        let breaks = if width.is_finite() {
            [width, 3.0 * width, 8.0 * width]
        } else {
            [1.0; 3]
        };
        let g = |phi: f64| {
            let s = (0.5 * phi).sin();
            [2.0 * (-2.0 * lit * s * s).exp()]
        };
        integrate(g, 0.0, PI, &breaks, 0.1 * tolerance).value[0]
    };
    let integrand = |theta: f64| [theta.cos().powi(2) * light.ln_longitudinal(theta).exp() * over_phi(theta)];
    let width = if light.sharpness > 0.0 {
        light.sharpness.recip().sqrt()
    } else {
        1.0
    };
    let breaks = [-8.0, -3.0, 0.0, 3.0, 8.0].map(|k| light.centre.theta + k * width);
    let integral = integrate(integrand, -FRAC_PI_2, FRAC_PI_2, &breaks, tolerance);
    super::longitudinal::settled("the diffuse term", &integral, tolerance).map(|[value]| value)
}
