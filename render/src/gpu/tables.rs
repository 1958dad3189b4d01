//! Tables the scattering shaders read: computed in float64 at start-up, uploaded once as one storage buffer of `vec4f`.
//!
//! | section | index of its first `vec4f` | entry |
//! |---|---|---|
//! | truncated Gauss rules | 0 | node, weight, and their steps to the next truncation, per rule size n, node k and truncation t |
//! | Gauss-Legendre rules over gamma | [`GAMMA_OFFSET`] | sin gamma, cos gamma, weight * cos gamma / 2, weight, per rule size and node |
//! | von Mises | [`VON_MISES_OFFSET`] | normaliser, node, weight and convolution term over v = 1 / (1 + sqrt kappa) |
//! | mean cosine powers | [`COSINE_POWER_OFFSET`] | means of y^1..y^8 under a von Mises density (Xu 2011, Eq 14), over v and y = abs cos(phi/2) |
//! | window cosine powers | [`WINDOW_OFFSET`] | means of y^1..y^8 over the half circle around a direction (Xu 2011, Eq 28), over y |
//! | Fresnel polynomials | [`FRESNEL_OFFSET`] | coefficients of X^0..X^7 of the exact dielectric reflectance, over eta |
//! | Fresnel moments of Xu 2011 | [`XU_OFFSET`] | H_0, H_2, H_4 of TT, then of TRT (Eq 19, 23), over 1/eta and theta_d |
//!
//! `shaders/lib/tables.wgsl` repeats the constants of this file; a test compares them.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Largest rule of the truncated Gauss section.
pub const TRUNCATED_MAX: usize = 6;
/// Truncation points per rule and node.
pub const TRUNCATION_COUNT: usize = 64;
/// First truncation point, in units of the Gaussian's bandwidth.
pub const TRUNCATION_MIN: f64 = -2.0;
/// Last truncation point; beyond it the Gaussian counts as whole.
pub const TRUNCATION_MAX: f64 = 3.0;
/// Largest rule over gamma.
pub const GAMMA_MAX: usize = 16;
/// First entry of the rules over gamma.
pub const GAMMA_OFFSET: usize = TRUNCATED_MAX * (TRUNCATED_MAX + 1) / 2 * TRUNCATION_COUNT;
/// Intervals of the von Mises section.
pub const VON_MISES_STEPS: usize = 256;
/// First entry of the von Mises section.
pub const VON_MISES_OFFSET: usize = GAMMA_OFFSET + GAMMA_MAX * (GAMMA_MAX + 1) / 2;
/// Intervals of the cosine powers in v and in y.
pub const COSINE_POWER_STEPS: usize = 64;
/// First entry of the cosine powers.
pub const COSINE_POWER_OFFSET: usize = VON_MISES_OFFSET + VON_MISES_STEPS + 1;
/// First entry of the window cosine powers.
pub const WINDOW_OFFSET: usize =
    COSINE_POWER_OFFSET + 2 * (COSINE_POWER_STEPS + 1) * (COSINE_POWER_STEPS + 1);
/// Intervals of the Fresnel section over eta in [1, [`FRESNEL_ETA_MAX`]].
pub const FRESNEL_STEPS: usize = 256;
/// Largest index of refraction.
pub const FRESNEL_ETA_MAX: f64 = 3.0;
/// First entry of the Fresnel section.
pub const FRESNEL_OFFSET: usize = WINDOW_OFFSET + 2 * (COSINE_POWER_STEPS + 1);
/// Intervals of the moments of Xu 2011 over 1/eta, from eta = 1 to [`XU_ETA_MAX`].
pub const XU_ETA_STEPS: usize = 128;
/// Largest index of refraction of the moments.
pub const XU_ETA_MAX: f64 = 10.0;
/// Intervals of the moments over theta_d in [0, pi/2].
pub const XU_THETA_STEPS: usize = 64;
/// First entry of the moments.
pub const XU_OFFSET: usize = FRESNEL_OFFSET + 2 * (FRESNEL_STEPS + 1);
/// All entries.
pub const TABLE_LEN: usize = XU_OFFSET + 2 * (XU_ETA_STEPS + 1) * (XU_THETA_STEPS + 1);

