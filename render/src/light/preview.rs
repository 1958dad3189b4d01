//! A picture to judge a fit by eye.

use glam::Vec3;

use super::{EnvironmentMap, LightSet, luminance};

/// Widest panel of a preview, pixels.
const PANEL_WIDTH: usize = 512;

/// Pixels between two panels.
const GAP: usize = 8;

/// An sRGB-encoded picture of three bytes a pixel, row after row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `3 * width * height` bytes, red, green, blue.
    pub rgb: Vec<u8>,
}

/// Map, reconstruction and difference below each other, all three exposed so that the map's mean luminance is middle grey.
///
/// The difference is grey where both agree, lighter where the lights are too bright and darker where they are too dark. A map wider
/// than 512 pixels is averaged down.
pub fn preview(map: &EnvironmentMap, lights: &LightSet) -> Picture {
    let map = shrunk(map, PANEL_WIDTH);
    let (width, rows) = (map.width, map.height);
    let fitted = map.grid_rows(0..rows, |w| lights.radiance(w));
    let exposure = middle_grey(&map);

    let panels: [Box<dyn Fn(usize) -> Vec3>; 3] = [
        Box::new(|index| tone(map.pixels[index] * exposure)),
        Box::new(|index| tone(fitted[index] * exposure)),
        Box::new(|index| {
            let difference = tone(fitted[index] * exposure) - tone(map.pixels[index] * exposure);
            Vec3::splat(0.5) + 0.5 * difference
        }),
    ];
    let height = 3 * rows + 2 * GAP;
    let mut rgb = vec![0; 3 * width * height];
    for (number, panel) in panels.iter().enumerate() {
        let start = 3 * number * (rows + GAP) * width;
        for (index, bytes) in rgb[start..][..3 * width * rows].chunks_exact_mut(3).enumerate() {
            bytes.copy_from_slice(&panel(index).to_array().map(|value| (value * 255.0).round() as u8));
        }
    }
    Picture { width, height, rgb }
}

/// The map alone, exposed as in [`preview`], averaged down by a whole factor to at most `width` columns.
pub fn panorama(map: &EnvironmentMap, width: usize) -> Picture {
    let map = shrunk(map, width);
    let exposure = middle_grey(&map);
    let bytes = |pixel: &Vec3| {
        tone(*pixel * exposure)
            .to_array()
            .map(|value| (value * 255.0).round() as u8)
    };
    Picture {
        width: map.width,
        height: map.height,
        rgb: map.pixels.iter().flat_map(bytes).collect(),
    }
}

/// The factor that makes the map's mean luminance middle grey.
fn middle_grey(map: &EnvironmentMap) -> f32 {
    let mean = map.energy().as_vec3() / (4.0 * std::f32::consts::PI);
    if luminance(mean) > 0.0 {
        0.18 / luminance(mean)
    } else {
        1.0
    }
}

/// Display value in [0, 1] of exposed radiance: x / (1 + x), which keeps suns and shadows apart, then the sRGB curve.
fn tone(radiance: Vec3) -> Vec3 {
    let encode = |value: f32| {
        let value = value / (1.0 + value);
        if value <= 0.0031308 {
            12.92 * value
        } else {
            1.055 * value.powf(1.0 / 2.4) - 0.055
        }
    };
    radiance.min(Vec3::splat(1e30)).map(encode)
}

/// The map averaged down by a whole factor to at most `widest` columns.
fn shrunk(map: &EnvironmentMap, widest: usize) -> EnvironmentMap {
    let factor = map.width.div_ceil(widest.max(1));
    let (width, height) = (map.width.div_ceil(factor), map.height.div_ceil(factor));
    let mut pixels = vec![Vec3::ZERO; width * height];
    let mut counts = vec![0.0; width * height];
    for (index, pixel) in map.pixels.iter().enumerate() {
        let target = index / map.width / factor * width + index % map.width / factor;
        pixels[target] += *pixel;
        counts[target] += 1.0;
    }
    let pixels = pixels
        .iter()
        .zip(&counts)
        .map(|(sum, count)| *sum / *count)
        .collect();
    EnvironmentMap {
        width,
        height,
        pixels,
    }
}
