//! Radiance `.hdr` pictures: RGBE scanlines, plain, with the old and with the new run-length code (Ward 1991, "Real pixels").
//!
//! Our own reader because the `image` crate's overflows on chains of empty runs and trusts the header's size before it has seen a scanline.

use glam::Vec3;

use super::error::Refusal;
use super::map::{RawMap, check_size};

/// First bytes of every Radiance picture; `RADIANCE`, `RGBE` or a program's name follows.
pub(super) const MAGIC: &[u8] = b"#?";

/// Longest header that is read; real ones have some hundred bytes.
const MAX_HEADER: usize = 1 << 16;

/// Widths that the new run-length code can hold.
const NEW_CODE_WIDTHS: std::ops::Range<usize> = 8..32768;

const EXPORT_AGAIN: &str = "the file is damaged or cut off: export or download it again";

/// Bytes of the file and how far they have been read.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// The next `count` bytes.
    fn take(&mut self, count: usize) -> Result<&'a [u8], Refusal> {
        let taken = self.bytes.get(self.at..).and_then(|rest| rest.get(..count));
        let Some(taken) = taken else {
            let reason = format!("the file ends, {count} more bytes were expected");
            return Err(Refusal::new(
                format!("byte {}", self.bytes.len()),
                reason,
                EXPORT_AGAIN,
            ));
        };
        self.at += count;
        Ok(taken)
    }

    /// The next byte.
    fn byte(&mut self) -> Result<u8, Refusal> {
        Ok(self.take(1)?[0])
    }

    /// The next line of the header without its end.
    fn line(&mut self) -> Result<String, Refusal> {
        let header = &self.bytes[self.at..self.bytes.len().min(MAX_HEADER).max(self.at)];
        let Some(length) = header.iter().position(|byte| *byte == b'\n') else {
            return Err(Refusal::new(
                format!("byte {}", self.at),
                "the header does not end",
                EXPORT_AGAIN,
            ));
        };
        self.at += length + 1;
        Ok(String::from_utf8_lossy(&header[..length]).trim_end().to_owned())
    }
}

/// What the header says of the pixels.
struct Header {
    width: usize,
    height: usize,
    bottom_up: bool,
    right_to_left: bool,
    warnings: Vec<String>,
}

/// Reads the pixels of a Radiance picture.
pub(super) fn read(bytes: &[u8]) -> Result<RawMap, Refusal> {
    let mut cursor = Cursor { bytes, at: 0 };
    let Header {
        width,
        height,
        bottom_up,
        right_to_left,
        warnings,
    } = read_header(&mut cursor)?;

    // A scanline has four bytes at least, so that a header that lies is found before its pixels are allocated; they then
    // grow with the scanlines that the file really holds.
    if (bytes.len() - cursor.at) / 4 < height {
        let reason = format!("{} bytes cannot hold {height} scanlines", bytes.len() - cursor.at);
        return Err(Refusal::new(format!("byte {}", cursor.at), reason, EXPORT_AGAIN));
    }
    let mut pixels: Vec<Vec3> = Vec::with_capacity(0);
    let mut scanline = vec![[0; 4]; width];
    for _ in 0..height {
        read_scanline(&mut cursor, &mut scanline)?;
        let start = pixels.len();
        pixels.extend(scanline.iter().map(|rgbe| radiance(*rgbe)));
        if right_to_left {
            pixels[start..].reverse();
        }
    }
    if bottom_up {
        pixels = pixels.rchunks(width).flatten().copied().collect();
    }
    Ok(RawMap {
        width,
        height,
        pixels,
        warnings,
    })
}

