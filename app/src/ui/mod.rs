//! The editor's window. It reads the document and emits edits; only the document changes itself.

mod actions;
mod command;
mod dispatch;
mod editing;
mod editor;
mod job;
mod light_ball;
mod light_inspector;
mod light_map;
mod lighting;
mod menus;
mod panel_brush;
mod panel_dye;
mod panel_hair;
mod panel_history;
mod panel_layers;
mod panel_light;
mod panel_mask;
mod panel_operations;
mod ring;
mod sequence;
mod status;
mod stroke;
mod theme;
mod viewer;
mod viewport;
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
        Box::new(|creation| Ok(Box::new(Editor::new(&creation.egui_ctx, open)))),
    )
}
