//! The azimuthal factor N: paths through the cross-section, integrated over the offset across the fibre.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::circular::Kernel;
use super::fibre::Rgb;
use super::fresnel::{fresnel, transmission};
use super::quadrature::{Estimate, Tolerance, integrate};

/// Widths around a mark of a kernel at which the first panels end.
const PANEL_WIDTHS: f64 = 6.0;
/// Kernels wider than this are met by several nodes of any panel and need none of their own.
const WIDE: f64 = 0.05;

/// The cross-section of a fibre at one difference angle: everything about a path that does not depend on its offset.
#[derive(Clone, Copy, Debug)]
pub struct CrossSection {
    eta: f64,
    cos_theta_d: f64,
    /// eta'^2 - 1, exact near eta' = 1.
    eta_prime_excess: f64,
    cos_theta_t: f64,
}

/// Where one path leaves.
#[derive(Clone, Copy, Debug)]
struct Path {
    /// Exit azimuth Phi(p, gamma) for positive offset; the mirrored offset leaves at the negative (modulo 2 pi).
    phi: f64,
    /// Its derivative by gamma.
    dphi_dgamma: f64,
}

impl CrossSection {
    /// At relative index `eta` and difference angle theta_d = (theta_o - theta_i) / 2, radians.
    pub fn new(eta: f64, theta_d: f64) -> Self {
        // At a pole eta' is infinite; 1e-12 stands for it and keeps every quotient finite.
        let cos_theta_d = theta_d.cos().max(1e-12);
        let excess = (eta - 1.0) * (eta + 1.0);
        Self {
            eta,
            cos_theta_d,
            eta_prime_excess: excess / (cos_theta_d * cos_theta_d),
            cos_theta_t: (excess + cos_theta_d * cos_theta_d).max(0.0).sqrt() / eta,
        }
    }

    /// eta'^2 of Xu 2011, Table 1 (the Bravais index squared); not positive where no light enters.
    fn eta_prime_squared(&self) -> f64 {
        1.0 + self.eta_prime_excess
    }

    /// The largest gamma at which light enters: pi/2, or the critical angle of an optically thinner fibre.
    pub(super) fn gamma_max(&self) -> f64 {
        if self.eta_prime_excess >= 0.0 {
            return FRAC_PI_2;
        }
        self.eta_prime_squared().max(0.0).sqrt().asin()
    }

    /// Exit azimuth of the path of order p that enters at gamma, h = sin gamma: Xu 2011, Eq 8.
    fn path(&self, p: u32, gamma: f64) -> Path {
        let order = f64::from(p);
        if p == 0 {
            return Path {
                phi: -2.0 * gamma,
                dphi_dgamma: -2.0,
            };
        }
        let (h, cos_gamma) = gamma.sin_cos();
        // eta' cos gamma_t, from cosines alone so that grazing paths keep their digits.
        let eta_cos_t = (self.eta_prime_excess + cos_gamma * cos_gamma).max(0.0).sqrt();
        let gamma_t = h.atan2(eta_cos_t);
        Path {
            phi: order * (2.0 * gamma_t + PI) - 2.0 * gamma,
            dphi_dgamma: 2.0 * order * cos_gamma / eta_cos_t - 2.0,
        }
    }

    /// Attenuation A(p, h) per channel: Xu 2011, Eq 10, with T^p along the true chords and Fresnel at the 3D angle.
    pub fn attenuation(&self, p: u32, gamma: f64, sigma_a: &Rgb) -> Rgb {
        let (surface, chords) = self.surface_and_chords(p, gamma);
        sigma_a.map(|sigma| surface * (-sigma * chords).exp())
    }

    /// What the surface leaves of the path of order p that enters at gamma, and the length inside, in fibre radii.
    pub(super) fn surface_and_chords(&self, p: u32, gamma: f64) -> (f64, f64) {
        let cos_gamma = gamma.cos();
        let cos_i = self.cos_theta_d * cos_gamma;
        let f = fresnel(self.eta, cos_i);
        if p == 0 {
            return (f, 0.0);
        }
        let surface = transmission(self.eta, cos_i).powi(2) * f.powi(p as i32 - 1);
        if surface == 0.0 {
            return (0.0, 0.0);
        }
        let cos_gamma_t =
            ((self.eta_prime_excess + cos_gamma * cos_gamma).max(0.0) / self.eta_prime_squared()).sqrt();
        (surface, 2.0 * f64::from(p) * cos_gamma_t / self.cos_theta_t)
    }

    /// The gamma in (0, gamma_max) where the exit azimuth turns back: the caustic, for 1 < eta' < p.
    pub(super) fn caustic(&self, p: u32) -> Option<f64> {
        let p2 = f64::from(p * p);
        let h2 = (p2 - self.eta_prime_squared()) / (p2 - 1.0);
        (p >= 2 && h2 > 0.0 && h2 < 1.0).then(|| h2.sqrt().asin())
    }

