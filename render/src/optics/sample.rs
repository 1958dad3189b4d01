//! Directions drawn from what a fibre scatters, for tracing paths: from the viewer to the light or from the light on.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

use rand::Rng;

use super::azimuthal::CrossSection;
use super::deon;
use super::fibre::{Fibre, Lobe, Rgb};

/// Least chance of every lobe, relative to what the likeliest sends, where chances are those of another inclination than what is sent.
const LEAST_CHANCE: f64 = 0.02;

/// The same where both are of one inclination: no more than rounding asks for. Weights with a mean of one have a product, over hundreds of
/// fibres, that is all in rare photons.
const LEAST_EXACT: f64 = 1e-9;

/// Ways out that [`sample_deon_onward`] chooses among.
const WAYS: usize = 4;

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
    let sent = deon_energies(|p| section.attenuation(p, gamma.abs(), &fibre.sigma_a));
    let (index, chance) = choose(&sent, LEAST_EXACT, random);
    let p = index as u32;

    let (alpha, v) = deon::tilt_and_variance(fibre, p);
    let theta = -around_cone(theta_o - 2.0 * alpha, v, random);
    Sample {
        theta,
        phi: deon_azimuth(fibre, p, gamma, 0.5 * (theta_o - theta), random),
        weight: sent[index].map(|a| a / chance),
    }
}

/// Where light that comes from inclination `theta_i` goes: [`sample_deon`] the other way around. `theta` and `phi` of the sample are those of the way
/// out, the mean of weight over samples near a direction is the flux there of a flux of one. M is normalised for every inclination of the viewer, not
/// for every one of the light, so that with tilted cuticles fibres that absorb nothing send out more or less than they get, and light from
/// everywhere is what stays as it is.
pub fn sample_deon_onward(fibre: &Fibre, theta_i: f64, random: &mut impl Rng) -> Sample {
    let gamma = random.random_range(-1.0_f64..1.0).asin();
    // Chances are those around the mean way out.
    let sections = fibre
        .alpha
        .map(|alpha| CrossSection::new(fibre.eta, 2.0 * alpha - theta_i));
    let around = deon_energies(|p| sections[p.min(2) as usize].attenuation(p, gamma.abs(), &fibre.sigma_a));
    // One of a few ways out in proportion to what it counts, which then counts as their mean: the less weights differ, the fewer photons of hundreds of
    // fibres are all there is (Talbot 2005, "Importance Resampling for Global Illumination").
    let ways: [(u32, f64, Rgb); WAYS] = std::array::from_fn(|_| {
        let (index, chance) = choose(&around, LEAST_CHANCE, random);
        let (alpha, v) = deon::tilt_and_variance(fibre, index as u32);
        // M_p(theta_i, theta_o) is a density of this over the cosine; flux goes with the cosine at either side.
        let cone = around_cone(theta_i, v, random);
        // A view near a pole may have its cone beyond it, which is the cone as far before it.
        let [one, other] = [cone, PI.copysign(cone) - cone].map(|cone| 2.0 * alpha - cone);
        let is_way = |theta: f64| theta.abs() < FRAC_PI_2;
        let (theta, count) = match (is_way(one), is_way(other)) {
            (true, true) => (if random.random() { one } else { other }, 2.0),
            (true, false) => (one, 1.0),
            (false, true) => (other, 1.0),
            (false, false) => (one, 0.0),
        };
        let section = CrossSection::new(fibre.eta, theta);
        let sent = deon_energy(index as u32, |p| {
            section.attenuation(p, gamma.abs(), &fibre.sigma_a)
        });
        let scale =
            count * theta.cos().powi(2) / (theta_i.cos() * cone.cos() * chance).max(f64::MIN_POSITIVE);
        (index as u32, theta, sent.map(|a| a * scale))
    });
    let (index, chance) = choose(&ways.map(|(_, _, weight)| weight), LEAST_EXACT, random);
    let (p, theta, weight) = ways[index];
    Sample {
        theta,
        phi: deon_azimuth(fibre, p, gamma, 0.5 * (theta_i - theta), random),
        weight: weight.map(|w| w / (WAYS as f64 * chance)),
    }
}

