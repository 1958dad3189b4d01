//! The scattering shaders against the float64 reference, on seeded random cases, and under poison values.

use std::f64::consts::PI;

use balayage_render::gpu::probe::{self, ProbeCase, ProbeResult};
use balayage_render::gpu::{Gpu, Method, Quality, probe_cases};
use balayage_render::optics::{self, Direction, Fibre, SrbfLight};
use balayage_tests::random;
use rayon::prelude::*;

/// Relative tolerance of the reference: below what is asked of the shaders.
const REFERENCE: f64 = 1e-3;

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
    let cases: Vec<_> = (0..48).map(|_| probe_cases::hair(&mut r, false)).collect();
    single_against_reference(&cases, Quality::Draft, [0.03, 0.02, 0.06, 0.02]);
    single_against_reference(&cases, Quality::Standard, [0.01, 0.008, 0.02, 0.008]);
    single_against_reference(&cases, Quality::High, [0.005, 0.003, 0.01, 0.004]);
}

#[test]
fn elliptic_single_scattering_agrees_with_the_reference() {
    let mut r = random(12);
    let cases: Vec<_> = (0..8).map(|_| probe_cases::hair(&mut r, true)).collect();
    single_against_reference(&cases, Quality::Standard, [0.01, 0.008, 0.06, 0.01]);
    single_against_reference(&cases, Quality::High, [0.005, 0.003, 0.03, 0.005]);
}

#[test]
fn uniform_light_global_term_and_averages_agree_with_the_reference() {
    let mut r = random(13);
    let cases: Vec<_> = (0..12).map(|_| probe_cases::hair(&mut r, false)).collect();
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

#[test]
fn edges_and_poison_stay_finite_and_non_negative() {
    let mut r = random(14);
    let cases: Vec<_> = (0..210_000).map(|_| probe_cases::stress(&mut r)).collect();
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
            .filter_map(|(c, r)| probe_cases::defect(r).map(|name| (name, c, r)))
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
    assert_eq!(
        probe_cases::defect(&broken),
        Some(probe_cases::Defect::NotFinite("single"))
    );
}
