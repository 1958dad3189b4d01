//! Averages over a fibre, and what multiple scattering makes of them.

use std::f64::consts::{FRAC_PI_2, PI};

use balayage_render::gpu::MeanFibre;
use balayage_render::optics::dual::{self, Backward};
use balayage_render::optics::{Averages, Direction, Fibre, global_scattering, scattering_averages};
use balayage_render::param::VertexParams;

use super::{CALLS, Parity, between, hold, log_between};

/// What the table of averages is made for.
pub fn mean_fibre() -> MeanFibre {
    MeanFibre::of(&[params()])
}

fn params() -> VertexParams {
    VertexParams {
        sigma_a: [0.0; 3],
        alpha_rad: -0.07,
        beta_rad: 0.1,
        azimuthal_width: 0.25,
        eta: 1.55,
        eccentricity: 1.0,
        alpha_ratios: [-0.5, -1.5],
        beta_ratios: [0.5, 2.0],
    }
}

/// The same fibre for the reference.
pub fn fibre(sigma_a: [f64; 3]) -> Fibre {
    let (alpha, beta) = (f64::from(-0.07_f32), f64::from(0.1_f32));
    Fibre {
        eta: f64::from(1.55_f32),
        eccentricity: 1.0,
        sigma_a,
        alpha: [alpha, -0.5 * alpha, -1.5 * alpha],
        beta: [beta, 0.5 * beta, 2.0 * beta],
        azimuthal_width: 0.25,
    }
}

/// Averages whose shares add up to at most one, as the table holds them.
pub fn averages(sigma_a: f64, theta: f64) -> Averages {
    let mut averages = scattering_averages(&fibre([sigma_a; 3]), theta, 1e-4).unwrap();
    let excess = (averages.a_f[0] + averages.a_b[0]).max(1.0);
    averages.a_f = averages.a_f.map(|a| a / excess);
    averages.a_b = averages.a_b.map(|a| a / excess);
    averages
}

