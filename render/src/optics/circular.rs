//! Functions of the azimuth that N is integrated against: lights, smoothing, detectors, half circles.
//!
//! All are even and of period 2 pi. A circular Gaussian g^c(x; lambda) = exp(2 (cos x - 1) / lambda^2) (Xu 2011, Table 1) is
//! held by its sharpness 2 / lambda^2.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::bessel::i0e;

/// Beyond this many standard deviations a Gaussian is below 1e-31 of its peak.
const REACH: f64 = 12.0;

/// An even function of the azimuth with period 2 pi.
pub trait Kernel {
    /// Its value at `x` radians.
    fn value(&self, x: f64) -> f64;

    /// Where it peaks, jumps or has a kink: places in [0, pi].
    fn marks(&self) -> &[f64];

    /// How far around each mark it varies, radians; zero for jumps and kinks.
    fn width(&self) -> f64;
}

/// Sharpness of the circular Gaussian of bandwidth `lambda`.
pub fn sharpness(lambda: f64) -> f64 {
    2.0 / (lambda * lambda)
}

/// The angle in (-pi, pi] that `x` stands for.
fn wrap(x: f64) -> f64 {
    x - TAU * (x / TAU).round()
}

/// g^c itself, of peak `scale`.
#[derive(Clone, Copy, Debug)]
pub struct CircularGaussian {
    sharpness: f64,
    scale: f64,
}

impl CircularGaussian {
    /// Peak one.
    pub fn peak_one(sharpness: f64) -> Self {
        Self {
            sharpness,
            scale: 1.0,
        }
    }

    /// Integral one over the circle.
    pub fn normalised(sharpness: f64) -> Self {
        Self {
            sharpness,
            scale: 1.0 / (TAU * i0e(sharpness)),
        }
    }
}

/// exp(sharpness (cos x - 1)), without cancellation at small x.
fn circular_gaussian(sharpness: f64, x: f64) -> f64 {
    let s = (0.5 * x).sin();
    (-2.0 * sharpness * s * s).exp()
}

impl Kernel for CircularGaussian {
    fn value(&self, x: f64) -> f64 {
        self.scale * circular_gaussian(self.sharpness, x)
    }

    fn marks(&self) -> &[f64] {
        &[0.0]
    }

    fn width(&self) -> f64 {
        self.sharpness.recip().sqrt()
    }
}

/// A light g^c of peak one, seen through a normalised circular Gaussian.
///
/// The product of two circular Gaussians is one again, of sharpness R = |A + B exp(i x)|, so the convolution is
/// exp(R - A - B) I0e(R) / I0e(B); R - A - B = -4 A B sin^2(x/2) / (R + A + B) keeps its digits.
#[derive(Clone, Copy, Debug)]
pub struct SmoothedLight {
    light: f64,
    smoothing: f64,
    scale: f64,
}

impl SmoothedLight {
    /// A light of sharpness `light` through a smoothing of sharpness `smoothing`.
    pub fn new(light: f64, smoothing: f64) -> Self {
        Self {
            light,
            smoothing,
            scale: 1.0 / i0e(smoothing),
        }
    }
}

impl Kernel for SmoothedLight {
    fn value(&self, x: f64) -> f64 {
        let (a, b) = (self.light, self.smoothing);
        let s = (0.5 * x).sin();
        let ab4s2 = 4.0 * a * b * s * s;
        let r = ((a + b) * (a + b) - ab4s2).max(0.0).sqrt();
        self.scale * i0e(r) * (-ab4s2 / (r + a + b)).exp()
    }

    fn marks(&self) -> &[f64] {
        &[0.0]
    }

    fn width(&self) -> f64 {
        (self.light.recip() + self.smoothing.recip()).sqrt()
    }
}

/// 1/pi on the half circle |x| < pi/2, else zero: Xu 2011, Eq 28.
#[derive(Clone, Copy, Debug)]
pub struct HalfCircle;

impl Kernel for HalfCircle {
    fn value(&self, x: f64) -> f64 {
        if wrap(x).abs() < FRAC_PI_2 {
            PI.recip()
        } else {
            0.0
        }
    }

    fn marks(&self) -> &[f64] {
        &[FRAC_PI_2]
    }

    fn width(&self) -> f64 {
        0.0
    }
}

/// [`HalfCircle`] seen through a normalised circular Gaussian.
#[derive(Clone, Copy, Debug)]
pub struct SmoothedHalfCircle {
    smoothing: CircularGaussian,
}

