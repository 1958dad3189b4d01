//! The scattering shaders against the float64 reference, on seeded random cases, and under poison values.

use std::f64::consts::{FRAC_PI_2, PI};

use balayage_render::gpu::probe::{self, ProbeCase, ProbeResult};
use balayage_render::gpu::{Gpu, Method, Quality};
use balayage_render::optics::{self, Direction, Fibre, SrbfLight};
use balayage_tests::random;
use rand::Rng;
use rayon::prelude::*;

/// Relative tolerance of the reference: below what is asked of the shaders.
const REFERENCE: f64 = 1e-3;

fn between(r: &mut impl Rng, low: f64, high: f64) -> f64 {
    r.random_range(low..high)
}

fn log_between(r: &mut impl Rng, low: f64, high: f64) -> f64 {
    r.random_range(low.ln()..high.ln()).exp()
}

/// Hair as people paint it: Marschner's ratios, eta 1.2 to 1.9, lights of bandwidth 0.06 to 1.4, half of them near the mirror cone.
fn hair_case(r: &mut impl Rng, elliptic: bool) -> ProbeCase {
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

fn fibre(c: &ProbeCase) -> Fibre {
    Fibre {
        eta: c.eta,
        eccentricity: c.eccentricity,
        sigma_a: c.sigma_a,
        alpha: c.alpha,
        beta: c.beta,
        azimuthal_width: c.azimuthal_width,
    }
}

fn answers(cases: &[ProbeCase], quality: Quality) -> Vec<ProbeResult> {
    let gpu = Gpu::headless().unwrap();
    probe::run(&gpu, cases, &Method::of_quality(quality)).unwrap()
}

/// Root mean square error over root mean square reference; panics on values that are no numbers.
fn rms(pairs: &[(f64, f64)]) -> f64 {
    assert!(
        pairs
            .iter()
            .all(|(got, want)| got.is_finite() && want.is_finite())
    );
    let error: f64 = pairs.iter().map(|(got, want)| (got - want).powi(2)).sum();
    let size: f64 = pairs.iter().map(|(_, want)| want * want).sum();
    (error / size).sqrt()
}

/// The error of `pairs` is at most `limit`, and the comparison would see an error of ten limits.
fn assert_close(name: &str, pairs: &[(f64, f64)], limit: f64) {
    let error = rms(pairs);
    println!("{name}: {error:.5} (limit {limit})");
    assert!(error <= limit, "{name}: RMS {error} above {limit}");
    let shifted: Vec<_> = pairs
        .iter()
        .map(|(_, want)| (want * (1.0 + 10.0 * limit), *want))
        .collect();
    assert!(rms(&shifted) > limit, "{name}: the comparison can not fail");
}

/// rgb of each lobe of `got`, divided by the light's own integral, beside `want`.
fn lobe_pairs(got: &[[[f64; 3]; 3]], want: &[[[f64; 3]; 3]], scale: &[f64], lobe: usize) -> Vec<(f64, f64)> {
    let cases = got.iter().zip(want).zip(scale);
    cases
        .flat_map(|((g, w), s)| (0..3).map(move |c| (g[lobe][c] * s, w[lobe][c] * s)))
        .collect()
}

fn sum_pairs(got: &[[[f64; 3]; 3]], want: &[[[f64; 3]; 3]], scale: &[f64]) -> Vec<(f64, f64)> {
    let total = |v: &[[f64; 3]; 3], c: usize| v[0][c] + v[1][c] + v[2][c];
    let cases = got.iter().zip(want).zip(scale);
    cases
        .flat_map(|((g, w), s)| (0..3).map(move |c| (total(g, c) * s, total(w, c) * s)))
        .collect()
}

fn single_against_reference(cases: &[ProbeCase], quality: Quality, limits: [f64; 4]) {
    let want: Vec<_> = cases
        .par_iter()
        .map(|c| {
            let centre = Direction {
                theta: c.theta_j,
                phi: c.phi_j,
            };
            let light = SrbfLight::new(centre, c.lambda_j).unwrap();
            let view = Direction {
                theta: c.theta_o,
                phi: c.phi_o,
            };
            optics::single_scattering(&fibre(c), view, &light, REFERENCE)
                .unwrap()
                .to_array()
        })
        .collect();
    let got: Vec<_> = answers(cases, quality).iter().map(|r| r.single).collect();
    // Per unit of light: small lights count as much as large ones.
    let scale: Vec<_> = cases
        .iter()
        .map(|c| 1.0 / (PI * c.lambda_j.powi(2) * (1.0 - (-4.0 / c.lambda_j.powi(2)).exp())))
        .collect();
    for (lobe, name) in ["R", "TT", "TRT"].into_iter().enumerate() {
        assert_close(
            &format!("{quality:?} {name}"),
            &lobe_pairs(&got, &want, &scale, lobe),
            limits[lobe],
        );
    }
    assert_close(
        &format!("{quality:?} sum"),
        &sum_pairs(&got, &want, &scale),
        limits[3],
    );
}

#[test]
fn single_scattering_agrees_with_the_reference() {
    let mut r = random(11);
    let cases: Vec<_> = (0..48).map(|_| hair_case(&mut r, false)).collect();
    single_against_reference(&cases, Quality::Draft, [0.03, 0.02, 0.06, 0.02]);
    single_against_reference(&cases, Quality::Standard, [0.01, 0.008, 0.02, 0.008]);
    single_against_reference(&cases, Quality::High, [0.005, 0.003, 0.01, 0.004]);
}

#[test]
fn elliptic_single_scattering_agrees_with_the_reference() {
    let mut r = random(12);
    let cases: Vec<_> = (0..8).map(|_| hair_case(&mut r, true)).collect();
    single_against_reference(&cases, Quality::Standard, [0.01, 0.008, 0.06, 0.01]);
    single_against_reference(&cases, Quality::High, [0.005, 0.003, 0.03, 0.005]);
}

#[test]
fn uniform_light_global_term_and_averages_agree_with_the_reference() {
    let mut r = random(13);
    let cases: Vec<_> = (0..12).map(|_| hair_case(&mut r, false)).collect();
    let ones = vec![1.0; cases.len()];
    for (quality, global_limit) in [(Quality::Standard, 0.02), (Quality::High, 0.01)] {
        let got = answers(&cases, quality);

        let uniform: Vec<_> = cases
            .par_iter()
            .map(|c| {
                let view = Direction {
                    theta: c.theta_o,
                    phi: c.phi_o,
                };
                optics::single_scattering(&fibre(c), view, &SrbfLight::uniform(), REFERENCE)
                    .unwrap()
                    .to_array()
            })
            .collect();
        let answered: Vec<_> = got.iter().map(|g| g.uniform_light).collect();
        assert_close(
            &format!("{quality:?} uniform light"),
            &sum_pairs(&answered, &uniform, &ones),
            0.005,
        );

        let global: Vec<_> = cases
            .par_iter()
            .map(|c| {
                let view = Direction {
                    theta: c.theta_o,
                    phi: c.phi_o,
                };
                let light = Direction {
                    theta: c.theta_j,
                    phi: c.phi_j,
                };
                optics::global_scattering(&fibre(c), view, light, c.sigma_f, REFERENCE)
                    .unwrap()
                    .to_array()
            })
            .collect();
        let answered: Vec<_> = got.iter().map(|g| g.global).collect();
        for (lobe, name) in ["R", "TT", "TRT"].into_iter().enumerate() {
            let pairs = lobe_pairs(&answered, &global, &ones, lobe);
            assert_close(&format!("{quality:?} global {name}"), &pairs, global_limit);
        }
    }

    let got = answers(&cases, Quality::Standard);
    let averages: Vec<_> = cases
        .par_iter()
        .map(|c| optics::scattering_averages(&fibre(c), c.theta_j, REFERENCE).unwrap())
        .collect();
    let pairs = |of: &dyn Fn(&ProbeResult) -> [f64; 3], reference: &dyn Fn(&optics::Averages) -> [f64; 3]| {
        let both = got.iter().zip(&averages);
        both.flat_map(|(g, a)| of(g).into_iter().zip(reference(a)))
            .collect::<Vec<_>>()
    };
    assert_close("a_f", &pairs(&|g| g.a_f, &|a| a.a_f), 0.005);
    assert_close("a_b", &pairs(&|g| g.a_b, &|a| a.a_b), 0.005);
    assert_close("alpha_f", &pairs(&|g| g.alpha[0], &|a| a.alpha_f), 0.01);
    assert_close("alpha_b", &pairs(&|g| g.alpha[1], &|a| a.alpha_b), 0.01);
    assert_close("beta_f", &pairs(&|g| g.beta[0], &|a| a.beta_f), 0.005);
    assert_close("beta_b", &pairs(&|g| g.beta[1], &|a| a.beta_b), 0.005);
}

/// One value: mostly an edge of the range or poison, else anywhere inside, uniform or log-uniform.
fn stressed(r: &mut impl Rng, low: f64, high: f64, special: &[f64]) -> f64 {
    match r.random_range(0..6) {
        0 => special[r.random_range(0..special.len())],
        1 => low,
        2 => high,
        3 if low > 0.0 => log_between(r, low, high),
        _ => between(r, low, high),
    }
}

const POISON: [f64; 8] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e30,
    -1e30,
    1e-42,
    0.0,
    -1.0,
];

