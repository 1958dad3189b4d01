//! Functions of the azimuth that N is integrated against: lights, smoothing, detectors, half circles.
//!
//! All are even and of period 2 pi. A circular Gaussian g^c(x; lambda) = exp(2 (cos x - 1) / lambda^2) (Xu 2011, Table 1) is
//! held by its sharpness 2 / lambda^2.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::bessel::i0e;
use super::quadrature::gauss_7;

/// Beyond this many standard deviations a Gaussian is below 1e-21 of its peak.
const REACH: f64 = 10.0;

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
#[derive(Clone, Debug)]
pub struct SmoothedHalfCircle {
    smoothing: CircularGaussian,
    /// Ends of panels in [0, pi], rising, and the integral of the smoothing from each to pi.
    tails: Vec<(f64, f64)>,
}

impl SmoothedHalfCircle {
    /// Through a smoothing of the given sharpness.
    pub fn new(sharpness: f64) -> Self {
        let smoothing = CircularGaussian::normalised(sharpness);
        let width = smoothing.width();

        // Panels narrow outwards, so that the integral keeps its relative precision in the far tail.
        let mut ends = vec![0.0];
        let mut end = 0.0;
        while end < PI && smoothing.value(end) > 0.0 {
            end = (end + width / (1.0 + end / (3.0 * width))).min(PI);
            ends.push(end);
        }
        let mut tail = 0.0;
        let mut tails: Vec<(f64, f64)> = vec![(end, 0.0)];
        for panel in ends.windows(2).rev() {
            tail += gauss_7(|t| smoothing.value(t), panel[0], panel[1]);
            tails.push((panel[0], tail));
        }
        tails.reverse();
        Self { smoothing, tails }
    }

    /// Integral of the smoothing over [x, pi] for x in [0, pi].
    fn tail(&self, x: f64) -> f64 {
        let next = self.tails.partition_point(|(end, _)| *end < x);
        self.tails.get(next).map_or(0.0, |(end, tail)| {
            tail + gauss_7(|t| self.smoothing.value(t), x, *end)
        })
    }
}

impl Kernel for SmoothedHalfCircle {
    fn value(&self, x: f64) -> f64 {
        // What lies beyond the two ends of the half circle, [x - pi/2, x + pi/2], or within it where that is less.
        let x = wrap(x).abs();
        if x < FRAC_PI_2 {
            return (1.0 - self.tail(FRAC_PI_2 - x) - self.tail(FRAC_PI_2 + x)) / PI;
        }
        (self.tail(x - FRAC_PI_2) + self.tail(3.0 * FRAC_PI_2 - x)) / PI
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
/// exponentially for Gaussians, with steps of 0.6 standard deviations of their product.
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
        let x = wrap(x);
        let precision = 1.0 / (self.beta * self.beta);
        let step = 0.6 / (self.light + precision).sqrt();
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

/// [`HalfCircle`] or an [`AzimuthShare`] seen through a [`GaussianDetector`], as its cosine series: a constant and the odd harmonics, of
/// which the detector multiplies the m-th by exp(-m^2 beta^2 / 2).
#[derive(Clone, Debug)]
pub struct DetectedHalf {
    mean: f64,
    /// Coefficients of cos x, cos 3x, cos 5x ...
    odd: Vec<f64>,
    beta: f64,
}

impl DetectedHalf {
    /// The half circle through a detector of standard deviation `beta`.
    pub fn circle(beta: f64) -> Self {
        let sign = |m: f64| if m % 4.0 == 1.0 { 1.0 } else { -1.0 };
        Self::new(0.5 / PI, beta, |m| 2.0 * sign(m) / (PI * PI * m))
    }

    /// A share through a detector of standard deviation `beta`.
    pub fn share(share: AzimuthShare, beta: f64) -> Self {
        let sign = match share {
            AzimuthShare::Forward => -1.0,
            AzimuthShare::Backward => 1.0,
        };
        Self::new(0.5, beta, |m| 4.0 * sign / (PI * PI * m * m))
    }

    fn new(mean: f64, beta: f64, coefficient: impl Fn(f64) -> f64) -> Self {
        // Harmonics beyond nine of the detector's own are below 1e-17.
        let count = (0.5 * REACH / beta).clamp(2.0, 5000.0) as u32;
        let odd = (0..count).map(|k| {
            let m = f64::from(2 * k + 1);
            coefficient(m) * (-0.5 * (m * beta).powi(2)).exp()
        });
        Self {
            mean,
            odd: odd.collect(),
            beta,
        }
    }
}

impl Kernel for DetectedHalf {
    fn value(&self, x: f64) -> f64 {
        // cos (m + 2) x = 2 cos 2x cos m x - cos (m - 2) x.
        let twice = 2.0 * (2.0 * x).cos();
        let (mut before, mut now) = (x.cos(), x.cos());
        let mut sum = self.mean;
        for coefficient in &self.odd {
            sum += coefficient * now;
            (before, now) = (now, twice * now - before);
        }
        sum
    }

    fn marks(&self) -> &[f64] {
        &[0.0, FRAC_PI_2, PI]
    }

    fn width(&self) -> f64 {
        self.beta
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
                let detector = GaussianDetector::new(w);
                near(
                    "half through a detector",
                    DetectedHalf::circle(w).value(x),
                    convolved(&HalfCircle, &detector, x, &edges),
                );
                near(
                    "share through a detector",
                    DetectedHalf::share(AzimuthShare::Forward, w).value(x),
                    convolved(&AzimuthShare::Forward, &detector, x, &[]),
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
    fn kernels_are_even_and_periodic() {
        let s = sharpness(0.3);
        let kernels: [&dyn Kernel; 8] = [
            &CircularGaussian::normalised(s),
            &SmoothedLight::new(s, sharpness(0.5)),
            &HalfCircle,
            &SmoothedHalfCircle::new(s),
            &AzimuthShare::Forward,
            &AzimuthShare::Backward,
            &GaussianDetector::new(0.3),
            &DetectedLight::new(s, 0.3),
        ];
        for (index, kernel) in kernels.into_iter().enumerate() {
            for x in [0.1, 1.4, 3.0] {
                let wanted = kernel.value(x);
                for same in [-x, x + TAU, x - 3.0 * TAU, 2.0 * TAU - x] {
                    let off = (kernel.value(same) - wanted).abs();
                    assert!(
                        off <= 1e-12 * wanted.abs() + 1e-25,
                        "kernel {index} at {same}: {off}"
                    );
                }
            }
            let varies = (kernel.value(0.1) - kernel.value(3.0)).abs();
            assert!(varies > 1e-3, "kernel {index} must not be constant");
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
