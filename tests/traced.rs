//! The renderer against the path tracer of the crate, which meets exact fibres and shares nothing with the shaders, in both models of a fibre.

use std::ops::ControlFlow;

use balayage_render::gpu::{Camera, Gpu, Method, Model, RenderSettings, Renderer, ShadeSettings};
use balayage_render::groom::{BALL_RADIUS, ball};
use balayage_render::light::{EnvironmentMap, LightSet, SrbfLight};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
use balayage_render::trace::{Scene, TraceSettings};
use glam::Vec3;

const SIZE: [u32; 2] = [64, 64];

#[test]
fn a_ball_is_as_bright_as_paths_say_in_both_models() {
    let groom = ball(6000, 0.0125, 1).unwrap();
    let camera = Camera::look_at(Vec3::new(0.0, 0.0, 10.0), Vec3::ZERO, 2.4 * BALL_RADIUS / 10.0);
    let mut renderer = Renderer::new(&Gpu::headless().unwrap()).unwrap();
    renderer.set_groom(&groom, None).unwrap();
    let even = LightSet {
        lights: Vec::new(),
        constant: Vec3::ONE,
    };
    let side = LightSet {
        lights: vec![SrbfLight {
            direction: Vec3::new(0.8, 0.6, 0.0),
            bandwidth: 0.5,
            radiance: Vec3::ONE,
        }],
        constant: Vec3::ZERO,
    };
    for (model, sigma_a, lights, most_off) in [
        (Model::Deon, 0.0, &even, 0.03),
        (Model::Marschner, 0.0, &even, 0.03),
        // Fibres of a quarter of a pixel, lit from one side.
        (Model::Deon, 0.1, &side, 0.08),
    ] {
        let params = VertexParams {
            sigma_a: [sigma_a; 3],
            ..PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default())
        };
        let params = vec![params; groom.point_count()];
        renderer.set_params(&params, &[]).unwrap();
        renderer.set_lights(lights);
        let settings = RenderSettings {
            shade: ShadeSettings {
                method: Method {
                    model,
                    ..Method::default()
                },
                ..ShadeSettings::default()
            },
            visibility_rays: 16,
            ..RenderSettings::default()
        };
        renderer.render(&camera, SIZE, &settings).unwrap();
        let drawn = renderer.picture().unwrap().mean()[1];

        let environment = EnvironmentMap::from_fn(128, 64, |w| lights.radiance(w)).0;
        let settings = TraceSettings {
            samples: 8,
            candidates: 6,
            orders: 400,
            is_deon: model == Model::Deon,
            ..TraceSettings::default()
        };
        let scene = Scene::new(&groom, &params, &environment);
        let traced = scene
            .trace(&camera, SIZE, &settings, &|| ControlFlow::Continue(()))
            .unwrap();
        let (single, all) = (traced.single.mean()[1], traced.all.mean()[1]);
        eprintln!("{model:?}, absorption {sigma_a}: {drawn:.4}, traced {all:.4}, once scattered {single:.4}");
        let is_near = |wanted: f64| (drawn / wanted - 1.0).abs() < most_off;
        assert!(is_near(all), "{drawn} instead of {all}");
        assert!(!is_near(single), "multiple scattering is nothing here");
        if sigma_a == 0.0 {
            // The one model loses nothing, the other what it would carry beyond TRT.
            assert_eq!(model == Model::Deon, (all - 1.0).abs() < 0.02, "{all}");
        }
    }
}
