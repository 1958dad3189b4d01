//! What the savings do to the picture.

use super::*;

#[test]
fn savings_change_the_picture_by_less_than_they_say() {
    let gpu = Gpu::headless().unwrap();
    // No saving changes what photons do.
    let with = |savings| RenderSettings { savings, ..summed() };
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
        // All of them on the straight hair, every third on the others.
        let some = environments.iter().step_by(if turns == 0.0 { 1 } else { 3 });
        for (name, lights) in some {
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
    // The hand rested before: what it sees is traced well.
    scene.frame(&RenderSettings::default());
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
    let sum = |picture: &Picture| picture.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
    let settings = RenderSettings {
        savings: Savings::ALL.without(Saving::Levels),
        ..RenderSettings::default()
    };
    // A share draws the first strands, so few here that the sum scatters by 8 % at a quarter: the mean over several orders is held.
    const ORDERS: usize = 8;
    let (mut ratios, mut single) = ([0.0; 2], 0.0);
    for order in 0..ORDERS {
        let mut scene = Scene::new(&gpu, reordered(&wavy(1.0), 13 * order), &lights(6));
        let [whole, half, quarter] = [1.0, 0.5, 0.25].map(|strand_share| {
            let part = RenderSettings {
                strand_share,
                ..settings
            };
            let light = sum(&scene.picture(&part));
            let drawn = scene.frame(&RenderSettings { samples: 2, ..part });
            (light, drawn.counter("strand segments drawn"))
        });
        assert!(10 * half.1 < 6 * whole.1 && 10 * quarter.1 < 6 * half.1);
        for (ratio, part) in ratios.iter_mut().zip([half, quarter]) {
            *ratio += part.0 / whole.0 / ORDERS as f64;
        }
        let mut alone = settings;
        alone.shade.terms = Terms::SINGLE;
        single += sum(&scene.picture(&alone)) / whole.0 / ORDERS as f64;
    }
    assert!(ratios.iter().all(|r| (r - 1.0).abs() < 0.05), "{ratios:?}");
    // What strands lose without their width would tell: so does light that fibres scatter once.
    assert!((single - 1.0).abs() > 0.08, "{single}");

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
