//! Environment maps: reading any supported file, cleaning, directions and solid angles of pixels.

use std::borrow::Cow;
use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::bands::bands;
use super::error::Refusal;
use super::fit::Progress;
use super::{EnvironmentMap, InputError, open_exr, radiance_hdr};

/// Most pixels a map may have: 8192 x 4096.
pub const MAX_PIXELS: usize = 1 << 25;

/// Brightest value a pixel keeps, so that sums over a whole map stay finite in f32.
const MAX_RADIANCE: f32 = 1e30;

/// What was found and repaired while a map was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapReport {
    /// Pixels with a NaN channel; the channel was set to 0.
    pub nan_pixels: usize,
    /// Pixels with an infinite channel or one above 1e30; the channel was set to the largest value of the map that is neither
    /// (what overflowed a half float was at least as bright as the rest), minus infinity to 0.
    pub infinite_pixels: usize,
    /// Pixels with a negative channel; the channel was set to 0.
    pub negative_pixels: usize,
    /// The lowest finite value of the file.
    pub lowest: f32,
    /// Things that are no error but rarely meant: wrong aspect, an exposure in the header, an all black map.
    pub warnings: Vec<String>,
}

/// What a reader of one format hands over: pixels as they stand in the file.
pub(super) struct RawMap {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Vec3>,
    pub warnings: Vec<String>,
}

/// Refuses sizes of nothing and sizes beyond [`MAX_PIXELS`] before anything is allocated.
pub(super) fn check_size(width: usize, height: usize, place: &str) -> Result<(), Refusal> {
    let pixels = width.checked_mul(height);
    if width == 0 || height == 0 {
        let reason = format!("a map of {width} x {height} pixels is empty");
        return Err(Refusal::new(place, reason, "export the map again"));
    }
    if pixels.is_none_or(|pixels| pixels > MAX_PIXELS) {
        let reason = format!("{width} x {height} is more than {MAX_PIXELS} pixels");
        return Err(Refusal::new(
            place,
            reason,
            "scale the map down to at most 8192 x 4096; 40 lights need no more than 512 x 256",
        ));
    }
    Ok(())
}

impl EnvironmentMap {
    /// Reads a Radiance `.hdr` or OpenEXR map; the format is told by the first bytes, not by the name.
    ///
    /// # Errors
    /// [`InputError`] with file, place, reason and remedy where the file is missing, broken, too large or of a kind that is not read.
    pub fn read(path: &Path) -> Result<(Self, MapReport), InputError> {
        let bytes = std::fs::read(path).map_err(|error| {
            Refusal::new(
                "whole file",
                error.to_string(),
                "check the path and its permissions",
            )
            .of(path)
        })?;
        Self::from_bytes(&bytes, path)
    }

    /// Reads a map from the bytes of a file; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As [`EnvironmentMap::read`].
    pub fn from_bytes(bytes: &[u8], name: &Path) -> Result<(Self, MapReport), InputError> {
        let raw = if bytes.starts_with(&open_exr::MAGIC) {
            open_exr::read(bytes)
        } else if bytes.starts_with(radiance_hdr::MAGIC) {
            radiance_hdr::read(bytes)
        } else {
            let remedy = "give an equirectangular map as Radiance .hdr or OpenEXR .exr";
            Err(Refusal::new("byte 0", "neither Radiance nor OpenEXR", remedy))
        };
        raw.map(Self::cleaned).map_err(|refusal| refusal.of(name))
    }

    /// Counts and repairs what is no radiance, and warns of what is rarely meant.
    pub(super) fn cleaned(raw: RawMap) -> (Self, MapReport) {
        let RawMap {
            width,
            height,
            mut pixels,
            warnings,
        } = raw;
        let mut report = MapReport {
            warnings,
            lowest: f32::INFINITY,
            ..MapReport::default()
        };
        let channels = pixels.iter().flat_map(Vec3::to_array);
        let brightest = channels
            .filter(|value| *value <= MAX_RADIANCE)
            .fold(0.0, f32::max);
        for pixel in &mut pixels {
            let mut seen = [false; 3];
            for channel in pixel.as_mut() {
                let value = *channel;
                if value.is_finite() {
                    report.lowest = report.lowest.min(value);
                }
                if value.is_nan() {
                    seen[0] = true;
                    *channel = 0.0;
                } else if value < 0.0 {
                    seen[if value.is_infinite() { 1 } else { 2 }] = true;
                    *channel = 0.0;
                } else if value > MAX_RADIANCE {
                    seen[1] = true;
                    *channel = brightest;
                }
            }
            report.nan_pixels += usize::from(seen[0]);
            report.infinite_pixels += usize::from(seen[1]);
            report.negative_pixels += usize::from(seen[2]);
        }
        if !report.lowest.is_finite() {
            report.lowest = 0.0;
        }
        if width != 2 * height {
            report.warnings.push(format!(
                "{width} x {height} is not twice as wide as high: read as latitude-longitude all the same"
            ));
        }
        if pixels.iter().all(|pixel| *pixel == Vec3::ZERO) {
            report.warnings.push("the map is all black".to_owned());
        }
        (
            Self {
                width,
                height,
                pixels,
            },
            report,
        )
    }

