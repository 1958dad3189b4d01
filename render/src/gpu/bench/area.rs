//! True coverage of a picture's pixels: areas of clipped polygons in f64, independent of any rasterizer.

use glam::{DMat4, DVec2, DVec3, Mat4};
use rayon::prelude::*;

use crate::gpu::camera::CameraUniform;
use crate::volume::Strands;

/// Rows that one thread sums up at a time.
const BAND_ROWS: usize = 16;

/// Share of every pixel that `strands` cover: a strand covers the area of its segments, each a strip between its ends' projected widths;
/// strands cover independently of one another, whatever their order.
///
/// Segments that reach before the camera's near plane count nothing.
pub fn true_alpha(camera: &CameraUniform, strands: &Strands<'_>) -> Vec<f32> {
    let strips: Vec<Vec<[DVec2; 4]>> = (0..strands.strand_count())
        .into_par_iter()
        .map(|strand| {
            let strip = |point| strip(camera, strands, point);
            strands.segments(strand).filter_map(strip).collect()
        })
        .collect();
    let (width, height) = (camera.size[0] as usize, camera.size[1] as usize);
    let mut alpha = vec![0.0; width * height];
    alpha
        .par_chunks_mut(BAND_ROWS * width)
        .enumerate()
        .for_each(|(band, alpha)| {
            let first_row = band * BAND_ROWS;
            let mut left = vec![1.0; alpha.len()];
            let mut covered = vec![0.0; alpha.len()];
            let mut touched = Vec::new();
            for strand in &strips {
                // A strand's parts in one pixel lie beside one another.
                for strip in strand {
                    let rows = first_row..first_row + alpha.len() / width;
                    add_areas(strip, rows, width, |row, column, area| {
                        let at = (row - first_row) * width + column;
                        if covered[at] == 0.0 {
                            touched.push(at);
                        }
                        covered[at] += area;
                    });
                }
                for at in touched.drain(..) {
                    left[at] *= 1.0 - f64::min(std::mem::take(&mut covered[at]), 1.0);
                }
            }
            for (alpha, left) in alpha.iter_mut().zip(left) {
                *alpha = (1.0 - left) as f32;
            }
        });
    alpha
}

/// Corners of the segment that begins at `point`, pixels: its outlines, half a diameter beside the axis across the plane through the eye.
fn strip(camera: &CameraUniform, strands: &Strands<'_>, point: usize) -> Option<[DVec2; 4]> {
    let view_from_world: DMat4 = Mat4::from_cols_array_2d(&camera.view_from_world).as_dmat4();
    let [a, b] =
        [point, point + 1].map(|p| view_from_world.transform_point3(strands.positions[p].as_dvec3()));
    if -a.z < f64::from(camera.near) || -b.z < f64::from(camera.near) {
        return None;
    }
    let focal = f64::from(camera.focal_px);
    let centre = DVec2::from(camera.centre_px.map(f64::from));
    let pixel = |p: DVec3| centre + DVec2::new(p.x, -p.y) * (focal / -p.z);
    let across = a.cross(b).try_normalize()?;
    let half = |point: usize| 0.5 * f64::from(strands.diameters[point] * camera.width_factor) * across;
    let (half_a, half_b) = (half(point), half(point + 1));
    Some([a - half_a, b - half_b, b + half_b, a + half_a].map(pixel))
}

/// Tells `add` of each pixel in `rows` that the polygon covers and how much of it.
fn add_areas(
    polygon: &[DVec2],
    rows: std::ops::Range<usize>,
    width: usize,
    mut add: impl FnMut(usize, usize, f64),
) {
    let range = |corners: &[DVec2], axis: usize, least: usize, end: usize| {
        let values = corners.iter().map(|p| p[axis]);
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        // Negative numbers become 0.
        (low.floor() as usize).max(least)..(high.ceil().max(0.0) as usize).min(end)
    };
    for row in range(polygon, 1, rows.start, rows.end) {
        let of_row = clipped(polygon, 1, row as f64);
        for column in range(&of_row, 0, 0, width) {
            let area = area(&clipped(&of_row, 0, column as f64));
            if area > 0.0 {
                add(row, column, area);
            }
        }
    }
}

/// The part of a convex polygon between `low` and `low + 1` along an axis (Sutherland and Hodgman 1974).
fn clipped(polygon: &[DVec2], axis: usize, low: f64) -> Vec<DVec2> {
    [(1.0, low), (-1.0, -(low + 1.0))]
        .iter()
        .fold(polygon.to_vec(), |corners, &(sign, bound)| {
            let inside = |p: DVec2| sign * p[axis] - bound;
            let mut kept = Vec::with_capacity(corners.len() + 1);
            for (k, &corner) in corners.iter().enumerate() {
                let next = corners[(k + 1) % corners.len()];
                let (here, there) = (inside(corner), inside(next));
                if here >= 0.0 {
                    kept.push(corner);
                }
                if (here >= 0.0) != (there >= 0.0) {
                    kept.push(corner.lerp(next, here / (here - there)));
                }
            }
            kept
        })
}

/// Area of a polygon, whichever way round it runs.
fn area(corners: &[DVec2]) -> f64 {
    let Some(&origin) = corners.first() else {
        return 0.0;
    };
    let doubled: f64 = corners
        .windows(2)
        .map(|pair| (pair[0] - origin).perp_dot(pair[1] - origin))
        .sum();
    0.5 * doubled.abs()
}
