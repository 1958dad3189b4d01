//! Refinement of lobes: variable projection (Golub and Pereyra 1973, with Kaufman's derivative) in a Levenberg-Marquardt loop.
//!
//! What is minimised is the difference between lights and map, both blurred by an SRBF of 0.2 radians and relative to the local
//! brightness: hair sees light through lobes at least that wide and is judged relative to its own radiance. Energies are the
//! solution of a non-negative linear problem at every step; centres and concentrations are what the loop moves.

use std::f64::consts::PI;

use glam::DVec3;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::cells::Cell;
use super::mixture::{Lobe, concentration, peak, resultant_length, resultant_slope};
use super::nnls::{self, Solution};

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

/// Points that one task takes; fixed, so that sums do not depend on the number of threads.
const POINTS_PER_TASK: usize = 192;

/// Weight of the relative error of the whole map's energy beside the RMS of the residual.
const ENERGY_WEIGHT: f64 = 3.0;

/// Exponent below which a lobe counts as zero.
const NEGLIGIBLE: f64 = -30.0;

/// A lobe of unit integral after the blur, at concentration kappa'.
struct Blurred {
    direction: DVec3,
    kappa: f64,
    peak: f64,
    /// d ln kappa' / d ln kappa.
    slope: f64,
    /// Two unit vectors across the direction.
    tangents: [DVec3; 2],
}

impl Blurred {
    fn new(lobe: &Lobe, blur: f64) -> Self {
        // Blurring multiplies the mean resultant lengths of light and blur.
        let blur = resultant_length(2.0 / (blur * blur));
        let kappa = concentration(resultant_length(lobe.kappa) * blur);
        let slope = resultant_slope(lobe.kappa) * blur / resultant_slope(kappa) * lobe.kappa / kappa;
        let (s, t) = lobe.direction.any_orthonormal_pair();
        Self {
            direction: lobe.direction,
            kappa,
            peak: peak(kappa),
            slope,
            tangents: [s, t],
        }
    }

    /// Value at `x`, and the factor of its derivative by ln kappa.
    fn value(&self, x: DVec3) -> (f64, f64) {
        let exponent = self.kappa * (self.direction.dot(x) - 1.0);
        if exponent < NEGLIGIBLE {
            return (0.0, 0.0);
        }
        // d ln C / d ln kappa = 1 - 2 kappa / (exp(2 kappa) - 1).
        let by_peak = 1.0 - 2.0 * self.kappa / (2.0 * self.kappa).min(700.0).exp_m1();
        (self.peak * exponent.exp(), (exponent + by_peak) * self.slope)
    }
}

/// The blurred map at the points, and the weights of the residual there.
pub(super) struct Target {
    blur: f64,
    points: Vec<DVec3>,
    /// Weighted values of the blurred map, rgb after each other in columns.
    values: DMatrix<f64>,
    weights: Vec<f64>,
    /// Integral of the map, rgb, times the weight of the energy row.
    energy: DVec3,
    energy_weight: f64,
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
        let energy_weight = ENERGY_WEIGHT / mass;
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

/// All products of values, derivatives and target that one step needs.
struct Products {
    /// Z' Z for Z = [values of K lobes | 3 K derivatives].
    zz: DMatrix<f64>,
    /// Z' Y for the target Y, rgb.
    zy: DMatrix<f64>,
}

/// The lobes with their best energies and what that costs.
struct State {
    lobes: Vec<Lobe>,
    products: Products,
    gram: DMatrix<f64>,
    solutions: Vec<Solution>,
    cost: f64,
}

/// Derivatives per lobe: along both tangents (radians) and by ln kappa.
const MOVES: usize = 3;

/// Values (and derivatives) of the blurred lobes at some points, one column a point, weighted.
fn columns(target: &Target, range: std::ops::Range<usize>, blurred: &[Blurred]) -> DMatrix<f64> {
    let count = blurred.len();
    let mut z = DMatrix::zeros(count * (1 + MOVES), range.len());
    for (mut column, i) in z.column_iter_mut().zip(range) {
        let (x, weight) = (target.points[i], target.weights[i]);
        for (k, lobe) in blurred.iter().enumerate() {
            let (value, by_ln_kappa) = lobe.value(x);
            if value == 0.0 {
                continue;
            }
            let value = value * weight;
            column[k] = value;
            let row = count + MOVES * k;
            column[row] = value * lobe.kappa * lobe.tangents[0].dot(x);
            column[row + 1] = value * lobe.kappa * lobe.tangents[1].dot(x);
            column[row + 2] = value * by_ln_kappa;
        }
    }
    z
}

impl Products {
    fn new(target: &Target, blurred: &[Blurred]) -> Self {
        let starts: Vec<usize> = (0..target.points.len()).step_by(POINTS_PER_TASK).collect();
        let part = |start: &usize| {
            let z = columns(target, *start..*start + POINTS_PER_TASK, blurred);
            let zy = &z * target.values.rows(*start, POINTS_PER_TASK);
            (&z * z.transpose(), zy)
        };
        let parts: Vec<(DMatrix<f64>, DMatrix<f64>)> = starts.par_iter().map(part).collect();
        let size = blurred.len() * (1 + MOVES);
        let mut sum = Self {
            zz: DMatrix::zeros(size, size),
            zy: DMatrix::zeros(size, 3),
        };
        for (zz, zy) in parts {
            sum.zz += zz;
            sum.zy += zy;
        }
        sum
    }
}

impl State {
    fn new(target: &Target, mut lobes: Vec<Lobe>) -> Self {
        let blurred: Vec<Blurred> = lobes.iter().map(|lobe| Blurred::new(lobe, target.blur)).collect();
        let products = Products::new(target, &blurred);
        let count = lobes.len();

        // The row of the energy sees every lobe with its unit integral; a trace of ridge separates lobes that coincide.
        let mut gram = products.zz.view((0, 0), (count, count)).into_owned();
        gram.add_scalar_mut(target.energy_weight * target.energy_weight);
        let ridge = 1e-9 * gram.trace() / count as f64;
        for k in 0..count {
            gram[(k, k)] += ridge;
        }

        let mut cost = 0.0;
        let mut solutions = Vec::with_capacity(3);
        for c in 0..3 {
            let y = target.energy[c];
            let b = products
                .zy
                .view((0, c), (count, 1))
                .column(0)
                .add_scalar(target.energy_weight * y);
            let free: Vec<bool> = lobes.iter().map(|lobe| lobe.energy[c] > 0.0).collect();
            let solution = nnls::solve(&gram, &b, &free);
            let yy = target.values.column(c).norm_squared() + y * y;
            cost += yy - 2.0 * b.dot(&solution.x) + (&gram * &solution.x).dot(&solution.x);
            for (lobe, energy) in lobes.iter_mut().zip(solution.x.iter()) {
                lobe.energy[c] = *energy;
            }
            solutions.push(solution);
        }
        Self {
            lobes,
            products,
            gram,
            solutions,
            cost,
        }
    }

