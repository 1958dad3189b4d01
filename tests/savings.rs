//! What a scene does not need is not computed: counted after every kind of edit, and the picture hardly tells.

use balayage_render::gpu::stale::{Changes, Input, Product};
use balayage_render::gpu::{
    Camera, FrameReport, Gpu, Quality, RenderSettings, Renderer, Saving, Savings, Terms,
};
use balayage_render::groom::Groom;
use balayage_render::image::Picture;
use balayage_render::light::{FitSettings, LightSet, PRESETS, Preset, SrbfLight, fit_lights};
use balayage_render::param::{LobeRatios, PigmentSet, PointValues, VertexParams};
use glam::{Quat, Vec3};
use std::ops::ControlFlow;

const SIZE: [u32; 2] = [96, 96];
const STRANDS: usize = 108;

/// Wavy strands in a block, `turns` waves along each.
fn wavy(turns: f32) -> Groom {
    wavy_and_thick(turns, 0.05)
}

/// The same with fibres of a diameter; a pixel of the usual picture is about 0.03.
fn wavy_and_thick(turns: f32, diameter: f32) -> Groom {
    let strands = (0..STRANDS).map(|i| {
        let root = Vec3::new(0.2 * (i % 12) as f32, 0.0, -0.15 * (i / 12) as f32);
        (0..12)
            .map(|k| {
                let s = k as f32 / 11.0;
                let phase = turns * std::f32::consts::TAU * s + 0.7 * i as f32;
                root + Vec3::new(0.1 * phase.sin(), -2.0 * s, 0.1 * phase.cos())
            })
            .collect::<Vec<_>>()
    });
    Groom::from_strands(strands.collect::<Vec<_>>(), diameter, 1.0)
        .unwrap()
        .0
}

fn lights(count: usize) -> LightSet {
    let lights = (0..count).map(|k| {
        let turn = 2.4 * k as f32;
        SrbfLight {
            direction: Vec3::new(turn.cos(), 0.3 + 0.1 * (k % 5) as f32, turn.sin()).normalize(),
            bandwidth: 0.15 + 0.05 * (k % 8) as f32,
            radiance: Vec3::new(1.0, 0.9, 0.8) * (1.0 + (k % 3) as f32),
        }
    });
    LightSet {
        lights: lights.collect(),
        ..Default::default()
    }
}

/// A few lights of a sky or studio.
fn environment(name: &str) -> LightSet {
    match Preset::named(name).unwrap() {
        Preset::Lights(lights) => lights,
        Preset::Sky(sky) => {
            let settings = FitSettings {
                count: 8,
                ..Default::default()
            };
            fit_lights(&sky.map(32).0, &settings, &|_| ControlFlow::Continue(())).unwrap()
        }
    }
}

fn hair(groom: &Groom) -> Vec<VertexParams> {
    vec![
        PointValues::default().vertex_params(PigmentSet::default(), &LobeRatios::default());
        groom.point_count()
    ]
}

struct Scene {
    groom: Groom,
    params: Vec<VertexParams>,
    camera: Camera,
    renderer: Renderer,
}

impl Scene {
    fn new(gpu: &Gpu, groom: Groom, lights: &LightSet) -> Self {
        let mut scene = Self {
            params: Vec::new(),
            camera: Camera::framing(groom.bounds(), 1.0),
            groom: groom.clone(),
            renderer: Renderer::new(gpu).unwrap(),
        };
        scene.wear(groom);
        scene.renderer.set_lights(lights);
        scene
    }

    fn wear(&mut self, groom: Groom) {
        self.params = hair(&groom);
        self.renderer.set_groom(&groom, None).unwrap();
        self.renderer.set_params(&self.params, &[]).unwrap();
        self.groom = groom;
    }

    fn frame(&mut self, settings: &RenderSettings) -> FrameReport {
        self.renderer.render(&self.camera, SIZE, settings).unwrap()
    }

    fn picture(&mut self, settings: &RenderSettings) -> Picture {
        self.frame(settings);
        self.renderer.picture().unwrap()
    }
}

fn rmse(a: &Picture, b: &Picture) -> f64 {
    a.difference(b, 1).tile_rmse
}

/// What each counter is work on.
const COUNTERS: [(&str, Product); 10] = [
    ("voxels painted", Product::Losses),
    ("visibility rays", Product::Visibility),
    ("exact rays", Product::Visibility),
    ("path rays", Product::PathSums),
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
    let still = RenderSettings::default();
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
fn one_light_of_many_costs_one_light() {
    let gpu = Gpu::headless().unwrap();
    let still = RenderSettings::default();
    let moving = RenderSettings {
        interactive: true,
        ..still
    };
    let mut set = lights(12);
    let mut scene = Scene::new(&gpu, wavy(1.0), &set);
    let first = scene.frame(&still);
    scene.frame(&moving);
    for (k, moves) in [(0, false), (1, true), (2, true), (3, false)] {
        set.lights[5].radiance *= 1.5;
        if moves {
            set.lights[5].direction = Quat::from_rotation_y(0.2) * set.lights[5].direction;
        }
        scene.renderer.set_lights(&set);
        let report = scene.frame(&moving);
        let single = report.counter("single scattering evaluations");
        // Taken away and added, of twelve.
        assert!(
            single > 0 && 5 * single <= first.counter("single scattering evaluations"),
            "step {k}: {single}"
        );
        assert_eq!(report.counter("visibility rays") > 0, moves);
        assert!(11 * report.counter("visibility rays") <= 2 * first.counter("visibility rays"));
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
        assert!((ratio - 1.0).abs() < 0.08, "a share of {share}: {ratio}");
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
