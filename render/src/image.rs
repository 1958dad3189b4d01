//! Pictures: linear RGBA in memory, PNG and EXR on disk.

use std::path::Path;

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

impl Picture {
    /// Writes RGBA float OpenEXR, scene-linear, premultiplied.
    ///
    /// # Errors
    /// [`PictureError::Write`].
    pub fn write_exr(&self, path: &Path) -> Result<(), PictureError> {
        exr::prelude::write_rgba_file(path, self.width, self.height, |x, y| {
            let [r, g, b, a] = self.pixels[y * self.width + x];
            (r, g, b, a)
        })
        .map_err(|e| PictureError::Write {
            path: path.display().to_string(),
            reason: e.to_string(),
        })
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

    /// Pixels with a value that is not finite.
    pub fn non_finite(&self) -> usize {
        self.pixels
            .iter()
            .filter(|p| p.iter().any(|c| !c.is_finite()))
            .count()
    }
}

/// Writes display-referred RGBA bytes, `width * height * 4` of them, as PNG.
///
/// # Errors
/// [`PictureError::Write`].
pub fn write_png(path: &Path, width: usize, height: usize, rgba: &[u8]) -> Result<(), PictureError> {
    let fail = |reason: String| PictureError::Write {
        path: path.display().to_string(),
        reason,
    };
    let buffer = image::RgbaImage::from_raw(width as u32, height as u32, rgba.to_vec())
        .ok_or_else(|| fail(format!("{} bytes are not {width} x {height} pixels", rgba.len())))?;
    buffer
        .save_with_format(path, image::ImageFormat::Png)
        .map_err(|e| fail(e.to_string()))
}
