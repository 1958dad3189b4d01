//! What hair sees of the difference between a map and the lights that stand for it.
//!
//! A simple hair-like kernel, a Gaussian lobe in theta_h times a broad reflection and a forward peak in azimuth, is integrated over
//! every pixel for a fixed set of random fibres; the hair error is the RMS of the relative differences.

use std::borrow::Cow;
use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::{ControlFlow, Range};

use glam::{DVec3, Vec3};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::bands::bands;
use super::fit::Progress;
use super::{EnvironmentMap, LightSet};

/// Fibres of [`HairKernel::default`].
const FIBRES: usize = 500;

/// Entries of a kernel table; linear interpolation then errs by 1e-6 of the peak.
const TABLE: usize = 4096;

/// Maps below this size are divided, so that the sum over pixels is an integral.
const LEAST_ROWS: usize = 64;

/// Maps wider than this are averaged down by a whole factor: their pixels are far finer than any lobe (0.35 degrees), and there are
/// millions of them for each of hundreds of fibres.
const MOST_COLUMNS: usize = 1024;

/// The kernel normal(theta_h; 0, longitudinal) (cos(phi/2)/4 + normal(pi - |phi|; azimuthal)) cos theta_i and its fibres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HairKernel {
    /// Standard deviation of the lobe in theta_h, degrees.
    pub longitudinal_deg: f32,
    /// Standard deviation of the forward peak in azimuth, degrees.
    pub azimuthal_deg: f32,
    /// How many fibres, with uniform tangent and view.
    pub fibres: usize,
    /// Seed of the fibres.
    pub seed: u64,
}

impl Default for HairKernel {
    /// 8 and 25 degrees, 500 fibres.
    fn default() -> Self {
        Self {
            longitudinal_deg: 8.0,
            azimuthal_deg: 25.0,
            fibres: FIBRES,
            seed: 2011,
        }
    }
}

/// A map with the radiance of its fibres, ready to judge light sets.
pub struct HairProbe<'a> {
    map: Cow<'a, EnvironmentMap>,
    /// Sine and cosine of the azimuth of every column.
    azimuth: Vec<(f32, f32)>,
    fibres: Vec<Fibre>,
    /// Values of the azimuthal factor at cos(phi/2) = index / (TABLE - 1).
    azimuthal: Vec<f32>,
    /// Radiance of every fibre under the map, rgb.
    radiance: Vec<DVec3>,
}

/// One fibre seen from one side.
struct Fibre {
    tangent: Vec3,
    view: Vec3,
    sin_theta_o: f32,
    cos_theta_o: f32,
    /// Values of the longitudinal factor times cos theta_i at theta_i = -pi/2 + pi index / (TABLE - 1).
    longitudinal: Vec<f32>,
}

/// Always goes on.
const GO_ON: Progress<'static> = &|_| ControlFlow::Continue(());

impl<'a> HairProbe<'a> {
    /// Integrates the kernel over the map for every fibre.
    pub fn new(map: &'a EnvironmentMap, kernel: HairKernel) -> Self {
        Self::with_progress(map, kernel, GO_ON).expect("nothing cancels")
    }

    /// As [`HairProbe::new`]; none where `progress` cancels.
    pub fn with_progress(map: &'a EnvironmentMap, kernel: HairKernel, progress: Progress) -> Option<Self> {
        let share = |done: f64| progress(0.2 * done);
        let mut probe = Self::unlit(map.averaged(MOST_COLUMNS, &share)?, kernel);
        let map = &probe.map;
        probe.radiance = probe.integrate(
            |rows| Cow::Borrowed(&map.pixels[rows.start * map.width..rows.end * map.width]),
            &|done| progress(0.2 + 0.8 * done),
        )?;
        Some(probe)
    }

    /// The fibres and the tables of their kernels.
    fn unlit(map: Cow<'a, EnvironmentMap>, kernel: HairKernel) -> Self {
        let mut random = Pcg64Mcg::seed_from_u64(kernel.seed);
        let sigma = kernel.longitudinal_deg.to_radians();
        let fibres = (0..kernel.fibres)
            .map(|_| {
                Fibre::new(
                    uniform_direction(&mut random),
                    uniform_direction(&mut random),
                    sigma,
                )
            })
            .collect();
        let sigma = kernel.azimuthal_deg.to_radians();
        let azimuthal = |index: usize| {
            let cos_half = index as f32 / (TABLE - 1) as f32;
            cos_half / 4.0 + normal(2.0 * cos_half.asin(), sigma)
        };
        let map = match map {
            Cow::Borrowed(map) => map.at_least(2 * LEAST_ROWS, LEAST_ROWS),
            averaged => averaged,
        };
        let azimuth = |x: usize| (2.0 * PI * (x as f32 + 0.5) / map.width as f32).sin_cos();
        let azimuth = (0..map.width).map(azimuth).collect();
        Self {
            fibres,
            azimuthal: (0..TABLE).map(azimuthal).collect(),
            azimuth,
            radiance: Vec::new(),
            map,
        }
    }

