//! Kajiya and Kay 1989 under an SRBF light: S = K_d + K_s cos^n(theta_i + theta_o - 2 alpha_R) / cos(theta_i) (Ren 2010, section 3).
//!
//! n = 1 / (2 beta_R)^2, so that the highlight is as wide in theta_i as Marschner's R; K_s holds the mean reflectance of the fibre seen
//! across, K_d what is left of the light, coloured by [`colour`].

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::bessel::i0e;
use super::fibre::{OpticsError, Rgb, SrbfLight, check_inclination, check_tolerance};
use super::fresnel::fresnel;
use super::longitudinal::{integrate_theta, settled};
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
    settled("the diffuse term", &integral, tolerance).map(|[value]| value)
}

/// The specular term with K_s = 1: integral of G cos^n(theta_i + axis) over the sphere, axis = theta_o - 2 alpha_R.
///
/// # Errors
/// A tolerance out of range, an axis beyond 3 pi / 2; an integral that does not settle.
pub fn specular(n: f64, axis: f64, light: &SrbfLight, tolerance: f64) -> Result<f64, OpticsError> {
    check_tolerance(tolerance)?;
    check_inclination("axis", axis / 3.0)?;
    let ln_weight = |theta_i: f64| {
        let cosine = (theta_i + axis).cos();
        if cosine <= 0.0 {
            return f64::NEG_INFINITY;
        }
        n * cosine.ln() + light.ln_longitudinal(theta_i)
    };
    let inner = |theta_i: f64| [TAU * i0e(light.azimuthal_sharpness(theta_i)) * theta_i.cos()];
    let integral = integrate_theta(ln_weight, n + light.sharpness, inner, tolerance);
    settled("the specular term", &integral, tolerance).map(|[value]| value)
}

/// n of a highlight of standard deviation `beta` in theta_h.
pub fn exponent(beta: f64) -> f64 {
    0.25 / (beta * beta)
}

/// Growth of the absorbance of hair with the root of a fibre's absorption.
pub const COLOUR_GROWTH: f64 = 4.0;

/// Colour of much hair whose fibres absorb `sigma_a` per radius: exp(-4 sqrt(sigma_a)).
///
/// It is what a half space of d'Eon's fibres (eta 1.55) sends back, a_b / (1 - a_f + k) averaged over inclinations, within 0.035: diffusion
/// makes it fall with the root of the absorption, and what R adds at any absorption (0.034) is the specular term's.
pub fn colour(sigma_a: &Rgb) -> Rgb {
    sigma_a.map(|sigma| (-COLOUR_GROWTH * sigma.sqrt()).exp())
}

/// Mean over the offset of the reflectance of a fibre seen across.
pub fn mean_reflectance(eta: f64) -> f64 {
    let integrand = |gamma: f64| [fresnel(eta, gamma.cos()) * gamma.cos()];
    integrate(integrand, 0.0, FRAC_PI_2, &[], 1e-10).value[0]
}

/// K_s of the exponent n: the reflectance over the integral of cos^n with its cosine for a view from the side, whose Gamma functions
/// are within 0.1 % of the root for n > 1.
pub fn specular_strength(n: f64, eta: f64) -> f64 {
    mean_reflectance(eta) * ((n + 1.5) / TAU).sqrt() / TAU
}

/// K_d: what is not reflected, over the integral pi^2 of the cosine, coloured.
pub fn diffuse_strength(sigma_a: &Rgb, eta: f64) -> Rgb {
    let left = (1.0 - mean_reflectance(eta)) / (PI * PI);
    colour(sigma_a).map(|c| left * c)
}
