//! Laws of the float64 optics: what must hold whatever the parameters are.

use std::f64::consts::{FRAC_PI_2, PI, SQRT_2};

use balayage_render::optics::azimuthal::CrossSection;
use balayage_render::optics::circular::{AzimuthShare, CircularGaussian, Kernel, Unit, sharpness};
use balayage_render::optics::quadrature::integrate;
use balayage_render::optics::{
    Direction, Fibre, Lobe, OpticsError, SrbfLight, deon, dual, furnace_radiance, global_scattering,
    kajiya_kay, scattering_averages, scattering_function, single_scattering,
};
use balayage_tests::random;
use rand::Rng;

/// Brown hair with the shifts and widths of the path-traced pictures.
const BROWN: Fibre = Fibre {
    eta: 1.55,
    eccentricity: 1.0,
    sigma_a: [0.5, 0.8, 1.4],
    alpha: [-0.0872664625997165, 0.0436332312998582, 0.130899693899575],
    beta: [0.0987305, 0.0740479, 0.148096],
    azimuthal_width: 0.2,
};

/// The same without absorption.
const CLEAR: Fibre = Fibre {
    sigma_a: [0.0; 3],
    ..BROWN
};

fn direction(theta: f64, phi: f64) -> Direction {
    Direction { theta, phi }
}

/// True when both agree to a relative tolerance; [`comparator_rejects`] holds it against itself.
fn close(got: f64, wanted: f64, tolerance: f64) -> bool {
    (got - wanted).abs() <= tolerance * wanted.abs()
}

#[test]
fn comparator_rejects() {
    for wanted in [1e-9, 0.3, 40.0] {
        assert!(close(wanted * (1.0 + 0.5e-6), wanted, 1e-6));
        assert!(!close(wanted * (1.0 + 1e-5), wanted, 1e-6));
        assert!(!close(f64::NAN, wanted, 1e-6));
    }
}

#[test]
fn smooth_azimuthal_factor_holds_the_energy_of_its_paths() {
    // N found by its roots (Eq 9) and the integral over the offset know nothing of each other.
    for (eta, theta_d) in [(1.55, 0.0), (1.3, 0.9), (1.9, -1.3)] {
        let section = CrossSection::new(eta, theta_d);
        for p in [0, 1] {
            let energy = section.integrate(p, &BROWN.sigma_a, &Unit, 0.3, 1e-10).value;
            let by_roots =
                integrate(|phi| section.n_smooth(p, &BROWN.sigma_a, phi), 0.0, PI, &[], 1e-9).value;
            for c in 0..3 {
                assert!(
                    close(2.0 * by_roots[c], energy[c], 1e-6),
                    "p {p}: {by_roots:?} {energy:?}"
                );
            }
        }
    }
}

#[test]
fn smoothing_moves_energy_and_keeps_it() {
    let section = CrossSection::new(1.55, 0.4);
    let smoothing = CircularGaussian::normalised(sharpness(0.2));
    let energy = section.integrate(2, &BROWN.sigma_a, &Unit, 0.0, 1e-10).value;
    let smooth = |phi: f64| section.integrate(2, &BROWN.sigma_a, &smoothing, phi, 1e-9).value;
    let whole = integrate(smooth, -PI, PI, &[0.0], 1e-7).value;
    for c in 0..3 {
        assert!(close(whole[c], energy[c], 1e-7), "{whole:?} {energy:?}");
    }
}

#[test]
fn preimages_leave_where_they_should() {
    let mut random = random(11);
    for _ in 0..300 {
        let section = CrossSection::new(random.random_range(1.05..2.2), random.random_range(-1.5..1.5));
        let (p, phi) = (random.random_range(0..5), random.random_range(-PI..PI));
        // A narrow kernel at phi sees exactly the density that the roots give, away from caustics.
        let n = section.n_smooth(p, &[0.1; 3], phi)[0];
        let bump = CircularGaussian::normalised(sharpness(1e-3));
        let seen = section.integrate(p, &[0.1; 3], &bump, phi, 1e-8).value[0];
        let other = section.n_smooth(p, &[0.1; 3], phi + 3e-3)[0];
        if n > 1e-6 && close(other, n, 0.02) {
            assert!(close(seen, n, 1e-2), "p {p} phi {phi}: {seen} {n}");
        }
    }
}