    /// RMS over the fibres of |H_lights - H_map| / |H_map| (rgb norm), H_lights summed over the same pixels; 0 where both are dark.
    pub fn error(&self, lights: &LightSet) -> f64 {
        self.rms(&self.radiance(lights))
    }

    /// As [`HairProbe::error`] for any radiance over unit directions, also one that dips below zero.
    pub fn error_of(&self, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> f64 {
        self.rms(&self.under(radiance, GO_ON).expect("nothing cancels"))
    }

    /// As [`HairProbe::error`]; none where `progress` cancels.
    pub fn error_with_progress(&self, lights: &LightSet, progress: Progress) -> Option<f64> {
        Some(self.rms(&self.under(|w| lights.radiance(w), progress)?))
    }

    /// RMS over the fibres of the relative difference from the map's radiance.
    fn rms(&self, fitted: &[DVec3]) -> f64 {
        let relative = |(fitted, wanted): (&DVec3, &DVec3)| {
            let difference = (*fitted - *wanted).length();
            if difference == 0.0 {
                0.0
            } else {
                difference / wanted.length()
            }
        };
        let sum: f64 = fitted
            .iter()
            .zip(&self.radiance)
            .map(relative)
            .map(|error| error * error)
            .sum();
        (sum / self.fibres.len().max(1) as f64).sqrt()
    }

    /// Radiance of every fibre under the lights, rgb, in an order that the kernel's seed fixes.
    pub fn radiance(&self, lights: &LightSet) -> Vec<DVec3> {
        self.under(|w| lights.radiance(w), GO_ON)
            .expect("nothing cancels")
    }

    /// Radiance of every fibre under the map, rgb.
    pub fn map_radiance(&self) -> &[DVec3] {
        &self.radiance
    }

    /// Radiance of every fibre under any radiance over unit directions; none where `progress` cancels.
    fn under(&self, radiance: impl Fn(Vec3) -> Vec3 + Sync, progress: Progress) -> Option<Vec<DVec3>> {
        self.integrate(|rows| Cow::Owned(self.map.grid_rows(rows, &radiance)), progress)
    }

    /// Sums pixel times kernel times solid angle for every fibre, some rows at a time, whose pixels `pixels_of` gives.
    fn integrate<'p>(
        &self,
        pixels_of: impl Fn(Range<usize>) -> Cow<'p, [Vec3]>,
        progress: Progress,
    ) -> Option<Vec<DVec3>> {
        let map = &self.map;
        let mut sums = vec![DVec3::ZERO; self.fibres.len()];
        for rows in bands(map.height, map.width * self.fibres.len()) {
            progress(rows.start as f64 / map.height as f64).continue_value()?;
            let pixels = pixels_of(rows.clone());
            sums.par_iter_mut()
                .zip(&self.fibres)
                .for_each(|(sum, fibre)| *sum = self.add_rows(*sum, &pixels, rows.start, fibre));
        }
        Some(sums)
    }

    /// Adds pixel times kernel times solid angle of one fibre, from row `first` on.
    fn add_rows(&self, mut sum: DVec3, pixels: &[Vec3], first: usize, fibre: &Fibre) -> DVec3 {
        let map = &self.map;
        for (y, row) in (first..).zip(pixels.chunks(map.width)) {
            let (sin_theta, cos_theta) = (PI * (y as f32 + 0.5) / map.height as f32).sin_cos();
            let mut row_sum = Vec3::ZERO;
            for (pixel, (sin_phi, cos_phi)) in row.iter().zip(&self.azimuth) {
                let w = Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
                row_sum += *pixel * self.kernel(fibre, w);
            }
            sum += row_sum.as_dvec3() * map.pixel_solid_angle(y);
        }
        sum
    }

