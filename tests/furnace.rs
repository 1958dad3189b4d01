//! White furnace: a fibre that absorbs nothing, in a uniform environment, sends out what its lobes hold.

use balayage_render::gpu::{Camera, Gpu, Method, Model, RenderSettings, Renderer, ShadeSettings, Terms};
use balayage_render::groom::Groom;
use balayage_render::light::LightSet;
use balayage_render::optics;
use balayage_render::param::VertexParams;
use glam::Vec3;

/// One straight strand along x of 40 points, thick enough to be seen.
fn straight_strand() -> Groom {
    let points: Vec<Vec3> = (0..40)
        .map(|k| Vec3::new(0.05 * k as f32 - 0.975, 0.0, 0.0))
        .collect();
    Groom::from_strands([points], 0.02, 1.0).unwrap().0
}

/// A camera far away that sees the strand at inclination `theta_o`.
fn camera(theta_o: f32) -> Camera {
    let eye = 40.0 * Vec3::new(theta_o.sin(), 0.0, theta_o.cos());
    Camera::look_at(eye, Vec3::ZERO, 3f32.to_radians())
}

#[test]
fn a_white_strand_in_a_white_world_sends_out_the_energy_of_its_lobes() {
    let params = VertexParams {
        sigma_a: [0.0; 3],
        alpha_rad: (-5f32).to_radians(),
        beta_rad: 8f32.to_radians() / std::f32::consts::SQRT_2,
        azimuthal_width: 0.2,
        eta: 1.55,
        eccentricity: 1.0,
        alpha_ratios: [-0.5, -1.5],
        beta_ratios: [0.75, 1.5],
    };
    let beta = f64::from(params.beta_rad);
    let alpha = f64::from(params.alpha_rad);
    let fibre = optics::Fibre {
        eta: 1.55,
        eccentricity: 1.0,
        sigma_a: [0.0; 3],
        alpha: [alpha, -0.5 * alpha, -1.5 * alpha],
        beta: [beta, 0.75 * beta, 1.5 * beta],
        azimuthal_width: 0.2,
    };
    let groom = straight_strand();
    let mut renderer = Renderer::new(&Gpu::headless().unwrap()).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer
        .set_params(&vec![params; groom.point_count()], &[])
        .unwrap();
    renderer.set_lights(&LightSet {
        lights: Vec::new(),
        constant: Vec3::ONE,
    });
    // What a path tracer found for the same fibre, three lobes.
    for (theta_deg, traced) in [
        (0.0, 0.963),
        (20.0, 0.992),
        (40.0, 1.019),
        (60.0, 1.030),
        (75.0, 0.957),
    ] {
        let theta_o = f64::to_radians(theta_deg);
        let expected = optics::furnace_radiance(&fibre, theta_o, 1e-5).unwrap();
        let expected: f64 = expected[0];
        assert!(
            (expected / traced - 1.0).abs() < 0.01,
            "{theta_deg} degrees: reference {expected}, path tracer {traced}"
        );
        for terms in [Terms::SINGLE, Terms::ALL] {
            let settings = RenderSettings {
                shade: ShadeSettings {
                    terms,
                    ..ShadeSettings::default()
                },
                ..RenderSettings::default()
            };
            renderer
                .render(&camera(theta_o as f32), [128, 64], &settings)
                .unwrap();
            let picture = renderer.picture().unwrap();
            let (sum, alpha) = picture
                .pixels
                .iter()
                .fold((0.0, 0.0), |(s, a), p| (s + f64::from(p[1]), a + f64::from(p[3])));
            let got = sum / alpha;
            eprintln!("{theta_deg} degrees, {terms:?}: radiance {got:.4}, reference {expected:.4}");
            assert!(alpha > 2.0, "the strand is not in the picture");
            assert!(
                (got / expected - 1.0).abs() < 0.02,
                "{theta_deg} degrees, {terms:?}: {got} instead of {expected}"
            );
        }
    }
}

#[test]
fn a_white_strand_of_deon_is_as_bright_as_its_world() {
    let params = VertexParams {
        sigma_a: [0.0; 3],
        alpha_rad: 0.0,
        beta_rad: 6f32.to_radians(),
        azimuthal_width: 0.2,
        eta: 1.55,
        eccentricity: 1.0,
        alpha_ratios: [-0.5, -1.5],
        beta_ratios: [0.5, 2.0],
    };
    let groom = straight_strand();
    let mut renderer = Renderer::new(&Gpu::headless().unwrap()).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer
        .set_params(&vec![params; groom.point_count()], &[])
        .unwrap();
    renderer.set_lights(&LightSet {
        lights: Vec::new(),
        constant: Vec3::ONE,
    });
    let settings = RenderSettings {
        shade: ShadeSettings {
            method: Method {
                model: Model::Deon,
                ..Method::default()
            },
            terms: Terms::SINGLE,
            ..ShadeSettings::default()
        },
        ..RenderSettings::default()
    };
    for theta_deg in [0.0_f32, 40.0, 60.0] {
        renderer
            .render(&camera(theta_deg.to_radians()), [128, 64], &settings)
            .unwrap();
        let picture = renderer.picture().unwrap();
        let sum = |c: usize| picture.pixels.iter().map(|p| f64::from(p[c])).sum::<f64>();
        let got = sum(1) / sum(3);
        eprintln!("{theta_deg} degrees: radiance {got:.4} of 1");
        assert!((got - 1.0).abs() < 0.02, "{theta_deg} degrees: {got}");
    }
}
