//! `balayage fit`: lights for an environment map.

use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
};

use balayage_render::{
    image::write_png,
    light::{
        EnvironmentMap, Fit, FitSettings, LightSet, MAX_LIGHTS, Objective, fit, fit_to_error, frames, preview,
    },
};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::{CliError, Console};
use crate::{Problem, document::map_warnings};

#[derive(Args)]
pub(super) struct FitArgs {
    /// Environment map (.hdr, .exr), or a folder of them: a sequence, each frame fitted from the lights of the one before.
    map: PathBuf,
    /// Number of lights, with --target-error the most of them [default: 40, with --target-error 80].
    #[arg(short = 'n', long = "count", value_parser = clap::value_parser!(u32).range(1..=MAX_LIGHTS as i64))]
    count: Option<u32>,
    /// Hair error to reach with as few lights as it takes, percent.
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    target_error: Option<f64>,
    /// Light list to write; for a sequence a folder, one list a frame.
    #[arg(short, long, value_name = "LIGHTS.json")]
    output: PathBuf,
    /// Picture to write: map, reconstruction and difference below each other.
    #[arg(long, value_name = "P.png")]
    preview: Option<PathBuf>,
    /// Lights to start from.
    #[arg(long, value_name = "LIGHTS.json")]
    from: Option<PathBuf>,
    /// What is minimised.
    #[arg(long, value_enum, default_value_t = ObjectiveName::Relative)]
    objective: ObjectiveName,
    /// Seed of the random choices.
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

#[derive(Clone, Copy, ValueEnum)]
enum ObjectiveName {
    /// The residual relative to local brightness, as hair sees it.
    Relative,
    /// Plain least squares, for comparison.
    L2,
}

/// A number of percent above zero, as a fraction.
fn percent(text: &str) -> Result<f64, String> {
    let percent: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if percent.is_finite() && percent > 0.0 {
        Ok(percent / 100.0)
    } else {
        Err("give percent above 0, for example 0.5".to_owned())
    }
}

pub(super) fn run(args: &FitArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let from = args
        .from
        .as_deref()
        .map(LightSet::read)
        .transpose()
        .map_err(Problem::from)?;
    if args.map.is_dir() {
        return run_sequence(args, from, console);
    }
    let (map, fitted) = fitted(args, &args.map, from.as_ref(), console)?;
    if let Some(target) = args.target_error.filter(|target| fitted.hair_error > *target) {
        console.warn(&format!(
            "hair error {} is above {} with {} lights; allow more with -n",
            shown(fitted.hair_error),
            shown(target),
            fitted.lights.lights.len()
        ));
    }
    fitted.lights.write(&args.output).map_err(Problem::from)?;
    if let Some(path) = &args.preview {
        write_preview(path, &map, &fitted.lights)?;
    }
    report(&args.output, &fitted, console)
}

/// Fits a folder of maps frame after frame and writes as many light lists.
fn run_sequence(args: &FitArgs, from: Option<LightSet>, console: &mut Console<'_>) -> Result<(), CliError> {
    if args.preview.is_some() {
        let reason = "--preview shows one map; give a file instead of a folder";
        return Err(CliError::Usage(reason.to_owned()));
    }
    let folder = &args.output;
    std::fs::create_dir_all(folder).map_err(|error| {
        let remedy = "choose a folder that can be written";
        Problem::at("whole folder", error.to_string(), remedy).in_file(folder)
    })?;
    let mut from = from;
    for path in frames(&args.map).map_err(Problem::from)? {
        let (_, fitted) = fitted(args, &path, from.as_ref(), console)?;
        let name = path.file_name().unwrap_or(path.as_os_str());
        let output = folder.join(name).with_extension("json");
        fitted.lights.write(&output).map_err(Problem::from)?;
        report(&output, &fitted, console)?;
        from = Some(fitted.lights);
    }
    Ok(())
}

/// Reads and fits one map.
fn fitted(
    args: &FitArgs,
    path: &Path,
    from: Option<&LightSet>,
    console: &mut Console<'_>,
) -> Result<(EnvironmentMap, Fit), CliError> {
    let (map, report) = EnvironmentMap::read(path).map_err(Problem::from)?;
    for warning in map_warnings(&report, path) {
        console.warn(&warning);
    }
    let usual = if args.target_error.is_some() { 80 } else { 40 };
    let settings = FitSettings {
        count: args.count.unwrap_or(usual) as usize,
        seed: args.seed,
        objective: match args.objective {
            ObjectiveName::Relative => Objective::Relative,
            ObjectiveName::L2 => Objective::L2,
        },
        from,
    };
    let progress = console.progress(1000, "fitting lights");
    let told = |done: f64| {
        progress.at((done * 1000.0) as u64);
        ControlFlow::Continue(())
    };
    let fitted = match args.target_error {
        Some(target) => fit_to_error(&map, target, &settings, &told),
        None => fit(&map, &settings, &told),
    }
    .map_err(|e| Problem::at("", e.to_string(), "start it again").in_file(path))?;
    Ok((map, fitted))
}

fn write_preview(path: &Path, map: &EnvironmentMap, lights: &LightSet) -> Result<(), CliError> {
    let picture = preview(map, lights);
    let rgba: Vec<u8> = picture
        .rgb
        .chunks_exact(3)
        .flat_map(|p| [p[0], p[1], p[2], 255])
        .collect();
    Ok(write_png(path, picture.width, picture.height, &rgba)?)
}

fn shown(fraction: f64) -> String {
    format!("{:.2} %", 100.0 * fraction)
}

/// Says how good a fit is.
fn report(output: &Path, fitted: &Fit, console: &mut Console<'_>) -> Result<(), CliError> {
    let value = json!({
        "output": output,
        "lights": fitted.lights.lights.len(),
        "hair_error": fitted.hair_error,
        "relative_l2": fitted.relative_l2,
        "energy_error": fitted.energy_error,
        "seconds": fitted.seconds,
    });
    let text = format!(
        "{}: {} lights, hair error {}, relative L2 {}, energy error (r, g, b) {}, {:.3} s",
        output.display(),
        fitted.lights.lights.len(),
        shown(fitted.hair_error),
        shown(fitted.relative_l2),
        fitted.energy_error.map(shown).join(", "),
        fitted.seconds
    );
    Ok(console.result(value, &text)?)
}