    /// The kernel for light from `w`.
    fn kernel(&self, fibre: &Fibre, w: Vec3) -> f32 {
        let sin_theta_i = w.dot(fibre.tangent).clamp(-1.0, 1.0);
        let cos_theta_i = (1.0 - sin_theta_i * sin_theta_i).sqrt();
        let cosines = (cos_theta_i * fibre.cos_theta_o).max(1e-12);
        let cos_phi = (w.dot(fibre.view) - sin_theta_i * fibre.sin_theta_o) / cosines;
        let cos_half = (0.5 + 0.5 * cos_phi).clamp(0.0, 1.0).sqrt();
        let longitudinal = interpolate(&fibre.longitudinal, 0.5 + arc_sine(sin_theta_i) / PI);
        longitudinal * interpolate(&self.azimuthal, cos_half)
    }
}

impl Fibre {
    fn new(tangent: Vec3, view: Vec3, sigma: f32) -> Self {
        let sin_theta_o = tangent.dot(view).clamp(-1.0, 1.0);
        let theta_o = sin_theta_o.asin();
        let longitudinal = |index: usize| {
            let theta_i = PI * index as f32 / (TABLE - 1) as f32 - FRAC_PI_2;
            normal(0.5 * (theta_i + theta_o), sigma) * theta_i.cos()
        };
        let longitudinal = (0..TABLE).map(longitudinal).collect();
        Self {
            tangent,
            view,
            sin_theta_o,
            cos_theta_o: theta_o.cos(),
            longitudinal,
        }
    }
}

/// Value of a table over [0, 1] at `place`.
fn interpolate(table: &[f32], place: f32) -> f32 {
    let place = place * (TABLE - 1) as f32;
    let index = (place as usize).min(TABLE - 2);
    let fraction = place - index as f32;
    table[index] + fraction * (table[index + 1] - table[index])
}

/// The normal density with mean 0.
fn normal(x: f32, sigma: f32) -> f32 {
    (-0.5 * (x / sigma).powi(2)).exp() / (sigma * (2.0 * PI).sqrt())
}

/// asin to 2e-8 (Abramowitz and Stegun 4.4.46), several times faster than the exact one.
fn arc_sine(x: f32) -> f32 {
    const A: [f32; 8] = [
        1.5707963050,
        -0.2145988016,
        0.0889789874,
        -0.0501743046,
        0.0308918810,
        -0.0170881256,
        0.0066700901,
        -0.0012624911,
    ];
    let magnitude = x.abs();
    let polynomial = A.iter().rev().fold(0.0, |sum, a| sum * magnitude + a);
    (FRAC_PI_2 - (1.0 - magnitude).max(0.0).sqrt() * polynomial).copysign(x)
}

/// A direction uniform over the sphere.
fn uniform_direction(random: &mut impl Rng) -> Vec3 {
    let y: f64 = random.random_range(-1.0..1.0);
    let phi: f64 = random.random_range(0.0..std::f64::consts::TAU);
    let radius = (1.0 - y * y).sqrt();
    DVec3::new(radius * phi.sin(), y, -radius * phi.cos()).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The kernel in float64, as it is written down.
    fn exact(kernel: HairKernel, fibre: &Fibre, w: Vec3) -> f64 {
        let normal =
            |x: f64, sigma: f64| (-0.5 * (x / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt());
        let (u, o, w) = (fibre.tangent.as_dvec3(), fibre.view.as_dvec3(), w.as_dvec3());
        let (theta_i, theta_o) = (w.dot(u).asin(), o.dot(u).asin());
        let phi = (w - u * w.dot(u)).angle_between(o - u * o.dot(u));
        let longitudinal = normal(
            0.5 * (theta_i + theta_o),
            f64::from(kernel.longitudinal_deg).to_radians(),
        );
        let forward = normal(
            std::f64::consts::PI - phi,
            f64::from(kernel.azimuthal_deg).to_radians(),
        );
        longitudinal * ((phi / 2.0).cos() / 4.0 + forward) * theta_i.cos()
    }

    #[test]
    fn tables_stand_for_the_kernel() {
        let map = EnvironmentMap {
            width: 1,
            height: 1,
            pixels: vec![Vec3::ONE],
        };
        let mut random = Pcg64Mcg::seed_from_u64(3);
        for longitudinal_deg in [4.0, 8.0] {
            let kernel = HairKernel {
                longitudinal_deg,
                fibres: 50,
                ..HairKernel::default()
            };
            let probe = HairProbe::unlit(Cow::Borrowed(&map), kernel);
            for fibre in &probe.fibres {
                let w = uniform_direction(&mut random);
                let (table, exact) = (f64::from(probe.kernel(fibre, w)), exact(kernel, fibre, w));
                assert!((table - exact).abs() < 2e-4 * exact + 1e-5, "{table} {exact}");
            }
        }
    }
}
