//! Seeded points of the scattering model: hair as people paint it, and what must not break a shader.

use std::f64::consts::{FRAC_PI_2, PI};

use rand::Rng;

use super::probe::{ProbeCase, ProbeResult};

/// Hair as people paint it: Marschner's ratios, eta 1.2 to 1.9, lights of bandwidth 0.06 to 1.4, half of them near the mirror cone.
pub fn hair(r: &mut impl Rng, elliptic: bool) -> ProbeCase {
    let tilt = -between(r, 0.005, 0.17);
    let width = log_between(r, 0.03, 0.25);
    let absorption = log_between(r, 0.01, 3.0);
    let theta_o = between(r, -1.0, 1.0).asin();
    let lambda_j = log_between(r, 0.06, 1.4);
    let theta_j = if r.random() {
        between(r, -1.0, 1.0).asin()
    } else {
        (-theta_o + between(r, -1.0, 1.0) * (2.0 * width + lambda_j)).clamp(-1.5, 1.5)
    };
    ProbeCase {
        eta: between(r, 1.2, 1.9),
        eccentricity: if elliptic { between(r, 0.8, 1.25) } else { 1.0 },
        sigma_a: [
            absorption,
            absorption * between(r, 1.0, 2.5),
            absorption * between(r, 1.0, 5.0),
        ],
        alpha: [tilt, -0.5 * tilt, -1.5 * tilt],
        beta: [width, 0.5 * width, 2.0 * width],
        azimuthal_width: between(r, 0.08, 0.45),
        theta_o,
        phi_o: between(r, -PI, PI),
        theta_j,
        phi_j: between(r, -PI, PI),
        lambda_j,
        sigma_f: between(r, 0.13, 1.4),
    }
}

/// No number, no finite number, too large, denormal, zero, negative.
pub const POISON: [f64; 8] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e30,
    -1e30,
    1e-42,
    0.0,
    -1.0,
];

/// A point whose every value is mostly an edge of its range, poison, or where a formula has a pole; else anywhere in the range.
pub fn stress(r: &mut impl Rng) -> ProbeCase {
    let lobes = |r: &mut _, low: f64, high: f64, special: &[f64]| -> [f64; 3] {
        std::array::from_fn(|_| stressed(r, low, high, special))
    };
    let with = |more: &[f64]| [&POISON[..], more].concat();
    let angles = with(&[
        FRAC_PI_2,
        -FRAC_PI_2,
        f64::from(std::f32::consts::FRAC_PI_2),
        FRAC_PI_2 - 1e-4,
    ]);
    let absorptions = with(&[1e-30, 50.0]);
    // At theta_d = 0 the effective index is the index itself: 2 is where TRT's caustic vanishes.
    let indices = with(&[1.0, 1.0 + 1e-7, 2.0, 3.0]);
    let azimuths = with(&[PI, -PI, 2.0 * PI, -2.0 * PI, 1e3 * PI]);
    let degree = PI / 180.0;
    ProbeCase {
        eta: stressed(r, 1.0, 3.0, &indices),
        eccentricity: if r.random() {
            1.0
        } else {
            stressed(r, 0.5, 2.0, &POISON)
        },
        sigma_a: lobes(r, 1e-30, 50.0, &absorptions),
        alpha: lobes(r, -0.3, 0.3, &POISON),
        beta: lobes(r, 0.1 * degree, 60.0 * degree, &POISON),
        azimuthal_width: stressed(r, 1e-3, 2.0, &POISON),
        theta_o: stressed(r, -FRAC_PI_2, FRAC_PI_2, &angles),
        phi_o: stressed(r, -7.0, 7.0, &azimuths),
        theta_j: stressed(r, -FRAC_PI_2, FRAC_PI_2, &angles),
        phi_j: stressed(r, -7.0, 7.0, &azimuths),
        lambda_j: stressed(r, 1e-3, 10.0, &POISON),
        sigma_f: stressed(r, 1e-3, 3.0, &POISON),
    }
}

/// One value: an edge of the range or something special, else inside, uniform or log-uniform.
fn stressed(r: &mut impl Rng, low: f64, high: f64, special: &[f64]) -> f64 {
    match r.random_range(0..6) {
        0 => special[r.random_range(0..special.len())],
        1 => low,
        2 => high,
        3 if low > 0.0 => log_between(r, low, high),
        _ => between(r, low, high),
    }
}

fn between(r: &mut impl Rng, low: f64, high: f64) -> f64 {
    r.random_range(low..high)
}

fn log_between(r: &mut impl Rng, low: f64, high: f64) -> f64 {
    r.random_range(low.ln()..high.ln()).exp()
}

/// Values of a case outside the ranges of `shaders/README.md`, which the shaders move to the nearest edge (or, where they are no number,
/// to a default).
pub fn repairs(case: &ProbeCase) -> usize {
    let outside = |values: &[f64], low: f64, high: f64| {
        let inside = |x: &&f64| (low as f32..=high as f32).contains(&(**x as f32));
        values.len() - values.iter().filter(inside).count()
    };
    outside(&case.sigma_a, 0.0, 1e4)
        + outside(&[case.eta], 1.0, 3.0)
        + outside(&[case.eccentricity], 0.5, 2.0)
        + outside(&case.alpha, -FRAC_PI_2, FRAC_PI_2)
        + outside(&case.beta, 1e-3, 1.5)
        + outside(&[case.azimuthal_width], 1e-3, 4.0)
        + outside(&[case.theta_o, case.theta_j], -FRAC_PI_2, FRAC_PI_2)
        + outside(&[case.phi_o, case.phi_j], -1e6, 1e6)
        + outside(&[case.lambda_j], 1e-3, 1e3)
        + outside(&[case.sigma_f], 1e-3, 1e3)
}

/// What is wrong with an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defect {
    /// A value is no finite number.
    NotFinite(&'static str),
    /// A value is below zero.
    Negative(&'static str),
    /// A value is more than a light of radiance one can give.
    TooLarge(&'static str),
}

/// The first value of an answer that is not finite, negative, or more than a light of radiance one can give.
pub fn defect(r: &ProbeResult) -> Option<Defect> {
    // cos^2 theta_i / cos^2 theta_d is at most 4, a lobe's energy at most 1. The global term is a density in theta_i, at most 115
    // for the narrowest M, divided by a cosine of at least 0.05.
    let positive = [
        ("single", r.single.as_flattened(), 6.0),
        ("uniform light", r.uniform_light.as_flattened(), 6.0),
        ("global", r.global.as_flattened(), 1e4),
        ("a_f", &r.a_f[..], 1.0),
        ("a_b", &r.a_b[..], 1.0),
        ("beta", r.beta.as_flattened(), 1.51),
        ("A_b", &r.a_bar_b[..], f64::MAX),
    ];
    let tilt = r.alpha.as_flattened().iter().find(|x| !x.is_finite());
    defect_in(&positive).or(tilt.map(|_| Defect::NotFinite("alpha")))
}

/// The first of named values that is not finite, negative, or above the most that it may be.
pub fn defect_in(positive: &[(&'static str, &[f64], f64)]) -> Option<Defect> {
    for (name, values, most) in positive {
        for value in *values {
            match value {
                x if !x.is_finite() => return Some(Defect::NotFinite(name)),
                x if *x < 0.0 => return Some(Defect::Negative(name)),
                x if x > most => return Some(Defect::TooLarge(name)),
                _ => {}
            }
        }
    }
    None
}
