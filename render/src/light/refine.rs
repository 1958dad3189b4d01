//! Refinement of lobes: variable projection (Golub and Pereyra 1973, with Kaufman's derivative) in a Levenberg-Marquardt loop.
//!
//! What is minimised is the difference between lights and map, both blurred by an SRBF of 0.2 radians and relative to the local
//! brightness: hair sees light through lobes at least that wide and is judged relative to its own radiance. Energies are the
//! solution of a non-negative linear problem at every step; centres and concentrations are what the loop moves.

use glam::{DVec3, Vec3};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::mixture::{Lobe, concentration, peak, resultant_length, resultant_slope};
use super::nnls::{self, Solution};
use super::sight::{PATCH, Patch, Target, decay};

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

    /// Values at the points of a patch, times `weights`; none where they are negligible.
    fn values(&self, patch: &Patch, weights: &[f32]) -> Option<[f32; PATCH]> {
        let (direction, kappa) = (self.direction.as_vec3(), self.kappa as f32);
        if !patch.sees(direction, patch.horizon(kappa)) {
            return None;
        }
        let peak = self.peak as f32;
        let mut values = patch.cosines(direction);
        for (value, weight) in values.iter_mut().zip(weights) {
            *value = peak * weight * decay(kappa * *value);
        }
        Some(values)
    }
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
    solutions: Vec<Solution>,
    cost: f64,
}

/// Concentration of a lobe that is born: a bandwidth of 0.14 radians.
const BIRTH: f64 = 100.0;

/// Every this many points are tried as the place of a birth.
const BIRTH_STRIDE: usize = 3;

/// Derivatives per lobe: along both tangents (radians) and by ln kappa.
const MOVES: usize = 3;

/// Those of the lobes that reach a patch, with their values and derivatives there, a column each.
fn columns(patch: &Patch, weights: &[f32], blurred: &[Blurred]) -> (Vec<usize>, DMatrix<f64>) {
    let (lobes, values): (Vec<usize>, Vec<[f32; PATCH]>) = blurred
        .iter()
        .enumerate()
        .filter_map(|(k, lobe)| lobe.values(patch, weights).map(|values| (k, values)))
        .unzip();
    let mut z = DMatrix::zeros(PATCH, lobes.len() * (1 + MOVES));
    let mut fill = |column: usize, values: &[f32; PATCH], factors: &[f32; PATCH]| {
        for ((z, value), factor) in z.column_mut(column).iter_mut().zip(values).zip(factors) {
            *z = f64::from(value * factor);
        }
    };
    for (j, (k, values)) in lobes.iter().zip(&values).enumerate() {
        let lobe = &blurred[*k];
        let kappa = lobe.kappa as f32;
        fill(j, values, &[1.0; PATCH]);

        // d/dt of kappa (d . x - 1) is kappa t . x.
        let first = lobes.len() + MOVES * j;
        for (side, tangent) in lobe.tangents.iter().enumerate() {
            let factors = patch
                .cosines(tangent.as_vec3())
                .map(|cosine| kappa * (cosine + 1.0));
            fill(first + side, values, &factors);
        }

        // d ln C / d ln kappa = 1 - 2 kappa / (exp(2 kappa) - 1).
        let by_peak = (1.0 - 2.0 * lobe.kappa / (2.0 * lobe.kappa).min(700.0).exp_m1()) as f32;
        let slope = lobe.slope as f32;
        let factors = patch
            .cosines(lobe.direction.as_vec3())
            .map(|cosine| (kappa * cosine + by_peak) * slope);
        fill(first + 2, values, &factors);
    }
    (lobes, z)
}

