//! What the refinement looks at: the map, blurred, at points over the sphere, and how much an error counts at each.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::cells::Cell;
use super::mixture::peak;

/// Points that one task takes; fixed, so that sums do not depend on the number of threads.
pub(super) const POINTS_PER_TASK: usize = 192;

/// Weight of the relative error of the whole map's energy beside the RMS of the residual.
const ENERGY_WEIGHT: f64 = 3.0;

/// Exponent below which a lobe counts as zero.
pub(super) const NEGLIGIBLE: f64 = -30.0;

/// How finely the map is looked at, and whether relative to its surroundings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Bandwidth of the blur, radians.
    pub blur: f64,
    /// Bandwidth of the blur whose luminance the residual is relative to, radians; none for plain least squares.
    pub surround: Option<f64>,
    /// Points at which the residual is taken, a multiple of [`POINTS_PER_TASK`]; their distance should be about half the
    /// blur's standard deviation.
    pub points: usize,
}

impl Sight {
    /// What hair sees.
    pub const HAIR: Self = Self {
        blur: 0.2,
        surround: Some(0.5),
        points: 8 * POINTS_PER_TASK,
    };
    /// Plain least squares, as fine as a loop over points affords.
    pub const L2: Self = Self {
        blur: 0.06,
        surround: None,
        points: 32 * POINTS_PER_TASK,
    };
}

/// Brightness below which a place counts as this bright, relative to the mean of the map.
const FLOOR: f64 = 1e-3;

/// The blurred map at the points, and the weights of the residual there.
pub(super) struct Target {
    /// Bandwidth of the blur, radians.
    pub blur: f64,
    /// Unit vectors.
    pub points: Vec<DVec3>,
    /// Weighted values of the blurred map, rgb after each other in columns.
    pub values: DMatrix<f64>,
    /// Weight of the residual at every point.
    pub weights: Vec<f64>,
    /// Integral of the map, rgb, times the weight of the energy row.
    pub energy: DVec3,
    /// Weight of the row that holds the whole map's energy.
    pub energy_weight: f64,
}

impl Target {
    /// Blurs a map given as cells; `None` where it holds no light.
    pub fn new(cells: &[Cell], sight: Sight) -> Option<Self> {
        let total: DVec3 = cells.iter().map(|cell| cell.energy).sum();
        let mass: f64 = cells.iter().map(|cell| cell.mass).sum();
        if mass <= 0.0 {
            return None;
        }
        let points = sphere_points(sight.points);
        let sources: Vec<_> = cells
            .iter()
            .map(|cell| (cell.mean.normalize_or_zero(), cell.energy))
            .collect();
        let blurred = spread(&points, &sources, sight.blur);

        // Equal solid angles make the sum over points a mean over the sphere.
        let mean = mass / (4.0 * PI);
        let share = (sight.points as f64).sqrt();
        let weights = match sight.surround {
            None => vec![1.0 / (mean * share); sight.points],
            Some(surround) => {
                // The rest of the way from the narrow to the wide blur starts from the points themselves.
                let rest = (surround * surround - sight.blur * sight.blur).sqrt();
                let solid_angle = 4.0 * PI / sight.points as f64;
                let sources: Vec<_> = points
                    .iter()
                    .zip(&blurred)
                    .map(|(x, rgb)| (*x, *rgb * solid_angle))
                    .collect();
                let luminance = DVec3::new(0.2126, 0.7152, 0.0722);
                let weight = |rgb: &DVec3| 1.0 / ((rgb.dot(luminance) + FLOOR * mean) * share);
                spread(&points, &sources, rest).iter().map(weight).collect()
            }
        };
        let values = DMatrix::from_fn(sight.points, 3, |i, c| blurred[i][c] * weights[i]);
        let energy_weight = if sight.surround.is_some() {
            ENERGY_WEIGHT / mass
        } else {
            0.0
        };
        Some(Self {
            blur: sight.blur,
            points,
            values,
            weights,
            energy: total * energy_weight,
            energy_weight,
        })
    }
}

/// Points spread evenly over the sphere (a Fibonacci spiral), each with the same solid angle.
fn sphere_points(count: usize) -> Vec<DVec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let point = |i: usize| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        let radius = (1.0 - y * y).sqrt();
        DVec3::new(radius * sin, y, radius * cos)
    };
    (0..count).map(point).collect()
}

/// Sum of point-like energies, each spread by an SRBF of the given bandwidth, at every point.
fn spread(points: &[DVec3], sources: &[(DVec3, DVec3)], bandwidth: f64) -> Vec<DVec3> {
    let kappa = 2.0 / (bandwidth * bandwidth);
    let at = |x: &DVec3| {
        let mut sum = DVec3::ZERO;
        for (direction, energy) in sources {
            let exponent = kappa * (direction.dot(*x) - 1.0);
            if exponent > NEGLIGIBLE / 2.0 {
                sum += *energy * exponent.exp();
            }
        }
        sum * peak(kappa)
    };
    points.par_iter().map(at).collect()
}
