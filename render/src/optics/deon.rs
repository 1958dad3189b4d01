//! The energy-conserving model of d'Eon 2011: S_p = M_p N_p, any order p, no cosine beside it.
//!
//! Conventions where the paper leaves a choice: v_p = (2 beta_p)^2 with beta_p the fibre's standard deviation in theta_h; the
//! tilt enters as theta_o - 2 alpha_p; p >= 3 takes TRT's alpha and beta; all detectors have the standard deviation
//! azimuthal_width / sqrt 2; R's Fresnel term is at cos(theta_d) cos(gamma) (Eq 12 prints the half angle); absorption runs along
//! the chord 2 cos(gamma_t) (the printed exponent 2 mu' (1 + cos 2 gamma_t) is 2 cos(gamma_t) chords). The cross-section is
//! circular: eccentricity is not read.

use std::f64::consts::{PI, SQRT_2};

use super::averages::Averages;
use super::azimuthal::CrossSection;
use super::bessel::i0e;
use super::circular::{AzimuthShare, DetectedHalf, DetectedLight, GaussianDetector, Kernel, Unit};
use super::dual::check_inverse_cosine;
use super::fibre::{
    Direction, Fibre, Lobe, Lobes, OpticsError, Rgb, SrbfLight, check_inclination, check_tolerance,
    check_width,
};
use super::longitudinal::{integrate_theta, ln_normal, settled};
use super::quadrature::{Estimate, Tolerance};
use super::single::INNER;

