//! SRBF lights: laws of their integral, rotation and file; laws, figures and determinism of the fit.

use std::cell::{Cell, RefCell};
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

use balayage_render::light::{
    EnvironmentMap, Fit, FitError, FitSettings, GradientSky, HairKernel, HairProbe, Harmonics, LightSet,
    Objective, PRESETS, Preset, SrbfLight, Work, fit, fit_counted, fit_lights, fit_to_error, preview,
};
use balayage_tests::{POISON, damage, random, repository, test_data};
use glam::{Quat, Vec3};
use rand::Rng;

const GO_ON: &dyn Fn(f64) -> ControlFlow<()> = &|_| ControlFlow::Continue(());

fn three_lights() -> LightSet {
    let light = |direction: Vec3, bandwidth, radiance| SrbfLight {
        direction: direction.normalize(),
        bandwidth,
        radiance,
    };
    let lights = vec![
        light(Vec3::new(1.0, 2.0, 0.5), 0.15, Vec3::new(30.0, 25.0, 15.0)),
        light(Vec3::new(-1.0, 0.1, -1.0), 0.5, Vec3::new(1.0, 2.0, 3.0)),
        light(Vec3::new(0.2, -0.8, 1.0), 1.2, Vec3::new(0.5, 0.4, 0.3)),
    ];
    LightSet {
        lights,
        constant: Vec3::ZERO,
    }
}

fn map_of(lights: &LightSet) -> EnvironmentMap {
    EnvironmentMap::from_fn(256, 128, |w| lights.radiance(w)).0
}

fn sample(name: &str) -> EnvironmentMap {
    EnvironmentMap::read(&repository(&format!("projects/environments/{name}.hdr")))
        .expect("a sample environment")
        .0
}

fn fitted(map: &EnvironmentMap, count: usize) -> Fit {
    fit(
        map,
        &FitSettings {
            count,
            ..FitSettings::default()
        },
        GO_ON,
    )
    .expect("a fit that is not cancelled")
}

#[test]
fn energy_is_the_integral_of_radiance() {
    let mut lights = three_lights();
    lights.constant = Vec3::new(0.1, 0.2, 0.3);
    let relative = map_of(&lights).energy() / lights.energy() - 1.0;
    assert!(relative.abs().max_element() < 1e-4, "{relative}");

    // The widest and a very narrow light, against the closed form's own limits 4 pi and pi lambda^2.
    let solid_angle = |bandwidth| {
        SrbfLight {
            direction: Vec3::Y,
            bandwidth,
            radiance: Vec3::ONE,
        }
        .solid_angle()
    };
    assert!((solid_angle(10.0) / (4.0 * PI) - 1.0).abs() < 0.02);
    assert!((solid_angle(1e-3) / (PI * 1e-6) - 1.0).abs() < 1e-6);
}

#[test]
fn solid_angles_of_pixels_sum_to_the_sphere() {
    for (width, height) in [(1, 1), (7, 3), (64, 32)] {
        let (map, _) = EnvironmentMap::from_fn(width, height, |_| Vec3::ONE);
        assert!((map.energy().x - 4.0 * PI).abs() < 1e-9);
    }
}

#[test]
fn rotation_moves_radiance_and_shifts_the_map() {
    let lights = three_lights();
    let mut random = random(7);
    for _ in 0..50 {
        let angle = random.random_range(-7.0..7.0);
        let w = Quat::from_rotation_x(random.random_range(0.0..6.0)) * Vec3::new(0.6, 0.0, 0.8);
        let turned = lights.rotated(angle).radiance(Quat::from_rotation_y(angle) * w);
        assert!(turned.abs_diff_eq(lights.radiance(w), 1e-3), "{angle} {w}");
    }

    // A quarter turn is a quarter of the map's width to the left.
    let (map, turned) = (
        map_of(&lights),
        map_of(&lights.rotated(std::f32::consts::FRAC_PI_2)),
    );
    let row = 40 * map.width;
    for x in 0..map.width {
        let shifted = map.pixels[row + (x + map.width / 4) % map.width];
        assert!(turned.pixels[row + x].abs_diff_eq(shifted, 1e-3), "column {x}");
    }
    let brighter = lights.exposed(2.0).radiance(Vec3::X);
    assert!(brighter.abs_diff_eq(4.0 * lights.radiance(Vec3::X), 1e-4));
}

