//! `balayage convert`: a groom or a project in another format.

use std::path::{Path, PathBuf};

use balayage_render::groom::{
    Groom, GroomReport, PaintedValues, UsdOptions, is_usd, read_groom, read_usd, write_painted_groom,
};
use clap::Args;
use serde_json::json;

use super::{CliError, Console};
use crate::document::{Document, files, material};

/// What the name of a sidecar file ends with.
const MATERIALS: &str = ".materials.json";

#[derive(Args)]
pub(super) struct ConvertArgs {
    /// Groom (.hair, .tfx, .usda, .usdc) or project (.json), whose painted channels go into .usda.
    input: PathBuf,
    /// File to write: .hair, .tfx or .usda; of a project also .materials.json, its parameters for other renderers.
    output: PathBuf,
    /// Metres per unit of the file; otherwise what it states, else guessed from its size.
    #[arg(long, value_name = "X")]
    metres_per_unit: Option<f32>,
    /// Time code of a USD file's samples; otherwise the value without a time, else the first sample.
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    usd_time: Option<f64>,
}

pub(super) fn run(args: &ConvertArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if args.output.to_string_lossy().ends_with(MATERIALS) {
        let document = super::open(&args.input, args.metres_per_unit, console)?;
        let sidecar = material::sidecar(&document);
        let text = format!("{sidecar:#}\n");
        files::write_atomic(&args.output, text.as_bytes())?;
        let value = json!({"output": args.output});
        return Ok(console.result(value, &args.output.display())?);
    }

    let (groom, painted, report) = read(args, console)?;
    if let Some(report) = report.as_ref().filter(|report| report.repairs() > 0) {
        console.warn(&format!("{}: {report}", args.input.display()));
    }
    let usd = is_usd(&args.output);
    if painted.is_some() && !usd {
        console.warn(&format!(
            "{}: the format holds no painted values; .usda does",
            args.output.display()
        ));
    }
    write_painted_groom(&args.output, &groom, painted.as_ref().filter(|_| usd))?;
    let (strands, points) = (groom.strand_count(), groom.point_count());
    let value = json!({"output": args.output, "groom": report, "strands": strands, "points": points, "hash": groom.content_hash()});
    let text = format!("{}: {strands} strands, {points} points", args.output.display());
    Ok(console.result(value, &text)?)
}

type Read = (Groom, Option<PaintedValues>, Option<GroomReport>);

/// The groom, its painted values and, of a groom file, what reading it found.
fn read(args: &ConvertArgs, console: &mut Console<'_>) -> Result<Read, CliError> {
    let is = |extension: &str| {
        Path::new(&args.input)
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(extension))
    };
    if is("json") {
        let document = super::open(&args.input, args.metres_per_unit, console)?;
        return Ok((
            document.groom_as_drawn()?.as_ref().clone(),
            Some(painted(&document)),
            None,
        ));
    }
    if is_usd(&args.input) {
        let options = UsdOptions {
            metres_per_unit: args.metres_per_unit,
            time: args.usd_time,
        };
        let usd = read_usd(&args.input, options)?;
        for note in &usd.loaded.report.notes {
            console.warn(&format!("{}: {note}", args.input.display()));
        }
        return Ok((usd.loaded.groom, usd.painted, Some(usd.loaded.report)));
    }
    let loaded = read_groom(&args.input, args.metres_per_unit)?;
    Ok((loaded.groom, None, Some(loaded.report)))
}

/// What a document's points are painted with.
fn painted(document: &Document) -> PaintedValues {
    PaintedValues {
        values: document.values().to_vec(),
        pigments: document.project().hair.pigments,
    }
}
