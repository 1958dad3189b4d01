//! OpenEXR maps through the `exr` crate: half and float, all its compressions (DWA included), scan lines and tiles, several parts.
//!
//! The header is judged before pixels are decoded; rows are allocated as chunks arrive, so that a header that lies costs nothing.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use exr::block::chunk::TileCoordinates;
use exr::block::reader::ChunksReader;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::meta::MetaData;
use exr::meta::attribute::SampleType;
use exr::meta::header::Header;
use glam::Vec3;
use half::f16;

use super::error::Refusal;
use super::map::{RawMap, check_size};

/// First bytes of every OpenEXR file.
pub(super) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Byte of the version field that says "deep data" in its bit 3.
const FLAGS_BYTE: usize = 5;

/// Most pixels a tile may have; larger ones would have to be decoded in one piece.
const MAX_TILE_PIXELS: usize = 1 << 22;

const EXPORT_AGAIN: &str = "the file is damaged or cut off: export or download it again";
const FLATTEN: &str =
    "flatten it to a scan-line image with full-resolution R, G, B, e.g. oiiotool in.exr --flatten -o out.exr";
const CONVERT: &str =
    "convert it to full-resolution R, G, B, e.g. exrheader to look and oiiotool in.exr -o out.exr to convert";

/// Reads the pixels of an OpenEXR picture.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, Refusal> {
    if bytes.get(FLAGS_BYTE).is_some_and(|flags| flags & 0b1000 != 0) {
        return Err(Refusal::new("version field", "deep data is not read", FLATTEN));
    }

    // The decoder is a dependency fed with anyone's bytes: a panic in it is a damaged file, not our end.
    catch_unwind(AssertUnwindSafe(|| decode(bytes)))
        .unwrap_or_else(|_| Err(Refusal::new("pixel data", "the decoder gave up", EXPORT_AGAIN)))
}

/// What the decoder says, as a refusal.
fn refused(place: &str, error: &exr::error::Error) -> Refusal {
    match error {
        exr::error::Error::NotSupported(what) => {
            Refusal::new(place, format!("not supported: {what}"), CONVERT)
        }
        other => Refusal::new(place, other.to_string(), EXPORT_AGAIN),
    }
}

/// Which channels of which part make the picture.
struct Source {
    part: usize,
    /// Red, green, blue as indices into the part's channels; the same one three times for a grey map.
    channels: [usize; 3],
}

fn decode(bytes: &[u8]) -> Result<RawMap, Refusal> {
    let reader = exr::block::read(Cursor::new(bytes), false).map_err(|error| refused("header", &error))?;
    let Source { part, channels } = find_source(reader.headers())?;
    let header = &reader.headers()[part];
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    check_size(width, height, "data window")?;
    check_chunks(reader.headers(), bytes.len())?;
    let mut warnings = warnings(reader.headers(), part, channels);

    // Only the full-resolution level of the chosen part is decoded.
    let wanted = |_: &MetaData, tile: TileCoordinates, block: BlockIndex| {
        block.layer == part && tile.level_index.x() == 0 && tile.level_index.y() == 0
    };
    let chunks = reader
        .filter_chunks(false, wanted)
        .map_err(|error| refused("chunk table", &error))?;
    let mut rows: Vec<Vec<Vec3>> = vec![Vec::new(); height];
    let mut samples = 0;
    let mut blocks = chunks.sequential_decompressor(false);
    while let Some(block) = blocks.decompress_next_block() {
        let block = block.map_err(|error| refused("pixel data", &error))?;
        let header = &blocks.meta_data().headers[part];
        samples += copy_block(&block, header, channels, &mut rows)?;
    }
    if samples < width * height {
        let reason = format!("{samples} of {} pixels are there", width * height);
        return Err(Refusal::new("pixel data", reason, EXPORT_AGAIN));
    }
    if rows.iter().any(Vec::is_empty) {
        warnings.push("some rows are missing and were read as black".to_owned());
    }
    let pixels = rows
        .into_iter()
        .flat_map(|row| {
            if row.is_empty() {
                vec![Vec3::ZERO; width]
            } else {
                row
            }
        })
        .collect();
    Ok(RawMap {
        width,
        height,
        pixels,
        warnings,
    })
}

