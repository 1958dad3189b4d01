//! Pictures: linear RGBA in memory, PNG and EXR on disk.

use std::fmt::Display;
use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::meta::attribute::{AttributeValue, Text};
use exr::prelude::{SpecificChannels, Vec2, WritableImage};

/// Scene-linear Rec.709, premultiplied by alpha = coverage; row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` pixels, row after row.
    pub pixels: Vec<[f32; 4]>,
}

/// What [`Picture::difference`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Mean radiance over the reference's, per channel, over pixels that the reference covers.
    pub ratio: [f64; 3],
    /// Root mean square difference of the means of square tiles, over their root mean square.
    pub tile_rmse: f64,
}

/// A picture could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file could not be written.
    #[error("{path}: cannot write the picture: {reason}; check that the folder exists and may be written")]
    Write {
        /// The file.
        path: String,
        /// What the system or encoder said.
        reason: String,
    },
    /// The file could not be read.
    #[error("{path}: cannot read the picture: {reason}")]
    Read {
        /// The file.
        path: String,
        /// What the system or decoder said.
        reason: String,
    },
}

impl PictureError {
    fn write(path: &Path, reason: &dyn Display) -> Self {
        Self::Write {
            path: path.display().to_string(),
            reason: reason.to_string(),
        }
    }
}

impl Picture {
    /// Writes RGBA float OpenEXR, scene-linear, premultiplied.
    ///
    /// # Errors
    /// [`PictureError::Write`].
    pub fn write_exr(&self, path: &Path) -> Result<(), PictureError> {
        let bytes = self.exr_bytes(path, &Metadata::new())?;
        fs::write(path, bytes).map_err(|e| PictureError::write(path, &e))
    }

    /// The bytes of the file that [`Picture::write_exr`] writes, with `metadata` as text attributes; `path` is for messages.
    ///
    /// # Errors
    /// [`PictureError::Write`].
    pub fn exr_bytes(&self, path: &Path, metadata: &Metadata) -> Result<Vec<u8>, PictureError> {
        let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
            let [r, g, b, a] = self.pixels[at.y() * self.width + at.x()];
            (r, g, b, a)
        });
        let mut image = exr::prelude::Image::from_channels((self.width, self.height), channels);
        for (name, text) in metadata {
            if let (Some(name), Some(text)) = (Text::new_or_none(ascii(name)), Text::new_or_none(ascii(text)))
            {
                let attributes = &mut image.layer_data.attributes;
                match name.to_string().as_str() {
                    "Software" => attributes.software_name = Some(text),
                    _ => drop(attributes.other.insert(name, AttributeValue::Text(text))),
                }
            }
        }
        let mut bytes = Cursor::new(Vec::new());
        image
            .write()
            .to_buffered(&mut bytes)
            .map_err(|e| PictureError::write(path, &e))?;
        Ok(bytes.into_inner())
    }

    /// Reads the first RGBA layer of an OpenEXR file.
    ///
    /// # Errors
    /// [`PictureError::Read`].
    pub fn read_exr(path: &Path) -> Result<Self, PictureError> {
        let image = exr::prelude::read_first_rgba_layer_from_file(
            path,
            |size, _| Picture {
                width: size.width(),
                height: size.height(),
                pixels: vec![[0.0; 4]; size.width() * size.height()],
            },
            |picture, position, (r, g, b, a): (f32, f32, f32, f32)| {
                let at = position.y() * picture.width + position.x();
                picture.pixels[at] = [r, g, b, a];
            },
        )
        .map_err(|e| PictureError::Read {
            path: path.display().to_string(),
            reason: e.to_string(),
        })?;
        Ok(image.layer_data.channel_data.pixels)
    }

    /// How far the picture is from a reference of the same size, a path tracer's for example.
    ///
    /// # Panics
    /// Where the sizes differ.
    pub fn difference(&self, reference: &Self, tile: usize) -> Difference {
        assert_eq!(
            (self.width, self.height),
            (reference.width, reference.height),
            "pictures of one size are compared"
        );
        let mean = |picture: &Self, c: usize| {
            let covered = picture
                .pixels
                .iter()
                .zip(&reference.pixels)
                .filter(|(_, r)| r[3] > 0.0);
            covered.map(|(p, _)| f64::from(p[c])).sum::<f64>()
        };
        let sum = |picture: &Self, x: usize, y: usize, c: usize| -> f64 {
            let pixels =
                (0..tile * tile).map(|k| (y * tile + k / tile) * picture.width + x * tile + k % tile);
            pixels.map(|k| f64::from(picture.pixels[k][c])).sum()
        };
        let (mut error, mut norm) = (0.0, 0.0);
        for y in 0..reference.height / tile {
            for x in 0..reference.width / tile {
                for c in 0..3 {
                    let expected = sum(reference, x, y, c);
                    error += (sum(self, x, y, c) - expected).powi(2);
                    norm += expected * expected;
                }
            }
        }
        Difference {
            ratio: std::array::from_fn(|c| mean(self, c) / mean(reference, c)),
            tile_rmse: (error / norm).sqrt(),
        }
    }

    /// Mean radiance of what is covered, linear rgb; not finite where nothing is.
    pub fn mean(&self) -> [f64; 3] {
        let sum = |c: usize| self.pixels.iter().map(|pixel| f64::from(pixel[c])).sum::<f64>();
        let covered = sum(3);
        std::array::from_fn(|c| sum(c) / covered)
    }

    /// Pixels with a value that is not finite.
    pub fn non_finite(&self) -> usize {
        self.pixels
            .iter()
            .filter(|p| p.iter().any(|c| !c.is_finite()))
            .count()
    }
}

