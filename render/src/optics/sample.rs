//! Directions drawn from what a fibre scatters, for path tracing.

use std::f64::consts::{FRAC_PI_2, SQRT_2, TAU};

use rand::Rng;

use super::azimuthal::CrossSection;
use super::fibre::{Fibre, Lobe, Rgb};

/// Least chance of every lobe, relative to what the likeliest sends.
const LEAST_CHANCE: f64 = 0.02;

/// Where light comes from, in the fibre frame with the viewer at azimuth 0, and what it counts.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// Inclination, radians.
    pub theta: f64,
    /// Azimuth towards the viewer's, radians.
    pub phi: f64,
    /// The mean of weight times the radiance from there is the integral of L S cos(theta_i) over the sphere.
    pub weight: Rgb,
}

/// Draws a lobe, an offset h across the fibre, the inclination from M and TRT's azimuth from its circular Gaussian (section 3 of the
/// design; Marschner 2003 with M normalised to one). None where M reaches beyond the poles: that light is lost. The cross-section is
/// circular: eccentricity is not read. `fibre` has passed [`Fibre::check`], |theta_o| <= pi/2.
pub fn sample(fibre: &Fibre, theta_o: f64, random: &mut impl Rng) -> Option<Sample> {
    let gamma = random.random_range(-1.0_f64..1.0).asin();

    // The lobe's chance is what it sends through this offset around its mean inclination.
    let sent = Lobe::ALL.map(|lobe| {
        let section = CrossSection::new(fibre.eta, theta_o - fibre.alpha[lobe as usize]);
        section
            .attenuation(lobe.p(), gamma.abs(), &fibre.sigma_a)
            .iter()
            .sum::<f64>()
            / 3.0
    });
    let least = LEAST_CHANCE * sent.iter().copied().fold(1e-300, f64::max);
    let chances = sent.map(|a| a.max(least));
    let total: f64 = chances.iter().sum();
    let mut rest = random.random_range(0.0..total);
    let lobe = Lobe::ALL
        .into_iter()
        .find(|lobe| {
            rest -= chances[*lobe as usize];
            rest < 0.0
        })
        .unwrap_or(Lobe::Trt);
    let chance = chances[lobe as usize] / total;

    let theta = 2.0 * fibre.alpha[lobe as usize] - theta_o + 2.0 * fibre.beta[lobe as usize] * normal(random);
    if theta.abs() >= FRAC_PI_2 {
        return None;
    }
    let theta_d = 0.5 * (theta_o - theta);
    let section = CrossSection::new(fibre.eta, theta_d);
    let attenuation = section.attenuation(lobe.p(), gamma.abs(), &fibre.sigma_a);
    let mut phi = section.exit_azimuth(lobe.p(), gamma.abs()) * gamma.signum();
    if lobe == Lobe::Trt {
        phi += fibre.azimuthal_width / SQRT_2 * normal(random);
    }
    let scale = (theta.cos() / theta_d.cos()).powi(2) / chance;
    Some(Sample {
        theta,
        phi: phi.rem_euclid(TAU),
        weight: attenuation.map(|a| a * scale),
    })
}

/// A normal deviate (Box and Muller).
fn normal(random: &mut impl Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (TAU * random.random::<f64>()).cos()
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_pcg::Pcg64Mcg;

    use super::*;
    use crate::optics::{Direction, SrbfLight, furnace_radiance, single_scattering};

    fn brown() -> Fibre {
        Fibre {
            eta: 1.55,
            eccentricity: 1.0,
            sigma_a: [0.5, 0.8, 1.4],
            alpha: [-5.0, 2.5, 7.5].map(f64::to_radians),
            beta: [5.657, 4.243, 8.485].map(f64::to_radians),
            azimuthal_width: 0.2,
        }
    }

    #[test]
    fn samples_average_to_the_integral_over_a_light_and_over_the_sphere() {
        const COUNT: u32 = 200_000;
        let fibre = brown();
        for (theta_o, centre) in [
            (
                0.2,
                Direction {
                    theta: -0.3,
                    phi: 2.8,
                },
            ),
            (-0.9, Direction { theta: 0.8, phi: 0.4 }),
        ] {
            let mut random = Pcg64Mcg::seed_from_u64(7);
            let light = SrbfLight::new(centre, 0.8).unwrap();
            let view = Direction {
                theta: theta_o,
                phi: 0.0,
            };
            let wanted = single_scattering(&fibre, view, &light, 1e-4).unwrap().sum();
            let whole: f64 = furnace_radiance(&fibre, theta_o, 1e-4).unwrap()[0];
            let (mut lit, mut all) = (0.0, 0.0);
            for _ in 0..COUNT {
                let Some(s) = sample(&fibre, theta_o, &mut random) else {
                    continue;
                };
                let cosine = centre.theta.sin() * s.theta.sin()
                    + centre.theta.cos() * s.theta.cos() * (centre.phi - s.phi).cos();
                lit += s.weight[0] * (2.0 * (cosine - 1.0) / 0.64).exp();
                all += s.weight[0];
            }
            let (lit, all) = (lit / f64::from(COUNT), all / f64::from(COUNT));
            assert!(
                (lit / wanted[0] - 1.0).abs() < 0.02,
                "light: {lit} for {}",
                wanted[0]
            );
            assert!((all / whole - 1.0).abs() < 0.01, "sphere: {all} for {whole}");
        }
    }
}
