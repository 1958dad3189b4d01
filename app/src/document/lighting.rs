//! From light settings to the lights of a frame.

use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use balayage_render::light::{
    EnvironmentMap, FitSettings, GradientSky, HairKernel, HairProbe, InputError, LightSet, MapReport,
    Picture, Preset, fit_lights, fit_to_error, panorama,
};
use glam::Vec3;

use super::{
    Document, builtin,
    project::{Environment, LightSettings, Project},
};
use crate::Problem;

/// Rows of the map that stands for the built-in sky.
const SKY_ROWS: usize = 128;

/// Columns of the picture of an environment.
const PANORAMA_WIDTH: usize = 384;

/// An environment before the hand's edits, rotation, exposure and tint.
#[derive(Clone, Debug)]
pub struct Lighting {
    /// The lights as fitted or read.
    pub lights: LightSet,
    /// The map behind them, where there is one.
    pub map: Option<Arc<EnvironmentMap>>,
    /// How long the fit took, where there was one.
    pub fit_seconds: Option<f64>,
    /// What a person should know about the files.
    pub warnings: Vec<String>,
}

/// What is asked of a fit.
struct Wanted<'a> {
    settings: FitSettings<'a>,
    /// Hair error to reach with as few lights as it takes.
    target: Option<f64>,
}

/// How well fitted lights stand for their map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitReport {
    /// RMS relative error of the radiance of random fibres.
    pub hair_error: f64,
    /// Energy of the lights over that of the map, minus 1, per channel.
    pub energy_error: [f64; 3],
}

