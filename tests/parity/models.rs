//! What the models of d'Eon 2011 and of Kajiya and Kay add.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use balayage_render::optics::azimuthal::CrossSection;
use balayage_render::optics::bessel::i0e;
use balayage_render::optics::circular::{AzimuthShare, DetectedHalf, DetectedLight, Kernel, Unit};
use balayage_render::optics::{Direction, Fibre, SrbfLight, deon, kajiya_kay};
use rand_pcg::Pcg64Mcg;

use super::{ARGUMENTS, CALLS, Parity, between, hold, log_between};

/// eta, cos theta_d, sigma_a, gamma.
fn ray(r: &mut Pcg64Mcg) -> Vec<f64> {
    vec![
        between(r, 1.05, 2.5),
        between(r, 0.1, 1.0),
        log_between(r, 0.01, 3.0),
        between(r, 0.01, FRAC_PI_2 - 0.05),
    ]
}

/// Cross-section of `ray`'s arguments.
fn section(x: &[f64; ARGUMENTS]) -> CrossSection {
    CrossSection::new(x[0], x[1].acos())
}

/// A fibre of absorption x[0] at alpha = -0.07, beta = 0.1 with Marschner's ratios and w_c = 0.25.
fn fibre(sigma_a: f64) -> Fibre {
    let (alpha, beta) = (f64::from(-0.07_f32), f64::from(0.1_f32));
    Fibre {
        eta: f64::from(1.55_f32),
        eccentricity: 1.0,
        sigma_a: [sigma_a; 3],
        alpha: [alpha, -0.5 * alpha, -1.5 * alpha],
        beta: [beta, 0.5 * beta, 2.0 * beta],
        azimuthal_width: 0.25,
    }
}

fn at(theta: f64, phi: f64) -> Direction {
    Direction { theta, phi }
}

const PARITIES_RAY: &str = "
    let ray = ray_at(refraction(x[0], x[1]), vec3f(x[2]), sin(x[3]), cos(x[3]));
    let second = next_exit(ray, first_exit(ray));
    let third = next_exit(ray, second);
    y = vec4f(first_exit(ray).energy.x, second.energy.x, third.energy.x, energy_beyond(ray, third).x);";

const PARITIES_AZIMUTH: &str = "
    let ray = ray_at(refraction(x[0], x[1]), vec3f(x[2]), sin(x[3]), cos(x[3]));
    let third = next_exit(ray, next_exit(ray, first_exit(ray)));
    y = vec4f(third.azimuth, first_exit(ray).azimuth);";

const FIBRE_AVERAGES: &str = "
    let a = scattering_averages(Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25), x[0], x[1]);
    y = vec4f(a.a_f, a.a_b, a.beta_f, a.alpha_b);";

const FORWARD: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    y.x = forward_scattering(prepare_forward(f, x[1]), x[2], cos(x[3]), 0.5 * x[4] * x[4]).x;";

const GLOBAL: &str = "
    let f = Fibre(vec3f(x[0]), 1.55, vec3f(-0.07, 0.035, 0.105), 1.0, vec3f(0.1, 0.05, 0.2), 0.25);
    let g = global_scattering(f, x[1], x[3], x[2], 0.0, x[4]);
    y = vec4f(g.r.x, g.tt.x, g.trt.x, 0.0);";

