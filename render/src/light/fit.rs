//! The fit of SRBF lights to an environment map: seed, mixture, refinement, report.

use std::ops::ControlFlow;
use std::time::Instant;

use glam::Vec3;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::bands::bands;
use super::cells::{cells, uniform_radiance};
use super::mixture::{self, Lobe};
use super::refine::{Effort, Work, refine};
use super::sight::{Sight, Target};
use super::srbf::solid_angle;
use super::{EnvironmentMap, HairKernel, HairProbe, LightSet, SrbfLight, luminance};

/// Most lights that one fit places; its time grows with the square of their number.
pub const MAX_LIGHTS: usize = 256;

/// Bandwidths that the fit gives, radians-like.
const BANDWIDTHS: std::ops::RangeInclusive<f64> = 0.02..=2.0;

/// Narrowest bandwidth in rows of the map: below it a light would fall between the pixels that it is held against.
const LEAST_ROWS_PER_LIGHT: f64 = 0.85;

/// Rows of the cells that the mixture is seeded in, and of those that it ends in.
const ROWS: [usize; 2] = [32, 64];

/// Lights from which on a fit looks at what smooth hair sees as well.
const LEAST_FOR_SMOOTH_HAIR: usize = 16;

/// Steps of the mixture from a seed and from given lights, at the two resolutions.
const COLD_STEPS: [usize; 2] = [20, 3];
const WARM_STEPS: [usize; 2] = [0, 0];

/// Refinement from a seed and from given lights; a changed map may have new suns, so that both can place lights anew. In a step
/// of a sequence a light jumps only where that pays well: every jump is seen as a flicker.
const COLD_REFINEMENT: Effort = Effort {
    before: 8,
    swaps: 16,
    per_swap: 3,
    after: 14,
    rounds: 1,
    worth_a_swap: 1.0,
};
const WARM_REFINEMENT: Effort = Effort {
    before: 3,
    swaps: 2,
    per_swap: 2,
    after: 3,
    rounds: 4,
    worth_a_swap: 0.8,
};

/// What the fit minimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Objective {
    /// The difference as hair sees it: blurred, relative to the local brightness.
    #[default]
    Relative,
    /// Plain least squares of radiance (seen at 0.06 radians), for comparison: suns of a few pixels dominate it.
    L2,
}

/// How to fit.
#[derive(Clone, Copy, Debug)]
pub struct FitSettings<'a> {
    /// How many lights, 1 to [`MAX_LIGHTS`]; lights that come out black are left out.
    pub count: usize,
    /// Seed of the starting centres; the same seed gives the same lights on any number of threads.
    pub seed: u64,
    /// What is minimised.
    pub objective: Objective,
    /// Lights of a similar map to start from: much faster. Those of radiance zero are dropped, missing ones are added.
    pub from: Option<&'a LightSet>,
}

impl Default for FitSettings<'_> {
    /// 40 lights from a seed.
    fn default() -> Self {
        Self {
            count: 40,
            seed: 0,
            objective: Objective::Relative,
            from: None,
        }
    }
}

/// Lights and how well they stand for the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The lights, brightest first; a uniform map becomes `constant` and no lights.
    pub lights: LightSet,
    /// RMS relative error of the radiance of random fibres, see [`HairProbe::error`].
    pub hair_error: f64,
    /// Root of the integral of the squared difference over that of the squared map.
    pub relative_l2: f64,
    /// Energy of the lights over that of the map, minus 1, per channel; 0 where both are black.
    pub energy_error: [f64; 3],
    /// How long the fit took, without the report.
    pub seconds: f64,
}

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// The progress callback asked to stop.
    #[error("the fit was cancelled")]
    Cancelled,
    /// The settings ask for no light or for too many.
    #[error("light count {0} is not in 1..={MAX_LIGHTS}; ask for 5 to 80, 40 is usual")]
    Count(usize),
}

/// Told the share done, 0 to 1; `Break` cancels. Called every few hundredths of a second at least.
pub type Progress<'a> = &'a dyn Fn(f64) -> ControlFlow<()>;