/// Names and texts that a file carries beside its pixels.
pub type Metadata = Vec<(String, String)>;

/// Writes display-referred RGBA bytes, `width * height * 4` of them, as PNG.
///
/// # Errors
/// [`PictureError::Write`].
pub fn write_png(path: &Path, width: usize, height: usize, rgba: &[u8]) -> Result<(), PictureError> {
    let bytes = png_bytes(path, [width as u32, height as u32], rgba, &Metadata::new())?;
    fs::write(path, bytes).map_err(|e| PictureError::write(path, &e))
}

/// The bytes of the file that [`write_png`] writes, with `metadata` as text chunks; `path` is for messages.
///
/// # Errors
/// [`PictureError::Write`]; also where there are not `4 * width * height` bytes.
pub fn png_bytes(
    path: &Path,
    [width, height]: [u32; 2],
    rgba: &[u8],
    metadata: &Metadata,
) -> Result<Vec<u8>, PictureError> {
    let encoded = || -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        for (name, text) in metadata {
            encoder.add_text_chunk(ascii(name), ascii(text))?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(rgba)?;
        writer.finish()?;
        Ok(bytes)
    };
    encoded().map_err(|e| PictureError::write(path, &e))
}

/// The metadata of a PNG or EXR whose pixels are all there.
///
/// # Errors
/// [`PictureError::Read`] for a file that is missing, damaged or cut off.
pub fn read_metadata(path: &Path) -> Result<Metadata, PictureError> {
    let failed = |reason: String| PictureError::Read {
        path: path.display().to_string(),
        reason,
    };
    let bytes = fs::read(path).map_err(|e| failed(e.to_string()))?;
    if bytes.starts_with(b"\x89PNG") {
        let read = || -> Result<Metadata, png::DecodingError> {
            let mut reader = png::Decoder::new(Cursor::new(&bytes)).read_info()?;
            let size = reader.output_buffer_size().unwrap_or(usize::MAX);
            // A picture of ours has four bytes a pixel; a header that says more than packing can hold lies.
            let mut pixels = vec![0; size.min(bytes.len().saturating_mul(1100))];
            reader.next_frame(&mut pixels)?;
            reader.finish()?;
            let texts = reader.info().uncompressed_latin1_text.iter();
            Ok(texts
                .map(|chunk| (chunk.keyword.clone(), chunk.text.clone()))
                .collect())
        };
        return read().map_err(|e| failed(e.to_string()));
    }
    let image =
        exr::prelude::read_first_rgba_layer_from_file(path, |_, _| (), |(), _, _: (f32, f32, f32, f32)| {})
            .map_err(|e| failed(e.to_string()))?;
    let others = image.layer_data.attributes.other;
    Ok(others
        .into_iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(text) => Some((name.to_string(), text.to_string())),
            _ => None,
        })
        .collect())
}

/// What is not ASCII as `\u{...}`: both formats hold Latin-1 only.
fn ascii(text: &str) -> String {
    let plain = |c: char| match c {
        '\0' => String::new(),
        c if c.is_ascii() => c.to_string(),
        c => c.escape_unicode().to_string(),
    };
    text.chars().map(plain).collect()
}
