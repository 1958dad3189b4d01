//! Refinement of lobes: variable projection (Golub and Pereyra 1973, with Kaufman's derivative) in a Levenberg-Marquardt loop.
//!
//! What is minimised is the difference between lights and map, both blurred as hair's lobes blur them (see `sight`) and relative to
//! the local brightness: hair is judged relative to its own radiance. Energies are the solution of a non-negative linear problem at every step; centres and concentrations are what the loop moves.

use std::cell::Cell;

use glam::{DVec3, Vec3};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::mixture::Lobe;
use super::nnls::{self, Solution};
use super::products::{Blurred, Products, Slopes, Values};
use super::sight::{PATCH, Patch, Target};

/// The lobes with their best energies and what that costs.
struct State<'a> {
    lobes: Vec<Lobe>,
    values: Values<'a>,
    solutions: Vec<Solution>,
    cost: f64,
}

/// Concentration of a lobe that is born, a bandwidth of 0.045 radians: what is missing is narrow more often than wide.
const BIRTH: f64 = 1000.0;

/// Every this many points are tried as the place of a birth.
const BIRTH_STRIDE: usize = 3;

impl<'a> State<'a> {
    fn new(target: &'a Target, mut lobes: Vec<Lobe>) -> Self {
        let values = Values::new(target, &lobes);
        let Products { zz: mut gram, zy } = values.products();
        let count = lobes.len();

        // The row of the energy sees every lobe with its unit integral; a trace of ridge separates lobes that coincide.
        gram.add_scalar_mut(target.energy_weight * target.energy_weight);
        let ridge = 1e-9 * gram.trace() / count as f64;
        for k in 0..count {
            gram[(k, k)] += ridge;
        }

        let mut cost = 0.0;
        let mut solutions = Vec::with_capacity(3);
        for c in 0..3 {
            let y = target.energy[c];
            let b = zy.column(c).add_scalar(target.energy_weight * y);
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
            values,
            solutions,
            cost,
        }
    }

    /// Gauss-Newton matrix and gradient by centres and ln kappa, energies projected out.
    /// `go_on` is asked before every costly part.
    fn normal_equations<E>(
        &self,
        go_on: impl Fn() -> Result<(), E>,
    ) -> Result<(DMatrix<f64>, DVector<f64>), E> {
        let Slopes { dd, dz, dy } = self.values.slopes(&go_on)?;
        let (moves, count) = dz.shape();
        let of_channel = |(c, solution): (usize, &Solution)| {
            let amplitudes = DVector::from_fn(moves, |p, _| solution.x[p % count]);
            let gradient = (&dz * &solution.x - dy.column(c)).component_mul(&amplitudes);

            // D' (1 - Phi G^-1 Phi') D, over the lobes that are lit in this channel.
            let mut matrix = dd.clone();
            for (p, mut column) in matrix.column_iter_mut().enumerate() {
                column.component_mul_assign(&amplitudes);
                column *= amplitudes[p];
            }
            let half = solution.factor.as_ref().and_then(|factor| {
                let phi_d = DMatrix::from_fn(solution.free.len(), moves, |j, p| {
                    dz[(p, solution.free[j])] * amplitudes[p]
                });
                factor.l_dirty().solve_lower_triangular(&phi_d)
            });
            if let Some(half) = half {
                matrix.gemm(-1.0, &half.transpose(), &half, 1.0);
            }
            (matrix, gradient)
        };
        go_on()?;
        let channels: Vec<_> = self.solutions.par_iter().enumerate().map(of_channel).collect();
        go_on()?;
        let zero = (DMatrix::zeros(moves, moves), DVector::zeros(moves));
        Ok(channels
            .into_iter()
            .fold(zero, |sum, channel| (sum.0 + channel.0, sum.1 + channel.1)))
    }
}

/// Lobes moved by a step in the tangents and ln kappa, each part held to a sensible size.
fn moved(lobes: &[Lobe], step: &DVector<f64>, blur: f64, range: (f64, f64)) -> Vec<Lobe> {
    let one = |(k, lobe): (usize, &Lobe)| {
        let (s, t) = lobe.direction.any_orthonormal_pair();
        let mut shift = s * step[k] + t * step[lobes.len() + k];
        let reach = 0.5 * (2.0 / lobe.kappa + blur * blur).sqrt();
        shift = shift.clamp_length_max(reach);
        let kappa = (lobe.kappa * step[2 * lobes.len() + k].clamp(-0.7, 0.7).exp()).clamp(range.0, range.1);
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
    /// Most rounds of all this; a map that changed beyond recognition needs more than one.
    pub rounds: usize,
    /// A swap must bring the squared residual below this share of what it was.
    pub worth_a_swap: f64,
}

impl Effort {
    /// Most calls of `on_step` in a round: a step has derivatives and an evaluation, a swap a birth and an evaluation.
    fn steps(&self) -> usize {
        2 * (self.before + self.swaps * (1 + self.per_swap) + self.after)
    }
}

/// Mean squared relative residual of the given lights from which on a map counts as another one, not as the next of a sequence.
const BEYOND_RECOGNITION: f64 = 0.1;

/// Another round follows one that left less than this share of the squared residual of such a map, and more than a good fit leaves.
const WORTH_ANOTHER: f64 = 0.3;
const GOOD: f64 = 1e-3;

/// How often the costly parts of a fit were done; equal on every machine, unlike time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Lights evaluated at all points with the energies that suit them best.
    pub evaluations: usize,
    /// Derivatives of all lights by direction and width at all points.
    pub derivatives: usize,
    /// Searches for the best place of a new light.
    pub births: usize,
}

