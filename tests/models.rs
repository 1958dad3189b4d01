//! The models of d'Eon 2011 and of Kajiya and Kay: shaders against the float64 reference, energy, poison values.

use std::f64::consts::{FRAC_PI_2, PI};

use balayage_render::gpu::probe::ProbeCase;
use balayage_render::gpu::probe_deon::{self, DeonResult};
use balayage_render::gpu::probe_kajiya_kay::{self, KajiyaKayResult};
use balayage_render::gpu::tables::gauss_legendre;
use balayage_render::gpu::{Gpu, Method, Model, Quality, probe, probe_cases};
use balayage_render::optics::{Direction, Fibre, SrbfLight, deon, dual, kajiya_kay};
use balayage_tests::random;
use rand::Rng;
use rayon::prelude::*;

/// Relative tolerance of the reference: below what is asked of the shaders.
const REFERENCE: f64 = 1e-3;

fn log_between(r: &mut impl Rng, low: f64, high: f64) -> f64 {
    r.random_range(low.ln()..high.ln()).exp()
}

/// Fibres from glossy to rough (beta 0.5 to 60 degrees in azimuth and along), lights of bandwidth 0.01 to 3.
fn wide_case(r: &mut impl Rng) -> ProbeCase {
    let degree = PI / 180.0;
    let width = log_between(r, 0.5 * degree, 60.0 * degree);
    ProbeCase {
        beta: [0.5 * width; 3],
        azimuthal_width: std::f64::consts::SQRT_2 * log_between(r, 0.5 * degree, 60.0 * degree),
        lambda_j: log_between(r, 0.01, 3.0),
        ..probe_cases::hair(r, false)
    }
}

fn fibre(c: &ProbeCase) -> Fibre {
    Fibre {
        eta: c.eta,
        eccentricity: 1.0,
        sigma_a: c.sigma_a,
        alpha: c.alpha,
        beta: c.beta,
        azimuthal_width: c.azimuthal_width,
    }
}

fn view(c: &ProbeCase) -> Direction {
    Direction {
        theta: c.theta_o,
        phi: c.phi_o,
    }
}

fn light(c: &ProbeCase) -> SrbfLight {
    let centre = Direction {
        theta: c.theta_j,
        phi: c.phi_j,
    };
    SrbfLight::new(centre, c.lambda_j).unwrap()
}

