//! The map's energy as a mixture of von Mises-Fisher lobes, by expectation maximisation (Banerjee 2005): fast, exact in energy, and a good start.
//!
//! A vMF density is C(kappa) exp(kappa (w . d - 1)), C = kappa / (2 pi (1 - exp(-2 kappa))): an SRBF of unit integral with
//! kappa = 2 / lambda^2.

use std::f64::consts::TAU;

use glam::DVec3;
use rand::Rng;
use rayon::prelude::*;

use super::cells::Cell;

/// Cells that one task takes; fixed, so that sums do not depend on the number of threads.
const CELLS_PER_TASK: usize = 512;

/// One light while it is fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// Unit vector to the centre.
    pub direction: DVec3,
    /// Concentration kappa = 2 / lambda^2.
    pub kappa: f64,
    /// Integral of the light over the sphere, linear Rec.709, not negative.
    pub energy: DVec3,
    /// Integral of its luminance.
    pub mass: f64,
}

/// C(kappa): the peak of a lobe of unit integral.
pub(super) fn peak(kappa: f64) -> f64 {
    kappa / (-TAU * (-2.0 * kappa).exp_m1())
}

/// Adds centres to the given lobes until there are `count`, each with a probability proportional to mass times squared distance
/// from those that are there (Arthur and Vassilvitskii 2007).
pub(super) fn seed(
    cells: &[Cell],
    mut lobes: Vec<Lobe>,
    count: usize,
    range: (f64, f64),
    random: &mut impl Rng,
) -> Vec<Lobe> {
    let nearest = |cell: &Cell| {
        lobes
            .iter()
            .map(|lobe| 1.0 - cell.mean.dot(lobe.direction))
            .fold(2.0, f64::min)
    };
    let mut distance: Vec<f64> = cells.iter().map(nearest).collect();
    let mean_mass = cells.iter().map(|cell| cell.mass).sum::<f64>() / count as f64;
    while lobes.len() < count {
        let mut total = 0.0;
        let running = |(cell, distance): (&Cell, &f64)| {
            total += cell.mass * distance;
            total
        };
        let sums: Vec<f64> = cells.iter().zip(&distance).map(running).collect();
        let target = random.random::<f64>() * total;
        let chosen = sums.partition_point(|sum| *sum <= target).min(cells.len() - 1);
        let direction = cells[chosen].mean.normalize_or(DVec3::Y);
        for (distance, cell) in distance.iter_mut().zip(cells) {
            *distance = distance.min(1.0 - cell.mean.dot(direction));
        }
        lobes.push(Lobe {
            direction,
            kappa: count as f64,
            energy: DVec3::ZERO,
            mass: mean_mass,
        });
    }
    for lobe in &mut lobes {
        lobe.kappa = lobe.kappa.clamp(range.0, range.1);
    }
    lobes
}

/// What one lobe is responsible for.
#[derive(Clone, Copy)]
struct Share {
    energy: DVec3,
    mass: f64,
    resultant: DVec3,
}

const NOTHING: Share = Share {
    energy: DVec3::ZERO,
    mass: 0.0,
    resultant: DVec3::ZERO,
};

/// One step of expectation maximisation; concentrations stay in `range`. Lobes that nothing belongs to keep their place with no energy.
pub(super) fn step(cells: &[Cell], lobes: &mut [Lobe], range: (f64, f64)) {
    let factors: Vec<f64> = lobes
        .iter()
        .map(|lobe| (lobe.mass * peak(lobe.kappa)).max(f64::MIN_POSITIVE).ln())
        .collect();
    let share_out = |cells: &[Cell]| {
        let mut shares = vec![NOTHING; lobes.len()];
        let mut responsibility = vec![0.0; lobes.len()];
        for cell in cells {
            // The expected log density of a lobe over a cell is linear in the cell's mean direction.
            let mut best = f64::NEG_INFINITY;
            for ((value, lobe), factor) in responsibility.iter_mut().zip(lobes.iter()).zip(&factors) {
                *value = factor + lobe.kappa * (lobe.direction.dot(cell.mean) - 1.0);
                best = best.max(*value);
            }
            let mut total = 0.0;
            for value in &mut responsibility {
                *value = if *value < best - 40.0 {
                    0.0
                } else {
                    (*value - best).exp()
                };
                total += *value;
            }
            for (share, value) in shares.iter_mut().zip(&responsibility) {
                if *value > 0.0 {
                    let part = value / total;
                    share.energy += cell.energy * part;
                    share.mass += cell.mass * part;
                    share.resultant += cell.mean * (cell.mass * part);
                }
            }
        }
        shares
    };
    let tasks: Vec<Vec<Share>> = cells.par_chunks(CELLS_PER_TASK).map(share_out).collect();

    for (k, lobe) in lobes.iter_mut().enumerate() {
        let mut sum = NOTHING;
        for share in tasks.iter().map(|task| task[k]) {
            sum.energy += share.energy;
            sum.mass += share.mass;
            sum.resultant += share.resultant;
        }
        (lobe.energy, lobe.mass) = (sum.energy, sum.mass);
        let length = sum.resultant.length();
        if sum.mass > 0.0 && length > 0.0 {
            lobe.direction = sum.resultant / length;
            lobe.kappa = concentration((length / sum.mass).min(1.0)).clamp(range.0, range.1);
        }
    }
}

/// A_3(kappa) = coth kappa - 1 / kappa: mean resultant length of a lobe.
pub(super) fn resultant_length(kappa: f64) -> f64 {
    if kappa < 1e-3 {
        kappa / 3.0
    } else {
        1.0 / kappa.tanh() - 1.0 / kappa
    }
}

/// Derivative of A_3.
pub(super) fn resultant_slope(kappa: f64) -> f64 {
    if kappa < 1e-2 {
        return 1.0 / 3.0 - kappa * kappa / 15.0;
    }
    let sinh = kappa.min(300.0).sinh();
    1.0 / (kappa * kappa) - 1.0 / (sinh * sinh)
}

/// The concentration whose mean resultant length is `length`: Banerjee's guess and three Newton steps.
pub(super) fn concentration(length: f64) -> f64 {
    let length = length.min(1.0 - 1e-9);
    let mut kappa = length * (3.0 - length * length) / (1.0 - length * length);
    for _ in 0..3 {
        kappa = (kappa - (resultant_length(kappa) - length) / resultant_slope(kappa)).max(1e-9);
    }
    kappa
}
