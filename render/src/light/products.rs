//! Lobes as they look through the blur, and the sums over the points that a step of the refinement needs: of lobes with lobes, with
//! their derivatives and with the map.

use glam::DVec3;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::mixture::{Lobe, concentration, peak, resultant_length, resultant_slope};
use super::sight::{PATCH, Patch, Target, decay};

/// A lobe of unit integral after the blur, at concentration kappa'.
pub(super) struct Blurred {
    direction: DVec3,
    kappa: f64,
    peak: f64,
    /// d ln kappa' / d ln kappa.
    slope: f64,
    /// Two unit vectors across the direction.
    tangents: [DVec3; 2],
}

impl Blurred {
    /// `lobe` through a blur of that bandwidth, radians.
    pub fn new(lobe: &Lobe, blur: f64) -> Self {
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

    /// All of `lobes` through a blur.
    pub fn all(lobes: &[Lobe], blur: f64) -> Vec<Self> {
        lobes.iter().map(|lobe| Self::new(lobe, blur)).collect()
    }

    /// Values at the points of a patch, times `weights`; none where they are negligible.
    pub fn values(&self, patch: &Patch, weights: &[f32]) -> Option<[f32; PATCH]> {
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

    /// What the values at the points of a patch are multiplied by to become their derivatives.
    fn factors(&self, patch: &Patch) -> [[f32; PATCH]; MOVES] {
        // d/dt of kappa (d . x - 1) is kappa t . x; d ln C / d ln kappa = 1 - 2 kappa / (exp(2 kappa) - 1).
        let kappa = self.kappa as f32;
        let across = |tangent: DVec3| {
            patch
                .cosines(tangent.as_vec3())
                .map(|cosine| kappa * (cosine + 1.0))
        };
        let by_peak = (1.0 - 2.0 * self.kappa / (2.0 * self.kappa).min(700.0).exp_m1()) as f32;
        let slope = self.slope as f32;
        let wider = patch
            .cosines(self.direction.as_vec3())
            .map(|cosine| (kappa * cosine + by_peak) * slope);
        [across(self.tangents[0]), across(self.tangents[1]), wider]
    }
}

/// Patches whose sums are made between two calls of `go_on`.
const PATCHES_AT_ONCE: usize = 16;

/// Derivatives per lobe: along both tangents (radians) and by ln kappa.
pub(super) const MOVES: usize = 3;

/// Sums of what several lobes are with each other and with the map, over all points.
pub(super) struct Products {
    /// Z' Z for the values Z of K lobes.
    pub zz: DMatrix<f64>,
    /// Z' Y for the map Y, rgb.
    pub zy: DMatrix<f64>,
}

/// The same of derivatives D: every lobe's first move, then every lobe's second, then the third.
pub(super) struct Slopes {
    /// D' D.
    pub dd: DMatrix<f64>,
    /// D' Z.
    pub dz: DMatrix<f64>,
    /// D' Y.
    pub dy: DMatrix<f64>,
}

/// Those of the lobes that reach a patch, with their values there, a column each.
struct Seen {
    lobes: Vec<usize>,
    values: DMatrix<f64>,
}

/// The values of all lobes at all points.
pub(super) struct Values<'a> {
    target: &'a Target,
    count: usize,
    /// The lobes through the blur of every sight.
    blurred: Vec<Vec<Blurred>>,
    patches: Vec<Seen>,
}

impl<'a> Values<'a> {
    /// Evaluates the lobes wherever they are not negligible.
    pub fn new(target: &'a Target, lobes: &[Lobe]) -> Self {
        let blurred: Vec<Vec<Blurred>> = target
            .blurs
            .iter()
            .map(|blur| Blurred::all(lobes, *blur))
            .collect();
        let see = |(index, patch): (usize, &Patch)| {
            let weights = &target.weights[index * PATCH..][..PATCH];
            let (lobes, values): (Vec<usize>, Vec<[f32; PATCH]>) = blurred[patch.sight]
                .iter()
                .enumerate()
                .filter_map(|(k, lobe)| lobe.values(patch, weights).map(|values| (k, values)))
                .unzip();
            let values = DMatrix::from_iterator(
                PATCH,
                lobes.len(),
                values.iter().flatten().copied().map(f64::from),
            );
            Seen { lobes, values }
        };
        let patches = target.patches.par_iter().enumerate().map(see).collect();
        Self {
            target,
            count: lobes.len(),
            blurred,
            patches,
        }
    }

