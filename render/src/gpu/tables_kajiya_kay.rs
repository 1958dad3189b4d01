//! The diffuse term of Kajiya and Kay under an SRBF light as a table over sin(theta_j) and lambda_j^2 / 2 (Ren 2010, section 3), from the
//! float64 reference. `shaders/lib/kajiya_kay_table.wgsl` reads it.
//!
//! What is stored is the term over the light's solid angle and over sqrt((cos^2 theta_j + 2 s) / (1 + 2 s)), s = lambda_j^2 / 2, a factor
//! with the limits of the term, so that a small table is enough. Axes: sqrt(1 - |sin theta_j|), which spreads the pole out, and
//! sqrt(2 s) / (1 + sqrt(2 s)), which reaches from narrow lights to the uniform environment.

use std::f64::consts::PI;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::tables::KAJIYA_KAY_STEPS;
use crate::optics::kajiya_kay::diffuse;
use crate::optics::{Direction, SrbfLight};

/// Relative tolerance of the entries, well below what interpolation between them loses.
const TOLERANCE: f64 = 1e-5;

/// Cells in the order of the light's width, then of the distance from the pole: the corner, its differences along the distance and along
/// the width, and what is left at the far corner. Computed once a process.
pub(super) fn cells() -> &'static [[f32; 4]] {
    static CELLS: LazyLock<Vec<[f32; 4]>> = LazyLock::new(|| {
        let points = KAJIYA_KAY_STEPS + 1;
        let values: Vec<f64> = (0..points * points)
            .into_par_iter()
            .map(|i| ratio(place(i % points), place(i / points)))
            .collect();
        let at = |row: usize, column: usize| values[row * points + column];
        let cell = |row: usize, column: usize| {
            let corner = at(row, column);
            let (along, across) = (at(row, column + 1) - corner, at(row + 1, column) - corner);
            [
                corner,
                along,
                across,
                at(row + 1, column + 1) - corner - along - across,
            ]
            .map(|v| v as f32)
        };
        (0..KAJIYA_KAY_STEPS)
            .flat_map(|row| (0..KAJIYA_KAY_STEPS).map(move |column| (row, column)))
            .map(|(row, column)| cell(row, column))
            .collect()
    });
    &CELLS
}

fn place(index: usize) -> f64 {
    index as f64 / KAJIYA_KAY_STEPS as f64
}

/// The stored ratio at table coordinates of the distance from the pole and of the width.
fn ratio(from_pole: f64, width: f64) -> f64 {
    let sin_theta_j = 1.0 - from_pole * from_pole;
    let cos_theta_j = (1.0 - sin_theta_j * sin_theta_j).max(0.0).sqrt();
    if width >= 1.0 {
        // The mean cosine over the sphere.
        return 0.25 * PI;
    }
    // The narrowest light that the shaders take stands for all below.
    let lambda = (width / (1.0 - width)).max(1e-3);
    let centre = Direction {
        theta: sin_theta_j.clamp(-1.0, 1.0).asin(),
        phi: 0.0,
    };
    let term = SrbfLight::new(centre, lambda)
        .and_then(|light| diffuse(&light, TOLERANCE))
        .expect("every node of the table is inside the reference's range");
    let two_s = lambda * lambda;
    let solid_angle = -PI * two_s * (-4.0 / two_s).exp_m1();
    term / (solid_angle * ((cos_theta_j * cos_theta_j + two_s) / (1.0 + two_s)).sqrt())
}
