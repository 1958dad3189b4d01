//! Saving: nothing is overwritten silently, and at any moment a whole project is on the disk.

use std::{fs, io, path::Path};

use super::{
    Document, backups, builtin,
    files::{self, SaveStep},
    journal::Record,
    json, relink,
};
use crate::Problem;

/// How a project is saved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SaveOptions {
    /// Earlier versions that are kept beside it.
    pub backups: u32,
    /// Writes over a file that another program has changed since it was read.
    pub overwrites_changes: bool,
}

/// A save that came to its end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Saved {
    /// What did not work besides, one sentence each.
    pub warnings: Vec<String>,
}

/// The content hash of a file's bytes.
pub(super) fn content_hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

impl Document {
    /// Saves to `path`, which becomes the document's own; the paths in the project follow it. No backup is kept.
    ///
    /// # Errors
    /// As [`Document::save_with`].
    pub fn save_as(&mut self, path: &Path) -> Result<(), Problem> {
        self.save_with(path, SaveOptions::default(), |_| Ok(())).map(drop)
    }

    /// Saves to `path`, which becomes the document's own; the paths in the project follow it. `before` is asked before each step
    /// and may refuse it.
    ///
    /// # Errors
    /// The file was changed by another program, or cannot be written; the old file and the document are as before.
    pub fn save_with(
        &mut self,
        path: &Path,
        options: SaveOptions,
        mut before: impl FnMut(SaveStep) -> io::Result<()>,
    ) -> Result<Saved, Problem> {
        self.commit_stroke();
        if !options.overwrites_changes && self.is_changed_on_disk(path) {
            return Err(Problem::at(
                "",
                "another program has changed the file since it was opened",
                "save under another name, or open the file again",
            )
            .in_file(path));
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut project = self.project.clone();
        project.files = relink::file_hashes(&project, &self.folder);
        project.map_paths(|reference| match builtin::bytes(reference) {
            Some(_) => reference.to_owned(),
            None => files::relative(&self.resolve(reference), &folder),
        });
        let text = json::to_text(&project)
            .map_err(|e| Problem::at("", e.to_string(), "report this as a bug").in_file(path))?;
        let hash = content_hash(text.as_bytes());

        // The journal learns which file it will count from: a crash between the rename and the journal's end loses nothing.
        if self.is_own(path) {
            self.record_raw(Record::Saved(hash.clone()));
        }
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let (mut saved, mut is_renamed) = (Saved::default(), false);
        let written = files::write_atomic_with(path, text.as_bytes(), |step| {
            is_renamed = step == SaveStep::SyncFolder;
            if step == SaveStep::Rename
                && let Err(error) = backups::rotate(&target, options.backups)
            {
                let warning = Problem::io(&target, "keeping a backup of the version before", &error);
                saved.warnings.push(warning.to_string());
            }
            before(step)
        });
        if (written.is_ok() || is_renamed) && self.is_own(path) {
            self.disk_hash = Some(hash.clone());
        }
        written?;
        self.project = project;
        self.folder = folder;
        self.path = Some(path.to_owned());
        self.disk_hash = Some(hash);
        self.saved_state = self.history.state();
        self.is_restored = false;
        if let Err(problem) = self.discard_journal() {
            saved.warnings.push(problem.to_string());
        }
        Ok(saved)
    }

    /// True where the document's own file no longer holds what was read from it or written to it. A file that is gone is no change.
    pub fn is_changed_on_disk(&self, path: &Path) -> bool {
        let Some(hash) = self.disk_hash.as_ref().filter(|_| self.is_own(path)) else {
            return false;
        };
        fs::read(path).is_ok_and(|bytes| content_hash(&bytes) != *hash)
    }

    /// True where `path` is the document's own file, however it is written.
    pub fn is_own(&self, path: &Path) -> bool {
        let Some(own) = self.path.as_deref() else {
            return false;
        };
        own == path || matches!((fs::canonicalize(own), fs::canonicalize(path)), (Ok(a), Ok(b)) if a == b)
    }

    /// Makes the document one that was never saved: its next save asks for a name.
    pub(super) fn detach(&mut self) {
        self.path = None;
        self.disk_hash = None;
        self.lock = None;
    }
}
