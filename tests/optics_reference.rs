//! The float64 optics against numbers of others: a path tracer's scattering values and seeded oracle cases.

use std::fs;

use balayage_render::optics::azimuthal::CrossSection;
use balayage_render::optics::circular::GaussianDetector;
use balayage_render::optics::dual::Backward;
use balayage_render::optics::{Direction, Fibre, deon, local_scattering, longitudinal, scattering_averages};
use balayage_tests::test_data;
use rayon::prelude::*;
use serde_json::Value;

/// Three numbers, or one for all channels.
fn channels(value: &Value) -> [f64; 3] {
    let list = value.as_array().map_or_else(
        || vec![value.as_f64().unwrap()],
        |list| list.iter().map(|v| v.as_f64().unwrap()).collect(),
    );
    std::array::from_fn(|c| list[c.min(list.len() - 1)])
}

/// True when every channel agrees, relatively or within `floor`.
fn agree(got: [f64; 3], wanted: [f64; 3], tolerance: f64, floor: f64) -> bool {
    got.iter()
        .zip(wanted)
        .all(|(g, w)| (g - w).abs() <= tolerance * w.abs() + floor)
}

#[test]
fn comparator_rejects() {
    let wanted = [0.3, 0.2, 1e-5];
    assert!(agree(wanted, wanted, 1e-5, 1e-12));
    assert!(!agree(wanted.map(|w| w * (1.0 + 1e-4)), wanted, 1e-5, 1e-12));
    assert!(!agree([f64::NAN; 3], wanted, 1e-5, 1e-12));
}

#[test]
fn path_tracers_values_of_m_n_and_s() {
    let Some(path) = test_data("../reference/bcsdf_values.json") else {
        return;
    };
    let file: Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    let alpha = [-5.0_f64, 2.5, 7.5].map(f64::to_radians);
    let beta = [8.0_f64, 6.0, 12.0].map(|bandwidth| bandwidth.to_radians() / std::f64::consts::SQRT_2);
    let rows = file["rows"].as_array().unwrap();
    assert!(rows.len() >= 200);
    for row in rows {
        let number = |key: &str| row[key].as_f64().unwrap();
        let radians = |key: &str| number(key).to_radians();
        let (theta_i, theta_o, phi) = (radians("theta_i"), radians("theta_o"), radians("phi"));
        let sigma_a = match row["look"].as_str().unwrap() {
            "blond" => [0.06, 0.10, 0.20],
            "brown" => [0.5, 0.8, 1.4],
            _ => [2.5, 3.0, 4.5],
        };
        let theta_d = 0.5 * (theta_o - theta_i);
        let section = CrossSection::new(1.55, theta_d);
        for (p, lobe) in ["R", "TT", "TRT"].into_iter().enumerate() {
            let m = longitudinal::m(alpha[p], beta[p], theta_i, theta_o);
            assert!(
                agree([m; 3], channels(&row[format!("M_{lobe}")]), 2e-5, 0.0),
                "M_{lobe} {row}"
            );
            // The path tracer blurs TRT by a wrapped Gaussian of bandwidth 0.2, by a transform that leaves 1e-16.
            let n = if p == 2 {
                let detector = GaussianDetector::new(0.2 / std::f64::consts::SQRT_2);
                section.integrate(2, &sigma_a, &detector, phi, 1e-8).value
            } else {
                section.n_smooth(p as u32, &sigma_a, phi)
            };
            let wanted = channels(&row[format!("N_{lobe}")]);
            assert!(agree(n, wanted, 2e-4, 2e-6), "N_{lobe} {n:?} {row}");
            let s = n.map(|n| m * n / theta_d.cos().powi(2));
            let floor = 2e-6 * m / theta_d.cos().powi(2);
            assert!(
                agree(s, channels(&row[format!("S_{lobe}")]), 3e-4, floor),
                "S_{lobe} {s:?} {row}"
            );
        }
    }
}

/// The oracle's cases: inputs (Xu's bandwidths) and results.
fn cases() -> Option<Vec<Value>> {
    let path = test_data("../reference/cases_public.jsonl")?;
    let text = fs::read_to_string(path).unwrap();
    Some(
        text.lines()
            .skip(1)
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
    )
}