    /// Sums of values with values and with the map.
    pub fn products(&self) -> Products {
        let part = |(index, seen): (usize, &Seen)| {
            let transposed = seen.values.transpose();
            let zy = &transposed * self.target.values.rows(index * PATCH, PATCH);
            (transposed * &seen.values, zy)
        };
        let parts: Vec<_> = self.patches.par_iter().enumerate().map(part).collect();

        // Patches are added one after the other, so that sums do not depend on the number of threads.
        let count = self.count;
        let mut sum = Products {
            zz: DMatrix::zeros(count, count),
            zy: DMatrix::zeros(count, 3),
        };
        for (seen, (zz, zy)) in self.patches.iter().zip(&parts) {
            add(&mut sum.zz, zz, &seen.lobes, &seen.lobes, (0, 0));
            add(&mut sum.zy, zy, &seen.lobes, &[0, 1, 2], (0, 0));
        }
        sum
    }

    /// Sums of derivatives with derivatives, with values and with the map. `go_on` is asked before every few patches and ends the work with an
    /// error.
    pub fn slopes<E>(&self, go_on: impl Fn() -> Result<(), E>) -> Result<Slopes, E> {
        let part = |(index, seen): (usize, &Seen)| {
            let moves = self.moves(index, seen).map(|of_move| of_move.transpose());
            let target = self.target.values.rows(index * PATCH, PATCH);
            let dd = PAIRS.map(|(p, q)| &moves[p] * moves[q].transpose());
            (
                dd,
                moves.each_ref().map(|d| d * &seen.values),
                moves.each_ref().map(|d| d * target),
            )
        };

        let count = self.count;
        let mut sum = Slopes {
            dd: DMatrix::zeros(MOVES * count, MOVES * count),
            dz: DMatrix::zeros(MOVES * count, count),
            dy: DMatrix::zeros(MOVES * count, 3),
        };
        let numbered: Vec<(usize, &Seen)> = self.patches.iter().enumerate().collect();
        for patches in numbered.chunks(PATCHES_AT_ONCE) {
            go_on()?;
            let parts: Vec<_> = patches.par_iter().copied().map(part).collect();
            for ((_, Seen { lobes, .. }), (dd, dz, dy)) in patches.iter().zip(&parts) {
                for ((p, q), dd) in PAIRS.iter().zip(dd) {
                    add(&mut sum.dd, dd, lobes, lobes, (p * count, q * count));
                }
                for p in 0..MOVES {
                    add(&mut sum.dz, &dz[p], lobes, lobes, (p * count, 0));
                    add(&mut sum.dy, &dy[p], lobes, &[0, 1, 2], (p * count, 0));
                }
            }
        }
        sum.dd.fill_lower_triangle_with_upper_triangle();
        Ok(sum)
    }

    /// The derivatives at the points of a patch, one matrix a move, a column a lobe.
    fn moves(&self, index: usize, seen: &Seen) -> [DMatrix<f64>; MOVES] {
        let patch = &self.target.patches[index];
        let mut moves = std::array::from_fn(|_| seen.values.clone());
        for (column, k) in seen.lobes.iter().enumerate() {
            let lobe = &self.blurred[patch.sight][*k];
            for (of_move, factors) in moves.iter_mut().zip(lobe.factors(patch)) {
                for (value, factor) in of_move.column_mut(column).iter_mut().zip(factors) {
                    *value *= f64::from(factor);
                }
            }
        }
        moves
    }
}

/// Moves whose products are summed; the others are their mirror images.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Adds `part` to the given rows and columns of a block of `sum`.
fn add(
    sum: &mut DMatrix<f64>,
    part: &DMatrix<f64>,
    rows: &[usize],
    columns: &[usize],
    block: (usize, usize),
) {
    for (q, column) in columns.iter().enumerate() {
        let mut to = sum.column_mut(block.1 + column);
        for (row, value) in rows.iter().zip(part.column(q).iter()) {
            to[block.0 + row] += value;
        }
    }
}
