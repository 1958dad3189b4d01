//! Multiple scattering: the global and local terms of Xu 2011 (section 4.3) and the per-fibre quantities behind them (Zinke 2008).

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use super::averages::{Averages, scattering_averages};
use super::azimuthal::CrossSection;
use super::circular::{HalfCircle, SmoothedHalfCircle, sharpness};
use super::fibre::{
    Direction, Fibre, Lobe, Lobes, OpticsError, Rgb, check_inclination, check_tolerance, check_width,
};
use super::longitudinal::{cosine_ratio, integrate_theta, ln_m, ln_normal, settled};
use super::quadrature::integrate;
use super::single::INNER;

/// The inclination of the light must leave 1 / cos(theta_j) of Eq 27 and 29 finite.
pub(super) fn check_inverse_cosine(theta_j: f64) -> Result<(), OpticsError> {
    check_inclination("theta_j", theta_j)?;
    if theta_j.cos() < 1e-9 {
        return Err(OpticsError::Refused {
            field: "theta_j",
            value: theta_j,
            requirement: "off the poles by more than 1e-9: the global and local terms divide by its cosine",
        });
    }
    Ok(())
}

/// Light that arrives scattered forward (Xu 2011, Eq 27 and 28), per lobe: the unit normal of bandwidth `sigma_f` (radians in
/// theta_i, standard deviation sigma_f / sqrt 2) around theta_j, 1/pi over the half circle around phi_j, over cos(theta_j).
///
/// Of the circular fibre; TRT smoothed by w_c. No transmittance and no density factor.
///
/// # Errors
/// Values that the model refuses, theta_j at a pole; an integral that does not settle.
pub fn global_scattering(
    fibre: &Fibre,
    view: Direction,
    light: Direction,
    sigma_f: f64,
    tolerance: f64,
) -> Result<Lobes, OpticsError> {
    fibre.check()?;
    view.check(["theta_o", "phi_o"])?;
    light.check(["theta_j", "phi_j"])?;
    check_inverse_cosine(light.theta)?;
    check_width("sigma_f", sigma_f)?;
    check_tolerance(tolerance)?;
    let phi = view.phi - light.phi;
    let spread = sigma_f / SQRT_2;
    let smoothed = SmoothedHalfCircle::new(sharpness(fibre.azimuthal_width));
    Lobes::try_each(|lobe| {
        let (alpha, beta) = (fibre.alpha[lobe as usize], fibre.beta[lobe as usize]);
        let ln_weight =
            |theta_i: f64| ln_m(alpha, beta, theta_i, view.theta) + ln_normal(theta_i, light.theta, spread);
        let inner = |theta_i: f64| {
            let section = CrossSection::new(fibre.eta, 0.5 * (view.theta - theta_i));
            let (p, tolerance) = (lobe.p(), INNER * tolerance);
            let n = if lobe == Lobe::Trt {
                section.integrate(p, &fibre.sigma_a, &smoothed, phi, tolerance)
            } else {
                section.integrate(p, &fibre.sigma_a, &HalfCircle, phi, tolerance)
            };
            n.value
                .map(|n| n * cosine_ratio(theta_i, view.theta) / light.theta.cos())
        };
        let precision = 0.25 / (beta * beta) + 1.0 / (spread * spread);
        settled(
            "global scattering",
            &integrate_theta(ln_weight, precision, inner, tolerance),
            tolerance,
        )
    })
}

