//! SRBF lights: laws of their integral and rotation, presets, harmonics, the preview.

mod cancel;
mod file;
mod fit;
mod follow;

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

use balayage_render::light::{
    EnvironmentMap, Fit, FitSettings, GradientSky, HairKernel, HairProbe, Harmonics, LightSet, PRESETS,
    Preset, SrbfLight, fit, preview,
};
use balayage_tests::{POISON, random, repository};
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
