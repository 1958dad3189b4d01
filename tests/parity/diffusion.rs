//! Light that spreads in inclination: diffusion on the three-sphere, and M3, which rests on it.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI};

use balayage_render::optics::{Direction, deon, dual, global_scattering};

use super::dual::{averages, fibre};
use super::{ARGUMENTS, Parity, between, hold, log_between};

/// Intervals of theta_i: trapezoids of a smooth, narrow-tailed integrand.
const INTERVALS: u32 = 48;
/// Width of light that stands for one inclination, Xu's bandwidth.
const NARROW: f64 = 0.02;
/// Beyond it light of one inclination has no inverse cosine to speak of.
const STEEPEST: f64 = 1.5;

/// sigma_a, theta_o, theta, phi, n, t_f, spread, kappa.
fn lit(r: &mut rand_pcg::Pcg64Mcg) -> Vec<f64> {
    let n = between(r, 0.2, 3.0);
    let direct = (-n).exp();
    vec![
        log_between(r, 0.02, 3.0),
        between(r, -0.8, 0.8),
        between(r, -1.2, 1.2),
        between(r, -PI, PI),
        n,
        direct + (1.0 - direct) * between(r, 0.0, 1.0),
        between(r, 0.01, 0.1),
        between(r, 0.0, 4.0),
    ]
}

/// The heat kernel of the three-sphere after a time of variance / 2, over its polar angles theta + pi/2 with measure cos^2 theta: its
/// eigenfunctions are sin(m chi) / sin(chi), m = 1, 2, ...
fn heat_kernel(theta: f64, theta_i: f64, variance: f64) -> f64 {
    let (from, to) = (theta + FRAC_PI_2, theta_i + FRAC_PI_2);
    let sum: f64 = (1..200)
        .map(f64::from)
        .map(|m| (m * from).sin() * (m * to).sin() * (-0.5 * (m * m - 1.0) * variance).exp())
        .sum();
    FRAC_2_PI * sum / (from.sin() * to.sin())
}

/// What a fibre that sends `response(theta_i)` of narrow light back to the viewer sends of light from `theta` that diffused.
fn diffused(response: impl Fn(f64) -> f64, theta: f64, variance: f64) -> f64 {
    let step = 2.0 * STEEPEST / f64::from(INTERVALS);
    let at = |i: u32| -STEEPEST + (f64::from(i) + 0.5) * step;
    (0..INTERVALS)
        .map(at)
        .map(|theta_i| {
            step * response(theta_i) * heat_kernel(theta, theta_i, variance) * theta.cos() * theta_i.cos()
        })
        .sum()
}

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["m3_terms", "diffused_lobes", "lobes_at"],
        file: "lib/multiple.wgsl",
        call: M3,
        domain: "sigma_a 0.02 to 3, |theta_o| <= 0.8, |theta| <= 1.2, any azimuth, n 0.2 to 3, t_f from exp(-n) to 1, kappa 0 to 4: the streams' equations \
            integrated step by step, spread by the eigenfunctions of the three-sphere",
        tolerance: 0.02,
        reason: "one refraction a lobe, four odd harmonics of the half circle, cosines by their means",
        calls: 12,
        draw: lit,
        reference: |x| {
            let [sigma_a, theta_o, theta, phi, n, t_f, spread, _, ..] = *x;
            let response = |theta_i: f64, phi: f64| {
                let at = |theta, phi| Direction { theta, phi };
                let fibre = fibre([sigma_a; 3]);
                let lobes =
                    global_scattering(&fibre, at(theta_o, phi), at(theta_i, 0.0), NARROW, 1e-3).unwrap();
                lobes.sum()[0]
            };
            let onward = diffused(|theta_i| response(theta_i, phi), theta, 4.0 * spread);
            // Both half circles together are the whole one.
            let all_round = |theta_i: f64| 0.5 * (response(theta_i, phi) + response(theta_i, phi + PI));
            let turned = diffused(
                all_round,
                theta,
                (4.0 * spread + turned_variance(sigma_a, theta_o)).min(1.0),
            );
            vec![(t_f - (-n).exp()) * onward, turned_power(x) * turned]
        },
    },
    Parity {
        covers: &["two_streams", "turned_variance"],
        file: "lib/multiple.wgsl",
        call: TURNED,
        domain: "as above: the streams' equations integrated step by step, the slope of ln(rho) by a difference",
        tolerance: 0.02,
        reason: "entries of the table are linear between nodes",
        calls: 60,
        draw: lit,
        reference: |x| vec![turned_power(x), turned_variance(x[0], x[1])],
    },
    Parity {
        covers: &["diffused_lobes", "lobes_at", "cone_rest"],
        file: "lib/forward_deon.wgsl",
        call: CONES,
        domain: "sigma_a 0.05 to 3, |theta_o| <= 0.8, |theta| <= 1.2, any azimuth, variance 0.03 to 0.9",
        tolerance: 0.05,
        reason: "one refraction a lobe, four odd harmonics of the half circle, two nodes a cone",
        calls: 12,
        draw: |r| {
            let sigma_a = log_between(r, 0.05, 3.0);
            let inclinations = [between(r, -0.8, 0.8), between(r, -1.2, 1.2)];
            vec![
                sigma_a,
                inclinations[0],
                inclinations[1],
                between(r, -PI, PI),
                between(r, 0.03, 0.9),
            ]
        },
        reference: |x| {
            let response = |theta_i: f64| {
                let at = |theta, phi| Direction { theta, phi };
                let fibre = fibre([x[0]; 3]);
                let lobes =
                    deon::global_scattering(&fibre, at(x[1], x[3]), at(theta_i, 0.0), NARROW, 1e-3).unwrap();
                lobes.sum()[0]
            };
            vec![diffused(response, x[2], x[4])]
        },
    },
];

