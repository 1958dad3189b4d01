//! The colour that hair is seen in: what a mass of equal fibres sends back in white light from everywhere, and the absorption
//! that makes it a wanted colour.
//!
//! The colour is rho, the cosine-weighted mean over inclinations of the reflectance of a half space of fibres (see
//! [`dual`](super::dual)), per channel a falling function of that channel's absorption alone. Geometry, Fresnel and widths do not depend on
//! absorption: the paths are laid out once, an evaluation is a sum of exponentials, and the inverse is solved to
//! rounding by a bracketing secant method.

use std::f64::consts::{FRAC_PI_2, PI};

use super::azimuthal::CrossSection;
use super::circular::{AzimuthShare, Kernel};
use super::dual::half_space_reflectance;
use super::fibre::{Fibre, Lobe, OpticsError, Rgb};
use super::longitudinal::ln_m;
use super::quadrature::gauss_7_nodes;

/// The largest absorption that is solved for, per fibre radius: what channel dye takes.
pub const MOST_ABSORPTION: f64 = 100.0;
/// Standard deviations of M that are integrated over.
const REACH: f64 = 5.0;
/// Relative precision of the solved colour.
const PRECISION: f64 = 1e-7;

/// A path through the fibre at one pair of inclinations.
#[derive(Clone, Copy, Debug)]
struct InnerPath {
    /// Length inside, in fibre radii.
    chords: f64,
    /// What it adds to a_f and a_b without absorption.
    forward: f64,
    backward: f64,
}

/// One inclination of the light.
#[derive(Clone, Debug)]
struct Inclination {
    /// Share of the mean over inclinations.
    weight: f64,
    /// What R adds to a_f and a_b.
    surface: [f64; 2],
    paths: Vec<InnerPath>,
}

/// Deep hair of one kind of fibre, at any absorption.
#[derive(Clone, Debug)]
pub struct DeepHair {
    inclinations: Vec<Inclination>,
}

/// The absorption for a wanted colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolvedColour {
    /// Absorption per fibre radius.
    pub sigma_a: Rgb,
    /// The colour that it gives.
    pub colour: Rgb,
    /// False where no absorption gives the wanted colour: each channel is then the nearest that one does.
    pub in_gamut: bool,
}

impl DeepHair {
    /// Lays out the paths of `fibre`, whose absorption is not read.
    ///
    /// # Errors
    /// Values that the model refuses.
    pub fn new(fibre: &Fibre) -> Result<Self, OpticsError> {
        fibre.check()?;
        // The mean over theta with weight cos(theta) / 2 is an even mean over sin(theta).
        let sines = [(-1.0, 0.0), (0.0, 1.0)];
        let inclinations = sines
            .into_iter()
            .flat_map(|(from, to)| gauss_7_nodes(from, to))
            .map(|(sine, weight)| Inclination::new(fibre, sine.asin(), 0.5 * weight))
            .collect();
        Ok(Self { inclinations })
    }

    /// Colour of one channel at an absorption per fibre radius.
    pub fn reflectance(&self, sigma_a: f64) -> f64 {
        self.inclinations
            .iter()
            .map(|i| i.weight * i.reflectance(sigma_a))
            .sum()
    }

    /// The colour that hair of this absorption is seen in, linear Rec.709.
    pub fn colour(&self, sigma_a: &Rgb) -> Rgb {
        sigma_a.map(|sigma_a| self.reflectance(sigma_a))
    }

    /// Darkest and lightest value that a channel can have.
    pub fn gamut(&self) -> (f64, f64) {
        (self.reflectance(MOST_ABSORPTION), self.reflectance(0.0))
    }

    /// The absorption whose colour is `wanted`; NaN counts as black.
    pub fn solve(&self, wanted: &Rgb) -> SolvedColour {
        let gamut = self.gamut();
        let sigma_a = wanted.map(|wanted| self.solve_channel(wanted, gamut));
        // Rounding of a colour that came from the gamut's edge does not put it outside.
        let slack = 1.0 + 1e-6;
        let in_gamut = wanted
            .iter()
            .all(|x| (gamut.0 / slack..=gamut.1 * slack).contains(x));
        SolvedColour {
            sigma_a,
            colour: self.colour(&sigma_a),
            in_gamut,
        }
    }

