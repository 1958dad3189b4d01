//! The energy-conserving model of d'Eon 2011: S_p = M_p N_p, any order p, no cosine beside it.
//!
//! Conventions where the paper leaves a choice: v_p = (2 beta_p)^2 with beta_p the fibre's standard deviation in theta_h; the
//! tilt enters as theta_o - 2 alpha_p; p >= 3 takes TRT's alpha and beta; all detectors have the standard deviation
//! azimuthal_width / sqrt 2; R's Fresnel term is at cos(theta_d) cos(gamma) (Eq 12 prints the half angle); absorption runs along
//! the chord 2 cos(gamma_t) (the printed exponent 2 mu' (1 + cos 2 gamma_t) is 2 cos(gamma_t) chords). The cross-section is
//! circular: eccentricity is not read.

use std::f64::consts::{PI, SQRT_2};

use super::azimuthal::CrossSection;
use super::bessel::i0e;
use super::circular::{DetectedLight, GaussianDetector, Unit};
use super::fibre::{Direction, Fibre, OpticsError, Rgb, SrbfLight, check_inclination, check_tolerance};
use super::longitudinal::{integrate_theta, settled};
use super::quadrature::Estimate;
use super::single::INNER;

/// Highest order that the reference evaluates.
pub const MOST_ORDERS: u32 = 64;

/// M_p(v, theta_i, theta_r) of d'Eon 2011, Eq 7: the light of one cone, spread by a spherical Gaussian of variance `v`.
///
/// Integrates with cos(theta_i) to one over theta_i. In Eq 7's own form csch overflows below v = 0.0014; here all exponents are
/// joined: exp(-2 sin^2((theta_i + theta_r) / 2) / v).
pub fn m_p(v: f64, theta_i: f64, theta_r: f64) -> f64 {
    ln_m_p(v, theta_i, theta_r).exp()
}

/// Logarithm of [`m_p`].
fn ln_m_p(v: f64, theta_i: f64, theta_r: f64) -> f64 {
    // A tilt may carry theta_r beyond the pole, where the cosine is negative and the cone comes in from the other side.
    let x = theta_i.cos() * theta_r.cos() / v;
    let s = if x >= 0.0 {
        (0.5 * (theta_i + theta_r)).sin()
    } else {
        (0.5 * (theta_i - theta_r)).cos()
    };
    i0e(x).ln() - 2.0 * s * s / v - (v * -(-2.0 / v).exp_m1()).ln()
}

/// alpha and v of the path of order p.
fn tilt_and_variance(fibre: &Fibre, p: u32) -> (f64, f64) {
    let lobe = p.min(2) as usize;
    (fibre.alpha[lobe], (2.0 * fibre.beta[lobe]).powi(2))
}

/// Standard deviation of the Gaussian detectors.
fn detector_width(fibre: &Fibre) -> f64 {
    fibre.azimuthal_width / SQRT_2
}

/// Refuses orders beyond what the reference resolves.
fn check_orders(orders: u32) -> Result<(), OpticsError> {
    if orders <= MOST_ORDERS {
        return Ok(());
    }
    Err(OpticsError::Refused {
        field: "orders",
        value: f64::from(orders),
        requirement: "at most 64; higher ones belong to the geometric tail",
    })
}

/// N_p at difference angle theta_d and azimuth phi: d'Eon 2011, Eq 10, with its Gaussian detector. Relative `tolerance`.
///
/// # Errors
/// Values that the model refuses; an integral that does not settle.
pub fn n_p(fibre: &Fibre, p: u32, theta_d: f64, phi: f64, tolerance: f64) -> Result<Rgb, OpticsError> {
    fibre.check()?;
    check_orders(p)?;
    check_inclination("theta_d", theta_d)?;
    check_tolerance(tolerance)?;
    let detector = GaussianDetector::new(detector_width(fibre));
    let section = CrossSection::new(fibre.eta, theta_d);
    settled(
        "N_p",
        &section.integrate(p, &fibre.sigma_a, &detector, phi, tolerance),
        tolerance,
    )
}

