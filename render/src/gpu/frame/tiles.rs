//! Pictures larger than what the adapter holds at once, part by part.

use super::{FrameReport, RenderSettings, Renderer};
use crate::gpu::{Camera, Crop, GpuError};

/// Bytes of a pixel in the largest buffer of a picture.
const PIXEL_BYTES: u64 = 16;

/// Texels of the head's target per pixel's side.
const HEAD_SIDE: u32 = 2;

/// A part of a picture that has just been drawn and is what the renderer's pictures show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Left and upper edge in the whole picture, pixels.
    pub origin: [u32; 2],
    /// Width and height, pixels.
    pub size: [u32; 2],
}

impl Renderer {
    /// Draws a picture of `size` pixels in as few tiles as the adapter allows, of at most `most_side` pixels a side where that is given, and
    /// calls `drawn` after each. Vertices that several tiles show are shaded once. A picture that fits is one tile.
    ///
    /// # Errors
    /// What [`Self::render`] and `drawn` fail with.
    pub fn render_tiles<E: From<GpuError>>(
        &mut self,
        camera: &Camera,
        size: [u32; 2],
        settings: &RenderSettings,
        most_side: Option<u32>,
        mut drawn: impl FnMut(&Self, Tile) -> Result<(), E>,
    ) -> Result<FrameReport, E> {
        let mut report = FrameReport::default();
        let tile = self.largest_tile(size, most_side);
        for top in (0..size[1]).step_by(tile[1] as usize) {
            for left in (0..size[0]).step_by(tile[0] as usize) {
                let part = Tile {
                    origin: [left, top],
                    size: [tile[0].min(size[0] - left), tile[1].min(size[1] - top)],
                };
                let camera = Camera {
                    crop: (part.size != size).then_some(Crop {
                        whole: size,
                        origin: part.origin,
                    }),
                    ..*camera
                };
                report.add(&self.render(&camera, part.size, settings)?);
                drawn(self, part)?;
            }
        }
        Ok(report)
    }

    /// Width and height of the tiles of a picture: halves of it, of quarters and so on, until one fits.
    fn largest_tile(&self, size: [u32; 2], most_side: Option<u32>) -> [u32; 2] {
        let limits = self.gpu.device.limits();
        let bytes = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        let side = (limits.max_texture_dimension_2d / HEAD_SIDE).min(most_side.unwrap_or(u32::MAX));
        let mut tile = size.map(|n| n.max(1));
        while PIXEL_BYTES * u64::from(tile[0]) * u64::from(tile[1]) > bytes || tile[0].max(tile[1]) > side {
            let longer = usize::from(tile[1] > tile[0]);
            if tile[longer] == 1 {
                break;
            }
            tile[longer] = tile[longer].div_ceil(2);
        }
        tile
    }
}

impl FrameReport {
    /// Times and work of another frame as well.
    fn add(&mut self, other: &Self) {
        for (pass, ms) in &other.passes {
            self.add_time(pass, *ms);
        }
        for (counter, n) in &other.counters {
            self.count(counter, *n);
        }
    }
}