/// Orders p = 0 .. 3 are drawn one by one; those above are the remainder.
pub const DRAWN_ORDERS: u32 = 4;
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
pub(super) fn tilt_and_variance(fibre: &Fibre, p: u32) -> (f64, f64) {
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

/// Integral over the sphere of G times all orders from `first` (>= 1) on, as the shaders draw what is left beyond p = 3: the geometric
/// series of the orders' energy, the same to all azimuths, with the cone of order `first`.
///
/// # Errors
/// As [`n_p`].
pub fn remainder(
    fibre: &Fibre,
    view: Direction,
    light: &SrbfLight,
    first: u32,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    fibre.check()?;
    view.check(["theta_o", "phi_o"])?;
    check_orders(first)?;
    check_tolerance(tolerance)?;
    let inner = |section: &CrossSection, theta_i: f64, tolerance: f64| {
        // A light of concentration kappa and peak one integrates to 2 pi i0e(kappa) over the azimuth.
        let seen = i0e(light.azimuthal_sharpness(theta_i));
        let energy = section.integrate_tail(first, &fibre.sigma_a, tolerance);
        Estimate {
            value: energy.value.map(|e| seen * e),
            error: energy.error.map(|e| seen * e),
        }
    };
    integrate_order(fibre, first, view.theta, light, inner, tolerance)
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
    let tail = remainder(fibre, view, &uniform, first, tolerance)?;
    Ok(std::array::from_fn(|c| {
        explicit.iter().map(|s| s[c]).sum::<f64>() + tail[c]
    }))
}

/// All averages of the fibre at inclination `theta` of the light, radians, all orders: Eq 32 of Xu 2011 with S_p = M_p N_p, the remainder
/// beyond p = 3 the same to all azimuths. The tilt goes with the light: M_p(theta_o, theta - 2 alpha) integrates to one over the views,
/// so that a fibre without absorption loses nothing at any tilt.
///
/// # Errors
/// As [`n_p`].
pub fn scattering_averages(fibre: &Fibre, theta: f64, tolerance: f64) -> Result<Averages, OpticsError> {
    fibre.check()?;
    check_inclination("theta_j", theta)?;
    check_tolerance(tolerance)?;
    let shares = |share: AzimuthShare| {
        let kernel = DetectedHalf::share(share, detector_width(fibre));
        Lobes::try_each(|lobe| share_of_lobe(fibre, lobe, theta, &kernel, tolerance)).map(|l| l.to_array())
    };
    let (forward, backward) = (shares(AzimuthShare::Forward)?, shares(AzimuthShare::Backward)?);
    Ok(Averages::of_lobes(fibre, &forward, &backward))
}

/// What a lobe (p >= 2: TRT) scatters into the kernel's share of azimuths.
fn share_of_lobe(
    fibre: &Fibre,
    lobe: Lobe,
    theta: f64,
    kernel: &impl Kernel,
    tolerance: f64,
) -> Result<Rgb, OpticsError> {
    let (alpha, v) = tilt_and_variance(fibre, lobe.p());
    let ln_weight = |theta_o: f64| ln_m_p(v, theta_o, theta - 2.0 * alpha);
    let inner = |theta_o: f64| {
        let section = CrossSection::new(fibre.eta, 0.5 * (theta_o - theta));
        lobe_integral(fibre, &section, lobe, kernel, 0.0, 0.5, tolerance).map(|n| n * theta_o.cos())
    };
    settled(
        "average attenuation",
        &integrate_theta(ln_weight, 1.0 / v, inner, tolerance),
        tolerance,
    )
}

/// N of a lobe against a kernel at azimuth `phi`; TRT holds p = 2, p = 3 and, times the kernel's `mean`, all above.
fn lobe_integral(
    fibre: &Fibre,
    section: &CrossSection,
    lobe: Lobe,
    kernel: &impl Kernel,
    phi: f64,
    mean: f64,
    tolerance: f64,
) -> Rgb {
    let inside = Tolerance {
        relative: INNER * tolerance,
        absolute: 1e-13,
    };
    let order = |p: u32| section.integrate(p, &fibre.sigma_a, kernel, phi, inside).value;
    if lobe != Lobe::Trt {
        return order(lobe.p());
    }
    let above = section
        .integrate_tail(DRAWN_ORDERS, &fibre.sigma_a, INNER * tolerance)
        .value;
    let (p2, p3) = (order(2), order(3));
    std::array::from_fn(|c| p2[c] + p3[c] + mean * above[c])
}

/// Light that arrives scattered forward, as [`super::global_scattering`] has it (Xu 2011, Eq 27), per lobe with all orders: the density
/// over solid angle, g(theta_i) s_f(phi_i) / cos(theta_j), times S_p, without a cosine.
///
/// # Errors
/// As [`n_p`], and theta_j at a pole.
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
    let spread = sigma_f / SQRT_2;
    let kernel = DetectedHalf::circle(detector_width(fibre));
    Lobes::try_each(|lobe| {
        let (alpha, v) = tilt_and_variance(fibre, lobe.p());
        let ln_weight = |theta_i: f64| {
            ln_m_p(v, theta_i, view.theta - 2.0 * alpha) + ln_normal(theta_i, light.theta, spread)
        };
        let inner = |theta_i: f64| {
            let section = CrossSection::new(fibre.eta, 0.5 * (view.theta - theta_i));
            let n = lobe_integral(
                fibre,
                &section,
                lobe,
                &kernel,
                view.phi - light.phi,
                0.5 / PI,
                tolerance,
            );
            n.map(|n| n * theta_i.cos() / light.theta.cos())
        };
        let precision = 1.0 / v + 1.0 / (spread * spread);
        settled(
            "global scattering",
            &integrate_theta(ln_weight, precision, inner, tolerance),
            tolerance,
        )
    })
}

/// The cone of d'Eon 2011, Appendix A, before its azimuth is integrated in closed form: the spherical Gaussian of variance `v`
/// between two directions, normalised over the sphere. For checking [`m_p`].
pub fn spherical_gaussian(v: f64, theta_i: f64, theta_r: f64, phi: f64) -> f64 {
    // Light at -theta_i makes the specular cone.
    let cosine = theta_i.cos() * theta_r.cos() * phi.cos() - theta_i.sin() * theta_r.sin();
    ((cosine - 1.0) / v).exp() / (2.0 * PI * v * -(-2.0 / v).exp_m1())
}