#[test]
fn scattering_is_reciprocal() {
    let fibre = Fibre {
        eccentricity: 1.15,
        ..BROWN
    };
    let mut random = random(5);
    for _ in 0..20 {
        let mut any = || direction(random.random_range(-1.4..1.4), random.random_range(-PI..PI));
        let (a, b) = (any(), any());
        let there = scattering_function(&fibre, a, b, 1e-8).unwrap().to_array();
        let back = scattering_function(&fibre, b, a, 1e-8).unwrap().to_array();
        for (s, t) in there.iter().flatten().zip(back.iter().flatten()) {
            assert!((s - t).abs() <= 1e-6 * s.abs() + 1e-30, "{s} {t}");
        }
    }

    // Turning the ellipse is not a symmetry.
    let s = |turn: f64| {
        let (light, view) = (direction(0.2, turn), direction(-0.1, 0.9 + turn));
        scattering_function(&fibre, light, view, 1e-8).unwrap().trt[0]
    };
    assert!(!close(s(0.0), s(1.0), 1e-2));
}

#[test]
fn narrow_lights_see_the_scattering_function() {
    for fibre in [
        BROWN,
        Fibre {
            eccentricity: 0.85,
            ..BROWN
        },
    ] {
        let (view, centre) = (direction(0.35, 0.2), direction(-0.25, 2.6));
        for (view, centre) in [(view, centre), (view, direction(-0.2, 0.5))] {
            let lambda: f64 = 0.004;
            let light = SrbfLight::new(centre, lambda).unwrap();
            let lit = single_scattering(&fibre, view, &light, 1e-5).unwrap().to_array();
            let s = scattering_function(&fibre, centre, view, 1e-8)
                .unwrap()
                .to_array();
            for (lit, s) in lit.iter().flatten().zip(s.iter().flatten()) {
                let wanted = s * centre.theta.cos() * PI * lambda * lambda;
                assert!(
                    (lit - wanted).abs() <= 2e-3 * wanted.abs() + 1e-12,
                    "{lit} {wanted}"
                );
            }
        }
    }
}

#[test]
fn wide_lights_become_the_uniform_environment() {
    let view = direction(0.5, 0.0);
    let wide = SrbfLight::new(direction(0.3, 1.0), 3e3).unwrap();
    let lit = single_scattering(&BROWN, view, &wide, 1e-7).unwrap().sum();
    let uniform = furnace_radiance(&BROWN, view.theta, 1e-7).unwrap();
    for c in 0..3 {
        assert!(close(lit[c], uniform[c], 1e-6), "{lit:?} {uniform:?}");
    }
}

#[test]
fn circular_and_almost_circular_fibres_agree() {
    // The circular fibre takes the closed convolution, the elliptic one three nested integrals.
    let (view, light) = (
        direction(0.4, 0.3),
        SrbfLight::new(direction(-0.6, 1.1), 0.3).unwrap(),
    );
    let circular = single_scattering(&BROWN, view, &light, 1e-6).unwrap();
    let almost = Fibre {
        eccentricity: 1.0 + 1e-9,
        ..BROWN
    };
    let elliptic = single_scattering(&almost, view, &light, 1e-6).unwrap();
    for c in 0..3 {
        assert!(
            close(elliptic.trt[c], circular.trt[c], 1e-6),
            "{elliptic:?} {circular:?}"
        );
    }
    let oval = Fibre {
        eccentricity: 1.1,
        ..BROWN
    };
    assert!(!close(
        single_scattering(&oval, view, &light, 1e-6).unwrap().trt[0],
        circular.trt[0],
        1e-3
    ));
}