/// Fits lights to a map and reports the errors that remain.
///
/// # Errors
/// [`FitError`] where the count is out of range or `progress` cancels.
pub fn fit(map: &EnvironmentMap, settings: &FitSettings, progress: Progress) -> Result<Fit, FitError> {
    let start = Instant::now();
    let share = |from: f64, to: f64| move |done: f64| progress(from + (to - from) * done);
    let lights = fit_lights(map, settings, &share(0.0, 0.4))?;
    let seconds = start.elapsed().as_secs_f64();

    let probe =
        HairProbe::with_progress(map, HairKernel::default(), &share(0.4, 0.65)).ok_or(FitError::Cancelled)?;
    let hair_error = probe
        .error_with_progress(&lights, &share(0.65, 0.9))
        .ok_or(FitError::Cancelled)?;
    reported(map, lights, hair_error, seconds, &share(0.9, 1.0))
}

/// Counts that [`fit_to_error`] tries.
const LADDER: [usize; 15] = [1, 2, 3, 5, 7, 10, 14, 20, 28, 40, 56, 80, 112, 160, 224];

/// Fits as few lights as reach `target` (hair error, a fraction), at most `settings.count`; the report says whether they do.
///
/// Counts rise in steps of about the square root of two, so that an error is met with at most a third more lights than needed.
///
/// # Errors
/// As [`fit`].
pub fn fit_to_error(
    map: &EnvironmentMap,
    target: f64,
    settings: &FitSettings,
    progress: Progress,
) -> Result<Fit, FitError> {
    let most = settings.count;
    let rungs: Vec<usize> = LADDER
        .into_iter()
        .filter(|count| *count < most)
        .chain([most])
        .collect();
    // A fit's time grows with its count; each has half of the way that is left per rung.
    let share = |from: f64, to: f64| move |done: f64| progress(from + (to - from) * done);
    let probe =
        HairProbe::with_progress(map, HairKernel::default(), &share(0.0, 0.2)).ok_or(FitError::Cancelled)?;
    let (mut seconds, mut done) = (0.0, 0.2);
    for count in rungs {
        let end = done + 0.5 * (1.0 - done);
        let start = Instant::now();
        let lights = fit_lights(
            map,
            &FitSettings { count, ..*settings },
            &share(done, 0.5 * (done + end)),
        )?;
        seconds += start.elapsed().as_secs_f64();
        let hair_error = probe
            .error_with_progress(&lights, &share(0.5 * (done + end), end))
            .ok_or(FitError::Cancelled)?;
        if hair_error <= target || count == most {
            return reported(map, lights, hair_error, seconds, &share(end, 1.0));
        }
        done = end;
    }
    Err(FitError::Count(most))
}

/// The report of a fit whose hair error is known.
fn reported(
    map: &EnvironmentMap,
    lights: LightSet,
    hair_error: f64,
    seconds: f64,
    progress: Progress,
) -> Result<Fit, FitError> {
    let relative_l2 = relative_l2(map, &lights, progress).ok_or(FitError::Cancelled)?;
    let (fitted, wanted) = (lights.energy().to_array(), map.energy().to_array());
    let energy_error = std::array::from_fn(|c| {
        if fitted[c] == wanted[c] {
            0.0
        } else {
            fitted[c] / wanted[c] - 1.0
        }
    });
    Ok(Fit {
        lights,
        hair_error,
        relative_l2,
        energy_error,
        seconds,
    })
}

/// Fits lights to a map without the report, which takes longer than the fit: what an animated environment calls per step, from the
/// lights of the step before.
///
/// # Errors
/// As [`fit`].
pub fn fit_lights(
    map: &EnvironmentMap,
    settings: &FitSettings,
    progress: Progress,
) -> Result<LightSet, FitError> {
    let _scope = tracing::info_span!("fit lights").entered();
    fit_counted(map, settings, progress).map(|(lights, _)| lights)
}

