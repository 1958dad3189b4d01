//! The fit from a seed: what it finds, how good it is, that it is the same on any machine.

use balayage_render::light::{
    EnvironmentMap, Fit, FitError, FitSettings, GradientSky, HairKernel, HairProbe, LightSet, Objective,
    SrbfLight, fit, fit_lights, fit_to_error,
};
use balayage_tests::test_data;
use glam::Vec3;

use super::{GO_ON, fitted, map_of, sample, three_lights};

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

/// Averaging a wide map for the hair error keeps its energy and what hair sees of it.
#[test]
fn hair_sees_a_wide_map_as_a_narrow_one() {
    let lights = three_lights();
    let map_of_width = |width: usize| EnvironmentMap::from_fn(width, width / 2, |w| lights.radiance(w)).0;
    let kernel = HairKernel {
        fibres: 12,
        ..HairKernel::default()
    };
    let (wide, narrow) = (map_of_width(2048), map_of_width(1024));
    let [wide, narrow] = [&wide, &narrow].map(|map| HairProbe::new(map, kernel).map_radiance().to_vec());
    for (wide, narrow) in wide.iter().zip(&narrow) {
        assert!(
            (*wide - *narrow).length() < 1e-4 * narrow.length(),
            "{wide} {narrow}"
        );
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
