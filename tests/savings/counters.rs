//! Work counted after every kind of edit.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::*;
use balayage_render::gpu::GpuError;
use balayage_render::gpu::stale::{Changes, Input, Product};
use balayage_render::volume::lobe::{LobeLight, lobe_tables};

/// What each counter is work on.
const COUNTERS: [(&str, Product); 11] = [
    ("voxels painted", Product::Losses),
    ("visibility rays", Product::Visibility),
    ("exact rays", Product::Visibility),
    ("path rays", Product::PathSums),
    ("photon rays", Product::Scattered),
    ("multiple scattering evaluations", Product::Multiple),
    ("vertices shaded", Product::Single),
    ("single scattering evaluations", Product::Single),
    ("head vertices shaded", Product::Head),
    ("fragments", Product::Fragments),
    ("parameter bytes uploaded", Product::Losses),
];

#[test]
fn each_edit_costs_what_the_graph_says_and_no_more() {
    let gpu = Gpu::headless().unwrap();
    let still = summed();
    let mut scene = Scene::new(&gpu, wavy(1.0), &lights(8));
    let first = scene.frame(&still);
    let whole = |counter: &str| first.counter(counter);
    let check = |report: &FrameReport, changed: &[Input], does: &[&str]| {
        let mut changes = Changes::default();
        changed.iter().for_each(|input| changes.note(*input));
        let stale = changes.stale();
        for (counter, product) in COUNTERS {
            let count = report.counter(counter);
            assert!(
                count == 0 || stale.has(product),
                "{counter}: {count} after {changed:?}"
            );
        }
        for counter in does {
            assert!(report.counter(counter) > 0, "{counter} after {changed:?}");
        }
    };

    // Nothing.
    assert_eq!(scene.frame(&still).passes, []);

    // The display's exposure: one pass. The light's: pixels are composed and shown again.
    let brighter = RenderSettings {
        view_exposure_ev: 1.0,
        ..still
    };
    let report = scene.frame(&brighter);
    assert_eq!(
        report
            .passes
            .iter()
            .map(|(name, _)| name.as_str())
            .collect::<Vec<_>>(),
        ["view"]
    );
    scene.frame(&still);
    let mut tinted = lights(8);
    for light in &mut tinted.lights {
        light.radiance *= Vec3::new(2.0, 1.5, 0.5);
    }
    scene.renderer.set_lights(&tinted);
    let report = scene.frame(&still);
    check(&report, &[Input::LightGain], &[]);
    let passes: Vec<_> = report.passes.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(passes, ["strand drawing", "view"]);

    // Another colour of all lights, each its own way: no march.
    for (k, light) in tinted.lights.iter_mut().enumerate() {
        light.radiance *= 1.0 + 0.05 * k as f32;
    }
    scene.renderer.set_lights(&tinted);
    let report = scene.frame(&still);
    check(
        &report,
        &[Input::LightColours],
        &["vertices shaded", "multiple scattering evaluations"],
    );

    // Turned: everything that lights reach, no parameter.
    scene.renderer.set_lights(&tinted.rotated(0.3));
    let report = scene.frame(&still);
    check(&report, &[Input::LightPlaces], &["visibility rays", "path rays"]);
    assert_eq!(report.counter("parameter bytes uploaded"), 0);

    // Dye on one strand while a hand moves: its vertices only; at rest the way of light through it.
    let painting = RenderSettings {
        interactive: true,
        ..still
    };
    for point in &mut scene.params[240..252] {
        point.sigma_a = [2.0, 0.2, 0.1];
    }
    let dirty = 240..252;
    scene.renderer.set_params(&scene.params, &[dirty]).unwrap();
    let report = scene.frame(&painting);
    check(&report, &[Input::Parameters], &["parameter bytes uploaded"]);
    assert_eq!(
        report.counter("parameter bytes uploaded"),
        12 * size_of::<VertexParams>() as u64
    );
    assert!(report.counter("vertices shaded") < whole("vertices shaded") / 40);
    assert_eq!(report.counter("path rays") + report.counter("voxels painted"), 0);
    let report = scene.frame(&still);
    check(&report, &[Input::Parameters], &["path rays", "voxels painted"]);
    assert_eq!(report.counter("vertices shaded"), 0);
    assert!(
        report.counter("voxels painted") < whole("voxels painted") / 4,
        "{} of {}",
        report.counter("voxels painted"),
        whole("voxels painted")
    );

    // The camera nearer: what is there of the light stays.
    let eye = scene.camera.position();
    let (low, high) = scene.groom.bounds();
    scene.camera = Camera::look_at(1.1 * eye, 0.5 * (low + high), 0.6);
    let report = scene.frame(&still);
    check(&report, &[Input::Eye], &["vertices shaded", "fragments"]);
    assert_eq!(report.counter("voxels painted"), 0);

    // Better quality shades again, worse keeps what is there.
    let quality = |quality| {
        let mut settings = still;
        settings.shade.method.quality = quality;
        settings
    };
    assert_eq!(
        scene.frame(&quality(Quality::Draft)).counter("vertices shaded"),
        0
    );
    assert_eq!(scene.frame(&still).counter("vertices shaded"), 0);

    // The control: with nothing kept the same frame does everything again.
    let anew = RenderSettings {
        savings: Savings::ALL.without(Saving::Untouched),
        ..still
    };
    let report = scene.frame(&anew);
    for counter in [
        "voxels painted",
        "visibility rays",
        "path rays",
        "vertices shaded",
        "fragments",
    ] {
        assert!(report.counter(counter) > 0, "{counter}");
    }
}

