//! White furnace: a fibre that absorbs nothing, in a uniform environment, sends out what its lobes hold.

use balayage_render::gpu::{
    Camera, Gpu, Method, Model, Multiple, RenderSettings, Renderer, ShadeSettings, Terms,
};
use balayage_render::groom::{BALL_RADIUS, Groom, ball};
use balayage_render::light::LightSet;
use balayage_render::optics;
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
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
        let got = renderer.picture().unwrap().mean()[1];
        eprintln!("{theta_deg} degrees: radiance {got:.4} of 1");
        assert!((got - 1.0).abs() < 0.02, "{theta_deg} degrees: {got}");
    }
}

/// Mean radiance of points in four shells of a ball, the outermost first, over some views.
fn shells_of_ball(
    renderer: &mut Renderer,
    groom: &Groom,
    (model, multiple): (Model, Multiple),
    sigma_a: f32,
) -> [f32; 4] {
    let params = VertexParams {
        sigma_a: [sigma_a; 3],
        ..PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default())
    };
    renderer
        .set_params(&vec![params; groom.point_count()], &[])
        .unwrap();
    let shells: [Vec<u32>; 4] = std::array::from_fn(|shell| {
        let of_shell = |point: &u32| {
            let depth = 1.0 - groom.positions()[*point as usize].length() / BALL_RADIUS;
            (4.0 * depth) as usize == shell
        };
        let points = (0..groom.point_count() as u32).filter(of_shell);
        points.step_by(1 + groom.point_count() / 8000).take(60).collect()
    });
    let all = shells.concat();
    // Photons in a white ball meet some hundred fibres each: of the first frame's few reach the middle.
    let mut settings = RenderSettings {
        visibility_rays: 16,
        ..RenderSettings::default()
    };
    settings.shade.method.model = model;
    settings.shade.multiple = multiple;
    let mut sums = vec![0.0; all.len()];
    let eyes = [
        Vec3::X,
        Vec3::NEG_Y,
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(0.0, 1.0, -1.0),
    ];
    for eye in eyes {
        let radiance = renderer.radiance_of_points(&all, 100.0 * eye, &settings).unwrap();
        for (sum, radiance) in sums.iter_mut().zip(radiance) {
            *sum += radiance.y / eyes.len() as f32;
        }
    }
    let mut sums = sums.into_iter();
    shells.map(|shell| sums.by_ref().take(shell.len()).sum::<f32>() / shell.len() as f32)
}

#[test]
fn a_dense_white_ball_that_loses_nothing_is_as_bright_as_its_world_to_its_middle() {
    // Some hundred fibres from its surface to its middle.
    let groom = ball(6000, 0.05, 1).unwrap();
    let mut renderer = Renderer::new(&Gpu::headless().unwrap()).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer.set_lights(&LightSet {
        lights: Vec::new(),
        constant: Vec3::ONE,
    });
    let mut ball =
        |multiple, sigma_a| shells_of_ball(&mut renderer, &groom, (Model::Deon, multiple), sigma_a);
    // Of some thousand photons a few tens reach the last shell, a sixty-fourth of the ball.
    for (multiple, bounds, innermost) in [
        (Multiple::M3, 0.95..1.08, 0.95..1.08),
        (Multiple::Traced, 0.93..1.07, 0.85..1.15),
    ] {
        let white = ball(multiple, 0.0);
        eprintln!("radiance by depth, {multiple:?}: {white:.3?}");
        assert!(white[..3].iter().all(|shell| bounds.contains(shell)), "{white:?}");
        assert!(innermost.contains(&white[3]), "{white:?}");
    }
    let grey = ball(Multiple::default(), 0.1);
    // The least absorption leaves a middle that no light reaches.
    assert!(grey[3] < 0.05, "{grey:?}");
}

#[test]
fn a_white_ball_stays_bright_to_its_middle_and_absorption_darkens_it() {
    let groom = ball(3000, 0.03, 1).unwrap();
    let mut renderer = Renderer::new(&Gpu::headless().unwrap()).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    renderer.set_lights(&LightSet {
        lights: Vec::new(),
        constant: Vec3::ONE,
    });
    let found = [0.0, 0.01, 0.1, 1.0].map(|sigma_a| {
        shells_of_ball(
            &mut renderer,
            &groom,
            (Model::Marschner, Multiple::default()),
            sigma_a,
        )
    });
    eprintln!("radiance by depth, absorption 0, .01, .1, 1: {found:.3?}");
    for (depth, white) in found[0].iter().enumerate() {
        assert!((0.50..1.05).contains(white), "shell {depth}: {found:?}");
    }
    for darker in found.windows(2) {
        for (less, more) in darker[0].iter().zip(&darker[1]) {
            assert!(more < less, "{found:?}");
        }
    }
    assert!(
        found[3][3] < 0.3 * found[0][3],
        "light does not reach the middle of dark hair"
    );
}

#[test]
fn a_uniform_environment_is_the_same_however_few_records_a_buffer_holds() {
    let groom = ball(900, 0.03, 1).unwrap();
    let points: Vec<u32> = (0..groom.point_count() as u32).step_by(97).collect();
    // Records of 32 lights at that many points want more than 4 MiB: a device that binds no more holds them in batches.
    let small = 4 << 20;
    assert!(groom.point_count() * 32 * 16 > small + small / 4);
    let radiance = |gpu: &Gpu| {
        let mut renderer = Renderer::new(gpu).unwrap();
        renderer.set_groom(&groom, None).unwrap();
        let params = PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
        renderer
            .set_params(&vec![params; groom.point_count()], &[])
            .unwrap();
        let lights = LightSet {
            lights: Vec::new(),
            constant: Vec3::ONE,
        };
        renderer.set_lights(&lights);
        renderer
            .radiance_of_points(&points, 100.0 * Vec3::Z, &RenderSettings::default())
            .unwrap()
    };
    let whole = radiance(&Gpu::headless().unwrap());
    let batched = radiance(&bound_to(small as u64));
    let brightest = whole.iter().map(|r| r.max_element()).fold(0.0, f32::max);
    for (a, b) in whole.iter().zip(&batched) {
        assert!(
            (a - b).abs().max_element() < 2e-3 * brightest,
            "{a} in one batch, {b} in several"
        );
    }
    assert!(brightest > 0.1, "the ball is not dark");
}

/// A device that binds buffers of at most so many bytes.
fn bound_to(bytes: u64) -> Gpu {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default())).unwrap();
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_limits: wgpu::Limits {
            max_storage_buffer_binding_size: bytes,
            ..adapter.limits()
        },
        ..Default::default()
    }))
    .unwrap();
    Gpu::from_parts(device, queue, &adapter.get_info())
}
