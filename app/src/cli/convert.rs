//! `balayage convert`: a groom in another format.

use std::path::PathBuf;

use balayage_render::groom::{read_groom, write_groom};
use clap::Args;
use serde_json::json;

use super::{CliError, Console};

#[derive(Args)]
pub(super) struct ConvertArgs {
    /// Groom to read (.hair, .tfx).
    input: PathBuf,
    /// Groom to write; the extension chooses the format.
    output: PathBuf,
    /// Metres per unit of the file; otherwise guessed from its size.
    #[arg(long, value_name = "X")]
    metres_per_unit: Option<f32>,
}

pub(super) fn run(args: &ConvertArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let loaded = read_groom(&args.input, args.metres_per_unit)?;
    if loaded.report.repairs() > 0 {
        console.warn(&format!("{}: {}", args.input.display(), loaded.report));
    }
    write_groom(&args.output, &loaded.groom)?;
    let value = json!({"output": args.output, "groom": loaded.report, "hash": loaded.groom.content_hash()});
    let text = format!(
        "{}: {} strands, {} points",
        args.output.display(),
        loaded.report.strands,
        loaded.report.points
    );
    Ok(console.result(value, &text)?)
}
