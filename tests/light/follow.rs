//! Fits from the lights of a similar map: as good as from a seed, without flicker.

use balayage_render::light::{
    EnvironmentMap, FitSettings, HairKernel, HairProbe, LightSet, Work, fit_counted, fit_lights,
};
use glam::Vec3;

use super::{GO_ON, sample};

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
