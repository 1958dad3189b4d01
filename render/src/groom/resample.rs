//! Grooms with the same number of points on every strand, as `.tfx` wants them.

use super::spline::NaturalSpline;
use super::{Groom, GroomBuilder, GroomError, GroomReport, UnitSource};

impl Groom {
    /// The same curves with `points_per_strand` points each, evenly spaced in the parameter of the natural cubic spline; diameters are
    /// linear in it. Both ends of every strand keep their bits; a strand that has the wanted number of points is copied.
    ///
    /// # Errors
    /// When `points_per_strand` is less than 2, or when the points fall so close together that no strand is left.
    pub fn resampled(&self, points_per_strand: usize) -> Result<(Self, GroomReport), GroomError> {
        if points_per_strand < 2 {
            return Err(GroomError::refused(
                "resampling",
                format!("{points_per_strand} points per strand"),
                "ask for at least 2",
            ));
        }
        let mut builder = GroomBuilder::new();
        for strand in 0..self.strand_count() {
            let (points, diameters) = (
                &self.positions()[self.strand(strand)],
                &self.diameters()[self.strand(strand)],
            );
            let spline = NaturalSpline::new(points);
            let last = points.len() - 1;
            builder.push_strand((0..points_per_strand).map(|i| {
                // The groom's own points are taken as they are.
                let at = (i * last) as f64 / (points_per_strand - 1) as f64;
                let (point, t) = (at as usize, at.fract());
                if t == 0.0 {
                    return (points[point], Some(diameters[point]));
                }
                let diameter = diameters[point] + t as f32 * (diameters[point + 1] - diameters[point]);
                (spline.position(point, t).as_vec3(), Some(diameter))
            }));
        }
        builder.finish("resampling", Some((self.metres_per_unit(), UnitSource::Given)))
    }
}
