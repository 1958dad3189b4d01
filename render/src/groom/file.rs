//! Groom files by name.

use std::fs;
use std::path::Path;

use super::{Groom, GroomError, GroomReport, hair_bytes, parse_hair, parse_tfx, tfx_bytes};

/// A groom and what reading it found.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedGroom {
    /// The sound strands.
    pub groom: Groom,
    /// What was kept, dropped and repaired.
    pub report: GroomReport,
}

/// The formats we read and write, told apart by extension.
#[derive(Clone, Copy)]
enum Format {
    Hair,
    Tfx,
}

impl Format {
    fn of(path: &Path) -> Result<Self, GroomError> {
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default()
            .to_ascii_lowercase();
        match extension.as_str() {
            "hair" => Ok(Self::Hair),
            "tfx" => Ok(Self::Tfx),
            _ => Err(GroomError::refused(
                path.display().to_string(),
                format!("\"{extension}\" is not the extension of a groom"),
                "use .hair or .tfx",
            )),
        }
    }
}

/// Reads a groom; the extension chooses the format and the file's first bytes must agree.
///
/// `metres_per_unit` overrides what the file states and what its size suggests. Holds the file's bytes, 16 bytes per point and 4 per strand
/// at most; counts in the file are checked against its size before they are believed.
///
/// # Errors
/// [`GroomError`] names the file, the place, the reason and the remedy.
pub fn read_groom(path: impl AsRef<Path>, metres_per_unit: Option<f32>) -> Result<LoadedGroom, GroomError> {
    let path = path.as_ref();
    let format = Format::of(path)?;
    let bytes = fs::read(path).map_err(|source| GroomError::Io {
        path: path.into(),
        action: "read",
        source,
    })?;
    let name = path.display().to_string();
    match format {
        Format::Hair => parse_hair(&bytes, &name, metres_per_unit),
        Format::Tfx => parse_tfx(&bytes, &name, metres_per_unit),
    }
}

/// Writes a groom in the format that the extension names: `.hair` holds all of it, `.tfx` (version 4) the positions only.
///
/// # Errors
/// [`GroomError`] when the format can not hold the groom or the file can not be written.
pub fn write_groom(path: impl AsRef<Path>, groom: &Groom) -> Result<(), GroomError> {
    let path = path.as_ref();
    let bytes = match Format::of(path)? {
        Format::Hair => hair_bytes(groom)?,
        Format::Tfx => tfx_bytes(groom)?,
    };
    fs::write(path, bytes).map_err(|source| GroomError::Io {
        path: path.into(),
        action: "write",
        source,
    })
}