#[test]
fn light_files_come_back_exactly() {
    let mut lights = three_lights();
    lights.constant = Vec3::new(0.1, 1e-20, 3.0e30);
    let file = tempfile::NamedTempFile::new().unwrap();
    lights.write(file.path()).unwrap();
    let back = LightSet::read(file.path()).unwrap();
    for (a, b) in lights.lights.iter().zip(&back.lights) {
        assert!(a.direction.abs_diff_eq(b.direction, 1e-6));
        assert_eq!((a.bandwidth, a.radiance), (b.bandwidth, b.radiance));
    }
    assert_eq!((lights.constant, 3), (back.constant, back.lights.len()));
}

#[test]
fn light_files_are_refused_with_light_and_field() {
    let read = |text: &str| LightSet::from_json(text, Path::new("l.json"));
    let light = |direction: &str, bandwidth: &str, radiance: &str| {
        let good = r#"{"direction": [0, 1, 0], "bandwidth": 1, "radiance": [1, 1, 1]}"#;
        let light =
            format!(r#"{{"direction": {direction}, "bandwidth": {bandwidth}, "radiance": {radiance}}}"#);
        read(&format!(r#"{{"lights": [{good}, {light}]}}"#))
    };
    let up = "[0, 1, 0]";
    assert!(light("[0, 1.005, 0]", "10", up).is_ok_and(|set| set.lights[1].direction == Vec3::Y));
    let cases = [
        (light("[0, 2, 0]", "1", up), "light 1, direction", "length 2"),
        (light("[0, 0, 0]", "1", up), "light 1, direction", "length 0"),
        (light(up, "0", up), "light 1, bandwidth", "0 is not in"),
        (light(up, "-1", up), "light 1, bandwidth", "-1 is not in"),
        (light(up, "11", up), "light 1, bandwidth", "11 is not in"),
        (light(up, "1e39", up), "light 1", "inf"),
        (
            light(up, "1", "[1, -1, 0]"),
            "light 1, radiance",
            "not finite and at least 0",
        ),
        (
            light(up, "1", "[1, 1e39, 0]"),
            "light 1, radiance",
            "not finite and at least 0",
        ),
        (light(up, "1", "[1, 1]"), "light 1", "invalid length"),
        (light(up, "\"wide\"", up), "light 1", "invalid type"),
        (
            read(r#"{"lights": [], "constant": [0, -1, 0]}"#),
            "constant",
            "not finite",
        ),
        (read(r#"{"lights": [], "extra": 1}"#), "line 1", "unknown field"),
        (
            read(r#"{"lights": [{"bandwidth": 1}]}"#),
            "light 0",
            "missing field",
        ),
        (read("{"), "line 1", "EOF"),
        (read("[]"), "line 1", ""),
    ];
    for (number, (result, place, reason)) in cases.into_iter().enumerate() {
        let error = result.expect_err("a bad file was read");
        let text = error.to_string();
        assert!(
            text.starts_with("l.json: ") && text.contains(place) && text.contains(reason),
            "{number}: {text}"
        );
    }

    // What would not be read back is not written.
    for poison in POISON {
        let mut lights = three_lights();
        lights.lights[2].bandwidth = poison;
        let file = tempfile::NamedTempFile::new().unwrap();
        let is_good = poison > 0.0 && poison <= 10.0;
        assert_eq!(lights.write(file.path()).is_ok(), is_good, "{poison}");
        assert_eq!(LightSet::read(file.path()).is_ok(), is_good, "{poison}");
    }
}

#[test]
fn the_fit_finds_the_lights_that_made_the_map() {
    let made = three_lights();
    let Fit {
        lights,
        hair_error,
        energy_error,
        ..
    } = fitted(&map_of(&made), 3);
    assert!(hair_error < 2e-3, "{hair_error}");
    assert!(
        energy_error.iter().all(|error| error.abs() < 1e-3),
        "{energy_error:?}"
    );
    for wanted in &made.lights {
        let angle = |light: &SrbfLight| light.direction.angle_between(wanted.direction);
        let nearest = lights
            .lights
            .iter()
            .min_by(|a, b| angle(a).total_cmp(&angle(b)))
            .unwrap();
        assert!(angle(nearest) < 0.02, "{nearest:?} for {wanted:?}");
        assert!(
            (nearest.bandwidth / wanted.bandwidth - 1.0).abs() < 0.05,
            "{nearest:?} for {wanted:?}"
        );
    }
}

#[test]
fn hair_error_is_relative() {
    let map = map_of(&three_lights());
    let probe = HairProbe::new(
        &map,
        HairKernel {
            fibres: 40,
            ..HairKernel::default()
        },
    );
    let exact = probe.error(&three_lights());
    let brighter = probe.error(&three_lights().scaled(Vec3::splat(1.01)));
    assert!(
        exact < 1e-5 && (brighter - 0.01).abs() < 1e-4,
        "{exact} {brighter}"
    );
    assert!((probe.error(&LightSet::default()) - 1.0).abs() < 1e-6);
}

#[test]
fn more_lights_are_closer() {
    let map = sample("sunrise");
    let probe = HairProbe::new(
        &map,
        HairKernel {
            fibres: 100,
            ..HairKernel::default()
        },
    );
    let error = |count| {
        let lights = fit_lights(
            &map,
            &FitSettings {
                count,
                ..FitSettings::default()
            },
            GO_ON,
        )
        .unwrap();
        assert!(
            lights
                .lights
                .iter()
                .all(|light| light.radiance.min_element() >= 0.0 && light.direction.is_normalized())
        );
        probe.error(&lights)
    };
    let errors = [5, 10, 20].map(error);
    assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
}

/// Fits 40 lights and holds the goal of the worst map, and of every channel's energy.
fn assert_forty_are_enough(name: &str, map: &EnvironmentMap) -> f64 {
    let Fit {
        hair_error,
        energy_error,
        relative_l2,
        seconds,
        lights,
    } = fitted(map, 40);
    println!(
        "{name}: hair {hair_error:.5} L2 {relative_l2:.3} energy {energy_error:.5?} {seconds:.2} s, {} lights",
        lights.lights.len()
    );
    assert!(hair_error < 0.008, "{name}: {hair_error}");
    assert!(
        energy_error.iter().all(|error| error.abs() < 0.004),
        "{name}: {energy_error:?}"
    );
    hair_error
}

#[test]
fn forty_lights_are_enough_for_a_sun() {
    // One with a sun; `bench lights` measures all.
    assert_forty_are_enough("sunrise", &sample("sunrise"));
}

#[test]
fn forty_lights_are_enough_for_lamps_at_night() {
    let Some(path) = test_data("fetched/env/ph_st_peters_square_night_512x256.hdr") else {
        return;
    };
    assert_forty_are_enough("st_peters_square_night", &EnvironmentMap::read(&path).unwrap().0);
}

#[test]
fn a_fit_depends_on_its_seed_and_not_on_threads() {
    let map = sample("city");
    let settings = FitSettings {
        count: 12,
        ..FitSettings::default()
    };
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| fit_lights(&map, &FitSettings { seed, ..settings }, GO_ON).unwrap())
    };
    let one = on(1, 0);
    assert_eq!(one, on(3, 0));
    assert_ne!(one, on(3, 1));
}

#[test]
fn a_turned_map_is_fitted_from_the_old_lights() {
    let map = sample("studio");
    let columns = 5;
    let turned = |index: usize| map.pixels[index / map.width * map.width + (index + columns) % map.width];
    let turned = EnvironmentMap {
        pixels: (0..map.pixels.len()).map(turned).collect(),
        ..map.clone()
    };
    let settings = FitSettings {
        count: 20,
        ..FitSettings::default()
    };
    let old = fit_lights(&map, &settings, GO_ON).unwrap();
    let new = fit_lights(
        &turned,
        &FitSettings {
            from: Some(&old),
            ..settings
        },
        GO_ON,
    )
    .unwrap();
    let probe = HairProbe::new(
        &turned,
        HairKernel {
            fibres: 100,
            ..HairKernel::default()
        },
    );
    let (before, after) = (probe.error(&old), probe.error(&new));
    assert!(after < 0.01 && after < 0.5 * before, "{before} {after}");
}

#[test]
fn least_squares_serves_its_own_measure_only() {
    let map = sample("sunrise");
    let by = |objective| {
        fit(
            &map,
            &FitSettings {
                count: 10,
                objective,
                ..FitSettings::default()
            },
            GO_ON,
        )
        .unwrap()
    };
    let (relative, l2) = (by(Objective::Relative), by(Objective::L2));
    assert!(
        l2.relative_l2 < relative.relative_l2,
        "{} {}",
        l2.relative_l2,
        relative.relative_l2
    );
    assert!(
        l2.hair_error > relative.hair_error,
        "{} {}",
        l2.hair_error,
        relative.hair_error
    );
}

#[test]
fn progress_rises_and_cancels() {
    let map = sample("city");
    let settings = FitSettings {
        count: 10,
        ..FitSettings::default()
    };
    let seen = RefCell::new(Vec::new());
    let record = |done| {
        seen.borrow_mut().push(done);
        ControlFlow::Continue(())
    };
    fit(&map, &settings, &record).unwrap();
    let calls = seen.borrow().len();
    assert!(
        calls > 60
            && seen.borrow().is_sorted()
            && seen.borrow().iter().all(|done| (0.0..=1.0).contains(done))
    );

    // Wherever it is cancelled, it stops there.
    for stop in [1, 2, calls / 4, calls - 1] {
        let count = RefCell::new(0);
        let cancel = |_| {
            *count.borrow_mut() += 1;
            if *count.borrow() == stop {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        assert_eq!(fit(&map, &settings, &cancel), Err(FitError::Cancelled));
        assert_eq!(*count.borrow(), stop);
    }
}

#[test]
fn odd_maps_fit() {
    let few = |map: &EnvironmentMap| fitted(map, 4);
    let uniform = EnvironmentMap {
        width: 1,
        height: 1,
        pixels: vec![Vec3::new(1.0, 2.0, 3.0)],
    };
    let fit = few(&uniform);
    assert_eq!(fit.lights, LightSet::uniform(uniform.pixels[0]));
    assert!(
        fit.hair_error < 1e-6 && fit.energy_error.iter().all(|error| error.abs() < 1e-6),
        "{fit:?}"
    );

    let (black, _) = EnvironmentMap::from_fn(8, 4, |_| Vec3::ZERO);
    let fit = few(&black);
    assert_eq!(
        (fit.hair_error, fit.relative_l2, fit.energy_error),
        (0.0, 0.0, [0.0; 3])
    );
    assert_eq!(fit.lights.radiance(Vec3::X), Vec3::ZERO);

    // Odd sizes, a column, a sun of one pixel in the dark, denormal and huge radiance.
    let (odd, _) = EnvironmentMap::from_fn(37, 11, |w| Vec3::splat(1.0 + w.y + 0.5 * w.x));
    let (column, _) = EnvironmentMap::from_fn(1, 9, |w| Vec3::splat(1.1 + w.y));
    let (mut sun, _) = EnvironmentMap::from_fn(128, 64, |_| Vec3::ZERO);
    sun.pixels[20 * 128 + 7] = Vec3::splat(1e6);
    let (dim, _) = EnvironmentMap::from_fn(32, 16, |w| Vec3::splat((1.1 + w.y) * 1e-30));
    let (huge, _) = EnvironmentMap::from_fn(32, 16, |w| Vec3::splat((1.1 + w.y) * 1e29));
    for (map, bound) in [
        (odd, 0.1),
        (column, 0.1),
        (sun.clone(), 0.6),
        (dim, 0.1),
        (huge, 0.1),
    ] {
        let fit = few(&map);
        assert!(
            fit.hair_error < bound,
            "{} x {}: {}",
            map.width,
            map.height,
            fit.hair_error
        );
        assert!(
            fit.energy_error.iter().all(|error| error.abs() < 0.02),
            "{:?}",
            fit.energy_error
        );
    }
    let none = FitSettings {
        count: 0,
        ..FitSettings::default()
    };
    assert_eq!(fit_lights(&black, &none, GO_ON), Err(FitError::Count(0)));
}

#[test]
fn the_gradient_sky_keeps_its_sun() {
    let sky = GradientSky::default();
    let (with, _) = sky.map(64);
    let (without, _) = GradientSky {
        sun_irradiance: Vec3::ZERO,
        ..sky
    }
    .map(64);
    let sun = with.energy() - without.energy();
    assert!(
        (sun / sky.sun_irradiance.as_dvec3() - 1.0).abs().max_element() < 1e-5,
        "{sun}"
    );

    // Poison is repaired and counted, never passed on.
    for poison in POISON {
        let (map, report) = GradientSky {
            zenith: Vec3::splat(poison),
            ..sky
        }
        .map(16);
        assert!(
            map.pixels
                .iter()
                .all(|pixel| pixel.is_finite() && pixel.min_element() >= 0.0)
        );
        let repaired = report.nan_pixels + report.infinite_pixels + report.negative_pixels;
        assert_eq!(repaired > 0, !(0.0..=1e30).contains(&poison), "{poison}");
    }
}

#[test]
fn a_preview_shows_map_lights_and_difference() {
    let lights = three_lights();
    let map = map_of(&lights);
    let same = preview(&map, &lights);
    assert_eq!(
        (same.width, same.height, same.rgb.len()),
        (256, 3 * 128 + 16, 3 * 256 * 400)
    );
    let panel = |picture: &[u8], number: usize| picture[number * 136 * 256 * 3..][..128 * 256 * 3].to_vec();
    assert_eq!(panel(&same.rgb, 0), panel(&same.rgb, 1));
    assert!(panel(&same.rgb, 2).iter().all(|byte| byte.abs_diff(128) <= 1));
    let dark = preview(&map, &lights.exposed(-1.0));
    assert!(panel(&dark.rgb, 2).iter().all(|byte| *byte < 128));
}

#[test]
fn damaged_light_lists_are_refused_or_sound() {
    let text = three_lights().to_json();
    let mut refused = 0;
    damage(text.as_bytes(), 64, 5, |bytes| {
        match LightSet::from_json(&String::from_utf8_lossy(bytes), Path::new("lights.json")) {
            Ok(read) => assert!(
                read.constant.is_finite()
                    && read.lights.iter().all(|l| {
                        l.direction.is_normalized()
                            && l.bandwidth > 0.0
                            && l.radiance.is_finite()
                            && l.radiance.min_element() >= 0.0
                    })
            ),
            Err(error) => {
                assert!(error.to_string().starts_with("lights.json: "));
                refused += 1;
            }
        }
    });
    assert!(refused > 100, "{refused} refused");
}

#[test]
fn a_change_beyond_recognition_gets_more_work() {
    let (city, sunrise) = (sample("city"), sample("sunrise"));
    let settings = FitSettings {
        count: 12,
        ..FitSettings::default()
    };
    let old = fit_lights(&city, &settings, GO_ON).unwrap();
    let warm = |map: &EnvironmentMap| {
        let settings = FitSettings {
            from: Some(&old),
            ..settings
        };
        fit_counted(map, &settings, GO_ON).unwrap()
    };
    let (_, gentle): (_, Work) = warm(&mixed(&city, &sunrise, 0.04));
    let (lights, abrupt) = warm(&sunrise);
    assert!(gentle.evaluations <= 16 && gentle.births <= 3, "{gentle:?}");
    assert!(abrupt.evaluations > gentle.evaluations, "{abrupt:?}");

    // What the city left behind is gone: the new lights are about as good as those of a fit from nothing.
    let probe = HairProbe::new(
        &sunrise,
        HairKernel {
            fibres: 60,
            ..HairKernel::default()
        },
    );
    let cold = fit_lights(&sunrise, &settings, GO_ON).unwrap();
    let (warm, cold) = (probe.error(&lights), probe.error(&cold));
    assert!(warm < 2.0 * cold, "{warm} {cold}");
}

#[test]
fn no_long_work_lies_between_two_calls_of_progress() {
    let map = sample("city");
    let cold = FitSettings {
        count: 10,
        ..FitSettings::default()
    };
    let old = fit_lights(&map, &cold, GO_ON).unwrap();
    let warm = FitSettings {
        from: Some(&old),
        ..cold
    };
    for settings in [cold, warm] {
        let calls = Cell::new(0);
        let count = |_| {
            calls.set(calls.get() + 1);
            ControlFlow::Continue(())
        };
        let (_, work) = fit_counted(&map, &settings, &count).unwrap();
        // The first evaluation comes before any step.
        let asked = calls.get();
        assert!(
            work.evaluations <= asked + 1 && work.births < asked,
            "{work:?}, {asked} calls"
        );
        assert!(work.evaluations > 10, "{work:?}");
    }
}

/// Every pixel of `a` and `b` mixed by `share` of `b`.
fn mixed(a: &EnvironmentMap, b: &EnvironmentMap, share: f32) -> EnvironmentMap {
    let mix = |(p, q): (&Vec3, &Vec3)| p.lerp(*q, share);
    EnvironmentMap {
        pixels: a.pixels.iter().zip(&b.pixels).map(mix).collect(),
        ..a.clone()
    }
}

#[test]
fn a_blend_is_followed_without_flicker() {
    let (city, sunrise) = (sample("city"), sample("sunrise"));
    let kernel = HairKernel {
        fibres: 60,
        ..HairKernel::default()
    };
    let ends = [&city, &sunrise].map(|map| HairProbe::new(map, kernel));
    let mut last: Option<LightSet> = None;
    let mut differences: Vec<Vec<glam::DVec3>> = Vec::new();
    for step in 9..14 {
        let share = step as f32 / 24.0;
        let settings = FitSettings {
            from: last.as_ref(),
            ..FitSettings::default()
        };
        let lights = fit_lights(&mixed(&city, &sunrise, share), &settings, GO_ON).unwrap();
        let wanted = ends[0].map_radiance().iter().zip(ends[1].map_radiance());
        let relative = |(fitted, (a, b)): (&glam::DVec3, (&glam::DVec3, &glam::DVec3))| {
            let wanted = a.lerp(*b, f64::from(share));
            (*fitted - wanted) / wanted.length()
        };
        differences.push(
            ends[0]
                .radiance(&lights)
                .iter()
                .zip(wanted)
                .map(relative)
                .collect(),
        );
        last = Some(lights);
    }
    let rms = |values: &mut dyn Iterator<Item = glam::DVec3>| {
        let (sum, count) = values.fold((0.0, 0), |(sum, count), v| (sum + v.length_squared(), count + 1));
        (sum / f64::from(count)).sqrt()
    };
    for of_step in &differences {
        assert!(rms(&mut of_step.iter().copied()) < 0.009);
    }
    for three in differences.windows(3) {
        let second = |i: usize| three[0][i] - 2.0 * three[1][i] + three[2][i];
        let flicker = rms(&mut (0..kernel.fibres).map(second));
        assert!(flicker < 0.006, "{flicker}");
    }
}

#[test]
fn as_many_lights_as_the_error_asks_for() {
    let (map, _) = GradientSky::default().map(32);
    let settings = FitSettings {
        count: 10,
        ..FitSettings::default()
    };
    let error_of = |count| fitted(&map, count).hair_error;
    let (few, more) = (error_of(2), error_of(5));
    assert!(more < few, "{few} {more}");
    for (target, most) in [(1.01 * few, 2), (1.01 * more, 5), (1e-9, 10)] {
        let fit = fit_to_error(&map, target, &settings, GO_ON).unwrap();
        let count = fit.lights.lights.len();
        assert!(
            count <= most && (fit.hair_error <= target || most == 10),
            "{count} {fit:?}"
        );
    }
}

#[test]
fn every_preset_is_light() {
    for name in PRESETS {
        let energy = match Preset::named(name).expect(name) {
            Preset::Sky(sky) => {
                let (map, report) = sky.map(32);
                assert_eq!(
                    report.nan_pixels + report.negative_pixels + report.infinite_pixels,
                    0
                );
                map.energy()
            }
            Preset::Lights(lights) => {
                LightSet::from_json(&lights.to_json(), Path::new(name)).expect(name);
                lights.energy()
            }
        };
        assert!(
            energy.is_finite() && energy.min_element() > 0.5 && energy.max_element() < 40.0,
            "{name} {energy}"
        );
    }
    assert_eq!(Preset::named("moon"), None);
}

#[test]
fn harmonics_of_a_smooth_map_are_the_map() {
    let (map, _) = EnvironmentMap::from_fn(128, 64, |w| {
        Vec3::new(1.0 + w.x, 2.0 - w.y * w.z, 1.5 + w.z * w.x)
    });
    let harmonics = Harmonics::of(&map, 4);
    assert!((harmonics.energy() / map.energy() - 1.0).abs().max_element() < 1e-6);
    let mean = Harmonics::of(&map, 0);
    let probe = HairProbe::new(
        &map,
        HairKernel {
            fibres: 30,
            ..HairKernel::default()
        },
    );
    let (full, least) = (
        probe.error_of(|w| harmonics.radiance(w)),
        probe.error_of(|w| mean.radiance(w)),
    );
    assert!(full < 1e-3 && least > 0.1, "{full} {least}");
}
