//! What Balayage remembers about a person's work on this machine: recent folders, folders that are trusted, how many backups
//! to keep. It lives in the user's folder, as do the editor's settings and the journals of projects that were never saved.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use super::files;
use crate::Problem;

/// Folders that are remembered.
const MAX_FOLDERS: usize = 32;
/// The file is small; anything larger is not ours.
const MAX_BYTES: u64 = 1 << 20;

/// The state folder and what it remembers.
#[derive(Clone, Debug)]
pub struct UserState {
    folder: PathBuf,
    memory: Memory,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Memory {
    /// Backups of each project.
    backups: u32,
    /// Folders of opened files, newest first.
    recent_folders: Vec<PathBuf>,
    /// Folders that projects may name files in.
    trusted_folders: Vec<PathBuf>,
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            backups: 3,
            recent_folders: Vec::new(),
            trusted_folders: Vec::new(),
        }
    }
}

/// Backups of one project above this number are refused.
pub const MAX_BACKUPS: u32 = 50;

impl UserState {
    /// The state in `folder`; one that is missing or unreadable is as new.
    pub fn in_folder(folder: PathBuf) -> Self {
        let text = files::read_text(&folder.join("state.json"), MAX_BYTES);
        let memory = text.ok().and_then(|text| serde_json::from_str(&text).ok());
        Self {
            folder,
            memory: memory.unwrap_or_default(),
        }
    }

    /// The user's own: in `$BALAYAGE_STATE`, else where the system keeps such things.
    pub fn of_user() -> Self {
        let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
        let home = || PathBuf::from(variable("HOME").unwrap_or_else(|| ".".into()));
        let folder = variable("BALAYAGE_STATE").map(PathBuf::from);
        let folder = folder.unwrap_or_else(|| {
            if cfg!(windows) {
                PathBuf::from(variable("LOCALAPPDATA").unwrap_or_else(|| ".".into())).join("Balayage")
            } else if cfg!(target_os = "macos") {
                home().join("Library/Application Support/Balayage")
            } else {
                variable("XDG_STATE_HOME")
                    .map_or_else(|| home().join(".local/state"), PathBuf::from)
                    .join("balayage")
            }
        });
        Self::in_folder(folder)
    }

    /// The folder; it may not exist yet.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Backups that are kept of each project.
    pub fn backups(&self) -> u32 {
        self.memory.backups.min(MAX_BACKUPS)
    }

    /// Keeps that many backups from now on.
    ///
    /// # Errors
    /// The state cannot be written; it holds for this session.
    pub fn set_backups(&mut self, backups: u32) -> Result<(), Problem> {
        self.memory.backups = backups.min(MAX_BACKUPS);
        self.save()
    }

    /// Folders of files that were opened, newest first.
    pub fn recent_folders(&self) -> &[PathBuf] {
        &self.memory.recent_folders
    }

    /// True for files in a folder that the person has allowed, folders in it not included.
    pub fn trusts(&self, file: &Path) -> bool {
        let folder = file.parent();
        folder.is_some_and(|folder| self.memory.trusted_folders.iter().any(|known| known == folder))
    }

    /// Remembers the folders of `used` files, and that projects may name files beside the `trusted` ones.
    ///
    /// # Errors
    /// The state cannot be written; it holds for this session.
    pub fn remember(&mut self, used: &[PathBuf], trusted: &[PathBuf]) -> Result<(), Problem> {
        let before = self.memory.clone();
        for (list, files) in [
            (&mut self.memory.recent_folders, used),
            (&mut self.memory.trusted_folders, trusted),
        ] {
            for file in files {
                let Some(folder) = file.parent().filter(|folder| folder.is_absolute()) else {
                    continue;
                };
                list.retain(|known| known != folder);
                list.insert(0, folder.to_owned());
            }
            list.truncate(MAX_FOLDERS);
        }
        if self.memory == before {
            Ok(())
        } else {
            self.save()
        }
    }

    fn save(&self) -> Result<(), Problem> {
        fs::create_dir_all(&self.folder).map_err(|e| Problem::io(&self.folder, "creating", &e))?;
        let path = self.folder.join("state.json");
        let text = super::json::to_text(&self.memory)
            .map_err(|e| Problem::at("", e.to_string(), "report this as a bug").in_file(&path))?;
        files::write_atomic(&path, text.as_bytes())
    }
}
