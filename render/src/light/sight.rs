//! What the refinement looks at: the map, blurred, at points over the sphere, and how much an error counts at each.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::cells::Cell;
use super::luminance;
use super::mixture::peak;

/// Points of a patch.
pub(super) const PATCH: usize = 96;

/// Weight of the relative error of the whole map's energy beside the RMS of the residual.
const ENERGY_WEIGHT: f64 = 3.0;

/// Exponent below which a lobe counts as zero.
const NEGLIGIBLE: f64 = -16.0;

/// How finely the map is looked at, and whether relative to its surroundings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Bandwidth of the blur, radians.
    pub blur: f64,
    /// Bandwidth of the blur whose luminance the residual is relative to, radians; none for plain least squares.
    pub surround: Option<f64>,
    /// Bands and sectors of the sphere, each a [`Patch`]. The points should be closer than the blur's standard deviation.
    pub divisions: usize,
    /// How much its residual counts beside that of other sights.
    pub weight: f64,
}

impl Sight {
    /// What hair sees through its wide lobes.
    pub const HAIR: Self = Self {
        blur: 0.2,
        surround: Some(0.5),
        divisions: 4,
        weight: 1.0,
    };
    /// What a fit from a seed looks at: beside the points of smooth hair fewer for the wide lobes do, and found no worse lights on nine maps.
    /// Steps of a sequence, which have these alone, drift with so few.
    pub const ALL_HAIR: [Self; 2] = [
        Self {
            divisions: 3,
            ..Self::HAIR
        },
        Self::SMOOTH_HAIR,
    ];
    /// What smooth hair sees besides, through lobes of some 4 degrees, which may look past a bright neighbour. Chosen on nine maps
    /// and 240 fibres of `bench lights --end-to-end`: more weight costs the wide lobes more than the narrow ones gain.
    const SMOOTH_HAIR: Self = Self {
        blur: 0.1,
        surround: Some(0.2),
        divisions: 7,
        weight: 0.4,
    };
    /// Plain least squares, as fine as a loop over points affords.
    pub const L2: Self = Self {
        blur: 0.06,
        surround: None,
        divisions: 8,
        weight: 1.0,
    };
}

/// Brightness below which a place counts as this bright, relative to the mean of the map.
const FLOOR: f32 = 1e-3;

/// Neighbouring points on the sphere, coordinate by coordinate, so that loops over them vectorise.
pub(super) struct Patch {
    pub x: [f32; PATCH],
    pub y: [f32; PATCH],
    pub z: [f32; PATCH],
    /// Which of the target's sights it belongs to.
    pub sight: usize,
    centre: Vec3,
    /// Angle from the centre to the farthest point, radians.
    radius: f32,
}

impl Patch {
    fn new(sight: usize, points: &[DVec3]) -> Self {
        let centre = points.iter().sum::<DVec3>().normalize();
        let radius = points
            .iter()
            .map(|point| centre.angle_between(*point))
            .fold(0.0, f64::max);
        Self {
            x: std::array::from_fn(|i| points[i].x as f32),
            y: std::array::from_fn(|i| points[i].y as f32),
            z: std::array::from_fn(|i| points[i].z as f32),
            sight,
            centre: centre.as_vec3(),
            radius: radius as f32,
        }
    }

    /// Cosine from the centre below which a lobe of concentration kappa is negligible at every point.
    pub fn horizon(&self, kappa: f32) -> f32 {
        let reach = (1.0 + NEGLIGIBLE as f32 / kappa).max(-1.0).acos() + self.radius;
        reach.min(PI as f32).cos()
    }

    /// Whether a lobe around `direction` reaches above the [`Patch::horizon`] of its concentration.
    pub fn sees(&self, direction: Vec3, horizon: f32) -> bool {
        self.centre.dot(direction) >= horizon
    }

    /// w . d - 1 at every point w.
    pub fn cosines(&self, d: Vec3) -> [f32; PATCH] {
        std::array::from_fn(|i| self.x[i] * d.x + self.y[i] * d.y + self.z[i] * d.z - 1.0)
    }
}

/// exp(x) of x <= 0 to 3e-7, without branches, so that loops over it vectorise; 1e-35 for what is smaller.
#[inline]
pub(super) fn decay(x: f32) -> f32 {
    // Adding 1.5 2^23 rounds to an integer, which is left in the low bits.
    const ROUND: f32 = 12_582_912.0;
    let x = x.max(-80.0);
    let rounded = x * std::f32::consts::LOG2_E + ROUND;
    let rest = x - (rounded - ROUND) * std::f32::consts::LN_2;
    let taylor = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    let value = taylor.iter().fold(0.0, |sum, term| sum * rest + term);
    value * f32::from_bits((rounded.to_bits() << 23).wrapping_add(127 << 23))
}

/// The blurred map at the points of one sight or several, and the weights of the residual there.
pub(super) struct Target {
    /// Bandwidth of every sight's blur, radians.
    pub blurs: Vec<f64>,
    /// The points of one sight after the other, [`PATCH`] of them each.
    pub patches: Vec<Patch>,
    /// Weighted values of the blurred map, rgb after each other in columns.
    pub values: DMatrix<f64>,
    /// Weight of the residual at every point.
    pub weights: Vec<f32>,
    /// Integral of the map, rgb, times the weight of the energy row.
    pub energy: DVec3,
    /// Weight of the row that holds the whole map's energy.
    pub energy_weight: f64,
}

