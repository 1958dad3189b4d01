//! The curves of `UsdGeomBasisCurves`: control points to a polyline.
//!
//! Bases and wraps as the schema's documentation defines them; `pinned` adds a phantom point 2 P0 - P1 at both ends.

/// Points that stand for a segment of a cubic curve; its end belongs to the next one.
pub(super) const POINTS_PER_SEGMENT: usize = 4;

/// `basis` of a cubic curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Basis {
    Linear,
    Bezier,
    BSpline,
    CatmullRom,
}

/// `wrap`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Wrap {
    NonPeriodic,
    Periodic,
    Pinned,
}

/// The shape of one curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub basis: Basis,
    pub wrap: Wrap,
    /// Control points.
    pub count: usize,
}

impl Shape {
    /// Segments; none where there are too few control points or a number of them that the basis does not allow.
    pub fn segments(self) -> usize {
        let n = self.count;
        match (self.basis, self.wrap) {
            (Basis::Linear, Wrap::Periodic) => n,
            (Basis::Linear, _) => n.saturating_sub(1),
            (Basis::Bezier, Wrap::Periodic) => n / 3,
            (Basis::Bezier, _) => n.saturating_sub(1) / 3,
            (_, Wrap::Periodic) => n,
            (_, Wrap::Pinned) => n.saturating_sub(1),
            (_, Wrap::NonPeriodic) => n.saturating_sub(3),
        }
    }

    /// Number of `varying` values: one at every end of a segment.
    pub fn varying(self) -> usize {
        self.segments() + usize::from(self.wrap != Wrap::Periodic)
    }

    /// Control points of a segment with their weights at `t` of it.
    fn weights(self, segment: usize, t: f64) -> [(isize, f64); 4] {
        let (s, u) = (segment as isize, 1.0 - t);
        let first = match (self.basis, self.wrap) {
            (Basis::Linear, _) => return [(s, u), (s + 1, t), (s, 0.0), (s, 0.0)],
            (Basis::Bezier, _) => 3 * s,
            (_, Wrap::Pinned) => s - 1,
            (_, Wrap::Periodic | Wrap::NonPeriodic) => s,
        };
        let (t2, t3) = (t * t, t * t * t);
        let w = match self.basis {
            Basis::BSpline => [
                u * u * u / 6.0,
                (3.0 * t3 - 6.0 * t2 + 4.0) / 6.0,
                (-3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0) / 6.0,
                t3 / 6.0,
            ],
            Basis::CatmullRom => [
                0.5 * (-t3 + 2.0 * t2 - t),
                0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
                0.5 * (-3.0 * t3 + 4.0 * t2 + t),
                0.5 * (t3 - t2),
            ],
            Basis::Linear | Basis::Bezier => [u * u * u, 3.0 * u * u * t, 3.0 * u * t2, t3],
        };
        [0, 1, 2, 3].map(|i| (first + i as isize, w[i]))
    }

    /// The value at `t` of a segment of what `control` gives at the control points.
    pub fn at<const N: usize>(self, segment: usize, t: f64, control: impl Fn(usize) -> [f64; N]) -> [f64; N] {
        let n = self.count as isize;
        let point = |i: isize| -> [f64; N] {
            let phantom = |end: usize, inner: usize| {
                let (end, inner) = (control(end), control(inner));
                std::array::from_fn(|c| 2.0 * end[c] - inner[c])
            };
            match i {
                _ if self.wrap == Wrap::Periodic => control(i.rem_euclid(n) as usize),
                -1 => phantom(0, 1),
                _ if i == n => phantom(n as usize - 1, n as usize - 2),
                _ => control(i.clamp(0, n - 1) as usize),
            }
        };
        // The sum starts from minus zero, which leaves even the sign of what is added to it.
        let mut sum = [-0.0; N];
        for (i, weight) in self.weights(segment, t).into_iter().filter(|(_, w)| *w != 0.0) {
            let p = point(i);
            for c in 0..N {
                sum[c] += weight * p[c];
            }
        }
        sum
    }

    /// Segment and parameter of every point of the polyline, the last one the end of the curve.
    pub fn samples(self) -> impl Iterator<Item = (usize, f64)> {
        let segments = self.segments();
        let steps = if self.basis == Basis::Linear {
            1
        } else {
            POINTS_PER_SEGMENT
        };
        let inner = (0..segments).flat_map(move |s| (0..steps).map(move |i| (s, i as f64 / steps as f64)));
        inner.chain(segments.checked_sub(1).map(|last| (last, 1.0)))
    }
}