    /// Illinois' method on the logarithms, between no and the most absorption.
    fn solve_channel(&self, wanted: f64, (darkest, lightest): (f64, f64)) -> f64 {
        if wanted >= lightest {
            return 0.0;
        }
        if wanted.is_nan() || wanted <= darkest {
            return MOST_ABSORPTION;
        }
        // x = ln(1 + 100 sigma_a) spreads light and dark hair evenly.
        let absorption = |x: f64| x.exp_m1() / 100.0;
        let off = |x: f64| (self.reflectance(absorption(x)) / wanted).ln();
        let (mut low, mut high) = (0.0, (100.0 * MOST_ABSORPTION).ln_1p());
        let (mut at_low, mut at_high) = ((lightest / wanted).ln(), (darkest / wanted).ln());
        let mut last_side = 0;
        for _ in 0..100 {
            let x = (low * at_high - high * at_low) / (at_high - at_low);
            let y = off(x);
            if y.abs() < PRECISION {
                return absorption(x);
            }
            if y > 0.0 {
                (low, at_low) = (x, y);
                if last_side == 1 {
                    at_high *= 0.5;
                }
                last_side = 1;
            } else {
                (high, at_high) = (x, y);
                if last_side == -1 {
                    at_low *= 0.5;
                }
                last_side = -1;
            }
        }
        absorption(0.5 * (low + high))
    }
}

impl Inclination {
    fn new(fibre: &Fibre, theta: f64, weight: f64) -> Self {
        let mut inclination = Self {
            weight,
            surface: [0.0; 2],
            paths: Vec::new(),
        };
        for lobe in Lobe::ALL {
            let (alpha, beta) = (fibre.alpha[lobe as usize], fibre.beta[lobe as usize]);
            let (mean, reach) = (2.0 * alpha - theta, REACH * 2.0 * beta);
            let panels = [(mean - reach, mean), (mean, mean + reach)]
                .map(|(from, to)| (from.max(-FRAC_PI_2), to.min(FRAC_PI_2)));
            for (theta_o, width) in panels
                .into_iter()
                .filter(|(from, to)| from < to)
                .flat_map(|(from, to)| gauss_7_nodes(from, to))
            {
                // The weight of Eq 32 of Xu 2011, as in `averages::attenuation`.
                let theta_d = 0.5 * (theta_o - theta);
                let compression = theta.cos() * theta_o.cos() / theta_d.cos().powi(2);
                let share = width * ln_m(alpha, beta, theta_o, theta).exp() * compression;
                inclination.add(&CrossSection::new(fibre.eta, theta_d), lobe, share);
            }
        }
        inclination
    }

    /// Adds the paths of one lobe at one pair of inclinations.
    fn add(&mut self, section: &CrossSection, lobe: Lobe, share: f64) {
        let p = lobe.p();
        let end = if p == 0 { FRAC_PI_2 } else { section.gamma_max() };
        // Panels end where the exit azimuth turns back or meets a corner of the shares.
        let mut ends = vec![0.0, end];
        ends.extend(section.caustic(p));
        ends.extend([0.0, PI].into_iter().flat_map(|phi| section.preimages(p, phi)));
        ends.retain(|gamma| (0.0..=end).contains(gamma));
        ends.sort_unstable_by(f64::total_cmp);
        for panel in ends.windows(2).filter(|panel| panel[1] - panel[0] > 1e-9) {
            for (gamma, width) in gauss_7_nodes(panel[0], panel[1]) {
                let (surface, chords) = section.surface_and_chords(p, gamma);
                let energy = share * width * gamma.cos() * surface;
                let phi = section.exit_azimuth(p, gamma);
                let (forward, backward) = (
                    energy * AzimuthShare::Forward.value(phi),
                    energy * AzimuthShare::Backward.value(phi),
                );
                if p == 0 {
                    self.surface[0] += forward;
                    self.surface[1] += backward;
                } else if energy > 0.0 {
                    self.paths.push(InnerPath {
                        chords,
                        forward,
                        backward,
                    });
                }
            }
        }
    }

    fn reflectance(&self, sigma_a: f64) -> f64 {
        let [mut a_f, mut a_b] = self.surface;
        for path in &self.paths {
            let kept = (-sigma_a * path.chords).exp();
            a_f += kept * path.forward;
            a_b += kept * path.backward;
        }
        half_space_reflectance(a_f, a_b)
    }
}