impl Target {
    /// Looks at a map given as cells; `None` where it holds no light.
    pub fn new(cells: &[Cell], sights: &[Sight]) -> Option<Self> {
        let total: DVec3 = cells.iter().map(|cell| cell.energy).sum();
        let mass: f64 = cells.iter().map(|cell| cell.mass).sum();
        if mass <= 0.0 {
            return None;
        }

        // Relative to the mean, so that no radiance is out of range in single precision.
        let mean = mass / (4.0 * PI);
        let source = |cell: &Cell| {
            let direction = cell.mean.normalize_or_zero().as_vec3();
            (direction, (cell.energy / mean).as_vec3())
        };
        let sources: Vec<(Vec3, Vec3)> = cells.iter().map(source).collect();
        let (mut patches, mut blurred, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        for (number, sight) in sights.iter().enumerate() {
            let points = patches_of(number, sight.divisions);
            let seen = spread(&points, &sources, sight.blur);
            weights.extend(weights_of(*sight, &points, &seen));
            blurred.extend(seen);
            patches.extend(points);
        }
        let value = |i: usize, c: usize| f64::from(blurred[i][c] * weights[i]);
        let values = DMatrix::from_fn(blurred.len(), 3, value);
        let weights = weights.iter().map(|weight| weight / mean as f32).collect();
        let is_relative = sights.iter().any(|sight| sight.surround.is_some());
        let energy_weight = if is_relative { ENERGY_WEIGHT / mass } else { 0.0 };
        Some(Self {
            blurs: sights.iter().map(|sight| sight.blur).collect(),
            patches,
            values,
            weights,
            energy: total * energy_weight,
            energy_weight,
        })
    }
}

/// Weight of the residual at every point; equal solid angles make the sum over the points of a sight a mean over the sphere.
fn weights_of(sight: Sight, patches: &[Patch], blurred: &[Vec3]) -> Vec<f32> {
    let count = blurred.len();
    let share = (sight.weight / (count as f64).sqrt()) as f32;
    let Some(surround) = sight.surround else {
        return vec![share; count];
    };

    // The rest of the way from the narrow to the wide blur starts from the points themselves.
    let rest = (surround * surround - sight.blur * sight.blur).sqrt();
    let solid_angle = (4.0 * PI / count as f64) as f32;
    let point = |i: usize| {
        let (patch, i) = (&patches[i / PATCH], i % PATCH);
        Vec3::new(patch.x[i], patch.y[i], patch.z[i])
    };
    let source = |(i, rgb): (usize, &Vec3)| (point(i), *rgb * solid_angle);
    let sources: Vec<(Vec3, Vec3)> = blurred.iter().enumerate().map(source).collect();
    let weight = |rgb: &Vec3| share / (luminance(*rgb) + FLOOR);
    spread(patches, &sources, rest).iter().map(weight).collect()
}

/// Points spread evenly over the sphere (a Fibonacci spiral), each with the same solid angle, as `divisions` sectors of as many bands.
fn patches_of(sight: usize, divisions: usize) -> Vec<Patch> {
    let count = divisions * divisions * PATCH;
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let point = |i: usize| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let azimuth = (golden * i as f64) % (2.0 * PI);
        let radius = (1.0 - y * y).sqrt();
        (
            azimuth,
            DVec3::new(radius * azimuth.sin(), y, radius * azimuth.cos()),
        )
    };
    let mut points: Vec<(f64, DVec3)> = (0..count).map(point).collect();
    for band in points.chunks_mut(divisions * PATCH) {
        band.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    let points: Vec<DVec3> = points.into_iter().map(|(_, point)| point).collect();
    points
        .chunks(PATCH)
        .map(|points| Patch::new(sight, points))
        .collect()
}

/// Sum of point-like energies, each spread by an SRBF of the given bandwidth, at every point.
fn spread(patches: &[Patch], sources: &[(Vec3, Vec3)], bandwidth: f64) -> Vec<Vec3> {
    let kappa = 2.0 / (bandwidth * bandwidth);
    let (kappa, peak) = (kappa as f32, peak(kappa) as f32);
    let at = |patch: &Patch| {
        let horizon = patch.horizon(kappa);
        let mut sums = [[0.0_f32; PATCH]; 3];
        for (direction, energy) in sources {
            if !patch.sees(*direction, horizon) {
                continue;
            }
            let values = patch.cosines(*direction).map(|cosine| decay(kappa * cosine));
            for (sum, energy) in sums.iter_mut().zip((*energy * peak).to_array()) {
                for (sum, value) in sum.iter_mut().zip(&values) {
                    *sum += energy * value;
                }
            }
        }
        (0..PATCH)
            .map(|i| Vec3::new(sums[0][i], sums[1][i], sums[2][i]))
            .collect::<Vec<Vec3>>()
    };
    let blurred: Vec<Vec<Vec3>> = patches.par_iter().map(at).collect();
    blurred.concat()
}