/// As [`fit_lights`], with the work it took.
///
/// # Errors
/// As [`fit`].
pub fn fit_counted(
    map: &EnvironmentMap,
    settings: &FitSettings,
    progress: Progress,
) -> Result<(LightSet, Work), FitError> {
    if !(1..=MAX_LIGHTS).contains(&settings.count) {
        return Err(FitError::Count(settings.count));
    }
    if let Some(radiance) = uniform_radiance(map) {
        return Ok((LightSet::uniform(radiance), Work::default()));
    }
    let go_on = |done: f64| {
        if progress(done).is_break() {
            Err(FitError::Cancelled)
        } else {
            Ok(())
        }
    };
    go_on(0.0)?;
    let map = map.at_least(2 * ROWS[1], ROWS[1]);
    let coarse = cells(&map, ROWS[0], || go_on(0.0))?;
    let fine = cells(&map, ROWS[1], || go_on(0.0))?;

    let warm = settings
        .from
        .map(|lights| lobes(lights, settings.count))
        .filter(|lobes| !lobes.is_empty());
    let (steps, refinement) = if warm.is_some() {
        (WARM_STEPS, WARM_REFINEMENT)
    } else {
        (COLD_STEPS, COLD_REFINEMENT)
    };
    // What smooth hair sees costs several times more: a step of a sequence goes without, and so do lights too few for it.
    let sights: &[Sight] = match (settings.objective, &warm) {
        (Objective::Relative, None) if settings.count >= LEAST_FOR_SMOOTH_HAIR => &Sight::ALL_HAIR,
        (Objective::Relative, _) => &[Sight::HAIR],
        (Objective::L2, _) => &[Sight::L2],
    };
    let mut random = Pcg64Mcg::seed_from_u64(settings.seed);
    let narrowest = BANDWIDTHS
        .start()
        .max(LEAST_ROWS_PER_LIGHT * std::f64::consts::PI / map.height as f64);
    let range = (concentration_of(*BANDWIDTHS.end()), concentration_of(narrowest));
    let mut lobes = mixture::seed(
        &coarse,
        warm.unwrap_or_default(),
        settings.count,
        range,
        &mut random,
    );
    for (cells, steps) in [(&coarse, steps[0]), (&fine, steps[1])] {
        for _ in 0..steps {
            mixture::step(cells, &mut lobes, range);
            go_on(0.05)?;
        }
    }

    go_on(0.1)?;
    let mut work = Work::default();
    if let Some(target) = Target::new(&fine, sights) {
        (lobes, work) = refine(&target, lobes, range, refinement, |done| go_on(0.1 + 0.9 * done))?;
    }
    Ok((light_set(&lobes), work))
}

/// kappa = 2 / lambda^2.
fn concentration_of(bandwidth: f64) -> f64 {
    2.0 / (bandwidth * bandwidth)
}

/// The brightest `count` lights that are lit, as lobes.
fn lobes(lights: &LightSet, count: usize) -> Vec<Lobe> {
    let lobe = |light: &SrbfLight| Lobe {
        direction: light.direction.as_dvec3().normalize(),
        kappa: concentration_of(f64::from(light.bandwidth)),
        energy: light.energy(),
        mass: f64::from(luminance(light.radiance)) * light.solid_angle(),
    };
    let mut lobes: Vec<Lobe> = lights
        .lights
        .iter()
        .map(lobe)
        .filter(|lobe| lobe.mass > 0.0)
        .collect();
    lobes.sort_by(|a, b| b.mass.total_cmp(&a.mass));
    lobes.truncate(count);
    lobes
}

/// The lobes that are lit as lights, brightest first.
fn light_set(lobes: &[Lobe]) -> LightSet {
    let light = |lobe: &Lobe| {
        let bandwidth = (2.0 / lobe.kappa).sqrt();
        SrbfLight {
            direction: lobe.direction.as_vec3().normalize(),
            bandwidth: bandwidth as f32,
            radiance: (lobe.energy / solid_angle(bandwidth)).as_vec3(),
        }
    };
    let mut lights: Vec<SrbfLight> = lobes
        .iter()
        .map(light)
        .filter(|light| light.radiance != Vec3::ZERO)
        .collect();
    lights.sort_by(|a, b| luminance(b.energy().as_vec3()).total_cmp(&luminance(a.energy().as_vec3())));
    LightSet {
        lights,
        constant: Vec3::ZERO,
    }
}

/// Root of the integral of the squared difference between lights and map over that of the squared map; 0 where both are black, none
/// where `progress` cancels.
fn relative_l2(map: &EnvironmentMap, lights: &LightSet, progress: Progress) -> Option<f64> {
    let (mut difference, mut norm) = (0.0, 0.0);
    for rows in bands(map.height, map.width * lights.lights.len()) {
        progress(rows.start as f64 / map.height as f64).continue_value()?;
        let fitted = map.grid_rows(rows.clone(), |w| lights.radiance(w));
        for (index, fitted) in (rows.start * map.width..).zip(&fitted) {
            let (wanted, solid_angle) = (map.pixels[index], map.pixel_solid_angle(index / map.width));
            difference += (fitted.as_dvec3() - wanted.as_dvec3()).length_squared() * solid_angle;
            norm += wanted.as_dvec3().length_squared() * solid_angle;
        }
    }
    Some(if difference == 0.0 {
        0.0
    } else {
        (difference / norm).sqrt()
    })
}
