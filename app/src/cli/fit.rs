//! `balayage fit`: lights for an environment map.

use std::{ops::ControlFlow, path::PathBuf};

use balayage_render::{
    image::write_png,
    light::{EnvironmentMap, FitSettings, LightSet, Objective, fit, preview},
};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::{CliError, Console};
use crate::{Problem, document::map_warnings};

#[derive(Args)]
pub(super) struct FitArgs {
    /// Environment map (.hdr, .exr).
    map: PathBuf,
    /// Number of lights.
    #[arg(short = 'n', long = "count", default_value_t = 40, value_parser = clap::value_parser!(u32).range(1..=1024))]
    count: u32,
    /// Light list to write.
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

pub(super) fn run(args: &FitArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let (map, report) = EnvironmentMap::read(&args.map).map_err(Problem::from)?;
    for warning in map_warnings(&report, &args.map) {
        console.warn(&warning);
    }
    let from = args
        .from
        .as_deref()
        .map(LightSet::read)
        .transpose()
        .map_err(Problem::from)?;
    let settings = FitSettings {
        count: args.count as usize,
        seed: args.seed,
        objective: match args.objective {
            ObjectiveName::Relative => Objective::Relative,
            ObjectiveName::L2 => Objective::L2,
        },
        from: from.as_ref(),
    };
    let progress = console.progress(1000, "fitting lights");
    let fitted = fit(&map, &settings, &|done| {
        progress.at((done * 1000.0) as u64);
        ControlFlow::Continue(())
    })
    .map_err(|e| Problem::at("", e.to_string(), "start it again").in_file(&args.map))?;
    drop(progress);
    fitted.lights.write(&args.output).map_err(Problem::from)?;
    if let Some(path) = &args.preview {
        let picture = preview(&map, &fitted.lights);
        let rgba: Vec<u8> = picture
            .rgb
            .chunks_exact(3)
            .flat_map(|p| [p[0], p[1], p[2], 255])
            .collect();
        write_png(path, picture.width, picture.height, &rgba)?;
    }

    let value = json!({
        "output": args.output,
        "lights": fitted.lights.lights.len(),
        "hair_error": fitted.hair_error,
        "relative_l2": fitted.relative_l2,
        "energy_error": fitted.energy_error,
        "seconds": fitted.seconds,
    });
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let energy = fitted.energy_error.map(percent).join(", ");
    let text = format!(
        "{}: {} lights, hair error {}, relative L2 {}, energy error (r, g, b) {energy}, {:.2} s",
        args.output.display(),
        fitted.lights.lights.len(),
        percent(fitted.hair_error),
        percent(fitted.relative_l2),
        fitted.seconds
    );
    Ok(console.result(value, &text)?)
}
