//! Cem Yuksel's `.hair` (HAIR file format, www.cemyuksel.com/research/hairmodels): a 128-byte header, then the arrays that its flags name.
//!
//! | bytes | content |
//! |---|---|
//! | 0..4 | "HAIR" |
//! | 4..8, 8..12 | strands, points (u32) |
//! | 12..16 | flags: 1 segments, 2 points, 4 thickness, 8 transparency, 16 colours |
//! | 16..20 | segments per strand where there is no segments array (u32) |
//! | 20..24 | thickness where there is no thickness array (f32): a fibre DIAMETER in file units |
//! | 24..40 | default transparency and colour (f32), not used |
//! | 40..128 | text; `metres_per_unit=X` in it states the unit (our own convention) |

use super::bytes::{FileBytes, f32_at, point_at};
use super::{Groom, GroomBuilder, GroomError, LoadedGroom, UnitSource};

const MAGIC: &[u8; 4] = b"HAIR";
const HEADER_LEN: u64 = 128;
const TEXT: std::ops::Range<usize> = 40..128;
const UNIT_KEY: &str = "metres_per_unit=";

const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLOURS: u32 = 16;

/// Reads a `.hair` file from memory; `name` is for messages.
///
/// Without `metres_per_unit` the unit is the one the file's text states, else a guess from its size. Allocates at most 16 bytes per point
/// and 4 per strand, after the counts have been checked against the bytes that are there.
///
/// # Errors
/// [`GroomError::Format`] for bytes that break the format, [`GroomError::Refused`] when no strand is usable.
pub fn parse_hair(bytes: &[u8], name: &str, metres_per_unit: Option<f32>) -> Result<LoadedGroom, GroomError> {
    let file = FileBytes { name, bytes };
    if !bytes.starts_with(MAGIC) {
        return Err(file.error(
            0,
            "it does not start with \"HAIR\"",
            "give a .hair file of Yuksel's format",
        ));
    }
    let header = file.section(0, HEADER_LEN, "the header")?;
    let strands = u64::from(file.u32(4)?);
    let points = u64::from(file.u32(8)?);
    let flags = file.u32(12)?;
    if flags & POINTS == 0 {
        return Err(file.error(
            12,
            "the flags say that there are no points",
            "export the hair with its points",
        ));
    }

    // Lay the arrays out behind each other; each must be there as a whole before anything is allocated.
    let mut end = HEADER_LEN;
    let mut array = |flag: u32, count: u64, stride: u64, what: &str| -> Result<Option<&[u8]>, GroomError> {
        if flags & flag == 0 {
            return Ok(None);
        }
        let section = file.section(end, count * stride, what)?;
        end += count * stride;
        Ok(Some(section))
    };
    let segments = array(SEGMENTS, strands, 2, "the array of segment counts")?;
    let positions = array(POINTS, points, 12, "the array of points")?.unwrap_or_default();
    let thickness = array(THICKNESS, points, 4, "the array of thicknesses")?;
    array(TRANSPARENCY, points, 4, "the array of transparencies")?;
    array(COLOURS, points, 12, "the array of colours")?;

    // The segment counts must account for every point.
    let default_segments = file.u32(16)?;
    let points_of = |strand: usize| -> u64 {
        1 + segments.map_or(u64::from(default_segments), |s| {
            u64::from(u16::from_le_bytes([s[2 * strand], s[2 * strand + 1]]))
        })
    };
    let counted = match segments {
        None => strands * points_of(0),
        Some(_) => (0..strands as usize).map(points_of).sum(),
    };
    if counted != points {
        return Err(file.error(
            8,
            format!("the header states {points} points, but its {strands} strands have {counted}"),
            "export the hair again",
        ));
    }

    // A default thickness that is no positive number counts as not stated.
    let default_thickness = Some(file.f32(20)?).filter(|&d| d > 0.0 && d.is_finite());
    let mut builder = GroomBuilder::with_capacity(strands as usize, points as usize);
    let mut first = 0;
    for strand in 0..strands as usize {
        let next = first + points_of(strand) as usize;
        builder.push_strand((first..next).map(|point| {
            (
                point_at(positions, point, 3),
                thickness.map_or(default_thickness, |t| Some(f32_at(t, point))),
            )
        }));
        first = next;
    }

    if flags & (TRANSPARENCY | COLOURS) != 0 {
        builder.note("the file's transparencies and colours are not used");
    }
    if bytes.len() as u64 > end {
        builder.note(format!(
            "{} bytes behind the last array are not used",
            bytes.len() as u64 - end
        ));
    }
    let unit = metres_per_unit
        .map(|unit| (unit, UnitSource::Given))
        .or_else(|| unit_of_text(&header[TEXT]).map(|unit| (unit, UnitSource::File)));
    let (groom, report) = builder.finish(name, unit)?;
    Ok(LoadedGroom { groom, report })
}

/// The unit that the header's text states, if it does.
fn unit_of_text(text: &[u8]) -> Option<f32> {
    let text = text.split(|&b| b == 0).next().unwrap_or_default();
    let value = std::str::from_utf8(text).ok()?.split_once(UNIT_KEY)?.1;
    let value = value.split(|c: char| c.is_whitespace() || c == ';').next()?;
    value
        .parse()
        .ok()
        .filter(|unit: &f32| unit.is_normal() && *unit > 0.0)
}

/// The bytes of a `.hair` file that [`parse_hair`] reads back as an equal groom, bit for bit.
///
/// Equal segment counts and equal diameters go into the header, others into arrays.
///
/// # Errors
/// [`GroomError::Refused`] when a strand has more than 65,535 segments: the format has 16 bits for them.
pub fn hair_bytes(groom: &Groom) -> Result<Vec<u8>, GroomError> {
    let segments: Vec<u16> = (0..groom.strand_count())
        .map(|strand| {
            let segments = groom.strand(strand).len() - 1;
            u16::try_from(segments).map_err(|_| {
                GroomError::refused(
                    "groom",
                    format!("strand {strand} has {segments} segments, .hair holds 65535"),
                    "split or simplify the strand",
                )
            })
        })
        .collect::<Result<_, _>>()?;
    let diameters = groom.diameters();
    let equal_segments = segments.iter().all(|&s| s == segments[0]);
    let equal_diameters = diameters.iter().all(|&d| d == diameters[0]);

    // The header, with counts that a groom keeps within u32.
    let mut flags = POINTS;
    flags |= if equal_segments { 0 } else { SEGMENTS };
    flags |= if equal_diameters { 0 } else { THICKNESS };
    let mut bytes = Vec::with_capacity(HEADER_LEN as usize + 18 * groom.point_count());
    bytes.extend_from_slice(MAGIC);
    for word in [
        groom.strand_count() as u32,
        groom.point_count() as u32,
        flags,
        u32::from(segments[0]),
    ] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    for value in [diameters[0], 0.0, 1.0, 1.0, 1.0] {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    bytes.extend_from_slice(format!("Balayage; {UNIT_KEY}{}", groom.metres_per_unit()).as_bytes());
    bytes.resize(HEADER_LEN as usize, 0);

    if !equal_segments {
        bytes.extend(segments.iter().flat_map(|s| s.to_le_bytes()));
    }
    bytes.extend(
        groom
            .positions()
            .iter()
            .flat_map(glam::Vec3::to_array)
            .flat_map(f32::to_le_bytes),
    );
    if !equal_diameters {
        bytes.extend(diameters.iter().flat_map(|d| d.to_le_bytes()));
    }
    Ok(bytes)
}