#[test]
fn photons_fly_when_what_scatters_them_changes_and_the_hand_rests() {
    let gpu = Gpu::headless().unwrap();
    let still = RenderSettings::default();
    let moving = RenderSettings {
        interactive: true,
        ..still
    };
    let mut set = lights(8);
    let mut scene = Scene::new(&gpu, wavy(1.0), &set);
    let photons = |report: &FrameReport| report.counter("photon rays");
    let first = scene.frame(&still);
    let whole = PHOTON_RAYS..PHOTON_RAYS + PHOTON_RAYS / 10;
    assert!(whole.contains(&photons(&first)), "{}", photons(&first));
    assert_eq!(first.counter("path rays") + first.counter("voxels painted"), 0);

    // Where the eye is, how bright all of it is and how it is shown are no matter.
    let eye = scene.camera.position();
    scene.camera.world_from_camera.w_axis = (1.05 * eye).extend(1.0);
    let report = scene.frame(&still);
    assert!(report.counter("multiple scattering evaluations") > 0 && photons(&report) == 0);
    set.lights.iter_mut().for_each(|light| light.radiance *= 2.0);
    scene.renderer.set_lights(&set);
    assert_eq!(photons(&scene.frame(&still)), 0);

    // Dye waits for the hand to rest. Other light flies at once, less of it; the rest follows.
    scene.params[240..252]
        .iter_mut()
        .for_each(|point| point.sigma_a = [2.0, 0.2, 0.1]);
    let dirty = 240..252;
    scene
        .renderer
        .set_params(&scene.params, std::slice::from_ref(&dirty))
        .unwrap();
    let report = scene.frame(&moving);
    assert!(report.counter("vertices shaded") > 0 && photons(&report) == 0);
    // A stroke that begins before the new field is whole sees the old one.
    scene
        .renderer
        .set_interrupt(Some(Arc::new(AtomicBool::new(true))));
    let given_up = scene.renderer.render(&scene.camera, SIZE, &still);
    assert!(matches!(given_up, Err(GpuError::Interrupted)));
    scene.renderer.set_interrupt(None);
    assert_eq!(photons(&scene.frame(&moving)), 0);
    assert!(whole.contains(&photons(&scene.frame(&still))));
    scene.renderer.set_lights(&set.rotated(0.1));
    let quick = photons(&scene.frame(&moving));
    assert!(quick > 0 && quick < PHOTON_RAYS / 2, "{quick}");
    assert!(whole.contains(&(quick + photons(&scene.frame(&still)))));

    // A refined view adds to what there is; other terms begin anew; without the light there is nothing to do.
    let refined = RenderSettings {
        visibility_rays: 2,
        ..still
    };
    let more = photons(&scene.frame(&refined));
    assert!(more > 0 && more < PHOTON_RAYS, "{more}");
    assert_eq!(photons(&scene.frame(&still)), 0);
    let mut other = still;
    other.shade.terms = Terms::D;
    assert!(whole.contains(&photons(&scene.frame(&other))));
    other.shade.multiple = Multiple::Off;
    let report = scene.frame(&other);
    assert_eq!(
        photons(&report) + report.counter("multiple scattering evaluations"),
        0
    );
}