#[test]
fn one_fibre_in_a_furnace_is_what_a_path_tracer_sees() {
    // Mean over the ribbon of R + TT + TRT by an independent path tracer, three digits.
    for (degrees, wanted) in [
        (0.0_f64, 0.963),
        (20.0, 0.992),
        (40.0, 1.019),
        (60.0, 1.030),
        (75.0, 0.957),
    ] {
        let got = furnace_radiance(&CLEAR, degrees.to_radians(), 1e-7).unwrap();
        assert!(
            (got[0] - wanted).abs() < 0.002,
            "{degrees} degrees: {got:?} {wanted}"
        );
    }
    for (degrees, wanted) in [(0.0_f64, [0.411, 0.265, 0.135]), (40.0, [0.404, 0.255, 0.135])] {
        let got = furnace_radiance(&BROWN, degrees.to_radians(), 1e-7).unwrap();
        for c in 0..3 {
            assert!(
                (got[c] - wanted[c]).abs() < 0.002,
                "{degrees} degrees: {got:?} {wanted:?}"
            );
        }
    }
}

#[test]
fn forward_and_backward_share_all_that_is_scattered() {
    let averages = scattering_averages(&BROWN, 0.6, 1e-7).unwrap();
    let section = |theta_o: f64| CrossSection::new(BROWN.eta, 0.5 * (theta_o - 0.6));
    let mut energy = [0.0; 3];
    for lobe in Lobe::ALL {
        let (alpha, beta) = (BROWN.alpha[lobe as usize], BROWN.beta[lobe as usize]);
        let of = |theta_o: f64| {
            let m = balayage_render::optics::longitudinal::m(alpha, beta, theta_o, 0.6);
            let cos_theta_d = (0.5 * (theta_o - 0.6)).cos();
            let n = section(theta_o)
                .integrate(lobe.p(), &BROWN.sigma_a, &Unit, 0.0, 1e-9)
                .value;
            n.map(|n| n * m * theta_o.cos() * 0.6_f64.cos() / cos_theta_d.powi(2))
        };
        let total = integrate(of, -FRAC_PI_2, FRAC_PI_2, &[2.0 * alpha - 0.6], 1e-8).value;
        (0..3).for_each(|c| energy[c] += total[c]);
    }
    for c in 0..3 {
        assert!(
            close(averages.a_f[c] + averages.a_b[c], energy[c], 1e-6),
            "{averages:?} {energy:?}"
        );
        assert!(averages.beta_f[c] > BROWN.beta[1] && averages.beta_f[c] < BROWN.beta[2]);
    }
    assert!(close(
        AzimuthShare::Forward.value(1.0) + AzimuthShare::Backward.value(1.0),
        1.0,
        1e-15
    ));
}

#[test]
fn layers_of_fibres_conserve_light() {
    // A row that loses nothing sends everything back; one that loses something satisfies its own equation.
    assert!(close(dual::adding_a_b(0.7, 0.3) + 0.3, 1.0, 1e-7));
    assert!(dual::extinction(0.7, 0.3) < 1e-7);
    assert!(close(dual::half_space_reflectance(0.7, 0.3), 1.0, 1e-7));
    let (a_f, a_b) = (0.5, 0.2);
    let r = dual::adding_a_b(a_f, a_b) + a_b;
    assert!(close(r, a_b + a_f * a_f * r / (1.0 - a_b * r), 1e-12));
    assert!(
        !close(r, a_b + a_f * a_f * r, 1e-3),
        "without the echoes the equation must fail"
    );

    // Where few events matter Zinke's series is the same.
    assert!(close(
        dual::zinke_a_b(0.1, 0.01),
        dual::adding_a_b(0.1, 0.01),
        2e-2
    ));

    // Fibres that send out more than they get are no reason for NaN.
    for value in [
        dual::adding_a_b(0.9, 0.3),
        dual::extinction(0.9, 0.3),
        dual::half_space_reflectance(1.2, 0.0),
    ] {
        assert!(value.is_finite() && value >= 0.0, "{value}");
    }
}

#[test]
fn mean_reflectance_lies_between_its_extremes() {
    let rho = dual::mean_reflectance(&BROWN, 1e-3).unwrap();
    let at = |theta: f64| scattering_averages(&BROWN, theta, 1e-4).unwrap();
    for (c, rho) in rho.into_iter().enumerate() {
        let of = |theta: f64| dual::half_space_reflectance(at(theta).a_f[c], at(theta).a_b[c]);
        let samples = [-1.3, -0.9, -0.4, 0.0, 0.4, 0.9, 1.3].map(of);
        let (low, high) = samples
            .iter()
            .fold((f64::MAX, 0.0_f64), |(l, h), s| (l.min(*s), h.max(*s)));
        assert!(rho > low && rho < high, "{rho} {samples:?}");
    }
}