/// [`deon_energy`] of every order that is drawn.
fn deon_energies(energy: impl Fn(u32) -> Rgb) -> [Rgb; 5] {
    std::array::from_fn(|p| deon_energy(p as u32, &energy))
}

/// What order `p` carries; the last one stands for the geometric series from its order on.
fn deon_energy(p: u32, energy: impl Fn(u32) -> Rgb) -> Rgb {
    let mut sent = energy(p);
    if p == deon::DRAWN_ORDERS {
        for (of_last, of_next) in sent.iter_mut().zip(energy(p + 1)) {
            let ratio = of_next / of_last.max(f64::MIN_POSITIVE);
            *of_last /= 1.0 - ratio.min(1.0 - 1e-9);
        }
    }
    sent
}

/// An inclination of the spherical Gaussian of variance `v` around the cone `theta`.
fn around_cone(theta: f64, v: f64, random: &mut impl Rng) -> f64 {
    let rest = random.random::<f64>();
    let u = 1.0 + v * (rest + (1.0 - rest) * (-2.0 / v).exp()).ln();
    let across = (1.0 - u * u).max(0.0).sqrt() * (TAU * random.random::<f64>()).cos();
    (u * theta.sin() + across * theta.cos()).clamp(-1.0, 1.0).asin()
}

/// Azimuth between the ways in and out of light of order `p` that met the fibre at `gamma`.
fn deon_azimuth(fibre: &Fibre, p: u32, gamma: f64, theta_d: f64, random: &mut impl Rng) -> f64 {
    let phi = if p < deon::DRAWN_ORDERS {
        let exit = CrossSection::new(fibre.eta, theta_d).exit_azimuth(p, gamma.abs());
        exit * gamma.signum() + fibre.azimuthal_width / SQRT_2 * normal(random)
    } else {
        TAU * random.random::<f64>()
    };
    phi.rem_euclid(TAU)
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

    #[test]
    fn light_goes_the_way_that_views_are_followed_back() {
        const COUNT: u32 = 400_000;
        const BINS: usize = 6;
        let bin = |theta: f64| (((theta / FRAC_PI_2 + 1.0) * 0.5 * BINS as f64) as usize).min(BINS - 1);
        // Inclinations as light from everywhere has them: flux on a fibre goes with cos^2.
        let inclination = |random: &mut Pcg64Mcg| {
            loop {
                let theta = random.random_range(-FRAC_PI_2..FRAC_PI_2);
                if random.random::<f64>() < theta.cos().powi(2) {
                    break theta;
                }
            }
        };
        let lit = |theta_i: f64, phi: f64| [1.0, (-4.0 * (theta_i - 0.4).powi(2)).exp() * (1.2 + phi.cos())];
        for sigma_a in [[0.0; 3], [0.1, 0.3, 0.8]] {
            let fibre = Fibre { sigma_a, ..brown() };
            let mut random = Pcg64Mcg::seed_from_u64(11);
            // Flux between bins of inclinations, out of white light and out of a light at one side.
            let mut flux = [[[0.0; 2]; BINS]; 3];
            for _ in 0..COUNT {
                let theta = inclination(&mut random);
                let onward = sample_deon_onward(&fibre, theta, &mut random);
                let back = sample_deon(&fibre, theta, &mut random);
                // The negative control takes the way back for the way on.
                let ways = [
                    (bin(onward.theta), theta, &onward),
                    (bin(theta), back.theta, &back),
                    (bin(back.theta), theta, &back),
                ];
                for (flux, (bin, theta_i, sample)) in flux.iter_mut().zip(ways) {
                    let light =
                        lit(theta_i, sample.phi).map(|light| light * sample.weight[1] / f64::from(COUNT));
                    flux[bin][0] += light[0];
                    flux[bin][1] += light[1];
                }
            }
            let [onward, back, wrong] = flux;
            let apart = |a: &[[f64; 2]; BINS]| {
                let pairs = a.as_flattened().iter().zip(back.as_flattened());
                pairs.map(|(a, b)| (a - b).abs() / (b + 0.01)).fold(0.0, f64::max)
            };
            assert!(apart(&onward) < 0.02, "{onward:.4?} onward, {back:.4?} back");
            assert!(
                apart(&wrong) > 0.06,
                "{wrong:.4?} is not to be told from {back:.4?}"
            );
        }
    }
}
