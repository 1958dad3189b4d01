//! What the product makes of fitted lights, against the float64 scattering function integrated over every pixel of the map.
//!
//! N_t / cos^2 theta_d of a fibre and view is smooth: it is tabulated over (theta_i, phi_i) with the reference and interpolated;
//! M_t and cos theta_i are exact at every pixel.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use balayage_render::gpu::probe::{self, ProbeCase};
use balayage_render::gpu::{Gpu, Method, probe_cases};
use balayage_render::light::{EnvironmentMap, LightSet};
use balayage_render::optics::{Direction, Fibre, OpticsError, scattering_function};
use glam::{DMat3, DQuat, DVec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::cli::CliError;

/// Intervals of the tables in theta_i and phi_i.
const THETA: usize = 48;
const PHI: usize = 384;
/// Relative tolerance of the tables.
const TOLERANCE: f64 = 1e-3;
/// Width at which M is far from zero everywhere, so that it divides out.
const BROAD: f64 = 1.5;
const SEED: u64 = 2011;

/// A random fibre in a random place, seen from one side, and its scattering function.
pub(super) struct Strand {
    case: ProbeCase,
    /// Columns u (tangent), v, w.
    world_from_fibre: DMat3,
    /// N_t / cos^2 theta_d at (theta_i, phi_i), rgb of R, TT and TRT.
    table: Vec<[DVec3; 3]>,
}

/// Random fibres of circular hair with their tables.
pub(super) fn strands(count: usize, on_done: impl Fn() + Sync) -> Result<Vec<Strand>, CliError> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let drawn: Vec<(ProbeCase, DMat3)> = (0..count)
        .map(|_| {
            let case = probe_cases::hair(&mut random, false);
            // Four normal deviates give a uniform rotation; sums of uniform ones are near enough to normal to lose any axis.
            let mut deviate = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
            let turn = DQuat::from_xyzw(deviate(), deviate(), deviate(), deviate()).normalize();
            (case, DMat3::from_quat(turn))
        })
        .collect();
    drawn
        .into_par_iter()
        .map(|(case, world_from_fibre)| {
            let strand = Strand::new(case, world_from_fibre).map_err(|e| CliError::Input(e.to_string()));
            on_done();
            strand
        })
        .collect()
}

/// Root mean square over the strands of |product - reference| / |reference| (rgb norm), and of the difference over that of the reference.
pub(super) fn errors(
    gpu: &Gpu,
    strands: &[Strand],
    map: &EnvironmentMap,
    lights: &LightSet,
) -> Result<[f64; 2], CliError> {
    let wanted: Vec<DVec3> = strands.par_iter().map(|strand| strand.under_map(map)).collect();
    let cases: Vec<ProbeCase> = strands.iter().flat_map(|strand| strand.cases(lights)).collect();
    let answers = probe::run(gpu, &cases, &Method::default())?;
    let per_strand = lights.lights.len().max(1);
    let (mut relative, mut difference, mut size) = (0.0, 0.0, 0.0);
    for (answers, wanted) in answers.chunks(per_strand).zip(&wanted) {
        let lit = answers.iter().zip(&lights.lights).map(|(answer, light)| {
            let lobes: DVec3 = answer.single.iter().map(|rgb| DVec3::from_array(*rgb)).sum();
            lobes * light.radiance.as_dvec3()
        });
        let error = (lit.sum::<DVec3>() - *wanted).length_squared();
        relative += error / wanted.length_squared();
        difference += error;
        size += wanted.length_squared();
    }
    Ok([
        (relative / wanted.len().max(1) as f64).sqrt(),
        (difference / size).sqrt(),
    ])
}

impl Strand {
    fn new(case: ProbeCase, world_from_fibre: DMat3) -> Result<Self, OpticsError> {
        let broad = Fibre {
            eta: case.eta,
            eccentricity: case.eccentricity,
            sigma_a: case.sigma_a,
            alpha: case.alpha,
            beta: [BROAD; 3],
            azimuthal_width: case.azimuthal_width,
        };
        let view = Direction {
            theta: case.theta_o,
            phi: case.phi_o,
        };
        let mut table = Vec::with_capacity((THETA + 1) * PHI);
        for index in 0..(THETA + 1) * PHI {
            let light = Direction {
                theta: PI * (index / PHI) as f64 / THETA as f64 - FRAC_PI_2,
                phi: TAU * (index % PHI) as f64 / PHI as f64 - PI,
            };
            let scattered = scattering_function(&broad, light, view, TOLERANCE)?.to_array();
            table.push(std::array::from_fn(|t| {
                DVec3::from_array(scattered[t]) / longitudinal(&case, t, BROAD, light.theta)
            }));
        }
        Ok(Self {
            case,
            world_from_fibre,
            table,
        })
    }

