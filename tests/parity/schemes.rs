//! The parts of the schemes xu2011 and directional.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{CALLS, Parity, between, hold, log_between};

/// Schlick's reflectance.
fn schlick(eta: f64, cos_i: f64) -> f64 {
    let f_0 = ((1.0 - eta) / (1.0 + eta)).powi(2);
    f_0 + (1.0 - f_0) * (1.0 - cos_i).powi(5)
}

/// Mean over h in [-1, 1] of `f(h)`, times two.
fn over_h(f: impl Fn(f64) -> f64) -> f64 {
    let steps = 2000;
    let width = PI / f64::from(steps);
    (0..steps)
        .map(|i| {
            let gamma = width * (f64::from(i) + 0.5) - FRAC_PI_2;
            width * gamma.cos() * f(gamma.sin())
        })
        .sum()
}

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["schlick", "schlick_f0", "schlick_polynomial"],
        file: "lib/xu2011_azimuth.wgsl",
        call: "
            let p = schlick_polynomial(x[0]);
            let c = x[1];
            let polynomial = p.low.x + c * (p.low.y + c * (p.low.z + c * (p.low.w + c * (p.high.x + c * p.high.y))));
            y = vec4f(schlick(schlick_f0(x[0]), c), polynomial, 0.0, 0.0);",
        domain: "eta 1 to 3, cosine 0 to 1",
        tolerance: 1e-5,
        reason: "the polynomial's terms of size 10 cancel",
        calls: CALLS,
        draw: |r| vec![between(r, 1.0, 3.0), between(r, 0.0, 1.0)],
        reference: |x| vec![schlick(x[0], x[1]); 2],
    },
    Parity {
        covers: &["circular_product"],
        file: "lib/xu2011_azimuth.wgsl",
        call: "y.x = circular_product(x[0], x[1], sin(0.5 * x[2]) * sin(0.5 * x[2]));",
        domain: "concentrations 0.1 to 500, all differences",
        tolerance: 1e-3,
        reason: "the table of i0e is linear between 256 places",
        calls: 300,
        draw: |r| vec![log_between(r, 0.1, 500.0), log_between(r, 0.1, 500.0), between(r, -PI, PI)],
        reference: |x| {
            let steps = 4096;
            let at = |phi: f64| (x[0] * (phi.cos() - 1.0) + x[1] * ((phi - x[2]).cos() - 1.0)).exp();
            let width = TAU / f64::from(steps);
            vec![(0..steps).map(|i| width * at(width * f64::from(i))).sum()]
        },
    },
    Parity {
        covers: &["xu_moments"],
        file: "lib/tables.wgsl",
        call: "y = vec4f(xu_moments(x[0], x[1], u32(x[2])), 0.0);",
        domain: "eta 1.1 to 3, theta_d 0 to 1.5, TT and TRT",
        tolerance: 3e-3,
        reason: "linear between 128 x 64 places",
        calls: 300,
        draw: |r| vec![between(r, 1.1, 3.0), between(r, 0.0, 1.5), between(r, 1.0, 3.0).floor()],
        reference: |x| {
            let moment = |k: i32| {
                over_h(|h| {
                    let reflected = schlick(x[0], x[1].cos() * (1.0 - h * h).max(0.0).sqrt());
                    (1.0 - reflected).powi(2) * reflected.powi(x[2] as i32 - 1) * h.powi(k)
                })
            };
            vec![moment(0), moment(2), moment(4)]
        },
    },
    Parity {
        covers: &["xu_energy"],
        file: "lib/xu2011_azimuth.wgsl",
        call: "
            let r = refraction(x[0], cos(x[1]));
            let e = xu_energy(r, vec3f(x[2]), u32(x[3]), xu_moments(x[0], x[1], u32(x[3])));
            y = vec4f(e.through.x, e.energy.x, 0.0, 0.0);",
        domain: "eta 1.3 to 1.9, theta_d 0 to 1.4, sigma_a 0 to 1, TT and TRT",
        tolerance: 0.02,
        reason: "Taylor's expansion to h^4, as printed",
        calls: 300,
        draw: |r| {
            vec![
                between(r, 1.3, 1.9),
                between(r, 0.0, 1.4),
                between(r, 0.0, 1.0),
                between(r, 1.0, 3.0).floor(),
            ]
        },
        reference: |x| {
            let eta_cos = (x[0] * x[0] - x[1].sin().powi(2)).sqrt();
            let (eta_p, sigma) = (eta_cos / x[1].cos(), x[3] * x[2] * x[0] / eta_cos);
            let t = |h: f64| (-2.0 * sigma * (1.0 - (h / eta_p).powi(2)).sqrt()).exp();
            let energy = over_h(|h| {
                let reflected = schlick(x[0], x[1].cos() * (1.0 - h * h).max(0.0).sqrt());
                0.5 * (1.0 - reflected).powi(2) * reflected.powi(x[3] as i32 - 1) * t(h)
            });
            vec![t(0.0), energy]
        },
    },
    Parity {
        covers: &["xu_lobe", "xu_bandwidth"],
        file: "lib/xu2011_azimuth.wgsl",
        call: "
            let b = vec3f(x[0], 1.0, 2.0);
            y.x = xu_lobe(b, xu_bandwidth(vec3f(x[1]), b), 1e-6, 0.5).x;",
        domain: "heights 1 to 10, energies that make widths of 0.02 to 0.3, no light's shape: the energy comes back",
        tolerance: 0.01,
        reason: "a circular Gaussian's integral is sqrt(pi) times its bandwidth within bandwidth^2 / 16",
        calls: CALLS,
        draw: |r| {
            let height = between(r, 1.0, 10.0);
            vec![height, height * PI.sqrt() * between(r, 0.02, 0.3)]
        },
        reference: |x| vec![x[1]],
    },
    Parity {
        covers: &["xu_trt_surface", "xu_oblique"],
        file: "lib/xu2011_trt.wgsl",
        call: "
            let r = refraction(x[0], x[1]);
            y = vec4f(xu_trt_surface(x[0], x[1]), xu_oblique(vec3f(x[2]), r).x, 0.0, 0.0);",
        domain: "eta' between 1.45 and 1.95, sigma_a 0 to 2: the rays that leave where they came from, found by their offset",
        tolerance: 1e-3,
        reason: "a difference quotient in the reference",
        calls: CALLS,
        draw: |r| {
            let cos_d = between(r, 0.6, 1.0);
            let eta_p = between(r, 1.45, 1.95);
            vec![(1.0 + cos_d * cos_d * (eta_p * eta_p - 1.0)).sqrt(), cos_d, between(r, 0.0, 2.0)]
        },
        reference: |x| {
            let eta_cos = (x[0] * x[0] - 1.0 + x[1] * x[1]).sqrt();
            let eta_p = eta_cos / x[1];
            let surface = |cos_i: f64| schlick(x[0], cos_i) * (1.0 - schlick(x[0], cos_i)).powi(2);
            let phi = |h: f64| 4.0 * (h / eta_p).asin() - 2.0 * h.asin();
            // Phi(h) = 0 beyond the caustic, by bisection.
            let (mut low, mut high) = (((4.0 - eta_p * eta_p) / 3.0).sqrt(), 1.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if phi(middle) > 0.0 { low = middle } else { high = middle }
            }
            let step = 1e-6;
            let slope = ((phi(low + step) - phi(low - step)) / (2.0 * step)).abs();
            let cos_t = (1.0 - (low / eta_p).powi(2)).sqrt();
            let through = (-4.0 * x[2] * cos_t * x[0] / eta_cos).exp();
            vec![surface(x[1]), 2.0 * 0.5 * through * surface(x[1] * (1.0 - low * low).sqrt()) / slope]
        },
    },
    Parity {
        covers: &["gaussian_share"],
        file: "lib/single_xu2011.wgsl",
        call: "let s = gaussian_share(x[0]); y = vec4f(s, 0.0, 0.0);",
        domain: "[-4, 4]: erf and exp(-x^2)",
        tolerance: 2e-6,
        reason: "a fit good to 1.5e-7 and its roundings",
        calls: 300,
        draw: |r| vec![between(r, -4.0, 4.0)],
        reference: |x| {
            let steps = 4000;
            let width = x[0] / f64::from(steps);
            let sum: f64 = (0..steps).map(|i| (-(width * (f64::from(i) + 0.5)).powi(2)).exp()).sum();
            vec![2.0 / PI.sqrt() * sum * width, (-x[0] * x[0]).exp()]
        },
    },
    Parity {
        covers: &["lobe_span", "lobe_sample"],
        file: "lib/single_directional.wgsl",
        call: "
            let lobe = lobe_span(x[0]);
            y = vec4f(lobe_sample(lobe, x[1]) / min(lobe.lambda_sq, 2.0), lobe.lambda_sq * lobe.span / min(lobe.lambda_sq, 4.0), 0.0, 0.0);",
        domain: "lambda 0.001 to 1000, shares 0 to 0.99",
        tolerance: 2e-5,
        reason: "a logarithm of one minus the share",
        calls: CALLS,
        draw: |r| vec![log_between(r, 1e-3, 1e3), between(r, 0.0, 0.99)],
        reference: |x| {
            let lambda_sq = x[0] * x[0];
            let span = -(-4.0 / lambda_sq).exp_m1();
            let depth = -0.5 * lambda_sq * (-x[1] * span).ln_1p();
            vec![depth / lambda_sq.min(2.0), lambda_sq * span / lambda_sq.min(4.0)]
        },
    },
];

#[test]
fn parts_of_the_schemes_agree_with_float64() {
    hold(PARITIES);
}