/// All sections in the order above, [`TABLE_LEN`] entries.
pub fn scattering_tables() -> Vec<[f32; 4]> {
    let mut out = Vec::with_capacity(TABLE_LEN);
    for n in 1..=TRUNCATED_MAX {
        push_truncated_rules(&mut out, n);
    }
    for n in 1..=GAMMA_MAX {
        out.extend(
            gauss_legendre(n, 0.0, FRAC_PI_2)
                .into_iter()
                .map(|(gamma, weight)| {
                    let (sin_gamma, cos_gamma) = gamma.sin_cos();
                    narrow([sin_gamma, cos_gamma, 0.5 * weight * cos_gamma, weight])
                }),
        );
    }
    out.extend((0..=VON_MISES_STEPS).map(|i| narrow(von_mises_entry(i as f64 / VON_MISES_STEPS as f64))));
    push_cosine_powers(&mut out);
    push_window_powers(&mut out);
    for i in 0..=FRESNEL_STEPS {
        let eta = 1.0 + (FRESNEL_ETA_MAX - 1.0) * i as f64 / FRESNEL_STEPS as f64;
        let c = fresnel_polynomial(eta);
        out.push(narrow([c[0], c[1], c[2], c[3]]));
        out.push(narrow([c[4], c[5], c[6], c[7]]));
    }
    push_xu_moments(&mut out);
    out
}

/// H_0, H_2 and H_4 of TT and TRT with Schlick's reflectance (Xu 2011, Eq 19 and 23).
fn push_xu_moments(out: &mut Vec<[f32; 4]>) {
    let rule = gauss_legendre(32, 0.0, FRAC_PI_2);
    for i in 0..=XU_ETA_STEPS {
        let eta = 1.0 / (1.0 - (1.0 - 1.0 / XU_ETA_MAX) * i as f64 / XU_ETA_STEPS as f64);
        let f_0 = ((1.0 - eta) / (1.0 + eta)).powi(2);
        for j in 0..=XU_THETA_STEPS {
            let cos_theta_d = (FRAC_PI_2 * j as f64 / XU_THETA_STEPS as f64).cos();
            let (mut tt, mut trt) = ([0.0; 4], [0.0; 4]);
            for (gamma, weight) in &rule {
                let (h, cos_gamma) = gamma.sin_cos();
                let reflected = f_0 + (1.0 - f_0) * (1.0 - cos_theta_d * cos_gamma).powi(5);
                // Both signs of h.
                let through = 2.0 * weight * cos_gamma * (1.0 - reflected).powi(2);
                for (k, power) in [1.0, h.powi(2), h.powi(4)].into_iter().enumerate() {
                    tt[k] += through * power;
                    trt[k] += through * reflected * power;
                }
            }
            out.extend([narrow(tt), narrow(trt)]);
        }
    }
}

fn narrow(values: [f64; 4]) -> [f32; 4] {
    values.map(|v| v as f32)
}

/// Gauss rule with `n` nodes for the weight exp(-x^2) on (-infinity, `t`], nodes ascending.
pub fn truncated_gauss_hermite(n: usize, t: f64) -> Vec<(f64, f64)> {
    // The weight is below 1e-21 outside +-7, so a dense rule between there and t stands for the measure.
    let measure: Vec<(f64, f64)> = gauss_legendre(96, -7.0, t.min(7.0))
        .into_iter()
        .map(|(x, w)| (x, w * (-x * x).exp()))
        .collect();
    gauss_of_measure(n, &measure)
}

