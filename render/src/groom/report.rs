//! What reading and cleaning found.

use std::fmt;

use serde::Serialize;

/// Where metres per unit came from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum UnitSource {
    /// The caller stated it.
    Given,
    /// The file states it.
    File,
    /// The strands are as large as a head in this unit.
    Guessed,
    /// Nothing fits a head; metres were assumed.
    #[default]
    Assumed,
}

/// Counts of what was kept, dropped and repaired on the way to a sound groom.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GroomReport {
    /// Strands kept.
    pub strands: usize,
    /// Points kept.
    pub points: usize,
    /// Strands dropped because fewer than two distinct points were left.
    pub dropped_strands: usize,
    /// Points dropped because a coordinate is NaN or infinite.
    pub non_finite_points: usize,
    /// Points dropped because a coordinate is beyond [`super::MAX_COORDINATE`].
    pub absurd_points: usize,
    /// Points dropped because they repeat the point before them.
    pub duplicate_points: usize,
    /// Diameters replaced by the default: NaN, infinite, not positive, or out of range.
    pub repaired_diameters: usize,
    /// Metres per file unit.
    pub metres_per_unit: f32,
    /// Where `metres_per_unit` came from.
    pub unit_source: UnitSource,
    /// Remarks on parts of the file that are not used.
    pub notes: Vec<String>,
}

impl GroomReport {
    /// Number of strands, points and diameters dropped or repaired.
    pub fn repairs(&self) -> usize {
        self.dropped_strands
            + self.non_finite_points
            + self.absurd_points
            + self.duplicate_points
            + self.repaired_diameters
    }
}

impl fmt::Display for GroomReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let source = match self.unit_source {
            UnitSource::Given => "as given",
            UnitSource::File => "stated by the file",
            UnitSource::Guessed => "guessed from the size",
            UnitSource::Assumed => "assumed: no usual unit makes this the size of a head",
        };
        let (strands, points) = (self.strands, self.points);
        write!(
            f,
            "{strands} strands, {points} points, {} m per unit ({source})",
            self.metres_per_unit
        )?;
        // Name only what happened.
        for (count, what) in [
            (
                self.dropped_strands,
                "strands without two distinct points dropped",
            ),
            (self.non_finite_points, "NaN or infinite points dropped"),
            (self.absurd_points, "points absurdly far away dropped"),
            (self.duplicate_points, "repeated points dropped"),
            (self.repaired_diameters, "unusable diameters set to the default"),
        ] {
            if count > 0 {
                write!(f, "; {count} {what}")?;
            }
        }
        for note in &self.notes {
            write!(f, "; {note}")?;
        }
        Ok(())
    }
}
