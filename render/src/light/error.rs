//! What is said when a light file or a map is refused.

use std::path::{Path, PathBuf};

/// A file that was refused: which, where in it, why, and what to do about it.
#[derive(Debug, thiserror::Error, PartialEq, Eq, Clone)]
#[error("{}: {place}: {reason}; {remedy}", file.display())]
pub struct InputError {
    /// The file, or the name that the caller gave to the bytes.
    pub file: PathBuf,
    /// The place in the file: a byte offset, a line, a light and its field.
    pub place: String,
    /// What is wrong there.
    pub reason: String,
    /// What the reader of the message can do.
    pub remedy: String,
}

/// An [`InputError`] before the reader's caller has added the file.
#[derive(Debug)]
pub(super) struct Refusal {
    pub place: String,
    pub reason: String,
    pub remedy: String,
}

impl Refusal {
    /// A refusal with its place, reason and remedy.
    pub fn new(place: impl Into<String>, reason: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self {
            place: place.into(),
            reason: reason.into(),
            remedy: remedy.into(),
        }
    }

    /// The refusal of `file`.
    pub fn of(self, file: &Path) -> InputError {
        InputError {
            file: file.to_path_buf(),
            place: self.place,
            reason: self.reason,
            remedy: self.remedy,
        }
    }
}