fn stress_case(r: &mut impl Rng) -> ProbeCase {
    let lobes = |r: &mut _, low: f64, high: f64, special: &[f64]| -> [f64; 3] {
        std::array::from_fn(|_| stressed(r, low, high, special))
    };
    let mut angles = POISON.to_vec();
    angles.extend([
        FRAC_PI_2,
        -FRAC_PI_2,
        f64::from(std::f32::consts::FRAC_PI_2),
        FRAC_PI_2 - 1e-4,
        0.0,
    ]);
    let mut absorptions = POISON.to_vec();
    absorptions.extend([0.0, 1e-30, 50.0]);
    let mut indices = POISON.to_vec();
    // At theta_d = 0 the effective index is the index itself: 2 is where TRT's caustic vanishes.
    indices.extend([1.0, 1.0 + 1e-7, 2.0, 3.0]);
    let mut azimuths = POISON.to_vec();
    azimuths.extend([PI, -PI, 2.0 * PI, -2.0 * PI, 1e3 * PI, 0.0]);
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

/// The first quantity of a result that is not finite, negative, or more than a light of radiance one can give.
fn defect(r: &ProbeResult) -> Option<&'static str> {
    let within = |v: &[[f64; 3]; 3], top: f64| v.iter().flatten().all(|x| (0.0..=top).contains(x));
    let shares = |v: &[f64; 3]| v.iter().all(|x| (0.0..=1.0).contains(x));
    let finite = |v: &[[f64; 3]; 2]| v.iter().flatten().all(|x| x.is_finite());
    // cos^2 theta_i / cos^2 theta_d is at most 4, a lobe's energy at most 1. The global term is a density in theta_i, at most 115
    // for the narrowest M, divided by a cosine of at least 0.05.
    let checks = [
        ("single", within(&r.single, 6.0)),
        ("uniform light", within(&r.uniform_light, 6.0)),
        ("global", within(&r.global, 1e4)),
        ("a_f", shares(&r.a_f)),
        ("a_b", shares(&r.a_b)),
        ("alpha", finite(&r.alpha)),
        ("beta", finite(&r.beta)),
    ];
    checks.into_iter().find(|(_, sound)| !sound).map(|(name, _)| name)
}

#[test]
fn edges_and_poison_stay_finite_and_non_negative() {
    let mut r = random(14);
    let cases: Vec<_> = (0..210_000).map(|_| stress_case(&mut r)).collect();
    for quality in [Quality::Draft, Quality::Standard, Quality::High] {
        let part = if quality == Quality::Standard {
            &cases[..]
        } else {
            &cases[..20_000]
        };
        let results = answers(part, quality);
        let bad: Vec<_> = part
            .iter()
            .zip(&results)
            .filter_map(|(c, r)| defect(r).map(|name| (name, c, r)))
            .collect();
        println!("{quality:?}: {} points, {} bad", part.len(), bad.len());
        assert!(
            bad.is_empty(),
            "{} of {}, first: {:?}",
            bad.len(),
            part.len(),
            bad[0]
        );
    }
    // The check can fail.
    let mut broken = answers(&cases[..1], Quality::Draft)[0];
    broken.single[1][2] = f64::NAN;
    assert_eq!(defect(&broken), Some("single"));
}