pub const PARITIES: &[Parity] = &[
    Parity {
        covers: &["ray_at", "first_exit", "next_exit", "energy_beyond"],
        file: "lib/ray.wgsl",
        call: PARITIES_RAY,
        domain: "eta 1.05 to 2.5, cos theta_d 0.1 to 1, sigma_a 0.01 to 3, gamma up to 0.05 before grazing: A_1, A_2, A_3 and the sum of all above",
        tolerance: 1e-4,
        reason: "1 - F loses digits near grazing, and its square twice as many",
        calls: CALLS,
        draw: ray,
        reference: |x| {
            let a = |p: u32| section(x).attenuation(p, x[3], &[x[2]; 3])[0];
            let beyond = (4..1000).map(a).sum();
            vec![a(1), a(2), a(3), beyond]
        },
    },
    Parity {
        covers: &["turned"],
        file: "lib/ray.wgsl",
        call: PARITIES_AZIMUTH,
        domain: "as before: cosine and sine of the exit azimuths of p = 3 and p = 1",
        tolerance: 2e-5,
        reason: "four products of rounded unit vectors, sines of f32",
        calls: CALLS,
        draw: ray,
        reference: |x| {
            let gamma_t = (x[3].sin() / ((x[0] * x[0] - 1.0 + x[1] * x[1]).sqrt() / x[1])).asin();
            let azimuth = |p: f64| p * (2.0 * gamma_t + PI) - 2.0 * x[3];
            vec![
                azimuth(3.0).cos(),
                azimuth(3.0).sin(),
                azimuth(1.0).cos(),
                azimuth(1.0).sin(),
            ]
        },
    },
    Parity {
        covers: &["harmonics"],
        file: "lib/detector.wgsl",
        call: "let h = harmonics(x[0]); y = vec4f(h, 0.0);",
        domain: "kappa 1e-4 to 1e4",
        tolerance: 1e-3,
        reason: "Amos' bound of I_8 / I_7 is 1 % off at worst; seven steps of the recurrence divide that",
        calls: CALLS,
        draw: |r| vec![log_between(r, 1e-4, 1e4)],
        reference: |x| {
            let steps = 2048;
            let (mut sums, mut norm) = ([0.0; 3], 0.0);
            for i in 0..steps {
                let t = TAU * (f64::from(i) + 0.5) / f64::from(steps);
                let density = (x[0] * (t.cos() - 1.0)).exp();
                norm += density;
                for (m, sum) in (1..).zip(&mut sums) {
                    *sum += density * (f64::from(m) * t).cos();
                }
            }
            sums.map(|s| s / norm).to_vec()
        },
    },
    Parity {
        covers: &["detected_light", "detected_at"],
        file: "lib/detector.wgsl",
        call: "y.x = detected_at(detected_light(x[0], x[1] * x[1]), cos(x[2]), 0.0);",
        domain: "kappa 0.01 to 500, detector 0.06 to 0.7 rad, any azimuth",
        tolerance: 0.03,
        reason: "fourth and higher harmonics of a circular Gaussian and of the true convolution differ",
        calls: 1000,
        draw: |r| {
            vec![
                log_between(r, 0.01, 500.0),
                log_between(r, 0.06, 0.7),
                between(r, -PI, PI),
            ]
        },
        reference: |x| vec![DetectedLight::new(x[0], x[1]).value(x[2])],
    },
    Parity {
        covers: &["m_p", "cone_scale", "cone_variance", "folded", "i0e"],
        file: "lib/cone.wgsl",
        call: "y.x = m_p(cone_variance(x[0]), x[1], x[2]) * sqrt(cone_variance(x[0]));",
        domain: "beta 0.5 to 60 degrees, theta_i in +-pi/2, theta_r up to 0.3 beyond the poles, within four widths of the cone; times its width",
        tolerance: 1e-3,
        reason: "the exponent's rounding at narrow cones: an angle of 1 is exact to 6e-8, its distance from the axis is divided by 0.017",
        calls: CALLS,
        draw: |r| {
            let beta = log_between(r, 0.5_f64.to_radians(), 60_f64.to_radians());
            let theta_i = between(r, -FRAC_PI_2, FRAC_PI_2);
            let theta_r = (-theta_i + between(r, -8.0, 8.0) * beta).clamp(-FRAC_PI_2 - 0.3, FRAC_PI_2 + 0.3);
            vec![beta, theta_i, theta_r]
        },
        reference: |x| {
            let v = (2.0 * x[0]).powi(2);
            vec![deon::m_p(v, x[1], x[2]) * v.sqrt()]
        },
    },
    Parity {
        covers: &["cone_product", "cone_node"],
        file: "lib/cone.wgsl",
        call: "
            let g = cone_product(cone_variance(x[0]), x[1], x[2], 1.0 / (x[3] * x[3]));
            for (var k = 0u; k < 6u; k++) {
                y.x += cone_node(g, 6u, k, cone_variance(x[0]), x[1], 0.0, x[2], 1.0 / (x[3] * x[3])).weight;
            }
            y.x = y.x * sqrt(1.0 + cone_variance(x[0]) / (x[3] * x[3]));",
        domain: "beta 0.5 to 60 degrees, |theta| <= 1.5, lambda 0.05 to 10; scaled to order one",
        tolerance: 0.02,
        reason: "six Gauss nodes of a square root that the poles cut off, worst where a wide cone meets a wide light",
        calls: 400,
        draw: |r| {
            let beta = log_between(r, 0.5_f64.to_radians(), 60_f64.to_radians());
            let lambda = log_between(r, 0.05, 10.0);
            let theta_r = between(r, -1.5, 1.5);
            let theta_j = (-theta_r + between(r, -1.0, 1.0) * (2.0 * beta + lambda)).clamp(-1.5, 1.5);
            vec![beta, theta_r, theta_j, lambda]
        },
        reference: |x| {
            let v = (2.0 * x[0]).powi(2);
            let steps = 4000;
            let width = PI / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| {
                    let theta = -FRAC_PI_2 + width * (f64::from(i) + 0.5);
                    let half = (0.5 * (theta - x[2])).sin();
                    deon::m_p(v, theta, x[1]) * theta.cos() * (-4.0 * half * half / (x[3] * x[3])).exp()
                })
                .sum();
            vec![sum * width * (1.0 + v / (x[3] * x[3])).sqrt()]
        },
    },
    Parity {
        covers: &["azimuth_deon_r", "azimuth_deon_tt", "azimuth_deon_higher", "seen", "deon_gamma_count"],
        file: "lib/azimuth_deon.wgsl",
        call: "
            let r = refraction(x[0], x[1]);
            let l = detected_light(x[4], x[5] * x[5]);
            let azimuth = vec2f(cos(x[6]), sin(x[6]));
            let higher = azimuth_deon_higher(r, vec3f(x[2]), l, azimuth);
            y = vec4f(azimuth_deon_r(fresnel_polynomial(x[0]), x[1], l, abs(cos(0.5 * x[6]))),
                azimuth_deon_tt(r, vec3f(x[2]), l, azimuth).x, higher.p2.x + higher.p3.x, higher.remainder.x);",
        domain: "eta 1.3 to 1.8, cos theta_d 0.4 to 1, sigma_a 0.01 to 3, kappa 0.1 to 50, detector 0.1 to 0.5 rad: N_0, N_1, N_2 + N_3 and all above against the light",
        tolerance: 0.06,
        reason: "eight gamma nodes, and a circular Gaussian instead of the convolution",
        calls: 60,
        draw: |r| {
            vec![
                between(r, 1.3, 1.8),
                between(r, 0.4, 1.0),
                log_between(r, 0.01, 3.0),
                0.0,
                log_between(r, 0.1, 50.0),
                log_between(r, 0.1, 0.5),
                between(r, -PI, PI),
            ]
        },
        reference: |x| {
            let kernel = DetectedLight::new(x[4], x[5]);
            let n = |p: u32| section(x).integrate(p, &[x[2]; 3], &kernel, x[6], 1e-4).value[0];
            let energy = |p: u32| section(x).integrate(p, &[x[2]; 3], &Unit, 0.0, 1e-6).value[0];
            let above: f64 = (4..40).map(energy).sum();
            vec![n(0), n(1), n(2) + n(3), i0e(x[4]) * above]
        },
    },
    Parity {
        covers: &["forward_share", "outward_shift"],
        file: "lib/half_circle.wgsl",
        call: "y.x = forward_share(vec2f(cos(x[0]), sin(x[0])), x[1]);",
        domain: "any azimuth, detector 0.02 to 1 rad",
        tolerance: 2e-3,
        reason: "erf by a tanh within 4e-4; a wide detector meets itself behind the circle",
        calls: 1000,
        draw: |r| vec![between(r, -PI, PI), log_between(r, 0.02, 1.0)],
        reference: |x| vec![DetectedHalf::share(AzimuthShare::Forward, x[1]).value(x[0])],
    },
    Parity {
        covers: &["scattering_averages", "azimuth_split", "averages_of"],
        file: "lib/averages_deon.wgsl",
        call: FIBRE_AVERAGES,
        domain: "sigma_a 0.01 to 10, |theta| <= 1.4: a_f, a_b, beta_f, alpha_b of all orders",
        tolerance: 0.01,
        reason: "six Gauss nodes in theta_o, sixteen in gamma",
        calls: 40,
        draw: |r| vec![log_between(r, 0.01, 10.0), between(r, -1.4, 1.4)],
        reference: |x| {
            let a = deon::scattering_averages(&fibre(x[0]), x[1], 1e-4).unwrap();
            vec![a.a_f[0], a.a_b[0], a.beta_f[0], a.alpha_b[0]]
        },
    },
    Parity {
        covers: &["global_scattering", "window_mean", "window_seen"],
        file: "lib/global_deon.wgsl",
        call: GLOBAL,
        domain: "sigma_a 0.05 to 3, |theta| <= 0.9, any azimuth, sigma_f 0.2 to 1",
        tolerance: 0.04,
        reason: "three outer and seven gamma nodes",
        calls: 40,
        draw: forward,
        reference: |x| {
            let g = deon::global_scattering(&fibre(x[0]), at(x[1], x[3]), at(x[2], 0.0), x[4], 1e-3).unwrap();
            vec![g.r[0], g.tt[0], g.trt[0]]
        },
    },
    Parity {
        covers: &["forward_scattering", "series_of"],
        file: "lib/forward_deon.wgsl",
        call: FORWARD,
        domain: "sigma_a 0.05 to 3, |theta| <= 0.9, any azimuth, sigma_f 0.2 to 1",
        tolerance: 0.12,
        reason: "one refraction per lobe and four harmonics of the half circle: its edge is worth a tenth",
        calls: 60,
        draw: forward,
        reference: |x| {
            let g = deon::global_scattering(&fibre(x[0]), at(x[1], x[3]), at(x[2], 0.0), x[4], 1e-3).unwrap();
            vec![g.sum()[0]]
        },
    },
    Parity {
        covers: &["kajiya_kay_diffuse", "solid_angle"],
        file: "lib/kajiya_kay_table.wgsl",
        call: "
            let omega = solid_angle(x[1]);
            y.x = kajiya_kay_diffuse(x[0], x[1]) / omega;
            y.y = omega / (x[1] * x[1] / (1.0 + x[1] * x[1]));",
        domain: "any theta_j, lambda 0.002 to 500; the term over the light's solid angle",
        tolerance: 2e-3,
        reason: "32 cells along each axis, bilinear",
        calls: 400,
        draw: |r| vec![between(r, -1.0, 1.0).asin(), log_between(r, 0.002, 500.0)],
        reference: |x| {
            let light = SrbfLight::new(at(x[0], 0.0), x[1]).unwrap();
            let l2 = x[1] * x[1];
            let omega = -PI * l2 * (-4.0 / l2).exp_m1();
            vec![
                kajiya_kay::diffuse(&light, 1e-5).unwrap() / omega,
                omega * (1.0 + l2) / l2,
            ]
        },
    },
    Parity {
        covers: &["kajiya_kay_colour", "mean_reflectance"],
        file: "lib/single_kajiya_kay.wgsl",
        call: "y.x = kajiya_kay_colour(vec3f(x[0])).x; y.y = mean_reflectance(fresnel_polynomial(x[1]));",
        domain: "sigma_a 1e-4 to 10, eta 1 to 3",
        tolerance: 0.01,
        reason: "the Fresnel polynomial is linear between etas, and near eta = 1 the reflectance is not",
        calls: CALLS,
        draw: |r| vec![log_between(r, 1e-4, 10.0), between(r, 1.0, 3.0)],
        reference: |x| vec![kajiya_kay::colour(&[x[0]; 3])[0], kajiya_kay::mean_reflectance(x[1])],
    },
    Parity {
        covers: &["kajiya_kay_specular"],
        file: "lib/single_kajiya_kay.wgsl",
        call: "y.x = kajiya_kay_specular(x[0], x[1], x[2], 1.0 / (x[3] * x[3]), 6u) / solid_angle(x[3]);",
        domain: "n of beta 1 to 20 degrees, |axis| <= 1.4, lambda 0.05 to 2, theta_j within the highlight; over the light's solid angle",
        tolerance: 0.01,
        reason: "six Gauss nodes",
        calls: 200,
        draw: |r| {
            let beta = log_between(r, 1_f64.to_radians(), 20_f64.to_radians());
            let lambda = log_between(r, 0.05, 2.0);
            let axis = between(r, -1.4, 1.4);
            let theta_j = (-axis + between(r, -1.0, 1.0) * (2.0 * beta + lambda)).clamp(-1.5, 1.5);
            vec![kajiya_kay::exponent(beta), axis, theta_j, lambda]
        },
        reference: |x| {
            let light = SrbfLight::new(at(x[2], 0.0), x[3]).unwrap();
            let l2 = x[3] * x[3];
            let omega = -PI * l2 * (-4.0 / l2).exp_m1();
            vec![kajiya_kay::specular(x[0], x[1], &light, 1e-5).unwrap() / omega]
        },
    },
    Parity {
        covers: &["ln_cos"],
        file: "lib/single_kajiya_kay.wgsl",
        call: "y.x = exp(x[0] * ln_cos(x[1]));",
        domain: "cos^n x, n 1 to 1e5, x within four widths; zero behind the highlight",
        tolerance: 1e-4,
        reason: "the exponent's rounding, n x^2 up to 8 and a sine's 1e-6 of it",
        calls: CALLS,
        draw: |r| {
            let n = log_between(r, 1.0, 1e5);
            vec![n, between(r, -4.0, 4.0) / n.sqrt()]
        },
        reference: |x| vec![x[1].cos().max(0.0).powf(x[0])],
    },
];

fn forward(r: &mut Pcg64Mcg) -> Vec<f64> {
    vec![
        log_between(r, 0.05, 3.0),
        between(r, -0.9, 0.9),
        between(r, -0.9, 0.9),
        between(r, -PI, PI),
        between(r, 0.2, 1.0),
    ]
}

#[test]
fn the_other_models_agree_with_float64() {
    hold(PARITIES);
}