/// Integral of the light over the sphere.
fn solid_angle(c: &ProbeCase) -> f64 {
    let l2 = c.lambda_j.powi(2);
    -PI * l2 * (-4.0 / l2).exp_m1()
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

/// Orders 0 to 3 and the remainder of the reference.
fn reference(c: &ProbeCase) -> [[f64; 3]; 5] {
    let orders =
        deon::single_scattering(&fibre(c), view(c), &light(c), deon::DRAWN_ORDERS, REFERENCE).unwrap();
    let remainder = deon::remainder(&fibre(c), view(c), &light(c), deon::DRAWN_ORDERS, REFERENCE).unwrap();
    [orders[0], orders[1], orders[2], orders[3], remainder]
}

fn orders(r: &DeonResult) -> [[f64; 3]; 5] {
    let [p0, p1, p2, p3] = r.orders;
    [p0, p1, p2, p3, r.remainder]
}

#[test]
fn deon_agrees_with_the_reference_order_by_order() {
    let gpu = Gpu::headless().unwrap();
    let mut r = random(41);
    let hair: Vec<_> = (0..48).map(|_| probe_cases::hair(&mut r, false)).collect();
    let wide: Vec<_> = (0..48).map(|_| wide_case(&mut r)).collect();
    let names = ["p = 0", "p = 1", "p = 2", "p = 3", "remainder"];
    let standard = [0.03, 0.01, 0.01, 0.03, 0.04];
    for (cases, limits, sum_limit, quality) in [
        (&hair, standard, 0.01, Quality::Standard),
        (&hair, [0.02, 0.01, 0.01, 0.02, 0.03], 0.006, Quality::High),
        (&wide, [0.06, 0.03, 0.05, 0.06, 0.06], 0.03, Quality::Standard),
    ] {
        let want: Vec<_> = cases.par_iter().map(reference).collect();
        let got = probe_deon::run(&gpu, cases, &Method::of_quality(quality)).unwrap();
        // Per unit of light: small lights count as much as large ones.
        let pairs = |of: &dyn Fn(&[[f64; 3]; 5], usize) -> f64| -> Vec<(f64, f64)> {
            let both = got.iter().zip(&want).zip(cases);
            both.flat_map(|((g, w), c)| {
                let scale = 1.0 / solid_angle(c);
                let g = orders(g);
                (0..3)
                    .map(move |k| (g, k))
                    .map(move |(g, k)| (of(&g, k) * scale, of(w, k) * scale))
            })
            .collect()
        };
        for (p, name) in names.into_iter().enumerate() {
            assert_close(&format!("{quality:?} {name}"), &pairs(&|v, c| v[p][c]), limits[p]);
        }
        let sum = pairs(&|v, c| v.iter().take(4).map(|o| o[c]).sum());
        assert_close(&format!("{quality:?} sum"), &sum, sum_limit);
    }
}

/// A fibre that absorbs nothing, without tilt: a tilt of its own moves each order's cone to other angles of refraction, and what one
/// order loses there no other one gets.
fn white(beta_deg: f64, theta_o_deg: f64) -> ProbeCase {
    ProbeCase {
        eta: 1.55,
        eccentricity: 1.0,
        sigma_a: [0.0; 3],
        alpha: [0.0; 3],
        beta: [beta_deg.to_radians(); 3],
        azimuthal_width: 0.2,
        theta_o: theta_o_deg.to_radians(),
        phi_o: 0.4,
        theta_j: 0.0,
        phi_j: 0.0,
        lambda_j: 1e3,
        sigma_f: 0.5,
    }
}

#[test]
fn a_white_fibre_of_deon_sends_everything_out() {
    let gpu = Gpu::headless().unwrap();
    let angles = [-85.0, -60.0, -20.0, 0.0, 40.0, 70.0, 85.0];
    let widths = [0.5, 3.0, 10.0, 30.0, 60.0];
    let cases: Vec<_> = widths
        .into_iter()
        .flat_map(|beta| angles.map(|theta| white(beta, theta)))
        .collect();
    let method = Method {
        model: Model::Deon,
        ..Method::default()
    };
    let drawn = probe::run(&gpu, &cases, &method).unwrap();
    let by_order = probe_deon::run(&gpu, &cases, &Method::default()).unwrap();
    for ((case, drawn), by_order) in cases.iter().zip(&drawn).zip(&by_order) {
        let uniform = SrbfLight::uniform();
        let sum = |orders: &[[f64; 3]]| orders.iter().map(|o| o[0]).sum::<f64>();

        // All orders one by one and the tail of what is beyond, then what the shader makes of it.
        let exact = deon::furnace_radiance(&fibre(case), case.theta_o, 21, 1e-6).unwrap()[0];
        assert!((exact - 1.0).abs() < 1e-4, "{case:?}: reference {exact}");
        let whole = sum(&drawn.uniform_light);
        assert!((whole - 1.0).abs() < 0.02, "{case:?}: {whole}");

        let few = deon::single_scattering(&fibre(case), view(case), &uniform, 4, 1e-4).unwrap();
        let ratio = sum(&by_order.uniform_light[..4]) / sum(&few);
        println!(
            "beta {:4.1}, theta {:5.1}: whole {whole:.4}, p = 0..3 over reference {ratio:.4}, {:.4} of light",
            case.beta[0].to_degrees(),
            case.theta_o.to_degrees(),
            sum(&few)
        );
        assert!(
            (ratio - 1.0).abs() < 0.01,
            "{case:?}: p = 0..3 are {ratio} of the reference's"
        );
        assert!(sum(&few) < 0.9999, "four orders alone must fall short");
    }
}

#[test]
fn the_shaders_cone_integrates_to_one() {
    let gpu = Gpu::headless().unwrap();
    for beta_deg in [0.5, 2.0, 10.0, 30.0, 60.0] {
        for theta_deg in [-80.0_f64, -30.0, 0.0, 50.0, 88.0] {
            let base = white(beta_deg, theta_deg);
            let width = 2.0 * base.beta[0];
            let (low, high) = (-base.theta_o - 9.0 * width, -base.theta_o + 9.0 * width);
            let nodes = gauss_legendre(200, low.max(-FRAC_PI_2), high.min(FRAC_PI_2));
            let cases: Vec<_> = nodes
                .iter()
                .map(|(theta, _)| ProbeCase {
                    theta_j: *theta,
                    ..base
                })
                .collect();
            let results = probe_deon::run(&gpu, &cases, &Method::of_quality(Quality::Draft)).unwrap();
            let whole: f64 = results
                .iter()
                .zip(&nodes)
                .map(|(r, (theta, weight))| weight * r.cone * f64::from((*theta as f32).cos()))
                .sum();
            println!("beta {beta_deg}, theta {theta_deg}: {:.1e}", whole - 1.0);
            assert!(
                (whole - 1.0).abs() < 1e-5,
                "beta {beta_deg}, theta {theta_deg}: {whole}"
            );
        }
    }
}

#[test]
fn kajiya_kay_is_its_two_terms() {
    let gpu = Gpu::headless().unwrap();
    let mut r = random(42);
    let cases: Vec<_> = (0..200)
        .map(|_| ProbeCase {
            lambda_j: log_between(&mut r, 0.01, 10.0),
            ..probe_cases::hair(&mut r, false)
        })
        .collect();
    let want: Vec<(f64, f64)> = cases
        .par_iter()
        .map(|c| {
            let n = kajiya_kay::exponent(c.beta[0]);
            let diffuse = kajiya_kay::diffuse(&light(c), 1e-5).unwrap();
            let specular = kajiya_kay::specular(n, c.theta_o - 2.0 * c.alpha[0], &light(c), 1e-5).unwrap();
            (diffuse / solid_angle(c), specular / solid_angle(c))
        })
        .collect();
    let got = probe_kajiya_kay::run(&gpu, &cases, &Method::default()).unwrap();
    let pairs = |got_of: fn(&KajiyaKayResult) -> f64, want_of: fn(&(f64, f64)) -> f64| -> Vec<(f64, f64)> {
        let all = got.iter().zip(&want).zip(&cases);
        all.map(|((g, w), c)| (got_of(g) / solid_angle(c), want_of(w)))
            .collect()
    };
    assert_close("diffuse", &pairs(|g| g.diffuse, |w| w.0), 0.001);
    assert_close("specular", &pairs(|g| g.specular, |w| w.1), 0.01);

    // What is drawn is the two terms times their strengths.
    let drawn: Vec<(f64, f64)> = got
        .iter()
        .zip(&cases)
        .flat_map(|(g, c)| {
            let n = kajiya_kay::exponent(c.beta[0]);
            let specular = kajiya_kay::specular_strength(n, c.eta) * g.specular;
            let diffuse = kajiya_kay::diffuse_strength(&c.sigma_a, c.eta);
            let want: [f64; 3] = std::array::from_fn(|k| specular + diffuse[k] * g.diffuse);
            let scale = 1.0 / solid_angle(c);
            let [r, tt, trt] = g.single;
            (0..3).map(move |k| ((r[k] + tt[k] + trt[k]) * scale, want[k] * scale))
        })
        .collect();
    assert_close("drawn", &drawn, 0.001);
    for (g, c) in got.iter().zip(&cases) {
        let [r, tt, trt] = g.uniform_light;
        let whole = r[0] + tt[0] + trt[0];
        assert!(
            whole > 0.0 && whole <= 1.01,
            "{c:?} sends out {whole} of a uniform light"
        );
    }
}

#[test]
fn kajiya_kay_has_the_colour_of_much_hair() {
    let nodes = gauss_legendre(8, -FRAC_PI_2, FRAC_PI_2);
    for sigma_a in [0.01, 0.1, 0.5, 1.4] {
        let fibre = Fibre {
            sigma_a: [sigma_a; 3],
            ..fibre(&white(6.0, 0.0))
        };
        let of = |theta: f64| {
            let a = deon::scattering_averages(&fibre, theta, REFERENCE).unwrap();
            dual::half_space_reflectance(a.a_f[0], a.a_b[0])
        };
        let mean: f64 = nodes.iter().map(|(t, w)| 0.5 * w * t.cos() * of(*t)).sum();
        let colour = kajiya_kay::colour(&fibre.sigma_a)[0];
        println!("sigma_a {sigma_a}: {colour:.3}, half space {mean:.3}");
        assert!(
            (colour - mean).abs() < 0.035,
            "{sigma_a}: {colour} instead of {mean}"
        );
    }
}

/// True where every value is light: finite, not negative, no more than a light of radiance one gives.
fn sound<'a>(values: impl IntoIterator<Item = &'a f64>, most: f64) -> bool {
    values.into_iter().all(|x| (0.0..=most).contains(x))
}