/// Gauss rule of a discrete measure: Stieltjes' recurrence, then the eigenvalues of the Jacobi matrix (Golub, Welsch 1969).
fn gauss_of_measure(n: usize, measure: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mass: f64 = measure.iter().map(|m| m.1).sum();
    let mut jacobi = DMatrix::zeros(n, n);
    let mut previous = vec![0.0; measure.len()];
    let mut current = vec![1.0 / mass.sqrt(); measure.len()];
    let mut norm = 0.0;
    for k in 0..n {
        let centre: f64 = measure
            .iter()
            .zip(&current)
            .map(|((x, w), p)| w * x * p * p)
            .sum();
        jacobi[(k, k)] = centre;
        let next: Vec<f64> = measure
            .iter()
            .zip(current.iter().zip(&previous))
            .map(|((x, _), (p, q))| (x - centre) * p - norm * q)
            .collect();
        norm = measure
            .iter()
            .zip(&next)
            .map(|((_, w), p)| w * p * p)
            .sum::<f64>()
            .sqrt();
        if k + 1 < n {
            jacobi[(k, k + 1)] = norm;
            jacobi[(k + 1, k)] = norm;
        }
        previous = std::mem::replace(&mut current, next.into_iter().map(|p| p / norm).collect());
    }
    let eigen = SymmetricEigen::new(jacobi);
    let mut rule: Vec<(f64, f64)> = (0..n)
        .map(|k| (eigen.eigenvalues[k], mass * eigen.eigenvectors[(0, k)].powi(2)))
        .collect();
    rule.sort_by(|a, b| a.0.total_cmp(&b.0));
    rule
}

