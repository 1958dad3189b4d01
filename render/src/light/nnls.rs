//! Least squares with non-negative unknowns, from the normal equations (Lawson and Hanson 1974, chapter 23; Bro and de Jong 1997).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A solution with what the caller needs to differentiate it.
pub(super) struct Solution {
    /// The unknowns, none below zero.
    pub x: DVector<f64>,
    /// Indices of the unknowns that are free, i.e. positive.
    pub free: Vec<usize>,
    /// Factor of the normal matrix over the free unknowns; none where none is free.
    pub factor: Option<Cholesky<f64, Dyn>>,
}

/// Minimises x' G x - 2 b' x over x >= 0. `free` is a guess of the positive unknowns, such as those of a nearby problem.
pub(super) fn solve(g: &DMatrix<f64>, b: &DVector<f64>, free: &[bool]) -> Solution {
    let n = b.len();
    let mut is_free = free.to_vec();
    let mut x = DVector::zeros(n);
    let tolerance = 1e-10 * b.amax();

    // Each round frees the unknown with the steepest descent; the bound only guards against rounding that cycles.
    let mut factor = settle(g, b, &mut is_free, &mut x);
    for _ in 0..3 * n {
        let descent = b - g * &x;
        let steepest = (0..n)
            .filter(|k| !is_free[*k])
            .max_by(|j, k| descent[*j].total_cmp(&descent[*k]));
        let Some(steepest) = steepest.filter(|k| descent[*k] > tolerance) else {
            break;
        };
        is_free[steepest] = true;
        let next = settle(g, b, &mut is_free, &mut x);
        if !is_free[steepest] {
            break;
        }
        factor = next;
    }
    let free = (0..n).filter(|k| is_free[*k]).collect();
    Solution { x, free, factor }
}

/// Solves over the free unknowns and fixes those that would fall below zero, until none does.
fn settle(
    g: &DMatrix<f64>,
    b: &DVector<f64>,
    is_free: &mut [bool],
    x: &mut DVector<f64>,
) -> Option<Cholesky<f64, Dyn>> {
    loop {
        let free: Vec<usize> = (0..b.len()).filter(|k| is_free[*k]).collect();
        if free.is_empty() {
            x.fill(0.0);
            return None;
        }
        let part = DMatrix::from_fn(free.len(), free.len(), |i, j| g[(free[i], free[j])]);
        let Some(factor) = part.cholesky() else {
            // Two lights on top of each other: the weaker diagonal goes.
            let weakest = free
                .iter()
                .copied()
                .min_by(|j, k| g[(*j, *j)].total_cmp(&g[(*k, *k)]))?;
            is_free[weakest] = false;
            continue;
        };
        let solved = factor.solve(&DVector::from_fn(free.len(), |i, _| b[free[i]]));

        // The largest step towards the solution that keeps every unknown at zero or above.
        let blocking = |(value, k): (&f64, &usize)| {
            (*value <= 0.0).then(|| (x[*k] / (x[*k] - value).max(f64::MIN_POSITIVE), *k))
        };
        let blocked: Vec<(f64, usize)> = solved.iter().zip(&free).filter_map(blocking).collect();
        if blocked.is_empty() {
            x.fill(0.0);
            for (value, k) in solved.iter().zip(&free) {
                x[*k] = *value;
            }
            return Some(factor);
        }
        let step = blocked.iter().map(|(step, _)| *step).fold(1.0, f64::min);
        for (value, k) in solved.iter().zip(&free) {
            x[*k] = (x[*k] + step * (value - x[*k])).max(0.0);
        }
        for (limit, k) in blocked {
            if limit <= step {
                is_free[k] = false;
                x[k] = 0.0;
            }
        }
    }
}
