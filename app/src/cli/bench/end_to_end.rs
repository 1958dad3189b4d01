//! What the product makes of fitted lights, against the float64 scattering function integrated over every pixel of the map.
//!
//! N_t of a fibre and view is smooth: it is tabulated over (theta_i, phi_i) with the reference and interpolated; M_t and
//! cos theta_i / cos^2 theta_d are exact at every pixel.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use balayage_render::gpu::probe::{self, ProbeCase, ProbeResult};
use balayage_render::gpu::{Gpu, Method, probe_cases};
use balayage_render::light::{EnvironmentMap, LightSet, SrbfLight};
use balayage_render::optics::{Direction, Fibre, OpticsError, scattering_function};
use balayage_render::param::VertexParams;
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
/// A longitudinal lobe below this is nothing, also times a sun of 1e6.
const NOTHING: f64 = 1e-16;
const SEED: u64 = 2011;
/// Widths of R of hair as it was measured and as it is painted unless a person wants otherwise, degrees (Marschner 2003, table 1); the
/// random fibres go from 1.7 to 14.
pub(super) const USUAL_DEG: std::ops::RangeInclusive<f64> = 5.0..=10.0;

/// A map and the lights that were fitted to it.
pub(super) struct Scene {
    pub map: EnvironmentMap,
    pub lights: LightSet,
}

/// How far the product is from the reference under one map: root mean squares over the fibres (rgb norm).
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    /// Of |product under the lights - reference under the map| / |reference under the map|.
    pub all: f64,
    /// The same of the reference under the lights: what the fit alone leaves.
    pub fit: f64,
    /// The same of the product against the reference, both under the lights: what the closed forms alone leave.
    pub scattering: f64,
    /// Difference of product and reference over the radiance of the reference, each a root mean square.
    pub overall: f64,
    /// Median of the product's relative difference.
    pub median: f64,
    /// As `all`, of the fibres whose R is as wide as [`USUAL_DEG`]; narrower lobes tell neighbouring lights apart.
    pub usual: f64,
}

/// A random fibre in a random place, seen from one side.
#[derive(Clone, Copy)]
struct Strand {
    case: ProbeCase,
    /// Columns u (tangent), v, w.
    world_from_fibre: DMat3,
}

/// The scattering function of a strand.
struct Scattering<'a> {
    strand: &'a Strand,
    /// N_t at (theta_i, phi_i), rgb of R, TT and TRT.
    table: Vec<[DVec3; 3]>,
}

/// Random fibres of circular hair; with `like`, all of that hair in random places.
fn strands(count: usize, like: Option<&VertexParams>) -> Vec<Strand> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let draw = |_| {
        let drawn = probe_cases::hair(&mut random, false);
        let case = like.map_or(drawn, |params| of_hair(params, &drawn));
        // Four normal deviates give a uniform rotation; sums of uniform ones are near enough to normal to lose any axis.
        let mut deviate = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>();
        let turn = DQuat::from_xyzw(deviate(), deviate(), deviate(), deviate()).normalize();
        Strand {
            case,
            world_from_fibre: DMat3::from_quat(turn),
        }
    };
    (0..count).map(draw).collect()
}

/// The directions of `drawn` with the hair of `params`.
fn of_hair(params: &VertexParams, drawn: &ProbeCase) -> ProbeCase {
    let lobes = |r: f32, ratios: [f32; 2]| [1.0, ratios[0], ratios[1]].map(|ratio| f64::from(r * ratio));
    ProbeCase {
        sigma_a: params.sigma_a.map(f64::from),
        alpha: lobes(params.alpha_rad, params.alpha_ratios),
        beta: lobes(params.beta_rad, params.beta_ratios),
        azimuthal_width: f64::from(params.azimuthal_width),
        eta: f64::from(params.eta),
        eccentricity: 1.0,
        ..*drawn
    }
}

/// Holds `count` random fibres (all of the hair `like`, if given) against the reference under every scene, whose maps are of one size; `on_done` hears of every fibre.
pub(super) fn errors(
    gpu: &Gpu,
    count: usize,
    like: Option<&VertexParams>,
    scenes: &[Scene],
    on_done: impl Fn() + Sync,
) -> Result<Vec<Errors>, CliError> {
    // A fibre's table is dropped before the next one's is made: it is the large part.
    let strands = strands(count, like);
    let fields: Vec<EnvironmentMap> = scenes.iter().flat_map(Scene::fields).collect();
    let reference = |strand: &Strand| -> Result<Vec<DVec3>, OpticsError> {
        let radiance = Scattering::new(strand)?.under(&fields);
        on_done();
        Ok(radiance)
    };
    let wanted: Vec<Vec<DVec3>> = strands
        .par_iter()
        .map(reference)
        .collect::<Result<_, _>>()
        .map_err(|error| CliError::Input(error.to_string()))?;

    let of_scene = |(number, scene): (usize, &Scene)| {
        let shown = product(gpu, &strands, &scene.lights)?;
        let under = |field: usize| wanted.iter().map(move |radiance| radiance[2 * number + field]);
        let (map, lights): (Vec<DVec3>, Vec<DVec3>) = (under(0).collect(), under(1).collect());
        let size = rms(map.iter().map(|radiance| radiance.length()));
        let difference = rms(shown.iter().zip(&map).map(|(a, b)| (*a - *b).length()));
        let mut all = relative(&shown, &map);
        let usual: Vec<f64> = strands
            .iter()
            .zip(&all)
            .filter(|(strand, _)| USUAL_DEG.contains(&strand.case.beta[0].to_degrees()))
            .map(|(_, error)| *error)
            .collect();
        all.sort_by(f64::total_cmp);
        Ok(Errors {
            all: rms(all.iter().copied()),
            fit: rms(relative(&lights, &map).into_iter()),
            scattering: rms(relative(&shown, &lights).into_iter()),
            overall: difference / size,
            median: all[all.len() / 2],
            usual: rms(usual.into_iter()),
        })
    };
    scenes.iter().enumerate().map(of_scene).collect()
}

