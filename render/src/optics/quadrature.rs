//! Adaptive integration of several functions at once.

/// Nodes of the 15-point Kronrod rule on [0, 1] (Piessens 1983, QUADPACK), outermost first; every second one is Gauss's.
const NODES: [f64; 8] = [
    0.991455371120812639206854697526329,
    0.949107912342758524526189684047851,
    0.864864423359769072789712788640926,
    0.741531185599394439863864773280788,
    0.586087235467691130294144391937781,
    0.405845151377397166906606412076961,
    0.207784955007898467600689403773245,
    0.0,
];
/// Kronrod's weights.
const KRONROD: [f64; 8] = [
    0.022935322010529224963732008058970,
    0.063092092629978553290700663189204,
    0.104790010322250183839876322541518,
    0.140653259715525918745189590510238,
    0.169004726639267902826583426598550,
    0.190350578064785409913256402421014,
    0.204432940075298892414161999234649,
    0.209482141084727828012999174891714,
];
/// Weights of the embedded 7-point Gauss rule, at nodes 1, 3, 5 and 7.
const GAUSS: [f64; 4] = [
    0.129484966168869693270611432679082,
    0.279705391489276667901467771423780,
    0.381830050505118944950369775488975,
    0.417959183673469387755102040816327,
];
/// Panels after which an integral is given up.
const MOST_PANELS: usize = 1000;
/// Below this an integral need not be accurate: every integral here is of order one where light arrives.
const NEGLIGIBLE: f64 = 1e-45;

/// When an integral is good enough: its error is below one of the two.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Relative to the value.
    pub relative: f64,
    /// Absolute: where values below it are rounding noise of the integrand.
    pub absolute: f64,
}

impl From<f64> for Tolerance {
    fn from(relative: f64) -> Self {
        Self {
            relative,
            absolute: NEGLIGIBLE,
        }
    }
}

impl Tolerance {
    /// The error that an integral of this value may have.
    fn allowed(&self, value: f64) -> f64 {
        (self.relative * value.abs()).max(self.absolute)
    }
}

/// An integral per component and how far off it may be.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<const N: usize> {
    /// The integrals.
    pub value: [f64; N],
    /// Bounds of their absolute errors, pessimistic for smooth integrands.
    pub error: [f64; N],
}

impl<const N: usize> Estimate<N> {
    /// The largest relative error of the components; infinite where one is no number.
    pub fn relative_error(&self) -> f64 {
        self.value
            .iter()
            .zip(&self.error)
            .map(|(value, error)| {
                if !value.is_finite() {
                    f64::INFINITY
                } else if *error > NEGLIGIBLE {
                    error / value.abs()
                } else {
                    0.0
                }
            })
            .fold(0.0, f64::max)
    }

    /// True when every component is finite and within `tolerance`.
    pub(super) fn within(&self, tolerance: Tolerance) -> bool {
        self.value
            .iter()
            .zip(&self.error)
            .all(|(value, error)| value.is_finite() && *error <= tolerance.allowed(*value))
    }
}

/// One interval with its estimate.
struct Panel<const N: usize> {
    from: f64,
    to: f64,
    estimate: Estimate<N>,
}

/// The 15-point rule on one interval; the error is the distance to the embedded 7-point rule, sharpened as QUADPACK does.
fn kronrod<const N: usize>(f: &mut impl FnMut(f64) -> [f64; N], from: f64, to: f64) -> Panel<N> {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut kronrod = [0.0; N];
    let mut gauss = [0.0; N];
    let mut magnitude = [0.0; N];
    for (k, (node, weight)) in NODES.into_iter().zip(KRONROD).enumerate() {
        let mirrored = if node == 0.0 { &[0.0][..] } else { &[-1.0, 1.0][..] };
        for side in mirrored {
            let y = f(centre + side * node * half);
            for c in 0..N {
                kronrod[c] += weight * y[c];
                magnitude[c] += weight * y[c].abs();
                if k % 2 == 1 {
                    gauss[c] += GAUSS[k / 2] * y[c];
                }
            }
        }
    }

    // The difference of the rules is the error of the weaker one; its 3/2 power tracks the stronger one.
    let error = std::array::from_fn(|c| {
        let (scale, difference) = (magnitude[c] * half, (kronrod[c] - gauss[c]).abs() * half);
        if scale <= NEGLIGIBLE {
            return 0.0;
        }
        let sharpened = scale * (200.0 * difference / scale).powf(1.5).min(1.0);
        sharpened.min(difference).max(4.0 * f64::EPSILON * scale)
    });
    let value = kronrod.map(|sum| sum * half);
    Panel {
        from,
        to,
        estimate: Estimate { value, error },
    }
}

