//! `balayage bench lights --sequence`: maps that change step by step, each fitted from the lights of the one before.
//!
//! The radiance of a fibre is linear in the map, so that two probes, one at each end, know it for every blend.

use std::ops::ControlFlow;
use std::time::Instant;

use balayage_render::light::{
    EnvironmentMap, FitSettings, HairKernel, HairProbe, LightSet, Work, fit_counted, fit_lights,
};
use glam::DVec3;

use super::report::{Cell, Report, Table};
use crate::cli::{CliError, Console};

/// Steps of a blend.
const STEPS: u32 = 24;
/// How far a map is turned without telling the fit, degrees.
const TURN_DEG: f64 = 3.0;

/// One step: what it cost and what it left.
struct Step {
    seconds: f64,
    work: Work,
    /// Relative error of every fibre, rgb.
    errors: Vec<DVec3>,
}

/// Turns every map and blends every map into the next; `count` lights.
pub(super) fn run(
    maps: &[(String, EnvironmentMap)],
    count: usize,
    seed: u64,
    console: &mut Console<'_>,
) -> Result<Report, CliError> {
    let settings = FitSettings {
        count,
        seed,
        ..FitSettings::default()
    };
    let blends: Vec<_> = maps
        .windows(2)
        .filter(|pair| (pair[0].1.width, pair[0].1.height) == (pair[1].1.width, pair[1].1.height))
        .collect();
    let progress = console.progress((maps.len() + blends.len()) as u64, "following");
    let mut table = Table::new(
        "lights_sequence",
        [
            "change",
            "ms, median",
            "ms, longest",
            "evaluations, most",
            "derivatives, most",
            "hair error, worst step",
            "flicker, RMS",
            "flicker, worst step",
        ],
    );
    let mut done = 0;
    let mut told = |table: &mut Table, name: String, steps: &[Step]| {
        table.row(row(name, steps));
        done += 1;
        progress.at(done);
    };
    for (name, map) in maps {
        told(
            &mut table,
            format!("{name} turned by {TURN_DEG} degrees"),
            &[turn(map, &settings)?],
        );
    }
    for pair in blends {
        let [(from, a), (to, b)] = pair else { continue };
        told(
            &mut table,
            format!("{from} to {to} in {STEPS} steps"),
            &blend(a, b, &settings)?,
        );
    }
    drop(progress);
    Ok(Report {
        name: "lights_sequence",
        notes: vec![
            format!(
                "{count} lights, seed {seed}, {} threads; reading excluded; the first lights come from a seed and are not timed",
                std::thread::available_parallelism().map_or(1, usize::from)
            ),
            "evaluations and derivatives: of all lights at all points, equal on every machine".to_owned(),
            "flicker: second difference of the relative error of a fibre's radiance over three steps, RMS over fibres".to_owned(),
        ],
        tables: vec![table],
        plots: Vec::new(),
    })
}

/// A map that is turned by a few columns.
fn turn(map: &EnvironmentMap, settings: &FitSettings) -> Result<Step, CliError> {
    let by = (TURN_DEG / 360.0 * map.width as f64).round() as usize;
    let pixel = |index: usize| map.pixels[index / map.width * map.width + (index + by) % map.width];
    let turned = EnvironmentMap {
        pixels: (0..map.pixels.len()).map(pixel).collect(),
        ..map.clone()
    };
    let probe = HairProbe::new(&turned, HairKernel::default());
    let (step, _) = follow(
        &turned,
        &first(map, settings)?,
        settings,
        &probe,
        probe.map_radiance(),
    )?;
    Ok(step)
}

/// Steps from one map to another.
fn blend(a: &EnvironmentMap, b: &EnvironmentMap, settings: &FitSettings) -> Result<Vec<Step>, CliError> {
    let probes = [a, b].map(|map| HairProbe::new(map, HairKernel::default()));
    let mut lights = first(a, settings)?;
    let mut steps = Vec::new();
    for number in 1..=STEPS {
        let share = f64::from(number) / f64::from(STEPS);
        let pixels = a.pixels.iter().zip(&b.pixels);
        let map = EnvironmentMap {
            pixels: pixels.map(|(a, b)| a.lerp(*b, share as f32)).collect(),
            ..a.clone()
        };
        let ends = probes[0].map_radiance().iter().zip(probes[1].map_radiance());
        let wanted: Vec<DVec3> = ends.map(|(a, b)| a.lerp(*b, share)).collect();
        let (step, next) = follow(&map, &lights, settings, &probes[0], &wanted)?;
        steps.push(step);
        lights = next;
    }
    Ok(steps)
}

/// The lights that a sequence starts with.
fn first(map: &EnvironmentMap, settings: &FitSettings) -> Result<LightSet, CliError> {
    fit_lights(map, settings, &|_| ControlFlow::Continue(())).map_err(|e| CliError::Input(e.to_string()))
}

/// Fits `map` from the lights before; `wanted` is the radiance of the probe's fibres under it.
fn follow(
    map: &EnvironmentMap,
    from: &LightSet,
    settings: &FitSettings,
    probe: &HairProbe<'_>,
    wanted: &[DVec3],
) -> Result<(Step, LightSet), CliError> {
    let settings = FitSettings {
        from: Some(from),
        ..*settings
    };
    let start = Instant::now();
    let (lights, work) = fit_counted(map, &settings, &|_| ControlFlow::Continue(()))
        .map_err(|e| CliError::Input(e.to_string()))?;
    let seconds = start.elapsed().as_secs_f64();
    let fitted = probe.radiance(&lights);
    let relative = |(fitted, wanted): (&DVec3, &DVec3)| (*fitted - *wanted) / wanted.length();
    let errors = fitted.iter().zip(wanted).map(relative).collect();
    let step = Step {
        seconds,
        work,
        errors,
    };
    Ok((step, lights))
}

fn row(name: String, steps: &[Step]) -> [Cell; 8] {
    let mut ms: Vec<f64> = steps.iter().map(|step| 1e3 * step.seconds).collect();
    ms.sort_by(f64::total_cmp);
    let most = |of: fn(&Work) -> usize| {
        let most = steps.iter().map(|step| of(&step.work)).max().unwrap_or(0);
        Cell::Count(most as u64)
    };
    let worst = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let hair: Vec<f64> = steps
        .iter()
        .map(|step| rms(step.errors.iter().copied()))
        .collect();
    let flicker: Vec<f64> = steps.windows(3).map(flicker).collect();
    let (overall, highest) = if flicker.is_empty() {
        (Cell::None, Cell::None)
    } else {
        let squares: f64 = flicker.iter().map(|value| value * value).sum();
        (
            (squares / flicker.len() as f64).sqrt().into(),
            worst(&flicker).into(),
        )
    };
    [
        name.into(),
        ms[ms.len() / 2].into(),
        worst(&ms).into(),
        most(|work| work.evaluations),
        most(|work| work.derivatives),
        worst(&hair).into(),
        overall,
        highest,
    ]
}

/// Second difference of the errors over three steps.
fn flicker(three: &[Step]) -> f64 {
    let errors = |step: usize| &three[step].errors;
    rms((0..errors(0).len()).map(|i| errors(0)[i] - 2.0 * errors(1)[i] + errors(2)[i]))
}

fn rms(values: impl ExactSizeIterator<Item = DVec3>) -> f64 {
    let count = values.len().max(1) as f64;
    (values.map(DVec3::length_squared).sum::<f64>() / count).sqrt()
}