/// |got - wanted| / |wanted| of every fibre.
fn relative(got: &[DVec3], wanted: &[DVec3]) -> Vec<f64> {
    let one = |(got, wanted): (&DVec3, &DVec3)| (*got - *wanted).length() / wanted.length();
    got.iter().zip(wanted).map(one).collect()
}

fn rms(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(|value| value * value).sum::<f64>() / count).sqrt()
}

/// What the shaders make of every strand under the lights, all lobes.
fn product(gpu: &Gpu, strands: &[Strand], lights: &LightSet) -> Result<Vec<DVec3>, CliError> {
    let cases: Vec<ProbeCase> = strands.iter().flat_map(|strand| strand.cases(lights)).collect();
    let answers = probe::run(gpu, &cases, &Method::default())?;
    let lit = |answers: &[ProbeResult]| {
        let one = |(answer, light): (&ProbeResult, &SrbfLight)| {
            let lobes: DVec3 = answer.single.iter().map(|rgb| DVec3::from_array(*rgb)).sum();
            lobes * light.radiance.as_dvec3()
        };
        answers.iter().zip(&lights.lights).map(one).sum()
    };
    Ok(answers.chunks(lights.lights.len().max(1)).map(lit).collect())
}

impl Scene {
    /// The map, and the lights as a map.
    fn fields(&self) -> [EnvironmentMap; 2] {
        let (width, height) = (self.map.width, self.map.height);
        let (lights, _) = EnvironmentMap::from_fn(width, height, |w| self.lights.radiance(w));
        [self.map.clone(), lights]
    }
}

impl Strand {
    /// (theta, phi) of a world direction.
    fn angles(&self, w: DVec3) -> (f64, f64) {
        let local = self.world_from_fibre.transpose() * w;
        (local.x.clamp(-1.0, 1.0).asin(), local.z.atan2(local.y))
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

impl<'a> Scattering<'a> {
    fn new(strand: &'a Strand) -> Result<Self, OpticsError> {
        let case = &strand.case;
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
                DVec3::from_array(scattered[t]) * cos2_theta_d(case, light.theta)
                    / longitudinal(case, t, BROAD, light.theta)
            }));
        }
        Ok(Self { strand, table })
    }

    /// Integral of L S cos theta_i over the pixels of every field; all are of one size.
    fn under(&self, fields: &[EnvironmentMap]) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; fields.len()];
        let Some(grid) = fields.first() else { return sums };
        for y in 0..grid.height {
            let solid_angle = grid.pixel_solid_angle(y);
            for x in 0..grid.width {
                let (theta, phi) = self.strand.angles(grid.direction(x, y));
                let scattered = self.at(theta, phi) * solid_angle;
                if scattered == DVec3::ZERO {
                    continue;
                }
                for (sum, field) in sums.iter_mut().zip(fields) {
                    *sum += field.pixels[y * grid.width + x].as_dvec3() * scattered;
                }
            }
        }
        sums
    }

    /// S cos theta_i, all lobes.
    fn at(&self, theta: f64, phi: f64) -> DVec3 {
        let t = (theta + FRAC_PI_2) / PI * THETA as f64;
        let p = (phi + PI) / TAU * PHI as f64;
        let (i, j) = ((t as usize).min(THETA - 1), p as usize);
        let (a, b) = (t - i as f64, p - j as f64);
        let corner = |di: usize, dj: usize| &self.table[(i + di) * PHI + (j + dj) % PHI];
        let case = &self.strand.case;
        let lobe = |lobe: usize| {
            let m = longitudinal(case, lobe, case.beta[lobe], theta);
            if m < NOTHING {
                return DVec3::ZERO;
            }
            let low = corner(0, 0)[lobe].lerp(corner(0, 1)[lobe], b);
            low.lerp(corner(1, 0)[lobe].lerp(corner(1, 1)[lobe], b), a) * m
        };
        (0..3).map(lobe).sum::<DVec3>() * theta.cos() / cos2_theta_d(case, theta)
    }
}

/// cos^2 theta_d; not 0, where light and view run along the fibre in opposite senses.
fn cos2_theta_d(case: &ProbeCase, theta_i: f64) -> f64 {
    (0.5 * (case.theta_o - theta_i)).cos().powi(2).max(1e-12)
}

/// M_t of one lobe at standard deviation `beta` in theta_h: normal in theta_i around 2 alpha - theta_o.
fn longitudinal(case: &ProbeCase, lobe: usize, beta: f64, theta_i: f64) -> f64 {
    let sigma = 2.0 * beta;
    let x = (theta_i - 2.0 * case.alpha[lobe] + case.theta_o) / sigma;
    (-0.5 * x * x).exp() / (sigma * TAU.sqrt())
}

#[cfg(test)]
mod tests {
    use balayage_render::optics::{self, single_scattering};
    use glam::Vec3;

    use super::*;

    #[test]
    fn pixels_sum_to_the_reference_of_a_light() {
        let mut strands = strands(3, None);
        // Seen nearly along the fibre the scattering function grows without bound.
        strands[2].case.theta_o = 1.52;
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
            let error = (Scattering::new(strand).expect("a sound fibre").under(&[map])[0] - wanted).length()
                / wanted.length();
            assert!(error < 0.005, "{error}");
        }
    }
}
