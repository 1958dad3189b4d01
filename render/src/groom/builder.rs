//! The only way to a [`Groom`]: strands are cleaned as they are pushed, and what was repaired is counted.

use glam::Vec3;

use super::{DEFAULT_DIAMETER_M, Groom, GroomError, GroomReport, UnitSource};

/// Largest coordinate that counts as a position, in file units: squares of differences stay finite in f32.
pub const MAX_COORDINATE: f32 = 1.0e7;

/// Largest number of points of a groom; index arithmetic of the shaders stays within u32.
pub const MAX_POINTS: usize = 1 << 31;

/// Range of diameters that count as diameters, in file units.
const DIAMETER_RANGE: std::ops::RangeInclusive<f32> = 1.0e-12..=1.0e6;

/// Units that files come in, in metres, the likeliest first.
const USUAL_UNITS_M: [f32; 4] = [1.0, 0.1, 0.01, 0.001];

/// Largest extent of hair on a head, in metres.
const HEAD_SIZE_M: std::ops::RangeInclusive<f32> = 0.1..=1.0;

/// Collects strands and keeps what is sound of them.
#[derive(Debug, Default)]
pub struct GroomBuilder {
    positions: Vec<Vec3>,
    /// NaN stands for "to be replaced by the default diameter".
    diameters: Vec<f32>,
    /// End of every strand kept so far.
    ends: Vec<u32>,
    report: GroomReport,
}

impl GroomBuilder {
    /// An empty builder.
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty builder with room for `strands` of `points` in all; the caller has checked that so many points are really there.
    pub fn with_capacity(strands: usize, points: usize) -> Self {
        // A strand without points is never kept, so that a lying strand count costs nothing.
        let strands = strands.min(points / 2);
        Self {
            positions: Vec::with_capacity(points),
            diameters: Vec::with_capacity(points),
            ends: Vec::with_capacity(strands + 1),
            report: GroomReport::default(),
        }
    }

    /// Adds a remark for the report.
    pub fn note(&mut self, note: impl Into<String>) {
        self.report.notes.push(note.into());
    }

    /// Adds one strand, root first: points and fibre diameters in file units, `None` where the file states no diameter.
    ///
    /// Points that are not finite, absurdly far away or equal to the point before them are dropped; a strand of which fewer than two
    /// points are left is dropped as a whole.
    pub fn push_strand(&mut self, points: impl IntoIterator<Item = (Vec3, Option<f32>)>) {
        self.push(points, |_| {});
    }

    /// [`GroomBuilder::push_strand`] that puts the indices of the points that were kept in `kept`, in place of what was there.
    pub(super) fn push_strand_noting(
        &mut self,
        points: impl IntoIterator<Item = (Vec3, Option<f32>)>,
        kept: &mut Vec<usize>,
    ) {
        kept.clear();
        if !self.push(points, |index| kept.push(index)) {
            kept.clear();
        }
    }

    /// Adds a strand, tells `keep` the index of every point that is kept, and returns whether the strand is.
    fn push(
        &mut self,
        points: impl IntoIterator<Item = (Vec3, Option<f32>)>,
        mut keep: impl FnMut(usize),
    ) -> bool {
        let start = self.positions.len();
        for (index, (position, diameter)) in points.into_iter().enumerate() {
            if !position.is_finite() {
                self.report.non_finite_points += 1;
            } else if position.abs().max_element() > MAX_COORDINATE {
                self.report.absurd_points += 1;
            } else if self.positions[start..]
                .last()
                .is_some_and(|&p| !is_segment(p, position))
            {
                self.report.duplicate_points += 1;
            } else {
                let sound = diameter.filter(|d| DIAMETER_RANGE.contains(d));
                self.report.repaired_diameters += usize::from(diameter.is_some() && sound.is_none());
                self.positions.push(position);
                self.diameters.push(sound.unwrap_or(f32::NAN));
                keep(index);
            }
        }

        // A strand needs a direction; a groom that is full drops the rest, which `finish` turns into an error.
        let end = self.positions.len();
        let sound = end - start >= 2;
        if sound {
            self.ends.push(u32::try_from(end).unwrap_or(u32::MAX));
        } else {
            self.positions.truncate(start);
            self.diameters.truncate(start);
            self.report.dropped_strands += 1;
        }
        sound
    }

    /// The sound groom and what was repaired.
    ///
    /// `unit` is metres per unit with its source; without it the unit is guessed from the size of the bounding box.
    ///
    /// # Errors
    /// When no strand is left, when there are more than [`MAX_POINTS`] points, or when the given unit is not a positive number.
    pub fn finish(
        self,
        name: &str,
        unit: Option<(f32, UnitSource)>,
    ) -> Result<(Groom, GroomReport), GroomError> {
        let Self {
            positions,
            mut diameters,
            ends,
            mut report,
        } = self;
        if ends.is_empty() {
            return Err(GroomError::refused(
                name,
                format!(
                    "no usable strand: {} without two distinct points",
                    report.dropped_strands
                ),
                "check that the hair was exported with its points",
            ));
        }
        if positions.len() > MAX_POINTS {
            return Err(GroomError::refused(
                name,
                format!("{} points, more than {MAX_POINTS}", positions.len()),
                "export fewer strands",
            ));
        }

        // The unit decides the default diameter.
        let (metres_per_unit, unit_source) = unit.unwrap_or_else(|| guess_unit(&positions));
        if !(metres_per_unit.is_normal() && metres_per_unit > 0.0) {
            return Err(GroomError::refused(
                name,
                format!("{metres_per_unit} metres per unit"),
                "state a positive number, such as 0.01 for centimetres",
            ));
        }
        let default =
            (DEFAULT_DIAMETER_M / metres_per_unit).clamp(*DIAMETER_RANGE.start(), *DIAMETER_RANGE.end());
        for diameter in diameters.iter_mut().filter(|d| d.is_nan()) {
            *diameter = default;
        }

        let first_point: Vec<u32> = std::iter::once(0).chain(ends).collect();
        report.strands = first_point.len() - 1;
        report.points = positions.len();
        report.metres_per_unit = metres_per_unit;
        report.unit_source = unit_source;
        Ok((
            Groom {
                positions,
                diameters,
                first_point,
                metres_per_unit,
            },
            report,
        ))
    }
}

/// Whether two points are so far apart that the direction between them means something in f32.
fn is_segment(from: Vec3, to: Vec3) -> bool {
    let resolution = 4.0 * f32::EPSILON * from.abs().max(to.abs()).max_element();
    from.distance(to) > resolution.max(1.0e-12)
}

/// The unit that makes the strands the size of a head, else metres.
fn guess_unit(positions: &[Vec3]) -> (f32, UnitSource) {
    let (min, max) = bounds(positions);
    let extent = (max - min).max_element();
    USUAL_UNITS_M
        .into_iter()
        .find(|unit| HEAD_SIZE_M.contains(&(extent * unit)))
        .map_or((1.0, UnitSource::Assumed), |unit| (unit, UnitSource::Guessed))
}

/// Smallest and largest coordinates.
pub(super) fn bounds(positions: &[Vec3]) -> (Vec3, Vec3) {
    positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), &p| {
            (min.min(p), max.max(p))
        })
}
