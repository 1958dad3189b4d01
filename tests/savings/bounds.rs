//! What the savings do to the picture.

use super::*;

#[test]
fn savings_change_the_picture_by_less_than_they_say() {
    let gpu = Gpu::headless().unwrap();
    let with = |savings| RenderSettings {
        savings,
        ..RenderSettings::default()
    };
    let mut largest = 0_f64;
    let mut scene = Scene::new(&gpu, wavy(0.0), &LightSet::default());
    let environments: Vec<_> = PRESETS.into_iter().filter(|name| *name != "uniform").collect();
    let environments: Vec<_> = environments
        .iter()
        .map(|name| (*name, environment(name)))
        .collect();
    assert_eq!(environments.len(), 6);
    for (turns, sigma_a) in [
        (0.0, [0.3, 0.5, 0.9]),
        (1.0, [0.05, 0.1, 0.2]),
        (3.0, [7.0, 8.0, 9.0]),
    ] {
        scene.wear(wavy(turns));
        for point in &mut scene.params {
            point.sigma_a = sigma_a;
        }
        scene.renderer.set_params(&scene.params, &[]).unwrap();
        for (name, lights) in &environments {
            scene.renderer.set_lights(lights);
            let reference = scene.picture(&with(Savings::NONE));
            let all = rmse(&scene.picture(&with(Savings::ALL)), &reference);
            let bound = Saving::ALL
                .map(|saving| saving.bound().powi(2))
                .iter()
                .sum::<f64>();
            assert!(all <= bound.sqrt(), "{name}, {turns} turns: {all}");
            largest = largest.max(all);
        }
        let reference = scene.picture(&with(Savings::NONE));
        for saving in Saving::ALL {
            let error = rmse(&scene.picture(&with(Savings::NONE.with(saving))), &reference);
            assert!(
                error <= saving.bound(),
                "{} at {turns} turns: {error}",
                saving.name()
            );
        }
    }
    assert!(largest > 1e-4, "the comparison sees something: {largest}");
}

#[test]
fn a_turning_view_keeps_what_light_other_fibres_send_for_two_degrees() {
    let gpu = Gpu::headless().unwrap();
    let mut scene = Scene::new(&gpu, wavy(1.0), &lights(6));
    let moving = RenderSettings {
        interactive: true,
        ..RenderSettings::default()
    };
    scene.frame(&moving);
    let (eye, centre) = (scene.camera.position(), {
        let (low, high) = scene.groom.bounds();
        0.5 * (low + high)
    });
    let mut evaluated = Vec::new();
    for degrees in [1.0_f32, 1.9, 3.0] {
        let turn = Quat::from_rotation_y(degrees.to_radians());
        scene.camera = Camera::look_at(centre + turn * (eye - centre), centre, scene.camera.fov_y_rad);
        let before = scene.frame(&moving).counter("multiple scattering evaluations");
        evaluated.push(before);
    }
    // A few points come into view; beyond two degrees all are evaluated again.
    assert!(
        10 * evaluated[0] < evaluated[2] && 10 * evaluated[1] < evaluated[2],
        "{evaluated:?}"
    );
    let lagging = {
        let turn = Quat::from_rotation_y(4.9_f32.to_radians());
        scene.camera = Camera::look_at(centre + turn * (eye - centre), centre, scene.camera.fov_y_rad);
        scene.picture(&moving)
    };
    let resting = scene.picture(&RenderSettings::default());
    let error = rmse(&lagging, &resting);
    assert!(error > 0.0 && error < Saving::Turning.bound(), "{error}");
}

#[test]
fn fewer_wider_strands_keep_the_hairs_light() {
    let gpu = Gpu::headless().unwrap();
    let mut scene = Scene::new(&gpu, wavy(1.0), &lights(6));
    let sum = |picture: &Picture| picture.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
    let mut settings = RenderSettings {
        savings: Savings::ALL.without(Saving::Levels),
        ..RenderSettings::default()
    };
    let whole = scene.picture(&settings);
    let mut drawn = scene.frame(&RenderSettings {
        samples: 2,
        ..settings
    });
    for share in [0.5, 0.25] {
        settings.strand_share = share;
        let part = scene.picture(&settings);
        let report = scene.frame(&RenderSettings {
            samples: 2,
            ..settings
        });
        let ratio = sum(&part) / sum(&whole);
        // The fewer strands are a sample, the wider its mean scatters.
        let bound = 0.05 / f64::from(share).sqrt();
        assert!((ratio - 1.0).abs() < bound, "a share of {share}: {ratio}");
        let segments = |report: &FrameReport| report.counter("strand segments drawn");
        assert!(
            10 * segments(&report) < 6 * segments(&drawn),
            "{}",
            segments(&report)
        );
        drawn = report;
    }
    // Without the width the picture would be half as bright: the sum tells.
    settings.shade.terms = Terms::SINGLE;
    settings.strand_share = 1.0;
    assert!((sum(&scene.picture(&settings)) / sum(&whole) - 1.0).abs() > 0.08);

    // Strands far finer than a pixel: fewer are drawn, the light stays.
    let mut scene = Scene::new(&gpu, wavy_and_thick(1.0, 3e-4), &lights(6));
    let far = |savings| RenderSettings {
        savings,
        ..RenderSettings::default()
    };
    let every = scene.picture(&far(Savings::ALL.without(Saving::Levels)));
    let all = scene
        .frame(&RenderSettings {
            samples: 2,
            ..far(Savings::ALL.without(Saving::Levels))
        })
        .counter("strand segments drawn");
    let level = scene.picture(&far(Savings::ALL));
    let few = scene
        .frame(&RenderSettings {
            samples: 2,
            ..far(Savings::ALL)
        })
        .counter("strand segments drawn");
    assert!(few > 0 && few < all, "{few} of {all}");
    let covered = |picture: &Picture| picture.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>();
    let ratios = [covered(&level) / covered(&every), sum(&level) / sum(&every)];
    assert!((ratios[0] - 1.0).abs() < 0.1, "{ratios:?}");
    // Few strands stand for the hair's colour: the error of a sample of them.
    assert!((ratios[1] - 1.0).abs() < 0.2, "{ratios:?}");
}
