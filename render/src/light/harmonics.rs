//! Spherical harmonics of a map: what lights are compared with (Ramamoorthi and Hanrahan 2001; real basis as in Sloan 2008).

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::EnvironmentMap;

/// Coefficients of the real, orthonormal basis up to an order, rgb.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    order: usize,
    /// Index l (l + 1) + m.
    coefficients: Vec<DVec3>,
}

impl Harmonics {
    /// Integrates basis times radiance over the pixels: (order + 1)^2 coefficients.
    pub fn of(map: &EnvironmentMap, order: usize) -> Self {
        let count = (order + 1) * (order + 1);
        let row = |y: usize| {
            let mut sums = vec![DVec3::ZERO; count];
            let solid_angle = map.pixel_solid_angle(y);
            for (x, pixel) in map.pixels[y * map.width..][..map.width].iter().enumerate() {
                let energy = pixel.as_dvec3() * solid_angle;
                for (sum, value) in sums.iter_mut().zip(basis(map.direction(x, y), order)) {
                    *sum += energy * value;
                }
            }
            sums
        };
        let rows: Vec<Vec<DVec3>> = (0..map.height).into_par_iter().map(row).collect();
        let coefficients = (0..count)
            .map(|index| rows.iter().map(|row| row[index]).sum())
            .collect();
        Self { order, coefficients }
    }

    /// The reconstruction in the unit direction `w`; below zero where it rings.
    pub fn radiance(&self, w: Vec3) -> Vec3 {
        let terms = self
            .coefficients
            .iter()
            .zip(basis(w.as_dvec3().normalize(), self.order));
        terms.map(|(c, value)| *c * value).sum::<DVec3>().as_vec3()
    }

    /// Integral over the sphere, rgb.
    pub fn energy(&self) -> DVec3 {
        self.coefficients[0] * (4.0 * PI).sqrt()
    }
}

/// The real basis at a unit direction, polar axis y.
fn basis(w: DVec3, order: usize) -> Vec<f64> {
    let mut values = vec![0.0; (order + 1) * (order + 1)];
    // Powers of (z + i x) carry both the azimuth and the sine that the Legendre functions below leave out.
    let (mut cos, mut sin) = (1.0, 0.0);
    // P_m^m over its sine, orthonormal.
    let mut diagonal = (1.0 / (4.0 * PI)).sqrt();
    for m in 0..=order {
        let (mut before, mut here) = (0.0, diagonal);
        let mut ratio_before = 0.0;
        for l in m..=order {
            let centre = l * (l + 1);
            if m == 0 {
                values[centre] = here;
            } else {
                values[centre + m] = 2.0_f64.sqrt() * here * cos;
                values[centre - m] = 2.0_f64.sqrt() * here * sin;
            }
            // Recurrence in l of the normalised functions.
            let (next, m) = ((l + 1) as f64, m as f64);
            let ratio = ((4.0 * next * next - 1.0) / (next * next - m * m)).sqrt();
            let following = ratio
                * (w.y * here
                    - if ratio_before > 0.0 {
                        before / ratio_before
                    } else {
                        0.0
                    });
            (before, here, ratio_before) = (here, following, ratio);
        }
        diagonal *= ((2 * m + 3) as f64 / (2 * m + 2) as f64).sqrt();
        (cos, sin) = (cos * w.z - sin * w.x, sin * w.z + cos * w.x);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basis_is_orthonormal() {
        let grid = EnvironmentMap {
            width: 64,
            height: 32,
            pixels: vec![Vec3::ONE; 64 * 32],
        };
        let order = 7;
        let count = (order + 1) * (order + 1);
        let mut products = vec![0.0; count * count];
        for y in 0..grid.height {
            for x in 0..grid.width {
                let values = basis(grid.direction(x, y), order);
                for (i, a) in values.iter().enumerate() {
                    for (j, b) in values.iter().enumerate() {
                        products[i * count + j] += a * b * grid.pixel_solid_angle(y);
                    }
                }
            }
        }
        for (index, product) in products.iter().enumerate() {
            let wanted = f64::from(u8::from(index / count == index % count));
            assert!((product - wanted).abs() < 0.02, "{index}: {product}");
        }
    }
}