/// a_f and a_b that a fibre can have, then widths and tilts.
fn shares(r: &mut rand_pcg::Pcg64Mcg) -> Vec<f64> {
    let sum = between(r, 0.05, 1.0);
    let a_f = sum * between(r, 0.0, 0.98);
    vec![
        a_f,
        sum - a_f,
        between(r, 0.02, 0.3),
        between(r, 0.02, 0.3),
        between(r, -0.2, 0.2),
        between(r, -0.2, 0.2),
    ]
}

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["averages_sigma", "averages_theta", "averages_sigma_place", "averages_theta_place"],
        file: "lib/averages_table.wgsl",
        call: "
            y.x = averages_sigma_place(averages_sigma(u32(x[0])));
            y.y = averages_theta_place(averages_theta(u32(x[1])));
            y.z = averages_sigma(31u);
            y.w = averages_theta(0u) + averages_theta(63u);",
        domain: "the 31 x 63 nodes below the last ones: the place of a node's value is the node; absorption ends at 30, inclinations are symmetric",
        tolerance: 1e-5,
        reason: "exp and log of f32",
        calls: CALLS,
        draw: |r| vec![between(r, 0.0, 31.0).floor(), between(r, 0.0, 63.0).floor()],
        reference: |x| vec![x[0], x[1], 0.05 * ((0.20641_f64 * 31.0).exp() - 1.0), 0.0],
    },
    Parity {
        covers: &["decay_per_fibre", "adding_a_b"],
        file: "lib/backward.wgsl",
        call: "y = vec4f(decay_per_fibre(x[0], x[1]), adding_a_b(x[0], x[1]), 0.0, 0.0);",
        domain: "a_f + a_b 0.05 to 1",
        tolerance: 1e-5,
        reason: "without loss the differences under the roots keep 1e-7; k is held above 1e-3",
        calls: CALLS,
        draw: shares,
        reference: |x| vec![dual::extinction(x[0], x[1]).max(1e-3), dual::adding_a_b(x[0], x[1])],
    },
    Parity {
        covers: &["backward_of", "delta_b", "sigma_b"],
        file: "lib/backward.wgsl",
        call: "
            let b = backward_of(FibreAverages(x[0], x[1], x[2], x[3], x[4], x[5], 0.0));
            y = vec4f(b.x, b.y, b.z, b.w);",
        domain: "a_f to 0.9, a_b to 1 - a_f, widths 0.02 to 0.3, tilts to 0.2",
        tolerance: 1e-5,
        reason: "series in 1 / (1 - a_f^2), up to 5^3",
        calls: CALLS,
        draw: |r| {
            let mut drawn = shares(r);
            drawn[0] = drawn[0].min(0.9);
            drawn
        },
        reference: |x| {
            let sigma = 2.0 * dual::sigma_b(x[0], x[1], x[2], x[3]);
            vec![
                dual::adding_a_b(x[0], x[1]),
                2.0 * dual::delta_b(x[0], x[1], x[4], x[5]),
                sigma * sigma,
                dual::zinke_a_b(x[0], x[1]),
            ]
        },
    },
    Parity {
        covers: &["scattering_averages"],
        file: "lib/averages.wgsl",
        call: FIBRE_AVERAGES,
        domain: "sigma_a 0.001 to 10, theta -1.4 to 1.4: a_f, a_b, beta_f, alpha_b",
        tolerance: 3e-3,
        reason: "six nodes in theta, sixteen in gamma",
        calls: 60,
        draw: |r| vec![log_between(r, 1e-3, 10.0), between(r, -1.4, 1.4)],
        reference: |x| {
            let a = scattering_averages(&fibre([x[0]; 3]), x[1], 1e-4).unwrap();
            vec![a.a_f[0], a.a_b[0], a.beta_f[0], a.alpha_b[0]]
        },
    },
    Parity {
        covers: &["fibre_averages", "averages_entry"],
        file: "lib/averages_table.wgsl",
        call: "let a = fibre_averages(x[0], x[1]); y = vec4f(a.a_f, a.a_b, a.beta_f, a.k);",
        domain: "sigma_a 0.001 to 10, theta -1.4 to 1.4",
        tolerance: 0.01,
        reason: "bilinear between 32 absorptions and 64 inclinations",
        calls: 60,
        draw: |r| vec![log_between(r, 1e-3, 10.0), between(r, -1.4, 1.4)],
        reference: |x| {
            let a = averages(x[0], x[1]);
            vec![a.a_f[0], a.a_b[0], a.beta_f[0], dual::extinction(a.a_f[0], a.a_b[0])]
        },
    },
    Parity {
        covers: &["backward_averages"],
        file: "lib/averages_table.wgsl",
        call: "y = backward_averages(averages_sigma_place(x[0]), x[1]);",
        domain: "sigma_a 0.03 to 10, theta -1.2 to 1.2: A_b, Delta_b, sigma_b^2 and the printed A_b",
        tolerance: 0.02,
        reason: "bilinear between 32 absorptions and 64 inclinations; the series of low absorption are steep",
        calls: 60,
        draw: |r| vec![log_between(r, 0.03, 10.0), between(r, -1.2, 1.2)],
        reference: |x| {
            let b = Backward::of(&averages(x[0], x[1]));
            vec![b.a_b_adding[0], b.delta_b[0], b.sigma_b[0].powi(2), b.a_b_zinke[0]]
        },
    },
    Parity {
        covers: &["half_space_reflectance"],
        file: "lib/averages_table.wgsl",
        call: "y.x = half_space_reflectance(x[0]);",
        domain: "sigma_a 0.01 to 10",
        tolerance: 0.01,
        reason: "linear between 32 absorptions; 64 inclinations",
        calls: 12,
        draw: |r| vec![log_between(r, 0.01, 10.0)],
        reference: |x| vec![dual::mean_reflectance(&fibre([x[0]; 3]), 1e-3).unwrap()[0]],
    },
    Parity {
        covers: &["forward_scattering", "prepare_forward", "window_series", "window_at"],
        file: "lib/forward.wgsl",
        call: FORWARD,
        domain: "sigma_a 0.01 to 3, |theta| <= 1, any azimuth, variance of sigma_f 0.25 to 1.2",
        tolerance: 0.15,
        reason: "one refraction a lobe, four odd harmonics, cosines by their means: a tenth of Eq 27's root mean square at worst",
        calls: 60,
        draw: |r| {
            let theta_o = between(r, -1.0, 1.0);
            vec![log_between(r, 0.01, 3.0), theta_o, between(r, -1.0, 1.0), between(r, -PI, PI), between(r, 0.25, 1.2)]
        },
        reference: |x| {
            let at = |theta, phi| Direction { theta, phi };
            let lobes = global_scattering(&fibre([x[0]; 3]), at(x[1], x[3]), at(x[2], 0.0), x[4], 1e-3).unwrap();
            vec![lobes.sum()[0]]
        },
    },
    Parity {
        covers: &["half_circle_share", "error_function"],
        file: "lib/global.wgsl",
        call: "y = vec4f(half_circle_share(x[0], x[1]), error_function(x[2]), 0.0, 0.0);",
        domain: "cosine -1 to 1, bandwidth 0.05 to 0.5; erf on [-5, 5]",
        tolerance: 0.01,
        reason: "a cubic in tanh, and the series of asin",
        calls: 500,
        draw: |r| vec![between(r, -1.0, 1.0), 1.0 / between(r, 0.05, 0.5), between(r, -5.0, 5.0)],
        reference: |x| {
            let erf = |x: f64| {
                let steps = 400;
                let width = x / f64::from(steps);
                let sum: f64 = (0..steps).map(|i| (-((f64::from(i) + 0.5) * width).powi(2)).exp()).sum();
                2.0 / PI.sqrt() * width * sum
            };
            vec![0.5 + 0.5 * erf(x[0].asin() * x[1]), erf(x[2])]
        },
    },
    Parity {
        covers: &["unpack_path"],
        file: "lib/multiple.wgsl",
        call: "
            let p = unpack_path(vec4u(pack2x16float(vec2f(x[0], x[1])), pack2x16float(vec2f(x[2], x[3])),
                pack2x16float(vec2f(x[4], x[5])), pack2x16float(vec2f(x[6], x[7]))));
            y = vec4f(p.s_f.x + 2.0 * p.s_f.y + 4.0 * p.s_f.z, p.spread, p.kappa.x + 2.0 * p.kappa.y + 4.0 * p.kappa.z, p.n);",
        domain: "sums and spread to 1, kappa and n to 6",
        tolerance: 1e-3,
        reason: "16-bit floats",
        calls: CALLS,
        draw: |r| {
            let mut drawn: Vec<f64> = (0..4).map(|_| between(r, 0.0, 1.0)).collect();
            drawn.extend((0..4).map(|_| between(r, 0.0, 6.0)));
            drawn
        },
        reference: |x| {
            vec![
                x[0] + 2.0 * x[1] + 4.0 * x[2],
                x[3],
                x[4] + 2.0 * x[5] + 4.0 * x[6],
                x[7],
            ]
        },
    },
    Parity {
        covers: &["m2_terms", "prepare_multiple", "arriving", "local_scattering", "backward"],
        file: "lib/multiple.wgsl",
        call: M2,
        domain: "sigma_a 0.1 to 3, |theta| <= 0.8, any azimuth, n 0.2 to 3, t_f from exp(-n) to 1, kappa 0 to 4: L and U of an averages table that is exact at its nodes",
        tolerance: 0.02,
        reason: "entries of the table are linear between nodes",
        calls: 60,
        draw: |r| {
            let n = between(r, 0.2, 3.0);
            let direct = (-n).exp();
            vec![
                log_between(r, 0.1, 3.0),
                between(r, -0.8, 0.8),
                between(r, -0.8, 0.8),
                between(r, -PI, PI),
                n,
                direct + (1.0 - direct) * between(r, 0.0, 1.0),
                between(r, 0.01, 0.1),
                between(r, 0.0, 4.0),
            ]
        },
        reference: m2,
    },
    Parity {
        covers: &["zinke2008_terms", "all_lobes"],
        file: "lib/multiple.wgsl",
        call: ZINKE,
        domain: "sigma_a 0.1 to 3, |theta| <= 0.8, any azimuth, lambda 0.1 to 0.8, n 0.2 to 3: D of Eq 27 with the light's bandwidth inside sigma_f",
        tolerance: 0.03,
        reason: "draft node counts of the global term",
        calls: 40,
        draw: |r| {
            let n = between(r, 0.2, 3.0);
            let direct = (-n).exp();
            vec![
                log_between(r, 0.1, 3.0),
                between(r, -0.8, 0.8),
                between(r, -0.8, 0.8),
                between(r, -PI, PI),
                n,
                direct + (1.0 - direct) * between(r, 0.0, 1.0),
                between(r, 0.01, 0.1),
                between(r, 0.1, 0.8),
            ]
        },
        reference: |x| {
            let direct = (-x[4]).exp();
            let spread = x[6] * (1.0 - direct);
            let sigma_f = (x[7] * x[7] + 2.0 * spread).sqrt();
            let at = |theta, phi| Direction { theta, phi };
            let lobes = global_scattering(&fibre([x[0]; 3]), at(x[1], x[3]), at(x[2], 0.0), sigma_f, 1e-3).unwrap();
            vec![0.7 * (x[5] - direct) * lobes.sum()[0]]
        },
    },
];

