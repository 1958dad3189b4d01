//! `balayage convert`: a groom or a project in another format.

use std::path::{Path, PathBuf};

use balayage_render::groom::{
    Groom, GroomReport, PaintedValues, is_usd, read_painted_groom, write_painted_groom,
};
use clap::Args;
use serde_json::json;

use super::{CliError, Console, groom_options::GroomOptions};
use crate::document::{files, material};

/// What the name of a sidecar file ends with.
const MATERIALS: &str = ".materials.json";

#[derive(Args)]
pub(super) struct ConvertArgs {
    /// Groom (.hair, .tfx, .usda, .usdc, .abc) or project (.json), whose painted channels go into .usda.
    input: PathBuf,
    /// File to write: .hair, .tfx or .usda; of a project also .materials.json, its parameters for other renderers.
    output: PathBuf,
    #[command(flatten)]
    groom: GroomOptions,
}

pub(super) fn run(args: &ConvertArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if args.output.to_string_lossy().ends_with(MATERIALS) {
        let document = super::open(&args.input, &args.groom, console)?;
        let sidecar = material::sidecar(&document);
        let text = format!("{sidecar:#}\n");
        files::write_atomic(&args.output, text.as_bytes())?;
        let value = json!({"output": args.output});
        return Ok(console.result(value, &args.output.display())?);
    }

    let (groom, painted, report) = read(args, console)?;
    if let Some(report) = &report {
        super::warn_of(report, &args.input, console);
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
        let document = super::open(&args.input, &args.groom, console)?;
        return Ok((
            document.groom_as_drawn()?.as_ref().clone(),
            Some(document.painted()),
            None,
        ));
    }
    let (loaded, painted) = read_painted_groom(&args.input, args.groom.read())?;
    Ok((loaded.groom, painted, Some(loaded.report)))
}
