//! A curve from (0, y) to (1, y) through a few points, without overshoot: how a gradient rises.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::problem::{Problem, within};

/// Points of a curve from x = 0 to x = 1, each y in [0, 1]; between them a monotone cubic.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Curve(pub Vec<[f32; 2]>);

/// Points above this number are refused.
const MAX_POINTS: usize = 16;

impl Default for Curve {
    /// Slow at both ends.
    fn default() -> Self {
        Self(vec![[0.0, 0.0], [0.25, 0.12], [0.75, 0.88], [1.0, 1.0]])
    }
}

impl Curve {
    /// The straight line.
    pub fn linear() -> Self {
        Self(vec![[0.0, 0.0], [1.0, 1.0]])
    }

    /// Checks order and range of the points.
    ///
    /// # Errors
    /// Names the point.
    pub fn check(&self, place: &str) -> Result<(), Problem> {
        let points = &self.0;
        if !(2..=MAX_POINTS).contains(&points.len()) {
            return Err(Problem::at(
                place,
                format!("{} points", points.len()),
                format!("give 2 to {MAX_POINTS} points"),
            ));
        }
        for (i, [x, y]) in points.iter().enumerate() {
            within(&format!("{place}[{i}]"), *x, 0.0..=1.0)?;
            within(&format!("{place}[{i}]"), *y, 0.0..=1.0)?;
        }
        let rises = points.windows(2).all(|w| w[0][0] < w[1][0]);
        if rises && points[0][0] == 0.0 && points[points.len() - 1][0] == 1.0 {
            return Ok(());
        }
        Err(Problem::at(
            place,
            "the points do not go from x = 0 to x = 1 in ascending order",
            "sort them by x, the first at 0, the last at 1",
        ))
    }

    /// The curve's value at `x`, held outside [0, 1]. Slopes are limited as in Fritsch and Carlson 1980, so that the curve
    /// stays between neighbouring points.
    pub fn at(&self, x: f32) -> f32 {
        let points = &self.0;
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return 0.0;
        };
        if x <= first[0] {
            return first[1];
        }
        if x >= last[0] {
            return last[1];
        }
        let i = points.partition_point(|p| p[0] <= x).clamp(1, points.len() - 1);
        let ([x0, y0], [x1, y1]) = (points[i - 1], points[i]);
        let width = x1 - x0;
        let t = (x - x0) / width;
        let (m0, m1) = (self.slope(i - 1) * width, self.slope(i) * width);
        let (t2, t3) = (t * t, t * t * t);
        let y = (2.0 * t3 - 3.0 * t2 + 1.0) * y0
            + (t3 - 2.0 * t2 + t) * m0
            + (3.0 * t2 - 2.0 * t3) * y1
            + (t3 - t2) * m1;
        y.clamp(0.0, 1.0)
    }

    /// Slope at point `i`: the harmonic mean of the secants, zero where they differ in sign, the secant at the ends.
    fn slope(&self, i: usize) -> f32 {
        let secant = |i: usize| {
            let ([x0, y0], [x1, y1]) = (self.0[i], self.0[i + 1]);
            (y1 - y0) / (x1 - x0)
        };
        match i {
            0 => secant(0),
            i if i + 1 == self.0.len() => secant(i - 1),
            i => {
                let (before, after) = (secant(i - 1), secant(i));
                if before * after <= 0.0 {
                    0.0
                } else {
                    2.0 * before * after / (before + after)
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_pass_their_points_and_stay_between_them() {
        let curve = Curve(vec![[0.0, 0.1], [0.2, 0.1], [0.3, 0.9], [1.0, 1.0]]);
        assert!(curve.check("curve").is_ok());
        for [x, y] in &curve.0 {
            assert!((curve.at(*x) - y).abs() < 1e-6);
        }
        let samples: Vec<f32> = (0..=1000).map(|i| curve.at(i as f32 / 1000.0)).collect();
        assert!(samples.windows(2).all(|w| w[1] >= w[0] - 1e-6));
        assert!((Curve::linear().at(0.3) - 0.3).abs() < 1e-6);
    }

    #[test]
    fn unsound_curves_are_refused() {
        for points in [
            vec![],
            vec![[0.0, 0.0]],
            vec![[0.0, 0.0], [0.5, 1.0]],
            vec![[0.0, 0.0], [0.6, 0.5], [0.6, 0.7], [1.0, 1.0]],
            vec![[0.0, f32::NAN], [1.0, 1.0]],
            vec![[0.0, 0.0], [1.0, 1.5]],
            vec![[0.0, 0.0]; 40],
        ] {
            assert!(Curve(points.clone()).check("curve").is_err(), "{points:?}");
        }
    }
}