/// The fibre of a case.
fn fibre(inputs: &Value) -> Fibre {
    let number = |key: &str| inputs[key].as_f64().unwrap();
    Fibre {
        eta: number("eta"),
        eccentricity: number("a"),
        sigma_a: channels(&inputs["sigma_a"]),
        alpha: channels(&inputs["alpha"]),
        beta: channels(&inputs["beta"]).map(|bandwidth| bandwidth / std::f64::consts::SQRT_2),
        azimuthal_width: number("w_c"),
    }
}

#[test]
fn averages_of_the_oracle() {
    let Some(cases) = cases() else { return };
    cases.par_iter().for_each(|case| {
        let theta = case["inputs"]["theta_j"].as_f64().unwrap();
        let averages = scattering_averages(&fibre(&case["inputs"]), theta, 1e-6).unwrap();
        let backward = Backward::of(&averages);
        let bandwidth = |std: [f64; 3]| std.map(|s| s * std::f64::consts::SQRT_2);
        // The oracle keeps Delta_b and sigma_b in theta_h, sigma_b as a bandwidth.
        for (name, got) in [
            ("alpha_f", averages.alpha_f),
            ("alpha_b", averages.alpha_b),
            ("beta_f", bandwidth(averages.beta_f)),
            ("beta_b", bandwidth(averages.beta_b)),
            ("Delta_b", backward.delta_b.map(|d| 0.5 * d)),
            ("sigma_b", bandwidth(backward.sigma_b).map(|s| 0.5 * s)),
            ("A_b", backward.a_b_zinke),
        ] {
            let wanted = channels(&case["ref"][name]["v"]);
            assert!(
                agree(got, wanted, 1e-4, 1e-7),
                "{name} of case {}: {got:?} {wanted:?}",
                case["id"]
            );
        }
    });
}

#[test]
fn deon_of_the_oracle() {
    let Some(cases) = cases() else { return };
    cases.par_iter().for_each(|case| {
        let inputs = &case["inputs"];
        let number = |key: &str| inputs[key].as_f64().unwrap();
        let v = number("deon_v");
        let fibre = Fibre {
            alpha: [0.0; 3],
            beta: [0.5 * v.sqrt(); 3],
            azimuthal_width: std::f64::consts::SQRT_2 * number("deon_beta_n"),
            ..fibre(inputs)
        };
        let light = Direction {
            theta: number("theta_j"),
            phi: number("phi_j"),
        };
        let view = Direction {
            theta: number("theta_o"),
            phi: number("phi_o"),
        };
        let m = [deon::m_p(v, light.theta, view.theta); 3];
        assert!(
            agree(m, channels(&case["ref"]["deon_M"]["v"]), 1e-9, 0.0),
            "M of case {}",
            case["id"]
        );
        for (p, wanted) in case["ref"]["deon_S_p"]["v"]
            .as_array()
            .unwrap()
            .iter()
            .enumerate()
        {
            let got = deon::scattering_function(&fibre, p as u32, light, view, 1e-8).unwrap();
            let wanted = channels(wanted);
            assert!(
                agree(got, wanted, 1e-6, 1e-12),
                "p {p} of case {}: {got:?} {wanted:?}",
                case["id"]
            );
        }
    });
}

#[test]
fn local_scattering_is_positive_and_fades_behind() {
    let brown = Fibre {
        eta: 1.55,
        eccentricity: 1.0,
        sigma_a: [0.5, 0.8, 1.4],
        alpha: [-0.087, 0.044, 0.131],
        beta: [0.099, 0.074, 0.148],
        azimuthal_width: 0.2,
    };
    let view = Direction { theta: 0.2, phi: 0.0 };
    let at = |phi: f64| local_scattering(&brown, view, Direction { theta: -0.1, phi }, 0.3, 1e-3).unwrap();
    let (front, side, behind) = (at(0.0), at(std::f64::consts::FRAC_PI_2), at(std::f64::consts::PI));
    for c in 0..3 {
        // Eq 30: half at the side, nothing opposite.
        assert!(front[c] > 0.0 && (side[c] / front[c] - 0.5).abs() < 1e-9 && behind[c] < 1e-7 * front[c]);
    }
    assert!(front[0] > front[2], "darker channels send less back");
}