    /// Every gamma in [0, gamma_max] whose path of order p leaves at azimuth `phi` (modulo 2 pi), by safeguarded Newton steps.
    pub fn preimages(&self, p: u32, phi: f64) -> Vec<f64> {
        let end = if p == 0 { FRAC_PI_2 } else { self.gamma_max() };
        let pieces = match self.caustic(p) {
            Some(turn) if turn < end => vec![0.0, turn, end],
            _ => vec![0.0, end],
        };
        let mut found = Vec::new();
        for piece in pieces.windows(2) {
            let (from, to) = (self.path(p, piece[0]).phi, self.path(p, piece[1]).phi);
            let (low, high) = (from.min(to), from.max(to));
            let mut target = phi + TAU * ((low - phi) / TAU).ceil();
            while target <= high {
                found.push(self.solve(p, piece[0], piece[1], target));
                target += TAU;
            }
        }
        found
    }

    /// The gamma in [low, high], where Phi is monotone, at which Phi = target.
    fn solve(&self, p: u32, mut low: f64, mut high: f64, target: f64) -> f64 {
        let rising = self.path(p, high).phi > self.path(p, low).phi;
        let mut gamma = 0.5 * (low + high);
        for _ in 0..80 {
            let path = self.path(p, gamma);
            let off = path.phi - target;
            if off == 0.0 || high - low < 1e-15 {
                break;
            }
            if (off > 0.0) == rising {
                high = gamma;
            } else {
                low = gamma;
            }
            let newton = gamma - off / path.dphi_dgamma;
            let next = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if (next - gamma).abs() < 1e-15 {
                break;
            }
            gamma = next;
        }
        gamma
    }

    /// Exit azimuth of the path of order p that enters at gamma, radians.
    pub(super) fn exit_azimuth(&self, p: u32, gamma: f64) -> f64 {
        self.path(p, gamma).phi
    }

    /// Integral over the offset of A(p, h) / 2 times the kernel at phi - Phi(p, h): what N_p becomes once it has been
    /// integrated against the kernel over the azimuth (d'Eon 2011, Eq 10, with any kernel in place of D_p).
    ///
    /// `tolerance` holds per channel; a bare number is relative.
    pub fn integrate(
        &self,
        p: u32,
        sigma_a: &Rgb,
        kernel: &impl Kernel,
        phi: f64,
        tolerance: impl Into<Tolerance>,
    ) -> Estimate<3> {
        let end = if p == 0 { FRAC_PI_2 } else { self.gamma_max() };
        let integrand = |gamma: f64| {
            let phi_out = self.path(p, gamma).phi;
            let seen = 0.5 * gamma.cos() * (kernel.value(phi - phi_out) + kernel.value(phi + phi_out));
            self.attenuation(p, gamma, sigma_a).map(|a| a * seen)
        };
        integrate(integrand, 0.0, end, &self.breaks(p, kernel, phi, end), tolerance)
    }

    /// Integral over the offset of (A_p + A_(p+1) + ...) / 2: the energy of order p and all higher ones as a geometric series
    /// with ratio f T, p >= 1.
    pub(super) fn integrate_tail(&self, p: u32, sigma_a: &Rgb, tolerance: f64) -> Estimate<3> {
        let integrand = |gamma: f64| {
            let cos_gamma = gamma.cos();
            let (first, next) = (
                self.attenuation(p, gamma, sigma_a),
                self.attenuation(p + 1, gamma, sigma_a),
            );
            std::array::from_fn(|c| {
                let kept = if first[c] > 0.0 { next[c] / first[c] } else { 0.0 };
                if kept < 1.0 {
                    first[c] * cos_gamma / (1.0 - kept)
                } else {
                    0.0
                }
            })
        };
        integrate(integrand, 0.0, self.gamma_max(), &[], tolerance)
    }

    /// Where panels of [`CrossSection::integrate`] end: caustic, critical angle, turns of high orders, marks of the kernel.
    fn breaks(&self, p: u32, kernel: &impl Kernel, phi: f64, end: f64) -> Vec<f64> {
        let mut breaks: Vec<f64> = self.caustic(p).into_iter().collect();
        breaks.push(self.gamma_max());
        breaks.extend((1..p.max(2)).map(|k| end * f64::from(k) / f64::from(p.max(2))));
        let width = kernel.width();
        if width >= WIDE {
            return breaks;
        }
        let reach = PANEL_WIDTHS * width;
        for mark in kernel.marks() {
            for offset in [-reach, 0.0, reach] {
                for mark in [mark + offset, -mark + offset] {
                    breaks.extend(self.preimages(p, phi - mark));
                    breaks.extend(self.preimages(p, mark - phi));
                }
                if width == 0.0 {
                    break;
                }
            }
        }
        breaks
    }

    /// N_p(phi) of a perfectly smooth fibre: Xu 2011, Eq 9, summed over the paths found numerically. Infinite at caustics.
    pub fn n_smooth(&self, p: u32, sigma_a: &Rgb, phi: f64) -> Rgb {
        let mut n = [0.0; 3];
        // Negative offsets leave at the mirrored azimuth; the central path is its own mirror image and counts once.
        let mirrored = self.preimages(p, -phi).into_iter().filter(|gamma| *gamma > 1e-12);
        for gamma in self.preimages(p, phi).into_iter().chain(mirrored) {
            let dphi_dh = self.path(p, gamma).dphi_dgamma.abs() / gamma.cos();
            let a = self.attenuation(p, gamma, sigma_a);
            for c in 0..3 {
                n[c] += 0.5 * a[c] / dphi_dh;
            }
        }
        n
    }
}
