//! Directions drawn from what a fibre scatters, for tracing paths: from the viewer to the light or from the light on.

use std::f64::consts::{FRAC_PI_2, SQRT_2, TAU};

use rand::Rng;

use super::azimuthal::CrossSection;
use super::deon;
use super::fibre::{Fibre, Lobe, Rgb};

/// Least chance of every lobe, relative to what the likeliest sends, where chances are those of another inclination than what is sent.
const LEAST_CHANCE: f64 = 0.02;

/// The same where both are of one inclination: no more than rounding asks for. Weights with a mean of one have a product, over hundreds of
/// fibres, that is all in rare photons.
const LEAST_EXACT: f64 = 1e-9;

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
pub fn sample_marschner(fibre: &Fibre, theta_o: f64, random: &mut impl Rng) -> Option<Sample> {
    let gamma = random.random_range(-1.0_f64..1.0).asin();

    // The lobe's chance is what it sends through this offset around its mean inclination.
    let sent = Lobe::ALL.map(|lobe| {
        let section = CrossSection::new(fibre.eta, theta_o - fibre.alpha[lobe as usize]);
        section.attenuation(lobe.p(), gamma.abs(), &fibre.sigma_a)
    });
    let (index, chance) = choose(&sent, LEAST_CHANCE, random);
    let lobe = Lobe::ALL[index];

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

/// The same for the model of d'Eon 2011 as the shaders draw it: p = 0 to 3 one by one, those above with the cone of p = 4 at every azimuth.
///
/// What each order carries is taken at inclination theta_o, not at each sample's own theta_d: a fibre without absorption neither loses nor gains by
/// however little, which hundreds of fibres would make much. The inclination is drawn from the spherical Gaussian around the cone that M_p
/// is the mean of (d'Eon, Marschner and Hanika 2013, "Importance Sampling for Physically-Based Hair Fiber Models").
pub fn sample_deon(fibre: &Fibre, theta_o: f64, random: &mut impl Rng) -> Sample {
    let gamma = random.random_range(-1.0_f64..1.0).asin();
    let section = CrossSection::new(fibre.eta, theta_o);
    let last = deon::DRAWN_ORDERS;
    let energy = |p: u32| section.attenuation(p, gamma.abs(), &fibre.sigma_a);
    let mut sent: [Rgb; 5] = std::array::from_fn(|p| energy(p as u32));
    // The last one stands for the geometric series from its order on.
    let next = energy(last + 1);
    for (of_last, of_next) in sent[last as usize].iter_mut().zip(next) {
        let ratio = of_next / of_last.max(f64::MIN_POSITIVE);
        *of_last /= 1.0 - ratio.min(1.0 - 1e-9);
    }
    let (index, chance) = choose(&sent, LEAST_EXACT, random);
    let p = index as u32;

    let (alpha, v) = deon::tilt_and_variance(fibre, p);
    let cone = theta_o - 2.0 * alpha;
    let rest = random.random::<f64>();
    let u = 1.0 + v * (rest + (1.0 - rest) * (-2.0 / v).exp()).ln();
    let across = (1.0 - u * u).max(0.0).sqrt() * (TAU * random.random::<f64>()).cos();
    let theta = (across * cone.cos() - u * cone.sin()).clamp(-1.0, 1.0).asin();
    let phi = if p < last {
        let exit = CrossSection::new(fibre.eta, 0.5 * (theta_o - theta)).exit_azimuth(p, gamma.abs());
        exit * gamma.signum() + fibre.azimuthal_width / SQRT_2 * normal(random)
    } else {
        TAU * random.random::<f64>()
    };
    Sample {
        theta,
        phi: phi.rem_euclid(TAU),
        weight: sent[index].map(|a| a / chance),
    }
}

/// One of several paths in proportion to the power that each sends, and its chance; `least` of the likeliest's at least.
fn choose<const N: usize>(sent: &[Rgb; N], least: f64, random: &mut impl Rng) -> (usize, f64) {
    let power = sent.map(|rgb| rgb.iter().sum::<f64>() / 3.0);
    let least = least * power.iter().copied().fold(1e-300, f64::max);
    let chances = power.map(|a| a.max(least));
    let total: f64 = chances.iter().sum();
    let mut rest = random.random_range(0.0..total);
    let index = chances
        .iter()
        .position(|chance| {
            rest -= chance;
            rest < 0.0
        })
        .unwrap_or(N - 1);
    (index, chances[index] / total)
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
    use crate::optics::{Direction, SrbfLight, deon, furnace_radiance, single_scattering};

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
                let Some(s) = sample_marschner(&fibre, theta_o, &mut random) else {
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

    #[test]
    fn samples_of_deon_average_to_the_integral_over_a_light_and_lose_nothing_in_white_hair() {
        const COUNT: u32 = 200_000;
        let at = |theta, phi| Direction { theta, phi };
        for (theta_o, centre, sigma_a) in [
            (0.2, at(-0.3, 2.8), [0.1, 0.3, 0.8]),
            (-0.9, at(0.8, 0.4), [0.02, 0.1, 0.2]),
            (1.1, at(-1.0, 1.5), [0.0; 3]),
        ] {
            let fibre = Fibre { sigma_a, ..brown() };
            let mut random = Pcg64Mcg::seed_from_u64(3);
            let light = SrbfLight::new(centre, 0.8).unwrap();
            let orders =
                deon::single_scattering(&fibre, at(theta_o, 0.0), &light, deon::DRAWN_ORDERS, 1e-4).unwrap();
            let above = deon::remainder(&fibre, at(theta_o, 0.0), &light, deon::DRAWN_ORDERS, 1e-4).unwrap();
            let wanted = above[1] + orders.iter().map(|order| order[1]).sum::<f64>();
            let whole = deon::furnace_radiance(&fibre, theta_o, deon::DRAWN_ORDERS, 1e-4).unwrap()[1];
            let (mut lit, mut all) = (0.0, 0.0);
            for _ in 0..COUNT {
                let s = sample_deon(&fibre, theta_o, &mut random);
                assert!(
                    sigma_a != [0.0; 3] || (s.weight[1] - 1.0).abs() < 1e-6,
                    "{:?}: over many fibres weights multiply",
                    s.weight
                );
                let cosine = centre.theta.sin() * s.theta.sin()
                    + centre.theta.cos() * s.theta.cos() * (centre.phi - s.phi).cos();
                lit += s.weight[1] * (2.0 * (cosine - 1.0) / 0.64).exp();
                all += s.weight[1];
            }
            let (lit, all) = (lit / f64::from(COUNT), all / f64::from(COUNT));
            // Energies at one inclination instead of each theta_d: 2 % off near the equator, 6 % at 63 degrees.
            assert!((lit / wanted - 1.0).abs() < 0.08, "light: {lit} for {wanted}");
            assert!((all / whole - 1.0).abs() < 0.05, "sphere: {all} for {whole}");
            assert!(
                sigma_a != [0.0; 3] || (all - 1.0).abs() < 0.002,
                "white hair sends {all}"
            );
        }
    }
}