    /// A map whose pixels are `radiance` of their centres' directions, cleaned as a file would be.
    pub fn from_fn(width: usize, height: usize, radiance: impl Fn(Vec3) -> Vec3) -> (Self, MapReport) {
        let grid = Self {
            width,
            height,
            pixels: Vec::new(),
        };
        let pixel = |index: usize| radiance(grid.direction(index % width, index / width).as_vec3());
        let pixels = (0..width * height).map(pixel).collect();
        Self::cleaned(RawMap {
            width,
            height,
            pixels,
            warnings: Vec::new(),
        })
    }

    /// The map itself, or one with pixels so divided that it has at least `width` x `height` of them: sums over the pixels of a
    /// tiny map then still are integrals over the sphere.
    pub(super) fn at_least(&self, width: usize, height: usize) -> Cow<'_, Self> {
        let (across, down) = (width.div_ceil(self.width), height.div_ceil(self.height));
        if across <= 1 && down <= 1 {
            return Cow::Borrowed(self);
        }
        let (width, height) = (self.width * across, self.height * down);
        let pixel = |index: usize| self.pixels[index / width / down * self.width + index % width / across];
        Cow::Owned(Self {
            width,
            height,
            pixels: (0..width * height).map(pixel).collect(),
        })
    }

    /// The map itself, or one of at most `widest` columns whose pixels are means over as many whole ones each, so that its energy is
    /// the same; a map that no whole factor divides stays as it is. None where `progress` cancels.
    pub(super) fn averaged(&self, widest: usize, progress: Progress) -> Option<Cow<'_, Self>> {
        let divides = |factor: &usize| {
            self.width.is_multiple_of(*factor)
                && self.height.is_multiple_of(*factor)
                && self.width / factor <= widest
        };
        let Some(factor) = (1..=self.height).find(divides).filter(|factor| *factor > 1) else {
            return Some(Cow::Borrowed(self));
        };
        let mut map = Self {
            width: self.width / factor,
            height: self.height / factor,
            pixels: Vec::with_capacity(self.pixels.len() / (factor * factor)),
        };
        for rows in bands(map.height, self.width * factor) {
            progress(rows.start as f64 / map.height as f64).continue_value()?;
            let mean = |(x, y): (usize, usize)| {
                let row = |row: usize| {
                    let pixels = &self.pixels[row * self.width + x * factor..][..factor];
                    pixels.iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>() * self.pixel_solid_angle(row)
                };
                let energy: DVec3 = (y * factor..(y + 1) * factor).map(row).sum();
                (energy / map.pixel_solid_angle(y)).as_vec3()
            };
            let places: Vec<(usize, usize)> =
                rows.flat_map(|y| (0..map.width).map(move |x| (x, y))).collect();
            let pixels: Vec<Vec3> = places.into_par_iter().map(mean).collect();
            map.pixels.extend(pixels);
        }
        Some(Cow::Owned(map))
    }

    /// Radiance at the pixel centres of some rows, row after row.
    pub(super) fn grid_rows(&self, rows: Range<usize>, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> Vec<Vec3> {
        let row = |y: usize| -> Vec<Vec3> {
            (0..self.width)
                .map(|x| radiance(self.direction(x, y).as_vec3()))
                .collect()
        };
        rows.into_par_iter().flat_map_iter(row).collect()
    }

    /// Unit direction of the centre of the pixel in column `x` and row `y`.
    pub fn direction(&self, x: usize, y: usize) -> DVec3 {
        let (sin_phi, cos_phi) = (2.0 * PI * (x as f64 + 0.5) / self.width as f64).sin_cos();
        let (sin_theta, cos_theta) = (PI * (y as f64 + 0.5) / self.height as f64).sin_cos();
        DVec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta)
    }

    /// Solid angle of every pixel in row `y`, steradians; over the map they sum to 4 pi.
    pub fn pixel_solid_angle(&self, y: usize) -> f64 {
        let edge = |row: usize| (PI * row as f64 / self.height as f64).cos();
        (edge(y) - edge(y + 1)) * 2.0 * PI / self.width as f64
    }

    /// Integral of the radiance over the sphere, linear Rec.709.
    pub fn energy(&self) -> DVec3 {
        let row = |(y, row): (usize, &[Vec3])| {
            row.iter().map(|pixel| pixel.as_dvec3()).sum::<DVec3>() * self.pixel_solid_angle(y)
        };
        // Rows are added one after the other, so that the sum does not depend on the number of threads.
        let rows: Vec<DVec3> = self.pixels.par_chunks(self.width).enumerate().map(row).collect();
        rows.into_iter().sum()
    }
}