/// S_p(w_i, w_r) = M_p N_p for light from one direction (d'Eon 2011, Eq 2).
///
/// # Errors
/// As [`n_p`].
pub fn scattering_function(
    fibre: &Fibre,
    p: u32,
    light: Direction,
    view: Direction,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    light.check(["theta_i", "phi_i"])?;
    view.check(["theta_o", "phi_o"])?;
    let (alpha, v) = tilt_and_variance(fibre, p);
    let m = m_p(v, light.theta, view.theta - 2.0 * alpha);
    let n = n_p(
        fibre,
        p,
        0.5 * (view.theta - light.theta),
        view.phi - light.phi,
        tolerance,
    )?;
    Ok(n.map(|n| m * n))
}

/// Integral over the sphere of G S_p dw for a light of peak one, p = 0 .. orders - 1; one entry per p.
///
/// # Errors
/// As [`n_p`].
pub fn single_scattering(
    fibre: &Fibre,
    view: Direction,
    light: &SrbfLight,
    orders: u32,
    tolerance: f64,
) -> Result<Vec<Rgb>, OpticsError> {
    fibre.check()?;
    view.check(["theta_o", "phi_o"])?;
    check_orders(orders)?;
    check_tolerance(tolerance)?;
    let phi = view.phi - light.centre.phi;
    let of_order = |p: u32| {
        let inner = |section: &CrossSection, theta_i: f64, tolerance: f64| {
            let lit = light.azimuthal_sharpness(theta_i);
            if lit == 0.0 {
                return section.integrate(p, &fibre.sigma_a, &Unit, phi, tolerance);
            }
            let kernel = DetectedLight::new(lit, detector_width(fibre));
            section.integrate(p, &fibre.sigma_a, &kernel, phi, tolerance)
        };
        integrate_order(fibre, p, view.theta, light, inner, tolerance)
    };
    (0..orders).map(of_order).collect()
}

/// Integral over theta_i of g^c M_p cos(theta_i) times `inner`.
fn integrate_order(
    fibre: &Fibre,
    p: u32,
    theta_o: f64,
    light: &SrbfLight,
    inner: impl Fn(&CrossSection, f64, f64) -> Estimate<3>,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    let (alpha, v) = tilt_and_variance(fibre, p);
    let ln_weight = |theta_i: f64| ln_m_p(v, theta_i, theta_o - 2.0 * alpha) + light.ln_longitudinal(theta_i);
    let integrand = |theta_i: f64| {
        let section = CrossSection::new(fibre.eta, 0.5 * (theta_o - theta_i));
        inner(&section, theta_i, INNER * tolerance)
            .value
            .map(|n| n * theta_i.cos())
    };
    let integral = integrate_theta(ln_weight, 1.0 / v + light.sharpness, integrand, tolerance);
    settled("single scattering", &integral, tolerance)
}

/// Radiance of one straight fibre in a uniform environment of radiance one: orders below `orders`, then the geometric series
/// of all higher ones, offset by offset: A_p + A_(p+1) + ... = A_p / (1 - f T). Without absorption it is one.
///
/// # Errors
/// As [`n_p`].
pub fn furnace_radiance(
    fibre: &Fibre,
    theta_o: f64,
    orders: u32,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    let view = Direction {
        theta: theta_o,
        phi: 0.0,
    };
    let uniform = SrbfLight::uniform();
    let first = orders.max(1);
    let explicit = single_scattering(fibre, view, &uniform, first, tolerance)?;
    let tail = integrate_order(
        fibre,
        first,
        theta_o,
        &uniform,
        |section, _, tolerance| section.integrate_tail(first, &fibre.sigma_a, tolerance),
        tolerance,
    )?;
    Ok(std::array::from_fn(|c| {
        explicit.iter().map(|s| s[c]).sum::<f64>() + tail[c]
    }))
}

/// The cone of d'Eon 2011, Appendix A, before its azimuth is integrated in closed form: the spherical Gaussian of variance `v`
/// between two directions, normalised over the sphere. For checking [`m_p`].
pub fn spherical_gaussian(v: f64, theta_i: f64, theta_r: f64, phi: f64) -> f64 {
    // Light at -theta_i makes the specular cone.
    let cosine = theta_i.cos() * theta_r.cos() * phi.cos() - theta_i.sin() * theta_r.sin();
    ((cosine - 1.0) / v).exp() / (2.0 * PI * v * -(-2.0 / v).exp_m1())
}