impl Lighting {
    /// Reads the environment of `project`, whose paths `resolve` turns into files, and fits lights where it is a map.
    ///
    /// `from` are the lights of a similar map to start from: much faster. `progress` hears the share that is done; it stops the
    /// fit by breaking.
    ///
    /// # Errors
    /// Files that are refused; a fit that was stopped.
    pub fn load(
        project: &Project,
        from: Option<&LightSet>,
        resolve: impl Fn(&str) -> PathBuf,
        progress: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<Self, Problem> {
        // Within a sequence the first map decides how many lights reach the target: a count that changed would flicker.
        let most = project.light.light_count as usize;
        let (count, target) = match (project.light.target_error, from) {
            (Some(_), Some(from)) => (from.lights.len().clamp(1, most), None),
            (target, _) => (most, target.map(f64::from)),
        };
        let settings = FitSettings {
            count,
            from,
            ..FitSettings::default()
        };
        let fit = Wanted { settings, target };
        let of_file = |reference: &str| {
            let file = resolve(reference);
            let read = match builtin::bytes(reference) {
                Some(bytes) => EnvironmentMap::from_bytes(bytes, &file),
                None => EnvironmentMap::read(&file),
            };
            Self::fitted(read.map_err(Problem::from)?, &file, &fit, progress)
        };
        match &project.light.environment {
            Environment::Constant(rgb) => Ok(Self::of_lights(LightSet::uniform(Vec3::from(*rgb)))),
            Environment::Lights(reference) => Ok(Self::of_lights(
                LightSet::read(&resolve(reference)).map_err(Problem::from)?,
            )),
            Environment::Preset(name) => match Preset::named(name) {
                Some(Preset::Lights(lights)) => Ok(Self::of_lights(lights)),
                Some(Preset::Sky(sky)) => Self::fitted(sky.map(SKY_ROWS), Path::new(name), &fit, progress),
                None => Err(Problem::at(
                    "light.environment.preset",
                    format!("there is no preset {name:?}"),
                    "choose another environment",
                )),
            },
            Environment::Sky => Self::fitted(
                GradientSky::default().map(SKY_ROWS),
                Path::new("sky"),
                &fit,
                progress,
            ),
            Environment::Map(reference) => of_file(reference),
            Environment::Sequence(sequence) => of_file(&sequence.maps[sequence.index(project.frame)]),
        }
    }

    fn of_lights(lights: LightSet) -> Self {
        Self {
            lights,
            map: None,
            fit_seconds: None,
            warnings: Vec::new(),
        }
    }

    fn fitted(
        (map, report): (EnvironmentMap, MapReport),
        name: &Path,
        fit: &Wanted<'_>,
        progress: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<Self, Problem> {
        let start = Instant::now();
        let lights = match fit.target {
            Some(target) => fit_to_error(&map, target, &fit.settings, progress).map(|fit| fit.lights),
            None => fit_lights(&map, &fit.settings, progress),
        }
        .map_err(|e| Problem::at("", e.to_string(), "start it again").in_file(name))?;
        Ok(Self {
            lights,
            map: Some(Arc::new(map)),
            fit_seconds: Some(start.elapsed().as_secs_f64()),
            warnings: map_warnings(&report, name),
        })
    }

    /// The lights of the frame: with the hand's edits, turned about the vertical axis, exposed and tinted.
    pub fn exposed(&self, settings: &LightSettings) -> LightSet {
        settings
            .edited(&self.lights)
            .rotated(settings.rotation_deg.to_radians())
            .scaled(settings.factor())
    }

    /// The environment to be looked at: its map, or where there is none what the lights amount to.
    pub fn panorama(&self) -> Picture {
        match &self.map {
            Some(map) => panorama(map, PANORAMA_WIDTH),
            None => {
                let radiance = |w: Vec3| self.lights.radiance(w);
                let (map, _) = EnvironmentMap::from_fn(PANORAMA_WIDTH, PANORAMA_WIDTH / 2, radiance);
                panorama(&map, PANORAMA_WIDTH)
            }
        }
    }

    /// Measures what the fit left out; none without a map, and where `progress` breaks.
    pub fn report(&self, progress: &dyn Fn(f64) -> ControlFlow<()>) -> Option<FitReport> {
        let map = self.map.as_deref()?;
        let probe = HairProbe::with_progress(map, HairKernel::default(), &|done| progress(0.5 * done))?;
        let hair_error = probe.error_with_progress(&self.lights, &|done| progress(0.5 + 0.5 * done))?;
        let (fitted, wanted) = (self.lights.energy().to_array(), map.energy().to_array());
        let error = |c: usize| {
            if fitted[c] == wanted[c] {
                0.0
            } else {
                fitted[c] / wanted[c] - 1.0
            }
        };
        Some(FitReport {
            hair_error,
            energy_error: std::array::from_fn(error),
        })
    }
}

impl LightSettings {
    /// Exposure and tint as one factor on every radiance.
    pub fn factor(&self) -> Vec3 {
        Vec3::from(self.tint) * self.exposure_ev.exp2()
    }

    /// True where both lead to the same fitted lights: rotation, exposure, tint, rate and hand-made lights need no new fit.
    pub fn same_fit(&self, other: &Self) -> bool {
        let same_environment = match (&self.environment, &other.environment) {
            (Environment::Sequence(a), Environment::Sequence(b)) => a.maps == b.maps,
            (a, b) => a == b,
        };
        same_environment && (self.light_count, self.target_error) == (other.light_count, other.target_error)
    }
}

impl Document {
    /// The files that the light reads; what is inside the program is no file.
    pub fn light_files(&self) -> Vec<PathBuf> {
        let references = match &self.project.light.environment {
            Environment::Map(path) | Environment::Lights(path) => std::slice::from_ref(path),
            Environment::Sequence(sequence) => sequence.maps.as_slice(),
            Environment::Sky | Environment::Preset(_) | Environment::Constant(_) => &[],
        };
        references
            .iter()
            .filter(|reference| builtin::bytes(reference).is_none())
            .map(|reference| self.resolve(reference))
            .collect()
    }
}

/// What was repaired in a map, one sentence each.
pub fn map_warnings(report: &MapReport, file: &Path) -> Vec<String> {
    let counts = [
        (report.nan_pixels, "NaN pixels set to 0"),
        (
            report.infinite_pixels,
            "infinite pixels set to the largest finite value",
        ),
        (report.negative_pixels, "negative pixels set to 0"),
    ];
    counts
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{}: {count} {what}", file.display()))
        .chain(
            report
                .warnings
                .iter()
                .map(|warning| format!("{}: {warning}", file.display())),
        )
        .collect()
}

impl From<InputError> for Problem {
    fn from(error: InputError) -> Self {
        Self::at(error.place, error.reason, error.remedy).in_file(&error.file)
    }
}