#[test]
fn one_light_of_many_costs_one_light() {
    let gpu = Gpu::headless().unwrap();
    let still = summed();
    let moving = RenderSettings {
        interactive: true,
        ..still
    };
    let mut set = lights(12);
    let mut scene = Scene::new(&gpu, wavy(1.0), &set);
    let first = scene.frame(&still);
    scene.frame(&moving);
    for (k, moves) in [(0, false), (1, true), (2, true), (3, false)] {
        // So little that no other light becomes one that is weak beside it, and marched to in another way.
        set.lights[5].radiance *= 1.2;
        if moves {
            set.lights[5].direction = Quat::from_rotation_y(0.2) * set.lights[5].direction;
        }
        scene.renderer.set_lights(&set);
        let report = scene.frame(&moving);
        let single = report.counter("single scattering evaluations");
        // A light that moves is taken away and added, of twelve; of one that changes its colour the difference is enough.
        let most = if moves { 5 } else { 10 };
        assert!(
            single > 0 && most * single <= first.counter("single scattering evaluations"),
            "step {k}: {single} of {}",
            first.counter("single scattering evaluations")
        );
        assert_eq!(report.counter("visibility rays") > 0, moves);
        // No rays but those of the light that moved.
        let rays_of = |light: &LobeLight| u64::from(light.visibility_count);
        let frames = lobe_tables(&set.lights).0;
        let all = frames.iter().map(rays_of).sum::<u64>();
        assert!(
            all * report.counter("visibility rays") <= rays_of(&frames[5]) * first.counter("visibility rays")
        );
    }
    let changed = scene.renderer.picture().unwrap();
    let mut fresh = Scene::new(&gpu, wavy(1.0), &set);
    let wanted = fresh.picture(&still);
    assert!(rmse(&changed, &wanted) < Saving::FewLights.bound());
    let unchanged = Scene::new(&gpu, wavy(1.0), &lights(12)).picture(&still);
    assert!(
        rmse(&unchanged, &wanted) > 10.0 * Saving::FewLights.bound(),
        "the edits are seen"
    );

    // At rest nothing of the sums is left.
    assert_eq!(scene.picture(&still).pixels, wanted.pixels);
}

#[test]
fn circular_hair_runs_no_elliptic_code() {
    let gpu = Gpu::headless().unwrap();
    let still = RenderSettings::default();
    let mut scene = Scene::new(&gpu, wavy(1.0), &lights(4));
    assert_eq!(scene.frame(&still).counter("elliptic evaluations"), 0);
    scene.params[3].eccentricity = 1.4;
    let dirty = 3..4;
    scene.renderer.set_params(&scene.params, &[dirty]).unwrap();
    let report = scene.frame(&still);
    let elliptic = report.counter("elliptic evaluations");
    assert!(elliptic > 0 && elliptic <= report.counter("single scattering evaluations"));
}