const FIBRE_AVERAGES: &str = "
    let a = scattering_averages(Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25), x[0], x[1]);
    y = vec4f(a.a_f, a.a_b, a.beta_f, a.alpha_b);";

const FORWARD: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    y.x = forward_scattering(prepare_forward(f, x[1]), x[2], cos(x[3]), 0.5 * x[4] * x[4]).x;";

const M2: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    let terms = m2_terms(prepare_multiple(f, x[1], x[3]), x[2], 0.0, PathRecord(vec3f(-log(x[5])), x[6], vec3f(x[7]), x[4]));
    y = vec4f(terms.l.x, terms.u.x, 0.0, 0.0);";

const ZINKE: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    let terms = zinke2008_terms(prepare_multiple(f, x[1], x[3]), x[2], 0.0, x[7], PathRecord(vec3f(-log(x[5])), x[6], vec3f(0.0), x[4]));
    y = vec4f(terms.d.x, 0.0, 0.0, 0.0);";

/// L and U of M2, from the reference's averages. A finite layer sends back (1 - b) / (1 - rho^2 b) of what a half space does.
fn m2(x: &[f64; super::ARGUMENTS]) -> Vec<f64> {
    let [sigma_a, theta_o, theta, phi, n, t_f, spread, kappa] = std::array::from_fn(|i| x[i]);
    let direct = (-n).exp();
    let scattered = t_f - direct;
    let rho = dual::mean_reflectance(&fibre([sigma_a; 3]), 1e-3).unwrap()[0];
    let b = (-kappa).exp();
    let depth = (1.0 - b) / (1.0 - rho * rho * b);
    let phi_d = phi.abs();
    let back = Backward::of(&averages(sigma_a, 0.5 * (theta_o - theta)));
    let around = |light_variance: f64| {
        let mean = back.delta_b[0] - theta_o;
        let variance = back.sigma_b[0].powi(2) + light_variance;
        let theta_i = (theta + (mean - theta) * light_variance / variance).clamp(-FRAC_PI_2, FRAC_PI_2);
        let normal = (-0.5 * (mean - theta).powi(2) / variance).exp() / (2.0 * PI * variance).sqrt();
        let cosines = (theta_i.cos() / (0.5 * (theta_o - theta_i)).cos()).powi(2);
        2.0 * back.a_b_adding[0] * normal * cosines / theta.cos()
    };
    let lit = if phi_d < FRAC_PI_2 { 1.0 / PI } else { 0.0 };
    let local =
        depth * (direct * lit * around(0.0) + scattered * (PI - phi_d) / (PI * PI) * around(4.0 * spread));
    let at_view = averages(sigma_a, theta_o);
    let share = at_view.a_f[0] + (at_view.a_b[0] - at_view.a_f[0]) * phi_d / PI;
    vec![local, rho * depth * t_f * share / PI]
}

#[test]
fn dual_scattering_agrees_with_float64() {
    hold(PARITIES);
}