impl Products {
    fn new(target: &Target, blurred: &[Blurred]) -> Self {
        let part = |(index, patch): (usize, &Patch)| {
            let weights = &target.weights[index * PATCH..][..PATCH];
            let (lobes, z) = columns(patch, weights, blurred);
            let transposed = z.transpose();
            let zy = &transposed * target.values.rows(index * PATCH, PATCH);
            (lobes, transposed * z, zy)
        };
        let parts: Vec<_> = target.patches.par_iter().enumerate().map(part).collect();

        // Patches are added one after the other, so that sums do not depend on the number of threads.
        let size = blurred.len() * (1 + MOVES);
        let mut sum = Self {
            zz: DMatrix::zeros(size, size),
            zy: DMatrix::zeros(size, 3),
        };
        for (lobes, zz, zy) in parts {
            let moves = lobes
                .iter()
                .flat_map(|k| (0..MOVES).map(move |p| blurred.len() + MOVES * k + p));
            let place: Vec<usize> = lobes.iter().copied().chain(moves).collect();
            for (q, to) in place.iter().enumerate() {
                let mut column = sum.zz.column_mut(*to);
                for (p, to) in place.iter().enumerate() {
                    column[*to] += zz[(p, q)];
                }
                for c in 0..3 {
                    sum.zy[(*to, c)] += zy[(q, c)];
                }
            }
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

/// How long to refine: steps of Levenberg-Marquardt before, between and after swaps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    pub before: usize,
    pub swaps: usize,
    pub per_swap: usize,
    pub after: usize,
}

/// Moves centres, concentrations and energies towards the least blurred relative residual; now and then the lobe that matters
/// least is put where the residual is largest, and stays there if that pays. `on_step` is told the share done and ends the work
/// with an error.
pub(super) fn refine<E>(
    target: &Target,
    lobes: Vec<Lobe>,
    range: (f64, f64),
    effort: Effort,
    on_step: impl Fn(f64) -> Result<(), E>,
) -> Result<Vec<Lobe>, E> {
    let total = effort.before + effort.swaps * (1 + effort.per_swap) + effort.after;
    let mut done = 0;
    let mut on_step = || {
        done += 1;
        on_step((done - 1) as f64 / total as f64)
    };
    let mut state = descend(
        target,
        State::new(target, lobes),
        range,
        effort.before,
        &mut on_step,
    )?;
    for _ in 0..effort.swaps {
        on_step()?;
        let swapped = State::new(target, swapped(target, &state));
        let swapped = descend(target, swapped, range, effort.per_swap, &mut on_step)?;
        if swapped.cost < state.cost {
            state = swapped;
        }
    }
    Ok(descend(target, state, range, effort.after, &mut on_step)?.lobes)
}

/// Steps of Levenberg-Marquardt.
fn descend<E>(
    target: &Target,
    mut state: State,
    range: (f64, f64),
    steps: usize,
    on_step: &mut impl FnMut() -> Result<(), E>,
) -> Result<State, E> {
    let mut damping = 1e-2;
    for _ in 0..steps {
        on_step()?;
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
    Ok(state)
}

/// The lobes with the least useful one put where a new one would help most.
fn swapped(target: &Target, state: &State) -> Vec<Lobe> {
    // What the cost rises by when a lobe goes is its squared energy over the diagonal of the inverse normal matrix.
    let mut use_of = vec![0.0; state.lobes.len()];
    for solution in &state.solutions {
        let Some(factor) = &solution.factor else { continue };
        let inverse = factor.inverse();
        for (j, k) in solution.free.iter().enumerate() {
            use_of[*k] += solution.x[*k] * solution.x[*k] / inverse[(j, j)];
        }
    }
    let weakest = (0..use_of.len())
        .min_by(|j, k| use_of[*j].total_cmp(&use_of[*k]))
        .unwrap_or(0);

    // What it falls by when one comes is its squared correlation with the residual, over the channels where that is positive.
    let residual = target.residual(&state.lobes);
    let born = |direction: DVec3| Lobe {
        direction,
        kappa: BIRTH,
        energy: DVec3::ONE,
        mass: 1.0,
    };
    let gain = |x: &DVec3| {
        let lobe = Blurred::new(&born(*x), target.blur);
        let (mut correlation, mut norm) = (Vec3::ZERO, 0.0);
        for (index, patch) in target.patches.iter().enumerate() {
            let points = index * PATCH..(index + 1) * PATCH;
            let Some(values) = lobe.values(patch, &target.weights[points.clone()]) else {
                continue;
            };
            for (value, residual) in values.iter().zip(&residual[points]) {
                correlation += *residual * *value;
                norm += value * value;
            }
        }
        f64::from(correlation.max(Vec3::ZERO).length_squared() / norm)
    };
    let candidates: Vec<DVec3> = target.patches.iter().flat_map(candidates).collect();
    let gains: Vec<f64> = candidates.par_iter().map(gain).collect();
    let best = (0..gains.len())
        .max_by(|i, j| gains[*i].total_cmp(&gains[*j]))
        .unwrap_or(0);

    let mut lobes = state.lobes.clone();
    lobes[weakest] = born(candidates[best]);
    lobes
}

/// The points of a patch that are tried as the place of a birth.
fn candidates(patch: &Patch) -> impl Iterator<Item = DVec3> {
    let point = |i| {
        Vec3::new(patch.x[i], patch.y[i], patch.z[i])
            .as_dvec3()
            .normalize()
    };
    (0..PATCH).step_by(BIRTH_STRIDE).map(point)
}

impl Target {
    /// Weighted difference of map and lobes at the points, rgb.
    fn residual(&self, lobes: &[Lobe]) -> Vec<Vec3> {
        let blurred: Vec<(Blurred, Vec3)> = lobes
            .iter()
            .map(|lobe| (Blurred::new(lobe, self.blur), lobe.energy.as_vec3()))
            .collect();
        let at = |(index, patch): (usize, &Patch)| {
            let points = index * PATCH..(index + 1) * PATCH;
            let wanted = |i: usize| DVec3::from_array(std::array::from_fn(|c| self.values[(i, c)])).as_vec3();
            let mut residual: Vec<Vec3> = points.clone().map(wanted).collect();
            for (lobe, energy) in &blurred {
                let values = lobe.values(patch, &self.weights[points.clone()]);
                for (residual, value) in residual.iter_mut().zip(values.iter().flatten()) {
                    *residual -= *energy * *value;
                }
            }
            residual
        };
        let parts: Vec<Vec<Vec3>> = self.patches.par_iter().enumerate().map(at).collect();
        parts.concat()
    }
}