#[test]
fn global_term_is_the_single_term_averaged_over_a_half_circle() {
    // A vanishing spread in theta leaves S summed over the azimuths of the half circle.
    let (view, light) = (direction(0.3, 0.5), direction(-0.4, 1.2));
    let sigma_f = 1e-3;
    let got = global_scattering(&BROWN, view, light, sigma_f, 1e-6)
        .unwrap()
        .to_array();
    let s = |phi_i: f64| {
        let s = scattering_function(&BROWN, direction(light.theta, phi_i), view, 1e-8).unwrap();
        let [r, tt, trt] = s.to_array();
        [r[0], tt[1], trt[2]].map(|s| s * light.theta.cos() / PI)
    };
    let (from, to) = (light.phi - FRAC_PI_2, light.phi + FRAC_PI_2);
    let wanted = integrate(s, from, to, &[view.phi], 1e-7).value;
    // The cosine of cos(theta) dtheta and the one that Eq 27 divides by cancel.
    for (got, wanted) in [got[0][0], got[1][1], got[2][2]].into_iter().zip(wanted) {
        assert!(
            (got - wanted).abs() <= 1e-4 * wanted.abs() + 1e-12,
            "{got} {wanted}"
        );
    }
}

#[test]
fn deon_conserves_energy() {
    // Integral of M_p over the sphere, then of all of S.
    for degrees in [0.5_f64, 3.0, 10.0, 30.0, 60.0] {
        let v = (2.0 * degrees.to_radians()).powi(2);
        for theta_o in [-1.5, -0.7, 0.0, 1.2, FRAC_PI_2] {
            let m = |theta: f64| [deon::m_p(v, theta, theta_o) * theta.cos()];
            let width = v.sqrt();
            let breaks = [-6.0, -1.0, 0.0, 1.0, 6.0].map(|k| -theta_o + k * width);
            let whole = integrate(m, -FRAC_PI_2, FRAC_PI_2, &breaks, 1e-9).value[0];
            assert!(
                close(whole, 1.0, 1e-7),
                "beta {degrees}, theta {theta_o}: {whole}"
            );
        }
    }
    let fibre = Fibre {
        alpha: [-0.05; 3],
        beta: [0.1; 3],
        ..CLEAR
    };
    for degrees in [-85.0_f64, -60.0, 0.0, 45.0, 85.0] {
        let whole = deon::furnace_radiance(&fibre, degrees.to_radians(), 21, 1e-6).unwrap();
        assert!((whole[0] - 1.0).abs() < 1e-4, "{degrees} degrees: {whole:?}");
        let uniform = SrbfLight::uniform();
        let few = deon::single_scattering(&fibre, direction(degrees.to_radians(), 0.0), &uniform, 4, 1e-6);
        let few: f64 = few.unwrap().iter().map(|s| s[0]).sum();
        assert!(few < 0.9999, "four orders alone must fall short: {few}");
    }
}

#[test]
fn deon_cone_is_the_spherical_gaussian_it_averages() {
    for (v, theta_i, theta_r) in [
        (0.01, 0.4, -0.3),
        (0.3, 1.3, -1.0),
        (2.0, -0.2, 0.9),
        (0.05, 1.5, -1.8),
    ] {
        let cone = |phi: f64| [2.0 * deon::spherical_gaussian(v, theta_i, theta_r, phi)];
        let width = v.sqrt();
        let wanted = integrate(cone, 0.0, PI, &[width, 3.0 * width], 1e-10).value[0];
        assert!(
            close(deon::m_p(v, theta_i, theta_r), wanted, 1e-9),
            "{v} {theta_i} {theta_r}: {wanted}"
        );
    }
}

