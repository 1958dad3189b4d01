//! What a person is told when an input is refused.

use std::ops::RangeInclusive;
use std::path::Path;

/// An input that was refused: where, why, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{}{reason}; {remedy}", prefix(.file), prefix(.place))]
pub struct Problem {
    /// The file, empty where the input is no file.
    pub file: String,
    /// The place in it: a line, a field, a byte offset; empty where the whole input is meant.
    pub place: String,
    /// What is wrong.
    pub reason: String,
    /// What to do.
    pub remedy: String,
}

/// Refuses a number outside `range`, NaN and infinities included.
pub(crate) fn within(place: &str, x: f32, range: RangeInclusive<f32>) -> Result<(), Problem> {
    if range.contains(&x) {
        return Ok(());
    }
    let (low, high) = range.into_inner();
    Err(Problem::at(
        place,
        format!("{x} is out of range"),
        format!("give a number from {low} to {high}"),
    ))
}

fn prefix(part: &str) -> String {
    if part.is_empty() {
        String::new()
    } else {
        format!("{part}: ")
    }
}

impl Problem {
    /// A problem at `place` that no file is named for yet.
    pub fn at(place: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            file: String::new(),
            place: place.into(),
            reason: reason.into(),
            remedy: remedy.into(),
        }
    }

    /// The same problem, named as one of `file`.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        Self {
            file: file.display().to_string(),
            ..self
        }
    }

    /// A file that could not be read or written.
    pub fn io(file: &Path, doing: &str, error: &std::io::Error) -> Self {
        let remedy = match error.kind() {
            std::io::ErrorKind::NotFound => "check the path",
            std::io::ErrorKind::PermissionDenied => "change its permissions or choose another place",
            std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
                "free some space or choose another disk"
            }
            std::io::ErrorKind::ReadOnlyFilesystem => "choose a place that can be written",
            std::io::ErrorKind::StaleNetworkFileHandle
            | std::io::ErrorKind::HostUnreachable
            | std::io::ErrorKind::NetworkUnreachable
            | std::io::ErrorKind::NetworkDown
            | std::io::ErrorKind::TimedOut => "reconnect the network folder or choose another place",
            _ => "check the disk and try again",
        };
        Self::at("", format!("{doing} failed: {error}"), remedy).in_file(file)
    }

    /// A JSON text that does not parse: the place is its line and column.
    pub fn json(error: &serde_json::Error) -> Self {
        let place = format!("line {}, column {}", error.line(), error.column());
        let text = error.to_string();
        let reason = text.split(" at line ").next().unwrap_or(&text).to_owned();
        Self::at(place, reason, "correct the JSON there")
    }
}