#[test]
fn edges_and_poison_stay_light_in_every_model() {
    let gpu = Gpu::headless().unwrap();
    let mut r = random(43);
    let cases: Vec<_> = (0..60_000).map(|_| probe_cases::stress(&mut r)).collect();
    let deon_method = Method {
        model: Model::Deon,
        ..Method::default()
    };
    for (c, r) in cases.iter().zip(&probe::run(&gpu, &cases, &deon_method).unwrap()) {
        assert_eq!(probe_cases::defect(r), None, "{c:?}: {r:?}");
    }
    for quality in [Quality::Draft, Quality::High] {
        let results = probe_deon::run(&gpu, &cases[..20_000], &Method::of_quality(quality)).unwrap();
        for (c, r) in cases.iter().zip(&results) {
            assert!(sound(orders(r).as_flattened(), 2.0), "{c:?}: {r:?}");
            assert!(sound(r.uniform_light.as_flattened(), 2.0), "{c:?}: {r:?}");
            assert!(r.cone.is_finite() && r.cone >= 0.0, "{c:?}: {r:?}");
        }
    }
    let results = probe_kajiya_kay::run(&gpu, &cases, &Method::default()).unwrap();
    for (c, r) in cases.iter().zip(&results) {
        assert!(sound(r.single.as_flattened(), 2.0), "{c:?}: {r:?}");
        assert!(sound(r.uniform_light.as_flattened(), 2.0), "{c:?}: {r:?}");
    }
    // The check can fail.
    assert!(!sound(&[f64::NAN], 2.0) && !sound(&[-1e-9], 2.0) && !sound(&[2.1], 2.0));
}
