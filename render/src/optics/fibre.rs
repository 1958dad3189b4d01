//! What the reference is asked about, and the door that refuses what has no answer.

use std::f64::consts::{FRAC_PI_2, PI};

use thiserror::Error;

/// One value per colour channel, linear Rec.709.
pub type Rgb = [f64; 3];

/// Why the reference gives no number.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum OpticsError {
    /// A value outside the range in which the model is defined.
    #[error("`{field}` is {value}; it must be {requirement}")]
    Refused {
        /// Name of the field, as in the probe's JSON where it has one.
        field: &'static str,
        /// The value that came in.
        value: f64,
        /// What would have been accepted.
        requirement: &'static str,
    },
    /// An integral that did not settle.
    #[error(
        "the integral of {what} reached a relative error of {reached:.1e}, not the {wanted:.1e} asked for; \
         ask for a looser tolerance"
    )]
    NotConverged {
        /// Which integral.
        what: &'static str,
        /// Estimated relative error reached.
        reached: f64,
        /// Relative error asked for.
        wanted: f64,
    },
}

/// Passes `value` on when it is finite and `accepted`, else refuses it by its name.
fn demand(
    field: &'static str,
    value: f64,
    accepted: bool,
    requirement: &'static str,
) -> Result<(), OpticsError> {
    if value.is_finite() && accepted {
        return Ok(());
    }
    Err(OpticsError::Refused {
        field,
        value,
        requirement,
    })
}

/// Refuses tolerances that double precision can not reach or that mean nothing.
pub(super) fn check_tolerance(tolerance: f64) -> Result<(), OpticsError> {
    demand(
        "tolerance",
        tolerance,
        (1e-12..=0.5).contains(&tolerance),
        "between 1e-12 and 0.5",
    )
}

/// Refuses widths of Gaussians that are not positive or that no quadrature resolves.
pub(super) fn check_width(field: &'static str, width: f64) -> Result<(), OpticsError> {
    demand(
        field,
        width,
        (1e-4..=1e4).contains(&width),
        "between 1e-4 and 1e4",
    )
}

/// Refuses inclinations beyond the poles.
pub(super) fn check_inclination(field: &'static str, theta: f64) -> Result<(), OpticsError> {
    demand(
        field,
        theta,
        theta.abs() <= FRAC_PI_2 + 1e-12,
        "between -pi/2 and pi/2",
    )
}

/// A path through the fibre: p = 0 reflects, p = 1 passes, p >= 2 has p - 1 internal reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lobe {
    /// Reflection, p = 0.
    R,
    /// Transmission, p = 1.
    Tt,
    /// One internal reflection, p = 2.
    Trt,
}

impl Lobe {
    /// The three lobes of Marschner 2003 in the order of p.
    pub const ALL: [Self; 3] = [Self::R, Self::Tt, Self::Trt];

    /// Number of path segments inside the fibre.
    pub fn p(self) -> u32 {
        self as u32
    }
}

/// One value per lobe and colour channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes {
    /// Reflection.
    pub r: Rgb,
    /// Transmission.
    pub tt: Rgb,
    /// One internal reflection.
    pub trt: Rgb,
}

impl Lobes {
    /// Asks `of` for each lobe in turn.
    pub(super) fn try_each(
        mut of: impl FnMut(Lobe) -> Result<Rgb, OpticsError>,
    ) -> Result<Self, OpticsError> {
        Ok(Self {
            r: of(Lobe::R)?,
            tt: of(Lobe::Tt)?,
            trt: of(Lobe::Trt)?,
        })
    }

    /// Sum of the three lobes per channel.
    pub fn sum(&self) -> Rgb {
        std::array::from_fn(|c| self.r[c] + self.tt[c] + self.trt[c])
    }

    /// The lobes in the order R, TT, TRT.
    pub fn to_array(&self) -> [Rgb; 3] {
        [self.r, self.tt, self.trt]
    }
}

/// A direction in the fibre frame, away from the fibre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Inclination to the normal plane, radians, in [-pi/2, pi/2].
    pub theta: f64,
    /// Azimuth around the tangent, radians.
    pub phi: f64,
}

impl Direction {
    /// Refuses what is no direction; `fields` names theta and phi in the message.
    pub fn check(&self, fields: [&'static str; 2]) -> Result<(), OpticsError> {
        check_inclination(fields[0], self.theta)?;
        demand(
            fields[1],
            self.phi,
            self.phi.abs() <= 1e3 * PI,
            "an angle in radians within 1000 pi",
        )
    }
}

/// A spherical radial basis function light of peak 1: G = exp(2 (w . w_j - 1) / lambda_j^2) (Xu 2011, Table 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SrbfLight {
    /// Centre w_j in the fibre frame.
    pub centre: Direction,
    /// 2 / lambda_j^2; zero is the uniform environment, G = 1.
    pub(super) sharpness: f64,
}

