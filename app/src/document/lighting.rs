//! From light settings to the lights of a frame.

use std::{ops::ControlFlow, path::Path, sync::Arc, time::Instant};

use balayage_render::light::{
    EnvironmentMap, FitSettings, GradientSky, InputError, LightSet, MapReport, Preset, fit_lights,
};
use glam::Vec3;

use super::{
    builtin,
    project::{Environment, LightSettings},
};
use crate::Problem;

/// Rows of the map that stands for the built-in sky.
const SKY_ROWS: usize = 128;

/// An environment before rotation and exposure.
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

impl Lighting {
    /// Reads the environment of `settings`, whose paths `resolve` turns into files, and fits lights where it is a map.
    ///
    /// `progress` hears the share that is done; it stops the fit by breaking.
    ///
    /// # Errors
    /// Files that are refused; a fit that was stopped.
    pub fn load(
        settings: &LightSettings,
        resolve: impl Fn(&str) -> std::path::PathBuf,
        progress: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<Self, Problem> {
        let count = settings.light_count as usize;
        match &settings.environment {
            Environment::Constant(rgb) => Ok(Self::of_lights(LightSet::uniform(Vec3::from(*rgb)))),
            Environment::Lights(reference) => Ok(Self::of_lights(
                LightSet::read(&resolve(reference)).map_err(Problem::from)?,
            )),
            Environment::Preset(name) => match Preset::named(name) {
                Some(Preset::Lights(lights)) => Ok(Self::of_lights(lights)),
                Some(Preset::Sky(sky)) => Self::fitted(sky.map(SKY_ROWS), Path::new(name), count, progress),
                None => Err(Problem::at(
                    "light.environment.preset",
                    format!("there is no preset {name:?}"),
                    "choose another environment",
                )),
            },
            Environment::Sky => Self::fitted(
                GradientSky::default().map(SKY_ROWS),
                Path::new("sky"),
                count,
                progress,
            ),
            Environment::Map(reference) => {
                let file = resolve(reference);
                let read = match builtin::bytes(reference) {
                    Some(bytes) => EnvironmentMap::from_bytes(bytes, &file),
                    None => EnvironmentMap::read(&file),
                }
                .map_err(Problem::from)?;
                Self::fitted(read, &file, count, progress)
            }
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
        count: usize,
        progress: &dyn Fn(f64) -> ControlFlow<()>,
    ) -> Result<Self, Problem> {
        let settings = FitSettings {
            count,
            ..FitSettings::default()
        };
        let start = Instant::now();
        let lights = fit_lights(&map, &settings, progress)
            .map_err(|e| Problem::at("", e.to_string(), "start it again").in_file(name))?;
        Ok(Self {
            lights,
            map: Some(Arc::new(map)),
            fit_seconds: Some(start.elapsed().as_secs_f64()),
            warnings: map_warnings(&report, name),
        })
    }

    /// The lights of the frame: turned about the vertical axis and exposed.
    pub fn exposed(&self, settings: &LightSettings) -> LightSet {
        self.lights
            .rotated(settings.rotation_deg.to_radians())
            .exposed(settings.exposure_ev)
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
