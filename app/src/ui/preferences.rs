//! The editor's side of the settings: kept when they change, followed at once.

use std::path::Path;

use egui::ThemePreference;

use super::{
    Editor,
    settings::{Look, Navigation, Preferences, Settings},
};

impl Editor {
    /// Takes other settings, the user's own for instance.
    pub fn use_settings(&mut self, settings: Settings) {
        self.settings = settings;
        self.follow_settings();
    }

    /// Takes the settings in the folder of the user's state; where they cannot be read, this session goes without.
    pub fn use_settings_of_user(&mut self) {
        match Settings::in_folder(self.state.folder()) {
            Ok(settings) => self.use_settings(settings),
            Err(problem) => self.complain(&problem),
        }
    }

    /// What is set.
    pub fn settings_values(&self) -> &Preferences {
        self.settings.values()
    }

    /// Changes a setting and follows it.
    pub(super) fn set_preference(&mut self, change: impl FnOnce(&mut Preferences)) {
        if let Err(problem) = self.settings.change(change) {
            self.complain(&problem);
        }
        self.follow_settings();
    }

    /// Remembers a file that was opened or saved.
    pub(super) fn remember(&mut self, file: &Path) {
        if let Err(problem) = self.settings.remember(file) {
            self.complain(&problem);
        }
    }

    pub(super) fn follow_settings(&mut self) {
        self.context.set_theme(match self.settings.values().look {
            Look::Dark => ThemePreference::Dark,
            Look::Light => ThemePreference::Light,
            Look::System => ThemePreference::System,
        });
        self.refresh_keys();
    }

    /// The mouse looks around as in Blender.
    pub(super) fn navigates_as_blender(&self) -> bool {
        self.settings.values().navigation == Navigation::Blender
    }
}
