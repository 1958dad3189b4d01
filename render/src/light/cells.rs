//! A map as energy in a few cells of the sphere: what the fit sums over instead of pixels.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::bands::bands;
use super::{EnvironmentMap, luminance};

/// Energy that comes from one cell of a latitude-longitude grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Integral of the radiance over the cell, linear Rec.709.
    pub energy: DVec3,
    /// Integral of the luminance over the cell.
    pub mass: f64,
    /// Mean direction, weighted by luminance; shorter than one by the spread within the cell.
    pub mean: DVec3,
}

/// Sums the pixels of a map into `rows` rows of cells, `2 * rows` at the equator and fewer towards the poles so that all are about
/// square, and leaves out the black ones.
///
/// Energy per channel is kept exactly; the map must have at least `2 * rows` by `rows` pixels. `go_on` is asked before every band of
/// rows and ends the work with an error.
pub(super) fn cells<E>(
    map: &EnvironmentMap,
    rows: usize,
    go_on: impl Fn() -> Result<(), E>,
) -> Result<Vec<Cell>, E> {
    let (sin, cos): (Vec<f64>, Vec<f64>) = (0..map.width)
        .map(|x| (std::f64::consts::TAU * (x as f64 + 0.5) / map.width as f64).sin_cos())
        .unzip();

    // A row of cells takes the pixel rows whose centres lie in it, so that no pixel counts twice.
    let first_row = |row: usize| (row * map.height).div_ceil(rows);
    let cell_row = |row: usize| {
        let around = (std::f64::consts::PI * (row as f64 + 0.5) / rows as f64).sin();
        let columns = (2.0 * rows as f64 * around).ceil() as usize;
        let empty = Cell {
            energy: DVec3::ZERO,
            mass: 0.0,
            mean: DVec3::ZERO,
        };
        let mut cells = vec![empty; columns];
        for y in first_row(row)..first_row(row + 1) {
            let solid_angle = map.pixel_solid_angle(y);
            let (sin_theta, cos_theta) =
                (std::f64::consts::PI * (y as f64 + 0.5) / map.height as f64).sin_cos();
            for (x, pixel) in map.pixels[y * map.width..][..map.width].iter().enumerate() {
                let cell = &mut cells[x * columns / map.width];
                let mass = f64::from(luminance(*pixel)) * solid_angle;
                cell.energy += pixel.as_dvec3() * solid_angle;
                cell.mass += mass;
                cell.mean += DVec3::new(sin[x] * sin_theta, cos_theta, -cos[x] * sin_theta) * mass;
            }
        }
        for cell in &mut cells {
            cell.mean /= cell.mass;
        }
        cells.retain(|cell| cell.mass > 0.0);
        cells
    };
    let mut cells = Vec::new();
    for band in bands(rows, map.width * map.height.div_ceil(rows)) {
        go_on()?;
        let of_band: Vec<Vec<Cell>> = band.into_par_iter().map(cell_row).collect();
        cells.extend(of_band.into_iter().flatten());
    }
    Ok(cells)
}

/// The radiance of a map whose pixels are all alike, within the rounding of RGBE.
pub(super) fn uniform_radiance(map: &EnvironmentMap) -> Option<Vec3> {
    let first = map.pixels[0];
    map.pixels
        .iter()
        .all(|pixel| (*pixel - first).abs().max_element() <= 1e-6 * first.max_element())
        .then_some(first)
}