/// Nodes and weights of the 7-point Gauss rule on one interval.
pub(super) fn gauss_7_nodes(from: f64, to: f64) -> [(f64, f64); 7] {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    std::array::from_fn(|i| {
        // Outermost first, the centre last, then back out.
        let k = if i < 4 { i } else { 6 - i };
        let step = NODES[2 * k + 1] * if i < 4 { -half } else { half };
        (centre + step, half * GAUSS[k])
    })
}

/// The 7-point Gauss rule on one interval, for integrands that it resolves to the last digits.
pub(super) fn gauss_7(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    gauss_7_nodes(from, to)
        .into_iter()
        .map(|(x, weight)| weight * f(x))
        .sum()
}

/// Integrates N functions over [from, to], halving the worst interval until each is within `tolerance` (a bare number is relative).
///
/// `breaks` are the places of kinks and narrow peaks, in any order; those outside (from, to) are ignored.
pub fn integrate<const N: usize>(
    mut f: impl FnMut(f64) -> [f64; N],
    from: f64,
    to: f64,
    breaks: &[f64],
    tolerance: impl Into<Tolerance>,
) -> Estimate<N> {
    let tolerance = tolerance.into();

    // Lay the first panels between the breaks.
    let mut edges: Vec<f64> = breaks.iter().copied().filter(|x| *x > from && *x < to).collect();
    edges.extend([from, to]);
    edges.sort_by(f64::total_cmp);
    edges.dedup_by(|a, b| (*a - *b).abs() < 1e-14 * (to - from));
    let mut panels: Vec<Panel<N>> = edges.windows(2).map(|e| kronrod(&mut f, e[0], e[1])).collect();

    loop {
        // Sum afresh in every pass, so that rounding does not pile up.
        let mut total = Estimate {
            value: [0.0; N],
            error: [0.0; N],
        };
        for panel in &panels {
            for c in 0..N {
                total.value[c] += panel.estimate.value[c];
                total.error[c] += panel.estimate.error[c];
            }
        }
        if total.within(tolerance) || panels.len() >= MOST_PANELS {
            return total;
        }

        // Halve every panel that holds a fair share of the error still allowed or exceeded.
        let worst = |panel: &Panel<N>| {
            (0..N)
                .map(|c| panel.estimate.error[c] / tolerance.allowed(total.value[c]))
                .fold(0.0, f64::max)
        };
        let limit = panels.iter().map(worst).fold(0.0, f64::max) * 0.25;
        let mut refined = Vec::with_capacity(panels.len() + 8);
        let mut stuck = true;
        for panel in panels {
            let middle = 0.5 * (panel.from + panel.to);
            if worst(&panel) < limit || middle <= panel.from || middle >= panel.to {
                refined.push(panel);
                continue;
            }
            stuck = false;
            refined.push(kronrod(&mut f, panel.from, middle));
            refined.push(kronrod(&mut f, middle, panel.to));
        }
        panels = refined;
        if stuck {
            return total;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kronrod_is_exact_to_degree_22() {
        // On [0, 1] the integral of (k + 1) x^k is one.
        let of_degree = |k: i32| {
            kronrod(&mut |x: f64| [f64::from(k + 1) * x.powi(k)], 0.0, 1.0)
                .estimate
                .value[0]
        };
        for k in 0..=22 {
            assert!((of_degree(k) - 1.0).abs() < 1e-14, "degree {k}");
        }
        assert!(
            (of_degree(60) - 1.0).abs() > 1e-14,
            "a finite rule must fail somewhere"
        );
    }

    #[test]
    fn narrow_peaks_and_singular_ends_converge() {
        // A Gaussian of width 1e-4 with its place and reach named, and the square root's infinite slope.
        let peak = integrate(
            |x: f64| [(-((x - 0.3) / 1e-4).powi(2)).exp(), x.sqrt()],
            0.0,
            1.0,
            &[0.2994, 0.3, 0.3006],
            1e-10,
        );
        assert!((peak.value[0] / (1e-4 * std::f64::consts::PI.sqrt()) - 1.0).abs() < 1e-9);
        assert!((peak.value[1] * 1.5 - 1.0).abs() < 1e-9);
        assert!(peak.relative_error() <= 1e-10);
    }
}
