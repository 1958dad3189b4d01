//! The editor's window. It reads the document and emits edits; only the document changes itself.

mod actions;
mod command;
mod compare;
mod dispatch;
mod editing;
mod editor;
mod job;
pub mod keymap;
mod light_ball;
mod light_inspector;
mod light_map;
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

pub use command::Command;
pub use editor::Editor;

/// Opens the window and returns when it is closed.
///
/// # Errors
/// No display, no GPU.
pub fn run(open: Option<PathBuf>) -> Result<(), eframe::Error> {
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default()
            .with_app_id("balayage")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([800.0, 500.0]),
        ..Default::default()
    };
    eframe::run_native(
        "Balayage",
        options,
        Box::new(|creation| {
            let mut editor = Editor::new(&creation.egui_ctx, open);
            editor.use_settings_of_user();
            Ok(Box::new(editor))
        }),
    )
}
