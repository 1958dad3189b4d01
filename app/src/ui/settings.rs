//! What a person set up and wants to find again: look, keys, recent files. It lives in the user's folder, not in projects.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use crate::{
    Problem,
    document::{files, json},
    paint::Extra,
};

/// Files that are remembered.
const MAX_RECENT: usize = 10;
/// Largest settings file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// How the mouse looks around, and the keys that belong to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Navigation {
    /// Alt with left, middle and right button.
    #[default]
    Maya,
    /// Middle button, Shift+middle, wheel.
    Blender,
}

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Look {
    /// Light text on dark grey: colours of the hair are judged best.
    #[default]
    Dark,
    /// Dark text on light grey.
    Light,
    /// As the system has it.
    System,
}

/// What the file holds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Light or dark.
    pub look: Look,
    /// Mouse and keys.
    pub navigation: Navigation,
    /// Keys of commands that differ from the preset's, as `"save": ["Ctrl+S"]`.
    pub keys: BTreeMap<String, Vec<String>>,
    /// Files that were opened or saved, newest first.
    pub recent: Vec<PathBuf>,
    /// The first-run hints were read.
    pub hints_read: bool,
    /// Unknown fields.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Preferences and where they are kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// None: for this session only.
    file: Option<PathBuf>,
    values: Preferences,
}

impl Settings {
    /// Preferences for one session, the hints read.
    pub fn of_session() -> Self {
        Self {
            file: None,
            values: Preferences {
                hints_read: true,
                ..Preferences::default()
            },
        }
    }

    /// The settings in `settings.json` of a folder, the user's own for instance ([`crate::document::UserState::folder`]).
    ///
    /// # Errors
    /// As [`Settings::read`].
    pub fn in_folder(folder: &Path) -> Result<Self, Problem> {
        Self::read(&folder.join("settings.json"))
    }

    /// The settings in `file`; a missing one is a first start.
    ///
    /// # Errors
    /// A file that cannot be read; it is left as it is.
    pub fn read(file: &Path) -> Result<Self, Problem> {
        let values = if file.exists() {
            let text = files::read_text(file, MAX_BYTES)?;
            serde_json::from_str(&text).map_err(|e| Problem::json(&e).in_file(file))?
        } else {
            Preferences::default()
        };
        Ok(Self {
            file: Some(file.to_owned()),
            values,
        })
    }

    /// What is set.
    pub fn values(&self) -> &Preferences {
        &self.values
    }

    /// Changes what is set and keeps it.
    ///
    /// # Errors
    /// A file that cannot be written; the change holds for this session.
    pub fn change(&mut self, change: impl FnOnce(&mut Preferences)) -> Result<(), Problem> {
        let before = self.values.clone();
        change(&mut self.values);
        let Some(file) = self.file.as_ref().filter(|_| self.values != before) else {
            return Ok(());
        };
        if let Some(folder) = file.parent() {
            std::fs::create_dir_all(folder).map_err(|e| Problem::io(folder, "making the folder", &e))?;
        }
        let text = json::to_text(&self.values).map_err(|e| Problem::json(&e).in_file(file))?;
        files::write_atomic(file, text.as_bytes())
    }

    /// Remembers a file that was opened or saved.
    ///
    /// # Errors
    /// As [`Settings::change`].
    pub fn remember(&mut self, file: &Path) -> Result<(), Problem> {
        let file = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
        self.change(|values| {
            values.recent.retain(|other| *other != file);
            values.recent.insert(0, file);
            values.recent.truncate(MAX_RECENT);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_kept_and_damage_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("deep/settings.json");
        let mut settings = Settings::read(&file).unwrap();
        assert_eq!(*settings.values(), Preferences::default());
        settings.change(|values| values.look = Look::System).unwrap();
        for i in 0..12 {
            settings
                .remember(&folder.path().join(format!("{i}.json")))
                .unwrap();
        }
        settings.remember(&folder.path().join("5.json")).unwrap();
        let again = Settings::read(&file).unwrap();
        assert_eq!(again, settings);
        assert_eq!(again.values().recent.len(), MAX_RECENT);
        assert_eq!(again.values().recent[0], folder.path().join("5.json"));

        std::fs::write(&file, "{\"look\": 3}").unwrap();
        let problem = Settings::read(&file).unwrap_err();
        assert!(problem.to_string().contains("settings.json"), "{problem}");
        let newer = "{\"look\": \"light\", \"later\": [1]}";
        std::fs::write(&file, newer).unwrap();
        let mut settings = Settings::read(&file).unwrap();
        settings.change(|values| values.hints_read = true).unwrap();
        assert!(std::fs::read_to_string(&file).unwrap().contains("later"));
    }
}