/// The first part that holds R, G and B (or a single Y), plain names before those of a layer.
fn find_source(parts: &[Header]) -> Result<Source, Refusal> {
    let find = |part: &Header, wanted: &str| {
        let channels = &part.channels.list;
        let names = || channels.iter().map(|channel| channel.name.to_string());
        let plain = names().position(|name| name == wanted);
        plain.or_else(|| names().position(|name| name.ends_with(&format!(".{wanted}"))))
    };
    for (index, part) in parts.iter().enumerate() {
        if part.deep {
            continue;
        }
        let rgb = [find(part, "R"), find(part, "G"), find(part, "B")];
        let channels = match (rgb, find(part, "Y")) {
            ([Some(r), Some(g), Some(b)], _) => [r, g, b],
            (_, Some(y)) if find(part, "RY").is_none() && find(part, "BY").is_none() => [y; 3],
            (_, Some(_)) => {
                return Err(Refusal::new(
                    "channels",
                    "luminance and chroma (Y, RY, BY) are not read",
                    CONVERT,
                ));
            }
            _ => continue,
        };
        let subsampled = channels.iter().any(|channel| {
            let sampling = part.channels.list[*channel].sampling;
            sampling.x() != 1 || sampling.y() != 1
        });
        if subsampled {
            return Err(Refusal::new(
                "channels",
                "subsampled channels are not read",
                CONVERT,
            ));
        }
        return Ok(Source {
            part: index,
            channels,
        });
    }
    let names: Vec<String> = parts
        .iter()
        .flat_map(|part| part.channels.list.iter().map(|channel| channel.name.to_string()))
        .take(8)
        .collect();
    Err(Refusal::new(
        "channels",
        format!("no R, G, B or Y among {}", names.join(", ")),
        CONVERT,
    ))
}

/// Refuses chunk tables longer than the file and tiles too large to decode.
fn check_chunks(parts: &[Header], file_length: usize) -> Result<(), Refusal> {
    for part in parts {
        if part.chunk_count > file_length / 8 {
            let reason = format!("{} chunks in a file of {file_length} bytes", part.chunk_count);
            return Err(Refusal::new("chunk table", reason, EXPORT_AGAIN));
        }
        let tile = part.max_block_pixel_size();
        if tile.width().saturating_mul(tile.height()) > MAX_TILE_PIXELS {
            let reason = format!("tiles of {} x {}", tile.width(), tile.height());
            return Err(Refusal::new("header", reason, CONVERT));
        }
    }
    Ok(())
}

/// What the user should know about the choice of part, channels and colour space.
fn warnings(parts: &[Header], part: usize, channels: [usize; 3]) -> Vec<String> {
    let header = &parts[part];
    let mut warnings = Vec::new();
    if parts.len() > 1 {
        warnings.push(format!("part {part} of {} is read", parts.len()));
    }
    let red = header.channels.list[channels[0]].name.to_string();
    if red != "R" {
        warnings.push(format!("channel {red} is read for red"));
    }
    let rec_709 = [(0.64, 0.33), (0.3, 0.6), (0.15, 0.06), (0.3127, 0.329)];
    if let Some(found) = header.shared_attributes.chromaticities {
        let found = [found.red, found.green, found.blue, found.white];
        let far =
            |(a, b): (&exr::math::Vec2<f32>, &(f32, f32))| (a.0 - b.0).abs().max((a.1 - b.1).abs()) > 0.005;
        if found.iter().zip(&rec_709).any(far) {
            warnings.push("other primaries than Rec.709 are read as Rec.709".to_owned());
        }
    }
    warnings
}

/// Copies the wanted channels of one block into the rows; returns how many pixels it held.
fn copy_block(
    block: &UncompressedBlock,
    header: &Header,
    channels: [usize; 3],
    rows: &mut [Vec<Vec3>],
) -> Result<usize, Refusal> {
    let width = header.layer_size.width();
    let mut pixels = 0;
    for line in block.lines(&header.channels) {
        let position = line.location.position;
        let places = position.x()..position.x() + line.location.sample_count;
        if places.end > width || position.y() >= rows.len() {
            return Err(Refusal::new(
                "pixel data",
                "a block lies outside the picture",
                EXPORT_AGAIN,
            ));
        }
        let wanted: Vec<usize> = (0..3)
            .filter(|rgb| channels[*rgb] == line.location.channel)
            .collect();
        if wanted.is_empty() {
            continue;
        }
        let values = decode_line(
            line.value,
            header.channels.list[line.location.channel].sample_type,
        );
        let row = &mut rows[position.y()];
        if row.is_empty() {
            row.resize(width, Vec3::ZERO);
        }
        for rgb in wanted {
            for (pixel, value) in row[places.clone()].iter_mut().zip(&values) {
                pixel[rgb] = *value;
            }
            pixels += usize::from(rgb == 0) * values.len();
        }
    }
    Ok(pixels)
}

/// Samples of one channel in one row, in the machine's byte order as the decoder leaves them.
fn decode_line(bytes: &[u8], sample_type: SampleType) -> Vec<f32> {
    let four = || {
        bytes
            .chunks_exact(4)
            .map(|bytes| [bytes[0], bytes[1], bytes[2], bytes[3]])
    };
    match sample_type {
        SampleType::F16 => bytes
            .chunks_exact(2)
            .map(|two| f16::from_ne_bytes([two[0], two[1]]).to_f32())
            .collect(),
        SampleType::F32 => four().map(f32::from_ne_bytes).collect(),
        SampleType::U32 => four().map(|bytes| u32::from_ne_bytes(bytes) as f32).collect(),
    }
}