/// Moves centres, concentrations and energies towards the least blurred relative residual; now and then the lobe that matters
/// least is put where the residual is largest, and stays there if that pays. `on_step` is told the share done and ends the work
/// with an error; between two calls is one evaluation, one of derivatives or one birth.
pub(super) fn refine<E>(
    target: &Target,
    lobes: Vec<Lobe>,
    range: (f64, f64),
    effort: Effort,
    on_step: impl Fn(f64) -> Result<(), E>,
) -> Result<(Vec<Lobe>, Work), E> {
    let total = (effort.rounds * effort.steps()) as f64;
    let done = Cell::new(0);
    let mut refinement = Refinement {
        target,
        range,
        on_step: |steps| on_step(f64::from(done.replace(done.get() + steps)) / total),
        work: Work::default(),
    };
    let mut state = refinement.evaluated(lobes);
    let given = state.cost;
    for _ in 0..effort.rounds {
        let before = state.cost;
        state = refinement.round(state, effort)?;
        if given < BEYOND_RECOGNITION || state.cost > WORTH_ANOTHER * before || state.cost < GOOD {
            break;
        }
    }
    Ok((state.lobes, refinement.work))
}

/// A refinement under way.
struct Refinement<'a, F> {
    target: &'a Target,
    range: (f64, f64),
    /// Asked before every costly part, with the steps that it is (0 within one).
    on_step: F,
    work: Work,
}

impl<'a, E, F: Fn(u32) -> Result<(), E>> Refinement<'a, F> {
    fn evaluated(&mut self, lobes: Vec<Lobe>) -> State<'a> {
        self.work.evaluations += 1;
        State::new(self.target, lobes)
    }

    fn round(&mut self, state: State<'a>, effort: Effort) -> Result<State<'a>, E> {
        let mut state = self.descend(state, effort.before)?;
        // Where a birth did not pay: the state is the same, so another place is tried.
        let mut barren = Vec::new();
        for _ in 0..effort.swaps {
            (self.on_step)(1)?;
            self.work.births += 1;
            let (lobes, place) = swapped(self.target, &state, &barren);
            (self.on_step)(1)?;
            let swapped = self.evaluated(lobes);
            let swapped = self.descend(swapped, effort.per_swap)?;
            if swapped.cost < effort.worth_a_swap * state.cost {
                state = swapped;
                barren.clear();
            } else {
                barren.push(place);
            }
        }
        self.descend(state, effort.after)
    }

    /// Steps of Levenberg-Marquardt.
    fn descend(&mut self, mut state: State<'a>, steps: usize) -> Result<State<'a>, E> {
        let finest = self.target.blurs.iter().copied().fold(f64::INFINITY, f64::min);
        let mut damping = 1e-2;
        let mut equations = None;
        for _ in 0..steps {
            if equations.is_none() {
                (self.on_step)(1)?;
                self.work.derivatives += 1;
                equations = Some(state.normal_equations(|| (self.on_step)(0))?);
            }
            let Some((matrix, gradient)) = &equations else {
                break;
            };
            let mut matrix = matrix.clone();
            let least = 1e-12 * matrix.diagonal().amax();
            for p in 0..gradient.len() {
                matrix[(p, p)] += damping * matrix[(p, p)] + least;
            }
            let Some(factor) = matrix.cholesky() else {
                damping *= 10.0;
                continue;
            };
            let step = -factor.solve(gradient);
            (self.on_step)(1)?;
            let next = self.evaluated(moved(&state.lobes, &step, finest, self.range));
            if next.cost < state.cost {
                state = next;
                equations = None;
                damping = (damping / 4.0).max(1e-7);
            } else {
                damping *= 6.0;
            }
        }
        Ok(state)
    }
}

/// The lobes with the least useful one put where a new one would help most, away from `barren` places; and that place.
fn swapped(target: &Target, state: &State, barren: &[DVec3]) -> (Vec<Lobe>, DVec3) {
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
        let lobe = born(*x);
        let lobes: Vec<Blurred> = target
            .blurs
            .iter()
            .map(|blur| Blurred::new(&lobe, *blur))
            .collect();
        let (mut correlation, mut norm) = (Vec3::ZERO, 0.0);
        for (index, patch) in target.patches.iter().enumerate() {
            let points = index * PATCH..(index + 1) * PATCH;
            let Some(values) = lobes[patch.sight].values(patch, &target.weights[points.clone()]) else {
                continue;
            };
            for (value, residual) in values.iter().zip(&residual[points]) {
                correlation += *residual * *value;
                norm += value * value;
            }
        }
        f64::from(correlation.max(Vec3::ZERO).length_squared() / norm)
    };
    let first_sight = target.patches.iter().filter(|patch| patch.sight == 0);
    let candidates: Vec<DVec3> = first_sight
        .flat_map(candidates)
        .filter(|x| !barren.contains(x))
        .collect();
    let gains: Vec<f64> = candidates.par_iter().map(gain).collect();
    let best = (0..gains.len())
        .max_by(|i, j| gains[*i].total_cmp(&gains[*j]))
        .unwrap_or(0);

    let mut lobes = state.lobes.clone();
    lobes[weakest] = born(candidates[best]);
    (lobes, candidates[best])
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
        let blurred: Vec<Vec<Blurred>> = self.blurs.iter().map(|blur| Blurred::all(lobes, *blur)).collect();
        let energies: Vec<Vec3> = lobes.iter().map(|lobe| lobe.energy.as_vec3()).collect();
        let at = |(index, patch): (usize, &Patch)| {
            let points = index * PATCH..(index + 1) * PATCH;
            let wanted = |i: usize| DVec3::from_array(std::array::from_fn(|c| self.values[(i, c)])).as_vec3();
            let mut residual: Vec<Vec3> = points.clone().map(wanted).collect();
            for (lobe, energy) in blurred[patch.sight].iter().zip(&energies) {
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