impl SmoothedHalfCircle {
    /// Through a smoothing of the given sharpness.
    pub fn new(smoothing: f64) -> Self {
        Self {
            smoothing: CircularGaussian::normalised(smoothing),
        }
    }

    /// Integral of the smoothing over [0, x] for x in [0, pi]: Gauss-Legendre panels of one standard deviation.
    fn cumulative(&self, x: f64) -> f64 {
        // Five points a panel of one standard deviation leave 1e-11.
        const NODES: [f64; 3] = [
            0.0,
            0.538469310105683091036314420700208,
            0.906179845938663992797626878299393,
        ];
        const WEIGHTS: [f64; 3] = [
            0.568888888888888888888888888888889,
            0.478628670499366468041291514835638,
            0.236926885056189087514264040719917,
        ];
        let width = self.smoothing.width();
        if x > REACH * width {
            return 0.5;
        }
        let panels = (x / (0.75 * width)).ceil().max(2.0);
        let half = 0.5 * x / panels;
        let mut sum = 0.0;
        let mut centre = half;
        while centre < x {
            sum += WEIGHTS[0] * self.smoothing.value(centre);
            for k in 1..3 {
                let step = half * NODES[k];
                sum +=
                    WEIGHTS[k] * (self.smoothing.value(centre - step) + self.smoothing.value(centre + step));
            }
            centre += 2.0 * half;
        }
        sum * half
    }
}

impl Kernel for SmoothedHalfCircle {
    fn value(&self, x: f64) -> f64 {
        // The half circle ends at x - pi/2 and x + pi/2; beyond pi the cumulative integral goes round.
        let x = wrap(x).abs();
        let near = x - FRAC_PI_2;
        let signed = if near < 0.0 {
            -self.cumulative(-near)
        } else {
            self.cumulative(near)
        };
        let far = x + FRAC_PI_2;
        let beyond = if far > PI {
            1.0 - self.cumulative(TAU - far)
        } else {
            self.cumulative(far)
        };
        (beyond - signed) / PI
    }

    fn marks(&self) -> &[f64] {
        &[FRAC_PI_2]
    }

    fn width(&self) -> f64 {
        self.smoothing.width()
    }
}

/// Share of a half circle that is seen forward, |x| / pi, or backward, 1 - |x| / pi: Eq 32 of Xu 2011 after both azimuths of
/// incidence and exit are averaged. (Section 4.3.2 prints 2 * integral of phi N for the forward share; with phi = 0 the
/// retroreflected azimuth that is right, while the limits printed in Eq 33 pick the backward half.)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AzimuthShare {
    /// |x| / pi.
    Forward,
    /// 1 - |x| / pi.
    Backward,
}

impl Kernel for AzimuthShare {
    fn value(&self, x: f64) -> f64 {
        let forward = wrap(x).abs() / PI;
        match self {
            Self::Forward => forward,
            Self::Backward => 1.0 - forward,
        }
    }

    fn marks(&self) -> &[f64] {
        &[0.0, PI]
    }

    fn width(&self) -> f64 {
        0.0
    }
}

/// The constant one: integrates N to the energy of its lobe.
#[derive(Clone, Copy, Debug)]
pub struct Unit;

impl Kernel for Unit {
    fn value(&self, _x: f64) -> f64 {
        1.0
    }

    fn marks(&self) -> &[f64] {
        &[]
    }

    fn width(&self) -> f64 {
        0.0
    }
}

/// The Gaussian detector of d'Eon 2011, Eq 11: a normal distribution of standard deviation `beta` wrapped around the circle.
#[derive(Clone, Copy, Debug)]
pub struct GaussianDetector {
    beta: f64,
}

impl GaussianDetector {
    /// Standard deviation in azimuth, radians, > 0.
    pub fn new(beta: f64) -> Self {
        Self { beta }
    }
}

impl Kernel for GaussianDetector {
    fn value(&self, x: f64) -> f64 {
        let x = wrap(x).abs();
        let turns = ((REACH * self.beta - x) / TAU).floor().max(0.0) as i32;
        let peak = 1.0 / (TAU.sqrt() * self.beta);
        (-turns - 1..=turns + 1)
            .map(|k| {
                let z = (x + TAU * f64::from(k)) / self.beta;
                peak * (-0.5 * z * z).exp()
            })
            .sum()
    }

    fn marks(&self) -> &[f64] {
        &[0.0]
    }

    fn width(&self) -> f64 {
        self.beta
    }
}

