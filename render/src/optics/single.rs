//! Single scattering of one fibre (Xu 2011, section 4.2), integrated numerically.

use super::azimuthal::CrossSection;
use super::circular::{CircularGaussian, Kernel, SmoothedLight, Unit, sharpness};
use super::fibre::{
    Direction, Fibre, Lobe, Lobes, OpticsError, Rgb, SrbfLight, check_inclination, check_tolerance,
};
use super::longitudinal::{cosine_ratio, integrate_theta, ln_m, m, settled};
use super::quadrature::integrate;

/// How much tighter an inner integral is than the one around it.
pub(super) const INNER: f64 = 0.2;

/// Share of a light's peak that no smoothed TRT makes up for.
const UNLIT: f64 = 1e-35;

/// I_t = integral over the sphere of G S_t cos(theta_i) dw for a light of peak one: Xu 2011, Eq 11, without its approximations.
///
/// TRT is smoothed by the normalised circular Gaussian of bandwidth w_c and sees eta*(phi_h) inside the integral (Eq 25, first
/// line); R and TT are those of the smooth circular fibre. `tolerance` is relative, per lobe and channel.
///
/// # Errors
/// Values that the model refuses; an integral that does not settle.
pub fn single_scattering(
    fibre: &Fibre,
    view: Direction,
    light: &SrbfLight,
    tolerance: f64,
) -> Result<Lobes, OpticsError> {
    fibre.check()?;
    view.check(["theta_o", "phi_o"])?;
    check_tolerance(tolerance)?;
    Lobes::try_each(|lobe| single_scattering_lobe(fibre, lobe, view, light, tolerance))
}

/// One lobe of [`single_scattering`], of checked values.
fn single_scattering_lobe(
    fibre: &Fibre,
    lobe: Lobe,
    view: Direction,
    light: &SrbfLight,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    let (alpha, beta) = (fibre.alpha[lobe as usize], fibre.beta[lobe as usize]);
    let ln_weight = |theta_i: f64| ln_m(alpha, beta, theta_i, view.theta) + light.ln_longitudinal(theta_i);
    let precision = 0.25 / (beta * beta) + light.sharpness;
    let inner = |theta_i: f64| {
        let n = azimuthal_light(fibre, lobe, view, light, theta_i, INNER * tolerance);
        n.map(|n| n * cosine_ratio(theta_i, view.theta))
    };
    settled(
        "single scattering",
        &integrate_theta(ln_weight, precision, inner, tolerance),
        tolerance,
    )
}

/// The inner integral of Xu 2011, Eq 12: N_t against the light's azimuthal factor at one theta_i.
fn azimuthal_light(
    fibre: &Fibre,
    lobe: Lobe,
    view: Direction,
    light: &SrbfLight,
    theta_i: f64,
    tolerance: f64,
) -> Rgb {
    let theta_d = 0.5 * (view.theta - theta_i);
    let phi = view.phi - light.centre.phi;
    let lit = light.azimuthal_sharpness(theta_i);
    if lobe == Lobe::Trt && fibre.eccentricity != 1.0 {
        return elliptic_light(fibre, theta_d, view.phi, light.centre.phi, lit, tolerance);
    }
    let section = CrossSection::new(fibre.eta, theta_d);
    let (p, sigma_a) = (lobe.p(), &fibre.sigma_a);
    if lit == 0.0 {
        return section.integrate(p, sigma_a, &Unit, phi, tolerance).value;
    }
    if lobe == Lobe::Trt {
        let kernel = SmoothedLight::new(lit, sharpness(fibre.azimuthal_width));
        return section.integrate(p, sigma_a, &kernel, phi, tolerance).value;
    }
    section
        .integrate(p, sigma_a, &CircularGaussian::peak_one(lit), phi, tolerance)
        .value
}

/// [`azimuthal_light`] of TRT with eta*(phi_h) inside the integral over phi_i.
fn elliptic_light(fibre: &Fibre, theta_d: f64, phi_o: f64, phi_j: f64, lit: f64, tolerance: f64) -> Rgb {
    use std::f64::consts::PI;

    let smoothing = CircularGaussian::normalised(sharpness(fibre.azimuthal_width));
    let light = CircularGaussian::peak_one(lit);
    let integrand = |x: f64| {
        let g = light.value(x);
        if g < UNLIT {
            return [0.0; 3];
        }
        let phi_i = phi_j + x;
        let section = CrossSection::new(fibre.eta_star(phi_o + phi_i), theta_d);
        let n = section.integrate(
            Lobe::Trt.p(),
            &fibre.sigma_a,
            &smoothing,
            phi_o - phi_i,
            INNER * tolerance,
        );
        n.value.map(|n| n * g)
    };
    let width = light.width();
    let breaks = [-5.0, -2.0, 0.0, 2.0, 5.0].map(|k| if width.is_finite() { k * width } else { 0.5 * k });
    integrate(integrand, -PI, PI, &breaks, tolerance).value
}

/// S_t(w_i, w_o) = M_t N_t / cos^2 theta_d for light from one direction (Xu 2011, Eq 6); TRT smoothed and elliptic as in
/// [`single_scattering`]. `tolerance` is that of TRT's integral.
///
/// # Errors
/// Values that the model refuses; an integral that does not settle.
pub fn scattering_function(
    fibre: &Fibre,
    light: Direction,
    view: Direction,
    tolerance: f64,
) -> Result<Lobes, OpticsError> {
    fibre.check()?;
    light.check(["theta_i", "phi_i"])?;
    view.check(["theta_o", "phi_o"])?;
    check_tolerance(tolerance)?;
    let theta_d = 0.5 * (view.theta - light.theta);
    let phi = view.phi - light.phi;
    Lobes::try_each(|lobe| {
        let n = if lobe == Lobe::Trt {
            let section = CrossSection::new(fibre.eta_star(view.phi + light.phi), theta_d);
            let smoothing = CircularGaussian::normalised(sharpness(fibre.azimuthal_width));
            let n = section.integrate(lobe.p(), &fibre.sigma_a, &smoothing, phi, tolerance);
            settled("N_TRT", &n, tolerance)?
        } else {
            CrossSection::new(fibre.eta, theta_d).n_smooth(lobe.p(), &fibre.sigma_a, phi)
        };
        let m = m(
            fibre.alpha[lobe as usize],
            fibre.beta[lobe as usize],
            light.theta,
            view.theta,
        );
        let cos_theta_d = theta_d.cos();
        Ok(n.map(|n| m * n / (cos_theta_d * cos_theta_d)))
    })
}

/// Radiance of one straight fibre in a uniform environment of radiance one, seen at inclination theta_o and averaged over
/// its azimuth: the energy of the three lobes; one when no light is lost or absorbed.
///
/// Of the circular fibre: in a uniform environment the azimuth of an elliptic one would matter.
///
/// # Errors
/// As [`single_scattering`].
pub fn furnace_radiance(fibre: &Fibre, theta_o: f64, tolerance: f64) -> Result<Rgb, OpticsError> {
    check_inclination("theta_o", theta_o)?;
    let view = Direction {
        theta: theta_o,
        phi: 0.0,
    };
    Ok(single_scattering(&fibre.circular(), view, &SrbfLight::uniform(), tolerance)?.sum())
}
