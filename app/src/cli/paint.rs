//! `balayage paint`: strokes without a window.

use std::{collections::HashSet, path::PathBuf, time::Instant};

use clap::Args;
use serde_json::json;

use super::{CliError, Console, groom_options::GroomOptions};
use crate::{
    document::{Edit, Layer, MAX_PROJECT_BYTES, ProjectLock, files},
    paint::{DirtyRanges, StrokeFile},
};

#[derive(Args)]
pub(super) struct PaintArgs {
    /// Project (.json) or groom to paint.
    input: PathBuf,
    /// Strokes to apply.
    #[arg(long, value_name = "STROKES.json")]
    strokes: PathBuf,
    /// Project to write.
    #[arg(short, long, value_name = "OUT.json")]
    output: PathBuf,
    #[command(flatten)]
    groom: GroomOptions,
}

pub(super) fn run(args: &PaintArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let text = files::read_text(&args.strokes, MAX_PROJECT_BYTES)?;
    let strokes = StrokeFile::parse(&text).map_err(|p| p.in_file(&args.strokes))?;
    let mut document = super::open(&args.input, &args.groom, console)?;

    // Strokes of another groom are places in space all the same; the person decides whether that was meant.
    let hash = document.groom().content_hash();
    if let Some(expected) = strokes.groom.as_ref().filter(|expected| **expected != hash) {
        console.warn(&format!(
            "{}: groom: the strokes were recorded on another groom (content hash {expected}, this one has {hash}): \
             they are painted at their recorded places",
            args.strokes.display()
        ));
    }
    let known: HashSet<_> = document
        .project()
        .operations
        .iter()
        .map(|operation| operation.id.clone())
        .collect();
    for operation in strokes
        .operations
        .iter()
        .filter(|operation| known.contains(&operation.id))
    {
        console.warn(&format!(
            "{}: operation {} is in the project already and is painted once more",
            args.strokes.display(),
            operation.id
        ));
    }

    let start = Instant::now();
    let progress = console.progress(strokes.operations.len() as u64, "painting");
    let mut changed = DirtyRanges::none();
    let count = strokes.operations.len();
    for (i, operation) in strokes.operations.into_iter().enumerate() {
        if !document
            .project()
            .layers
            .iter()
            .any(|layer| layer.id == operation.layer)
        {
            let layer = Layer::new(&operation.layer, &operation.layer);
            document.apply(Edit::AddLayer(layer, usize::MAX))?;
        }
        changed.merge(&document.apply(Edit::Stroke(operation))?.points);
        progress.at(i as u64 + 1);
    }
    drop(progress);
    let milliseconds = start.elapsed().as_secs_f64() * 1e3;
    if let Some(holder) = ProjectLock::holder(&args.output) {
        console.warn(&format!(
            "{}: {holder} has the project open: its next save will ask before it overwrites this one",
            args.output.display()
        ));
    }
    document.save_as(&args.output)?;

    let points = changed.point_count();
    let value = json!({
        "output": args.output,
        "operations": count,
        "points_changed": points,
        "points": document.groom().point_count(),
        "groom": hash,
        "milliseconds": milliseconds,
    });
    let text = format!(
        "{}: {count} operations, {points} of {} points changed, {milliseconds:.1} ms",
        args.output.display(),
        document.groom().point_count()
    );
    Ok(console.result(value, &text)?)
}