impl SrbfLight {
    /// The light around `centre` with bandwidth lambda_j > 0.
    ///
    /// # Errors
    /// A centre that is no direction, a bandwidth outside [1e-4, 1e4].
    pub fn new(centre: Direction, lambda_j: f64) -> Result<Self, OpticsError> {
        centre.check(["theta_j", "phi_j"])?;
        check_width("lambda_j", lambda_j)?;
        Ok(Self {
            centre,
            sharpness: 2.0 / (lambda_j * lambda_j),
        })
    }

    /// The uniform environment of radiance one, G = 1.
    pub fn uniform() -> Self {
        Self {
            centre: Direction { theta: 0.0, phi: 0.0 },
            sharpness: 0.0,
        }
    }

    /// The longitudinal factor g^c(theta_i; theta_j, lambda_j) of Xu 2011, Eq 11, as its logarithm.
    pub(super) fn ln_longitudinal(&self, theta_i: f64) -> f64 {
        let s = (0.5 * (theta_i - self.centre.theta)).sin();
        -2.0 * self.sharpness * s * s
    }

    /// Sharpness 2 / lambda'^2 of the azimuthal factor, lambda' = lambda / sqrt(cos theta_i cos theta_j) (Xu 2011, Eq 11).
    pub(super) fn azimuthal_sharpness(&self, theta_i: f64) -> f64 {
        self.sharpness * (theta_i.cos() * self.centre.theta.cos()).max(0.0)
    }
}

/// One fibre: what Marschner 2003 and Xu 2011 scatter light with. All angles in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibre {
    /// Index of refraction relative to the surrounding; below one the fibre reflects totally beyond its critical angle.
    pub eta: f64,
    /// Eccentricity a of the cross-section, 1 = circular (Xu 2011, Eq 24).
    pub eccentricity: f64,
    /// Absorption per fibre radius.
    pub sigma_a: Rgb,
    /// Longitudinal shifts of R, TT, TRT.
    pub alpha: [f64; 3],
    /// Standard deviations of R, TT, TRT in theta_h; Xu's bandwidths are sqrt(2) times these.
    pub beta: [f64; 3],
    /// Bandwidth w_c of the circular Gaussian that smooths TRT; the standard deviation is w_c / sqrt(2).
    pub azimuthal_width: f64,
}

impl Fibre {
    /// Refuses values for which the model has no meaning or no reference quadrature.
    ///
    /// # Errors
    /// The first field that is not finite or out of range, with the range.
    pub fn check(&self) -> Result<(), OpticsError> {
        demand(
            "eta",
            self.eta,
            self.eta > 0.0 && self.eta <= 1e3,
            "above 0 and at most 1000",
        )?;
        let a = self.eccentricity;
        demand("eccentricity", a, (0.1..=10.0).contains(&a), "between 0.1 and 10")?;
        let (low, high) = self.eta_star_range();
        demand(
            "eccentricity",
            a,
            low > 0.0 && high > 0.0,
            "such that the effective index of Xu 2011, Eq 24 stays above 0: nearer to 1 for this eta",
        )?;
        for (field, sigma_a) in ["sigma_a[0]", "sigma_a[1]", "sigma_a[2]"]
            .into_iter()
            .zip(self.sigma_a)
        {
            demand(field, sigma_a, sigma_a >= 0.0, "finite and at least 0")?;
        }
        for (field, alpha) in ["alpha R", "alpha TT", "alpha TRT"].into_iter().zip(self.alpha) {
            demand(
                field,
                alpha,
                alpha.abs() <= FRAC_PI_2,
                "between -pi/2 and pi/2 (90 degrees)",
            )?;
        }
        for (field, beta) in ["beta R", "beta TT", "beta TRT"].into_iter().zip(self.beta) {
            demand(
                field,
                beta,
                (1e-4..=10.0).contains(&beta),
                "between 1e-4 and 10 radians",
            )?;
        }
        check_width("azimuthal_width", self.azimuthal_width)
    }

    /// The same fibre with a circular cross-section.
    pub fn circular(self) -> Self {
        Self {
            eccentricity: 1.0,
            ..self
        }
    }

    /// The indices along the two axes of the ellipse, eta*_1 and eta*_2 (Xu 2011, Eq 24).
    fn eta_star_range(&self) -> (f64, f64) {
        let a2 = self.eccentricity * self.eccentricity;
        let along = |a2: f64| 2.0 * (self.eta - 1.0) * a2 - self.eta + 2.0;
        (along(a2), along(1.0 / a2))
    }

    /// Effective index eta*(phi_h) of the elliptic cross-section (Xu 2011, Eq 24), from phi_o + phi_i = 2 phi_h.
    pub fn eta_star(&self, two_phi_h: f64) -> f64 {
        let (eta_1, eta_2) = self.eta_star_range();
        0.5 * ((eta_1 + eta_2) + two_phi_h.cos() * (eta_1 - eta_2))
    }
}