    /// Gauss-Newton matrix and gradient by centres and ln kappa, energies projected out.
    fn normal_equations(&self) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.lobes.len();
        let moves = count * MOVES;
        let dd = self.products.zz.view((count, count), (moves, moves));
        let mut matrix = DMatrix::zeros(moves, moves);
        let mut gradient = DVector::zeros(moves);
        for (c, solution) in self.solutions.iter().enumerate() {
            let d_phi = self.products.zz.view((count, 0), (moves, count));
            let error = d_phi * &solution.x - self.products.zy.view((count, c), (moves, 1));

            // D' (1 - Phi G^-1 Phi') D, over the lobes that are lit in this channel.
            let mut projected = dd.into_owned();
            if let Some(factor) = &solution.factor {
                let phi_d = DMatrix::from_fn(solution.free.len(), moves, |j, p| d_phi[(p, solution.free[j])]);
                let half = factor.l_dirty().solve_lower_triangular(&phi_d);
                if let Some(half) = half {
                    projected -= half.transpose() * &half;
                }
            }
            for p in 0..moves {
                let a = solution.x[p / MOVES];
                gradient[p] += a * error[p];
                for q in 0..moves {
                    matrix[(q, p)] += a * solution.x[q / MOVES] * projected[(q, p)];
                }
            }
        }
        (matrix, gradient)
    }
}

/// Lobes moved by a step in the tangents and ln kappa, each part held to a sensible size.
fn moved(lobes: &[Lobe], step: &DVector<f64>, blur: f64, range: (f64, f64)) -> Vec<Lobe> {
    let one = |(k, lobe): (usize, &Lobe)| {
        let (s, t) = lobe.direction.any_orthonormal_pair();
        let mut shift = s * step[MOVES * k] + t * step[MOVES * k + 1];
        let reach = 0.5 * (2.0 / lobe.kappa + blur * blur).sqrt();
        shift = shift.clamp_length_max(reach);
        let kappa = (lobe.kappa * step[MOVES * k + 2].clamp(-0.7, 0.7).exp()).clamp(range.0, range.1);
        Lobe {
            direction: (lobe.direction + shift).normalize(),
            kappa,
            ..*lobe
        }
    };
    lobes.iter().enumerate().map(one).collect()
}

/// Moves centres, concentrations and energies towards the least blurred relative residual; `on_step` is told the share done and
/// ends the work with an error.
pub(super) fn refine<E>(
    target: &Target,
    lobes: Vec<Lobe>,
    range: (f64, f64),
    steps: usize,
    on_step: impl Fn(f64) -> Result<(), E>,
) -> Result<Vec<Lobe>, E> {
    let mut state = State::new(target, lobes);
    let mut damping = 1e-2;
    for step in 0..steps {
        on_step(step as f64 / steps as f64)?;
        let (mut matrix, gradient) = state.normal_equations();
        let least = 1e-12 * matrix.diagonal().amax();
        for p in 0..gradient.len() {
            matrix[(p, p)] += damping * matrix[(p, p)] + least;
        }
        let Some(factor) = matrix.cholesky() else {
            damping *= 10.0;
            continue;
        };
        let next = State::new(
            target,
            moved(&state.lobes, &-factor.solve(&gradient), target.blur, range),
        );
        if next.cost < state.cost {
            state = next;
            damping = (damping / 4.0).max(1e-7);
        } else {
            damping *= 6.0;
        }
    }
    Ok(state.lobes)
}