/// Light that comes back from the neighbourhood (Xu 2011, Eq 29 to 31) with A_b by [`zinke_a_b`], Delta_b and sigma_b at each
/// theta_i instead of Eq 31's mean; all at the inclination (theta_o - theta_i) / 2 of Table 1 (Eq 31 prints the other sign,
/// and A_b is not even). `sigma_f` as in [`global_scattering`]; sigma_b and Delta_b are doubled to theta_i. Includes the
/// factor 2 and the azimuth (pi - |phi|) / pi^2 of Eq 30; no density factor.
///
/// # Errors
/// As [`global_scattering`].
pub fn local_scattering(
    fibre: &Fibre,
    view: Direction,
    light: Direction,
    sigma_f: f64,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    fibre.check()?;
    view.check(["theta_o", "phi_o"])?;
    light.check(["theta_j", "phi_j"])?;
    check_inverse_cosine(light.theta)?;
    check_width("sigma_f", sigma_f)?;
    check_tolerance(tolerance)?;
    let spread = sigma_f / SQRT_2;
    let mut failure = None;
    let inner = |theta_i: f64| {
        let theta_d = 0.5 * (view.theta - theta_i);
        let averages = match scattering_averages(fibre, theta_d, INNER * tolerance) {
            Ok(averages) => averages,
            Err(error) => {
                failure = Some(error);
                return [0.0; 3];
            }
        };
        let backward = Backward::of(&averages);
        std::array::from_fn(|c| {
            let ln_back = ln_normal(theta_i, backward.delta_b[c] - view.theta, backward.sigma_b[c]);
            2.0 * backward.a_b_zinke[c] * ln_back.exp() * cosine_ratio(theta_i, view.theta)
                / light.theta.cos()
        })
    };
    let ln_weight = |theta_i: f64| ln_normal(theta_i, light.theta, spread);
    let integral = integrate_theta(ln_weight, 1.0 / (spread * spread), inner, tolerance);
    if let Some(error) = failure {
        return Err(error);
    }
    let azimuth = (PI - wrapped_distance(view.phi, light.phi)) / (PI * PI);
    Ok(settled("local scattering", &integral, tolerance)?.map(|v| v * azimuth))
}

/// The angle between two azimuths, in [0, pi].
fn wrapped_distance(a: f64, b: f64) -> f64 {
    (a - b).cos().clamp(-1.0, 1.0).acos()
}

/// Backscattering of the neighbourhood at one inclination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backward {
    /// A_b by Zinke's series, one and three backward events.
    pub a_b_zinke: Rgb,
    /// A_b by adding layers.
    pub a_b_adding: Rgb,
    /// Mean shift Delta_b, radians in theta_i.
    pub delta_b: Rgb,
    /// Standard deviation sigma_b, radians in theta_i.
    pub sigma_b: Rgb,
}

impl Backward {
    /// From the averages at the same inclination.
    pub fn of(averages: &Averages) -> Self {
        let Averages {
            a_f,
            a_b,
            alpha_f,
            alpha_b,
            beta_f,
            beta_b,
        } = averages;
        let each = |f: &dyn Fn(usize) -> f64| -> Rgb { std::array::from_fn(f) };
        Self {
            a_b_zinke: each(&|c| zinke_a_b(a_f[c], a_b[c])),
            a_b_adding: each(&|c| adding_a_b(a_f[c], a_b[c])),
            delta_b: each(&|c| 2.0 * delta_b(a_f[c], a_b[c], alpha_f[c], alpha_b[c])),
            sigma_b: each(&|c| 2.0 * sigma_b(a_f[c], a_b[c], beta_f[c], beta_b[c])),
        }
    }
}

/// The largest a_f for which Zinke's series are evaluated: they diverge at one.
const MOST_FORWARD: f64 = 0.99;

/// A_b of Zinke 2008 (Eq 11 to 14): sum of one backward event, A_1 = a_b a_f^2 / (1 - a_f^2), and three,
/// A_3 = a_b^3 a_f^2 / (1 - a_f^2)^3. a_f is held at 0.99.
pub fn zinke_a_b(a_f: f64, a_b: f64) -> f64 {
    let f2 = a_f.min(MOST_FORWARD).powi(2);
    let open = 1.0 - f2;
    a_b * f2 / open + a_b.powi(3) * f2 / open.powi(3)
}