/// Reads the lines of text in front of the pixels.
fn read_header(cursor: &mut Cursor) -> Result<Header, Refusal> {
    let mut warnings = Vec::new();
    loop {
        let at = cursor.at;
        let line = cursor.line()?;
        if line.is_empty() {
            break;
        }
        let Some((name, value)) = line.split_once('=') else {
            continue;
        };
        match name.trim() {
            "FORMAT" if value.trim() != "32-bit_rle_rgbe" => {
                let reason = format!("pixels are {}", value.trim());
                return Err(Refusal::new(
                    format!("byte {at}"),
                    reason,
                    "convert to 32-bit_rle_rgbe, e.g. with ra_xyze -r",
                ));
            }
            "EXPOSURE" | "COLORCORR" => warnings.push(format!("{line} of the header is not undone")),
            "PRIMARIES" => warnings.push(format!("{line} is read as Rec.709")),
            _ => {}
        }
    }

    let at = cursor.at;
    let line = cursor.line()?;
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let place = format!("byte {at}");
    let refused = |reason: &str| {
        Refusal::new(
            &place,
            format!("resolution \"{line}\" {reason}"),
            "export as -Y height +X width",
        )
    };
    let [y_axis, height, x_axis, width] = words[..] else {
        return Err(refused("is not of the form -Y height +X width"));
    };
    if !matches!(y_axis, "-Y" | "+Y") || !matches!(x_axis, "+X" | "-X") {
        return Err(refused("does not run along rows"));
    }
    let (Ok(height), Ok(width)) = (height.parse(), width.parse()) else {
        return Err(refused("has a size that is no number"));
    };
    check_size(width, height, &place)?;
    Ok(Header {
        width,
        height,
        bottom_up: y_axis == "+Y",
        right_to_left: x_axis == "-X",
        warnings,
    })
}

/// Reads one row of pixels in whichever of the three codes it has.
fn read_scanline(cursor: &mut Cursor, scanline: &mut [[u8; 4]]) -> Result<(), Refusal> {
    let width = scanline.len();
    let place = format!("byte {}", cursor.at);
    let first = cursor.take(4)?;
    let is_new = NEW_CODE_WIDTHS.contains(&width) && first[0] == 2 && first[1] == 2 && first[2] < 128;
    if !is_new {
        cursor.at -= 4;
        return read_old_scanline(cursor, scanline);
    }
    let length = usize::from(first[2]) << 8 | usize::from(first[3]);
    if length != width {
        let reason = format!("a scanline of {length} pixels in a picture {width} wide");
        return Err(Refusal::new(place, reason, EXPORT_AGAIN));
    }

    // The new code holds the four components one after the other, each as runs (count > 128) and literal stretches.
    for component in 0..4 {
        let mut x = 0;
        while x < width {
            let at = cursor.at;
            let count = cursor.byte()?;
            let is_run = count > 128;
            let length = usize::from(if is_run { count - 128 } else { count });
            if length == 0 || length > width - x {
                let reason = format!("a stretch of {length} at pixel {x} of {width}");
                return Err(Refusal::new(format!("byte {at}"), reason, EXPORT_AGAIN));
            }
            let values = cursor.take(if is_run { 1 } else { length })?;
            for (offset, pixel) in scanline[x..x + length].iter_mut().enumerate() {
                pixel[component] = values[if is_run { 0 } else { offset }];
            }
            x += length;
        }
    }
    Ok(())
}

/// Reads pixel after pixel; (1, 1, 1, n) repeats the last one n times, n shifted by 8 bits for each marker in a row.
fn read_old_scanline(cursor: &mut Cursor, scanline: &mut [[u8; 4]]) -> Result<(), Refusal> {
    let width = scanline.len();
    let (mut x, mut shift) = (0, 0);
    while x < width {
        let at = cursor.at;
        let rgbe = cursor.take(4)?;
        if rgbe[..3] != [1, 1, 1] {
            scanline[x].copy_from_slice(rgbe);
            (x, shift) = (x + 1, 0);
            continue;
        }
        let count = usize::from(rgbe[3]) << shift;
        if x == 0 || shift > 16 || count > width - x {
            let reason = format!("a run of {count} at pixel {x} of {width}");
            return Err(Refusal::new(format!("byte {at}"), reason, EXPORT_AGAIN));
        }
        let last = scanline[x - 1];
        scanline[x..x + count].fill(last);
        (x, shift) = (x + count, shift + 8);
    }
    Ok(())
}

/// Radiance of one pixel: mantissas over 256, common exponent with bias 128; exponent 0 is black.
fn radiance([r, g, b, exponent]: [u8; 4]) -> Vec3 {
    if exponent == 0 {
        return Vec3::ZERO;
    }
    Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * (f32::from(exponent) - 136.0).exp2()
}