const M3: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    let terms = m3_terms(prepare_multiple(f, x[1], x[3]), x[2], 0.0, PathRecord(vec3f(-log(x[5])), x[6], vec3f(x[7]), x[4]));
    y = vec4f(terms.d.x, terms.u.x, 0.0, 0.0);";

const TURNED: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    let path = PathRecord(vec3f(-log(x[5])), x[6], vec3f(x[7]), x[4]);
    let view = prepare_multiple(f, x[1], x[3]);
    y = vec4f(two_streams(view, x[2], path).x - x[5], view.turned_variance, 0.0, 0.0);";

const CONES: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    let v = prepare_forward(f, x[1]);
    let lobes = diffused_lobes(v, x[2], x[4]);
    let cos_x = cos(x[3]);
    y.x = (lobes.x * window_at(v.series[0], cos_x) + lobes.y * window_at(v.series[1], cos_x) + lobes.z * window_at(v.series[2], cos_x)).x;";

/// Spread of what a half space sends back: the slope of ln(rho) over ln(a_f) and ln(a_b) together tells how often it was scattered.
fn turned_variance(sigma_a: f64, theta: f64) -> f64 {
    const STEP: f64 = 1e-4;
    let m = averages(sigma_a, theta);
    let ln_rho = |scale: f64| dual::half_space_reflectance(scale * m.a_f[0], scale * m.a_b[0]).ln();
    let times = (ln_rho(1.0) - ln_rho(1.0 - STEP)) / -(-STEP).ln_1p();
    let variance = 4.0 * (m.beta_b[0].powi(2) + (times - 1.0) * m.beta_f[0].powi(2));
    variance.min(1.0)
}

/// What two streams carry beyond the light that does not turn round: their equations (`two_streams` in the shader) integrated by Runge and
/// Kutta from both boundary conditions.
fn turned_power(x: &[f64; ARGUMENTS]) -> f64 {
    let [sigma_a, _, theta, _, _, t_f, _, kappa] = std::array::from_fn(|i| x[i]);
    let rho = dual::mean_reflectance(&fibre([sigma_a; 3]), 1e-3).unwrap()[0];
    let here = averages(sigma_a, theta);
    let (loss, back) = (1.0 - here.a_f[0], here.a_b[0]);
    let k = ((loss - back) * (loss + back)).max(9e-8).sqrt();
    // The fibre whose streams decay by k and whose half space reflects rho.
    let a = k * (1.0 + rho * rho) / (1.0 - rho * rho);
    let b = 2.0 * k * rho / (1.0 - rho * rho);
    let (front, behind) = (-t_f.ln() / loss, 0.5 * kappa / k);
    let advanced = |[f, r]: [f64; 2], fibres: f64| {
        const STEPS: u32 = 2000;
        let h = fibres / f64::from(STEPS);
        let slope = |[f, r]: [f64; 2]| [-a * f + b * r, a * r - b * f];
        (0..STEPS).fold([f, r], |y, _| {
            let at = |d: [f64; 2], s: f64| [y[0] + s * d[0], y[1] + s * d[1]];
            let k1 = slope(y);
            let k2 = slope(at(k1, 0.5 * h));
            let k3 = slope(at(k2, 0.5 * h));
            let k4 = slope(at(k3, h));
            std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
        })
    };
    // Two solutions, mixed so that nothing enters from behind.
    let (one, other) = (advanced([1.0, 0.0], front), advanced([1.0, 1.0], front));
    let (end_one, end_other) = (advanced(one, behind), advanced(other, behind));
    let share = -end_one[1] / (end_other[1] - end_one[1]);
    let carried = (one[0] + one[1]) * (1.0 - share) + (other[0] + other[1]) * share;
    (carried - t_f).max(0.0)
}

#[test]
fn diffusion_agrees_with_float64() {
    hold(PARITIES);
}
