//! AMD TressFX `.tfx`, versions 3 and 4: all strands have the same number of points; no diameters, no unit.
//!
//! | | version 3 | version 4 |
//! |---|---|---|
//! | bytes 0..4 | version (f32) | the same |
//! | 4..8, 8..12 | strands, points per strand (u32) | the same |
//! | offset of the positions | u64 at 144 | u32 at 12 |
//! | header | 296 bytes | 160 bytes |
//! | positions | f32 x 3 | f32 x 4; w is an inverse mass, 0 marks a pinned point such as the root |

use super::bytes::{FileBytes, point_at};
use super::{Groom, GroomBuilder, GroomError, LoadedGroom, UnitSource};

const HEADER_LEN_V3: u64 = 296;
const HEADER_LEN_V4: u64 = 160;

/// Reads a `.tfx` file from memory; `name` is for messages.
///
/// Without `metres_per_unit` the unit is a guess from the size of the hair. Allocates at most 16 bytes per point and 4 per strand, after
/// the counts have been checked against the bytes that are there.
///
/// # Errors
/// [`GroomError::Format`] for bytes that break the format, [`GroomError::Refused`] when no strand is usable.
pub fn parse_tfx(bytes: &[u8], name: &str, metres_per_unit: Option<f32>) -> Result<LoadedGroom, GroomError> {
    let file = FileBytes { name, bytes };
    let version = file.f32(0)?;
    let strands = u64::from(file.u32(4)?);
    let points_per_strand = u64::from(file.u32(8)?);

    // The two versions differ in the place of the offset and the width of a point.
    let (header_len, offset, stride) = if (3.0..4.0).contains(&version) {
        file.section(0, HEADER_LEN_V3, "the header of version 3")?;
        (
            HEADER_LEN_V3,
            u64::from(file.u32(144)?) | u64::from(file.u32(148)?) << 32,
            3,
        )
    } else if (4.0..5.0).contains(&version) {
        file.section(0, HEADER_LEN_V4, "the header of version 4")?;
        (HEADER_LEN_V4, u64::from(file.u32(12)?), 4)
    } else {
        return Err(file.error(
            0,
            format!("the version is {version}, not 3 or 4"),
            "give a .tfx file written by TressFX 3 or 4",
        ));
    };

    // An offset of zero means "right behind the header"; one inside the header would read the header as hair.
    let offset = if offset == 0 { header_len } else { offset };
    if offset < header_len {
        return Err(file.error(
            if stride == 3 { 144 } else { 12 },
            format!("the positions start at byte {offset}, inside the header of {header_len} bytes"),
            "export the hair again",
        ));
    }

    // The product of two u32 fits into u64, its bytes may not.
    let points = strands * points_per_strand;
    let positions = file.section(
        offset,
        points.saturating_mul(4 * stride),
        "the array of positions",
    )?;
    let mut builder = GroomBuilder::with_capacity(strands as usize, points as usize);
    for strand in 0..if points == 0 { 0 } else { strands } {
        let first = strand * points_per_strand;
        builder.push_strand(
            (first..first + points_per_strand)
                .map(|point| (point_at(positions, point as usize, stride as usize), None)),
        );
    }

    let end = offset + points * 4 * stride;
    if bytes.len() as u64 > end {
        builder.note("texture coordinates, thicknesses and colours of the file are not used");
    }
    let (groom, report) = builder.finish(name, metres_per_unit.map(|unit| (unit, UnitSource::Given)))?;
    Ok(LoadedGroom { groom, report })
}

/// The bytes of a `.tfx` file, version 4, whose positions [`parse_tfx`] reads back bit for bit. The first point of every strand is pinned.
///
/// # Errors
/// [`GroomError::Refused`] when strands differ in their number of points.
pub fn tfx_bytes(groom: &Groom) -> Result<Vec<u8>, GroomError> {
    let points_per_strand = groom.strand(0).len();
    if let Some(strand) = (0..groom.strand_count()).find(|&s| groom.strand(s).len() != points_per_strand) {
        return Err(GroomError::refused(
            "groom",
            format!(
                "strand {strand} has {} points and strand 0 has {points_per_strand}, but .tfx wants the same number everywhere",
                groom.strand(strand).len()
            ),
            "write .hair instead or resample the strands",
        ));
    }

    let mut bytes = Vec::with_capacity(HEADER_LEN_V4 as usize + 16 * groom.point_count());
    bytes.extend_from_slice(&4.0_f32.to_le_bytes());
    for word in [
        groom.strand_count() as u32,
        points_per_strand as u32,
        HEADER_LEN_V4 as u32,
    ] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    bytes.resize(HEADER_LEN_V4 as usize, 0);
    for (point, p) in groom.positions().iter().enumerate() {
        let inverse_mass = if point % points_per_strand == 0 { 0.0 } else { 1.0 };
        for value in [p.x, p.y, p.z, inverse_mass] {
            bytes.extend_from_slice(&f32::to_le_bytes(value));
        }
    }
    Ok(bytes)
}