/// Gauss-Legendre rule with `n` nodes on [a, b]: roots of the Legendre polynomial by Newton's method.
pub fn gauss_legendre(n: usize, a: f64, b: f64) -> Vec<(f64, f64)> {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    (0..n)
        .rev()
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut p, mut before) = (1.0, 0.0);
                for k in 0..n {
                    let k = k as f64;
                    (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                let step = p / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (middle + half * x, half * 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

fn push_truncated_rules(out: &mut Vec<[f32; 4]>, n: usize) {
    let step = (TRUNCATION_MAX - TRUNCATION_MIN) / (TRUNCATION_COUNT - 1) as f64;
    let rules: Vec<_> = (0..TRUNCATION_COUNT)
        .map(|i| truncated_gauss_hermite(n, TRUNCATION_MIN + step * i as f64))
        .collect();
    let entry = |k: usize, i: usize| {
        let (x, w) = rules[i][k];
        let (x_next, w_next) = rules[(i + 1).min(TRUNCATION_COUNT - 1)][k];
        narrow([x, w, x_next - x, w_next - w])
    };
    out.extend((0..n).flat_map(|k| (0..TRUNCATION_COUNT).map(move |i| entry(k, i))));
}

/// Points x and normalised weights of the von Mises density exp(kappa (cos x - 1)) / (2 pi i0e(kappa)), with i0e(kappa).
fn von_mises_measure(kappa: f64) -> (Vec<(f64, f64)>, f64) {
    // Trapezoids converge geometrically for a smooth periodic integrand and for a Gaussian cut at nine deviations.
    let half = PI.min(9.0 / kappa.sqrt());
    let count = 256;
    let step = 2.0 * half / count as f64;
    let points: Vec<(f64, f64)> = (0..count)
        .map(|i| {
            let x = -half + step * (i as f64 + 0.5);
            (x, step * (-2.0 * kappa * (0.5 * x).sin().powi(2)).exp())
        })
        .collect();
    let mass: f64 = points.iter().map(|p| p.1).sum();
    (
        points.into_iter().map(|(x, w)| (x, w / mass)).collect(),
        mass / (2.0 * PI),
    )
}

/// kappa at the table coordinate v = 1 / (1 + sqrt kappa).
fn kappa_at(v: f64) -> f64 {
    ((1.0 - v) / v).powi(2)
}

/// i0e(kappa) / v; tan(x/4) / v and w of the three-node rule {0, +-x}, weights {1 - 2w, w, w};
/// and g / (1/2 + kappa), g = A / (2 kappa A'), A = I1/I0, of the convolution rule 1/kappa_c = (1 + g/kappa_2) / kappa_1.
fn von_mises_entry(v: f64) -> [f64; 4] {
    if v <= 0.0 {
        return [1.0 / (2.0 * PI).sqrt(), 0.25 * 3.0_f64.sqrt(), 1.0 / 6.0, 1.0];
    }
    let kappa = kappa_at(v);
    if kappa < 1e-9 {
        return [1.0 / v, (PI / 6.0).tan() / v, 1.0 / 3.0, 1.0];
    }
    let (points, i0e) = von_mises_measure(kappa);
    // 1 - A is integrated as such: the difference would cancel for narrow densities.
    let one_minus_a: f64 = points
        .iter()
        .map(|(x, w)| 2.0 * w * (0.5 * x).sin().powi(2))
        .sum();
    let a = 1.0 - one_minus_a;
    let slope: f64 = points
        .iter()
        .map(|(x, w)| w * (one_minus_a - 2.0 * (0.5 * x).sin().powi(2)).powi(2))
        .sum();
    // The rule is exact for cos x and cos 2x: 1 + cos x = A / (kappa (1 - A)).
    let one_minus_cos = 2.0 - a / (kappa * one_minus_a);
    let weight = one_minus_a / (2.0 * one_minus_cos);
    let g = a / (2.0 * kappa * slope);
    [
        i0e / v,
        // From 1 - cos x, which is exact for narrow densities.
        (0.5 * (0.5 * one_minus_cos).sqrt().asin()).tan() / v,
        weight,
        g / (0.5 + kappa),
    ]
}

fn push_cosine_powers(out: &mut Vec<[f32; 4]>) {
    for i in 0..=COSINE_POWER_STEPS {
        let v = i as f64 / COSINE_POWER_STEPS as f64;
        let points = if v > 0.0 {
            von_mises_measure(kappa_at(v)).0
        } else {
            vec![(0.0, 1.0)]
        };
        push_power_means(out, &points);
    }
}

fn push_window_powers(out: &mut Vec<[f32; 4]>) {
    let count = 1024;
    let step = PI / f64::from(count);
    let points: Vec<(f64, f64)> = (0..count)
        .map(|i| (-FRAC_PI_2 + step * (f64::from(i) + 0.5), 1.0 / f64::from(count)))
        .collect();
    push_power_means(out, &points);
}

/// Means of abs(cos((centre + x)/2))^k, k = 1..8, over weighted points x, for centres with y = abs(cos(centre/2)) on the grid.
fn push_power_means(out: &mut Vec<[f32; 4]>, points: &[(f64, f64)]) {
    for j in 0..=COSINE_POWER_STEPS {
        let centre = 2.0 * (j as f64 / COSINE_POWER_STEPS as f64).acos();
        let mut means = [0.0; 8];
        for (x, weight) in points {
            let y = (0.5 * (centre + x)).cos().abs();
            let mut term = *weight;
            for mean in &mut means {
                term *= y;
                *mean += term;
            }
        }
        out.push(narrow([means[0], means[1], means[2], means[3]]));
        out.push(narrow([means[4], means[5], means[6], means[7]]));
    }
}

/// Coefficients of X^0..X^7, X = cos of the angle of incidence, of the least-squares polynomial of the reflectance on [0, 1].
///
/// # Panics
/// Never: the normal matrix of eight monomials on Gauss nodes is regular.
pub fn fresnel_polynomial(eta: f64) -> [f64; 8] {
    let nodes = gauss_legendre(64, 0.0, 1.0);
    let rows = DMatrix::from_fn(nodes.len(), 8, |i, k| {
        nodes[i].1.sqrt() * nodes[i].0.powi(k as i32)
    });
    let values = DVector::from_fn(nodes.len(), |i, _| {
        nodes[i].1.sqrt() * fresnel_dielectric(nodes[i].0, eta)
    });
    let solution = rows
        .svd(true, true)
        .solve(&values, 1e-14)
        .expect("both factors were asked for");
    std::array::from_fn(|k| solution[k])
}

/// Exact reflectance of unpolarised light that comes from outside at cosine `cos_i` onto a dielectric of index `eta` >= 1.
fn fresnel_dielectric(cos_i: f64, eta: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / (eta * eta)).max(0.0).sqrt();
    let s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    let p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    0.5 * (s * s + p * p)
}
