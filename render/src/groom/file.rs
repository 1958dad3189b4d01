//! Groom files by name.

use std::fs;
use std::path::Path;

use super::{
    Groom, GroomError, GroomReport, PaintedValues, ReadOptions, hair_bytes, parse_abc, parse_hair, parse_tfx,
    parse_usd, tfx_bytes, usda_bytes,
};

/// Extensions of the files that [`read_groom`] reads.
pub const GROOM_EXTENSIONS: [&str; 6] = ["hair", "tfx", "usda", "usdc", "usd", "abc"];

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
    /// Text or binary, told by the first bytes.
    Usd,
    /// Curves in, never out.
    Abc,
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
            "usd" | "usda" | "usdc" => Ok(Self::Usd),
            "abc" => Ok(Self::Abc),
            _ => Err(GroomError::refused(
                path.display().to_string(),
                format!("\"{extension}\" is not the extension of a groom"),
                "use .hair, .tfx, .usda, .usdc or .abc",
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
    let _scope = tracing::info_span!("read groom").entered();
    let options = ReadOptions {
        metres_per_unit,
        time: None,
    };
    read_painted_groom(path.as_ref(), options).map(|(loaded, _)| loaded)
}

/// [`read_groom`] with the painted values that a USD file brings, at the time that is asked for.
///
/// # Errors
/// As [`read_groom`]; also a time for a format that holds none.
pub fn read_painted_groom(
    path: &Path,
    options: ReadOptions,
) -> Result<(LoadedGroom, Option<PaintedValues>), GroomError> {
    let format = Format::of(path)?;
    let name = path.display().to_string();
    if options.time.is_some() && !matches!(format, Format::Usd) {
        return Err(GroomError::refused(
            name,
            "a time is given, but only USD files hold samples in time",
            "leave the time out",
        ));
    }
    let bytes = read(path)?;
    match format {
        Format::Hair => parse_hair(&bytes, &name, options.metres_per_unit).map(|loaded| (loaded, None)),
        Format::Tfx => parse_tfx(&bytes, &name, options.metres_per_unit).map(|loaded| (loaded, None)),
        Format::Usd => parse_usd(&bytes, &name, options).map(|usd| (usd.loaded, usd.painted)),
        Format::Abc => parse_abc(&bytes, &name, options.metres_per_unit).map(|abc| (abc.loaded, None)),
    }
}

/// True where the extension names a USD file.
pub fn is_usd(path: &Path) -> bool {
    matches!(Format::of(path), Ok(Format::Usd))
}

fn read(path: &Path) -> Result<Vec<u8>, GroomError> {
    fs::read(path).map_err(|source| GroomError::Io {
        path: path.into(),
        action: "read",
        source,
    })
}

/// Writes a groom in the format that the extension names: `.hair` holds all of it, `.tfx` (version 4) the positions only, `.usda` all of it.
///
/// # Errors
/// [`GroomError`] when the format can not hold the groom or the file can not be written.
pub fn write_groom(path: impl AsRef<Path>, groom: &Groom) -> Result<(), GroomError> {
    write_painted_groom(path.as_ref(), groom, None)
}

/// [`write_groom`] with painted values, which `.usda` holds and the other formats can not.
///
/// # Errors
/// As [`write_groom`]; also when there is not a value for every point.
pub fn write_painted_groom(
    path: &Path,
    groom: &Groom,
    painted: Option<&PaintedValues>,
) -> Result<(), GroomError> {
    let bytes = match Format::of(path)? {
        Format::Hair => hair_bytes(groom)?,
        Format::Tfx => tfx_bytes(groom)?,
        Format::Usd if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("usda")) => {
            usda_bytes(groom, painted)?
        }
        Format::Abc => {
            return Err(GroomError::refused(
                path.display().to_string(),
                "Alembic is read, not written",
                "write .usda",
            ));
        }
        Format::Usd => {
            return Err(GroomError::refused(
                path.display().to_string(),
                "binary USD is read, not written",
                "write .usda and convert it with usdcat",
            ));
        }
    };
    fs::write(path, bytes).map_err(|source| GroomError::Io {
        path: path.into(),
        action: "write",
        source,
    })
}
