//! A picture that was drawn, whole whatever tiles the adapter wanted, on its way to a file.

use std::path::Path;

use balayage_render::{
    gpu::{Camera, DebugView, FrameReport, RenderSettings, Renderer},
    image::{Metadata, Picture, png_bytes},
};

use super::{CliError, names::Format};

/// A picture with what was noticed about it.
pub(super) struct Drawn {
    size: [u32; 2],
    pixels: Pixels,
    /// Pixels that are not finite.
    pub(super) bad_pixels: u32,
    /// What false colours mean.
    pub(super) legend: Option<String>,
}

enum Pixels {
    /// sRGB bytes, straight alpha.
    Shown(Vec<u8>),
    /// Scene-linear, premultiplied.
    Linear(Picture),
}

impl Drawn {
    /// Draws a picture as its format wants it.
    pub(super) fn picture(
        renderer: &mut Renderer,
        camera: &Camera,
        size: [u32; 2],
        settings: &RenderSettings,
        format: Format,
    ) -> Result<(Self, FrameReport), CliError> {
        let [width, height] = size.map(|side| side as usize);
        let mut pixels = match format {
            Format::Png => Pixels::Shown(vec![0; 4 * width * height]),
            Format::Exr => Pixels::Linear(Picture {
                width,
                height,
                pixels: vec![[0.0; 4]; width * height],
            }),
        };
        let mut bad_pixels = 0;
        let report = renderer.render_tiles::<CliError>(camera, size, settings, None, |renderer, tile| {
            bad_pixels += renderer.non_finite()?;
            let [left, top] = tile.origin.map(|n| n as usize);
            let columns = tile.size[0] as usize;
            match &mut pixels {
                Pixels::Shown(whole) => {
                    let bytes = renderer.shown_bytes()?;
                    for (row, line) in bytes.chunks_exact(4 * columns).enumerate() {
                        whole[4 * ((top + row) * width + left)..][..line.len()].copy_from_slice(line);
                    }
                }
                Pixels::Linear(whole) => {
                    let picture = renderer.picture()?;
                    for (row, line) in picture.pixels.chunks_exact(columns).enumerate() {
                        whole.pixels[(top + row) * width + left..][..line.len()].copy_from_slice(line);
                    }
                }
            }
            Ok(())
        })?;
        let drawn = Self {
            size,
            pixels,
            bad_pixels,
            legend: None,
        };
        Ok((drawn, report))
    }

    /// Draws what a debug view shows.
    pub(super) fn false_colours(
        renderer: &mut Renderer,
        camera: &Camera,
        size: [u32; 2],
        settings: &RenderSettings,
        view: DebugView,
    ) -> Result<(Self, FrameReport), CliError> {
        let report = renderer.render(camera, size, settings)?;
        let bad_pixels = renderer.non_finite()?;
        let colours = renderer.debug_view(camera, size, settings, view)?;
        let drawn = Self {
            size,
            pixels: Pixels::Shown(colours.rgba()),
            bad_pixels,
            legend: Some(colours.legend()),
        };
        Ok((drawn, report))
    }

    /// The file's content.
    pub(super) fn bytes(&self, path: &Path, metadata: &Metadata) -> Result<Vec<u8>, CliError> {
        Ok(match &self.pixels {
            Pixels::Shown(rgba) => png_bytes(path, self.size, rgba, metadata)?,
            Pixels::Linear(picture) => picture.exr_bytes(path, metadata)?,
        })
    }
}
