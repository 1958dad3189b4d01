//! The natural cubic spline through the points of a strand, uniform in its parameter: segment i runs from t = 0 at point i to t = 1 at
//! point i + 1, first and second derivatives are continuous, the second derivative vanishes at both ends.

use glam::{DVec3, Vec3};

/// A spline in Hermite form.
pub(super) struct NaturalSpline {
    points: Vec<DVec3>,
    /// First derivative at every point.
    derivatives: Vec<DVec3>,
}

impl NaturalSpline {
    /// The spline through at least two points.
    ///
    /// Continuity of the second derivative asks for d_(i-1) + 4 d_i + d_(i+1) = 3 (p_(i+1) - p_(i-1)); the ends for 2 d_0 + d_1 = 3 (p_1 - p_0)
    /// and its mirror image.
    pub fn new(points: &[Vec3]) -> Self {
        let points: Vec<DVec3> = points.iter().map(|p| p.as_dvec3()).collect();
        let last = points.len() - 1;

        // Eliminate downwards (Thomas algorithm); every diagonal stays above 2 - 1/2.
        let mut upper = Vec::with_capacity(points.len());
        let mut derivatives: Vec<DVec3> = Vec::with_capacity(points.len());
        for i in 0..=last {
            let right = 3.0 * (points[(i + 1).min(last)] - points[i.saturating_sub(1)]);
            let diagonal = if i == 0 || i == last { 2.0 } else { 4.0 };
            let (above, below) = if i == 0 {
                (0.0, DVec3::ZERO)
            } else {
                (upper[i - 1], derivatives[i - 1])
            };
            let pivot = diagonal - above;
            upper.push(1.0 / pivot);
            derivatives.push((right - below) / pivot);
        }

        // Substitute upwards.
        for i in (0..last).rev() {
            let next = derivatives[i + 1];
            derivatives[i] -= upper[i] * next;
        }
        Self { points, derivatives }
    }

    /// Number of segments.
    pub fn segment_count(&self) -> usize {
        self.points.len() - 1
    }

    /// Position at `t` of `segment`.
    pub fn position(&self, segment: usize, t: f64) -> DVec3 {
        let (p, d) = (&self.points[segment..], &self.derivatives[segment..]);
        let s = 1.0 - t;
        s * s * (1.0 + 2.0 * t) * p[0] + t * t * (1.0 + 2.0 * s) * p[1] + t * s * (s * d[0] - t * d[1])
    }

    /// Unit tangent, root to tip, at `t` of `segment`; the chord's direction where the curve stands still.
    pub fn tangent(&self, segment: usize, t: f64) -> DVec3 {
        let (p, d) = (&self.points[segment..], &self.derivatives[segment..]);
        let s = 1.0 - t;
        let chord = p[1] - p[0];
        let derivative = 6.0 * t * s * chord + s * (s - 2.0 * t) * d[0] + t * (t - 2.0 * s) * d[1];
        if derivative.length() > 1.0e-6 * chord.length() {
            derivative.normalize()
        } else {
            chord.normalize()
        }
    }
}