#[test]
fn kajiya_kay_diffuse_has_its_limits() {
    // A uniform light gives the integral of the cosine, pi^2; a narrow one the cosine times the light's solid angle.
    assert!(close(
        kajiya_kay::diffuse(&SrbfLight::uniform(), 1e-9).unwrap(),
        PI * PI,
        1e-8
    ));
    let lambda: f64 = 1e-3;
    let narrow = SrbfLight::new(direction(0.7, 0.0), lambda).unwrap();
    let wanted = 0.7_f64.cos() * PI * lambda * lambda;
    assert!(close(kajiya_kay::diffuse(&narrow, 1e-9).unwrap(), wanted, 1e-5));
}

#[test]
fn edges_of_the_parameters_are_finite() {
    let view = direction(FRAC_PI_2, -PI);
    let fibres = [
        Fibre { eta: 1.0, ..BROWN },
        Fibre { eta: 1.0, ..CLEAR },
        Fibre {
            eta: 1.0 + 1e-7,
            ..BROWN
        },
        Fibre { eta: 2.0, ..BROWN },
        Fibre { eta: 0.8, ..BROWN },
        Fibre {
            sigma_a: [0.0, 50.0, 1e30],
            ..BROWN
        },
        Fibre {
            beta: [0.002; 3],
            azimuthal_width: 0.01,
            ..BROWN
        },
        Fibre {
            beta: [1.0; 3],
            azimuthal_width: 3.0,
            ..BROWN
        },
    ];
    for fibre in fibres {
        for (view, lambda) in [
            (view, 0.3),
            (direction(-0.3, 1.0), 1e-3),
            (direction(1.56, 0.0), 10.0),
        ] {
            let light = SrbfLight::new(direction(0.2, 0.0), lambda).unwrap();
            let lit = single_scattering(&fibre, view, &light, 1e-4).unwrap();
            assert!(
                lit.to_array()
                    .iter()
                    .flatten()
                    .all(|s| s.is_finite() && *s >= 0.0),
                "{fibre:?} {lit:?}"
            );
        }
    }
}

#[test]
fn bad_values_are_refused_by_name() {
    let good = direction(0.1, 0.2);
    let light = SrbfLight::new(good, 0.3).unwrap();
    let refused = |fibre: Fibre| match single_scattering(&fibre, good, &light, 1e-4) {
        Err(OpticsError::Refused { field, .. }) => field,
        other => panic!("{fibre:?} was answered: {other:?}"),
    };
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(refused(Fibre { eta: bad, ..BROWN }), "eta");
        assert_eq!(
            refused(Fibre {
                eccentricity: bad,
                ..BROWN
            }),
            "eccentricity"
        );
        assert_eq!(
            refused(Fibre {
                sigma_a: [0.1, bad, 0.1],
                ..BROWN
            }),
            "sigma_a[1]"
        );
        assert_eq!(
            refused(Fibre {
                beta: [0.1, 0.1, bad],
                ..BROWN
            }),
            "beta TRT"
        );
        assert_eq!(
            refused(Fibre {
                azimuthal_width: bad,
                ..BROWN
            }),
            "azimuthal_width"
        );
        assert!(SrbfLight::new(good, bad).is_err());
        assert!(global_scattering(&BROWN, good, good, bad, 1e-4).is_err());
    }
    assert_eq!(refused(Fibre { eta: 0.0, ..BROWN }), "eta");
    assert_eq!(
        refused(Fibre {
            alpha: [f64::NAN; 3],
            ..BROWN
        }),
        "alpha R"
    );
    assert_eq!(
        refused(Fibre {
            eta: 3.0,
            eccentricity: 0.2,
            ..BROWN
        }),
        "eccentricity"
    );
    assert!(SrbfLight::new(direction(1.6, 0.0), 0.3).is_err());
    assert!(single_scattering(&BROWN, direction(0.0, f64::NAN), &light, 1e-4).is_err());
    assert!(single_scattering(&BROWN, good, &light, f64::NAN).is_err());
    assert!(deon::n_p(&BROWN, 65, 0.0, 0.0, 1e-4).is_err());
    assert!(global_scattering(&BROWN, good, direction(FRAC_PI_2, 0.0), 0.3, 1e-4).is_err());
    assert!(BROWN.check().is_ok() && close(BROWN.beta[0] * SQRT_2, 0.139626, 1e-4));
}
