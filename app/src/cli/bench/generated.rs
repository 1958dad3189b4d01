//! Hair of any number of strands, to measure with.

use std::path::{Path, PathBuf};

use balayage_render::groom::{GeneratorSettings, HairStyle, generate, write_groom};

use crate::cli::groom_options::GroomOptions;
use crate::cli::{CliError, Console, open};
use crate::document::Document;

/// Points of a strand.
const POINTS: u32 = 16;

/// Straight hair of `strands` strands on the built-in head, as a file in `folder`.
pub(super) fn write_generated(folder: &Path, strands: u32) -> Result<PathBuf, CliError> {
    let head = Document::sample()?.document.load_head()?;
    let head =
        head.ok_or_else(|| CliError::Input("the built-in sample has no head: reinstall".to_owned()))?;
    std::fs::create_dir_all(folder)
        .map_err(|e| CliError::Input(format!("{}: {e}; name another folder", folder.display())))?;
    let path = folder.join(format!("generated-{strands}.hair"));
    let settings = GeneratorSettings {
        strand_count: strands,
        points_per_strand: POINTS,
        ..GeneratorSettings::new(HairStyle::Straight)
    };
    write_groom(&path, &generate(&settings, &head)?)?;
    Ok(path)
}

/// A document of it.
pub(super) fn generated(
    folder: &Path,
    strands: u32,
    console: &mut Console<'_>,
) -> Result<Document, CliError> {
    let path = write_generated(folder, strands)?;
    open(&path, &GroomOptions::default(), console)
}