/// Share of light that a half space of fibres sends back beyond the first fibre's own a_b, all orders, by adding layers:
/// A_b = r - a_b with r = a_b + a_f^2 r / (1 - a_b r). A fibre that sends out more than it gets is scaled to one.
pub fn adding_a_b(a_f: f64, a_b: f64) -> f64 {
    let (a_f, a_b) = at_most_all(a_f, a_b);
    if a_b == 0.0 {
        return 0.0;
    }
    // r is the smaller root of a_b r^2 - (1 + a_b^2 - a_f^2) r + a_b = 0; the discriminant is written as a product.
    let b = 1.0 + a_b * a_b - a_f * a_f;
    let discriminant =
        ((1.0 - a_b - a_f) * (1.0 - a_b + a_f) * (1.0 + a_b - a_f) * (1.0 + a_b + a_f)).max(0.0);
    2.0 * a_b / (b + discriminant.sqrt()) - a_b
}

/// Scales both shares so that their sum is at most one.
fn at_most_all(a_f: f64, a_b: f64) -> (f64, f64) {
    let excess = (a_f + a_b).max(1.0);
    (a_f / excess, a_b / excess)
}

/// Delta_b of Zinke 2008 (Eq 16): mean shift of backscattered light, in the angle of the alphas (theta_h).
pub fn delta_b(a_f: f64, a_b: f64, alpha_f: f64, alpha_b: f64) -> f64 {
    let f2 = a_f.min(MOST_FORWARD).powi(2);
    let (b2, open) = (a_b * a_b, 1.0 - f2);
    alpha_b * (1.0 - 2.0 * b2 / (open * open)) + alpha_f * (2.0 * open * open + 4.0 * f2 * b2) / open.powi(3)
}

/// sigma_b of Zinke 2008 (Eq 17): standard deviation of backscattered light in theta_h, from standard deviations in theta_h.
///
/// The printed formula is not homogeneous in the widths (its denominator adds a pure number to widths), so the unit matters:
/// it is evaluated with Xu's bandwidths sqrt(2) beta and the result is taken as such.
pub fn sigma_b(a_f: f64, a_b: f64, beta_f: f64, beta_b: f64) -> f64 {
    let (beta_f, beta_b) = (SQRT_2 * beta_f, SQRT_2 * beta_b);
    let (f2, b3) = (beta_f * beta_f, a_b.powi(3));
    let once = (2.0 * f2 + beta_b * beta_b).sqrt();
    let thrice = (2.0 * f2 + 3.0 * beta_b * beta_b).sqrt();
    let growth = 1.0 + 0.7 * a_f * a_f;
    growth * (a_b * once + b3 * thrice) / (a_b + b3 * (2.0 * beta_f + 3.0 * beta_b)) / SQRT_2
}

/// Extinction of diffuse light per fibre crossed, k = sqrt((1 - a_f - a_b) (1 - a_f + a_b)), the two-stream solution of a row
/// of fibres; zero for fibres that lose nothing.
pub fn extinction(a_f: f64, a_b: f64) -> f64 {
    let (a_f, a_b) = at_most_all(a_f, a_b);
    ((1.0 - a_f - a_b).max(0.0) * (1.0 - a_f + a_b)).sqrt()
}

/// Reflectance of a half space of fibres at one inclination: a_b / (1 - a_f + k).
pub fn half_space_reflectance(a_f: f64, a_b: f64) -> f64 {
    let (a_f, a_b) = at_most_all(a_f, a_b);
    let lost = 1.0 - a_f + extinction(a_f, a_b);
    if lost > 0.0 { a_b / lost } else { 0.0 }
}

/// rho: the cosine-weighted mean over theta in (-pi/2, pi/2) of [`half_space_reflectance`].
///
/// # Errors
/// As [`scattering_averages`].
pub fn mean_reflectance(fibre: &Fibre, tolerance: f64) -> Result<Rgb, OpticsError> {
    check_tolerance(tolerance)?;
    let mut failure = None;
    let integrand = |theta: f64| match scattering_averages(fibre, theta, INNER * tolerance) {
        Ok(averages) => std::array::from_fn(|c| {
            0.5 * theta.cos() * half_space_reflectance(averages.a_f[c], averages.a_b[c])
        }),
        Err(error) => {
            failure = Some(error);
            [0.0; 3]
        }
    };
    let mean = integrate(integrand, -FRAC_PI_2, FRAC_PI_2, &[0.0], tolerance);
    match failure {
        Some(error) => Err(error),
        None => settled("mean reflectance", &mean, tolerance),
    }
}