    /// (theta, phi) of a world direction.
    fn angles(&self, w: DVec3) -> (f64, f64) {
        let local = self.world_from_fibre.transpose() * w;
        (local.x.clamp(-1.0, 1.0).asin(), local.z.atan2(local.y))
    }

    /// Integral of L S cos theta_i over the pixels.
    fn under_map(&self, map: &EnvironmentMap) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for y in 0..map.height {
            let mut row = DVec3::ZERO;
            for x in 0..map.width {
                let (theta, phi) = self.angles(map.direction(x, y));
                row += map.pixels[y * map.width + x].as_dvec3() * self.scattered(theta, phi);
            }
            sum += row * map.pixel_solid_angle(y);
        }
        sum
    }

    /// S cos theta_i, all lobes.
    fn scattered(&self, theta: f64, phi: f64) -> DVec3 {
        let t = (theta + FRAC_PI_2) / PI * THETA as f64;
        let p = (phi + PI) / TAU * PHI as f64;
        let (i, j) = ((t as usize).min(THETA - 1), p as usize);
        let (a, b) = (t - i as f64, p - j as f64);
        let corner = |di: usize, dj: usize| &self.table[(i + di) * PHI + (j + dj) % PHI];
        let lobe = |lobe: usize| {
            let m = longitudinal(&self.case, lobe, self.case.beta[lobe], theta);
            let low = corner(0, 0)[lobe].lerp(corner(0, 1)[lobe], b);
            low.lerp(corner(1, 0)[lobe].lerp(corner(1, 1)[lobe], b), a) * m
        };
        (0..3).map(lobe).sum::<DVec3>() * theta.cos()
    }

    /// One probe case a light.
    fn cases(&self, lights: &LightSet) -> impl Iterator<Item = ProbeCase> {
        lights.lights.iter().map(|light| {
            let (theta_j, phi_j) = self.angles(light.direction.as_dvec3());
            ProbeCase {
                theta_j,
                phi_j,
                lambda_j: f64::from(light.bandwidth),
                ..self.case
            }
        })
    }
}

/// M_t of one lobe at standard deviation `beta` in theta_h: normal in theta_i around 2 alpha - theta_o.
fn longitudinal(case: &ProbeCase, lobe: usize, beta: f64, theta_i: f64) -> f64 {
    let sigma = 2.0 * beta;
    let x = (theta_i - 2.0 * case.alpha[lobe] + case.theta_o) / sigma;
    (-0.5 * x * x).exp() / (sigma * TAU.sqrt())
}

#[cfg(test)]
mod tests {
    use balayage_render::light::SrbfLight;
    use balayage_render::optics::{self, single_scattering};
    use glam::Vec3;

    use super::*;

    #[test]
    fn pixels_sum_to_the_reference_of_a_light() {
        let strands = strands(2, || ()).expect("sound fibres");
        for strand in &strands {
            let light = SrbfLight {
                direction: Vec3::new(0.3, 0.5, -0.8).normalize(),
                bandwidth: 0.6,
                radiance: Vec3::ONE,
            };
            let (map, _) = EnvironmentMap::from_fn(256, 128, |w| light.radiance_towards(w));
            let (theta, phi) = strand.angles(light.direction.as_dvec3());
            let c = &strand.case;
            let fibre = Fibre {
                eta: c.eta,
                eccentricity: c.eccentricity,
                sigma_a: c.sigma_a,
                alpha: c.alpha,
                beta: c.beta,
                azimuthal_width: c.azimuthal_width,
            };
            let view = Direction {
                theta: c.theta_o,
                phi: c.phi_o,
            };
            let centre = optics::SrbfLight::new(Direction { theta, phi }, 0.6).expect("a light");
            let wanted = single_scattering(&fibre, view, &centre, 1e-4)
                .expect("an integral")
                .sum();
            let wanted = DVec3::from_array(wanted);
            let error = (strand.under_map(&map) - wanted).length() / wanted.length();
            assert!(error < 0.005, "{error}");
        }
    }
}
