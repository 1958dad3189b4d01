//! The editor's window. It reads the document and emits edits; only the document changes itself.

mod actions;
mod adjust;
mod command;
mod compare;
mod dispatch;
mod documents;
mod editing;
mod editor;
mod job;
pub mod keymap;
mod light_ball;
mod light_grab;
mod light_inspector;
mod light_map;
mod light_place;
mod lighting;
mod menus;
mod palette;
mod panel_brush;
mod panel_dye;
mod panel_hair;
mod panel_history;
mod panel_layers;
mod panel_light;
mod panel_mask;
mod panel_operations;
mod panel_statistics;
mod preferences;
mod questions;
mod ring;
mod sequence;
pub mod settings;
mod status;
mod stroke;
mod theme;
mod viewer;
mod viewing;
mod viewport;
mod welcome;
mod widgets;

use std::path::PathBuf;

use balayage_render::groom::ReadOptions;

use crate::document::UserState;

pub use command::Command;
pub use editor::Editor;

/// Opens the window and returns when it is closed; a groom named by `open` is read with `options`.
///
/// # Errors
/// No display, no GPU.
pub fn run(open: Option<PathBuf>, options: ReadOptions) -> Result<(), eframe::Error> {
    let native = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("balayage")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([800.0, 500.0]),
        ..Default::default()
    };
    eframe::run_native(
        "Balayage",
        native,
        Box::new(|creation| {
            let mut editor = Editor::with_state(&creation.egui_ctx, open, options, UserState::of_user());
            editor.use_settings_of_user();
            Ok(Box::new(editor))
        }),
    )
}