/// A light g^c of peak one, seen through a [`GaussianDetector`]; no closed form: the trapezoidal rule, which converges
/// exponentially for Gaussians, with steps of 0.7 standard deviations of their product.
#[derive(Clone, Copy, Debug)]
pub struct DetectedLight {
    light: f64,
    beta: f64,
}

impl DetectedLight {
    /// A light of sharpness `light` through a detector of standard deviation `beta`.
    pub fn new(light: f64, beta: f64) -> Self {
        Self { light, beta }
    }
}

impl Kernel for DetectedLight {
    fn value(&self, x: f64) -> f64 {
        let precision = 1.0 / (self.beta * self.beta);
        let step = 0.7 / (self.light + precision).sqrt();
        let reach = REACH * self.beta;
        let lit = REACH / self.light.sqrt();
        let weight = step / (TAU.sqrt() * self.beta);
        let window = |from: f64, to: f64| -> f64 {
            let first = (from / step).ceil();
            let count = ((to / step).floor() - first) as i64;
            (0..=count)
                .map(|k| {
                    let t = (first + k as f64) * step;
                    let s = (0.5 * t).sin();
                    (-2.0 * self.light * s * s - 0.5 * precision * (t - x) * (t - x)).exp()
                })
                .sum()
        };

        // A wide light is summed over the whole reach of the detector, a narrow one turn by turn.
        let x = wrap(x);
        if lit >= PI {
            return weight * window(x - reach, x + reach);
        }
        let (first, last) = (
            ((x - reach - lit) / TAU).ceil() as i64,
            ((x + reach + lit) / TAU).floor() as i64,
        );
        (first..=last)
            .map(|turn| {
                let centre = TAU * turn as f64;
                window((x - reach).max(centre - lit), (x + reach).min(centre + lit))
            })
            .sum::<f64>()
            * weight
    }

    fn marks(&self) -> &[f64] {
        &[0.0]
    }

    fn width(&self) -> f64 {
        (self.light.recip() + self.beta * self.beta).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::quadrature::integrate;

    /// Convolution of `light` with `smoothing` at x, straight from its definition.
    fn convolved(light: &impl Kernel, smoothing: &impl Kernel, x: f64, breaks: &[f64]) -> f64 {
        let breaks: Vec<f64> = breaks.iter().chain(&[0.0, x]).copied().collect();
        integrate(
            |t| [light.value(t) * smoothing.value(x - t)],
            -PI,
            PI,
            &breaks,
            1e-11,
        )
        .value[0]
    }

    #[test]
    fn closed_convolutions_are_the_integrals_they_stand_for() {
        for (lambda, w) in [(0.3, 0.2), (0.05, 0.4), (2.0, 0.1), (0.9, 1.5)] {
            let (light, smoothing) = (sharpness(lambda), sharpness(w));
            for x in [-3.1, -1.0, 0.0, 0.2, 1.55, 2.5] {
                let g = CircularGaussian::peak_one(light);
                let through = CircularGaussian::normalised(smoothing);
                let near = |name: &str, got: f64, wanted: f64| {
                    let off = (got - wanted).abs();
                    assert!(
                        off < 1e-9 * wanted.abs() + 1e-14,
                        "{name} {lambda} {w} {x}: {got} {wanted}"
                    );
                };
                near(
                    "light",
                    SmoothedLight::new(light, smoothing).value(x),
                    convolved(&g, &through, x, &[]),
                );
                let edges = [-FRAC_PI_2, FRAC_PI_2];
                near(
                    "half",
                    SmoothedHalfCircle::new(smoothing).value(x),
                    convolved(&HalfCircle, &through, x, &edges),
                );
                near(
                    "detector",
                    DetectedLight::new(light, w).value(x),
                    convolved(&g, &GaussianDetector::new(w), x, &[]),
                );
            }
        }
    }

    #[test]
    fn normalised_kernels_integrate_to_one() {
        for w in [0.01, 0.3, 1.0, 4.0] {
            let of = |kernel: &dyn Kernel| integrate(|x| [kernel.value(x)], -PI, PI, &[0.0], 1e-11).value[0];
            assert!((of(&CircularGaussian::normalised(sharpness(w))) - 1.0).abs() < 1e-10);
            assert!((of(&GaussianDetector::new(w)) - 1.0).abs() < 1e-10);
            assert!((of(&CircularGaussian::peak_one(sharpness(w))) - 1.0).abs() > 1e-3);
        }
    }
}
