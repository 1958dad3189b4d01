//! What can go wrong with strand and mesh files, told with file, place, reason and remedy.

use std::path::PathBuf;

/// A groom or mesh could not be read, built or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GroomError {
    /// The operating system refused the file.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: "open", "read" or "write".
        action: &'static str,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The bytes are not what the format promises.
    #[error("{file}: byte {offset}: {reason}; {remedy}")]
    Format {
        /// The file's name.
        file: String,
        /// Where in the file, in bytes from its start.
        offset: u64,
        /// What is wrong there.
        reason: String,
        /// What the user can do.
        remedy: String,
    },
    /// The strands or settings are readable, but what was asked can not be done with them.
    #[error("{subject}: {reason}; {remedy}")]
    Refused {
        /// The file or the object concerned.
        subject: String,
        /// Why it can not be done.
        reason: String,
        /// What the user can do.
        remedy: String,
    },
}

impl GroomError {
    /// A refusal about `subject`.
    pub(crate) fn refused(
        subject: impl Into<String>,
        reason: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Refused {
            subject: subject.into(),
            reason: reason.into(),
            remedy: remedy.into(),
        }
    }
}
